"""Fetch students' repositories as of the deadline, and push feedback to them.

    python -I -m qdot.grader.integrations.git_submissions collect DIR --on github
        fills DIR/submitted, listed in DIR/graded/collected.csv
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
from dataclasses import astuple, dataclass, fields, replace
from itertools import chain
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.lateness import with_zone
from qdot.exercises.common.console import escape_controls, note, say
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.input_file import csv_text
from qdot.grader.grading.batch import find_student
from qdot.grader.grading.history import read_last_results
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
    """A student has no work to grade, because nothing was pushed, or nothing in time; the message says why."""


class _HostUnreachable(Exception):
    """It is unknown whether a student has work, because the server is unreachable or refuses; the message says why."""


@dataclass(frozen=True)
class CollectedRepository:
    """A student's repository: the commit to grade, the time of its push, and the time until which pushes count.

    All fields are texts, as in the table. `left_out` says why there is nothing to grade, so that the work counts as
    missing. `unreached` says why this is unknown, so that there is no mark.
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

    This time is the deadline if the assignment has no table `late`. Otherwise, it is the `until` of that table, shifted
    by the student's extension; the table deducts points for late work. Without the table, late work loses no points,
    and a student who pushed nothing in time is graded by the last push.
    """
    deadline = assignment.due_date_of(student)
    if deadline is None or assignment.late is None:
        return deadline
    if assignment.late.until is None or assignment.due_date is None:
        return None
    return assignment.late.until + (deadline - with_zone(assignment.due_date))


# --- collecting ---


def collect(assignment: Assignment, host: Host) -> list[CollectedRepository]:
    """Fetch every student's repository into submitted/STUDENT; write a table of the repositories not fetched.

    Raises QdotError if no repository could be fetched; previously fetched files then remain.
    """
    repositories = [(find_student(assignment, name), url) for name, url in _read_repositories(assignment, host)]
    for leftover in assignment.folder.glob(f"{WORK_FOLDER_PREFIX}*"):  # a killed run may have left folders
        shutil.rmtree(leftover, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=WORK_FOLDER_PREFIX, dir=assignment.folder) as work:
        fetched_folder = Path(work, "submitted")
        fetched_folder.mkdir()
        with ThreadPoolExecutor(MAX_PARALLEL) as threads:
            collected_repositories = list(
                threads.map(lambda each: _collect_one(assignment, host, fetched_folder, *each), repositories)
            )
        for each in collected_repositories:
            if each.unreached:
                note(f"{each.student}: qdot can't fetch {each.repository}, so there is no mark: {each.unreached}")
            elif each.left_out:
                note(f"{each.student}: {each.repository} has nothing to grade: {each.left_out}")
        unreached_students = [(each.student, each.unreached) for each in collected_repositories if each.unreached]
        if len(unreached_students) == len(collected_repositories):
            raise QdotError("no repository could be fetched; check the names in repositories.csv and the token")
        if unreached_students:
            table = csv_text([("student", "why"), *unreached_students])
            (fetched_folder / NOT_FETCHED_FILE).write_text(table, encoding="utf-8")
        submitted_folder = assignment.folder / "submitted"
        if submitted_folder.exists():
            submitted_folder.rename(Path(work, "before"))
        fetched_folder.rename(submitted_folder)
    table = csv_text([[column.name for column in fields(CollectedRepository)], *map(astuple, collected_repositories)])
    write_atomically(assignment.folder / "graded" / "collected.csv", table)
    return collected_repositories


def _read_repositories(assignment: Assignment, host: Host) -> list[tuple[str, str]]:
    """Return the pairs of a student and a repository in repositories.csv. Raises QdotError."""
    path = assignment.folder / "repositories.csv"
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines()))
        pairs = [(row["student"].strip(), row["repository"].strip()) for row in rows]
    except (OSError, ValueError, KeyError, AttributeError):
        raise QdotError(f"{path}: expected a table with the columns repository and student") from None
    owner = f"{host.owner}/" if host.owner else "OWNER/"
    return [(student, repository.replace("OWNER/", owner, 1)) for student, repository in pairs if student]


def _collect_one(
    assignment: Assignment, host: Host, fetched: Path, student: Student, repository: str
) -> CollectedRepository:
    """Fetch a student's repository into `fetched`/STUDENT, and return a description of it."""
    cutoff = find_cutoff(assignment, student)
    collected_repository = CollectedRepository(
        student.id, repository, counts_until="" if cutoff is None else cutoff.isoformat()
    )
    folder = fetched / student.id
    try:
        head = _run_git(host, "ls-remote", "--symref", host.repository_url(repository), "HEAD").split()
        if head[:1] != ["ref:"]:
            raise _NothingToGrade("nothing was pushed to it")
        collected_repository = replace(collected_repository, branch=head[1].removeprefix("refs/heads/"))
        push = _find_counting_push(
            host, repository, collected_repository.branch, cutoff, accepts_late=assignment.late is None
        )
        collected_repository = replace(collected_repository, commit=push.commit, pushed=push.received.isoformat())
        _fetch_commit(host, repository, push, folder)
    except (_NothingToGrade, _HostUnreachable, OSError) as error:
        shutil.rmtree(folder, ignore_errors=True)
        field_name = "left_out" if isinstance(error, _NothingToGrade) else "unreached"
        return replace(collected_repository, **{field_name: escape_controls(str(error))})
    return collected_repository


