"""Arms by their axes: the table that is made of them holds their numbers exactly, so that it tells them again."""

import pytest
import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.conventions import axes_of, by_axes
from exercises.arm.placing import Axis, exactly
from exercises.stream import Stream

WAYS = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 3, 4), (1, 2, 2), (1, -1, 1), (0, 1, 1), (2, 3, 6), (1, 2, 3))
A1, A2 = sp.symbols("a1 a2")
LENGTHS = {A1: sp.Rational(7, 10), A2: sp.Rational(3, 10)}


@pytest.mark.parametrize("seed", range(12))
def test_oblique_axes_are_told_as_they_were_given(seed: int) -> None:
    """No number is rounded on the way through the table: 30 digits agree."""
    stream = Stream(f"placing/{seed}")

    def place() -> sp.Matrix:
        return sp.Matrix([sp.Rational(stream.integer(-20, 20), 20) for _ in range(3)])

    open_length = sp.Matrix([A1 if seed % 3 == 0 else 0, 0, 0])
    axes = []
    for _ in range(stream.integer(2, 5)):
        way = sp.Matrix(stream.choice(WAYS))
        axes.append(Axis(stream.choice("RRRP"), way / way.norm(), place() + open_length))
    point = place() + 2 * open_length + (sp.Matrix([A2, 0, 0]) if seed % 3 == 0 else sp.zeros(3, 1))
    base, joints, tool = by_axes(axes, point, len(axes))
    found, there = axes_of(Chain("oblique", joints, ("vx",), base, tool))
    gone = [there - point, *(one.direction - axis.direction for one, axis in zip(found, axes, strict=True))]
    gone += [(f.point - a.point).cross(a.direction) for f, a in zip(found, axes, strict=True) if a.kind == "R"]
    assert all(abs(sp.N(entry.xreplace(LENGTHS), 40)) < 1e-30 for vector in gone for entry in vector)


@pytest.mark.parametrize(
    "value",
    ["3/sqrt(41)", "9/164000", "1/7", "0.1234567891", "sqrt(9/16400)", "1/20 + 17*sqrt(2)/40", "sqrt(3)/2 - sqrt(6)/8"],
)
def test_a_number_is_told_as_what_it_is(value: str) -> None:
    exact = sp.nsimplify(value, rational=True)
    assert sp.simplify(exactly(exact.n(80)) - exact) == 0


def test_a_number_of_no_simple_form_is_rounded() -> None:
    assert exactly(sp.sin(sp.S.One)) == sp.Rational("0.8414709848")
