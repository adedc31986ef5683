"""Detect inputs that don't fit together, and report the likely cause, before anything is graded or written."""

import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePath

from qdot.exercises.assignment.assignment import SECRET_FILE, SECRET_VARIABLE, Assignment, load_assignment
from qdot.exercises.assignment.release import notebook_path
from qdot.exercises.common.errors import QdotError, count_noun, list_some
from qdot.grader.grading.certify import find_former_students
from qdot.grader.submissions.layouts import list_nested_folders
from qdot.grader.submissions.submission import StudentFiles, Submission, SubmissionFolder, read_submission

SAMPLE_SIZE = 25
"""Maximum number of students whose notebooks are inspected; they are spread over the roster."""
MAX_FILE_SIZE = 1_000_000
"""Maximum size in bytes of an inspected notebook; larger ones may be malicious, and are read only by graders."""
ARCHIVE_ENDINGS = (".zip", ".tar", ".tgz", ".tar.gz", ".7z", ".rar")
"""File endings of archives."""
MAX_NAMES_LISTED = 5
"""Maximum number of names listed in a message."""


def load_class(folder: Path) -> Assignment:
    """Return an assignment. Raises QdotError if its roster or secret doesn't match the notebooks in released/."""
    assignment = load_assignment(folder)
    paths = {student.id: notebook_path(assignment, student.id) for student in assignment.roster}
    released_files = {student: StudentFiles((path,)) for student, path in paths.items() if path.exists()}
    unreleased = [name for name in paths if name not in released_files]
    if respelled := _match_respelled_identifiers(find_former_students(assignment), unreleased):
        students = count_noun(len(respelled), "student")
        raise QdotError(
            f"{folder / 'roster.csv'}: {students} would get other problems than those in {folder / 'released'}, so "
            f"qdot stopped. {_advise_restoring(respelled)}"
        )
    submissions = [submission for _, submission in read_sample(assignment, released_files, list(paths))]
    remedy = ", or delete this folder if no student has these notebooks"
    check_secret(assignment, submissions, folder / "released", remedy)
    return assignment


def check_class(
    assignment: Assignment, submissions: SubmissionFolder, submissions_folder: Path, named_path: Path
) -> None:
    """Raise QdotError if files belong to no student, or if most notebooks name another assignment, student or secret.

    `submissions_folder` is the folder that contains the submissions; `named_path` is the folder or zip file that the
    user named.
    """
    ids = [student.id for student in assignment.roster]
    unknown_names = submissions.not_on_roster
    if unknown_names and not submissions.by_student:
        _, *nested_folders = list_nested_folders(submissions_folder)  # archives often contain such folders
        names = [*unknown_names, *(path.name for folder in nested_folders for path in folder.iterdir())]
        problem = "no file or folder here belongs to a student in roster.csv, so nothing was graded"
        raise QdotError(f"{named_path}: {problem}. {_describe_likely_cause(names, ids, assignment.key)}")
    absent_students = [student for student in ids if student not in submissions.by_student]
    if respelled := _match_respelled_identifiers(unknown_names, absent_students):
        problem = f"submissions of {count_noun(len(respelled), 'student')} would have no owner, so nothing was graded"
        raise QdotError(f"{named_path}: {problem}. {_advise_restoring(respelled)}")
    sample = dict(read_sample(assignment, submissions.by_student, ids))
    keys = [key for key in _claims_by_student(sample, "assignment").values() if key != assignment.key]
    if 2 * len(keys) > len(sample) > 1:
        subject = f"another assignment ({_list_names(sorted(set(keys)))}) than {assignment.key!r}"
        raise QdotError(
            f"{named_path}: {len(keys)} of {len(sample)} notebooks belong to {subject}, so nothing was graded. Is this "
            "the right folder?"
        )
    owners = {student: owner for student, owner in _claims_by_student(sample, "student").items() if owner != student}
    if len(owners) > 1 and 2 * len(owners) > len(sample):
        raise QdotError(f"{named_path}: {len(owners)} of {len(sample)} notebooks {_describe_mixed_up(owners, ids)}")
    check_secret(assignment, list(sample.values()), named_path)


def _claims_by_student(sample: Mapping[str, Submission], claim_name: str) -> dict[str, str]:
    """Return the texts that the notebooks' metadata contain under a key, by the student who submitted the notebook."""
    claims = {student: submission.qdot_metadata.get(claim_name) for student, submission in sample.items()}
    return {student: claim for student, claim in claims.items() if isinstance(claim, str)}


def check_secret(assignment: Assignment, submissions: Sequence[Submission], path: Path, remedy: str = "") -> None:
    """Raise QdotError if most notebooks were generated with another secret, so that their problems differ.

    The message ends with `remedy`, an additional suggestion.
    """
    marks = [claim for submission in submissions if isinstance(claim := submission.qdot_metadata.get("secret"), str)]
    wrong = sum(mark != assignment.secret_digest for mark in marks)
    if 2 * wrong > len(marks):
        source = assignment.folder / SECRET_FILE
        source_name = str(source) if source.exists() else f"${SECRET_VARIABLE}"
        notebooks = "the notebook was" if len(marks) == 1 else f"{wrong} of {len(marks)} notebooks were"
        raise QdotError(
            f"{path}: {notebooks} generated with another secret than that in {source_name}. qdot stopped, because it "
            "would grade problems that the students never saw. Restore the secret with which the notebooks were "
            f"generated{remedy}"
        )


