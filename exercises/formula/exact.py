"""Decide exactly whether two expressions are the same rational function of lengths, sines and cosines.

Each angle theta is represented by a number w = exp(i theta / 8). An argument of a sine or cosine is a sum of angles,
halves, quarters and eighths of angles, and multiples of a quarter of a degree. Then the sine or cosine is a quotient of
polynomials in such numbers w, with coefficients in the field of the 1440th roots of unity. The same is true of sums,
products, quotients and integer powers of such sines, cosines and symbols. Two such functions n1/d1 and n2/d2 are equal
if and only if N = n1 d2 - n2 d1 is the zero polynomial.

Modulo a prime p = 1 (mod 1440), the integers contain 1440th roots of unity, so the functions can be evaluated without
rounding. The system's random generator chooses a prime and a root for several answers at a time. The point is chosen
after the answer is known. If the two values differ, the functions differ for certain. If N is not zero, the values can
still agree in two cases:

  - The prime ideal of p that belongs to the root divides a nonzero coefficient of N. The coefficient is an algebraic
    integer of norm at most 2^(384 height). The height is the binary logarithm of the sum of the sizes of all
    coefficients. Each ideal has the norm p > 2^80, so at most 384 height / 80 of the 384 PRIME_COUNT ideals divide it.
  - The point is a zero of N modulo p. At most the fraction degree / (p - 1) of all points are zeros (Schwartz, Zippel).

The sum of the two bounds the chance of accepting a wrong answer; points are added until it is below 1e-15. Degree and
height are computed from both texts as typed, without expanding anything. An angle outside of a sine or cosine, and pi,
are algebraically independent of the numbers w and are treated like symbols.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import comb, inf, isqrt, log2, prod
from operator import add
from typing import Any, NamedTuple

from sympy import multiplicity

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.angles import Angle, Phase, find_angles, make_phase
from qdot.exercises.formula.field import (
    PRIME_BITS,
    PRIME_COUNT,
    ROOT_ORDER,
    Field,
    SharedField,
    choose_field,
    choose_integer_below,
)
from qdot.exercises.formula.program import Program, Step

# --- sizes: degree and height of numerator and denominator ---


class Size(NamedTuple):
    """Upper bounds on the degree and height of a numerator, and on the degree and height of its denominator."""

    degree: float
    height: float
    denominator_degree: float = 0.0
    denominator_height: float = 0.0


def _add_sizes(x: Size, y: Size, count: int) -> Size:
    """Return the size of the sum nx/dx + count ny/dy = (nx dy + count ny dx) / (dx dy)."""
    if not count:
        return x
    degree = max(x.degree + y.denominator_degree, x.denominator_degree + y.degree)
    height = _log2_of_sum(x.height + y.denominator_height, x.denominator_height + y.height + log2(abs(count)))
    denominator_height = x.denominator_height + y.denominator_height
    return Size(degree, height, x.denominator_degree + y.denominator_degree, denominator_height)


def _log2_of_sum(x: float, y: float) -> float:
    """Return log2(2^x + 2^y), rounded up."""
    high, low = max(x, y), min(x, y)
    # log2(2^high + 2^low) = high + log2(1 + 2^(low - high)), and log2(1 + t) is at most 1 and at most 2t if t <= 1
    return high if low == -inf else high + (1.0 if high - low < 1 else 2.0 ** max(low - high + 1, -60.0))


def _invert_size(x: Size) -> Size:
    return Size(*x[2:], *x[:2])


def _log2(number: int) -> float:
    return log2(abs(number)) if number else -inf


# --- programs ---

ModularStep = tuple[str, tuple[int, ...], Any]
"""A step as in `program`, but the constant of a trigonometric function is the phase of its angle.

The constant of a square root is (rational factor, primes under the root, exponent of the root of unity).
"""


class SizedStep(NamedTuple):
    """A step, and the size of its result."""

    step: ModularStep
    size: Size


@dataclass(frozen=True)
class ModularProgram:
    """The steps of a program for evaluation modulo a prime; None for a step that can't be evaluated this way."""

    steps: tuple[SizedStep | None, ...]
    outputs: tuple[int, ...]

    def find_size(self, output_index: int) -> Size | None:
        """Return the size of a result; None if the result can't be recognised as a rational function."""
        sized_step = self.steps[self.outputs[output_index]]
        return None if sized_step is None else sized_step.size


_UNIT_SIZE = Size(0.0, 0.0)
"""The size of a number whose absolute value is 1, such as i."""
_MAX_SIZE = 1e15
"""Maximum degree and height of a function that is evaluated."""


