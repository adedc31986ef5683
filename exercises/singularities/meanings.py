"""Find true and false statements about what singular configurations look like, for questions with options.

A *branch* is a part of the singular set. A statement, such as "the axes of joints 1 and 3 coincide", is called the
*meaning* of a branch. The meaning is correct if it holds everywhere on the branch and at no regular configuration
(`reason`). The meaning is wrong if it holds nowhere on the branch.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
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
    choose_nearby_configuration,
    measure_axis_distance,
    measure_axis_spread,
    measure_collinearity,
    measure_common_direction,
    measure_coplanarity,
    measure_distance_change,
    measure_origin_collinearity,
    measure_prismatic_slant,
    measure_samples,
    move_samples,
)
from qdot.exercises.singularities.reason import is_reason

ZERO_TOLERANCE, NONZERO_THRESHOLD = 1e-6, 1e-3
"""Tolerances (m, or a sine): below the first, a measure counts as zero; above the second, it is clearly nonzero."""
MIN_SIZE = 0.02
"""Minimum distance (m) of two origins, and minimum speed of P (m/s) for a unit joint rate, in statements about them."""
MIN_SAMPLE_COUNT = 4
"""If a branch has fewer samples than this, statements about the branch are too uncertain."""

DIFFERENCE_STEP = 1e-3
"""Step of a joint variable (rad or m) for finite differences."""
TRIED_ANGLES, TRIED_DISPLACEMENTS = np.linspace(0, 2 * np.pi, 73)[1:-1], np.linspace(-2, 2, 81)
"""The rotations (rad, every 5°) and displacements (m) of a joint that are tried. They show whether P can be farther
from an axis, or nearer to it, than at a sample."""


@dataclass(frozen=True)
class Meaning:
    """A statement about joints (counted from 1), with its text.

    The `kind` is a short name, such as "on axis" or "far".
    """

    kind: str
    joints: tuple[int, ...]
    words: str

    @property
    def remark(self) -> str:
        """The remark before the statement, such as "the arm is stretched out"; "" if there is none."""
        return self.words.rpartition(": ")[0]

    def without_remark(self) -> "Meaning":
        """Return the statement without the remark before it."""
        return replace(self, words=self.words.rpartition(": ")[2])


@dataclass(frozen=True)
class MeasuredMeaning(Meaning):
    """A statement with a measure that is zero if the statement holds.

    Statements of the kinds "straight" and "doubled" have the same measure, and so have "far" and "near". Then `holds`
    finds out which of the two is true.
    """

    measure: Measure

    def without_measure(self) -> Meaning:
        """Return the statement without its measure, as problems store it."""
        return Meaning(self.kind, self.joints, self.words)


@dataclass(frozen=True)
class BranchMeanings:
    """The correct meaning of a branch, and wrong meanings."""

    correct: Meaning
    wrong: tuple[Meaning, ...]


def find_branch_meanings(
    chain: Chain, samples: Sequence[Sample], further_samples: Sequence[Sample] = ()
) -> BranchMeanings | None:
    """Return the correct meaning and the wrong meanings of a branch; None if one of them is missing.

    The `samples` are configurations on the branch. A statement that holds at all of them may be false elsewhere on the
    branch. Therefore the correct meaning must not be false at any of `further_samples`, either.
    """
    if len(samples) < MIN_SAMPLE_COUNT:
        return None
    meanings = list_candidate_meanings(chain, samples)
    truth_values = [(meaning, {holds(chain, meaning, sample) for sample in samples}) for meaning in meanings]
    true_meanings = [meaning for meaning, values in truth_values if values == {True}]
    wrong_meanings = [meaning for meaning, values in truth_values if values == {False}]

    def is_correct(meaning: MeasuredMeaning) -> bool:
        if not is_reason(chain, samples, meaning.measure, lambda sample: holds(chain, meaning, sample) is True):
            return False
        return all(holds(chain, meaning, sample) is not False for sample in further_samples)

    correct_meaning = next(filter(is_correct, true_meanings), None)
    if correct_meaning is None or not wrong_meanings:
        return None
    stored_wrong_meanings = (meaning.without_measure() for meaning in wrong_meanings)
    return BranchMeanings(correct_meaning.without_measure(), tuple(stored_wrong_meanings))


def _make_meaning(kind: str, joints: Sequence[int], words: str, measure: Measure) -> MeasuredMeaning:
    """Return a statement about joints (from 0); the braces in `words` stand for the joints' numbers (from 1)."""
    numbers = tuple(joint + 1 for joint in joints)
    return MeasuredMeaning(kind, numbers, words.format(*numbers), measure)


