"""Boundary or internal: what kind of singularity a configuration is, established by computation.

At a singular configuration let u span the directions that J cannot produce (u J = 0) and k the joint motions that do
not move the task (J k = 0). To second order the arm moves by u . (dJ/dk k) along u. If that has one sign for all k,
small motions reach one side of a surface only: the arm's reach folds back there. It is a boundary of the reach if,
besides, no other configuration leads to the far side; otherwise, and where the sign changes or the second-order
motion vanishes, the singularity is internal. Unlimited joint travel is assumed, as in the chapter.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from exercises.arm.appearance import meaning, wrist_centre
from exercises.arm.axes import Sample
from exercises.arm.chain import TASK_ROWS, Chain
from exercises.arm.derivation import derive
from exercises.arm.kinematics import NumericChain
from exercises.arm.reach import reaches_beside
from exercises.arm.singularity import Component
from exercises.formula.conditions import Space
from exercises.formula.expression import read
from exercises.formula.identity import Domain
from exercises.formula.pieces import Piece, pieces
from exercises.stream import Stream

__all__ = [
    "Kind", "classify", "classify_pieces", "domain_of", "kind_at", "kind_is_sure", "samples_on",
    "wrist_centre",
]  # fmt: skip

REGULAR = 1e-7
"""A singular value counts as zero below this part of the largest."""

_STARTS, _STEPS = 80, 40
_EARLY, _KEPT = 8, 20
"""Searches for a configuration beyond a fold; after `_EARLY` steps only the `_KEPT` nearest go on."""

_LOOKED_AT = 60
"""About how many samples are looked at to say what they have in common."""
_ARMS = 5
"""Choices of lengths for each length that is open."""

_TURNS = 24
"""Turns of a joint that does not move the point, at which a corner of the reach is looked for."""

_BEYOND = 1e-4
"""How far beyond a fold that is, of the reach: less than the hole that a folded arm leaves."""


@dataclass(frozen=True)
class Kind:
    """What a set of singular configurations is: kind, whether all of it is of that kind, and what it looks like.

    The kind is empty where it can't be established (`kind_is_sure`), so that it is told nowhere.
    """

    kind: str
    uniform: bool
    meaning: str


def domain_of(chain: Chain, values: Mapping[str, float] | None = None) -> Domain:
    """Return the domain of a chain's symbols: joints, rates, task velocity, open lengths, and given values."""
    roles: dict[str, str | float] = {}
    for joint, q, rate in zip(chain.joints, chain.q, chain.rates, strict=True):
        roles[q.name] = "angle" if joint.kind == "R" else "signed"
        roles[rate.name] = "signed"
    roles.update(dict.fromkeys(TASK_ROWS, "signed"))
    for symbol in chain.parameters:
        roles[symbol.name] = "angle" if symbol.name.startswith(("alpha", "beta")) else "length"
    return Domain({**roles, **(values or {})})


def samples_on(chain: Chain, condition: str, seed: str, arms: int = 5, each: int = 3) -> list[Sample]:
    """Return configurations at which `condition` (text) holds, for several choices of the open lengths."""
    return list(_samples(chain, condition, seed, arms, each))


@lru_cache(maxsize=256)
def _samples(chain: Chain, condition: str, seed: str, arms: int, each: int) -> tuple[Sample, ...]:
    """Return the same, kept: a component is looked at whole and then value by value, which are the same conditions."""
    joints = [q.name for q in chain.q]
    samples = []
    for number in range(arms):
        stream = Stream(f"{seed}/{condition}/{number}")
        values = _apart(chain, stream)
        space = Space(joints, domain_of(chain, values))
        arm = NumericChain(chain, values)
        for piece in pieces(read(condition), joints):
            samples += _configurations(space, piece, joints, stream, each, arm)
    return tuple(samples)


