"""Arms by their axes: their table holds the numbers exactly; linear algebra in thirty digits chooses its pivots."""

import mpmath
import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.axes_to_dh import Axis, move_point_along_axes, recognize_exact
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.mpmath_kinematics import PRECISE_CONTEXT, determinant, inverse, solve_linear
from qdot.exercises.arm.standard_table import dh_of_axes, home_geometry_of
from qdot.exercises.common.stream import Stream
from tests.support.suites import select_for_suite

WAYS = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0, 3, 4), (1, 2, 2), (1, -1, 1), (0, 1, 1), (2, 3, 6), (1, 2, 3))
A1, A2 = sp.symbols("a1 a2")
LENGTHS = {A1: sp.Rational(7, 10), A2: sp.Rational(3, 10)}


@pytest.mark.parametrize("seed", range(select_for_suite(5, 12)))
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
    base, joints, tool = dh_of_axes(axes, point, len(axes))
    found, there = home_geometry_of(Chain("oblique", joints, ("vx",), base, tool))
    gone = [there - point, *(one.direction - axis.direction for one, axis in zip(found, axes, strict=True))]
    gone += [(f.point - a.point).cross(a.direction) for f, a in zip(found, axes, strict=True) if a.is_revolute]
    assert all(abs(sp.N(entry.xreplace(LENGTHS), 40)) < 1e-30 for vector in gone for entry in vector)


def _has_open_root(entry: sp.Expr) -> bool:
    return entry.has(sp.atan2) or any(not p.exp.is_Integer and p.free_symbols for p in entry.atoms(sp.Pow))


@pytest.mark.parametrize("seed", select_for_suite((3,), range(24)))
@pytest.mark.whole
def test_open_places_of_parallel_axes_have_no_roots(seed: int) -> None:
    """Two lengths are open across parallel axes: their distance is a root, and so was all that came out of the table.

    Where the axes and the point are is told as it was given, and where the arm goes is what its axes alone say.
    """
    stream = Stream(f"parallel/{seed}")
    first, second = (sp.Matrix(stream.choice(WAYS)) for _ in range(2))
    h = sp.Symbol("h1")
    axes = []
    for k, along in enumerate([first] * 3 + ([second] if seed % 2 else [])):
        way = along * (-1 if seed > 3 and k == 1 else 1) / along.norm()
        axes.append(Axis("R", way, sp.Matrix(stream.choice([(k * A1, A2, 0), (A1, h * k, A2), (A1 + A2 * k, 0, h)]))))
    point = sp.Matrix([A1 + A2, h, A1])
    base, joints, tool = dh_of_axes(axes, point, len(axes))
    chain = Chain(f"parallel{seed}", joints, ("vx", "vy", "vz"), base, tool, convention="screws")
    found, there = home_geometry_of(chain)
    for one, axis in zip(found, axes, strict=True):
        assert sp.simplify(one.direction - axis.direction).is_zero_matrix
        assert sp.simplify((one.point - axis.point).cross(axis.direction)).is_zero_matrix
        assert not any(map(_has_open_root, one.point))
    assert (there - point).applyfunc(sp.expand).is_zero_matrix
    assert not any(map(_has_open_root, (*derive(chain).position, *derive(chain).geometric)))
    q = np.array([stream.uniform(-2, 2) for _ in axes])
    lengths = {A1: 0.7, A2: 0.3, h: 0.45}
    at = {**lengths, **dict(zip(chain.q, q, strict=True))}
    place = move_point_along_axes(axes, point, q, lengths)
    assert np.allclose(np.array(derive(chain).position.xreplace(at).evalf(), dtype=float).ravel(), place, atol=1e-12)


@pytest.mark.parametrize(
    "value",
    ["3/sqrt(41)", "9/164000", "1/7", "0.1234567891", "sqrt(9/16400)", "1/20 + 17*sqrt(2)/40", "sqrt(3)/2 - sqrt(6)/8"],
)
def test_a_number_is_told_as_what_it_is(value: str) -> None:
    exact = sp.nsimplify(value, rational=True)
    assert sp.simplify(recognize_exact(exact.n(80)) - exact) == 0


def test_a_number_of_no_simple_form_is_rounded() -> None:
    assert recognize_exact(sp.sin(sp.S.One)) == sp.Rational("0.8414709848")


TINY = PRECISE_CONTEXT.mpf("1e-31")
MATRICES = {
    "regular": [[2, 1], [1, 3]],
    "first pivot is rounding": [[TINY, 1, 0], [1, 1, 0], [0, 2, 5]],
    "second pivot is rounding": [[1, 2, 3], [2, 4 + TINY, 1], [1, 0, 1]],
    "rows in the wrong order": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
}


@pytest.mark.parametrize("name", MATRICES)
def test_solutions_inverses_and_determinants_are_mpmaths(name: str) -> None:
    rows = [[PRECISE_CONTEXT.mpf(value) for value in row] for row in MATRICES[name]]
    n, matrix = len(rows), PRECISE_CONTEXT.matrix(rows)
    right = [PRECISE_CONTEXT.mpf(i + 1) for i in range(n)]
    assert (
        PRECISE_CONTEXT.norm(matrix * PRECISE_CONTEXT.matrix(solve_linear(rows, right)) - PRECISE_CONTEXT.matrix(right))
        < 1e-25
    )
    assert PRECISE_CONTEXT.norm(matrix * PRECISE_CONTEXT.matrix(inverse(rows)) - PRECISE_CONTEXT.eye(n)) < 1e-25
    assert abs(determinant(rows) - PRECISE_CONTEXT.det(matrix)) < 1e-25


def test_a_singular_matrix_has_determinant_zero_and_no_inverse() -> None:
    rows = [[mpmath.mpf(1), mpmath.mpf(2)], [mpmath.mpf(2), mpmath.mpf(4)]]
    assert determinant(rows) == 0 and determinant([[0, 0], [0, 0]]) == 0
    with pytest.raises(ZeroDivisionError):
        inverse(rows)
