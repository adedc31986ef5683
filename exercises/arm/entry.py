"""Read one entry of a DH table: a number, or a formula in quotes, as an exact SymPy expression.

Formulas follow the grammar of answers, with three stricter rules:

* A unit is not a symbol.
* A product is written with `*`. Only a number may precede a factor without it, as in 2a1 and 2pi/3.
* A symbol is one letter for a length, or alpha or beta for an angle, with an optional number, as in a1, h and alpha2.

Other names are errors, and the error messages say what to write.
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
"""A length above this (m) is probably meant in millimetres."""

_MAX_CHARACTERS, _MAX_EXPONENT, _MAX_BASE = 200, 20, 10**6
"""Maximum number of characters of a formula, maximum exponent, and maximum numeric base of a power."""
_MIN_MAGNITUDE, _MAX_MAGNITUDE = sp.Rational(1, 10**9), 10**6
"""Minimum and maximum absolute value of a nonzero number."""
_OPERATIONS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}
_FUNCTIONS = {name: getattr(sp, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt")}

_ANGLE_NAMES = ("alpha", "beta")
"""Names of constant angles, with or without a number; all other symbols are lengths."""

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_TOKEN = re.compile(rf"(?P<number>{_NUMBER})|(?P<name>[^\W\d]\w*)|(?P<other>\S)")

_DEGREE = sp.pi / 180
_ANGLE_UNITS = {
    **dict.fromkeys(("rad", "radian", "radians"), sp.S.One),
    **dict.fromkeys(("°", "deg", "degree", "degrees"), _DEGREE),
}
_LENGTH_UNITS = {"m": sp.S.One, "cm": sp.Rational(1, 100), "mm": sp.Rational(1, 1000)}
"""The units of angles and of lengths, with their values in radians or metres.

