"""Tests of what a worked solution says of singular configurations: by turning joints, at configurations of their own.

The sentences are read back as a student reads them: what they say of axes, slides and the point is looked for in the
poses of the arm, anew, and "as far as joint 2 can bring it" by bringing it everywhere.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.classification import Kind, classify, is_one_sided, samples_on, split_by_value
from qdot.exercises.arm.kinds import are_one_sided, kinds_at
from qdot.exercises.arm.normalized_arm import normalize_arm, normalized_pieces
from qdot.exercises.arm.singularity import Component, singular_set
from qdot.exercises.verify.numeric_reference import Check, NumericReference

ARMS, OF_A_PIECE = (4, 20, 80), 8
"""Choices of lengths, more where there is nothing for fewer, and how many configurations of a piece are looked at."""

SAME = 1e-6
"""What counts as zero, in metres or as a sine: samples are singular to about 1e-9."""

Place = Callable[[np.ndarray], np.ndarray]
"""Where what is spoken of is in poses (..., n): (..., 3), m."""


def said_of_singularities(numeric: NumericReference) -> Iterator[Check]:
    """Test what the worked solution says of each component, or of each of its values where they are told apart."""
    chain = numeric.chain
    for component in singular_set(chain) or ():
        values = [part for _, part in split_by_value(component, classify(chain, component))]
        for part in values or [component]:
            yield said_of_component(chain, part)


def said_of_component(chain: Chain, component: Component) -> Check:
    """Test what is said of a component of the singular set, or of a part of one."""
    return _said(normalize_arm(chain), tuple(normalized_pieces(chain, component)), classify(chain, component))


@lru_cache(maxsize=4096)
def _said(chain: Chain, pieces: tuple[str, ...], kind: Kind) -> Check:
    samples = [sample for piece in pieces for sample in _samples(chain, piece)]
    name = f"said of {' or '.join(pieces)}"
    false = [sample for sample in samples if not holds(chain, kind.meaning, sample)]
    if false or not samples:
        where = ", ".join(f"{q} = {value:.4g}" for q, value in zip(chain.q, false[0].q, strict=True)) if false else ""
        return Check(name, False, f"{kind.meaning}: at {len(false)} of {len(samples)} not so, as at {where}")
    return Check(name, is_of_kind(chain, kind, samples), f"{kind.meaning}; {kind.kind}, at {len(samples)} places")


def side_of_lost_direction(
    chain: Chain, condition: sp.Expr | None, values: tuple[tuple[sp.Symbol, sp.Expr], ...], samples: Sequence[Sample]
) -> Check:
    """Test at other configurations what solutions say of a boundary: whether one side of the lost direction is out."""
    is_said = is_one_sided(chain, condition, values)
    detail = f"one side only is{'' if is_said else ' not'} said, at {len(samples)} configurations"
    return Check("side of the lost direction", not is_said or are_one_sided(chain, samples), detail)


def places_on(chain: Chain, component: Component) -> list[Sample]:
    """Return configurations of the bare arm on a component, other ones than those by which it was classified."""
    return [sample for piece in normalized_pieces(chain, component) for sample in _samples(normalize_arm(chain), piece)]


def _samples(chain: Chain, piece: str) -> list[Sample]:
    """Return configurations on a piece; of more arms where it is there for few lengths, as theta3 = acos(-a2/a3)."""
    many = ARMS if chain.parameters else (1,)
    tried = (samples_on(chain, piece, "verify/said", arms, OF_A_PIECE // many[0]) for arms in many)
    return next((samples for samples in tried if samples), [])


def is_of_kind(chain: Chain, kind: Kind, samples: Sequence[Sample]) -> bool:
    """Tell whether a kind is that of all configurations, where it is told of all."""
    if not kind.kind or not kind.uniform:
        return True
    return {found for found in kinds_at(chain, samples) if found is not None} <= {kind.kind}


@dataclass(frozen=True)
class _Said:
    """Words that are known, said of a configuration; `match` has what they name."""

    chain: Chain
    sample: Sample
    match: re.Match[str]

    @property
    def joints(self) -> list[int]:
        """The joints that are listed, from 0."""
        return [int(number) - 1 for number in re.findall(r"\d+", self.match["joints"] or "")]


def holds(chain: Chain, words: str, sample: Sample) -> bool:
    """Tell whether words hold at a configuration; words that are not known hold nowhere."""
    clauses = re.split(r", and (?=the |joints? \d|all |slide|arm )", words)
    return all(any(_one(chain, clause, sample)) for clause in clauses)


def _one(chain: Chain, words: str, sample: Sample) -> Iterator[bool]:
    for pattern, test in _SAYINGS.items():
        match = re.fullmatch(pattern, words)
        if match is not None:
            yield test(_Said(chain, sample, match))


def _place(sample: Sample, words: str) -> Place:
    """Return where something is: the point, the origin of a frame, a joint's axis, or the wrist's centre."""
    if words == "the point":
        return sample.arm.point
    if words == "the wrist centre":
        return lambda q: _meeting(sample.arm.frames(q)[..., -4:-1, :, :])
    (number,) = re.findall(r"\d+", words)
    frame = int(number) if words.startswith("the origin") else int(number) - 1
    return lambda q: sample.arm.frames(q)[..., frame, :3, 3]


def _meeting(frames: np.ndarray) -> np.ndarray:
    """Return the point nearest to the z axes of frames (..., k, 4, 4)."""
    z = frames[..., :3, 2]
    across = np.eye(3) - z[..., :, None] * z[..., None, :]
    due = np.einsum("...kij,...kj->...i", across, frames[..., :3, 3])
    return np.linalg.solve(across.sum(axis=-3), due[..., None])[..., 0]


def _axis(sample: Sample, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Return direction and a point of the axis of a joint."""
    frame = sample.frames[joint]
    return frame[:3, 2], frame[:3, 3]