def _describe_mixed_up(owners: Mapping[str, str], ids: Sequence[str]) -> str:
    """Return the message on notebooks that other students than their owners submitted, with advice."""
    respelled = {student: owner for student, owner in owners.items() if _normalize(student) == _normalize(owner)}
    if len(respelled) < len(owners) and set(owners.values()) <= set(ids):
        pairs = [f"{student} has the notebook of {owner}" for student, owner in owners.items()]
        return (
            f"are in folders or under names of other students ({list_some(pairs, MAX_NAMES_LISTED)}), so nothing was "
            "graded. Were folders or files renamed or mixed up? Move each notebook back to its own student"
        )
    cause = "Is this the right class and the right folder?"
    if len(respelled) == len(owners):
        cause = _advise_restoring(respelled)
    return f"name other students than the folders and files that contain them, so nothing was graded. {cause}"


SPREADSHEET_HINT = "The identifiers differ in leading zeros, case or encoding of letters; spreadsheets remove zeros."


def _describe_likely_cause(strangers: Sequence[str], ids: Sequence[str], assignment_key: str) -> str:
    """Return the likely cause of files that belong to no student, with advice."""
    if respelled := _match_respelled_identifiers(strangers, ids):
        return _advise_restoring(respelled)
    if f"{assignment_key}.ipynb" in strangers:
        name = f"{assignment_key}.ipynb"
        return f"{name} does not name its student. Put it into a folder named after the student: STUDENT/{name}"
    archives = [name for name in strangers if name.lower().endswith(ARCHIVE_ENDINGS)]
    if archives and 2 * len(archives) >= len(strangers):
        return f"qdot opens an archive only if its name is that of a student. Unpack {_list_names(archives)} first"
    matches = {name: student for name in strangers if (student := _find_student_in_name(name, ids))}
    if 2 * len(matches) >= len(strangers) > 0 and len(set(matches.values())) == len(matches):
        name, student = next(iter(matches.items()))
        ending = PurePath(name).suffix if PurePath(name).suffix[1:].isalnum() else ""
        return (
            f"{len(matches)} of {len(strangers)} names contain more than the student's identifier. Rename them, for "
            f"example {name!r} to {student + ending!r}"
        )
    return (
        f"It contains {_list_names(strangers)}; the roster has {_list_names(ids)}. Is this the right class? If a "
        "platform uses other identifiers, add them to roster.csv as a column (docs/submissions.md)"
    )


def _find_student_in_name(name: str, ids: Sequence[str]) -> str:
    """Return the student whose identifier is a separate word in a file's name; "" if there are none or several."""
    pattern = re.compile(r"(?<![^\W_])({})(?![^\W_])".format("|".join(re.escape(student) for student in ids)))
    students = set(pattern.findall(PurePath(name).stem))
    return students.pop() if len(students) == 1 else ""


def _match_respelled_identifiers(strangers: Sequence[str], ids: Sequence[str]) -> dict[str, str]:
    """Return a mapping from each student with a respelled identifier to the matching file name.

    A spreadsheet may have changed the spelling.
    """
    names = {_normalize(form): form for name in strangers for form in (PurePath(name).stem, name)}
    return {student: names[_normalize(student)] for student in ids if _normalize(student) in names}


def _advise_restoring(renamed: Mapping[str, str]) -> str:
    return (
        f"{SPREADSHEET_HINT} Write the identifiers into roster.csv as they were when the notebooks were generated: "
        f"{list_some([f'{new_name} → {old_name}' for new_name, old_name in renamed.items()], MAX_NAMES_LISTED)}."
    )


def read_sample(
    assignment: Assignment, files: Mapping[str, StudentFiles], ids: Sequence[str]
) -> Iterator[tuple[str, Submission]]:
    """Yield the notebooks of a sample of students; unusually large files are skipped without opening them."""
    students = [student for student in ids if student in files and files[student].files]
    for student in students[:: -(-len(students) // SAMPLE_SIZE) or 1]:
        file = files[student].files[0]
        with suppress(Exception):  # the error is reported when this student is graded
            if file.suffix == ".ipynb" and file.stat().st_size <= MAX_FILE_SIZE:
                yield student, read_submission(file, assignment.key)


def _normalize(identifier: str) -> str:
    """Normalize what spreadsheets and systems change in an identifier: leading zeros, case, encoding of letters."""
    return re.sub(r"(?<!\d)0+(?=\d)", "", unicodedata.normalize("NFKC", identifier).casefold())


def _list_names(names: Sequence[str]) -> str:
    return list_some(list(map(repr, names)), MAX_NAMES_LISTED)
