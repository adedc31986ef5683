"""Mistakes with screws and exponentials, for arms that are described by their axes at home."""

from collections.abc import Callable, Iterator
from functools import reduce

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, cross, product
from qdot.exercises.arm.axes_to_dh import Axis
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import SCREWS as HAS_SCREWS
from qdot.exercises.arm.derivation_graph import Change, Table, Working, adjoint, constant, propagate_linear_rows
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.mistakes.base import Mistake, MistakeVariant, Shape

SCREWS = ("home screws", "space jacobian", "body jacobian")
"""The stages whose columns are screws."""
SOURCE = "the product of exponentials"
Variants = Callable[[Chain, Shape], Iterator[MistakeVariant]]


def _only_for_screws(slips: Callable[[Chain], Iterator[MistakeVariant]]) -> Variants:
    """Restrict variants to arms that are described by their axes."""

    def only(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
        if HAS_SCREWS in convention_of(chain).has:
            yield from slips(chain)

    return only


def _flip_moment(chain: Chain) -> Iterator[MistakeVariant]:
    def apply_change(w: Working, columns: np.ndarray) -> np.ndarray:
        out = np.array(columns)
        for i, kind in enumerate(w["kinds"]):
            if kind == "R":
                out[3:, i] = -out[3:, i]
        return out

    yield from (MistakeVariant({stage: apply_change}) for stage in SCREWS)


def _use_point(chain: Chain) -> Iterator[MistakeVariant]:
    """Take a point on the axis for the velocity."""

    def points(w: Working, columns: np.ndarray) -> np.ndarray:
        out = np.array(columns)
        for i, (kind, axis) in enumerate(zip(w["kinds"], axes_of(w.chain)[0], strict=True)):
            if kind == "R":
                out[3:, i] = constant(w, axis.point)
        return out

    yield MistakeVariant({"home screws": points})


def _exchange_halves(chain: Chain) -> Iterator[MistakeVariant]:
    exchanged: Change = lambda _, columns: np.concatenate([columns[3:], columns[:3]])  # noqa: E731
    yield from (MistakeVariant({stage: exchanged}) for stage in (*SCREWS, "geometric"))


def _put_slide_above(chain: Chain) -> Iterator[MistakeVariant]:
    def apply_change(w: Working, columns: np.ndarray) -> np.ndarray:
        out = np.array(columns)
        for i, kind in enumerate(w["kinds"]):
            if kind == "P":
                out[:, i] = np.concatenate([columns[3:, i], columns[:3, i]])
        return out

    kinds = {joint.kind for joint in chain.joints}
    if kinds == {"R", "P"}:
        yield from (MistakeVariant({stage: apply_change}) for stage in SCREWS)


def _use_home_screws(chain: Chain) -> Iterator[MistakeVariant]:
    def about_the_point(w: Working, _: np.ndarray) -> np.ndarray:
        point, home = _home_point(w), w["home screws"]
        moved = [home[3:, i] + cross(home[:3, i], point) for i in range(w.n)]
        return np.concatenate([home[:3], np.stack(moved, axis=1)])

    yield MistakeVariant({"space jacobian": lambda w, _: w["home screws"]})
    yield MistakeVariant({"body jacobian": about_the_point})


def _use_other_frame(chain: Chain) -> Iterator[MistakeVariant]:
    yield MistakeVariant(
        {"space jacobian": lambda w, _: w.without("space jacobian")["body jacobian"]}, _FRAMES["space"]
    )
    yield MistakeVariant({"body jacobian": lambda w, _: w["space jacobian"]}, _FRAMES["body"])


_FRAMES: dict[str, dict[str, object]] = {
    "space": {"wanted": "space", "taken": "body"},
    "body": {"wanted": "body", "taken": "space"},
}


def _use_point_velocity(chain: Chain) -> Iterator[MistakeVariant]:
    """Take the velocity of P instead of that of the point at the origin."""
    yield MistakeVariant({"space jacobian": lambda w, _: np.concatenate([w["geometric"][3:], w["geometric"][:3]])})


def _skip_rotation(chain: Chain) -> Iterator[MistakeVariant]:
    yield MistakeVariant({"body jacobian": lambda w, _: np.concatenate([w["geometric"][3:], w["geometric"][:3]])})


def _rotate_backwards(chain: Chain) -> Iterator[MistakeVariant]:
    def turned(w: Working, _: np.ndarray) -> np.ndarray:
        halves = w["geometric"][3:], w["geometric"][:3]
        return np.concatenate([product(w["body rotation"], half) for half in halves])

    yield MistakeVariant({"body jacobian": turned})


def _keep_origin(chain: Chain) -> Iterator[MistakeVariant]:
    """Rotate the space Jacobian into the body frame, but leave its reference point at the space frame's origin."""

    def turned(w: Working, _: np.ndarray) -> np.ndarray:
        back = w["body rotation"].swapaxes(0, 1)
        return np.concatenate([product(back, w["space jacobian"][:3]), product(back, w["space jacobian"][3:])])

    yield MistakeVariant({"body jacobian": turned})


# --- the adjoint ---


def _change_adjoint(build: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Variants:
    """Return the variants that build [Ad T] from the rotation (3, 3, …) and the origin (3, …) in another way."""

    def slips(chain: Chain) -> Iterator[MistakeVariant]:
        yield MistakeVariant({"body adjoint": lambda w, _: build(w["body rotation"], w["point"])})

    return _only_for_screws(slips)


def _stack_blocks(upper: np.ndarray, right: np.ndarray, left: np.ndarray, lower: np.ndarray) -> np.ndarray:
    return np.concatenate([np.concatenate([upper, right], axis=1), np.concatenate([left, lower], axis=1)])


def _hat(vector: np.ndarray) -> np.ndarray:
    """Return the matrix [v], (3, 3, …)."""
    x, y, z = vector
    return np.stack([np.stack([0 * x, -z, y]), np.stack([z, 0 * x, -x]), np.stack([-y, x, 0 * x])])


def _invert(turn: np.ndarray, place: np.ndarray) -> np.ndarray:
    back = turn.swapaxes(0, 1)
    return adjoint(back, -apply_matrix(back, place))


def _transpose_rotation(turn: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Take the adjoint with R transposed, but the right P."""
    return adjoint(turn.swapaxes(0, 1), place)


# --- exponentials ---


def _exponential(w: Working, axis: Axis, i: int) -> tuple[np.ndarray, np.ndarray]:
    """Return rotation (3, 3, …) and shift (3, …) of a joint's motion, by Rodrigues' formula."""
    q = w.arithmetic.table_entry(w.chain.q[i])
    u = constant(w, axis.direction)
    zero, unit = 0 * u[0], 0 * u[0] + 1
    identity = np.stack([np.stack(row) for row in ((unit, zero, zero), (zero, unit, zero), (zero, zero, unit))])
    if axis.kind == "P":
        return identity, w.arithmetic.value(q)[None] * u
    s, c = w.arithmetic.value(w.arithmetic.sin(q)), w.arithmetic.value(w.arithmetic.cos(q))
    hat = np.stack([np.stack([zero, -u[2], u[1]]), np.stack([u[2], zero, -u[0]]), np.stack([-u[1], u[0], zero])])
    turn = identity + s * hat + (unit - c) * product(hat, hat)
    point = constant(w, axis.point)
    return turn, point - apply_matrix(turn, point)


def _exponentials(w: Working) -> list[tuple[np.ndarray, np.ndarray]]:
    return [_exponential(w, axis, i) for i, axis in enumerate(axes_of(w.chain)[0])]


Motion = tuple[np.ndarray, np.ndarray]


def _compose(first: Motion, second: Motion) -> Motion:
    """Return the motion of the product of two exponentials."""
    return product(first[0], second[0]), apply_matrix(first[0], second[1]) + first[1]


def _compose_all(w: Working, in_order: bool) -> Motion:
    """Return the motion of the product of all exponentials, joint 1 on the left if they are in order."""
    each = _exponentials(w)
    return reduce(_compose, each if in_order else each[::-1])


def _carry_screws(w: Working, each: list[Motion]) -> np.ndarray:
    """Return the screws at home, each moved by the motions of the joints before it, (6, n, …)."""
    home = w["home screws"]
    out, motion = [home[:, 0]], each[0]
    for i in range(1, w.n):
        angular, linear = apply_matrix(motion[0], home[:3, i]), apply_matrix(motion[0], home[3:, i])
        out.append(np.concatenate([angular, linear + cross(motion[1], angular)]))
        motion = _compose(motion, each[i])
    return np.stack(out, axis=1)


def _home_point(w: Working) -> np.ndarray:
    """Return where P is at home, (3, …)."""
    return constant(w, axes_of(w.chain)[1])


def _reverse_order(chain: Chain) -> Iterator[MistakeVariant]:
    """Multiply the exponentials from the last to the first: in the pose, and before each screw."""

    def point(w: Working, _: np.ndarray) -> np.ndarray:
        turn, shift = _compose_all(w, in_order=False)
        return apply_matrix(turn, _home_point(w)) + shift

    def columns(w: Working, _: np.ndarray) -> np.ndarray:
        home, each = w["home screws"], _exponentials(w)
        out, motion = [home[:, 0]], each[0]
        for i in range(1, w.n):
            angular, linear = apply_matrix(motion[0], home[:3, i]), apply_matrix(motion[0], home[3:, i])
            out.append(np.concatenate([angular, linear + cross(motion[1], angular)]))
            motion = _compose(each[i], motion)
        return np.stack(out, axis=1)

    if chain.n > 1:
        yield MistakeVariant({"body rotation": lambda w, _: _compose_all(w, in_order=False)[0], "point": point})
    if chain.n > 2:
        yield MistakeVariant({"space jacobian": columns})


def _put_home_left(chain: Chain) -> Iterator[MistakeVariant]:
    """Put M on the left, M e^(S_1) ... e^(S_n), although it belongs on the right."""
    yield MistakeVariant({"point": lambda w, _: _home_point(w) + _compose_all(w, in_order=True)[1]})


def _drop_home(chain: Chain) -> Iterator[MistakeVariant]:
    """Leave M out of the product."""
    yield MistakeVariant({"point": lambda w, _: _compose_all(w, in_order=True)[1]})


def _drop_shift(chain: Chain) -> Iterator[MistakeVariant]:
    """Leave (I - R) q out of the exponentials of all joints that have it, or of one: they rotate about the origin."""
    axes = axes_of(chain)[0]
    shifting = [
        i for i, axis in enumerate(axes) if axis.kind == "R" and any(axis.direction.cross(axis.point))
    ]  # through the origin there is none
    for some in [shifting, *([[i] for i in shifting] if len(shifting) > 1 else [])] if shifting else []:

        def motions(w: Working, some: list[int] = some) -> list[Motion]:
            return [(turn, 0 * shift if i in some else shift) for i, (turn, shift) in enumerate(_exponentials(w))]

        def point(w: Working, _: np.ndarray, motions: Callable[[Working], list[Motion]] = motions) -> np.ndarray:
            turn, shift = reduce(_compose, motions(w))
            return apply_matrix(turn, _home_point(w)) + shift

        def columns(w: Working, _: np.ndarray, motions: Callable[[Working], list[Motion]] = motions) -> np.ndarray:
            return _carry_screws(w, motions(w))

        words = {"joint": " and ".join(str(i + 1) for i in some)}
        yield MistakeVariant({"point": point}, words)
        if some[0] < chain.n - 1:
            yield MistakeVariant({"space jacobian": columns}, words)


def _keep_points(chain: Chain) -> Iterator[MistakeVariant]:
    """Rotate the axes, but leave the points on them at home."""

    def columns(w: Working, right: np.ndarray) -> np.ndarray:
        out = np.array(right)
        for i, axis in enumerate(axes_of(w.chain)[0]):
            if axis.kind == "R":
                out[3:, i] = -cross(right[:3, i], constant(w, axis.point))
        return out

    yield MistakeVariant({"space jacobian": columns})


def _confuse_degrees(chain: Chain) -> Iterator[MistakeVariant]:
    """Take sines and cosines of degrees, or convert to radians what is in radians already."""
    for factor in (180 / sp.pi, sp.pi / 180):

        def scaled(w: Working, table: Table, factor: sp.Expr = factor) -> Table:
            for i, (q, offset, row) in enumerate(zip(chain.q, chain.offsets, table.rows, strict=False)):
                if row.kind == "R":
                    table = table.with_row(i, theta=w.arithmetic.table_entry(factor * q + offset))
            return table

        if any(joint.kind == "R" for joint in chain.joints):
            yield MistakeVariant({"table": scaled, "linear": propagate_linear_rows})


MISTAKES = (
    Mistake(
        "screw-sign", "Screw with the wrong sign of its velocity",
        "The halves v of the screws seem to have the wrong sign: the point at the origin moves at -omega x q.",
        SOURCE, _only_for_screws(_flip_moment),
    ),
    Mistake(
        "screw-point", "Point on the axis for the velocity of a screw",
        "The halves v of the screws seem to hold points on the axes: they hold velocities, -omega x q.",
        SOURCE, _only_for_screws(_use_point),
    ),
    Mistake(
        "twist-rows-exchanged", "Halves of a twist exchanged",
        "The upper and the lower half seem to be exchanged: the question says in which order the rows stand.", SOURCE,
        _only_for_screws(_exchange_halves),
    ),
    Mistake(
        "slide-above", "Direction of a slide for its angular velocity",
        "The direction of a slide seems to stand in the half omega of its screw: a slide turns nothing, and its "
        "direction is v.", SOURCE, _only_for_screws(_put_slide_above),
    ),
    Mistake(
        "screws-at-home", "Screws as they are at home",
        "The columns seem to be the screws at home: each is carried along by other joints, of the space Jacobian by "
        "those before it, of the body Jacobian by those behind.", SOURCE, _only_for_screws(_use_home_screws),
    ),
    Mistake(
        "other-twist-frame", "Space and body frame exchanged",
        "The answer seems to be that of the {taken} frame: it is wanted for the {wanted} frame.", SOURCE,
        _only_for_screws(_use_other_frame),
    ),
    Mistake(
        "velocity-of-p", "Velocity of P in the space frame",
        "The half v seems to be the velocity of P: in the space frame it is that of the point of the last link "
        "that is at the origin.", SOURCE, _only_for_screws(_use_point_velocity),
    ),
    Mistake(
        "body-not-turned", "Body frame's velocities in the coordinates of the space frame",
        "The velocities seem to be left in the coordinates of the space frame: the body frame sees them turned by the "
        "transposed rotation.", SOURCE, _only_for_screws(_skip_rotation),
    ),
    Mistake(
        "body-turned-the-other-way", "Turned by the rotation of the body frame for its transpose",
        "The velocities seem to be turned by the rotation of the body frame: its transpose takes them into that frame.",
        SOURCE, _only_for_screws(_rotate_backwards), rare=True,
    ),
    Mistake(
        "body-about-origin", "Reference point not moved to the body frame",
        "The space Jacobian seems to be turned into the body frame only: its velocities are those of another point, "
        "and are to be moved to P.", SOURCE, _only_for_screws(_keep_origin), rare=True,
    ),
    Mistake(
        "adjoint-of-inverse", "Adjoint of the inverse",
        "The adjoint seems to be that of T_bs, which takes twists into the body frame: it is wanted for T_sb.", SOURCE,
        _change_adjoint(_invert),
    ),
    Mistake(
        "adjoint-block-above", "[P] R in the wrong block",
        "The block [P] R seems to stand in the wrong corner: it takes omega to v, and stands in the rows of v and the "
        "columns of omega.", SOURCE,
        _change_adjoint(lambda turn, place: _stack_blocks(turn, product(_hat(place), turn), 0 * turn, turn)),
    ),
    Mistake(
        "adjoint-order", "R [P] for [P] R",
        "The block beside the two rotations seems to be R [P]: R turns vectors into the space frame first, and [P] is "
        "on its left.", SOURCE,
        _change_adjoint(lambda turn, place: _stack_blocks(turn, 0 * turn, product(turn, _hat(place)), turn)),
    ),
    Mistake(
        "adjoint-sign", "[P] R with the wrong sign",
        "The block [P] R of the adjoint seems to have the wrong sign: the point at the origin moves at v + P x omega.",
        SOURCE, _change_adjoint(lambda turn, place: adjoint(turn, -place)),
    ),
    Mistake(
        "adjoint-without-p", "Twist turned, and not moved",
        "Both halves of the twist seem to be turned only: in the space frame, its velocity is that of another point, "
        "for which there is [P] R.", SOURCE, _change_adjoint(lambda turn, place: adjoint(turn, 0 * place)),
    ),
    Mistake(
        "adjoint-not-turned", "[P] for [P] R",
        "The block [P] R seems to be [P]: it is multiplied by R, which turns the angular velocity first.",
        SOURCE, _change_adjoint(lambda turn, place: _stack_blocks(turn, 0 * turn, _hat(place), turn)),
    ),
    Mistake(
        "rotation-transposed", "Rotation of the body frame transposed",
        "R seems to be transposed: the columns of R_sb are the axes of the body frame as the space frame sees them.",
        SOURCE, _change_adjoint(_transpose_rotation), rare=True,
    ),
    Mistake(
        "exponentials-reversed", "Exponentials in the wrong order",
        "The exponentials seem to be multiplied in the wrong order: joint 1 stands on the left.", SOURCE,
        _only_for_screws(_reverse_order),
    ),
    Mistake(
        "home-pose-left", "M on the left",
        "The pose at home seems to stand on the left of the exponentials: with screws in the space frame it stands on "
        "the right.", SOURCE, _only_for_screws(_put_home_left),
    ),
    Mistake(
        "home-pose-forgotten", "M left out",
        "The pose at home seems to be left out: the product of the exponentials is multiplied by it.", SOURCE,
        _only_for_screws(_drop_home),
    ),
    Mistake(
        "exponential-about-origin", "(I - R) q left out of an exponential",
        "The exponential of joint {joint} seems to turn about the origin: the axis goes through q, so that beside R "
        "there is the column (I - R) q.", SOURCE, _only_for_screws(_drop_shift),
    ),
    Mistake(
        "points-at-home", "Points of the axes as they are at home",
        "The points on the axes seem to be those at home: the joints before an axis carry it along, its points, too.",
        SOURCE, _only_for_screws(_keep_points), rare=True,
    ),
    Mistake(
        "joints-in-degrees", "Degrees for radians in exponentials",
        "Degrees and radians seem to be mixed up: joint angles are in radians, and stand under sine and cosine as they "
        "are.", SOURCE,
        _only_for_screws(_confuse_degrees), rare=True,
    ),
)  # fmt: skip
