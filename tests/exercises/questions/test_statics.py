"""Static joint torques: by moments about the axes, units, signs, and the load that asks nothing of the joints."""

from dataclasses import replace

import pytest
import sympy as sp

from exercises.answers import Matrix
from exercises.arm.derivation import derive
from exercises.families import FAMILIES
from exercises.generation import generate, questions_of, sample_chain
from exercises.problem import Part, Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.statics import Loaded
from exercises.stream import Stream
from exercises.verify import certify
from exercises.writing.statement import prompt, worked_solution
from tests.support.problems import as_table

ARMS = [
    family for family in FAMILIES if not FAMILIES[family].varied and "joint-torques" in questions_of(family)
]  # fmt: skip


def asked(family: str, seed: int) -> tuple[Problem, Part]:
    problem = generate(ProblemId(family, seed, ("joint-torques",)))
    return problem, problem.parts[0]


@pytest.mark.parametrize("family", ARMS)
def test_a_joint_carries_the_moment_of_the_load_about_its_own_axis(family: str) -> None:
    """By balance of moments (of forces, for a slide), not by the transposed Jacobian."""
    problem, part = asked(family, 3)
    chain, found = problem.chain, derive(problem.chain)
    names = part.symbols
    force, moment = (
        sp.Matrix([sp.Symbol(f"{letter}{axis}") if f"{letter}{axis}" in names else 0 for axis in "xyz"])
        for letter in "fm"
    )
    assert isinstance(part.answer, Matrix)
    for i, joint in enumerate(chain.joints):
        z, arm = found.z[:, i], found.p_star[:, i]
        carried = force if i < chain.point.frame else sp.zeros(3, 1)
        expected = z.dot(arm.cross(carried) + moment) if joint.kind == "R" else z.dot(carried)
        difference = sp.sympify(expected - part.answer.reference[i])
        values = {s: sp.Float(0.3 + 0.37 * k) for k, s in enumerate(sorted(difference.free_symbols, key=str))}
        assert abs(difference.xreplace(values).evalf()) < 1e-12


@pytest.mark.parametrize("family", ARMS)
def test_the_prompt_names_every_unit_and_the_sign_convention(family: str) -> None:
    problem, part = asked(family, 1)
    text = prompt(problem, part)
    for i, joint in enumerate(problem.chain.joints, 1):
        assert f"$\\tau_{{{i}}}$ in {'N m' if joint.kind == 'R' else 'N'}" in text
    assert "on its surroundings" in text
    assert "weight of the links and friction are left out" in text
    assert all(f"`{name}`" in text for name in part.symbols)
    kinds = {name[0] for name in part.symbols}
    what = {"f": "the force $F", "m": "the moment $F", "fm": "the force and moment $F"}["".join(sorted(kinds))]
    assert f"exerts {what}" in text
    assert ("forces in N" in text, "moments in N m" in text) == ("f" in kinds, "m" in kinds)


def test_symbols_are_printed_with_an_index_and_typed_without() -> None:
    problem, part = asked("scara", 1)
    text = prompt(problem, part) + worked_solution(problem, part)
    assert "f_{x}" in text and "m_{z}" in text
    assert list(part.symbols) == ["fx", "fy", "fz", "mz"]
    assert problem.symbols()["mz"].unit == "N m"


@pytest.mark.parametrize(("family", "joint", "value"), [("planar-2r", 1, sp.S.Zero), ("planar-2r", 1, sp.pi)])
def test_a_load_along_the_lost_direction_asks_nothing_of_the_joints(family: str, joint: int, value: sp.Expr) -> None:
    """The arm stretched out or folded back, of Example 6.2."""
    problem, part = asked(family, 1)
    chain = replace(as_table(problem.chain), tool=None)
    answer, _ = QUESTIONS["joint-torques"].ask(chain, Stream("x"))
    assert isinstance(answer, Matrix)
    at = {chain.q[joint]: value - chain.offsets[joint]}
    x, y = derive(chain).p_star[:2, 1].xreplace(at)
    along = answer.reference.xreplace({**at, sp.Symbol("fx"): x, sp.Symbol("fy"): y})
    across = answer.reference.xreplace({**at, sp.Symbol("fx"): -y, sp.Symbol("fy"): x})
    values = {s: sp.Float(0.3 + 0.37 * k) for k, s in enumerate(sorted(along.free_symbols, key=str))}
    assert max(abs(entry) for entry in along.xreplace(values).evalf()) < 1e-12
    assert abs(across.xreplace(values).evalf()[1]) > 1e-3
    assert "For a load $F = u$" in worked_solution(problem, part)


def test_an_arm_with_fewer_joints_than_rows_is_told_that_some_loads_never_ask_anything() -> None:
    problem, part = asked("scorbot-wrist", 1)
    assert "in every configuration there are directions" in worked_solution(problem, part)
    problem, part = asked("scara", 1)
    assert "in every configuration there are directions" not in worked_solution(problem, part)


def test_the_reaction_and_the_untransposed_product_are_found() -> None:
    problem, part = asked("elbow-3r", 2)
    assert isinstance(part.answer, Matrix)
    assert certify(problem).passed
    force = part.about(Loaded).force
    for wrong in (-part.answer.reference, derive(problem.chain).jacobian * force):
        assert not certify(replace(problem, parts=(replace(part, answer=Matrix(wrong)),))).passed


@pytest.mark.parametrize("family", ["puma-560", "lbr-7r", "ur-6r"])
def test_arms_of_many_terms_are_refused(family: str) -> None:
    assert "too many to be worked out by hand" in (
        QUESTIONS["joint-torques"].refusal(sample_chain(ProblemId(family, 1))) or ""
    )


@pytest.mark.parametrize(("identity", "is_lost"), [("random-3/638@zeros", False), ("planar-2r/1@chapter", True)])
def test_no_lost_direction_is_told_of_an_arm_without_one(identity: str, is_lost: bool) -> None:
    problem = generate(replace(ProblemId.parse(identity), questions=("joint-torques",)))
    assert ("that is lost" in worked_solution(problem, problem.parts[0])) == is_lost
