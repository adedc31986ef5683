"""Repositories for GitHub and GitLab: fresh clones, graded by the very commands of the exported workflows."""

import json
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
from qdot.exercises.exports.wheel import list_versions, make_wheel
from tests.support import ROOT
from tests.support.ci import Machine, git, list_github_steps, push_to_new_repository, read_yaml
from tests.support.command import run, run_and_fail
from tests.support.git_server import TOKEN, Server, serve_repositories
from tests.support.programs import ACTIONLINT, require_program, require_reader
from tests.support.submitting import Cells, make_class, make_correct_notebook

PUSHED = "2027-01-15T22:00:00Z"
SECRET = "0123456789abcdef"
CHECKS = {"github": "vendor.github-workflows", "gitlab": "vendor.gitlab-ci"}


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("course") / "hw"
    made = make_class(folder, [Student("ada", "Ada"), Student("bo"), Student("cy")])
    run("export", folder, "--to", "github", "--to", "gitlab", "--jobs", "1")
    return made


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    return Machine(tmp_path_factory.mktemp("machine"))


def exported(assignment: Assignment, platform: str) -> Path:
    return assignment.folder / "exports" / platform


def half_right(cells: Cells) -> None:
    cells[-1]["source"] = "p1_determinant = 0"


def handed_in(assignment: Assignment, platform: str, server: Server, *students: str) -> None:
    """Have students push their answers, Bo's with a mistake, to the repositories that they were given."""
    for student in students:
        folder = exported(assignment, platform) / "students" / student
        files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        text = make_correct_notebook(assignment, student, half_right if student == "bo" else lambda _: None)
        files |= {"hw.ipynb": text.encode(), "pip.py": b"raise SystemExit('a student module was run')\n"}
        server.push(f"course/hw-{student}", files, PUSHED)


def results(clone: Path) -> dict[str, dict[str, object]]:
    lines = (clone / "graded" / "results.jsonl").read_text(encoding="utf-8").splitlines()
    return {result["student"]: result for result in map(json.loads, lines)}


@dataclass(frozen=True)
class Grading:
    """The repository that grades, cloned on a machine of its platform, beside the server with the students'."""

    machine: Machine
    server: Server
    clone: Path
    given: Mapping[str, str]

    def run(self, commands: Sequence[tuple[str, Mapping[str, str]]]) -> str:
        """Run commands, each with the variables of its own; return all that they said."""
        said = []
        for command, env in commands:
            done = self.machine.run(command, self.clone, **{**self.given, **env})
            assert done.returncode == 0, done.stderr
            said += [done.stdout, done.stderr]
        return "".join(said)

    def feedback(self, student: str) -> str:
        """Return what the student is told in the branch `feedback`."""
        bare = self.server.bare(f"course/hw-{student}")
        assert "<html" in git("-C", bare, "show", "feedback:feedback.html")
        return git("-C", bare, "show", "feedback:README.md")


@contextmanager
def grading(assignment: Assignment, machine: Machine, platform: str, place: Path) -> Iterator[Grading]:
    """Yield a repository that grades, where Ada and Bo have pushed their answers and Cy nothing."""
    with serve_repositories(place / "server") as server:
        git("init", "--quiet", "--bare", server.bare("course/hw-cy"))
        handed_in(assignment, platform, server, "ada", "bo")
        clone, source = place / "clone", shutil.copytree(exported(assignment, platform) / "grading", place / "grading")
        git("clone", "--quiet", push_to_new_repository(Path(source), server.folder, "course/hw-grading"), clone)
        given = {"GITHUB_STEP_SUMMARY": str(place / "summary.md")} if platform == "github" else {}
        yield Grading(machine, server, clone, {**server.variables(platform), "QDOT_TOKEN": "", **given})


