"""GitHub's runner and GitLab's, as far as our action, our components and the workflows that use them need them.

Whatever else a workflow holds is refused here, so that nothing is passed over that would be done there.
"""

import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from tests.support.ci import Machine, read_yaml

GIVEN = ("actions/checkout", "actions/setup-python", "actions/setup-node")
"""Actions whose work is done before a job begins here: its folder is a clone, the machine has a Python."""


def filled(text: object, known: Mapping[str, str]) -> str:
    """Return a value of a workflow, its expressions filled in: nothing for a secret or output that is not there."""

    def looked_up(found: re.Match[str]) -> str:
        name = found[1].strip()
        return known.get(name, "") if name.startswith(("secrets.", "steps.")) else known[name]

    if isinstance(text, bool):
        return str(text).lower()
    return re.sub(r"\$\{\{(.*?)\}\}", looked_up, str(text))


@dataclass
class Runner:
    """A job of GitHub's on a machine: steps in their order, actions made of steps, outputs, what is kept."""

    machine: Machine
    clone: Path
    place: Path
    actions: Mapping[str, Path]
    """Folders of actions by the name that workflows call them; the commit is whatever lies there."""
    known: dict[str, str] = field(default_factory=dict)
    variables: Mapping[str, str] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)

    def job(self, workflow: Path) -> bool:
        """Run the only job of a workflow; tell whether it succeeded."""
        (job,) = read_yaml(workflow)["jobs"].values()
        return self._steps(job["steps"], self.known, None)

    def _steps(self, steps: list[dict[str, Any]], known: dict[str, str], action: Path | None) -> bool:
        """Run steps, also those after one that failed whose condition has it so."""
        succeeded = True
        for step in steps:
            condition = re.sub(r"[${} ]", "", step.get("if", "success()"))
            if {"success()": succeeded, "!cancelled()": True}[condition]:
                succeeded &= self._step(step, known, action)
        return succeeded

    def _step(self, step: dict[str, Any], known: dict[str, str], action: Path | None) -> bool:
        given = {name: filled(value, known) for name, value in step.get("with", {}).items()}
        if "run" in step:
            return self._command(step, known, action)
        name = step["uses"].partition("@")[0]
        if name in GIVEN:
            return True
        if name == "actions/upload-artifact":
            if (self.clone / given["path"]).exists():  # else it warns
                shutil.copytree(self.clone / given["path"], self.place / "kept" / given["name"])
            elif given.get("if-no-files-found") == "error":
                return False
            return True
        return self._action(self.actions[name], given, step.get("id"))

    def _action(self, folder: Path, given: dict[str, str], name: str | None) -> bool:
        about = read_yaml(folder / "action.yml")
        assert given.keys() <= about["inputs"].keys() and about["runs"]["using"] == "composite"
        inputs = {f"inputs.{key}": given.get(key, each.get("default", "")) for key, each in about["inputs"].items()}
        succeeded = self._steps(about["runs"]["steps"], inputs, folder)
        for output, each in about.get("outputs", {}).items():
            self.known[f"steps.{name}.outputs.{output}"] = filled(each["value"], inputs)
        return succeeded

    def _command(self, step: dict[str, Any], known: dict[str, str], action: Path | None) -> bool:
        assert action is None or step["shell"] == "bash"
        output, temporary = self.place / "output", self.place / "temporary"
        temporary.mkdir(exist_ok=True)
        output.write_text("")
        variables = {
            **self.variables, **{key: filled(value, known) for key, value in step.get("env", {}).items()},
            "GITHUB_OUTPUT": str(output), "GITHUB_STEP_SUMMARY": str(self.place / "summary.md"),
            "RUNNER_TEMP": str(temporary), **({"GITHUB_ACTION_PATH": str(action)} if action else {}),
        }  # fmt: skip
        done = self.machine.run(step["run"], self.clone, **variables)
        self.said += [done.stdout, done.stderr]
        for line in output.read_text().splitlines():
            key, _, value = line.partition("=")
            known[f"steps.{step['id']}.outputs.{key}"] = value
        return done.returncode == 0


def component(path: Path, given: Mapping[str, object]) -> dict[str, Any]:
    """Return what GitLab makes of a component: its jobs, with inputs filled in."""
    header, body = path.read_text(encoding="utf-8").split("\n---\n")
    inputs = YAML(typ="safe").load(header)["spec"]["inputs"]
    assert given.keys() <= inputs.keys(), "GitLab refuses inputs that a component does not have"
    values = {name: given[name] if name in given else about["default"] for name, about in inputs.items()}
    for name, about in inputs.items():
        assert isinstance(values[name], bool if about.get("type") == "boolean" else str)
    text = re.sub(r"\$\[\[ inputs\.([\w-]+) \]\]", lambda found: filled(values[found[1]], {}), body)
    assert "$[[" not in text
    jobs: dict[str, Any] = YAML(typ="safe").load(text)
    return jobs


def script_of(job: Mapping[str, Any]) -> str:
    """Return the lines of a job of GitLab's as they are given to one shell, which stops at the first failure."""
    return "\n".join(job["script"])
