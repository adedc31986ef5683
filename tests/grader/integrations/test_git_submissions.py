"""Collecting pushed work as it was at the deadline by the server's clock, and pushing feedback back."""

import csv
import json
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.late_rule import read_late_rule
from qdot.grader.integrations import git_hosts, git_submissions
from qdot.grader.integrations.git_submissions import find_cutoff, main
from tests.support.ci import git
from tests.support.command import run
from tests.support.git_server import TOKEN, Server, serve_repositories
from tests.support.submitting import TOML, make_class, make_correct_notebook, work_in_one_process

pytestmark = pytest.mark.xdist_group("pushed")

DUE = datetime(2027, 1, 15, 23, 0, tzinfo=UTC)
IN_TIME, LATE = "2027-01-15T22:00:00Z", "2027-01-16T08:00:00Z"


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    with serve_repositories(tmp_path / "server") as server:
        yield server


@pytest.fixture
def assignment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Assignment:
    folder = tmp_path / "hw"
    students = ["ada", "bo", "cy"]
    make_class(folder, [Student(student) for student in students])
    lines = [f"OWNER/hw-{student},{student}" for student in students]
    (folder / "repositories.csv").write_text("\n".join(["repository,student", *lines, ""]))
    (folder / "assignment.toml").write_text(f"due = {DUE.isoformat()}\n{TOML}")
    monkeypatch.setattr(git_hosts, "RETRY_PAUSES", ())
    return load_assignment(folder)


