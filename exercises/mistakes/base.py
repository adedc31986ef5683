"""What a mistake is: a change to a derivation, or to an answer, and the message to the student."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from qdot.exercises.answers import Answer
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import REGISTRY, convention_of
from qdot.exercises.arm.derivation_graph import Change
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


def at_each_and_all(places: Sequence[int], at: Callable[[Sequence[int]], MistakeVariant]) -> Iterator[MistakeVariant]:
    """Yield a variant made at each of some places alone, and then at all of them, if they are several."""
    for place in places:
        yield replace(at([place]), places=(place,))
    if len(places) > 1:
        yield replace(at(places), places=tuple(places), at=at)


@dataclass(frozen=True)
class MistakenAnswer:
    """One way to mistake an answer that no derivation gives: the answer that is given instead."""

    answer: Answer
    words: Mapping[str, object] = field(default_factory=dict)


Variants = Callable[[Chain, Shape], Iterator[MistakeVariant]]
"""The ways to make a mistake on an arm; the shape is that of the answer in which it shows."""

MISREADINGS = frozenset().union(*(each.misreadings for each in REGISTRY.values()))
"""The mistakes of those who read an arm in another convention than its own."""

Answers = Callable[[Chain, Part], Iterator[MistakenAnswer]]
"""The ways to make a mistake with the answer to a part."""


def no_variants(chain: Chain, about: object) -> Iterator[MistakeVariant]:
    """Make no mistake."""
    yield from ()


def no_answers(chain: Chain, part: Part) -> Iterator[MistakenAnswer]:
    """Make no mistake."""
    yield from ()


def only_for_tables(mistakes: Iterable["Mistake"], but: AbstractSet[str] = frozenset()) -> tuple["Mistake", ...]:
    """Restrict mistakes, `but` some, to arms with a table: an arm described by its axes has no frames on its links."""
    return tuple(
        mistake
        if mistake.name in but
        else replace(
            mistake,
            slips=partial(_if_possible, mistake.name, mistake.slips),
            takes=partial(_if_possible, mistake.name, mistake.takes),
        )
        for mistake in mistakes
    )


def _if_possible(name: str, make: Callable[[Chain, Any], Iterator[Any]], chain: Chain, about: Any) -> Iterator[Any]:
    convention = convention_of(chain)
    possible = convention.has_frames and (name in convention.misreadings or name not in MISREADINGS)
    return make(chain, about) if possible else iter(())


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
    slips: Variants = no_variants
    takes: Answers = no_answers
    rare: bool = False

    def sentence(self, words: Mapping[str, object]) -> str:
        """Return the message to the student, and where to look."""
        return f"{self.says.format(**words)} See {self.where}."

    @property
    def where(self) -> str:
        """The place in the chapter, as words after "See"; numbers are those of formulas."""
        return f"({self.source})" if self.source[0].isdigit() else self.source
