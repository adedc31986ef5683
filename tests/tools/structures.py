"""Find every structure of 2, 3 or 4 joints that makes a clean problem: exercises/families/structures.txt.

    python -m tests.tools.structures      rewrites the table (half a minute)

Two tables describe the same arm, and have the same normal form, if they differ only in properties that change nothing
in J except signs and names:
  - the directions of axes (signs of twists) and mirror images;
  - the placement of the base: d_1 of a revolute first joint, theta_1 and a_1 of a prismatic one;
  - offsets along one line: d_i after a parallel axis adds to d_(i-1), or to the zero of the prismatic joint there;
  - the last twist, because no axis follows it.

Different normal forms with their tasks can still give the same problem; they then form one class. The revolute joints
divide a chain into bodies: the first is the base, and the last contains the point of interest. A body has the axes of
the revolute joints before and after it, prismatic axes, and a constant offset. All angles are right angles, so all of
these lie along three perpendicular axes. J is the same except for signs and names if the bodies differ only in
  - the directions of axes and the signs of lengths, which includes mirror images;
  - the zeros of the joints, which shift angles by multiples of 90 degrees;
  - the placement of the base, and the names x, y and z of the world's axes, with the rows of the task;
  - the order of prismatic joints in one body, and offsets along a prismatic axis, which shift that joint's zero;
  - the places where links meet a revolute axis: such offsets add up over consecutive parallel axes, and shift the
    height of the base or the zero of a parallel prismatic joint, if there is one.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations, permutations, product

import numpy as np

from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.stream import Stream
from qdot.exercises.families.structures import STRUCTURES_FILE, Structure, StructureRow, build_arm, is_clean
from qdot.exercises.singularities.difficulty import rate_difficulty_band


def tables(n: int, angles: bool) -> Iterator[tuple[StructureRow, ...]]:
    """Yield every DH table of n joints, up to the signs of the twists, which are 0 or ±90 degrees.

    Angles of prismatic joints are 0, or with `angles` also 90 degrees. The last twist is 0.
    """
    kinds = [StructureRow("R", a, d, x) for a, d, x in product((False, True), repeat=3)]
    kinds += [StructureRow("P", a, d, x) for a, d, x in product((False, True), repeat=3) if angles or not d]
    last = [row for row in kinds if not row.has_twist]
    yield from product(*[kinds] * (n - 1), last)


def count_tables(n: int, angles: bool) -> int:
    """Return the number of DH tables with twists in {0, 90, -90} degrees, counting both signs.

    >>> count_tables(2, False), count_tables(3, False), count_tables(3, True)
    (108, 1944, 4608)
    """
    return sum(2 ** sum(row.has_twist for row in rows) for rows in tables(n, angles))


def normal_form(rows: tuple[StructureRow, ...]) -> tuple[StructureRow, ...]:
    """Return the normal form of a structure (see the top of the module).

    >>> " ".join(map(str, normal_form((StructureRow("R", False, True, False), StructureRow("R", True, True, False)))))
    'R Ra'
    """
    first = rows[0]
    normal_rows = [
        StructureRow("R", first.has_a, False, first.has_twist)
        if first.is_revolute
        else StructureRow("P", False, False, first.has_twist)
    ]
    for row in rows[1:]:
        before = normal_rows[-1]
        if row.is_revolute and row.has_fixed_entry and not before.has_twist:
            has_d = len(normal_rows) > 1
            normal_rows[-1] = StructureRow("R", before.has_a, has_d, before.has_twist) if before.is_revolute else before
            normal_rows.append(StructureRow("R", row.has_a, False, row.has_twist))
        else:
            normal_rows.append(row)
    result = tuple(normal_rows)
    return result if result == rows else normal_form(result)


@lru_cache(maxsize=8192)
def _find_nonzero_rows(rows: tuple[StructureRow, ...]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return Jacobians at random configurations (k x 6 x n), and the names of the rows that are not always zero."""
    chain, stream = build_arm(rows, ("vx",)), Stream("structures")
    arm = NumericChain(chain, {symbol.name: stream.uniform(0.4, 1.2) for symbol in chain.parameters})
    jacobians = arm.compute_jacobian(np.array([[stream.uniform(-3, 3) for _ in rows] for _ in range(6)]))
    moving = np.abs(jacobians).max(axis=(0, 2)) > 1e-9
    return jacobians, tuple(row for row, moves in zip(VELOCITY_NAMES, moving, strict=True) if moves)


def regular_tasks(rows: tuple[StructureRow, ...]) -> list[tuple[str, ...]]:
    """Return the tasks for questions about a structure: those in which J is square and generically regular.

    Two joints have two of vx, vy, vz. Three joints have vx, vy, vz; an arm that stays in a plane has two of these and
    the rotation in its plane; a wrist has wx, wy, wz. Four joints have vx, vy, vz and one rotation, if the arm rotates
    about only one axis of the world.
    """
    jacobians, moving = _find_nonzero_rows(rows)
    linear, turns = [row for row in moving if row[0] == "v"], [row for row in moving if row[0] == "w"]
    tasks: list[tuple[str, ...]] = []
    if len(rows) == 2:
        tasks = list(combinations(linear, 2))
    elif len(rows) == 4:
        tasks = [moving] if len(linear) == 3 and len(turns) == 1 else []
    elif len(linear) == 3 or moving == VELOCITY_NAMES[3:]:
        tasks = [moving[:3]]
    elif {row[1] for row in moving} == set("xyz") and (len(linear), len(turns)) == (2, 1):
        tasks = [moving]
    return [task for task in tasks if _is_regular(jacobians[:, [VELOCITY_NAMES.index(row) for row in task]])]


