"""Find the angles in a program: sums of names and of pi with rational factors, as in the argument of a sine."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from qdot.exercises.formula.field import ROOT_ORDER
from qdot.exercises.formula.program import Step, compile_program
from qdot.exercises.formula.trees import Node

ANGLE_DIVISOR = 8
"""An angle theta is represented by w = exp(i theta / ANGLE_DIVISOR). So exp(i theta / 2) is a power of w, for
example."""

AngleCoefficients = dict[str, Fraction]
"""A sum of multiples of names and pi. It maps each name to its rational factor, and "" to the constant term."""


class Angle(NamedTuple):
    """An angle, or an angle times i if `is_imaginary`, such as the exponent of exp(i theta)."""

    coefficients: AngleCoefficients
    is_imaginary: bool = False


MAX_BITS = 10_000
"""Maximum number of bits of an angle's factors, because long numbers could use up the memory."""


@dataclass(frozen=True)
class Phase:
    """The value exp(i angle), as a product of a power of w for each name and a power of the root of unity.

    `powers` has pairs (name, exponent of its w); `root_exponent` is the exponent of the root of unity.
    """

    powers: tuple[tuple[str, int], ...]
    root_exponent: int


def make_phase(angle: AngleCoefficients) -> Phase | None:
    """Return exp(i angle); None if it is not a product as in Phase.

    The factor of each name must be a multiple of 1 / ANGLE_DIVISOR. The multiple of pi must be a multiple of a quarter
    of a degree. There must be no constant term, because the exponential of a number of radians is not a root of unity.
    """
    powers, root_exponent = [], Fraction(0)
    for name, factor in angle.items():
        if name == "pi":
            root_exponent = factor * ROOT_ORDER / 2
        elif name == "" and factor:
            return None
        elif name and factor:
            powers.append((name, factor * ANGLE_DIVISOR))
    if root_exponent.denominator != 1 or any(power.denominator != 1 for _, power in powers):
        return None
    return Phase(tuple((name, int(power)) for name, power in powers), int(root_exponent) % ROOT_ORDER)


def find_angles(steps: Sequence[Step]) -> list[Angle | None]:
    """Return for each step of a program the angle that it computes, or None if it computes no angle."""
    angles: list[Angle | None] = []
    for op, operands, constant in steps:
        args = [angle for angle in (angles[i] for i in operands) if angle is not None]
        angles.append(_compute_angle(op, args, constant) if len(args) == len(operands) else None)
    return angles


def _compute_angle(op: str, args: Sequence[Angle], constant: Any) -> Angle | None:
    """Return the angle that a step computes from the angles `args`, or None if the result is not an angle."""
    if op == "number":
        return Angle({"": constant})
    if op == "name" and constant != "E":
        return Angle({"": Fraction(1)}, is_imaginary=True) if constant == "I" else Angle({constant: Fraction(1)})
    if op == "sum":
        return _add_angles(args, constant)
    if op == "neg":
        return _scale_angle(args[0], Fraction(-1))
    if op == "*":
        for factor, angle in (args, args[::-1]):
            if set(factor.coefficients) <= {""}:  # a number
                return _scale_angle(angle, factor.coefficients.get("", Fraction(0)), factor.is_imaginary)
    if op == "/" and set(args[1].coefficients) <= {""} and args[1].coefficients.get("") and not args[1].is_imaginary:
        return _scale_angle(args[0], 1 / args[1].coefficients[""])
    return None


def _add_angles(terms: Sequence[Angle], counts: Sequence[int]) -> Angle | None:
    """Return the sum of angles times counts; None if only some angles are imaginary, or if a factor is too long."""
    if len({term.is_imaginary for term in terms}) > 1:
        return None
    total: AngleCoefficients = {}
    for term, count in zip(terms, counts, strict=True):
        for name, factor in term.coefficients.items():
            total[name] = total.get(name, Fraction(0)) + count * factor
            if _is_too_long(total[name]):
                return None
    return Angle(total, bool(terms) and terms[0].is_imaginary)


def _scale_angle(angle: Angle, factor: Fraction, is_imaginary: bool = False) -> Angle | None:
    """Return an angle multiplied by a factor and, if `is_imaginary`, by i; None if a number is too long."""
    sign = -1 if is_imaginary and angle.is_imaginary else 1
    product = {name: sign * factor * value for name, value in angle.coefficients.items()}
    return None if any(map(_is_too_long, product.values())) else Angle(product, is_imaginary != angle.is_imaginary)


def _is_too_long(number: Fraction) -> bool:
    return max(number.numerator.bit_length(), number.denominator.bit_length()) > MAX_BITS


def find_linear_factors(node: Node) -> AngleCoefficients:
    """Return the rational factors of a sum of names and of pi; {} for any other tree.

    >>> find_linear_factors(Node("neg", (Node("name", value="theta1"),)))
    {'theta1': Fraction(-1, 1)}
    """
    program = compile_program([node])
    angle = find_angles(program.steps)[program.outputs[0]]
    return {} if angle is None or angle.is_imaginary else angle.coefficients


def find_multiple_of_pi(node: Node) -> Fraction | None:
    """Return the factor of a rational multiple of pi, reduced to 0 <= factor < 2; None for any other tree.

    >>> find_multiple_of_pi(Node("neg", (Node("name", value="pi"),)))
    Fraction(1, 1)
    """
    factors = find_linear_factors(node)
    if not factors or set(factors) - {"pi", ""} or factors.get(""):
        return None
    return factors.get("pi", Fraction(0)) % 2
