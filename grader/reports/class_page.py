"""Write the class overview of `qdot report`: a page with charts for the staff, in one file that loads no others."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.writing.render import render
from qdot.grader.diagnosis.similar import Pair, Written, Wrong, alikeness, nearly_the_same, written
from qdot.grader.grading.marking import NOT_RIGHT
from qdot.grader.grading.result import PartResult, Result
from qdot.grader.judging.answer_parser import read_answer
from qdot.grader.judging.functions import SHOWN
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports import charts
from qdot.grader.reports.answers import Answer, make_visible, show_answer
from qdot.grader.reports.class_view import (
    GroupOfClass,
    describe_student,
    find_late_or_missing,
    find_without_attempt,
    group_wrong_answers,
    select_graded,
    summarize_mistakes,
    summarize_parts,
    summarize_scores,
)
from qdot.grader.reports.tables import NO_MARK, status
from qdot.grader.statistics import statistics
from qdot.grader.statistics.fairness_tests import Comparison, compare, correct_for_number

MOST_CHARTED = 15
"""Maximum number of mistakes in the chart; the table has all of them."""
MOST_UNUSUAL = 2
"""Maximum number of unusual forms shown for a part."""
UNUSUAL = 0.5
"""A correct answer has an unusual form if it shares at most this fraction of its pieces with the reference."""
MOST_PAIRS = 30
"""Maximum number of pairs of nearly identical answers that are shown."""
MOST_GROUPS = 20
"""Maximum number of groups of a part that are shown with an answer; results.jsonl has the keys of all groups."""
SHORT = 400
"""Maximum number of characters shown of an answer."""
FEW = 30
"""With fewer students, the page warns that difficulty and discrimination are unreliable."""
COMPARED = ("expression", "matrix", "singular", "direction")
"""The types of answers whose written forms are compared."""
CHARTED_VARIANTS = 3
"""Maximum number of comparisons between variants that have a chart."""


@dataclass(frozen=True)
class Work:
    """A student's work on a part: the problem, the part, its result, and the text of the answer."""

    student: str
    problem: Problem
    part: Part
    result: PartResult
    answer: str

    @property
    def on_page(self) -> Answer:
        """The answer as the page shows it: its text is shortened if it is long."""
        return replace(show_answer(self.problem, self.part, self.answer), text=_cut(self.answer))

    def parse(self, text: str) -> Written | None:
        """Return a text, parsed as an answer to this part, in the form used to compare answers; None if it has none."""
        return written(read_answer(self.problem, self.part, text))


@dataclass(frozen=True)
class GroupsOfPart:
    """The groups of equal wrong answers to a part: those that the page shows with an answer, and the others."""

    name: str
    groups: Sequence[tuple[GroupOfClass, Answer]]
    left_out: Sequence[GroupOfClass]


@dataclass(frozen=True)
class UnusualForm:
    """A correct answer to a part in an unusual form, a student who wrote it, and the number of such students."""

    part: str
    answer: Answer
    student: str
    count: int


