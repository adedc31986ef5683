"""What every type of answer can be asked: its shape, its reference as text and as data, and what a notebook shows.

A type is one class and has its line in `answers.TYPES`. Code outside of this folder that treats the forms of answers
differently is an `AnswerVisitor`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, ClassVar, Generic, NoReturn, TypeVar

import sympy as sp

from qdot.exercises.formula.parser import tree_of_reference
from qdot.exercises.formula.printers.python import Write, python_text
from qdot.exercises.formula.trees import Node

Json = dict[str, Any]
T = TypeVar("T")


class AnswerVisitor(Generic[T]):
    """A method for each form of answer, called with the answer; by default that of a wider form.

    Each type of answer calls the method for its form (`Answer.accept`). Methods that do the same for several forms are
    written once, as `formulas`, `letters` or `default`.
    """

    def formula(self, answer: Any) -> T:
        """Take one formula."""
        return self.formulas(answer)

    def matrix(self, answer: Any) -> T:
        """Take a matrix of formulas, or a vector."""
        return self.formulas(answer)

    def formulas(self, answer: Any) -> T:
        """Take formulas, one or in rows and columns."""
        return self.default(answer)

    def direction(self, answer: Any) -> T:
        """Take a vector up to a factor."""
        return self.default(answer)

    def numbers(self, answer: Any) -> T:
        """Take numbers with units."""
        return self.default(answer)

    def conditions(self, answer: Any) -> T:
        """Take conditions on the joints."""
        return self.default(answer)

    def one_of(self, answer: Any) -> T:
        """Take one of several options."""
        return self.letters(answer)

    def some_of(self, answer: Any) -> T:
        """Take several options."""
        return self.letters(answer)

    def matching(self, answer: Any) -> T:
        """Take an option for each item."""
        return self.letters(answer)

    def letters(self, answer: Any) -> T:
        """Take letters of options, whatever they stand for."""
        return self.default(answer)

    def default(self, answer: Any) -> T:
        """Take whatever has no way of its own."""
        return self._none(answer)

    def _none(self, answer: Any) -> NoReturn:
        raise TypeError(f"{type(self).__name__} has no way for answers of type {answer.type}")


class Answer(ABC):
    """The answer to a part: a frozen dataclass of the reference, with everything that depends on its type."""

    type: ClassVar[str]
    """Its name in `qdot show --json` and in results."""
    takes_symbols: ClassVar[bool] = True
    """Whether it may contain symbols of the problem."""
    counts_up_to_a_factor: ClassVar[bool] = False
    """Whether every multiple except zero is right, too."""
    is_exact: ClassVar[bool] = False
    """Whether decimals mean exactly what they say, except for the rounding that an assignment allows."""
    is_a_set: ClassVar[bool] = False
    """Whether the answer is a set of configurations, as conditions on the joints."""

    @abstractmethod
    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Return what the visitor's method for this form of answer returns."""

    @property
    def shape(self) -> tuple[int, int] | None:
        """Rows and columns of an answer that has entries, else None."""
        return None

    @property
    def units_due(self) -> tuple[str, ...]:
        """The unit of each expected number; empty for formulas."""
        return ()

    def unit(self, entry: int) -> str:
        """Return the unit of an entry, counted from 0; "" if it has none."""
        return self.units_due[entry] if self.units_due else ""

    @property
    def offered(self) -> tuple[str, ...]:
        """The options to choose from; empty for answers without options."""
        return ()

    @property
    def right(self) -> tuple[int, ...]:
        """The right options, counted from 0."""
        return ()

    @property
    def matched(self) -> tuple[str, ...]:
        """The items that options are matched to."""
        return ()

    @property
    def is_one_line(self) -> bool:
        """Whether a single expression or a few letters are typed."""
        return False

    @property
    def typed_as(self) -> str:
        """What is expected, in words, if a placeholder does not show it."""
        return ""

    @property
    def is_in_numbers(self) -> bool:
        """Whether numbers are expected, right within a tolerance."""
        return False

    @property
    def is_formulas(self) -> bool:
        """Whether formulas are expected, which are compared entry by entry."""
        return False

    def as_matrix(self) -> sp.Matrix:
        """Return the reference as a matrix, of one entry for an expression. Raises TypeError for other types."""
        raise TypeError(f"the answer is of type {self.type}, and no matrix")

    def entries(self) -> list[sp.Expr]:
        """Return the formulas that are compared as formulas."""
        return []

    @abstractmethod
    def formulas(self) -> list[str]:
        """Return the texts of the reference, which are parsed like a student's; empty for letters."""

    def trees(self, known: Iterable[str]) -> list[list[Node]]:
        """Return the reference as trees, in rows and columns; conditions and single formulas are a column.

        `known` are the names of the problem's symbols.
        """
        names = frozenset(known)
        trees = [tree_of_reference(text, names) for text in self.formulas()]
        columns = (self.shape or (1, 1))[1]
        return [trees[i : i + columns] for i in range(0, len(trees), columns)]

    @abstractmethod
    def as_json(self) -> str | list[Any]:
        """Return the reference as text, as a list (a vector, conditions, letters), or as a list of rows."""

    def options_json(self) -> Json:
        """Return the options, if there are any, and the items to which they are matched."""
        return {}

    def allowance_json(self) -> Json:
        """Return the units of expected numbers, and how far off they may be."""
        return {}

    @abstractmethod
    def as_typed(self) -> str:
        """Return the reference as a student would type it."""

    @abstractmethod
    def code(self, taken: int = 0, write: Write = python_text) -> str:
        """Return the reference as Python code, `taken` columns of whose first line are used already.

        Formulas are written by `write`.
        """

    def placeholder(self, taken: int = 0) -> str:
        """Return what an unanswered cell assigns: `blank`, in the expected shape."""
        return "blank"
