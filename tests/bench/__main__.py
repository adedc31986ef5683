"""`make bench`: what generating and grading a notebook costs, beside floors measured in the same run.

Floor of grading: the notebook's own cells, run in a process forked from one that has SymPy and NumPy loaded. Floor of
generating: writing the files. Times are medians in milliseconds; what counts are the ratios.
"""

import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from exercises.assignment import Assignment, Student, load_assignment
from exercises.problem import variable
from exercises.release import init_assignment, release_one
from grader.batch import grade_student
from grader.certify import certificate_text
from grader.demo import answered
from grader.sandbox import Sandbox
from grader.submission import Found, read_submission

STUDENTS = 12


def milliseconds(work: Callable[[], object]) -> float:
    """Return how long a call takes."""
    start = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - start)


def row(name: str, times: list[float], floor: float) -> None:
    """Print one line of the table."""
    middle = statistics.median(times)
    sys.stdout.write(f"{name:<46} {middle:9.1f} ms {middle / floor:8.1f} x floor\n")


def bench(folder: Path) -> None:
    """Make a class, hand in the solutions, and time each step per student."""
    students = [Student(f"s{i:03d}") for i in range(STUDENTS)]
    init_assignment(folder, "Bench", "bench", students, "a secret that is long enough")
    assignment = load_assignment(folder)
    generating = [milliseconds(lambda s=s: release_one((assignment, certificate_text), s.id)) for s in students]  # type: ignore[misc]
    files = [folder / kind / s.id / "bench.ipynb" for s in students for kind in ("released", "solutions")]
    writing = [milliseconds(lambda p=p: (folder / "floor").write_bytes(p.read_bytes())) for p in files]  # type: ignore[misc]
    row("generate: first student, structures derived", generating[:1], 2 * statistics.median(writing))
    row("generate: every other student", generating[1:], 2 * statistics.median(writing))
    for student in students:
        (folder / "in" / student.id).mkdir(parents=True)
        text = (folder / "released" / student.id / "bench.ipynb").read_text()
        solved = answered(text, assignment.problems(student.id), lambda code, _: code)
        (folder / "in" / student.id / "bench.ipynb").write_text(solved)
    with Sandbox() as sandbox:
        floors = [milliseconds(lambda s=s: cells_only(folder, assignment, s.id, sandbox)) for s in students]  # type: ignore[misc]
        floor = statistics.median(floors[1:])
        found = {s.id: Found((folder / "in" / s.id / "bench.ipynb",)) for s in students}
        grading = [milliseconds(lambda s=s: grade_student(assignment, s.id, found[s.id], sandbox)) for s in students]  # type: ignore[misc]
    row("floor: the notebook's own cells", floors[1:], floor)
    row("grade: regenerate, run, read, compare, mark", grading, floor)


def cells_only(folder: Path, assignment: Assignment, student: str, sandbox: Sandbox) -> None:
    """Run the cells of a submission and nothing else."""
    submission = read_submission(folder / "in" / student / "bench.ipynb")
    names = [variable(slot.name, question) for slot in assignment.slots for question in slot.questions]
    run = sandbox.run(submission.cells, names)
    assert len(run.answers) == len(names)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as made:
        bench(Path(made) / "class")
