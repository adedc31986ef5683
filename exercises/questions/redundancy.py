"""Questions on J J^T, for redundant and other arms, and on the null space of J; J is m x n.

- det(J J^T) is, by the Cauchy–Binet formula, the sum of the squares of the maximal minors of J.
- The pseudo-inverse J^T (J J^T)^-1 gives the minimum-norm joint rates.
- The manipulability w = sqrt(det(J J^T)) is the product of the singular values of J, and |det J| if J is square.
- The condition number kappa is the largest singular value divided by the smallest.
- For n = m + 1, the maximal minors with alternating signs span the null space of J, the self-motion.

Manipulability and condition number combine all entries of J, so these questions apply only if the entries' units fit.
Formulas are derived once for the structure of an arm, which is the arm with symbols for all lengths and oblique angles.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm import mpmath_kinematics as precise
from qdot.exercises.arm.chain import Chain, is_angle_symbol
from qdot.exercises.arm.mpmath_kinematics import FLOAT_CONTEXT, PRECISE_CONTEXT, MpmathArm, Vector
from qdot.exercises.arm.trigonometry import Factored, factor_trig
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.formula.units import write_power_of_metres
from qdot.exercises.problem.problem import Details, recorded_as
from qdot.exercises.questions import inversion
from qdot.exercises.questions.base import AnswerAndDetails, Question, name_joint_rates
from qdot.exercises.questions.inversion import THREE_DIGIT_TOLERANCE, ConfigurationAndVelocity, VelocityDetails
from qdot.exercises.reference_answers import Direction, Expression, Number

MAX_TERMS = 12
"""Maximum number of terms of det(J J^T) to work out by hand; a self-motion may have half as many terms."""

ZERO_TOLERANCE = 1e-9
"""A ratio of singular values, or the largest entry of a column, counts as zero below this limit."""

MAX_JOINTS = 4
"""Maximum number of joints for which minors are worked out as formulas by hand."""

# --- objections to arms ---


def _evaluate_generic_jacobian(chain: Chain) -> np.ndarray:
    """Return the task Jacobian (m x n) at an arbitrary configuration, to test the rank of the Jacobian."""
    values = {symbol: sp.Rational(3 * i + 5, 10) for i, symbol in enumerate(chain.parameters)}
    return np.array(
        MpmathArm(chain, values, FLOAT_CONTEXT).compute_task_jacobian([0.3 + 0.7 * i for i in range(chain.n)])
    )


def find_symbolic_angle_objection(chain: Chain) -> str | None:
    """Return why an arm is unsuitable (a symbolic angle in its table), or None if it is suitable.

    No numbers are sampled for symbolic angles.
    """
    angles = [symbol.name for symbol in chain.parameters if is_angle_symbol(symbol)]
    return f"its angle {angles[0]} is symbolic" if angles else None


def _find_rank_objection(chain: Chain) -> str | None:
    """Return why an arm is unsuitable (its Jacobian never has full rank), or None if it is suitable."""
    if objection := find_symbolic_angle_objection(chain):
        return objection
    sigma = np.linalg.svd(_evaluate_generic_jacobian(chain), compute_uv=False)
    return "its Jacobian has less than full rank everywhere" if sigma[-1] <= ZERO_TOLERANCE * sigma[0] else None


def _find_redundancy_objection(chain: Chain) -> str | None:
    """Return why an arm is unsuitable, or None if it is suitable.

    It is unsuitable if it is not redundant, never has full rank, or has a joint without effect.
    """
    m, n = len(chain.task), chain.n
    if n <= m:
        task = ", ".join(chain.task)
        return f"its Jacobian is {m} x {n} for the task {task}; the question needs more joints than rows"
    if objection := _find_rank_objection(chain):
        return objection
    has_effect = np.abs(_evaluate_generic_jacobian(chain)).max(axis=0) >= ZERO_TOLERANCE
    return None if has_effect.all() else f"joint {has_effect.argmin() + 1} does not move the task at all"


def _find_mixed_joints_objection(chain: Chain) -> str | None:
    """Return why an arm is unsuitable (rates with different units), or None if it is suitable."""
    is_mixed = len({joint.kind for joint in chain.joints}) > 1
    return "it has revolute and prismatic joints, whose rates have different units" if is_mixed else None


def _find_minimum_norm_objection(chain: Chain) -> str | None:
    return _find_redundancy_objection(chain) or _find_mixed_joints_objection(chain)


# --- det(J J^T) ---


@dataclass(frozen=True, kw_only=True)
class MinorDetails(Details):
    """Details about the maximal minors: the product of the factors that all of them share, and the other factors.

    `squares` are the squares of the minors after division by the shared factors.
    """

    shared_factors: sp.Expr = field(metadata=recorded_as("shared"))
    squares: tuple[sp.Expr, ...]


def _make_minor_details(chain: Chain, rng: Stream) -> MinorDetails:
    squares = tuple(_substitute_numbers(chain, quotient) ** 2 for quotient in _factor_minors_of(chain).quotients)
    return MinorDetails(shared_factors=_find_shared_factors(chain), squares=squares)


def _find_shared_factors(chain: Chain) -> sp.Expr:
    """Return the product of the factors that all maximal minors share, or 1 if there are none."""
    return _substitute_numbers(chain, _factor_minors_of(chain).shared_factors)


def _substitute_numbers(chain: Chain, product: Factored) -> sp.Expr:
    """Return a product that was derived for the structure of an arm, with the arm's own numbers."""
    return product.substitute(dict(make_symbolic_arm(chain).values))


