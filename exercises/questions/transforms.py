"""Questions on the transform of the last frame (Example 6.1), and on the Jacobian in the tool frame (6.12)."""

from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from qdot.exercises.arm import transforms
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES, VELOCITY_NAMES
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.problem.problem import Details, recorded_as
from qdot.exercises.questions import base
from qdot.exercises.questions.base import Question

MAX_JOINTS = 5
"""Maximum number of joints whose transforms are multiplied by hand. The result also has at most MAX_TERMS terms."""


@dataclass(frozen=True)
class AngleSum:
    """An entry (row, column), from 1, of T_{w,i} that an angle-sum identity shortens; `number` is i.

    `product` is the entry before the identity is used, and `result` is the entry afterwards.
    """

    number: int
    entry: tuple[int, int]
    product: sp.Expr
    result: sp.Expr


@dataclass(frozen=True)
class ToolColumn:
    """The axis z of joint `number`, its vector p* (m) and z x p*, each 3 x 1, in the coordinates of the last frame."""

    number: int
    kind: str
    z: sp.Matrix
    p_star: sp.Matrix
    cross: sp.Matrix


@dataclass(frozen=True, kw_only=True)
class TransformDetails(Details):
    """Details about T_{w,n}: the transforms T_{w,0} ... T_{w,n}, and the first entry with a sum of angles, if any."""

    poses: tuple[sp.Matrix, ...]
    angle_sum: AngleSum | None = field(metadata=recorded_as("sum"))


@dataclass(frozen=True, kw_only=True)
class ToolJacobianDetails(Details):
    """Details of a question about the Jacobian in the last frame: the vectors in its columns."""

    columns: tuple[ToolColumn, ...]


def find_first_angle_sum(chain: Chain, poses: tuple[sp.Matrix, ...]) -> AngleSum | None:
    """Return the first entry with a sum of angles of parallel joints; None if there is no such entry.

    `poses` are T_{w,0} ... T_{w,n}. Only the columns x_i are searched. An entry of x_i is a row of T_{w,i-1} times the
    first column of T_{i-1,i}.
    """
    convention = convention_of(chain)
    for i, joint in enumerate(convention.rows[1:], 2):
        x = convention.make_rotation(joint)[:, 0]
        for row in range(3):
            product = sp.Add(*(poses[i - 1][row, k] * x[k] for k in range(3)))
            result = poses[i][row, 0]
            if len(sp.Add.make_args(product)) == 2 and not result.is_Add:
                return AngleSum(i, (row + 1, 1), product, result)
    return None


def _list_poses(chain: Chain) -> tuple[sp.Matrix, ...]:
    """Return the transforms T_{w,0} ... T_{w,n} of an arm, with the arm's numbers."""
    return tuple(map(derive(chain).substitute_matrix, transforms.compute_frame_poses(make_symbolic_arm(chain).chain)))


def _make_transform_details(chain: Chain, rng: Stream) -> TransformDetails:
    poses = _list_poses(chain)
    return TransformDetails(poses=poses, angle_sum=find_first_angle_sum(chain, poses))


def _make_tool_details(chain: Chain, rng: Stream) -> ToolJacobianDetails:
    substitute, symbolic_chain = derive(chain).substitute_matrix, make_symbolic_arm(chain).chain
    vectors_of_joints = transforms.compute_joint_vectors(symbolic_chain)
    joints_and_vectors = enumerate(zip(symbolic_chain.joints, vectors_of_joints, strict=True), 1)
    columns = (ToolColumn(i, joint.kind, *map(substitute, vectors)) for i, (joint, vectors) in joints_and_vectors)
    return ToolJacobianDetails(columns=tuple(columns))


def assemble_transform(rotation: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return the transform, (4, 4, …), with a rotation (3, 3, …) and an origin (3, …)."""
    zero = 0 * origin[0]
    last_row = np.stack([zero, zero, zero, zero + 1])
    return np.concatenate([np.concatenate([rotation, origin[:, None]], axis=1), last_row[None]])


QUESTIONS = (
    Question(
        "transform", "Transform of the last frame", "Example 6.1", points=2.0, required_feature=FRAMES,
        compute=lambda stages, _: assemble_transform(stages["last rotation"], stages["last origin"]),
        substitution=lambda rows: {"last rotation": lambda *_: rows[:3, :3]},
        textbook_formulas={
            "last rotation": lambda chain: _list_poses(chain)[-1][:3, :3],
            "last origin": lambda chain: _list_poses(chain)[-1][:3, 3],
        },
        make_details=_make_transform_details, constant_last_row=("0", "0", "0", "1"),
        find_size_objection=base.limit_size(
            "the product of the transforms of {n} joints", MAX_JOINTS,
            lambda chain: transforms.count_last_pose_terms(make_symbolic_arm(chain).chain),
        ),
    ),
    Question(
        "tool-jacobian", "Jacobian in the tool frame", "6.12", points=2.0, required_feature=FRAMES,
        prerequisites=("transform", "geometric-jacobian"), stage="tool jacobian",
        textbook_formulas={
            "tool jacobian": lambda chain: derive(chain).substitute_matrix(
                transforms.compute_tool_jacobian(make_symbolic_arm(chain).chain)
            ),
        },
        make_details=_make_tool_details, label_rows_and_columns=base.label_jacobian(lambda _: VELOCITY_NAMES),
        find_arm_objection=base.find_tool_point_objection,
        find_size_objection=base.limit_size(
            "the Jacobian of {n} joints in the tool frame", MAX_JOINTS,
            lambda chain: transforms.count_tool_jacobian_terms(make_symbolic_arm(chain).chain),
        ),
    ),
)  # fmt: skip
