"""Questions on arms described by their axes: screws, pose by exponentials, Jacobians and twists in {s} and {b}.

The notation is that of Lynch and Park. Twists are computed as (omega, v). Questions ask for the rows in the twist order
of the arm. The home screw of joint i is S_i = (omega_i, -omega_i x q_i) for a revolute joint, (0, v_i) for a prismatic
joint. The space frame {s} is the world frame. The body frame {b} moves with the last link, has its origin at the task
point P, and is parallel to {s} at home. Column i of the space Jacobian J_s is S_i, moved by the joints before joint i.
The body Jacobian describes the same motion in the coordinates of {b}: J_b = [Ad_{T_bs}] J_s. The structure of an arm is
the arm with symbols for all lengths and oblique angles.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes_to_dh import Axis, recognize_exact
from qdot.exercises.arm.chain import REVOLUTE, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import SCREWS
from qdot.exercises.arm.kinematics import compute_frames_and_point
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.arm.trigonometry import count_terms, remove_brackets, to_textbook_matrix
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.problem.problem import Details, recorded_as
from qdot.exercises.questions import base
from qdot.exercises.questions.base import ObjectionFinder, Question
from qdot.exercises.questions.reference import TextbookFormulas
from qdot.exercises.questions.transforms import assemble_transform

SCREWS_SOURCE = "product of exponentials"
"""The `source` of questions on screws, which the chapter does not cover."""
MAX_JOINTS = 4
"""Maximum number of joints for which the exponentials are multiplied by hand."""


@dataclass(frozen=True)
class Screw:
    """The screw of a joint: direction of its axis (3 x 1), a point on the axis (3 x 1, m), and (omega, v) (6 x 1)."""

    number: int
    kind: str
    direction: sp.Matrix
    point: sp.Matrix
    coordinates: sp.Matrix = field(metadata=recorded_as("screw"))

    @property
    def moment(self) -> sp.Matrix:
        """The linear part v of the coordinates (3 x 1)."""
        return self.coordinates[3:, :]


@dataclass(frozen=True, kw_only=True)
class HomeScrewDetails(Details):
    """Details of a question about the home screws."""

    screws: tuple[Screw, ...]


@dataclass(frozen=True, kw_only=True)
class SpaceJacobianDetails(Details):
    """Details of a question about the space Jacobian: the screws, each moved by the joints before it."""

    moved_screws: tuple[Screw, ...] = field(metadata=recorded_as("carried"))


@dataclass(frozen=True, kw_only=True)
class BodyFrameDetails(Details):
    """Details about the body frame: its rotation R_sb, its origin P in {s}, and the space Jacobian if it is needed."""

    rotation: sp.Matrix
    origin: sp.Matrix = field(metadata=recorded_as("place"))
    space_jacobian: sp.Matrix | None = field(default=None, metadata=recorded_as("space"))


# --- screws and exponentials ---


def _join_twist(kind: str, axis: sp.Matrix, velocity: sp.Matrix) -> sp.Matrix:
    """Return the twist (omega, v), 6 x 1, that a joint causes at unit rate; `velocity` is the v of a revolute joint."""
    return axis.col_join(velocity) if kind == REVOLUTE else sp.zeros(3, 1).col_join(axis)


def list_home_screws(chain: Chain) -> tuple[Screw, ...]:
    """Return the home screws of an arm in the world frame."""
    screws = []
    for number, axis in enumerate(compute_home_geometry(chain).axes, 1):
        coordinates = _join_twist(axis.kind, axis.direction, -axis.direction.cross(axis.point))
        screws.append(Screw(number, axis.kind, axis.direction, axis.point, coordinates))
    return tuple(screws)


def make_cross_product_matrix(vector: sp.Matrix) -> sp.Matrix:
    """Return the 3 x 3 matrix [v] with [v] u = v x u."""
    x, y, z = vector
    return sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def compute_exponential(axis: Axis, value: sp.Expr) -> sp.Matrix:
    """Return e^([S] value), 4 x 4, for a joint axis at home: a rotation by Rodrigues' formula, or a translation.

    >>> theta = sp.Symbol("theta1")
    >>> compute_exponential(Axis("R", sp.Matrix([0, 0, 1]), sp.Matrix([2, 0, 0])), theta)[:2, 3]
    Matrix([
    [2 - 2*cos(theta1)],
    [  -2*sin(theta1)]])
    """
    rotation, translation = sp.eye(3), value * axis.direction
    if axis.is_revolute:
        cross = make_cross_product_matrix(axis.direction)
        rotation = (rotation + sp.sin(value) * cross + (1 - sp.cos(value)) * cross**2).applyfunc(sp.expand)
        translation = axis.point - rotation * axis.point
    return make_transform(rotation, translation.applyfunc(sp.expand))


def make_transform(rotation: sp.Matrix, origin: sp.Matrix) -> sp.Matrix:
    """Return the transform (4 x 4) with a rotation matrix and an origin."""
    return rotation.row_join(origin).col_join(sp.Matrix([[0, 0, 0, 1]]))


@lru_cache(maxsize=1024)
def _derive_moved_screws(symbolic_chain: Chain) -> tuple[Screw, ...]:
    """Return the screws of a structure's joints, moved by the joints before them."""
    moved_screws, frames = [], compute_frames_and_point(symbolic_chain).frames
    for number, (joint, frame) in enumerate(zip(symbolic_chain.joints, frames, strict=False), 1):
        z, origin = to_textbook_matrix(frame.rotation[:, 2]), to_textbook_matrix(frame.origin)
        coordinates = _join_twist(joint.kind, z, to_textbook_matrix(-z.cross(origin)))
        moved_screws.append(Screw(number, joint.kind, z, origin, coordinates))
    return tuple(moved_screws)


