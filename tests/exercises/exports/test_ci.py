"""Repositories for GitHub and GitLab: fresh clones, graded by the very commands of the exported workflows."""

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from exercises.assignment import Assignment, Student
from exercises.errors import QdotError
from exercises.exports.outlet import Order
from exercises.exports.repositories import assignment_files
from exercises.exports.wheel import versions, wheel
from grader.certify import failures_of
from tests.support.ci import Machine, git, github_steps, hosted, read_yaml, write_json
from tests.support.command import fails, run
from tests.support.handing_in import Cells, a_class, right

pytestmark = pytest.mark.xdist_group("ci")

PUSHED = "2027-01-15T22:00:00Z"
SECRET = "0123456789abcdef"
CHECKS = {"github": "vendor.github-workflows", "gitlab": "vendor.gitlab-ci"}


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("course") / "hw"
    made = a_class(folder, [Student("ada", "Ada"), Student("bo"), Student("cy")])
    run("export", folder, "--to", "github", "--to", "gitlab", "--jobs", "1")
    return made


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    return Machine(tmp_path_factory.mktemp("machine"))


def exported(assignment: Assignment, platform: str) -> Path:
    return assignment.folder / "exports" / platform


def half_right(cells: Cells) -> None:
    cells[-1]["source"] = "p1_determinant = 0"


def pushed(assignment: Assignment, platform: str, place: Path, *students: str) -> Path:
    """Have students push their answers, Bo's with a mistake, and return the server."""
    server = place / "server"
    for student in students:
        text = right(assignment, student, half_right if student == "bo" else lambda _: None)
        folder = place / student
        shutil.copytree(exported(assignment, platform) / "students" / student, folder)
        (folder / "hw.ipynb").write_text(text, encoding="utf-8")
        (folder / "pip.py").write_text("raise SystemExit('a student module was run')\n", encoding="utf-8")
        hosted(folder, server, f"course/hw-{student}")
    return server


def results(clone: Path) -> dict[str, dict[str, object]]:
    lines = (clone / "graded" / "results.jsonl").read_text(encoding="utf-8").splitlines()
    return {result["student"]: result for result in map(json.loads, lines)}


@dataclass(frozen=True)
class OnGitHub:
    """The repository that grades, cloned on a machine of GitHub, beside the server with the students' repositories."""

    machine: Machine
    server: Path
    clone: Path
    given: Mapping[str, str]

    def steps(self) -> dict[str, subprocess.CompletedProcess[str]]:
        """Run the workflow up to the step that hands the feedback back, which is not run; return what each said."""
        done = {}
        for command, env in self._commands():
            if "hand-back" not in command:
                done[command] = self.machine.run(command, self.clone, **self.given, **env)
        return done

    def hand_back(self) -> subprocess.CompletedProcess[str]:
        """Run the last step."""
        command, env = self._commands()[-1]
        assert "hand-back" in command
        return self.machine.run(command, self.clone, **self.given, **env)

    def _commands(self) -> list[tuple[str, dict[str, str]]]:
        secrets = {"QDOT_SECRET": SECRET, "QDOT_TOKEN": "not-checked-here"}
        return github_steps(self.clone / ".github" / "workflows" / "grade.yml", secrets)


@pytest.fixture(scope="module")
def on_github(assignment: Assignment, machine: Machine, tmp_path_factory: pytest.TempPathFactory) -> OnGitHub:
    """Ada and Bo have pushed their answers, and Cy has no repository."""
    place = tmp_path_factory.mktemp("github")
    server = pushed(assignment, "github", place, "ada", "bo")
    for student in ("ada", "bo"):
        write_json(place / "api" / "repos" / "course" / f"hw-{student}" / "activity", [{"timestamp": PUSHED}])
    clone = place / "clone"
    git("clone", "--quiet", hosted(_copy(assignment, "github", place), server, "course/grading"), clone)
    given = {
        "GITHUB_STEP_SUMMARY": str(place / "summary.md"), "GITHUB_SERVER_URL": f"file://{server}",
        "GITHUB_API_URL": f"file://{place / 'api'}", "GITHUB_REPOSITORY_OWNER": "course",
    }  # fmt: skip
    return OnGitHub(machine, server, clone, given)


