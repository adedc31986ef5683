"""The lines of an arm along which a motion is lost on a branch of its singular set, found at samples of a structure."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.directions import CLEAR, Line, directions, lines_of, lost_direction, task_rows
from qdot.exercises.arm.singularity import Component
from qdot.exercises.questions.geometry import singular_samples

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
def lost_motion(generic: Chain, component: Component) -> Motion | None:
    """Return the lines along which a motion is lost and those along which none is, on a branch of a structure."""
    samples, rows = singular_samples(generic, component, SAMPLES), task_rows(generic)
    lost = [lost_direction(sample.arm.jacobian(sample.q)[rows], CLEAR / 5) for sample in samples]
    if len(samples) < SAMPLES // 2 or any(u is None for u in lost):
        return None
    whole = np.zeros((len(samples), 6))
    whole[:, rows] = np.array(lost)
    sizes = {"P": np.linalg.norm(whole[:, :3], axis=1), "link": np.linalg.norm(whole[:, 3:], axis=1)}
    lines = lines_of(generic)
    along = directions(lines, samples)
    for moving, first in (("P", 0), ("link", 3)):
        if np.any(sizes[moving] < 0.02):
            continue
        held = bool(np.any(sizes["link" if moving == "P" else "P"] > 1e-7))
        counted = [row - first in range(3) and row in rows for row in range(first, first + 3)]
        motion = _sort_lines(moving, held, whole[:, first : first + 3] / sizes[moving][:, None], lines, along, counted)
        if motion is not None:
            return motion
    return None


def _sort_lines(
    moving: str, held: bool, lost: np.ndarray, lines: list[Line], along: np.ndarray, counted: list[bool]
) -> Motion | None:
    """Sort lines into those parallel to the lost direction everywhere and those clearly not, nearly everywhere."""
    right, wrong = [], []
    off = ~np.array(counted)
    for line, vectors in zip(lines, along, strict=True):
        if np.isnan(vectors).any() or np.abs(vectors[:, off]).max(initial=0.0) > 1e-9:
            continue
        cosine = np.abs(np.sum(vectors * lost, axis=1))
        if np.all(cosine > 1 - 1e-9):
            right.append(line)
        elif np.mean(cosine < CLEARLY_OFF) >= 0.75:
            wrong.append(line)
    return (
        Motion(moving, held, tuple(right), tuple(wrong))
        if right and _count_directions(wrong, lines, along) >= 2
        else None
    )


def _count_directions(chosen: list[Line], lines: list[Line], along: np.ndarray) -> int:
    """Return how many of the lines have directions of their own."""
    groups: list[np.ndarray] = []
    for line in chosen:
        vectors = along[lines.index(line)]
        if not any(np.all(np.abs(np.sum(vectors * known, axis=1)) > 1 - 1e-6) for known in groups):
            groups.append(vectors)
    return len(groups)


@lru_cache(maxsize=1024)
def parallel_lines(generic: Chain, component: Component) -> dict[tuple[Line, Line], bool]:
    """Tell of each pair of lines whether they are parallel all over a branch."""
    lines = lines_of(generic)
    along = directions(lines, singular_samples(generic, component, SAMPLES))
    return {
        (a, b): bool(np.all(np.abs(np.sum(along[i] * along[j], axis=1)) > 1 - 1e-6))
        for i, a in enumerate(lines)
        for j, b in enumerate(lines)
    }
