"""Solve one condition for a joint and substitute it into others that hold with it, as a person would.

Conditions are polynomials in lengths, slides, and sines and cosines of angles. A + B d = 0 gives a slide if A or B is a
nonzero constant, and B cos q + C sin q = 0 the sine in terms of the cosine. A condition on one angle alone is a
polynomial in the tangent of half the angle, which shows factors that cos^2 + sin^2 = 1 hides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

from qdot.exercises.arm.trigonometry import factor_trig


@dataclass(frozen=True)
class Relation:
    """A value for a slide or a sine, and factors that are not zero there, `beside`."""

    atom: sp.Expr
    value: sp.Expr
    beside: tuple[sp.Expr, ...] = ()

    def occurs_in(self, condition: sp.Expr) -> bool:
        """Tell whether a condition contains the atom, also inside an angle sum or a multiple."""
        return bool(_expand_angles(condition).has(self.atom))

    def substitute_into(self, condition: sp.Expr) -> sp.Expr:
        """Return the numerator of a condition after the substitution."""
        above, _ = sp.fraction(sp.together(_expand_angles(condition).xreplace({self.atom: self.value})))
        return sp.expand(above)


def relation_of(
    condition: sp.Expr, joints: Sequence[sp.Symbol], is_nonzero: Callable[[sp.Expr], bool]
) -> Relation | None:
    """Solve a condition for a slide or for the sine of an angle; return None if that is not certain to work.

    `is_nonzero` tells whether an expression without joint variables is nonzero.
    """
    plain = _expand_angles(condition)
    used = [q for q in joints if plain.has(q)]
    slides = [q for q in used if not any(trig.has(q) for trig in plain.atoms(sp.sin, sp.cos))]
    for slide in slides:
        line = sp.Poly(plain, slide)
        if line.degree() != 1:
            continue
        slope, rest = line.all_coeffs()
        moving = [f for f, _ in factor_trig(slope).factors if f.free_symbols & set(joints)]
        fixed = rest if moving else slope  # if B has joints in it, a nonzero constant A keeps it from vanishing
        if not fixed.free_symbols & set(joints) and is_nonzero(fixed):
            return Relation(slide, -rest / slope, tuple(moving))
    if len(used) == 1 and not slides:
        cosine, sine = sp.cos(used[0]), sp.sin(used[0])
        c, s = sp.Dummy("c"), sp.Dummy("s")
        line = sp.Poly(plain.xreplace({cosine: c, sine: s}), c, s)
        b, a = line.coeff_monomial(c), line.coeff_monomial(s)
        if line.total_degree() == 1 and line.coeff_monomial(1) == 0 and is_nonzero(a) and is_nonzero(b):
            return Relation(sine, -b / a * cosine)
    return None


def factor_by_half_angle(factor: sp.Expr, joints: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """Return factors of a condition on one angle, each linear in its cosine and sine; itself if there are none.

    >>> q = sp.Symbol("theta3")
    >>> factor_by_half_angle(2 * sp.cos(q) ** 2 + 3 * sp.cos(q) - 3 * sp.sin(q) - 1, [q])
    [sin(theta3) - cos(theta3), sin(theta3) + cos(theta3) + 3]
    """
    plain = _expand_angles(factor)
    used = [q for q in joints if plain.has(q)]
    if len(used) != 1 or not plain.has(sp.sin, sp.cos):
        return [factor]
    (q,) = used
    c, s, t = sp.Dummy("c"), sp.Dummy("s"), sp.Dummy("t")
    circle = sp.Poly(plain.xreplace({sp.cos(q): c, sp.sin(q): s}), c, s)
    degree = circle.total_degree()
    if degree < 2 or any(q in coefficient.free_symbols for coefficient in circle.coeffs()):
        return [factor]
    around = 1 + t**2
    above = sum(
        coefficient * (1 - t**2) ** i * (2 * t) ** j * around ** (degree - i - j)
        for (i, j), coefficient in circle.terms()
    )
    factors, left = [], 2 * degree
    for piece, power in sp.factor_list(sp.expand(above))[1]:
        powers = sp.Poly(piece, t)
        if powers.degree() == 0:
            continue
        left -= power * powers.degree()
        high, middle, low = powers.all_coeffs() if powers.degree() == 2 else (0, 0, 0)
        if powers.degree() != 2:
            return [factor]
        if (high, middle) != (low, 0):  # 1 + t^2 is never zero
            factors.append(sp.expand((low + high) + (low - high) * sp.cos(q) + middle * sp.sin(q)))
    factors = [
        next((f for f, _ in factor_trig(found_factor).factors if f.has(q)), found_factor) for found_factor in factors
    ]
    in_order = sorted(factors, key=lambda found_factor: (sp.count_ops(found_factor), sp.default_sort_key(found_factor)))
    return in_order if left == 0 and factors else [factor]


def _expand_angles(condition: sp.Expr) -> sp.Expr:
    """Return a condition in sines and cosines of single angles."""
    return sp.expand(sp.expand_trig(condition))
