"""Test the questions of `questions.statics`: the power at the joints is the power at the hand."""

from collections.abc import Callable, Iterator

import numpy as np

from qdot.exercises.problem.problem import Part
from qdot.exercises.verify.formulas import expect_by_each_route, formula_check
from qdot.exercises.verify.numeric_reference import Check, NumericReference


def _torques(numeric: NumericReference, part: Part) -> dict[str, tuple[np.ndarray, float]]:
    force = np.stack([numeric.values[name] for name in part.symbols], axis=1)

    def of_unit_rates(jacobian: np.ndarray) -> np.ndarray:
        """Return the power of the force for each joint's unit rate, which is that joint's torque."""
        return np.einsum("pij,pi->pj", jacobian[:, numeric.task], force)[:, :, None]

    return expect_by_each_route(numeric, of_unit_rates)


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {"joint-torques": formula_check(_torques)}
