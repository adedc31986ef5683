"""Find the lines of an arm (joint axes, links, …) along which no motion is possible on a branch of its singular set.

The directions of the lines are compared with the lost direction at sampled configurations.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import compress

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.questions.exact_configurations import sample_singular_configurations
from qdot.exercises.singularities import directions
from qdot.exercises.singularities.directions import ArmLine
from qdot.exercises.singularities.singular_set import Component

SAMPLE_COUNT = 8
"""Number of configurations at which lines are compared with the lost direction."""

MAX_WRONG_COSINE = float(np.cos(np.radians(13.7)))
"""Cosine of 13.7 degrees, the minimum angle between a wrong line and the lost direction.

The limit is not 15 degrees: joints are sampled in steps of 5 degrees, so 15 degrees would occur exactly. Then rounding
would decide, and rounding differs between machines.
"""


@dataclass(frozen=True)
class LostMotion:
    """A motion that an arm loses on a branch: a translation of "P" or a rotation of the last "link" (`moving_part`).

    `correct_lines` are parallel to the lost direction, and `wrong_lines` are clearly not. If `holds_other_motion`, the
    motion is impossible only while the other motion (rotation or translation) is zero.
    """

    moving_part: str
    holds_other_motion: bool
    correct_lines: tuple[ArmLine, ...]
    wrong_lines: tuple[ArmLine, ...]


@lru_cache(maxsize=1024)
def find_lost_motion(symbolic_chain: Chain, component: Component) -> LostMotion | None:
    """Return the motion that a structure loses on a branch; None if no line of the arm has the lost direction.

    The correct lines have the form of a wrong line, because an option of another form than all others would stand out.
    """
    samples = sample_singular_configurations(symbolic_chain, component, SAMPLE_COUNT)
    threshold = directions.NONZERO_THRESHOLD / 5  # lower, because the samples have lengths of very different size
    rows = symbolic_chain.task_rows
    jacobians = (sample.arm.compute_jacobian(sample.q)[rows] for sample in samples)
    lost_directions = [directions.find_lost_direction(jacobian, threshold) for jacobian in jacobians]
    if len(samples) < SAMPLE_COUNT // 2 or any(u is None for u in lost_directions):
        return None
    lost_twists = np.zeros((len(samples), 6))
    lost_twists[:, rows] = np.array(lost_directions)
    norms = {"P": np.linalg.norm(lost_twists[:, :3], axis=1), "link": np.linalg.norm(lost_twists[:, 3:], axis=1)}
    lines = directions.list_candidate_lines(symbolic_chain)
    vectors = directions.compute_line_directions(lines, samples)
    for moving_part, other_part, first_row in (("P", "link", 0), ("link", "P", 3)):
        if np.any(norms[moving_part] < 0.02):  # the lost direction has hardly any such motion
            continue
        axes_outside_task = [axis for axis in range(3) if first_row + axis not in rows]
        # A line is False here if its direction is undefined (nan) at some configuration.
        is_in_task = np.abs(vectors[:, :, axes_outside_task]).max(axis=(1, 2), initial=0.0) <= 1e-9
        unit_vectors = lost_twists[:, first_row : first_row + 3] / norms[moving_part][:, None]
        cosine = np.abs(np.sum(vectors * unit_vectors, axis=2))
        is_correct = is_in_task & np.all(cosine > 1 - 1e-9, axis=1)
        is_oblique = (np.mean(cosine < MAX_WRONG_COSINE, axis=1) >= 0.75) & ~np.isnan(cosine).any(axis=1)
        is_wrong = is_in_task & ~is_correct & is_oblique
        if is_correct.any() and _count_directions(vectors[is_wrong]) >= 2:
            wrong_lines = tuple(compress(lines, is_wrong))
            forms = {line.form for line in wrong_lines}  # the only line of its form would stand out
            correct_lines = tuple(line for line in compress(lines, is_correct) if line.form in forms)
            if correct_lines:
                return LostMotion(moving_part, bool(np.any(norms[other_part] > 1e-7)), correct_lines, wrong_lines)
    return None


def _count_directions(line_vectors: np.ndarray) -> int:
    """Return how many of the lines, given by unit vectors (lines, samples, 3), have different directions."""
    distinct_vectors: list[np.ndarray] = []
    for vectors in line_vectors:
        if not any(_are_parallel(vectors, known_vectors) for known_vectors in distinct_vectors):
            distinct_vectors.append(vectors)
    return len(distinct_vectors)


def _are_parallel(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.all(np.abs(np.sum(a * b, axis=1)) > 1 - 1e-6))


@lru_cache(maxsize=1024)
def compare_lines(symbolic_chain: Chain, component: Component) -> dict[tuple[ArmLine, ArmLine], bool]:
    """Return for each pair of a structure's lines whether the two lines are parallel at all samples of a branch."""
    lines = directions.list_candidate_lines(symbolic_chain)
    samples = sample_singular_configurations(symbolic_chain, component, SAMPLE_COUNT)
    vectors = directions.compute_line_directions(lines, samples)
    return {(a, b): _are_parallel(vectors[i], vectors[j]) for i, a in enumerate(lines) for j, b in enumerate(lines)}
