"""What a person types in a notebook: every form in tests/data/forms.jsonl gets what it says there, one cell each.

`gets` is the outcome; "refused" is read and of another form than is due, "unreadable" a value that is no formula,
"stopped" a cell that Python stops. `says` is how the sentence begins that the student reads.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import pytest

from exercises.generation import generate
from exercises.problem import Part, Problem, ProblemId
from grader.answer import Given
from grader.check import readable
from grader.parts import judge_given
from grader.reading import read_answer
from grader.sandbox import Sandbox
from tests.support import DATA

FORMS = [json.loads(line) for line in (DATA / "forms.jsonl").read_text(encoding="utf-8").splitlines()]
SETUP = """
from sympy import *
import numpy as np
theta1, theta2, a1, a2, qd1, qd2, vx, vy, t = symbols("theta1 theta2 a1 a2 qd1 qd2 vx vy t")
px = a1*cos(theta1) + a2*cos(theta1 + theta2)
py = a1*sin(theta1) + a2*sin(theta1 + theta2)
P, q = Matrix([px, py]), Matrix([theta1, theta2])
"""


@cache
def problem() -> Problem:
    """The plain arm of the chapter."""
    return generate(ProblemId("planar-2r", 0, variation="chapter"))


@dataclass(frozen=True)
class Typed:
    """A form with its value as it left the notebook, or why there is none."""

    form: Mapping[str, str]
    text: str | None
    why: str

    @property
    def asked(self) -> tuple[Problem, Part]:
        return problem(), problem()[self.form["part"]]

    @property
    def given(self) -> Given:
        assert self.text is not None
        return read_answer(*self.asked, self.text)


TOGETHER = 12
"""Forms in one notebook: after every cell, all answers are looked at again."""


@pytest.fixture(scope="module")
def typed(sandbox: Sandbox) -> list[Typed]:
    """All forms, each in a cell of its own."""
    return [one for begin in range(0, len(FORMS), TOGETHER) for one in _run(sandbox, FORMS[begin : begin + TOGETHER])]


def _run(sandbox: Sandbox, forms: list[dict[str, str]]) -> list[Typed]:
    names = [f"form{k}" for k in range(len(forms))]
    run = sandbox.run([SETUP, *(f"{name} = {form['python']}" for name, form in zip(names, forms, strict=True))], names)
    assert run.end == "done"
    return [
        Typed(form, run.answers.get(name), run.failures.get(name) or run.cell_errors.get(k + 1, ""))
        for k, (name, form) in enumerate(zip(names, forms, strict=True))
    ]


def outcome(one: Typed, number: int) -> tuple[str, str]:
    """Return what a form gets, and what is said of it."""
    if one.text is None:
        return ("stopped" if one.form["gets"] == "stopped" else "unreadable"), one.why
    judged = judge_given(*one.asked, one.given, f"forms/{number}")
    return ("refused" if one.given.refusal else judged.outcome.value), judged.reason


def test_every_form_gets_what_is_due(typed: list[Typed]) -> None:
    assert len({(one.form["part"], one.form["python"]) for one in typed}) == len(FORMS)
    found = [(one.form, *outcome(one, number)) for number, one in enumerate(typed)]
    assert [(form["python"], gets, said) for form, gets, said in found if gets != form["gets"]] == []
    assert [(form["python"], said) for form, _, said in found if not said.startswith(form["says"])] == []


def test_check_says_of_every_form_whether_the_grader_can_read_it(typed: list[Typed]) -> None:
    for one in typed:
        if one.text is not None:
            assert readable(one.text, *one.asked) == (one.given.refusal is None), one.form
