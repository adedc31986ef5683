"""Questions on the Jacobian of an arm with six joints and a spherical wrist: det J = det J11 det J22.

If the axes of the last three joints meet in P, these joints do not move P. Columns 4 to 6 of J then have no linear
part, and J is block triangular. J11 (3 x 3) maps the arm's joint rates to the velocity of P. J22 maps the wrist's joint
rates to the angular velocity that the wrist adds.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import determinant
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES
from qdot.exercises.arm.derivation import derive, symbolic_arm_of
from qdot.exercises.arm.kinematics import Z, frame_after, frames_and_point
from qdot.exercises.arm.trigonometry import Factored, are_identical, count_terms, factor_trig, textbook_matrix
from qdot.exercises.arm.vectors import rot_x, rot_z
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import MAX_TERMS, Question, name_joint_rates, object_unless_square
from qdot.exercises.singularities.appearance import find_wrist_centre


@lru_cache(maxsize=1024)
def _write_wrist_axes(generic: Chain) -> sp.Matrix:
    """Return the axes of joints 4 to 6 of a structure in the coordinates of the frame on axis 4 (3 x 3)."""
    axes = [frame_after(generic.joints[3:i]).rotation * Z for i in (3, 4, 5)]
    for joint in generic.joints[3 : convention_of(generic).frame_on_axis(4)]:  # joint 4, if that frame rotates with it
        axes = [rot_z(-joint.theta) * axis for axis in axes]
    return textbook_matrix(sp.Matrix.hstack(*axes))


@lru_cache(maxsize=1024)
def _derive_arm_from_frame_1(generic: Chain) -> sp.Matrix:
    """Return R_1^T J11 of a structure (3 x 3): the arm block in the coordinates of link 1, with equal determinant."""
    first_joint, rotation = generic.joints[0], rot_x(convention_of(generic).step_to_standard_frame(1)[0])
    point = frame_after(generic.joints[1:4]).origin
    z_0 = sp.Matrix([0, sp.sin(first_joint.alpha), sp.cos(first_joint.alpha)])  # in frame 1, like r_1
    r_1 = sp.Matrix([first_joint.a, *(first_joint.d * z_0[1:, :])])
    previous_frames = (frame_after(generic.joints[1:i]) for i in (1, 2))
    axes_and_arms = [(z_0, r_1 + point), *((frame.rotation * Z, point - frame.origin) for frame in previous_frames)]
    joints_and_vectors = zip(generic.joints[:3], axes_and_arms, strict=True)
    columns = [z.cross(arm) if joint.is_revolute else z for joint, (z, arm) in joints_and_vectors]
    return textbook_matrix(rotation * sp.Matrix.hstack(*columns))


@lru_cache(maxsize=1024)
def _factor_determinants(generic: Chain) -> tuple[Factored, Factored]:
    """Return det J11 and det J22 of a structure in factored form."""
    arm = derive(generic).geometric[:3, :3]
    return factor_trig(sp.expand(arm.det(method="berkowitz"))), factor_trig(sp.expand(_write_wrist_axes(generic).det()))


def derive_arm_block(chain: Chain) -> sp.Matrix:
    """Return J11, the linear rows of joints 1 to 3, in the world frame (3 x 3)."""
    return derive(chain).geometric[:3, :3]


def derive_wrist_block(chain: Chain) -> sp.Matrix:
    """Return J22, the axes of joints 4 to 6, in the frame on the axis of joint 4 (3 x 3)."""
    return derive(chain).substitute_matrix(_write_wrist_axes(symbolic_arm_of(chain).chain))


def derive_block_determinants(chain: Chain) -> sp.Matrix:
    """Return [det J11, det J22] in factored form."""
    values = dict(symbolic_arm_of(chain).values)
    return sp.Matrix([factored.substitute(values) for factored in _factor_determinants(symbolic_arm_of(chain).chain)])


@dataclass(frozen=True)
class WristBlocks:
    """The steps to the determinants: the blocks, their expansions, and their zeros.

    `arm_seen` is R_1^T J11, the arm block as seen from frame 1. `expanded` is det J22, expanded along the first column
    of J22 and not simplified. `arm_zeros` are the factors of det J11 that depend on joints. `straight` are the values
    of theta5 at which det J22 is zero. `in_line` says whether axes 4 and 6 are collinear there, as they are for the
    usual twists of 90 degrees. Otherwise the three axes are coplanar.
    """

    arm: sp.Matrix
    arm_seen: sp.Matrix
    wrist: sp.Matrix
    expanded: sp.Expr
    arm_zeros: tuple[sp.Expr, ...]
    straight: tuple[sp.Expr, sp.Expr]
    in_line: bool


@dataclass(frozen=True, kw_only=True)
class BlockDetails(Details):
    """Details of a question about the determinants of the blocks, with the steps to them."""

    blocks: WristBlocks


@dataclass(frozen=True, kw_only=True)
class WristAxisDetails(Details):
    """Details about J22: the rotations between the frames on its three axes, and axes 5 and 6 in the first frame.

    `inner` is axis 6 in the frame on axis 5. `z_4` and `z_5` are axes 5 and 6, named as in a standard table.
    """

    rotations: tuple[sp.Matrix, ...]
    inner: sp.Matrix
    z_4: sp.Matrix
    z_5: sp.Matrix


def derive_blocks(chain: Chain) -> WristBlocks:
    """Return the blocks of an arm with a spherical wrist, and the steps to their determinants."""
    d, generic, wrist = derive(chain), symbolic_arm_of(chain).chain, derive_wrist_block(chain)
    factors = (d.substitute_values(factor) for factor, _ in _factor_determinants(generic)[0].factors)
    return WristBlocks(
        arm=derive_arm_block(chain),
        arm_seen=d.substitute_matrix(_derive_arm_from_frame_1(generic)),
        wrist=wrist,
        expanded=wrist[0, 1] * wrist[1, 2] - wrist[1, 1] * wrist[0, 2],
        arm_zeros=tuple(_drop_sign(factor) for factor in factors if factor.free_symbols & set(chain.q)),
        straight=(_wrap_angle(-chain.offsets[4]), _wrap_angle(sp.pi - chain.offsets[4])),
        in_line=all((2 * joint.alpha / sp.pi).is_Integer for joint in chain.joints[3:5]),
    )


def _drop_sign(factor: sp.Expr) -> sp.Expr:
    return -factor if factor.could_extract_minus_sign() else factor


def _wrap_angle(angle: sp.Expr) -> sp.Expr:
    """Return an angle, wrapped to (-pi, pi] if it is numeric, else unchanged."""
    return sp.pi - sp.Mod(sp.pi - angle, 2 * sp.pi) if angle.is_number else angle


def _describe_wrist(chain: Chain, rng: Stream) -> WristAxisDetails:
    convention = convention_of(chain)
    first_frame = convention.frame_on_axis(4)
    rotations = tuple(convention.rotation(row) for row in convention.rows[first_frame:][:2])
    block = derive_wrist_block(chain)
    return WristAxisDetails(rotations=rotations, inner=rotations[1][:, 2], z_4=block[:, 1], z_5=block[:, 2])


@lru_cache(maxsize=1024)
def _is_at_wrist_centre(generic: Chain, centre: int) -> bool:
    """Return whether P is the point where the last three axes meet: O_4, or O_5 or O_6 if that is the same point."""
    if generic.point.frame < centre:
        return False
    frames, point = frames_and_point(generic)
    return all(are_identical(a, b) for a, b in zip(point, frames[centre].origin, strict=True))


def object_unless_block_triangular(chain: Chain) -> str | None:
    """Return the objection to arms whose Jacobian at P is not block triangular."""
    if chain.n != 6 or chain.task != TASK_ROWS:
        return "it does not have six joints and a task of six rows"
    centre = find_wrist_centre(chain)
    if centre is None or not _is_at_wrist_centre(symbolic_arm_of(chain).chain, centre):
        return "the axes of its last three joints do not intersect at its point"
    return object_unless_square(chain)


def object_to_long_arm_block(chain: Chain) -> str | None:
    """Return the objection to arms whose block J11 is too long to work out by hand."""
    count = count_terms(derive_arm_block(symbolic_arm_of(chain).chain))
    return f"its arm block has {count} terms, too many to work out by hand" if count > MAX_TERMS else None


QUESTIONS = (
    Question(
        "arm-block", "Arm block of the Jacobian", "6.12", points=2.0, required_feature=FRAMES,
        stage="arm block", row_and_column_labels=lambda chain: (TASK_ROWS[:3], name_joint_rates(chain)[:3]),
        objection=object_unless_block_triangular, too_long=object_to_long_arm_block,
        link_sums="columns of links", link_sum_rows=lambda _: [(axis, axis) for axis in range(3)],
    ),
    Question(
        "wrist-block", "Wrist block of the Jacobian", "6.12", required_feature=FRAMES,
        stage="wrist block", textbook_stages={"wrist block": derive_wrist_block}, make_details=_describe_wrist,
        row_and_column_labels=lambda chain: (TASK_ROWS[3:], name_joint_rates(chain)[3:]),
        objection=object_unless_block_triangular,
    ),
    Question(
        "block-determinants", "Determinants of the blocks", "6.8", points=2.0, required_feature=FRAMES,
        needs=("arm-block", "wrist-block"),
        formula=lambda w, _: np.stack([determinant(w["arm block"]), determinant(w["wrist block"])]),
        reference=lambda chain, _: derive_block_determinants(chain),
        make_details=lambda chain, _: BlockDetails(blocks=derive_blocks(chain)),
        entry_names=lambda chain, _: [r"\det J_{11}", r"\det J_{22}"], objection=object_unless_block_triangular,
        too_long=object_to_long_arm_block, is_made_of_jacobian=True, is_made_of_minors=True,
    ),
)  # fmt: skip
