"""Wrong sets of singular configurations: with one mistake, with another, and with both."""

from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations, islice
from operator import itemgetter

from qdot.exercises.answers import ConditionSet
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import domain_of
from qdot.exercises.arm.singularity import Component, singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import Space, compare_sets
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.set_parser import Piece, parse_pieces
from qdot.exercises.mistakes.catalogue import mistaken_answers
from qdot.exercises.problem.problem import Part
from qdot.exercises.quizzes.options import MOST_SPREAD, SHOWS_ITSELF, SPREAD, Blame, OfferedOption, rank_right_option

Components = tuple[Component, ...]

PAIRS = 60
MOST_PIECES = 6
"""Maximum number of pieces of a set in a short question."""


def make_four_sets(chain: Chain, rng: Stream) -> list[OfferedOption] | None:
    """Return the singular set and three wrong ones, or None if the mistakes of the catalogue don't give three."""
    correct_set = singular_set(chain)
    if not correct_set:
        return None
    intended_rank, scored_options = rng.below(4), list[tuple[Score, list[OfferedOption]]]()
    for options in islice(_make_sets_of_four(chain, correct_set, rng), PAIRS):
        score = _rate_options(options, intended_rank)
        if score is not None and score[:2] != BEST:
            scored_options.append((score, options))
        elif score is not None and all_differ(chain, options):
            return options
    scored_options.sort(key=itemgetter(0))
    return next((options for _, options in scored_options if all_differ(chain, options)), None)


Score = tuple[bool, int, float]
"""How badly options match: whether their lengths differ much, how far the correct one is from its intended rank by
length, and the length ratio of the longest to the shortest."""
BEST = (False, 0)
"""The first two components of the best possible score."""


def _rate_options(options: list[OfferedOption], wanted: int) -> Score | None:
    """Return how badly options match, or None if they are unsuitable. This is much faster than `all_differ`."""
    texts = [option.text for option in options]
    if len(set(texts)) < 4 or any(text.count(" or ") >= MOST_PIECES for text in texts):
        return None
    lengths = [len(text) for text in texts]
    spread = max(lengths) / min(lengths)
    if spread > 2 * MOST_SPREAD:
        return None
    return (spread > 2 * SPREAD, abs(rank_right_option(lengths) - wanted), spread)


def _make_sets_of_four(chain: Chain, right: Components, rng: Stream) -> Iterator[list[OfferedOption]]:
    single_mistake_sets = wrong_sets(chain, right)
    pairs = rng.permutation(list(combinations(single_mistake_sets, 2)))
    for wrong_set, second_set in pairs:
        for set_with_both in wrong_sets(chain, _components_of(wrong_set)):
            if set_with_both.behind == second_set.behind:
                blames = (*wrong_set.behind, *second_set.behind)
                yield [OfferedOption(right), wrong_set, second_set, OfferedOption(set_with_both.shown, blames)]
    for wrong_options in rng.permutation(list(islice(combinations(single_mistake_sets, 3), PAIRS))):
        yield [OfferedOption(right), *wrong_options]


def _components_of(option: OfferedOption) -> Components:
    assert isinstance(option.shown, tuple)
    return option.shown


@lru_cache(maxsize=4096)
def wrong_sets(chain: Chain, components: Components) -> tuple[OfferedOption, ...]:
    """Return the wrong sets that single mistakes give, each with its mistake."""
    part = Part("singular-angles", "singular-angles", ConditionSet(components))
    return tuple(
        OfferedOption(variant.answer.components, (Blame.of(mistake, variant.words.items()),))
        for mistake, variant in mistaken_answers(chain, part)
        if not mistake.rare and mistake.name not in SHOWS_ITSELF and isinstance(variant.answer, ConditionSet)
    )


def all_differ(chain: Chain, options: list[OfferedOption]) -> bool:
    """Return whether the sets contain different configurations, and none is empty."""
    texts = [tuple(piece for component in _components_of(option) for piece in component.pieces()) for option in options]
    return all(not _are_same(chain, a, b) for a, b in combinations(texts, 2))


@lru_cache(maxsize=20_000)
def _are_same(chain: Chain, a: tuple[str, ...], b: tuple[str, ...]) -> bool:
    joints = [q.name for q in chain.q]
    space = Space(joints, domain_of(chain))
    comparison = compare_sets(_parse_pieces(a, joints), _parse_pieces(b, joints), space, "quiz")
    return comparison.equal or all(example is None for example in (*comparison.covered, *comparison.sound))


def _parse_pieces(texts: tuple[str, ...], joints: list[str]) -> list[Piece]:
    return [piece for text in texts for piece in parse_pieces(read(text), joints)]
