"""Compute whether a singular configuration is a boundary or an internal singularity.

At a singular configuration, let u be a direction that J cannot produce (u J = 0), and k a joint motion that does not
move the task (J k = 0). To second order, the arm moves by u . (dJ/dk k) along u. If this has the same sign for all k,
small motions reach only one side of a surface, at which the reach folds back. If no other configuration reaches the
far side either, the singularity is at the boundary of the reach. In all other cases it is internal, also if the
second-order motion vanishes. Unlimited joint travel is assumed, as in the chapter.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.singularities.appearance import wrist_centre
from qdot.exercises.singularities.axes import Sample, jacobians_of
from qdot.exercises.singularities.reach import reach_lengths, reaches_beyond

RANK_TOLERANCE = 1e-7
"""A singular value counts as zero if it is below this fraction of the largest."""

_ROTATION_COUNT = 24
"""Number of angles that are tried for a joint that does not move the point, in the search for a corner of the reach."""


def can_establish_kind(chain: Chain) -> bool:
    """Return whether the kind, boundary or internal, can be established and is meaningful for a chain.

    If not, the kind is never asked for or reported.

    The kind can be established for up to four rows, and for all six rows of an arm with a spherical wrist. For other
    tasks, the search for configurations beyond a fold is no proof. The kind is meaningful if the task's rows are rates
    of coordinates, such as a position, an orientation or one angle about a fixed axis. Only coordinates have a reach;
    angular velocities have none. If there are more rows than joints, the reach is only a surface, whose boundary is of
    no interest.
    """
    if chain.n == 6 and set(chain.task) == set(TASK_ROWS):
        return wrist_centre(chain) is not None
    return len(chain.task) <= min(4, chain.n) and _has_coordinates(chain)


def _has_coordinates(chain: Chain) -> bool:
    """Return whether the task's angular rows are none, all three, or the only one in which the arm rotates."""
    angular_rows = [row for row in chain.task if row[0] == "w"]
    if len(angular_rows) in (0, 3):
        return True
    return len(angular_rows) == 1 and all(
        row in angular_rows or derive(chain).geometric[i, :].is_zero_matrix
        for i, row in enumerate(TASK_ROWS)
        if row[0] == "w"
    )


def are_one_sided(chain: Chain, samples: Sequence[Sample]) -> bool:
    """Return whether each configuration loses exactly one direction, on one side of which nothing can be reached.

    Return False for boundary configurations that show this only after a joint that does not move the point has been
    rotated.
    """
    rows = chain.task_rows
    if _has_free_orientation(chain):
        samples, rows = _arms_before_wrist(samples), [0, 1, 2]
    if not samples:
        return False
    ranks = _ranks(np.linalg.svd(jacobians_of(samples)[:, rows], compute_uv=False), samples)
    return bool(np.all(ranks == len(rows) - 1) and np.all(_kinds_by_motion(samples, rows) == "boundary"))


def classify_samples(chain: Chain, samples: Sequence[Sample]) -> list[str]:
    """Return the kinds of many configurations of arms of the same structure, faster than one at a time.

    An arm with a spherical wrist is at the boundary if the wrist centre is at the boundary of its reach, because the
    wrist itself reaches every orientation.
    """
    if not _has_free_orientation(chain):
        return list(_kinds_by_position(samples, chain.task_rows))
    kinds = np.full(len(samples), "regular", dtype=object)
    sigma = np.linalg.svd(jacobians_of(samples), compute_uv=False) if samples else np.ones((0, 6))
    singular = np.flatnonzero(_ranks(sigma, samples) < 6).tolist()
    wrist_centre_kinds = _kinds_by_position(_arms_before_wrist([samples[k] for k in singular]), [0, 1, 2])
    kinds[singular] = np.where(wrist_centre_kinds == "boundary", "boundary", "internal")
    return list(kinds)


def _has_free_orientation(chain: Chain) -> bool:
    """Return whether a six-joint arm with a full task has a spherical wrist that reaches all orientations.

    The wrist's successive axes must be perpendicular.
    """
    has_wrist = chain.n == 6 and set(chain.task) == set(TASK_ROWS) and wrist_centre(chain) is not None
    return has_wrist and all(sp.cos(joint.alpha) == 0 for joint in chain.joints[3:5])


def _arms_before_wrist(samples: Sequence[Sample]) -> list[Sample]:
    """Return the first three joints of six-joint arms with a spherical wrist, with the wrist centre as their point."""
    return [Sample(s.arm.first_joints(3, (0.0, 0.0, s.arm.fixed[3][0])), s.q[:3]) for s in samples]


