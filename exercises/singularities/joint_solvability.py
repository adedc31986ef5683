"""Decide whether conditions on joint variables can hold simultaneously, for all lengths except special ones.

The cosine and the sine of each revolute joint become a pair of unknowns on a circle, and the conditions become
polynomials in the unknowns. Coefficients are residues modulo a large prime; symbolic lengths and constant angles become
random residues. A Gröbner basis decides whether the polynomials have a common zero, which may be complex. If they have
none, the conditions can't hold simultaneously except for special lengths. This conclusion is wrong if random
residues happen to satisfy a special relation or if the prime divides a coefficient: probability below about 1e-6.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import prod

import sympy as sp

from qdot.exercises.arm.chain import is_joint_angle
from qdot.exercises.arm.trigonometry import count_written_terms
from qdot.exercises.common.stream import Stream

MAX_UNKNOWNS, MAX_TERMS, MAX_ZEROS = 7, 160, 100
"""Limits for computing a Gröbner basis: the number of unknowns, the number of terms in all polynomials together, and
the product of the polynomials' degrees, which bounds the number of zeros."""
_SMALLEST_PRIME, _PRIME_SEARCH_LENGTH = 10**9, 20_000
"""The smallest number that is tried as the prime, and the number of successive numbers that are tried."""
_ANGLE_PARTS = 36 * 10**12
"""A constant angle is a rational multiple of a symbol or of 1 rad; the multiple times this number must be an integer.

The residues for the cosine and the sine of one part determine those of its multiples. The sine and the cosine of a
rational number of radians are transcendental, so random residues can represent them.
"""


Residues = dict[sp.Expr, int]
"""Maps unknowns, symbolic lengths, pi or square roots to residues."""


class _Undecided(Exception):
    """The error raised if a condition contains something that residues can't represent."""


def may_hold_simultaneously(
    conditions: Sequence[sp.Expr], joints: Sequence[sp.Symbol], max_zeros: int = MAX_ZEROS
) -> bool:
    """Return False if conditions provably have no common zero for general lengths, otherwise True.

    With a larger `max_zeros`, the maximum product of degrees, more is decided, but it takes longer.
    """
    numerators = [_expand_numerator(condition) for condition in conditions]
    try:
        converter = _Converter(joints, _find_prime(frozenset().union(*map(_find_primes_under_roots, numerators))))
        polynomials = [converter.convert(condition) for condition in numerators]
    except _Undecided:
        return True
    return _may_have_common_zero(polynomials, converter, max_zeros)


def is_implied(
    condition: sp.Expr, premises: Sequence[sp.Expr], joints: Sequence[sp.Symbol], max_zeros: int = MAX_ZEROS
) -> bool:
    """Return whether a condition provably follows from premises.

    The condition follows if the premises and 1 = y * condition, with a new unknown y, have no common zero.
    """
    y = sp.Symbol("d_y")  # not named theta..., so that it isn't treated as an angle
    return not may_hold_simultaneously([*premises, 1 - y * condition], (*joints, y), max_zeros)


def drop_implied(
    conditions: Sequence[sp.Expr], joints: Sequence[sp.Symbol], max_zeros: int = MAX_ZEROS
) -> tuple[sp.Expr, ...]:
    """Return conditions without those that provably follow from two or more others; long ones are dropped first."""
    return drop_redundant(
        conditions, lambda condition, others: len(others) > 1 and is_implied(condition, others, joints, max_zeros)
    )


def drop_redundant(
    conditions: Sequence[sp.Expr], follows: Callable[[sp.Expr, tuple[sp.Expr, ...]], bool]
) -> tuple[sp.Expr, ...]:
    """Return conditions without those for which `follows(condition, others)` is true; long ones are dropped first."""
    remaining_conditions = tuple(conditions)
    for condition in sorted(conditions, key=sp.count_ops, reverse=True):
        other_conditions = tuple(other for other in remaining_conditions if other != condition)
        if other_conditions and follows(condition, other_conditions):
            remaining_conditions = other_conditions
    return remaining_conditions


def _may_have_common_zero(polynomials: Sequence[sp.Expr], converter: "_Converter", max_zeros: int) -> bool:
    """Return whether polynomials may have a common zero, at which each pair of unknowns is on its circle.

    A polynomial that fixes a joint is solved first, and each solution is substituted into the other polynomials.
    """
    nonzero_polynomials = list(dict.fromkeys(polynomial for polynomial in polynomials if polynomial != 0))
    for k, polynomial in enumerate(nonzero_polynomials):
        points = _solve_for_joint(polynomial, converter)
        if points is not None:
            other_polynomials = nonzero_polynomials[:k] + nonzero_polynomials[k + 1 :]
            systems = ([_substitute_residues(point, p, converter.prime) for p in other_polynomials] for point in points)
            return any(_may_have_common_zero(system, converter, max_zeros) for system in systems)
    return _may_have_zero_by_groebner_basis(nonzero_polynomials, converter, max_zeros)


