"""`qdot demo`: runs all steps for a simulated class of 30, with correct answers, common mistakes and broken files."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import nbformat

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.certified_problems import FailedSlot, raise_failed_slots
from qdot.exercises.assignment.release import ReleaseResult, init_assignment, release_notebooks
from qdot.exercises.common.console import note, say, show_progress
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import explain_missing
from qdot.exercises.common.files import write_atomically
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.grading.batch import grade_class, lock_folder
from qdot.grader.grading.certify import CERTIFIER
from qdot.grader.grading.result import Result
from qdot.grader.reports.formats import write_requested_reports
from qdot.grader.reports.tables import work_status
from qdot.grader.reports.write import write_reports
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions

TITLE, KEY = "Velocity kinematics, demonstration", "velocity"
SECRET = "a demonstration needs no secret, so that it shows the same class everywhere"  # noqa: S105

NAMES = (
    "Ada Lovelace", "Blaise Pascal", "Chen Jingrun", "Dorothy Vaughan", "Emmy Noether", "Felix Klein",
    "Grace Hopper", "Henri Poincaré", "Ingrid Daubechies", "Jacques Denavit", "Katherine Johnson", "Leonhard Euler",
    "Maryam Mirzakhani", "Niels Abel", "Olga Ladyzhenskaya", "Paul Erdős", "Qin Jiushao", "Richard Hartenberg",
    "Sofja Kowalewskaja", "Terence Tao", "Uta Merzbach", "Vera Rubin", "William Hamilton", "Xu Guangqi",
    "Yutaka Taniyama", "Zu Chongzhi", "Arthur Cayley", "Bernhard Riemann", "Carl Jacobi", "David Hilbert",
)  # fmt: skip

Edit = Callable[[str, Part], str]
"""A function that returns the Python text of a student's answer, given the Python text of the reference answer."""


def _is_symbolic(part: Part) -> bool:
    return bool(part.answer.list_entries())


def _expand(code: str, part: Part) -> str:
    """Return the answer in another correct form: with the angle-sum identities applied."""
    if not _is_symbolic(part):
        return code
    is_matrix = code.startswith("Matrix")
    return f"{code}.applyfunc(lambda entry: entry.expand(trig=True))" if is_matrix else f"({code}).expand(trig=True)"


def _negate(code: str, part: Part) -> str:
    """Change the sign of a formula; choose option A if there are options."""
    if part.answer.offered_options:
        return '"A"'
    return code if part.answer.is_set else f"-({code})"


def _use_relative_angles(code: str, part: Part) -> str:
    """Use relative angles instead of absolute ones: theta2 instead of theta1 + theta2."""
    substitutions = "{theta1 + theta2 + theta3: theta3, theta1 + theta2: theta2, theta2 + theta3: theta3}"
    return f"({code}).subs({substitutions})" if _is_symbolic(part) else code


def _transpose(code: str, part: Part) -> str:
    return f"{code}.T" if _is_symbolic(part) and part.shape is not None and 1 not in part.shape else code


def _forget_joint_2(code: str, part: Part) -> str:
    """Omit the contribution of joint 2 to velocities, as if the derivative with respect to its variable were zero."""
    if not _is_symbolic(part) or part.kind in ("joint-axes", "position-vectors"):
        return code
    if part.shape is not None and part.shape[1] > 1:
        return f"{code} * Matrix.diag(*[0 if i == 1 else 1 for i in range({part.shape[1]})])"
    return f"({code}).subs(qd2, 0)"


def _use_degrees(code: str, part: Part) -> str:
    """Use degrees for angles, and degrees per second for the rates of revolute joints."""
    if part.answer.expected_units:
        factors = ["180/pi" if unit == "rad/s" else "1" for unit in part.answer.expected_units]
        return f"{code}.multiply_elementwise(Matrix([{', '.join(factors)}]))"
    return f"[condition.subs(pi, 180) for condition in {code}]" if part.answer.is_set else code


def _keep_first_condition(code: str, part: Part) -> str:
    """Keep only the first singular condition, like a student who forgets pi or the shoulder singularity."""
    return f"{code}[:1]" if part.answer.is_set else code


def _leave_half_blank(code: str, part: Part) -> str:
    return code if len(part.name) % 2 else '"blank"' if part.answer.offered_options else "blank"


def _raise_error(code: str, part: Part) -> str:
    return "1/0" if part.name in ("jacobian", "geometric-jacobian") else code


def _loop_forever(code: str, part: Part) -> str:
    return f"[{code} for _ in iter(int, 1)][0]" if part.name == "determinant" else code


EDITS: Sequence[tuple[str, Edit]] = (
    ("right", lambda code, _: code), ("right, in another form", _expand), ("wrong sign throughout", _negate),
    ("relative for absolute angles", _use_relative_angles), ("matrices transposed", _transpose),
    ("joint 2 forgotten", _forget_joint_2), ("degrees for radians", _use_degrees),
    ("only the first condition", _keep_first_condition), ("half of the answer", _leave_half_blank),
    ("a cell with an error", _raise_error), ("an endless loop", _loop_forever),
)  # fmt: skip

