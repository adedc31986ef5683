"""A matrix of formulas, or a vector of them in one column."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.answers.rows import Rows


@dataclass(frozen=True)
class Matrix(Rows):
    """A matrix or (one column) a vector, marked by entry."""

    reference: sp.Matrix

    type = "matrix"
    is_exact = True

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of a matrix."""
        return forms.matrix(self)

    @property
    def is_formulas(self) -> bool:
        """It is."""
        return True
