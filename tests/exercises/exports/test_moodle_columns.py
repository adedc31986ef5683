"""Moodle XML of every format that writes it fits the database columns of Moodle and STACK.

On PostgreSQL a text that is too long for its column aborts the import.
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
    export_request = ExportRequest(load_assignment(folder), lambda _: [], variant_count=1)
    file, *_ = EXPORT_FORMATS[request.param].export(export_request)
    return ET.fromstring(file.content)


def list_questions(quiz: ET.Element) -> Iterator[tuple[ET.Element, str]]:
    yield from ((question, kind) for question in quiz if (kind := question.get("type", "")) != "category")


def test_texts_fit_their_columns(quiz: ET.Element) -> None:
    too_long = [
        (kind, path, text)
        for question, kind in list_questions(quiz)
        for path, most in {**DATA["columns"]["*"], **DATA["columns"].get(kind, {})}.items()
        for element in question.findall(path)
        if len(text := element.text or "") > most
    ]
    assert too_long == []


def test_category_names_are_valid_and_short_enough(quiz: ET.Element) -> None:
    paths = [text for element in quiz.findall("question/category/text") if (text := element.text)]
    names = [name.replace("//", "/") for path in paths for name in re.split(r"(?<!/)/(?!/)", path)]
    assert paths and max(map(len, names)) <= DATA["category"]
    assert all(name and "<" not in name and ">" not in name and name == name.strip() for name in names)
    assert len(set(paths)) == len(paths)


def test_required_columns_are_filled_and_unique_ones_unique(quiz: ET.Element) -> None:
    ids = [question.findtext("idnumber") for question, _ in list_questions(quiz)]
    assert len(set(ids)) == len(ids)
    for question, kind in list_questions(quiz):
        for path in DATA["filled"]["*"] + DATA["filled"].get(kind, []):
            texts = [element.text for element in question.findall(path)]
            assert texts and all(text and text.strip() for text in texts), (kind, path)
        for path in DATA["unique"].get(kind, []):
            texts = [element.text for element in question.findall(path)]
            assert len(set(texts)) == len(texts), path
        name = question.findtext("name/text", "")
        assert "<" not in name and ">" not in name  # Moodle would read them as a tag
        if kind != "cloze":  # a column of twelve digits, seven after the point
            assert re.fullmatch(r"\d{1,5}(\.\d{1,7})?", question.findtext("defaultgrade", "")), kind
