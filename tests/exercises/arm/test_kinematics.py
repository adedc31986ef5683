"""Chains: valid tables, exact if from joint axes; all ways to compute a Jacobian agree, and with finite differences."""

from collections.abc import Callable

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from qdot.exercises.arm.axes_to_dh import Axis, move_point_along_axes, recognize_exact
from qdot.exercises.arm.chain import Base, Chain, Joint, Point
from qdot.exercises.arm.kinematics import NumericChain, compute_frames_and_point
from qdot.exercises.arm.mpmath_kinematics import PRECISE_CONTEXT, compute_determinant, compute_inverse, solve_linear
from qdot.exercises.arm.standard_table import compute_home_geometry, convert_axes
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import Derivation, derive
from qdot.exercises.derivation.graph import compute_symbolic_stages, propagate_linear_rows, to_sympy_matrix
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from tests.support.suites import select_for_suite

T1, T2, A1, A2 = sp.symbols("theta1 theta2 a1 a2")
FIRST, SECOND = Joint("R", T1, 0, A1, 0), Joint("R", T2, 0, A2, 0)


def make_planar_arm(*joints: Joint, task: tuple[str, ...] = ("vx", "vy"), tool: Point | None = None) -> Chain:
    return Chain("arm", joints, task, tool=tool)


def test_chain_lists_variables_rates_offsets_and_lengths() -> None:
    arm = make_planar_arm(
        FIRST, Joint("R", T2 + sp.pi / 2, 0, A2, 0), Joint("P", 0, sp.Symbol("d3") + sp.Rational(1, 5), 0, 0)
    )
    assert [q.name for q in arm.q] == ["theta1", "theta2", "d3"]
    assert [rate.name for rate in arm.rates] == ["qd1", "qd2", "qd3"]
    assert arm.offsets == (0, sp.pi / 2, sp.Rational(1, 5))
    assert [symbol.name for symbol in arm.parameters] == ["a1", "a2"]
    assert arm.point == Point(3)


D2 = sp.Symbol("d2")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (make_planar_arm, "at least one joint"),
        (lambda: make_planar_arm(Joint("R", T2, 0, A1, 0)), "theta is theta2, but must be theta1 plus a constant"),
        (lambda: make_planar_arm(FIRST, Joint("R", 2 * T2, 0, A2, 0)), "must be theta2 plus a constant"),
        (lambda: make_planar_arm(FIRST, Joint("R", T2, 0, T1, 0)), "contains theta1, the variable of a joint"),
        (lambda: make_planar_arm(FIRST, Joint("P", 0, D2, D2, 0)), "contains d2"),
        (lambda: make_planar_arm(Joint("R", T1, D2, A1, 0), Joint("P", 0, D2, 0, 0)), "contains d2"),
        (lambda: Joint("X", T1, 0, A1, 0), "'R' or 'P', not 'X'"),
        *((lambda task=task: make_planar_arm(FIRST, task=task), "task") for task in ((), ("vx", "vx"), ("x",))),
        (lambda: make_planar_arm(FIRST, tool=Point(2)), "there is no frame O2; the last frame is O1"),
    ],
)
def test_invalid_arm_is_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(QdotError, match=message):
        make()


def test_planar_arms_are_distinguished_from_spatial_ones() -> None:
    assert make_planar_arm(FIRST, SECOND).is_planar
    assert make_planar_arm(Joint("R", T1, 0, A1, sp.pi), SECOND).is_planar
    assert make_planar_arm(Joint("R", T1, 0, A1, sp.pi / 2), Joint("P", 0, sp.Symbol("d2"), 0, 0)).is_planar
    assert not make_planar_arm(Joint("R", T1, 0, A1, sp.pi / 2), SECOND).is_planar
    assert not Chain("arm", (FIRST, SECOND), ("vx", "vy"), Base(tilt=sp.pi / 2)).is_planar


