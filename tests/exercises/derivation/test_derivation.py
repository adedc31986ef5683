"""Derivations: the chapter's results, its errata, and the textbook arms of tests/data/ground_truth.json."""

import json
from collections.abc import Callable, Mapping
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.derivation.derivation import Derivation, derive
from qdot.exercises.formula.equality import Domain, choose_default_role, compare_entries
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import Node, as_matrix
from tests.support import DATA
from tests.support.suites import sample_for_suite

RECORDS = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
NAMES = [record["name"] for record in RECORDS]
PLAIN = [record["name"] for record in RECORDS if all(row[0] in "vw" and len(row) == 2 for row in record["task_rows"])]
SQUARE = [record["name"] for record in RECORDS if record["name"] in PLAIN and record.get("det")]

ROLES = Domain({name: choose_default_role(name) for name in ("theta1", "theta2", "theta3", "a1", "a2", "a3", "d1")})
A, D = sp.symbols("a1 a2 a3"), sp.symbols("d1")


def make_revolute(i: int, a: sp.Expr = 0, alpha: sp.Expr = 0, d: sp.Expr = 0) -> Joint:
    return Joint("R", sp.Symbol(f"theta{i}"), d, a, alpha)


TWO = Chain("2R", (make_revolute(1, A[0]), make_revolute(2, A[1])), ("vx", "vy"))
SCORBOT = Chain(
    "Scorbot, P",
    (make_revolute(1, A[0], -sp.pi / 2, D), make_revolute(2, A[1]), make_revolute(3, A[2])),
    ("vx", "vy", "vz"),
)


def agrees_with_print(printed: str, matrix: Any) -> bool:
    """Return whether a formula or matrix, typed as in the chapter, equals a derived one."""
    theirs = [entry for row in as_matrix(parse_formula(printed)) for entry in row]
    ours = [parse_formula(str(entry)) for entry in (matrix if isinstance(matrix, sp.MatrixBase) else [matrix])]
    return len(theirs) == len(ours) and all(compare_entries(theirs, ours, ROLES, "chapter").is_correct)


def _compute_twist(jacobian: sp.Matrix) -> sp.Matrix:
    return jacobian * sp.Matrix(sp.symbols(f"qd1:{jacobian.cols + 1}"))


C = "(a1 + a2*c2 + a3*c23)"
S = "(a2*s2 + a3*s23)"
J_SCORBOT = f"[[-s1*{C}, -c1*{S}, -a3*c1*s23], [c1*{C}, -s1*{S}, -a3*s1*s23], [0, -a2*c2 - a3*c23, -a3*c23]]"
INVERSE = "[[a2*c12/(a1*a2*s2), a2*s12/(a1*a2*s2)], [(-a1*c1 - a2*c12)/(a1*a2*s2), (-a1*s1 - a2*s12)/(a1*a2*s2)]]"
CHAPTER: dict[str, tuple[Chain, Callable[[Derivation], object], str]] = {
    "6.1 position": (TWO, lambda d: d.position, "[a1*c1 + a2*c12, a1*s1 + a2*s12, 0]"),
    "6.1 rotation": (TWO, lambda d: d.rotations[2], "[[c12, -s12, 0], [s12, c12, 0], [0, 0, 1]]"),
    "6.1 v_x": (TWO, lambda d: _compute_twist(d.geometric_jacobian)[0], "-a1*s1*qd1 - a2*s12*(qd1 + qd2)"),
    "6.1 v_y": (TWO, lambda d: _compute_twist(d.geometric_jacobian)[1], "a1*c1*qd1 + a2*c12*(qd1 + qd2)"),
    "6.1 J": (TWO, lambda d: d.jacobian, "[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, a2*c12]]"),
    "6.2 det J": (TWO, lambda d: d.determinant, "a1*a2*s2"),
    "6.2 inverse": (TWO, lambda d: d.inverse, INVERSE),
    "6.2 rates": (
        TWO, lambda d: d.derive_rate_law(),
        "[(c12*vx + s12*vy)/(a1*s2), -((a1*c1 + a2*c12)*vx + (a1*s1 + a2*s12)*vy)/(a1*a2*s2)]",
    ),
    "6.3 position": (SCORBOT, lambda d: d.position, f"[c1*{C}, s1*{C}, d1 - a2*s2 - a3*s23]"),
    "6.3 J": (SCORBOT, lambda d: d.jacobian, J_SCORBOT),
    "6.3 det J": (SCORBOT, lambda d: d.determinant, f"a2*a3*s3*{C}"),
    "6.3 v_x": (
        SCORBOT, lambda d: _compute_twist(d.geometric_jacobian)[0],
        f"-s1*{C}*qd1 - c1*{S}*qd2 - a3*c1*s23*qd3",
    ),
    "6.4 p*_0": (TWO, lambda d: d.p_star[:, 0], "[a1*c1 + a2*c12, a1*s1 + a2*s12, 0]"),
    "6.4 p*_1": (TWO, lambda d: d.p_star[:, 1], "[a2*c12, a2*s12, 0]"),
    "6.4 z": (TWO, lambda d: d.z, "[[0, 0], [0, 0], [1, 1]]"),
    "6.4 J": (
        TWO, lambda d: d.geometric_jacobian,
        "[[-a1*s1 - a2*s12, -a2*s12], [a1*c1 + a2*c12, a2*c12], [0, 0], [0, 0], [0, 0], [1, 1]]",
    ),
    "6.4 frame 1": (TWO, lambda d: _compute_twist(d.derive_link_jacobian(1)), "[-a1*s1*qd1, a1*c1*qd1, 0, 0, 0, qd1]"),
}  # fmt: skip