def list_moved_screws(chain: Chain) -> tuple[Screw, ...]:
    """Return the screws of an arm in the space frame, each moved by the joints before it."""
    home = dict.fromkeys(chain.q, sp.S.Zero)
    symbolic_screws, moved_screws = _derive_moved_screws(make_symbolic_arm(chain).chain), []
    for screw, axis in zip(symbolic_screws, compute_home_geometry(chain).axes, strict=True):
        vectors = (screw.direction, screw.point, screw.coordinates)
        direction, point, coordinates = map(derive(chain).substitute_matrix, vectors)
        if chain.axis_points:  # move each point along its axis to the point that is given in the arm's description
            distance = recognize_exact(axis.direction.dot(axis.point - point.xreplace(home)))
            point = (point + distance * direction).applyfunc(remove_brackets)
        moved_screws.append(Screw(screw.number, screw.kind, direction, point, coordinates))
    return tuple(moved_screws)


def derive_space_jacobian(chain: Chain) -> sp.Matrix:
    """Return J_s, 6 x n, for the twist (omega, v) of the last link in {s}; v is the velocity at the origin of {s}."""
    screws = _derive_moved_screws(make_symbolic_arm(chain).chain)
    return derive(chain).substitute_matrix(sp.Matrix.hstack(*(screw.coordinates for screw in screws)))


# --- the body frame ---


class BodyKinematics(NamedTuple):
    """The rotation R_sb (3 x 3), the body Jacobian J_b (6 x n) for the twist (omega, v) in {b}, and [P] R_sb (3 x 3).

    At home, R_sb is the identity. v is the velocity of P.
    """

    rotation: sp.Matrix
    jacobian: sp.Matrix
    position_cross_rotation: sp.Matrix


def _find_home_offsets(chain: Chain) -> dict[sp.Symbol, sp.Expr]:
    """Return the values of the structure's joint variables if the arm is at home, which are the arm's joint offsets.

    A symbol replaces an offset that is neither zero nor a multiple of pi/2.
    """
    home = {}
    for q, offset, joint in zip(chain.q, chain.offsets, chain.joints, strict=True):
        stays_numeric = offset == 0 or (joint.is_revolute and (2 * offset / sp.pi).is_Integer)
        home[q] = offset if stays_numeric else sp.Symbol(f"home_{q.name}")
    return home


