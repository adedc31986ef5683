"""PrairieLearn's own question server and elements, without its database and web pages: each question, scores as ours.

`software` is a checkout whose `.venv` holds what its pyproject.toml and qdot depend on (Python 3.13), with the packages
of its apps/prairielearn in place and those of packages/ built (pnpm); Node 24 is on the path.
"""

import json
import os
import re
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import jsonschema
import sympy as sp

from exercises.answers import LETTERS, Answer, ConditionSet, Letters, Matching, Number
from exercises.answers.base import rows_typed
from exercises.arm.singularity import Component
from exercises.exports.bank import bank
from exercises.exports.known_wrong import known_wrong
from exercises.exports.outlet import Order
from exercises.exports.prairielearn import EXACTLY, input_names, question_id
from exercises.exports.registry import OUTLETS
from exercises.formula.text import rows_of_text
from exercises.problem import Part, Problem
from exercises.quizzes import ASKED
from grader.marking import mark
from tests.platforms.given import EVERYTHING, order
from tests.platforms.records import Counts, Record, today
from tests.support.elements import filled, left_blank

Data = dict[str, Any]
APP = "apps/prairielearn"
REPOSITORY = Path(__file__).parents[2]
SCRIPT = Path(__file__).with_suffix(".mjs")
ANSWER = "> "
"""Before the script's answers; the server logs into the same output."""
SCHEMAS = {
    "infoCourse.json": "infoCourse",
    "infoCourseInstance.json": "infoCourseInstance",
    "infoAssessment.json": "infoAssessment",
    "info.json": "infoQuestion",
}
MOST_WRONG = 3
"""So many wrong answers are given to each part."""


def run(software: Path, work: Path) -> Record:
    """Export everything, take each question through all phases, and count."""
    made = order(work / "assignment", EVERYTHING)
    course = work / "course"
    for file in OUTLETS["prairielearn"].files(made):
        path = course / file.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(str(file.content), encoding="utf-8")
    counts = Counts()
    _validate(software, course, counts)
    server = Server(software, course)
    for variant in bank(made):
        question = _Question(server, question_id(made.assignment, variant.slot), counts)
        _try(question, variant.problem, made, counts)
    server.close()
    told = subprocess.run(["git", "-C", software, "log", "-1", "--format=%cs (%h)"], capture_output=True, text=True)
    name = f"PrairieLearn of {told.stdout.strip()}, its question server in Node and its elements in Python"
    return Record("prairielearn", name, today(), counts.told())


# --- what is counted ---


def _validate(software: Path, course: Path, counts: Counts) -> None:
    for path in sorted(course.rglob("info*.json")):
        schema = json.loads((software / APP / "src/schemas/schemas" / f"{SCHEMAS[path.name]}.json").read_text())
        errors = list(jsonschema.Draft7Validator(schema).iter_errors(json.loads(path.read_text())))
        counts.add("valid", not errors, f"{path.relative_to(course)}: {errors[:1]}")


# --- a question, in the server ---


