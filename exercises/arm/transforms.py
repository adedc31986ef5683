"""Compute the poses of all frames of a symbolic arm, and its Jacobian in the coordinates of the last frame.

A symbolic arm (`derivation`) has symbols for all lengths. The point of interest is fixed in the last frame. The frames
are the frames of the arm's convention. The angles of consecutive parallel joints are added.
"""

from functools import lru_cache

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import Z, compute_frame_after, compute_link_frames
from qdot.exercises.arm.trigonometry import count_terms, to_textbook_form, to_textbook_matrix


@lru_cache(maxsize=4096)
def compute_frame_poses(arm: Chain) -> tuple[sp.Matrix, ...]:
    """Return the poses T_{w,0} ... T_{w,n} of a symbolic arm's frames in the world, 4 x 4."""
    poses = (frame.rotation.row_join(frame.origin).applyfunc(to_textbook_form) for frame in compute_link_frames(arm))
    return tuple(pose.col_join(sp.Matrix([[0, 0, 0, 1]])) for pose in poses)


@lru_cache(maxsize=4096)
def compute_joint_vectors(arm: Chain) -> tuple[tuple[sp.Matrix, sp.Matrix, sp.Matrix], ...]:
    """Return for each joint the axis z, the vector p* (m) and z x p*, each 3 x 1, in the last frame."""
    convention, vectors = convention_of(arm), []
    joints = convention.keep_first_joints(arm.n).joints
    for i, joint in enumerate(joints):
        last_frame = compute_frame_after(joints[i:])  # frame n in the coordinates of the frame before joint i + 1
        z, to_last_origin = to_textbook_matrix(last_frame.rotation.T * Z), last_frame.rotation.T * last_frame.origin
        to_point = to_last_origin - convention.find_distance_along_axis(joint) * z + sp.Matrix(convention.point.offset)
        p_star = to_textbook_matrix(to_point)
        vectors.append((z, p_star, to_textbook_matrix(z.cross(p_star))))
    return tuple(vectors)


@lru_cache(maxsize=4096)
def compute_tool_jacobian(arm: Chain) -> sp.Matrix:
    """Return the 6 x n Jacobian of a symbolic arm in the coordinates of the last frame."""
    columns = (
        cross.col_join(z) if joint.is_revolute else z.col_join(sp.zeros(3, 1))
        for joint, (z, _, cross) in zip(arm.joints, compute_joint_vectors(arm), strict=True)
    )
    return sp.Matrix.hstack(*columns)


@lru_cache(maxsize=4096)
def count_last_pose_terms(arm: Chain) -> int:
    """Return the number of terms of T_{w,n}, multiplied out; ones and zeros don't count."""
    return count_terms(compute_frame_poses(arm)[-1], ignored_values=(0, 1))


@lru_cache(maxsize=4096)
def count_tool_jacobian_terms(arm: Chain) -> int:
    """Return the number of terms of the Jacobian in the last frame, multiplied out; ones and zeros don't count."""
    return count_terms(compute_tool_jacobian(arm), ignored_values=(0, 1))
