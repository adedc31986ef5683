"""Fetch students' repositories as of the deadline, and push feedback to them.

    python -I -m qdot.grader.integrations.git_submissions collect DIR --on github
        fetches into DIR/submitted, and lists the repositories in DIR/graded/collected.csv
    python -I -m qdot.grader.integrations.git_submissions hand-back DIR --on github
        pushes feedback to the branch `feedback` of each repository

The grading job runs this with the staff's token. No fetched file is executed. The times of pushes come from the server,
not from the repository (`git_hosts`).
"""

import argparse
import csv
import datetime
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.error
from concurrent.futures import ThreadPoolExecutor
from dataclasses import astuple, dataclass, fields
from itertools import chain
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.late_rule import add_time_zone
from qdot.exercises.common.console import escape_controls, note, print_result
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.input_file import format_csv
from qdot.grader.grading.history import read_results_to_report
from qdot.grader.integrations.git_hosts import Host, Push, find_host
from qdot.grader.reports.github import make_summary
from qdot.grader.submissions.submission import NOT_FETCHED_FILE

MAX_PARALLEL = 8
"""Maximum number of repositories that are fetched, or pushed to, at the same time."""
GIT_TIMEOUT = 300
"""Timeout for each git command, in seconds."""
WORK_FOLDER_PREFIX = ".submitted-"
"""Prefix of the temporary folder, next to submitted/, into which repositories are fetched."""
FEEDBACK_BRANCH = "feedback"
"""The branch in which a student finds the feedback."""


class _NothingToGrade(Exception):
    """Raised, with the reason, if a student pushed nothing, or nothing in time, so there is nothing to grade."""


class _GitFailed(Exception):
    """Raised, with the reason, if git or the server failed, so the student's work is unknown."""


@dataclass(frozen=True)
class CollectedRepository:
    """A student's repository, as in a row of collected.csv.

    `commit` is the commit to grade, `pushed` is the time of its push, and `counts_until` is the time until which pushes
    count. `left_out` says why there is nothing to grade; the work then counts as missing. `unreached` says why qdot
    could not reach the repository; the student then has no mark.
    """

    student: str
    repository: str
    branch: str = ""
    commit: str = ""
    pushed: str = ""
    counts_until: str = ""
    left_out: str = ""
    unreached: str = ""


def find_cutoff(assignment: Assignment, student: Student) -> datetime.datetime | None:
    """Return the time after which a student's pushes no longer count; None if they always count.

    If there is no push before this time, a later one may still count (`_find_counting_push`). Without the table `late`
    in assignment.toml, the time is the student's deadline. With this table, which deducts points for late work, the
    time is the table's `until`, shifted by the student's extension.
    """
    deadline = assignment.due_date_of(student)
    if deadline is None or assignment.late_rule is None:
        return deadline
    if assignment.late_rule.until is None or assignment.due_date is None:
        return None
    return assignment.late_rule.until + (deadline - add_time_zone(assignment.due_date))


# --- collecting ---


def collect(assignment: Assignment, host: Host) -> list[CollectedRepository]:
    """Fetch every student's repository into submitted/STUDENT, and write graded/collected.csv.

    A table in submitted/ lists the students whose repositories qdot could not reach. Raises QdotError if no repository
    could be fetched; the files of the last run then remain.
    """
    pairs = [(assignment.find_student(name), repository) for name, repository in _read_repositories(assignment, host)]
    for leftover in assignment.folder.glob(f"{WORK_FOLDER_PREFIX}*"):  # a killed run may have left folders
        shutil.rmtree(leftover, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=WORK_FOLDER_PREFIX, dir=assignment.folder) as work_folder:
        fetched_folder = Path(work_folder, "submitted")
        fetched_folder.mkdir()
        with ThreadPoolExecutor(MAX_PARALLEL) as threads:
            rows = list(threads.map(lambda pair: _collect_repository(assignment, host, fetched_folder, *pair), pairs))
        for row in rows:
            if row.unreached:
                note(f"{row.student}: qdot can't fetch {row.repository}, so there is no mark: {row.unreached}")
            elif row.left_out:
                note(f"{row.student}: {row.repository} has nothing to grade: {row.left_out}")
        unreached_students = [(row.student, row.unreached) for row in rows if row.unreached]
        if len(unreached_students) == len(rows):
            raise QdotError("no repository could be fetched; check the names in repositories.csv and the token")
        if unreached_students:
            unreached_table = format_csv([("student", "why"), *unreached_students])
            (fetched_folder / NOT_FETCHED_FILE).write_text(unreached_table, encoding="utf-8")
        submitted_folder = assignment.folder / "submitted"
        if submitted_folder.exists():
            submitted_folder.rename(Path(work_folder, "before"))
        fetched_folder.rename(submitted_folder)
    table = format_csv([[column.name for column in fields(CollectedRepository)], *map(astuple, rows)])
    write_atomically(assignment.folder / "graded" / "collected.csv", table)
    return rows