def _ranks(sigma: np.ndarray, samples: Sequence[Sample]) -> np.ndarray:
    """Return the ranks of Jacobians with these singular values (k x m).

    A Jacobian whose entries are all negligible compared with the arm's reach has rank zero.
    """
    scale = sigma[:, 0].copy()
    small_scales = np.flatnonzero(scale < 1.0).tolist()
    if small_scales:
        reach = reach_lengths([samples[k].arm for k in small_scales])
        scale[small_scales] = np.maximum(scale[small_scales], np.minimum(reach, 1.0))
    return np.asarray(np.sum(sigma > RANK_TOLERANCE * scale[:, None], axis=1))


def _kinds_by_position(samples: Sequence[Sample], task: list[int]) -> np.ndarray:
    """Return the kinds of configurations by the position of their point.

    A corner of the reach is found only at certain configurations with the point there. Therefore, if a joint can rotate
    without moving the point, its rotations are tested too: if one of them is at the boundary, so is the configuration.
    """
    kinds = _kinds_by_motion(samples, task)
    if not samples or max(task) > 2:
        return kinds
    undecided = np.flatnonzero(kinds == "internal").tolist()
    for joint in range(1, min(len(samples[0].q), samples[0].arm.point_frame) if undecided else 0):
        if samples[0].arm.kinds[joint] == "R":
            rotated_samples = _rotate_joint([samples[k] for k in undecided], joint)
            rotatable = [k for k, rotations in zip(undecided, rotated_samples, strict=True) if rotations]
            all_kinds = iter(_kinds_by_motion([sample for rotations in rotated_samples for sample in rotations], task))
            for k in rotatable:
                rotation_kinds = [next(all_kinds) for _ in range(_ROTATION_COUNT)]
                kinds[k] = "boundary" if "boundary" in rotation_kinds else "internal"
            undecided = [k for k in undecided if k not in rotatable]
            if not undecided:
                break
    return kinds


def _rotate_joint(samples: Sequence[Sample], joint: int) -> list[list[Sample]]:
    """Return for each sample the samples that rotating a joint produces; none if that moves the point."""
    q = np.tile(np.stack([sample.q for sample in samples])[:, None], (1, _ROTATION_COUNT, 1))
    q[..., joint] = np.linspace(-np.pi, np.pi, _ROTATION_COUNT, endpoint=False)
    points = NumericChain.stack([sample.arm for sample in samples]).point(q)
    is_still = np.ptp(points, axis=1).max(axis=1) < RANK_TOLERANCE
    return [
        [Sample(sample.arm, configuration) for configuration in configurations] if stays else []
        for sample, configurations, stays in zip(samples, q, is_still, strict=True)
    ]


def _kinds_by_motion(samples: Sequence[Sample], task: list[int]) -> np.ndarray:
    """Return the kinds of configurations by their small motions and by the search for other configurations."""
    kinds = np.full(len(samples), "regular", dtype=object)
    if not samples:
        return kinds
    u, singular_values, vt = np.linalg.svd(jacobians_of(samples)[:, task])
    ranks = _ranks(singular_values, samples)
    for rank in sorted({int(rank) for rank in ranks if rank < singular_values.shape[1]}):
        indices = np.flatnonzero(ranks == rank)
        group = [samples[k] for k in indices.tolist()]
        bending = _compute_bending(group, task, vt[indices, rank:])
        is_edge = np.zeros(len(indices), dtype=bool)
        for lost in _lost_directions(u[indices, :, rank:], bending, is_square=len(task) <= vt.shape[1]):
            undecided = np.flatnonzero(~is_edge)
            if len(undecided):
                undecided_samples = [group[k] for k in undecided.tolist()]
                is_edge[undecided] = _are_at_boundary(undecided_samples, task, lost[undecided], bending[undecided])
        kinds[indices] = np.where(is_edge, "boundary", "internal")
    return kinds


def _lost_directions(lost_basis: np.ndarray, bending: "_Bending", is_square: bool) -> Iterator[np.ndarray]:
    """Yield lost directions of the samples (k x m), up to sign: the only one, or a selection of their combinations.

    If several directions are lost at once, the sample is at a boundary only if the reach folds in one of their
    combinations. At a corner of the reach only few combinations fold, and the blunter the corner, the fewer. Therefore
    the combination along which small motions reach the least comes first.
    """
    count = lost_basis.shape[2]
    if count == 1:
        if is_square:
            yield lost_basis[:, :, 0]
        return
    if count == 2:
        yield _least_reached_direction(lost_basis, bending)
    for weights in _unit_vectors(count):
        yield lost_basis @ weights


_DIRECTION_STEP = np.pi / 45
"""Angle (rad) between the combinations that are tried if two directions are lost."""
_RANDOM_DIRECTION_COUNT = 150
"""Number of combinations that are tried if more than two directions are lost."""


