"""Wrong answers by people who had not seen the catalogue of mistakes: most are named, and all get a true message.

A line of `slips.jsonl` has the writer, a problem, a part, the typed answer, what the student did, and, for some, the
names that the mistakes must be given. Two people wrote them on 24 November 2026 as edits of worked solutions, which
were all they saw; a quarter have two mistakes at once.

Of 250 answers with one mistake 245 are named, or located in an entry; of 72 with two mistakes, 37, because two mistakes
in the same entries are not separated. The diagnosis of an answer takes 40 ms of processor time on average.

The third writer is a reader who reported answers with a wrong name or none; they are named since.

Three names are not what the student did, but give the same answer: a difference formula taken for a sum is named as a
twist left out (pan-tilt/20); an offset with the wrong sign and a wrong direction as an offset in the wrong radians
(planar-3r/11), and with the wrong sign of a cofactor, as constants with the wrong sign (wrist-zyz/18).
"""

import itertools
import json
import re
from collections import Counter
from functools import cache
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.derivation.graph import compute_symbolic_stages, list_links_to_point
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

pytestmark = pytest.mark.xdist_group("slips")  # so that each is diagnosed once
SLIPS: list[dict[str, Any]] = list(map(json.loads, (DATA / "slips.jsonl").read_text(encoding="utf-8").splitlines()))
SELECTED = range(0, len(SLIPS), select_for_suite(12, 1))
NAMED_SHARE = {1: select_for_suite(0.9, 0.97), 2: select_for_suite(0.2, 0.5)}
"""The share of answers with one mistake, and with two, that must be named; `make test` has only seven with two."""


@cache
def diagnose_slip(index: int) -> tuple[Diagnosis | None, Diagnosis | None]:
    slip = SLIPS[index]
    problem = generate(ProblemId.parse(slip["problem"]), [slip["part"]])
    (part,) = problem.parts
    answer = read_answer(problem, part, slip["answer"], "slips")
    assert judge_parsed(problem, part, answer, "slips").outcome in (Outcome.WRONG, Outcome.PARTIAL), slip
    diagnosis = diagnose(problem, part, answer, "slips")
    return diagnosis, None if diagnosis else advise(problem, part, answer, "slips")


def find_diagnosis(did: str) -> Diagnosis:
    diagnosis, _ = diagnose_slip(next(index for index, slip in enumerate(SLIPS) if slip["did"].startswith(did)))
    assert diagnosis is not None, did
    return diagnosis


@pytest.mark.parametrize("part", sample_for_suite(range(4), 1))
def test_every_wrong_answer_gets_one_message(part: int) -> None:
    for index in SELECTED[part::4]:
        mistake, advice = diagnose_slip(index)
        text = mistake or advice
        assert text is not None and text.feedback.endswith((".", "?")), SLIPS[index]
        assert bool(mistake) != bool(advice), SLIPS[index]


def test_most_mistakes_are_named() -> None:
    totals, named_counts = Counter[int](), Counter[int]()
    for index in SELECTED:
        totals[SLIPS[index]["slips"]] += 1
        named_counts[SLIPS[index]["slips"]] += diagnose_slip(index)[0] is not None
    assert all(named_counts[slips] >= NAMED_SHARE[slips] * totals[slips] for slips in totals), (named_counts, totals)


def test_mistakes_get_their_true_names() -> None:
    named = [index for index, slip in enumerate(SLIPS) if "mistakes" in slip]
    for index in sample_for_suite(named, 15):
        diagnosis, _ = diagnose_slip(index)
        assert diagnosis is not None and set(diagnosis.mistakes) == set(SLIPS[index]["mistakes"]), SLIPS[index]


def test_messages_name_alternatives_and_places() -> None:
    either = find_diagnosis("From 4*sin = cos")
    assert either.are_alternatives and either.names == "tangent-inverted or value-sign-in-set"
    assert "theta2 = pi/2" in find_diagnosis("Solved the condition of the shoulder with one joint alone").feedback
    signatures = [find_diagnosis(f"Solved sin(theta2 + {angle})").signature for angle in ("pi/4", "pi/3")]
    assert signatures[0] == signatures[1]
    for index in SELECTED:
        if SLIPS[index]["problem"].startswith("planar-3r/") and SLIPS[index]["part"] == "singular-angles":
            diagnoses = diagnose_slip(index)
            assert not any(diagnosis and "det J" in diagnosis.feedback for diagnosis in diagnoses), SLIPS[index]


