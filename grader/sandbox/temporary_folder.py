"""Make temporary folders that are removed even if their process is killed: the next such process removes them."""

import contextlib
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.files import IS_POSIX, lock
from qdot.grader.sandbox.notebook_process import folder_removal

SUFFIX = ".tmp"
"""The ending of these folders' names, so that a user's own folder such as qdot-submissions-autumn is never removed."""

REMOVAL_TIMEOUT = 5.0
"""Maximum number of seconds for removing the folder of a killed process; the next process removes what is left."""


@dataclass(frozen=True)
class TemporaryFolder:
    """A temporary folder; `descriptor` is an open file that locks the folder while this process runs, -1 on Windows."""

    path: str
    descriptor: int

    def __enter__(self) -> Path:
        return Path(self.path)

    def __exit__(self, *_: object) -> None:
        self.remove()

    def remove(self) -> None:
        """Remove the folder and its content."""
        with contextlib.suppress(OSError):
            if IS_POSIX:
                folder_removal.remove_folder(self.path)
            else:
                shutil.rmtree(self.path)
        with contextlib.suppress(OSError):
            os.close(self.descriptor)


def make_temporary_folder(prefix: str) -> TemporaryFolder:
    """Return a new temporary folder, and remove the folders with the same prefix whose processes were killed.

    A folder that can't be removed stays.
    """
    if not IS_POSIX:  # Windows can't lock folders
        return TemporaryFolder(tempfile.mkdtemp(prefix=prefix, suffix=SUFFIX), -1)
    for path in Path(tempfile.gettempdir()).glob(f"{prefix}*{SUFFIX}"):
        with contextlib.suppress(Exception):
            _remove_unless_locked(path)
    while True:
        folder = tempfile.mkdtemp(prefix=prefix, suffix=SUFFIX)
        with contextlib.suppress(FileNotFoundError):  # another process may have removed it before it was locked
            descriptor = os.open(folder, os.O_RDONLY)
            with contextlib.suppress(OSError):  # the disk may not support locks
                lock(descriptor)
            if Path(folder).is_dir():
                return TemporaryFolder(folder, descriptor)
            os.close(descriptor)


def _remove_unless_locked(path: Path) -> None:
    """Remove a folder of this user. Raises OSError if another process has locked the folder, or after a timeout."""
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        if os.fstat(descriptor).st_uid == os.geteuid():
            lock(descriptor, wait=False)
            folder_removal.remove_folder(str(path), REMOVAL_TIMEOUT)
    finally:
        os.close(descriptor)
