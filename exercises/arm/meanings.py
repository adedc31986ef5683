"""Statements about what configurations look like: on an axis, collinear axes, stretched out; tested at samples.

A meaning is a statement that is true or false of a configuration. For a branch of the singular set, a meaning that
holds everywhere on it, and at no regular configuration (`reason`), is right; those that hold nowhere on it are wrong.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product

import numpy as np

from qdot.exercises.arm.axes import (
    Off,
    Sample,
    bend,
    distance,
    nearby_pose,
    off_common_direction,
    off_level,
    off_line,
    parallel,
    slant,
    slope,
    spread,
)
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinds import kinds_at
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.reason import is_reason

NEAR, APART = 1e-6, 0.02
"""What counts as zero, and as clearly not zero, in metres or as a sine."""

STEP = 1e-3


@dataclass(frozen=True)
class Meaning:
    """A statement of joints (from 1), in words; `kind` is "on axis", "in line", "far" or "near" and the like."""

    kind: str
    joints: tuple[int, ...]
    words: str


@dataclass(frozen=True)
class Reading:
    """What a branch looks like: the right meaning, and wrong ones."""

    right: Meaning
    wrong: tuple[Meaning, ...]


def read_meanings(chain: Chain, samples: Sequence[Sample], more: Sequence[Sample] = ()) -> Reading | None:
    """Return the reading of configurations, or None if no statement is true at all of them or none is false at all.

    A statement that holds at the `samples` may be false elsewhere: the right one is false at none of `more`, either.
    """
    if len(samples) < 4:
        return None
    outcomes_by_meaning = [
        (meaning, {holds(chain, meaning, sample) for sample in samples}) for meaning in meanings_of(chain, samples)
    ]
    held = [meaning for meaning, outcomes in outcomes_by_meaning if outcomes == {True}]
    right = next((meaning for meaning in held if _is_right(chain, meaning, samples, more)), None)
    wrong = [meaning for meaning, outcomes in outcomes_by_meaning if outcomes == {False}]
    return Reading(right, tuple(wrong)) if right is not None and wrong else None


def _is_right(chain: Chain, meaning: Meaning, samples: Sequence[Sample], more: Sequence[Sample]) -> bool:
    if not is_reason(chain, samples, measure(meaning), partial(_is_true, chain, meaning)):
        return False
    return all(holds(chain, meaning, sample) is not False for sample in more)


def common_kind(chain: Chain, samples: Sequence[Sample]) -> str | None:
    """Return "boundary" or "internal" if all configurations are of that kind, else None."""
    kinds = set(kinds_at(chain, samples))
    return kinds.pop() if len(kinds) == 1 else None


def meanings_of(chain: Chain, samples: Sequence[Sample]) -> list[Meaning]:
    """Return all statements that would explain a loss of rank, the most informative first.

    If rotations count, collinear axes are the reason, and P on one of them may be incidental. If only rotations count,
    it does not matter where P is.
    """
    revolute = [i for i, joint in enumerate(chain.joints) if joint.kind == "R"]
    in_line = [
        Meaning("in line", (i + 1, j + 1), f"the axes of joints {i + 1} and {j + 1} lie on one line")
        for i, j in combinations(revolute, 2)
        if not _holds_nearby(samples, partial(off_line, i=i, j=j))
    ]
    if not chain.linear_rows:
        return in_line + _directions_of_axes(samples, revolute)
    meanings = [
        Meaning("on axis", (i + 1,), f"$P$ lies on the axis of joint {i + 1}")
        for i in revolute
        if i < chain.point.frame and not _holds_nearby(samples, partial(distance, joint=i))
    ]
    turns_count = len(chain.linear_rows) < len(chain.task)
    meanings = in_line + meanings if turns_count else meanings + in_line
    for i in revolute:
        for j in range(i + 1, min(chain.n, chain.point.frame)):
            meanings += _extremes(chain, samples, i, j)
    slides = _slides_at_links(chain, samples) if turns_count else []
    meanings += [meaning for meaning in slides if meaning.kind == "across"]
    # A prismatic joint passes through zero, which changes the order of the origins without being singular.
    rigid = [k for k in range(1, chain.n) if chain.joints[k - 1].kind == chain.joints[k].kind == "R"]
    meanings += [meaning for k in rigid for meaning in _origins_in_line(chain, samples, k)]
    meanings += [meaning for meaning in slides if meaning.kind == "along"]
    return meanings + _in_one_plane(chain, samples, revolute) + _common_direction(chain, samples)


def _directions_of_axes(samples: Sequence[Sample], revolute: Sequence[int]) -> list[Meaning]:
    """Return the statements about the directions of the axes, wherever they are."""
    meanings = [
        Meaning("parallel", (i + 1, j + 1), f"the axes of joints {i + 1} and {j + 1} are parallel")
        for i, j in combinations(revolute, 2)
        if not _holds_nearby(samples, partial(spread, joints=(i, j)))
    ]
    for chosen in combinations(revolute, 3):
        if not _holds_nearby(samples, partial(spread, joints=chosen)):
            joints = tuple(i + 1 for i in chosen)
            names = f"{joints[0]}, {joints[1]} and {joints[2]}"
            meanings.append(Meaning("one plane", joints, f"the axes of joints {names} are all parallel to one plane"))
            meanings.append(Meaning("square", joints, f"the axes of joints {names} are at right angles to each other"))
    return meanings


def _slides_at_links(chain: Chain, samples: Sequence[Sample]) -> list[Meaning]:
    """Return the statements about prismatic joints along or across links between parallel axes, if not always so."""
    kinds = [joint.kind for joint in chain.joints]
    links = [i for i in range(chain.n - 1) if kinds[i : i + 2] == ["R", "R"] and chain.joints[i].a != 0]
    meanings = []
    for slide, i in product([k for k, kind in enumerate(kinds) if kind == "P"], links):
        if not parallel(samples, i, i + 1):
            continue
        link, joints = f"the line from the axis of joint {i + 1} to that of joint {i + 2}", (slide + 1, i + 1, i + 2)
        for kind, how in (("along", "along"), ("across", "at right angles to")):
            if not _holds_nearby(samples, partial(slant, slide=slide, i=i, j=i + 1, across=kind == "across")):
                meanings.append(Meaning(kind, joints, f"slide {slide + 1} runs {how} {link}"))
    return meanings


def _origins_in_line(chain: Chain, samples: Sequence[Sample], k: int) -> list[Meaning]:
    """Return the statements about three successive origins, the middle one being O_k, if no two of them coincide.

    They have the names of the arm's convention, and are left out if it has no name for one of them.
    """
    names = [convention_of(chain).place(frame) for frame in (k - 1, k, k + 1)]
    sizes = [np.linalg.norm(np.diff(s.arm.frames(s.q)[k - 1 : k + 2, :3, 3], axis=0), axis=1).min() for s in samples]
    if None in names or min(sizes) < APART or _holds_nearby(samples, partial(_off_collinear, k=k)):
        return []
    line = f"${names[0]}$, ${names[1]}$ and ${names[2]}$ lie on one line"
    return [
        Meaning("straight", (k,), f"{line}, ${names[1]}$ between the others"),
        Meaning("doubled", (k,), f"{line}, ${names[1]}$ not between the others"),
    ]


def _off_collinear(arm: NumericChain, q: np.ndarray, k: int) -> np.ndarray:
    """Return how far three successive origins are from collinear."""
    return bend(arm, q, k)[0]


def _in_one_plane(chain: Chain, samples: Sequence[Sample], revolute: Sequence[int]) -> list[Meaning]:
    """Return the statement that the point and all axes lie in one plane, for an arm whose axes are all parallel."""
    if len(chain.linear_rows) != len(chain.task) or len(revolute) != chain.n or chain.n < 3:
        return []
    if not all(parallel(samples, 0, i) for i in revolute):
        return []
    return [Meaning("level", tuple(i + 1 for i in revolute), "$P$ and the axes of all joints lie in one plane")]


def _common_direction(chain: Chain, samples: Sequence[Sample]) -> list[Meaning]:
    """Return the statements about two joints that move the point along one line, if that depends on the pose."""
    moving = range(min(chain.n, chain.point.frame))
    sizes = np.min([np.linalg.norm(s.arm.jacobian(s.q)[:3], axis=0) for s in samples], axis=0)
    return [
        Meaning("one way", (i + 1, j + 1), f"joints {i + 1} and {j + 1} move $P$ along the same line")
        for i, j in combinations(moving, 2)
        if min(sizes[i], sizes[j]) > APART and not _holds_nearby(samples, partial(off_common_direction, joints=(i, j)))
    ]


def _extremes(chain: Chain, samples: Sequence[Sample], i: int, j: int) -> list[Meaning]:
    if not _changes_distance(samples, i, j):
        return []
    bringing = f"from the axis of joint {i + 1} as joint {j + 1} can bring it"
    near = Meaning("near", (i + 1, j + 1), f"$P$ is as near to{bringing.removeprefix('from')}")
    if chain.joints[j].kind == "P":
        return [near]
    far = Meaning("far", (i + 1, j + 1), f"$P$ is as far {bringing}")
    others = [k for k in range(i + 1, min(chain.n, chain.point.frame)) if k != j]
    if parallel(samples, i, j) and not any(_changes_distance(samples, i, k) for k in others):
        far = Meaning("far", far.joints, f"the arm is stretched out: {far.words}")
        near = Meaning("near", near.joints, f"the arm is folded back: {near.words}")
    return [far, near]


def _changes_distance(samples: Sequence[Sample], i: int, j: int) -> bool:
    """Tell whether a joint changes how far the point is from an axis, in poses beside the samples."""
    distances = (distance(s.arm, np.stack([nearby_pose(s), nearby_pose(s, j)]), i) for s in samples)
    return all(abs(before - after) > 1e-9 for before, after in distances)


def measure(meaning: Meaning) -> Off:
    """Return the measure that is zero if a statement holds; "straight" and "doubled", "far" and "near" share one."""
    i, j = meaning.joints[0] - 1, meaning.joints[-1] - 1
    joints = [joint - 1 for joint in meaning.joints]
    if meaning.kind in ("along", "across"):
        return partial(slant, slide=i, i=joints[1], j=j, across=meaning.kind == "across")
    by_kind: dict[str, Off] = {
        "on axis": partial(distance, joint=i),
        "in line": partial(off_line, i=i, j=j),
        "parallel": partial(spread, joints=joints),
        "one plane": partial(spread, joints=joints),
        "square": partial(_off_square, joints=joints),
        "straight": partial(_off_collinear, k=i + 1),
        "doubled": partial(_off_collinear, k=i + 1),
        "level": off_level,
        "one way": partial(off_common_direction, joints=joints),
    }
    return by_kind.get(meaning.kind, partial(slope, joint=i, movers=[j]))


def _off_square(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return how far axes are from being at right angles to each other."""
    return np.asarray(1 - spread(arm, q, joints))


