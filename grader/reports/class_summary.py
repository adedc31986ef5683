"""Compute the numbers of the class overview from the results: scores, parts, mistakes, equal answers, lateness."""

import re
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.late_rule import describe_duration
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.grader.grading.result import Override, PartResult, Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import map_max_points
from qdot.grader.reports.answer_display import make_visible
from qdot.grader.reports.grades_table import REASONS_WITHOUT_MARK, UNMARKED_STATUSES, find_work_status, is_marked
from qdot.grader.statistics.class_statistics import Interval, compute_discrimination, compute_reliability

OUTCOME_WORDS = {
    Outcome.CORRECT: "right", Outcome.PARTIAL: "partly right", Outcome.WRONG: "wrong", Outcome.MISSING: "blank",
    Outcome.UNGRADED: "ungraded",
}  # fmt: skip
"""The outcomes in words, in the order in which tables list them."""


@dataclass(frozen=True)
class PartSummary:
    """The statistics of a part of the assignment.

    `outcome_counts` is the number of students with each outcome. `mean_share` measures the difficulty: the mean of the
    earned points divided by the maximum points, over the students who have points for the part. `follow_through_count`
    is the number of answers that follow from a wrong earlier answer.
    """

    name: str
    title: str
    max_points: float
    outcome_counts: Mapping[Outcome, int]
    mean_share: float | None
    discrimination: Interval | None
    follow_through_count: int

    @property
    def graded_count(self) -> int:
        """The number of students who submitted work that could be graded."""
        return sum(self.outcome_counts.values())


@dataclass(frozen=True)
class MistakeSummary:
    """A mistake of the catalogue: the students who made it, and the parts in which it was made."""

    name: str
    title: str
    students: tuple[str, ...]
    parts: tuple[str, ...]


@dataclass(frozen=True)
class AnswerGroup:
    """A group of equal wrong answers to a part.

    `key` is the group's key in overrides.csv. `typical_student` is a student who wrote the answer in its most common
    form. `mistake` is the title of the known mistake that leads to the answer, empty if there is none. `points_range`
    is the minimum and the maximum of the points that qdot gave. `override` is the group's line in overrides.csv.
    """

    key: str
    part: str
    students: tuple[str, ...]
    typical_student: str
    mistake: str
    points_range: tuple[float, float]
    max_points: float
    follow_through_count: int
    override: Override | None

    @property
    def count(self) -> int:
        """The number of students who gave the answer."""
        return len(self.students)


@dataclass(frozen=True)
class Scores:
    """The scores of the students who have a mark, in percent, and the statistics of these scores.

    `tenth_counts` has the number of scores in each tenth of the range 0 to 100 %; 100 % is in the last tenth.
    `reliability` is Cronbach's alpha. `full_score_count` is the number of scores of 100 %.
    """

    percents: tuple[float, ...]
    tenth_counts: tuple[int, ...]
    mean: float
    median: float
    standard_deviation: float | None
    reliability: float | None
    full_score_count: int


def describe_student(student: Student) -> str:
    """Return a student's name and identifier, or only the identifier if there is no name.

    >>> describe_student(Student("s1", "Ada Lovelace")), describe_student(Student("s2"))
    ('Ada Lovelace (s1)', 's2')
    """
    return make_visible(f"{student.name} ({student.id})" if student.name else student.id)


def select_graded(results: Sequence[Result]) -> list[Result]:
    """Return the results of students whose notebook could be graded."""
    return [result for result in results if result.submission is not None and result.obstacle is None]


