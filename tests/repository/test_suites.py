"""The suites: each selects the same tests every day, and one family represents each shape of arm."""

from pathlib import Path

import pytest

from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from tests.support import ROOT, problem_cache, suites
from tests.support.suites import SHAPES, classify_shape, describe_left_out, sample_for_suite, select_families


def test_every_shape_of_arm_is_represented_by_a_family() -> None:
    shapes = {
        name: classify_shape(sample_chain(ProblemId(name, 0)), FAMILIES[name].has_varied_structure) for name in FAMILIES
    }
    assert set(shapes.values()) == set(SHAPES)
    assert all(shapes[name] == shape for shape, name in SHAPES.items())


def test_each_suite_selects_its_families(monkeypatch: pytest.MonkeyPatch) -> None:
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
        path, _, beginning = name.partition("::")
        text = (ROOT / "tests" / path).read_text(encoding="utf-8")
        assert f"\ndef {beginning.partition('[')[0] or 'test_'}" in text, name


def test_a_run_says_what_it_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "WHOLE", False)
    monkeypatch.setattr(suites, "SUITE", "test")
    assert describe_left_out(3, 40) == "make test left out 3 tests and 40 families of sweeps; `make whole` runs them"
    monkeypatch.setattr(suites, "WHOLE", True)
    assert "nothing is left out" in describe_left_out(0, 0)


def test_the_suites_are_make_targets_and_the_whole_runs_nightly() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert all(f"\n{suite}:" in makefile for suite in suites.SUITES)
    workflow = Path(ROOT / ".github" / "workflows" / "whole.yml").read_text(encoding="utf-8")
    assert "cron:" in workflow and "run: make whole" in workflow


def test_problems_are_cached_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(problem_cache, "get_cache_folder", lambda: tmp_path)
    problem_ids = [ProblemId("cartesian", 0), ProblemId("planar-pr", 0)]
    problem_cache.load_problem(problem_ids[0])
    assert problem_cache.cache_problems(problem_ids[:1]) == 0 and len(list(tmp_path.iterdir())) == 1
    monkeypatch.setattr(problem_cache, "get_cache_folder", lambda: None)
    assert problem_cache.cache_problems(problem_ids) == 0
