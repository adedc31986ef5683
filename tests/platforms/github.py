"""GitHub's workflows, run on this machine by act, which is at `software` beside the actions that they use.

`software` is a folder with the program act and `actions/NAME` for each of `ACTIONS`, at the commit that is named there.
Where an action is not there, a step that keeps a folder stands for it. GitHub itself is a server of ours: its
repositories are real, its API has the lists of pushes and the issues that the jobs use (tests.support.git_server).
"""

import json
import os
import re
import subprocess
from pathlib import Path

from qdot.exercises.exports.repositories import ACTIONS
from tests.platforms.given import SECRET
from tests.platforms.notebooks import BLANK, KEY, RIGHT
from tests.platforms.records import Count, Record, today
from tests.platforms.repositories import OWNER, Class, counts, pushed, ran
from tests.support.git_server import TOKEN

STAND_IN = """name: keeps a folder
inputs: {name: {required: true}, path: {required: true}}
runs:
  using: composite
  steps:
    - {shell: bash, run: 'mkdir -p "$KEPT" && cp -R "${{ inputs.path }}" "$KEPT/${{ inputs.name }}"'}
"""
ASKED = f"repos/{OWNER}/{KEY}-grading/issues/1"


def run(software: Path, work: Path) -> Record:
    """Grade a class by the exported workflow, twice, and have two students' repositories check themselves."""
    with pushed("github", work) as own:
        act = _Act(software, work, own)
        grading = own.clone(f"{KEY}-grading", work / "clone", "https://github.com/")
        first = act.run("schedule", grading)
        marks = counts(own, work / "kept" / "graded", first)
        (work / "kept").rename(work / "kept-first")
        again = act.run("issues", grading)
        checked = [
            act.run("push", own.clone(f"{KEY}-{name}", work / name, "https://github.com/")) for name in (RIGHT, BLANK)
        ]
        jobs = [
            "Job succeeded" in first, "Job succeeded" in again and "Cache restored" in again,
            "Job succeeded" in checked[0], "Job failed" in checked[1] and re.search(r"\b0 of \d+ answers", checked[1]),
        ]  # fmt: skip
        asked = [path == ASKED and edit["by"] == "Bearer token-that-asks" for path, edit in own.server.edits]
    stand_ins = " ".join(["The server is simulated.", *(f"A stand-in replaces {name}." for name in act.missing)])
    imported, asking = Count(sum(map(bool, jobs)), len(jobs), stand_ins), Count(sum(asked), 2)
    return Record(
        "github", f"GitHub's actions by {act.version}", today(),
        {"imported": imported, **marks, "asked for points": asking},
    )  # fmt: skip


class _Act:
    """The runner: each job on this machine, with a Python that it finds where GitHub keeps those installed."""

    def __init__(self, software: Path, work: Path, own: Class) -> None:
        self.program, self.work, self.own = software / "act", work, own
        self.version = subprocess.run([self.program, "--version"], capture_output=True, text=True).stdout.strip()
        self.local, self.missing = list[str](), list[str]()
        for pinned in ACTIONS.values():
            name = pinned.split("@")[0].removeprefix("actions/")
            at = software / "actions" / name
            if not list(at.glob("dist/**/*.js")):
                self.missing.append(name)
                at = work / "actions" / name
                at.mkdir(parents=True)
                (at / "action.yml").write_text(STAND_IN)
            self.local += ["--local-repository", f"{pinned.split()[0]}={at}"]
        done = subprocess.run([own.python / "bin" / "python", "--version"], capture_output=True, text=True)
        tools = work / "tools" / "Python" / done.stdout.split()[1]
        tools.mkdir(parents=True)
        (tools / "x64").symlink_to(own.python)
        (tools / "x64.complete").touch()
        # What a job asks of github.com is asked of the server; an address that no file holds can't be forgotten there.
        (work / "gitconfig").write_text(f'[url "file://{own.server.folder}/"]\n\tinsteadOf = https://github.com/\n')
        (work / "event.json").write_text(
            json.dumps({"repository": {"default_branch": "main"}, "ref": "refs/heads/main"})
        )

    def run(self, event: str, clone: Path) -> str:
        """Run the workflow of a clone for an event; return all that is said."""
        given = {
            "RUNNER_TOOL_CACHE": self.work / "tools", "AGENT_TOOLSDIRECTORY": self.work / "tools",
            "GIT_CONFIG_GLOBAL": self.work / "gitconfig", "GITHUB_API_URL": self.own.server.api,
            "KEPT": self.work / "kept",
        }  # fmt: skip
        environment = [word for name, value in given.items() for word in ("--env", f"{name}={value}")]
        secrets = [f"QDOT_SECRET={SECRET}", f"QDOT_TOKEN={TOKEN}"] if event != "push" else ["QDOT_ASK=token-that-asks"]
        done = ran(
            [
                self.program, event, "--platform", "ubuntu-latest=-self-hosted", "--pull=false", *self.local,
                "--cache-server-path", self.work / "cache", "--cache-server-addr", "127.0.0.1",
                "--eventpath", self.work / "event.json", "--var", f"QDOT_ASKED={ASKED}", *environment,
                *(word for secret in secrets for word in ("--secret", secret)),
            ],
            clone, {**os.environ, "HOME": str(self.work), "XDG_CACHE_HOME": str(self.work / "xdg")},
        )  # fmt: skip
        (self.work / f"{clone.name}-{event}.log").write_text(done.stdout + done.stderr)
        return done.stdout + done.stderr
