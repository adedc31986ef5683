"""Mistakes with screws and the product of exponentials, for arms described by their axes in the home configuration."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial, reduce

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, cross, matrix_product
from qdot.exercises.arm.axes_to_dh import Axis
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import SCREWS as HAS_SCREWS
from qdot.exercises.arm.derivation_graph import Change, Table, Working, adjoint_matrix, constant_vector, rotate_rows
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.mistakes.base import (
    AnswerShape,
    Mistake,
    MistakeVariant,
    VariantGenerator,
    propagated_variant,
    restrict_to_feature,
    single_variant,
)

SCREW_STAGES = ("home screws", "space jacobian", "body jacobian")
"""The stages of the derivation whose columns are screws."""
SECTION = "the product of exponentials"


def _variants_in_each_stage(change: Change, *stages: str) -> VariantGenerator:
    """Return a function that yields one variant per stage, in which the change is applied to that stage."""
    return lambda chain, _: (MistakeVariant({stage: change}) for stage in stages)


def _flip_linear_parts(w: Working, columns: np.ndarray) -> np.ndarray:
    new_columns = np.array(columns)
    revolute_joints = [i for i, kind in enumerate(w["kinds"]) if kind == "R"]
    new_columns[3:, revolute_joints] = -new_columns[3:, revolute_joints]
    return new_columns


def _replace_linear_parts(linear_part: Callable[[Working, np.ndarray, int, Axis], np.ndarray]) -> Change:
    """Return the change that replaces the linear parts v of the screws of revolute joints."""

    def replace_linear_parts(w: Working, columns: np.ndarray) -> np.ndarray:
        new_columns = np.array(columns)
        for i, axis in enumerate(axes_of(w.chain)[0]):
            if axis.kind == "R":
                new_columns[3:, i] = linear_part(w, columns, i, axis)
        return new_columns

    return replace_linear_parts


def _exchange_halves(w: Working, columns: np.ndarray) -> np.ndarray:
    return np.roll(columns, 3, axis=0)


def _move_slide_to_angular_rows(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def apply_change(w: Working, columns: np.ndarray) -> np.ndarray:
        new_columns, prismatic_joints = np.array(columns), [i for i, kind in enumerate(w["kinds"]) if kind == "P"]
        new_columns[:, prismatic_joints] = np.roll(columns[:, prismatic_joints], 3, axis=0)
        return new_columns

    if {joint.kind for joint in chain.joints} == {"R", "P"}:
        yield from (MistakeVariant({stage: apply_change}) for stage in SCREW_STAGES)


def _use_home_screws(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def move_to_point(w: Working, _: np.ndarray) -> np.ndarray:
        point, home = _home_point(w), w["home screws"]
        linear = [home[3:, i] + cross(home[:3, i], point) for i in range(w.n)]
        return np.concatenate([home[:3], np.stack(linear, axis=1)])

    yield MistakeVariant({"space jacobian": lambda w, _: w["home screws"]})
    yield MistakeVariant({"body jacobian": move_to_point})


def _use_other_frame(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    yield MistakeVariant(
        {"space jacobian": lambda w, _: w.without_changes_of("space jacobian")["body jacobian"]},
        {"wanted": "space", "taken": "body"},
    )
    yield MistakeVariant({"body jacobian": lambda w, _: w["space jacobian"]}, {"wanted": "body", "taken": "space"})


def _reorder_geometric_rows(w: Working) -> np.ndarray:
    """Return the geometric Jacobian, whose linear velocities are those of P, with its rows in the order (omega, v)."""
    return np.roll(w["geometric"], 3, axis=0)


# --- the adjoint ---


def _change_adjoint(build: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> VariantGenerator:
    """Return a function that yields the variant in which `build` builds the adjoint matrix [Ad T].

    Its arguments are the rotation (3, 3, …) and the origin (3, …) of the body frame.
    """
    return single_variant({"body adjoint": lambda w, _: build(w["body rotation"], w["point"])})


def _stack_blocks(
    upper_left: np.ndarray, upper_right: np.ndarray, lower_left: np.ndarray, lower_right: np.ndarray
) -> np.ndarray:
    return np.concatenate(
        [np.concatenate([upper_left, upper_right], axis=1), np.concatenate([lower_left, lower_right], axis=1)]
    )


def _skew_matrix(vector: np.ndarray) -> np.ndarray:
    """Return the skew-symmetric matrix [v], (3, 3, …)."""
    x, y, z = vector
    return np.stack([np.stack([0 * x, -z, y]), np.stack([z, 0 * x, -x]), np.stack([-y, x, 0 * x])])


def _adjoint_of_inverse(rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    transpose = rotation.swapaxes(0, 1)
    return adjoint_matrix(transpose, -apply_matrix(transpose, position))


# --- exponentials ---

Motion = tuple[np.ndarray, np.ndarray]
"""The rotation (3, 3, …) and the translation (3, …) of a rigid motion."""


def _exponential(w: Working, axis: Axis, q: sp.Symbol) -> Motion:
    """Return the exponential of a joint's screw, computed with Rodrigues' formula."""
    angle, u = w.arithmetic.table_entry(q), constant_vector(w, axis.direction)
    zeros, ones = 0 * u[0], 0 * u[0] + 1
    identity = np.stack([np.stack(row) for row in ((ones, zeros, zeros), (zeros, ones, zeros), (zeros, zeros, ones))])
    if axis.kind == "P":
        return identity, w.arithmetic.drop_derivatives(angle)[None] * u
    s = w.arithmetic.drop_derivatives(w.arithmetic.sin(angle))
    c = w.arithmetic.drop_derivatives(w.arithmetic.cos(angle))
    rotation = identity + s * _skew_matrix(u) + (ones - c) * matrix_product(_skew_matrix(u), _skew_matrix(u))
    point = constant_vector(w, axis.point)
    return rotation, point - apply_matrix(rotation, point)


def _exponentials(w: Working) -> list[Motion]:
    return [_exponential(w, axis, q) for axis, q in zip(axes_of(w.chain)[0], w.chain.q, strict=True)]


def _compose(first: Motion, second: Motion) -> Motion:
    """Return the product of two motions."""
    return matrix_product(first[0], second[0]), apply_matrix(first[0], second[1]) + first[1]


def _move_screws(w: Working, motions: Sequence[Motion], is_reversed: bool = False) -> np.ndarray:
    """Return the home screws, each moved by the motions of the joints before it, (6, n, …)."""
    home = w["home screws"]
    moved_screws, motion = [home[:, 0]], motions[0]
    for i in range(1, w.n):
        angular, linear = apply_matrix(motion[0], home[:3, i]), apply_matrix(motion[0], home[3:, i])
        moved_screws.append(np.concatenate([angular, linear + cross(motion[1], angular)]))
        motion = _compose(motions[i], motion) if is_reversed else _compose(motion, motions[i])
    return np.stack(moved_screws, axis=1)


def _move_home_point(w: Working, motions: Sequence[Motion]) -> np.ndarray:
    """Return the home position of P moved by the product of the motions, (3, …)."""
    rotation, shift = reduce(_compose, motions)
    return apply_matrix(rotation, _home_point(w)) + shift


def _home_point(w: Working) -> np.ndarray:
    """Return the home position of P, (3, …)."""
    return constant_vector(w, axes_of(w.chain)[1])


def _reverse_order(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the exponentials in reverse order, in the pose or in the columns of the space Jacobian."""
    if chain.n > 1:
        yield MistakeVariant(
            {
                "body rotation": lambda w, _: reduce(_compose, _exponentials(w)[::-1])[0],
                "point": lambda w, _: _move_home_point(w, _exponentials(w)[::-1]),
            }
        )
    if chain.n > 2:
        yield MistakeVariant({"space jacobian": lambda w, _: _move_screws(w, _exponentials(w), is_reversed=True)})


