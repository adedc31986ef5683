"""Typeset SymPy's formulas in the textbook's notation: c_1, s_{12}, decimals for lengths, dotted joint rates."""

import math
import re
from collections.abc import Sequence
from functools import cache, lru_cache, partial
from itertools import combinations_with_replacement
from typing import NamedTuple

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.formula import layout, order
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.layout import (
    Layout,
    Pieces,
    make_digits,
    make_numeric_fraction,
    make_row,
    make_script,
)
from qdot.exercises.formula.order import COMPONENT_PATTERN, find_joint_sum_digits, is_rate_or_component, write_decimal
from qdot.exercises.formula.printers.latex import print_latex
from qdot.exercises.writing.angles import AngleNames
from qdot.exercises.writing.line_breaking import fill_lines
from qdot.exercises.writing.shortening import multiply_numbers

_FUNCTIONS = {
    **{getattr(sp, name): Layout("function", name) for name in ("sin", "cos", "tan", "exp")},
    **{getattr(sp, f"a{name}"): Layout("function", f"arc{name}") for name in ("sin", "cos", "tan")},
    **{getattr(sp, name): Layout("text", name) for name in ("atan2", "sign")}, sp.log: Layout("function", "ln"),
}  # fmt: skip
_TALL = frozenset(("frac", "root"))
"""Kinds of layouts that need tall brackets; a small fraction fits into brackets of normal height."""
_MAX_DENOMINATOR = 10**6
"""Maximum denominator of a fraction before a root; numbers with a larger denominator are shown as decimals."""
_HALVES = (2, 4, 8)
"""The denominators of halves, quarters and eighths."""
_SYMBOL_PATTERN = re.compile(r"(theta|alpha|beta|qdd?|[a-zA-Z])(\d*)")


@cache
def write_symbol(name: str, prismatic_numbers: tuple[str, ...] = ()) -> str:
    r"""Return the LaTeX of a symbol.

    `prismatic_numbers` are the numbers of the prismatic joints, whose rates are written \dot d.

    >>> write_symbol("theta12"), write_symbol("qd2", ("2",)), write_symbol("qdd1"), write_symbol("wx")
    ('\\theta_{12}', '\\dot{d}_{2}', '\\ddot{\\theta}_{1}', '\\omega_{x}')
    """
    if COMPONENT_PATTERN.fullmatch(name):
        return (r"\omega" if name[0] == "w" else name[0]) + f"_{{{name[1]}}}"
    match = _SYMBOL_PATTERN.fullmatch(name)
    if match is None:
        return _write_other_name(name)
    letter, index = match.groups()
    if letter in ("qd", "qdd"):
        letter = ("\\dot" if letter == "qd" else "\\ddot") + ("{d}" if index in prismatic_numbers else r"{\theta}")
    elif letter in ("theta", "alpha", "beta"):
        letter = "\\" + letter
    return f"{letter}_{{{index}}}" if index else letter


def _write_other_name(name: str) -> str:
    r"""Return the LaTeX of a name that the chapter does not use.

    The second of two letters is an index. Longer words are upright.

    >>> _write_other_name("Fx"), _write_other_name("m_load"), _write_other_name("tau1"), _write_other_name("mass")
    ('F_{x}', 'm_{\\text{load}}', '\\tau_{1}', '\\text{mass}')
    """
    if not name.isidentifier():  # it is LaTeX already
        return str(sp.latex(sp.Symbol(name)))
    stem, _, index = name.partition("_")
    if not index and len(name) == 2 and not sp.latex(sp.Symbol(name)).startswith("\\"):
        stem, index = name[0], name[1]
    symbol = str(sp.latex(sp.Symbol(stem)))
    symbol = rf"\text{{{stem}}}" if len(stem) > 1 and symbol == stem else symbol
    index = rf"\text{{{index}}}".replace("_", " ") if len(index) > 1 and not index.isdigit() else index
    return f"{symbol}_{{{index}}}" if index else symbol


# --- layout ---


class _SignedTerm(NamedTuple):
    """A typeset term: whether it is subtracted, and the pieces of its absolute value."""

    is_negative: bool
    pieces: Pieces


