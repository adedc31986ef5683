"""List, read and unpack the files in untrusted zip and tar archives, within limits.

Only `unpack_temporarily` writes files, below a temporary folder. All other functions read archives in memory. Archives
inside archives are not opened.
"""

import contextlib
import datetime
import gzip
import io
import lzma
import os
import stat
import struct
import tarfile
import time
import unicodedata
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from qdot.grader.sandbox.temporary_folder import make_temporary_folder
from qdot.grader.submissions.cells import MAX_FILE_BYTES, NOTEBOOK_ADVICE, OverLimit, Unreadable, make_printable

MAX_FILES = 10_000
"""Maximum number of files in an archive that a student submits."""

MAX_DOWNLOAD_BYTES, MAX_DOWNLOAD_FILES = 20_000_000_000, 200_000
"""Maximum number of bytes, and of files, in a platform's download."""

ARCHIVE_ERRORS = (
    zipfile.BadZipFile, tarfile.TarError, OSError, EOFError, ValueError, zlib.error, lzma.LZMAError, struct.error,
    NotImplementedError, RuntimeError, IndexError, KeyError, OverflowError,
)  # fmt: skip
"""The exceptions that the libraries raise for damaged or malicious archives."""


def is_archive(first_bytes: bytes) -> bool:
    """Return whether a file whose first 512 bytes are `first_bytes` is an archive that qdot can open."""
    is_zip_or_gzip = first_bytes.startswith((b"PK\x03\x04", b"PK\x05\x06", b"\x1f\x8b"))
    return is_zip_or_gzip or first_bytes[257:262] == b"ustar"  # the mark of a tar archive


def list_members(path: Path) -> dict[str, int]:
    """Map the name of each file in an archive to its size in bytes. Raises Unreadable if it can't be opened."""
    label = make_printable(path.name)
    try:
        if zipfile.is_zipfile(path):
            sizes = _list_zip(path)
        else:
            sizes = {info.name: info.size for info, _ in _iterate_tar(path) if info.isfile()}
    except ARCHIVE_ERRORS:
        raise Unreadable(f"qdot can't open the archive {label}, because it is damaged; {NOTEBOOK_ADVICE}") from None
    if "[Content_Types].xml" in sizes or "mimetype" in sizes:
        raise Unreadable(f"{label} is an office document, not a notebook; {NOTEBOOK_ADVICE}")
    return sizes


def read_member(path: Path, name: str) -> bytes:
    """Return the content of a file in an archive. Raises Unreadable if the file can't be unpacked."""
    label = f"{make_printable(name)} in {make_printable(path.name)}"
    try:
        data = _read_content(path, name)
    except ARCHIVE_ERRORS as error:
        problem = "needs a password" if "encrypted" in str(error) else "can't be unpacked: the archive is damaged"
        raise Unreadable(f"{label} {problem}; {NOTEBOOK_ADVICE}") from None
    if len(data) > MAX_FILE_BYTES:
        raise OverLimit(f"{label} is larger than {MAX_FILE_BYTES // 1_000_000} MB; {NOTEBOOK_ADVICE}")
    return data


def _read_content(path: Path, name: str) -> bytes:
    """Return the first bytes of a file in an archive, up to one byte more than the limit. Raises ARCHIVE_ERRORS."""
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive, archive.open(name) as file:
            return file.read(MAX_FILE_BYTES + 1)
    for info, tar in _iterate_tar(path):
        if info.name == name and (content := tar.extractfile(info)) is not None:
            return content.read(MAX_FILE_BYTES + 1)
    raise KeyError(name)


def _list_zip(path: Path) -> dict[str, int]:
    """Map the name of each file in a zip to its size in bytes. Raises OverLimit if there are too many files.

    Parsing a very long central directory, the list of files in a zip, would take too much memory, so its size is
    checked first. The end record, the last part of a zip, has at most 65,557 bytes and contains this size in bytes.
    """
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - 65_557))
        last_bytes = file.read()
    start = last_bytes.rfind(b"PK\x05\x06")  # the end record begins with these bytes
    directory_size = int.from_bytes(last_bytes[start + 12 : start + 16], "little") if start >= 0 else 0
    if directory_size > 150 * MAX_FILES:  # an entry of the directory has about 46 bytes and the file's path
        raise _make_file_count_error(path)
    with zipfile.ZipFile(path) as archive:
        files = [info for info in archive.infolist() if not info.is_dir() and not _is_link(info)]
        return {info.filename: info.file_size for info in files}


