"""The whole loop, for 8 seeds of every family: generate, answer with the solution, run, grade: full marks for each.

The solution is what the staff's notebook holds, run as a student's would be; and for every question the usual mistakes
made in it are not right. QDOT_SEEDS sets another number of seeds.
"""

import os
from collections.abc import Iterator

import pytest

from exercises.families import FAMILIES
from exercises.generate import generate
from exercises.problem import ConditionSet, Expression, Matrix, Number, Part, Problem, ProblemId, variable
from exercises.writing.answer_code import answer_code
from grader.marking import mark
from grader.sandbox import Limits, Sandbox
from grader.verdict import Outcome, Verdict

SEEDS = int(os.environ.get("QDOT_SEEDS", "8"))
CHUNK = 4
SETUP = (
    "from sympy import *\n"
    + "".join(f"theta{i}, d{i}, a{i}, qd{i} = symbols('theta{i} d{i} a{i} qd{i}')\n" for i in range(1, 8))
    + "vx, vy, vz, wx, wy, wz = symbols('vx vy vz wx wy wz')\nfx, fy, fz, mx, my, mz = symbols('fx fy fz mx my mz')"
)


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox(Limits(seconds=60, cell_seconds=20)) as made:
        yield made


def marked(sandbox: Sandbox, problem: Problem, codes: dict[str, str]) -> dict[str, Verdict]:
    cells = [f"{variable('p1', name)} = {code}" for name, code in codes.items()]
    run = sandbox.run([SETUP, *cells], [variable("p1", name) for name in codes])
    assert not run.cell_errors, run.cell_errors
    return {verdict.part: verdict for verdict in mark(problem, "p1", run.answers, {}, "secret")}


@pytest.mark.parametrize("start", range(0, SEEDS, CHUNK))
@pytest.mark.parametrize("family", FAMILIES)
def test_the_solution_earns_full_marks(family: str, start: int, sandbox: Sandbox) -> None:
    for seed in range(start, min(start + CHUNK, SEEDS)):
        problem = generate(ProblemId(family, seed))
        verdicts = marked(sandbox, problem, {part.name: answer_code(part) for part in problem.parts})
        for verdict in verdicts.values():
            assert verdict.judgement.outcome is Outcome.CORRECT, (
                f"{problem.id} {verdict.part}: {verdict.judgement.reason}"
            )
            assert verdict.points == verdict.max_points


def mistakes(part: Part, code: str) -> dict[str, str]:
    """Return the usual mistakes in an answer, as code; each changes the answer (or is left out where it would not)."""
    answer = part.answer
    if isinstance(answer, ConditionSet):
        return {"degrees": "{theta2: [0, 180]}", "none": "[]", "book": "Eq(sin(theta1), 0)", "first": f"({code})[:-1]"}
    if isinstance(answer, Number):
        return {"sign": f"-({code})", "degrees": f"180/pi*({code})"}
    if not isinstance(answer, (Expression, Matrix)):
        return {}
    relative = {
        "theta1 + theta2 + theta3": "theta3", "theta1 + theta2": "theta2", "theta2 + theta3": "theta3",
        "theta1 - theta2": "theta2",
    }  # fmt: skip
    found = {
        "sign": f"-({code})",
        "nan": f"({code})*nan",
        "degrees": f"({code}).subs({{theta1: pi*theta1/180, theta2: pi*theta2/180, theta3: pi*theta3/180}})",
        "unknown symbol": f"({code})*Symbol('k')",
    }
    if isinstance(answer, Matrix):
        reference = answer.reference
        if 1 not in reference.shape and reference != reference.T:
            found["transposed"] = f"({code}).T"
        columns = reference.cols
        found["dropped column"] = f"({code})*diag(*[0]*1, *[1]*{columns - 1})" if columns > 1 else f"({code})*0"
        found["number for a matrix"] = "1"
    changed = code
    for absolute, wrong in relative.items():
        changed = changed.replace(absolute, wrong)
    if changed != code:
        found["relative angle"] = changed
    angles = any(symbol.name.startswith("theta") for symbol in answer.reference.free_symbols)
    return {name: wrong for name, wrong in found.items() if angles or name != "degrees"}


CHAPTER = ("planar-2r", "elbow-3r", "polar-rp", "planar-3r")
TRIED = [(family, seed) for family in FAMILIES for seed in (range(3) if family in CHAPTER else (0,))]


@pytest.mark.parametrize(("family", "seed"), TRIED)
def test_the_usual_mistakes_fail(family: str, seed: int, sandbox: Sandbox) -> None:
    problem = generate(ProblemId(family, 1000 + seed))
    for part in problem.parts:
        for mistake, code in mistakes(part, answer_code(part)).items():
            verdict = marked(sandbox, problem, {part.name: code})[part.name]
            assert verdict.judgement.outcome in (Outcome.WRONG, Outcome.PARTIAL, Outcome.MISSING), (
                f"{problem.id} {part.name}: {mistake} was judged {verdict.judgement.outcome}: {code}"
            )
            assert verdict.points is not None
            assert verdict.points < verdict.max_points
