"""Offer problems of the same kind for practice, which students try as often as they like; no mark is stored.

A set consists of the assignment's problems for an identifier that no student has. So sets are certified, and the same
for all students. Answers stay in memory until the student opens another set, and for a day at most.
"""

from dataclasses import replace
from typing import Any

from django.core.cache import cache
from django.http import HttpRequest, HttpResponse, HttpResponseRedirect, JsonResponse
from django.utils import timezone
from django.views.decorators.http import require_GET, require_http_methods, require_POST

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.exercises.common.json_form import to_jsonable
from qdot.grader.grading.final_result import GradedNotebook, compute_final_result
from qdot.grader.serve.class_list import describe_class
from qdot.grader.serve.errors import NO_PAGE, Refused
from qdot.grader.serve.judge_process import StudentOfClass, TypedAnswers, have_common_arm
from qdot.grader.serve.marking_online import get_judge_pool, load_problem_records, mark_practice, release_if_needed
from qdot.grader.serve.models import Person
from qdot.grader.serve.rates import check_rate
from qdot.grader.serve.scores import make_empty_marks
from qdot.grader.serve.sign_in import for_everybody
from qdot.grader.serve.student_pages import (
    ANSWERS_PER_MINUTE,
    DRAFTS_PER_MINUTE,
    Work,
    describe_part,
    describe_total,
    find_language,
    find_work,
    read_answer_text,
    read_json,
    show_page,
)

SET_COUNT, STATE_SECONDS, NEW_SETS_PER_MINUTE = 100, 24 * 3600, 10
"""How many sets an assignment has, how long answers stay in memory, and how many sets a student may open a minute."""
MAX_SETS_TRIED = 5
"""Number of sets after which qdot stops looking for one without the student's own arms."""


def find_practice(person: Person, key: str, number: int) -> Work:
    """Return a set of an assignment as the work of a student who has no due date and no limits. Raises Refused."""
    work = find_work(person, key)
    if not work.assignment.practice or not 1 <= number <= SET_COUNT:
        raise Refused(404, NO_PAGE)
    open_assignment = replace(work.assignment, roster=(), due_date=None, late_rule=None, attempt_policy=AttemptPolicy())
    practice = Work(person, open_assignment, Student(f"practice:{number}"))
    if _has_own_arm(work, practice):
        raise Refused(409, "These problems have the same arms as yours, so they are not for practice.")
    return practice


def _has_own_arm(work: Work, practice: Work) -> bool:
    """Return whether a set has an arm of the student's own problems, so that practice would reveal right answers."""
    name = f"practice-{work.assignment.notebook_digest_of(work.student.id)}-{work.person.pk}-{practice.student.id}"
    if (cached_result := cache.get(name)) is not None:
        return bool(cached_result)
    check_rate("practice set", work.person.pk, NEW_SETS_PER_MINUTE)
    release_if_needed(work.assignment, work.student.id)
    release_if_needed(practice.assignment, practice.student.id)
    students = (work.student.id, practice.student.id)
    requests = [StudentOfClass(describe_class(practice.assignment), student) for student in students]
    result = get_judge_pool().run(have_common_arm, requests)
    cache.set(name, result, None)
    return result


@require_GET
@for_everybody
def show_practice_page(request: HttpRequest, person: Person, key: str, number: int) -> HttpResponse:
    """Show a set of problems, or redirect to the next set if this one has an arm of the student's own problems."""
    for step in range(MAX_SETS_TRIED):
        candidate_number = (number + step - 1) % SET_COUNT + 1
        try:
            work = find_practice(person, key, candidate_number)
        except Refused as error:
            if error.status != 409 or step == MAX_SETS_TRIED - 1:
                raise
        else:
            return HttpResponseRedirect(f"../{candidate_number}/") if step else show_page(request, work)
    raise Refused(404, NO_PAGE)


@require_GET
@for_everybody
def get_practice(request: HttpRequest, person: Person, key: str, number: int) -> HttpResponse:
    """Return what the page of a set shows, as `student_pages.get_work` does."""
    work = find_practice(person, key, number)
    state, language = _load_state(work), find_language(request)
    return JsonResponse({
        "person": person.pk, "title": work.assignment.title, "student": {"id": work.student.id, "name": ""},
        "now": timezone.now().isoformat(), "due": None, "late_rule": "", "feedback": work.assignment.feedback,
        "closed": "", "takes_notebooks": False, "submissions": [],
        "practice": {"next": f"../{number % SET_COUNT + 1}/", "home": "../../"},
        "problems": load_problem_records(work.student.id, work.assignment, work.student.id, language),
        "answers": state["answers"], "drafts": state["drafts"], **_describe_state(work, state),
    })  # fmt: skip


def _load_state(work: Work) -> dict[str, Any]:
    """Return the answers of a person to a set, their marks, and what is shown of them."""
    state: dict[str, Any] = cache.get(f"practising-{work.person.pk}-{work.assignment.key}", {})
    is_same = state.get("set") == (work.student.id, work.assignment.notebook_digest)
    return state if is_same else {"answers": {}, "drafts": {}, "marks": None, "shown": {}}


def _store_state(work: Work, state: dict[str, Any]) -> None:
    state["set"] = work.student.id, work.assignment.notebook_digest
    cache.set(f"practising-{work.person.pk}-{work.assignment.key}", state, STATE_SECONDS)


def _describe_state(work: Work, state: dict[str, Any]) -> dict[str, Any]:
    """Return what the page shows of the marks."""
    marks = state["marks"] or make_empty_marks(work.assignment, work.student.id)
    result = compute_final_result(work.assignment, work.student, [GradedNotebook("practice", marks=marks)])
    results = {name: describe_part(part, state["shown"].get(name)) for name, part in result.parts.items()}
    return {**describe_total(work, result, []), "results": results}


@require_POST
@for_everybody
def post_practice(request: HttpRequest, person: Person, key: str, number: int) -> HttpResponse:
    """Mark an answer, and return the verdicts, as `student_pages.post_answer` does."""
    content, work = read_json(request), find_practice(person, key, number)
    part, text = read_answer_text(content, work.assignment)
    check_rate("answer", person.pk, ANSWERS_PER_MINUTE)
    state, slot = _load_state(work), part.partition(".")[0]
    finished_problems = {problem.slot: problem for problem in state["marks"].problems} if state["marks"] else {}
    finished_problems.pop(slot, None)
    answers = {**state["answers"], part: text}
    class_of_assignment = describe_class(work.assignment)
    typed_answers = TypedAnswers(class_of_assignment, work.student.id, answers, finished_problems, is_quick=True)
    marked_answers = mark_practice(person, typed_answers)
    shown = {name: value for name, value in state["shown"].items() if name.partition(".")[0] != slot}
    state |= {"answers": answers, "marks": marked_answers.marks, "shown": shown | to_jsonable(marked_answers.shown)}
    state["drafts"].pop(part, None)
    _store_state(work, state)
    return JsonResponse({"submission": 0, "state": "marked", **_describe_state(work, state)})


@require_http_methods(["PUT"])
@for_everybody
def put_practice_draft(request: HttpRequest, person: Person, key: str, number: int) -> HttpResponse:
    """Store a text that isn't submitted yet."""
    content, work = read_json(request), find_practice(person, key, number)
    check_rate("draft", person.pk, DRAFTS_PER_MINUTE)
    part, text = read_answer_text(content, work.assignment, is_draft=True)
    state = _load_state(work)
    state["drafts"][part] = text
    _store_state(work, state)
    return JsonResponse({})
