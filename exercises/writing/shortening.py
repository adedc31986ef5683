r"""Shorten sums of sines and cosines: combine two terms into one, and factor out common factors.

For example, if a table adds 30 degrees to \theta and \varphi is the sum, then \sqrt{3}/4 \cos\varphi + 1/4 \sin\varphi
becomes 1/2 \cos\theta. The sine and cosine of the joint that rotates the whole arm are factored out, as in
x = (0.2 + a_2 c_2) c_1 + d_2 s_1. No value changes, and short expressions stay unchanged.
"""

from collections.abc import Callable, Iterator
from collections.abc import Set as AbstractSet
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import sympy as sp

from qdot.exercises.formula.order import find_joint_sum_digits, find_joints, is_rate_or_component

HasNotation = Callable[[sp.Expr], bool]
"""A function that returns whether there is a short notation for the sine and cosine of an angle (see `angles`)."""


@lru_cache(maxsize=4096)
def remove_constant_shifts(expression: sp.Expr) -> sp.Expr:
    """Return an expression in which A cos + B sin of an angle plus a constant becomes a sine or cosine of the angle.

    >>> t2, a1 = sp.symbols("theta2 a1")
    >>> remove_constant_shifts(sp.sqrt(3) * sp.cos(t2 + sp.pi / 6) / 4 + sp.sin(t2 + sp.pi / 6) / 4)
    cos(theta2)/2
    >>> remove_constant_shifts(a1 * sp.cos(t2 + sp.pi / 6) + sp.sin(t2 + sp.pi / 6))
    a1*cos(theta2 + pi/6) + sin(theta2 + pi/6)
    """
    if not any(_has_shift(trig.args[0]) for trig in expression.atoms(sp.sin, sp.cos)):
        return expression
    return _shorten_sums(expression, _join_shifted_terms)


def use_angle_sums(expression: sp.Expr, has_notation: HasNotation) -> sp.Expr:
    """Return an expression shortened by angle-sum identities if `has_notation` accepts the sum or difference.

    >>> t1, t2, a1 = sp.symbols("theta1 theta2 a1")
    >>> use_angle_sums(a1 * sp.sin(t1) * sp.cos(t2) + a1 * sp.cos(t1) * sp.sin(t2), lambda angle: True)
    a1*sin(theta1 + theta2)
    """
    if len(expression.atoms(sp.sin, sp.cos)) < 4:  # an identity needs the sines and cosines of two angles
        return expression
    return _shorten_sums(expression, lambda total: _combine_one_pair(total, has_notation))


def replace_squares(expression: sp.Expr) -> sp.Expr:
    """Return an expression in which sin^2 + cos^2 = 1 is applied if it combines two terms into one.

    >>> t2, a1 = sp.symbols("theta2 a1")
    >>> replace_squares(a1 - a1 * sp.sin(t2) ** 2), replace_squares(sp.sin(t2) ** 2 + sp.cos(t2) ** 2)
    (a1*cos(theta2)**2, 1)
    """
    if not any(isinstance(power.base, (sp.sin, sp.cos)) for power in expression.atoms(sp.Pow)):
        return expression
    return _shorten_sums(expression, _join_squares)


def _join_squares(total: sp.Expr) -> sp.Expr | None:
    """Return a sum with two of its terms combined by sin^2 + cos^2 = 1, or None if that is impossible."""
    terms = set(total.args)
    for term in total.args:
        for square in sp.Mul.make_args(term):
            base, power = square.as_base_exp()
            if power != 2 or not isinstance(base, (sp.sin, sp.cos)):
                continue
            remainder = term / square
            complement = (sp.cos if isinstance(base, sp.sin) else sp.sin)(base.args[0]) ** 2
            if -remainder in terms:
                return total - term + remainder - remainder * complement
            if remainder * complement in terms:
                return total - term - remainder * complement + remainder
    return None


def multiply_numbers(expression: sp.Expr) -> sp.Expr:
    """Return an expression with its numbers multiplied out if that makes them shorter.

    >>> root = sp.sqrt(3)
    >>> multiply_numbers(sp.Symbol("a1") - root * (sp.Rational(1, 20) - 9 * root / 40) / 2 + root / 40)
    a1 + 27/80
    """
    if not expression.args or expression.is_Function:
        return expression
    if expression.is_number:
        expanded_number = sp.expand(expression)
        return expanded_number if sp.count_ops(expanded_number) < sp.count_ops(expression) else expression
    if expression.is_Add:
        number = sp.Add(*(term for term in expression.args if term.is_number))
        other_terms = (multiply_numbers(term) for term in expression.args if not term.is_number)
        return sp.Add(multiply_numbers(number), *other_terms)
    args = tuple(map(multiply_numbers, expression.args))
    return expression if args == expression.args else expression.func(*args)


