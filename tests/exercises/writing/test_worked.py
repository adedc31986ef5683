"""What a worked solution says of its steps, of determinants and of singular configurations is so for its arm."""

import random
import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import CONVENTIONS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.directions import task_rows
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.common.variation import STEPS
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.inversion import InSituation
from qdot.exercises.questions.rank import OfMotion
from qdot.exercises.writing.cases import cases_of, minors_of
from qdot.exercises.writing.expansion import Expansion, expanded, expansion_of
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.statement import hints, statement, worked_solution, worked_solutions, worked_steps
from qdot.exercises.writing.worked import Worked, _at_once, _cofactors
from tests.support.suites import few_families, few_of, several


@pytest.mark.parametrize(
    ("problem_id", "inverse", "rates"),
    [
        ("cartesian/738@zeros", False, False),
        ("polar-rp/837@frames@modified-dh", False, False),
        ("planar-rpr/835@frames", False, False),
        ("random-3/638@chapter@modified-dh", False, False),
        ("planar-3r-pose/819@lengths", True, True),
        ("planar-3r-pose/30003@lengths", True, True),  # 9/40 over 3/10: a length has cancelled
        ("wrist-zyz/241@lengths", True, True),
        ("elbow/640@lengths", True, True),
    ],
)
def test_factors_cancel_where_it_is_said(problem_id: str, inverse: bool, rates: bool) -> None:
    problem = generate(problem_id, ["inverse-jacobian", "inverse-velocity"])
    steps = Worked(problem.chain)
    assert (steps.inverse_cancels, steps.rates_cancel) == (inverse, rates)
    texts = {part.kind: worked_solution(problem, part) for part in problem.parts}
    assert ("common factors" in texts["inverse-jacobian"]) == (inverse and problem.chain.n > 2)
    assert ("common factors" in texts["inverse-velocity"]) == rates


BOTH = ("inverse-jacobian", "inverse-velocity")
TABLE = r"\begin{bmatrix}"
LAST_COLUMN = "the last column of $R_{i-1}$"
SAYS = [
    # problem, questions, the one that is looked at, what its solution says, and what it does not say
    ("elbow-lateral/607@zeros", BOTH, 1, "found above", TABLE),  # the rates go on from the inverse
    ("elbow-lateral/607@zeros", BOTH[1:], 0, TABLE, "found above"),
    ("elbow-lateral/607@zeros", BOTH, 0, "", "-0.45 c_{2} + a_{3}"),  # signs are alike in a row
    ("elbow-lateral/295@full@screws", BOTH, 1, "", "(-"),
    ("orthogonal-3r/647@frames", BOTH[:1], 0, "0.5 c_{2}^{2}", "0.5 s_{2}^{2}"),  # squares are taken together
    ("wrist-zyz/241@lengths", ("jacobian", "joint-axes"), 0, LAST_COLUMN, "found above"),
    ("wrist-zyz/241@lengths", ("jacobian", "joint-axes"), 1, "found above", "$R_{i-1}$"),
    ("planar-pr/675@chapter", ("link-velocity",), 0, "slides along its axis", "turns about"),
    ("planar-2r/416@frames", ("joint-axes",), 0, "", "180°"),  # no half twist
    ("scara/808@lengths", ("joint-axes",), 0, "180°", "found above"),
]


@pytest.mark.parametrize(("problem_id", "names", "which", "there", "not_there"), SAYS)
def test_steps_are_told_as_they_are_for_this_arm(
    problem_id: str, names: tuple[str, ...], which: int, there: str, not_there: str
) -> None:
    text = worked_solutions(generate(problem_id, list(names)))[names[which]]
    if not_there.startswith("-"):
        text = text.rpartition("common factors")[2]
    assert there in text and not_there not in text


SCREWS = (
    "home-screws", "position", "joint-axes", "joint-effect", "geometric-jacobian", "space-jacobian",
    "space-twist", "body-pose",
)  # fmt: skip


