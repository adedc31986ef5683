"""Generate wrong sets of singular configurations as options: by one mistake, by another one, and by both mistakes."""

from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations, islice
from operator import itemgetter

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace, compare_sets
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import Piece, parse_pieces
from qdot.exercises.mistakes.catalogue import generate_mistaken_answers
from qdot.exercises.problem.problem import Part
from qdot.exercises.reference_answers import ConditionSet
from qdot.exercises.short_questions import options
from qdot.exercises.short_questions.options import Blame, OfferedOption
from qdot.exercises.singularities.classification import make_domain
from qdot.exercises.singularities.singular_set import Component

ComponentSet = tuple[Component, ...]

MAX_SETS_OF_FOUR = 60
"""Maximum number of groups of four options that are compared."""
MAX_PIECES = 6
"""Maximum number of pieces of a set that is offered as an option."""


def make_four_sets(chain: Chain, correct_set: ComponentSet, rng: Stream) -> list[OfferedOption] | None:
    """Return the correct set and three wrong sets as options, or None if known mistakes don't lead to three sets."""
    intended_rank = rng.integer_below(4)
    candidates: list[tuple[options.LengthMismatch, list[OfferedOption]]] = []
    for four_options in islice(_make_sets_of_four(chain, correct_set, rng), MAX_SETS_OF_FOUR):
        mismatch = _find_length_mismatch(four_options, intended_rank)
        if mismatch is not None and not mismatch.is_best:
            candidates.append((mismatch, four_options))
        elif mismatch is not None and are_different_sets(chain, four_options):
            return four_options
    candidates.sort(key=itemgetter(0))
    return next((four_options for _, four_options in candidates if are_different_sets(chain, four_options)), None)


def _find_length_mismatch(four_options: list[OfferedOption], intended_rank: int) -> options.LengthMismatch | None:
    """Return how badly the lengths of the options' texts match; None for unsuitable options.

    This check is much faster than `are_different_sets`.
    """
    texts = [option.text for option in four_options]
    correct_count, *wrong_counts = (text.count(" or ") for text in texts)
    if len(set(texts)) < 4 or max(correct_count, *wrong_counts) >= MAX_PIECES or correct_count not in wrong_counts:
        return None  # a correct set with another number of pieces than all wrong sets would stand out
    return options.find_length_mismatch(list(map(len, texts)), intended_rank, tolerance=2)


def _make_sets_of_four(chain: Chain, correct_set: ComponentSet, rng: Stream) -> Iterator[list[OfferedOption]]:
    """Yield groups of four options: the correct set, and those that two mistakes give, alone and together.

    Later groups have the sets that any three mistakes give.
    """
    wrong_sets = make_wrong_sets(chain, correct_set)
    for first_set, second_set in rng.permutation(list(combinations(wrong_sets, 2))):
        for set_with_both in make_wrong_sets(chain, first_set.content):
            if set_with_both.blames == second_set.blames:
                blames = (*first_set.blames, *second_set.blames)
                yield [OfferedOption(correct_set), first_set, second_set, OfferedOption(set_with_both.content, blames)]
    for three_sets in rng.permutation(list(islice(combinations(wrong_sets, 3), MAX_SETS_OF_FOUR))):
        yield [OfferedOption(correct_set), *three_sets]


@lru_cache(maxsize=4096)
def make_wrong_sets(chain: Chain, components: ComponentSet) -> tuple[OfferedOption, ...]:
    """Return the wrong sets that known mistakes give instead of the set of `components`, each with its mistake."""
    part = Part("singular-angles", "singular-angles", ConditionSet(components))
    return tuple(
        OfferedOption(mistaken_answer.answer.components, (Blame.from_mistake(mistake, mistaken_answer.words.items()),))
        for mistake, mistaken_answer in generate_mistaken_answers(chain, part)
        if options.is_plausible(mistake) and isinstance(mistaken_answer.answer, ConditionSet)
    )


def are_different_sets(chain: Chain, four_options: list[OfferedOption]) -> bool:
    """Return whether the sets contain different configurations, and whether none of the sets is empty."""
    pieces = [tuple(ConditionSet(option.content).list_pieces()) for option in four_options]
    return all(not _are_equal_sets(chain, a, b) for a, b in combinations(pieces, 2))


@lru_cache(maxsize=20_000)
def _are_equal_sets(chain: Chain, a: tuple[str, ...], b: tuple[str, ...]) -> bool:
    joints = [q.name for q in chain.q]
    space = ConfigurationSpace(joints, make_domain(chain))
    comparison = compare_sets(_parse_pieces(a, joints), _parse_pieces(b, joints), space, "quiz")
    return comparison.are_equal or all(example is None for example in (*comparison.is_covered, *comparison.is_sound))


def _parse_pieces(texts: tuple[str, ...], joints: list[str]) -> list[Piece]:
    return [piece for text in texts for piece in parse_pieces(parse_formula(text), joints)]
