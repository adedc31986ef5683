"""Answers in formulas and numbers: one formula, matrices and vectors, numbers with units, directions, sets."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, product
from typing import Any, NamedTuple

import sympy as sp

from qdot.exercises.formula.equality import Rounding
from qdot.exercises.formula.printers.python import (
    FormulaToCode,
    bracket_long_text,
    print_python,
    write_list_code,
    write_matrix_code,
)
from qdot.exercises.formula.sympy_text import format_expression, format_matrix_rows, make_matrix_json
from qdot.exercises.reference_answers.base import Answer, Json, T
from qdot.exercises.singularities.singular_set import Component

COUNT_TOLERANCE = 1e-9
"""Relative and absolute error that is allowed for counts, which are exact apart from floating-point rounding."""


class _Formulas(Answer):
    """An answer whose formulas are the entries of a matrix."""

    def list_entries(self) -> list[sp.Expr]:
        """Return the entries row by row."""
        return list(self.as_matrix())

    def list_formulas(self) -> list[str]:
        """Return the text of each entry, row by row."""
        return [format_expression(entry) for entry in self.as_matrix()]


@dataclass(frozen=True)
class Expression(_Formulas):
    """One formula."""

    reference: sp.Expr

    type = "expression"
    group = "formulas"
    is_exact = True
    is_one_line = True
    is_symbolic = True

    def as_matrix(self) -> sp.Matrix:
        """Return the formula as a 1 x 1 matrix."""
        return sp.Matrix([self.reference])

    def as_json(self) -> str:
        """Return the formula's text."""
        return format_expression(self.reference)

    as_typed = as_json

    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return the formula; a long formula is put in brackets, on several lines."""
        return bracket_long_text(format_formula(self.reference), prefix_width)


class RowsAnswer(_Formulas):
    """An answer in rows and columns."""

    reference: sp.Matrix

    @property
    def shape(self) -> tuple[int, int]:
        """The numbers of rows and columns."""
        return (self.reference.rows, self.reference.cols)

    def as_matrix(self) -> sp.Matrix:
        """Return the matrix."""
        return sp.Matrix(self.reference)

    def as_json(self) -> list[Any]:
        """Return a list of rows, or of the entries of a vector."""
        return make_matrix_json(self.reference)

    def as_typed(self) -> str:
        """Return the rows in brackets."""
        return bracket_rows(format_matrix_rows(self.reference))

    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return `Matrix([[…], […]])`; a long matrix has one row per line."""
        return write_matrix_code(
            [[format_formula(entry) for entry in row] for row in self.reference.tolist()], prefix_width
        )

    def write_placeholder(self, prefix_width: int = 0) -> str:
        """Return the matrix with `blank` as each entry."""
        return write_matrix_code([["blank"] * self.reference.cols] * self.reference.rows, prefix_width)


def bracket_rows(rows: list[list[str]]) -> str:
    """Return rows of text in the form in which a matrix is typed: [[1, 0], [0, 1]]."""
    return "[" + ", ".join(f"[{', '.join(row)}]" for row in rows) + "]"


@dataclass(frozen=True)
class Matrix(RowsAnswer):
    """A matrix, or a vector as a matrix with one column. Each entry is graded."""

    reference: sp.Matrix

    type = "matrix"
    group = "formulas"
    is_exact = True
    is_symbolic = True


@dataclass(frozen=True)
class Direction(RowsAnswer):
    """A vector; every nonzero multiple of it is correct, too.

    `tolerance` is the relative error allowed for a vector of numbers; it is None for a vector of formulas.
    """

    reference: sp.Matrix
    tolerance: float | None = None

    type = "direction"
    is_direction = True

    def find_tolerance(self, rounding: Rounding | None) -> float | None:
        """Return the error that the assignment's rounding allows for unit vectors; None for a vector of formulas."""
        if self.tolerance is None or rounding is None:
            return self.tolerance
        return rounding.relative or rounding.absolute

    @property
    def is_numeric(self) -> bool:
        """Whether the vector consists of numbers, because the question asks for it at one configuration."""
        return self.tolerance is not None


class AllowedErrors(NamedTuple):
    """The allowed errors of numbers: one relative error, and an absolute error for each number.

    The larger one counts.
    """

    relative: float
    absolute: list[float]


