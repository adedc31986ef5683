"""Short questions on the chapter's concepts, with parameters and figures: sizes, inverses, what is out of reach."""

from exercises.questions.base import Question

QUESTIONS: tuple[Question, ...] = ()
