"""What a student gets, from the marks of a notebook to a line of results.jsonl; docs/schemas/result.json has its keys.

Points are those of the assignment, to four decimals. Moments are texts of ISO 8601 with the offset from UTC.
"""

from dataclasses import dataclass, field

from qdot.exercises.common.json_form import OPTIONAL
from qdot.exercises.formula.identity import Certificate
from qdot.grader.judging.verdict import Outcome

Entries = tuple[tuple[bool, ...], ...]
"""The rows of an answer's entries."""


@dataclass(frozen=True)
class MadeFrom:
    """What else than the submission decides the points: versions of the engine and the grader, and the assignment.

    An older version of qdot may not have written all of it.
    """

    engine: int = 0
    grader: int = 0
    assignment: str = ""


@dataclass(frozen=True)
class AppliedOverride:
    """What a person set or said: points (None: the grader's stay), and what the grader gave (None where it failed).

    `group` is the key of the group of equal wrong answers that it is for, None where it is for one student.
    """

    points: float | None
    comment: str
    was: float | None
    group: str | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True, kw_only=True)
class PartResult:
    """What came of a part: points out of `max_points`, None where it has no mark, and what is known of the answer.

    `mistake` names those of the catalogue that give the answer. `followed_from` is the earlier part from whose wrong
    answer this one follows, `follows` says of each entry whether it does. `attempt` tells whether the answer is an
    attempt at this arm, where that is known; `group` is the key of all equal wrong answers.
    """

    name: str
    outcome: Outcome
    over_limit: bool = False
    points: float | None
    max_points: float
    override: AppliedOverride | None = None
    reason: str
    mistake: str | None = None
    advice: str | None = None
    followed_from: str | None = None
    follows: Entries | None = None
    attempt: bool | None = None
    group: str | None = None
    certificate: Certificate | None = None
    answer: str | None = None
    entries: Entries | None = None


@dataclass(frozen=True)
class ProblemResult:
    """A problem of a student: its id, its place in the assignment, and its parts."""

    id: str
    slot: str
    parts: tuple[PartResult, ...]


@dataclass(frozen=True, kw_only=True)
class Marked:
    """What the grader gives for a notebook, or for none; `final_result` makes a student's result of it.

    `obstacle` says why nothing of it could be used. `notes` are for the student, `staff_notes` for the staff.
    """

    sha256: str | None
    obstacle: str | None = None
    notes: tuple[str, ...] = ()
    staff_notes: tuple[str, ...] = ()
    made_from: MadeFrom
    problems: tuple[ProblemResult, ...]
    seconds: float = 0.0
    """Processor time that grading it took."""
    megabytes: float = 0.0
    """Largest memory of the process that ran it."""

    @property
    def is_graded(self) -> bool:
        """Whether every part has its points: qdot failed on one that has none, or a limit was exceeded."""
        return all(part.points is not None for problem in self.problems for part in problem.parts)


@dataclass(frozen=True)
class CountingSubmission:
    """The notebook that counts. `received_from` is what tells the time: a platform, or "file"."""

    file: str
    sha256: str | None
    received: str | None
    received_from: str = "file"


@dataclass(frozen=True)
class Lateness:
    """By how many seconds work is late, and which share of the points before (0 to 1) that costs."""

    due: str
    received: str
    seconds: int
    penalty: float
    points_before: float


@dataclass(frozen=True)
class ReadNotebook:
    """One of several notebooks that were read; its score is None if it was not graded."""

    file: str
    received: str | None
    score: float | None


@dataclass(frozen=True, kw_only=True)
class Result:
    """A student's result, a line of results.jsonl: the score out of `max_score`, and what it is made up of.

    `submission` is None if nothing was submitted. `attempts` are all notebooks that were read if there were several.
    """

    student: str
    assignment: str
    submission: CountingSubmission | None
    score: float
    max_score: float
    late: Lateness | None
    override: AppliedOverride | None = None
    attempts: tuple[ReadNotebook, ...] = ()
    obstacle: str | None = None
    notes: tuple[str, ...] = ()
    staff_notes: tuple[str, ...] = ()
    made_from: MadeFrom = MadeFrom()
    problems: tuple[ProblemResult, ...]

    @property
    def parts(self) -> dict[str, PartResult]:
        """All parts by their names in the assignment, as in "p1.jacobian"."""
        return {f"{problem.slot}.{part.name}": part for problem in self.problems for part in problem.parts}

    @property
    def overrides(self) -> dict[str, AppliedOverride]:
        """What a person set or said, by the names of the parts, and of the "total"."""
        every = {**{name: part.override for name, part in self.parts.items()}, "total": self.override}
        return {name: override for name, override in every.items() if override is not None}

    @property
    def percent(self) -> float:
        """The score in per cent of all points."""
        return 100 * self.score / self.max_score
