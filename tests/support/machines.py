"""Make this machine look like another: a kernel that refuses sandbox measures, Docker's root, an ordinary user.

A seccomp filter refuses system calls, as in Docker; the program and its child processes inherit it. Only root can
become another user; a mount namespace makes Python readable for that user.
"""

import contextlib
import os
import platform
import struct
import subprocess
import sys
from collections.abc import Collection
from pathlib import Path

from qdot.grader.sandbox.notebook_process import kernel

NOBODY = 65534
DOCKERS_ROOT = 0
DOCKER_CAPABILITIES = {0, 1, 3, 4, 5, 6, 7, 8, 10, 13, 18, 27, 29, 31}
"""The default capabilities of root in Docker: it can neither mount nor inspect other processes."""

CALLS: dict[str, tuple[tuple[int, int], ...]] = {  # on x86_64, on aarch64
    "namespaces": ((272, 97), (308, 268), (165, 40), (166, 39), (155, 41), (442, 442)),
    "landlock": ((444, 444), (445, 445), (446, 446)),
}
"""The system calls that each measure needs: unshare, setns, mounts; Landlock's three."""


def _make_filter(refused: Collection[str]) -> bytes:
    column = {"x86_64": 0, "aarch64": 1}[platform.machine()]
    program = struct.pack("HBBI", 0x20, 0, 0, 0)  # load the number
    for number in (numbers[column] for measure in refused for numbers in CALLS[measure]):
        program += struct.pack("HBBI", 0x15, 0, 1, number) + struct.pack("HBBI", 0x06, 0, 0, 0x00050001)
    return program + struct.pack("HBBI", 0x06, 0, 0, 0x7FFF0000)


def _make_python_readable() -> None:
    """Let every user read the Python installation, even if only root can read a folder above it."""
    kernel.unshare(kernel.NEWNS)
    kernel.mount(None, "/", None, kernel.MS_REC | kernel.MS_PRIVATE)
    for prefix in {sys.prefix, sys.base_prefix, str(Path(__file__).parents[2])}:
        closed_folder = next((p for p in reversed(Path(prefix).parents) if p.stat().st_mode & 0o5 != 0o5), None)
        if closed_folder is not None:
            descriptor = os.open(prefix, os.O_PATH)
            kernel.mount("shown", str(closed_folder), "tmpfs", 0, "mode=755")
            Path(prefix).mkdir(parents=True)
            kernel.mount(f"/proc/self/fd/{descriptor}", prefix, None, kernel.MS_BIND | kernel.MS_REC)
            os.close(descriptor)


def run_restricted(
    refused: Collection[str], program: list[str], user: int | None = None, home: Path | None = None
) -> "subprocess.CompletedProcess[str]":
    def restrict_process() -> None:
        if user == DOCKERS_ROOT:
            _make_python_readable()
            for number in set(range(64)) - DOCKER_CAPABILITIES:
                with contextlib.suppress(OSError):  # the kernel has fewer capabilities
                    kernel.prctl(kernel.PR_CAPBSET_DROP, number)
        elif user is not None:
            _make_python_readable()
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
        if refused:
            kernel.prctl(kernel.PR_SET_NO_NEW_PRIVS, 1)
            kernel.install_seccomp_filter(_make_filter(refused))

    environment = {**os.environ, **({"TMPDIR": str(home), "HOME": str(home)} if home else {})}
    return subprocess.run(
        [sys.executable, *program], capture_output=True, text=True, timeout=120,
        preexec_fn=restrict_process, env=environment, cwd=Path(__file__).parents[2],
    )  # fmt: skip
