"""Test the questions of `questions.wrist`: blocks of the Jacobian in numbers, and their determinants."""

from collections.abc import Callable, Iterator

import numpy as np

from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.problem.problem import Part
from qdot.exercises.verify.formulas import EXACT, agree, expect_by_each_route, formula_check
from qdot.exercises.verify.numeric_reference import Check, NumericReference


def _arm(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    return expect_by_each_route(numeric, lambda jacobian: jacobian[:, :3, :3])


def _wrist(numeric: NumericReference, _: Part) -> dict[str, tuple[np.ndarray, float]]:
    turn = numeric.convention_frames[:, convention_of(numeric.chain).frame_on_axis(4), :3, :3].swapaxes(1, 2)
    return expect_by_each_route(numeric, lambda jacobian: turn @ jacobian[:, 3:, 3:])


def _check_determinants(numeric: NumericReference, part: Part) -> Iterator[Check]:
    """Compare each determinant with its block, and their product with det J of all six rows."""
    claimed = numeric.read(part.answer.as_matrix())
    turn = numeric.frames[:, 3, :3, :3].swapaxes(1, 2)
    blocks = (numeric.jacobian[:, :3, :3], turn @ numeric.jacobian[:, 3:, 3:])
    expected = np.stack([np.linalg.det(block) for block in blocks], axis=1)[:, :, None]
    yield agree("LU decomposition", claimed, expected, EXACT)
    if claimed.shape == expected.shape:
        whole = np.linalg.det(numeric.task_jacobian)[:, None, None]
        yield agree("their product is det J", claimed.prod(axis=1, keepdims=True), whole, EXACT)
    beside = np.abs(numeric.jacobian[:, :3, 3:]).max()
    yield Check("the wrist does not move P", bool(beside < EXACT), f"largest entry beside J11: {beside:.1e}")


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "arm-block": formula_check(_arm),
    "wrist-block": formula_check(_wrist),
    "block-determinants": _check_determinants,
}
