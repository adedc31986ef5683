"""Boundary or internal: what kind of singularity a configuration is, established by computation.

At a singular configuration let u span the directions that J cannot produce (u J = 0) and k the joint motions that do
not move the task (J k = 0). To second order the arm moves by u . (dJ/dk k) along u. If that has one sign for all k,
small motions reach one side of a surface only: the arm's reach folds back there. It is a boundary of the reach if,
besides, no other configuration leads to the far side; otherwise, and where the sign changes or the second-order
motion vanishes, the singularity is internal. Unlimited joint travel is assumed, as in the chapter.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import sympy as sp

from exercises.arm.appearance import meaning, wrist_centre
from exercises.arm.axes import Sample
from exercises.arm.bare import bare, bare_pieces
from exercises.arm.beyond import reached_beyond, reaches_of
from exercises.arm.chain import TASK_ROWS, Chain
from exercises.arm.derivation import derive
from exercises.arm.kinematics import NumericChain
from exercises.arm.lengths import are_unrelated, with_open_lengths
from exercises.arm.singularity import Component, singular_set
from exercises.arm.trigonometry import substitute
from exercises.formula.conditions import Space
from exercises.formula.expression import read
from exercises.formula.identity import Domain
from exercises.formula.pieces import Piece, pieces
from exercises.stream import Stream

__all__ = [
    "Kind", "Values", "by_value", "classify", "classify_pieces", "domain_of", "kind_at", "kind_is_sure", "kinds_at",
    "part_at", "samples_on", "seen_on", "wrist_centre",
]  # fmt: skip

REGULAR = 1e-7
"""A singular value counts as zero below this part of the largest."""

_LOOKED_AT = 60
"""About how many samples are looked at to say what they have in common: few may all miss where it is not so."""
_KIND_AT = 2
"""Of how many of these one is asked for its kind, which takes longer."""
_PARTS = 3
"""In how many parts these are looked at."""
_FURTHER = 60
"""Further choices of open lengths of which the kind is looked at, before it is told of all."""
_ARMS = 5
"""Choices of lengths for each length that is open."""
_LEAST_ARMS = 3
"""As many as for so many open lengths are there of fewer."""

_MOST_VALUES = 4
"""Of more combinations of joint values nobody wants to read one after the other."""

_ARM = "number of the arm"
"""The name under which a configuration says whose it is."""

_TURNS = 24
"""Turns of a joint that does not move the point, at which a corner of the reach is looked for."""


@dataclass(frozen=True)
class Kind:
    """What a set of singular configurations is: kind, whether all of it is of that kind, and what it looks like.

    The kind is empty where it can't be established (`kind_is_sure`), or no configuration was found of which it is
    known, so that it is told nowhere.
    """

    kind: str
    uniform: bool
    meaning: str


def domain_of(chain: Chain, values: Mapping[str, float | np.ndarray] | None = None, slides: str = "signed") -> Domain:
    """Return the domain of a chain's symbols: joints, rates, task velocity, open lengths, and given values.

    `slides` is the role of slides: "signed", where answers are compared, or "travel", as far as any arm reaches.
    """
    roles: dict[str, str | float | np.ndarray] = {}
    for joint, q, rate in zip(chain.joints, chain.q, chain.rates, strict=True):
        roles[q.name] = "angle" if joint.kind == "R" else slides
        roles[rate.name] = "signed"
    roles.update(dict.fromkeys(TASK_ROWS, "signed"))
    for symbol in chain.parameters:
        roles[symbol.name] = "angle" if symbol.name.startswith(("alpha", "beta")) else "length"
    return Domain({**roles, **(values or {})})


def samples_on(chain: Chain, condition: str, seed: str, arms: int = 5, each: int = 3) -> list[Sample]:
    """Return configurations at which `condition` (text) holds, for several choices of the open lengths."""
    return list(_samples(chain, condition, seed, arms, each))


@lru_cache(maxsize=64)
def _samples(chain: Chain, condition: str, seed: str, arms: int, each: int) -> tuple[Sample, ...]:
    """Return the same, kept: a component is looked at whole and then value by value, which are the same conditions."""
    found: list[list[Sample]] = [[] for _ in range(arms)]
    slides = any(joint.kind == "P" for joint in chain.joints)
    # far out, an arm may be at the boundary where it is not with its slides drawn in
    for first, role in ((0, "signed"), (1, "travel")) if slides else ((0, "signed"),):
        stream = Stream(f"{seed}/{condition}/{first}")
        numbers = range(first, arms, 2 if slides else 1)
        values = [_apart(chain, stream) for _ in numbers]
        for piece in pieces(read(condition), [q.name for q in chain.q]) if values else ():
            for number, samples in zip(numbers, _configurations(chain, piece, values, role, stream, each), strict=True):
                found[number] += samples
    return tuple(sample for samples in found for sample in samples)


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
    chain: Chain, piece: Piece, values: Sequence[Mapping[str, float]], role: str, stream: Stream, each: int
) -> list[list[Sample]]:
    """Return up to so many configurations of each of some arms, told by their open lengths; worked out all at once."""
    joints, lengths = [q.name for q in chain.q], [symbol.name for symbol in chain.parameters]
    count = 3 * each
    roles = {name: np.repeat([value[name] for value in values], count) for name in lengths}
    space = Space(joints, domain_of(chain, {**roles, _ARM: np.repeat(np.arange(len(values)), count)}, role))
    there = space.on_piece(piece, {*space.names_of([[piece]]), _ARM}, stream, count=count * len(values))
    columns = np.array([there[joint] for joint in joints]).T
    found = []
    for number, value in enumerate(values):
        arm = NumericChain(chain, value)
        found.append([Sample(arm, q) for q in columns[there[_ARM] == number][:each]])
    return found


def classify(chain: Chain, component: Component) -> Kind:
    """Classify a component of the singular set over samples of its configurations and of the open lengths.

    Where some configurations are boundary and some internal, `kind` is "boundary" and `uniform` is False. It is
    established for the structure, for all lengths at once; where that gives several answers, for the bare arm, once for
    all arms that have the same.
    """
    arm, conditions = bare(chain), tuple(bare_pieces(chain, component))
    general, known = in_general(chain)
    if all(condition in known for condition in conditions):
        kind = _whatever_the_lengths(general, tuple(known[condition] for condition in conditions))
        if kind is not None:
            return kind if kind.uniform or not kind.kind else replace(kind, **_kind_of(arm, conditions))
    return _classified(arm, conditions)


@lru_cache(maxsize=1024)
def in_general(chain: Chain) -> tuple[Chain, Mapping[str, str]]:
    """Return the bare arm with open lengths in place of given ones, and each condition on it that it has in common with
    the arm's own, as text, under the text of that one; none where the given lengths are special.
    """
    general, given = with_open_lengths(chain)
    counted = [value for symbol, value in given.items() if symbol in bare(general).parameters]
    found = {}
    for component in singular_set(general) or () if counted and are_unrelated(counted) else ():
        for part in _parts(component):
            (piece,) = bare_pieces(general, part)
            (own,) = bare_pieces(bare(chain), _filled(part, given))
            found[own] = piece
    return bare(general), found


def _parts(component: Component) -> list[Component]:
    """Return what a component is at each combination of values of joints; itself, if they are not told."""
    if component.solutions is None:
        return [component]
    joints, values = zip(*component.solutions, strict=True)
    return [part_at(component, tuple(zip(joints, each, strict=True))) for each in product(*values)]


def _filled(component: Component, lengths: Mapping[sp.Symbol, sp.Expr]) -> Component:
    """Return a component with numbers for lengths."""
    conditions = tuple(substitute(condition, lengths) for condition in component.conditions)
    if component.solutions is None:
        return Component(conditions, None)
    solutions = ((q, tuple(substitute(value, lengths) for value in values)) for q, values in component.solutions)
    return Component(conditions, tuple(solutions))


@lru_cache(maxsize=4096)
def _whatever_the_lengths(chain: Chain, conditions: tuple[str, ...]) -> Kind | None:
    """Return what conditions are for all lengths, where each of them looks like one thing; else None."""
    kind = _classified(chain, conditions)
    if len(conditions) > 1:
        return kind if all(_whatever_the_lengths(chain, (condition,)) for condition in conditions) else None
    return None if " or " in kind.meaning else kind


Values = tuple[tuple[sp.Symbol, sp.Expr], ...]
"""Joints with their values."""


def by_value(component: Component, kind: Kind) -> list[tuple[Values, Component]]:
    """Return a component's values of its joints, each with the part that it is, where more is to be said than of all.

    That is where it looks like this or like that, or is of both kinds.
    """
    if component.solutions is None or not (" or " in kind.meaning or (kind.kind and not kind.uniform)):
        return []
    joints, values = zip(*component.solutions, strict=True)
    chosen = [tuple(zip(joints, each, strict=True)) for each in product(*values)]
    if not 1 < len(chosen) <= _MOST_VALUES:
        return []
    return [(each, part_at(component, each)) for each in chosen]


def part_at(component: Component, values: Values) -> Component:
    """Return the part of a component at which joints have these values."""
    return replace(component, solutions=tuple((joint, (value,)) for joint, value in values))


def classify_pieces(chain: Chain, conditions: Sequence[str]) -> Kind:
    """Classify the union of conditions (text), as `classify` does for a component."""
    return _classified(chain, tuple(conditions))


@lru_cache(maxsize=4096)
def _classified(chain: Chain, conditions: tuple[str, ...]) -> Kind:
    return Kind(**_kind_of(chain, conditions), meaning=meaning(chain, seen_on(chain, conditions)))


@lru_cache(maxsize=4096)
def _kind_of(chain: Chain, conditions: tuple[str, ...]) -> Mapping[str, Any]:
    """Return `kind` and `uniform` of conditions; as soon as both kinds are seen, nothing more can be."""
    kinds: set[str] = set()
    if kind_is_sure(chain):
        seen = seen_on(chain, conditions)[::_KIND_AT]
        kinds = _kinds_among(chain, [seen[first::_PARTS] for first in range(_PARTS)])
    if len(kinds) == 1 and chain.parameters:  # of other lengths it may be another
        others = [one for condition in conditions for one in samples_on(chain, condition, "lengths", _FURTHER, 1)]
        kinds |= _kinds_among(chain, [others])
    return {"kind": "boundary" if "boundary" in kinds else "internal" if kinds else "", "uniform": len(kinds) == 1}


def _kinds_among(chain: Chain, parts: Sequence[Sequence[Sample]]) -> set[str]:
    """Return the kinds of configurations, part by part until there are two."""
    found: set[str] = set()
    for samples in parts:
        if len(found) < 2:
            found |= {kind for kind in kinds_at(chain, samples) if kind is not None}
    return found


def seen_on(chain: Chain, conditions: Sequence[str]) -> list[Sample]:
    """Return configurations on conditions (text), enough to say of all what is so of these."""
    # what is so may depend on how open lengths compare
    arms = _ARMS * max(_LEAST_ARMS, len(chain.parameters)) if chain.parameters else _ARMS
    each = -(-_LOOKED_AT // (arms * len(conditions)))
    samples = [sample for condition in conditions for sample in samples_on(chain, condition, "seen", arms, each)]
    return samples[:: max(1, len(samples) // _LOOKED_AT)]


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
    return kinds_at(chain, [sample])[0]


def kinds_at(chain: Chain, samples: Sequence[Sample]) -> list[str | None]:
    """Return the same of many configurations of arms of one structure, in less time than one by one."""
    if not samples:
        return []
    carrying = [_without_wrist(chain, sample) for sample in samples]
    kinds: list[str | None] = ["regular"] * len(samples)
    plain = [k for k, hand in enumerate(carrying) if hand is None]
    _put(kinds, plain, _kinds_of_places([samples[k] for k in plain], [TASK_ROWS.index(row) for row in chain.task]))
    on_wrist = [k for k, hand in enumerate(carrying) if hand is not None and _is_singular(samples[k])]
    places = _kinds_of_places([hand for k in on_wrist if (hand := carrying[k]) is not None], [0, 1, 2])
    _put(kinds, on_wrist, ["internal" if kind == "regular" else kind for kind in places])
    return kinds


def _put(kinds: list[str | None], at: Sequence[int], found: Sequence[str | None]) -> None:
    for k, kind in zip(at, found, strict=True):
        kinds[k] = kind


def _without_wrist(chain: Chain, sample: Sample) -> Sample | None:
    """Return the first three joints of an arm of six with a spherical wrist, their point being the wrist's centre."""
    if chain.n != 6 or set(chain.task) != set(TASK_ROWS) or wrist_centre(chain) is None:
        return None
    if any(abs(np.cos(sample.arm.fixed[joint][2])) > REGULAR for joint in (3, 4)):
        return None  # such a wrist does not reach every orientation
    return Sample(sample.arm.first(3, (0.0, 0.0, sample.arm.fixed[3][0])), sample.q[:3])


