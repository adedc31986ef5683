"""SCORM packages: manifests satisfy the schemas, and the page contains its settings.

Chromium runs them in a SCORM run-time (site/e2e/course.test.mjs); tests/platforms import them into real platforms.
"""

import html
import io
import json
import re
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.exercises.common.errors import QdotError
from qdot.exercises.exports import scorm
from qdot.exercises.exports.bank import iterate_bank
from qdot.exercises.exports.export_format import ExportedFile, ExportRequest
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.site import pages
from qdot.grader.cli.main import app
from tests.exercises.exports.test_items import make_request
from tests.support import read_data
from tests.support.command import run, run_and_fail, runner
from tests.support.site_scripts import write_stand_in_assets

TOML = read_data("assignments/scorm.toml")


@pytest.fixture(scope="module")
def patched(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    assets = write_stand_in_assets(tmp_path_factory.mktemp("scripts") / "dist")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scorm, "find_assets", lambda: assets)
        yield


@pytest.fixture(scope="module")
def export_request(tmp_path_factory: pytest.TempPathFactory) -> ExportRequest:
    return make_request(tmp_path_factory.mktemp("scorm"), TOML, 2)


def export_packages(export_request: ExportRequest) -> dict[str, dict[str, bytes]]:
    files: list[ExportedFile] = list(EXPORT_FORMATS["scorm"].export(export_request))
    assert all(file.is_private for file in files)  # they contain the answers
    return {file.path.partition("-scorm")[2].removesuffix(".zip"): unzip(file.content) for file in files}


def unzip(content: str | bytes) -> dict[str, bytes]:
    assert isinstance(content, bytes)
    with zipfile.ZipFile(io.BytesIO(content)) as package:
        return {name: package.read(name) for name in package.namelist()}


@pytest.fixture(scope="module")
def packages(export_request: ExportRequest, patched: None) -> dict[str, dict[str, bytes]]:
    return export_packages(export_request)


CP12, CP2004 = "http://www.imsproject.org/xsd/imscp_rootv1p1p2", "http://www.imsglobal.org/xsd/imscp_v1p1"
ADL12, ADL2004 = "http://www.adlnet.org/xsd/adlcp_rootv1p2", "http://www.adlnet.org/xsd/adlcp_v1p3"
SEQUENCING = "http://www.imsglobal.org/xsd/imsss"
CHILDREN = {
    "manifest": ("metadata", "organizations", "resources"), "metadata": ("schema", "schemaversion"),
    "organizations": ("organization",), "organization": ("title", "item", "sequencing"),
    "item": ("title", "sequencing"), "sequencing": ("controlMode", "deliveryControls"), "resources": ("resource",),
    "resource": ("file",),
}  # fmt: skip
"""The used elements in the order of the schemas."""
REQUIRED = {
    "manifest": {"identifier"}, "organization": {"identifier"}, "item": {"identifier"}, "file": {"href"},
    "resource": {"identifier", "type"},
}  # fmt: skip
NCNAME = r"[A-Za-z_][\w.-]*"


@pytest.mark.parametrize("version", ["12", "2004"])
def test_manifest_is_valid_and_lists_every_file(packages: dict[str, dict[str, bytes]], version: str) -> None:
    package = packages[version]
    root = ElementTree.fromstring(package["imsmanifest.xml"])
    namespace, adl = (CP12, ADL12) if version == "12" else (CP2004, ADL2004)
    for element in root.iter():
        space, _, name = element.tag[1:].partition("}")
        assert space == (SEQUENCING if name in ("sequencing", "controlMode", "deliveryControls") else namespace)
        positions = [CHILDREN[name].index(child.tag.rpartition("}")[2]) for child in element]
        assert positions == sorted(positions)
        assert set(element.attrib) >= REQUIRED.get(name, set())
    names = [element.attrib["identifier"] for element in root.iter() if "identifier" in element.attrib]
    assert len(set(names)) == len(names) and all(re.fullmatch(NCNAME, name) for name in names)
    item, resource = (next(root.iter(f"{{{namespace}}}{name}")) for name in ("item", "resource"))
    organizations = next(root.iter(f"{{{namespace}}}organizations"))
    assert item.attrib["identifierref"] == resource.attrib["identifier"]
    assert organizations.attrib["default"] == organizations[0].attrib["identifier"]
    assert resource.attrib["href"] == "index.html"
    assert resource.attrib[f"{{{adl}}}{'scormtype' if version == '12' else 'scormType'}"] == "sco"
    assert next(root.iter(f"{{{namespace}}}title")).text == "Arms & <signs>"
    expected = {"12": ("ADL SCORM", "1.2"), "2004": ("ADL SCORM", "2004 4th Edition")}
    assert tuple(each.text for each in root[0]) == expected[version]
    listed = [file.attrib["href"] for file in root.iter(f"{{{namespace}}}file")]
    assert sorted([*listed, "imsmanifest.xml"]) == sorted(package)


def read_settings(package: dict[str, bytes]) -> dict[str, Any]:
    match = re.search(r'data-set="([^"]*)"', package["index.html"].decode())
    assert match is not None
    return dict(json.loads(html.unescape(match[1])))


