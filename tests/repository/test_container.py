"""The grader's container: built by Podman as docs/container.md says, and a class graded in it by the page's commands.

The base is an image that QDOT_BASE names (a CI that reaches a registry), else a Debian of its own packages, which
mmdebstrap makes once and Podman keeps. What a machine has too little of to run a container says so, and is skipped.
"""

import json
import os
import platform
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from tests.support import ROOT
from tests.support.programs import require_program
from tests.support.submitting import make_class, make_correct_notebook

PAGE = (ROOT / "docs" / "container.md").read_text(encoding="utf-8")
CLUSTERS = (ROOT / "docs" / "scaling.md").read_text(encoding="utf-8")
CONTAINERFILE = (ROOT / "Containerfile").read_text(encoding="utf-8")
IMAGE, BASE = "localhost/qdot", "localhost/qdot-tests-base"
PODMAN = "apt-get install podman runc"
NAMESPACES = ["unshare", "setns", "mount", "umount2", "pivot_root", "mount_setattr"]
LANDLOCK = ["landlock_create_ruleset", "landlock_add_rule", "landlock_restrict_self"]
SOMEBODY = 65532


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"(?ms)^```{language}\n(.*?)^```", page)


# --- without a container ---


def test_what_it_is_built_from_and_a_wheel_too_is_let_into_the_build() -> None:
    """What is not on the list is no part of the context: no environment, and no class beside the code."""
    first, *lines = [line for line in (ROOT / ".dockerignore").read_text().splitlines() if not line.startswith("#")]
    shown = {line.removeprefix("!") for line in lines if line.startswith("!")}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = project["tool"]["hatch"]["build"]["targets"]["wheel"]["only-include"]
    assert first == "*" and {"pyproject.toml", "constraints.txt", "README.md", "LICENSE"} < shown
    assert set(folders) - {"site/dist"} < shown
    assert all((ROOT / name).exists() for name in shown)


def test_it_runs_as_nobody_and_says_first_what_it_enforces() -> None:
    final = CONTAINERFILE.rpartition("\nFROM ")[2]
    assert f"\nUSER {SOMEBODY}:{SOMEBODY}\n" in final and 'ENTRYPOINT ["qdot"]\nCMD ["doctor"]' in final
    assert "RUN" not in final and "ADD" not in CONTAINERFILE


def test_a_pod_is_held_as_the_container_is() -> None:
    (text,) = blocks(CLUSTERS, "yaml")[:1]
    spec = YAML(typ="safe").load(text)["spec"]
    pod, (one,) = spec["template"]["spec"], spec["template"]["spec"]["containers"]
    assert one["securityContext"] == {
        "readOnlyRootFilesystem": True, "allowPrivilegeEscalation": False, "capabilities": {"drop": ["ALL"]},
    }  # fmt: skip
    assert pod["securityContext"]["runAsNonRoot"] and pod["securityContext"]["runAsUser"] == SOMEBODY
    assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
    assert {each["mountPath"] for each in one["volumeMounts"]} == {"/class", "/tmp"}
    assert one["args"][:2] == ["grade", "."]


# --- with one ---


@dataclass(frozen=True)
class Engine:
    """Podman as this machine can run it, under its own name in a folder of its own."""

    folder: Path
    secure: Sequence[str] = ()

    def run(self, command: str, cwd: Path) -> "subprocess.CompletedProcess[str]":
        """Run what the page says, with `grader` as it defines it."""
        define = blocks(PAGE, "bash")[0].partition("\n}\n")[0] + "\n}\n"
        if self.secure:
            define = define.replace("podman run", shlex.join(["podman", "run", *self.secure]))
        path = f"{self.folder}{os.pathsep}{os.environ['PATH']}"
        return subprocess.run(
            ["bash", "-e", "-c", define + command], cwd=cwd, env={**os.environ, "PATH": path}, capture_output=True,
            text=True, timeout=600,
        )  # fmt: skip

    def succeeds(self, command: str, cwd: Path) -> str:
        done = self.run(command, cwd)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout


def unable(said: str) -> None:
    """Skip a test, or fail where a CI has a base for it."""
    if os.environ.get("CI") and os.environ.get("QDOT_BASE"):
        pytest.fail(said)
    pytest.skip(said)


