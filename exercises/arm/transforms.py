"""The poses of all frames of a structure, and its Jacobian in the last frame, in which the point of interest is fixed.

The angles of consecutive parallel joints are added. The frames are those of the arm's convention.
"""

from functools import lru_cache

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import Z, frame_after, link_frames
from qdot.exercises.arm.trigonometry import count_terms, textbook_form, textbook_matrix


@lru_cache(maxsize=4096)
def frame_poses(structure: Chain) -> tuple[sp.Matrix, ...]:
    """Return the poses T_{w,0} ... T_{w,n} of the frames in the world, 4 x 4."""
    poses = (frame.rotation.row_join(frame.origin).applyfunc(textbook_form) for frame in link_frames(structure))
    return tuple(pose.col_join(sp.Matrix([[0, 0, 0, 1]])) for pose in poses)


@lru_cache(maxsize=4096)
def joint_vectors_in_tool_frame(structure: Chain) -> tuple[tuple[sp.Matrix, sp.Matrix, sp.Matrix], ...]:
    """Return for each joint the axis z, the vector p* (m) and z x p*, each 3 x 1, in the last frame."""
    return tuple(_joint_in_tool_frame(structure, i) for i in range(structure.n))


def _joint_in_tool_frame(structure: Chain, i: int) -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """Return z, p* and z x p* of one joint (from 0) in the last frame."""
    convention = convention_of(structure)
    joints = convention.first_joints(structure.n).joints
    last_frame = frame_after(joints[i:])  # frame n in the coordinates of the frame at the end of link i
    z, distance_along_z = textbook_matrix(last_frame.rotation.T * Z), convention.distance_along_axis(joints[i])
    to_last_origin = last_frame.rotation.T * last_frame.origin
    p_star = textbook_matrix(to_last_origin - distance_along_z * z + sp.Matrix(convention.point.offset))
    return z, p_star, textbook_matrix(z.cross(p_star))


@lru_cache(maxsize=4096)
def jacobian_in_tool_frame(structure: Chain) -> sp.Matrix:
    """Return the 6 x n Jacobian in the coordinates of the last frame."""
    columns = (
        cross.col_join(z) if joint.kind == "R" else z.col_join(sp.zeros(3, 1))
        for joint, (z, _, cross) in zip(structure.joints, joint_vectors_in_tool_frame(structure), strict=True)
    )
    return sp.Matrix.hstack(*columns)


@lru_cache(maxsize=4096)
def count_last_pose_terms(structure: Chain) -> int:
    """Return the number of terms of T_{w,n}, multiplied out; ones and zeros don't count."""
    return count_terms(frame_poses(structure)[-1], trivial=(0, 1))


@lru_cache(maxsize=4096)
def count_tool_jacobian_terms(structure: Chain) -> int:
    """Return the number of terms of the Jacobian in the last frame, multiplied out; ones and zeros don't count."""
    return count_terms(jacobian_in_tool_frame(structure), trivial=(0, 1))
