"""Decide whether two expressions are the same function, entry by entry, and say where they differ.

Exactly first (`exact`): rational functions of lengths, sines and cosines, with a bound on the chance of a wrong
verdict. What is none (square roots, inverse functions, absolute values, decimals in a sine) is compared in numbers, at
many random points. Double precision only finds differences there that are much larger than rounding can be. That two
values are the same is decided with 50 digits, at one point at least of every region that was met in which the operands
of functions with branches keep their signs: both sides are analytic there, and the same all over it if they are the
same around a point.

Decimals mean what they say: 0.5 is a half, 3.14 is not pi. Only a number of 13 digits or more is taken for the double
that a program prints (SymPy prints 15, without zeros at the end), and allowed what a chain of operations with doubles
loses (FLOATS, of the size of the terms).
An assignment may allow more (`Rounding`).
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

import mpmath
import numpy as np

from qdot.exercises.common.json_form import OPTIONAL
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import exact
from qdot.exercises.formula.noise import remove_noise
from qdot.exercises.formula.program import (
    SAME,
    Program,
    compile_program,
    evaluate_precisely,
    evaluate_steps,
    number_regions,
    select_outputs,
)
from qdot.exercises.formula.trees import Node, digits_of, digits_of_decimals, names

POINTS = 50
POINTS_BRANCHING = 2000
SHARE, SHARE_BRANCHING = 0.5, 0.02
"""The bound of a comparison in numbers is for answers that differ at that share of the configurations or more."""
READABLE = 8
"""That many points come first and have two decimals, so that a counterexample can be followed by hand."""

PRINTED, DOUBLE = 13, 16
"""Digits from which on a decimal that was typed is a double as programs print it, and a problem's number is a root."""
FLOATS = 1e-12
"""What entries may be off with decimals of PRINTED digits or more, and values of joints always."""

_ROUNDING = 64 * np.finfo(float).eps


@dataclass(frozen=True)
class Domain:
    """What each symbol may be: "angle" (whole circle), "length" (positive), "signed", "travel", or a given number,
    or an array with one for each point.

    "travel" is that of a prismatic joint, in metres, as far as any arm reaches, in both directions.

    A number that no fraction is (a root) is given as a double; other doubles are the decimals that they print as.
    """

    roles: Mapping[str, str | float | Fraction | np.ndarray]

    def fixed_values(self) -> dict[str, Fraction | None]:
        """Return the names that stand for numbers, None for those that are known as doubles only."""
        return {name: _as_fraction(role) for name, role in self.roles.items() if not isinstance(role, str | np.ndarray)}

    def sample(self, used: set[str], points: int, stream: Stream) -> dict[str, np.ndarray]:
        """Return values at `points` points for each name in use; an unknown name is a free signed number."""
        values = {}
        for name in sorted(used):
            role = self.roles.get(name, "signed")
            if isinstance(role, str):
                values[name] = _sample_role(role, points, stream)
            else:
                values[name] = role.astype(float) if isinstance(role, np.ndarray) else np.full(points, float(role))
        return values


def _as_fraction(number: float | Fraction) -> Fraction | None:
    if isinstance(number, Fraction):
        return number
    return None if digits_of(Fraction(repr(number))) >= DOUBLE else Fraction(repr(number))


def _sample_role(role: str, points: int, stream: Stream) -> np.ndarray:
    """Return random values for a role, readable ones first; lengths are spread evenly over orders of magnitude."""
    unit = (np.frombuffer(stream.take(8 * points), dtype=">u8") >> np.uint64(11)) / float(1 << 53)
    if role == "angle":
        values = np.pi * (2 * unit - 1)
    elif role == "length":
        values = 0.05 * 800.0**unit
        values[:READABLE] = 0.2 + 1.3 * unit[:READABLE]
    elif role == "travel":
        side = np.where(unit < 0.5, -1.0, 1.0)
        values = side * 0.2 * 50.0 ** (2 * unit % 1)
    else:
        values = np.where(unit < 0.5, -0.2 - 3.6 * unit, 0.2 + 3.6 * (unit - 0.5))
    values[:READABLE] = np.round(values[:READABLE], 2)
    return np.asarray(values)