def make_class_page(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the page as self-contained HTML. Raises QdotError if matplotlib is not installed."""
    charts.check_library()
    graded = [result.student for result in select_graded(results)]
    problems = {student: dict(load_stored_problems(assignment, student).problems) for student in graded}
    scores, mistakes, class_parts = (
        summarize_scores(results),
        summarize_mistakes(results),
        summarize_parts(assignment, results),
    )
    comparisons = _compare_variants(assignment, results, problems)
    work = {part.name: _work_on(part.name, results, problems) for part in class_parts}
    part_names = [part.name for part in class_parts]
    states = Counter(status(result) for result in results)
    similar = _similar_answers(work)
    charted = mistakes[:MOST_CHARTED]
    return render(
        "reports/report.html.j2",
        title=assignment.title,
        names={student.id: describe_student(student) for student in assignment.roster},
        titles={part.name: part.title for part in class_parts},
        students=len(results),
        handed_in=sum(result.submission is not None for result in results),
        states={name: states[name] for name in ("graded", "late", "missing", "unusable", *NO_MARK)},
        scores=scores,
        score_chart=charts.draw_histogram(scores.percents, scores.mean, scores.median) if scores else "",
        parts=class_parts,
        outcome_words={
            outcome: word
            for outcome, (word, *_) in charts.OUTCOMES.items()
            if outcome is not Outcome.UNGRADED or any(map(states.get, NO_MARK))
        },
        outcome_chart=charts.draw_outcomes(part_names, [part.count for part in class_parts]) if graded else "",
        interval_chart=charts.draw_intervals(part_names, [part.discrimination for part in class_parts]),
        least=statistics.LEAST,
        few=scores is None or len(scores.percents) < FEW,
        followed=sum(part.followed for part in class_parts),
        mistakes=mistakes,
        graded=len(graded),
        mistake_chart=charts.draw_mistakes({entry.title: len(entry.students) for entry in charted}),
        groups=_groups_with_answers(results, work),
        unusual=_unusual_forms(work),
        comparisons=comparisons,
        variant_charts=[
            charts.draw_groups(index, entry.groups, entry.shares)
            for index, entry in enumerate(comparisons[:CHARTED_VARIANTS])
        ],
        permutations=statistics.PERMUTATIONS,
        has_due=any(assignment.due_of(student) is not None for student in assignment.roster),
        not_on_time=find_late_or_missing(results),
        overrides=[
            (result.student, name, override) for result in results for name, override in result.overrides.items()
        ],
        visible=make_visible,
        without_attempt=find_without_attempt(results),
        similar=[
            (name, pair, [_cut(pair.first.answer), _cut(pair.second.answer)]) for name, pair in similar[:MOST_PAIRS]
        ],
        similar_left=max(0, len(similar) - MOST_PAIRS),
    )


def _work_on(name: str, results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]) -> list[Work]:
    """Return the work of all students who wrote an answer to a part; `name` is for example "p1.jacobian"."""
    slot, question = name.split(".", 1)
    works = []
    for result in select_graded(results):
        part, problem = result.parts[name], problems[result.student][slot]
        if part.answer is not None and part.answer != SHOWN:
            works.append(Work(result.student, problem, problem[question], part, part.answer))
    return works


def _groups_with_answers(results: Sequence[Result], work: Mapping[str, Sequence[Work]]) -> list[GroupsOfPart]:
    """Return every part that has groups of equal wrong answers, with an answer of each of the largest groups."""
    parts = []
    groups = group_wrong_answers(results)
    for name in dict.fromkeys(group.part for group in groups):
        part_groups = [group for group in groups if group.part == name]
        work_by_student = {student_work.student: student_work for student_work in work[name]}
        answers = [
            work_by_student[group.typical].on_page if group.typical in work_by_student else Answer(SHOWN)
            for group in part_groups[:MOST_GROUPS]
        ]
        parts.append(GroupsOfPart(name, list(zip(part_groups, answers, strict=False)), part_groups[MOST_GROUPS:]))
    return parts


def _compare_variants(
    assignment: Assignment, results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]
) -> list[Comparison]:
    """Return the comparisons between students with different arms, for every problem of the assignment."""
    comparisons = []
    for slot in assignment.slots:
        chains, shares = [], []
        for result in select_graded(results):
            parts = next(problem.parts for problem in result.problems if problem.slot == slot.name)
            points = [part.points for part in parts if part.points is not None]
            if len(points) == len(parts):
                chains.append(problems[result.student][slot.name].chain)
                shares.append(100 * sum(points) / sum(part.max_points for part in parts))
        if chains:
            comparisons += compare(slot.name, chains, shares, assignment.key, varied=slot.family.varied)
    return correct_for_number(comparisons)


def _unusual_forms(of_parts: Mapping[str, Sequence[Work]]) -> list[UnusualForm]:
    """Return correct answers whose form differs most from the reference, for each part the most unusual first."""
    forms = []
    for name, works in of_parts.items():
        by_form: dict[str, tuple[float, Work, int]] = {}
        for work in works:
            if work.result.outcome is not Outcome.CORRECT or work.part.type not in COMPARED:
                continue
            answer, reference = work.parse(work.answer), work.parse(work.part.answer.code())
            if answer is None or reference is None:
                continue
            similarity = alikeness(answer, reference)
            if similarity <= UNUSUAL:
                entry = by_form.get(answer.text, (similarity, work, 0))
                by_form[answer.text] = (*entry[:2], entry[2] + 1)
        most_unusual = sorted(by_form.values(), key=lambda each: (each[0], each[1].student))[:MOST_UNUSUAL]
        forms += [UnusualForm(name, work.on_page, work.student, count) for _, work, count in most_unusual]
    return forms


def _similar_answers(of_parts: Mapping[str, Sequence[Work]]) -> list[tuple[str, Pair]]:
    """Return pairs of nearly identical wrong answers with their part, unless a known mistake explains the answers."""
    pairs: list[tuple[str, Pair]] = []
    for name, works in of_parts.items():
        wrong_answers = []
        for work in works:
            is_unexplained = work.result.mistake is None and work.result.followed_from is None
            if work.result.outcome not in NOT_RIGHT or work.part.type not in COMPARED or not is_unexplained:
                continue
            answer = work.parse(work.answer)
            if answer is not None:
                wrong_answers.append(Wrong(work.student, work.answer, answer, work.part.answer.code()))
        pairs += [(name, pair) for pair in nearly_the_same(wrong_answers, usual=max(3, len(works) // 20))]
    return pairs


def _cut(text: str) -> str:
    return make_visible(text if len(text) <= SHORT else f"{text[:SHORT]} …")