def _join_terms(signed_terms: Sequence[_SignedTerm]) -> Pieces:
    terms = ((layout.MINUS if is_negative else layout.PLUS, *pieces) for is_negative, pieces in signed_terms)
    pieces = layout.join_pieces((), terms)
    return pieces if signed_terms[0].is_negative else pieces[1:]


class _ExpressionLayout:
    """Lays out SymPy expressions. A term is a sign and an absolute value, so that signs can move out of brackets."""

    def __init__(
        self, prismatic_numbers: tuple[str, ...], lengths: tuple[sp.Rational, ...] = (), has_halves: bool = False
    ) -> None:
        self.prismatic_numbers, self.lengths, self.has_halves = prismatic_numbers, lengths, has_halves
        self.cached_product = lru_cache(maxsize=2048)(self.lay_out_product)  # several results share terms

    def lay_out(self, expression: sp.Expr) -> Pieces:
        return _join_terms(self.lay_out_terms(expression))

    def lay_out_terms(self, expression: sp.Expr, flips_signs: bool = False) -> list[_SignedTerm]:
        """Return the terms of a sum in reading order, with all signs changed if `flips_signs`."""
        terms = order.order_terms(expression, flips_signs)
        return [_SignedTerm(is_negative, self.cached_product(term).pieces) for is_negative, term in terms]

    def lay_out_product(self, expression: sp.Expr) -> _SignedTerm:
        """Return a product and its sign; the signs of sums in brackets are chosen so that few begin with a minus."""
        if expression.is_Add:
            return _SignedTerm(is_negative=False, pieces=self.lay_out(expression))
        coefficient, remainder = expression.as_coeff_Mul()
        if remainder == 1:
            return self.lay_out_number(coefficient)
        product = order.order_product(expression)
        factors_above, factors_below = product.numerator, product.denominator
        number_above, number_below = self.split_coefficient(product.number, remainder, bool(factors_below))
        has_denominator = bool(factors_below or number_below)
        is_alone_above = has_denominator and not number_above and len(factors_above) == 1
        pieces_above = self.lay_out_factors(factors_above, product.flipped_sums, is_alone_above)
        numerator = number_above + pieces_above or make_digits("1")
        if not has_denominator:
            return _SignedTerm(product.is_negative, numerator)
        is_alone_below = not number_below and len(factors_below) == 1
        denominator = number_below + self.lay_out_factors(factors_below, product.flipped_sums, is_alone_below)
        return _SignedTerm(product.is_negative, (layout.make_fraction(numerator, denominator, remainder.is_number),))

    def lay_out_factors(self, factors: Sequence[sp.Expr], flipped_sums: frozenset[sp.Expr], is_alone: bool) -> Pieces:
        """Return factors side by side; a sum gets brackets unless it `is_alone` in a numerator or denominator."""
        pieces: list[Layout] = []
        for k, factor in enumerate(factors):
            if k and _ends_in_angle(pieces) and any(map(is_rate_or_component, factor.free_symbols)):
                pieces.append(layout.THIN)  # \cos\varphi_1 \dot\theta_1 is not the cosine of a product
            pieces += self.lay_out_factor(factor, factor in flipped_sums, is_alone)
        return tuple(pieces)

    def lay_out_factor(self, factor: sp.Expr, flips_signs: bool = False, is_alone: bool = False) -> Pieces:
        if factor.is_Add:
            terms = _join_terms(self.lay_out_terms(factor, flips_signs))
            return terms if is_alone else layout.bracket(terms, _TALL)
        if factor.is_Pow:
            return self.lay_out_power(factor.base, factor.exp)
        if factor.is_Symbol:
            return parse_latex(write_symbol(factor.name, self.prismatic_numbers)).inner
        if factor.is_number and factor.is_Rational:
            return self.lay_out_number(factor).pieces
        if isinstance(factor, sp.Abs):
            return (layout.make_fence("||", self.lay_out(factor.args[0])),)
        if factor.func in _FUNCTIONS:
            return self.lay_out_call(factor, layout.EMPTY)
        return parse_latex(str(sp.latex(factor))).inner

    def lay_out_power(self, base: sp.Expr, exponent: sp.Expr) -> Pieces:
        if exponent == sp.Rational(1, 2):
            return (Layout("root", "sqrt", (make_row(*self.lay_out(base)),)),)
        if exponent.could_extract_minus_sign():
            return self.cached_product(sp.Pow(base, exponent)).pieces
        exponent_layout = make_row(*self.lay_out(exponent))
        if isinstance(base, (sp.sin, sp.cos, sp.tan)):
            return self.lay_out_call(base, exponent_layout)
        base_pieces = self.lay_out_factor(base)
        if not (base.is_Add or base.is_Symbol or (base.is_Integer and base > 0)):
            base_pieces = layout.bracket(base_pieces, _TALL)
        return layout.raise_pieces_to(base_pieces, exponent_layout)

    def lay_out_call(self, expression: sp.Expr, superscript: Layout) -> Pieces:
        word, argument = _FUNCTIONS[expression.func], expression.args[0]
        function_name = make_script(word, layout.EMPTY, superscript) if superscript.inner else word
        if isinstance(expression, (sp.sin, sp.cos)):
            joint_digits = find_joint_sum_digits(argument)
            if joint_digits is not None:
                letter = Layout("letter", word.text[0])
                return (make_script(letter, make_row(*make_digits(joint_digits)), superscript),)
            if order.NAMED_ANGLE_PATTERN.fullmatch(str(argument)):
                return (function_name, *parse_latex(argument.name).inner)
            return (function_name, *layout.bracket(self.lay_out_angle(argument), _TALL))
        arguments = layout.join_pieces((layout.COMMA,), map(self.lay_out, expression.args))
        return (function_name, *layout.bracket(arguments, _TALL))

    def lay_out_angle(self, value: sp.Expr) -> Pieces:
        """Lay out an angle. Its constant is in degrees if this is a short decimal: theta_1 + 30°, or 30° - theta_1.

        If a number of radians is added, as in theta_1 + 0.7 + pi/2, the whole angle is in radians.
        """
        if has_radians(value):
            return self.lay_out(value)
        constant = sp.Add(*(term for term in sp.Add.make_args(sp.expand(value)) if (term / sp.pi).is_Rational))
        remainder, digits = sp.expand(value - constant), write_decimal(abs(180 * constant / sp.pi))
        if constant == 0 or digits is None:
            return self.lay_out(value)
        degrees = make_script(Layout("number", digits), superscript=layout.DEGREE)
        if remainder == 0:
            return (layout.MINUS, degrees) if constant < 0 else (degrees,)
        remainder_pieces = self.lay_out(remainder)
        if constant < 0 or remainder_pieces[0] != layout.MINUS:
            return (*remainder_pieces, layout.MINUS if constant < 0 else layout.PLUS, degrees)
        return (degrees, *remainder_pieces)

    def lay_out_number(self, value: sp.Expr) -> _SignedTerm:
        is_negative, size = bool(value.is_negative), abs(value)
        if size.is_Float:
            digits, _, power = f"{float(size):.10g}".partition("e")
            pieces = layout.make_scientific_number(digits, int(power)) if power else make_digits(digits)
            return _SignedTerm(is_negative, pieces)
        if not size.is_Rational:
            return _SignedTerm(is_negative=False, pieces=self.lay_out_factor(value))
        if (decimal_digits := write_decimal(size)) is not None:
            return _SignedTerm(is_negative, make_digits(decimal_digits))
        return _SignedTerm(is_negative, (make_numeric_fraction(size.p, size.q),))

    def split_coefficient(self, value: sp.Expr, remainder: sp.Expr, is_fraction: bool) -> tuple[Pieces, Pieces]:
        """Split a numeric coefficient into the numbers in the numerator and in the denominator of its term.

        7/20 adds 0.35 to the numerator; 20/7 adds 0.35 to the denominator. `remainder` is the term without the
        coefficient, and `is_fraction` says whether it has a denominator.
        """
        if value == 1:
            return (), ()
        if not value.is_Rational:
            return self.lay_out_number(value).pieces, ()
        if self.has_halves and value.q in _HALVES and not is_fraction:
            return (make_numeric_fraction(value.p, value.q),), ()
        digits, inverse_digits = write_decimal(value), write_decimal(1 / value)
        if is_fraction and (quotient := _find_quotient_of_lengths(value, self.lengths)) is not None:
            numerator, denominator = map(self.lay_out_number, quotient)
            return (() if quotient[0] == 1 else numerator.pieces), denominator.pieces
        has_root = any(factor.is_Pow and factor.is_number for factor in sp.Mul.make_args(remainder))
        if value.q > _MAX_DENOMINATOR or not (remainder.is_number or has_root):
            prefers_inverse = digits is None or (is_fraction and value > 1 and len(str(inverse_digits)) <= len(digits))
            if inverse_digits is not None and prefers_inverse:
                return (), make_digits(inverse_digits)
            if digits is not None:
                return make_digits(digits), ()
        numerator_pieces, denominator_pieces = (make_digits(str(n)) if n != 1 else () for n in (value.p, value.q))
        return numerator_pieces, denominator_pieces


