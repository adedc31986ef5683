"""What a person types: every form in tests/data/forms.jsonl gets what it says there.

`where` a form is typed is a cell of a notebook, as Python, or a box, as text. `gets` is the outcome; "refused" is read
and of another form than is due, "unreadable" a value that is no formula, "stopped" a cell that Python stops. `says` is
how the sentence begins that the student reads. `right` has the right answer where it is not the problem's own.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.notebook.notebook import make_notebook_metadata
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.reference_answers import LETTERS, Choice, Number
from qdot.grader.grading.check import find_claimed_form, is_readable
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.expected_form import find_expected_form, read_answer
from qdot.grader.judging.functions import make_calls
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.sandbox.sandbox import Sandbox
from tests.support import DATA
from tests.support.problems import get_problem
from tests.support.suites import select_for_suite

FORMS = [json.loads(line) for line in (DATA / "forms.jsonl").read_text(encoding="utf-8").splitlines()]
CELLS, TEXTS = ([form for form in FORMS if form["where"] == where] for where in ("cell", "text"))
SETUP = """
from sympy import *
import numpy as np
theta1, theta2, a1, a2, qd1, qd2, vx, vy, t = symbols("theta1 theta2 a1 a2 qd1 qd2 vx vy t")
px = a1*cos(theta1) + a2*cos(theta1 + theta2)
py = a1*sin(theta1) + a2*sin(theta1 + theta2)
P, q = Matrix([px, py]), Matrix([theta1, theta2])
"""
SEED = "forms"


def problem() -> Problem:
    """The plain arm of the chapter."""
    return get_problem("planar-2r", 0, "chapter")


def part_of(form: Mapping[str, Any]) -> Part:
    """The part that a form answers, with the right answer that the form names."""
    part = problem()[form["part"]]
    answer = part.answer
    if "right" in form and isinstance(answer, Number):
        answer = replace(answer, reference=sp.Matrix([sp.Float(value, 12) for value in form["right"]]))
    elif "right" in form:
        assert isinstance(answer, Choice)
        answer = replace(answer, correct=LETTERS.index(form["right"]))
    return replace(part, answer=answer)


@dataclass(frozen=True)
class Typed:
    """A form with its value as it left the notebook or the box, or why there is none."""

    form: Mapping[str, Any]
    text: str | None
    why: str = ""

    @property
    def given(self) -> ParsedAnswer:
        assert self.text is not None
        return read_answer(problem(), part_of(self.form), self.text, SEED)


TOGETHER = 12
"""AnswerVisitor in one notebook: after every cell, all answers are looked at again."""


@pytest.fixture(scope="module")
def typed(sandbox: Sandbox) -> list[Typed]:
    """All forms, in `make test` every third: each that is Python in a cell of its own."""
    cells, texts = CELLS[:: select_for_suite(3, 1)], TEXTS[:: select_for_suite(3, 1)]
    runs = (_run(sandbox, cells[begin : begin + TOGETHER]) for begin in range(0, len(cells), TOGETHER))
    return [*(one for run in runs for one in run), *(Typed(form, form["typed"]) for form in texts)]


def _run(sandbox: Sandbox, forms: list[dict[str, Any]]) -> list[Typed]:
    slots = [f"p{k}" for k in range(len(forms))]
    names = [f"{slot}_form" for slot in slots]
    calls = dict.fromkeys(slots, make_calls(problem(), problem().domain, SEED))
    cells = [SETUP, *(f"{name} = {form['typed']}" for name, form in zip(names, forms, strict=True))]
    run = sandbox.run(cells, names, calls)
    assert run.end == "done"
    return [
        Typed(form, run.answers.get(name), run.unreadable_reasons.get(name) or run.cell_errors.get(k + 1, ""))
        for k, (name, form) in enumerate(zip(names, forms, strict=True))
    ]


def outcome(one: Typed, number: int) -> tuple[str, str]:
    """Return what a form gets, and what is said of it."""
    if one.text is None:
        return ("stopped" if one.form["gets"] == "stopped" else "unreadable"), one.why
    given = one.given
    judged = judge_parsed(problem(), part_of(one.form), given, f"forms/{number}")
    return ("refused" if given.refusal else judged.outcome.value), judged.reason


def test_every_form_gets_what_is_due(typed: list[Typed]) -> None:
    found = [(one.form, *outcome(one, number)) for number, one in enumerate(typed)]
    assert [(form["typed"], gets, said) for form, gets, said in found if gets != form["gets"]] == []
    assert [(form["typed"], said) for form, _, said in found if not said.startswith(form["says"])] == []


def test_check_says_of_every_form_whether_the_grader_can_read_it(typed: list[Typed]) -> None:
    """Options to choose from are in no notebook; what `qdot check` can't know is known to the grader alone."""
    said = make_notebook_metadata("student", "hw", "ada", [("p1", problem())])
    for one in typed:
        if one.text is not None:
            part = part_of(one.form)
            due = (
                find_expected_form(problem(), part)
                if part.answer.offered_options
                else find_claimed_form(said, "p1", part.name)
            )
            strange = not part.answer.is_set and one.given.symbols - set(problem().domain.roles)
            readable_there = one.given.refusal is None and not strange
            assert due is not None and is_readable(one.text, due) == readable_there, one.form


def test_there_are_many_forms_of_every_question() -> None:
    assert len(FORMS) >= 600
    assert len({(form["part"], form["where"], form["typed"], str(form.get("right"))) for form in FORMS}) == len(FORMS)
    assert {form["part"] for form in FORMS} == {part.name for part in problem().parts}
    assert {form["gets"] for form in FORMS} == {"correct", "partial", "wrong", "refused", "unreadable", "stopped"}
