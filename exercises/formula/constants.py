"""Values of joints that are typed as numbers: held with 50 digits to conditions, not to within a tolerance."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np

from exercises.formula.angles import Angles
from exercises.formula.identity import SAME, allowed_for_decimals
from exercises.formula.program import compile_program, evaluate, evaluate_precisely
from exercises.formula.trees import Node, names

DIGITS = 50


def value_of(node: Node) -> Any:
    """Return the real value of a tree without symbols, as an mpmath number; None where it has symbols or none."""
    if names(node):
        return None
    value = evaluate_precisely(compile_program([node]), {}, DIGITS)[0]
    return mpmath.re(value) if mpmath.isfinite(value) and abs(mpmath.im(value)) < SAME else None


def same_value(one: Any, other: Any, angles: bool, room: float) -> bool:
    """Tell whether two values are the same, angles modulo whole turns, but for `room` of their size."""
    with mpmath.workdps(DIGITS):
        off = one - other
        if angles:
            off -= 2 * mpmath.pi * mpmath.nint(off / (2 * mpmath.pi))
        return bool(abs(off) <= max(room, SAME) * max(1, abs(other)))


def holds_at(zero: Node, at: Mapping[str, Any], symbols: Mapping[str, Any], room: float) -> bool:
    """Tell whether an expression vanishes at values of joints, for some values of the other symbols."""
    program = compile_program([zero])
    values = {**symbols, **at}
    misses = evaluate_precisely(program, values, DIGITS)[0]
    size = float(evaluate(program, {name: np.array([float(value)]) for name, value in values.items()}, 1)[1][0, 0])
    return bool(mpmath.isfinite(misses) and abs(misses) <= max(room, SAME) * max(size, 1e-300))


def room_of(nodes: Sequence[Node]) -> float:
    """Return what values may be off because of decimals that are doubles."""
    return max((allowed_for_decimals(node) for node in nodes), default=0.0)


def turns_of(node: Node) -> Fraction | None:
    """Return a rational multiple of pi as a part of pi, from 0 to less than 2; None for anything else.

    >>> turns_of(Node("neg", (Node("name", value="pi"),)))
    Fraction(1, 1)
    """
    program = compile_program([node])
    angle = Angles(program.steps).at(program.outputs[0])
    if angle is None or angle[1] or set(angle[0]) - {"pi", ""} or angle[0].get(""):
        return None
    return angle[0].get("pi", Fraction(0)) % 2
