"""Generate wrong sets of singular configurations: one by a mistake, one by another mistake, and one by both."""

from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations, islice
from operator import itemgetter

from qdot.exercises.answer_types import ConditionSet
from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace, compare_sets
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import Piece, parse_pieces
from qdot.exercises.mistakes.catalogue import generate_mistaken_answers
from qdot.exercises.problem.problem import Part
from qdot.exercises.short_questions.options import (
    BEST_MISMATCH,
    Blame,
    LengthMismatch,
    OfferedOption,
    is_plausible,
    rate_lengths,
)
from qdot.exercises.singularities.classification import domain_of
from qdot.exercises.singularities.singularity import Component, singular_set

ComponentSet = tuple[Component, ...]

MAX_SETS_OF_FOUR = 60
MAX_PIECES = 6
"""Maximum number of pieces of a set in a short question."""


def make_four_sets(chain: Chain, rng: Stream) -> list[OfferedOption] | None:
    """Return the singular set and three wrong ones, or None if the mistakes of the catalogue don't give three."""
    correct_set = singular_set(chain)
    if not correct_set:
        return None
    intended_rank, scored_options = rng.integer_below(4), list[tuple[LengthMismatch, list[OfferedOption]]]()
    for options in islice(_make_sets_of_four(chain, correct_set, rng), MAX_SETS_OF_FOUR):
        score = _rate_options(options, intended_rank)
        if score is not None and score[:2] != BEST_MISMATCH:
            scored_options.append((score, options))
        elif score is not None and are_different_sets(chain, options):
            return options
    scored_options.sort(key=itemgetter(0))
    return next((options for _, options in scored_options if are_different_sets(chain, options)), None)


def _rate_options(options: list[OfferedOption], intended_rank: int) -> LengthMismatch | None:
    """Return how badly options match, or None if they are unsuitable. This is much faster than `are_different_sets`."""
    texts = [option.text for option in options]
    if len(set(texts)) < 4 or any(text.count(" or ") >= MAX_PIECES for text in texts):
        return None
    return rate_lengths(list(map(len, texts)), intended_rank, tolerance=2)


def _make_sets_of_four(chain: Chain, correct_set: ComponentSet, rng: Stream) -> Iterator[list[OfferedOption]]:
    single_mistake_sets = make_wrong_sets(chain, correct_set)
    pairs = rng.permutation(list(combinations(single_mistake_sets, 2)))
    for wrong_set, second_set in pairs:
        for set_with_both in make_wrong_sets(chain, _get_components(wrong_set)):
            if set_with_both.behind == second_set.behind:
                blames = (*wrong_set.behind, *second_set.behind)
                yield [OfferedOption(correct_set), wrong_set, second_set, OfferedOption(set_with_both.shown, blames)]
    for wrong_options in rng.permutation(list(islice(combinations(single_mistake_sets, 3), MAX_SETS_OF_FOUR))):
        yield [OfferedOption(correct_set), *wrong_options]


def _get_components(option: OfferedOption) -> ComponentSet:
    assert isinstance(option.shown, tuple)
    return option.shown


@lru_cache(maxsize=4096)
def make_wrong_sets(chain: Chain, components: ComponentSet) -> tuple[OfferedOption, ...]:
    """Return the wrong sets that single mistakes give, each with its mistake."""
    part = Part("singular-angles", "singular-angles", ConditionSet(components))
    return tuple(
        OfferedOption(variant.answer.components, (Blame.from_mistake(mistake, variant.words.items()),))
        for mistake, variant in generate_mistaken_answers(chain, part)
        if is_plausible(mistake) and isinstance(variant.answer, ConditionSet)
    )


def are_different_sets(chain: Chain, options: list[OfferedOption]) -> bool:
    """Return whether the sets contain different configurations, and none is empty."""
    texts = [tuple(ConditionSet(_get_components(option)).pieces()) for option in options]
    return all(not _are_equal_sets(chain, a, b) for a, b in combinations(texts, 2))


@lru_cache(maxsize=20_000)
def _are_equal_sets(chain: Chain, a: tuple[str, ...], b: tuple[str, ...]) -> bool:
    joints = [q.name for q in chain.q]
    space = ConfigurationSpace(joints, domain_of(chain))
    comparison = compare_sets(_parse_pieces(a, joints), _parse_pieces(b, joints), space, "quiz")
    return comparison.are_equal or all(example is None for example in (*comparison.is_covered, *comparison.is_sound))


def _parse_pieces(texts: tuple[str, ...], joints: list[str]) -> list[Piece]:
    return [piece for text in texts for piece in parse_pieces(parse_formula(text), joints)]
