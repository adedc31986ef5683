"""A run that can't be right: found before anything is graded or written, and stopped with the likely cause."""

import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Any

from qdot.exercises.assignment.assignment import SECRET_FILE, SECRET_VARIABLE, Assignment, load_assignment
from qdot.exercises.assignment.release import notebook_path
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.certify import former_students
from qdot.grader.submissions.layouts import only_folder
from qdot.grader.submissions.submission import DEEPEST, StudentFiles, Submission, SubmissionFolder, read_submission

LOOKED_AT = 25
"""Students, spread over the roster, whose notebooks' metadata are looked at."""
LARGEST = 1_000_000
"""Bytes of a notebook that is looked at: one that is made to hurt is left to the processes that grade."""
ARCHIVES = (".zip", ".tar", ".tgz", ".tar.gz", ".7z", ".rar")
"""What names of archives end with."""
SHOWN = 5
"""Names that a message lists."""


def load_class(folder: Path) -> Assignment:
    """Return an assignment whose roster and secret are those of the notebooks in released/. Raises QdotError."""
    assignment = load_assignment(folder)
    paths = {student.id: notebook_path(assignment, student.id) for student in assignment.roster}
    found = {student: StudentFiles((path,)) for student, path in paths.items() if path.exists()}
    if alike := _alike(former_students(assignment), [student for student in paths if student not in found]):
        students = "1 student" if len(alike) == 1 else f"{len(alike)} students"
        raise QdotError(
            f"{folder / 'roster.csv'}: {students} would get other problems than those in {folder / 'released'}, so "
            f"nothing was done. {_as_before(alike)}"
        )
    read = [submission for _, submission in read_some(assignment, found, list(paths))]
    check_secret(assignment, read, folder / "released", "; or delete this folder, if nobody has these notebooks")
    return assignment


def check_class(assignment: Assignment, looked: SubmissionFolder, root: Path, named: Path) -> None:
    """Raise QdotError where files are of nobody, or most notebooks of others: assignments, students, secrets.

    `root` is where they lie, `named` the folder or zip that the user named.
    """
    ids = [student.id for student in assignment.roster]
    if looked.strangers and not looked.by_student:
        raise QdotError(
            f"{named}: no file or folder here belongs to a student in roster.csv, so nothing was graded. "
            + _of_nobody([*looked.strangers, *_inside(root)], ids, assignment.key)
        )
    absent = [student for student in ids if student not in looked.by_student]
    if alike := _alike(looked.strangers, absent):
        raise QdotError(f"{named}: work of {len(alike)} would be of nobody, so nothing was graded. {_as_before(alike)}")
    read = list(read_some(assignment, looked.by_student, ids))
    keys = [said for _, one in read if isinstance(said := one.claims.get("assignment"), str) and said != assignment.key]
    if 2 * len(keys) > len(read) > 1:
        raise QdotError(
            f"{named}: {len(keys)} of {len(read)} notebooks belong to another assignment ({_some(sorted(set(keys)))}) "
            f"than {assignment.key!r}, so nothing was graded. Is this the right folder?"
        )
    claimed = {
        who: str(said) for who, one in read if isinstance(said := one.claims.get("student"), str) and said != who
    }
    if len(claimed) > 1 and 2 * len(claimed) > len(read):
        raise QdotError(f"{named}: {len(claimed)} of {len(read)} notebooks {_of_others(claimed, ids)}")
    check_secret(assignment, [one for _, one in read], named)


def check_secret(assignment: Assignment, read: Sequence[Submission], path: Path, otherwise: str = "") -> None:
    """Raise QdotError where most notebooks were made with another secret: nobody would get the problems they solved.

    `otherwise` is what else can be done about it.
    """
    said = [one.claims["secret"] for one in read if isinstance(one.claims.get("secret"), str)]
    wrong = sum(one != assignment.secret_mark for one in said)
    if 2 * wrong > len(said):
        source = assignment.folder / SECRET_FILE
        where = str(source) if source.exists() else f"${SECRET_VARIABLE}"
        raise QdotError(
            f"{path}: {'the notebook was' if len(said) == 1 else f'{wrong} of {len(said)} notebooks were'} made with "
            f"another secret than the one in {where}, so "
            "nothing was done: every student would be marked on problems that they never saw. Put the secret "
            f"there that the notebooks were made with{otherwise}"
        )


