"""The full transform of the last frame (Example 6.1), and the Jacobian in the tool frame."""

from dataclasses import dataclass

import numpy as np
import sympy as sp

from qdot.exercises.answers import Matrix
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import Change, Working
from qdot.exercises.arm.transforms import in_tool_frame, poses, seen_from_tool, terms_in_tool_frame, terms_of_last_pose
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, Part
from qdot.exercises.questions.base import Asked, Question, objection_to_terms, rates_to, stage

MOST_JOINTS = 5
"""Up to so many joints transforms are multiplied out by hand; of those, up to MOST_TERMS terms."""


@dataclass(frozen=True)
class AngleSum:
    """An entry of T_{w,i} as the product of row and column gives it, and with the angles of parallel joints added."""

    number: int
    entry: tuple[int, int]
    product: sp.Expr
    result: sp.Expr


@dataclass(frozen=True)
class ToolColumn:
    """The axis of joint `number`, its vector p* (m) and z x p*, each 3 x 1, in the coordinates of the last frame."""

    number: int
    kind: str
    z: sp.Matrix
    p_star: sp.Matrix
    cross: sp.Matrix


@dataclass(frozen=True, kw_only=True)
class ByTransforms(Details):
    """About T_{w,n}: the transforms T_{w,0} ... T_{w,n} that lead to it, and where angles first add up in them."""

    poses: tuple[sp.Matrix, ...]
    sum: AngleSum | None


@dataclass(frozen=True, kw_only=True)
class InToolFrame(Details):
    """About the Jacobian in the last frame: what its columns are made of."""

    columns: tuple[ToolColumn, ...]


def first_angle_sum(chain: Chain, poses: tuple[sp.Matrix, ...]) -> AngleSum | None:
    """Return the first entry in which angles of parallel joints add up; `poses` are T_{w,0} ... T_{w,n}.

    It is looked for in the columns x_i: a row of T_{w,i-1} times the first column of T_{i-1,i}.
    """
    convention = convention_of(chain)
    for i, joint in enumerate(convention.rows[1:], 2):
        x = convention.rotation(joint)[:, 0]
        for row in range(3):
            product = sp.Add(*(poses[i - 1][row, k] * x[k] for k in range(3)))
            result = poses[i][row, 0]
            if len(sp.Add.make_args(product)) == 2 and not result.is_Add:
                return AngleSum(i, (row + 1, 1), product, result)
    return None


def _ask_transform(chain: Chain, rng: Stream) -> Asked:
    d = derive(chain)
    arm_poses = tuple(pose.applyfunc(d.fill) for pose in poses(structure(chain).chain))
    return Matrix(arm_poses[-1]), ByTransforms(poses=arm_poses, sum=first_angle_sum(chain, arm_poses))


def _ask_tool_jacobian(chain: Chain, rng: Stream) -> Asked:
    d, generic = derive(chain), structure(chain).chain
    columns = tuple(
        ToolColumn(number, joint.kind, *(vector.applyfunc(d.fill) for vector in seen))
        for number, (joint, seen) in enumerate(zip(generic.joints, seen_from_tool(generic), strict=True), 1)
    )
    return Matrix(in_tool_frame(generic).applyfunc(d.fill)), InToolFrame(columns=columns)


def _object_to_point(chain: Chain) -> str | None:
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


def _object_to_pose(chain: Chain) -> str | None:
    if chain.n > MOST_JOINTS:
        return f"the product of the transforms of {chain.n} joints is too long to be worked out by hand"
    return objection_to_terms(terms_of_last_pose(structure(chain).chain))


def _object_to_jacobian(chain: Chain) -> str | None:
    if chain.n > MOST_JOINTS:
        return f"the Jacobian of {chain.n} joints in the tool frame is too long to be worked out by hand"
    return objection_to_terms(terms_in_tool_frame(structure(chain).chain))


# --- out of a derivation ---


def _derived_transform(w: Working, part: Part) -> np.ndarray:
    rotation, origin = w["last rotation"], w["last origin"]
    below = np.stack([0 * origin[0], 0 * origin[0], 0 * origin[0], 0 * origin[0] + 1])
    return np.concatenate([np.concatenate([rotation, origin[:, None]], axis=1), below[None]])


def _substitute_transform(rows: np.ndarray) -> dict[str, Change]:
    return {"last rotation": lambda _, right: rows[:3, :3]}


QUESTIONS = (
    Question(
        name="transform",
        speaks_of=FRAMES,
        title="Transform of the last frame",
        source="Example 6.1",
        ask=_ask_transform,
        points=2.0,
        too_long=_object_to_pose,
        result=_derived_transform,
        substitutes=_substitute_transform,
        last_row=("0", "0", "0", "1"),
    ),
    Question(
        name="tool-jacobian",
        speaks_of=FRAMES,
        title="Jacobian in the tool frame",
        source="6.12",
        ask=_ask_tool_jacobian,
        needs=("transform", "geometric-jacobian"),
        points=2.0,
        objection=_object_to_point,
        too_long=_object_to_jacobian,
        result=stage("tool jacobian"),
        grid=rates_to(lambda _: TASK_ROWS),
        follows=(("transform", "geometric-jacobian"),),
    ),
)  # fmt: skip
