"""Wrong answers that are right but for rounding: fewer digits than are due, or decimals for exact constants."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from qdot.exercises.formula.trees import Node, digits_of_decimals
from qdot.exercises.problem.problem import Part
from qdot.grader.diagnosis.numbers import InNumbers
from qdot.grader.judging.verdict import Diagnosis

NEAR = 2e-3
"""What decimals for exact constants change at most, as a share of the entries: 3.14 for pi changes as much."""
NEAR_VALUES = 1e-6
"""What rounding changes at most in the values of a function, as a share of the largest: six digits are left of them."""
EXACTLY = "Right but for rounding: write exact values, as pi/2 for 1.5708 and sqrt(3)/2 for 0.866."
FUNCTION = "Right but for rounding: round neither the values that the function returns nor the constants in it."
DIGITS = 2
"""So many digits of a number are due to tell it from others; of several, one or more of them need as many."""


def explain_rounding(part: Part, answer: InNumbers, right: np.ndarray, entries: Sequence[Node]) -> Diagnosis | None:
    """Return that an answer is right but for rounding, or nothing: it is no mistake of the catalogue.

    `entries` are what was typed; formulas are looked at where there is a decimal in them.
    """
    if answer.values.shape != right.shape or (np.iscomplexobj(right) and np.any(right.imag)):
        return None
    has_decimals = any(map(digits_of_decimals, entries))
    if answer.is_direction:
        near = replace(answer, room=(NEAR if has_decimals else answer.room[0], 0.0))
        return Diagnosis((), EXACTLY) if entries and not part.answer.is_in_numbers and is_right(near, right) else None
    digits = part.rounding.words if part.rounding is not None else "to three significant digits"
    if part.answer.is_in_numbers:
        return Diagnosis((), f"Right but for rounding: numbers are due {digits}.") if _to_few(answer, right) else None
    if not has_decimals:
        return Diagnosis((), EXACTLY) if entries and is_right(answer, right) else None  # as 866025/1000000
    off = np.abs(answer.values - right)
    size = np.minimum(answer.size, 2 * np.abs(right).max())  # terms may be large that are no part of the answer
    size = np.maximum(size, np.abs(right).max(axis=(0, 1)))  # cos(1.5708) times an entry may be added to another one
    if not (answer.like(right) | (off <= NEAR * size).all(axis=-1)).all():
        return None
    return Diagnosis((), EXACTLY if part.rounding is None else f"Right but for rounding: decimals are due {digits}.")


def explain_rounded_function(returned: InNumbers, right: np.ndarray) -> Diagnosis | None:
    """Return that a function is right but for rounding, or nothing."""
    if returned.values.shape != right.shape or returned.is_direction:
        return None
    near = np.abs(returned.values - right) <= NEAR_VALUES * np.maximum(returned.size, np.abs(right).max())
    return Diagnosis((), FUNCTION) if near.all() else None


def is_right(answer: InNumbers, right: np.ndarray) -> bool:
    """Tell whether an answer has the right values, as far as numbers tell: then what is wrong is no mistake in them."""
    return answer.values.shape == right.shape and bool(answer.like(right).all())


def _to_few(answer: InNumbers, right: np.ndarray) -> bool:
    """Tell whether all numbers are the right ones to one or two digits, and one of them to two."""
    to_two = answer.like(right) | _is_to(DIGITS, answer.values.real, right.real)
    to_one = _is_to(DIGITS - 1, answer.values.real, right.real)
    return bool((to_two | to_one).all() and to_two.any())


def _is_to(digits: int, values: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Tell of each number whether it is the right one, rounded to digits or cut off after two, (rows, columns)."""
    with np.errstate(all="ignore"):
        step = 10.0 ** (np.floor(np.log10(np.abs(right))) + 1 - digits)
        ways = [np.round(right / step) * step, *([np.trunc(right / step) * step] if digits == DIGITS else [])]
        same = [(np.abs(values - way) <= 1e-9 * np.abs(right)).all(axis=-1) for way in ways]
    return np.any(same, axis=0)
