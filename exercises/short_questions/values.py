"""Questions whose answer is a number with a unit: the determinant at a configuration, the speed of the tool point."""

from dataclasses import dataclass
from typing import Any

import mpmath
import sympy as sp

from qdot.exercises.answer_types import Number
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.mpmath_kinematics import determinant, evaluate_in_context, round_to_ten_digits
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions import geometry
from qdot.exercises.questions.base import AnswerAndDetails
from qdot.exercises.questions.geometry import DIGITS, ConfigurationDetails, ExactConfiguration
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE
from qdot.exercises.short_questions.asking import ShortQuestion

MIN_SPEED = 0.05
"""Minimum speed that is asked for, in m/s."""


def _sample_pose(chain: Chain, rng: Stream) -> ExactConfiguration | None:
    return geometry.sample_regular_configuration(chain, rng, 0.05, prefers_misleading=False)


def _ask_determinant(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    configuration = _sample_pose(chain, rng)
    if configuration is None:
        return None
    jacobian = geometry.evaluate_precisely(chain, configuration, derive(chain).jacobian)
    rows = [[evaluate_in_context(entry) for entry in row] for row in jacobian.tolist()]
    revolute_count = len(chain.revolute_joints)
    unit = {0: "", 1: "m"}.get(revolute_count, f"m^{revolute_count}")
    return _make_number(determinant(rows), unit), ConfigurationDetails(place=configuration)


def _make_number(value: Any, unit: str) -> Number:
    rounded_value = round_to_ten_digits(value)
    floor = THREE_DIGIT_TOLERANCE * abs(float(rounded_value)) / 5
    return Number(sp.Matrix([rounded_value]), (unit,), THREE_DIGIT_TOLERANCE, floor)


def _object_to_units(chain: Chain) -> str | None:
    is_linear = all(row.startswith("v") for row in chain.task)
    return None if is_linear else "its Jacobian mixes metres and radians"


@dataclass(frozen=True, kw_only=True)
class RateDetails(ConfigurationDetails):
    """Details of a question about a configuration at which the joints move at given rates."""

    rates: dict[sp.Symbol, sp.Rational]


def _ask_speed(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Sample rates of all joints; the answer is the norm of the linear velocity."""
    for _ in range(40):
        configuration = _sample_pose(chain, rng)
        if configuration is None:
            continue
        rates = {rate: sp.Rational(rng.choice([k for k in range(-9, 10) if k]), 10) for rate in chain.rates}
        linear = geometry.evaluate_precisely(chain, configuration, derive(chain).linear)
        velocity = linear * sp.Matrix(list(rates.values()))
        with mpmath.workdps(DIGITS):
            speed = mpmath.sqrt(mpmath.fsum(mpmath.mpf(str(sp.N(entry, DIGITS))) ** 2 for entry in velocity))
        if speed > MIN_SPEED:
            return _make_number(speed, "m/s"), RateDetails(place=configuration, rates=rates)
    return None


def _object_to_line(chain: Chain) -> str | None:
    moving_row_count = sum(any(entry != 0 for entry in row) for row in derive(chain).linear.tolist())
    return None if moving_row_count >= 2 else "its point moves along a line or not at all"


VALUE_QUESTIONS = (
    ShortQuestion(
        "determinant-value", "Determinant in a configuration", "6.8", sample=_ask_determinant, form="number",
        base_question="determinant", objection_if_nothing_found="no regular configuration was found",
        objection=_object_to_units, entry_names=lambda *_: [r"\det J"],
    ),
    ShortQuestion(
        "speed", "Speed of the point", "6.4", sample=_ask_speed, form="number", base_question="jacobian",
        objection_if_nothing_found="no configuration was found in which its point moves", objection=_object_to_line,
        entry_names=lambda *_: ["|v_P|"],
    ),
)  # fmt: skip
