"""What singular configurations look like, in words: stretched out, on an axis, axes in line; tested at samples."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
import sympy as sp

from exercises.arm.axes import Sample, around, beside, distance, distances, off_line, off_plane, parallel, slant, spread
from exercises.arm.chain import TASK_ROWS, Chain, Point

NEAR, APART = 1e-5, 1e-3
"""What counts as zero, and as clearly not zero, in metres or as a sine."""


class Statement(NamedTuple):
    """What configurations look like, and of which joints that is said where the words don't tell."""

    words: str
    joints: tuple[int, ...] = ()

    def of(self, other: str) -> "Statement":
        """Return the same said of something else than the point of interest."""
        return Statement(self.words.replace("the point", other), self.joints)


def wrist_centre(chain: Chain) -> int | None:
    """Return the frame whose origin lies on the axes of the last three joints, whatever they do; None without one."""
    wrist = chain.joints[-3:]
    if chain.n < 4 or any(joint.kind != "R" for joint in wrist):
        return None
    meet = wrist[0].a == 0 and wrist[1].a == 0 and wrist[1].d == 0
    bent = all((joint.alpha / sp.pi).is_integer is not True for joint in wrist[:2])
    return chain.n - 2 if meet and bent else None


def meaning(chain: Chain, samples: Sequence[Sample], elsewhere: Sequence[Sequence[Sample]] = ()) -> str:
    """Return what all of some singular configurations look like, or at least which joints' motions depend on others'.

    `elsewhere` are groups of configurations that meet a part of the conditions only and lose no rank: what is so there
    as well is no reason by itself, and another statement is taken or joined to it.
    """
    first = next(statements(chain, samples), None) or next(_axes_in_plane(chain, samples), None)
    if first is None:
        return _dependence(chain, samples)
    weak = [{*statements(chain, group), *_axes_in_plane(chain, group)} for group in elsewhere]
    if not any(first in said for said in weak):
        return first.words
    held = list(dict.fromkeys(statements(chain, samples)))
    joined = [(first, said) for said in (*held[1:], *_axes_in_plane(chain, samples))]
    for chosen in (*((said,) for said in held), *joined):
        if not any(said.issuperset(chosen) for said in weak):
            return ", and ".join(said.words for said in chosen)
    return f"{first.words}; by itself that costs no rank"


