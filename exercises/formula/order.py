r"""Put the terms of a sum and the factors of a product in the order in which a person writes them, with signs.

Joint angles come before constants. Terms such as a_1 + a_2 c_2 + a_3 c_{23} are sorted by their last joint. The factor
c_1 comes before the bracket that it multiplies, but \cos\varphi_1 after it. Rates and velocities come after their
coefficients and are sorted by index.
"""

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from qdot.exercises.formula.sympy_text import format_expression

SortKey = tuple[object, ...]
"""A key by which `sorted` compares names, terms or factors."""


class SignedTerm(NamedTuple):
    """A term of a sum as it is printed after its sign, and whether the sign is a minus."""

    is_negative: bool
    term: sp.Expr


NAMED_ANGLE_PATTERN = re.compile(r"\\varphi'*_\{(\d+)\}")
"""The name of a symbol for an angle; its index lists the joints whose angles it contains."""

COMPONENT_PATTERN = re.compile(r"[vwfm][xyz]")
"""The name of a component of a velocity v, an angular velocity w, a force f or a moment m."""
_RATE_PATTERN = re.compile(r"qd\d+")


@lru_cache(maxsize=4096)
def make_natural_sort_key(name: str) -> SortKey:
    """Return a key that sorts names by their letters, then by their numbers: a2 before a10."""
    match = re.fullmatch(r"(.*?)(\d*)", name)
    assert match is not None
    return (match.group(1), int(match.group(2) or -1))


def _make_trig_key(trig: sp.Expr) -> SortKey:
    """Return a key that sorts sines and cosines by their last joint, then by their number of joints, cosines first."""
    joints = sorted(joint for symbol in trig.args[0].free_symbols for joint in find_joints(symbol))
    return (max(joints, default=0), -len(joints), joints, isinstance(trig, sp.sin), format_expression(trig))


def find_joints(symbol: sp.Symbol) -> list[int]:
    """Return the number of a symbol's joint, or the numbers of all joints whose angles a named angle contains."""
    match = NAMED_ANGLE_PATTERN.fullmatch(symbol.name)
    return [int(digit) for digit in match.group(1)] if match else [find_number_in_name(symbol)]


@lru_cache(maxsize=4096)
def _make_term_key(term: sp.Expr) -> SortKey:
    """Return a key that sorts terms by rate or velocity, then by their sines and cosines, then by their symbols."""
    motion_keys = sorted(map(_make_motion_key, filter(is_rate_or_component, term.free_symbols)))
    trig_keys = sorted(_make_trig_key(trig)[:4] for trig in term.atoms(sp.sin, sp.cos))  # without their texts
    names = sorted(make_natural_sort_key(symbol.name) for symbol in term.free_symbols)
    is_without_angle = not any(letters == "theta" for letters, _ in names)  # False sorts before True
    return (motion_keys, trig_keys, is_without_angle, term.is_number, names, format_expression(term))


@lru_cache(maxsize=4096)
def is_rate_or_component(symbol: sp.Symbol) -> bool:
    """Return whether a symbol is a joint rate, or a component of a velocity or force."""
    return bool(_RATE_PATTERN.fullmatch(symbol.name) or COMPONENT_PATTERN.fullmatch(symbol.name))


def _make_motion_key(symbol: sp.Symbol) -> SortKey:
    """Return a key that sorts joint rates by joint, before components of velocities and forces."""
    if not COMPONENT_PATTERN.fullmatch(symbol.name):
        return (0, find_number_in_name(symbol))
    return (1, "vwfm".index(symbol.name[0]), symbol.name[1])


def _make_factor_key(factor: sp.Expr) -> SortKey:
    r"""Return a key that sorts factors.

    The order is: number, lengths, sums of lengths, c_1 and s_1, brackets, \cos\varphi_1, rates and velocities.
    """
    base = factor.base if factor.is_Pow else factor
    if base.is_number:
        return (0, format_expression(factor))
    if base.is_Symbol:
        return (6, _make_motion_key(base)) if is_rate_or_component(base) else (1, make_natural_sort_key(base.name))
    if isinstance(base, (sp.sin, sp.cos)):
        return (3 if find_joint_sum_digits(base.args[0]) is not None else 5, _make_trig_key(base))
    if base.is_Add and all(map(is_rate_or_component, base.free_symbols)):
        return (6, (2, format_expression(base)))  # like a rate, after all other factors
    is_length = base.is_Add and all(symbol.name[0] in "aL" for symbol in base.free_symbols)
    return (2 if is_length else 4, base.is_Add, format_expression(factor))


@lru_cache(maxsize=4096)
def _contains_trig_or_motion(term: sp.Expr) -> bool:
    """Return whether a term contains sines, cosines, rates or velocities."""
    return any(map(is_rate_or_component, term.free_symbols)) or bool(term.atoms(sp.sin, sp.cos))


@dataclass(frozen=True)
class Product:
    """A product: whether it is negative, its absolute numeric factor, and the factors in its numerator and denominator.

    The sums in `flipped_sums` are printed with the opposite signs. Then no bracket starts with a minus, and a sum has
    the same signs in all entries of a matrix. Only a sum of velocities may start with a minus, as in (-s_1 v_x +
    c_1 v_y)/a_1.
    """

    is_negative: bool
    number: sp.Expr
    numerator: tuple[sp.Expr, ...]
    denominator: tuple[sp.Expr, ...]
    flipped_sums: frozenset[sp.Expr]


