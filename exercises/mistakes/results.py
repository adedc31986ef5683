"""How the answer to each question follows from a derivation, so that what goes wrong there shows in the answer."""

from collections.abc import Callable
from typing import Any

import numpy as np

from exercises.arm.chain import TASK_ROWS
from exercises.mistakes.arithmetic import applied, determinant, product
from exercises.mistakes.base import RESULT
from exercises.mistakes.working import Working
from exercises.problem import Part


def _moving_rows(w: Working) -> list[int]:
    return ["xyz".index(axis) for axis in w.chain.linear_rows]


def _velocity(w: Working) -> np.ndarray:
    return applied(w["linear"][_moving_rows(w)], w["joint rates"])


def _component(w: Working, part: Part) -> np.ndarray:
    row = part.details["row"]
    assert isinstance(row, int)
    return np.asarray(applied(w["linear"][[row]], w["joint rates"]))


def _link_velocity(w: Working, part: Part) -> np.ndarray:
    frame = part.details["frame"]
    assert isinstance(frame, int)
    return applied(w.up_to(frame)["geometric"], w["joint rates"][:frame])


def _seen_from_tool(w: Working) -> np.ndarray:
    turned = w.arithmetic.value(w["rotations"][-1]).swapaxes(0, 1)
    return np.concatenate([product(turned, w["geometric"][:3]), product(turned, w["geometric"][3:])])


def _transform(w: Working) -> np.ndarray:
    rotation, origin = w.arithmetic.value(w["rotations"][-1]), w["origins"][-1]
    below = np.stack([0 * origin[0], 0 * origin[0], 0 * origin[0], 0 * origin[0] + 1])
    return np.concatenate([np.concatenate([rotation, origin[:, None]], axis=1), below[None]])


def _wrist_block(w: Working) -> np.ndarray:
    turned = w.arithmetic.value(w["rotations"][3]).swapaxes(0, 1)
    return np.stack([applied(turned, w["axes"][i]) for i in (3, 4, 5)], axis=1)


def _block_determinants(w: Working) -> np.ndarray:
    return np.stack([determinant(w["geometric"][:3, :3]), determinant(_wrist_block(w))])


def _torques(w: Working, part: Part) -> np.ndarray:
    return applied(w["transposed jacobian"], w.symbols(part.symbols))


def _effect(w: Working, part: Part) -> np.ndarray:
    effect: Any = part.details["effect"]
    return np.asarray(w["geometric"][[TASK_ROWS.index(row) for row in effect.rows], effect.joint - 1])


RESULTS: dict[str, Callable[[Working, Part], np.ndarray]] = {
    "transform": lambda w, _: _transform(w),
    "position": lambda w, _: w["point"][_moving_rows(w)],
    "velocity": lambda w, _: _velocity(w),
    "velocity-component": _component,
    "jacobian": lambda w, _: w["jacobian"],
    "joint-axes": lambda w, _: w["axes"][: w.n].swapaxes(0, 1),
    "position-vectors": lambda w, _: w["arms"][: w.n].swapaxes(0, 1),
    "geometric-jacobian": lambda w, _: w["geometric"],
    "twist": lambda w, _: applied(w["geometric"], w["joint rates"]),
    "link-velocity": _link_velocity,
    "tool-jacobian": lambda w, _: _seen_from_tool(w),
    "arm-block": lambda w, _: w["geometric"][:3, :3],
    "wrist-block": lambda w, _: _wrist_block(w),
    "block-determinants": lambda w, _: _block_determinants(w),
    "determinant": lambda w, _: w["determinant"][None],
    "gram-determinant": lambda w, _: w["gram determinant"][None],
    "inverse-jacobian": lambda w, _: w["inverse"],
    "inverse-velocity": lambda w, _: w["rates"],
    "joint-torques": _torques,
    "self-motion": lambda w, _: w["self-motion"],
    "lost-direction": lambda w, _: w["lost direction"],
    "joint-effect": _effect,
    "joint-rates": lambda w, _: w["rates"],
    "path-rates": lambda w, _: w["rates"],
    "least-norm-rates": lambda w, _: applied(w["pseudo-inverse"], w["wanted velocity"]),
    "manipulability": lambda w, _: w["manipulability"][None],
    "condition-number": lambda w, _: w["condition number"][None],
}
"""The questions whose answers come out of a derivation. A vector has one axis before the arithmetic's, a matrix two."""


def result(w: Working, part: Part) -> np.ndarray:
    """Return the answer to a part as it comes out of a working, (rows, columns, …), mistakes in writing it included."""
    found = RESULTS[part.kind](w, part)
    found = found[:, None] if found.ndim == 2 else found
    for stage, change in w.changes:
        if stage == RESULT:
            found = change(w, found)
    return found