def program(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/bash\n{text}")
    path.chmod(0o755)


def wrapper(podman: str, base: str) -> str:
    """Return a podman that gives what this machine lacks: rights to raise limits, cgroups of one kind, a known base."""
    limits = []
    for name, kind, most in (("nofile", resource.RLIMIT_NOFILE, 1 << 20), ("nproc", resource.RLIMIT_NPROC, 1 << 15)):
        hard = resource.getrlimit(kind)[1]
        limits += [f"--ulimit={name}={min(most, hard if hard > 0 else most)}"]
    mixed = Path("/sys/fs/cgroup/unified").is_dir() and shutil.which("runc")  # crun takes no cgroups of both kinds
    runtime = ["--runtime", "runc"] if mixed else []
    kept = ["--userns", "keep-id"] if os.geteuid() else []
    given = [f"--build-arg=BASE={base}"]
    if certificates := os.environ.get("PIP_CERT"):
        given += [
            f"--build-arg=PIP_CERT={certificates}",
            f"--volume={Path(certificates).parent}:{Path(certificates).parent}:ro",
        ]
    run = shlex.join([podman, *runtime, "run", *limits, *kept])
    build = shlex.join([podman, "build", "--isolation", "chroot", "--network", "host", "--layers=false", *given])
    return (
        f'case "$1" in run) shift; exec {run} "$@";; build) shift; exec {build} "$@";; *) exec {podman} "$@";; esac\n'
    )


def base_of(podman: str, folder: Path) -> str:
    """Return an image with Python: the one that QDOT_BASE names, else a Debian that is made here."""
    if named := os.environ.get("QDOT_BASE"):
        return named
    if subprocess.run([podman, "image", "exists", BASE]).returncode:
        program = require_program(
            "mmdebstrap", "apt-get install mmdebstrap, or name an image in QDOT_BASE", in_ci=False
        )
        sources = [str(path) for path in Path("/etc/apt").glob("sources.list.d/*.sources")] or ["/etc/apt/sources.list"]
        include = "--include=python3,python3-venv"
        suite = platform.freedesktop_os_release().get("VERSION_CODENAME", "stable")  # those sources are of this one
        made = [program, "--variant=minbase", include, suite, str(folder / "base.tar"), *sources]
        done = subprocess.run(made, capture_output=True, text=True)
        if done.returncode:
            unable(f"mmdebstrap makes no Debian here: {done.stderr.strip().splitlines()[-1:]}")
        subprocess.run([podman, "import", "--quiet", str(folder / "base.tar"), BASE], check=True, capture_output=True)
        (folder / "base.tar").unlink()
    return BASE


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    """Podman, with the image built by it as the page says."""
    podman = require_program("podman", PODMAN, in_ci="QDOT_BASE" in os.environ)
    folder = tmp_path_factory.mktemp("engine")
    base = base_of(podman, folder)
    program(folder / "podman", wrapper(podman, base))
    if os.geteuid() == 0:  # what is written is to be somebody's who is not root
        program(folder / "id", f"echo {SOMEBODY}\n")
    made = Engine(folder)
    tried = made.run(f"podman run --rm {base} python3 --version", folder)
    if tried.returncode:
        unable(f"podman runs no container here: {tried.stderr.strip()}")
    asked = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(folder), "hatchling"]
    if subprocess.run(asked, capture_output=True).returncode:
        unable("the index of Python's packages can't be reached, which the build of the image asks")
    (build,) = re.findall(r"(?m)^    (podman build .*)$", PAGE)
    made.succeeds(build, ROOT)
    yield made
    made.run(f"podman rmi {IMAGE}", folder)


@pytest.fixture
def course(tmp_path: Path) -> Assignment:
    """A class of three, two of whom have handed in; the second is out for the key."""
    made = make_class(tmp_path / "homework", [Student("ada", "Ada"), Student("bo"), Student("cy")])
    toml = made.folder / "assignment.toml"
    toml.write_text(f'sandbox = "strict"\n{toml.read_text()}')
    thief = "p1_determinant = len(open('/class/homework/secret.txt').read())"
    for student, text in (
        ("ada", make_correct_notebook(made, "ada")),
        ("bo", make_correct_notebook(made, "bo", lambda cells: cells[-1].update(source=thief))),
    ):
        handed_in = made.folder / "submitted" / student / "hw.ipynb"
        handed_in.parent.mkdir(parents=True)
        handed_in.write_text(text)
    if os.geteuid() == 0:
        subprocess.run(["chown", "-R", f"{SOMEBODY}:{SOMEBODY}", tmp_path], check=True)
    return load_assignment(made.folder)


