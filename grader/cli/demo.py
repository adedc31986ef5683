"""`qdot demo`: run the commands of an instructor on a simulated class of 30.

The simulated students submit correct answers, common mistakes and broken files.
"""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import nbformat
import typer

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.common.console import note, print_result
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.cli.class_commands import generate
from qdot.grader.cli.export_commands import report
from qdot.grader.cli.grade_command import grade
from qdot.grader.cli.options import JobsOption
from qdot.grader.grading.history import read_results_to_report
from qdot.grader.reports.grades_table import find_work_status, has_points
from qdot.grader.sandbox.sandbox import check_system

TITLE, KEY = "Velocity kinematics, demonstration", "velocity"
SECRET = "a demonstration needs no secret, so that it shows the same class everywhere"  # noqa: S105
NOTEBOOK_SECONDS = 10.0
"""Maximum processor time of a notebook; the demo does not wait longer for the endless loop of one student."""

NAMES = (
    "Ada Lovelace", "Blaise Pascal", "Chen Jingrun", "Dorothy Vaughan", "Emmy Noether", "Felix Klein",
    "Grace Hopper", "Henri Poincaré", "Ingrid Daubechies", "Jacques Denavit", "Katherine Johnson", "Leonhard Euler",
    "Maryam Mirzakhani", "Niels Abel", "Olga Ladyzhenskaya", "Paul Erdős", "Qin Jiushao", "Richard Hartenberg",
    "Sofja Kowalewskaja", "Terence Tao", "Uta Merzbach", "Vera Rubin", "William Hamilton", "Xu Guangqi",
    "Yutaka Taniyama", "Zu Chongzhi", "Arthur Cayley", "Bernhard Riemann", "Carl Jacobi", "David Hilbert",
)  # fmt: skip

Edit = Callable[[str, Part], str]
"""A function that returns a student's answer to a part as Python code, given the code of the reference answer."""


def _is_symbolic(part: Part) -> bool:
    return bool(part.answer.list_entries())


def _expand(code: str, part: Part) -> str:
    """Return the answer in another correct form, by applying the angle-sum identities."""
    if not _is_symbolic(part):
        return code
    if code.startswith("Matrix"):
        return f"{code}.applyfunc(lambda entry: entry.expand(trig=True))"
    return f"({code}).expand(trig=True)"


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


def _leave_half_blank(code: str, part: Part) -> str:
    """Leave the parts whose names have an even number of letters blank; they are about half of the parts."""
    if len(part.name) % 2:
        return code
    return '"blank"' if part.answer.offered_options else "blank"


EDITS: dict[str, Edit] = {
    "right": lambda code, _: code, "right, in another form": _expand, "wrong sign throughout": _negate,
    "relative for absolute angles": _use_relative_angles, "matrices transposed": _transpose,
    "joint 2 forgotten": _forget_joint_2, "degrees for radians": _use_degrees,
    # This forgets theta2 = pi, for example, or the shoulder singularity.
    "only the first condition": lambda code, part: f"{code}[:1]" if part.answer.is_set else code,
    "half of the answer": _leave_half_blank,
    "a cell with an error": lambda code, part: "1/0" if part.name in ("jacobian", "geometric-jacobian") else code,
    # `iter(int, 1)` yields zeros forever.
    "an endless loop": lambda code, part: f"[{code} for _ in iter(int, 1)][0]" if part.name == "determinant" else code,
}  # fmt: skip
"""The kinds of submission with edited answers, each with its edit."""

UNEDITED_KINDS = ("blank", "cut off", "another assignment", "never submitted")
"""The kinds of submission in which no answer is edited."""

KIND_BY_NAME = dict(zip(NAMES, (*EDITS, *UNEDITED_KINDS, *("right, in another form", "right") * 8), strict=False))
"""The kind of submission of each student: one of each kind, then correct answers in one of two forms."""


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder for the demo.")] = Path("qdot-demo"),
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Run everything on a simulated class of 30.

    Creates an assignment folder, generates notebooks, submits right, wrong, blank and broken ones, and grades them.

    Examples:
      qdot demo
          a class of 30, from problems to feedback, in qdot-demo
    """
    check_system()
    if folder.is_file() or (folder.exists() and any(folder.iterdir())):
        _check_is_demo(folder)
    else:
        students = [Student(f"s{i:03d}", name, f"s{i:03d}@example.org") for i, name in enumerate(NAMES, 1)]
        init_assignment(folder, TITLE, KEY, students, SECRET)
    generate(folder, jobs)
    assignment = load_assignment(folder)
    for student in assignment.roster:
        write_submission(assignment, student.id, KIND_BY_NAME[student.name])
    grade(folder, jobs=jobs, seconds=NOTEBOOK_SECONDS)
    _, results = read_results_to_report(assignment)
    scores = [f"{result.score:.1f} of {result.max_score:g}" if has_points(result) else "no mark" for result in results]
    width = max(map(len, scores))
    print_result(f"\n{'id':<4}  {'name':<20} {'submitted':<32} {'points':>{width}}  status")
    for student, score, result in zip(assignment.roster, scores, results, strict=True):
        kind, status = KIND_BY_NAME[student.name], find_work_status(result)
        print_result(f"{student.id:<4}  {student.name:<20} {kind:<32} {score:>{width}}  {status}")
    example = next(student.id for student in assignment.roster if KIND_BY_NAME[student.name] == "half of the answer")
    print_result(f"\na feedback page: {folder / 'graded' / 'feedback' / f'{example}.html'}")
    report(folder)


def _check_is_demo(folder: Path) -> None:
    """Raise QdotError if an existing folder is not one that `qdot demo` made."""
    try:
        is_demo = load_assignment(folder).title == TITLE
    except QdotError:
        is_demo = False
    if not is_demo:
        raise QdotError(f"{folder} already exists and is not a qdot demonstration; choose another folder")
    note(f"{folder} already exists; continuing with it")


def write_submission(assignment: Assignment, student: str, submission_kind: str) -> None:
    """Write a submission of this kind for a student, made from the student's released notebook."""
    released_path = assignment.folder / "released" / student / f"{assignment.key}.ipynb"
    text = released_path.read_text(encoding="utf-8")
    target = assignment.folder / "submitted" / student / f"{assignment.key}.ipynb"
    if submission_kind in EDITS:
        text = fill_in_answers(text, assignment.generate_problems(student), EDITS[submission_kind])
    elif submission_kind == "cut off":
        text = text[: len(text) // 2]
    elif submission_kind == "another assignment":
        text = text.replace(f'"assignment": "{assignment.key}"', '"assignment": "trajectories"')
    if submission_kind != "never submitted":
        write_atomically(target, text)


def fill_in_answers(text: str, problems: Sequence[tuple[str, Problem]], edit: Edit) -> str:
    """Return a student's notebook with the reference answers, changed by `edit`, in its answer cells."""
    parts = {f"{slot}.{part.name}": part for slot, problem in problems for part in problem.parts}
    notebook = nbformat.reads(text, as_version=4)
    for cell in notebook.cells:
        name = cell.metadata.get("qdot", {}).get("part")
        if name in parts:
            variable = cell.source.split("=", 1)[0]
            cell.source = f"{variable}= {edit(parts[name].answer.write_code(), parts[name])}"
    return json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
