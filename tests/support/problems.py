"""Problems for tests: cached problems of each family, a question about any chain, and samples of parts."""

import os
import signal
from collections import Counter
from dataclasses import dataclass, replace
from functools import cache

import sympy as sp

from qdot.exercises.arm.chain import DEFAULT_CONVENTION, Chain, Point
from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import list_questions_of_family
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS, Question
from qdot.exercises.reference_answers import Answer
from tests.support.problem_cache import load_problem
from tests.support.suites import SHAPES, WHOLE, select_for_suite

LONG_ARMS = tuple(name for name in FAMILIES if name.endswith(("-6r", "-7r", "-560")))
"""Families of six and seven joints, whose problems take ten times as long as others."""


@cache
def get_problem(
    family: str, seed: int, variation: str = "full", convention: str = "", twist_order: str = ""
) -> Problem:
    """Return the problem of a family and a seed with all its questions, from the cache on disk.

    By default, everything varies that can vary, because whatever holds for such arms also holds for simpler ones.
    """
    return load_problem(ProblemId(family, seed, variation=variation, convention=convention, twist_order=twist_order))


def choose_convention(question: Question) -> str:
    """Return the convention that a question needs; empty if it can be asked about the default DH table."""
    return "" if DEFAULT_CONVENTION in question.conventions else question.conventions[0]


@cache
def ask_question(name: str, chain: Chain, seed: int = 1) -> Problem:
    """Return a problem with this question alone, about a chain that need not belong to a family."""
    question = QUESTIONS[name]
    answer, details = question.ask(chain, Stream(f"{chain.name}/{seed}/{name}"))
    part = Part(name, name, answer, question.points, (), details)
    return Problem(ProblemId("textbook", seed, (name,)), chain, (part,))


def fold_tool_into_table(chain: Chain) -> Chain:
    """Return the same arm with the offset of its point of interest moved back into the table."""
    *others, last = chain.joints
    x, y, z = chain.point.offset
    if chain.point.frame < chain.n:
        return chain
    if last.is_prismatic:
        others[-1] = replace(others[-1], a=others[-1].a + x)
        return replace(chain, joints=(*others, replace(last, d=last.d + z)), tool=None)
    x += last.a
    turns = 0
    while (x == 0 or _is_minus(x)) and turns < 4 and (x, y) != (0, 0):
        (x, y), turns = (y, -x), turns + 1
    last = replace(last, theta=last.theta + turns * sp.pi / 2, d=last.d + z, a=x)
    return replace(chain, joints=(*others, last), tool=Point(chain.n, (sp.S.Zero, y, sp.S.Zero)))


def _is_minus(value: sp.Expr) -> bool:
    return bool(value.as_coeff_Mul()[0].is_negative)


def replace_answer(problem: Problem, answer: Answer) -> Problem:
    (part,) = problem.parts
    return replace(problem, parts=(replace(part, answer=answer),))


@cache
def list_rare_questions() -> set[str]:
    counts = Counter(name for family in FAMILIES for name in list_questions_of_family(family))
    return {name for name in QUESTIONS if counts[name] <= 2}


def sample_parts(problem: Problem) -> list[Part]:
    """Return the rare questions and a third of the other parts, a different third for each family.

    For arms with six or seven joints, the share is a third only in `make whole`, and otherwise a sixth.
    """
    step = select_for_suite(6, 3) if problem.id.family in LONG_ARMS else 3
    first = (list(FAMILIES).index(problem.id.family) + problem.id.seed) % step
    return [part for i, part in enumerate(problem.parts) if i % step == first or part.name in list_rare_questions()]


@cache
def _assign_questions() -> dict[str, frozenset[str]]:
    """Assign every question to two of the families in SHAPES, those with few joints and the fewest questions so far."""
    assigned: dict[str, list[str]] = {family: [] for family in SHAPES.values()}
    rarest = sorted(QUESTIONS, key=lambda name: sum(name in list_questions_of_family(family) for family in assigned))
    fixed_families = [family for family in assigned if not FAMILIES[family].has_varied_structure]
    for name in rarest:
        candidates = [family for family in fixed_families if name in list_questions_of_family(family)]
        candidates.sort(key=lambda family: (family in LONG_ARMS, len(assigned[family])))
        for family in candidates[:2]:
            assigned[family].append(name)
    return {family: frozenset(names) for family, names in assigned.items()}


def select_parts(problem: Problem) -> list[Part]:
    """Return the parts that a slow sweep checks: in `make whole`, all of them.

    `make test` checks every question for two of the families in SHAPES.
    """
    if WHOLE:
        return list(problem.parts)
    names = _assign_questions().get(problem.id.family, frozenset())
    return [part for part in problem.parts if part.name in names] or sample_parts(problem)


@dataclass(frozen=True)
class CrashingAssignment(Assignment):
    """An assignment whose process is killed while it generates the problems of `victim`, the first `times` times."""

    victim: str = ""
    times: int = 0

    def generate_problems(self, student: str) -> list[tuple[str, Problem]]:
        died = len(list(self.folder.glob("died.*")))
        if student == self.victim and died < self.times:
            (self.folder / f"died.{died}").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super().generate_problems(student)
