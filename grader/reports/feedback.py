"""Write a student's feedback page: for each part, what is correct, what is wrong, where, and why.

The page is made from a result as in results.jsonl, and from the stored texts and figures of the student's problems. The
page contains the worked solutions if the assignment sets `feedback = "solutions"`.
"""

import hashlib
import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.store import load_stored_problems
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.formula.equality import Certificate
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.short_questions import question_of
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.problem_texts import write_solution
from qdot.exercises.writing.render import render
from qdot.grader.grading.result import PartResult, Result
from qdot.grader.judging.answer_parser import BLANK_JUDGEMENT
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import WRONG_OR_PARTIAL
from qdot.grader.reports.answer_display import ShownAnswer, make_visible, show_answer
from qdot.grader.reports.counterexample_figure import draw_example
from qdot.grader.reports.counterexample_table import SUPERSCRIPT, CounterexampleTable, make_counterexample_table
from qdot.grader.reports.feedback_levels import (
    capitalize,
    limit_feedback,
    remove_numbers,
    replace_patterns,
    shows_at_least,
)
from qdot.grader.reports.grades_table import find_work_status, has_points
from qdot.grader.reports.part_rows import describe_decisions, describe_override

PAGE_VERSION = 15
"""Version of the page; increase it when the page's content changes, so that every page is rewritten."""

OUTCOME_WORDS = dict(zip(Outcome, ("right", "partly right", "wrong", "not answered", "not graded yet"), strict=True))
CELL_STOP_OUTCOMES = (
    (r"\bqdot stopped the cell with this answer\b", "stopped at the time limit"),
    (r"\bcell with this answer stopped\b.* \(it (took|waited) longer\b", "stopped at the time limit"),
    (r"\bcell with this answer stopped\b", "stopped with an error"),
)
"""Patterns of the reason why an answer is missing, each with the outcome in words that the page shows instead."""
NO_ANSWERS_NOTE = "Your notebook has no answer to any question. Did you submit the notebook in which you worked?"
ADVICE_BY_STATUS = {
    "missing": "If you did submit your notebook, tell your instructor.",
    "unusable": "Check the file that you submitted. If you can still submit, submit your notebook for this assignment: "
    "open it in Jupyter, save it, and submit that file. If it does not open or it is too late, tell your instructor.",
}
"""Maps the status of work (`find_work_status`) to what a student can do if there was no notebook to grade."""
MAX_PARTS_WITHOUT_OVERVIEW = 6
"""If a student has more parts than this, the page begins with an overview of them."""

_END = r"(?=$|\. )"  # the end of a sentence
SHORT_REASONS = (
    (rf"\. Compared with the solution: your answer differs{_END}", ""),
    (rf"^your answer differs{_END}(\. )?", ""),
    (rf"; your answer differs{_END}", ""),
    (rf"\b(entry (?:\d+|\(\d+, \d+\))) differs{_END}", r"\1 is wrong"),
    (rf"; number \d+ is not right{_END}", ""),
    (rf"^your number is not right{_END}(\. )?", ""),
    (r"(\byou found\b.*); an? [a-z ]+ is missing\b", r"\1"),
    (r"(\bconditions? (?:is|are) wrong); this configuration [a-z ]+", r"\1"),
    (r"\bthis configuration is not singular\b", "your answer includes a configuration that is not singular"),
    (r"\bthis configuration does not satisfy the condition\b", "your answer includes a wrong configuration"),
)
"""Patterns of phrases that make no sense or say nothing new without their numbers, with replacements.

The page shows the numbers in a table, and which entries are right.
"""
DEGREES_REASON = r"(?:; |^)your values are in degrees, but the question asks for radians\b"
"""A pattern of a phrase that is left out if the advice says the same."""


@dataclass(frozen=True, kw_only=True)
class PartOnPage:
    """A part as the template shows it; `result` has only what the feedback level allows.

    `outcome_text` is the outcome in words. `comparison` says how a correct answer was compared. `entry_states` has
    "right", "follows", "blank" or "wrong" for each entry of the answer. `followed_from` is the number of the earlier
    part with the wrong answer from which this answer follows. `counterexample_figure`, `prompt`, `figure` and
    `solution` are HTML.
    """

    id: str
    number: str
    title: str
    result: PartResult
    outcome_text: str
    reason: str
    advice: str
    override: str
    comparison: str
    answer: ShownAnswer | None
    entry_states: list[list[str]] | None
    followed_from: str | None
    table: CounterexampleTable | None
    counterexample_figure: str
    prompt: str
    figure: str
    solution: str | None


