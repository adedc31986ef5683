"""Mistakes in the columns of a Jacobian: by differentiation (6.3) and by propagation (6.9 to 6.12)."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, cross
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation_graph import (
    RESULT,
    Change,
    StageResults,
    Table,
    convention_rotation,
    links_to_point,
    rotate_rows,
)
from qdot.exercises.mistakes.base import (
    AnswerShape,
    MistakeVariant,
    VariantGenerator,
    exchange,
    joint_words,
    joints_of_kind,
    propagated_variant,
    scale_entries,
    single_variant,
    variants_if,
    vary_each_joint_and_all,
)
from qdot.exercises.mistakes.position import first_joint_of_run, link_words, moving_links

# --- differentiation ---


def _scale_term(factor: int, min_terms: int) -> VariantGenerator:
    """Return a function that yields variants with one link's contribution to one column multiplied by a factor.

    The column must have contributions from at least `min_terms` links.
    """

    def variants(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        for joint in range(chain.n):
            links = [link for link in moving_links(chain) if link >= joint]
            for link in links if len(links) >= min_terms else ():
                words = {"joint": joint + 1, **link_words(chain, link)}
                yield MistakeVariant({"effects": scale_entries((joint, link), factor)}, words)

    return variants


def _keep_own_link(w: StageResults, effects: np.ndarray) -> np.ndarray:
    other_links = ~np.eye(w.n, w.n + 1, dtype=bool)
    return np.asarray(scale_entries(other_links, 0)(w, effects))


def _keep_last_link(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    links = moving_links(chain)
    if len(links) > 1:
        yield MistakeVariant({"effects": scale_entries((slice(None), links[:-1]), 0)})


def _mirror_effects(w: StageResults, joint: int) -> np.ndarray:
    """Return the effects of a joint on the links, (n + 1, 3, …), with the angles of its run negated.

    The run consists of the consecutive parallel joints that the joint belongs to. An effect is the derivative of a
    link's vector with respect to the joint's variable.
    """
    first = first_joint_of_run(w.chain, joint)
    run = [i for i in range(w.n) if first_joint_of_run(w.chain, i) == first and w["kinds"][i] == "R"]

    def mirror(_: StageResults, table: Table) -> Table:
        rows = (replace(row, theta=-row.theta) if i in run else row for i, row in enumerate(table.rows))
        return replace(table, rows=tuple(rows))

    return np.asarray(w.without_changes_of("effects").with_mistakes({"table": mirror})["effects"][joint])


def _flip_derivative(sign: int) -> VariantGenerator:
    def apply_change(w: StageResults, effects: np.ndarray) -> np.ndarray:
        kinds = w["kinds"]
        return np.stack([sign * _mirror_effects(w, i) if kinds[i] == "R" else effects[i] for i in range(w.n)])

    return variants_if(lambda chain: joints_of_kind(chain, "R"), {"effects": apply_change})


def _skip_differentiation(w: StageResults, effects: np.ndarray) -> np.ndarray:
    new_effects, links = np.array(effects), w.arithmetic.drop_derivatives(np.stack(w["links"]))
    for joint in range(w.n):
        if w["kinds"][joint] == "R":
            later_links = [k for k in links_to_point(w.chain) if k >= joint]
            new_effects[joint, later_links] = links[later_links]
    return new_effects


# --- propagation ---


def _propagated_variants(changes: Mapping[str, Change], names_axis: bool = False) -> VariantGenerator:
    """Return a function that yields one variant, in which the linear rows are propagated after the changes.

    If `names_axis`, the message names frame i and axis i.
    """

    def variants(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        yield propagated_variant(changes, _axis_words(chain) if names_axis else {})

    return variants


def _axis_words(chain: Chain) -> dict[str, object]:
    """Return the names of the axis of joint i and of the frame on this axis, in the arm's convention."""
    convention = convention_of(chain)
    return {"frame": convention.frame_index, "axis": convention.plain_axis}


def _shift_to_next(w: StageResults, vectors: np.ndarray) -> np.ndarray:
    return np.concatenate([vectors[1:], vectors[-1:]])


