"""Send scores to the gradebook of the platform until they arrive (Assignment and Grade Services).

The rows of ScoreDelivery are the queue. They say what the gradebook should show, so that a restart can't send an old
score after a newer one, and a score that is sent twice does no harm.
"""

import datetime
import random
from dataclasses import dataclass

from django.db import transaction
from django.db.models import F, Q, QuerySet
from django.utils import timezone
from lti_tool.models import LtiLineItem, LtiRegistration
from pylti1p3.assignments_grades import AssignmentsGradesService
from pylti1p3.exception import LtiServiceException
from pylti1p3.grade import Grade

from qdot.exercises.common.console import escape_controls
from qdot.grader.grading.result import Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.serve.class_list import find_student, load_class_assignment
from qdot.grader.serve.errors import logger
from qdot.grader.serve.lti.connection import PLATFORM_ERRORS, Connections
from qdot.grader.serve.lti.people import read_class_list
from qdot.grader.serve.models import Classroom, Person, ScoreDelivery
from qdot.grader.serve.scores import load_result

SCORE_SCOPE = "https://purl.imsglobal.org/spec/lti-ags/scope/score"
FIRST_WAIT = datetime.timedelta(seconds=10)
LONGEST_WAIT = datetime.timedelta(hours=6)
MAX_REFUSALS = 11
"""Number of tries, within about three hours, after which a score that the platform refuses is left to the staff."""
CLAIM_DURATION = datetime.timedelta(minutes=2)
"""How long other processes must not send a score that a process has begun to send."""
LIST_INTERVAL = datetime.timedelta(days=1)
LIST_RETRY = datetime.timedelta(hours=1)
_UNREACHABLE = "can't be reached"
"""The beginning of `last_error` if the platform is to blame; all of its scores then wait for the next success."""


@dataclass(frozen=True)
class Score:
    """The points that a column of the gradebook shows for a student; `points` is None for an empty cell."""

    points: float | None
    max_points: float


def update_scores(person: Person, key: str) -> None:
    """Note which scores of an assignment the gradebook of the person's course should show.

    Call this in the transaction that changes marks or points. Nothing is noted for people and columns that the platform
    hasn't named, or for people who have left the course. When such a person opens qdot again, the scores are updated.
    """
    if person.lti_user_id is None or person.role != Person.Role.STUDENT or not person.is_active:
        return
    is_for_assignment = Q(resource_id=key) | Q(resource_id__startswith=f"{key}/")
    columns = LtiLineItem.objects.filter(is_for_assignment, context=person.classroom.lti_context_id).order_by("pk")
    with transaction.atomic():
        rows = ScoreDelivery.objects.select_for_update()
        deliveries = [rows.get_or_create(person=person, line_item=column)[0] for column in columns]
        if deliveries:
            assignment = load_class_assignment(person.classroom, key)
            result = load_result(person, assignment, find_student(assignment, person))
        for delivery in deliveries:
            score = _find_score(result, delivery.line_item.resource_id.partition("/")[2])
            has_changed = (score.points, score.max_points) != (delivery.score, delivery.max_score)
            if has_changed and not (score.points is None and delivery.score is None):
                delivery.score, delivery.max_score = score.points, score.max_points
                _advance_timestamp(delivery, timezone.now())
                delivery.tries, delivery.last_error = 0, ""
                delivery.save()


def _find_score(result: Result, part_name: str) -> Score:
    """Return the score for a part, or for the whole assignment if the part is ""."""
    if not part_name:
        is_empty = result.submission is None and not result.overrides
        return Score(None if is_empty else result.score, result.max_score)
    part = result.parts.get(part_name)
    if part is None:
        return Score(points=None, max_points=0)
    if part.override is not None:
        return Score(part.points, part.max_points)
    penalty = result.late.penalty if result.late else 0
    is_empty = part.points is None or part.outcome == Outcome.MISSING
    return Score(None if is_empty else (part.points or 0) * (1 - penalty), part.max_points)


def _advance_timestamp(delivery: ScoreDelivery, now: datetime.datetime) -> None:
    """Give a score a later timestamp than before, and send it as soon as that time has come."""
    was_sent = delivery.sent is not None or delivery.tries > 0 or delivery.next_try is not None
    delivery.timestamp = max(now, delivery.timestamp + datetime.timedelta(seconds=1)) if was_sent else now
    delivery.next_try = delivery.timestamp


