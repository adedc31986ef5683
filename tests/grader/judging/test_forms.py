"""Typed answers: every form in tests/data/forms.jsonl gets the outcome stated there.

`where` is "cell" for Python in a notebook, "text" for an answer box. `gets` is the outcome: "refused" is parsed but of
a form other than expected, "unreadable" is a value that is not a formula, "stopped" is a cell that raises. The message
to the student begins with `says`. `right` is the right answer if it differs from the problem's.
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
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.functions import sample_function_arguments
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
    return get_problem("planar-2r", 0, "chapter")


def part_of(form: Mapping[str, Any]) -> Part:
    part = problem()[form["part"]]
    answer = part.answer
    if "right" in form and isinstance(answer, Number):
        answer = replace(answer, reference=sp.Matrix([sp.Float(value, 12) for value in form["right"]]))
    elif "right" in form:
        assert isinstance(answer, Choice)
        answer = replace(answer, correct=LETTERS.index(form["right"]))
    return replace(part, answer=answer)


@dataclass(frozen=True)
class TypedAnswer:
    """A form with the text that left the notebook or the box, or the reason why there is none."""

    form: Mapping[str, Any]
    text: str | None
    failure: str = ""

    @property
    def parsed(self) -> ParsedAnswer:
        assert self.text is not None
        return read_answer(problem(), part_of(self.form), self.text, SEED)


BATCH = 12
"""The number of forms in a notebook. It is small, because after every cell the sandbox reads all answers again."""


@pytest.fixture(scope="module")
def typed(sandbox: Sandbox) -> list[TypedAnswer]:
    """Run all forms, in `make test` every third; each Python form has a cell to itself."""
    cells, texts = CELLS[:: select_for_suite(3, 1)], TEXTS[:: select_for_suite(3, 1)]
    runs = (run_in_notebook(sandbox, cells[begin : begin + BATCH]) for begin in range(0, len(cells), BATCH))
    return [*(answer for run in runs for answer in run), *(TypedAnswer(form, form["typed"]) for form in texts)]


def run_in_notebook(sandbox: Sandbox, forms: list[dict[str, Any]]) -> list[TypedAnswer]:
    slots = [f"p{k}" for k in range(len(forms))]
    names = [f"{slot}_form" for slot in slots]
    calls = dict.fromkeys(slots, sample_function_arguments(problem(), problem().domain, SEED))
    cells = [SETUP, *(f"{name} = {form['typed']}" for name, form in zip(names, forms, strict=True))]
    run = sandbox.run(cells, names, calls)
    assert run.end == "done"
    return [
        TypedAnswer(form, run.answers.get(name), run.unreadable_reasons.get(name) or run.cell_errors.get(k + 1, ""))
        for k, (name, form) in enumerate(zip(names, forms, strict=True))
    ]


def judge_typed(answer: TypedAnswer, number: int) -> tuple[str, str]:
    if answer.text is None:
        return ("stopped" if answer.form["gets"] == "stopped" else "unreadable"), answer.failure
    parsed = answer.parsed
    judgement = judge_parsed(problem(), part_of(answer.form), parsed, f"forms/{number}")
    return ("refused" if parsed.refusal else judgement.outcome.value), judgement.reason


def test_every_form_gets_its_outcome_and_message(typed: list[TypedAnswer]) -> None:
    judged = [(answer.form, *judge_typed(answer, number)) for number, answer in enumerate(typed)]
    assert [(form["typed"], got, message) for form, got, message in judged if got != form["gets"]] == []
    failures = [(f["typed"], message) for f, _, message in judged if not message.startswith(f["says"])]
    assert not failures, "\n".join(map(str, failures))


def test_check_agrees_with_the_grader_on_what_is_readable(typed: list[TypedAnswer]) -> None:
    metadata = make_notebook_metadata("student", "hw", "ada", [("p1", problem())])
    for answer in typed:
        if answer.text is not None:
            part = part_of(answer.form)
            form = find_claimed_form(metadata, "p1", part.name)
            has_unknown_symbols = not part.answer.is_set and answer.parsed.symbols - set(problem().domain.roles)
            is_gradable = answer.parsed.refusal is None and not has_unknown_symbols
            assert form is not None and is_readable(answer.text, form) == is_gradable, answer.form


def test_the_corpus_is_large_and_covers_every_part_and_outcome() -> None:
    assert len(FORMS) >= 600
    assert len({(form["part"], form["where"], form["typed"], str(form.get("right"))) for form in FORMS}) == len(FORMS)
    assert {form["part"] for form in FORMS} == {part.name for part in problem().parts}
    assert {form["gets"] for form in FORMS} == {"correct", "partial", "wrong", "refused", "unreadable", "stopped"}
