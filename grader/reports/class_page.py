"""Write the class overview of `qdot report`: a page with charts for the staff, in one file that loads no others."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.common.errors import shorten
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.writing.render import render
from qdot.grader.diagnosis import similar
from qdot.grader.diagnosis.similar import SimilarPair
from qdot.grader.grading.result import PartResult, Result
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.functions import FUNCTION_TEXT
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import WRONG_OR_PARTIAL
from qdot.grader.reports import charts, class_summary
from qdot.grader.reports.answer_display import ShownAnswer, make_visible, show_answer
from qdot.grader.reports.grades_table import UNMARKED_STATUSES, find_work_status
from qdot.grader.statistics import class_statistics
from qdot.grader.statistics.fairness_tests import Comparison, compare_groups, correct_p_values

MAX_CHARTED_MISTAKES = 15
"""Maximum number of mistakes in the chart; the table has all of them."""
MAX_PAIRS = 30
"""Maximum number of pairs of nearly identical answers that are shown."""
MAX_GROUPS = 20
"""Maximum number of groups of a part that are shown with an answer; results.jsonl has the keys of all groups."""
MAX_ANSWER_LENGTH = 400
"""Maximum number of characters shown of an answer."""
MIN_RELIABLE_CLASS = 30
"""With fewer students, the page warns that difficulty and discrimination are unreliable."""
COMPARED_TYPES = ("expression", "matrix", "singular", "direction")
"""The types of answers whose written forms are compared."""
MAX_COMPARISON_CHARTS = 3
"""Maximum number of comparisons between variants that have a chart."""


@dataclass(frozen=True)
class StudentWork:
    """A student's work on a part: the student's problem, the part, its result, and the text of the answer."""

    student: str
    problem: Problem
    part: Part
    result: PartResult
    answer: str

    @property
    def shown_answer(self) -> ShownAnswer:
        """The answer as the page shows it; a long text is shortened."""
        return replace(show_answer(self.problem, self.part, self.answer), text=_shorten(self.answer))


@dataclass(frozen=True)
class GroupsOfPart:
    """The groups of equal wrong answers to a part: those that the page shows, each with an answer, and the others."""

    name: str
    groups: Sequence[tuple[class_summary.AnswerGroup, ShownAnswer]]
    omitted_groups: Sequence[class_summary.AnswerGroup]


def make_class_page(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the page as one HTML file, with all charts. Raises QdotError if matplotlib is not installed."""
    charts.check_library()
    graded_ids = [result.student for result in class_summary.select_graded(results)]
    problems = {student: dict(load_stored_problems(assignment, student).problems) for student in graded_ids}
    scores = class_summary.summarize_scores(results)
    parts = class_summary.summarize_parts(assignment, results)
    mistakes = class_summary.summarize_mistakes(results)
    comparisons = _compare_variants(assignment, results, problems)
    names = [part.name for part in parts]
    work_by_part = {name: _collect_work(name, results, problems) for name in names}
    status_counts = Counter(map(find_work_status, results))
    similar_pairs = _find_similar_answers(work_by_part)
    overrides = [(result.student, name, override) for result in results for name, override in result.overrides.items()]
    outcome_words = {outcome: style.label for outcome, style in charts.OUTCOME_STYLES.items()}
    if not any(map(status_counts.get, UNMARKED_STATUSES)):
        del outcome_words[Outcome.UNGRADED]
    mistake_counts = {mistake.title: len(mistake.students) for mistake in mistakes[:MAX_CHARTED_MISTAKES]}
    charted_comparisons = enumerate(comparisons[:MAX_COMPARISON_CHARTS])
    page_charts = {
        "score_chart": charts.draw_histogram(scores.tenth_counts, scores.mean, scores.median) if scores else "",
        "outcome_chart": charts.draw_outcomes(names, [part.outcome_counts for part in parts]) if graded_ids else "",
        "interval_chart": charts.draw_intervals(names, [part.discrimination for part in parts]),
        "mistake_chart": charts.draw_mistakes(mistake_counts),
        "variant_charts": [charts.draw_groups(i, item.shares_by_group) for i, item in charted_comparisons],
    }
    return render(
        "reports/report.html.j2", **page_charts, title=assignment.title, results=results, graded_count=len(graded_ids),
        names={student.id: class_summary.describe_student(student) for student in assignment.roster},
        status_counts=status_counts, scores=scores, parts=parts, titles={part.name: part.title for part in parts},
        outcome_words=outcome_words, mistakes=mistakes, comparisons=comparisons, statistics=class_statistics,
        is_small_class=scores is None or len(scores.percents) < MIN_RELIABLE_CLASS, overrides=overrides,
        groups=_group_answers(results, work_by_part), make_visible=make_visible,
        has_due_dates=any(assignment.due_date_of(student) is not None for student in assignment.roster),
        late_or_unmarked=class_summary.find_late_or_unmarked(results), shorten=_shorten, pairs=similar_pairs,
        max_pairs=MAX_PAIRS, parts_without_attempt=class_summary.find_students_without_attempt(results),
    )  # fmt: skip


def _collect_work(
    name: str, results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]
) -> list[StudentWork]:
    """Return the work of all students who wrote an answer to a part; `name` is for example "p1.jacobian"."""
    slot, question = name.split(".", 1)
    works = []
    for result in class_summary.select_graded(results):
        part, problem = result.parts[name], problems[result.student][slot]
        if part.answer is not None and part.answer != FUNCTION_TEXT:
            works.append(StudentWork(result.student, problem, problem[question], part, part.answer))
    return works


def _group_answers(results: Sequence[Result], work_by_part: Mapping[str, Sequence[StudentWork]]) -> list[GroupsOfPart]:
    """Return the groups of equal wrong answers to each part; `work_by_part` has the work of all students."""
    parts = []
    for name, part_groups in groupby(class_summary.group_wrong_answers(results), key=lambda group: group.part):
        groups = list(part_groups)
        work_by_student = {work.student: work for work in work_by_part[name]}
        pairs = [(group, work_by_student.get(group.typical_student)) for group in groups[:MAX_GROUPS]]
        # An answer without work is a function, which has no text.
        shown_groups = [(group, work.shown_answer if work else ShownAnswer(FUNCTION_TEXT)) for group, work in pairs]
        parts.append(GroupsOfPart(name, shown_groups, groups[MAX_GROUPS:]))
    return parts


def _compare_variants(
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


def _find_similar_answers(work_by_part: Mapping[str, Sequence[StudentWork]]) -> list[tuple[str, SimilarPair]]:
    """Return pairs of nearly identical wrong answers with their part, unless a known mistake explains the answers."""
    pairs: list[tuple[str, SimilarPair]] = []
    for name, works in work_by_part.items():
        wrong_answers: list[similar.StudentAnswer] = []
        max_common_count = max(3, len(works) // 20)  # an answer of more than 5 % of the students is a common mistake
        for work in works:
            is_explained = work.result.mistake is not None or work.result.followed_from is not None
            if is_explained or work.result.outcome not in WRONG_OR_PARTIAL or work.part.type not in COMPARED_TYPES:
                continue
            canonical_form = similar.make_canonical_form(read_answer(work.problem, work.part, work.answer))
            if canonical_form is not None:
                reference = work.part.answer.write_code()
                wrong_answers.append(similar.StudentAnswer(work.student, work.answer, canonical_form, reference))
        pairs += [(name, pair) for pair in similar.find_similar_pairs(wrong_answers, max_common_count=max_common_count)]
    return pairs


def _shorten(text: str) -> str:
    return make_visible(shorten(text, MAX_ANSWER_LENGTH))
