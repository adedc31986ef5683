"""The types of answers. Each type is one class, which contains everything that depends on the type.

`TYPES` below lists all types. The modules:

    base            the base class of all types, and the base class of functions that depend on the type
    formulas        formulas, numbers with units, directions, and sets of configurations
    options         letters that stand for options
    words           words, which a person marks
"""

from qdot.exercises.reference_answers.base import Answer, AnswerVisitor, Json
from qdot.exercises.reference_answers.formulas import ConditionSet, Direction, Expression, Matrix, Number
from qdot.exercises.reference_answers.options import LETTERS, TRUE_FALSE, Choice, Letters, Matching, Selection
from qdot.exercises.reference_answers.words import Words

TYPES: dict[str, type[Answer]] = {
    answer_type.type: answer_type
    for answer_type in (Expression, Matrix, ConditionSet, Number, Direction, Choice, Selection, Matching, Words)
}
"""Every type of answer by its name."""

__all__ = [
    "LETTERS", "TRUE_FALSE", "TYPES", "Answer", "AnswerVisitor", "Choice", "ConditionSet", "Direction", "Expression",
    "Json", "Letters", "Matching", "Matrix", "Number", "Selection", "Words",
]  # fmt: skip
