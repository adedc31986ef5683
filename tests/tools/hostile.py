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
from tests.support.submitting import code_cell
from tests.tools.fuzz import TOKENS, mutate

ATTACKER, NEIGHBOUR = "s02", "s01"


@dataclass(frozen=True)
class Workspace:
    """The folder of all submissions, the student's own folder in it, and a correct notebook."""

    root: Path
    folder: Path
    right: str

    def put(self, name: str, content: bytes) -> Path:
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

_PIECES = (
    "\udcf6", "\udcff\udcfe", "\x1b[2J", "\n", "\r", "\t", "\x7f", "\u202e", "\u200f", "\u200b", "\ufeff", "-", "--",
    "-rf", " ", "  ", ".", "..", "...", "'", '"', "<script>alert(1)</script>", "&amp;", "{{7*7}}", "{% raw %}", "%s",
    "%n", "$(id)", "`id`", ";", "|", "*", "?", "[", "]", "~", "#", "=1+1", "@", ":", "\\", "a" * 120, "ö" * 60,
    "o\u0308", "ﬁ", "İ", "ß", "١", "x" * 255, "\U0001f4a9", "CON", "NUL", "LPT1.", "hw", "s02", "s03", "_LATE_",
    "_123_456_", "true", "_99_assignsubmission_file_", "_99_assignsubmission_onlinetext", "submission_7",
    "submission_metadata.yml", "None", "__MACOSX", ".ipynb_checkpoints", "Thumbs.db", ".git", "assignment.toml",
    "overrides.csv", "results.jsonl", "p1.position",
)  # fmt: skip
_ENDINGS = (
    ".ipynb", ".ipynb", ".ipynb", ".IPYNB", ".ipynb.txt", ".json", ".py", ".md", ".zip", ".tar.gz", ".tar", ".tgz",
    ".txt", ".html", ".pdf", ".rmd", "", ".", ".ipynb ", ".ipynb.ipynb", ".tar.gz.ipynb",
)  # fmt: skip


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
    begin = rng.choice(
        (f"{ATTACKER}_", "Two Bo_99_assignsubmission_file_", "twobo_LATE_7_9_", "twobo_7_9_", "submission_7", "")
    )
    return root / os.fsencode(f"{begin}{noise}")[:255].decode("utf-8", "surrogateescape")


# --- contents of a folder ---


def write_odd_names(workspace: Workspace, rng: Stream) -> None:
    for _ in range(1 + rng.integer_below(6)):
        content = rng.choice((workspace.right, "", "no notebook", "{", "<html>", "p1_position = 1\n"))
        workspace.put("/".join(make_name(rng) for _ in range(1 + rng.integer_below(3))), content.encode())


def write_many_files(workspace: Workspace, rng: Stream) -> None:
    ending, content = rng.choice(_ENDINGS), rng.choice((workspace.right, "", "{}")).encode()
    for number in range(rng.choice((60, 300, 2100))):
        workspace.put(f"{number}{ending}", content)


def write_deep_folders(workspace: Workspace, rng: Stream) -> None:
    step = rng.choice(("d", "d" * 200, "\udcf6", "s02", "ö" * 100))
    workspace.folder.mkdir(parents=True, exist_ok=True)
    top = os.open(workspace.folder, os.O_RDONLY)
    for _ in range(rng.choice((3, 20, 400, 1500))):
        os.mkdir(step, dir_fd=top)
        inner = os.open(step, os.O_RDONLY, dir_fd=top)
        os.close(top)
        top = inner
    file = os.open("hw.ipynb", os.O_WRONLY | os.O_CREAT, dir_fd=top)
    os.write(file, workspace.right.encode())
    os.close(file)
    os.close(top)


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
        os.link(workspace.put("one.ipynb", workspace.right.encode()), workspace.folder / "two.ipynb")


def write_special_file(workspace: Workspace, rng: Stream) -> None:
    file_name = rng.choice(("hw.ipynb", "a.zip", "notes", make_name(rng)))
    workspace.folder.mkdir(parents=True, exist_ok=True)
    path = rng.choice(
        (
            workspace.folder / file_name,
            workspace.folder.with_name(f"{workspace.folder.name}.ipynb"),
            workspace.root / "submission_metadata.yml",
        )
    )
    if rng.integer_below(2):
        os.mkfifo(path)
    else:
        with socket.socket(socket.AF_UNIX) as unix_socket, contextlib.chdir(path.parent):
            unix_socket.bind(path.name)