@lru_cache(maxsize=1024)
def _find_quotient_of_lengths(value: sp.Rational, lengths: tuple[sp.Rational, ...]) -> tuple[sp.Expr, sp.Expr] | None:
    """Return a number as the numerator and denominator of a quotient of an arm's lengths: 7/9 as 0.35 and 0.45.

    Numerator and denominator may each be a product of two lengths, and the numerator may be 1. Returns None for other
    numbers, and for decimals that are short.
    """
    if value == 1 or (write_decimal(value) is not None and not value.is_Integer):
        return None
    products = [a * b for a, b in combinations_with_replacement(lengths, 2)]
    for numerator_size, denominator_size in ((1, 1), (1, 2), (2, 1), (2, 2)):
        for denominator in lengths if denominator_size == 1 else products:
            numerator = value * denominator
            if (numerator_size == 1 and numerator == 1) or numerator in (lengths if numerator_size == 1 else products):
                return numerator, denominator
    return None


def _ends_in_angle(pieces: Sequence[Layout]) -> bool:
    """Return whether pieces end with a named angle, which has no brackets after sin and cos."""
    return pieces[-1].kind == "script" and pieces[-1].inner[0].text == "φ"


def tex(
    expression: sp.Expr | sp.Matrix, chain: Chain | None = None, angles: AngleNames | None = None,
    has_halves: bool = False,
) -> str:  # fmt: skip
    r"""Return the LaTeX of an expression or matrix in the textbook's notation, with the names of `angles`.

    If `has_halves`, halves, quarters and eighths are fractions unless a length of the arm is a number.

    >>> t1, t2, a1 = sp.symbols("theta1 theta2 a1")
    >>> tex(-a1 * sp.sin(t1) - sp.Rational(2, 5) * sp.cos(t1 + t2 + sp.pi / 6))
    '-a_{1} s_{1} - 0.4 \\cos(\\theta_{1} + \\theta_{2} + 30^\\circ)'
    """
    return print_latex(lay_out(expression, chain, angles, has_halves))