def _find_counting_push(
    host: Host, repository: str, branch: str, until: datetime.datetime | None, accepts_late: bool
) -> Push:
    """Return the last push to a branch in time. If there is none and `accepts_late`, return the last push of all."""
    try:
        pushes = iter(host.list_pushes(host, repository, branch))
        last_push = next(pushes, None)
        all_pushes = () if last_push is None else chain((last_push,), pushes)
        in_time = next((push for push in all_pushes if until is None or push.received <= until), None)
        counting_push = in_time or (last_push if accepts_late else None)
    except urllib.error.HTTPError as error:
        reason = f"the server answers {error.code} {error.reason}"
        raise _HostUnreachable(f"the times of its pushes are unknown: {reason}") from None
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise _HostUnreachable(f"the times of its pushes are unknown: {error}") from None
    if counting_push is None:
        raise _NothingToGrade(f"the server has no push to {branch}{f' until {until}' if until else ''}")
    return counting_push


def _fetch_commit(host: Host, repository: str, push: Push, folder: Path) -> None:
    """Write the files of a commit into a folder, each with the time of the push; symbolic links become plain files.

    If the server no longer has the commit, the student has replaced it by a forced push.
    """
    safe_options = ("-c", "core.symlinks=false", "-c", "core.hooksPath=/dev/null", "-C", str(folder))
    fetch_options = ("--quiet", "--depth", "1", "--no-tags", "--no-recurse-submodules")
    folder.mkdir()
    _run_git(host, *safe_options, "init", "--quiet")
    try:
        _run_git(host, *safe_options, "fetch", *fetch_options, host.repository_url(repository), push.commit)
    except _HostUnreachable as error:
        if re.search(r"not our ref|no such remote ref|unadvertised object", str(error)):
            raise _NothingToGrade(f"the commit that counts no longer exists: {error}") from None
        raise
    _run_git(host, *safe_options, "checkout", "--quiet", "--detach", push.commit)
    shutil.rmtree(folder / ".git")
    moment = push.received.timestamp()
    for path in folder.rglob("*"):
        os.utime(path, (moment, moment), follow_symlinks=False)


