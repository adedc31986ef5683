"""Singular sets as pieces, and singular configurations that a search in numbers finds."""

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
from qdot.exercises.singularities.classification import domain_of
from qdot.exercises.singularities.singular_set import singular_set
from qdot.exercises.verify.singular import find_singular_configurations


def rows_of(chain: Chain) -> list[int]:
    return [VELOCITY_NAMES.index(row) for row in chain.task]


def lengths_of(chain: Chain, stream: Stream) -> dict[str, float]:
    return {symbol.name: stream.uniform(0.3, 1.0) for symbol in chain.parameters}


def rank_ratios(arm: NumericChain, chain: Chain, q: np.ndarray) -> np.ndarray:
    """Return the smallest singular value of the task's J by the largest one, at configurations (..., n)."""
    sigma = np.linalg.svd(arm.jacobian(q)[..., rows_of(chain), :], compute_uv=False)
    return np.asarray(sigma[..., -1] / np.maximum(sigma[..., 0], 1e-6))


def read_pieces(chain: Chain, texts: Iterable[str]) -> list[Piece]:
    joints = [q.name for q in chain.q]
    return [piece for text in texts for piece in parse_pieces(parse_formula(text), joints)]


def claimed(chain: Chain) -> list[Piece]:
    """Return the pieces of the singular set of a chain."""
    return read_pieces(chain, (text for component in singular_set(chain) or () for text in component.pieces()))


def compared(chain: Chain, ours: list[Piece], book: Iterable[str]) -> SetComparison:
    """Return whether pieces are what a book prints, for any lengths."""
    return compare_sets(
        ours, read_pieces(chain, book), ConfigurationSpace([q.name for q in chain.q], domain_of(chain)), chain.name
    )


def assert_is_book(chain: Chain, ours: list[Piece], book: Iterable[str]) -> None:
    """Assert that each condition of a book is covered, and nothing else is claimed."""
    found = compared(chain, ours, book)
    assert found.are_equal and all(found.is_covered) and all(found.is_sound), (chain.name, found.missing, found.surplus)


@dataclass(frozen=True)
class Search:
    """An arm with lengths, configurations from which singular ones were looked for, and those that were reached."""

    chain: Chain
    lengths: dict[str, float]
    starts: np.ndarray
    reached: np.ndarray

    @property
    def arm(self) -> NumericChain:
        return NumericChain(self.chain, self.lengths)

    def are_in(self, claims: list[Piece], tolerance: float = SEARCH_TOLERANCE) -> np.ndarray:
        """Return of each configuration that was reached whether it is in a set."""
        joints, count = [q.name for q in self.chain.q], len(self.reached)
        values = dict(zip(joints, self.reached.T, strict=True)) | {
            k: np.full(count, v) for k, v in self.lengths.items()
        }
        return ConfigurationSpace(joints, domain_of(self.chain, self.lengths)).contains(
            claims, values, count, tolerance
        )


def search(chain: Chain, seed: str, count: int = 12) -> Search:
    """Look for singular configurations of an arm from some starts."""
    stream = Stream(seed)
    lengths = lengths_of(chain, stream)
    starts = np.array([[stream.uniform(-3, 3) for _ in chain.q] for _ in range(count)])
    return Search(
        chain, lengths, starts, find_singular_configurations(NumericChain(chain, lengths), starts, rows_of(chain))
    )
