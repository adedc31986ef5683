"""Mark typed answers in a process that has already loaded the assignments and SymPy, without the database."""

import hashlib
import html
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from qdot.exercises.assignment.assignment import FEEDBACK_LEVELS, Assignment, Student
from qdot.exercises.assignment.release import ReleaseContext, ReleaseResult, release_notebooks_of_student
from qdot.exercises.assignment.store import StoredProblems, load_stored_problems
from qdot.exercises.formula.equality import Counterexample, SetDifference
from qdot.exercises.notebook.notebook import write_answer_cell, write_notebook
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.short_questions import question_of
from qdot.exercises.site.record import make_asked_record, write_html_with_latex
from qdot.exercises.writing import problem_texts
from qdot.exercises.writing.render import render
from qdot.grader.grading.attempt import make_marking_versions, make_part_result
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.grading.copied_answers import ClassAnswers
from qdot.grader.grading.result import NotebookMarks, PartResult, ProblemResult
from qdot.grader.judging.expected_form import explain_unparsed_entry, read_answer
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import MarkingRules, mark
from qdot.grader.reports.feedback import show_parts
from qdot.grader.sandbox.time_budgets import Budget, TimeBudgets
from qdot.grader.serve.assignments import Assignments
from qdot.grader.submissions.answer_locator import describe_unset

Key = TypeVar("Key")
Value = TypeVar("Value")


@dataclass(frozen=True)
class ClassOfAssignment:
    """The key of an assignment, and the identifiers of a class's students, who may copy from each other."""

    key: str
    students: tuple[str, ...]


@dataclass(frozen=True)
class TypedAnswers:
    """A student's typed answers by part, as in "p1.jacobian", and the marks of problems that are not marked again.

    If `is_quick`, marking stops after a short time.
    """

    class_of_assignment: ClassOfAssignment
    student: str
    answers: Mapping[str, str]
    finished_problems: Mapping[str, ProblemResult]
    is_quick: bool = False


@dataclass(frozen=True, kw_only=True)
class ShownPart:
    """What a student's page shows of the verdict on a part, at the level of feedback; texts are HTML.

    `entries` has "right", "follows", "blank" or "wrong" for each entry. `pose` has the joint values of the
    counterexample, and `followed_from` is the name of the part from which the answer follows. `costs_try` is False if
    qdot could not read or judge the answer.
    """

    sentences: tuple[str, ...]
    entries: list[list[str]] | None
    counterexample: str | None
    pose: dict[str, float] | None
    followed_from: str | None
    answer: str | None
    costs_try: bool = True


class Judge:
    """Marks typed answers. The problems of recent students and the correct answers of a class stay in memory."""

    def __init__(self, folders: tuple[Path, ...]) -> None:
        self._assignments = Assignments(folders)
        self._problems = dict[tuple[str, ...], StoredProblems]()
        self._class_answers = dict[tuple[object, ...], ClassAnswers]()
        for assignment in self._assignments.load_all().values():
            self._warm_up(ClassOfAssignment(assignment.key, tuple(student.id for student in assignment.roster)))

    def load_assignment(self, class_of_assignment: ClassOfAssignment) -> Assignment:
        """Return an assignment with the class as its roster."""
        roster = tuple(map(Student, class_of_assignment.students))
        return replace(self._assignments.load_all()[class_of_assignment.key], roster=roster)

    def load_problems(self, assignment: Assignment, student: str) -> StoredProblems:
        """Return the problems of a student."""
        key = (assignment.key, assignment.notebook_digest_of(student), assignment.marking_digest, student)
        return _remember(self._problems, key, lambda: load_stored_problems(assignment, student))

    def find_class_answers(self, assignment: Assignment) -> ClassAnswers:
        """Return the correct answers of the class."""
        students = tuple(student.id for student in assignment.roster)
        key = (assignment.problems_digest, students, tuple(sorted(assignment.replacements)))
        return _remember(self._class_answers, key, lambda: ClassAnswers(assignment))

    def _warm_up(self, class_of_assignment: ClassOfAssignment) -> None:
        """Load everything that marking needs, so that the first student does not have to wait."""
        assignment = self.load_assignment(class_of_assignment)
        for student in class_of_assignment.students[:1]:
            for slot, problem in self.load_problems(assignment, student).problems:
                for part in problem.parts:
                    self.find_class_answers(assignment).find_fingerprints(slot, part)
                mark(problem, {part.name: "theta1 + 1" for part in problem.parts[:1]}, secret=assignment.secret)


