"""Define a student's result, from the marks of a notebook to a line of results.jsonl (docs/schemas/result.json).

Points are on the scale of the assignment and have at most four decimals. Times are strings in ISO 8601 with the offset
from UTC. A slot is the place of a problem in the assignment, such as "p1"; each student has a different problem there.
"""

from dataclasses import dataclass, field

from qdot.exercises.common.json_form import OMITTED_IF_NONE
from qdot.exercises.formula.equality import Certificate
from qdot.grader.judging.verdict import Outcome

EntryFlags = tuple[tuple[bool, ...], ...]
"""A flag for each entry of an answer, row by row: for example, whether the entry is correct."""


@dataclass(frozen=True)
class MarkingVersions:
    """Everything besides the submission that decides the points.

    `engine` is the version of the generator of problems, and `grader` the version of the grader. `assignment` is a
    digest of the assignment's settings. Results from an older version of qdot may lack some of the fields.
    """

    engine: int = 0
    grader: int = 0
    assignment: str = ""


@dataclass(frozen=True)
class Override:
    """The points that a person sets for a part or for a student's total, and a comment for the student.

    If there is only a comment, `points` is None, and the grader's points remain. `previous_points` is the number of
    points that the grader gave. It is None if qdot failed to grade the part, or if the override has not been applied
    yet. `group` is the key of the group of equal wrong answers to which the override applies; None if it is for one
    student.
    """

    points: float | None
    comment: str
    previous_points: float | None = field(metadata={"alias": "was"})
    group: str | None = field(default=None, metadata=OMITTED_IF_NONE)


@dataclass(frozen=True, kw_only=True)
class PartResult:
    """The result of a part: `points` out of `max_points`, and the findings on the answer.

    `points` is None if the part has no mark. `mistake` names the mistakes of the catalogue that lead to the answer. If
    the answer follows from a wrong answer to an earlier part, `followed_from` is that part, and `follows` says which
    entries follow. `attempt` is whether the answer is a real attempt at this arm (see `marking.mark`); None if this is
    unknown. `group` is the key that all equal wrong answers share. `entries` says which entries are correct.
    """

    name: str
    outcome: Outcome
    over_limit: bool = False
    points: float | None
    max_points: float
    override: Override | None = None
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
    """The grader's marks for a notebook, or for a missing one. The student's result is computed from these marks.

    `obstacle` is the reason why the notebook could not be graded, or None. `notes` are sentences for the student, and
    `staff_notes` for the staff. `made_from` has the versions from which the marks were computed.
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
    """By how many seconds a submission is late, and the share `penalty` (0 to 1) that is deducted from its points.

    `due` and `received` are times, and `points_before` is the number of points before the deduction.
    """

    due: str
    received: str
    seconds: int
    penalty: float
    points_before: float


@dataclass(frozen=True)
class SubmittedNotebook:
    """One of several notebooks that a student submitted; `score` is None if the notebook was not graded."""

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
    override: Override | None = None
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
    def overrides(self) -> dict[str, Override]:
        """Maps the name of each overridden part, or "total", to the override."""
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
