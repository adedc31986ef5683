"""Read the files of an assignment folder that a platform needs to grade, or to regenerate the problems."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import PurePath

from qdot.exercises.assignment.assignment import ASSIGNMENT_FILE, Assignment, split_question_name
from qdot.exercises.assignment.replacements import REPLACEMENTS_FILE
from qdot.exercises.common.input_file import format_toml, read_toml

OUTSIDE_FOLDER = "shared"
"""The folder of an export for copies of files outside the assignment folder; further folders have a number."""

_TOML_TOKEN = re.compile(
    r"#[^\n]*|\"{3}(?:[^\\]|\\.)*?\"{3,5}|'{3}.*?'{3,5}|(?P<text>\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*')", re.DOTALL
)
"""Matches a comment or a string in TOML; the group `text` is a string on a single line."""


def read_assignment_files(assignment: Assignment) -> dict[str, bytes]:
    """Map the path in the export of each file that grading needs, except the secret, to its content."""
    names = ["roster.csv", REPLACEMENTS_FILE, "overrides.csv"]
    tables = {name: path.read_bytes() for name in names if (path := assignment.folder / name).exists()}
    return read_problem_files(assignment) | tables


def read_problem_files(assignment: Assignment) -> dict[str, bytes]:
    """Map the path in the export of assignment.toml, and of each file that it names, to the file's content.

    The named files are robots, files of questions, and the logo. Robots of the library are not included, because qdot
    contains them. A file outside the assignment folder is copied, and the exported assignment.toml names the copy.
    """
    folder = assignment.folder
    path = folder / ASSIGNMENT_FILE
    paths = _choose_paths([name for name in _list_named_files(assignment) if (folder / name).is_file()])
    new_names = {name: path_in_export for name, path_in_export in paths.items() if _is_outside(name)}
    content = _rename_files(read_toml(path).text, new_names).encode() if new_names else path.read_bytes()
    return {ASSIGNMENT_FILE: content} | {
        path_in_export: (folder / name).read_bytes() for name, path_in_export in paths.items()
    }


def _list_named_files(assignment: Assignment) -> list[str]:
    """Return the names of files and robots in assignment.toml, without repetitions."""
    content = read_toml(assignment.folder / ASSIGNMENT_FILE).content
    question_lists = (entry.get("questions") for entry in content["problem"])
    questions = [name for names in question_lists if isinstance(names, list) for name in names]
    question_files = [file_name for file_name, _ in map(split_question_name, questions) if file_name]
    robots = [entry["robot"] for entry in content["problem"] if "robot" in entry]
    logo = content.get("paper", {}).get("logo")
    return list(dict.fromkeys([*robots, *question_files, *([logo] if logo else [])]))


def _is_outside(name: str) -> bool:
    return PurePath(name).is_absolute() or ".." in PurePath(name).parts


def _choose_paths(names: list[str]) -> dict[str, str]:
    """Map each file name in assignment.toml to the path in the export.

    Only folders change, because an arm is named after its file.
    """
    paths = {name: PurePath(name).as_posix() for name in names if not _is_outside(name)}
    for name in names:
        folder, number = OUTSIDE_FOLDER, 1
        while name not in paths:
            path = f"{folder}/{PurePath(name).name}"
            if path.casefold() not in map(str.casefold, paths.values()):
                paths[name] = path
            number += 1
            folder = f"{OUTSIDE_FOLDER}-{number}"
    return paths


def _rename_files(toml: str, new_names: Mapping[str, str]) -> str:
    """Return the text of a TOML file with the names of some files replaced.

    >>> print(_rename_files('questions = ["p", "../a.toml"]  # not "../a.toml"', {"../a.toml": "shared/a.toml"}))
    questions = ["p", "shared/a.toml"]  # not "../a.toml"
    """

    def rename(match: re.Match[str]) -> str:
        value = tomllib.loads(f"text = {match['text']}")["text"] if match["text"] else ""
        name, separator, question = (value, "", "") if value in new_names else value.partition("#")
        return format_toml(f"{new_names[name]}{separator}{question}") if name in new_names else match[0]

    return _TOML_TOKEN.sub(rename, toml)
