"""The published JSON Schemas are valid, and qdot's output conforms to them."""

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from qdot.exercises.assignment.assignment import Student
from qdot.exercises.site.bank import write_bank
from qdot.exercises.site.bank_problem import QUIZ, BankProblem
from qdot.grader.grading.certify import find_failures
from tests.support import ROOT
from tests.support.command import run
from tests.support.submitting import make_class, make_correct_notebook, submit


def find_schema_errors(name: str, content: Any) -> list[str]:
    schema = json.loads((ROOT / "docs" / "schemas" / f"{name}.json").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema, format_checker=Draft202012Validator.FORMAT_CHECKER)
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(content)]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, Any]]:
    """Return the results of a class with right, wrong, late, overridden, repeated and missing work."""
    folder = tmp_path_factory.mktemp("class") / "hw"
    assignment = make_class(folder, [Student(name) for name in ("ada", "bo", "cy", "di")])
    toml = (folder / "assignment.toml").read_text()
    rule = 'due = 2020-01-01T00:00:00Z\nlate = {per_day = 0.01, at_most = 0.5}\nattempts = "best"\n[[problem]]'
    (folder / "assignment.toml").write_text(toml.replace("[[problem]]", rule))
    table = "student,part,points,comment,group\nbo,p1.jacobian,1,x,\nada,,3,,\n"
    (folder / "overrides.csv").write_text(table)
    submit(assignment, "ada/hw.ipynb", make_correct_notebook(assignment, "ada"))
    wrong = make_correct_notebook(assignment, "bo", lambda cells: cells[-1].update(source="p1_determinant = a1"))
    for name in ("hw", "other"):
        submit(assignment, f"bo/{name}.ipynb", wrong)
    submit(assignment, "cy/hw.ipynb", "no notebook")
    run("grade", folder, "--jobs", "1")
    result = json.loads((folder / "graded" / "results.jsonl").read_text().splitlines()[1])
    group = result["problems"][0]["parts"][2]["group"]
    (folder / "overrides.csv").write_text(f"{table},,,look again,{group}\n")
    run("grade", folder, "--report", f"json={folder / 'results.json'}", "--jobs", "1")
    lines = [json.loads(line) for line in (folder / "graded" / "results.jsonl").read_text().splitlines()]
    assert json.loads((folder / "results.json").read_text()) == lines
    return lines


def test_results_conform(results: list[dict[str, Any]]) -> None:
    assert find_schema_errors("results", results) == []
    assert [find_schema_errors("result", line) for line in results] == [[]] * 4
    is_recorded = [bool(results[0]["override"]), bool(results[1]["attempts"]), bool(results[1]["late"])]
    assert is_recorded == [True, True, True]
    explained = results[1]["problems"][0]["parts"][2]
    assert explained["override"] == {"points": None, "comment": "look again", "was": 0.0, "group": explained["group"]}
    for key, invalid in (("score", "4"), ("late", {}), ("problems", []), ("extra", 1)):
        changed = copy.deepcopy(results[0])
        changed[key] = invalid
        assert find_schema_errors("result", changed)


def test_compare_conforms(results: list[dict[str, Any]]) -> None:
    requests = [
        {"id": 1, "type": "expression", "reference": "a1*sin(theta1)", "student": student, "joints": ["theta1"]}
        for student in ("sin(theta1)*a1", "a1", "", "a1**(", "blank")
    ]
    lines = run("compare", "--batch", "-", stdin="".join(json.dumps(line) + "\n" for line in requests)).splitlines()
    assert [find_schema_errors("compare", json.loads(line)) for line in lines] == [[]] * 5
    assert find_schema_errors("compare", {"id": 1, "outcome": "good", "reason": "", "certificate": None})


def test_doctor_conforms() -> None:
    content = json.loads(run("doctor", "--json"))
    assert find_schema_errors("doctor", content) == []
    assert find_schema_errors("doctor", {**content, "guarantees": []})


@pytest.mark.parametrize("problem", ["planar-2r/7", "scara/2"])
def test_shown_problems_conform(problem: str) -> None:
    questions = "position,jacobian,singular-angles,rank,singularity-type,lost-direction,joint-rates"
    content = json.loads(run("show", problem, "--questions", questions, "--format", "json", "--solution"))
    assert find_schema_errors("show", content) == []
    assert find_schema_errors("show", json.loads(run("show", problem, "--questions", "quiz", "--format", "json"))) == []
    assert find_schema_errors("show", {**content, "parts": []})
    assert find_schema_errors("show", {**content, "robot": {**content["robot"], "joints": [{"kind": "X"}]}})


@pytest.mark.whole
def test_solutions_conform(tmp_path: Path) -> None:
    row = '[[joint]]\nkind = "R"\ntheta = "theta{i}"\nd = 0\na = "a{i}"\nalpha = 0\n'
    for joints, task in ((1, '["vx"]'), (2, '["vx", "vy"]'), (3, '["vx", "vy"]'), (2, '["wx", "wz"]')):
        arm = tmp_path / "arm.toml"
        arm.write_text(f'name = "x"\ntask = {task}\n' + "".join(row.format(i=i) for i in range(1, joints + 1)))
        content = json.loads(run("solve", arm, "--format", "json"))
        assert find_schema_errors("solve", content) == []
        assert find_schema_errors("solve", {**content, "jacobian": []})


def test_certificates_conform(tmp_path: Path) -> None:
    assignment = make_class(tmp_path / "hw", [Student("ada")])
    run("generate", assignment.folder, "--jobs", "1")
    content = json.loads((assignment.folder / "certificates" / "ada" / "hw.json").read_text())
    assert find_schema_errors("certificate", content) == []
    assert find_schema_errors("certificate", {**content, "notebook": {}})


def test_problems_of_the_sites_bank_conform(tmp_path: Path) -> None:
    questions = ("position", "singular-angles", "rank", "lost-direction", "joint-rates", "singularity-type")
    bank_problems = [BankProblem("planar-2r", "001", 1, questions), BankProblem("planar-2r", "001-quiz", 1, (QUIZ,))]
    for problem in write_bank(tmp_path, bank_problems, find_failures, 1, lambda: None, lambda _: None):
        path = tmp_path / "bank" / "planar-2r" / f"{problem['key']}.json"
        assert find_schema_errors("bank-problem", json.loads(path.read_text())) == []
        for name in problem["questions"]:
            content = json.loads((path.with_suffix("") / f"{name}.json").read_text())
            assert find_schema_errors("bank-question", content) == []
            assert find_schema_errors("bank-question", {**content, "said": {"0": ["only one"]}})
