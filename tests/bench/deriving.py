"""What deriving costs: from DH table to factored determinant, and the first and later problems of a family."""

import statistics
import sys
import time
from collections.abc import Callable

import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain, Joint
from exercises.arm.derivation import derive
from exercises.families import FAMILIES
from exercises.generation import generate, questions_of
from exercises.problem import ProblemId

Row = tuple[sp.Expr, sp.Expr, sp.Expr]
"""d, a and alpha of a joint."""

D3, D4, A1, A2, A3 = sp.symbols("d3 d4 a1 a2 a3")
UP, DOWN = sp.pi / 2, -sp.pi / 2
ELBOW = [(0, 0, UP), (0, A2, 0), (0, A3, 0)]
PUMA = [(0, 0, UP), (0, A2, 0), (D3, A3, DOWN), (D4, 0, UP), (0, 0, DOWN), (0, 0, 0)]
LATER = 6
"""Problems after the first that are timed of each family."""


def arm(rows: list[Row], task: tuple[str, ...]) -> Chain:
    """Return an arm of revolute joints."""
    q = sp.symbols(f"theta1:{len(rows) + 1}")
    return Chain("bench", tuple(Joint("R", v, *map(sp.S, row)) for v, row in zip(q, rows, strict=True)), task)


def bench_deriving() -> None:
    """Print the determinants' times beside SymPy's on the elbow (the PUMA's it does not end), then the families'."""
    elbow, puma = arm(ELBOW, TASK_ROWS[:3]), arm(PUMA, TASK_ROWS)
    position = derive(elbow).position
    theirs = cpu(lambda: sp.factor(sp.trigsimp(position.jacobian(elbow.q).det())))
    derive.cache_clear()
    ours = cpu(lambda: derive(arm(ELBOW, TASK_ROWS[:3])).determinant)
    show("elbow-3r: table to factored determinant", ours)
    show("SymPy: differentiate, det, trigsimp, factor", theirs)
    sys.stdout.write(f"{'SymPy over ours':<46} {theirs / ours:9.1f} x\n")
    show("PUMA 560: table to factored determinant", cpu(lambda: derive(puma).determinant))
    show("PUMA 560: position, axes and J, proved", cpu(lambda: derive(puma).geometric))
    later = []
    for name in FAMILIES:
        for seed in range(2, 2 + LATER):
            asked = questions_of(name)[:4]
            later.append(cpu(lambda name=name, seed=seed, asked=asked: generate(ProblemId(name, seed, asked))))  # type: ignore[misc]
    show("later problems of four questions, mean", statistics.mean(later))


def first_problems() -> tuple[str, float]:
    """Return the family whose first problem of four questions takes longest, and the seconds; each family is new."""
    taken = {}
    for name in FAMILIES:
        asked = questions_of(name)[:4]
        taken[name] = cpu(lambda name=name, asked=asked: generate(ProblemId(name, 1, asked))) / 1000  # type: ignore[misc]
    slowest = max(taken, key=lambda name: taken[name])
    return slowest, taken[slowest]


def cpu(work: Callable[[], object]) -> float:
    """Return the processor time of a call in milliseconds."""
    start = time.process_time()
    work()
    return 1000 * (time.process_time() - start)


def show(name: str, milliseconds: float) -> None:
    """Print one line of the table."""
    sys.stdout.write(f"{name:<46} {milliseconds:9.1f} ms\n")


if __name__ == "__main__":
    slowest, seconds = first_problems()
    show(f"first problem, slowest family ({slowest})", 1000 * seconds)
    bench_deriving()
