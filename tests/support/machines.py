"""Other machines, as far as this one can be made to look like them: kernels that refuse measures, an ordinary user.

What a kernel refuses is refused by a filter of system calls, as Docker's is, which the program and all that it starts
inherits. Only root can become another user; Python is made readable for that one in a namespace of mounts.
"""

import contextlib
import os
import platform
import struct
import subprocess
import sys
from collections.abc import Collection
from pathlib import Path

from qdot.grader.sandbox.contained import kernel

NOBODY = 65534
DOCKERS_ROOT = 0
KEPT = {0, 1, 3, 4, 5, 6, 7, 8, 10, 13, 18, 27, 29, 31}
"""The capabilities that root has in Docker, if nothing else is said; to mount, or to look into processes, is none."""

CALLS: dict[str, tuple[tuple[int, int], ...]] = {  # on x86_64, on aarch64
    "namespaces": ((272, 97), (308, 268), (165, 40), (166, 39), (155, 41), (442, 442)),
    "landlock": ((444, 444), (445, 445), (446, 446)),
}
"""System calls without which a measure can't be had: unshare, setns, mounts; Landlock's three."""


def _filter(refused: Collection[str]) -> bytes:
    """Return a filter that answers with EPERM."""
    column = {"x86_64": 0, "aarch64": 1}[platform.machine()]
    program = struct.pack("HBBI", 0x20, 0, 0, 0)  # load the number
    for number in (numbers[column] for measure in refused for numbers in CALLS[measure]):
        program += struct.pack("HBBI", 0x15, 0, 1, number) + struct.pack("HBBI", 0x06, 0, 0, 0x00050001)
    return program + struct.pack("HBBI", 0x06, 0, 0, 0x7FFF0000)


def _show_python() -> None:
    """Let everybody read what Python is made of, also where it lies in a folder that is root's alone."""
    kernel.unshare(kernel.NEWNS)
    kernel.mount(None, "/", None, kernel.MS_REC | kernel.MS_PRIVATE)
    for prefix in {sys.prefix, sys.base_prefix, str(Path(__file__).parents[2])}:
        closed = next((p for p in reversed(Path(prefix).parents) if p.stat().st_mode & 0o5 != 0o5), None)
        if closed is not None:
            held = os.open(prefix, os.O_PATH)
            kernel.mount("shown", str(closed), "tmpfs", 0, "mode=755")
            Path(prefix).mkdir(parents=True)
            kernel.mount(f"/proc/self/fd/{held}", prefix, None, kernel.MS_BIND | kernel.MS_REC)
            os.close(held)


def run_on(
    refused: Collection[str],
    program: list[str],
    user: int | None = None,
    home: Path | None = None,
    timeout: float = 120,
) -> "subprocess.CompletedProcess[str]":
    """Run a program of Python where the kernel refuses some measures, as another user if one is given."""

    def become() -> None:
        if user == DOCKERS_ROOT:
            _show_python()
            for number in set(range(64)) - KEPT:
                with contextlib.suppress(OSError):  # there are no more
                    kernel.prctl(kernel.PR_CAPBSET_DROP, number)
        elif user is not None:
            _show_python()
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
        if refused:
            kernel.prctl(kernel.PR_SET_NO_NEW_PRIVS, 1)
            kernel.install_seccomp_filter(_filter(refused))

    environment = {**os.environ, **({"TMPDIR": str(home), "HOME": str(home)} if home else {})}
    return subprocess.run(
        [sys.executable, *program], capture_output=True, text=True, timeout=timeout, preexec_fn=become, env=environment,
        cwd=Path(__file__).parents[2],
    )  # fmt: skip
