"""Choose the pose in which an arm is drawn: lengths for the drawing, and candidate poses with a score.

Poses are given by the entries of the DH table (theta_i or d_i with the offset), because a figure shows these. If the
pose is given, the view is chosen instead: the usual view is rotated about the vertical axis, so that up stays up.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import ANGLE_PREFIXES, PRISMATIC, Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.errors import QdotError
from qdot.exercises.figure.plane import SPATIAL_VIEW, axonometric_view, choose_view, is_drawn_flat, numeric_lengths

DEFAULT_LENGTH = 0.4
"""Length in metres for a table without any number."""
WIDTH, HEIGHT = 520, 360
"""Size of a figure in pixels."""
MAX_ARM_SIZE = (380.0, 240.0)
"""Maximum size of the arm's skeleton in pixels; the rest of the figure is for axes and labels."""
MAX_POSES = 2000
"""Maximum number of poses that are compared; if there are more, they are sampled evenly."""
LONG_ARM_JOINTS = 4
"""An arm with more joints is a long arm."""
CROWDED_PENALTY, CROWDED_DISTANCE = 0.4, 34.0
"""Penalty for two labels at nearly the same position, and the distance in pixels below which it applies."""
CLEARANCE_WEIGHT = {False: 1.8, True: 4.0}
"""Maximum bonus for links that are apart, and penalty if two of them cross; higher for a long arm (True)."""


AZIMUTHS, ELEVATIONS = range(0, 360, 15), (24, 12, 40)
"""Angles from the usual view, and above the horizon, in degrees."""
CROWDED_DISTANCE_IN_VIEW, AXIS_LENGTH = 44.0, 54.0
"""Distance in pixels below which two origins, or ends of axes, are too close, and the length of an axis."""
VISIBLE_AXIS_SHARE = 0.45
"""The share of a z axis that should be visible."""
USUAL_VIEW_BONUS = 0.3
"""Bonus for the usual view, in which the arm's own figure is drawn."""


@dataclass(frozen=True)
class Skeleton:
    """The arm in a pose, world frame, metres: frames (n+1 x 4 x 4), corners (n x 3), table entries (n), path to P.

    Corner i-1 is O_{i-1} + d_i z_{i-1}, the point at which link i bends from z_{i-1} to x_i. `path` is from O_k to P.
    """

    frames: np.ndarray
    corners: np.ndarray
    entries: np.ndarray
    path: np.ndarray

    @property
    def origins(self) -> np.ndarray:
        """The origins O_0 ... O_n (n+1 x 3)."""
        return np.asarray(self.frames[:, :3, 3])


@lru_cache(maxsize=16)
def make_drawable_chain(chain: Chain, base_distance_factor: float = 1.0) -> Chain:
    """Return the arm with numeric lengths of similar size, so that the shortest is visible.

    `base_distance_factor` is a factor for the base's distance from the world's origin.
    """
    unit = _longest_length(chain)
    values = symbol_values(chain, unit)

    def length(value: sp.Expr, min_share: float = 0.36, max_share: float = 1.0) -> sp.Expr:
        if value == 0:
            return sp.S.Zero
        if not value.is_number:
            return sp.Float(float(value.xreplace(values)))
        # The size is limited, because a base may be far away.
        size = min_share + (max_share - min_share) * min(abs(float(value)) / unit, 1.3)
        return sp.Float((1 if value > 0 else -1) * unit * size)

    variables = {variable.name: variable for variable in chain.q}
    base_range = (0.55, 1.0) if chain.n <= LONG_ARM_JOINTS else (0.3, 0.5)  # a long arm needs more of the drawing

    def replace_entry(name: str, entry: sp.Expr) -> sp.Expr:
        if name in variables:
            return variables[name]
        if name.startswith(ANGLE_PREFIXES):
            return entry.xreplace(values)
        return base_distance_factor * length(entry, *base_range) if name.startswith("base") else length(entry)

    return chain.map_entries(replace_entry)


