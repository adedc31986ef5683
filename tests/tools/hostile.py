"""What students might hand in by mistake or in malice, drawn from a seeded stream; `submissions` has it graded.

Every kind is a function that puts something into a student's folder. What a disk refuses to hold is left out.
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
from tests.tools.fuzz import TOKENS, changed

OWN, NEIGHBOUR = "s02", "s01"


@dataclass(frozen=True)
class Desk:
    """Where a student puts things: the folder of all submissions, one's own, and a right notebook of one's own."""

    root: Path
    own: Path
    right: str

    def put(self, name: str, content: bytes) -> Path:
        path = self.own / name.replace("\0", "0").lstrip("/")
        path.parent.mkdir(parents=True, exist_ok=True)
        written(path, content)
        return path


def written(path: Path, content: bytes) -> None:
    """Write a file; neither through a link, which may lead out of what is ours, nor into a pipe that nobody reads."""
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


def name(rng: Stream) -> str:
    drawn = "".join(rng.choice(_PIECES) for _ in range(1 + rng.integer_below(3))).replace("/", "_")
    ending = rng.choice(_ENDINGS)
    drawn = os.fsencode(drawn)[: 255 - len(ending)].decode("utf-8", "surrogateescape") + ending
    return f"{drawn}x" if drawn in (".", "..") else drawn


def own_folder(root: Path, rng: Stream) -> Path:
    """Return what a platform would call the student's folder, with what a student could have a say in at its end."""
    if rng.integer_below(5):
        return root / OWN
    noise = name(rng).replace("\0", "")
    begin = rng.choice(
        (f"{OWN}_", "Two Bo_99_assignsubmission_file_", "twobo_LATE_7_9_", "twobo_7_9_", "submission_7", "")
    )
    return root / os.fsencode(f"{begin}{noise}")[:255].decode("utf-8", "surrogateescape")


# --- what lies in a folder ---


def names(desk: Desk, rng: Stream) -> None:
    for _ in range(1 + rng.integer_below(6)):
        content = rng.choice((desk.right, "", "no notebook", "{", "<html>", "p1_position = 1\n"))
        desk.put("/".join(name(rng) for _ in range(1 + rng.integer_below(3))), content.encode())


def many_files(desk: Desk, rng: Stream) -> None:
    ending, content = rng.choice(_ENDINGS), rng.choice((desk.right, "", "{}")).encode()
    for number in range(rng.choice((60, 300, 2100))):
        desk.put(f"{number}{ending}", content)


def nested(desk: Desk, rng: Stream) -> None:
    step = rng.choice(("d", "d" * 200, "\udcf6", "s02", "ö" * 100))
    desk.own.mkdir(parents=True, exist_ok=True)
    top = os.open(desk.own, os.O_RDONLY)
    for _ in range(rng.choice((3, 20, 400, 1500))):
        os.mkdir(step, dir_fd=top)
        inner = os.open(step, os.O_RDONLY, dir_fd=top)
        os.close(top)
        top = inner
    file = os.open("hw.ipynb", os.O_WRONLY | os.O_CREAT, dir_fd=top)
    os.write(file, desk.right.encode())
    os.close(file)
    os.close(top)


def links(desk: Desk, rng: Stream) -> None:
    targets = (
        "nowhere", ".", "..", "/", "/etc/passwd", "/dev/zero", "/dev/stdin", "/proc/self/fd/0", "/proc/self/mem",
        "hw.ipynb", "loop", f"../{NEIGHBOUR}", f"../{NEIGHBOUR}/hw.ipynb", "../../secret.txt", "../../graded",
        "x" * 255, "x" * 300, "a/" * 2000, "\udcf6", "\n", str(desk.root / NEIGHBOUR / "hw.ipynb"),
    )  # fmt: skip
    for _ in range(1 + rng.integer_below(4)):
        called = rng.choice(("hw.ipynb", "loop", "folder", name(rng)))
        if rng.integer_below(6) == 0:  # the student's whole folder, or file, is a link
            desk.own.parent.mkdir(parents=True, exist_ok=True)
            desk.own.symlink_to(rng.choice(targets))
            return
        desk.own.mkdir(parents=True, exist_ok=True)
        (desk.own / called).symlink_to(rng.choice(targets))
    if rng.integer_below(4) == 0:
        os.link(desk.put("one.ipynb", desk.right.encode()), desk.own / "two.ipynb")


