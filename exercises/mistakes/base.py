"""Define a mistake: a change to a derivation, or to an answer, and the message to the student."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from qdot.exercises.answer_types import Answer
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY, convention_of
from qdot.exercises.arm.conventions.base import FRAMES
from qdot.exercises.arm.derivation_graph import Change, Working, propagate_linear_rows
from qdot.exercises.problem.problem import Part

AnswerShape = tuple[int, int]


@dataclass(frozen=True)
class MistakeVariant:
    """One variant of a mistake on an arm: the changed stages of the derivation, and the words for the message.

    `missing_symbols` lists the symbols of an omitted factor. The message can't name them, because quizzes contain it
    and a quiz id must always give the same text.

    If the mistake can be made at several joints, `joints` are the joints (from 0) at which this variant makes it.
    `at_joints` returns the variant for other joints.
    """

    changes: Mapping[str, Change]
    words: Mapping[str, object] = field(default_factory=dict)
    missing_symbols: str = ""
    joints: tuple[int, ...] = ()
    at_joints: "Callable[[Sequence[int]], MistakeVariant] | None" = None

    def without_idle_joints(self, idle_joints: AbstractSet[int]) -> "MistakeVariant | None":
        """Return the variant without the joints at which it changes nothing; None if fewer than two remain."""
        remaining_joints = [joint for joint in self.joints if joint not in idle_joints]
        if self.at_joints and len(remaining_joints) > 1:
            return replace(self.at_joints(remaining_joints), joints=tuple(remaining_joints))
        return None


@dataclass(frozen=True)
class MistakenAnswer:
    """The wrong answer that one variant of a mistake gives, for a part that is not derived step by step."""

    answer: Answer
    words: Mapping[str, object] = field(default_factory=dict)


VariantGenerator = Callable[[Chain, AnswerShape], Iterator[MistakeVariant]]
"""Yields the variants of a mistake on an arm, for an answer of the given shape."""

AnswerGenerator = Callable[[Chain, Part], Iterator[MistakenAnswer]]
"""Yields the wrong answers that a mistake gives to a part."""


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake.

    `message` is the message to the student: what seems to have happened, and where to look. It gives no answer away.
    The variant's words replace the names in braces. `source` is the section or equation in the chapter. A rare mistake
    is named only if no other mistake gives the same answer.
    """

    name: str
    title: str
    message: str
    source: str
    variants: VariantGenerator = lambda chain, shape: iter(())
    answers: AnswerGenerator = lambda chain, part: iter(())
    rare: bool = False

    def sentence(self, words: Mapping[str, object]) -> str:
        """Return the message to the student, including a reference to the chapter."""
        return f"{self.message.format(**words)} See {self.chapter_reference}."

    @property
    def chapter_reference(self) -> str:
        """The reference to the chapter that follows "See"; equation numbers are in brackets."""
        return f"({self.source})" if self.source[0].isdigit() else self.source


def name_chapter(sentence: str) -> str:
    """Return a mistake's sentence in which a reference such as "See (6.4)" says that (6.4) is in Chapter 6.

    Readers need this wherever the sentence stands without the notebook or the site, which say so.

    >>> name_chapter("Check the sign. See (6.4).")
    'Check the sign. See (6.4) in Chapter 6.'
    """
    return re.sub(r"\bSee (\(6\.[^)]*\)|Example 6\.\d+|below 6\.\d+)", r"See \1 in Chapter 6", sentence)


# --- restriction of mistakes to some arms ---

MISREADINGS = frozenset().union(*(each.specific_mistakes for each in REGISTRY.values()))
"""The mistakes that come from reading an arm's description in another convention."""


def restrict_to_feature(
    feature: str, mistakes: Iterable[Mistake], restricted_names: AbstractSet[str] | None = None
) -> tuple[Mistake, ...]:
    """Restrict mistakes to arms whose convention has a feature, such as frames on the links.

    If `restricted_names` are given, only the mistakes with these names are restricted. The others are returned
    unchanged.
    """

    def restrict(mistake: Mistake) -> Mistake:
        def is_possible(chain: Chain) -> bool:
            convention = convention_of(chain)
            return feature in convention.features and (
                mistake.name in convention.specific_mistakes or mistake.name not in MISREADINGS
            )

        return replace(
            mistake,
            variants=lambda chain, shape: mistake.variants(chain, shape) if is_possible(chain) else iter(()),
            answers=lambda chain, part: mistake.answers(chain, part) if is_possible(chain) else iter(()),
        )

    return tuple(
        restrict(mistake) if restricted_names is None or mistake.name in restricted_names else mistake
        for mistake in mistakes
    )


def restrict_to_tables(
    mistakes: Iterable[Mistake], restricted_names: AbstractSet[str] | None = None
) -> tuple[Mistake, ...]:
    """Restrict mistakes, or only those with the given names, to arms that are described by a DH table.

    An arm that is described by its axes has no frames on its links.
    """
    return restrict_to_feature(FRAMES, mistakes, restricted_names)


# --- helpers for variants ---


def single_variant(changes: Mapping[str, Change], words: Mapping[str, object] | None = None) -> VariantGenerator:
    """Return a function that yields the same single variant for every arm."""
    return lambda chain, shape: iter([MistakeVariant(changes, words or {})])


def propagated_variant(changes: Mapping[str, Change], words: Mapping[str, object] | None = None) -> MistakeVariant:
    """Return a variant in which the linear rows of the Jacobian are computed by propagation after the changes."""
    return MistakeVariant({**changes, "linear": propagate_linear_rows}, words or {})


def vary_each_joint_and_all(
    joints: Sequence[int], variant_at: Callable[[Sequence[int]], MistakeVariant]
) -> Iterator[MistakeVariant]:
    """Yield one variant for each of the given joints, and then one for all of them together if there are several."""
    for joint in joints:
        yield replace(variant_at([joint]), joints=(joint,))
    if len(joints) > 1:
        yield replace(variant_at(joints), joints=tuple(joints), at_joints=variant_at)


def scale_entries(entry_index: Any, factor: int) -> Change:
    """Return the change that multiplies the entries at an index of an array by a factor."""

    def scale(w: Working, values: np.ndarray) -> np.ndarray:
        scaled = np.array(values)
        scaled[entry_index] = factor * scaled[entry_index]
        return scaled

    return scale


def exchange(i: int, j: int, axis: int = 0) -> Change:
    """Return the change that exchanges two rows (axis 0) or columns (axis 1) of an array."""

    def apply_exchange(w: Working, values: np.ndarray) -> np.ndarray:
        order = list(range(values.shape[axis]))
        order[i], order[j] = j, i
        return values.take(order, axis)

    return apply_exchange
