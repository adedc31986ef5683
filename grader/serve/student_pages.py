"""The views behind a student's page."""

import datetime
import json
from pathlib import Path
from typing import Any, NamedTuple

from django.core.exceptions import BadRequest
from django.http import HttpRequest, HttpResponse, HttpResponseRedirect, JsonResponse
from django.middleware.csrf import get_token
from django.utils import timezone
from django.views.decorators.http import require_GET, require_http_methods, require_POST

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.late_rule import describe_duration
from qdot.exercises.assignment.release import make_notebook_path
from qdot.exercises.notebook.notebook import fill_in_answers
from qdot.exercises.writing.languages import ENGLISH, LANGUAGES
from qdot.grader.grading.result import Result
from qdot.grader.reports.feedback import make_feedback_page
from qdot.grader.reports.feedback_levels import capitalize
from qdot.grader.reports.part_rows import describe_decisions
from qdot.grader.serve.class_list import find_student, load_assignments, load_class_assignment
from qdot.grader.serve.errors import NO_PAGE, TOO_LARGE, Refused
from qdot.grader.serve.html_pages import render_page
from qdot.grader.serve.judge_process import end_sentence, limit_open_feedback
from qdot.grader.serve.marking_online import (
    count_waiting_before,
    load_problem_records,
    mark_answers,
    release_if_needed,
)
from qdot.grader.serve.models import Draft, Person, Submission
from qdot.grader.serve.rates import check_rate
from qdot.grader.serve.scores import compute_result, list_submissions, load_overrides, load_result
from qdot.grader.serve.sign_in import SIGN_IN_ADVICE, find_person, for_everybody
from qdot.grader.serve.submitting import (
    check_text,
    describe_attempts,
    explain_closed,
    find_answers,
    find_tried_texts,
    parse_request_id,
    save_draft,
    submit_answer,
    submit_notebook,
)

ANSWERS_PER_MINUTE, DRAFTS_PER_MINUTE, NOTEBOOKS_PER_MINUTE, READS_PER_MINUTE = 40, 90, 6, 240
MAX_JSON_BYTES = 200_000


class Work(NamedTuple):
    """The person, the assignment and the student that a request is about."""

    person: Person
    assignment: Assignment
    student: Student


def find_work(person: Person, key: str) -> Work:
    """Return a person's work on an assignment. Raises Refused, also if it is requested too often."""
    check_rate("read", person.pk, READS_PER_MINUTE)
    assignment = load_class_assignment(person.classroom, key)
    if person.role == Person.Role.STAFF:  # staff see the page of an invented student, with problems of their own
        student = Student(person.student_id, person.name or person.student_id)
        return Work(person, assignment, student)
    return Work(person, assignment, find_student(assignment, person))


def read_json(request: HttpRequest) -> dict[str, Any]:
    """Return the object in the body of a request. Raises BadRequest, or Refused if it is too large."""
    if len(request.body) > MAX_JSON_BYTES:
        raise Refused(413, TOO_LARGE)
    try:
        content = json.loads(request.body)
    except (ValueError, RecursionError):
        raise BadRequest from None
    if not isinstance(content, dict):
        raise BadRequest
    return content


# --- pages ---


@require_GET
def show_home(request: HttpRequest) -> HttpResponse:
    """Show the assignments of the person who is signed in, or open the only one. Tell others how to sign in."""
    try:
        person = find_person(request)
    except Refused:
        return render_page(request, "serve/home.html.j2", title="qdot", advice=SIGN_IN_ADVICE, assignments=[])
    is_staff = person.role == Person.Role.STAFF
    assignments = [
        {"key": key, "title": assignment.title, "is_staff": is_staff}
        for key, assignment in load_assignments().items()
        if is_staff or person.classroom.lti_context_id or person.student_id in {s.id for s in assignment.roster}
    ]
    if len(assignments) == 1:
        get_token(request)
        return HttpResponseRedirect(f"/a/{assignments[0]['key']}/{'class/' if is_staff else ''}")
    return render_page(request, "serve/home.html.j2", title="qdot", advice="", assignments=assignments)


