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
from qdot.exercises.problem.problem import Details, ResultChoiceDetails
from qdot.exercises.questions import base
from qdot.exercises.questions.base import Question


@dataclass(frozen=True, kw_only=True)
class FrameDetails(ResultChoiceDetails):
    """Details of a question about the frame of a link, by its number."""

    frame: int


def _choose_link(chain: Chain, rng: Stream) -> FrameDetails:
    # Too many arms have the same motion of frame 1, and frames beyond the third are too much work.
    return FrameDetails(frame=rng.integer(min(2, chain.n - 1), min(chain.n - 1, 3)))


def _derive_link_velocity(w: Working, details: Details) -> np.ndarray:
    assert isinstance(details, FrameDetails)
    return apply_matrix(w.for_first_joints(details.frame)["geometric"], w["joint rates"][: details.frame])


AXIS_NAMES = ("x", "y", "z")
"""The axes of a frame, which label the rows of vectors."""


def _number(chain: Chain) -> range:
    """Return the numbers of the joints."""
    return range(1, chain.n + 1)


def _name_axes(chain: Chain) -> tuple[str, ...]:
    """Return the names that a student may type for the joint axes in the arm's convention."""
    return tuple(map(convention_of(chain).typed_axis, _number(chain)))


def _order_rows(chain: Chain) -> list[int]:
    """Return the indices, among six rows with the linear ones first, of the rows in the order asked for."""
    return [TASK_ROWS.index(row) for row in convention_of(chain).velocity_names]


def _find_linear_rows(chain: Chain) -> list[tuple[int, int]]:
    return [(row, axis) for row, axis in enumerate(_order_rows(chain)) if axis < 3]


QUESTIONS = (
    Question(
        "joint-axes", "Joint axes", "below 6.10", formula=lambda w, _: w["axes"][: w.n].swapaxes(0, 1),
        substitution=base.make_column_substitution("axes", linear=propagate_linear_rows), column_names=_name_axes,
        row_and_column_labels=lambda chain: (AXIS_NAMES, list(map(convention_of(chain).axis_name, _number(chain)))),
        too_long=base.make_length_objection("z"),
    ),
    Question(
        "position-vectors", "Position vectors p*", "6.13", points=2.0, required_feature=FRAMES,
        formula=lambda w, _: w["arms"][: w.n].swapaxes(0, 1),
        substitution=base.make_column_substitution("arms", linear=propagate_linear_rows),
        row_and_column_labels=lambda chain: (AXIS_NAMES, list(map(convention_of(chain).vector_name, _number(chain)))),
        objection=base.object_to_point_before_last_link, too_long=base.make_length_objection("p_star"),
    ),
    Question(
        "geometric-jacobian", "Geometric Jacobian by propagation", "6.12", points=2.0,
        needs=("joint-axes", "position-vectors"), stage="geometric", row_order=_order_rows,
        row_and_column_labels=base.make_jacobian_labels(lambda chain: convention_of(chain).velocity_names),
        too_long=base.make_length_objection("geometric"), link_sums="columns of links", link_sum_rows=_find_linear_rows,
    ),
    Question(
        "twist", "Twist of the end effector", "6.9 and 6.10", needs=("geometric-jacobian",),
        formula=base.make_rate_product_formula("geometric", _order_rows),
        too_long=base.make_length_objection("geometric"),
        entry_names=lambda chain, _: base.name_velocity_components(convention_of(chain).velocity_names),
    ),
    Question(
        "link-velocity", "Velocity of a link frame", "6.9 and 6.10", required_feature=FRAMES,
        formula=_derive_link_velocity, make_details=_choose_link,
        entry_names=lambda chain, _: base.name_velocity_components(TASK_ROWS),
        objection=lambda chain: None if chain.n > 1 else (
            "it has only one joint, so there is no frame between base and end"
        ),
    ),
)  # fmt: skip
