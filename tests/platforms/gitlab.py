"""GitLab's jobs, run on this machine by gitlab-ci-local.

`software` is the path of its command; rsync is on the path.

GitLab itself is replaced by our own server (tests.support.git_server), with real repositories and an API that lists the
pushes.
"""

import os
import re
import subprocess
from collections.abc import Mapping
from pathlib import Path

from tests.platforms.assignments import SECRET
from tests.platforms.notebooks import BLANK, KEY, RIGHT
from tests.platforms.records import Count, Record, today
from tests.platforms.repositories import PushedClass, count_marks, run_job, serve_pushed_class

ADDRESS = "git@gitlab.example.org:"


def run(software: Path, work: Path) -> Record:
    """Grade a class by the exported pipeline, twice, and have two students' projects check themselves."""
    version = subprocess.run([software, "--version"], capture_output=True, text=True).stdout.strip()
    with serve_pushed_class("gitlab", work) as pushed_class:
        grading = pushed_class.clone(f"{KEY}-grading", work / "clone", ADDRESS)
        variables = {**pushed_class.server.variables("gitlab"), "QDOT_SECRET": SECRET}
        first = _run_pipeline(software, work, pushed_class, grading, {**variables, "CI_PIPELINE_SOURCE": "schedule"})
        marks = count_marks(pushed_class, grading / "graded", first)
        again = _run_pipeline(software, work, pushed_class, grading, {**variables, "CI_PIPELINE_SOURCE": "web"})
        checked = [
            _run_pipeline(software, work, pushed_class, pushed_class.clone(f"{KEY}-{name}", work / name, ADDRESS), {})
            for name in (RIGHT, BLANK)
        ]
        jobs = [
            "PASS  grade" in first, "PASS  grade" in again, "PASS  check" in checked[0],
            "FAIL  check" in checked[1] and re.search(r"\b0 of \d+ answers", checked[1]),
        ]  # fmt: skip
        push_log = _run_pipeline(software, work, pushed_class, grading, {**variables, "CI_PIPELINE_SOURCE": "push"})
    return Record(
        "gitlab", f"gitlab-ci-local {version}", today(),
        {
            "imported": Count(sum(map(bool, jobs)), len(jobs), "The server is simulated."), **marks,
            "not run on a push": Count(int("PASS" not in push_log), 1),
        },
    )  # fmt: skip


def _run_pipeline(
    software: Path, work: Path, pushed_class: PushedClass, clone: Path, variables: Mapping[str, str]
) -> str:
    options = [word for name, value in variables.items() for word in ("--variable", f"{name}={value}")]
    path = f"{pushed_class.python / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = run_job(
        [software, "--force-shell-executor", "--no-color", "--home", work / "home", *options],
        clone, {**os.environ, "HOME": str(work), "PATH": path},
    )  # fmt: skip
    return done.stdout + done.stderr
