"""Manipulability and condition number at a configuration."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
