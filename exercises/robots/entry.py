"""Parse one entry of a DH table in a robot file, a number or a formula in quotes, into an exact SymPy expression.

A formula follows the grammar of students' answers, with three stricter rules:

* Units are not allowed.
* A product is written with `*`. The `*` may be omitted only after a number, as in 2a1 and 2pi/3.
* A symbol is one letter for a length, or alpha or beta for an angle, with an optional number, as in a1, h and alpha2.
"""

import itertools
import operator
import re
from decimal import Decimal
from fractions import Fraction

import sympy as sp

from qdot.exercises.common.errors import QdotError
from qdot.exercises.formula.names import FUNCTIONS
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import Node, ParseError

SUSPICIOUS_LENGTH = 20
"""A length above this limit (m) is probably meant in millimetres."""

_MAX_CHARACTERS, _MAX_EXPONENT, _MAX_BASE = 200, 20, 10**6
"""Maximum number of characters of a formula, maximum exponent, and maximum numeric base of a power."""
_MIN_MAGNITUDE, _MAX_MAGNITUDE = sp.Rational(1, 10**9), 10**6
"""Minimum and maximum absolute value of a nonzero number."""
_OPERATIONS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}
_SYMPY_FUNCTIONS = {name: getattr(sp, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt")}

_RESERVED_NAME = re.compile(r"qd\d*|[vwfm][xyz]|blank")
"""Names with a meaning in answers: rates, velocities, forces, moments, and `blank` for an entry that is left open."""
_ANGLE_NAMES = ("alpha", "beta")
"""Names of constant angles, with or without a number; other symbols are lengths."""

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TOKEN = re.compile(rf"(?P<number>{_NUMBER})|(?P<name>[^\W\d]\w*)|(?P<other>\S)")

_UNITS = frozenset({"rad", "radian", "radians", "°", "deg", "degree", "degrees", "m", "cm", "mm"})
"""Units, which are refused, because entries are always in radians and metres."""


def _get_unit_hint(is_angle: bool) -> str:
    """Return the hint that is appended to messages about an angle or a length."""
    return 'angles are in radians, as in "pi/2"' if is_angle else 'lengths are in metres, as in 0.4 or "a1"'


def parse_entry(raw: object, is_angle: bool, is_in_degrees: bool = False) -> sp.Expr:
    """Parse a table entry (rad or m) into an exact SymPy expression, in which decimals become fractions.

    If `is_in_degrees` is true, the numeric terms of an angle are in degrees; they are converted to radians. Raises
    QdotError.
    """
    if is_in_degrees and is_angle:
        return _parse_degrees(raw)
    if isinstance(raw, bool) or not isinstance(raw, (int, Decimal, str)):
        raise QdotError(f"expected a number, or an expression in quotes; {_get_unit_hint(is_angle)}")
    if isinstance(raw, str):
        value = _parse_quoted_formula(raw, is_angle)
    elif isinstance(raw, Decimal) and not raw.is_finite():
        raise QdotError("expected a finite number")
    else:
        fraction = Fraction(raw)
        value = sp.Rational(fraction.numerator, fraction.denominator)
    constant = _sum_constant_terms(value)
    if constant.is_Rational and constant != 0 and not _MIN_MAGNITUDE <= abs(constant) <= _MAX_MAGNITUDE:
        limits = "its absolute value must be from 1e-9 to 1e6"
        raise QdotError(f"the number is out of range: {limits}; {_get_unit_hint(is_angle)}")
    if is_angle:
        _check_angle(value)
    return value


def _parse_degrees(raw: object) -> sp.Expr:
    """Parse an angle in degrees, and return the angle in radians. Raises QdotError."""
    try:
        value = parse_entry(raw, is_angle=False)  # as an angle in radians, 90 would be refused
    except QdotError:
        raise QdotError('expected a number of degrees, or an expression in quotes, as in 90 or "theta1 + 90"') from None
    constant = _sum_constant_terms(value)
    if constant.has(sp.pi):
        raise QdotError('pi is not allowed, because this file has angles = "degrees"; write, for example, 90 for pi/2')
    return value - constant + constant * sp.pi / 180


def _parse_quoted_formula(text: str, is_angle: bool) -> sp.Expr:
    """Parse a formula in quotes. Raises QdotError, whose message says what to write instead."""
    if len(text) > _MAX_CHARACTERS:
        raise QdotError(f"the formula has {len(text)} characters; at most {_MAX_CHARACTERS} are allowed")
    tokens = list(_TOKEN.finditer(text))
    for word in (token.group() for token in tokens):
        if (word if word == "M" else word.lower()) in _UNITS:  # M is a length; m is the metre
            raise QdotError(f"{word} is a unit; write the entry without a unit: {_get_unit_hint(is_angle)}")
    for token, next_token in itertools.pairwise(tokens):
        if _lacks_product_sign(token, next_token):
            correction = f"{text[: token.end()]}*{text[next_token.start() :]}"
            raise QdotError(f'a product needs *; did you mean "{correction}"?')
    if re.fullmatch(r"\s*[-+]?\d*,\d+\s*", text):
        raise QdotError(f"decimals need a point; write {text.strip().replace(',', '.')}")
    abbreviation = re.search(r"\b[csCS]_?\d{1,4}\b", text)
    if abbreviation:
        meaning = "is an abbreviation for a sine or cosine in answers"
        raise QdotError(f"{abbreviation.group()} {meaning}; choose another name, such as a1 or h")
    try:
        return to_sympy(parse_formula(text))
    except ParseError as error:
        has_example = "as in" in str(error)  # an example is a hint, so no other hint is needed
        raise QdotError(str(error) if has_example else f"{error}; {_get_unit_hint(is_angle)}") from None


def _lacks_product_sign(token: re.Match[str], next_token: re.Match[str]) -> bool:
    """Return whether two successive tokens are factors of a product without *, such as a1 b2, (a1)b2 and (a1)(b2).

    A number may stand before a symbol or a bracket, as in 2a1. a1(b2) is left to the parser of formulas.
    """
    is_number_or_name = next_token.lastgroup in ("number", "name")
    if token.lastgroup == "number":
        return next_token.lastgroup == "number"
    if token.lastgroup == "name":
        return is_number_or_name and token.group().lower() not in FUNCTIONS
    return token.group() == ")" and (is_number_or_name or next_token.group() == "(")


# --- angles and lengths ---


def _check_angle(value: sp.Expr) -> None:
    """Raise QdotError if the numeric part of an angle is a rounded multiple of pi/12 or seems to be in degrees."""
    constant = _sum_constant_terms(value)
    if not constant.is_Rational or constant == 0:
        return
    twelfths = float(constant) / (float(sp.pi) / 12)
    nearest_integer = round(twelfths)
    if nearest_integer and abs(twelfths - nearest_integer) < 0.005:  # about 0.0013 rad, as in 1.57
        exact_angle = sp.pi * nearest_integer / 12
        raise QdotError(f'{float(constant):g} looks like a rounded angle; write the exact angle, "{exact_angle}"')
    if abs(constant) > 7:  # more than a full turn, 2 pi
        radians_hint = f'angles are in radians; {float(constant):g} degrees would be "{sp.pi * constant / 180}"'
        raise QdotError(f'{radians_hint}; if all angles are in degrees, add angles = "degrees"')


def _sum_constant_terms(value: sp.Expr) -> sp.Expr:
    """Return the sum of the numeric terms of an expression."""
    return sp.Add(*(term for term in sp.Add.make_args(sp.expand(value)) if term.is_number))


def find_unit_warning(value: sp.Expr) -> str | None:
    """Return a warning if a length is so large that it is probably meant in millimetres, else None."""
    constant = _sum_constant_terms(value)
    if not constant.is_Rational or abs(constant) <= SUSPICIOUS_LENGTH:
        return None
    length = float(constant)
    return f"lengths are in metres; is this in millimetres? {length:g} mm would be {length / 1000:g}"


def check_quantity(value: sp.Expr, is_angle: bool) -> None:
    """Raise QdotError if a length stands where an angle is expected, or the reverse, as in swapped columns."""
    # the arguments of functions may be of another quantity: atan2(a1, d1) is an angle
    value_without_functions = value.xreplace(dict.fromkeys(value.atoms(sp.Function), sp.S.One))
    for symbol in sorted(value_without_functions.free_symbols, key=str):
        letters = symbol.name.rstrip("0123456789")
        if letters == "theta":
            hint = "call a constant angle alpha or beta, as in beta1"
            raise QdotError(f"{symbol} is the name of a joint variable; {hint}")
        if is_angle and letters not in _ANGLE_NAMES:
            raise QdotError(f"{symbol} is a name for a length; call an angle alpha or beta, as in alpha1")
        if not is_angle and letters in _ANGLE_NAMES:
            raise QdotError(f"{symbol} is a name for an angle; call a length a1, d1 or h, for example")
    if not is_angle and value_without_functions.has(sp.pi):
        raise QdotError("pi is allowed in angles only; lengths are in metres")


# --- conversion to SymPy ---


def to_sympy(node: Node) -> sp.Expr:
    """Convert the tree of a formula to a SymPy expression.

    Raises ParseError if the formula contains anything but numbers, names, + - * / ^ and the _SYMPY_FUNCTIONS.
    """
    if node.kind in ("number", "decimal"):
        return sp.Rational(node.value.numerator, node.value.denominator)
    if node.kind == "name":
        return _make_symbol(str(node.value))
    if node.kind == "call" and node.value in _SYMPY_FUNCTIONS:
        value = _SYMPY_FUNCTIONS[node.value](*map(to_sympy, node.args))
        return _require_finite(value, f"{node.value}(…)")
    if node.kind == "neg":
        return -to_sympy(node.args[0])
    if node.kind == "^":
        return _compute_power(*(to_sympy(arg) for arg in node.args))
    if node.kind in ("+", "-", "*", "/"):
        first_operand, second_operand = (to_sympy(arg) for arg in node.args)
        if node.kind == "/" and second_operand == 0:
            raise ParseError("the formula divides by zero")
        return _OPERATIONS[node.kind](first_operand, second_operand)
    subject = f"the function {node.value!r}" if node.kind == "call" else f"a {node.kind}"
    raise ParseError(f"{subject} is not allowed in a DH table")


def _make_symbol(name: str) -> sp.Expr:
    """Return the symbol with a name, or pi. Raises ParseError if the name is not allowed."""
    if name == "pi":
        return sp.pi
    if _RESERVED_NAME.fullmatch(name):
        raise ParseError(f"the name {name!r} is reserved: qd1 … are joint rates, vx … wz velocities")
    if name in ("k", "n"):
        raise ParseError(f"the name {name} is reserved for whole numbers in answers; write {name}1")
    letters = name.rstrip("0123456789")
    is_constant = name in ("E", "I")  # Euler's number and the imaginary unit
    if is_constant or not (re.fullmatch(r"[A-Za-z]", letters) or letters in (*_ANGLE_NAMES, "theta")):
        hint = "use one letter, or alpha or beta, optionally with a number, as in a1, h or alpha2"
        raise ParseError(f"{name!r} is not a name for a length or angle; {hint}")
    return sp.Symbol(name)


def _compute_power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    """Return a power. Raises ParseError if its exponent or its numeric base is too large."""
    if not exponent.is_Rational or abs(exponent) > _MAX_EXPONENT:
        raise ParseError(f"an exponent must be a number of at most {_MAX_EXPONENT}")
    if base.is_number and abs(base) > _MAX_BASE:
        raise ParseError(f"the base of a power is too large; it must be at most {_MAX_BASE}")
    return _require_finite(base**exponent, "a power")


def _require_finite(value: sp.Expr, subject: str) -> sp.Expr:
    """Return a value unchanged. Raises ParseError if the value is infinite, undefined or complex."""
    if value.has(sp.zoo, sp.oo, sp.nan) or value.is_real is False:
        raise ParseError(f"{subject} is not a real number")
    return value
