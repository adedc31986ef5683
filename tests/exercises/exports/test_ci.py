"""Repositories for GitHub and GitLab: fresh clones, graded by the commands of the exported workflows."""

import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from check_jsonschema.cli.main_command import main as check_schema  # type: ignore[import-untyped]
from click.testing import CliRunner

from qdot.exercises.assignment.assignment import Assignment, Student
from qdot.exercises.exports.repositories import ACTIONS
from qdot.exercises.exports.wheel import make_wheel, write_versions
from tests.support import ROOT
from tests.support.ci import Machine, git, list_github_steps, push_to_new_repository, read_yaml
from tests.support.command import run, run_and_fail
from tests.support.git_server import TOKEN, Server, serve_repositories
from tests.support.programs import ACTIONLINT, require_program, require_reader
from tests.support.results import get_received_time, read_results
from tests.support.submitting import Cells, make_class, make_correct_notebook, read_folder

PUSHED = "2027-01-15T22:00:00Z"
SECRET = "0123456789abcdef"
CHECKS = {"github": "vendor.github-workflows", "gitlab": "vendor.gitlab-ci"}


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("course") / "hw"
    course = make_class(folder, [Student("ada", "Ada"), Student("bo"), Student("cy")])
    run("export", folder, "--to", "github", "--to", "gitlab", "--jobs", "1")
    return course


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    return Machine(tmp_path_factory.mktemp("machine"))


def get_export_folder(assignment: Assignment, platform: str) -> Path:
    return assignment.folder / "exports" / platform


def spoil_determinant(cells: Cells) -> None:
    cells[-1]["source"] = "p1_determinant = 0"


def push_answers(assignment: Assignment, platform: str, server: Server, *students: str) -> None:
    for student in students:
        folder = get_export_folder(assignment, platform) / "students" / student
        files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        text = make_correct_notebook(assignment, student, spoil_determinant if student == "bo" else lambda _: None)
        files |= {"hw.ipynb": text.encode(), "pip.py": b"raise SystemExit('a student module was run')\n"}
        server.push(f"course/hw-{student}", files, PUSHED)


@dataclass(frozen=True)
class GradingRepository:
    """The grading repository, cloned on a machine of its platform, and the server with the students' repositories."""

    machine: Machine
    server: Server
    clone: Path
    environment: Mapping[str, str]

    def run(self, commands: Sequence[tuple[str, Mapping[str, str]]]) -> str:
        output = []
        for command, env in commands:
            process = self.machine.run(command, self.clone, **{**self.environment, **env})
            assert process.returncode == 0, process.stderr
            output += [process.stdout, process.stderr]
        return "".join(output)

    def feedback(self, student: str) -> str:
        repository = self.server.bare(f"course/hw-{student}")
        assert "<html" in git("-C", repository, "show", "feedback:feedback.html")
        return git("-C", repository, "show", "feedback:README.md")


@contextmanager
def clone_grading_repository(
    assignment: Assignment, machine: Machine, platform: str, place: Path
) -> Iterator[GradingRepository]:
    """Yield a clone of the grading repository, after Ada and Bo pushed their answers and Cy nothing."""
    with serve_repositories(place / "server") as server:
        git("init", "--quiet", "--bare", server.bare("course/hw-cy"))
        push_answers(assignment, platform, server, "ada", "bo")
        clone = place / "clone"
        source = Path(shutil.copytree(get_export_folder(assignment, platform) / "grading", place / "grading"))
        git("clone", "--quiet", push_to_new_repository(source, server.folder, "course/hw-grading"), clone)
        environment = {"GITHUB_STEP_SUMMARY": str(place / "summary.md")} if platform == "github" else {}
        yield GradingRepository(machine, server, clone, {**server.variables(platform), "QDOT_TOKEN": "", **environment})


def list_grading_commands(platform: str, clone: Path) -> Sequence[tuple[str, Mapping[str, str]]]:
    environment = {"QDOT_SECRET": SECRET, "QDOT_TOKEN": TOKEN}
    if platform == "github":
        return list_github_steps(clone / ".github" / "workflows" / "grade.yml", environment)
    install, *script = read_yaml(clone / ".gitlab-ci.yml")["grade"]["script"]
    return [(install, {}), ("\n".join(script), environment)]  # a runner gives one shell all of a script