MAX_REMEMBERED = 256
"""Maximum number of students whose problems, and of classes whose answers, stay in memory."""


def _remember(memory: dict[Key, Value], key: Key, make: Callable[[], Value]) -> Value:
    """Return the value that is stored for a key; if it is missing, make it, and drop the oldest value."""
    if key not in memory:
        if len(memory) >= MAX_REMEMBERED:
            memory.pop(next(iter(memory)))
        memory[key] = make()
    return memory[key]


# --- what a judge does ---


def stay_busy(_: Judge, seconds: float) -> None:
    """Keep this process busy, so that the pool starts another process for other work."""
    time.sleep(seconds)


@dataclass(frozen=True)
class MarkedAnswers:
    """The marks of a student's answers, and what the student's page shows of them by part, as in "p1.jacobian"."""

    marks: NotebookMarks
    shown: Mapping[str, ShownPart]


QUICK_JUDGING, QUICK_DIAGNOSING = 3.0, 2.0
"""Maximum seconds of processor time for answers that students wait for; most answers need less than one second."""


def mark_typed_answers(judge: Judge, request: TypedAnswers) -> MarkedAnswers | None:
    """Return the marks of typed answers: those that `qdot grade` gives to the notebook with the same answers.

    The result is None if marking must be quick but takes too long.
    """
    assignment = judge.load_assignment(request.class_of_assignment)
    class_answers = judge.find_class_answers(assignment)
    stored_problems, budgets = judge.load_problems(assignment, request.student), TimeBudgets()
    if request.is_quick:
        budgets = TimeBudgets(Budget(QUICK_JUDGING), Budget(QUICK_DIAGNOSING))
    results = list[ProblemResult]()
    for slot, problem in stored_problems.problems:
        if slot in request.finished_problems:
            results.append(request.finished_problems[slot])
            continue
        names = {part.name: f"{slot}.{part.name}" for part in problem.parts}
        texts = {name: request.answers[full_name] for name, full_name in names.items() if full_name in request.answers}
        reasons = {name: describe_unset(name_answer_variable(slot, name)) for name in names}
        rules = MarkingRules(assignment.follow_through, partial(class_answers.is_correct_for_another, problem, slot))
        verdicts = mark(problem, texts, reasons, secret=assignment.secret, rules=rules, budgets=budgets)
        parts = tuple(make_part_result(slot, verdict) for verdict in verdicts)
        results.append(ProblemResult(str(problem.id), slot, parts))
    if request.is_quick and min(budgets.judging.remaining_seconds, budgets.diagnosing.remaining_seconds) <= 0:
        return None
    notebook = write_answers_notebook(assignment, request.student, request.answers)
    marks = NotebookMarks(
        sha256=hashlib.sha256(notebook.encode()).hexdigest(),
        made_from=make_marking_versions(assignment, request.student), problems=tuple(results),
    )  # fmt: skip
    return MarkedAnswers(marks, show_marks(assignment, stored_problems, marks, set(request.finished_problems)))


def limit_open_feedback(assignment: Assignment) -> Assignment:
    """Return the assignment without feedback that shows right answers, for students who may still submit."""
    return replace(assignment, feedback=min(assignment.feedback, "counterexample", key=FEEDBACK_LEVELS.index))


def show_marks(
    assignment: Assignment, stored_problems: StoredProblems, marks: NotebookMarks, omitted_slots: set[str]
) -> dict[str, ShownPart]:
    """Map each part to what the student's page shows of its marks while answers can still be submitted."""
    shown, level = dict[str, ShownPart](), limit_open_feedback(assignment).feedback
    for number, ((slot, problem), result) in enumerate(zip(stored_problems.problems, marks.problems, strict=True), 1):
        if slot in omitted_slots:
            continue
        stored_texts = stored_problems.pieces_of(slot)
        for part_on_page in show_parts(stored_texts, number, problem, result.parts, level):
            part_result = part_on_page.result
            is_missing = part_result.outcome is Outcome.MISSING
            texts = [] if is_missing or part_result.outcome is Outcome.CORRECT else [part_on_page.reason]
            if texts and texts[0].startswith("qdot couldn't parse your answer:"):
                part = problem[part_result.name]
                texts = [explain_unparsed_entry(problem, part, part_result.answer or "") or texts[0]]
            sentences = [html.escape(end_sentence(text), quote=False) for text in (part_on_page.advice, *texts) if text]
            table = render("reports/difference.html.j2", table=part_on_page.table) if part_on_page.table else ""
            answer = part_on_page.answer
            counterexample = part_result.certificate and part_result.certificate.counterexample
            followed_from = part_result.followed_from
            shown[f"{slot}.{part_result.name}"] = ShownPart(
                sentences=tuple(sentences), entries=part_on_page.entry_states,
                counterexample=f"{table}{part_on_page.counterexample_figure}" or None,
                pose=_find_pose(problem, counterexample) if counterexample else None,
                followed_from=f"{slot}.{followed_from}" if followed_from else None,
                answer=None if answer is None else answer.html or html.escape(answer.text, quote=False),
                costs_try=not is_missing and part_result.points is not None and not _is_refused(problem, part_result),
            )  # fmt: skip
    return shown


