"""Derivations: the textbook arms of tests/data/ground_truth.json; test_latex.py has the chapter's results."""

import json
from collections.abc import Callable, Mapping
from typing import Any

import pytest

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.derivation.derivation import Derivation, derive
from qdot.exercises.formula.equality import Domain, choose_default_role, compare_entries
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import Node
from tests.support import DATA
from tests.support.suites import sample_for_suite

RECORDS = json.loads((DATA / "ground_truth.json").read_text(encoding="utf-8"))
NAMES = [record["name"] for record in RECORDS]
PLAIN = [record["name"] for record in RECORDS if all(row[0] in "vw" and len(row) == 2 for row in record["task_rows"])]
SQUARE = [record["name"] for record in RECORDS if record["name"] in PLAIN and record.get("det")]
THREE = Chain("3R", tuple(Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2, 3)), ("vx", "vy"))
FLAT = Chain("2R", THREE.joints[:2], ("vx", "vz"))


@pytest.mark.parametrize(
    ("chain", "derive_from", "message"),
    [
        (THREE, lambda d: d.determinant, "2 x 3"), (THREE, lambda d: d.inverse, "2 x 3"),
        (THREE, lambda d: d.derive_rate_law(), "2 x 3"), (FLAT, lambda d: d.inverse, "det J = 0 everywhere"),
        (FLAT, lambda d: d.derive_rate_law(), "det J = 0 everywhere"),
    ],
)  # fmt: skip
def test_jacobian_without_inverse_is_refused(
    chain: Chain, derive_from: Callable[[Derivation], object], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        derive_from(derive(chain))


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
