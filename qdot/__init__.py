"""qdot: randomised problems on manipulator velocities, as notebooks and quizzes, with automatic grading.

`exercises` generates problems, and `grader` grades answers. Both are folders of the checkout, and linked here. The
package itself has the public names (`__all__`). Each is imported when it is first used:

>>> from qdot import generate, judge
>>> problem = generate("polar-rp/1", ["determinant"])
>>> judge(problem, problem["determinant"], "-(7/10 + d2)")
Judgement(correct, 1: right)
"""

import os
from typing import TYPE_CHECKING, Any

# The size of SymPy's cache for each function. A class uses the same formulas again and again; 1000 entries are too few.
os.environ.setdefault("SYMPY_CACHE_SIZE", "20000")

if TYPE_CHECKING:
    from qdot.exercises.arm.chain import Base, Chain, Joint, Point
    from qdot.exercises.assignment.assignment import Assignment, load_assignment
    from qdot.exercises.common.errors import QdotError
    from qdot.exercises.families import FAMILIES
    from qdot.exercises.formula.equality import Certificate
    from qdot.exercises.generation import generate
    from qdot.exercises.notebook.problem_formats import show
    from qdot.exercises.problem.problem import ENGINE, Part, Problem, ProblemId
    from qdot.exercises.reference_answers import Answer
    from qdot.exercises.robots.robot_file import read_robot
    from qdot.exercises.short_questions import ALL_QUESTIONS
    from qdot.exercises.solve.solver import Solution, solve
    from qdot.exercises.verify.certificate import ProblemCertificate, certify
    from qdot.grader.diagnosis.diagnosis import diagnose
    from qdot.grader.grading.attempt import grade_notebook
    from qdot.grader.grading.check import check_notebook
    from qdot.grader.judging.answer_parser import ParsedAnswer
    from qdot.grader.judging.expected_form import read_answer
    from qdot.grader.judging.judge import judge
    from qdot.grader.judging.verdict import Diagnosis, Judgement, Outcome, Verdict
    from qdot.grader.marking.marking import MarkingRules, mark

_HOMES = {
    "exercises.reference_answers": ("Answer",), "exercises.arm.chain": ("Base", "Chain", "Joint", "Point"),
    "exercises.assignment.assignment": ("Assignment", "load_assignment"), "exercises.common.errors": ("QdotError",),
    "exercises.families": ("FAMILIES",), "exercises.robots.robot_file": ("read_robot",),
    "exercises.formula.equality": ("Certificate",), "exercises.generation": ("generate",),
    "exercises.notebook.problem_formats": ("show",),
    "exercises.problem.problem": ("ENGINE", "Part", "Problem", "ProblemId"),
    "exercises.short_questions": ("ALL_QUESTIONS",),
    "exercises.solve.solver": ("Solution", "solve"), "exercises.verify.certificate": ("ProblemCertificate", "certify"),
    "grader.diagnosis.diagnosis": ("diagnose",), "grader.grading.attempt": ("grade_notebook",),
    "grader.grading.check": ("check_notebook",),
    "grader.marking.marking": ("MarkingRules", "mark"),
    "grader.judging.answer_parser": ("ParsedAnswer",), "grader.judging.expected_form": ("read_answer",),
    "grader.judging.judge": ("judge",),
    "grader.judging.verdict": ("Diagnosis", "Judgement", "Outcome", "Verdict"),
}  # fmt: skip
"""The modules that define the public names. They are imported on demand, because SymPy takes long to load."""

__all__ = [
    "ALL_QUESTIONS", "ENGINE", "FAMILIES", "Answer", "Assignment", "Base", "Certificate", "Chain", "Diagnosis", "Joint",
    "Judgement", "MarkingRules", "Outcome", "ParsedAnswer", "Part", "Point", "Problem", "ProblemCertificate",
    "ProblemId", "QdotError", "Solution", "Verdict", "certify", "check_notebook", "diagnose", "generate",
    "grade_notebook", "judge", "load_assignment", "mark", "read_answer", "read_robot", "show", "solve",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    from importlib import import_module

    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"qdot.{home}"), name)
    raise AttributeError(f"module 'qdot' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
