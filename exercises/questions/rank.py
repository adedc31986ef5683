"""Rank, lost direction and meaning of a singular configuration (null space of J transposed)."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
