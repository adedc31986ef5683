"""Mistakes in finished formulas are named with their place, and a mistake inherited by later parts is named once."""

from fractions import Fraction

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_symbolic_stages, to_sympy_matrix
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, count_nodes, format_tree
from qdot.exercises.mistakes.catalogue import CATALOGUE, apply_mistake
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.mistakes.formula_edits import edit_all_entries, edit_entry
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.results import compute_answer
from qdot.grader.diagnosis.formula_mistakes import locate_entries
from qdot.grader.marking.marking import MarkingRules, mark
from tests.support.judging import diagnose
from tests.support.problems import get_problem
from tests.support.suites import few_families

C1, S1, C12, S12 = "cos(theta1)", "sin(theta1)", "cos(theta1 + theta2)", "sin(theta1 + theta2)"


def test_relative_angles_in_a_whole_entry_are_one_mistake() -> None:
    entry = parse_formula(f"a1*{C1} + a2*{C12} + a3*cos(theta1 + theta2 + theta3 + pi/6)", {})
    changed = [format_tree(edit.entry) for edit in edit_entry(entry) if edit.mistake == "angles-typed"]
    expected = parse_formula("a1*cos(theta1) + a2*cos(theta2) + a3*cos(theta3 + pi/6)", {})
    assert changed[0] == format_tree(expected)


def test_a_missing_term_is_described_by_its_symbols() -> None:
    entry = parse_formula(f"0.5*{C1} + a2*qd1*{C12} + {S1}*{S12}", {})
    descriptions = {edit.missing_words for edit in edit_entry(entry) if edit.mistake == "term-missing"}
    assert descriptions >= {" that contains 0.5", " that contains a2 and qd1", " that contains theta1 and theta2"}
    assert {edit.missing_words for edit in edit_entry(entry) if edit.mistake == "trig-typed"} == {""}


def test_entries_are_located_by_row_and_column_or_number() -> None:
    assert locate_entries([(0, 0), (2, 0)], (3, 1)) == "In each of the entries 1 and 3,"
    assert locate_entries([(0, 2)], (1, 3)) == "In entry 3,"
    assert locate_entries([(0, 0)], (1, 1)) == "In your answer,"


def evaluate_rows(rows: list[list[Node]], values: dict[str, np.ndarray]) -> np.ndarray:
    with np.errstate(all="ignore"):
        return evaluate(compile_program([entry for row in rows for entry in row]), values, 4).values


def is_different(values: np.ndarray, right: np.ndarray) -> bool:
    return bool(np.isfinite(values).all()) and not np.allclose(values, right, rtol=1e-9)


def write_rows(part: Part, rows: list[list[Node]]) -> str:
    if part.shape is None:
        return format_tree(rows[0][0])
    return f"[{', '.join('[' + ', '.join(map(format_tree, row)) + ']' for row in rows)}]"


@few_families
def test_every_mistake_in_one_entry_is_diagnosed_on_every_arm(family: str) -> None:
    """Diagnose the first edit of each kind that changes the answer; another name for the same answer counts, too."""
    problem = get_problem(family, 0)
    for part in problem.parts:
        if part.name not in ("position", "jacobian", "determinant"):
            continue
        rows = [list(row) for row in part.answer.parse_trees(problem.domain.roles)]
        values = sample_configurations(problem.chain, part, problem.domain, 4, Stream("finished"))
        right, tried = evaluate_rows(rows, values), set()
        i, j = max(
            ((i, j) for i, row in enumerate(rows) for j in range(len(row))),
            key=lambda at: count_nodes(rows[at[0]][at[1]]),
        )
        for edit in edit_entry(rows[i][j]):
            wrong_rows = [row[:] for row in rows]
            wrong_rows[i][j] = edit.entry
            wrong_values = evaluate_rows(wrong_rows, values)
            if edit.mistake in tried or not is_different(wrong_values, right):
                continue
            if np.ptp(wrong_values[i * len(rows[0]) + j]) < 1e-9:  # a constant, which many mistakes give
                continue
            tried.add(edit.mistake)
            if count_nodes(edit.entry) > 150:
                continue
            answer = write_rows(part, wrong_rows)
            assert diagnose(problem, part, answer, "finished") is not None, (part.name, edit.mistake, answer)


@few_families
def test_every_mistake_throughout_an_answer_is_diagnosed_on_every_arm(family: str) -> None:
    problem = get_problem(family, 0)
    part = next(part for part in problem.parts if part.name in ("jacobian", "joint-axes", "link-velocity"))
    rows = [list(row) for row in part.answer.parse_trees(problem.domain.roles)]
    values = sample_configurations(problem.chain, part, problem.domain, 4, Stream("finished"))
    right, tried = evaluate_rows(rows, values), set()
    for name, changed in edit_all_entries(rows):
        wrong_values = evaluate_rows(changed, values)
        if name in tried or not is_different(wrong_values, right):
            continue
        tried.add(name)
        answer = write_rows(part, changed)
        assert diagnose(problem, part, answer, "finished") is not None, (name, answer)


def test_an_inherited_mistake_is_named_once() -> None:
    """A wrong sign of a twist is named in the joint axes; later parts refer to it."""
    problem = get_problem("elbow-3r", 0)
    names = ("joint-axes", "jacobian", "velocity")
    parts = {part.name: part for part in problem.parts if part.name in names}
    right = compute_symbolic_stages(problem.chain)
    variant = next(answer.variant for answer in apply_mistake(CATALOGUE["twist-sign"], right, parts["joint-axes"]))
    wrong_stages = right.with_mistakes(variant.changes)
    answers = {}
    for name, part in parts.items():
        matrix = to_sympy_matrix(compute_answer(wrong_stages, part))
        answers[name] = str(matrix[0, 0]) if part.shape is None else str(matrix.tolist())
    verdicts = {
        verdict.part: verdict for verdict in mark(problem, answers, secret="s", rules=MarkingRules(Fraction(0)))
    }
    diagnoses = {name: verdicts[name].diagnosis for name in names if name in parts}
    named = [name for name, diagnosis in diagnoses.items() if diagnosis is not None and diagnosis.mistakes]
    assert len(named) == 1, diagnoses
    first = named[0]
    for name, diagnosis in diagnoses.items():
        assert diagnosis is not None
        assert name == first or (diagnosis.inherited == first and "the same mistake as in" in diagnosis.feedback)
        assert name == first or not diagnosis.names


def test_a_missing_square_leaves_the_root_or_twice_the_root() -> None:
    entries = [edit.entry for edit in edit_entry(parse_formula("x^2"), ["x"]) if edit.mistake == "square-missing"]
    assert [format_tree(entry) for entry in entries] == ["x", "(2*x)"]
