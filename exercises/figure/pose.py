"""Choose the lengths of an arm in its drawing, and the pose that is easiest to read.

A pose is given by the table entries of the joints, theta_i or d_i with the offset, because a figure shows these
entries. The candidate poses of an arm get a score. If a pose is given, the view is chosen instead: the usual view is
rotated about the vertical axis, so that the drawing stays upright. `drawn_chain` is the arm with the lengths for the
drawing. In shapes of arrays, k is the number of poses or views. The weights of scores, and the sizes in pixels that
earn a full score, were chosen by looking at many figures.
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
from qdot.exercises.figure.plane import SPATIAL_VIEW, choose_view, compute_view, is_drawn_flat, list_numeric_lengths

DEFAULT_LENGTH = 0.4
"""Longest length in metres of an arm whose table has no numeric lengths."""
WIDTH, HEIGHT = 520, 360
"""Size of a figure in pixels."""
MAX_ARM_SIZE = (380.0, 240.0)
"""Maximum size of the arm's skeleton in pixels; the rest of the figure is for axes and labels."""
MAX_POSES = 2000
"""Maximum number of poses that are compared; if there are more poses, they are sampled evenly."""
LONG_ARM_JOINTS = 4
"""An arm with more joints is a long arm."""
CROWDED_PENALTY, CROWDED_DISTANCE = 0.4, 34.0
"""Penalty for two labels that are too close, and the distance in pixels below which this penalty applies."""
CLEARANCE_WEIGHT = {False: 1.8, True: 4.0}
"""Maximum bonus for the clearance between links, and penalty for two links that cross; True is for a long arm."""

AZIMUTHS, ELEVATIONS = range(0, 360, 15), (24, 12, 40)
"""The angles of views in degrees: from the usual view about the vertical axis, and above the horizon."""
CROWDED_DISTANCE_IN_VIEW, AXIS_LENGTH = 44.0, 54.0
"""Distance in pixels below which two origins or ends of axes are too close, and length of an axis in pixels."""
VISIBLE_AXIS_SHARE = 0.45
"""The fraction of a z axis's length that should be visible."""
USUAL_VIEW_BONUS = 0.3
"""Bonus for the usual view, in which the arm is drawn when no pose is given."""