def _drop_translation(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants without the translation (I - R) q in the exponentials of all joints, or of one joint.

    These joints then rotate about the origin.
    """

    def motions(w: Working, changed_joints: Sequence[int]) -> list[Motion]:
        return [
            (rotation, 0 * shift if i in changed_joints else shift)
            for i, (rotation, shift) in enumerate(_exponentials(w))
        ]

    def point(w: Working, _: np.ndarray, changed_joints: Sequence[int]) -> np.ndarray:
        return _move_home_point(w, motions(w, changed_joints))

    def columns(w: Working, _: np.ndarray, changed_joints: Sequence[int]) -> np.ndarray:
        return _move_screws(w, motions(w, changed_joints))

    shifting_joints = [  # the term is zero for an axis through the origin
        i for i, axis in enumerate(axes_of(chain)[0]) if axis.kind == "R" and any(axis.direction.cross(axis.point))
    ]
    for joints in (
        [shifting_joints, *([i] for i in shifting_joints)]
        if len(shifting_joints) > 1
        else [shifting_joints]
        if shifting_joints
        else []
    ):
        words = {"joint": " and ".join(str(i + 1) for i in joints)}
        yield MistakeVariant({"point": partial(point, changed_joints=joints)}, words)
        if joints[0] < chain.n - 1:
            yield MistakeVariant({"space jacobian": partial(columns, changed_joints=joints)}, words)


def _confuse_degrees(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with joint angles in degrees instead of radians, or converted to radians twice."""

    def scale(w: Working, table: Table, factor: sp.Expr) -> Table:
        for i, (q, offset, row) in enumerate(zip(chain.q, chain.offsets, table.rows, strict=False)):
            if row.kind == "R":
                table = table.with_row(i, theta=w.arithmetic.table_entry(factor * q + offset))
        return table

    for factor in (180 / sp.pi, sp.pi / 180) if any(joint.kind == "R" for joint in chain.joints) else ():
        yield propagated_variant({"table": partial(scale, factor=factor)})


_ALL_MISTAKES = (
    Mistake("screw-sign", "Screw with the wrong sign of its velocity",
            "The parts v of your screws seem to have the wrong sign. The point at the origin moves at -omega x q.",
            SECTION, _variants_in_each_stage(_flip_linear_parts, *SCREW_STAGES)),
    Mistake("screw-point", "Point on the axis instead of the velocity of a screw",
            "You seem to have used points on the axes as the parts v of the screws. These parts are velocities, "
            "-omega x q.", SECTION,
            _variants_in_each_stage(
                    _replace_linear_parts(lambda w, _, i, axis: constant_vector(w, axis.point)), "home screws"
                )),
    Mistake("twist-rows-exchanged", "Halves of a twist exchanged",
            "You seem to have exchanged the upper and the lower half. The question states the order of the rows.",
            SECTION, _variants_in_each_stage(_exchange_halves, *SCREW_STAGES, "geometric")),
    Mistake("slide-above", "Direction of a prismatic joint used as angular velocity",
            "You seem to have used the direction of a prismatic joint as omega. A prismatic joint does not rotate the "
            "links after it; its direction is v.", SECTION, _move_slide_to_angular_rows),
    Mistake("screws-at-home", "Screws of the home configuration",
            "Your columns seem to be the screws of the home configuration. Other joints move each screw: in the space "
            "Jacobian those before its joint, in the body Jacobian those after it.", SECTION, _use_home_screws),
    Mistake("other-twist-frame", "Space and body frame exchanged",
            "Your answer seems to be for the {taken} frame. The question asks for the {wanted} frame.", SECTION,
            _use_other_frame),
    Mistake("velocity-of-p", "Velocity of P in the space frame",
            "You seem to have used the velocity of P as v. In the space frame, v is the velocity of the point of the "
            "last link that is at the origin.", SECTION,
            single_variant({"space jacobian": lambda w, _: _reorder_geometric_rows(w)})),
    Mistake("body-not-turned", "Body velocities left in the coordinates of the space frame",
            "You seem to have left the velocities in the coordinates of the space frame. The transposed rotation "
            "matrix takes them into the body frame.", SECTION,
            single_variant({"body jacobian": lambda w, _: _reorder_geometric_rows(w)})),
    Mistake("body-turned-the-other-way", "Multiplied by the rotation matrix of the body frame instead of its transpose",
            "You seem to have multiplied the velocities by the rotation matrix of the body frame. Its transpose takes "
            "them into that frame.", SECTION,
            single_variant({"body jacobian": lambda w, _: rotate_rows(w["body rotation"], _reorder_geometric_rows(w))}),
            rare=True),
    Mistake("body-about-origin", "Reference point not moved to the body frame",
            "You seem to have only rotated the space Jacobian into the body frame. Its velocities v belong to another "
            "point: move them to P.", SECTION,
            single_variant({
                    "body jacobian": lambda w, _: rotate_rows(w["body rotation"].swapaxes(0, 1), w["space jacobian"])
                }), rare=True),
    Mistake("adjoint-of-inverse", "Adjoint of the inverse",
            "You seem to have given the adjoint of T_bs, which takes twists into the body frame. The question asks "
            "for the adjoint of T_sb.",
            SECTION, _change_adjoint(_adjoint_of_inverse)),
    Mistake("adjoint-block-above", "[P] R in the wrong block",
            "The block [P] R seems to be in the wrong corner. It takes omega to v, so it belongs in the rows of v and "
            "the columns of omega.", SECTION,
            _change_adjoint(
                    lambda turn, place: _stack_blocks(turn, matrix_product(_skew_matrix(place), turn), 0 * turn, turn)
                )),
    Mistake("adjoint-order", "Product R [P] instead of [P] R",
            "The block beside the two rotations seems to be R [P]. R rotates vectors into the space frame first, so "
            "[P] is on its left.", SECTION,
            _change_adjoint(
                    lambda turn, place: _stack_blocks(turn, 0 * turn, matrix_product(turn, _skew_matrix(place)), turn)
                )),
    Mistake("adjoint-sign", "[P] R with the wrong sign",
            "The block [P] R of the adjoint seems to have the wrong sign. The point at the origin moves at v + P x "
            "omega.", SECTION, _change_adjoint(lambda turn, place: adjoint_matrix(turn, -place))),
    Mistake("adjoint-without-p", "Twist rotated, but not moved",
            "You seem to have only rotated the two halves of the twist. In the space frame, v belongs to another "
            "point, and the block [P] R accounts for that.", SECTION,
            _change_adjoint(lambda turn, place: adjoint_matrix(turn, 0 * place))),
    Mistake("adjoint-not-turned", "Block [P] instead of [P] R",
            "You seem to have used [P] instead of [P] R. The factor R rotates the angular velocity first.", SECTION,
            _change_adjoint(lambda turn, place: _stack_blocks(turn, 0 * turn, _skew_matrix(place), turn))),
    Mistake("rotation-transposed", "Rotation of the body frame transposed",
            "You seem to have transposed R. The columns of R_sb are the axes of the body frame, in the coordinates of "
            "the space frame.", SECTION,
            _change_adjoint(lambda turn, place: adjoint_matrix(turn.swapaxes(0, 1), place)), rare=True),
    Mistake("exponentials-reversed", "Exponentials in the wrong order",
            "You seem to have multiplied the exponentials in the wrong order. The exponential of joint 1 is on the "
            "left.", SECTION,
            _reverse_order),
    Mistake("home-pose-left", "Home pose M on the left",
            "You seem to have put the home pose M on the left of the exponentials. With screws in the space frame, M "
            "is on the right.", SECTION,
            single_variant({"point": lambda w, _: _home_point(w) + reduce(_compose, _exponentials(w))[1]})),
    Mistake("home-pose-forgotten", "Home pose M left out",
            "You seem to have left out the home pose M. Multiply the product of the exponentials by it.", SECTION,
            single_variant({"point": lambda w, _: reduce(_compose, _exponentials(w))[1]})),
    Mistake("exponential-about-origin", "Term (I - R) q left out of an exponential",
            "The exponential of joint {joint} seems to rotate about the origin. The axis passes through q, so the "
            "column beside R is (I - R) q.", SECTION, _drop_translation),
    Mistake("points-at-home", "Points on the axes in the home configuration",
            "You seem to have used points on the axes in the home configuration. The joints before an axis move it, "
            "and its points with it.", SECTION,
            _variants_in_each_stage(
                    _replace_linear_parts(
                        lambda w, columns, i, axis: -cross(columns[:3, i], constant_vector(w, axis.point))
                    ),
                    "space jacobian",
                ), rare=True),
    Mistake("joints-in-degrees", "Degrees instead of radians in exponentials",
            "You seem to have mixed up degrees and radians. Joint angles are in radians: use them in sine and cosine "
            "without conversion.", SECTION, _confuse_degrees, rare=True),
)  # fmt: skip

MISTAKES = restrict_to_feature(HAS_SCREWS, _ALL_MISTAKES)
