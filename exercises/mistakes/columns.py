"""Mistakes in the columns of a Jacobian: by differentiation (6.3) and by propagation (6.9 to 6.12).

The stage "link derivatives" has the derivatives of all link vectors with respect to all joint variables, (joints, links
+ 1, 3, …). The stage "vectors to point" has the vectors p* from a frame on each joint axis to P, (joints + 1, 3, …).
Here "…" stands for the axes of the arithmetic (`mistakes.base`).
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import PRISMATIC, REVOLUTE, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.derivation import graph
from qdot.exercises.derivation.arithmetic import apply_matrix, cross, matrix_product
from qdot.exercises.derivation.graph import RESULT, Change, StageResults, Table
from qdot.exercises.mistakes import base
from qdot.exercises.mistakes.base import AnswerShape, MistakeVariant, VariantGenerator
from qdot.exercises.mistakes.position import find_first_joint_of_run, list_nonzero_links, make_link_words

# --- differentiation ---


def _scale_term(factor: int, min_terms: int) -> VariantGenerator:
    """Return a function that yields variants with the contribution of one link to one column multiplied by a factor.

    Only columns with contributions from at least `min_terms` links are changed.
    """

    def generate(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        for joint in range(chain.n):
            links = [link for link in list_nonzero_links(chain) if link >= joint]
            for link in links if len(links) >= min_terms else ():
                words = {"joint": joint + 1, **make_link_words(chain, link)}
                yield MistakeVariant({"link derivatives": base.scale_entries((joint, link), factor)}, words=words)

    return generate


def _keep_own_link(stages: StageResults, link_derivatives: np.ndarray) -> np.ndarray:
    """Return the derivatives, with zeros for all links except the one directly after each joint."""
    other_links = ~np.eye(stages.n, stages.n + 1, dtype=bool)
    return np.asarray(base.scale_entries(other_links, factor=0)(stages, link_derivatives))


def _keep_last_link(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant in which only the last link contributes to the columns."""
    links = list_nonzero_links(chain)
    if len(links) > 1:
        yield MistakeVariant({"link derivatives": base.scale_entries((slice(None), links[:-1]), factor=0)})


def _mirror_link_derivatives(stages: StageResults, joint: int) -> np.ndarray:
    """Return the derivatives of the link vectors with respect to a joint variable, with the angles of its run negated.

    The run is the sequence of consecutive parallel joints that contains the joint. Negating these angles changes the
    signs of the derivatives of all sines, but not of cosines.
    """
    run_start = find_first_joint_of_run(stages.chain, joint)
    run = [
        i for i in base.list_joints_of_kind(stages, REVOLUTE) if find_first_joint_of_run(stages.chain, i) == run_start
    ]

    def mirror(_: StageResults, table: Table) -> Table:
        rows = (replace(row, theta=-row.theta) if i in run else row for i, row in enumerate(table.rows))
        return replace(table, rows=tuple(rows))

    return np.asarray(
        stages.without_changes_of("link derivatives").with_mistakes({"table": mirror})["link derivatives"][joint]
    )


def _flip_derivative(sign: int) -> VariantGenerator:
    """Return a function that yields the variant with a wrong sign in the derivatives of all cosines or of all sines.

    In mirrored derivatives, those of the sines have the wrong sign. If they are multiplied by the `sign` -1, those of
    the cosines have the wrong sign instead.
    """

    def apply_change(stages: StageResults, link_derivatives: np.ndarray) -> np.ndarray:
        new_derivatives = np.array(link_derivatives)
        for i in base.list_joints_of_kind(stages, REVOLUTE):
            new_derivatives[i] = sign * _mirror_link_derivatives(stages, i)
        return new_derivatives

    return base.vary_if(lambda chain: chain.revolute_joints, {"link derivatives": apply_change})


def _skip_differentiation(stages: StageResults, link_derivatives: np.ndarray) -> np.ndarray:
    """Return the derivatives, but for revolute joints the link vectors themselves instead of their derivatives."""
    new_derivatives = np.array(link_derivatives)
    links = stages.arithmetic.drop_derivatives(np.stack(stages["link vectors"]))
    for joint in base.list_joints_of_kind(stages, REVOLUTE):
        later_links = [k for k in graph.list_links_to_point(stages.chain) if k >= joint]
        new_derivatives[joint, later_links] = links[later_links]
    return new_derivatives


# --- propagation ---


def _vary_propagation(*change_sets: Mapping[str, Change], mentions_axis: bool = False) -> VariantGenerator:
    """Return a function that yields one variant for each set of changes, with the linear rows of J by propagation.

    If `mentions_axis`, the message mentions the axis of joint i, and the frame on this axis.
    """
    return lambda chain, _: (
        base.make_propagated_variant(changes, words=_make_axis_words(chain) if mentions_axis else {})
        for changes in change_sets
    )


