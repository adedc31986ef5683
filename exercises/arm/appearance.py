"""What singular configurations look like, in words: stretched out, on an axis, axes in line; tested at samples.

What is told is a reason (`reason`): nowhere is it so where no rank is lost. Where nothing that is seen is one, the
joints are told whose columns of J are dependent, and what rests while they move.
"""

from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, permutations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes import (
    Off,
    Sample,
    around,
    distance,
    off_line,
    off_one_way,
    off_plane,
    offs,
    parallel,
    slant,
    slope,
    spread,
)
from qdot.exercises.arm.chain import TASK_ROWS, Chain, Point
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.reason import is_reason

NEAR, APART = 1e-5, 1e-3
_AXES = "xyz"
"""What counts as zero, and as clearly not zero, in metres or as a sine."""
_FEW = 15
"""Configurations of which a statement is found, to be tested at all of them."""


@dataclass(frozen=True)
class Statement:
    """What configurations look like: it is so where `off` is zero and `true` says so; `looks` name who found it."""

    words: str
    off: Off
    true: Callable[[Sample], bool] = lambda _: True
    looks: frozenset[str] = frozenset()

    def seen_at(self, frame: int, other: str) -> "Statement":
        """Return the same said of the origin of another frame than the point of interest."""
        return Statement(
            self.words.replace("the point", other),
            lambda arm, q: self.off(arm.with_point(frame), q),
            lambda sample: self.true(Sample(sample.arm.with_point(frame), sample.q)),
            self.looks,
        )

    def together(self, other: "Statement") -> "Statement":
        """Return this and another one."""
        return Statement(
            f"{self.words}, and {other.words}",
            lambda arm, q: np.hypot(self.off(arm, q), other.off(arm, q)),
            lambda sample: self.true(sample) and other.true(sample),
            self.looks | other.looks,
        )


Look = Callable[[Chain, Sequence[Sample]], Iterator[Statement]]
"""What yields statements of one kind that hold of all of some configurations, and not around them."""


def wrist_centre(chain: Chain) -> int | None:
    """Return the frame whose origin lies on the axes of the last three joints, whatever they do; None without one."""
    wrist = chain.joints[-3:]
    if chain.n < 4 or any(joint.kind != "R" for joint in wrist):
        return None
    meet = wrist[0].a == 0 and wrist[1].a == 0 and wrist[1].d == 0
    bent = all((joint.alpha / sp.pi).is_integer is not True for joint in wrist[:2])
    return chain.n - 2 if meet and bent else None


