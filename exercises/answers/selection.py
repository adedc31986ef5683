"""All right options out of several."""

from dataclasses import dataclass

from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.answers.letters import Letters


@dataclass(frozen=True)
class Selection(Letters):
    """All right options, one or more, out of several."""

    options: tuple[str, ...]
    correct: tuple[int, ...]

    type = "selection"

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of all right options."""
        return forms.some_of(self)

    @property
    def right(self) -> tuple[int, ...]:
        """The right options, counted from 0."""
        return self.correct
