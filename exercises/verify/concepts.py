"""Check the answers to questions on concepts, such as the size of J, by finite differences and least squares."""

import numpy as np

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.concepts import (
    INVERTIBILITY_ANSWERS,
    InvertibilityDetails,
    JointEffectDetails,
    parse_vector,
)
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.reference_answers import Choice
from qdot.exercises.verify.formulas import EXACT_TOLERANCE, PartCheck, check_agreement
from qdot.exercises.verify.numbers import list_reference_numbers
from qdot.exercises.verify.numeric_model import Check, Checks, NumericModel, differentiate, differentiate_frames
from qdot.exercises.verify.rank import find_rank

ROUNDING_TOLERANCE, MIN_WRONG_ERROR = 0.0006, 0.01
"""Maximum error of a number that is rounded to three decimals, and minimum error of a wrong option (m/s or rad/s)."""
MIN_ENTRY = 1e-6
"""Entries of J below this value (m/s or rad/s) count as zero, because finite differences are not exact."""


def _check_size(model: NumericModel, part: Part) -> Checks:
    """Check the number of rows and columns of J, and that no row of the task is always zero."""
    task = part.details_as(TaskDetails).task
    jacobian = model.finite_difference_jacobian[:, [VELOCITY_NAMES.index(row) for row in task]]
    expected = np.array([[float(jacobian.shape[1])], [float(jacobian.shape[2])]])
    yield check_agreement("size", list_reference_numbers(part), expected[None], EXACT_TOLERANCE)
    largest_entries = np.abs(jacobian).max(axis=(0, 2))
    zero_rows = [row for row, entry in zip(task, largest_entries, strict=True) if entry < MIN_ENTRY]
    is_different = not zero_rows and task != model.chain.task
    yield Check("rows that move", is_different, f"always zero: {', '.join(zero_rows) or 'none'}")


def _check_effect(model: NumericModel, part: Part) -> Checks:
    """Check by finite differences that only the correct option is the velocity that one joint causes."""
    answer, effect = part.answer_as(Choice), part.details_as(JointEffectDetails)
    sample, joint = model.sample_at(effect.configuration), effect.joint - 1
    angular = differentiate_frames(sample.arm.compute_frames, sample.q[None])[0, joint, -1, 3:]
    velocity = np.array([*differentiate(sample.arm.compute_point, sample.q[None])[0, joint], *angular])
    expected = velocity[[VELOCITY_NAMES.index(row) for row in effect.rows]]
    errors = [float(np.abs(np.array(parse_vector(option)) - expected).max()) for option in answer.options]
    is_correct = [error < ROUNDING_TOLERANCE for error in errors]
    is_only_correct = is_correct == [index == answer.correct for index in range(len(is_correct))]
    yield Check("finite differences", is_only_correct, f"errors {', '.join(f'{error:.3f}' for error in errors)}")
    near_count = sum(error < MIN_WRONG_ERROR for error in errors)
    yield Check("clearly different", near_count == 1, "one option is near the right one")


def _check_invertibility(model: NumericModel, part: Part) -> Checks:
    """Check by size and rank whether J is regular, singular or redundant, or has too few columns."""
    answer, details = part.answer_as(Choice), part.details_as(InvertibilityDetails)
    task_rows = [VELOCITY_NAMES.index(row) for row in details.task]
    jacobian = model.exponential_jacobian_at(details.configuration)[task_rows]
    rank, is_clear = find_rank(jacobian)
    m, n = jacobian.shape
    if m == n:
        expected_key = "regular" if rank == n else "singular"
    elif m < n:
        expected_key = "redundant"
    else:
        expected_key = "few"
    yield Check("clear", is_clear and (m == n or rank == min(m, n)), f"{m} x {n}, rank {rank}")
    options = answer.options
    is_stated = options[answer.correct] == INVERTIBILITY_ANSWERS[expected_key] and details.answer_key == expected_key
    are_all_offered = sorted(options) == sorted(INVERTIBILITY_ANSWERS.values())
    yield Check("use", is_stated and are_all_offered, f"{answer.letters} is {options[answer.correct]}")


CHECKS: dict[str, PartCheck] = {
    "jacobian-size": _check_size,
    "joint-effect": _check_effect,
    "invertibility": _check_invertibility,
}
