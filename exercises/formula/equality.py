"""Decide whether two expressions are the same function, entry by entry, and find where they differ.

Rational functions of lengths, sines and cosines are compared exactly (`exact`), with a bound on the chance of a wrong
verdict. Other expressions (square roots, inverse functions, absolute values, decimals in a sine) are compared
numerically at many random points. A point consists of a value for each symbol.

  - Double precision is used only to find differences much larger than any rounding error.
  - Whether two values are equal is decided with 50 digits, at one or more points of every sampled region. A region is a
    set of points at which the operands of functions with branches have the same signs. Both expressions are analytic in
    a region, so if they agree around one point, they agree everywhere in it.

Decimals are exact: 0.5 is a half, 3.14 is not pi. Only a number of 13 digits or more is taken for a double that a
program printed (SymPy prints 15 digits, without trailing zeros). Such a number may have the rounding error of a
floating-point calculation (DOUBLE_TOLERANCE, relative to the size of the terms). An assignment may allow more
(`Rounding`).
"""

import math
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

POINT_COUNT, POINT_COUNT_BRANCHING = 50, 2000
"""Number of points of a numeric comparison, without and with functions with branches."""
WRONG_SHARE, WRONG_SHARE_BRANCHING = 0.5, 0.02
"""The bound of a numeric comparison holds for answers that are wrong at this fraction of the points or more."""
READABLE_POINTS = 8
"""Number of points whose values have two decimals, so that people can check a counterexample. They come first."""

PRINTED_DOUBLE_DIGITS, ROOT_DIGITS = 13, 16
"""Minimum number of digits of a typed decimal that counts as a printed double, and of a number in a problem that counts
as an irrational root."""
MIN_VISIBLE_SHARE = 0.02
"""Minimum size of the values at a counterexample, relative to the median over all wrong points."""
DOUBLE_TOLERANCE = 1e-12
"""Relative error allowed for joint values, and for entries with decimals of PRINTED_DOUBLE_DIGITS or more."""

_RELATIVE_ROUNDING = 640 * np.finfo(float).eps
"""Bound on the rounding error of a result in double precision, relative to its magnitude. It is generous, because the
errors of many steps add up."""


@dataclass(frozen=True)
class Domain:
    """The range from which each symbol is sampled.

    The role of a symbol is a kind of random value, a fixed number, or an array with one number for each point. These
    are the kinds of random values:

    - "angle": from the whole circle.
    - "length", "positive": positive numbers.
    - "signed": positive or negative numbers.
    - "travel": values of a prismatic joint in metres, positive or negative, within the reach of any arm.

    An irrational number (a root) is given as a double. Any other double stands for the decimal as which it is printed.
    The names in `unlisted_names` belong to other parts of the problem and are left out of messages that list the
    symbols.
    """

    roles: Mapping[str, str | float | Fraction | np.ndarray]
    unlisted_names: AbstractSet[str] = frozenset()

    def list_fixed_values(self) -> dict[str, Fraction | None]:
        """Return the value of each name that stands for a number; None for an irrational number, known as a double."""
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
    """Return a number of a problem as an exact fraction; None for a root, which is known only as a double."""
    if isinstance(number, Fraction):
        return number
    return None if count_digits(Fraction(repr(number))) >= ROOT_DIGITS else Fraction(repr(number))


def _sample_role(role: str, point_count: int, stream: Stream) -> np.ndarray:
    """Return random values for a role (rad or m), of which the first READABLE_POINTS have two decimals.

    Positive numbers lie between 0.05 and 40 (readable ones: 0.2 and 1.5), the sizes of travels between 0.2 and 10. Both
    have uniformly distributed logarithms. The sizes of signed numbers lie between 0.2 and 2.
    """
    # 53 random bits, as many as a double stores, make a fraction from 0 to 1
    fractions = (np.frombuffer(stream.take_bytes(8 * point_count), dtype=">u8") >> np.uint64(11)) / float(1 << 53)
    if role == "angle":
        values = np.pi * (2 * fractions - 1)
    elif role in ("length", "positive"):
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
    """Return the default role of a name: "angle" for theta1, "length" for a1, d1 and L1, and "signed" for others."""
    if name.startswith("theta"):
        return "angle"
    return "length" if name[0] in "adLl" and name[1:].isdigit() else "signed"