def test_a_fresh_clone_on_github_grades_by_the_workflows_own_commands(on_github: OnGitHub) -> None:
    for command, done in on_github.steps().items():
        assert done.returncode == 0, done.stderr
        if "collect" in command:
            assert "cy: course/hw-cy can't be fetched" in done.stderr
    got = results(on_github.clone)
    assert [got[student]["score"] for student in ("ada", "bo", "cy")] == [4, 3, 0]
    assert got["ada"]["submission"]["received"] == "2027-01-15T22:00:00+00:00"  # type: ignore[index]
    summary = Path(on_github.given["GITHUB_STEP_SUMMARY"]).read_text(encoding="utf-8")
    assert "| bo | 3 | 4 | graded |" in summary


def test_students_get_their_own_feedback_back_on_github(on_github: OnGitHub) -> None:
    """After the test before: their own points, in a branch of its own, and nobody else's."""
    if not (on_github.clone / "graded").exists():
        on_github.steps()
    done = on_github.hand_back()
    assert done.returncode == 0, done.stderr
    back = on_github.server / "course" / "hw-bo.git"
    told = git("-C", back, "show", "feedback:README.md")
    assert "**3 of 4 points**" in told
    assert "ada" not in told
    assert "<html" in git("-C", back, "show", "feedback:feedback.html")
    assert git("-C", back, "log", "--format=%s", "main").splitlines() == ["first"]
    with pytest.raises(subprocess.CalledProcessError):
        git("-C", on_github.server / "course" / "hw-cy.git", "log")


def _copy(assignment: Assignment, platform: str, place: Path) -> Path:
    return Path(shutil.copytree(exported(assignment, platform) / "grading", place / "grading"))


