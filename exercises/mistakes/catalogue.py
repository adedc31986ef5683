"""The catalogue of all kinds of mistakes, and the wrong answers that they lead to."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import starmap
from pathlib import Path
from typing import Any

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import Change, StageResults, propagate_linear_rows
from qdot.exercises.mistakes import algebra, arrangement, choices, columns, numeric, position, screws, sets, table
from qdot.exercises.mistakes.base import Mistake, MistakenAnswer, MistakeVariant
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.results import compute_answer, is_derived, is_made_of_jacobian

VARIANTS = (
    position.VARIANTS | columns.VARIANTS | screws.VARIANTS | algebra.VARIANTS | table.VARIANTS | arrangement.VARIANTS
    | numeric.VARIANTS
)  # fmt: skip
ANSWERS = numeric.ANSWERS | sets.ANSWERS | choices.ANSWERS
"""The functions that yield the variants of each mistake, or the wrong answers that it gives."""


def _read_sections() -> dict[str, tuple[Mistake, ...]]:
    text = Path(__file__).with_name("catalogue.toml").read_text(encoding="utf-8")
    functions: dict[str, Any] = {name: {"generate_variants": function} for name, function in VARIANTS.items()}
    functions |= {name: {"generate_answers": function} for name, function in ANSWERS.items()}

    def make_mistake(name: str, entries: dict[str, Any]) -> Mistake:
        return Mistake(name=name, **entries, **functions.get(name, {}))

    sections = tomllib.loads(text)["section"]
    return {section["title"]: tuple(starmap(make_mistake, section["mistakes"].items())) for section in sections}


SECTIONS: dict[str, tuple[Mistake, ...]] = _read_sections()
"""The mistakes by the titles of their sections in catalogue.toml."""

CATALOGUE: dict[str, Mistake] = {
    mistake.name: mistake
    for mistake in sorted((each for section in SECTIONS.values() for each in section), key=lambda each: each.rare)
}
"""All mistakes by name. Likelier ones come first, because the first mistake that gives an answer is named."""

_LAST_STEP_MISTAKES = algebra.VARIANTS.keys() | arrangement.VARIANTS.keys()

NUMERIC_MISTAKES = tuple(mistake.name for mistake in SECTIONS["Numbers"])

MISTAKES_FOR_ONE_NUMBER = frozenset(
    {*NUMERIC_MISTAKES, "all-relative-angles", "degrees", "determinant-sign", "sign", "square-lost"} - {"value-sign"}
)
"""The mistakes considered if the answer is a single number, which many others would match by chance."""

PROPAGATION_FACTOR = 0.5
"""The frequency of a mistake in adding up the links is multiplied by this if the columns are propagated."""

_POSITION_STAGES = frozenset({"table", "rotations", "own links", "links"})


@dataclass(frozen=True)
class PredictedAnswer:
    """The wrong answer that a variant of a mistake gives, (rows, columns, …), in the arithmetic of `working`."""

    mistake: Mistake
    variant: MistakeVariant
    working: StageResults
    answer: np.ndarray

    @property
    def sentence(self) -> str:
        """The message to the student."""
        return self.mistake.sentence(self.variant.words)


def variant_frequency(predicted: PredictedAnswer) -> float:
    """Return how often this variant is made, relative to other variants that give the same answer."""
    frequency = predicted.mistake.frequency
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
        return [mistake for mistake in mistakes if mistake.name not in NUMERIC_MISTAKES]
    return [
        mistake for mistake in mistakes if is_precise or part.shape != (1, 1) or mistake.name in MISTAKES_FOR_ONE_NUMBER
    ]


def predict_wrong_answers(w: StageResults, part: Part, is_precise: bool = False) -> Iterator[PredictedAnswer]:
    """Yield the answers that mistakes in the derivation of a part give, including answers that remain correct."""
    if is_derived(part):
        reference = _compute_result(w, part)
        for mistake in list_likely_mistakes(part, is_precise):
            yield from apply_mistake(mistake, w, part, reference)


def apply_mistake(
    mistake: Mistake, w: StageResults, part: Part, correct_answer: np.ndarray | None = None
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


def _compute_result(working: StageResults, part: Part) -> np.ndarray | None:
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
