"""GitHub's workflows, run on this machine by act.

`software` is a folder with the program act and `actions/NAME` for each of `ACTIONS`, at the commit that is named there.
A missing action is replaced by a stand-in that copies a folder. GitHub itself is replaced by our own server. It has
real repositories, and its API has the lists of pushes and the issues that the jobs use (tests.support.git_server).
"""

import json
import os
import re
import subprocess
from pathlib import Path

from qdot.exercises.exports.repositories import ACTIONS
from tests.platforms.assignments import SECRET
from tests.platforms.notebooks import BLANK, KEY, RIGHT
from tests.platforms.records import Count, Record, today
from tests.platforms.repositories import OWNER, PushedClass, count_marks, run_job, serve_pushed_class
from tests.support.git_server import TOKEN

STAND_IN = """name: copies a folder
inputs: {name: {required: true}, path: {required: true}}
runs:
  using: composite
  steps:
    - {shell: bash, run: 'mkdir -p "$STORE" && cp -R "${{ inputs.path }}" "$STORE/${{ inputs.name }}"'}
"""
ISSUE = f"repos/{OWNER}/{KEY}-grading/issues/1"


def run(software: Path, work: Path) -> Record:
    with serve_pushed_class("github", work) as pushed_class:
        act = _Act(software, work, pushed_class)
        grading = pushed_class.clone(f"{KEY}-grading", work / "clone", "https://github.com/")
        first = act.run("schedule", grading)
        marks = count_marks(pushed_class, work / "stored" / "graded", first)
        (work / "stored").rename(work / "stored-first")
        again = act.run("issues", grading)
        checked = [
            act.run("push", pushed_class.clone(f"{KEY}-{name}", work / name, "https://github.com/"))
            for name in (RIGHT, BLANK)
        ]
        jobs = [
            "Job succeeded" in first, "Job succeeded" in again and "Cache restored" in again,
            "Job succeeded" in checked[0], "Job failed" in checked[1] and re.search(r"\b0 of \d+ answers", checked[1]),
        ]  # fmt: skip
        edits_are_expected = [
            path == ISSUE and edit["by"] == "Bearer token-that-asks" for path, edit in pushed_class.server.edits
        ]
    stand_ins = " ".join(["The server is simulated.", *(f"A stand-in replaces {name}." for name in act.missing)])
    imported, asked = Count(sum(map(bool, jobs)), len(jobs), stand_ins), Count(sum(edits_are_expected), 2)
    return Record(
        "github", f"GitHub's actions by {act.version}", today(),
        {"imported": imported, **marks, "asked for points": asked},
    )  # fmt: skip


class _Act:
    """The runner: it runs each job on this machine, with our Python in the folder where actions look for one."""

    def __init__(self, software: Path, work: Path, pushed_class: PushedClass) -> None:
        self.program, self.work, self.pushed_class = software / "act", work, pushed_class
        self.version = subprocess.run([self.program, "--version"], capture_output=True, text=True).stdout.strip()
        self.local_actions, self.missing = list[str](), list[str]()
        for pinned in ACTIONS.values():
            name = pinned.split("@")[0].removeprefix("actions/")
            action = software / "actions" / name
            if not list(action.glob("dist/**/*.js")):
                self.missing.append(name)
                action = work / "actions" / name
                action.mkdir(parents=True)
                (action / "action.yml").write_text(STAND_IN)
            self.local_actions += ["--local-repository", f"{pinned.split()[0]}={action}"]
        version = subprocess.run([pushed_class.python / "bin" / "python", "--version"], capture_output=True, text=True)
        tools = work / "tools" / "Python" / version.stdout.split()[1]
        tools.mkdir(parents=True)
        (tools / "x64").symlink_to(pushed_class.python)
        (tools / "x64.complete").touch()
        # Git sends requests for github.com to our server; no repository or workflow contains our server's address.
        (work / "gitconfig").write_text(
            f'[url "file://{pushed_class.server.folder}/"]\n\tinsteadOf = https://github.com/\n'
        )
        (work / "event.json").write_text(
            json.dumps({"repository": {"default_branch": "main"}, "ref": "refs/heads/main"})
        )

    def run(self, event: str, clone: Path) -> str:
        variables = {
            "RUNNER_TOOL_CACHE": self.work / "tools", "AGENT_TOOLSDIRECTORY": self.work / "tools",
            "GIT_CONFIG_GLOBAL": self.work / "gitconfig", "GITHUB_API_URL": self.pushed_class.server.api,
            "STORE": self.work / "stored",
        }  # fmt: skip
        environment = [word for name, value in variables.items() for word in ("--env", f"{name}={value}")]
        secrets = [f"QDOT_SECRET={SECRET}", f"QDOT_TOKEN={TOKEN}"] if event != "push" else ["QDOT_ASK=token-that-asks"]
        done = run_job(
            [
                self.program, event, "--platform", "ubuntu-latest=-self-hosted", "--pull=false", *self.local_actions,
                "--cache-server-path", self.work / "cache", "--cache-server-addr", "127.0.0.1",
                "--eventpath", self.work / "event.json", "--var", f"QDOT_ASKED={ISSUE}", *environment,
                *(word for secret in secrets for word in ("--secret", secret)),
            ],
            clone, {**os.environ, "HOME": str(self.work), "XDG_CACHE_HOME": str(self.work / "xdg")},
        )  # fmt: skip
        (self.work / f"{clone.name}-{event}.log").write_text(done.stdout + done.stderr)
        return done.stdout + done.stderr
