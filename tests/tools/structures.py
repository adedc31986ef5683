"""Find every structure of 2, 3 or 4 joints that makes a clean problem: exercises/families/structures.txt.

    python -m tests.tools.structures      rewrites the table (half a minute)

Two tables are the same arm, and have one normal form, if they differ only in what leaves J unchanged but for signs and
names:
  - the sense of axes (signs of twists) and mirror images;
  - where the base stands: d_1 of a revolute first joint, theta_1 and a_1 of a prismatic one;
  - offsets along one line: d_i behind a parallel axis adds to d_(i-1), or to the zero of the prismatic joint there;
  - the last twist, which no axis follows.

Normal forms, each with a task, can still be the same problem; then they are of one class. A chain is a row of bodies
between its revolute joints: the first is the base, the last holds the point of interest.
A body has the axis of the revolute joint before it, that of the joint behind it, slides along some of its axes, and a
constant offset; with right angles everywhere, all of that lies along three axes square to each other. J is the same
but for signs and names where the bodies agree in everything but
  - the senses of axes and the signs of lengths, which includes mirror images;
  - the zeros of the joints, angles by multiples of 90 degrees;
  - where the base stands, and which of the world's axes are called x, y and z, the rows of the task going with them;
  - the order of slides in one body, and offsets along one of its slides, which shift that slide's zero;
  - where along a revolute axis a link meets it: such offsets add up over parallel axes in a row, and shift the base's
    height or the zero of a slide that runs the same way, if there is one.
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
    """Yield every DH table of n joints with twists 0, 90 and -90 counted thrice; `angles` of slides 0 or 90 degrees.

    A row stands for as many tables as its twist has signs; `count_tables` counts them.
    """
    kinds = [StructureRow("R", a, d, x) for a, d, x in product((False, True), repeat=3)]
    kinds += [StructureRow("P", a, d, x) for a, d, x in product((False, True), repeat=3) if angles or not d]
    last = [row for row in kinds if not row.has_twist]
    yield from product(*[kinds] * (n - 1), last)


def count_tables(n: int, angles: bool) -> int:
    """Return the number of DH tables with twists in {0, 90, -90} degrees.

    >>> count_tables(2, False), count_tables(3, False), count_tables(3, True)
    (108, 1944, 4608)
    """
    return sum(2 ** sum(row.has_twist for row in rows) for rows in tables(n, angles))


def normal_form(rows: tuple[StructureRow, ...]) -> tuple[StructureRow, ...]:
    """Return the normal form of a structure (see above).

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
def _rows_that_move(rows: tuple[StructureRow, ...]) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return Jacobians of the structure at random (k x 6 x n), and the rows that are not zero everywhere."""
    chain, stream = build_arm(rows, ("vx",)), Stream("structures")
    arm = NumericChain(chain, {symbol.name: stream.uniform(0.4, 1.2) for symbol in chain.parameters})
    jacobians = arm.jacobian(np.array([[stream.uniform(-3, 3) for _ in rows] for _ in range(6)]))
    moving = np.abs(jacobians).max(axis=(0, 2)) > 1e-9
    return jacobians, tuple(row for row, moves in zip(VELOCITY_NAMES, moving, strict=True) if moves)


def regular_tasks(rows: tuple[StructureRow, ...]) -> list[tuple[str, ...]]:
    """Return the tasks in which a structure is asked, those in which J is square and regular in general.

    Two joints: two of vx, vy, vz. Three joints: all three; two of them and the turn about the third axis, where the arm
    stays in that plane; or wx, wy, wz for a wrist. Four joints: vx, vy, vz and one turn, where the arm turns about one
    axis of the world only.
    """
    jacobians, moving = _rows_that_move(rows)
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
    """Go through all structures of n joints for those that are clean in a task, and number their classes."""
    chains = ((rows, task, build_arm(rows, task)) for rows, tasks in regular_forms(n).items() for task in tasks)
    numbers: dict[Key, int] = {}
    return [
        Structure(rows, task, rate_difficulty_band(chain), numbers.setdefault(class_key(rows, task), len(numbers)))
        for rows, task, chain in chains
        if is_clean(chain)
    ]


# --- classes ---

Key = tuple[object, ...]

BEFORE = 2
"""The axis of the revolute joint before a body, in the frame in which the body begins (0, 1, 2 for x, y, z)."""


@dataclass
class _Body:
    """Axes are numbered in the frame in which the body begins; `behind` is None for the last body."""

    behind: int | None = None
    slides: list[int] = field(default_factory=list)
    offsets: set[int] = field(default_factory=set)


def class_key(rows: Sequence[StructureRow], task: Sequence[str] = ()) -> Key:
    """Return what all structures of a class have in common, and no others.

    >>> from qdot.exercises.families.structures import parse_rows
    >>> planar = class_key(parse_rows("R Ra"))
    >>> class_key(parse_rows("Rd Rad")) == planar, class_key(parse_rows("Rx Ra")) == planar
    (True, False)
    >>> class_key(parse_rows("Rx Ra"), ("vx", "vz")) == class_key(parse_rows("Rx Ra"), ("vy", "vz"))
    True
    """
    base, *later_bodies = _bodies(rows)
    kinds = "".join(row.kind for row in rows)
    return (kinds, _base_key(base, task), *map(_square_key, later_bodies), *_axial_offsets(base, later_bodies))


def _bodies(rows: Sequence[StructureRow]) -> list[_Body]:
    bodies, axes = [_Body()], (0, 1, 2)
    for row in rows:
        if row.is_revolute:
            bodies[-1].behind = axes[2]
            bodies.append(_Body(offsets={BEFORE} if row.has_fixed_entry else set()))
            axes = (0, 1, 2)
        else:
            if row.has_fixed_entry:
                axes = (axes[1], axes[0], axes[2])
            bodies[-1].slides.append(axes[2])
        if row.has_a:
            bodies[-1].offsets.add(axes[0])
        if row.has_twist:
            axes = (axes[0], axes[2], axes[1])
    return bodies


def _axis_names(names: Sequence[int], axes: Iterable[int]) -> tuple[int, ...]:
    return tuple(sorted(names[axis] for axis in axes))


def _base_key(base: _Body, task: Sequence[str]) -> Key:
    """Return axis, slides and task under those names of the world's axes that come first."""
    linear, turns = ([axis for axis, name in enumerate("xyz") if kind + name in task] for kind in "vw")
    behind = [] if base.behind is None else [base.behind]
    return min(
        tuple(_axis_names(names, axes) for axes in (behind, base.slides, linear, turns))
        for names in permutations(range(3))
    )