@lru_cache(maxsize=8)
def _unit_vectors(count: int) -> np.ndarray:
    """Return unit vectors in `count` dimensions, one of each pair of opposites (directions x count)."""
    if count == 2:
        return _vectors_at_angles(np.arange(0, np.pi, _DIRECTION_STEP))
    rng = Stream("directions")
    vectors = np.array([[rng.uniform(-1, 1) for _ in range(count)] for _ in range(_RANDOM_DIRECTION_COUNT)])
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _vectors_at_angles(angles: np.ndarray) -> np.ndarray:
    """Return the unit vectors (… x 2) at angles in a plane."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


_REFINEMENT_ROUNDS, _REFINEMENT_FACTOR = 6, 4.0
"""Number of rounds that refine the search for the least reached direction, and the refinement factor of each round."""


def _least_reached_direction(lost_basis: np.ndarray, bending: "_Bending") -> np.ndarray:
    """Return for each sample the combination of two lost directions along which small motions reach the least."""
    forms = np.stack([_quadratic_forms(lost_basis[..., column], bending) for column in range(2)])
    angles = np.tile(np.arange(0, 2 * np.pi, _DIRECTION_STEP), (len(lost_basis), 1))
    for round_number in range(_REFINEMENT_ROUNDS):
        leading = np.linalg.eigvalsh(np.einsum("kal,lkst->kast", _vectors_at_angles(angles), forms))[..., -1]
        best_angles = np.take_along_axis(angles, np.argmin(leading, axis=1)[:, None], axis=1)
        angles = best_angles + np.linspace(-_DIRECTION_STEP, _DIRECTION_STEP, 9) / _REFINEMENT_FACTOR**round_number
    return np.einsum("kml,kl->km", lost_basis, _vectors_at_angles(best_angles[:, 0]))


@dataclass(frozen=True)
class _Bending:
    """The joint motions that do not move the task, k x s x n (`joint_motions`), and the change of J along each of them.

    The `jacobian_changes` is k x s x rows of the task x n.
    """

    joint_motions: np.ndarray
    jacobian_changes: np.ndarray

    def __getitem__(self, indices: np.ndarray) -> "_Bending":
        return _Bending(self.joint_motions[indices], self.jacobian_changes[indices])


_DIFFERENCE_STEP = 1e-4
"""Step of the joint motions for finite differences."""


def _compute_bending(samples: Sequence[Sample], task: list[int], joint_motions: np.ndarray) -> _Bending:
    """Return the change of J along motions that do not move the task, by central differences.

    The differences are not divided by twice the step.
    """
    arms, q = NumericChain.stack([sample.arm for sample in samples]), np.stack([sample.q for sample in samples])
    directions = np.concatenate([joint_motions, -joint_motions], axis=1)
    forward, backward = np.split(arms.jacobian(q[:, None] + _DIFFERENCE_STEP * directions)[:, :, task], 2, axis=1)
    return _Bending(joint_motions, forward - backward)


def _are_at_boundary(
    samples: Sequence[Sample], task: list[int], lost_directions: np.ndarray, bending: _Bending
) -> np.ndarray:
    """Return for each sample whether no configuration reaches beyond it, on a side that small motions do not reach.

    A motion whose second-order effect is zero (a joint that moves nothing) is ignored. If all are, both sides are
    tested.
    """
    eigenvalues = np.linalg.eigvalsh(_quadratic_forms(lost_directions, bending))
    forward, backward = np.any(eigenvalues > 1e-5, axis=1), np.any(eigenvalues < -1e-5, axis=1)
    # The search is reliable only for a point that can move in as many directions as the task has rows.
    tests_both = max(task) < 3 and len(task) <= len(samples[0].q)
    is_edge = np.zeros(len(samples), dtype=bool)
    for sign, is_tested in ((1, ~forward & (backward | tests_both)), (-1, ~backward & (forward | tests_both))):
        indices = np.flatnonzero(is_tested & ~is_edge)
        if len(indices):
            tested = [samples[k] for k in indices.tolist()]
            is_edge[indices] = ~reaches_beyond(tested, task, sign * lost_directions[indices])
    return is_edge


def _quadratic_forms(directions: np.ndarray, bending: _Bending) -> np.ndarray:
    """Return the quadratic forms (k x s x s) of the second-order motion along a direction."""
    changes = np.einsum("km,ksmn->ksn", directions, bending.jacobian_changes) / (2 * _DIFFERENCE_STEP)
    halves = changes @ bending.joint_motions.swapaxes(1, 2)
    return np.asarray((halves + halves.swapaxes(1, 2)) / 2)
