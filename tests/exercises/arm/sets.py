"""Singular sets as pieces, and singular configurations found by a numeric search."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import SEARCH_TOLERANCE, ConfigurationSpace, SetComparison, compare_sets
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import Piece, parse_pieces
from qdot.exercises.singularities.classification import make_domain
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.exercises.verify.singular import find_singular_configurations


def list_task_rows(chain: Chain) -> list[int]:
    return [VELOCITY_NAMES.index(row) for row in chain.task]


def sample_lengths(chain: Chain, stream: Stream) -> dict[str, float]:
    return {symbol.name: stream.uniform(0.3, 1.0) for symbol in chain.parameters}


def compute_rank_ratios(arm: NumericChain, chain: Chain, q: np.ndarray) -> np.ndarray:
    """Return the smallest singular value of the task Jacobian divided by the largest, at configurations (..., n)."""
    sigma = np.linalg.svd(arm.compute_jacobian(q)[..., list_task_rows(chain), :], compute_uv=False)
    return np.asarray(sigma[..., -1] / np.maximum(sigma[..., 0], 1e-6))


def read_pieces(chain: Chain, texts: Iterable[str]) -> list[Piece]:
    joints = [q.name for q in chain.q]
    return [piece for text in texts for piece in parse_pieces(parse_formula(text), joints)]


def read_singular_set(chain: Chain) -> list[Piece]:
    components = find_singular_set(chain) or ()
    return read_pieces(chain, (text for component in components for text in component.list_pieces()))


def compare_with_book(chain: Chain, ours: list[Piece], book: Iterable[str]) -> SetComparison:
    """Compare pieces with the conditions that a book prints, for any lengths."""
    space = ConfigurationSpace([q.name for q in chain.q], make_domain(chain))
    return compare_sets(ours, read_pieces(chain, book), space, chain.name)


def assert_same_set(chain: Chain, ours: list[Piece], book: Iterable[str]) -> None:
    """Assert that the pieces cover each condition of a book, and nothing else."""
    comparison = compare_with_book(chain, ours, book)
    is_same = comparison.are_equal and all(comparison.is_covered) and all(comparison.is_sound)
    assert is_same, (chain.name, comparison.missing, comparison.surplus)


@dataclass(frozen=True)
class Search:
    """An arm with lengths, the starting configurations of a search, and the singular configurations that it reached."""

    chain: Chain
    lengths: dict[str, float]
    starts: np.ndarray
    reached: np.ndarray

    @property
    def arm(self) -> NumericChain:
        return NumericChain(self.chain, self.lengths)

    def are_in(self, claims: list[Piece], tolerance: float = SEARCH_TOLERANCE) -> np.ndarray:
        """Return for each reached configuration whether it is in a set."""
        joints, count = [q.name for q in self.chain.q], len(self.reached)
        values = dict(zip(joints, self.reached.T, strict=True))
        values |= {name: np.full(count, length) for name, length in self.lengths.items()}
        space = ConfigurationSpace(joints, make_domain(self.chain, self.lengths))
        return space.contains(claims, values, count, tolerance)


def search_singularities(chain: Chain, seed: str, count: int = 12) -> Search:
    stream = Stream(seed)
    lengths = sample_lengths(chain, stream)
    starts = np.array([[stream.uniform(-3, 3) for _ in chain.q] for _ in range(count)])
    reached = find_singular_configurations(NumericChain(chain, lengths), starts, list_task_rows(chain))
    return Search(chain, lengths, starts, reached)
