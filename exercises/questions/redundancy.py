"""Redundant arms: det(J J^T), least-norm rates through the pseudo-inverse, self-motion."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
