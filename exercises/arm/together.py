"""Whether conditions on joints ever hold together, for lengths that nothing is special about.

Sines and cosines of joints become pairs of unknowns on a circle, and conditions polynomials in them. Over a large prime
field, with residues drawn for what is open (lengths, and constant angles as points of the circle), a Gröbner basis says
whether they have a common zero at all, complex ones included. That they have none then holds for all lengths but
special ones; it is wrong by chance only where a draw is special, or the prime divides a coefficient: one in millions.
"""

from collections.abc import Sequence

import sympy as sp

from exercises.stream import Stream

MOST_UNKNOWNS, MOST_TERMS = 7, 160
"""Unknowns, and terms of all polynomials, up to which a basis is worked out; it takes some milliseconds then."""
_LEAST = 10**9
_ROOTS_OF = (2, 3)


def _prime() -> int:
    """Return a prime in whose field 2 and 3 have square roots, as in cosines of multiples of pi/12."""
    has_roots = (p for p in range(_LEAST, 2 * _LEAST) if all(pow(n, (p - 1) // 2, p) == 1 for n in _ROOTS_OF))
    return next(p for p in has_roots if sp.isprime(p))


PRIME = _prime()
_ROOTS = {n: int(sp.sqrt_mod(n, PRIME)) for n in _ROOTS_OF}


class _Undecided(Exception):
    """Something that has no place in the field is in a condition."""


def may_hold_together(conditions: Sequence[sp.Expr], joints: Sequence[sp.Symbol]) -> bool:
    """Tell whether conditions have a common zero, for lengths that nothing is special about; True if undecided."""
    field = _Field(joints)
    try:
        polynomials = [field.polynomial(condition) for condition in conditions]
    except _Undecided:
        return True
    used = {symbol for polynomial in polynomials for symbol in polynomial.free_symbols}
    polynomials += [c**2 + s**2 - 1 for c, s in field.circles.values() if {c, s} & used]
    unknowns = sorted({symbol for polynomial in polynomials for symbol in polynomial.free_symbols}, key=str)
    terms = sum(len(sp.Add.make_args(polynomial)) for polynomial in polynomials)
    if not unknowns or len(unknowns) > MOST_UNKNOWNS or terms > MOST_TERMS:
        return True
    basis = sp.groebner(polynomials, *unknowns, modulus=PRIME, order="grevlex")
    return bool(basis.exprs != [1])


class _Field:
    """Residues for what stands in conditions, and unknowns for the joints."""

    def __init__(self, joints: Sequence[sp.Symbol]) -> None:
        self.circles = {q: sp.symbols(f"c_{q.name} s_{q.name}") for q in joints if q.name.startswith("theta")}
        slides = {q for q in joints if q not in self.circles}
        self.unknowns = slides.union(*self.circles.values())
        self.draws = Stream("together")
        self.drawn: dict[sp.Basic, int] = {}

    def polynomial(self, condition: sp.Expr) -> sp.Expr:
        """Return a condition as a polynomial in the unknowns with residues for coefficients. Raises _Undecided."""
        numerator, _ = sp.together(sp.expand(sp.expand_trig(condition))).as_numer_denom()
        plain = sp.expand(numerator)
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
        half = self._residue(sp.tan(angle / 2, evaluate=False))
        below = pow(1 + half**2, -1, PRIME)
        return sp.Integer((1 - half**2 if is_cosine else 2 * half) * below % PRIME)

    def _term(self, term: sp.Expr) -> sp.Expr:
        coefficient, moving = 1, sp.S.One
        for factor in sp.Mul.make_args(term):
            if factor.free_symbols & self.unknowns:
                moving *= factor
            else:
                coefficient = coefficient * self._constant(factor) % PRIME
        return coefficient * moving

    def _constant(self, factor: sp.Expr) -> int:
        base, exponent = factor.as_base_exp()
        if base.is_Integer and (2 * exponent).is_Integer:
            return pow(self._root(int(base)) if exponent.q == 2 else int(base), int(exponent.p), PRIME)
        if base.is_Rational and exponent == 1:
            return int(base.p) * pow(int(base.q), -1, PRIME) % PRIME
        if (base.is_Symbol or base == sp.pi) and exponent.is_Integer:
            return pow(self._residue(base), int(exponent), PRIME)
        raise _Undecided

    def _root(self, number: int) -> int:
        """Return a square root of a number made of 2 and 3."""
        root = 1
        for prime in _ROOTS_OF:
            while number % prime == 0:
                root, number = root * _ROOTS[prime] % PRIME, number // prime
        if number != 1:
            raise _Undecided
        return root

    def _residue(self, what: sp.Basic) -> int:
        if what not in self.drawn:
            self.drawn[what] = self.draws.integer(2, PRIME - 2)
        return self.drawn[what]
