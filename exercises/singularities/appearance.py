"""Describe what singular configurations look like, such as "arm stretched out", by testing statements at samples.

A statement is reported only if it is the reason for the singularity (`reason`), that is, if it holds at no regular
configuration. If there is no such statement, the description names joints with dependent columns of J, and says what
stays at rest while these joints move. If this would not be informative, the description says that there is no simple
meaning. In statements, "the point" is the point of interest.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain as chain_together
from itertools import combinations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, Point
from qdot.exercises.arm.conventions.base import NO_SIMPLE_MEANING
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.singularities.axes import (
    Measure,
    Sample,
    are_parallel,
    compute_jacobians,
    measure_axis_distance,
    measure_axis_spread,
    measure_collinearity,
    measure_common_direction,
    measure_coplanarity,
    measure_distance_change,
    measure_prismatic_slant,
    measure_samples,
    move_samples,
    stack_samples,
)
from qdot.exercises.singularities.reason import is_reason

ZERO_TOLERANCE, NONZERO_THRESHOLD = 1e-5, 1e-3
"""Tolerances (m, or a sine): below the first, a measure counts as zero; above the second, it is clearly nonzero."""
_DIFFERENCE_STEP = 1e-3
"""Step of a joint variable (rad or m) for numeric derivatives of the distance of the point from an axis."""
_MIN_CURVATURE = 1e-3
"""Minimum second derivative (m) that shows whether this distance is a maximum or a minimum."""
_CURVE_POINT_COUNT = 180
"""Number of angles of a joint at which this distance is compared with that at a sample."""


@dataclass(frozen=True)
class Statement:
    """A statement about what configurations look like.

    The statement holds at a configuration if `measure` is zero and `predicate` returns True.
    """

    words: str
    measure: Measure
    predicate: Callable[[Sample], bool] = lambda _: True

    def with_origin_as_point(self, frame: int, origin_name: str) -> "Statement":
        """Return the same statement about the origin of a frame instead of the point."""
        return Statement(
            self.words.replace("the point", origin_name),
            lambda arm, q: self.measure(arm.with_point(frame), q),
            lambda sample: self.predicate(Sample(sample.arm.with_point(frame), sample.q)),
        )

    def combine(self, other: "Statement") -> "Statement":
        """Return the statement that this statement and another one hold."""
        return Statement(
            f"{self.words}, and {other.words}",
            lambda arm, q: np.hypot(self.measure(arm, q), other.measure(arm, q)),
            lambda sample: self.predicate(sample) and other.predicate(sample),
        )


Finder = Callable[[Chain, Sequence[Sample]], Iterator[Statement]]
"""A function that yields the statements of one kind that hold at all samples, but not at configurations near them."""


def find_wrist_centre(chain: Chain) -> int | None:
    """Return the frame whose origin always lies on the axes of the last three joints; None if there is none."""
    wrist = chain.joints[-3:]
    if chain.n < 4 or any(joint.is_prismatic for joint in wrist):
        return None
    axes_meet = wrist[0].a == 0 and wrist[1].a == 0 and wrist[1].d == 0
    is_twisted = all((joint.alpha / sp.pi).is_integer is not True for joint in wrist[:2])
    return chain.n - 2 if axes_meet and is_twisted else None


def describe_appearance(chain: Chain, samples: Sequence[Sample]) -> str:
    """Describe why configurations are singular: what they look like, or else which joints are dependent."""
    statement = find_reason(chain, samples)
    return statement.words if statement else describe_dependence(chain, samples)


def find_reason(chain: Chain, samples: Sequence[Sample]) -> Statement | None:
    """Return a statement, or a combination of two, that is the reason why all samples are singular, or None."""
    if not samples:
        return None
    candidates: list[Statement] = []
    for statement in chain_together(find_statements(chain, samples), _find_axes_parallel_to_plane(chain, samples)):
        if is_reason(chain, samples, statement.measure, statement.predicate):
            return statement
        candidates.append(statement)
    pairs = (a.combine(b) for a, b in combinations(candidates, 2) if a.words != b.words)
    return next((pair for pair in pairs if is_reason(chain, samples, pair.measure, pair.predicate)), None)


def find_statements(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Yield statements that hold at all samples but not near them; the most specific statements come first."""
    has_angular_rows = any(row[0] == "w" for row in chain.task)
    if has_angular_rows and len(chain.task) == 3 and chain.linear_axes and chain.joints[-1].is_revolute and chain.n > 1:
        # the last joint sets the angle of a planar pose, and the other joints position the axis of the last joint
        yield from _find_coplanar_parallel_axes(chain, samples)
        position_chain = replace(chain, task=tuple(row for row in chain.task if row[0] == "v"))
        name = f"the axis of joint {chain.n}"
        yield from _find_origin_statements(position_chain, samples, chain.n - 1, name, _find_point_statements)
        return
    centre = find_wrist_centre(chain) if has_angular_rows else None
    if centre is None or chain.point == Point(centre):
        yield from _find_point_statements(chain, samples)
    else:
        yield from _find_origin_statements(chain, samples, centre, "the wrist centre", _find_point_statements)