def tex_zero(condition: sp.Expr, chain: Chain | None = None, angles: AngleNames | None = None) -> str:
    r"""Return the LaTeX of an expression that a condition sets to zero, without the numeric factor of a product.

    >>> tex_zero(-2 * sp.sin(sp.Symbol("theta3"))), tex_zero(sp.Symbol("a1") - sp.Symbol("a2"))
    ('s_{3}', 'a_{1} - a_{2}')
    """
    named_condition = sp.sympify(condition if angles is None else angles.use_names(condition))
    return tex(remove_numeric_factor(named_condition), chain)


def remove_numeric_factor(condition: sp.Expr) -> sp.Expr:
    """Return a condition without its numeric factor: sin(theta3) for -2 sin(theta3)."""
    _, remainder = condition.as_coeff_Mul()
    return condition if remainder.is_Add or remainder == 1 else remainder


def lay_out(
    expression: sp.Expr | sp.Matrix, chain: Chain | None = None, angles: AngleNames | None = None,
    has_halves: bool = False,
) -> Layout:  # fmt: skip
    """Return the layout of an expression or matrix in the textbook's notation, with the names of `angles`."""
    lengths = list_numeric_lengths(chain) if chain is not None else ()
    prismatic_numbers = list_prismatic_joints(chain) if chain is not None else ()
    lay_out_entry = partial(
        _lay_out_scalar, prismatic_numbers=prismatic_numbers, lengths=lengths, has_halves=has_halves and not lengths
    )
    named_expression = sp.sympify(expression if angles is None else angles.use_names(sp.sympify(expression)))
    if not isinstance(named_expression, sp.MatrixBase):
        return make_row(*lay_out_entry(named_expression))
    rows = named_expression.tolist()
    return make_row(layout.make_matrix([list(map(lay_out_entry, entries)) for entries in rows]))


