"""The parts of GitHub's and GitLab's runners that our action, our components and their example workflows need.

Anything else in a workflow is an error, so the tests skip nothing that a real runner would do.
"""

import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from tests.support.ci import Machine, read_yaml

PRE_DONE_ACTIONS = ("actions/checkout", "actions/setup-python", "actions/setup-node")
"""Actions that have nothing to do here: the job's folder is already a clone, and the machine has Python."""


def fill_expressions(text: object, expression_values: Mapping[str, str]) -> str:
    """Return a value of a workflow with its expressions filled in; missing secrets and outputs are empty."""

    def look_up(match: re.Match[str]) -> str:
        name = match[1].strip()
        may_be_missing = name.startswith(("secrets.", "steps."))
        return expression_values.get(name, "") if may_be_missing else expression_values[name]

    if isinstance(text, bool):
        return str(text).lower()
    return re.sub(r"\$\{\{(.*?)\}\}", look_up, str(text))


@dataclass
class Runner:
    """A GitHub job on a machine: steps in order, composite actions, outputs, uploaded artifacts.

    `expression_values` has the values of expressions in workflows, such as "secrets.TOKEN".
    """

    machine: Machine
    clone: Path
    place: Path
    actions: Mapping[str, Path]
    """The folders of actions by their names in workflows; the commit is ignored."""
    expression_values: dict[str, str] = field(default_factory=dict)
    variables: Mapping[str, str] = field(default_factory=dict)
    output: list[str] = field(default_factory=list)

    def job(self, workflow: Path) -> bool:
        """Run the only job of a workflow; return whether it succeeded."""
        (job,) = read_yaml(workflow)["jobs"].values()
        return self._run_steps(job["steps"], self.expression_values, None)

    def _run_steps(self, steps: list[dict[str, Any]], expression_values: dict[str, str], action: Path | None) -> bool:
        """Run steps; after a failure, run only those whose condition allows it."""
        succeeded = True
        for step in steps:
            condition = re.sub(r"[${} ]", "", step.get("if", "success()"))
            if {"success()": succeeded, "!cancelled()": True}[condition]:
                succeeded &= self._run_step(step, expression_values, action)
        return succeeded

    def _run_step(self, step: dict[str, Any], expression_values: dict[str, str], action: Path | None) -> bool:
        inputs = {name: fill_expressions(value, expression_values) for name, value in step.get("with", {}).items()}
        if "run" in step:
            return self._run_command(step, expression_values, action)
        name = step["uses"].partition("@")[0]
        if name in PRE_DONE_ACTIONS:
            return True
        if name == "actions/upload-artifact":
            if (self.clone / inputs["path"]).exists():  # otherwise GitHub only warns
                shutil.copytree(self.clone / inputs["path"], self.place / "kept" / inputs["name"])
            elif inputs.get("if-no-files-found") == "error":
                return False
            return True
        return self._run_action(self.actions[name], inputs, step.get("id"))

    def _run_action(self, folder: Path, given_inputs: dict[str, str], name: str | None) -> bool:
        definition = read_yaml(folder / "action.yml")
        assert given_inputs.keys() <= definition["inputs"].keys() and definition["runs"]["using"] == "composite"
        inputs = {
            f"inputs.{key}": given_inputs.get(key, declared.get("default", ""))
            for key, declared in definition["inputs"].items()
        }
        succeeded = self._run_steps(definition["runs"]["steps"], inputs, folder)
        for output, declared in definition.get("outputs", {}).items():
            self.expression_values[f"steps.{name}.outputs.{output}"] = fill_expressions(declared["value"], inputs)
        return succeeded

    def _run_command(self, step: dict[str, Any], expression_values: dict[str, str], action: Path | None) -> bool:
        assert action is None or step["shell"] == "bash"
        output, temporary = self.place / "output", self.place / "temporary"
        temporary.mkdir(exist_ok=True)
        output.write_text("")
        environment = {key: fill_expressions(value, expression_values) for key, value in step.get("env", {}).items()}
        variables = {
            **self.variables, **environment,
            "GITHUB_OUTPUT": str(output), "GITHUB_STEP_SUMMARY": str(self.place / "summary.md"),
            "RUNNER_TEMP": str(temporary), **({"GITHUB_ACTION_PATH": str(action)} if action else {}),
        }  # fmt: skip
        process = self.machine.run(step["run"], self.clone, **variables)
        self.output += [process.stdout, process.stderr]
        for line in output.read_text().splitlines():
            key, _, value = line.partition("=")
            expression_values[f"steps.{step['id']}.outputs.{key}"] = value
        return process.returncode == 0


def expand_component(path: Path, given_inputs: Mapping[str, object]) -> dict[str, Any]:
    """Return the jobs of a GitLab component, with its inputs filled in as GitLab does."""
    header, body = path.read_text(encoding="utf-8").split("\n---\n")
    inputs = YAML(typ="safe").load(header)["spec"]["inputs"]
    assert given_inputs.keys() <= inputs.keys(), "GitLab refuses inputs that a component does not have"
    values = {}
    for name, declared in inputs.items():
        values[name] = given_inputs[name] if name in given_inputs else declared["default"]
        assert isinstance(values[name], bool if declared.get("type") == "boolean" else str)
    text = re.sub(r"\$\[\[ inputs\.([\w-]+) \]\]", lambda match: fill_expressions(values[match[1]], {}), body)
    assert "$[[" not in text
    jobs: dict[str, Any] = YAML(typ="safe").load(text)
    return jobs


def join_script(job: Mapping[str, Any]) -> str:
    """Return the commands of a GitLab job as one script for a shell that stops at the first failure."""
    return "\n".join(job["script"])
