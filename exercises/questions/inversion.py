"""Questions on the inverse of J and joint rates (6.7; Example 6.2), and on static joint torques, tau = J^T F.

By the principle of virtual work, joint torques are dual to joint rates. Questions ask for joint rates as formulas, or
as numbers at a configuration.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm import mpmath_kinematics as precise
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.mpmath_kinematics import MpmathArm, Vector
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import make_task_velocity
from qdot.exercises.problem.problem import Details, SymbolInfo, list_values_by_name, recorded_as
from qdot.exercises.questions import base
from qdot.exercises.questions.base import AnswerAndDetails, Question
from qdot.exercises.questions.quantities import name_load
from qdot.exercises.reference_answers import Number

MAX_SAMPLES = 2000
"""Maximum number of samples for a well-conditioned configuration."""

THREE_DIGIT_TOLERANCE = 0.005
"""Relative tolerance of numbers with three significant digits: rounding 1.004999 to 1.00 changes it by 0.5 %."""

ERROR_NEAR_ZERO = 0.001
"""Error allowed in each entry of a numeric vector, as a fraction of the vector's largest entry."""

Lengths = dict[sp.Symbol, sp.Rational]
JointValues = dict[sp.Symbol, sp.Expr]

# --- configurations ---


@dataclass(frozen=True)
class Configuration:
    """Numbers for an arm: one for each symbolic length (m), and one for each joint variable (rad or m)."""

    lengths: Lengths
    joints: JointValues

    @property
    def values(self) -> dict[sp.Symbol, sp.Expr]:
        """All numbers together, for substitution."""
        return {**self.lengths, **self.joints}

    @property
    def numbers(self) -> dict[str, float]:
        """All numbers as floats, by the names of their symbols."""
        return {str(symbol): float(sp.N(value.xreplace(self.lengths))) for symbol, value in self.values.items()}

    @property
    def figure_values(self) -> dict[str, float]:
        """The joint values for a figure, by the names of the joint variables."""
        return {q.name: float(value) for q, value in self.joints.items()}


@dataclass(frozen=True)
class ConfigurationAndVelocity(Configuration):
    """A configuration with simple numbers, and the task velocity there (m/s and rad/s)."""

    velocity: dict[sp.Symbol, sp.Rational]

    @property
    def values(self) -> dict[sp.Symbol, sp.Expr]:
        """All numbers together, for substitution."""
        return {**super().values, **self.velocity}


@dataclass(frozen=True, kw_only=True)
class VelocityDetails(Details):
    """Details of a question that gives a configuration and a task velocity."""

    configuration: ConfigurationAndVelocity = field(metadata=recorded_as("situation"))

    def list_given_values(self, chain: Chain) -> dict[str, float]:
        """Return the numbers of the configuration and velocity."""
        return self.configuration.numbers


def sample_joint_values(chain: Chain, rng: Stream) -> JointValues:
    """Return random joint values: angles in steps of 5 degrees, prismatic joints in steps of 5 cm."""
    return {
        q: sp.pi * sp.Rational(rng.integer(-35, 35), 36) if joint.is_revolute else sp.Rational(rng.integer(2, 16), 20)
        for q, joint in zip(chain.q, chain.joints, strict=True)
    }


def sample_lengths(chain: Chain, rng: Stream) -> Lengths:
    """Return random numbers for the symbolic lengths. No two lengths are equal, as the text of the problem says."""
    used_lengths = list_table_lengths(chain)
    lengths: Lengths = {}
    for symbol in chain.parameters:
        start = rng.integer(0, 10)
        candidates = (sp.Rational(6 + (start + offset) % 11, 20) for offset in range(11))  # 0.3 m to 0.8 m
        lengths[symbol] = next(length for length in candidates if length not in used_lengths)
        used_lengths.add(lengths[symbol])
    return lengths


def list_table_lengths(chain: Chain) -> set[sp.Expr]:
    """Return the absolute values of the numeric lengths in an arm's table."""
    return {abs(length) for joint in chain.joints for length in (joint.a, joint.d) if length.is_number}


def compute_conditioning(chain: Chain, lengths: Lengths, joints: JointValues) -> float:
    """Return sigma_min/sigma_max of the task Jacobian at a configuration; it is zero if J loses rank."""
    arm = NumericChain(chain, list_values_by_name(lengths))
    jacobian = arm.compute_jacobian(np.array([float(joints[q].xreplace(lengths)) for q in chain.q]))
    sigma = np.linalg.svd(jacobian[chain.task_rows], compute_uv=False)
    return float(sigma[-1] / sigma[0])


def sample_configuration_and_velocity(chain: Chain, rng: Stream) -> ConfigurationAndVelocity:
    """Return a random configuration that is far from all singular configurations, with a random task velocity."""
    for _ in range(MAX_SAMPLES):
        lengths, joints = sample_lengths(chain, rng), sample_joint_values(chain, rng)
        velocity = {v: sp.Rational(rng.nonzero_integer(8), 20) for v in make_task_velocity(chain)}  # at most 0.4
        if compute_conditioning(chain, lengths, joints) > find_min_conditioning(chain):
            return ConfigurationAndVelocity(lengths, joints, velocity)
    raise RuntimeError(f"no well-conditioned pose of {chain} was found; please report this")