def set_platform(server: Server, platform: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in server.variables(platform).items():
        monkeypatch.setenv(name, value)


@pytest.fixture
def github(server: Server, monkeypatch: pytest.MonkeyPatch) -> Server:
    set_platform(server, "github", monkeypatch)
    return server


def collect(assignment: Assignment, platform: str = "github", command: str = "collect") -> int:
    return main([command, str(assignment.folder), "--on", platform])


def read_collected(assignment: Assignment) -> dict[str, dict[str, str]]:
    with (assignment.folder / "graded" / "collected.csv").open() as table:
        return {row["student"]: row for row in csv.DictReader(table)}


@pytest.mark.parametrize("platform", ["github", "gitlab"])
def test_the_last_push_before_the_deadline_is_collected(
    platform: str, assignment: Assignment, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ada pushed backdated commits after it, Bo pushed 250 times too late, Cy pushed only after it.

    Content does nothing: no link is followed, and no hook or filter runs.
    """
    monkeypatch.setenv("GIT_COMMITTER_DATE", "2020-01-01T00:00:00Z")
    commit_in_time = server.push("course/hw-ada", {"hw.ipynb": "in time", "x/y.txt": "y"}, IN_TIME)
    server.push("course/hw-ada", {"hw.ipynb": "too late"}, LATE)
    server.push("course/hw-ada", {"hw.ipynb": "elsewhere"}, "2027-01-15T22:30:00Z", branch="feedback")
    server.push("course/hw-bo", {"hw.ipynb": "in time, too"}, IN_TIME)
    commit = server.push("course/hw-bo", {"hw.ipynb": "too late"}, LATE)
    server.pushes["course/hw-bo"] += [("main", commit, LATE)] * 250
    work = server.folder / "work" / "course" / "hw-cy"
    git("init", "--quiet", work)
    (work / "hw.ipynb").symlink_to("/etc/passwd")
    server.push("course/hw-cy", {".gitattributes": "*.ipynb filter=lfs\n", ".gitmodules": "[submodule"}, LATE)
    set_platform(server, platform, monkeypatch)
    assert collect(assignment, platform) == 0
    submitted = assignment.folder / "submitted"
    assert (submitted / "ada" / "hw.ipynb").read_text() == "in time"
    assert (submitted / "bo" / "hw.ipynb").read_text() == "in time, too"
    late = submitted / "cy" / "hw.ipynb"  # without a rule for late work, it is only marked as late
    assert late.read_text() == "/etc/passwd" and not late.is_symlink()
    assert not (submitted / "ada" / ".git").exists()
    for path in ("hw.ipynb", "x/y.txt"):
        moment = (submitted / "ada" / path).stat().st_mtime
        assert datetime.fromtimestamp(moment, UTC) == datetime.fromisoformat(IN_TIME)
    rows = read_collected(assignment)
    assert (rows["ada"]["commit"], rows["ada"]["branch"]) == (commit_in_time, "main")
    assert rows["ada"]["counts_until"] == DUE.isoformat()
    assert rows["cy"]["pushed"] > rows["cy"]["counts_until"] and not rows["cy"]["left_out"]
    toml = assignment.folder / "assignment.toml"
    toml.write_text(f"late = {{until = {(DUE + timedelta(hours=1)).isoformat()}}}\n{toml.read_text()}")
    (assignment.folder / ".submitted-of-a-run-that-was-killed" / "submitted").mkdir(parents=True)
    assert collect(assignment, platform) == 0
    assert "no push to main until" in read_collected(assignment)["cy"]["left_out"]
    monkeypatch.setenv("GITHUB_API_URL", "http://127.0.0.1:9")
    monkeypatch.setenv("CI_API_V4_URL", "http://127.0.0.1:9")
    assert collect(assignment, platform) == 2, "nothing new could be fetched"
    assert (submitted / "ada" / "hw.ipynb").read_text() == "in time"
    assert not list(assignment.folder.glob(".submitted-*"))


@pytest.mark.whole
def test_unreachable_work_is_ungraded_and_missing_work_gets_zero(
    assignment: Assignment, github: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    """The server has no list of Bo's pushes, and Cy never pushed. Ada is graded anyway."""
    for student in ("ada", "bo"):
        github.push(f"course/hw-{student}", {"hw.ipynb": make_correct_notebook(assignment, student)}, IN_TIME)
    bo_pushes = github.pushes.pop("course/hw-bo")
    git("init", "--quiet", "--bare", github.bare("course/hw-cy"))
    assert collect(assignment) == 0
    printed = capsys.readouterr()
    assert printed.out == "1 repository fetched, 1 without work to grade, 1 could not be fetched\n"
    bo_message, cy_message = printed.err.splitlines()
    assert bo_message.startswith("bo: ") and "course/hw-bo" in bo_message and "404 Not Found" in bo_message
    assert cy_message.startswith("cy: ") and "course/hw-cy" in cy_message and TOKEN not in printed.err
    row = read_collected(assignment)["bo"]
    assert "404 Not Found" in row["unreached"] and not row["left_out"]

    def grade_statuses(code: int) -> list[str]:
        with work_in_one_process():
            run("grade", assignment.folder, "--jobs", "1", code=code)
        with (assignment.folder / "graded" / "grades.csv").open() as table:
            return [row["status"] for row in csv.DictReader(table)]

    assert grade_statuses(code=2) == ["graded", "ungraded", "missing"]
    assert "answers 404" in (assignment.folder / "graded" / "feedback" / "bo.html").read_text()
    assert collect(assignment, command="hand-back") == 0
    assert capsys.readouterr().out.startswith("feedback pushed to 1 repository,")
    github.pushes["course/hw-bo"] = bo_pushes
    assert collect(assignment) == 0
    assert grade_statuses(code=0) == ["graded", "graded", "missing"]


def test_a_commit_replaced_by_a_forced_push_is_left_out(assignment: Assignment, github: Server) -> None:
    for student in ("ada", "bo"):
        github.push(f"course/hw-{student}", {"hw.ipynb": "in time"}, IN_TIME)
    bare = github.bare("course/hw-bo")
    git("update-ref", "refs/heads/main", git("commit-tree", "-m", "new", "HEAD^{tree}", cwd=bare).strip(), cwd=bare)
    git("gc", "--quiet", "--prune=now", cwd=bare)
    assert collect(assignment) == 0
    row = read_collected(assignment)["bo"]
    assert "no longer exists" in row["left_out"] and not row["unreached"]


def test_a_missing_token_server_or_list_is_one_error(
    assignment: Assignment, server: Server, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("QDOT_TOKEN", raising=False)
    assert collect(assignment) == 2
    assert "QDOT_TOKEN is not set" in capsys.readouterr().err
    set_platform(server, "github", monkeypatch)
    assert collect(assignment) == 2
    assert "no repository could be fetched" in capsys.readouterr().err
    (assignment.folder / "repositories.csv").write_text("who,what\nada,hw\n")
    assert collect(assignment) == 2
    assert "columns repository and student" in capsys.readouterr().err


def test_pushes_count_until_the_students_cutoff(assignment: Assignment) -> None:
    ada = assignment.roster[0]
    ada_extended = replace(ada, due_date=datetime(2027, 1, 17, 23, tzinfo=UTC))
    last_day = datetime(2027, 1, 20, tzinfo=UTC)
    with_end = replace(assignment, late_rule=read_late_rule({"until": last_day}, DUE))
    open_ended = replace(assignment, late_rule=read_late_rule({"per_day": 0.1}, DUE))
    assert [find_cutoff(assignment, student) for student in (ada, ada_extended)] == [DUE, ada_extended.due_date]
    extended_end = datetime(2027, 1, 22, tzinfo=UTC)
    assert [find_cutoff(with_end, student) for student in (ada, ada_extended)] == [last_day, extended_end]
    assert find_cutoff(open_ended, ada) is find_cutoff(replace(assignment, due_date=None), ada) is None


def test_feedback_goes_to_its_student_and_is_pushed_once(
    assignment: Assignment, github: Server, capsys: pytest.CaptureFixture[str]
) -> None:
    for student in ("ada", "bo"):
        github.push(f"course/hw-{student}", {"hw.ipynb": make_correct_notebook(assignment, student)}, IN_TIME)
    git("init", "--quiet", "--bare", github.bare("course/hw-cy"))
    assert collect(assignment) == 0
    with work_in_one_process():
        run("grade", assignment.folder, "--jobs", "1")
    bare, heads = github.bare("course/hw-bo"), []
    for _ in range(2):
        assert collect(assignment, command="hand-back") == 0
        assert "feedback pushed to 2 repositories, 0 failed" in capsys.readouterr().out
        heads.append(git("-C", bare, "rev-parse", "feedback"))
    assert heads[0] == heads[1]
    readme = git("-C", bare, "show", "feedback:README.md")
    assert "**4 of 4 points**" in readme and "ada" not in readme
    assert "<html" in git("-C", bare, "show", "feedback:feedback.html")
    bare.rename(github.folder / "gone")
    (assignment.folder / "graded" / "feedback" / "ada.html").unlink()
    assert collect(assignment, command="hand-back") == 1
    printed = capsys.readouterr()
    assert "bo: qdot can't push the feedback to course/hw-bo: " in printed.err
    assert "ada: qdot can't push the feedback to course/hw-ada: " in printed.err
    assert printed.out == "feedback pushed to 0 repositories, 2 failed\n"


def test_git_gets_the_token_only_in_its_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QDOT_SECRET", "0123456789abcdef")
    host = git_hosts.find_host("github", {"QDOT_TOKEN": TOKEN, "GITHUB_SERVER_URL": "https://git.example.org/"})
    environment = host.make_git_environment()
    assert environment["GIT_CONFIG_KEY_0"] == "http.https://git.example.org/.extraheader"
    assert TOKEN not in json.dumps([host.make_repository_url("a/b"), repr(host)])
    assert not [name for name in environment if name.startswith("QDOT_")]
    assert git_submissions.MAX_PARALLEL > 1