def test_a_point_beside_the_plane_of_a_twisted_last_frame_is_not_planar() -> None:
    offset, zero = sp.Rational(1, 10), sp.S.Zero
    twisted = Joint(SECOND.kind, SECOND.theta, SECOND.d, SECOND.a, sp.pi / 2)
    for joint, point, is_planar in (
        (SECOND, (zero, offset, zero), True), (SECOND, (zero, zero, offset), False),
        (twisted, (zero, offset, zero), False), (twisted, (zero, zero, offset), True),
    ):  # fmt: skip
        arm = make_planar_arm(FIRST, joint, tool=Point(2, point))
        assert arm.is_planar is is_planar, (joint, point)


RIGHT = st.sampled_from([sp.S.Zero, sp.pi / 2, sp.pi, -sp.pi / 2])
LENGTH = st.sampled_from([sp.S.Zero, sp.Rational(1, 2), sp.Rational(-3, 10), sp.Symbol("h")])
ODD = st.sampled_from([sp.S.Zero, sp.pi / 6, -sp.pi / 2, sp.Rational(1, 3)])


@st.composite
def chains(draw: st.DrawFn) -> Chain:
    joints = []
    for i in range(1, draw(st.integers(1, 4)) + 1):
        kind = draw(st.sampled_from("RRP"))
        joint_value = sp.Symbol(f"theta{i}" if kind == "R" else f"d{i}") + draw(ODD)
        constant = draw(LENGTH) if kind == "R" else draw(ODD)
        theta, d = (joint_value, constant) if kind == "R" else (constant, joint_value)
        joints.append(Joint(kind, theta, d, draw(LENGTH), draw(st.one_of(RIGHT, ODD))))
    base = Base((draw(LENGTH), draw(LENGTH), draw(LENGTH)), draw(ODD), draw(st.one_of(RIGHT, ODD)))
    point = Point(draw(st.integers(0, len(joints))), (draw(LENGTH), draw(LENGTH), draw(LENGTH)))
    return Chain("any", tuple(joints), ("vx",), base, point)


def evaluate_matrix(matrix: sp.Matrix, chain: Chain, q: np.ndarray) -> np.ndarray:
    values = {joint.name: np.array([value]) for joint, value in zip(chain.q, q, strict=True)}
    values["h"] = np.array([0.37])
    entries = evaluate(compile_program([parse_formula(str(entry)) for entry in matrix]), values, 1).values.real
    return entries.reshape(matrix.shape)


@settings(max_examples=select_for_suite(8, 60))
@given(chains(), st.integers(0, 10**6))
def test_symbolic_and_numeric_kinematics_agree(chain: Chain, seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-2, 2, chain.n)
    arm = NumericChain(chain, {"h": 0.37})
    poses, jacobian = arm.compute_frames(q), arm.compute_jacobian(q)
    frames, point = compute_frames_and_point(chain)
    stages = compute_symbolic_stages(chain)
    for i, (frame, rotation) in enumerate(zip(frames, stages["rotations"], strict=True)):
        np.testing.assert_allclose(evaluate_matrix(frame.rotation, chain, q), poses[i, :3, :3], atol=1e-12)
        np.testing.assert_allclose(evaluate_matrix(to_sympy_matrix(rotation), chain, q), poses[i, :3, :3], atol=1e-12)
        np.testing.assert_allclose(evaluate_matrix(frame.origin, chain, q)[:, 0], poses[i, :3, 3], atol=1e-12)
    np.testing.assert_allclose(evaluate_matrix(point, chain, q)[:, 0], arm.compute_point(q), atol=1e-12)
    propagated = to_sympy_matrix(np.concatenate([propagate_linear_rows(stages), stages["angular rows"]]))
    np.testing.assert_allclose(evaluate_matrix(propagated, chain, q), jacobian, atol=1e-12)
    np.testing.assert_allclose(evaluate_matrix(point.jacobian(chain.q), chain, q), jacobian[:3], atol=1e-12)
    for i in range(chain.n):
        p_star = evaluate_matrix(to_sympy_matrix(stages["vectors to point"][i]), chain, q)[:, 0]
        np.testing.assert_allclose(p_star, arm.compute_point(q) - poses[i, :3, 3], atol=1e-12)


