"""What stands inside a sine: sums of names and of pi with rational factors, found among the steps of a program."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from qdot.exercises.formula.field import ORDER
from qdot.exercises.formula.program import Step

PARTS = 8
"""An angle's w is exp(i theta / PARTS), so that halves, quarters and eighths of it are whole powers."""

Angle = dict[str, Fraction]
"""A sum of names and of pi (under "pi") with rational factors; the constant term stands under ""."""


MOST_BITS = 10_000
"""Size of a factor beyond which nothing is an angle: products of long numbers would fill the memory."""


@dataclass(frozen=True)
class Phase:
    """exp(i angle) as a product of powers of the w and of the root of unity."""

    powers: tuple[tuple[str, int], ...]
    turn: int


def phase_of(angle: Angle) -> Phase | None:
    """Return exp(i angle); None where a factor is not in eighths, or a constant no multiple of half a degree."""
    powers, turn = [], Fraction(0)
    for name, factor in angle.items():
        if name == "pi":
            turn = factor * ORDER / 2
        elif name == "" and factor:
            return None
        elif name and factor:
            powers.append((name, factor * PARTS))
    if turn.denominator != 1 or any(power.denominator != 1 for _, power in powers):
        return None
    return Phase(tuple((name, int(power)) for name, power in powers), int(turn) % ORDER)


class Angles:
    """The angles among the steps of a program, with whether each is to be multiplied by i."""

    def __init__(self, steps: Sequence[Step]) -> None:
        self.steps = steps
        self.found: dict[int, tuple[Angle, bool] | None] = {}

    def at(self, index: int) -> tuple[Angle, bool] | None:
        """Return the angle that a step is; None where it is none."""
        todo = [index]
        while todo:  # no recursion: a product of many factors is a deep program
            top = todo[-1]
            missing = [i for i in self.steps[top][1] if i not in self.found] if top not in self.found else []
            if missing:
                todo += missing
            else:
                todo.pop()
                if top not in self.found:
                    self.found[top] = self._made(*self.steps[top])
        return self.found[index]

    def _made(self, op: str, operands: tuple[int, ...], constant: Any) -> tuple[Angle, bool] | None:
        if op == "number":
            return {"": constant}, False
        if op == "name":
            return (
                ({"": Fraction(1)}, True)
                if constant == "I"
                else None
                if constant == "E"
                else ({constant: Fraction(1)}, False)
            )
        args = [self.found[i] for i in operands]
        if any(arg is None for arg in args):
            return None
        known = [arg for arg in args if arg is not None]
        if op == "sum":
            return _sum_of(known, constant)
        if op == "neg":
            return _times(known[0], Fraction(-1), False)
        if op == "*":
            for one, other in (known, known[::-1]):
                if set(one[0]) <= {""}:
                    return _times(other, one[0].get("", Fraction(0)), one[1])
        if op == "/" and set(known[1][0]) <= {""} and known[1][0].get("") and not known[1][1]:
            return _times(known[0], 1 / known[1][0][""], False)
        return None


def _sum_of(terms: Sequence[tuple[Angle, bool]], counts: Sequence[int]) -> tuple[Angle, bool] | None:
    if len({imaginary for _, imaginary in terms}) > 1:
        return None
    total: Angle = {}
    for (angle, _), count in zip(terms, counts, strict=True):
        for name, factor in angle.items():
            total[name] = total.get(name, Fraction(0)) + count * factor
            if _is_long(total[name]):
                return None
    return total, terms[0][1] if terms else False


def _times(angle: tuple[Angle, bool], factor: Fraction, imaginary: bool) -> tuple[Angle, bool] | None:
    sign = -1 if imaginary and angle[1] else 1
    product = {name: sign * factor * value for name, value in angle[0].items()}
    return None if any(map(_is_long, product.values())) else (product, imaginary != angle[1])


def _is_long(number: Fraction) -> bool:
    return max(number.numerator.bit_length(), number.denominator.bit_length()) > MOST_BITS
