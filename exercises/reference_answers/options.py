"""Answers by letters of options: one correct option, several correct options, or one option for each item."""

from dataclasses import dataclass

from qdot.exercises.formula.printers.python import FormulaToCode, print_python
from qdot.exercises.reference_answers.base import Answer, Json

LETTERS = "ABCDEFGH"
"""The letters that label the options, in order."""

TRUE_FALSE = ("true", "false")
"""The options of a question that asks whether a statement is true."""


class Letters(Answer):
    """An answer given by letters: `options` are labelled A, B, C … in their order."""

    options: tuple[str, ...]
    correct: int | tuple[int, ...]

    group = "letters"
    takes_symbols = False
    is_one_line = True
    typed_form = "letters, or true or false"

    @property
    def offered_options(self) -> tuple[str, ...]:
        """The options."""
        return self.options

    @property
    def correct_indices(self) -> tuple[int, ...]:
        """The indices of the correct options, from 0; if there are items, one index for each item, in their order."""
        return self.correct if isinstance(self.correct, tuple) else (self.correct,)

    @property
    def letters(self) -> str:
        """The letters of the correct options, as in "ACD"; if there are items, in their order, as in "BAC"."""
        return "".join(LETTERS[index] for index in self.correct_indices)

    def list_formulas(self) -> list[str]:
        """Return no formulas, because the answer consists of letters."""
        return []

    def as_json(self) -> str | list[str]:
        """Return each letter."""
        return list(self.letters)

    def to_options_json(self) -> Json:
        """Return the options."""
        return {"options": list(self.options)}

    def as_typed(self) -> str:
        """Return the letters."""
        return self.letters

    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return the letters in quotes."""
        return f'"{self.letters}"'

    def write_placeholder(self, prefix_width: int = 0) -> str:
        """Return `blank` in quotes, because letters are typed in quotes."""
        return '"blank"'


@dataclass(frozen=True)
class Choice(Letters):
    """One correct option out of several."""

    options: tuple[str, ...]
    correct: int

    type = "choice"

    @property
    def typed_text(self) -> str:
        """The text to type for the correct option: its letter, or true or false."""
        return self.options[self.correct] if self.options == TRUE_FALSE else self.letters

    def as_json(self) -> str:
        """Return the letter."""
        return self.letters

    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return the text to type, in quotes."""
        return f'"{self.typed_text}"'


@dataclass(frozen=True)
class Selection(Letters):
    """All correct options, one or more, out of several."""

    options: tuple[str, ...]
    correct: tuple[int, ...]

    type = "selection"


@dataclass(frozen=True)
class Matching(Letters):
    """One option for each item. No option belongs to two items, and some options may belong to no item."""

    items: tuple[str, ...]
    options: tuple[str, ...]
    correct: tuple[int, ...]

    type = "matching"

    @property
    def matched_items(self) -> tuple[str, ...]:
        """The items."""
        return self.items

    def to_options_json(self) -> Json:
        """Return the options and the items."""
        return {"options": list(self.options), "items": list(self.items)}
