"""Mistakes with screws and the product of exponentials, for arms described by their axes in the home configuration.

In shapes, "…" stands for the axes of the arithmetic (`derivation.graph`).
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial, reduce
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes_to_dh import Axis
from qdot.exercises.arm.chain import PRISMATIC, REVOLUTE, Chain
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.derivation import graph
from qdot.exercises.derivation.arithmetic import apply_matrix, cross, matrix_product
from qdot.exercises.derivation.graph import Change, StageResults, Table
from qdot.exercises.mistakes import base
from qdot.exercises.mistakes.base import AnswerShape, MistakeVariant, VariantGenerator

SCREW_STAGES = ("home screws", "space jacobian", "body jacobian")
"""The stages of the derivation whose columns are screws (omega, v)."""


def _vary_each_stage(change: Change, *stages: str) -> VariantGenerator:
    """Return a function that yields one variant for each stage, in which this stage is changed."""
    return lambda chain, _: (MistakeVariant({stage: change}) for stage in stages)


def _flip_linear_parts(stages: StageResults, columns: np.ndarray) -> np.ndarray:
    """Return the screws with the opposite sign of v for revolute joints."""
    return base.scale_entries((slice(3, None), base.list_joints_of_kind(stages, REVOLUTE)), factor=-1)(stages, columns)


def _replace_linear_parts(compute_linear: Callable[[StageResults, np.ndarray, int, Axis], np.ndarray]) -> Change:
    """Return the change that replaces the linear parts v of the screws of revolute joints.

    The arguments of `compute_linear` are the stages, the correct screws, the index of the joint and its axis at home.
    """

    def replace_linear_parts(stages: StageResults, columns: np.ndarray) -> np.ndarray:
        new_columns = np.array(columns)
        for i, axis in enumerate(compute_home_geometry(stages.chain).axes):
            if axis.is_revolute:
                new_columns[3:, i] = compute_linear(stages, columns, i, axis)
        return new_columns

    return replace_linear_parts


def _move_prismatic_to_angular_rows(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the directions of prismatic joints in the rows of omega, unless all joints are prismatic."""

    def apply_change(stages: StageResults, columns: np.ndarray) -> np.ndarray:
        prismatic_joints = base.list_joints_of_kind(stages, PRISMATIC)
        new_columns = np.array(columns)
        new_columns[:, prismatic_joints] = np.roll(columns[:, prismatic_joints], shift=3, axis=0)
        return new_columns

    if {joint.kind for joint in chain.joints} == {REVOLUTE, PRISMATIC}:
        yield from (MistakeVariant({stage: apply_change}) for stage in SCREW_STAGES)


