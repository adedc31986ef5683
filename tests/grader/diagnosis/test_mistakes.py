"""Wrong answers that two people wrote who had not seen the catalogue: most are named, and each gets something true.

In `slips.jsonl`: whose hand, a problem, a part, the answer as it was typed, and what the student did. Written on 24
November 2026 by two hands that saw worked solutions only, as edits of these, a quarter of them with two slips at once.

Of 250 answers with one slip 245 are named, or the entry and what is wrong there, of 72 with two slips 37: two mistakes
that change the same entries are not taken apart. The diagnosis of an answer takes 40 ms of processor time on average.

The third hand is that of a reader who found the wrong name behind these answers, or none: they are named since.

Three names are not what the student did, and give the very same answer: a difference formula taken for a sum is a twist
that is left out (pan-tilt/20); an offset with the wrong sign and the direction that is not lost are an offset in
the wrong radians (planar-3r/11), and with the wrong sign of a cofactor, constants with the wrong sign (wrist-zyz/18).
"""

import itertools
import json
import re
from collections import Counter
from functools import cache
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.arm.derivation_graph import compute_symbolic_stages, links_to_point
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.reference_answers import Matrix
from qdot.grader.diagnosis.advice import advise
from qdot.grader.diagnosis.diagnosis import diagnose
from qdot.grader.judging.expected_form import read_answer
from qdot.grader.judging.judge import judge_parsed
from qdot.grader.judging.verdict import Diagnosis, Outcome
from tests.support import DATA, judging
from tests.support.problems import ask_question
from tests.support.suites import sample_for_suite, select_for_suite

pytestmark = pytest.mark.xdist_group("slips")  # each is diagnosed once
SLIPS: list[dict[str, Any]] = list(map(json.loads, (DATA / "slips.jsonl").read_text(encoding="utf-8").splitlines()))
TAKEN = range(0, len(SLIPS), select_for_suite(12, 1))
NAMED = {1: select_for_suite(0.9, 0.97), 2: select_for_suite(0.4, 0.5)}
"""The share of answers with one slip, and with two, behind which mistakes are named."""


@cache
def told(index: int) -> tuple[Diagnosis | None, Diagnosis | None]:
    """Return the mistake that is named, or what is said where there is none."""
    slip = SLIPS[index]
    problem = generate(ProblemId.parse(slip["problem"]), [slip["part"]])
    (part,) = problem.parts
    given = read_answer(problem, part, slip["answer"], "slips")
    assert judge_parsed(problem, part, given, "slips").outcome in (Outcome.WRONG, Outcome.PARTIAL), slip
    named = diagnose(problem, part, given, "slips")
    return named, None if named else advise(problem, part, given, "slips")


def named(did: str) -> Diagnosis:
    """Return the mistake that is named behind the slip of a student who did this."""
    made, _ = told(next(index for index, slip in enumerate(SLIPS) if slip["did"].startswith(did)))
    assert made is not None, did
    return made


@pytest.mark.parametrize("part", sample_for_suite(range(4), 2))
def test_something_is_said_of_every_wrong_answer(part: int) -> None:
    for index in TAKEN[part::4]:
        mistake, advice = told(index)
        text = mistake or advice
        assert text is not None and text.says.endswith((".", "?")), SLIPS[index]
        assert bool(mistake) != bool(advice), SLIPS[index]


def test_most_are_named() -> None:
    made, known = Counter[int](), Counter[int]()
    for index in TAKEN:
        made[SLIPS[index]["slips"]] += 1
        known[SLIPS[index]["slips"]] += told(index)[0] is not None
    assert all(known[slips] >= NAMED[slips] * made[slips] for slips in made), (known, made)


@pytest.mark.parametrize(
    ("did", "mistakes"),
    sample_for_suite([
        ("Typed the angles", "angles-in-degrees"), ("Typed s12 as sin", "sum-of-angles-split"),
        ("Typed pi/3 for the", "wrong-radians"), ("Typed the offset of 60", "offset-in-degrees"),
        ("Multiplied F by", "jacobian-for-transpose"),
        ("Overlooked the offset of 45 degrees at theta3 in row 3 of the table.", "offset-forgotten"),
        ("Took O5, the tip", "other-point"), ("Lost the term 0.75", "term-missing"),
        ("Sign slip when the", "product-sign"), ("Left out the bracket of the denominator: /d3", "bracket-missing"),
        ("Turned only the", "vectors-left-in-base"), ("Turned 1/0.75 into", "number-inverted"),
        ("Saw that the arm", "rank-of-one-condition"), ("Added 0.2 + 0.4*cos", "unlike-terms-added"),
        ("Took only the positive", "one-root-of-each"),
        ("Used the Jacobian at the start A instead of the one at the place 0.3 ", "rates-at-start"),
        ("Typed fy instead", "symbol-typed"), ("Counted the orientation", "orientation-as-one-component"),
        ("Typed the lengths", "lengths-in-centimetres"), ("Added joint 2 to", "term-surplus"),
        ("Sign slip in the", "term-sign-typed"), ("From 4*sin = cos", "tangent-inverted + value-sign-in-set"),
        ("Took the moment arms", "point-forgotten"), ("Squared the sum", "sum-squared"),
        ("Overlooked the minus", "velocity-sign"), ("Product rule forgotten", "chain-rule"),
        ("Multiplied the base", "rotated-the-wrong-way"), ("Dropped the offset 0.5", "offset-forgotten-on-path"),
        ("Typed sin(theta3", "sum-of-angles-split"), ("Took the unit vector", "path-reversed"),
        ("Lost one of the", "square-lost"), ("Added the determinants of the two", "blocks-added"),
        ("Gave the components", "earlier-frame"), ("Converted 30 deg", "values-in-wrong-radians"),
        ("Left the offset of 90 degrees out", "offset-forgotten-in-set"),
        ("Solved sin(theta2 + pi/4", "offset-sign-in-set"),
        ("Left the offset of 90 degrees out,", "value-called-singular + component-missed"),
        ("Forgot that theta3", "condition-of-several-forgotten"),
        ("Forgot the condition", "condition-of-several-forgotten"), ("Gave one root of", "one-root-only"),
        ("Gave the other root", "one-root-only"), ("Gave the conditions", "or-for-and"),
        ("Solved the condition", "shoulder-missed"), ("Called theta1 =", "shoulder-missed"),
        ("Took p* from the", "arm-reversed"), ("Gave the whole Jacobian", "sign"),
        ("Gave the three rows", "other-rows"),
        ("Cancelled d3 from", "component-missed + one-root-only"),
    ], 15),
)  # fmt: skip
def test_by_their_true_names(did: str, mistakes: str) -> None:
    assert set(named(did).mistakes) == set(mistakes.split(" + "))