def _is_singular(sample: Sample) -> bool:
    """Tell whether a Jacobian of six rows and columns loses rank."""
    sigma = np.linalg.svd(sample.arm.jacobian(sample.q), compute_uv=False)
    return bool(_ranks(sigma[None], [sample])[0] < len(sigma))


def _ranks(sigma: np.ndarray, samples: Sequence[Sample]) -> np.ndarray:
    """Return the ranks of Jacobians with these singular values (k x m).

    One whose entries are all next to nothing, against the arm's reach, has rank zero.
    """
    scale = sigma[:, 0].copy()
    short = np.flatnonzero(scale < 1.0).tolist()
    if short:
        scale[short] = np.maximum(scale[short], np.minimum(reaches_of([samples[k].arm for k in short]), 1.0))
    return np.asarray(np.sum(sigma > REGULAR * scale[:, None], axis=1))


def _kinds_of_places(samples: Sequence[Sample], task: list[int]) -> list[str | None]:
    """Return the kinds of configurations; where a joint can turn without moving the point, of the worst it turns to.

    Boundary or not is a matter of where the point is. A corner of the reach is seen from some of its configurations, so
    that those that are looked at are the same for all configurations with the point there.
    """
    kinds = _kinds_seen(samples, task)
    if max(task) > 2:
        return kinds
    asked = [k for k, kind in enumerate(kinds) if kind == "internal"]
    for joint in range(1, min(len(samples[0].q), samples[0].arm.point_frame) if asked else 0):
        if samples[0].arm.kinds[joint] == "R":
            turned = _turned([samples[k] for k in asked], joint)
            still = [k for k, poses in zip(asked, turned, strict=True) if poses]
            seen = iter(_kinds_seen([sample for poses in turned for sample in poses], task))
            for k in still:
                worst = [next(seen) for _ in range(_TURNS)]
                kinds[k] = "boundary" if "boundary" in worst else "internal"
            asked = [k for k in asked if k not in still]
            if not asked:
                break
    return kinds


