"""Define the verdict on an answer: outcome, points, reason, and the certificate of the comparison."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from qdot.exercises.formula.equality import Certificate


class Outcome(StrEnum):
    """The outcome of judging an answer.

    CORRECT means that every comparison passed. UNGRADED means that there is no mark: qdot failed, a limit was exceeded,
    or a person marks the answer.
    """

    CORRECT = "correct"
    PARTIAL = "partial"
    WRONG = "wrong"
    MISSING = "missing"
    UNGRADED = "ungraded"


@dataclass(frozen=True)
class Judgement:
    """The judgement on an answer: its share of the points from 0 to 1, the reason, and which entries are correct.

    If the outcome is UNGRADED, a limit was exceeded (`over_limit`), qdot failed, or a person must mark the answer.
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
    """The names of the mistakes that together explain a wrong answer, and the `feedback` for the student.

    If no mistake is named, the feedback says what the student should look at. If a single mistake explains the whole
    answer, `cause` contains its name and the values in its message. If several mistakes are equally likely, `cause` has
    the first. If the mistake was already found in an earlier part, `inherited` is that part, and the mistake is not
    named again. `signature` lists the mistakes and their locations, including an inherited mistake.
    """

    mistakes: tuple[str, ...]
    feedback: str
    cause: tuple[str, Mapping[str, object]] | None = None
    inherited: str | None = None
    signature: tuple[str, ...] = ()
    are_alternatives: bool = False
    """Whether each of the mistakes alone explains the answer, so only one of them was made."""

    @property
    def is_single_mistake(self) -> bool:
        """Whether a single known mistake, made here or in an earlier part, explains the answer."""
        is_only_mistake = len(self.mistakes) == 1 and len(self.signature) <= 1
        return self.inherited is not None or self.are_alternatives or is_only_mistake

    @property
    def names(self) -> str:
        """The names of the mistakes as written in results.jsonl; "" if there are none."""
        return (" or " if self.are_alternatives else " and ").join(self.mistakes)


IGNORED_WORDS = ("degrees", "every", "zero")
"""The names of those values in a message that depend on the arm and don't identify the mistake: angles and advice."""


def locate_mistake(mistake: str, words: Mapping[str, object]) -> str:
    """Return a mistake's name and location, such as the joint, as a text that doesn't depend on the arm's numbers.

    `words` are the values in the message about the mistake.

    >>> locate_mistake("offset-sign", {"joint": 2, "degrees": "45°"})
    'offset-sign joint=2'
    """
    details = [f"{name}={value}" for name, value in sorted(words.items()) if name not in IGNORED_WORDS and value != ""]
    return " ".join([mistake, *details])


@dataclass(frozen=True)
class Verdict:
    """The judgement on one part with the points (None if ungraded), the text of the answer, and the diagnosis.

    `group` is the key that all equivalent wrong answers share (`diagnosis.groups`). If the answer follows from a wrong
    answer to an earlier part, `followed_from` is that part, and `follows` says which entries follow. `attempt` is
    whether a formula is a real attempt at this arm (docs/judging.md); None for options, or if unknown.
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
        points_text = "no mark yet" if self.points is None else f"{self.points:g} of {self.max_points:g}"
        return f"Verdict({self.part}: {self.judgement.outcome.value}, {points_text})"


AWAITS_PERSON = "a person marks this answer"
"""The reason why an answer in words has no points yet."""
MARKED_BY_PERSON = "a person marked this answer"
"""The reason for the points that an answer in words earns."""


def make_missing_judgement(reason: str = "you submitted nothing for this part") -> Judgement:
    """Return the judgement on a missing answer."""
    return Judgement(Outcome.MISSING, 0.0, reason)


def make_wrong_judgement(reason: str, certificate: Certificate | None = None) -> Judgement:
    """Return the judgement on an answer that is entirely wrong."""
    return Judgement(Outcome.WRONG, 0.0, reason, certificate)


def make_partial_judgement(share: float, reason: str, certificate: Certificate | None = None) -> Judgement:
    """Return the judgement on an answer that earns a share of the points: PARTIAL, or WRONG for a share of 0."""
    outcome = Outcome.WRONG if share <= 0 else Outcome.PARTIAL
    return Judgement(outcome, max(0.0, share), reason, certificate)


def make_correct_judgement(certificate: Certificate | None = None, reason: str = "right") -> Judgement:
    """Return the judgement on an answer that passed every comparison."""
    return Judgement(Outcome.CORRECT, 1.0, reason, certificate)


def name_entry(index: int, columns: int) -> str:
    """Return the name of an entry: "entry 2" of a vector, "entry (1, 2)" of a matrix."""
    return f"entry {index + 1}" if columns == 1 else f"entry ({index // columns + 1}, {index % columns + 1})"
