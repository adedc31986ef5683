"""`qdot report`: the class at a glance, one page for the staff, with charts; nothing in it comes from elsewhere."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.quizzes import ASKED
from qdot.exercises.writing.render import render
from qdot.grader.diagnosis.similar import Pair, Written, Wrong, alikeness, nearly_the_same, written
from qdot.grader.grading.marking import NOT_RIGHT
from qdot.grader.grading.result import PartResult, Result
from qdot.grader.judging.answer_parser import read_answer
from qdot.grader.judging.functions import SHOWN
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports import charts
from qdot.grader.reports.answers import answer_of, visible
from qdot.grader.reports.class_view import (
    GroupOfClass,
    MistakeOfClass,
    PartOfClass,
    Scores,
    graded_work,
    groups,
    mistakes,
    not_on_time,
    parts,
    scores,
    set_by_hand,
    whom,
    without_attempt,
)
from qdot.grader.reports.tables import NO_MARK, status
from qdot.grader.statistics import statistics
from qdot.grader.statistics.fairness_tests import Comparison, compare, corrected, in_words

MOST_CHARTED = 15
"""Mistakes in the chart; all are in the table."""
MOST_UNUSUAL = 2
"""Of a part."""
UNUSUAL = 0.5
"""A right answer has an unusual form where it shares no more than this part of its pieces with the reference."""
MOST_PAIRS = 30
MOST_GROUPS = 20
"""Of a part, of which an answer is shown; the keys of all are in results.jsonl."""
MOST_NAMED = 12
"""Students of a group that are named."""
SHORT = 400
"""Characters of an answer that are shown."""
FEW = 30
"""Of fewer students, figures of difficulty and discrimination say little, and the page says so."""
COMPARED = ("expression", "matrix", "singular", "direction")
"""The types of answers that are compared as they are written."""
CHARTED_VARIANTS = 3


@dataclass(frozen=True)
class Work:
    """A student's work on a part: the answer's text and what became of it, with the problem that it is of."""

    student: str
    problem: Problem
    part: Part
    result: PartResult
    answer: str


@dataclass(frozen=True)
class TenthRow:
    """How many scores, in per cent, are from one bound to below the other."""

    from_percent: int
    to_percent: int
    count: int


@dataclass(frozen=True)
class ScoresOnPage:
    """The scores of the class: figures in words, a table of tenths, and a chart as SVG."""

    count: int
    mean: str
    median: str
    deviation: str | None
    full: int
    rows: list[TenthRow]
    chart: str


@dataclass(frozen=True)
class PartRow:
    """A part of the assignment, its figures in words."""

    name: str
    title: str
    points: str
    count: Mapping[Outcome, int]
    share: str
    omitted: str
    discrimination: str
    interval: str
    followed: int


@dataclass(frozen=True)
class MistakeRow:
    """A mistake, how many students made it, in which parts, and who."""

    title: str
    count: int
    share: str
    parts: str
    who: str


@dataclass(frozen=True)
class AnswerOnPage:
    """An answer: `shown` is HTML, empty where there is the text alone."""

    shown: str
    text: str


@dataclass(frozen=True)
class GroupRow:
    """A group of equal wrong answers; `set_to` is what overrides.csv gives it, empty where that is nothing."""

    key: str
    count: int
    who: str
    typical: str
    answer: AnswerOnPage
    mistake: str
    followed: int
    earned: str
    set_to: str
    comment: str


@dataclass(frozen=True)
class GroupsOfPart:
    """The groups of a part, of several students and of one alone, and how many groups and students are left out."""

    name: str
    title: str
    rows: list[GroupRow]
    alone: list[GroupRow]
    left: int
    students_left: int


@dataclass(frozen=True)
class VariantRow:
    """A comparison of variants: the means of its groups, and what the chance of such a difference says."""

    slot: str
    feature: str
    means: list[str]
    p: str
    said: str


@dataclass(frozen=True)
class UnusualForm:
    """A right answer in a form that few others have, and of how many students."""

    answer: AnswerOnPage
    student: str
    count: int


@dataclass(frozen=True)
class UnusualOfPart:
    """The unusual forms of a part."""

    name: str
    title: str
    forms: list[UnusualForm]


@dataclass(frozen=True)
class PairRow:
    """Two students with nearly the same wrong answer."""

    part: str
    one: str
    other: str
    alike: str
    texts: tuple[str, str]


def class_page(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return the page as self-contained HTML. Raises QdotError where what draws charts is not installed."""
    charts.check()
    names = {student.id: whom(student) for student in assignment.roster}
    able = [result.student for result in graded_work(results)]
    problems = {student: dict(load_stored_problems(assignment, student).problems) for student in able}
    of_class, of_mistakes, of_parts, made = (
        scores(results), mistakes(results), parts(assignment, results), _variants(assignment, results, problems),
    )  # fmt: skip
    work = {part.name: _work(part.name, results, problems) for part in of_parts}
    states = Counter(status(result) for result in results)
    similar, similar_left = _similar(work, names)
    return render(
        "reports/report.html.j2",
        title=assignment.title,
        students=len(results),
        handed_in=sum(result.submission is not None for result in results),
        states={name: states[name] for name in ("graded", "late", "missing", "unusable", *NO_MARK)},
        scores=_scores(of_class),
        alpha=None if of_class.reliability is None else f"{of_class.reliability:.2f}",
        parts=[_part(part) for part in of_parts],
        outcome_words={
            outcome: word
            for outcome, (word, *_) in charts.OUTCOMES.items()
            if outcome is not Outcome.UNGRADED or any(map(states.get, NO_MARK))
        },
        outcome_chart=_outcome_chart(of_parts),
        interval_chart=_interval_chart(of_parts),
        least=statistics.LEAST,
        few=len(of_class.percents) < FEW,
        followed=sum(part.followed for part in of_parts),
        mistakes=_mistakes(of_mistakes, names, len(able)),
        mistake_chart=_mistake_chart(of_mistakes),
        groups=_groups(results, work, names),
        unusual=_unusual(work, names),
        variants=[_variant(each) for each in made],
        variant_charts=[
            {"title": f"{each.slot}, by {each.feature}", "svg": charts.groups(index, each.groups, each.shares)}
            for index, each in enumerate(made[:CHARTED_VARIANTS])
        ],
        permutations=f"{statistics.PERMUTATIONS:,}",
        has_due=any(assignment.due_of(student) is not None for student in assignment.roster),
        not_on_time=not_on_time(assignment, results),
        overrides=set_by_hand(assignment, results),
        without_attempt=without_attempt(assignment, results),
        similar=similar,
        similar_left=similar_left,
    )


