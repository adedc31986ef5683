"""One right option out of several."""

from dataclasses import dataclass

from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.answers.letters import LETTERS, Letters
from qdot.exercises.formula.printers.python import Write, python_text

TRUE_FALSE = ("true", "false")
"""The options of a statement that is true or false."""


@dataclass(frozen=True)
class Choice(Letters):
    """One right option out of several; options are shown in this order under the letters A, B, C …"""

    options: tuple[str, ...]
    correct: int

    type = "choice"

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of one right option."""
        return forms.one_of(self)

    @property
    def letter(self) -> str:
        """The letter of the right option."""
        return LETTERS[self.correct]

    @property
    def right(self) -> tuple[int, ...]:
        """The right option alone."""
        return (self.correct,)

    @property
    def word(self) -> str:
        """What is typed for the right option: its letter, or true or false."""
        return self.options[self.correct] if self.options == TRUE_FALSE else self.letter

    def as_json(self) -> str:
        """Return the letter."""
        return self.letter

    def code(self, taken: int = 0, write: Write = python_text) -> str:
        """Return what is typed, in quotes."""
        return f'"{self.word}"'
