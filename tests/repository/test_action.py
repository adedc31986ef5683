"""The GitHub action and the GitLab components grade the example course in simulated runners."""

import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.exports.wheel import make_wheel
from tests.exercises.exports.test_ci import run_linter, spoil_determinant
from tests.support import ROOT
from tests.support.ci import Machine, git, push_to_new_repository, read_yaml
from tests.support.ci_runners import Runner, expand_component, join_script
from tests.support.programs import ACTIONLINT, require_program, require_reader
from tests.support.results import read_results
from tests.support.submitting import make_correct_notebook

pytestmark = [pytest.mark.xdist_group("action"), pytest.mark.integration]
COURSE = ROOT / "docs" / "examples" / "course"
WORKFLOW = COURSE / ".github" / "workflows" / "grade.yml"
NAME = "ORGANISATION/qdot"
SECRET = "0123456789abcdef"


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    """Return a machine without a package index, with the build tools that the action needs."""
    machine = Machine(tmp_path_factory.mktemp("machine"))
    machine.lend()
    machine.variables["PIP_NO_BUILD_ISOLATION"] = "0"  # as pip reads it: there is none
    return machine


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    """Return the example course with its secret; Ada and Bo have submitted."""
    folder = Path(shutil.copytree(COURSE, tmp_path_factory.mktemp("course") / "course"))
    (folder / "secret.txt").write_text(SECRET)
    assignment = load_assignment(folder)
    for student, text in (
        ("ada", make_correct_notebook(assignment, "ada")),
        ("bo", make_correct_notebook(assignment, "bo", spoil_determinant)),
    ):
        (folder / "submitted" / student).mkdir(parents=True)
        (folder / "submitted" / student / "planar.ipynb").write_text(text)
    return assignment


@pytest.fixture
def clone(course: Assignment, tmp_path: Path) -> Path:
    pushed = Path(shutil.copytree(course.folder, tmp_path / "pushed", ignore=shutil.ignore_patterns("secret.txt")))
    git("clone", "--quiet", push_to_new_repository(pushed, tmp_path / "server", "course"), tmp_path / "clone")
    return tmp_path / "clone"


def make_runner(machine: Machine, clone: Path, **secrets: str) -> Runner:
    secret_values = {f"secrets.{name}": value for name, value in secrets.items()}
    return Runner(machine, clone, clone.parent, {NAME: ROOT}, secret_values)


def edit_inputs(workflow: Path, text: str) -> Path:
    before = workflow.read_text(encoding="utf-8")
    after = before.replace("          secret: ${{ secrets.QDOT_SECRET }}\n", text)
    assert after != before
    workflow.write_text(after, encoding="utf-8")
    return workflow


def test_the_example_is_graded_on_github(machine: Machine, clone: Path) -> None:
    job = make_runner(machine, clone, QDOT_SECRET=SECRET)
    assert job.job(clone / ".github" / "workflows" / "grade.yml"), job.output
    artifact = clone.parent / "kept" / "graded"
    assert [result.score for result in read_results(artifact.parent).values()] == [4, 3, 0]
    assert (artifact / "junit.xml").is_file() and (artifact / "feedback" / "bo.html").is_file()
    assert "| bo | 3 | 4 | graded |" in (clone.parent / "summary.md").read_text(encoding="utf-8")
    assert SECRET not in "".join(job.output)


def test_without_the_secret_grading_stops_with_the_reason(machine: Machine, clone: Path) -> None:
    job = make_runner(machine, clone)
    assert not job.job(clone / ".github" / "workflows" / "grade.yml")
    assert "without the secret, qdot can't regenerate the students' problems" in "".join(job.output)


@pytest.mark.parametrize(
    ("option", "succeeds", "message"),
    [
        ("fail-under: 80", False, "3 students: 2 graded, 1 missing"),
        ("run: mark", False, "::error::qdot: run is 'mark', but it must be grade or check"),
    ],
    ids=lambda text: str(text)[:10],
)
def test_options_of_the_step(option: str, succeeds: bool, message: str, machine: Machine, clone: Path) -> None:
    inputs = f"          secret: ${{{{ secrets.QDOT_SECRET }}}}\n          {option}\n"
    workflow = edit_inputs(clone / ".github" / "workflows" / "grade.yml", inputs)
    (clone / "graded").mkdir()
    job = make_runner(machine, clone, QDOT_SECRET=SECRET)
    assert job.job(workflow) == succeeds and message in "".join(job.output), job.output


def test_a_students_repository_is_checked_without_a_secret(machine: Machine, clone: Path) -> None:
    (clone / "pip.py").write_text("raise SystemExit('a module of the repository was run')\n")
    inputs = "          run: check\n          notebook: submitted/bo/planar.ipynb\n"
    workflow = edit_inputs(clone / ".github" / "workflows" / "grade.yml", inputs)
    text = workflow.read_text(encoding="utf-8")
    workflow.write_text(text[: text.index("      - uses: actions/upload")], encoding="utf-8")
    job = make_runner(machine, clone)
    assert job.job(workflow), job.output
    assert "3 of 3 answers can be read" in "".join(job.output)


