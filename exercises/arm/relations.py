"""What one condition says of a joint, put into others that hold with it: a person would do so before reading them.

Conditions are polynomials in lengths, slides, and sines and cosines of angles. A + B d = 0 gives a slide where A or B
is a constant other than zero, and B cos q + C sin q = 0 the sine by the cosine. A condition on one angle alone is a
polynomial in the tangent of its half, which shows factors that cos^2 + sin^2 = 1 hides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import sympy as sp

from qdot.exercises.arm.trigonometry import factored


@dataclass(frozen=True)
class Relation:
    """What takes the place of a slide or a sine, and factors that are not zero there, `beside`."""

    atom: sp.Expr
    value: sp.Expr
    beside: tuple[sp.Expr, ...] = ()

    def is_in(self, condition: sp.Expr) -> bool:
        """Tell whether a condition has what is replaced, in an angle sum or a multiple, too."""
        return bool(_apart(condition).has(self.atom))

    def put_into(self, condition: sp.Expr) -> sp.Expr:
        """Return what stands above the fraction bar of a condition then."""
        above, _ = sp.fraction(sp.together(_apart(condition).xreplace({self.atom: self.value})))
        return sp.expand(above)


def relation_of(
    condition: sp.Expr, joints: Sequence[sp.Symbol], is_nonzero: Callable[[sp.Expr], bool]
) -> Relation | None:
    """Return what a condition says of a slide or of the sine of an angle; None where that is nothing for sure.

    `is_nonzero` tells of what no joint changes whether it is another number than zero.
    """
    plain = _apart(condition)
    used = [q for q in joints if plain.has(q)]
    slides = [q for q in used if not any(trig.has(q) for trig in plain.atoms(sp.sin, sp.cos))]
    for slide in slides:
        line = sp.Poly(plain, slide)
        if line.degree() != 1:
            continue
        slope, rest = line.all_coeffs()
        moving = [f for f, _ in factored(slope).factors if f.free_symbols & set(joints)]
        fixed = rest if moving else slope  # where B moves, a constant A other than zero keeps it from vanishing
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


def by_half_angle(factor: sp.Expr, joints: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """Return factors of a condition on one angle, each linear in its cosine and sine; itself where there are none.

    >>> q = sp.Symbol("theta3")
    >>> by_half_angle(2 * sp.cos(q) ** 2 + 3 * sp.cos(q) - 3 * sp.sin(q) - 1, [q])
    [sin(theta3) - cos(theta3), sin(theta3) + cos(theta3) + 3]
    """
    plain = _apart(factor)
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
    found, left = [], 2 * degree
    for piece, power in sp.factor_list(sp.expand(above))[1]:
        powers = sp.Poly(piece, t)
        if powers.degree() == 0:
            continue
        left -= power * powers.degree()
        high, middle, low = powers.all_coeffs() if powers.degree() == 2 else (0, 0, 0)
        if powers.degree() != 2:
            return [factor]
        if (high, middle) != (low, 0):  # 1 + t^2 is never zero
            found.append(sp.expand((low + high) + (low - high) * sp.cos(q) + middle * sp.sin(q)))
    found = [next((f for f, _ in factored(one).factors if f.has(q)), one) for one in found]
    in_order = sorted(found, key=lambda one: (sp.count_ops(one), sp.default_sort_key(one)))
    return in_order if left == 0 and found else [factor]


def _apart(condition: sp.Expr) -> sp.Expr:
    """Return a condition in sines and cosines of single angles."""
    return sp.expand(sp.expand_trig(condition))
