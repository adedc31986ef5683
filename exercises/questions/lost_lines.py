"""The lines of an arm along which motion is lost on a branch of its singular set, found at sampled configurations."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import compress

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.questions.geometry import sample_singular_configurations
from qdot.exercises.singularities.directions import (
    NONZERO_THRESHOLD,
    ArmLine,
    line_directions,
    list_candidate_lines,
    lost_direction,
)
from qdot.exercises.singularities.singularity import Component

SAMPLE_COUNT = 8
"""Number of configurations at which lines are compared with the lost direction."""

MAX_WRONG_COSINE = float(np.cos(np.radians(13.7)))
"""Cosine of 13.7 degrees, the minimum angle between a wrong line and the lost direction.

It is not 15 degrees, because joints are sampled in steps of 5 degrees, so that 15 degrees occur exactly. Then rounding
would decide, which differs between machines."""


@dataclass(frozen=True)
class LostMotion:
    """A lost translation of "P" or rotation of the last "link" (`moving_part`), with the correct and the wrong lines.

    If `holds_other_motion` is true, the motion is lost only while the other one is zero.
    """

    moving_part: str
    holds_other_motion: bool
    correct_lines: tuple[ArmLine, ...]
    wrong_lines: tuple[ArmLine, ...]


@lru_cache(maxsize=1024)
def find_lost_motion(generic: Chain, component: Component) -> LostMotion | None:
    """Return the motion that a structure loses on a branch, or None if no line of the arm describes it."""
    samples, rows = sample_singular_configurations(generic, component, SAMPLE_COUNT), generic.task_rows
    lost_directions = [lost_direction(sample.arm.jacobian(sample.q)[rows], NONZERO_THRESHOLD / 5) for sample in samples]
    if len(samples) < SAMPLE_COUNT // 2 or any(u is None for u in lost_directions):
        return None
    lost_twists = np.zeros((len(samples), 6))
    lost_twists[:, rows] = np.array(lost_directions)
    norms = {"P": np.linalg.norm(lost_twists[:, :3], axis=1), "link": np.linalg.norm(lost_twists[:, 3:], axis=1)}
    lines = list_candidate_lines(generic)
    vectors = line_directions(lines, samples)
    for moving, held_part, first_row in (("P", "link", 0), ("link", "P", 3)):
        if np.any(norms[moving] < 0.02):
            continue
        other_axes = [axis for axis in range(3) if first_row + axis not in rows]
        in_task = np.abs(vectors[:, :, other_axes]).max(axis=(1, 2), initial=0.0) <= 1e-9  # False where undefined
        cosine = np.abs(np.sum(vectors * (lost_twists[:, first_row : first_row + 3] / norms[moving][:, None]), axis=2))
        is_correct = in_task & np.all(cosine > 1 - 1e-9, axis=1)
        is_oblique = (np.mean(cosine < MAX_WRONG_COSINE, axis=1) >= 0.75) & ~np.isnan(cosine).any(axis=1)
        is_wrong = in_task & ~is_correct & is_oblique
        if is_correct.any() and _count_directions(vectors[is_wrong]) >= 2:
            is_held = bool(np.any(norms[held_part] > 1e-7))
            return LostMotion(moving, is_held, tuple(compress(lines, is_correct)), tuple(compress(lines, is_wrong)))
    return None


def _count_directions(line_directions: np.ndarray) -> int:
    """Return the number of different directions among lines, (lines, samples, 3)."""
    distinct_directions: list[np.ndarray] = []
    for vectors in line_directions:
        if not any(_are_parallel(vectors, known_vectors) for known_vectors in distinct_directions):
            distinct_directions.append(vectors)
    return len(distinct_directions)


def _are_parallel(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.all(np.abs(np.sum(a * b, axis=1)) > 1 - 1e-6))


@lru_cache(maxsize=1024)
def find_parallel_lines(generic: Chain, component: Component) -> dict[tuple[ArmLine, ArmLine], bool]:
    """Return for each pair of lines whether they are parallel everywhere on a branch."""
    lines = list_candidate_lines(generic)
    vectors = line_directions(lines, sample_singular_configurations(generic, component, SAMPLE_COUNT))
    return {(a, b): _are_parallel(vectors[i], vectors[j]) for i, a in enumerate(lines) for j, b in enumerate(lines)}