def test_what_is_said_behind_some_of_them() -> None:
    either = named("From 4*sin = cos")
    assert either.are_alternatives and either.names == "tangent-inverted or value-sign-in-set"
    assert "theta2 = pi/2" in named("Solved the condition of the shoulder with one joint alone").says
    on_two_arms = [named(f"Solved sin(theta2 + {angle})").signature for angle in ("pi/4", "pi/3")]
    assert on_two_arms[0] == on_two_arms[1]
    for index in TAKEN:
        if SLIPS[index]["problem"].startswith("planar-3r/") and SLIPS[index]["part"] == "singular-angles":
            assert not any(one and "det J" in one.says for one in told(index)), SLIPS[index]


def answer_without(problem: Problem, part: Part, left_out: dict[int, tuple[int, ...]]) -> str:
    """Return the Jacobian with the parts of some links left out of some columns."""
    w = compute_symbolic_stages(problem.chain)
    assert isinstance(part.answer, Matrix)
    found = part.answer.reference.as_mutable()
    for column, links in left_out.items():
        for row, name in enumerate(problem.chain.task):
            if name.startswith("w"):
                continue
            found[row, column] -= sum(w["link derivatives"][column][k]["xyz".index(name[1])][0] for k in links)
    return str(found.tolist())


@pytest.mark.parametrize("family", ["planar-3r", "elbow", "scorbot-wrist", "orthogonal-3r"])
def test_links_left_out_of_several_columns_are_named(family: str) -> None:
    problem = generate(ProblemId(family, 1, ("jacobian",)))
    (part,) = problem.parts
    w = compute_symbolic_stages(problem.chain)
    rows = ["xyz".index(name[1]) for name in problem.chain.task if name.startswith("v")]
    moved = [
        [k for k in links_to_point(problem.chain) if any(w["link derivatives"][column][k][row][0] != 0 for row in rows)]
        for column in range(problem.chain.n)
    ]
    columns = [column for column in range(problem.chain.n) if len(moved[column]) > 1]
    assert len(columns) > 1
    for first, second in itertools.combinations(columns, 2):
        left_out = {first: (moved[first][-1],), second: tuple(moved[second][:-1])}
        found = judging.diagnose(problem, part, answer_without(problem, part, left_out), "seed")
        assert found is not None, left_out
        if found.mistakes == ("chain-rule",) and "; " in found.says:
            assert all(f"in column {column + 1}" in found.says for column in (first, second))


def test_links_left_out_of_the_position_are_named() -> None:
    problem = generate(ProblemId("planar-3r", 1, ("position",)))
    links = compute_symbolic_stages(problem.chain)["links"]
    lost = sp.Matrix([sum(links[k][row][0] for k in (0, 2)) for row in range(2)])
    found = judging.diagnose(
        problem, problem.parts[0], str((problem.parts[0].answer.as_matrix() - lost).tolist()), "seed"
    )
    assert found is not None and "link 1 and link 3" in found.says
    jacobian = ask_question("jacobian", sample_chain(ProblemId("planar-3r", 1)))
    text = answer_without(jacobian, jacobian.parts[0], {0: (0, 1), 1: (2,)})
    found = judging.diagnose(jacobian, jacobian.parts[0], text, "seed")
    assert found is not None and re.search("link 1 and link 2 in column 1; .* in column 2", found.says)


@pytest.mark.parametrize("family", ["planar-3r", "elbow"])
def test_zeros_and_other_sums_are_not_blamed(family: str) -> None:
    problem = generate(ProblemId(family, 1, ("jacobian",)))
    (part,) = problem.parts
    reference = part.answer.as_matrix()
    zero = reference.as_mutable()
    zero[:, 0] = sp.zeros(reference.rows, 1)
    named = judging.diagnose(problem, part, str(zero.tolist()), "seed")
    assert named is None or "chain-rule" not in named.mistakes
    other = reference.as_mutable()
    other[0, 0] += sp.Symbol("a3") * sp.sin(2 * sp.Symbol("theta1"))
    found = judging.diagnose(problem, part, str(other.tolist()), "seed")
    assert found is not None and found.mistakes == ("term-surplus",) and "a3" in found.says
