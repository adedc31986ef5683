"""The views behind the page of the staff: the class, its mistakes, and points set by people."""

import datetime
from typing import Any

from django.db import transaction
from django.db.models import Count, Max, Min
from django.http import HttpRequest, HttpResponse, JsonResponse
from django.utils import timezone
from django.views.decorators.http import require_GET, require_POST

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError, count_noun
from qdot.grader.grading.batch import parse_time
from qdot.grader.grading.overrides import TOTAL_PART, flatten_answer
from qdot.grader.grading.result import PartResult, Result
from qdot.grader.judging.verdict import AWAITS_PERSON
from qdot.grader.marking.marking import format_points, map_max_points, sum_points
from qdot.grader.reports.class_summary import group_wrong_answers
from qdot.grader.reports.feedback_levels import capitalize
from qdot.grader.serve.class_list import (
    count_file_changes,
    describe_class,
    describe_file_error,
    find_student,
    load_class_assignment,
)
from qdot.grader.serve.errors import Refused
from qdot.grader.serve.exchange import make_results_zip
from qdot.grader.serve.html_pages import render_page
from qdot.grader.serve.judge_process import StudentOfClass, make_solutions
from qdot.grader.serve.lti.outbox import find_refused, update_scores
from qdot.grader.serve.marking_online import get_judge_pool
from qdot.grader.serve.models import Classroom, Extension, Person, PointsOverride, StaffAction, Submission
from qdot.grader.serve.regrading import accept_regrading, continue_regrading, count_outdated
from qdot.grader.serve.scores import compute_results
from qdot.grader.serve.sign_in import for_staff
from qdot.grader.serve.student_pages import describe_work, find_language, find_work, read_json
from qdot.grader.serve.submitting import UNSTORABLE, check_part

MAX_COMMENT_CHARACTERS, MAX_ACTIONS_SHOWN = 5_000, 50


def record_action(person: Person, summary: str) -> None:
    """Record what a member of staff has changed."""
    StaffAction.objects.create(classroom=person.classroom, person=person, summary=summary[:500])


def make_page_version(classroom: Classroom, key: str) -> str:
    """Return a text that changes whenever the page of the class has something new to show."""
    submissions = Submission.objects.filter(person__classroom=classroom, assignment=key)
    counts = submissions.aggregate(last=Max("pk"), marked=Count("marks"))
    refused = find_refused(classroom, key).count()
    last_action = StaffAction.objects.filter(classroom=classroom).aggregate(last=Max("pk"))["last"]
    return f"{counts['last'] or 0}.{counts['marked']}.{last_action or 0}.{refused}.{count_file_changes()}"