def list_prismatic_joints(chain: Chain) -> tuple[str, ...]:
    r"""Return the numbers of an arm's prismatic joints, whose rates are \dot d."""
    return tuple(q.name[1:] for q in chain.q if q.name.startswith("d"))


@lru_cache(maxsize=256)
def list_numeric_lengths(chain: Chain) -> tuple[sp.Rational, ...]:
    """Return the absolute values of the nonzero numeric lengths of an arm."""
    return tuple(dict.fromkeys(abs(size) for size in list_lengths(chain) if size.is_Rational and size != 0))


def list_lengths(chain: Chain) -> list[sp.Expr]:
    """Return the lengths in an arm's table, point and base, in this order."""
    lengths: list[sp.Expr] = []
    for joint, offset in zip(chain.joints, chain.offsets, strict=True):
        lengths += [joint.a, joint.d if joint.is_revolute else offset]
    return [*lengths, *chain.point.offset, *chain.base.position]


@lru_cache(maxsize=1024)
def _lay_out_scalar(
    expression: sp.Expr,
    prismatic_numbers: tuple[str, ...],
    lengths: tuple[sp.Rational, ...],
    has_halves: bool = False,
) -> Pieces:
    """Lay out an expression; cached, because steps, results and other parts show the same expressions."""
    return _get_expression_layout(prismatic_numbers, lengths, has_halves).lay_out(multiply_numbers(expression))


_get_expression_layout = lru_cache(maxsize=16)(_ExpressionLayout)


MAX_LINE_WIDTH = 44.0
"""Maximum width of a formula's line in em (see `line_breaking`); longer lines are broken."""


def tex_lines(expression: sp.Expr, chain: Chain | None = None, angles: AngleNames | None = None) -> str:
    """Return the LaTeX of a sum for the right side of an aligned formula, with long sums broken into lines."""
    terms = layout.split_terms(lay_out(expression, chain, angles).inner)
    first_line, *other_lines = fill_lines(terms, MAX_LINE_WIDTH)
    lines = (first_line, *((layout.QUAD, *line[1:]) for line in other_lines))
    return r" \\ & ".join(print_latex(make_row(*line)) for line in lines)


def tex_length(value: sp.Expr) -> str:
    r"""Return the LaTeX of a length for a table or a sentence, with the unit m if it is a number or has a decimal term.

    >>> tex_length(sp.Symbol("d2") + sp.Rational(33, 100))
    'd_{2} + 0.33\\,\\text{m}'
    >>> tex_length(sp.sqrt(2) * (10 * sp.Symbol("a2") + 1) / 20)
    '\\frac{\\sqrt{2} (a_{2} + 0.1)}{2}'
    >>> tex_length(sp.sqrt(2) * (3 * sp.Symbol("a2") + 1))
    '\\sqrt{2} (3 a_{2} + 1)'
    """
    length = _restore_table_numbers(sp.sympify(value))
    constant = sp.Add(*(term for term in sp.Add.make_args(length) if term.is_number))
    has_unit = constant != 0 and (length.is_number or write_decimal(constant) is not None)
    return _tex_with_unit(length, "m" if has_unit else "")


def _restore_table_numbers(value: sp.Expr) -> sp.Expr:
    """Return a length in which the sum in brackets has the numbers of the arm's table.

    When SymPy solves for a length, it clears decimals: (a2 + 0.1)/2 becomes (10 a2 + 1)/20.
    """
    brackets = [factor for factor in sp.Mul.make_args(value) if factor.is_Add and factor.free_symbols]
    if len(brackets) != 1 or value.is_Add:
        return value
    (bracket,) = brackets
    terms = [term.as_coeff_Mul() for term in bracket.args]
    coefficients_of_symbols = [coefficient for coefficient, remainder in terms if remainder != 1]
    has_constant = len(coefficients_of_symbols) < len(terms)
    if not has_constant or not all(coefficient.is_Integer for coefficient, _ in terms):
        return value
    common_factor = sp.Integer(math.gcd(*map(int, coefficients_of_symbols)))
    if any(write_decimal(coefficient / common_factor) is None for coefficient, _ in terms):
        return value
    new_bracket = sp.Add(*(coefficient / common_factor * remainder for coefficient, remainder in terms))
    return value / bracket * common_factor * new_bracket