def default_role(name: str) -> str:
    """Return the default role of a name: theta* is an angle, a*, d* and L* are lengths, all others are signed."""
    if name.startswith("theta"):
        return "angle"
    return "length" if name[0] in "adLl" and name[1:].isdigit() else "signed"


@dataclass(frozen=True)
class Rounding:
    """What decimals may be off, by policy of an assignment: a part of the value's size, or an amount in SI units.

    `words` say it as in "to three significant digits", "within 0.01 rad/s".
    """

    relative: float = 0.0
    absolute: float = 0.0
    words: str = ""


@dataclass(frozen=True)
class EntryDifference:
    """A point where an entry (counted from 0) differs: the symbols' values in rad and m, and both values there.

    A value is a text if it is no finite real number, or if more digits are needed to show the difference. `expected` is
    None if it is withheld. For a vector that counts up to a factor, it is what suits the answer's entry `pivot`.
    """

    entry: int
    at: Mapping[str, float]
    yours: float | str
    expected: float | str | None
    pivot: int | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class SetDifference:
    """Configurations (rad and m) in which two sets differ: singular but not claimed, and claimed but not singular."""

    missing: Mapping[str, float] | None
    surplus: Mapping[str, float] | None


Counterexample = EntryDifference | SetDifference


@dataclass(frozen=True)
class Certificate:
    """How a verdict was reached: method, points tried, the chance at most that a wrong answer gets through.

    After "exact" the bound holds for any wrong answer; after "numeric" for one that is wrong at a share of the
    configurations or more (SHARE, SHARE_BRANCHING). None: none is claimed.
    """

    method: str
    points: int
    bound: float | None = None
    counterexample: Counterexample | None = None


@dataclass(frozen=True)
class Comparison:
    """For each entry, whether it is right; and the certificate, with the first difference."""

    equal: tuple[bool, ...]
    certificate: Certificate


def compare_entries(
    student: Sequence[Node], reference: Sequence[Node], domain: Domain, seed: str, rounding: Rounding | None = None
) -> Comparison:
    """Compare two lists of scalar trees entry by entry at random points; nobody may know their `seed` before.

    Raises ReadError where an entry is no scalar.
    """
    if all(remove_noise(node) is node for node in reference):
        student = [remove_noise(node) for node in student]
    theirs, ours = compile_program(student), compile_program(reference)
    constants = domain.fixed_values()
    decided = exact.compare(theirs, ours, constants, seed)
    doubles = {name for name, value in constants.items() if value is None}
    allowed = [_allowance(node, rounding, doubles) for node in student]
    certain = [
        entry.equal is True or (entry.equal is False and not any(room))
        for entry, room in zip(decided, allowed, strict=True)
    ]
    equal = [entry.equal is True for entry in decided]
    points = max(entry.points for entry in decided)
    if all(equal):
        return Comparison(tuple(equal), Certificate("exact", points, max(entry.bound for entry in decided)))
    count = _count(theirs, certain)
    values = domain.sample(set().union(*(names(node) for node in (*student, *reference))), count, Stream(seed))
    trial = _Trial(theirs, ours, allowed, values, constants, count)
    for k, sure in enumerate(certain):
        if not sure:
            equal[k] = trial.equal(k)
    wrong = [k for k, same in enumerate(equal) if not same]
    example = trial.counterexample(wrong[0]) if wrong else None
    if all(certain):
        bound = max((entry.bound for entry in decided if entry.equal), default=0.0)
        return Comparison(tuple(equal), Certificate("exact", points, bound, example))
    bound = chance_of_missing(trial.defined, SHARE_BRANCHING if theirs.branches else SHARE)
    return Comparison(tuple(equal), Certificate("numeric", trial.points, bound, example))


def chance_of_missing(points: int, share: float = SHARE) -> float:
    """Return the chance that an answer which is wrong at that share of all points is right at all of these points."""
    return float((1.0 - share) ** points)


