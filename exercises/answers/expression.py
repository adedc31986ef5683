"""One formula."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answers.base import Answer
from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.formula.printers.python import Write, bracketed, python_text
from qdot.exercises.formula.text import text_of


@dataclass(frozen=True)
class Expression(Answer):
    """One formula."""

    reference: sp.Expr

    type = "expression"
    is_exact = True

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of a formula."""
        return forms.formula(self)

    @property
    def is_one_line(self) -> bool:
        """It is."""
        return True

    @property
    def is_formulas(self) -> bool:
        """It is one."""
        return True

    def as_matrix(self) -> sp.Matrix:
        """Return the formula as the only entry."""
        return sp.Matrix([self.reference])

    def entries(self) -> list[sp.Expr]:
        """Return the formula."""
        return [self.reference]

    def formulas(self) -> list[str]:
        """Return the formula's text."""
        return [text_of(self.reference)]

    def as_json(self) -> str:
        """Return the formula's text."""
        return text_of(self.reference)

    def as_typed(self) -> str:
        """Return the formula's text."""
        return text_of(self.reference)

    def code(self, taken: int = 0, write: Write = python_text) -> str:
        """Return the formula, on several lines in brackets where it is long."""
        return bracketed(write(self.reference), taken)
