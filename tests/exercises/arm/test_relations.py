"""What conditions say of joints, put into others: what comes out is zero exactly where both hold, tried in numbers."""

import numpy as np
import pytest
import sympy as sp

from exercises.arm.relations import by_half_angle, relation_of
from exercises.arm.trigonometry import factored
from exercises.stream import Stream

T3, T4 = sp.symbols("theta3 theta4")
D5 = sp.Symbol("d5")
A, B = sp.symbols("a2 a3")
JOINTS = (T3, T4, D5)
s, c = sp.sin, sp.cos


def never_zero(constant: sp.Expr) -> bool:
    return constant != 0


@pytest.mark.parametrize(
    ("condition", "atom", "value"),
    [
        (A + D5, D5, -A),
        (A + D5 * s(T4), D5, -A / s(T4)),
        (A * c(T4) + B * D5, D5, -A * c(T4) / B),
        (A * c(T3) - B * s(T3), s(T3), A * c(T3) / B),
    ],
)
def test_a_condition_gives_a_slide_or_a_sine(condition: sp.Expr, atom: sp.Expr, value: sp.Expr) -> None:
    found = relation_of(condition, JOINTS, never_zero)
    assert found is not None
    assert (found.atom, sp.simplify(found.value - value)) == (atom, 0)


@pytest.mark.parametrize(
    "condition",
    [
        c(T4) + D5 * s(T3),  # wherever both vanish, d5 is free
        A + D5**2,
        A + B * c(T3) + B * s(T3),
        c(T3) + c(T4),
        (A - A) * c(T3) + B * s(T3) + 0 * D5,  # that is s3 = 0
    ],
)
def test_what_is_not_sure_gives_nothing(condition: sp.Expr) -> None:
    assert relation_of(condition, JOINTS, never_zero) is None


def test_a_constant_that_may_be_zero_gives_nothing() -> None:
    assert relation_of((A - B) + D5 * s(T4), JOINTS, lambda constant: constant != A - B) is None
    assert relation_of((A - B) * c(T3) + B * s(T3), JOINTS, lambda constant: sp.expand(constant) != A - B) is None


def test_what_is_put_in_shows_its_factors() -> None:
    found = relation_of(A + D5 * s(T4), JOINTS, never_zero)
    assert found is not None
    put = found.put_into(D5 + A * c(T4) + A * s(T4) + D5 * s(2 * T4))
    assert {factor for factor, _ in factored(put).factors} == {A, c(T4), s(T4) + c(T4)}
    assert found.beside == (s(T4),)
    assert found.is_in(D5 * c(T3))
    assert not found.is_in(c(T4))


@pytest.mark.parametrize("seed", range(8))
def test_factors_by_the_half_angle_are_those_of_the_condition(seed: int) -> None:
    draws = Stream(f"half angle/{seed}")
    parts = [
        draws.choice((-2, -1, 1, 2)) * c(T3) + draws.choice((-3, -1, 1, 2)) * B * s(T3) + draws.choice((0, 1, 4)) * A
        for _ in range(2)
    ]
    whole = sp.expand(sp.expand(parts[0] * parts[1]).subs(s(T3) ** 2, 1 - c(T3) ** 2))
    found = by_half_angle(whole, JOINTS)
    assert len(found) == 2
    for q in np.linspace(-3, 3, 7):
        at = {T3: sp.Float(q), A: sp.Rational(3, 7), B: sp.Rational(5, 11)}
        ratio = (parts[0] * parts[1]).subs(at) / (found[0] * found[1]).subs(at)
        assert abs(abs(ratio) - abs((parts[0] * parts[1] / (found[0] * found[1])).subs({**at, T3: 0.123}))) < 1e-9


@pytest.mark.parametrize("condition", [c(T3) + A, c(T3) ** 2 * A + s(T3) * B + 2, c(T3) * s(T4), A * D5**2 + D5])
def test_what_has_no_such_factors_is_left_as_it_is(condition: sp.Expr) -> None:
    assert by_half_angle(condition, JOINTS) == [condition]
