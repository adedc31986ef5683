"""nbgrader itself, by its commands: a class's notebooks come in by its exchange and by zip_collect, and are marked.

`software` is an environment of Python with nbgrader and JupyterLab, into which the exported qdot is installed. The
marks are read in the formgrader, from the pages and the lists that a browser is given, and in students' feedback.
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
from qdot.grader.grading.batch import find_student
from qdot.grader.reports.part_rows import make_part_rows
from tests.platforms.jupyter import jupyter, page, variables
from tests.platforms.notebooks import (
    BLANK,
    KEY,
    MISTAKEN,
    RIGHT,
    WRONG,
    Ours,
    a_class,
    answered,
    exported,
    hold,
    install,
)
from tests.platforms.records import Counts, Record, today

COURSE = "kinematics"
BY_EXCHANGE, BY_ZIP = (RIGHT, MISTAKEN), (WRONG, BLANK)
"""Students by how their notebooks come in."""
NAMED = r".*_(?P<student_id>\w+)_attempt_(?P<timestamp>[0-9\-]+)_(?P<file_id>\w+)"
"""The names that a learning platform gives to what it was handed, as nbgrader's documentation has them."""


def run(software: Path, work: Path) -> Record:
    """Take a class through the course's steps, from generate_assignment to feedback, and open the formgrader."""
    assignment, counts = a_class(work / KEY, RIGHT, WRONG, MISTAKEN, BLANK), Counts()
    course = _Course(software, work, exported(assignment, "nbgrader", work / "course"))
    (wheel,) = course.folder.glob("*.whl")
    install(software, wheel)
    course.staff("generate_assignment", KEY)
    course.staff("db", "student", "import", "students.csv")
    course.hand_in(assignment)
    for name in (one.id for one in assignment.roster):
        counts.add("imported", (course.folder / "submitted" / name / KEY / f"{KEY}.ipynb").exists(), name)
    course.staff("autograde", KEY)
    course.staff("generate_feedback", KEY)
    with jupyter(software, course.folder, work) as address:
        formgrader = _Formgrader(f"{address}/formgrader")
        for student in (one.id for one in assignment.roster):
            _hold(Ours(assignment, student, work / student / KEY / f"{KEY}.ipynb"), course, formgrader, counts)
    version = subprocess.run([software / "bin" / "nbgrader", "--version"], capture_output=True, text=True)
    return Record("nbgrader", f"nbgrader {version.stdout.split()[-1]} and its formgrader", today(), counts.told())


@dataclass(frozen=True)
class _Course:
    """The course folder as it was exported, an exchange, and a folder for each student."""

    software: Path
    work: Path
    folder: Path

    def staff(self, *words: str) -> None:
        """Give a command of nbgrader's in the course folder."""
        self._nbgrader(self.folder, *words)

    def hand_in(self, assignment: Assignment) -> None:
        """Have everybody hand in, and collect it."""
        for student in (one.id for one in assignment.roster):
            file = f"{student}/{KEY}/{KEY}.ipynb"
            (self.work / file).parent.mkdir(parents=True)
            text = (self.folder / "handout" / file).read_text(encoding="utf-8")
            (self.work / file).write_text(answered(assignment, student, text), encoding="utf-8")
        self.staff("release_assignment", KEY)
        for student in BY_EXCHANGE:
            self._nbgrader(self.work / student, "submit", KEY, f"--CourseDirectory.student_id={student}")
        self.staff("collect", KEY)
        archive = self.folder / "downloaded" / KEY / "archive"
        archive.mkdir(parents=True)
        with zipfile.ZipFile(archive / "all.zip", "w") as packed:
            for student in BY_ZIP:
                name = f"{KEY}_{student}_attempt_2027-01-15-22-00-00_{KEY}.ipynb"
                packed.write(self.work / student / KEY / f"{KEY}.ipynb", name)
        self.staff("zip_collect", KEY, f"--FileNameCollectorPlugin.named_regexp={NAMED}")

    def _nbgrader(self, cwd: Path, *words: str) -> None:
        exchange = self.work / "exchange"
        exchange.mkdir(mode=0o777, exist_ok=True)
        exchange.chmod(0o777)
        options = [f"--Exchange.root={exchange}", f"--CourseDirectory.course_id={COURSE}"]
        command: list[str | Path] = [self.software / "bin" / "nbgrader", *words, *options]
        done = subprocess.run(command, cwd=cwd, env=variables(self.software, self.work), capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"nbgrader {words[0]}: {done.stdout[-2000:]}{done.stderr[-2000:]}")


@dataclass(frozen=True)
class _Formgrader:
    """The formgrader's pages, and the lists from which its pages are filled."""

    address: str

    @cached_property
    def scores(self) -> Mapping[str, Mapping[str, Any]]:
        """What nbgrader's list of submissions shows about each student."""
        return {one["student"]: one for one in json.loads(page(f"{self.address}/api/submissions/{KEY}"))}

    @cached_property
    def notebooks(self) -> Mapping[str, str]:
        """Its names of the notebooks, by students."""
        listed = json.loads(page(f"{self.address}/api/submitted_notebooks/{KEY}/{KEY}"))
        return {one["student"]: one["id"] for one in listed}

    def grades(self, student: str) -> dict[str, float]:
        """Return the points in the boxes of a student's page, by the cells' names."""
        boxes = json.loads(page(f"{self.address}/api/grades?submission_id={self.notebooks[student]}"))
        return {box["name"]: box["auto_score"] for box in boxes}

    def words(self, student: str) -> str:
        """Return what a student's page says."""
        return _words(page(f"{self.address}/submissions/{self.notebooks[student]}/"))


def _words(text: str) -> str:
    """Return what a page says, without tags and spaces, which differ with what a browser makes of a notebook."""
    return re.sub(r"\s+", "", html.unescape(re.sub(r"<[^>]*>", "", text)))


def _hold(ours: Ours, course: _Course, formgrader: _Formgrader, counts: Counts) -> None:
    """Hold what the staff see of a student, and what the student sees."""
    student, assignment = ours.student, ours.assignment
    listed, grades = formgrader.scores[student], formgrader.grades(student)
    total = (listed["score"], listed["max_score"]) == (ours.result.score, ours.result.max_score)
    named = f"{listed['first_name']} {listed['last_name']}" == find_student(assignment, student).name
    counts.add("shown in formgrader", total and named, f"{student}: {listed}, {ours.result.score} of ours")
    feedback = course.folder / "feedback" / student / KEY / f"{KEY}.html"
    pages = {"shown": _words(feedback.read_text(encoding="utf-8")), "shown in formgrader": formgrader.words(student)}
    rows = {row.part: row for row in make_part_rows(ours.result, assignment.feedback)}
    for part, name, points, _ in list_parts(assignment):
        said = "" if rows[part].points == points else _words(html.escape(rows[part].message))
        for what, text in pages.items():
            counts.add(
                what, f"#Markedbyqdot:{part}," in text and said in text, f"{student} {name}: {rows[part].message}"
            )
    hold(
        counts, ours, {part: grades[make_grade_id(part)] for part in ours.result.parts if make_grade_id(part) in grades}
    )