def _read_repositories(assignment: Assignment, host: Host) -> list[tuple[str, str]]:
    """Return the rows of repositories.csv: pairs of a student's identifier and a repository OWNER/NAME.

    Raises QdotError if the file can't be read.
    """
    path = assignment.folder / "repositories.csv"
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines()))
        pairs = [(row["student"].strip(), row["repository"].strip()) for row in rows]
    except (OSError, ValueError, KeyError, AttributeError):
        raise QdotError(f"{path}: expected a table with the columns repository and student") from None
    owner = f"{host.owner}/" if host.owner else "OWNER/"
    return [(student, repository.replace("OWNER/", owner, 1)) for student, repository in pairs if student]


def _collect_repository(
    assignment: Assignment, host: Host, parent: Path, student: Student, repository: str
) -> CollectedRepository:
    """Fetch into `parent`/STUDENT the commit of a student's repository that counts; return the repository's row."""
    cutoff = find_cutoff(assignment, student)
    folder = parent / student.id
    row = {"counts_until": "" if cutoff is None else cutoff.isoformat()}
    try:
        head = _run_git(host, "ls-remote", "--symref", host.make_repository_url(repository), "HEAD").split()
        if head[:1] != ["ref:"]:  # the name of the default branch follows "ref:"
            raise _NothingToGrade("nothing was pushed to it")
        row["branch"] = head[1].removeprefix("refs/heads/")
        # Without a rule for late work, late work is graded and marked as late.
        falls_back_to_last = assignment.late_rule is None
        push = _find_counting_push(host, repository, row["branch"], cutoff, falls_back_to_last)
        row |= {"commit": push.commit, "pushed": push.received.isoformat()}
        _fetch_commit(host, repository, push, folder)
    except (_NothingToGrade, _GitFailed, OSError) as error:
        shutil.rmtree(folder, ignore_errors=True)
        row["left_out" if isinstance(error, _NothingToGrade) else "unreached"] = escape_controls(str(error))
    return CollectedRepository(student.id, repository, **row)


def _find_counting_push(
    host: Host, repository: str, branch: str, cutoff: datetime.datetime | None, falls_back_to_last: bool
) -> Push:
    """Return the last push to a branch until `cutoff`. If there is none and `falls_back_to_last`, return the last push.

    Raises _NothingToGrade if there is no such push, and _GitFailed if the server doesn't list its pushes.
    """
    try:
        pushes = iter(host.list_pushes(host, repository, branch))
        last_push = next(pushes, None)
        all_pushes = () if last_push is None else chain((last_push,), pushes)
        last_push_in_time = next((push for push in all_pushes if cutoff is None or push.received <= cutoff), None)
        counting_push = last_push_in_time or (last_push if falls_back_to_last else None)
    except urllib.error.HTTPError as error:
        reason = f"the server answers {error.code} {error.reason}"
        raise _GitFailed(f"the times of its pushes are unknown: {reason}") from None
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise _GitFailed(f"the times of its pushes are unknown: {error}") from None
    if counting_push is None:
        raise _NothingToGrade(f"the server has no push to {branch}{f' until {cutoff}' if cutoff else ''}")
    return counting_push


def _fetch_commit(host: Host, repository: str, push: Push, folder: Path) -> None:
    """Write the files of a commit into a folder; every file gets the time of the push, and links become plain files.

    Raises _NothingToGrade if the server no longer has the commit: the student has replaced it by a forced push.
    """
    safe_options = ("-c", "core.symlinks=false", "-c", "core.hooksPath=/dev/null", "-C", str(folder))
    fetch_options = ("--quiet", "--depth", "1", "--no-tags", "--no-recurse-submodules")
    folder.mkdir()
    _run_git(host, *safe_options, "init", "--quiet")
    try:
        _run_git(host, *safe_options, "fetch", *fetch_options, host.make_repository_url(repository), push.commit)
    except _GitFailed as error:
        if re.search(r"not our ref|no such remote ref|unadvertised object", str(error)):
            raise _NothingToGrade(f"the commit that counts no longer exists: {error}") from None
        raise
    _run_git(host, *safe_options, "checkout", "--quiet", "--detach", push.commit)
    shutil.rmtree(folder / ".git")
    push_time = push.received.timestamp()
    for path in folder.rglob("*"):
        os.utime(path, (push_time, push_time), follow_symlinks=False)


