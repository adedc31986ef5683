"""Mistakes in reading the DH table, the base and the point of interest."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, matrix_product
from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation_graph import (
    Change,
    Table,
    TableRow,
    Working,
    propagate_linear_rows,
    rotation_x,
    rotation_z,
)
from qdot.exercises.mistakes.base import (
    AnswerShape,
    Mistake,
    MistakeVariant,
    VariantGenerator,
    restrict_to_tables,
    vary_each_joint_and_all,
)

MAX_ROWS_FOR_ANY_PAIR = 4
"""Maximum number of rows for which any two rows may be confused; in longer tables, only adjacent rows are."""


def _change_row(index: int, change: Callable[[Working, TableRow], dict[str, Any]], **words: object) -> MistakeVariant:
    """Return the variant in which entries of one row of the table are changed, in the arm's convention."""

    def apply_change(w: Working, table: Table) -> Table:
        return _with_convention_row(w, table, index, **change(w, _convention_row(w, table, index)))

    return MistakeVariant({"table": apply_change}, {"joint": index + 1, "link": index + 1, **words})


def _convention_row(w: Working, table: Table, index: int) -> TableRow:
    """Return a row in the arm's convention: modified rows contain a and alpha of the previous link or the base."""
    row, link = table.rows[index], _standard_row_index(w, index)
    if link >= 0:
        return replace(row, a=table.rows[link].a, alpha=table.rows[link].alpha)
    position, _, tilt = table.base
    return replace(row, a=position[0] if convention_of(w.chain).base.is_world else position[0] * 0, alpha=tilt)


def _with_convention_row(w: Working, table: Table, index: int, **new_entries: Any) -> Table:
    """Return the table with entries of one row changed in the arm's convention."""
    row, link = _convention_row(w, table, index), _standard_row_index(w, index)
    a, alpha = new_entries.pop("a", row.a), new_entries.pop("alpha", row.alpha)
    table = table.with_row(index, **new_entries)
    if link >= 0:
        return table.with_row(link, a=a, alpha=alpha)
    position, yaw, _ = table.base
    base_x_axis = np.stack([w.arithmetic.cos(yaw), w.arithmetic.sin(yaw), yaw * 0])
    return replace(table, base=(position + (a - row.a) * base_x_axis, yaw, alpha))


def _standard_row_index(w: Working, index: int) -> int:
    """Return the index of the standard row that contains a and alpha of a row of the convention; -1 for the base."""
    return index - convention_of(w.chain).frame_on_axis(1)


def _change_each_row(
    applies: Callable[[Joint], bool], change: Callable[[Working, TableRow], dict[str, Any]]
) -> VariantGenerator:
    """Return a function that yields one variant per row that `applies` accepts, with entries of this row changed."""
    return lambda chain, _: (_change_row(i, change) for i, row in enumerate(convention_of(chain).rows) if applies(row))


