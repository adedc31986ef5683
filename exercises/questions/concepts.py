"""Questions on concepts: the size of J, the effect of a joint, when (6.7) applies, which velocities are impossible."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Number
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.derivation_graph import Working
from qdot.exercises.arm.mpmath_kinematics import determinant, evaluate_in_context, round_matrix, round_to_four_digits
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions import geometry
from qdot.exercises.questions.base import AnswerAndDetails, Question, shuffle_options
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.questions.geometry import ConfigurationDetails, ExactConfiguration
from qdot.exercises.questions.inversion import sample_joint_values
from qdot.exercises.questions.singular import object_unless_direction_lost
from qdot.exercises.singularities.directions import lost_direction

MIN_OPTION_DIFFERENCE = 0.2
"""Minimum difference of two options, as a fraction of the larger one."""

# --- size of J ---


def _list_other_tasks(chain: Chain) -> list[tuple[str, ...]]:
    """Return the tasks other than the arm's own whose rows of the Jacobian are not identically zero."""
    rows = moving_rows(derive(chain).geometric)
    tasks = [task for size in range(1, len(rows) + 1) for task in combinations(rows, size)]
    return [task for task in tasks if task != chain.task]


def moving_rows(geometric: sp.Matrix) -> tuple[str, ...]:
    """Return the names of the rows of a 6 x n Jacobian that are not identically zero."""
    return tuple(name for name, row in zip(TASK_ROWS, geometric.tolist(), strict=True) if any(e != 0 for e in row))


def _ask_jacobian_size(chain: Chain, rng: Stream) -> AnswerAndDetails:
    tasks = _list_other_tasks(chain)
    size = rng.choice(sorted({len(task) for task in tasks}))
    task = rng.choice([task for task in tasks if len(task) == size])
    return Number(sp.Matrix([size, chain.n]), ("", ""), 1e-9, 1e-9), TaskDetails(task=task)


def _object_to_task(chain: Chain) -> str | None:
    return None if _list_other_tasks(chain) else "its velocity has only one component, which is also its task"


# --- effect of one joint ---


@dataclass(frozen=True)
class JointEffect:
    """The joint that moves alone, the configuration, and the components of velocity that are shown."""

    joint: int
    place: ExactConfiguration
    rows: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class JointEffectDetails(Details):
    """Details of a question about the velocity that one joint causes."""

    effect: JointEffect

    def given_values(self, chain: Chain) -> dict[str, float]:
        """Return the numbers of the configuration."""
        return self.effect.place.numbers


def _choose_rows(chain: Chain) -> tuple[str, ...]:
    """Return the velocity components in which a joint's effect is shown.

    They are those of P, or of the last link if the task has no linear rows or P moves in one component only.
    """
    rows = moving_rows(derive(chain).geometric)
    is_linear = bool(chain.linear_axes) and sum(row[0] == "v" for row in rows) >= 2
    return tuple(row for row in rows if row[0] == ("v" if is_linear else "w"))


def _object_to_effect(chain: Chain) -> str | None:
    rows = _choose_rows(chain)
    return None if len(rows) >= 2 else "its velocity has only one component, along a fixed line"


RoundedVector = tuple[sp.Rational, ...]


