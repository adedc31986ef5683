"""Rewrite constants with roots as the sine or cosine of an angle: cos(75°) instead of (√6 - √2)/4.

SymPy evaluates both sin(15°) and cos(75°) to (√6 - √2)/4. If the arm's table has one of these angles, this angle is
used; otherwise, the angle is 15°.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.writing.shortening import split_constant

_FIFTEEN_DEGREES = sp.pi / 12


@dataclass(frozen=True)
class _SumOfRoots:
    """A constant with two terms (number, root or 1), and the sine or cosine that equals the constant."""

    terms: tuple[tuple[sp.Expr, sp.Expr], ...]
    trig: sp.Expr


@lru_cache(maxsize=256)
def list_constant_angles(chain: Chain) -> tuple[sp.Expr, ...]:
    """Return the constant angles of an arm's table and base, in order, each reduced to at most 90 degrees."""
    rows = convention_of(chain).rows
    table_constants = (angle for row in rows for angle in (row.alpha, split_constant(row.theta).constant))
    constants = [*table_constants, chain.base.yaw, chain.base.tilt]
    rational_angles = (angle for angle in constants if (angle / sp.pi).is_Rational)
    reduced_angles = (abs(sp.Mod(angle + sp.pi / 2, sp.pi) - sp.pi / 2) for angle in rational_angles)
    return tuple(dict.fromkeys(angle for angle in reduced_angles if angle != 0))


def use_constant_angles(expression: sp.Expr, angles: Sequence[sp.Expr] = ()) -> sp.Expr:
    """Return an expression in which sums of roots and nested roots become sines and cosines of constant angles.

    >>> cos_75, sin_75 = sp.cos(5 * sp.pi / 12), sp.sin(5 * sp.pi / 12)
    >>> use_constant_angles(cos_75 * sp.Symbol("a1")), use_constant_angles(sin_75, (5 * sp.pi / 12,))
    (a1*sin(pi/12), sin(5*pi/12))
    """
    if not any(power.exp == sp.Rational(1, 2) for power in expression.atoms(sp.Pow)):
        return expression
    roots, sums = _find_trigs_by_value(tuple(angles))
    without_nested_roots = expression.xreplace(roots)
    return without_nested_roots.replace(lambda part: part.is_Add, lambda total: _join_roots(total, sums))


@lru_cache(maxsize=256)
def _find_trigs_by_value(angles: tuple[sp.Expr, ...]) -> tuple[dict[sp.Expr, sp.Expr], tuple[_SumOfRoots, ...]]:
    """Return the constants to rewrite, each with the equal sine or cosine (or its square): nested roots, and sums."""
    roots: dict[sp.Expr, sp.Expr] = {}
    sums: dict[sp.Expr, sp.Expr] = {}
    for angle, function in product((*angles, _FIFTEEN_DEGREES), (sp.cos, sp.sin)):
        value, trig = sp.expand(function(angle)), function(angle, evaluate=False)
        if value.is_Add:
            sums.setdefault(value, trig)
        if value.is_Pow and value.base.is_Add:
            roots |= {value: roots.get(value, trig), 1 / value: roots.get(1 / value, 1 / trig)}
        if angle in angles:
            sums.setdefault(sp.expand(value**2), trig**2)
    pairs = ((value, trig) for value, trig in sums.items() if value.is_Add and len(value.args) == 2)
    return roots, tuple(_SumOfRoots(tuple(term.as_coeff_Mul() for term in value.args), trig) for value, trig in pairs)


def _join_roots(total: sp.Expr, known_sums: Sequence[_SumOfRoots]) -> sp.Expr:
    """Return a sum in which two terms that differ only in their roots are combined by one of the `known_sums`."""
    for sum_of_roots in known_sums:
        (number_1, root_1), (number_2, root_2) = sum_of_roots.terms
        numbers: dict[sp.Expr, dict[sp.Expr, sp.Expr]] = {}
        terms = []
        for term in sp.Add.make_args(total):
            number, other_factors = term.as_coeff_Mul()
            factors = sp.Mul.make_args(other_factors)
            root_in_term = next((r for r in (root_1, root_2) if r != 1 and r in factors), sp.S.One)
            if root_in_term in (root_1, root_2):
                numbers.setdefault(other_factors / root_in_term, {})[root_in_term] = number
            else:
                terms.append(term)
        for other_factors, number_by_root in numbers.items():
            if len(number_by_root) == 2 and number_by_root[root_1] / number_1 == number_by_root[root_2] / number_2:
                terms.append(number_by_root[root_1] / number_1 * sum_of_roots.trig * other_factors)
            else:
                terms += [number * root_in_term * other_factors for root_in_term, number in number_by_root.items()]
        total = sp.Add(*terms)
    return total
