"""`qdot solve` ends in time, or by Ctrl-C, with all that is ready, and says what is missing."""

import json
import re
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.common.time_limit import OutOfTime, parse_seconds, time_limit
from qdot.exercises.robots.library import find_robot_path
from qdot.exercises.robots.robot_file import Robot, read_robot_file
from qdot.exercises.solve.solver import generate_data_events, generate_text_events, solve
from qdot.exercises.solve.time_limited import write_solution
from tests.repository.test_schemas import find_schema_errors
from tests.support.command import run, run_and_fail
from tests.support.suites import sample_for_suite

ROW = '[[joint]]\nkind = "R"\ntheta = "theta%d"\nd = %s\na = %s\nalpha = "%d*pi/180"\n'
SKEW = [(0.3, 0.2, 40), (0.1, 0.3, -55), (0.2, 0.25, 70), (0.15, 0.2, 35), (0.1, 0.1, 50), (0.2, 0.1, 0)]
TWO_R = [(0, '"a1"', 0), (0, '"a2"', 0)]


def _robot(folder: Path, rows: Sequence[tuple[object, object, int]]) -> Robot:
    path = folder / "arm.toml"
    path.write_text('name = "arm"\n' + "".join(ROW % (i, *row) for i, row in enumerate(rows, 1)))
    return read_robot_file(path)


def _written(robot: Robot, form: str, seconds: float = 60, shown: Callable[..., Any] = lambda _: nullcontext()) -> str:
    said: list[str] = []
    with suppress(KeyboardInterrupt):
        write_solution(robot, form, seconds, said.append, shown)
    return "".join(said)


@pytest.mark.whole
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


def test_an_arm_that_takes_minutes_ends_in_time_and_says_so(tmp_path: Path) -> None:
    before = time.process_time()
    robot = _robot(tmp_path, SKEW)
    assert len(robot.chain.task) == 6 and time.process_time() - before < 3
    text = _written(robot, "text", 0.8)
    assert time.process_time() - before < 8
    assert "T_(5,6)" in text
    said = " ".join(text[text.index("What is missing") :].split())
    assert "Determinant of the Jacobian; Singular configurations" in said and "0.8 seconds" in said and "--time" in said
    content = json.loads(_written(robot, "json", 0.5))
    assert find_schema_errors("solve", content) == []
    assert content["missing"][-2:] == ["determinant", "singular"] and content["singular"] is None
    assert "What is missing" in _written(robot, "latex", 0.5)


def _stopped(robot: Robot, form: str, stop: str) -> str:
    """Return what is said where Ctrl-C comes at work on something."""
    stops: list[str] = []

    def shown(what: str) -> AbstractContextManager[object]:
        if what == stop:
            stops.append(what)
            raise KeyboardInterrupt
        return nullcontext()

    text = _written(robot, form, shown=shown)
    assert stops
    return " ".join(text.split()) if form == "text" else text


def _keys(robot: Robot, stop: str) -> dict[str, Any]:
    """Return the JSON of what there is where Ctrl-C comes, which is valid."""
    content: dict[str, Any] = json.loads(_stopped(robot, "json", stop))
    assert find_schema_errors("solve", content) == []
    return content


LOOKS, TEST = "the geometry of these configurations", "the numeric test of these conditions"
LOOKING = "the geometry of the configurations in which J loses rank"
KINDS = ["type", "uniform", "meaning"]
STOPS = [
    ("the determinant of J", "det J = a₁ a₂ s₂", "Singular configurations", ["singular"]),
    ("where the determinant of J is zero", "exactly when det J = 0", "these configurations", ["singular"]),
    (LOOKING, "s₂ = 0", f"{LOOKS}; {TEST}", [*KINDS, "tested"]),
    (TEST, "folded back", TEST, ["tested"]),
]


@pytest.mark.parametrize(("stop", "there", "missing", "keys"), sample_for_suite(STOPS, 4))
def test_ctrl_c_keeps_what_is_there_and_names_what_is_not(
    stop: str, there: str, missing: str, keys: list[str], tmp_path: Path
) -> None:
    robot = _robot(tmp_path, TWO_R)
    text = _stopped(robot, "text", stop)
    assert there in text
    reason = rf"Not derived: {re.escape(missing)}.* stopped because .*, at this step: {re.escape(stop)}\."
    assert re.search(reason, text)
    assert "What is missing" in _stopped(robot, "latex", stop)
    content = _keys(robot, stop)
    assert content["missing"] == keys and stop in content["note"]
    if "singular" in keys:
        assert content["singular"] is None
        return
    (told,), (whole,) = content["singular"], json.loads(_written(robot, "json"))["singular"]
    assert told == whole | dict.fromkeys(set(keys) & set(whole))
    assert content["determinant"] == str(solve(robot.chain).determinant)