@dataclass(frozen=True)
class Skeleton:
    """The arm in a pose, in the world frame and in metres.

    `frames` are the link frames (n+1 x 4 x 4), and `entries` are the table entries of the joints (n). Corner i-1 (of
    n x 3) is O_{i-1} + d_i z_{i-1}, at which link i bends from z_{i-1} to x_i. `path` (4 x 3) leads from the origin of
    P's frame to P, along one axis of this frame after another.
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
    """Return the arm without offsets and with numeric lengths of similar size, so that the shortest length is visible.

    The distance of the base from the world's origin is multiplied by `base_distance_factor`.
    """
    unit = _find_longest_length(chain)
    values = choose_symbol_values(chain, unit)

    def map_length(value: sp.Expr, min_share: float = 0.36, max_share: float = 1.0) -> sp.Expr:
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
        return base_distance_factor * map_length(entry, *base_range) if name.startswith("base") else map_length(entry)

    return chain.map_entries(replace_entry)


def choose_symbol_values(chain: Chain, unit: float) -> dict[sp.Symbol, sp.Float]:
    """Return numbers for the symbolic constants of an arm whose longest numeric length is `unit` (m)."""
    shares = itertools.chain((1.0, 0.85, 0.72, 0.62), itertools.repeat(0.55))
    values: dict[sp.Symbol, sp.Float] = {}

    def set_default(expression: sp.Expr, value: float) -> None:
        for symbol in sorted(expression.free_symbols - set(chain.q), key=lambda s: s.name):
            values.setdefault(symbol, sp.Float(value))

    for index, joint in enumerate(chain.joints):
        is_twisted = joint.alpha not in (0, sp.pi)  # if so, a is a lateral offset, usually the smaller length
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


def choose_example_values(chain: Chain) -> dict[sp.Symbol, sp.Float]:
    """Return numbers for the symbolic lengths (m) and angles (rad) of an arm, similar to its numeric lengths."""
    return choose_symbol_values(chain, _find_longest_length(chain))


def _find_longest_length(chain: Chain) -> float:
    """Return the longest numeric length (m) of an arm, or a default if it has none."""
    offsets = [abs(float(value)) for value in chain.point.offset if value.is_number and value != 0]
    return max(list_numeric_lengths(chain) + offsets, default=DEFAULT_LENGTH)


def compute_table_entries(chain: Chain, pose: Mapping[str, float]) -> np.ndarray:
    """Return the table entries of the joints (n) for joint values (rad, m); symbolic constants get default values."""
    if missing_names := ", ".join(variable.name for variable in chain.q if variable.name not in pose):
        raise QdotError(f"{chain.name}: the pose has no {missing_names}; it needs {', '.join(map(str, chain.q))}")
    entries = []
    for joint, variable in zip(chain.joints, chain.q, strict=True):
        entry = joint.variable_entry.xreplace({variable: sp.Float(pose[variable.name])})
        entries.append(float(entry.xreplace(choose_symbol_values(chain, DEFAULT_LENGTH))))
    return np.array(entries)


def list_candidate_poses(chain: Chain, drawn_chain: Chain) -> np.ndarray:
    """Return a fixed list of poses (k x n): all combinations of a few values, or an even selection of combinations."""
    unit = max(list_numeric_lengths(drawn_chain), default=DEFAULT_LENGTH)
    # The angles are positive, because readers take the arrow of an arc for the positive direction.
    angles_in_degrees = (40, 50, 33, 65, 115, 130) if is_drawn_flat(chain) else (40, 60, 30, 70, 115, 130, 145, 155)
    length_factors = (1.7, 2.0) if chain.is_planar else (1.3, 1.0, 1.7) if is_drawn_flat(chain) else (1.0, 0.75, 0.55)
    # extensions of prismatic joints are multiples of the longest length
    angles, extensions = np.radians(angles_in_degrees), unit * np.array(length_factors)
    choices = [angles if joint.is_revolute else extensions for joint in chain.joints]
    indices = _choose_value_indices(tuple(map(len, choices)))
    return np.stack([values[index] for values, index in zip(choices, indices, strict=True)], axis=1)


@lru_cache(maxsize=64)
def _choose_value_indices(sizes: tuple[int, ...]) -> np.ndarray:
    """Return the index of each joint's value (n x k): all combinations, or an even selection of `MAX_POSES` of them."""
    total = math.prod(sizes)
    step = 1 if total <= MAX_POSES else int(total * 0.6180339887) | 1  # the golden ratio spreads the selection evenly
    return np.array(np.unravel_index(np.arange(min(total, MAX_POSES)) * step % total, sizes, order="F"))


@lru_cache(maxsize=16)
def _make_numeric_chain(drawn_chain: Chain) -> NumericChain:
    """Return the numeric kinematics of an arm with numeric lengths; cached."""
    return NumericChain(drawn_chain, {})