Units are recognised only to be refused, because entries are in radians and metres.
"""
_UNIT_HINT = {True: 'angles are in radians, as in "pi/2"', False: 'lengths are in metres, as in 0.4 or "a1"'}
"""Hints that are appended to error messages about angles (key True) and about lengths (key False)."""


def parse_entry(raw: object, is_angle: bool, in_degrees: bool = False) -> sp.Expr:
    """Parse a table entry into an exact SymPy expression, in which decimals become fractions. Raises QdotError.

    If `in_degrees` is true, the numeric part of an angle is converted to radians.
    """
    if in_degrees and is_angle:
        return _parse_degrees(raw)
    if isinstance(raw, bool) or not isinstance(raw, (int, Decimal, str)):
        raise QdotError(f"expected a number, or an expression in quotes; {_UNIT_HINT[is_angle]}")
    if isinstance(raw, str):
        value = _parse_formula(raw, is_angle)
    elif isinstance(raw, Decimal) and not raw.is_finite():
        raise QdotError("expected a finite number")
    else:
        fraction = Fraction(raw)
        value = sp.Rational(fraction.numerator, fraction.denominator)
    constant = _sum_constant_terms(value)
    if constant.is_Rational and constant != 0 and not _MIN_MAGNITUDE <= abs(constant) <= _MAX_MAGNITUDE:
        limits = "its absolute value must be from 1e-9 to 1e6"
        raise QdotError(f"it is out of range: {limits}; {_UNIT_HINT[is_angle]}")
    if is_angle:
        _check_angle(value)
    return value


def _parse_degrees(raw: object) -> sp.Expr:
    """Parse an angle in degrees; return it in radians."""
    try:
        value = parse_entry(raw, False)
    except QdotError:
        raise QdotError('expected a number of degrees, or an expression in quotes, as in 90 or "theta1 + 90"') from None
    constant = _sum_constant_terms(value)
    if constant.has(sp.pi):
        raise QdotError('pi is not allowed, because this file has angles = "degrees"; write, for example, 90 for pi/2')
    return value - constant + constant * _DEGREE


def _parse_formula(text: str, is_angle: bool) -> sp.Expr:
    """Parse a formula in quotes. Raises QdotError with a correction."""
    if len(text) > _MAX_CHARACTERS:
        raise QdotError(f"it has {len(text)} characters; at most {_MAX_CHARACTERS} are allowed")
    _check_units(text, is_angle)
    _check_products(text)
    if re.fullmatch(r"\s*[-+]?\d*,\d+\s*", text):
        raise QdotError(f"decimals need a point; write {text.strip().replace(',', '.')}")
    abbreviation = re.search(r"\b[csCS]_?\d{1,4}\b", text)
    if abbreviation:
        meaning = "is an abbreviation for a sine or cosine in answers"
        raise QdotError(f"{abbreviation.group()} {meaning}; choose another name, such as a1 or h")
    try:
        return to_sympy(parse_formula(text))
    except ParseError as error:
        raise QdotError(str(error) if "as in" in str(error) else f"{error}; {_UNIT_HINT[is_angle]}") from None


def _check_units(text: str, is_angle: bool) -> None:
    """Refuse a unit; if the entry is a number with its unit, say what to write in its place."""
    tokens = [token if len(token) == 1 else token.lower() for token in (m.group() for m in _TOKEN.finditer(text))]
    unit = next((token for token in tokens if token in _ANGLE_UNITS or token in _LENGTH_UNITS), None)
    if unit is None:
        return
    units = _ANGLE_UNITS if is_angle else _LENGTH_UNITS
    if unit not in units:
        quantity = "an angle" if unit in _ANGLE_UNITS else "a length"
        raise QdotError(f"{unit} is a unit of {quantity}; {_UNIT_HINT[is_angle]}")
    rule = "angles are in radians" if is_angle else "lengths are in metres"
    number = re.fullmatch(rf"([-+]?{_NUMBER})\s*\*?\s*{unit}", text.strip(), re.IGNORECASE)
    if number is None:
        example = '"pi/2" for 90 degrees' if is_angle else "0.4 for 400 mm"
        raise QdotError(f"{rule}, without a unit; write {example}")
    value = sp.Rational(number[1]) * units[unit]
    if value.has(sp.pi):
        raise QdotError(f'{rule}; write "{value}"')
    if is_angle:
        _check_angle(value)  # 1.5708 rad is pi/2
    raise QdotError(f"{rule}; write {float(value):.12g}")


# --- angles and lengths ---


def _check_angle(value: sp.Expr) -> None:
    """Raise QdotError if an angle is a rounded multiple of pi/12 or seems to be in degrees."""
    constant = _sum_constant_terms(value)
    if not constant.is_Rational or constant == 0:
        return
    twelfths = float(constant) / (float(sp.pi) / 12)
    nearest = round(twelfths)
    if nearest and abs(twelfths - nearest) < 0.005:
        raise QdotError(f'{float(constant):g} looks like a rounded angle; write it exactly, "{sp.pi * nearest / 12}"')
    if abs(constant) > 7:
        in_radians = f'angles are in radians; {float(constant):g} degrees would be "{sp.pi * constant / 180}"'
        raise QdotError(f'{in_radians}; if all angles are in degrees, add angles = "degrees"')


def _sum_constant_terms(value: sp.Expr) -> sp.Expr:
    """Return the sum of the numeric terms of an expression."""
    return sp.Add(*(term for term in sp.Add.make_args(sp.expand(value)) if term.is_number))


def find_unit_warning(value: sp.Expr) -> str | None:
    """Return a warning if a length is so large that it is probably in millimetres, else None."""
    constant = _sum_constant_terms(value)
    if not constant.is_Rational or abs(constant) <= SUSPICIOUS_LENGTH:
        return None
    length = float(constant)
    return f"lengths are in metres; is this in millimetres? {length:g} mm would be {length / 1000:g}"


def check_quantity(value: sp.Expr, is_angle: bool) -> None:
    """Refuse a length if an angle is expected, and the reverse. This catches swapped columns."""
    value_without_functions = value.xreplace(
        dict.fromkeys(value.atoms(sp.Function), sp.S.One)
    )  # atan2(a1, d1) is an angle
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


# --- products and names ---


def _check_products(text: str) -> None:
    """Refuse a product without `*`, such as "a1 b2", which is ambiguous; a number may precede a symbol or bracket."""
    corrected_text = text
    for first, second in reversed([*itertools.pairwise(_TOKEN.finditer(text))]):
        if _lacks_product_sign(first, second):
            corrected_text = f"{corrected_text[: first.end()]}*{corrected_text[second.start() :]}"
    if corrected_text != text:
        raise QdotError(f'a product needs *; did you mean "{corrected_text}"?')


def _lacks_product_sign(first: re.Match[str], second: re.Match[str]) -> bool:
    """Return whether two successive tokens are factors of an ambiguous product."""
    if first.lastgroup == "number":
        return second.lastgroup == "number"
    is_symbol = first.lastgroup == "name" and first.group().lower() not in FUNCTIONS
    starts_factor = second.lastgroup in ("number", "name") or (second.group() == "(" and not is_symbol)
    return starts_factor and (is_symbol or first.group() == ")")


def to_sympy(node: Node) -> sp.Expr:
    """Convert a parsed formula to a SymPy expression. Raises ParseError for anything but arithmetic and _FUNCTIONS."""
    if node.kind in ("number", "decimal"):
        return sp.Rational(node.value.numerator, node.value.denominator)
    if node.kind == "name":
        return _make_symbol(str(node.value))
    if node.kind == "call" and node.value in _FUNCTIONS:
        return _require_finite(_FUNCTIONS[node.value](*(to_sympy(arg) for arg in node.args)), f"{node.value}(…)")
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
    if name == "pi":
        return sp.pi
    if re.fullmatch(r"qd\d*|[vwfm][xyz]|blank", name):
        raise ParseError(f"the name {name!r} is reserved: qd1 … are joint rates, vx … wz velocities")
    if name in ("k", "n"):
        raise ParseError(f"the name {name} is reserved for whole numbers in answers; write {name}1")
    letters = name.rstrip("0123456789")
    if not (re.fullmatch(r"[A-Za-z]", letters) or letters in (*_ANGLE_NAMES, "theta")) or name in ("E", "I"):
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
    """Return a value unchanged. Raises ParseError if it is infinite, undefined or complex."""
    if value.has(sp.zoo, sp.oo, sp.nan) or value.is_real is False:
        raise ParseError(f"{subject} is not a real number")
    return value