def _away(sample: Sample, places: np.ndarray, joint: int) -> np.ndarray:
    """Return the distances of places (k, 3) from a joint's axis, which does not move."""
    z, origin = _axis(sample, joint)
    return np.asarray(np.linalg.norm(np.cross(places - origin, z), axis=-1))


def _brought(sample: Sample, joint: int) -> np.ndarray:
    """Return the pose itself and those to which a joint alone can bring the arm, (k, n)."""
    around = np.linspace(-np.pi, np.pi, 181) if sample.arm.kinds[joint] == "R" else np.linspace(-5, 5, 201)
    return np.asarray(sample.q + np.concatenate([[0.0], around])[:, None] * np.eye(len(sample.q))[joint])


def _extreme(distances: np.ndarray) -> str:
    """Tell whether the first of distances is the largest, the least or neither, as where all of them are the same."""
    first, least, largest = distances[0], distances.min(), distances.max()
    room = min(1e-8, 0.01 * (largest - least))
    if room < 1e-12:
        return ""
    return "far" if first > largest - room else "near" if first < least + room else ""


def _on_axes(said: _Said) -> bool:
    sample = said.sample
    place = _place(sample, said.match["what"])
    at = place(sample.q)
    return all(
        np.linalg.norm(place(sample.q + 0.7 * np.eye(len(sample.q))[joint]) - at) < SAME
        if sample.arm.kinds[joint] == "R" and said.match["what"] == "the point"
        else _away(sample, at[None], joint)[0] < SAME
        for joint in said.joints
    )


def _in_line(said: _Said) -> bool:
    sample = said.sample
    first, *others = said.joints
    z, origin = _axis(sample, first)
    return all(_away(sample, np.stack([origin, origin + z]), other).max() < SAME for other in others)


def _as_far(said: _Said) -> bool:
    """Bring the point, by the one joint, everywhere it can be brought to."""
    sample = said.sample
    poses = _brought(sample, int(said.match["by"]) - 1)
    distances = _away(sample, _place(sample, said.match["what"])(poses), int(said.match["axis"]) - 1)
    return _extreme(distances) in re.findall("far|near", said.match["how"])


def _as_far_aside(said: _Said) -> bool:
    """Look along the slide: the joint turns the place on a circle, seen at a slant, whose side it is at."""
    sample = said.sample
    places = _place(sample, said.match["what"])(_brought(sample, int(said.match["by"]) - 1))
    z, origin = _axis(sample, int(said.match["slide"]) - 1)
    seen = (places - origin) - ((places - origin) @ z)[:, None] * z
    side = seen[0] / max(float(np.linalg.norm(seen[0])), 1e-12)
    return _extreme(seen @ side) in ("far", "near") or _turns_back(seen)