@dataclass(frozen=True)
class ProblemOnPage:
    """A problem as the template shows it; `figure` and `statement` are HTML."""

    id: str
    title: str
    figure: str
    statement: str
    parts: tuple[PartOnPage, ...]


def compute_page_fingerprint(assignment: Assignment, student: Student, result: Result) -> str:
    """Return a short text that changes whenever the page must change; the page contains it."""
    content = [PAGE_VERSION, assignment.notebook_digest, assignment.feedback, student.name, to_jsonable(result)]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def make_feedback_page(assignment: Assignment, student: Student, result: Result) -> str:
    """Return the student's page as self-contained HTML. Problems are loaded from the store, not regenerated."""
    problems = [] if result.obstacle is not None else _show_problems(assignment, student, result)
    parts = [part for problem in problems for part in problem.parts]
    decisions = describe_decisions(result)
    if result.obstacle is not None:
        overrides = {name: part.override for name, part in result.parts.items() if part.override}
        decisions += [describe_override(override, f" for {name}") for name, override in overrides.items()]
    notes = [make_visible(note) for note in (*decisions, *map(capitalize, _omit_repeated_stops(result.notes, parts)))]
    first_parts = [part for problem in problems if (part := _find_first_part(problem))]
    if parts and all(part.outcome_text == OUTCOME_WORDS[Outcome.MISSING] for part in parts):
        notes, first_parts = [NO_ANSWERS_NOTE, *notes], []
    elif len(blank_numbers := [part.number for part in parts if _is_blank(part)]) > 1:
        notes = [f"You left {len(blank_numbers)} answers blank: {', '.join(blank_numbers)}.", *notes]
    elif parts and all(part.result.outcome is Outcome.CORRECT for part in parts):
        notes = ["All of your answers are right.", *notes]
    first_numbers = dict[str, str]()
    shortened_parts = [tuple(_shorten_texts(part, first_numbers) for part in problem.parts) for problem in problems]
    problems = [replace(problem, parts=parts) for problem, parts in zip(problems, shortened_parts, strict=True)]
    return render(
        "reports/feedback.html.j2", title=assignment.title, student=student, result=result, problems=problems,
        made_from=compute_page_fingerprint(assignment, student, result), marked_extent=_find_marked_extent(result),
        obstacle=make_visible(result.obstacle or ""), notes=notes, first_parts=first_parts,
        advice=ADVICE_BY_STATUS.get(find_work_status(result), ""),
        has_overview=len(parts) > MAX_PARTS_WITHOUT_OVERVIEW,
        withheld_note=_describe_withheld_feedback(assignment.feedback, parts),
    )  # fmt: skip


def _is_blank(part: PartOnPage) -> bool:
    return part.result.outcome is Outcome.MISSING and part.result.reason == BLANK_JUDGEMENT.reason


def _shorten_texts(part: PartOnPage, first_numbers: dict[str, str]) -> PartOnPage:
    """Return a part without what the page says elsewhere: that the answer is blank, or what an earlier mistake was.

    `first_numbers` is updated. It maps the sentence on each mistake, and the number of each part that repeats the
    mistake, to the number of the first part with this mistake.
    """
    if _is_blank(part):
        return replace(part, reason="")
    if match := re.match(r"(You seem to have made the same mistake as in )(\d+\.\d+)", part.advice):
        number = first_numbers.get(match[2], match[2])
        return replace(part, advice=f"{match[1]}{number}{part.advice[match.end() :]}")
    sentence, separator, reference = part.advice.partition(" See ")
    if not part.result.mistake or (number := first_numbers.setdefault(sentence, part.number)) == part.number:
        return part
    first_numbers[part.number] = number
    return replace(part, advice=f"You seem to have made the same mistake as in {number}.{separator}{reference}")


def _omit_repeated_stops(notes: Sequence[str], parts: Sequence[PartOnPage]) -> list[str]:
    """Return the notes, without those on stopped cells if the parts below mention all of these stops."""
    stop_notes = [note for note in notes if re.fullmatch(r"qdot stopped cell \d+: [^;]*", note)]
    stopped_parts = [part for part in parts if part.reason.startswith("qdot stopped the cell with this answer")]
    return [note for note in notes if note not in stop_notes or len(stopped_parts) < len(stop_notes)]