def _solve_for_joint(polynomial: sp.Expr, converter: "_Converter") -> list[Residues] | None:
    """Return the solutions of a polynomial in the unknowns of one joint.

    A prismatic joint has one solution; a revolute joint has the intersections of a line and the circle. An empty list
    (for a nonzero constant) means that there is provably no solution. None means that the polynomial can't be solved
    here: it has unknowns of several joints, isn't linear, or has no solution modulo the prime, although it may have one
    in an extension of the field.
    """
    unknowns, prime = polynomial.free_symbols, converter.prime
    if not unknowns:
        return []
    pair = next((pair for pair in converter.circles.values() if unknowns <= set(pair)), None)
    if pair is None and len(unknowns) > 1:
        return None
    linear_polynomial = sp.Poly(polynomial, *(pair or unknowns), modulus=prime)
    if linear_polynomial.total_degree() != 1:
        return None
    if pair is None:
        slope, constant = map(int, linear_polynomial.all_coeffs())
        return [{next(iter(unknowns)): -constant * pow(slope, -1, prime) % prime}]
    a, b, constant = (int(linear_polynomial.coeff_monomial(monomial)) for monomial in (*pair, 1))
    squared_amplitude = (a * a + b * b) % prime
    root = sp.sqrt_mod((squared_amplitude - constant * constant) % prime, prime) if squared_amplitude else None
    if root is None:
        return None
    cosine, sine = pair
    inverse, roots = pow(squared_amplitude, -1, prime), {int(root), -int(root) % prime}
    return [
        {cosine: (-a * constant + b * r) * inverse % prime, sine: (-b * constant - a * r) * inverse % prime}
        for r in roots
    ]


def _substitute_residues(residues: Residues, polynomial: sp.Expr, prime: int) -> sp.Expr:
    """Return a polynomial with residues as coefficients, after substituting residues for symbols or roots.

    Raises _Undecided if a coefficient is not an integer.
    """
    unknowns = sorted(polynomial.free_symbols - residues.keys(), key=str)
    new_polynomial = sp.expand(polynomial.xreplace({name: sp.Integer(value) for name, value in residues.items()}))
    try:
        return sp.Poly(new_polynomial, *(unknowns or [sp.Dummy()]), modulus=prime).as_expr()
    except sp.BasePolynomialError:
        raise _Undecided from None


def _may_have_zero_by_groebner_basis(polynomials: Sequence[sp.Expr], converter: "_Converter", max_zeros: int) -> bool:
    """Return whether polynomials may have a common zero, by a Gröbner basis.

    If that would take long, only the shortest polynomials are used: if these have no common zero, the whole system has
    none.
    """
    chosen_polynomials: list[sp.Expr] = []
    for polynomial in sorted(polynomials, key=lambda candidate: (len(sp.Add.make_args(candidate)), str(candidate))):
        system = converter.add_circles([*chosen_polynomials, polynomial])
        if _is_quick(system, max_zeros):
            chosen_polynomials.append(polynomial)
    system = converter.add_circles(chosen_polynomials)
    unknowns = _list_unknowns(system)
    if not unknowns:
        return not chosen_polynomials
    basis = sp.groebner(system, *unknowns, modulus=converter.prime, order="grevlex")
    return bool(basis.exprs != [1])


def _list_unknowns(polynomials: Sequence[sp.Expr]) -> list[sp.Symbol]:
    return sorted({symbol for polynomial in polynomials for symbol in polynomial.free_symbols}, key=str)


def _is_quick(system: Sequence[sp.Expr], max_zeros: int) -> bool:
    """Return whether a Gröbner basis of a system can be computed quickly."""
    unknowns = _list_unknowns(system)
    if len(unknowns) > MAX_UNKNOWNS or count_written_terms(system) > MAX_TERMS:
        return False
    return not unknowns or prod(sp.Poly(polynomial, *unknowns).total_degree() for polynomial in system) <= max_zeros


def _expand_numerator(condition: sp.Expr) -> sp.Expr:
    """Return the numerator of a condition, in sines and cosines of single angles."""
    numerator, _ = sp.together(sp.expand(sp.expand_trig(condition))).as_numer_denom()
    return sp.expand(numerator)


def _find_primes_under_roots(expression: sp.Expr) -> frozenset[int]:
    """Return the primes whose square roots occur in an expression."""
    bases = (power.base for power in expression.atoms(sp.Pow) if power.exp.is_Rational and power.exp.q == 2)
    numbers = (number for base in bases if base.is_Rational for number in (base.p, base.q))
    return frozenset(prime for number in numbers for prime in sp.factorint(abs(int(number))) if prime > 1)


