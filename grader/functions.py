"""Judge an answer that is a Python function by its values at points which no one knows before (see `callables`).

Where a function takes symbols, it left the sandbox as a formula and does not come here. What comes here are doubles
from code that is not ours, so that nothing is left to look at with more digits: they must be right to nine digits of
the size of the terms, or as the assignment allows.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from exercises.formula.expression import read
from exercises.formula.identity import Certificate, Comparison, Domain, Rounding, missed, number
from exercises.formula.program import compile_program, evaluate
from exercises.formula.text import rows_of_text
from exercises.formula.trees import names
from exercises.problem import Part, Problem
from exercises.stream import Stream
from grader.contained.callables import TABLE
from grader.formulas import matrix_judgement
from grader.verdict import Judgement, wrong

POINTS = 50
NINE_DIGITS = 1e-9
SHOWN = f"a Python function; its values at {POINTS} random configurations were compared"


def asked_of(problem: Problem, domain: Domain, seed: str) -> dict[str, Any]:
    """Return the joints, and the names and values of all symbols at the points at which a function is called."""
    values = domain.sample(set(domain.roles), POINTS, Stream(hashlib.sha256(seed.encode()).hexdigest()))
    symbols = sorted(values)
    return {
        "joints": [q.name for q in problem.chain.q],
        "symbols": symbols,
        "points": np.array([values[symbol] for symbol in symbols]).T.tolist(),
    }


def is_table(answer: str) -> bool:
    """Tell whether an answer is the values of a function."""
    return answer.startswith(TABLE)


def constant_text(answer: str) -> str | None:
    """Return the values as the text of a matrix where they are the same at all points; None where they vary."""
    shape, values = table_values(answer)
    if shape is None or not np.all(values == values[0]) or np.any(values.imag != 0):
        return None
    entries = np.array([repr(float(value)) for value in values[0].real], dtype=object).reshape(shape)
    return str(entries.tolist()).replace("'", "")


def judge_function(
    part: Part, answer: str, asked: Mapping[str, Any], domain: Domain, rounding: Rounding | None
) -> Judgement:
    """Judge the values of a function at the points asked for. A table that is none is the student's own making."""
    if not part.answer.entries():
        return wrong("a function of the configuration stands where no formula is due")
    rows = rows_of_text(part.answer.as_matrix())
    due_shape = (len(rows), len(rows[0]))
    shape, values = table_values(answer)
    if shape is None or len(values) != POINTS:
        return wrong("these are no values of a function")
    if values.shape[1] != due_shape[0] * due_shape[1] or (len(shape) == 2 and 1 not in shape and shape != due_shape):
        returned = " x ".join(map(str, shape)) or "one number"
        return wrong(f"the function returns {returned}, and {due_shape[0]} x {due_shape[1]} is due")
    at = dict(zip(asked["symbols"], np.array(asked["points"]).T, strict=True))
    nodes = [read(entry, domain.roles) for row in rows for entry in row]
    due, size = evaluate(compile_program(nodes), at, POINTS)
    found = _along(values.T, due) if part.answer.counts_up_to_a_factor else values.T
    shown = set(asked["joints"]).union(*map(names, nodes))
    compared = _compared(found, due, size, {name: column for name, column in at.items() if name in shown}, rounding)
    return matrix_judgement(compared, [False] * len(nodes), rows)


def _along(found: np.ndarray, due: np.ndarray) -> np.ndarray:
    """Return vectors scaled and turned to be compared with those that are due, if they lie along them."""
    with np.errstate(all="ignore"):
        factor = np.sum(due * found.conj(), axis=0) / np.sum(np.abs(found) ** 2, axis=0)
        return np.asarray(found * factor)


def _compared(
    found: np.ndarray, due: np.ndarray, size: np.ndarray, at: Mapping[str, np.ndarray], rounding: Rounding | None
) -> Comparison:
    relative, absolute = (rounding.relative, rounding.absolute) if rounding is not None else (0.0, 0.0)
    with np.errstate(all="ignore"):
        largest = np.nanmax(np.where(np.isfinite(size), size, 0.0), axis=0)
        scale = np.where(size > 0, size, np.where(largest > 0, largest, 1.0))
        right = np.abs(found - due) <= max(NINE_DIGITS, relative) * scale + absolute
    defined = np.isfinite(due)
    equal = [bool(np.all(same[there]) and np.any(there)) for same, there in zip(right, defined, strict=True)]
    example = None
    if not all(equal):
        entry = equal.index(False)
        point = int(np.argmax(~right[entry] & defined[entry]))
        example = {
            "entry": entry,
            "at": {name: float(f"{column[point]:.6g}") for name, column in sorted(at.items())},
            "yours": number(complex(found[entry, point])),
            "expected": number(complex(due[entry, point])),
        }
    return Comparison(tuple(equal), Certificate("numeric", POINTS, missed(POINTS), example))


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
