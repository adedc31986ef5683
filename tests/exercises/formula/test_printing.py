"""The text of an answer is SymPy's, letter by letter, whoever put it together."""

import pytest
import sympy as sp
from sympy.printing.str import StrPrinter

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.printing import FullPrinter, Printer

SYMBOLS = (*sp.symbols("theta1 theta2 a1 d4 qd1 vx"), sp.Symbol("N", commutative=False), sp.Dummy("q"))
NUMBERS = (sp.pi, sp.S(-1), sp.S(3), sp.Rational(-2, 7), sp.Rational(41, 100), sp.sqrt(2), sp.I, sp.S(10) ** 400)
FUNCTIONS = (sp.sin, sp.cos, sp.tan, sp.atan, sp.Abs)
POWERS = (-2, -1, 0, 1, 2, sp.Rational(1, 2), sp.Rational(-1, 2), SYMBOLS[2])


def drawn(rng: Stream, depth: int) -> sp.Expr:
    """Return an expression, a tenth of its nodes as SymPy would not leave them."""
    if depth == 0:
        return rng.choice(SYMBOLS if rng.choice(range(3)) else NUMBERS)
    kind, evaluate = rng.choice(range(10)), rng.choice(range(10)) > 0
    if kind < 8:
        parts = [drawn(rng, depth - 1) for _ in range(rng.choice((2, 3)))]
        return (sp.Add if kind < 4 else sp.Mul)(*parts, evaluate=evaluate)
    if kind == 8:
        return rng.choice(FUNCTIONS)(drawn(rng, depth - 1), evaluate=evaluate)
    return sp.Pow(drawn(rng, depth - 1), rng.choice(POWERS), evaluate=evaluate)


@pytest.mark.parametrize("depth", [1, 2, 3])
def test_what_is_put_together_directly_is_what_sympy_prints(depth: int) -> None:
    rng = Stream(f"printing/{depth}")
    for _ in range(150):
        expression = drawn(rng, depth)
        text = StrPrinter().doprint(expression)
        assert Printer().doprint(expression) == FullPrinter().doprint(expression) == text, sp.srepr(expression)


def test_doubles_have_all_their_digits() -> None:
    trig = sp.sin(sp.Float(3**0.5 / 2) * SYMBOLS[0] + SYMBOLS[1])
    assert Printer().doprint(trig) == str(trig) == "sin(0.866025403784439*theta1 + theta2)"
    assert FullPrinter().doprint(trig) == "sin(0.8660254037844386*theta1 + theta2)"


def test_what_is_equal_and_written_otherwise_keeps_its_own_text() -> None:
    x = SYMBOLS[0]
    half, longer = sp.Float("0.5", 15) * x + 1, sp.Float("0.5", 30) * x + 1
    texts = [FullPrinter().doprint(one) for one in (half, longer, half)]
    assert texts[0] == texts[2]
    assert texts[0] != texts[1]
