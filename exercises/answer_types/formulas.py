"""Answers in formulas and numbers: one formula, matrices and vectors, numbers with units, directions, conditions."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Any

import sympy as sp

from qdot.exercises.answer_types.base import Answer, AnswerVisitor, Json, T
from qdot.exercises.formula.equality import Rounding
from qdot.exercises.formula.printers.python import FormulaToCode, bracket_long_text, list_code, matrix_code, python_text
from qdot.exercises.formula.sympy_text import expression_text, matrix_json, matrix_rows_as_text
from qdot.exercises.singularities.singularity import Component


@dataclass(frozen=True)
class Expression(Answer):
    """One formula."""

    reference: sp.Expr

    type = "expression"
    is_exact = True
    is_one_line = True
    is_symbolic = True

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for one formula."""
        return visitor.formula(self)

    def as_matrix(self) -> sp.Matrix:
        """Return the formula as a 1 x 1 matrix."""
        return sp.Matrix([self.reference])

    def entries(self) -> list[sp.Expr]:
        """Return the formula."""
        return [self.reference]

    def formulas(self) -> list[str]:
        """Return the formula's text."""
        return [expression_text(self.reference)]

    def as_json(self) -> str:
        """Return the formula's text."""
        return expression_text(self.reference)

    as_typed = as_json

    def code(self, used_columns: int = 0, format_formula: FormulaToCode = python_text) -> str:
        """Return the formula, on several lines in brackets if it is long."""
        return bracket_long_text(format_formula(self.reference), used_columns)


class RowsAnswer(Answer):
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
        return [expression_text(entry) for entry in self.reference]

    def as_json(self) -> list[Any]:
        """Return a list of rows, or of the entries of a vector."""
        return matrix_json(self.reference)

    def as_typed(self) -> str:
        """Return the rows in brackets."""
        return type_rows(matrix_rows_as_text(self.reference))

    def code(self, used_columns: int = 0, format_formula: FormulaToCode = python_text) -> str:
        """Return `Matrix([[…], […]])`, one row per line if it is long."""
        return matrix_code([[format_formula(entry) for entry in row] for row in self.reference.tolist()], used_columns)

    def placeholder(self, used_columns: int = 0) -> str:
        """Return the matrix with `blank` as each entry."""
        return matrix_code([["blank"] * self.reference.cols] * self.reference.rows, used_columns)


def type_rows(rows: list[list[str]]) -> str:
    """Return rows of text in the form in which a matrix is typed."""
    return "[" + ", ".join(f"[{', '.join(row)}]" for row in rows) + "]"


@dataclass(frozen=True)
class Matrix(RowsAnswer):
    """A matrix or (one column) a vector, graded by entry."""

    reference: sp.Matrix

    type = "matrix"
    is_exact = True
    is_symbolic = True

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for a matrix."""
        return visitor.matrix(self)


@dataclass(frozen=True)
class Direction(RowsAnswer):
    """A vector that is correct up to a nonzero factor; `tolerance` is relative, None for a symbolic vector."""

    reference: sp.Matrix
    tolerance: float | None = None

    type = "direction"
    counts_up_to_a_factor = True

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for a direction."""
        return visitor.direction(self)

    def tolerance_with(self, rounding: Rounding | None) -> float | None:
        """Return the tolerance for unit vectors under the assignment's rounding; None for a symbolic vector."""
        if self.tolerance is None or rounding is None:
            return self.tolerance
        return rounding.relative or rounding.absolute

    @property
    def is_numeric(self) -> bool:
        """Whether the vector is numeric: asked for at one configuration."""
        return self.tolerance is not None


@dataclass(frozen=True)
class Number(RowsAnswer):
    """Numbers with units, correct within the relative error `tolerance`, or within the absolute error `floor`."""

    reference: sp.Matrix
    units: tuple[str, ...]
    tolerance: float
    floor: float

    type = "number"
    takes_symbols = False
    is_numeric = True

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for numbers."""
        return visitor.numbers(self)

    def tolerance_and_floor(self, rounding: Rounding | None) -> tuple[float, float]:
        """Return the relative and the absolute error allowed, under the assignment's rounding; the larger counts."""
        if rounding is None:
            return self.tolerance, self.floor
        # The error allowed near zero scales with the required number of digits.
        return rounding.relative, rounding.absolute + self.floor * rounding.relative / self.tolerance

    def allowed_errors(self, rounding: Rounding | None) -> list[float]:
        """Return the absolute error allowed for each number."""
        tolerance, floor = self.tolerance_and_floor(rounding)
        return [max(tolerance * abs(float(value)), floor) for value in self.reference]

    @property
    def expected_units(self) -> tuple[str, ...]:
        """The unit of each number."""
        return self.units

    @property
    def is_one_line(self) -> bool:
        """Whether the answer is a single number."""
        return len(self.reference) == 1

    def entries(self) -> list[sp.Expr]:
        """Return nothing: numbers are not compared as formulas."""
        return []

    def as_json(self) -> list[str]:
        """Return each number with ten digits."""
        return [f"{float(value):.10g}" if value.is_number else str(value) for value in self.reference]

    def tolerance_json(self) -> Json:
        """Return the units, and the relative and the absolute error allowed."""
        return {"units": list(self.units), "tolerance": self.tolerance, "floor": self.floor}

    def code(self, used_columns: int = 0, format_formula: FormulaToCode = python_text) -> str:
        """Return the number, or a column of numbers."""
        return format_formula(self.reference[0]) if self.is_one_line else super().code(used_columns, format_formula)

    def placeholder(self, used_columns: int = 0) -> str:
        """Return `blank`, or a column of blanks."""
        return "blank" if self.is_one_line else super().placeholder(used_columns)


@dataclass(frozen=True)
class ConditionSet(Answer):
    """A set of configurations, as conditions on the joints."""

    components: tuple[Component, ...]

    type = "singular"
    is_exact = True
    is_set = True
    typed_form = "a list of conditions"

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for conditions."""
        return visitor.conditions(self)

    def pieces(self) -> list[str]:
        """Return every piece of the set as text: a value of a joint, or conditions that hold simultaneously."""
        return [piece for component in self.components for piece in component.pieces()]

    formulas = as_json = pieces

    def group_by_condition(self, pieces: Sequence[T]) -> list[list[T]]:
        """Group a sequence with an item for each piece of the set by the components to which the pieces belong."""
        remaining = iter(pieces)
        return [list(islice(remaining, len(component.pieces()))) for component in self.components]

    def as_typed(self) -> str:
        """Return the pieces in brackets."""
        return f"[{', '.join(self.pieces())}]"

    def code(self, used_columns: int = 0, format_formula: FormulaToCode = python_text) -> str:
        """Return a list of `Eq` and `And`, one for each value or combination of values."""
        alternatives = (_list_alternatives(component, format_formula) for component in self.components)
        return list_code([text for texts in alternatives for text in texts], used_columns)

    def placeholder(self, used_columns: int = 0) -> str:
        """Return a list with one blank."""
        return "[blank]"


def _list_alternatives(component: Component, format_formula: FormulaToCode) -> list[str]:
    """Return the conditions of a component, one text for each value or combination of values."""
    if component.solutions is None:
        equations = [[f"Eq({format_formula(condition)}, 0)"] for condition in component.conditions]
    else:
        equations = [
            [f"Eq({joint}, {format_formula(value)})" for value in values] for joint, values in component.solutions
        ]
    return [chosen[0] if len(chosen) == 1 else f"And({', '.join(chosen)})" for chosen in product(*equations)]
