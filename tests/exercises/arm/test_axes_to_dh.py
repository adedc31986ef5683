"""DH tables from joint axes are exact; linear algebra in thirty digits chooses good pivots."""

import mpmath
import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.axes_to_dh import Axis, move_point_along_axes, recognize_exact
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.mpmath_kinematics import PRECISE_CONTEXT, determinant, inverse, solve_linear
from qdot.exercises.arm.standard_table import compute_home_geometry, convert_axes
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from tests.support.suites import select_for_suite

DIRECTIONS = (
    (0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 3, 4), (1, 2, 2), (1, -1, 1), (0, 1, 1), (2, 3, 6), (1, 2, 3),
)  # fmt: skip
A1, A2 = sp.symbols("a1 a2")
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
    assert PRECISE_CONTEXT.norm(matrix * PRECISE_CONTEXT.matrix(inverse(rows)) - PRECISE_CONTEXT.eye(n)) < 1e-25
    assert abs(determinant(rows) - PRECISE_CONTEXT.det(matrix)) < 1e-25


def test_singular_matrix_has_zero_determinant_and_no_inverse() -> None:
    rows = [[mpmath.mpf(1), mpmath.mpf(2)], [mpmath.mpf(2), mpmath.mpf(4)]]
    assert determinant(rows) == 0 and determinant([[0, 0], [0, 0]]) == 0
    with pytest.raises(ZeroDivisionError):
        inverse(rows)
