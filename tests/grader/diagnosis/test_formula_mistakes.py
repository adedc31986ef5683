"""Slips in finished formulas are named with their place, and what follows from a mistake has no second name."""

import re
from fractions import Fraction

import numpy as np
import pytest

from qdot.exercises.arm.derivation_graph import compute_symbolic_stages, to_sympy_matrix
from qdot.exercises.chapter import make_planar_2r
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, count_nodes, node_text
from qdot.exercises.mistakes.catalogue import CATALOGUE, apply_mistake
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.mistakes.finished import edit_entry, edit_throughout
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.results import compute_answer
from qdot.grader.diagnosis.formula_mistakes import locate_entries
from qdot.grader.marking.marking import MarkingRules, mark
from tests.support.judging import diagnose
from tests.support.problems import ask_question, get_problem
from tests.support.suites import few_families

PLANAR = make_planar_2r()
C1, S1, C12, S12 = "cos(theta1)", "sin(theta1)", "cos(theta1 + theta2)", "sin(theta1 + theta2)"


def jacobian(*entries: str) -> str:
    one, two, three, four = entries
    return f"Matrix([[{one}, {two}], [{three}, {four}]])"


RIGHT = (f"-a1*{S1} - a2*{S12}", f"-a2*{S12}", f"a1*{C1} + a2*{C12}", f"a2*{C12}")


@pytest.mark.parametrize(
    ("changed", "mistakes", "places"),
    [
        ({1: f"a2*{S12}"}, "term-sign-typed", "row 1, column 2"),
        ({0: f"-a1*{S1} - a2*{C12}"}, "trig-typed", "row 1, column 1"),
        ({2: f"a1*{C1} + {C12}"}, "factor-missing", "row 2, column 1|a2"),
        ({2: f"a1*{C1} + a2"}, "factor-missing", "row 2, column 1|theta1, theta2"),
        ({2: f"a2*{C12}"}, "term-missing", "row 2, column 1|a1"),
        ({0: f"-a2*{S12}", 2: f"a1*{C1}"}, "term-missing", "row 1, column 1|a1;row 2, column 1|a2"),
        ({3: "a2*cos(theta1 - theta2)"}, "angle-typed", "row 2, column 2|angle"),
        ({3: "a2*cos(theta1)*cos(theta2)"}, "sum-of-angles-split", "row 2, column 2|sum"),
        ({2: f"a1*{S1} + a2*{S12}"}, "trigs-typed", "row 2, column 1"),
        ({1: RIGHT[3], 3: RIGHT[1]}, "entries-exchanged", "row 1, column 2, and row 2, column 2"),
        (
            {1: "0", 2: f"a1*{C1} - a2*{C12}", 3: "0"}, "term-missing term-sign-typed",
            "row 1, column 2, and row 2, column 2;row 2, column 1",
        ),
        ({0: "0"}, "entry-missing", "row 1, column 1"),
        ({2: f"-a1*{C1} - a2*{C12}"}, "entry-sign", "row 2, column 1"),
        ({1: f"a2*{C12}"}, "trig-not-derived", "row 1, column 2"),
        ({1: f"-a2*{S12}*a1"}, "factor-surplus", "row 1, column 2|a1"),
        ({1: RIGHT[0]}, "term-surplus", "row 1, column 2|a1"),
        ({0: f"-(a1*{S1} + 3*a2*{S12})*2/2"}, "factor-surplus", "row 1, column 1"),
        ({2: f"1.7*a1*{C1} + 1.7*a2*{C12}"}, "entry-factor", "row 2, column 1"),
        ({0: f"-a1*{S1}*1.3 - a2*{S12}"}, "factor-surplus", "row 1, column 1"),
        ({3: f"a2*{C12} + 2"}, "term-surplus", "row 2, column 2"),
        ({1: f"-a2*sqrt(1 - {C12}^2)"}, "sign-lost", "row 1, column 2"),
        ({k: entry.replace("a1*", "").replace("a2*", "") for k, entry in enumerate(RIGHT)}, "lengths-missing", ""),
        ({k: f"-({entry})" for k, entry in enumerate(RIGHT)}, "sign", ""),  # no cross product in the wrong order
    ],
)  # fmt: skip
def test_what_went_wrong_in_entries_is_named_with_them(changed: dict[int, str], mistakes: str, places: str) -> None:
    problem = ask_question("jacobian", PLANAR)
    answer = jacobian(*(changed.get(k, entry) for k, entry in enumerate(RIGHT)))
    found = diagnose(problem, problem.parts[0], answer, "finished")
    assert found is not None and list(found.mistakes) == mistakes.split()
    for place in filter(None, places.split(";")):
        where, _, word = place.partition("|")
        assert re.search(rf"In {where}, [^.]*{word}", found.says), found.says


def test_relative_angles_throughout_an_entry_are_named() -> None:
    entry = parse_formula(f"a1*{C1} + a2*{C12} + a3*cos(theta1 + theta2 + theta3 + pi/6)", {})
    changed = [node_text(edit.entry) for edit in edit_entry(entry) if edit.mistake == "angles-typed"]
    due = parse_formula("a1*cos(theta1) + a2*cos(theta2) + a3*cos(theta3 + pi/6)", {})
    assert changed[0] == node_text(due)


