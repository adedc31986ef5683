"""Numbers, each with its unit."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answers.base import Answer, Json, rows_typed
from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.formula.identity import Rounding
from qdot.exercises.formula.printers.python import Write, matrix_code, python_text
from qdot.exercises.formula.text import rows_of_text, text_of


@dataclass(frozen=True)
class Number(Answer):
    """Numbers with a unit each, right within `tolerance` (relative; `floor` is an absolute least allowance)."""

    reference: sp.Matrix
    units: tuple[str, ...]
    tolerance: float
    floor: float

    type = "number"
    takes_symbols = False

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of numbers."""
        return forms.numbers(self)

    @property
    def is_in_numbers(self) -> bool:
        """They are."""
        return True

    def as_matrix(self) -> sp.Matrix:
        """Return the numbers in a column."""
        return sp.Matrix(self.reference)

    @property
    def shape(self) -> tuple[int, int]:
        """How many there are, and one column."""
        return (self.reference.rows, self.reference.cols)

    def allowed(self, rounding: Rounding | None) -> tuple[float, float]:
        """Return the relative tolerance and the absolute least allowance, as the assignment's rounding has them."""
        if rounding is None:
            return self.tolerance, self.floor
        # An allowance for values near zero belongs to the digits that are wanted.
        return rounding.relative, rounding.absolute + self.floor * rounding.relative / self.tolerance

    def room(self, rounding: Rounding | None) -> list[float]:
        """Return what each number may be off."""
        tolerance, floor = self.allowed(rounding)
        return [max(tolerance * abs(float(value)), floor) for value in self.reference]

    @property
    def units_due(self) -> tuple[str, ...]:
        """The unit of each."""
        return self.units

    @property
    def is_one_line(self) -> bool:
        """Whether it is one number."""
        return len(self.reference) == 1

    def formulas(self) -> list[str]:
        """Return the text of each number."""
        return [text_of(value) for value in self.reference]

    def as_json(self) -> list[str]:
        """Return each number with ten digits."""
        return [f"{float(value):.10g}" if value.is_number else str(value) for value in self.reference]

    def allowance_json(self) -> Json:
        """Return units, relative tolerance, and absolute least allowance."""
        return {"units": list(self.units), "tolerance": self.tolerance, "floor": self.floor}

    def as_typed(self) -> str:
        """Return the numbers in brackets."""
        return rows_typed(rows_of_text(self.reference))

    def code(self, taken: int = 0, write: Write = python_text) -> str:
        """Return the number, or a column of them."""
        texts = [write(value) for value in self.reference]
        return texts[0] if len(texts) == 1 else matrix_code([[text] for text in texts], taken)

    def placeholder(self, taken: int = 0) -> str:
        """Return `blank`, or a column of it."""
        return "blank" if self.is_one_line else matrix_code([["blank"]] * len(self.reference), taken)
