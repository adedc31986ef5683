"""Expressions as text, letter by letter as SymPy prints them, in a quarter of the time for sums, products and sines.

SymPy asks every node for its class and its precedence and, to order a sum, mpmath for the value of every coefficient.
Here the few kinds that answers are made of are put together directly. Whatever else there is, SymPy prints. It needs
nothing of qdot: the process in which notebooks run loads this file by itself (`grader/sandbox/contained/printing`).
"""

import math
from collections.abc import Callable
from typing import Any

import sympy
from sympy.core.numbers import Half, Integer, NegativeOne, One, Rational, Zero
from sympy.core.sorting import default_sort_key
from sympy.printing.str import StrPrinter

MOST_KEPT, LONGEST_KEPT = 4096, 1000
"""Sums, sines and cosines whose text is kept, and the characters of the longest: angles come often in an answer."""

LONGEST_NUMBER = 500
"""Bits of a number that is as good as a double when terms are put in order."""

RATIONALS = (Rational, Integer, Half, One, NegativeOne, Zero)


class Printer(StrPrinter):
    """Prints what SymPy's own printer prints."""

    def _print(self, expr: Any, **settings: Any) -> str:
        direct = None if settings else DIRECT.get(type(expr))
        text = None if direct is None else direct(self, expr)
        return str(super()._print(expr, **settings)) if text is None else text


class FullPrinter(Printer):
    """Prints doubles with all their digits: SymPy prints 15, and 0.866025403784439 is not the root of 3/4."""

    def _print_Float(self, number: sympy.Float) -> str:
        return repr(float(number)) if number._prec <= 53 else str(sympy.sstr(number, full_prec=True))


Direct = Callable[[Printer, Any], str | None]
"""Returns the text of an expression, None where SymPy is to print it."""

_kept: dict[tuple[type[Printer], int], tuple[sympy.Expr, str]] = {}


def kept(make: Direct) -> Direct:
    """Keep texts by the very object: equal would not do, as 0.5 is equal to 0.50."""

    def text_of(printer: Printer, expr: Any) -> str | None:
        key = type(printer), id(expr)
        known = _kept.get(key)
        if known is not None and known[0] is expr:
            return known[1]
        text = make(printer, expr)
        if text is not None and len(text) <= LONGEST_KEPT:
            if len(_kept) >= MOST_KEPT:
                _kept.clear()
            _kept[key] = expr, text
        return text

    return text_of


@kept
def _sine_or_cosine(printer: Printer, expr: Any) -> str | None:
    (angle,) = expr.args
    return f"{type(expr).__name__}({printer._print(angle)})" if type(angle) in DIRECT else None


@kept
def _sum(printer: Printer, expr: sympy.Add) -> str | None:
    terms = _in_order(expr)
    if terms is None:
        return None
    shown = ""
    for term in terms:
        text, sign = printer._print(term), "+"
        if type(term) is sympy.Add:
            text = f"({text})"
        elif text.startswith("-"):
            text, sign = text[1:], "-"
        shown += f" {sign} {text}" if shown else text if sign == "+" else f"-{text}"
    return shown


def _in_order(expr: sympy.Add) -> list[sympy.Expr] | None:
    """Return the terms as `as_ordered_terms` has them: by the powers of what is multiplied, then by coefficients."""
    if len(expr.args) < 3 and any(isinstance(term, (sympy.Number, sympy.NumberSymbol)) for term in expr.args):
        return None
    terms: list[tuple[sympy.Expr, float, dict[sympy.Expr, int]]] = []
    for term in expr.args:
        number, factors = _taken_apart(term)
        if not all(map(_is_plain, factors)) or max(number.p.bit_length(), number.q.bit_length()) > LONGEST_NUMBER:
            return None
        coefficient, powers = number.p / number.q, dict[sympy.Expr, int]()
        for factor in factors:
            base, power = _power(factor)
            if factor is sympy.pi:
                coefficient *= math.pi
            elif type(base) is not sympy.Symbol and base.is_number:
                return None
            else:
                powers[base] = power
        terms.append((term, coefficient, powers))
    bases = sorted({base for _, _, powers in terms for base in powers}, key=default_sort_key)
    terms.sort(key=lambda one: ([-one[2].get(base, 0) for base in bases], one[1]))
    return [term for term, _, _ in terms]


def _taken_apart(term: sympy.Expr) -> tuple[Rational, tuple[sympy.Expr, ...]]:
    """Return the number before a product or anything else, and the factors behind it."""
    factors = term.args if type(term) is sympy.Mul else (term,)
    return (factors[0], factors[1:]) if type(factors[0]) in RATIONALS else (sympy.S.One, factors)


def _is_plain(factor: sympy.Expr) -> bool:
    """Tell whether a factor is put together here, with others that may change places with it."""
    if type(factor) is sympy.Pow:
        factor, exponent = factor.args
        if type(exponent) not in RATIONALS or exponent.q != 1 or exponent.p in (0, 1) or factor is sympy.pi:
            return False
    return factor is sympy.pi or (type(factor) in FACTORS and bool(factor.is_commutative))


def _power(factor: sympy.Expr) -> tuple[sympy.Expr, int]:
    return (factor.base, int(factor.exp)) if type(factor) is sympy.Pow else (factor, 1)


@kept
def _product(printer: Printer, expr: sympy.Mul) -> str | None:
    number, factors = _taken_apart(expr)
    if not factors or number.p == 0 or expr.args[0] is sympy.S.One:
        return None
    if not all(map(_is_plain, factors)):
        return None
    above = [] if abs(number.p) == 1 else [str(abs(number.p))]
    below = [] if number.q == 1 else [str(number.q)]
    for factor in sorted(factors, key=default_sort_key):
        base, power = _power(factor)
        text = printer._print(base)
        if type(base) is sympy.Add:
            text = f"({text})"
        (above if power > 0 else below).append(text if abs(power) == 1 else f"{text}**{abs(power)}")
    sign = "-" if number.p < 0 else ""
    text = sign + ("*".join(above) or "1")
    if not below:
        return text
    return f"{text}/{below[0]}" if len(below) == 1 else f"{text}/({'*'.join(below)})"


def _name(_: Printer, expr: sympy.Symbol) -> str:
    return str(expr.name)


def _pi(_: Printer, __: sympy.Expr) -> str:
    return "pi"


def _number(_: Printer, expr: Rational) -> str:
    return str(expr.p) if expr.q == 1 else f"{expr.p}/{expr.q}"


FACTORS = (sympy.Symbol, sympy.sin, sympy.cos, sympy.Add)
"""What products and powers are made of that are put together here."""

DIRECT: dict[type, Direct] = {
    sympy.Add: _sum, sympy.Mul: _product, sympy.sin: _sine_or_cosine, sympy.cos: _sine_or_cosine, sympy.Symbol: _name,
    type(sympy.pi): _pi, **dict.fromkeys(RATIONALS, _number),
}  # fmt: skip
