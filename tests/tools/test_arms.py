"""What `qdot solve` prints of arms that nobody has thought of holds; what is false would be found."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.arm.robot_file import Robot
from exercises.arm.singularity import Component
from tests.support.suites import few_of
from tests.tools import arms as tool
from tests.tools.arms import Outcome, arms, every_arm, outcome

SECONDS = 6.0


def _taken() -> list[tuple[str, Robot]]:
    """Return some of the arms; in `make whole` all of them."""
    return few_of(every_arm(300, "a", 60), 8)


@pytest.mark.parametrize("robot", [pytest.param(robot, id=name) for name, robot in _taken()])
def test_nothing_that_is_told_is_false(robot: Robot) -> None:
    assert outcome(robot, SECONDS).false == ()


TWO_R = Chain(
    "two",
    (Joint("R", "theta1", 0, "a1", 0), Joint("R", "theta2", 0, sp.Rational(3, 10), 0)),
    ("vx", "vy"),
)


def test_an_arm_without_falsehoods() -> None:
    result = outcome(Robot(TWO_R), SECONDS)
    assert result.false == () and result.missing == () and result.seconds < SECONDS


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ((), "of 90 searches ended elsewhere"),
        ((Component((sp.cos(sp.Symbol("theta2")),), None),), "J keeps its rank where cos(theta2) = 0"),
        (
            (Component((sp.sin(sp.Symbol("theta2")),), ((sp.Symbol("theta2"), (sp.S.Zero, sp.pi / 2)),)),),
            "is told of sin(theta2) = 0, and is no solution",
        ),
    ],
)
def test_a_falsehood_is_found(monkeypatch: pytest.MonkeyPatch, told: tuple[Component, ...], said: str) -> None:
    """A singular set that is wrong, for an arm that nothing is kept of."""
    monkeypatch.setattr("exercises.solving.singular_set", lambda _: told)
    monkeypatch.setattr("exercises.writing.worked.singular_set", lambda _: told)
    monkeypatch.setattr("exercises.solving._doubt", lambda *_: "")  # it would be told
    chain = replace(TWO_R, name=f"two {said[:9]}", title=said[:9])
    assert any(said in one for one in outcome(Robot(chain), SECONDS).false)


def _run(monkeypatch: pytest.MonkeyPatch, path: Path, *options: str) -> int:
    few = ["--count", "2", "--seeds", "1", "--seconds", "6"]
    monkeypatch.setattr("sys.argv", ["arms", *([] if options else few), "--record", str(path), *options])
    return tool.main()


def test_a_run_that_is_stopped_goes_on_and_one_of_other_code_begins_anew(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path, looked_at = tmp_path / "arms.json", list[str]()

    def looked(robot: Robot, seconds: float) -> Outcome:
        if robot.chain.name == "random-3":
            raise KeyboardInterrupt
        looked_at.append(robot.chain.name)
        return Outcome(("it is false",) if robot.chain.name == "a/1" else (), ("special_lengths",), 0.04)

    monkeypatch.setattr(tool, "outcome", looked)
    with pytest.raises(KeyboardInterrupt):
        _run(monkeypatch, path)
    assert looked_at == ["a/0", "a/1", "random-2"]
    assert json.loads(path.read_text())["arms"].keys() == {"a/0", "a/1", "random-2/0"}
    monkeypatch.setattr(tool, "outcome", lambda *_: Outcome((), (), 1.26))
    assert _run(monkeypatch, path) == 1
    record = json.loads(path.read_text())
    assert record["arms"]["a/1"] == {"seconds": 0.0, "missing": ["special_lengths"], "false": ["it is false"]}
    assert record["arms"]["random-4/0"] == {"seconds": 1.3}
    assert tool.summary(record) == "5 arms, 3 not finished in 6 s and said so, 1 with what is false"
    assert _run(monkeypatch, path, "--again") == 0
    again = json.loads(path.read_text())
    assert again["again"]["arms"] == {"a/1": {"seconds": 1.3}} and again["arms"] == record["arms"]
    assert tool.false_in(again) == [] and tool.summary(again).endswith(", 0 when looked at again")
    path.write_text(json.dumps(record | {"code": "other"}))
    assert _run(monkeypatch, path) == 0 and "again" not in json.loads(path.read_text())


def test_what_the_last_run_found_false_is_mended() -> None:
    record = json.loads(tool.RECORD.read_text(encoding="utf-8"))
    assert len(record["arms"]) == record["count"] + record["seeds"] * len(tool.FAMILIES) >= 480
    assert tool.false_in(record) == []
    assert all("seconds" in row and row["seconds"] <= record["limit"] + tool.SLACK for row in record["arms"].values())


def test_a_wrong_formula_is_found() -> None:
    values = {"theta1": 0.3, "theta2": 0.4, "a1": 0.5}
    right = [0.5 * 0.9553364891, 0.0]
    assert list(tool._differs("p", ["a1*cos(theta1)", "0"], right, values)) == []
    assert len(list(tool._differs("p", ["a1*sin(theta1)", "0"], right, values))) == 1


def test_arms_are_the_same_for_a_seed() -> None:
    first, again = ([robot.chain for robot in arms(20, "b")] for _ in range(2))
    assert first == again and len({chain.n for chain in first}) > 3
    assert any(joint.kind == "P" for chain in first for joint in chain.joints)
