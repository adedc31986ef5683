"""PrairieLearn, whole: a course is loaded, published and released, and students answer its assessments over HTTP.

`software` is a checkout with its packages built and in place (pnpm), whose `.venv` holds what its pyproject.toml and
qdot depend on (Python 3.13); Node 24 is on the path. PGHOST, PGPORT, PGUSER and PGPASSWORD name a PostgreSQL with the
extension vector, in which a database is made for the run and dropped; REDIS_URL names a Redis.
"""

import json
import os
import re
import secrets
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from html import unescape
from http.cookiejar import CookieJar
from pathlib import Path
from typing import Any
from urllib.error import HTTPError, URLError
from urllib.parse import urlencode
from urllib.request import HTTPCookieProcessor, OpenerDirector, build_opener

import sympy as sp

from qdot.exercises.assignment.certified_problems import Variant
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.known_wrong_answers import find_known_wrong_answers
from qdot.exercises.exports.prairielearn import INSTANCE_FOLDER, list_input_names, make_question_id
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.formula.sympy_text import format_matrix_rows
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import LETTERS, Answer, ConditionSet, Letters, Matching, Number
from qdot.exercises.reference_answers.formulas import bracket_rows
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.singularities.singular_set import Component
from qdot.grader.marking.marking import MarkingRules, mark
from tests.platforms.given import EVERYTHING, order
from tests.platforms.records import Counts, Record, today
from tests.support.prairielearn_forms import fill_form, leave_blank

Data = dict[str, Any]
APP = "apps/prairielearn"
REPOSITORY = Path(__file__).parents[2]
LOOPBACK = Path(__file__).with_name("loopback.mjs")
PATIENCE = 600
"""The time limit in seconds for starting the server or loading a page."""
ADA, HENRI = ("ada@example.org", "Ada Lovelace"), ("henri@example.org", "Henri Poincaré")
GRADE = "question-grade"
"""In a page on which one can answer."""
MOST_WRONG = 3
"""The number of wrong answers tried for each part."""


def run(software: Path, work: Path) -> Record:
    """Load an export as a course; Ada answers the whole homework, and Henri takes the exam."""
    made = order(work / "assignment", EVERYTHING)
    course = work / "course"
    for file in EXPORT_FORMATS["prairielearn"].export(made):
        path = course / file.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(str(file.content), encoding="utf-8")
    counts = Counts()
    variants = list(iterate_bank(made))
    with running(software, course, work) as site:
        _load(site, counts)
        ada, henri = (site.visitor(*person) for person in (ADA, HENRI))
        _release(site, course, henri, counts)
        for variant, asked in zip(variants, ada.questions("Homework"), strict=True):
            _answer(asked, variant, made, counts)
        for variant, asked in zip(variants, henri.questions("Exam"), strict=True):
            _examine(asked, variant, made, counts)
        _total(site, variants, counts)
    told = subprocess.run(["git", "-C", software, "log", "-1", "--format=%cs (%h)"], capture_output=True, text=True)
    return Record(
        "prairielearn", f"a complete PrairieLearn server of {told.stdout.strip()}, over HTTP", today(), counts.told()
    )


# --- its server, and who visits it ---


@dataclass(frozen=True)
class Site:
    """A running PrairieLearn server, with its address and database."""

    address: str
    database: str

    def rows(self, query: str) -> list[Data]:
        """Return what its database answers to a query."""
        select = f"SELECT to_json(answer) FROM ({query}) answer"
        told = subprocess.run(
            ["psql", "--no-psqlrc", "-AtX", "-c", select, self.database], capture_output=True, text=True, check=True
        )
        return [json.loads(line) for line in told.stdout.splitlines()]

    def row(self, query: str) -> Data:
        """Return the only row of an answer."""
        (answer,) = self.rows(query)
        return answer

    def load(self) -> None:
        """Load the course from its folder, as an administrator does, and wait until this is done."""
        staff = Visitor(self)
        staff.get("/pl/loadFromDisk")
        while (job := self.rows("SELECT status FROM job_sequences ORDER BY id DESC LIMIT 1")[0]["status"]) == "Running":
            time.sleep(0.5)
        if job != "Success":
            raise RuntimeError(str(self.rows("SELECT output FROM jobs ORDER BY id DESC LIMIT 1")))

    def visitor(self, address: str, name: str) -> "Visitor":
        """Return a student, who has logged in."""
        student = Visitor(self)
        student.post("/pl/login", {"__action": "dev_login", "uid": address, "name": name})
        return student