def list_candidate_meanings(chain: Chain, samples: Sequence[Sample]) -> list[MeasuredMeaning]:
    """Return the statements that might explain a loss of rank; the most informative statements come first.

    If the task has angular rows, collinear axes come first, because P on one of these axes may be incidental. If the
    task has only angular rows, there are no statements about the position of P, which does not matter.
    """
    revolute_joints = chain.revolute_joints
    collinear_meanings = [
        _make_meaning(
            "in line", pair, "the axes of joints {} and {} coincide", partial(measure_collinearity, joints=pair)
        )
        for pair in combinations(revolute_joints, 2)
    ]
    if not chain.linear_axes:
        return _select_special(samples, collinear_meanings) + _list_direction_meanings(samples, revolute_joints)
    point_meanings = [
        _make_meaning("on axis", (i,), "$P$ lies on the axis of joint {}", partial(measure_axis_distance, joint=i))
        for i in revolute_joints
        if i < chain.point.frame
    ]
    has_angular_rows = len(chain.linear_axes) < len(chain.task)
    groups = (collinear_meanings, point_meanings) if has_angular_rows else (point_meanings, collinear_meanings)
    meanings = _select_special(samples, [meaning for group in groups for meaning in group])
    for i in revolute_joints:
        for j in range(i + 1, chain.point.frame):
            meanings += _list_extreme_meanings(chain, samples, i, j)
    parallel_meanings, perpendicular_meanings = (
        _list_prismatic_meanings(chain, samples, is_perpendicular) if has_angular_rows else []
        for is_perpendicular in (False, True)
    )
    # A prismatic joint that passes through zero changes the order of the origins, but that is not a singularity.
    rigid_links = [k for k in range(1, chain.n) if chain.joints[k - 1].is_revolute and chain.joints[k].is_revolute]
    origin_meanings = [meaning for k in rigid_links for meaning in _list_origin_meanings(chain, samples, k)]
    meanings += _select_special(samples, [*perpendicular_meanings, *origin_meanings, *parallel_meanings])
    meanings += _list_plane_meanings(chain, samples)
    return meanings + _select_special(samples, _list_common_direction_meanings(chain, samples))


def _select_special(samples: Sequence[Sample], meanings: Sequence[MeasuredMeaning]) -> list[MeasuredMeaning]:
    """Return the statements that are false near the samples; statements that hold there, too, explain nothing."""
    nearby_samples = move_samples(samples)
    return [meaning for meaning in meanings if measure_samples(nearby_samples, meaning.measure).max() >= ZERO_TOLERANCE]


def _list_direction_meanings(samples: Sequence[Sample], revolute_joints: Sequence[int]) -> list[MeasuredMeaning]:
    """Return the statements about the directions of the axes, regardless of the positions of the axes."""
    words = "the axes of joints {} and {} are parallel"
    parallel_meanings = [
        _make_meaning("parallel", pair, words, partial(measure_axis_spread, joints=pair))
        for pair in combinations(revolute_joints, 2)
    ]
    meanings = _select_special(samples, parallel_meanings)
    axes = "the axes of joints {}, {} and {} are"
    for joints in combinations(revolute_joints, 3):
        spread = partial(measure_axis_spread, joints=joints)
        plane_meaning = _make_meaning("one plane", joints, f"{axes} all parallel to one plane", spread)
        if _select_special(samples, [plane_meaning]):
            measure, words = partial(_measure_perpendicularity, joints=joints), f"{axes} at right angles to each other"
            meanings += [plane_meaning, _make_meaning("square", joints, words, measure)]
    return meanings


def _list_prismatic_meanings(chain: Chain, samples: Sequence[Sample], is_perpendicular: bool) -> list[MeasuredMeaning]:
    """Return the statements that a prismatic joint moves along a link between parallel axes, or perpendicular to it."""
    is_revolute = [joint.is_revolute for joint in chain.joints]
    links = [i for i in range(chain.n - 1) if all(is_revolute[i : i + 2]) and chain.joints[i].a != 0]
    kind, preposition = ("across", "at right angles to") if is_perpendicular else ("along", "along")
    words = f"prismatic joint {{}} moves {preposition} the line from the axis of joint {{}} to that of joint {{}}"
    measure = partial(measure_prismatic_slant, is_perpendicular=is_perpendicular)
    return [
        _make_meaning(kind, (p, i, i + 1), words, partial(measure, prismatic_joint=p, i=i, j=i + 1))
        for p, i in product(chain.prismatic_joints, links)
        if are_parallel(samples, i, i + 1)
    ]


def _list_origin_meanings(chain: Chain, samples: Sequence[Sample], k: int) -> list[MeasuredMeaning]:
    """Return the statements about the origins O_{k-1}, O_k and O_{k+1} if no two of them coincide.

    The statements use the names of the origins in the arm's convention. Return no statement if an origin has no name.
    """
    names = [convention_of(chain).name_origin(frame) for frame in (k - 1, k, k + 1)]
    distances = [np.linalg.norm(np.diff(s.frames[k - 1 : k + 2, :3, 3], axis=0), axis=1).min() for s in samples]
    if None in names or min(distances) < MIN_SIZE:
        return []
    line = f"${names[0]}$, ${names[1]}$ and ${names[2]}$ are collinear, with ${names[1]}$"
    measure = partial(measure_origin_collinearity, k=k)
    return [
        MeasuredMeaning("straight", (k,), f"{line} between the others", measure),
        MeasuredMeaning("doubled", (k,), f"{line} not between the others", measure),
    ]


