"""Recognise answers that are correct except for rounding: too few digits, or decimals for exact constants."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from qdot.exercises.formula.trees import Node, count_decimal_digits
from qdot.exercises.problem.problem import Part
from qdot.grader.diagnosis.numbers import NumericAnswer
from qdot.grader.judging.verdict import Diagnosis

CONSTANT_TOLERANCE = 2e-3
"""Maximum relative error of an entry with decimals for exact constants, such as 3.14 for pi."""
FUNCTION_TOLERANCE = 1e-6
"""Maximum error that rounding to six digits causes in a function's values, relative to the largest value."""
EXACT_VALUES_ADVICE = "Right but for rounding: write exact values, as pi/2 for 1.5708 and sqrt(3)/2 for 0.866."
FUNCTION_ADVICE = "Right but for rounding: round neither the values that the function returns nor the constants in it."
MIN_DIGITS = 2
"""Minimum number of digits that identify a number; if there are several numbers, at least one needs as many."""


def explain_rounding(
    part: Part, answer: NumericAnswer, correct_values: np.ndarray, entries: Sequence[Node]
) -> Diagnosis | None:
    """Return the diagnosis that an answer is correct except for rounding, or None.

    This is not a mistake of the catalogue. `entries` are the formulas as typed.
    """
    if answer.values.shape != correct_values.shape or (np.iscomplexobj(correct_values) and np.any(correct_values.imag)):
        return None
    has_decimals = any(map(count_decimal_digits, entries))
    if answer.is_direction:
        tolerant = replace(answer, tolerances=(CONSTANT_TOLERANCE if has_decimals else answer.tolerances[0], 0.0))
        if entries and not part.answer.is_numeric and is_correct(tolerant, correct_values):
            return Diagnosis((), EXACT_VALUES_ADVICE)
        return None
    digits = part.rounding.words if part.rounding is not None else "to three significant digits"
    if part.answer.is_numeric:
        if _is_correct_to_few_digits(answer, correct_values):
            return Diagnosis((), f"Right but for rounding: numbers are due {digits}.")
        return None
    if not has_decimals:
        return (
            Diagnosis((), EXACT_VALUES_ADVICE) if entries and is_correct(answer, correct_values) else None
        )  # such as 866025/1000000
    difference = np.abs(answer.values - correct_values)
    size = np.minimum(answer.term_size, 2 * np.abs(correct_values).max())  # large terms may cancel in the answer
    size = np.maximum(
        size, np.abs(correct_values).max(axis=(0, 1))
    )  # an entry may contain cos(1.5708) times another entry
    if not (answer.match_entries(correct_values) | (difference <= CONSTANT_TOLERANCE * size).all(axis=-1)).all():
        return None
    return Diagnosis(
        (), EXACT_VALUES_ADVICE if part.rounding is None else f"Right but for rounding: decimals are due {digits}."
    )


def explain_rounded_function(answer: NumericAnswer, correct_values: np.ndarray) -> Diagnosis | None:
    """Return the diagnosis that a function is correct except for rounding, or None."""
    if answer.values.shape != correct_values.shape or answer.is_direction:
        return None
    is_near = np.abs(answer.values - correct_values) <= FUNCTION_TOLERANCE * np.maximum(
        answer.term_size, np.abs(correct_values).max()
    )
    return Diagnosis((), FUNCTION_ADVICE) if is_near.all() else None


def is_correct(answer: NumericAnswer, correct_values: np.ndarray) -> bool:
    """Return whether all values of an answer are correct within its tolerance."""
    return answer.values.shape == correct_values.shape and bool(answer.match_entries(correct_values).all())


def _is_correct_to_few_digits(answer: NumericAnswer, correct_values: np.ndarray) -> bool:
    """Return whether all numbers are correct to one or two digits, and at least one of them to two."""
    to_two = answer.match_entries(correct_values) | _matches_to_digits(
        MIN_DIGITS, answer.values.real, correct_values.real
    )
    to_one = _matches_to_digits(MIN_DIGITS - 1, answer.values.real, correct_values.real)
    return bool((to_two | to_one).all() and to_two.any())


def _matches_to_digits(digits: int, values: np.ndarray, correct_values: np.ndarray) -> np.ndarray:
    """Return for each number whether it is the correct one rounded to `digits` digits, (rows, columns).

    It may also be truncated to two digits.
    """
    with np.errstate(all="ignore"):
        step = 10.0 ** (np.floor(np.log10(np.abs(correct_values))) + 1 - digits)
        rounded_values = [
            np.round(correct_values / step) * step,
            *([np.trunc(correct_values / step) * step] if digits == MIN_DIGITS else []),
        ]
        matches = [
            (np.abs(values - rounded) <= 1e-9 * np.abs(correct_values)).all(axis=-1) for rounded in rounded_values
        ]
    return np.any(matches, axis=0)
