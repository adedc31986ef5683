"""The published JSON Schemas, and what qdot really writes held against them."""

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.site.bank import write_bank
from qdot.exercises.site.supply import QUIZ, BankProblem
from qdot.grader.grading.certify import find_failures
from tests.support import ROOT
from tests.support.command import run
from tests.support.submitting import make_class, make_correct_notebook, submit

SCHEMAS = ROOT / "docs" / "schemas"


def validator(name: str) -> Any:
    content = json.loads((SCHEMAS / f"{name}.json").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(content)
    return Draft202012Validator(content, format_checker=Draft202012Validator.FORMAT_CHECKER)


def errors(name: str, content: Any) -> list[str]:
    return [f"{error.json_path}: {error.message}" for error in validator(name).iter_errors(content)]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """A class in which everything happens that results tell of: right, wrong, late, set by a person, twice, nothing."""
    folder = tmp_path_factory.mktemp("class") / "hw"
    made = make_class(folder, [Student(name) for name in ("ada", "bo", "cy", "di")])
    toml = (folder / "assignment.toml").read_text()
    rule = 'due = 2020-01-01T00:00:00Z\nlate = {per_day = 0.01, at_most = 0.5}\nattempts = "best"\n[[problem]]'
    (folder / "assignment.toml").write_text(toml.replace("[[problem]]", rule))
    table = "student,part,points,comment,group\nbo,p1.jacobian,1,x,\nada,,3,,\n"
    (folder / "overrides.csv").write_text(table)
    submit(made, "ada/hw.ipynb", make_correct_notebook(made, "ada"))
    for name in ("hw", "other"):
        submit(
            made,
            f"bo/{name}.ipynb",
            make_correct_notebook(made, "bo", lambda cells: cells[-1].update(source="p1_determinant = a1")),
        )
    submit(made, "cy/hw.ipynb", "no notebook")
    run("grade", folder, "--jobs", "1")
    wrong = json.loads((folder / "graded" / "results.jsonl").read_text().splitlines()[1])["problems"][0]["parts"][2]
    (folder / "overrides.csv").write_text(f"{table},,,look again,{wrong['group']}\n")
    run("grade", folder, "--report", f"json={folder / 'results.json'}", "--jobs", "1")
    lines = [json.loads(line) for line in (folder / "graded" / "results.jsonl").read_text().splitlines()]
    assert json.loads((folder / "results.json").read_text()) == lines
    return lines


def test_results(results: list[dict[str, Any]]) -> None:
    assert errors("results", results) == []
    assert [errors("result", line) for line in results] == [[]] * 4
    told = [bool(results[0]["override"]), bool(results[1]["attempts"]), bool(results[1]["late"])]
    assert told == [True, True, True]
    explained = results[1]["problems"][0]["parts"][2]
    assert explained["override"] == {"points": None, "comment": "look again", "was": 0.0, "group": explained["group"]}
    for place, wrong in (("score", "4"), ("late", {}), ("problems", []), ("extra", 1)):
        changed = copy.deepcopy(results[0])
        changed[place] = wrong
        assert errors("result", changed)


def test_compare(results: list[dict[str, Any]]) -> None:
    given = [
        {"id": 1, "type": "expression", "reference": "a1*sin(theta1)", "student": student, "joints": ["theta1"]}
        for student in ("sin(theta1)*a1", "a1", "", "a1**(", "blank")
    ]
    out = run("compare", "--batch", "-", stdin="".join(json.dumps(line) + "\n" for line in given)).splitlines()
    assert [errors("compare", json.loads(line)) for line in out] == [[]] * 5
    assert errors("compare", {"id": 1, "outcome": "good", "reason": "", "certificate": None})


def test_doctor() -> None:
    content = json.loads(run("doctor", "--json"))
    assert errors("doctor", content) == []
    assert errors("doctor", {**content, "guarantees": []})


@pytest.mark.parametrize("problem", ["planar-2r/7", "scara/2"])
def test_problems(problem: str) -> None:
    asked = "position,jacobian,singular-angles,rank,singularity-type,lost-direction,joint-rates"
    content = json.loads(run("show", problem, "--questions", asked, "--format", "json", "--solution"))
    assert errors("show", content) == []
    assert errors("show", json.loads(run("show", problem, "--questions", "quiz", "--format", "json"))) == []
    assert errors("show", {**content, "parts": []})
    assert errors("show", {**content, "robot": {**content["robot"], "joints": [{"kind": "X"}]}})


@pytest.mark.whole
def test_solutions(tmp_path: Path) -> None:
    row = '[[joint]]\nkind = "R"\ntheta = "theta{i}"\nd = 0\na = "a{i}"\nalpha = 0\n'
    for joints, task in ((1, '["vx"]'), (2, '["vx", "vy"]'), (3, '["vx", "vy"]'), (2, '["wx", "wz"]')):
        arm = tmp_path / "arm.toml"
        arm.write_text(f'name = "x"\ntask = {task}\n' + "".join(row.format(i=i) for i in range(1, joints + 1)))
        content = json.loads(run("solve", arm, "--format", "json"))
        assert errors("solve", content) == []
        assert errors("solve", {**content, "jacobian": []})


def test_certificates(tmp_path: Path) -> None:
    made = make_class(tmp_path / "hw", [Student("ada")])
    run("generate", made.folder, "--jobs", "1")
    content = json.loads((made.folder / "certificates" / "ada" / "hw.json").read_text())
    assert errors("certificate", content) == []
    assert errors("certificate", {**content, "notebook": {}})


def test_problems_of_the_sites_bank(tmp_path: Path) -> None:
    asked = ("position", "singular-angles", "rank", "lost-direction", "joint-rates", "singularity-type")
    wanted = [BankProblem("planar-2r", "001", 1, asked), BankProblem("planar-2r", "001-quiz", 1, (QUIZ,))]
    for wish in write_bank(tmp_path, wanted, find_failures, 1, lambda: None, lambda _: None):
        content = json.loads((tmp_path / "bank" / "planar-2r" / f"{wish['key']}.json").read_text())
        assert errors("bank-problem", content) == []
        assert errors("bank-problem", {**content, "said": [["only one"]]})
