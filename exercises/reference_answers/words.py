"""An answer in words, which a person marks."""

from dataclasses import dataclass

from qdot.exercises.formula.printers.python import FormulaToCode, print_python
from qdot.exercises.reference_answers.base import Answer


@dataclass(frozen=True)
class Words(Answer):
    """An answer in words. qdot stores and shows it, but never decides its points."""

    type = "text"
    takes_symbols = False
    typed_form = "a text"

    def list_formulas(self) -> list[str]:
        """Return no formulas."""
        return []

    def as_json(self) -> str:
        """Return nothing, because there is no reference."""
        return ""

    def as_typed(self) -> str:
        """Return nothing, because there is no reference."""
        return ""

    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return a note that a person marks the answer, as a text."""
        return '"(A person marks this answer.)"'

    def write_placeholder(self, prefix_width: int = 0) -> str:
        """Return a blank text over several lines."""
        return '"""\nblank\n"""'
