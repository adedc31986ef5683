"""Questions on joint axes, position vectors, J and twists by velocity propagation (6.9 to 6.13; Example 6.4).

Linear rows come first, as in (6.6). If an arm is described by its axes, rows have the order of its twists.
"""

from dataclasses import dataclass

import numpy as np

from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES
from qdot.exercises.arm.derivation_graph import Working, propagate_linear_rows
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, OneOfSeveral
from qdot.exercises.questions.base import (
    Question,
    objection_to_length,
    objection_to_point,
    rates_to,
    substitute_columns,
    times_rates,
    velocities,
)


@dataclass(frozen=True, kw_only=True)
class OfFrame(OneOfSeveral):
    """Details of a question about the frame of a link, by its number."""

    frame: int


def _choose_link(chain: Chain, rng: Stream) -> OfFrame:
    # Too many arms have the same motion of frame 1, and frames beyond the third are too much work.
    return OfFrame(frame=rng.integer(min(2, chain.n - 1), min(chain.n - 1, 3)))


def _derive_link_velocity(w: Working, details: Details) -> np.ndarray:
    assert isinstance(details, OfFrame)
    return apply_matrix(w.up_to(details.frame)["geometric"], w["joint rates"][: details.frame])


AXES = ("x", "y", "z")
"""The axes of a frame, which label the rows of vectors."""


def _name_axes(chain: Chain) -> tuple[str, ...]:
    """Return the names that a student may type for the joint axes in the arm's convention."""
    return tuple(convention_of(chain).typed_axis(i) for i in range(1, chain.n + 1))


def _order_rows(chain: Chain) -> list[int]:
    """Return the indices, among six rows with the linear ones first, of the rows in the order asked for."""
    return [TASK_ROWS.index(row) for row in convention_of(chain).velocities]


def _find_linear_rows(chain: Chain) -> list[tuple[int, int]]:
    return [(row, axis) for row, axis in enumerate(_order_rows(chain)) if axis < 3]


QUESTIONS = (
    Question(
        "joint-axes", "Joint axes", "below 6.10",
        formula=lambda w, _: w["axes"][: w.n].swapaxes(0, 1),
        substitutes=substitute_columns("axes", linear=propagate_linear_rows),
        columns=_name_axes,
        grid=lambda chain: (AXES, [convention_of(chain).axis(joint) for joint in range(1, chain.n + 1)]),
        too_long=objection_to_length("z"),
    ),
    Question(
        "position-vectors", "Position vectors p*", "6.13", points=2.0, speaks_of=FRAMES,
        formula=lambda w, _: w["arms"][: w.n].swapaxes(0, 1),
        substitutes=substitute_columns("arms", linear=propagate_linear_rows),
        grid=lambda chain: (AXES, [convention_of(chain).vector(joint) for joint in range(1, chain.n + 1)]),
        objection=objection_to_point, too_long=objection_to_length("p_star"),
    ),
    Question(
        "geometric-jacobian", "Geometric Jacobian by propagation", "6.12", points=2.0,
        needs=("joint-axes", "position-vectors"), stage="geometric", row_order=_order_rows,
        grid=rates_to(lambda chain: convention_of(chain).velocities), too_long=objection_to_length("geometric"),
        adds_up="columns of links", linear_rows=_find_linear_rows,
    ),
    Question(
        "twist", "Twist of the end effector", "6.9 and 6.10", needs=("geometric-jacobian",),
        formula=times_rates("geometric", _order_rows), too_long=objection_to_length("geometric"),
        entry_names=lambda chain, _: velocities(convention_of(chain).velocities),
    ),
    Question(
        "link-velocity", "Velocity of a link frame", "6.9 and 6.10", speaks_of=FRAMES,
        formula=_derive_link_velocity, details=_choose_link, entry_names=lambda chain, _: velocities(TASK_ROWS),
        objection=lambda chain: None if chain.n > 1 else "it has one joint, so no frame between base and end",
    ),
)  # fmt: skip