@lru_cache(maxsize=1024)
def _derive_gram_determinant(symbolic_chain: Chain) -> Factored:
    """Return det(J J^T) of a structure: the squared shared factors of all minors, times a sum of squares."""
    shared_factors, quotients = _factor_minors(symbolic_chain)
    products = (Factored(abs(quotient.coefficient), quotient.factors) for quotient in quotients)
    squares = sp.Add(*(product.to_expression() ** 2 for product in products))
    factored_sum = factor_trig(sp.expand(squares)).to_expression() if len(quotients) > 1 else squares
    shortest_form = min((squares, factored_sum), key=lambda form: len(sp.Add.make_args(form)) + sp.count_ops(form))
    squared_factors = tuple((factor, 2 * power) for factor, power in shared_factors.factors)
    return Factored(shared_factors.coefficient**2, (*squared_factors, (shortest_form, 1)))


class FactoredMinors(NamedTuple):
    """The maximal minors of J: the factors that all of them share, and the quotient of each minor by these factors."""

    shared_factors: Factored
    quotients: tuple[Factored, ...]


def _factor_minors_of(chain: Chain) -> FactoredMinors:
    """Return the maximal minors of an arm's structure and the factors that they share."""
    return _factor_minors(make_symbolic_arm(chain).chain)


@lru_cache(maxsize=1024)
def _factor_minors(symbolic_chain: Chain) -> FactoredMinors:
    """Return the maximal minors of a structure without the factors that they share, and these factors."""
    minors = derive(symbolic_chain).symbolic_minors
    nonzero_minors = [minor for minor in minors if not minor.is_zero]
    all_powers = [dict(minor.factors) for minor in nonzero_minors]
    first_factors = all_powers[0] if all_powers else {}
    shared_powers = {factor: min(powers.get(factor, 0) for powers in all_powers) for factor in first_factors}
    coefficient = sp.gcd([minor.coefficient for minor in nonzero_minors])
    shared_factors = Factored(coefficient, tuple((factor, power) for factor, power in shared_powers.items() if power))
    quotients = tuple(minor if minor.is_zero else minor.divide_by(shared_factors) for minor in minors)
    return FactoredMinors(shared_factors, quotients)


def _count_terms(product: Factored) -> int:
    """Return the number of terms of all sums in a product, also of nested sums."""

    def count(expression: sp.Expr) -> int:
        if expression.is_Add:
            return sum(map(count, expression.args))
        return max(1, sum(count(factor) for factor in expression.args if factor.has(sp.Add)))

    expression = product.to_expression()  # a sum of angles in a sine or cosine does not count
    return count(expression.xreplace({trig: sp.Dummy() for trig in expression.atoms(sp.sin, sp.cos)}))


def _find_gram_size_objection(chain: Chain) -> str | None:
    if chain.n > MAX_JOINTS or _count_terms(_derive_gram_determinant(make_symbolic_arm(chain).chain)) > MAX_TERMS:
        return "det(J J^T) is too long to work out by hand"
    return None


# --- minimum-norm joint rates ---


@dataclass(frozen=True, kw_only=True)
class MinimumNormDetails(VelocityDetails):
    """Details of a question about minimum-norm joint rates J^T w: the matrix J J^T, and w, which solves J J^T w = v."""

    gram: sp.Matrix
    weights: sp.Matrix


