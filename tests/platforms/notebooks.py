"""A class that hands in notebooks: right, wrong, mistaken and blank ones; and the marks that qdot gives to each."""

import json
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import sympy as sp

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.known_wrong_answers import find_known_wrong_answers
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.notebook.notebook import make_solution_notebook, write_notebook
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.reference_answers import ConditionSet
from qdot.grader.grading.batch import find_student, grade_one, make_limits
from qdot.grader.grading.certify import find_failures
from qdot.grader.grading.result import Result
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_student_files
from tests.platforms.given import SECRET
from tests.platforms.records import Counts
from tests.support.gallery import GALLERY, GALLERY_FOLDER

CUSTOM_QUESTIONS = ("middle-of-a-link", "tip-speed", "axis-in-the-base-frame")
"""The questions of the gallery that the class is asked."""
RIGHT, WRONG, MISTAKEN, BLANK = "right", "wrong", "mistaken", "blank"
"""Students by what they hand in; what is mistaken is what a known mistake leads to, and may be right in part."""
KEY = "arms"
NEAR = 1e-6


def a_class(folder: Path, *students: str) -> Assignment:
    """Make an assignment, which also has questions of an instructor, for students who are named by what they submit."""
    roster = [Student(name, f"{name.title()} <Student>", f"{name}@example.org") for name in students]
    init_assignment(folder, "Arms & <signs>", KEY, roster, SECRET, problem_set=SETS[DEFAULT_SET])
    with (folder / "assignment.toml").open("a", encoding="utf-8") as file:
        for name in CUSTOM_QUESTIONS:
            shutil.copy(GALLERY_FOLDER / f"{name}.toml", folder)
            file.write(f'[[problem]]\nfamily = "{GALLERY[name]}"\nquestions = ["{name}.toml"]\n')
    return load_assignment(folder)


def exported(assignment: Assignment, export_format: str, to: Path) -> Path:
    """Export an assignment into a folder, and return it."""
    for file in EXPORT_FORMATS[export_format].export(ExportRequest(assignment, find_failures)):
        path = to / file.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(file.content if isinstance(file.content, bytes) else file.content.encode())
    return to


def install(software: Path, wheel: Path) -> None:
    """Install an exported wheel: what it needs, and then this very qdot, of which the version may be there already."""
    command: list[str | Path] = [software / "bin" / "python", "-m", "pip", "install", "--quiet", wheel]
    for options in ([], ["--force-reinstall", "--no-deps"]):
        subprocess.run([*command, *options], check=True, capture_output=True)


# --- what is handed in ---


def answered(assignment: Assignment, student: str, text: str) -> str:
    """Return the notebook that was handed out to a student, with that student's kind of answers in its cells."""
    code = {RIGHT: _right, WRONG: _wrong, MISTAKEN: _mistaken}.get(student)
    answers = code(assignment, student) if code else {}
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        part = part_of(cell)
        if part in answers:
            cell["source"] = answers[part]
    return json.dumps(notebook, indent=1)


def part_of(cell: Mapping[str, Any]) -> str:
    """Return the part that is answered in a cell of a student's notebook; nothing for other cells."""
    part: str = cell["metadata"].get("qdot", {}).get("part", "")
    return part


def _right(assignment: Assignment, student: str) -> dict[str, str]:
    problems = assignment.generate_problems(student)
    solved = json.loads(
        write_notebook(make_solution_notebook(assignment.title, assignment.key, student, problems, assignment.hints))
    )
    return {part: cell["source"] for cell in solved["cells"] if (part := part_of(cell))}


def _wrong(assignment: Assignment, student: str) -> dict[str, str]:
    return _each(assignment, student, lambda problem, part: "0")


def _mistaken(assignment: Assignment, student: str) -> dict[str, str]:
    return _each(assignment, student, _mistake)


def _each(assignment: Assignment, student: str, code: Callable[[Problem, Part], str]) -> dict[str, str]:
    return {
        f"{slot}.{part.name}": f"{name_answer_variable(slot, part.name)} = {code(problem, part)}"
        for slot, problem in assignment.generate_problems(student)
        for part in problem.parts
    }


def _mistake(problem: Problem, part: Part) -> str:
    """Return what a known mistake makes of an answer, as code; zero where none is known."""
    known = next(iter(find_known_wrong_answers(problem, part, 1)), None)
    if known is None:
        return "0"
    if isinstance(part.answer, ConditionSet):
        assert isinstance(known.answer, tuple)
        return replace(part.answer, components=known.answer).write_code()
    value = sp.Matrix(known.answer)
    return str(value if len(value) > 1 else value[0])


# --- what it is worth ---


@dataclass(frozen=True)
class Ours:
    """A student's notebook, with the points that qdot itself gives to it."""

    assignment: Assignment
    student: str
    notebook: Path

    @cached_property
    def result(self) -> Result:
        """Its result, as in results.jsonl."""
        found = find_student_files(self.assignment, self.notebook)
        return grade_one(
            self.assignment, find_student(self.assignment, self.student), found, make_limits(Limits.seconds)
        )


def hold(counts: Counts, ours: Ours, theirs: Mapping[str, float]) -> None:
    """Count what a program gives to each part, by what the student has handed in and by what qdot gives."""
    for name, part in ours.result.parts.items():
        points, most = theirs.get(name, -1.0), part.max_points
        where = f"{ours.student} {name}: {points} of {most}"
        if ours.student == RIGHT:
            counts.add("right = full", points == most, where)
        elif ours.student == BLANK:
            counts.add("blank = 0", points == 0, where)
        else:
            counts.add("wrong < full", 0 <= points < most, where)
        counts.add("marks as ours", abs(points - (part.points or 0)) < NEAR, f"{where}, {part.points} of ours")
