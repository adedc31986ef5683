"""A counterexample in words, as part of a reason; `feedback_levels` takes them out again."""

from collections.abc import Mapping, Sequence

from qdot.exercises.formula.identity import EntryDifference


def at_words(at: Mapping[str, float]) -> str:
    """Return where an entry differs, as in " at theta1 = 0.61, theta2 = -1.32"; nothing where there is no symbol."""
    listed = ", ".join(f"{name} = {value:g}" for name, value in at.items())
    return f" at {listed}" if listed else ""


def values_words(example: EntryDifference) -> str:
    """Return both values, as in ": yours 0.41, expected 0.77"."""
    return f": yours {shown(example.yours)}, expected {shown(example.expected)}"


def number_words(example: EntryDifference, unit: str = "") -> str:
    """Return both values, as in " is 0.41, and 0.77 rad/s is right"."""
    right = f"{example.expected:.4g} {unit}".rstrip() if isinstance(example.expected, float) else ""
    return f" is {shown(example.yours)}, and {right} is right"


def pose_words(at: Mapping[str, float], joints: Sequence[str]) -> str:
    """Return a configuration, as in ": theta1 = 0.61, theta2 = -1.32"; joints first."""
    names = [name for name in (*joints, *(n for n in at if n not in joints)) if name in at]
    return f": {', '.join(f'{name} = {at[name]:.4g}' for name in names) or '(any)'}"


def shown(value: float | str | None) -> str:
    """Return a value as it stands in a reason."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def entry_name(entry: int, columns: int) -> str:
    """Return what an entry is called: "entry 2" of a vector, "entry (1, 2)" of a matrix."""
    return f"entry {entry + 1}" if columns == 1 else f"entry ({entry // columns + 1}, {entry % columns + 1})"
