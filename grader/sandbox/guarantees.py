"""The guarantees of this machine while students' code runs: a probe tests each one and finds out what enforces it.

The kernel enforces a guarantee if it refused everything that the probe tried without the audit hook.
"""

import contextlib
import os
import socket
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from qdot.exercises.common.errors import QdotError
from qdot.grader.sandbox.contained.attempts import SEPARATE_ATTEMPTS
from qdot.grader.sandbox.sandbox import REFUSED, Limits, Sandbox

ENFORCED_BY_KERNEL, WATCHED_IN_PYTHON, NOT_ENFORCED = "enforced by the kernel", "watched in Python only", "missing"
"""How a guarantee is enforced on this machine."""


@dataclass(frozen=True)
class Promise:
    """What is guaranteed about a notebook: a phrase, the measures, and whether Python's audit hook watches it."""

    text: str
    measures: tuple[str, ...]
    is_watched: bool = False


GUARANTEES = {
    "files": Promise(
        "reads only Python and its libraries, and writes only into its own folder (64 MB), which is then removed",
        ("namespaces", "landlock", "seccomp", "user", "quota", "watch"), True,
    ),
    "network": Promise(
        "can't use the network or connect to a socket of this machine",
        ("namespaces", "seccomp", "landlock", "watch"), True,
    ),
    "processes": Promise(
        "can't start programs or reach other processes; its own processes end with it",
        ("seccomp", "namespaces", "limits", "watch"), True,
    ),
    "memory": Promise("can't use more memory than its limit", ("limits", "seccomp", "namespaces")),
    "time": Promise("can't use more processor time than its limit, and is then killed", ("limits",)),
    "privileges": Promise("has no root privileges and can't gain any", ("privileges", "seccomp", "user")),
}  # fmt: skip
"""What is guaranteed about a notebook, by the name of the guarantee."""

_ALLOW_NAMESPACES = (
    "Allow user namespaces: sysctl kernel.apparmor_restrict_unprivileged_userns=0 (Ubuntu), "
    "kernel.unprivileged_userns_clone=1 (Debian). A container with Landlock does not need them"
)
MEASURES = {
    "landlock": ("Landlock", "Use Linux 5.13 or later with Landlock enabled ('landlock' in the kernel parameter lsm=)"),
    "seccomp": ("seccomp", "Use Linux on x86_64 or aarch64 with seccomp filters enabled"),
    "namespaces": ("namespaces", _ALLOW_NAMESPACES),
    "user": ("not root", "Run qdot as an ordinary user, or install Python in a folder that all users can read"),
    "privileges": ("no_new_privs, no capabilities", "Run qdot on Linux as an ordinary user"),
    "limits": ("rlimits", "Raise the hard limits (ulimit -H), or use Linux"),
    "quota": ("count of written bytes", ""),
    "watch": ("audit hook", ""),
}
"""The readable name of each measure, and how to make the measure available."""


@dataclass(frozen=True)
class Guarantee:
    """One guarantee: what enforces it on this machine (`by`), the measures used, and what the probe still achieved."""

    name: str
    promise: str
    by: str
    means: tuple[str, ...]
    achieved: tuple[str, ...]


@dataclass(frozen=True)
class Findings:
    """All guarantees, and the measures that are not available here, each with the reason."""

    guarantees: tuple[Guarantee, ...]
    lacking: dict[str, str]

    @property
    def is_strict(self) -> bool:
        """Whether the kernel enforces all guarantees."""
        return all(guarantee.by == ENFORCED_BY_KERNEL for guarantee in self.guarantees)

    def as_json(self) -> dict[str, Any]:
        """Return the findings as data."""
        return {"strict": self.is_strict, **asdict(self)}


def probe(disabled_measures: Iterable[str] = (), quick: bool = False) -> Findings:
    """Try to break out of a sandbox on this machine, and return the findings. Raises QdotError if no sandbox works.

    A full probe computes for a second, until it is stopped for its processor time; a quick probe does not.
    """
    if not hasattr(os, "fork"):
        guarantees = tuple(Guarantee(name, promise.text, NOT_ENFORCED, (), ()) for name, promise in GUARANTEES.items())
        return Findings(guarantees, {"system": REFUSED})
    achievements: dict[str, list[str]] = {name: [] for name in GUARANTEES}
    limits = Limits(seconds=10, memory=1 << 30)
    started = Sandbox(limits, disabled_measures, load_libraries=False, processor_seconds=1)
    with _make_targets() as targets, started as sandbox:
        tested_guarantees: set[str] = set()

        def record_line(line: dict[str, Any]) -> None:
            tested_guarantees.add(line["guarantee"])
            if line["achieved"]:
                achievements[line["guarantee"]].append(line["achieved"])

        probe_targets = {**targets, "memory": limits.memory, "seconds": 0 if quick else 1, "alone": None}
        end = sandbox.exchange({"attempts": probe_targets}, record_line)
        unbegun_reason = sandbox.not_started_reason
        if sandbox.has_left_processes:
            achievements["processes"].append("left processes running")
        lacking_measures = sandbox.unavailable_measures
        for number in range(len(SEPARATE_ATTEMPTS)) if end in EXPECTED_ENDS[quick] else ():
            if sandbox.exchange({"attempts": {**probe_targets, "seconds": 0, "alone": number}}, record_line) == "lost":
                achievements["processes"].append("killed the process that starts notebooks")
        if sandbox.has_left_files:
            achievements["files"].append("left files behind")
    if end not in EXPECTED_ENDS[quick] or not tested_guarantees >= GUARANTEES.keys() - {"time"}:
        reason = f": {unbegun_reason}" if unbegun_reason else ""
        raise QdotError(f"the sandbox does not work on this machine: its probe ended early ({end}{reason})")
    if end == "overtime" and not achievements["time"]:
        achievements["time"].append("computed until it was killed from outside")
    guarantees = tuple(_make_guarantee(name, achievements[name], lacking_measures) for name in GUARANTEES)
    return Findings(guarantees, lacking_measures)