def statements(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Yield what all of some configurations look like, and those around them do not; the most telling first."""
    turns_count = any(row[0] == "w" for row in chain.task)
    if turns_count and len(chain.task) == 3 and chain.linear_rows and chain.joints[-1].kind == "R" and chain.n > 1:
        yield from _of_last_axis(chain, samples)
        return
    centre = wrist_centre(chain) if turns_count else None
    if centre is None or chain.point == Point(centre):
        yield from _seen_at(chain, samples)
        return
    moved = [Sample(sample.arm.with_point(centre), sample.q) for sample in samples]
    for said in _seen_at(replace(chain, tool=Point(centre)), moved):
        yield said.of("the wrist centre")


def _of_last_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Yield what poses of a planar arm look like where the turn counts: the last joint sets that, the others P."""
    yield from _parallel_row(chain, samples)
    moved = [Sample(sample.arm.with_point(chain.n - 1), sample.q) for sample in samples]
    rows = tuple(row for row in chain.task if row[0] == "v")
    for said in _seen_at(replace(chain, tool=Point(chain.n - 1), task=rows), moved):
        yield said.of(f"the axis of joint {chain.n}")


def _seen_at(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Yield what configurations look like from the point of interest."""
    looks = [_on_an_axis, _in_line, _extreme_reach, _far_from_slide, _parallel_slides, _slide_at_link, _parallel_axes,
             _parallel_row, _origin_on_axis, _origin_extreme]  # fmt: skip
    if not chain.linear_rows:
        looks = [_in_line, _parallel_axes, _axes_in_plane]
    elif len(chain.linear_rows) < len(chain.task):
        first = [_in_line, _parallel_axes, _parallel_row]  # where P is may be by the way
        looks = first + [look for look in looks if look not in first]
    for look in looks:
        yield from look(chain, samples)


def _dependence(chain: Chain, samples: Sequence[Sample]) -> str:
    """Return which joints, as few as will do, can move without anything that the task counts; by the columns of J."""
    rows = [TASK_ROWS.index(row) for row in chain.task]
    jacobians = [sample.arm.jacobian(sample.q) for sample in samples]
    if chain.n <= len(rows) and samples:
        for count in range(1, chain.n + 1):
            for chosen in combinations(range(chain.n), count):
                if all(_depend(j[np.ix_(rows, chosen)]) for j in jacobians):
                    names = _names(chosen)
                    if count == 1:
                        return f"joint {names} moves nothing that the task counts"
                    still = _what_rests(chain, [j[:, chosen] for j in jacobians], rows)
                    who = "all joints" if count == chain.n > 2 else f"joints {names}"
                    return f"{who} can move together and {still}"
    where = {2: "along one line", 3: "in one plane"}.get(len(rows)) if len(chain.linear_rows) == len(rows) else None
    return f"all joints move the point {where}" if where else "the columns of J are linearly dependent"


def _depend(columns: np.ndarray) -> bool:
    sigma = np.linalg.svd(columns, compute_uv=False)
    return bool(sigma[-1] < NEAR * max(sigma[0], 1e-3))


def _what_rests(chain: Chain, jacobians: Sequence[np.ndarray], rows: Sequence[int]) -> str:
    """Say what a motion leaves at rest that none of the rows that count takes part in."""
    motions = [np.linalg.svd(jacobian[rows])[2][-1] for jacobian in jacobians]
    moved = [np.abs(jacobian @ motion) for jacobian, motion in zip(jacobians, motions, strict=True)]
    if len(chain.linear_rows) == len(rows) and all(speeds[:3].max() < NEAR for speeds in moved):
        return "leave the point at rest"
    if all(speeds.max() < NEAR for speeds in moved):
        return f"leave link {chain.n} at rest"
    return "nothing that the task counts moves"


def _names(joints: Sequence[int]) -> str:
    numbers = [str(joint + 1) for joint in joints]
    return " and ".join([", ".join(numbers[:-1]), numbers[-1]] if len(numbers) > 1 else numbers)


def _on_an_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for joint in (i for i in range(chain.point.frame) if chain.joints[i].kind == "R"):
        if _only_there(samples, partial(distance, joint=joint)):
            yield Statement(f"the point lies on the axis of joint {joint + 1}, which then does not move it")


def _revolute_pairs(chain: Chain) -> list[tuple[int, int]]:
    return list(combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "R"], 2))


def _in_line(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for i, j in _revolute_pairs(chain):
        if _only_there(samples, partial(off_line, i=i, j=j)):
            yield Statement(f"the axes of joints {i + 1} and {j + 1} lie on one line")


def _parallel_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for i, j in sorted(_revolute_pairs(chain), key=lambda pair: pair[1] - pair[0]):
        if _only_there(samples, partial(spread, joints=(i, j))):
            yield Statement(f"the axes of joints {i + 1} and {j + 1} are parallel")


def _axes_in_plane(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for three axes that are parallel to one plane, so that nothing turns about the direction square to it."""
    if not any(row[0] == "w" for row in chain.task):
        return
    for triple in combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "R"], 3):
        if _only_there(samples, partial(spread, joints=triple)):
            names = ", ".join(str(i + 1) for i in triple[:2])
            yield Statement(f"the axes of joints {names} and {triple[2] + 1} are all parallel to one plane")


def _parallel_row(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for triple in combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "R"], 3):
        always = all(parallel(places, triple[0], j) for places in (samples, around(samples)) for j in triple[1:])
        if always and _only_there(samples, partial(off_plane, row=triple)):
            names = ", ".join(str(i + 1) for i in triple[:2])
            yield Statement(f"the parallel axes of joints {names} and {triple[2] + 1} lie in one plane")


