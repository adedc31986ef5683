"""Static joint torques: moments about the axes, units, signs, and loads that need no torque."""

import re
from dataclasses import replace

import pytest
import sympy as sp

from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, list_questions_of_family
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.reference_answers import Matrix
from qdot.exercises.writing.problem_texts import write_prompt, write_solution
from tests.support.problems import fold_tool_into_table, get_problem
from tests.support.suites import on_families

ARMS = [
    name
    for name, family in FAMILIES.items()
    if not family.has_varied_structure and "joint-torques" in list_questions_of_family(name)
]


def generate_torque_problem(family: str, seed: int) -> tuple[Problem, Part]:
    problem = generate(ProblemId(family, seed, ("joint-torques",)))
    return problem, problem.parts[0]


@on_families(ARMS)
def test_joint_torque_is_the_moment_about_the_joint_axis(family: str) -> None:
    """Compute it by balance of moments (of forces, for a prismatic joint), not by the transposed Jacobian."""
    problem = get_problem(family, 0)
    part = problem["joint-torques"]
    chain, derivation = problem.chain, derive(problem.chain)
    names = part.symbols
    force, moment = (
        sp.Matrix([sp.Symbol(f"{letter}{axis}") if f"{letter}{axis}" in names else 0 for axis in "xyz"])
        for letter in "fm"
    )
    for i, joint in enumerate(chain.joints):
        z, arm = derivation.z[:, i], derivation.p_star[:, i]
        carried = force if i < chain.point.frame else sp.zeros(3, 1)
        expected = z.dot(arm.cross(carried) + moment) if joint.is_revolute else z.dot(carried)
        difference = sp.sympify(expected - part.answer_as(Matrix).reference[i])
        values = {s: sp.Float(0.3 + 0.37 * k) for k, s in enumerate(sorted(difference.free_symbols, key=str))}
        assert abs(difference.xreplace(values).evalf()) < 1e-12


@on_families(ARMS)
def test_prompt_names_every_unit_and_load(family: str) -> None:
    problem = get_problem(family, 0)
    part = problem["joint-torques"]
    text = write_prompt(problem, part)
    for i, joint in enumerate(problem.chain.joints, 1):
        assert f"$\\tau_{{{i}}}$ in {'N m' if joint.is_revolute else 'N'}" in text
    assert all(f"`{name}`" in text for name in part.symbols)
    units = {"f": "N", "m": "N m"}
    assert all(problem.symbols[name].unit == units[name[0]] for name in part.symbols)
    load, has = text.split("**")[0], {name[0] for name in part.symbols}
    assert (re.search(r"\bin N\b(?! m)", load) is not None, "in N m" in load) == ("f" in has, "m" in has)


@pytest.mark.parametrize("value", [sp.S.Zero, sp.pi])
def test_load_along_lost_direction_needs_no_torque(value: sp.Expr) -> None:
    """Use the stretched and the folded arm of Example 6.2."""
    problem, part = generate_torque_problem("planar-2r", 1)
    chain = replace(fold_tool_into_table(problem.chain), tool=None)
    answer, _ = QUESTIONS["joint-torques"].ask(chain, Stream("x"))
    at = {chain.q[1]: value - chain.offsets[1]}
    x, y = derive(chain).p_star[:2, 1].xreplace(at)
    along = answer.as_matrix().xreplace({**at, sp.Symbol("fx"): x, sp.Symbol("fy"): y})
    across = answer.as_matrix().xreplace({**at, sp.Symbol("fx"): -y, sp.Symbol("fy"): x})
    values = {s: sp.Float(0.3 + 0.37 * k) for k, s in enumerate(sorted(along.free_symbols, key=str))}
    assert max(abs(entry) for entry in along.xreplace(values).evalf()) < 1e-12
    assert abs(across.xreplace(values).evalf()[1]) > 1e-3
    assert "For a load $F = u$" in write_solution(problem, part)


@pytest.mark.parametrize(("family", "is_short"), [("scorbot-wrist", True), ("scara", False)])
def test_solution_notes_loads_that_never_need_torque(family: str, is_short: bool) -> None:
    problem, part = generate_torque_problem(family, 1)
    assert ("in every configuration there are directions" in write_solution(problem, part)) == is_short


@pytest.mark.parametrize(("identity", "is_lost"), [("random-3/638@zeros", False), ("planar-2r/1@chapter", True)])
def test_solution_mentions_lost_direction_only_if_there_is_one(identity: str, is_lost: bool) -> None:
    problem = generate(replace(ProblemId.parse(identity), questions=("joint-torques",)))
    assert ("the arm loses a direction" in write_solution(problem, problem.parts[0])) == is_lost
