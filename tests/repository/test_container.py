"""The grader's container: built by Podman with the commands of docs/container.md, then used to grade a class.

The base is the image in QDOT_BASE (in a CI that reaches a registry), or a Debian that mmdebstrap builds once and Podman
stores. If a machine can't run containers, the tests are skipped with the reason.
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
SERVE_PAGE = (ROOT / "docs" / "serve.md").read_text(encoding="utf-8")
CLUSTERS = (ROOT / "docs" / "scaling.md").read_text(encoding="utf-8")
CONTAINERFILE = (ROOT / "Containerfile").read_text(encoding="utf-8")
IMAGE, BASE = "localhost/qdot", "localhost/qdot-tests-base"
PODMAN = "apt-get install podman runc"
NAMESPACES = ["unshare", "setns", "mount", "umount2", "pivot_root", "mount_setattr"]
LANDLOCK = ["landlock_create_ruleset", "landlock_add_rule", "landlock_restrict_self"]
CONTAINER_USER = 65532


def find_code_blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"(?ms)^```{language}\n(.*?)^```", page)


def test_the_build_context_has_only_the_needed_files() -> None:
    """Other files, such as environments or a class beside the code, stay out of the context."""
    first, *lines = [line for line in (ROOT / ".dockerignore").read_text().splitlines() if not line.startswith("#")]
    included = {line.removeprefix("!") for line in lines if line.startswith("!")}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    folders = project["tool"]["hatch"]["build"]["targets"]["wheel"]["only-include"]
    assert first == "*" and {"pyproject.toml", "constraints.txt", "README.md", "LICENSE"} < included
    assert set(folders) < included
    assert all((ROOT / name).exists() for name in included if not name.startswith("site/dist"))


def test_the_container_runs_as_an_ordinary_user_and_starts_doctor() -> None:
    final = CONTAINERFILE.rpartition("\nFROM ")[2]
    assert f"\nUSER {CONTAINER_USER}:{CONTAINER_USER}\n" in final and 'ENTRYPOINT ["qdot"]\nCMD ["doctor"]' in final
    assert "RUN" not in final and "ADD" not in CONTAINERFILE


def test_the_image_that_serves_is_built_like_the_other() -> None:
    """The tests below build only the image that serves."""
    build, build_to_serve = (re.findall(r"(?m)^    (podman build .*)$", page) for page in (PAGE, SERVE_PAGE))
    assert [command.replace("--build-arg 'EXTRAS=[serve]' ", "") for command in build_to_serve] == build


def test_a_pod_is_restricted_like_the_container() -> None:
    (text,) = find_code_blocks(CLUSTERS, "yaml")[:1]
    spec = YAML(typ="safe").load(text)["spec"]
    pod, (container,) = spec["template"]["spec"], spec["template"]["spec"]["containers"]
    assert container["securityContext"] == {
        "readOnlyRootFilesystem": True, "allowPrivilegeEscalation": False, "capabilities": {"drop": ["ALL"]},
    }  # fmt: skip
    assert pod["securityContext"]["runAsNonRoot"] and pod["securityContext"]["runAsUser"] == CONTAINER_USER
    assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
    assert {mount["mountPath"] for mount in container["volumeMounts"]} == {"/class", "/tmp"}
    assert container["args"][:2] == ["grade", "."]


@dataclass(frozen=True)
class Engine:
    """Podman as this machine can run it, as a wrapper in a separate folder."""

    folder: Path
    secure: Sequence[str] = ()

    def run(self, command: str, cwd: Path) -> "subprocess.CompletedProcess[str]":
        """Run a command with the page's definition of `grader`."""
        define = find_code_blocks(PAGE, "bash")[0].partition("\n}\n")[0] + "\n}\n"
        if self.secure:
            define = define.replace("podman run", shlex.join(["podman", "run", *self.secure]))
        path = f"{self.folder}{os.pathsep}{os.environ['PATH']}"
        return subprocess.run(
            ["bash", "-e", "-c", define + command], cwd=cwd, env={**os.environ, "PATH": path}, capture_output=True,
            text=True, timeout=600,
        )  # fmt: skip

    def succeeds(self, command: str, cwd: Path) -> str:
        process = self.run(command, cwd)
        assert process.returncode == 0, process.stdout + process.stderr
        return process.stdout


def skip_or_fail(reason: str) -> None:
    """Skip a test, or fail in a CI that has a base image."""
    if os.environ.get("CI") and os.environ.get("QDOT_BASE"):
        pytest.fail(reason)
    pytest.skip(reason)


def write_program(path: Path, text: str) -> None:
    path.write_text(f"#!/bin/bash\n{text}")
    path.chmod(0o755)


