"""A complete PrairieLearn server: load, publish and release a course, and answer its assessments as students over HTTP.

`software` is a checkout with its packages installed and built (pnpm). Its `.venv` has the dependencies of its
pyproject.toml and of qdot (Python 3.13); Node 24 is on the path. PGHOST, PGPORT, PGUSER and PGPASSWORD name a
PostgreSQL with the extension vector, in which the run creates a database and drops it; REDIS_URL names a Redis.
"""

import json
import os
import re
import secrets
import signal
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
from qdot.exercises.short_questions import question_of
from qdot.exercises.singularities.singular_set import Component
from qdot.grader.marking.marking import MarkingRules, mark
from tests.platforms.assignments import EVERYTHING, make_request, write_files
from tests.platforms.records import Counts, Record, describe_checkout, today
from tests.support.prairielearn_forms import fill_form, leave_blank
from tests.support.running_service import find_free_port

Data = dict[str, Any]
APP = "apps/prairielearn"
REPOSITORY = Path(__file__).parents[2]
LOOPBACK = Path(__file__).with_name("loopback.mjs")
PATIENCE = 600
"""Seconds that the server may take to start, or to send a page."""
ADA, HENRI = ("ada@example.org", "Ada Lovelace"), ("henri@example.org", "Henri Poincaré")
GRADE = "question-grade"
"""A class of the HTML of pages whose question can still be answered."""
MAX_WRONG_ANSWERS = 3
"""Number of wrong answers to each part."""


def run(software: Path, work: Path) -> Record:
    """Load an export as a course; Ada answers everything in the homework, Henri takes the exam."""
    request = make_request(work / "assignment", EVERYTHING)
    course = work / "course"
    write_files(EXPORT_FORMATS["prairielearn"].export(request), course)
    counts = Counts()
    variants = list(iterate_bank(request))
    with run_server(software, course, work) as site:
        _load_course(site, counts)
        ada, henri = (site.log_in(*person) for person in (ADA, HENRI))
        _release_course(site, course, henri, counts)
        for variant, question in zip(variants, ada.begin_assessment("Homework"), strict=True):
            _answer_homework_question(question, variant, request, counts)
        for variant, question in zip(variants, henri.begin_assessment("Exam"), strict=True):
            _answer_exam_question(question, variant, request, counts)
        _check_totals(site, variants, counts)
    name = f"a complete PrairieLearn server of {describe_checkout(software)}, over HTTP"
    return Record("prairielearn", name, today(), counts.freeze())


# --- the server and its visitors ---


@dataclass(frozen=True)
class Site:
    address: str
    database: str

    def query_rows(self, query: str) -> list[Data]:
        select = f"SELECT to_json(answer) FROM ({query}) answer"
        output = subprocess.run(
            ["psql", "--no-psqlrc", "-AtX", "-c", select, self.database], capture_output=True, text=True, check=True
        )
        return [json.loads(line) for line in output.stdout.splitlines()]

    def query_row(self, query: str) -> Data:
        (row,) = self.query_rows(query)
        return row

    def load_course(self) -> None:
        """Load the course from its folder as an administrator does, and wait until that is done."""
        staff = Visitor(self)
        staff.get("/pl/loadFromDisk")
        while (
            job := self.query_rows("SELECT status FROM job_sequences ORDER BY id DESC LIMIT 1")[0]["status"]
        ) == "Running":
            time.sleep(0.5)
        if job != "Success":
            raise RuntimeError(str(self.query_rows("SELECT output FROM jobs ORDER BY id DESC LIMIT 1")))

    def log_in(self, address: str, name: str) -> "Visitor":
        student = Visitor(self)
        student.post("/pl/login", {"__action": "dev_login", "uid": address, "name": name})
        return student


@dataclass(frozen=True)
class Visitor:
    site: Site
    opener: OpenerDirector = field(default_factory=lambda: build_opener(HTTPCookieProcessor(CookieJar())))

    def get(self, path: str) -> str:
        return self._open(path, None)

    def post(self, path: str, form: Mapping[str, object]) -> str:
        return self._open(path, urlencode(form, doseq=True).encode())

    def can_open(self, path: str) -> bool:
        """Return whether a page is shown; if not, the server must answer 403."""
        try:
            self.get(path)
        except HTTPError as refusal:
            assert refusal.code == 403, refusal
            return False
        return True

    def begin_assessment(self, kind: str) -> list["Question"]:
        """Begin the assessment of a kind ("Homework" or "Exam"), and return its questions in order."""
        number = self.site.query_row(f"SELECT id FROM assessments WHERE type = '{kind}'")["id"]
        page = self.get(f"/pl/course_instance/1/assessment/{number}")
        if "instance_question" not in page:  # an exam begins with a click
            form = {"__action": "new_instance", "__csrf_token": find_csrf_token(page)}
            page = self.post(f"/pl/course_instance/1/assessment/{number}", form)
        paths = dict.fromkeys(re.findall(r'href="(/pl/course_instance/1/instance_question/\d+/)"', page))
        return [Question(self, path) for path in paths]

    def _open(self, path: str, form: bytes | None) -> str:
        with self.opener.open(self.site.address + path, form, PATIENCE) as response:
            page: str = response.read().decode()
        return page