def _turned(samples: Sequence[Sample], joint: int) -> list[list[Sample]]:
    """Return of each sample what a joint turns it to, if that does not move the point."""
    q = np.tile(np.stack([sample.q for sample in samples])[:, None], (1, _TURNS, 1))
    q[..., joint] = np.linspace(-np.pi, np.pi, _TURNS, endpoint=False)
    places = NumericChain.several([sample.arm for sample in samples]).point(q)
    still = np.ptp(places, axis=1).max(axis=1) < REGULAR
    return [
        [Sample(sample.arm, pose) for pose in poses] if stays else []
        for sample, poses, stays in zip(samples, q, still, strict=True)
    ]


def _kinds_seen(samples: Sequence[Sample], task: list[int]) -> list[str | None]:
    """Return the kinds that configurations show by their own small motions and by the search for others."""
    if not samples:
        return []
    arms = NumericChain.several([sample.arm for sample in samples])
    u, sigma, vt = np.linalg.svd(arms.jacobian(np.stack([sample.q for sample in samples])[:, None])[:, 0, task])
    ranks = _ranks(sigma, samples)
    kinds: list[str | None] = ["regular"] * len(samples)
    for rank in sorted({int(rank) for rank in ranks if rank < sigma.shape[1]}):
        at = np.flatnonzero(ranks == rank)
        places = [samples[k] for k in at.tolist()]
        bending = _bending(places, task, vt[at, rank:])
        is_edge = np.zeros(len(at), dtype=bool)
        for lost in _directions(u[at, :, rank:], is_square=len(task) <= vt.shape[1]):
            rest = np.flatnonzero(~is_edge)
            if len(rest):
                own = _Bending(bending.still[rest], bending.change[rest])
                is_edge[rest] = _are_edges([places[k] for k in rest.tolist()], task, lost[rest], own)
        _put(kinds, at.tolist(), ["boundary" if edge else "internal" for edge in is_edge])
    return kinds


