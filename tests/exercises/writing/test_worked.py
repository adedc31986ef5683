"""Statements in a worked solution on steps, determinants and singular configurations hold for its arm."""

import random
import re
from collections.abc import Iterator
from dataclasses import replace

import pytest
import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.writing.expansion import Expansion, expand_determinant, expand_jacobian
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.problem_texts import write_hints, write_solution, write_solutions, write_statement
from qdot.exercises.writing.solution_steps import SolutionSteps, _compute_cofactors
from tests.support.suites import sample_for_suite, select_for_suite

BOTH = ("inverse-jacobian", "inverse-velocity")
TABLE = r"\begin{bmatrix}"
LAST_COLUMN = "the last column of $R_{i-1}$"
SAYS = [
    # problem, questions, the one that is looked at, what its solution says, and what it does not say
    ("elbow-lateral/607@zeros", BOTH, 1, "found above", TABLE),  # the rates go on from the inverse
    ("elbow-lateral/607@zeros", BOTH[1:], 0, TABLE, "found above"),
    ("elbow-lateral/295@full@screws", BOTH, 1, "", "(-"),
    ("orthogonal-3r/647@frames", BOTH[:1], 0, "0.5 c_{2}^{2}", "0.5 s_{2}^{2}"),  # squares are taken together
    ("wrist-zyz/241@lengths", ("jacobian", "joint-axes"), 0, LAST_COLUMN, "found above"),
    ("wrist-zyz/241@lengths", ("jacobian", "joint-axes"), 1, "found above", "$R_{i-1}$"),
    ("planar-pr/675@chapter", ("link-velocity",), 0, "moves along the joint's axis", "$p^*$"),
    ("scara/808@lengths", ("joint-axes",), 0, "180°", "found above"),
]


@pytest.mark.parametrize(("problem_id", "names", "which", "there", "not_there"), sample_for_suite(SAYS, 4))
def test_steps_are_told_as_they_are_for_this_arm(
    problem_id: str, names: tuple[str, ...], which: int, there: str, not_there: str
) -> None:
    text = write_solutions(generate(problem_id, list(names)))[names[which]]
    assert there in text and not_there not in text


SCREWS = (
    "home-screws", "position", "joint-axes", "joint-effect", "geometric-jacobian", "space-jacobian",
    "space-twist", "body-pose",
)  # fmt: skip


def told(problem_id: str, *names: str) -> str:
    problem = generate(problem_id, list(names))
    parts = [text for part in problem.parts for text in (*write_hints(problem, part), write_solution(problem, part))]
    return "".join((write_statement(problem, ""), *parts))


@pytest.mark.whole
def test_slides_are_spoken_of_where_there_are_some() -> None:
    revolute = told("elbow-lateral/295@full@screws", *SCREWS)
    revolute += told("wrist-rpy/745@zeros@screws", "jacobian", "joint-axes")
    assert not [word for word in ("slide", "prismatic", "v_i'", "v_{i}'") if word in revolute]
    both = told("scara/1@chapter@screws", "position", "joint-axes", "space-jacobian", "space-twist")
    assert "prismatic" in both and "v_i'" in both


NAMES = {"dh": "$O_{2}$ lies", "modified-dh": "$O_{3}$ lies", "screws": "$q_{3}'$ lies"}
LEAST = "This condition can hold only if"


def solution(identity: str, question: str, convention: str = "dh") -> str:
    problem = generate(replace(ProblemId.parse(identity), questions=(question,)).with_convention(convention))
    (part,) = problem.parts
    return write_solution(problem, part)


@pytest.mark.whole
@pytest.mark.parametrize("convention", CONVENTIONS)
def test_an_origin_has_the_name_that_the_arms_convention_has_for_it(convention: str) -> None:
    """O_2 of the standard table is on the axis of joint 3: the origin of frame 3 of a modified one."""
    assert NAMES[convention] in solution("orthogonal-3r/776@frames", "singular-angles", convention)


def test_where_an_arm_has_no_name_for_an_origin_what_is_true_of_all_is_said() -> None:
    # Joints 2 and 3 are slides.
    chain = sample_chain(ProblemId.parse("cylindrical/1@chapter").with_convention("screws"))
    words = convention_of(chain).rename_origins("the origin O2 lies on the axis of joint 1")
    assert words == "these configurations have no simple geometric meaning"


def test_values_that_are_of_different_kinds_are_told_apart_and_equal_ones_together() -> None:
    """A planar arm of three joints is stretched out, or folded back in any of three ways."""
    text = solution("planar-3r/550@chapter", "singular-angles")
    stretched, folded = (next(line for line in text.split("\n") if word in line) for word in ("stretched", "folded"))
    pair = r"\$\\theta_\{2\} = (0|180\^\\circ)\$ and \$\\theta_\{3\} = (0|180\^\\circ)\$"
    assert re.findall(pair, stretched.partition("stretched")[0]) == [("0", "0")]
    half = r"180^\circ"
    assert set(re.findall(pair, folded.partition("folded")[0])) >= {("0", half), (half, "0"), (half, half)}


