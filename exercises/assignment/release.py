"""Make a new assignment folder, and write two notebooks for each student: one to release and one for the staff."""

import re
import secrets
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from qdot.exercises.assignment.assignment import MISSING_ROSTER_HINT, SECRET_FILE, Assignment, Student, read_roster
from qdot.exercises.assignment.certified_problems import (
    FailedSlot,
    RecordMaker,
    describe_internal_error,
    generate_student_problems,
    record_replacements,
)
from qdot.exercises.assignment.replacements import REPLACEMENTS_FILE, Replacement
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS, ProblemSet
from qdot.exercises.assignment.store import make_store_path, store_problems
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import clean_up_after, make_folder, sync_disks_after, write_atomically
from qdot.exercises.common.parallel import map_in_order, return_state
from qdot.exercises.common.variation import DEFAULT_VARIATION
from qdot.exercises.notebook.notebook import (
    NotebookContent,
    make_solution_notebook,
    make_student_notebook,
    write_notebook,
)
from qdot.exercises.notebook.self_check import Problems
from qdot.exercises.writing.render import render

if TYPE_CHECKING:
    from nbformat import NotebookNode

EXAMPLE_STUDENTS = (Student("s001", "Ada Example", "ada@example.org"), Student("s002", "Bo Example", "bo@example.org"))


def init_assignment(
    folder: Path, title: str, key: str, students: Sequence[Student] = EXAMPLE_STUDENTS, secret: str | None = None,
    roster: Path | None = None, problem_set: ProblemSet = SETS[DEFAULT_SET],
) -> None:  # fmt: skip
    """Make a new assignment folder. Nothing is overwritten: raises QdotError if one of its files exists already.

    `key` is the short name of the assignment in file names. `secret` is the text from which problems are generated, or
    None for a random one. `roster` is a file to copy as roster.csv; if it is given, `students` is ignored.
    """
    if roster is not None:
        read_roster(roster, MISSING_ROSTER_HINT)
    names = ("assignment.toml", "roster.csv", ".gitignore", SECRET_FILE, "README.md")
    existing_names = [name for name in names if (folder / name).exists()]
    if existing_names:
        raise QdotError(f"{folder} already has {', '.join(existing_names)}; choose another folder")
    context = {
        "title": title, "key": key, "students": students, "secret_file": SECRET_FILE, "set": problem_set,
        "default_variation": DEFAULT_VARIATION,
    }  # fmt: skip
    write_atomically(folder / SECRET_FILE, (secret or secrets.token_hex(32)) + "\n", mode=0o600)
    roster_content = render("init/roster.csv.j2", **context) if roster is None else roster.read_bytes()
    write_atomically(folder / "roster.csv", roster_content)
    write_atomically(folder / ".gitignore", render("init/gitignore.j2", **context))
    write_atomically(folder / "README.md", render("init/README.md.j2", **context))
    make_folder(folder / "submitted")
    write_atomically(folder / "assignment.toml", render("init/assignment.toml.j2", **context))


NOTEBOOK_FOLDERS = ("released", "solutions")
"""The folders of a student's notebooks: the one to release, and the staff's."""


@dataclass(frozen=True)
class ReleaseResult:
    """The outcome for a student's notebooks.

    - "written": the notebooks are new.
    - "kept": the notebooks were up to date.
    - "completed": a file was missing or unreadable after an interrupted run; no existing notebook has changed.
    - "rewritten": the released notebook has changed.
    - "left out": there is no notebook, because there is no valid problem for the `failed_slots`.
    - "to replace": nothing is written yet; the caller must first record the `replacements`, then call again.
    """

    student: str
    outcome: str
    replacements: Mapping[str, Replacement] = field(default_factory=dict)
    failed_slots: tuple[FailedSlot, ...] = ()


@dataclass(frozen=True)
class Certifier:
    """Two functions of the grader, which this package must not import.

    `make_record` certifies a problem and returns the record of its checks (see `RecordMaker`). `make_certificate`
    returns a student's certificate as text, which lists the records of the student's problems. Its arguments are the
    assignment, the student, the records by slot and the notebook.
    """

    make_record: RecordMaker[Any]
    make_certificate: Callable[[Assignment, str, Mapping[str, Any], "NotebookNode"], str]