def symbol_values(chain: Chain, unit: float) -> dict[sp.Symbol, sp.Float]:
    """Return numbers for the symbolic constants of an arm whose longest numeric length is `unit`."""
    shares = itertools.chain((1.0, 0.85, 0.72, 0.62), itertools.repeat(0.55))
    values: dict[sp.Symbol, sp.Float] = {}

    def set_default(expression: sp.Expr, value: float) -> None:
        for symbol in sorted(expression.free_symbols - set(chain.q), key=lambda s: s.name):
            values.setdefault(symbol, sp.Float(value))

    for index, joint in enumerate(chain.joints):
        is_twisted = joint.alpha not in (0, sp.pi)  # then a is a lateral offset, usually the smaller length
        for expression, is_small in ((joint.d, False), (joint.a, is_twisted)):
            if expression.free_symbols - set(chain.q):
                set_default(expression, unit * (0.5 if is_small else next(shares)))
        set_default(joint.theta, 0.5)
        set_default(joint.alpha, 0.5 + 0.1 * index)
    for expressions, value in ((chain.point.offset, 0.45 * unit), (chain.base.position, 0.7 * unit)):
        for expression in expressions:
            set_default(expression, value)
    set_default(chain.base.yaw, 0.5)
    set_default(chain.base.tilt, 0.5)
    return values


def example_values(chain: Chain) -> dict[sp.Symbol, sp.Float]:
    """Return numbers for the symbolic lengths and angles of an arm (m, rad), similar to its numeric ones."""
    return symbol_values(chain, _longest_length(chain))


def _longest_length(chain: Chain) -> float:
    """Return the longest numeric length (m) of an arm, or a default if it has none."""
    offsets = [abs(float(value)) for value in chain.point.offset if value.is_number and value != 0]
    return max(numeric_lengths(chain) + offsets, default=DEFAULT_LENGTH)


def compute_table_entries(chain: Chain, pose: Mapping[str, float]) -> np.ndarray:
    """Return the table's entries (n) for joint values (rad, m), with default values for symbolic constants."""
    missing = [variable.name for variable in chain.q if variable.name not in pose]
    if missing:
        raise QdotError(f"{chain.name}: the pose has no {', '.join(missing)}; it needs {', '.join(map(str, chain.q))}")
    entries = []
    for joint, variable in zip(chain.joints, chain.q, strict=True):
        entry = joint.variable_entry.xreplace({variable: sp.Float(pose[variable.name])})
        entries.append(float(entry.xreplace(symbol_values(chain, DEFAULT_LENGTH))))
    return np.array(entries)


def list_candidate_poses(chain: Chain, drawn: Chain) -> np.ndarray:
    """Return a fixed list of poses (k x n): every combination of a few values, or an even selection of them."""
    unit = max(numeric_lengths(drawn), default=DEFAULT_LENGTH)
    # only positive angles: readers take the arrow of an arc for the positive direction
    angles_in_degrees = (40, 50, 33, 65, 115, 130) if is_drawn_flat(chain) else (40, 60, 30, 70, 115, 130, 145, 155)
    length_factors = (1.7, 2.0) if chain.is_planar else (1.3, 1.0, 1.7) if is_drawn_flat(chain) else (1.0, 0.75, 0.55)
    angles, extensions = np.radians(angles_in_degrees), unit * np.array(length_factors)
    choices = [angles if joint.is_revolute else extensions for joint in chain.joints]
    indices = _choose_value_indices(tuple(map(len, choices)))
    return np.stack([values[index] for values, index in zip(choices, indices, strict=True)], axis=1)


@lru_cache(maxsize=64)
def _choose_value_indices(sizes: tuple[int, ...]) -> np.ndarray:
    """Return the index of each joint's value (n x k): all combinations, or an even selection of `MAX_POSES` of them."""
    total = math.prod(sizes)
    step = 1 if total <= MAX_POSES else int(total * 0.6180339887) | 1
    index = np.arange(min(total, MAX_POSES)) * step % total
    digits = []
    for size in sizes:
        index, digit = np.divmod(index, size)
        digits.append(digit)
    return np.array(digits)


@lru_cache(maxsize=16)
def _numeric_chain(drawn: Chain) -> NumericChain:
    """Return the kinematics of an arm with numeric lengths; cached."""
    return NumericChain(drawn, {})


