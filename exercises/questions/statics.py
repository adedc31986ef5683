"""Static joint torques, the dual of the velocity problem: tau = J^T f."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
