"""Test manipulability and condition number: by the singular values of J, from frames and from exponentials."""

from collections.abc import Callable, Iterator

import numpy as np

from qdot.exercises.answers import Number
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.inversion import InSituation
from qdot.exercises.verify.exponentials import exponential_jacobian
from qdot.exercises.verify.formulas import EXACT, agree
from qdot.exercises.verify.numeric_reference import Check, NumericReference
from qdot.exercises.verify.redundancy import (
    NUMBERS,
    check_conditioning,
    check_three_digits,
    jacobian_at,
    reference_numbers,
)


def _measure_check(measure: Callable[[np.ndarray], float]) -> Callable[[NumericReference, Part], Iterator[Check]]:
    """Return the check that a number is `measure` of the task Jacobian, which is computed in two ways."""

    def check(numeric: NumericReference, part: Part) -> Iterator[Check]:
        situation = part.about(InSituation).situation
        jacobian = jacobian_at(numeric, situation)
        arm = NumericChain(numeric.chain, {symbol.name: float(value) for symbol, value in situation.lengths.items()})
        q = np.array([float(situation.joints[symbol]) for symbol in numeric.chain.q])
        by_exponentials = exponential_jacobian(arm, q)[numeric.task]
        for name, rows in (("singular values", jacobian), ("product of exponentials", by_exponentials)):
            yield agree(name, reference_numbers(part), np.full((1, 1, 1), measure(rows)), NUMBERS)
        yield check_conditioning(numeric, jacobian)
        yield check_three_digits(part, np.array([measure(jacobian)]))
        if part.kind == "manipulability":
            yield _check_unit(part, arm, q, numeric)

    return check


def _check_unit(part: Part, arm: NumericChain, q: np.ndarray, numeric: NumericReference) -> Check:
    """Measure the same arm in half metres: w grows by 2^k if its unit is m^k."""
    answer = part.of(Number)
    scale = np.ones((len(numeric.task), 1))
    scale[[row < 3 for row in numeric.task]] = 2.0
    columns = np.array([1.0 if kind == "R" else 0.5 for kind in arm.kinds])
    jacobian = arm.jacobian(q)[numeric.task]
    grown = _volume(jacobian * scale * columns) / _volume(jacobian)
    power = round(float(np.log2(grown)))
    unit = {0: "", 1: "m"}.get(power, f"m^{power}")
    exact = abs(grown - 2.0**power) < EXACT * grown
    return Check("unit", bool(exact and answer.units == (unit,)), f"{unit or 'a plain number'}")


def _volume(jacobian: np.ndarray) -> float:
    return float(np.prod(np.linalg.svd(jacobian, compute_uv=False)))


def _ratio(jacobian: np.ndarray) -> float:
    return float(np.linalg.cond(jacobian))


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "manipulability": _measure_check(_volume),
    "condition-number": _measure_check(_ratio),
}