def _shift_to_previous(w: StageResults, vectors: np.ndarray) -> np.ndarray:
    return np.concatenate([vectors[:1], vectors[:-1]])


def _start_arms_one_frame_earlier(w: StageResults, arms: np.ndarray) -> np.ndarray:
    return np.concatenate([w["point"][None] - w["origins"][:1], arms[:-1]])


def _use_next_axis(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    yield propagated_variant({"axes": _shift_to_next}, _axis_words(chain))
    products: Change = lambda w, _: [cross(w["axes"][i + 1], w["arms"][i]) for i in range(w.n)]  # noqa: E731
    yield propagated_variant({"products": products}, _axis_words(chain))


def _start_at_other_origin(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i, j in permutations(range(chain.n), 2):

        def apply_change(w: StageResults, arms: np.ndarray, i: int = i, j: int = j) -> np.ndarray:
            return np.stack([arms[j] if k == i else arm for k, arm in enumerate(arms)])

        frame, other_frame = (convention_of(chain).frame_on_axis(joint + 1) for joint in (i, j))
        yield MistakeVariant({"arms": apply_change}, {"joint": i + 1, "frame": frame, "other": other_frame})


def _stop_at_next_origin(w: StageResults, arms: np.ndarray) -> np.ndarray:
    links = w.arithmetic.drop_derivatives(np.stack(w["links"]))
    return np.stack([*links[: w.n], arms[-1]])


def _treat_as(wrong_kind: str, correct_kind: str) -> VariantGenerator:
    def treat(treated_joints: Sequence[int]) -> MistakeVariant:
        def apply_change(w: StageResults, correct_kinds: list[str]) -> list[str]:
            return [wrong_kind if i in treated_joints else kind for i, kind in enumerate(correct_kinds)]

        return propagated_variant({"kinds": apply_change}, joint_words(treated_joints))

    return lambda chain, shape: vary_each_joint_and_all(joints_of_kind(chain, correct_kind), treat)


def _replace_angular(
    new_column: Callable[[StageResults, int, np.ndarray], np.ndarray], words: Mapping[str, object]
) -> MistakeVariant:
    """Return the variant in which each joint's column of the angular rows is replaced."""

    def apply_change(w: StageResults, angular: np.ndarray) -> np.ndarray:
        return np.stack([new_column(w, i, angular[:, i]) for i in range(w.n)], axis=1)

    return MistakeVariant({"angular": apply_change}, words)


def _rotate_prismatic_joints(joints: Sequence[int]) -> MistakeVariant:
    """Return the variant that gives prismatic joints an angular velocity."""
    return _replace_angular(lambda w, i, column: w["axes"][i] if i in joints else column, joint_words(joints))


def _rotate_one_prismatic_joint(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i in joints_of_kind(chain, "P"):
        yield _rotate_prismatic_joints([i])


def _rotate_all_prismatic_joints(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    prismatic_joints = joints_of_kind(chain, "P")
    if len(prismatic_joints) > 1:
        yield _rotate_prismatic_joints(prismatic_joints)


def _drop_angular(joints: Sequence[int]) -> MistakeVariant:
    return _replace_angular(lambda w, i, column: 0 * column if i in joints else column, joint_words(joints))


def _keep_one_angular(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    revolute_joints = joints_of_kind(chain, "R")
    for i in revolute_joints if len(revolute_joints) > 2 else ():
        yield replace(_drop_angular([k for k in range(chain.n) if k != i]), words=joint_words([i]))


def _use_next_angular(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    yield _replace_angular(
        lambda w, i, column: column if w["kinds"][i] == "P" else w["axes"][i + 1], _axis_words(chain)
    )


def _use_tool_frame(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def rotate(w: StageResults, vectors: np.ndarray) -> np.ndarray:
        rotation = w["last rotation"].swapaxes(0, 1)
        return np.stack([apply_matrix(rotation, vectors[:, i]) for i in range(vectors.shape[1])], axis=1)

    # In questions about the last frame, the vectors need not be rotated again.
    yield MistakeVariant({"linear": rotate, "angular": rotate, "tool jacobian": _leave_in_base(slice(0, 6))})
    axes: Change = lambda w, axes: rotate(w, axes.swapaxes(0, 1)).swapaxes(0, 1)  # noqa: E731
    yield MistakeVariant({"axes": axes, "tool jacobian": _leave_in_base(slice(3, 6))})


def _use_local_axes(w: StageResults, axes: np.ndarray) -> np.ndarray:
    """Return (0, 0, 1) for every joint axis: its coordinates in the frame on this axis."""
    local_axis = np.stack([w.arithmetic.constant(sp.Integer(value)) for value in (0, 0, 1)])
    return np.stack([local_axis] * len(axes))


def _rotations_on_axes(w: StageResults) -> list[np.ndarray]:
    """Return the rotations of the frames on the joint axes, with the last repeated if there is no next frame."""
    frames = [convention_of(w.chain).frame_on_axis(joint) for joint in range(1, w.n + 2)]
    return [convention_rotation(w, min(frame, w.n)) for frame in frames]


def _use_x_or_y_axes(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for axis in "xy":
        yield propagated_variant({"axes": _take_frame_axis(axis, range(chain.n + 1))}, {"axis": axis})


def _use_x_or_y_axis_once(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for axis, i in product("xy", range(chain.n)):
        yield propagated_variant({"axes": _take_frame_axis(axis, [i])}, {"axis": axis, "joint": i + 1})


def _take_frame_axis(axis: str, joints: Sequence[int]) -> Change:
    def apply_change(w: StageResults, axes: np.ndarray) -> np.ndarray:
        columns = [rotation[:, "xy".index(axis)] for rotation in _rotations_on_axes(w)]
        return np.stack([column if i in joints else axes[i] for i, column in enumerate(columns)])

    return apply_change


def _flip_axis(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i in range(chain.n):
        yield propagated_variant({"axes": scale_entries(i, -1)}, {"joint": i + 1})


def _drop_joint(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants that omit the contribution of one joint to the velocities."""
    for i in range(chain.n) if chain.n > 1 else ():
        drop = scale_entries((slice(None), i), 0)
        yield MistakeVariant({"linear": drop, "angular": drop}, {"joint": i + 1})


def _exchange_arms(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i, j in combinations(range(chain.n), 2):
        yield propagated_variant({"arms": exchange(i, j)}, {"joint": i + 1, "other": j + 1})


def _leave_vectors_in_base(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants that leave the vectors of J, or only the linear or angular ones, in the base frame.

    They change only questions that ask for another frame.
    """
    for words, rows in (("vectors", slice(0, 6)), ("angular vectors", slice(3, 6)), ("linear vectors", slice(0, 3))):
        yield MistakeVariant({"tool jacobian": _leave_in_base(rows)}, {"vectors": words})
    yield MistakeVariant({"wrist block": lambda w, _: np.moveaxis(w["axes"][3:6], 0, 1)}, {"vectors": "vectors"})


def _leave_in_base(rows: slice) -> Change:
    """Return the change that leaves the given rows of the Jacobian in base coordinates instead of tool coordinates."""

    def apply_change(w: StageResults, rotated: np.ndarray) -> np.ndarray:
        unrotated = np.array(rotated)
        unrotated[rows] = w["geometric"][rows]
        return unrotated

    return apply_change


def _use_earlier_frame(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    def rotate(w: StageResults, _: np.ndarray, frame: int) -> np.ndarray:
        return rotate_rows(convention_rotation(w, frame).swapaxes(0, 1), w["geometric"])

    for frame in range(1, chain.n):
        yield MistakeVariant({"tool jacobian": partial(rotate, frame=frame)}, {"frame": frame})


def _use_other_velocity(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the velocity of another frame, or with the velocity of P due to the first joints only."""

    def replace_by_frame_velocity(w: StageResults, velocity: np.ndarray, frame: int) -> np.ndarray:
        if not w.depends_on("joint rates"):
            return velocity
        try:
            inner = w if frame == w.n else w.for_first_joints(frame)
            stage = "tool jacobian" if w.depends_on("tool jacobian") else "geometric"
            return apply_matrix(inner[stage], w["joint rates"][:frame])[:, None]
        except IndexError:  # a joint is after the frame
            return velocity

    def replace_by_partial_velocity(w: StageResults, velocity: np.ndarray, last_joint: int) -> np.ndarray:
        if not w.depends_on("joint rates"):
            return velocity
        return apply_matrix(w["geometric"][:, :last_joint], w["joint rates"][:last_joint])[:, None]

    last_frame_words = "the last frame" if convention_of(chain).point.is_origin else "the point"
    for frame in range(1, chain.n + 1) if shape == (6, 1) else ():
        words = {"frame": "another frame" if frame < chain.n else last_frame_words}
        yield MistakeVariant({RESULT: partial(replace_by_frame_velocity, frame=frame)}, words)
        if frame < chain.n:
            yield MistakeVariant(
                {RESULT: partial(replace_by_partial_velocity, last_joint=frame)}, {"frame": "the point"}
            )


VARIANTS: dict[str, VariantGenerator] = {
    "chain-rule": _scale_term(0, min_terms=2),
    "joint-left-out": _drop_joint,
    "own-link-only": single_variant({"effects": _keep_own_link}),
    "last-link-only": _keep_last_link,
    "term-sign": _scale_term(-1, min_terms=1),
    "derivative-of-cosine": _flip_derivative(-1),
    "derivative-of-sine": _flip_derivative(1),
    "not-differentiated": single_variant({"effects": _skip_differentiation}),
    "next-axis": _use_next_axis,
    "next-arm": _propagated_variants({"arms": _shift_to_next}, names_axis=True),
    "next-frame": _propagated_variants({"axes": _shift_to_next, "arms": _shift_to_next}, names_axis=True),
    "previous-frame": _propagated_variants({"axes": _shift_to_previous, "arms": _start_arms_one_frame_earlier}),
    "previous-axis": _propagated_variants({"axes": _shift_to_previous}, names_axis=True),
    "cross-order": _propagated_variants({"products": lambda w, _: list(map(cross, w["arms"], w["axes"]))[: w.n]}),
    "no-cross-product": _propagated_variants({"products": lambda w, _: w["arms"]}),
    "arm-from-base": _propagated_variants({"arms": lambda w, arms: np.stack([w["point"]] * len(arms))}),
    "arm-from-other-origin": _start_at_other_origin,
    "arm-to-origin": _propagated_variants({"arms": lambda w, _: w["frames on axes"]}),
    "arm-reversed": _propagated_variants({"arms": lambda w, arms: -arms}),
    "arm-of-one-link": _propagated_variants({"arms": _stop_at_next_origin}),
    "prismatic-as-revolute": _treat_as("R", "P"),
    "revolute-as-prismatic": _treat_as("P", "R"),
    "slide-turns": _rotate_one_prismatic_joint,
    "no-angular-part": lambda chain, _: vary_each_joint_and_all(joints_of_kind(chain, "R"), _drop_angular),
    "slides-turn": _rotate_all_prismatic_joints,
    "angular-of-one-joint": _keep_one_angular,
    "angular-of-next-axis": _use_next_angular,
    "blocks-exchanged": single_variant({"geometric": lambda w, both: np.roll(both, 3, axis=0)}),
    "tool-frame": _use_tool_frame,
    "own-frames": _propagated_variants({"axes": _use_local_axes}),
    "wrong-axis": _use_x_or_y_axes,
    "wrong-axis-of-joint": _use_x_or_y_axis_once,
    "row-of-rotation": _propagated_variants(
        {"axes": lambda w, _: np.stack([turn[2] for turn in _rotations_on_axes(w)])}
    ),
    "axis-sign": _flip_axis,
    "rows-not-turned": _leave_vectors_in_base,
    "turned-the-wrong-way": single_variant(
        {
            "tool jacobian": lambda w, _: rotate_rows(w["last rotation"], w["geometric"]),
        }
    ),
    "frame-before": _use_earlier_frame,
    "velocity-of-other-frame": _use_other_velocity,
    "arms-exchanged": _exchange_arms,
}
