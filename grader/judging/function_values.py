"""Answers that are Python functions: at which points they are called, and the values that they return there.

Where a function takes symbols, it left the sandbox as a formula and does not come here (see `callables`).
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.identity import Domain
from qdot.exercises.problem.problem import Problem
from qdot.grader.sandbox.contained.callables import TABLE
from qdot.grader.sandbox.sandbox import Calls

POINTS = 50
SHOWN = f"a Python function; its values at {POINTS} random configurations were compared"


def calls_of(problem: Problem, domain: Domain, seed: str) -> Calls:
    """Return the joints, and the names and values of all symbols at the points at which a function is called."""
    values = _points(domain, seed)
    symbols = tuple(sorted(values))
    points = np.array([values[symbol] for symbol in symbols]).T.tolist()
    return Calls(tuple(q.name for q in problem.chain.q), symbols, tuple(map(tuple, points)))


def _points(domain: Domain, seed: str) -> dict[str, np.ndarray]:
    return domain.sample(set(domain.roles), POINTS, Stream(hashlib.sha256(seed.encode()).hexdigest()))


@dataclass(frozen=True)
class Table:
    """The values of a function: its shape (None where the text was no table), values (points, entries), and where."""

    shape: tuple[int, ...] | None
    values: np.ndarray
    at: Mapping[str, np.ndarray]


def is_table(answer: str) -> bool:
    """Tell whether an answer is the values of a function."""
    return answer.startswith(TABLE)


def read_table(text: str, domain: Domain, seed: str) -> Table:
    """Read the values of a function at the points of `seed`."""
    return Table(*table_values(text), _points(domain, seed))


def constant_text(text: str) -> str | None:
    """Return the values as the text of a matrix where they are the same at all points; None where they vary."""
    shape, values = table_values(text)
    if shape is None or not np.all(values == values[0]) or np.any(values.imag != 0):
        return None
    entries = np.array([repr(float(value)) for value in values[0].real], dtype=object).reshape(shape)
    return str(entries.tolist()).replace("'", "")


def table_values(answer: str) -> tuple[tuple[int, ...] | None, np.ndarray]:
    """Return shape and values (points, entries) of a table, or None and nothing where the text is no table."""
    try:
        content = json.loads(answer.removeprefix(TABLE))
        shape = tuple(int(size) for size in content["shape"])
        pairs = np.array(content["values"], dtype=float)
        if pairs.ndim == 3 and pairs.shape[2] == 2 and pairs.shape[1] == int(np.prod(shape)) and len(shape) <= 2:
            return shape, pairs[..., 0] + 1j * pairs[..., 1]
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        pass
    return None, np.zeros((0, 0))
