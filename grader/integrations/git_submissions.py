"""Fetch what students have pushed to their repositories, as it was at the deadline, and hand back feedback.

    python -I -m qdot.grader.integrations.git_submissions collect DIR --on github
        fills DIR/submitted, listed in DIR/graded/collected.csv
    python -I -m qdot.grader.integrations.git_submissions hand-back DIR --on github
        puts feedback into the branch `feedback` of each

The grading job runs this with the staff's token. Nothing that was fetched is run. The server, not the repository, says
when a push came in (`git_hosts`).
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
from qdot.grader.grading.batch import find_student
from qdot.grader.grading.history import read_last_results
from qdot.grader.integrations.git_hosts import Host, Push, find_host
from qdot.grader.reports.github import make_summary
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
    """Say why there is nothing of a student's to grade: nothing was pushed, or nothing in time."""


class _Unreached(Exception):
    """Say why it is not known whether there is anything: the server can't be asked, or does not give it."""


@dataclass(frozen=True)
class Collected:
    """A student's repository: which commit is graded, when it was pushed, and until when a push counts.

    All are texts, as in the table. `left_out` says why there is nothing to grade, so that the work is missing;
    `unreached` why that is not known, so that there is no mark.
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
    """Return the time after which a student's pushes no longer count: the deadline, unless late work may earn points.

    Where late work loses a share (`late`), it is that table's `until`; None where pushes count without an end. Without
    that table, being late costs nothing: who pushed nothing in time is graded by the last push.
    """
    deadline = assignment.due_of(student)
    if deadline is None or assignment.late is None:
        return deadline
    if assignment.late.until is None or assignment.due_date is None:
        return None
    return assignment.late.until + (deadline - with_zone(assignment.due_date))


# --- collecting ---


def collect(assignment: Assignment, host: Host) -> list[Collected]:
    """Fetch everybody's repository into submitted/STUDENT, with a table of those who could not be reached.

    Raises QdotError if nobody could be; what was fetched before is still there then.
    """
    wanted = [(find_student(assignment, name), repository) for name, repository in _repositories(assignment, host)]
    for left in assignment.folder.glob(f"{WORK}*"):  # by a run that was killed
        shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=WORK, dir=assignment.folder) as work:
        fetched = Path(work, "submitted")
        fetched.mkdir()
        with ThreadPoolExecutor(AT_ONCE) as threads:
            every = list(threads.map(lambda each: _collect_one(assignment, host, fetched, *each), wanted))
        for each in every:
            if each.unreached:
                note(f"{each.student}: {each.repository} can't be fetched, and has no mark: {each.unreached}")
            elif each.left_out:
                note(f"{each.student}: {each.repository} is left out: {each.left_out}")
        unreached = [{"student": each.student, "why": each.unreached} for each in every if each.unreached]
        if len(unreached) == len(every):
            raise QdotError(
                "no repository could be fetched: are the names in repositories.csv right, and the token valid?"
            )
        if unreached:
            (fetched / NOT_FETCHED).write_text(_table(["student", "why"], unreached), encoding="utf-8")
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
    owner = f"{host.owner}/" if host.owner else "OWNER/"
    return [(student, repository.replace("OWNER/", owner, 1)) for student, repository in pairs if student]


def _collect_one(assignment: Assignment, host: Host, fetched: Path, student: Student, repository: str) -> Collected:
    """Fetch a student's repository into a folder of all, and return what was fetched."""
    until = find_cutoff(assignment, student)
    collected = Collected(student.id, repository, counts_until="" if until is None else until.isoformat())
    folder = fetched / student.id
    try:
        head = _git(host, "ls-remote", "--symref", host.url(repository), "HEAD").split()
        if head[:1] != ["ref:"]:
            raise _LeftOut("nothing was ever pushed to it")
        collected = replace(collected, branch=head[1].removeprefix("refs/heads/"))
        push = _counting_push(host, repository, collected.branch, until, late_too=assignment.late is None)
        collected = replace(collected, commit=push.commit, pushed=push.received.isoformat())
        _fetch_commit(host, repository, push, folder)
    except (_LeftOut, _Unreached, OSError) as error:
        shutil.rmtree(folder, ignore_errors=True)
        kind = "left_out" if isinstance(error, _LeftOut) else "unreached"
        return replace(collected, **{kind: printable(str(error))})
    return collected


