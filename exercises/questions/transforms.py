"""The full transform of the last frame (Example 6.1), and the Jacobian in the tool frame."""

from functools import lru_cache

import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive, structure
from exercises.arm.kinematics import Z, frame_behind, frames_and_point
from exercises.arm.trigonometry import textbook
from exercises.problem import Matrix
from exercises.questions.base import MOST_TERMS, Asked, Question
from exercises.stream import Stream


@lru_cache(maxsize=1024)
def _last_pose(generic: Chain) -> sp.Matrix:
    """Return T_{w,n} of a structure, 4 x 4, with absolute angles in runs of parallel joints."""
    frame = frames_and_point(generic)[0][-1]
    pose = frame.rotation.row_join(frame.origin).applyfunc(textbook)
    return pose.col_join(sp.Matrix([[0, 0, 0, 1]]))


@lru_cache(maxsize=1024)
def _in_tool_frame(generic: Chain) -> sp.Matrix:
    """Return the 6 x n Jacobian of a structure in the coordinates of its last frame, in which P is fixed."""
    columns = []
    for i, joint in enumerate(generic.joints):
        rest = frame_behind(generic.joints[i:])  # frame n seen from frame i
        z = rest.rotation.T * Z
        arm = rest.rotation.T * rest.origin + sp.Matrix(generic.point.offset)
        linear, angular = (z.cross(arm), z) if joint.kind == "R" else (z, sp.zeros(3, 1))
        columns.append(linear.col_join(angular))
    return sp.Matrix.hstack(*columns).applyfunc(lambda entry: textbook(sp.expand(entry)))


def _transform(chain: Chain, rng: Stream) -> Asked:
    return Matrix(_last_pose(structure(chain).chain).applyfunc(derive(chain).fill)), {}


def _tool_jacobian(chain: Chain, rng: Stream) -> Asked:
    return Matrix(_in_tool_frame(structure(chain).chain).applyfunc(derive(chain).fill)), {}


def _point_on_last_link(chain: Chain) -> str | None:
    return None if chain.point.frame == chain.n else f"its point moves with frame {chain.point.frame}, not the last"


def _counted(matrix: sp.Matrix) -> str | None:
    entries = (sp.expand(entry) for entry in matrix)
    count = sum(len(sp.Add.make_args(entry)) for entry in entries if entry not in (0, 1))
    return f"it has {count} terms, too many to be worked out by hand" if count > MOST_TERMS else None


def _long_pose(chain: Chain) -> str | None:
    return _counted(_last_pose(structure(chain).chain)) if chain.n <= 5 else "it has too many joints for it by hand"


def _long_jacobian(chain: Chain) -> str | None:
    return _counted(_in_tool_frame(structure(chain).chain)) if chain.n <= 5 else "it has too many joints for it by hand"


QUESTIONS = (
    Question("transform", "Transform of the last frame", "Example 6.1", _transform, (), 2.0, too_long=_long_pose),
    Question(
        "tool-jacobian", "Jacobian in the tool frame", "6.12", _tool_jacobian, ("transform", "geometric-jacobian"), 2.0,
        _point_on_last_link, _long_jacobian,
    ),
)  # fmt: skip
