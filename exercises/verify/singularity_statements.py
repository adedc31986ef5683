"""Check what a worked solution says about singular configurations, on arms with numeric lengths.

A statement consists of clauses about axes, prismatic joints and the tool point. A pattern recognises each clause. The
clause is then tested on the frames of the arm, at other configurations than those used to derive the statement. For
example, "as far as joint 2 can bring it" is tested by moving joint 2 through its whole range.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import REVOLUTE, Chain
from qdot.exercises.arm.conventions.base import NO_SIMPLE_MEANING
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import (
    Classification,
    classify,
    is_one_sided,
    sample_condition,
    split_by_value,
)
from qdot.exercises.singularities.normalized_arm import normalize_arm, normalize_conditions
from qdot.exercises.singularities.singular_set import Component, find_singular_set
from qdot.exercises.singularities.singularity_kinds import are_one_sided, classify_samples
from qdot.exercises.verify.numeric_model import Check, Checks, NumericModel

ARM_COUNTS, SAMPLES_PER_PIECE = (4, 20, 80), 8
"""Numbers of choices of lengths, and number of configurations that are tested on a piece of the singular set.

A larger number of choices is tried only if the smaller number gives no configuration."""

TOLERANCE = 1e-6
"""Tolerance for a distance in metres and for the sine of an angle; samples are singular to about 1e-9."""

PositionFunction = Callable[[np.ndarray], np.ndarray]
"""Returns the position (..., 3), in m, of the subject of a statement, at configurations (..., n)."""


def check_singularity_statements(model: NumericModel) -> Checks:
    """Check what the worked solution says about each component of the singular set.

    If the solution has one statement for each joint value of a component, each statement is checked.
    """
    chain = model.chain
    for component in find_singular_set(chain) or ():
        subsets = [subset for _, subset in split_by_value(component, classify(chain, component))]
        for subset in subsets or [component]:
            yield check_component_statement(chain, subset)


def check_component_statement(chain: Chain, component: Component) -> Check:
    """Check what the worked solution says about a component of the singular set, or about a subset of a component."""
    pieces = tuple(normalize_conditions(chain, component))
    return _check_statement(normalize_arm(chain), pieces, classify(chain, component))


@lru_cache(maxsize=4096)
def _check_statement(chain: Chain, pieces: tuple[str, ...], classification: Classification) -> Check:
    """Check a statement and the kind of singularity at configurations on pieces of a normalized arm's singular set."""
    samples = [sample for piece in pieces for sample in _sample_piece(chain, piece)]
    name = f"said of {' or '.join(pieces)}"
    counterexamples = [sample for sample in samples if not statement_holds(chain, classification.meaning, sample)]
    if samples and not counterexamples:
        detail = f"{classification.meaning}; {classification.kind}, at {len(samples)} places"
        return Check(name, all_have_kind(chain, classification, samples), detail)
    first_q = counterexamples[0].q if counterexamples else ()
    location = ", ".join(f"{q} = {value:.4g}" for q, value in zip(chain.q, first_q, strict=False))
    detail = f"{classification.meaning}: at {len(counterexamples)} of {len(samples)} not so, as at {location}"
    return Check(name, False, detail)


def check_side_of_lost_direction(
    chain: Chain, condition: sp.Expr | None, values: tuple[tuple[sp.Symbol, sp.Expr], ...], samples: Sequence[Sample]
) -> Check:
    """Check that P can't move to one side of the lost direction at any sample, if a solution says that it can't.

    The samples are configurations at which `condition` is zero and some joints have the given `values`.
    """
    is_stated = is_one_sided(chain, condition, values)
    detail = f"one side only is{'' if is_stated else ' not'} said, at {len(samples)} configurations"
    return Check("side of the lost direction", not is_stated or are_one_sided(chain, samples), detail)


def sample_component(chain: Chain, component: Component) -> list[Sample]:
    """Return configurations of the normalized arm on a component, other than those used to classify it."""
    return [
        sample
        for piece in normalize_conditions(chain, component)
        for sample in _sample_piece(normalize_arm(chain), piece)
    ]


def _sample_piece(chain: Chain, piece: str) -> tuple[Sample, ...]:
    """Return configurations on a piece of the singular set.

    More arms are tried if the piece, such as theta3 = acos(-a2/a3), exists for few lengths only.
    """
    arm_counts = ARM_COUNTS if chain.parameters else (1,)
    samples_per_arm = SAMPLES_PER_PIECE // arm_counts[0]
    attempts = (sample_condition(chain, piece, "verify/said", count, samples_per_arm) for count in arm_counts)
    return next(filter(None, attempts), ())


