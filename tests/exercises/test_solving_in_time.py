"""`qdot solve` ends in time, or by Ctrl-C, with all that is ready, and says what is missing."""

import json
import time
from collections.abc import Sequence
from contextlib import nullcontext
from functools import lru_cache
from pathlib import Path

import pytest

from exercises.arm.robot_file import Robot, read_robot_file
from exercises.solving import solution_json, solution_latex, solution_text, solve
from exercises.solving_in_time import seconds_of, write_solution
from exercises.time_limit import OutOfTime, time_limit
from tests.repository.test_schemas import errors
from tests.support.command import fails, run

ROW = '[[joint]]\nkind = "R"\ntheta = "theta%d"\nd = %s\na = %s\nalpha = "%d*pi/180"\n'
SKEW = [(0.3, 0.2, 40), (0.1, 0.3, -55), (0.2, 0.25, 70), (0.15, 0.2, 35), (0.1, 0.1, 50), (0.2, 0.1, 0)]
TWO_R = [(0, '"a1"', 0), (0, '"a2"', 0)]


def _robot(folder: Path, rows: Sequence[tuple[object, object, int]]) -> Robot:
    path = folder / "arm.toml"
    path.write_text('name = "arm"\n' + "".join(ROW % (i, *row) for i, row in enumerate(rows, 1)))
    return read_robot_file(path)


def _written(robot: Robot, form: str, seconds: float = 60) -> str:
    said: list[str] = []
    write_solution(robot, form, seconds, said.append, lambda _: nullcontext())
    return "".join(said)


def test_a_loop_ends_when_its_processor_time_is_over() -> None:
    before = time.process_time()
    with pytest.raises(OutOfTime), time_limit(0.3):
        while True:
            pass
    assert 0.25 < time.process_time() - before < 3
    with time_limit(0.2):
        time.sleep(0.4)  # takes nothing of the processor
    while time.process_time() - before < 1:
        pass  # and nothing is limited behind the block


def test_what_was_stopped_is_not_kept() -> None:
    asked: list[int] = []

    @lru_cache
    def half_made(number: int) -> int:
        asked.append(number)
        while len(asked) == 1:
            pass
        return number

    with pytest.raises(OutOfTime), time_limit(0.2):
        half_made(3)
    assert half_made(3) == 3 and asked == [3, 3]


def test_with_time_enough_it_writes_what_the_library_does(tmp_path: Path) -> None:
    robot = _robot(tmp_path, TWO_R)
    solution = solve(robot.chain)
    for form, written in (("text", solution_text), ("latex", solution_latex), ("json", solution_json)):
        assert _written(robot, form) == written(solution)
    assert "missing" not in json.loads(_written(robot, "json"))


def test_an_arm_that_takes_minutes_ends_in_time_and_says_so(tmp_path: Path) -> None:
    robot = _robot(tmp_path, SKEW)
    before = time.process_time()
    text = _written(robot, "text", 0.8)
    assert time.process_time() - before < 8
    assert "T_(5,6)" in text and "What is missing" in text
    said = " ".join(text[text.index("What is missing") :].split())
    assert "Determinant of the Jacobian; Singular configurations" in said
    assert "the 0.8 seconds of processor time were over (--time gives it more)" in said
    assert "of what is missing, nothing is claimed" in said
    content = json.loads(_written(robot, "json", 0.5))
    assert errors("solve", content) == []
    assert content["missing"][-2:] == ["determinant", "singular"] and content["singular"] is None
    assert "What is missing" in _written(robot, "latex", 0.5)


@pytest.mark.parametrize(
    ("stop", "left"),
    [
        ("where the determinant of J is zero", r"$J$ loses rank where $\det J$ is zero"),
        ("what the configurations look like in which J loses rank", "J loses rank where one of these holds"),
    ],
)
def test_ctrl_c_keeps_what_is_there(tmp_path: Path, stop: str, left: str) -> None:
    said: list[str] = []

    def shown(what: str) -> nullcontext[None]:
        if what == stop:
            raise KeyboardInterrupt
        return nullcontext()

    with pytest.raises(KeyboardInterrupt):
        write_solution(_robot(tmp_path, TWO_R), "text", 60, said.append, shown)
    text = " ".join("".join(said).split())
    assert "det J = a₁ a₂ s₂" in text and left.replace("$", "").replace(r"\det", "det") in text
    assert f"This ended because it was stopped, at work on {stop}" in text
    assert "Not worked out: Singular configurations. This ended" in text


def test_what_holds_for_special_lengths_only_comes_last(tmp_path: Path) -> None:
    def shown(what: str) -> nullcontext[None]:
        if what == "whether anything differs where a1 = a2":
            raise KeyboardInterrupt
        return nullcontext()

    for form in ("text", "json"):
        said: list[str] = []
        with pytest.raises(KeyboardInterrupt):
            write_solution(_robot(tmp_path, TWO_R), form, 60, said.append, shown)
        if form == "text":
            text = " ".join("".join(said).split())
            assert "the arm is folded back, a boundary singularity" in text
            assert "Not worked out: what holds for special lengths only. This ended" in text
        else:
            content = json.loads("".join(said))
            assert errors("solve", content) == []
            assert content["missing"] == ["special_lengths"] and content["singular"][0]["condition"] == "sin(theta2)"
            assert "whether anything differs where a1 = a2" in content["note"]


def test_the_time_is_an_option_and_ending_by_it_is_no_failure(tmp_path: Path) -> None:
    _robot(tmp_path, SKEW)
    assert "What is missing" in run("solve", tmp_path / "arm.toml", "--time", "0.3")
    assert "--time" in run("solve", "--help")
    _robot(tmp_path, TWO_R)
    assert "What is missing" not in run("solve", tmp_path / "arm.toml")


@pytest.mark.parametrize("text", ["x", "", "0", "0.09", "-3", "nan", "inf", "1e9", "1e400", "0,5", "5 min", "٣"])
def test_a_time_that_is_none_is_told_in_one_line(text: str, tmp_path: Path) -> None:
    _robot(tmp_path, TWO_R)
    said = fails("solve", tmp_path / "arm.toml", f"--time={text}")
    assert said == f"qdot: --time {text!r} is not from 0.1 to 100000000 seconds; write a number, as in --time 300"


def test_times_are_read_as_numbers() -> None:
    assert [seconds_of(text) for text in ("300", "0.1", ".5", "1e2", " 7 ", "+2.", "1e8")] == [
        300, 0.1, 0.5, 100, 7, 2, 1e8,
    ]  # fmt: skip


def test_an_arm_of_skew_axes_is_read_at_once(tmp_path: Path) -> None:
    """Which rows count was asked of its formulas, which take a minute."""
    before = time.process_time()
    assert len(_robot(tmp_path, SKEW).chain.task) == 6
    assert time.process_time() - before < 3
    planar = [(0, 0.3, 0)] * 6
    assert _robot(tmp_path, planar).chain.task == ("vx", "vy")
