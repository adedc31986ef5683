"""Define a student's result, from the marks of a notebook to a line of results.jsonl (docs/schemas/result.json).

Points are those of the assignment, to four decimals. Times are ISO 8601 strings with the offset from UTC.
"""

from dataclasses import dataclass, field

from qdot.exercises.common.json_form import OMITTED_IF_NONE
from qdot.exercises.formula.equality import Certificate
from qdot.grader.judging.verdict import Outcome

EntryFlags = tuple[tuple[bool, ...], ...]
"""A flag for each entry of an answer, row by row: for example, whether the entry is correct."""


@dataclass(frozen=True)
class MarkingVersions:
    """Everything besides the submission that decides the points: the versions of qdot's parts, and the assignment.

    Results from an older version of qdot may lack some of the fields.
    """

    engine: int = 0
    grader: int = 0
    assignment: str = ""


@dataclass(frozen=True)
class AppliedOverride:
    """An override with the grader's points `was`, which `points` replace unless there is only a comment (None).

    `was` is None if qdot failed to grade the part. `group` is the key of the group of equal wrong answers to which the
    override applies; None if it is for one student.
    """

    points: float | None
    comment: str
    was: float | None
    group: str | None = field(default=None, metadata=OMITTED_IF_NONE)


@dataclass(frozen=True, kw_only=True)
class PartResult:
    """The result of a part: `points` out of `max_points`, and the findings on the answer.

    `points` is None if the part has no mark. `mistake` names the mistakes of the catalogue that give the answer. If the
    answer follows from a wrong answer to an earlier part, `followed_from` is that part, and `follows` says which
    entries follow. `attempt` is whether the answer is an attempt at this arm, if known. `group` is the key that all
    equal wrong answers share.
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
    follows: EntryFlags | None = None
    attempt: bool | None = None
    group: str | None = None
    certificate: Certificate | None = None
    answer: str | None = None
    entries: EntryFlags | None = None


@dataclass(frozen=True)
class ProblemResult:
    """The result of a student's problem: the problem's id, its slot in the assignment, and its parts."""

    id: str
    slot: str
    parts: tuple[PartResult, ...]


@dataclass(frozen=True, kw_only=True)
class NotebookMarks:
    """The grader's marks for a notebook, or for a missing one. The student's result is computed from them.

    `obstacle` says why the notebook could not be graded. `notes` are for the student, `staff_notes` for the staff.
    """

    sha256: str | None
    obstacle: str | None = None
    notes: tuple[str, ...] = ()
    staff_notes: tuple[str, ...] = ()
    made_from: MarkingVersions
    problems: tuple[ProblemResult, ...]
    seconds: float = 0.0
    """Processor time that the grading took."""
    megabytes: float = 0.0
    """Peak memory of the process that ran the notebook."""

    @property
    def is_graded(self) -> bool:
        """Whether every part has points; a part has none if qdot failed to grade it or if a limit was exceeded."""
        return all(part.points is not None for problem in self.problems for part in problem.parts)


@dataclass(frozen=True)
class CountingSubmission:
    """The notebook that counts. `received_from` is the source of the time: a platform's name, or "file"."""

    file: str
    sha256: str | None
    received: str | None
    received_from: str = "file"


@dataclass(frozen=True)
class Lateness:
    """The number of seconds by which work is late, and the share `penalty` (0 to 1) deducted from `points_before`."""

    due: str
    received: str
    seconds: int
    penalty: float
    points_before: float


@dataclass(frozen=True)
class SubmittedNotebook:
    """One of several notebooks that a student submitted; `score` is None if it was not graded."""

    file: str
    received: str | None
    score: float | None


@dataclass(frozen=True, kw_only=True)
class Result:
    """A student's result, one line of results.jsonl: the score out of `max_score`, and how it was computed.

    `submission` is None if nothing was submitted. `attempts` lists all the student's notebooks if there were several.
    """

    student: str
    assignment: str
    submission: CountingSubmission | None
    score: float
    max_score: float
    late: Lateness | None
    override: AppliedOverride | None = None
    attempts: tuple[SubmittedNotebook, ...] = ()
    obstacle: str | None = None
    notes: tuple[str, ...] = ()
    staff_notes: tuple[str, ...] = ()
    made_from: MarkingVersions = MarkingVersions()
    problems: tuple[ProblemResult, ...]

    @property
    def parts(self) -> dict[str, PartResult]:
        """All parts by their names in the assignment, for example "p1.jacobian"."""
        return {f"{problem.slot}.{part.name}": part for problem in self.problems for part in problem.parts}

    @property
    def overrides(self) -> dict[str, AppliedOverride]:
        """The overrides by name: the part's name in the assignment, or "total"."""
        overrides = {**{name: part.override for name, part in self.parts.items()}, "total": self.override}
        return {name: override for name, override in overrides.items() if override is not None}

    @property
    def file(self) -> str:
        """The file name of the notebook that counts; "" if nothing was submitted."""
        return "" if self.submission is None else self.submission.file

    @property
    def percent(self) -> float:
        """The score as a percentage of `max_score`."""
        return 100 * self.score / self.max_score
