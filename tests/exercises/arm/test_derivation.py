"""Derivations: the chapter's results, its errata, and the textbook arms of tests/data/ground_truth.json."""

import json
from collections.abc import Callable, Mapping
from typing import Any

import pytest
import sympy as sp

from exercises.arm.chain import Chain, Joint, Point
from exercises.arm.derivation import Derivation, derive
from exercises.formula.expression import read
from exercises.formula.identity import Domain, compare_entries, default_role
from exercises.formula.trees import Node, as_matrix
from tests.support import DATA

RECORDS = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
NAMES = [record["name"] for record in RECORDS]
PLAIN = [record["name"] for record in RECORDS if all(row[0] in "vw" and len(row) == 2 for row in record["task_rows"])]
SQUARE = [record["name"] for record in RECORDS if record["name"] in PLAIN and record.get("det")]

ROLES = Domain({name: default_role(name) for name in ("theta1", "theta2", "theta3", "a1", "a2", "a3", "d1")})
A, D = sp.symbols("a1 a2 a3"), sp.symbols("d1")


def turning(i: int, a: sp.Expr = 0, alpha: sp.Expr = 0, d: sp.Expr = 0) -> Joint:
    return Joint("R", sp.Symbol(f"theta{i}"), d, a, alpha)


TWO = Chain("2R", (turning(1, A[0]), turning(2, A[1])), ("vx", "vy"))
SCORBOT = Chain(
    "Scorbot, P",
    (turning(1, A[0], -sp.pi / 2, D), turning(2, A[1]), turning(3, A[2])),
    ("vx", "vy", "vz"),
)


def agrees(printed: str, matrix: Any) -> bool:
    """Compare a formula or matrix, typed as in the chapter, with a derived one."""
    theirs = [entry for row in as_matrix(read(printed)) for entry in row]
    ours = [read(str(entry)) for entry in (matrix if isinstance(matrix, sp.MatrixBase) else [matrix])]
    return len(theirs) == len(ours) and all(compare_entries(theirs, ours, ROLES, "chapter").equal)


C = "(a1 + a2*c2 + a3*c23)"
S = "(a2*s2 + a3*s23)"
CHAPTER = {
    "6.1 position": (derive(TWO).position, "[a1*c1 + a2*c12, a1*s1 + a2*s12, 0]"),
    "6.1 rotation": (derive(TWO).rotations[2], "[[c12, -s12, 0], [s12, c12, 0], [0, 0, 1]]"),
    "6.1 v_x": (derive(TWO).twist()[0], "-a1*s1*qd1 - a2*s12*(qd1 + qd2)"),
    "6.1 v_y": (derive(TWO).twist()[1], "a1*c1*qd1 + a2*c12*(qd1 + qd2)"),
    "6.1 J": (derive(TWO).jacobian, "[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, a2*c12]]"),
    "6.2 det J": (derive(TWO).determinant, "a1*a2*s2"),
    "6.2 inverse": (
        derive(TWO).inverse,
        "[[a2*c12/(a1*a2*s2), a2*s12/(a1*a2*s2)], [(-a1*c1 - a2*c12)/(a1*a2*s2), (-a1*s1 - a2*s12)/(a1*a2*s2)]]",
    ),
    "6.2 rates": (
        derive(TWO).rate_law(),
        "[(c12*vx + s12*vy)/(a1*s2), -((a1*c1 + a2*c12)*vx + (a1*s1 + a2*s12)*vy)/(a1*a2*s2)]",
    ),
    "6.3 position": (derive(SCORBOT).position, f"[c1*{C}, s1*{C}, d1 - a2*s2 - a3*s23]"),
    "6.3 J": (
        derive(SCORBOT).jacobian,
        f"[[-s1*{C}, -c1*{S}, -a3*c1*s23], [c1*{C}, -s1*{S}, -a3*s1*s23], [0, -a2*c2 - a3*c23, -a3*c23]]",
    ),
    "6.3 det J": (derive(SCORBOT).determinant, f"a2*a3*s3*{C}"),
    "6.3 v_x": (derive(SCORBOT).twist()[0], f"-s1*{C}*qd1 - c1*{S}*qd2 - a3*c1*s23*qd3"),
    "6.4 p*_0": (derive(TWO).p_star[:, 0], "[a1*c1 + a2*c12, a1*s1 + a2*s12, 0]"),
    "6.4 p*_1": (derive(TWO).p_star[:, 1], "[a2*c12, a2*s12, 0]"),
    "6.4 z": (derive(TWO).z, "[[0, 0], [0, 0], [1, 1]]"),
    "6.4 J": (
        derive(TWO).geometric,
        "[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, a2*c12], [0, 0], [0, 0], [0, 0], [1, 1]]",
    ),
    "6.4 frame 1": (derive(TWO).twist(derive(TWO).link_jacobian(1)), "[-a1*s1*qd1, a1*c1*qd1, 0, 0, 0, qd1]"),
}

