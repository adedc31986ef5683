"""Compute the figures of the class overview from the results: scores, parts, mistakes, equal answers, lateness."""

import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.lateness import describe_duration
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.quizzes import ASKED
from qdot.grader.grading.marking import list_max_points
from qdot.grader.grading.result import AppliedOverride, PartResult, Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports.answers import make_visible
from qdot.grader.reports.tables import NO_MARK, is_marked, status
from qdot.grader.statistics.statistics import Interval, discrimination, reliability


@dataclass(frozen=True)
class PartOfClass:
    """A part of the assignment: its outcomes, its mean share (difficulty), and its discrimination.

    `shares` are of those whose work was graded and who have points for it. `followed` counts what earned points because
    it follows from a wrong earlier answer.
    """

    name: str
    title: str
    max_points: float
    count: Mapping[Outcome, int]
    share: float | None
    discrimination: Interval | None
    followed: int

    @property
    def graded(self) -> int:
        """How many handed in work that could be graded."""
        return sum(self.count.values())


@dataclass(frozen=True)
class MistakeOfClass:
    """A mistake of the catalogue: who made it, and in which parts."""

    name: str
    title: str
    students: tuple[str, ...]
    parts: tuple[str, ...]


@dataclass(frozen=True)
class GroupOfClass:
    """A group of equal wrong answers; the `typical` student wrote it as most did.

    `mistake` is the title of the mistake of the catalogue that gives the answer, empty where none is known. `earned`
    are the least and the most points that the grader gave for it; `override` is what overrides.csv says of it.
    """

    key: str
    part: str
    students: tuple[str, ...]
    typical: str
    mistake: str
    earned: tuple[float, float]
    max_points: float
    followed: int
    override: AppliedOverride | None

    @property
    def count(self) -> int:
        """How many students gave the answer."""
        return len(self.students)

    @property
    def is_of_one(self) -> bool:
        """Whether a single student gave the answer."""
        return self.count == 1


@dataclass(frozen=True)
class Scores:
    """The scores of those who have a mark, in per cent, and what they come to.

    `tenths` are how many scores there are in each tenth of 100 %, `full` how many have all points.
    """

    percents: tuple[float, ...]
    tenths: tuple[int, ...]
    mean: float
    median: float
    deviation: float | None
    reliability: float | None
    full: int


def describe_student(student: Student) -> str:
    """Return a student as the staff knows them.

    >>> describe_student(Student("s1", "Ada Lovelace")), describe_student(Student("s2"))
    ('Ada Lovelace (s1)', 's2')
    """
    return make_visible(f"{student.name} ({student.id})" if student.name else student.id)


def select_graded(results: Sequence[Result]) -> list[Result]:
    """Return the results of students whose notebook could be graded."""
    return [result for result in results if result.submission is not None and result.obstacle is None]


