"""Find out whether a singular configuration is a boundary or an internal singularity.

At a singular configuration, J cannot produce a direction u: u J = 0. A joint motion k does not move the task: J k = 0.
To second order, the arm moves by u . (dJ/dk k) along u. If this product has the same sign for all k, small
motions reach only one side of a surface, at which the workspace folds. If no other configuration reaches the far side
either, the singularity is at the boundary of the workspace. In all other cases, also if the second-order motion is
zero, the singularity is internal. Joint travel is unlimited, as in the chapter. The *workspace* consists of all values
of the task's coordinates that the arm reaches.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain as chain_together

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.singularities.appearance import find_wrist_centre
from qdot.exercises.singularities.axes import Sample, compute_jacobians, stack_samples
from qdot.exercises.singularities.reach import compute_arm_lengths, reaches_beyond

RANK_TOLERANCE = 1e-7
"""A singular value counts as zero if it is less than this fraction of the largest."""

_ROTATION_COUNT = 24
"""Number of angles that are tried for a joint that does not move P, in the search for a corner of the workspace."""


def can_establish_kind(chain: Chain) -> bool:
    """Return whether the kind of an arm's singularities, boundary or internal, can be established and is meaningful.

    Otherwise, the kind is never asked for or reported. The kind can be established for tasks of up to four rows, and
    for all six rows of an arm with a spherical wrist. For other tasks, the search for configurations beyond a fold is
    not a proof.

    The kind is meaningful if the task's rows are the rates of coordinates: of a position, of an orientation, or of an
    angle about a fixed axis. Other angular velocities are rates of no coordinate, so they have no workspace. If there
    are more rows than joints, the workspace is only a surface, whose boundary is of no interest.
    """
    if chain.n == 6 and set(chain.task) == set(VELOCITY_NAMES):
        return find_wrist_centre(chain) is not None
    return len(chain.task) <= min(4, chain.n) and _has_coordinates(chain)


def _has_coordinates(chain: Chain) -> bool:
    """Return whether the angular rows of the task are none, all three, or the only one in which the arm rotates."""
    angular_rows = [row for row in chain.task if row[0] == "w"]
    if len(angular_rows) in (0, 3):
        return True
    return len(angular_rows) == 1 and all(
        row in angular_rows or derive(chain).geometric_jacobian[i, :].is_zero_matrix
        for i, row in enumerate(VELOCITY_NAMES)
        if row[0] == "w"
    )


def are_one_sided(chain: Chain, samples: Sequence[Sample]) -> bool:
    """Return whether each sample loses exactly one direction, and reaches nothing on one side of this direction.

    At some boundary configurations, this is found only after the rotation of a joint that does not move P; for these,
    return False.
    """
    if not samples:
        return False
    has_free_orientation = _has_free_orientation(chain)
    tested_samples = _cut_before_wrist(samples) if has_free_orientation else samples
    rows = [0, 1, 2] if has_free_orientation else chain.task_rows
    singular_values = np.linalg.svd(compute_jacobians(tested_samples)[:, rows], compute_uv=False)
    loses_one_direction = _compute_ranks(singular_values, tested_samples) == len(rows) - 1
    return bool(np.all(loses_one_direction) and np.all(_classify_by_motion(tested_samples, rows) == "boundary"))


def classify_samples(chain: Chain, samples: Sequence[Sample]) -> list[str]:
    """Return the kind of each sample: "boundary", "internal" or "regular". All arms must have the same structure.

    If the arm's spherical wrist reaches every orientation, only the wrist centre matters. The arm is at the boundary if
    the wrist centre is at the boundary of its own workspace.
    """
    if not _has_free_orientation(chain):
        return list(_classify_by_position(samples, chain.task_rows))
    kinds = np.full(len(samples), "regular", dtype=object)
    sigma = np.linalg.svd(compute_jacobians(samples), compute_uv=False) if samples else np.ones((0, 6))
    singular_indices = np.flatnonzero(_compute_ranks(sigma, samples) < 6).tolist()
    wrist_centre_kinds = _classify_by_position(_cut_before_wrist([samples[k] for k in singular_indices]), [0, 1, 2])
    kinds[singular_indices] = np.where(wrist_centre_kinds == "boundary", "boundary", "internal")
    return list(kinds)


def _has_free_orientation(chain: Chain) -> bool:
    """Return whether an arm with six joints and a task of six rows has a spherical wrist that reaches all orientations.

    Successive axes of such a wrist are perpendicular.
    """
    has_wrist = chain.n == 6 and set(chain.task) == set(VELOCITY_NAMES) and find_wrist_centre(chain) is not None
    return has_wrist and all(sp.cos(joint.alpha) == 0 for joint in chain.joints[3:5])


def _cut_before_wrist(samples: Sequence[Sample]) -> list[Sample]:
    """Return samples of arms with a spherical wrist as samples of their first three joints; P is the wrist centre."""

    def cut(sample: Sample) -> Sample:
        wrist_centre = (0.0, 0.0, sample.arm.fixed_entries[3])  # at the distance d of joint 4 along the z axis
        return Sample(sample.arm.keep_first_joints(3, wrist_centre), sample.q[:3])

    return list(map(cut, samples))


def _compute_ranks(sigma: np.ndarray, samples: Sequence[Sample]) -> np.ndarray:
    """Return the ranks (k) of the samples' Jacobians, given their singular values (k x m).

    A Jacobian whose entries are all negligible compared with the arm's length has rank zero.
    """
    scale = sigma[:, 0].copy()
    small_indices = np.flatnonzero(scale < 1.0).tolist()
    if small_indices:
        arm_lengths = compute_arm_lengths([samples[k].arm for k in small_indices])
        scale[small_indices] = np.maximum(scale[small_indices], np.minimum(arm_lengths, 1.0))
    return np.asarray(np.sum(sigma > RANK_TOLERANCE * scale[:, None], axis=1))


def _classify_by_position(samples: Sequence[Sample], task: list[int]) -> np.ndarray:
    """Return the kind of each sample; for a position task, all configurations with the same P have the same kind.

    At a corner of the workspace, the boundary is found only at some of the configurations that bring P there.
    Therefore, if a joint can rotate without moving P, its rotations are tested, too. If one of them is at the boundary,
    so is the sample.
    """
    kinds = _classify_by_motion(samples, task)
    if not samples or max(task) > 2:
        return kinds
    internal_samples = {k: samples[k] for k in np.flatnonzero(kinds == "internal").tolist()}
    for joint in range(1, samples[0].arm.point_frame):
        if internal_samples and samples[0].arm.is_revolute[joint]:
            rotations = _rotate_joint(internal_samples, joint)
            rotation_kinds = _classify_by_motion(list(chain_together(*rotations.values())), task)
            for k, kinds_of_sample in zip(rotations, rotation_kinds.reshape(-1, _ROTATION_COUNT), strict=True):
                if "boundary" in kinds_of_sample:
                    kinds[k] = "boundary"
            internal_samples = {k: sample for k, sample in internal_samples.items() if k not in rotations}
    return kinds


def _rotate_joint(samples: Mapping[int, Sample], joint: int) -> dict[int, list[Sample]]:
    """Return samples with a joint rotated, for each of the samples whose P this joint does not move."""
    arms, q = stack_samples(list(samples.values()))
    q = np.tile(q, (1, _ROTATION_COUNT, 1))
    q[..., joint] = np.linspace(-np.pi, np.pi, _ROTATION_COUNT, endpoint=False)
    keeps_point = np.ptp(arms.compute_point(q), axis=1).max(axis=1) < RANK_TOLERANCE
    return {
        k: [Sample(sample.arm, configuration) for configuration in configurations]
        for (k, sample), configurations, point_stays in zip(samples.items(), q, keeps_point, strict=True)
        if point_stays
    }


def _classify_by_motion(samples: Sequence[Sample], task: list[int]) -> np.ndarray:
    """Return the kind of each sample by its small motions and by a search for configurations beyond it."""
    kinds = np.full(len(samples), "regular", dtype=object)
    if not samples:
        return kinds
    u, singular_values, v_transposed = np.linalg.svd(compute_jacobians(samples)[:, task])
    ranks = _compute_ranks(singular_values, samples)
    for rank in sorted({int(rank) for rank in ranks if rank < singular_values.shape[1]}):
        indices = np.flatnonzero(ranks == rank)
        rank_samples = [samples[k] for k in indices.tolist()]
        bending = _compute_bending(rank_samples, task, v_transposed[indices, rank:])
        is_at_boundary = np.zeros(len(indices), dtype=bool)
        for lost_directions in _yield_lost_directions(u[indices, :, rank:], bending):
            undecided_indices = np.flatnonzero(~is_at_boundary)  # no earlier direction has shown the boundary
            if len(undecided_indices):
                undecided_samples = [rank_samples[k] for k in undecided_indices.tolist()]
                is_at_boundary[undecided_indices] = _are_at_boundary(
                    undecided_samples, task, lost_directions[undecided_indices], bending[undecided_indices]
                )
        kinds[indices] = np.where(is_at_boundary, "boundary", "internal")
    return kinds


def _yield_lost_directions(lost_basis: np.ndarray, bending: "_Bending") -> Iterator[np.ndarray]:
    """Yield unit vectors along lost directions of k samples (k x m), without their opposites.

    `lost_basis` (k x m x lost directions) are orthonormal lost directions. If several directions are lost at once, many
    combinations of them are yielded. The sample is at the boundary if the workspace folds along any of these. At a
    corner of the workspace, it folds only along a few combinations. Therefore the combination along which small motions
    reach the least comes first.
    """
    lost_count = lost_basis.shape[2]
    if lost_count == 1:
        yield lost_basis[:, :, 0]
        return
    if lost_count == 2:
        yield _find_least_reached_direction(lost_basis, bending)
    for weights in _list_unit_vectors(lost_count):
        yield lost_basis @ weights


_DIRECTION_STEP = np.pi / 15
"""Angle (rad) between successive combinations that are tried if two directions are lost."""
_RANDOM_DIRECTION_COUNT = 150
"""Number of random combinations that are tried if more than two directions are lost."""


@lru_cache(maxsize=8)
def _list_unit_vectors(dimension: int) -> np.ndarray:
    """Return unit vectors, count x dimension, without the opposite of any of them."""
    if dimension == 2:
        return _compute_unit_vectors(np.arange(0, np.pi, _DIRECTION_STEP))
    rng = Stream("directions")
    vectors = np.array([[rng.uniform(-1, 1) for _ in range(dimension)] for _ in range(_RANDOM_DIRECTION_COUNT)])
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _compute_unit_vectors(angles: np.ndarray) -> np.ndarray:
    """Return the unit vectors (… x 2) at angles in a plane."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


