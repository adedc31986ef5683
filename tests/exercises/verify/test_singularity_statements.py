"""Statements about singular configurations, also true or false ones, hold, and certificates detect false ones."""

import re
from collections.abc import Iterator
from dataclasses import replace

import pytest

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions.singular import KindDetails
from qdot.exercises.reference_answers import Choice
from qdot.exercises.short_questions.single_configuration import ConfigurationStatement
from qdot.exercises.singularities import classification
from qdot.exercises.singularities.classification import Classification, classify, sample_condition, split_by_value
from qdot.exercises.singularities.normalized_arm import normalize_arm, normalize_conditions
from qdot.exercises.singularities.singular_set import Component, find_singular_set
from qdot.exercises.verify import singularity_statements
from qdot.exercises.verify.certificate import certify
from qdot.exercises.verify.singularity_statements import statement_holds
from qdot.exercises.writing.problem_texts import write_solution
from tests.support.suites import few_families, few_or_all_families, sample_for_suite, select_for_suite

FARTHEST = "as far from the axis of joint 2 as joint 3 can bring it"


def parts(chain: Chain) -> Iterator[tuple[list[str], str]]:
    """Yield conditions of the bare arm, and what is said of them."""
    for component in find_singular_set(chain) or ():
        values = split_by_value(component, classify(chain, component))
        for part in (component, *(part for _, part in values)):
            yield normalize_conditions(chain, part), classify(chain, part).meaning


def are_so(chain: Chain, pieces: list[str], words: str) -> set[bool]:
    arm = normalize_arm(chain)
    samples = [sample for piece in pieces for sample in sample_condition(arm, piece, "test", samples_per_arm=6)]
    return {statement_holds(arm, words, sample) for sample in samples}


@few_or_all_families
def test_what_is_said_is_so(family: str) -> None:
    for step in select_for_suite(("chapter", "full"), tuple(VARIATION_STEPS)):
        for pieces, words in parts(sample_chain(ProblemId(family, 3).with_variation(step))):
            assert are_so(sample_chain(ProblemId(family, 3).with_variation(step)), pieces, words) == {True}, words


@few_families
def test_the_same_of_other_joints_is_not(family: str) -> None:
    """Every number in a sentence counts: with another joint in its place it is false, or says the same."""
    chain = sample_chain(ProblemId(family, 3).with_variation("chapter"))
    for pieces, words in parts(chain):
        for match in re.finditer(r"(?<=joint )\d", words):
            told = int(match[0])
            others = [
                words[: match.start()] + str(n) + words[match.end() :] for n in range(1, chain.n + 1) if n != told
            ]
            assert any(are_so(chain, pieces, other) != {True} for other in others), words


@pytest.mark.parametrize(
    ("identity", "piece", "words", "is_so"),
    sample_for_suite(
        [
            # what was once said, and is not so in all of the configurations: stretched out in a quarter of them;
            # joint 3 is bent; the far end of two, of which the other one is farther
            ("orthogonal-3r/1@chapter", "theta3 = pi", f"the point is {FARTHEST}", False),
            ("random-3/10085@full", "theta2 = pi", "arm folded back", False),
            ("random-3/10002@full", "theta2 = pi", "arm stretched out or folded back", False),
            ("planar-3r/1@chapter", "theta2 = pi and theta3 = pi", "arm folded back", True),
            # each joint alone has the point farthest, both together do not: the links run there, back and there again
            ("planar-3r/1@chapter", "theta2 = pi and theta3 = pi", "arm stretched out", False),
            ("planar-2r/1@chapter", "theta2 = 0", "arm stretched out", True),
            ("planar-2r/1@chapter", "theta2 = 0", "arm folded back", False),
            ("planar-2r/1@chapter", "theta2 = 0", "arm stretched", False),  # words that are not known
            ("planar-2r/1@chapter", "theta2 = 0", "arm stretched out, and joint 1 has no effect on the task", False),
        ],
        3,
    ),
)
def test_what_is_said_of_an_arm_is_true_or_false(identity: str, piece: str, words: str, is_so: bool) -> None:
    chain = sample_chain(ProblemId.parse(identity))
    assert (are_so(chain, [piece], words) == {True}) is is_so
    assert is_so or ([piece], words) not in list(parts(chain))


@pytest.mark.parametrize(
    ("identity", "question", "said"),
    [
        ("planar-2r/1@chapter", "singular-angles", Classification("boundary", True, "arm folded back")),
        ("planar-2r/1@chapter", "singular-angles", Classification("internal", True, "arm stretched out")),
        (
            "elbow/2@chapter",
            "singularity-type",
            Classification("boundary", False, "the point lies on the axis of joint 3"),
        ),
    ],
)
def test_a_false_sentence_or_kind_fails_the_certificate(
    identity: str, question: str, said: Classification, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = generate(replace(ProblemId.parse(identity), questions=(question,)))
    assert question == "singular-angles" or problem.parts[0].details_as(KindDetails).singularity_kind != "regular"
    assert certify(problem).passed

    def falsely(chain: Chain, component: Component) -> Classification:
        is_place = question == "singular-angles" and component.solutions and component.solutions[0][1] != (0,)
        return classification.classify(chain, component) if is_place else said

    monkeypatch.setattr(singularity_statements, "classify", falsely)
    (failure,) = certify(problem).failures
    assert failure.name.startswith(f"{question}: said of") and said.meaning in failure.detail


@pytest.mark.parametrize("family", ["planar-3r", "elbow-3r"])
def test_that_a_pose_is_singular_is_true_or_false_as_its_rank_says(family: str) -> None:
    answers = set()
    for seed in range(40):
        problem = generate(ProblemId(family, seed, ("true-or-false",)))
        (part,) = problem.parts
        if part.details_as(ConfigurationStatement).statement_kind == "singular":
            assert isinstance(part.answer, Choice)
            assert certify(problem).passed
            answers.add(part.answer.options[part.answer.correct])
        if answers == {"true", "false"}:
            return
    pytest.fail(f"of 40 statements, {answers} only")


@pytest.mark.parametrize(
    ("problem", "conditions", "one_side"),
    [("orthogonal-3r/219@lengths", 2, False), ("orthogonal-3r/4@full", 1, False), ("planar-2r/3@lengths", 1, True)],
)
def test_one_side_of_a_boundary_is_named_only_if_the_lost_direction_has_one(
    problem: str, conditions: int, one_side: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """P on the axis of joint 2 is on the boundary, but reaches both sides of the lost direction there."""
    asked = generate(problem, ["singularity-type"])
    (part,) = asked.parts
    solution = write_solution(asked, part)
    assert part.details_as(KindDetails).singularity_kind == "boundary"
    assert ("to one side of this point only" in solution) == one_side and certify(asked).passed
    assert solution.partition("the Jacobian loses rank")[0].count("= 0") == conditions
    monkeypatch.setattr("qdot.exercises.verify.singularity_statements.is_one_sided", lambda *_: True)
    assert certify(asked).passed == one_side
