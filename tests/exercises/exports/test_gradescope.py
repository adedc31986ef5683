"""Gradescope's autograder, unpacked in Gradescope's folders, set up and run by its own two scripts."""

import json
import stat
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.grader.grading.result import MarkingVersions
from qdot.grader.integrations.gradescope import apply_attempt_policy, find_due_date, main, make_results
from qdot.grader.reports.gradescope import GradescopeResults, StaffData
from tests.support.ci import Machine, write_json
from tests.support.command import run
from tests.support.submitting import TOML, Cells, code_cell, make_class, make_correct_notebook

SECRET = "0123456789abcdef"
ADA = {"id": 7, "email": "ada@x.org", "name": "Ada Lovelace"}


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("course") / "hw"
    course = make_class(folder, [Student("ada", "Ada Lovelace", "ada@x.org"), Student("bo", "Bo B", "bo@x.org")])
    late = "due = 2027-01-10T00:00:00Z\nlate = {per_day = 0.1}\n[[problem]]"
    (folder / "assignment.toml").write_text(TOML.replace("[[problem]]", late))
    run("export", folder, "--to", "gradescope", "--jobs", "1")
    return load_assignment(course.folder)


def lay_out_submission(assignment: Assignment, root: Path, notebook: str, /, **metadata: Any) -> Path:
    with zipfile.ZipFile(assignment.folder / "exports" / "gradescope" / "autograder.zip") as archive:
        for about in archive.infolist():
            path = Path(archive.extract(about, root / "source"))
            path.chmod(about.external_attr >> 16)
    for folder in ("submission", "results"):
        (root / folder).mkdir()
    (root / "submission" / "my work.ipynb").write_text(notebook)
    content = {"created_at": "2027-01-09T12:00:00.000000-08:00", "users": [ADA], "previous_submissions": [], **metadata}
    write_json(root / "submission_metadata.json", content)
    return root


@pytest.fixture(scope="module")
def autograder(
    assignment: Assignment, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Machine, Path, dict[str, str]]:
    """A machine after Gradescope's setup, the folder with the submission, and its environment variables.

    The notebook tries to read the secret, fails, and loses the parts after that.
    """
    place = tmp_path_factory.mktemp("gradescope")

    def spy(cells: Cells) -> None:
        cells.insert(1, code_cell(f"stolen = open({str(place / 'source/assignment/secret.txt')!r}).read()"))
        cells[-1]["source"] = "p1_determinant = stolen"

    root = lay_out_submission(assignment, place, make_correct_notebook(assignment, "ada", spy))
    machine = Machine(place / "machine")
    environment = {"AUTOGRADER": str(root), "QDOT_HOME": str(place / "opt")}
    setup = (root / "source" / "setup.sh").read_text()
    setup = setup.replace('"$home/python/bin/qdot" doctor\n', "")  # needs libraries that are lent afterwards
    process = subprocess.run(
        ["bash"], input=setup, env={**machine.variables, **environment}, capture_output=True, text=True
    )
    assert process.returncode == 0, process.stderr
    machine.home = place / "opt"
    machine.lend()
    return machine, root, environment


@pytest.mark.integration
def test_autograder_sets_up_and_runs_with_its_own_scripts(autograder: tuple[Machine, Path, dict[str, str]]) -> None:
    machine, root, environment = autograder
    assert stat.S_IMODE((root / "source" / "assignment").stat().st_mode) == 0o700
    process = machine.run(str(root / "source" / "run_autograder"), root, **environment)
    assert process.returncode == 0, process.stderr
    text = (root / "results" / "results.json").read_text()
    assert SECRET not in text
    content = json.loads(text)
    assert content["score"] == 3
    assert [(test["number"], test["score"], test["max_score"], test["status"]) for test in content["tests"]] == [
        ("p1.position", 1, 1, "passed"), ("p1.jacobian", 2, 2, "passed"), ("p1.determinant", 0, 1, "failed"),
    ]  # fmt: skip
    assert {test["visibility"] for test in content["tests"]} == {"visible"}
    assert content["stdout_visibility"] == "hidden"


