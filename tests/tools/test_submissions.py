"""Some rounds of `make fuzz` with hostile submissions, and all its former finds."""

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
from tests.tools.submissions import Find, HostileClass, grade_random_round


@pytest.fixture(scope="module")
def hostile_class(tmp_path_factory: pytest.TempPathFactory) -> HostileClass:
    return HostileClass(tmp_path_factory.mktemp("class") / "hw")


@pytest.mark.parametrize("number", range(select_for_suite(15, 60)))
def test_a_random_hostile_submission_harms_no_other_student(hostile_class: HostileClass, number: int) -> None:
    grade_random_round(hostile_class, "test", number)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_hostile_submission_writes_files(kind: str, tmp_path: Path) -> None:
    cells = [code_cell(f"p1_x{number} = 1") for number in range(5)]
    for number in range(3):
        submit_random(tmp_path, json.dumps({"cells": cells}), Stream(f"{kind}/{number}"), (kind,))
    assert any(tmp_path.iterdir())
    folder_removal.remove_folder(str(tmp_path))  # pytest can't remove it


def submit_nothing(root: Path, right: str) -> str:
    return "nothing"


def remove_neighbours_notebook(root: Path, right: str) -> str:
    (root / NEIGHBOUR / "hw.ipynb").unlink()
    return "neighbour's notebook removed"


def test_a_neighbour_without_full_marks_is_a_find(hostile_class: HostileClass) -> None:
    with pytest.raises(Find, match="the neighbour is missing with 0") as found:
        hostile_class.grade_round(remove_neighbours_notebook)
    assert found.value.__notes__ == ["neighbour's notebook removed"]


def test_a_changed_file_outside_graded_is_a_find(hostile_class: HostileClass, monkeypatch: pytest.MonkeyPatch) -> None:
    def write_and_touch(*arguments: Any) -> Any:
        (hostile_class.folder / "assignment.toml").touch()
        return write_reports(*arguments)

    monkeypatch.setattr(submissions, "write_reports", write_and_touch)
    with pytest.raises(Find, match=r"outside graded/ was changed: .*assignment.toml"):
        hostile_class.grade_round(submit_nothing)


def test_an_exception_and_unprintable_text_are_finds(
    hostile_class: HostileClass, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(submissions, "find_submissions", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError) as found:
            hostile_class.grade_round(submit_nothing)
        assert found.value.__notes__ == ["nothing"]
    monkeypatch.setattr(
        submissions.HostileClass, "_grade_here", _add_unprintable_message(submissions.HostileClass._grade_here)
    )
    with pytest.raises(Find, match="this can't be shown"):
        hostile_class.grade_round(submit_nothing)


def _add_unprintable_message(
    grade_here: Callable[[HostileClass, Path], list[str]],
) -> Callable[[HostileClass, Path], list[str]]:
    return lambda hostile_class, source: [*grade_here(hostile_class, source), "\x1b[2J"]


@pytest.mark.whole
def test_the_command_grades_a_random_hostile_submission(hostile_class: HostileClass) -> None:
    grade_random_round(hostile_class, "test", submissions.COMMAND_INTERVAL - 1)


# --- former finds ---


def submit_too_long_link(root: Path, right: str) -> str:
    (root / ATTACKER).symlink_to("x" * 300)
    return "link"


def submit_too_long_path(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    top = os.open(root / ATTACKER, os.O_RDONLY)
    for _ in range(25):
        os.mkdir("d" * 200, dir_fd=top)
        inner = os.open("d" * 200, os.O_RDONLY, dir_fd=top)
        os.close(top)
        top = inner
    os.close(top)
    return "path"


def submit_gradescope_metadata(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    (root / ATTACKER / "submission_metadata.yml").write_text("submission_7:\n")
    return "list"


def submit_null_character(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    data = json.loads(right)
    data["cells"][2]["source"] = "p1_position = '\\x00'"
    (root / ATTACKER / "hw.ipynb").write_text(json.dumps(data))
    return "null"


def submit_terminal_escape(root: Path, right: str) -> str:
    (root / ATTACKER).mkdir()
    data = json.loads(right)
    data["cells"][1]["source"] = "raise Exception('\\x1b[2J\\ud800')"
    (root / ATTACKER / "hw.ipynb").write_text(json.dumps(data))
    return "error"


FINDS: dict[Callable[[Path, str], str], str] = {
    submit_too_long_link: "unusable", submit_too_long_path: "unusable", submit_gradescope_metadata: "unusable",
    submit_null_character: "graded", submit_terminal_escape: "graded",
}  # fmt: skip
"""Former finds, each with the expected status of the student who submits it."""


@pytest.mark.parametrize("submit", FINDS)
def test_former_finds_are_fixed(hostile_class: HostileClass, submit: Callable[[Path, str], str]) -> None:
    _, result = hostile_class.grade_round(submit, flat=True)
    assert find_work_status(result) == FINDS[submit]
