"""Judge answers that are Python functions by their values at random configurations.

The sandbox calls the function (`notebook_process.function_answers`). A function that accepts symbols is converted to a
formula, which is not judged here. A function that accepts only numbers becomes a table of values: JSON after a prefix.

The values are double-precision numbers from the student's code; qdot can't recompute them with more digits. They must
be correct to nine digits, relative to the size of the terms, or within the assignment's tolerance. Students can't know
the configurations beforehand.
"""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import equality
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import find_names
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.judging.answer_parser import FunctionValues
from qdot.grader.judging.formulas import judge_compared_matrix
from qdot.grader.judging.verdict import Judgement, make_wrong_judgement
from qdot.grader.sandbox.notebook_process.function_answers import TABLE_PREFIX
from qdot.grader.sandbox.sandbox import FunctionArguments

SAMPLE_COUNT = 50
"""Number of configurations at which a function is called."""
RELATIVE_TOLERANCE = 1e-9
"""Allowed error of a value, relative to the size of the terms in the correct answer (the reference)."""
FUNCTION_TEXT = f"a Python function; its values at {SAMPLE_COUNT} random configurations were compared"


def sample_function_arguments(problem: Problem, domain: equality.Domain, seed: str) -> FunctionArguments:
    """Return the arguments with which a student's function is called: the joints, and all symbols with their values.

    `domain` contains the symbols of the problem.
    """
    values = _sample_points(domain, seed)
    symbols = tuple(sorted(values))
    points = np.array([values[symbol] for symbol in symbols]).T.tolist()
    return FunctionArguments(tuple(q.name for q in problem.chain.q), symbols, tuple(map(tuple, points)))


def _sample_points(domain: equality.Domain, seed: str) -> dict[str, np.ndarray]:
    """Return `SAMPLE_COUNT` random values of each symbol."""
    return domain.sample(set(domain.roles), SAMPLE_COUNT, Stream(hashlib.sha256(seed.encode()).hexdigest()))


def is_function_table(answer: str) -> bool:
    """Return whether an answer is a table of the values of a Python function."""
    return answer.startswith(TABLE_PREFIX)


def read_table(text: str, domain: equality.Domain, seed: str) -> FunctionValues:
    """Parse a table of the values of a function at the configurations that `seed` determines."""
    return FunctionValues(*parse_table(text), _sample_points(domain, seed))


def find_constant_value(text: str) -> str | None:
    """Return the value of a function as the text of a matrix if all values in a table are equal; otherwise None."""
    shape, values = parse_table(text)
    if shape is None or not np.all(values == values[0]) or np.any(values.imag != 0):
        return None
    entries = np.array([repr(float(value)) for value in values[0].real], dtype=object).reshape(shape)
    return str(entries.tolist()).replace("'", "")


def parse_table(answer: str) -> tuple[tuple[int, ...] | None, np.ndarray]:
    """Return the shape of a single value in a table, and all values, an array of shape (points, entries).

    Return None and no values if the table is malformed: a student may have typed the prefix.
    """
    with suppress(ValueError, TypeError, KeyError, OverflowError, RecursionError):
        content = json.loads(answer.removeprefix(TABLE_PREFIX))
        shape = tuple(int(size) for size in content["shape"])
        pairs = np.array(content["values"], dtype=float)
        if pairs.ndim == 3 and pairs.shape[2] == 2 and pairs.shape[1] == int(np.prod(shape)) and len(shape) <= 2:
            return shape, pairs[..., 0] + 1j * pairs[..., 1]
    return None, np.zeros((0, 0))


def judge_function(
    part: Part, function_values: FunctionValues, joints: Sequence[str], symbol_names: Iterable[str]
) -> Judgement:
    """Judge the values of a student's function. A malformed table is wrong.

    Counterexamples show the values of the `joints` and of the symbols in the reference.
    """
    if not part.answer.list_entries():
        return make_wrong_judgement("your answer is a function, but the question does not ask for a formula")
    reference = part.answer.parse_trees(symbol_names)
    nodes = [entry for row in reference for entry in row]
    expected_shape = (len(reference), len(reference[0]))
    shape, values = function_values.shape, function_values.values
    if shape is None or len(values) != SAMPLE_COUNT:
        return make_wrong_judgement("these are not the values of a function")
    is_matrix = len(shape) == 2 and 1 not in shape
    if values.shape[1] != len(nodes) or (is_matrix and shape != expected_shape):
        size_words = " x ".join(map(str, shape)) or "one number"
        expected_words = " x ".join(map(str, expected_shape))
        return make_wrong_judgement(f"your function returns {size_words}, but it must return {expected_words}")
    expected, term_size = evaluate(compile_program(nodes), function_values.arguments, SAMPLE_COUNT)
    answer_values = _scale_to_fit(expected, values.T) if part.answer.is_direction else values.T
    shown_names = set(joints).union(*map(find_names, nodes))
    shown_arguments = {name: column for name, column in function_values.arguments.items() if name in shown_names}
    comparison = _compare_values(answer_values, expected, term_size, shown_arguments, part.rounding)
    return judge_compared_matrix(comparison, [False] * len(nodes), reference)


def _scale_to_fit(expected: np.ndarray, answer_values: np.ndarray) -> np.ndarray:
    """Return vectors scaled by the factors that bring them closest to the expected ones, (entries, points)."""
    with np.errstate(all="ignore"):
        factor = np.sum(expected * answer_values.conj(), axis=0) / np.sum(np.abs(answer_values) ** 2, axis=0)
        return np.asarray(answer_values * factor)


def _compare_values(
    answer_values: np.ndarray, expected_values: np.ndarray, term_size: np.ndarray,
    arguments: Mapping[str, np.ndarray], rounding: equality.Rounding | None,
) -> equality.Comparison:  # fmt: skip
    """Compare arrays of shape (entries, points). Points at which the expected value is undefined don't count.

    `term_size` is the size of the terms in the expected values, and `arguments` are the values of the symbols.
    """
    relative_error, absolute_error = (rounding.relative, rounding.absolute) if rounding is not None else (0.0, 0.0)
    with np.errstate(all="ignore"):
        largest_terms = np.nanmax(np.where(np.isfinite(term_size), term_size, 0.0), axis=0)
        # The size of an entry without nonzero terms is that of the largest entry at this point.
        scale = np.where(term_size > 0, term_size, np.where(largest_terms > 0, largest_terms, 1.0))
        tolerance = max(RELATIVE_TOLERANCE, relative_error) * scale + absolute_error
        is_close = np.abs(answer_values - expected_values) <= tolerance
    is_defined = np.isfinite(expected_values)
    # An entry whose expected value is undefined at all points is wrong.
    is_correct = list(map(bool, (is_close | ~is_defined).all(axis=1) & is_defined.any(axis=1)))
    example = None
    if not all(is_correct):
        entry = is_correct.index(False)
        point = int(np.argmax(~is_close[entry] & is_defined[entry]))
        value, expected_value = complex(answer_values[entry, point]), complex(expected_values[entry, point])
        symbol_values = {name: float(f"{column[point]:.6g}") for name, column in sorted(arguments.items())}
        example = equality.EntryDifference(entry, symbol_values, *equality.format_difference(value, expected_value))
    return equality.Comparison(
        tuple(is_correct),
        equality.Certificate("numeric", SAMPLE_COUNT, equality.compute_chance_of_missing(SAMPLE_COUNT), example),
    )
