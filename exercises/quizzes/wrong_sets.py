"""Wrong sets of singular configurations: one mistake made, another, and both."""

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
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.pieces import Piece, pieces
from qdot.exercises.mistakes.catalogue import mistaken_answers
from qdot.exercises.problem.problem import Part
from qdot.exercises.quizzes.options import MOST_SPREAD, SHOWS_ITSELF, SPREAD, Blame, Offered, rank_of_key

Components = tuple[Component, ...]

PAIRS = 60
MOST_PIECES = 6
"""Pieces of a set that a short question shows."""


def four_sets(chain: Chain, rng: Stream) -> list[Offered] | None:
    """Return the singular set and three wrong ones, or None where the catalogue does not give three."""
    right = singular_set(chain)
    if not right:
        return None
    wanted, others = rng.below(4), list[tuple[Score, list[Offered]]]()
    for options in islice(_fours(chain, right, rng), PAIRS):
        score = _score(options, wanted)
        if score is not None and score[:2] != BEST:
            others.append((score, options))
        elif score is not None and all_differ(chain, options):
            return options
    others.sort(key=itemgetter(0))
    return next((options for _, options in others if all_differ(chain, options)), None)


Score = tuple[bool, int, float]
"""How ill options go together: whether their lengths are far apart, how far the right one is from the rank in length
that is wanted, and the ratio of the longest to the shortest."""
BEST = (False, 0)
"""The first two of a score that nothing need be better than."""


def _score(options: list[Offered], wanted: int) -> Score | None:
    """Return how ill options go together, which is cheap beside whether they differ; None where they don't at all."""
    texts = [option.text for option in options]
    if len(set(texts)) < 4 or any(text.count(" or ") >= MOST_PIECES for text in texts):
        return None
    lengths = [len(text) for text in texts]
    spread = max(lengths) / min(lengths)
    if spread > 2 * MOST_SPREAD:
        return None
    return (spread > 2 * SPREAD, abs(rank_of_key(lengths) - wanted), spread)


def _fours(chain: Chain, right: Components, rng: Stream) -> Iterator[list[Offered]]:
    first = _wrong(chain, right)
    pairs = rng.shuffled(list(combinations(first, 2)))
    for one, other in pairs:
        for both in _wrong(chain, _components(one)):
            if both.behind == other.behind:
                blames = (*one.behind, *other.behind)
                yield [Offered(right), one, other, Offered(both.shown, blames)]
    for three in rng.shuffled(list(islice(combinations(first, 3), PAIRS))):
        yield [Offered(right), *three]


def _components(option: Offered) -> Components:
    assert isinstance(option.shown, tuple)
    return option.shown


@lru_cache(maxsize=4096)
def _wrong(chain: Chain, components: Components) -> tuple[Offered, ...]:
    """Return what each mistake makes of a set."""
    part = Part("singular-angles", "singular-angles", ConditionSet(components))
    wrong_sets = []
    for mistake, slip in mistaken_answers(chain, part):
        if not mistake.rare and mistake.name not in SHOWS_ITSELF and isinstance(slip.answer, ConditionSet):
            wrong_sets.append(Offered(slip.answer.components, (Blame.of(mistake, slip.words.items()),)))
    return tuple(wrong_sets)


def all_differ(chain: Chain, options: list[Offered]) -> bool:
    """Tell whether no two of the sets hold the same configurations, and none is empty."""
    texts = [tuple(piece for component in _components(option) for piece in component.pieces()) for option in options]
    return all(not _same(chain, a, b) for a, b in combinations(texts, 2))


@lru_cache(maxsize=20_000)
def _same(chain: Chain, a: tuple[str, ...], b: tuple[str, ...]) -> bool:
    joints = [q.name for q in chain.q]
    space = Space(joints, domain_of(chain))
    comparison = compare_sets(_read(a, joints), _read(b, joints), space, "quiz")
    return comparison.equal or all(held is None for held in (*comparison.covered, *comparison.sound))


def _read(texts: tuple[str, ...], joints: list[str]) -> list[Piece]:
    return [piece for text in texts for piece in pieces(read(text), joints)]