_REFINEMENT_ROUNDS, _REFINEMENT_FACTOR = 6, 4.0
"""The search for the least reached direction: number of rounds, and the factor by which each round refines the
angle."""


def _find_least_reached_direction(lost_basis: np.ndarray, bending: "_Bending") -> np.ndarray:
    """Return per sample the combination of two lost directions (k x m) along which small motions reach the least."""
    forms = np.stack([_compute_quadratic_forms(lost_basis[..., column], bending) for column in range(2)])
    angles = np.tile(np.arange(0, 2 * np.pi, _DIRECTION_STEP), (len(lost_basis), 1))
    for round_number in range(_REFINEMENT_ROUNDS):
        eigenvalues = np.linalg.eigvalsh(np.einsum("kal,lkst->kast", _compute_unit_vectors(angles), forms))
        best_angles = np.take_along_axis(angles, np.argmin(eigenvalues[..., -1], axis=1)[:, None], axis=1)
        angles = best_angles + np.linspace(-_DIRECTION_STEP, _DIRECTION_STEP, 9) / _REFINEMENT_FACTOR**round_number
    return np.einsum("kml,kl->km", lost_basis, _compute_unit_vectors(best_angles[:, 0]))


@dataclass(frozen=True)
class _Bending:
    """The changes of the Jacobians of k samples along joint motions that do not move the task.

    - `joint_motions`: s joint motions for each sample, k x s x n.
    - `jacobian_changes`: the change of the task Jacobian from a step backward along each of these motions to a step
      forward, k x s x m x n. The length of the steps is _DIFFERENCE_STEP.
    """

    joint_motions: np.ndarray
    jacobian_changes: np.ndarray

    def __getitem__(self, indices: np.ndarray) -> "_Bending":
        return _Bending(self.joint_motions[indices], self.jacobian_changes[indices])


