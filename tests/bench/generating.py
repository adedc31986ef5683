"""Measure the cost of generating: one student of a class, one record of the site, one family's first problem."""

import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.assignment.release import ReleaseContext, release_notebooks_of_student
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import ProblemId
from qdot.grader.grading.certify import CERTIFIER

from .clock import processor_time

QDOT = (sys.executable, "-m", "qdot")
MIXED = ("planar-2r", "polar-rp", "planar-pr", "cylindrical", "elbow-3r")
"""The families of a class's five problems. Each problem has five questions."""
OF_SITE = ("planar-2r", "polar-rp")
"""The families of the site's records."""
SLOT = """
[[problem]]
family = "{}"
questions = ["position", "jacobian", "determinant", "inverse-velocity", "singular-angles"]
"""
CUSTOM_QUESTIONS = """
[question.middle]
prompt = "Find the velocity of the middle of link 2."
answer = "ddt((o1 + o2)/2)"
[question.rate-of-p]
prompt = "Find the velocity of $P$."
answer = "v"
[question.tip]
prompt = "At {pose} and {rates}, how fast is $P$?"
given = ["pose", "rates"]
answer = "norm(v)"
unit = "m/s"
[question.load]
prompt = "Which torques hold the force $(F, m g, F)$ at $P$?"
answer = "transpose(Jv)*[F, m*g, F]"
units = {m = "kg", g = "m/s^2", F = "N"}
[question.where]
prompt = "Where is the arm singular?"
answer = "zeros(det(J))"
"""
CUSTOM_SLOT = """
[[problem]]
family = "{}"
questions = ["middle", "rate-of-p", "tip", "load", "where"]
"""
RECORDS = """
import sys
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.verify.certificate import certify
from qdot.exercises.generation import generate
from qdot.exercises.site.record import make_site_record, make_solutions_record, translate_record, translate_solutions
families, first, last = sys.argv[1].split(","), int(sys.argv[2]), int(sys.argv[3])
for seed in range(first, last):
    for family in families:
        problem = generate(ProblemId(family, seed))
        certify(problem)
        record = make_site_record(problem)
        make_solutions_record(problem), translate_record(problem, record, "de"), translate_solutions(problem, "de")
"""


def generating(folder: Path, more: int) -> float:
    """Return the seconds for each student more: a class of two beside one with so many more, structures all met."""
    small, large = _make_class(folder / "small", 2), _make_class(folder / "large", 2 + more)
    taken = [processor_time([*QDOT, "generate", str(path), "--jobs", "1"], folder) for path in (small, large)]
    return (taken[1] - taken[0]) / more


def compare_own_questions(folder: Path, more: int) -> tuple[float, float]:
    """Return the seconds for each student with an instructor's own questions, and with built-in ones.

    The classes have the same arms, and a process each. Their students take turns, so other work slows both.
    """
    contexts = [
        ReleaseContext(load_assignment(_make_class(folder / name, 2 + more, is_custom)), CERTIFIER)
        for name, is_custom in (("custom", True), ("built-in", False))
    ]
    seconds = [0.0, 0.0]
    with ProcessPoolExecutor(1) as custom_process, ProcessPoolExecutor(1) as built_in_process:
        for number, student in enumerate(contexts[0].assignment.roster):
            for index, process in enumerate((custom_process, built_in_process)):
                taken = process.submit(_time_release, contexts[index], student.id).result()
                seconds[index] += taken / more if number >= 2 else 0
    return seconds[0], seconds[1]


def _time_release(context: ReleaseContext, student: str) -> float:
    start = time.process_time()
    release_notebooks_of_student(context, student)
    return time.process_time() - start


def _make_class(folder: Path, students: int, is_custom: bool = False) -> Path:
    folder.parent.mkdir(parents=True, exist_ok=True)
    processor_time([*QDOT, "init", str(folder), "--key", "bench"], folder.parent)
    roster = "student,name,email\n" + "".join(f"s{n:05d},,\n" for n in range(students))
    (folder / "roster.csv").write_text(roster, encoding="utf-8")
    (folder / "secret.txt").write_text("5" * 64 + "\n", encoding="utf-8")  # all classes have the same arms
    file = folder / "assignment.toml"
    head = file.read_text("utf-8").split("\n[[problem]]")[0]
    slot, questions = (CUSTOM_SLOT, CUSTOM_QUESTIONS) if is_custom else (SLOT, "")
    file.write_text(head + questions + "".join(map(slot.format, MIXED)), encoding="utf-8")
    return folder


def records(more: int) -> float:
    """Return the seconds for each record of the site more, every question asked, structures all met."""

    def taken(last: int) -> float:
        with tempfile.TemporaryDirectory() as folder:
            line = [sys.executable, "-c", RECORDS, ",".join(OF_SITE), "1", str(last)]
            return processor_time(line, Path(folder))

    return (taken(2 + more) - taken(2)) / (more * len(OF_SITE))


def first_problems() -> tuple[str, float]:
    """Return the family whose first problem of four questions takes longest, and the seconds; each family is new."""
    seconds = {}
    for name in FAMILIES:
        start = time.process_time()
        generate(ProblemId(name, 1, list_questions_of_family(name)[:4]))
        seconds[name] = time.process_time() - start
    slowest = max(seconds, key=lambda name: seconds[name])
    return slowest, seconds[slowest]
