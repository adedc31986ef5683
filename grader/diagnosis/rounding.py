"""Recognise answers that are correct except for rounding: too few digits, or decimals for exact constants."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from qdot.exercises.formula.trees import Node, digits_of_decimals
from qdot.exercises.problem.problem import Part
from qdot.grader.diagnosis.numbers import InNumbers
from qdot.grader.judging.verdict import Diagnosis

NEAR = 2e-3
"""Maximum relative error of an entry with decimals for exact constants, such as 3.14 for pi."""
NEAR_VALUES = 1e-6
"""Maximum error that rounding to six digits causes in a function's values, relative to the largest value."""
EXACTLY = "Right but for rounding: write exact values, as pi/2 for 1.5708 and sqrt(3)/2 for 0.866."
FUNCTION = "Right but for rounding: round neither the values that the function returns nor the constants in it."
DIGITS = 2
"""Minimum number of digits that identify a number; if there are several numbers, at least one needs as many."""


def explain_rounding(part: Part, answer: InNumbers, right: np.ndarray, entries: Sequence[Node]) -> Diagnosis | None:
    """Return the diagnosis that an answer is correct except for rounding, or None.

    This is not a mistake of the catalogue. `entries` are the formulas as typed.
    """
    if answer.values.shape != right.shape or (np.iscomplexobj(right) and np.any(right.imag)):
        return None
    has_decimals = any(map(digits_of_decimals, entries))
    if answer.is_direction:
        tolerant = replace(answer, room=(NEAR if has_decimals else answer.room[0], 0.0))
        return (
            Diagnosis((), EXACTLY) if entries and not part.answer.is_in_numbers and is_right(tolerant, right) else None
        )
    digits = part.rounding.words if part.rounding is not None else "to three significant digits"
    if part.answer.is_in_numbers:
        return Diagnosis((), f"Right but for rounding: numbers are due {digits}.") if _to_few(answer, right) else None
    if not has_decimals:
        return Diagnosis((), EXACTLY) if entries and is_right(answer, right) else None  # such as 866025/1000000
    difference = np.abs(answer.values - right)
    size = np.minimum(answer.size, 2 * np.abs(right).max())  # large terms may cancel in the answer
    size = np.maximum(size, np.abs(right).max(axis=(0, 1)))  # an entry may contain cos(1.5708) times another entry
    if not (answer.like(right) | (difference <= NEAR * size).all(axis=-1)).all():
        return None
    return Diagnosis((), EXACTLY if part.rounding is None else f"Right but for rounding: decimals are due {digits}.")


def explain_rounded_function(returned: InNumbers, right: np.ndarray) -> Diagnosis | None:
    """Return the diagnosis that a function is correct except for rounding, or None."""
    if returned.values.shape != right.shape or returned.is_direction:
        return None
    is_near = np.abs(returned.values - right) <= NEAR_VALUES * np.maximum(returned.size, np.abs(right).max())
    return Diagnosis((), FUNCTION) if is_near.all() else None


def is_right(answer: InNumbers, right: np.ndarray) -> bool:
    """Return whether all values of an answer are correct within its tolerance."""
    return answer.values.shape == right.shape and bool(answer.like(right).all())


def _to_few(answer: InNumbers, right: np.ndarray) -> bool:
    """Return whether all numbers are correct to one or two digits, and at least one of them to two."""
    to_two = answer.like(right) | _is_to(DIGITS, answer.values.real, right.real)
    to_one = _is_to(DIGITS - 1, answer.values.real, right.real)
    return bool((to_two | to_one).all() and to_two.any())


def _is_to(digits: int, values: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return for each number whether it is the correct one rounded to `digits` digits, (rows, columns).

    It may also be truncated to two digits.
    """
    with np.errstate(all="ignore"):
        step = 10.0 ** (np.floor(np.log10(np.abs(right))) + 1 - digits)
        rounded_values = [np.round(right / step) * step, *([np.trunc(right / step) * step] if digits == DIGITS else [])]
        matches = [(np.abs(values - rounded) <= 1e-9 * np.abs(right)).all(axis=-1) for rounded in rounded_values]
    return np.any(matches, axis=0)
