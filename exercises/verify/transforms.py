"""Test the questions of `questions.transforms`: products of 4 x 4 matrices, and velocities in the tool frame."""

from collections.abc import Callable, Iterator

import numpy as np

from qdot.exercises.problem.problem import Part
from qdot.exercises.verify.formulas import EXACT, expect_by_each_route, formula_check
from qdot.exercises.verify.numeric_reference import Check, NumericReference


def _pose(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (numeric.convention_frames[:, -1], EXACT)}


def _tool(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    turn = numeric.convention_frames[:, -1, :3, :3].swapaxes(1, 2)

    def seen(jacobian: np.ndarray) -> np.ndarray:
        return np.concatenate([turn @ jacobian[:, :3], turn @ jacobian[:, 3:]], axis=1)

    return expect_by_each_route(numeric, seen)


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "transform": formula_check(_pose),
    "tool-jacobian": formula_check(_tool),
}
