"""Tests of the questions of `questions.transforms`: products of 4 x 4 matrices, and velocities seen from the tool."""

from collections.abc import Callable, Iterator

import numpy as np

from exercises.problem import Part
from exercises.verify.formulas import EXACT, each_way, formula
from exercises.verify.ground import Check, Ground


def _pose(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return {"frames": (ground.frames[:, -1], EXACT)}


def _tool(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    turn = ground.frames[:, -1, :3, :3].swapaxes(1, 2)

    def seen(jacobian: np.ndarray) -> np.ndarray:
        return np.concatenate([turn @ jacobian[:, :3], turn @ jacobian[:, 3:]], axis=1)

    return each_way(ground, seen)


CHECKS: dict[str, Callable[[Ground, Part], Iterator[Check]]] = {
    "transform": formula(_pose),
    "tool-jacobian": formula(_tool),
}