def leave_out_links(problem: Problem, part: Part, left_out: dict[int, tuple[int, ...]]) -> str:
    """Return the Jacobian without the contributions of some links to some columns."""
    stages = compute_symbolic_stages(problem.chain)
    assert isinstance(part.answer, Matrix)
    jacobian = part.answer.reference.as_mutable()
    for column, links in left_out.items():
        for row, name in enumerate(problem.chain.task):
            if name.startswith("w"):
                continue
            jacobian[row, column] -= sum(stages["link derivatives"][column][k]["xyz".index(name[1])][0] for k in links)
    return str(jacobian.tolist())


@pytest.mark.parametrize("family", ["planar-3r", "elbow", "scorbot-wrist", "orthogonal-3r"])
def test_links_left_out_of_several_columns_are_named(family: str) -> None:
    problem = generate(ProblemId(family, 1, ("jacobian",)))
    (part,) = problem.parts
    stages = compute_symbolic_stages(problem.chain)
    rows = ["xyz".index(name[1]) for name in problem.chain.task if name.startswith("v")]
    derivatives = stages["link derivatives"]
    moved_links = [
        [k for k in list_links_to_point(problem.chain) if any(derivatives[column][k][row][0] != 0 for row in rows)]
        for column in range(problem.chain.n)
    ]
    columns = [column for column in range(problem.chain.n) if len(moved_links[column]) > 1]
    assert len(columns) > 1
    for first, second in itertools.combinations(columns, 2):
        left_out = {first: (moved_links[first][-1],), second: tuple(moved_links[second][:-1])}
        diagnosis = judging.diagnose(problem, part, leave_out_links(problem, part, left_out), "seed")
        assert diagnosis is not None, left_out
        if diagnosis.mistakes == ("chain-rule",) and "; " in diagnosis.feedback:
            assert all(f"in column {column + 1}" in diagnosis.feedback for column in (first, second))


def test_links_left_out_of_the_position_are_named() -> None:
    problem = generate(ProblemId("planar-3r", 1, ("position",)))
    links = compute_symbolic_stages(problem.chain)["link vectors"]
    lost = sp.Matrix([sum(links[k][row][0] for k in (0, 2)) for row in range(2)])
    diagnosis = judging.diagnose(
        problem, problem.parts[0], str((problem.parts[0].answer.as_matrix() - lost).tolist()), "seed"
    )
    assert diagnosis is not None and "link 1 and link 3" in diagnosis.feedback
    jacobian = ask_question("jacobian", sample_chain(ProblemId("planar-3r", 1)))
    text = leave_out_links(jacobian, jacobian.parts[0], {0: (0, 1), 1: (2,)})
    diagnosis = judging.diagnose(jacobian, jacobian.parts[0], text, "seed")
    assert diagnosis is not None and re.search("link 1 and link 2 to column 1, and .* to column 2", diagnosis.feedback)


@pytest.mark.parametrize("family", ["planar-3r", "elbow"])
def test_zero_columns_and_extra_terms_are_no_links_left_out(family: str) -> None:
    problem = generate(ProblemId(family, 1, ("jacobian",)))
    (part,) = problem.parts
    reference = part.answer.as_matrix()
    zero_column = reference.as_mutable()
    zero_column[:, 0] = sp.zeros(reference.rows, 1)
    zero_diagnosis = judging.diagnose(problem, part, str(zero_column.tolist()), "seed")
    assert zero_diagnosis is None or "chain-rule" not in zero_diagnosis.mistakes
    extended = reference.as_mutable()
    extended[0, 0] += sp.Symbol("a3") * sp.sin(2 * sp.Symbol("theta1"))
    diagnosis = judging.diagnose(problem, part, str(extended.tolist()), "seed")
    assert diagnosis is not None and diagnosis.mistakes == ("term-surplus",) and "a3" in diagnosis.feedback
