"""The questions of the chapter. Each question asks for one result of an arm.

    differentiation     position, velocity and Jacobian by differentiation, and the determinant
    propagation         joint axes, position vectors, Jacobian and velocities by propagation
    transforms          the transform of the last frame, and the Jacobian in the tool frame
    screws              screws, exponentials, and Jacobians and twists in the space and body frames
    wrist               the blocks of the Jacobian of an arm with a spherical wrist
    inversion           the inverse, joint rates, and static joint torques
    path                joint rates along a straight line
    redundancy          J J^T and the null space of J
    singular            singular configurations and their kind
    rank                rank, lost direction and meaning of a singular configuration
    concepts            the size of J, the effect of a joint, when J can be inverted

Beside the questions:

    base                    the definition of a question
    reference               the derivation in textbook form, from which reference answers are derived
    language, quantities    the language of formulas, and the quantities of an arm that formulas name
    exact_configurations    regular and singular configurations, and the branches of a singular set
    custom/                 questions that instructors define
    results                 answers computed from a derivation, correct or with mistakes in it
"""

from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import (
    concepts,
    differentiation,
    inversion,
    path,
    propagation,
    rank,
    redundancy,
    screws,
    singular,
    transforms,
    wrist,
)
from qdot.exercises.questions.base import Question

_ORDER = (
    "transform", "home-screws", "body-pose", "position", "velocity", "velocity-component", "jacobian",
    "jacobian-size", "joint-effect",
    "joint-axes", "position-vectors", "geometric-jacobian", "twist", "link-velocity",
    "own-frame-velocity", "tool-jacobian",
    "body-adjoint", "space-jacobian", "body-jacobian", "space-twist", "body-twist",
    "arm-block", "wrist-block", "block-determinants", "determinant", "gram-determinant",
    "inverse-jacobian", "inverse-velocity", "joint-rates", "path-rates",
    "least-norm-rates", "self-motion",
    "singular-angles", "singularity-type", "singularity-meaning", "rank", "lost-direction",
    "invertibility", "joint-torques", "manipulability", "condition-number",
)  # fmt: skip
"""The names of the questions in the order of the chapter."""

_ALL = {
    question.name: question
    for module in (
        differentiation, propagation, inversion, singular, transforms, screws, wrist, redundancy, path, rank, concepts,
    )
    for question in module.QUESTIONS
}  # fmt: skip

QUESTIONS: dict[str, Question] = {name: _ALL[name] for name in sorted(_ALL, key=_ORDER.index)}
"""All questions of the chapter by name, in the order of the chapter."""


def find_question(part: Part) -> Question | None:
    """Return the chapter's or the instructor's question that a part asks; None if the part asks a short question."""
    question: Question | None = part.details.question or QUESTIONS.get(part.kind)
    return question


__all__ = ["QUESTIONS", "Question", "find_question"]