def _counting_push(host: Host, repository: str, branch: str, until: datetime.datetime | None, late_too: bool) -> Push:
    """Return the last push to a branch that counts; if there is none, the very last if `late_too`."""
    try:
        pushes = iter(host.pushes(host, repository, branch))
        last = next(pushes, None)
        every = () if last is None else chain((last,), pushes)
        in_time = next((push for push in every if until is None or push.received <= until), None)
        counting = in_time or (last if late_too else None)
    except urllib.error.HTTPError as error:
        why = f"the server answers {error.code} {error.reason}"
        raise _Unreached(f"when it was pushed to is not known: {why}") from None
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise _Unreached(f"when it was pushed to is not known: {error}") from None
    if counting is None:
        raise _LeftOut(f"the server knows of no push to {branch}{f' until {until}' if until else ''}")
    return counting


def _fetch_commit(host: Host, repository: str, push: Push, folder: Path) -> None:
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
    """Return what git prints. Raises _Unreached with what it says is wrong; advice follows after that line."""
    try:
        done = subprocess.run(
            ["git", *arguments], env={**host.git_environment(), **environment}, stdin=subprocess.DEVNULL,
            capture_output=True, text=True, errors="replace", timeout=PATIENCE,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise _Unreached(f"git took longer than {PATIENCE} s") from None
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        last = lines[-1] if lines else f"git ended with {done.returncode}"
        raise _Unreached(printable(next((line for line in lines if ERROR.match(line)), last)))
    return done.stdout


ERROR = re.compile("(remote|error|fatal|ERROR):")
"""How the line begins in which git says what is wrong."""


# --- handing back ---


def hand_back(assignment: Assignment, host: Host) -> list[Collected]:
    """Push the feedback of everybody whose repository was fetched; return their repositories and whom it can't reach.

    It is a commit without a past that depends on nothing but the feedback: if that has not changed, nothing is sent.
    """
    graded, results = read_last_results(assignment)
    by_student = {result.student: result for result in results}

    def push_feedback(student: str, repository: str) -> Collected:
        with tempfile.TemporaryDirectory(prefix="qdot-feedback-") as work:
            page = assignment.folder / "graded" / "feedback" / f"{student}.html"
            try:
                Path(work, "README.md").write_text(make_summary(graded, [by_student[student]]), encoding="utf-8")
                shutil.copyfile(page, Path(work, "feedback.html"))
                _push(host, repository, work)
            except (OSError, _Unreached) as error:
                return Collected(student, repository, FEEDBACK, unreached=str(error))
        return Collected(student, repository, FEEDBACK)

    fetched = [
        (student, repository)
        for student, repository in _repositories(assignment, host)
        if student in by_student and (assignment.folder / "submitted" / student).is_dir()
    ]
    with ThreadPoolExecutor(AT_ONCE) as threads:
        every = list(threads.map(lambda each: push_feedback(*each), fetched))
    for each in every:
        if each.unreached:
            note(f"{each.student}: feedback can't be pushed to {each.repository}: {each.unreached}")
    return every


def _push(host: Host, repository: str, folder: str) -> None:
    author = ("-c", "user.name=qdot", "-c", "user.email=qdot@localhost", "-c", "commit.gpgsign=false")
    times = dict.fromkeys(("GIT_AUTHOR_DATE", "GIT_COMMITTER_DATE"), "2000-01-01T00:00:00Z")
    _git(host, "-C", folder, "init", "--quiet", f"--initial-branch={FEEDBACK}")
    _git(host, "-C", folder, "add", "--all")
    _git(host, "-C", folder, *author, "commit", "--quiet", "--message", "Feedback", **times)
    _git(host, "-C", folder, "push", "--quiet", "--force", host.url(repository), f"HEAD:refs/heads/{FEEDBACK}")


def main(arguments: list[str] | None = None) -> int:
    """Collect, or hand back; 0 if that was done, 1 if feedback did not reach everybody, 2 if it can't be done.

    A repository that can't be fetched stops nobody's grading: `qdot grade` then ends with 2, as that mark is lacking.
    """
    parser = argparse.ArgumentParser(
        prog="python -m qdot.grader.integrations.git_submissions", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("task", choices=("collect", "hand-back"))
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--on", choices=("github", "gitlab"), required=True)
    options = parser.parse_args(arguments)
    try:
        host, assignment = find_host(options.on, os.environ), load_assignment(options.folder)
        every = (collect if options.task == "collect" else hand_back)(assignment, host)
    except QdotError as error:
        note(f"qdot: {error}")
        return 2
    unreached, left_out = sum(bool(each.unreached) for each in every), sum(bool(each.left_out) for each in every)
    done = len(every) - unreached - left_out
    if options.task == "collect":
        say(f"{done} repositories fetched, {left_out} left out, {unreached} could not be fetched")
        return 0
    say(f"{done} repositories given their feedback, {unreached} not")
    return int(bool(unreached))


if __name__ == "__main__":
    sys.exit(main())
