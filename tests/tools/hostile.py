"""Hostile or broken submissions, generated from a seeded stream; `submissions` grades them.

Every kind is a function that writes something into a student's folder. Names that the disk refuses are left out.
"""

import contextlib
import gzip
import io
import json
import os
import socket
import stat
import struct
import tarfile
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from qdot.exercises.common.stream import Stream
from qdot.grader.submissions.cells import MAX_FILE_BYTES
from tests.support import DATA
from tests.support.submitting import code_cell
from tests.tools.fuzz import TOKENS, mutate

ATTACKER, NEIGHBOUR = "s02", "s01"


@dataclass(frozen=True)
class Workspace:
    """The folder of all submissions, the student's own folder in it, and a correct notebook."""

    root: Path
    folder: Path
    correct_notebook: str

    def write(self, name: str, content: bytes) -> Path:
        path = self.folder / name.replace("\0", "0").lstrip("/")
        path.parent.mkdir(parents=True, exist_ok=True)
        write_safely(path, content)
        return path


def write_safely(path: Path, content: bytes) -> None:
    """Write a file, but neither through a link, which may lead elsewhere, nor into a pipe that nobody reads."""
    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644)
    with os.fdopen(file, "wb") as opened:
        opened.write(content)


# --- names ---

_TEXTS = json.loads((DATA / "hostile.json").read_text(encoding="utf-8"))
_PIECES = (*_TEXTS["pieces"], "a" * 120, "ö" * 60, "x" * 255)
_ENDINGS = tuple(_TEXTS["endings"])


def make_name(rng: Stream) -> str:
    stem = "".join(rng.choice(_PIECES) for _ in range(1 + rng.integer_below(3))).replace("/", "_")
    ending = rng.choice(_ENDINGS)
    stem = os.fsencode(stem)[: 255 - len(ending)].decode("utf-8", "surrogateescape") + ending
    return f"{stem}x" if stem in (".", "..") else stem


def choose_folder(root: Path, rng: Stream) -> Path:
    """Return a folder named like a platform's, ending in text that a student could choose."""
    if rng.integer_below(5):
        return root / ATTACKER
    noise = make_name(rng).replace("\0", "")
    begins = (f"{ATTACKER}_", "Two Bo_99_assignsubmission_file_", "twobo_LATE_7_9_", "twobo_7_9_", "submission_7", "")
    begin = rng.choice(begins)
    return root / os.fsencode(f"{begin}{noise}")[:255].decode("utf-8", "surrogateescape")


# --- contents of a folder ---


def write_odd_names(workspace: Workspace, rng: Stream) -> None:
    for _ in range(1 + rng.integer_below(6)):
        content = rng.choice((workspace.correct_notebook, "", "no notebook", "{", "<html>", "p1_position = 1\n"))
        workspace.write("/".join(make_name(rng) for _ in range(1 + rng.integer_below(3))), content.encode())


def write_many_files(workspace: Workspace, rng: Stream) -> None:
    ending, content = rng.choice(_ENDINGS), rng.choice((workspace.correct_notebook, "", "{}")).encode()
    for number in range(rng.choice((60, 300, 2100))):
        workspace.write(f"{number}{ending}", content)


def write_deep_folders(workspace: Workspace, rng: Stream) -> None:
    step = rng.choice(("d", "d" * 200, "\udcf6", "s02", "ö" * 100))
    workspace.folder.mkdir(parents=True, exist_ok=True)
    descriptor = os.open(workspace.folder, os.O_RDONLY)
    for _ in range(rng.choice((3, 20, 400, 1500))):
        os.mkdir(step, dir_fd=descriptor)
        inner = os.open(step, os.O_RDONLY, dir_fd=descriptor)
        os.close(descriptor)
        descriptor = inner
    file = os.open("hw.ipynb", os.O_WRONLY | os.O_CREAT, dir_fd=descriptor)
    os.write(file, workspace.correct_notebook.encode())
    os.close(file)
    os.close(descriptor)


