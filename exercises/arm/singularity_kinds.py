"""Boundary or internal: what kind of singularity a configuration is, established by computation.

At a singular configuration let u span the directions that J cannot produce (u J = 0) and k the joint motions that do
not move the task (J k = 0). To second order the arm moves by u . (dJ/dk k) along u. If that has one sign for all k,
small motions reach one side of a surface only: the arm's reach folds back there. It is a boundary of the reach if,
besides, no other configuration leads to the far side; otherwise, and where the sign changes or the second-order
motion vanishes, the singularity is internal. Unlimited joint travel is assumed, as in the chapter.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.appearance import wrist_centre
from qdot.exercises.arm.axes import Sample, jacobians_of
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.reach import reach_lengths, reaches_beyond
from qdot.exercises.common.stream import Stream

REGULAR = 1e-7
"""A singular value counts as zero below this part of the largest."""

_TURNS = 24
"""Turns of a joint that does not move the point, at which a corner of the reach is looked for."""


def kind_is_sure(chain: Chain) -> bool:
    """Tell whether boundary or internal can be established, and is meaningful; otherwise it is never asked or reported.

    It can be established for up to four rows, and for all six of an arm with a spherical wrist; for others the search
    for configurations beyond a fold is no proof. It is meaningful if the rows are rates of coordinates, which have a
    reach: an angular velocity has none, but an orientation, or one angle about a fixed axis, has. With more rows than
    joints the reach is a surface, whose boundary nobody would think of.
    """
    if chain.n == 6 and set(chain.task) == set(TASK_ROWS):
        return wrist_centre(chain) is not None
    return len(chain.task) <= min(4, chain.n) and _has_coordinates(chain)


def _has_coordinates(chain: Chain) -> bool:
    """Tell whether the task has all three angular rows, or only the one about which the arm rotates at all."""
    turns = [row for row in chain.task if row[0] == "w"]
    if len(turns) in (0, 3):
        return True
    return len(turns) == 1 and all(
        row in turns or derive(chain).geometric[i, :].is_zero_matrix for i, row in enumerate(TASK_ROWS) if row[0] == "w"
    )


def kind_at(chain: Chain, sample: Sample) -> str:
    """Return "regular", "boundary" or "internal" for one configuration."""
    return kinds_at(chain, [sample])[0]


def are_one_sided(chain: Chain, samples: Sequence[Sample]) -> bool:
    """Tell whether each configuration loses one direction only, on one side of which nothing can be reached.

    It is not so at a boundary if a joint can rotate without moving the point, and brings the arm to the edge with that.
    """
    rows = chain.task_rows
    if _has_free_orientation(chain):
        samples, rows = _arms_before_wrist(samples), [0, 1, 2]
    if not samples:
        return False
    sigma = np.linalg.svd(jacobians_of(samples)[:, rows], compute_uv=False)
    return set(_ranks(sigma, samples)) == {len(rows) - 1} and set(_kinds_by_motion(samples, rows)) == {"boundary"}


def kinds_at(chain: Chain, samples: Sequence[Sample]) -> list[str]:
    """Return the kind of many configurations of arms of one structure, faster than one by one.

    A hand on a spherical wrist is at the boundary if the wrist's centre is at the boundary of its reach: the wrist
    itself reaches every orientation.
    """
    if not _has_free_orientation(chain):
        return list(_kinds_of_places(samples, chain.task_rows))
    kinds = np.full(len(samples), "regular", dtype=object)
    singular = [k for k, sample in enumerate(samples) if _is_singular(sample)]
    of_wrist_centre = _kinds_of_places(_arms_before_wrist([samples[k] for k in singular]), [0, 1, 2])
    kinds[singular] = np.where(of_wrist_centre == "boundary", "boundary", "internal")
    return list(kinds)


def _has_free_orientation(chain: Chain) -> bool:
    """Tell whether an arm of six joints has a spherical wrist with axes at right angles: it has all orientations."""
    is_whole = chain.n == 6 and set(chain.task) == set(TASK_ROWS) and wrist_centre(chain) is not None
    return is_whole and all(sp.cos(chain.joints[i].alpha) == 0 for i in (3, 4))


def _arms_before_wrist(samples: Sequence[Sample]) -> list[Sample]:
    """Return the first three joints of six-joint arms with a spherical wrist; their point is the wrist's centre."""
    return [Sample(s.arm.first_joints(3, (0.0, 0.0, s.arm.fixed[3][0])), s.q[:3]) for s in samples]


