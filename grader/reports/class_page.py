"""The class overview of `qdot report`: one page for the staff, with charts; nothing in it comes from elsewhere."""

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
"""Mistakes in the chart; all are in the table."""
MOST_UNUSUAL = 2
"""Unusual forms that are shown of a part."""
UNUSUAL = 0.5
"""A right answer has an unusual form if it shares no more than this part of its pieces with the reference."""
MOST_PAIRS = 30
MOST_GROUPS = 20
"""Groups of a part of which an answer is shown; the keys of all are in results.jsonl."""
SHORT = 400
"""Characters of an answer that are shown."""
FEW = 30
"""With fewer students, figures of difficulty and discrimination say little, and the page says so."""
COMPARED = ("expression", "matrix", "singular", "direction")
"""The types of answers that are compared as they are written."""
CHARTED_VARIANTS = 3


@dataclass(frozen=True)
class Work:
    """A student's work on a part: the answer's text and what became of it, with the student's problem."""

    student: str
    problem: Problem
    part: Part
    result: PartResult
    answer: str

    @property
    def on_page(self) -> Answer:
        """The answer as the page shows it, its text cut short."""
        return replace(show_answer(self.problem, self.part, self.answer), text=_cut(self.answer))

    def parse(self, text: str) -> Written | None:
        """Return a text as an answer to this part in the form in which answers are compared, None if there is none."""
        return written(read_answer(self.problem, self.part, text))


@dataclass(frozen=True)
class GroupsOfPart:
    """The groups of equal wrong answers of a part, those that are shown and those that are left out."""

    name: str
    groups: Sequence[tuple[GroupOfClass, Answer]]
    left_out: Sequence[GroupOfClass]


@dataclass(frozen=True)
class UnusualForm:
    """A right answer to a part in a form that few others have, one student who wrote it, and how many did."""

    part: str
    answer: Answer
    student: str
    count: int


def make_class_page(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the page as self-contained HTML. Raises QdotError if the library that draws charts is not installed."""
    charts.check_library()
    graded = [result.student for result in select_graded(results)]
    problems = {student: dict(load_stored_problems(assignment, student).problems) for student in graded}
    of_class, of_mistakes, of_parts = (
        summarize_scores(results),
        summarize_mistakes(results),
        summarize_parts(assignment, results),
    )
    comparisons = _compare_variants(assignment, results, problems)
    work = {part.name: _work_on(part.name, results, problems) for part in of_parts}
    part_names = [part.name for part in of_parts]
    states = Counter(status(result) for result in results)
    similar = _similar_answers(work)
    charted = of_mistakes[:MOST_CHARTED]
    return render(
        "reports/report.html.j2",
        title=assignment.title,
        names={student.id: describe_student(student) for student in assignment.roster},
        titles={part.name: part.title for part in of_parts},
        students=len(results),
        handed_in=sum(result.submission is not None for result in results),
        states={name: states[name] for name in ("graded", "late", "missing", "unusable", *NO_MARK)},
        scores=of_class,
        score_chart=charts.draw_histogram(of_class.percents, of_class.mean, of_class.median) if of_class else "",
        parts=of_parts,
        outcome_words={
            outcome: word
            for outcome, (word, *_) in charts.OUTCOMES.items()
            if outcome is not Outcome.UNGRADED or any(map(states.get, NO_MARK))
        },
        outcome_chart=charts.draw_outcomes(part_names, [part.count for part in of_parts]) if graded else "",
        interval_chart=charts.draw_intervals(part_names, [part.discrimination for part in of_parts]),
        least=statistics.LEAST,
        few=of_class is None or len(of_class.percents) < FEW,
        followed=sum(part.followed for part in of_parts),
        mistakes=of_mistakes,
        graded=len(graded),
        mistake_chart=charts.draw_mistakes({each.title: len(each.students) for each in charted}),
        groups=_groups_with_answers(results, work),
        unusual=_unusual_forms(work),
        comparisons=comparisons,
        variant_charts=[
            charts.draw_groups(index, each.groups, each.shares)
            for index, each in enumerate(comparisons[:CHARTED_VARIANTS])
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
    """Return the work of all students on a part, called as in "p1.jacobian", that has a text of the student's own."""
    slot, question = name.split(".", 1)
    works = []
    for result in select_graded(results):
        part, problem = result.parts[name], problems[result.student][slot]
        if part.answer is not None and part.answer != SHOWN:
            works.append(Work(result.student, problem, problem[question], part, part.answer))
    return works


def _groups_with_answers(results: Sequence[Result], work: Mapping[str, Sequence[Work]]) -> list[GroupsOfPart]:
    """Return every part that has groups of equal wrong answers, with those of most students."""
    shown = []
    every = group_wrong_answers(results)
    for name in dict.fromkeys(group.part for group in every):
        of_part = [group for group in every if group.part == name]
        of_students = {each.student: each for each in work[name]}
        answers = [
            of_students[group.typical].on_page if group.typical in of_students else Answer(SHOWN)
            for group in of_part[:MOST_GROUPS]
        ]
        shown.append(GroupsOfPart(name, list(zip(of_part, answers, strict=False)), of_part[MOST_GROUPS:]))
    return shown


def _compare_variants(
    assignment: Assignment, results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]
) -> list[Comparison]:
    """Return the comparisons of students whose arms differ, for every problem of the assignment."""
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
    """Return right answers that have little in common with their reference as it is written, a part's oddest first."""
    forms = []
    for name, every in of_parts.items():
        by_form: dict[str, tuple[float, Work, int]] = {}
        for work in every:
            if work.result.outcome is not Outcome.CORRECT or work.part.type not in COMPARED:
                continue
            answer, reference = work.parse(work.answer), work.parse(work.part.answer.code())
            if answer is None or reference is None:
                continue
            alike = alikeness(answer, reference)
            if alike <= UNUSUAL:
                before = by_form.get(answer.text, (alike, work, 0))
                by_form[answer.text] = (*before[:2], before[2] + 1)
        oddest = sorted(by_form.values(), key=lambda each: (each[0], each[1].student))[:MOST_UNUSUAL]
        forms += [UnusualForm(name, work.on_page, work.student, count) for _, work, count in oddest]
    return forms


def _similar_answers(of_parts: Mapping[str, Sequence[Work]]) -> list[tuple[str, Pair]]:
    """Return pairs of nearly identical wrong answers with their part; what a known mistake explains is no pair."""
    pairs: list[tuple[str, Pair]] = []
    for name, every in of_parts.items():
        wrong = []
        for work in every:
            unexplained = work.result.mistake is None and work.result.followed_from is None
            if work.result.outcome not in NOT_RIGHT or work.part.type not in COMPARED or not unexplained:
                continue
            answer = work.parse(work.answer)
            if answer is not None:
                wrong.append(Wrong(work.student, work.answer, answer, work.part.answer.code()))
        pairs += [(name, pair) for pair in nearly_the_same(wrong, usual=max(3, len(every) // 20))]
    return pairs


def _cut(text: str) -> str:
    return make_visible(text if len(text) <= SHORT else f"{text[:SHORT]} …")
