"""List the files that a notebook may read, and block all others with an audit hook: the second line of defence.

The hook watches Python code and raises an error that names what the hook refused. The kernel restricts native code, too
(`isolation`). If the kernel can't, as on macOS, the hook is the only defence.
"""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

HIDDEN_PACKAGES = ("qdot",)
"""Packages that a notebook may not load: with them and the secret, it could regenerate the reference answers."""


def find_library_folders() -> list[str]:
    """Return the folders from which Python imports modules, except a checkout of qdot (an editable install)."""
    package_folders = [path for path in sys.path if "site-packages" in path or "dist-packages" in path]
    other_folders = [path for path in sys.path if path and path not in package_folders]
    checkouts = [path for path in other_folders if any(Path(path, name).is_dir() for name in HIDDEN_PACKAGES)]
    return package_folders + [path for path in other_folders if path not in checkouts]


LIBRARY_FOLDERS = tuple(find_library_folders())
"""The folders from which a notebook imports modules."""

DEVICES = ("/dev/null", "/dev/zero", "/dev/urandom", "/dev/random")

READABLE_PATHS = (
    sys.prefix, sys.base_prefix, *LIBRARY_FOLDERS, "/usr/lib", "/usr/lib64", "/usr/share", "/usr/local/lib", "/lib",
    "/lib64", "/nix/store", "/gnu/store", "/System/Library", "/Library/Fonts", "/etc/localtime", "/etc/fonts",
    "/etc/ssl", "/etc/ld.so.cache", *filter(os.path.isabs, os.environ.get("LD_LIBRARY_PATH", "").split(":")), *DEVICES,
)  # fmt: skip
"""The paths that Python and its libraries read; a notebook may read nothing else on the machine."""

RESOLVED_READABLE_PATHS = tuple(dict.fromkeys(map(os.path.realpath, READABLE_PATHS)))
"""The same paths with links resolved."""

REFUSED_EVENTS = (
    "subprocess.", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.kill", "os.killpg", "pty.",
    "socket.", "ctypes.", "signal.pthread_kill", "os.link", "os.symlink", "os.chown", "sys.setprofile", "sys.settrace",
    "os.setxattr", "os.removexattr", "fcntl.ioctl", "gc.get_", "webbrowser.", "ftplib.", "smtplib.", "urllib.",
)  # fmt: skip
"""Beginnings of the names of audit events that are always refused."""

CHANGING_EVENTS = ("os.rename", "os.remove", "os.rmdir", "os.mkdir", "os.chmod", "os.truncate", "os.utime")
"""Beginnings of the names of audit events that are allowed only in the notebook's folder."""


def is_inside(path: Any, folders: tuple[str, ...]) -> bool:
    """Return whether a path, with links resolved, is in one of the folders.

    Also return True for the descriptor of an open file (checked when it was opened), and for None (the current folder,
    which the notebook may read).
    """
    if isinstance(path, int) or path is None:
        return True
    resolved_path = os.path.realpath(os.fsdecode(path))
    return any(resolved_path == folder or resolved_path.startswith(folder.rstrip("/") + "/") for folder in folders)


def make_audit_hook(folder: str) -> Callable[[str, tuple[Any, ...]], None]:
    """Return an audit hook that allows only reading the libraries and writing into the notebook's folder.

    Once added, a hook can't be removed.
    """
    notebook_folders = (os.path.realpath(folder),)
    readable_paths = (*notebook_folders, *RESOLVED_READABLE_PATHS)
    writing_flags = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
    inner_folders = ("", "/exercises", "/grader")  # these are links in a checkout
    names = [f"{name}{inner_folder}" for name in HIDDEN_PACKAGES for inner_folder in inner_folders]
    hidden_paths = tuple(os.path.realpath(f"{path}/{name}") for path in sys.path for name in names)

    def refuse(action: str) -> NoReturn:
        raise PermissionError(f"a notebook may not {action} while it is graded")

    def hook(event: str, args: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = args
            opens_for_writing = isinstance(flags, int) and flags & writing_flags
            is_harmless = path in ("/dev/null", b"/dev/null")
            is_allowed = is_inside(path, notebook_folders if opens_for_writing and not is_harmless else readable_paths)
            if not is_allowed or (not isinstance(path, int) and is_inside(path, hidden_paths)):
                refuse(f"open {str(path)[:200]!r}")
        elif event == "import" and str(args[0]).split(".")[0] in HIDDEN_PACKAGES:
            refuse(f"import {str(args[0])[:100]}")
        elif event.startswith(("os.listdir", "os.scandir", "os.chdir")):  # allowed for os.walk and glob in libraries
            if not is_inside(args[0], readable_paths):
                refuse(f"list {str(args[0])[:200]!r}")
        elif event.startswith(CHANGING_EVENTS):
            # chmod and utime also change a file that is open for reading only, such as a library.
            is_descriptor = isinstance(args[0], int) and event in ("os.chmod", "os.utime")
            paths = [arg for arg in args[:2] if isinstance(arg, (str, bytes))]
            if is_descriptor or not all(is_inside(path, notebook_folders) for path in paths):
                refuse(f"change {str(args[0])[:200]!r}")
        elif event.startswith(REFUSED_EVENTS):
            refuse(f"use {event}")

    return hook
