"""Compute the answer to a part from the stages of a derivation, correct or with mistakes in it."""

import re
from collections.abc import Iterable

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation.arithmetic import TreeArithmetic, determinant, list_rows
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.derivation.graph import RESULT, StageResults
from qdot.exercises.formula.trees import Node
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import find_question
from qdot.exercises.reference_answers import Matrix


def is_derived_step_by_step(part: Part) -> bool:
    """Return whether the answer to a part is computed from the stages of a derivation."""
    return (question := find_question(part)) is not None and question.compute is not None


def is_made_of_jacobian(part: Part) -> bool:
    """Return whether the answer to a part is derived from a given Jacobian."""
    return (question := find_question(part)) is not None and question.is_made_of_jacobian


def _is_made_of_minors(part: Part) -> bool:
    return (question := find_question(part)) is not None and question.is_made_of_minors


def is_product(part: Part) -> bool:
    """Return whether the answer to a part is a product whose factors are compared, such as a determinant."""
    return _is_made_of_minors(part) and part.shape is None


def solves_equations(part: Part) -> bool:
    """Return whether the answer to a part solves linear equations, so that it can be checked by substitution."""
    question = find_question(part)
    is_solution = question is not None and re.search(r"\b(?:inv|least_norm)\(", question.typed_formula) is not None
    return part.answer.is_direction or is_solution


def find_determinant_in_denominator(chain: Chain, part: Part, symbol_names: Iterable[str]) -> Node | None:
    """Return det J as a formula tree if it is the denominator of an answer's entries, as in the inverse; else None.

    `symbol_names` are the names of the problem's symbols.
    """
    if not _is_made_of_minors(part) or part.shape is None or not chain.has_square_jacobian:
        return None
    jacobian = Matrix(derive(chain).jacobian).parse_trees(symbol_names)
    return list_rows(determinant(TreeArithmetic.stack_rows(jacobian)))[0][0]


def compute_answer(stages: StageResults, part: Part) -> np.ndarray:
    """Return the answer to a part that follows from a derivation and its mistakes, (rows, columns, …).

    Mistakes in the final result (RESULT) are applied last. Raises TypeError if the answer to the part is not computed
    from the stages of a derivation.
    """
    question = find_question(part)
    if question is None or question.compute is None:
        raise TypeError(f"the answer to {part.kind!r} is not computed by a derivation")
    answer = question.compute(stages, part.details)
    answer = answer[:, None] if answer.ndim == 2 else answer
    for name, change in stages.changes:
        answer = change(stages, answer) if name == RESULT else answer
    return answer
