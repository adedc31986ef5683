"""Mistakes in reading the DH table, and in what is put at its two ends."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from exercises.arm.arithmetic import applied, product
from exercises.arm.chain import Chain
from exercises.arm.stages import Table, TableRow, Working, turn_x, turn_z
from exercises.mistakes.base import Mistake, Shape, Slip


def _row(index: int, change: Callable[[Working, TableRow], dict[str, Any]], **words: object) -> Slip:
    """Return the slip that changes entries of one row."""

    def changed(w: Working, table: Table) -> Table:
        return table.with_row(index, **change(w, table.rows[index]))

    return Slip({"table": changed}, {"joint": index + 1, "link": index + 1, **words})


def _rows(
    chain: Chain, due: Callable[[Any], bool], change: Callable[[Working, TableRow], dict[str, Any]]
) -> Iterator[Slip]:
    for i, joint in enumerate(chain.joints):
        if due(joint):
            yield _row(i, change)


def _offsets(chain: Chain, _: Shape) -> Iterator[Slip]:
    for i, (joint, offset, q) in enumerate(zip(chain.joints, chain.offsets, chain.q, strict=True)):
        if offset != 0:
            entry = "theta" if joint.kind == "R" else "d"
            yield _row(i, lambda w, row, e=entry, q=q: {e: w.arithmetic.stepped(q)}, variable=q)  # type: ignore[misc]


def _fixed_angles(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _rows(chain, lambda j: j.kind == "P" and j.theta != 0, lambda _, row: {"theta": row.theta * 0})


def _twisted(joint: Any) -> bool:
    return bool(sp.sin(joint.alpha) != 0)


def _twist_sign(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _rows(chain, _twisted, lambda _, row: {"alpha": -row.alpha})


def _twist_left_out(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _rows(chain, lambda joint: joint.alpha != 0, lambda _, row: {"alpha": row.alpha * 0})


def _all_twists(chain: Chain, _: Shape) -> Iterator[Slip]:
    def turned(w: Working, table: Table) -> Table:
        return replace(table, rows=tuple(replace(row, alpha=-row.alpha) for row in table.rows))

    if sum(map(_twisted, chain.joints)) > 1:
        yield Slip({"table": turned})


def _a_left_out(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _rows(chain, lambda joint: joint.a != 0, lambda _, row: {"a": row.a * 0})


def _d_left_out(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _rows(chain, lambda joint: joint.kind == "R" and joint.d != 0, lambda _, row: {"d": row.d * 0})


def _exchanged(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _rows(
        chain,
        lambda joint: joint.a != joint.d and (joint.kind == "P" or (joint.a, joint.d) != (0, 0)),
        lambda _, row: {"a": row.d, "d": row.a},
    )


def _other_way(chain: Chain, _: Shape) -> Iterator[Slip]:
    return _rows(chain, lambda joint: joint.kind == "R", lambda _, row: {"theta": -row.theta})


def _turned_too_far(chain: Chain, _: Shape) -> Iterator[Slip]:
    quarter = lambda w, row: {"theta": row.theta + w.arithmetic.stepped(sp.pi / 2)}  # noqa: E731
    return _rows(chain, lambda joint: joint.kind == "R", quarter)


def _degrees(chain: Chain, _: Shape) -> Iterator[Slip]:
    def small(w: Working, table: Table) -> Table:
        part = w.arithmetic.stepped(sp.pi / 180)
        kinds = [joint.kind for joint in w.chain.joints]
        rows = (
            replace(row, theta=row.theta * part) if kind == "R" else row
            for row, kind in zip(table.rows, kinds, strict=True)
        )
        return replace(table, rows=tuple(rows))

    if any(joint.kind == "R" for joint in chain.joints):
        yield Slip({"table": small})


def _no_base(chain: Chain, _: Shape) -> Iterator[Slip]:
    def at_origin(w: Working, table: Table) -> Table:
        position, yaw, tilt = table.base
        return replace(table, base=(position * 0, yaw * 0, tilt * 0))

    if not chain.base.is_world:
        yield Slip({"table": at_origin})


def _no_offset(chain: Chain, _: Shape) -> Iterator[Slip]:
    if not chain.point.is_origin:
        yield Slip({"table": lambda w, table: replace(table, offset=table.offset * 0)})


def _other_frame(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Take the last origin for the point, where that is another; and the one before for the last."""

    def at(frame: int) -> Slip:
        return Slip({"point": lambda w, _: w["origins"][frame], "effects": _up_to(frame)}, {"frame": frame})

    if chain.point.frame != chain.n:
        yield at(chain.n)
    if chain.point.frame == chain.n and chain.n > 1:
        yield at(chain.n - 1)