def _use_home_screws(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the home screws as the space Jacobian, and with the home screws about P as the body Jacobian.

    A student who makes this mistake forgets that the joints move the screws and P.
    """

    def move_to_point(stages: StageResults, _: np.ndarray) -> np.ndarray:
        point, home = _compute_home_point(stages), stages["home screws"]
        linear_parts = [home[3:, i] + cross(home[:3, i], point) for i in range(stages.n)]
        return np.concatenate([home[:3], np.stack(linear_parts, axis=1)])

    yield MistakeVariant({"space jacobian": lambda stages, _: stages["home screws"]})
    yield MistakeVariant({"body jacobian": move_to_point})


def _use_other_frame(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the body Jacobian instead of the space Jacobian, and vice versa."""
    yield MistakeVariant(
        # use the correct body Jacobian, because it would otherwise be computed from the changed space Jacobian
        {"space jacobian": lambda stages, _: stages.without_changes_of("space jacobian")["body jacobian"]},
        words={"wanted": "space", "taken": "body"},
    )
    yield MistakeVariant(
        {"body jacobian": lambda stages, _: stages["space jacobian"]}, words={"wanted": "body", "taken": "space"}
    )


def _reorder_geometric_rows(stages: StageResults) -> np.ndarray:
    """Return the geometric Jacobian, with the velocities of P, in the order of rows (omega, v)."""
    return np.roll(stages["geometric jacobian"], shift=3, axis=0)


# --- the adjoint ---


def _change_adjoint(build: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> VariantGenerator:
    """Return a function that yields the variant in which `build` computes the adjoint matrix [Ad T].

    The arguments of `build` are the rotation (3, 3, …) and the origin (3, …) of the body frame.
    """
    return base.vary_always({"body adjoint": lambda stages, _: build(stages["body rotation"], stages["point"])})


def _stack_blocks(
    upper_left: np.ndarray, upper_right: np.ndarray, lower_left: np.ndarray, lower_right: np.ndarray
) -> np.ndarray:
    """Return the matrix (6, 6, …) that consists of four blocks (3, 3, …)."""
    upper, lower = np.concatenate([upper_left, upper_right], axis=1), np.concatenate([lower_left, lower_right], axis=1)
    return np.concatenate([upper, lower])


def _make_skew_matrix(vector: np.ndarray) -> np.ndarray:
    """Return the skew-symmetric matrix [v], (3, 3, …)."""
    x, y, z = vector
    return np.stack([np.stack([0 * x, -z, y]), np.stack([z, 0 * x, -x]), np.stack([-y, x, 0 * x])])


def _compute_adjoint_of_inverse(rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the adjoint matrix (6, 6, …) of the inverse of a pose."""
    transpose = rotation.swapaxes(0, 1)
    return graph.make_adjoint_matrix(transpose, -apply_matrix(transpose, position))


# --- exponentials ---


class Motion(NamedTuple):
    """The rotation (3, 3, …) and the translation (3, …) of a rigid motion."""

    rotation: np.ndarray
    translation: np.ndarray


def _compute_exponential(stages: StageResults, axis: Axis, q: sp.Symbol) -> Motion:
    """Return the exponential of a joint's screw, computed with Rodrigues' formula."""
    angle, direction = stages.arithmetic.convert_entry(q), graph.convert_constant_vector(stages, axis.direction)
    zeros, ones = 0 * direction[0], 0 * direction[0] + 1
    identity = np.stack([np.stack(row) for row in ((ones, zeros, zeros), (zeros, ones, zeros), (zeros, zeros, ones))])
    if axis.is_prismatic:
        return Motion(identity, stages.arithmetic.drop_derivatives(angle)[None] * direction)
    sine = stages.arithmetic.drop_derivatives(stages.arithmetic.sin(angle))
    cosine = stages.arithmetic.drop_derivatives(stages.arithmetic.cos(angle))
    skew = _make_skew_matrix(direction)
    rotation = identity + sine * skew + (ones - cosine) * matrix_product(skew, skew)
    point = graph.convert_constant_vector(stages, axis.point)
    return Motion(rotation, point - apply_matrix(rotation, point))


def _compute_exponentials(stages: StageResults) -> list[Motion]:
    return [
        _compute_exponential(stages, axis, q)
        for axis, q in zip(compute_home_geometry(stages.chain).axes, stages.chain.q, strict=True)
    ]


def _multiply_exponentials(stages: StageResults) -> Motion:
    return reduce(_compose, _compute_exponentials(stages))


def _compose(left: Motion, right: Motion) -> Motion:
    """Return the product of two motions."""
    translation = apply_matrix(left.rotation, right.translation) + left.translation
    return Motion(matrix_product(left.rotation, right.rotation), translation)


def _move_screws(stages: StageResults, motions: Sequence[Motion], is_reversed: bool = False) -> np.ndarray:
    """Return the home screws, each moved by the motions of the earlier joints, (6, n, …).

    If `is_reversed`, the motions are multiplied in reverse order.
    """
    home = stages["home screws"]
    moved_screws, motion = [home[:, 0]], motions[0]
    for i in range(1, stages.n):
        angular_part, linear_part = (apply_matrix(motion.rotation, vector) for vector in (home[:3, i], home[3:, i]))
        moved_screws.append(np.concatenate([angular_part, linear_part + cross(motion.translation, angular_part)]))
        motion = _compose(motions[i], motion) if is_reversed else _compose(motion, motions[i])
    return np.stack(moved_screws, axis=1)


def _move_home_point(stages: StageResults, motions: Sequence[Motion]) -> np.ndarray:
    """Return P at home, moved by the product of the motions, (3, …)."""
    motion = reduce(_compose, motions)
    return apply_matrix(motion.rotation, _compute_home_point(stages)) + motion.translation


def _compute_home_point(stages: StageResults) -> np.ndarray:
    """Return the position of P at home, (3, …)."""
    return graph.convert_constant_vector(stages, compute_home_geometry(stages.chain).point)


def _reverse_order(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the exponentials in reverse order: in the pose, or in the space Jacobian."""
    if chain.n > 1:
        yield MistakeVariant({
            "body rotation": lambda stages, _: reduce(_compose, _compute_exponentials(stages)[::-1]).rotation,
            "point": lambda stages, _: _move_home_point(stages, _compute_exponentials(stages)[::-1]),
        })  # fmt: skip
    if chain.n > 2:
        yield MistakeVariant(
            {"space jacobian": lambda stages, _: _move_screws(stages, _compute_exponentials(stages), is_reversed=True)}
        )


def _drop_translation(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants without the translation (I - R) a in the exponentials of all joints, or of one joint.

    Here a is a point on the axis of the joint. Without this translation, the joint would rotate about the origin.
    """

    def list_motions(stages: StageResults, changed_joints: Sequence[int]) -> list[Motion]:
        exponentials = enumerate(_compute_exponentials(stages))
        return [Motion(R, 0 * p) if i in changed_joints else Motion(R, p) for i, (R, p) in exponentials]

    def change_point(stages: StageResults, _: np.ndarray, changed_joints: Sequence[int]) -> np.ndarray:
        return _move_home_point(stages, list_motions(stages, changed_joints))

    def change_columns(stages: StageResults, _: np.ndarray, changed_joints: Sequence[int]) -> np.ndarray:
        return _move_screws(stages, list_motions(stages, changed_joints))

    translating_joints = [  # for an axis through the origin, the translation is zero
        i
        for i, axis in enumerate(compute_home_geometry(chain).axes)
        if axis.is_revolute and any(axis.direction.cross(axis.point))
    ]
    all_joints = [translating_joints] if len(translating_joints) > 1 else []
    for joints in (*all_joints, *([i] for i in translating_joints)):
        words = base.make_joint_words(joints)
        yield MistakeVariant({"point": partial(change_point, changed_joints=joints)}, words=words)
        if joints[0] < chain.n - 1:  # the last joint moves no other screw
            yield MistakeVariant({"space jacobian": partial(change_columns, changed_joints=joints)}, words=words)


def _confuse_degrees(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with joint angles in degrees instead of radians, or converted to radians twice.

    Linear rows are computed by propagation, because derivatives with respect to degrees would have another factor.
    """

    def scale(stages: StageResults, table: Table, factor: sp.Expr) -> Table:
        new_table = table
        for i, (q, offset, row) in enumerate(zip(chain.q, chain.offsets, table.rows, strict=False)):
            if row.is_revolute:
                new_table = new_table.with_row(i, theta=stages.arithmetic.convert_entry(factor * q + offset))
        return new_table

    for factor in (180 / sp.pi, sp.pi / 180) if chain.revolute_joints else ():
        yield base.make_propagated_variant({"table": partial(scale, factor=factor)})


VARIANTS: dict[str, VariantGenerator] = {
    "screw-sign": _vary_each_stage(_flip_linear_parts, *SCREW_STAGES),
    "screw-point": _vary_each_stage(
        _replace_linear_parts(lambda stages, _, i, axis: graph.convert_constant_vector(stages, axis.point)),
        "home screws",
    ),
    "twist-rows-exchanged": _vary_each_stage(
        lambda stages, columns: np.roll(columns, shift=3, axis=0), *SCREW_STAGES, "geometric jacobian"
    ),
    "slide-above": _move_prismatic_to_angular_rows,
    "screws-at-home": _use_home_screws,
    "other-twist-frame": _use_other_frame,
    "velocity-of-p": base.vary_always({"space jacobian": lambda stages, _: _reorder_geometric_rows(stages)}),
    "body-not-rotated": base.vary_always({"body jacobian": lambda stages, _: _reorder_geometric_rows(stages)}),
    "body-rotated-the-wrong-way": base.vary_always(
        {"body jacobian": lambda stages, _: graph.rotate_rows(stages["body rotation"], _reorder_geometric_rows(stages))}
    ),
    "body-about-origin": base.vary_always(
        {
            "body jacobian": lambda stages, _: graph.rotate_rows(
                stages["body rotation"].swapaxes(0, 1), stages["space jacobian"]
            )
        }
    ),
    "adjoint-of-inverse": _change_adjoint(_compute_adjoint_of_inverse),
    "adjoint-block-upper-right": _change_adjoint(
        lambda R, P: _stack_blocks(R, matrix_product(_make_skew_matrix(P), R), 0 * R, R)
    ),
    "adjoint-order": _change_adjoint(lambda R, P: _stack_blocks(R, 0 * R, matrix_product(R, _make_skew_matrix(P)), R)),
    "adjoint-sign": _change_adjoint(lambda R, P: graph.make_adjoint_matrix(R, -P)),
    "adjoint-without-p": _change_adjoint(lambda R, P: graph.make_adjoint_matrix(R, 0 * P)),
    "adjoint-not-rotated": _change_adjoint(lambda R, P: _stack_blocks(R, 0 * R, _make_skew_matrix(P), R)),
    "rotation-transposed": _change_adjoint(lambda R, P: graph.make_adjoint_matrix(R.swapaxes(0, 1), P)),
    "exponentials-reversed": _reverse_order,
    "home-pose-multiplied-from-left": base.vary_always(  # M exp(…) instead of exp(…) M
        {"point": lambda stages, _: _compute_home_point(stages) + _multiply_exponentials(stages).translation}
    ),
    "home-pose-forgotten": base.vary_always({"point": lambda stages, _: _multiply_exponentials(stages).translation}),
    "exponential-about-origin": _drop_translation,
    "points-at-home": _vary_each_stage(
        _replace_linear_parts(
            lambda stages, columns, i, axis: -cross(columns[:3, i], graph.convert_constant_vector(stages, axis.point))
        ),
        "space jacobian",
    ),
    "joints-in-degrees": _confuse_degrees,
}
