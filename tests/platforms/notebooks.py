"""A class that submits notebooks: right, wrong, mistaken and blank ones; and the marks that qdot gives to each."""

import json
import shutil
import subprocess
from collections.abc import Callable, Iterable, Mapping
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
from qdot.exercises.notebook.notebook import NotebookContent, make_solution_notebook, write_notebook
from qdot.exercises.problem.problem import Part, Problem, name_answer_variable
from qdot.exercises.reference_answers import ConditionSet
from qdot.grader.grading.batch import grade_one, make_limits
from qdot.grader.grading.certify import find_failures
from qdot.grader.grading.result import Result
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_student_files
from tests.platforms.assignments import SECRET, write_files
from tests.platforms.records import Counts
from tests.support.gallery import GALLERY, GALLERY_FOLDER

CUSTOM_QUESTIONS = ("middle-of-a-link", "tip-speed", "axis-in-the-base-frame")
"""Questions of the gallery that are in the assignment."""
RIGHT, WRONG, MISTAKEN, BLANK = "right", "wrong", "mistaken", "blank"
"""Students, named by what they submit. Mistaken answers are results of known mistakes, and may be partly right."""
KEY = "arms"
TOLERANCE = 1e-6


def make_class_assignment(folder: Path, students: Iterable[str] = (RIGHT, WRONG, MISTAKEN, BLANK)) -> Assignment:
    """Make an assignment with a ready-made set and custom questions, for students named by what they submit."""
    roster = [Student(name, f"{name.title()} <Student>", f"{name}@example.org") for name in students]
    init_assignment(folder, "Arms & <signs>", KEY, roster, SECRET, problem_set=SETS[DEFAULT_SET])
    with (folder / "assignment.toml").open("a", encoding="utf-8") as file:
        for name in CUSTOM_QUESTIONS:
            shutil.copy(GALLERY_FOLDER / f"{name}.toml", folder)
            file.write(f'[[problem]]\nfamily = "{GALLERY[name]}"\nquestions = ["{name}.toml"]\n')
    return load_assignment(folder)


def export_into(assignment: Assignment, export_format: str, folder: Path) -> Path:
    write_files(EXPORT_FORMATS[export_format].export(ExportRequest(assignment, find_failures)), folder)
    return folder


def install(software: Path, wheel: Path) -> None:
    """Install an exported wheel into an environment: its dependencies, then itself, even if it is installed."""
    command: list[str | Path] = [software / "bin" / "python", "-m", "pip", "install", "--quiet", wheel]
    for options in ([], ["--force-reinstall", "--no-deps"]):
        subprocess.run([*command, *options], check=True, capture_output=True)


# --- submissions ---


def fill_in_answers(assignment: Assignment, student: str, text: str) -> str:
    """Return a student's released notebook (`text`) with that student's kind of answers in its cells."""
    write_answers = {RIGHT: write_right_answers, WRONG: _write_wrong_answers, MISTAKEN: _write_mistaken_answers}
    return fill_in(text, write_answers[student](assignment, student) if student in write_answers else {})


def fill_in(text: str, answers: Mapping[str, str]) -> str:
    """Return a notebook with answers in its cells; `answers` has the code of each part."""
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        part = get_part(cell)
        if part in answers:
            cell["source"] = answers[part]
    return json.dumps(notebook, indent=1)


def get_part(cell: Mapping[str, Any]) -> str:
    """Return the part whose answer a cell of a student's notebook holds, or an empty string for other cells."""
    part: str = cell["metadata"].get("qdot", {}).get("part", "")
    return part


def write_right_answers(assignment: Assignment, student: str) -> dict[str, str]:
    problems = assignment.generate_problems(student)
    content = NotebookContent(assignment.title, assignment.key, student, problems, assignment.hints)
    solved = json.loads(write_notebook(make_solution_notebook(content)))
    return {part: cell["source"] for cell in solved["cells"] if (part := get_part(cell))}


def _write_wrong_answers(assignment: Assignment, student: str) -> dict[str, str]:
    return _answer_each_part(assignment, student, lambda problem, part: "0")


def _write_mistaken_answers(assignment: Assignment, student: str) -> dict[str, str]:
    return _answer_each_part(assignment, student, _write_mistaken_answer)


def _answer_each_part(
    assignment: Assignment, student: str, write_answer: Callable[[Problem, Part], str]
) -> dict[str, str]:
    return {
        f"{slot}.{part.name}": f"{name_answer_variable(slot, part.name)} = {write_answer(problem, part)}"
        for slot, problem in assignment.generate_problems(student)
        for part in problem.parts
    }


def _write_mistaken_answer(problem: Problem, part: Part) -> str:
    """Return, as code, the result of a known mistake in a part, or zero if no mistake is known."""
    known = next(iter(find_known_wrong_answers(problem, part, 1)), None)
    if known is None:
        return "0"
    if isinstance(part.answer, ConditionSet):
        assert isinstance(known.answer, tuple)
        return replace(part.answer, components=known.answer).write_code()
    value = sp.Matrix(known.answer)
    return str(value if len(value) > 1 else value[0])


# --- marks ---


@dataclass(frozen=True)
class QdotGrading:
    """The grading of a student's notebook by qdot itself."""

    assignment: Assignment
    student: str
    notebook: Path

    @cached_property
    def result(self) -> Result:
        files = find_student_files(self.assignment, self.notebook)
        return grade_one(
            self.assignment, self.assignment.find_student(self.student), files, make_limits(Limits.seconds)
        )


def compare_marks(counts: Counts, grading: QdotGrading, platform_points: Mapping[str, float]) -> None:
    """Check the points that a platform gives each part against the kind of submission and against qdot's points."""
    for name, part in grading.result.parts.items():
        points, max_points = platform_points.get(name, -1.0), part.max_points
        details = f"{grading.student} {name}: {points} of {max_points}"
        if grading.student == RIGHT:
            counts.add("right = full", points == max_points, details)
        elif grading.student == BLANK:
            counts.add("blank = 0", points == 0, details)
        else:
            counts.add("wrong < full", 0 <= points < max_points, details)
        counts.add("marks as ours", abs(points - (part.points or 0)) < TOLERANCE, f"{details}, {part.points} by qdot")
