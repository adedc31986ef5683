"""Write trigonometric polynomials in textbook form, and test exactly whether two of them are equal.

A trigonometric polynomial is a polynomial in lengths and in sines and cosines of sums of angles, such as an entry of a
Jacobian. An angle may occur several times in a sum, as in 2 theta1 - theta2. In names, `trig` stands for a sine or
cosine. Three forms are used here:

- The Fourier form is a sum of coefficient * cos(sum) and coefficient * sin(sum). This form is often the shortest.
- The polynomial in the sine s and the cosine c of each single angle, with s^2 + c^2 = 1, is unique up to that relation.
  This form proves equality.
- In the factored form, c^2 + s^2 is replaced by 1 only after factoring, because an earlier replacement hides factors.
"""

import operator
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp


@dataclass(frozen=True)
class FourierForm:
    """A sum of terms A cos(phi) + B sin(phi), in which each phi is a different sum of integer multiples of `angles`.

    `terms` maps the multiples of the angles in phi to (A, B). The first multiple that is not zero is positive.
    """

    angles: tuple[sp.Symbol, ...]
    terms: Mapping[tuple[int, ...], tuple[sp.Expr, sp.Expr]]

    @property
    def term_count(self) -> int:
        """The number of terms of the written-out sum."""
        return count_written_terms(coefficient for pair in self.terms.values() for coefficient in pair)

    def to_expression(self) -> sp.Expr:
        """Return the SymPy expression."""
        summands = []
        for multiples, (cosine, sine) in self.terms.items():
            phi = sp.Add(*(k * angle for k, angle in zip(multiples, self.angles, strict=True)))
            summands += [cosine * sp.cos(phi), sine * sp.sin(phi)]
        return sp.Add(*summands)


def compute_fourier_form(expression: sp.Expr) -> FourierForm:
    """Return the Fourier form of a trigonometric polynomial.

    The sine and the cosine of an angle are combinations of e = exp(i angle) and 1/e, for which two symbols are used. In
    a term of the expanded polynomial, the exponent of e minus that of 1/e is the multiple of the angle. Raises
    ValueError if the expression is not a trigonometric polynomial with integer multiples.
    """
    trigs = _list_trigs(expression)
    angles = _sort_symbols({angle for trig in trigs for angle in trig.free_symbols})
    lengths = _sort_symbols(expression.free_symbols - set(angles))
    exponentials = {angle: {1: sp.Dummy(), -1: sp.Dummy()} for angle in angles}  # e and 1/e, by their exponents
    exponential_forms = {}
    for trig in trigs:
        multiples = _read_multiples(trig.args[0])
        e_phi, inverse_e_phi = (
            sp.Mul(*(exponentials[angle][sign if k > 0 else -sign] ** abs(k) for angle, k in multiples.items()))
            for sign in (1, -1)
        )  # exp(i phi) and exp(-i phi) for the argument phi of the sine or cosine
        is_cosine = isinstance(trig, sp.cos)
        exponential_forms[trig] = (e_phi + inverse_e_phi) / 2 if is_cosine else (e_phi - inverse_e_phi) / (2 * sp.I)
    symbols = [*lengths, *(symbol for pair in exponentials.values() for symbol in pair.values())]
    ring = sp.polys.rings.PolyRing(symbols or [sp.Dummy()], sp.QQ_I)
    polynomial = ring.from_expr(expression.xreplace(exponential_forms))
    terms: dict[tuple[int, ...], list[list[sp.Expr]]] = {}
    for powers, coefficient in polynomial.terms():
        exponents = powers[len(lengths) :]
        multiples_in_phi = tuple(map(operator.sub, exponents[::2], exponents[1::2])) if angles else ()
        first_multiple = next((k for k in multiples_in_phi if k), 0)
        if first_multiple >= 0:  # the terms with -phi are the conjugates of the terms with phi
            scale = 2 if first_multiple else 1
            product = sp.Mul(*map(sp.Pow, lengths, powers[: len(lengths)]))
            cosines, sines = terms.setdefault(multiples_in_phi, [[], []])
            real_part, imaginary_part = map(sp.QQ.to_sympy, (coefficient.x, coefficient.y))
            cosines.append(scale * real_part * product)
            sines.append(-scale * imaginary_part * product)
    sums = {key: (sp.Add(*cosines), sp.Add(*sines)) for key, (cosines, sines) in terms.items()}
    return FourierForm(angles, {key: pair for key, pair in sums.items() if pair != (0, 0)})


