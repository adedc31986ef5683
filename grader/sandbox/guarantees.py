"""Find out which guarantees this machine can give while students' code runs, and what enforces each guarantee.

A probe runs in a sandbox in place of a notebook, without the audit hook, and tries to break each guarantee. The kernel
enforces a guarantee if every attempt against the guarantee fails.
"""

import contextlib
import os
import socket
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from qdot.exercises.common.console import note
from qdot.exercises.common.errors import QdotError
from qdot.grader.sandbox.notebook_process.escape_attempts import SEPARATE_ATTEMPTS
from qdot.grader.sandbox.sandbox import WINDOWS_MESSAGE, Limits, Sandbox, check_system

ENFORCED_BY_KERNEL, WATCHED_IN_PYTHON, NOT_ENFORCED = "enforced by the kernel", "watched in Python only", "missing"
"""How this machine may enforce a guarantee."""


@dataclass(frozen=True)
class Promise:
    """What qdot promises about a notebook.

    `text` completes the sentence "a notebook …". `measures` are the names of the measures that keep the promise, as in
    `MEASURES`. If "watch" is one of them, Python's audit hook reports what the promise forbids.
    """

    text: str
    measures: tuple[str, ...]


PROMISES = {
    "files": Promise(
        "reads only Python and its libraries, and writes only into its own folder (64 MB), which is then removed",
        ("namespaces", "landlock", "seccomp", "user", "quota", "watch")),
    "network": Promise(
        "can't use the network or connect to a socket of this machine",
        ("namespaces", "seccomp", "landlock", "watch")),
    "processes": Promise(
        "can't start programs or reach other processes; its own processes end with it",
        ("seccomp", "namespaces", "limits", "watch")),
    "memory": Promise("can't use more memory than its limit", ("limits", "seccomp", "namespaces")),
    "time": Promise("is killed when it has used its processor time", ("limits",)),
    "privileges": Promise("has no root privileges and can't gain any", ("privileges", "seccomp", "user")),
}  # fmt: skip
"""Maps the name of each guarantee to what qdot promises about a notebook."""

_ALLOW_NAMESPACES = (
    "Allow user namespaces: sysctl kernel.apparmor_restrict_unprivileged_userns=0 (Ubuntu), "
    "kernel.unprivileged_userns_clone=1 (Debian). A container with Landlock does not need them"
)


class Measure(NamedTuple):
    """A measure: its readable name, and how to make it available."""

    title: str
    remedy: str


MEASURES = {
    "landlock": Measure(
        "Landlock", "Use Linux 5.13 or later with Landlock enabled ('landlock' in the kernel parameter lsm=)"
    ),
    "seccomp": Measure("seccomp", "Use Linux on x86_64 or aarch64 with seccomp filters enabled"),
    "namespaces": Measure("namespaces", _ALLOW_NAMESPACES),
    "user": Measure("not root", "Run qdot as an ordinary user, or install Python in a folder that all users can read"),
    "privileges": Measure("no_new_privs, no capabilities", "Run qdot on Linux as an ordinary user"),
    "limits": Measure("rlimits", "Raise the hard limits (ulimit -H), or use Linux"),
    "quota": Measure("count of written bytes", ""),
    "watch": Measure("audit hook", ""),
}
"""Maps the name of each measure to the measure.

Namespaces give each notebook a private root of limited size, so only a machine without them needs the quota.
"""


@dataclass(frozen=True)
class Guarantee:
    """How this machine keeps the promise in `PROMISES` with this `name`; `promise` is its text.

    `enforcement` is one of the values above, such as `ENFORCED_BY_KERNEL`. `means` are the titles of the measures that
    this machine has. `achieved` lists what the probe achieved against the guarantee.
    """

    name: str
    promise: str
    enforcement: str = field(metadata={"alias": "by"})
    means: tuple[str, ...]
    achieved: tuple[str, ...]


@dataclass(frozen=True)
class Findings:
    """All guarantees of this machine; `lacking` maps each measure that is not available to the reason."""

    guarantees: tuple[Guarantee, ...]
    lacking: dict[str, str]

    @property
    def is_strict(self) -> bool:
        """Whether the kernel enforces all guarantees."""
        return all(guarantee.enforcement == ENFORCED_BY_KERNEL for guarantee in self.guarantees)