ERRATA = {
    "6.1 rotation": "[[c12, -s12, 0], [c12, c12, 0], [0, 0, 1]]",
    "6.1 v_x": "-a1*s1*qd1 - a2*s12*qd1 + qd2",
    "6.1 v_y": "a1*c1*qd1 + a2*c12*qd1 + qd2",
    "6.2 inverse": CHAPTER["6.2 inverse"][1].replace(" a2*s12/", " -a2*s12/"),
    "6.3 J": CHAPTER["6.3 J"][1].replace("-s1*(a2*s2 + a3*s23)", "-s1*(a2*s2 + a3*c23)"),
}


@pytest.mark.parametrize("name", CHAPTER)
def test_the_chapter_is_derived(name: str) -> None:
    derived, printed = CHAPTER[name]
    assert agrees(printed, derived)


@pytest.mark.parametrize("name", ERRATA)
def test_what_is_printed_wrong_is_not_derived(name: str) -> None:
    derived, right = CHAPTER[name]
    assert ERRATA[name] != right
    assert not agrees(ERRATA[name], derived)


def test_the_scorbot_at_its_tip_moves_wrist_centre_and_tip() -> None:
    wrist = (turning(4, 0, -sp.pi / 2), turning(5, 0, 0, sp.Symbol("d5")))
    whole = Chain("Scorbot", (*SCORBOT.joints, *wrist), ("vx", "vy", "vz"), tool=Point(4))
    found = derive(whole)
    assert agrees(CHAPTER["6.3 position"][1], found.position)
    assert found.geometric.shape == (6, 5)
    assert found.geometric[:3, :3] == derive(SCORBOT).jacobian
    assert found.geometric[:3, 3:] == sp.zeros(3, 2)


RESULTS: dict[str, Callable[[Derivation], object]] = {
    "determinant": lambda found: found.determinant,
    "inverse": lambda found: found.inverse,
    "rates": lambda found: found.rate_law(),
}


@pytest.mark.parametrize("result", RESULTS)
def test_a_jacobian_that_is_not_square_has_no_determinant(result: str) -> None:
    redundant = Chain("3R", (turning(1, A[0]), turning(2, A[1]), turning(3, A[2])), ("vx", "vy"))
    with pytest.raises(ValueError, match="2 x 3"):
        RESULTS[result](derive(redundant))


@pytest.mark.parametrize("result", ["inverse", "rates"])
def test_a_jacobian_that_never_has_an_inverse_says_so(result: str) -> None:
    flat = Chain("2R", (turning(1, A[0]), turning(2, A[1])), ("vx", "vz"))
    with pytest.raises(ValueError, match="det J = 0 everywhere"):
        RESULTS[result](derive(flat))


@pytest.mark.parametrize("name", NAMES)
def test_textbook_jacobians(name: str, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    at_tip = Chain(name, arm.chain.joints, ("vx",))
    ours = [read(str(entry)) for entry in derive(at_tip).geometric]
    theirs = [read(entry) for row in arm.record["J_full_base_tip"] for entry in row]
    roles = {symbol: default_role(symbol) for symbol in (*arm.record["params"], *arm.record["variables"])}
    assert all(compare_entries(ours, theirs, Domain(roles), name).equal)


@pytest.mark.parametrize("name", SQUARE)
def test_textbook_determinants_up_to_sign(name: str, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    ours, theirs = read(str(derive(arm.chain).determinant)), read(arm.record["det"])
    roles = {symbol: default_role(symbol) for symbol in (*arm.record["params"], *arm.record["variables"])}
    signs = [compare_entries([ours], [t], Domain(roles), name).equal[0] for t in (theirs, Node("neg", (theirs,)))]
    assert sum(signs) == 1