def _list_plane_meanings(chain: Chain, samples: Sequence[Sample]) -> list[MeasuredMeaning]:
    """Return the statement that the point and all axes lie in one plane; [] unless all axes are parallel."""
    if len(chain.linear_axes) != len(chain.task) or chain.prismatic_joints or chain.n < 3:
        return []
    if not all(are_parallel(samples, 0, i) for i in range(chain.n)):
        return []
    words = "$P$ and the axes of all joints lie in one plane"
    measure = partial(measure_coplanarity, joints=range(chain.n), includes_point=True)
    return [_make_meaning("level", range(chain.n), words, measure)]


def _list_common_direction_meanings(chain: Chain, samples: Sequence[Sample]) -> list[MeasuredMeaning]:
    """Return the statements that two joints move the point along the same line."""
    moving_joints = range(chain.point.frame)
    speeds = np.min([np.linalg.norm(s.arm.compute_jacobian(s.q)[:3], axis=0) for s in samples], axis=0)
    return [
        _make_meaning("one way", (i, j), "joints {} and {} move $P$ along the same line",
                    partial(measure_common_direction, joints=(i, j)))
        for i, j in combinations(moving_joints, 2)
        if min(speeds[i], speeds[j]) > MIN_SIZE
    ]  # fmt: skip


def _list_extreme_meanings(chain: Chain, samples: Sequence[Sample], i: int, j: int) -> list[MeasuredMeaning]:
    """Return the statements that joint j brings P as far from axis i, or as near to it, as possible."""
    if not _changes_distance(samples, i, j):
        return []
    measure = partial(measure_distance_change, joint=i, moving_joints=[j])
    axis = "the axis of joint {} as joint {} can bring it"
    far_words, near_words = f"$P$ is as far from {axis}", f"$P$ is as near to {axis}"
    if chain.joints[j].is_prismatic:
        return [_make_meaning("near", (i, j), near_words, measure)]
    other_joints = [k for k in range(i + 1, chain.point.frame) if k != j]
    if are_parallel(samples, i, j) and not any(_changes_distance(samples, i, k) for k in other_joints):
        far_words, near_words = f"the arm is stretched out: {far_words}", f"the arm is folded back: {near_words}"
    return [_make_meaning("far", (i, j), far_words, measure), _make_meaning("near", (i, j), near_words, measure)]


def _changes_distance(samples: Sequence[Sample], i: int, j: int) -> bool:
    """Return whether joint j changes the distance of P from axis i at configurations near the samples."""
    pairs = ((s.arm, np.stack([choose_nearby_configuration(s), choose_nearby_configuration(s, j)])) for s in samples)
    return all(abs(np.diff(measure_axis_distance(arm, q, i))) > 1e-9 for arm, q in pairs)


def _measure_perpendicularity(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return how far three axes are from being perpendicular to each other, from 0 to 1."""
    return np.asarray(1 - measure_axis_spread(arm, q, joints))


def holds(chain: Chain, meaning: MeasuredMeaning, sample: Sample) -> bool | None:
    """Return whether a statement is true at a configuration; None if that is not clear."""
    i, j = meaning.joints[0] - 1, meaning.joints[-1] - 1
    if meaning.kind in ("far", "near"):
        return _is_extreme(chain, meaning.kind, sample, i, j)
    is_zero = _is_zero(sample.evaluate(meaning.measure))
    if is_zero and meaning.kind in ("straight", "doubled"):
        step, next_step = np.diff(sample.frames[i : i + 3, :3, 3], axis=0)
        return bool(step @ next_step > 0) == (meaning.kind == "straight")
    return is_zero


def _is_zero(error: float) -> bool | None:
    """Return whether an error is zero up to rounding; None if it is neither clearly zero nor clearly nonzero."""
    return True if error < ZERO_TOLERANCE else False if error > NONZERO_THRESHOLD else None


def _is_extreme(chain: Chain, kind: str, sample: Sample, i: int, j: int) -> bool | None:
    """Return whether joint j alone can bring P no farther from axis i (`kind` "far"), or no nearer to it ("near").

    Return None if that is not clear.
    """
    steps = TRIED_ANGLES if chain.joints[j].is_revolute else TRIED_DISPLACEMENTS
    displacements = np.zeros((len(steps) + 3, len(sample.q)))
    displacements[1:, j] = [DIFFERENCE_STEP, -DIFFERENCE_STEP, *steps]
    distances = measure_axis_distance(sample.arm, sample.q + displacements, i)
    changes = distances[1:] - distances[0]
    slope = abs(changes[0] - changes[1]) / (2 * DIFFERENCE_STEP)
    if slope > ZERO_TOLERANCE and distances[0] > ZERO_TOLERANCE:  # on the axis, the distance has a kink, no slope
        return _is_zero(slope)
    return _is_zero(changes.max() if kind == "far" else -changes.min())
