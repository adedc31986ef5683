"""qdot: randomised manipulator-velocity problems, written out and graded.

`exercises` is what is asked, `grader` what is handed in; both lie at the top of the checkout, and are linked here. What
a library or a notebook needs is offered by this package itself (`__all__`), and loaded when it is asked for:

>>> from qdot import generate, judge
>>> problem = generate("polar-rp/1", ["determinant"])
>>> judge(problem, problem["determinant"], "-(7/10 + d2)")
Judgement(correct, 1: right)
"""

import os
from typing import TYPE_CHECKING, Any

# What SymPy remembers of each function: a class asks the same of the same formulas, and a thousand are soon forgotten.
os.environ.setdefault("SYMPY_CACHE_SIZE", "20000")

if TYPE_CHECKING:
    from qdot.exercises.answer_types import Answer as Answer
    from qdot.exercises.arm.chain import Base as Base
    from qdot.exercises.arm.chain import Chain as Chain
    from qdot.exercises.arm.chain import Joint as Joint
    from qdot.exercises.arm.chain import Point as Point
    from qdot.exercises.arm.robot_file import read_robot as read_robot
    from qdot.exercises.assignment.assignment import Assignment as Assignment
    from qdot.exercises.assignment.assignment import load_assignment as load_assignment
    from qdot.exercises.common.errors import QdotError as QdotError
    from qdot.exercises.families import FAMILIES as FAMILIES
    from qdot.exercises.formula.equality import Certificate as Certificate
    from qdot.exercises.generation import generate as generate
    from qdot.exercises.notebook.problem_formats import show as show
    from qdot.exercises.problem.problem import ENGINE as ENGINE
    from qdot.exercises.problem.problem import Part as Part
    from qdot.exercises.problem.problem import Problem as Problem
    from qdot.exercises.problem.problem import ProblemId as ProblemId
    from qdot.exercises.short_questions import ASKED as ASKED
    from qdot.exercises.solve.solver import Solution as Solution
    from qdot.exercises.solve.solver import solve as solve
    from qdot.exercises.verify.certificate import ProblemCertificate as ProblemCertificate
    from qdot.exercises.verify.certificate import certify as certify
    from qdot.grader.diagnosis.diagnosis import diagnose as diagnose
    from qdot.grader.grading.attempt import grade_notebook as grade_notebook
    from qdot.grader.grading.check import check_notebook as check_notebook
    from qdot.grader.grading.marking import MarkingRules as MarkingRules
    from qdot.grader.grading.marking import mark as mark
    from qdot.grader.judging.answer import ParsedAnswer as ParsedAnswer
    from qdot.grader.judging.answer_parser import read_answer as read_answer
    from qdot.grader.judging.judge import judge as judge
    from qdot.grader.judging.verdict import Diagnosis as Diagnosis
    from qdot.grader.judging.verdict import Judgement as Judgement
    from qdot.grader.judging.verdict import Outcome as Outcome
    from qdot.grader.judging.verdict import Verdict as Verdict

_HOMES = {
    "exercises.answer_types": ("Answer",), "exercises.arm.chain": ("Base", "Chain", "Joint", "Point"),
    "exercises.arm.robot_file": ("read_robot",), "exercises.assignment.assignment": ("Assignment", "load_assignment"),
    "exercises.common.errors": ("QdotError",), "exercises.families": ("FAMILIES",),
    "exercises.formula.equality": ("Certificate",), "exercises.generation": ("generate",),
    "exercises.notebook.problem_formats": ("show",),
    "exercises.problem.problem": ("ENGINE", "Part", "Problem", "ProblemId"), "exercises.short_questions": ("ASKED",),
    "exercises.solve.solver": ("Solution", "solve"), "exercises.verify.certificate": ("ProblemCertificate", "certify"),
    "grader.diagnosis.diagnosis": ("diagnose",), "grader.grading.attempt": ("grade_notebook",),
    "grader.grading.check": ("check_notebook",),
    "grader.grading.marking": ("MarkingRules", "mark"),
    "grader.judging.answer": ("ParsedAnswer",), "grader.judging.answer_parser": ("read_answer",),
    "grader.judging.judge": ("judge",),
    "grader.judging.verdict": ("Diagnosis", "Judgement", "Outcome", "Verdict"),
}  # fmt: skip
"""Where what is offered here is made: SymPy is loaded for who asks for it, and not for who asks for the version."""

__all__ = [
    "ASKED", "ENGINE", "FAMILIES", "Answer", "Assignment", "Base", "Certificate", "Chain", "Diagnosis", "Joint",
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
