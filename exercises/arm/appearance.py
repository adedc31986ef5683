"""What singular configurations look like, in words: stretched out, on an axis, axes in line; tested at samples."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np
import sympy as sp

from exercises.arm.axes import Sample, around, beside, distance, off_line, off_plane, parallel, slant, spread
from exercises.arm.chain import Chain, Point

NEAR, APART = 1e-5, 1e-3
"""What counts as zero, and as clearly not zero, in metres or as a sine."""


def wrist_centre(chain: Chain) -> int | None:
    """Return the frame whose origin lies on the axes of the last three joints, whatever they do; None without one."""
    wrist = chain.joints[-3:]
    if chain.n < 4 or any(joint.kind != "R" for joint in wrist):
        return None
    meet = wrist[0].a == 0 and wrist[1].a == 0 and wrist[1].d == 0
    bent = all((joint.alpha / sp.pi).is_integer is not True for joint in wrist[:2])
    return chain.n - 2 if meet and bent else None


def meaning(chain: Chain, samples: Sequence[Sample]) -> str:
    """Return what all of some singular configurations look like; that columns depend on each other, if nothing else."""
    turns_count = any(row[0] == "w" for row in chain.task)
    if turns_count and len(chain.task) == 3 and chain.linear_rows and chain.joints[-1].kind == "R" and chain.n > 1:
        return _of_last_axis(chain, samples)
    centre = wrist_centre(chain) if turns_count else None
    if centre is None or chain.point == Point(centre):
        return _seen_at(chain, samples)
    moved = [Sample(sample.arm.with_point(centre), sample.q) for sample in samples]
    said = _seen_at(replace(chain, tool=Point(centre)), moved)
    return said.replace("the point", "the wrist centre")


def _of_last_axis(chain: Chain, samples: Sequence[Sample]) -> str:
    """Return what poses of a planar arm look like where the turn counts: the last joint sets that, the others P."""
    seen = _parallel_row(chain, samples)
    if seen is not None:
        return seen
    moved = [Sample(sample.arm.with_point(chain.n - 1), sample.q) for sample in samples]
    rows = tuple(row for row in chain.task if row[0] == "v")
    said = _seen_at(replace(chain, tool=Point(chain.n - 1), task=rows), moved)
    return said.replace("the point", f"the axis of joint {chain.n}")


def _seen_at(chain: Chain, samples: Sequence[Sample]) -> str:
    """Return what configurations look like from the point of interest."""
    looks = [_on_an_axis, _in_line, _extreme_reach, _far_from_slide, _slide_at_link, _parallel_axes, _parallel_row,
             _origin_on_axis]  # fmt: skip
    if not chain.linear_rows:
        looks = [_in_line, _parallel_axes, _axes_in_plane]
    elif len(chain.linear_rows) < len(chain.task):
        looks.remove(_in_line)
        looks.insert(0, _in_line)
    for look in looks:
        if (said := look(chain, samples)) is not None:
            return said
    return "the columns of J are linearly dependent"


def _on_an_axis(chain: Chain, samples: Sequence[Sample]) -> str | None:
    for joint in (i for i in range(chain.point.frame) if chain.joints[i].kind == "R"):
        if _only_there(samples, partial(distance, joint=joint)):
            return f"the point lies on the axis of joint {joint + 1}, which then does not move it"
    return None


def _revolute_pairs(chain: Chain) -> list[tuple[int, int]]:
    return list(combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "R"], 2))


def _in_line(chain: Chain, samples: Sequence[Sample]) -> str | None:
    for i, j in _revolute_pairs(chain):
        if _only_there(samples, partial(off_line, i=i, j=j)):
            return f"the axes of joints {i + 1} and {j + 1} lie on one line"
    return None


def _parallel_axes(chain: Chain, samples: Sequence[Sample]) -> str | None:
    for i, j in sorted(_revolute_pairs(chain), key=lambda pair: pair[1] - pair[0]):
        if _only_there(samples, partial(spread, joints=(i, j))):
            return f"the axes of joints {i + 1} and {j + 1} are parallel"
    return None


def _axes_in_plane(chain: Chain, samples: Sequence[Sample]) -> str | None:
    """Look for three axes that are parallel to one plane, so that nothing turns about the direction square to it."""
    for triple in combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "R"], 3):
        if _only_there(samples, partial(spread, joints=triple)):
            names = ", ".join(str(i + 1) for i in triple[:2])
            return f"the axes of joints {names} and {triple[2] + 1} are all parallel to one plane"
    return None


def _parallel_row(chain: Chain, samples: Sequence[Sample]) -> str | None:
    for triple in combinations([i for i, joint in enumerate(chain.joints) if joint.kind == "R"], 3):
        always = all(parallel(found, triple[0], j) for found in (samples, around(samples)) for j in triple[1:])
        if always and _only_there(samples, partial(off_plane, row=triple)):
            names = ", ".join(str(i + 1) for i in triple[:2])
            return f"the parallel axes of joints {names} and {triple[2] + 1} lie in one plane"
    return None


def _far_from_slide(chain: Chain, samples: Sequence[Sample]) -> str | None:
    """Look for a slide from whose line a later joint has brought the point as far as it can."""
    for slide in (i for i, joint in enumerate(chain.joints) if joint.kind == "P"):
        for moving in range(slide + 1, min(chain.n, chain.point.frame)):
            if samples and all(_extreme(sample, slide, moving) == 1 for sample in samples):
                return f"the point is as far from the line of slide {slide + 1} as joint {moving + 1} can bring it"
    return None


def _slide_at_link(chain: Chain, samples: Sequence[Sample]) -> str | None:
    """Look for a slide that has come to lie along, or square to, the line that joins two parallel axes."""
    for slide in (i for i, joint in enumerate(chain.joints) if joint.kind == "P"):
        for i, j in _revolute_pairs(chain):
            if not samples or not parallel(samples, i, j):
                continue
            for across, how in ((False, "along"), (True, "at right angles to")):
                if _only_there(samples, partial(slant, slide=slide, i=i, j=j, across=across)):
                    return (
                        f"slide {slide + 1} runs {how} the line from the axis of joint {i + 1} to that of joint {j + 1}"
                    )
    return None


def _origin_on_axis(chain: Chain, samples: Sequence[Sample]) -> str | None:
    for axis in (i for i, joint in enumerate(chain.joints) if joint.kind == "R"):
        for frame in range(axis + 2, chain.n):
            moved = [Sample(sample.arm.with_point(frame), sample.q) for sample in samples]
            if _only_there(moved, partial(distance, joint=axis)):
                return f"the origin O{frame} lies on the axis of joint {axis + 1}"
    return None


def _extreme_reach(chain: Chain, samples: Sequence[Sample]) -> str | None:
    extremes = _extremes(chain, samples)
    if extremes is None:
        return None
    axis, movers, signs = extremes
    mover = f"joint {movers[0] + 1}"
    if chain.joints[movers[0]].kind == "P":
        return f"arm drawn in: the point is as near to the axis of joint {axis + 1} as {mover} can bring it"
    if all(parallel(samples, axis, moving) for moving in movers):
        return _EXTENDED[signs]
    if signs == frozenset({1, -1}):
        return f"the point is as far from or as near to the axis of joint {axis + 1} as {mover} can bring it"
    how = "far from" if 1 in signs else "near to"
    return f"the point is as {how} the axis of joint {axis + 1} as {mover} can bring it"


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
        movers = [moving for moving in later if samples and 0 not in signs[moving]]
        if movers:
            each = (all(signs[moving][i] == 1 for moving in movers) for i in range(len(samples)))
            return axis, movers, frozenset(1 if farthest else -1 for farthest in each)
    return None


def _extreme(sample: Sample, axis: int, moving: int) -> int:
    step = 1e-3
    away = np.zeros(len(sample.q))
    away[moving] = step
    middle, ahead, behind = (distance(sample, sample.q + side * away, axis) for side in (0, 1, -1))
    if abs(ahead - behind) > 1e-3 * abs(ahead + behind - 2 * middle) or abs(ahead + behind - 2 * middle) < 1e-9:
        return 0
    return 1 if middle > ahead else -1