def told(problem_id: str, *names: str) -> str:
    """Return statement, hints and solutions."""
    problem = generate(problem_id, list(names))
    parts = [text for part in problem.parts for text in (*hints(problem, part), worked_solution(problem, part))]
    return "".join((statement(problem, ""), *parts))


@pytest.mark.whole
def test_slides_are_spoken_of_where_there_are_some() -> None:
    revolute = told("elbow-lateral/295@full@screws", *SCREWS)
    revolute += told("wrist-rpy/745@zeros@screws", "jacobian", "joint-axes")
    assert not [word for word in ("slide", "prismatic", "v_i'", "v_{i}'") if word in revolute]
    both = told("scara/1@chapter@screws", "position", "joint-axes", "space-jacobian", "space-twist")
    assert "prismatic" in both and "v_i'" in both


NAMES = {"dh": "$O_{2}$ lies", "modified-dh": "$O_{3}$ lies", "screws": "$q_{3}'$ lies"}
LEAST = "It holds somewhere only if"


def solution(identity: str, question: str, convention: str = "dh") -> str:
    problem = generate(replace(ProblemId.parse(identity), questions=(question,)).with_convention(convention))
    (part,) = problem.parts
    return worked_solution(problem, part)


@pytest.mark.parametrize("convention", few_of(CONVENTIONS, 1))
def test_an_origin_has_the_name_that_the_arms_convention_has_for_it(convention: str) -> None:
    """O_2 of the standard table is on the axis of joint 3: the origin of frame 3 of a modified one."""
    assert NAMES[convention] in solution("orthogonal-3r/776@frames", "singular-angles", convention)


def test_where_an_arm_has_no_name_for_an_origin_what_is_true_of_all_is_said() -> None:
    chain = sample_chain(
        ProblemId.parse("cylindrical/1@chapter").with_convention("screws")
    )  # joints 2 and 3 are slides
    words = convention_of(chain).rename_origins("the origin O2 lies on the axis of joint 1")
    assert words == "the columns of J are linearly dependent"


def test_values_that_are_of_different_kinds_are_told_apart_and_equal_ones_together() -> None:
    """Of a planar arm of three joints: stretched out, or folded back in any of three ways."""
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


@few_families
def test_a_direction_that_is_lost_is_perpendicular_to_all_columns_that_are_shown(family: str) -> None:
    for step in ("chapter", "full"):
        problem = _asking(family, step, "lost-motion")
        if problem is None:
            return
        chain, (part,) = problem.chain, problem.parts
        example = worked_steps(chain).lost_example(part.about(OfMotion).asked.where)
        assert example is not None
        jacobian, lost = (np.array(matrix.tolist(), dtype=float) for matrix in (example.jacobian, example.lost))
        assert np.abs(jacobian.T @ lost).max() < 2e-3 * np.abs(jacobian).max()
        if not example.about:
            arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in example.lengths.items()})
            own = arm.jacobian(np.array([float(sp.N(example.joints[q])) for q in chain.q]))[task_rows(chain)]
            assert np.allclose(own, jacobian, rtol=1e-3, atol=1e-4)
        is_long = worked_steps(chain).lost_where(part.about(OfMotion).asked.where) is None
        assert is_long == ("In numbers, " in worked_solution(problem, part))


def _asking(family: str, step: str, question: str) -> Problem | None:
    identity = ProblemId(family, 3).with_variation(step)
    if QUESTIONS[question].objects(sample_chain(identity)) is not None:
        return None
    return generate(replace(identity, questions=(question,)))


@pytest.mark.parametrize("family", ["stanford-6r", "puma-560", "anthropomorphic-6r"])
def test_rates_by_blocks_are_the_reference(family: str) -> None:
    problem = generate(ProblemId(family, 4, ("joint-rates",)).with_variation("zeros"))
    (part,) = problem.parts
    blocks = worked_steps(problem.chain).rates_by_blocks(part.about(InSituation).situation)
    assert blocks is not None
    shown = np.array([*blocks.first, *blocks.last], dtype=float)
    assert np.allclose(shown, np.array(part.answer.as_matrix(), dtype=float).ravel(), rtol=1e-3, atol=1e-6)
    for inverse, right, rates in ((blocks.arm, blocks.linear, blocks.first), (blocks.wrist, blocks.left, blocks.last)):
        assert np.allclose(np.array(inverse * right - rates, dtype=float), 0, atol=5e-3)