def compute_skeletons(drawn_chain: Chain, entries: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frames (k x n+1 x 4 x 4), corners (k x n x 3) and paths to P (k x 4 x 3) for poses (k x n)."""
    arm = _make_numeric_chain(drawn_chain)
    frames = arm.compute_frames(entries)
    lengths = np.stack(
        [entries[:, i] if kind == PRISMATIC else np.full(len(entries), arm.fixed_entries[i])
         for i, kind in enumerate(arm.kinds)], axis=1
    )  # fmt: skip
    corners = frames[:, :-1, :3, 3] + lengths[..., None] * frames[:, :-1, :3, 2]
    frame = frames[:, drawn_chain.point.frame]
    path = [frame[:, :3, 3]]
    for axis, value in enumerate(drawn_chain.point.offset):
        path.append(path[-1] + float(value) * frame[:, :3, axis])
    return frames, corners, np.stack(path, axis=1)


def compute_skeleton(drawn_chain: Chain, entries: np.ndarray) -> Skeleton:
    """Return the skeleton of the arm in one pose, given by the table's entries (n)."""
    frames, corners, path = compute_skeletons(drawn_chain, entries[None])
    return Skeleton(frames[0], corners[0], entries, path[0])


def find_best_poses(chain: Chain, drawn_chain: Chain, count: int) -> np.ndarray:
    """Return the `count` candidate poses (count x n) whose skeletons are easiest to read, the best pose first."""
    entries = list_candidate_poses(chain, drawn_chain)
    order = np.argsort(-np.round(score_poses(chain, drawn_chain, entries), 3), kind="stable")
    return np.asarray(entries[order[:count]])


def score_poses(chain: Chain, drawn_chain: Chain, entries: np.ndarray) -> np.ndarray:
    """Return how easy the skeletons of poses (k x n) are to read (k); a higher score is better."""
    is_long = chain.n > LONG_ARM_JOINTS
    score, lines, scale = _score_without_clearance(chain, drawn_chain, entries)
    gaps = find_clearance(lines, 2 if is_long else 1) * scale / 70
    return np.asarray(score + CLEARANCE_WEIGHT[is_long] * np.clip(gaps, -1, 1))


def _score_without_clearance(chain: Chain, drawn_chain: Chain, entries: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the score of poses (k) without the bonus for clearance, the lines to keep apart, and the scale (k).

    The lines (k x s x 2 x 2) are pairs of ends: the drawn links, and axes of the last frame.
    """
    frames, corners, path = compute_skeletons(drawn_chain, entries)
    view = choose_view(chain)
    segments = list_segments(frames, corners, path, drawn_chain.point.frame)
    drawn_segments = segments @ view[:2].T
    scale = _compute_fitting_scale(drawn_segments)
    lengths = np.linalg.norm(drawn_segments[:, :, 1] - drawn_segments[:, :, 0], axis=2) * scale[:, None]
    score = 1.5 * np.minimum(lengths.min(axis=1) / 85, 1)
    score = score + 0.3 * np.minimum(lengths.mean(axis=1) / 150, 1) + _score_angles(chain, frames, entries, view)
    up = frames[:, 0, :3, 1 if abs(view[2] @ frames[0, 0, :3, 2]) > 0.999 else 2]
    heights = np.einsum("kspx,kx->ksp", segments - frames[:, 0, None, None, :3, 3], up).reshape(len(entries), -1)
    score = score + 3.0 * np.minimum(heights.min(axis=1) * scale / 40, 0).clip(-1)
    score = score + 0.4 * np.minimum((heights[:, -1] * scale) / 60, 1)
    if not is_drawn_flat(chain):
        z_axes = np.linalg.norm(frames[:, :, :3, 2] @ view[:2].T, axis=2)
        score = score + 0.8 * np.minimum(z_axes.min(axis=1) / 0.6, 1) + 0.9 * _score_axis_separation(frames, view)
        score = score - CROWDED_PENALTY * _count_crowded(frames, view, scale)
    ends = (frames[:, -1, :3, 3] - frames[:, 0, :3, 3]) @ view[:2].T
    score = score + 0.9 * np.minimum(np.linalg.norm(ends, axis=1) * scale / 260, 1)
    return np.asarray(score), _add_last_axes(drawn_segments, frames, view, scale), scale


def _compute_fitting_scale(drawn_segments: np.ndarray) -> np.ndarray:
    """Return the scales (k), in pixels per metre, at which drawn segments (k x s x 2 x 2) have the maximum size."""
    spread = np.ptp(drawn_segments.reshape(len(drawn_segments), -1, 2), axis=1)
    return np.asarray(1.0 / np.maximum(np.max(spread / MAX_ARM_SIZE, axis=1), 1e-9))


def list_segments(frames: np.ndarray, corners: np.ndarray, path: np.ndarray, point_frame: int) -> np.ndarray:
    """Return the segments of all links that have a length (k x s x 2 x 3), from the base to P."""
    points = [frames[:, 0, :3, 3]]
    for i in range(corners.shape[1]):
        points += [corners[:, i], frames[:, i + 1, :3, 3]]
    if point_frame == corners.shape[1]:
        points += [path[:, k] for k in range(1, 4)]
    pairs = np.stack([np.stack(points[:-1], axis=1), np.stack(points[1:], axis=1)], axis=2)
    has_length = np.linalg.norm(pairs[:, :, 1] - pairs[:, :, 0], axis=2).max(axis=0) > 1e-6
    return pairs[:, has_length] if has_length.any() else pairs[:, :1]


def find_clearance(drawn_segments: np.ndarray, axis_count: int) -> np.ndarray:
    """Return how far apart the segments are drawn (k): segments that are not adjacent, and far ends of adjacent ones.

    The distance is -inf if two segments cross. The last `axis_count` segments are axes of the last frame, which are all
    adjacent to the last link.
    """
    shares = np.linspace(0.0, 1.0, 6)[:, None]
    points = drawn_segments[:, :, None, 0] * (1 - shares) + drawn_segments[:, :, None, 1] * shares
    distances = np.full(len(drawn_segments), np.inf)
    last_link = drawn_segments.shape[1] - axis_count - 1
    for i, j in itertools.combinations(range(drawn_segments.shape[1]), 2):
        is_adjacent = j == i + 1 or i >= last_link
        a, b = (points[:, i, :4], points[:, j, 2:]) if is_adjacent else (points[:, i], points[:, j])
        x, y = (a[:, :, None, k] - b[:, None, :, k] for k in range(2))
        gaps = np.sqrt((x * x + y * y).reshape(len(drawn_segments), -1).min(axis=1))
        distances = np.minimum(distances, gaps * (1.3 if is_adjacent else 1.0))
        if not is_adjacent:
            distances = np.where(_are_crossing(drawn_segments[:, i], drawn_segments[:, j]), -np.inf, distances)
    return np.where(distances == np.inf, 1.0, distances)


def _are_crossing(segment: np.ndarray, other_segment: np.ndarray) -> np.ndarray:
    """Return whether two segments (k x 2 x 2 each) cross in the drawing (k)."""

    def separates(line: np.ndarray, segment: np.ndarray) -> np.ndarray:
        direction, offsets = (line[:, 1] - line[:, 0])[:, None], segment - line[:, None, 0]
        cross_products = direction[..., 0] * offsets[..., 1] - direction[..., 1] * offsets[..., 0]
        return np.asarray(cross_products[:, 0] * cross_products[:, 1] < 0)

    return separates(segment, other_segment) & separates(other_segment, segment)


def _add_last_axes(drawn_segments: np.ndarray, frames: np.ndarray, view: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return drawn segments (k x s x 2 x 2), followed by the x axis of the last frame.

    For a long arm, the z axis of this frame is added, too, because the arm's end may come near to its base.
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
        drawn_angle = _compute_drawn_angles(x, end)
        visibility = np.minimum(np.minimum(drawn_angle, np.pi - drawn_angle + 0.3) / np.radians(35), 1)
        visibility = visibility * np.minimum(np.linalg.norm(end, axis=1) / 0.5, 1)
        lowest_visibility = np.minimum(lowest_visibility, visibility)
        if i > 0 or is_drawn_flat(chain):
            preference = preference + np.clip(1.4 - np.abs(entries[:, i] - 0.8), 0, 1) * 1.2 / chain.n
    return np.asarray(1.2 * lowest_visibility + preference)


def _compute_drawn_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angles (k, rad) between vectors in the drawing (k x 2 each)."""
    return np.asarray(np.abs(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))))


