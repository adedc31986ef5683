"""Question kinds: each asks an arm for one result; the registry is in the order of the chapter."""

from exercises.questions import differentiation, inversion, propagation, singular
from exercises.questions.base import Question

_ORDER = (
    "position", "velocity", "velocity-component", "jacobian", "joint-axes", "position-vectors", "geometric-jacobian",
    "twist", "link-velocity", "determinant", "inverse-jacobian", "inverse-velocity", "joint-rates", "singular-angles",
    "singularity-type",
)  # fmt: skip

_ALL = {
    question.name: question
    for module in (differentiation, propagation, inversion, singular)
    for question in module.QUESTIONS
}

QUESTIONS: dict[str, Question] = {name: _ALL[name] for name in [*_ORDER, *(n for n in _ALL if n not in _ORDER)]}

__all__ = ["QUESTIONS", "Question"]