class ReleaseContext(NamedTuple):
    """The arguments of `release_notebooks_of_student` that are the same for every student."""

    assignment: Assignment
    certifier: Certifier


ONLINE_FOLDER = "online"
"""The folder for the files of `qdot serve`; `qdot forget` removes students from the database in it."""


def _find_student_folder(assignment: Assignment, kind: str, student: str) -> Path:
    """Return the folder of a student's files of a kind.

    Only the stand-in students of `qdot serve`, such as practice:3, have a colon in the identifier; their files are in
    online/.
    """
    if ":" not in student:
        return assignment.folder / kind / student
    return assignment.folder / ONLINE_FOLDER / kind / re.sub(r'[/\\:*?"<>|]', "-", student)


def make_certificate_path(assignment: Assignment, student: str) -> Path:
    """Return the path of the certificate of a student's problems."""
    return _find_student_folder(assignment, "certificates", student) / f"{assignment.key}.json"


def make_notebook_path(assignment: Assignment, student: str, kind: str = "released") -> Path:
    """Return the path of a student's notebook: the student's own ("released"), or the staff's ("solutions")."""
    return _find_student_folder(assignment, kind, student) / f"{assignment.key}.ipynb"


def release_notebooks_of_student(context: ReleaseContext, student: str) -> ReleaseResult:
    """Certify the problems of one student and write both notebooks, unless all files are up to date.

    If a problem has to be replaced, write nothing and return the replacement, which the caller records.
    """
    assignment, certifier = context
    if is_up_to_date(assignment, student):
        return ReleaseResult(student, "kept")
    student_problems = generate_student_problems(assignment, student, certifier.make_record)
    if student_problems.failed_slots:
        return ReleaseResult(student, "left out", failed_slots=student_problems.failed_slots)
    new_replacements = student_problems.find_new_replacements(assignment)
    if new_replacements:
        return ReleaseResult(student, "to replace", new_replacements)
    certified_problems = student_problems.certified_problems
    problems = [(slot, certified_problem.problem) for slot, certified_problem in certified_problems.items()]
    try:
        notebooks = _make_notebooks(assignment, student, problems)
    except (QdotError, OSError, MemoryError):
        raise
    except Exception as error:
        failed_slot = _find_faulty_slot(assignment, student, problems, error)
        return ReleaseResult(student, "left out", failed_slots=(failed_slot,))
    records = {slot: certified_problem.record for slot, certified_problem in certified_problems.items()}
    certificate = certifier.make_certificate(assignment, student, records, notebooks[0])
    outcome = _write_files(assignment, student, notebooks, certificate)
    store_problems(assignment, student, problems)
    return ReleaseResult(student, outcome)


def _write_files(assignment: Assignment, student: str, notebooks: "Sequence[NotebookNode]", certificate: str) -> str:
    """Write the certificate and the notebooks, and return the outcome (see `ReleaseResult`)."""
    released_path, solution_path = (make_notebook_path(assignment, student, kind) for kind in NOTEBOOK_FOLDERS)
    new_text, solution = map(write_notebook, notebooks)
    existing_text = read_if_present(released_path)
    # An outdated solution means that an earlier run stopped between writing the two notebooks. Report "rewritten",
    # although the released notebook may already be new.
    is_solution_outdated = _read_notebook_digest(solution_path) not in ("", assignment.notebook_digest_of(student))
    if existing_text not in (None, "", new_text) or is_solution_outdated:
        outcome = "rewritten"
    else:
        outcome = "written" if existing_text is None and not solution_path.exists() else "completed"
    write_atomically(make_certificate_path(assignment, student), certificate, mode=0o600, is_synced=False)
    if existing_text != new_text:
        write_atomically(released_path, new_text, is_synced=False)
    write_atomically(solution_path, solution, mode=0o600, is_synced=False)
    return outcome


