"""What the types have in common whose answer is the letters of options."""

from abc import abstractmethod

from qdot.exercises.answers.base import Answer, Json
from qdot.exercises.formula.printers.python import Write, python_text

LETTERS = "ABCDEFGH"
"""Under which options are shown."""


class Letters(Answer):
    """An answer in letters: `options` are shown in their order under A, B, C …"""

    options: tuple[str, ...]
    takes_symbols = False

    @property
    def offered(self) -> tuple[str, ...]:
        """The options."""
        return self.options

    @property
    def is_one_line(self) -> bool:
        """It is."""
        return True

    @property
    def typed_as(self) -> str:
        """What is typed."""
        return "letters, or true or false"

    @property
    @abstractmethod
    def right(self) -> tuple[int, ...]:
        """The right options, counted from 0."""

    @property
    def letters(self) -> str:
        """The letters of the right options, in their order as in "ACD", or in that of the items as in "BAC"."""
        return "".join(LETTERS[index] for index in self.right)

    def formulas(self) -> list[str]:
        """Return nothing: letters are no formula."""
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

    def code(self, taken: int = 0, write: Write = python_text) -> str:
        """Return the letters in quotes."""
        return f'"{self.letters}"'

    def placeholder(self, taken: int = 0) -> str:
        """Return a text, for a text is due."""
        return '"blank"'
