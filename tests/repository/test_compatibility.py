"""Classes released by earlier versions, and the names that these promised, still work with this version.

`python -m tests.tools.archive VERSION` writes the archive of a release, which never changes; without a version, it
writes the archive of the unreleased state.
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
from qdot.grader.grading.attempt import GRADER_VERSION
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.certificates import FailureKind
from qdot.grader.grading.certify import list_tasks, verify_all
from qdot.grader.grading.history import find_mark_changes, read_previous_results
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions
from tests.tools.archive import ARCHIVES, SCHEMAS, UNRELEASED, list_public_names

ALL_ARCHIVES = sorted(path for path in ARCHIVES.iterdir())
archives = pytest.mark.parametrize("archive", ALL_ARCHIVES, ids=lambda path: path.name)
REWRITE_HINT = "python -m tests.tools.archive rewrites the unreleased archive; released archives are promises"


def read_about(archive: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((archive / "about.json").read_text(encoding="utf-8"))
    return content


def major_version(number: str) -> str:
    """Return the part of a version within which promises hold: the major number, or 0.MINOR before 1.0."""
    numbers = number.split(".")
    return numbers[0] if numbers[0] != "0" else ".".join(numbers[:2])


def is_promised(archive: Path) -> bool:
    archived, current = read_about(archive)["qdot"], find_qdot_version()
    return archive.name == UNRELEASED or major_version(archived) == major_version(current)


@archives
def test_an_archived_class_has_the_same_problems(archive: Path, tmp_path: Path) -> None:
    assignment = load_assignment(Path(shutil.copytree(archive, tmp_path / "class")))
    verified = list(verify_all(list_tasks(assignment), 1))
    kinds = {failure.kind for _, failures in verified for failure in failures} - {FailureKind.NO_NOTEBOOK}
    assert len({task.student for task, _ in verified}) == 2
    if is_promised(archive):
        assert read_about(archive)["engine"] == ENGINE, REWRITE_HINT
    assert kinds == (set() if read_about(archive)["engine"] == ENGINE else {FailureKind.OTHER_ENGINE}), REWRITE_HINT


@archives
def test_an_archived_class_has_the_same_marks(archive: Path, tmp_path: Path) -> None:
    assignment = load_assignment(Path(shutil.copytree(archive, tmp_path / "class")))
    submissions = find_submissions(assignment, assignment.folder / "submitted")
    results = grade_class(assignment, submissions.by_student, 0, Limits())
    if archive.name == UNRELEASED or read_about(archive)["grader"] == GRADER_VERSION:
        assert find_mark_changes(read_previous_results(assignment), results) == [], REWRITE_HINT


def find_missing_names(old: Any, new: Any, path: str = "") -> list[str]:
    if isinstance(old, dict):
        return [
            name for key, value in old.items() for name in find_missing_names(value, new.get(key, []), f"{path} {key}")
        ]
    return [f"{path.strip()}: {name}" for name in old if name not in new]


@archives
def test_every_promised_name_exists(archive: Path) -> None:
    if is_promised(archive):
        promised = json.loads((archive / "interface.json").read_text(encoding="utf-8"))
        assert find_missing_names(promised, list_public_names()) == [], REWRITE_HINT


def test_a_missing_name_is_found() -> None:
    reduced = list_public_names()
    reduced["commands"]["qdot show"].remove("--hints")
    reduced["export_formats"].remove("moodle")
    assert find_missing_names(list_public_names(), reduced) == ["commands qdot show: --hints", "export_formats: moodle"]


CONTRACT_KEYS = ("type", "const", "enum", "pattern", "$ref", "prefixItems", "anyOf", "oneOf")
"""The keys of a schema that tell a program what it will find."""


def find_breaking_changes(old: Any, new: Any, path: str) -> list[str]:
    """Return what a reader of the old schema would miss in data of the new one."""
    if not isinstance(old, dict) or not isinstance(new, dict):
        return [] if old == new else [path]
    changes = [f"{path}.{name}" for name in old.get("properties", {}) if name not in new.get("properties", {})]
    optional = [name for name in old.get("required", []) if name not in new.get("required", [])]
    changes += [f"{path}.{name} may be missing" for name in optional]
    changes += [f"{path}: {key}" for key in CONTRACT_KEYS if old.get(key) != new.get(key)]
    for key in ("properties", "$defs"):
        for name, inner in old.get(key, {}).items():
            if name in new.get(key, {}):
                changes += find_breaking_changes(inner, new[key][name], f"{path}.{name}")
    return changes + (find_breaking_changes(old["items"], new.get("items"), f"{path}[]") if "items" in old else [])


def read_schemas(folder: Path) -> dict[str, Any]:
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def find_unversioned_changes(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """Return the breaking changes of schemas whose version is unchanged."""
    missing = [name for name in old if name not in new]
    same = [name for name in old if name in new and old[name]["version"] == new[name]["version"]]
    return missing + [change for name in same for change in find_breaking_changes(old[name], new[name], name)]


def test_every_schema_has_an_id_and_a_version() -> None:
    for name, content in read_schemas(SCHEMAS).items():
        assert isinstance(content["version"], int)
        assert content["$id"] == f"urn:qdot:schema:{name}:{content['version']}"


@archives
def test_a_breaking_change_of_a_schema_has_a_new_version(archive: Path) -> None:
    old, new = read_schemas(archive / "schemas"), read_schemas(SCHEMAS)
    assert find_unversioned_changes(old, new) == [], "raise its version"
    if is_promised(archive):
        numbers = {name: content["version"] for name, content in old.items()}
        assert numbers == {name: new[name]["version"] for name in numbers}, REWRITE_HINT


def test_breaking_changes_of_schemas_are_found() -> None:
    current = read_schemas(SCHEMAS)
    reduced = copy.deepcopy(current)
    del reduced["result"]["properties"]["score"]
    reduced["result"]["required"].remove("late")
    reduced["result"]["properties"]["student"]["type"] = "integer"
    changes = ["result.score", "result.late may be missing", "result.student: type"]
    assert find_unversioned_changes(current, reduced) == changes
    reduced["result"]["version"] += 1
    assert find_unversioned_changes(current, reduced) == []
