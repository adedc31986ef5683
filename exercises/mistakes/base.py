"""What a mistake is: a change to a derivation, or to an answer, and what is said to who made it."""

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
class Slip:
    """One way in which a mistake is made on an arm: the stages that change, and the words for the sentence.

    `missing` are symbols of what is left out. The sentence has no place for them: it is a part of quizzes, whose ids
    give the same for ever. `places` are the joints, from 0, of a slip that can be made at each of several or at all of
    them, and `at` makes it at some of these.
    """

    changes: Mapping[str, Change]
    words: Mapping[str, object] = field(default_factory=dict)
    missing: str = ""
    places: tuple[int, ...] = ()
    at: "Callable[[Sequence[int]], Slip] | None" = None

    def but_at(self, idle: AbstractSet[int]) -> "Slip | None":
        """Return a slip at several places without those where it changes nothing; None if fewer than two are left."""
        places = [place for place in self.places if place not in idle]
        return replace(self.at(places), places=tuple(places)) if self.at and len(places) > 1 else None


def at_each_and_all(places: Sequence[int], at: Callable[[Sequence[int]], Slip]) -> Iterator[Slip]:
    """Yield a slip made at each of some places alone, and then at all of them, if they are several."""
    for place in places:
        yield replace(at([place]), places=(place,))
    if len(places) > 1:
        yield replace(at(places), places=tuple(places), at=at)


@dataclass(frozen=True)
class Taken:
    """One way in which a mistake is made with an answer that no derivation gives: what it is taken for."""

    answer: Answer
    words: Mapping[str, object] = field(default_factory=dict)


Slips = Callable[[Chain, Shape], Iterator[Slip]]
"""The ways to make a mistake on an arm; the shape is that of the answer that it shows in."""

MISREADINGS = frozenset().union(*(each.misreadings for each in REGISTRY.values()))
"""The mistakes of those who read an arm in another convention than its own."""

Takes = Callable[[Chain, Part], Iterator[Taken]]
"""The ways to make a mistake with the answer to a part."""


def never(chain: Chain, about: object) -> Iterator[Slip]:
    """Make no mistake."""
    yield from ()


def not_taken(chain: Chain, part: Part) -> Iterator[Taken]:
    """Make no mistake."""
    yield from ()


def of_frames(mistakes: Iterable["Mistake"], but: AbstractSet[str] = frozenset()) -> tuple["Mistake", ...]:
    """Return mistakes, `but` some, as ones that speak of a table or its frames: an arm told by its axes has none."""
    return tuple(
        one
        if one.name in but
        else replace(
            one, slips=partial(_if_possible, one.name, one.slips), takes=partial(_if_possible, one.name, one.takes)
        )
        for one in mistakes
    )


def _if_possible(name: str, made: Callable[[Chain, Any], Iterator[Any]], chain: Chain, about: Any) -> Iterator[Any]:
    convention = convention_of(chain)
    possible = convention.has_frames and (name in convention.misreadings or name not in MISREADINGS)
    return made(chain, about) if possible else iter(())


@dataclass(frozen=True)
class Mistake:
    """A kind of mistake.

    `says` is the sentence to the student: what seems to have happened and where to look, with the words of the slip in
    braces; it gives no answer away. `source` is where the chapter has it right. A rare one is named only where no other
    gives the same answer.
    """

    name: str
    title: str
    says: str
    source: str
    slips: Slips = never
    takes: Takes = not_taken
    rare: bool = False

    def sentence(self, words: Mapping[str, object]) -> str:
        """Return what is said, and where to look."""
        return f"{self.says.format(**words)} See {self.where}."

    @property
    def where(self) -> str:
        """The place in the chapter as words behind "See"; numbers are those of formulas."""
        return f"({self.source})" if self.source[0].isdigit() else self.source
