"""Temporary folders that no killed process leaves behind: the next that makes one removes those of dead processes."""

import contextlib
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from qdot.exercises.common.files import IS_POSIX, lock
from qdot.grader.sandbox.contained import folders

ENDING = ".tmp"
"""What the name of such a folder ends with: somebody's own qdot-submissions-autumn is none."""

PATIENCE = 5.0
"""Seconds in which a folder that was left behind is removed; what is left of it has its turn the next time."""


@dataclass(frozen=True)
class OwnFolder:
    """A temporary folder, locked for as long as this process has it open."""

    path: str
    handle: int

    def __enter__(self) -> Path:
        return Path(self.path)

    def __exit__(self, *_: object) -> None:
        self.remove()

    def remove(self) -> None:
        """Remove the folder with all that is in it."""
        with contextlib.suppress(OSError):
            folders.remove(self.path) if IS_POSIX else shutil.rmtree(self.path)
        with contextlib.suppress(OSError):
            os.close(self.handle)


def own_folder(prefix: str) -> OwnFolder:
    """Return a new temporary folder, and remove those with such a name whose processes were killed.

    What can't be removed stays, whatever is in the way: it is no reason not to begin.
    """
    if not IS_POSIX:  # a folder can't be locked
        return OwnFolder(tempfile.mkdtemp(prefix=prefix, suffix=ENDING), -1)
    for path in Path(tempfile.gettempdir()).glob(f"{prefix}*{ENDING}"):
        with contextlib.suppress(Exception):
            _remove_unless_locked(path)
    while True:
        folder = tempfile.mkdtemp(prefix=prefix, suffix=ENDING)
        with contextlib.suppress(FileNotFoundError):  # somebody who was tidying up had it before it was locked
            handle = os.open(folder, os.O_RDONLY)
            with contextlib.suppress(OSError):  # a disk that knows no locks: nobody else gets one there, either
                lock(handle)
            if Path(folder).is_dir():
                return OwnFolder(folder, handle)
            os.close(handle)


def _remove_unless_locked(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        if os.fstat(handle).st_uid == os.geteuid():
            lock(handle, wait=False)
            folders.remove(str(path), PATIENCE)
    finally:
        os.close(handle)
