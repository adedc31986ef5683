"""A vector that counts up to a factor other than zero."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.answers.rows import Rows
from qdot.exercises.formula.identity import Rounding


@dataclass(frozen=True)
class Direction(Rows):
    """A vector that counts up to a factor other than zero; `tolerance` is relative, None where it is a formula."""

    reference: sp.Matrix
    tolerance: float | None = None

    type = "direction"
    counts_up_to_a_factor = True

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of a direction."""
        return forms.direction(self)

    def apart(self, rounding: Rounding | None) -> float | None:
        """Return by how much unit vectors may differ, as the assignment's rounding has it; None of formulas."""
        if self.tolerance is None or rounding is None:
            return self.tolerance
        return rounding.relative or rounding.absolute

    @property
    def is_in_numbers(self) -> bool:
        """Whether it is asked for at a configuration."""
        return self.tolerance is not None