@lru_cache(maxsize=1024)
def _derive_structure_kinematics(symbolic_chain: Chain, home: tuple[tuple[sp.Symbol, sp.Expr], ...]) -> BodyKinematics:
    """Return the body kinematics of a structure; `home` has the value of each joint variable at home."""
    frames, point = compute_frames_and_point(symbolic_chain)
    last_rotation, home_rotation = frames[-1].rotation, frames[-1].rotation.xreplace(dict(home))
    rotation = to_textbook_matrix(last_rotation * home_rotation.T)
    columns = []
    for joint, frame in zip(symbolic_chain.joints, frames, strict=False):
        # Simplify in the coordinates of the last frame, then convert to the coordinates of {b}.
        z = home_rotation * to_textbook_matrix(last_rotation.T * frame.rotation[:, 2])
        lever = home_rotation * to_textbook_matrix(last_rotation.T * (point - frame.origin))
        columns.append(_join_twist(joint.kind, z, z.cross(lever)))
    position_cross_rotation = to_textbook_matrix(make_cross_product_matrix(point) * rotation)
    return BodyKinematics(rotation, to_textbook_matrix(sp.Matrix.hstack(*columns)), position_cross_rotation)


def _has_oblique_angles(chain: Chain) -> bool:
    """Return whether the arm has oblique angles, so that it can't use the results for its structure.

    Oblique angles are link twists that are symbols in the structure, and joint offsets that are not rational multiples
    of pi. With a symbol for each of them, short results would become thousands of terms.
    """
    has_oblique_twist = any(joint.alpha.free_symbols for joint in make_symbolic_arm(chain).chain.joints[:-1])
    revolute_offsets = [offset for offset, joint in zip(chain.offsets, chain.joints, strict=True) if joint.is_revolute]
    return has_oblique_twist or any(not (offset / sp.pi).is_Rational for offset in revolute_offsets)


def _rotate_back(axis: Axis, angle: sp.Expr, vectors: sp.Matrix) -> sp.Matrix:
    """Return vectors, 3 x k, rotated by the negative angle about an axis direction, with products expanded."""
    cross = make_cross_product_matrix(axis.direction)
    rotation = sp.eye(3) - sp.sin(angle) * cross + (1 - sp.cos(angle)) * cross**2
    return (rotation.applyfunc(sp.expand) * vectors).applyfunc(sp.expand)


def _derive_body_column(chain: Chain, index: int) -> sp.Matrix:
    """Return the column of a joint (from 0) in J_b, 6 x 1: its home screw about P, moved back by the joints after it.

    A later revolute joint only rotates omega and the velocity of points on its axis, so each product contains the sine
    or cosine of a joint at most once.
    """
    axes, home_point = compute_home_geometry(chain)
    joint_axis = axes[index]
    omega, v = joint_axis.direction, joint_axis.direction.cross(home_point - joint_axis.point)
    if joint_axis.is_prismatic:
        omega, v = sp.zeros(3, 1), joint_axis.direction
    for axis, q in zip(axes[index + 1 :], chain.q[index + 1 :], strict=True):
        if axis.is_prismatic:
            v = (v + omega.cross(q * axis.direction)).applyfunc(sp.expand)
            continue
        lever = axis.point - home_point
        rotated_vectors = _rotate_back(axis, q, omega.row_join(v + omega.cross(lever)))
        omega = rotated_vectors[:, 0]
        v = (rotated_vectors[:, 1] - omega.cross(lever)).applyfunc(sp.expand)
    return omega.col_join(v)