def _is_singular(sample: Sample) -> bool:
    """Tell whether a Jacobian of six rows and columns loses rank."""
    sigma = np.linalg.svd(sample.arm.jacobian(sample.q), compute_uv=False)
    return bool(_ranks(sigma[None], [sample])[0] < len(sigma))


def _ranks(sigma: np.ndarray, samples: Sequence[Sample]) -> np.ndarray:
    """Return the ranks of Jacobians with these singular values (k x m).

    A Jacobian whose entries are all negligible compared with the arm's reach has rank zero.
    """
    scale = sigma[:, 0].copy()
    short = np.flatnonzero(scale < 1.0).tolist()
    if short:
        scale[short] = np.maximum(scale[short], np.minimum(reach_lengths([samples[k].arm for k in short]), 1.0))
    return np.asarray(np.sum(sigma > REGULAR * scale[:, None], axis=1))


def _kinds_of_places(samples: Sequence[Sample], task: list[int]) -> np.ndarray:
    """Return the kinds of configurations; if a joint can rotate without moving the point, of the worst it rotates to.

    Boundary or not depends only on where the point is. A corner of the reach shows only at some configurations, so the
    same configurations are tested for every configuration with the point there.
    """
    kinds = _kinds_by_motion(samples, task)
    if not samples or max(task) > 2:
        return kinds
    open_places = np.flatnonzero(kinds == "internal").tolist()
    for joint in range(1, min(len(samples[0].q), samples[0].arm.point_frame) if open_places else 0):
        if samples[0].arm.kinds[joint] == "R":
            rotated_samples = _rotate_joint([samples[k] for k in open_places], joint)
            still = [k for k, poses in zip(open_places, rotated_samples, strict=True) if poses]
            seen = iter(_kinds_by_motion([sample for poses in rotated_samples for sample in poses], task))
            for k in still:
                worst = [next(seen) for _ in range(_TURNS)]
                kinds[k] = "boundary" if "boundary" in worst else "internal"
            open_places = [k for k in open_places if k not in still]
            if not open_places:
                break
    return kinds


def _rotate_joint(samples: Sequence[Sample], joint: int) -> list[list[Sample]]:
    """Return for each sample the samples that a joint rotates it to, if that does not move the point."""
    q = np.tile(np.stack([sample.q for sample in samples])[:, None], (1, _TURNS, 1))
    q[..., joint] = np.linspace(-np.pi, np.pi, _TURNS, endpoint=False)
    places = NumericChain.stack([sample.arm for sample in samples]).point(q)
    still = np.ptp(places, axis=1).max(axis=1) < REGULAR
    return [
        [Sample(sample.arm, pose) for pose in poses] if stays else []
        for sample, poses, stays in zip(samples, q, still, strict=True)
    ]


def _kinds_by_motion(samples: Sequence[Sample], task: list[int]) -> np.ndarray:
    """Return the kinds of configurations by their small motions and by the search for other configurations."""
    kinds = np.full(len(samples), "regular", dtype=object)
    if not samples:
        return kinds
    u, sigma, vt = np.linalg.svd(jacobians_of(samples)[:, task])
    ranks = _ranks(sigma, samples)
    for rank in sorted({int(rank) for rank in ranks if rank < sigma.shape[1]}):
        at = np.flatnonzero(ranks == rank)
        places = [samples[k] for k in at.tolist()]
        bending = _bending(places, task, vt[at, rank:])
        is_edge = np.zeros(len(at), dtype=bool)
        for lost in _lost_directions(u[at, :, rank:], bending, is_square=len(task) <= vt.shape[1]):
            rest = np.flatnonzero(~is_edge)
            if len(rest):
                remaining_bending = _Bending(bending.still[rest], bending.change[rest])
                is_edge[rest] = _are_edges([places[k] for k in rest.tolist()], task, lost[rest], remaining_bending)
        kinds[at] = np.where(is_edge, "boundary", "internal")
    return kinds


def _lost_directions(lost: np.ndarray, bending: "_Bending", is_square: bool) -> Iterator[np.ndarray]:
    """Yield lost directions of each sample (k x m), up to sign: the only one, else a selection in all directions.

    If several are lost at once, it is a boundary only if one of them folds. At a corner of the reach few do, the
    blunter the corner the fewer: the one farthest from all that small motions reach comes first.
    """
    count = lost.shape[2]
    if count == 1:
        if is_square:
            yield lost[:, :, 0]
        return
    if count == 2:
        yield _least_reached_direction(lost, bending)
    for mixed in _unit_vectors(count):
        yield lost @ mixed


