"""Define the verdict on an answer: outcome, points, reason, and the certificate of the comparison."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from qdot.exercises.formula.equality import Certificate, EntryDifference


class Outcome(StrEnum):
    """The outcome of judging an answer.

    CORRECT means that every comparison passed. UNGRADED means that there is no mark, because qdot failed or a limit
    was exceeded.
    """

    CORRECT = "correct"
    PARTIAL = "partial"
    WRONG = "wrong"
    MISSING = "missing"
    UNGRADED = "ungraded"


@dataclass(frozen=True)
class Judgement:
    """The judgement on an answer: its share of the points from 0 to 1, the reason, and which entries are correct.

    If the outcome is UNGRADED, either a limit was exceeded (`over_limit`) or qdot failed.
    """

    outcome: Outcome
    share: float
    reason: str
    certificate: Certificate | None = None
    entries: tuple[tuple[bool, ...], ...] | None = None
    over_limit: bool = False

    def __repr__(self) -> str:
        return f"Judgement({self.outcome.value}, {self.share:g}: {self.reason})"


@dataclass(frozen=True)
class Diagnosis:
    """The names of the mistakes that together explain a wrong answer, and the feedback for the student (`says`).

    If no mistake is named, the feedback says the student what to look at. `cause` is a single mistake (its name and
    the values in its message) that explains the whole answer. If the mistake was already found in an earlier part,
    `inherited` is that part, and the mistake is not named again. `signature` lists the mistakes and where they were
    made, including inherited ones.
    """

    mistakes: tuple[str, ...]
    says: str
    cause: tuple[str, Mapping[str, object]] | None = None
    inherited: str | None = None
    signature: tuple[str, ...] = ()
    are_alternatives: bool = False
    """Whether each of the mistakes alone explains the answer, so that only one of them was made."""

    @property
    def is_single_mistake(self) -> bool:
        """Whether a single known mistake, made here or in an earlier part, explains the answer."""
        return (
            self.inherited is not None
            or self.are_alternatives
            or (len(self.mistakes) == 1 and len(self.signature) <= 1)
        )

    @property
    def names(self) -> str:
        """The names of the mistakes as written in results.jsonl, "" for none."""
        return (" or " if self.are_alternatives else " and ").join(self.mistakes)


IGNORED_WORDS = ("degrees", "every", "zero")
"""Words of a message that don't identify the mistake: numbers of the student's own arm, and properties of J."""


def locate_mistake(mistake: str, words: Mapping[str, object]) -> str:
    """Return a mistake's name and location, such as the joint, as a text that doesn't depend on the arm's numbers.

    >>> locate_mistake("offset-sign", {"joint": 2, "degrees": "45°"})
    'offset-sign joint=2'
    """
    details = [f"{name}={value}" for name, value in sorted(words.items()) if name not in IGNORED_WORDS and value != ""]
    return " ".join([mistake, *details])


@dataclass(frozen=True)
class Verdict:
    """The judgement on one part with its points (None if ungraded), the answer's text, and its diagnosis.

    `group` is the key that all equivalent wrong answers share (`diagnosis.groups`). `follows` marks the entries that
    follow from the earlier answer. `attempt` is True if a symbolic answer is a real attempt at this arm (a correct
    answer always is). It is None for options, or if this is unknown.
    """

    part: str
    judgement: Judgement
    points: float | None
    max_points: float
    answer: str | None
    diagnosis: Diagnosis | None = None
    followed_from: str | None = None
    group: str | None = None
    follows: tuple[tuple[bool, ...], ...] | None = None
    attempt: bool | None = None

    def __repr__(self) -> str:
        earned = "no mark yet" if self.points is None else f"{self.points:g} of {self.max_points:g}"
        return f"Verdict({self.part}: {self.judgement.outcome.value}, {earned})"


def missing_judgement(reason: str = "you submitted nothing for this part") -> Judgement:
    """Return the judgement on a missing answer."""
    return Judgement(Outcome.MISSING, 0.0, reason)


def wrong_judgement(reason: str, certificate: Certificate | None = None) -> Judgement:
    """Return the judgement on an answer that is entirely wrong."""
    return Judgement(Outcome.WRONG, 0.0, reason, certificate)


def partial_judgement(share: float, reason: str, certificate: Certificate | None = None) -> Judgement:
    """Return the judgement on an answer that earns a share of the points; only `correct_judgement` returns CORRECT."""
    outcome = Outcome.WRONG if share <= 0 else Outcome.PARTIAL
    return Judgement(outcome, max(0.0, share), reason, certificate)


def correct_judgement(certificate: Certificate | None = None, reason: str = "right") -> Judgement:
    """Return the judgement on an answer that passed every comparison."""
    return Judgement(Outcome.CORRECT, 1.0, reason, certificate)


# --- phrases that describe a counterexample within a reason; `feedback_levels` can remove them ---


def describe_point(point: Mapping[str, float]) -> str:
    """Return in words the point at which an entry differs, as in " at theta1 = 0.61"; "" without symbols."""
    assignments = ", ".join(f"{name} = {value:g}" for name, value in point.items())
    return f" at {assignments}" if assignments else ""


def describe_values(example: EntryDifference) -> str:
    """Return both values, as in ": yours 0.41, expected 0.77"."""
    return f": yours {format_value(example.yours)}, expected {format_value(example.expected)}"


def describe_number(example: EntryDifference, unit: str = "") -> str:
    """Return both values, as in " is 0.41, and 0.77 rad/s is right"."""
    expected_words = f"{example.expected:.4g} {unit}".rstrip() if isinstance(example.expected, float) else ""
    return f" is {format_value(example.yours)}, and {expected_words} is right"


def describe_configuration(values: Mapping[str, float], joints: Sequence[str]) -> str:
    """Return a configuration in words, as in ": theta1 = 0.61, theta2 = -1.32"; the joints come first."""
    names = [name for name in (*joints, *(n for n in values if n not in joints)) if name in values]
    return f": {', '.join(f'{name} = {values[name]:.4g}' for name in names) or '(any)'}"


def format_value(value: float | str | None) -> str:
    """Return a value in the form used in a reason."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def name_entry(index: int, columns: int) -> str:
    """Return the name of an entry: "entry 2" of a vector, "entry (1, 2)" of a matrix."""
    return f"entry {index + 1}" if columns == 1 else f"entry ({index // columns + 1}, {index % columns + 1})"
