"""Questions about an arm at one configuration: the determinant, the speed of P, and whether a statement is true."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.mpmath_kinematics import compute_determinant, evaluate_in_context, round_to_ten_digits
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.formula.units import write_power_of_metres
from qdot.exercises.problem.problem import recorded_as
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.questions.concepts import find_moving_rows
from qdot.exercises.questions.exact_configurations import (
    DIGITS,
    ConfigurationDetails,
    ExactConfiguration,
    evaluate_precisely,
    sample_displayable_configuration,
    sample_regular_configuration,
)
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE
from qdot.exercises.reference_answers import TRUE_FALSE, Choice, Number
from qdot.exercises.short_questions.short_question import ShortQuestion
from qdot.exercises.singularities.singular_set import find_singular_set

MAX_SPEED_TRIES, MAX_STATEMENT_TRIES = 40, 30
"""Maximum numbers of samples: of a configuration with a speed, and of a statement."""

MIN_SPEED = 0.05
"""Minimum speed that is asked for, in m/s."""

MIN_VISIBLE_VELOCITY = 0.08
"""Minimum velocity component (m/s for a unit joint rate) whose sign is asked for, so that it is visible in a
drawing."""


def _sample_regular_configuration(chain: Chain, rng: Stream) -> ExactConfiguration | None:
    return sample_regular_configuration(chain, rng, min_ratio=0.05, prefers_seemingly_singular=False)


# --- numbers ---


def _make_number(value: Any, unit: str) -> Number:
    """Return a number as an answer that accepts three digits."""
    rounded_value = round_to_ten_digits(value)
    absolute_tolerance = THREE_DIGIT_TOLERANCE * abs(float(rounded_value)) / 5  # small: only relative errors matter
    return Number(sp.Matrix([rounded_value]), (unit,), THREE_DIGIT_TOLERANCE, absolute_tolerance)


def _ask_determinant(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    configuration = _sample_regular_configuration(chain, rng)
    if configuration is None:
        return None
    jacobian = evaluate_precisely(chain, configuration, derive(chain).jacobian)
    rows = [[evaluate_in_context(entry) for entry in row] for row in jacobian.tolist()]
    unit = write_power_of_metres(len(chain.revolute_joints))
    return _make_number(compute_determinant(rows), unit), ConfigurationDetails(configuration=configuration)


@dataclass(frozen=True, kw_only=True)
class RateDetails(ConfigurationDetails):
    """Details of a question about a configuration at which the joints move at given rates."""

    rates: dict[sp.Symbol, sp.Rational]


def _ask_speed(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Sample rates of all joints and ask for the norm of the linear velocity."""
    for _ in range(MAX_SPEED_TRIES):
        configuration = _sample_regular_configuration(chain, rng)
        if configuration is None:
            continue
        rates = {rate: sp.Rational(rng.nonzero_integer(9), 10) for rate in chain.rates}  # at most 0.9 rad/s or m/s
        linear_rows = evaluate_precisely(chain, configuration, derive(chain).linear_rows)
        velocity = linear_rows * sp.Matrix(list(rates.values()))
        with mpmath.workdps(DIGITS):
            squares = (mpmath.mpf(str(sp.N(entry, DIGITS))) ** 2 for entry in velocity)
            speed = mpmath.sqrt(mpmath.fsum(squares))
        if speed > MIN_SPEED:
            return _make_number(speed, "m/s"), RateDetails(configuration=configuration, rates=rates)
    return None


def _find_line_objection(chain: Chain) -> str | None:
    linear_rows = [row for row in find_moving_rows(derive(chain).geometric_jacobian) if row[0] == "v"]
    return None if len(linear_rows) >= 2 else "its point moves along a line or not at all"


VALUE_QUESTIONS = (
    ShortQuestion(
        "determinant-value", "Determinant at a configuration", "6.8", sample=_ask_determinant, form="number",
        base_question="determinant", objection_if_sampling_fails="no regular configuration was found",
        find_arm_objection=lambda chain: (
            None if len(chain.linear_axes) == len(chain.task) else "its Jacobian mixes metres and radians"
        ),
        name_entries=lambda *_: [r"\det J"],
    ),
    ShortQuestion(
        "speed", "Speed of the point", "6.4", sample=_ask_speed, form="number", base_question="jacobian",
        objection_if_sampling_fails="no configuration was found in which its point moves",
        find_arm_objection=_find_line_objection, name_entries=lambda *_: ["|v_P|"],
    ),
)  # fmt: skip


# --- true or false ---


@dataclass(frozen=True, kw_only=True)
class ConfigurationStatement(ConfigurationDetails):
    """A statement about a configuration.

    `statement_kind` is "singular" (the configuration is singular) or "moves" (a joint moves P in some direction).
    """

    statement_kind: str = field(metadata=recorded_as("said"))


@dataclass(frozen=True, kw_only=True)
class JointStatement(ConfigurationStatement):
    """The statement that a velocity component of P has a certain sign if one joint moves at a positive rate.

    `joint` is the number of the joint, and `row` is the name of the component, such as "vx". `is_positive` says whether
    the stated sign is positive.
    """

    joint: int
    row: str
    is_positive: bool = field(metadata=recorded_as("positive"))


def _ask_true_or_false(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose whether the statement is to be true, then sample such a statement."""
    is_true = rng.choice((True, False))
    for _ in range(MAX_STATEMENT_TRIES):
        for statement in _sample_statements(chain, is_true, rng):
            return Choice(TRUE_FALSE, TRUE_FALSE.index("true" if is_true else "false")), statement
    return None


def _sample_statements(chain: Chain, is_true: bool, rng: Stream) -> Iterator[ConfigurationStatement]:
    """Yield statements of both kinds in random order, all true or all false; a kind that does not apply is left out."""
    for statement_kind in rng.permutation(("singular", "moves")):
        if statement_kind == "singular" and (components := find_singular_set(chain)):
            if is_true:
                configuration = sample_displayable_configuration(chain, (rng.choice(components),), rng)
            else:
                configuration = sample_regular_configuration(chain, rng, min_ratio=0.12)
            if configuration is not None:
                yield ConfigurationStatement(statement_kind="singular", configuration=configuration)
        if statement_kind == "moves":
            yield from _sample_joint_statements(chain, is_true, rng)


def _sample_joint_statements(chain: Chain, is_true: bool, rng: Stream) -> Iterator[ConfigurationStatement]:
    """Yield a statement about the sign of a velocity component due to one joint; a false one has the wrong sign."""
    configuration = _sample_regular_configuration(chain, rng)
    if configuration is None:
        return
    linear_rows = evaluate_precisely(chain, configuration, derive(chain).linear_rows)
    visible_entries = np.argwhere(np.abs(np.array(linear_rows.tolist(), dtype=float)) > MIN_VISIBLE_VELOCITY).tolist()
    if visible_entries:
        row, joint = rng.choice(visible_entries)
        yield JointStatement(
            statement_kind="moves", configuration=configuration, joint=joint + 1, row=VELOCITY_NAMES[row],
            is_positive=bool(linear_rows[row, joint] > 0) == is_true,
        )  # fmt: skip


TRUE_OR_FALSE = ShortQuestion(
    "true-or-false", "True or false?", "6.12", sample=_ask_true_or_false, form="true or false",
    base_question="jacobian", objection_if_sampling_fails="there is no statement about its configurations to judge",
)  # fmt: skip