def test_determinants_of_blocks_are_not_worked_out_twice() -> None:
    problem = generate(ProblemId("stanford-6r", 4, ("block-determinants", "determinant")).with_variation("zeros"))
    first, second = worked_solutions(problem).values()
    assert "found above" in second and "The wrist" not in second and "found above" not in first


def worked_determinants(chain: Chain) -> Iterator[tuple[Expansion, sp.Expr]]:
    """Yield (expansion, determinant) of all that solutions on an arm work out."""
    worked = Worked(chain)
    if worked.blocks is not None:
        yield worked.arm_expansion, worked.blocks[0]
        yield worked.wrist_expansion, worked.blocks[1]
    elif QUESTIONS["determinant"].refusal(chain) is None:
        yield worked.expansion, worked.d.determinant


@pytest.mark.parametrize("variation", several(("full",), tuple(STEPS)))
def test_every_intermediate_is_the_determinant(family: str, variation: str) -> None:
    for expansion, determinant in worked_determinants(sample_chain(ProblemId(family, 0, variation=variation))):
        symbols = set(determinant.free_symbols).union(*(line.free_symbols for line in expansion.products))
        for step in expansion.steps:
            symbols |= step.outside.free_symbols.union(*(matrix.free_symbols for matrix in step.inside))
        drawing = random.Random(f"{family} {variation}")
        for _ in range(3):
            at = {symbol: sp.Rational(drawing.randint(-300, 300), 100) for symbol in sorted(symbols, key=str)}
            value = sp.N(determinant.xreplace(at), 15)
            intermediates = [
                step.outside.xreplace(at) * sp.Mul(*(matrix.xreplace(at).evalf(20).det() for matrix in step.inside))
                for step in expansion.steps
            ]
            for intermediate in (*intermediates, *(line.xreplace(at) for line in expansion.products)):
                assert abs(sp.N(intermediate, 15) - value) < 1e-9 * max(1, abs(value))


@pytest.mark.parametrize("variation", several(("chapter",), ("chapter", "zeros", "full")))
def test_no_line_is_there_twice(family: str, variation: str) -> None:
    chain = sample_chain(ProblemId(family, 0, variation=variation))
    for expansion, _ in worked_determinants(chain):
        shown = [tex(line, chain, Worked(chain).angles) for line in expansion.products]
        unsigned = ["".join(sorted(line.replace("-", "").replace("+", "").replace(" ", ""))) for line in shown]
        assert len(set(unsigned)) == len(unsigned), shown


def test_a_matrix_is_taken_apart_where_zeros_are() -> None:
    a, b, c, d, e = sp.symbols("a b c d e")
    expansion = expanded(sp.ImmutableMatrix([[a, b, d], [c, d, e], [0, 0, e]]))
    assert [(step.kind, step.line, step.entry) for step in expansion.steps] == [("alone", "row 3", e)]
    assert expansion.products == (e * (a * d - b * c),)


def test_an_orthogonal_arm_is_seen_from_a_frame_in_which_one_product_is_left() -> None:
    expansion = expansion_of(Worked(sample_chain(ProblemId("orthogonal-3r", 0, variation="chapter")))._structure)
    assert [step.kind for step in expansion.steps] == ["frame"]
    assert expansion.seen
    assert not expansion.theorem


NOT_SQUARE = ("planar-3r", "pan-tilt", "scorbot-wrist", *several((), ("scorbot-tip", "lbr-7r")))


def generic(family: str, variation: str = "zeros") -> Chain:
    return structure(sample_chain(ProblemId(family, 0, variation=variation))).chain


def numbers(symbols: set[sp.Symbol], seed: str) -> dict[sp.Symbol, sp.Expr]:
    drawing = random.Random(seed)
    return {symbol: sp.Rational(drawing.randint(20, 300), 100) for symbol in sorted(symbols, key=str)}


