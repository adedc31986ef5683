"""How many students share an answer: the fingerprints of arms tell apart what generated answers tell apart."""

import json
from collections.abc import Hashable, Sequence

import pytest

from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ProblemId
from tests.tools.sharing import GROUPS, MEASURED, arms_of, count_sharing, keys_in_formulas

ONE_OF = {"position": "position", "J": "jacobian", "6 x n": "geometric-jacobian", "det": "determinant"}
SETS = ONE_OF | {"singular": "singular-angles"}


def _alike(keys: Sequence[Hashable]) -> list[int]:
    """Return for each the first that has the same key."""
    return [keys.index(key) for key in keys]


@pytest.mark.parametrize(
    ("family", "step", "asked"),
    [
        ("planar-2r", "zeros", SETS),
        ("planar-2r", "full", SETS),
        ("elbow-3r", "lengths", SETS),
        ("scara", "frames", ONE_OF),
    ],
)
def test_fingerprints_group_students_as_their_references_do(family: str, step: str, asked: dict[str, str]) -> None:
    arms = arms_of(family, step, 30)
    keys = keys_in_formulas(arms, list(asked))
    problems = [generate(ProblemId(family, seed, variation=step), list(asked.values())) for seed in range(30)]
    for group, question in asked.items():
        references = [repr(problem[question].answer.as_json()) for problem in problems]
        assert _alike(keys[group]) == _alike(references), group


def test_every_family_is_measured_at_every_step_and_everybody_shares_the_arm_of_the_chapter() -> None:
    measured = json.loads(MEASURED.read_text(encoding="utf-8"))["formulas"]
    assert list(measured) == list(FAMILIES)
    for family, entry in measured.items():
        assert list(entry["steps"]) == list(VARIATION_STEPS)
        assert all(count <= entry["students"] for counts in entry["steps"].values() for count in counts.values())
        if not FAMILIES[family].has_varied_structure:
            assert set(entry["steps"]["chapter"].values()) == {entry["students"]}


@pytest.mark.parametrize("family", ["polar-rp", "wrist-zyz"])
def test_the_file_says_what_is_measured(family: str) -> None:
    """Where this fails, run: make sharing"""
    entry = json.loads(MEASURED.read_text(encoding="utf-8"))["formulas"][family]
    counts = entry["steps"]["zeros"]
    keys = keys_in_formulas(arms_of(family, "zeros", entry["students"]), list(counts))
    assert {group: count_sharing(its) for group, its in keys.items()} == counts
    assert set(counts) <= set(GROUPS)
