"""Store what a student submits, before the request is answered. A request that arrives twice is stored once."""

import re
import uuid
from collections import defaultdict
from datetime import datetime
from pathlib import PurePath
from typing import NamedTuple

from django.db import transaction
from django.db.models import Sum
from django.db.models.functions import Length
from django.utils import timezone

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.assignment.late_rule import add_time_zone
from qdot.exercises.common.errors import count_noun, make_name_error, shorten
from qdot.grader.judging.functions import is_function_table
from qdot.grader.marking.marking import map_max_points
from qdot.grader.serve.errors import Refused
from qdot.grader.serve.models import Draft, Person, Submission
from qdot.grader.serve.scores import list_notebook_answers, list_submissions
from qdot.grader.submissions.submission import explain_refused_upload

MAX_ANSWER_CHARACTERS = 20_000
UNSTORABLE = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff]")
"""Characters that not every database can store, and that no text needs."""
MAX_NOTEBOOK_BYTES, MAX_STORED_BYTES = 20_000_000, 200_000_000
"""The maximum size of a notebook, and of all notebooks of a student together."""
MAX_WAITING, MAX_SUBMISSIONS = 5, 1_000
"""Maximum number of a student's submissions that wait to be marked, and of all submissions to one assignment."""
NOTEBOOK_ENDINGS = (".ipynb", ".zip", ".py", ".md", ".txt", ".json", ".tar", ".tgz", ".gz")


class AttemptsState(NamedTuple):
    """The number of attempts that are left (None for no limit), and the rule in words ("" for no limit).

    `tries` is the maximum number of answers to each question; None for no limit.
    """

    left: int | None
    rule: str
    tries: int | None = None


def describe_attempts(assignment: Assignment, received: list[datetime]) -> AttemptsState:
    """Return how many attempts are left for a student who has submitted at these times."""
    policy, rules, left = assignment.attempt_policy, list[str](), None
    if policy.best_of is not None:
        left = policy.best_of - (len(policy.group_attempts(received)) if received else 0)
        rules.append(f"The best of your attempts counts: {policy.rule}.")
    if policy.tries is not None:
        answers = count_noun(policy.tries, "answer")
        rules.append(f"Each question takes {answers}; answers that qdot can't read don't count.")
    return AttemptsState(left, " ".join(rules), policy.tries)


def explain_closed(assignment: Assignment, student: Student, received: list[datetime], now: datetime) -> str:
    """Return a sentence that says why nothing more can be submitted; "" if it can."""
    due_date, rule, policy = assignment.due_date_of(student), assignment.late_rule, assignment.attempt_policy
    if due_date and assignment.due_date and rule is not None and rule.until is not None:
        extension = due_date - add_time_zone(assignment.due_date)
        if now > rule.until + extension:
            return "The time for submitting is over."
    if policy.best_of is not None and now not in received:  # in the same second, it would be the same attempt
        times = [*received, now]
        if len(times) - 1 not in {i for attempt in policy.group_attempts(times) for i in attempt}:
            return f"You have used {count_noun(policy.best_of, 'attempt')}; no further attempt counts."
    return ""


def find_tried_texts(person: Person, key: str) -> dict[str, set[str]]:
    """Map each part to the answers that count as tries, because they were judged or will be."""
    tried_texts = defaultdict[str, set[str]](set)
    rows = Submission.objects.filter(person=person, assignment=key).exclude(changed_part="")
    for part, answers, state, shown in rows.values_list("changed_part", "answers", "state", "shown"):
        shown_part = (shown or {}).get(part)
        if state == Submission.State.WAITING or (shown_part and shown_part.get("costs_try", True)):
            tried_texts[part].add((answers or {}).get(part, ""))
    return tried_texts


def check_part(part: str, assignment: Assignment) -> None:
    """Raise Refused if an assignment has no part with a name such as "p1.jacobian"."""
    names = list(map_max_points(assignment))
    if part not in names:
        message = str(make_name_error("question", shorten(part, 50), names))
        raise Refused(404, f"{message[0].upper()}{message[1:]}.")


def check_text(part: str, text: object, assignment: Assignment) -> str:
    """Check the text of an answer, and return it as it is stored. Raises Refused."""
    check_part(part, assignment)
    if not isinstance(text, str):
        raise Refused(400, "An answer must be a text.")
    if len(text) > MAX_ANSWER_CHARACTERS:
        raise Refused(413, f"An answer has at most {MAX_ANSWER_CHARACTERS:,} characters.")
    if UNSTORABLE.search(text) or is_function_table(text):
        raise Refused(400, "This answer contains characters that can't be in an answer.")
    return text.strip()


def parse_request_id(text: object) -> uuid.UUID:
    """Parse the identifier that the browser has chosen for a request. Raises Refused."""
    try:
        return uuid.UUID(str(text))
    except ValueError:
        raise Refused(400, "This request has no number; load the page again.") from None


