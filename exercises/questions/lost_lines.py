"""The lines of an arm along which a motion is lost on a branch of its singular set, found at samples of a structure."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import compress

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.directions import CLEAR, Line, directions, lines_of, lost_direction
from qdot.exercises.arm.singularity import Component
from qdot.exercises.questions.geometry import sample_singular_poses

SAMPLES = 8
"""Configurations at which lines are tried."""

CLEARLY_OFF = float(np.cos(np.radians(13.7)))
"""Cosine of the least angle between a wrong line and the lost direction. Joints are sampled in steps of 5 degrees, so
that an angle of 15 degrees occurs, which rounding puts on one side on one machine and on the other side on another."""


@dataclass(frozen=True)
class Motion:
    """What can't move along which line: "P" or "link", the other held still where `held`; right and wrong lines."""

    moving: str
    held: bool
    right: tuple[Line, ...]
    wrong: tuple[Line, ...]


@lru_cache(maxsize=1024)
def find_lost_motion(generic: Chain, component: Component) -> Motion | None:
    """Return the lines along which a motion is lost and those along which none is, on a branch of a structure."""
    samples, rows = sample_singular_poses(generic, component, SAMPLES), generic.task_rows
    lost = [lost_direction(sample.arm.jacobian(sample.q)[rows], CLEAR / 5) for sample in samples]
    if len(samples) < SAMPLES // 2 or any(u is None for u in lost):
        return None
    whole = np.zeros((len(samples), 6))
    whole[:, rows] = np.array(lost)
    sizes = {"P": np.linalg.norm(whole[:, :3], axis=1), "link": np.linalg.norm(whole[:, 3:], axis=1)}
    lines = lines_of(generic)
    along = directions(lines, samples)
    for moving, still, first in (("P", "link", 0), ("link", "P", 3)):
        if np.any(sizes[moving] < 0.02):
            continue
        uncounted = [axis for axis in range(3) if first + axis not in rows]
        in_task = np.abs(along[:, :, uncounted]).max(axis=(1, 2), initial=0.0) <= 1e-9  # False where undefined
        cosine = np.abs(np.sum(along * (whole[:, first : first + 3] / sizes[moving][:, None]), axis=2))
        right = in_task & np.all(cosine > 1 - 1e-9, axis=1)
        wrong = in_task & ~right & (np.mean(cosine < CLEARLY_OFF, axis=1) >= 0.75) & ~np.isnan(cosine).any(axis=1)
        if right.any() and _count_directions(along[wrong]) >= 2:
            held = bool(np.any(sizes[still] > 1e-7))
            return Motion(moving, held, tuple(compress(lines, right)), tuple(compress(lines, wrong)))
    return None


def _count_directions(along: np.ndarray) -> int:
    """Return how many of some lines, (lines, samples, 3), have directions of their own."""
    different: list[np.ndarray] = []
    for vectors in along:
        if not any(_are_parallel(vectors, known) for known in different):
            different.append(vectors)
    return len(different)


def _are_parallel(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.all(np.abs(np.sum(a * b, axis=1)) > 1 - 1e-6))


@lru_cache(maxsize=1024)
def find_parallel_lines(generic: Chain, component: Component) -> dict[tuple[Line, Line], bool]:
    """Tell for each pair of lines whether they are parallel all over a branch."""
    lines = lines_of(generic)
    along = directions(lines, sample_singular_poses(generic, component, SAMPLES))
    return {(a, b): _are_parallel(along[i], along[j]) for i, a in enumerate(lines) for j, b in enumerate(lines)}
