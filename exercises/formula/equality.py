"""Decide whether two expressions are the same function, entry by entry, and find where they differ.

Rational functions of lengths, sines and cosines are compared exactly (`exact`), with a bound on the chance of a wrong
verdict. Other expressions (square roots, inverse functions, absolute values, decimals in a sine) are compared
numerically, at many random points.

  - Double precision is used only to find differences much larger than any rounding error.
  - Whether two values are equal is decided with 50 digits, at one or more points of every region that was sampled. In a
    region the operands of functions with branches keep their signs. Both expressions are analytic there, so that they
    agree on the whole region if they agree around a point.

Decimals are exact: 0.5 is a half, 3.14 is not pi. Only a number of 13 digits or more is taken for a double printed by a
program (SymPy prints 15 digits, without trailing zeros). It may have the rounding error of a chain of operations with
doubles (DOUBLE_TOLERANCE, relative to the size of the terms). An assignment may allow more (`Rounding`).
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

import mpmath
import numpy as np

from qdot.exercises.common.json_form import OMITTED_IF_NONE
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import exact, program
from qdot.exercises.formula.noise import remove_noise
from qdot.exercises.formula.program import PRECISE_TOLERANCE, Program, compile_program, evaluate_precisely
from qdot.exercises.formula.trees import Node, Nodes, count_decimal_digits, count_digits, find_names

POINT_COUNT = 50
POINT_COUNT_BRANCHING = 2000
WRONG_SHARE, WRONG_SHARE_BRANCHING = 0.5, 0.02
"""The bound of a numeric comparison holds for answers that are wrong at this share of the configurations or more."""
READABLE_POINTS = 8
"""The number of points that come first, with two decimals, so that a counterexample can be checked by hand."""

PRINTED_DOUBLE_DIGITS, ROOT_DIGITS = 13, 16
"""Minimum number of digits at which a typed decimal counts as a printed double, and a problem's number as a root."""
DOUBLE_TOLERANCE = 1e-12
"""Relative error allowed for joint values, and for entries with decimals of PRINTED_DOUBLE_DIGITS or more."""

_RELATIVE_ROUNDING = 64 * np.finfo(float).eps


@dataclass(frozen=True)
class Domain:
    """The role of each symbol: a kind of random value, a given number, or an array with one number for each point.

    The kinds are "angle" (whole circle), "length" (positive), "signed" and "travel". "travel" is that of a prismatic
    joint, in metres, as far as any arm reaches, in both directions.

    An irrational number (a root) is given as a double; other doubles stand for the decimals that they print as.
    """

    roles: Mapping[str, str | float | Fraction | np.ndarray]

    def fixed_values(self) -> dict[str, Fraction | None]:
        """Return the value of each name that stands for a number, None if it is only known as a double."""
        return {name: _as_fraction(role) for name, role in self.roles.items() if not isinstance(role, str | np.ndarray)}

    def sample(self, used_names: set[str], point_count: int, stream: Stream) -> dict[str, np.ndarray]:
        """Return random values at `point_count` points for each used name; an unknown name has the role "signed"."""
        values = {}
        for name in sorted(used_names):
            role = self.roles.get(name, "signed")
            if isinstance(role, str):
                values[name] = _sample_role(role, point_count, stream)
            else:
                values[name] = role.astype(float) if isinstance(role, np.ndarray) else np.full(point_count, float(role))
        return values


def _as_fraction(number: float | Fraction) -> Fraction | None:
    if isinstance(number, Fraction):
        return number
    return None if count_digits(Fraction(repr(number))) >= ROOT_DIGITS else Fraction(repr(number))


def _sample_role(role: str, point_count: int, stream: Stream) -> np.ndarray:
    """Return random values for a role, readable ones first; the logarithms of lengths are uniformly distributed."""
    fractions = (np.frombuffer(stream.take_bytes(8 * point_count), dtype=">u8") >> np.uint64(11)) / float(1 << 53)
    if role == "angle":
        values = np.pi * (2 * fractions - 1)
    elif role == "length":
        values = 0.05 * 800.0**fractions
        values[:READABLE_POINTS] = 0.2 + 1.3 * fractions[:READABLE_POINTS]
    elif role == "travel":
        directions = np.where(fractions < 0.5, -1.0, 1.0)
        values = directions * 0.2 * 50.0 ** (2 * fractions % 1)
    else:
        values = np.where(fractions < 0.5, -0.2 - 3.6 * fractions, 0.2 + 3.6 * (fractions - 0.5))
    values[:READABLE_POINTS] = np.round(values[:READABLE_POINTS], 2)
    return np.asarray(values)


def choose_default_role(name: str) -> str:
    """Return the default role of a name: theta* is an angle, a*, d* and L* are lengths, all others are signed."""
    if name.startswith("theta"):
        return "angle"
    return "length" if name[0] in "adLl" and name[1:].isdigit() else "signed"