def _is_link(info: zipfile.ZipInfo) -> bool:
    """Return whether an entry of a zip is a symbolic link."""
    return stat.S_ISLNK(info.external_attr >> 16)


def _make_file_count_error(path: Path) -> OverLimit:
    """Return the error for an archive with too many files."""
    return OverLimit(f"{make_printable(path.name)} contains more than {MAX_FILES} files; {NOTEBOOK_ADVICE}")


def _iterate_tar(path: Path) -> Iterator[tuple[tarfile.TarInfo, tarfile.TarFile]]:
    """Yield each entry of a tar archive, which may be compressed, and the open archive. Raises OverLimit."""
    with path.open("rb") as file:
        is_compressed = file.peek(2).startswith(b"\x1f\x8b")
        reader: io.BufferedIOBase = gzip.GzipFile(fileobj=file) if is_compressed else file
        content = io.BytesIO(reader.read(MAX_FILE_BYTES + 1))
    if content.getbuffer().nbytes > MAX_FILE_BYTES:
        size = f"{MAX_FILE_BYTES // 1_000_000} MB"
        raise OverLimit(f"{make_printable(path.name)} unpacks to more than {size}; {NOTEBOOK_ADVICE}")
    with tarfile.open(fileobj=content, mode="r:") as tar:
        for number, info in enumerate(tar):
            if number >= MAX_FILES:
                raise _make_file_count_error(path)
            yield info, tar


# --- a platform's download ---


@contextlib.contextmanager
def unpack_temporarily(path: Path) -> Iterator[tuple[Path, list[str]]]:
    """Unpack a platform's zip into a temporary folder. Yield the folder, and a message about each skipped file.

    Raises Unreadable if the zip can't be unpacked.
    """
    with make_temporary_folder("qdot-submissions-") as folder:
        try:
            with zipfile.ZipFile(path) as archive:
                messages = _unpack(archive, folder)
        except ARCHIVE_ERRORS as error:
            raise Unreadable(f"{path} can't be unpacked: {error}") from None
        yield folder, messages


def _unpack(archive: zipfile.ZipFile, folder: Path) -> list[str]:
    """Unpack a zip into a folder, and return a message about each skipped file. Raises Unreadable."""
    messages, total_size = list[str](), 0
    files = [info for info in archive.infolist() if not info.is_dir()]
    if len(files) > MAX_DOWNLOAD_FILES:
        raise Unreadable(f"{archive.filename} contains more than {MAX_DOWNLOAD_FILES} files")
    for info in files:
        path, reason = _find_safe_path(info.filename), ""
        if path is None:
            reason = "its name leads out of the folder"
        elif _is_link(info):
            reason = "it is a symbolic link"
        elif info.flag_bits & 1:
            reason = "it needs a password"
        else:
            try:
                total_size += _write_member(archive, info, folder / path)
            except ARCHIVE_ERRORS:
                reason = "it is damaged"
        if reason:
            messages.append(f"{make_printable(info.filename)}: {reason}; not unpacked")
        if total_size > MAX_DOWNLOAD_BYTES:
            raise Unreadable(f"{archive.filename} unpacks to more than {MAX_DOWNLOAD_BYTES // 1_000_000_000} GB")
    return messages


def _find_safe_path(name: str) -> PurePosixPath | None:
    """Return the path of a file, relative to the folder for unpacking; None if its name leads out of that folder."""
    path = PurePosixPath(name.replace("\\", "/"))
    if path.is_absolute() or ".." in path.parts or not path.parts or "\0" in name:
        return None
    # File systems allow names of 255 bytes; NFC can make a name a little longer.
    parts = [part if len(part.encode()) <= 240 else part.encode()[:240].decode(errors="ignore") for part in path.parts]
    return PurePosixPath(*(unicodedata.normalize("NFC", part) for part in parts))


def _write_member(archive: zipfile.ZipFile, info: zipfile.ZipInfo, target: Path) -> int:
    """Write a file with the modification time stored in the archive, and return the number of bytes written.

    If a file is too large, only one byte more than the limit is written. Reading that file then reports that it is too
    large.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    remaining = MAX_FILE_BYTES + 1
    with archive.open(info) as source, target.open("wb") as file:
        while remaining > 0 and (block := source.read(min(remaining, 1 << 20))):
            file.write(block)
            remaining -= len(block)
    with contextlib.suppress(ValueError, OverflowError):
        seconds = time.mktime(datetime.datetime(*info.date_time).timetuple())  # noqa: DTZ001 - a zip has no time zone
        os.utime(target, (seconds, seconds))
    return MAX_FILE_BYTES + 1 - remaining
