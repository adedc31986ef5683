"""Removes files that an earlier build wrote into a site's folder and that no longer exist."""

import contextlib
import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath

from qdot.exercises.common.files import cannot_write, write_atomically

LIST = "written.json"
"""The list of files that the last build wrote, with the digests of their bytes."""


def remove_stale_files(folder: Path, written: Iterable[str]) -> list[str]:
    """Remove files that the list names and that were not `written` again; write the new list. Return removed files.

    A file that was changed since then stays, and so does everything that is not in the list. Raises QdotError.
    """
    now = {name: _digest(folder / name) for name in sorted(set(written))}
    removed = []
    for name, digest in _read_list(folder).items():
        path = folder / name
        if name in now or path.is_symlink() or not path.is_file() or _digest(path) != digest:
            continue
        try:
            path.unlink()
        except OSError as error:
            raise cannot_write(path, error) from None
        removed.append(name)
        with contextlib.suppress(OSError):  # it contains other files
            path.parent.rmdir()
    write_atomically(folder / LIST, json.dumps({"qdot": "site", "files": now}, indent=1) + "\n")
    return removed


def _read_list(folder: Path) -> Mapping[str, str]:
    """Return the list's digests by path; empty if there is no list, or none that qdot wrote."""
    try:
        content = json.loads((folder / LIST).read_text(encoding="utf-8"))
        files = content["files"] if content["qdot"] == "site" else {}
        return {name: digest for name, digest in files.items() if _is_inside(name)}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _is_inside(name: str) -> bool:
    path = PurePosixPath(name)
    return not path.is_absolute() and ".." not in path.parts and "\\" not in name and ":" not in name


def _digest(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise cannot_write(path, error) from None
