"""A set of configurations, as conditions on the joints."""

from collections.abc import Sequence
from dataclasses import dataclass

from qdot.exercises.answers.base import Answer
from qdot.exercises.answers.forms import Forms, T
from qdot.exercises.arm.singularity import Component
from qdot.exercises.formula.printers.python import Write, list_code, python_text


@dataclass(frozen=True)
class ConditionSet(Answer):
    """A set of configurations, as conditions on the joints."""

    components: tuple[Component, ...]

    type = "singular"
    is_exact = True
    is_a_set = True

    def told_to(self, forms: Forms[T]) -> T:
        """Return what is made of a set of conditions."""
        return forms.conditions(self)

    def pieces(self) -> list[str]:
        """Return every piece as text."""
        return [piece for component in self.components for piece in component.pieces()]

    def by_condition(self, pieces: Sequence[T]) -> list[list[T]]:
        """Return what stands for each piece, those together that belong to one condition or to several at once."""
        left, groups = list(pieces), []
        for component in self.components:
            count = len(component.pieces())
            groups.append(left[:count])
            left = left[count:]
        return groups

    @property
    def typed_as(self) -> str:
        """A list."""
        return "a list of conditions"

    def formulas(self) -> list[str]:
        """Return every piece as text."""
        return self.pieces()

    def as_json(self) -> list[str]:
        """Return every piece as text."""
        return self.pieces()

    def as_typed(self) -> str:
        """Return the pieces in brackets."""
        return f"[{', '.join(self.pieces())}]"

    def code(self, taken: int = 0, write: Write = python_text) -> str:
        """Return a list of `Eq` and `And`, one for each value or combination of values."""
        return list_code([text for component in self.components for text in _alternatives(component, write)], taken)

    def placeholder(self, taken: int = 0) -> str:
        """Return a list."""
        return "[blank]"


def _alternatives(component: Component, write: Write) -> list[str]:
    """Return the conditions of a component, one text for each value or combination of values."""
    if component.solutions is None:
        return [_together([f"Eq({write(condition)}, 0)" for condition in component.conditions])]
    combinations: list[list[str]] = [[]]
    for joint, values in component.solutions:
        combinations = [[*c, f"Eq({joint}, {write(value)})"] for c in combinations for value in values]
    return [_together(equations) for equations in combinations]


def _together(equations: list[str]) -> str:
    return equations[0] if len(equations) == 1 else f"And({', '.join(equations)})"