@lru_cache(maxsize=256)
def _derive_oblique_kinematics(chain: Chain) -> BodyKinematics:
    """Return the body kinematics of an arm with oblique angles, by exponentials of its axes."""
    inverse_rotation = sp.eye(3)
    for axis, q in zip(compute_home_geometry(chain).axes, chain.q, strict=True):
        if axis.is_revolute:
            inverse_rotation = _rotate_back(axis, q, inverse_rotation)
    jacobian = sp.Matrix.hstack(*(_derive_body_column(chain, index) for index in range(chain.n)))
    rotation = inverse_rotation.T.applyfunc(remove_brackets)
    position_cross_rotation = (make_cross_product_matrix(derive(chain).position) * rotation).applyfunc(sp.expand)
    return BodyKinematics(rotation, jacobian.applyfunc(remove_brackets), position_cross_rotation)


def _derive_body_kinematics(chain: Chain) -> BodyKinematics:
    """Return the body kinematics of an arm, if possible from those of the arm's structure."""
    if _has_oblique_angles(chain):
        return _derive_oblique_kinematics(chain)
    home = _find_home_offsets(chain)
    home_values = {home[q]: offset for q, offset in zip(chain.q, chain.offsets, strict=True) if home[q].is_Symbol}
    substitute = derive(chain).substitute_values

    def substitute_entry(entry: sp.Expr) -> sp.Expr:
        return remove_brackets(substitute(entry).xreplace(home_values))

    matrices = _derive_structure_kinematics(make_symbolic_arm(chain).chain, tuple(home.items()))
    return BodyKinematics(*(matrix.applyfunc(substitute_entry) for matrix in matrices))


def derive_body_rotation(chain: Chain) -> sp.Matrix:
    """Return R_sb, 3 x 3, which is the identity at home."""
    return _derive_body_kinematics(chain).rotation


def derive_body_jacobian(chain: Chain) -> sp.Matrix:
    """Return J_b, 6 x n, for the twist (omega, v) of the last link in {b}; v is the velocity of P."""
    return _derive_body_kinematics(chain).jacobian


def derive_body_pose(chain: Chain) -> sp.Matrix:
    """Return the pose T_sb of the body frame, 4 x 4."""
    return make_transform(derive_body_rotation(chain), derive(chain).position)


def derive_body_adjoint(chain: Chain) -> sp.Matrix:
    """Return [Ad T_sb], 6 x 6, which maps a twist (omega, v) in {b} to the same twist in {s}."""
    rotation, _, position_cross_rotation = _derive_body_kinematics(chain)
    return rotation.row_join(sp.zeros(3)).col_join(position_cross_rotation.row_join(rotation))


# --- questions ---


def _make_body_details(chain: Chain, rng: Stream) -> BodyFrameDetails:
    return BodyFrameDetails(rotation=derive_body_rotation(chain), origin=derive(chain).position)


def _make_body_and_space_details(chain: Chain, rng: Stream) -> BodyFrameDetails:
    return replace(_make_body_details(chain, rng), space_jacobian=derive_space_jacobian(chain))


def _make_space_details(chain: Chain, rng: Stream) -> SpaceJacobianDetails:
    return SpaceJacobianDetails(moved_screws=list_moved_screws(chain))


def _get_twist_row_order(chain: Chain) -> Sequence[int]:
    return convention_of(chain).twist_row_order


def _order_adjoint(chain: Chain, adjoint: np.ndarray) -> np.ndarray:
    """Return an adjoint, (6, 6, …), with rows and columns reordered from (omega, v) to the arm's order, or back."""
    return np.asarray(adjoint[_get_twist_row_order(chain)][:, _get_twist_row_order(chain)])


def _find_body_objection(chain: Chain) -> str | None:
    moves_with_last_link = chain.point.frame == chain.n
    return None if moves_with_last_link else "its point P is not fixed to the last link, unlike the body frame"


@lru_cache(maxsize=4096)
def _count_terms(chain: Chain, derive_result: Callable[[Chain], sp.Matrix]) -> int:
    return count_terms(derive_result(chain), ignored_values=(0, 1))


def _limit_size(description: str, derive_result: Callable[[Chain], sp.Matrix]) -> ObjectionFinder:
    return base.limit_size(description, MAX_JOINTS, lambda chain: _count_terms(chain, derive_result))