@dataclass(frozen=True)
class Rounding:
    """The error that an assignment allows for decimals: relative to the value's size, or absolute in SI units.

    `words` describe it, as in "to three significant digits", "within 0.01 rad/s".
    """

    relative: float = 0.0
    absolute: float = 0.0
    words: str = ""


@dataclass(frozen=True)
class EntryDifference:
    """A point where an entry (counted from 0) differs: the symbols' values in rad and m, and both values there.

    A value is a text if it is not a finite real number, or if more digits are needed to show the difference.
    `reference_values` is None if it is withheld. If only the direction of a vector counts, `reference_values` is scaled
    to match the answer's entry `pivot`.
    """

    entry: int
    at: Mapping[str, float]
    yours: float | str
    expected: float | str | None
    pivot: int | None = field(default=None, metadata=OMITTED_IF_NONE)


@dataclass(frozen=True)
class SetDifference:
    """Configurations (rad and m) where two sets differ: one singular but not claimed, one claimed but not singular."""

    missing: Mapping[str, float] | None
    surplus: Mapping[str, float] | None


Counterexample = EntryDifference | SetDifference


@dataclass(frozen=True)
class Certificate:
    """How a verdict was reached: method, points tried, and a bound on the chance that a wrong answer is accepted.

    For the method "exact", the bound holds for any wrong answer. For "numeric", it holds for an answer that is wrong at
    a share of at least WRONG_SHARE (or WRONG_SHARE_BRANCHING) of the configurations. If `bound` is None, no bound is
    claimed.
    """

    method: str
    points: int
    bound: float | None = None
    counterexample: Counterexample | None = None


@dataclass(frozen=True)
class Comparison:
    """Whether each entry is correct, and the certificate, with the first difference."""

    is_correct: tuple[bool, ...]
    certificate: Certificate


