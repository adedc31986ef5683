"""Make statements about what configurations look like, such as collinear axes, and test them at samples.

A meaning is a statement that is true or false for a configuration. For a branch of the singular set, a meaning is
correct if it holds everywhere on the branch and at no regular configuration (`reason`). It is wrong if it holds nowhere
on the branch.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.singularities.axes import (
    Measure,
    Sample,
    are_parallel,
    arm_coplanarity_error,
    axis_distance,
    axis_distance_derivative,
    axis_spread,
    collinearity_error,
    common_direction_error,
    measure_samples,
    nearby_configuration,
    nearby_samples,
    origin_collinearity_error,
    prismatic_slant,
)
from qdot.exercises.singularities.reason import is_reason

ZERO_TOLERANCE, NONZERO_THRESHOLD = 1e-6, 0.02
"""Tolerances in metres or as a sine: below the first, a measure is zero; above the second, it is clearly nonzero."""

DIFFERENCE_STEP = 1e-3
"""Step of a joint variable for finite differences."""


@dataclass(frozen=True)
class Meaning:
    """A statement about joints (from 1), with its text; `kind` is for example "on axis", "in line" or "far"."""

    kind: str
    joints: tuple[int, ...]
    words: str


@dataclass(frozen=True)
class MeasuredMeaning(Meaning):
    """A statement with a measure that is zero if the statement holds.

    "straight" and "doubled" share a measure, as do "far" and "near".
    """

    measure: Measure

    def without_measure(self) -> Meaning:
        """Return the statement alone, as problems store it."""
        return Meaning(self.kind, self.joints, self.words)


@dataclass(frozen=True)
class BranchMeanings:
    """What a branch looks like: the correct meaning, and wrong ones."""

    correct: Meaning
    wrong: tuple[Meaning, ...]


def find_branch_meanings(
    chain: Chain, samples: Sequence[Sample], further_samples: Sequence[Sample] = ()
) -> BranchMeanings | None:
    """Return the correct and the wrong meanings of a branch, or None if there is no correct or no wrong one.

    The `samples` are configurations on the branch. A statement that holds at all of them may be false elsewhere, so the
    correct one must not be false at any sample of `further_samples`, either.
    """
    if len(samples) < 4:
        return None
    meanings = candidate_meanings(chain, samples)
    outcomes = [{holds(chain, meaning, sample) for sample in samples} for meaning in meanings]
    pairs = list(zip(meanings, outcomes, strict=True))
    true, wrong = ([meaning for meaning, outcome in pairs if outcome == {truth}] for truth in (True, False))
    correct = next((meaning for meaning in true if _is_correct(chain, meaning, samples, further_samples)), None)
    if correct is None or not wrong:
        return None
    return BranchMeanings(correct.without_measure(), tuple(meaning.without_measure() for meaning in wrong))


def _is_correct(
    chain: Chain, meaning: MeasuredMeaning, samples: Sequence[Sample], further_samples: Sequence[Sample]
) -> bool:
    """Return whether a meaning explains the singularity at `samples` and is not false at any of `further_samples`."""
    if not is_reason(chain, samples, meaning.measure, lambda sample: holds(chain, meaning, sample) is True):
        return False
    return all(holds(chain, meaning, sample) is not False for sample in further_samples)


def _meaning_of(kind: str, joints: Sequence[int], words: str, measure: Measure) -> MeasuredMeaning:
    """Return a statement about joints (from 0); the braces in `words` stand for their numbers (from 1)."""
    numbers = tuple(joint + 1 for joint in joints)
    return MeasuredMeaning(kind, numbers, words.format(*numbers), measure)


def candidate_meanings(chain: Chain, samples: Sequence[Sample]) -> list[MeasuredMeaning]:
    """Return all statements that might explain a loss of rank; the most informative come first.

    If the task has angular rows, collinear axes are the reason, and P on one of them may be incidental. If it has only
    angular rows, the position of P does not matter.
    """
    revolute = [i for i, joint in enumerate(chain.joints) if joint.kind == "R"]
    collinear = [
        _meaning_of("in line", pair, "the axes of joints {} and {} coincide", partial(collinearity_error, joints=pair))
        for pair in combinations(revolute, 2)
    ]
    if not chain.linear_rows:
        return _special_meanings(samples, collinear) + _directions_of_axes(samples, revolute)
    on_axis = [
        _meaning_of("on axis", (i,), "$P$ lies on the axis of joint {}", partial(axis_distance, joint=i))
        for i in revolute
        if i < chain.point.frame
    ]
    has_angular_rows = len(chain.linear_rows) < len(chain.task)
    meanings = _special_meanings(samples, collinear + on_axis if has_angular_rows else on_axis + collinear)
    for i in revolute:
        for j in range(i + 1, min(chain.n, chain.point.frame)):
            meanings += _extreme_meanings(chain, samples, i, j)
    at_links = _prismatic_at_links(chain, samples) if has_angular_rows else []
    # A prismatic joint passes through zero, which changes the order of the origins without being singular.
    rigid = [k for k in range(1, chain.n) if chain.joints[k - 1].kind == chain.joints[k].kind == "R"]
    origins = [meaning for k in rigid for meaning in _origins_in_line(chain, samples, k)]
    across, along = ([meaning for meaning in at_links if meaning.kind == kind] for kind in ("across", "along"))
    meanings += _special_meanings(samples, [*across, *origins, *along])
    meanings += _in_one_plane(chain, samples, revolute)
    return meanings + _special_meanings(samples, _common_direction(chain, samples))


def _special_meanings(samples: Sequence[Sample], meanings: Sequence[MeasuredMeaning]) -> list[MeasuredMeaning]:
    """Return the statements that do not also hold near the samples; other statements say nothing about the samples."""
    nearby = nearby_samples(samples)
    return [meaning for meaning in meanings if measure_samples(nearby, meaning.measure).max() >= ZERO_TOLERANCE]


def _directions_of_axes(samples: Sequence[Sample], revolute: Sequence[int]) -> list[MeasuredMeaning]:
    """Return the statements about the directions of the axes, regardless of their positions."""
    pairs = [
        _meaning_of("parallel", pair, "the axes of joints {} and {} are parallel", partial(axis_spread, joints=pair))
        for pair in combinations(revolute, 2)
    ]
    meanings = _special_meanings(samples, pairs)
    axes = "the axes of joints {}, {} and {} are"
    for chosen in combinations(revolute, 3):
        in_plane, at_right_angles = (partial(error, joints=chosen) for error in (axis_spread, _perpendicularity_error))
        plane = _meaning_of("one plane", chosen, f"{axes} all parallel to one plane", in_plane)
        square = _meaning_of("square", chosen, f"{axes} at right angles to each other", at_right_angles)
        meanings += [plane, square] if _special_meanings(samples, [plane]) else []
    return meanings


def _prismatic_at_links(chain: Chain, samples: Sequence[Sample]) -> list[MeasuredMeaning]:
    """Return the statements about prismatic joints along or across links between parallel axes."""
    kinds = [joint.kind for joint in chain.joints]
    links = [i for i in range(chain.n - 1) if kinds[i : i + 2] == ["R", "R"] and chain.joints[i].a != 0]
    line = "the line from the axis of joint {} to that of joint {}"
    return [
        _meaning_of(kind, (prismatic, i, i + 1), f"prismatic joint {{}} moves {how} {line}",
                    partial(prismatic_slant, prismatic=prismatic, i=i, j=i + 1, across=kind == "across"))
        for prismatic, i in product([k for k, kind in enumerate(kinds) if kind == "P"], links)
        if are_parallel(samples, i, i + 1)
        for kind, how in (("along", "along"), ("across", "at right angles to"))
    ]  # fmt: skip


def _origins_in_line(chain: Chain, samples: Sequence[Sample], k: int) -> list[MeasuredMeaning]:
    """Return the statements about three successive origins, with O_k in the middle, if no two of them coincide.

    The origins have the names of the arm's convention. Return no statement if it has no name for one of them.
    """
    names = [convention_of(chain).origin_name(frame) for frame in (k - 1, k, k + 1)]
    sizes = [np.linalg.norm(np.diff(s.arm.frames(s.q)[k - 1 : k + 2, :3, 3], axis=0), axis=1).min() for s in samples]
    if None in names or min(sizes) < NONZERO_THRESHOLD:
        return []
    line = f"${names[0]}$, ${names[1]}$ and ${names[2]}$ are collinear, with ${names[1]}$"
    pairs = (("straight", "between the others"), ("doubled", "not between the others"))
    measure = partial(origin_collinearity_error, k=k)
    return [MeasuredMeaning(kind, (k,), f"{line} {position}", measure) for kind, position in pairs]


def _in_one_plane(chain: Chain, samples: Sequence[Sample], revolute: Sequence[int]) -> list[MeasuredMeaning]:
    """Return the statement that the point and all axes lie in one plane, for an arm whose axes are all parallel."""
    if len(chain.linear_rows) != len(chain.task) or len(revolute) != chain.n or chain.n < 3:
        return []
    if not all(are_parallel(samples, 0, i) for i in revolute):
        return []
    words = "$P$ and the axes of all joints lie in one plane"
    return [_meaning_of("level", revolute, words, arm_coplanarity_error)]


def _common_direction(chain: Chain, samples: Sequence[Sample]) -> list[MeasuredMeaning]:
    """Return the statements about two joints that move the point along the same line."""
    moving_joints = range(min(chain.n, chain.point.frame))
    sizes = np.min([np.linalg.norm(s.arm.jacobian(s.q)[:3], axis=0) for s in samples], axis=0)
    return [
        _meaning_of("one way", (i, j), "joints {} and {} move $P$ along the same line",
                    partial(common_direction_error, joints=(i, j)))
        for i, j in combinations(moving_joints, 2)
        if min(sizes[i], sizes[j]) > NONZERO_THRESHOLD
    ]  # fmt: skip


def _extreme_meanings(chain: Chain, samples: Sequence[Sample], i: int, j: int) -> list[MeasuredMeaning]:
    """Return the statements that joint j brings the point as far from, or as near to, axis i as it can."""
    if not _changes_distance(samples, i, j):
        return []
    measure = partial(axis_distance_derivative, joint=i, movers=[j])
    axis = "the axis of joint {} as joint {} can bring it"
    far, near = f"$P$ is as far from {axis}", f"$P$ is as near to {axis}"
    if chain.joints[j].kind == "P":
        return [_meaning_of("near", (i, j), near, measure)]
    others = [k for k in range(i + 1, min(chain.n, chain.point.frame)) if k != j]
    alone = are_parallel(samples, i, j) and not any(_changes_distance(samples, i, k) for k in others)
    stretched, folded = ("the arm is stretched out: ", "the arm is folded back: ") if alone else ("", "")
    return [
        _meaning_of("far", (i, j), f"{stretched}{far}", measure),
        _meaning_of("near", (i, j), f"{folded}{near}", measure),
    ]


def _changes_distance(samples: Sequence[Sample], i: int, j: int) -> bool:
    """Return whether a joint changes the distance of the point from an axis, at configurations near the samples."""
    pairs = ((s.arm, np.stack([nearby_configuration(s), nearby_configuration(s, j)])) for s in samples)
    return all(abs(np.diff(axis_distance(arm, q, i))) > 1e-9 for arm, q in pairs)


def _perpendicularity_error(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return how far axes are from being perpendicular to each other."""
    return np.asarray(1 - axis_spread(arm, q, joints))