def _shorten_sums(expression: sp.Expr, shorten_once: Callable[[sp.Expr], sp.Expr | None]) -> sp.Expr:
    """Return an expression with `shorten_once` applied to each of its sums until it returns None."""
    if not expression.args or expression.is_Function:
        return expression
    args = tuple(_shorten_sums(arg, shorten_once) for arg in expression.args)
    new_expression = expression if args == expression.args else expression.func(*args)
    while new_expression.is_Add and (shorter_expression := shorten_once(new_expression)) is not None:
        new_expression = shorter_expression
    return new_expression


def _has_shift(angle: sp.Expr) -> bool:
    """Return whether an angle is a sum of joint variables plus a nonzero rational multiple of pi."""
    remainder, constant = split_constant(angle)
    return constant != 0 and (constant / sp.pi).is_Rational and is_joint_sum(remainder)


def is_joint_sum(angle: sp.Expr) -> bool:
    """Return whether an angle or its negative is a sum of joint variables, each with the coefficient 1."""
    return (find_joint_sum_digits(angle) or find_joint_sum_digits(-angle)) is not None


class AngleParts(NamedTuple):
    """The part of an angle that contains symbols, and the constant that is added to it."""

    variable: sp.Expr
    constant: sp.Expr


def split_constant(angle: sp.Expr) -> AngleParts:
    """Return the variable part and the constant part of an angle."""
    constant, variable = angle.as_independent(sp.Symbol, as_Add=True)
    return AngleParts(variable, constant)


def _split_number(term: sp.Expr) -> tuple[sp.Expr, list[sp.Expr]]:
    """Return the numeric coefficient of a term, including roots of numbers, and the other factors."""
    number, remainder = term.as_independent(sp.Symbol, as_Add=False)
    return number, list(sp.Mul.make_args(remainder))


def _join_shifted_terms(total: sp.Expr) -> sp.Expr | None:
    """Return a sum with fewer terms, by expanding sines and cosines of an angle plus a constant; None if impossible."""
    trigs = total.atoms(sp.sin, sp.cos)
    variable_parts = {trig: split_constant(trig.args[0]).variable for trig in trigs}
    shifted_angles = {angle for trig, angle in variable_parts.items() if _has_shift(trig.args[0])}
    for angle in sorted(shifted_angles, key=sp.default_sort_key):
        trigs_of_angle = {trig for trig in trigs if variable_parts[trig] == angle}
        if not _may_join_terms(total, trigs_of_angle):
            continue
        expanded_trigs = {trig: _expand_shift(trig) for trig in trigs_of_angle}
        new_total = sp.expand(total.xreplace(expanded_trigs))
        if len(sp.Add.make_args(new_total)) < len(total.args):
            return new_total
    return None


def _may_join_terms(total: sp.Expr, trigs: AbstractSet[sp.Expr]) -> bool:
    """Return whether two terms may become equal by expanding `trigs` (sines and cosines), apart from their numbers."""
    remainders = set()
    for term in total.args:
        _, factors = _split_number(term)
        other_factors = [factor for factor in factors if factor not in trigs]
        if any(factor.is_Add or (factor.is_Pow and factor.args[0].args) for factor in other_factors):
            return True  # only expansion shows the factors of such a term
        remainder = sp.Mul(*other_factors)
        if len(other_factors) < len(factors) and remainder in remainders:
            return True
        if len(other_factors) < len(factors):
            remainders.add(remainder)
    return False


def _expand_shift(trig: sp.Expr) -> sp.Expr:
    """Return the sine or cosine of an angle plus a constant, expanded into sines and cosines of the angle alone."""
    angle, constant = split_constant(trig.args[0])
    symbol = sp.Symbol("_angle")
    return sp.expand_trig(trig.func(symbol + constant)).xreplace({symbol: angle})


def _combine_one_pair(total: sp.Expr, has_notation: HasNotation) -> sp.Expr | None:
    """Return a sum with two of its terms combined by an angle-sum identity, or None if none applies."""
    for terms, factor, trig in _iterate_pairs_of_terms(total):
        if has_notation(trig.args[0]):
            return total - sp.Add(*terms) + factor * trig
    return None


class _ProductOfTrigs(NamedTuple):
    """A term with a product of two sines or cosines: its number, and the function (sin or cos) of each angle."""

    term: sp.Expr
    number: sp.Expr
    functions: dict[sp.Expr, type]