def _directions(lost: np.ndarray, is_square: bool) -> Iterator[np.ndarray]:
    """Yield directions of each sample that are lost (k x m): the only one, else some of them.

    Where several are lost at once, it is a boundary only if one of them folds.
    """
    count = lost.shape[2]
    if count == 1:
        if is_square:
            yield lost[:, :, 0]
        return
    stream = Stream("directions")
    for _ in range(12):
        direction = lost @ np.array([stream.uniform(-1, 1) for _ in range(count)])
        yield direction / np.linalg.norm(direction, axis=1, keepdims=True)


@dataclass(frozen=True)
class _Bending:
    """Still motions of samples (k x s x n), and for each how J changes along it (k x s x rows of the task x n)."""

    still: np.ndarray
    change: np.ndarray


_STEP = 1e-4


def _bending(samples: Sequence[Sample], task: list[int], still: np.ndarray) -> _Bending:
    """Return how J changes along still motions, by central differences, twice the step not yet divided out."""
    arms, q = NumericChain.several([sample.arm for sample in samples]), np.stack([sample.q for sample in samples])
    ways = np.concatenate([still, -still], axis=1)
    ahead, behind = np.split(arms.jacobian(q[:, None] + _STEP * ways)[:, :, task], 2, axis=1)
    return _Bending(still, ahead - behind)


