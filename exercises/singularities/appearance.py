"""Describe what singular configurations look like, such as "arm stretched out", by testing statements at samples.

A statement is reported only if it is the reason (`reason`), that is, if it holds at no regular configuration. If there
is none, the report names the joints whose columns of J are dependent, and what stays at rest while they move.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain as chain_together
from itertools import combinations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, Point
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.singularities.axes import (
    Measure,
    Sample,
    are_parallel,
    axis_distance,
    axis_distance_derivative,
    axis_spread,
    collinearity_error,
    common_direction_error,
    coplanarity_error,
    jacobians_of,
    measure_samples,
    nearby_samples,
    prismatic_slant,
)
from qdot.exercises.singularities.reason import is_reason

ZERO_TOLERANCE, NONZERO_THRESHOLD = 1e-5, 1e-3
"""Tolerances in metres or as a sine: below the first, a measure is zero; above the second, it is clearly nonzero."""


@dataclass(frozen=True)
class Statement:
    """A statement about what configurations look like; it holds if `measure` is zero and `predicate` returns True."""

    words: str
    measure: Measure
    predicate: Callable[[Sample], bool] = lambda _: True

    def about_origin(self, frame: int, origin_name: str) -> "Statement":
        """Return the same statement, but about the origin of a frame instead of the point of interest."""
        return Statement(
            self.words.replace("the point", origin_name),
            lambda arm, q: self.measure(arm.with_point(frame), q),
            lambda sample: self.predicate(Sample(sample.arm.with_point(frame), sample.q)),
        )

    def combine(self, second: "Statement") -> "Statement":
        """Return the statement that both this one and a second one hold."""
        return Statement(
            f"{self.words}, and {second.words}",
            lambda arm, q: np.hypot(self.measure(arm, q), second.measure(arm, q)),
            lambda sample: self.predicate(sample) and second.predicate(sample),
        )


Finder = Callable[[Chain, Sequence[Sample]], Iterator[Statement]]
"""A function that yields the statements of one kind that hold at all samples, but not near them."""


def wrist_centre(chain: Chain) -> int | None:
    """Return the frame whose origin always lies on the axes of the last three joints; None if there is none."""
    wrist = chain.joints[-3:]
    if chain.n < 4 or any(joint.kind != "R" for joint in wrist):
        return None
    axes_meet = wrist[0].a == 0 and wrist[1].a == 0 and wrist[1].d == 0
    is_twisted = all((joint.alpha / sp.pi).is_integer is not True for joint in wrist[:2])
    return chain.n - 2 if axes_meet and is_twisted else None


def describe_appearance(chain: Chain, samples: Sequence[Sample]) -> str:
    """Return a description of why configurations are singular: their look, or else which joints are dependent."""
    statement = find_reason(chain, samples)
    return statement.words if statement else describe_dependence(chain, samples)


def find_reason(chain: Chain, samples: Sequence[Sample]) -> Statement | None:
    """Return a statement, or a combination of two, that holds at all samples and at no regular configuration."""
    if not samples:
        return None
    candidates: list[Statement] = []
    for statement in chain_together(find_statements(chain, samples), _find_axes_parallel_to_plane(chain, samples)):
        if is_reason(chain, samples, statement.measure, statement.predicate):
            return statement
        candidates.append(statement)
    pairs = (first.combine(second) for first, second in combinations(candidates, 2) if first.words != second.words)
    return next((pair for pair in pairs if is_reason(chain, samples, pair.measure, pair.predicate)), None)


def find_statements(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Yield statements that hold at all samples but not near them; the most specific come first."""
    has_angular_rows = any(row[0] == "w" for row in chain.task)
    if has_angular_rows and len(chain.task) == 3 and chain.linear_rows and chain.joints[-1].kind == "R" and chain.n > 1:
        # the last joint sets the angle of a planar task, the others position its axis
        yield from _find_coplanar_parallel_axes(chain, samples)
        rows = tuple(row for row in chain.task if row[0] == "v")
        yield from _origin_statements(replace(chain, task=rows), samples, chain.n - 1, f"the axis of joint {chain.n}")
        return
    centre = wrist_centre(chain) if has_angular_rows else None
    if centre is None or chain.point == Point(centre):
        yield from _point_statements(chain, samples)
    else:
        yield from _origin_statements(chain, samples, centre, "the wrist centre")


