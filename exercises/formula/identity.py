"""Decide whether two expressions are the same function, at random configurations, and say where they differ.

TOLERANCE, stated once: two values count as equal when they differ by less than 1e-9 of the size of the terms that
make up the reference's value there. Doubles carry 1e-16, and a student's chain of decimal steps loses three or four
digits of that, so right answers written with full decimals pass; the least mistake worth the name (3.14 for pi,
0.866 for sqrt(3)/2) is a hundred thousand times larger. Where rounding could be mistaken for a difference, or hide
one, the point is evaluated again with 50 and then 200 digits.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from exercises.formula.expression import Node, names
from exercises.formula.tape import Tape, compile_tape, evaluate, evaluate_precisely
from exercises.stream import Stream

TOLERANCE = 1e-9
POINTS = 24
POINTS_BRANCHING = 2000
READABLE = 8
"""That many points come first and have two decimals, so that a counterexample can be followed by hand."""

_ROUNDING = 64 * np.finfo(float).eps


@dataclass(frozen=True)
class Domain:
    """What each symbol may be: "angle" (whole circle), "length" (positive), "signed", or a given number."""

    roles: Mapping[str, str | float]

    def sample(self, used: set[str], points: int, stream: Stream) -> dict[str, np.ndarray]:
        """Return values at `points` points for each name in use; an unknown name is a free signed number."""
        out = {}
        for name in sorted(used):
            role = self.roles.get(name, "signed")
            if isinstance(role, (int, float)):
                out[name] = np.full(points, float(role))
            else:
                out[name] = np.array([_draw(role, stream, readable=i < READABLE) for i in range(points)])
        return out


def _draw(role: str, stream: Stream, readable: bool) -> float:
    if role == "angle":
        value = stream.uniform(-np.pi, np.pi)
    elif role == "length":
        value = stream.uniform(0.2, 1.5) if readable else float(np.exp(stream.uniform(np.log(0.05), np.log(40.0))))
    else:
        value = stream.uniform(0.2, 2.0) * stream.choice((-1, 1))
    return round(value, 2) if readable else value


def default_role(name: str) -> str:
    """Return the role that a name has when nothing else is said: theta* angle; a*, d*, L* length; others signed."""
    if name.startswith("theta"):
        return "angle"
    return "length" if name[0] in "adLl" and name[1:].isdigit() else "signed"


@dataclass(frozen=True)
class Certificate:
    """How a verdict was reached: method, points tried, bound on a wrong acceptance (None: no bound is claimed)."""

    method: str
    points: int
    bound: float | None = None
    counterexample: Mapping[str, Any] | None = None

    def as_json(self) -> dict[str, Any]:
        """Return the form in which results files hold it."""
        found = dict(self.counterexample) if self.counterexample is not None else None
        return {"method": self.method, "points": self.points, "bound": self.bound, "counterexample": found}


@dataclass(frozen=True)
class Comparison:
    """For each entry, whether it is right; and the certificate, with the first difference."""

    equal: tuple[bool, ...]
    certificate: Certificate


def compare_entries(student: Sequence[Node], reference: Sequence[Node], domain: Domain, seed: str) -> Comparison:
    """Compare two lists of scalar trees entry by entry at points drawn from `seed`.

    Raises ReadError where an entry is no scalar.
    """
    ours, theirs = compile_tape(reference), compile_tape(student)
    points = max(POINTS, min(POINTS_BRANCHING, _VALUES // len(theirs.steps))) if theirs.branches else POINTS
    used = set().union(*(names(node) for node in (*student, *reference)))
    values = domain.sample(used, points, Stream(seed))
    expected, scale = evaluate(ours, values, points)
    found, found_magnitude = evaluate(theirs, values, points)
    verdicts = _verdicts(found, found_magnitude, expected, scale)
    _escalate(verdicts, theirs, ours, values, scale)
    equal = tuple(bool(row) for row in (verdicts == _SAME).all(axis=1))
    example = _counterexample(verdicts, values, used, found, expected)
    return Comparison(equal, Certificate("numeric", points, None, example))


_SAME, _DIFFERENT, _GREY = 1, 0, 2

_VALUES = 10_000_000
"""Numbers that one comparison may compute in double precision: a tape longer than 5,000 steps has fewer points."""

_PRECISE_STEPS = 100_000
"""Steps of evaluation with many digits that one comparison may take (some seconds); a grader must not be stalled."""

_DECIDED = 12
"""An entry with grey points left over is right if that many others were decided, and none of them was different."""


def _scales(magnitude: np.ndarray) -> np.ndarray:
    """Return the size against which a difference is judged: the entry's terms; for a zero, the largest entry's."""
    largest = magnitude.max(axis=0, keepdims=True)
    largest = np.where(largest > 0, largest, 1.0)
    return np.where(magnitude > 0, magnitude, largest)


def _verdicts(found: np.ndarray, size: np.ndarray, expected: np.ndarray, expected_size: np.ndarray) -> np.ndarray:
    allowed = TOLERANCE * _scales(expected_size)
    with np.errstate(all="ignore"):
        noise = _ROUNDING * (size + expected_size)
        difference = np.abs(found - expected)
        verdicts = np.where(difference > allowed, _DIFFERENT, _SAME)
        grey = ~(noise < 0.1 * allowed) & (difference <= 10 * noise)
    verdicts[grey] = _GREY
    undefined = ~np.isfinite(found) | ~np.isfinite(expected)
    verdicts[undefined] = _GREY
    # Values of two decimals may coincide (a1 = a2) and meet a removable singularity; the other points can't.
    verdicts[:, :READABLE][undefined[:, :READABLE]] = _SAME
    return verdicts


def _escalate(
    verdicts: np.ndarray, student: Tape, reference: Tape, values: Mapping[str, np.ndarray], magnitude: np.ndarray
) -> None:
    """Decide the grey points with more digits, as many as _PRECISE_STEPS allow; what stays undefined is different.

    Only points at which the reference is defined count (the others are a null set that a draw may still hit).
    """
    allowed = TOLERANCE * _scales(magnitude)
    affordable = _PRECISE_STEPS // (2 * (len(student.steps) + len(reference.steps)))
    for point in np.unique(np.nonzero(verdicts == _GREY)[1])[:affordable]:
        at = {name: float(column[point]) for name, column in values.items()}
        rows = np.nonzero((verdicts[:, point] == _GREY) & ~(verdicts == _DIFFERENT).any(axis=1))[0]
        if not len(rows):
            continue
        low, high = (
            (evaluate_precisely(student, at, digits), evaluate_precisely(reference, at, digits)) for digits in (50, 200)
        )
        for row in rows:
            verdicts[row, point] = _precise_verdict(low, high, int(row), float(allowed[row, point]))
    enough = (verdicts == _SAME).sum(axis=1, keepdims=True) >= _DECIDED
    verdicts[:] = np.where(verdicts == _GREY, np.where(enough, _SAME, _DIFFERENT), verdicts)


def _precise_verdict(low: Any, high: Any, row: int, allowed: float) -> int:
    if not all(mpmath.isfinite(value) for value in (low[0][row], high[0][row])):
        return _SAME if not mpmath.isfinite(high[1][row]) else _DIFFERENT
    # Two precisions that agree show that the digits are there; a result that moves with the precision is noise.
    if abs(low[0][row] - high[0][row]) > allowed / 10:
        return _DIFFERENT
    return _SAME if abs(high[0][row] - high[1][row]) <= allowed else _DIFFERENT


def _counterexample(
    verdicts: np.ndarray, values: Mapping[str, np.ndarray], used: set[str], found: np.ndarray, expected: np.ndarray
) -> dict[str, Any] | None:
    wrong = np.argwhere(verdicts == _DIFFERENT)
    if not len(wrong):
        return None
    entry, point = min((tuple(pair) for pair in wrong.tolist()), key=lambda pair: (pair[1] >= READABLE, pair))
    at = {name: _short(values[name][point]) for name in sorted(used)}
    return {"entry": entry, "at": at, "yours": number(found[entry, point]), "expected": number(expected[entry, point])}


def _short(value: float) -> float:
    return float(f"{value:.6g}")


def number(value: complex) -> float | str:
    """Return a value fit for JSON: a float of six digits, or words where it is complex or not a number."""
    if not np.isfinite(value):
        return "not a finite number"
    if abs(value.imag) > 1e-9 * abs(value):
        return f"{value.real:.6g} + {value.imag:.6g}i"
    return _short(value.real)
