"""A CI for tests: repositories to clone, a fresh environment, and the commands of a workflow."""

import importlib.util
import json
import os
import re
import subprocess
import sys
import venv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from tests.support.programs import GIT as GIT_FROM
from tests.support.programs import require_program

GIT = ["git", "-c", "user.name=t", "-c", "user.email=t@example.org", "-c", "init.defaultBranch=main"]


def git(*arguments: str | Path, cwd: Path | None = None) -> str:
    require_program("git", GIT_FROM)
    process = subprocess.run([*GIT, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, check=True)
    return process.stdout


def push_to_new_repository(folder: Path, server: Path, name: str) -> Path:
    bare = server / f"{name}.git"
    git("init", "--quiet", "--bare", bare)
    git("init", "--quiet", folder)
    git("add", "--all", "--force", cwd=folder)
    git("commit", "--quiet", "--message", "first", cwd=folder)
    git("push", "--quiet", bare, "HEAD:refs/heads/main", cwd=folder)
    return bare


def find_site_packages(environment: Path) -> Path:
    (site,) = environment.glob("lib/python3*/site-packages")
    return site


def lend_pip(environment: Path) -> None:
    """Let an environment without pip use the pip of the environment that runs the tests."""
    spec = importlib.util.find_spec("pip")
    assert spec is not None and spec.origin is not None
    (find_site_packages(environment) / "pip").symlink_to(Path(spec.origin).parent)


def read_yaml(path: Path) -> Any:
    return YAML(typ="safe").load(path.read_text(encoding="utf-8"))


class Machine:
    """A CI machine: a fresh Python, and only the environment variables that are passed.

    There is no package index: pip installs from files, without their dependencies. The environment that runs the tests
    lends these afterwards. It also lends pip, because installing pip takes seconds.
    """

    def __init__(self, folder: Path) -> None:
        self.home = folder
        venv.create(folder / "python", with_pip=False, symlinks=True)
        lend_pip(folder / "python")
        self.variables = {
            "PATH": f"{folder / 'python' / 'bin'}{os.pathsep}/usr/local/bin{os.pathsep}/usr/bin{os.pathsep}/bin",
            "HOME": str(folder), "LANG": "C.UTF-8", "PIP_NO_DEPS": "1", "PIP_NO_INDEX": "1",
            "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        }  # fmt: skip

    def lend(self) -> None:
        libraries = [path for path in sys.path if Path(path).name == "site-packages"]
        path_file = find_site_packages(self.home / "python") / "lent.pth"
        path_file.write_text("".join(f"{library}\n" for library in libraries), "utf-8")

    def run(self, command: str, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
        process = subprocess.run(
            ["bash", "-e", "-c", command], cwd=cwd, env={**self.variables, **variables}, capture_output=True, text=True
        )
        if " -m pip install " in command:
            assert process.returncode == 0, process.stderr
            self.lend()
        return process


def list_github_steps(workflow: Path, repository_values: Mapping[str, str]) -> list[tuple[str, dict[str, str]]]:
    """Return the commands of a workflow's only job, each with its environment variables.

    `repository_values` has the repository's secrets and variables; missing ones are empty, as on GitHub.
    """
    (job,) = read_yaml(workflow)["jobs"].values()

    def fill(text: str) -> str:
        return re.sub(r"\$\{\{ (?:secrets|vars)\.(\w+) \}\}", lambda match: repository_values.get(match[1], ""), text)

    steps = []
    for step in job["steps"]:
        if "run" in step:
            env = {name: fill(str(value)) for name, value in {**job.get("env", {}), **step.get("env", {})}.items()}
            assert not [value for value in env.values() if "${{" in value]
            steps.append((step["run"], env))
    return steps


def write_json(path: Path, content: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content), encoding="utf-8")