def _count_crowded(frames: np.ndarray, view: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Return how many origins and tips of axes (the places of labels) are drawn close together in each pose (k)."""
    origins = frames[:, :, :3, 3]
    tips = [origins + AXIS_LENGTH / scale[:, None, None] * frames[:, :, :3, k] for k in (0, 2)]
    points = np.concatenate([origins, *tips], axis=1)
    return _count_close_pairs(points, points @ view[:2].T * scale[:, None, None], CROWDED_DISTANCE)


def _count_close_pairs(
    points: np.ndarray, drawn_points: np.ndarray, min_distance: float, heavy_count: int = 0
) -> np.ndarray:
    """Return a weighted count (k) of the pairs of p points that are drawn less than `min_distance` pixels apart.

    `points` (k x p x 3, or 1 x p x 3) are in the world, and `drawn_points` (k x p x 2) in the drawing. Pairs that
    coincide in the world don't count. A pair of the first `heavy_count` points counts four times.
    """
    total = np.zeros(len(drawn_points))
    for i, j in itertools.combinations(range(points.shape[1]), 2):
        if np.abs(points[:, i] - points[:, j]).max() > 1e-6:
            gaps = np.linalg.norm(drawn_points[:, i] - drawn_points[:, j], axis=1)
            total += np.maximum(0.0, 1.0 - gaps / min_distance) * (4.0 if j < heavy_count else 1.0)
    return total


def _score_axis_separation(frames: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Return how well x and z axes with a common origin can be distinguished (k).

    The score is 1 if the drawn angles between them are at least 20 degrees.
    """
    lowest_score = np.ones(len(frames))
    arrows = [(frames[:, i, :3, 3], frames[:, i, :3, k]) for i in range(frames.shape[1]) for k in (0, 2)]
    for (origin, axis), (other_origin, other_axis) in itertools.combinations(arrows, 2):
        if np.max(np.abs(origin - other_origin)) > 1e-6 or np.max(np.linalg.norm(axis - other_axis, axis=1)) < 1e-6:
            continue
        drawn_angle = _compute_drawn_angles(axis @ view[:2].T, other_axis @ view[:2].T)
        lowest_score = np.minimum(lowest_score, drawn_angle / np.radians(20))
    return lowest_score


# --- the view of an arm in a given pose ---


def find_best_views(drawn_chain: Chain, entries: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the `count` best views (3 x 3, see `View.axes`) of an arm with numeric lengths, the best view first.

    `entries` (n) are the table entries of the joints. Scores are rounded, so that the order is the same on every
    machine.
    """
    directions = itertools.product(ELEVATIONS, AZIMUTHS)
    views = np.array([compute_view(np.radians(36.0 + angle), np.radians(height)) for height, angle in directions])
    score = _score_views(drawn_chain, entries, views)
    score[0] += USUAL_VIEW_BONUS
    order = np.argsort(-np.round(score, 3), kind="stable")[:count]
    return [SPATIAL_VIEW if k == 0 else views[k] for k in order]


def _score_views(drawn_chain: Chain, entries: np.ndarray, views: np.ndarray) -> np.ndarray:
    """Return how clearly views (k x 3 x 3) show the links, the origins and the z axes of an arm."""
    frames, corners, path = compute_skeletons(drawn_chain, entries[None])
    (segments,) = list_segments(frames, corners, path, drawn_chain.point.frame)
    drawn_segments = np.einsum("spx,kyx->kspy", segments, views[:, :2])
    scale = _compute_fitting_scale(drawn_segments)
    origins, z = frames[0, :, :3, 3], frames[0, :, :3, 2]
    drawn_origins = scale[:, None, None] * np.einsum("ix,kyx->kiy", origins, views[:, :2])
    drawn_axes = np.einsum("ix,kyx->kiy", z, views[:, :2])
    # `find_clearance` needs an axis of the last frame. This axis is too short to matter.
    ends = np.stack([origins[-1], origins[-1] + 1e-6 * z[-1]])
    last_axis = np.broadcast_to(np.einsum("px,kyx->kpy", ends, views[:, :2])[:, None], (len(views), 1, 2, 2))
    clearances = np.clip(find_clearance(np.concatenate([drawn_segments, last_axis], axis=1), 1) * scale / 50, 0, 1)
    visible_shares = np.minimum(np.linalg.norm(drawn_axes, axis=2) / VISIBLE_AXIS_SHARE, 1)
    is_hidden = np.round(views[:, 2] @ z[0], 6) < 0  # the wall that carries the arm hides it
    points = np.concatenate([origins, origins + 0.37 * z])[None]
    drawn_points = np.concatenate([drawn_origins, drawn_origins + AXIS_LENGTH * drawn_axes], axis=1)
    crowded_count = _count_close_pairs(points, drawn_points, CROWDED_DISTANCE_IN_VIEW, heavy_count=len(origins))
    return np.asarray(2.0 * clearances + 0.6 * (visible_shares - 1).sum(axis=1) - crowded_count - is_hidden)
