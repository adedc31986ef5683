"""What is said of an answer: outcome, points, the reason, and the certificate behind it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from qdot.exercises.formula.identity import Certificate, EntryDifference


class Outcome(StrEnum):
    """CORRECT only when every comparison passed; UNGRADED, without a mark, when qdot failed or a limit was exceeded."""

    CORRECT = "correct"
    PARTIAL = "partial"
    WRONG = "wrong"
    MISSING = "missing"
    UNGRADED = "ungraded"


@dataclass(frozen=True)
class Judgement:
    """How good an answer is: share of the points from 0 to 1, the reason, which entries are right.

    One that is UNGRADED may be so because it took more than a limit allows; else qdot failed.
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
    """The names of the mistakes that together give a wrong answer, and what is said of them to the student.

    Without a name, what to look at is said. `cause` is the name and the words of a single one that gives the whole
    answer; `inherited` the earlier part in which it was found, where it has no name of its own here. `known_by` tells
    what the mistakes are and where they were made, whatever was found in earlier parts.
    """

    mistakes: tuple[str, ...]
    says: str
    cause: tuple[str, Mapping[str, object]] | None = None
    inherited: str | None = None
    known_by: tuple[str, ...] = ()
    either: bool = False
    """Whether it was one of the mistakes, each of which gives the answer, and not all together."""

    @property
    def is_one(self) -> bool:
        """Whether a single known mistake, made here or earlier, gives the answer: not several kinds or slips."""
        return self.inherited is not None or self.either or (len(self.mistakes) == 1 and len(self.known_by) <= 1)

    @property
    def names(self) -> str:
        """The names of the mistakes as in results.jsonl, "" for none."""
        return (" or " if self.either else " and ").join(self.mistakes)


NOT_THE_MISTAKE = ("degrees", "every", "zero")
"""Words of a sentence that don't say which mistake it is: numbers of the student's own arm, and what J is like."""


def locate_mistake(mistake: str, words: Mapping[str, object]) -> str:
    """Return a mistake with its place, the same for all arms on which it is made there.

    >>> locate_mistake("offset-sign", {"joint": 2, "degrees": "45°"})
    'offset-sign joint=2'
    """
    places = [f"{name}={value}" for name, value in sorted(words.items()) if name not in NOT_THE_MISTAKE and value != ""]
    return " ".join([mistake, *places])


@dataclass(frozen=True)
class Verdict:
    """The judgement on one part with its points (None where ungraded), the answer's text, and what is known of it.

    `group` is the key of all wrong answers that are the same as this one (`grader.groups`); `follows` the entries that
    follow from the earlier answer. `attempt` tells whether formulas are an attempt at this arm,
    as what is right is; None of options and what is not known.
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


def missing(reason: str = "nothing was handed in for this part") -> Judgement:
    """Return the judgement on an answer that is not there."""
    return Judgement(Outcome.MISSING, 0.0, reason)


def wrong(reason: str, certificate: Certificate | None = None) -> Judgement:
    """Return the judgement on an answer that is entirely wrong."""
    return Judgement(Outcome.WRONG, 0.0, reason, certificate)


def partial(share: float, reason: str, certificate: Certificate | None = None) -> Judgement:
    """Return the judgement for a share of the points; only `correct` returns CORRECT."""
    outcome = Outcome.WRONG if share <= 0 else Outcome.PARTIAL
    return Judgement(outcome, max(0.0, share), reason, certificate)


def correct(certificate: Certificate | None = None, reason: str = "right") -> Judgement:
    """Return the judgement on an answer that passed every comparison."""
    return Judgement(Outcome.CORRECT, 1.0, reason, certificate)


# --- a counterexample in words, as part of a reason; `feedback_levels` takes them out again ---


def at_words(at: Mapping[str, float]) -> str:
    """Return where an entry differs, as in " at theta1 = 0.61, theta2 = -1.32"; "" without symbols."""
    listed = ", ".join(f"{name} = {value:g}" for name, value in at.items())
    return f" at {listed}" if listed else ""


def values_words(example: EntryDifference) -> str:
    """Return both values, as in ": yours 0.41, expected 0.77"."""
    return f": yours {show_value(example.yours)}, expected {show_value(example.expected)}"


def number_words(example: EntryDifference, unit: str = "") -> str:
    """Return both values, as in " is 0.41, and 0.77 rad/s is right"."""
    right = f"{example.expected:.4g} {unit}".rstrip() if isinstance(example.expected, float) else ""
    return f" is {show_value(example.yours)}, and {right} is right"


def pose_words(at: Mapping[str, float], joints: Sequence[str]) -> str:
    """Return a configuration, as in ": theta1 = 0.61, theta2 = -1.32"; joints first."""
    names = [name for name in (*joints, *(n for n in at if n not in joints)) if name in at]
    return f": {', '.join(f'{name} = {at[name]:.4g}' for name in names) or '(any)'}"


def show_value(value: float | str | None) -> str:
    """Return a value as it stands in a reason."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def entry_name(entry: int, columns: int) -> str:
    """Return what an entry is called: "entry 2" of a vector, "entry (1, 2)" of a matrix."""
    return f"entry {entry + 1}" if columns == 1 else f"entry ({entry // columns + 1}, {entry % columns + 1})"
