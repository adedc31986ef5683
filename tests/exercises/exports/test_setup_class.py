"""setup-class.sh creates a class's repositories, permissions and secrets, with a gh that records its calls."""

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from qdot.exercises.assignment.assignment import Student
from tests.support import ROOT
from tests.support.ci import git
from tests.support.command import run, run_and_fail
from tests.support.fake_github import github
from tests.support.programs import GH, GIT, require_program
from tests.support.submitting import make_class

SECRET = "0123456789abcdef"
ROSTER = "student,name,email,GitHub\nada,Ada,,ada-l\nbo,,,@bo\n"
LOGINS = ("ada-l", "bo")
TOKENS = {"QDOT_TOKEN": "the-staffs", "QDOT_ASK": "that-asks"}


@dataclass(frozen=True)
class Class:
    """An exported class, and a fake gh that knows these logins."""

    folder: Path
    state: Path

    def setup(self, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
        (self.state / "calls.jsonl").write_text("")
        return subprocess.run(
            ["bash", self.folder / "exports" / "github" / "setup-class.sh", *arguments], capture_output=True, text=True,
            env={
                "PATH": f"{self.state / 'bin'}{os.pathsep}{os.environ['PATH']}", "HOME": str(self.state),
                "GH_STATE": str(self.state), **variables,
            },
        )  # fmt: skip

    def calls(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in (self.state / "calls.jsonl").read_text().splitlines()]

    def secrets(self) -> dict[tuple[str, str], str]:
        secret_calls = [call for call in self.calls() if call["call"][:2] == ["secret", "set"]]
        return {(call["call"][4], call["call"][2]): call["stdin"] for call in secret_calls}

    def knows(self, logged_in: bool = True, logins: tuple[str, ...] = LOGINS, scopes: str = "repo, workflow") -> None:
        known = {"logged_in": logged_in, "logins": logins, "scopes": scopes}
        (self.state / "known.json").write_text(json.dumps(known))

    def show(self, repository: str, path: str) -> str:
        return git("-C", self.state / "repositories" / f"{repository}.git", "show", f"main:{path}")

    def subjects(self, repository: str) -> list[str]:
        return git("-C", self.state / "repositories" / f"{repository}.git", "log", "--format=%s", "main").splitlines()


def write_roster_and_export(folder: Path, roster: str) -> None:
    (folder / "roster.csv").write_text(roster)
    run("export", folder, "--to", "github", "--jobs", "1")


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("course") / "hw"
    make_class(folder, [Student("ada"), Student("bo")])
    write_roster_and_export(folder, ROSTER)
    return folder


@pytest.fixture
def course(exported: Path, tmp_path: Path) -> Class:
    require_program("git", GIT)
    folder, state = tmp_path / "hw", tmp_path / "state"
    shutil.copytree(exported, folder)
    (state / "bin").mkdir(parents=True)
    program = state / "bin" / "gh"
    program.write_text((ROOT / "tests" / "support" / "fake_gh.py").read_text())
    program.chmod(0o755)
    enrolled = Class(folder, state)
    enrolled.knows()
    return enrolled


@pytest.mark.integration
def test_real_gh_sets_up_a_class_and_a_second_run_changes_nothing(course: Class) -> None:
    require_program("gh", GH)
    (course.state / "bin" / "gh").unlink()
    with tempfile.TemporaryDirectory(prefix="gh") as short, github(Path(short, "g"), "course", "ada-l", "bo") as hub:
        done = course.setup("course", **TOKENS, **hub.environment)
        assert done.returncode == 0, done.stderr
        students = {"course/hw-ada", "course/hw-bo"}
        assert hub.private == {"course/hw-grading", *students}
        assert hub.invited == {"course/hw-ada": ("ada-l", "push"), "course/hw-bo": ("bo", "push")}
        assert hub.sealed == {
            "course/hw-grading": {"QDOT_SECRET", "QDOT_TOKEN"}, **{name: {"QDOT_ASK"} for name in students}
        }  # fmt: skip
        assert hub.issues == {"course/hw-grading": ["Pushes"]}
        variables = {"QDOT_ASKED": "repos/course/hw-grading/issues/1"}
        assert hub.variables == dict.fromkeys(students, variables)
        for student in ("ada", "bo"):
            repository = hub.bare(f"course/hw-{student}")
            assert f'"student": "{student}"' in git("-C", repository, "show", "main:hw.ipynb")
            assert "name: Check" in git("-C", repository, "show", "main:.github/workflows/check.yml")
        assert not [hidden for hidden in (SECRET, *TOKENS.values()) if hidden in done.stdout + done.stderr]
        pushed = {name: git("-C", hub.bare(name), "rev-parse", "main") for name in hub.private}
        hub.changes.clear()
        assert course.setup("course", **TOKENS, **hub.environment).returncode == 0
        assert not [change for change in hub.changes if change.startswith(("create", "POST /repos/course/hw-grading"))]
        assert pushed == {name: git("-C", hub.bare(name), "rev-parse", "main") for name in hub.private}
        assert hub.variables == dict.fromkeys(students, variables) and len(hub.issues["course/hw-grading"]) == 1


@pytest.mark.integration
def test_second_run_adds_new_students(course: Class) -> None:
    course.setup("course")
    write_roster_and_export(course.folder, f"{ROSTER}cy,,,cy99\n")
    course.knows(logins=("ada-l", "bo", "cy99"))
    assert course.setup("course", **TOKENS).returncode == 0
    created = [call["call"][2] for call in course.calls() if call["call"][:2] == ["repo", "create"]]
    assert created == ["course/hw-cy"]
    assert course.secrets() == {
        ("course/hw-grading", "QDOT_SECRET"): SECRET, ("course/hw-grading", "QDOT_TOKEN"): "the-staffs",
        **{(f"course/hw-{student}", "QDOT_ASK"): "that-asks" for student in ("ada", "bo", "cy")},
    }  # fmt: skip
    shown = json.dumps([call["call"] for call in course.calls()])
    assert not [hidden for hidden in (SECRET, *TOKENS.values()) if hidden in shown]
    assert "cy99" in course.show("course/hw-grading", "repositories.csv")
    assert course.subjects("course/hw-grading") == ["The class has changed", "hw [skip ci]"]
    assert course.subjects("course/hw-ada") == course.subjects("course/hw-cy") == ["hw [skip ci]"]


@pytest.mark.integration
def test_unknown_login_is_named_and_the_others_are_set_up(course: Class) -> None:
    course.knows(logins=("bo",))
    done = course.setup("course")
    assert done.returncode == 1 and "ada (ada-l)" in done.stderr and "HTTP 404" in done.stderr
    assert course.subjects("course/hw-bo") == ["hw [skip ci]"]


def test_dry_run_prints_everything_and_changes_nothing(course: Class) -> None:
    course.knows(scopes="")  # a fine-grained token, whose scopes GitHub does not report
    done = course.setup("course", "--dry-run", **TOKENS)
    assert done.returncode == 0, done.stderr
    assert not (course.state / "repositories").exists() and not course.secrets()
    for line in (
        "gh repo create course/hw-grading --private", "students/ada", "the issue Pushes",
        "gh secret set QDOT_SECRET --repo course/hw-grading",
        "gh api --method PUT repos/course/hw-bo/collaborators/bo --field permission=push",
        "QDOT_ASKED of course/hw-bo to repos/course/hw-grading/issues/1",
    ):  # fmt: skip
        assert line in done.stdout
    assert not [secret for secret in (SECRET, *TOKENS.values()) if secret in done.stdout]


def remove_gh(course: Class) -> None:
    (course.state / "bin" / "gh").unlink()
    for name in ("bash", "dirname", "git"):
        (course.state / "bin" / name).symlink_to(require_program(name, GIT))


@pytest.mark.parametrize(
    ("spoil", "arguments", "message"),
    [
        (lambda _: None, (), "organisation"), (lambda _: None, ("a", "b"), "a and b"),
        (remove_gh, ("a",), "gh is not installed"), (lambda _: None, ("a", "--try"), "--try"),
        (lambda course: course.knows(logged_in=False), ("a",), "gh auth login --scopes workflow"),
        (lambda course: course.knows(scopes="repo, gist"), ("a",), "gh auth refresh --scopes workflow"),
        (lambda course: write_roster_and_export(course.folder, "student,name\nada,Ada\nbo,\n"), ("a",), "ada bo"),
        (lambda course: (course.folder / "secret.txt").unlink(), ("a",), "the secret of the assignment"),
    ],
)  # fmt: skip
def test_missing_requirement_is_reported_and_nothing_is_changed(
    spoil: Callable[[Class], None], arguments: tuple[str, ...], message: str, course: Class
) -> None:
    spoil(course)
    alone = {"PATH": str(course.state / "bin")} if spoil is remove_gh else {}
    done = course.setup(*arguments, **alone)
    assert done.returncode == 2 and not done.stdout
    assert len(done.stderr.splitlines()) == 1 and message in done.stderr
    assert not (course.state / "repositories").exists()


def test_invalid_login_is_refused_at_export(course: Class) -> None:
    (course.folder / "roster.csv").write_text("student,github\nada,ada lovelace\n")
    assert "'ada lovelace' of ada" in run_and_fail("export", course.folder, "--to", "github")
