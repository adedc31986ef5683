"""When two structures, each with a task, are the same problem: J is the same but for signs and names.

A chain is a row of bodies between its revolute joints: the first is the base, the last holds the point of interest.
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
from itertools import permutations
from typing import Protocol


class StructureRow(Protocol):
    """What is asked of a row of a structure, as in `structures.Row`."""

    @property
    def kind(self) -> str: ...  # noqa: D102
    @property
    def a(self) -> bool: ...  # noqa: D102
    @property
    def d(self) -> bool: ...  # noqa: D102
    @property
    def twist(self) -> bool: ...  # noqa: D102


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

    >>> from qdot.exercises.families.structures import read_rows
    >>> planar = class_key(read_rows("R Ra"))
    >>> class_key(read_rows("Rd Rad")) == planar, class_key(read_rows("Rx Ra")) == planar
    (True, False)
    >>> class_key(read_rows("Rx Ra"), ("vx", "vz")) == class_key(read_rows("Rx Ra"), ("vy", "vz"))
    True
    """
    base, *others = _bodies(rows)
    kinds = "".join(row.kind for row in rows)
    return (kinds, _base_key(base, task), *map(_square_key, others), *_axial_offsets(base, others))


def _bodies(rows: Sequence[StructureRow]) -> list[_Body]:
    bodies, axes = [_Body()], (0, 1, 2)
    for row in rows:
        if row.kind == "R":
            bodies[-1].behind = axes[2]
            bodies.append(_Body(offsets={BEFORE} if row.d else set()))
            axes = (0, 1, 2)
        else:
            if row.d:
                axes = (axes[1], axes[0], axes[2])
            bodies[-1].slides.append(axes[2])
        if row.a:
            bodies[-1].offsets.add(axes[0])
        if row.twist:
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


def _axial_offsets(base: _Body, others: Sequence[_Body]) -> Iterator[bool]:
    """Yield for every row of parallel revolute axes whether an offset along them counts."""
    before, first = base, 0
    while first < len(others):
        last = first
        while others[last].behind == BEFORE:
            last += 1
        row = others[first : last + 1]
        offset = before.behind in before.offsets or any(BEFORE in body.offsets for body in row)
        slide = before.behind in before.slides or any(BEFORE in body.slides for body in row)
        yield offset and not slide and first > 0
        before, first = others[last], last + 1