OTHER_SUBMISSION_KINDS = ("blank", "cut off", "another assignment", "never submitted")
"""The kinds of submission in which no answer is edited."""

EXTRA_CORRECT_STUDENTS = 15
"""Number of additional students whose answers are all correct, in one of two forms."""


def list_submission_kinds() -> list[str]:
    """Return the kind of submission of each of the 30 students."""
    one_of_each = [name for name, _ in EDITS] + list(OTHER_SUBMISSION_KINDS)
    return one_of_each + ["right" if i % 2 else "right, in another form" for i in range(EXTRA_CORRECT_STUDENTS)]


def run_demo(folder: Path, jobs: int) -> None:
    """Make a class in `folder`, submit notebooks for its students, grade them, and print where the results are."""
    students = [Student(f"s{i:03d}", name, f"s{i:03d}@example.org") for i, name in enumerate(NAMES, 1)]
    if folder.exists() and any(folder.iterdir()):
        _check_is_demo(folder)
    else:
        init_assignment(folder, TITLE, KEY, students, SECRET)
    assignment = load_assignment(folder)
    jobs = min(jobs, len(students))
    failed_slots: list[FailedSlot] = []
    with show_progress("generating", len(students)) as counter:

        def count_student(released: ReleaseResult) -> None:
            failed_slots.extend(released.failed_slots)
            counter.step()

        assignment = release_notebooks(assignment, CERTIFIER, jobs, count_student)
    raise_failed_slots(assignment, failed_slots)
    with show_progress("submitting", len(students)) as counter:
        for student, kind in zip(assignment.roster, list_submission_kinds(), strict=True):
            write_submission(assignment, student.id, kind)
            counter.step()
    submissions = find_submissions(assignment, folder / "submitted").by_student
    with lock_folder(assignment.folder):
        with show_progress("grading", len(students)) as counter:
            limits = Limits(cell_seconds=2)
            results = grade_class(assignment, submissions, jobs, limits, lambda _: counter.step())
        with show_progress("writing feedback", len(students)) as counter:
            write_reports(assignment, results, jobs, counter.step)
    say(f"{'id':<4}  {'name':<20} {'submitted':<32} {'points':>{len(_score(results[0]))}}  status")
    for student, kind, result in zip(assignment.roster, list_submission_kinds(), results, strict=True):
        say(f"{student.id:<4}  {student.name:<20} {kind:<32} {_score(result)}  {work_status(result)}")
    first_student = assignment.roster[0].id
    say("")
    say(f"a student's notebook   {folder / 'released' / first_student / f'{KEY}.ipynb'}")
    say(f"the staff's            {folder / 'solutions' / first_student / f'{KEY}.ipynb'}")
    say(f"a feedback page        {folder / 'graded' / 'feedback' / f'{assignment.roster[8].id}.html'}")
    say(f"grades                 {folder / 'graded' / 'grades.csv'}")
    if missing_message := explain_missing("report", "the report of the class", "matplotlib"):
        note(missing_message)
    else:
        write_requested_reports(assignment, results, [("html", str(folder / "graded" / "report.html"))])
        say(f"overview of the class  {folder / 'graded' / 'report.html'}")


def _score(result: Result) -> str:
    return f"{result.score:5.1f} of {result.max_score:g}"


def _check_is_demo(folder: Path) -> None:
    """Raise QdotError if an existing folder is not one that `qdot demo` made."""
    try:
        is_demo = load_assignment(folder).title == TITLE
    except QdotError:
        is_demo = False
    if not is_demo:
        raise QdotError(f"{folder} already exists and is not a qdot demonstration; choose another folder")
    note(f"{folder} already exists; continuing with it")


def write_submission(assignment: Assignment, student: str, kind: str) -> None:
    """Write the submission of this kind for a student, made from the student's released notebook."""
    released_path = assignment.folder / "released" / student / f"{assignment.key}.ipynb"
    text = released_path.read_text(encoding="utf-8")
    target = assignment.folder / "submitted" / student / f"{assignment.key}.ipynb"
    edits = dict(EDITS)
    if kind in edits:
        text = fill_in_answers(text, assignment.generate_problems(student), edits[kind])
    elif kind == "cut off":
        text = text[: len(text) // 2]
    elif kind == "another assignment":
        text = text.replace(f'"assignment": "{assignment.key}"', '"assignment": "trajectories"')
    if kind != "never submitted":
        write_atomically(target, text)


def fill_in_answers(text: str, problems: Sequence[tuple[str, Problem]], edit: Edit) -> str:
    """Return a student's notebook with the reference answers, changed by `edit`, in its answer cells."""
    parts: Mapping[str, Part] = {f"{slot}.{part.name}": part for slot, problem in problems for part in problem.parts}
    notebook = nbformat.reads(text, as_version=4)
    for cell in notebook.cells:
        name = cell.metadata.get("qdot", {}).get("part")
        if name in parts:
            variable = cell.source.split("=", 1)[0]
            cell.source = f"{variable}= {edit(parts[name].answer.write_code(), parts[name])}"
    return json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
