"""Find the direction of motion lost at a singular configuration.

If J (m x n, m <= n) has rank m - 1, one direction u of the task is lost: every velocity that the joints can produce is
perpendicular to u, so that u J = 0. The cofactors of m - 1 independent columns of J form such a vector u, because a
determinant with two equal columns is zero. For m = 3, u is the cross product of the two columns. Vectors are in the
world frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, is_joint_angle
from qdot.exercises.arm.trigonometry import Factored, count_terms, factor_trig, to_textbook_form
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.singularities.singular_set import Component

ZERO_THRESHOLD, NONZERO_THRESHOLD = 1e-9, 0.05
"""Limits of a singular value of J, relative to the largest: below the first it counts as zero, and above the second as
nonzero."""

MAX_TERMS, MAX_ROWS = 8, 4
"""Maximum number of terms of a formula for a lost direction, and maximum number of rows of J for such a formula."""


def find_clear_rank(jacobian: np.ndarray, nonzero_threshold: float = NONZERO_THRESHOLD) -> int | None:
    """Return the rank of a matrix; None if a singular value is neither clearly zero nor clearly nonzero."""
    sigma = np.linalg.svd(jacobian, compute_uv=False)
    relative_values = sigma / max(float(sigma[0]), 1e-12)
    if np.any((relative_values > ZERO_THRESHOLD) & (relative_values < nonzero_threshold)):
        return None
    return int(np.sum(relative_values >= nonzero_threshold))


# --- as a formula ---


@dataclass(frozen=True)
class LostDirectionFormula:
    """A formula for the lost direction u (m x 1).

    - `direction`: the entries of u, formulas in the joint variables that the singular condition does not fix.
    - `columns`: the columns of J (counted from 1) whose cofactors are the entries of u.
    - `jacobian`: J at the singular configurations (m x n); None if its entries are not short.
    """

    direction: sp.Matrix
    columns: tuple[int, ...]
    jacobian: sp.Matrix | None


@lru_cache(maxsize=1024)
def find_shortest_lost_direction(symbolic_arm: Chain, component: Component) -> LostDirectionFormula | None:
    """Return the shortest formula for the direction that a symbolic arm loses at a component; None if none is short.

    The component belongs to the singular set of this arm and has one combination of joint values.
    """
    jacobian = derive(symbolic_arm).jacobian
    if jacobian.rows > min(jacobian.cols, MAX_ROWS) or component.solutions is None:
        return None
    scale = sp.Dummy("t")
    for condition, (joint, (value, *_)) in zip(component.conditions, component.solutions, strict=True):
        substituted_jacobian = _substitute_joint_value(jacobian, condition, joint, value, scale)
        if substituted_jacobian is None:
            return None
        jacobian = substituted_jacobian
    shown_jacobian = None if any(entry.has(scale) for entry in jacobian) else jacobian.applyfunc(to_textbook_form)
    formulas = [
        LostDirectionFormula(direction, tuple(j + 1 for j in columns), shown_jacobian)
        for columns in combinations(range(jacobian.cols), jacobian.rows - 1)
        if (direction := _compute_cofactors(jacobian[:, list(columns)])) is not None and not direction.has(scale)
    ]
    short_formulas = [formula for formula in formulas if count_terms(formula.direction, ignored_values=()) <= MAX_TERMS]
    return min(
        short_formulas,
        key=lambda formula: (count_terms(formula.direction, ignored_values=()), sp.count_ops(formula.direction)),
        default=None,
    )


def _substitute_joint_value(
    jacobian: sp.Matrix, condition: sp.Expr, joint: sp.Symbol, value: sp.Expr, scale: sp.Symbol
) -> sp.Matrix | None:
    """Return J at a joint value; None if the angle of the joint can't be eliminated from J.

    If the value is not a multiple of a right angle, it comes from a condition A cos q + B sin q = 0. Then cos q = B t
    and sin q = -A t are substituted, with the unknown t = `scale`. This is possible if A and B do not contain angles
    that occur in J.
    """
    if not is_joint_angle(joint) or (2 * value / sp.pi).is_Integer:
        return jacobian.applyfunc(lambda entry: sp.expand(entry.xreplace({joint: value})))
    cosine, sine = sp.Dummy("c"), sp.Dummy("s")
    linear_form = sp.expand(_split_off_angle(condition, joint, cosine, sine))
    a, b = linear_form.coeff(cosine), linear_form.coeff(sine)
    has_other_terms = sp.expand(linear_form - a * cosine - b * sine) != 0
    if has_other_terms or (a.free_symbols | b.free_symbols) & set(_list_angles(jacobian)):
        return None
    return jacobian.applyfunc(lambda entry: sp.expand(_split_off_angle(entry, joint, b * scale, -a * scale)))


def _list_angles(matrix: sp.Matrix) -> list[sp.Symbol]:
    """Return the symbols in the arguments of a matrix's sines and cosines."""
    trigs = (trig for entry in matrix for trig in entry.atoms(sp.sin, sp.cos))
    return [symbol for trig in trigs for symbol in trig.free_symbols]


def _split_off_angle(expression: sp.Expr, joint: sp.Symbol, cosine: sp.Expr, sine: sp.Expr) -> sp.Expr:
    """Expand sines and cosines of sums with a joint's angle, and replace the cosine and the sine of this angle."""
    replacements = {}
    for trig in expression.atoms(sp.sin, sp.cos):
        factor = sp.diff(trig.args[0], joint)
        if factor != 0:
            other_angles = trig.args[0] - factor * joint
            derivative = sp.cos(other_angles) if isinstance(trig, sp.sin) else -sp.sin(other_angles)
            replacements[trig] = trig.func(other_angles) * cosine + derivative * factor * sine
    return expression.xreplace(replacements)


def _compute_cofactors(columns: sp.Matrix) -> sp.Matrix | None:
    """Return the m cofactors of m - 1 columns (m x 1) without their common factors; None if all cofactors are zero."""
    m = columns.rows
    entries = []
    for i in range(m):
        minor = columns.extract([k for k in range(m) if k != i], list(range(m - 1)))
        determinant = minor.det(method="berkowitz") if m > 1 else sp.S.One
        entries.append(factor_trig(sp.expand((-1) ** i * determinant)))
    if all(entry.is_zero for entry in entries):
        return None
    return sp.Matrix([entry.to_expression() for entry in _cancel_common_factors(entries)])


def _cancel_common_factors(entries: Sequence[Factored]) -> list[Factored]:
    """Return entries divided by their common factors; all signs are changed if most entries are negative."""
    factor_powers = [dict(entry.factors) for entry in entries if not entry.is_zero]
    common_powers = {f: min(powers.get(f, 0) for powers in factor_powers) for f in factor_powers[0]}
    coefficients = [entry.coefficient for entry in entries if not entry.is_zero]
    common_coefficient = sp.Rational(sp.igcd(0, *(c.p for c in coefficients)), sp.ilcm(1, *(c.q for c in coefficients)))
    sign = -1 if sum(map(sp.sign, coefficients)) < 0 else 1
    common_factors = tuple((factor, power) for factor, power in common_powers.items() if power)
    common_product = Factored(sign * common_coefficient, common_factors)
    return [entry if entry.is_zero else entry.divide_by(common_product) for entry in entries]