def find_csrf_token(page: str) -> str:
    return unescape(re.findall(r'name="__csrf_token"\s+value="([^"]+)"', page)[0])


@contextmanager
def run_server(software: Path, course: Path, work: Path) -> Iterator[Site]:
    """Run PrairieLearn on a free port with a database of its own and one course."""
    port = str(find_free_port())
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
    python = software / ".venv/bin/python3.13"  # it is restarted for each phase and writes no bytecode
    subprocess.run([python, "-m", "compileall", "-q", "exercises", "grader"], cwd=REPOSITORY, check=True)
    _check_imports(python, "prairielearn.internal.zygote_utils", "qdot.grader.marking.marking")
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
        _wait_for_server(server, site, work / "server.log")
        yield site
    finally:
        if server.poll() is None:
            os.killpg(server.pid, signal.SIGTERM)
            server.wait()
        subprocess.run(["dropdb", "--force", database], check=True)


def _check_imports(python: Path, *modules: str) -> None:
    """Raise an error unless Python can import modules that questions call; otherwise pages would time out slowly."""
    path = os.pathsep.join((str(python.parents[2] / APP / "python"), str(REPOSITORY)))
    for module in modules:
        subprocess.run([python, "-c", f"import {module}"], env={**os.environ, "PYTHONPATH": path}, check=True)


def _wait_for_server(server: subprocess.Popen[bytes], site: Site, log: Path) -> None:
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


def _load_course(site: Site, counts: Counts) -> None:
    """Load the course as exported, and check that no info.json causes an error or a warning."""
    site.load_course()
    for table in ("courses", "course_instances", "assessments", "questions"):
        for row in site.query_rows(f"SELECT id, sync_errors, sync_warnings FROM {table}"):
            warning = row["sync_errors"] or row["sync_warnings"]
            counts.add("loaded without a warning", not warning, f"{table}: {warning}")


def _release_course(site: Site, course: Path, student: Visitor, counts: Counts) -> None:
    """Publish the course instance, then release both assessments, in the files that PrairieLearn's pages change."""
    assessments = sorted((course / INSTANCE_FOLDER / "assessments").glob("*/infoAssessment.json"))
    pages = [f"/pl/course_instance/1/assessment/{number}" for number in range(1, len(assessments) + 1)]
    check = "hidden until released"
    counts.add(check, not student.can_open("/pl/course_instance/1"), "the course instance")
    dates = {"startDate": "2020-01-01T00:00:01", "endDate": "2099-12-31T23:59:59"}
    _update_json(course / INSTANCE_FOLDER / "infoCourseInstance.json", publishing=dates)
    site.load_course()
    assert student.can_open("/pl/course_instance/1")
    for page in pages:
        counts.add(check, not student.can_open(page), page)
    for path in assessments:
        _update_json(path, accessControl=[{"dateControl": {"release": {"date": "2020-01-01T00:00:01"}}}])
    site.load_course()


def _update_json(path: Path, **settings: object) -> None:
    path.write_text(json.dumps(json.loads(path.read_text(encoding="utf-8")) | settings), encoding="utf-8")


# --- answers ---


def _make_right_answers(part: Part) -> list[str]:
    answer = part.answer
    if isinstance(answer, Letters):
        return [answer.letters]
    if isinstance(answer, Number):
        values = [float(value) for value in answer.as_matrix()]
        if answer.is_count:
            return [_format_list(str(round(value)) for value in values)]
        return [_format_list(f"{value:{form}}" for value in values) for form in (".6g", ".4f", ".5e")]
    typed = answer.as_typed()
    return [typed, answer.write_code(), typed.replace("**", "^").replace("*", " ")]


