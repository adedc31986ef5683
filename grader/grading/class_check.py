"""Detect inputs that don't fit together, and report the likely cause, before anything is graded or written.

An identifier is respelled if a program, such as a spreadsheet, changed its leading zeros, its case or its encoding. For
example, 007 becomes 7.
"""

import math
import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePath

from qdot.exercises.assignment.assignment import SECRET_FILE, SECRET_VARIABLE, Assignment, load_assignment
from qdot.exercises.assignment.release import make_notebook_path
from qdot.exercises.common.errors import QdotError, count_noun, write_first
from qdot.grader.grading.certify import find_former_students
from qdot.grader.submissions.layouts import list_nested_folders
from qdot.grader.submissions.submission import StudentFiles, Submission, SubmissionFolder, read_submission

SAMPLE_SIZE = 25
"""Maximum number of students whose notebooks are inspected; these students are spread over the roster."""
MAX_FILE_SIZE = 1_000_000
"""Maximum size in bytes of an inspected notebook. A larger notebook may be malicious, so it is not inspected."""
MAX_NAMES_LISTED = 5
"""Maximum number of names listed in a message."""


def load_class(folder: Path) -> Assignment:
    """Return the assignment in a folder. Raises QdotError if the released notebooks don't fit its roster or secret."""
    assignment = load_assignment(folder)
    paths = {student.id: make_notebook_path(assignment, student.id) for student in assignment.roster}
    released_files = {student: StudentFiles((path,)) for student, path in paths.items() if path.exists()}
    unreleased_students = [name for name in paths if name not in released_files]
    if respelled_ids := _match_respelled_identifiers(find_former_students(assignment), unreleased_students):
        students = count_noun(len(respelled_ids), "student")
        obstacle = f"{students} would get different problems from those in {folder / 'released'}, so qdot stopped"
        raise QdotError(f"{folder / 'roster.csv'}: {obstacle}. {_advise_restoring(respelled_ids)}")
    submissions = [submission for _, submission in read_sample(assignment, released_files, list(paths))]
    remedy = ", or delete this folder if no student has these notebooks"
    check_secret(assignment, submissions, folder / "released", remedy)
    return assignment


def check_class(
    assignment: Assignment, submissions: SubmissionFolder, submissions_folder: Path, named_path: Path
) -> None:
    """Raise QdotError if files belong to no student, or if most notebooks name another assignment, student or secret.

    `submissions_folder` is the folder that contains the submissions. `named_path` is the path that the user entered: a
    folder or a zip file.
    """
    ids = [student.id for student in assignment.roster]
    unknown_names = submissions.not_on_roster
    if unknown_names and not submissions.by_student:
        _, *nested_folders = list_nested_folders(submissions_folder)  # archives often contain such folders
        names = [*unknown_names, *(path.name for folder in nested_folders for path in folder.iterdir())]
        obstacle = "no file or folder here belongs to a student in roster.csv, so nothing was graded"
        raise QdotError(f"{named_path}: {obstacle}. {_describe_likely_cause(names, ids, assignment.key)}")
    absent_students = [student for student in ids if student not in submissions.by_student]
    if respelled_ids := _match_respelled_identifiers(unknown_names, absent_students):
        students = count_noun(len(respelled_ids), "student")
        obstacle = f"the submissions of {students} don't match the roster, so nothing was graded"
        raise QdotError(f"{named_path}: {obstacle}. {_advise_restoring(respelled_ids)}")
    sample = dict(read_sample(assignment, submissions.by_student, ids))
    other_keys = [key for key in _map_claims(sample, "assignment").values() if key != assignment.key]
    if 2 * len(other_keys) > len(sample) > 1:
        difference = f"another assignment ({_write_names(sorted(set(other_keys)))}), not to {assignment.key!r}"
        obstacle = f"{len(other_keys)} of {len(sample)} notebooks belong to {difference}, so nothing was graded"
        raise QdotError(f"{named_path}: {obstacle}. Is this the right folder?")
    owners = {student: owner for student, owner in _map_claims(sample, "student").items() if owner != student}
    if len(owners) > 1 and 2 * len(owners) > len(sample):
        pairs = [f"{student} has the notebook of {owner}" for student, owner in owners.items()]
        listing = write_first(pairs, MAX_NAMES_LISTED)
        obstacle = f"{len(owners)} of {len(sample)} notebooks are in folders or under names of other students"
        advice = "Is this the right class? If notebooks were mixed up, move each one back to its own student"
        if all(_normalize(student) == _normalize(owner) for student, owner in owners.items()):
            advice = _advise_restoring(owners)
        raise QdotError(f"{named_path}: {obstacle} ({listing}), so nothing was graded. {advice}")
    check_secret(assignment, list(sample.values()), named_path)


