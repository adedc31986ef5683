"""Pack the feedback pages of a class for upload to a platform (`qdot return`).

A platform finds the student of a page by the name of the page's file or folder. This name must begin like the name in
the platform's download of the submissions. Moodle's mod/assign/feedback/file/importziplib.php and Canvas's
app/models/abstract_assignment.rb parse these names. Brightspace's documentation requires the folders of its download.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.handout import make_file_name
from qdot.exercises.common.errors import QdotError, count_noun, write_first
from qdot.exercises.common.files import make_zip, write_atomically
from qdot.grader.grading.result import Result
from qdot.grader.reports.gradebooks import make_brightspace_csv, make_canvas_csv, make_moodle_csv
from qdot.grader.reports.graded_folder import read_current_page
from qdot.grader.reports.grades_table import make_grades_csv
from qdot.grader.submissions.layouts import check_safely
from qdot.grader.submissions.submission import UNCERTAIN_OWNER, find_certain_paths

MAX_STUDENTS_LISTED = 10
"""Maximum number of students named in a message."""


@dataclass(frozen=True)
class ReturnTarget:
    """A platform that takes pages back.

    `layout` is the name of the platform in `SubmittedPath`. `find_place` returns the beginning of the path of a page in
    the zip, from a submitted file or folder; None if the platform can't place a page there. `make_marks` returns the
    table of marks that the platform imports. `upload_words` says where to upload the zip.
    """

    layout: str
    find_place: Callable[[Path], str | None]
    make_marks: Callable[[Assignment, Sequence[Result]], str]
    upload_words: str


def _find_moodle_place(path: Path) -> str | None:
    """Return the folder of a submission in Moodle's download; its file name begins like a folder's name."""
    if check_safely(path.is_dir):
        return f"{path.name}/"
    folder = re.match(r".+?_\d+_assignsubmission_[a-z]+_?", path.name, re.DOTALL)
    return f"{folder[0].removesuffix('_')}/" if folder else None


def _find_canvas_place(path: Path) -> str | None:
    """Return the beginning of a file's name in Canvas's download, with the numbers of the user and of the file.

    Canvas doesn't place files beside a text or an address that was submitted.
    """
    beginning = re.match(r".+?(?:_LATE)?_\d+_\d+_", path.name, re.DOTALL)
    return beginning and beginning[0]


TARGETS = {
    "moodle": ReturnTarget(
        "Moodle", _find_moodle_place, make_moodle_csv,
        "in the assignment, Submissions > Actions > Upload feedback files in a zip",
    ),
    "canvas": ReturnTarget("Canvas", _find_canvas_place, make_canvas_csv, "in the assignment, Re-upload submissions"),
    "brightspace": ReturnTarget(
        "Brightspace", lambda path: f"{path.name}/", make_brightspace_csv,
        "in the assignment's folder, Submissions > Add feedback files",
    ),
}  # fmt: skip
"""Maps each value of `--to` that names a platform to the platform."""
FOLDER = "folder"
"""The value of `--to` for a folder with a page for each student."""


@dataclass(frozen=True)
class ReturnedFeedback:
    """What `qdot return` has written: the zip or the folder of pages, their number, the table of marks; and notes."""

    pages_path: Path
    page_count: int
    marks_path: Path
    notes: Sequence[str] = ()


def return_feedback(
    assignment: Assignment, results: Sequence[Result], target_name: str, submissions: Path, out: Path
) -> ReturnedFeedback:
    """Write the pages of a class for a platform, or into a folder, with the table of marks beside them.

    `submissions` is the folder of submissions that was graded; a folder of pages needs none. Raises QdotError if a page
    is missing or out of date, or if a page can't be placed; nothing is written then.
    """
    students = {student.id: student for student in assignment.roster}
    pages = {result.student: read_current_page(assignment, students[result.student], result) for result in results}
    if target_name == FOLDER:
        names = {student: f"{make_file_name(students[student])}.html" for student in pages}
        files: dict[Path, bytes] = {out / names[student]: page for student, page in pages.items()}
        returned_feedback = ReturnedFeedback(out, len(pages), out / "grades.csv")
        marks = make_grades_csv(results, assignment.roster, names)
    else:
        target = TARGETS[target_name]
        submitted_ids = [result.student for result in results if result.submission is not None]
        _check_owners(assignment, results)
        places = _find_places(target, assignment, submitted_ids, submissions)
        file_name = f"{assignment.key}-feedback.html"
        zipped_pages = {f"{places[student]}{file_name}": pages[student] for student in submitted_ids}
        zip_path = out / f"{target_name}-feedback.zip"
        files = {zip_path: make_zip(zipped_pages)}
        notes = _note_absent_students(results, submitted_ids)
        marks_path = out / f"{target_name}-grades.csv"
        returned_feedback = ReturnedFeedback(zip_path, len(zipped_pages), marks_path, notes)
        marks = target.make_marks(assignment, results)
    for path, content in (*files.items(), (returned_feedback.marks_path, marks.encode())):
        write_atomically(path, content, 0o600)
    return returned_feedback


def _check_owners(assignment: Assignment, results: Sequence[Result]) -> None:
    """Raise QdotError if the owner of a submission is uncertain."""
    doubtful_students = [result.student for result in results if result.obstacle == UNCERTAIN_OWNER]
    if doubtful_students:
        names = write_first(doubtful_students, MAX_STUDENTS_LISTED)
        raise QdotError(
            f"a submission may belong to {names}, but not certainly; do what `qdot grade {assignment.folder}` advises, "
            "grade again, and then return the pages"
        )


def _find_places(
    target: ReturnTarget, assignment: Assignment, students: Sequence[str], submissions: Path
) -> Mapping[str, str]:
    """Return the place of each student's page in the zip. Raises QdotError if a page can't be placed."""
    submitted_paths = find_certain_paths(assignment, submissions)
    places = {}
    for student in students:
        entries = submitted_paths.get(student, ())
        paths = [entry.path for entry in entries if entry.platform == target.layout]
        places[student] = next(filter(None, map(target.find_place, paths)), None)
    unplaced_students = [student for student, place in places.items() if place is None]
    if unplaced_students:
        names = write_first(unplaced_students, MAX_STUDENTS_LISTED)
        raise QdotError(
            f"no submission of {names} has a name from {target.layout}; give the download from {target.layout} that "
            f"was graded, as in: qdot return {assignment.folder} download.zip --to {target.layout.lower()}; or choose "
            f"--to {FOLDER}"
        )
    return {student: place for student, place in places.items() if place is not None}


def _note_absent_students(results: Sequence[Result], submitted_ids: Sequence[str]) -> list[str]:
    """Return a note on the students who submitted nothing, whose pages have no place; [] if there are none."""
    absent_students = [result.student for result in results if result.student not in submitted_ids]
    if not absent_students:
        return []
    names = write_first(absent_students, MAX_STUDENTS_LISTED)
    verb = "gets" if len(absent_students) == 1 else "get"
    return [f"{count_noun(len(absent_students), 'student')} without a submission {verb} no page: {names}"]
