"""What tests of questions share: problems of one question for any chain, and problems with another reference."""

import os
import signal
from collections import Counter
from dataclasses import dataclass, replace
from functools import cache

import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS, Chain, Point
from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import questions_of_family
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS, Question
from qdot.exercises.reference_answers import Answer
from tests.support.kept import kept
from tests.support.suites import SHAPES, WHOLE, several

LONG_ARMS = tuple(name for name in FAMILIES if name.endswith(("-6r", "-7r", "-560")))
"""Families of six and seven joints, whose problems take ten times as long as others."""


@cache
def drawn(family: str, seed: int, variation: str = "full", convention: str = "", twist_order: str = "") -> Problem:
    """Return the problem of a family and a seed with all its questions, generated once for the same code.

    Where nothing else is said, everything varies that can: what holds for those holds for plainer ones.
    """
    return kept(ProblemId(family, seed, variation=variation, convention=convention, twist_order=twist_order))


def told_in(question: Question) -> str:
    """Return the convention in which a question is asked of an arm: none in particular, if it is asked of tables."""
    return "" if CONVENTIONS[0] in question.conventions else question.conventions[0]


@cache
def asked(name: str, chain: Chain, seed: int = 1) -> Problem:
    """Return a problem with this question alone, for a chain that need not be of a family."""
    question = QUESTIONS[name]
    answer, details = question.ask(chain, Stream(f"{chain.name}/{seed}/{name}"))
    part = Part(name, name, answer, question.points, (), details)
    return Problem(ProblemId("textbook", seed, (name,)), chain, (part,))


def as_table(chain: Chain) -> Chain:
    """Return the same arm, the lengths that its point of interest has been given put back into the table."""
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


def with_answer(problem: Problem, answer: Answer) -> Problem:
    """Return the problem with another reference for its only part."""
    (part,) = problem.parts
    return replace(problem, parts=(replace(part, answer=answer),))


@cache
def seldom_asked() -> set[str]:
    """Return the questions that only one or two families can be asked."""
    often = Counter(name for family in FAMILIES for name in questions_of_family(family))
    return {name for name in QUESTIONS if often[name] <= 2}


def some_parts(problem: Problem) -> list[Part]:
    """Return a third of the parts, another third for each family, and those that are asked seldom.

    Of arms of six and seven joints it is a sixth, in `make whole` a third.
    """
    each = several(6, 3) if problem.id.family in LONG_ARMS else 3
    first = (list(FAMILIES).index(problem.id.family) + problem.id.seed) % each
    return [part for i, part in enumerate(problem.parts) if i % each == first or part.name in seldom_asked()]


@cache
def _turns() -> dict[str, frozenset[str]]:
    """Give every question to two of the families that every sweep takes, to those with the fewest so far."""
    given: dict[str, list[str]] = {family: [] for family in SHAPES.values()}
    rarest = sorted(QUESTIONS, key=lambda name: sum(name in questions_of_family(family) for family in given))
    for name in rarest:
        can = [
            family
            for family in given
            if name in questions_of_family(family) and not FAMILIES[family].has_varied_structure
        ]
        for family in sorted(can, key=lambda family: len(given[family]) * (3 if family in LONG_ARMS else 1))[:2]:
            given[family].append(name)
    return {family: frozenset(names) for family, names in given.items()}


def parts_in_turn(problem: Problem) -> list[Part]:
    """Return the parts that a sweep looks at where each takes long; in `make whole` all of them.

    In `make test` every question is among those of two of the families that every sweep takes.
    """
    if WHOLE:
        return list(problem.parts)
    names = _turns().get(problem.id.family, frozenset())
    return [part for part in problem.parts if part.name in names] or some_parts(problem)


@dataclass(frozen=True)
class DeadlyAssignment(Assignment):
    """An assignment that ends the process which comes to the problems of `victim`, so many `times`."""

    victim: str = ""
    times: int = 0

    def problems(self, student: str) -> list[tuple[str, Problem]]:
        died = len(list(self.folder.glob("died.*")))
        if student == self.victim and died < self.times:
            (self.folder / f"died.{died}").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super().generate_problems(student)
