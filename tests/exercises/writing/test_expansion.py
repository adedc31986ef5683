"""Every step by which determinants and minors are worked out has its value, and no line is there twice."""

import random
from collections.abc import Iterator

import pytest
import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive, structure
from exercises.arm.singularity import singular_set
from exercises.generation import generate, sample_chain
from exercises.problem import ProblemId
from exercises.questions import QUESTIONS
from exercises.variation import STEPS
from exercises.writing.cases import cases_of, minors_of
from exercises.writing.expansion import Expansion, expanded, expansion_of
from exercises.writing.latex import tex
from exercises.writing.worked import Worked, _at_once, _cofactors
from tests.support.suites import several


def worked_determinants(chain: Chain) -> Iterator[tuple[Expansion, sp.Expr]]:
    """Yield (expansion, determinant) of all that solutions on an arm work out."""
    worked = Worked(chain)
    if worked.blocks is not None:
        yield worked.arm_expansion, worked.blocks[0]
        yield worked.wrist_expansion, worked.blocks[1]
    elif QUESTIONS["determinant"].refusal(chain) is None:
        yield worked.expansion, worked.d.determinant


@pytest.mark.parametrize("variation", several(("lengths", "full"), tuple(STEPS)))
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


def test_lengths_that_are_added_stay_together() -> None:
    chain = generate("cylindrical/200@full", ["determinant"]).chain
    lines = [tex(line, chain) for line in Worked(chain).expansion.products]
    assert lines[-2:] == [r"(d_{3} + 0.9) (c_{1}^{2} + s_{1}^{2})", "d_{3} + 0.9"]


NOT_SQUARE = ("planar-3r", "pan-tilt", "scorbot-wrist", "scorbot-tip", "lbr-7r")


def generic(family: str, variation: str = "zeros") -> Chain:
    return structure(sample_chain(ProblemId(family, 0, variation=variation))).chain


def numbers(symbols: set[sp.Symbol], seed: str) -> dict[sp.Symbol, sp.Expr]:
    drawing = random.Random(seed)
    return {symbol: sp.Rational(drawing.randint(20, 300), 100) for symbol in sorted(symbols, key=str)}


def near(one: sp.Expr, other: sp.Expr) -> bool:
    return bool(abs(sp.N(one - other, 20)) < 1e-12)


@pytest.mark.parametrize("family", NOT_SQUARE)
@pytest.mark.parametrize("variation", ["chapter", "full"])
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


@pytest.mark.parametrize("family", NOT_SQUARE)
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
        product = worked.d.jacobian * worked.cofactors.T
        assert sp.simplify(product - worked.d.determinant * sp.eye(3)) == sp.zeros(3, 3)
