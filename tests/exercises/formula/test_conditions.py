"""Sets of configurations are compared independently of how they are written."""

import contextlib
import operator
from typing import Any

import numpy as np
import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace, compare_sets
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import parse_pieces
from qdot.exercises.formula.trees import ParseError
from tests.support import read_cases

JOINTS = ("theta1", "theta2", "theta3")
DOMAIN = Domain({**dict.fromkeys(JOINTS, "angle"), **dict.fromkeys(("a1", "a2", "a3"), "length")})
SPACE = ConfigurationSpace(JOINTS, DOMAIN)


def are_equal_sets(claimed: str, reference: str, space: ConfigurationSpace = SPACE, seed: str = "seed") -> bool:
    left, right = (parse_pieces(parse_formula(text), space.joints) for text in (claimed, reference))
    return compare_sets(left, right, space, seed).are_equal


FOLD = "[theta2 = 0, theta2 = pi]"
SHOULDER = "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"
SPACES = {
    "joints": SPACE, "slide": ConfigurationSpace(("theta1", "d2"), Domain({"theta1": "angle", "d2": "signed"})),
    "lengths": ConfigurationSpace(JOINTS, Domain({**DOMAIN.roles, "a1": 0.1, "a2": 0.5, "a3": 0.4})),
    "slides": ConfigurationSpace(("d2", "d3"), Domain({"d2": "signed", "d3": "signed"})),
}  # fmt: skip


@pytest.mark.parametrize("case", read_cases("conditions")["compared"], ids=operator.itemgetter("name"))
def test_sets_are_compared_independently_of_their_form(case: dict[str, Any]) -> None:
    reference, space = case["reference"], SPACES[case["space"]]
    for claimed in case["same"]:
        assert are_equal_sets(claimed, reference, space) and are_equal_sets(reference, claimed, space), claimed
    for claimed in case["others"]:
        assert not are_equal_sets(claimed, reference, space), claimed


def test_piece_that_is_empty_for_the_lengths_is_neither_right_nor_wrong() -> None:
    short = ConfigurationSpace(JOINTS, Domain({**DOMAIN.roles, "a1": 2.0, "a2": 0.5, "a3": 0.4}))
    claimed, reference = (parse_pieces(parse_formula(text), JOINTS) for text in (SHOULDER, FOLD))
    comparison = compare_sets(claimed, reference, short, "seed")
    assert comparison.is_sound == (None,)


@pytest.mark.parametrize("text", ["theta2 in theta3 in 0 =", "{theta2: }", "[theta2 = [[0]]]", "theta2 = ...", "{...}"])
def test_invalid_condition_is_refused(text: str) -> None:
    with pytest.raises(ParseError):
        parse_pieces(parse_formula(text), JOINTS)


@pytest.mark.parametrize(
    "text",
    [
        "theta2 = k*n*m*pi", "theta2 in {" + ",".join(f"{k}*pi" for k in range(300)) + "}", "theta2 = 9**9**9**9",
        "theta2 = 1e300*exp(1000)", "theta2 = 1/0",
        " and ".join(["(theta1 = 0 or theta1 = pi)"] * 24),
    ],
)  # fmt: skip
def test_long_claims_do_not_stall_the_comparison(text: str) -> None:
    every_turn = text.startswith(("theta2 = k", "theta2 in"))  # long forms of the correct set
    with contextlib.suppress(ParseError):  # refused or compared, but never stuck
        assert are_equal_sets(text, FOLD) is every_turn


@pytest.mark.parametrize("text", ["sin(theta2) = 0", "sin(theta2)^2 = 0", "tan(theta2) = 0", "1 = cos(theta2)^2"])
def test_poses_are_sampled_on_every_branch_of_a_condition(text: str) -> None:
    (piece,) = parse_pieces(parse_formula(text), JOINTS)
    values = SPACE.sample_piece(piece, SPACE.collect_names([[piece]]), Stream("branches"), count=60)["theta2"]
    at_zero, at_pi = (np.sum(np.abs(np.sin(values / 2)) < 1e-3), np.sum(np.abs(np.cos(values / 2)) < 1e-3))
    assert at_zero > 10
    assert at_pi > 10
    assert at_zero + at_pi > 50


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("b", "c"), [("0.1", "0.4"), ("0.05", "0.45"), ("0.15", "0.8"), ("0.3", "0.5")])
def test_cancelling_large_terms_do_not_hide_a_branch(b: str, c: str, seed: int) -> None:
    """A product of two conditions in tan(theta3/2) has terms so large that every slope looks flat."""
    t = "tan(theta3/2)"
    whole = f"{b} + {c}*cos(theta2) + a3*(cos(theta2)*(1 - {t}^2) - sin(theta2)*2*{t})/(1 + {t}^2)"
    plain = f"sin(theta3) = 0 or {b} + {c}*cos(theta2) + a3*cos(theta2 + theta3) = 0"
    claimed, reference = (
        parse_pieces(parse_formula(text), JOINTS)
        for text in (f"sin(theta3) = 0 or 2*{t}/(1 + {t}^2)*({whole}) = 0", plain)
    )
    comparison = compare_sets(claimed, reference, SPACE, str(seed))
    assert comparison.are_equal and comparison.fewest_configurations > 45
    wrong = parse_pieces(parse_formula(plain.replace("theta2 + theta3", "theta2 - theta3")), JOINTS)
    assert not compare_sets(claimed, wrong, SPACE, str(seed)).are_equal
