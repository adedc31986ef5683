"""Tests of the questions of `questions.screws`: the axes as they are told, and exponentials of these in numbers.

Nothing here knows of the table: each joint is the axis that the statement tells, in the world frame at home, and the
arm is the product of the joints' exponentials.
"""

from collections.abc import Callable, Iterator

import numpy as np
import sympy as sp

from exercises.arm.conventions import axes_of
from exercises.problem import Part
from exercises.verify.formulas import DIFFERENCED, EXACT, agree, formula
from exercises.verify.numeric_reference import POSES, Check, NumericReference

Values = dict[str, tuple[np.ndarray, float]]


def _hat(vector: np.ndarray) -> np.ndarray:
    """Return the matrix [v] with [v] u = v x u, (…, 3, 3)."""
    zero = 0 * vector[..., 0]
    x, y, z = (vector[..., k] for k in range(3))
    return np.stack([np.stack([zero, -z, y], -1), np.stack([z, zero, -x], -1), np.stack([-y, x, zero], -1)], -2)


def _adjoint(pose: np.ndarray) -> np.ndarray:
    """Return [Ad T] of poses (…, 4, 4) for twists (omega, v), (…, 6, 6)."""
    turn, zero = pose[..., :3, :3], np.zeros_like(pose[..., :3, :3])
    moved = _hat(pose[..., :3, 3]) @ turn
    return np.concatenate([np.concatenate([turn, zero], -1), np.concatenate([moved, turn], -1)], -2)


def _exponential(screw: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return e^([S] theta) as 4 x 4 matrices, by the series' closed form, for screws (…, 6) and values (…)."""
    spin, slide = screw[..., :3], screw[..., 3:]
    hat, by = _hat(spin), value[..., None, None]
    turning = (np.linalg.norm(spin, axis=-1) > 0.5)[..., None, None]
    one = np.broadcast_to(np.eye(3), hat.shape)
    turn = one + np.sin(by) * hat + (1 - np.cos(by)) * hat @ hat
    along = np.where(turning, by * one + (1 - np.cos(by)) * hat + (by - np.sin(by)) * hat @ hat, by * one)
    pose = np.zeros((*hat.shape[:-2], 4, 4))
    pose[..., :3, :3], pose[..., 3, 3] = turn, 1.0
    pose[..., :3, 3] = (along @ slide[..., None])[..., 0]
    return pose


def _placed(pose: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return where poses (…, 4, 4) take places (…, 3)."""
    return (pose[..., :3, :3] @ place[..., None])[..., 0] + pose[..., :3, 3]


class _Axes:
    """The arm by its axes in numbers, at the places of a reference: home screws (…, n, 6), poses, space Jacobian.

    `point` (…, 3) is the point of interest, which the joints before it carry.
    """

    def __init__(self, numeric: NumericReference) -> None:
        axes, point = axes_of(numeric.chain)
        self.q = np.stack([numeric.values[q.name] for q in numeric.chain.q], axis=1)
        self.home = np.stack([self._screw(numeric, axis.kind, axis.direction, axis.point) for axis in axes], axis=1)
        place = self._numbers(numeric, point)
        before, carried = np.broadcast_to(np.eye(4), (len(self.q), 4, 4)), []
        self.point = place
        for i in range(numeric.chain.n):
            carried.append((_adjoint(before) @ self.home[:, i, :, None])[..., 0])
            before = before @ _exponential(self.home[:, i], self.q[:, i])
            if i + 1 == numeric.chain.point.frame:
                self.point = _placed(before, place)
        self.space = np.stack(carried, axis=2)
        home = np.broadcast_to(np.eye(4), before.shape).copy()
        home[:, :3, 3] = place
        self.pose = before @ home
        self.body = _adjoint(np.linalg.inv(self.pose)) @ self.space

    def _screw(self, numeric: NumericReference, kind: str, direction: sp.Matrix, point: sp.Matrix) -> np.ndarray:
        u, o = self._numbers(numeric, direction), self._numbers(numeric, point)
        return np.concatenate([u, np.cross(o, u)] if kind == "R" else [0 * u, u], axis=1)

    @staticmethod
    def _numbers(numeric: NumericReference, vector: sp.Matrix) -> np.ndarray:
        rows = []
        for lengths in numeric.lengths:
            known = {sp.Symbol(name): value for name, value in lengths.items()}
            rows += [[float(entry.xreplace(known)) for entry in vector]] * POSES
        return np.array(rows)


def told(numeric: NumericReference) -> Iterator[Check]:
    """Look whether the axes that are told lead to the point, and move it, as the table does that is worked with."""
    axes = _Axes(numeric)
    yield agree("axes at home: point", axes.point[:, None], numeric.point[:, None], EXACT)
    before = numeric.chain.point.frame
    spin, slide = (axes.space[:, rows, :before].swapaxes(1, 2) for rows in (slice(0, 3), slice(3, 6)))
    moved = np.cross(spin, axes.point[:, None]) + slide
    yield agree("axes at home: velocities", moved, numeric.jacobian[:, :3, :before].swapaxes(1, 2), EXACT)


def _home(numeric: NumericReference, _: Part) -> Values:
    return {"axes at home": (_Axes(numeric).home.swapaxes(1, 2), EXACT)}


def _pose(numeric: NumericReference, _: Part) -> Values:
    return {"product of exponentials": (_Axes(numeric).pose, EXACT)}


def _space_jacobian(numeric: NumericReference) -> Values:
    """By exponentials, and from the velocities of the last frame, which are differences."""
    last = numeric.carried[:, :, numeric.chain.n]
    spin, velocity = last[..., 3:], last[..., :3]
    at_origin = velocity - np.cross(spin, numeric.frames[:, None, -1, :3, 3])
    differenced = np.concatenate([spin, at_origin], axis=2).swapaxes(1, 2)
    return {
        "product of exponentials": (_Axes(numeric).space, EXACT),
        "finite differences": (differenced, DIFFERENCED),
    }


def _body_jacobian(numeric: NumericReference) -> Values:
    """By exponentials, and from the geometric Jacobian, turned into the frame that is the world's at home."""
    by_frames = np.concatenate([numeric.jacobian[:, 3:], numeric.jacobian[:, :3]], axis=1)
    turn = _Axes(numeric).pose[:, :3, :3].swapaxes(1, 2)
    turned = np.concatenate([turn @ by_frames[:, :3], turn @ by_frames[:, 3:]], axis=1)
    return {"product of exponentials": (_Axes(numeric).body, EXACT), "frames": (turned, EXACT)}


def _times_rates(due: Callable[[NumericReference], Values]) -> Callable[[NumericReference, Part], Values]:
    def twist(numeric: NumericReference, _: Part) -> Values:
        return {name: (jacobian @ numeric.rates, allowed) for name, (jacobian, allowed) in due(numeric).items()}

    return twist


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    "home-screws": formula(_home),
    "body-pose": formula(_pose),
    "space-jacobian": formula(lambda numeric, _: _space_jacobian(numeric)),
    "body-jacobian": formula(lambda numeric, _: _body_jacobian(numeric)),
    "space-twist": formula(_times_rates(_space_jacobian)),
    "body-twist": formula(_times_rates(_body_jacobian)),
}
