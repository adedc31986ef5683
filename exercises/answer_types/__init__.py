"""The types of answers: each is one class with everything that depends on its type.

`TYPES` below lists all types. The modules:

    base            the base class; `AnswerVisitor`, for code that distinguishes the forms of answers
    formulas        formulas, numbers, directions, conditions
    options         letters of options
"""

from qdot.exercises.answer_types.base import Answer, AnswerVisitor, Json
from qdot.exercises.answer_types.formulas import ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.answer_types.options import LETTERS, TRUE_FALSE, Choice, Letters, Matching, Selection

TYPES: dict[str, type[Answer]] = {
    kind.type: kind
    for kind in (Expression, Matrix, ConditionSet, Number, Direction, Choice, Selection, Matching)
}  # fmt: skip
"""Every type of answer by its name."""

__all__ = [
    "LETTERS", "TRUE_FALSE", "TYPES", "Answer", "AnswerVisitor", "Choice", "ConditionSet", "Direction", "Expression",
    "Json", "Letters", "Matching", "Matrix", "Number", "Selection",
]  # fmt: skip
