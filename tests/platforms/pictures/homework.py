"""The assignment in the pictures: three questions on two arms."""

from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS

KEY = "homework6"
SECRET = "0123456789abcdef"
ADA, HENRI = Student("ada", "Ada Lovelace", "ada@example.org"), Student("henri", "Henri Poincaré", "henri@example.org")
TOML = f"""title = "Homework 6"
key = "{KEY}"
hints = true

[[problem]]
family = "planar-2r"
variation = "lengths"
questions = ["jacobian", "determinant"]
points = [2, 1]

[[problem]]
family = "elbow-3r"
variation = "lengths"
questions = ["axis-choice"]
points = [1]
"""


def make_assignment(folder: Path) -> Assignment:
    init_assignment(folder, "Homework 6", KEY, (ADA, HENRI), SECRET, problem_set=SETS[DEFAULT_SET])
    (folder / "assignment.toml").write_text(TOML, encoding="utf-8")
    return load_assignment(folder)
