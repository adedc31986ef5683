"""Every step by which a determinant is worked out has its value, and no line is there twice."""

import random
from collections.abc import Iterator

import pytest
import sympy as sp

from exercises import generate
from exercises.problem import Problem
from exercises.variation import STEPS
from exercises.writing.expansion import Expansion, expanded, expansion_of
from exercises.writing.latex import tex
from exercises.writing.statement import worked_solution
from exercises.writing.worked import Worked
from tests.support.problems import drawn
from tests.support.suites import several


def worked_determinants(problem: Problem) -> Iterator[tuple[Expansion, sp.Expr]]:
    """Yield (expansion, determinant) of all that a problem's solutions work out."""
    worked = Worked(problem.chain)
    if "determinant" in {part.name for part in problem.parts} and worked.blocks is None:
        yield worked.expansion, worked.d.determinant
    if worked.blocks is not None:
        yield worked.arm_expansion, worked.blocks[0]
        yield worked.wrist_expansion, worked.blocks[1]


@pytest.mark.parametrize("variation", several(("lengths", "full"), tuple(STEPS)))
def test_every_intermediate_is_the_determinant(family: str, variation: str) -> None:
    for expansion, determinant in worked_determinants(drawn(family, 0, variation)):
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
    problem = drawn(family, 0, variation)
    for expansion, _ in worked_determinants(problem):
        shown = [tex(line, problem.chain, Worked(problem.chain).angles) for line in expansion.products]
        unsigned = ["".join(sorted(line.replace("-", "").replace("+", "").replace(" ", ""))) for line in shown]
        assert len(set(unsigned)) == len(unsigned), shown


def test_a_matrix_is_taken_apart_where_zeros_are() -> None:
    a, b, c, d, e = sp.symbols("a b c d e")
    expansion = expanded(sp.ImmutableMatrix([[a, b, d], [c, d, e], [0, 0, e]]))
    assert [(step.kind, step.line, step.entry) for step in expansion.steps] == [("alone", "row 3", e)]
    assert expansion.products == (e * (a * d - b * c),)


def test_an_orthogonal_arm_is_seen_from_a_frame_in_which_one_product_is_left() -> None:
    expansion = expansion_of(Worked(drawn("orthogonal-3r", 0, "chapter").chain)._structure)
    assert [step.kind for step in expansion.steps] == ["frame"]
    assert expansion.seen
    assert not expansion.theorem


def test_lengths_that_are_added_stay_together() -> None:
    chain = generate("cylindrical/200@full", ["determinant"]).chain
    lines = [tex(line, chain) for line in Worked(chain).expansion.products]
    assert lines[-2:] == [r"(d_{3} + 0.9) (c_{1}^{2} + s_{1}^{2})", "d_{3} + 0.9"]


def test_a_single_product_of_two_is_told_as_one_and_not_checked_by_itself() -> None:
    problem = generate("planar-pr/675@chapter", ["determinant"])
    text = worked_solution(problem, problem.parts[0])
    assert "here one of the two products is zero:" in text
    assert "Only one product" not in text and "**Check:**" not in text
