"""nbgrader itself: its commands collect a class's notebooks by the exchange and by zip_collect, and mark them.

`software` is an environment of Python with nbgrader and JupyterLab, into which the exported qdot is installed. The
marks are read from the formgrader's pages and API, and from the students' feedback.
"""

import html
import json
import re
import subprocess
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.exports.nbgrader import list_parts, make_grade_id
from qdot.grader.reports.part_rows import make_part_rows
from tests.platforms.jupyter import fetch_page, make_environment, serve_jupyterlab
from tests.platforms.notebooks import (
    BLANK,
    KEY,
    MISTAKEN,
    RIGHT,
    WRONG,
    QdotGrading,
    compare_marks,
    export_into,
    fill_in_answers,
    install,
    make_class_assignment,
)
from tests.platforms.records import Counts, Record, today

COURSE = "kinematics"
BY_EXCHANGE, BY_ZIP = (RIGHT, MISTAKEN), (WRONG, BLANK)
"""Students whose notebooks are submitted through the exchange, and those whose are in a downloaded archive."""
NAME_PATTERN = r".*_(?P<student_id>\w+)_attempt_(?P<timestamp>[0-9\-]+)_(?P<file_id>\w+)"
"""The names of files downloaded from a learning platform; the example in nbgrader's documentation."""


def run(software: Path, work: Path) -> Record:
    """Run nbgrader's commands for a class, from generate_assignment to feedback, and open the formgrader."""
    assignment, counts = make_class_assignment(work / KEY), Counts()
    course = _Course(software, work, export_into(assignment, "nbgrader", work / "course"))
    (wheel,) = course.folder.glob("*.whl")
    install(software, wheel)
    course.run_as_staff("generate_assignment", KEY)
    course.run_as_staff("db", "student", "import", "students.csv")
    course.submit_and_collect(assignment)
    for name in (student.id for student in assignment.roster):
        counts.add("imported", (course.folder / "submitted" / name / KEY / f"{KEY}.ipynb").exists(), name)
    course.run_as_staff("autograde", KEY)
    course.run_as_staff("generate_feedback", KEY)
    with serve_jupyterlab(software, course.folder, work) as address:
        formgrader = _Formgrader(f"{address}/formgrader")
        for student in (student.id for student in assignment.roster):
            _check_student(
                QdotGrading(assignment, student, work / student / KEY / f"{KEY}.ipynb"), course, formgrader, counts
            )
    version = subprocess.run([software / "bin" / "nbgrader", "--version"], capture_output=True, text=True)
    return Record("nbgrader", f"nbgrader {version.stdout.split()[-1]} and its formgrader", today(), counts.freeze())


@dataclass(frozen=True)
class _Course:
    """An nbgrader course: the exported course `folder`; `work` contains the exchange and a folder for each student."""

    software: Path
    work: Path
    folder: Path

    def run_as_staff(self, *words: str) -> None:
        self._run(self.folder, *words)

    def submit_and_collect(self, assignment: Assignment) -> None:
        for student in (student.id for student in assignment.roster):
            file = f"{student}/{KEY}/{KEY}.ipynb"
            (self.work / file).parent.mkdir(parents=True)
            text = (self.folder / "handout" / file).read_text(encoding="utf-8")
            (self.work / file).write_text(fill_in_answers(assignment, student, text), encoding="utf-8")
        self.run_as_staff("release_assignment", KEY)
        for student in BY_EXCHANGE:
            self._run(self.work / student, "submit", KEY, f"--CourseDirectory.student_id={student}")
        self.run_as_staff("collect", KEY)
        archive = self.folder / "downloaded" / KEY / "archive"
        archive.mkdir(parents=True)
        with zipfile.ZipFile(archive / "all.zip", "w") as zip_file:
            for student in BY_ZIP:
                name = f"{KEY}_{student}_attempt_2027-01-15-22-00-00_{KEY}.ipynb"
                zip_file.write(self.work / student / KEY / f"{KEY}.ipynb", name)
        self.run_as_staff("zip_collect", KEY, f"--FileNameCollectorPlugin.named_regexp={NAME_PATTERN}")

    def _run(self, cwd: Path, *words: str) -> None:
        exchange = self.work / "exchange"
        exchange.mkdir(mode=0o777, exist_ok=True)
        exchange.chmod(0o777)
        options = [f"--Exchange.root={exchange}", f"--CourseDirectory.course_id={COURSE}"]
        command: list[str | Path] = [self.software / "bin" / "nbgrader", *words, *options]
        done = subprocess.run(
            command, cwd=cwd, env=make_environment(self.software, self.work), capture_output=True, text=True
        )
        if done.returncode:
            raise RuntimeError(f"nbgrader {words[0]}: {done.stdout[-2000:]}{done.stderr[-2000:]}")


@dataclass(frozen=True)
class _Formgrader:
    address: str

    @cached_property
    def scores(self) -> Mapping[str, Mapping[str, Any]]:
        return {entry["student"]: entry for entry in json.loads(fetch_page(f"{self.address}/api/submissions/{KEY}"))}

    @cached_property
    def notebooks(self) -> Mapping[str, str]:
        entries = json.loads(fetch_page(f"{self.address}/api/submitted_notebooks/{KEY}/{KEY}"))
        return {entry["student"]: entry["id"] for entry in entries}

    def fetch_grades(self, student: str) -> dict[str, float]:
        boxes = json.loads(fetch_page(f"{self.address}/api/grades?submission_id={self.notebooks[student]}"))
        return {box["name"]: box["auto_score"] for box in boxes}

    def fetch_text(self, student: str) -> str:
        return _extract_text(fetch_page(f"{self.address}/submissions/{self.notebooks[student]}/"))


def _extract_text(text: str) -> str:
    return re.sub(r"\s+", "", html.unescape(re.sub(r"<[^>]*>", "", text)))


def _check_student(grading: QdotGrading, course: _Course, formgrader: _Formgrader, counts: Counts) -> None:
    """Check what the staff and the student see, and the marks."""
    student, assignment = grading.student, grading.assignment
    entry, grades = formgrader.scores[student], formgrader.fetch_grades(student)
    is_total_right = (entry["score"], entry["max_score"]) == (grading.result.score, grading.result.max_score)
    is_name_right = f"{entry['first_name']} {entry['last_name']}" == assignment.find_student(student).name
    counts.add(
        "shown in formgrader", is_total_right and is_name_right, f"{student}: {entry}, {grading.result.score} by qdot"
    )
    feedback = course.folder / "feedback" / student / KEY / f"{KEY}.html"
    pages = {
        "shown": _extract_text(feedback.read_text(encoding="utf-8")),
        "shown in formgrader": formgrader.fetch_text(student),
    }
    rows = {row.part: row for row in make_part_rows(grading.result, assignment, assignment.feedback)}
    for part, name, points, _ in list_parts(assignment):
        message = "" if rows[part].points == points else _extract_text(html.escape(rows[part].message))
        for check, text in pages.items():
            counts.add(
                check, f"#Markedbyqdot:{part}," in text and message in text, f"{student} {name}: {rows[part].message}"
            )
    compare_marks(
        counts,
        grading,
        {part: grades[make_grade_id(part)] for part in grading.result.parts if make_grade_id(part) in grades},
    )
