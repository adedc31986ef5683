"""Mistakes in the columns of a Jacobian: by differentiation (6.3) and by propagation (6.9 to 6.12)."""

from collections.abc import Iterator, Mapping, Sequence
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
    Table,
    Working,
    convention_rotation,
    links_to_point,
    rotate_rows,
)
from qdot.exercises.mistakes.base import (
    AnswerShape,
    Mistake,
    MistakeVariant,
    VariantGenerator,
    exchange,
    propagated_variant,
    restrict_to_tables,
    scale_entries,
    single_variant,
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


def _keep_own_link(w: Working, effects: np.ndarray) -> np.ndarray:
    other_links = ~np.eye(w.n, w.n + 1, dtype=bool)
    return np.asarray(scale_entries(other_links, 0)(w, effects))


def _keep_last_link(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    links = moving_links(chain)
    if len(links) > 1:
        yield MistakeVariant({"effects": scale_entries((slice(None), links[:-1]), 0)})


def _mirror_effects(w: Working, joint: int) -> np.ndarray:
    """Return the effects of a joint on the links, (n + 1, 3, …), with the angles of its run negated.

    The run consists of the consecutive parallel joints that the joint belongs to. An effect is the derivative of a
    link's vector with respect to the joint's variable.
    """
    run = [
        i
        for i in range(w.n)
        if first_joint_of_run(w.chain, i) == first_joint_of_run(w.chain, joint) and w["kinds"][i] == "R"
    ]

    def mirror(_: Working, table: Table) -> Table:
        rows = (replace(row, theta=-row.theta) if i in run else row for i, row in enumerate(table.rows))
        return replace(table, rows=tuple(rows))

    return np.asarray(w.without_changes_of("effects").with_mistakes({"table": mirror})["effects"][joint])


def _flip_derivative(sign: int) -> VariantGenerator:
    def apply_change(w: Working, effects: np.ndarray) -> np.ndarray:
        revolute_joints = [i for i in range(w.n) if w["kinds"][i] == "R"]
        return np.stack([sign * _mirror_effects(w, i) if i in revolute_joints else effects[i] for i in range(w.n)])

    return lambda chain, shape: iter(
        [MistakeVariant({"effects": apply_change})] if any(joint.kind == "R" for joint in chain.joints) else []
    )


def _skip_differentiation(w: Working, effects: np.ndarray) -> np.ndarray:
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


def _shift_to_next(w: Working, vectors: np.ndarray) -> np.ndarray:
    return np.concatenate([vectors[1:], vectors[-1:]])


def _shift_to_previous(w: Working, vectors: np.ndarray) -> np.ndarray:
    return np.concatenate([vectors[:1], vectors[:-1]])


def _use_next_axis(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    yield propagated_variant({"axes": _shift_to_next}, _axis_words(chain))
    products: Change = lambda w, _: [cross(w["axes"][i + 1], w["arms"][i]) for i in range(w.n)]  # noqa: E731
    yield propagated_variant({"products": products}, _axis_words(chain))


def _start_at_other_origin(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i, j in permutations(range(chain.n), 2):

        def apply_change(w: Working, arms: np.ndarray, i: int = i, j: int = j) -> np.ndarray:
            return np.stack([arms[j] if k == i else arm for k, arm in enumerate(arms)])

        frame, other_frame = (convention_of(chain).frame_on_axis(joint + 1) for joint in (i, j))
        yield MistakeVariant({"arms": apply_change}, {"joint": i + 1, "frame": frame, "other": other_frame})


def _stop_at_next_origin(w: Working, arms: np.ndarray) -> np.ndarray:
    links = w.arithmetic.drop_derivatives(np.stack(w["links"]))
    return np.stack([*links[: w.n], arms[-1]])


def _joints_of_kind(chain: Chain, kind: str) -> list[int]:
    return [i for i, joint in enumerate(chain.joints) if joint.kind == kind]


def _joint_words(joints: Sequence[int]) -> dict[str, object]:
    """Return the numbers of joints, from 1."""
    return {"joint": " and ".join(str(i + 1) for i in joints)}


def _treat_as(wrong_kind: str, correct_kind: str) -> VariantGenerator:
    def treat(treated_joints: Sequence[int]) -> MistakeVariant:
        def apply_change(w: Working, correct_kinds: list[str]) -> list[str]:
            return [wrong_kind if i in treated_joints else kind for i, kind in enumerate(correct_kinds)]

        return propagated_variant({"kinds": apply_change}, _joint_words(treated_joints))

    return lambda chain, shape: vary_each_joint_and_all(_joints_of_kind(chain, correct_kind), treat)


def _rotate_prismatic_joints(joints: Sequence[int]) -> MistakeVariant:
    """Return the variant that gives prismatic joints an angular velocity."""

    def apply_change(w: Working, angular: np.ndarray) -> np.ndarray:
        return np.stack([w["axes"][i] if i in joints else angular[:, i] for i in range(w.n)], axis=1)

    return MistakeVariant({"angular": apply_change}, _joint_words(joints))


def _rotate_one_prismatic_joint(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i in _joints_of_kind(chain, "P"):
        yield replace(_rotate_prismatic_joints([i]), words={"joint": i + 1})


def _rotate_all_prismatic_joints(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    prismatic_joints = _joints_of_kind(chain, "P")
    if len(prismatic_joints) > 1:
        yield _rotate_prismatic_joints(prismatic_joints)


def _drop_angular(joints: Sequence[int]) -> MistakeVariant:
    def apply_change(w: Working, angular: np.ndarray) -> np.ndarray:
        return np.stack([0 * angular[:, i] if i in joints else angular[:, i] for i in range(w.n)], axis=1)

    return MistakeVariant({"angular": apply_change}, _joint_words(joints))


def _keep_one_angular(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    revolute_joints = _joints_of_kind(chain, "R")
    for i in revolute_joints if len(revolute_joints) > 2 else ():
        yield replace(_drop_angular([k for k in range(chain.n) if k != i]), words={"joint": i + 1})


def _use_next_angular(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def apply_change(w: Working, angular: np.ndarray) -> np.ndarray:
        return np.stack([angular[:, k] if w["kinds"][k] == "P" else w["axes"][k + 1] for k in range(w.n)], axis=1)

    yield MistakeVariant({"angular": apply_change}, _axis_words(chain))


def _use_tool_frame(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def rotate(w: Working, vectors: np.ndarray) -> np.ndarray:
        rotation = w["last rotation"].swapaxes(0, 1)
        return np.stack([apply_matrix(rotation, vectors[:, i]) for i in range(vectors.shape[1])], axis=1)

    # In questions about the last frame, the vectors need not be rotated again.
    yield MistakeVariant({"linear": rotate, "angular": rotate, "tool jacobian": _leave_in_base(slice(0, 6))})
    axes: Change = lambda w, axes: rotate(w, axes.swapaxes(0, 1)).swapaxes(0, 1)  # noqa: E731
    yield MistakeVariant({"axes": axes, "tool jacobian": _leave_in_base(slice(3, 6))})


def _use_local_axes(w: Working, axes: np.ndarray) -> np.ndarray:
    """Return (0, 0, 1) for every joint axis: its coordinates in the frame on this axis."""
    local_axis = np.stack([w.arithmetic.constant(sp.Integer(value)) for value in (0, 0, 1)])
    return np.stack([local_axis] * len(axes))


def _rotations_on_axes(w: Working) -> list[np.ndarray]:
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
    def apply_change(w: Working, axes: np.ndarray) -> np.ndarray:
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

    def apply_change(w: Working, rotated: np.ndarray) -> np.ndarray:
        unrotated = np.array(rotated)
        unrotated[rows] = w["geometric"][rows]
        return unrotated

    return apply_change


def _use_earlier_frame(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    def rotate(w: Working, _: np.ndarray, frame: int) -> np.ndarray:
        return rotate_rows(convention_rotation(w, frame).swapaxes(0, 1), w["geometric"])

    for frame in range(1, chain.n):
        yield MistakeVariant({"tool jacobian": partial(rotate, frame=frame)}, {"frame": frame})


def _use_other_velocity(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the velocity of another frame, or with the velocity of P due to the first joints only."""

    def replace_by_frame_velocity(w: Working, velocity: np.ndarray, frame: int) -> np.ndarray:
        if not w.depends_on("joint rates"):
            return velocity
        try:
            inner = w if frame == w.n else w.for_first_joints(frame)
            stage = "tool jacobian" if w.depends_on("tool jacobian") else "geometric"
            return apply_matrix(inner[stage], w["joint rates"][:frame])[:, None]
        except IndexError:  # a joint is after the frame
            return velocity

    def replace_by_partial_velocity(w: Working, velocity: np.ndarray, last_joint: int) -> np.ndarray:
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


_ALL_MISTAKES = (
    Mistake("chain-rule", "Contribution missing from the chain rule",
            "Column {joint} seems to lack the contribution of link {link}. Joint {joint} moves every link after it.",
            "6.3", _scale_term(0, min_terms=2)),
    Mistake("joint-left-out", "Joint left out",
            "You seem to have left out the contribution of joint {joint}. Every joint that moves the point counts.",
            "6.4",
            _drop_joint, rare=True),
    Mistake("own-link-only", "Each joint moves its own link only",
            "Each of your columns seems to contain only the link of its own joint. A joint moves every link after it.",
            "6.3",
            single_variant({"effects": _keep_own_link})),
    Mistake("last-link-only", "Only the last link counted",
            "Your columns seem to contain only the last link. A joint moves every link after it.",
            "6.3", _keep_last_link),
    Mistake("term-sign", "Term of a column with the wrong sign",
            "In column {joint}, the contribution of link {link} seems to have the wrong sign. Differentiate it again.",
            "6.3",
            _scale_term(-1, min_terms=1)),
    Mistake("derivative-of-cosine", "Derivatives of sine and cosine with the wrong sign",
            "You seem to have made a sign error when you differentiated sines and cosines. Check the derivative of "
            "the cosine.", "6.3", _flip_derivative(-1)),
    Mistake("derivative-of-sine", "Derivative of the sine with the wrong sign",
            "You seem to have made a sign error when you differentiated sines and cosines. Check the derivative of "
            "the sine.", "6.3", _flip_derivative(1)),
    Mistake("not-differentiated", "Not differentiated",
            "You seem to have used the sines and cosines of the position unchanged in the Jacobian. Differentiate "
            "them.", "6.3", single_variant({"effects": _skip_differentiation})),
    Mistake("next-axis", "Axis of the next joint",
            "You seem to have used the axes of the next joints. Joint i rotates about, or moves along, {axis}.",
            "6.9 and 6.10", _use_next_axis),
    Mistake("next-arm", "p* of the next joint",
            "Your vectors p* seem to start one origin too late. For joint i, p* starts at the origin of frame {frame}.",
            "6.12", _propagated_variants({"arms": _shift_to_next}, names_axis=True)),
    Mistake("next-frame", "Frame of the next joint",
            "In each column, you seem to have used the axis and the vector of the next joint. Joint i belongs to "
            "frame {frame}.",
            "6.12", _propagated_variants({"axes": _shift_to_next, "arms": _shift_to_next}, names_axis=True)),
    Mistake("previous-frame", "Frame before a joint, as in the standard table",
            "In each column, you seem to have used the axis and the vector of frame i-1. In a modified table, frame i "
            "is on the axis of joint i.", "6.12",
            _propagated_variants({
                    "axes": _shift_to_previous,
                    "arms": lambda w, arms: np.concatenate([w["point"][None] - w["origins"][:1], arms[:-1]]),
                }), rare=True),
    Mistake("previous-axis", "Axis of the previous joint",
            "You seem to have used the axes of the previous joints. Joint i rotates about, or moves along, {axis}.",
            "6.9 and 6.10", _propagated_variants({"axes": _shift_to_previous}, names_axis=True), rare=True),
    Mistake("cross-order", "Cross product in the wrong order",
            "You seem to have taken the cross products in the wrong order. Note that a x b is minus b x a.", "6.12",
            _propagated_variants({"products": lambda w, _: [cross(w["arms"][i], w["axes"][i]) for i in range(w.n)]})),
    Mistake("no-cross-product", "Cross product left out",
            "You seem to have used p* itself as the linear part of a revolute joint's column. Take its cross product "
            "with the axis.",
            "6.12", _propagated_variants({"products": lambda w, _: w["arms"]})),
    Mistake("arm-from-base", "Vector from the base instead of p*",
            "All of your vectors p* seem to start at the base. Each one starts at the origin of its own joint's frame.",
            "6.13", _propagated_variants({"arms": lambda w, arms: np.stack([w["point"]] * len(arms))})),
    Mistake("arm-from-other-origin", "One vector p* from another origin",
            "Your vector p* of joint {joint} seems to start at O{other}. For this joint, it starts at the origin of "
            "frame {frame}.", "6.13", _start_at_other_origin, rare=True),
    Mistake("arm-to-origin", "Vector to the joint instead of p*",
            "Your vectors p* seem to run from the base to the joints. They run from the joints to the point.", "6.13",
            _propagated_variants({"arms": lambda w, _: w["frames on axes"]}), rare=True),
    Mistake("arm-reversed", "p* reversed",
            "Your vectors p* seem to run from the point to the joints. Check their direction.", "6.13",
            _propagated_variants({"arms": lambda w, arms: -arms})),
    Mistake("arm-of-one-link", "p* of one link only",
            "Your vectors p* seem to end at the next origin. They end at the point.", "6.13",
            _propagated_variants({"arms": _stop_at_next_origin})),
    Mistake("prismatic-as-revolute", "Prismatic joint treated as revolute",
            "You seem to have treated joint {joint} as revolute. It is prismatic and moves along its axis.",
            "6.12", _treat_as("R", "P")),
    Mistake("revolute-as-prismatic", "Revolute joint treated as prismatic",
            "You seem to have treated joint {joint} as prismatic. It is revolute and rotates about its axis.",
            "6.12", _treat_as("P", "R"),
            rare=True),
    Mistake("slide-turns", "Angular part for a prismatic joint",
            "Joint {joint} is prismatic, but seems to have an angular part in your answer. A prismatic joint does not "
            "rotate the links after it.", "6.11", _rotate_one_prismatic_joint),
    Mistake("no-angular-part", "Angular part left out",
            "You seem to have left out the angular part of joint {joint}. A revolute joint rotates all links after it.",
            "6.10", lambda chain, _: vary_each_joint_and_all(_joints_of_kind(chain, "R"), _drop_angular)),
    Mistake("slides-turn", "Angular parts for prismatic joints",
            "Joints {joint} are prismatic, but seem to have an angular part in your answer. A prismatic joint does "
            "not rotate the links after it.",
            "6.11", _rotate_all_prismatic_joints, rare=True),
    Mistake("angular-of-one-joint", "Angular part of one joint only",
            "Only joint {joint} seems to have an angular part in your answer. Every revolute joint rotates all links "
            "after it.",
            "6.10", _keep_one_angular, rare=True),
    Mistake("angular-of-next-axis", "Axis of the next joint in the angular rows",
            "In the angular rows, you seem to have used the axes of the next joints. Joint i rotates about {axis}.",
            "6.10",
            _use_next_angular, rare=True),
    Mistake("blocks-exchanged", "Linear and angular rows exchanged",
            "You seem to have exchanged the linear and the angular rows. The linear rows come first.", "6.6",
            single_variant({"geometric": lambda w, both: np.roll(both, 3, axis=0)}), rare=True),
    Mistake("tool-frame", "Tool frame instead of base frame",
            "Your vectors seem to be in the coordinates of the last frame. Express them in the base frame.", "6.11",
            _use_tool_frame),
    Mistake("own-frames", "Axes in the coordinates of their own frames",
            "You seem to have used (0, 0, 1), the axis in its own frame, for every joint. Express all axes in the "
            "same frame.", "below 6.10", _propagated_variants({"axes": _use_local_axes}), rare=True),
    Mistake("wrong-axis", "x or y axis instead of z axis",
            "You seem to have used the {axis} axes of the frames. Joints rotate about, or move along, the z axes.",
            "below 6.10",
            _use_x_or_y_axes, rare=True),
    Mistake("wrong-axis-of-joint", "x or y axis instead of z axis, for one joint",
            "For joint {joint}, you seem to have used the {axis} axis of the frame. Joints rotate about, or move "
            "along, the z axes.", "below 6.10", _use_x_or_y_axis_once, rare=True),
    Mistake("row-of-rotation", "Row of the rotation matrix instead of its column",
            "You seem to have used the last rows of the rotation matrices as the axes. The axes are the last columns.",
            "below 6.10",
            _propagated_variants({"axes": lambda w, _: np.stack([rotation[2] for rotation in _rotations_on_axes(w)])}),
            rare=True),
    Mistake("axis-sign", "Axis with the wrong sign",
            "The axis of joint {joint} seems to point in the wrong direction. Check its sign.",
            "below 6.10", _flip_axis, rare=True),
    Mistake("rows-not-turned", "Vectors left in the base frame",
            "You seem to have left the {vectors} in the base frame. Express all of them in the frame that the "
            "question asks for.",
            "6.11", _leave_vectors_in_base, rare=True),
    Mistake("turned-the-wrong-way", "Multiplied by the rotation matrix instead of its transpose",
            "You seem to have multiplied the vectors by the rotation matrix of the frame that is asked for. Its "
            "transpose takes vectors into that frame.", "6.11",
            single_variant({"tool jacobian": lambda w, _: rotate_rows(w["last rotation"], w["geometric"])}), rare=True),
    Mistake("frame-before", "Another frame instead of the tool frame",
            "Your vectors seem to be in the coordinates of frame {frame}. The question asks for another frame.", "6.11",
            _use_earlier_frame, rare=True),
    Mistake("velocity-of-other-frame", "Velocity of another frame",
            "You seem to have given the velocity of {frame}. Check which frame's origin the question asks for. Only "
            "the joints before that frame move it.", "6.9 and 6.10", _use_other_velocity, rare=True),
    Mistake("arms-exchanged", "Vectors p* exchanged",
            "You seem to have exchanged the vectors p* of joints {joint} and {other}.",
            "6.13", _exchange_arms, rare=True),
)  # fmt: skip

FRAME_MISTAKES = frozenset({
    "next-arm", "next-frame", "previous-frame", "arm-from-base", "arm-from-other-origin", "arm-to-origin",
    "arm-reversed", "arm-of-one-link", "no-cross-product", "tool-frame", "own-frames", "wrong-axis",
    "wrong-axis-of-joint", "row-of-rotation", "velocity-of-other-frame", "arms-exchanged", "rows-not-turned",
    "turned-the-wrong-way", "frame-before", "blocks-exchanged",
})  # fmt: skip
"""The mistakes that involve frames on the links, or vectors from their origins.

Mistakes that involve screws are in `screws`."""
MISTAKES = restrict_to_tables(_ALL_MISTAKES, FRAME_MISTAKES)
