"""Write files atomically: a reader sees either the old content or the new, never a part of it."""

import contextlib
import io
import os
import re
import stat
import tempfile
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from qdot.exercises.common.errors import QdotError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

IS_POSIX = fcntl is not None
"""Whether an open file can be renamed and removed; Windows does not allow that."""
_DEVICE_NAME = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³]) *(\..*)?", re.IGNORECASE)


def is_changed_by_windows(name: str) -> bool:
    """Return whether Windows would change a file name: a device's name, or a name that ends with a dot or a space."""
    return name.endswith((".", " ")) or _DEVICE_NAME.fullmatch(name) is not None


def make_write_error(path: Path, error: OSError) -> QdotError:
    """Return the error for a file or folder that can't be written."""
    return QdotError(f"{path} can't be written: {error.strerror or error}")


def make_folder(path: Path) -> None:
    """Create a folder and its parents, if they don't exist. Raises QdotError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise make_write_error(path, error) from None


def write_atomically(path: Path, content: str | bytes, mode: int = 0o644, *, is_synced: bool = True) -> None:
    """Write `content` to a temporary file and rename that to `path`; on failure, `path` is unchanged. Raises QdotError.

    If `is_synced`, the content and then the new name are synced to the disk before this function returns, so that both
    survive a power failure. Files that a rerun regenerates need not be synced (see `sync_disks_after`).

    If `path` is a symbolic link, its target is written. A device, a pipe or /dev/stdout is written directly, because a
    rename would replace it for every program on the machine.
    """
    try:
        data = content.encode("utf-8", "replace") if isinstance(content, str) else content
        if _must_be_written_in_place(path):
            with path.open("wb") as file:
                file.write(data)
        else:
            _write_and_rename(Path(os.path.realpath(path)) if path.is_symlink() else path, data, mode, is_synced)
    except OSError as error:
        raise make_write_error(path, error) from None


def _must_be_written_in_place(path: Path) -> bool:
    """Return whether a path can't be replaced: a device, a pipe, a socket, or a process's open file (/dev/fd/1)."""
    try:
        file_mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    if not stat.S_ISREG(file_mode):
        return not stat.S_ISDIR(file_mode)
    folders = [path.parent, *([path.parent / path.readlink().parent] if path.is_symlink() else [])]
    return any(os.path.realpath(folder).startswith(("/proc/", "/dev/fd")) for folder in folders)


def _write_and_rename(path: Path, data: bytes, mode: int, is_synced: bool) -> None:
    """Write a temporary file and rename it to `path`, which may exist. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = _open_temporary(path)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            if is_synced:
                os.fsync(file.fileno())
            Path(name).chmod(mode)
            if IS_POSIX:
                Path(name).replace(path)  # while it is locked, so that no other process removes it as a leftover
        if not IS_POSIX:
            Path(name).replace(path)
        if is_synced:
            _sync_folder(path.parent)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise


def _sync_folder(folder: Path) -> None:
    """Sync a folder, so that a rename in the folder survives a power failure."""
    with contextlib.suppress(OSError):  # some file systems can't sync a folder
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


@contextlib.contextmanager
def sync_disks_after() -> Iterator[None]:
    """After the block, sync all disks once, so that the files written in the block survive a power failure.

    Syncing each file would take longer than writing the file.
    """
    try:
        yield
    finally:
        if hasattr(os, "sync"):  # Windows has no sync
            os.sync()


# --- temporary files, which a killed process leaves behind ---


def _open_temporary(path: Path) -> tuple[int, str]:
    """Return the handle and the name of a new file beside `path`; the file is locked while this process has it open."""
    while True:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=_make_prefix(path), suffix=".tmp")
        with contextlib.suppress(OSError):  # the file system has no locks, so nobody can lock the file
            lock(handle)
        if os.fstat(handle).st_nlink:
            return handle, name
        os.close(handle)  # another process removed the file before it was locked


def _make_prefix(path: Path) -> str:
    """Return the beginning of the names of the temporary files for a path."""
    return f".{path.name[:40]}."  # not longer than file systems allow


def lock(handle: int, *, wait: bool = True) -> None:
    """Lock an open file until it is closed or the process ends. Raises OSError.

    If `wait` is False and another process holds the lock, the function raises BlockingIOError.
    """
    if IS_POSIX:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    else:
        _lock_on_windows(handle, wait)


LOCKED_BYTE = 1 << 30
"""Index of the byte that is locked on Windows. It is far beyond the content, which stays readable."""


def _lock_on_windows(handle: int, wait: bool) -> None:
    import msvcrt

    locking_mode = msvcrt.LK_LOCK if wait else msvcrt.LK_NBLCK  # type: ignore[attr-defined]
    position = os.lseek(handle, 0, os.SEEK_CUR)
    os.lseek(handle, LOCKED_BYTE, os.SEEK_SET)
    try:
        msvcrt.locking(handle, locking_mode, 1)  # type: ignore[attr-defined]
    except OSError as error:
        raise BlockingIOError(error.errno, error.strerror) from None
    finally:
        os.lseek(handle, position, os.SEEK_SET)


@contextlib.contextmanager
def clean_up_after(paths: Sequence[Path]) -> Iterator[None]:
    """Remove leftover temporary files of earlier runs before the block, and of killed workers after it."""
    remove_leftovers(paths)
    try:
        yield
    finally:
        remove_leftovers(paths)


def remove_leftovers(paths: Iterable[Path]) -> None:
    """Remove the temporary files that killed processes left for these paths; locked files, which are in use, stay."""
    prefixes: dict[Path, set[str]] = {}
    for path in paths:
        prefixes.setdefault(path.parent, set()).add(_make_prefix(path))
    for folder, known_prefixes in prefixes.items():
        with contextlib.suppress(OSError):
            for path in folder.iterdir():
                match = re.fullmatch(r"(\..*\.)[a-z0-9_]{8}\.tmp", path.name, re.DOTALL)
                if match and match.group(1) in known_prefixes:
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


def make_zip(files: Mapping[str, str | bytes], permissions: Mapping[str, int] = {}) -> bytes:
    """Return a zip archive whose bytes depend only on the files.

    `permissions` maps the path of a file to its permissions; all other files get 0o644.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as zip_file:
        for path, content in files.items():
            info = zipfile.ZipInfo(path, date_time=(1980, 1, 1, 0, 0, 0))
            info.compress_type, info.create_system = zipfile.ZIP_DEFLATED, 3  # 3 is Unix, so permissions apply
            info.external_attr = permissions.get(path, 0o644) << 16
            zip_file.writestr(info, content.encode() if isinstance(content, str) else content)
    return buffer.getvalue()
