"""What students have pushed to their repositories: fetched as it was when it counts; feedback is handed back.

    python -I -m qdot.grader.integrations.git_submissions collect DIR --on github
        fills DIR/submitted, listed in DIR/graded/collected.csv
    python -I -m qdot.grader.integrations.git_submissions hand-back DIR --on github
        puts feedback into the branch `feedback` of each

It is the grading job that runs this, with the staff's token. Nothing that was fetched is run, and nothing in it says
when it came in: the server does (`git_hosts`).
"""

import argparse
import csv
import datetime
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import urllib.error
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields, replace
from itertools import chain
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.lateness import with_zone
from qdot.exercises.common.console import note, printable, say
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.grader.grading.history import last_results
from qdot.grader.grading.one_student import student_named
from qdot.grader.integrations.git_hosts import Host, Push, host_named
from qdot.grader.reports.github import summary
from qdot.grader.submissions.submission import NOT_FETCHED

AT_ONCE = 8
"""Repositories that are fetched, or pushed to, side by side."""
PATIENCE = 300
"""Seconds that git may take for one of them."""
WORK = ".submitted-"
"""What the folder beside submitted/ is called into which is fetched."""
FEEDBACK = "feedback"
"""The branch in which a student finds it."""


class _LeftOut(Exception):
    """Why there is nothing of a student's to grade, as the server says: nothing was pushed, or nothing in time."""


class _Unreached(Exception):
    """Why it is not known whether there is: the server can't be asked, or does not give it."""


@dataclass(frozen=True)
class Collected:
    """A student's repository: which commit is graded, pushed when, and until when a push counts; texts, as in a table.

    `left_out` says why there is nothing to grade, so that it is missing; `unreached` why that is not known, so that
    there is no mark.
    """

    student: str
    repository: str
    branch: str = ""
    commit: str = ""
    pushed: str = ""
    counts_until: str = ""
    left_out: str = ""
    unreached: str = ""

    @property
    def why(self) -> str:
        """Why nothing was fetched; empty where it was."""
        return self.unreached or self.left_out


def counts_until(assignment: Assignment, student: Student) -> datetime.datetime | None:
    """Return the time after which a push of a student's counts no more, where there is one before: when work is due.

    Where late work loses a share (`late`), it is that table's `until`; None where pushes count without an end. Without
    that table, being late costs nothing: who pushed nothing in time is graded by the last push.
    """
    due = assignment.due_of(student)
    if due is None or assignment.late is None:
        return due
    if assignment.late.until is None or assignment.due_date is None:
        return None
    return assignment.late.until + (due - with_zone(assignment.due_date))


# --- collecting ---


def collect(assignment: Assignment, host: Host) -> list[Collected]:
    """Fetch everybody's repository into submitted/STUDENT, with a table of those who could not be reached.

    Raises QdotError where nobody could be: what was fetched before is still there then.
    """
    asked = [
        (student_named(assignment, student), repository) for student, repository in _repositories(assignment, host)
    ]
    for left in assignment.folder.glob(f"{WORK}*"):  # by a run that was killed
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=WORK, dir=assignment.folder) as work:
        fetched = Path(work, "submitted")
        fetched.mkdir()
        with ThreadPoolExecutor(AT_ONCE) as threads:
            every = list(threads.map(lambda each: _collected(assignment, host, fetched, *each), asked))
        unreached = [each for each in every if each.unreached]
        for each in every:
            if each.why:
                said = "can't be fetched, and has no mark" if each.unreached else "is left out"
                note(f"{each.student}: {each.repository} {said}: {each.why}")
        if len(unreached) == len(every):
            raise QdotError(
                "no repository could be fetched: are the names in repositories.csv right, and the token valid?"
            )
        if unreached:
            rows = [{"student": each.student, "why": each.unreached} for each in unreached]
            (fetched / NOT_FETCHED).write_text(_table(["student", "why"], rows), encoding="utf-8")
        submitted = assignment.folder / "submitted"
        if submitted.exists():
            submitted.rename(Path(work, "before"))
        fetched.rename(submitted)
    table = _table([name.name for name in fields(Collected)], map(asdict, every))
    write_atomically(assignment.folder / "graded" / "collected.csv", table)
    return every