def _apart(chain: Chain, stream: Stream) -> dict[str, float]:
    """Draw lengths for those left open, none near another or a given one: equal lengths are a special case."""
    given = [joint.a for joint in chain.joints] + [j.d for j in chain.joints if j.kind == "R"]
    taken = [abs(float(length)) for length in given if length.is_number]
    values = {}
    for symbol in chain.parameters:
        drawn = [round(0.4 * 3.5 ** stream.uniform(0, 1), 3) for _ in range(5)]
        value = next((v for v in drawn if all(abs(v - other) > 0.01 for other in taken)), drawn[-1])
        values[symbol.name] = value
        taken.append(value)
    return values


def _configurations(
    space: Space, piece: Piece, joints: Sequence[str], stream: Stream, each: int, arm: NumericChain
) -> list[Sample]:
    values = space.on_piece(piece, space.names_of([[piece]]), stream, count=3 * each)
    columns = np.array([values[joint] for joint in joints])
    return [Sample(arm, columns[:, i]) for i in range(min(each, columns.shape[1]))]


def classify(chain: Chain, component: Component) -> Kind:
    """Classify a component of the singular set over samples of its configurations and of the open lengths.

    Where some configurations are boundary and some internal, `kind` is "boundary" and `uniform` is False.
    """
    return classify_pieces(chain, component.pieces())


