"""What worked solutions say of singular configurations: true of every family, and false sentences are found out."""

import re
from collections.abc import Iterator
from dataclasses import replace

import pytest
import sympy as sp

from exercises.arm import classification
from exercises.arm.bare import bare, bare_pieces
from exercises.arm.chain import Chain
from exercises.arm.classification import Kind, by_value, classify, samples_on
from exercises.arm.singularity import Component, singular_set
from exercises.generation import generate, sample_chain
from exercises.problem import ProblemId
from exercises.questions.singular import OfKind
from exercises.variation import STEPS
from exercises.verify import appearance, certify
from exercises.verify.appearance import holds
from tests.support.suites import every_family, several

FALSE = {
    "random-3/10085@full": ("cos(theta2)", sp.pi / 2, "arm folded back"),  # stretched out in a quarter of the poses
    "random-3/10002@full": ("sin(theta2)", 0, "arm stretched out or folded back"),  # joint 3 is bent
    # the far end of two, of which the other one is farther
    "orthogonal-3r/1@chapter": (
        "sin(theta3)", sp.pi, "the point is as far from the axis of joint 2 as joint 3 can bring it",
    ),
}  # fmt: skip
"""What was once said at values of joints, and is not so in all of the configurations."""


def chain_of(identity: str) -> Chain:
    return sample_chain(ProblemId.parse(identity))


def parts(chain: Chain) -> Iterator[tuple[list[str], str]]:
    """Yield conditions of the bare arm, and what is said of them."""
    for component in singular_set(chain) or ():
        values = by_value(component, classify(chain, component))
        for part in (component, *(part for _, part in values)):
            yield bare_pieces(chain, part), classify(chain, part).meaning


def are_so(chain: Chain, pieces: list[str], words: str) -> set[bool]:
    arm = bare(chain)
    return {holds(arm, words, sample) for piece in pieces for sample in samples_on(arm, piece, "test", each=6)}


@every_family
def test_what_is_said_is_so(family: str) -> None:
    for step in several(("chapter", "full"), tuple(STEPS)):
        for pieces, words in parts(sample_chain(ProblemId(family, 3).varied(step))):
            assert are_so(sample_chain(ProblemId(family, 3).varied(step)), pieces, words) == {True}, words


@every_family
def test_the_same_of_other_joints_is_not(family: str) -> None:
    """Every number in a sentence counts: with another joint in its place it is false, or says the same."""
    chain = sample_chain(ProblemId(family, 3).varied("chapter"))
    for pieces, words in parts(chain):
        for match in re.finditer(r"(?<=joint )\d", words):
            told = int(match[0])
            others = [
                words[: match.start()] + str(n) + words[match.end() :] for n in range(1, chain.n + 1) if n != told
            ]
            assert any(are_so(chain, pieces, other) != {True} for other in others), words


@pytest.mark.parametrize("identity", FALSE)
def test_what_was_said_falsely_once_is_found_out(identity: str) -> None:
    chain = chain_of(identity)
    condition, value, words = FALSE[identity]
    (component,) = [c for c in singular_set(chain) or () if str(c.conditions[0]).lstrip("-") == condition]
    ((joint, _),) = component.solutions or ()
    here = Component(component.conditions, ((joint, (sp.sympify(value),)),))
    assert False in are_so(chain, bare_pieces(chain, here), words)
    assert classify(chain, here).meaning != words


def test_a_piece_that_is_there_for_few_lengths_is_found() -> None:
    """theta3 = acos(-(a1 + a2)/a3) is there for one arm in sixteen."""
    assert certify(generate(ProblemId("random-3", 10091, ("singular-angles",)).varied("chapter"))).passed


@pytest.mark.parametrize("identity", ["planar-3r/10001@full", "planar-3r/10157@lengths", "planar-3r/10007@lengths"])
def test_what_is_so_for_most_lengths_only_is_not_said_of_all(identity: str) -> None:
    """Folded so, the first arm is at the boundary only where a link is long; the other is not always stretched out."""
    asked = ("singular-angles", "singularity-type")
    assert certify(generate(replace(ProblemId.parse(identity), questions=asked))).passed


def test_an_arm_that_is_folded_twice_is_not_stretched_out() -> None:
    """Each joint alone has the point farthest, both together do not: the links run there, back and there again."""
    chain, twice = chain_of("planar-3r/1@chapter"), "theta2 = pi and theta3 = pi"
    assert ([twice], "arm folded back") in list(parts(chain))
    assert are_so(chain, [twice], "arm folded back") == {True}
    assert are_so(chain, [twice], "arm stretched out") == {False}


def test_words_that_are_not_known_are_not_so() -> None:
    chain = chain_of("planar-2r/1@chapter")
    assert are_so(chain, ["theta2 = 0"], "arm stretched out") == {True}
    assert are_so(chain, ["theta2 = 0"], "arm folded back") == {False}
    assert are_so(chain, ["theta2 = 0"], "arm stretched") == {False}
    assert are_so(chain, ["theta2 = 0"], "arm stretched out, and joint 1 moves nothing that the task counts") == {False}


@pytest.mark.parametrize(
    "said", [Kind("boundary", True, "arm folded back"), Kind("internal", True, "arm stretched out")]
)
def test_a_false_sentence_or_kind_fails_the_certificate(said: Kind, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = generate(ProblemId("planar-2r", 1, ("singular-angles",)).varied("chapter"))
    assert certify(problem).passed

    def falsely(chain: Chain, component: Component) -> Kind:
        ((_, values),) = component.solutions or ()
        return said if values == (0,) else classification.classify(chain, component)

    monkeypatch.setattr(appearance, "classify", falsely)
    (failure,) = certify(problem).failures
    assert failure.name == "singular-angles: said of theta2 = 0"
    assert said.meaning in failure.detail


def test_a_false_sentence_about_one_place_fails_the_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = next(
        found
        for seed in range(20)
        if (found := generate(ProblemId("elbow", seed, ("singularity-type",)).varied("chapter"))).parts[0]
        .about(OfKind).type != "regular"
    )  # fmt: skip
    assert certify(problem).passed
    monkeypatch.setattr(
        appearance, "classify", lambda *_: Kind("boundary", False, "the point lies on the axis of joint 3")
    )
    (failure,) = certify(problem).failures
    assert failure.name.startswith("singularity-type: said of")