def _run_git(host: Host, *arguments: str, **environment: str) -> str:
    """Return the output of a git command.

    Raises _HostUnreachable with git's error line, without the advice after it.
    """
    try:
        process = subprocess.run(
            ["git", *arguments], env={**host.git_environment(), **environment}, stdin=subprocess.DEVNULL,
            capture_output=True, text=True, errors="replace", timeout=GIT_TIMEOUT,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise _HostUnreachable(f"git took longer than {GIT_TIMEOUT} s") from None
    if process.returncode:
        lines = [line for line in process.stderr.splitlines() if line.strip()]
        last_line = lines[-1] if lines else f"git ended with {process.returncode}"
        raise _HostUnreachable(escape_controls(next((line for line in lines if ERROR_LINE.match(line)), last_line)))
    return process.stdout


ERROR_LINE = re.compile("(remote|error|fatal|ERROR):")
"""The beginning of the line in which git reports an error."""


# --- returning feedback ---


def hand_back(assignment: Assignment, host: Host) -> list[CollectedRepository]:
    """Push the feedback to every fetched repository, and return the repositories, with errors in `unreached`.

    The feedback is a commit without a parent that depends only on its content, so unchanged feedback isn't sent again.
    """
    graded_assignment, results = read_last_results(assignment)
    by_student = {result.student: result for result in results}

    def push_feedback(student: str, repository: str) -> CollectedRepository:
        with tempfile.TemporaryDirectory(prefix="qdot-feedback-") as work:
            page = assignment.folder / "graded" / "feedback" / f"{student}.html"
            error_text = ""
            try:
                Path(work, "README.md").write_text(
                    make_summary(graded_assignment, [by_student[student]]), encoding="utf-8"
                )
                shutil.copyfile(page, Path(work, "feedback.html"))
                _push_folder(host, repository, work)
            except (OSError, _HostUnreachable) as error:
                error_text = str(error)
        return CollectedRepository(student, repository, FEEDBACK_BRANCH, unreached=error_text)

    submitted_folder = assignment.folder / "submitted"
    graded_students = [name for name in by_student if (submitted_folder / name).is_dir()]
    fetched_repositories = [each for each in _read_repositories(assignment, host) if each[0] in graded_students]
    with ThreadPoolExecutor(MAX_PARALLEL) as threads:
        pushed = list(threads.map(lambda each: push_feedback(*each), fetched_repositories))
    for each in pushed:
        if each.unreached:
            note(f"{each.student}: qdot can't push the feedback to {each.repository}: {each.unreached}")
    return pushed


def _push_folder(host: Host, repository: str, folder: str) -> None:
    """Push the files in a folder to the branch for feedback, as its only commit. Raises _HostUnreachable."""
    author = ("-c", "user.name=qdot", "-c", "user.email=qdot@localhost", "-c", "commit.gpgsign=false")
    times = dict.fromkeys(("GIT_AUTHOR_DATE", "GIT_COMMITTER_DATE"), "2000-01-01T00:00:00Z")
    _run_git(host, "-C", folder, "init", "--quiet", f"--initial-branch={FEEDBACK_BRANCH}")
    _run_git(host, "-C", folder, "add", "--all")
    _run_git(host, "-C", folder, *author, "commit", "--quiet", "--message", "Feedback", **times)
    target = (host.repository_url(repository), f"HEAD:refs/heads/{FEEDBACK_BRANCH}")
    _run_git(host, "-C", folder, "push", "--quiet", "--force", *target)


def main(arguments: list[str] | None = None) -> int:
    """Collect repositories or hand back feedback; return the exit code.

    The exit code is 0 for success, 1 if feedback did not reach every student, and 2 if the task can't be done. A
    repository that can't be fetched doesn't stop the grading of others; `qdot grade` then exits with 2, because a mark
    is missing.
    """
    program, description = "python -m qdot.grader.integrations.git_submissions", (__doc__ or "").splitlines()[0]
    parser = argparse.ArgumentParser(prog=program, description=description)
    parser.add_argument("task", choices=("collect", "hand-back"))
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--on", choices=("github", "gitlab"), required=True)
    options = parser.parse_args(arguments)
    try:
        host, assignment = find_host(options.on, os.environ), load_assignment(options.folder)
        repositories = (collect if options.task == "collect" else hand_back)(assignment, host)
    except QdotError as error:
        note(f"qdot: {error}")
        return 2
    failed_count = sum(bool(item.unreached) for item in repositories)
    left_out = sum(bool(item.left_out) for item in repositories)
    done_count = len(repositories) - failed_count - left_out
    repositories_text = f"{done_count} {'repository' if done_count == 1 else 'repositories'}"
    if options.task == "collect":
        say(f"{repositories_text} fetched, {left_out} without work to grade, {failed_count} could not be fetched")
        return 0
    say(f"feedback pushed to {repositories_text}, {failed_count} failed")
    return int(bool(failed_count))


if __name__ == "__main__":
    sys.exit(main())
