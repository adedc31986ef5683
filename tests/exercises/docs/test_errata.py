"""The numbers of exercises/chapter/errata.toml, computed from the derivation, and the printed formulas of the book."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm, read_errata
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.singularities.classification import classify_conditions

A1, A2, A3, T1, T2, T3, QD1, QD2 = sp.symbols("a1 a2 a3 theta1 theta2 theta3 qd1 qd2")
HALF, TWO_FIFTHS = sp.Rational(1, 2), sp.Rational(2, 5)


def to_radians(value: int) -> sp.Expr:
    return sp.pi * sp.Rational(value, 180)


TWO_R = {A1: HALF, A2: TWO_FIFTHS, T1: to_radians(20), T2: to_radians(40)}
RATES = {QD1: sp.Integer(1), QD2: sp.Integer(2)}
ELBOW = {A1: sp.Rational(1, 10), A2: HALF, A3: TWO_FIFTHS, T1: to_radians(30), T2: to_radians(-40), T3: to_radians(70)}


def read_numbers(place: str) -> list[float]:
    (erratum,) = [erratum for erratum in read_errata() if place in erratum.place]
    return [float(value.removesuffix(" m/s").replace("−", "-")) for _, value in erratum.values]


def compute_rank(chain: Chain, configuration: Mapping[sp.Symbol, sp.Expr]) -> int:
    jacobian = np.array(derive(chain).jacobian.xreplace(dict(configuration)).evalf(20).tolist(), dtype=float)
    return int(np.linalg.matrix_rank(jacobian, tol=1e-9))


def count_inverse_solutions(a1: float, a2: float, distance: float) -> int:
    """Count the poses of a planar 2R arm that reach a point at this distance, by the law of cosines."""
    cosine = (distance**2 - a1**2 - a2**2) / (2 * a1 * a2)
    return 1 if abs(abs(cosine) - 1) < 1e-12 else 2 if abs(cosine) < 1 else 0


def classify_folded_arm(second: sp.Expr) -> str:
    planar = make_planar_2r()
    joints = tuple(replace(joint, a=a) for joint, a in zip(planar.joints, (HALF, second), strict=True))
    return classify_conditions(replace(planar, joints=joints), ("theta2 = pi",)).kind


def approximate(*computed: object) -> object:
    """Return what compares equal to the numbers rounded to four digits."""
    return pytest.approx([float(value) for value in computed], rel=6e-4, abs=1e-12)  # type: ignore[arg-type]


def test_numbers_of_planar_arm_are_those_computed() -> None:
    planar = derive(make_planar_2r())
    rotation, jacobian = planar.rotations[2].xreplace(TWO_R), planar.jacobian.xreplace(TWO_R).evalf()
    cosine = sp.cos(T1 + T2).xreplace(TWO_R)
    assert read_numbers("of $T$") == approximate(sp.sqrt(rotation[0, 0] ** 2 + cosine**2 + rotation[2, 0] ** 2), 1)
    assert rotation[:, 0].norm() == 1

    printed = -A1 * sp.sin(T1) * QD1 - A2 * sp.sin(T1 + T2) * QD1 + QD2
    right = (planar.geometric_jacobian[0, :] * sp.Matrix([QD1, QD2]))[0]
    assert read_numbers("$v_x$ and $v_y$") == approximate(*(v.xreplace({**TWO_R, **RATES}) for v in (printed, right)))

    wrong_inverse = jacobian.inv().as_mutable()
    wrong_inverse[0, 1] *= -1
    assert read_numbers("$J^{-1}$") == approximate(*(jacobian * wrong_inverse * sp.Matrix([0, sp.Rational(1, 5)])), 0)

    stretched, folded = ({**TWO_R, T2: angle} for angle in (sp.S.Zero, sp.pi))
    assert (
        read_numbers("aligned")
        == [compute_rank(make_planar_2r(), TWO_R), compute_rank(make_planar_2r(), stretched)]
        == [2, 1]
    )
    at_stop, at_stretch, at_fold = (planar.determinant.xreplace(where) for where in (TWO_R, stretched, folded))
    assert read_numbers("boundary singularities") == approximate(at_stop, at_stretch)
    assert read_numbers("not invertible") == approximate(at_stretch, at_fold)


def test_solutions_and_kinds_of_planar_arm_are_those_computed() -> None:
    point = NumericChain(make_planar_2r(), {"a1": 0.5, "a2": 0.4}).compute_point(np.array([0.0, np.pi / 3]))
    distance = float(np.linalg.norm(point))
    (erratum,) = [erratum for erratum in read_errata() if "inverse-kinematics solutions" in erratum.place]
    assert f"at {distance:.3f} m" in erratum.values[1][0]
    solutions = [count_inverse_solutions(0.5, 0.4, 0.9), count_inverse_solutions(0.5, 0.4, distance)]
    assert read_numbers("inverse-kinematics solutions") == solutions == [1, 2]
    (erratum,) = [erratum for erratum in read_errata() if "$s_2 = 0$" in erratum.place]
    assert [kind for _, kind in erratum.values] == [classify_folded_arm(HALF), classify_folded_arm(TWO_FIFTHS)]


def test_numbers_of_scorbot_are_those_computed() -> None:
    scorbot, arm = derive(make_scorbot_arm()), make_scorbot_arm()
    printed = -sp.sin(T1) * (A2 * sp.sin(T2) + A3 * sp.cos(T2 + T3))
    step = sp.Rational(1, 10**5)
    ahead, behind = (scorbot.position[1].xreplace({**ELBOW, T2: ELBOW[T2] + side * step}) for side in (1, -1))
    difference = (ahead - behind).evalf(30) / (2 * step)
    right = scorbot.geometric_jacobian[1, 1].xreplace(ELBOW)
    assert read_numbers("partial") == approximate(printed.xreplace(ELBOW), right, difference)

    terms, product = sp.expand(scorbot.jacobian.det(method="berkowitz")), scorbot.determinant
    count = len(sp.Add.make_args(terms))
    assert read_numbers(r"$\det J$") == approximate(count, terms.xreplace(ELBOW), product.xreplace(ELBOW))

    bent = {symbol: value for symbol, value in ELBOW.items() if symbol != T2}
    shoulder = {**bent, T2: sp.nsolve(product.xreplace(bent), T2, 2.0, prec=30)}
    straight = {**bent, T2: sp.S.Zero}
    computed = (
        compute_rank(arm, straight),
        product.xreplace(straight),
        compute_rank(arm, shoulder),
        product.xreplace(shoulder),
    )
    assert read_numbers("Example 6.3, singular") == approximate(*computed)
    assert computed[0] == 3 and computed[2] == 2
    (erratum,) = [erratum for erratum in read_errata() if "Example 6.3, singular" in erratum.place]
    assert rf"\theta_2 = {float(sp.deg(shoulder[T2])):.2f}^\circ" in erratum.configuration
