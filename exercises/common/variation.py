"""Name how much the arms of a class may differ from the chapter's arm: axes of variation, and steps.

An axis of variation is one property that may differ, such as the lengths; it is not a joint axis. A step is a set of
such axes, and each step includes the axes of the step before.
"""

from collections.abc import Sequence

from qdot.exercises.common.errors import QdotError, make_name_error

VARIATION_AXES = ("lengths", "zeros", "senses", "base", "tool", "task")
"""The properties that may vary, in the order in which they are sampled. A family has some of them (`families.base`)."""

VARIATION_STEPS: dict[str, tuple[str, ...]] = {
    "chapter": (),
    "lengths": ("lengths",),
    "zeros": ("lengths", "zeros"),
    "frames": ("lengths", "zeros", "senses", "base"),
    "full": VARIATION_AXES,
}
"""The steps with their axes of variation, from the chapter's own arm to an arm on which everything varies."""

DEFAULT_VARIATION = "zeros"
"""The default step: each student gets other lengths and joint zeros; everything else is as in the chapter."""


def list_variation_axes(variation: str) -> tuple[str, ...]:
    """Return the axes of variation of a step, or of a text such as "lengths+base". Raises QdotError for unknown names.

    If a step and an axis have the same name, the name alone means the step, and the name with a + before it means the
    axis.

    >>> list_variation_axes("zeros"), list_variation_axes("+zeros"), list_variation_axes("base+lengths")
    (('lengths', 'zeros'), ('zeros',), ('lengths', 'base'))
    """
    is_step = variation in VARIATION_STEPS
    return VARIATION_STEPS[variation] if is_step else _check_axes(variation.removeprefix("+").split("+"))


def find_canonical_name(variation: str) -> str:
    """Return the canonical name of a variation: the step's name, or else its axes in order. Raises QdotError.

    >>> find_canonical_name("zeros+lengths"), find_canonical_name("base+lengths"), find_canonical_name("+zeros")
    ('zeros', 'lengths+base', '+zeros')
    """
    return _name_axes(list_variation_axes(variation))


def name_variation(names: Sequence[str]) -> str:
    """Return the name of the variation with these axes; without axes, the name is "chapter". Raises QdotError.

    >>> name_variation(["zeros"]), name_variation([])
    ('+zeros', 'chapter')
    """
    return _name_axes(_check_axes(names))


def _name_axes(axes: tuple[str, ...]) -> str:
    text = "+".join(axes)
    name = f"+{text}" if text in VARIATION_STEPS else text
    return next((step for step, step_axes in VARIATION_STEPS.items() if step_axes == axes), name)


def _check_axes(names: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        if name not in VARIATION_AXES:
            raise make_name_error("variation", name, list(dict.fromkeys((*VARIATION_STEPS, *VARIATION_AXES))))
        if names.count(name) > 1:
            raise QdotError(f"variation: {name} occurs twice")
    return tuple(name for name in VARIATION_AXES if name in names)