MAX_DIGITS = 15
"""The number of significant digits that every float stores correctly."""


@dataclass(frozen=True)
class Rounding:
    """The error that an assignment allows for decimals: relative to the value's size, or absolute in SI units.

    `words` describe the error, as in "to three significant digits" or "within 0.01 rad/s". If the entries of a vector
    have different absolute errors, `errors_of_entries` holds all of them, and `absolute` is the smallest.
    """

    relative: float = 0.0
    absolute: float = 0.0
    words: str = ""
    errors_of_entries: tuple[float, ...] = field(default=(), repr=False)

    def count_digits(self, value: float) -> int:
        """Return the number of significant digits to which a value must be given to be within this error.

        >>> Rounding(5e-4).count_digits(9.5), Rounding(absolute=0.01).count_digits(123.456)
        (4, 5)
        """
        if value == 0:
            return 1
        exponent = math.floor(math.log10(abs(value)))
        allowed_error = max(self.relative * 10.0**exponent, self.absolute)
        if allowed_error == 0:
            return MAX_DIGITS
        return exponent + 1 + math.ceil(-math.log10(2 * allowed_error) - 1e-9)  # 1e-9: the error of the logarithm


@dataclass(frozen=True)
class EntryDifference:
    """A point at which an entry (counted from 0) is wrong: the symbols' values in rad and m, and the entry's values.

    `yours` is the answer's value. A value is a text if it is not a finite real number, or if a float has too few digits
    to show the difference. `expected` is None if students may not see it. If only the direction of a vector counts, the
    expected vector is scaled so that its entry `pivot` equals that of the answer.
    """

    entry: int
    at: Mapping[str, float]
    yours: float | str
    expected: float | str | None
    pivot: int | None = field(default=None, metadata=OMITTED_IF_NONE)


@dataclass(frozen=True)
class SetDifference:
    """Configurations (rad and m): `missing` is only in the reference set, and `surplus` only in the student's set."""

    missing: Mapping[str, float] | None
    surplus: Mapping[str, float] | None


Counterexample = EntryDifference | SetDifference


@dataclass(frozen=True)
class Certificate:
    """The evidence for a verdict: the method, the number of points, and a bound on the chance of a false acceptance.

    For the method "exact", the bound holds for any wrong answer. For "numeric", it holds if the answer is wrong at a
    large share of all points: at least WRONG_SHARE, or WRONG_SHARE_BRANCHING if functions have branches. If `bound` is
    None, no bound is known.
    """

    method: str
    points: int
    bound: float | None = None
    counterexample: Counterexample | None = None


@dataclass(frozen=True)
class Comparison:
    """Whether each entry is correct, and the certificate, with a counterexample for the first wrong entry."""

    is_correct: tuple[bool, ...]
    certificate: Certificate


def compare_entries(
    student_entries: Nodes, reference_entries: Nodes, domain: Domain, seed: str, rounding: Rounding | None = None
) -> Comparison:
    """Compare two lists of scalar trees entry by entry.

    `seed` determines the random points, so nobody may know it before the answer is submitted. Raises ParseError for an
    entry that is not a scalar.
    """
    # if the reference has tiny terms, those of the answer may be meant, too
    reference_has_tiny_terms = any(remove_noise(node) is not node for node in reference_entries)
    entries = student_entries if reference_has_tiny_terms else [remove_noise(node) for node in student_entries]
    student_program, reference_program = compile_program(entries), compile_program(reference_entries)
    fixed_values = domain.list_fixed_values()
    exact_results = exact.compare(student_program, reference_program, fixed_values, seed)
    is_correct = [result.is_equal is True for result in exact_results]
    method, point_count = "exact", max(result.point_count for result in exact_results)
    bound = max((result.bound for result in exact_results if result.is_equal), default=0.0)
    counterexample = None
    if not all(is_correct):
        double_names = {name for name, value in fixed_values.items() if value is None}
        allowances = [_find_allowed_errors(node, rounding, double_names) for node in entries]
        # the exact verdict is final, unless an allowed error may excuse a difference
        is_certain = [
            bool(result.is_equal) or (result.is_equal is False and not any(allowance))
            for result, allowance in zip(exact_results, allowances, strict=True)
        ]
        sample_count = _choose_point_count(student_program, is_certain)
        names = set().union(*map(find_names, (*entries, *reference_entries)))
        values = domain.sample(names, sample_count, Stream(seed))
        programs = student_program, reference_program
        comparison = _NumericComparison(programs, allowances, values, fixed_values, sample_count)
        for entry in range(len(is_correct)):
            is_correct[entry] = is_correct[entry] if is_certain[entry] else comparison.is_equal(entry)
        if not all(is_correct):
            counterexample = comparison.find_counterexample(is_correct.index(False))
        if not all(is_certain):
            wrong_share = WRONG_SHARE_BRANCHING if student_program.has_branches else WRONG_SHARE
            method, point_count = "numeric", comparison.point_count
            bound = compute_chance_of_missing(comparison.defined_count, wrong_share)
    return Comparison(tuple(is_correct), Certificate(method, point_count, bound, counterexample))


