"""What a probe tries instead of a notebook, without the audit hook: whatever succeeds is not prevented on this machine.

Each attempt returns what it achieved, in words; it raises OSError, or another exception, if it was refused. Attempts
that end with the death of their process are made `ALONE`, each in a process of its own.
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
from typing import Any

from . import kernel

try:
    import fcntl
except ImportError:  # Windows, where this is imported, and never runs
    fcntl = None  # type: ignore[assignment]

MOST, MOST_WRITTEN = 200, 256_000_000
"""Numbers of processes and of bytes that show that nothing limits them; the bytes are four times the quota."""


def make(targets: dict[str, Any], report: Callable[[dict[str, Any]], None]) -> None:
    """Make every attempt, or the one that is `alone`; report what each achieved, "" if it was refused."""
    signal.signal(signal.SIGXCPU, signal.SIG_IGN)
    alone = targets["alone"]
    for guarantees, attempt in ATTEMPTS if alone is None else (ALONE[alone],):
        try:
            achieved = attempt(targets)
        except Exception:
            achieved = ""
        for guarantee in guarantees.split():
            report({"guarantee": guarantee, "achieved": achieved})
    if not targets["seconds"]:
        report({"done": True})
    while time.process_time() < targets["seconds"] + 1:  # until it is killed
        pass
    report({"guarantee": "time", "achieved": f"computed for {targets['seconds'] + 1} s"})


def _read(targets: dict[str, Any]) -> str:
    return f"read a file of another user's folder ({len(Path(targets['file']).read_bytes())} bytes)"


def _write(targets: dict[str, Any]) -> str:
    Path(targets["open"], "planted").touch()
    return "wrote into another folder"


def _alter(targets: dict[str, Any]) -> str:
    os.chmod(targets["file"], 0o600)
    return "changed the rights of another folder's file"


def _alter_by_descriptor(_: dict[str, Any]) -> str:
    library = os.open(os.__file__, os.O_RDONLY)
    os.fchmod(library, os.fstat(library).st_mode & 0o7777)  # to what they are: nobody is harmed where this succeeds
    return "changed the rights of a library"


def _list(targets: dict[str, Any]) -> str:
    return f"listed another folder ({len(os.listdir(Path(targets['file']).parent))} files)"


def _fill(targets: dict[str, Any]) -> str:
    with open("large", "wb") as file:
        for _ in range(200):
            file.write(bytes(1 << 20))
    return "wrote a file of 200 MB"


def _fill_many(_: dict[str, Any]) -> str:
    """Write many files, none of which is too large by itself."""
    content = bytes(8_000_000)
    for number in range(MOST_WRITTEN // len(content)):
        Path(str(number)).write_bytes(content)
    return f"wrote {MOST_WRITTEN // 1_000_000} MB in all"


def _fill_nameless(_: dict[str, Any]) -> str:
    """Write many files that have no names any more."""
    kept: list[Any] = []
    content = bytes(8_000_000)
    while len(content) * len(kept) < MOST_WRITTEN:
        kept.append(open("nameless", "wb", buffering=0))  # noqa: SIM115 - it is to stay open
        os.unlink("nameless")
        kept[-1].write(content)
    return f"wrote {MOST_WRITTEN // 1_000_000} MB into files without names"


def _nest(_: dict[str, Any]) -> str:
    """Leave folders that are hard to remove; the grader looks whether they are gone afterwards."""
    os.mkdir("closed")
    os.mkdir("closed/inner", 0)
    with contextlib.suppress(OSError):  # refused where libraries could be closed in this way, too
        os.chmod("closed", 0)
    for _depth in range(1200):
        os.mkdir("d")
        os.chdir("d")
    return ""


def _connect(targets: dict[str, Any]) -> str:
    socket.create_connection(("127.0.0.1", targets["port"]), timeout=2)
    return "connected to a port of this machine"


def _connect_abstract(targets: dict[str, Any]) -> str:
    with socket.socket(socket.AF_UNIX) as end:
        end.connect(targets["abstract"])
    return "connected to a socket of this machine"


def _send(targets: dict[str, Any]) -> str:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.sendto(b"x", ("127.0.0.1", targets["port"]))
    return "sent a datagram"


def _signal(targets: dict[str, Any]) -> str:
    if targets["pid"] == os.getpid():  # both are the first in their namespaces, as where the grader has a container's
        raise ProcessLookupError
    os.kill(targets["pid"], 0)
    return "reached the grader with a signal"


def _signal_by_descriptor(_: dict[str, Any]) -> str:
    """Have the kernel kill the process that starts notebooks, as the owner of a pipe in which something arrives."""
    reading, writing = os.pipe()
    fcntl.fcntl(reading, fcntl.F_SETOWN, os.getppid())
    fcntl.fcntl(reading, fcntl.F_SETSIG, signal.SIGKILL)
    fcntl.fcntl(reading, fcntl.F_SETFL, os.O_ASYNC)
    os.write(writing, b"x")
    time.sleep(0.1)
    return ""


def _start(_: dict[str, Any]) -> str:
    os.waitpid(os.posix_spawn(sys.executable, [sys.executable, "-c", ""], {}), 0)
    return "started a program"


def _multiply(_: dict[str, Any]) -> str:
    """Start processes that leave their session and wait; they hold the pipe, which closes when all have ended."""
    for number in range(MOST):
        try:
            pid = os.fork()
        except OSError:
            return ""
        if pid == 0:
            os.setsid()
            if number == 0 and os.fork():
                os._exit(0)
            while True:
                signal.pause()
    return f"started {MOST} processes"


def _allocate(targets: dict[str, Any]) -> str:
    mmap.mmap(-1, targets["memory"] + (1 << 20)).close()
    return "was given more memory than the limit"


def _share_memory(_: dict[str, Any]) -> str:
    for size in range(64):
        descriptor = os.memfd_create(str(size))
        os.truncate(descriptor, 10_000_000)
    return "was given memory that no limit counts"


def _unshare(_: dict[str, Any]) -> str:
    kernel.unshare(kernel.NEWUSER)
    return "became root of a namespace"


def _trace(targets: dict[str, Any]) -> str:
    if sys.platform != "linux" or ctypes.CDLL(None).ptrace(0x4206, targets["pid"], 0, 0) != 0:  # seize: stops nobody
        raise OSError
    return "reached into the grader's memory"


def _change_root(_: dict[str, Any]) -> str:
    os.chroot(".")
    return "changed its root folder"


def _hurry(_: dict[str, Any]) -> str:
    os.nice(-1)
    return "took precedence over other processes"


Attempt = tuple[str, Callable[[dict[str, Any]], str]]

ATTEMPTS: tuple[Attempt, ...] = (
    ("files", _read), ("files", _write), ("files", _alter), ("files", _alter_by_descriptor), ("files", _list),
    ("network", _connect), ("network", _send), ("network", _connect_abstract), ("processes", _signal),
    ("memory", _allocate), ("memory", _share_memory), ("privileges", _unshare), ("processes", _trace),
    ("processes", _start), ("privileges", _change_root), ("privileges", _hurry), ("processes memory", _multiply),
)  # fmt: skip
"""The attempts in order, each with the guarantees that it tests: many processes also have the memory of many."""

ALONE: tuple[Attempt, ...] = (
    ("files", _fill), ("files", _fill_many), ("files", _fill_nameless), ("files", _nest),
    ("processes", _signal_by_descriptor),
)  # fmt: skip
"""The attempts that are each made in a process of their own."""
