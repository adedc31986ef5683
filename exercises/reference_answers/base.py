"""The base class of all types of answers, and the base class of functions that depend on the type of an answer.

Each type is one class, listed in `reference_answers.TYPES`. Code outside this folder that depends on the type is in
subclasses of `AnswerVisitor`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import Any, ClassVar, Generic, TypeVar

import sympy as sp

from qdot.exercises.formula.parser import parse_reference
from qdot.exercises.formula.printers.python import FormulaToCode, print_python
from qdot.exercises.formula.trees import Node

Json = dict[str, Any]
T = TypeVar("T")


class AnswerVisitor(Generic[T]):
    """A function with a method for each type of answer (the visitor pattern).

    A subclass defines some of these methods:

    - `visit_expression`, `visit_matrix`, … : one for each name in `reference_answers.TYPES`
    - `visit_formulas` for expressions and matrices, and `visit_letters` for all letters of options
    - `visit_any` for every answer
    """

    def visit(self, answer: "Answer") -> T:
        """Call the most specific method for an answer, and return its result. Raises TypeError if there is none."""
        for name in (answer.type, answer.group, "any"):
            if (method := getattr(self, f"visit_{name}", None)) is not None:
                result: T = method(answer)
                return result
        raise TypeError(f"{type(self).__name__} does not support answers of type {answer.type}")


class Answer(ABC):
    """The reference answer to a part, and everything that depends on its type. Each type is a frozen dataclass."""

    type: ClassVar[str]
    """The name of the type in `qdot show --json` and in results."""
    group: ClassVar[str] = ""
    """The group to which the type belongs: "formulas", "letters", or none."""
    takes_symbols: ClassVar[bool] = True
    """Whether an answer may contain symbols of the problem."""
    is_direction: ClassVar[bool] = False
    """Whether every nonzero multiple of a correct answer is correct, too."""
    is_exact: ClassVar[bool] = False
    """Whether decimals count as exact (0.5 is a half), unless the assignment allows rounding."""
    is_set: ClassVar[bool] = False
    """Whether the answer is a set of configurations, given by conditions on the joints."""
    is_symbolic: ClassVar[bool] = False
    """Whether the answer consists of formulas that are compared entry by entry."""
    typed_form: ClassVar[str] = ""
    """The form in which an answer is typed, in words; "" if a placeholder shows the form."""

    @property
    def shape(self) -> tuple[int, int] | None:
        """The numbers of rows and columns of an answer that has entries; None for other answers."""
        return None

    @property
    def expected_units(self) -> tuple[str, ...]:
        """The unit of each expected number; empty for formulas."""
        return ()

    @property
    def offered_options(self) -> tuple[str, ...]:
        """The options to choose from; empty for answers without options."""
        return ()

    @property
    def correct_indices(self) -> tuple[int, ...]:
        """The indices of the correct options, from 0; empty for answers without options."""
        return ()

    @property
    def matched_items(self) -> tuple[str, ...]:
        """The items to which a student matches options; empty for other answers."""
        return ()

    @property
    def is_one_line(self) -> bool:
        """Whether the typed answer is a single expression or a few letters."""
        return False

    @property
    def is_numeric(self) -> bool:
        """Whether the answer consists of numbers that are correct within a tolerance."""
        return False

    def as_matrix(self) -> sp.Matrix:
        """Return the reference as a matrix (1 x 1 for an expression). Raises TypeError for other types."""
        raise TypeError(f"the answer is of type {self.type}, not a matrix")

    def list_entries(self) -> list[sp.Expr]:
        """Return the formulas that are compared as functions, row by row; [] for numbers, sets and letters."""
        return []

    @abstractmethod
    def list_formulas(self) -> list[str]:
        """Return the texts of the reference's formulas, which are parsed like students' answers; [] for letters."""

    def parse_trees(self, symbol_names: Iterable[str]) -> list[list[Node]]:
        """Return the reference's formulas as trees, in rows and columns; conditions are one column.

        `symbol_names` are the names of the problem's symbols.
        """
        names = frozenset(symbol_names)
        trees = [parse_reference(text, names) for text in self.list_formulas()]
        _, columns = self.shape or (1, 1)
        return [trees[i : i + columns] for i in range(0, len(trees), columns)]

    @abstractmethod
    def as_json(self) -> str | list[Any]:
        """Return the reference as text, as a list (for a vector, conditions or letters), or as a list of rows."""

    def to_options_json(self) -> Json:
        """Return the options, and the items to which they are matched; {} for answers without options."""
        return {}

    def to_tolerance_json(self) -> Json:
        """Return the units of expected numbers, and the errors allowed; {} for formulas and letters."""
        return {}

    @abstractmethod
    def as_typed(self) -> str:
        """Return the reference as a student would type it."""

    @abstractmethod
    def write_code(self, prefix_width: int = 0, format_formula: FormulaToCode = print_python) -> str:
        """Return the reference as Python code; a long matrix is broken into lines.

        The code begins after `prefix_width` columns of its first line. `format_formula` converts a formula to code.
        """

    def write_placeholder(self, prefix_width: int = 0) -> str:
        """Return the Python code for an unanswered part: `blank`, in the expected shape."""
        return "blank"