def _make_axis_words(chain: Chain) -> dict[str, object]:
    """Return the names of the axis of joint i and of the frame on this axis, in the arm's convention."""
    convention = convention_of(chain)
    return {"frame": convention.frame_index, "axis": convention.axis_in_words}


def _shift_to_next(stages: StageResults, vectors: np.ndarray) -> np.ndarray:
    return np.concatenate([vectors[1:], vectors[-1:]])


def _shift_to_previous(stages: StageResults, vectors: np.ndarray) -> np.ndarray:
    return np.concatenate([vectors[:1], vectors[:-1]])


def _start_one_frame_earlier(stages: StageResults, vectors_to_point: np.ndarray) -> np.ndarray:
    """Return the vectors to P from the frame on the previous joint axis; the first vector starts at the base."""
    return np.concatenate([stages["point"][None] - stages["origins"][:1], vectors_to_point[:-1]])


def _start_at_other_origin(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants in which the vector to P from one joint axis starts at another joint axis."""

    def replace_vector(stages: StageResults, vectors_to_point: np.ndarray, i: int, j: int) -> np.ndarray:
        return vectors_to_point[[j if k == i else k for k in range(len(vectors_to_point))]]

    for i, j in permutations(range(chain.n), 2):
        frame_on_axis = convention_of(chain).find_frame_on_axis
        words = {"joint": i + 1, "frame": frame_on_axis(i + 1), "other": frame_on_axis(j + 1)}
        yield MistakeVariant({"vectors to point": partial(replace_vector, i=i, j=j)}, words=words)


def _stop_at_next_origin(stages: StageResults, vectors_to_point: np.ndarray) -> np.ndarray:
    """Return the link vectors instead of the vectors to P."""
    links = stages.arithmetic.drop_derivatives(np.stack(stages["link vectors"]))
    return np.stack([*links[: stages.n], vectors_to_point[-1]])


def _treat_joints_as(wrong_kind: str, correct_kind: str) -> VariantGenerator:
    """Return a function that yields variants in which joints of one kind are treated like those of the other kind."""

    def treat(treated_joints: Sequence[int]) -> MistakeVariant:
        def apply_change(stages: StageResults, correct_kinds: list[str]) -> list[str]:
            return [wrong_kind if i in treated_joints else kind for i, kind in enumerate(correct_kinds)]

        return base.make_propagated_variant({"joint kinds": apply_change}, words=base.make_joint_words(treated_joints))

    return lambda chain, shape: base.vary_each_joint_and_all(chain.list_joints_of_kind(correct_kind), treat)


def _replace_angular(
    make_column: Callable[[StageResults, int, np.ndarray], np.ndarray], words: Mapping[str, object]
) -> MistakeVariant:
    """Return the variant in which `make_column` computes each joint's column of the angular rows.

    The arguments of `make_column` are the stages, the index of the joint and the correct column.
    """

    def apply_change(stages: StageResults, angular_rows: np.ndarray) -> np.ndarray:
        return np.stack([make_column(stages, i, angular_rows[:, i]) for i in range(stages.n)], axis=1)

    return MistakeVariant({"angular rows": apply_change}, words=words)


def _rotate_prismatic_joints(joints: Sequence[int]) -> MistakeVariant:
    """Return the variant in which prismatic joints cause an angular velocity."""
    return _replace_angular(
        lambda stages, i, column: stages["axes"][i] if i in joints else column, words=base.make_joint_words(joints)
    )


def _drop_angular(joints: Sequence[int]) -> MistakeVariant:
    """Return the variant in which some joints cause no angular velocity."""
    return _replace_angular(
        lambda stages, i, column: 0 * column if i in joints else column, words=base.make_joint_words(joints)
    )


def _keep_one_angular(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants in which only one of three or more revolute joints causes an angular velocity."""
    revolute_joints = chain.revolute_joints
    for i in revolute_joints if len(revolute_joints) > 2 else ():
        yield replace(_drop_angular([k for k in range(chain.n) if k != i]), words=base.make_joint_words([i]))


def _use_next_angular(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant with the axis of the next joint in the angular rows of each revolute joint."""
    yield _replace_angular(
        lambda stages, i, column: column if stages["joint kinds"][i] == PRISMATIC else stages["axes"][i + 1],
        words=_make_axis_words(chain),
    )


def _use_tool_frame(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the columns of J, or only the axes, in the coordinates of the last frame.

    If the question asks for these coordinates, the vectors are not rotated a second time.
    """

    def rotate(stages: StageResults, vectors: np.ndarray) -> np.ndarray:
        return matrix_product(stages["last rotation"].swapaxes(0, 1), vectors)

    yield MistakeVariant({"linear rows": rotate, "angular rows": rotate, "tool jacobian": _leave_in_base(slice(0, 6))})

    def rotate_axes(stages: StageResults, axes: np.ndarray) -> np.ndarray:
        return rotate(stages, axes.swapaxes(0, 1)).swapaxes(0, 1)

    yield MistakeVariant({"axes": rotate_axes, "tool jacobian": _leave_in_base(slice(3, 6))})


def _use_local_axes(stages: StageResults, axes: np.ndarray) -> np.ndarray:
    """Return (0, 0, 1) for every joint axis, its coordinates in the frame on the axis itself."""
    local_axis = np.stack([stages.arithmetic.make_constant(sp.Integer(value)) for value in (0, 0, 1)])
    return np.stack([local_axis] * len(axes))


def _list_rotations_on_axes(stages: StageResults) -> list[np.ndarray]:
    """Return the rotations of the frames on the axes of joints 1 to n + 1; the last frame replaces a missing one."""
    frames = [convention_of(stages.chain).find_frame_on_axis(joint) for joint in range(1, stages.n + 2)]
    return [graph.compute_convention_rotation(stages, min(frame, stages.n)) for frame in frames]


def _use_frame_axis(axis: str, joint: int | None = None) -> MistakeVariant:
    """Return the variant with the x or y axis of a frame instead of the joint axis, for one joint or for all joints."""

    def apply_change(stages: StageResults, axes: np.ndarray) -> np.ndarray:
        columns = [rotation[:, "xy".index(axis)] for rotation in _list_rotations_on_axes(stages)]
        return np.stack([column if joint in (i, None) else axes[i] for i, column in enumerate(columns)])

    words = {"axis": axis} if joint is None else {"axis": axis, "joint": joint + 1}
    return base.make_propagated_variant({"axes": apply_change}, words=words)


def _drop_joint(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants that omit the contribution of one joint to the velocities."""
    for i in range(chain.n) if chain.n > 1 else ():
        drop = base.scale_entries((slice(None), i), factor=0)
        yield MistakeVariant({"linear rows": drop, "angular rows": drop}, words={"joint": i + 1})


def _leave_vectors_in_base(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with all vectors of J, or only linear or angular ones, in base coordinates.

    They change only the answers to questions that ask for the coordinates of another frame.
    """
    for noun, rows in (
        ("vectors", slice(0, 6)),
        ("angular parts of the columns", slice(3, 6)),
        ("linear parts of the columns", slice(0, 3)),
    ):
        yield MistakeVariant({"tool jacobian": _leave_in_base(rows)}, words={"vectors": noun})
    yield MistakeVariant(
        {"wrist block": lambda stages, _: np.moveaxis(stages["axes"][3:6], 0, 1)}, words={"vectors": "vectors"}
    )


def _leave_in_base(rows: slice) -> Change:
    """Return the change that leaves some rows of the Jacobian in base coordinates instead of tool coordinates."""

    def apply_change(stages: StageResults, rotated_jacobian: np.ndarray) -> np.ndarray:
        new_jacobian = np.array(rotated_jacobian)
        new_jacobian[rows] = stages["geometric jacobian"][rows]
        return new_jacobian

    return apply_change


def _use_earlier_frame(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the Jacobian in the coordinates of an earlier frame instead of the last frame."""

    def rotate(stages: StageResults, _: np.ndarray, frame: int) -> np.ndarray:
        return graph.rotate_rows(
            graph.compute_convention_rotation(stages, frame).swapaxes(0, 1), stages["geometric jacobian"]
        )

    for frame in range(1, chain.n):
        yield MistakeVariant({"tool jacobian": partial(rotate, frame=frame)}, words={"frame": frame})


def _use_other_velocity(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the velocity of another frame, or with the velocity of P that only the first joints cause."""

    def replace_by_frame_velocity(stages: StageResults, velocity: np.ndarray, frame: int) -> np.ndarray:
        if not stages.depends_on("joint rates"):
            return velocity
        try:
            frame_stages = stages if frame == stages.n else stages.keep_first_joints(frame)
            jacobian = frame_stages["tool jacobian" if stages.depends_on("tool jacobian") else "geometric jacobian"]
            return apply_matrix(jacobian, stages["joint rates"][:frame])[:, None]
        except IndexError:  # another mistake is made at a joint after the frame
            return velocity

    def replace_by_partial_velocity(stages: StageResults, velocity: np.ndarray, last_joint: int) -> np.ndarray:
        if not stages.depends_on("joint rates"):
            return velocity
        return apply_matrix(stages["geometric jacobian"][:, :last_joint], stages["joint rates"][:last_joint])[:, None]

    last_frame_words = "the last frame" if convention_of(chain).point.is_origin else "the point of interest"
    for frame in range(1, chain.n + 1) if shape == (6, 1) else ():
        words = {"frame": "another frame" if frame < chain.n else last_frame_words}
        yield MistakeVariant({RESULT: partial(replace_by_frame_velocity, frame=frame)}, words=words)
        if frame < chain.n:
            yield MistakeVariant(
                {RESULT: partial(replace_by_partial_velocity, last_joint=frame)},
                words={"frame": "the point of interest"},
            )


VARIANTS: dict[str, VariantGenerator] = {
    "chain-rule": _scale_term(factor=0, min_terms=2),
    "joint-left-out": _drop_joint,
    "own-link-only": base.vary_always({"link derivatives": _keep_own_link}),
    "last-link-only": _keep_last_link,
    "term-sign": _scale_term(factor=-1, min_terms=1),
    "derivative-of-cosine": _flip_derivative(sign=-1),
    "derivative-of-sine": _flip_derivative(sign=1),
    "not-differentiated": base.vary_always({"link derivatives": _skip_differentiation}),
    "next-axis": _vary_propagation(
        {"axes": _shift_to_next},
        {"cross products": lambda stages, _: list(map(cross, stages["axes"][1:], stages["vectors to point"]))},
        mentions_axis=True,
    ),
    "next-arm": _vary_propagation({"vectors to point": _shift_to_next}, mentions_axis=True),
    "next-frame": _vary_propagation({"axes": _shift_to_next, "vectors to point": _shift_to_next}, mentions_axis=True),
    "previous-frame": _vary_propagation({"axes": _shift_to_previous, "vectors to point": _start_one_frame_earlier}),
    "previous-axis": _vary_propagation({"axes": _shift_to_previous}, mentions_axis=True),
    "cross-order": _vary_propagation(
        {"cross products": lambda stages, _: list(map(cross, stages["vectors to point"], stages["axes"]))[: stages.n]}
    ),
    "no-cross-product": _vary_propagation({"cross products": lambda stages, _: stages["vectors to point"]}),
    "arm-from-base": _vary_propagation(
        {"vectors to point": lambda stages, vectors: np.stack([stages["point"]] * len(vectors))}
    ),
    "arm-from-other-origin": _start_at_other_origin,
    "arm-to-origin": _vary_propagation({"vectors to point": lambda stages, _: stages["origins on axes"]}),
    "arm-reversed": _vary_propagation({"vectors to point": lambda stages, vectors: -vectors}),
    "arm-of-one-link": _vary_propagation({"vectors to point": _stop_at_next_origin}),
    "prismatic-as-revolute": _treat_joints_as(REVOLUTE, PRISMATIC),
    "revolute-as-prismatic": _treat_joints_as(PRISMATIC, REVOLUTE),
    "slide-turns": base.vary_each(lambda chain: (([i],) for i in chain.prismatic_joints), _rotate_prismatic_joints),
    "no-angular-part": lambda chain, _: base.vary_each_joint_and_all(chain.revolute_joints, _drop_angular),
    "slides-turn": base.vary_each(  # all prismatic joints; "slide-turns" is one of them
        lambda chain: [(chain.prismatic_joints,)] if len(chain.prismatic_joints) > 1 else [], _rotate_prismatic_joints
    ),
    "angular-of-one-joint": _keep_one_angular,
    "angular-of-next-axis": _use_next_angular,
    "blocks-exchanged": base.vary_always(  # the angular rows before the linear rows
        {"geometric jacobian": lambda stages, rows: np.roll(rows, shift=3, axis=0)}
    ),
    "tool-frame": _use_tool_frame,
    "axes-in-own-frames": _vary_propagation({"axes": _use_local_axes}),
    "wrong-axis": base.vary_each(lambda _: [("x",), ("y",)], _use_frame_axis),
    "wrong-axis-of-joint": base.vary_each(lambda chain: product("xy", range(chain.n)), _use_frame_axis),
    "row-of-rotation": _vary_propagation(
        {"axes": lambda stages, _: np.stack([rotation[2] for rotation in _list_rotations_on_axes(stages)])}
    ),
    "axis-sign": base.vary_each(
        lambda chain: ((i,) for i in range(chain.n)),
        lambda i: base.make_propagated_variant({"axes": base.scale_entries(i, factor=-1)}, words={"joint": i + 1}),
    ),
    "vectors-left-in-base": _leave_vectors_in_base,
    "rotated-the-wrong-way": base.vary_always(
        {"tool jacobian": lambda stages, _: graph.rotate_rows(stages["last rotation"], stages["geometric jacobian"])}
    ),
    "earlier-frame": _use_earlier_frame,
    "velocity-of-other-frame": _use_other_velocity,
    "arms-exchanged": base.vary_each(
        lambda chain: combinations(range(chain.n), 2),
        lambda i, j: base.make_propagated_variant(
            {"vectors to point": base.exchange(i, j)}, words={"joint": i + 1, "other": j + 1}
        ),
    ),
}
