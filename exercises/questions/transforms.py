"""The full transform of the last frame, and the Jacobian in the tool frame."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
