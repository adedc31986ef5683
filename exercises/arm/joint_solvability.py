"""Whether conditions on joints ever hold together, for lengths that nothing is special about.

Sines and cosines of joints become pairs of unknowns on a circle, and conditions polynomials in them. Over a large prime
field, with residues drawn for what is open (lengths, and constant angles as points of the circle), a Gröbner basis says
whether they have a common zero at all, complex ones included. That they have none then holds for all lengths but
special ones; it is wrong by chance only where a draw is special, or the prime divides a coefficient: one in millions.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import prod

import sympy as sp

from qdot.exercises.common.stream import Stream

MOST_UNKNOWNS, MOST_TERMS, MOST_ZEROS = 7, 160, 100
"""Unknowns, terms of all polynomials, and the product of their degrees, up to which a basis is worked out."""
_LEAST, _TRIED = 10**9, 20_000
_PARTS = 36 * 10**12
"""Into how many parts an open angle is divided, and a radian: what its half and its third are follows from one draw.

The sine and cosine of a number of radians are no roots of any polynomial, so that one drawn stands for all.
"""


Pair = tuple[sp.Symbol, sp.Symbol]
"""The unknowns for cosine and sine of a joint."""
Point = dict[sp.Symbol, int]
"""Residues for the unknowns of a joint."""


class _Undecided(Exception):
    """Something that has no place in the field is in a condition."""


def may_hold_together(conditions: Sequence[sp.Expr], joints: Sequence[sp.Symbol], most_zeros: int = MOST_ZEROS) -> bool:
    """Tell whether conditions have a common zero, for lengths that nothing is special about; True if undecided.

    With more `most_zeros`, it may take longer, and decides more.
    """
    plain = [_expanded(condition) for condition in conditions]
    try:
        field = _Field(joints, _prime(frozenset().union(*map(_roots_in, plain))))
        polynomials = [_put({}, field.polynomial(condition), field.prime) for condition in plain]
    except _Undecided:
        return True
    return _may_vanish(polynomials, tuple(field.circles.values()), field.prime, most_zeros)


def follows(
    condition: sp.Expr, given: Sequence[sp.Expr], joints: Sequence[sp.Symbol], most_zeros: int = MOST_ZEROS
) -> bool:
    """Tell whether a condition was seen to hold wherever others do: these and 1 = y times it have no common zero."""
    y = sp.Symbol("d_y")
    return not may_hold_together([*given, 1 - y * condition], (*joints, y), most_zeros)


def without_needless(
    conditions: Sequence[sp.Expr], joints: Sequence[sp.Symbol], most_zeros: int = MOST_ZEROS
) -> tuple[sp.Expr, ...]:
    """Return conditions without those that follow from the others, the longest of which are left out first."""
    kept = list(conditions)
    for condition in sorted(conditions, key=sp.count_ops, reverse=True):
        rest = [other for other in kept if other != condition]
        if len(rest) > 1 and follows(condition, rest, joints, most_zeros):
            kept = rest
    return tuple(kept)


def _may_vanish(polynomials: Sequence[sp.Expr], circles: Sequence[Pair], prime: int, most_zeros: int) -> bool:
    """Tell whether polynomials may have a common zero, with each pair of unknowns on its circle.

    What fixes a joint by itself is put into the others first, which are few and short then, one point after the other.
    """
    polynomials = list(dict.fromkeys(polynomial for polynomial in polynomials if polynomial != 0))
    for polynomial in polynomials:
        points = _points(polynomial, circles, prime)
        if points is not None:
            rest = [other for other in polynomials if other is not polynomial]
            there = ([_put(at, other, prime) for other in rest] for at in points)
            return any(_may_vanish(others, circles, prime, most_zeros) for others in there)
    return _has_zero(polynomials, circles, prime, most_zeros)


def _points(polynomial: sp.Expr, circles: Sequence[Pair], prime: int) -> list[Point] | None:
    """Return where a condition on one joint holds; None if it is on several, no line, or holds outside of the field.

    That is a number for a slide, and for an angle where a line and the circle meet.
    """
    unknowns = polynomial.free_symbols
    if not unknowns:
        return []
    pair = next((pair for pair in circles if unknowns <= set(pair)), None)
    if pair is None and len(unknowns) > 1:
        return None
    line = sp.Poly(polynomial, *(pair or unknowns), modulus=prime)
    if line.total_degree() != 1:
        return None
    if pair is None:
        slope, constant = map(int, line.all_coeffs())
        return [{next(iter(unknowns)): -constant * pow(slope, -1, prime) % prime}]
    a, b, constant = (int(line.coeff_monomial(monomial)) for monomial in (*pair, 1))
    size = (a * a + b * b) % prime
    root = sp.sqrt_mod((size - constant * constant) % prime, prime) if size else None
    if root is None:
        return None
    below = pow(size, -1, prime)
    ends = ((-a * constant + b * r) * below % prime for r in {int(root), -int(root) % prime})
    others = ((-b * constant - a * r) * below % prime for r in {int(root), -int(root) % prime})
    return [dict(zip(pair, point, strict=True)) for point in zip(ends, others, strict=True)]


def _put(point: Point, polynomial: sp.Expr, prime: int) -> sp.Expr:
    """Return a polynomial with the unknowns of a joint put in, its coefficients as residues."""
    unknowns = sorted(polynomial.free_symbols - point.keys(), key=str)
    plain = sp.expand(polynomial.xreplace({unknown: sp.Integer(value) for unknown, value in point.items()}))
    return sp.Poly(plain, *unknowns, modulus=prime).as_expr() if unknowns else sp.Integer(int(plain) % prime)


def _has_zero(polynomials: Sequence[sp.Expr], circles: Sequence[Pair], prime: int, most_zeros: int) -> bool:
    """Tell the same by a basis. Where that would take long, some of them, the shortest, may show that there is none."""
    chosen: list[sp.Expr] = []
    for polynomial in sorted(polynomials, key=lambda one: (len(sp.Add.make_args(one)), str(one))):
        system = _with_circles([*chosen, polynomial], circles)
        if _is_short(system, most_zeros):
            chosen.append(polynomial)
    system = _with_circles(chosen, circles)
    unknowns = _unknowns(system)
    if not unknowns:
        return not chosen
    basis = sp.groebner(system, *unknowns, modulus=prime, order="grevlex")
    return bool(basis.exprs != [1])


def _with_circles(polynomials: Sequence[sp.Expr], circles: Sequence[Pair]) -> list[sp.Expr]:
    used = set(_unknowns(polynomials))
    return [*polynomials, *(c**2 + s**2 - 1 for c, s in circles if {c, s} & used)]


def _unknowns(polynomials: Sequence[sp.Expr]) -> list[sp.Symbol]:
    return sorted({symbol for polynomial in polynomials for symbol in polynomial.free_symbols}, key=str)


def _is_short(system: Sequence[sp.Expr], most_zeros: int) -> bool:
    """Tell whether a basis is worked out in no time."""
    unknowns = _unknowns(system)
    terms = sum(len(sp.Add.make_args(polynomial)) for polynomial in system)
    if len(unknowns) > MOST_UNKNOWNS or terms > MOST_TERMS:
        return False
    return not unknowns or prod(sp.Poly(polynomial, *unknowns).total_degree() for polynomial in system) <= most_zeros


def _expanded(condition: sp.Expr) -> sp.Expr:
    """Return what stands above the fraction bar of a condition, in sines and cosines of single angles."""
    numerator, _ = sp.together(sp.expand(sp.expand_trig(condition))).as_numer_denom()
    return sp.expand(numerator)


def _roots_in(plain: sp.Expr) -> frozenset[int]:
    """Return the numbers whose square roots stand in an expression."""
    bases = (power.base for power in plain.atoms(sp.Pow) if power.exp.is_Rational and power.exp.q == 2)
    numbers = (number for base in bases if base.is_Rational for number in (base.p, base.q))
    return frozenset(prime for number in numbers for prime in sp.factorint(abs(int(number))) if prime > 1)


@lru_cache(maxsize=256)
def _prime(roots: frozenset[int]) -> int:
    """Return a prime in whose field some numbers have square roots. Raises _Undecided where none is near."""
    for p in range(_LEAST, _LEAST + _TRIED):
        if all(pow(n, (p - 1) // 2, p) == 1 for n in roots) and sp.isprime(p):
            return p
    raise _Undecided


class _Field:
    """Residues by a prime for what stands in conditions, and unknowns for the joints."""

    def __init__(self, joints: Sequence[sp.Symbol], prime: int) -> None:
        self.prime = prime
        self.circles = {q: sp.symbols(f"c_{q.name} s_{q.name}") for q in joints if q.name.startswith("theta")}
        slides = {q for q in joints if q not in self.circles}
        self.unknowns = slides.union(*self.circles.values())
        self.draws = Stream("together")
        self.drawn: dict[sp.Basic, int] = {}

    def polynomial(self, plain: sp.Expr) -> sp.Expr:
        """Return a condition as a polynomial in the unknowns with residues for coefficients. Raises _Undecided."""
        plain = sp.expand(plain.xreplace({atom: self._of_angle(atom) for atom in plain.atoms(sp.sin, sp.cos)}))
        return sum((self._term(term) for term in sp.Add.make_args(plain)), sp.S.Zero)

    def _of_angle(self, atom: sp.Expr) -> sp.Expr:
        """Return the sine or cosine of a joint as its unknown, that of a constant angle as a residue."""
        (angle,) = atom.args
        is_cosine = isinstance(atom, sp.cos)
        if angle in self.circles:
            return self.circles[angle][0 if is_cosine else 1]
        if angle.free_symbols & set(self.circles):
            raise _Undecided
        times, base = angle.as_coeff_Mul()
        parts = times * _PARTS
        if not (base.is_Symbol or base == 1) or not parts.is_Integer:  # pi/7 is related to others in a way of its own
            raise _Undecided
        half, p = self._residue(sp.tan(base, evaluate=False)), self.prime
        below = pow(1 + half**2, -1, p)
        c, s = self._turned((1 - half**2) * below % p, 2 * half * below % p, int(parts))
        return sp.Integer(c if is_cosine else s)

    def _turned(self, c: int, s: int, times: int) -> tuple[int, int]:
        """Return cosine and sine of a multiple of an angle, by theirs."""
        if times < 0:
            return self._turned(c, -s % self.prime, -times)
        found = (1, 0)
        while times:
            if times & 1:
                found = (found[0] * c - found[1] * s) % self.prime, (found[0] * s + found[1] * c) % self.prime
            c, s, times = (c * c - s * s) % self.prime, 2 * c * s % self.prime, times >> 1
        return found

    def _term(self, term: sp.Expr) -> sp.Expr:
        coefficient, moving = 1, sp.S.One
        for factor in sp.Mul.make_args(term):
            if factor.free_symbols & self.unknowns:
                moving *= factor
            else:
                coefficient = coefficient * self._constant(factor) % self.prime
        return coefficient * moving

    def _constant(self, factor: sp.Expr) -> int:
        base, exponent = factor.as_base_exp()
        if base.is_Integer and (2 * exponent).is_Integer:
            return pow(self._root(int(base)) if exponent.q == 2 else int(base), int(exponent.p), self.prime)
        if base.is_Rational and exponent == 1:
            return int(base.p) * pow(int(base.q), -1, self.prime) % self.prime
        if (base.is_Symbol or base == sp.pi) and exponent.is_Integer:
            return pow(self._residue(base), int(exponent), self.prime)
        raise _Undecided

    def _root(self, number: int) -> int:
        """Return a square root, made of those of its prime factors, so that roots multiply as they should."""
        root = 1
        for prime, times in sp.factorint(number).items():
            own = self.drawn.setdefault(sp.sqrt(prime, evaluate=False), int(sp.sqrt_mod(prime, self.prime) or 0))
            if not own:
                raise _Undecided
            root = root * pow(own, times, self.prime) % self.prime
        return root

    def _residue(self, what: sp.Basic) -> int:
        if what not in self.drawn:
            self.drawn[what] = self.draws.integer(2, self.prime - 2)
        return self.drawn[what]