def _ask_minimum_norm_rates(chain: Chain, rng: Stream) -> AnswerAndDetails:
    configuration = inversion.sample_configuration_and_velocity(chain, rng)
    arm = MpmathArm(chain, configuration.lengths)
    jacobian = inversion.evaluate_jacobian_precisely(chain, configuration)
    gram = precise.compute_gram_matrix(jacobian)
    weights = precise.solve_linear(gram, [arm.evaluate_number(value) for value in configuration.velocity.values()])
    rates = [sum(row[i] * weight for row, weight in zip(jacobian, weights, strict=True)) for i in range(chain.n)]
    return inversion.make_rates_answer(chain, rates, max(map(abs, rates))), MinimumNormDetails(
        configuration=configuration,
        gram=precise.round_matrix(gram),
        weights=precise.round_matrix([[weight] for weight in weights]),
        pose=configuration.figure_values,
    )


# --- manipulability and condition number ---


def _find_manipulability_objection(chain: Chain) -> str | None:
    """Return why an arm is unsuitable, or None if it is suitable.

    It is unsuitable if its manipulability is always zero, is constant, or mixes units.
    """
    m, n = len(chain.task), chain.n
    rows = ", ".join(chain.task)
    if n < m:
        return f"it has {count_noun(n, 'joint')} for the {m} rows {rows}, so J J^T is singular everywhere"
    if len({row[0] for row in chain.task}) > 1:
        return f"its task {rows} has linear and angular rows, in different units"
    if n > m and (objection := _find_mixed_joints_objection(chain)):
        return objection
    if not chain.revolute_joints:
        return "its Jacobian is the same in every configuration"
    return _find_rank_objection(chain)


def _find_condition_number_objection(chain: Chain) -> str | None:
    if len(chain.task) == 1:
        return "its Jacobian has only one row, so only one singular value"
    return _find_mixed_joints_objection(chain) or _find_manipulability_objection(chain)


@dataclass(frozen=True, kw_only=True)
class GramDetails(VelocityDetails):
    """Details about J J^T at a configuration: its eigenvalues in descending order, and the power of m in w's unit.

    `power` is None for the condition number, which has no unit.
    """

    gram: sp.Matrix
    eigenvalues: tuple[sp.Float, ...]
    power: int | None = None


def _make_gram_details(
    chain: Chain, configuration: ConfigurationAndVelocity, singular_values: Vector, power: int | None = None
) -> GramDetails:
    squares = sorted((value**2 for value in singular_values), reverse=True)
    jacobian = inversion.evaluate_jacobian_precisely(chain, configuration)
    return GramDetails(
        configuration=configuration,
        gram=precise.round_matrix(precise.compute_gram_matrix(jacobian)),
        eigenvalues=tuple(map(precise.round_to_four_digits, squares)),
        power=power,
        pose=configuration.figure_values,
    )


def _compute_singular_values(chain: Chain, configuration: ConfigurationAndVelocity) -> Vector:
    """Return the singular values of the task Jacobian at a configuration, to 30 digits."""
    jacobian = PRECISE_CONTEXT.matrix(inversion.evaluate_jacobian_precisely(chain, configuration))
    return list(PRECISE_CONTEXT.svd_r(jacobian, compute_uv=False))


def _ask_manipulability(chain: Chain, rng: Stream) -> AnswerAndDetails:
    configuration = inversion.sample_configuration_and_velocity(chain, rng)
    gram = precise.compute_gram_matrix(inversion.evaluate_jacobian_precisely(chain, configuration))
    value = precise.round_to_ten_digits(PRECISE_CONTEXT.sqrt(precise.compute_determinant(gram)))
    power = len(chain.linear_axes) - len(chain.prismatic_joints)
    details = _make_gram_details(chain, configuration, _compute_singular_values(chain, configuration), power)
    return Number(sp.Matrix([value]), (write_power_of_metres(power),), THREE_DIGIT_TOLERANCE, floor=1e-9), details


def _ask_condition_number(chain: Chain, rng: Stream) -> AnswerAndDetails:
    configuration = inversion.sample_configuration_and_velocity(chain, rng)
    sigma = _compute_singular_values(chain, configuration)
    value = precise.round_to_ten_digits(max(sigma) / min(sigma))
    details = _make_gram_details(chain, configuration, sigma)
    return Number(sp.Matrix([value]), ("",), THREE_DIGIT_TOLERANCE, floor=1e-9), details


# --- self-motion ---


def _find_self_motion_objection(chain: Chain) -> str | None:
    if objection := _find_redundancy_objection(chain):
        return objection
    m, n = len(chain.task), chain.n
    if n != m + 1:
        return f"its self-motion for the task {', '.join(chain.task)} has {n - m} dimensions, not one"
    if n <= MAX_JOINTS and sum(not minor.is_zero for minor in derive(chain).symbolic_minors) < 2:
        return "one of its joints does not affect the task"
    return None


