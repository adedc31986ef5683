"""Judge an answer that is a Python function by its values at points which no one knows before.

What comes here are doubles from code that is not ours, so that nothing is left to look at with more digits: they must
be right to nine digits of the size of the terms, or as the assignment allows.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from qdot.exercises.formula.identity import Certificate, Comparison, EntryDifference, Rounding, missed, told_apart
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import names
from qdot.exercises.problem.problem import Part
from qdot.grader.judging.formulas import matrix_judgement
from qdot.grader.judging.function_values import POINTS, Table
from qdot.grader.judging.verdict import Judgement, wrong

NINE_DIGITS = 1e-9


def judge_function(part: Part, table: Table, joints: Sequence[str], known: Iterable[str]) -> Judgement:
    """Judge the values of a function of the `joints`. A table that is none is the student's own making."""
    if not part.answer.entries():
        return wrong("a function of the configuration stands where no formula is due")
    due_rows = part.answer.trees(known)
    nodes, due_shape = [entry for row in due_rows for entry in row], (len(due_rows), len(due_rows[0]))
    shape, values = table.shape, table.values
    if shape is None or len(values) != POINTS:
        return wrong("these are no values of a function")
    if values.shape[1] != due_shape[0] * due_shape[1] or (len(shape) == 2 and 1 not in shape and shape != due_shape):
        returned = " x ".join(map(str, shape)) or "one number"
        return wrong(f"the function returns {returned}, and {due_shape[0]} x {due_shape[1]} is due")
    due, size = evaluate(compile_program(nodes), table.at, POINTS)
    answered = _along(values.T, due) if part.answer.counts_up_to_a_factor else values.T
    shown = set(joints).union(*map(names, nodes))
    at = {name: column for name, column in table.at.items() if name in shown}
    return matrix_judgement(_compared(answered, due, size, at, part.rounding), [False] * len(nodes), due_rows)


def _along(found: np.ndarray, due: np.ndarray) -> np.ndarray:
    """Return vectors scaled and turned to be compared with those that are due, if they lie along them."""
    with np.errstate(all="ignore"):
        factor = np.sum(due * found.conj(), axis=0) / np.sum(np.abs(found) ** 2, axis=0)
        return np.asarray(found * factor)


def _compared(
    found: np.ndarray, due: np.ndarray, size: np.ndarray, at: Mapping[str, np.ndarray], rounding: Rounding | None
) -> Comparison:
    relative, absolute = (rounding.relative, rounding.absolute) if rounding is not None else (0.0, 0.0)
    with np.errstate(all="ignore"):
        largest = np.nanmax(np.where(np.isfinite(size), size, 0.0), axis=0)
        scale = np.where(size > 0, size, np.where(largest > 0, largest, 1.0))
        right = np.abs(found - due) <= max(NINE_DIGITS, relative) * scale + absolute
    defined = np.isfinite(due)
    equal = [bool(np.all(same[there]) and np.any(there)) for same, there in zip(right, defined, strict=True)]
    example = None
    if not all(equal):
        entry = equal.index(False)
        point = int(np.argmax(~right[entry] & defined[entry]))
        yours, expected = told_apart(complex(found[entry, point]), complex(due[entry, point]))
        values = {name: float(f"{column[point]:.6g}") for name, column in sorted(at.items())}
        example = EntryDifference(entry, values, yours, expected)
    return Comparison(tuple(equal), Certificate("numeric", POINTS, missed(POINTS), example))
