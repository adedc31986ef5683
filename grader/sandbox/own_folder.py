"""Temporary folders that are removed even if their process is killed: the next process that makes one removes them."""

import contextlib
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.files import IS_POSIX, lock
from qdot.grader.sandbox.contained import folders

SUFFIX = ".tmp"
"""The ending of these folders' names. It protects a user's own folder, such as qdot-submissions-autumn."""

REMOVAL_TIMEOUT = 5.0
"""Maximum number of seconds spent on removing an abandoned folder; the next process removes the rest."""


@dataclass(frozen=True)
class TemporaryFolder:
    """A temporary folder, locked for as long as this process has it open."""

    path: str
    descriptor: int

    def __enter__(self) -> Path:
        return Path(self.path)

    def __exit__(self, *_: object) -> None:
        self.remove()

    def remove(self) -> None:
        """Remove the folder and its content."""
        with contextlib.suppress(OSError):
            folders.remove(self.path) if IS_POSIX else shutil.rmtree(self.path)
        with contextlib.suppress(OSError):
            os.close(self.descriptor)


def make_temporary_folder(prefix: str) -> TemporaryFolder:
    """Return a new temporary folder, and remove those with the same prefix whose processes were killed.

    Folders that can't be removed are left.
    """
    if not IS_POSIX:  # Windows can't lock folders
        return TemporaryFolder(tempfile.mkdtemp(prefix=prefix, suffix=SUFFIX), -1)
    for path in Path(tempfile.gettempdir()).glob(f"{prefix}*{SUFFIX}"):
        with contextlib.suppress(Exception):
            _remove_unless_locked(path)
    while True:
        folder = tempfile.mkdtemp(prefix=prefix, suffix=SUFFIX)
        with contextlib.suppress(FileNotFoundError):  # another process may have removed it before it was locked
            handle = os.open(folder, os.O_RDONLY)
            with contextlib.suppress(OSError):  # the disk may not support locks
                lock(handle)
            if Path(folder).is_dir():
                return TemporaryFolder(folder, handle)
            os.close(handle)


def _remove_unless_locked(path: Path) -> None:
    """Remove a folder of this user. Raises OSError if another process has locked it, or if it takes too long."""
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        if os.fstat(handle).st_uid == os.geteuid():
            lock(handle, wait=False)
            folders.remove(str(path), REMOVAL_TIMEOUT)
    finally:
        os.close(handle)