def compute_skeletons(drawn: Chain, entries: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frames (k x n+1 x 4 x 4), corners (k x n x 3) and paths to P (k x 4 x 3) for poses (k x n)."""
    numeric = _numeric_chain(drawn)
    frames = numeric.frames(entries)
    lengths = np.stack(
        [entries[:, i] if kind == PRISMATIC else np.full(len(entries), numeric.fixed[i][0])
         for i, kind in enumerate(numeric.kinds)], axis=1
    )  # fmt: skip
    corners = frames[:, :-1, :3, 3] + lengths[..., None] * frames[:, :-1, :3, 2]
    frame = frames[:, drawn.point.frame]
    path = [frame[:, :3, 3]]
    for axis, value in enumerate(drawn.point.offset):
        path.append(path[-1] + float(value) * frame[:, :3, axis])
    return frames, corners, np.stack(path, axis=1)


def compute_skeleton(drawn: Chain, entries: np.ndarray) -> Skeleton:
    """Return the skeleton of the arm in one pose, given by the table's entries (n)."""
    frames, corners, path = compute_skeletons(drawn, entries[None])
    return Skeleton(frames[0], corners[0], entries, path[0])


def best_poses(chain: Chain, drawn: Chain, count: int) -> np.ndarray:
    """Return the `count` candidate poses (count x n) whose bare skeletons are easiest to read, best first."""
    entries = list_candidate_poses(chain, drawn)
    order = np.argsort(-np.round(score_poses(chain, drawn, entries), 3), kind="stable")
    return np.asarray(entries[order[:count]])


def score_poses(chain: Chain, drawn: Chain, entries: np.ndarray) -> np.ndarray:
    """Return how easy the bare skeletons of poses (k x n) are to read (k); higher is better."""
    score, lines, scale = _score_without_clearance(chain, drawn, entries)
    gaps = find_clearance(lines, 2 if chain.n > LONG_ARM_JOINTS else 1) * scale / 70
    return np.asarray(score + CLEARANCE_WEIGHT[chain.n > LONG_ARM_JOINTS] * np.clip(gaps, -1, 1))


def _score_without_clearance(chain: Chain, drawn: Chain, entries: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the score of poses without clearance (k), the lines to keep apart (k x s x 2 x 2), and the scale (k)."""
    frames, corners, path = compute_skeletons(drawn, entries)
    view = choose_view(chain)
    pieces = list_segments(frames, corners, path, drawn.point.frame)
    drawn_segments = pieces @ view[:2].T
    scale = _fitting_scale(drawn_segments)
    lengths = np.linalg.norm(drawn_segments[:, :, 1] - drawn_segments[:, :, 0], axis=2) * scale[:, None]
    score = 1.5 * np.minimum(lengths.min(axis=1) / 85, 1)
    score = score + 0.3 * np.minimum(lengths.mean(axis=1) / 150, 1) + _score_angles(chain, frames, entries, view)
    up = frames[:, 0, :3, 1 if abs(view[2] @ frames[0, 0, :3, 2]) > 0.999 else 2]
    heights = np.einsum("kspx,kx->ksp", pieces - frames[:, 0, None, None, :3, 3], up).reshape(len(entries), -1)
    score = score + 3.0 * np.minimum(heights.min(axis=1) * scale / 40, 0).clip(-1)
    score = score + 0.4 * np.minimum((heights[:, -1] * scale) / 60, 1)
    if not is_drawn_flat(chain):
        z_axes = np.linalg.norm(frames[:, :, :3, 2] @ view[:2].T, axis=2)
        score = score + 0.8 * np.minimum(z_axes.min(axis=1) / 0.6, 1) + 0.9 * _score_axis_separation(frames, view)
        score = score - CROWDED_PENALTY * _count_crowded(frames, view, scale)
    ends = (frames[:, -1, :3, 3] - frames[:, 0, :3, 3]) @ view[:2].T
    score = score + 0.9 * np.minimum(np.linalg.norm(ends, axis=1) * scale / 260, 1)
    return np.asarray(score), _add_last_axes(drawn_segments, frames, view, scale), scale


def _fitting_scale(drawn_segments: np.ndarray) -> np.ndarray:
    """Return the scales (k) at which drawn segments (k x s x 2 x 2) take the maximum size, in pixels per metre."""
    spread = np.ptp(drawn_segments.reshape(len(drawn_segments), -1, 2), axis=1)
    return np.asarray(1.0 / np.maximum(np.max(spread / MAX_ARM_SIZE, axis=1), 1e-9))


def list_segments(frames: np.ndarray, corners: np.ndarray, path: np.ndarray, point_frame: int) -> np.ndarray:
    """Return the segments of all links with a length (k x s x 2 x 3), in the arm's order."""
    points = [frames[:, 0, :3, 3]]
    for i in range(corners.shape[1]):
        points += [corners[:, i], frames[:, i + 1, :3, 3]]
    if point_frame == corners.shape[1]:
        points += [path[:, k] for k in range(1, 4)]
    pairs = np.stack([np.stack(points[:-1], axis=1), np.stack(points[1:], axis=1)], axis=2)
    has_length = np.linalg.norm(pairs[:, :, 1] - pairs[:, :, 0], axis=2).max(axis=0) > 1e-6
    return pairs[:, has_length] if has_length.any() else pairs[:, :1]


def find_clearance(drawn_segments: np.ndarray, axis_count: int) -> np.ndarray:
    """Return the minimum distance of segments that are not adjacent (and of far ends of adjacent ones), per pose (k).

    It is -inf if two of them cross. The last `axis_count` segments are axes of the last frame, all adjacent to the last
    link.
    """
    shares = np.linspace(0.0, 1.0, 6)[:, None]
    points = drawn_segments[:, :, None, 0] * (1 - shares) + drawn_segments[:, :, None, 1] * shares
    distances, last_link = np.full(len(drawn_segments), np.inf), drawn_segments.shape[1] - axis_count - 1
    for i, j in itertools.combinations(range(drawn_segments.shape[1]), 2):
        is_adjacent = j == i + 1 or i >= last_link
        first, second = (points[:, i, :4], points[:, j, 2:]) if is_adjacent else (points[:, i], points[:, j])
        x, y = (first[:, :, None, k] - second[:, None, :, k] for k in range(2))
        gaps = np.sqrt((x * x + y * y).reshape(len(drawn_segments), -1).min(axis=1))
        distances = np.minimum(distances, gaps * (1.3 if is_adjacent else 1.0))
        if not is_adjacent:
            distances = np.where(_do_cross(drawn_segments[:, i], drawn_segments[:, j]), -np.inf, distances)
    return np.where(distances == np.inf, 1.0, distances)


def _do_cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return whether two segments (k x 2 x 2 each) cross in the drawing (k)."""

    def sides(line: np.ndarray, segment: np.ndarray) -> np.ndarray:
        direction, offsets = (line[:, 1] - line[:, 0])[:, None], segment - line[:, None, 0]
        cross_products = direction[..., 0] * offsets[..., 1] - direction[..., 1] * offsets[..., 0]
        return np.asarray(cross_products[:, 0] * cross_products[:, 1] < 0)

    return sides(first, second) & sides(second, first)


def _add_last_axes(drawn_segments: np.ndarray, frames: np.ndarray, view: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return drawn segments (k x s x 2 x 2) with the x axis of the last frame added.

    For a long arm, the z axis is added, too, because the arm's end may come near to its base.
    """
    start = frames[:, -1, :3, 3] @ view[:2].T
    lines = [drawn_segments]
    for axis in (0, 2) if frames.shape[1] > LONG_ARM_JOINTS + 1 else (0,):
        end = start + 50 / scale[:, None] * (frames[:, -1, :3, axis] @ view[:2].T)
        lines.append(np.stack([start, end], axis=1)[:, None])
    return np.concatenate(lines, axis=1)


def _score_angles(chain: Chain, frames: np.ndarray, entries: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Return a score for how clearly the joint angles are visible (k); angles near 45 degrees score highest."""
    lowest_visibility, preference = np.ones(len(entries)), np.zeros(len(entries))
    for i, joint in enumerate(chain.joints):
        if joint.is_prismatic:
            continue
        x, y = frames[:, i, :3, 0] @ view[:2].T, frames[:, i, :3, 1] @ view[:2].T
        end = x * np.cos(entries[:, i, None]) + y * np.sin(entries[:, i, None])
        drawn_angle = np.abs(np.arctan2(x[:, 0] * end[:, 1] - x[:, 1] * end[:, 0], (x * end).sum(axis=1)))
        visibility = np.minimum(np.minimum(drawn_angle, np.pi - drawn_angle + 0.3) / np.radians(35), 1)
        visibility = visibility * np.minimum(np.linalg.norm(end, axis=1) / 0.5, 1)
        lowest_visibility = np.minimum(lowest_visibility, visibility)
        if i > 0 or is_drawn_flat(chain):
            preference = preference + np.clip(1.4 - np.abs(entries[:, i] - 0.8), 0, 1) * 1.2 / chain.n
    return np.asarray(1.2 * lowest_visibility + preference)


def _count_crowded(frames: np.ndarray, view: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return a weighted count of origins and tips of axes (positions of labels) that are drawn close together (k).

    Pairs that coincide in every pose don't count.
    """
    axes = [frames[:, :, :3, 3] + 54 / scale[:, None, None] * frames[:, :, :3, k] for k in (0, 2)]
    points = np.concatenate([frames[:, :, :3, 3], *axes], axis=1)
    drawn_points = np.moveaxis(points @ view[:2].T, 0, 2) * scale
    total = np.zeros(len(frames))
    for i in range(points.shape[1] - 1):
        others = np.arange(i + 1, points.shape[1])
        candidates = others[np.abs(points[0, others] - points[0, i]).max(axis=1) <= 1e-6]
        coincident = candidates[np.abs(points[:, candidates] - points[:, [i]]).max(axis=(0, 2)) <= 1e-6]
        differences = drawn_points[np.setdiff1d(others, coincident)] - drawn_points[i]
        gaps = np.sqrt(differences[:, 0] * differences[:, 0] + differences[:, 1] * differences[:, 1])
        total += np.maximum(0.0, 1.0 - gaps / CROWDED_DISTANCE).sum(axis=0)
    return total


def _score_axis_separation(frames: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Return how well x and z axes with a common origin can be distinguished (k); 1 from 20 degrees on."""
    lowest_score = np.ones(len(frames))
    arrows = [(frames[:, i, :3, 3], frames[:, i, :3, k]) for i in range(frames.shape[1]) for k in (0, 2)]
    for (origin, first), (second_origin, second) in itertools.combinations(arrows, 2):
        if np.max(np.abs(origin - second_origin)) > 1e-6 or np.max(np.linalg.norm(first - second, axis=1)) < 1e-6:
            continue
        a, b = first @ view[:2].T, second @ view[:2].T
        drawn_angle = np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)))
        lowest_score = np.minimum(lowest_score, drawn_angle / np.radians(20))
    return lowest_score


# --- the view of an arm in a given pose ---


def best_views(drawn: Chain, entries: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the `count` best views (right, up, towards the reader; 3 x 3) of an arm with numeric lengths, best first.

    `entries` (n) are those of the table. Scores are rounded, so that ties are broken alike on every machine.
    """
    directions = itertools.product(ELEVATIONS, AZIMUTHS)
    views = np.array([axonometric_view(np.radians(36.0 + angle), np.radians(height)) for height, angle in directions])
    score = _score_views(drawn, entries, views)
    score[0] += USUAL_VIEW_BONUS
    order = np.argsort(-np.round(score, 3), kind="stable")[:count]
    return [SPATIAL_VIEW if k == 0 else views[k] for k in order]


def _score_views(drawn: Chain, entries: np.ndarray, views: np.ndarray) -> np.ndarray:
    """Return how clearly views (k x 3 x 3) show the links, the origins and the z axes of an arm."""
    frames, corners, path = compute_skeletons(drawn, entries[None])
    pieces = list_segments(frames, corners, path, drawn.point.frame)[0]
    drawn_segments = np.einsum("spx,kyx->kspy", pieces, views[:, :2])
    scale = _fitting_scale(drawn_segments)
    origins, z = frames[0, :, :3, 3], frames[0, :, :3, 2]
    drawn_origins = scale[:, None, None] * np.einsum("ix,kyx->kiy", origins, views[:, :2])
    drawn_axes = np.einsum("ix,kyx->kiy", z, views[:, :2])
    ends = np.stack(
        [origins[-1], origins[-1] + 1e-6 * z[-1]]
    )  # `find_clearance` needs an axis; this one is too short to matter
    last_axis = np.broadcast_to(np.einsum("px,kyx->kpy", ends, views[:, :2])[:, None], (len(views), 1, 2, 2))
    clearances = np.clip(find_clearance(np.concatenate([drawn_segments, last_axis], axis=1), 1) * scale / 50, 0, 1)
    visible_shares = np.minimum(np.linalg.norm(drawn_axes, axis=2) / VISIBLE_AXIS_SHARE, 1)
    is_hidden = np.round(views[:, 2] @ z[0], 6) < 0  # the wall that carries the arm hides it
    crowded_count = _count_crowded_in_views(origins, z, drawn_origins, drawn_axes)
    return np.asarray(2.0 * clearances + 0.6 * (visible_shares - 1).sum(axis=1) - crowded_count - is_hidden)


def _count_crowded_in_views(
    origins: np.ndarray, z: np.ndarray, drawn_origins: np.ndarray, drawn_axes: np.ndarray
) -> np.ndarray:
    """Return a weighted count of pairs of origins and ends of z axes that are drawn close together (k).

    The arguments are both in the world (n+1 x 3) and in the drawing (k x n+1 x 2). Coincident points don't count.
    """
    points = np.concatenate([origins, origins + 0.37 * z])
    drawn_points = np.concatenate([drawn_origins, drawn_origins + AXIS_LENGTH * drawn_axes], axis=1)
    count = len(origins)
    total = np.zeros(len(drawn_origins))
    for i, j in itertools.combinations(range(len(points)), 2):
        if np.linalg.norm(points[i] - points[j]) > 1e-6:
            gaps = np.linalg.norm(drawn_points[:, i] - drawn_points[:, j], axis=1)
            total += np.maximum(0.0, 1.0 - gaps / CROWDED_DISTANCE_IN_VIEW) * (4.0 if j < count else 1.0)
    return total
