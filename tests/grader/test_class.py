"""A class, each with one planted mistake of a kind of their own: every one comes back with it named.

It is of two, in `make whole` of thirty.
"""

import json
from pathlib import Path
from typing import Any

import nbformat

from exercises.assignment import Assignment, Student, load_assignment
from exercises.problem import variable
from exercises.release import init_assignment
from grader.batch import grade_class
from grader.reports.feedback import feedback_page
from grader.sandbox import Limits
from grader.submission import find_submissions
from tests.support.suites import several
from tests.tools.diagnoses import Made, answers_with

TOML = """
title = "T"
key = "hw"
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "determinant", "inverse-jacobian", "joint-torques", "singular-angles"]
[[problem]]
family = "elbow-3r"
questions = ["position", "jacobian", "singular-angles", "singularity-type"]
[[problem]]
family = "polar-rp"
questions = ["joint-axes", "position-vectors", "geometric-jacobian", "twist", "joint-rates"]
"""
STUDENTS = [Student(f"s{k:02d}", f"Name {k}") for k in range(several(2, 30))]


def planted(assignment: Assignment) -> dict[str, tuple[str, Made]]:
    """Return a wrong answer for each student, with its place: a kind of mistake that nobody else made."""
    used: set[str] = set()
    found = {}
    for k, student in enumerate(assignment.roster):
        problems = assignment.problems(student.id)
        places = [(slot, problem, part) for slot, problem in problems for part in problem.parts]
        for slot, problem, part in places[k % len(places) :] + places:
            fresh = [one for one in answers_with(problem, part, 10) if one.mistake not in used and len(one.text) < 1500]
            if fresh:
                found[student.id] = (slot, fresh[0])
                used.add(fresh[0].mistake)
                break
    return found


def hand_in(assignment: Assignment, student: str, slot: str, one: Made) -> None:
    """Write a notebook of a student's own, without what `qdot generate` makes: that takes longer than all the rest."""
    problems = assignment.problems(student)
    symbols = " ".join(dict.fromkeys(name for _, problem in problems for name in problem.symbols()))
    cells = [f"from sympy import *\n{symbols.replace(' ', ', ')} = symbols({symbols!r})"]
    for name, problem in problems:
        for part in problem.parts:
            is_wrong = (name, part.name) == (slot, one.part.name)
            cells.append(f"{variable(name, part.name)} = {repr(one.text) if is_wrong else part.answer.code()}")
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    target = assignment.folder / "submitted" / student / "hw.ipynb"
    target.parent.mkdir(parents=True)
    target.write_text(json.dumps(notebook), encoding="utf-8")


def test_every_planted_mistake_comes_back_named(tmp_path: Path) -> None:
    folder = tmp_path / "hw"
    init_assignment(folder, "T", "hw", STUDENTS, secret="0123456789abcdef")
    (folder / "assignment.toml").write_text(TOML)
    assignment = load_assignment(folder)
    wrong = planted(assignment)
    assert len({one.mistake for _, one in wrong.values()}) == len(STUDENTS)
    for identifier, (slot, one) in wrong.items():
        hand_in(assignment, identifier, slot, one)
    found = find_submissions(assignment, folder / "submitted").found
    results = grade_class(assignment, found, 1, Limits(seconds=60, cell_seconds=10), lambda _: None)
    named = 0
    for student, result in zip(STUDENTS, results, strict=True):
        slot, one = wrong[student.id]
        for problem in result["problems"]:
            for part in problem["parts"]:
                if (problem["slot"], part["name"]) == (slot, one.part.name):
                    named += _is_named(part, one)
                    assert part["mistake"] and part["advice"], (student.id, one)
                    assert part["points"] < part["max_points"]
                    assert _in_page(part["advice"], feedback_page(assignment, student, result))
                else:
                    assert part["outcome"] == "correct" and part["mistake"] is None, (student.id, part)
    assert named >= 0.5 * len(STUDENTS)  # of the others, another mistake gives the very same answer


def _is_named(part: dict[str, Any], one: Made) -> bool:
    return one.mistake in part["mistake"].split(" and ")


def _in_page(advice: str, page: str) -> bool:
    return advice.split(".", maxsplit=1)[0].replace("'", "&#39;").replace("<", "&lt;").replace(">", "&gt;") in page