def holds(chain: Chain, meaning: Meaning, sample: Sample) -> bool | None:
    """Tell whether a statement is true of a configuration; None if that is not clear."""
    i, j = meaning.joints[0] - 1, meaning.joints[-1] - 1
    if meaning.kind in ("far", "near"):
        return _is_extreme(chain, meaning.kind, sample, i, j)
    is_zero = _decide_zero(sample.off(measure(meaning)))
    if is_zero and meaning.kind in ("straight", "doubled"):
        return bool(bend(sample.arm, sample.q[None], i + 1)[1][0] > 0) == (meaning.kind == "straight")
    return is_zero


def _is_true(chain: Chain, meaning: Meaning, sample: Sample) -> bool:
    return holds(chain, meaning, sample) is True


def _is_extreme(chain: Chain, kind: str, sample: Sample, i: int, j: int) -> bool | None:
    """Tell whether joint j alone can bring the point no farther from (no nearer to) axis i."""
    others = np.linspace(0, 2 * np.pi, 73)[1:-1] if chain.joints[j].kind == "R" else np.linspace(-2, 2, 81)
    changes = np.zeros((len(others) + 2, len(sample.q)))
    changes[:, j] = [STEP, -STEP, *others]
    distances = distance(sample.arm, sample.q + np.vstack([np.zeros(len(sample.q)), changes]), i)
    middle, change = float(distances[0]), distances[1:] - distances[0]
    if abs(change[0] - change[1]) / (2 * STEP) > NEAR and middle > NEAR:
        return False if abs(change[0] - change[1]) / (2 * STEP) > APART / 20 else None
    beyond = float(change.max() if kind == "far" else -change.min())
    return True if beyond < NEAR else False if beyond > APART / 20 else None


def _decide_zero(size: float) -> bool | None:
    return True if size < NEAR else False if size > APART / 20 else None


def _holds_nearby(samples: Sequence[Sample], off: Off) -> bool:
    """Tell whether a relation holds in the poses near the samples, too: then it says nothing about the samples."""
    return all(sample.off_nearby(off) < NEAR for sample in samples)
