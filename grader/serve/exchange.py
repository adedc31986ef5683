"""Write a class as a folder for `qdot grade`, which gives the same marks; read such a folder; back up and restore."""

import io
import os
import shutil
import uuid
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from django.contrib.sessions.models import Session
from django.core.management import call_command
from django.db import connection, transaction

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import make_folder, write_atomically
from qdot.exercises.common.input_file import format_csv
from qdot.grader.grading.attempt import read_attempts
from qdot.grader.grading.overrides import ANSWER_COLUMN, COLUMN_NAMES, GROUP_COLUMN, OVERRIDES_FILE, read_overrides
from qdot.grader.grading.result import Override
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.grades_table import (
    TO_MARK_FILE,
    escape_formula,
    make_grades_csv,
    make_results_jsonl,
    make_to_mark_csv,
)
from qdot.grader.serve.backup_files import DATABASE_MEMBER, FOLDERS_MEMBER, read_member
from qdot.grader.serve.class_list import load_assignments, load_class_assignment
from qdot.grader.serve.judge_process import write_answers_notebook
from qdot.grader.serve.models import Classroom, Person, PointsOverride, Submission
from qdot.grader.serve.scores import compute_results, list_submissions, name_file, select_attempts
from qdot.grader.serve.settings import find_options
from qdot.grader.submissions.submission import find_submissions, open_submissions


def make_roster_csv(assignment: Assignment) -> str:
    """Return roster.csv with the students, each with the due date that applies to the student."""
    rows = [("student", "name", "email", "due")]
    for student in assignment.roster:
        due_date = assignment.due_date_of(student)
        name, email = escape_formula(student.name), escape_formula(student.email)
        rows.append((student.id, name, email, due_date.isoformat() if due_date else ""))
    return format_csv(rows)


def make_overrides_csv(classroom: Classroom, key: str) -> str:
    """Return overrides.csv with the points and comments that people have set."""
    rows = [(*COLUMN_NAMES, GROUP_COLUMN, ANSWER_COLUMN)]
    for row in PointsOverride.objects.filter(classroom=classroom, assignment=key).select_related("person"):
        points = "" if row.points is None else format_points(row.points)
        student = row.person.student_id if row.person else ""
        part = "" if row.group else row.part
        rows.append((student, part, points, row.comment, row.group, escape_formula(row.answer)))
    return format_csv(rows)


def iterate_files(classroom: Classroom, assignment: Assignment) -> Iterator[tuple[str, bytes, datetime]]:
    """Yield the path below submitted/, the content and the time of each file of the class.

    Only the notebooks that decide a student's mark are written, because `qdot grade` reads a limited number.
    """
    people = {person.student_id: person for person in classroom.people.filter(role=Person.Role.STUDENT)}
    for student in assignment.roster:
        attempts, _ = select_attempts(assignment, list_submissions(people[student.id], assignment.key))
        for number, attempt in enumerate(attempts, 1):
            submission = Submission.objects.get(pk=attempt.pk)
            if submission.answers is None:
                content = bytes(submission.content or b"")
            else:
                content = write_answers_notebook(assignment, student.id, submission.answers).encode()
            yield f"{student.id}/{number}/{name_file(assignment, submission)}", content, submission.received


def export_class(classroom: Classroom, key: str, out: Path) -> None:
    """Write a class as a folder of an assignment, with what was submitted. Raises QdotError."""
    assignment = load_class_assignment(classroom, key)
    if out.exists():
        raise QdotError(f"{out} exists already; choose another folder with --out")
    make_folder(out)
    for path in sorted(assignment.folder.iterdir()):
        if path.is_file() and path.name not in ("roster.csv", OVERRIDES_FILE):
            shutil.copy2(path, out / path.name)
    write_atomically(out / "roster.csv", make_roster_csv(assignment))
    write_atomically(out / OVERRIDES_FILE, make_overrides_csv(classroom, key))
    make_folder(out / "submitted")
    for name, content, received in iterate_files(classroom, assignment):
        path = out / "submitted" / name
        make_folder(path.parent)
        write_atomically(path, content, is_synced=False)
        os.utime(path, (received.timestamp(), received.timestamp()))
    load_assignment(out)  # checks that the folder is complete