_find_pose_size_objection = _limit_size("the product of the exponentials of {n} joints", derive_body_pose)
_find_body_jacobian_size_objection = _limit_size("the body Jacobian of {n} joints", derive_body_jacobian)


def _find_space_size_objection(chain: Chain) -> str | None:
    return base.find_term_count_objection(_count_terms(chain, derive_space_jacobian))


def _name_twist(chain: Chain, _: Details) -> Sequence[str]:
    return base.name_velocity_components(_list_row_names(chain))


def _list_row_names(chain: Chain) -> Sequence[str]:
    return convention_of(chain).velocity_names


_SCREW_FORMULAS: TextbookFormulas = {
    "home screws": lambda chain: sp.Matrix.hstack(*(screw.coordinates for screw in list_home_screws(chain))),
    "space jacobian": derive_space_jacobian,
    "body rotation": derive_body_rotation,
    "body jacobian": derive_body_jacobian,
    "body adjoint": derive_body_adjoint,
}

_make_screw_question = partial(
    Question, source=SCREWS_SOURCE, required_feature=SCREWS, textbook_formulas=_SCREW_FORMULAS
)
_make_body_question = partial(_make_screw_question, find_arm_objection=_find_body_objection)

QUESTIONS = (
    _make_screw_question(
        "home-screws", "Screw axes at home", stage="home screws", row_order=_get_twist_row_order,
        make_details=lambda chain, _: HomeScrewDetails(screws=list_home_screws(chain)),
        label_rows_and_columns=lambda chain: (_list_row_names(chain), [f"S_{{{i}}}" for i in range(1, chain.n + 1)]),
    ),
    _make_body_question(
        "body-pose", "Pose of the body frame by exponentials", points=2.0,
        compute=lambda stages, _: assemble_transform(stages["body rotation"], stages["point"]),
        substitution=lambda rows: {"body rotation": lambda *_: rows[:3, :3], "point": lambda *_: rows[:3, 3]},
        make_details=_make_body_details, find_size_objection=_find_pose_size_objection,
        constant_last_row=("0", "0", "0", "1"),
    ),
    _make_body_question(
        "body-adjoint", "Adjoint of the body frame", points=2.0, prerequisites=("body-pose",),
        compute=lambda stages, _: _order_adjoint(stages.chain, stages["body adjoint"]),
        substitution=lambda rows: {"body adjoint": lambda stages, _: _order_adjoint(stages.chain, rows)},
        make_details=_make_body_details,
        label_rows_and_columns=lambda chain: (_list_row_names(chain), _list_row_names(chain)),
        find_size_objection=_limit_size("the adjoint of the pose of {n} joints", derive_body_adjoint),
    ),
    _make_screw_question(
        "space-jacobian", "Space Jacobian", points=2.0, stage="space jacobian", row_order=_get_twist_row_order,
        make_details=_make_space_details, find_size_objection=_find_space_size_objection,
        label_rows_and_columns=base.label_jacobian(_list_row_names),
    ),
    _make_body_question(
        "body-jacobian", "Body Jacobian", points=2.0, prerequisites=("body-pose", "space-jacobian"),
        stage="body jacobian", row_order=_get_twist_row_order, make_details=_make_body_and_space_details,
        label_rows_and_columns=base.label_jacobian(_list_row_names),
        find_size_objection=_find_body_jacobian_size_objection,
    ),
    _make_screw_question(
        "space-twist", "Twist in the space frame", prerequisites=("space-jacobian",),
        compute=base.make_rate_product_formula("space jacobian", _get_twist_row_order),
        make_details=_make_space_details, name_entries=_name_twist, find_size_objection=_find_space_size_objection,
    ),
    _make_body_question(
        "body-twist", "Twist in the body frame", prerequisites=("body-jacobian",),
        compute=base.make_rate_product_formula("body jacobian", _get_twist_row_order),
        make_details=_make_body_and_space_details, name_entries=_name_twist,
        find_size_objection=_find_body_jacobian_size_objection,
    ),
)  # fmt: skip