def _far_from_slide(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for a slide from whose line a later joint has brought the point as far as it can."""
    for slide in (i for i, joint in enumerate(chain.joints) if joint.kind == "P"):
        for moving in range(slide + 1, min(chain.n, chain.point.frame)):
            if _same_everywhere([_extreme(sample, slide, moving) for sample in samples]) == {1}:
                yield Statement(
                    f"the point is as far from the line of slide {slide + 1} as joint {moving + 1} can bring it"
                )


def _parallel_slides(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for i, j in combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "P"], 2):
        if _only_there(samples, partial(spread, joints=(i, j))):
            yield Statement(f"slides {i + 1} and {j + 1} are parallel")


def _slide_at_link(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for a slide that has come to lie along, or square to, the line that joins two parallel axes."""
    for slide in (i for i, joint in enumerate(chain.joints) if joint.kind == "P"):
        for i, j in _revolute_pairs(chain):
            if not samples or not parallel(samples, i, j):
                continue
            for across, how in ((False, "along"), (True, "at right angles to")):
                if _only_there(samples, partial(slant, slide=slide, i=i, j=j, across=across)):
                    yield Statement(
                        f"slide {slide + 1} runs {how} the line from the axis of joint {i + 1} to that of joint {j + 1}"
                    )


def _origin_on_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for axis in (i for i, joint in enumerate(chain.joints) if joint.kind == "R"):
        for frame in range(axis + 2, chain.n):
            moved = [Sample(sample.arm.with_point(frame), sample.q) for sample in samples]
            if _only_there(moved, partial(distance, joint=axis)):
                yield Statement(f"the origin O{frame} lies on the axis of joint {axis + 1}")


def _origin_extreme(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Look for an origin in the wrist, as where the last two axes of a UR meet, that is as far or near as it can be."""
    for frame in range(4, chain.n):
        moved = [Sample(sample.arm.with_point(frame), sample.q) for sample in samples]
        for said in _extreme_reach(replace(chain, tool=Point(frame)), moved):
            if "the point" in said.words:
                yield said.of(f"the origin O{frame}")


def _extreme_reach(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    extremes = _extremes(chain, samples)
    if extremes is None:
        return
    axis, movers, signs = extremes
    mover = f"joint {movers[0] + 1}"
    if chain.joints[movers[0]].kind == "P":
        yield Statement(f"arm drawn in: the point is as near to the axis of joint {axis + 1} as {mover} can bring it")
    elif all(parallel(samples, axis, moving) for moving in movers):
        yield Statement(_EXTENDED[signs], (axis, *movers))
    elif signs == frozenset({1, -1}):
        yield Statement(f"the point is as far from or as near to the axis of joint {axis + 1} as {mover} can bring it")
    else:
        how = "far from" if 1 in signs else "near to"
        yield Statement(f"the point is as {how} the axis of joint {axis + 1} as {mover} can bring it")


_EXTENDED = {
    frozenset({1}): "arm stretched out",
    frozenset({-1}): "arm folded back",
    frozenset({1, -1}): "arm stretched out or folded back",
}


def _only_there(samples: Sequence[Sample], off: Callable[[Sample, np.ndarray], float]) -> bool:
    """Tell whether what is zero if something holds is so in all samples, and not in the poses around them as well."""
    held = bool(samples) and all(off(sample, sample.q) < NEAR for sample in samples)
    return held and any(off(sample, beside(sample)) > APART for sample in samples)


def _extremes(chain: Chain, samples: Sequence[Sample]) -> tuple[int, list[int], frozenset[int]] | None:
    """Find an axis from which the point is farthest or nearest in all samples, and the later joints that make it so.

    The sign of a sample is 1 where it is farthest with respect to each of those joints, else -1.
    """
    for axis in range(chain.n):
        if chain.joints[axis].kind != "R":
            continue
        later = range(axis + 1, min(chain.n, chain.point.frame))
        signs = {moving: [_extreme(sample, axis, moving) for sample in samples] for moving in later}
        movers = [moving for moving in later if 0 not in _same_everywhere(signs[moving])]
        if movers:
            at = [{signs[moving][i] for moving in movers} for i in range(len(samples))]
            return axis, movers, frozenset(-1 if -1 in signs_at else 1 for signs_at in at if signs_at != {None})
    return None


def _same_everywhere(signs: Sequence[int | None]) -> set[int]:
    """Return the signs of samples that have one; 0 where half of them have none."""
    known = {sign for sign in signs if sign is not None}
    return known if 2 * signs.count(None) < len(signs) else {0}


def _extreme(sample: Sample, axis: int, moving: int) -> int | None:
    """Return 1 where a joint has brought the point as far from an axis as it can, nearby, -1 as near, else 0.

    None where it hardly changes the distance, or not at all, as where the point happens to lie on its own axis.
    """
    step = 1e-3
    away = np.zeros((5, len(sample.q)))
    away[:, moving] = step * np.arange(-2, 3)
    far_behind, behind, middle, ahead, far_ahead = distances(sample, sample.q + away, axis)
    slope = (8 * (ahead - behind) - (far_ahead - far_behind)) / (12 * step)
    curvature = (ahead + behind - 2 * middle) / step**2
    if abs(slope) > max(1e-9, 1e-6 * abs(curvature)):
        return 0
    if abs(curvature) < 1e-3:
        return None
    return 1 if curvature < 0 else -1
