"""`qdot demo`: the whole loop on a simulated class of 30: answers right, wrong in the usual ways, or broken."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import nbformat

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.draws import FailedSlot, raise_left_out
from qdot.exercises.assignment.release import ReleaseResult, init_assignment, release
from qdot.exercises.common.console import note, progress, say
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import explain_missing
from qdot.exercises.common.files import write_atomically
from qdot.exercises.problem.problem import Part, Problem
from qdot.grader.grading.batch import alone, grade_class
from qdot.grader.grading.certify import CERTIFIER, record_of
from qdot.grader.grading.result import Result
from qdot.grader.reports.formats import write_asked
from qdot.grader.reports.tables import status
from qdot.grader.reports.write import write_page, write_reports
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
"""Turns the right-hand side of a right answer into a student's, as Python text."""


def _right(code: str, part: Part) -> str:  # noqa: ARG001 - an edit takes both
    return code


def _symbolic(part: Part) -> bool:
    return bool(part.answer.entries())


def _mapped(code: str, function: str) -> str:
    return (
        f"Matrix([{code}]).applyfunc({function})" if not code.startswith("Matrix") else f"{code}.applyfunc({function})"
    )


def _expanded(code: str, part: Part) -> str:
    """Return the answer as another person would write it: sums of angles taken apart."""
    if not _symbolic(part) or not code.startswith("Matrix"):
        return f"({code}).expand(trig=True)" if _symbolic(part) else code
    return _mapped(code, "lambda entry: entry.expand(trig=True)")


def _sign(code: str, part: Part) -> str:
    if part.answer.offered:
        return '"A"'
    return code if part.answer.is_a_set else f"-({code})"


def _relative(code: str, part: Part) -> str:
    """Take relative angles for absolute ones: theta2 where theta1 + theta2 is due."""
    changes = "{theta1 + theta2 + theta3: theta3, theta1 + theta2: theta2, theta2 + theta3: theta3}"
    return f"({code}).subs({changes})" if _symbolic(part) else code


def _transposed(code: str, part: Part) -> str:
    return f"{code}.T" if _symbolic(part) and part.shape is not None and 1 not in part.shape else code


def _dropped(code: str, part: Part) -> str:
    """Forget what joint 2 adds to velocities: the derivative with respect to its variable is taken for zero."""
    if part.kind in ("joint-axes", "position-vectors"):
        return code
    if _symbolic(part) and part.shape is not None and part.shape[1] > 1:
        return f"{code} * Matrix.diag(*[0 if i == 1 else 1 for i in range({part.shape[1]})])"
    return f"({code}).subs(qd2, 0)" if _symbolic(part) else code


def _degrees(code: str, part: Part) -> str:
    """Give angles in degrees, and rates of joints that turn in degrees per second."""
    if part.answer.units_due:
        factors = ["180/pi" if unit == "rad/s" else "1" for unit in part.answer.units_due]
        return f"{code}.multiply_elementwise(Matrix([{', '.join(factors)}]))"
    return f"[one.subs(pi, 180) for one in {code}]" if part.answer.is_a_set else code


def _only_first(code: str, part: Part) -> str:
    """Find the first singular condition only, as who forgets pi, or the shoulder."""
    return f"{code}[:1]" if part.answer.is_a_set else code


def _half(code: str, part: Part) -> str:
    return code if len(part.name) % 2 else _blank(part)


def _blank(part: Part) -> str:
    return '"blank"' if part.answer.offered else "blank"


def _raises(code: str, part: Part) -> str:
    return "1/0" if part.name in ("jacobian", "geometric-jacobian") else code


def _nan(code: str, part: Part) -> str:
    return 'float("nan")' if part.name == "determinant" else code


def _loops(code: str, part: Part) -> str:
    return f"[{code} for _ in iter(int, 1)][0]" if part.name == "determinant" else code


def _unknown(code: str, part: Part) -> str:
    return f'({code}) * Symbol("k")' if _symbolic(part) else code


EDITS: Sequence[tuple[str, Edit]] = (
    ("right", _right), ("right, in another form", _expanded), ("a sign wrong throughout", _sign),
    ("relative for absolute angles", _relative), ("matrices transposed", _transposed),
    ("joint 2 forgotten", _dropped), ("degrees for radians", _degrees), ("first singular condition only", _only_first),
    ("half of it", _half), ("a cell that raises", _raises), ("nan", _nan), ("an endless loop", _loops),
    ("an unknown symbol", _unknown),
)  # fmt: skip

FILES = ("blank", "cut off", "another assignment", "never handed in")
"""What else happens to notebooks in a class."""

RIGHT = 13
"""So many students, beside the usual mistakes, have everything right, in one of two forms."""


