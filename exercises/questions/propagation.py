"""Questions on joint axes, position vectors, J and twists by velocity propagation (6.9 to 6.13; Example 6.4).

The linear rows of J and of a twist come first, as in (6.6), unless the arm is described by screw axes. Then the rows
have the order of the arm's twists.

Arms with a modified DH table (Craig) also have a question on velocities in the coordinates of each frame. With
R = R_{i-1,i}^T, with the origin P_i of frame i in frame i-1, and with each vector expressed in the frame that its
prefix names:

    i_omega_i = R i-1_omega_i-1 + qd_i z,   i_v_i = R (i-1_v_i-1 + i-1_omega_i-1 x P_i)           revolute
    i_omega_i = R i-1_omega_i-1,            i_v_i = R (i-1_v_i-1 + i-1_omega_i-1 x P_i) + qd_i z   prismatic
"""

from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES, FRAMES_OF_JOINTS, VELOCITY_NAMES
from qdot.exercises.arm.kinematics import Z
from qdot.exercises.arm.trigonometry import count_terms, to_textbook_form
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import apply_matrix
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.derivation.graph import StageResults
from qdot.exercises.problem.problem import Details, ResultChoiceDetails
from qdot.exercises.questions import base
from qdot.exercises.questions.base import Question

AXIS_NAMES = ("x", "y", "z")
"""The axes of a frame, which label the rows of vectors."""

LAST_FRAME = 3
"""The last frame for whose velocity questions ask; the velocities of later frames are too much work by hand."""


@dataclass(frozen=True, kw_only=True)
class FrameDetails(ResultChoiceDetails):
    """Details of a question about the frame of a link. The number of the frame is that of the link."""

    frame: int


def _choose_frame(chain: Chain, rng: Stream) -> FrameDetails:
    # Frame 1 is avoided, because its motion is the same for too many arms.
    return FrameDetails(frame=rng.integer(min(2, chain.n - 1), min(chain.n - 1, LAST_FRAME)))


def _compute_frame_velocity(stages: StageResults, details: Any, jacobian_stage: str) -> np.ndarray:
    """Return the twist of the frame i in `details`: the Jacobian of joints 1 to i, multiplied by their rates."""
    return apply_matrix(stages.keep_first_joints(details.frame)[jacobian_stage], stages["joint rates"][: details.frame])


def _list_joint_numbers(chain: Chain) -> range:
    return range(1, chain.n + 1)


def _list_row_indices(chain: Chain) -> list[int]:
    """Return the order in which questions ask for the six rows, as indices of rows with the linear rows first."""
    return [VELOCITY_NAMES.index(row) for row in convention_of(chain).velocity_names]


# --- velocities in the coordinates of each frame ---


@dataclass(frozen=True)
class RecursionStep:
    """One step of the recursion: the number of a frame, and the kind of the joint that moves the frame.

    `rotation` is R = R_{i-1,i}^T, and `origin` is P_i. `omega` and `v` are the velocities of the frame, in the
    coordinates of the frame.
    """

    number: int
    kind: str
    rotation: sp.Matrix
    origin: sp.Matrix
    omega: sp.Matrix
    v: sp.Matrix


@dataclass(frozen=True, kw_only=True)
class RecursionDetails(Details):
    """Details of a question about the velocity of a frame: the frame's number, and the steps of the recursion."""

    frame: int
    steps: tuple[RecursionStep, ...]


@lru_cache(maxsize=1024)
def _derive_steps(symbolic_chain: Chain) -> tuple[RecursionStep, ...]:
    """Return the steps of the recursion for all frames of a symbolic arm."""
    omega = v = sp.zeros(3, 1)
    steps = []
    convention = convention_of(symbolic_chain)
    for number, (row, rate) in enumerate(zip(convention.rows, symbolic_chain.rates, strict=True), 1):
        rotation, origin = convention.make_rotation(row).T, convention.make_link_vector(row)
        v = _collect_rates(rotation * (v + omega.cross(origin)), symbolic_chain)
        omega = _collect_rates(rotation * omega, symbolic_chain)
        v, omega = (v, omega + rate * Z) if row.is_revolute else (v + rate * Z, omega)
        steps.append(RecursionStep(number, row.kind, rotation, origin, omega, v))
    return tuple(steps)


def _collect_rates(vector: sp.Matrix, symbolic_chain: Chain) -> sp.Matrix:
    """Return a vector whose entries are sums over the joint rates, with coefficients in textbook form."""

    def collect(entry: sp.Expr) -> sp.Expr:
        coefficients = ((sp.expand(entry).coeff(rate), rate) for rate in symbolic_chain.rates)
        return sp.Add(*(to_textbook_form(coefficient) * rate for coefficient, rate in coefficients if coefficient != 0))

    return vector.applyfunc(collect)


