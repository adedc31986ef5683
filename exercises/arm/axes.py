"""How joint axes, slides and the point of interest lie at a configuration: distances, angles, lines, planes.

Each measure is zero where something is exactly so: a point on an axis, two axes on one line. What is zero everywhere
tells nothing of a singular configuration, so that the pose `beside` it is looked at as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exercises.arm.kinematics import NumericChain, cross


@dataclass(frozen=True)
class Sample:
    """One arm in numbers at one configuration q (n)."""

    arm: NumericChain
    q: np.ndarray


def beside(sample: Sample, but: int | None = None) -> np.ndarray:
    """Return a pose (n) near a sample, out of line in every joint; `but` moves one joint more."""
    moved = sample.q + 0.3 * np.arange(1, len(sample.q) + 1)
    if but is not None:
        moved[but] += 0.2
    return np.asarray(moved)


def around(samples: Sequence[Sample]) -> list[Sample]:
    """Return samples near by, at which what is special of the first no longer holds."""
    return [Sample(sample.arm, beside(sample)) for sample in samples]


def distance(sample: Sample, q: np.ndarray, joint: int) -> float:
    """Return the distance of the point from a joint's axis, in metres."""
    return float(distances(sample, q[None], joint)[0])


def distances(sample: Sample, q: np.ndarray, joint: int) -> np.ndarray:
    """Return the distance of the point from a joint's axis in many poses (k x n)."""
    frames = sample.arm.frames(q)
    arm = sample.arm.point_of(frames) - frames[:, joint, :3, 3]
    return np.asarray(np.linalg.norm(cross(frames[:, joint, :3, 2], arm), axis=1))


def spread(sample: Sample, q: np.ndarray, joints: Sequence[int]) -> float:
    """Return the area or volume that the directions of two or three axes span: 0 to 1."""
    z = sample.arm.frames(q)[list(joints), :3, 2]
    return float(np.sqrt(max(np.linalg.det(z @ z.T), 0.0)))


def off_line(sample: Sample, q: np.ndarray, i: int, j: int) -> float:
    """Return how far two axes are from lying on one line: sine of their angle plus distance of O_j from axis i."""
    frames = sample.arm.frames(q)
    axis, between = frames[i, :3, 2], frames[j, :3, 3] - frames[i, :3, 3]
    return float(np.linalg.norm(cross(axis, frames[j, :3, 2])) + np.linalg.norm(cross(axis, between)))


def off_plane(sample: Sample, q: np.ndarray, row: tuple[int, int, int]) -> float:
    """Return how far three parallel axes are from lying in one plane: the area between the points where they start."""
    frames = sample.arm.frames(q)
    first, second, third = (frames[i, :3, 3] for i in row)
    return abs(float(frames[row[0], :3, 2] @ cross(second - first, third - first)))


def parallel(samples: Sequence[Sample], i: int, j: int) -> bool:
    """Tell whether two axes are parallel in all samples."""
    frames = [sample.arm.frames(sample.q) for sample in samples]
    return all(np.linalg.norm(cross(f[i, :3, 2], f[j, :3, 2])) < 1e-6 for f in frames)


def slant(sample: Sample, q: np.ndarray, slide: int, i: int, j: int, across: bool) -> float:
    """Return the sine of the angle by which a slide does not run along, or `across`, the line from axis i to axis j.

    The axes are parallel; the line is the shortest between them. Where they are one line, nothing runs along it: 1.
    """
    frames = sample.arm.frames(q)
    line, along = frames[j, :3, 3] - frames[i, :3, 3], frames[slide, :3, 2]
    line = line - (line @ frames[i, :3, 2]) * frames[i, :3, 2]
    size = float(np.linalg.norm(line))
    if size < 1e-6:
        return 1.0
    return float(abs(along @ line) if across else np.linalg.norm(cross(along, line))) / size