def test_jacobians_of_screws_are_missing_by_their_names(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    row = '[[joint]]\nkind = "R"\naxis = [0, 0, 1]\npoint = [%s, 0, 0]\n'
    path.write_text(f'name = "arm"\nconvention = "screws"\npoint = [0.7, 0, 0]\n{row % 0}{row % 0.4}')
    robot = read_robot_file(path)
    content = _keys(robot, "the body Jacobian")
    assert content["missing"] == ["body_jacobian", "determinant", "singular"]
    assert content["space_jacobian"][2] == ["1", "1"] and content["body_jacobian"] is None
    assert _keys(robot, "the position")["space_jacobian"] is None
    assert "missing" not in json.loads(_written(robot, "json"))


def test_a_section_that_was_stopped_while_it_was_written_is_missing(tmp_path: Path) -> None:
    said: list[str] = []

    def say(block: str) -> None:
        if "Jacobian by differentiation" in block and "What is missing" not in block:
            raise KeyboardInterrupt
        said.append(block)

    with pytest.raises(KeyboardInterrupt):
        write_solution(_robot(tmp_path, TWO_R), "text", 60, say, lambda _: nullcontext())
    text = " ".join("".join(said).split())
    assert "Not derived: Jacobian by differentiation; Cartesian velocity" in text


def test_where_all_is_there_nothing_is_missing(tmp_path: Path) -> None:
    """Ctrl-C between the last result and the end."""
    robot = _robot(tmp_path, TWO_R)
    for form in ("text", "latex", "json"):
        left = [None for _ in (generate_data_events(robot.chain) if form == "json" else generate_text_events(robot))]

        def shown(what: str, left: list[None] = left) -> AbstractContextManager[object]:
            if not left:
                raise KeyboardInterrupt
            left.pop()
            return nullcontext()

        assert _written(robot, form, shown=shown) == _written(robot, form) and not left


def test_the_time_is_an_option_and_ending_by_it_is_no_failure(tmp_path: Path) -> None:
    _robot(tmp_path, SKEW)
    assert "What is missing" in run("solve", tmp_path / "arm.toml", "--time", "0.3")


STOPPED_IN = """
import os, pkgutil, signal, sys
place, name = sys.argv[1].rsplit(".", 1)
where = pkgutil.resolve_name(place)
usual = getattr(where, name)

def stopped(*args, **options):
    os.kill(os.getpid(), signal.SIGINT)
    return usual(*args, **options)

setattr(where, name, stopped)
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.argv[:2] = ["qdot"]
from qdot.grader.cli.main import main
main()
"""


@pytest.mark.parametrize(
    ("where", "form", "missing"),
    [
        ("typer.core.TyperCommand.parse_args", "json", ""),  # the program is there, its command is not
        pytest.param("qdot.exercises.robots.robot_file.read_toml", "json", "", marks=pytest.mark.whole),
        pytest.param("qdot.exercises.solve.solver.derive", "text", "What", marks=pytest.mark.whole),
        pytest.param("qdot.exercises.solve.solver.derive", "json", "position", marks=pytest.mark.whole),
        ("qdot.exercises.solve.solver.find_singular_set", "json", "singular"),
    ],
)
def test_ctrl_c_at_the_very_beginning_is_told_in_one_line(where: str, form: str, missing: str, tmp_path: Path) -> None:
    """Results go to standard output, and before anything was worked out there are none; then there is one object."""
    _robot(tmp_path, TWO_R)
    command = [sys.executable, "-c", STOPPED_IN, where, "solve", str(tmp_path / "arm.toml"), "-f", form]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert (ended.returncode, ended.stderr) == (130, "qdot: stopped\n")
    if form == "text" or not missing:
        assert "What is missing" in ended.stdout if missing else ended.stdout == ""
    else:
        content = json.loads(ended.stdout)
        assert find_schema_errors("solve", content) == [] and content["missing"][0] == missing


@pytest.mark.parametrize("text", ["x", "", "0", "0.09", "-3", "nan", "inf", "1e9", "1e400", "0,5", "5 min", "٣"])
def test_a_time_that_is_none_is_told_in_one_line(text: str, tmp_path: Path) -> None:
    _robot(tmp_path, TWO_R)
    said = run_and_fail("solve", tmp_path / "arm.toml", f"--time={text}")
    assert said.startswith(f"qdot: --time {text!r}: ") and "0.1 to 100000000" in said and "\n" not in said


def test_times_are_read_as_numbers() -> None:
    texts = ("300", "0.1", ".5", "1e2", " 7 ", "+2.", "1e8")
    assert [parse_seconds(text) for text in texts] == [300, 0.1, 0.5, 100, 7, 2, 1e8]


@pytest.mark.whole
def test_conditions_that_were_tested_are_kept_where_what_they_look_like_is_not() -> None:
    """An arm of seven joints: the time limit is reached after the numeric test."""
    robot = read_robot_file(find_robot_path("iiwa7"))

    def ended(title: str) -> AbstractContextManager[object]:
        if title == LOOKING:
            raise OutOfTime
        return nullcontext()

    whole, data = json.loads(_written(robot, "json")), json.loads(_written(robot, "json", shown=ended))
    assert find_schema_errors("solve", data) == [] and data["missing"] == ["meaning"]
    assert len(whole["singular"]) > 1
    assert [one["conditions"] for one in data["singular"]] == [one["conditions"] for one in whole["singular"]]
    assert {one["meaning"] for one in data["singular"]} == {None} != {one["meaning"] for one in whole["singular"]}
    assert data["tested"] == whole["tested"] and data["note"].startswith(whole["note"])
    shown = " ".join(_written(robot, "text", shown=ended).split())
    assert "as far as they were derived" in shown and f"{whole['tested']['searches']} searches" in shown
    assert f"Not derived: {LOOKS}." in shown
