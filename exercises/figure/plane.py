"""Choose the view of an arm: perpendicular to the plane in which it moves, or oblique from above if there is none."""

from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain


def compute_view(azimuth: float, elevation: float) -> np.ndarray:
    """Return the directions right, up and towards the reader (rows) for a reader's azimuth and elevation (rad)."""
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


SPATIAL_VIEW = compute_view(np.radians(36.0), np.radians(24.0))
"""The usual view of a spatial arm."""
VIEWS = {
    "z": np.eye(3),
    "x": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
    "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
    None: SPATIAL_VIEW,
}
"""Maps the world axis perpendicular to the drawing of a planar arm, or None for a spatial arm, to the usual view."""
VIEW_DESCRIPTIONS = {
    "z": "in the plane of x_w and y_w, seen from +z_w",
    "x": "in the plane of y_w and z_w, seen from +x_w",
    "y": "in the plane of x_w and z_w, seen from -y_w",
}
"""Maps the world axis perpendicular to the drawing of a planar arm to a description of the view."""


def make_numbers_exact(chain: Chain) -> Chain:
    """Return the same arm with Python numbers in its base and point converted to SymPy numbers."""
    return chain.map_entries(lambda _, entry: sp.sympify(entry))


def scale_prismatic_entries(chain: Chain, entries: np.ndarray, factor: float) -> np.ndarray:
    """Return table entries of joints (… x n) with the entries of prismatic joints multiplied by a factor."""
    return np.where([joint.is_prismatic for joint in chain.joints], entries * factor, entries)


def list_numeric_lengths(chain: Chain) -> list[float]:
    """Return the absolute values of the nonzero numeric lengths a and d in the table (m)."""
    return [abs(float(v)) for joint in chain.joints for v in (joint.a, joint.d) if v.is_number and v != 0]


def choose_view(chain: Chain) -> np.ndarray:
    """Return the usual view of an arm: the directions right, up and towards the reader (rows) in the world frame."""
    return VIEWS[find_normal_axis(chain)]


def is_drawn_flat(chain: Chain) -> bool:
    """Return whether the arm is drawn flat, because it never leaves a plane of two axes of the world."""
    return find_normal_axis(chain) is not None


@lru_cache(maxsize=256)
def find_normal_axis(chain: Chain) -> str | None:
    """Return the world axis ("x", "y" or "z") that is perpendicular to all motions of the arm, or None.

    The motions are tested at two arbitrary configurations.
    """
    if chain.is_planar:
        return "z"
    exact_chain = make_numbers_exact(chain)
    lengths = {symbol.name: 0.3 + 0.11 * k for k, symbol in enumerate(exact_chain.parameters)}
    arm = NumericChain(exact_chain, lengths)
    configurations = np.array([[0.37 + 0.21 * i for i in range(chain.n)], [1.13 - 0.47 * i for i in range(chain.n)]])
    frames = arm.compute_frames(configurations)
    points = np.concatenate([frames[..., :3, 3], arm.compute_point_of(frames)[:, None]], axis=1).reshape(-1, 3)
    axes, is_revolute = frames[:, :-1, :3, 2], arm.is_revolute
    for k, name in ((2, "z"), (1, "y"), (0, "x")):
        axis_components = np.abs(axes[..., k])
        is_perpendicular = np.all(np.abs(axis_components - is_revolute) < 1e-9) and np.all(np.abs(points[:, k]) < 1e-9)
        if is_perpendicular and is_revolute.any() and (name == "z" or chain.base.yaw == 0):
            return name
    return None