@settings(max_examples=60)
@given(chains(), st.integers(0, 10**6))
def test_jacobian_agrees_with_finite_differences(chain: Chain, seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-2, 2, chain.n)
    arm, h = NumericChain(chain, {"h": 0.37}), 1e-5
    ahead, behind = (arm.compute_frames(q + side * h * np.eye(chain.n)) for side in (1, -1))
    linear = (arm.compute_point_of(ahead) - arm.compute_point_of(behind)).T / (2 * h)
    spin = (ahead - behind)[:, -1, :3, :3] / (2 * h) @ arm.compute_frames(q)[-1, :3, :3].T
    angular = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
    np.testing.assert_allclose(arm.compute_jacobian(q), np.vstack([linear, angular]), atol=1e-8)


DIRECTIONS = (
    (0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 3, 4), (1, 2, 2), (1, -1, 1), (0, 1, 1), (2, 3, 6), (1, 2, 3),
)  # fmt: skip
LENGTHS = {A1: sp.Rational(7, 10), A2: sp.Rational(3, 10)}


@pytest.mark.parametrize("seed", range(select_for_suite(5, 12)))
def test_table_keeps_oblique_axes_exact(seed: int) -> None:
    """The axes computed back from the table agree to 30 digits."""
    stream = Stream(f"placing/{seed}")

    def sample_point() -> sp.Matrix:
        return sp.Matrix([sp.Rational(stream.integer(-20, 20), 20) for _ in range(3)])

    open_length = sp.Matrix([A1 if seed % 3 == 0 else 0, 0, 0])
    axes = []
    for _ in range(stream.integer(2, 5)):
        direction = sp.Matrix(stream.choice(DIRECTIONS))
        axes.append(Axis(stream.choice("RRRP"), direction / direction.norm(), sample_point() + open_length))
    point = sample_point() + 2 * open_length + (sp.Matrix([A2, 0, 0]) if seed % 3 == 0 else sp.zeros(3, 1))
    base, joints, tool = convert_axes(axes, point, len(axes))
    home_axes, home_point = compute_home_geometry(Chain("oblique", joints, ("vx",), base, tool))
    pairs = list(zip(home_axes, axes, strict=True))
    differences = [home_point - point, *(home.direction - axis.direction for home, axis in pairs)]
    differences += [(home.point - axis.point).cross(axis.direction) for home, axis in pairs if axis.is_revolute]
    assert all(abs(sp.N(entry.xreplace(LENGTHS), 40)) < 1e-30 for vector in differences for entry in vector)


def _has_symbolic_root(entry: sp.Expr) -> bool:
    return entry.has(sp.atan2) or any(not p.exp.is_Integer and p.free_symbols for p in entry.atoms(sp.Pow))


@pytest.mark.parametrize("seed", select_for_suite((3,), range(24)))
@pytest.mark.whole
def test_symbolic_points_on_parallel_axes_give_no_roots(seed: int) -> None:
    """Two symbolic offsets across parallel axes make their distance a root, which must not appear in the results.

    Axes and point keep the form of the input, and the position agrees with a computation from the axes alone.
    """
    stream = Stream(f"parallel/{seed}")
    first, second = (sp.Matrix(stream.choice(DIRECTIONS)) for _ in range(2))
    h = sp.Symbol("h1")
    axes = []
    for k, direction in enumerate([first] * 3 + ([second] if seed % 2 else [])):
        unit = direction * (-1 if seed > 3 and k == 1 else 1) / direction.norm()
        axes.append(Axis("R", unit, sp.Matrix(stream.choice([(k * A1, A2, 0), (A1, h * k, A2), (A1 + A2 * k, 0, h)]))))
    point = sp.Matrix([A1 + A2, h, A1])
    base, joints, tool = convert_axes(axes, point, len(axes))
    chain = Chain(f"parallel{seed}", joints, ("vx", "vy", "vz"), base, tool, convention="screws")
    home_axes, home_point = compute_home_geometry(chain)
    for home, axis in zip(home_axes, axes, strict=True):
        assert sp.simplify(home.direction - axis.direction).is_zero_matrix
        assert sp.simplify((home.point - axis.point).cross(axis.direction)).is_zero_matrix
        assert not any(map(_has_symbolic_root, home.point))
    assert (home_point - point).applyfunc(sp.expand).is_zero_matrix
    assert not any(map(_has_symbolic_root, (*derive(chain).position, *derive(chain).geometric_jacobian)))
    q = np.array([stream.uniform(-2, 2) for _ in axes])
    lengths = {A1: 0.7, A2: 0.3, h: 0.45}
    at = {**lengths, **dict(zip(chain.q, q, strict=True))}
    expected = move_point_along_axes(axes, point, q, lengths)
    assert np.allclose(np.array(derive(chain).position.xreplace(at).evalf(), dtype=float).ravel(), expected, atol=1e-12)


