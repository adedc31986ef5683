"""Make all tables."""

import uuid

from django.db import migrations, models
from django.db.models import CASCADE, SET_NULL
from django.utils import timezone

from qdot.grader.serve.models import get_current_second

ID = ("id", models.BigAutoField(auto_created=True, primary_key=True, serialize=False, verbose_name="ID"))
"""The first column of every table."""

UNIQUE = {
    "one_person_per_student_id": ("person", "classroom", "student_id"),
    "one_person_per_lti_user": ("person", "classroom", "lti_user"),
    "one_due_date_per_student": ("extension", "person", "assignment"),
    "one_draft_per_part": ("draft", "person", "assignment", "part"),
    "one_override_per_target": ("pointsoverride", "classroom", "assignment", "person", "group", "part", "answer"),
    "one_delivery_per_column": ("scoredelivery", "person", "line_item"),
    "one_row_per_request": ("submission", "person", "request_id"),
}
"""The constraints: a table, and the columns that no two rows have in common."""


class Migration(migrations.Migration):
    initial = True

    dependencies = [
        ("lti_tool", "0008_ltideployment_pns_url_and_more"),
    ]

    operations = [
        migrations.CreateModel(
            name="Classroom",
            fields=[
                ID,
                ("title", models.CharField(blank=True, max_length=500)),
                ("is_connected", models.BooleanField(default=False)),
                ("list_due", models.DateTimeField(default=timezone.now)),
                (
                    "lti_context",
                    models.OneToOneField(blank=True, null=True, on_delete=CASCADE, to="lti_tool.lticontext"),
                ),
            ],
        ),
        migrations.CreateModel(
            name="Person",
            fields=[
                ID,
                ("role", models.CharField(choices=[("student", "Student"), ("staff", "Staff")], max_length=7)),
                ("student_id", models.CharField(max_length=100)),
                ("name", models.CharField(blank=True, max_length=500)),
                ("email", models.CharField(blank=True, max_length=320)),
                ("link_digest", models.CharField(blank=True, max_length=64, null=True, unique=True)),
                ("session_version", models.PositiveIntegerField(default=1)),
                ("is_active", models.BooleanField(default=True)),
                ("classroom", models.ForeignKey(on_delete=CASCADE, related_name="people", to="serve.classroom")),
                ("lti_user", models.ForeignKey(blank=True, null=True, on_delete=SET_NULL, to="lti_tool.ltiuser")),
            ],
        ),
        migrations.CreateModel(
            name="Extension",
            fields=[
                ID,
                ("assignment", models.CharField(max_length=100)),
                ("due", models.DateTimeField()),
                ("person", models.ForeignKey(on_delete=CASCADE, related_name="extensions", to="serve.person")),
            ],
        ),
        migrations.CreateModel(
            name="Draft",
            fields=[
                ID,
                ("assignment", models.CharField(max_length=100)),
                ("part", models.CharField(max_length=200)),
                ("text", models.TextField()),
                ("saved", models.DateTimeField(default=timezone.now)),
                ("person", models.ForeignKey(on_delete=CASCADE, related_name="drafts", to="serve.person")),
            ],
        ),
        migrations.CreateModel(
            name="PointsOverride",
            fields=[
                ID,
                ("assignment", models.CharField(max_length=100)),
                ("group", models.CharField(blank=True, max_length=210)),
                ("part", models.CharField(max_length=200)),
                ("points", models.FloatField(null=True)),
                ("comment", models.TextField(blank=True)),
                ("answer", models.TextField(blank=True)),
                ("made", models.DateTimeField(default=timezone.now)),
                ("classroom", models.ForeignKey(on_delete=CASCADE, related_name="overrides", to="serve.classroom")),
                ("made_by", models.ForeignKey(null=True, on_delete=SET_NULL, related_name="+", to="serve.person")),
                (
                    "person",
                    models.ForeignKey(
                        blank=True, null=True, on_delete=CASCADE, related_name="overrides", to="serve.person"
                    ),
                ),
            ],
        ),
        migrations.CreateModel(
            name="ScoreDelivery",
            fields=[
                ID,
                ("score", models.FloatField(null=True)),
                ("max_score", models.FloatField(default=0)),
                ("timestamp", models.DateTimeField(default=timezone.now)),
                ("next_try", models.DateTimeField(db_index=True, null=True)),
                ("tries", models.PositiveIntegerField(default=0)),
                ("sent", models.DateTimeField(null=True)),
                ("last_error", models.CharField(blank=True, max_length=300)),
                ("line_item", models.ForeignKey(on_delete=CASCADE, to="lti_tool.ltilineitem")),
                ("person", models.ForeignKey(on_delete=CASCADE, related_name="deliveries", to="serve.person")),
            ],
        ),
        migrations.CreateModel(
            name="StaffAction",
            fields=[
                ID,
                ("made", models.DateTimeField(default=timezone.now)),
                ("summary", models.CharField(max_length=500)),
                ("classroom", models.ForeignKey(on_delete=CASCADE, related_name="actions", to="serve.classroom")),
                ("person", models.ForeignKey(null=True, on_delete=SET_NULL, to="serve.person")),
            ],
        ),
        migrations.CreateModel(
            name="Submission",
            fields=[
                ID,
                ("assignment", models.CharField(max_length=100)),
                ("request_id", models.UUIDField(default=uuid.uuid4)),
                ("received", models.DateTimeField(default=get_current_second)),
                ("answers", models.JSONField(null=True)),
                ("changed_part", models.CharField(blank=True, max_length=200)),
                ("file_name", models.CharField(blank=True, max_length=255)),
                ("content", models.BinaryField(null=True)),
                (
                    "state",
                    models.CharField(
                        choices=[("waiting", "Waiting"), ("marked", "Marked")], default="waiting", max_length=7
                    ),
                ),
                ("marks", models.JSONField(null=True)),
                ("shown", models.JSONField(null=True)),
                ("remarked", models.JSONField(null=True)),
                ("points", models.FloatField(null=True)),
                ("obstacle", models.CharField(blank=True, max_length=500)),
                ("person", models.ForeignKey(on_delete=CASCADE, related_name="submissions", to="serve.person")),
            ],
            options={
                "ordering": ["received", "id"],
            },
        ),
        migrations.AddIndex(
            model_name="submission",
            index=models.Index(fields=["person", "assignment", "received"], name="serve_submi_person__5841f2_idx"),
        ),
        *(
            migrations.AddConstraint(table, models.UniqueConstraint(fields=fields, name=name))
            for name, (table, *fields) in UNIQUE.items()
        ),
    ]
