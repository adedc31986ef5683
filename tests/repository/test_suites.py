"""The suites: whatever is left out has its turn, those that stand for shapes often, and a change finds its tests."""

from math import gcd
from pathlib import Path

import pytest

from exercises.families import FAMILIES
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from tests.support import ROOT, kept, suites
from tests.support.suites import SHAPES, SHAPES_SHARE, SHARE, TURNS, covering, families_for, shape_of, told

DAYS = range(739_000, 739_000 + SHARE)


def test_every_family_is_of_a_shape_for_which_one_stands() -> None:
    shapes = {name: shape_of(sample_chain(ProblemId(name, 0)), FAMILIES[name].varied) for name in FAMILIES}
    assert set(shapes.values()) == set(SHAPES)
    assert all(shapes[name] == shape for shape, name in SHAPES.items())


def test_a_sweep_takes_each_shape_every_fourth_day_and_each_family_in_its_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "WHOLE", False)
    monkeypatch.setattr(suites, "SUITE", "test")
    taken = []
    for day in DAYS:
        monkeypatch.setattr(suites, "ROTATION", day)
        taken.append(families_for("a test"))
        assert len(taken) < 4 or set(SHAPES.values()) <= set().union(*taken[-4:])
    assert set().union(*taken) == set(FAMILIES)
    assert max(map(len, taken)) < len(FAMILIES) / 2
    assert [families_for(f"test {k}") for k in range(5)] != [families_for("test 0")] * 5
    assert families_for("a test", ["ur-6r"]) == ["ur-6r"]


def test_what_takes_seconds_has_its_turn_and_what_takes_more_is_left_to_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    times = {"tests/a.py::quick": 0.5, "tests/a.py::slow": 0.8, "tests/a.py::slower": 5.0, "tests/a.py::slowest": 7.0}
    monkeypatch.setattr(suites, "SECONDS", {**times, "tests/grader/contained/a.py::slow": 11.0})
    turns: dict[str, int] = {}
    for test in (*suites.SECONDS, "tests/a.py::new"):
        for day in range(739_000, 739_021):
            monkeypatch.setattr(suites, "ROTATION", day)
            turns[test] = turns.get(test, 0) + suites.has_its_turn(ROOT / "a.py", f"{test}[x]", "")
    assert list(turns.values()) == [21, 7, 3, 0, 21, 21]
    monkeypatch.setattr(suites, "uncommitted", lambda: ("grader/roster.py",))
    assert suites.has_its_turn(ROOT / "tests/grader/test_layouts.py", "tests/a.py::slowest", "")


def test_a_group_that_shares_what_takes_long_has_its_turn_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "SECONDS", {"@class": 5.0, "@course": 20.0, "tests/a.py::slow": 0.8})
    days = set()
    for day in range(739_000, 739_021):
        monkeypatch.setattr(suites, "ROTATION", day)
        run = [suites.has_its_turn(ROOT / "a.py", f"tests/a.py::{test}@class", "class") for test in ("slow", "quick")]
        assert run[0] == run[1]
        days.add((day % 7, run[0]))
        assert not suites.has_its_turn(ROOT / "a.py", "tests/a.py::quick@course", "course")
    assert len(days) == 7 and sum(run for _, run in days) == 1


def test_every_test_sees_every_family_some_day_however_long_it_takes() -> None:
    assert all(gcd(days, share) == 1 for _, days in TURNS for share in (SHARE, SHAPES_SHARE))


def test_what_takes_long_has_a_table_of_tests_that_are_there() -> None:
    files = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py"))
    for name in suites.SECONDS:
        if name.startswith("@"):
            assert f'xdist_group("{name[1:]}")' in files, name
            continue
        file, _, test = name.partition("[")[0].partition("::")
        assert (
            f"def {test.rpartition('.')[2].partition('::')[2] or test.rpartition('.')[2]}" in (ROOT / file).read_text()
        ), name


def test_what_takes_long_looks_at_five_families_and_at_all_in_a_week(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "WHOLE", False)
    monkeypatch.setattr(suites, "SUITE", "test")
    taken = []
    for day in DAYS[:7]:
        monkeypatch.setattr(suites, "ROTATION", day)
        taken.append(suites.few_for("a test", FAMILIES, 5))
    assert {len(set(some)) for some in taken} == {5}
    assert set().union(*taken) == set(FAMILIES)
    monkeypatch.setattr(suites, "WHOLE", True)
    assert set(suites.few_for("a test", FAMILIES, 5)) == set(FAMILIES)


def test_check_takes_one_family_and_whole_takes_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "WHOLE", False)
    monkeypatch.setattr(suites, "SUITE", "check")
    assert {len(families_for(f"test {k}")) for k in range(9)} == {1}
    assert len({*(families_for(f"test {k}")[0] for k in range(200))}) == len(FAMILIES)
    monkeypatch.setattr(suites, "WHOLE", True)
    assert families_for("a test") == list(FAMILIES)


def test_what_check_always_runs_is_there() -> None:
    for name in suites.ALWAYS:
        file, _, begin = name.partition("::")
        text = (ROOT / "tests" / file).read_text(encoding="utf-8")
        assert f"\ndef {begin or 'test_'}" in text, name


@pytest.mark.parametrize(
    ("changed", "found"),
    [
        ("exercises/formula/exact.py", "tests/exercises/formula/test_exact.py"),
        ("grader/roster.py", "tests/grader/test_layouts.py"),
        ("exercises/figure/__init__.py", "tests/exercises/figure/test_figure.py"),
        ("tests/grader/test_formulas.py", "tests/grader/test_formulas.py"),
        ("templates/exports/moodle.xml.j2", "tests/exercises/exports/test_platforms.py"),
        ("docs/families.md", "tests/exercises/docs/test_docs.py"),
        ("README.md", "tests/repository/test_readme.py"),
        ("exercises/formula/vocabulary.json", "tests/tools/test_readers.py"),
        ("grader/statistics.py", "grader/statistics.py"),
    ],
)
def test_a_change_finds_its_tests(changed: str, found: str) -> None:
    assert ROOT / found in covering(changed)


def test_every_module_has_tests_that_make_check_would_run() -> None:
    modules = [*(ROOT / "exercises").rglob("*.py"), *(ROOT / "grader").rglob("*.py")]
    assert len(modules) > 250
    assert not [path for path in modules if not covering(path.relative_to(ROOT).as_posix())]


def test_a_run_says_what_it_left_out_and_what_runs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suites, "SUITE", "test")
    said = " ".join(told(3, 40, 200))
    assert (
        "left out 3 tests" in said
        and "200 that take seconds" in said
        and "40 families" in said
        and "`make whole` runs" in said
    )
    assert f"QDOT_ROTATION={suites.ROTATION} make test" in said
    monkeypatch.setattr(suites, "SUITE", "whole")
    assert "nothing is left out" in told(0, 0)[0]


def test_make_has_the_suites_and_the_nightly_workflow_runs_the_whole() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert all(f"\n{suite}:" in makefile for suite in suites.SUITES)
    workflow = Path(ROOT / ".github" / "workflows" / "whole.yml").read_text(encoding="utf-8")
    assert "cron:" in workflow and "run: make whole" in workflow


def test_problems_are_kept_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(kept, "folder", lambda: tmp_path)
    asked = [ProblemId("cartesian", 0), ProblemId("planar-pr", 0)]
    kept.kept(asked[0])
    assert kept.keep(asked[:1]) == 0 and len(list(tmp_path.iterdir())) == 1
    monkeypatch.setattr(kept, "folder", lambda: None)
    assert kept.keep(asked) == 0