def near(one: sp.Expr, other: sp.Expr) -> bool:
    return bool(abs(sp.N(one - other, 20)) < 1e-12)


@pytest.mark.parametrize("family", NOT_SQUARE)
@pytest.mark.parametrize("variation", several(["full"], ["chapter", "full"]))
def test_every_line_of_a_minor_is_that_minor_of_the_matrix_shown(family: str, variation: str) -> None:
    chain = generic(family, variation)
    minors = minors_of(chain)
    at = numbers(minors.matrix.free_symbols | set(chain.q), f"{family} {variation}")
    for value, expansion in zip(minors.values, minors.expansions, strict=True):
        for line in expansion.products:
            assert near(line.xreplace(at), value.xreplace(at))


@pytest.mark.parametrize("family", NOT_SQUARE)
def test_the_matrix_shown_has_the_rank_of_the_jacobian(family: str) -> None:
    chain = generic(family, "full")
    minors = minors_of(chain)
    jacobian = derive(chain).jacobian
    at = numbers(jacobian.free_symbols | set(chain.q), family)
    if minors.at_zero:
        square = [(j.T * j).xreplace(at).evalf(30).det() for j in (minors.matrix, jacobian)]
        assert near(*square)
    else:
        square = [(j * j.T).xreplace(at).evalf(30).det() for j in (minors.matrix, jacobian)]
        assert (abs(square[0]) < 1e-12) == (abs(square[1]) < 1e-12)


@pytest.mark.parametrize("family", few_of(NOT_SQUARE, 2))
def test_what_is_left_of_a_minor_is_that_minor_where_the_factor_vanishes(family: str) -> None:
    chain = generic(family)
    minors = minors_of(chain)
    cases = cases_of(chain, minors.values)
    assert cases is not None
    for case in cases.cases:
        assert case.factor.func in (sp.sin, sp.cos)
        (angle,) = case.factor.args
        joint = min(angle.free_symbols, key=str)
        for zero in (sp.S.Zero, sp.pi) if case.factor.func is sp.sin else (sp.pi / 2, -sp.pi / 2):
            at = numbers(minors.matrix.free_symbols | set(chain.q), family)
            at[joint] = zero - (angle - joint).xreplace(at)
            left = dict(case.left)
            for number, minor in enumerate(minors.values, 1):
                if number != cases.pivot:
                    assert near(left.get(number, sp.S.Zero).xreplace(at), minor.xreplace(at))


@pytest.mark.parametrize("family", NOT_SQUARE)
def test_the_cases_find_the_whole_singular_set(family: str) -> None:
    chain = generic(family)
    cases = cases_of(chain, minors_of(chain).values)
    components = singular_set(chain)
    assert cases is not None
    assert components is not None
    found = len(cases.shared) + sum(map(len, (case.others for case in cases.cases)))
    assert found == len(components)


@pytest.mark.parametrize("family", ["planar-rpr", "planar-3r-pose"])
def test_a_determinant_is_told_whose_columns_are_taken_from_one_another(family: str) -> None:
    """For that, a matrix is changed, which has to be one that can be."""
    worked = Worked(sample_chain(ProblemId(family, 0, variation="zeros")))
    assert worked.expansion.products and worked.cofactors.copy().is_square


def test_what_is_told_of_a_structure_is_found_once_for_all_its_arms() -> None:
    first, second = (Worked(sample_chain(ProblemId("elbow-3r", seed, variation="zeros"))) for seed in (1, 2))
    assert first.chain != second.chain and first._structure == second._structure
    assert _at_once(first._structure) is _at_once(second._structure)
    assert _cofactors(first._structure) is _cofactors(second._structure)
    for worked in (first, second):
        assert worked.at_once is not None
        joints = dict(worked.at_once.joints)
        assert sp.expand(worked.d.determinant.xreplace(joints) - worked.at_once.determinant) == 0
        left = worked.d.jacobian * worked.cofactors.T - worked.d.determinant * sp.eye(3)
        assert all(near(e.xreplace(numbers(left.free_symbols, "inverse")), sp.S.Zero) for e in left)