def _map_claims(sample: Mapping[str, Submission], claim_name: str) -> dict[str, str]:
    """Map each student to the text that the metadata of the student's notebook contain under a key, if it is a text."""
    claims = {student: submission.qdot_metadata.get(claim_name) for student, submission in sample.items()}
    return {student: claim for student, claim in claims.items() if isinstance(claim, str)}


def check_secret(assignment: Assignment, submissions: Sequence[Submission], path: Path, remedy: str = "") -> None:
    """Raise QdotError if most notebooks were generated with a different secret, so their problems differ.

    `path` is where the notebooks are. The message ends with `remedy`, an additional suggestion.
    """
    claims = [
        claim for submission in submissions if isinstance(claim := submission.qdot_metadata.get("secret_digest"), str)
    ]
    wrong_count = sum(claim != assignment.secret_digest for claim in claims)
    if 2 * wrong_count > len(claims):
        source = assignment.folder / SECRET_FILE
        source_name = str(source) if source.exists() else f"${SECRET_VARIABLE}"
        notebooks = "the notebook was" if len(claims) == 1 else f"{wrong_count} of {len(claims)} notebooks were"
        raise QdotError(
            f"{path}: {notebooks} generated with a different secret from the one in {source_name}. qdot stopped, "
            "because it would grade problems that the students never saw. Restore the secret with which the notebooks "
            f"were generated{remedy}"
        )


SPREADSHEET_HINT = "The identifiers differ in leading zeros, case or encoding of letters; spreadsheets remove zeros."


def _describe_likely_cause(unknown_names: Sequence[str], ids: Sequence[str], assignment_key: str) -> str:
    """Return the likely cause, with advice, if no file belongs to a student of the roster `ids`.

    `unknown_names` are the names of these files and folders.
    """
    if respelled_ids := _match_respelled_identifiers(unknown_names, ids):
        return _advise_restoring(respelled_ids)
    name = f"{assignment_key}.ipynb"
    if name in unknown_names:
        return f"{name} does not name its student. Put it into a folder named after the student: STUDENT/{name}"
    return (
        f"It contains {_write_names(unknown_names)}; the roster has {_write_names(ids)}. Is this the right class? "
        "Unpack archives first, and name each file or folder after its student, as in STUDENT.ipynb. If a platform "
        "uses other identifiers, add them to roster.csv as a column (docs/submissions.md)"
    )


def _match_respelled_identifiers(unknown_names: Sequence[str], ids: Sequence[str]) -> dict[str, str]:
    """Return a mapping from each student whose identifier is respelled to the name of the matching file."""
    names = {_normalize(text): text for name in unknown_names for text in (PurePath(name).stem, name)}
    return {student: names[_normalize(student)] for student in ids if _normalize(student) in names}


def _advise_restoring(respelled_ids: Mapping[str, str]) -> str:
    """Return the advice to undo changes of identifiers; `respelled_ids` maps present to original identifiers."""
    pairs = [f"{new_name} → {old_name}" for new_name, old_name in respelled_ids.items()]
    remedy = "Write the identifiers into roster.csv as they were when the notebooks were generated"
    return f"{SPREADSHEET_HINT} {remedy}: {write_first(pairs, MAX_NAMES_LISTED)}."


def read_sample(
    assignment: Assignment, files: Mapping[str, StudentFiles], ids: Sequence[str]
) -> Iterator[tuple[str, Submission]]:
    """Yield pairs of a student and a notebook for a sample of students. Large files are skipped without opening them.

    `files` maps students to their files, and `ids` are the students in the order of the roster.
    """
    students = [student for student in ids if student in files and files[student].files]
    for student in students[:: math.ceil(len(students) / SAMPLE_SIZE) or 1]:
        file = files[student].files[0]
        with suppress(Exception):  # the error is reported when this student is graded
            if file.suffix == ".ipynb" and file.stat().st_size <= MAX_FILE_SIZE:
                yield student, read_submission(file, assignment.key)


def _normalize(identifier: str) -> str:
    """Return an identifier without what spreadsheets and systems change: leading zeros, case, encoding of letters."""
    return re.sub(r"(?<!\d)0+(?=\d)", "", unicodedata.normalize("NFKC", identifier).casefold())


def _write_names(names: Sequence[str]) -> str:
    """Return the first few names, in quotes."""
    return write_first(list(map(repr, names)), MAX_NAMES_LISTED)