@pytest.mark.whole  # see test_solving: the Scorbot's shoulder
def test_what_lengths_have_to_satisfy_is_told_where_a_condition_may_not_hold() -> None:
    assert rf"{LEAST} $a_{{1}} \le a_{{2}} + \sqrt{{" in solution("industrial-6r/305@chapter", "singular-angles")
    assert LEAST not in solution("elbow/1@chapter", "singular-angles")  # a2 c2 + a3 c23 = 0 holds somewhere for all


def test_determinants_of_blocks_are_not_worked_out_twice() -> None:
    problem = generate(ProblemId("stanford-6r", 4, ("block-determinants", "determinant")).with_variation("zeros"))
    first, second = write_solutions(problem).values()
    assert "found above" in second and "The wrist" not in second and "found above" not in first


def worked_determinants(chain: Chain) -> Iterator[tuple[Expansion, sp.Expr]]:
    """Yield (expansion, determinant) of all that solutions on an arm work out."""
    worked = SolutionSteps(chain)
    if worked.block_determinants is not None:
        yield worked.arm_expansion, worked.block_determinants[0]
        yield worked.wrist_expansion, worked.block_determinants[1]
    elif QUESTIONS["determinant"].find_obstacle(chain) is None:
        yield worked.expansion, worked.derivation.determinant


@pytest.mark.parametrize("variation", select_for_suite(("full",), tuple(VARIATION_STEPS)))
def test_every_intermediate_is_the_determinant(family: str, variation: str) -> None:
    for expansion, determinant in worked_determinants(sample_chain(ProblemId(family, 0, variation=variation))):
        symbols = set(determinant.free_symbols).union(*(line.free_symbols for line in expansion.products))
        for step in expansion.steps:
            symbols |= step.factor.free_symbols | step.matrix.free_symbols
        drawing = random.Random(f"{family} {variation}")
        for _ in range(3):
            at = {symbol: sp.Rational(drawing.randint(-300, 300), 100) for symbol in sorted(symbols, key=str)}
            value = sp.N(determinant.xreplace(at), 15)
            intermediates = [
                step.factor.xreplace(at) * step.matrix.xreplace(at).evalf(20).det() for step in expansion.steps
            ]
            for intermediate in (*intermediates, *(line.xreplace(at) for line in expansion.products)):
                assert abs(sp.N(intermediate, 15) - value) < 1e-9 * max(1, abs(value))


@pytest.mark.parametrize("variation", select_for_suite(("chapter",), ("chapter", "zeros", "full")))
def test_no_line_is_there_twice(family: str, variation: str) -> None:
    chain = sample_chain(ProblemId(family, 0, variation=variation))
    for expansion, _ in worked_determinants(chain):
        shown = [tex(line, chain, SolutionSteps(chain).angles) for line in expansion.products]
        unsigned = ["".join(sorted(line.replace("-", "").replace("+", "").replace(" ", ""))) for line in shown]
        assert len(set(unsigned)) == len(unsigned), shown


def test_a_matrix_is_taken_apart_where_zeros_are() -> None:
    a, b, c, d, e = sp.symbols("a b c d e")
    expansion = expand_determinant(sp.Matrix([[a, b, d], [c, d, e], [0, 0, e]]))
    assert [(step.kind, step.line, step.entry) for step in expansion.steps] == [("alone", "row 3", e)]
    assert expansion.products == (e * (a * d - b * c),)


def numbers(symbols: set[sp.Symbol], seed: str) -> dict[sp.Symbol, sp.Expr]:
    drawing = random.Random(seed)
    return {symbol: sp.Rational(drawing.randint(20, 300), 100) for symbol in sorted(symbols, key=str)}


def near(first: sp.Expr, second: sp.Expr) -> bool:
    return bool(abs(sp.N(first - second, 20)) < 1e-12)


@pytest.mark.parametrize("family", ["elbow-3r", "orthogonal-3r", "wrist-zyz"])
def test_joint_1_has_a_value_at_which_the_jacobian_is_short(family: str) -> None:
    worked = SolutionSteps(sample_chain(ProblemId(family, 0, variation="full")))
    assert worked.expansion.steps[0].kind == "joint"
    shown = worked.expansion.steps[0].matrix
    there = worked.derivation.jacobian.xreplace({worked.chain.q[0]: worked.joint_1_value})
    at = numbers(there.free_symbols | shown.free_symbols, family)
    assert all(near(a.xreplace(at), b.xreplace(at)) for a, b in zip(there, shown, strict=True))


def test_what_is_told_of_a_structure_is_found_once_for_all_its_arms() -> None:
    first, second = (SolutionSteps(sample_chain(ProblemId("elbow-3r", seed, variation="zeros"))) for seed in (1, 2))
    assert first.chain != second.chain and first._structure == second._structure
    assert expand_jacobian(first._structure) is expand_jacobian(second._structure)
    assert _compute_cofactors(first._structure) is _compute_cofactors(second._structure)
    for worked in (first, second):
        left = worked.derivation.jacobian * worked.cofactors.T - worked.derivation.determinant * sp.eye(3)
        assert all(near(e.xreplace(numbers(left.free_symbols, "inverse")), sp.S.Zero) for e in left)