ERRATA = {
    "6.1 rotation": "[[c12, -s12, 0], [c12, c12, 0], [0, 0, 1]]",
    "6.1 v_x": "-a1*s1*qd1 - a2*s12*qd1 + qd2",
    "6.1 v_y": "a1*c1*qd1 + a2*c12*qd1 + qd2",
    "6.2 inverse": INVERSE.replace(" a2*s12/", " -a2*s12/"),
    "6.3 J": J_SCORBOT.replace("-s1*(a2*s2 + a3*s23)", "-s1*(a2*s2 + a3*c23)"),
}


@pytest.mark.parametrize("name", CHAPTER)
def test_derivation_agrees_with_the_chapter_and_not_with_its_errata(name: str) -> None:
    chain, derived, printed = CHAPTER[name]
    assert agrees_with_print(printed, derived(derive(chain)))
    assert name not in ERRATA or not agrees_with_print(ERRATA[name], derived(derive(chain)))


@pytest.mark.parametrize("question", ["6.2 det J", "6.2 inverse", "6.2 rates"])
def test_jacobian_without_inverse_is_refused(question: str) -> None:
    redundant = Chain("3R", (make_revolute(1, A[0]), make_revolute(2, A[1]), make_revolute(3, A[2])), ("vx", "vy"))
    for chain, message in ((redundant, "2 x 3"), (TWO.with_task("vx", "vz"), "det J = 0 everywhere")):
        if (question, chain.n) != ("6.2 det J", 2):
            with pytest.raises(ValueError, match=message):
                CHAPTER[question][1](derive(chain))


def domain_of(arm: Any) -> Domain:
    return Domain({name: choose_default_role(name) for name in (*arm.record["params"], *arm.record["variables"])})


@pytest.mark.parametrize("name", sample_for_suite(NAMES, 5))
def test_jacobian_agrees_with_the_textbook(name: str, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    at_tip = Chain(name, arm.chain.joints, ("vx",))
    ours = [parse_formula(str(entry)) for entry in derive(at_tip).geometric_jacobian]
    theirs = [parse_formula(entry) for row in arm.record["J_full_base_tip"] for entry in row]
    assert all(compare_entries(ours, theirs, domain_of(arm), name).is_correct)


@pytest.mark.parametrize("name", SQUARE)
def test_determinant_agrees_with_the_textbook_up_to_sign(name: str, textbook_arms: Mapping[str, Any]) -> None:
    arm = textbook_arms[name]
    ours, theirs = parse_formula(str(derive(arm.chain).determinant)), parse_formula(arm.record["det"])
    signs = [compare_entries([ours], [t], domain_of(arm), name).is_correct[0] for t in (theirs, Node("neg", (theirs,)))]
    assert sum(signs) == 1
