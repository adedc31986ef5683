"""A CI as our tests need it: repositories to clone, a fresh environment, and the very commands of a workflow."""

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
from tests.support.programs import needs

GIT = ["git", "-c", "user.name=t", "-c", "user.email=t@example.org", "-c", "init.defaultBranch=main"]


def git(*arguments: str | Path, cwd: Path | None = None) -> str:
    needs("git", GIT_FROM)
    done = subprocess.run([*GIT, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, check=True)
    return done.stdout


def hosted(folder: Path, server: Path, name: str) -> Path:
    """Push what is in a folder to a new repository of a server, and return its path there."""
    bare = server / f"{name}.git"
    git("init", "--quiet", "--bare", bare)
    git("init", "--quiet", folder)
    git("add", "--all", "--force", cwd=folder)
    git("commit", "--quiet", "--message", "first", cwd=folder)
    git("push", "--quiet", bare, "HEAD:refs/heads/main", cwd=folder)
    return bare


def site_of(environment: Path) -> Path:
    """Return where an environment has its libraries."""
    (site,) = environment.glob("lib/python3*/site-packages")
    return site


def lend_pip(environment: Path) -> None:
    """Let an environment that has none use this one's pip."""
    found = importlib.util.find_spec("pip")
    assert found is not None and found.origin is not None
    (site_of(environment) / "pip").symlink_to(Path(found.origin).parent)


def read_yaml(path: Path) -> Any:
    return YAML(typ="safe").load(path.read_text(encoding="utf-8"))


class Machine:
    """A CI's machine: a fresh Python, and only those variables that it is given.

    There is no index of packages: what pip is told to install comes from files, without what it needs; that is lent
    from this environment afterwards. So is pip, before: its own installation takes seconds.
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
        """Let what is installed here be found there."""
        libraries = [path for path in sys.path if Path(path).name == "site-packages"]
        (site_of(self.home / "python") / "lent.pth").write_text("".join(f"{path}\n" for path in libraries), "utf-8")

    def run(self, command: str, cwd: Path, **variables: str) -> subprocess.CompletedProcess[str]:
        """Run a command as GitHub and GitLab do: by bash, which stops at the first failure."""
        done = subprocess.run(
            ["bash", "-e", "-c", command], cwd=cwd, env={**self.variables, **variables}, capture_output=True, text=True
        )
        if " -m pip install " in command:
            assert done.returncode == 0, done.stderr
            self.lend()
        return done


def github_steps(workflow: Path, known: Mapping[str, str]) -> list[tuple[str, dict[str, str]]]:
    """Return the commands of a workflow's only job, each with what its `env` gives it.

    `known` are secrets and variables of the repository; what it has not is empty, as on GitHub.
    """
    (job,) = read_yaml(workflow)["jobs"].values()

    def filled(text: str) -> str:
        return re.sub(r"\$\{\{ (?:secrets|vars)\.(\w+) \}\}", lambda found: known.get(found[1], ""), text)

    found = []
    for step in job["steps"]:
        if "run" in step:
            env = {name: filled(str(value)) for name, value in {**job.get("env", {}), **step.get("env", {})}.items()}
            assert not [value for value in env.values() if "${{" in value]
            found.append((step["run"], env))
    return found


def write_json(path: Path, content: Any) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content), encoding="utf-8")
