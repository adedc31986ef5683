"""Questions on redundant arms (n > m): det(J J^T), minimum-norm joint rates by the pseudo-inverse, and self-motion.

J is m x n. By the Cauchy-Binet formula, det(J J^T) is the sum of the squares of the maximal minors. The pseudo-inverse
J^T (J J^T)^-1 gives the minimum-norm joint rates. For n = m + 1, the minors with alternating signs span the null space.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.answer_types import Direction, Expression
from qdot.exercises.arm import mpmath_kinematics as precise
from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, symbolic_arm_of
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, PreciseArm, Vector
from qdot.exercises.arm.trigonometry import Factored, factor_trig
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question, name_joint_rates
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE, VelocityDetails

MAX_TERMS = 12
"""Maximum number of terms of det(J J^T) to work out by hand. A self-motion may have half as many."""

ZERO_TOLERANCE = 1e-9
"""Limit below which a singular value or a column counts as zero."""

MAX_JOINTS = 4
"""Maximum number of joints for which minors are worked out as formulas by hand."""


def object_unless_redundant(chain: Chain) -> str | None:
    """Return the objection to an arm that is not redundant, loses rank everywhere, or has a joint without effect."""
    m, n = len(chain.task), chain.n
    if n <= m:
        task = ", ".join(chain.task)
        return f"its Jacobian is {m} x {n} for the task {task}; the question needs more joints than rows"
    if objection := object_to_rank_loss_everywhere(chain):
        return objection
    has_effect = np.abs(evaluate_jacobian_at_generic_configuration(chain)).max(axis=0) >= ZERO_TOLERANCE
    return None if has_effect.all() else f"joint {has_effect.argmin() + 1} does not move the task at all"


def evaluate_jacobian_at_generic_configuration(chain: Chain) -> np.ndarray:
    """Return the task Jacobian (m x n) at a generic configuration, for tests of its rank."""
    values = {symbol: sp.Rational(3 * i + 5, 10) for i, symbol in enumerate(chain.parameters)}
    return np.array(PreciseArm(chain, values, FLOAT_CONTEXT).task_jacobian([0.3 + 0.7 * i for i in range(chain.n)]))


def object_to_symbolic_angles(chain: Chain) -> str | None:
    """Return the objection to an arm with a symbolic angle in its table, because only lengths are sampled."""
    angles = [symbol.name for symbol in chain.parameters if symbol.name.startswith(("alpha", "beta"))]
    return f"its angle {angles[0]} is symbolic" if angles else None


def object_to_rank_loss_everywhere(chain: Chain) -> str | None:
    """Return the objection to an arm that has no numeric configuration of full rank."""
    if objection := object_to_symbolic_angles(chain):
        return objection
    sigma = np.linalg.svd(evaluate_jacobian_at_generic_configuration(chain), compute_uv=False)
    return "its Jacobian has less than full rank everywhere" if sigma[-1] <= ZERO_TOLERANCE * sigma[0] else None


def object_to_mixed_joints(chain: Chain) -> str | None:
    """Return the objection to an arm with revolute and prismatic joints: their rates have no common unit."""
    if len({joint.kind for joint in chain.joints}) > 1:
        return "it has revolute and prismatic joints, whose rates have different units"
    return None


def _object_to_minimum_norm(chain: Chain) -> str | None:
    return object_unless_redundant(chain) or object_to_mixed_joints(chain)


# --- det(J J^T) ---


def _object_to_length(chain: Chain) -> str | None:
    if chain.n > MAX_JOINTS or _count_terms(_derive_gram(symbolic_arm_of(chain).chain)) > MAX_TERMS:
        return "det(J J^T) is too long to work out by hand"
    return None


@dataclass(frozen=True, kw_only=True)
class MinorDetails(Details):
    """Details about the maximal minors: the factors that all of them share, and the squares of the quotients."""

    shared: sp.Expr
    squares: tuple[sp.Expr, ...]


def _write_gram_determinant(chain: Chain) -> sp.Expr:
    return _derive_gram(symbolic_arm_of(chain).chain).substitute(dict(symbolic_arm_of(chain).values))


def _describe_gram(chain: Chain, rng: Stream) -> MinorDetails:
    values = dict(symbolic_arm_of(chain).values)
    squares = tuple(
        minor.substitute(values) ** 2 for minor in factor_out_common_factors(symbolic_arm_of(chain).chain)[1]
    )
    return MinorDetails(shared=_find_shared_factors(chain), squares=squares)


def _find_shared_factors(chain: Chain) -> sp.Expr:
    """Return the product of the factors that all maximal minors share, or 1 if there are none."""
    arm_structure = symbolic_arm_of(chain)
    return factor_out_common_factors(arm_structure.chain)[0].substitute(dict(arm_structure.values))


@lru_cache(maxsize=1024)
def _derive_gram(chain: Chain) -> Factored:
    """Return det(J J^T) of a structure: the squared shared factors of all minors, times a sum of squares."""
    shared_factors, quotients = factor_out_common_factors(chain)
    squares = sp.Add(*(Factored(abs(minor.coefficient), minor.factors).expression() ** 2 for minor in quotients))
    factored = factor_trig(sp.expand(squares)).expression() if len(quotients) > 1 else squares
    shortest_form = min((squares, factored), key=lambda form: len(sp.Add.make_args(form)) + sp.count_ops(form))
    squared_factors = tuple((factor, 2 * power) for factor, power in shared_factors.factors)
    return Factored(shared_factors.coefficient**2, (*squared_factors, (shortest_form, 1)))


@lru_cache(maxsize=1024)
def factor_out_common_factors(chain: Chain) -> tuple[Factored, tuple[Factored, ...]]:
    """Return the factors that all maximal minors of a structure share, and the quotient of each minor by them."""
    minors = derive(chain).symbolic_minors
    nonzero_minors = [minor for minor in minors if not minor.is_zero]
    powers = [dict(minor.factors) for minor in nonzero_minors]
    common_powers = {f: min(p.get(f, 0) for p in powers) for f in powers[0]} if powers else {}
    coefficient = sp.gcd([minor.coefficient for minor in nonzero_minors])
    shared_factors = Factored(coefficient, tuple((f, power) for f, power in common_powers.items() if power))
    return shared_factors, tuple(minor if minor.is_zero else minor.over(shared_factors) for minor in minors)


def _count_terms(product: Factored) -> int:
    """Return the number of terms in the sums of a product, including those of nested sums."""
    expression = product.expression()
    return _count_leaves(expression.xreplace({trig: sp.Dummy() for trig in expression.atoms(sp.sin, sp.cos)}))


def _count_leaves(expression: sp.Expr) -> int:
    if expression.is_Add:
        return sum(map(_count_leaves, expression.args))
    return max(1, sum(_count_leaves(factor) for factor in expression.args if factor.has(sp.Add)))


# --- minimum-norm joint rates ---


@dataclass(frozen=True, kw_only=True)
class MinimumNormDetails(VelocityDetails):
    """Details of a question about joint rates J^T w: the matrix J J^T, and the weights w that solve J J^T w = v."""

    gram: sp.Matrix
    weights: sp.Matrix


def _ask_minimum_norm_rates(chain: Chain, rng: Stream) -> AnswerAndDetails:
    situation = inversion.sample_situation(chain, rng)
    arm = PreciseArm(chain, situation.lengths)
    jacobian = inversion.evaluate_jacobian_precisely(chain, situation)
    gram = precise.gram_matrix(jacobian)
    weights = precise.solve_linear(gram, [arm.evaluate_number(value) for value in situation.velocity.values()])
    rates = [sum(row[i] * weight for row, weight in zip(jacobian, weights, strict=True)) for i in range(chain.n)]
    return inversion.make_joint_rates(chain, rates, max(map(abs, rates))), MinimumNormDetails(
        situation=situation,
        gram=precise.round_matrix(gram),
        weights=precise.round_matrix([[weight] for weight in weights]),
        pose=situation.figure_values,
    )


# --- self-motion ---


def _object_to_motion(chain: Chain) -> str | None:
    if objection := object_unless_redundant(chain):
        return objection
    m, n = len(chain.task), chain.n
    if n != m + 1:
        return f"its self-motion for the task {', '.join(chain.task)} has {n - m} dimensions, not one"
    if n <= MAX_JOINTS and sum(not minor.is_zero for minor in derive(chain).symbolic_minors) < 2:
        return "one of its joints does not affect the task"
    return None


@dataclass(frozen=True, kw_only=True)
class SelfMotionFormulaDetails(Details):
    """Details about a self-motion as formulas, without a configuration: the factors that all maximal minors share."""

    situation: None
    shared: sp.Expr


def _ask_self_motion(chain: Chain, rng: Stream) -> AnswerAndDetails:
    generic = symbolic_arm_of(chain).chain
    if chain.n <= MAX_JOINTS and sum(map(_count_terms, factor_out_common_factors(generic)[1])) <= MAX_TERMS / 2:
        details = SelfMotionFormulaDetails(situation=None, shared=_find_shared_factors(chain))
        return Direction(write_self_motion(chain)), details
    situation = inversion.sample_situation(chain, rng)
    jacobian = inversion.evaluate_jacobian_precisely(chain, situation)
    numbers = sp.Matrix(list(map(precise.round_to_ten_digits, compute_null_vector(jacobian))))
    return Direction(numbers, THREE_DIGIT_TOLERANCE), VelocityDetails(situation=situation, pose=situation.figure_values)


def compute_null_vector(jacobian: list[Vector]) -> Vector:
    """Return the unit vector (up to its sign) in the null space of an m x (m + 1) matrix of full rank.

    To project a unit vector e_k on the null space, subtract its part J^T (J J^T)^-1 J e_k in the row space.
    """
    n = len(jacobian[0])
    for k in range(n):
        weights = precise.solve_linear(precise.gram_matrix(jacobian), [row[k] for row in jacobian])
        projection = [(i == k) - sum(row[i] * w for row, w in zip(jacobian, weights, strict=True)) for i in range(n)]
        if projection[k] > 1 / (2 * n):  # the square of the null vector's entry k; for one k it is at least 1/n
            norm = sum(value**2 for value in projection) ** 0.5
            return [value / norm for value in projection]
    raise ValueError("the matrix has more than one direction in its null space, or none")


def write_self_motion(chain: Chain) -> sp.Matrix:
    """Return joint rates with zero task velocity, n x 1 for n = m + 1: entry i is (-1)^i times the minor without i.

    Factors that all minors share are omitted, so the vector is zero only where J loses rank for more than one reason.
    """
    arm_structure = symbolic_arm_of(chain)
    _, quotients = factor_out_common_factors(arm_structure.chain)
    # The minors are in the order of the columns that they contain, so the first one omits the last column.
    minors = [minor.substitute(dict(arm_structure.values)) for minor in reversed(quotients)]
    return sp.Matrix([(-1) ** i * minor for i, minor in enumerate(minors)])


QUESTIONS = (
    Question(
        "gram-determinant", "det(J Jᵀ) of a redundant arm", "6.8 for m < n", points=2.0, needs=("jacobian",),
        stage="gram determinant", textbook_stages={"gram determinant": _write_gram_determinant}, answer_type=Expression,
        make_details=_describe_gram, entry_names=lambda chain, _: [r"\det(J J^T)"],
        objection=_object_to_minimum_norm, too_long=_object_to_length, is_made_of_jacobian=True, is_made_of_minors=True,
    ),
    Question(
        "least-norm-rates", "Minimum-norm joint rates", "6.7 for m < n", needs=("jacobian",),
        formula=lambda w, _: apply_matrix(w["pseudo-inverse"], w["wanted velocity"]), sample=_ask_minimum_norm_rates,
        typed_names=name_joint_rates, objection=_object_to_minimum_norm, is_made_of_jacobian=True,
    ),
    Question(
        "self-motion", "Self-motion of a redundant arm", "6.4 for m < n", needs=("jacobian",), stage="self-motion",
        sample=_ask_self_motion, typed_names=name_joint_rates, objection=_object_to_motion, is_made_of_jacobian=True,
    ),
)  # fmt: skip