def _are_edges(samples: Sequence[Sample], task: list[int], lost: np.ndarray, bending: _Bending) -> np.ndarray:
    """Tell whether no configuration reaches beyond each place, on a side to which small motions do not lead.

    A still motion of second order zero (a joint that moves nothing) takes no part; if all are, either side may be
    the far one.
    """
    forward, backward = _folds(lost, bending)
    # The search is sure for a point that can move in as many directions as are counted, and only for that.
    either = max(task) < 3 and len(task) <= len(samples[0].q)
    is_edge = np.zeros(len(samples), dtype=bool)
    for side, asked in ((1, ~forward & (backward | either)), (-1, ~backward & (forward | either))):
        at = np.flatnonzero(asked & ~is_edge)
        if len(at):
            is_edge[at] = ~reached_beyond([samples[k] for k in at.tolist()], task, side * lost[at])
    return is_edge


def _folds(lost: np.ndarray, bending: _Bending) -> tuple[np.ndarray, np.ndarray]:
    """Tell whether still motions lead, to second order, forward along `lost`, and whether they lead backward."""
    along = np.einsum("km,ksmn->ksn", lost, bending.change) / (2 * _STEP)
    form = along @ bending.still.swapaxes(1, 2)
    eigenvalues = np.linalg.eigvalsh((form + form.swapaxes(1, 2)) / 2)
    return np.any(eigenvalues > 1e-5, axis=1), np.any(eigenvalues < -1e-5, axis=1)
