"""Where the minors of a Jacobian that is not square come from, and how the singular set follows from them."""

import random

import pytest
import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive, structure
from exercises.arm.singularity import singular_set
from exercises.writing.cases import cases_of, minors_of
from exercises.writing.worked import Worked, _at_once, _cofactors
from tests.support.problems import drawn

NOT_SQUARE = ("planar-3r", "pan-tilt", "scorbot-wrist", "scorbot-tip", "lbr-7r")


def generic(family: str, variation: str = "zeros") -> Chain:
    return structure(drawn(family, 0, variation).chain).chain


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
    problem = drawn(family, 0, "full")
    chain = structure(problem.chain).chain
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
    worked = Worked(drawn(family, 0, "zeros").chain)
    assert worked.expansion.products and worked.cofactors.copy().is_square


def test_what_is_told_of_a_structure_is_found_once_for_all_its_arms() -> None:
    first, second = (Worked(drawn("elbow-3r", seed, "zeros").chain) for seed in (1, 2))
    assert first.chain != second.chain and first._structure == second._structure
    assert _at_once(first._structure) is _at_once(second._structure)
    assert _cofactors(first._structure) is _cofactors(second._structure)
    for worked in (first, second):
        assert worked.at_once is not None
        joints = dict(worked.at_once.joints)
        assert sp.expand(worked.d.determinant.xreplace(joints) - worked.at_once.determinant) == 0
        product = worked.d.jacobian * worked.cofactors.T
        assert sp.simplify(product - worked.d.determinant * sp.eye(3)) == sp.zeros(3, 3)