def test_lateness_uses_gradescopes_clock_and_extension(assignment: Assignment, tmp_path: Path) -> None:
    extended = {**ADA, "assignment": {"due_date": "2027-01-12T00:00:00Z"}}
    general = {"due_date": "2027-01-10T00:00:00Z"}
    late = {"created_at": "2027-01-12T10:00:00-00:00", "assignment": general}
    root = lay_out_submission(assignment, tmp_path / "a", make_correct_notebook(assignment, "ada"), users=[ADA], **late)
    results = make_results(root, "after_due_date")
    assert results.score == pytest.approx(4 * 0.7)  # three days begun since the 10th
    assert "30 % of your 4 points" in results.output
    assert {test.visibility for test in results.tests} == {"after_due_date"}
    write_json(root / "submission_metadata.json", {"users": [extended], **late})
    assert make_results(root).score == pytest.approx(4 * 0.9)
    assert find_due_date({"users": [ADA]}) is find_due_date({"assignment": {"due_date": "not a time"}}) is None


def test_unknown_student_gets_no_mark_and_group_gets_the_owners_mark(
    assignment: Assignment, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stranger = {"id": 8, "email": "eve@x.org", "name": "Eve"}
    root = lay_out_submission(assignment, tmp_path, make_correct_notebook(assignment, "bo"), users=[stranger])
    (root / "results" / "results.json").write_text("{}")
    assert main([str(root)]) == 2
    assert not (root / "results" / "results.json").exists()  # Gradescope says that there is no mark
    assert "eve@x.org" in capsys.readouterr().err
    users = [ADA, {"id": 9, "email": "BO@x.org", "name": "Bo B"}]  # in a group, the notebook's owner
    write_json(root / "submission_metadata.json", {"created_at": "2027-01-01T00:00:00Z", "users": users})
    assert main([str(root)]) == 0
    content = json.loads((root / "results" / "results.json").read_text())
    assert (content["extra_data"]["student"], content["score"]) == ("bo", 4)


def test_best_attempt_counts_up_to_the_limit() -> None:
    def best(results: GradescopeResults, most: int, earlier: list[Any], **metadata: str) -> GradescopeResults:
        return apply_attempt_policy(results, {"previous_submissions": earlier, **metadata}, AttemptPolicy(most))

    for_staff = StaffData("ada", "hw", MarkingVersions(), None, ())
    two, hour = GradescopeResults(2.0, "", "text", "visible", "hidden", (), for_staff), "2027-01-09T{:02}:00:00Z"
    earlier: list[Any] = [{"score": "3.5"}, {"score": 4.0, "autograder_error": True}, {"score": None}]
    assert best(two, 5, earlier).score == 3.5
    assert best(two, 5, [{"score": 1}]) is two
    four = replace(two, score=4.0)
    earlier = [{"score": k / 2, "submission_time": hour.format(k)} for k in range(1, 6)]
    sixth = best(four, 5, earlier, created_at=hour.format(9))
    assert sixth.score == 2.5 and "5 attempts" in sixth.output
    assert best(four, 6, earlier, created_at=hour.format(9)) is four
    assert best(four, 5, earlier, created_at="2027-01-09T05:03:00Z") is four  # instead of the fifth


def test_secret_is_only_in_the_private_zip(assignment: Assignment) -> None:
    folder = assignment.folder / "exports" / "gradescope"
    assert stat.S_IMODE((folder / "autograder.zip").stat().st_mode) == 0o600
    with zipfile.ZipFile(folder / "autograder.zip") as archive:
        assert archive.read("assignment/secret.txt").decode().strip() == SECRET
        assert {"setup.sh", "run_autograder"} <= {name for name in archive.namelist() if "/" not in name}
    assert not [p for p in folder.rglob("*") if p.suffix != ".zip" and p.is_file() and SECRET in p.read_text()]