@dataclass(frozen=True)
class Number(RowsAnswer):
    """Numbers with units, correct within the relative error `tolerance`, or within the absolute error `floor`.

    `floor` matters near zero, where a relative error allows nothing.
    """

    reference: sp.Matrix
    units: tuple[str, ...]
    tolerance: float
    floor: float

    type = "number"
    takes_symbols = False
    is_numeric = True

    @property
    def is_count(self) -> bool:
        """Whether the numbers are counts, which must be exact. The tolerances of all other numbers exceed 1e-6."""
        return self.tolerance < 1e-6

    def find_allowed_errors(self, rounding: Rounding | None) -> AllowedErrors:
        """Return the errors that the assignment's rounding allows."""
        count = len(self.reference)
        if rounding is None:
            return AllowedErrors(self.tolerance, count * [self.floor])
        # The error allowed near zero is proportional to the allowed relative error.
        floor_of_digits = self.floor * rounding.relative / self.tolerance
        absolute_errors = rounding.errors_of_entries or count * (rounding.absolute,)
        return AllowedErrors(rounding.relative, [error + floor_of_digits for error in absolute_errors])

    def list_allowed_errors(self, rounding: Rounding | None) -> list[float]:
        """Return the absolute error allowed for each number."""
        relative, absolute = self.find_allowed_errors(rounding)
        values = map(float, self.reference)
        return [max(relative * abs(value), error) for value, error in zip(values, absolute, strict=True)]

    @property
    def expected_units(self) -> tuple[str, ...]:
        """The unit of each number."""
        return self.units

    @property
    def is_one_line(self) -> bool:
        """Whether the answer is a single number."""
        return len(self.reference) == 1

    def list_entries(self) -> list[sp.Expr]:
        """Return no entries: numbers are not compared as functions."""
        return []

    def as_json(self) -> list[str]:
        """Return each number with ten digits."""
        return [f"{float(value):.10g}" if value.is_number else str(value) for value in self.reference]

    def to_tolerance_json(self) -> Json:
        """Return the units, and the relative and the absolute error allowed."""
        return {"units": list(self.units), "tolerance": self.tolerance, "floor": self.floor}

    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return the number, or a column of numbers."""
        write = super().write_code
        return format_formula(self.reference[0]) if self.is_one_line else write(prefix_width, format_formula)

    def write_placeholder(self, prefix_width: int = 0) -> str:
        """Return `blank`, or a column of blanks."""
        return "blank" if self.is_one_line else super().write_placeholder(prefix_width)


@dataclass(frozen=True)
class ConditionSet(Answer):
    """A set of configurations: those that satisfy the conditions of at least one component.

    `is_singular_set` says whether these are the arm's singular configurations.
    """

    components: tuple[Component, ...]
    is_singular_set: bool = True

    type = "singular"
    is_exact = True
    is_set = True
    typed_form = "a list of conditions"

    def list_pieces(self) -> list[str]:
        """Return every piece of the set as text: a value of a joint, or conditions that must hold simultaneously."""
        return [piece for component in self.components for piece in component.list_pieces()]

    list_formulas = as_json = list_pieces

    def group_by_component(self, items: Sequence[T]) -> list[list[T]]:
        """Group items by component; there is one item for each piece of the set."""
        remaining_items = iter(items)
        return [list(islice(remaining_items, len(component.list_pieces()))) for component in self.components]

    def as_typed(self) -> str:
        """Return the pieces in brackets."""
        return f"[{', '.join(self.list_pieces())}]"

    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return a list of `Eq` and `And`, one for each value or combination of values."""
        alternatives = (_list_alternatives(component, format_formula) for component in self.components)
        return write_list_code([text for texts in alternatives for text in texts], prefix_width)

    def write_placeholder(self, prefix_width: int = 0) -> str:
        """Return a list with one blank."""
        return "[blank]"


def _list_alternatives(component: Component, format_formula: FormulaToCode) -> list[str]:
    """Return the code of a component's conditions: one text for each value, or for each combination of values."""
    if component.solutions is None:
        equations = [[f"Eq({format_formula(condition)}, 0)"] for condition in component.conditions]
    else:
        solutions = component.solutions
        equations = [[f"Eq({joint}, {format_formula(value)})" for value in values] for joint, values in solutions]
    combinations = product(*equations)
    return [texts[0] if len(texts) == 1 else f"And({', '.join(texts)})" for texts in combinations]
