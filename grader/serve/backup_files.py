"""Read a backup: the content of the database as JSON, and the files of the assignments."""

import zipfile
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from qdot.exercises.assignment.assignment import ASSIGNMENT_FILE, SECRET_FILE, load_assignment
from qdot.exercises.common.errors import QdotError, write_first
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
    """Write the files of the assignments that are missing in their folders, which may be new. Raises QdotError.

    Nothing is written if a folder's secret, key or problems differ from the backup's.
    """
    with open_backup(path) as archive, TemporaryDirectory() as temporary:
        contents = defaultdict[str, dict[str, bytes]](dict)
        for name in archive.namelist():
            if len(parts := PurePosixPath(name).parts) == 3 and parts[0] == FOLDERS_MEMBER:
                contents[parts[1]][parts[2]] = archive.read(name)
        sources = {folder: _find_source(folder, folders, contents) for folder in folders}
        for number, (folder, source) in enumerate(sources.items()):
            present = {name: (folder / name).read_bytes() for name in contents[source] if (folder / name).is_file()}
            copies = Path(temporary) / f"{number}-original", Path(temporary) / f"{number}-merged"
            for copy, files in zip(copies, ({}, present), strict=True):
                _write_missing(copy, contents[source] | files)
            try:
                digests = {load_assignment(copy).problems_digest for copy in copies}
            except QdotError as error:
                raise QdotError(
                    str(error).replace(str(copies[0]), str(path)).replace(str(copies[1]), str(folder))
                ) from None
            if len(digests) > 1:
                raise QdotError(
                    f"the secret, key or problems in {folder} differ from those in {path}; name a new folder"
                )
        for folder, source in sources.items():
            _write_missing(folder, contents[source])


def _find_source(folder: Path, folders: list[Path], contents: Mapping[str, object]) -> str:
    """Return the key of the backup's assignment for a folder: the only one, or the folder's name, or its key.

    Raises QdotError if the backup has no such assignment.
    """
    if len(folders) == len(contents) == 1:
        return next(iter(contents))
    names = [folder.resolve().name]
    if (folder / ASSIGNMENT_FILE).exists():
        names.append(load_assignment(folder).key)
    if (name := next((name for name in names if name in contents), None)) is None:
        keys = write_first(sorted(contents), 5)
        raise QdotError(f"{folder}: the backup has {keys}; name each folder after its assignment")
    return name


def _write_missing(folder: Path, contents: Mapping[str, bytes]) -> None:
    make_folder(folder)
    for name, content in contents.items():
        if not (folder / name).exists():
            write_atomically(folder / name, content, 0o600 if name == SECRET_FILE else 0o644)
