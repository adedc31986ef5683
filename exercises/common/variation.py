"""Names of variations: which properties of the students' arms may differ from the chapter's arm.

An axis of variation is one such property, for example the lengths; it is not a joint axis. A step is a set of axes, and
each step includes the axes of the step before.
"""

from collections.abc import Sequence

from qdot.exercises.common.errors import QdotError, make_name_error

VARIATION_AXES = ("lengths", "zeros", "senses", "base", "tool", "task")
"""The properties that may vary, in the order in which they are sampled.

"zeros" are the joint offsets, and "senses" are the senses of the joint axes.
`families.family` says which of them apply to a family."""

VARIATION_STEPS: dict[str, tuple[str, ...]] = {
    "chapter": (),
    "lengths": ("lengths",),
    "zeros": ("lengths", "zeros"),
    "frames": ("lengths", "zeros", "senses", "base"),
    "full": VARIATION_AXES,
}
"""Maps each step to its axes of variation, from the chapter's own arm to an arm on which everything varies."""

DEFAULT_VARIATION = "zeros"
"""The default step: each student gets other lengths and joint zeros; everything else is as in the chapter."""


def list_variation_axes(variation: str | Sequence[str]) -> tuple[str, ...]:
    """Return the axes of a variation: of a step, of a text such as "lengths+base", or of a list of axes.

    If a step and an axis have the same name, the name alone means the step, and the name with a + before it means the
    axis. Raises QdotError for unknown names.

    >>> list_variation_axes("zeros"), list_variation_axes("+zeros"), list_variation_axes("base+lengths")
    (('lengths', 'zeros'), ('zeros',), ('lengths', 'base'))
    """
    if isinstance(variation, str) and variation in VARIATION_STEPS:
        return VARIATION_STEPS[variation]
    names = variation.removeprefix("+").split("+") if isinstance(variation, str) else list(variation)
    for name in names:
        if name not in VARIATION_AXES:
            raise make_name_error("variation", name, list(dict.fromkeys((*VARIATION_STEPS, *VARIATION_AXES))))
        if names.count(name) > 1:
            raise QdotError(f"variation: {name} occurs twice")
    return tuple(name for name in VARIATION_AXES if name in names)


def find_canonical_name(variation: str | Sequence[str]) -> str:
    """Return the name of a variation: the step's name, or else its axes in order. Raises QdotError.

    >>> find_canonical_name("zeros+lengths"), find_canonical_name("base+lengths"), find_canonical_name("+zeros")
    ('zeros', 'lengths+base', '+zeros')
    >>> find_canonical_name(["zeros"]), find_canonical_name([])
    ('+zeros', 'chapter')
    """
    axes = list_variation_axes(variation)
    text = "+".join(axes)
    name = f"+{text}" if text in VARIATION_STEPS else text
    return next((step for step, step_axes in VARIATION_STEPS.items() if step_axes == axes), name)
