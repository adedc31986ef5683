"""Tests of the questions of `questions.transforms`: products of 4 x 4 matrices, and velocities seen from the tool."""

from collections.abc import Callable, Iterator

import numpy as np

from qdot.exercises.problem.problem import Part
from qdot.exercises.verify.formulas import EXACT, each_way, formula
from qdot.exercises.verify.numeric_reference import Check, NumericReference


def _pose(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (numeric.told[:, -1], EXACT)}


def _tool(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    turn = numeric.told[:, -1, :3, :3].swapaxes(1, 2)

    def seen(jacobian: np.ndarray) -> np.ndarray:
        return np.concatenate([turn @ jacobian[:, :3], turn @ jacobian[:, 3:]], axis=1)

    return each_way(numeric, seen)


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "transform": formula(_pose),
    "tool-jacobian": formula(_tool),
}
