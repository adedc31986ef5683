"""Ready-made sets: each is an assignment that begins plain and climbs, and that its own solutions solve."""

import json
import shutil
from itertools import pairwise
from pathlib import Path

import pytest

from exercises.assignment import load_assignment
from exercises.difficulty import difficulty
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from exercises.sets import DEFAULT_SET, SETS
from exercises.variation import axes_of
from tests.support.command import fails, run
from tests.support.suites import several

TRIED = several(("redundant", "quiz", "mid-term"), tuple(SETS))
"""Sets that are generated and graded; of the others, `make test` looks at what they ask."""


@pytest.fixture(params=SETS)
def folder(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    run("init", tmp_path / "hw", "--set", request.param)
    return tmp_path / "hw"


def test_a_set_climbs(folder: Path) -> None:
    """No problem varies less than the one before it; the last is harder than the first."""
    slots = load_assignment(folder).slots
    varied = [set(axes_of(slot.variation)) for slot in slots]
    assert all(before <= after for before, after in pairwise(varied))
    arms = [sample_chain(ProblemId(slot.family.name, 0, variation=slot.variation)) for slot in slots]
    assert difficulty(arms[-1]) > difficulty(arms[0]) or len({slot.family.name for slot in slots}) < len(slots)


def test_a_set_says_what_it_is_worth(folder: Path) -> None:
    assignment = load_assignment(folder)
    chosen = next(one for one in SETS.values() if one.title == assignment.title)
    assert chosen.points == sum(sum(slot.max_points) for slot in assignment.slots)
    told = f"{chosen.problems} problems, {chosen.points:g} points, about {chosen.minutes} minutes"
    assert told in (folder / "assignment.toml").read_text(encoding="utf-8").splitlines()[0]
    assert 1 <= chosen.minutes / chosen.points <= 6


@pytest.mark.parametrize("name", TRIED)
def test_a_set_is_solved_by_its_own_solutions(name: str, tmp_path: Path) -> None:
    run("init", tmp_path, "--set", name)
    (tmp_path / "roster.csv").write_text("student\ns001\n", encoding="utf-8")
    run("generate", tmp_path, "--jobs", "1")
    shutil.copytree(tmp_path / "solutions" / "s001", tmp_path / "submitted" / "s001")
    run("grade", tmp_path, "--jobs", "1")
    (result,) = map(json.loads, (tmp_path / "graded" / "results.jsonl").read_text(encoding="utf-8").splitlines())
    assert result["score"] == result["max_score"] == SETS[name].points


def test_sets_are_listed_and_a_wrong_name_is_told() -> None:
    listed = run("init", "--list")
    assert all(name in listed and one.title in listed for name, one in SETS.items())
    assert listed.startswith(DEFAULT_SET)
    assert "unknown set 'quizz' (did you mean 'quiz'?); known: overview" in fails("init", "x", "--set", "quizz")
    assert "name the folder to make" in fails("init")