def holds(chain: Chain, meaning: MeasuredMeaning, sample: Sample) -> bool | None:
    """Return whether a statement is true for a configuration; None if that is not clear."""
    i, j = meaning.joints[0] - 1, meaning.joints[-1] - 1
    if meaning.kind in ("far", "near"):
        return _is_extreme(chain, meaning.kind, sample, i, j)
    is_zero = _is_zero(sample.evaluate(meaning.measure))
    if is_zero and meaning.kind in ("straight", "doubled"):
        first, second = np.diff(sample.frames[i : i + 3, :3, 3], axis=0)
        return bool(first @ second > 0) == (meaning.kind == "straight")
    return is_zero


def _is_zero(error: float) -> bool | None:
    """Return whether an error is zero up to rounding; None if it is neither clearly zero nor clearly nonzero."""
    return True if error < ZERO_TOLERANCE else False if error > NONZERO_THRESHOLD / 20 else None


def _is_extreme(chain: Chain, kind: str, sample: Sample, i: int, j: int) -> bool | None:
    """Return whether joint j alone can bring the point no farther from (or no nearer to) axis i; None if not clear."""
    others = np.linspace(0, 2 * np.pi, 73)[1:-1] if chain.joints[j].kind == "R" else np.linspace(-2, 2, 81)
    changes = np.zeros((len(others) + 2, len(sample.q)))
    changes[:, j] = [DIFFERENCE_STEP, -DIFFERENCE_STEP, *others]
    distances = axis_distance(sample.arm, sample.q + np.vstack([np.zeros(len(sample.q)), changes]), i)
    change = distances[1:] - distances[0]
    slope = abs(change[0] - change[1]) / (2 * DIFFERENCE_STEP)
    if slope > ZERO_TOLERANCE and distances[0] > ZERO_TOLERANCE:
        return _is_zero(slope)
    return _is_zero(change.max() if kind == "far" else -change.min())