def _turns_back(seen: np.ndarray) -> bool:
    """Tell whether places pass the first one at an end of the line on which they go to and fro."""
    spread = np.linalg.svd(seen - seen.mean(axis=0))[2][0]
    return _extreme((seen - seen.mean(axis=0)) @ spread) in ("far", "near")


def _stretched(said: _Said) -> bool:
    """Look for an axis from which the parallel ones after it bring the point no farther, or some of them no nearer.

    An arm that carries a wrist is looked at without it, and one whose last joint turns the hand without that.
    """
    sample, stated = said.sample, set(re.findall("stretched out|folded back", said.match[0]))
    turning = [i for i, kind in enumerate(sample.arm.kinds) if kind == "R"]
    places: list[Place] = [sample.arm.point]
    if any(row[0] == "w" for row in said.chain.task):
        places.append(_place(sample, f"the axis of joint {len(sample.q)}"))
        places += [_place(sample, "the wrist centre")] if len(sample.q) == 6 else []
    return any(_how_stretched(sample, place, turning[i:]) in stated for place in places for i in range(len(turning)))


def _how_stretched(sample: Sample, place: Place, turning: Sequence[int]) -> str:
    """Tell how an arm lies from the first of some joints on; nothing where another one is bent, or not parallel.

    It is stretched out where all of its links, seen along the axes, run one way.
    """
    axis, *later = turning
    moving = {joint: _away(sample, place(_brought(sample, joint)), axis) for joint in later}
    told = [joint for joint, distances in moving.items() if np.ptp(distances) > SAME]
    z = _axis(sample, axis)[0]
    if not told or any(_extreme(moving[joint]) == "" for joint in told):
        return ""
    if any(abs(z @ _axis(sample, joint)[0]) < 1 - SAME for joint in told):
        return ""
    stops = [_axis(sample, joint)[1] for joint in (axis, *told)] + [place(sample.q[None])[0]]
    links = np.diff([stop - (stop @ z) * z for stop in stops], axis=0)
    return "stretched out" if np.all(links @ links.T > -SAME) else "folded back"


def _parallel(said: _Said) -> bool:
    sample = said.sample
    axes = [_axis(sample, joint)[0] for joint in said.joints]
    return all(np.linalg.norm(np.cross(one, other)) < SAME for one, other in pairwise(axes))


def _to_one_plane(said: _Said) -> bool:
    sample = said.sample
    axes = np.array([_axis(sample, joint)[0] for joint in said.joints])
    return bool(abs(np.linalg.svd(axes, compute_uv=False)[-1]) < SAME)


def _row(said: _Said) -> bool:
    """Look for the plane of parallel axes: it holds their direction and the lines from the first to the others."""
    sample = said.sample
    axes = [_axis(sample, joint) for joint in said.joints]
    (z, origin), others = axes[0], axes[1:]
    across = [np.cross(z, place - origin) for _, place in others]
    return _parallel(said) and bool(np.linalg.svd(np.array([*across]), compute_uv=False)[1] < SAME)


def _slide_runs(said: _Said) -> bool:
    sample = said.sample
    slide, (z, start), (_, end) = (_axis(sample, int(said.match[name]) - 1) for name in ("slide", "first", "second"))
    line = (end - start) - ((end - start) @ z) * z
    if np.linalg.norm(line) < SAME:
        return False
    line /= np.linalg.norm(line)
    seen = slide[0] - (slide[0] @ z) * z
    if said.match["how"] == "along":
        return bool(np.linalg.norm(np.cross(seen, line)) < SAME)
    return bool(abs(seen @ line) < SAME)


def _one_way(said: _Said) -> bool:
    sample = said.sample
    nudges = 1e-5 * np.eye(len(sample.q))[said.joints]
    one, other = (sample.arm.point(sample.q + nudges) - sample.arm.point(sample.q - nudges)) / 2e-5
    return bool(np.linalg.norm(np.cross(one, other)) < SAME * np.linalg.norm(one) * np.linalg.norm(other) * 10)