def _iterate_pairs_of_terms(total: sp.Expr) -> Iterator[tuple[tuple[sp.Expr, sp.Expr], sp.Expr, sp.Expr]]:
    """Yield pairs of terms that an angle-sum identity combines, with a factor and the new sine or cosine."""
    products_by_angles_and_factors: dict[tuple[frozenset[sp.Expr], sp.Expr], list[_ProductOfTrigs]] = {}
    for term in total.args:
        number, factors = _split_number(term)
        trigs = [factor for factor in factors if isinstance(factor, (sp.sin, sp.cos)) and factor.free_symbols]
        for first_trig, second_trig in combinations(trigs, 2):
            functions = {first_trig.args[0]: first_trig.func, second_trig.args[0]: second_trig.func}
            other_factors = sp.Mul(*(factor for factor in factors if factor not in (first_trig, second_trig)))
            if len(functions) == 2:
                products = products_by_angles_and_factors.setdefault((frozenset(functions), other_factors), [])
                products.append(_ProductOfTrigs(term, number, functions))
    for (angles, other_factors), products in products_by_angles_and_factors.items():
        alpha, beta = sorted(angles, key=sp.default_sort_key)
        for (term, number, functions), (second_term, second_number, second_functions) in combinations(products, 2):
            has_same_function = any(functions[angle] is second_functions[angle] for angle in angles)
            if has_same_function or number not in (second_number, -second_number):
                continue
            is_cosine = functions[alpha] is functions[beta]  # cos cos and sin sin
            # cos(a - b) = cos a cos b + sin a sin b, but sin(a - b) = sin a cos b - cos a sin b
            is_difference = (number == second_number) == is_cosine
            function = sp.cos if is_cosine else sp.sin
            # the identity's first term is the one whose function of alpha is that of the result
            leading_number = number if functions[alpha] is function else second_number
            factor, trig = function(alpha - beta if is_difference else alpha + beta).as_coeff_Mul()
            if trig.free_symbols:
                yield (term, second_term), leading_number * factor * other_factors, trig


@lru_cache(maxsize=4096)
def factor_sums(expression: sp.Expr) -> sp.Expr:
    """Return an expression whose sums are factored by the sine and cosine of the first joint in them.

    >>> t1, t2, a2, a3, d2 = sp.symbols("theta1 theta2 a2 a3 d2")
    >>> factor_sums(a2 * sp.cos(t1) * sp.cos(t2) + a3 * sp.cos(t1) + d2 * sp.sin(t1))
    d2*sin(theta1) + (a2*cos(theta2) + a3)*cos(theta1)
    """
    if not expression.args or expression.is_Function:
        return expression
    args = tuple(map(factor_sums, expression.args))
    new_expression = expression if args == expression.args else expression.func(*args)
    if not new_expression.is_Add:
        return new_expression
    has_rates = any(map(is_rate_or_component, new_expression.free_symbols))
    return _collect_rates(new_expression) if has_rates else _collect_first_joint(new_expression)


def _collect_rates(total: sp.Add) -> sp.Expr:
    """Return a sum in which joint rates (or velocities) with the same coefficient are collected: s_1 (qd2 + qd3)."""
    rates_by_coefficient: dict[sp.Expr, list[sp.Expr]] = {}
    for term in total.args:
        symbols = (factor for factor in sp.Mul.make_args(term) if factor.is_Symbol)
        rates_in_term = list(filter(is_rate_or_component, symbols))
        if len(rates_in_term) != 1:
            return total
        (rate,) = rates_in_term
        if -term / rate in rates_by_coefficient:
            rates_by_coefficient[-term / rate].append(-rate)
        else:
            rates_by_coefficient.setdefault(term / rate, []).append(rate)
    return sp.Add(*(coefficient * sp.Add(*rates) for coefficient, rates in rates_by_coefficient.items()))


def _collect_first_joint(total: sp.Add) -> sp.Expr:
    """Return a sum with the sine and cosine of its first joint factored out; unchanged if that is impossible."""
    trigs_with_joints = [trig for trig in total.atoms(sp.sin, sp.cos) if trig.args[0].free_symbols]
    if not trigs_with_joints:
        return total
    first_joint = min(min(_find_joints_in_angle(trig)) for trig in trigs_with_joints)
    common_trigs = [trig for trig in trigs_with_joints if first_joint in _find_joints_in_angle(trig)]
    if not all(trig.args[0].is_Symbol for trig in common_trigs):
        return total
    angle_symbols = set().union(*(trig.args[0].free_symbols for trig in trigs_with_joints))
    groups: dict[sp.Expr, list[sp.Expr]] = {}
    for term in total.args:
        factors = sp.Mul.make_args(term)
        trigs = [factor for factor in factors if factor in common_trigs]
        remainder = sp.Mul(*(factor for factor in factors if factor not in common_trigs))
        is_varying = not trigs and remainder.free_symbols & angle_symbols
        if len(trigs) > 1 or is_varying or remainder.has(*common_trigs):
            return total
        groups.setdefault(trigs[0] if trigs else sp.S.One, []).append(remainder)
    if all(len(remainders) < 2 for trig, remainders in groups.items() if trig != 1):
        return total
    return sp.Add(*(trig * sp.Add(*remainders) for trig, remainders in groups.items()))


def _find_joints_in_angle(trig: sp.Expr) -> set[int]:
    return {joint for symbol in trig.args[0].free_symbols for joint in find_joints(symbol)}