def _table(columns: Sequence[str], rows: Iterable[Mapping[str, str]]) -> str:
    table = io.StringIO()
    lines = csv.DictWriter(table, columns, lineterminator="\n")
    lines.writeheader()
    lines.writerows(rows)
    return table.getvalue()


def _repositories(assignment: Assignment, host: Host) -> list[tuple[str, str]]:
    """Return students and their repositories. Raises QdotError."""
    path = assignment.folder / "repositories.csv"
    try:
        rows = list(csv.DictReader(path.read_text(encoding="utf-8-sig").splitlines()))
        pairs = [(row["student"].strip(), row["repository"].strip()) for row in rows]
    except (OSError, ValueError, KeyError, AttributeError):
        raise QdotError(f"{path} is to be a table with the columns repository and student") from None
    own = f"{host.owner}/" if host.owner else "OWNER/"
    return [(student, repository.replace("OWNER/", own, 1)) for student, repository in pairs if student]


def _collected(assignment: Assignment, host: Host, fetched: Path, student: Student, repository: str) -> Collected:
    """Fetch a student's repository into a folder of all, and return what was fetched."""
    until = counts_until(assignment, student)
    told = Collected(student.id, repository, counts_until="" if until is None else until.isoformat())
    folder = fetched / student.id
    try:
        told = replace(told, branch=_default_branch(host, repository))
        push = _counting(host, repository, told.branch, until, late_too=assignment.late is None)
        told = replace(told, commit=push.commit, pushed=push.received.isoformat())
        _fetch(host, repository, push, folder)
    except (_LeftOut, _Unreached, OSError) as error:
        shutil.rmtree(folder, ignore_errors=True)
        said = printable(str(error))
        return replace(told, left_out=said) if isinstance(error, _LeftOut) else replace(told, unreached=said)
    return told


def _default_branch(host: Host, repository: str) -> str:
    said = _git(host, "ls-remote", "--symref", host.url(repository), "HEAD").split()
    if said[:1] != ["ref:"]:
        raise _LeftOut("nothing was ever pushed to it")
    return said[1].removeprefix("refs/heads/")


def _counting(host: Host, repository: str, branch: str, until: datetime.datetime | None, late_too: bool) -> Push:
    """Return the last push to a branch that counts; where there is none, the very last, if `late_too`."""
    try:
        pushes = iter(host.pushes(host, repository, branch))
        last = next(pushes, None)
        every = () if last is None else chain((last,), pushes)
        in_time = next((push for push in every if until is None or push.received <= until), None)
        counting = in_time or (last if late_too else None)
    except urllib.error.HTTPError as error:
        raise _Unreached(
            f"when it was pushed to is not known: the server answers {error.code} {error.reason}"
        ) from None
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise _Unreached(f"when it was pushed to is not known: {error}") from None
    if counting is None:
        raise _LeftOut(f"the server knows of no push to {branch}{f' until {until}' if until else ''}")
    return counting


def _fetch(host: Host, repository: str, push: Push, folder: Path) -> None:
    """Put the files of a commit into a folder, each with the time of the push; links become files.

    A commit that the server no longer has is one that the student has replaced, by a push that was forced.
    """
    safely = ("-c", "core.symlinks=false", "-c", "core.hooksPath=/dev/null", "-C", str(folder))
    folder.mkdir()
    _git(host, *safely, "init", "--quiet")
    try:
        _git(
            host, *safely, "fetch", "--quiet", "--depth", "1", "--no-tags", "--no-recurse-submodules",
            host.url(repository), push.commit,
        )  # fmt: skip
    except _Unreached as error:
        if re.search(r"not our ref|no such remote ref|unadvertised object", str(error)):
            raise _LeftOut(f"the commit that counts is no longer there: {error}") from None
        raise
    _git(host, *safely, "checkout", "--quiet", "--detach", push.commit)
    shutil.rmtree(folder / ".git")
    moment = push.received.timestamp()
    for path in folder.rglob("*"):
        os.utime(path, (moment, moment), follow_symlinks=False)


