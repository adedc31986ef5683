"""Linear algebra in thirty digits: it must choose its pivots, for an entry that should be zero is 1e-31 of rounding."""

import mpmath
import pytest

from exercises.arm.precise import PRECISE, determinant, inverse, solved

TINY = PRECISE.mpf("1e-31")
MATRICES = {
    "regular": [[2, 1], [1, 3]],
    "first pivot is rounding": [[TINY, 1, 0], [1, 1, 0], [0, 2, 5]],
    "second pivot is rounding": [[1, 2, 3], [2, 4 + TINY, 1], [1, 0, 1]],
    "rows in the wrong order": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
}


@pytest.mark.parametrize("name", MATRICES)
def test_solutions_inverses_and_determinants_are_mpmaths(name: str) -> None:
    rows = [[PRECISE.mpf(value) for value in row] for row in MATRICES[name]]
    n, matrix = len(rows), PRECISE.matrix(rows)
    right = [PRECISE.mpf(i + 1) for i in range(n)]
    assert PRECISE.norm(matrix * PRECISE.matrix(solved(rows, right)) - PRECISE.matrix(right)) < 1e-25
    assert PRECISE.norm(matrix * PRECISE.matrix(inverse(rows)) - PRECISE.eye(n)) < 1e-25
    assert abs(determinant(rows) - PRECISE.det(matrix)) < 1e-25


def test_a_singular_matrix_has_determinant_zero_and_no_inverse() -> None:
    rows = [[mpmath.mpf(1), mpmath.mpf(2)], [mpmath.mpf(2), mpmath.mpf(4)]]
    assert determinant(rows) == 0 and determinant([[0, 0], [0, 0]]) == 0
    with pytest.raises(ZeroDivisionError):
        inverse(rows)
