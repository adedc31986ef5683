"""What matrices and directions have in common: formulas in rows and columns."""

from typing import Any

import sympy as sp

from qdot.exercises.answers.base import Answer, rows_typed
from qdot.exercises.formula.printers.python import Write, matrix_code, python_text
from qdot.exercises.formula.text import matrix_json, rows_of_text, text_of


class Rows(Answer):
    """An answer in rows and columns."""

    reference: sp.Matrix

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return (self.reference.rows, self.reference.cols)

    def as_matrix(self) -> sp.Matrix:
        """Return the matrix."""
        return sp.Matrix(self.reference)

    def entries(self) -> list[sp.Expr]:
        """Return the entries row by row."""
        return list(self.reference)

    def formulas(self) -> list[str]:
        """Return the text of each entry, row by row."""
        return [text_of(entry) for entry in self.reference]

    def as_json(self) -> list[Any]:
        """Return a list of rows, or of the entries of a vector."""
        return matrix_json(self.reference)

    def as_typed(self) -> str:
        """Return the rows in brackets."""
        return rows_typed(rows_of_text(self.reference))

    def code(self, taken: int = 0, write: Write = python_text) -> str:
        """Return `Matrix([[…], […]])`, one row a line where it is long."""
        return matrix_code([[write(entry) for entry in row] for row in self.reference.tolist()], taken)

    def placeholder(self, taken: int = 0) -> str:
        """Return the matrix with `blank` in each place."""
        rows, columns = self.shape
        return matrix_code([["blank"] * columns] * rows, taken)
