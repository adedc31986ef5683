"""Variation: how far the arms of a class lead away from that of the chapter, by named axes and by steps of them.

An axis changes one thing of an arm. A step is a set of axes; each holds those of the step before.
"""

from collections.abc import Sequence

from qdot.exercises.common.errors import QdotError, unknown

AXES = ("lengths", "zeros", "senses", "base", "tool", "task")
"""What may vary, in the order in which it is drawn. Which of them a family has is the family's (`Family.axes`)."""

STEPS: dict[str, tuple[str, ...]] = {
    "chapter": (),
    "lengths": ("lengths",),
    "zeros": ("lengths", "zeros"),
    "frames": ("lengths", "zeros", "senses", "base"),
    "full": AXES,
}
"""The steps from the arm as the chapter draws it to one on which everything varies."""

DEFAULT = "zeros"
"""The step where none is asked for: lengths and zeros of a student's own, everything else as the chapter has it."""


def axes_of(variation: str) -> tuple[str, ...]:
    """Return the axes of a step, or of a text of axes as in "lengths+base". Raises QdotError for any other.

    A name that is a step's is the step's; with a + before it, the axis is meant.

    >>> axes_of("zeros"), axes_of("+zeros"), axes_of("base+lengths")
    (('lengths', 'zeros'), ('zeros',), ('lengths', 'base'))
    """
    return STEPS[variation] if variation in STEPS else _check_axes(variation.removeprefix("+").split("+"))


def canonical_name(variation: str) -> str:
    """Return the one name of a variation: a step's where it is one, else its axes in order. Raises QdotError.

    >>> canonical_name("zeros+lengths"), canonical_name("base+lengths"), canonical_name("+zeros")
    ('zeros', 'lengths+base', '+zeros')
    """
    return _name(axes_of(variation))


def name_of_axes(names: Sequence[str]) -> str:
    """Return the name of the variation along some axes; without any, it is the chapter's arm. Raises QdotError.

    >>> name_of_axes(["zeros"]), name_of_axes([])
    ('+zeros', 'chapter')
    """
    return _name(_check_axes(names))


def _name(axes: tuple[str, ...]) -> str:
    text = "+".join(axes)
    return next((step for step, its in STEPS.items() if its == axes), f"+{text}" if text in STEPS else text)


def _check_axes(names: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        if name not in AXES:
            raise unknown("variation", name, [*STEPS, *(axis for axis in AXES if axis not in STEPS)])
        if names.count(name) > 1:
            raise QdotError(f"variation: {name} is named twice")
    return tuple(name for name in AXES if name in names)
