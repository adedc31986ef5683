"""Writing files so that nobody ever sees half of one."""

import contextlib
import os
import tempfile
from pathlib import Path

from exercises.errors import QdotError


def cannot_write(path: Path, error: OSError) -> QdotError:
    """Return the error for a file or folder that the system won't let us write."""
    return QdotError(f"{path} can't be written: {error.strerror or error}")


def make_folder(path: Path) -> None:
    """Make a folder and those above it, if they aren't there. Raises QdotError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(path, error) from None


def write_atomically(path: Path, text: str, mode: int = 0o644) -> None:
    """Write `text` beside `path` and rename it into place; on any failure `path` is as it was. Raises QdotError."""
    try:
        _write_and_rename(path, text, mode)
    except OSError as error:
        raise cannot_write(path, error) from None


def _write_and_rename(path: Path, text: str, mode: int) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:40]}.", suffix=".tmp")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", errors="replace", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        Path(name).chmod(mode)
        Path(name).replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise
