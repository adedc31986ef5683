"""A notebook's checks of its own answers: what fits, what does not, and what is said of forms that can't be judged."""

import contextlib
import io
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.answers import Expression, Matrix
from exercises.arm.chain import TWIST_ORDERS
from exercises.arm.told import is_by_axes
from exercises.families import FAMILIES
from exercises.notebook import student_notebook
from exercises.problem import Problem, variable
from exercises.self_check import RELATIONS, check_cell, function_cell
from tests.support.problems import drawn
from tests.support.suites import of_families

T1, T2, A1, A2 = sp.symbols("theta1 theta2 a1 a2")
POSITION = sp.Matrix([A1 * sp.cos(T1) + A2 * sp.cos(T1 + T2), A1 * sp.sin(T1) + A2 * sp.sin(T1 + T2)])
JACOBIAN = POSITION.jacobian([T1, T2])
ANSWERS = {"position": POSITION, "jacobian": JACOBIAN, "determinant": A1 * A2 * sp.sin(T2)}
DERIVATIVE = "Is your Jacobian the derivative of your position?"
SINGULAR = "Are these the singular configurations of your Jacobian?"


@cache
def _plain() -> Problem:
    """The plain arm of Example 6.1: a1 and a2 are symbols."""
    return drawn("planar-2r", 0, "chapter")


def _space(problem: Problem) -> dict[str, Any]:
    space: dict[str, Any] = {}
    notebook = student_notebook("t", "k", "s", [("p1", problem)])
    for cell in notebook.cells:
        if cell.id in ("setup", "self-check"):
            exec(cell.source, space)
    return space


def _told(
    problem: Problem, answers: dict[str, Any], about: str = "", space: dict[str, Any] | None = None
) -> dict[str, str]:
    """Return what is said of each question: the references with other answers for some parts.

    Of one question alone it is what the cells say that ask it; what a notebook has set may be given, to be used again.
    """
    space = _space(problem) if space is None else space
    for part in problem.parts:
        space[variable("p1", part.name)] = answers.get(part.name, getattr(part.answer, "reference", None))
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for part in problem.parts:
            if (cell := check_cell("p1", problem, part.name)) and about in cell:
                exec(cell, space)
    told: dict[str, str] = {}
    for line in printed.getvalue().splitlines():
        question, sign, said = line.partition("? ")
        if sign:
            told[question + "?"] = said
        else:
            last = "look again" if line.startswith("Look again") else next(reversed(told))
            told[last] = told.get(last, "") + line
    return told


def test_every_relation_is_checked_for_some_family() -> None:
    asked = [drawn(name, 0, step) for name in ("planar-2r", "planar-3r") for step in ("chapter", "full")]
    asked += [drawn("planar-2r", 0, "chapter", convention="screws")]
    cells = "".join(check_cell("p1", problem, part.name) for problem in asked for part in problem.parts)
    assert [relation.question for relation in RELATIONS if relation.question not in cells] == []


def _sabotaged(problem: Problem) -> Iterator[tuple[str, str, Any]]:
    """Yield each relation's question with one of its answers gone wrong in one entry."""
    for relation in RELATIONS:
        cells = "".join(check_cell("p1", problem, part.name) for part in problem.parts)
        if relation.question not in cells or relation.singular:
            continue
        name = relation.needs[-1]
        answer = next(part.answer for part in problem.parts if part.name == name)
        assert isinstance(answer, (Expression, Matrix))
        wrong = sp.Matrix([answer.reference])
        compared = [at for at in np.ndindex(*wrong.shape) if at[1] == 0 or "first column of" not in relation.question]
        if "linear rows" in relation.question and is_by_axes(problem.chain):
            compared = [at for at in compared if at[0] > 2]
        row, column = next(at for at in compared if wrong[at] != 0)
        if "angular" in relation.question:
            wrong[0 if is_by_axes(problem.chain) else 3, 0] += sp.Rational(1, 10)
        else:
            wrong[row, column] *= sp.Rational(-9, 10)
        yield relation.question, name, wrong


@pytest.mark.parametrize("convention", ["dh", "screws"])
@of_families(list(FAMILIES))
def test_an_entry_gone_wrong_does_not_fit(family: str, convention: str) -> None:
    problem = drawn(family, 0, convention=convention)
    space = _space(problem)
    for question, name, wrong in _sabotaged(problem):
        assert _told(problem, {name: wrong}, question, space)[question].startswith("No."), question


@pytest.mark.parametrize("twist_order", TWIST_ORDERS)
@of_families(list(FAMILIES))
def test_right_answers_of_an_arm_told_by_axes_fit(family: str, twist_order: str) -> None:
    told = _told(drawn(family, 1, convention="screws", twist_order=twist_order), {})
    assert {said for question, said in told.items() if question != SINGULAR} <= {
        "Yes; what both rest on may still be wrong."
    }


def test_where_it_does_not_fit_is_told() -> None:
    wrong = JACOBIAN.copy()
    wrong[1, 0] = -wrong[1, 0]
    said = _told(_plain(), {**ANSWERS, "jacobian": wrong})[DERIVATIVE]
    assert said.startswith("No. At theta1 = ") and "row 2, column 1: " in said and "row 1" not in said
    assert "2 x 1 and 2 x 2" in _told(_plain(), {**ANSWERS, "jacobian": JACOBIAN[:, 0]})[DERIVATIVE]


