"""Measure the cost of generating: one student of a class, one record of the site, one family's first problem."""

import sys
import tempfile
import time
from pathlib import Path

from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import ProblemId

from .clock import processor_time

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


def generating(folder: Path, more: int, is_custom: bool = False) -> float:
    """Return the seconds for each student more: a class of two beside one with so many more, structures all met.

    With `is_custom`, the questions are an instructor's own.
    """
    return (_class(folder / "large", 2 + more, is_custom) - _class(folder / "small", 2, is_custom)) / more


def _class(folder: Path, students: int, is_custom: bool) -> float:
    command = [sys.executable, "-m", "qdot"]
    roster = folder.with_suffix(".csv")
    roster.parent.mkdir(parents=True, exist_ok=True)
    roster.write_text("student,name,email\n" + "".join(f"s{n:05d},,\n" for n in range(students)), encoding="utf-8")
    processor_time([*command, "init", str(folder), "--key", "bench"], folder.parent)
    (folder / "roster.csv").write_bytes(roster.read_bytes())
    (folder / "secret.txt").write_text("5" * 64 + "\n", encoding="utf-8")  # all classes have the same arms
    file = folder / "assignment.toml"
    head = file.read_text("utf-8").split("\n[[problem]]")[0]
    slot, questions = (CUSTOM_SLOT, CUSTOM_QUESTIONS) if is_custom else (SLOT, "")
    file.write_text(head + questions + "".join(map(slot.format, MIXED)), encoding="utf-8")
    return processor_time([*command, "generate", str(folder), "--jobs", "1"], folder.parent)


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