def _moves_nothing(said: _Said) -> bool:
    """Look at joints whose columns of J depend on each other, and at what rests in the motion they can make."""
    sample = said.sample
    joints = said.joints or list(range(len(sample.q)))
    jacobian = sample.arm.jacobian(sample.q)[:, joints]
    rows = [TASK_ROWS.index(row) for row in said.chain.task]
    _, sigma, motions = np.linalg.svd(jacobian[rows])
    count = min(len(rows), len(joints))
    if len(joints) <= len(rows) and sigma[count - 1] > SAME * max(float(sigma[0]), 1e-3):
        return False
    moved = np.abs(jacobian @ motions[-1])
    resting = {"leave the point at rest": moved[:3], f"leave link {len(sample.q)} at rest": moved}
    return bool(resting.get(said.match["rests"] or "", moved[rows]).max() < SAME)


def _all_along(said: _Said) -> bool:
    sample = said.sample
    sigma = np.linalg.svd(sample.arm.jacobian(sample.q)[:3], compute_uv=False)
    return bool(sigma[1 if said.match["where"] == "along one line" else 2] < SAME)


def _all_along_as_seen(said: _Said) -> bool:
    """Look along an axis of the world: every joint moves the point along the same line, or nothing at all."""
    across = "xyz".index(said.match["axis"])
    seen = np.delete(said.sample.arm.jacobian(said.sample.q)[:3], across, axis=0)
    return bool(np.linalg.svd(seen, compute_uv=False)[1] < SAME)


def _none_moves(said: _Said) -> bool:
    rows = ["xyz".index(axis) + 3 * ("about" in said.match[0]) for axis in re.findall("[xyz]", said.match["axes"])]
    return bool(np.abs(said.sample.arm.jacobian(said.sample.q)[rows]).max() < SAME)


def _dependent(said: _Said) -> bool:
    sample = said.sample
    rows = [TASK_ROWS.index(row) for row in said.chain.task]
    sigma = np.linalg.svd(sample.arm.jacobian(sample.q)[rows], compute_uv=False)
    return bool(sigma[-1] < SAME * max(float(sigma[0]), 1e-3))


_WHAT = r"(?P<what>the point|the wrist centre|the origin O\d+|the axis of joint \d+)"
_JOINTS = r"(?P<joints>[\d, and]+)"
_SAYINGS: dict[str, Callable[[_Said], bool]] = {
    rf"{_WHAT} lies on the ax[ie]s of joints? {_JOINTS}(, which then do(es)? not move it)?": _on_axes,
    rf"the axes of joints {_JOINTS} lie on one line": _in_line,
    r"arm (stretched out|folded back)( or folded back)?": _stretched,
    rf"(arm drawn in: )?{_WHAT} is (?P<how>as far from|as near to|as far from or as near to) the axis of joint"
    r" (?P<axis>\d+) as joint (?P<by>\d+) can bring it": _as_far,
    rf"{_WHAT} is as far to one side of slide (?P<slide>\d+) as joint (?P<by>\d+) can bring it": _as_far_aside,
    rf"(the axes of joints|slides) {_JOINTS} are parallel": _parallel,
    rf"the axes of joints {_JOINTS} are all parallel to one plane": _to_one_plane,
    rf"the parallel axes of joints {_JOINTS} lie in one plane": _row,
    r"slide (?P<slide>\d+) runs (?P<how>along|at right angles to) the line from the axis of joint (?P<first>\d+)"
    r" to that of joint (?P<second>\d+)": _slide_runs,
    rf"joints {_JOINTS} move the point along the same line": _one_way,
    r"joint (?P<joints>\d+) moves nothing(?P<rests>) that the task counts": _moves_nothing,
    rf"(all joints|joints {_JOINTS}) can move together and (?P<rests>.*)": _moves_nothing,
    r"all joints move the point (?P<where>along one line|in one plane)": _all_along,
    r"seen along (?P<axis>[xyz]), all joints move the point along one line": _all_along_as_seen,
    r"no joint (moves the point along|turns link \d+ about) (?P<axes>[xyz, and]+)": _none_moves,
    r"the (columns|rows) of J are linearly dependent": _dependent,
}
