"""Questions on how well an arm moves at a configuration: manipulability and condition number of its Jacobian.

The manipulability w = sqrt(det(J J^T)) is the product of the singular values of J, and |det J| if J is square. The
condition number kappa is the largest singular value divided by the smallest. Both compare or multiply entries of J, so
the questions apply only if the units allow that.
"""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answer_types import Number
from qdot.exercises.arm import mpmath_kinematics as precise
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.mpmath_kinematics import PRECISE_CONTEXT, Vector
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE, ConfigurationAndVelocity, VelocityDetails
from qdot.exercises.questions.redundancy import object_to_mixed_joints, object_to_rank_loss_everywhere


def _object_to_arm(chain: Chain) -> str | None:
    """Return the objection to arms whose w is always zero, is constant, or mixes units."""
    m, n = len(chain.task), chain.n
    rows = ", ".join(chain.task)
    if n < m:
        return f"it has {count_noun(n, 'joint')} for the {m} rows {rows}, so J J^T is singular everywhere"
    if len({row[0] for row in chain.task}) > 1:
        return f"its task {rows} has linear and angular rows, in different units"
    if n > m and (objection := object_to_mixed_joints(chain)):
        return objection
    if not chain.revolute_joints:
        return "its Jacobian is the same in every configuration"
    return object_to_rank_loss_everywhere(chain)


def _object_to_ratio(chain: Chain) -> str | None:
    if len(chain.task) == 1:
        return "its Jacobian has only one row, so only one singular value"
    return object_to_mixed_joints(chain) or _object_to_arm(chain)


def find_power_of_metres(chain: Chain) -> int:
    """Return k for the unit m^k of w: the number of linear rows less the number of prismatic joints."""
    linear_row_count = sum(row[0] == "v" for row in chain.task)
    return linear_row_count - len(chain.prismatic_joints)


def _ask_manipulability(chain: Chain, rng: Stream) -> AnswerAndDetails:
    situation = inversion.sample_situation(chain, rng)
    gram = precise.gram_matrix(inversion.evaluate_jacobian_precisely(chain, situation))
    value = precise.round_to_ten_digits(PRECISE_CONTEXT.sqrt(precise.determinant(gram)))
    power = find_power_of_metres(chain)
    unit = {0: "", 1: "m"}.get(power, f"m^{power}")
    return Number(sp.Matrix([value]), (unit,), THREE_DIGIT_TOLERANCE, 1e-9), _describe_measures(chain, situation, power)


@dataclass(frozen=True, kw_only=True)
class GramDetails(VelocityDetails):
    """Details about J J^T at a configuration: its eigenvalues, the largest first, and k if the unit of w is m^k."""

    gram: sp.Matrix
    eigenvalues: tuple[sp.Float, ...]
    power: int | None = None


def _describe_measures(chain: Chain, situation: ConfigurationAndVelocity, power: int | None = None) -> GramDetails:
    squares = sorted((value**2 for value in compute_singular_values(chain, situation)), reverse=True)
    return GramDetails(
        situation=situation,
        gram=precise.round_matrix(precise.gram_matrix(inversion.evaluate_jacobian_precisely(chain, situation))),
        eigenvalues=tuple(map(precise.round_to_four_digits, squares)),
        power=power,
        pose=situation.figure_values,
    )


def compute_singular_values(chain: Chain, situation: ConfigurationAndVelocity) -> Vector:
    """Return the singular values of the task Jacobian at a situation's configuration, to 30 digits."""
    jacobian = PRECISE_CONTEXT.matrix(inversion.evaluate_jacobian_precisely(chain, situation))
    return list(PRECISE_CONTEXT.svd_r(jacobian, compute_uv=False))


def _ask_condition_number(chain: Chain, rng: Stream) -> AnswerAndDetails:
    situation = inversion.sample_situation(chain, rng)
    sigma = compute_singular_values(chain, situation)
    value = precise.round_to_ten_digits(max(sigma) / min(sigma))
    return Number(sp.Matrix([value]), ("",), THREE_DIGIT_TOLERANCE, 1e-9), _describe_measures(chain, situation)


QUESTIONS = (
    Question(
        "manipulability", "Manipulability at a configuration", "below 6.8", needs=("jacobian",), stage="manipulability",
        sample=_ask_manipulability, entry_names=lambda chain, _: ["w"], objection=_object_to_arm,
    ),
    Question(
        "condition-number", "Condition number at a configuration", "below 6.8", needs=("jacobian",),
        stage="condition number", sample=_ask_condition_number, entry_names=lambda chain, _: [r"\kappa"],
        objection=_object_to_ratio,
    ),
)  # fmt: skip