def compute_chance_of_missing(point_count: int, share: float = WRONG_SHARE) -> float:
    """Return the chance that an answer that is wrong at a `share` of all points is correct at all sampled points."""
    return float((1.0 - share) ** point_count)


def _choose_point_count(student_program: Program, is_certain: Sequence[bool]) -> int:
    """Return the number of points: few if all verdicts are certain, many for functions with branches."""
    if all(is_certain):
        return READABLE_POINTS
    if not student_program.has_branches:
        return POINT_COUNT
    return max(POINT_COUNT, min(POINT_COUNT_BRANCHING, _MAX_VALUES // len(student_program.steps)))


def choose_decimal_tolerance(node: Node) -> float:
    """Return the relative error allowed for a formula whose decimals are printed doubles; 0 for any other formula."""
    return DOUBLE_TOLERANCE if count_decimal_digits(node) >= PRINTED_DOUBLE_DIGITS else 0.0


def _find_allowed_errors(node: Node, rounding: Rounding | None, double_names: AbstractSet[str]) -> tuple[float, float]:
    """Return the error allowed for an entry, relative to the size of the reference's terms, and the absolute error."""
    has_doubles = bool(double_names and find_names(node) & double_names)
    relative_error = DOUBLE_TOLERANCE if has_doubles else choose_decimal_tolerance(node)
    return (relative_error, 0.0) if rounding is None else (max(relative_error, rounding.relative), rounding.absolute)


_MAX_VALUES = 10_000_000
"""Maximum number of double-precision values in a comparison: a program of more than 5,000 steps has fewer points."""

_MAX_PRECISE_STEPS = 100_000
"""Maximum number of steps that a comparison evaluates with many digits; more would take longer than some seconds."""

_CLEAR_DIFFERENCE = 1e-9
"""Minimum relative difference that is certain in double precision; it is far larger than rounding errors."""

_MAX_REGION_POINTS, _MAX_WORST_POINTS = 16, 3
"""Maximum number of points at which an entry is evaluated with many digits: one for each region, and others.

The other points are those with the largest differences relative to rounding errors.
"""


class _NumericComparison:
    """The comparison of two programs at the same points: in double precision and, if necessary, with many digits.

    `allowances` are the relative and the absolute error allowed for each entry. Arrays have the shape (entries,
    points). Magnitudes are the sizes of the terms that are added to obtain a value (`program`).
    """

    def __init__(
        self, programs: Sequence[Program], allowances: Sequence[tuple[float, float]],
        values: Mapping[str, np.ndarray], fixed_values: Mapping[str, Fraction | None], point_count: int,
    ) -> None:  # fmt: skip
        self.programs, self.values, self.fixed_values, self.point_count = programs, values, fixed_values, point_count
        self.evaluated_steps = [(p, program.evaluate_steps(p, values, point_count)) for p in programs]
        results = [program.select_outputs(p, steps) for p, steps in self.evaluated_steps]
        (self.student_values, magnitudes), (self.reference_values, reference_magnitudes) = results
        self.scale = _compute_term_scales(reference_magnitudes)
        with np.errstate(all="ignore"):
            relative_errors, absolute_errors = np.array(allowances).T
            self.allowed_error = relative_errors[:, None] * self.scale + absolute_errors[:, None]
            self.magnitude = magnitudes + reference_magnitudes
            self.rounding_error = _RELATIVE_ROUNDING * self.magnitude
            self.difference = np.abs(self.student_values - self.reference_values)
        self.remaining_evaluations = _MAX_PRECISE_STEPS // (2 * sum(len(p.steps) for p in programs))
        self.examples: dict[int, tuple[int, Any, Any]] = {}
        """For each entry that differs: a point, the answer's value and the expected value there."""
        self.precise_results: dict[tuple[int, int], list[list[Any]]] = {}
        """For each point and number of digits: the results of both programs."""

    @cached_property
    def region_numbers(self) -> np.ndarray:
        """The number of each point's region, (points,)."""
        return program.assign_regions(self.evaluated_steps, self.point_count)

    @property
    def defined_count(self) -> int:
        """The smallest number of points at which an entry of the reference is defined."""
        return int(np.isfinite(self.reference_values).sum(axis=1).min())

    def is_equal(self, entry: int) -> bool:
        """Return whether an entry is correct."""
        if self._is_clearly_different(entry).any():
            return False
        precise_results = [self._agrees_precisely(entry, int(point)) for point in self._choose_points(entry)]
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

    def _choose_points(self, entry: int) -> list[int]:
        """Return the points to evaluate with many digits: one of each region, and those with the largest differences.

        Points at which double precision shows that the error is allowed need no more digits.
        """
        undecided_points = np.flatnonzero(~self._is_clearly_allowed(entry))
        is_defined = np.isfinite(self.student_values[entry]) & np.isfinite(self.reference_values[entry])
        # Values with two decimals may be equal (a1 = a2), so that 0/0 occurs; other values are never equal.
        undecided_points = undecided_points[is_defined[undecided_points] | (undecided_points >= READABLE_POINTS)]
        if not len(undecided_points):
            return []
        with np.errstate(all="ignore"):
            ratios = (self.difference[entry] - self.allowed_error[entry]) / self.rounding_error[entry]
        sortable_ratios = np.nan_to_num(ratios, nan=np.inf)[undecided_points]
        _, first_of_region = np.unique(self.region_numbers[undecided_points], return_index=True)
        last_index = min(_MAX_WORST_POINTS, len(undecided_points) - 1)
        worst_indices = np.argpartition(-sortable_ratios, last_index)[:_MAX_WORST_POINTS]
        points = undecided_points[np.concatenate((np.sort(first_of_region)[:_MAX_REGION_POINTS], worst_indices))]
        return list(dict.fromkeys(map(int, points)))

    def _agrees_precisely(self, entry: int, point: int) -> bool | None:
        """Return whether both values of an entry agree to many digits; if not, store them as an example.

        Return None if the reference is undefined, or if the maximum number of steps has been used.
        """
        yours: Any = None
        expected: Any = None
        for digits in (program.PRECISE_DIGITS, 4 * program.PRECISE_DIGITS):
            if (results := self._evaluate_precisely(point, digits)) is None:
                return None
            yours, expected = (program_results[entry] for program_results in results)
            if not mpmath.isfinite(expected):
                return None
            if not mpmath.isfinite(yours):
                continue  # more digits may help if a denominator almost vanishes
            with mpmath.workdps(digits):
                difference, magnitude = abs(yours - expected), self.magnitude[entry, point]
                # without a finite magnitude, assume that up to ten digits cancel; five digits are lost by rounding
                scale = magnitude if np.isfinite(magnitude) else 1e10 * (abs(yours) + abs(expected))
                rounding_error = mpmath.mpf(10) ** (5 - digits) * scale
                allowance = max(self.allowed_error[entry, point], PRECISE_TOLERANCE * self.scale[entry, point])
            if difference + rounding_error <= allowance:
                return True
            if difference - rounding_error > allowance:
                break
        self.examples.setdefault(entry, (point, yours, expected))
        return False

    def _evaluate_precisely(self, point: int, digits: int) -> list[list[Any]] | None:
        """Return all results of both programs at a point with `digits` digits, or None if there are too many steps."""
        if (point, digits) not in self.precise_results:
            if self.remaining_evaluations <= 0:
                return None
            self.remaining_evaluations -= 1
            symbols = {
                name: self.fixed_values.get(name) or float(column[point]) for name, column in self.values.items()
            }
            self.precise_results[point, digits] = [evaluate_precisely(p, symbols, digits) for p in self.programs]
        return self.precise_results[point, digits]

    def find_counterexample(self, entry: int) -> EntryDifference:
        """Return a point where an entry differs, preferably one with two decimals, and both values there.

        Points at which both values are tiny are avoided, because they would not convince a student.
        """
        is_defined = np.isfinite(self.reference_values[entry])
        is_wrong = self._is_clearly_different(entry) | ~np.isfinite(self.student_values[entry])
        points = np.flatnonzero(is_wrong & is_defined)
        if len(points):
            with np.errstate(invalid="ignore"):
                sizes = np.fmax(np.abs(self.student_values[entry]), np.abs(self.reference_values[entry]))
            readable_points = points[points < READABLE_POINTS]
            is_visible = sizes[readable_points] >= MIN_VISIBLE_SHARE * np.median(sizes[points])
            point = int([*readable_points[is_visible], *points][0])
            yours, expected = self.student_values[entry, point], self.reference_values[entry, point]
        else:
            point, yours, expected = self.examples.get(entry) or self._find_tiny_difference(entry)
        symbols = {name: round_to_six_digits(column[point]) for name, column in sorted(self.values.items())}
        return EntryDifference(entry, symbols, *format_difference(yours, expected))

    def _find_tiny_difference(self, entry: int) -> tuple[int, Any, Any]:
        """Return a point at which PRECISE_DIGITS digits show a difference, or else any point, and both values there."""
        example = (0, self.student_values[entry, 0], self.reference_values[entry, 0])
        for point in range(READABLE_POINTS):
            if (results := self._evaluate_precisely(point, program.PRECISE_DIGITS)) is not None:
                yours, expected = (program_results[entry] for program_results in results)
                example = (point, yours, expected)
                if yours != expected:
                    break
        return example


def _compute_term_scales(magnitudes: np.ndarray) -> np.ndarray:
    """Return the scale of each entry: its magnitude or, if that is 0, the largest magnitude at the same point."""
    largest_magnitudes = magnitudes.max(axis=0, keepdims=True)
    largest_magnitudes = np.where((largest_magnitudes > 0) & np.isfinite(largest_magnitudes), largest_magnitudes, 1.0)
    return np.where((magnitudes > 0) & np.isfinite(magnitudes), magnitudes, largest_magnitudes)


def round_to_six_digits(value: float) -> float:
    """Return a number with six digits, which is the same on every machine."""
    return float(f"{value:.6g}")


def format_difference(student_value: Any, expected_value: Any) -> tuple[float | str, float | str]:
    """Return the answer's value and the expected value, with enough digits to show their difference."""
    yours, expected = to_json_number(complex(student_value)), to_json_number(complex(expected_value))
    if yours != expected:
        return yours, expected
    precise_values = [mpmath.mpmathify(value) for value in (student_value, expected_value)]
    if not isinstance(yours, str):  # the imaginary part is only a rounding error
        precise_values = [value.real for value in precise_values]
    for digits in range(8, 50, 2):
        your_text, expected_text = (mpmath.nstr(value, digits) for value in precise_values)
        if your_text != expected_text:
            return your_text, expected_text
    return yours, expected


def to_json_number(value: complex) -> float | str:
    """Return a value for JSON: a float with six digits, or words if it is complex or not a number."""
    if not np.isfinite(value):
        return "undefined or too large"
    if abs(value.imag) > 1e-9 * abs(value):
        real_part = f"{value.real:.6g} " if abs(value.real) > 1e-9 * abs(value) else ""
        sign = "-" if value.imag < 0 else "+" if real_part else ""
        return f"{real_part}{sign}{' ' if real_part else ''}{abs(value.imag):.6g}i"
    return round_to_six_digits(value.real)