@pytest.mark.integration
def test_a_class_is_graded_in_it_as_outside(engine: Engine, course: Assignment, tmp_path: Path) -> None:
    outside = shutil.copytree(course.folder, tmp_path / "outside")
    said = engine.succeeds("grader grade homework", tmp_path)
    graded = (course.folder / "graded" / "results.jsonl").read_bytes()
    assert b"3 students: 2 graded, 1 missing" in said.encode(), said
    scores = [json.loads(line)["score"] for line in graded.splitlines()]
    assert scores == [4, 3, 0]  # what bo's last cell was after is no answer
    subprocess.run([sys.executable, "-m", "qdot", "grade", outside], cwd=ROOT, check=True, capture_output=True)
    assert (outside / "graded" / "results.jsonl").read_bytes() == graded
    owners = {path.stat().st_uid for path in (course.folder / "graded").rglob("*")}
    assert owners == {os.geteuid() or SOMEBODY}


@pytest.mark.integration
def test_it_is_strict_with_all_rights_dropped_and_no_filter_of_its_own(engine: Engine, tmp_path: Path) -> None:
    found = json.loads(engine.succeeds("grader doctor --json", tmp_path))
    assert found["strict"], found
    assert "this machine can use sandbox" in engine.succeeds("podman run --rm --network none qdot", tmp_path)


def refusing(names: list[str], folder: Path) -> list[str]:
    """Return the flag for a filter that refuses some system calls, as Docker's does."""
    profile = folder / "profile.json"
    refused = {"names": names, "action": "SCMP_ACT_ERRNO", "errnoRet": 1}
    profile.write_text(json.dumps({"defaultAction": "SCMP_ACT_ALLOW", "syscalls": [refused]}))
    return ["--security-opt", f"seccomp={profile}"]


@pytest.mark.integration
def test_it_is_strict_where_namespaces_are_refused(engine: Engine, tmp_path: Path) -> None:
    found = json.loads(Engine(engine.folder, refusing(NAMESPACES, tmp_path)).succeeds("grader doctor --json", tmp_path))
    assert found["strict"] and set(found["lacking"]) == {"namespaces"}, found


@pytest.mark.integration
def test_it_refuses_to_grade_where_notebooks_could_read_the_class(
    engine: Engine, course: Assignment, tmp_path: Path
) -> None:
    old = Engine(engine.folder, refusing([*NAMESPACES, *LANDLOCK], tmp_path))
    found = json.loads(old.succeeds("grader doctor --json", tmp_path))
    assert not found["strict"] and set(found["lacking"]) == {"namespaces", "landlock"}
    done = old.run("grader grade homework", tmp_path)
    assert done.returncode == 2 and 'requires sandbox = "strict"' in done.stderr, done.stderr
    assert not list(course.folder.glob("graded/results*"))


INSIDE = """
import json, os, pathlib, socket, sys
def refused(action):
    try:
        action()
    except OSError as error:
        return type(error).__name__
found = dict(
    user=os.getuid(), pip=bool(list(pathlib.Path("/opt").rglob("pip"))),
    tests=len(list(pathlib.Path("/opt").rglob("tests"))),
    uncompiled=[str(p) for p in pathlib.Path("/opt/qdot").rglob("grader/*.py")
                if not list(p.parent.glob(f"__pycache__/{p.stem}.*.pyc"))],
    written=[where for where in ("/", "/opt/qdot", "/usr/bin", "/etc") if not refused(pathlib.Path(where, "x").touch)],
    network=refused(lambda: socket.create_connection(("192.0.2.1", 80), 2)),
    rights=[line.split()[1] for line in open("/proc/self/status") if line.startswith(("CapEff", "CapBnd"))],
)
print(json.dumps(found))
"""


@pytest.mark.integration
def test_what_is_in_it_and_what_it_may(engine: Engine, tmp_path: Path) -> None:
    inside = Engine(engine.folder, ["--entrypoint", "/opt/qdot/bin/python"])
    found = json.loads(inside.succeeds(f"grader -c {shlex.quote(INSIDE)}", tmp_path))
    assert found == {
        "user": os.geteuid() or SOMEBODY, "pip": False, "tests": 0, "uncompiled": [], "written": [],
        "network": "OSError", "rights": ["0" * 16] * 2,
    }  # fmt: skip