@dataclass(frozen=True)
class Visitor:
    """A user's browser with its cookies."""

    site: Site
    opener: OpenerDirector = field(default_factory=lambda: build_opener(HTTPCookieProcessor(CookieJar())))

    def get(self, path: str) -> str:
        """Return a page."""
        return self._open(path, None)

    def post(self, path: str, form: Mapping[str, object]) -> str:
        """Return the page to which a form leads."""
        return self._open(path, urlencode(form, doseq=True).encode())

    def is_let_in(self, path: str) -> bool:
        """Return whether a page is shown."""
        try:
            self.get(path)
        except HTTPError as refusal:
            assert refusal.code == 403, refusal
            return False
        return True

    def questions(self, kind: str) -> list["Asked"]:
        """Start an assessment, and return its questions in order."""
        number = self.site.row(f"SELECT id FROM assessments WHERE type = '{kind}'")["id"]
        page = self.get(f"/pl/course_instance/1/assessment/{number}")
        if "instance_question" not in page:  # an exam is begun by a click
            form = {"__action": "new_instance", "__csrf_token": token(page)}
            page = self.post(f"/pl/course_instance/1/assessment/{number}", form)
        paths = dict.fromkeys(re.findall(r'href="(/pl/course_instance/1/instance_question/\d+/)"', page))
        return [Asked(self, path) for path in paths]

    def _open(self, path: str, form: bytes | None) -> str:
        with self.opener.open(self.site.address + path, form, PATIENCE) as answer:
            page: str = answer.read().decode()
        return page


def token(page: str) -> str:
    """Return what a form has to send along."""
    return unescape(re.findall(r'name="__csrf_token"\s+value="([^"]+)"', page)[0])


