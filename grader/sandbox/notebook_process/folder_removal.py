"""Remove a folder and its content, whatever the depth of nesting and the permissions.

No recursion and no long paths are needed: the subfolders of each subfolder are moved into the top folder, until every
subfolder can be removed there.
"""

import contextlib
import math
import os
import secrets
import stat
import time


def remove_folder(path: str, timeout: float = math.inf) -> None:
    """Remove a folder. Raises OSError if something can't be removed, or after `timeout` seconds.

    Links are removed, and never followed.
    """
    deadline = time.monotonic() + timeout
    with contextlib.suppress(NotImplementedError):
        os.chmod(path, 0o700, follow_symlinks=False)
    top_handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        while names := os.listdir(top_handle):
            for name in names:
                if not _unlink(name, top_handle):
                    _move_up(name, top_handle)
                if time.monotonic() > deadline:
                    raise TimeoutError(f"{path} is not empty after {timeout:g} s")
    finally:
        os.close(top_handle)
    os.rmdir(path)


def _unlink(name: str, parent_handle: int) -> bool:
    """Remove a file or a link; return False for a folder, after giving its owner all rights to it.

    `parent_handle` is the descriptor of the folder that contains it.
    """
    try:
        os.unlink(name, dir_fd=parent_handle)
    except (IsADirectoryError, PermissionError):  # for a folder, macOS raises PermissionError
        with contextlib.suppress(NotImplementedError):
            os.chmod(name, 0o700, dir_fd=parent_handle, follow_symlinks=False)
        if not stat.S_ISDIR(os.stat(name, dir_fd=parent_handle, follow_symlinks=False).st_mode):
            raise
        return False
    return True


def _move_up(name: str, top_handle: int) -> None:
    """Move the subfolders of a folder into the top folder; remove its files, and then the folder itself."""
    folder_handle = os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=top_handle)
    try:
        for entry in os.listdir(folder_handle):
            if not _unlink(entry, folder_handle):
                os.rename(entry, secrets.token_hex(16), src_dir_fd=folder_handle, dst_dir_fd=top_handle)
    finally:
        os.close(folder_handle)
    os.rmdir(name, dir_fd=top_handle)