def make_results_zip(classroom: Classroom, key: str) -> bytes:
    """Return the tables that `qdot grade` writes for a class, and the class's overrides.csv, as a zip."""
    assignment = load_class_assignment(classroom, key)
    results, roster = compute_results(assignment, classroom), assignment.roster
    if any(student.due_date for student in roster):
        roster = tuple(map(_add_due_cell, roster))
    contents: dict[str, str | bytes | None] = {
        "results.jsonl": make_results_jsonl(results), "grades.csv": make_grades_csv(results, roster),
        TO_MARK_FILE: make_to_mark_csv(results), OVERRIDES_FILE: make_overrides_csv(classroom, key),
        "roster.csv": make_roster_csv(assignment),
    }  # fmt: skip
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in contents.items():
            if content is not None:
                archive.writestr(f"{key}/{name}", content)
    return buffer.getvalue()


def _add_due_cell(student: Student) -> Student:
    """Return a student whose column `due` contains the due date that applies to the student."""
    cells = dict(student.other_cells) | {"due": student.due_date.isoformat() if student.due_date else ""}
    return replace(student, other_cells=tuple(cells.items()))


def import_class(classroom: Classroom, key: str, source: Path) -> tuple[int, int]:
    """Store what students have submitted into a folder or zip, and overrides.csv of the assignment's folder.

    Whatever is stored already is skipped. Return the numbers of new submissions and overrides. Raises QdotError.
    """
    from qdot.grader.serve.marking_online import grade_submission

    assignment = load_class_assignment(classroom, key)
    overrides = read_overrides(assignment)
    people = {person.student_id: person for person in classroom.people.filter(role=Person.Role.STUDENT)}
    new_submissions = new_overrides = 0
    with open_submissions(source) as root, transaction.atomic():
        for student, files in find_submissions(assignment, root).by_student.items():
            for attempt in read_attempts(files, key):
                content = attempt.file.read_bytes()
                # the same id whenever this file is imported, so that it is stored once
                request_id = uuid.uuid5(uuid.NAMESPACE_OID, f"{attempt.sha256}/{attempt.received.isoformat()}")
                submission, is_new = Submission.objects.get_or_create(
                    person=people[student], request_id=request_id,
                    defaults={
                        "assignment": key, "file_name": attempt.file.name[-255:], "content": content,
                        "received": attempt.received.replace(microsecond=0),
                    },
                )  # fmt: skip
                if is_new:
                    grade_submission.enqueue(submission.pk)
                    new_submissions += 1
        targets: list[tuple[dict[str, Any], Override]] = [
            ({"person": people[student], "part": part, "group": "", "answer": answer}, override)
            for (student, part, answer), override in overrides.by_part.items()
        ]
        targets += [
            ({"person": None, "part": group.partition("/")[0], "group": group, "answer": ""}, override)
            for group, override in overrides.by_group.items()
        ]
        for target, override in targets:
            _, is_new = PointsOverride.objects.update_or_create(
                defaults={"points": override.points, "comment": override.comment},
                classroom=classroom, assignment=key, **target,
            )  # fmt: skip
            new_overrides += is_new
    return new_submissions, new_overrides


# --- backups ---


def back_up(path: Path) -> None:
    """Write the database, the key of sessions and the files of the assignments into a zip, while the service runs."""
    content = io.StringIO()
    with transaction.atomic():
        if connection.vendor == "postgresql":
            with connection.cursor() as cursor:
                cursor.execute("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ")
        call_command("dumpdata", exclude=["contenttypes", "auth", "sessions"], stdout=content)
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(DATABASE_MEMBER, content.getvalue())
        for key, assignment in load_assignments().items():
            for file in sorted(file for file in assignment.folder.iterdir() if file.is_file()):
                archive.write(file, f"{FOLDERS_MEMBER}/{key}/{file.name}")
    write_atomically(path, buffer.getvalue(), 0o600)


def restore(path: Path) -> None:
    """Replace the content of the database by that of a backup; everybody is signed out. Raises QdotError."""
    content = read_member(path, DATABASE_MEMBER)
    temporary_path = find_options().online_folder / DATABASE_MEMBER
    write_atomically(temporary_path, content, 0o600)
    try:
        with transaction.atomic():
            call_command("flush", verbosity=0, interactive=False)
            call_command("loaddata", str(temporary_path), verbosity=0)
            Session.objects.all().delete()
    finally:
        temporary_path.unlink()
