"""Define the answers that are letters of options: one correct option, several, or one for each item."""

from dataclasses import dataclass

from qdot.exercises.answer_types.base import Answer, AnswerVisitor, Json, T
from qdot.exercises.formula.printers.python import FormulaToCode, python_text

LETTERS = "ABCDEFGH"
"""The letters that label the options, in order."""

TRUE_FALSE = ("true", "false")
"""The options of a statement that is true or false."""


class Letters(Answer):
    """An answer given by letters: `options` are labelled A, B, C … in their order."""

    options: tuple[str, ...]
    correct: int | tuple[int, ...]
    takes_symbols = False
    is_one_line = True
    typed_form = "letters, or true or false"

    @property
    def offered_options(self) -> tuple[str, ...]:
        """The options."""
        return self.options

    @property
    def correct_indices(self) -> tuple[int, ...]:
        """The correct options, counted from 0; in the order of the items if there are items."""
        return self.correct if isinstance(self.correct, tuple) else (self.correct,)

    @property
    def letters(self) -> str:
        """The letters of the correct options: in their order, as in "ACD", or in that of the items, as in "BAC"."""
        return "".join(LETTERS[index] for index in self.correct_indices)

    def formulas(self) -> list[str]:
        """Return no formulas, because the answer consists of letters."""
        return []

    def as_json(self) -> str | list[str]:
        """Return each letter."""
        return list(self.letters)

    def options_json(self) -> Json:
        """Return the options."""
        return {"options": list(self.options)}

    def as_typed(self) -> str:
        """Return the letters."""
        return self.letters

    def code(self, used_columns: int = 0, format_formula: FormulaToCode = python_text) -> str:
        """Return the letters in quotes."""
        return f'"{self.letters}"'

    def placeholder(self, used_columns: int = 0) -> str:
        """Return a string, because a string is expected."""
        return '"blank"'


@dataclass(frozen=True)
class Choice(Letters):
    """One correct option out of several; the options are labelled A, B, C … in this order."""

    options: tuple[str, ...]
    correct: int

    type = "choice"

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for one correct option."""
        return visitor.choice(self)

    @property
    def letter(self) -> str:
        """The letter of the correct option."""
        return LETTERS[self.correct]

    @property
    def typed_text(self) -> str:
        """The text to type for the correct option: its letter, or true or false."""
        return self.options[self.correct] if self.options == TRUE_FALSE else self.letter

    def as_json(self) -> str:
        """Return the letter."""
        return self.letter

    def code(self, used_columns: int = 0, format_formula: FormulaToCode = python_text) -> str:
        """Return the text to type, in quotes."""
        return f'"{self.typed_text}"'


@dataclass(frozen=True)
class Selection(Letters):
    """All correct options, one or more, out of several."""

    options: tuple[str, ...]
    correct: tuple[int, ...]

    type = "selection"

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for several correct options."""
        return visitor.selection(self)


@dataclass(frozen=True)
class Matching(Letters):
    """An option for each item; no option belongs to two items, and an option may belong to no item."""

    items: tuple[str, ...]
    options: tuple[str, ...]
    correct: tuple[int, ...]

    type = "matching"

    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for an option for each item."""
        return visitor.matching(self)

    @property
    def matched_items(self) -> tuple[str, ...]:
        """The items."""
        return self.items

    def options_json(self) -> Json:
        """Return the options and the items."""
        return {"options": list(self.options), "items": list(self.items)}
