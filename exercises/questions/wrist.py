"""Questions on the Jacobian of an arm with six joints and a spherical wrist: det J = det J11 det J22.

If the axes of the last three joints meet in P, these joints do not move P. Columns 4 to 6 of J then have no linear
part, and J is block triangular. J11 (3 x 3), the arm block, maps the rates of joints 1 to 3 to the velocity of P. J22,
the wrist block, maps the rates of joints 4 to 6 to the angular velocity that the wrist adds. Both are derived once for
the structure of an arm, which is the arm with symbols for all lengths and oblique angles.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES, VELOCITY_NAMES
from qdot.exercises.arm.kinematics import Z, compute_frame_after, compute_frames_and_point
from qdot.exercises.arm.trigonometry import (
    Factored,
    are_identical,
    count_terms,
    factor_trig,
    to_textbook_matrix,
    wrap_angle,
)
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import determinant
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.problem.problem import Details, recorded_as
from qdot.exercises.questions import base
from qdot.exercises.questions.base import Question
from qdot.exercises.singularities.appearance import find_wrist_centre


@lru_cache(maxsize=1024)
def _derive_wrist_axes(symbolic_chain: Chain) -> sp.Matrix:
    """Return the axes of joints 4 to 6 of a structure in the coordinates of the frame on axis 4 (3 x 3)."""
    axes = [compute_frame_after(symbolic_chain.joints[3:i]).rotation * Z for i in (3, 4, 5)]
    frame = convention_of(symbolic_chain).find_frame_on_axis(4)
    for joint in symbolic_chain.joints[3:frame]:  # joint 4 if the frame on its axis rotates with it, else no joint
        axes = [rot_z(-joint.theta) * axis for axis in axes]
    return to_textbook_matrix(sp.Matrix.hstack(*axes))


@lru_cache(maxsize=1024)
def _derive_arm_block_in_frame_1(symbolic_chain: Chain) -> sp.Matrix:
    """Return R_1^T J11 of a structure (3 x 3): J11 in the coordinates of link 1, with the same determinant."""
    joint_1 = symbolic_chain.joints[0]
    twist, _ = convention_of(symbolic_chain).find_step_to_standard_frame(1)
    point = compute_frame_after(symbolic_chain.joints[1:4]).origin
    z_0 = sp.Matrix([0, sp.sin(joint_1.alpha), sp.cos(joint_1.alpha)])  # in frame 1, like r_1
    r_1 = sp.Matrix([joint_1.a, *(joint_1.d * z_0[1:, :])])
    frames = (compute_frame_after(symbolic_chain.joints[1:i]) for i in (1, 2))
    axes_and_levers = [(z_0, r_1 + point), *((frame.rotation * Z, point - frame.origin) for frame in frames)]
    joints_and_vectors = zip(symbolic_chain.joints[:3], axes_and_levers, strict=True)
    columns = [z.cross(lever) if joint.is_revolute else z for joint, (z, lever) in joints_and_vectors]
    return to_textbook_matrix(rot_x(twist) * sp.Matrix.hstack(*columns))


@lru_cache(maxsize=1024)
def _factor_determinants(symbolic_chain: Chain) -> tuple[Factored, Factored]:
    """Return det J11 and det J22 of a structure in factored form."""
    determinants = _derive_arm_block(symbolic_chain).det(method="berkowitz"), _derive_wrist_axes(symbolic_chain).det()
    arm_determinant, wrist_determinant = (factor_trig(sp.expand(value)) for value in determinants)
    return arm_determinant, wrist_determinant


def _derive_arm_block(chain: Chain) -> sp.Matrix:
    """Return J11, the linear rows of joints 1 to 3, in the world frame (3 x 3)."""
    return derive(chain).geometric_jacobian[:3, :3]


def derive_wrist_block(chain: Chain) -> sp.Matrix:
    """Return J22, the axes of joints 4 to 6, in the frame on the axis of joint 4 (3 x 3)."""
    return derive(chain).substitute_matrix(_derive_wrist_axes(make_symbolic_arm(chain).chain))


def derive_block_determinants(chain: Chain) -> sp.Matrix:
    """Return [det J11, det J22] in factored form (2 x 1)."""
    values = dict(make_symbolic_arm(chain).values)
    factored_determinants = _factor_determinants(make_symbolic_arm(chain).chain)
    return sp.Matrix([product.substitute(values) for product in factored_determinants])


@dataclass(frozen=True, kw_only=True)
class BlockDetails(Details):
    """Details of a question about the determinants of the blocks: the steps of their derivation, and their zeros.

    - `arm_block_in_frame_1` is R_1^T J11.
    - `expanded_wrist_determinant` is det J22, expanded along the first column of J22, (0, 0, 1), and not simplified.
    - `arm_factors` are the factors of det J11 that depend on joints.
    - `wrist_zeros` are the values of theta5 at which det J22 is zero.
    - `has_collinear_axes` says whether axes 4 and 6 are collinear at these values, as for the usual twists of 90
      degrees. Otherwise the three axes of the wrist are coplanar.
    """

    arm_block: sp.Matrix = field(metadata=recorded_as("blocks.arm"))
    arm_block_in_frame_1: sp.Matrix = field(metadata=recorded_as("blocks.arm_seen"))
    wrist_block: sp.Matrix = field(metadata=recorded_as("blocks.wrist"))
    expanded_wrist_determinant: sp.Expr = field(metadata=recorded_as("blocks.expanded"))
    arm_factors: tuple[sp.Expr, ...] = field(metadata=recorded_as("blocks.arm_zeros"))
    wrist_zeros: tuple[sp.Expr, sp.Expr] = field(metadata=recorded_as("blocks.straight"))
    has_collinear_axes: bool = field(metadata=recorded_as("blocks.in_line"))


@dataclass(frozen=True, kw_only=True)
class WristAxisDetails(Details):
    """Details about J22: the rotations between the frames on the wrist's axes, and the directions of axes 5 and 6.

    `z_4` and `z_5` are axes 5 and 6 in the frame on axis 4, with their names in a standard table.
    """

    rotations: tuple[sp.Matrix, ...]
    axis_6_in_frame_on_axis_5: sp.Matrix = field(metadata=recorded_as("inner"))
    z_4: sp.Matrix
    z_5: sp.Matrix


def derive_blocks(chain: Chain) -> BlockDetails:
    """Return the blocks of an arm with a spherical wrist, and the steps to their determinants."""
    derivation, symbolic_chain = derive(chain), make_symbolic_arm(chain).chain
    wrist_block = derive_wrist_block(chain)
    arm_determinant, _ = _factor_determinants(symbolic_chain)
    factors = (derivation.substitute_values(factor) for factor, _ in arm_determinant.factors)
    joint_factors = (factor for factor in factors if factor.free_symbols & set(chain.q))
    return BlockDetails(
        arm_block=_derive_arm_block(chain),
        arm_block_in_frame_1=derivation.substitute_matrix(_derive_arm_block_in_frame_1(symbolic_chain)),
        wrist_block=wrist_block,
        expanded_wrist_determinant=wrist_block[0, 1] * wrist_block[1, 2] - wrist_block[1, 1] * wrist_block[0, 2],
        arm_factors=tuple(-factor if factor.could_extract_minus_sign() else factor for factor in joint_factors),
        wrist_zeros=(wrap_angle(-chain.offsets[4]), wrap_angle(sp.pi - chain.offsets[4])),
        has_collinear_axes=all((2 * joint.alpha / sp.pi).is_Integer for joint in chain.joints[3:5]),
    )


def _make_wrist_details(chain: Chain, rng: Stream) -> WristAxisDetails:
    convention, block = convention_of(chain), derive_wrist_block(chain)
    first_frame = convention.find_frame_on_axis(4)
    rotations = tuple(convention.make_rotation(row) for row in convention.rows[first_frame : first_frame + 2])
    return WristAxisDetails(
        rotations=rotations, axis_6_in_frame_on_axis_5=rotations[1][:, 2], z_4=block[:, 1], z_5=block[:, 2]
    )


@lru_cache(maxsize=1024)
def _is_at_wrist_centre(symbolic_chain: Chain, centre: int) -> bool:
    """Return whether P is the point in which the last three axes meet, the origin of frame `centre`."""
    if symbolic_chain.point.frame < centre:
        return False
    frames, point = compute_frames_and_point(symbolic_chain)
    return all(are_identical(a, b) for a, b in zip(point, frames[centre].origin, strict=True))


def find_block_objection(chain: Chain) -> str | None:
    """Return why the Jacobian of an arm is not block triangular, or why its determinant is zero, or None."""
    if chain.n != 6 or chain.task != VELOCITY_NAMES:
        return "it does not have six joints and a task of six rows"
    centre = find_wrist_centre(chain)
    if centre is None or not _is_at_wrist_centre(make_symbolic_arm(chain).chain, centre):
        return "the axes of its last three joints do not intersect at its point"
    return base.find_determinant_objection(chain)


def _find_arm_block_size_objection(chain: Chain) -> str | None:
    count = count_terms(_derive_arm_block(make_symbolic_arm(chain).chain))
    return f"its arm block has {count} terms, too many to work out by hand" if count > base.MAX_TERMS else None


QUESTIONS = (
    Question(
        "arm-block", "Arm block of the Jacobian", "6.12", points=2.0, required_feature=FRAMES,
        stage="arm block", label_rows_and_columns=lambda chain: (VELOCITY_NAMES[:3], base.name_joint_rates(chain)[:3]),
        find_arm_objection=find_block_objection, find_size_objection=_find_arm_block_size_objection,
        link_sums="columns of links", find_link_sum_rows=lambda _: [(axis, axis) for axis in range(3)],
    ),
    Question(
        "wrist-block", "Wrist block of the Jacobian", "6.12", required_feature=FRAMES, stage="wrist block",
        textbook_formulas={"wrist block": derive_wrist_block}, make_details=_make_wrist_details,
        label_rows_and_columns=lambda chain: (VELOCITY_NAMES[3:], base.name_joint_rates(chain)[3:]),
        find_arm_objection=find_block_objection,
    ),
    Question(
        "block-determinants", "Determinants of the blocks", "6.8", points=2.0, required_feature=FRAMES,
        prerequisites=("arm-block", "wrist-block"),
        compute=lambda stages, _: np.stack([determinant(stages["arm block"]), determinant(stages["wrist block"])]),
        derive_matrix=lambda chain, _: derive_block_determinants(chain),
        make_details=lambda chain, _: derive_blocks(chain),
        name_entries=lambda chain, _: [r"\det J_{11}", r"\det J_{22}"], find_arm_objection=find_block_objection,
        find_size_objection=_find_arm_block_size_objection, is_made_of_jacobian=True, is_made_of_minors=True,
    ),
)  # fmt: skip
