"""Recognise answers that are correct except for rounding: too few digits, or decimals for exact constants."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from qdot.exercises.formula.trees import Node, count_decimal_digits
from qdot.exercises.problem.problem import Part
from qdot.grader.diagnosis.evaluated_answer import EvaluatedAnswer
from qdot.grader.diagnosis.numbers import NumericAnswer, Tolerances
from qdot.grader.judging.verdict import Diagnosis

CONSTANT_TOLERANCE = 2e-3
"""Maximum relative error of an entry with decimals instead of exact constants, such as 3.14 for pi."""
FUNCTION_TOLERANCE = 1e-6
"""Maximum error that rounding to six digits causes in a function's values, relative to the largest value."""
EXACT_VALUES_ADVICE = (
    "Your answer is correct except for rounding. Write exact values, such as pi/2 instead of 1.5708 and sqrt(3)/2 "
    "instead of 0.866."
)
FUNCTION_ADVICE = (
    "Your function is correct except for rounding. Do not round its constants or the values that it returns."
)
MIN_DIGITS = 2
"""Minimum number of digits that identify a number. A number with only one digit may be right by chance."""


def explain_rounding(wrong_answer: EvaluatedAnswer, entries: Sequence[Node]) -> Diagnosis | None:
    """Return the diagnosis that an answer is correct except for rounding, or None.

    This is not a mistake of the catalogue. `entries` are the formulas as typed.
    """
    part, answer, correct_values = wrong_answer.part, wrong_answer.numeric, wrong_answer.correct_values
    if not wrong_answer.has_expected_shape or (np.iscomplexobj(correct_values) and np.any(correct_values.imag)):
        return None
    has_decimals = any(map(count_decimal_digits, entries))
    if answer.is_direction:
        relative_tolerance = CONSTANT_TOLERANCE if has_decimals else answer.tolerances.relative
        tolerant_answer = replace(answer, tolerances=Tolerances(relative_tolerance, 0.0))
        is_correct = replace(wrong_answer, numeric=tolerant_answer).is_correct
        return Diagnosis((), EXACT_VALUES_ADVICE) if entries and not part.answer.is_numeric and is_correct else None
    if part.answer.is_numeric:
        return _explain_few_digits(part, answer, correct_values)
    if not has_decimals:  # but possibly fractions, such as 866025/1000000
        return Diagnosis((), EXACT_VALUES_ADVICE) if entries and wrong_answer.is_correct else None
    difference, largest_value = np.abs(answer.values - correct_values), np.abs(correct_values).max(axis=(0, 1))
    size = np.minimum(answer.term_size, 2 * np.abs(correct_values).max())  # large terms may cancel in the answer
    size = np.maximum(size, largest_value)  # an entry may contain cos(1.5708) times another entry
    if not (answer.match_entries(correct_values) | (difference <= CONSTANT_TOLERANCE * size).all(axis=-1)).all():
        return None
    advice = f"Your answer is correct except for rounding. Give decimals {part.precision}."
    return Diagnosis((), EXACT_VALUES_ADVICE if part.rounding is None else advice)


def explain_rounded_function(wrong_answer: EvaluatedAnswer) -> Diagnosis | None:
    """Return the diagnosis that a function is correct except for rounding, or None."""
    answer, correct_values = wrong_answer.numeric, wrong_answer.correct_values
    if not wrong_answer.has_expected_shape or answer.is_direction:
        return None
    size = np.maximum(answer.term_size, np.abs(correct_values).max())
    is_near = np.abs(answer.values - correct_values) <= FUNCTION_TOLERANCE * size
    return Diagnosis((), FUNCTION_ADVICE) if is_near.all() else None


def _explain_few_digits(part: Part, answer: NumericAnswer, correct_values: np.ndarray) -> Diagnosis | None:
    """Return the diagnosis that all numbers are correct to fewer digits than required, or None.

    If no number is correct to two digits, the feedback only says that the answer has too few digits, because one digit
    may be right by chance.
    """
    values, expected = answer.values.real, correct_values.real
    largest_value = float(np.abs(expected).max())
    required_digits = part.count_digits(largest_value) if largest_value else MIN_DIGITS
    has_enough_digits = answer.match_entries(correct_values)
    for digits in range(MIN_DIGITS, required_digits):
        has_enough_digits = has_enough_digits | _matches_to_digits(digits, values, expected)
    has_one_digit = _matches_to_digits(1, values, expected)
    if not (has_enough_digits | has_one_digit).all():
        return None
    beginning = "is correct except for rounding" if has_enough_digits.any() else "has too few digits"
    return Diagnosis((), f"Your answer {beginning}. Give each number {part.precision}.")


def _matches_to_digits(digits: int, values: np.ndarray, correct_values: np.ndarray) -> np.ndarray:
    """Return for each number whether it is the correct number rounded to `digits` digits, (rows, columns).

    A number that is truncated to several digits instead of rounded is accepted, too.
    """
    with np.errstate(all="ignore"):
        step = 10.0 ** (np.floor(np.log10(np.abs(correct_values))) + 1 - digits)
        rounded_values = [np.round(correct_values / step)]
        if digits >= MIN_DIGITS:
            rounded_values.append(np.trunc(correct_values / step))
        errors = [np.abs(values - rounded_value * step) for rounded_value in rounded_values]
        matches = [(error <= 1e-9 * np.abs(correct_values)).all(axis=-1) for error in errors]
    return np.any(matches, axis=0)