@require_GET
@for_everybody
def show_work_page(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Show the student's page."""
    return show_page(request, find_work(person, key))


def show_page(request: HttpRequest, work: Work) -> HttpResponse:
    """Return the page on which a student works."""
    title, key = work.assignment.title, work.assignment.key
    return render_page(request, "serve/student.html.j2", title=title, key=key, person=work.person)


# --- JSON ---


@require_GET
@for_everybody
def get_work(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Return everything that the student's page shows."""
    get_token(request)
    return JsonResponse(describe_work(find_work(person, key), find_language(request)))


def find_language(request: HttpRequest) -> str:
    """Return the language in which the page wants the problems."""
    language = request.GET.get("lang", ENGLISH)
    return language if language in LANGUAGES else ENGLISH


def describe_work(work: Work, language: str) -> dict[str, Any]:
    """Return a student's work as the page reads it."""
    person, assignment, student = work
    submissions = list_submissions(person, assignment.key)
    overrides = load_overrides(person.classroom, assignment.key)
    result = compute_result(assignment, student, submissions, overrides)
    received, now, due_date = [s.received for s in submissions], timezone.now(), assignment.due_date_of(student)
    rule = assignment.late_rule
    late_sentence = ""
    if rule is not None and rule.per_day:
        late_sentence = f"Late work loses {100 * float(rule.per_day):.4g} % of its points for each day or part of a day"
        late_sentence += f", after a grace period of {describe_duration(rule.grace)}." if rule.grace else "."
    drafts = Draft.objects.filter(person=person, assignment=assignment.key)
    return {
        "person": person.pk, "title": assignment.title, "student": {"id": student.id, "name": student.name},
        "now": now.isoformat(), "due": due_date and due_date.isoformat(),
        "late_rule": late_sentence, "feedback": assignment.feedback,
        "takes_notebooks": assignment.attempt_policy.tries is None,
        "practice": {"next": "practice/1/", "home": ""} if assignment.practice else None,
        "closed": explain_closed(assignment, student, received, now.replace(microsecond=0)),
        "problems": load_problem_records(person.pk, assignment, person.student_id, language),
        "answers": find_answers(submissions), "drafts": dict(drafts.values_list("part", "text")),
        **describe_total(work, result, received), "results": describe_parts(work, result, submissions),
        "submissions": [describe_submission(submission) for submission in submissions],
    }  # fmt: skip


def describe_total(work: Work, result: Result, received: list[datetime.datetime]) -> dict[str, Any]:
    """Return what the page shows of the total; `received` are the times of all submissions."""
    notes = [*describe_decisions(result), *map(capitalize, result.notes)]
    return {
        "notes": list(map(end_sentence, notes)), "is_late": result.late is not None,
        "score": None if result.obstacle and not result.overrides else result.score, "max_score": result.max_score,
        "attempts": describe_attempts(work.assignment, received)._asdict(),
    }  # fmt: skip


def describe_parts(work: Work, result: Result, submissions: list[Submission]) -> dict[str, Any]:
    """Return what the page shows of each part: its marks, and their explanation."""
    counting_time = result.submission.received if result.submission else None
    marked_submissions = (submission for submission in submissions if submission.state == Submission.State.MARKED)
    counting_ids = [s.pk for s in marked_submissions if s.received.isoformat() == counting_time]
    shown = Submission.objects.filter(pk__in=counting_ids[:1]).values_list("shown", flat=True).first() or {}
    tries = work.assignment.attempt_policy.tries
    tries_left = dict[str, int]()
    if tries is not None:
        tried_texts = find_tried_texts(work.person, work.assignment.key)
        tries_left = {name: max(0, tries - len(tried_texts.get(name, ()))) for name in result.parts}
    return {name: describe_part(part, shown.get(name), tries_left.get(name)) for name, part in result.parts.items()}


EMPTY_EXPLANATION: dict[str, Any] = {
    "sentences": [], "entries": None, "counterexample": None, "pose": None, "followed_from": None, "answer": None,
}  # fmt: skip


def describe_part(part: Any, shown: dict[str, Any] | None, tries_left: int | None = None) -> dict[str, Any]:
    """Return the marks of a part with an explanation; `shown` is a `ShownPart` as JSON."""
    return {
        "tries_left": tries_left, "outcome": part.outcome, "points": part.points, "max_points": part.max_points,
        "comment": part.override.comment if part.override else "", **(shown or EMPTY_EXPLANATION),
    }  # fmt: skip


def describe_submission(submission: Submission) -> dict[str, Any]:
    """Return a submission as the list on the page shows it."""
    return {
        "id": submission.pk, "received": submission.received.isoformat(),
        "kind": "answer" if submission.changed_part else "notebook", "part": submission.changed_part,
        "file_name": submission.file_name, "state": submission.state, "place": count_waiting_before(submission),
        "score": None if submission.obstacle else submission.points,
        "note": submission.obstacle and end_sentence(submission.obstacle),
    }  # fmt: skip


@require_POST
@for_everybody
def post_answer(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Store an answer, mark it, and return the verdicts on its problem."""
    content, work = read_json(request), find_work(person, key)
    request_id = parse_request_id(content.get("request"))
    part, text = read_answer_text(content, work.assignment)
    check_rate("answer", person.pk, ANSWERS_PER_MINUTE)
    submission, is_new = submit_answer(work.assignment, work.student, person, request_id, {part: text})
    if is_new:
        mark_answers(submission)
    submissions = list_submissions(person, key)
    result = compute_result(work.assignment, work.student, submissions, load_overrides(person.classroom, key))
    slot = part.partition(".")[0]
    results = describe_parts(work, result, submissions)
    return JsonResponse({
        "submission": submission.pk, "state": submission.state,
        "results": {name: value for name, value in results.items() if name.startswith(f"{slot}.")},
        **describe_total(work, result, [s.received for s in submissions]),
    })  # fmt: skip


def read_answer_text(content: dict[str, Any], assignment: Assignment, *, is_draft: bool = False) -> tuple[str, str]:
    """Return the part and the text in a request; only a draft may be empty. Raises Refused."""
    part = str(content.get("part"))
    text = check_text(part, content.get("text"), assignment)
    if not text and not is_draft:
        raise Refused(400, "Type an answer first.")
    return part, text


@require_http_methods(["PUT"])
@for_everybody
def put_draft(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Store a text that isn't submitted yet."""
    content, work = read_json(request), find_work(person, key)
    check_rate("draft", person.pk, DRAFTS_PER_MINUTE)
    save_draft(person, key, *read_answer_text(content, work.assignment, is_draft=True))
    return JsonResponse({})


@require_POST
@for_everybody
def post_notebook(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Store a notebook, and put it into the queue."""
    work, file = find_work(person, key), request.FILES.get("file")
    request_id = parse_request_id(request.POST.get("request"))
    if file is None or isinstance(file, list):
        raise Refused(400, "Choose a file.")
    check_rate("notebook", person.pk, NOTEBOOKS_PER_MINUTE)
    name, content = Path(file.name or "").name, file.read()
    submission = submit_notebook(work.assignment, work.student, person, request_id, name, content)
    return JsonResponse({"submission": submission.pk, "place": count_waiting_before(submission)}, status=202)


@require_GET
@for_everybody
def get_submission(request: HttpRequest, person: Person, key: str, number: int) -> HttpResponse:
    """Return the progress of grading a submission."""
    work = find_work(person, key)
    submission = person.submissions.filter(assignment=key, pk=number).defer("content").first()
    if submission is None:
        raise Refused(404, NO_PAGE)
    submissions = list_submissions(person, key)
    result = compute_result(work.assignment, work.student, submissions, load_overrides(person.classroom, key))
    return JsonResponse({**describe_submission(submission), "results": describe_parts(work, result, submissions)})


# --- files ---


@require_GET
@for_everybody
def get_notebook(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Return the student's notebook, with the answers that the student has submitted."""
    work = find_work(person, key)
    release_if_needed(work.assignment, work.student.id)
    content = make_notebook_path(work.assignment, work.student.id).read_text(encoding="utf-8")
    content = fill_in_answers(content, find_answers(list_submissions(person, key)))
    return HttpResponse(content, "application/x-ipynb+json", headers={
        "Content-Disposition": f'attachment; filename="{key}.ipynb"',
    })  # fmt: skip


@require_GET
@for_everybody
def get_feedback(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Return the feedback page of `qdot grade`, with correct values only if nothing more can be submitted."""
    work = find_work(person, key)
    received = [submission.received for submission in list_submissions(person, key)]
    is_closed = explain_closed(work.assignment, work.student, received, timezone.now().replace(microsecond=0))
    assignment = work.assignment if is_closed else limit_open_feedback(work.assignment)
    return HttpResponse(make_feedback_page(assignment, work.student, load_result(*work)))