def _up_to(frame: int) -> Callable[[Working, np.ndarray], np.ndarray]:
    def changed(w: Working, _: np.ndarray) -> np.ndarray:
        effects = np.stack([w.arithmetic.slopes(link)[: w.n] for link in w["links"]], axis=1)
        effects[:, frame:] = effects[:, frame:] * 0
        return effects

    return changed


def _modified(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(theta_i) Tz(d_i), the convention of other books, with the table of this one."""

    def rotations(w: Working, right: list[np.ndarray]) -> list[np.ndarray]:
        turned = [right[0]]
        for row in w["table"].rows:
            turned.append(product(product(turned[-1], turn_x(w, row.alpha)), turn_z(w, row.theta)))
        return turned

    def links(w: Working, right: list[np.ndarray]) -> list[np.ndarray]:
        vectors, before = [], w["rotations"]
        for k, row in enumerate(w["table"].rows):
            along = row.a * before[k][:, 0] + row.d * before[k + 1][:, 2]
            vectors.append(along)
        return [*vectors, applied(before[w.chain.point.frame], w["table"].offset)]

    if any(joint.alpha != 0 for joint in chain.joints):
        yield Slip({"rotations": rotations, "links": links})


MISTAKES = (
    Mistake(
        "offset-forgotten", "Joint offset left out",
        "The table adds a constant to the variable of joint {joint}, and it seems to be left out: put in what the "
        "table says, not {variable} alone.", "6.1", _offsets,
    ),
    Mistake(
        "fixed-angle-forgotten", "Constant angle of a prismatic joint left out",
        "Joint {joint} slides, but its row has an angle too, which seems to be left out.", "6.1", _fixed_angles,
    ),
    Mistake(
        "length-forgotten", "Length a left out",
        "The length a in row {link} of the table seems to be left out.", "6.1", _a_left_out,
    ),
    Mistake(
        "distance-forgotten", "Distance d left out",
        "The distance d in row {link} of the table seems to be left out.", "6.1", _d_left_out,
    ),
    Mistake(
        "point-forgotten", "Offset of the point left out",
        "The result is that of the last frame's origin. The point of interest stands off it: look at its coordinates "
        "in that frame.", "6.1", _no_offset,
    ),
    Mistake(
        "other-point", "Another frame's origin for the point",
        "The result seems to be that of the origin O{frame}. Look again at which point is asked for.", "6.13",
        _other_frame, rare=True,
    ),
    Mistake(
        "base-forgotten", "Base left out",
        "The arm does not stand in the origin of the world frame: its base seems to be left out.", "6.1", _no_base,
    ),
    Mistake(
        "twist-sign", "Twist with the wrong sign",
        "The twist alpha of row {joint} seems to be taken with the wrong sign: it is the angle from z{joint}'s "
        "predecessor to z{joint}, counted about x{joint}.", "Example 6.1", _twist_sign,
    ),
    Mistake(
        "all-twists-sign", "All twists with the wrong sign",
        "All twists alpha seem to be taken with the wrong sign: each is counted about x from one z to the next.",
        "Example 6.1", _all_twists,
    ),
    Mistake(
        "twist-forgotten", "Twist left out",
        "The twist alpha of row {joint} seems to be left out: the axes behind it are turned by it.",
        "Example 6.1", _twist_left_out,
    ),
    Mistake(
        "modified-dh", "Another Denavit-Hartenberg convention",
        "The table seems to be read in the other (modified) convention. Here a frame is reached by turning and moving "
        "along z first, and along x after that: Rz Tz Tx Rx.", "Example 6.1", _modified, rare=True,
    ),
    Mistake(
        "a-and-d-exchanged", "a and d exchanged",
        "In row {link} of the table, a and d seem to be exchanged: d is measured along z, a along x.",
        "Example 6.1", _exchanged, rare=True,
    ),
    Mistake(
        "joint-turns-other-way", "A joint that turns the other way",
        "Joint {joint} seems to turn the other way: its angle counts counterclockwise about its z axis.",
        "6.1", _other_way, rare=True,
    ),
    Mistake(
        "quarter-turn", "A quarter turn too much",
        "The angle of joint {joint} seems to be a quarter turn off: it is counted from the x axis before to the one "
        "behind.", "6.1", _turned_too_far, rare=True,
    ),
    Mistake(
        "degrees", "Degrees for radians",
        "The angles seem to be turned from degrees into radians. They are in radians already.", "6.1", _degrees,
        rare=True,
    ),
)  # fmt: skip