def meaning(chain: Chain, samples: Sequence[Sample]) -> str:
    """Return in words why some configurations are singular: what they look like, or else which joints are dependent."""
    said = reason_of(chain, samples[:: max(1, len(samples) // _FEW)])
    if said is not None and not _is_said_of_all(chain, samples, said):
        said = reason_of(chain, samples)
    return said.words if said else dependence(chain, samples)


def _is_said_of_all(chain: Chain, samples: Sequence[Sample], said: Statement) -> bool:
    """Tell whether who found a statement at some configurations finds it at all of them."""
    words = [one.words for one in _everything(chain, samples, said.looks)]
    return said.words in (*words, *(f"{one}, and {other}" for one, other in permutations(words, 2)))


def reason_of(chain: Chain, samples: Sequence[Sample]) -> Statement | None:
    """Return what all of some configurations look like and no regular one does: one statement, else two together."""
    held: list[Statement] = []
    for said in _everything(chain, samples):
        if is_reason(chain, samples, said.off, said.true):
            return said
        held.append(said)
    pairs = (first.together(second) for first, second in combinations(held, 2) if first.words != second.words)
    return next((said for said in pairs if is_reason(chain, samples, said.off, said.true)), None)


def _everything(chain: Chain, samples: Sequence[Sample], only: Set[str] = frozenset()) -> Iterator[Statement]:
    yield from statements(chain, samples, only)
    yield from _found_by([_axes_in_plane], chain, samples, only)


def _found_by(looks: Sequence[Look], chain: Chain, samples: Sequence[Sample], only: Set[str]) -> Iterator[Statement]:
    """Yield what looks find, one after the other; of `only` those named, if any are."""
    for look in looks:
        if not only or look.__name__ in only:
            for said in look(chain, samples):
                yield replace(said, looks=frozenset((look.__name__,)))


def statements(chain: Chain, samples: Sequence[Sample], only: Set[str] = frozenset()) -> Iterator[Statement]:
    """Yield what all of some configurations look like, and those around them do not; the most telling first.

    Where looks are named, `only` what these find.
    """
    turns_count = any(row[0] == "w" for row in chain.task)
    if turns_count and len(chain.task) == 3 and chain.linear_rows and chain.joints[-1].kind == "R" and chain.n > 1:
        yield from _of_last_axis(chain, samples, only)
        return
    centre = wrist_centre(chain) if turns_count else None
    if centre is None or chain.point == Point(centre):
        yield from _seen_at(chain, samples, only)
        return
    moved = [Sample(sample.arm.with_point(centre), sample.q) for sample in samples]
    for said in _seen_at(replace(chain, tool=Point(centre)), moved, only):
        yield said.seen_at(centre, "the wrist centre")


def _of_last_axis(chain: Chain, samples: Sequence[Sample], only: Set[str]) -> Iterator[Statement]:
    """Yield what poses of a planar arm look like where the turn counts: the last joint sets that, the others P."""
    yield from _found_by([_parallel_row], chain, samples, only)
    moved = [Sample(sample.arm.with_point(chain.n - 1), sample.q) for sample in samples]
    rows = tuple(row for row in chain.task if row[0] == "v")
    for said in _seen_at(replace(chain, tool=Point(chain.n - 1), task=rows), moved, only):
        yield said.seen_at(chain.n - 1, f"the axis of joint {chain.n}")


def _seen_at(chain: Chain, samples: Sequence[Sample], only: Set[str]) -> Iterator[Statement]:
    """Yield what configurations look like from the point of interest."""
    looks: list[Look] = [_on_an_axis, _in_line, _extreme_reach, _far_from_slide, _parallel_slides, _slide_at_link,
                         _parallel_axes, _parallel_row, _origin_on_axis, _origin_extreme, _one_way]  # fmt: skip
    if not chain.linear_rows:
        looks = [_in_line, _parallel_axes]
    elif len(chain.linear_rows) < len(chain.task):
        first = [_in_line, _parallel_axes, _parallel_row]  # where P is may be by the way
        looks = first + [look for look in looks if look not in first]
    yield from _found_by(looks, chain, samples, only)


def dependence(chain: Chain, samples: Sequence[Sample]) -> str:
    """Return which joints, as few as will do, can move without anything that the task counts; by the columns of J.

    Where they are always dependent, as there are more joints than rows, what all joints together do not do.
    """
    rows = [TASK_ROWS.index(row) for row in chain.task]
    if chain.n > len(rows):
        return _dependent_rows(chain, samples, rows)
    if samples:
        jacobians = _jacobians(samples)
        for count in range(1, chain.n + 1):
            for chosen in combinations(range(chain.n), count):
                if _depend(jacobians, rows, chosen):
                    names = _names(chosen)
                    if count == 1:
                        return f"joint {names} moves nothing that the task counts"
                    still = _what_rests(chain, jacobians[..., chosen], rows)
                    who = "all joints" if count == chain.n > 2 else f"joints {names}"
                    return f"{who} can move together and {still}"
    return "the columns of J are linearly dependent"


def _dependent_rows(chain: Chain, samples: Sequence[Sample], rows: Sequence[int]) -> str:
    """Return along or about which axis of the world all joints move nothing, or how they move the point."""
    jacobians = _jacobians(samples) if samples else np.ones((1, 6, chain.n))
    still = [row for row in rows if np.abs(jacobians[:, row]).max() < NEAR]
    which = _listed([_AXES[row % 3] for row in still])
    if still and max(still) < 3:
        return f"no joint moves the point along {which}"
    if still and min(still) > 2:
        return f"no joint turns link {chain.n} about {which}"
    if not samples or still or max(rows) > 2:
        return "the rows of J are linearly dependent"
    sigma = np.linalg.svd(jacobians[:, :3], compute_uv=False)
    where = {2: "along one line", 3: "in one plane"}[len(rows)]
    if np.all(sigma[:, len(rows) - 1] < NEAR * np.maximum(sigma[:, 0], 1e-3)):
        return f"all joints move the point {where}"
    (across,) = {0, 1, 2} - set(rows)
    return f"seen along {_AXES[across]}, all joints move the point {where}"


def _jacobians(samples: Sequence[Sample]) -> np.ndarray:
    """Return the Jacobian of each sample, (k, 6, n)."""
    arms = NumericChain.several([sample.arm for sample in samples])
    return arms.jacobian(np.stack([sample.q for sample in samples])[:, None])[:, 0]


def _depend(jacobians: np.ndarray, rows: Sequence[int], columns: Sequence[int]) -> bool:
    """Tell whether columns of Jacobians (k, 6, n), seen in some rows, depend on each other in all of them."""
    sigma = np.linalg.svd(jacobians[:, list(rows)][:, :, list(columns)], compute_uv=False)
    return bool(np.all(sigma[:, -1] < NEAR * np.maximum(sigma[:, 0], 1e-3)))


def _what_rests(chain: Chain, jacobians: np.ndarray, rows: Sequence[int]) -> str:
    """Say what a motion leaves at rest, of joints with columns (k, 6, …), that none of the rows that count sees."""
    motions = np.linalg.svd(jacobians[:, list(rows)])[2][:, -1]
    moved = np.abs(np.einsum("kij,kj->ki", jacobians, motions))
    if len(chain.linear_rows) == len(rows) and moved[:, :3].max() < NEAR:
        return "leave the point at rest"
    if moved.max() < NEAR:
        return f"leave link {chain.n} at rest"
    return "nothing that the task counts moves"


def _names(joints: Sequence[int]) -> str:
    return _listed([str(joint + 1) for joint in joints])


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _on_an_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    turning = [i for i in range(chain.point.frame) if chain.joints[i].kind == "R"]
    on = [i for i in turning if next(_if_only_there(samples, "", partial(distance, joint=i)), None) is not None]
    if len(on) > 1:
        words = f"the point lies on the axes of joints {_names(on)}, which then do not move it"
        yield from _if_only_there(samples, words, partial(_off_axes, joints=on))
    for joint in turning:
        words = f"the point lies on the axis of joint {joint + 1}, which then does not move it"
        yield from _if_only_there(samples, words, partial(distance, joint=joint))


def _off_axes(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return how far the point is from the farthest of several axes."""
    return np.asarray(np.max([distance(arm, q, joint) for joint in joints], axis=0))


def _revolute(chain: Chain) -> list[int]:
    return [i for i, joint in enumerate(chain.joints) if joint.kind == "R"]


def _in_line(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for i, j in combinations(_revolute(chain), 2):
        words = f"the axes of joints {i + 1} and {j + 1} lie on one line"
        yield from _if_only_there(samples, words, partial(off_line, i=i, j=j))


def _parallel_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for parallel axes: two of them where turns alone count, else with them all that are parallel to them.

    That is a reason only if the columns of these joints depend on each other by themselves.
    """
    if not samples:
        return
    rows, jacobians = [TASK_ROWS.index(row) for row in chain.task], _jacobians(samples)
    for i, j in sorted(combinations(_revolute(chain), 2), key=lambda pair: pair[1] - pair[0]):
        if parallel(samples, i, j):
            others = [k for k in _revolute(chain) if chain.linear_rows and parallel(samples, i, k)]
            chosen = sorted({i, j, *others})
            if not _depend(jacobians, rows, chosen):
                continue
            words = f"the axes of joints {_names(chosen)} are parallel"
            yield from _if_only_there(samples, words, partial(spread, joints=(i, j)))


def _axes_in_plane(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for three axes that are parallel to one plane, so that nothing turns about the direction square to it."""
    if not any(row[0] == "w" for row in chain.task):
        return
    for triple in combinations(_revolute(chain), 3):
        words = f"the axes of joints {_names(triple)} are all parallel to one plane"
        yield from _if_only_there(samples, words, partial(spread, joints=triple))


def _parallel_row(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for triple in combinations(_revolute(chain), 3):
        if all(parallel(places, triple[0], j) for places in (samples, around(samples)) for j in triple[1:]):
            words = f"the parallel axes of joints {_names(triple)} lie in one plane"
            yield from _if_only_there(samples, words, partial(off_plane, row=triple))


def _far_from_slide(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for a slide from whose line a later joint has brought the point as far as it can."""
    for slide in (i for i, joint in enumerate(chain.joints) if joint.kind == "P"):
        for moving in range(slide + 1, min(chain.n, chain.point.frame)):
            if _signs(samples, slide, moving) == {1}:
                yield _extreme_statement(
                    f"the point is as far to one side of slide {slide + 1} as joint {moving + 1} can bring it",
                    slide, [moving], {1},
                )  # fmt: skip


def _parallel_slides(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for i, j in combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "P"], 2):
        yield from _if_only_there(samples, f"slides {i + 1} and {j + 1} are parallel", partial(spread, joints=(i, j)))


def _slide_at_link(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for a slide that has come to lie along, or square to, the line that joins two parallel axes."""
    for slide in (i for i, joint in enumerate(chain.joints) if joint.kind == "P"):
        for i, j in combinations(_revolute(chain), 2):
            if not samples or not parallel(samples, i, j):
                continue
            link = f"the line from the axis of joint {i + 1} to that of joint {j + 1}"
            for across, how in ((False, "along"), (True, "at right angles to")):
                words = f"slide {slide + 1} runs {how} {link}"
                yield from _if_only_there(samples, words, partial(slant, slide=slide, i=i, j=j, across=across))


def _origin_on_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for axis in _revolute(chain):
        for frame in range(axis + 2, chain.n):
            words = f"the origin O{frame} lies on the axis of joint {axis + 1}"
            yield from _if_only_there(samples, words, partial(_origin_off, frame=frame, axis=axis))


def _origin_off(arm: NumericChain, q: np.ndarray, frame: int, axis: int) -> np.ndarray:
    """Return the distance of an origin from an axis."""
    return distance(arm.with_point(frame), q, axis)


def _origin_extreme(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for an origin in the wrist, as where the last two axes of a UR meet, that is as far or near as it can be."""
    for frame in range(4, chain.n):
        moved = [Sample(sample.arm.with_point(frame), sample.q) for sample in samples]
        for said in _extreme_reach(replace(chain, tool=Point(frame)), moved):
            if "the point" in said.words:
                yield said.seen_at(frame, f"the origin O{frame}")


def _one_way(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for two joints that move the point along the same line."""
    for pair in combinations(range(min(chain.n, chain.point.frame)), 2):
        sizes = [np.linalg.norm(s.arm.jacobian(s.q)[:3, list(pair)], axis=0).min() for s in samples]
        if samples and min(sizes) > APART:
            words = f"joints {_names(pair)} move the point along the same line"
            yield from _if_only_there(samples, words, partial(off_one_way, joints=pair))


def _extreme_reach(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for an axis from which later joints can bring the point no farther, or no nearer."""
    for axis in _revolute(chain):
        later = range(axis + 1, min(chain.n, chain.point.frame))
        told = {moving: _signs(samples, axis, moving) for moving in later}
        movers = [moving for moving, signs in told.items() if 0 not in signs]
        turning = [moving for moving in movers if chain.joints[moving].kind == "R"]
        bent = [moving for moving in later if moving not in movers and 0 in _extremes(samples, axis, moving)]
        if turning and not bent and turning == movers and all(parallel(samples, axis, j) for j in movers):
            yield _stretched(samples, axis, movers)
            continue
        for moving in movers:
            signs = told[moving]
            if moving in turning and not parallel(samples, axis, moving):
                signs = set(_ends(samples, axis, moving))
            if 0 not in signs:
                yield _extreme_statement(_as_far_or_near(chain, axis, moving, signs), axis, [moving], signs)


def _as_far_or_near(chain: Chain, axis: int, moving: int, signs: set[int]) -> str:
    ending = f"the axis of joint {axis + 1} as joint {moving + 1} can bring it"
    if chain.joints[moving].kind == "P":
        return f"arm drawn in: the point is as near to {ending}"
    how = "far from or as near to" if len(signs) > 1 else "far from" if 1 in signs else "near to"
    return f"the point is as {how} {ending}"


def _stretched(samples: Sequence[Sample], axis: int, movers: Sequence[int]) -> Statement:
    """Return how an arm with parallel axes lies: folded back where its joints can together bring the point farther."""
    told = [_extremes(samples, axis, moving) for moving in movers]
    tells = [any(sign is not None for sign in signs) for signs in zip(*told, strict=True)]
    how = frozenset(_reach(sample, axis, movers) for sample, it_tells in zip(samples, tells, strict=True) if it_tells)
    said = _extreme_statement(_EXTENDED[how], axis, movers, {1, -1})

    def true(sample: Sample) -> bool:  # where the point lies on the axis, every joint is at an end of what it can do
        return said.true(sample) and sample.off(partial(distance, joint=axis)) > APART

    return replace(said, true=true)


def _reach(sample: Sample, axis: int, movers: Sequence[int]) -> int:
    """Tell an arm whose joints are each at an end: stretched out (1), or farther with some turned by 180° (-1).

    Each alone can have the point farthest and two together not: where links lie there, back and there again.
    """
    turned = np.zeros((2 ** len(movers), len(sample.q)))
    turned[:, list(movers)] = np.pi * np.array(list(product((0, 1), repeat=len(movers))))
    distances = distance(sample.arm, sample.q + turned, axis)
    return -1 if distances.max() > distances[0] + NEAR else 1


def _extreme_statement(words: str, axis: int, movers: Sequence[int], signs: set[int]) -> Statement:
    def true(sample: Sample) -> bool:
        return all(_extreme(sample, axis, moving) in signs for moving in movers)

    return Statement(words, partial(slope, joint=axis, movers=tuple(movers)), true)


_EXTENDED = {
    frozenset({1}): "arm stretched out",
    frozenset({-1}): "arm folded back",
    frozenset({1, -1}): "arm stretched out or folded back",
}


def _if_only_there(samples: Sequence[Sample], words: str, off: Off) -> Iterator[Statement]:
    """Yield a statement where what is zero if it holds is zero in all samples, but not in the poses around them."""
    held = bool(samples) and offs(samples, off).max() < NEAR
    if held and offs(around(samples), off).max() > APART:
        yield Statement(words, off)


def _signs(samples: Sequence[Sample], axis: int, moving: int) -> set[int]:
    """Return whether a joint is at its farthest (1) or nearest (-1) nearby in all samples; {0} where in one it is not.

    Some may tell nothing, but not half of them.
    """
    told = _extremes(samples, axis, moving)
    if 0 in told or 2 * told.count(None) >= len(told):
        return {0}
    return {sign for sign in told if sign is not None}


def _extreme(sample: Sample, axis: int, moving: int) -> int | None:
    """Return 1 where a joint has brought the point as far from an axis as it can, nearby, -1 as near, else 0.

    None where it hardly changes the distance, or not at all, as where the point happens to lie on its own axis.
    """
    return _extremes([sample], axis, moving)[0]


def _extremes(samples: Sequence[Sample], axis: int, moving: int) -> list[int | None]:
    """Return the same of each sample."""
    if not samples:
        return []
    step = 1e-3
    q = np.tile(np.stack([sample.q for sample in samples])[:, None], (1, 5, 1))
    q[..., moving] += step * np.arange(-2, 3)
    arms = NumericChain.several([sample.arm for sample in samples])
    far_behind, behind, middle, ahead, far_ahead = distance(arms, q, axis).T
    rising = (8 * (ahead - behind) - (far_ahead - far_behind)) / (12 * step)
    curvature = (ahead + behind - 2 * middle) / step**2
    signs = np.where(np.abs(curvature) < 1e-3, 0, np.where(curvature < 0, 1, -1))
    is_rising = np.abs(rising) > np.maximum(1e-9, 1e-6 * np.abs(curvature))
    return [0 if rises else int(sign) if sign else None for rises, sign in zip(is_rising, signs, strict=True)]


def _ends(samples: Sequence[Sample], axis: int, moving: int) -> list[int]:
    """Return 1 where a turning joint has brought the point as far from an axis as it can anywhere, -1 as near, else 0.

    The square of the distance is a sum of sines and cosines of the joint and of twice the joint, which five places
    tell; it may have two maxima, as about an axis that is not parallel.
    """
    turns = 2 * np.pi / 5 * np.arange(5)
    q = np.tile(np.stack([sample.q for sample in samples])[:, None], (1, 5, 1))
    q[..., moving] += turns
    squares = distance(NumericChain.several([sample.arm for sample in samples]), q, axis) ** 2
    everywhere = squares @ np.linalg.inv(_waves(turns)) @ _waves(np.linspace(0, 2 * np.pi, 180))
    room = 1e-9 * np.maximum(squares.max(axis=1), 1.0)
    is_far, is_near = squares[:, 0] > everywhere.max(axis=1) - room, squares[:, 0] < everywhere.min(axis=1) + room
    return [1 if far else -1 if near else 0 for far, near in zip(is_far, is_near, strict=True)]


def _waves(turns: np.ndarray) -> np.ndarray:
    """Return 1, sines and cosines of angles (k) and of twice these, (5, k)."""
    return np.array([np.ones_like(turns), *(wave(i * turns) for i in (1, 2) for wave in (np.cos, np.sin))])