def classify_pieces(chain: Chain, conditions: Sequence[str]) -> Kind:
    """Classify the union of conditions (text), as `classify` does for a component."""
    arms = _ARMS * max(1, len(chain.parameters))  # the kind may depend on how open lengths compare
    all_samples = [sample for condition in conditions for sample in samples_on(chain, condition, "classify", arms)]
    words = meaning(chain, all_samples[:: max(1, len(all_samples) // _LOOKED_AT)])
    if not kind_is_sure(chain):
        return Kind("", False, words)
    kinds = {kind for sample in all_samples if (kind := kind_at(chain, sample)) is not None}
    return Kind("boundary" if "boundary" in kinds else "internal", len(kinds) == 1, words)


def kind_is_sure(chain: Chain) -> bool:
    """Whether boundary or internal can be established, and means something: else nothing is asked or told of it.

    It can for up to four rows, and for all six of an arm with a spherical wrist; for others the search for
    configurations beyond a fold is no proof. It means something where the rows are rates of coordinates, which have a
    reach: an angular velocity has none, but an orientation, or one angle about a fixed axis, has. With more rows than
    joints the reach is a surface, to whose boundary no one would think of.
    """
    if chain.n == 6 and set(chain.task) == set(TASK_ROWS):
        return wrist_centre(chain) is not None
    return len(chain.task) <= min(4, chain.n) and _has_coordinates(chain)


def _has_coordinates(chain: Chain) -> bool:
    """Whether the angular rows of the task are all three, or the only one about which the arm turns at all."""
    turns = [row for row in chain.task if row[0] == "w"]
    if len(turns) in (0, 3):
        return True
    return len(turns) == 1 and all(
        row in turns or derive(chain).geometric[i, :].is_zero_matrix for i, row in enumerate(TASK_ROWS) if row[0] == "w"
    )


def kind_at(chain: Chain, sample: Sample) -> str | None:
    """Return "regular", "boundary" or "internal" for one configuration; None where more rank is lost than nearby.

    A hand on a spherical wrist is at the boundary where the wrist's centre is at the boundary of what the arm reaches:
    the wrist itself reaches every orientation.
    """
    return _kept_kind(chain, sample.arm, tuple(sample.q.tolist()))


@lru_cache(maxsize=1024)
def _kept_kind(chain: Chain, arm: NumericChain, q: tuple[float, ...]) -> str | None:
    """Return the same; kept, as samples are (see `_samples`)."""
    sample = Sample(arm, np.array(q))
    task = [TASK_ROWS.index(row) for row in chain.task]
    carrying = _without_wrist(chain, sample)
    if carrying is not None:
        if _rank(sample.arm.jacobian(sample.q), _reach(sample.arm)) == 6:
            return "regular"
        kind = _kind_of_place(carrying, [0, 1, 2])
        return "internal" if kind == "regular" else kind
    return _kind_of_place(sample, task)


def _without_wrist(chain: Chain, sample: Sample) -> Sample | None:
    """Return the first three joints of an arm of six with a spherical wrist, their point being the wrist's centre."""
    if chain.n != 6 or set(chain.task) != set(TASK_ROWS) or wrist_centre(chain) is None:
        return None
    if any(abs(np.cos(sample.arm.fixed[joint][2])) > REGULAR for joint in (3, 4)):
        return None  # such a wrist does not reach every orientation
    return Sample(sample.arm.first(3, (0.0, 0.0, sample.arm.fixed[3][0])), sample.q[:3])


def _rank(jacobian: np.ndarray, reach: float) -> int:
    """Return the rank; a Jacobian whose entries are all next to nothing, against the arm's reach, has rank zero."""
    return _rank_by(np.linalg.svd(jacobian, compute_uv=False), reach)


def _rank_by(sigma: np.ndarray, reach: float) -> int:
    """Return the rank of a Jacobian with these singular values."""
    return int(np.sum(sigma > REGULAR * max(sigma[0], min(reach, 1.0))))


def _kind_of_place(sample: Sample, task: list[int]) -> str | None:
    """Return the kind of a configuration; where a joint can turn without moving the point, of the worst it turns to.

    Boundary or not is a matter of where the point is. A corner of the reach is seen from some of its configurations, so
    that those that are looked at are the same for all configurations with the point there.
    """
    kind = _kind_seen(sample, task)
    if kind != "internal" or max(task) > 2:
        return kind
    for joint in range(1, min(len(sample.q), sample.arm.point_frame)):
        turned = np.tile(sample.q, (_TURNS, 1))
        turned[:, joint] = np.linspace(-np.pi, np.pi, _TURNS, endpoint=False)
        places = sample.arm.point(turned)
        if sample.arm.kinds[joint] == "R" and np.ptp(places, axis=0).max() < REGULAR:
            kinds = (_kind_seen(Sample(sample.arm, q), task) for q in turned)
            return "boundary" if any(each == "boundary" for each in kinds) else "internal"
    return kind


def _kind_seen(sample: Sample, task: list[int]) -> str | None:
    """Return the kind that a configuration shows by its own small motions and by the search for others."""
    jacobian = sample.arm.jacobian_of(sample.frames)[task]
    u, sigma, vt = np.linalg.svd(jacobian)
    rank = _rank_by(sigma, 1.0 if sigma[0] >= 1.0 else _reach(sample.arm))
    if rank == min(jacobian.shape):
        return "regular"
    lost, still = u[:, rank:], vt[rank:]
    if jacobian.shape[0] > jacobian.shape[1] or lost.shape[1] > 1:
        return "internal" if lost.shape[1] == 1 else _kind_of_many(sample, task, lost, still)
    return "boundary" if _is_edge(sample, task, lost[:, 0], _bending(sample, task, still)) else "internal"


def _kind_of_many(sample: Sample, task: list[int], lost: np.ndarray, still: np.ndarray) -> str | None:
    """Several directions are lost at once: a boundary only if one of them folds."""
    stream, bending = Stream("directions"), _bending(sample, task, still)
    for _ in range(12):
        direction = lost @ np.array([stream.uniform(-1, 1) for _ in range(lost.shape[1])])
        if _is_edge(sample, task, direction / np.linalg.norm(direction), bending):
            return "boundary"
    return "internal"


_Bending = tuple[np.ndarray, np.ndarray]
"""Still motions (rows), and for each how J changes along it (rows of the task x n)."""


def _is_edge(sample: Sample, task: list[int], lost: np.ndarray, bending: _Bending) -> bool:
    """Tell whether no configuration reaches beyond the place, on a side to which small motions do not lead.

    A still motion of second order zero (a joint that moves nothing) takes no part; if all are, either side may be
    the far one.
    """
    forward, backward = _folds(lost, *bending)
    if forward or backward:
        sides = [] if forward and backward else [-lost] if forward else [lost]
    else:
        # The search is sure for a point that can move in as many directions as are counted, and only for that.
        sides = [lost, -lost] if max(task) < 3 and len(task) <= len(sample.q) else []
    return any(not _reached_beyond(sample, task, side) for side in sides)


_STEP = 1e-4


def _bending(sample: Sample, task: list[int], still: np.ndarray) -> _Bending:
    """Return how J changes along still motions, by central differences, twice the step not yet divided out."""
    ahead, behind = sample.arm.jacobian(sample.q + _STEP * np.array([still, -still]))[:, :, task]
    return still, ahead - behind


def _folds(lost: np.ndarray, still: np.ndarray, change: np.ndarray) -> tuple[bool, bool]:
    """Tell whether still motions lead, to second order, forward along `lost`, and whether they lead backward."""
    form = lost @ change / (2 * _STEP) @ still.T
    eigenvalues = np.linalg.eigvalsh((form + form.T) / 2)
    return bool(np.any(eigenvalues > 1e-5)), bool(np.any(eigenvalues < -1e-5))


def _reached_beyond(sample: Sample, task: list[int], direction: np.ndarray) -> bool:
    """Tell whether some configuration reaches a place just beyond the fold.

    A formula says it for simple arms, at once and for sure; for others, damped Newton from many starts.
    """
    frames = sample.frames
    reach = _reach(sample.arm)
    linear = [row < 3 for row in task]
    shift = _BEYOND * reach * direction * np.array([1.0 if is_linear else 1.0 / reach for is_linear in linear])
    known = reaches_beside(sample.arm, frames, task, shift)
    if known is not None:
        return known
    target_point = sample.arm.point_of(frames)
    rotation = frames[-1, :3, :3]
    q = _starts(len(sample.q)).copy()
    for step in range(_STEPS):
        now = sample.arm.frames(q)
        error = np.concatenate([target_point - sample.arm.point_of(now), _turn(rotation, now[:, -1, :3, :3])], axis=1)
        residual = error[:, task] + shift
        distance = np.linalg.norm(residual, axis=1)
        if np.any(distance < 1e-6 * reach):
            return True
        if step == _EARLY:
            kept = np.argsort(distance, kind="stable")[:_KEPT]
            q, residual, now = q[kept], residual[kept], now[kept]
        jacobian = sample.arm.jacobian_of(now)[:, task]
        square = jacobian @ jacobian.transpose(0, 2, 1) + 1e-9 * np.eye(len(task))
        move = (jacobian.transpose(0, 2, 1) @ np.linalg.solve(square, residual[:, :, None]))[:, :, 0]
        q += move * np.minimum(1.0, 0.6 / np.maximum(np.abs(move).max(axis=1, keepdims=True), 1e-12))
    return False


@lru_cache(maxsize=64)
def _starts(n: int) -> np.ndarray:
    stream = Stream("starts")
    return np.array([[stream.uniform(-np.pi, np.pi) for _ in range(n)] for _ in range(_STARTS)])


@lru_cache(maxsize=256)
def _reach(arm: NumericChain) -> float:
    """Return the usual length of all links one after another, against which distances are judged."""
    links = np.diff(arm.frames(_starts(len(arm.kinds)))[:, :, :3, 3], axis=1)
    return float(np.median(np.linalg.norm(links, axis=2).sum(axis=1))) + 1e-9


def _turn(target: np.ndarray, now: np.ndarray) -> np.ndarray:
    """Return the small rotation vectors that bring orientations `now` (… x 3 x 3) to `target`."""
    between = target @ now.transpose(0, 2, 1)
    antisymmetric = (between - between.transpose(0, 2, 1)) / 2
    return np.stack([antisymmetric[:, 2, 1], antisymmetric[:, 0, 2], antisymmetric[:, 1, 0]], axis=1)
