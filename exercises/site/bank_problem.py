"""List the problems of the site's bank: several arms of each family at every step of variation, with their questions.

A step of variation is how much arms may differ from the chapter's (`common.variation`). The first arm of a step gets
all questions. The questions are divided among the other arms, so that each question is asked about several more arms. A
page shows only one question of an arm at a time, so thousands of arms don't need all thirty questions each.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

from qdot.exercises.arm.chain import Chain
from qdot.exercises.assignment.certified_problems import (
    FailedSlot,
    FailureFinder,
    Variant,
    certify_with,
    generate_and_certify,
    require_certified,
)
from qdot.exercises.assignment.replacements import MAX_SEEDS
from qdot.exercises.common.errors import Reason
from qdot.exercises.common.variation import DEFAULT_VARIATION, VARIATION_STEPS, find_canonical_name
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import find_listing, generate, sample_chain, select_quiz_questions
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions.base import Question
from qdot.exercises.short_questions import ALL_QUESTIONS, question_of

QUIZ = "quiz"
MAX_ARMS = 1000
"""Maximum number of arms of a family; larger seeds are for replacements of problems that fail."""
ARMS_PER_STEP = 25
"""Default number of arms of a family at every step."""
ARMS_PER_QUESTION = 2
"""Number of arms that get each question, in addition to the first arm of a step."""
MAX_QUIZ_SEED = 9
"""Arms with an odd seed up to this one also have short questions: one arm of each of the five steps of variation,
because the steps follow each other in the order of the seeds."""
COMPARED_SEEDS = (1, 2, 3)
"""Seeds whose problems are compared to find the questions with sampled numbers, such as joint rates."""
MAX_SEEDS_PER_ARM = 4
"""Maximum number of seeds to try for each arm, because some steps of variation give few different arms."""


class FrameConvention(NamedTuple):
    """A convention (such as standard DH) and an order of twists; "" means the default of the family."""

    name: str = ""
    twist_order: str = ""


DEFAULT_FRAME_CONVENTION = FrameConvention()


class ArmShare(NamedTuple):
    """The index of an arm among the arms that share the same questions, and the number of these arms."""

    arm_index: int
    arm_count: int


@dataclass(frozen=True)
class BankProblem:
    """A problem for the bank: its family, its key, and how to generate it.

    - `questions`: the names of its questions; () means all questions of the chapter that apply to the arm, and (QUIZ,)
      one short question of each form
    - `variation`: how much its arm differs from the chapter's
    - `problem`: the problem, if it exists already
    - `question_share`: for an arm that is in the bank already, its share of the questions with sampled numbers
    - `frame_convention`: the convention and the order of twists that describe the arm
    """

    family: str
    key: str
    seed: int = 0
    questions: tuple[str, ...] = ()
    variation: str = DEFAULT_VARIATION
    problem: Problem | None = None
    question_share: ArmShare | None = None
    frame_convention: FrameConvention = DEFAULT_FRAME_CONVENTION

    def generate(self, seed_number: int = 1) -> Problem:
        """Return the problem; a `seed_number` above 1 gives a replacement if the problem failed its certificate.

        No other problem has the seed of a replacement.
        """
        if self.problem is not None:
            return self.problem
        questions = self.questions
        if questions == (QUIZ,):
            questions = select_quiz_questions(self.family, self.frame_convention.name)
        elif self.question_share is not None:
            names = find_questions_with_sampled_numbers(self.family, self.frame_convention)
            questions = deal_questions(names, *self.question_share)
        identity = ProblemId(self.family, self.seed + (seed_number - 1) * MAX_ARMS, questions, variation=self.variation)
        return generate(identity.with_convention(*self.frame_convention))

    def find_certified(self, find_failures: FailureFinder) -> Problem | FailedSlot:
        """Return the problem with the first seed that passes. Raises QdotError if an existing `problem` fails."""
        if self.problem is not None:
            return require_certified(self.problem, find_failures)
        first_failure = ""
        for seed_number in range(1, MAX_SEEDS + 1):
            result = generate_and_certify(partial(self.generate, seed_number), partial(certify_with, find_failures))
            if not isinstance(result, Reason):
                problem, _ = result
                return problem
            first_failure = first_failure or result
        return FailedSlot("", self.key, self.family, first_failure)


def list_problems_of_variants(variants: Sequence[Variant]) -> list[BankProblem]:
    """Return the problems for the variants of an assignment's bank; the name of a slot replaces the family's name."""
    return [BankProblem(variant.slot.name, variant.key, problem=variant.problem) for variant in variants]


def find_custom_questions(problems: Sequence[BankProblem]) -> list[Question]:
    """Return the questions that an instructor has defined, each once."""
    parts = [part for problem in problems if problem.problem is not None for part in problem.problem.parts]
    return list({part.kind: question_of(part) for part in parts if part.kind not in ALL_QUESTIONS}.values())


def list_problems_of_families(
    names: Sequence[str], arm_count: int, variation: str = "", convention: str = "", twist_order: str = ""
) -> list[BankProblem]:
    """Return the problems for `arm_count` arms of each family; some of the arms have short questions, too.

    Without a `variation`, the arms of a family cycle through the steps of variation. `convention` and `twist_order`
    apply to all arms, if given. Raises QdotError for unknown names.
    """
    identity = ProblemId(names[0], 0).with_convention(convention, twist_order)
    frame_convention = FrameConvention(identity.convention, identity.twist_order)
    steps = [find_canonical_name(variation)] if variation else list(VARIATION_STEPS)
    problems: list[BankProblem] = []
    for name in names:
        main_problems: list[BankProblem] = []
        for first_seed, step in enumerate(steps, 1):
            seeds = range(first_seed, arm_count + 1, len(steps))
            main_problems += _list_problems(name, step, seeds, frame_convention)
        for problem in sorted(main_problems, key=lambda problem: problem.seed):
            problems.append(problem)
            if problem.seed % 2 and problem.seed <= MAX_QUIZ_SEED and not FAMILIES[name].has_varied_structure:
                problems.append(replace(problem, key=f"{problem.key}-{QUIZ}", questions=(QUIZ,), question_share=None))
    return problems


def _list_problems(family: str, step: str, seeds: range, frame_convention: FrameConvention) -> Iterator[BankProblem]:
    """Yield the problems of a step, one for each seed: first distinct arms, then arms that are in the bank already."""
    if not seeds:
        return
    make_problem = partial(BankProblem, family, variation=step, frame_convention=frame_convention)
    distinct_seeds, repeated_seeds = _find_distinct_seeds(family, step, seeds)
    yield make_problem(f"{distinct_seeds[0]:03d}", distinct_seeds[0])
    for index, seed in enumerate(distinct_seeds[1:]):
        names = deal_questions(_list_questions(family, frame_convention.name), index, len(distinct_seeds) - 1)
        yield make_problem(f"{seed:03d}", seed, names)
    for index, seed in enumerate(repeated_seeds):
        yield make_problem(f"{seed:03d}", seed, question_share=ArmShare(index, len(repeated_seeds)))


def _find_distinct_seeds(family: str, step: str, seeds: range) -> tuple[list[int], list[int]]:
    """Return seeds with distinct arms, and seeds with repeated arms, in total as many as there are `seeds`.

    If there are too few distinct arms, larger seeds are tried, too.
    """
    if FAMILIES[family].has_varied_structure:  # all arms are distinct
        return list(seeds), []
    seed_limit = min(seeds.start + MAX_SEEDS_PER_ARM * len(seeds) * seeds.step, MAX_ARMS + 1)
    seed_by_arm: dict[Chain, int] = {}
    repeated_seeds: list[int] = []
    for seed in range(seeds.start, seed_limit, seeds.step):
        if len(seed_by_arm) == len(seeds):
            break
        chain = sample_chain(ProblemId(family, seed, variation=step))
        if seed_by_arm.setdefault(chain, seed) != seed:
            repeated_seeds.append(seed)
    return list(seed_by_arm.values()), repeated_seeds[: len(seeds) - len(seed_by_arm)]


def deal_questions(names: Sequence[str], arm_index: int, arm_count: int) -> tuple[str, ...]:
    """Return the questions for arm number `arm_index` (from 0) of `arm_count` arms that share the questions.

    Each question is asked about ARMS_PER_QUESTION arms. If there are no more arms than that, each gets all questions.

    >>> [deal_questions("abcd", index, 4) for index in range(4)]
    [('a', 'b'), ('c', 'd'), ('a', 'b'), ('c', 'd')]
    """
    # The questions are dealt to the arms like cards, over and over, until `deal_count` of them are dealt.
    deal_count = max(min(ARMS_PER_QUESTION, arm_count) * len(names), arm_count)
    question_indices = range(arm_index * deal_count // arm_count, (arm_index + 1) * deal_count // arm_count)
    chosen_names = {names[index % len(names)] for index in question_indices}
    return tuple(name for name in names if name in chosen_names)


@lru_cache(maxsize=4)
def _list_questions(family: str, convention: str) -> tuple[str, ...]:
    return find_listing(family, convention).questions


@lru_cache(maxsize=4)
def find_questions_with_sampled_numbers(
    family: str, frame_convention: FrameConvention = DEFAULT_FRAME_CONVENTION
) -> tuple[str, ...]:
    """Return the questions that have sampled numbers, such as joint rates, which differ between problems on one arm."""
    first_step, questions = next(iter(VARIATION_STEPS)), _list_questions(family, frame_convention.name)
    # At the first step, all arms are the chapter's own, so only sampled numbers can differ.
    identities = [ProblemId(family, seed, questions, variation=first_step) for seed in COMPARED_SEEDS]
    problems = [generate(identity.with_convention(*frame_convention)) for identity in identities]
    parts_of_questions = zip(*(problem.parts for problem in problems), strict=True)
    answers = {
        parts[0].name: {json.dumps([part.answer.as_json(), repr(part.details)]) for part in parts}
        for parts in parts_of_questions
    }
    return tuple(name for name, different_answers in answers.items() if len(different_answers) > 1)