def _of_others(claimed: Mapping[str, str], ids: Sequence[str]) -> str:
    """Return what is said of notebooks of other students than they are found with, and what to do."""
    alike = {who: said for who, said in claimed.items() if _bare(who) == _bare(said)}
    if len(alike) < len(claimed) and set(claimed.values()) <= set(ids):
        listed = [f"{who} has that of {said}" for who, said in list(claimed.items())[:SHOWN]]
        more = f", and {len(claimed) - SHOWN} more" if len(claimed) > SHOWN else ""
        return (
            f"are in the folders, or under the names, of other students in roster.csv ({', '.join(listed)}{more}), so "
            "nothing was graded. Were folders or files renamed or mixed up? Put each notebook back with its own student"
        )
    cause = (
        f"{SPREADSHEET} Write these into roster.csv as they were: {_mapping(alike)}."
        if len(alike) == len(claimed)
        else "Is this the class, and the folder, that the notebooks were handed out to?"
    )
    return (
        "were handed out to students of other identifiers than those they are found with, so nothing was graded. "
        f"{cause}"
    )


SPREADSHEET = "They differ by leading zeros, case or the way in which letters are encoded; a spreadsheet removes zeros."


def _of_nobody(strangers: Sequence[str], ids: Sequence[str], key: str) -> str:
    """Return what is the likely cause, and what to do."""
    if alike := _alike(strangers, ids):
        return _as_before(alike)
    if f"{key}.ipynb" in strangers:
        return f"Whose notebook is {key}.ipynb? Put it into a folder named after the student: STUDENT/{key}.ipynb"
    packed = [name for name in strangers if name.lower().endswith(ARCHIVES)]
    if packed and 2 * len(packed) >= len(strangers):
        return (
            f"It has {_some(packed)}, and an archive in it is opened only if it is named after a student. Unpack it, "
            "and grade the folder that was in it"
        )
    within = {name: student for name in strangers if (student := _named_in(name, ids))}
    if 2 * len(within) >= len(strangers) > 0 and len(set(within.values())) == len(within):
        name, student = next(iter(within.items()))
        ending = PurePath(name).suffix
        return (
            f"{len(within)} of {len(strangers)} have more in their names than the student's identifier. Rename them: "
            f"{name!r} to {student + (ending if ending[1:].isalnum() else '')!r}, for example"
        )
    return (
        f"It has {_some(strangers)}; the roster has {_some(ids)}. Is this the right class? If a platform names its "
        "files otherwise, add its identifiers to roster.csv as a column (docs/submissions.md)"
    )


def _named_in(name: str, ids: Sequence[str]) -> str:
    """Return the one student whose identifier is in a name, between separators or at its ends; nothing if several."""
    around = re.compile(r"(?<![^\W_])({})(?![^\W_])".format("|".join(re.escape(student) for student in ids)))
    inside = set(around.findall(PurePath(name).stem))
    return inside.pop() if len(inside) == 1 else ""


def _inside(root: Path) -> list[str]:
    """Return the names in a folder that is alone in another, as around a zip."""
    names, inner = list[str](), only_folder(root)
    for _ in range(DEEPEST):
        if inner is not None:
            names += [path.name for path in inner.iterdir()]
            inner = only_folder(inner)
    return names


def _alike(strangers: Sequence[str], ids: Sequence[str]) -> dict[str, str]:
    """Return the students who are called as strangers are but for what a spreadsheet changes, with those names."""
    called = {_bare(form): form for name in strangers for form in (PurePath(name).stem, name)}
    return {student: called[_bare(student)] for student in ids if _bare(student) in called}


def _as_before(alike: Mapping[str, str]) -> str:
    return (
        f"{SPREADSHEET} Write the identifiers into roster.csv as they were when the notebooks were generated: "
        f"{_mapping(alike)}."
    )


def read_some(
    assignment: Assignment, found: Mapping[str, StudentFiles], ids: Sequence[str]
) -> Iterator[tuple[str, Submission]]:
    """Yield what some students handed in, where it is a notebook of usual size: no other file is opened here."""
    there = [student for student in ids if student in found and found[student].files]
    for student in there[:: -(-len(there) // LOOKED_AT) or 1]:
        file = found[student].files[0]
        try:
            if file.suffix == ".ipynb" and file.stat().st_size <= LARGEST:
                yield student, read_submission(file, assignment.key)
        except Exception:  # noqa: S112 - it is told of this student when it is graded
            continue


def _bare(identifier: str) -> str:
    """Return an identifier without what spreadsheets and systems change."""
    return re.sub(r"(?<!\d)0+(?=\d)", "", unicodedata.normalize("NFKC", identifier).casefold())


def _mapping(alike: Mapping[str, Any]) -> str:
    pairs = [f"{now} → {before}" for now, before in list(alike.items())[:SHOWN]]
    return ", ".join(pairs) + (f" and {len(alike) - SHOWN} more" if len(alike) > SHOWN else "")


def _some(names: Sequence[str]) -> str:
    return ", ".join(map(repr, names[:SHOWN])) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
