"""`qdot upgrade-check`: what another version would make of a class, told without touching the folder."""

import json
import shutil
from pathlib import Path
from unittest.mock import patch

import pytest

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.assignment.release import release
from qdot.grader.grading import upgrade
from qdot.grader.grading.certify import CERTIFIER
from tests.support.command import fails, run
from tests.support.handing_in import a_class, contents, hand_in, one_process, right


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = a_class(tmp_path_factory.mktemp("upgrade") / "hw", [Student("ada"), Student("bo")])
    release(made, CERTIFIER, 1, lambda _: None)
    hand_in(made, "ada/hw.ipynb", right(made, "ada"))
    hand_in(made, "bo/hw.ipynb", right(made, "bo", lambda cells: cells[-1].update(source="p1_determinant = a1")))
    with one_process():
        run("grade", made.folder, "--jobs", "1")
    return made.folder


@pytest.fixture
def folder(graded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(graded, tmp_path / "hw"))


def checked(folder: Path, *options: str, code: int = 0) -> list[str]:
    """Return the lines that are printed after the first, without the folder's name; nothing is written by that."""
    before = contents(folder)
    with one_process():
        said = run("upgrade-check", folder, "--jobs", "1", *options, code=code)
    assert contents(folder) == before
    return said.replace(str(folder), "hw").splitlines()[1:]


SAME = [
    "problems   2 of 2 are the same as were handed out",
    "notebooks  'qdot generate' keeps all 2 as they are",
    "wording    a notebook that is made anew reads the same",
    "marks      2 results are of this very grader; 'qdot grade' grades none again",
]


def change(folder: Path, title: str = "", **record: object) -> None:
    """Write something else into the record that is kept of ada's problem, or of the notebook's title."""
    path = folder / "certificates" / "ada" / "hw.json"
    content = json.loads(path.read_text())
    content["problems"]["p1"].update(record)
    if title:
        content["notebook"]["title"] = title
    path.write_text(json.dumps(content, indent=1))


def test_of_the_same_version_nothing_differs(folder: Path) -> None:
    first = run("upgrade-check", folder, "--jobs", "1").splitlines()[0]
    assert first.startswith("this is qdot ") and first.endswith("(engine 1)") and "was handed out by qdot " in first
    assert checked(folder, "--marks") == [*SAME, "no mark would move"]


def test_a_problem_that_would_be_another(folder: Path) -> None:
    parts = json.loads((folder / "certificates" / "ada" / "hw.json").read_text())["problems"]["p1"]["parts"]
    change(folder, qdot="0.0.9", sha256="0" * 64, parts={**parts, "jacobian": "0" * 64})
    which, count, *rest = checked(folder, code=1)
    assert "ada: planar-2r/" in which and "jacobian changed since qdot 0.0.9" in which
    assert "1 of 2" in count and "1 is another" in count and rest == SAME[1:]
    change(folder, engine=7, qdot="9.0.0")
    which, count, *_ = checked(folder, code=1)
    assert "engine 7 of qdot 9.0.0" in which and "1 is another" in count


def test_of_a_certificate_that_is_gone_nothing_tells(folder: Path) -> None:
    (folder / "certificates" / "bo" / "hw.json").unlink()
    which, count, notebooks, *_ = checked(folder, code=1)
    assert which.startswith("bo: ") and "hw.json is missing" in which
    assert "of 1 nothing tells" in count and "1 of 2 anew (bo)" in notebooks


def test_a_problem_that_this_version_cannot_make(folder: Path) -> None:
    fails_to = patch("qdot.exercises.assignment.assignment.generate", side_effect=ValueError("x"))
    with patch.object(upgrade, "changes_of", lambda *_: []), fails_to:
        lines = checked(folder, code=1)
    assert "ValueError: x" in lines[0] and "0 of 2" in lines[2] and "2 are others" in lines[2]


def test_what_would_be_worded_otherwise(folder: Path) -> None:
    change(folder, title="0" * 64)
    wording = checked(folder)[2]
    assert wording.startswith("wording    1 notebook ") and "(title)" in wording


def test_an_assignment_that_was_changed(folder: Path) -> None:
    toml = folder / "assignment.toml"
    toml.write_text(toml.read_text().replace("[1, 2, 1]", "[1, 3, 1]"))
    problems, notebooks, _, marks = checked(folder, code=1)
    assert problems == SAME[0] and "2 of 2 anew (ada, bo)" in notebooks
    assert marks.startswith("marks      2 of 2 ") and "assignment.toml" in marks


def test_marks_that_would_move(folder: Path) -> None:
    """As where an earlier grader gave bo full marks, and named its number."""
    path = folder / "graded" / "results.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    lines[1]["problems"][0]["parts"][2].update(outcome="correct", points=1.0)
    lines[1]["score"], lines[1]["made_from"]["grader"] = 4.0, 3
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    lines = checked(folder, "--marks", code=1)
    assert lines[3].startswith("marks      1 of 2 ") and "grader 3" in lines[3]
    assert lines[4:6] == ["bo  p1.determinant  1 → 0  grader changed", "bo  total  4 → 3  grader changed"]


def test_who_was_given_nothing_has_nothing_that_differs(folder: Path, tmp_path: Path) -> None:
    (folder / "roster.csv").write_text("student\nada\nbo\nnew\n")
    assert checked(folder) == SAME
    (folder / "roster.csv").write_text("student\nada\n")  # bo has left, and was handed out something all the same
    assert checked(folder)[0] == SAME[0]
    assert len(checked(a_class(tmp_path / "new", [Student("cy")]).folder)) == 1
    assert "is not a folder" in fails("upgrade-check", tmp_path / "none")