def _scores(of_class: Scores) -> ScoresOnPage | None:
    percents = of_class.percents
    if of_class.mean is None or of_class.median is None:
        return None
    tenths = Counter(min(9, int(percent // 10)) for percent in percents)
    return ScoresOnPage(
        count=len(percents),
        mean=f"{of_class.mean:.3g}",
        median=f"{of_class.median:.3g}",
        deviation=None if of_class.deviation is None else f"{of_class.deviation:.3g}",
        full=of_class.full,
        rows=[TenthRow(10 * i, 10 * i + 10, tenths[i]) for i in range(10)],
        chart=charts.histogram(percents, of_class.mean, of_class.median),
    )


# --- parts ---


def _part(part: PartOfClass) -> PartRow:
    interval = part.discrimination
    return PartRow(
        name=part.name,
        title=part.title,
        points=f"{part.max_points:g}",
        count=part.count,
        share="–" if part.share is None else f"{100 * part.share:.0f} %",
        omitted=f"{100 * part.count[Outcome.MISSING] / max(1, part.graded):.0f} %",
        discrimination="–" if interval is None else _with_sign(interval.value),
        interval="" if interval is None else f"{_with_sign(interval.low)} to {_with_sign(interval.high)}",
        followed=part.followed,
    )


def _with_sign(value: float) -> str:
    return f"{round(value, 2) + 0.0:.2f}".replace("-", "−")


def _outcome_chart(of_parts: Sequence[PartOfClass]) -> str:
    if not any(part.graded for part in of_parts):
        return ""
    return charts.outcomes([part.name for part in of_parts], [part.count for part in of_parts])


def _interval_chart(of_parts: Sequence[PartOfClass]) -> str:
    if not any(part.discrimination for part in of_parts):
        return ""
    return charts.intervals([part.name for part in of_parts], [part.discrimination for part in of_parts])


# --- mistakes ---


def _mistakes(mistakes_of_class: Sequence[MistakeOfClass], names: Mapping[str, str], graded: int) -> list[MistakeRow]:
    return [
        MistakeRow(
            title=each.title,
            count=len(each.students),
            share=f"{100 * len(each.students) / graded:.0f} %",
            parts=", ".join(each.parts),
            who=", ".join(names[student] for student in each.students),
        )
        for each in mistakes_of_class
    ]


def _mistake_chart(mistakes_of_class: Sequence[MistakeOfClass]) -> str:
    first = mistakes_of_class[:MOST_CHARTED]
    return (
        charts.mistakes([_shortened(each.title) for each in first], [len(e.students) for e in first]) if first else ""
    )


def _shortened(title: str, most: int = 44) -> str:
    return title if len(title) <= most else f"{title[: most - 1].rstrip()}…"


# --- groups of equal wrong answers ---


def _groups(
    results: Sequence[Result], of_parts: Mapping[str, Sequence[Work]], names: Mapping[str, str]
) -> list[GroupsOfPart]:
    """Return every part that has groups, with those of most students."""
    shown = []
    every = groups(results)
    for name in dict.fromkeys(group.part for group in every):
        of_part = [group for group in every if group.part == name]
        work = {each.student: each for each in of_parts[name]}
        rows = [_group(group, work.get(group.typical), names) for group in of_part[:MOST_GROUPS]]
        left = of_part[MOST_GROUPS:]
        shown.append(
            GroupsOfPart(
                name=name,
                title=ASKED[name.split(".", 1)[1]].title,
                rows=[row for row in rows if row.count > 1],
                alone=[row for row in rows if row.count == 1],
                left=len(left),
                students_left=sum(len(group.students) for group in left),
            )
        )
    return shown


def _group(group: GroupOfClass, typical: Work | None, names: Mapping[str, str]) -> GroupRow:
    who = [names[student] for student in group.students]
    more = len(who) - MOST_NAMED
    least, most = (f"{points:g}" for points in group.earned)
    override = group.override
    set_to = "" if override is None or override.points is None else f"{override.points:g}"
    return GroupRow(
        key=group.key,
        count=len(who),
        who=", ".join(who[:MOST_NAMED]) + (f" and {more} more" if more > 0 else ""),
        typical=names[group.typical],
        answer=AnswerOnPage("", SHOWN) if typical is None else _answer(typical),
        mistake=group.mistake,
        followed=group.followed,
        earned=f"{least if least == most else f'{least} to {most}'} of {group.max_points:g}",
        set_to=set_to,
        comment="" if override is None else visible(override.comment),
    )


# --- variants ---


def _variants(
    assignment: Assignment, results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]
) -> list[Comparison]:
    comparisons = []
    for slot in assignment.slots:
        chains, shares = [], []
        for result in graded_work(results):
            parts = next(problem.parts for problem in result.problems if problem.slot == slot.name)
            points = [part.points for part in parts if part.points is not None]
            if len(points) == len(parts):
                chains.append(problems[result.student][slot.name].chain)
                shares.append(100 * sum(points) / sum(part.max_points for part in parts))
        if chains:
            comparisons += compare(slot.name, chains, shares, assignment.key, varied=slot.family.varied)
    return corrected(comparisons)


def _variant(each: Comparison) -> VariantRow:
    groups = zip(each.groups, each.shares, strict=True)
    means = [f"{name}: {sum(shares) / len(shares):.0f} % ({len(shares)})" for name, shares in groups]
    return VariantRow(each.slot, each.feature, means, f"{each.chance:.3f}", in_words(each.corrected))


# --- answers ---


def _work(name: str, results: Sequence[Result], problems: Mapping[str, Mapping[str, Problem]]) -> list[Work]:
    slot, question = name.split(".", 1)
    works = []
    for result in graded_work(results):
        part, problem = result.parts[name], problems[result.student][slot]
        if part.answer is not None and part.answer != SHOWN:
            works.append(Work(result.student, problem, problem[question], part, part.answer))
    return works


def _unusual(of_parts: Mapping[str, Sequence[Work]], names: Mapping[str, str]) -> list[UnusualOfPart]:
    """Return right answers that have little in common with the reference as it is written, the oddest first."""
    shown = []
    for name, every in of_parts.items():
        by_form: dict[str, tuple[float, Work, int]] = {}
        for work in every:
            if work.result.outcome is not Outcome.CORRECT or work.part.type not in COMPARED:
                continue
            answer, reference = _written(work, work.answer), _written(work, work.part.answer.code())
            if answer is None or reference is None:
                continue
            alike = alikeness(answer, reference)
            if alike <= UNUSUAL:
                before = by_form.get(answer.text, (alike, work, 0))
                by_form[answer.text] = (*before[:2], before[2] + 1)
        oddest = sorted(by_form.values(), key=lambda each: (each[0], each[1].student))[:MOST_UNUSUAL]
        forms = [UnusualForm(_answer(work), names[work.student], count) for _, work, count in oddest]
        if forms:
            shown.append(UnusualOfPart(name, ASKED[oddest[0][1].part.kind].title, forms))
    return shown


def _written(work: Work, text: str) -> Written | None:
    return written(read_answer(work.problem, work.part, text))


def _answer(work: Work) -> AnswerOnPage:
    return AnswerOnPage(answer_of(work.problem, work.part, work.answer).shown, _cut(work.answer))


def _similar(of_parts: Mapping[str, Sequence[Work]], names: Mapping[str, str]) -> tuple[list[PairRow], int]:
    """Return pairs of nearly identical wrong answers, and how many are left out; what a mistake explains is none."""
    alike: list[tuple[str, Pair]] = []
    for name, every in of_parts.items():
        wrong = []
        for work in every:
            unexplained = work.result.mistake is None and work.result.followed_from is None
            if work.result.outcome not in NOT_RIGHT or work.part.type not in COMPARED or not unexplained:
                continue
            answer = _written(work, work.answer)
            if answer is not None:
                wrong.append(Wrong(work.student, work.answer, answer, work.part.answer.code()))
        alike += [(name, pair) for pair in nearly_the_same(wrong, usual=max(3, len(every) // 20))]
    pairs = [
        PairRow(
            part=name,
            one=names[pair.first.student],
            other=names[pair.second.student],
            alike="the same" if pair.alike == 1 else f"{100 * pair.alike:.0f} % in common",
            texts=(_cut(pair.first.answer), _cut(pair.second.answer)),
        )
        for name, pair in alike[:MOST_PAIRS]
    ]
    return pairs, len(alike) - len(pairs)


def _cut(text: str) -> str:
    return visible(text if len(text) <= SHORT else f"{text[:SHORT]} …")
