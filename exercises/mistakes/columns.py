"""Mistakes in the columns of a Jacobian: by differentiation (6.3) and by propagation (6.9 to 6.12)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, permutations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import applied, cross
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation_graph import (
    RESULT,
    Change,
    Table,
    Working,
    carried,
    propagated,
    told_rotation,
    turned_rows,
)
from qdot.exercises.mistakes.base import Mistake, Shape, Slip, at_each_and_all, of_frames
from qdot.exercises.mistakes.position import run_start

# --- differentiation ---


def _lengths(chain: Chain) -> list[int]:
    """Return the links that have a length and lead to the point."""
    joints = chain.joints
    has = [k for k in range(chain.n) if joints[k].kind == "P" or (joints[k].a, joints[k].d) != (0, 0)]
    return [k for k in carried(chain) if k in has or (k == chain.n and not chain.point.is_origin)]


def _effect(joint: int, links: list[int], factor: int) -> Change:
    def changed(w: Working, effects: np.ndarray) -> np.ndarray:
        out = np.array(effects)
        out[joint, links] = factor * out[joint, links]
        return out

    return changed


def _names(chain: Chain, joint: int, link: int) -> dict[str, object]:
    return {"joint": joint + 1, "link": chain.point.frame if link == chain.n else link + 1}


def _chain_rule(chain: Chain, _: Shape) -> Iterator[Slip]:
    for joint in range(chain.n):
        for link in _lengths(chain):
            if link >= joint and len([k for k in _lengths(chain) if k >= joint]) > 1:
                yield Slip({"effects": _effect(joint, [link], 0)}, _names(chain, joint, link))


def _own_link_only(chain: Chain, _: Shape) -> Iterator[Slip]:
    def changed(w: Working, effects: np.ndarray) -> np.ndarray:
        out = np.array(effects)
        for joint in range(w.n):
            others = [k for k in range(w.n + 1) if k != joint]
            out[joint, others] = 0 * out[joint, others]
        return out

    yield Slip({"effects": changed})


def _last_link_only(chain: Chain, _: Shape) -> Iterator[Slip]:
    links = _lengths(chain)

    def changed(w: Working, effects: np.ndarray) -> np.ndarray:
        out = np.array(effects)
        out[:, links[:-1]] = 0 * out[:, links[:-1]]
        return out

    if len(links) > 1:
        yield Slip({"effects": changed})


def _term_sign(chain: Chain, _: Shape) -> Iterator[Slip]:
    for joint in range(chain.n):
        for link in _lengths(chain):
            if link >= joint:
                yield Slip({"effects": _effect(joint, [link], -1)}, _names(chain, joint, link))


def _mirrored(w: Working, joint: int) -> np.ndarray:
    """Return what a joint does to the links where the angles of its run are counted the other way, (n + 1, 3, …)."""
    run = [i for i in range(w.n) if run_start(w.chain, i) == run_start(w.chain, joint)]

    def turned(_: Working, table: Table) -> Table:
        kinds = w["kinds"]
        rows = (
            replace(row, theta=-row.theta) if i in run and kinds[i] == "R" else row for i, row in enumerate(table.rows)
        )
        return replace(table, rows=tuple(rows))

    return np.asarray(w.without("effects").but({"table": turned})["effects"][joint])


def _derivative_of(sign: int) -> Callable[[Chain, Shape], Iterator[Slip]]:
    def slips(chain: Chain, _: Shape) -> Iterator[Slip]:
        def changed(w: Working, effects: np.ndarray) -> np.ndarray:
            turning = [i for i in range(w.n) if w["kinds"][i] == "R"]
            return np.stack([sign * _mirrored(w, i) if i in turning else effects[i] for i in range(w.n)])

        if any(joint.kind == "R" for joint in chain.joints):
            yield Slip({"effects": changed})

    return slips


def _not_differentiated(chain: Chain, _: Shape) -> Iterator[Slip]:
    def changed(w: Working, effects: np.ndarray) -> np.ndarray:
        out = np.array(effects)
        links = w.arithmetic.value(np.stack(w["links"]))
        for joint in range(w.n):
            if w["kinds"][joint] == "R":
                behind = [k for k in carried(w.chain) if k >= joint]
                out[joint, behind] = links[behind]
        return out

    yield Slip({"effects": changed})


def _both_factors(chain: Chain, shape: Shape) -> Iterator[Slip]:
    """Differentiate the length of a slide and its direction at once, where a velocity is asked for."""
    for j in [i for i, joint in enumerate(chain.joints) if joint.kind == "P"] if shape[1] == 1 else ():

        def changed(w: Working, effects: np.ndarray, j: int = j) -> np.ndarray:
            def longer(w: Working, table: Table) -> Table:
                return table.with_row(j, d=table.rows[j].d + w.arithmetic.stepped(sp.S.One))

            right, out = w.without("effects"), np.array(effects)
            direction = right.but({"table": longer})["effects"][:, j] - right["effects"][:, j]
            out[:, j] = effects[:, j] + direction * (w["joint rates"][j] - w.arithmetic.value(w["table"].rows[j].d))
            out[j, j] = 0 * effects[j, j]
            return out

        yield Slip({"effects": changed}, {"joint": j + 1})


# --- propagation ---


def _by_products(change: Callable[[Working, int], np.ndarray], words: dict[str, object] | None = None) -> Slip:
    products = lambda w, right: [change(w, i) for i in range(w.n)]  # noqa: E731
    return Slip({"linear": propagated, "products": products}, words or {})


def _on_axis(chain: Chain) -> dict[str, object]:
    """Return what the frame on the axis of joint i and this axis are called in the convention of an arm."""
    convention = convention_of(chain)
    return {"frame": convention.frame_index, "axis": convention.plain_axis}


def _next_axis(chain: Chain, _: Shape) -> Iterator[Slip]:
    words = _on_axis(chain)
    yield Slip({"axes": lambda w, axes: np.concatenate([axes[1:], axes[-1:]]), "linear": propagated}, words)
    yield _by_products(lambda w, i: cross(w["axes"][i + 1], w["arms"][i]), words)


def _next_arm(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield Slip({"arms": lambda w, arms: np.concatenate([arms[1:], arms[-1:]]), "linear": propagated}, _on_axis(chain))


def _next_both(chain: Chain, _: Shape) -> Iterator[Slip]:
    def shifted(w: Working, right: np.ndarray) -> np.ndarray:
        return np.concatenate([right[1:], right[-1:]])

    yield Slip({"axes": shifted, "arms": shifted, "linear": propagated}, _on_axis(chain))


def _previous_both(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Take the frame before the joint, on whose axis the standard table has it, where a modified one has the next."""

    def arms(w: Working, right: np.ndarray) -> np.ndarray:
        return np.concatenate([w["point"][None] - w["origins"][:1], right[:-1]])

    if chain.n > 1:
        yield Slip({"axes": _before, "arms": arms, "linear": propagated})