@lru_cache(maxsize=4096)
def order_product(expression: sp.Expr) -> Product:
    """Return an expression other than a sum as a product with its factors in order."""
    number, remainder = expression.as_coeff_Mul()
    is_negative = bool(number.is_negative)
    numerator, denominator = list[sp.Expr](), list[sp.Expr]()
    for factor in sorted(sp.Mul.make_args(remainder), key=_make_factor_key):
        if factor.is_Pow and factor.exp.could_extract_minus_sign():
            denominator.append(1 / factor)
        elif factor != 1:
            numerator.append(factor)
    flipped_sums = set()
    for factor in denominator:
        if factor.is_Add and order_terms(factor)[0].is_negative:
            flipped_sums.add(factor)
            is_negative = not is_negative
    for factor in numerator:
        if factor.is_Add:
            has_minus = [term_is_negative for term_is_negative, _ in order_terms(factor)]
            if all(has_minus) or (is_negative if _may_start_with_minus(factor) else has_minus[0]):
                flipped_sums.add(factor)
                is_negative = not is_negative
    return Product(is_negative, abs(number), tuple(numerator), tuple(denominator), frozenset(flipped_sums))


def _may_start_with_minus(factor: sp.Expr) -> bool:
    """Return whether a factor is a sum of velocities with different signs, which may start with a minus."""
    has_both_signs = len({term.is_negative for term in order_terms(factor)}) > 1
    return has_both_signs and any(map(is_rate_or_component, factor.free_symbols))


@lru_cache(maxsize=4096)
def order_terms(expression: sp.Expr, flips_signs: bool = False) -> tuple[SignedTerm, ...]:
    """Return the terms of a sum in order; if `flips_signs`, all signs are changed."""
    sorted_terms = sorted(sp.Add.make_args(expression), key=_make_term_key)
    signed_terms = [_split_sign(term, flips_signs) for term in sorted_terms]
    if any(map(_contains_trig_or_motion, sorted_terms)):
        # 0.12 + a_2 c_2, but a_1 c_1 - 0.6: a constant comes first unless it is subtracted
        signed_terms.sort(key=lambda signed: 1 if _contains_trig_or_motion(signed.term) else 2 * signed.is_negative)
        return tuple(_move_plus_first(signed_terms))
    # theta_1 - theta_2 + theta_3 + 0.1, but d_2 - d_1: numbers come last, and the first term has no minus
    is_first_negative = signed_terms[0].is_negative
    signed_terms.sort(key=lambda signed: (signed.term.is_number, is_first_negative and signed.is_negative))
    if signed_terms[0].is_negative and not signed_terms[-1].is_negative:  # 0.2 - a_1
        signed_terms = [signed_terms[-1], *signed_terms[:-1]]
    return tuple(signed_terms)


def _split_sign(term: sp.Expr, flips_signs: bool) -> SignedTerm:
    """Return a term with its sign or, if `flips_signs`, with the opposite sign."""
    if flips_signs and not (opposite := -term).is_Add:
        return SignedTerm(order_product(opposite).is_negative, opposite)
    return SignedTerm(order_product(term).is_negative != flips_signs, term)


def _move_plus_first(signed_terms: list[SignedTerm]) -> list[SignedTerm]:
    """Return the terms with a positive term first, if the first term is negative and the order may be changed.

    The order may be changed in a sum of rates. The first two terms may also be swapped if they have the same angle.
    """
    symbols = {str(symbol) for _, term in signed_terms for symbol in term.free_symbols}
    if signed_terms[0].is_negative and all(map(_RATE_PATTERN.fullmatch, symbols)):
        return sorted(signed_terms, key=lambda signed: signed.is_negative)  # qd2 - qd1
    has_minus = [is_negative for is_negative, _ in signed_terms[:2]]
    if has_minus == [True, False] and not any(map(is_rate_or_component, signed_terms[0].term.free_symbols)):
        angles = [{trig.args for trig in term.atoms(sp.sin, sp.cos)} for _, term in signed_terms[:2]]
        if angles[0] == angles[1]:  # 0.06 s_2 - 0.35 c_2
            return [signed_terms[1], signed_terms[0], *signed_terms[2:]]
    return signed_terms


def write_decimal(value: sp.Expr) -> str | None:
    """Return the digits of a terminating decimal, as in "0.35", or None for any other number."""
    if not value.is_Rational or 10 ** int(value.q).bit_length() % int(value.q):
        return None
    return str(value) if value.is_Integer else f"{float(value):.12f}".rstrip("0").rstrip(".")


@lru_cache(maxsize=4096)
def find_joint_sum_digits(angle: sp.Expr) -> str | None:
    """Return "12" for theta1 + theta2, and None for an angle without such a shorthand (as in c12)."""
    digits = []
    for term in sp.Add.make_args(angle):
        match = re.fullmatch(r"theta(\d)", str(term))
        if match is None:
            return None
        digits.append(match.group(1))
    return "".join(sorted(digits))


def find_number_in_name(symbol: sp.Symbol) -> int:
    """Return the number in a symbol's name, or 0."""
    digits = re.sub(r"\D", "", symbol.name)
    return int(digits) if digits else 0
