"""The problems of the site's bank: how many arms each family and step has, that they differ, and what each is asked."""

from collections import Counter
from itertools import product

import pytest

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import find_listing, generate, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.site.bank_problem import (
    ARMS_PER_QUESTION,
    ARMS_PER_STEP,
    QUIZ,
    BankProblem,
    deal_questions,
    find_questions_with_sampled_numbers,
    list_problems_of_families,
)
from tests.support.suites import few_families, sample_for_suite, select_for_suite

ALL = ARMS_PER_STEP * len(VARIATION_STEPS)


def arms(family: str, variants: int) -> list[BankProblem]:
    return [wanted for wanted in list_problems_of_families([family], variants) if wanted.questions != (QUIZ,)]


@pytest.mark.whole
def test_family_has_so_many_arms_at_every_step() -> None:
    wanted = list_problems_of_families(list(FAMILIES), ALL)
    assert len({(one.family, one.key) for one in wanted}) == len(wanted)
    counts = Counter((one.family, one.variation) for one in wanted if one.questions != (QUIZ,))
    assert counts == {(family, step): ARMS_PER_STEP for family in FAMILIES for step in VARIATION_STEPS}


@few_families
def test_arms_of_a_step_differ_and_every_question_comes_with_several_of_them(family: str) -> None:
    if FAMILIES[family].has_varied_structure:
        pytest.skip("its arms have structures of their own, which are drawn as they are made")
    wanted = arms(family, ALL)
    for step in VARIATION_STEPS:
        of_step = [one for one in wanted if one.variation == step]
        fresh = [one for one in of_step if one.question_share is None]
        chains = {sample_chain(ProblemId(family, one.seed, variation=step)) for one in fresh}
        assert len(chains) == len(fresh)
        assert fresh[0].questions == ()
        others = Counter(name for one in fresh[1:] for name in one.questions)
        assert others == dict.fromkeys(
            find_listing(family).questions if fresh[1:] else (), min(ARMS_PER_QUESTION, len(fresh) - 1)
        )
        again = [one for one in of_step if one.question_share is not None]
        assert {sample_chain(ProblemId(family, one.seed, variation=step)) for one in again} <= chains
    assert len([one for one in wanted if one.variation == "full" and one.question_share is None]) == ARMS_PER_STEP


def test_few_arms_are_asked_everything() -> None:
    assert [one.variation for one in arms("scara", 6)] == [*VARIATION_STEPS, "chapter"]
    assert {one.variation for one in list_problems_of_families(["scara"], 3, "base+lengths")} == {"lengths+base"}
    everything = find_listing("scara").questions
    asked = {
        one.questions
        for one in arms("scara", len(VARIATION_STEPS) * (1 + ARMS_PER_QUESTION))
        if one.question_share is None
    }
    assert asked <= {(), everything}
    assert len(arms("scara", 3)) == 3


@pytest.mark.families(select_for_suite(("polar-rp", "wrist-zyz"), tuple(FAMILIES)), every=True)
def test_an_arm_that_is_there_already_is_asked_what_comes_in_other_numbers(family: str) -> None:
    if FAMILIES[family].has_varied_structure:
        pytest.skip("its arms are never there already")
    names = find_questions_with_sampled_numbers(family)
    assert names and "position" not in names and "determinant" not in names
    assert set(names) < set(find_listing(family).questions)
    again = [one for one in arms(family, ALL) if one.variation == "chapter" and one.question_share is not None]
    assert len(again) == ARMS_PER_STEP - 1
    asked = Counter(name for one in again for name in deal_questions(names, *(one.question_share or (0, 1))))
    assert set(asked) == set(names) and min(asked.values()) >= ARMS_PER_QUESTION
    first = generate(ProblemId(family, 1, names, variation="chapter"))
    told: dict[str, set[str]] = {name: set() for name in names}
    for seed in (one.seed for one in again):
        left = tuple(name for name in names if len(told[name]) < 2)
        if left:
            other = generate(ProblemId(family, seed, left, variation="chapter"))
            assert other.chain == first.chain
            for part in other.parts:
                told[part.name].add(repr((part.answer.as_json(), part.details)))
    assert all(len(ways) > 1 for ways in told.values()), told


def test_questions_are_dealt_evenly() -> None:
    for count, places in product(range(1, 31), (1, 2, 3, 4, 24, 100)):
        names = [f"q{i}" for i in range(count)]
        hands = [deal_questions(names, place, places) for place in range(places)]
        assert all(hands) and all(list(hand) == sorted(hand, key=names.index) for hand in hands)
        counts = Counter(name for hand in hands for name in hand)
        assert set(counts) == set(names), (count, places)
        assert max(counts.values()) - min(counts.values()) <= 1, (count, places)
        assert min(counts.values()) >= min(ARMS_PER_QUESTION, places), (count, places)


@pytest.mark.parametrize(
    ("convention", "twist_order", "told"),
    sample_for_suite(
        [
            ("screws", "", ("screws", "")),
            ("", "v-omega", ("screws", "v-omega")),
            ("modified-dh", "", ("modified-dh", "")),
            ("dh", "", ("", "")),
        ],
        2,
    ),
)
def test_a_site_is_told_in_a_convention_throughout(convention: str, twist_order: str, told: tuple[str, str]) -> None:
    wanted = list_problems_of_families(["planar-2r"], ALL, "", convention, twist_order)
    assert [(one.key, one.seed, one.variation) for one in wanted] == [
        (one.key, one.seed, one.variation) for one in list_problems_of_families(["planar-2r"], ALL)
    ]
    assert {one.frame_convention for one in wanted} == {told}
    first, quiz, shared = (
        next(one for one in wanted if one.questions == asked and bool(one.question_share) == is_shared)
        for asked, is_shared in (((), False), ((QUIZ,), False), ((), True))
    )
    for one in (first, quiz, shared):
        made = one.generate()
        assert (made.id.convention, made.id.twist_order) == told
        assert made.chain.convention == (told[0] or "dh")
        assert made.chain.twist_order == (told[1] or "omega-v")
        assert made.parts
    asked = {part.name for part in first.generate().parts}
    assert ("space-jacobian" in asked) == (told[0] == "screws")


def test_every_question_of_a_convention_comes_with_several_arms() -> None:
    of_step = [one for one in list_problems_of_families(["planar-3r"], ALL, "", "screws") if one.variation == "full"]
    others = Counter(name for one in of_step if one.question_share is None for name in one.questions if name != QUIZ)
    assert others == dict.fromkeys(find_listing("planar-3r", "screws").questions, ARMS_PER_QUESTION)
    assert "body-jacobian" in others


def test_an_order_of_twists_beside_a_table_is_refused() -> None:
    with pytest.raises(QdotError, match="order of twists"):
        list_problems_of_families(["planar-2r"], 1, "", "modified-dh", "v-omega")
    with pytest.raises(QdotError, match="'srews'"):
        list_problems_of_families(["planar-2r"], 1, "", "srews")