@pytest.mark.parametrize(
    "value",
    ["3/sqrt(41)", "9/164000", "1/7", "0.1234567891", "sqrt(9/16400)", "1/20 + 17*sqrt(2)/40", "sqrt(3)/2 - sqrt(6)/8"],
)
def test_exact_form_of_number_is_recognized(value: str) -> None:
    exact = sp.nsimplify(value, rational=True)
    assert sp.simplify(recognize_exact(exact.n(80)) - exact) == 0


def test_number_without_simple_form_is_rounded() -> None:
    assert recognize_exact(sp.sin(sp.S.One)) == sp.Rational("0.8414709848")


TINY = PRECISE_CONTEXT.mpf("1e-31")
MATRICES = {
    "regular": [[2, 1], [1, 3]],
    "first pivot is rounding": [[TINY, 1, 0], [1, 1, 0], [0, 2, 5]],
    "second pivot is rounding": [[1, 2, 3], [2, 4 + TINY, 1], [1, 0, 1]],
    "rows in the wrong order": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
}


@pytest.mark.parametrize("name", MATRICES)
def test_linear_algebra_agrees_with_mpmath(name: str) -> None:
    rows = [[PRECISE_CONTEXT.mpf(value) for value in row] for row in MATRICES[name]]
    n, matrix = len(rows), PRECISE_CONTEXT.matrix(rows)
    right = [PRECISE_CONTEXT.mpf(i + 1) for i in range(n)]
    solution = PRECISE_CONTEXT.matrix(solve_linear(rows, right))
    assert PRECISE_CONTEXT.norm(matrix * solution - PRECISE_CONTEXT.matrix(right)) < 1e-25
    assert PRECISE_CONTEXT.norm(matrix * PRECISE_CONTEXT.matrix(compute_inverse(rows)) - PRECISE_CONTEXT.eye(n)) < 1e-25
    assert abs(compute_determinant(rows) - PRECISE_CONTEXT.det(matrix)) < 1e-25


def test_singular_matrix_has_zero_determinant_and_no_inverse() -> None:
    rows = [[mpmath.mpf(1), mpmath.mpf(2)], [mpmath.mpf(2), mpmath.mpf(4)]]
    assert compute_determinant(rows) == 0 and compute_determinant([[0, 0], [0, 0]]) == 0
    with pytest.raises(ZeroDivisionError):
        compute_inverse(rows)


THREE = Chain("3R", tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2, 3)), ("vx", "vy"))
FLAT = Chain("2R", THREE.joints[:2], ("vx", "vz"))


@pytest.mark.parametrize(
    ("chain", "derive_from", "message"),
    [
        (THREE, lambda d: d.determinant, "2 x 3"), (THREE, lambda d: d.inverse, "2 x 3"),
        (THREE, lambda d: d.derive_rate_law(), "2 x 3"), (FLAT, lambda d: d.inverse, "det J = 0 everywhere"),
        (FLAT, lambda d: d.derive_rate_law(), "det J = 0 everywhere"),
    ],
)  # fmt: skip
def test_jacobian_without_inverse_is_refused(
    chain: Chain, derive_from: Callable[[Derivation], object], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        derive_from(derive(chain))
