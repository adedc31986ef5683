"""Joint rates along a straight path at a prescribed speed, and where a rate exceeds its limit (the welding robot)."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
