"""Judge answers that are Python functions by their values at random points.

A function that accepts symbols is converted to a formula in the sandbox and is not judged here (see `callables`). The
values judged here are double-precision numbers from the student's code, which can't be recomputed with more digits.
They must be correct to nine digits, relative to the size of the terms, or within the assignment's tolerance. Nobody
knows the points beforehand.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.identity import (
    Certificate,
    Comparison,
    Domain,
    EntryDifference,
    Rounding,
    chance_of_missing,
    tell_apart,
)
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import names
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.judging.answer import Table
from qdot.grader.judging.formulas import matrix_judgement
from qdot.grader.judging.verdict import Judgement, wrong
from qdot.grader.sandbox.contained.callables import TABLE
from qdot.grader.sandbox.sandbox import Calls

POINTS = 50
NINE_DIGITS = 1e-9
SHOWN = f"a Python function; its values at {POINTS} random configurations were compared"


def calls_of(problem: Problem, domain: Domain, seed: str) -> Calls:
    """Return the arguments of the calls of a student's function: the joints, and all symbols with their values."""
    values = _points(domain, seed)
    symbols = tuple(sorted(values))
    points = np.array([values[symbol] for symbol in symbols]).T.tolist()
    return Calls(tuple(q.name for q in problem.chain.q), symbols, tuple(map(tuple, points)))


def _points(domain: Domain, seed: str) -> dict[str, np.ndarray]:
    return domain.sample(set(domain.roles), POINTS, Stream(hashlib.sha256(seed.encode()).hexdigest()))


def is_table(answer: str) -> bool:
    """Return whether an answer is a table of the values of a Python function."""
    return answer.startswith(TABLE)


def read_table(text: str, domain: Domain, seed: str) -> Table:
    """Parse the values of a function at the points that `seed` determines."""
    return Table(*table_values(text), _points(domain, seed))


def constant_text(text: str) -> str | None:
    """Return the text of a matrix if a function has the same value at all points, else None."""
    shape, values = table_values(text)
    if shape is None or not np.all(values == values[0]) or np.any(values.imag != 0):
        return None
    entries = np.array([repr(float(value)) for value in values[0].real], dtype=object).reshape(shape)
    return str(entries.tolist()).replace("'", "")


def table_values(answer: str) -> tuple[tuple[int, ...] | None, np.ndarray]:
    """Return the shape and values (points, entries) of a table; (None, no values) if the text is not a table."""
    try:
        content = json.loads(answer.removeprefix(TABLE))
        shape = tuple(int(size) for size in content["shape"])
        pairs = np.array(content["values"], dtype=float)
        if pairs.ndim == 3 and pairs.shape[2] == 2 and pairs.shape[1] == int(np.prod(shape)) and len(shape) <= 2:
            return shape, pairs[..., 0] + 1j * pairs[..., 1]
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        pass
    return None, np.zeros((0, 0))


def judge_function(part: Part, table: Table, joints: Sequence[str], known: Iterable[str]) -> Judgement:
    """Judge the values of a function of the `joints`. A malformed table was typed by the student, and is wrong."""
    if not part.answer.entries():
        return wrong("a function of the configuration stands where no formula is due")
    reference = part.answer.trees(known)
    nodes, expected_shape = [entry for row in reference for entry in row], (len(reference), len(reference[0]))
    shape, values = table.shape, table.values
    if shape is None or len(values) != POINTS:
        return wrong("these are no values of a function")
    is_matrix = len(shape) == 2 and 1 not in shape
    if values.shape[1] != len(nodes) or (is_matrix and shape != expected_shape):
        returned_words = " x ".join(map(str, shape)) or "one number"
        return wrong(f"the function returns {returned_words}, and {expected_shape[0]} x {expected_shape[1]} is due")
    expected, size = evaluate(compile_program(nodes), table.at, POINTS)
    answer_values = _scale_to(expected, values.T) if part.answer.counts_up_to_a_factor else values.T
    shown_names = set(joints).union(*map(names, nodes))
    at = {name: column for name, column in table.at.items() if name in shown_names}
    return matrix_judgement(_compare(answer_values, expected, size, at, part.rounding), [False] * len(nodes), reference)


def _scale_to(expected: np.ndarray, answered: np.ndarray) -> np.ndarray:
    """Return the vectors scaled by the factors that bring them closest to the expected ones."""
    with np.errstate(all="ignore"):
        factor = np.sum(expected * answered.conj(), axis=0) / np.sum(np.abs(answered) ** 2, axis=0)
        return np.asarray(answered * factor)


def _compare(
    answered: np.ndarray,
    expected: np.ndarray,
    size: np.ndarray,
    at: Mapping[str, np.ndarray],
    rounding: Rounding | None,
) -> Comparison:
    relative, absolute = (rounding.relative, rounding.absolute) if rounding is not None else (0.0, 0.0)
    with np.errstate(all="ignore"):
        largest = np.nanmax(np.where(np.isfinite(size), size, 0.0), axis=0)
        scale = np.where(size > 0, size, np.where(largest > 0, largest, 1.0))
        is_within = np.abs(answered - expected) <= max(NINE_DIGITS, relative) * scale + absolute
    defined = np.isfinite(expected)
    is_correct = [
        bool(np.all(same[is_defined]) and np.any(is_defined))
        for same, is_defined in zip(is_within, defined, strict=True)
    ]
    example = None
    if not all(is_correct):
        entry = is_correct.index(False)
        point = int(np.argmax(~is_within[entry] & defined[entry]))
        yours, right_value = tell_apart(complex(answered[entry, point]), complex(expected[entry, point]))
        values = {name: float(f"{column[point]:.6g}") for name, column in sorted(at.items())}
        example = EntryDifference(entry, values, yours, right_value)
    return Comparison(tuple(is_correct), Certificate("numeric", POINTS, chance_of_missing(POINTS), example))
