"""What earlier versions handed out, and every name that they promised, held against this version.

`python -m tests.tools.archive VERSION` writes the archive of a release, which stays as it is; without a version, that
of what is not released yet.
"""

import copy
import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import load_assignment
from qdot.exercises.common.extras import find_qdot_version
from qdot.exercises.problem.problem import ENGINE
from qdot.grader.cli.reference_pages import compatibility_page
from qdot.grader.grading.attempt import GRADER_VERSION
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.certificates import FailureKind
from qdot.grader.grading.certify import list_tasks, verify_all
from qdot.grader.grading.history import find_mark_changes, read_previous_results
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions
from tests.support import ROOT
from tests.tools.archive import ARCHIVES, SCHEMAS, UNRELEASED, interface

EVERY = sorted(path for path in ARCHIVES.iterdir())
archives = pytest.mark.parametrize("archive", EVERY, ids=lambda path: path.name)
ANEW = "python -m tests.tools.archive writes what is not released anew; what is released is promised"


def about(archive: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((archive / "about.json").read_text(encoding="utf-8"))
    return content


def major(number: str) -> str:
    """Return the part of a version within which nothing that is promised changes; before 1.0, any may."""
    whole = number.split(".")
    return whole[0] if whole[0] != "0" else ".".join(whole[:2])


def is_promised(archive: Path) -> bool:
    return archive.name == UNRELEASED or major(about(archive)["qdot"]) == major(find_qdot_version())


@archives
def test_an_archived_class_has_the_same_problems(archive: Path, tmp_path: Path) -> None:
    assignment = load_assignment(Path(shutil.copytree(archive, tmp_path / "class")))
    every = list(verify_all(list_tasks(assignment), 1))
    kinds = {failure.kind for _, failures in every for failure in failures} - {FailureKind.NO_NOTEBOOK}
    assert len({task.student for task, _ in every}) == 2
    if is_promised(archive):
        assert about(archive)["engine"] == ENGINE, ANEW
    assert kinds == (set() if about(archive)["engine"] == ENGINE else {FailureKind.OTHER_ENGINE}), ANEW


@archives
def test_an_archived_class_has_the_same_marks(archive: Path, tmp_path: Path) -> None:
    assignment = load_assignment(Path(shutil.copytree(archive, tmp_path / "class")))
    looked = find_submissions(assignment, assignment.folder / "submitted")
    results = grade_class(assignment, looked.by_student, 0, Limits())
    if archive.name == UNRELEASED or about(archive)["grader"] == GRADER_VERSION:
        assert find_mark_changes(read_previous_results(assignment), results) == [], ANEW


# --- names ---


def gone(old: Any, now: Any, place: str = "") -> list[str]:
    """Return which of the names that were promised are not there any more."""
    if isinstance(old, dict):
        return [name for key, value in old.items() for name in gone(value, now.get(key, []), f"{place} {key}")]
    return [f"{place.strip()}: {name}" for name in old if name not in now]


@archives
def test_every_promised_name_is_there(archive: Path) -> None:
    if is_promised(archive):
        assert gone(json.loads((archive / "interface.json").read_text(encoding="utf-8")), interface()) == [], ANEW


def test_a_name_that_goes_is_noticed() -> None:
    less = interface()
    less["commands"]["qdot show"].remove("--hints")
    less["export_formats"].remove("moodle")
    assert gone(interface(), less) == ["commands qdot show: --hints", "export_formats: moodle"]


# --- schemas ---

READS = ("type", "const", "enum", "pattern", "$ref", "prefixItems", "anyOf", "oneOf")
"""What of a schema tells a program what it will find."""


def broken(old: Any, now: Any, place: str) -> list[str]:
    """Return what a program that reads by the old schema would not find in what is written by the new one."""
    if not isinstance(old, dict) or not isinstance(now, dict):
        return [] if old == now else [place]
    found = [f"{place}.{name}" for name in old.get("properties", {}) if name not in now.get("properties", {})]
    found += [
        f"{place}.{name} may be missing" for name in old.get("required", []) if name not in now.get("required", [])
    ]
    found += [f"{place}: {key}" for key in READS if old.get(key) != now.get(key)]
    for key in ("properties", "$defs"):
        for name, inner in old.get(key, {}).items():
            if name in now.get(key, {}):
                found += broken(inner, now[key][name], f"{place}.{name}")
    return found + (broken(old["items"], now.get("items"), f"{place}[]") if "items" in old else [])


def schemas(folder: Path) -> dict[str, Any]:
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def less_than_promised(old: dict[str, Any], now: dict[str, Any]) -> list[str]:
    """Return what is broken of schemas that have the same version still."""
    lost = [name for name in old if name not in now]
    same = [name for name in old if name in now and old[name]["version"] == now[name]["version"]]
    return lost + [each for name in same for each in broken(old[name], now[name], name)]


def test_every_schema_has_an_id_and_a_version() -> None:
    for name, content in schemas(SCHEMAS).items():
        assert isinstance(content["version"], int)
        assert content["$id"] == f"urn:qdot:schema:{name}:{content['version']}"


@archives
def test_a_schema_that_takes_something_away_has_another_version(archive: Path) -> None:
    old, now = schemas(archive / "schemas"), schemas(SCHEMAS)
    assert less_than_promised(old, now) == [], "raise its version"
    if is_promised(archive):
        numbers = {name: content["version"] for name, content in old.items()}
        assert numbers == {name: now[name]["version"] for name in numbers}, ANEW


def test_what_a_schema_takes_away_is_noticed() -> None:
    now = schemas(SCHEMAS)
    less = copy.deepcopy(now)
    del less["result"]["properties"]["score"]
    less["result"]["required"].remove("late")
    less["result"]["properties"]["student"]["type"] = "integer"
    assert less_than_promised(now, less) == ["result.score", "result.late may be missing", "result.student: type"]
    less["result"]["version"] += 1
    assert less_than_promised(now, less) == []


def test_the_page_of_promises_is_up_to_date() -> None:
    page = (ROOT / "docs" / "compatibility.md").read_text(encoding="utf-8")
    assert page == compatibility_page(), "make docs"
    for name, content in schemas(SCHEMAS).items():
        assert f"| `{name}.json` | {content['version']} |" in page
