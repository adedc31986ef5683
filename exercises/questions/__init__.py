"""The kinds of questions, each of which asks for one result of an arm, in the order of the chapter.

Beside the questions:

    base            the definition of a question
    reference       the stages of a derivation in textbook form, from which reference answers are derived
    geometry        configurations for questions on singularities
    lost_lines      the lines of an arm along which a motion is lost
    results         answers computed by a derivation, correct or with mistakes in it
"""

from qdot.exercises.questions import (
    concepts,
    differentiation,
    inversion,
    path,
    performance,
    propagation,
    rank,
    recursion,
    redundancy,
    screws,
    singular,
    statics,
    transforms,
    wrist,
)
from qdot.exercises.questions.base import Question

_ORDER = (
    "transform", "home-screws", "body-pose", "position", "velocity", "velocity-component", "jacobian",
    "jacobian-size", "joint-effect",
    "joint-axes", "position-vectors", "geometric-jacobian", "twist", "link-velocity",
    "own-frame-velocity", "tool-jacobian",
    "body-adjoint", "changed-twist", "space-jacobian", "body-jacobian", "space-twist", "body-twist",
    "arm-block", "wrist-block", "block-determinants", "determinant", "gram-determinant",
    "inverse-jacobian", "inverse-velocity", "joint-rates", "path-rates", "path-limit",
    "least-norm-rates", "self-motion",
    "singular-angles", "singularity-type", "singularity-meaning", "rank", "lost-direction", "lost-motion",
    "invertibility", "unreachable-velocity", "joint-torques", "manipulability", "condition-number",
)  # fmt: skip

_ALL = {
    question.name: question
    for module in (
        differentiation, propagation, inversion, singular,
        transforms, recursion, screws, wrist, redundancy, path, rank, concepts, statics, performance,
    )
    for question in module.QUESTIONS
}  # fmt: skip

QUESTIONS: dict[str, Question] = {name: _ALL[name] for name in sorted(_ALL, key=_ORDER.index)}

__all__ = ["QUESTIONS", "Question"]