def probe(disabled_measures: Iterable[str] = (), quick: bool = False) -> Findings:
    """Try to break out of a sandbox on this machine, and return the findings. Raises QdotError if no sandbox works.

    A full probe computes for a second, until it exceeds its processor time and is killed; a quick probe does not. Tests
    switch off `disabled_measures`.
    """
    if not hasattr(os, "fork"):
        guarantees = tuple(Guarantee(name, promise.text, NOT_ENFORCED, (), ()) for name, promise in PROMISES.items())
        return Findings(guarantees, {"system": WINDOWS_MESSAGE})
    achievements: dict[str, list[str]] = {name: [] for name in PROMISES}
    tested_guarantees: set[str] = set()

    def record_line(line: dict[str, Any]) -> None:
        tested_guarantees.add(line["guarantee"])
        if line["achieved"]:
            achievements[line["guarantee"]].append(line["achieved"])

    limits = Limits(seconds=10, memory=1 << 30)
    sandbox = Sandbox(limits, disabled_measures, load_libraries=False, processor_seconds=1)
    with _make_targets() as targets, sandbox:
        targets |= {"memory": limits.memory, "seconds": 0 if quick else 1, "separate_attempt": None}
        end = sandbox.exchange({"attempts": targets}, record_line)
        expected_end = "done" if quick else "killed"
        if end not in (expected_end, "overtime") or not tested_guarantees >= PROMISES.keys() - {"time"}:
            reason = f": {sandbox.not_started_reason}" if sandbox.not_started_reason else ""
            raise QdotError(f"the sandbox does not work on this machine: its probe ended early ({end}{reason})")
        if sandbox.has_left_processes:
            achievements["processes"].append("left processes running")
        unavailable_measures = sandbox.unavailable_measures
        for number in range(len(SEPARATE_ATTEMPTS)):
            targets |= {"seconds": 0, "separate_attempt": number}
            if sandbox.exchange({"attempts": targets}, record_line) == "lost":
                achievements["processes"].append("killed the process that starts notebooks")
        if sandbox.has_left_files:
            achievements["files"].append("left files behind")
    if end == "overtime" and not achievements["time"]:
        achievements["time"].append("computed until it was killed from outside")
    guarantees = tuple(_make_guarantee(name, achievements[name], unavailable_measures) for name in PROMISES)
    return Findings(guarantees, unavailable_measures)


def _make_guarantee(name: str, achievements: list[str], unavailable_measures: dict[str, str]) -> Guarantee:
    """Return how a guarantee is enforced, judging by what the probe achieved against it."""
    available_measures = [measure for measure in PROMISES[name].measures if measure not in unavailable_measures]
    if "namespaces" not in unavailable_measures and "quota" in available_measures:
        available_measures.remove("quota")  # the notebook's own file system has a limited size, so nothing is counted
    titles = tuple(MEASURES[measure].title for measure in available_measures)
    enforcement_in_python = WATCHED_IN_PYTHON if "watch" in available_measures else NOT_ENFORCED
    enforcement = enforcement_in_python if achievements else ENFORCED_BY_KERNEL
    return Guarantee(name, PROMISES[name].text, enforcement, titles, tuple(achievements))


@contextlib.contextmanager
def _make_targets() -> Iterator[dict[str, Any]]:
    """Yield what a probe attacks: a file, a world-writable folder, a port, a socket and this process."""
    with (
        tempfile.TemporaryDirectory(prefix="qdot-prey-") as folder,
        socket.create_server(("127.0.0.1", 0)) as server,
        socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as local_socket,
    ):
        file, writable_folder = Path(folder, "secret.txt"), Path(folder, "open")
        file.write_text("the secret", encoding="utf-8")
        writable_folder.mkdir()
        for path, mode in ((Path(folder), 0o755), (file, 0o644), (writable_folder, 0o777)):
            path.chmod(mode)  # any user may read and write here, so only the sandbox can keep a notebook out
        address = f"\0qdot-{os.getpid()}" if sys.platform == "linux" else str(Path(folder, "socket"))
        local_socket.bind(address)
        local_socket.listen()
        port = server.getsockname()[1]
        yield {"file": str(file), "folder": str(writable_folder), "port": port, "socket": address, "pid": os.getpid()}


def check_sandbox(must_be_strict: bool) -> str:
    """Return a warning about the guarantees that the kernel does not enforce; "" if it enforces all.

    Raises QdotError if no notebook can run on this system, or if `must_be_strict` and there would be a warning.
    """
    check_system()
    findings = probe(quick=not must_be_strict)
    if findings.is_strict:
        return ""
    weak_guarantees = [guarantee for guarantee in findings.guarantees if guarantee.enforcement != ENFORCED_BY_KERNEL]
    description = ", ".join(f"{guarantee.name}: {guarantee.enforcement}" for guarantee in weak_guarantees)
    if not must_be_strict:
        return f"The sandbox on this machine is weaker than it should be ({description}); see `qdot doctor`."
    weak_measures = {measure for guarantee in weak_guarantees for measure in PROMISES[guarantee.name].measures}
    missing_measures = weak_measures & findings.lacking.keys()
    remedies = [measure.remedy for name, measure in MEASURES.items() if measure.remedy and name in missing_measures]
    raise QdotError(
        f'assignment.toml requires sandbox = "strict", but this machine can\'t enforce it ({description}). '
        f"{'; '.join(remedies) or 'Run qdot on another machine'}. For details, run `qdot doctor`; nothing was run"
    )


def note_sandbox_weakness(must_be_strict: bool) -> None:
    """Print a note on what this machine's sandbox does not enforce. Raises QdotError as `check_sandbox` does."""
    if warning := check_sandbox(must_be_strict):
        note(warning)


def list_remedies(findings: Findings) -> list[str]:
    """Return a line for each measure that is not available here: the reason, and how to make it available."""
    pairs = [(MEASURES.get(name, Measure(name, "")), reason) for name, reason in findings.lacking.items()]
    return [f"{measure.title}: not available ({reason}). {measure.remedy}".strip() for measure, reason in pairs]
