"""Read a backup: the content of the database as JSON, and the files of the assignments."""

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from qdot.exercises.assignment.assignment import SECRET_FILE
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import make_folder, write_atomically

DATABASE_MEMBER, FOLDERS_MEMBER = "database.json", "folders"
"""The names in a backup of the content of the database, and of the folder with the files of assignments."""


@contextmanager
def open_backup(path: Path) -> Iterator[zipfile.ZipFile]:
    """Open a backup. Raises QdotError."""
    try:
        with zipfile.ZipFile(path) as archive:
            archive.getinfo(DATABASE_MEMBER)
            yield archive
    except (OSError, KeyError, zipfile.BadZipFile):
        raise QdotError(f"{path} was not written by `qdot serve backup`") from None


def read_member(path: Path, name: str) -> bytes:
    """Return the content of a file in a backup. Raises QdotError."""
    with open_backup(path) as archive:
        return archive.read(name)


def restore_files(path: Path, folders: list[Path]) -> None:
    """Write the files of the assignments that are missing in their folders. Raises QdotError."""
    with open_backup(path) as archive:
        for folder in folders:
            prefix = f"{FOLDERS_MEMBER}/{folder.resolve().name}/"
            make_folder(folder)
            for name in (name for name in archive.namelist() if name.startswith(prefix)):
                target = folder / Path(name).name
                if not target.exists():
                    write_atomically(target, archive.read(name), 0o600 if target.name == SECRET_FILE else 0o644)