_DIFFERENCE_STEP = 1e-4
"""Step of the joint motions (rad or m) for finite differences."""
_CURVATURE_TOLERANCE = 1e-5
"""A second-order motion (m or rad, for a unit joint motion) below this limit counts as zero."""


def _compute_bending(samples: Sequence[Sample], task: list[int], joint_motions: np.ndarray) -> _Bending:
    """Return the changes of the samples' task Jacobians along joint motions (k x s x n)."""
    arms, q = stack_samples(samples)
    directions = np.concatenate([joint_motions, -joint_motions], axis=1)
    jacobians = arms.compute_jacobian(q + _DIFFERENCE_STEP * directions)[:, :, task]
    forward_jacobians, backward_jacobians = np.split(jacobians, 2, axis=1)
    return _Bending(joint_motions, forward_jacobians - backward_jacobians)


def _are_at_boundary(
    samples: Sequence[Sample], task: list[int], lost_directions: np.ndarray, bending: _Bending
) -> np.ndarray:
    """Return for each sample whether it is at the boundary of the workspace along its lost direction (k x m).

    A sample is at the boundary if no configuration reaches beyond it on a side that small motions do not reach. Motions
    without a second-order effect are ignored, such as those of a joint that moves nothing. If no motion has a
    second-order effect, both sides are tested.
    """
    eigenvalues = np.linalg.eigvalsh(_compute_quadratic_forms(lost_directions, bending))
    moves_forward = np.any(eigenvalues > _CURVATURE_TOLERANCE, axis=1)
    moves_backward = np.any(eigenvalues < -_CURVATURE_TOLERANCE, axis=1)
    # the search is reliable only for a point that can move in as many directions as the task has rows
    is_tested = moves_forward | moves_backward | (max(task) < 3 and len(task) <= len(samples[0].q))
    is_at_boundary = np.zeros(len(samples), dtype=bool)
    for sign, is_reached in ((1, moves_forward), (-1, moves_backward)):
        indices = np.flatnonzero(is_tested & ~is_reached & ~is_at_boundary)
        if len(indices):
            tested_samples = [samples[k] for k in indices.tolist()]
            is_at_boundary[indices] = ~reaches_beyond(tested_samples, task, sign * lost_directions[indices])
    return is_at_boundary


def _compute_quadratic_forms(directions: np.ndarray, bending: _Bending) -> np.ndarray:
    """Return the quadratic forms (k x s x s) of the second-order motion of each sample along its direction (k x m)."""
    changes = np.einsum("km,ksmn->ksn", directions, bending.jacobian_changes) / (2 * _DIFFERENCE_STEP)
    forms = changes @ bending.joint_motions.swapaxes(1, 2)
    return np.asarray((forms + forms.swapaxes(1, 2)) / 2)