def write_links(workspace: Workspace, rng: Stream) -> None:
    targets = (
        "nowhere", ".", "..", "/", "/etc/passwd", "/dev/zero", "/dev/stdin", "/proc/self/fd/0", "/proc/self/mem",
        "hw.ipynb", "loop", f"../{NEIGHBOUR}", f"../{NEIGHBOUR}/hw.ipynb", "../../secret.txt", "../../graded",
        "x" * 255, "x" * 300, "a/" * 2000, "\udcf6", "\n", str(workspace.root / NEIGHBOUR / "hw.ipynb"),
    )  # fmt: skip
    for _ in range(1 + rng.integer_below(4)):
        link_name = rng.choice(("hw.ipynb", "loop", "folder", make_name(rng)))
        if rng.integer_below(6) == 0:  # the student's whole folder, or file, is a link
            workspace.folder.parent.mkdir(parents=True, exist_ok=True)
            workspace.folder.symlink_to(rng.choice(targets))
            return
        workspace.folder.mkdir(parents=True, exist_ok=True)
        (workspace.folder / link_name).symlink_to(rng.choice(targets))
    if rng.integer_below(4) == 0:
        os.link(workspace.write("one.ipynb", workspace.correct_notebook.encode()), workspace.folder / "two.ipynb")


def write_special_file(workspace: Workspace, rng: Stream) -> None:
    file_name = rng.choice(("hw.ipynb", "a.zip", "notes", make_name(rng)))
    workspace.folder.mkdir(parents=True, exist_ok=True)
    single_file = workspace.folder.with_name(f"{workspace.folder.name}.ipynb")
    path = rng.choice((workspace.folder / file_name, single_file, workspace.root / "submission_metadata.yml"))
    if rng.integer_below(2):
        os.mkfifo(path)
    else:
        with socket.socket(socket.AF_UNIX) as unix_socket, contextlib.chdir(path.parent):
            unix_socket.bind(path.name)


def restrict_permissions(workspace: Workspace, rng: Stream) -> None:
    path = workspace.write("hw.ipynb", workspace.correct_notebook.encode())
    (workspace.folder / "folder").mkdir(exist_ok=True)
    target = rng.choice((path, workspace.folder / "folder", workspace.folder))
    target.chmod(rng.choice((0, 0o111, 0o200, 0o444, 0o4777)))


def set_odd_times(workspace: Workspace, rng: Stream) -> None:
    timestamp = rng.choice((0, -1, -(2**31), 2**31, 2**33, 253402300800, -62135596801, 2**34 - 1))
    os.utime(workspace.write("hw.ipynb", workspace.correct_notebook.encode()), (timestamp, timestamp))


