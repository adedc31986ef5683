"""The catalogue: every kind of mistake, and the wrong answers that it leads to."""

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
from qdot.exercises.questions.results import is_derived, is_made_of_jacobian, result

SECTIONS: dict[str, ModuleType] = {
    "Adding up the links": position, "Columns of the Jacobian": columns, "Screws and exponentials": screws,
    "What is made of the Jacobian": algebra,
    "Reading the table": table, "Writing a result down": arrangement, "Numbers": numeric,
    "The finished formulas": finished,
    "Singular configurations": sets, "Options and counts": choices,
}  # fmt: skip

_ALL: list[Mistake] = [mistake for module in SECTIONS.values() for mistake in module.MISTAKES]

CATALOGUE: dict[str, Mistake] = {mistake.name: mistake for mistake in sorted(_ALL, key=lambda mistake: mistake.rare)}
"""Every mistake by name, the more likely ones first: if two give the same answer, the first is named."""

_LAST_STEPS = {mistake.name for module in (algebra, arrangement) for mistake in module.MISTAKES}

_IN_NUMBERS = [mistake.name for mistake in numeric.MISTAKES]

ONE_NUMBER = frozenset(
    {*_IN_NUMBERS, "all-relative-angles", "degrees", "determinant-sign", "sign", "square-lost"} - {"value-sign"}
)
"""The mistakes considered for a wrong answer of a single number; many others would match it by chance."""

PRIORS: dict[str, float] = {
    "point-forgotten": 2.0, "link-left-out": 1.5, "joint-left-out": 1.0, "row-misread": 0.1, "cross-order": 0.1,
    "arm-reversed": 0.1, "modified-dh": 0.1, "joint-turns-other-way": 0.1, "previous-axis": 0.1, "wrong-axis": 0.1,
    "link-not-rotated": 0.5, "own-link-only": 0.5, "arm-of-one-link": 0.5, "screw-sign": 2.0,
    "link-subtracted": 1.5, "offset-forgotten": 1.5, "base-forgotten": 1.5,
    "row-of-rotation": 0.1, "arm-to-origin": 0.1, "offset-sign": 1.0, "offset-in-degrees": 1.0, "wrong-radians": 1.0,
    "slide-offset-sign": 1.5, "lengths-exchanged": 1.0, "other-point": 1.0, "value-sign-in-set": 1.0,
    "tangent-turned-over": 1.0, "product-sign": 1.0, "axis-sign": 0.5, "offset-forgotten-in-set": 1.0,
    "offset-sign-in-set": 1.0, "quarter-turn-singular": 0.5,
}  # fmt: skip
"""How often a mistake is made, relative to others that give the same answer: 1 for most, RARE for rare ones."""
RARE = 0.3
BY_PROPAGATION = 0.5
"""The factor for a mistake in adding up the links if the columns are propagated instead of differentiated."""

ALIKE: dict[str, tuple[str, ...]] = {
    "prismatic-as-revolute": ("joint-left-out",),
    "link-left-out": ("point-forgotten", "chain-rule", "offset-forgotten", "base-forgotten"),
    "link-subtracted": ("offset-forgotten", "slide-offset-sign"),
    "row-misread": ("offset-sign",),
    "distance-forgotten": ("other-point",),
    "term-sign": ("product-sign",),
    "tangent-turned-over": ("value-sign-in-set",),
    "quarter-turn-singular": ("offset-forgotten-in-set", "offset-sign-in-set"),
}
"""Mistakes that give the same answer as another on some arms: the likelier one is named, or both if equally likely."""

_POSITIONS = frozenset({"table", "rotations", "own links", "links"})


@dataclass(frozen=True)
class Wrong:
    """A variant of a mistake, and the wrong answer that it gives, (rows, columns, …) in the working's arithmetic."""

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
    return PRIORS.get(mistake.name, RARE if mistake.rare else 1.0)


def variant_frequency(wrong: Wrong) -> float:
    """Return how often this variant of a mistake is made, relative to others that give the same answer."""
    frequency = mistake_frequency(wrong.mistake)
    propagates = any(stage == "linear" for stage, _ in wrong.working.changes)
    if "linear" in wrong.variant.changes:  # a propagated quantity such as p* may itself be the answer
        return frequency if wrong.working.depends_on("linear") else max(frequency, 1.0)
    return frequency * BY_PROPAGATION if propagates else frequency


def likely_mistakes(part: Part, precise: bool = False) -> list[Mistake]:
    """Return the mistakes to consider for a wrong answer to a part, the more likely ones first.

    Mistakes in the last step come before mistakes in the derivation of J. For a single number, all are considered only
    if it is `precise`.
    """
    ordered = list(CATALOGUE.values())
    if is_made_of_jacobian(part):
        ordered = sorted(ordered, key=lambda mistake: (mistake.rare, mistake.name not in _LAST_STEPS))
    if part.type != "number":
        return [mistake for mistake in ordered if mistake.name not in _IN_NUMBERS]
    return [mistake for mistake in ordered if precise or part.shape != (1, 1) or mistake.name in ONE_NUMBER]


def wrong_answers(w: Working, part: Part, precise: bool = False) -> Iterator[Wrong]:
    """Yield the answers to a part that mistakes in the derivation give, including those that change nothing."""
    if is_derived(part):
        reference = _result(w, part)
        for mistake in likely_mistakes(part, precise):
            yield from make_mistake(mistake, w, part, reference)


def make_mistake(mistake: Mistake, w: Working, part: Part, right: np.ndarray | None = None) -> Iterator[Wrong]:
    """Yield the answers that the variants of one mistake give to a part.

    A mistake in adding up the links is continued by differentiation first, then by propagation. A mistake at several
    joints is made, and described, only at those joints at which it changes the answer.
    """
    right = _result(w, part) if right is None else right
    if right is None:
        return
    idle_joints = set[int]()
    for variant in mistake.variants(w.chain, (right.shape[0], right.shape[1])):
        effective_variant = variant if variant.at is None else variant.but_at(idle_joints)
        if variant.at is not None:
            idle_joints = set()
        if effective_variant is None:
            continue
        change_sets: list[dict[str, Change]] = [dict(effective_variant.changes)]
        if _POSITIONS & set(effective_variant.changes) and "linear" not in effective_variant.changes:
            change_sets.append({**effective_variant.changes, "linear": propagate_linear_rows})
        answers = [(working, _result(working, part)) for working in map(w.with_mistakes, change_sets)]
        wrong_variants = [
            Wrong(mistake, effective_variant, working, answer) for working, answer in answers if answer is not None
        ]
        yield from wrong_variants
        if all(_is_same(wrong.answer, right) for wrong in wrong_variants):
            idle_joints.update(effective_variant.places)


def _is_same(answer: np.ndarray, right: np.ndarray) -> bool:
    if answer.shape != right.shape:
        return False
    if answer.dtype == object:
        return bool((answer == right).all())
    return np.allclose(answer, right, rtol=1e-9, atol=1e-9, equal_nan=True)


def _result(working: Working, part: Part) -> np.ndarray | None:
    try:
        with np.errstate(all="ignore"):  # J may have lost rank
            return result(working, part)
    except IndexError:  # the mistake is at a joint after the frame of the question
        return None


def mistaken_answers(chain: Chain, part: Part) -> Iterator[tuple[Mistake, MistakenAnswer]]:
    """Yield the mistaken answers to a part that do not come from a derivation."""
    for mistake in CATALOGUE.values():
        for mistaken in mistake.answers(chain, part):
            yield mistake, mistaken
