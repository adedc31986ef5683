"""Run in place of a notebook and try to break out of the sandbox: an attempt that succeeds shows a gap on this machine.

All attempts are made without the audit hook. Each attempt that may kill its own process gets a separate process
(`SEPARATE_ATTEMPTS`).
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
except ImportError:  # on Windows, where this module is imported but never runs
    fcntl = None  # type: ignore[assignment]

UNLIMITED_PROCESSES, UNLIMITED_BYTES = 200, 256_000_000
"""If this many processes or bytes succeed, no limit is enforced. The bytes are four times the allowed size."""

ALLOWED_FILE_BYTES = 8_000_000
"""Size in bytes of a file that is small enough to be allowed."""


class Attempt(NamedTuple):
    """An attempt: the names of the guarantees that it tests, what it achieves, and the action on the probe's targets.

    Several names are separated by spaces. If the machine prevents the action, the action raises an exception or returns
    False.
    """

    guarantees: str
    achievement: str
    action: Callable[[dict[str, Any]], object]


def make_attempts(targets: dict[str, Any], report: Callable[[dict[str, Any]], None]) -> None:
    """Make all attempts, and report what each attempt achieved, or "" if it failed.

    If `targets["separate_attempt"]` is not None, make only the attempt with this index in `SEPARATE_ATTEMPTS`. Then
    compute for more than `targets["seconds"]` of processor time; if the process is not killed, report that.
    """
    signal.signal(signal.SIGXCPU, signal.SIG_IGN)
    index = targets["separate_attempt"]
    attempts = ATTEMPTS if index is None else (SEPARATE_ATTEMPTS[index],)
    for attempt in attempts:
        try:
            achievement = attempt.achievement if attempt.action(targets) is not False else ""
        except Exception:
            achievement = ""
        for guarantee in attempt.guarantees.split():
            report({"guarantee": guarantee, "achieved": achievement})
    if not targets["seconds"]:
        report({"done": True})
    while time.process_time() < targets["seconds"] + 1:  # compute until killed
        pass
    report({"guarantee": "time", "achieved": f"computed for {targets['seconds'] + 1} s"})


def _alter_library(_: dict[str, Any]) -> None:
    library = os.open(os.__file__, os.O_RDONLY)
    os.fchmod(library, os.fstat(library).st_mode & 0o7777)  # sets the same permissions, so success does no harm


def _connect_to_socket(targets: dict[str, Any]) -> None:
    with socket.socket(socket.AF_UNIX) as unix_socket:
        unix_socket.connect(targets["socket"])


def _connect_to_port(targets: dict[str, Any]) -> None:
    socket.create_connection(("127.0.0.1", targets["port"]), timeout=2)


def _send_datagram(targets: dict[str, Any]) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as datagram_socket:
        datagram_socket.sendto(b"x", ("127.0.0.1", targets["port"]))


def _signal_grader(targets: dict[str, Any]) -> None:
    if targets["pid"] == os.getpid():  # in a container, both this process and the grader may have the number 1
        raise ProcessLookupError
    os.kill(targets["pid"], 0)


def _trace_grader(targets: dict[str, Any]) -> bool:
    ptrace_seize = 0x4206  # this request does not stop the traced process
    return sys.platform == "linux" and ctypes.CDLL(None).ptrace(ptrace_seize, targets["pid"], 0, 0) == 0


def _start_program(_: dict[str, Any]) -> None:
    os.waitpid(os.posix_spawn(sys.executable, [sys.executable, "-c", ""], {}), 0)


def _start_many_processes(_: dict[str, Any]) -> bool:
    """Start processes that leave their session and wait; they keep the pipe of the report open until all have ended."""
    for number in range(UNLIMITED_PROCESSES):
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
    Attempt("files", "read a file in another user's folder", lambda targets: Path(targets["file"]).read_bytes()),
    Attempt("files", "wrote into another folder", lambda targets: Path(targets["folder"], "planted").touch()),
    Attempt("files", "changed permissions in another folder", lambda targets: os.chmod(targets["file"], 0o600)),
    Attempt("files", "changed the permissions of a library", _alter_library),
    Attempt("files", "listed another folder", lambda targets: os.listdir(Path(targets["file"]).parent)),
    Attempt("network", "connected to a port of this machine", _connect_to_port),
    Attempt("network", "sent a datagram", _send_datagram),
    Attempt("network", "connected to a socket of this machine", _connect_to_socket),
    Attempt("processes", "sent a signal to the grader", _signal_grader),
    Attempt("memory", "got more memory than its limit",
            lambda targets: mmap.mmap(-1, targets["memory"] + ALLOWED_FILE_BYTES)),
    Attempt("memory", "got memory outside every limit", _share_memory),
    Attempt("privileges", "became root of a namespace", lambda _: kernel.unshare(kernel.NEWUSER)),
    Attempt("processes", "traced the grader", _trace_grader),
    Attempt("processes", "started a program", _start_program),
    Attempt("privileges", "changed its root folder", lambda _: os.chroot(".")),
    Attempt("privileges", "raised its own priority", lambda _: os.nice(-1)),
    Attempt("processes memory", f"started {UNLIMITED_PROCESSES} processes", _start_many_processes),
)  # fmt: skip
"""The attempts in order. The last attempt also tests memory, because many processes together get more memory."""


def _write_large_file(_: dict[str, Any]) -> None:
    megabyte = bytes(1 << 20)
    with open("large", "wb") as file:
        for _number in range(200):
            file.write(megabyte)


def _write_many_files(_: dict[str, Any]) -> None:
    """Write many files, each of which is small enough by itself."""
    content = bytes(ALLOWED_FILE_BYTES)
    for number in range(UNLIMITED_BYTES // ALLOWED_FILE_BYTES):
        Path(str(number)).write_bytes(content)


def _write_nameless_files(_: dict[str, Any]) -> None:
    """Write many files whose names are already removed."""
    content = bytes(ALLOWED_FILE_BYTES)
    open_files: list[Any] = []
    while ALLOWED_FILE_BYTES * len(open_files) < UNLIMITED_BYTES:
        open_files.append(open("nameless", "wb", buffering=0))  # noqa: SIM115 - it has to stay open
        os.unlink("nameless")
        open_files[-1].write(content)


def _leave_nested_folders(_: dict[str, Any]) -> bool:
    """Leave folders that are hard to remove; the grader checks afterwards whether the folders are gone."""
    os.mkdir("closed")
    os.mkdir("closed/inner", 0)
    with contextlib.suppress(OSError):  # some machines refuse this, because it could make a library unreadable
        os.chmod("closed", 0)
    for _depth in range(1200):
        os.mkdir("d")
        os.chdir("d")
    return False


def _signal_by_descriptor(_: dict[str, Any]) -> bool:
    """Make the forking process the owner of a pipe; writing to the pipe then makes the kernel kill its owner."""
    reading_end, writing_end = os.pipe()
    fcntl.fcntl(reading_end, fcntl.F_SETOWN, os.getppid())
    fcntl.fcntl(reading_end, fcntl.F_SETSIG, signal.SIGKILL)
    fcntl.fcntl(reading_end, fcntl.F_SETFL, os.O_ASYNC)
    os.write(writing_end, b"x")
    time.sleep(0.1)
    return False


_UNLIMITED_SIZE = f"{UNLIMITED_BYTES // 1_000_000} MB"
SEPARATE_ATTEMPTS = (
    Attempt("files", "wrote a file of 200 MB", _write_large_file),
    Attempt("files", f"wrote {_UNLIMITED_SIZE} in all", _write_many_files),
    Attempt("files", f"wrote {_UNLIMITED_SIZE} into files without names", _write_nameless_files),
    Attempt("files", "", _leave_nested_folders),
    Attempt("processes", "", _signal_by_descriptor),
)
"""The attempts that each need their own process."""