@dataclass(frozen=True, kw_only=True)
class SelfMotionFormulaDetails(Details):
    """Details of a question about a self-motion as formulas: the factors that all maximal minors share.

    The `configuration` is None, because only a self-motion in numbers has one.
    """

    configuration: None = field(metadata=recorded_as("situation"))
    shared_factors: sp.Expr = field(metadata=recorded_as("shared"))


def _ask_self_motion(chain: Chain, rng: Stream) -> AnswerAndDetails:
    """Ask for a self-motion: as formulas if they are short, else as numbers at a configuration."""
    quotients = _factor_minors_of(chain).quotients if chain.n <= MAX_JOINTS else ()
    if quotients and sum(map(_count_terms, quotients)) <= MAX_TERMS / 2:
        formula_details = SelfMotionFormulaDetails(configuration=None, shared_factors=_find_shared_factors(chain))
        return Direction(derive_self_motion(chain)), formula_details
    configuration = inversion.sample_configuration_and_velocity(chain, rng)
    jacobian = inversion.evaluate_jacobian_precisely(chain, configuration)
    numbers = sp.Matrix(list(map(precise.round_to_ten_digits, compute_null_vector(jacobian))))
    details = VelocityDetails(configuration=configuration, pose=configuration.figure_values)
    return Direction(numbers, THREE_DIGIT_TOLERANCE), details


def compute_null_vector(jacobian: list[Vector]) -> Vector:
    """Return the unit vector (up to its sign) in the null space of an m x (m + 1) matrix of full rank.

    The projection of a unit vector e_k on the null space is e_k - J^T (J J^T)^-1 J e_k.
    """
    n = len(jacobian[0])
    for k in range(n):
        weights = precise.solve_linear(precise.compute_gram_matrix(jacobian), [row[k] for row in jacobian])
        projection = [(i == k) - sum(row[i] * w for row, w in zip(jacobian, weights, strict=True)) for i in range(n)]
        if projection[k] > 1 / (2 * n):  # the square of entry k of the null vector; at least 1/n for some k
            norm = sum(value**2 for value in projection) ** 0.5
            return [value / norm for value in projection]
    raise ValueError("the matrix has more than one direction in its null space, or none")


def derive_self_motion(chain: Chain) -> sp.Matrix:
    """Return joint rates with zero task velocity, n x 1 for n = m + 1.

    Entry i is (-1)^i times the maximal minor without column i. Factors that all minors share are omitted, so that the
    vector is not zero at their zeros.
    """
    # The minors are in the order of the columns that they contain, so the first minor omits the last column.
    minors = [_substitute_numbers(chain, minor) for minor in reversed(_factor_minors_of(chain).quotients)]
    return sp.Matrix([(-1) ** i * minor for i, minor in enumerate(minors)])


QUESTIONS = (
    Question(
        "gram-determinant", "det(J Jᵀ) of a redundant arm", "6.8 for m < n", points=2.0, prerequisites=("jacobian",),
        formula="det(J*transpose(J))", answer_type=Expression, make_details=_make_minor_details,
        textbook_formulas={
            "gram determinant": lambda chain: _substitute_numbers(
                chain, _derive_gram_determinant(make_symbolic_arm(chain).chain)
            ),
        },
        name_entries=lambda chain, _: [r"\det(J J^T)"], find_arm_objection=_find_minimum_norm_objection,
        find_size_objection=_find_gram_size_objection, is_made_of_jacobian=True, is_made_of_minors=True,
    ),
    Question(
        "least-norm-rates", "Minimum-norm joint rates", "6.7 for m < n", prerequisites=("jacobian",),
        formula="least_norm(J, xd)", sample=_ask_minimum_norm_rates, list_labels=name_joint_rates,
        is_made_of_jacobian=True, find_arm_objection=_find_minimum_norm_objection,
    ),
    Question(
        "self-motion", "Self-motion of a redundant arm", "6.4 for m < n", prerequisites=("jacobian",),
        stage="self-motion", sample=_ask_self_motion, list_labels=name_joint_rates,
        find_arm_objection=_find_self_motion_objection, is_made_of_jacobian=True,
    ),
    Question(
        "manipulability", "Manipulability at a configuration", "below 6.8", prerequisites=("jacobian",),
        formula="sqrt(det(J*transpose(J)))", sample=_ask_manipulability, name_entries=lambda chain, _: ["w"],
        find_arm_objection=_find_manipulability_objection,
    ),
    Question(
        "condition-number", "Condition number at a configuration", "below 6.8", prerequisites=("jacobian",),
        stage="condition number", sample=_ask_condition_number, name_entries=lambda chain, _: [r"\kappa"],
        find_arm_objection=_find_condition_number_objection,
    ),
)  # fmt: skip
