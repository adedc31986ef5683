"""Write the class overview of `qdot report`: a page for the staff, in one file that loads no others."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.common.errors import shorten
from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.render import render
from qdot.grader.grading.result import Result
from qdot.grader.judging.functions import FUNCTION_TEXT
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports import class_summary
from qdot.grader.reports.answer_display import ShownAnswer, make_visible, show_answer
from qdot.grader.reports.grades_table import UNMARKED_STATUSES, find_work_status
from qdot.grader.statistics import class_statistics
from qdot.grader.statistics.fairness_tests import Comparison, compare_groups, correct_p_values

MAX_GROUPS = 20
"""Maximum number of groups of a part that are shown with an answer; results.jsonl has the keys of all groups."""
MAX_ANSWER_LENGTH = 400
"""Maximum number of characters shown of an answer."""
MIN_RELIABLE_CLASS = 30
"""With fewer students, the page warns that difficulty and discrimination are unreliable."""


@dataclass(frozen=True)
class GroupsOfPart:
    """The groups of equal wrong answers to a part. The page shows `groups`, each with an answer, but no others."""

    name: str
    groups: Sequence[tuple[class_summary.AnswerGroup, ShownAnswer]]
    omitted_groups: Sequence[class_summary.AnswerGroup]


def make_class_page(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the page as one HTML file."""
    graded_ids = [result.student for result in class_summary.select_graded(results)]
    problems = {student: dict(load_stored_problems(assignment, student).problems) for student in graded_ids}
    scores = class_summary.summarize_scores(results)
    parts = class_summary.summarize_parts(assignment, results)
    mistakes = class_summary.summarize_mistakes(results)
    comparisons = _compare_groups_of_arms(assignment, results, problems)
    status_counts = Counter(map(find_work_status, results))
    overrides = [(result.student, name, override) for result in results for name, override in result.overrides.items()]
    outcome_words = dict(class_summary.OUTCOME_WORDS)
    if not any(map(status_counts.get, UNMARKED_STATUSES)):
        del outcome_words[Outcome.UNGRADED]
    return render(
        "reports/report.html.j2", title=assignment.title, results=results, graded_count=len(graded_ids),
        names={student.id: class_summary.describe_student(student) for student in assignment.roster},
        status_counts=status_counts, scores=scores, parts=parts, titles={part.name: part.title for part in parts},
        outcome_words=outcome_words, mistakes=mistakes, comparisons=comparisons, statistics=class_statistics,
        is_small_class=scores is None or len(scores.percents) < MIN_RELIABLE_CLASS, overrides=overrides,
        groups=_group_answers(results, problems), make_visible=make_visible,
        has_due_dates=any(assignment.due_date_of(student) is not None for student in assignment.roster),
        late_or_unmarked=class_summary.find_late_or_unmarked(results),
        parts_without_attempt=class_summary.find_students_without_attempt(results),
    )  # fmt: skip


def _group_answers(results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]) -> list[GroupsOfPart]:
    """Return the groups of equal wrong answers to each part."""
    answers_by_student = {result.student: result.parts for result in results}

    def show_typical_answer(group: class_summary.AnswerGroup) -> ShownAnswer:
        slot, question = group.part.split(".", 1)
        problem, student = problems[group.typical_student][slot], group.typical_student
        text = answers_by_student[student][group.part].answer or FUNCTION_TEXT
        return replace(
            show_answer(problem, problem[question], text), text=make_visible(shorten(text, MAX_ANSWER_LENGTH))
        )

    parts = []
    for name, part_groups in groupby(class_summary.group_wrong_answers(results), key=lambda group: group.part):
        groups = list(part_groups)
        shown_groups = [(group, show_typical_answer(group)) for group in groups[:MAX_GROUPS]]
        parts.append(GroupsOfPart(name, shown_groups, groups[MAX_GROUPS:]))
    return parts


def _compare_groups_of_arms(
    assignment: Assignment, results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]
) -> list[Comparison]:
    """Return, for every problem of the assignment, comparisons of the shares of points between groups of arms."""
    comparisons = []
    for slot in assignment.slots:
        chains, shares = [], []
        for result in class_summary.select_graded(results):
            parts = next(problem.parts for problem in result.problems if problem.slot == slot.name)
            points = [part.points for part in parts if part.points is not None]
            if len(points) == len(parts):
                chains.append(problems[result.student][slot.name].chain)
                shares.append(100 * sum(points) / sum(part.max_points for part in parts))
        if chains:
            comparisons += compare_groups(
                slot.name, chains, shares, assignment.key, has_varied_structure=slot.family.has_varied_structure
            )
    return correct_p_values(comparisons)