def _origin_statements(chain: Chain, samples: Sequence[Sample], frame: int, origin_name: str) -> Iterator[Statement]:
    """Yield statements about the axes and the origin of a frame."""
    for statement in _point_statements(replace(chain, tool=Point(frame)), _move_point(samples, frame)):
        yield statement.about_origin(frame, origin_name)


def _move_point(samples: Sequence[Sample], frame: int) -> list[Sample]:
    """Return the same configurations of the arms with the origin of a frame as the point of interest."""
    return [Sample(sample.arm.with_point(frame), sample.q) for sample in samples]


def _point_statements(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
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
    if not chain.linear_rows:
        finders = [_find_collinear_axes, _find_parallel_axes]
    elif len(chain.linear_rows) < len(chain.task):  # the position of P may be incidental
        first = [_find_collinear_axes, _find_parallel_axes, _find_coplanar_parallel_axes]
        finders = first + [finder for finder in finders if finder not in first]
    for finder in finders:
        yield from finder(chain, samples)


def describe_dependence(chain: Chain, samples: Sequence[Sample]) -> str:
    """Describe the smallest set of joints that can move without any motion in the task's rows.

    If there are more joints than rows, the columns of J are always dependent; then describe the motion that is lost.
    """
    rows = chain.task_rows
    if chain.n > len(rows):
        return _describe_dependent_rows(chain, samples, rows)
    if samples:
        jacobians = jacobians_of(samples)
        for count in range(1, chain.n + 1):
            for chosen in combinations(range(chain.n), count):
                if _are_dependent(jacobians, rows, chosen):
                    names = _joint_names(chosen)
                    if count == 1:
                        return f"joint {names} has no effect on the task"
                    effect = _describe_rest(chain, jacobians[..., chosen], rows)
                    subject = "all joints" if count == chain.n > 2 else f"joints {names}"
                    return f"{subject} can move together and {effect}"
    return "the columns of J are linearly dependent"


def _describe_dependent_rows(chain: Chain, samples: Sequence[Sample], rows: Sequence[int]) -> str:
    """Describe the world axis along or about which no joint causes motion, or how all joints move the point."""
    jacobians = jacobians_of(samples) if samples else np.ones((1, 6, chain.n))
    zero_rows = [row for row in rows if np.abs(jacobians[:, row]).max() < ZERO_TOLERANCE]
    axis_names = _join_names(["xyz"[row % 3] for row in zero_rows])
    if zero_rows and max(zero_rows) < 3:
        return f"no joint moves the point along {axis_names}"
    if zero_rows and min(zero_rows) > 2:
        return f"no joint rotates link {chain.n} about {axis_names}"
    if not samples or zero_rows or max(rows) > 2:
        return "the rows of J are linearly dependent"
    singular_values = np.linalg.svd(jacobians[:, :3], compute_uv=False)
    directions = {2: "along one line", 3: "in one plane"}[len(rows)]
    if np.all(singular_values[:, len(rows) - 1] < ZERO_TOLERANCE * np.maximum(singular_values[:, 0], 1e-3)):
        return f"all joints move the point {directions}"
    (missing_axis,) = {0, 1, 2} - set(rows)
    return f"seen along {'xyz'[missing_axis]}, all joints move the point {directions}"


def _are_dependent(jacobians: np.ndarray, rows: Sequence[int], columns: Sequence[int]) -> bool:
    """Return whether columns, restricted to `rows`, are linearly dependent in each of the Jacobians (k, 6, n)."""
    singular_values = np.linalg.svd(jacobians[:, list(rows)][:, :, list(columns)], compute_uv=False)
    return bool(np.all(singular_values[:, -1] < ZERO_TOLERANCE * np.maximum(singular_values[:, 0], 1e-3)))


def _describe_rest(chain: Chain, jacobians: np.ndarray, rows: Sequence[int]) -> str:
    """Describe what stays at rest while some joints move without any effect on the task's rows.

    `jacobians` (k, 6, …) are the columns of these joints at k configurations.
    """
    joint_rates = np.linalg.svd(jacobians[:, list(rows)])[2][:, -1]
    speeds = np.abs(np.einsum("kij,kj->ki", jacobians, joint_rates))
    if len(chain.linear_rows) == len(rows) and speeds[:, :3].max() < ZERO_TOLERANCE:
        return "leave the point at rest"
    if speeds.max() < ZERO_TOLERANCE:
        return f"leave link {chain.n} at rest"
    return "have no effect on the task"


def _joint_names(joints: Sequence[int]) -> str:
    """Return the numbers of joints (from 0) as text, counted from 1, such as "1, 2 and 3"."""
    return _join_names([str(joint + 1) for joint in joints])


def _join_names(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def _find_point_on_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    revolute = [i for i in _revolute_joints(chain) if i < chain.point.frame]
    axes_with_point = [i for i in revolute if [*_yield_if_special(samples, "", partial(axis_distance, joint=i))]]
    if len(axes_with_point) > 1:
        words = f"the point lies on the axes of joints {_joint_names(axes_with_point)}, which then do not move it"
        yield from _yield_if_special(samples, words, partial(_farthest_axis_distance, joints=axes_with_point))
    for joint in revolute:
        words = f"the point lies on the axis of joint {joint + 1}, which then does not move it"
        yield from _yield_if_special(samples, words, partial(axis_distance, joint=joint))


def _farthest_axis_distance(arm: NumericChain, q: np.ndarray, joints: Sequence[int]) -> np.ndarray:
    """Return the distance of the point from the farthest of several axes."""
    return np.asarray(np.max([axis_distance(arm, q, joint) for joint in joints], axis=0))


def _revolute_joints(chain: Chain) -> list[int]:
    return chain.joints_of_kind("R")


def _find_collinear_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for pair in combinations(_revolute_joints(chain), 2):
        words = f"the axes of joints {_joint_names(pair)} coincide"
        yield from _yield_if_special(samples, words, partial(collinearity_error, joints=pair))


def _find_parallel_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find parallel axes: pairs if the task has only angular rows, else all that are parallel to each other.

    They are a reason only if the columns of these joints alone are dependent.
    """
    rows, jacobians = chain.task_rows, jacobians_of(samples)
    for i, j in sorted(combinations(_revolute_joints(chain), 2), key=lambda pair: pair[1] - pair[0]):
        if are_parallel(samples, i, j):
            others = [k for k in _revolute_joints(chain) if chain.linear_rows and are_parallel(samples, i, k)]
            chosen = sorted({i, j, *others})
            if _are_dependent(jacobians, rows, chosen):
                words = f"the axes of joints {_joint_names(chosen)} are parallel"
                yield from _yield_if_special(samples, words, partial(axis_spread, joints=(i, j)))


def _find_axes_parallel_to_plane(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find three axes parallel to one plane, so that these joints cause no rotation about its normal."""
    if not any(row[0] == "w" for row in chain.task):
        return
    for triple in combinations(_revolute_joints(chain), 3):
        words = f"the axes of joints {_joint_names(triple)} are all parallel to one plane"
        yield from _yield_if_special(samples, words, partial(axis_spread, joints=triple))


def _find_coplanar_parallel_axes(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for triple in combinations(_revolute_joints(chain), 3):
        if all(are_parallel(group, triple[0], j) for group in (samples, nearby_samples(samples)) for j in triple[1:]):
            words = f"the parallel axes of joints {_joint_names(triple)} lie in one plane"
            yield from _yield_if_special(samples, words, partial(coplanarity_error, row=triple))


def _find_extreme_side_of_prismatic(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find a prismatic joint whose line is as far from the point as a later joint can bring it."""
    for prismatic in chain.joints_of_kind("P"):
        side = f"the point is as far to one side of prismatic joint {prismatic + 1}"
        for mover in range(prismatic + 1, min(chain.n, chain.point.frame)):
            if _common_extreme_signs(samples, prismatic, mover) == {1}:
                yield _extreme_statement(f"{side} as joint {mover + 1} can bring it", prismatic, [mover], {1})


def _find_parallel_prismatic(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for pair in combinations(chain.joints_of_kind("P"), 2):
        words = f"the axes of prismatic joints {_joint_names(pair)} are parallel"
        yield from _yield_if_special(samples, words, partial(axis_spread, joints=pair))


def _find_prismatic_at_link(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find a prismatic joint along, or perpendicular to, the line that joins two parallel axes."""
    parallel_pairs = [pair for pair in combinations(_revolute_joints(chain), 2) if are_parallel(samples, *pair)]
    for prismatic, (i, j) in product(chain.joints_of_kind("P"), parallel_pairs):
        link = f"the line from the axis of joint {i + 1} to that of joint {j + 1}"
        for is_across, preposition in ((False, "along"), (True, "at right angles to")):
            words = f"prismatic joint {prismatic + 1} moves {preposition} {link}"
            measure = partial(prismatic_slant, prismatic=prismatic, i=i, j=j, across=is_across)
            yield from _yield_if_special(samples, words, measure)


def _find_origin_on_axis(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    for axis in _revolute_joints(chain):
        for frame in range(axis + 2, chain.n):
            words = f"the origin O{frame} lies on the axis of joint {axis + 1}"
            yield from _yield_if_special(samples, words, partial(_origin_distance, frame=frame, axis=axis))


def _origin_distance(arm: NumericChain, q: np.ndarray, frame: int, axis: int) -> np.ndarray:
    """Return the distance of an origin from an axis."""
    return axis_distance(arm.with_point(frame), q, axis)


def _find_extreme_origin(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find an origin in the wrist that is as far from or as near to an axis as possible.

    An example is the intersection of the last two axes of a UR robot.
    """
    for frame in range(4, chain.n):
        moved_samples = _move_point(samples, frame)
        for statement in _find_extreme_reach(replace(chain, tool=Point(frame)), moved_samples):
            if "the point" in statement.words:
                yield statement.about_origin(frame, f"the origin O{frame}")


def _find_common_direction(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find two joints that move the point along the same line."""
    for pair in combinations(range(min(chain.n, chain.point.frame)), 2):
        speeds = [np.linalg.norm(s.arm.jacobian(s.q)[:3, list(pair)], axis=0).min() for s in samples]
        if min(speeds) > NONZERO_THRESHOLD:
            words = f"joints {_joint_names(pair)} move the point along the same line"
            yield from _yield_if_special(samples, words, partial(common_direction_error, joints=pair))


def _find_extreme_reach(chain: Chain, samples: Sequence[Sample]) -> Iterator[Statement]:
    """Find an axis whose distance from the point is a maximum or minimum with respect to later joints."""
    for axis in _revolute_joints(chain):
        later_joints = range(axis + 1, min(chain.n, chain.point.frame))
        signs_by_joint = {joint: _common_extreme_signs(samples, axis, joint) for joint in later_joints}
        movers = [joint for joint, signs in signs_by_joint.items() if 0 not in signs]
        revolute = [joint for joint in movers if chain.joints[joint].kind == "R"]
        others = [j for j in later_joints if j not in movers and 0 in _extreme_signs(samples, axis, j)]
        if revolute and not others and revolute == movers and all(are_parallel(samples, axis, j) for j in movers):
            yield _extension_statement(samples, axis, movers)
            continue
        for joint in movers:
            signs = signs_by_joint[joint]
            if joint in revolute and not are_parallel(samples, axis, joint):
                signs = set(_global_extreme_signs(samples, axis, joint))
            if 0 not in signs:
                yield _extreme_statement(_describe_extreme(chain, axis, joint, signs), axis, [joint], signs)


def _describe_extreme(chain: Chain, axis: int, moving_joint: int, signs: set[int]) -> str:
    """Describe that a joint brings the point as far from an axis, or as near to it, as it can."""
    ending = f"the axis of joint {axis + 1} as joint {moving_joint + 1} can bring it"
    if chain.joints[moving_joint].kind == "P":
        return f"arm drawn in: the point is as near to {ending}"
    relation = "far from or as near to" if len(signs) > 1 else "far from" if 1 in signs else "near to"
    return f"the point is as {relation} {ending}"


def _extension_statement(samples: Sequence[Sample], axis: int, movers: Sequence[int]) -> Statement:
    """Return the statement that an arm with parallel axes is stretched out or folded back.

    It is folded back if other angles of the same joints reach farther.
    """
    signs_by_sample = zip(*(_extreme_signs(samples, axis, joint) for joint in movers), strict=True)
    conclusive = [sample for sample, signs in zip(samples, signs_by_sample, strict=True) if set(signs) != {None}]
    words = _EXTENSION_WORDS[frozenset(_extension_sign(sample, axis, movers) for sample in conclusive)]
    statement = _extreme_statement(words, axis, movers, {1, -1})

    def is_true(sample: Sample) -> bool:  # if the point lies on the axis, every joint is at an extreme
        return statement.predicate(sample) and sample.evaluate(partial(axis_distance, joint=axis)) > NONZERO_THRESHOLD

    return replace(statement, predicate=is_true)


def _extension_sign(sample: Sample, axis: int, movers: Sequence[int]) -> int:
    """Return 1 if an arm whose joints are all at an extreme is stretched out, -1 if half turns of joints reach farther.

    If the links zigzag, each joint alone may have the point at its farthest while two joints together do not.
    """
    half_turns = np.zeros((2 ** len(movers), len(sample.q)))
    half_turns[:, list(movers)] = np.pi * np.array(list(product((0, 1), repeat=len(movers))))
    distances = axis_distance(sample.arm, sample.q + half_turns, axis)
    return -1 if distances.max() > distances[0] + ZERO_TOLERANCE else 1


def _extreme_statement(words: str, axis: int, movers: Sequence[int], signs: set[int]) -> Statement:
    """Return the statement that all movers have brought the point to an extreme distance from an axis.

    `signs` are the allowed signs of the extremes: 1 is farthest, -1 nearest.
    """

    def is_true(sample: Sample) -> bool:
        return all(_extreme_signs([sample], axis, moving)[0] in signs for moving in movers)

    return Statement(words, partial(axis_distance_derivative, joint=axis, movers=tuple(movers)), is_true)


_EXTENSION_WORDS = {
    frozenset({1}): "arm stretched out",
    frozenset({-1}): "arm folded back",
    frozenset({1, -1}): "arm stretched out or folded back",
}


def _yield_if_special(samples: Sequence[Sample], words: str, measure: Measure) -> Iterator[Statement]:
    """Yield the statement if its measure is zero at all samples, but not at the configurations near them."""
    holds = measure_samples(samples, measure).max() < ZERO_TOLERANCE
    if holds and measure_samples(nearby_samples(samples), measure).max() > NONZERO_THRESHOLD:
        yield Statement(words, measure)


def _common_extreme_signs(samples: Sequence[Sample], axis: int, moving_joint: int) -> set[int]:
    """Return the signs of the extremes that a joint reaches at all samples: 1 is farthest, -1 nearest.

    Return {0} if the joint is not at an extreme at all samples. Fewer than half of the samples may be inconclusive.
    """
    signs = _extreme_signs(samples, axis, moving_joint)
    if 0 in signs or 2 * signs.count(None) >= len(signs):
        return {0}
    return {sign for sign in signs if sign is not None}


def _extreme_signs(samples: Sequence[Sample], axis: int, moving_joint: int) -> list[int | None]:
    """Return for each sample 1 if the point's distance from an axis is a local maximum, -1 if a local minimum, else 0.

    The distance is a function of the joint `moving_joint`. The result is None if that joint hardly changes it, for
    example if the point lies on the joint's own axis.
    """
    step = 1e-3
    q = np.tile(np.stack([sample.q for sample in samples])[:, None], (1, 5, 1))
    q[..., moving_joint] += step * np.arange(-2, 3)
    arms = NumericChain.stack([sample.arm for sample in samples])
    far_behind, behind, middle, ahead, far_ahead = axis_distance(arms, q, axis).T
    derivative = (8 * (ahead - behind) - (far_ahead - far_behind)) / (12 * step)
    curvature = (ahead + behind - 2 * middle) / step**2
    signs = np.where(np.abs(curvature) < 1e-3, 0, np.where(curvature < 0, 1, -1))
    has_slope = np.abs(derivative) > np.maximum(1e-9, 1e-6 * np.abs(curvature))
    return [0 if sloped else int(sign) if sign else None for sloped, sign in zip(has_slope, signs, strict=True)]


def _global_extreme_signs(samples: Sequence[Sample], axis: int, moving_joint: int) -> list[int]:
    """Return for each sample 1 if the point's distance from an axis is a global maximum, -1 if a minimum, else 0.

    The squared distance is a sum of sines and cosines of a revolute joint's angle and of twice that angle. Five values
    determine this sum. It may have two maxima if the axes are not parallel.
    """
    angles = 2 * np.pi / 5 * np.arange(5)
    q = np.tile(np.stack([sample.q for sample in samples])[:, None], (1, 5, 1))
    q[..., moving_joint] += angles
    squares = axis_distance(NumericChain.stack([sample.arm for sample in samples]), q, axis) ** 2
    curve = squares @ np.linalg.inv(_harmonics(angles)) @ _harmonics(np.linspace(0, 2 * np.pi, 180))
    tolerance = 1e-9 * np.maximum(squares.max(axis=1), 1.0)
    is_far, is_near = squares[:, 0] > curve.max(axis=1) - tolerance, squares[:, 0] < curve.min(axis=1) + tolerance
    return [int(sign) for sign in np.where(is_far, 1, np.where(is_near, -1, 0))]


def _harmonics(angles: np.ndarray) -> np.ndarray:
    """Return 1, and the cosines and sines of angles (k) and of twice the angles, as a (5, k) array."""
    return np.array([np.ones_like(angles), *(trig(i * angles) for i in (1, 2) for trig in (np.cos, np.sin))])
