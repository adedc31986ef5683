"""What a wrong answer lacks is named link by link, where no mistake of the catalogue gives it."""

import itertools
import re

import pytest
import sympy as sp

from exercises.answers import Matrix
from exercises.arm.stages import carried, formulas
from exercises.generation import generate, sample_chain
from exercises.problem import Part, Problem, ProblemId
from tests.support.judging import diagnose
from tests.support.problems import asked


def answer_without(problem: Problem, part: Part, left_out: dict[int, tuple[int, ...]]) -> str:
    """Return the Jacobian with the parts of some links left out of some columns."""
    w = formulas(problem.chain)
    assert isinstance(part.answer, Matrix)
    found = part.answer.reference.as_mutable()
    for column, links in left_out.items():
        for row, name in enumerate(problem.chain.task):
            if name.startswith("w"):
                continue
            found[row, column] -= sum(w["effects"][column][k]["xyz".index(name[1])][0] for k in links)
    return str(found.tolist())


@pytest.mark.parametrize("family", ["planar-3r", "elbow", "scorbot-wrist", "orthogonal-3r"])
def test_links_left_out_of_several_columns_are_named(family: str) -> None:
    problem = generate(ProblemId(family, 1, ("jacobian",)))
    (part,) = problem.parts
    w = formulas(problem.chain)
    rows = ["xyz".index(name[1]) for name in problem.chain.task if name.startswith("v")]
    moved = [
        [k for k in carried(problem.chain) if any(w["effects"][column][k][row][0] != 0 for row in rows)]
        for column in range(problem.chain.n)
    ]
    columns = [column for column in range(problem.chain.n) if len(moved[column]) > 1]
    assert len(columns) > 1
    for first, second in itertools.combinations(columns, 2):
        left_out = {first: (moved[first][-1],), second: tuple(moved[second][:-1])}
        found = diagnose(problem, part, answer_without(problem, part, left_out), "seed")
        assert found is not None, left_out
        if found.mistakes == ("chain-rule",) and "; " in found.says:
            assert f"olumn {first + 1} seems to lack" in found.says and f"olumn {second + 1}" in found.says


def test_links_left_out_of_the_position_are_named() -> None:
    problem = generate(ProblemId("planar-3r", 1, ("position",)))
    links = formulas(problem.chain)["links"]
    lost = sp.Matrix([sum(links[k][row][0] for k in (0, 2)) for row in range(2)])
    found = diagnose(problem, problem.parts[0], str((problem.parts[0].answer.as_matrix() - lost).tolist()), "seed")
    assert found is not None and "link 1 and link 3" in found.says
    jacobian = asked("jacobian", sample_chain(ProblemId("planar-3r", 1)))
    text = answer_without(jacobian, jacobian.parts[0], {0: (0, 1), 1: (2,)})
    found = diagnose(jacobian, jacobian.parts[0], text, "seed")
    assert found is not None and re.search("olumn 1 .*link 1 and link 2 .*column 2 ", found.says)


@pytest.mark.parametrize("family", ["planar-3r", "elbow"])
def test_zeros_and_other_sums_are_not_blamed(family: str) -> None:
    problem = generate(ProblemId(family, 1, ("jacobian",)))
    (part,) = problem.parts
    reference = part.answer.as_matrix()
    zero = reference.as_mutable()
    zero[:, 0] = sp.zeros(reference.rows, 1)
    named = diagnose(problem, part, str(zero.tolist()), "seed")
    assert named is None or "lack" not in named.says
    other = reference.as_mutable()
    other[0, 0] += sp.Symbol("a3") * sp.sin(2 * sp.Symbol("theta1"))
    assert diagnose(problem, part, str(other.tolist()), "seed") is None