def write_wrapper(podman: str, base: str) -> str:
    """Return a script around podman that works around this machine's limits, mixed cgroups and missing base image."""
    limits = []
    for name, kind, maximum in (("nofile", resource.RLIMIT_NOFILE, 1 << 20), ("nproc", resource.RLIMIT_NPROC, 1 << 15)):
        hard = resource.getrlimit(kind)[1]
        limits += [f"--ulimit={name}={min(maximum, hard if hard > 0 else maximum)}"]
    mixed = Path("/sys/fs/cgroup/unified").is_dir() and shutil.which("runc")  # crun can't use mixed cgroups
    runtime = ["--runtime", "runc"] if mixed else []
    user_namespace = ["--userns", "keep-id"] if os.geteuid() else []
    build_options = [f"--build-arg=BASE={base}"]
    if certificates := os.environ.get("PIP_CERT"):
        build_options += [
            f"--build-arg=PIP_CERT={certificates}",
            f"--volume={Path(certificates).parent}:{Path(certificates).parent}:ro",
        ]
    run = shlex.join([podman, *runtime, "run", *limits, *user_namespace])
    build = shlex.join(
        [podman, "build", "--isolation", "chroot", "--network", "host", "--layers=false", *build_options]
    )
    return (
        f'case "$1" in run) shift; exec {run} "$@";; build) shift; exec {build} "$@";; *) exec {podman} "$@";; esac\n'
    )


def find_base(podman: str, folder: Path) -> str:
    """Return an image with Python: the one in QDOT_BASE, or a Debian that is built here."""
    if image := os.environ.get("QDOT_BASE"):
        return image
    if subprocess.run([podman, "image", "exists", BASE]).returncode:
        program = require_program(
            "mmdebstrap", "apt-get install mmdebstrap, or name an image in QDOT_BASE", in_ci=False
        )
        sources = [str(path) for path in Path("/etc/apt").glob("sources.list.d/*.sources")] or ["/etc/apt/sources.list"]
        include = "--include=python3,python3-venv"
        suite = platform.freedesktop_os_release().get("VERSION_CODENAME", "stable")  # the release of those sources
        command = [program, "--variant=minbase", include, suite, str(folder / "base.tar"), *sources]
        process = subprocess.run(command, capture_output=True, text=True)
        if process.returncode:
            skip_or_fail(f"mmdebstrap makes no Debian here: {process.stderr.strip().splitlines()[-1:]}")
        subprocess.run([podman, "import", "--quiet", str(folder / "base.tar"), BASE], check=True, capture_output=True)
        (folder / "base.tar").unlink()
    return BASE


@pytest.fixture(scope="module")
def engine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Engine]:
    podman = require_program("podman", PODMAN, in_ci="QDOT_BASE" in os.environ)
    folder = tmp_path_factory.mktemp("engine")
    base = find_base(podman, folder)
    write_program(folder / "podman", write_wrapper(podman, base))
    if os.geteuid() == 0:  # files must belong to an ordinary user
        write_program(folder / "id", f"echo {CONTAINER_USER}\n")
    engine = Engine(folder)
    version_check = engine.run(f"podman run --rm {base} python3 --version", folder)
    if version_check.returncode:
        skip_or_fail(f"podman runs no container here: {version_check.stderr.strip()}")
    download = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", str(folder), "hatchling"]
    if subprocess.run(download, capture_output=True).returncode:
        skip_or_fail("the index of Python's packages can't be reached, which the build of the image asks")
    (build,) = re.findall(r"(?m)^    (podman build .*)$", SERVE_PAGE)
    engine.succeeds(build, ROOT)
    yield engine
    engine.run(f"podman rmi {IMAGE}", folder)


@pytest.fixture
def course(tmp_path: Path) -> Assignment:
    """Return a class of three with two submissions, of which the second tries to read the secret."""
    assignment = make_class(tmp_path / "homework", [Student("ada", "Ada"), Student("bo"), Student("cy")])
    toml = assignment.folder / "assignment.toml"
    toml.write_text(f'sandbox = "strict"\n{toml.read_text()}')
    thief = "p1_determinant = len(open('/class/homework/secret.txt').read())"
    for student, text in (
        ("ada", make_correct_notebook(assignment, "ada")),
        ("bo", make_correct_notebook(assignment, "bo", lambda cells: cells[-1].update(source=thief))),
    ):
        path = assignment.folder / "submitted" / student / "hw.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(text)
    if os.geteuid() == 0:
        subprocess.run(["chown", "-R", f"{CONTAINER_USER}:{CONTAINER_USER}", tmp_path], check=True)
    return load_assignment(assignment.folder)


