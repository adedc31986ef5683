"""The base class of all types of answers, and the visitor that distinguishes them.

Each type is one class, listed in `answer_types.TYPES`. Code outside this folder that depends on the type of an answer
subclasses `AnswerVisitor`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, ClassVar, Generic, TypeVar

import sympy as sp

from qdot.exercises.formula.parser import parse_reference
from qdot.exercises.formula.printers.python import FormulaToCode, python_text
from qdot.exercises.formula.trees import Node

Json = dict[str, Any]
T = TypeVar("T")


class AnswerVisitor(Generic[T]):
    """A visitor with a method for each type of answer; by default, each method calls a more general one.

    An answer calls the method for its type (`Answer.accept`). A subclass that treats several types alike overrides only
    the more general method: `formulas`, `letters` or `default`.
    """

    def formula(self, answer: Any) -> T:
        """Visit one formula."""
        return self.formulas(answer)

    def matrix(self, answer: Any) -> T:
        """Visit a matrix of formulas, or a vector."""
        return self.formulas(answer)

    def formulas(self, answer: Any) -> T:
        """Visit a single formula, or formulas in rows and columns."""
        return self.default(answer)

    def direction(self, answer: Any) -> T:
        """Visit a vector that is defined up to a factor."""
        return self.default(answer)

    def numbers(self, answer: Any) -> T:
        """Visit numbers with units."""
        return self.default(answer)

    def conditions(self, answer: Any) -> T:
        """Visit conditions on the joints."""
        return self.default(answer)

    def choice(self, answer: Any) -> T:
        """Visit the choice of a single option."""
        return self.letters(answer)

    def selection(self, answer: Any) -> T:
        """Visit the choice of several options."""
        return self.letters(answer)

    def matching(self, answer: Any) -> T:
        """Visit the choice of an option for each item."""
        return self.letters(answer)

    def letters(self, answer: Any) -> T:
        """Visit letters of options of any type."""
        return self.default(answer)

    def default(self, answer: Any) -> T:
        """Visit any answer whose form has no method of its own. Raises TypeError by default."""
        raise TypeError(f"{type(self).__name__} does not support answers of type {answer.type}")


class Answer(ABC):
    """The reference answer to a part, and everything that depends on its type. Each type is a frozen dataclass."""

    type: ClassVar[str]
    """Its name in `qdot show --json` and in results."""
    takes_symbols: ClassVar[bool] = True
    """Whether it may contain symbols of the problem."""
    counts_up_to_a_factor: ClassVar[bool] = False
    """Whether every nonzero multiple of a correct answer is correct, too."""
    is_exact: ClassVar[bool] = False
    """Whether decimals are taken as exact, unless the assignment allows rounding."""
    is_set: ClassVar[bool] = False
    """Whether the answer is a set of configurations, as conditions on the joints."""

    @abstractmethod
    def accept(self, visitor: AnswerVisitor[T]) -> T:
        """Call the visitor's method for this type of answer, and return its result."""

    @property
    def shape(self) -> tuple[int, int] | None:
        """Rows and columns of an answer that has entries, else None."""
        return None

    @property
    def expected_units(self) -> tuple[str, ...]:
        """The unit of each expected number; empty for formulas."""
        return ()

    def unit(self, entry: int) -> str:
        """Return the unit of an entry, counted from 0; "" if it has none."""
        return self.expected_units[entry] if self.expected_units else ""

    @property
    def offered_options(self) -> tuple[str, ...]:
        """The options to choose from; empty for answers without options."""
        return ()

    @property
    def correct_indices(self) -> tuple[int, ...]:
        """The correct options, counted from 0."""
        return ()

    @property
    def matched_items(self) -> tuple[str, ...]:
        """The items that options are matched to."""
        return ()

    @property
    def is_one_line(self) -> bool:
        """Whether the typed answer is a single expression or a few letters."""
        return False

    @property
    def typed_form(self) -> str:
        """The form in which an answer is typed, in words, if a placeholder does not show it."""
        return ""

    @property
    def is_numeric(self) -> bool:
        """Whether the answer consists of numbers that are correct within a tolerance."""
        return False

    @property
    def is_symbolic(self) -> bool:
        """Whether the answer consists of formulas that are compared entry by entry."""
        return False

    def as_matrix(self) -> sp.Matrix:
        """Return the reference as a matrix (1 x 1 for an expression). Raises TypeError for other types."""
        raise TypeError(f"the answer is of type {self.type}, not a matrix")

    def entries(self) -> list[sp.Expr]:
        """Return the formulas that are compared symbolically."""
        return []

    @abstractmethod
    def formulas(self) -> list[str]:
        """Return the formulas of the reference as texts, which are parsed like a student's; empty for letters."""

    def trees(self, known: Iterable[str]) -> list[list[Node]]:
        """Return the reference as trees, in rows and columns; conditions and single formulas are a column.

        `known` are the names of the problem's symbols.
        """
        names = frozenset(known)
        trees = [parse_reference(text, names) for text in self.formulas()]
        columns = (self.shape or (1, 1))[1]
        return [trees[i : i + columns] for i in range(0, len(trees), columns)]

    @abstractmethod
    def as_json(self) -> str | list[Any]:
        """Return the reference as text, as a list (a vector, conditions, letters), or as a list of rows."""

    def options_json(self) -> Json:
        """Return the options, if there are any, and the items to which they are matched."""
        return {}

    def tolerance_json(self) -> Json:
        """Return the units of expected numbers, and the errors allowed."""
        return {}

    @abstractmethod
    def as_typed(self) -> str:
        """Return the reference as a student would type it."""

    @abstractmethod
    def code(self, used_columns: int = 0, format_formula: FormulaToCode = python_text) -> str:
        """Return the reference as Python code; a long matrix is broken into lines.

        `used_columns` is the number of columns of the first line that are already used. `format_formula` converts a
        formula to code.
        """

    def placeholder(self, used_columns: int = 0) -> str:
        """Return the Python code for an unanswered part: `blank`, in the expected shape."""
        return "blank"
