"""Configurations to choose from: an arm with numeric lengths, and its singular and regular configurations."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.directions import clear_rank
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.lengths import with_lengths
from qdot.exercises.arm.singularity import Component, singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.geometry import (
    Pose,
    full_rank,
    jacobian_at,
    make_pose,
    sample_regular_pose,
    sample_shown_pose,
    sample_unequal_lengths,
    wrap_angle,
)
from qdot.exercises.questions.inversion import sample_pose
from qdot.exercises.quizzes.options import Blame, Places
from qdot.exercises.quizzes.wrong_sets import wrong_sets

CLEAR = 0.12
"""Ratio of the smallest to the largest singular value at which a configuration is visibly regular."""
TRIES = 40
_LOOKED_AT = 200

Lengths = dict[sp.Symbol, sp.Rational]
PoseAndBlame = tuple[Pose, Blame | None]
"""A configuration, and the mistake (if any) that makes it seem singular."""


def with_random_lengths(chain: Chain, rng: Stream) -> tuple[Chain, Lengths]:
    """Return the arm with a random number for each symbolic length of its table, and these numbers."""
    lengths = sample_unequal_lengths(chain, rng)
    return with_lengths(chain, lengths), lengths


@lru_cache(maxsize=256)
def clearness(chain: Chain) -> float:
    """Return the ratio of smallest to largest singular value at which a configuration of this arm is clearly regular.

    Some arms, such as a SCARA with short links, hardly ever reach `CLEAR`. For these it is the median of the ratio.
    """
    rng, arm = Stream("clearness"), NumericChain(chain, {})
    q = np.array([[float(value) for value in sample_pose(chain, rng).values()] for _ in range(_LOOKED_AT)])
    sigma = np.linalg.svd(arm.jacobian(q)[:, chain.task_rows], compute_uv=False)
    return min(CLEAR, round(float(np.median(sigma[:, -1] / np.maximum(sigma[:, 0], 1e-12))), 3))


def singular_poses(chain: Chain, rng: Stream) -> Iterator[PoseAndBlame]:
    """Yield singular configurations of an arm, from all components of its singular set in turn."""
    components = singular_set(chain) or ()
    for _ in range(TRIES):
        for component in rng.permutation(components):
            configuration = sample_shown_pose(chain, (component,), rng)
            if configuration is not None:
                yield configuration, None


def regular_poses(chain: Chain, rng: Stream) -> Iterator[PoseAndBlame]:
    """Yield regular configurations: first those that a known mistake makes seem singular, then random ones."""
    for component, blame in rng.permutation(_find_falsely_singular(chain)):
        configuration = _sample_regular_pose_with(chain, component, rng)
        if configuration is not None:
            yield configuration, blame
    for _ in range(TRIES):
        configuration = sample_regular_pose(chain, rng, clearness(chain))
        if configuration is not None:
            yield configuration, None


def _find_falsely_singular(chain: Chain) -> list[tuple[Component, Blame]]:
    correct_set = singular_set(chain) or ()
    return [
        (component, option.behind[0])
        for option in wrong_sets(chain, correct_set)
        for component in option.shown
        if component not in correct_set and component.solutions is not None
    ]


def _sample_regular_pose_with(chain: Chain, component: Component, rng: Stream) -> Pose | None:
    """Return a regular configuration with the joint values of a component that is wrongly called singular."""
    assert component.solutions is not None
    for _ in range(6):
        configuration = sample_regular_pose(chain, rng, clearness(chain), misleading=False)
        if configuration is None:
            return None
        values = {q: rng.choice(values) for q, values in component.solutions}
        regular = regular_pose_at(chain, {**configuration.joints, **values})
        if regular is not None:
            return regular
    return None


def regular_pose_at(chain: Chain, joints: dict[sp.Symbol, sp.Expr]) -> Pose | None:
    """Return the configuration with these joint values if it is clearly regular, else None."""
    if any(value.free_symbols or not sp.N(value).is_real for value in joints.values()):
        return None
    configuration = make_pose(chain, {}, {q: wrap_angle(chain, q, value) for q, value in joints.items()})
    return (
        configuration if clear_rank(jacobian_at(chain, configuration), clearness(chain)) == full_rank(chain) else None
    )


def take_distinct(candidates: Iterator[PoseAndBlame], count: int, excluded: Sequence[Pose] = ()) -> list[PoseAndBlame]:
    """Return up to `count` candidates whose texts differ from each other and from those of the excluded ones."""
    texts = {write_pose(configuration) for configuration in excluded}
    distinct: list[PoseAndBlame] = []
    for configuration, blame in candidates:
        if len(distinct) == count:
            break
        if write_pose(configuration) not in texts:
            texts.add(write_pose(configuration))
            distinct.append((configuration, blame))
    return distinct


def write_pose(pose: Pose) -> str:
    """Return joint values as plain text, such as "theta1 = 30 deg, d2 = 0.4 m"."""
    return ", ".join(f"{q} = {_write_value(pose, q)}" for q in pose.joints)


def _write_value(pose: Pose, q: sp.Symbol) -> str:
    is_revolute = q.name.startswith("theta")
    value = pose.about.get(q, pose.joints[q] * 180 / sp.pi if is_revolute else pose.joints[q])
    number = str(value) if value.is_Integer else f"{float(value):.10g}"
    return f"{number} {'deg' if is_revolute else 'm'}"


def find_drawn_options(chain: Chain, part: Part) -> tuple[Chain, list[dict[str, float]]] | None:
    """Return the numeric arm and the configurations to draw if the options of a part are drawings, else None."""
    if not part.has_drawn_options:
        return None
    details = part.about(Places)
    return with_lengths(chain, details.lengths), [configuration.figure for configuration in details.places]