_APART = np.pi / 45
"""Angle between the directions that are tried if two are lost."""
_TRIED = 150
"""Directions that are tried if more are lost."""


@lru_cache(maxsize=8)
def _unit_vectors(count: int) -> np.ndarray:
    """Return unit vectors in `count` dimensions, one of each pair of opposites (directions x count)."""
    if count == 2:
        return _vectors_at_angles(np.arange(0, np.pi, _APART))
    stream = Stream("directions")
    every = np.array([[stream.uniform(-1, 1) for _ in range(count)] for _ in range(_TRIED)])
    return np.asarray(every / np.linalg.norm(every, axis=1, keepdims=True))


def _vectors_at_angles(angles: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


_ROUNDS, _CLOSER = 6, 4.0
"""Rounds in which the search for the farthest direction is refined, and by which factor each."""


def _least_reached_direction(lost: np.ndarray, bending: "_Bending") -> np.ndarray:
    """Return for each sample the combination of its two lost directions along which small motions reach the least."""
    forms = np.stack([_quadratic_forms(lost[..., column], bending) for column in range(2)])
    angles = np.tile(np.arange(0, 2 * np.pi, _APART), (len(lost), 1))
    for round_number in range(_ROUNDS):
        leading = np.linalg.eigvalsh(np.einsum("kal,lkst->kast", _vectors_at_angles(angles), forms))[..., -1]
        best = np.take_along_axis(angles, np.argmin(leading, axis=1)[:, None], axis=1)
        angles = best + np.linspace(-_APART, _APART, 9) / _CLOSER**round_number
    return np.einsum("kml,kl->km", lost, _vectors_at_angles(best[:, 0]))


@dataclass(frozen=True)
class _Bending:
    """Still motions of samples (k x s x n), and for each how J changes along it (k x s x rows of the task x n)."""

    still: np.ndarray
    change: np.ndarray


_STEP = 1e-4


def _bending(samples: Sequence[Sample], task: list[int], still: np.ndarray) -> _Bending:
    """Return how J changes along still motions, by central differences, not yet divided by twice the step."""
    arms, q = NumericChain.stack([sample.arm for sample in samples]), np.stack([sample.q for sample in samples])
    ways = np.concatenate([still, -still], axis=1)
    ahead, behind = np.split(arms.jacobian(q[:, None] + _STEP * ways)[:, :, task], 2, axis=1)
    return _Bending(still, ahead - behind)


def _are_edges(samples: Sequence[Sample], task: list[int], lost: np.ndarray, bending: _Bending) -> np.ndarray:
    """Tell whether no configuration reaches beyond each place, on a side to which small motions do not lead.

    A still motion of second order zero (a joint that moves nothing) takes no part; if all are, either side may be
    the far one.
    """
    forward, backward = _folds(lost, bending)
    # The search is reliable only for a point that can move in as many directions as the task counts.
    either = max(task) < 3 and len(task) <= len(samples[0].q)
    is_edge = np.zeros(len(samples), dtype=bool)
    for side, asked in ((1, ~forward & (backward | either)), (-1, ~backward & (forward | either))):
        at = np.flatnonzero(asked & ~is_edge)
        if len(at):
            is_edge[at] = ~reaches_beyond([samples[k] for k in at.tolist()], task, side * lost[at])
    return is_edge


def _folds(lost: np.ndarray, bending: _Bending) -> tuple[np.ndarray, np.ndarray]:
    """Tell whether still motions lead, to second order, forward along `lost`, and whether they lead backward."""
    eigenvalues = np.linalg.eigvalsh(_quadratic_forms(lost, bending))
    return np.any(eigenvalues > 1e-5, axis=1), np.any(eigenvalues < -1e-5, axis=1)


def _quadratic_forms(along: np.ndarray, bending: _Bending) -> np.ndarray:
    """Return the quadratic forms (k x s x s) of the second-order motion along directions by still motions."""
    halves = np.einsum("km,ksmn->ksn", along, bending.change) / (2 * _STEP) @ bending.still.swapaxes(1, 2)
    return np.asarray((halves + halves.swapaxes(1, 2)) / 2)