def _ask_effect(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    rows = _choose_rows(chain)
    indices = [TASK_ROWS.index(row) for row in rows]
    for _ in range(60):
        lengths, joints = geometry.sample_unequal_lengths(chain, rng), sample_joint_values(chain, rng)
        configuration = geometry.make_exact_configuration(chain, lengths, joints)
        jacobian = geometry.evaluate_precisely(chain, configuration, derive(chain).geometric)[indices, :]
        moving_joints = [i for i in range(chain.n) if _compute_norm(jacobian.col(i)) > 0.1]
        if not moving_joints:
            continue
        joint = rng.choice(moving_joints)
        wrong_columns = _make_wrong_columns(chain, configuration, joint, jacobian, [i for i in indices if i < 3])
        options = [_round_vector(jacobian.col(joint))]
        for candidate in map(_round_vector, rng.permutation(wrong_columns)):
            if all(_differ_clearly(candidate, option) for option in options):
                options.append(candidate)
        if len(options) >= 4:
            answer, _ = shuffle_options(options[:4], options[0], rng, write_vector)
            effect = JointEffect(joint + 1, configuration, rows)
            return answer, JointEffectDetails(effect=effect, pose=configuration.figure_values)
    return None


def _derive_effect(w: Working, details: Details) -> np.ndarray:
    assert isinstance(details, JointEffectDetails)
    effect = details.effect
    return np.asarray(w["geometric"][[TASK_ROWS.index(row) for row in effect.rows], effect.joint - 1])


def _make_wrong_columns(
    chain: Chain, configuration: ExactConfiguration, joint: int, jacobian: sp.Matrix, linear_rows: list[int]
) -> list[sp.Matrix]:
    """Return wrong versions of a column.

    They have the wrong sign, belong to another joint, are p* itself, use the p* of the next origin, or mix up the axes.
    """
    column = jacobian.col(joint)
    vectors = [-column, *(jacobian.col(i) for i in range(chain.n) if i != joint)]
    if linear_rows:
        derivation, is_revolute = derive(chain), chain.joints[joint].is_revolute
        z = geometry.evaluate_precisely(chain, configuration, derivation.z)
        p_star = geometry.evaluate_precisely(chain, configuration, derivation.p_star)
        vectors.append(p_star.col(joint).extract(linear_rows, [0]))
        origin = joint + is_revolute
        if origin < chain.n:
            vectors.append(z.col(joint).cross(p_star.col(origin)).extract(linear_rows, [0]))
    x, y, *other_entries = column
    vectors += [sp.Matrix([*plane, *other_entries]) for plane in ((-y, x), (y, x), (x, -y))]
    return [vector for vector in vectors if _compute_norm(vector) > 0.05]


def _compute_norm(vector: Iterable[sp.Expr]) -> float:
    """Return the norm of a vector. The sum is equal on every machine, because a norm may be exactly at a limit."""
    return math.sqrt(math.fsum(float(value) ** 2 for value in vector))


def _round_vector(vector: sp.Matrix) -> RoundedVector:
    """Return the entries of a vector, rounded to three decimals."""
    return tuple(_round_to(value, 3) for value in vector)


def _round_to(value: sp.Expr, decimals: int) -> sp.Rational:
    return sp.Rational(geometry.nearest_integer(sp.Float(value, 30) * 10**decimals), 10**decimals)


def _differ_clearly(a: RoundedVector, b: RoundedVector) -> bool:
    distance = _compute_norm(x - y for x, y in zip(a, b, strict=True))
    return distance > MIN_OPTION_DIFFERENCE * max(_compute_norm(a), _compute_norm(b))


def write_vector(vector: RoundedVector) -> str:
    """Return a vector as the text of an option, with three decimals per entry.

    >>> write_vector((sp.Rational(1, 3).limit_denominator(1000), sp.S(-2)))
    '(0.333, -2.000)'
    """
    return f"({', '.join(f'{float(value) + 0.0:.3f}' for value in vector)})"


def parse_vector(text: str) -> list[float]:
    """Return the vector that an option shows, parsed from the text of `write_vector`.

    >>> parse_vector("(0.333, -2.000)")
    [0.333, -2.0]
    """
    return [float(value) for value in text.strip("()").split(",")]


# --- when (6.7) can be used ---

INVERTIBILITY_ANSWERS = {
    "regular": "yes: $J$ is square and has full rank in this configuration",
    "singular": "no: $J$ is square, but singular in this configuration",
    "redundant": "no: $J$ has more columns than rows, and infinitely many joint rates give the same velocity",
    "few": "no: $J$ has more rows than columns, and most velocities can't be produced by any joint rates",
}


@dataclass(frozen=True, kw_only=True)
class InvertibilityDetails(ConfigurationDetails):
    """Details of a question whether (6.7) applies.

    They are the answer's key in INVERTIBILITY_ANSWERS, the numeric J, and det J if J is square.
    """

    use: str
    task: tuple[str, ...]
    numbers: sp.Matrix
    determinant: sp.Float | None = None


def _ask_invertibility(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose the answer first, then a task and a configuration for which it is correct."""
    for use in rng.permutation(tuple(INVERTIBILITY_ANSWERS)):
        for task in rng.permutation(_list_tasks(chain, use))[:6]:
            arm = chain.with_task(*task)
            configuration = _sample_configuration_for(arm, use, rng)
            if configuration is not None:
                answer, _ = shuffle_options(tuple(INVERTIBILITY_ANSWERS), use, rng, INVERTIBILITY_ANSWERS.__getitem__)
                return answer, _describe_invertibility(arm, use, configuration)
    return None


def _describe_invertibility(chain: Chain, answer_key: str, configuration: ExactConfiguration) -> InvertibilityDetails:
    """Return the details for an arm with the given task, with numbers to four digits."""
    jacobian = geometry.evaluate_precisely(chain, configuration, derive(chain).jacobian)
    numbers = [[evaluate_in_context(value) for value in row] for row in jacobian.tolist()]
    value = round_to_four_digits(determinant(numbers)) if jacobian.is_square else None
    rounded = round_matrix(numbers)
    return InvertibilityDetails(
        use=answer_key, task=chain.task, place=configuration, numbers=rounded, determinant=value
    )


@lru_cache(maxsize=1024)
def _list_tasks(chain: Chain, answer_key: str) -> tuple[tuple[str, ...], ...]:
    """Return the tasks for which J has the shape that an answer needs. For square J, prefer the arm's own task."""
    rows = moving_rows(derive(chain).geometric)
    if answer_key in ("regular", "singular"):
        if len(chain.task) == chain.n:
            return (chain.task,)
        return tuple(combinations(rows, chain.n)) if chain.n <= 3 else ()
    row_counts = range(1, chain.n) if answer_key == "redundant" else range(chain.n + 1, len(rows) + 1)
    return tuple(task for size in row_counts for task in combinations(rows, size))


def _sample_configuration_for(chain: Chain, answer_key: str, rng: Stream) -> ExactConfiguration | None:
    if answer_key == "singular":
        return geometry.find_singular_configuration(chain, rng)
    return geometry.sample_regular_configuration(chain, rng, 0.06, answer_key == "regular")


# --- which velocities a singularity makes impossible ---

MAX_ROWS = 4
"""Maximum number of velocity components of an option."""


@dataclass(frozen=True)
class VelocityLoss:
    """The singular configuration, whether the correct option is a possible velocity, and the lost direction.

    `products` are the scalar products of the lost direction with the options (by letter), to two decimals.
    """

    place: ExactConfiguration
    possible: bool
    lost: tuple[sp.Rational, ...]
    products: tuple[tuple[str, sp.Rational], ...]


@dataclass(frozen=True, kw_only=True)
class VelocityLossDetails(Details):
    """Details of a question about the velocities that are impossible at a singular configuration."""

    cost: VelocityLoss

    def shown_values(self, chain: Chain) -> dict[str, float]:
        """Return the numbers of the singular configuration."""
        return {**self.cost.place.numbers, **(self.pose or {})}


def _object_to_velocity_loss(chain: Chain) -> str | None:
    if objection := object_unless_direction_lost(chain):
        return objection
    if len(chain.task) > MAX_ROWS:
        return f"its task has {len(chain.task)} components of velocity"
    if _loses_one_direction_somewhere(chain):
        return None
    return "it has no singular configuration that loses exactly one direction"


@lru_cache(maxsize=1024)
def _loses_one_direction_somewhere(chain: Chain) -> bool:
    return geometry.find_singular_configuration(chain, Stream("cost"), 1) is not None


def _ask_unreachable_velocity(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose at random whether exactly one of four velocities can be produced, or all but one."""
    is_possible = rng.choice((True, False))
    for _ in range(20):
        configuration = geometry.find_singular_configuration(chain, rng, 1)
        if configuration is None:
            continue
        jacobian = geometry.evaluate_precisely(chain, configuration, derive(chain).jacobian)
        lost_vector = lost_direction(geometry.evaluate_jacobian(chain, configuration))
        assert lost_vector is not None
        velocities = _sample_velocities(jacobian, lost_vector, is_possible, rng)
        if velocities is not None:
            answer, shuffled = shuffle_options(velocities, velocities[0], rng, write_vector)
            lost_entries = _round_vector(geometry.compute_lost_direction(chain, configuration))
            products = (sum(a * b for a, b in zip(vector, lost_entries, strict=True)) for vector in shuffled)
            lettered_products = tuple(zip("ABCD", (_round_to(value, 2) for value in products), strict=True))
            loss = VelocityLoss(configuration, is_possible, lost_entries, lettered_products)
            return answer, VelocityLossDetails(cost=loss, pose=configuration.figure_values)
    return None


def _sample_velocities(
    jacobian: sp.Matrix, lost_unit_vector: np.ndarray, possible: bool, rng: Stream
) -> list[RoundedVector] | None:
    """Return four velocities, the correct option first.

    If `possible`, the arm can produce only the first velocity, otherwise only the others. Returns None if no suitable
    velocities are found.
    """
    velocities: list[RoundedVector] = []
    for _ in range(80):
        rates = sp.Matrix([sp.Rational(rng.choice([k for k in range(-9, 10) if k]), 10) for _ in range(jacobian.cols)])
        exact_velocity = jacobian * rates
        is_possible = possible == (not velocities)
        if not is_possible:
            exact_velocity += _sample_velocity_along(lost_unit_vector, _compute_norm(exact_velocity), rng)
        velocity = _round_vector(exact_velocity)
        is_moderate = 0.1 < _compute_norm(velocity) < 3
        is_suitable = is_moderate and _is_clearly_as_intended(velocity, lost_unit_vector, is_possible)
        if is_suitable and _is_new(velocity, velocities):
            velocities.append(velocity)
        if len(velocities) == 4:
            return velocities
    return None


def _sample_velocity_along(direction: np.ndarray, length: float, rng: Stream) -> sp.Matrix:
    """Return a velocity along the lost direction; its length is `length`, rounded to hundredths, but at least 0.2."""
    factor = rng.choice((1, -1)) * sp.Rational(round(100 * max(length, 0.2)), 100)
    first_entry = next(value for value in direction if abs(value) > 1e-3)
    oriented = direction if first_entry > 0 else -direction
    return factor * sp.Matrix([sp.Rational(round(float(value) * 10**6), 10**6) for value in oriented])


def _is_clearly_as_intended(velocity: RoundedVector, lost_unit_vector: np.ndarray, is_possible: bool) -> bool:
    """Return whether the arm can clearly produce a velocity if `is_possible`, and clearly can't otherwise.

    The arm can produce a velocity without a component along the lost direction. It clearly can't produce one with a
    large component.
    """
    numbers = np.array([float(value) for value in velocity])
    lost_share = abs(float(numbers @ lost_unit_vector)) / float(np.linalg.norm(numbers))
    return lost_share < 0.012 if is_possible else lost_share > 0.5


def _is_new(velocity: RoundedVector, chosen_velocities: list[RoundedVector]) -> bool:
    opposite = tuple(-value for value in velocity)
    return all(_differ_clearly(v, previous) for previous in chosen_velocities for v in (velocity, opposite))


QUESTIONS = (
    Question(
        "jacobian-size", "Size of the Jacobian", "6.4", points=0.5, sample=_ask_jacobian_size,
        objection=_object_to_task, entry_names=lambda chain, _: [r"\text{rows}", r"\text{columns}"],
    ),
    Question(
        "joint-effect", "Velocity caused by one joint", "6.12",
        sample=_ask_effect, formula=_derive_effect, objection=_object_to_effect,
    ),
    Question("invertibility", "When (6.7) applies", "6.7", sample=_ask_invertibility),
    Question(
        "unreachable-velocity", "Velocities lost at a singularity", "6.8", sample=_ask_unreachable_velocity,
        objection=_object_to_velocity_loss,
    ),
)  # fmt: skip