def tex_angle(value: sp.Expr) -> str:
    r"""Return the LaTeX of an angle, with its constant in degrees; in radians if a number of radians is added.

    >>> tex_angle(sp.Symbol("theta2") + sp.pi / 2), tex_angle(sp.pi - sp.atan(4))
    ('\\theta_{2} + 90^\\circ', '180^\\circ - \\arctan(4)')
    >>> tex_angle(sp.Symbol("theta2") - sp.Rational(7, 10) + sp.pi)
    '\\theta_{2} - 0.7 + \\pi\\,\\text{rad}'
    """
    return _write_angle_in_degrees(sp.sympify(value))


@lru_cache(maxsize=1024)
def _write_angle_in_degrees(value: sp.Expr) -> str:
    return _tex_with_unit(value, "rad") if has_radians(value) else print_latex(make_row(*_lay_out_angle(value)))


_lay_out_angle = _ExpressionLayout(()).lay_out_angle


def has_radians(angle: sp.Expr) -> bool:
    """Return whether a number of radians is a term of an angle, such as 0.7; multiples of pi are shown in degrees."""
    return any(term.is_Rational and term != 0 for term in sp.Add.make_args(sp.expand(angle)))


def tex_value(value: sp.Expr, joint: sp.Symbol) -> str:
    """Return the exact LaTeX of a joint's value: an angle in degrees, or a length with its unit."""
    return tex_length(value) if joint.name.startswith("d") else tex_angle(value)


_MAX_SHORT_NUMBER, _MAX_SHORT_OPERATIONS = 10**4, 10
"""Maximum numerator and denominator of the numbers, and maximum number of operations, in a value shown exactly."""


def tex_result(value: sp.Expr, joint: sp.Symbol) -> str:
    r"""Return the LaTeX of a derived joint value, followed by its value in degrees unless it is already in degrees.

    A number without a short exact form is rounded to four significant digits.

    >>> theta3 = sp.Symbol("theta3")
    >>> tex_result(sp.pi / 2, theta3), tex_result(sp.atan(sp.Rational(31, 6)) - sp.pi, theta3)
    ('90^\\circ', '\\arctan(\\tfrac{31}{6}) - 180^\\circ \\approx -101^\\circ')
    >>> tex_result(sp.atan(sp.Rational(1499950, 55059)) - sp.pi, theta3)
    '-1.607\\,\\text{rad} \\approx -92.1^\\circ'
    """
    exact_value = sp.sympify(value)
    if not exact_value.is_number:
        return tex_value(exact_value, joint)
    is_long = sp.count_ops(exact_value) > _MAX_SHORT_OPERATIONS or any(
        max(abs(rational.p), rational.q) > _MAX_SHORT_NUMBER for rational in exact_value.atoms(sp.Rational)
    )
    shown_value = sp.Rational(f"{float(exact_value):.4g}") if is_long else exact_value
    if joint.name.startswith("d"):
        return tex_length(shown_value)
    if (shown_value / sp.pi).is_Rational:
        return tex_angle(shown_value)
    return rf"{tex_angle(shown_value)} \approx {tex_degrees(exact_value)}"


def tex_degrees(angle: sp.Expr) -> str:
    r"""Return the LaTeX of a number of radians in degrees, to four significant digits.

    >>> tex_degrees(sp.Rational("1.134464045"))
    '65^\\circ'
    """
    return tex_angle(sp.Rational(f"{math.degrees(float(angle)):.4g}") * sp.pi / 180)


def _tex_with_unit(value: sp.Expr, unit: str) -> str:
    unit_pieces = (layout.THIN, Layout("text", unit)) if unit else ()
    return print_latex(make_row(*lay_out(value).inner, *unit_pieces))