def make_modular_program(program: Program, fixed_values: Mapping[str, Fraction | None]) -> ModularProgram:
    """Return a program for evaluation modulo a prime.

    `fixed_values` maps names to rational numbers, or to None (irrational).
    """
    steps = [_replace_fixed_name(step, fixed_values) for step in program.steps]
    angles = find_angles(steps)
    sized_steps: list[SizedStep | None] = []
    for op, operands, constant in steps:
        sizes = [operand.size for operand in (sized_steps[i] for i in operands) if operand is not None]
        if op in _TRIGONOMETRIC_FUNCTIONS:
            step = _make_trigonometric_step(op, angles[operands[0]])
        elif op == "sqrt":
            step = _make_square_root_step(angles[operands[0]])
        else:
            size = _compute_size(op, constant, sizes) if len(sizes) == len(operands) else None
            step = SizedStep((op, operands, constant), size) if size is not None else None
        sized_steps.append(None if step is None or max(step.size) > _MAX_SIZE else step)
    return ModularProgram(tuple(sized_steps), program.outputs)


def _compute_size(op: str, constant: Any, sizes: Sequence[Size]) -> Size | None:
    """Return the size of a step's result, given the sizes of its operands; None if the operation is not rational."""
    if op == "number":
        return Size(0.0, _log2(constant.numerator), 0.0, _log2(constant.denominator))
    if op == "name" and constant != "E":
        return _UNIT_SIZE if constant == "I" else Size(1.0, 0.0)
    if op == "sum":
        size = Size(0.0, -inf)
        for term, count in zip(sizes, constant, strict=True):
            size = _add_sizes(size, term, count)
        return size
    if op == "neg":
        return sizes[0]
    if op in ("*", "/"):
        factor_size = sizes[1] if op == "*" else _invert_size(sizes[1])
        return Size(*map(add, sizes[0], factor_size))
    if op == "integer power":
        base_size = sizes[0] if constant >= 0 else _invert_size(sizes[0])
        return Size(*(abs(constant) * bound for bound in base_size)) if constant else _UNIT_SIZE
    return None


def _replace_fixed_name(step: Step, fixed_values: Mapping[str, Fraction | None]) -> Step:
    """Return a step with a number if the step has a name that stands for this number."""
    op, _, name = step
    if op != "name" or name not in fixed_values:
        return step
    value = fixed_values[name]
    return ("number", (), value) if value is not None else ("unknown number", (), None)


_TRIGONOMETRIC_FUNCTIONS = frozenset({"sin", "cos", "tan", "cot", "sec", "csc", "exp"})


def _make_trigonometric_step(op: str, angle: Angle | None) -> SizedStep | None:
    """Return the step for a trigonometric function of a real angle, or for the exponential of an imaginary angle.

    Return None for any other angle, and for an angle without a phase.
    """
    if angle is None or angle.is_imaginary != (op == "exp"):
        return None
    phase = make_phase(angle.coefficients)
    if phase is None:
        return None
    exponent_sum = sum(abs(power) for _, power in phase.powers)
    if exponent_sum > _MAX_SIZE:  # a larger sum might not fit into a double
        return None
    degree = float(exponent_sum)
    exponential, sine = Size(degree, 0.0, degree, 0.0), Size(2 * degree, 1.0, degree, 1.0)
    tangent, inverse_sine = Size(2 * degree, 1.0, 2 * degree, 1.0), _invert_size(sine)
    size = {
        "exp": exponential, "sin": sine, "cos": sine, "tan": tangent, "cot": tangent,
        "sec": inverse_sine, "csc": inverse_sine,
    }[op]  # fmt: skip
    return SizedStep((op, (), phase), size)


_SQUARE_ROOTS = {2: ((1, 180), (1, -180)), 3: ((1, 120), (1, -120)), 5: ((1, 0), (2, 288), (2, -288))}
"""Square roots of 2, 3 and 5 as sums of terms (coefficient, power of the root of unity)."""