def restrict_permissions(workspace: Workspace, rng: Stream) -> None:
    path = workspace.put("hw.ipynb", workspace.right.encode())
    (workspace.folder / "folder").mkdir(exist_ok=True)
    target = rng.choice((path, workspace.folder / "folder", workspace.folder))
    target.chmod(rng.choice((0, 0o111, 0o200, 0o444, 0o4777)))


def set_odd_times(workspace: Workspace, rng: Stream) -> None:
    timestamp = rng.choice((0, -1, -(2**31), 2**31, 2**33, 253402300800, -62135596801, 2**34 - 1))
    os.utime(workspace.put("hw.ipynb", workspace.right.encode()), (timestamp, timestamp))


def write_odd_sizes(workspace: Workspace, rng: Stream) -> None:
    kind = rng.integer_below(5)
    if kind == 0:
        workspace.put(
            "hw.ipynb", rng.choice((b"", b" ", b"\n" * 1000, b"\0", b"\xef\xbb\xbf", b"\xff\xfe", b"{", b"[]", b"null"))
        )
    elif kind == 1:
        with workspace.put(rng.choice(("hw.ipynb", "a.zip", "x.txt")), b"{").open("r+b") as file:
            file.truncate(rng.choice((MAX_FILE_BYTES, MAX_FILE_BYTES + 1, 10**12)))
    elif kind == 2:
        output = {"output_type": "stream", "name": "stdout", "text": rng.choice(("x", '"', "\n", "ö")) * 30_000_000}
        workspace.put("hw.ipynb", _edit_cells(workspace, lambda cells: cells[2].update(outputs=[output])).encode())
    elif kind == 3:
        count = rng.choice((3_000, 200_000))
        empty = [code_cell(rng.choice(("", "1", "x = 1", "1/0", "("))) for _ in range(5)]
        workspace.put("hw.ipynb", _edit_cells(workspace, lambda cells: cells.extend(empty * (count // 5))).encode())
    else:
        workspace.put(
            "hw.ipynb", b"{" + rng.choice((b" ", b"[", b'"a":', b",", b"\\")) * rng.choice((10**5, 3 * 10**6))
        )


def write_stray_file(workspace: Workspace, rng: Stream) -> None:
    """Write a platform's metadata file or another stray file, beside the students' folders or in one."""
    workspace.folder.mkdir(parents=True, exist_ok=True)
    metadata_name = "submission_metadata.yml"
    path = rng.choice(
        (workspace.folder / metadata_name, workspace.root / rng.choice((metadata_name, "README.txt", make_name(rng))))
    )
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
    "NaN", "-Infinity", "1e999", "-0", "1" * 5000, "0." + "1" * 5000, "[" * 100_000 + "]" * 100_000,
    "[" * 500 + "]" * 500, '{"a":' * 900 + "1" + "}" * 900, '"\\ud800"', '"\\udc00\\ud800"', '"\\u0000"', '"\x01"',
    "tru", "'a'", "01", "1_0", "", "//", '{"a": 1, "a": 2}', '"' + "\\\\" * 5000 + '"', '"' + "a" * 300_000 + '"',
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
    """Return every place in JSON as its container and its key or index."""
    places, stack = [], [value]
    while stack:
        top = stack.pop()
        keys = list(top) if isinstance(top, dict) else range(len(top)) if isinstance(top, list) else ()
        places += [(top, key) for key in keys]
        stack += [top[key] for key in keys]
    return places


def write_odd_structures(workspace: Workspace, rng: Stream) -> None:
    data = json.loads(workspace.right)
    version = rng.integer_below(6)
    if version == 0:
        sheets: Any = rng.choice(([{"cells": data.pop("cells")}], [], None, {}, [None, [], {"cells": {}}]))
        data.update(nbformat=3, worksheets=sheets)
    elif version == 1:
        data.update(
            nbformat=rng.choice((5, 2, 99, -1, None, "4", 4.5)), nbformat_minor=rng.choice((0, None, "x", 10**9))
        )
    for _ in range(rng.integer_below(5)):
        holder, key = rng.choice(_list_places(data) or [({}, "")])
        way = rng.integer_below(5)
        if way <= 2:
            holder[key] = _choose_odd_value(rng)
        elif way == 3 and key in holder if isinstance(holder, dict) else way == 3:
            del holder[key]
        elif isinstance(holder, dict):
            holder[rng.choice(("", "cells", "source", "qdot", "metadata", "outputs", "\ud800", make_name(rng)))] = (
                _choose_odd_value(rng)
            )
        else:
            holder.insert(0, _choose_odd_value(rng))
    if rng.integer_below(8) == 0:
        data = rng.choice(([data], {"cells": data}, None, "notebook", [[data]], {"metadata": data.get("metadata")}))
    text = json.dumps(data, ensure_ascii=bool(rng.integer_below(2)))
    while f'"{_RAW}"' in text:
        text = text.replace(f'"{_RAW}"', rng.choice(_TEXTS_OF_JSON), 1)
    if rng.integer_below(6) == 0:
        text = (
            text.replace('"cells": ', '"cells": [], "cells": ', 1)
            if rng.integer_below(2)
            else f'{text[:-1]}, "cells": {{}}}}'
        )
    workspace.put(_choose_file_name(rng), text.encode("utf-8", rng.choice(("replace", "surrogatepass"))))


def _choose_file_name(rng: Stream) -> str:
    return rng.choice(("hw.ipynb", "hw.ipynb", "a.ipynb", "a.json", "a.txt", "a.py", "a.md", "a.zip", make_name(rng)))


def write_changed_bytes(workspace: Workspace, rng: Stream) -> None:
    data = bytearray(
        workspace.right.encode(rng.choice(("utf-8", "utf-8", "utf-8", "utf-16", "utf-16-be", "utf-32", "utf-8-sig")))
    )
    for _ in range(1 + rng.integer_below(8)):
        at, length = rng.integer_below(len(data) + 1), 1 + rng.integer_below(200)
        way = rng.integer_below(6)
        if way == 0:
            data[at : at + 1] = bytes([rng.integer_below(256)])
        elif way == 1:
            del data[at : at + length]
        elif way == 2:
            data[at:at] = rng.take_bytes(length)
        elif way == 3:
            data[at:at] = data[at : at + length]
        elif way == 4:
            data[at:at] = rng.choice(
                (b"\0", b"\xff", b"\r", b"\x1a", b"\xed\xa0\x80", b'"', b"{", b"]", b"\\u", b"\xe2\x80\xa8")
            )
        elif rng.integer_below(4) == 0:
            del data[at:]
    magic = rng.choice(
        (b"", b"", b"", b"", b"%PDF", b"PK\x03\x04", b"PK\x05\x06", b"\x1f\x8b", b"\x89PNG", b"\xff\xfe", b"BZh")
    )
    workspace.put(_choose_file_name(rng), magic + bytes(data))


# --- cells ---

_SOURCES = (
    "\x00", "x = '\x00'", "# coding: utf-7\n1", "# -*- coding: latin-1 -*-\n'ö'", "1" * 100_000, "x = " + "(" * 5000,
    "-" * 20_000 + "1", "x = [" + "1," * 50_000 + "]", "lambda: " * 2000 + "1", "a" + ".b" * 20_000,
    "if 1:\n" + " " * 99 + "1", "\t1\n 2", "\f\v1", "\u2028", "%%bash\nrm -rf /", "%%writefile ../../x\n1",
    "%%writefile\n", "%%", "%", "!", "!ls", "files = !ls", "sin?", "??", "%%time\n1/0", "%run x", "%load_ext x",
    "await x", "async with a: pass", "return 1", "yield 1", "break", "input()", "from x import *", "import this",
    "raise SystemExit(3)", "raise KeyboardInterrupt", "raise BaseException('\\ud800')",
    "raise Exception('\\x1b[2J\\n' * 1000)", "import os; os._exit(0)", "import os; os.kill(os.getpid(), 9)",
    "import os; os.abort()", "exit()", "1/0", "while True: pass", "def f(): f()\nf()", "x = 'a' * 10**10",
    "print('x' * 10**7)", "import sys; sys.setrecursionlimit(10**9)\nf = lambda: f()\nf()",
    "import sys; sys.stdout.write('\\ud800')", "import sys; sys.stdout.close(); sys.stderr = None",
    "open('x', 'w').write('x' * 10**8)", "import os\nfor k in range(200): os.makedirs(f'd{k}/' * 3)",
    "import os\nfor k in range(300):\n os.mkdir('d'); os.chdir('d')",
    "class E(Exception):\n def __str__(self): raise self\nraise E",
    "class E(Exception): __name__ = 3\nE.__qualname__ = '\\ud800\\n'\nraise E",
    "import builtins; builtins.str = builtins.repr = None", "import sympy; sympy.Symbol.__new__ = None",
    "globals().clear()", "del __builtins__",
    "import gc\nfor o in gc.get_objects():\n  if isinstance(o, dict): o.clear()",
    "import threading\nthreading.Thread(target=input).start()",
    "import signal; signal.signal(14, signal.SIG_IGN); signal.pause()", "import time; time.sleep(3)",
    "import ctypes; ctypes.string_at(0)", "import atexit; atexit.register(lambda: 1/0)",
    "import warnings; warnings.simplefilter('error'); warnings.warn('x')",
)  # fmt: skip
_VALUES = (
    "None", "...", "NotImplemented", "float('nan')", "oo", "zoo", "1e999", "10**10000", "2**2**2**2**2",
    "Rational(1, 10**3000)", "''", "'\\ud800'", "'\\x00'", "'<script>alert(1)</script>'", "'a1' * 10**5", "'(' * 3000",
    "b'a1'", "[]", "[[[]]]", "{}", "set()", "Matrix(0, 0, [])", "Matrix([[1]] * 500)", "zeros(60, 60)", "Symbol('')",
    "Symbol('\\ud800')", "Symbol('\\x1b[2J')", "Symbol('a1 + a2')", "Symbol('x' * 10**5)", "Function('f')(1)",
    "Derivative(Symbol('x')**2, Symbol('x'))", "Integral(1, (Symbol('x'), 0, 1))",
    "Sum(Symbol('k'), (Symbol('k'), 1, 10**9))", "sum(Symbol(f'x{k}') for k in range(9000))", "Piecewise((1, True))",
    "lambda *a: a", "lambda *a: 1/0", "print", "type", "object()", "range(9)", "(k for k in iter(int, 1))",
    "type('T', (), {'__str__': lambda s: 1/0, '__repr__': lambda s: 3})()", "type('T', (str,), {})('a1')", "I**I",
    "type('T', (Symbol,), {'_sympystr': lambda s, p: 'x' * 10**6})('x')", "blank", "Eq(1, 2)", "True", "S.EmptySet",
    "ImageSet(Lambda(blank, blank), S.Integers)", "'1/0'", "'9^9^9^9'", "'{theta2: [0, pi]}'",
    "'sin(' * 400 + 'a1' + ')' * 400", "'a1 +' * 2000 + 'a1'", "r'\\\\frac{' * 100", "'k*pi ' * 50",
    "(lambda x: x.append(x) or x)([])", "(lambda x: x.update(a=x) or x)({})",
    "__import__('numpy').full((3, 3), float('nan'))", "1j", "True + True",
)  # fmt: skip


def _edit_cells(workspace: Workspace, change: Callable[[list[dict[str, Any]]], Any]) -> str:
    data = json.loads(workspace.right)
    change(data["cells"])
    return json.dumps(data)


def write_hostile_cells(workspace: Workspace, rng: Stream) -> None:
    def change(all_cells: list[dict[str, Any]]) -> None:
        for _ in range(1 + rng.integer_below(4)):
            cell, way = all_cells[2 + rng.integer_below(3)], rng.integer_below(5)
            variable = str(cell["source"]).partition(" = ")[0]
            if way == 0:
                all_cells.insert(rng.integer_below(len(all_cells)), code_cell(rng.choice(_SOURCES)))
            elif way == 1:
                cell["source"] = f"{cell['source']}\n{rng.choice(_SOURCES)}"
            elif way <= 3:
                cell["source"] = f"{variable} = {rng.choice(_VALUES)}"
            else:
                cell["source"] = mutate(str(cell["source"]), rng, (*TOKENS, "\n", "%", "!", "#"), 5000)

    workspace.put("hw.ipynb", _edit_cells(workspace, change).encode())


# --- archives ---


@cache
def _bomb() -> bytes:
    """Return compressed zeros that unpack to more than the size limit."""
    return gzip.compress(b"\0" * (MAX_FILE_BYTES + 10), 1)


def _make_zip(workspace: Workspace, rng: Stream) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(
        buffer, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA))
    ) as archive:
        for _ in range(rng.choice((0, 1, 1, 2, 4))):
            info = zipfile.ZipInfo(
                _choose_member_name(rng),
                rng.choice(((1980, 1, 1, 0, 0, 0), (2107, 15, 31, 31, 63, 62), (2026, 0, 0, 0, 0, 0))),
            )
            info.external_attr = (
                rng.choice((0, stat.S_IFLNK, stat.S_IFIFO, stat.S_IFDIR, stat.S_IFREG | 0o600, 0xFFFF)) << 16
            )
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
    kinds = (
        tarfile.REGTYPE,
        tarfile.REGTYPE,
        tarfile.SYMTYPE,
        tarfile.LNKTYPE,
        tarfile.FIFOTYPE,
        tarfile.CHRTYPE,
        tarfile.DIRTYPE,
        b"S",
        b"x",
        b"L",
        b"Z",
    )
    form = rng.choice((tarfile.USTAR_FORMAT, tarfile.GNU_FORMAT, tarfile.PAX_FORMAT))
    with tarfile.open(fileobj=buffer, mode="w", format=form, errors="surrogateescape") as archive:
        for _ in range(rng.choice((0, 1, 1, 2, 4))):
            info, content = tarfile.TarInfo(_choose_member_name(rng)), _choose_member_content(workspace, rng)
            info.type, info.size, info.linkname = (
                rng.choice(kinds),
                len(content),
                rng.choice(("hw.ipynb", "/etc/passwd", "..", info.name)),
            )
            with contextlib.suppress(ValueError, UnicodeError):
                archive.addfile(info, io.BytesIO(content))
    data = buffer.getvalue()
    return gzip.compress(data, 1) if rng.integer_below(2) else data


def _choose_member_name(rng: Stream) -> str:
    odd = (
        f"../{NEIGHBOUR}/hw.ipynb", "/etc/hw.ipynb", "a/../../hw.ipynb", "C:\\hw.ipynb", "a\\hw.ipynb",
        "__MACOSX/hw.ipynb", "a/" * 2000 + "hw.ipynb", "x" * 60_000 + ".ipynb", "[Content_Types].xml", "mimetype",
        "hw.ipynb/", "", "./", "inner.zip", "a.tar.gz", make_name(rng),
    )  # fmt: skip
    return rng.choice(("hw.ipynb", "a/hw.ipynb", "b.ipynb", "hw.py", "hw.md", rng.choice(odd)))


def _choose_member_content(workspace: Workspace, rng: Stream) -> bytes:
    return rng.choice(
        (
            workspace.right.encode(),
            workspace.right.encode(),
            b"",
            b"{}",
            rng.take_bytes(300),
            b"PK\x03\x04",
            workspace.right[:500].encode(),
        )
    )


def write_archive(workspace: Workspace, rng: Stream) -> None:
    kind = rng.integer_below(12)
    if kind == 0:
        workspace.put(rng.choice(("a.tar.gz", "hw.ipynb", "a.zip")), _bomb())
        return
    content = bytearray((_make_zip if kind % 2 else _make_tar)(workspace, rng))
    for _ in range(rng.choice((0, 0, 1, 3))):
        at, way = rng.integer_below(len(content) + 1), rng.integer_below(5)
        if way == 0:
            del content[at:]
        elif way == 1:
            content[at : at + 4] = rng.choice(
                (b"\xff" * 4, b"\0" * 4, struct.pack("<I", 2**31), b"99999999", rng.take_bytes(4))
            )
        elif way == 2:
            content[at : at + 1] = rng.take_bytes(1)
        elif way == 3:
            content[0:0] = rng.choice((b"#!/bin/sh\n", b"\0" * 512, bytes(content[:600])))
        else:
            content += rng.choice((bytes(content), b"PK\x05\x06" + b"\xff" * 18, b"\0" * 2000))
    workspace.put(rng.choice(("a.zip", "a.tar", "a.tar.gz", "hw.ipynb", "a.tgz", make_name(rng))), bytes(content))


Kind = Callable[[Workspace, Stream], None]
KINDS: dict[str, Kind] = {
    "names": write_odd_names, "many files": write_many_files, "nested": write_deep_folders, "links": write_links,
    "special": write_special_file, "rights": restrict_permissions, "times": set_odd_times, "sizes": write_odd_sizes,
    "stray": write_stray_file, "structures": write_odd_structures, "bytes": write_changed_bytes,
    "cells": write_hostile_cells, "archives": write_archive,
}  # fmt: skip
FREQUENT_KINDS = (*KINDS, "names", "links", *["structures"] * 4, *["bytes"] * 3, *["cells"] * 4, *["archives"] * 4)
"""Kinds to choose from; those with many variants occur more often."""


def submit_random(root: Path, right: str, rng: Stream, choices: tuple[str, ...] = FREQUENT_KINDS) -> str:
    """Write a random hostile submission, and return its description."""
    workspace = Workspace(root, choose_folder(root, rng), right)
    kinds = [rng.choice(choices) for _ in range(1 + rng.integer_below(8) // 6)]
    kinds.sort(key=lambda kind: kind == "links")  # later kinds would write into a linked folder
    if kinds[0] == "links":
        del kinds[1:]
    for kind in kinds:
        with contextlib.suppress(OSError):  # names that are too long, or files that exist
            KINDS[kind](workspace, rng)
    return f"{' and '.join(kinds)} in {workspace.folder.name!a}"
