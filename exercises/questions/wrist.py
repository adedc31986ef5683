"""The wrist-partitioned problem of six joints: det J = det J11 det J22."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
