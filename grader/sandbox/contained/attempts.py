"""What a probe tries instead of a notebook, without the audit hook: whatever succeeds is not prevented on this machine.

Attempts that end with the death of their process are made `ALONE`, each in a process of its own.
"""

import contextlib
import ctypes
import mmap
import os
import signal
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from . import kernel

try:
    import fcntl
except ImportError:  # Windows, where this is imported, and never runs
    fcntl = None  # type: ignore[assignment]

MOST, MOST_WRITTEN = 200, 256_000_000
"""Numbers of processes and of bytes that show that nothing limits them; the bytes are four times the quota."""

SOME = 8_000_000
"""Bytes of a file that is not too large by itself."""


class Attempt(NamedTuple):
    """The guarantees that an attempt tests, what it achieves, and an action that raises or returns False if refused."""

    guarantees: str
    achieved: str
    action: Callable[[dict[str, Any]], object]


def make(targets: dict[str, Any], report: Callable[[dict[str, Any]], None]) -> None:
    """Make every attempt, or the one that is `alone`; report what each achieved, "" if it was refused."""
    signal.signal(signal.SIGXCPU, signal.SIG_IGN)
    alone = targets["alone"]
    for attempt in ATTEMPTS if alone is None else (ALONE[alone],):
        try:
            achieved = attempt.achieved if attempt.action(targets) is not False else ""
        except Exception:
            achieved = ""
        for guarantee in attempt.guarantees.split():
            report({"guarantee": guarantee, "achieved": achieved})
    if not targets["seconds"]:
        report({"done": True})
    while time.process_time() < targets["seconds"] + 1:  # until it is killed
        pass
    report({"guarantee": "time", "achieved": f"computed for {targets['seconds'] + 1} s"})


def _alter_library(_: dict[str, Any]) -> None:
    library = os.open(os.__file__, os.O_RDONLY)
    os.fchmod(library, os.fstat(library).st_mode & 0o7777)  # to what they are: nobody is harmed if this succeeds


def _connect_abstract(targets: dict[str, Any]) -> None:
    with socket.socket(socket.AF_UNIX) as end:
        end.connect(targets["abstract"])


def _send(targets: dict[str, Any]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.sendto(b"x", ("127.0.0.1", targets["port"]))


def _signal(targets: dict[str, Any]) -> None:
    if targets["pid"] == os.getpid():  # both are the first in their namespaces, as if the grader is in a container
        raise ProcessLookupError
    os.kill(targets["pid"], 0)


def _trace(targets: dict[str, Any]) -> bool:
    seize = 0x4206  # stops nobody
    return sys.platform == "linux" and ctypes.CDLL(None).ptrace(seize, targets["pid"], 0, 0) == 0


def _start(_: dict[str, Any]) -> None:
    os.waitpid(os.posix_spawn(sys.executable, [sys.executable, "-c", ""], {}), 0)


def _multiply(_: dict[str, Any]) -> bool:
    """Start processes that leave their session and wait; they hold the pipe, which closes when all have ended."""
    for number in range(MOST):
        try:
            pid = os.fork()
        except OSError:
            return False
        if pid == 0:
            os.setsid()
            if number == 0 and os.fork():
                os._exit(0)
            while True:
                signal.pause()
    return True


def _share_memory(_: dict[str, Any]) -> None:
    for size in range(64):
        os.truncate(os.memfd_create(str(size)), 10_000_000)


ATTEMPTS = (
    Attempt("files", "read a file of another user's folder", lambda targets: Path(targets["file"]).read_bytes()),
    Attempt("files", "wrote into another folder", lambda targets: Path(targets["open"], "planted").touch()),
    Attempt("files", "changed the rights of another folder's file", lambda targets: os.chmod(targets["file"], 0o600)),
    Attempt("files", "changed the rights of a library", _alter_library),
    Attempt("files", "listed another folder", lambda targets: os.listdir(Path(targets["file"]).parent)),
    Attempt(
        "network", "connected to a port of this machine",
        lambda targets: socket.create_connection(("127.0.0.1", targets["port"]), timeout=2),
    ),
    Attempt("network", "sent a datagram", _send),
    Attempt("network", "connected to a socket of this machine", _connect_abstract),
    Attempt("processes", "reached the grader with a signal", _signal),
    Attempt("memory", "was given more memory than the limit", lambda targets: mmap.mmap(-1, targets["memory"] + SOME)),
    Attempt("memory", "was given memory that no limit counts", _share_memory),
    Attempt("privileges", "became root of a namespace", lambda _: kernel.unshare(kernel.NEWUSER)),
    Attempt("processes", "reached into the grader's memory", _trace),
    Attempt("processes", "started a program", _start),
    Attempt("privileges", "changed its root folder", lambda _: os.chroot(".")),
    Attempt("privileges", "took precedence over other processes", lambda _: os.nice(-1)),
    Attempt("processes memory", f"started {MOST} processes", _multiply),
)  # fmt: skip
"""The attempts in order; many processes also have the memory of many."""


def _fill(_: dict[str, Any]) -> None:
    with open("large", "wb") as file:
        for _number in range(200):
            file.write(bytes(1 << 20))


def _fill_many(_: dict[str, Any]) -> None:
    """Write many files, none of which is too large by itself."""
    for number in range(MOST_WRITTEN // SOME):
        Path(str(number)).write_bytes(bytes(SOME))


def _fill_nameless(_: dict[str, Any]) -> None:
    """Write many files that have no names any more."""
    kept: list[Any] = []
    while SOME * len(kept) < MOST_WRITTEN:
        kept.append(open("nameless", "wb", buffering=0))  # noqa: SIM115 - it is to stay open
        os.unlink("nameless")
        kept[-1].write(bytes(SOME))


def _nest(_: dict[str, Any]) -> bool:
    """Leave folders that are hard to remove; the grader looks whether they are gone afterwards."""
    os.mkdir("closed")
    os.mkdir("closed/inner", 0)
    with contextlib.suppress(OSError):  # refused where libraries could be closed in this way, too
        os.chmod("closed", 0)
    for _depth in range(1200):
        os.mkdir("d")
        os.chdir("d")
    return False


def _signal_by_descriptor(_: dict[str, Any]) -> bool:
    """Have the kernel kill the process that starts notebooks, as the owner of a pipe in which something arrives."""
    reading, writing = os.pipe()
    fcntl.fcntl(reading, fcntl.F_SETOWN, os.getppid())
    fcntl.fcntl(reading, fcntl.F_SETSIG, signal.SIGKILL)
    fcntl.fcntl(reading, fcntl.F_SETFL, os.O_ASYNC)
    os.write(writing, b"x")
    time.sleep(0.1)
    return False


_WRITTEN = f"{MOST_WRITTEN // 1_000_000} MB"
ALONE = (
    Attempt("files", "wrote a file of 200 MB", _fill), Attempt("files", f"wrote {_WRITTEN} in all", _fill_many),
    Attempt("files", f"wrote {_WRITTEN} into files without names", _fill_nameless), Attempt("files", "", _nest),
    Attempt("processes", "", _signal_by_descriptor),
)  # fmt: skip
"""The attempts that are each made in a process of their own."""
