"""Questions on concepts: the size of J, the velocity that a joint causes, and when equation (6.7) applies.

(6.7) computes joint rates with the inverse of J. The last two questions have options. Velocities in options are rounded
to three decimals.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.mpmath_kinematics import (
    compute_determinant,
    evaluate_in_context,
    round_matrix,
    round_to_four_digits,
)
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.derivation.graph import StageResults
from qdot.exercises.problem.problem import recorded_as
from qdot.exercises.questions.base import AnswerAndDetails, Question, shuffle_options
from qdot.exercises.questions.differentiation import TaskDetails
from qdot.exercises.questions.exact_configurations import (
    ConfigurationDetails,
    ExactConfiguration,
    evaluate_precisely,
    make_exact_configuration,
    round_to_integer,
    sample_from_any_component,
    sample_regular_configuration,
    sample_unequal_lengths,
)
from qdot.exercises.questions.inversion import sample_joint_values
from qdot.exercises.reference_answers import Number
from qdot.exercises.reference_answers.formulas import COUNT_TOLERANCE

MAX_EFFECT_TRIES = 60
"""Maximum number of configurations sampled for a joint's effect."""
MAX_TASKS, MIN_REGULAR_RATIO = 6, 0.06
"""Maximum number of tasks that are tried for each answer about (6.7), and minimum sigma_min/sigma_max of a regular
J."""
MIN_EFFECT, MIN_WRONG_EFFECT = 0.1, 0.05
"""Minimum velocity due to a joint at unit rate (m/s or rad/s): in a correct option, and in a wrong one."""
MIN_OPTION_DIFFERENCE = 0.2
"""Minimum norm of the difference of two vectors offered as options, as a fraction of the larger norm."""
RoundedVector = tuple[sp.Rational, ...]
"""A vector whose entries are rounded to three decimals."""

# --- size of J ---


def _list_other_tasks(chain: Chain) -> list[tuple[str, ...]]:
    """Return the tasks (choices of velocity components), other than the arm's usual task, with no zero row in J."""
    rows = find_moving_rows(derive(chain).geometric_jacobian)
    tasks = [task for size in range(1, len(rows) + 1) for task in combinations(rows, size)]
    return [task for task in tasks if task != chain.task]


def find_moving_rows(geometric: sp.Matrix) -> tuple[str, ...]:
    """Return the names of the rows of a 6 x n Jacobian that are not identically zero."""
    return tuple(name for name, row in zip(VELOCITY_NAMES, geometric.tolist(), strict=True) if any(row))


def _ask_jacobian_size(chain: Chain, rng: Stream) -> AnswerAndDetails:
    """Choose a number of rows, then a task with this number, and ask for the size of its Jacobian."""
    tasks = _list_other_tasks(chain)
    size = rng.choice(sorted({len(task) for task in tasks}))
    task = rng.choice([task for task in tasks if len(task) == size])
    answer = Number(sp.Matrix([size, chain.n]), ("", ""), COUNT_TOLERANCE, COUNT_TOLERANCE)
    return answer, TaskDetails(task=task)


# --- effect of one joint ---


@dataclass(frozen=True, kw_only=True)
class JointEffectDetails(ConfigurationDetails):
    """Details of a question about the velocity that one joint causes at a configuration.

    `joint` is the number of the joint, and `rows` are the names of the components of velocity that the options show.
    """

    joint: int = field(metadata=recorded_as("effect.joint"))
    configuration: ExactConfiguration = field(metadata=recorded_as("effect.place"))
    rows: tuple[str, ...] = field(metadata=recorded_as("effect.rows"))


def _choose_rows(chain: Chain) -> tuple[str, ...]:
    """Return the velocity components that options on a joint's effect show.

    Options show the velocity of P. If the task has no linear rows, or if P moves in one component only, they show the
    angular velocity of the last link.
    """
    rows = find_moving_rows(derive(chain).geometric_jacobian)
    is_linear = bool(chain.linear_axes) and sum(row[0] == "v" for row in rows) >= 2
    return tuple(row for row in rows if row[0] == ("v" if is_linear else "w"))


