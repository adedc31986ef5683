"""An option for each item."""

from dataclasses import dataclass

from exercises.answers.base import Json
from exercises.answers.forms import Forms, T
from exercises.answers.letters import Letters, of_letters


@dataclass(frozen=True)
class Matching(Letters):
    """An option for each item; no option belongs to two items, and some may belong to none."""

    items: tuple[str, ...]
    options: tuple[str, ...]
    correct: tuple[int, ...]

    type = "matching"

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of an option for each item."""
        return forms.matching(self)

    @property
    def letters(self) -> str:
        """The letters of the right options in the order of the items, as in "BAC"."""
        return of_letters(self.correct)

    def options_json(self) -> Json:
        """Return the options and the items."""
        return {"options": list(self.options), "items": list(self.items)}
