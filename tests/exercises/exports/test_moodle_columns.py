"""Moodle XML of every format that writes it, checked against the columns of the tables of Moodle and STACK.

What is too long for its column ends an import on PostgreSQL, with everything behind it.
"""

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Student, load_assignment
from qdot.exercises.exports.export_format import ExportRequest
from qdot.exercises.exports.registry import EXPORT_FORMATS
from tests.support.submitting import make_class

DATA = json.loads((Path(__file__).parents[2] / "data" / "moodle_columns.json").read_text())
TITLE = f"Arms & <signs> / {'velocity ' * 40}"
TOML = f"""title = "{TITLE}"
key = "{"long-key-" * 10}"
hints = true
[[problem]]
family = "planar-2r"
questions = ["position", "jacobian", "inverse-velocity", "singular-angles", "joint-rates"]
[[problem]]
family = "elbow-3r"
questions = ["jacobian", "determinant", "rank"]
[[problem]]
family = "polar-rp"
questions = ["match-columns", "singular-drawing", "dependence"]
"""


@pytest.fixture(scope="module", params=["moodle", "stack"])
def quiz(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> ET.Element:
    folder = tmp_path_factory.mktemp("columns") / "hw"
    make_class(folder, [Student("ada")])
    (folder / "assignment.toml").write_text(TOML)
    file, *_ = EXPORT_FORMATS[request.param].export(
        ExportRequest(load_assignment(folder), lambda _: [], variant_count=1)
    )
    return ET.fromstring(file.content)


def questions(quiz: ET.Element) -> Iterator[tuple[ET.Element, str]]:
    """Yield questions, and their types."""
    yield from ((one, kind) for one in quiz if (kind := one.get("type", "")) != "category")


def test_texts_are_not_longer_than_their_columns(quiz: ET.Element) -> None:
    too_long = [
        (kind, path, text)
        for question, kind in questions(quiz)
        for path, most in {**DATA["columns"]["*"], **DATA["columns"].get(kind, {})}.items()
        for element in question.findall(path)
        if len(text := element.text or "") > most
    ]
    assert too_long == []


def test_names_of_categories_are_short_enough_and_whole(quiz: ET.Element) -> None:
    paths = [text for element in quiz.findall("question/category/text") if (text := element.text)]
    names = [name.replace("//", "/") for path in paths for name in re.split(r"(?<!/)/(?!/)", path)]
    assert paths and max(map(len, names)) <= DATA["category"]
    assert all(name and "<" not in name and ">" not in name and name == name.strip() for name in names)
    assert len(set(paths)) == len(paths)


def test_what_must_be_filled_is_and_what_must_be_unique_is(quiz: ET.Element) -> None:
    ids = [question.findtext("idnumber") for question, _ in questions(quiz)]
    assert len(set(ids)) == len(ids)
    for question, kind in questions(quiz):
        for path in DATA["filled"]["*"] + DATA["filled"].get(kind, []):
            found = [element.text for element in question.findall(path)]
            assert found and all(text and text.strip() for text in found), (kind, path)
        for path in DATA["unique"].get(kind, []):
            found = [element.text for element in question.findall(path)]
            assert len(set(found)) == len(found), path
        name = question.findtext("name/text", "")
        assert "<" not in name and ">" not in name  # Moodle takes them for a tag
        if kind != "cloze":  # of its numbers' twelve digits seven are behind the point
            assert re.fullmatch(r"\d{1,5}(\.\d{1,7})?", question.findtext("defaultgrade", "")), kind
