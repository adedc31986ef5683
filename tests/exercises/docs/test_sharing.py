"""Counts of students who share an answer: fingerprints of arms group them like the generated answers."""

import json
from collections.abc import Hashable, Sequence

import pytest

from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ProblemId
from tests.support.suites import sample_for_suite
from tests.tools.sharing import GROUPS, MEASUREMENTS_FILE, count_sharing, make_formula_keys, sample_arms

ONE_OF = {"position": "position", "J": "jacobian", "6 x n": "geometric-jacobian", "det": "determinant"}
SETS = ONE_OF | {"singular": "singular-angles"}


def _group_equal(keys: Sequence[Hashable]) -> list[int]:
    """Return for each key the index of the first equal key."""
    return [keys.index(key) for key in keys]


@pytest.mark.parametrize(
    ("family", "step", "asked"),
    sample_for_suite(
        [
            ("planar-2r", "zeros", SETS),
            ("planar-2r", "full", SETS),
            ("elbow-3r", "lengths", SETS),
            ("scara", "frames", ONE_OF),
        ],
        2,
    ),
)
def test_fingerprints_group_students_like_their_answers(family: str, step: str, asked: dict[str, str]) -> None:
    arms = sample_arms(family, step, 30)
    keys = make_formula_keys(arms, list(asked))
    problems = [generate(ProblemId(family, seed, variation=step), list(asked.values())) for seed in range(30)]
    for group, question in asked.items():
        references = [repr(problem[question].answer.as_json()) for problem in problems]
        assert _group_equal(keys[group]) == _group_equal(references), group


def test_sharing_is_measured_for_every_family_and_variation_step() -> None:
    measured = json.loads(MEASUREMENTS_FILE.read_text(encoding="utf-8"))
    assert list(measured) == list(FAMILIES)
    for family, entry in measured.items():
        assert list(entry["steps"]) == list(VARIATION_STEPS)
        assert all(count <= entry["students"] for counts in entry["steps"].values() for count in counts.values())
        if not FAMILIES[family].has_varied_structure:
            assert set(entry["steps"]["chapter"].values()) == {entry["students"]}


@pytest.mark.parametrize("family", ["polar-rp", "wrist-zyz"])
def test_stored_sharing_agrees_with_measurement(family: str) -> None:
    """If this fails, run: make sharing"""
    entry = json.loads(MEASUREMENTS_FILE.read_text(encoding="utf-8"))[family]
    counts = entry["steps"]["zeros"]
    keys = make_formula_keys(sample_arms(family, "zeros", entry["students"]), list(counts))
    assert {group: count_sharing(its) for group, its in keys.items()} == counts
    assert set(counts) <= set(GROUPS)
