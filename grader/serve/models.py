"""The tables of `qdot serve`. Times have a time zone; points are on the scale of the assignment.

A class is one course of a learning platform, or the roster of the folder if students use personal links. Nobody can see
another class. Each submission is a row of `Submission`. Only its marks ever change, when they are computed again.
"""

import datetime
import secrets
import uuid
from typing import Any

from django.db import models
from django.utils import timezone


def get_current_second() -> datetime.datetime:
    """Return the current time in whole seconds."""
    return timezone.now().replace(microsecond=0)


class Classroom(models.Model):
    """The people of one course. `lti_context` is the course on its learning platform; None for personal links.

    A course that isn't connected may not use the service. The first course of a platform is connected when a teacher
    opens the tool there; connect further courses on the command line. `list_due` is the time at which qdot next reads
    the class list from the platform.
    """

    title = models.CharField(max_length=500, blank=True)
    lti_context = models.OneToOneField("lti_tool.LtiContext", null=True, blank=True, on_delete=models.CASCADE)
    is_connected = models.BooleanField(default=False)
    list_due = models.DateTimeField(default=timezone.now)

    def __str__(self) -> str:
        return self.title or "the roster of the folder"


class Person(models.Model):
    """A student or a member of staff in one class.

    `student_id` names the student in the assignment: with the secret it determines the problems. `link_digest` is the
    SHA-256 of the token in the personal link; the token itself is not stored. `session_version` is raised to sign the
    person out everywhere.
    """

    class Role(models.TextChoices):
        STUDENT = "student"
        STAFF = "staff"

    classroom = models.ForeignKey(Classroom, on_delete=models.CASCADE, related_name="people")
    role = models.CharField(max_length=7, choices=Role.choices)
    student_id = models.CharField(max_length=100)
    name = models.CharField(max_length=500, blank=True)
    email = models.CharField(max_length=320, blank=True)
    lti_user = models.ForeignKey("lti_tool.LtiUser", null=True, blank=True, on_delete=models.SET_NULL)
    link_digest = models.CharField(max_length=64, null=True, blank=True, unique=True)
    session_version = models.PositiveIntegerField(default=1)
    is_active = models.BooleanField(default=True)

    class Meta:
        constraints = [
            models.UniqueConstraint(fields=["classroom", "student_id"], name="one_person_per_student_id"),
            models.UniqueConstraint(fields=["classroom", "lti_user"], name="one_person_per_lti_user"),
        ]

    def __str__(self) -> str:
        return self.student_id


class Extension(models.Model):
    """The due date of one student for one assignment, instead of the assignment's."""

    person = models.ForeignKey(Person, on_delete=models.CASCADE, related_name="extensions")
    assignment = models.CharField(max_length=100)
    due = models.DateTimeField()

    class Meta:
        constraints = [models.UniqueConstraint(fields=["person", "assignment"], name="one_due_date_per_student")]


class Submission(models.Model):
    """What a student submitted with one press of a button: one typed answer, or a notebook.

    The browser chooses `request_id`, so that a request that arrives twice is stored once. For typed answers, `answers`
    maps the names of parts, such as "p1.jacobian", to *all* of the student's answers so far, because each submission
    has all of the student's work, as a notebook does. `changed_part` is the part that was submitted.

    `marks` is a NotebookMarks (grader/grading/result.py) as JSON. `shown` maps each part to what the student sees of
    its marks (`judge_process.ShownPart`). Both are None until the work is marked. `remarked` has new marks until the
    staff accepts them; it is {} while the work is being marked again. `points` is the sum of the marks before late
    penalties. `obstacle` is the reason why the work couldn't be graded. `received` is in whole seconds, like the time
    of a file that `qdot grade` reads.
    """

    class State(models.TextChoices):
        WAITING = "waiting"
        MARKED = "marked"

    person = models.ForeignKey(Person, on_delete=models.CASCADE, related_name="submissions")
    assignment = models.CharField(max_length=100)
    request_id = models.UUIDField(default=uuid.uuid4)
    received = models.DateTimeField(default=get_current_second)
    answers = models.JSONField(null=True)
    changed_part = models.CharField(max_length=200, blank=True)
    file_name = models.CharField(max_length=255, blank=True)
    content = models.BinaryField(null=True)
    state = models.CharField(max_length=7, choices=State.choices, default=State.WAITING)
    marks = models.JSONField(null=True)
    shown = models.JSONField(null=True)
    remarked = models.JSONField(null=True)
    points = models.FloatField(null=True)
    obstacle = models.CharField(max_length=500, blank=True)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["person", "request_id"], name="one_row_per_request")]
        indexes = [models.Index(fields=["person", "assignment", "received"])]
        ordering = ["received", "id"]

    def set_marks(self, marks: dict[str, Any], shown: dict[str, Any]) -> None:
        """Store the marks, and what the student and the staff see of them."""
        all_points = [part["points"] for problem in marks["problems"] for part in problem["parts"]]
        self.marks, self.shown, self.remarked, self.state = marks, shown, None, self.State.MARKED
        self.points = None if None in all_points else round(sum(all_points), 4)
        self.obstacle = (marks["obstacle"] or "")[:500]
        self.save(update_fields=["marks", "shown", "remarked", "state", "points", "obstacle"])