def _read_multiples(phi: sp.Expr) -> dict[sp.Symbol, int]:
    """Return the integer coefficients of the symbols in an angle. Raises ValueError for any other coefficient."""
    multiples = phi.expand().as_coefficients_dict()
    if any(not (angle.is_Symbol and multiple.is_Integer) for angle, multiple in multiples.items()):
        raise ValueError(f"{phi} is not a whole-number sum of angles")
    return {angle: int(multiple) for angle, multiple in multiples.items()}


def _is_whole_number_sum(phi: sp.Expr) -> bool:
    try:
        _read_multiples(phi)
    except ValueError:
        return False
    return True


def _sort_symbols(symbols: Iterable[sp.Symbol]) -> tuple[sp.Symbol, ...]:
    return tuple(sorted(symbols, key=lambda symbol: symbol.name))


def _list_trigs(expression: sp.Expr) -> list[sp.Expr]:
    return sorted(expression.atoms(sp.sin, sp.cos), key=sp.default_sort_key)


def wrap_angle(angle: sp.Expr) -> sp.Expr:
    """Return a numeric angle reduced to (-pi, pi], and any other angle expanded.

    >>> wrap_angle(-sp.pi), wrap_angle(sp.pi + sp.atan(2)), wrap_angle(sp.Symbol("alpha") + 2 * sp.pi)
    (pi, -pi + atan(2), alpha + 2*pi)
    """
    expanded_angle = sp.expand(angle)
    if not expanded_angle.is_number:
        return expanded_angle
    turns = sp.expand(expanded_angle / (2 * sp.pi))
    exact_or_rounded = turns if turns.is_Rational else sp.N(turns, 30)
    return sp.expand(expanded_angle - 2 * sp.pi * sp.ceiling(exact_or_rounded - sp.Rational(1, 2)))


def wrap_multiple_of_pi(angle: sp.Expr) -> sp.Expr:
    """Return a rational multiple of pi reduced to (-pi, pi], and any other angle expanded, so that 4 stays 4."""
    expanded_angle = sp.expand(angle)
    return wrap_angle(expanded_angle) if (expanded_angle / sp.pi).is_Rational else expanded_angle


def are_identical(a: sp.Expr, b: sp.Expr) -> bool:
    """Return whether two trigonometric polynomials are the same function. The result is a proof, not a test at points.

    Their difference is a polynomial in the sine s and the cosine c of each angle. After division by all s^2 + c^2 - 1,
    a unique remainder is left. The remainder is zero if and only if the functions are equal. Unlike a Fourier form, the
    remainder stays short if sines and cosines of many angles are multiplied. Raises ValueError if an expression is not
    a trigonometric polynomial with integer multiples of angles.
    """
    if a == b:
        return True
    difference = a - b
    trigs = _list_trigs(difference)
    multiples = {trig: _read_multiples(trig.args[0]) for trig in trigs}
    pairs = {angle: (sp.Dummy(), sp.Dummy()) for trig in trigs for angle in multiples[trig]}  # s and c of each angle
    symbols_of_trigs = {sp.sin(q): s for q, (s, _) in pairs.items()} | {sp.cos(q): c for q, (_, c) in pairs.items()}
    polynomial_form = difference.xreplace({trig: sp.expand_trig(trig).xreplace(symbols_of_trigs) for trig in trigs})
    unknowns = [symbol for pair in pairs.values() for symbol in pair]
    ring = sp.polys.rings.PolyRing([*unknowns, *(polynomial_form.free_symbols - set(unknowns)), sp.Dummy()], sp.QQ)
    return not ring.from_expr(polynomial_form).rem([ring(s**2 + c**2 - 1) for s, c in pairs.values()])