def _choose_frame_of_recursion(chain: Chain, rng: Stream) -> RecursionDetails:
    frame, substitute = rng.choice(_list_suitable_frames(chain)), derive(chain).substitute_matrix
    steps = (
        RecursionStep(step.number, step.kind, *map(substitute, (step.rotation, step.origin, step.omega, step.v)))
        for step in _derive_steps(make_symbolic_arm(chain).chain)[:frame]
    )
    return RecursionDetails(frame=frame, steps=tuple(steps))


def _list_suitable_frames(chain: Chain) -> list[int]:
    """Return the frames whose velocity depends on more than one joint and can be worked out by hand."""
    return [frame for frame in range(2, min(chain.n, LAST_FRAME) + 1) if _count_terms(chain, frame) <= base.MAX_TERMS]


@lru_cache(maxsize=4096)
def _count_terms(chain: Chain, frame: int) -> int:
    step = _derive_steps(make_symbolic_arm(chain).chain)[frame - 1]
    return count_terms(derive(chain).substitute_matrix(step.v.col_join(step.omega)))


QUESTIONS = (
    Question(
        "joint-axes", "Joint axes", "below 6.10", compute=lambda stages, _: stages["axes"][: stages.n].swapaxes(0, 1),
        substitution=base.make_column_substitution("axes"),
        name_columns=lambda chain: tuple(map(convention_of(chain).name_typed_axis, _list_joint_numbers(chain))),
        label_rows_and_columns=lambda chain: (
            AXIS_NAMES, list(map(convention_of(chain).name_axis, _list_joint_numbers(chain)))
        ),
        find_size_objection=base.limit_terms("z"),
    ),
    Question(
        "position-vectors", "Position vectors p*", "6.13", points=2.0, required_feature=FRAMES,
        compute=lambda stages, _: stages["vectors to point"][: stages.n].swapaxes(0, 1),
        substitution=base.make_column_substitution("vectors to point"),
        label_rows_and_columns=lambda chain: (
            AXIS_NAMES, list(map(convention_of(chain).name_vector, _list_joint_numbers(chain)))
        ),
        find_arm_objection=base.find_tool_point_objection, find_size_objection=base.limit_terms("p_star"),
    ),
    Question(
        "geometric-jacobian", "Geometric Jacobian by propagation", "6.12", points=2.0,
        prerequisites=("joint-axes", "position-vectors"), stage="geometric jacobian", row_order=_list_row_indices,
        label_rows_and_columns=base.label_jacobian(lambda chain: convention_of(chain).velocity_names),
        find_size_objection=base.limit_terms("geometric_jacobian"), link_sums="columns of links",
        find_link_sum_rows=lambda chain: [(row, axis) for row, axis in enumerate(_list_row_indices(chain)) if axis < 3],
    ),
    Question(
        "twist", "Twist of the end effector", "6.9 and 6.10", prerequisites=("geometric-jacobian",),
        compute=base.make_rate_product_formula("geometric jacobian", _list_row_indices),
        find_size_objection=base.limit_terms("geometric_jacobian"),
        name_entries=lambda chain, _: base.name_velocity_components(convention_of(chain).velocity_names),
    ),
    Question(
        "link-velocity", "Velocity of a link frame", "6.9 and 6.10", required_feature=FRAMES,
        compute=partial(_compute_frame_velocity, jacobian_stage="geometric jacobian"), make_details=_choose_frame,
        name_entries=lambda chain, _: base.name_velocity_components(VELOCITY_NAMES),
        find_arm_objection=lambda chain: None if chain.n > 1 else (
            "it has only one joint, so there is no frame between base and end"
        ),
    ),
    Question(
        "own-frame-velocity", "Velocity of a frame in its own coordinates", "6.9 and 6.10", points=2.0,
        required_feature=FRAMES_OF_JOINTS, make_details=_choose_frame_of_recursion,
        compute=partial(_compute_frame_velocity, jacobian_stage="tool jacobian"),
        derive_matrix=lambda _, details: details.steps[-1].v.col_join(details.steps[-1].omega),
        name_entries=lambda chain, _: base.name_velocity_components(VELOCITY_NAMES),
        find_arm_objection=lambda chain: None if chain.n > 1 else "it has one joint",
        find_size_objection=lambda chain: None if _list_suitable_frames(chain) else (
            "the velocities of its frames are too long to work out by hand"
        ),
    ),
)  # fmt: skip