def compare_entries(
    student_entries: Nodes, reference_entries: Nodes, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Comparison:
    """Compare two lists of scalar trees entry by entry at random points.

    Nobody may know `seed`, which determines the points, before the answer is submitted. Raises ParseError for an entry
    that is not a scalar.
    """
    if all(remove_noise(node) is node for node in reference_entries):
        student_entries = [remove_noise(node) for node in student_entries]
    student_program, reference_program = compile_program(student_entries), compile_program(reference_entries)
    constants = domain.fixed_values()
    exact_results = exact.compare(student_program, reference_program, constants, seed)
    double_names = {name for name, value in constants.items() if value is None}
    allowances = [_find_allowed_errors(node, rounding, double_names) for node in student_entries]
    is_certain = [
        entry.is_equal is True or (entry.is_equal is False and not any(allowance))
        for entry, allowance in zip(exact_results, allowances, strict=True)
    ]
    equal = [entry.is_equal is True for entry in exact_results]
    points = max(entry.point_count for entry in exact_results)
    if all(equal):
        return Comparison(tuple(equal), Certificate("exact", points, max(entry.bound for entry in exact_results)))
    count = _choose_point_count(student_program, is_certain)
    names = set().union(*map(find_names, (*student_entries, *reference_entries)))
    values = domain.sample(names, count, Stream(seed))
    trial = _NumericComparison((student_program, reference_program), allowances, values, constants, count)
    for k, is_sure in enumerate(is_certain):
        if not is_sure:
            equal[k] = trial.is_equal(k)
    wrong_entries = [k for k, same in enumerate(equal) if not same]
    example = trial.find_counterexample(wrong_entries[0]) if wrong_entries else None
    if all(is_certain):
        bound = max((entry.bound for entry in exact_results if entry.is_equal), default=0.0)
        return Comparison(tuple(equal), Certificate("exact", points, bound, example))
    wrong_share = WRONG_SHARE_BRANCHING if student_program.has_branches else WRONG_SHARE
    bound = chance_of_missing(trial.defined_count, wrong_share)
    return Comparison(tuple(equal), Certificate("numeric", trial.point_count, bound, example))


def chance_of_missing(point_count: int, share: float = WRONG_SHARE) -> float:
    """Return the chance that an answer that is wrong at a `share` of all points is correct at all sampled points."""
    return float((1.0 - share) ** point_count)


def _choose_point_count(student_program: Program, is_certain: Sequence[bool]) -> int:
    """Return the number of points: few if only a counterexample is missing, many for functions with branches."""
    if all(is_certain):
        return READABLE_POINTS
    if not student_program.has_branches:
        return POINT_COUNT
    return max(POINT_COUNT, min(POINT_COUNT_BRANCHING, _MAX_VALUES // len(student_program.steps)))


def choose_decimal_tolerance(node: Node) -> float:
    """Return the relative error allowed for a formula whose decimals are printed doubles; 0 for any other formula."""
    return DOUBLE_TOLERANCE if count_decimal_digits(node) >= PRINTED_DOUBLE_DIGITS else 0.0


def _find_allowed_errors(node: Node, rounding: Rounding | None, double_names: AbstractSet[str]) -> tuple[float, float]:
    """Return the relative error (to the size of the reference's terms) and the absolute error allowed for an entry."""
    floats = DOUBLE_TOLERANCE if double_names and find_names(node) & double_names else choose_decimal_tolerance(node)
    return (floats, 0.0) if rounding is None else (max(floats, rounding.relative), rounding.absolute)


_MAX_VALUES = 10_000_000
"""Maximum count of double-precision values per comparison: a program of more than 5,000 steps has fewer points."""

_MAX_PRECISE_STEPS = 100_000
"""Maximum number of evaluation steps with many digits per comparison (some seconds), so that grading never stalls."""

_CLEAR_DIFFERENCE = 1e-9
"""Smallest difference that double precision may establish, relative to the size of the terms; far above rounding."""

_MAX_REGION_POINTS, _MAX_WORST_POINTS = 16, 3
"""Maximum number of points per entry evaluated with 50 digits: one for each region, and those with the largest
difference relative to rounding."""


class _NumericComparison:
    """The comparison of two programs at the same points: in double precision, and with many digits if necessary."""

    def __init__(
        self,
        programs: Sequence[Program],
        allowances: Sequence[tuple[float, float]],
        values: Mapping[str, np.ndarray],
        constants: Mapping[str, Fraction | None],
        point_count: int,
    ) -> None:
        self.programs, self.values, self.constants, self.point_count = programs, values, constants, point_count
        self.evaluated_steps = [(each, program.evaluate_steps(each, values, point_count)) for each in programs]
        results = [program.select_outputs(*evaluated) for evaluated in self.evaluated_steps]
        (self.student_values, size), (self.reference_values, expected_size) = results
        self.scale = _compute_term_scales(expected_size)
        with np.errstate(all="ignore"):
            parts, amounts = np.array(allowances).T
            self.allowed_error = parts[:, None] * self.scale + amounts[:, None]
            self.size = size + expected_size
            self.rounding_error = 10 * _RELATIVE_ROUNDING * self.size
            self.difference = np.abs(self.student_values - self.reference_values)
        self.remaining_evaluations = _MAX_PRECISE_STEPS // (2 * sum(len(each.steps) for each in programs))
        self.examples: dict[int, tuple[int, Any, Any]] = {}
        self.precise_results: dict[tuple[int, int], list[list[Any]]] = {}

    @cached_property
    def region_numbers(self) -> np.ndarray:
        """The number of each point's region."""
        return program.assign_regions(self.evaluated_steps, self.point_count)

    @property
    def defined_count(self) -> int:
        """The smallest number of points at which an entry of the reference is defined."""
        return int(np.isfinite(self.reference_values).sum(axis=1).min())

    def is_equal(self, entry: int) -> bool:
        """Return whether an entry is correct; if not, store a point at which it differs."""
        if self._is_clearly_different(entry).any():
            return False
        precise_results = [self._agrees_precisely(entry, int(point)) for point in self._points_to_check(entry)]
        return False not in precise_results and (True in precise_results or bool(self._is_clearly_allowed(entry).any()))

    def _is_clearly_different(self, entry: int) -> np.ndarray:
        """Return for each point whether the difference is much larger than any rounding error."""
        with np.errstate(all="ignore"):
            threshold = self.allowed_error[entry] + self.rounding_error[entry] + _CLEAR_DIFFERENCE * self.scale[entry]
            return np.asarray((self.difference[entry] > threshold) & np.isfinite(self.difference[entry]))

    def _is_clearly_allowed(self, entry: int) -> np.ndarray:
        """Return for each point whether double precision shows that the error is allowed."""
        with np.errstate(all="ignore"):
            return np.asarray(self.difference[entry] + self.rounding_error[entry] <= self.allowed_error[entry])

    def _points_to_check(self, entry: int) -> list[int]:
        """Return the points that need many digits: one of each region that isn't settled, and the worst points."""
        unsettled = np.flatnonzero(~self._is_clearly_allowed(entry))
        defined = np.isfinite(self.student_values[entry]) & np.isfinite(self.reference_values[entry])
        # Values with two decimals may coincide (a1 = a2) at a removable singularity; those of the other points can't.
        unsettled = unsettled[defined[unsettled] | (unsettled >= READABLE_POINTS)]
        if not len(unsettled):
            return []
        with np.errstate(all="ignore"):
            ratios = (self.difference[entry] - self.allowed_error[entry]) / self.rounding_error[entry]
        sortable_ratios = np.nan_to_num(ratios, nan=np.inf)[unsettled]
        first_of_region = np.sort(np.unique(self.region_numbers[unsettled], return_index=True)[1])
        worst = np.argpartition(-sortable_ratios, min(_MAX_WORST_POINTS, len(unsettled) - 1))[:_MAX_WORST_POINTS]
        points = unsettled[np.concatenate((first_of_region[:_MAX_REGION_POINTS], worst))]
        return list(dict.fromkeys(map(int, points)))

    def _agrees_precisely(self, entry: int, point: int) -> bool | None:
        """Return whether both values of an entry agree to many digits.

        Return None if the reference is undefined, or if the maximum number of steps has been used.
        """
        yours: Any = None
        expected: Any = None
        for digits in (50, 200):
            if (results := self._evaluate_precisely(point, digits)) is None:
                return None
            yours, expected = results[0][entry], results[1][entry]
            if not mpmath.isfinite(expected):
                return None
            if not mpmath.isfinite(yours):
                continue  # it may be defined with more digits, if a denominator almost vanishes
            with mpmath.workdps(digits):
                difference, size = abs(yours - expected), self.size[entry, point]
                scale = size if np.isfinite(size) else 1e10 * (abs(yours) + abs(expected))
                rounding_error = mpmath.mpf(10) ** (5 - digits) * scale
                allowance = max(self.allowed_error[entry, point], PRECISE_TOLERANCE * self.scale[entry, point])
            if difference + rounding_error <= allowance:
                return True
            if difference - rounding_error > allowance:
                break
        self.examples.setdefault(entry, (point, yours, expected))
        return False

    def _evaluate_precisely(self, point: int, digits: int) -> list[list[Any]] | None:
        """Return all results of both programs at a point with `digits` digits, or None if that takes too long."""
        if (point, digits) not in self.precise_results:
            if self.remaining_evaluations <= 0:
                return None
            self.remaining_evaluations -= 1
            at = {name: self.constants.get(name) or float(column[point]) for name, column in self.values.items()}
            self.precise_results[point, digits] = [evaluate_precisely(each, at, digits) for each in self.programs]
        return self.precise_results[point, digits]

    def find_counterexample(self, entry: int) -> EntryDifference:
        """Return a point where an entry differs, preferably a readable one, and both values there."""
        defined = np.isfinite(self.reference_values[entry])
        clear = np.flatnonzero((self._is_clearly_different(entry) | ~np.isfinite(self.student_values[entry])) & defined)
        if len(clear):
            point = int(clear[0])
            yours, expected = self.student_values[entry, point], self.reference_values[entry, point]
        else:
            point, yours, expected = self.examples.get(entry) or self._find_tiny_difference(entry)
        at = {name: _round_to_six_digits(column[point]) for name, column in sorted(self.values.items())}
        return EntryDifference(entry, at, *show_difference(yours, expected))

    def _find_tiny_difference(self, entry: int) -> tuple[int, Any, Any]:
        """Return a point at which 50 digits show a difference that double precision doesn't show, or else any point."""
        example = (0, self.student_values[entry, 0], self.reference_values[entry, 0])
        for point in range(READABLE_POINTS):
            if (results := self._evaluate_precisely(point, 50)) is not None:
                example = (point, results[0][entry], results[1][entry])
                if example[1] != example[2]:
                    break
        return example


def _compute_term_scales(magnitudes: np.ndarray) -> np.ndarray:
    """Return the scale of each entry: the size of its terms, or the largest scale at that point if the size is 0."""
    largest = magnitudes.max(axis=0, keepdims=True)
    largest = np.where((largest > 0) & np.isfinite(largest), largest, 1.0)
    return np.where((magnitudes > 0) & np.isfinite(magnitudes), magnitudes, largest)


def _round_to_six_digits(value: float) -> float:
    return float(f"{value:.6g}")


def show_difference(student_value: Any, expected_value: Any) -> tuple[float | str, float | str]:
    """Return two different values, written with enough digits to show the difference."""
    shown = to_json_number(complex(student_value)), to_json_number(complex(expected_value))
    if shown[0] != shown[1]:
        return shown
    precise_values = [mpmath.mpmathify(value) for value in (student_value, expected_value)]
    if not any(isinstance(value, str) for value in shown):  # real, except for a residue of complex arithmetic
        precise_values = [value.real for value in precise_values]
    for digits in range(8, 50, 2):
        texts = mpmath.nstr(precise_values[0], digits), mpmath.nstr(precise_values[1], digits)
        if texts[0] != texts[1]:
            return texts
    return shown


def to_json_number(value: complex) -> float | str:
    """Return a value for JSON: a float with six digits, or words if it is complex or not a number."""
    if not np.isfinite(value):
        return "not a finite number"
    if abs(value.imag) > 1e-9 * abs(value):
        return f"{value.real:.6g} + {value.imag:.6g}i"
    return _round_to_six_digits(value.real)