@lru_cache(maxsize=256)
def _find_prime(primes_with_roots: frozenset[int]) -> int:
    """Return a prime modulo which certain primes have square roots. Raises _Undecided if none is found."""
    for p in range(_SMALLEST_PRIME, _SMALLEST_PRIME + _PRIME_SEARCH_LENGTH):
        if all(pow(n, (p - 1) // 2, p) == 1 for n in primes_with_roots) and sp.isprime(p):
            return p
    raise _Undecided


class _Converter:
    """The conversion of conditions to polynomials: residues modulo a prime for constants, and unknowns for joints."""

    def __init__(self, joints: Sequence[sp.Symbol], prime: int) -> None:
        self.prime = prime
        self.circles: dict[sp.Symbol, tuple[sp.Symbol, sp.Symbol]] = {  # the unknowns for the cosine and the sine
            q: sp.symbols(f"c_{q.name} s_{q.name}") for q in joints if is_joint_angle(q)
        }
        prismatic_variables = {q for q in joints if q not in self.circles}
        self.unknowns = prismatic_variables.union(*self.circles.values())
        self.rng = Stream("together")
        self.residues: dict[sp.Basic, int] = {}

    def add_circles(self, polynomials: Sequence[sp.Expr]) -> list[sp.Expr]:
        """Return polynomials, followed by c^2 + s^2 - 1 for each pair of unknowns that they contain."""
        unknowns = set(_list_unknowns(polynomials))
        return [*polynomials, *(c**2 + s**2 - 1 for c, s in self.circles.values() if {c, s} & unknowns)]

    def convert(self, condition: sp.Expr) -> sp.Expr:
        """Return a condition as a polynomial in the unknowns with residues as coefficients. Raises _Undecided."""
        polynomial = condition.xreplace({trig: self._convert_trig(trig) for trig in condition.atoms(sp.sin, sp.cos)})
        constants = sorted((polynomial.free_symbols - self.unknowns) | polynomial.atoms(sp.NumberSymbol), key=str)
        roots = [
            power for power in polynomial.atoms(sp.Pow) if power.base.is_Integer and power.exp == sp.Rational(1, 2)
        ]
        residues = {root: self._find_root_residue(int(root.base)) for root in roots}
        residues |= {constant: self._sample_residue(constant) for constant in constants}
        return _substitute_residues(residues, polynomial, self.prime)

    def _convert_trig(self, atom: sp.Expr) -> sp.Expr:
        """Return the unknown for the sine or cosine of a joint, or the residue for that of a constant angle."""
        (angle,) = atom.args
        is_cosine = isinstance(atom, sp.cos)
        if angle in self.circles:
            cosine, sine = self.circles[angle]
            return cosine if is_cosine else sine
        if angle.free_symbols & set(self.circles):
            raise _Undecided
        multiple, base = angle.as_coeff_Mul()
        part_count = multiple * _ANGLE_PARTS
        # The cosine of pi/7, for example, is an algebraic number, which no random residue represents.
        if not (base.is_Symbol or base == 1) or not part_count.is_Integer:
            raise _Undecided
        # t represents the tangent of half a part; any residue gives a cosine and a sine on the circle
        t, p = self._sample_residue(sp.tan(base, evaluate=False)), self.prime
        inverse = pow(1 + t**2, -1, p)
        c, s = self._multiply_angle((1 - t**2) * inverse % p, 2 * t * inverse % p, int(part_count))
        return sp.Integer(c if is_cosine else s)

    def _multiply_angle(self, c: int, s: int, factor: int) -> tuple[int, int]:
        """Return cosine and sine of `factor` times an angle with cosine c and sine s."""
        if factor < 0:
            return self._multiply_angle(c, -s % self.prime, -factor)
        cosine, sine = 1, 0
        while factor:  # c and s belong to an angle that is doubled for each binary digit of the factor
            if factor & 1:
                cosine, sine = (cosine * c - sine * s) % self.prime, (cosine * s + sine * c) % self.prime
            c, s, factor = (c * c - s * s) % self.prime, 2 * c * s % self.prime, factor >> 1
        return cosine, sine

    def _find_root_residue(self, number: int) -> int:
        """Return the residue of a square root, as the product of the roots of the prime factors."""
        root = 1
        for prime_factor, power in sp.factorint(number).items():
            factor_root = sp.sqrt_mod(prime_factor, self.prime)
            if not factor_root:
                raise _Undecided
            root = root * pow(int(factor_root), power, self.prime) % self.prime
        return root

    def _sample_residue(self, constant: sp.Basic) -> int:
        """Return the random residue that represents a constant, always the same for the same constant."""
        if constant not in self.residues:
            self.residues[constant] = self.rng.integer(2, self.prime - 2)
        return self.residues[constant]