def _run_git(host: Host, *arguments: str, **environment: str) -> str:
    """Return the output of a git command.

    Raises _GitFailed with git's error line, without the advice after it.
    """
    try:
        process = subprocess.run(
            ["git", *arguments], env={**host.make_git_environment(), **environment}, stdin=subprocess.DEVNULL,
            capture_output=True, text=True, errors="replace", timeout=GIT_TIMEOUT,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise _GitFailed(f"git took longer than {GIT_TIMEOUT} s") from None
    if process.returncode:
        lines = [line for line in process.stderr.splitlines() if line.strip()]
        last_line = lines[-1] if lines else f"git ended with {process.returncode}"
        raise _GitFailed(escape_controls(next((line for line in lines if ERROR_LINE.match(line)), last_line)))
    return process.stdout


ERROR_LINE = re.compile("(remote|error|fatal|ERROR):")
"""Matches the beginning of the line in which git reports an error."""


# --- returning feedback ---


def hand_back(assignment: Assignment, host: Host) -> list[CollectedRepository]:
    """Push the feedback to every fetched repository, and return the repositories; `unreached` says why a push failed.

    The feedback is a commit without a parent. Its id depends only on its content, so git does not send unchanged
    feedback again.
    """
    graded_assignment, results = read_results_to_report(assignment)
    result_by_student = {result.student: result for result in results}

    def push_feedback(student: str, repository: str) -> CollectedRepository:
        page = assignment.folder / "graded" / "feedback" / f"{student}.html"
        with tempfile.TemporaryDirectory(prefix="qdot-feedback-") as folder:
            try:
                summary = make_summary(graded_assignment, [result_by_student[student]])
                Path(folder, "README.md").write_text(summary, encoding="utf-8")
                shutil.copyfile(page, Path(folder, "feedback.html"))
                _push_folder(host, repository, folder)
            except (OSError, _GitFailed) as error:
                return CollectedRepository(student, repository, FEEDBACK_BRANCH, unreached=str(error))
        return CollectedRepository(student, repository, FEEDBACK_BRANCH)

    submitted_folder = assignment.folder / "submitted"
    pairs = [
        (student, repository)
        for student, repository in _read_repositories(assignment, host)
        if student in result_by_student and (submitted_folder / student).is_dir()
    ]
    with ThreadPoolExecutor(MAX_PARALLEL) as threads:
        rows = list(threads.map(lambda pair: push_feedback(*pair), pairs))
    for row in rows:
        if row.unreached:
            note(f"{row.student}: qdot can't push the feedback to {row.repository}: {row.unreached}")
    return rows


def _push_folder(host: Host, repository: str, folder: str) -> None:
    """Push the files in a folder to the branch for feedback, as its only commit. Raises _GitFailed."""
    author = ("-c", "user.name=qdot", "-c", "user.email=qdot@localhost", "-c", "commit.gpgsign=false")
    times = dict.fromkeys(("GIT_AUTHOR_DATE", "GIT_COMMITTER_DATE"), "2000-01-01T00:00:00Z")
    _run_git(host, "-C", folder, "init", "--quiet", f"--initial-branch={FEEDBACK_BRANCH}")
    _run_git(host, "-C", folder, "add", "--all")
    _run_git(host, "-C", folder, *author, "commit", "--quiet", "--message", "Feedback", **times)
    target = (host.make_repository_url(repository), f"HEAD:refs/heads/{FEEDBACK_BRANCH}")
    _run_git(host, "-C", folder, "push", "--quiet", "--force", *target)


def main(arguments: list[str] | None = None) -> int:
    """Collect repositories or hand back feedback; return the exit code.

    The exit code is 0 for success, 1 if feedback did not reach every student, and 2 if the task can't be done. The code
    is 0 even if some repositories can't be fetched, so that the others are graded; `qdot grade` then exits with 2,
    because marks are missing.
    """
    program = "python -m qdot.grader.integrations.git_submissions"
    parser = argparse.ArgumentParser(prog=program, description=(__doc__ or "").splitlines()[0])
    parser.add_argument("task", choices=("collect", "hand-back"))
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--on", choices=("github", "gitlab"), required=True)
    options = parser.parse_args(arguments)
    try:
        host, assignment = find_host(options.on, os.environ), load_assignment(options.folder)
        rows = (collect if options.task == "collect" else hand_back)(assignment, host)
    except QdotError as error:
        note(f"qdot: {error}")
        return 2
    failed_count = sum(bool(row.unreached) for row in rows)
    empty_count = sum(bool(row.left_out) for row in rows)
    success_count = len(rows) - failed_count - empty_count
    repositories_text = f"{success_count} {'repository' if success_count == 1 else 'repositories'}"
    if options.task == "collect":
        print_result(
            f"{repositories_text} fetched, {empty_count} without work to grade, {failed_count} could not be fetched"
        )
        return 0
    print_result(f"feedback pushed to {repositories_text}, {failed_count} failed")
    return int(bool(failed_count))


if __name__ == "__main__":
    sys.exit(main())