@dataclass(frozen=True)
class Factored:
    """A product of a rational coefficient and of factors with their powers. Factors differ by more than a sign."""

    coefficient: sp.Rational
    factors: tuple[tuple[sp.Expr, int], ...]

    @property
    def is_zero(self) -> bool:
        """Whether the product is the zero function."""
        return bool(self.coefficient == 0)

    def to_expression(self) -> sp.Expr:
        """Return the product as a SymPy expression."""
        return sp.Mul(self.coefficient, *(factor**power for factor, power in self.factors))

    def divide_by(self, divisor: "Factored") -> "Factored":
        """Return the quotient, with common factors cancelled; powers may become negative."""
        powers = dict(self.factors)
        for factor, power in divisor.factors:
            powers[factor] = powers.get(factor, 0) - power
        factors = tuple((factor, power) for factor, power in powers.items() if power)
        return Factored(self.coefficient / divisor.coefficient, factors)

    def substitute(self, values: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
        """Return the product with values substituted in each factor; lengths that become equal are factored out."""
        has_duplicates = len(set(values.values())) < len(values)
        bases = [(factor.xreplace(values), power) for factor, power in self.factors]
        if has_duplicates:
            bases = [(distribute_fraction(sp.factor_terms(base)), power) for base, power in bases]
        return sp.Mul(self.coefficient, *(base**power for base, power in bases))


def distribute_fraction(product: sp.Expr) -> sp.Expr:
    """Move the fraction of a product into its first sum whose terms have numeric factors, and return the product.

    >>> x, y, z = sp.symbols("x y z")
    >>> distribute_fraction(z * (15 * x + 7 * y) / 20), distribute_fraction(z * (x + y) / 20)
    (z*(3*x/4 + 7*y/20), z*(x + y)/20)
    """
    fraction, remaining_product = product.as_coeff_Mul()
    factors = sp.Mul.make_args(remaining_product)
    sum_with_numbers = next((factor for factor in factors if factor.is_Add and _has_numbers(factor)), None)
    if fraction.is_integer or sum_with_numbers is None:
        return product
    other_factors = [factor for factor in factors if factor is not sum_with_numbers]
    return sp.Mul(*other_factors, sp.Add(*(distribute_fraction(fraction * term) for term in sum_with_numbers.args)))


def _has_numbers(total: sp.Expr) -> bool:
    """Return whether a term of a sum, or of a sum in a term, has a numeric factor other than 1 and -1."""
    return any(
        abs(term.as_coeff_Mul()[0]) != 1 or any(inner.is_Add and _has_numbers(inner) for inner in term.args)
        for term in total.args
    )


def remove_arctangents(expression: sp.Expr) -> sp.Expr:
    """Return an expression without arctangents of lengths in its angles; unchanged if roots would remain.

    >>> a, b, t1 = sp.symbols("a1 a2 theta1")
    >>> remove_arctangents(sp.sqrt(a**2 + b**2) * sp.sin(t1 + sp.atan2(b, a)))
    a1*sin(theta1) + a2*cos(theta1)
    >>> remove_arctangents(a * sp.sin(t1 + sp.atan2(b, a)))
    a1*sin(theta1 + atan2(a2, a1))
    """
    if not expression.has(sp.atan2):
        return expression
    trigs = [trig for trig in expression.atoms(sp.sin, sp.cos) if trig.has(sp.atan2)]
    result = sp.expand(expression.xreplace({trig: _expand_arctangents(trig) for trig in trigs}))
    return expression if any(power.exp < 0 for power in result.atoms(sp.Pow)) else result


def _expand_arctangents(trig: sp.Expr) -> sp.Expr:
    """Expand the sine or cosine of a sum of angles, so that the arctangents become quotients with a root."""
    arctangents = [term for term in sp.Add.make_args(trig.args[0]) if term.has(sp.atan2)]
    c, s = sp.cos(trig.args[0] - sp.Add(*arctangents)), sp.sin(trig.args[0] - sp.Add(*arctangents))
    for term in arctangents:
        x, y = sp.cos(term), sp.sin(term)
        c, s = c * x - s * y, s * x + c * y
    return c if isinstance(trig, sp.cos) else s


_MAX_OPERATIONS = 400
"""`remove_brackets` leaves an expression with more operations than this unchanged, because expanding it takes long."""


def remove_brackets(expression: sp.Expr) -> sp.Expr:
    """Return a sum in which no root of a number multiplies a sum with symbols; terms are grouped by sines and cosines.

    >>> d2, t1 = sp.symbols("d2 theta1")
    >>> remove_brackets(sp.sqrt(2) * (d2 + sp.sqrt(2) / 5) / 2 - sp.Rational(1, 10))
    sqrt(2)*d2/2 + 1/10
    >>> remove_brackets(sp.sqrt(2) * (d2 + sp.sqrt(2) / 5) * sp.cos(t1) / 2 - d2 * sp.cos(t1))
    (-d2 + sqrt(2)*d2/2 + 1/5)*cos(theta1)
    """
    if not any(map(_has_bracket, expression.atoms(sp.Mul))) or sp.count_ops(expression) > _MAX_OPERATIONS:
        return expression
    groups: dict[sp.Expr, list[sp.Expr]] = {}
    for term in sp.Add.make_args(sp.expand(expression)):
        coefficient, trigs = term.as_independent(sp.sin, sp.cos, as_Add=False)
        groups.setdefault(trigs, []).append(coefficient)
    return sp.Add(*(sp.Add(*coefficient) * trigs for trigs, coefficient in groups.items()))


def _has_bracket(product: sp.Mul) -> bool:
    """Return whether a root of a number multiplies a sum with symbols."""
    numbers = [factor for factor in product.args if factor.is_number]
    return any(map(_is_root, numbers)) and any(factor.is_Add and factor.free_symbols for factor in product.args)


def _is_root(number: sp.Expr) -> bool:
    return number.is_Pow and number.exp.is_Rational and not number.exp.is_Integer


@lru_cache(maxsize=20_000)
def factor_trig(expression: sp.Expr, max_terms: int = 200) -> Factored:
    """Return the factored form of a trigonometric polynomial, as in a textbook.

    First, the sine and the cosine of each sum of angles are factored as independent symbols. Then each factor is
    replaced by its shortest form: c2*s23 - s2*c23 becomes s3, and c^2 + s^2 becomes 1.

    If the polynomial has more than `max_terms` terms, only the factors that all terms share are split off. A complete
    factorization would take minutes, and nobody would read the result. Raises ValueError if the expression has roots of
    numbers, because the coefficients of factors are rational.
    """
    if expression == 0:
        return Factored(sp.S.Zero, ())
    if any(power.is_number and _is_root(power) for power in expression.atoms(sp.Pow)):
        raise ValueError(f"{expression} has roots of numbers")
    symbols_by_trig, trigs_by_symbol = _name_trigs(expression)
    coefficient, polynomial_factors = _factor_polynomial(expression.xreplace(symbols_by_trig), max_terms)
    powers: dict[sp.Expr, int] = {}
    for factor, power in polynomial_factors:
        content, shortest_form = _find_shortest_form(factor.xreplace(trigs_by_symbol))
        if shortest_form == 0:
            return Factored(sp.S.Zero, ())
        coefficient *= content**power
        for piece in sp.Mul.make_args(shortest_form):
            base, exponent = piece.as_base_exp()
            if not exponent.is_Integer:  # a root, or exp(x), is a factor
                base, exponent = piece, sp.S.One
            if base != 1:
                powers[base] = powers.get(base, 0) + power * int(exponent)
    factors = sorted(powers.items(), key=lambda item: (sp.count_ops(item[0]), sp.default_sort_key(item[0])))
    return Factored(sp.Rational(coefficient), tuple(factors))


def _factor_polynomial(expression: sp.Expr, max_terms: int) -> tuple[sp.Expr, list[tuple[sp.Expr, int]]]:
    """Return the coefficient of a polynomial, and its factors with their powers.

    If the polynomial has more than `max_terms` terms, only the factors that all terms share are split off.
    """
    if not expression.free_symbols:
        return expression, []
    polynomial = sp.Poly(expression)
    powers, remaining_polynomial = polynomial.terms_gcd()
    coefficient, primitive = remaining_polynomial.primitive()
    if primitive.LC() < 0:
        coefficient, primitive = -coefficient, -primitive
    factors = [(symbol, power) for symbol, power in zip(polynomial.gens, powers, strict=True) if power]
    if len(primitive.terms()) > max_terms:
        return coefficient, [*factors, (primitive.as_expr(), 1)]
    remaining_polynomial, linear_factor = _split_linear_factor(primitive)
    content, other_factors = remaining_polynomial.factor_list()
    factors += [(factor.as_expr(), power) for factor, power in other_factors]
    return coefficient * content, factors if linear_factor is None else [*factors, (linear_factor, 1)]


def _split_linear_factor(primitive: sp.Poly) -> tuple[sp.Poly, sp.Expr | None]:
    """Split off the factor that contains a symbol x of degree one; return the remaining polynomial, and the factor.

    A polynomial x A + B is g (x A' + B') with the greatest common divisor g of A and B, and x A' + B' is irreducible.
    This is much faster than a general factorization, and applies because most lengths have degree one. Return None for
    the factor if there is no such symbol.
    """
    terms = primitive.terms()
    linear_indices = [k for k, powers in enumerate(zip(*primitive.monoms(), strict=True)) if max(powers) == 1]
    if not linear_indices or not primitive.domain.is_ZZ:
        return primitive, None
    k = min(linear_indices, key=lambda k: sum(powers[k] for powers, _ in terms))
    ring = sp.polys.rings.PolyRing(primitive.gens, sp.ZZ)
    polynomial = ring.from_dict({powers: sp.ZZ(int(c)) for powers, c in terms})
    constant_part = ring.from_dict({powers: c for powers, c in polynomial.items() if not powers[k]})
    common_factor = (polynomial - constant_part).exquo(ring.gens[k]).gcd(constant_part)
    common_factor *= 1 if common_factor.LC > 0 else -1
    return sp.Poly.from_dict(dict(common_factor), *primitive.gens), polynomial.exquo(common_factor).as_expr()


def _name_trigs(expression: sp.Expr) -> tuple[dict[sp.Expr, sp.Symbol], dict[sp.Symbol, sp.Expr]]:
    """Return a symbol for every cosine and sine in an expression, and the inverse mapping.

    The symbol of an angle's cosine is followed by the symbol of its sine.
    """
    symbols_by_trig: dict[sp.Expr, sp.Symbol] = {}
    arguments = sorted({atom.args[0] for atom in _list_trigs(expression)}, key=sp.default_sort_key)
    for index, argument in enumerate(arguments):
        symbols_by_trig[sp.cos(argument)] = sp.Symbol(f"c_{index}")
        symbols_by_trig[sp.sin(argument)] = sp.Symbol(f"s_{index}")
    return symbols_by_trig, {symbol: trig for trig, symbol in symbols_by_trig.items()}


_MAX_FOURIER_GROWTH = 3
"""A Fourier form with more than this many times the terms of a factor is not tried as a shorter form of the factor."""


def _find_shortest_form(factor: sp.Expr) -> tuple[sp.Rational, sp.Expr]:
    """Return the shortest form of a factor as a product of a rational number and a remaining form.

    The first term of the remaining form is positive. These forms are compared: the factor itself, its Fourier form, and
    forms with expanded angles or replaced squares. In forms with expanded angles, a sum of lengths times a product of
    sines and cosines counts as one term.
    """
    forms = [factor]
    if factor.is_Add:
        fourier_form = compute_fourier_form(factor)
        if not fourier_form.terms:
            return sp.S.One, sp.S.Zero
        forms += _reduce_squares(factor)
        # a longer Fourier form would become even longer if its angles were expanded
        if fourier_form.term_count <= _MAX_FOURIER_GROWTH * len(factor.args):
            expanded_form = sp.expand(sp.expand_trig(fourier_form.to_expression()))
            long_forms = (expanded_form, *_reduce_squares(expanded_form))
            forms += [fourier_form.to_expression(), *map(_collect_trigs, long_forms)]
    shortest_form = min(forms, key=lambda form: (len(sp.Add.make_args(form)), sp.count_ops(form)))
    content, primitive = shortest_form.as_content_primitive()
    if min(sp.Add.make_args(primitive), key=sp.default_sort_key).could_extract_minus_sign():
        content, primitive = -content, sp.Add(*(-term for term in sp.Add.make_args(primitive)))
    if primitive.is_Add:
        symbols_by_trig, trigs_by_symbol = _name_trigs(primitive)
        primitive = sp.factor_terms(primitive.xreplace(symbols_by_trig)).xreplace(trigs_by_symbol)
    return content, primitive


def _collect_trigs(expression: sp.Expr) -> sp.Expr:
    """Return a sum with one term for each product of sines and cosines."""
    symbols_by_trig, trigs_by_symbol = _name_trigs(expression)
    if not symbols_by_trig:
        return expression
    polynomial = sp.Poly(expression.xreplace(symbols_by_trig), *symbols_by_trig.values())
    terms = (coefficient * sp.Mul(*map(sp.Pow, polynomial.gens, powers)) for powers, coefficient in polynomial.terms())
    return sp.Add(*terms).xreplace(trigs_by_symbol)


def _reduce_squares(expression: sp.Expr) -> list[sp.Expr]:
    """Return two forms of an expression: with s^2 replaced by 1 - c^2, and with c^2 replaced by 1 - s^2.

    Return an empty list if the expression has no squares of sines or cosines.
    """
    symbols_by_trig, trigs_by_symbol = _name_trigs(expression)
    symbols = list(symbols_by_trig.values())
    if not symbols:
        return []
    polynomial = sp.Poly(expression.xreplace(symbols_by_trig), *symbols)
    if all(power < 2 for powers in polynomial.monoms() for power in powers):
        return []  # there is nothing to replace
    forms = []
    for offset in (0, 1):  # with 0, i is the index of each cosine and j that of its sine; with 1, the reverse
        summands = []
        for powers, coefficient in polynomial.terms():
            term = coefficient
            for k in range(0, len(symbols), 2):
                i, j = k + offset, k + 1 - offset
                square_count, remainder = divmod(powers[j], 2)
                term *= symbols[i] ** powers[i] * symbols[j] ** remainder * (1 - symbols[i] ** 2) ** square_count
            summands.append(term)
        forms.append(sp.expand(sp.Add(*summands)).xreplace(trigs_by_symbol))
    return forms


_MAX_TEXTBOOK_TERMS = 60
"""Maximum number of terms of an expression whose textbook form shows all factors."""


def to_textbook_form(expression: sp.Expr) -> sp.Expr:
    """Return a trigonometric polynomial in textbook form: like terms collected, common factors outside.

    >>> t1, t2, a1, a2 = sp.symbols("theta1 theta2 a1 a2")
    >>> to_textbook_form(a1 * sp.cos(t1) + a2 * sp.cos(t1) * sp.cos(t2))
    (a1 + a2*cos(theta2))*cos(theta1)
    """
    return factor_trig(expression, max_terms=_MAX_TEXTBOOK_TERMS).to_expression()


def write_in_textbook_form(expression: sp.Expr) -> sp.Expr:
    """Return any expression in textbook form, even if it has roots, sums in denominators, or other functions.

    First, the contents of roots, denominators and functions are written in textbook form. Then each root, denominator
    or function is treated as a symbol. An expression without a textbook form is left unchanged.

    >>> t1, t2, a1 = sp.symbols("theta1 theta2 a1")
    >>> write_in_textbook_form(sp.sqrt((a1 * sp.cos(t1)) ** 2 + (a1 * sp.sin(t1)) ** 2 + 3) * t2)
    theta2*sqrt(a1**2 + 3)
    """
    names: dict[sp.Expr, sp.Symbol] = {}

    def name(node: sp.Expr) -> sp.Symbol:
        return names.setdefault(node, sp.Symbol(f"function {len(names)}"))  # no other symbol has a space

    def rewrite(node: sp.Expr) -> sp.Expr:
        if node.is_Pow and node.exp.is_Rational and not (node.exp.is_Integer and (node.exp > 0 or node.base.is_Symbol)):
            root = sp.Pow(write_in_textbook_form(node.base), sp.Rational(1, node.exp.q))
            return name(root) ** node.exp.p
        if node.is_Function and not (isinstance(node, sp.sin | sp.cos) and _is_whole_number_sum(node.args[0])):
            return name(node.func(*map(write_in_textbook_form, node.args)))
        return node.func(*map(rewrite, node.args)) if node.args and not node.is_Function else node

    polynomial = rewrite(expression)
    try:
        numerator, denominator = sp.fraction(sp.together(polynomial))
        if denominator.free_symbols:
            divisor = factor_trig(sp.expand(denominator))
            factored_numerator = factor_trig(sp.expand(numerator), max_terms=_MAX_TEXTBOOK_TERMS)
            polynomial = factored_numerator.divide_by(divisor).to_expression()
        else:
            polynomial = to_textbook_form(sp.expand(polynomial))
    except (ValueError, sp.PolynomialError):  # for example, an angle outside a sine
        pass
    return polynomial.xreplace({symbol: node for node, symbol in names.items()})


def to_textbook_matrix(matrix: sp.Matrix) -> sp.Matrix:
    """Return a matrix whose entries are multiplied out, then in textbook form."""
    return matrix.applyfunc(lambda entry: to_textbook_form(sp.expand(entry)))


def count_terms(entries: sp.Matrix, ignored_values: tuple[int, ...] = (0,)) -> int:
    """Return the number of terms of a matrix's entries, multiplied out. Entries in `ignored_values` don't count."""
    return sum(len(sp.Add.make_args(sp.expand(entry))) for entry in entries if entry not in ignored_values)


def count_written_terms(expressions: Iterable[sp.Expr]) -> int:
    """Return the number of terms of all expressions as they are written; zeros don't count."""
    return sum(len(sp.Add.make_args(expression)) for expression in expressions if expression != 0)