def _square_key(body: _Body) -> Key:
    """Return how its axes lie, its slides, and the offsets that are square to its axes and not along a slide.

    Where the axes are parallel, or none follows, the two directions square to them have no names of their own.
    """
    offsets = body.offsets - {BEFORE, body.behind} - set(body.slides)
    same, swapped = (0, 1, 2), (1, 0, 2)
    if body.behind in (None, BEFORE):
        lie, names = "last" if body.behind is None else "parallel", [same, swapped]
    else:
        lie, names = "square", [same] if body.behind == 1 else [swapped]
    return min((lie, _axis_names(name, body.slides), _axis_names(name, offsets)) for name in names)


def _axial_offsets(base: _Body, later_bodies: Sequence[_Body]) -> Iterator[bool]:
    """Yield for every row of parallel revolute axes whether an offset along them counts."""
    before, first = base, 0
    while first < len(later_bodies):
        last = first
        while later_bodies[last].behind == BEFORE:
            last += 1
        row = later_bodies[first : last + 1]
        offset = before.behind in before.offsets or any(BEFORE in body.offsets for body in row)
        slide = before.behind in before.slides or any(BEFORE in body.slides for body in row)
        yield offset and not slide and first > 0
        before, first = later_bodies[last], last + 1


if __name__ == "__main__":
    lines = (str(structure) for n in (2, 3, 4) for structure in find_clean_structures(n))
    write_atomically(STRUCTURES_FILE, "# made by tests.tools.structures\n" + "\n".join(lines) + "\n")