def summarize_scores(results: Sequence[Result]) -> Scores | None:
    """Return the scores of students who have a mark; None if nobody has one.

    Cronbach's alpha is computed from the students who have points for every part.
    """
    percents = tuple(result.percent for result in results if is_marked(result))
    if not percents:
        return None
    counts = Counter(min(9, int(percent // 10)) for percent in percents)
    tenth_counts = tuple(counts[tenth] for tenth in range(10))
    mean, median = statistics.fmean(percents), statistics.median(percents)
    standard_deviation = statistics.stdev(percents) if len(percents) > 1 else None
    full_score_count = sum(percent >= 100 - 1e-9 for percent in percents)
    alpha = compute_reliability(_list_point_rows(results))
    return Scores(percents, tenth_counts, mean, median, standard_deviation, alpha, full_score_count)


def _list_point_rows(results: Sequence[Result]) -> list[list[float]]:
    """Return a row with the points of every part for each student who has points for all parts."""
    rows = [[part.points for part in result.parts.values()] for result in select_graded(results)]
    return [[points for points in row if points is not None] for row in rows if None not in row]


def summarize_parts(assignment: Assignment, results: Sequence[Result]) -> list[PartSummary]:
    """Return a summary of every part of the assignment, in its order."""
    student_parts = [result.parts for result in select_graded(results)]
    point_rows = _list_point_rows(results)
    summaries, titles = [], assignment.titles_by_part
    for index, (name, max_points) in enumerate(map_max_points(assignment).items()):
        answers = [parts[name] for parts in student_parts]
        shares = [part.points / max_points for part in answers if part.points is not None]
        counter = Counter(part.outcome for part in answers)
        summaries.append(PartSummary(
            name, titles[name], max_points, {outcome: counter[outcome] for outcome in Outcome},
            mean_share=statistics.fmean(shares) if shares else None,
            discrimination=compute_discrimination(point_rows, index) if point_rows else None,
            follow_through_count=sum(part.followed_from is not None for part in answers),
        ))  # fmt: skip
    return summaries


def summarize_mistakes(results: Sequence[Result]) -> list[MistakeSummary]:
    """Return the diagnosed mistakes, the most frequent first; two mistakes in one answer both count."""
    answers_by_mistake: dict[str, list[tuple[str, str]]] = {}
    for result in select_graded(results):
        for name, part in result.parts.items():
            # The names of alternative mistakes are joined by "or", those of several mistakes together by "and".
            for mistake in filter(None, re.split(" or | and ", part.mistake or "")):
                answers_by_mistake.setdefault(mistake, []).append((result.student, name))
    summaries = []
    for mistake, answers in answers_by_mistake.items():
        students, parts = (tuple(dict.fromkeys(names)) for names in zip(*answers, strict=True))
        summaries.append(MistakeSummary(mistake, _find_mistake_title(mistake), students, parts))
    return sorted(summaries, key=lambda summary: (-len(summary.students), summary.title))


def _find_mistake_title(name: str) -> str:
    return CATALOGUE[name].title if name in CATALOGUE else name


def group_wrong_answers(results: Sequence[Result]) -> list[AnswerGroup]:
    """Return the groups of equal wrong answers, part by part; the largest groups come first."""
    answers: dict[tuple[int, str], list[tuple[str, str, PartResult]]] = {}
    for result in select_graded(results):
        for index, (name, part) in enumerate(result.parts.items()):
            if part.group is not None:
                answers.setdefault((index, part.group), []).append((result.student, name, part))
    ordered_groups = sorted((index, -len(group_answers), key) for (index, key), group_answers in answers.items())
    return [_summarize_group(key, answers[index, key]) for index, _, key in ordered_groups]


def _summarize_group(key: str, answers: Sequence[tuple[str, str, PartResult]]) -> AnswerGroup:
    """Return a group from its key and its answers, which are triples (student, name of the part, its result)."""
    students, names, parts = zip(*answers, strict=True)
    wordings = ["".join((part.answer or "").split()) for part in parts]
    ((most_common_wording, _),) = Counter(wordings).most_common(1)
    typical_student = students[wordings.index(most_common_wording)]
    mistakes = next((part.mistake for part in parts if part.mistake), "")
    alternatives = [map(_find_mistake_title, alternative.split(" and ")) for alternative in mistakes.split(" or ")]
    overrides = [part.override for part in parts if part.override is not None]
    grader_points = [part.points if part.override is None else part.override.previous_points for part in parts]
    earned_points = [points for points in grader_points if points is not None] or [0.0]
    return AnswerGroup(
        key, names[0], students, typical_student, mistake=" or ".join(map("; ".join, alternatives)),
        points_range=(min(earned_points), max(earned_points)), max_points=parts[0].max_points,
        follow_through_count=sum(part.followed_from is not None for part in parts),
        override=next((override for override in overrides if override.group == key), None),
    )  # fmt: skip


@dataclass(frozen=True)
class LateOrUnmarked:
    """A student who has no mark or was late: the status of the work, as in `find_work_status`, and the reason.

    `has_mark` is whether the student has a mark nevertheless.
    """

    result: Result
    status: str
    reason: str
    has_mark: bool


def find_late_or_unmarked(results: Sequence[Result]) -> list[LateOrUnmarked]:
    """Return the students who have no mark or were late, with the reasons."""
    rows = []
    for result in results:
        status = find_work_status(result)
        late = result.late
        if status == "graded":
            continue
        reason = ""
        if late is not None:
            reason = f"{describe_duration(late.seconds)} late"
            reason += f", {100 * late.penalty:.4g} % deducted" if late.penalty else ", nothing deducted"
        elif status in ("unusable", *UNMARKED_STATUSES):
            reason = result.obstacle or REASONS_WITHOUT_MARK.get(status, "")
        rows.append(LateOrUnmarked(result, status, make_visible(reason), is_marked(result)))
    order = [*UNMARKED_STATUSES, "unusable", "missing", "late"]
    return sorted(rows, key=lambda row: order.index(row.status))


def find_students_without_attempt(results: Sequence[Result]) -> dict[str, list[str]]:
    """Return the students who gave several wrong formulas, none of which is an attempt at their own arm.

    Each student is mapped to the names of these parts. Apart from choice questions, nothing in the work of these
    students is correct.
    """
    part_names_by_student = {}
    for result in select_graded(results):
        names = [name for name, part in result.parts.items() if part.attempt is False]
        if len(names) >= MIN_PARTS_WITHOUT_ATTEMPT and not any(part.attempt for part in result.parts.values()):
            part_names_by_student[result.student] = names
    return part_names_by_student


MIN_PARTS_WITHOUT_ATTEMPT = 2
"""Minimum number of wrong formulas that are not an attempt at the student's own arm, for a student to be listed."""
