"""An option for each item."""

from dataclasses import dataclass

from qdot.exercises.answers.base import Json
from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.answers.letters import Letters


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
    def matched(self) -> tuple[str, ...]:
        """The items."""
        return self.items

    @property
    def right(self) -> tuple[int, ...]:
        """The right options, counted from 0, in the order of the items."""
        return self.correct

    def options_json(self) -> Json:
        """Return the options and the items."""
        return {"options": list(self.options), "items": list(self.items)}