EXPECTED_ENDS = {True: ("done", "overtime"), False: ("killed", "overtime")}
"""How a probe may end if the sandbox works: a quick one (True) and a full one (False)."""


def _make_guarantee(name: str, achieved: list[str], unavailable_measures: dict[str, str]) -> Guarantee:
    """Return a guarantee with what enforces it, judging by what the probe achieved."""
    available_measures = [measure for measure in GUARANTEES[name].measures if measure not in unavailable_measures]
    if "namespaces" not in unavailable_measures and "quota" in available_measures:
        available_measures.remove("quota")  # the notebook's own file system has a limited size, so nothing is counted
    measure_names = tuple(MEASURES[measure][0] for measure in available_measures)
    is_watched = GUARANTEES[name].is_watched and "watch" not in unavailable_measures
    by = ENFORCED_BY_KERNEL if not achieved else WATCHED_IN_PYTHON if is_watched else NOT_ENFORCED
    return Guarantee(name, GUARANTEES[name].text, by, measure_names, tuple(achieved))


@contextlib.contextmanager
def _make_targets() -> Iterator[dict[str, Any]]:
    """Yield the targets that a probe attacks: a file, a world-writable folder, a port, a socket, this process."""
    with (
        tempfile.TemporaryDirectory(prefix="qdot-prey-") as folder,
        socket.create_server(("127.0.0.1", 0)) as server,
        socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as local_socket,
    ):
        file, writable = Path(folder, "secret.txt"), Path(folder, "open")
        file.write_text("the secret", encoding="utf-8")
        writable.mkdir()
        for path, mode in ((Path(folder), 0o755), (file, 0o644), (writable, 0o777)):  # a notebook may run as any user
            path.chmod(mode)
        address = f"\0qdot-{os.getpid()}" if sys.platform == "linux" else str(Path(folder, "socket"))
        local_socket.bind(address)
        local_socket.listen()
        port = server.getsockname()[1]
        yield {"file": str(file), "open": str(writable), "port": port, "abstract": address, "pid": os.getpid()}


def explain_refusal(findings: Findings) -> str:
    """Return why the level "strict" is not available on this machine, and what to do about it."""
    weak_names = [guarantee.name for guarantee in findings.guarantees if guarantee.by != ENFORCED_BY_KERNEL]
    needed = {measure for name in weak_names for measure in GUARANTEES[name].measures} & findings.lacking.keys()
    remedies = [remedy for name, (_, remedy) in MEASURES.items() if remedy and name in needed]
    return (
        'assignment.toml requires sandbox = "strict", but this machine can\'t enforce it '
        f"({_describe_weak_guarantees(findings)}). "
        f"{'; '.join(remedies) or 'Run qdot on another machine'}. For details, run `qdot doctor`; nothing was run"
    )


def describe_weakness(findings: Findings) -> str:
    """Return one line about what this machine does not enforce; empty if it enforces everything."""
    weak_guarantees = _describe_weak_guarantees(findings)
    return (
        f"The sandbox on this machine is weaker than it should be ({weak_guarantees}); see `qdot doctor`."
        if weak_guarantees
        else ""
    )


def _describe_weak_guarantees(findings: Findings) -> str:
    """Return the guarantees that the kernel does not enforce, each with what happens instead."""
    return ", ".join(
        f"{guarantee.name}: {guarantee.by}" for guarantee in findings.guarantees if guarantee.by != ENFORCED_BY_KERNEL
    )


def list_remedies(findings: Findings) -> list[str]:
    """Return a line for each measure that is not available here: the reason, and how to make it available."""
    measures = [(*MEASURES.get(name, (name, "")), reason) for name, reason in findings.lacking.items()]
    return [f"{title}: not available ({reason}). {remedy}".strip() for title, remedy, reason in measures]
