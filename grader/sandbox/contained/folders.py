"""Remove a folder with all that is in it, however deep it is nested and whatever rights it has.

No recursion and no long paths: what lies in a folder of the folder is moved up into it, until everything lies there.
"""

import contextlib
import math
import os
import secrets
import time


def remove(path: str, within: float = math.inf) -> None:
    """Remove a folder. Raises OSError where something can't be removed, or all of it takes longer than so many seconds.

    Links are removed, and never followed.
    """
    deadline = time.monotonic() + within
    with contextlib.suppress(NotImplementedError):
        os.chmod(path, 0o700, follow_symlinks=False)
    top = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        while names := os.listdir(top):
            for name in names:
                if not _unlinked(name, top):
                    _lift(name, top)
                if time.monotonic() > deadline:
                    raise TimeoutError(f"{path} is not empty after {within:g} s")
    finally:
        os.close(top)
    os.rmdir(path)


def _unlinked(name: str, parent: int) -> bool:
    """Remove a file or a link; return whether it was one."""
    try:
        os.unlink(name, dir_fd=parent)
    except (IsADirectoryError, PermissionError):  # macOS says the latter of a folder
        if not _is_folder(name, parent):
            raise
        return False
    return True


def _is_folder(name: str, parent: int) -> bool:
    with contextlib.suppress(NotImplementedError):  # its owner may read, change and move it from now on
        os.chmod(name, 0o700, dir_fd=parent, follow_symlinks=False)
    with contextlib.suppress(NotADirectoryError):
        os.close(os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=parent))
        return True
    return False


def _lift(name: str, top: int) -> None:
    """Move the folders that are in a folder up, remove its files, and then itself."""
    folder = os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=top)
    try:
        for inner in os.listdir(folder):
            if not _unlinked(inner, folder):
                os.rename(inner, secrets.token_hex(16), src_dir_fd=folder, dst_dir_fd=top)
    finally:
        os.close(folder)
    os.rmdir(name, dir_fd=top)