def _make_square_root_step(operand: Angle | None) -> SizedStep | None:
    """Return the step for the square root of a number whose squarefree part has only the prime factors 2, 3 and 5.

    A number is an "angle" that consists of a constant term. Return None for anything else.
    """
    if operand is None or set(operand.coefficients) - {""} or operand.is_imaginary:
        return None
    number = operand.coefficients.get("", Fraction(0))
    product = abs(number.numerator) * number.denominator
    root_primes = tuple(prime for prime in (2, 3, 5) if product and multiplicity(prime, product) % 2)
    integer_root = isqrt(product // prod(root_primes))
    if integer_root * integer_root * prod(root_primes) != product:
        return None
    factor = Fraction(integer_root, number.denominator)
    root_height = 3.0 * len(root_primes)  # the coefficients of a root in _SQUARE_ROOTS add up to less than 2^3
    size = Size(0.0, _log2(factor.numerator) + root_height, 0.0, _log2(factor.denominator))
    return SizedStep(("root", (), (factor, root_primes, ROOT_ORDER // 4 if number < 0 else 0)), size)


# --- evaluation ---


class _Point:
    """A random point: a value modulo the prime for each name, and for the number w of each angle.

    They are chosen when first used. If `is_shared`, a value depends only on its name, so all programs are evaluated at
    the same point.
    """

    def __init__(self, field: Field, stream: Stream, is_shared: bool = False) -> None:
        self.field, self.stream, self.is_shared = field, stream, is_shared
        self.values: dict[str, int] = {}

    def get_value(self, name: str) -> int:
        if name not in self.values:
            stream = self.stream.substream(name) if self.is_shared else self.stream
            self.values[name] = 1 + choose_integer_below(stream, self.field.prime - 1)
        return self.values[name]

    def evaluate_phase(self, phase: Phase) -> int:
        """Return exp(i angle) modulo the prime."""
        value = self.field.raise_root(phase.root_exponent)
        for name, power in phase.powers:
            value = value * pow(self.get_value(f"phase/{name}"), power, self.field.prime) % self.field.prime
        return value


def _reduce_modulo(number: Fraction, prime: int) -> int:
    """Return a rational number modulo a prime. Raises ValueError if the denominator is zero modulo the prime."""
    return number.numerator * pow(number.denominator, -1, prime) % prime


def evaluate_modular(program: ModularProgram, point: _Point) -> list[int | None]:
    """Return the results modulo the prime; None for a result that is undefined or not a rational function."""
    values: list[int | None] = []
    for sized_step in program.steps:
        value = None
        if sized_step is not None:
            op, operands, constant = sized_step.step
            args = [values[i] for i in operands]
            with suppress(ValueError):  # a division by zero
                value = None if None in args else _evaluate_step(op, args, constant, point) % point.field.prime
        values.append(value)
    return [values[i] for i in program.outputs]


def _evaluate_step(op: str, args: list[Any], constant: Any, point: _Point) -> int:
    """Return the result of a step, not reduced modulo the prime. Raises ValueError for a division by zero."""
    prime = point.field.prime
    if op == "*":
        return args[0] * args[1]
    if op == "sum":
        return sum(count * arg for count, arg in zip(constant, args, strict=True))
    if op in _TRIGONOMETRIC_FUNCTIONS:
        return _evaluate_trigonometric_function(op, point.evaluate_phase(constant), point.field)
    if op == "neg":
        return -args[0]
    if op == "name":
        return point.field.raise_root(ROOT_ORDER // 4) if constant == "I" else point.get_value(f"name/{constant}")
    if op == "number":
        return _reduce_modulo(constant, prime)
    if op == "/":
        return args[0] * pow(args[1], -1, prime)
    if op == "integer power":
        return pow(args[0], constant, prime)
    factor, root_primes, exponent = constant  # a square root
    value = _reduce_modulo(factor, prime) * point.field.raise_root(exponent)
    for root_prime in root_primes:
        value = value * sum(count * point.field.raise_root(power) for count, power in _SQUARE_ROOTS[root_prime]) % prime
    return value


def _evaluate_trigonometric_function(op: str, phase: int, field: Field) -> int:
    """Return the value of a function of an angle, given `phase` = exp(i angle)."""
    if op == "exp":
        return phase
    prime, i = field.prime, field.raise_root(ROOT_ORDER // 4)
    inverse_phase = pow(phase, -1, prime)
    sine, cosine = (inverse_phase - phase) * i, phase + inverse_phase  # each times 2
    numerator, denominator = {
        "sin": (sine, 2), "cos": (cosine, 2), "tan": (sine, cosine),
        "cot": (cosine, sine), "sec": (2, cosine), "csc": (2, sine),
    }[op]  # fmt: skip
    return numerator * pow(denominator, -1, prime)


# --- comparison ---

MAX_ERROR_CHANCE = 1e-15
"""Maximum chance of accepting a wrong answer; points are added until the bound is below this."""
MAX_POINTS = 6
"""Maximum number of points. If only the reference is defined at all of them, the results differ; otherwise they stay
undecided."""


class ExactComparison:
    """The comparison of one result of two programs, at the points tried so far.

    `bound` limits the chance that an answer is wrong if it is accepted now. The sizes are None for a result that is not
    a rational function; such results are not compared.
    """

    def __init__(self, student_size: Size | None, reference_size: Size | None) -> None:
        self._sizes = student_size and reference_size and (student_size, reference_size)
        self._tried_count, self._agreeing_count, self._undefined_answer_count = 0, 0, 0
        self._differs, self.bound = False, inf

    @property
    def needs_points(self) -> bool:
        """Whether another point may decide the comparison."""
        return self._sizes is not None and not self._differs and self.bound > MAX_ERROR_CHANCE

    @property
    def is_equal(self) -> bool | None:
        """Whether the results are the same function; None if that is undecided."""
        if self._differs or 0 < self._tried_count == self._undefined_answer_count:
            return False
        return True if self.bound <= MAX_ERROR_CHANCE else None

    @property
    def point_count(self) -> int:
        """The number of points that led to the decision."""
        return self._agreeing_count if self.is_equal else self._tried_count

    def add_point(self, student_value: int | None, reference_value: int | None, field: Field) -> None:
        """Compare the values at one more point; None is an undefined value."""
        self._tried_count += 1
        if student_value is None or reference_value is None:
            self._undefined_answer_count += reference_value is not None
        elif student_value != reference_value:
            self._differs = True
        elif self._sizes is not None:
            self._agreeing_count += 1
            single_chance = bound_chance_of_agreement(*self._sizes, field.bits, field.prime_count)
            self.bound = min(1.0, comb(self._tried_count, self._agreeing_count) * single_chance**self._agreeing_count)


def bound_chance_of_agreement(
    student: Size, reference: Size, bits: int = PRIME_BITS, prime_count: float = PRIME_COUNT
) -> float:
    """Return a bound on the chance that two different functions agree at one random point."""
    difference = _add_sizes(student, reference, -1)
    degree, height = difference.degree, difference.height
    return min(1.0, degree / 2.0**bits + max(height, 0.0) / bits / prime_count)


_SHARED_FIELD = SharedField()


def compare(
    student: Program, reference: Program, fixed_values: Mapping[str, Fraction | None], seed: str,
    choose_test_field: Callable[[Stream], Field] | None = None,
) -> list[ExactComparison]:  # fmt: skip
    """Compare two programs result by result.

    `fixed_values` is as for `make_modular_program`. A student's result that is undefined wherever the reference is
    defined differs from it. `seed` determines the points and all fields except the first, which other comparisons
    share. Tests choose all fields themselves.
    """
    modular_student = make_modular_program(student, fixed_values)
    modular_reference = modular_student if student == reference else make_modular_program(reference, fixed_values)
    stream = Stream(f"{seed}/exact")
    indices = range(len(modular_reference.outputs))
    comparisons = [ExactComparison(modular_student.find_size(k), modular_reference.find_size(k)) for k in indices]
    for trial in range(MAX_POINTS):
        if not any(comparison.needs_points for comparison in comparisons):
            break
        is_shared = trial == 0 and choose_test_field is None
        chosen_field = _SHARED_FIELD.get() if is_shared else (choose_test_field or choose_field)(stream)
        point = _Point(chosen_field, stream)
        student_values = evaluate_modular(modular_student, point)
        is_same_program = modular_reference is modular_student
        reference_values = student_values if is_same_program else evaluate_modular(modular_reference, point)
        for comparison, value, expected in zip(comparisons, student_values, reference_values, strict=True):
            if comparison.needs_points:
                comparison.add_point(value, expected, chosen_field)
    return comparisons


# --- fingerprints of functions ---

FINGERPRINT_POINTS = 2
"""Number of points for a fingerprint. Two different functions agree at both points with a chance of about 1 in
10^40."""


def fingerprint_results(program: Program, seed: str) -> list[tuple[int | None, ...] | None]:
    """Return numbers that identify each result: equal functions have equal numbers, whatever their texts.

    The numbers are the values of the result modulo a prime, at points that depend only on `seed` and on the names. An
    undefined value is None. If a result is not a rational function of lengths, sines and cosines, return None for it.

    >>> from qdot.exercises.formula.parser import parse_formula
    >>> from qdot.exercises.formula.program import compile_program
    >>> program = compile_program([parse_formula(text) for text in ("2*sin(x)*cos(x)", "sin(2*x)", "sin(x)")])
    >>> double, same, single = fingerprint_results(program, "s")
    >>> double == same, double == single
    (True, False)
    """
    modular, seeded_field = make_modular_program(program, {}), _choose_seeded_field(seed)
    points = (_Point(seeded_field, Stream(f"{seed}/{k}"), is_shared=True) for k in range(FINGERPRINT_POINTS))
    columns = zip(*(evaluate_modular(modular, point) for point in points), strict=True)
    return [None if modular.find_size(entry) is None else column for entry, column in enumerate(columns)]


@lru_cache(maxsize=16)
def _choose_seeded_field(seed: str) -> Field:
    return choose_field(Stream(f"{seed}/field"))