@contextmanager
def running(software: Path, course: Path, work: Path) -> Iterator[Site]:
    """Run PrairieLearn on a free port, with its own database and one course."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    database = f"qdot_{secrets.token_hex(4)}"
    redis = os.environ.get("REDIS_URL", "redis://127.0.0.1:6379/")
    settings = {
        "courseDirs": [str(course)], "serverPort": port, "filesRoot": str(work / "files"),
        "postgresqlDatabase": database, "postgresqlHost": os.environ["PGHOST"],
        "postgresqlUser": os.environ["PGUSER"], "postgresqlPassword": os.environ["PGPASSWORD"],
        "redisUrl": redis, "nonVolatileRedisUrl": redis, "cronActive": False, "workspaceEnable": False,
        "questionTimeoutMilliseconds": 1000 * PATIENCE, "workerPingTimeoutMilliseconds": 1000 * PATIENCE,
        "workersCount": 1,
    }  # fmt: skip
    (work / "files").mkdir()
    config = work / "config.json"
    config.write_text(json.dumps(settings), encoding="utf-8")
    python = software / ".venv/bin/python3.13"  # it starts anew for each phase, and keeps no bytecode itself
    subprocess.run([python, "-m", "compileall", "-q", "exercises", "grader"], cwd=REPOSITORY, check=True)
    _need(python, "prairielearn.internal.zygote_utils", "qdot.grader.marking.marking")
    subprocess.run(["createdb", database], check=True)
    app = software / APP
    command = [f"{app}/node_modules/.bin/tsx", "--tsconfig", "src/tsconfig.json", "--import", str(LOOPBACK)]
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY), "HOME": str(work)}
    with (work / "server.log").open("w", encoding="utf-8") as log:
        server = subprocess.Popen(
            [*command, "src/server.ts", "--config", str(config)], cwd=app, env=environment, stdout=log, stderr=log,
            start_new_session=True,
        )  # fmt: skip
    site = Site(f"http://127.0.0.1:{port}", database)
    try:
        _wait(server, site, work / "server.log")
        yield site
    finally:
        if server.poll() is None:
            os.killpg(server.pid, signal.SIGTERM)
            server.wait()
        subprocess.run(["dropdb", "--force", database], check=True)


def _need(python: Path, *modules: str) -> None:
    """Check that Python can import what questions call; otherwise pages of the server would wait for a long time."""
    path = os.pathsep.join((str(python.parents[2] / APP / "python"), str(REPOSITORY)))
    for module in modules:
        subprocess.run([python, "-c", f"import {module}"], env={**os.environ, "PYTHONPATH": path}, check=True)


def _wait(server: subprocess.Popen[bytes], site: Site, log: Path) -> None:
    for _ in range(PATIENCE):
        if server.poll() is not None:
            raise RuntimeError(log.read_text(encoding="utf-8")[-3000:])
        try:
            Visitor(site).get("/pl/webhooks/ping")
        except URLError:
            time.sleep(1)
        else:
            return
    raise RuntimeError(f"PrairieLearn did not start in {PATIENCE} s")


# --- the course ---


def _load(site: Site, counts: Counts) -> None:
    """Load the course as it is exported; count what it says of each info.json."""
    site.load()
    for table in ("courses", "course_instances", "assessments", "questions"):
        for one in site.rows(f"SELECT id, sync_errors, sync_warnings FROM {table}"):
            said = one["sync_errors"] or one["sync_warnings"]
            counts.add("loaded without a warning", not said, f"{table}: {said}")


def _release(site: Site, course: Path, student: Visitor, counts: Counts) -> None:
    """Publish the course instance, then release both assessments, in the files that its pages write."""
    assessments = sorted((course / INSTANCE_FOLDER / "assessments").glob("*/infoAssessment.json"))
    pages = [f"/pl/course_instance/1/assessment/{number}" for number in range(1, len(assessments) + 1)]
    hidden = "hidden until released"
    counts.add(hidden, not student.is_let_in("/pl/course_instance/1"), "the course instance")
    dates = {"startDate": "2020-01-01T00:00:01", "endDate": "2099-12-31T23:59:59"}
    _set(course / INSTANCE_FOLDER / "infoCourseInstance.json", publishing=dates)
    site.load()
    assert student.is_let_in("/pl/course_instance/1")
    for page in pages:
        counts.add(hidden, not student.is_let_in(page), page)
    for path in assessments:
        _set(path, accessControl=[{"dateControl": {"release": {"date": "2020-01-01T00:00:01"}}}])
    site.load()


def _set(path: Path, **settings: object) -> None:
    path.write_text(json.dumps(json.loads(path.read_text(encoding="utf-8")) | settings), encoding="utf-8")


# --- answers ---


def _right(part: Part) -> list[str]:
    """Return the right answer in several forms."""
    answer = part.answer
    if isinstance(answer, Letters):
        return [answer.letters]
    if isinstance(answer, Number):
        values = [float(value) for value in answer.as_matrix()]
        if answer.is_count:
            return [_listed(str(round(value)) for value in values)]
        return [_listed(f"{value:{form}}" for value in values) for form in (".6g", ".4f", ".5e")]
    typed = answer.as_typed()
    return [typed, answer.write_code(), typed.replace("**", "^").replace("*", " ")]


def _wrong(problem: Problem, part: Part) -> list[str]:
    """Return wrong answers: other options, and what known mistakes give; where there are none, sevens."""
    answer = part.answer
    if isinstance(answer, Matching):
        turned = answer.letters[1:] + answer.letters[:1]
        return [turned]
    if isinstance(answer, Letters):
        return [letter for letter in LETTERS[: len(answer.options)] if letter not in answer.letters][:MOST_WRONG]
    known = [_typed(answer, one.answer) for one in find_known_wrong_answers(problem, part, MOST_WRONG)]
    rows, columns = answer.shape or (1, 1)
    sevens = bracket_rows([["7"] * columns] * rows) if answer.shape else "7"
    return known or [_listed(["7"] * rows) if isinstance(answer, Number) else sevens]


def _typed(answer: Answer, wrong: sp.Matrix | tuple[Component, ...]) -> str:
    if isinstance(answer, ConditionSet):
        return replace(answer, components=wrong).as_typed()
    if isinstance(answer, Number):
        return _listed(f"{float(value):.6g}" for value in sp.Matrix(wrong))
    rows = format_matrix_rows(sp.Matrix(wrong))
    return bracket_rows(rows) if answer.shape else rows[0][0]


def _listed(numbers: Iterable[str]) -> str:
    each = list(numbers)
    return f"[{', '.join(each)}]" if len(each) > 1 else each[0]


# --- one question ---


@dataclass(frozen=True)
class Asked:
    """A question of an assessment that a user takes."""

    student: Visitor
    path: str

    @property
    def number(self) -> int:
        """Return its number in the database."""
        return int(self.path.split("/")[-2])

    def page(self) -> str:
        """Return its page, which has a new variant where the last one is done."""
        return self.student.get(self.path)

    def variant(self) -> Data:
        """Return its newest variant."""
        query = f"SELECT * FROM variants WHERE instance_question_id = {self.number} ORDER BY id DESC LIMIT 1"
        return self.student.site.row(query)

    def points(self) -> float:
        """Return what it has earned so far."""
        query = f"SELECT points FROM instance_questions WHERE id = {self.number}"
        return float(self.student.site.row(query)["points"])

    def submit(self, page: str, form: Data) -> tuple[Data, str]:
        """Submit a form of a page; return the stored submission and the next page."""
        sent = {"__action": "grade", "__variant_id": self.variant()["id"], "__csrf_token": token(page)}
        page = self.student.post(self.path, {**sent, **form})
        query = f"SELECT * FROM submissions WHERE variant_id = {sent['__variant_id']} ORDER BY id DESC LIMIT 1"
        return self.student.site.row(query), page


def _answer(asked: Asked, variant: Variant, made: ExportRequest, counts: Counts) -> None:
    """Answer a question of the homework, right in several forms, wrong, in part, and not at all."""
    problem, name = variant.problem, make_question_id(made.assignment, variant.slot)
    print(name, flush=True)
    page = asked.page()
    _show(name, page, asked.variant(), problem, counts)
    for texts in wrong_answers(problem):
        page = _submit(asked, page, problem, made, texts, counts, "wrong < full")
    page = _submit(asked, page, problem, made, of_the_first(problem, _right), counts)
    page = page if GRADE in page else asked.page()
    before = asked.variant()
    blank = {key: text for part in problem.parts for key, text in leave_blank(part).items()}
    nothing, page = asked.submit(page, blank)
    costs_none = bool(nothing["format_errors"]) and asked.variant()["num_tries"] == before["num_tries"]
    counts.add("nothing costs no attempt", costs_none, name)
    for texts in right_answers(problem):
        page = _submit(asked, page, problem, made, texts, counts, "right = full")
    counts.add("points as ours", abs(asked.points() - problem.max_points) < 1e-6, f"{name}: {asked.points()}")
    for part in problem.parts:
        solution = words(asked.variant()["true_answer"]["solutions"][part.name]["solution"])
        counts.add("solution when done", solution in words(page), f"{name}.{part.name}")


def _examine(asked: Asked, variant: Variant, made: ExportRequest, counts: Counts) -> None:
    """Answer a question of the exam in three attempts: the best one counts, and there is no fourth."""
    problem, name = variant.problem, make_question_id(made.assignment, variant.slot)
    page, best = asked.page(), 0.0
    only = asked.variant()["id"]
    several = [of_the_first(problem, _right), of_the_first(problem, partial(_wrong, problem))]
    for texts in [*several * (len(problem.parts) > 1), next(right_answers(problem))]:
        page = _submit(asked, page, problem, made, texts, counts)
        best = max(best, sum(_marks(problem, made, texts).values()))
        counts.add("points as ours", abs(asked.points() - best) < 1e-6, f"{name}: {asked.points()}, not {best}")
    counts.add("attempts of the exam", GRADE not in asked.page(), f"{name} can be answered once more")
    counts.add("attempts of the exam", asked.variant()["id"] == only, f"{name} has another variant")


def _total(site: Site, variants: list[Variant], counts: Counts) -> None:
    """Compare the points of both assessments with those of the assignment."""
    whole = sum(variant.problem.max_points for variant in variants)
    for one in site.rows("SELECT assessment_id, points, max_points FROM assessment_instances"):
        same = all(abs(one[points] - whole) < 1e-6 for points in ("points", "max_points"))
        counts.add("points of the assessments", same, f"{one}, of {whole}")
    issues = site.rows("SELECT question_id, student_message, instructor_message, course_data FROM issues")
    for question in site.rows("SELECT id, qid FROM questions"):
        told = [issue for issue in issues if issue["question_id"] == question["id"]]
        counts.add("no issue for the staff", not told, f"{question['qid']}: {told[:1]}")


def right_answers(problem: Problem) -> Iterator[dict[str, str]]:
    """Yield right answers to all parts, in several forms."""
    right = {part.name: _right(part) for part in problem.parts}
    for number in range(3):
        yield {name: forms[number % len(forms)] for name, forms in right.items()}


def wrong_answers(problem: Problem) -> Iterator[dict[str, str]]:
    """Yield wrong answers to all parts, or to those that have so many."""
    wrong = {part.name: _wrong(problem, part) for part in problem.parts}
    for number in range(max(len(forms) for forms in wrong.values())):
        yield {name: forms[number] for name, forms in wrong.items() if number < len(forms)}


def of_the_first(problem: Problem, forms: Callable[[Part], list[str]]) -> dict[str, str]:
    """Return an answer to the first part, and to no other."""
    return {problem.parts[0].name: forms(problem.parts[0])[0]}


def words(page: str) -> str:
    """Return what can be read of HTML."""
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", without_scripts(page))).split())


def without_scripts(page: str) -> str:
    """Return HTML without scripts and styles."""
    return re.sub(r"<(script|style)\b.*?</\1>", " ", page, flags=re.DOTALL)


def _show(name: str, page: str, variant: Data, problem: Problem, counts: Counts) -> None:
    read = words(page)
    for part in problem.parts:
        counts.add("imported", part.name in variant["params"]["shown"], f"{name}.{part.name}")
        fields = all(f'name="{box}"' in page for box in list_input_names(part))
        solution = words(variant["true_answer"]["solutions"][part.name]["solution"])
        shown = fields and ALL_QUESTIONS[part.kind].title in read and solution not in read
        counts.add("shown", shown, f"{name}.{part.name}")
    _see_clean(page, name, counts)


def _see_clean(page: str, name: str, counts: Counts) -> None:
    left = [sign for sign in ("{{", "<pl-", "in quotes", "?:") if sign in without_scripts(page)]
    counts.add("clean pages", not left, f"{name}: {left}")


def _marks(problem: Problem, made: ExportRequest, texts: Mapping[str, str]) -> dict[str, float]:
    """Return what we give for answers, by part."""
    assignment = made.assignment
    rules = MarkingRules(assignment.follow_through)
    verdicts = mark(problem, texts, secret=assignment.secret, rules=rules)
    return {
        part.name: -1 if verdict.points is None else verdict.points
        for part, verdict in zip(problem.parts, verdicts, strict=True)
    }


def _submit(
    asked: Asked,
    page: str,
    problem: Problem,
    made: ExportRequest,
    texts: Mapping[str, str],
    counts: Counts,
    what: str = "",
) -> str:
    """Submit answers to some parts and blanks to the others; compare every score with ours, and return the page."""
    page = page if GRADE in page else asked.page()
    params = asked.variant()["params"]
    form: Data = {}
    for part in problem.parts:
        text = texts.get(part.name)
        form |= leave_blank(part) if text is None else fill_form(part, text, params)
    stored, page = asked.submit(page, form)
    ours = _marks(problem, made, texts)
    for part in problem.parts:
        where = f"{asked.path} {part.name} {texts.get(part.name)!r}: {stored['format_errors'] or ''}"
        score = (stored["partial_scores"] or {}).get(part.name, {}).get("score", -1)
        if part.name not in texts:
            counts.add("blank = 0", score == 0, f"{where} {score}")
        elif what:
            counts.add(what, score == 1 if what == "right = full" else 0 <= score < 1, f"{where} {score}")
        counts.add("scores as ours", abs(score - ours[part.name] / part.points) < 1e-9, f"{where} {score}")
    _see_clean(page, asked.path, counts)
    return page
