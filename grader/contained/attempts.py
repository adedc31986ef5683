"""What a probe tries in a notebook's place, past the audit hook: whatever succeeds is not contained on this machine.

Each attempt returns what it achieved, in words; it raises OSError, or another exception, where it was refused.
"""

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

MOST = 200
"""So many processes are no longer a limit."""


def make(asked: dict[str, Any], report: Callable[[dict[str, Any]], None]) -> None:
    """Make every attempt; report of each what it achieved, nothing where it was refused."""
    signal.signal(signal.SIGXCPU, signal.SIG_IGN)
    for guarantee, attempt in ATTEMPTS:
        try:
            achieved = attempt(asked)
        except Exception:
            achieved = ""
        report({"guarantee": guarantee, "achieved": achieved})
    if not asked["seconds"]:
        report({"done": True})
    while time.process_time() < asked["seconds"] + 1:  # until it is killed
        pass
    report({"guarantee": "time", "achieved": f"computed for {asked['seconds'] + 1} s"})


def _read(asked: dict[str, Any]) -> str:
    return f"read a file of another user's folder ({len(Path(asked['file']).read_bytes())} bytes)"


def _write(asked: dict[str, Any]) -> str:
    Path(asked["file"]).with_name("planted").touch()
    return "wrote into another folder"


def _alter(asked: dict[str, Any]) -> str:
    os.chmod(asked["file"], 0o600)
    return "changed the rights of another folder's file"


def _list(asked: dict[str, Any]) -> str:
    return f"listed another folder ({len(os.listdir(Path(asked['file']).parent))} files)"


def _fill(asked: dict[str, Any]) -> str:
    with open("large", "wb") as file:
        for _ in range(200):
            file.write(bytes(1 << 20))
    return "wrote a file of 200 MB"


def _connect(asked: dict[str, Any]) -> str:
    socket.create_connection(("127.0.0.1", asked["port"]), timeout=2)
    return "connected to a port of this machine"


def _connect_abstract(asked: dict[str, Any]) -> str:
    with socket.socket(socket.AF_UNIX) as end:
        end.connect(asked["abstract"])
    return "connected to a socket of this machine"


def _send(asked: dict[str, Any]) -> str:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.sendto(b"x", ("127.0.0.1", asked["port"]))
    return "sent a datagram"


def _signal(asked: dict[str, Any]) -> str:
    os.kill(asked["pid"], 0)
    return "reached the grader with a signal"


def _multiply(_: dict[str, Any]) -> str:
    """Start processes that leave their session and wait; they hold the pipe, so that it tells when all have ended."""
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


def _allocate(asked: dict[str, Any]) -> str:
    mmap.mmap(-1, asked["memory"] + (1 << 20)).close()
    return "was given more memory than the limit"


def _share_memory(_: dict[str, Any]) -> str:
    for size in range(64):
        descriptor = os.memfd_create(str(size))
        os.truncate(descriptor, 10_000_000)
    return "was given memory that no limit counts"


def _unshare(_: dict[str, Any]) -> str:
    kernel.unshare(kernel.NEWUSER)
    return "became root of a namespace"


def _trace(asked: dict[str, Any]) -> str:
    if sys.platform != "linux" or ctypes.CDLL(None).ptrace(0x4206, asked["pid"], 0, 0) != 0:  # seize: stops nobody
        raise OSError
    return "reached into the grader's memory"


def _change_root(_: dict[str, Any]) -> str:
    os.chroot(".")
    return "changed its root folder"


def _hurry(_: dict[str, Any]) -> str:
    os.nice(-1)
    return "took precedence over other processes"


ATTEMPTS: tuple[tuple[str, Callable[[dict[str, Any]], str]], ...] = (
    ("files", _read), ("files", _write), ("files", _alter), ("files", _list), ("files", _fill), ("network", _connect),
    ("network", _send), ("network", _connect_abstract), ("processes", _signal), ("memory", _allocate),
    ("memory", _share_memory), ("privileges", _unshare), ("processes", _trace), ("privileges", _change_root),
    ("privileges", _hurry), ("processes", _multiply),
)  # fmt: skip
"""In the order in which they are made, each with the guarantee that it is against."""