@pytest.mark.integration
def test_grading_in_the_container_gives_the_same_results(engine: Engine, course: Assignment, tmp_path: Path) -> None:
    outside = shutil.copytree(course.folder, tmp_path / "outside")
    output = engine.succeeds("grader grade homework", tmp_path)
    graded = (course.folder / "graded" / "results.jsonl").read_bytes()
    assert b"3 students: 2 graded, 1 missing" in output.encode(), output
    scores = [json.loads(line)["score"] for line in graded.splitlines()]
    assert scores == [4, 3, 0]  # bo's theft failed
    subprocess.run([sys.executable, "-m", "qdot", "grade", outside], cwd=ROOT, check=True, capture_output=True)
    assert (outside / "graded" / "results.jsonl").read_bytes() == graded
    owners = {path.stat().st_uid for path in (course.folder / "graded").rglob("*")}
    assert owners == {os.geteuid() or CONTAINER_USER}


@pytest.mark.integration
def test_the_container_is_strict_without_capabilities(engine: Engine, tmp_path: Path) -> None:
    report = json.loads(engine.succeeds("grader doctor --json", tmp_path))
    assert report["strict"], report
    assert "this machine can use sandbox" in engine.succeeds("podman run --rm --network none qdot", tmp_path)


def make_filter(names: list[str], folder: Path) -> list[str]:
    """Return the flags for a filter that refuses some system calls, like Docker's."""
    profile = folder / "profile.json"
    refused = {"names": names, "action": "SCMP_ACT_ERRNO", "errnoRet": 1}
    profile.write_text(json.dumps({"defaultAction": "SCMP_ACT_ALLOW", "syscalls": [refused]}))
    return ["--security-opt", f"seccomp={profile}"]


@pytest.mark.integration
def test_the_container_is_strict_without_namespaces(engine: Engine, tmp_path: Path) -> None:
    filtered = Engine(engine.folder, make_filter(NAMESPACES, tmp_path))
    report = json.loads(filtered.succeeds("grader doctor --json", tmp_path))
    assert report["strict"] and set(report["lacking"]) == {"namespaces"}, report


@pytest.mark.integration
def test_the_container_refuses_to_grade_if_notebooks_could_read_the_class(
    engine: Engine, course: Assignment, tmp_path: Path
) -> None:
    weak_engine = Engine(engine.folder, make_filter([*NAMESPACES, *LANDLOCK], tmp_path))
    report = json.loads(weak_engine.succeeds("grader doctor --json", tmp_path))
    assert not report["strict"] and set(report["lacking"]) == {"namespaces", "landlock"}
    process = weak_engine.run("grader grade homework", tmp_path)
    assert process.returncode == 2 and 'requires sandbox = "strict"' in process.stderr, process.stderr
    assert not list(course.folder.glob("graded/results*"))


INSPECTION = """
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
def test_the_container_has_few_files_and_no_rights(engine: Engine, tmp_path: Path) -> None:
    inside = Engine(engine.folder, ["--entrypoint", "/opt/qdot/bin/python"])
    report = json.loads(inside.succeeds(f"grader -c {shlex.quote(INSPECTION)}", tmp_path))
    assert report == {
        "user": os.geteuid() or CONTAINER_USER, "pip": False, "tests": 0, "uncompiled": [], "written": [],
        "network": "OSError", "rights": ["0" * 16] * 2,
    }  # fmt: skip


REQUEST = """
import time, urllib.error, urllib.request

request = urllib.request.Request("http://127.0.0.1:8000/", headers={"Host": "qdot.example.edu"})
for _ in range(120):
    try:
        print(urllib.request.urlopen(request).read().decode())
        break
    except urllib.error.URLError:
        time.sleep(1)
"""
"""A program that asks the service in the same container for its first page, and waits until it answers."""


@pytest.mark.integration
@pytest.mark.skipif(not (ROOT / "site/dist/.vite/manifest.json").exists(), reason="the pages are not built: make site")
def test_the_container_serves_a_class(engine: Engine, course: Assignment, tmp_path: Path) -> None:
    serving = Engine(engine.folder, ["--detach", "--name", "qdot-serve-test"])
    serving.succeeds(f"grader serve {course.folder.name} --host 0.0.0.0 --url https://qdot.example.edu", tmp_path)
    try:
        ask = f"podman exec qdot-serve-test /opt/qdot/bin/python -c {shlex.quote(REQUEST)}"
        assert "personal link" in engine.succeeds(ask, tmp_path)
    finally:
        engine.run("podman stop qdot-serve-test", tmp_path)