def test_what_is_missing_is_told_by_its_lengths_rates_and_numbers_else_by_its_joints() -> None:
    entry = parse_formula(f"0.5*{C1} + a2*qd1*{C12} + {S1}*{S12}", {})
    told = {edit.missing_words for edit in edit_entry(entry) if edit.mistake == "term-missing"}
    assert told >= {" (with 0.5 in it)", " (with a2, qd1 in it)", " (with theta1, theta2 in it)"}
    assert {edit.missing_words for edit in edit_entry(entry) if edit.mistake == "trig-typed"} == {""}


def test_the_places_of_a_vector_are_told_by_number_and_a_single_formula_has_none() -> None:
    assert locate_entries([(0, 0), (2, 0)], (3, 1)) == "In entries 1 and 3"
    assert locate_entries([(0, 2)], (1, 3)) == "In entry 3"
    assert locate_entries([(0, 0)], (1, 1)) == "In your answer"


def values_of(rows: list[list[Node]], at: dict[str, np.ndarray]) -> np.ndarray:
    with np.errstate(all="ignore"):
        return evaluate(compile_program([entry for row in rows for entry in row]), at, 4)[0]


def as_typed(part: Part, rows: list[list[Node]]) -> str:
    if part.shape is None:
        return node_text(rows[0][0])
    return f"[{', '.join('[' + ', '.join(map(node_text, row)) + ']' for row in rows)}]"


@few_families
def test_every_slip_in_a_formula_of_any_arm_is_named(family: str) -> None:
    """By its name or by that of another mistake that gives the same: of each kind, the first that changes something."""
    problem = get_problem(family, 0)
    for part in problem.parts:
        if part.name not in ("position", "jacobian", "determinant"):
            continue
        rows = [list(row) for row in part.answer.parse_trees(problem.domain.roles)]
        at = sample_configurations(problem.chain, part, problem.domain, 4, Stream("finished"))
        right, tried = values_of(rows, at), set()
        i, j = max(
            ((i, j) for i, row in enumerate(rows) for j in range(len(row))), key=lambda w: count_nodes(rows[w[0]][w[1]])
        )
        for edit in edit_entry(rows[i][j]):
            other = [row[:] for row in rows]
            other[i][j] = edit.entry
            found = values_of(other, at)
            if edit.mistake in tried or not np.isfinite(found).all() or np.allclose(found, right, rtol=1e-9):
                continue
            if np.ptp(found[i * len(rows[0]) + j]) < 1e-9:  # a number that many slips give
                continue
            tried.add(edit.mistake)
            if count_nodes(edit.entry) > 150:
                continue
            answer = as_typed(part, other)
            assert diagnose(problem, part, answer, "finished") is not None, (part.name, edit.mistake, answer)


@few_families
def test_a_slip_throughout_is_named_on_any_arm(family: str) -> None:
    problem = get_problem(family, 0)
    part = next(part for part in problem.parts if part.name in ("jacobian", "joint-axes", "link-velocity"))
    rows = [list(row) for row in part.answer.parse_trees(problem.domain.roles)]
    at = sample_configurations(problem.chain, part, problem.domain, 4, Stream("finished"))
    right, tried = values_of(rows, at), set()
    for name, changed in edit_throughout(rows):
        found = values_of(changed, at)
        if name in tried or not np.isfinite(found).all() or np.allclose(found, right, rtol=1e-9):
            continue
        tried.add(name)
        answer = as_typed(part, changed)
        assert diagnose(problem, part, answer, "finished") is not None, (name, answer)


def test_a_mistake_that_later_parts_inherit_is_named_once() -> None:
    """A twist taken with the wrong sign: named in the joint axes, and told of the others as that."""
    problem = get_problem("elbow-3r", 0)
    names = ("joint-axes", "jacobian", "velocity")
    parts = {part.name: part for part in problem.parts if part.name in names}
    right = compute_symbolic_stages(problem.chain)
    slip = next(wrong.variant for wrong in apply_mistake(CATALOGUE["twist-sign"], right, parts["joint-axes"]))
    wrong = right.with_mistakes(slip.changes)
    answers = {}
    for name, part in parts.items():
        matrix = to_sympy_matrix(compute_answer(wrong, part))
        answers[name] = str(matrix[0, 0]) if part.shape is None else str(matrix.tolist())
    verdicts = {
        verdict.part: verdict for verdict in mark(problem, answers, secret="s", rules=MarkingRules(Fraction(0)))
    }
    told = {name: verdicts[name].diagnosis for name in names if name in parts}
    named = [name for name, diagnosis in told.items() if diagnosis is not None and diagnosis.mistakes]
    assert len(named) == 1, told
    first = named[0]
    for name, diagnosis in told.items():
        assert diagnosis is not None
        assert name == first or (diagnosis.inherited == first and "the same mistake as in" in diagnosis.says)
        assert name == first or not diagnosis.names


def test_a_square_that_is_missing_is_its_root_or_twice_its_root() -> None:
    found = [edit.entry for edit in edit_entry(parse_formula("x^2"), ["x"]) if edit.mistake == "square-missing"]
    assert [node_text(entry) for entry in found] == ["x", "(2*x)"]