class Server:
    """PrairieLearn's question server in Node, told over a pipe what to make; it starts its Python worker itself."""

    def __init__(self, software: Path, course: Path) -> None:
        app, self.course = software / APP, course
        environment = {"PYTHONPATH": str(REPOSITORY), "PATH": os.environ["PATH"], "HOME": str(course)}
        command: list[str | Path] = [
            app / "node_modules/.bin/tsx", "--tsconfig", "src/tsconfig.json", SCRIPT, software, course,
        ]  # fmt: skip
        self.process = subprocess.Popen(
            command, cwd=app, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip

    def make(self, question: str, what: str, **told: Any) -> Any:
        """Return what was made, and what the staff would be told was wrong with the question."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps({"question": question, "make": what, **told}) + "\n")
        self.process.stdin.flush()
        for line in self.process.stdout:
            if line.startswith(ANSWER):
                answer = json.loads(line.removeprefix(ANSWER))
                return answer["made"], answer["issues"]
        raise RuntimeError(f"PrairieLearn's question server ended at {what} of {question}")

    def close(self) -> None:
        """End it, and its worker."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait(60)


class _Question:
    """A variant of a question, from generate on."""

    def __init__(self, server: Server, qid: str, counts: Counts) -> None:
        self.server, self.name, self.counts = server, qid, counts
        self.made = self._make("variant")

    def submit(self, form: Data) -> Data:
        """Return a submission after it has been parsed, and graded unless it can't be."""
        return self._make("submission", variant=self.made, form=form)

    def pages(self, submission: Data | None = None) -> Data:
        """Return the HTML of the panels of its page, of a submission, too."""
        return self._make("pages", variant=self.made, submission=submission)

    def _make(self, what: str, **told: Any) -> Data:
        made, issues = self.server.make(self.name, what, **told)
        self.counts.add("no issue for the staff", not issues, f"{self.name}, {what}: {issues[:1]}")
        if made is None:
            raise RuntimeError(f"{self.name}, {what}: {issues}")
        result: Data = made
        return result


# --- answers ---


def _right(part: Part) -> list[str]:
    """Return the right answer in several forms."""
    answer = part.answer
    if isinstance(answer, Letters):
        return [answer.letters]
    if isinstance(answer, Number):
        values = [float(value) for value in answer.as_matrix()]
        if answer.tolerance < EXACTLY:
            return [_listed(str(round(value)) for value in values)]
        return [_listed(f"{value:{form}}" for value in values) for form in (".6g", ".4f", ".5e")]
    typed = answer.as_typed()
    return [typed, answer.code(), typed.replace("**", "^").replace("*", " ")]


def _wrong(problem: Problem, part: Part) -> list[str]:
    """Return wrong answers: other options, and what known mistakes give; where there are none, sevens."""
    answer = part.answer
    if isinstance(answer, Matching):
        turned = answer.letters[1:] + answer.letters[:1]
        return [turned]
    if isinstance(answer, Letters):
        return [letter for letter in LETTERS[: len(answer.options)] if letter not in answer.letters][:MOST_WRONG]
    known = [_typed(answer, one.answer) for one in known_wrong(problem, part, MOST_WRONG)]
    rows, columns = answer.shape or (1, 1)
    sevens = rows_typed([["7"] * columns] * rows) if answer.shape else "7"
    return known or [_listed(["7"] * rows) if isinstance(answer, Number) else sevens]


def _typed(answer: Answer, wrong: sp.Matrix | tuple[Component, ...]) -> str:
    if isinstance(answer, ConditionSet):
        return replace(answer, components=wrong).as_typed()
    if isinstance(answer, Number):
        return _listed(f"{float(value):.6g}" for value in sp.Matrix(wrong))
    rows = rows_of_text(sp.Matrix(wrong))
    return rows_typed(rows) if answer.shape else rows[0][0]


def _listed(numbers: Iterable[str]) -> str:
    each = list(numbers)
    return f"[{', '.join(each)}]" if len(each) > 1 else each[0]


# --- one question ---


def _try(question: _Question, problem: Problem, made: Order, counts: Counts) -> None:
    place = question.name
    print(place)
    for part in problem.parts:
        shown = part.name in question.made["params"]["shown"]
        counts.add("imported", shown, f"{place}.{part.name}")
    _show(question, problem, counts)
    _score(question, problem, made, counts)


def _show(question: _Question, problem: Problem, counts: Counts) -> None:
    pages = question.pages()
    asked, solved = pages["questionHtml"], pages["answerHtml"]
    for part in problem.parts:
        solution = _words(question.made["true_answer"]["solutions"][part.name]["solution"])
        fields = all(f'name="{name}"' in asked for name in input_names(part))
        told = ASKED[part.kind].title in _words(asked) and solution in _words(solved) and solution not in _words(asked)
        counts.add("shown", fields and told, f"{question.name}.{part.name}")
    clean = not [word for word in ("{{", "<pl-", "in quotes", "?:") if word in asked + solved]
    counts.add("clean pages", clean, question.name)


def _words(html: str) -> str:
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", html)).split())


def _score(question: _Question, problem: Problem, made: Order, counts: Counts) -> None:
    right = {part.name: _right(part) for part in problem.parts}
    wrong = {part.name: _wrong(problem, part) for part in problem.parts}
    for number in range(3):
        texts = {name: forms[number % len(forms)] for name, forms in right.items()}
        _submit(question, problem, made, texts, counts, "right = full", lambda score: score == 1)
    for number in range(MOST_WRONG):
        texts = {name: forms[number] for name, forms in wrong.items() if number < len(forms)}
        _submit(question, problem, made, texts, counts, "wrong < full", lambda score: score < 1)
    first = problem.parts[0]
    _submit(question, problem, made, {first.name: right[first.name][0]}, counts, "", lambda score: True)
    nothing = question.submit({name: text for part in problem.parts for name, text in left_blank(part).items()})
    counts.add("nothing costs no attempt", bool(nothing["format_errors"]), question.name)


def _submit(
    question: _Question,
    problem: Problem,
    made: Order,
    texts: dict[str, str],
    counts: Counts,
    what: str,
    is_due: Callable[[float], bool],
) -> None:
    """Hand in answers to some parts, and blanks to the others; hold every score against ours."""
    if not texts:
        return
    form: Data = {}
    for part in problem.parts:
        text = texts.get(part.name)
        form |= left_blank(part) if text is None else filled(part, text, question.made["params"])
    data = question.submit(form)
    assignment = made.assignment
    ours = mark(problem, texts, secret=assignment.secret, credit=assignment.follow_through, oftener=assignment.oftener)
    for part, verdict in zip(problem.parts, ours, strict=True):
        where = f"{question.name}.{part.name} {texts.get(part.name)!r}: {data['format_errors'] or ''}"
        score = (data["partial_scores"] or {}).get(part.name, {}).get("score", -1)
        if part.name in texts and what:
            counts.add(what, score >= 0 and is_due(score), f"{where} {score}")
        elif part.name not in texts:
            counts.add("blank = 0", score == 0, f"{where} {score}")
        same = verdict.points is not None and abs(score - verdict.points / part.points) < 1e-9
        counts.add("scores as ours", same, f"{where} {score}")
    if not data["format_errors"]:
        (page,) = question.pages(data)["submissionHtmls"]
        counts.add("clean pages", not [word for word in ("{{", "<pl-", "in quotes", "?:") if word in page], where)