def _make_wrong_answers(problem: Problem, part: Part) -> list[str]:
    """Return wrong answers: other options, results of known mistakes, or sevens if no mistake is known."""
    answer = part.answer
    if isinstance(answer, Matching):
        return [answer.letters[1:] + answer.letters[:1]]
    if isinstance(answer, Letters):
        return [letter for letter in LETTERS[: len(answer.options)] if letter not in answer.letters][:MAX_WRONG_ANSWERS]
    known = [
        _format_wrong_answer(answer, known.answer)
        for known in find_known_wrong_answers(problem, part, MAX_WRONG_ANSWERS)
    ]
    rows, columns = answer.shape or (1, 1)
    sevens = bracket_rows([["7"] * columns] * rows) if answer.shape else "7"
    return known or [_format_list(["7"] * rows) if isinstance(answer, Number) else sevens]


def _format_wrong_answer(answer: Answer, wrong: sp.Matrix | tuple[Component, ...]) -> str:
    if isinstance(answer, ConditionSet):
        return replace(answer, components=wrong).as_typed()
    if isinstance(answer, Number):
        return _format_list(f"{float(value):.6g}" for value in sp.Matrix(wrong))
    rows = format_matrix_rows(sp.Matrix(wrong))
    return bracket_rows(rows) if answer.shape else rows[0][0]


def _format_list(numbers: Iterable[str]) -> str:
    texts = list(numbers)
    return f"[{', '.join(texts)}]" if len(texts) > 1 else texts[0]


# --- one question ---


@dataclass(frozen=True)
class Question:
    """A question of an assessment that a student has begun."""

    student: Visitor
    path: str

    @property
    def number(self) -> int:
        return int(self.path.split("/")[-2])

    def open_page(self) -> str:
        return self.student.get(self.path)

    def fetch_variant(self) -> Data:
        query = f"SELECT * FROM variants WHERE instance_question_id = {self.number} ORDER BY id DESC LIMIT 1"
        return self.student.site.query_row(query)

    def fetch_points(self) -> float:
        query = f"SELECT points FROM instance_questions WHERE id = {self.number}"
        return float(self.student.site.query_row(query)["points"])

    def submit(self, page: str, form: Data) -> tuple[Data, str]:
        variant = self.fetch_variant()["id"]
        hidden_fields = {"__action": "grade", "__variant_id": variant, "__csrf_token": find_csrf_token(page)}
        page = self.student.post(self.path, {**hidden_fields, **form})
        query = f"SELECT * FROM submissions WHERE variant_id = {variant} ORDER BY id DESC LIMIT 1"
        return self.student.site.query_row(query), page


def _answer_homework_question(question: Question, variant: Variant, request: ExportRequest, counts: Counts) -> None:
    """Answer a homework question: wrong, partly, blank, and right in several forms."""
    problem, name = variant.problem, make_question_id(request.assignment, variant.slot)
    print(name, flush=True)
    page = question.open_page()
    _check_page(name, page, question.fetch_variant(), problem, counts)
    for texts in iterate_wrong_answers(problem):
        page = _submit(question, page, problem, request, texts, counts, "wrong < full")
    page = _submit(question, page, problem, request, answer_first_part(problem, _make_right_answers), counts)
    page = page if GRADE in page else question.open_page()
    before = question.fetch_variant()
    blank = {key: text for part in problem.parts for key, text in leave_blank(part).items()}
    blank_submission, page = question.submit(page, blank)
    costs_no_attempt = (
        bool(blank_submission["format_errors"]) and question.fetch_variant()["num_tries"] == before["num_tries"]
    )
    counts.add("nothing costs no attempt", costs_no_attempt, name)
    for texts in iterate_right_answers(problem):
        page = _submit(question, page, problem, request, texts, counts, "right = full")
    points = question.fetch_points()
    counts.add("points as ours", abs(points - problem.max_points) < 1e-6, f"{name}: {points}")
    for part in problem.parts:
        solution = extract_text(question.fetch_variant()["true_answer"]["solutions"][part.name]["solution"])
        counts.add("solution when done", solution in extract_text(page), f"{name}.{part.name}")


def _answer_exam_question(question: Question, variant: Variant, request: ExportRequest, counts: Counts) -> None:
    """Answer an exam question in all its attempts; check that the best one counts and that there is no further one."""
    problem, name = variant.problem, make_question_id(request.assignment, variant.slot)
    page, best = question.open_page(), 0.0
    variant_id = question.fetch_variant()["id"]
    partial_answers = [
        answer_first_part(problem, _make_right_answers),
        answer_first_part(problem, partial(_make_wrong_answers, problem)),
    ]
    for texts in [*partial_answers * (len(problem.parts) > 1), next(iterate_right_answers(problem))]:
        page = _submit(question, page, problem, request, texts, counts)
        best = max(best, sum(_grade_with_qdot(problem, request, texts).values()))
        points = question.fetch_points()
        counts.add("points as ours", abs(points - best) < 1e-6, f"{name}: {points}, not {best}")
    counts.add("attempts of the exam", GRADE not in question.open_page(), f"{name} can be answered again")
    counts.add("attempts of the exam", question.fetch_variant()["id"] == variant_id, f"{name} has another variant")


