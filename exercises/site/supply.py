"""Which problems the site has: so many arms of each family at every step of variation, and what is asked of each.

The first arm of a step is asked everything. The others share the questions, so that each comes with several more arms:
a page shows one question of an arm at a time, and thirty of each of thousands of arms would be worked out for nobody.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

from qdot.exercises.arm.chain import Chain
from qdot.exercises.assignment.draws import Failures, GivenUp, Variant, attempt, certified, vouching
from qdot.exercises.assignment.redrawn import DRAWS
from qdot.exercises.common.variation import DEFAULT, STEPS, canonical_name
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, listing_of, sample_chain, short_quiz
from qdot.exercises.problem.problem import Problem, ProblemId

QUIZ = "quiz"
MOST_SEEDS = 1000
"""More arms of a family than that are not asked for."""
OF_EACH_STEP = 25
"""So many arms of a family at every step, where nobody says how many."""
ARMS_EACH = 2
"""Beside the first arm of a step, so many others are asked any one question."""
QUIZ_SEEDS = 9
"""Up to this seed, every second arm also has short questions: one arm of each step."""
DRAWN_FROM = (1, 2, 3)
"""Seeds by which it is found out what comes in other numbers."""
LOOKED_FURTHER = 4
"""So many times the arms that are wanted are looked through for different ones: lengths alone make few."""


Told = tuple[str, str]
"""A convention, and an order of twists; "" of what is a family's own."""


@dataclass(frozen=True)
class Wanted:
    """A problem that is wanted in the bank: under which family and key, and what it is.

    `asked` are its questions: none stands for all of the chapter's that apply, QUIZ for a short one of each form.
    `variation` is how far its arm leads away from the chapter's. With `share`, which of so many shares, the arm is one
    that there is already, and it is asked a share of what comes with other numbers. `told` is the convention in which
    the arm is told, and the order of its twists, both "" where they are the family's.
    """

    family: str
    key: str
    seed: int = 0
    asked: tuple[str, ...] = ()
    variation: str = DEFAULT
    problem: Problem | None = None
    share: tuple[int, int] | None = None
    told: Told = ("", "")

    def made(self, draw: int = 1) -> Problem:
        """Return the problem; draws after the first have seeds that nobody else wants."""
        if self.problem is not None:
            return self.problem
        questions = self.asked
        if questions == (QUIZ,):
            questions = short_quiz(self.family, self.told[0])
        elif self.share is not None:
            questions = dealt(drawn_questions(self.family, self.told), *self.share)
        seed = self.seed + (draw - 1) * MOST_SEEDS
        return generate(ProblemId(self.family, seed, questions, variation=self.variation).told(*self.told))

    def certified(self, failures: Failures) -> Problem | GivenUp:
        """Return the first draw that passes its certificate. Raises QdotError for a problem that has no other draws."""
        if self.problem is not None:
            return certified(self.problem, failures)
        why = ""
        for draw in range(1, DRAWS + 1):
            made = attempt(partial(self.made, draw), vouching(failures))
            if not isinstance(made, str):
                return made[0]
            why = why or made
        return GivenUp("", self.key, self.family, why)


def of_variants(variants: Sequence[Variant]) -> list[Wanted]:
    """Return the variants of an assignment's bank, each place as a family of its own."""
    return [Wanted(variant.slot.name, variant.key, problem=variant.problem) for variant in variants]


def of_families(
    names: Sequence[str], variants: int, variation: str = "", convention: str = "", twist_order: str = ""
) -> list[Wanted]:
    """Return so many arms of each family; every second of the first ones also has short questions.

    Where no `variation` is asked for, the arms of a family climb its steps, over and over. All of them are told in a
    `convention`, with twists in an order, where these are named. Raises QdotError for what is none.
    """
    identity = ProblemId(names[0], 0).told(convention, twist_order)
    told = identity.convention, identity.twist_order
    steps = [canonical_name(variation)] if variation else list(STEPS)
    problems: list[Wanted] = []
    for name in names:
        climbing = (range(at, variants + 1, len(steps)) for at in range(1, len(steps) + 1))
        each = zip(steps, climbing, strict=True)
        arms = [replace(arm, told=told) for step, seeds in each for arm in _of_step(name, step, seeds, told)]
        for arm in sorted(arms, key=lambda arm: arm.seed):
            problems.append(arm)
            if arm.seed % 2 and arm.seed <= QUIZ_SEEDS and not FAMILIES[name].varied:
                problems.append(Wanted(name, f"{arm.key}-{QUIZ}", arm.seed, (QUIZ,), arm.variation, told=told))
    return problems


def _of_step(family: str, step: str, seeds: range, told: Told) -> Iterator[Wanted]:
    """Yield as many arms of a step as there are seeds: different ones first, then such as are there already."""
    if not seeds:
        return
    fresh, again = _different(family, step, seeds)
    wanted = partial(_wanted, family, step)
    yield wanted(fresh[0])
    for place, seed in enumerate(fresh[1:]):
        yield replace(wanted(seed), asked=dealt(_questions(family, told[0]), place, len(fresh) - 1))
    for place, seed in enumerate(again):
        yield replace(wanted(seed), share=(place, len(again)))


def _wanted(family: str, step: str, seed: int) -> Wanted:
    return Wanted(family, f"{seed:03d}", seed, variation=step)


def _different(family: str, step: str, seeds: range) -> tuple[list[int], list[int]]:
    """Return the seeds whose arms are different, also beyond those given, and as many of the others as are missing."""
    if FAMILIES[family].varied:  # each has a structure of its own
        return list(seeds), []
    end = min(seeds.start + LOOKED_FURTHER * len(seeds) * seeds.step, MOST_SEEDS + 1)
    first: dict[Chain, int] = {}
    again: list[int] = []
    for seed in range(seeds.start, end, seeds.step):
        if len(first) == len(seeds):
            break
        chain = sample_chain(ProblemId(family, seed, variation=step))
        if first.setdefault(chain, seed) != seed:
            again.append(seed)
    return list(first.values()), again[: len(seeds) - len(first)]


def dealt(names: Sequence[str], place: int, places: int) -> tuple[str, ...]:
    """Return the questions of one of so many arms that share them, in order: each comes with ARMS_EACH of the arms.

    Where the arms are no more than that, each is asked all.

    >>> [dealt("abcd", place, 4) for place in range(4)]
    [('a', 'b'), ('c', 'd'), ('a', 'b'), ('c', 'd')]
    """
    asked = max(min(ARMS_EACH, places) * len(names), places)
    own = {names[at % len(names)] for at in range(place * asked // places, (place + 1) * asked // places)}
    return tuple(name for name in names if name in own)


@lru_cache(maxsize=4)
def _questions(family: str, convention: str) -> tuple[str, ...]:
    return listing_of(family, convention).questions


@lru_cache(maxsize=4)
def drawn_questions(family: str, told: Told = ("", "")) -> tuple[str, ...]:
    """Return what is asked in other numbers of the same arm, as a pose or rates are drawn for it."""
    step, asked = next(iter(STEPS)), _questions(family, told[0])
    drawn = [generate(ProblemId(family, seed, asked, variation=step).told(*told)) for seed in DRAWN_FROM]
    read = [[json.dumps([part.answer.as_json(), repr(part.details)]) for part in problem.parts] for problem in drawn]
    return tuple(part.name for part, *ways in zip(drawn[0].parts, *read, strict=True) if len(set(ways)) > 1)
