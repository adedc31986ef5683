"""The action for GitHub and the components for GitLab: the example course graded by them, as their runners would."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.exports.repositories import ACTIONS
from qdot.exercises.exports.wheel import make_wheel
from tests.support import ROOT
from tests.support.ci import Machine, git, push_to_new_repository, read_yaml
from tests.support.ci_runners import Runner, expand_component, join_script
from tests.support.programs import ACTIONLINT, require_program, require_reader
from tests.support.submitting import Cells, make_correct_notebook

pytestmark = [pytest.mark.xdist_group("action"), pytest.mark.integration]

COURSE = ROOT / "docs" / "examples" / "course"
WORKFLOW = COURSE / ".github" / "workflows" / "grade.yml"
NAME = "ORGANISATION/qdot"
SECRET = "0123456789abcdef"


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    """A machine without an index, to which is lent what builds a wheel: the action is made from its own source."""
    made = Machine(tmp_path_factory.mktemp("machine"))
    made.lend()
    made.variables["PIP_NO_BUILD_ISOLATION"] = "0"  # as pip reads it: there is none
    return made


def half_right(cells: Cells) -> None:
    cells[-1]["source"] = "p1_determinant = 0"


@pytest.fixture(scope="module")
def course(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    """The example, with its secret beside it; Ada and Bo have handed in."""
    folder = Path(shutil.copytree(COURSE, tmp_path_factory.mktemp("course") / "course"))
    (folder / "secret.txt").write_text(SECRET)
    assignment = load_assignment(folder)
    for student, text in (
        ("ada", make_correct_notebook(assignment, "ada")),
        ("bo", make_correct_notebook(assignment, "bo", half_right)),
    ):
        (folder / "submitted" / student).mkdir(parents=True)
        (folder / "submitted" / student / "planar.ipynb").write_text(text)
    return assignment


@pytest.fixture
def clone(course: Assignment, tmp_path: Path) -> Path:
    """What a runner has of it: all but the secret."""
    pushed = Path(shutil.copytree(course.folder, tmp_path / "pushed", ignore=shutil.ignore_patterns("secret.txt")))
    git("clone", "--quiet", push_to_new_repository(pushed, tmp_path / "server", "course"), tmp_path / "clone")
    return tmp_path / "clone"


def runner(machine: Machine, clone: Path, **secrets: str) -> Runner:
    known = {f"secrets.{name}": value for name, value in secrets.items()}
    return Runner(machine, clone, clone.parent, {NAME: ROOT}, known)


def scores(graded: Path) -> dict[str, float]:
    lines = (graded / "results.jsonl").read_text(encoding="utf-8").splitlines()
    return {result["student"]: result["score"] for result in map(json.loads, lines)}


def edited(workflow: Path, text: str) -> Path:
    """Give the step of a workflow other inputs."""
    before = workflow.read_text(encoding="utf-8")
    after = before.replace("          secret: ${{ secrets.QDOT_SECRET }}\n", text)
    assert after != before
    workflow.write_text(after, encoding="utf-8")
    return workflow


def test_the_example_is_graded_on_github(machine: Machine, clone: Path) -> None:
    job = runner(machine, clone, QDOT_SECRET=SECRET)
    assert job.job(clone / ".github" / "workflows" / "grade.yml"), job.output
    kept = clone.parent / "kept" / "graded"
    assert scores(kept) == {"ada": 4, "bo": 3, "cy": 0}
    assert (kept / "junit.xml").is_file() and (kept / "feedback" / "bo.html").is_file()
    assert "| bo | 3 | 4 | graded |" in (clone.parent / "summary.md").read_text(encoding="utf-8")
    assert SECRET not in "".join(job.output)


def test_without_the_secret_nothing_is_graded_and_it_is_said_why(machine: Machine, clone: Path) -> None:
    job = runner(machine, clone)
    assert not job.job(clone / ".github" / "workflows" / "grade.yml")
    assert "without the secret, qdot can't regenerate the students' problems" in "".join(job.output)


@pytest.mark.parametrize(
    ("given", "succeeds", "says"),
    [
        ("fail-under: 80", False, "3 students: 2 graded, 1 missing"),
        ("run: mark", False, "::error::qdot: run is 'mark'; it is grade or check"),
    ],
    ids=lambda text: str(text)[:10],
)
def test_what_else_a_step_may_be_told(given: str, succeeds: bool, says: str, machine: Machine, clone: Path) -> None:
    inputs = f"          secret: ${{{{ secrets.QDOT_SECRET }}}}\n          {given}\n"
    workflow = edited(clone / ".github" / "workflows" / "grade.yml", inputs)
    (clone / "graded").mkdir()
    job = runner(machine, clone, QDOT_SECRET=SECRET)
    assert job.job(workflow) == succeeds and says in "".join(job.output), job.output


def test_a_students_repository_is_checked_without_a_secret(machine: Machine, clone: Path) -> None:
    (clone / "pip.py").write_text("raise SystemExit('a module of the repository was run')\n")
    workflow = edited(
        clone / ".github" / "workflows" / "grade.yml",
        "          run: check\n          notebook: submitted/bo/planar.ipynb\n",
    )
    text = workflow.read_text(encoding="utf-8")
    workflow.write_text(text[: text.index("      - uses: actions/upload")], encoding="utf-8")
    job = runner(machine, clone)
    assert job.job(workflow), job.output
    assert "3 of 3 answers can be read" in "".join(job.output)


def gitlab(name: str, machine: Machine, clone: Path, **given: object) -> "subprocess.CompletedProcess[str]":
    (job,) = expand_component(ROOT / "templates" / f"{name}.yml", given).values()
    variables = {**job["variables"], "QDOT_SECRET": SECRET} if name == "grade" else job["variables"]
    install, rest = join_script(job).split("\n", 1)
    machine.run(install, clone, **variables)
    return machine.run(rest, clone, **variables)


@pytest.fixture
def own(clone: Path) -> str:
    """qdot as a wheel in the repository, where no index has it."""
    name, content = make_wheel()
    (clone / name).write_bytes(content)
    return f"./{name}"


def test_the_example_is_graded_on_gitlab(machine: Machine, clone: Path, own: str) -> None:
    (asked,) = read_yaml(clone / ".gitlab-ci.yml")["include"]
    assert asked["component"] == "$CI_SERVER_FQDN/GROUP/qdot/grade@COMMIT"
    done = gitlab("grade", machine, clone, **asked["inputs"], install=own)
    assert done.returncode == 0, done.stderr
    assert scores(clone / "graded") == {"ada": 4, "bo": 3, "cy": 0} and (clone / "graded" / "junit.xml").is_file()


def test_a_students_project_is_checked_on_gitlab(machine: Machine, clone: Path, own: str) -> None:
    done = gitlab("check", machine, clone, notebook="submitted/bo/planar.ipynb", install=own)
    assert done.returncode == 0 and "3 of 3 answers can be read" in done.stdout, done.stderr


def test_a_grading_on_gitlab_fails_where_fetching_does(machine: Machine, clone: Path, own: str) -> None:
    done = gitlab("grade", machine, clone, install=own)
    assert done.returncode != 0 and "QDOT_TOKEN is not set" in done.stderr


# --- without a run ---


def test_action_and_components_hold_to_the_platforms_schemas(tmp_path: Path) -> None:
    made = tmp_path / "gitlab.yml"
    checks = [("vendor.github-actions", ROOT / "action.yml"), ("vendor.github-workflows", WORKFLOW)]
    for name, given in (("grade", {}), ("check", {"notebook": "x.ipynb"})):
        made = tmp_path / f"{name}.json"
        made.write_text(json.dumps(expand_component(ROOT / "templates" / f"{name}.yml", given)))
        checks.append(("vendor.gitlab-ci", made))
    for schema, path in checks:
        command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", schema, str(path)]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout


def pinned(text: str) -> str:
    return text.replace(f"{NAME}@COMMIT", f"{NAME}@{'0' * 40}  # v1.0.0")


def quiet(*command: str | Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_they_are_as_linters_want_them(tmp_path: Path) -> None:
    workflow = tmp_path / ".github" / "workflows" / "grade.yml"
    workflow.parent.mkdir(parents=True)
    workflow.write_text(pinned(WORKFLOW.read_text(encoding="utf-8")), encoding="utf-8")
    quiet(
        require_reader("zizmor"), "--offline", "--no-progress", "--persona", "pedantic", ROOT / "action.yml", workflow
    )
    shellcheck = require_reader("shellcheck")
    for number, step in enumerate(read_yaml(ROOT / "action.yml")["runs"]["steps"]):
        if "run" in step:
            script = tmp_path / f"{number}.sh"
            script.write_text(f"#!/bin/bash -e\n{step['run']}")
            quiet(shellcheck, script)
    for name, given in (("grade", {}), ("check", {"notebook": "x.ipynb"})):
        (job,) = expand_component(ROOT / "templates" / f"{name}.yml", given).values()
        (tmp_path / f"{name}.sh").write_text(f"#!/bin/bash -e\n{join_script(job)}\n")
        quiet(shellcheck, tmp_path / f"{name}.sh")


def test_workflows_that_use_it_are_as_actionlint_wants_them(tmp_path: Path) -> None:
    program = require_program("actionlint", ACTIONLINT, in_ci=False)
    workflow = tmp_path / "grade.yml"
    workflow.write_text(pinned(WORKFLOW.read_text(encoding="utf-8")), encoding="utf-8")
    quiet(program, workflow)


def test_actions_that_ours_uses_are_named_by_their_commits() -> None:
    used = re.findall(r"\buses: *(.+)", (ROOT / "action.yml").read_text() + WORKFLOW.read_text())
    assert set(used) - {f"{NAME}@COMMIT"} <= set(ACTIONS.values()) and len(used) == 4


def test_the_page_gives_the_action_what_it_takes() -> None:
    page = (ROOT / "docs" / "ci.md").read_text(encoding="utf-8")
    known = read_yaml(ROOT / "action.yml")["inputs"]
    used = []
    for text in re.findall(r"(?ms)^```yaml\n(.*?)^```", page):
        content = YAML(typ="safe").load(text)
        steps = (
            content if isinstance(content, list) else [s for j in content.get("jobs", {}).values() for s in j["steps"]]
        )
        used += [step for step in steps if step.get("uses", "").startswith(NAME)]
    assert used and all(step["with"].keys() <= known.keys() for step in used)
    table = page[page.index("| input |") : page.index("It needs only")]
    assert set(re.findall(r"`([\w-]+)`(?=[^|]*\|[^|]*\|\n)", table)) >= known.keys()