def summarize_scores(results: Sequence[Result]) -> Scores | None:
    """Return the scores of those who have a mark; None if nobody has. Cronbach's alpha is of those with all points."""
    percents = tuple(result.percent for result in results if is_marked(result))
    if not percents:
        return None
    counts = Counter(min(9, int(percent // 10)) for percent in percents)
    return Scores(
        percents,
        tuple(counts[tenth] for tenth in range(10)),
        statistics.fmean(percents),
        statistics.median(percents),
        statistics.stdev(percents) if len(percents) > 1 else None,
        reliability(_rows(results)),
        sum(percent >= 100 - 1e-9 for percent in percents),
    )


def _rows(results: Sequence[Result]) -> list[list[float]]:
    """Return the points of every part, for students who have points for all parts."""
    rows = [[part.points for part in result.parts.values()] for result in select_graded(results)]
    return [[points for points in row if points is not None] for row in rows if None not in row]


def summarize_parts(assignment: Assignment, results: Sequence[Result]) -> list[PartOfClass]:
    """Return every part of the assignment, in its order."""
    work = [result.parts for result in select_graded(results)]
    rows = _rows(results)
    of_class = []
    for index, (name, most) in enumerate(list_max_points(assignment).items()):
        answers = [parts[name] for parts in work]
        shares = [part.points / most for part in answers if part.points is not None]
        count = Counter(part.outcome for part in answers)
        of_class.append(
            PartOfClass(
                name,
                ASKED[name.split(".", 1)[1]].title,
                most,
                {outcome: count[outcome] for outcome in Outcome},
                statistics.fmean(shares) if shares else None,
                discrimination(rows, index) if rows else None,
                sum(part.followed_from is not None for part in answers),
            )
        )
    return of_class


def summarize_mistakes(results: Sequence[Result]) -> list[MistakeOfClass]:
    """Return the mistakes that were diagnosed, the most frequent first; of two mistakes in one answer, each counts."""
    who: dict[str, dict[str, None]] = {}
    where: dict[str, dict[str, None]] = {}
    for result in select_graded(results):
        for name, part in result.parts.items():
            for mistake in part.mistake.replace(" or ", " and ").split(" and ") if part.mistake else ():
                who.setdefault(mistake, {})[result.student] = None
                where.setdefault(mistake, {})[name] = None
    titles = {name: CATALOGUE[name].title if name in CATALOGUE else name for name in who}
    made = [MistakeOfClass(name, titles[name], tuple(students), tuple(where[name])) for name, students in who.items()]
    return sorted(made, key=lambda mistake: (-len(mistake.students), mistake.title))


def group_wrong_answers(results: Sequence[Result]) -> list[GroupOfClass]:
    """Return the groups of equal wrong answers: those of a part together, of most students first."""
    answers: dict[tuple[int, str], list[tuple[str, str, PartResult]]] = {}
    for result in select_graded(results):
        for index, (name, part) in enumerate(result.parts.items()):
            if part.group is not None:
                answers.setdefault((index, part.group), []).append((result.student, name, part))
    of_class = [(index, _group(key, of_group)) for (index, key), of_group in answers.items()]
    return [group for _, group in sorted(of_class, key=lambda each: (each[0], -len(each[1].students), each[1].key))]


def _group(key: str, answers: Sequence[tuple[str, str, PartResult]]) -> GroupOfClass:
    parts = [part for _, _, part in answers]
    often = Counter(_without_blanks(part) for part in parts)
    most = max(often.values())
    mistake = next((part.mistake for part in parts if part.mistake), "")
    overrides = [part.override for part in parts if part.override is not None]
    before = [part.points if part.override is None else part.override.was for part in parts]
    earned = [points for points in before if points is not None] or [0.0]
    return GroupOfClass(
        key,
        answers[0][1],
        tuple(student for student, _, _ in answers),
        next(student for student, _, part in answers if often[_without_blanks(part)] == most),
        " and ".join(CATALOGUE[name].title if name in CATALOGUE else name for name in mistake.split(" and ") if name),
        (min(earned), max(earned)),
        parts[0].max_points,
        sum(part.followed_from is not None for part in parts),
        next((override for override in overrides if override.group == key), None),
    )


def _without_blanks(part: PartResult) -> str:
    return "".join((part.answer or "").split())


@dataclass(frozen=True)
class NotOnTime:
    """A student who has no mark or was late: the state of the work, and the reason."""

    result: Result
    status: str
    reason: str

    @property
    def has_mark(self) -> bool:
        """Whether there is a mark all the same."""
        return is_marked(self.result)


def find_late_or_missing(results: Sequence[Result]) -> list[NotOnTime]:
    """Return who has no mark or was late, and what is known of it."""
    rows = []
    for result in results:
        state, late = status(result), result.late
        if state == "graded":
            continue
        reason = ""
        if late is not None:
            reason = f"{describe_duration(late.seconds)} late"
            reason += f", {100 * late.penalty:.4g} % taken off" if late.penalty else ", nothing taken off"
        elif state in ("unusable", *NO_MARK):
            reason = result.obstacle or (
                "qdot failed on a part" if state == "ungraded" else "judging a part took too long"
            )
        rows.append(NotOnTime(result, state, make_visible(reason)))
    order = [*NO_MARK, "unusable", "missing", "late"]
    return sorted(rows, key=lambda row: order.index(row.status))


def find_without_attempt(results: Sequence[Result]) -> dict[str, list[str]]:
    """Return whose wrong formulas, two or more, are all no attempt at their own arm, and the names of the parts.

    Nothing but options is right in the work of these students.
    """
    parts_of_students = {}
    for result in select_graded(results):
        no_attempts = [name for name, part in result.parts.items() if part.attempt is False]
        if len(no_attempts) >= FEWEST_WITHOUT and not any(part.attempt for part in result.parts.values()):
            parts_of_students[result.student] = no_attempts
    return parts_of_students


FEWEST_WITHOUT = 2
