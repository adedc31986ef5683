"""Axes, position vectors, columns and twists by velocity propagation (6.9 to 6.13; Example 6.4).

Linear rows come first, as in (6.6); where an arm is told by its axes, they have the order of its twists.
"""

from dataclasses import dataclass

import numpy as np

from qdot.exercises.answers import Matrix
from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.derivation_graph import Change, Working, propagate_linear_rows
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, OneOfSeveral, Part
from qdot.exercises.questions.base import (
    Asked,
    Question,
    objection_to_length,
    rates_to,
    substitute_columns,
    velocities,
)


@dataclass(frozen=True, kw_only=True)
class OfFrame(OneOfSeveral):
    """About the frame of a link, by its number."""

    frame: int


def _ask_axes(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).z), Details()


def _ask_vectors(chain: Chain, rng: Stream) -> Asked:
    return Matrix(derive(chain).p_star), Details()


def _object_to_point(chain: Chain) -> str | None:
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


def _ask_geometric(chain: Chain, rng: Stream) -> Asked:
    return Matrix(convention_of(chain).velocity_rows(derive(chain).geometric)), Details()


def _ask_twist(chain: Chain, rng: Stream) -> Asked:
    return Matrix(convention_of(chain).velocity_rows(derive(chain).twist())), Details()


def _ask_link_velocity(chain: Chain, rng: Stream) -> Asked:
    # Frame 1 moves alike on too many arms; frames beyond the third are too much work.
    k = rng.integer(min(2, chain.n - 1), min(chain.n - 1, 3))
    d = derive(chain)
    return Matrix(d.twist(d.link_jacobian(k))), OfFrame(frame=k)


def _object_to_joints(chain: Chain) -> str | None:
    return None if chain.n > 1 else "it has one joint, so no frame between base and end"


AXES = ("x", "y", "z")
"""Of a frame, to which the rows of vectors belong."""


def _names_of_axes(chain: Chain) -> tuple[str, ...]:
    """Return the axes' names as they are typed: of the frames they are axes of, or what an axis gives P."""
    return tuple(convention_of(chain).typed_axis(i) for i in range(1, chain.n + 1))


# --- out of a derivation ---


def _derived_geometric(w: Working, part: Part) -> np.ndarray:
    return _reorder_rows(w, w["geometric"])


def _reorder_rows(w: Working, rows: np.ndarray) -> np.ndarray:
    """Return six rows, linear first, in the order in which they are asked for; or those in that order, linear first."""
    return np.asarray(rows[[TASK_ROWS.index(row) for row in convention_of(w.chain).velocities]])


def _substitute_geometric(rows: np.ndarray) -> dict[str, Change]:
    return {"geometric": lambda w, _: _reorder_rows(w, rows)}


def _linear_rows(chain: Chain) -> list[tuple[int, int]]:
    return [
        (row, axis)
        for row, name in enumerate(convention_of(chain).velocities)
        for axis in range(3)
        if name == TASK_ROWS[axis]
    ]


def _derived_link_velocity(w: Working, part: Part) -> np.ndarray:
    frame = part.about(OfFrame).frame
    return apply_matrix(w.up_to(frame)["geometric"], w["joint rates"][:frame])


QUESTIONS = (
    Question(
        name="joint-axes",
        title="Joint axes",
        source="below 6.10",
        ask=_ask_axes,
        columns=_names_of_axes,
        grid=lambda chain: (AXES, [convention_of(chain).axis(joint) for joint in range(1, chain.n + 1)]),
        too_long=objection_to_length("z"),
        result=lambda w, _: w["axes"][: w.n].swapaxes(0, 1),
        substitutes=substitute_columns("axes", linear=propagate_linear_rows),
    ),
    Question(
        name="position-vectors",
        speaks_of=FRAMES,
        title="Position vectors p*",
        source="6.13",
        ask=_ask_vectors,
        points=2.0,
        objection=_object_to_point,
        grid=lambda chain: (AXES, [convention_of(chain).vector(joint) for joint in range(1, chain.n + 1)]),
        too_long=objection_to_length("p_star"),
        result=lambda w, _: w["arms"][: w.n].swapaxes(0, 1),
        substitutes=substitute_columns("arms", linear=propagate_linear_rows),
    ),
    Question(
        name="geometric-jacobian",
        title="Geometric Jacobian by propagation",
        source="6.12",
        ask=_ask_geometric,
        needs=("joint-axes", "position-vectors"),
        points=2.0,
        too_long=objection_to_length("geometric"),
        result=_derived_geometric,
        grid=rates_to(lambda chain: convention_of(chain).velocities),
        substitutes=_substitute_geometric,
        follows=(("joint-axes", "position-vectors"),),
        adds_up="columns of links",
        linear_rows=_linear_rows,
    ),
    Question(
        name="twist",
        title="Twist of the end effector",
        source="6.9 and 6.10",
        ask=_ask_twist,
        needs=("geometric-jacobian",),
        too_long=objection_to_length("geometric"),
        result=lambda w, part: apply_matrix(_derived_geometric(w, part), w["joint rates"]),
        entry_names=lambda chain, _: velocities(convention_of(chain).velocities),
        follows=(("geometric-jacobian",),),
    ),
    Question(
        name="link-velocity",
        speaks_of=FRAMES,
        title="Velocity of a link frame",
        source="6.9 and 6.10",
        ask=_ask_link_velocity,
        objection=_object_to_joints,
        result=_derived_link_velocity,
        entry_names=lambda chain, _: velocities(TASK_ROWS),
    ),
)  # fmt: skip