@pytest.mark.whole  # as on GitHub, by the same commands but for where they stand
def test_a_fresh_clone_on_gitlab_grades_by_the_jobs_own_commands(
    assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    server, api, clone = pushed(assignment, "gitlab", tmp_path, "bo"), tmp_path / "api", tmp_path / "clone"
    events = [
        {"created_at": "2027-03-01T00:00:00Z", "push_data": {"ref": "feedback"}},
        {"created_at": PUSHED, "push_data": {"ref": "main"}},
    ]
    write_json(api / "projects" / "course" / "hw-bo" / "events", events)  # of a file://, curl decodes the path
    git("clone", "--quiet", hosted(_copy(assignment, "gitlab", tmp_path), server, "course/grading"), clone)
    job = read_yaml(clone / ".gitlab-ci.yml")["grade"]
    given = {
        "CI_SERVER_URL": f"file://{server}", "CI_API_V4_URL": f"file://{api}",
        "CI_PROJECT_NAMESPACE": "course", "QDOT_SECRET": SECRET, "QDOT_TOKEN": "x",
    }  # fmt: skip
    for command in job["script"]:
        done = machine.run(command, clone, **given)
        assert done.returncode == 0, done.stderr
    got = results(clone)
    assert [got[student]["score"] for student in ("ada", "bo")] == [0, 3]
    assert got["bo"]["submission"]["received"] == "2027-01-15T22:00:00+00:00"  # type: ignore[index]
    assert (clone / job["artifacts"]["reports"]["junit"]).read_text(encoding="utf-8").startswith("<testsuites")


def checks(clone: Path, platform: str) -> list[str]:
    """Return the commands by which a student's repository checks itself."""
    if platform == "github":
        return [command for command, _ in github_steps(clone / ".github" / "workflows" / "check.yml", {})]
    commands: list[str] = read_yaml(clone / ".gitlab-ci.yml")["check"]["script"]
    return commands


def test_a_students_repository_on_gitlab_checks_itself_as_on_github(assignment: Assignment) -> None:
    on_github, on_gitlab = (checks(exported(assignment, name) / "students" / "ada", name) for name in CHECKS)
    assert on_gitlab == [on_github[0], on_github[1].removesuffix(' --report github="$GITHUB_STEP_SUMMARY"')]
    for name in (".qdot", "hw.ipynb"):
        there, here = (exported(assignment, platform) / "students" / "ada" / name for platform in CHECKS)
        paths = [there, *there.rglob("*")]
        same = [path.read_bytes() == (here / path.relative_to(there)).read_bytes() for path in paths if path.is_file()]
        assert same and all(same)


@pytest.mark.parametrize("platform", ["github", pytest.param("gitlab", marks=pytest.mark.whole)])
def test_a_students_repository_checks_itself_without_any_secret(
    platform: str, assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    clone = tmp_path / "clone"
    git("clone", "--quiet", hosted(_students(assignment, platform, tmp_path), tmp_path / "server", "ada"), clone)
    install, check = checks(clone, platform)
    machine.run(install, clone)
    done = machine.run(check, clone, GITHUB_STEP_SUMMARY=str(tmp_path / "summary.md"))
    assert done.returncode == 1, done.stderr  # nothing is answered yet
    assert "0 of 3 answers can be read" in done.stdout
    if platform == "github":
        place = re.search(r"^::warning file=hw.ipynb,line=(\d+),title=p1.jacobian::left blank$", done.stdout, re.M)
        assert place
        line = (clone / "hw.ipynb").read_text(encoding="utf-8").splitlines()[int(place[1]) - 1]
        assert "p1_jacobian = " in line
        assert "| p1.jacobian | can't be read | left blank |" in (tmp_path / "summary.md").read_text(encoding="utf-8")


def _students(assignment: Assignment, platform: str, place: Path) -> Path:
    return Path(shutil.copytree(exported(assignment, platform) / "students" / "ada", place / "ada"))


def test_no_repository_holds_the_secret_and_no_students_workflow_asks_for_one(assignment: Assignment) -> None:
    for platform in ("github", "gitlab"):
        for path in exported(assignment, platform).rglob("*"):
            if path.is_file():
                assert SECRET.encode() not in path.read_bytes()
                if "students" in path.parts and path.suffix == ".yml":
                    assert "secret" not in path.read_text(encoding="utf-8").replace("nothing here is secret", "")
    grade = read_yaml(exported(assignment, "github") / "grading" / ".github" / "workflows" / "grade.yml")
    assert set(grade["on"]) == {"workflow_dispatch", "schedule"}  # nothing that a student does starts it


@pytest.mark.parametrize("platform", CHECKS)
def test_workflows_hold_to_the_platforms_schema(platform: str, assignment: Assignment, tmp_path: Path) -> None:
    schema = CHECKS[platform]
    files = [str(path) for path in exported(assignment, platform).rglob("*.yml")]
    assert len(files) == 4
    wrong = tmp_path / "wrong.yml"
    wrong.write_text("on: push\njobs: {a: {steps: 1}}\n" if platform == "github" else "a: {script: {b: 1}}\n")
    for given, code in ((files, 0), ([str(wrong)], 1)):
        command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, *given]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == code, done.stdout


def test_the_wheel_is_the_same_twice_and_its_libraries_are_named() -> None:
    first = wheel()
    wheel.cache_clear()
    assert wheel() == first
    named = versions().splitlines()
    assert any(line.startswith("sympy==") for line in named)
    assert not [line for line in named if line.startswith(("pytest==", "qdot=="))]


def test_a_robot_outside_of_the_folder_is_refused(assignment: Assignment, tmp_path: Path) -> None:
    folder = tmp_path / "hw"
    folder.mkdir()
    (folder / "assignment.toml").write_text('title = "T"\nkey = "hw"\n[[problem]]\nrobot = "../arm.toml"\n')
    (folder / "roster.csv").write_text("student\nada\n")
    with pytest.raises(QdotError, match="lies outside of"):
        assignment_files(Order(replace(assignment, folder=folder), failures_of))


def test_the_check_takes_one_report_only(tmp_path: Path) -> None:
    assert "write github=PATH" in fails("check", tmp_path / "x.ipynb", "--report", "junit=x")


def test_the_report_of_a_check_may_be_standard_output(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.md").write_text("```python\np1_determinant = 'a1*a2'\n```")
    said = run("check", "mine.md", "--report", "github=-")
    assert "| p1.determinant | can be read |" in said and [path.name for path in tmp_path.iterdir()] == ["mine.md"]