def send_scores(connections: Connections, now: datetime.datetime) -> None:
    """Send the scores whose time has come. A platform that can't be reached doesn't delay the others."""
    due_deliveries = ScoreDelivery.objects.filter(
        next_try__lte=now, person__is_active=True, line_item__context__deployment__registration__is_active=True
    )
    related = ("person__lti_user", "line_item__context__deployment__registration")
    unreachable_platforms: set[int] = set()
    for delivery in due_deliveries.select_related(*related).order_by("next_try"):
        platform = delivery.line_item.context.deployment.registration
        if platform.pk in unreachable_platforms:
            continue
        unchanged_delivery = ScoreDelivery.objects.filter(pk=delivery.pk, timestamp=delivery.timestamp)
        if not unchanged_delivery.filter(next_try=delivery.next_try).update(next_try=timezone.now() + CLAIM_DURATION):
            continue  # another process sends it, or the score has changed
        platform_deliveries = ScoreDelivery.objects.filter(line_item__context__deployment__registration=platform)
        try:
            _send(delivery, connections, platform, now)
        except PLATFORM_ERRORS as error:
            deliveries, gives_up = unchanged_delivery, delivery.tries + 1 >= MAX_REFUSALS
            if _is_unreachable(error, platform):
                unreachable_platforms.add(platform.pk)
                deliveries, gives_up = unchanged_delivery | platform_deliveries.filter(next_try__lte=now), False
            _postpone(deliveries, delivery.tries, error, now, gives_up=gives_up)
        else:
            unchanged_delivery.update(next_try=None, sent=timezone.now(), tries=0, last_error="")
            platform_deliveries.filter(last_error__startswith=_UNREACHABLE).update(next_try=now, last_error="")


def _is_unreachable(error: Exception, platform: LtiRegistration) -> bool:
    """Return whether an error concerns all scores: the platform is down, too busy, or gives qdot no access token."""
    if not isinstance(error, LtiServiceException):
        return True
    status, is_about_token = error.response.status_code, error.response.url.startswith(platform.token_url)
    return status >= 500 or status == 429 or is_about_token


def _send(delivery: ScoreDelivery, connections: Connections, platform: LtiRegistration, now: datetime.datetime) -> None:
    """Send a score once; if the platform no longer accepts the access token, once more with a new one."""
    sub = delivery.person.lti_user.sub if delivery.person.lti_user else ""
    grade = Grade().set_user_id(sub).set_timestamp(delivery.timestamp.isoformat())
    if delivery.score is None:
        grade.set_activity_progress("Initialized").set_grading_progress("NotReady")
    else:
        grade.set_score_given(round(delivery.score, 6)).set_score_maximum(delivery.max_score)
        grade.set_activity_progress("Submitted").set_grading_progress("FullyGraded")
    endpoint = {"scope": [SCORE_SCOPE], "lineitem": delivery.line_item.url}
    try:
        AssignmentsGradesService(connections.open(platform, now), endpoint).put_grade(grade)
    except LtiServiceException as error:
        connections.close(platform)
        if error.response.status_code != 401:
            raise
        AssignmentsGradesService(connections.open(platform, now), endpoint).put_grade(grade)


def _postpone(
    deliveries: QuerySet[ScoreDelivery], tries: int, error: Exception, now: datetime.datetime, *, gives_up: bool
) -> None:
    """Try again later; each wait is twice as long as the one before, unless the platform names a time.

    If the platform says that it has a newer score (409), the score gets a new time. If qdot `gives_up`, it sends the
    score only after it has changed, or if the staff asks for it.
    """
    response = error.response if isinstance(error, LtiServiceException) else None
    wait = min(FIRST_WAIT * 2 ** min(tries, 20), LONGEST_WAIT) * random.uniform(1, 1.25)  # noqa: S311 (no secret)
    seconds_text = response.headers.get("Retry-After", "") if response is not None else ""
    if seconds_text.isdecimal():
        wait = min(max(wait, datetime.timedelta(seconds=int(seconds_text[:9]))), LONGEST_WAIT)
    if response is None:
        description = f"{_UNREACHABLE}: {type(error).__name__}: {error}"
    else:
        description = f"{_UNREACHABLE if response.status_code >= 500 else 'refused'}: HTTP {response.status_code}"
    last_error = escape_controls(description)[:300]
    values = {"next_try": None if gives_up else now + wait, "tries": F("tries") + 1, "last_error": last_error}
    if response is not None and response.status_code == 409:
        values["timestamp"] = now + wait
    count = deliveries.update(**values)
    logger.warning("%d scores have not arrived; the platform %s", count, last_error)


def find_refused(classroom: Classroom, key: str) -> QuerySet[ScoreDelivery]:
    """Return the scores for an assignment that are not sent any more, because the platform refuses them."""
    is_for_assignment = Q(line_item__resource_id=key) | Q(line_item__resource_id__startswith=f"{key}/")
    rows = ScoreDelivery.objects.filter(is_for_assignment, person__classroom=classroom, next_try=None)
    return rows.exclude(last_error="").select_related("person")


def read_class_lists(connections: Connections, now: datetime.datetime) -> None:
    """Read the class lists of connected courses whose time has come."""
    due_classrooms = Classroom.objects.filter(is_connected=True, list_due__lte=now, lti_context__isnull=False)
    for classroom in due_classrooms.exclude(lti_context__memberships_url=""):
        wait = LIST_INTERVAL
        try:
            read_class_list(classroom, connections, now)
        except PLATFORM_ERRORS as error:
            wait = LIST_RETRY
            logger.warning("the class list of course %s was not read: %s", classroom.pk, escape_controls(str(error)))
        Classroom.objects.filter(pk=classroom.pk, list_due=classroom.list_due).update(list_due=now + wait)


_connections = Connections()


def process_outbox() -> None:
    """Send the scores and read the class lists whose time has come; called every second."""
    now = timezone.now()
    send_scores(_connections, now)
    read_class_lists(_connections, now)