def _find_first_part(problem: ProblemOnPage) -> PartOnPage | None:
    """Return the part to correct first: the first one that is wrong or stopped, otherwise the first one not answered.

    Later parts often repeat a mistake of that part, so the page does not list them.
    """
    stop_outcomes = {text for _, text in CELL_STOP_OUTCOMES}
    wrong_parts = [
        part for part in problem.parts if part.result.outcome in WRONG_OR_PARTIAL or part.outcome_text in stop_outcomes
    ]
    unanswered_parts = [part for part in problem.parts if part.result.outcome is Outcome.MISSING]
    return next(iter(wrong_parts + unanswered_parts), None)


def _find_marked_extent(result: Result) -> str:
    """Return how much of the work has a mark: "nothing", "some" parts, or "all"."""
    if not has_points(result):
        return "nothing"
    part_points = [part.points for part in result.parts.values()]
    if None not in part_points or result.override is not None:
        return "all"
    return "some" if any(points is not None for points in part_points) else "nothing"


def _describe_withheld_feedback(level: str, parts: Sequence[PartOnPage]) -> str:
    """Return a note on what the page doesn't show about wrong answers; "" if it shows everything."""
    if shows_at_least(level, "values") or not any(part.result.outcome in WRONG_OR_PARTIAL for part in parts):
        return ""
    if shows_at_least(level, "counterexample"):
        if all(part.table is None for part in parts):
            return "This page does not show correct values."
        details = "a configuration and your answer's value there, but not the correct value"
        return f"For most wrong answers, this page shows {details}."
    if shows_at_least(level, "mistake"):
        return "Mistakes are named. Correct values, and configurations at which an answer is wrong, are not shown."
    return "This page shows only the points of each part, and answers that qdot could not parse."


def _show_problems(assignment: Assignment, student: Student, result: Result) -> list[ProblemOnPage]:
    """Return the student's problems, each with its parts and their results, in the order of the page."""
    stored_problems, problems = load_stored_problems(assignment, student.id), list[ProblemOnPage]()
    for number, (slot, problem) in enumerate(stored_problems.problems, 1):
        stored_texts, results = stored_problems.pieces_of(slot), result.problems[number - 1].parts
        parts = show_parts(stored_texts, number, problem, results, assignment.feedback)
        title, statement = f"Problem {number}: {problem.title}", _add_caption(stored_texts["statement"], problem)
        problems.append(ProblemOnPage(f"problem-{number}", title, stored_texts["figure"], statement, parts))
    return problems


def _add_caption(statement: str, problem: Problem) -> str:
    """Return the statement of a problem with a caption for its table, because screen readers read the caption first.

    The cells of the table's header get a scope, so that a screen reader can read the header of each column.
    """
    caption = f'<table><caption class="unseen">{convention_of(problem.chain).caption}</caption>'
    return re.sub(r"<th\b(?!ead)", '<th scope="col"', statement.replace("<table>", caption))


def show_parts(
    stored_texts: Mapping[str, str], number: int, problem: Problem, results: Sequence[PartResult], feedback: str
) -> tuple[PartOnPage, ...]:
    """Return the parts of a problem with a number (from 1); their texts refer to other parts by number.

    `stored_texts` has the problem's texts and figures, as HTML. `feedback` is the level of feedback.
    """
    numbers = {result.name: f"{number}.{index}" for index, result in enumerate(results, 1)}
    parts = []
    for index, result in enumerate((limit_feedback(result, feedback) for result in results), 1):
        part, outcome, text = problem[result.name], result.outcome, result.answer
        is_wrong = outcome in WRONG_OR_PARTIAL
        # A partly blank vector is shown as an answer.
        is_blank = outcome is Outcome.MISSING and not re.sub(r"blank|[\s\[\](),]", "", text or "")
        example = result.certificate and result.certificate.counterexample
        table = make_counterexample_table(problem, part, example) if is_wrong and example else None
        reason = _write_reason(result, omits_numbers=is_wrong and result.certificate is not None)
        part_on_page = PartOnPage(
            id=f"part-{number}-{index}", number=numbers[part.name], title=question_of(part).title, result=result,
            outcome_text=_describe_outcome(result), reason=_replace_names_by_numbers(reason, problem, numbers),
            advice=_replace_names_by_numbers(result.advice or "", problem, numbers),
            override=make_visible(describe_override(result.override)) if result.override else "",
            comparison=_describe_comparison(part, result.certificate) if outcome is Outcome.CORRECT else "",
            answer=None if text is None or is_blank else show_answer(problem, part, text),
            entry_states=_find_entry_states(problem, part, result) if is_wrong else None,
            followed_from=numbers.get(result.followed_from or ""), table=table,
            counterexample_figure=draw_example(problem, part, example, text) if table is not None and example else "",
            prompt=stored_texts[f"{part.name} prompt"], figure=stored_texts[f"{part.name} figure"],
            solution=to_html(write_solution(problem, part)) if feedback == "solutions" else None,
        )  # fmt: skip
        parts.append(part_on_page)
    return tuple(parts)