def run_on_gitlab(name: str, machine: Machine, clone: Path, **inputs: object) -> "subprocess.CompletedProcess[str]":
    (job,) = expand_component(ROOT / "templates" / f"{name}.yml", inputs).values()
    variables = {**job["variables"], "QDOT_SECRET": SECRET} if name == "grade" else job["variables"]
    install, script = join_script(job).split("\n", 1)
    machine.run(install, clone, **variables)
    return machine.run(script, clone, **variables)


@pytest.fixture
def wheel_path(clone: Path) -> str:
    name, content = make_wheel()
    (clone / name).write_bytes(content)
    return f"./{name}"


def test_the_example_is_graded_on_gitlab(machine: Machine, clone: Path, wheel_path: str) -> None:
    (component,) = read_yaml(clone / ".gitlab-ci.yml")["include"]
    assert component["component"] == "$CI_SERVER_FQDN/GROUP/qdot/grade@COMMIT"
    process = run_on_gitlab("grade", machine, clone, **component["inputs"], install=wheel_path)
    assert process.returncode == 0, process.stderr
    assert [result.score for result in read_results(clone).values()] == [4, 3, 0]
    assert (clone / "graded" / "junit.xml").is_file()


def test_a_students_project_is_checked_on_gitlab(machine: Machine, clone: Path, wheel_path: str) -> None:
    process = run_on_gitlab("check", machine, clone, notebook="submitted/bo/planar.ipynb", install=wheel_path)
    assert process.returncode == 0 and "3 of 3 answers can be read" in process.stdout, process.stderr


def test_grading_on_gitlab_fails_if_collecting_fails(machine: Machine, clone: Path, wheel_path: str) -> None:
    process = run_on_gitlab("grade", machine, clone, install=wheel_path)
    assert process.returncode != 0 and "QDOT_TOKEN is not set" in process.stderr


@pytest.mark.parametrize(("name", "inputs"), [("grade", {}), ("check", {"notebook": "x.ipynb"})])
def test_a_component_installs_our_distribution_by_default(name: str, inputs: dict[str, object]) -> None:
    """`qdot` on the package index is a stranger's package, which must not run where the secret is."""
    (job,) = expand_component(ROOT / "templates" / f"{name}.yml", inputs).values()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert job["variables"]["QDOT_INSTALL"] == project["name"]


def test_action_and_components_are_valid(tmp_path: Path) -> None:
    path = tmp_path / "gitlab.yml"
    checks = [("vendor.github-actions", ROOT / "action.yml"), ("vendor.github-workflows", WORKFLOW)]
    for name, inputs in (("grade", {}), ("check", {"notebook": "x.ipynb"})):
        path = tmp_path / f"{name}.json"
        path.write_text(json.dumps(expand_component(ROOT / "templates" / f"{name}.yml", inputs)))
        checks.append(("vendor.gitlab-ci", path))
    for schema, path in checks:
        command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, str(path)]
        process = subprocess.run(command, capture_output=True, text=True)
        assert process.returncode == 0, process.stdout


def test_scripts_and_workflows_pass_the_linters(tmp_path: Path) -> None:
    workflow = tmp_path / ".github" / "workflows" / "grade.yml"
    workflow.parent.mkdir(parents=True)
    workflow.write_text(WORKFLOW.read_text("utf-8").replace(f"{NAME}@COMMIT", f"{NAME}@{'0' * 40}  # v1.0.0"), "utf-8")
    zizmor = [require_reader("zizmor"), "--offline", "--no-progress", "--persona", "pedantic"]
    run_linter(*zizmor, ROOT / "action.yml", workflow)
    shellcheck = require_reader("shellcheck")
    for number, step in enumerate(read_yaml(ROOT / "action.yml")["runs"]["steps"]):
        if "run" in step:
            script = tmp_path / f"{number}.sh"
            script.write_text(f"#!/bin/bash -e\n{step['run']}")
            run_linter(shellcheck, script)
    for name, inputs in (("grade", {}), ("check", {"notebook": "x.ipynb"})):
        (job,) = expand_component(ROOT / "templates" / f"{name}.yml", inputs).values()
        (tmp_path / f"{name}.sh").write_text(f"#!/bin/bash -e\n{join_script(job)}\n")
        run_linter(shellcheck, tmp_path / f"{name}.sh")
    run_linter(require_program("actionlint", ACTIONLINT, in_ci=False), workflow)


def test_the_docs_use_only_inputs_of_the_action() -> None:
    page = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
    inputs = read_yaml(ROOT / "action.yml")["inputs"]
    used = []
    for text in re.findall(r"(?ms)^```yaml\n(.*?)^```", page):
        content = YAML(typ="safe").load(text)
        jobs = [{"steps": content}] if isinstance(content, list) else content.get("jobs", {}).values()
        used += [step for job in jobs for step in job["steps"] if step.get("uses", "").startswith(NAME)]
    assert used and all(step["with"].keys() <= inputs.keys() for step in used)
    table = page[page.index("| input |") : page.index("needs only")]
    assert set(re.findall(r"`([\w-]+)`(?=[^|]*\|[^|]*\|\n)", table)) >= inputs.keys()