def submit_answer(
    assignment: Assignment, student: Student, person: Person, request_id: uuid.UUID, answers: dict[str, str]
) -> tuple[Submission, bool]:
    """Store an answer together with all earlier ones, and return the row and whether it is new. Raises Refused.

    `answers` has only the part that is submitted.
    """
    with transaction.atomic():
        Person.objects.select_for_update().get(pk=person.pk)  # a lock: one submission after the other
        if (stored_submission := person.submissions.filter(request_id=request_id).first()) is not None:
            return stored_submission, False
        earlier_submissions = list_submissions(person, assignment.key)
        _check_open(assignment, student, earlier_submissions)
        latest = earlier_submissions[0] if earlier_submissions else None
        if latest is not None and not latest.changed_part and latest.state == Submission.State.WAITING:
            raise Refused(409, "Your notebook is still being graded. Submit your answer again after that.")
        all_answers = {part: text for part, text in {**find_answers(earlier_submissions), **answers}.items() if text}
        ((part, text),) = answers.items()
        if (tries := assignment.attempt_policy.tries) is not None:
            tried_texts = find_tried_texts(person, assignment.key)[part]
            if text not in tried_texts and len(tried_texts) >= tries:
                raise Refused(409, f"You have used all tries of this question ({tries}).")
        submission = Submission.objects.create(
            person=person, assignment=assignment.key, request_id=request_id, answers=all_answers, changed_part=part
        )
        Draft.objects.filter(person=person, assignment=assignment.key, part=part).delete()
    return submission, True


def _check_open(assignment: Assignment, student: Student, earlier_submissions: list[Submission]) -> None:
    """Raise Refused if nothing more can be submitted, or not now."""
    if sum(submission.state == Submission.State.WAITING for submission in earlier_submissions) >= MAX_WAITING:
        raise Refused(429, "Some of what you submitted is still being graded. Try again after that.")
    if len(earlier_submissions) >= MAX_SUBMISSIONS:
        raise Refused(409, f"You have submitted {MAX_SUBMISSIONS:,} times; qdot accepts no more.")
    now, received = timezone.now().replace(microsecond=0), [submission.received for submission in earlier_submissions]
    if sentence := explain_closed(assignment, student, received, now):
        raise Refused(409, sentence)


def find_answers(submissions: list[Submission]) -> dict[str, str]:
    """Map each part to the student's current answer; `submissions` begin with the newest.

    The answers are those of the latest submission, except for notebooks that are not graded or could not be graded.
    """
    latest = next((s for s in submissions if s.changed_part or (s.state == s.State.MARKED and not s.obstacle)), None)
    if latest is None:
        return {}
    return dict(latest.answers) if latest.answers is not None else list_notebook_answers(latest)


def submit_notebook(
    assignment: Assignment, student: Student, person: Person, request_id: uuid.UUID, name: str, content: bytes
) -> Submission:
    """Store a notebook and put it into the queue, both or neither. Raises Refused."""
    from qdot.grader.serve.marking_online import grade_submission, read_upload

    if len(content) > MAX_NOTEBOOK_BYTES:
        raise Refused(413, f"A notebook has at most {MAX_NOTEBOOK_BYTES // 1_000_000} MB; clear its outputs.")
    if PurePath(name).suffix.lower() not in NOTEBOOK_ENDINGS:
        raise Refused(415, "Submit the notebook itself, a file that ends in .ipynb, or a zip that contains it.")
    if assignment.attempt_policy.tries is not None:
        raise Refused(409, "Type your answers on the page: the number of tries is limited, so no notebook is accepted.")
    if reason := explain_refused_upload(read_upload(person, assignment, name, content), assignment, student.id):
        raise Refused(415, f"This file was not submitted: {reason}. Nothing has changed.")
    with transaction.atomic():
        Person.objects.select_for_update().get(pk=person.pk)
        if (stored_submission := person.submissions.filter(request_id=request_id).first()) is not None:
            return stored_submission
        _check_open(assignment, student, list_submissions(person, assignment.key))
        stored_bytes = person.submissions.aggregate(size=Sum(Length("content")))["size"] or 0
        if stored_bytes + len(content) > MAX_STORED_BYTES:
            size = f"{MAX_STORED_BYTES // 1_000_000} MB"
            raise Refused(413, f"Your notebooks have more than {size}; clear their outputs.")
        submission = Submission.objects.create(
            person=person, assignment=assignment.key, request_id=request_id, file_name=name[-255:], content=content
        )
        grade_submission.enqueue(submission.pk)
    return submission


def save_draft(person: Person, key: str, part: str, text: str) -> None:
    """Store a text that a student has typed but not submitted."""
    values = {"text": text, "saved": timezone.now()}
    Draft.objects.update_or_create(person=person, assignment=key, part=part, defaults=values)