def commands_of(platform: str, clone: Path) -> Sequence[tuple[str, Mapping[str, str]]]:
    """Return the commands by which a repository grades, each with its variables."""
    given = {"QDOT_SECRET": SECRET, "QDOT_TOKEN": TOKEN}
    if platform == "github":
        return list_github_steps(clone / ".github" / "workflows" / "grade.yml", given)
    install, *script = read_yaml(clone / ".gitlab-ci.yml")["grade"]["script"]
    return [(install, {}), ("\n".join(script), given)]  # a runner gives one shell all of a script


@pytest.mark.integration
@pytest.mark.parametrize("platform", CHECKS)
def test_a_fresh_clone_grades_and_hands_back_by_the_platforms_own_commands(
    platform: str, assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    with grading(assignment, machine, platform, tmp_path) as job:
        said = job.run(commands_of(platform, job.clone))
        assert "cy: course/hw-cy has nothing to grade" in said and TOKEN not in said
        got = results(job.clone)
        assert [got[student]["score"] for student in ("ada", "bo", "cy")] == [4, 3, 0]
        assert got["ada"]["submission"]["received"] == "2027-01-15T22:00:00+00:00"  # type: ignore[index]
        if platform == "github":
            assert "| bo | 3 | 4 | graded |" in (tmp_path / "summary.md").read_text(encoding="utf-8")
        else:
            reports = read_yaml(job.clone / ".gitlab-ci.yml")["grade"]["artifacts"]["reports"]
            assert (job.clone / reports["junit"]).read_text(encoding="utf-8").startswith("<testsuites")
        told = job.feedback("bo")
        assert "**3 of 4 points**" in told and "ada" not in told
        assert git("-C", job.server.bare("course/hw-bo"), "log", "--format=%s", "main").splitlines() == ["work"]


def test_only_what_grades_has_the_secret_and_notebooks_never_run_beside_the_token(assignment: Assignment) -> None:
    """No repository holds the secret, and a student's workflow asks for one that can only ask."""
    path = exported(assignment, "github") / "grading" / ".github" / "workflows" / "grade.yml"
    assert "github.event" not in path.read_text()  # nothing of what a student sends is read
    workflow = read_yaml(path)
    assert set(workflow["on"]) == {"workflow_dispatch", "schedule", "issues"}  # none runs what a student wrote
    assert workflow["on"]["issues"] == {"types": ["edited"]}
    (job,) = workflow["jobs"].values()
    given = {step["name"]: set(step.get("env", {})) for step in job["steps"] if "run" in step}
    assert given["Install qdot"] == set() and given["Grade"] == {"QDOT_SECRET"}
    assert workflow["permissions"] == {} and job["permissions"] == {"contents": "read"}
    for step in job["steps"]:
        assert "uses" not in step or "env" not in step
    for platform in ("github", "gitlab"):
        for path in exported(assignment, platform).rglob("*"):
            if path.is_file():
                assert SECRET.encode() not in path.read_bytes()
                if "students" in path.parts and path.suffix == ".yml":
                    asked = re.findall(r"secrets\.\w+|QDOT_SECRET|QDOT_TOKEN", path.read_text(encoding="utf-8"))
                    assert asked == (["secrets.QDOT_ASK"] if platform == "github" else [])


def checks(clone: Path, platform: str) -> list[str]:
    """Return the commands by which a student's repository checks itself."""
    if platform == "github":
        steps = list_github_steps(clone / ".github" / "workflows" / "check.yml", {})
        return [command for command, env in steps if "QDOT_ASK" not in env]
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


@pytest.mark.integration
@pytest.mark.parametrize("platform", CHECKS)
def test_a_students_repository_checks_itself_without_any_secret(
    platform: str, assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    clone = tmp_path / "clone"
    own = Path(shutil.copytree(exported(assignment, platform) / "students" / "ada", tmp_path / "ada"))
    git("clone", "--quiet", push_to_new_repository(own, tmp_path / "server", "ada"), clone)
    install, check = checks(clone, platform)
    machine.run(install, clone)
    done = machine.run(check, clone, GITHUB_STEP_SUMMARY=str(tmp_path / "summary.md"))
    assert done.returncode == 1, done.stderr  # nothing is answered yet
    assert "0 of 3 answers can be read" in done.stdout
    if platform == "github":
        assert "::warning file=hw.ipynb,title=p1.jacobian::" in done.stdout
        assert "| p1.jacobian | not parsed | left blank |" in (tmp_path / "summary.md").read_text(encoding="utf-8")


def test_a_push_asks_for_points_by_a_token_that_can_do_no_more(
    assignment: Assignment, machine: Machine, tmp_path: Path
) -> None:
    with serve_repositories(tmp_path / "server") as server:
        workflow = exported(assignment, "github") / "students" / "ada" / ".github" / "workflows" / "check.yml"
        known = {"QDOT_ASK": "token-that-asks", "QDOT_ASKED": "repos/course/hw-grading/issues/1"}
        ((command, env),) = [step for step in list_github_steps(workflow, known) if "QDOT_ASK" in step[1]]
        done = machine.run(command, tmp_path, GITHUB_API_URL=server.api, **env)
        assert done.returncode == 0 and not done.stdout, done.stderr
        ((path, edit),) = server.edits
        assert path == "repos/course/hw-grading/issues/1" and edit["by"] == "Bearer token-that-asks"
        assert re.fullmatch(r"Last asked \d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", edit["body"])


@pytest.mark.parametrize("platform", CHECKS)
def test_workflows_hold_to_the_platforms_schema(platform: str, assignment: Assignment) -> None:
    files = [str(path) for path in exported(assignment, platform).rglob("*.yml")]
    assert len(files) == 4
    done = CliRunner().invoke(check_schema, ["--builtin-schema", CHECKS[platform], *files])
    assert done.exit_code == 0, done.output


def workflows(assignment: Assignment) -> list[Path]:
    """Return the workflows for GitHub that we export, and our own."""
    return [*exported(assignment, "github").rglob("*.yml"), *(ROOT / ".github" / "workflows").glob("*.yml")]


def test_every_action_is_named_by_its_commit_everywhere(assignment: Assignment) -> None:
    """A tag can be moved by whoever takes over an action, and with it what a job with secrets runs."""
    files = [*workflows(assignment), *(ROOT / "docs").rglob("*.md")]
    used = [line for path in files for line in re.findall(r"\buses: *(.+)", path.read_text(encoding="utf-8"))]
    assert len(used) > 10
    known = {pinned.partition("@")[0]: pinned for pinned in ACTIONS.values()}
    for line in used:
        if line.split()[0] in ("ORGANISATION/qdot@COMMIT", "./"):  # qdot's own, which lies where a course has put it
            continue
        assert re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}  # v\d+\.\d+\.\d+", line)
        assert known.get(line.partition("@")[0], line) == line


def quiet(*command: str | Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.integration
def test_workflows_and_their_commands_are_as_linters_want_them(assignment: Assignment) -> None:
    quiet(require_reader("zizmor"), "--offline", "--no-progress", "--persona", "pedantic", *workflows(assignment))
    shellcheck = require_reader("shellcheck")
    quiet(shellcheck, exported(assignment, "github") / "setup-class.sh")
    quiet(require_program("actionlint", ACTIONLINT, in_ci=False), "-shellcheck", shellcheck, *workflows(assignment))


def test_the_wheel_is_the_same_twice_and_its_libraries_are_named() -> None:
    first = make_wheel()
    make_wheel.cache_clear()
    assert make_wheel() == first
    named = list_versions().splitlines()
    assert any(line.startswith("sympy==") for line in named)
    assert not [line for line in named if line.startswith(("pytest==", "qdot-robotics=="))]


def test_a_check_takes_one_report_which_may_be_standard_output(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "github=PATH" in run_and_fail("check", "mine.md", "--report", "junit=x")
    (tmp_path / "mine.md").write_text("```python\np1_determinant = 'a1*a2'\n```")
    said = run("check", "mine.md", "--report", "github=-")
    assert "| p1.determinant | parsed |" in said and [path.name for path in tmp_path.iterdir()] == ["mine.md"]
