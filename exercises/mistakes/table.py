"""Mistakes in reading the DH table, the base and the point of interest.

All derivations start from the standard table. The a and alpha in row i of a modified table are in row i - 1 of the
standard table, or in the base; a mistake changes them there.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, permutations
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import PRISMATIC, REVOLUTE, Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.derivation import graph
from qdot.exercises.derivation.arithmetic import apply_matrix, matrix_product
from qdot.exercises.derivation.graph import Change, StageResults, Table, TableRow
from qdot.exercises.mistakes.base import (
    AnswerShape,
    MistakeVariant,
    VariantGenerator,
    join_words,
    make_joint_words,
    make_propagated_variant,
    vary_each_joint_and_all,
    vary_if,
)

MAX_ROWS_FOR_ANY_PAIR = 4
"""Maximum number of rows of a table in which any two rows may be confused. In longer tables, only adjacent rows are."""


def _change_row(
    index: int, change: Callable[[StageResults, TableRow], dict[str, Any]], **words: object
) -> MistakeVariant:
    """Return the variant that changes entries in one row of the table that students see."""

    def apply_change(stages: StageResults, table: Table) -> Table:
        return _change_entries(stages, table, index, **change(stages, _find_convention_row(stages, table, index)))

    return MistakeVariant({"table": apply_change}, words={"joint": index + 1, "link": index + 1, **words})


def _find_convention_row(stages: StageResults, table: Table, index: int) -> TableRow:
    """Return a row of the table that students see."""
    row, link_row_index = table.rows[index], _find_link_row(stages, index)
    if link_row_index >= 0:
        return replace(row, a=table.rows[link_row_index].a, alpha=table.rows[link_row_index].alpha)
    shift = table.base_position[0]  # this is the first a of a modified table if students see no base
    return replace(row, a=shift if convention_of(stages.chain).base.is_world else shift * 0, alpha=table.base_tilt)


def _change_entries(stages: StageResults, table: Table, index: int, **new_entries: Any) -> Table:
    """Return the standard table with entries changed in one row of the table that students see."""
    row, link_row_index = _find_convention_row(stages, table, index), _find_link_row(stages, index)
    a, alpha = new_entries.pop("a", row.a), new_entries.pop("alpha", row.alpha)
    new_table = table.with_row(index, **new_entries)
    if link_row_index >= 0:
        return new_table.with_row(link_row_index, a=a, alpha=alpha)
    yaw = table.base_yaw
    base_x_axis = np.stack([stages.arithmetic.cos(yaw), stages.arithmetic.sin(yaw), yaw * 0])
    return replace(new_table, base_position=table.base_position + (a - row.a) * base_x_axis, base_tilt=alpha)


def _find_link_row(stages: StageResults, index: int) -> int:
    """Return the index of the standard row that has the a and alpha of a row that students see; -1 is the base."""
    return index - 1 if convention_of(stages.chain).is_proximal else index


def _change_each_row(
    applies: Callable[[Joint], bool], change: Callable[[StageResults, TableRow], dict[str, Any]]
) -> VariantGenerator:
    """Return a function that yields a variant for each row that `applies` accepts, with changed entries in this row."""
    return lambda chain, _: (_change_row(i, change) for i, row in enumerate(convention_of(chain).rows) if applies(row))


def _drop_offsets(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants without the offsets of one joint or of all joints."""

    def drop(joints: Sequence[int]) -> MistakeVariant:
        def apply_change(stages: StageResults, table: Table) -> Table:
            new_table = table
            for i in joints:
                variable = stages.arithmetic.convert_entry(chain.q[i])
                new_table = new_table.with_row(i, **{chain.joints[i].variable_key: variable})
            return new_table

        return MistakeVariant({"table": apply_change}, words=_make_offset_words(chain, joints))

    return vary_each_joint_and_all([i for i, offset in enumerate(chain.offsets) if offset != 0], drop)


