"""The catalogue of all kinds of mistakes, and the wrong answers that they lead to."""

from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import Change, Working, propagate_linear_rows
from qdot.exercises.mistakes import (
    algebra,
    arrangement,
    choices,
    columns,
    finished,
    numeric,
    position,
    screws,
    sets,
    table,
)
from qdot.exercises.mistakes.base import Mistake, MistakenAnswer, MistakeVariant
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.results import compute_answer, is_derived, is_made_of_jacobian

SECTIONS: dict[str, ModuleType] = {
    "Adding up the links": position, "Columns of the Jacobian": columns, "Screws and exponentials": screws,
    "What is made of the Jacobian": algebra,
    "Reading the table": table, "Writing a result down": arrangement, "Numbers": numeric,
    "The finished formulas": finished,
    "Singular configurations": sets, "Options and counts": choices,
}  # fmt: skip

_ALL_MISTAKES: list[Mistake] = [mistake for module in SECTIONS.values() for mistake in module.MISTAKES]

CATALOGUE: dict[str, Mistake] = {
    mistake.name: mistake for mistake in sorted(_ALL_MISTAKES, key=lambda mistake: mistake.rare)
}
"""All mistakes by name. Likelier ones come first, because the first mistake that gives an answer is named."""

_LAST_STEP_MISTAKES = {mistake.name for module in (algebra, arrangement) for mistake in module.MISTAKES}

_NUMERIC_MISTAKES = [mistake.name for mistake in numeric.MISTAKES]

MISTAKES_FOR_ONE_NUMBER = frozenset(
    {*_NUMERIC_MISTAKES, "all-relative-angles", "degrees", "determinant-sign", "sign", "square-lost"} - {"value-sign"}
)
"""The mistakes considered if the answer is a single number, which many others would match by chance."""

FREQUENCIES: dict[str, float] = {
    "point-forgotten": 2.0, "link-left-out": 1.5, "joint-left-out": 1.0, "row-misread": 0.1, "cross-order": 0.1,
    "arm-reversed": 0.1, "modified-dh": 0.1, "joint-turns-other-way": 0.1, "previous-axis": 0.1, "wrong-axis": 0.1,
    "link-not-rotated": 0.5, "own-link-only": 0.5, "arm-of-one-link": 0.5, "screw-sign": 2.0,
    "link-subtracted": 1.5, "offset-forgotten": 1.5, "base-forgotten": 1.5,
    "row-of-rotation": 0.1, "arm-to-origin": 0.1, "offset-sign": 1.0, "offset-in-degrees": 1.0, "wrong-radians": 1.0,
    "slide-offset-sign": 1.5, "lengths-exchanged": 1.0, "other-point": 1.0, "value-sign-in-set": 1.0,
    "tangent-turned-over": 1.0, "product-sign": 1.0, "axis-sign": 0.5, "offset-forgotten-in-set": 1.0,
    "offset-sign-in-set": 1.0, "quarter-turn-singular": 0.5,
}  # fmt: skip
"""How often a mistake is made, relative to others that give the same answer.

Mistakes that are not listed have frequency 1, or RARE if they are rare."""
RARE_FREQUENCY = 0.3
PROPAGATION_FACTOR = 0.5
"""The frequency of a mistake in adding up the links is multiplied by this if the columns are propagated."""

EQUIVALENT_MISTAKES: dict[str, tuple[str, ...]] = {
    "prismatic-as-revolute": ("joint-left-out",),
    "link-left-out": ("point-forgotten", "chain-rule", "offset-forgotten", "base-forgotten"),
    "link-subtracted": ("offset-forgotten", "slide-offset-sign"),
    "row-misread": ("offset-sign",),
    "distance-forgotten": ("other-point",),
    "term-sign": ("product-sign",),
    "tangent-turned-over": ("value-sign-in-set",),
    "quarter-turn-singular": ("offset-forgotten-in-set", "offset-sign-in-set"),
}
"""For a mistake, others that give the same answer on some arms.

The likeliest of them is named, or two if they are equally likely."""

_POSITION_STAGES = frozenset({"table", "rotations", "own links", "links"})


@dataclass(frozen=True)
class PredictedAnswer:
    """The wrong answer that a variant of a mistake gives, (rows, columns, …), in the arithmetic of `working`."""

    mistake: Mistake
    variant: MistakeVariant
    working: Working
    answer: np.ndarray

    @property
    def sentence(self) -> str:
        """The message to the student."""
        return self.mistake.sentence(self.variant.words)


