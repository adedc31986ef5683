"""A part of `make fuzz`: some rounds of what nobody should hand in, and all that was found so."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.common.stream import Stream
from qdot.grader.reports.graded_folder import write_reports
from qdot.grader.reports.grades_table import find_work_status
from qdot.grader.sandbox.notebook_process import folder_removal
from tests.support.submitting import code_cell
from tests.support.suites import select_for_suite
from tests.tools import submissions
from tests.tools.hostile import ATTACKER, KINDS, NEIGHBOUR, submit_random
from tests.tools.submissions import Class, Find, drawn_round


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Class:
    return Class(tmp_path_factory.mktemp("class") / "hw")


@pytest.mark.parametrize("number", range(select_for_suite(15, 200)))
def test_what_is_drawn_stops_nobody(made: Class, number: int) -> None:
    drawn_round(made, "test", number)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_hands_something_in(kind: str, tmp_path: Path) -> None:
    cells = [code_cell(f"p1_x{number} = 1") for number in range(5)]
    for number in range(3):
        submit_random(tmp_path, json.dumps({"cells": cells}), Stream(f"{kind}/{number}"), (kind,))
    assert any(tmp_path.iterdir())
    folder_removal.remove_folder(str(tmp_path))  # pytest can't


def test_the_same_seed_hands_in_the_same(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        submit_random(tmp_path / folder, "{}", Stream("same"), ("names", "bytes"))
    one, two = ([path.name for path in sorted((tmp_path / folder).rglob("*"))] for folder in ("one", "two"))
    assert one == two != []


def nothing(root: Path, right: str) -> str:
    return "nothing"


def lose_the_neighbours(root: Path, right: str) -> str:
    (root / NEIGHBOUR / "hw.ipynb").unlink()
    return "the neighbour's is gone"


def test_a_neighbour_without_full_marks_is_a_find(made: Class) -> None:
    with pytest.raises(Find, match="the neighbour is missing with 0") as found:
        made.round(lose_the_neighbours)
    assert found.value.__notes__ == ["the neighbour's is gone"]


def test_a_file_that_is_changed_is_a_find(made: Class, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(*about: Any) -> Any:
        (made.folder / "assignment.toml").touch()
        return write_reports(*about)

    monkeypatch.setattr(submissions, "write_reports", write)
    with pytest.raises(Find, match=r"outside graded/ was changed: .*assignment.toml"):
        made.round(nothing)


def test_what_is_raised_or_can_not_be_shown_is_a_find(made: Class, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(submissions, "find_submissions", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError) as found:
            made.round(nothing)
        assert found.value.__notes__ == ["nothing"]
    monkeypatch.setattr(submissions.Class, "_here", _with_a_stranger(submissions.Class._here))
    with pytest.raises(Find, match="this can't be shown"):
        made.round(nothing)


def _with_a_stranger(here: Callable[[Class, Path], list[str]]) -> Callable[[Class, Path], list[str]]:
    return lambda of, source: [*here(of, source), "\x1b[2J"]


@pytest.mark.parametrize("zipped", [False, True])
def test_a_right_notebook_is_no_find(made: Class, zipped: bool) -> None:
    def hand(root: Path, right: str) -> str:
        (root / ATTACKER).mkdir()
        (root / ATTACKER / "hw.ipynb").write_text(right)
        return "a right one"

    case, result = made.round(hand, zipped=zipped, flat=True)
    assert (case, result.score) == ("a right one", 4)


@pytest.mark.whole
def test_the_command_grades_what_is_drawn(made: Class) -> None:
    drawn_round(made, "test", submissions.COMMAND - 1)


# --- what was found ---


def too_long_a_link(root: Path, right: str) -> str:
    (root / ATTACKER).symlink_to("x" * 300)
    return "link"


def too_long_a_path(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    top = os.open(root / ATTACKER, os.O_RDONLY)
    for _ in range(25):
        os.mkdir("d" * 200, dir_fd=top)
        inner = os.open("d" * 200, os.O_RDONLY, dir_fd=top)
        os.close(top)
        top = inner
    os.close(top)
    return "path"


def a_list_of_gradescopes(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    (root / ATTACKER / "submission_metadata.yml").write_text("submission_7:\n")
    return "list"


def a_null_in_an_answer(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    data = json.loads(right)
    data["cells"][2]["source"] = "p1_position = '\\x00'"
    (root / ATTACKER / "hw.ipynb").write_text(json.dumps(data))
    return "null"


def an_error_that_controls_a_terminal(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    data = json.loads(right)
    data["cells"][1]["source"] = "raise Exception('\\x1b[2J\\ud800')"
    (root / ATTACKER / "hw.ipynb").write_text(json.dumps(data))
    return "error"


FINDS: dict[Callable[[Path, str], str], str] = {
    too_long_a_link: "unusable", too_long_a_path: "unusable", a_list_of_gradescopes: "unusable",
    a_null_in_an_answer: "graded", an_error_that_controls_a_terminal: "graded",
}  # fmt: skip
"""Findings, each with the expected result of the student who submits it."""


@pytest.mark.parametrize("found", FINDS)
def test_former_finds_are_fixed(made: Class, found: Callable[[Path, str], str]) -> None:
    _, result = made.round(found, flat=True)
    assert find_work_status(result) == FINDS[found]