def _drop_offsets(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def drop(joints: Sequence[int]) -> MistakeVariant:
        def apply_change(w: Working, table: Table) -> Table:
            for i in joints:
                table = table.with_row(i, **{_variable_entry(chain, i): w.arithmetic.table_entry(chain.q[i])})
            return table

        variables = ", ".join(str(chain.q[i]) for i in joints)
        return MistakeVariant({"table": apply_change}, {"joint": _joint_numbers(joints), "variable": variables})

    return vary_each_joint_and_all([i for i, offset in enumerate(chain.offsets) if offset != 0], drop)


def _variable_entry(chain: Chain, joint: int) -> str:
    """Return the name of the table entry that contains the joint variable: "theta" or "d"."""
    return "theta" if chain.joints[joint].kind == "R" else "d"


def _joint_numbers(indices: Sequence[int]) -> str:
    """Return the numbers of joints, from 1, as text."""
    return ", ".join(str(i + 1) for i in indices)


def _add_to_variable(term: Callable[[Chain, int], sp.Expr], kind: str) -> VariantGenerator:
    """Return a function that yields one variant per joint of a kind, with `term` added to its variable.

    Joints for which `term` is zero are skipped.
    """

    def variants(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        for i, joint in enumerate(chain.joints):
            if joint.kind == kind and term(chain, i) != 0:
                yield _add_to_row(i, _variable_entry(chain, i), term(chain, i))

    return variants


def _add_to_row(index: int, entry: str, term: sp.Expr, /, **words: object) -> MistakeVariant:
    return _change_row(index, lambda w, row: {entry: getattr(row, entry) + w.arithmetic.table_entry(term)}, **words)


def _scale_offsets(
    factors: Sequence[sp.Expr], is_affected: Callable[[sp.Expr], bool] = lambda offset: True
) -> VariantGenerator:
    """Return a function that yields variants with the constants of revolute joints multiplied by a factor.

    For each factor, one constant is multiplied at a time, and then all of them.
    """

    def variants(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        offsets = {
            i: offset
            for i, (joint, offset) in enumerate(zip(chain.joints, chain.offsets, strict=True))
            if joint.kind == "R" and offset != 0 and is_affected(offset)
        }
        for factor in factors:
            yield from vary_each_joint_and_all(list(offsets), partial(_scale_constants, offsets, factor))

    return variants


def _scale_constants(offsets: Mapping[int, sp.Expr], factor: sp.Expr, joints: Sequence[int]) -> MistakeVariant:
    def apply_change(w: Working, table: Table) -> Table:
        for i in joints:
            theta = table.rows[i].theta + w.arithmetic.table_entry((factor - 1) * offsets[i])
            table = table.with_row(i, theta=theta)
        return table

    constants = ", ".join(dict.fromkeys(_degree_text(offsets[i]) for i in joints))
    return MistakeVariant({"table": apply_change}, {"joint": _joint_numbers(joints), "degrees": constants})


def _degree_text(angle: sp.Expr) -> str:
    """Return an angle in degrees, as text."""
    return f"{sp.nsimplify(angle * 180 / sp.pi)}°"


def _use_other_row(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants in which a row has the length, distance, twist or constant of another row."""
    for (i, row), (j, other_row) in permutations(enumerate(convention_of(chain).rows), 2):
        if chain.n > MAX_ROWS_FOR_ANY_PAIR and abs(i - j) > 1:
            continue
        if chain.offsets[i] != chain.offsets[j] and row.kind == other_row.kind:
            difference = chain.offsets[j] - chain.offsets[i]
            yield _add_to_row(
                i, _variable_entry(chain, i), difference, entry="constant of the joint variable", other=j + 1
            )
        for entry in ("a", "d", "alpha"):
            value = getattr(other_row, entry)
            is_variable = entry == "d" and "P" in (row.kind, other_row.kind)
            if not is_variable and getattr(row, entry) != value:
                yield _change_row(i, partial(_replace_entry, entry, value), entry=entry, other=j + 1)


def _replace_entry(entry: str, value: sp.Expr, w: Working, row: TableRow) -> dict[str, Any]:
    return {entry: w.arithmetic.table_entry(value)}


def _exchange_lengths(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    rows = convention_of(chain).rows
    for i, j in combinations(range(chain.n), 2):
        if 0 != rows[i].a != rows[j].a != 0:

            def apply_change(w: Working, table: Table, i: int = i, j: int = j) -> Table:
                first, second = _convention_row(w, table, i).a, _convention_row(w, table, j).a
                return _with_convention_row(w, _with_convention_row(w, table, i, a=second), j, a=first)

            yield MistakeVariant({"table": apply_change}, {"joint": i + 1, "other": j + 1})


def _has_twist(joint: Joint) -> bool:
    return bool(sp.sin(joint.alpha) != 0)


def _flip_all_twists(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    def flip(w: Working, table: Table) -> Table:
        return replace(table, rows=tuple(replace(row, alpha=-row.alpha) for row in table.rows))

    if sum(map(_has_twist, chain.joints)) > 1:
        yield MistakeVariant({"table": flip})


def scale_angles(factor: sp.Expr) -> Change:
    """Return the change that multiplies the angle of each revolute row of the table by a factor."""

    def scale(w: Working, table: Table) -> Table:
        scale_factor = w.arithmetic.table_entry(factor)
        rows = (replace(row, theta=row.theta * scale_factor) if row.kind == "R" else row for row in table.rows)
        return replace(table, rows=tuple(rows))

    return scale


def _convert_again(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    if any(joint.kind == "R" for joint in chain.joints):
        yield MistakeVariant({"table": scale_angles(sp.pi / 180)})


def _drop_base(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    if not convention_of(chain).base.is_world:
        yield MistakeVariant({"table": _without_base(chain, any(convention_of(chain).base.position))})


def _skip_base_rotation(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    base = convention_of(chain).base
    if any(base.position) and (base.yaw, base.tilt) != (0, 0):
        yield MistakeVariant({"table": _without_base(chain, at_origin=False)})


def _without_base(chain: Chain, at_origin: bool) -> Change:
    """Return the change that omits the rotation of the base, and also its position if `at_origin`."""

    def apply_change(w: Working, table: Table) -> Table:
        position, yaw, tilt = table.base  # the tilt may come from the first row of a modified table
        zero_tilt = tilt * 0 if convention_of(chain).base.tilt != 0 else tilt
        return replace(table, base=(position * 0 if at_origin else position, yaw * 0, zero_tilt))

    return apply_change


def _drop_point_offset(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    if not convention_of(chain).point.is_origin:
        yield MistakeVariant({"table": _move_to_last_origin})


def _move_to_last_origin(w: Working, table: Table) -> Table:
    """Return the table with P at the origin of its frame; in a modified table, without the length of its link."""
    if convention_of(w.chain).is_proximal and w.chain.point.frame:
        table = table.with_row(w.chain.point.frame - 1, a=table.rows[w.chain.point.frame - 1].a * 0)
    return replace(table, offset=table.offset * 0)


def _use_other_origin(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant that uses the last frame's origin as P, or the origin before it if P is in the last frame."""
    if convention_of(chain).is_proximal:
        if chain.point.frame == chain.n > 1:
            yield MistakeVariant({"table": _move_to_earlier_origin}, {"frame": chain.n - 1})
        return

    def variant_at(frame: int) -> MistakeVariant:
        return MistakeVariant(
            {"point": lambda w, _: w["origins"][frame], "effects": _effects_up_to(frame)}, {"frame": frame}
        )

    if chain.point.frame != chain.n:
        yield variant_at(chain.n)
    if chain.point.frame == chain.n and chain.n > 1:
        yield variant_at(chain.n - 1)


def _move_to_earlier_origin(w: Working, table: Table) -> Table:
    """Return a modified table with P at the second-last origin, by setting the later lengths to zero."""
    last_row, second_last = table.rows[-1], table.rows[-2]
    table = table.with_row(w.n - 1, a=last_row.a * 0, d=last_row.d * 0).with_row(w.n - 2, a=second_last.a * 0)
    return replace(table, offset=table.offset * 0)


def _effects_up_to(frame: int) -> Callable[[Working, np.ndarray], np.ndarray]:
    def apply_change(w: Working, _: np.ndarray) -> np.ndarray:
        effects = np.stack([w.arithmetic.derivatives(link)[: w.n] for link in w["links"]], axis=1)
        effects[:, frame:] = effects[:, frame:] * 0
        return effects

    return apply_change


def _use_other_units(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with all numeric lengths in centimetres or millimetres; symbols remain in metres."""

    def scale(w: Working, table: Table, factor: int) -> Table:
        scaled_rows = []
        for row, joint, offset, q in zip(table.rows, w.chain.joints, w.chain.offsets, w.chain.q, strict=True):
            variable = w.arithmetic.table_entry(q if joint.kind == "P" else sp.S.Zero)
            has_number = (offset if joint.kind == "P" else joint.d).is_number
            a = row.a * factor if joint.a.is_number else row.a
            scaled_rows.append(replace(row, a=a, d=(row.d - variable) * factor + variable if has_number else row.d))
        position, yaw, tilt = table.base
        point_offset = table.offset * factor if all(x.is_number for x in w.chain.point.offset) else table.offset
        return replace(table, rows=tuple(scaled_rows), base=(position * factor, yaw, tilt), offset=point_offset)

    if any(joint.a != 0 or joint.d != 0 for joint in chain.joints):
        yield MistakeVariant({"table": partial(scale, factor=100)}, {"unit": "centimetres"})
        yield MistakeVariant({"table": partial(scale, factor=1000)}, {"unit": "millimetres"})


def _read_as_modified(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant that reads a standard table as a modified one, as other books define it.

    The transform of a row is then Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(theta_i) Tz(d_i).
    """

    def rotations(w: Working, correct_rotations: list[np.ndarray]) -> list[np.ndarray]:
        rotations = [correct_rotations[0]]
        for row in w["table"].rows:
            rotations.append(
                matrix_product(matrix_product(rotations[-1], rotation_x(w, row.alpha)), rotation_z(w, row.theta))
            )
        return rotations

    def links(w: Working, correct_links: list[np.ndarray]) -> list[np.ndarray]:
        vectors, rotations_before = [], w["rotations"]
        for k, row in enumerate(w["table"].rows):
            link_vector = row.a * rotations_before[k][:, 0] + row.d * rotations_before[k + 1][:, 2]
            vectors.append(link_vector)
        return [*vectors, apply_matrix(rotations_before[w.chain.point.frame], w["table"].offset)]

    if any(joint.alpha != 0 for joint in chain.joints):
        yield MistakeVariant({"rotations": rotations, "links": links})


def _use_next_links(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant that uses link i's a and alpha in row i of a modified table.

    The transform of a row is then Rx(alpha_i) Tx(a_i) Rz(theta_i) Tz(d_i).
    """

    def shift_links(w: Working, table: Table) -> Table:
        point, link = convention_of(w.chain).point, w.chain.point.frame
        offset = np.stack([w.arithmetic.table_entry(value) for value in point.offset])
        for i in range(w.n):
            next_row = convention_of(chain).rows[i + 1] if i + 1 < chain.n else None
            a, alpha = (
                w.arithmetic.table_entry(value)
                for value in ((next_row.a, next_row.alpha) if next_row else (zero, zero))
            )
            table = _with_convention_row(w, table, i, a=a, alpha=alpha)
        if 0 < link < w.n:  # the coordinates of P are unchanged, but in the frame before its link
            row = table.rows[link - 1]
            moved_offset = offset - np.stack([row.a, row.a * 0, row.a * 0])
            table = replace(table, offset=apply_matrix(rotation_x(w, -row.alpha), moved_offset))
        return table

    zero, rows = sp.S.Zero, convention_of(chain).rows
    if len({(row.a, row.alpha) for row in (*rows, replace(rows[0], a=zero, alpha=zero))}) > 1:
        yield MistakeVariant({"table": shift_links, "linear": propagate_linear_rows})


def _read_as_standard(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants that read a modified table as a standard one.

    The transform of a row is then Rz(theta_i) Tz(d_i) Tx(a_{i-1}) Rx(alpha_{i-1}).
    """

    def shift_links(w: Working, table: Table) -> Table:
        first_row, *later_rows = convention_of(w.chain).rows
        base, point = convention_of(w.chain).base, convention_of(w.chain).point
        link_entries = [(w.arithmetic.table_entry(first_row.a), w.arithmetic.table_entry(first_row.alpha))]
        link_entries += [(row.a, row.alpha) for row in table.rows[: len(later_rows)]]
        rows = [replace(row, a=a, alpha=alpha) for row, (a, alpha) in zip(table.rows, link_entries, strict=True)]
        base_position = np.stack([w.arithmetic.table_entry(value) for value in base.position])
        base_angles = w.arithmetic.table_entry(base.yaw), w.arithmetic.table_entry(base.tilt)
        offset = np.stack([w.arithmetic.table_entry(value) for value in point.offset])
        return Table(tuple(rows), (base_position, *base_angles), offset)

    if any((row.a, row.alpha) != (0, 0) for row in convention_of(chain).rows):
        standard_changes: dict[str, Change] = {
            "table": shift_links,
            "last rotation": lambda w, _: w.arithmetic.drop_derivatives(w["rotations"][-1]),
            "frames on axes": lambda w, _: w["origins"],
        }
        yield MistakeVariant(standard_changes)  # frame i-1 belongs to joint i, as in a standard table

        def next_axes(w: Working, _: np.ndarray) -> np.ndarray:
            axes = [w.arithmetic.drop_derivatives(rotation[:, 2]) for rotation in w["rotations"][1:]]
            return np.stack([*axes, axes[-1]])

        next_origins: Change = lambda w, _: np.concatenate([w["origins"][1:], w["origins"][-1:]])  # noqa: E731
        yield MistakeVariant(
            {**standard_changes, "axes": next_axes, "frames on axes": next_origins, "linear": propagate_linear_rows}
        )


_ALL_MISTAKES = (
    Mistake("offset-forgotten", "Joint offset left out",
            "You seem to have left out the constant that the table adds to the variable of joint {joint}. Use the "
            "whole entry of the table, not only {variable}.", "6.1", _drop_offsets),
    Mistake("offset-sign", "Joint offset with the wrong sign",
            "You seem to have used the constant {degrees} that the table adds to the angle of joint {joint} with the "
            "wrong sign.", "6.1", _scale_offsets([sp.S(-1)], lambda offset: bool(sp.sin(offset) != 0)), rare=True),
    Mistake("slide-offset-sign", "Offset of a prismatic joint with the wrong sign",
            "You seem to have used the constant that the table adds to the variable of joint {joint} with the wrong "
            "sign.",
            "6.1", _add_to_variable(lambda chain, i: -2 * chain.offsets[i], "P"), rare=True),
    Mistake("offset-in-degrees", "Constant angle typed in degrees",
            "You seem to have typed the constant {degrees} of the table in degrees. Sine and cosine take radians: "
            "convert {degrees} to a multiple of pi.", "6.1", _scale_offsets([180 / sp.pi]), rare=True),
    Mistake(
        "wrong-radians", "Degrees converted to the wrong radians",
        "You seem to have converted the constant {degrees} of the table to the wrong radians. 180° is pi, so 30° "
            "is pi/6, 45° is pi/4, 60° is pi/3 and 90° is pi/2.", "6.1",
        _scale_offsets([sp.S(2), sp.S.Half]), rare=True,  # 30° becomes pi/3, 60° pi/6, 45° pi/2 or pi/8
    ),
    Mistake("fixed-angle-forgotten", "Constant angle of a prismatic joint left out",
            "You seem to have left out a constant angle. Joint {joint} is prismatic, but its row in the table also "
            "has an angle.", "6.1",
            _change_each_row(lambda row: row.kind == "P" and row.theta != 0, lambda _, row: {"theta": row.theta * 0})),
    Mistake("length-forgotten", "Length a left out",
            "You seem to have left out the length a in row {link} of the table.",
            "6.1", _change_each_row(lambda row: row.a != 0, lambda _, row: {"a": row.a * 0})),
    Mistake("distance-forgotten", "Distance d left out",
            "You seem to have left out the distance d in row {link} of the table.", "6.1",
            _change_each_row(lambda row: row.kind == "R" and row.d != 0, lambda _, row: {"d": row.d * 0})),
    Mistake("variable-forgotten", "Joint variable left out",
            "You seem to have left out the angle of joint {joint}. It rotates every link after it.", "6.1",
            _add_to_variable(lambda chain, i: -chain.q[i], "R"), rare=True),
    Mistake("row-misread", "Entry from another row of the table",
            "For row {joint} of the table, you seem to have used the {entry} of row {other}.", "Example 6.1",
            _use_other_row, rare=True),
    Mistake("lengths-exchanged", "Lengths exchanged",
            "You seem to have exchanged the lengths a in rows {joint} and {other} of the table.", "Example 6.1",
            _exchange_lengths, rare=True),
    Mistake("point-forgotten", "Offset of the point left out",
            "Your result seems to be for the origin of the last frame. The point of interest is offset from it: look "
            "at its coordinates in that frame.", "6.1", _drop_point_offset),
    Mistake("other-point", "Origin of another frame instead of the point",
            "Your result seems to be for the origin O{frame}. Check which point the question asks for.", "6.13",
            _use_other_origin, rare=True),
    Mistake("base-forgotten", "Base left out",
            "You seem to have left out the base. The arm's base is not at the origin of the world frame.", "6.1",
            _drop_base),
    Mistake("base-not-rotated", "Rotation of the base left out",
            "You seem to have left out the rotation of the base. The base is rotated in the world frame.", "6.1",
            _skip_base_rotation, rare=True),
    Mistake("twist-sign", "Twist with the wrong sign",
            "You seem to have used the twist alpha in row {joint} of the table with the wrong sign. It is the angle "
            "from one z axis to the next, measured about the x axis between them.", "Example 6.1",
            _change_each_row(_has_twist, lambda _, row: {"alpha": -row.alpha})),
    Mistake("all-twists-sign", "All twists with the wrong sign",
            "You seem to have used all twists alpha with the wrong sign. Each one is measured about x, from one z "
            "axis to the next.",
            "Example 6.1", _flip_all_twists),
    Mistake("twist-forgotten", "Twist left out",
            "You seem to have left out the twist alpha in row {joint} of the table. It rotates the axes after it.",
            "Example 6.1",
            _change_each_row(lambda row: row.alpha != 0, lambda _, row: {"alpha": row.alpha * 0})),
    Mistake("modified-dh", "Another Denavit-Hartenberg convention",
            "You seem to have read the table in the other (modified) convention. Here, you reach a frame by rotating "
            "about z and moving along z first, then moving along x and rotating about x: Rz Tz Tx Rx.",
            "Example 6.1", _read_as_modified, rare=True),
    Mistake("link-behind", "Length and twist of the link after a joint",
            "In each transform, you seem to have used the length and the twist of link i, as in the standard "
            "convention. In the modified convention, those of link i-1 come before joint i.",
            "Example 6.1", _use_next_links, rare=True),
    Mistake("standard-dh", "The standard Denavit-Hartenberg convention",
            "You seem to have read the table in the standard (distal) convention. Here, you reach a frame by rotating "
            "about x and moving along x first, then rotating about z and moving along z: Rx Tx Rz Tz.",
            "Example 6.1", _read_as_standard, rare=True),
    Mistake("a-and-d-exchanged", "a and d exchanged",
            "You seem to have exchanged a and d in row {link} of the table. The distance d is measured along z, and "
            "the length a along x.",
            "Example 6.1", _change_each_row(lambda row: row.a != row.d, lambda _, row: {"a": row.d, "d": row.a}),
            rare=True),
    Mistake("joint-turns-other-way", "Joint that rotates the other way",
            "You seem to have rotated joint {joint} in the wrong direction. Its angle is positive counterclockwise "
            "about its z axis.", "6.1",
            _change_each_row(lambda row: row.kind == "R", lambda _, row: {"theta": -row.theta}), rare=True),
    Mistake("quarter-turn", "Angle off by 90°",
            "The angle of joint {joint} seems to be off by 90°. It is measured from the x axis before the joint to "
            "the one after it.", "6.1", _add_to_variable(lambda chain, i: sp.pi / 2, "R"), rare=True),
    Mistake("lengths-in-centimetres", "Lengths in another unit",
            "The numeric lengths seem to be in {unit}. Give them in metres.", "6.1", _use_other_units,
            rare=True),
    Mistake("degrees", "Degrees instead of radians",
            "You seem to have converted the angles from degrees to radians. They are already in radians.", "6.1",
            _convert_again, rare=True),
)  # fmt: skip

MISTAKES = restrict_to_tables(_ALL_MISTAKES, {mistake.name for mistake in _ALL_MISTAKES} - {"degrees"})