def _before(w: Working, axes: np.ndarray) -> np.ndarray:
    return np.concatenate([axes[:1], axes[:-1]])


def _previous_axis(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield Slip({"axes": _before, "linear": propagated}, _on_axis(chain))


def _order(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield _by_products(lambda w, i: cross(w["arms"][i], w["axes"][i]))


def _no_product(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield _by_products(lambda w, i: w["arms"][i])


def _from_base(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield Slip({"arms": lambda w, arms: np.stack([w["point"]] * len(arms)), "linear": propagated})


def _to_origin(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield Slip({"arms": lambda w, _: w["frames on axes"], "linear": propagated})


def _from_other_origin(chain: Chain, _: Shape) -> Iterator[Slip]:
    for i, j in permutations(range(chain.n), 2):

        def changed(w: Working, arms: np.ndarray, i: int = i, j: int = j) -> np.ndarray:
            out = np.array(arms)
            out[i] = arms[j]
            return out

        frame, other = (convention_of(chain).frame_on_axis(joint + 1) for joint in (i, j))
        yield Slip({"arms": changed}, {"joint": i + 1, "frame": frame, "other": other})


def _reversed(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield Slip({"arms": lambda w, arms: -arms, "linear": propagated})


def _one_link(chain: Chain, _: Shape) -> Iterator[Slip]:
    def changed(w: Working, arms: np.ndarray) -> np.ndarray:
        links = w.arithmetic.value(np.stack(w["links"]))
        return np.stack([*links[: w.n], arms[-1]])

    yield Slip({"arms": changed, "linear": propagated})


def _as_revolute(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _taken_for(chain, "P", "R")


def _as_prismatic(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _taken_for(chain, "R", "P")


def _taken_for(chain: Chain, kind: str, other: str) -> Iterator[Slip]:
    def taken(joints: Sequence[int]) -> Slip:
        changed: Change = lambda w, kinds: [other if i in joints else kind for i, kind in enumerate(kinds)]  # noqa: E731
        return Slip({"kinds": changed, "linear": propagated}, {"joint": _listed(joints)})

    return at_each_and_all([i for i, joint in enumerate(chain.joints) if joint.kind == kind], taken)


def _listed(joints: Sequence[int]) -> str:
    """Return numbers of joints, from 1."""
    return " and ".join(str(i + 1) for i in joints)


def _turning_slides(chain: Chain, _: Shape) -> Iterator[Slip]:
    for i, joint in enumerate(chain.joints):
        if joint.kind == "P":
            yield Slip({"angular": _column(i, lambda w, i: w["axes"][i])}, {"joint": i + 1})


def _all_slides_turn(chain: Chain, _: Shape) -> Iterator[Slip]:
    slides = [i for i, joint in enumerate(chain.joints) if joint.kind == "P"]

    def changed(w: Working, angular: np.ndarray) -> np.ndarray:
        return np.stack([w["axes"][i] if i in slides else angular[:, i] for i in range(w.n)], axis=1)

    if len(slides) > 1:
        yield Slip({"angular": changed}, {"joint": _listed(slides)})


def _one_turns(chain: Chain, _: Shape) -> Iterator[Slip]:
    revolute = [i for i, joint in enumerate(chain.joints) if joint.kind == "R"]
    for i in revolute if len(revolute) > 2 else ():

        def changed(w: Working, angular: np.ndarray, i: int = i) -> np.ndarray:
            return np.stack([angular[:, k] if k == i else 0 * angular[:, k] for k in range(w.n)], axis=1)

        yield Slip({"angular": changed}, {"joint": i + 1})


def _next_turns(chain: Chain, _: Shape) -> Iterator[Slip]:
    def changed(w: Working, angular: np.ndarray) -> np.ndarray:
        turning = [k if w["kinds"][k] == "P" else min(k + 1, w.n) for k in range(w.n)]
        return np.stack([angular[:, k] if i == k else w["axes"][i] for k, i in enumerate(turning)], axis=1)

    yield Slip({"angular": changed}, _on_axis(chain))


def _column(joint: int, new: Callable[[Working, int], np.ndarray]) -> Change:
    def changed(w: Working, right: np.ndarray) -> np.ndarray:
        out = np.array(right)
        out[:, joint] = new(w, joint)
        return out

    return changed


def _not_turning(chain: Chain, _: Shape) -> Iterator[Slip]:
    def still(joints: Sequence[int]) -> Slip:
        def changed(w: Working, angular: np.ndarray) -> np.ndarray:
            return np.stack([0 * angular[:, i] if i in joints else angular[:, i] for i in range(w.n)], axis=1)

        return Slip({"angular": changed}, {"joint": _listed(joints)})

    return at_each_and_all([i for i, joint in enumerate(chain.joints) if joint.kind == "R"], still)


def _blocks(chain: Chain, _: Shape) -> Iterator[Slip]:
    yield Slip({"geometric": lambda w, both: np.concatenate([both[3:], both[:3]])})


def _in_tool_frame(chain: Chain, _: Shape) -> Iterator[Slip]:
    def seen(w: Working, vectors: np.ndarray) -> np.ndarray:
        turned = w["last rotation"].swapaxes(0, 1)
        return np.stack([applied(turned, vectors[:, i]) for i in range(vectors.shape[1])], axis=1)

    # Where that frame is asked for, they need not be turned again.
    yield Slip({"linear": seen, "angular": seen, "tool jacobian": _left_in_base(slice(0, 6))})
    axes: Change = lambda w, axes: seen(w, axes.swapaxes(0, 1)).swapaxes(0, 1)  # noqa: E731
    yield Slip({"axes": axes, "tool jacobian": _left_in_base(slice(3, 6))})


def _own_frame(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Every axis taken for (0, 0, 1), as each joint's own frame sees it."""

    def changed(w: Working, axes: np.ndarray) -> np.ndarray:
        up = [w.arithmetic.number(sp.Integer(value)) for value in (0, 0, 1)]
        return np.stack([np.stack(up)] * len(axes))

    if any(joint.alpha != 0 for joint in chain.joints):
        yield Slip({"axes": changed, "linear": propagated})


def _rotations_on_axes(w: Working) -> list[np.ndarray]:
    """Return the rotations of the frames on the joint axes, and that of the last one again where there is none."""
    numbers = [convention_of(w.chain).frame_on_axis(joint) for joint in range(1, w.n + 2)]
    return [told_rotation(w, min(number, w.n)) for number in numbers]


def _along_x(chain: Chain, _: Shape) -> Iterator[Slip]:
    for axis in "xy":
        yield Slip({"axes": _along(axis, range(chain.n + 1)), "linear": propagated}, {"axis": axis})


def _one_along_x(chain: Chain, _: Shape) -> Iterator[Slip]:
    for axis, i in product("xy", range(chain.n)):
        yield Slip({"axes": _along(axis, [i]), "linear": propagated}, {"axis": axis, "joint": i + 1})


def _along(axis: str, joints: Sequence[int]) -> Change:
    def changed(w: Working, axes: np.ndarray) -> np.ndarray:
        columns = [rotation[:, "xy".index(axis)] for rotation in _rotations_on_axes(w)]
        return np.stack([column if i in joints else axes[i] for i, column in enumerate(columns)])

    return changed


def _axis_row(chain: Chain, _: Shape) -> Iterator[Slip]:
    def rows(w: Working, _: np.ndarray) -> np.ndarray:
        return np.stack([rotation[2] for rotation in _rotations_on_axes(w)])

    if any(joint.alpha != 0 for joint in chain.joints):
        yield Slip({"axes": rows, "linear": propagated})


def _axis_sign(chain: Chain, _: Shape) -> Iterator[Slip]:
    for i in range(chain.n):

        def changed(w: Working, axes: np.ndarray, i: int = i) -> np.ndarray:
            out = np.array(axes)
            out[i] = -out[i]
            return out

        yield Slip({"axes": changed, "linear": propagated}, {"joint": i + 1})


def _joint_left_out(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Take a joint for one that does not move: what it adds to the velocities is missing."""
    for i in range(chain.n):

        def changed(w: Working, rows: np.ndarray, i: int = i) -> np.ndarray:
            out = np.array(rows)
            out[:, i] = 0 * out[:, i]
            return out

        if chain.n > 1:
            yield Slip({"linear": changed, "angular": changed}, {"joint": i + 1})


def _arms_exchanged(chain: Chain, _: Shape) -> Iterator[Slip]:
    for i, j in combinations(range(chain.n), 2):

        def changed(w: Working, arms: np.ndarray, i: int = i, j: int = j) -> np.ndarray:
            out = np.array(arms)
            out[[i, j]] = out[[j, i]]
            return out

        yield Slip({"arms": changed, "linear": propagated}, {"joint": i + 1, "other": j + 1})


def _tool_stage(change: Change) -> Callable[[Chain, Shape], Iterator[Slip]]:
    def slips(chain: Chain, _: Shape) -> Iterator[Slip]:
        yield Slip({"tool jacobian": change})

    return slips


def _not_turned(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Leave vectors as the base sees them where another frame is asked for: all of them, or one kind of rows."""
    for words, rows in (("vectors", slice(0, 6)), ("angular vectors", slice(3, 6)), ("linear vectors", slice(0, 3))):
        yield Slip({"tool jacobian": _left_in_base(rows)}, {"vectors": words})
    yield Slip({"wrist block": lambda w, _: np.moveaxis(w["axes"][3:6], 0, 1)}, {"vectors": "vectors"})


def _left_in_base(rows: slice) -> Change:
    """Return the change of the Jacobian in the last frame by which some rows are not turned into it."""

    def changed(w: Working, turned: np.ndarray) -> np.ndarray:
        out = np.array(turned)
        out[rows] = w["geometric"][rows]
        return out

    return changed


def _turned_the_other_way(w: Working, _: np.ndarray) -> np.ndarray:
    return turned_rows(w["last rotation"], w["geometric"])


def _frame_before(chain: Chain, shape: Shape) -> Iterator[Slip]:
    for frame in range(1, chain.n):

        def changed(w: Working, _: np.ndarray, frame: int = frame) -> np.ndarray:
            return turned_rows(told_rotation(w, frame).swapaxes(0, 1), w["geometric"])

        yield Slip({"tool jacobian": changed}, {"frame": frame})


def _other_frames_velocity(chain: Chain, shape: Shape) -> Iterator[Slip]:
    """Take the velocity of another frame, or that of P with the sums ending at another joint."""
    if shape != (6, 1):
        return
    for frame in range(1, chain.n + 1):

        def of_frame(w: Working, velocity: np.ndarray, k: int = frame) -> np.ndarray:
            if not w.comes_from("joint rates"):
                return velocity
            try:
                inner = w if k == w.n else w.up_to(k)
                frame = "tool jacobian" if w.comes_from("tool jacobian") else "geometric"
                return applied(inner[frame], w["joint rates"][:k])[:, None]
            except IndexError:  # of a joint behind the frame
                return velocity

        def of_point(w: Working, velocity: np.ndarray, k: int = frame) -> np.ndarray:
            if not w.comes_from("joint rates"):
                return velocity
            return applied(w["geometric"][:, :k], w["joint rates"][:k])[:, None]

        last = "the last frame" if convention_of(chain).point.is_origin else "the point"
        yield Slip({RESULT: of_frame}, {"frame": "another frame" if frame < chain.n else last})
        if frame < chain.n:
            yield Slip({RESULT: of_point}, {"frame": "the point"})


_ALL = (
    Mistake(
        "chain-rule", "Contribution dropped from the chain rule",
        "Column {joint} seems to lack the part that link {link} adds: joint {joint} moves every link behind it.",
        "6.3", _chain_rule,
    ),
    Mistake(
        "joint-left-out", "Joint left out",
        "What joint {joint} adds seems to be left out: every joint that moves the point counts.", "6.4",
        _joint_left_out, rare=True,
    ),
    Mistake(
        "own-link-only", "Each joint moves its own link only",
        "Each column seems to hold its joint's own link only: a joint moves every link behind it.", "6.3",
        _own_link_only,
    ),
    Mistake(
        "last-link-only", "Only the last link counted",
        "The columns seem to hold the last link only: a joint moves every link behind it.", "6.3", _last_link_only,
    ),
    Mistake(
        "term-sign", "Term of a column with the wrong sign",
        "In column {joint}, the part that link {link} adds seems to have the wrong sign.", "6.3", _term_sign,
    ),
    Mistake(
        "derivative-of-cosine", "Derivatives of sine and cosine with the wrong sign",
        "A sign seems to go wrong where sines and cosines are differentiated. Look again at the derivative of the "
        "cosine.", "6.3", _derivative_of(-1),
    ),
    Mistake(
        "derivative-of-sine", "Derivative of the sine with the wrong sign",
        "A sign seems to go wrong where sines and cosines are differentiated. Look again at the derivative of the "
        "sine.", "6.3", _derivative_of(1),
    ),
    Mistake(
        "not-differentiated", "Not differentiated",
        "The sines and cosines of the position seem to stand in the Jacobian as they are: they are to be "
        "differentiated.", "6.3", _not_differentiated,
    ),
    Mistake(
        "product-rule", "Both factors differentiated at once",
        "The length of joint {joint} and its direction seem to be differentiated at once: of a product, one factor is "
        "differentiated at a time, and the results are added.", "6.3", _both_factors, rare=True,
    ),
    Mistake(
        "next-axis", "Axis of the next joint",
        "The axes seem to be those of the next joints: joint i turns about, or slides along, {axis}.",
        "6.9 and 6.10", _next_axis,
    ),
    Mistake(
        "next-arm", "p* of the next joint",
        "The vectors p* seem to start one origin too late: for joint i it runs from the origin of frame {frame}.",
        "6.12", _next_arm,
    ),
    Mistake(
        "next-frame", "Frame of the next joint",
        "Axis and vector of each column seem to be those of the next joint: joint i belongs to frame {frame}.",
        "6.12", _next_both,
    ),
    Mistake(
        "previous-frame", "Frame before a joint, as in the standard table",
        "Axis and vector of each column seem to be those of frame i-1: in a modified table, frame i stands on the axis "
        "of joint i.", "6.12", _previous_both, rare=True,
    ),
    Mistake(
        "previous-axis", "Axis of the joint before",
        "The axes seem to be those of the joints before: joint i turns about, or slides along, {axis}.",
        "6.9 and 6.10", _previous_axis, rare=True,
    ),
    Mistake(
        "cross-order", "Cross product in the wrong order",
        "The cross products seem to be taken in the wrong order: a x b is minus b x a.", "6.12", _order,
    ),
    Mistake(
        "no-cross-product", "Cross product left out",
        "The linear part of a revolute column seems to be p* itself: the cross product with the axis is missing.",
        "6.12", _no_product,
    ),
    Mistake(
        "arm-from-base", "Vector from the base for p*",
        "The vectors p* seem to start at the base throughout: each starts at the origin of its own joint's frame.",
        "6.13", _from_base,
    ),
    Mistake(
        "arm-from-other-origin", "One vector p* from another origin",
        "The vector p* of joint {joint} seems to start at O{other}: for this joint it runs from the origin of frame "
        "{frame}.", "6.13", _from_other_origin, rare=True,
    ),
    Mistake(
        "arm-to-origin", "Vector to the joint for p*",
        "The vectors p* seem to run from the base to the joints: they run from the joints to the point.",
        "6.13", _to_origin, rare=True,
    ),
    Mistake(
        "arm-reversed", "p* reversed",
        "The vectors p* seem to run from the point to the joints: they run the other way.", "6.13", _reversed,
    ),
    Mistake(
        "arm-of-one-link", "p* of one link only",
        "The vectors p* seem to reach to the next origin only: they reach to the point.", "6.13", _one_link,
    ),
    Mistake(
        "prismatic-as-revolute", "Prismatic joint treated as revolute",
        "Joint {joint} seems to be treated as revolute: it slides along its axis.", "6.12", _as_revolute,
    ),
    Mistake(
        "revolute-as-prismatic", "Revolute joint treated as prismatic",
        "Joint {joint} seems to be treated as prismatic: it turns about its axis.", "6.12", _as_prismatic, rare=True,
    ),
    Mistake(
        "slide-turns", "Angular part for a prismatic joint",
        "Joint {joint} slides, and seems to have an angular part.", "6.11", _turning_slides,
    ),
    Mistake(
        "no-angular-part", "Angular part left out",
        "The angular part of joint {joint} seems to be left out: a revolute joint turns all links behind it.",
        "6.10", _not_turning,
    ),
    Mistake(
        "slides-turn", "Angular parts for prismatic joints",
        "Joints {joint} are prismatic, but seem to have an angular part: a prismatic joint rotates nothing.", "6.11",
        _all_slides_turn, rare=True,
    ),
    Mistake(
        "angular-of-one-joint", "Angular part of one joint only",
        "Only joint {joint} seems to have an angular part: every revolute joint rotates all links behind it.", "6.10",
        _one_turns, rare=True,
    ),
    Mistake(
        "angular-of-next-axis", "Axis of the next joint in the angular rows",
        "In the angular rows the axes seem to be those of the next joints: joint i rotates about {axis}.", "6.10",
        _next_turns, rare=True,
    ),
    Mistake(
        "blocks-exchanged", "Linear and angular rows exchanged",
        "The linear and the angular rows seem to be exchanged: the linear ones come first.", "6.6", _blocks, rare=True,
    ),
    Mistake(
        "tool-frame", "Tool frame for base frame",
        "The vectors seem to be those that the last frame sees: they are wanted in the base frame.", "6.11",
        _in_tool_frame,
    ),
    Mistake(
        "own-frames", "Axes as their own frames see them",
        "Every axis seems to be taken for (0, 0, 1), as its own frame sees it: all are expected in the same frame.",
        "below 6.10", _own_frame, rare=True,
    ),
    Mistake(
        "wrong-axis", "x or y axis for z",
        "The {axis} axes of the frames seem to be taken: joints turn about, and slide along, z.", "below 6.10",
        _along_x, rare=True,
    ),
    Mistake(
        "wrong-axis-of-joint", "x or y axis for z, for one joint",
        "For joint {joint}, the {axis} axis of the frame seems to be taken: joints rotate about, and slide along, z.",
        "below 6.10", _one_along_x, rare=True,
    ),
    Mistake(
        "row-of-rotation", "Row of the rotation matrix for its column",
        "The axes seem to be the last rows of the rotation matrices: they are the last columns.", "below 6.10",
        _axis_row, rare=True,
    ),
    Mistake(
        "axis-sign", "Axis with the wrong sign",
        "The axis of joint {joint} seems to point the wrong way.", "below 6.10", _axis_sign, rare=True,
    ),
    Mistake(
        "rows-not-turned", "Vectors left in the base frame",
        "The {vectors} seem to be left in the base frame: all are expected in the coordinates of another frame.",
        "6.11", _not_turned, rare=True,
    ),
    Mistake(
        "turned-the-wrong-way", "Turned by the rotation for its transpose",
        "The vectors seem to be multiplied by the rotation matrix of the frame that is asked for: its transpose takes "
        "vectors into that frame.", "6.11", _tool_stage(_turned_the_other_way), rare=True,
    ),
    Mistake(
        "frame-before", "Another frame for the tool frame",
        "You seem to have the vectors in the coordinates of frame {frame}: another frame is asked for.", "6.11",
        _frame_before, rare=True,
    ),
    Mistake(
        "velocity-of-other-frame", "Velocity of another frame",
        "The velocity seems to be that of {frame}: it is wanted for the origin of the frame that is asked for, by the "
        "joints before it.", "6.9 and 6.10", _other_frames_velocity, rare=True,
    ),
    Mistake(
        "arms-exchanged", "Vectors p* exchanged",
        "The vectors p* of joints {joint} and {other} seem to be exchanged.", "6.13", _arms_exchanged, rare=True,
    ),
)  # fmt: skip

OF_FRAMES = frozenset({
    "next-arm", "next-frame", "previous-frame", "arm-from-base", "arm-from-other-origin", "arm-to-origin",
    "arm-reversed", "arm-of-one-link", "no-cross-product", "tool-frame", "own-frames", "wrong-axis",
    "wrong-axis-of-joint", "row-of-rotation", "velocity-of-other-frame", "arms-exchanged", "rows-not-turned",
    "turned-the-wrong-way", "frame-before", "blocks-exchanged",
})  # fmt: skip
"""Those that speak of frames on the links, or of vectors from their origins; of screws, `screws` says what is above."""
MISTAKES = of_frames(_ALL, but={one.name for one in _ALL} - OF_FRAMES)
