"""The types of answers: each is one class in a module of its own, with all that depends on its type.

Beside the types, which stand in `TYPES` below:

    forms               the forms of answers, with a way for each, for those who treat forms differently (`Forms`)
    base                what every type can be asked
    rows, letters       what types of formulas have in common, and types whose answer is the letters of options
"""

from qdot.exercises.answers.base import Answer, Json
from qdot.exercises.answers.choice import TRUE_FALSE, Choice
from qdot.exercises.answers.conditions import ConditionSet
from qdot.exercises.answers.direction import Direction
from qdot.exercises.answers.expression import Expression
from qdot.exercises.answers.forms import Forms
from qdot.exercises.answers.letters import LETTERS, Letters
from qdot.exercises.answers.matching import Matching
from qdot.exercises.answers.matrix import Matrix
from qdot.exercises.answers.number import Number
from qdot.exercises.answers.selection import Selection

TYPES: dict[str, type[Answer]] = {
    kind.type: kind
    for kind in (Expression, Matrix, ConditionSet, Number, Direction, Choice, Selection, Matching)
}  # fmt: skip
"""Every type of answer by its name."""

__all__ = [
    "LETTERS", "TRUE_FALSE", "TYPES", "Answer", "Choice", "ConditionSet", "Direction", "Expression", "Forms", "Json",
    "Letters", "Matching", "Matrix", "Number", "Selection",
]  # fmt: skip
