"""Imitate Python on Windows in every process that starts with this folder on PYTHONPATH.

POSIX modules and functions are removed, and processes are spawned. Open files can't be renamed or removed, folders
can't be opened, and new files need names that Windows allows. A stand-in replaces Windows's module `msvcrt`.
"""

import builtins
import contextlib
import importlib.abc
import io
import multiprocessing
import os
import re
import shutil
import signal
import subprocess  # noqa: F401 - imported first, because it would take msvcrt for Windows
import sys
import tempfile
import types
from multiprocessing import context
from typing import Any

MODULES = ("fcntl", "resource", "pwd", "grp", "termios", "tty", "pty", "syslog", "readline", "spwd", "nis", "crypt")
FUNCTIONS = (
    "fork", "forkpty", "geteuid", "getuid", "getgid", "getegid", "setsid", "killpg", "getpgid", "sysconf",
    "sched_getaffinity", "chown", "fchown", "mkfifo", "getrusage", "wait3", "wait4", "O_DIRECTORY", "O_NOFOLLOW",
    "O_NONBLOCK", "O_CLOEXEC", "memfd_create", "register_at_fork",
)  # fmt: skip
SIGNALS = (
    "SIGALRM", "SIGKILL", "SIGPROF", "SIGHUP", "SIGUSR1", "SIGUSR2", "SIGXCPU", "SIGCHLD", "SIGPIPE", "setitimer",
    "ITIMER_PROF", "alarm", "pthread_sigmask", "SIG_BLOCK", "SIG_UNBLOCK", "SIG_SETMASK", "sigwait",
)  # fmt: skip
FORBIDDEN = re.compile(r'[<>:"|?*\\\x00-\x1f]|[. ]$|^(?:con|prn|aux|nul|com\d|lpt\d)(?:\.|$)', re.IGNORECASE)

import fcntl  # noqa: E402


class _Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name: str, *_: object) -> None:
        if name in MODULES:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def _make_msvcrt() -> types.ModuleType:
    module = types.ModuleType("msvcrt")

    def locking(handle: int, mode: int, _: int, flock: Any = fcntl.flock) -> None:
        try:
            flock(handle, 2 | (4 if mode == 2 else 0))
        except BlockingIOError as error:
            raise PermissionError(13, "Permission denied") from error

    module.LK_LOCK, module.LK_NBLCK, module.locking = 1, 2, locking  # type: ignore[attr-defined]
    return module


def _refuse_open_files(function: Any) -> Any:
    def checked(source: Any, *rest: Any, **options: Any) -> Any:
        for path in (source, *rest[:1]):
            _check_closed(path)
        for path in rest[:1]:
            _check_name(path)
        return function(source, *rest, **options)

    return checked


def _check_closed(path: Any) -> None:
    if not isinstance(path, (str, os.PathLike)):
        return
    real_path = os.path.realpath(path)
    for number in os.listdir("/proc/self/fd"):
        with contextlib.suppress(FileNotFoundError):
            if os.readlink(f"/proc/self/fd/{number}") == real_path:
                raise PermissionError(13, "The process cannot access the file because it is being used", str(path))


def _check_name(path: Any) -> None:
    name = os.path.basename(os.fspath(path)) if isinstance(path, (str, os.PathLike)) else ""
    if FORBIDDEN.search(name) and not str(path).startswith("/dev/"):
        raise OSError(22, "Invalid argument", str(path))


def _refuse_folders(function: Any) -> Any:
    def checked(path: Any, flags: int = 0, *rest: Any, **options: Any) -> int:
        if isinstance(path, (str, os.PathLike)) and os.path.isdir(path):
            raise PermissionError(13, "Permission denied", str(path))
        if flags & os.O_CREAT:
            _check_name(path)
        return function(path, flags, *rest, **options)

    return checked


def _check_written_name(function: Any) -> Any:
    def checked(file: Any, mode: str = "r", *rest: Any, **options: Any) -> Any:
        if any(letter in mode for letter in "wax"):
            _check_name(file)
        return function(file, mode, *rest, **options)

    return checked


def _check_created_name(function: Any) -> Any:
    def checked(path: Any, *rest: Any, **options: Any) -> Any:
        _check_name(path)
        return function(path, *rest, **options)

    return checked


def _hide_from_qdot(function: Any, name: str) -> Any:
    def checked(*arguments: Any) -> Any:
        if sys._getframe(1).f_globals.get("__name__", "").split(".")[0] in ("exercises", "grader"):
            raise AttributeError(f"module 'os' has no attribute {name!r}")
        return function(*arguments)

    return checked


def remove_posix() -> None:
    """Remove from this process all modules and functions that Windows does not have."""
    sys.modules["msvcrt"] = _make_msvcrt()
    for name in MODULES:
        sys.modules.pop(name, None)
    sys.meta_path.insert(0, _Missing())
    for module, names in ((os, FUNCTIONS), (signal, SIGNALS)):
        for name in names:
            if hasattr(module, name):
                delattr(module, name)
    for name in ("fork", "forkserver"):
        context._concrete_contexts.pop(name, None)  # type: ignore[attr-defined]
    multiprocessing.get_all_start_methods = lambda: ["spawn"]
    multiprocessing.set_start_method("spawn")
    shutil._use_fd_functions = False  # type: ignore[attr-defined]
    tempfile._bin_openflags = tempfile._text_openflags = os.O_RDWR | os.O_CREAT | os.O_EXCL  # type: ignore[attr-defined]
    os.uname = _hide_from_qdot(os.uname, "uname")  # NumPy asks where it was built for Linux
    os.open = _refuse_folders(os.open)
    for name in ("rename", "replace", "unlink", "remove"):
        setattr(os, name, _refuse_open_files(getattr(os, name)))
    os.mkdir = _check_created_name(os.mkdir)
    builtins.open = io.open = _check_written_name(io.open)


remove_posix()
