"""Values of joints that are typed as numbers, held with 50 digits to conditions: to a double's digits, not to a few."""

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np

from qdot.exercises.formula.angles import find_angles
from qdot.exercises.formula.identity import FLOATS, SAME
from qdot.exercises.formula.program import compile_program, evaluate, evaluate_precisely
from qdot.exercises.formula.trees import Node, names

DIGITS = 50


def value_of(node: Node) -> Any:
    """Return the real value of a tree without symbols, as an mpmath number; None where it has symbols or none."""
    if names(node):
        return None
    value = evaluate_precisely(compile_program([node]), {}, DIGITS)[0]
    return mpmath.re(value) if mpmath.isfinite(value) and abs(mpmath.im(value)) < SAME else None


def same_value(value: Any, expected: Any, angles: bool) -> bool:
    """Tell whether two values are the same, angles modulo whole turns: to the digits that programs print of doubles."""
    with mpmath.workdps(DIGITS):
        off = value - expected
        if angles:
            off -= 2 * mpmath.pi * mpmath.nint(off / (2 * mpmath.pi))
        return bool(abs(off) <= FLOATS * max(1, abs(expected)))


def holds_at(zero: Node, at: Mapping[str, Any], symbols: Mapping[str, Any]) -> bool:
    """Tell whether an expression vanishes at values of joints, for some values of the other symbols."""
    program = compile_program([zero])
    values = {**symbols, **at}
    misses = evaluate_precisely(program, values, DIGITS)[0]
    size = float(evaluate(program, {name: np.array([float(value)]) for name, value in values.items()}, 1)[1][0, 0])
    return bool(mpmath.isfinite(misses) and abs(misses) <= FLOATS * max(size, 1e-300))


def turns_of(node: Node) -> Fraction | None:
    """Return a rational multiple of pi as a part of pi, from 0 to less than 2; None for anything else.

    >>> turns_of(Node("neg", (Node("name", value="pi"),)))
    Fraction(1, 1)
    """
    program = compile_program([node])
    angle = find_angles(program.steps)[program.outputs[0]]
    if angle is None or angle[1] or set(angle[0]) - {"pi", ""} or angle[0].get(""):
        return None
    return angle[0].get("pi", Fraction(0)) % 2
