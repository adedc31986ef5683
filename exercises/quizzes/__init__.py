"""Short questions for quizzes (options, matches, numbers, drawings), and all questions together.

Beside the short questions:

    asking              how a short question is asked
    options, places     what a question with options offers; configurations to choose from
    wrong, wrong_sets   wrong options, made by the mistakes of the catalogue
    option_mistakes     why each option is wrong
"""

from qdot.exercises.questions import QUESTIONS, Question
from qdot.exercises.quizzes import choice, drawings, matching, selections, values

QUIZZES: dict[str, Question] = {
    question.name: question
    for question in (
        *choice.CHOICES, *selections.SELECTIONS, *matching.MATCHINGS, *values.VALUES, *drawings.DRAWN
    )
}  # fmt: skip
"""Short questions by name."""

ASKED: dict[str, Question] = {**QUESTIONS, **QUIZZES}
"""Every question by name: those of the chapter, then the short ones."""

__all__ = ["ASKED", "QUIZZES"]