def _describe_outcome(part: PartResult) -> str:
    """Return the outcome of a part in words; a missing answer whose cell crashed is not called unanswered."""
    stop_outcomes = [text for pattern, text in CELL_STOP_OUTCOMES if re.search(pattern, part.reason)]
    return stop_outcomes[0] if part.outcome is Outcome.MISSING and stop_outcomes else OUTCOME_WORDS[part.outcome]


def _find_entry_states(problem: Problem, part: Part, result: PartResult) -> list[list[str]] | None:
    """Return for each entry whether it is right, wrong or blank, or follows from an earlier wrong answer.

    Return None if the answer has only one entry, or none.
    """
    entries = result.entries or ()
    entry_count = sum(map(len, entries))
    if entry_count <= 1:
        return None
    blanks = read_answer(problem, part, result.answer or "").is_blank
    remaining_blanks = iter(blanks if len(blanks) == entry_count else [False] * entry_count)

    def find_state(is_right: bool, follows: bool) -> str:
        is_blank = next(remaining_blanks)
        if is_right or follows:
            return "right" if is_right else "follows"
        return "blank" if is_blank else "wrong"

    return [list(map(find_state, *rows)) for rows in zip(entries, result.follows or entries, strict=True)]


def _replace_names_by_numbers(text: str, problem: Problem, numbers: Mapping[str, str]) -> str:
    """Return a text with the names of parts, as in "to 'jacobian'", replaced by their numbers on the page."""
    for name, number in numbers.items():
        names = f"{re.escape(name)}|{re.escape(question_of(problem[name]).title)}"
        text = re.sub(rf"(\bto|\bin|,|\band) '(?:{names})'", rf"\1 {number}", text)
    return text


def _write_reason(part: PartResult, omits_numbers: bool) -> str:
    """Return the reason why an answer is wrong; if `omits_numbers`, without the numbers that a table shows.

    If several entries are wrong, the reason names none of them.
    """
    reason = replace_patterns(remove_numbers(part.reason), SHORT_REASONS) if omits_numbers else part.reason
    if sum(not is_right for row in part.entries or () for is_right in row) > 1:
        reason = re.sub(rf"; entry (\d+|\(\d+, \d+\)) (is wrong|differs){_END}", "", reason)
    if "in degrees" in (part.advice or ""):
        reason = re.sub(DEGREES_REASON, "", reason)
    return make_visible(capitalize(reason))


def _describe_comparison(part: Part, certificate: Certificate | None) -> str:
    """Return how a correct answer was compared, and the probability that a wrong one would have passed."""
    if certificate is None or (certificate.points < 2 and not certificate.bound):
        return ""
    points, bound = certificate.points, certificate.bound
    if not bound:
        return f"qdot compared your answer with the solution at {count_noun(points, 'configuration')}."
    power = str(-math.ceil(math.log10(bound))).translate(SUPERSCRIPT)
    comparison = "evaluated your formula and the solution at random values in exact arithmetic"
    error = "A wrong answer"
    if certificate.method != "exact":  # bound = (1 - share) ** points
        share = f"{1 - bound ** (1 / points):.0%}".replace("50%", "half")
        comparison = f"compared your answer with the solution at {points} random configurations"
        error = f"An answer that is wrong for at least {share} of all configurations"
        if part.answer.is_set:
            comparison = f"tested each of your conditions at {points} random configurations that satisfy it"
            error = f"A condition that is wrong for at least {share} of its configurations"
    return f"qdot {comparison}. {error} would pass this check with a probability of less than 1 in 10{power}."