@require_GET
@for_staff
def show_class_page(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Show the page of the class."""
    assignment = load_class_assignment(person.classroom, key)
    return render_page(request, "serve/class.html.j2", title=assignment.title, key=key, person=person)


@require_GET
@for_staff
def get_results(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Return the results of the class; status 204 if they haven't changed since the version `since`."""
    assignment = load_class_assignment(person.classroom, key)
    version = make_page_version(person.classroom, key)
    if request.GET.get("since") == version:
        return HttpResponse(status=204)
    results = compute_results(assignment, person.classroom)
    return JsonResponse({"version": version, **describe_class_results(assignment, person.classroom, results)})


def describe_class_results(assignment: Assignment, classroom: Classroom, results: list[Result]) -> dict[str, Any]:
    """Return the results of a class as its page reads them."""
    people = {person.student_id: person for person in classroom.people.all()}
    rows = Submission.objects.filter(person__classroom=classroom, assignment=assignment.key).values("person_id")
    rows = rows.annotate(begun=Min("received"), last=Max("received"))
    spans = {row["person_id"]: (row["begun"], row["last"]) for row in rows}
    own_due_dates = {s.id: assignment.due_date_of(s) for s in assignment.roster if s.due_date is not None}
    students, to_mark = list[dict[str, Any]](), list[dict[str, Any]]()
    for result in results:
        person = people[result.student]
        (begun, last), due = spans.get(person.pk, (None, None)), own_due_dates.get(person.student_id)
        students.append({
            "id": person.pk, "student_id": person.student_id, "name": person.name, "is_late": result.late is not None,
            "begun": _format_time(begun), "last": _format_time(last), "due": _format_time(due),
            "score": result.score if begun else None, "comment": result.override.comment if result.override else "",
            "marks": {name: _describe_mark(part) for name, part in result.parts.items()},
            "notes": "\n".join(map(capitalize, result.staff_notes)) if begun else "",
        })  # fmt: skip
        to_mark += [
            {"student": person.pk, "part": name, "text": part.answer or ""}
            for name, part in result.parts.items()
            if part.points is None and part.reason == AWAITS_PERSON
        ]
    result_by_student = {result.student: result for result in results}
    groups = [
        {
            "group": group.key, "part": group.part, "count": group.count, "mistake": group.mistake,
            "outcome": result_by_student[group.typical_student].parts[group.part].outcome,
            "points": group.override.points if group.override else group.points_range[1],
            "answer": result_by_student[group.typical_student].parts[group.part].answer,
            "students": [people[student].pk for student in group.students],
        }
        for group in group_wrong_answers(results)
    ]  # fmt: skip
    actions = StaffAction.objects.filter(classroom=classroom).select_related("person").order_by("-pk")
    max_points, titles = map_max_points(assignment), assignment.titles_by_part
    text_parts = {f"{slot.name}.{name}" for slot in assignment.slots for name in slot.text_questions}
    return {
        "title": assignment.title, "due": _format_time(assignment.due_date),
        "max_score": sum_points(max_points.values()), "file_error": describe_file_error(assignment.key),
        "parts": [
            {"name": name, "title": titles[name], "max_points": points, "is_text": name in text_parts}
            for name, points in max_points.items()
        ],
        "students": students, "groups": groups, "to_mark": to_mark,
        "refused": [
            {"student": row.person.pk, "error": row.last_error} for row in find_refused(classroom, assignment.key)
        ],
        "outdated": count_outdated(assignment, results),
        "actions": [
            {"made": action.made.isoformat(), "by": _name_person(action.person), "summary": action.summary}
            for action in actions[:MAX_ACTIONS_SHOWN]
        ],
    }  # fmt: skip


def _describe_mark(part: PartResult) -> dict[str, Any]:
    return {
        "outcome": part.outcome, "points": part.points, "mistake": part.mistake or "",
        "is_override": part.override is not None,
    }  # fmt: skip


def _format_time(moment: datetime.datetime | None) -> str | None:
    return None if moment is None else moment.isoformat()


def _name_person(person: Person | None) -> str:
    return "" if person is None else person.name or person.student_id


def find_student_of(staff_member: Person, number: object) -> Person:
    """Return a student of the class of a member of staff. Raises Refused."""
    if isinstance(number, int):
        student = staff_member.classroom.people.filter(pk=number, role=Person.Role.STUDENT).first()
        if student is not None:
            return student
    raise Refused(404, "Your class has no such student.")


@require_GET
@for_staff
def get_student(request: HttpRequest, person: Person, key: str, number: int) -> HttpResponse:
    """Return a student's work, with the solutions and without limits on feedback."""
    student = find_student_of(person, number)
    work = find_work(student, key)
    content = describe_work(work, find_language(request))
    request_for_student = StudentOfClass(describe_class(work.assignment), student.student_id)
    content["solutions"] = get_judge_pool().run(make_solutions, request_for_student)
    return JsonResponse(content)


# --- decisions ---


@require_POST
@for_staff
def post_override(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Set points or a comment for a student's part or total, or for a group of equal wrong answers."""
    content = read_json(request)
    assignment = load_class_assignment(person.classroom, key)
    max_points = map_max_points(assignment)
    max_points[TOTAL_PART] = sum_points(max_points.values())
    part, points, comment = str(content.get("part", "")), content.get("points"), str(content.get("comment", ""))
    group, answer = str(content.get("group") or ""), flatten_answer(str(content.get("answer") or ""))
    if group:
        part = group.partition("/")[0]
    if part != TOTAL_PART:
        check_part(part, assignment)
    is_number = isinstance(points, (int, float)) and not isinstance(points, bool)
    if points is not None and not (is_number and 0 <= points <= max_points[part]):
        raise Refused(400, f"Enter points from 0 to {max_points[part]:g}.")
    if len(comment) > MAX_COMMENT_CHARACTERS:
        raise Refused(400, f"A comment has at most {MAX_COMMENT_CHARACTERS:,} characters.")
    if UNSTORABLE.search(comment + answer):
        raise Refused(400, "This comment contains characters that can't be stored.")
    student = None if group else find_student_of(person, content.get("student"))
    affected = [student] if student is not None else _find_people_of_group(person.classroom, assignment, group)
    if not affected:
        raise Refused(404, "There is no such group of equal answers.")
    target = assignment.titles_by_part[part] if part else "the total"
    subject = f"the group {group}" if student is None else f"{target} of {_name_person(student)}"
    with transaction.atomic():
        rows = PointsOverride.objects.filter(
            classroom=person.classroom, assignment=key, person=student, group=group, part=part, answer=answer
        )
        was_set = rows.delete()[0] > 0
        if points is None and not comment and not was_set:
            return JsonResponse({})
        if points is not None or comment:
            rounded_points = None if points is None else round(float(points), 4)
            PointsOverride.objects.create(
                classroom=person.classroom, assignment=key, person=student, group=group, part=part, answer=answer,
                points=rounded_points, comment=comment, made_by=person,
            )  # fmt: skip
            changes = [] if rounded_points is None else [f"points: {format_points(rounded_points)}"]
            change = ", ".join([*changes, *([f"comment “{comment}”"] if comment else [])])
        else:
            change = "points and comment removed"
        record_action(person, f"{subject}: {change}")
        for affected_student in affected:
            update_scores(affected_student, key)
    return JsonResponse({})


def _find_people_of_group(classroom: Classroom, assignment: Assignment, group: str) -> list[Person]:
    """Return the students with an answer in a group of equal wrong answers."""
    results = compute_results(assignment, classroom)
    members = [result.student for result in results if any(part.group == group for part in result.parts.values())]
    return list(classroom.people.filter(student_id__in=members))


@require_POST
@for_staff
def post_extension(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Set the due date of one student, or remove the student's extension."""
    content = read_json(request)
    assignment = load_class_assignment(person.classroom, key)
    student, due = find_student_of(person, content.get("student")), content.get("due")
    if due is not None and assignment.due_date is None:
        raise Refused(409, "This assignment has no due date; add `due` to assignment.toml first.")
    due_date = None if due is None else read_due_date(due)
    with transaction.atomic():
        removed, _ = Extension.objects.filter(person=student, assignment=key).delete()
        if due_date is None and not removed and find_student(assignment, student).due_date:
            raise Refused(409, "This extension is in roster.csv; change it there.")
        if due_date is not None:
            Extension.objects.create(person=student, assignment=key, due=due_date)
        summary = f"due {due_date:%Y-%m-%d %H:%M}" if due_date else "due date of the class"
        record_action(person, f"{_name_person(student)}: {summary}")
        update_scores(student, key)
    return JsonResponse({})


def read_due_date(text: object) -> datetime.datetime:
    """Parse a due date. Raises Refused, also for an implausible year."""
    try:
        due_date = parse_time(str(text))
    except QdotError:
        due_date = None
    if due_date is None or not 2000 <= due_date.year < 2200:
        raise Refused(400, "qdot couldn't read this date; write it as in 2027-01-15T23:59:00+01:00.")
    return due_date


@require_POST
@for_staff
def post_regrade(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Mark outdated submissions again, and return the changed marks. With the token of these changes, accept them."""
    content, assignment = read_json(request), load_class_assignment(person.classroom, key)
    if error := describe_file_error(key):
        raise Refused(409, error)
    if "token" not in content:
        return JsonResponse(continue_regrading(assignment, person.classroom)._asdict())
    count = accept_regrading(assignment, person.classroom, str(content["token"]))
    record_action(person, f"{count_noun(count, 'submission')} marked again")
    return JsonResponse({})


@require_POST
@for_staff
def resend_refused_scores(_: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Resend the scores that the platform has refused."""
    load_class_assignment(person.classroom, key)
    with transaction.atomic():
        count = find_refused(person.classroom, key).update(next_try=timezone.now(), tries=0, last_error="")
        record_action(person, f"{count_noun(count, 'refused score')} sent again")
    return JsonResponse({})


@require_GET
@for_staff
def get_export(request: HttpRequest, person: Person, key: str) -> HttpResponse:
    """Return the tables that `qdot grade` writes."""
    headers = {"Content-Disposition": f'attachment; filename="{key}.zip"'}
    return HttpResponse(make_results_zip(person.classroom, key), "application/zip", headers=headers)