def _count(theirs: Program, certain: Sequence[bool]) -> int:
    """Return the number of points: a few for a counterexample alone, many if branches may differ somewhere."""
    if all(certain):
        return READABLE
    return max(POINTS, min(POINTS_BRANCHING, _VALUES // len(theirs.steps))) if theirs.branches else POINTS


def allowed_for_decimals(node: Node) -> float:
    """Return the relative error that a value may have because its decimals are doubles; 0 if they are not."""
    return FLOATS if digits_of_decimals(node) >= PRINTED else 0.0


def _allowance(node: Node, rounding: Rounding | None, doubles: AbstractSet[str]) -> tuple[float, float]:
    """Return how far off an entry may be: a part of the size of the reference's terms, and an amount."""
    floats = FLOATS if doubles and names(node) & doubles else allowed_for_decimals(node)
    return (floats, 0.0) if rounding is None else (max(floats, rounding.relative), rounding.absolute)


_VALUES = 10_000_000
"""Numbers that one comparison may compute in double precision: a program longer than 5,000 steps has fewer points."""

_PRECISE_STEPS = 100_000
"""Steps of evaluation with many digits that one comparison may take (some seconds); a grader must not be stalled."""

_CLEAR = 1e-9
"""A difference that double precision may find: much more than rounding, of the size of the terms."""

_REGIONS, _SUSPECTS = 16, 3
"""Points at which an entry is looked at with 50 digits: one a region, and those that differ most for their rounding."""


class _Trial:
    """Two programs at the same points: in double precision at all of them, with many digits where that decides."""

    def __init__(
        self,
        theirs: Program,
        ours: Program,
        allowed: Sequence[tuple[float, float]],
        values: Mapping[str, np.ndarray],
        constants: Mapping[str, Fraction | None],
        points: int,
    ) -> None:
        self.theirs, self.ours, self.values, self.given, self.points = theirs, ours, values, constants, points
        self.steps = [(program, evaluate_steps(program, values, points)) for program in (theirs, ours)]
        (self.yours, size), (self.expected, expected_size) = (select_outputs(*evaluated) for evaluated in self.steps)
        self.scale = _scales(expected_size)
        with np.errstate(all="ignore"):
            parts, amounts = np.array(allowed).T
            self.room = parts[:, None] * self.scale + amounts[:, None]
            self.size = size + expected_size
            self.noise = 10 * _ROUNDING * self.size
            self.off = np.abs(self.yours - self.expected)
        self.left = _PRECISE_STEPS // (2 * (len(theirs.steps) + len(ours.steps)))
        self.examples: dict[int, tuple[int, Any, Any]] = {}
        self.precise: dict[tuple[int, int], tuple[list[Any], list[Any]]] = {}

    @cached_property
    def regions(self) -> np.ndarray:
        """The region of each point."""
        return number_regions(self.steps, self.points)

    @property
    def defined(self) -> int:
        """The smallest number of points at which an entry of the reference is defined."""
        return int(np.isfinite(self.expected).sum(axis=1).min())

    def equal(self, entry: int) -> bool:
        """Return whether an entry is right, and store the point at which it differs."""
        if self._is_clear(entry).any():
            return False
        looked = [self._is_same(entry, int(point)) for point in self._to_look_at(entry)]
        return False not in looked and (True in looked or bool(self._is_settled(entry).any()))

    def _is_clear(self, entry: int) -> np.ndarray:
        """Return the points at which the difference is much larger than rounding can make it."""
        with np.errstate(all="ignore"):
            least = self.room[entry] + self.noise[entry] + _CLEAR * self.scale[entry]
            return np.asarray((self.off[entry] > least) & np.isfinite(self.off[entry]))

    def _is_settled(self, entry: int) -> np.ndarray:
        """Return the points at which double precision shows that the error is within the allowance."""
        with np.errstate(all="ignore"):
            return np.asarray(self.off[entry] + self.noise[entry] <= self.room[entry])

    def _to_look_at(self, entry: int) -> list[int]:
        """Return the points that need many digits: of all regions that are not settled one, and the worst."""
        open_ = np.flatnonzero(~self._is_settled(entry))
        defined = np.isfinite(self.yours[entry]) & np.isfinite(self.expected[entry])
        # Values of two decimals may coincide (a1 = a2) and meet a removable singularity; the other points can't.
        open_ = open_[defined[open_] | (open_ >= READABLE)]
        if not len(open_):
            return []
        with np.errstate(all="ignore"):
            suspect = np.nan_to_num((self.off[entry] - self.room[entry]) / self.noise[entry], nan=np.inf)
        first = [int(open_[i]) for i in np.sort(np.unique(self.regions[open_], return_index=True)[1])]
        worst = [int(open_[i]) for i in np.argpartition(-suspect[open_], min(_SUSPECTS, len(open_) - 1))[:_SUSPECTS]]
        return list(dict.fromkeys(first[:_REGIONS] + worst))

    def _is_same(self, entry: int, point: int) -> bool | None:
        """Return whether an entry is the same with many digits; None if the reference is undefined or time is up."""
        yours: Any = None
        expected: Any = None
        for digits in (50, 200):
            if (results := self._precisely(point, digits)) is None:
                return None
            yours, expected = results[0][entry], results[1][entry]
            if not mpmath.isfinite(expected):
                return None
            if not mpmath.isfinite(yours):
                continue  # with more digits it may be defined: a denominator that all but vanishes
            with mpmath.workdps(digits):
                off, size = abs(yours - expected), self.size[entry, point]
                scale = size if np.isfinite(size) else 1e10 * (abs(yours) + abs(expected))
                lost = mpmath.mpf(10) ** (5 - digits) * scale
                room = max(self.room[entry, point], SAME * self.scale[entry, point])
            if off + lost <= room:
                return True
            if off - lost > room:
                break
        self.examples.setdefault(entry, (point, yours, expected))
        return False

    def _precisely(self, point: int, digits: int) -> tuple[list[Any], list[Any]] | None:
        """Return all results of both programs at a point, or None if that would take too long."""
        if (point, digits) not in self.precise:
            if self.left <= 0:
                return None
            self.left -= 1
            at = {name: self.given.get(name) or float(column[point]) for name, column in self.values.items()}
            self.precise[point, digits] = (
                evaluate_precisely(self.theirs, at, digits), evaluate_precisely(self.ours, at, digits),
            )  # fmt: skip
        return self.precise[point, digits]

    def counterexample(self, entry: int) -> EntryDifference:
        """Return a point where an entry differs, both values there, and the entry's number; readable ones first."""
        defined = np.isfinite(self.expected[entry])
        clear = np.flatnonzero((self._is_clear(entry) | ~np.isfinite(self.yours[entry])) & defined)
        if len(clear):
            point = int(clear[0])
            yours, expected = self.yours[entry, point], self.expected[entry, point]
        else:
            point, yours, expected = self.examples.get(entry) or self._tiny_difference(entry)
        at = {name: _round(column[point]) for name, column in sorted(self.values.items())}
        return EntryDifference(entry, at, *tell_apart(yours, expected))

    def _tiny_difference(self, entry: int) -> tuple[int, Any, Any]:
        """Return a point at which 50 digits show a difference that double precision does not, or else any point."""
        example = (0, self.yours[entry, 0], self.expected[entry, 0])
        for point in range(READABLE):
            if (results := self._precisely(point, 50)) is not None:
                example = (point, results[0][entry], results[1][entry])
                if example[1] != example[2]:
                    break
        return example


def _scales(magnitude: np.ndarray) -> np.ndarray:
    """Return the size to which a difference is compared: that of the entry's terms, or of the largest entry's for 0."""
    largest = magnitude.max(axis=0, keepdims=True)
    largest = np.where((largest > 0) & np.isfinite(largest), largest, 1.0)
    return np.where((magnitude > 0) & np.isfinite(magnitude), magnitude, largest)


def _round(value: float) -> float:
    return float(f"{value:.6g}")


def tell_apart(yours: Any, expected: Any) -> tuple[float | str, float | str]:
    """Return two values with enough digits to show that they differ."""
    shown = number(complex(yours)), number(complex(expected))
    if shown[0] != shown[1]:
        return shown
    both = [mpmath.mpmathify(value) for value in (yours, expected)]
    if not any(isinstance(value, str) for value in shown):  # real, but for what is left of complex arithmetic
        both = [value.real for value in both]
    for digits in range(8, 50, 2):
        texts = mpmath.nstr(both[0], digits), mpmath.nstr(both[1], digits)
        if texts[0] != texts[1]:
            return texts
    return shown


def number(value: complex) -> float | str:
    """Return a value for JSON: a float with six digits, or words if it is complex or not a number."""
    if not np.isfinite(value):
        return "not a finite number"
    if abs(value.imag) > 1e-9 * abs(value):
        return f"{value.real:.6g} + {value.imag:.6g}i"
    return _round(value.real)