def all_have_kind(chain: Chain, classification: Classification, samples: Sequence[Sample]) -> bool:
    """Return whether all configurations have the kind that the solution states; True if no common kind is stated."""
    kind = classification.kind
    return not kind or not classification.is_uniform or set(classify_samples(chain, samples)) <= {kind}


@dataclass(frozen=True)
class _Clause:
    """A clause of a statement about a configuration, matched with a pattern that captures its joints and points."""

    chain: Chain
    sample: Sample
    match: re.Match[str]

    @property
    def joints(self) -> list[int]:
        """The joints that the clause lists, counted from 0."""
        return [int(number) - 1 for number in re.findall(r"\d+", self.match["joints"] or "")]


def statement_holds(chain: Chain, statement: str, sample: Sample) -> bool:
    """Return whether a statement is true at a configuration; a statement that no pattern matches is false."""

    def clause_holds(text: str) -> bool:
        matches = ((re.fullmatch(pattern, text), test) for pattern, test in _TESTS.items())
        return any(match is not None and test(_Clause(chain, sample, match)) for match, test in matches)

    return all(map(clause_holds, re.split(r", and (?=the |joints? \d|prismatic |arm )", statement)))


def _make_position_function(sample: Sample, subject: str) -> PositionFunction:
    """Return the function from configurations to the position of a statement's subject.

    The subject is the tool point, the origin of a frame, a point on a joint's axis, or the wrist centre.
    """
    if subject == "the point":
        return sample.arm.compute_point
    if subject == "the wrist centre":
        return lambda q: _find_nearest_point(sample.arm.compute_frames(q)[..., -4:-1, :, :])
    (number,) = map(int, re.findall(r"\d+", subject))
    frame = number if subject.startswith("the origin") else number - 1
    return lambda q: sample.arm.compute_frames(q)[..., frame, :3, 3]


def _find_nearest_point(frames: np.ndarray) -> np.ndarray:
    """Return the point nearest to the z axes of frames (..., k, 4, 4): the least-squares solution, (..., 3)."""
    z = frames[..., :3, 2]
    projections = np.eye(3) - z[..., :, None] * z[..., None, :]
    moments = np.einsum("...kij,...kj->...i", projections, frames[..., :3, 3])
    return np.linalg.solve(projections.sum(axis=-3), moments[..., None])[..., 0]