def _find_origin_statements(
    chain: Chain, samples: Sequence[Sample], frame: int, origin_name: str, finder: Finder
) -> Iterator[Statement]:
    """Yield the statements of a finder, with the origin of a frame instead of the point.

    The statements call the origin `origin_name`.
    """
    moved_samples = [Sample(sample.arm.with_point(frame), sample.q) for sample in samples]
    for statement in finder(replace(chain, tool=Point(frame)), moved_samples):
        yield statement.with_origin_as_point(frame, origin_name)


def _find_point_statements(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Yield statements about the axes and the point of interest."""
    finders: list[Finder] = [
        _find_point_on_axis,
        _find_collinear_axes,
        _find_extreme_reach,
        _find_extreme_side_of_prismatic,
        _find_parallel_prismatic,
        _find_prismatic_at_link,
        _find_parallel_axes,
        _find_coplanar_parallel_axes,
        _find_origin_on_axis,
        _find_extreme_origin,
        _find_common_direction,
    ]
    if not chain.linear_axes:
        finders = [_find_collinear_axes, _find_parallel_axes]
    elif len(chain.linear_axes) < len(chain.task):  # the position of P may be incidental
        axis_finders = [_find_collinear_axes, _find_parallel_axes, _find_coplanar_parallel_axes]
        finders = axis_finders + [finder for finder in finders if finder not in axis_finders]
    for finder in finders:
        yield from finder(chain, samples)


def describe_dependence(chain: Chain, samples: Sequence[Sample]) -> str:
    """Describe the smallest set of joints that can move together without any motion in the task's rows.

    The set of all joints is not reported, because all joints together can move in this way at every singular
    configuration. An arm with more joints than rows has such a set at every configuration, so none is reported.
    """
    rows = chain.task_rows
    if samples and chain.n <= len(rows):
        jacobians = compute_jacobians(samples)
        max_joint_count = chain.n if chain.n <= 2 else chain.n - 1
        for joint_count in range(1, max_joint_count + 1):
            for joints in combinations(range(chain.n), joint_count):
                if _are_dependent(jacobians, rows, joints):
                    names = _join_joint_numbers(joints)
                    if joint_count == 1:
                        return f"joint {names} has no effect on the task"
                    effect = _describe_rest(chain, jacobians[..., joints], rows)
                    return f"joints {names} can move together and {effect}"
    return NO_SIMPLE_MEANING


def _are_dependent(jacobians: np.ndarray, rows: Sequence[int], columns: Sequence[int]) -> bool:
    """Return whether columns, restricted to some rows, are linearly dependent in each of k Jacobians (k x 6 x n)."""
    sigma = np.linalg.svd(jacobians[:, list(rows)][:, :, list(columns)], compute_uv=False)
    return bool(np.all(sigma[:, -1] < ZERO_TOLERANCE * np.maximum(sigma[:, 0], NONZERO_THRESHOLD)))


def _describe_rest(chain: Chain, jacobians: np.ndarray, rows: Sequence[int]) -> str:
    """Describe what stays at rest while some joints move without any effect on the task's rows.

    `jacobians` (k x 6 x joints) are the columns of these joints in the Jacobians at k configurations.
    """
    _, _, v_transposed = np.linalg.svd(jacobians[:, list(rows)])
    speeds = np.abs(np.einsum("kij,kj->ki", jacobians, v_transposed[:, -1]))
    if len(chain.linear_axes) == len(rows) and speeds[:, :3].max() < ZERO_TOLERANCE:
        return "leave the point at rest"
    if speeds.max() < ZERO_TOLERANCE:
        return f"leave link {chain.n} at rest"
    return "have no effect on the task"


def _join_joint_numbers(joints: Sequence[int]) -> str:
    """Return the numbers of joints (from 0) as text, counted from 1, such as "1, 2 and 3"."""
    numbers = [str(joint + 1) for joint in joints]
    return " and ".join([", ".join(numbers[:-1]), numbers[-1]] if len(numbers) > 1 else numbers)


# --- finders of statements ---


def _find_in_groups(
    samples: Sequence[Sample], groups: Iterable[Sequence[int]], words: str, measure: Callable[..., np.ndarray]
) -> Iterator[Statement]:
    """Yield for each group of joints the statement `words` with the joints' numbers, if it holds only at the samples.

    `measure` is a measure with an additional argument `joints`.
    """
    for joints in groups:
        yield from _yield_if_special(
            samples, words.format(_join_joint_numbers(joints)), partial(measure, joints=joints)
        )


def _find_point_on_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find the axes on which the point lies: all axes together, then each axis alone."""
    revolute_joints = [i for i in chain.revolute_joints if i < chain.point.frame]
    axes_with_point = [i for i in revolute_joints if _is_special(samples, partial(measure_axis_distance, joint=i))]
    if len(axes_with_point) > 1:
        words = "the point lies on the axes of joints {}, which then do not move it"
        yield from _find_in_groups(samples, [axes_with_point], words, _measure_farthest_distance)
    words = "the point lies on the axis of joint {}, which then does not move it"
    yield from _find_in_groups(samples, [(joint,) for joint in revolute_joints], words, _measure_farthest_distance)


def _measure_farthest_distance(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the distance (m) of the point from the farthest of several axes."""
    return np.asarray(np.max([measure_axis_distance(arm, q, joint) for joint in joints], axis=0))


def _find_collinear_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    pairs = combinations(chain.revolute_joints, 2)
    return _find_in_groups(samples, pairs, "the axes of joints {} coincide", measure_collinearity)


def _find_parallel_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find parallel axes: pairs if the task has only angular rows, else all axes that are parallel to each other.

    The columns of these joints must be dependent; otherwise parallel axes cannot be the reason.
    """
    rows, jacobians = chain.task_rows, compute_jacobians(samples)
    for i, j in sorted(combinations(chain.revolute_joints, 2), key=lambda pair: pair[1] - pair[0]):
        if are_parallel(samples, i, j):
            further_joints = [k for k in chain.revolute_joints if chain.linear_axes and are_parallel(samples, i, k)]
            joints = sorted({i, j, *further_joints})
            if _are_dependent(jacobians, rows, joints):
                words = f"the axes of joints {_join_joint_numbers(joints)} are parallel"
                yield from _yield_if_special(samples, words, partial(measure_axis_spread, joints=(i, j)))


def _find_axes_parallel_to_plane(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find three axes parallel to one plane, so that these joints cause no rotation about the plane's normal."""
    triples = combinations(chain.revolute_joints, 3) if any(row[0] == "w" for row in chain.task) else ()
    return _find_in_groups(samples, triples, "the axes of joints {} are all parallel to one plane", measure_axis_spread)


def _find_coplanar_parallel_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find three axes that lie in one plane, and that are parallel to each other at the samples and near them."""
    groups = samples, move_samples(samples)
    triples = (
        triple
        for triple in combinations(chain.revolute_joints, 3)
        if all(are_parallel(group, triple[0], j) for group in groups for j in triple[1:])
    )
    return _find_in_groups(samples, triples, "the parallel axes of joints {} lie in one plane", measure_coplanarity)


def _find_extreme_side_of_prismatic(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find a prismatic joint whose line is as far from the point as a later joint can bring it."""
    for prismatic_joint in chain.prismatic_joints:
        side = f"the point is as far to one side of prismatic joint {prismatic_joint + 1}"
        for moving_joint in range(prismatic_joint + 1, chain.point.frame):
            if _find_common_extreme_signs(samples, prismatic_joint, moving_joint) == {1}:
                words = f"{side} as joint {moving_joint + 1} can bring it"
                yield _make_extreme_statement(words, prismatic_joint, [moving_joint], {1})


def _find_parallel_prismatic(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    pairs = combinations(chain.prismatic_joints, 2)
    return _find_in_groups(samples, pairs, "the axes of prismatic joints {} are parallel", measure_axis_spread)


def _find_prismatic_at_link(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find a prismatic joint along, or perpendicular to, the line that joins two parallel axes."""
    parallel_pairs = [pair for pair in combinations(chain.revolute_joints, 2) if are_parallel(samples, *pair)]
    for prismatic_joint, (i, j) in product(chain.prismatic_joints, parallel_pairs):
        line = f"the line from the axis of joint {i + 1} to that of joint {j + 1}"
        for is_perpendicular, preposition in ((False, "along"), (True, "at right angles to")):
            words = f"prismatic joint {prismatic_joint + 1} moves {preposition} {line}"
            measure = partial(measure_prismatic_slant, prismatic_joint=prismatic_joint, i=i, j=j)
            measure = partial(measure, is_perpendicular=is_perpendicular)
            yield from _yield_if_special(samples, words, measure)


def _find_origin_on_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find the origin of a frame that lies on an earlier axis."""
    for axis in chain.revolute_joints:
        for frame in range(axis + 2, chain.n):
            words = f"the point lies on the axis of joint {axis + 1}"
            statement = Statement(words, partial(measure_axis_distance, joint=axis))
            statement = statement.with_origin_as_point(frame, f"the origin O{frame}")
            yield from _yield_if_special(samples, statement.words, statement.measure)


def _find_extreme_origin(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find the origin of a frame in the wrist that is as far from an axis, or as near to it, as it can be.

    An example is the intersection of the last two axes of a UR robot. The first three joints are no wrist.
    """
    for frame in range(4, chain.n):
        statements = _find_origin_statements(chain, samples, frame, f"the origin O{frame}", _find_extreme_reach)
        yield from (statement for statement in statements if f"O{frame}" in statement.words)


def _find_common_direction(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find two joints that move the point along the same line."""
    for pair in combinations(range(chain.point.frame), 2):
        jacobians = (sample.arm.compute_jacobian(sample.q) for sample in samples)
        speeds = [np.linalg.norm(jacobian[:3, list(pair)], axis=0).min() for jacobian in jacobians]
        if min(speeds) > NONZERO_THRESHOLD:
            words = f"joints {_join_joint_numbers(pair)} move the point along the same line"
            yield from _yield_if_special(samples, words, partial(measure_common_direction, joints=pair))


def _find_extreme_reach(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find an axis whose distance from the point is a maximum or a minimum with respect to later joints."""
    for axis in chain.revolute_joints:
        later_joints = range(axis + 1, chain.point.frame)
        signs_by_joint = {joint: _find_common_extreme_signs(samples, axis, joint) for joint in later_joints}
        extreme_joints = [joint for joint, signs in signs_by_joint.items() if 0 not in signs]
        other_joints = [j for j in later_joints if j not in extreme_joints]
        can_extend_further = any(0 in _find_extreme_signs(samples, axis, j) for j in other_joints)
        has_parallel_axes = all(j in chain.revolute_joints and are_parallel(samples, axis, j) for j in extreme_joints)
        if extreme_joints and has_parallel_axes and not can_extend_further:
            yield _make_extension_statement(samples, axis, extreme_joints)
            continue
        for joint in extreme_joints:
            signs = signs_by_joint[joint]
            if chain.joints[joint].is_revolute and not are_parallel(samples, axis, joint):
                signs = set(_find_global_extreme_signs(samples, axis, joint))
            if 0 not in signs:
                yield _make_extreme_statement(_describe_extreme(chain, axis, joint, signs), axis, [joint], signs)


def _describe_extreme(chain: Chain, axis: int, moving_joint: int, signs: set[int]) -> str:
    """Describe that a joint brings the point as far from an axis (sign 1), or as near to it (sign -1), as it can."""
    ending = f"the axis of joint {axis + 1} as joint {moving_joint + 1} can bring it"
    if chain.joints[moving_joint].is_prismatic:
        return f"arm retracted: the point is as near to {ending}"
    relation = "far from or as near to" if len(signs) > 1 else "far from" if 1 in signs else "near to"
    return f"the point is as {relation} {ending}"


def _make_extension_statement(samples: Sequence[Sample], axis: int, moving_joints: Sequence[int]) -> Statement:
    """Return the statement that an arm with parallel axes is stretched out or folded back.

    The arm is folded back if other angles of `moving_joints` reach farther from the axis.
    """
    signs_by_sample = zip(*(_find_extreme_signs(samples, axis, joint) for joint in moving_joints), strict=True)
    samples_and_signs = zip(samples, signs_by_sample, strict=True)
    conclusive_samples = [sample for sample, signs in samples_and_signs if set(signs) != {None}]
    extension_signs = frozenset(_find_extension_sign(sample, axis, moving_joints) for sample in conclusive_samples)
    words = _EXTENSION_WORDS[extension_signs]
    statement = _make_extreme_statement(words, axis, moving_joints, {1, -1})

    def is_true(sample: Sample) -> bool:  # if the point lies on the axis, all joints are trivially at an extreme
        distance = sample.evaluate(partial(measure_axis_distance, joint=axis))
        return distance > NONZERO_THRESHOLD and statement.predicate(sample)

    return replace(statement, predicate=is_true)


def _find_extension_sign(sample: Sample, axis: int, moving_joints: Sequence[int]) -> int:
    """Return 1 if an arm with all moving joints at an extreme is stretched out, else -1.

    The arm is stretched out if half turns of moving joints do not increase the distance. In a zigzag arm, for example,
    no joint alone can increase the distance, but two joints together can.
    """
    half_turns = np.zeros((2 ** len(moving_joints), len(sample.q)))
    half_turns[:, list(moving_joints)] = np.pi * np.array(list(product((0, 1), repeat=len(moving_joints))))
    distances = measure_axis_distance(sample.arm, sample.q + half_turns, axis)
    return -1 if distances.max() > distances[0] + ZERO_TOLERANCE else 1


def _make_extreme_statement(words: str, axis: int, moving_joints: Sequence[int], signs: set[int]) -> Statement:
    """Return the statement that all moving joints have brought the point to an extreme distance from an axis.

    `signs` are the allowed signs of the extremes: 1 for a maximum, -1 for a minimum.
    """

    def is_true(sample: Sample) -> bool:
        return all(_find_extreme_signs([sample], axis, joint)[0] in signs for joint in moving_joints)

    return Statement(words, partial(measure_distance_change, joint=axis, moving_joints=tuple(moving_joints)), is_true)


_EXTENSION_WORDS = {
    frozenset({1}): "arm stretched out",
    frozenset({-1}): "arm folded back",
    frozenset({1, -1}): "arm stretched out or folded back",
}


def _is_special(samples: Sequence[Sample], measure: Measure) -> bool:
    """Return whether a measure is zero at all samples, but not at configurations near them."""
    is_zero_at_samples = measure_samples(samples, measure).max() < ZERO_TOLERANCE
    return bool(is_zero_at_samples and measure_samples(move_samples(samples), measure).max() > NONZERO_THRESHOLD)


def _yield_if_special(samples: Sequence[Sample], words: str, measure: Measure) -> Iterator[Statement]:
    """Yield the statement `words` if it holds at all samples, but not at configurations near them."""
    if _is_special(samples, measure):
        yield Statement(words, measure)


def _find_common_extreme_signs(samples: Sequence[Sample], axis: int, moving_joint: int) -> set[int]:
    """Return the signs of the extreme distances that a joint reaches at the samples: 1 for a maximum, -1 for a minimum.

    Return {0} if the distance at a sample is not extreme, or if half of the samples or more are inconclusive.
    """
    signs = _find_extreme_signs(samples, axis, moving_joint)
    if 0 in signs or 2 * signs.count(None) >= len(signs):
        return {0}
    return {sign for sign in signs if sign is not None}


def _find_extreme_signs(samples: Sequence[Sample], axis: int, moving_joint: int) -> list[int | None]:
    """Return for each sample 1 if the point's distance from an axis is a local maximum, -1 if a local minimum, else 0.

    The distance is a function of the joint `moving_joint`. Its derivatives are computed from the distances d0 to d4 at
    five equally spaced joint values. The result is None if the joint hardly changes the distance, for example if the
    point lies on the joint's axis.
    """
    arms, q = stack_samples(samples)
    q = np.tile(q, (1, 5, 1))
    q[..., moving_joint] += _DIFFERENCE_STEP * np.arange(-2, 3)
    d0, d1, d2, d3, d4 = measure_axis_distance(arms, q, axis).T
    slope = (8 * (d3 - d1) - (d4 - d0)) / (12 * _DIFFERENCE_STEP)
    curvature = (d3 + d1 - 2 * d2) / _DIFFERENCE_STEP**2
    signs = np.where(np.abs(curvature) < _MIN_CURVATURE, 0, np.where(curvature < 0, 1, -1))
    is_sloped = np.abs(slope) > np.maximum(1e-9, 1e-6 * np.abs(curvature))  # the limits allow for rounding
    return [0 if sloped else int(sign) or None for sloped, sign in zip(is_sloped, signs, strict=True)]


def _find_global_extreme_signs(samples: Sequence[Sample], axis: int, moving_joint: int) -> list[int]:
    """Return for each sample 1 if the point's distance from an axis is a global maximum, -1 if a minimum, else 0.

    The squared distance is a constant plus sines and cosines of a revolute joint's angle and of twice the angle, so
    five values determine it. The distance may have two maxima if the two axes are not parallel.
    """
    angles = 2 * np.pi / 5 * np.arange(5)
    arms, q = stack_samples(samples)
    q = np.tile(q, (1, 5, 1))
    q[..., moving_joint] += angles
    squares = measure_axis_distance(arms, q, axis) ** 2
    curve_angles = np.linspace(0, 2 * np.pi, _CURVE_POINT_COUNT)
    curve = squares @ np.linalg.inv(_compute_harmonics(angles)) @ _compute_harmonics(curve_angles)
    tolerance = 1e-9 * np.maximum(squares.max(axis=1), 1.0)
    is_far, is_near = squares[:, 0] > curve.max(axis=1) - tolerance, squares[:, 0] < curve.min(axis=1) + tolerance
    return [int(sign) for sign in np.where(is_far, 1, np.where(is_near, -1, 0))]


def _compute_harmonics(angles: np.ndarray) -> np.ndarray:
    """Return 1, and the cosines and sines of angles (k) and of twice the angles, as a (5, k) array."""
    return np.array([np.ones_like(angles), *(trig(i * angles) for i in (1, 2) for trig in (np.cos, np.sin))])