def _find_faulty_slot(assignment: Assignment, student: str, problems: Problems, error: Exception) -> FailedSlot:
    """Return the slot whose problem can't be written into a notebook, with the internal error that it causes.

    If each problem can be written alone, return the first slot with the error of the whole notebook.
    """
    for slot, problem in problems:
        try:
            _make_notebooks(assignment, student, [(slot, problem)])
        except Exception as slot_error:
            return FailedSlot(student, slot, problem.id.family, describe_internal_error(slot_error))
    slot, problem = problems[0]
    return FailedSlot(student, slot, problem.id.family, describe_internal_error(error))


def _make_notebooks(assignment: Assignment, student: str, problems: Problems) -> "tuple[NotebookNode, NotebookNode]":
    """Return the released notebook, and the staff's, which copies its statements and question prompts."""
    released_notebook = make_notebook(assignment, student, problems)
    return released_notebook, make_notebook(assignment, student, problems, released_notebook)


def make_notebook(
    assignment: Assignment, student: str, problems: Problems, released_notebook: "NotebookNode | None" = None
) -> "NotebookNode":
    """Return the notebook to release, or the staff's notebook with solutions if `released_notebook` is given."""
    content = NotebookContent(assignment.title, assignment.key, student, problems, assignment.hints, assignment.site)
    if released_notebook is None:
        notebook = make_student_notebook(content)
    else:
        notebook = make_solution_notebook(content, released_notebook)
    notebook.metadata["qdot"].update(
        problems_digest=assignment.problems_digest_of(student),
        notebook_digest=assignment.notebook_digest_of(student),
        secret_digest=assignment.secret_digest,
    )
    return notebook


def is_up_to_date(assignment: Assignment, student: str) -> bool:
    """Return whether a student's notebooks and certificate all exist and belong to the current assignment."""
    notebooks = [make_notebook_path(assignment, student, kind) for kind in NOTEBOOK_FOLDERS]
    paths = [*notebooks, make_certificate_path(assignment, student)]
    return all(_read_notebook_digest(path) == assignment.notebook_digest_of(student) for path in paths)


def is_released(assignment: Assignment, student: str) -> bool:
    """Return whether a student's notebook in released/ exists and belongs to the current assignment."""
    return _read_notebook_digest(make_notebook_path(assignment, student)) == assignment.notebook_digest_of(student)


def read_if_present(path: Path) -> str | None:
    """Return the text of a file; None if there is no file, "" if it can't be read."""
    try:
        return path.read_bytes().decode(errors="replace")
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError:
        return ""


def _read_notebook_digest(path: Path) -> str:
    """Return the digest of the settings from which a notebook or certificate was made, "" if none is recorded."""
    match = re.search(r'"notebook_digest": "([^"]*)"', read_if_present(path) or "")
    return match.group(1) if match else ""


def release_notebooks(
    assignment: Assignment, certifier: Certifier, jobs: int, on_result: Callable[[ReleaseResult], None]
) -> Assignment:
    """Write the notebooks of the whole class in `jobs` processes; return the assignment with its replaced problems.

    `on_result` is called for every student, in roster order. Students with newly replaced problems come last, because
    the table of replacements (redrawn.csv) must list these problems before the notebooks are written. A second run
    after an interruption continues: files that are up to date stay unchanged. When this function ends, partly written
    files are removed.
    """
    students = [student.id for student in assignment.roster]
    paths = [make_notebook_path(assignment, student, kind) for student in students for kind in NOTEBOOK_FOLDERS]
    paths += [make_certificate_path(assignment, student) for student in students]
    paths += [make_store_path(assignment.folder, student) for student in students]
    with clean_up_after([*paths, assignment.folder / REPLACEMENTS_FILE]), sync_disks_after():
        while students:
            waiting_students: list[str] = []
            context = ReleaseContext(assignment, certifier)
            with closing(  # `return_state` gives each process the context as its state
                map_in_order(release_notebooks_of_student, students, jobs, setup=return_state, arguments=(context,))
            ) as results:
                for result in results:
                    if result.outcome == "to replace":
                        assignment = record_replacements(assignment, result.student, result.replacements)
                        waiting_students.append(result.student)
                    else:
                        on_result(result)
            students = waiting_students
    return assignment
