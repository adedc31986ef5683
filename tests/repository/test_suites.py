"""The suites: each selects the same tests every day, and a family stands for each shape of arm."""

from pathlib import Path

import pytest

from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from tests.support import ROOT, problem_cache, suites
from tests.support.suites import SHAPES, classify_shape, describe_left_out, sample_for_suite, select_families


def test_every_family_is_of_a_shape_for_which_one_stands() -> None:
    shapes = {
        name: classify_shape(sample_chain(ProblemId(name, 0)), FAMILIES[name].has_varied_structure) for name in FAMILIES
    }
    assert set(shapes.values()) == set(SHAPES)
    assert all(shapes[name] == shape for shape, name in SHAPES.items())


def test_check_takes_one_family_test_takes_each_shape_and_whole_takes_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "WHOLE", False)
    monkeypatch.setattr(suites, "SUITE", "test")
    assert select_families() == list(SHAPES.values())
    assert select_families(["ur-6r", "scara", "elbow"]) == ["scara"]
    assert select_families(["ur-6r", "elbow"]) == ["ur-6r"]
    assert sample_for_suite(range(10), 3) == [0, 4, 8]
    monkeypatch.setattr(suites, "SUITE", "check")
    assert select_families() == ["planar-2r"]
    monkeypatch.setattr(suites, "WHOLE", True)
    assert select_families() == list(FAMILIES)
    assert sample_for_suite(range(10), 3) == list(range(10))


def test_the_examples_of_make_check_exist() -> None:
    for name in suites.EXAMPLES:
        file, _, begin = name.partition("::")
        text = (ROOT / "tests" / file).read_text(encoding="utf-8")
        assert f"\ndef {begin.partition('[')[0] or 'test_'}" in text, name


def test_a_run_says_what_it_left_out_and_what_runs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "WHOLE", False)
    monkeypatch.setattr(suites, "SUITE", "test")
    assert describe_left_out(3, 40) == "make test left out 3 tests and 40 families of sweeps; `make whole` runs them"
    monkeypatch.setattr(suites, "WHOLE", True)
    assert "nothing is left out" in describe_left_out(0, 0)


def test_make_has_the_suites_and_the_nightly_workflow_runs_the_whole() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert all(f"\n{suite}:" in makefile for suite in suites.SUITES)
    workflow = Path(ROOT / ".github" / "workflows" / "whole.yml").read_text(encoding="utf-8")
    assert "cron:" in workflow and "run: make whole" in workflow


def test_problems_are_cached_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(problem_cache, "get_cache_folder", lambda: tmp_path)
    asked = [ProblemId("cartesian", 0), ProblemId("planar-pr", 0)]
    problem_cache.load_problem(asked[0])
    assert problem_cache.cache_problems(asked[:1]) == 0 and len(list(tmp_path.iterdir())) == 1
    monkeypatch.setattr(problem_cache, "get_cache_folder", lambda: None)
    assert problem_cache.cache_problems(asked) == 0