def mistake_frequency(mistake: Mistake) -> float:
    """Return how often a mistake is made, relative to others that give the same answer."""
    return FREQUENCIES.get(mistake.name, RARE_FREQUENCY if mistake.rare else 1.0)


def variant_frequency(predicted: PredictedAnswer) -> float:
    """Return how often this variant is made, relative to other variants that give the same answer."""
    frequency = mistake_frequency(predicted.mistake)
    propagates = any(stage == "linear" for stage, _ in predicted.working.changes)
    if "linear" in predicted.variant.changes:  # a propagated quantity such as p* may itself be the answer
        return frequency if predicted.working.depends_on("linear") else max(frequency, 1.0)
    return frequency * PROPAGATION_FACTOR if propagates else frequency


def list_likely_mistakes(part: Part, is_precise: bool = False) -> list[Mistake]:
    """Return the mistakes to consider for a wrong answer to a part, the more likely ones first.

    Mistakes in the last step come before mistakes in the derivation of J. If the answer is a single number, all
    mistakes are considered only if `is_precise` says that it has enough digits.
    """
    mistakes = list(CATALOGUE.values())
    if is_made_of_jacobian(part):
        mistakes = sorted(mistakes, key=lambda mistake: (mistake.rare, mistake.name not in _LAST_STEP_MISTAKES))
    if part.type != "number":
        return [mistake for mistake in mistakes if mistake.name not in _NUMERIC_MISTAKES]
    return [
        mistake for mistake in mistakes if is_precise or part.shape != (1, 1) or mistake.name in MISTAKES_FOR_ONE_NUMBER
    ]


def predict_wrong_answers(w: Working, part: Part, is_precise: bool = False) -> Iterator[PredictedAnswer]:
    """Yield the answers that mistakes in the derivation of a part give, including answers that remain correct."""
    if is_derived(part):
        reference = _compute_result(w, part)
        for mistake in list_likely_mistakes(part, is_precise):
            yield from apply_mistake(mistake, w, part, reference)


def apply_mistake(
    mistake: Mistake, w: Working, part: Part, correct_answer: np.ndarray | None = None
) -> Iterator[PredictedAnswer]:
    """Yield the answers to a part that the variants of one mistake give.

    After a mistake in adding up the links, J is derived by differentiation first, and then by propagation. A mistake at
    several joints is made only at the joints at which it changes the answer, and its message names only these.
    """
    correct_answer = _compute_result(w, part) if correct_answer is None else correct_answer
    if correct_answer is None:
        return
    idle_joints = set[int]()
    for variant in mistake.variants(w.chain, (correct_answer.shape[0], correct_answer.shape[1])):
        effective_variant = variant if variant.at_joints is None else variant.without_idle_joints(idle_joints)
        if variant.at_joints is not None:
            idle_joints = set()
        if effective_variant is None:
            continue
        change_sets: list[dict[str, Change]] = [dict(effective_variant.changes)]
        if _POSITION_STAGES & set(effective_variant.changes) and "linear" not in effective_variant.changes:
            change_sets.append({**effective_variant.changes, "linear": propagate_linear_rows})
        answers = [(working, _compute_result(working, part)) for working in map(w.with_mistakes, change_sets)]
        predictions = [
            PredictedAnswer(mistake, effective_variant, working, answer)
            for working, answer in answers
            if answer is not None
        ]
        yield from predictions
        if all(_is_same_answer(wrong.answer, correct_answer) for wrong in predictions):
            idle_joints.update(effective_variant.joints)


def _is_same_answer(answer: np.ndarray, correct_answer: np.ndarray) -> bool:
    if answer.shape != correct_answer.shape:
        return False
    if answer.dtype == object:
        return bool((answer == correct_answer).all())
    return np.allclose(answer, correct_answer, rtol=1e-9, atol=1e-9, equal_nan=True)


def _compute_result(working: Working, part: Part) -> np.ndarray | None:
    try:
        with np.errstate(all="ignore"):  # J may be rank-deficient
            return compute_answer(working, part)
    except IndexError:  # the joint of the mistake comes after the frame that the question asks about
        return None


def generate_mistaken_answers(chain: Chain, part: Part) -> Iterator[tuple[Mistake, MistakenAnswer]]:
    """Yield the wrong answers to a part that mistakes give without a step-by-step derivation."""
    for mistake in CATALOGUE.values():
        for mistaken_answer in mistake.answers(chain, part):
            yield mistake, mistaken_answer