FORMS = [
    ["a1*cos(theta1) + a2*cos(theta1 + theta2)", "a1*s1 + a2*s12"], "[a1 c1 + a2 c12, a1 s1 + a2 s12]",
    "[a1*cos(\u03b81) + a2*c12, a1*s1 + a2*s12]", [POSITION[0], POSITION[1]], tuple(POSITION),
    [[POSITION[0]], [POSITION[1]]], {"x": POSITION[0], "y": POSITION[1]}, np.array([POSITION[0], POSITION[1]]),
    sp.ImmutableMatrix(POSITION),
    POSITION.subs({T1: sp.Symbol("theta1", real=True), A1: sp.Symbol("a1", positive=True)}),
    lambda theta1, theta2: list(POSITION.subs({T1: theta1, T2: theta2})),
    sp.Matrix([sp.Integral(-A1 * sp.sin(T1), T1) + A2 * sp.cos(T1 + T2), POSITION[1]]), sp.Tuple(*POSITION),
    POSITION.T, [sp.Matrix([POSITION[0]]), sp.Matrix([POSITION[1]])],
]  # fmt: skip


def test_forms_that_the_grader_takes_fit() -> None:
    columns = [JACOBIAN[:, 0], JACOBIAN[:, 1]]
    for changed in (*({"position": form} for form in FORMS), {"jacobian": columns}):
        assert _told(_plain(), {**ANSWERS, **changed}, DERIVATIVE)[DERIVATIVE].startswith("Yes"), changed


OTHER_FORMS: list[tuple[Any, str]] = [
    ("a1 cos 30\u00b0", "can't be told"),
    (sp.Matrix([sp.nan, POSITION[1]]), "No."),  # what is nowhere a number does not fit
    ([sp.Symbol("l1") * sp.cos(T1), A1], "no symbol of this problem is l1"),
    (["a1*s14", "a2"], "what s14 is"),
    (lambda t, u: [t, u], "no symbol of this problem is t, u"),
    (sp.Matrix([sp.Symbol("blank"), A1]), "Not yet"),
    (None, "can't be told"),
    (object(), "can't be told"),
    (sp.Eq(T1, 0) & sp.Eq(T2, 0), "can't be told"),
    (sp.Array([[[A1, A2]], [[A1, A2]]]), "can't be told"),
    ([[A1, A2], [A1]], "can't be told"),
    (sp.Matrix([A1, A2, T1, T2]), "2 x 2 and 4 x 2"),
]


def test_of_other_forms_it_is_said_that_they_are_not_judged() -> None:
    for position, why in OTHER_FORMS:
        assert why in _told(_plain(), {**ANSWERS, "position": position}, DERIVATIVE)[DERIVATIVE], position


def test_degrees_in_a_sine_are_seen_though_both_answers_fit() -> None:
    position = sp.Matrix([A1 * sp.cos(T1 + 30), A1 * sp.sin(T1 + 30)])
    told = _told(_plain(), {"position": position, "jacobian": position.jacobian([T1, T2])})
    assert told[DERIVATIVE].startswith("Yes") and "30 in sin or cos; angles are in radians" in told["look again"]
    assert "look again" not in _told(_plain(), ANSWERS)


CONDITIONS: list[tuple[Any, str]] = [
    ([sp.Eq(sp.sin(T2), 0)], "Yes"), ([sp.Eq(T2, 0), sp.Eq(T2, sp.pi)], "Yes"),
    ([sp.Eq(T2, 0), sp.Eq(T2, -sp.pi)], "Yes"), ([{T2: [0, sp.pi]}], "Yes"), ({T2: [0, sp.pi]}, "Yes"),
    (sp.Or(sp.Eq(T2, 0), sp.Eq(T2, sp.pi)), "Yes"), ([sp.sin(T2)], "sin(theta2) is no condition"),
    ([sp.Eq(sp.cos(T2), 1), sp.Eq(sp.cos(T2), -1)], "Yes"), ([sp.Eq(2 * T2, 0), sp.Eq(T2, sp.pi)], "Yes"),
    ([sp.Eq(sp.cos(T2), 2)], "no configuration was found"),
    ([sp.Eq(T2, 0)], "Not all. Your Jacobian loses rank here, too"),
    ([sp.Eq(T2, sp.pi / 2)], "No. There theta2 = pi/2, and your Jacobian keeps its rank"),
    ([sp.And(sp.Eq(T2, 0), sp.Eq(T1, 0)), sp.Eq(T2, sp.pi)], "Not all."), ([sp.Eq(T1, sp.pi / 2)], "No. "),
    ([0, sp.pi], "numbers without a joint"), ([False], "or of False"), ("theta2 = 0", "not told of text"),
    ([sp.Symbol("blank")], "Not yet"), ([sp.Eq(T2, sp.pi * sp.Symbol("k"))], "no symbol of this problem is k"),
]  # fmt: skip


def test_singular_configurations_are_put_into_the_own_jacobian() -> None:
    for conditions, said in CONDITIONS:
        told = _told(_plain(), {**ANSWERS, "singular-angles": conditions}, SINGULAR)[SINGULAR]
        assert said in told or (said == "not told of text" and "qdot check" in told), conditions


def test_a_problem_of_short_questions_has_no_function_for_checks() -> None:
    problem = drawn("planar-2r", 0)
    quiz = Problem(problem.id, problem.chain, tuple(p for p in problem.parts if p.name == "rank"))
    assert function_cell([("p1", quiz)]) == ""
    assert not any(cell.id == "self-check" for cell in student_notebook("t", "k", "s", [("p1", quiz)]).cells)
