"""The record of certified draws is true to its run, and a run goes on where the last one ended."""

import json
import sys
from pathlib import Path

import pytest

from exercises.families import FAMILIES
from exercises.problem import ENGINE
from grader.certificates import Failure, Kind
from grader.certify import Task
from tests.tools import draws

FEW = {"planar-2r": {"chapter": 3, "lengths": 0}}


@pytest.fixture
def record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A record of one family and two steps, which the tool goes on with."""
    path = tmp_path / "draws.json"
    path.write_text(json.dumps({**draws.empty(), "certified": FEW}))
    monkeypatch.setattr(draws, "FAMILIES", {"planar-2r": FAMILIES["planar-2r"]})
    monkeypatch.setattr(draws, "STEPS", dict.fromkeys(FEW["planar-2r"], ()))
    monkeypatch.setattr(sys, "argv", ["draws", "--count", "4", "--record", str(path)])
    return path


def test_a_run_goes_on_where_the_last_one_ended(record: Path) -> None:
    assert draws.main() == 0
    kept = json.loads(record.read_text())
    assert kept["certified"] == {"planar-2r": {"chapter": 4, "lengths": 4}} and kept["failed"] == {}
    assert list(draws.left(kept, 4)) == []


def test_what_fails_is_kept_and_told(
    record: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(tasks: list[Task], jobs: int) -> object:
        return ((task, [Failure(Kind.UNSOUND, "no")] if i == 1 else []) for i, task in enumerate(tasks))

    monkeypatch.setattr(draws, "certify_all", fail)
    assert draws.main() == 1
    assert len(json.loads(record.read_text())["failed"]) == 1 and "no" in capsys.readouterr().out
    monkeypatch.undo()
    monkeypatch.setattr(sys, "argv", ["draws", "--count", "0", "--record", str(record)])
    assert draws.main() == 0 and json.loads(record.read_text())["failed"] == {}  # looked at again


def test_another_engine_begins_anew(record: Path) -> None:
    record.write_text(json.dumps({**draws.empty(), "engine": ENGINE - 1, "certified": FEW}))
    assert draws.kept(record)["certified"] == {"planar-2r": {"chapter": 0, "lengths": 0}}


def test_no_draw_has_failed() -> None:
    kept = json.loads(draws.RECORD.read_text())
    assert kept["failed"] == {} and min(n for steps in kept["certified"].values() for n in steps.values()) >= 1