def _locate_axis(sample: Sample, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the direction (3) of a joint's axis and a point (3) on the axis."""
    frame = sample.frames[joint]
    return frame[:3, 2], frame[:3, 3]


def compute_distances_from_axis(sample: Sample, positions: np.ndarray, joint: int) -> np.ndarray:
    """Return the distances (k) of positions (k, 3) from a joint's axis at the sample's configuration."""
    z, origin = _locate_axis(sample, joint)
    return np.asarray(np.linalg.norm(np.cross(positions - origin, z), axis=-1))


def _move_joint(sample: Sample, joint: int) -> np.ndarray:
    """Return the sample's configuration, followed by configurations in which only one joint is moved, (k, n)."""
    steps = np.linspace(-np.pi, np.pi, 181) if sample.arm.is_revolute[joint] else np.linspace(-5, 5, 201)  # 2° or 5 cm
    return np.asarray(sample.q + np.concatenate([[0.0], steps])[:, None] * np.eye(len(sample.q))[joint])


def _name_extreme(distances: np.ndarray) -> str:
    """Return "far" if the first distance is the largest, "near" if the smallest; "" otherwise or if all are equal."""
    first_distance, min_distance, max_distance = distances[0], distances.min(), distances.max()
    tolerance = min(1e-8, 0.01 * (max_distance - min_distance))
    if tolerance < 1e-12:
        return ""
    if first_distance > max_distance - tolerance:
        return "far"
    return "near" if first_distance < min_distance + tolerance else ""


def _is_on_axes(clause: _Clause) -> bool:
    """Return whether the subject lies on the axes of the joints.

    The tool point must not move if a revolute joint rotates, here by 0.7 rad.
    """
    sample = clause.sample
    position = _make_position_function(sample, clause.match["subject"])
    point = position(sample.q)
    return all(
        np.linalg.norm(position(sample.q + 0.7 * np.eye(len(sample.q))[joint]) - point) < TOLERANCE
        if sample.arm.is_revolute[joint] and clause.match["subject"] == "the point"
        else compute_distances_from_axis(sample, point[None], joint)[0] < TOLERANCE
        for joint in clause.joints
    )


def _are_collinear(clause: _Clause) -> bool:
    """Return whether the axes of the joints coincide: two points on the first axis lie on all other axes."""
    sample = clause.sample
    first_joint, *other_joints = clause.joints
    z, origin = _locate_axis(sample, first_joint)
    points = np.stack([origin, origin + z])
    return all(compute_distances_from_axis(sample, points, joint).max() < TOLERANCE for joint in other_joints)


def _is_extreme(clause: _Clause) -> bool:
    """Return whether moving one joint cannot bring the subject farther from (or nearer to) an axis."""
    sample = clause.sample
    configurations = _move_joint(sample, int(clause.match["moving_joint"]) - 1)
    positions = _make_position_function(sample, clause.match["subject"])(configurations)
    distances = compute_distances_from_axis(sample, positions, int(clause.match["axis"]) - 1)
    return _name_extreme(distances) in re.findall("far|near", clause.match["extreme"])


def _is_extreme_sideways(clause: _Clause) -> bool:
    """Return whether the joint has moved the point as far as possible to one side of the prismatic joint.

    Seen along the axis of the prismatic joint, the circle on which the joint moves the point is an ellipse or a line.
    On a line, the point must be at one of the two ends.
    """
    sample, prismatic_joint = clause.sample, int(clause.match["prismatic"]) - 1
    if clause.chain.joints[prismatic_joint].is_revolute:
        return False
    configurations = _move_joint(sample, int(clause.match["moving_joint"]) - 1)
    z, origin = _locate_axis(sample, prismatic_joint)
    offsets = _make_position_function(sample, clause.match["subject"])(configurations) - origin
    projections = offsets - (offsets @ z)[:, None] * z
    side_direction = projections[0] / max(float(np.linalg.norm(projections[0])), 1e-12)
    deviations = projections - projections.mean(axis=0)
    _, _, main_directions = np.linalg.svd(deviations)
    line_direction = main_directions[0]
    return bool(_name_extreme(projections @ side_direction) or _name_extreme(deviations @ line_direction))


def _is_stretched(clause: _Clause) -> bool:
    """Return whether the arm is stretched out or folded back after one of its revolute joints, as stated.

    If the arm is stretched out, the later parallel joints can bring the point no farther from the axis. If it is folded
    back, some of these joints can bring the point no nearer. If the task has angular rows, the statement may instead be
    true of a point on the last axis or of the wrist centre.
    """
    sample, stated_stretches = clause.sample, set(re.findall("stretched out|folded back", clause.match[0]))
    revolute_joints = [i for i, kind in enumerate(sample.arm.kinds) if kind == REVOLUTE]
    subjects = ["the point"]
    if any(row[0] == "w" for row in clause.chain.task):
        subjects += [f"the axis of joint {len(sample.q)}", *(["the wrist centre"] if len(sample.q) == 6 else [])]
    return any(
        _describe_stretch(sample, _make_position_function(sample, subject), revolute_joints[i:]) in stated_stretches
        for subject in subjects
        for i in range(len(revolute_joints))
    )


def _describe_stretch(sample: Sample, position: PositionFunction, revolute_joints: Sequence[int]) -> str:
    """Return "stretched out" or "folded back" for the arm after the first of some revolute joints; "" if it is neither.

    Only joints that change the distance of the position from the first axis count. Their axes must be parallel, and
    each of these joints must have brought the position to its largest or smallest distance. The arm is stretched out if
    all links between the axes point in the same direction, seen along the axes.
    """
    first_joint, *later_joints = revolute_joints
    distances_by_joint = {
        joint: compute_distances_from_axis(sample, position(_move_joint(sample, joint)), first_joint)
        for joint in later_joints
    }
    effective_joints = [joint for joint, distances in distances_by_joint.items() if np.ptp(distances) > TOLERANCE]
    z = sample.axes[first_joint]
    if not effective_joints or any(
        not _name_extreme(distances_by_joint[joint]) or abs(z @ sample.axes[joint]) < 1 - TOLERANCE
        for joint in effective_joints
    ):
        return ""
    origins = [sample.frames[joint][:3, 3] for joint in (first_joint, *effective_joints)]
    points = [*origins, position(sample.q[None])[0]]
    links = np.diff([point - (point @ z) * z for point in points], axis=0)
    return "stretched out" if np.all(links @ links.T > -TOLERANCE) else "folded back"


def _are_parallel(clause: _Clause) -> bool:
    directions = clause.sample.axes[clause.joints]
    return all(np.linalg.norm(np.cross(a, b)) < TOLERANCE for a, b in pairwise(directions))


def _are_parallel_to_plane(clause: _Clause) -> bool:
    return bool(np.linalg.svd(clause.sample.axes[clause.joints], compute_uv=False)[-1] < TOLERANCE)


def _are_coplanar(clause: _Clause) -> bool:
    """Return whether axes are parallel and lie in one plane: all lines between them have the same normal."""
    (z, origin), *other_axes = (_locate_axis(clause.sample, joint) for joint in clause.joints)
    normals = np.array([np.cross(z, point - origin) for _, point in other_axes])
    return _are_parallel(clause) and bool(np.linalg.svd(normals, compute_uv=False)[1] < TOLERANCE)


def _has_stated_direction(clause: _Clause) -> bool:
    """Return whether a prismatic axis is along, or perpendicular to, the line between two parallel joint axes."""
    joints = [int(clause.match[name]) - 1 for name in ("prismatic", "first", "second")]
    if clause.chain.joints[joints[0]].is_revolute:
        return False
    (direction, _), (z, start), (_, end) = (_locate_axis(clause.sample, joint) for joint in joints)
    line = (end - start) - ((end - start) @ z) * z
    if np.linalg.norm(line) < TOLERANCE:
        return False
    line /= np.linalg.norm(line)
    deviation = np.cross(direction, line) if clause.match["direction"] == "along" else direction @ line
    return bool(np.linalg.norm(deviation) < TOLERANCE)


def _move_along_one_line(clause: _Clause) -> bool:
    """Return whether two joints move the point in parallel directions, by finite differences."""
    sample = clause.sample
    nudges = 1e-5 * np.eye(len(sample.q))[clause.joints]
    a, b = (sample.arm.compute_point(sample.q + nudges) - sample.arm.compute_point(sample.q - nudges)) / 2e-5
    return bool(np.linalg.norm(np.cross(a, b)) < 10 * TOLERANCE * np.linalg.norm(a) * np.linalg.norm(b))


def _have_no_effect(clause: _Clause) -> bool:
    """Return whether the joints can move while the stated point or link, or everything in the task, stays at rest."""
    sample, rows = clause.sample, clause.chain.task_rows
    joints = clause.joints
    jacobian = sample.arm.compute_jacobian(sample.q)[:, joints]
    _, sigma, motions = np.linalg.svd(jacobian[rows])
    full_rank = min(len(rows), len(joints))
    if len(joints) <= len(rows) and sigma[full_rank - 1] > TOLERANCE * max(float(sigma[0]), 1e-3):
        return False
    velocities = np.abs(jacobian @ motions[-1])
    stated_velocities = {"leave the point at rest": velocities[:3], f"leave link {len(sample.q)} at rest": velocities}
    return bool(stated_velocities.get(clause.match["rest_clause"] or "", velocities[rows]).max() < TOLERANCE)


def _are_dependent(clause: _Clause) -> bool:
    """Return whether the task Jacobian has less than full rank."""
    sigma = np.linalg.svd(clause.sample.arm.compute_jacobian(clause.sample.q)[clause.chain.task_rows], compute_uv=False)
    return bool(sigma[-1] < TOLERANCE * max(float(sigma[0]), 1e-3))


_SUBJECT_PATTERN = r"(?P<subject>the point|the wrist centre|the origin O\d+|the axis of joint \d+)"
_JOINTS_PATTERN = r"(?P<joints>[\d, and]+)"
_TESTS: dict[str, Callable[[_Clause], bool]] = {
    rf"{_SUBJECT_PATTERN} lies on the ax[ie]s of joints? {_JOINTS_PATTERN}"
    r"(, which then do(es)? not move it)?": _is_on_axes,
    rf"the axes of joints {_JOINTS_PATTERN} coincide": _are_collinear,
    r"arm (stretched out|folded back)( or folded back)?": _is_stretched,
    rf"(arm retracted: )?{_SUBJECT_PATTERN} is (?P<extreme>as far from|as near to|as far from or as near to)"
    r" the axis of joint (?P<axis>\d+) as joint (?P<moving_joint>\d+) can bring it": _is_extreme,
    rf"{_SUBJECT_PATTERN} is as far to one side of prismatic joint (?P<prismatic>\d+)"
    r" as joint (?P<moving_joint>\d+) can bring it": _is_extreme_sideways,
    rf"the axes of (prismatic )?joints {_JOINTS_PATTERN} are parallel": _are_parallel,
    rf"the axes of joints {_JOINTS_PATTERN} are all parallel to one plane": _are_parallel_to_plane,
    rf"the parallel axes of joints {_JOINTS_PATTERN} lie in one plane": _are_coplanar,
    r"prismatic joint (?P<prismatic>\d+) moves (?P<direction>along|at right angles to) the line"
    r" from the axis of joint (?P<first>\d+) to that of joint (?P<second>\d+)": _has_stated_direction,
    rf"joints {_JOINTS_PATTERN} move the point along the same line": _move_along_one_line,
    r"joint (?P<joints>\d+) has no effect(?P<rest_clause>) on the task": _have_no_effect,
    rf"joints {_JOINTS_PATTERN} can move together and (?P<rest_clause>.*)": _have_no_effect,
    NO_SIMPLE_MEANING: _are_dependent,
}
"""Maps the pattern of each kind of statement to its test."""
