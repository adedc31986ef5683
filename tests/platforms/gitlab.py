"""GitLab's jobs, run on this machine by gitlab-ci-local, whose command `software` is; rsync is on the path.

GitLab itself is a server of ours (tests.support.git_server): its repositories are real, its API lists the pushes.
"""

import os
import re
import subprocess
from collections.abc import Mapping
from pathlib import Path

from tests.platforms.given import SECRET
from tests.platforms.notebooks import BLANK, KEY, RIGHT
from tests.platforms.records import Count, Record, today
from tests.platforms.repositories import Class, counts, pushed, ran

ADDRESS = "git@gitlab.example.org:"


def run(software: Path, work: Path) -> Record:
    """Grade a class twice with the exported pipeline, and run the checks of two students' projects."""
    version = subprocess.run([software, "--version"], capture_output=True, text=True).stdout.strip()
    with pushed("gitlab", work) as own:
        grading = own.clone(f"{KEY}-grading", work / "clone", ADDRESS)
        given = {**own.server.variables("gitlab"), "QDOT_SECRET": SECRET}
        first = _job(software, work, own, grading, {**given, "CI_PIPELINE_SOURCE": "schedule"})
        marks = counts(own, grading / "graded", first)
        again = _job(software, work, own, grading, {**given, "CI_PIPELINE_SOURCE": "web"})
        checked = [
            _job(software, work, own, own.clone(f"{KEY}-{name}", work / name, ADDRESS), {}) for name in (RIGHT, BLANK)
        ]
        jobs = [
            "PASS  grade" in first, "PASS  grade" in again, "PASS  check" in checked[0],
            "FAIL  check" in checked[1] and re.search(r"\b0 of \d+ answers", checked[1]),
        ]  # fmt: skip
        unasked = _job(software, work, own, grading, {**given, "CI_PIPELINE_SOURCE": "push"})
    return Record(
        "gitlab", f"gitlab-ci-local {version}", today(),
        {
            "imported": Count(sum(map(bool, jobs)), len(jobs), "The server is simulated."), **marks,
            "not run on a push": Count(int("PASS" not in unasked), 1),
        },
    )  # fmt: skip


def _job(software: Path, work: Path, own: Class, clone: Path, given: Mapping[str, str]) -> str:
    """Run the pipeline of a clone; return all that is said."""
    known = [word for name, value in given.items() for word in ("--variable", f"{name}={value}")]
    path = f"{own.python / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = ran(
        [software, "--force-shell-executor", "--no-color", "--home", work / "home", *known],
        clone, {**os.environ, "HOME": str(work), "PATH": path},
    )  # fmt: skip
    return done.stdout + done.stderr