class Draft(models.Model):
    """A text that a student typed but has not submitted; it also appears on the student's other machines."""

    person = models.ForeignKey(Person, on_delete=models.CASCADE, related_name="drafts")
    assignment = models.CharField(max_length=100)
    part = models.CharField(max_length=200)
    text = models.TextField()
    saved = models.DateTimeField(default=timezone.now)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["person", "assignment", "part"], name="one_draft_per_part")]


class PointsOverride(models.Model):
    """A line of overrides.csv: points or a comment for one student's part or total, or for a group of equal answers.

    Either `person` or `group` is set. `answer` is the answer that a person marked by hand, as in overrides.csv.
    """

    classroom = models.ForeignKey(Classroom, on_delete=models.CASCADE, related_name="overrides")
    assignment = models.CharField(max_length=100)
    person = models.ForeignKey(Person, null=True, blank=True, on_delete=models.CASCADE, related_name="overrides")
    group = models.CharField(max_length=210, blank=True)
    part = models.CharField(max_length=200)
    points = models.FloatField(null=True)
    comment = models.TextField(blank=True)
    answer = models.TextField(blank=True)
    made_by = models.ForeignKey(Person, null=True, on_delete=models.SET_NULL, related_name="+")
    made = models.DateTimeField(default=timezone.now)

    class Meta:
        constraints = [
            models.UniqueConstraint(
                fields=["classroom", "assignment", "person", "group", "part", "answer"], name="one_override_per_target"
            ),
        ]


class ScoreDelivery(models.Model):
    """The score that a platform's gradebook should show for a student, with one row per student and column.

    A row is stored together with the marks, and qdot sends it until the platform confirms it. `next_try` is None once
    the platform has confirmed or refused the score; `last_error` has the reason for a refusal. `timestamp` increases
    by a second or more with each change, because platforms refuse a score that isn't newer than theirs, and some of
    them compare whole seconds.
    """

    person = models.ForeignKey(Person, on_delete=models.CASCADE, related_name="deliveries")
    line_item = models.ForeignKey("lti_tool.LtiLineItem", on_delete=models.CASCADE)
    score = models.FloatField(null=True)
    max_score = models.FloatField(default=0)
    timestamp = models.DateTimeField(default=timezone.now)
    next_try = models.DateTimeField(null=True, db_index=True)
    tries = models.PositiveIntegerField(default=0)
    sent = models.DateTimeField(null=True)
    last_error = models.CharField(max_length=300, blank=True)

    class Meta:
        constraints = [models.UniqueConstraint(fields=["person", "line_item"], name="one_delivery_per_column")]


class StaffAction(models.Model):
    """A change by a member of staff, as the class page lists it."""

    classroom = models.ForeignKey(Classroom, on_delete=models.CASCADE, related_name="actions")
    person = models.ForeignKey(Person, null=True, on_delete=models.SET_NULL)
    made = models.DateTimeField(default=timezone.now)
    summary = models.CharField(max_length=500)


def make_link_token() -> str:
    """Return a new token of a personal link: 192 random bits."""
    return secrets.token_urlsafe(24)