def test_page_contains_its_questions_with_points_and_credit(packages: dict[str, dict[str, bytes]]) -> None:
    assert read_settings(packages["12"]) == {
        "scorm": "1.2", "key": "hw-1.a", "title": "Arms & <signs>", "tries": 3, "pass": None,
        "places": [
            {"name": "p1", "questions": [["determinant", 3.0, 0.0], ["joint-effect", 0.5, 1.0]]},
            {"name": "p2", "questions": [["position", 1.0, 0.5]]},
        ],
    }  # fmt: skip
    assert read_settings(packages["2004"]) == read_settings(packages["12"]) | {"scorm": "2004"}
    page = packages["12"]["index.html"].decode()
    assert "default-src 'none'; script-src 'self';" in page
    assert "<title>Arms &amp; &lt;signs&gt;</title>" in page
    names = re.findall(r'(?:src|href)="([^"]+)"', page)
    assert names and set(names) <= set(packages["12"])


def test_package_has_all_variants_and_no_seed_or_secret(
    export_request: ExportRequest, packages: dict[str, dict[str, bytes]]
) -> None:
    variants = list(iterate_bank(export_request))
    package = packages["2004"]
    index = json.loads(package["bank/index.json"])
    assert {problem["key"] for family in index["families"] for problem in family["problems"]} == {
        variant.key for variant in variants
    }
    assert index["feedback"] == "solutions"
    for variant in variants:
        stem = f"bank/{variant.slot.name}/{variant.key}"
        assert json.loads(package[f"{stem}.json"])["id"] == variant.key
        parts = [json.loads(package[f"{stem}/{kind}.json"]) for kind in variant.slot.questions]
        assert [part["points"] for part in parts] == list(variant.slot.max_points)
        assert not any(part["hints"] for part in parts)  # the assignment has hints off
        assert all(part["solved"]["typed"] for part in parts)
        assert all(f"{stem}{ending}" in package for ending in (".de.json", f"/{parts[0]['kind']}.de.json"))
    for name, content in package.items():
        assert export_request.assignment.secret.encode() not in content, name
        assert not [variant for variant in variants if str(variant.problem.id.seed).encode() in content], name
        assert b"made_from" not in content, name


def test_package_keeps_attempts_hints_and_passing_share(export_request: ExportRequest, patched: None) -> None:
    policy = AttemptPolicy(best_of=5)
    assignment = replace(
        export_request.assignment, attempt_policy=policy, hints=True, feedback="mistake", title="x" * 300
    )
    request = replace(export_request, assignment=assignment, variant_count=1)
    package = export_packages(replace(request, passing_share=Fraction(2, 5)))["12"]
    titles = ElementTree.fromstring(package["imsmanifest.xml"]).iter(f"{{{CP12}}}title")
    assert {len(str(title.text)) for title in titles} == {200}  # the schema takes no more
    assert (read_settings(package)["tries"], read_settings(package)["pass"]) == (5, 0.4)
    assert json.loads(package["bank/index.json"])["feedback"] == "mistake"
    assert not [name for name, content in package.items() if name.startswith("bank/") and b'"solved"' in content]
    assert not any(b'"factors"' in content for content in package.values())
    question = next(name for name in package if name.startswith("bank/p1/p1-001/") and not name.endswith(".de.json"))
    assert json.loads(package[question])["hints"]
    solved = export_packages(replace(request, has_solutions=True))["12"]
    assert json.loads(solved[question])["solved"]["typed"]


def test_rules_that_a_browser_cannot_apply_are_noted(
    export_request: ExportRequest, patched: None, tmp_path: Path
) -> None:
    toml = TOML.replace('"whole"', '"factors"').replace("credit = {position = 0.5}", "decimals = {position = 3}")
    notes: list[str] = []
    request = make_request(tmp_path, toml, 1)
    export_packages(replace(request, report=notes.append))
    assert [note.partition(":")[0] for note in notes] == ["p1", "p2"]
    assert "partial credit for determinant" in notes[0] and "decimals" in notes[1] and "position" in notes[1]


def test_too_many_questions_are_refused_before_writing(export_request: ExportRequest) -> None:
    slot = replace(export_request.assignment.slots[0], questions=("determinant",) * 1001)
    assignment = replace(export_request.assignment, slots=(slot,))
    with pytest.raises(QdotError, match=r"assignment\.toml: .* 1001 .* 1000"):
        EXPORT_FORMATS["scorm"].check(replace(export_request, assignment=assignment))


def test_export_command_writes_packages_and_needs_site_scripts(
    export_request: ExportRequest, patched: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = export_request.assignment.folder
    command = ("export", folder, "--to", "scorm", "--variants", "1", "--jobs", "1", "--pass", "60")
    assert "scorm: 2 files in" in run(*command)
    written = folder / "exports" / "scorm"
    assert sorted(path.name for path in written.iterdir()) == ["hw-1.a-scorm12.zip", "hw-1.a-scorm2004.zip"]
    assert read_settings(unzip((written / "hw-1.a-scorm12.zip").read_bytes()))["pass"] == 0.6
    assert runner.invoke(app, ["export", str(folder), "--to", "scorm", "--pass", "101"]).exit_code == 2
    monkeypatch.setattr(pages, "find_folder", lambda *_: None)
    monkeypatch.setattr(scorm, "find_assets", pages.find_assets)
    assert "the site's scripts, which pages and SCORM packages need, are not there" in run_and_fail(*command)
