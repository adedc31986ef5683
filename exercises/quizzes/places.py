"""Configurations to choose from: an arm with lengths, and poses of it in which it is singular or not."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.answers import ConditionSet
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.directions import clear_rank, task_rows
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.lengths import with_lengths
from qdot.exercises.arm.singularity import Component, singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.mistakes.catalogue import mistaken_answers
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.geometry import (
    Pose,
    distinct_lengths,
    jacobian_at,
    pose_of,
    regular_pose,
    shown_pose,
    turned_back,
)
from qdot.exercises.questions.inversion import draw_pose
from qdot.exercises.quizzes.options import SHOWS_ITSELF, Blame, Places

CLEAR = 0.12
"""Least singular value of a regular pose over the largest one, so that it is clear to the eye."""
TRIES = 40
_LOOKED_AT = 200

Lengths = dict[sp.Symbol, sp.Rational]
Found = tuple[Pose, Blame | None]
"""A pose, and the mistake by which it is taken for singular, if it is one."""


def drawn_lengths(chain: Chain, rng: Stream) -> tuple[Chain, Lengths]:
    """Return the arm with a number for each length that its table leaves open, and these numbers."""
    lengths = distinct_lengths(chain, rng)
    return with_lengths(chain, lengths), lengths


@lru_cache(maxsize=256)
def clearness(chain: Chain) -> float:
    """Return what the least singular value of a clearly regular pose is over the largest one, for an arm in numbers.

    Some arms, as a SCARA with short links, hardly ever reach `CLEAR`: of these, poses no worse than the usual ones are.
    """
    rng, arm = Stream("clearness"), NumericChain(chain, {})
    q = np.array([[float(value) for value in draw_pose(chain, rng).values()] for _ in range(_LOOKED_AT)])
    sigma = np.linalg.svd(arm.jacobian(q)[:, task_rows(chain)], compute_uv=False)
    return min(CLEAR, round(float(np.median(sigma[:, -1] / np.maximum(sigma[:, 0], 1e-12))), 3))


def singular_poses(chain: Chain, rng: Stream) -> Iterator[Found]:
    """Yield singular poses of an arm in numbers, from all parts of its singular set in turn."""
    components = singular_set(chain) or ()
    for _ in range(TRIES):
        for component in rng.shuffled(components):
            pose = shown_pose(chain, (component,), rng)
            if pose is not None:
                yield pose, None


def regular_poses(chain: Chain, rng: Stream) -> Iterator[Found]:
    """Yield regular poses: first those that a mistake of the catalogue takes for singular, then any that look so."""
    for component, blame in rng.shuffled(_called_singular(chain)):
        pose = _regular(chain, component, rng)
        if pose is not None:
            yield pose, blame
    for _ in range(TRIES):
        pose = regular_pose(chain, rng, clearness(chain))
        if pose is not None:
            yield pose, None


def _called_singular(chain: Chain) -> list[tuple[Component, Blame]]:
    right = singular_set(chain) or ()
    part = Part("singular-angles", "singular-angles", ConditionSet(right))
    places = []
    for mistake, slip in mistaken_answers(chain, part):
        answer = slip.answer
        if not mistake.rare and mistake.name not in SHOWS_ITSELF and isinstance(answer, ConditionSet):
            new = [one for one in answer.components if one not in right and one.solutions is not None]
            places += [(one, Blame.of(mistake, slip.words.items())) for one in new]
    return places


def _regular(chain: Chain, component: Component, rng: Stream) -> Pose | None:
    """Return a regular pose with joint values that a mistake calls singular."""
    assert component.solutions is not None
    for _ in range(6):
        pose = regular_pose(chain, rng, clearness(chain), slips=False)
        if pose is None:
            return None
        values = {q: rng.choice(values) for q, values in component.solutions}
        regular = posed(chain, {**pose.joints, **values})
        if regular is not None:
            return regular
    return None


def posed(chain: Chain, joints: dict[sp.Symbol, sp.Expr]) -> Pose | None:
    """Return a pose with these joint values where it is clearly regular."""
    if any(value.free_symbols or not sp.N(value).is_real for value in joints.values()):
        return None
    pose = pose_of(chain, {}, {q: turned_back(chain, q, value) for q, value in joints.items()})
    return pose if clear_rank(jacobian_at(chain, pose), clearness(chain)) == min(len(chain.task), chain.n) else None


def several(found: Iterator[Found], count: int, taken_already: Sequence[Pose] = ()) -> list[Found]:
    """Return so many poses that differ, in their text, from each other and from those that are taken already."""
    texts = {words(pose) for pose in taken_already}
    chosen: list[Found] = []
    for pose, blame in found:
        if len(chosen) == count:
            break
        if words(pose) not in texts:
            texts.add(words(pose))
            chosen.append((pose, blame))
    return chosen


def words(pose: Pose) -> str:
    """Return joint values as plain text, as in "theta1 = 30 deg, d2 = 0.4 m"."""
    return ", ".join(f"{q} = {_value(pose, q)}" for q in pose.joints)


def _value(pose: Pose, q: sp.Symbol) -> str:
    revolute = q.name.startswith("theta")
    value = pose.about.get(q, pose.joints[q] * 180 / sp.pi if revolute else pose.joints[q])
    shown = str(value) if value.is_Integer else f"{float(value):.10g}"
    return f"{shown} {'deg' if revolute else 'm'}"


def options_drawn(chain: Chain, part: Part) -> tuple[Chain, list[dict[str, float]]] | None:
    """Return the arm in numbers and the poses to draw where the options of a part are configurations drawn, or None."""
    if not part.has_drawn_options:
        return None
    details = part.about(Places)
    return with_lengths(chain, details.lengths), [place.figure for place in details.places]