def _is_refused(problem: Problem, part: PartResult) -> bool:
    """Return whether a wrong answer was refused when it was parsed, so it was not compared."""
    if part.outcome is not Outcome.WRONG or part.certificate is not None or part.answer is None:
        return False
    return read_answer(problem, problem[part.name], part.answer).refusal is not None


def end_sentence(text: str) -> str:
    """Return a sentence with a full stop, unless it already ends with punctuation."""
    return text if text.endswith((".", "?", "!")) else f"{text}."


def _find_pose(problem: Problem, example: Counterexample) -> dict[str, float] | None:
    """Return the joint values of a counterexample; None if it has none."""
    configuration = (example.surplus or example.missing) if isinstance(example, SetDifference) else example.at
    joints = {q.name for q in problem.chain.q}
    return {name: value for name, value in (configuration or {}).items() if name in joints} or None


def write_answers_notebook(assignment: Assignment, student: str, answers: Mapping[str, str]) -> str:
    """Return the text of a notebook with a student's typed answers; the same answers give the same text."""
    cells: list[dict[str, Any]] = [
        {
            "cell_type": "code", "execution_count": None, "id": part.replace(".", "-")[:64], "outputs": [],
            "metadata": {"qdot": {"part": part}},
            "source": write_answer_cell(part, answers[part]),
        }
        for part in sorted(answers)
    ]  # fmt: skip
    claims = {"assignment": assignment.key, "student": student, "digest": assignment.problems_digest_of(student)}
    return write_notebook({"cells": cells, "metadata": {"qdot": claims}, "nbformat": 4, "nbformat_minor": 5})


@dataclass(frozen=True)
class StudentOfClass:
    """A student of a class, for an assignment; `language` is the language of the page."""

    class_of_assignment: ClassOfAssignment
    student: str
    language: str = "en"


def release_problems(judge: Judge, request: StudentOfClass) -> ReleaseResult:
    """Generate, certify and store the problems of a student who has none yet, as `qdot generate` does."""
    context = ReleaseContext(judge.load_assignment(request.class_of_assignment), CERTIFIER)
    return release_notebooks_of_student(context, request.student)


def have_common_arm(judge: Judge, requests: Sequence[StudentOfClass]) -> bool:
    """Return whether two students have problems about the same arm."""
    first_problems, second_problems = (
        judge.load_problems(judge.load_assignment(request.class_of_assignment), request.student).problems
        for request in requests
    )
    return any(first.chain == second.chain for _, first in first_problems for _, second in second_problems)


def make_problem_records(judge: Judge, request: StudentOfClass) -> list[dict[str, Any]]:
    """Return a student's problems as the page shows them: {"slot", "problem"}, without keys and solutions.

    The id in a record is the slot's name. From the problem's id, anybody could generate the problem and its answers.
    """
    assignment = judge.load_assignment(request.class_of_assignment)
    problems = judge.load_problems(assignment, request.student).problems
    records = [(slot, make_asked_record(problem, assignment.hints, request.language)) for slot, problem in problems]
    return [{"slot": slot, "problem": record | {"id": slot}} for slot, record in records]


def make_solutions(judge: Judge, request: StudentOfClass) -> dict[str, dict[str, str]]:
    """Map each part, as in "p1.jacobian", to its title, its worked solution (HTML with LaTeX), and its typed answer."""
    assignment = judge.load_assignment(request.class_of_assignment)
    return {
        f"{slot}.{part.name}": _write_solution(problem, part)
        for slot, problem in judge.load_problems(assignment, request.student).problems
        for part in problem.parts
    }


def _write_solution(problem: Problem, part: Part) -> dict[str, str]:
    solution = write_html_with_latex(problem_texts.write_solution(problem, part))
    typed_answer = problem_texts.write_answer_code(problem, part)
    return {"title": question_of(part).title, "solution": solution, "typed": typed_answer}
