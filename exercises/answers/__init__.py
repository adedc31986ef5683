"""The types of answers: each is one class with all that depends on its type.

Beside the types, which stand in `TYPES` below:

    base            what every type can be asked; `AnswerVisitor`, for code that treats the forms of answers differently
    formulas        formulas, numbers, directions, conditions
    options         letters of options
"""

from qdot.exercises.answers.base import Answer, AnswerVisitor, Json
from qdot.exercises.answers.formulas import ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.answers.options import LETTERS, TRUE_FALSE, Choice, Letters, Matching, Selection

TYPES: dict[str, type[Answer]] = {
    kind.type: kind
    for kind in (Expression, Matrix, ConditionSet, Number, Direction, Choice, Selection, Matching)
}  # fmt: skip
"""Every type of answer by its name."""

__all__ = [
    "LETTERS", "TRUE_FALSE", "TYPES", "Answer", "AnswerVisitor", "Choice", "ConditionSet", "Direction", "Expression",
    "Json", "Letters", "Matching", "Matrix", "Number", "Selection",
]  # fmt: skip
