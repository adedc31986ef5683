"""What a mistake is: a change to a derivation, or to an answer, and the message to the student."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from qdot.exercises.answers import Answer
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY, convention_of
from qdot.exercises.arm.conventions.base import FRAMES
from qdot.exercises.arm.derivation_graph import Change, Working, propagate_linear_rows
from qdot.exercises.problem.problem import Part

Shape = tuple[int, int]


@dataclass(frozen=True)
class MistakeVariant:
    """One way to make a mistake on an arm: the stages that change, and the words for the sentence.

    `missing` are the symbols of what is left out. The sentence can't name them: it is part of quizzes, whose ids must
    always give the same text. `places` are the joints, from 0, of a variant that can be made at each of several or at
    all of them, and `at` makes it at some of these.
    """

    changes: Mapping[str, Change]
    words: Mapping[str, object] = field(default_factory=dict)
    missing: str = ""
    places: tuple[int, ...] = ()
    at: "Callable[[Sequence[int]], MistakeVariant] | None" = None

    def but_at(self, idle: AbstractSet[int]) -> "MistakeVariant | None":
        """Return a variant without the places where it changes nothing; None if fewer than two are left."""
        places = [place for place in self.places if place not in idle]
        return replace(self.at(places), places=tuple(places)) if self.at and len(places) > 1 else None


@dataclass(frozen=True)
class MistakenAnswer:
    """One way to mistake an answer that no derivation gives: the answer that is given instead."""

    answer: Answer
    words: Mapping[str, object] = field(default_factory=dict)


Variants = Callable[[Chain, Shape], Iterator[MistakeVariant]]
"""The ways to make a mistake on an arm; the shape is that of the answer in which it shows."""

Answers = Callable[[Chain, Part], Iterator[MistakenAnswer]]
"""The ways to make a mistake with the answer to a part."""


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake.

    `says` is the sentence to the student: what seems to have happened and where to look, with the words of the variant
    in braces; it gives no answer away. `source` is the place in the chapter. A rare mistake is named only if no other
    one gives the same answer.
    """

    name: str
    title: str
    says: str
    source: str
    variants: Variants = lambda chain, shape: iter(())
    answers: Answers = lambda chain, part: iter(())
    rare: bool = False

    def sentence(self, words: Mapping[str, object]) -> str:
        """Return the message to the student, and where to look."""
        return f"{self.says.format(**words)} See {self.where}."

    @property
    def where(self) -> str:
        """The place in the chapter, as words after "See"; numbers are those of formulas."""
        return f"({self.source})" if self.source[0].isdigit() else self.source


# --- which arms a mistake is made on ---

MISREADINGS = frozenset().union(*(each.misreadings for each in REGISTRY.values()))
"""The mistakes of those who read an arm in another convention than its own."""


def only_if_described_by(
    feature: str, mistakes: Iterable[Mistake], names: AbstractSet[str] | None = None
) -> tuple[Mistake, ...]:
    """Restrict mistakes, all or those with these `names`, to arms whose convention has a feature such as frames."""

    def restrict(mistake: Mistake) -> Mistake:
        def is_possible(chain: Chain) -> bool:
            convention = convention_of(chain)
            return feature in convention.has and (
                mistake.name in convention.misreadings or mistake.name not in MISREADINGS
            )

        return replace(
            mistake,
            variants=lambda chain, shape: mistake.variants(chain, shape) if is_possible(chain) else iter(()),
            answers=lambda chain, part: mistake.answers(chain, part) if is_possible(chain) else iter(()),
        )

    return tuple(restrict(mistake) if names is None or mistake.name in names else mistake for mistake in mistakes)


def only_for_tables(mistakes: Iterable[Mistake], names: AbstractSet[str] | None = None) -> tuple[Mistake, ...]:
    """Restrict mistakes to arms with a table: an arm described by its axes has no frames on its links."""
    return only_if_described_by(FRAMES, mistakes, names)


# --- how variants are made ---


def always(changes: Mapping[str, Change], words: Mapping[str, object] | None = None) -> Variants:
    """Return the variants of a mistake that is made in one way on all arms."""
    return lambda chain, shape: iter([MistakeVariant(changes, words or {})])


def by_propagation(changes: Mapping[str, Change], words: Mapping[str, object] | None = None) -> MistakeVariant:
    """Return a variant after which the linear rows of the Jacobian are propagated."""
    return MistakeVariant({**changes, "linear": propagate_linear_rows}, words or {})


def at_each_and_all(places: Sequence[int], at: Callable[[Sequence[int]], MistakeVariant]) -> Iterator[MistakeVariant]:
    """Yield a variant made at each of some places alone, and then at all of them, if they are several."""
    for place in places:
        yield replace(at([place]), places=(place,))
    if len(places) > 1:
        yield replace(at(places), places=tuple(places), at=at)


def scale_at(index: Any, factor: int) -> Change:
    """Return the change that multiplies the entries at an index of an array by a factor."""

    def scale(w: Working, values: np.ndarray) -> np.ndarray:
        scaled = np.array(values)
        scaled[index] = factor * scaled[index]
        return scaled

    return scale


def exchange(i: int, j: int, axis: int = 0) -> Change:
    """Return the change that exchanges two rows (axis 0) or columns (axis 1) of an array."""

    def apply_exchange(w: Working, values: np.ndarray) -> np.ndarray:
        order = list(range(values.shape[axis]))
        order[i], order[j] = j, i
        return values.take(order, axis)

    return apply_exchange
