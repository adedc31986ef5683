"""An assignment's folder made new, and its notebooks written, one for the student and one for the staff."""

import os
import re
import secrets
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from nbformat import NotebookNode

from exercises.assignment import SECRET_FILE, Assignment, Student, read_roster
from exercises.errors import QdotError
from exercises.files import made_lasting, make_folder, tidied, write_atomically
from exercises.notebook import notebook_text, solution_notebook, student_notebook
from exercises.parallel import ordered_map
from exercises.problem import Problem
from exercises.render import render
from exercises.sets import DEFAULT_SET, SETS, ProblemSet
from exercises.store import keep, store_path
from exercises.variation import DEFAULT

EXAMPLE_STUDENTS = (Student("s001", "Ada Example", "ada@example.org"), Student("s002", "Bo Example", "bo@example.org"))


def init_assignment(
    folder: Path, title: str, key: str, students: Sequence[Student] = EXAMPLE_STUDENTS, secret: str | None = None,
    roster: Path | None = None, problems: ProblemSet = SETS[DEFAULT_SET],
) -> None:  # fmt: skip
    """Make a new assignment folder. Raises QdotError where one is there already: nothing is overwritten.

    `roster` is a file that becomes roster.csv as it stands, in the place of `students`; `problems` is what is asked.
    """
    if roster is not None:
        read_roster(roster)
    names = ("assignment.toml", "roster.csv", ".gitignore", SECRET_FILE, "README.md")
    there = [name for name in names if (folder / name).exists()]
    if there:
        raise QdotError(f"{folder} has {', '.join(there)} already; name a new folder")
    context = {
        "title": title, "key": key, "students": students, "secret_file": SECRET_FILE, "set": problems,
        "default_variation": DEFAULT,
    }  # fmt: skip
    write_atomically(folder / SECRET_FILE, (secret or secrets.token_hex(32)) + "\n", mode=0o600)
    listed = render("init/roster.csv.j2", **context) if roster is None else roster.read_bytes()
    write_atomically(folder / "roster.csv", listed)
    write_atomically(folder / ".gitignore", render("init/gitignore.j2", **context))
    write_atomically(folder / "README.md", render("init/README.md.j2", **context))
    make_folder(folder / "submitted")
    write_atomically(folder / "assignment.toml", render("init/assignment.toml.j2", **context))


Maker = Callable[[str, str, str, Sequence[tuple[str, Problem]], bool], NotebookNode]
MAKERS: tuple[Maker, ...] = (student_notebook, solution_notebook)
"""What makes the notebooks of a student: the one to hand out, and the staff's."""


@dataclass(frozen=True)
class Released:
    """What became of one student's notebooks: "written", "kept" (up to date already), "completed" or "rewritten".

    Completed is what lacked a file, as an earlier run was stopped: no notebook to hand out is another than it was.
    Rewritten is one that changed since it was written.
    """

    student: str
    outcome: str


Certify = Callable[[Assignment, str, Sequence[tuple[str, Problem]], NotebookNode], str]
"""Returns the text of the certificate of a student's problems and notebook; raises QdotError where it has to fail."""


def certificate_path(assignment: Assignment, student: str) -> Path:
    """Return where the certificate of a student's problems is kept."""
    return assignment.folder / "certificates" / student / f"{assignment.key}.json"


def notebook_path(assignment: Assignment, student: str, kind: str = "released") -> Path:
    """Return where a student's notebook is: the one "released", or the staff's, in "solutions"."""
    return assignment.folder / kind / student / f"{assignment.key}.ipynb"


def release_one(work: tuple[Assignment, Certify], student: str) -> Released:
    """Certify the problems of one student and write both notebooks, unless all is there from this very assignment."""
    assignment, certify = work
    released, solved = paths = [notebook_path(assignment, student, kind) for kind in ("released", "solutions")]
    certificate = certificate_path(assignment, student)
    if all(_edition(path) == assignment.edition for path in (*paths, certificate)):
        return Released(student, "kept")
    problems = assignment.problems(student)
    notebooks = [_notebook(make, assignment, student, problems) for make in MAKERS]
    to_hand_out, solution = map(notebook_text, notebooks)
    there = _content(released)
    # Where the solution alone is an old one, a run was stopped after it had changed the notebook, and told nobody.
    if there not in (None, "", to_hand_out) or _edition(solved) not in ("", assignment.edition):
        outcome = "rewritten"
    else:
        outcome = "written" if there is None and not solved.exists() else "completed"
    certified = certify(assignment, student, problems, notebooks[0])
    write_atomically(certificate, certified, mode=0o600, lasting=False)
    if there != to_hand_out:
        write_atomically(released, to_hand_out, lasting=False)
    write_atomically(solved, solution, lasting=False)
    keep(assignment, student, problems)
    return Released(student, outcome)


def _notebook(
    make: Maker, assignment: Assignment, student: str, problems: Sequence[tuple[str, Problem]]
) -> NotebookNode:
    notebook = make(assignment.title, assignment.key, student, problems, assignment.hints)
    notebook.metadata["qdot"].update(digest=assignment.digest, edition=assignment.edition)
    return notebook


def handout(assignment: Assignment, student: str, failures: Callable[[Problem], Sequence[str]]) -> str:
    """Return the notebook to hand out: the one in released/, if it is up to date, else made and certified now.

    Raises QdotError where a problem fails its certificate.
    """
    released = notebook_path(assignment, student)
    if _edition(released) == assignment.edition:
        return _content(released) or ""
    problems = assignment.problems(student)
    for _, problem in problems:
        failed = failures(problem)
        if failed:
            raise QdotError(f"{problem.id}: the problem does not pass its certificate: {failed[0]}; please report it")
    return notebook_text(_notebook(student_notebook, assignment, student, problems))


def _content(path: Path) -> str | None:
    """Return the text of a file as it stands, None where there is no file; what can't be read is empty."""
    try:
        return path.read_bytes().decode(errors="replace")
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError:
        return ""


def _edition(path: Path) -> str:
    """Return the edition that a notebook or a certificate was made from, empty where there is none to be read."""
    match = re.search(r'"edition": "([^"]*)"', _content(path) or "")
    return match.group(1) if match else ""


def release(assignment: Assignment, certify: Certify, jobs: int, each: Callable[[Released], None]) -> None:
    """Write the notebooks of the whole class on `jobs` processes; `each` is told of every student's in roster order.

    A rerun after a stop goes on where it was: what is up to date is kept, and files that it had only begun are removed.
    """
    students = [student.id for student in assignment.roster]
    kinds = ("released", "solutions")
    notebooks = [notebook_path(assignment, student, kind) for student in students for kind in kinds]
    others = [path(assignment, student) for student in students for path in (certificate_path, store_path)]
    every = ordered_map(release_one, students, jobs, _both, (assignment, certify))
    with tidied(notebooks + others), closing(every), made_lasting(assignment.folder) as now_and_then:
        for released in every:
            now_and_then()
            each(released)


def _both(assignment: Assignment, certify: Certify) -> tuple[Assignment, Certify]:
    return assignment, certify


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


CORES = _cores()
"""The number of cores that this process may use."""
