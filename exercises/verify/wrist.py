"""Tests of the questions of `questions.wrist`: blocks cut out of the Jacobian in numbers, and their determinants."""

from collections.abc import Callable, Iterator

import numpy as np

from exercises.problem import Part
from exercises.verify.formulas import EXACT, agree, each_way, formula
from exercises.verify.ground import Check, Ground


def _arm(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return each_way(ground, lambda jacobian: jacobian[:, :3, :3])


def _wrist(ground: Ground, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    turn = ground.frames[:, 3, :3, :3].swapaxes(1, 2)
    return each_way(ground, lambda jacobian: turn @ jacobian[:, 3:, 3:])


def _determinants(ground: Ground, part: Part) -> Iterator[Check]:
    """Hold each determinant against its block, and their product against det J of all six rows."""
    found = ground.read(part.answer.as_matrix())
    turn = ground.frames[:, 3, :3, :3].swapaxes(1, 2)
    blocks = (ground.jacobian[:, :3, :3], turn @ ground.jacobian[:, 3:, 3:])
    expected = np.stack([np.linalg.det(block) for block in blocks], axis=1)[:, :, None]
    yield agree("LU decomposition", found, expected, EXACT)
    if found.shape == expected.shape:
        whole = np.linalg.det(ground.task_jacobian)[:, None, None]
        yield agree("their product is det J", found.prod(axis=1, keepdims=True), whole, EXACT)
    beside = np.abs(ground.jacobian[:, :3, 3:]).max()
    yield Check("the wrist does not move P", bool(beside < EXACT), f"largest entry beside J11: {beside:.1e}")


CHECKS: dict[str, Callable[[Ground, Part], Iterator[Check]]] = {
    "arm-block": formula(_arm),
    "wrist-block": formula(_wrist),
    "block-determinants": _determinants,
}