def _is_regular(jacobians: np.ndarray) -> bool:
    sigma = np.linalg.svd(jacobians, compute_uv=False)
    return bool((sigma[:, -1] > 1e-6).any())


def regular_forms(n: int) -> dict[tuple[StructureRow, ...], list[tuple[str, ...]]]:
    """Return the normal forms of n joints that are regular in some task, with these tasks, sorted by code."""
    forms = sorted({normal_form(rows) for rows in tables(n, True)}, key=lambda rows: " ".join(map(str, rows)))
    return {rows: tasks for rows in forms if (tasks := regular_tasks(rows))}


def find_clean_structures(n: int) -> list[Structure]:
    """Return the structures of n joints that are clean in some task, with numbers of their classes."""
    chains = ((rows, task, build_arm(rows, task)) for rows, tasks in regular_forms(n).items() for task in tasks)
    numbers: dict[Key, int] = {}
    return [
        Structure(rows, task, rate_difficulty_band(chain), numbers.setdefault(class_key(rows, task), len(numbers)))
        for rows, task, chain in chains
        if is_clean(chain)
    ]


# --- classes ---

Key = tuple[object, ...]

PREVIOUS_AXIS = 2
"""The axis of the revolute joint before a body, in the frame in which the body begins (0, 1, 2 for x, y, z)."""


@dataclass
class _Body:
    """The rigid part between two revolute joints, with its prismatic joints.

    Axes are numbered in the frame in which the body begins (0, 1, 2 for x, y, z).
    `next_axis` is the axis of the next revolute joint, or None for the last body.
    """

    next_axis: int | None = None
    prismatic_axes: list[int] = field(default_factory=list)
    offsets: set[int] = field(default_factory=set)


def class_key(rows: Sequence[StructureRow], task: Sequence[str] = ()) -> Key:
    """Return a key that is the same for structures of one class, and differs between classes.

    >>> from qdot.exercises.families.structures import parse_rows
    >>> planar = class_key(parse_rows("R Ra"))
    >>> class_key(parse_rows("Rd Rad")) == planar, class_key(parse_rows("Rx Ra")) == planar
    (True, False)
    >>> class_key(parse_rows("Rx Ra"), ("vx", "vz")) == class_key(parse_rows("Rx Ra"), ("vy", "vz"))
    True
    """
    base, *later_bodies = _split_into_bodies(rows)
    kinds = "".join(row.kind for row in rows)
    return (kinds, _make_base_key(base, task), *map(_make_body_key, later_bodies), *_axial_offsets(base, later_bodies))


def _split_into_bodies(rows: Sequence[StructureRow]) -> list[_Body]:
    bodies, axes = [_Body()], (0, 1, 2)
    for row in rows:
        if row.is_revolute:
            bodies[-1].next_axis = axes[2]
            bodies.append(_Body(offsets={PREVIOUS_AXIS} if row.has_fixed_entry else set()))
            axes = (0, 1, 2)
        else:
            if row.has_fixed_entry:
                axes = (axes[1], axes[0], axes[2])
            bodies[-1].prismatic_axes.append(axes[2])
        if row.has_a:
            bodies[-1].offsets.add(axes[0])
        if row.has_twist:
            axes = (axes[0], axes[2], axes[1])
    return bodies


def _axis_names(names: Sequence[int], axes: Iterable[int]) -> tuple[int, ...]:
    return tuple(sorted(names[axis] for axis in axes))


def _make_base_key(base: _Body, task: Sequence[str]) -> Key:
    """Return the next axis, the prismatic axes and the task, with the axes named so that the key is least."""
    linear, angular = ([axis for axis, name in enumerate("xyz") if kind + name in task] for kind in "vw")
    next_axes = [] if base.next_axis is None else [base.next_axis]
    return min(
        tuple(_axis_names(names, axes) for axes in (next_axes, base.prismatic_axes, linear, angular))
        for names in permutations(range(3))
    )


def _make_body_key(body: _Body) -> Key:
    """Return the directions of the body's axes, its prismatic axes, and the offsets perpendicular to all of them.

    If the axes are parallel or there is no next axis, the two directions perpendicular to them are interchangeable.
    """
    offsets = body.offsets - {PREVIOUS_AXIS, body.next_axis} - set(body.prismatic_axes)
    same, swapped = (0, 1, 2), (1, 0, 2)
    if body.next_axis in (None, PREVIOUS_AXIS):
        arrangement, names = "last" if body.next_axis is None else "parallel", [same, swapped]
    else:
        arrangement, names = "perpendicular", [same] if body.next_axis == 1 else [swapped]
    return min((arrangement, _axis_names(name, body.prismatic_axes), _axis_names(name, offsets)) for name in names)


def _axial_offsets(base: _Body, later_bodies: Sequence[_Body]) -> Iterator[bool]:
    """Yield for every row of parallel revolute axes whether an offset along them counts."""
    previous_body, first = base, 0
    while first < len(later_bodies):
        last = first
        while later_bodies[last].next_axis == PREVIOUS_AXIS:
            last += 1
        row = later_bodies[first : last + 1]
        has_offset = previous_body.next_axis in previous_body.offsets or any(
            PREVIOUS_AXIS in body.offsets for body in row
        )
        is_absorbed = previous_body.next_axis in previous_body.prismatic_axes or any(
            PREVIOUS_AXIS in body.prismatic_axes for body in row
        )
        yield has_offset and not is_absorbed and first > 0
        previous_body, first = later_bodies[last], last + 1


if __name__ == "__main__":
    lines = (str(structure) for n in (2, 3, 4) for structure in find_clean_structures(n))
    write_atomically(STRUCTURES_FILE, "# made by tests.tools.structures\n" + "\n".join(lines) + "\n")
