r"""Sums gathered as a person writes them: the sine and cosine of the joint that turns the whole arm stand outside.

x = (0.2 + a_2 c_2) c_1 + d_2 s_1, in the place of three products; the value is the same. So do equal factors of rates.
"""

from functools import lru_cache

import sympy as sp

from qdot.exercises.formula.order import joints_of, moves


@lru_cache(maxsize=4096)
def gathered(expression: sp.Expr) -> sp.Expr:
    """Return an expression whose sums are gathered by the sine and cosine of the first joint that turns them.

    >>> t1, t2, a2, a3, d2 = sp.symbols("theta1 theta2 a2 a3 d2")
    >>> gathered(a2 * sp.cos(t1) * sp.cos(t2) + a3 * sp.cos(t1) + d2 * sp.sin(t1))
    d2*sin(theta1) + (a2*cos(theta2) + a3)*cos(theta1)
    """
    if not expression.args or expression.is_Function:
        return expression
    args = tuple(map(gathered, expression.args))
    whole = expression if args == expression.args else expression.func(*args)
    if not whole.is_Add:
        return whole
    return _by_rates(whole) if any(moves(symbol) for symbol in whole.free_symbols) else _by_first_turn(whole)


def _by_rates(total: sp.Add) -> sp.Expr:
    """Gather joint rates, or velocities, with the same coefficient: s_1 (qd2 + qd3)."""
    rates: dict[sp.Expr, list[sp.Expr]] = {}
    for term in total.args:
        own = [factor for factor in sp.Mul.make_args(term) if factor.is_Symbol and moves(factor)]
        if len(own) != 1:
            return total
        coefficient = term / own[0]
        if -coefficient in rates:
            rates[-coefficient].append(-own[0])
        else:
            rates.setdefault(coefficient, []).append(own[0])
    return sp.Add(*(c * sp.Add(*each) for c, each in rates.items()))


def _by_first_turn(total: sp.Add) -> sp.Expr:
    turning = [trig for trig in total.atoms(sp.sin, sp.cos) if trig.args[0].free_symbols]
    if not turning:
        return total
    first = min(min(_joints(trig)) for trig in turning)
    outside = [trig for trig in turning if first in _joints(trig)]
    if not all(trig.args[0].is_Symbol for trig in outside):
        return total
    groups: dict[sp.Expr, list[sp.Expr]] = {}
    for term in total.args:
        factors = sp.Mul.make_args(term)
        own = [factor for factor in factors if factor in outside]
        rest = sp.Mul(*(factor for factor in factors if factor not in outside))
        if rest.has(*outside) or len(own) > 1 or (not own and rest.free_symbols & _variables(turning)):
            return total
        groups.setdefault(own[0] if own else sp.S.One, []).append(rest)
    if all(len(rests) < 2 for trig, rests in groups.items() if trig != 1):
        return total
    return sp.Add(*(trig * sp.Add(*rests) for trig, rests in groups.items()))


def _joints(trig: sp.Expr) -> set[int]:
    return {joint for symbol in trig.args[0].free_symbols for joint in joints_of(symbol)}


def _variables(turning: list[sp.Expr]) -> set[sp.Expr]:
    return {symbol for trig in turning for symbol in trig.args[0].free_symbols}