def kinds() -> list[str]:
    """Return what becomes of each of the 30 students."""
    usual = [name for name, _ in EDITS] + list(FILES)
    return usual + ["right" if i % 2 else "right, in another form" for i in range(RIGHT)]


def run_demo(folder: Path, jobs: int) -> None:
    """Make a class in `folder`, hand in its notebooks, grade them, and say where to look."""
    students = [Student(f"s{i:03d}", name, f"s{i:03d}@example.org") for i, name in enumerate(NAMES, 1)]
    if folder.exists() and any(folder.iterdir()):
        _same_demo(folder)
    else:
        init_assignment(folder, TITLE, KEY, students, SECRET)
    assignment = load_assignment(folder)
    given_up: list[FailedSlot] = []
    with progress("generating", len(students)) as counter:

        def each(released: ReleaseResult) -> None:
            given_up.extend(released.given_up)
            counter.step()

        assignment = release(assignment, CERTIFIER, min(jobs, len(students)), each)
    with progress("handing in", len(students)) as counter:
        for student, kind in zip(assignment.roster, kinds(), strict=True):
            if student.id not in {given.student for given in given_up}:
                hand_in(assignment, student.id, kind)
            counter.step()
    submissions = find_submissions(assignment, folder / "submitted").by_student
    jobs = min(jobs, len(students))
    with alone(assignment.folder):
        with progress("grading", len(students)) as counter:
            limits = Limits(cell_seconds=2)
            results = grade_class(
                assignment, submissions, jobs, limits, lambda _: counter.step(), write_page=write_page
            )
        with progress("writing feedback", len(students)) as counter:
            write_reports(assignment, results, jobs, counter.step)
    say(f"{'id':<4}  {'name':<20} {'handed in':<32} {'points':>{len(_score(results[0]))}}  status")
    for student, kind, result in zip(assignment.roster, kinds(), results, strict=True):
        say(f"{student.id:<4}  {student.name:<20} {kind:<32} {_score(result)}  {status(result)}")
    first = assignment.roster[0].id
    say("")
    say(f"a student's notebook   {folder / 'released' / first / f'{KEY}.ipynb'}")
    say(f"the staff's            {folder / 'solutions' / first / f'{KEY}.ipynb'}")
    say(f"a feedback page        {folder / 'graded' / 'feedback' / f'{assignment.roster[8].id}.html'}")
    say(f"grades                 {folder / 'graded' / 'grades.csv'}")
    _report(assignment, results)
    raise_left_out(assignment, given_up, record_of)


def _report(assignment: Assignment, results: Sequence[Result]) -> None:
    if said := explain_missing("report", "the report of the class", "matplotlib"):
        note(said)
        return
    path = assignment.folder / "graded" / "report.html"
    write_asked(assignment, results, [("html", str(path))])
    say(f"the class at a glance  {path}")


def _score(result: Result) -> str:
    return f"{result.score:5.1f} of {result.max_score:g}"


def _same_demo(folder: Path) -> None:
    try:
        same = load_assignment(folder).title == TITLE
    except QdotError:
        same = False
    if not same:
        raise QdotError(f"{folder} is there already and is not a demonstration of qdot's; name a new folder")
    note(f"{folder} is there already; going on with it")


def hand_in(assignment: Assignment, student: str, kind: str) -> None:
    """Write what a student of that kind hands in, made from the notebook that was handed out."""
    released = assignment.folder / "released" / student / f"{assignment.key}.ipynb"
    text = released.read_text(encoding="utf-8")
    target = assignment.folder / "submitted" / student / f"{assignment.key}.ipynb"
    edits = dict(EDITS)
    if kind in edits:
        text = answered(text, assignment.problems(student), edits[kind])
    elif kind == "cut off":
        text = text[: len(text) // 2]
    elif kind == "another assignment":
        text = text.replace(f'"assignment": "{assignment.key}"', '"assignment": "trajectories"')
    if kind != "never handed in":
        write_atomically(target, text)


def answered(text: str, problems: Sequence[tuple[str, Problem]], edit: Edit) -> str:
    """Return the student's notebook with every answer cell filled in from the reference, through `edit`."""
    parts: Mapping[str, Part] = {f"{slot}.{part.name}": part for slot, problem in problems for part in problem.parts}
    notebook = nbformat.reads(text, as_version=4)
    for cell in notebook.cells:
        name = cell.metadata.get("qdot", {}).get("part")
        if name in parts:
            left = cell.source.split("=", 1)[0]
            cell.source = f"{left}= {edit(parts[name].answer.code(), parts[name])}"
    return json.dumps(notebook, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