def _check_totals(site: Site, variants: list[Variant], counts: Counts) -> None:
    """Check the points of both assessments against the assignment's, and that PrairieLearn reports no issues."""
    total = sum(variant.problem.max_points for variant in variants)
    for row in site.query_rows("SELECT assessment_id, points, max_points FROM assessment_instances"):
        same = all(abs(row[points] - total) < 1e-6 for points in ("points", "max_points"))
        counts.add("points of the assessments", same, f"{row}, not {total}")
    issues = site.query_rows("SELECT question_id, student_message, instructor_message, course_data FROM issues")
    for question in site.query_rows("SELECT id, qid FROM questions"):
        question_issues = [issue for issue in issues if issue["question_id"] == question["id"]]
        counts.add("no issue for the staff", not question_issues, f"{question['qid']}: {question_issues[:1]}")


def iterate_right_answers(problem: Problem) -> Iterator[dict[str, str]]:
    right = {part.name: _make_right_answers(part) for part in problem.parts}
    for number in range(3):
        yield {name: forms[number % len(forms)] for name, forms in right.items()}


def iterate_wrong_answers(problem: Problem) -> Iterator[dict[str, str]]:
    """Yield the first wrong answers to all parts, then the second ones of the parts that have two, and so on."""
    wrong = {part.name: _make_wrong_answers(problem, part) for part in problem.parts}
    for number in range(max(len(forms) for forms in wrong.values())):
        yield {name: forms[number] for name, forms in wrong.items() if number < len(forms)}


def answer_first_part(problem: Problem, forms: Callable[[Part], list[str]]) -> dict[str, str]:
    return {problem.parts[0].name: forms(problem.parts[0])[0]}


def extract_text(page: str) -> str:
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", remove_scripts(page))).split())


def remove_scripts(page: str) -> str:
    return re.sub(r"<(script|style)\b.*?</\1>", " ", page, flags=re.DOTALL)


def _check_page(name: str, page: str, variant: Data, problem: Problem, counts: Counts) -> None:
    text = extract_text(page)
    for part in problem.parts:
        counts.add("imported", part.name in variant["params"]["shown"], f"{name}.{part.name}")
        fields = all(f'name="{box}"' in page for box in list_input_names(part))
        solution = extract_text(variant["true_answer"]["solutions"][part.name]["solution"])
        shown = fields and question_of(part).make_title(problem.chain) in text and solution not in text
        counts.add("shown", shown, f"{name}.{part.name}")
    _check_markup(page, name, counts)


def _check_markup(page: str, name: str, counts: Counts) -> None:
    unprocessed = [markup for markup in ("{{", "<pl-", "in quotes", "?:") if markup in remove_scripts(page)]
    counts.add("clean pages", not unprocessed, f"{name}: {unprocessed}")


def _grade_with_qdot(problem: Problem, request: ExportRequest, texts: Mapping[str, str]) -> dict[str, float]:
    """Return the points that qdot gives answers, by part; -1 for an ungraded one."""
    assignment = request.assignment
    rules = MarkingRules(assignment.follow_through)
    verdicts = mark(problem, texts, secret=assignment.secret, rules=rules)
    return {
        part.name: -1 if verdict.points is None else verdict.points
        for part, verdict in zip(problem.parts, verdicts, strict=True)
    }


def _submit(
    question: Question,
    page: str,
    problem: Problem,
    request: ExportRequest,
    texts: Mapping[str, str],
    counts: Counts,
    check: str = "",
) -> str:
    page = page if GRADE in page else question.open_page()
    params = question.fetch_variant()["params"]
    form: Data = {}
    for part in problem.parts:
        text = texts.get(part.name)
        form |= leave_blank(part) if text is None else fill_form(part, text, params)
    stored, page = question.submit(page, form)
    qdot_points = _grade_with_qdot(problem, request, texts)
    for part in problem.parts:
        details = f"{question.path} {part.name} {texts.get(part.name)!r}: {stored['format_errors'] or ''}"
        score = (stored["partial_scores"] or {}).get(part.name, {}).get("score", -1)
        if part.name not in texts:
            counts.add("blank = 0", score == 0, f"{details} {score}")
        elif check:
            counts.add(check, score == 1 if check == "right = full" else 0 <= score < 1, f"{details} {score}")
        counts.add("scores as ours", abs(score - qdot_points[part.name] / part.points) < 1e-9, f"{details} {score}")
    _check_markup(page, question.path, counts)
    return page
