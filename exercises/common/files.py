"""Writing files so that nobody ever sees half of one."""

import contextlib
import os
import re
import stat
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

from qdot.exercises.common.errors import QdotError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

IS_POSIX = fcntl is not None
"""Whether a file that is open can be renamed and removed, as Windows does not let anybody."""


_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³]) *(\..*)?", re.IGNORECASE)


def is_changed_by_windows(name: str) -> bool:
    """Return whether a file or folder can't have this name on Windows: a device has it, or its end is taken off."""
    return name.endswith((".", " ")) or _DEVICE.fullmatch(name) is not None


def cannot_write(path: Path, error: OSError) -> QdotError:
    """Return the error for a file or folder that the system won't let us write."""
    return QdotError(f"{path} can't be written: {error.strerror or error}")


def make_folder(path: Path) -> None:
    """Make a folder and those above it, if they aren't there. Raises QdotError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path, error) from None


def write_atomically(path: Path, content: str | bytes, mode: int = 0o644, *, lasting: bool = True) -> None:
    """Write `content` beside `path` and rename it into place; on any failure `path` is as it was. Raises QdotError.

    It is on the disk before it has the name, and has the name for good before this returns, whatever fails then. Where
    that need not be `lasting`, as a rerun makes it anew, nobody waits for the disk (see `flush_disks_after`).

    A link stays, and what it leads to is written. A device, a pipe or /dev/stdout is written in place: a file that took
    its name would take its place for every program on the machine.
    """
    try:
        data = content.encode("utf-8", "replace") if isinstance(content, str) else content
        if _is_in_place(path):
            with path.open("wb") as file:
                file.write(data)
        else:
            _write_and_rename(Path(os.path.realpath(path)) if path.is_symlink() else path, data, mode, lasting)
    except OSError as error:
        raise cannot_write(path, error) from None


def _is_in_place(path: Path) -> bool:
    """Tell whether a path is of a device, a pipe, a socket, or of a file that some process has open (/dev/fd/1)."""
    try:
        kind = path.stat().st_mode
    except FileNotFoundError:
        return False
    if not stat.S_ISREG(kind):
        return not stat.S_ISDIR(kind)
    beside = [path.parent, *([path.parent / path.readlink().parent] if path.is_symlink() else [])]
    return any(os.path.realpath(folder).startswith(("/proc/", "/dev/fd")) for folder in beside)


def _write_and_rename(path: Path, data: bytes, mode: int, lasting: bool) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = _open_temporary(path)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            if lasting:
                os.fsync(file.fileno())
            Path(name).chmod(mode)
            if IS_POSIX:
                Path(name).replace(path)  # while it is locked: nobody takes it for one that was left behind
        if not IS_POSIX:
            Path(name).replace(path)
        if lasting:
            _flush_names(path.parent)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise


def _flush_names(folder: Path) -> None:
    """See to it that a rename outlives a loss of power; without this, it is whole all the same, the old or the new."""
    with contextlib.suppress(OSError):  # some disks can't
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextlib.contextmanager
def flush_disks_after() -> Iterator[None]:
    """Have the system write to its disks what is written in the block, so that it survives a loss of power.

    Syncing each file would take longer than writing it.
    """
    try:
        yield
    finally:
        if hasattr(os, "sync"):  # Windows has none
            os.sync()


# --- files begun, and left behind by a process that was killed ---


def _open_temporary(path: Path) -> tuple[int, str]:
    """Return handle and name of a new file beside `path`, locked for as long as this process has it open."""
    while True:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=_prefix(path), suffix=".tmp")
        with contextlib.suppress(OSError):  # a disk that knows no locks: nobody else gets one there, either
            lock(handle)
        if os.fstat(handle).st_nlink:
            return handle, name
        os.close(handle)  # somebody who was tidying up had it before it was locked


def _prefix(path: Path) -> str:
    return f".{path.name[:40]}."


def lock(handle: int, *, wait: bool = True, shared: bool = False) -> None:
    """Lock an open file, alone or with others who share it; the system lets go of it when the file is closed, or the
    process ends. Raises OSError; without `wait`, it is a BlockingIOError where somebody else has it.

    On Windows nobody shares a lock.
    """
    if IS_POSIX:
        fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB))
    else:
        _lock_on_windows(handle, wait)


FAR = 1 << 30
"""The byte of a file that is locked on Windows, where nobody else can read what is locked."""


def _lock_on_windows(handle: int, wait: bool) -> None:
    import msvcrt

    kind = msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK  # type: ignore[attr-defined]
    place = os.lseek(handle, 0, os.SEEK_CUR)
    os.lseek(handle, FAR, os.SEEK_SET)
    try:
        msvcrt.locking(handle, kind, 1)  # type: ignore[attr-defined]
    except OSError as error:
        raise BlockingIOError(error.errno, error.strerror) from None
    finally:
        os.lseek(handle, place, os.SEEK_SET)


@contextlib.contextmanager
def clean_up_after(paths: Iterable[Path]) -> Iterator[None]:
    """Remove what an earlier run left behind for these paths, and in the end what this run's own dead workers did."""
    known = list(paths)
    remove_left_behind(known)
    try:
        yield
    finally:
        remove_left_behind(known)


def remove_left_behind(paths: Iterable[Path]) -> None:
    """Remove what killed processes had begun to write for these paths; what one is writing now is locked, and stays."""
    prefixes: dict[Path, set[str]] = {}
    for path in paths:
        prefixes.setdefault(path.parent, set()).add(_prefix(path))
    for folder, known in prefixes.items():
        with contextlib.suppress(OSError):
            for path in folder.iterdir():
                begun = re.fullmatch(r"(\..*\.)[a-z0-9_]{8}\.tmp", path.name, re.DOTALL)
                if begun and begun.group(1) in known:
                    _remove_unless_locked(path)


def _remove_unless_locked(path: Path) -> None:
    with contextlib.suppress(OSError):
        handle = os.open(path, os.O_RDWR)
        try:
            lock(handle, wait=False)
            if IS_POSIX:
                path.unlink()
        finally:
            os.close(handle)
        if not IS_POSIX:
            path.unlink()