def evaluate_jacobian_precisely(chain: Chain, configuration: Configuration) -> list[Vector]:
    """Return the task Jacobian at a configuration, as rows of high-precision numbers."""
    arm = MpmathArm(chain, configuration.lengths)
    return arm.compute_task_jacobian([arm.evaluate_number(configuration.joints[q]) for q in chain.q])


def find_min_conditioning(chain: Chain) -> float:
    """Return the minimum sigma_min/sigma_max of a configuration at which a question asks for numbers.

    The minimum is smaller for arms with many joints, which have few configurations with a large ratio. It is also
    smaller for tasks in metres and radians, because the ratio then depends on the units.
    """
    has_one_unit = len({row[0] for row in chain.task}) == 1
    return 0.15 if chain.n <= base.MAX_JOINTS_FOR_INVERSE and has_one_unit else 0.04


# --- inverse and joint rates ---


def make_rates_answer(chain: Chain, rates: Iterable[Any], max_rate: Any) -> Number:
    """Return joint rates as an answer that accepts three digits. `max_rate` is the largest absolute value of a rate."""
    units = tuple("rad/s" if joint.is_revolute else "m/s" for joint in chain.joints)
    rounded_rates = sp.Matrix(list(map(precise.round_to_ten_digits, rates)))
    return Number(rounded_rates, units, THREE_DIGIT_TOLERANCE, ERROR_NEAR_ZERO * float(max_rate))


def _ask_joint_rates(chain: Chain, rng: Stream) -> AnswerAndDetails:
    configuration = sample_configuration_and_velocity(chain, rng)
    velocity = [precise.evaluate_in_context(value) for value in configuration.velocity.values()]
    rates = precise.solve_linear(evaluate_jacobian_precisely(chain, configuration), velocity)
    max_rate = max(abs(precise.round_to_ten_digits(rate)) for rate in rates)
    return make_rates_answer(chain, rates, max_rate), VelocityDetails(configuration=configuration)


INVERSE_PREREQUISITES = (("jacobian",), ("jacobian", "determinant"))
"""The sets of questions from whose answers the inverse can be derived."""
RATE_PREREQUISITES = (("inverse-velocity",), ("inverse-jacobian",), *INVERSE_PREREQUISITES)
"""The sets of questions from whose answers numeric joint rates can be derived."""


# --- static joint torques ---


@dataclass(frozen=True, kw_only=True)
class LoadDetails(Details):
    """Details of a question about joint torques: the force or moment that the arm exerts (one entry per task row)."""

    force: sp.Matrix


def make_load_symbols(chain: Chain) -> dict[str, SymbolInfo]:
    """Return the symbols of the force and the moment that the arm exerts, such as fx for the row vx, and mx for wx."""
    force, moment = SymbolInfo("force", "N"), SymbolInfo("moment", "N m")
    return {name: force if name[0] == "f" else moment for name in name_load(chain)}


def _make_load_details(chain: Chain, rng: Stream) -> LoadDetails:
    symbols = make_load_symbols(chain)
    units = tuple("N m" if joint.is_revolute else "N" for joint in chain.joints)
    return LoadDetails(symbols=symbols, force=sp.Matrix([sp.Symbol(name) for name in symbols]), units=units)


def _choose_torque_title(chain: Chain) -> str:
    kinds = "".join(sorted({joint.kind for joint in chain.joints}))
    return {"R": "Static joint torques", "P": "Static joint forces", "PR": "Static joint torques and forces"}[kinds]


QUESTIONS = (
    Question(
        "inverse-jacobian", "Inverse Jacobian", "appendix", points=2.0, prerequisites=("jacobian", "determinant"),
        formula="inv(J)", label_rows_and_columns=lambda chain: (base.name_joint_rates(chain), chain.task),
        find_arm_objection=base.find_determinant_objection, find_size_objection=base.find_inverse_size_objection,
        is_made_of_jacobian=True, is_made_of_minors=True, alternative_prerequisites=INVERSE_PREREQUISITES,
    ),
    Question(
        "inverse-velocity", "Inverse velocity", "6.7", points=2.0, prerequisites=("jacobian", "inverse-jacobian"),
        formula="inv(J)*xd", list_labels=base.name_joint_rates, find_arm_objection=base.find_determinant_objection,
        find_size_objection=base.find_inverse_size_objection, is_made_of_jacobian=True, is_made_of_minors=True,
        alternative_prerequisites=RATE_PREREQUISITES[1:],
    ),
    Question(
        "joint-rates", "Joint rates at a configuration", "6.7", prerequisites=("inverse-velocity",),
        formula="inv(J)*xd", sample=_ask_joint_rates, list_labels=base.name_joint_rates, is_made_of_jacobian=True,
        find_arm_objection=base.find_determinant_objection, alternative_prerequisites=RATE_PREREQUISITES,
    ),
    Question(
        "joint-torques", "Static joint torques", "dual of 6.4", prerequisites=("jacobian",),
        choose_title=_choose_torque_title,
        formula="transpose(J)*f", make_details=_make_load_details, is_made_of_jacobian=True,
        name_entries=lambda chain, _: [rf"\tau_{{{joint}}}" for joint in range(1, chain.n + 1)],
        find_size_objection=base.limit_terms("jacobian"),
    ),
)  # fmt: skip