def write_odd_sizes(workspace: Workspace, rng: Stream) -> None:
    choice = rng.integer_below(5)
    if choice == 0:
        contents = (b"", b" ", b"\n" * 1000, b"\0", b"\xef\xbb\xbf", b"\xff\xfe", b"{", b"[]", b"null")
        workspace.write("hw.ipynb", rng.choice(contents))
    elif choice == 1:
        with workspace.write(rng.choice(("hw.ipynb", "a.zip", "x.txt")), b"{").open("r+b") as file:
            file.truncate(rng.choice((MAX_FILE_BYTES, MAX_FILE_BYTES + 1, 10**12)))
    elif choice == 2:
        output = {"output_type": "stream", "name": "stdout", "text": rng.choice(("x", '"', "\n", "ö")) * 30_000_000}
        workspace.write("hw.ipynb", _edit_cells(workspace, lambda cells: cells[2].update(outputs=[output])).encode())
    elif choice == 3:
        count = rng.choice((3_000, 200_000))
        empty = [code_cell(rng.choice(("", "1", "x = 1", "1/0", "("))) for _ in range(5)]
        workspace.write("hw.ipynb", _edit_cells(workspace, lambda cells: cells.extend(empty * (count // 5))).encode())
    else:
        repeated = rng.choice((b" ", b"[", b'"a":', b",", b"\\"))
        workspace.write("hw.ipynb", b"{" + repeated * rng.choice((10**5, 3 * 10**6)))


def write_stray_file(workspace: Workspace, rng: Stream) -> None:
    """Write a platform's metadata file or another stray file, beside the students' folders or in one."""
    workspace.folder.mkdir(parents=True, exist_ok=True)
    metadata_name = "submission_metadata.yml"
    name_beside_folders = rng.choice((metadata_name, "README.txt", make_name(rng)))
    path = rng.choice((workspace.folder / metadata_name, workspace.root / name_beside_folders))
    lines = (
        "submission_7:", "  :submitters:", "  - :sid: s02", "    :name: Two", "  :created_at: 2026-99-21 22:05:07 Z",
             "  :created_at: 9999-12-31 23:59:59 -23:59", "\udcff", '  - :sid: "\\ud800"', "? [", "x" * 10_000,
    )  # fmt: skip
    text = "\n".join(rng.choice(lines) for _ in range(rng.integer_below(12)))
    if rng.integer_below(6) == 0:
        path.mkdir()
    elif rng.integer_below(4) == 0:
        path.symlink_to(rng.choice(("nowhere", path.name, "x" * 300, "/dev/zero")))
    else:
        write_safely(path, text.encode("utf-8", "surrogateescape"))


# --- notebooks ---

_RAW = "@raw@"
_TEXTS_OF_JSON = (
    *_TEXTS["texts_of_json"], "1" * 5000, "0." + "1" * 5000, "[" * 100_000 + "]" * 100_000, "[" * 500 + "]" * 500,
    '{"a":' * 900 + "1" + "}" * 900, '"' + "\\\\" * 5000 + '"', '"' + "a" * 300_000 + '"',
)  # fmt: skip


def _choose_odd_value(rng: Stream) -> Any:
    values: tuple[Any, ...] = (
        None, True, False, 0, -1, 4.5, 10**30, "", "code", "p1.position", "p9.x", "\ud800", "\x00", "\x1b[2J", "\u202e",
        [], {}, [[]], [None], [1, "a", None], {"": ""}, {"qdot": {}}, {"qdot": None}, {"qdot": {"part": 3}}, [{}],
        ["x = 1\n"] * 3, {"qdot": {"part": "p1.position", "\n": 1}}, {"cells": []}, [{"cells": 1}], "s01", "other",
        "solution", "a" * 500, "<script>alert(1)</script>", _RAW, _RAW, _RAW,
    )  # fmt: skip
    return rng.choice(values)


def _list_places(value: Any) -> list[tuple[Any, Any]]:
    places, stack = [], [value]
    while stack:
        container = stack.pop()
        if isinstance(container, (dict, list)):
            keys = list(container) if isinstance(container, dict) else range(len(container))
            places += [(container, key) for key in keys]
            stack += [container[key] for key in keys]
    return places


def write_odd_structures(workspace: Workspace, rng: Stream) -> None:
    data = json.loads(workspace.correct_notebook)
    version = rng.integer_below(6)
    if version == 0:
        sheets: Any = rng.choice(([{"cells": data.pop("cells")}], [], None, {}, [None, [], {"cells": {}}]))
        data.update(nbformat=3, worksheets=sheets)
    elif version == 1:
        data["nbformat"] = rng.choice((5, 2, 99, -1, None, "4", 4.5))
        data["nbformat_minor"] = rng.choice((0, None, "x", 10**9))
    for _ in range(rng.integer_below(5)):
        holder, key = rng.choice(_list_places(data) or [({}, "")])
        change_number = rng.integer_below(5)
        if change_number <= 2:
            holder[key] = _choose_odd_value(rng)
        elif change_number == 3 and (isinstance(holder, list) or key in holder):
            del holder[key]
        elif isinstance(holder, dict):
            names = ("", "cells", "source", "qdot", "metadata", "outputs", "\ud800", make_name(rng))
            holder[rng.choice(names)] = _choose_odd_value(rng)
        else:
            holder.insert(0, _choose_odd_value(rng))
    if rng.integer_below(8) == 0:
        data = rng.choice(([data], {"cells": data}, None, "notebook", [[data]], {"metadata": data.get("metadata")}))
    text = json.dumps(data, ensure_ascii=bool(rng.integer_below(2)))
    while f'"{_RAW}"' in text:
        text = text.replace(f'"{_RAW}"', rng.choice(_TEXTS_OF_JSON), 1)
    if rng.integer_below(6) == 0:
        twice = text.replace('"cells": ', '"cells": [], "cells": ', 1)
        text = rng.choice((twice, f'{text[:-1]}, "cells": {{}}}}'))
    workspace.write(_choose_file_name(rng), text.encode("utf-8", rng.choice(("replace", "surrogatepass"))))


def _choose_file_name(rng: Stream) -> str:
    return rng.choice(("hw.ipynb", "hw.ipynb", "a.ipynb", "a.json", "a.txt", "a.py", "a.md", "a.zip", make_name(rng)))


def write_changed_bytes(workspace: Workspace, rng: Stream) -> None:
    encoding = rng.choice(("utf-8", "utf-8", "utf-8", "utf-16", "utf-16-be", "utf-32", "utf-8-sig"))
    data = bytearray(workspace.correct_notebook.encode(encoding))
    for _ in range(1 + rng.integer_below(8)):
        start, length = rng.integer_below(len(data) + 1), 1 + rng.integer_below(200)
        change_number = rng.integer_below(6)
        if change_number == 0:
            data[start : start + 1] = bytes([rng.integer_below(256)])
        elif change_number == 1:
            del data[start : start + length]
        elif change_number == 2:
            data[start:start] = rng.take_bytes(length)
        elif change_number == 3:
            data[start:start] = data[start : start + length]
        elif change_number == 4:
            odd_bytes = (b"\0", b"\xff", b"\r", b"\x1a", b"\xed\xa0\x80", b'"', b"{", b"]", b"\\u", b"\xe2\x80\xa8")
            data[start:start] = rng.choice(odd_bytes)
        elif rng.integer_below(4) == 0:
            del data[start:]
    magics = (b"%PDF", b"PK\x03\x04", b"PK\x05\x06", b"\x1f\x8b", b"\x89PNG", b"\xff\xfe", b"BZh")
    workspace.write(_choose_file_name(rng), rng.choice((*[b""] * 4, *magics)) + bytes(data))


# --- cells ---

_SOURCES = (
    *_TEXTS["sources"], "1" * 100_000, "x = " + "(" * 5000, "-" * 20_000 + "1", "x = [" + "1," * 50_000 + "]",
    "lambda: " * 2000 + "1", "a" + ".b" * 20_000, "if 1:\n" + " " * 99 + "1",
)  # fmt: skip
_VALUES = tuple(_TEXTS["values"])


def _edit_cells(workspace: Workspace, change: Callable[[list[dict[str, Any]]], Any]) -> str:
    data = json.loads(workspace.correct_notebook)
    change(data["cells"])
    return json.dumps(data)


def write_hostile_cells(workspace: Workspace, rng: Stream) -> None:
    def change(all_cells: list[dict[str, Any]]) -> None:
        for _ in range(1 + rng.integer_below(4)):
            cell, change_number = all_cells[2 + rng.integer_below(3)], rng.integer_below(5)
            variable = str(cell["source"]).partition(" = ")[0]
            if change_number == 0:
                all_cells.insert(rng.integer_below(len(all_cells)), code_cell(rng.choice(_SOURCES)))
            elif change_number == 1:
                cell["source"] = f"{cell['source']}\n{rng.choice(_SOURCES)}"
            elif change_number <= 3:
                cell["source"] = f"{variable} = {rng.choice(_VALUES)}"
            else:
                cell["source"] = mutate(str(cell["source"]), rng, (*TOKENS, "\n", "%", "!", "#"), 5000)

    workspace.write("hw.ipynb", _edit_cells(workspace, change).encode())


# --- archives ---


@cache
def _make_bomb() -> bytes:
    return gzip.compress(b"\0" * (MAX_FILE_BYTES + 10), 1)


def _make_zip(workspace: Workspace, rng: Stream) -> bytes:
    buffer = io.BytesIO()
    methods = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)
    times = ((1980, 1, 1, 0, 0, 0), (2107, 15, 31, 31, 63, 62), (2026, 0, 0, 0, 0, 0))
    modes = (0, stat.S_IFLNK, stat.S_IFIFO, stat.S_IFDIR, stat.S_IFREG | 0o600, 0xFFFF)
    with zipfile.ZipFile(buffer, "w", rng.choice(methods)) as archive:
        for _ in range(rng.choice((0, 1, 1, 2, 4))):
            info = zipfile.ZipInfo(_choose_member_name(rng), rng.choice(times))
            info.external_attr = rng.choice(modes) << 16
            info.compress_type = archive.compression
            with contextlib.suppress(ValueError, UnicodeError), warnings.catch_warnings(action="ignore"):  # odd names
                archive.writestr(info, _choose_member_content(workspace, rng))
        if rng.integer_below(30) == 0:
            for number in range(10_050):
                archive.writestr(f"{number}.ipynb", b"")
    data = bytearray(buffer.getvalue())
    if rng.integer_below(4) == 0:  # marked as encrypted
        for signature, offset in ((b"PK\x01\x02", 8), (b"PK\x03\x04", 6)):
            start = data.find(signature)
            if start >= 0:
                data[start + offset] |= 1
    return bytes(data)


def _make_tar(workspace: Workspace, rng: Stream) -> bytes:
    buffer = io.BytesIO()
    usual_types = (tarfile.REGTYPE, tarfile.REGTYPE, tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.FIFOTYPE)
    types = (*usual_types, tarfile.CHRTYPE, tarfile.DIRTYPE, b"S", b"x", b"L", b"Z")
    targets = ("hw.ipynb", "/etc/passwd", "..")
    tar_format = rng.choice((tarfile.USTAR_FORMAT, tarfile.GNU_FORMAT, tarfile.PAX_FORMAT))
    with tarfile.open(fileobj=buffer, mode="w", format=tar_format, errors="surrogateescape") as archive:
        for _ in range(rng.choice((0, 1, 1, 2, 4))):
            info, content = tarfile.TarInfo(_choose_member_name(rng)), _choose_member_content(workspace, rng)
            info.type, info.size, info.linkname = rng.choice(types), len(content), rng.choice((*targets, info.name))
            with contextlib.suppress(ValueError, UnicodeError):
                archive.addfile(info, io.BytesIO(content))
    data = buffer.getvalue()
    return gzip.compress(data, 1) if rng.integer_below(2) else data


def _choose_member_name(rng: Stream) -> str:
    odd_names = (
        f"../{NEIGHBOUR}/hw.ipynb", "/etc/hw.ipynb", "a/../../hw.ipynb", "C:\\hw.ipynb", "a\\hw.ipynb",
        "__MACOSX/hw.ipynb", "a/" * 2000 + "hw.ipynb", "x" * 60_000 + ".ipynb", "[Content_Types].xml", "mimetype",
        "hw.ipynb/", "", "./", "inner.zip", "a.tar.gz", make_name(rng),
    )  # fmt: skip
    return rng.choice(("hw.ipynb", "a/hw.ipynb", "b.ipynb", "hw.py", "hw.md", rng.choice(odd_names)))


def _choose_member_content(workspace: Workspace, rng: Stream) -> bytes:
    notebook = workspace.correct_notebook.encode()
    return rng.choice((notebook, notebook, b"", b"{}", rng.take_bytes(300), b"PK\x03\x04", notebook[:500]))


def write_archive(workspace: Workspace, rng: Stream) -> None:
    choice = rng.integer_below(12)
    if choice == 0:
        workspace.write(rng.choice(("a.tar.gz", "hw.ipynb", "a.zip")), _make_bomb())
        return
    content = bytearray((_make_zip if choice % 2 else _make_tar)(workspace, rng))
    for _ in range(rng.choice((0, 0, 1, 3))):
        start, change_number = rng.integer_below(len(content) + 1), rng.integer_below(5)
        if change_number == 0:
            del content[start:]
        elif change_number == 1:
            content[start : start + 4] = rng.choice(
                (b"\xff" * 4, b"\0" * 4, struct.pack("<I", 2**31), b"99999999", rng.take_bytes(4))
            )
        elif change_number == 2:
            content[start : start + 1] = rng.take_bytes(1)
        elif change_number == 3:
            content[0:0] = rng.choice((b"#!/bin/sh\n", b"\0" * 512, bytes(content[:600])))
        else:
            content += rng.choice((bytes(content), b"PK\x05\x06" + b"\xff" * 18, b"\0" * 2000))
    workspace.write(rng.choice(("a.zip", "a.tar", "a.tar.gz", "hw.ipynb", "a.tgz", make_name(rng))), bytes(content))


Kind = Callable[[Workspace, Stream], None]
KINDS: dict[str, Kind] = {
    "names": write_odd_names, "many files": write_many_files, "nested": write_deep_folders, "links": write_links,
    "special": write_special_file, "rights": restrict_permissions, "times": set_odd_times, "sizes": write_odd_sizes,
    "stray": write_stray_file, "structures": write_odd_structures, "bytes": write_changed_bytes,
    "cells": write_hostile_cells, "archives": write_archive,
}  # fmt: skip
FREQUENT_KINDS = (*KINDS, "names", "links", *["structures"] * 4, *["bytes"] * 3, *["cells"] * 4, *["archives"] * 4)
"""Kinds to choose from; those with many variants occur more often."""


def submit_random(root: Path, correct_notebook: str, rng: Stream, choices: tuple[str, ...] = FREQUENT_KINDS) -> str:
    workspace = Workspace(root, choose_folder(root, rng), correct_notebook)
    kinds = [rng.choice(choices) for _ in range(1 + rng.integer_below(8) // 6)]
    kinds.sort(key=lambda kind: kind == "links")  # later kinds would write into a linked folder
    if kinds[0] == "links":
        del kinds[1:]
    for kind in kinds:
        with contextlib.suppress(OSError):  # names that are too long, or files that exist
            KINDS[kind](workspace, rng)
    return f"{' and '.join(kinds)} in {workspace.folder.name!a}"