def special(desk: Desk, rng: Stream) -> None:
    called = rng.choice(("hw.ipynb", "a.zip", "notes", name(rng)))
    desk.own.mkdir(parents=True, exist_ok=True)
    place = rng.choice(
        (desk.own / called, desk.own.with_name(f"{desk.own.name}.ipynb"), desk.root / "submission_metadata.yml")
    )
    if rng.integer_below(2):
        os.mkfifo(place)
    else:
        with socket.socket(socket.AF_UNIX) as made, contextlib.chdir(place.parent):
            made.bind(place.name)


def rights(desk: Desk, rng: Stream) -> None:
    path = desk.put("hw.ipynb", desk.right.encode())
    (desk.own / "folder").mkdir(exist_ok=True)
    which = rng.choice((path, desk.own / "folder", desk.own))
    which.chmod(rng.choice((0, 0o111, 0o200, 0o444, 0o4777)))


def times(desk: Desk, rng: Stream) -> None:
    when = rng.choice((0, -1, -(2**31), 2**31, 2**33, 253402300800, -62135596801, 2**34 - 1))
    os.utime(desk.put("hw.ipynb", desk.right.encode()), (when, when))


def sizes(desk: Desk, rng: Stream) -> None:
    drawn = rng.integer_below(5)
    if drawn == 0:
        desk.put(
            "hw.ipynb", rng.choice((b"", b" ", b"\n" * 1000, b"\0", b"\xef\xbb\xbf", b"\xff\xfe", b"{", b"[]", b"null"))
        )
    elif drawn == 1:
        with desk.put(rng.choice(("hw.ipynb", "a.zip", "x.txt")), b"{").open("r+b") as file:
            file.truncate(rng.choice((MAX_FILE_BYTES, MAX_FILE_BYTES + 1, 10**12)))
    elif drawn == 2:
        output = {"output_type": "stream", "name": "stdout", "text": rng.choice(("x", '"', "\n", "ö")) * 30_000_000}
        desk.put("hw.ipynb", _changed_cells(desk, lambda cells: cells[2].update(outputs=[output])).encode())
    elif drawn == 3:
        count = rng.choice((3_000, 200_000))
        empty = [code_cell(rng.choice(("", "1", "x = 1", "1/0", "("))) for _ in range(5)]
        desk.put("hw.ipynb", _changed_cells(desk, lambda cells: cells.extend(empty * (count // 5))).encode())
    else:
        desk.put("hw.ipynb", b"{" + rng.choice((b" ", b"[", b'"a":', b",", b"\\")) * rng.choice((10**5, 3 * 10**6)))


def stray(desk: Desk, rng: Stream) -> None:
    """What a platform has beside the students' folders, there or in one's own, and what is nobody's."""
    desk.own.mkdir(parents=True, exist_ok=True)
    of_platform = "submission_metadata.yml"
    place = rng.choice((desk.own / of_platform, desk.root / rng.choice((of_platform, "README.txt", name(rng)))))
    lines = (
        "submission_7:", "  :submitters:", "  - :sid: s02", "    :name: Two", "  :created_at: 2026-99-21 22:05:07 Z",
             "  :created_at: 9999-12-31 23:59:59 -23:59", "\udcff", '  - :sid: "\\ud800"', "? [", "x" * 10_000,
    )  # fmt: skip
    text = "\n".join(rng.choice(lines) for _ in range(rng.integer_below(12)))
    if rng.integer_below(6) == 0:
        place.mkdir()
    elif rng.integer_below(4) == 0:
        place.symlink_to(rng.choice(("nowhere", place.name, "x" * 300, "/dev/zero")))
    else:
        written(place, text.encode("utf-8", "surrogateescape"))


# --- notebooks ---

_RAW = "@raw@"
_TEXTS_OF_JSON = (
    "NaN", "-Infinity", "1e999", "-0", "1" * 5000, "0." + "1" * 5000, "[" * 100_000 + "]" * 100_000,
    "[" * 500 + "]" * 500, '{"a":' * 900 + "1" + "}" * 900, '"\\ud800"', '"\\udc00\\ud800"', '"\\u0000"', '"\x01"',
    "tru", "'a'", "01", "1_0", "", "//", '{"a": 1, "a": 2}', '"' + "\\\\" * 5000 + '"', '"' + "a" * 300_000 + '"',
)  # fmt: skip


def _odd(rng: Stream) -> Any:
    odd: tuple[Any, ...] = (
        None, True, False, 0, -1, 4.5, 10**30, "", "code", "p1.position", "p9.x", "\ud800", "\x00", "\x1b[2J", "\u202e",
        [], {}, [[]], [None], [1, "a", None], {"": ""}, {"qdot": {}}, {"qdot": None}, {"qdot": {"part": 3}}, [{}],
        ["x = 1\n"] * 3, {"qdot": {"part": "p1.position", "\n": 1}}, {"cells": []}, [{"cells": 1}], "s01", "other",
        "solution", "a" * 500, "<script>alert(1)</script>", _RAW, _RAW, _RAW,
    )  # fmt: skip
    return rng.choice(odd)


def _places(value: Any) -> list[tuple[Any, Any]]:
    """Return every place in JSON, as what holds it and its key or number."""
    found, stack = [], [value]
    while stack:
        top = stack.pop()
        keys = list(top) if isinstance(top, dict) else range(len(top)) if isinstance(top, list) else ()
        found += [(top, key) for key in keys]
        stack += [top[key] for key in keys]
    return found


def structures(desk: Desk, rng: Stream) -> None:
    data = json.loads(desk.right)
    version = rng.integer_below(6)
    if version == 0:
        sheets: Any = rng.choice(([{"cells": data.pop("cells")}], [], None, {}, [None, [], {"cells": {}}]))
        data.update(nbformat=3, worksheets=sheets)
    elif version == 1:
        data.update(
            nbformat=rng.choice((5, 2, 99, -1, None, "4", 4.5)), nbformat_minor=rng.choice((0, None, "x", 10**9))
        )
    for _ in range(rng.integer_below(5)):
        holder, key = rng.choice(_places(data) or [({}, "")])
        way = rng.integer_below(5)
        if way <= 2:
            holder[key] = _odd(rng)
        elif way == 3 and key in holder if isinstance(holder, dict) else way == 3:
            del holder[key]
        elif isinstance(holder, dict):
            holder[rng.choice(("", "cells", "source", "qdot", "metadata", "outputs", "\ud800", name(rng)))] = _odd(rng)
        else:
            holder.insert(0, _odd(rng))
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
    desk.put(_called(rng), text.encode("utf-8", rng.choice(("replace", "surrogatepass"))))


def _called(rng: Stream) -> str:
    return rng.choice(("hw.ipynb", "hw.ipynb", "a.ipynb", "a.json", "a.txt", "a.py", "a.md", "a.zip", name(rng)))


def bytes_changed(desk: Desk, rng: Stream) -> None:
    data = bytearray(
        desk.right.encode(rng.choice(("utf-8", "utf-8", "utf-8", "utf-16", "utf-16-be", "utf-32", "utf-8-sig")))
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
    desk.put(_called(rng), magic + bytes(data))


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


def _changed_cells(desk: Desk, change: Callable[[list[dict[str, Any]]], Any]) -> str:
    data = json.loads(desk.right)
    change(data["cells"])
    return json.dumps(data)


def cells(desk: Desk, rng: Stream) -> None:
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
                cell["source"] = changed(str(cell["source"]), rng, (*TOKENS, "\n", "%", "!", "#"), 5000)

    desk.put("hw.ipynb", _changed_cells(desk, change).encode())


# --- archives ---


@cache
def _bomb() -> bytes:
    """Return zeros that unpack to more than is read."""
    return gzip.compress(b"\0" * (MAX_FILE_BYTES + 10), 1)


def _zip(desk: Desk, rng: Stream) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(
        packed, "w", rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA))
    ) as archive:
        for _ in range(rng.choice((0, 1, 1, 2, 4))):
            info = zipfile.ZipInfo(
                _packed_name(rng),
                rng.choice(((1980, 1, 1, 0, 0, 0), (2107, 15, 31, 31, 63, 62), (2026, 0, 0, 0, 0, 0))),
            )
            info.external_attr = (
                rng.choice((0, stat.S_IFLNK, stat.S_IFIFO, stat.S_IFDIR, stat.S_IFREG | 0o600, 0xFFFF)) << 16
            )
            info.compress_type = archive.compression
            with contextlib.suppress(ValueError, UnicodeError), warnings.catch_warnings(action="ignore"):  # odd names
                archive.writestr(info, _packed_content(desk, rng))
        if rng.integer_below(30) == 0:
            for number in range(10_050):
                archive.writestr(f"{number}.ipynb", b"")
    data = bytearray(packed.getvalue())
    if rng.integer_below(4) == 0:  # said to be encrypted
        for mark, at in ((b"PK\x01\x02", 8), (b"PK\x03\x04", 6)):
            place = data.find(mark)
            if place >= 0:
                data[place + at] |= 1
    return bytes(data)


def _tar(desk: Desk, rng: Stream) -> bytes:
    packed = io.BytesIO()
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
    with tarfile.open(fileobj=packed, mode="w", format=form, errors="surrogateescape") as archive:
        for _ in range(rng.choice((0, 1, 1, 2, 4))):
            info, content = tarfile.TarInfo(_packed_name(rng)), _packed_content(desk, rng)
            info.type, info.size, info.linkname = (
                rng.choice(kinds),
                len(content),
                rng.choice(("hw.ipynb", "/etc/passwd", "..", info.name)),
            )
            with contextlib.suppress(ValueError, UnicodeError):
                archive.addfile(info, io.BytesIO(content))
    data = packed.getvalue()
    return gzip.compress(data, 1) if rng.integer_below(2) else data


def _packed_name(rng: Stream) -> str:
    odd = (
        f"../{NEIGHBOUR}/hw.ipynb", "/etc/hw.ipynb", "a/../../hw.ipynb", "C:\\hw.ipynb", "a\\hw.ipynb",
        "__MACOSX/hw.ipynb", "a/" * 2000 + "hw.ipynb", "x" * 60_000 + ".ipynb", "[Content_Types].xml", "mimetype",
        "hw.ipynb/", "", "./", "inner.zip", "a.tar.gz", name(rng),
    )  # fmt: skip
    return rng.choice(("hw.ipynb", "a/hw.ipynb", "b.ipynb", "hw.py", "hw.md", rng.choice(odd)))


def _packed_content(desk: Desk, rng: Stream) -> bytes:
    return rng.choice(
        (
            desk.right.encode(),
            desk.right.encode(),
            b"",
            b"{}",
            rng.take_bytes(300),
            b"PK\x03\x04",
            desk.right[:500].encode(),
        )
    )


def archives(desk: Desk, rng: Stream) -> None:
    drawn = rng.integer_below(12)
    if drawn == 0:
        desk.put(rng.choice(("a.tar.gz", "hw.ipynb", "a.zip")), _bomb())
        return
    made = bytearray((_zip if drawn % 2 else _tar)(desk, rng))
    for _ in range(rng.choice((0, 0, 1, 3))):
        at, way = rng.integer_below(len(made) + 1), rng.integer_below(5)
        if way == 0:
            del made[at:]
        elif way == 1:
            made[at : at + 4] = rng.choice(
                (b"\xff" * 4, b"\0" * 4, struct.pack("<I", 2**31), b"99999999", rng.take_bytes(4))
            )
        elif way == 2:
            made[at : at + 1] = rng.take_bytes(1)
        elif way == 3:
            made[0:0] = rng.choice((b"#!/bin/sh\n", b"\0" * 512, bytes(made[:600])))
        else:
            made += rng.choice((bytes(made), b"PK\x05\x06" + b"\xff" * 18, b"\0" * 2000))
    desk.put(rng.choice(("a.zip", "a.tar", "a.tar.gz", "hw.ipynb", "a.tgz", name(rng))), bytes(made))


Kind = Callable[[Desk, Stream], None]
KINDS: dict[str, Kind] = {
    "names": names, "many files": many_files, "nested": nested, "links": links, "special": special, "rights": rights,
    "times": times, "sizes": sizes, "stray": stray, "structures": structures, "bytes": bytes_changed, "cells": cells,
    "archives": archives,
}  # fmt: skip
OFTEN = (*KINDS, "names", "links", *["structures"] * 4, *["bytes"] * 3, *["cells"] * 4, *["archives"] * 4)
"""What is drawn from: most of what has most forms."""


def hand_in_drawn(root: Path, right: str, rng: Stream, among: tuple[str, ...] = OFTEN) -> str:
    """Put something drawn into the folder of submissions; return in words what."""
    desk = Desk(root, own_folder(root, rng), right)
    drawn = [rng.choice(among) for _ in range(1 + rng.integer_below(8) // 6)]
    drawn.sort(key=lambda kind: kind == "links")  # what comes after a link to a folder would be put into that
    if drawn[0] == "links":
        del drawn[1:]
    for kind in drawn:
        with contextlib.suppress(OSError):  # names that are too long, what is there already
            KINDS[kind](desk, rng)
    return f"{' and '.join(drawn)} in {desk.own.name!a}"
