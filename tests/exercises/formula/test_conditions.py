"""Sets of configurations are compared independently of how they are written."""

import contextlib

import numpy as np
import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import ConfigurationSpace, compare_sets
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.set_parser import parse_pieces
from qdot.exercises.formula.trees import ParseError

JOINTS = ("theta1", "theta2", "theta3")
DOMAIN = Domain({**dict.fromkeys(JOINTS, "angle"), **dict.fromkeys(("a1", "a2", "a3"), "length")})
SPACE = ConfigurationSpace(JOINTS, DOMAIN)


def are_equal_sets(claimed: str, reference: str, space: ConfigurationSpace = SPACE, seed: str = "seed") -> bool:
    left, right = (parse_pieces(parse_formula(text), space.joints) for text in (claimed, reference))
    return compare_sets(left, right, space, seed).are_equal


FOLD = "[theta2 = 0, theta2 = pi]"
SAME_FOLD = [
    "{theta2: [0, pi]}", "{theta2: {0, pi}}", "theta2 = k*pi", "theta2 = n*pi", "Eq(sin(theta2), 0)", "sin(theta2) = 0",
    "sin(theta2)^2 = 0", "sin(theta2)", "theta2 in {0, -pi}", "theta2 in [0, 3*pi]", "tan(theta2) = 0",
    "theta2 = 0 or theta2 = pi", "Or(Eq(theta2, 0), Eq(theta2, pi))", "[theta2 = 0, theta2 = 2*pi, theta2 = -pi]",
    "0 = theta2 or pi = theta2", "theta2 = [0, pi]", "a1*a2*sin(theta2) = 0", "cos(theta2)^2 = 1", "{theta2: k*pi}",
    "s2 = 0", "theta2 = acos(1) or theta2 = acos(-1)", "theta2 - pi = 0 or theta2 = 0",
    "sin(theta1 + theta2)*cos(theta1) = cos(theta1 + theta2)*sin(theta1)",
]  # fmt: skip
OTHER_FOLD = [
    "theta2 = 0", "theta2 = pi", "theta2 in {0, pi, pi/2}", "theta3 = 0 or theta3 = pi", "cos(theta2) = 0",
    "theta2 = 0 or theta2 = 180", "theta2 in {0, 3.14}", "sin(2*theta2) = 0", "theta2 = 2*k*pi",
    "sin(theta2) = 0 and sin(theta3) = 0", "theta1 = 0 and sin(theta2) = 0", "sin(theta2/2) = 0",
    "sin(theta2)*sin(theta3) = 0", "a1 = 0", "0 = 0", "1 = 0",
]  # fmt: skip
SHOULDER = "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"
LONG_ENOUGH = ConfigurationSpace(JOINTS, Domain({**DOMAIN.roles, "a1": 0.1, "a2": 0.5, "a3": 0.4}))
BRANCH, OTHER_BRANCH = (f"theta3 = {sign}acos(-(a1 + a2*cos(theta2))/a3) - theta2" for sign in ("", "-"))
SAME_SHOULDER = [
    "a1 + a2*c2 + a3*c23 = 0", "a3*c23 = -a1 - a2*c2", "Eq(a1 + a2*c2, -a3*c23)", f"{BRANCH} or {OTHER_BRANCH}",
    "(a1 + a2*c2 + a3*c23)^2 = 0", "a1 + (a2 + a3*c3)*c2 - a3*s2*s3 = 0",
]  # fmt: skip
OTHER_SHOULDER = [
    BRANCH, "a2*c2 + a3*c23 = 0", "a1 + a2*c2 - a3*c23 = 0", "a1 + a2*c2 + a3*c3 = 0",
    SHOULDER + " or sin(theta3) = 0", "a1 + a2*c2 = 0 and c23 = 0",
]  # fmt: skip
LINES = "[" + ", ".join(f"theta2 = {x} and theta3 = {y}" for x in ("0", "pi") for y in ("0", "pi")) + "]"
SAME_LINES = [
    "And(Eq(sin(theta2), 0), Eq(sin(theta3), 0))", "{theta2: [0, pi], theta3: [0, pi]}", "s2 = 0 and s23 = 0",
    "sin(theta2)^2 + sin(theta3)^2 = 0",
]  # fmt: skip
OTHER_LINES = ["sin(theta2) = 0 or sin(theta3) = 0", "{theta2: [0, pi], theta3: 0}"]
SLIDE = ConfigurationSpace(("theta1", "d2"), Domain({"theta1": "angle", "d2": "signed"}))
SUM = "sin(theta1 + theta2) = 0"
SAME_SUM = [
    "theta1 + theta2 = 0 or pi", "theta1 + theta2 = 0, pi, -pi", "theta1 + theta2 in {0, 3*pi}",
    "theta1 + theta2 = k*pi", "[Eq(theta1 + theta2, 0), Eq(theta1 + theta2, pi)]",
    "theta1 = -theta2 + 2*pi, theta2 = pi - theta1", "2*theta1 + 2*theta2 = 0 or (theta1 + theta2)/2 = pi/2",
    "theta1 + theta2 - pi = 0, 0 = -theta1 - theta2",
    "cos(theta1) = 0 and theta1 + theta2 = 0 or sin(theta1 + theta2) = 0",
]  # fmt: skip
OTHER_SUM = [
    "theta1 + theta2 = 0", "theta1 + theta2 = 0 or pi/2", "theta1 - theta2 = 0, pi", "2*theta1 + 2*theta2 = 0, pi",
    "theta1 + theta2 = 0 or 3.14", "And(Eq(theta1 + theta2, 0), Eq(theta2, pi))", "theta1 + theta2 = 0 or 180",
]  # fmt: skip
BOTH = "theta1 = -pi/2 and theta2 = pi/2 or theta1 = pi/2 and theta2 = -pi/2"
SAME_BOTH = [
    "theta1 + theta2 = 0 and theta1 - theta2 = pi", "And(Eq(theta1 + theta2, 2*pi), Eq(cos(theta1), 0))",
    "theta1 = -theta2 and theta1 = theta2 + pi",
]  # fmt: skip
OTHER_BOTH = ["theta1 + theta2 = 0 and theta1 = pi/2", "theta1 + theta2 = 0 and theta1 - theta2 = 0"]
SAME_MULTIPLES = ["sin(theta1 + 3*theta2/2) = 0", "theta2 = -2*theta1/3", "theta1 = pi - 1.5*theta2"]
SLIDES = ConfigurationSpace(("d2", "d3"), Domain({"d2": "signed", "d3": "signed"}))
COMPARED = [
    (FOLD, SPACE, SAME_FOLD, OTHER_FOLD), (SHOULDER, LONG_ENOUGH, SAME_SHOULDER, OTHER_SHOULDER),
    (LINES, SPACE, SAME_LINES, OTHER_LINES),
    ("d2 = -7/20", SLIDE, ["20*d2 + 7 = 0", "d2 = -0.35"], ["d2 = -7/20 + 2*pi"]),  # a slide has no full turns
    ("d2 = 3 - d3", SLIDES, ["d2 + d3 = 3", "2*d3 + 2*d2 - 6 = 0"], ["d2 + d3 = 3 + 2*pi", "sin(d2 + d3 - 3) = 0"]),
    (SUM, SPACE, SAME_SUM, OTHER_SUM), (BOTH, SPACE, SAME_BOTH, OTHER_BOTH),
    ("2*theta1 + 3*theta2 = 0", SPACE, SAME_MULTIPLES, ["2*theta1 - 3*theta2 = 0", "theta1 + theta2 = 0"]),
]  # fmt: skip
IDS = ["fold", "tied", "lines", "slide", "slides", "sum", "two sums", "multiples"]


@pytest.mark.parametrize(("reference", "space", "same", "others"), COMPARED, ids=IDS)
def test_sets_are_compared_independently_of_their_form(
    reference: str, space: ConfigurationSpace, same: list[str], others: list[str]
) -> None:
    for claimed in same:
        assert are_equal_sets(claimed, reference, space) and are_equal_sets(reference, claimed, space), claimed
    for claimed in others:
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
