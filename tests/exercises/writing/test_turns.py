"""Constants that are sines and cosines of an arm's own angles: said by these angles, with the value that they have."""

import pytest
import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.solving import solution_text, solve
from exercises.writing.latex import tex
from exercises.writing.turns import turns_of, with_turns

PI = sp.pi
A2, T2 = sp.symbols("a2 theta2")


def arm(degrees: int | sp.Rational) -> Chain:
    alpha = sp.Rational(degrees) * PI / 180
    joints = (Joint("R", sp.Symbol("theta1"), 0, 0, alpha), Joint("R", T2, 0, A2, 0))
    return Chain("oblique", joints, ("vx", "vy", "vz"))


@pytest.mark.parametrize(
    ("degrees", "shown"),
    [(75, ("75", "75")), (15, ("15", "15")), (105, ("75", "75")), (-75, ("75", "75")), (165, ("15", "15")),
     (72, ("72", "72")), (sp.Rational(45, 2), ("22.5", "22.5")), (54, ("54", "54"))],
)  # fmt: skip
def test_a_twist_is_said_as_the_table_has_it(degrees: int, shown: tuple[str, str]) -> None:
    chain = arm(degrees)
    (turn,) = turns_of(chain)
    cosine, sine = shown
    assert tex(sp.cos(turn) * A2, chain) == rf"\cos({cosine}^\circ) a_{{2}}"
    assert tex(sp.sin(turn) * A2, chain) == rf"\sin({sine}^\circ) a_{{2}}"


def test_no_root_is_left_of_it_in_a_whole_derivation() -> None:
    text = solution_text(solve(arm(75)))
    assert "cos(75°)" in text
    assert "15°" not in text
    assert "√" not in text


def test_angles_that_are_in_no_table_are_said_by_fifteen_degrees() -> None:
    assert tex(sp.cos(5 * PI / 12) * A2) == r"\sin(15^\circ) a_{2}"
    assert tex(sp.cos(5 * PI / 12) * A2, arm(90)) == r"\sin(15^\circ) a_{2}"


def test_base_and_zeros_of_joints_count_as_the_table_does() -> None:
    joints = (Joint("R", sp.Symbol("theta1") + 5 * PI / 12, 0, A2, 0), Joint("P", PI / 5, sp.Symbol("d2"), 0, 0))
    chain = Chain("turned", joints, ("vx",), Base(yaw=-3 * PI / 8, tilt=PI))
    assert turns_of(chain) == (5 * PI / 12, PI / 5, 3 * PI / 8)


@pytest.mark.parametrize("turn", [PI / 12, 5 * PI / 12, PI / 8, 3 * PI / 8, PI / 5, PI / 10, 2 * PI / 5, 3 * PI / 10])
def test_what_is_said_has_the_same_value(turn: sp.Expr) -> None:
    x = sp.Symbol("x")
    sine, cosine = sp.sin(turn), sp.cos(turn)
    for whole in (3 * sine * x - cosine / 7, cosine**2 * x + 2, x / sine, sp.expand((sine + x) * (cosine - 2) * 5)):
        said = with_turns(whole, (turn,))
        assert abs(sp.N((said - whole).subs(x, sp.Rational(5, 7)), 30)) < 1e-25
    assert with_turns(sine * x, (turn,)) == sp.sin(turn, evaluate=False) * x


def test_roots_that_are_lengths_stay_what_they_are() -> None:
    whole = sp.sqrt(2) * A2 / 4 + sp.sqrt(6) / 3 + sp.sqrt(5) * T2 + T2
    assert with_turns(whole, (5 * PI / 12,)) == whole