def _git(host: Host, *arguments: str, **environment: str) -> str:
    """Return what git prints. Raises _Unreached with what it says is wrong."""
    try:
        done = subprocess.run(
            ["git", *arguments], env={**host.git_environment(), **environment}, stdin=subprocess.DEVNULL,
            capture_output=True, text=True, errors="replace", timeout=PATIENCE,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise _Unreached(f"git took longer than {PATIENCE} s") from None
    if done.returncode:
        raise _Unreached(printable(_reason(done.stderr) or f"git ended with {done.returncode}"))
    return done.stdout


def _reason(said: str) -> str:
    """Return which of git's lines says what is wrong; advice follows after it."""
    lines = [line for line in said.splitlines() if line.strip()]
    return next((line for line in lines if re.match("(remote|error|fatal|ERROR):", line)), "".join(lines[-1:]))


# --- handing back ---


def hand_back(assignment: Assignment, host: Host) -> list[Collected]:
    """Push the feedback of everybody whose repository was fetched; return those of them who could not be reached.

    It is a commit without a past that depends on nothing but the feedback: where that is what it was, nothing is sent.
    """
    graded, results = last_results(assignment)
    by_student = {result.student: result for result in results}

    def handed(student: str, repository: str) -> Collected:
        with tempfile.TemporaryDirectory(prefix="qdot-feedback-") as work:
            page = assignment.folder / "graded" / "feedback" / f"{student}.html"
            try:
                Path(work, "README.md").write_text(summary(graded, [by_student[student]]), encoding="utf-8")
                shutil.copyfile(page, Path(work, "feedback.html"))
                _push(host, repository, work)
            except (OSError, _Unreached) as error:
                return Collected(student, repository, FEEDBACK, unreached=str(error))
        return Collected(student, repository, FEEDBACK)

    to_whom = [
        (student, repository)
        for student, repository in _repositories(assignment, host)
        if student in by_student and (assignment.folder / "submitted" / student).is_dir()
    ]
    with ThreadPoolExecutor(AT_ONCE) as threads:
        every = list(threads.map(lambda each: handed(*each), to_whom))
    for each in every:
        if each.unreached:
            note(f"{each.student}: feedback can't be pushed to {each.repository}: {each.unreached}")
    return every


def _push(host: Host, repository: str, folder: str) -> None:
    author = ("-c", "user.name=qdot", "-c", "user.email=qdot@localhost", "-c", "commit.gpgsign=false")
    _git(host, "-C", folder, "init", "--quiet", f"--initial-branch={FEEDBACK}")
    _git(host, "-C", folder, "add", "--all")
    at = "2000-01-01T00:00:00Z"
    _git(
        host, "-C", folder, *author, "commit", "--quiet", "--message", "Feedback", GIT_AUTHOR_DATE=at,
        GIT_COMMITTER_DATE=at,
    )  # fmt: skip
    _git(host, "-C", folder, "push", "--quiet", "--force", host.url(repository), f"HEAD:refs/heads/{FEEDBACK}")


def main(arguments: list[str] | None = None) -> int:
    """Collect, or hand back; 0 if that was done, 1 if feedback did not reach everybody, 2 if it can't be done.

    Who can't be fetched stops nobody's grading: it is `qdot grade` that then ends with 2, for want of their mark.
    """
    parser = argparse.ArgumentParser(
        prog="python -m qdot.grader.integrations.git_submissions", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("task", choices=("collect", "hand-back"))
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--on", choices=("github", "gitlab"), required=True)
    given = parser.parse_args(arguments)
    try:
        host, assignment = host_named(given.on, os.environ), load_assignment(given.folder)
        every = (collect if given.task == "collect" else hand_back)(assignment, host)
    except QdotError as error:
        note(f"qdot: {error}")
        return 2
    unreached, left_out = sum(bool(each.unreached) for each in every), sum(bool(each.left_out) for each in every)
    done = len(every) - unreached - left_out
    if given.task == "collect":
        say(f"{done} repositories fetched, {left_out} left out, {unreached} could not be fetched")
        return 0
    say(f"{done} repositories given their feedback, {unreached} not")
    return int(bool(unreached))


if __name__ == "__main__":
    sys.exit(main())
