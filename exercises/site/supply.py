"""The list of the site's problems: a number of arms of each family at every step of variation, with questions.

The first arm of a step gets all questions. The others share them, so that each question comes with several more arms:
a page shows one question of an arm at a time, and nobody needs all thirty questions for each of thousands of arms.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

from qdot.exercises.arm.chain import Chain
from qdot.exercises.assignment.draws import FailedSlot, Failures, Variant, attempt, certify_by, require_certified
from qdot.exercises.assignment.redrawn import DRAWS
from qdot.exercises.common.variation import DEFAULT, STEPS, canonical_name
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, listing_of, sample_chain, short_quiz
from qdot.exercises.problem.problem import Problem, ProblemId

QUIZ = "quiz"
MOST_SEEDS = 1000
"""Maximum number of arms of a family."""
OF_EACH_STEP = 25
"""Default number of arms of a family at every step."""
ARMS_EACH = 2
"""Number of arms that get each question, besides the first arm of a step."""
QUIZ_SEEDS = 9
"""Up to this seed, every second arm also has short questions: one arm of each step."""
DRAWN_FROM = (1, 2, 3)
"""Seeds that are compared to find the questions with sampled numbers."""
LOOKED_FURTHER = 4
"""How many arms to search for each one that is wanted, as variation of lengths alone gives few different ones."""


FrameConvention = tuple[str, str]
"""A convention and an order of twists; "" means the family's own."""


@dataclass(frozen=True)
class BankProblem:
    """A problem to be in the bank: its family, its key, and how to generate it.

    `asked` are its questions: none means all of the chapter's that apply, QUIZ a short one of each form. `variation` is
    how much its arm differs from the chapter's. `share` (index, number of shares) is for an arm that is in the bank
    already: it gets a share of the questions with sampled numbers. `frame_convention` describes the arm.
    """

    family: str
    key: str
    seed: int = 0
    asked: tuple[str, ...] = ()
    variation: str = DEFAULT
    problem: Problem | None = None
    share: tuple[int, int] | None = None
    frame_convention: FrameConvention = ("", "")

    def make(self, draw: int = 1) -> Problem:
        """Return the problem; draws after the first have seeds that no other problem has."""
        if self.problem is not None:
            return self.problem
        questions = self.asked
        if questions == (QUIZ,):
            questions = short_quiz(self.family, self.frame_convention[0])
        elif self.share is not None:
            questions = deal_questions(questions_with_sampled_numbers(self.family, self.frame_convention), *self.share)
        seed = self.seed + (draw - 1) * MOST_SEEDS
        return generate(
            ProblemId(self.family, seed, questions, variation=self.variation).with_convention(*self.frame_convention)
        )

    def find_certified(self, failures: Failures) -> Problem | FailedSlot:
        """Return the first draw that passes its certificate. Raises QdotError for a problem that has no other draws."""
        if self.problem is not None:
            return require_certified(self.problem, failures)
        why = ""
        for draw in range(1, DRAWS + 1):
            made = attempt(partial(self.make, draw), certify_by(failures))
            if not isinstance(made, str):
                return made[0]
            why = why or made
        return FailedSlot("", self.key, self.family, why)


def wanted_of_variants(variants: Sequence[Variant]) -> list[BankProblem]:
    """Return the variants of an assignment's bank, with each slot as a family."""
    return [BankProblem(variant.slot.name, variant.key, problem=variant.problem) for variant in variants]


def wanted_of_families(
    names: Sequence[str], variants: int, variation: str = "", convention: str = "", twist_order: str = ""
) -> list[BankProblem]:
    """Return `variants` arms of each family; every second one of the first also has short questions.

    Without a `variation`, the arms of a family go through its steps again and again. `convention` and `twist_order`
    apply to all of them, if given. Raises QdotError for unknown ones.
    """
    identity = ProblemId(names[0], 0).with_convention(convention, twist_order)
    frame_convention = identity.convention, identity.twist_order
    steps = [canonical_name(variation)] if variation else list(STEPS)
    problems: list[BankProblem] = []
    for name in names:
        climbing = (range(at, variants + 1, len(steps)) for at in range(1, len(steps) + 1))
        each = zip(steps, climbing, strict=True)
        arms = [
            replace(arm, frame_convention=frame_convention)
            for step, seeds in each
            for arm in _problems_of_step(name, step, seeds, frame_convention)
        ]
        for arm in sorted(arms, key=lambda arm: arm.seed):
            problems.append(arm)
            if arm.seed % 2 and arm.seed <= QUIZ_SEEDS and not FAMILIES[name].varied:
                problems.append(
                    BankProblem(
                        name, f"{arm.key}-{QUIZ}", arm.seed, (QUIZ,), arm.variation, frame_convention=frame_convention
                    )
                )
    return problems


def _problems_of_step(family: str, step: str, seeds: range, frame_convention: FrameConvention) -> Iterator[BankProblem]:
    """Yield as many arms of a step as there are seeds: distinct ones first, then repeated ones."""
    if not seeds:
        return
    fresh, again = _distinct_seeds(family, step, seeds)
    wanted = partial(_wanted_at_seed, family, step)
    yield wanted(fresh[0])
    for place, seed in enumerate(fresh[1:]):
        yield replace(
            wanted(seed), asked=deal_questions(_questions(family, frame_convention[0]), place, len(fresh) - 1)
        )
    for place, seed in enumerate(again):
        yield replace(wanted(seed), share=(place, len(again)))


def _wanted_at_seed(family: str, step: str, seed: int) -> BankProblem:
    return BankProblem(family, f"{seed:03d}", seed, variation=step)


def _distinct_seeds(family: str, step: str, seeds: range) -> tuple[list[int], list[int]]:
    """Return seeds with distinct arms, also beyond the given ones, and repeated ones to complete the number."""
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


def deal_questions(names: Sequence[str], place: int, places: int) -> tuple[str, ...]:
    """Return the questions of one of `places` arms that share them: each question comes with ARMS_EACH of the arms.

    If there are no more arms than that, each gets all questions.

    >>> [deal_questions("abcd", place, 4) for place in range(4)]
    [('a', 'b'), ('c', 'd'), ('a', 'b'), ('c', 'd')]
    """
    asked = max(min(ARMS_EACH, places) * len(names), places)
    chosen = {names[at % len(names)] for at in range(place * asked // places, (place + 1) * asked // places)}
    return tuple(name for name in names if name in chosen)


@lru_cache(maxsize=4)
def _questions(family: str, convention: str) -> tuple[str, ...]:
    return listing_of(family, convention).questions


@lru_cache(maxsize=4)
def questions_with_sampled_numbers(family: str, frame_convention: FrameConvention = ("", "")) -> tuple[str, ...]:
    """Return the questions with numbers that are sampled for the same arm, such as a pose or rates."""
    step, asked = next(iter(STEPS)), _questions(family, frame_convention[0])
    drawn = [
        generate(ProblemId(family, seed, asked, variation=step).with_convention(*frame_convention))
        for seed in DRAWN_FROM
    ]
    read = [[json.dumps([part.answer.as_json(), repr(part.details)]) for part in problem.parts] for problem in drawn]
    return tuple(part.name for part, *ways in zip(drawn[0].parts, *read, strict=True) if len(set(ways)) > 1)