def _add_to_variable(make_term: Callable[[Chain, int], sp.Expr], kind: str) -> VariantGenerator:
    """Return a function that yields one variant for each joint of a kind, with a term added to the joint's variable.

    `make_term` returns the term for an arm and a joint. Joints with a zero term have no variant.
    """

    def generate(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        for i in chain.list_joints_of_kind(kind):
            if (term := make_term(chain, i)) != 0:
                yield _add_to_row(i, chain.joints[i].variable_key, term)

    return generate


def _add_to_row(index: int, entry: str, term: sp.Expr, /, **words: object) -> MistakeVariant:
    return _change_row(
        index, lambda stages, row: {entry: getattr(row, entry) + stages.arithmetic.convert_entry(term)}, **words
    )


def _scale_offsets(
    factors: Sequence[sp.Expr], is_affected: Callable[[sp.Expr], bool] = lambda offset: True
) -> VariantGenerator:
    """Return a function that yields variants with the offsets of revolute joints multiplied by a factor.

    For each factor, one offset is multiplied at a time, and then all offsets. Only offsets that `is_affected` accepts
    are multiplied.
    """

    def generate(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
        all_offsets = {i: chain.offsets[i] for i in chain.revolute_joints}
        offsets = {i: offset for i, offset in all_offsets.items() if offset != 0 and is_affected(offset)}
        for factor in factors:
            yield from vary_each_joint_and_all(list(offsets), partial(_scale_offsets_of_joints, chain, offsets, factor))

    return generate


def _scale_offsets_of_joints(
    chain: Chain, offsets: Mapping[int, sp.Expr], factor: sp.Expr, joints: Sequence[int]
) -> MistakeVariant:
    """Return the variant with the offsets of these joints multiplied by a factor."""

    def apply_change(stages: StageResults, table: Table) -> Table:
        new_table = table
        for i in joints:
            theta = table.rows[i].theta + stages.arithmetic.convert_entry((factor - 1) * offsets[i])
            new_table = new_table.with_row(i, theta=theta)
        return new_table

    offset_texts = dict.fromkeys(f"{sp.nsimplify(offsets[i] * 180 / sp.pi)}°" for i in joints)
    words = {**_make_offset_words(chain, joints), "degrees": join_words([*offset_texts])}
    return MistakeVariant({"table": apply_change}, words=words)


def _make_offset_words(chain: Chain, joints: Sequence[int]) -> dict[str, object]:
    """Return the words for the placeholders "joint" and "variable" of messages about joint offsets."""
    return {**make_joint_words(joints), "variable": join_words([str(chain.q[i]) for i in joints])}


def _use_other_row(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants in which a row has the length, distance, twist or offset of another row."""
    for (i, row), (j, other_row) in permutations(enumerate(convention_of(chain).rows), 2):
        if chain.n > MAX_ROWS_FOR_ANY_PAIR and abs(i - j) > 1:
            continue
        if chain.offsets[i] != chain.offsets[j] and row.kind == other_row.kind:
            words = {"entry": "the constant that is added to the joint variable", "other": j + 1}
            yield _add_to_row(i, chain.joints[i].variable_key, chain.offsets[j] - chain.offsets[i], **words)
        for entry in ("a", "d", "alpha"):
            value = getattr(other_row, entry)
            is_variable = entry == "d" and PRISMATIC in (row.kind, other_row.kind)
            if not is_variable and getattr(row, entry) != value:
                yield _change_row(i, partial(_make_entry, entry, value), entry=entry, other=j + 1)


def _make_entry(entry: str, value: sp.Expr, stages: StageResults, row: TableRow) -> dict[str, Any]:
    """Return the new value of an entry, by the name of the entry; a partial of this function changes a row."""
    return {entry: stages.arithmetic.convert_entry(value)}


def _exchange_lengths(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the lengths a of two rows exchanged."""

    def exchange(stages: StageResults, table: Table, i: int, j: int) -> Table:
        a_i, a_j = (_find_convention_row(stages, table, index).a for index in (i, j))
        return _change_entries(stages, _change_entries(stages, table, i, a=a_j), j, a=a_i)

    rows = convention_of(chain).rows
    for i, j in combinations(range(chain.n), 2):
        if rows[i].a != rows[j].a and 0 not in (rows[i].a, rows[j].a):
            yield MistakeVariant({"table": partial(exchange, i=i, j=j)}, words={"joint": i + 1, "other": j + 1})


def _depends_on_twist_sign(joint: Joint) -> bool:
    return bool(sp.sin(joint.alpha) != 0)


def _flip_all_twists(stages: StageResults, table: Table) -> Table:
    return replace(table, rows=tuple(replace(row, alpha=-row.alpha) for row in table.rows))


def scale_angles(factor: sp.Expr) -> Change:
    """Return the change that multiplies the angle of each revolute row of the table by a factor."""

    def scale(stages: StageResults, table: Table) -> Table:
        scale_factor = stages.arithmetic.convert_entry(factor)
        rows = (replace(row, theta=row.theta * scale_factor) if row.is_revolute else row for row in table.rows)
        return replace(table, rows=tuple(rows))

    return scale


def _has_moved_and_rotated_base(chain: Chain) -> bool:
    base = convention_of(chain).base
    return any(base.position) and (base.yaw, base.tilt) != (0, 0)


def _drop_base_rotation(stages: StageResults, table: Table) -> Table:
    new_table = replace(table, base_yaw=table.base_yaw * 0)
    if convention_of(stages.chain).base.tilt == 0:  # a tilt in `table` is then from row 1 of a modified table
        return new_table
    return replace(new_table, base_tilt=table.base_tilt * 0)


def _drop_base(stages: StageResults, table: Table) -> Table:
    new_table = _drop_base_rotation(stages, table)
    is_moved = any(convention_of(stages.chain).base.position)
    return replace(new_table, base_position=table.base_position * 0) if is_moved else new_table


def _move_point_to_origin(stages: StageResults, table: Table) -> Table:
    """Return the table with P moved to the origin of its frame.

    In a modified table, P's x coordinate is partly in the entry a of the standard row of this frame, so the entry
    becomes zero, too.
    """
    new_table, row_index = replace(table, point_offset=table.point_offset * 0), stages.chain.point.frame - 1
    if convention_of(stages.chain).is_proximal and row_index >= 0:
        return new_table.with_row(row_index, a=table.rows[row_index].a * 0)
    return new_table


def _use_other_origin(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant with the last origin instead of P, or with the origin before it if P is in the last frame.

    In a modified table, only a point P in the last frame is replaced.
    """
    if convention_of(chain).is_proximal:
        if chain.point.frame == chain.n > 1:
            yield MistakeVariant({"table": _move_point_to_earlier_origin}, words={"frame": chain.n - 1})
        return

    frame = chain.n - 1 if chain.point.frame == chain.n else chain.n
    if frame > 0:
        yield MistakeVariant(
            {"point": lambda stages, _: stages["origins"][frame], "link derivatives": _keep_derivatives_up_to(frame)},
            words={"frame": frame},
        )


def _move_point_to_earlier_origin(stages: StageResults, table: Table) -> Table:
    """Return a table with the lengths after the second-last origin set to zero, so that P is at this origin.

    The table of the first joint alone, which has no earlier origin, stays as it is.
    """
    if stages.n == 1:
        return table
    second_last_row, last_row = table.rows[-2:]
    new_table = table.with_row(stages.n - 2, a=second_last_row.a * 0)
    new_table = new_table.with_row(stages.n - 1, a=last_row.a * 0, d=last_row.d * 0)
    return replace(new_table, point_offset=table.point_offset * 0)


def _keep_derivatives_up_to(frame: int) -> Callable[[StageResults, np.ndarray], np.ndarray]:
    """Return the change that keeps the derivatives of the link vectors up to a frame, and sets the others to zero."""

    def apply_change(stages: StageResults, _: np.ndarray) -> np.ndarray:
        link_derivatives = graph.differentiate_links(stages)
        link_derivatives[:, frame:] = link_derivatives[:, frame:] * 0
        return link_derivatives

    return apply_change


def _use_other_units(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with numeric lengths in centimetres or millimetres, and symbols in metres."""

    def scale(stages: StageResults, table: Table, factor: int) -> Table:
        scaled_rows = []
        for row, joint, offset, q in zip(
            table.rows, stages.chain.joints, stages.chain.offsets, stages.chain.q, strict=True
        ):
            variable = stages.arithmetic.convert_entry(q if joint.is_prismatic else sp.S.Zero)
            a = row.a * factor if joint.a.is_number else row.a
            has_numeric_d = (offset if joint.is_prismatic else joint.d).is_number
            d = (row.d - variable) * factor + variable if has_numeric_d else row.d
            scaled_rows.append(replace(row, a=a, d=d))
        new_table = replace(table, rows=tuple(scaled_rows), base_position=table.base_position * factor)
        has_numeric_point = all(value.is_number for value in stages.chain.point.offset)
        return replace(new_table, point_offset=table.point_offset * factor) if has_numeric_point else new_table

    if any(joint.a != 0 or joint.d != 0 for joint in chain.joints):
        yield MistakeVariant({"table": partial(scale, factor=100)}, words={"unit": "centimetres"})
        yield MistakeVariant({"table": partial(scale, factor=1000)}, words={"unit": "millimetres"})


def _read_as_modified(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant that reads a standard table as a modified table, the convention of other books.

    The transform of a row is then Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(theta_i) Tz(d_i).
    """

    def change_rotations(stages: StageResults, correct_rotations: list[np.ndarray]) -> list[np.ndarray]:
        rotations = [correct_rotations[0]]
        for row in stages["table"].rows:
            rotation_to_axis = matrix_product(rotations[-1], graph.make_rotation_x(stages, row.alpha))
            rotations.append(matrix_product(rotation_to_axis, graph.make_rotation_z(stages, row.theta)))
        return rotations

    def change_links(stages: StageResults, correct_links: list[np.ndarray]) -> list[np.ndarray]:
        frames, rows = stages["rotations"], stages["table"].rows
        vectors = [row.a * frames[k][:, 0] + row.d * frames[k + 1][:, 2] for k, row in enumerate(rows)]
        return [*vectors, apply_matrix(frames[stages.chain.point.frame], stages["table"].point_offset)]

    if any(joint.alpha != 0 for joint in chain.joints):
        yield MistakeVariant({"rotations": change_rotations, "link vectors": change_links})


def _use_next_links(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield the variant that uses the a and alpha of link i in row i of a modified table.

    The transform of a row is then Rx(alpha_i) Tx(a_i) Rz(theta_i) Tz(d_i).
    """
    rows = convention_of(chain).rows
    empty_row = replace(rows[0], a=sp.S.Zero, alpha=sp.S.Zero)

    def shift_links(stages: StageResults, table: Table) -> Table:
        new_table, point = table, convention_of(stages.chain).point
        offset = np.stack([stages.arithmetic.convert_entry(value) for value in point.offset])
        for i, next_row in zip(range(stages.n), [*rows[1:], empty_row], strict=False):
            a, alpha = stages.arithmetic.convert_entry(next_row.a), stages.arithmetic.convert_entry(next_row.alpha)
            new_table = _change_entries(stages, new_table, i, a=a, alpha=alpha)
        if 0 < point.frame < stages.n:  # the coordinates of P now refer to the previous frame
            row = new_table.rows[point.frame - 1]
            moved_offset = offset - np.stack([row.a, row.a * 0, row.a * 0])
            return replace(
                new_table, point_offset=apply_matrix(graph.make_rotation_x(stages, -row.alpha), moved_offset)
            )
        return new_table

    if len({(row.a, row.alpha) for row in (*rows, empty_row)}) > 1:
        yield make_propagated_variant({"table": shift_links})


def _read_as_standard(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants that read a modified table as a standard table.

    The transform of a row is then Rz(theta_i) Tz(d_i) Tx(a_{i-1}) Rx(alpha_{i-1}). The first variant uses the axis of
    frame i-1 for joint i, as in a standard table. The second variant uses the axis of frame i, as in a modified table.
    """

    def shift_links(stages: StageResults, table: Table) -> Table:
        first_row, *later_rows = convention_of(stages.chain).rows
        convert = stages.arithmetic.convert_entry
        base, point = convention_of(stages.chain).base, convention_of(stages.chain).point
        link_entries = [(convert(first_row.a), convert(first_row.alpha))]
        link_entries += [(row.a, row.alpha) for row in table.rows[: len(later_rows)]]
        rows = [replace(row, a=a, alpha=alpha) for row, (a, alpha) in zip(table.rows, link_entries, strict=True)]
        base_position, offset = (np.stack([*map(convert, vector)]) for vector in (base.position, point.offset))
        return Table(tuple(rows), base_position, convert(base.yaw), convert(base.tilt), offset)

    if any((row.a, row.alpha) != (0, 0) for row in convention_of(chain).rows):
        standard_changes: dict[str, Change] = {
            "table": shift_links,
            "last rotation": lambda stages, _: stages.arithmetic.drop_derivatives(stages["rotations"][-1]),
            "origins on axes": lambda stages, _: stages["origins"],
        }
        yield MistakeVariant(standard_changes)

        def use_next_axes(stages: StageResults, _: np.ndarray) -> np.ndarray:
            axes = [stages.arithmetic.drop_derivatives(rotation[:, 2]) for rotation in stages["rotations"][1:]]
            return np.stack([*axes, axes[-1]])

        def use_next_origins(stages: StageResults, _: np.ndarray) -> np.ndarray:
            return np.concatenate([stages["origins"][1:], stages["origins"][-1:]])

        yield make_propagated_variant({**standard_changes, "axes": use_next_axes, "origins on axes": use_next_origins})


VARIANTS: dict[str, VariantGenerator] = {
    "offset-forgotten": _drop_offsets,
    "offset-sign": _scale_offsets([sp.S(-1)], lambda offset: bool(sp.sin(offset) != 0)),
    "prismatic-offset-sign": _add_to_variable(lambda chain, i: -2 * chain.offsets[i], PRISMATIC),
    "offset-in-degrees": _scale_offsets([180 / sp.pi]),
    "wrong-radians": _scale_offsets([sp.S(2), sp.S.Half]),
    "fixed-angle-forgotten": _change_each_row(
        lambda row: row.is_prismatic and row.theta != 0, lambda _, row: {"theta": row.theta * 0}
    ),
    "length-forgotten": _change_each_row(lambda row: row.a != 0, lambda _, row: {"a": row.a * 0}),
    "distance-forgotten": _change_each_row(lambda row: row.is_revolute and row.d != 0, lambda _, row: {"d": row.d * 0}),
    "variable-forgotten": _add_to_variable(lambda chain, i: -chain.q[i], REVOLUTE),
    "row-misread": _use_other_row,
    "lengths-exchanged": _exchange_lengths,
    "point-forgotten": vary_if(
        lambda chain: not convention_of(chain).point.is_origin, {"table": _move_point_to_origin}
    ),
    "other-point": _use_other_origin,
    "base-forgotten": vary_if(lambda chain: not convention_of(chain).base.is_world, {"table": _drop_base}),
    "base-not-rotated": vary_if(_has_moved_and_rotated_base, {"table": _drop_base_rotation}),
    "twist-sign": _change_each_row(_depends_on_twist_sign, lambda _, row: {"alpha": -row.alpha}),
    "all-twists-sign": vary_if(
        lambda chain: sum(map(_depends_on_twist_sign, chain.joints)) > 1, {"table": _flip_all_twists}
    ),
    "twist-forgotten": _change_each_row(lambda row: row.alpha != 0, lambda _, row: {"alpha": row.alpha * 0}),
    "modified-dh": _read_as_modified,
    "length-and-twist-of-link-i": _use_next_links,
    "standard-dh": _read_as_standard,
    "a-and-d-exchanged": _change_each_row(lambda row: row.a != row.d, lambda _, row: {"a": row.d, "d": row.a}),
    "joint-rotates-other-way": _change_each_row(lambda row: row.is_revolute, lambda _, row: {"theta": -row.theta}),
    "quarter-turn": _add_to_variable(lambda chain, i: sp.pi / 2, REVOLUTE),
    "lengths-in-centimetres": _use_other_units,
    "degrees": vary_if(lambda chain: chain.revolute_joints, {"table": scale_angles(sp.pi / 180)}),
}