@pytest.mark.integration
@pytest.mark.parametrize("platform", CHECKS)
def test_fresh_clone_grades_and_returns_feedback(
    platform: str, assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    with clone_grading_repository(assignment, machine, platform, tmp_path) as job:
        output = job.run(list_grading_commands(platform, job.clone))
        assert "cy: course/hw-cy has nothing to grade" in output and TOKEN not in output
        results = read_results(job.clone)
        assert [results[student].score for student in ("ada", "bo", "cy")] == [4, 3, 0]
        assert get_received_time(results["ada"]) == "2027-01-15T22:00:00+00:00"
        if platform == "github":
            assert "| bo | 3 | 4 | graded |" in (tmp_path / "summary.md").read_text(encoding="utf-8")
        else:
            reports = read_yaml(job.clone / ".gitlab-ci.yml")["grade"]["artifacts"]["reports"]
            assert (job.clone / reports["junit"]).read_text(encoding="utf-8").startswith("<testsuites")
        feedback = job.feedback("bo")
        assert "**3 of 4 points**" in feedback and "ada" not in feedback
        assert git("-C", job.server.bare("course/hw-bo"), "log", "--format=%s", "main").splitlines() == ["work"]


def test_secret_is_only_in_the_grading_step(assignment: Assignment) -> None:
    """No repository contains the secret, and a student's workflow uses only a token that can request grading."""
    path = get_export_folder(assignment, "github") / "grading" / ".github" / "workflows" / "grade.yml"
    assert "github.event" not in path.read_text()  # no student input is read
    workflow = read_yaml(path)
    assert set(workflow["on"]) == {"workflow_dispatch", "schedule", "issues"}  # none runs student code
    assert workflow["on"]["issues"] == {"types": ["edited"]}
    (job,) = workflow["jobs"].values()
    environment = {step["name"]: set(step.get("env", {})) for step in job["steps"] if "run" in step}
    assert environment["Install qdot"] == set() and environment["Grade"] == {"QDOT_SECRET"}
    assert workflow["permissions"] == {} and job["permissions"] == {"contents": "read"}
    for step in job["steps"]:
        assert "uses" not in step or "env" not in step
    for platform in ("github", "gitlab"):
        for path in get_export_folder(assignment, platform).rglob("*"):
            if path.is_file():
                assert SECRET.encode() not in path.read_bytes()
                if "students" in path.parts and path.suffix == ".yml":
                    secrets = re.findall(r"secrets\.\w+|QDOT_SECRET|QDOT_TOKEN", path.read_text(encoding="utf-8"))
                    assert secrets == (["secrets.QDOT_ASK"] if platform == "github" else [])


def list_check_commands(clone: Path, platform: str) -> list[str]:
    if platform == "github":
        steps = list_github_steps(clone / ".github" / "workflows" / "check.yml", {})
        return [command for command, env in steps if "QDOT_ASK" not in env]
    commands: list[str] = read_yaml(clone / ".gitlab-ci.yml")["check"]["script"]
    return commands


def test_student_repositories_of_gitlab_and_github_check_alike(assignment: Assignment) -> None:
    folders = {name: get_export_folder(assignment, name) / "students" / "ada" for name in CHECKS}
    on_github, on_gitlab = (list_check_commands(folder, name) for name, folder in folders.items())
    assert on_gitlab == [on_github[0], on_github[1].removesuffix(' --report github="$GITHUB_STEP_SUMMARY"')]
    first, second = (
        {k: v for k, v in read_folder(f).items() if k.startswith((".qdot", "hw"))} for f in folders.values()
    )
    assert first and first == second


@pytest.mark.integration
@pytest.mark.parametrize("platform", CHECKS)
def test_student_repository_checks_itself_without_secrets(
    platform: str, assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    clone = tmp_path / "clone"
    folder = shutil.copytree(get_export_folder(assignment, platform) / "students" / "ada", tmp_path / "ada")
    git("clone", "--quiet", push_to_new_repository(Path(folder), tmp_path / "server", "ada"), clone)
    install, check = list_check_commands(clone, platform)
    machine.run(install, clone)
    done = machine.run(check, clone, GITHUB_STEP_SUMMARY=str(tmp_path / "summary.md"))
    assert done.returncode == 1, done.stderr  # nothing is answered yet
    assert "0 of 3 answers can be read" in done.stdout
    if platform == "github":
        assert "::warning file=hw.ipynb,title=p1.jacobian::" in done.stdout
        assert "| p1.jacobian | not parsed | left blank |" in (tmp_path / "summary.md").read_text(encoding="utf-8")


def test_push_requests_grading_with_the_request_token_only(
    assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    with serve_repositories(tmp_path / "server") as server:
        workflow = get_export_folder(assignment, "github") / "students" / "ada" / ".github" / "workflows" / "check.yml"
        known = {"QDOT_ASK": "token-that-asks", "QDOT_ASKED": "repos/course/hw-grading/issues/1"}
        ((command, env),) = [step for step in list_github_steps(workflow, known) if "QDOT_ASK" in step[1]]
        done = machine.run(command, tmp_path, GITHUB_API_URL=server.api, **env)
        assert done.returncode == 0 and not done.stdout, done.stderr
        ((path, edit),) = server.edits
        assert path == "repos/course/hw-grading/issues/1" and edit["by"] == "Bearer token-that-asks"
        assert re.fullmatch(r"Last asked \d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", edit["body"])


@pytest.mark.parametrize("platform", CHECKS)
def test_workflows_satisfy_the_platforms_schema(platform: str, assignment: Assignment) -> None:
    files = [str(path) for path in get_export_folder(assignment, platform).rglob("*.yml")]
    assert len(files) == 4
    done = CliRunner().invoke(check_schema, ["--builtin-schema", CHECKS[platform], *files])
    assert done.exit_code == 0, done.output


def list_workflows(assignment: Assignment) -> list[Path]:
    return [*get_export_folder(assignment, "github").rglob("*.yml"), *(ROOT / ".github" / "workflows").glob("*.yml")]


def test_every_action_is_pinned_to_a_commit(assignment: Assignment) -> None:
    """Someone who takes over an action can move its tags and run code in a job with secrets."""
    files = [*list_workflows(assignment), ROOT / "action.yml", *(ROOT / "docs").rglob("*.md")]
    files += (ROOT / "docs" / "examples").rglob(".github/workflows/*.yml")
    used = [line for path in files for line in re.findall(r"\buses: *(.+)", path.read_text(encoding="utf-8"))]
    assert len(used) > 10
    known = {pinned.partition("@")[0]: pinned for pinned in ACTIONS.values()}
    for line in used:
        if line.split()[0] in ("ORGANISATION/qdot@COMMIT", "./"):  # qdot's own action, at the course's address
            continue
        assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}  # v\d+\.\d+\.\d+", line)
        assert known.get(line.partition("@")[0], line) == line


def run_linter(*command: str | Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.integration
def test_workflows_and_their_commands_pass_linters(assignment: Assignment) -> None:
    workflows, shellcheck = list_workflows(assignment), require_reader("shellcheck")
    run_linter(require_reader("zizmor"), "--offline", "--no-progress", "--persona", "pedantic", *workflows)
    run_linter(shellcheck, get_export_folder(assignment, "github") / "setup-class.sh")
    run_linter(require_program("actionlint", ACTIONLINT, in_ci=False), "-shellcheck", shellcheck, *workflows)


def test_wheel_is_reproducible_and_pins_its_libraries() -> None:
    first = make_wheel()
    make_wheel.cache_clear()
    assert make_wheel() == first
    named = write_versions().splitlines()
    assert any(line.startswith("sympy==") for line in named)
    assert not [line for line in named if line.startswith(("pytest==", "qdot-robotics=="))]


def test_check_writes_report_to_standard_output(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "github=PATH" in run_and_fail("check", "mine.md", "--report", "junit=x")
    (tmp_path / "mine.md").write_text("```python\np1_determinant = 'a1*a2'\n```")
    output = run("check", "mine.md", "--report", "github=-")
    assert "| p1.determinant | parsed |" in output and [path.name for path in tmp_path.iterdir()] == ["mine.md"]