def _ask_effect(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Offer the correct column and a wrong one, and both with the opposite sign, so that the sign reveals nothing."""
    rows = _choose_rows(chain)
    indices = [VELOCITY_NAMES.index(row) for row in rows]
    for _ in range(MAX_EFFECT_TRIES):
        lengths, joint_values = sample_unequal_lengths(chain, rng), sample_joint_values(chain, rng)
        configuration = make_exact_configuration(chain, lengths, joint_values)
        jacobian = evaluate_precisely(chain, configuration, derive(chain).geometric_jacobian)[indices, :]
        moving_joints = [i for i in range(chain.n) if _compute_norm(jacobian.col(i)) > MIN_EFFECT]
        if not moving_joints:
            continue
        joint_index = rng.choice(moving_joints)
        wrong_columns = _make_wrong_columns(chain, configuration, joint_index, jacobian, [i for i in indices if i < 3])
        correct = _round_vector(jacobian.col(joint_index))
        rounded_columns = map(_round_vector, wrong_columns)
        candidates = [column for column in rounded_columns if not _are_nearly_parallel(correct, column)]
        if candidates:
            columns = (correct, rng.choice(candidates))
            options = [tuple(sign * value for value in column) for column in columns for sign in (1, -1)]
            answer, _ = shuffle_options(options, options[0], rng, write_vector)
            return answer, JointEffectDetails(joint=joint_index + 1, configuration=configuration, rows=rows)
    return None


def _compute_effect(stages: StageResults, details: JointEffectDetails) -> np.ndarray:
    return np.asarray(
        stages["geometric jacobian"][[VELOCITY_NAMES.index(row) for row in details.rows], details.joint - 1]
    )


def _make_wrong_columns(
    chain: Chain, configuration: ExactConfiguration, joint_index: int, jacobian: sp.Matrix, linear_rows: list[int]
) -> list[sp.Matrix]:
    """Return wrong columns for a joint; `jacobian` has the rows of J that the options show.

    The wrong columns are those of other joints, the vector p* of the joint, the cross product of its axis with the p*
    of the next origin, and the correct column with x and y confused. For a prismatic joint, the cross product is with
    the joint's own p*, as if the joint were revolute. Columns that are nearly zero are left out. `linear_rows` are
    the linear rows (0 to 2) among the shown rows.
    """
    column = jacobian.col(joint_index)
    vectors = [jacobian.col(i) for i in range(chain.n) if i != joint_index]
    if linear_rows:
        z = evaluate_precisely(chain, configuration, derive(chain).z)
        p_star = evaluate_precisely(chain, configuration, derive(chain).p_star)
        vectors.append(p_star.col(joint_index).extract(linear_rows, [0]))
        origin = joint_index + 1 if chain.joints[joint_index].is_revolute else joint_index
        if origin < chain.n:
            vectors.append(z.col(joint_index).cross(p_star.col(origin)).extract(linear_rows, [0]))
    x, y, *other_entries = column
    vectors += [sp.Matrix([*confused_xy, *other_entries]) for confused_xy in ((-y, x), (y, x), (x, -y))]
    return [vector for vector in vectors if _compute_norm(vector) > MIN_WRONG_EFFECT]


def _compute_norm(vector: Iterable[sp.Expr]) -> float:
    """Return the norm of a vector. The exact sum (fsum) gives the same result on all machines."""
    return math.sqrt(math.fsum(float(value) ** 2 for value in vector))


def _round_vector(vector: sp.Matrix) -> RoundedVector:
    return tuple(sp.Rational(round_to_integer(sp.Float(value, 30) * 1000), 1000) for value in vector)


def write_vector(vector: RoundedVector) -> str:
    """Return a vector as the text of an option, with three decimals per entry.

    >>> write_vector((sp.Rational(1, 3).limit_denominator(1000), sp.S(-2)))
    '(0.333, -2.000)'
    """
    numbers = (float(value) + 0.0 for value in vector)  # + 0.0 turns -0.0 into 0.0
    return f"({', '.join(f'{number:.3f}' for number in numbers)})"


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
"""Maps each kind of Jacobian to the answer whether (6.7) can be used; "few" stands for too few joints."""


@dataclass(frozen=True, kw_only=True)
class InvertibilityDetails(ConfigurationDetails):
    """Details of a question that asks whether (6.7) applies to a task at a configuration.

    `answer_key` is the key of the correct answer in INVERTIBILITY_ANSWERS. `numeric_jacobian` is J for the task, to
    four digits, and `determinant` is det J if J is square.
    """

    answer_key: str = field(metadata=recorded_as("use"))
    task: tuple[str, ...]
    numeric_jacobian: sp.Matrix = field(metadata=recorded_as("numbers"))
    determinant: sp.Float | None = None


def _ask_invertibility(chain: Chain, rng: Stream) -> AnswerAndDetails | None:
    """Choose an answer, then a task and a configuration for which the answer is correct."""
    keys = tuple(INVERTIBILITY_ANSWERS)
    for answer_key in rng.permutation(keys):
        for task in rng.permutation(_list_tasks(chain, answer_key))[:MAX_TASKS]:
            task_chain = chain.with_task(*task)
            if answer_key == "singular":
                configuration = sample_from_any_component(task_chain, rng)
            else:
                configuration = sample_regular_configuration(
                    task_chain, rng, MIN_REGULAR_RATIO, prefers_seemingly_singular=answer_key == "regular"
                )
            if configuration is not None:
                answer, _ = shuffle_options(keys, answer_key, rng, INVERTIBILITY_ANSWERS.__getitem__)
                return answer, _make_invertibility_details(task_chain, answer_key, configuration)
    return None


def _make_invertibility_details(
    chain: Chain, answer_key: str, configuration: ExactConfiguration
) -> InvertibilityDetails:
    jacobian = evaluate_precisely(chain, configuration, derive(chain).jacobian)
    numbers = [[evaluate_in_context(value) for value in row] for row in jacobian.tolist()]
    return InvertibilityDetails(
        answer_key=answer_key,
        task=chain.task,
        configuration=configuration,
        numeric_jacobian=round_matrix(numbers),
        determinant=round_to_four_digits(compute_determinant(numbers)) if jacobian.is_square else None,
    )


@lru_cache(maxsize=1024)
def _list_tasks(chain: Chain, answer_key: str) -> tuple[tuple[str, ...], ...]:
    """Return the tasks whose J has the shape that an answer needs; only the usual task, if both J are square."""
    rows = find_moving_rows(derive(chain).geometric_jacobian)
    if answer_key in ("regular", "singular"):
        if chain.has_square_jacobian:
            return (chain.task,)
        return tuple(combinations(rows, chain.n)) if chain.n <= 3 else ()
    row_counts = range(1, chain.n) if answer_key == "redundant" else range(chain.n + 1, len(rows) + 1)
    return tuple(task for size in row_counts for task in combinations(rows, size))


def _are_nearly_parallel(a: RoundedVector, b: RoundedVector) -> bool:
    """Return whether a vector is nearly a multiple, perhaps a negative multiple, of another vector."""
    product = sum(x * y for x, y in zip(a, b, strict=True))
    projection = [product / sum(x**2 for x in a) * x for x in a]
    distance = _compute_norm(y - x for y, x in zip(b, projection, strict=True))
    return distance <= MIN_OPTION_DIFFERENCE * max(_compute_norm(b), _compute_norm(projection))


QUESTIONS = (
    Question(
        "jacobian-size", "Size of the Jacobian", "6.4", points=0.5, sample=_ask_jacobian_size,
        find_arm_objection=lambda chain: None if _list_other_tasks(chain) else (
            "its velocity has only one component, which is also its task"
        ),
        name_entries=lambda chain, _: [r"\text{rows}", r"\text{columns}"],
    ),
    Question(
        "joint-effect", "Velocity caused by one joint", "6.12", sample=_ask_effect, compute=_compute_effect,
        find_arm_objection=lambda chain: None if len(_choose_rows(chain)) >= 2 else (
            "its velocity has only one component, along a fixed line"
        ),
    ),
    Question("invertibility", "Invertibility of the Jacobian", "6.7", sample=_ask_invertibility),
)  # fmt: skip
