"""A file that was handed in as cells: notebooks of any version, scripts, Markdown, and what to hand in instead.

Nothing is executed, and no library reads the file: what is needed of a notebook is the text of its cells, and a file
that is damaged, hostile or enormous is to end in one sentence. Scripts and Markdown are split as jupytext writes them.
A large file is read by this module run as a program, which has limits of memory and time.
"""

import ast
import contextlib
import json
import re
import subprocess
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import PurePath
from typing import Any

LARGEST = 200_000_000
"""Bytes of a file that is read; outputs of 100 MB are no reason to refuse a notebook."""

MOST_VALUES = 12_000_000
"""Values in a JSON file, each of which takes some 60 bytes of memory, however short it is."""

MOST_CODE, MOST_CELLS = 20_000_000, 25_000
"""Characters of code in all cells together, and cells."""

LARGEST_HERE = 1_000_000
"""Bytes of a file that is read in this process: whatever is in it, that takes little memory and time."""

MEMORY, SECONDS = 2_000_000_000, 20
"""Bytes, and seconds of processor time, that reading a larger file may take."""

LONGEST_PARSED = 200_000
"""Characters of a script that Python's own parser is given."""


class Unreadable(Exception):
    """A submission that can't be graded at all; the text says why, to the student."""


class OverLimit(Unreadable):
    """A submission that takes more than a limit allows: it has no mark, and nothing of qdot has failed."""


@dataclass(frozen=True)
class Cell:
    """A cell: its text, the part that its metadata name, and whether it is code."""

    source: str
    part: str | None = None
    is_code: bool = True


@dataclass(frozen=True)
class Content:
    """What a file holds: cells, what its metadata claim, what is to be said of its format, and metadata not of ours."""

    cells: tuple[Cell, ...]
    claims: Mapping[str, Any]
    note: str = ""
    foreign: tuple[str, ...] = ()


SCRIPTS, TEXTS = (".py",), (".md", ".rmd", ".qmd", ".markdown")

INSTEAD = "open it in Jupyter and hand in the notebook itself, the file that ends in .ipynb"

NO_NOTEBOOK = (
    (b"%PDF", "a PDF"), (b"\xd0\xcf\x11\xe0", "a document of an office program"), (b"{\\rtf", "a text document (RTF)"),
    (b"Rar!", "a RAR archive"), (b"7z\xbc\xaf", "a 7-Zip archive"), (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
)  # fmt: skip
"""How files begin that are handed in in place of a notebook."""


def plain(name: str) -> str:
    r"""Return a file's name such that it can stand in a sentence: one line, of no great length.

    >>> print(plain("a\nb.ipynb"))
    a�b.ipynb
    """
    shown = "".join(ch if ch.isprintable() else "\N{REPLACEMENT CHARACTER}" for ch in name)
    return shown if len(shown) <= 120 else f"{shown[:80]}…{shown[-30:]}"


def read_cells(name: str, data: bytes) -> Content:
    """Return what is in a file, told by its content first and by its name only then. Raises Unreadable."""
    said = plain(name)
    if not data.strip():
        raise Unreadable(f"{said} is empty")
    return _content(name, said, data) if len(data) <= LARGEST_HERE else _read_apart(said, data)


def _read_apart(said: str, data: bytes) -> Content:
    """Return what is in a file, read by another process within limits. Raises Unreadable."""
    try:
        program = [sys.executable, "-I", __file__, said, str(MEMORY), str(SECONDS)]
        done = subprocess.run(program, input=data, capture_output=True, timeout=10 * SECONDS)
        told = json.loads(done.stdout)
    except (subprocess.TimeoutExpired, ValueError):  # it was ended, or ran out of memory
        raise OverLimit(_TOO_MUCH.format(said)) from None
    if "why" in told:
        raise (OverLimit if told["is_over_limit"] else Unreadable)(told["why"])
    cells = tuple(Cell(**cell) for cell in told.pop("cells"))
    return Content(cells, **{**told, "foreign": tuple(told["foreign"])})


def main(said: str, memory: str, seconds: str) -> None:
    """Print what is in the file that comes on standard input, as JSON, or why that can't be told."""
    with contextlib.suppress(ImportError):  # as on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (int(memory), int(memory)))
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
    try:
        told: dict[str, Any] = asdict(_content(said, said, sys.stdin.buffer.read()))
    except Unreadable as error:
        told = {"why": str(error), "is_over_limit": isinstance(error, OverLimit)}
    json.dump(told, sys.stdout)


_TOO_MUCH = "{} takes too much memory or time to be read; clear its outputs and hand it in again"


def _content(name: str, said: str, data: bytes) -> Content:
    content = _of_any_kind(name, said, data)
    if sum(len(cell.source) for cell in content.cells if cell.is_code) > MOST_CODE:
        raise OverLimit(f"{said} has more than {MOST_CODE // 1_000_000} MB of code in its cells, too much to be run")
    if len(content.cells) > MOST_CELLS:
        raise OverLimit(f"{said} has more than {MOST_CELLS} cells; hand in the notebook with your answers alone")
    return content


def _of_any_kind(name: str, said: str, data: bytes) -> Content:
    for begin, kind in NO_NOTEBOOK:
        if data.startswith(begin):
            raise Unreadable(f"{said} is {kind}, not a notebook; {INSTEAD}")
    text = _decoded(said, data)
    suffix = PurePath(name).suffix.lower()
    if text.lstrip()[:1] == "{":
        return _notebook(said, text)
    if re.match(r"\s*<(!doctype|html|\?xml)", text[:200], re.IGNORECASE):
        raise Unreadable(f"{said} is a web page, such as an export of a notebook; {INSTEAD}")
    if suffix in TEXTS:
        return _as_text(_of_markdown(text), "Markdown")
    if suffix in SCRIPTS or (suffix == ".txt" and re.search(r"(?m)^p\d+_\w+ *=", text)):
        return _as_text(_of_script(text), "a Python script")
    if suffix in (".ipynb", ".json"):
        raise Unreadable(f"{said} is not a Jupyter notebook, or was cut off (line 1)")
    raise Unreadable(f"{said} is not a notebook; {INSTEAD}")


def _decoded(said: str, data: bytes) -> str:
    """Return the text in whatever encoding an editor has saved it; line ends become those of Unix."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        encodings: Sequence[str] = ("utf-16",)
    elif data[1:2] == b"\0":
        encodings = ("utf-16-le",)
    else:
        encodings = ("utf-8-sig",) if b"\0" in data[:4096] else ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
    raise Unreadable(f"{said} is not a Jupyter notebook: it is not text")


# --- notebooks ---


def _notebook(said: str, text: str) -> Content:
    """Return what is in a notebook of any version. What is wrong is told in our own words."""
    if sum(map(text.count, ",[{")) > MOST_VALUES:
        raise OverLimit(_TOO_MUCH.format(said))
    try:
        data = json.loads(text, object_pairs_hook=_without_outputs, parse_int=float)
    except json.JSONDecodeError as error:
        raise Unreadable(f"{said} {_fault(text, error)}") from None
    except RecursionError:
        raise Unreadable(f"{said} is not a Jupyter notebook: it nests too deeply") from None
    listed = _listed(data)
    if listed is None:
        raise Unreadable(f"{said} is not a Jupyter notebook: it is JSON, but has no cells that can be read")
    own = [_plain(_plain(cell.get("metadata")).get("qdot")) for cell in listed]
    cells = (
        Cell(
            _source(cell), part if isinstance(part := qdot.get("part"), str) else None, cell.get("cell_type") == "code"
        )
        for cell, qdot in zip(listed, own, strict=True)
    )
    foreign = sorted({plain(key) for qdot in own for key, value in qdot.items() if key != "part" or _is_odd(value)})
    return Content(tuple(cells), _plain(_plain(data.get("metadata")).get("qdot")), "", tuple(foreign))


_CONFLICT = re.compile(r"(?m)^(?:<{7} .*|={7}|>{7} .*)$")


def _fault(text: str, error: json.JSONDecodeError) -> str:
    """Return what is wrong with a text that is no JSON."""
    marks = [text.count("\n", 0, mark.start()) + 1 for mark in islice(_CONFLICT.finditer(text), 6)]
    if marks:
        lines = f"line {marks[0]}" if len(marks) == 1 else f"lines {', '.join(map(str, marks))}"
        return (
            f"has conflict markers of Git in it ({lines}): two versions were merged and none was chosen; choose one, "
            "see that it opens in Jupyter, and hand it in again"
        )
    comma = (
        error.pos if text.startswith(",", error.pos) else len(text[: error.pos].rstrip()) - 1
    )  # by version of Python
    if re.compile(r",\s*[\]}]").match(text, max(comma, 0)):
        line = text.count("\n", 0, comma) + 1
        return f"has a comma too many at the end of line {line}; remove it, and hand it in again"
    return f"is not a Jupyter notebook, or was cut off (line {error.lineno})"


def _without_outputs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    return {key: value for key, value in pairs if key != "outputs"}


def _listed(data: dict[str, Any]) -> list[dict[str, Any]] | None:
    """Return the cells as they stand; up to version 3 they are on worksheets."""
    sheets = data.get("worksheets")
    pages = [data.get("cells")]
    if isinstance(sheets, list):
        pages += [_plain(sheet).get("cells") for sheet in sheets]
    lists = [page for page in pages if isinstance(page, list)]
    return [cell for page in lists for cell in page if isinstance(cell, dict)] if lists else None


def _source(cell: dict[str, Any]) -> str:
    """Return a cell's text; up to version 3 that of code is called its input."""
    source = cell.get("source", cell.get("input", ""))
    text = "".join(map(str, source)) if isinstance(source, list) else str(source)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _is_odd(part: Any) -> bool:
    return not isinstance(part, str) or not re.fullmatch(r"[A-Za-z0-9]+\.[A-Za-z0-9-]+", part)


def _plain(value: Any) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


# --- scripts and Markdown ---

_PART = re.compile(r"""\bpart['"]?\s*[:=]\s*['"]?([A-Za-z0-9]+\.[A-Za-z0-9-]+)""")
_PERCENT = re.compile(r"# ?%%((?:\s.*)?)")
_FENCE = re.compile(r"\s*(`{3,}|~{3,})\s*(.*)")
_CODE = re.compile(r"\{?\s*(\{code-cell\}|code-cell|ipython3?|python3?|py|sympy)\b", re.IGNORECASE)


def _as_text(cells: Iterator[Cell], kind: str) -> Content:
    return Content(tuple(islice(cells, MOST_CELLS + 1)), {}, f"it is {kind}, which was read as a notebook")


def _part_in(text: str) -> str | None:
    match = _PART.search(text)
    return match.group(1) if match else None


def _of_script(text: str) -> Iterator[Cell]:
    """Yield the cells of a script: as its lines `# %%` say, else statements between which there is a gap."""
    lines = text.split("\n")
    marks = [(number, match.group(1)) for number, line in enumerate(lines) if (match := _PERCENT.fullmatch(line))]
    if not marks:
        yield from _blocks(text, lines)
        return
    if marks[0][0]:
        yield Cell("\n".join(lines[: marks[0][0]]))
    ends = [number for number, _ in marks[1:]] + [len(lines)]
    for (number, said), end in zip(marks, ends, strict=True):
        body, is_text = lines[number + 1 : end], re.search(r"\[(markdown|md|raw)\]", said)
        if is_text:
            body = [re.sub(r"^# ?", "", line) for line in body]
        yield Cell("\n".join(body).strip("\n"), _part_in(said), not is_text)


def _blocks(text: str, lines: list[str]) -> Iterator[Cell]:
    """Yield statements that follow one another as one cell; a blank line or a comment before one begins the next."""
    begins = [n for n in _statements(text, lines) if n == 0 or not lines[n - 1].strip() or lines[n - 1].startswith("#")]
    for begin, end in zip(begins, [*begins[1:], len(lines)], strict=True):
        top = begin
        while top and lines[top - 1].startswith("#") and not lines[top].startswith("# +"):
            top -= 1
        part = _part_in(lines[top]) if lines[top].startswith("# +") else None
        yield Cell("\n".join(lines[begin:end]).strip("\n"), part)


def _statements(text: str, lines: list[str]) -> list[int]:
    """Return the lines on which statements begin; by the look of them where the script can't be parsed."""
    tree = parsed(text, LONGEST_PARSED)
    if tree is not None:
        first = (min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", ()))]) for node in tree.body)
        return sorted({number - 1 for number in first})
    goes_on = r"[\s#)\]}]|(else|elif|except|finally)\b"
    return [number for number, line in enumerate(lines) if line and not re.match(goes_on, line)]


def parsed(source: str, longest: int) -> ast.Module | None:
    """Return the tree of a text that is Python and not too long; whatever is wrong with it, it is not executed."""
    if len(source) > longest:
        return None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def first_fault(source: str) -> int:
    """Return the line on which a text that is no Python ceases to be; 1 where that can't be told."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            ast.parse(source)
    except SyntaxError as error:
        return error.lineno or 1
    except (ValueError, RecursionError, MemoryError):
        pass
    return 1


def _of_markdown(text: str) -> Iterator[Cell]:
    """Yield fenced Python as code, and what is between as text."""
    fence, info, body = "", "", list[str]()
    for line in text.split("\n"):
        match = _FENCE.fullmatch(line)
        if not fence and match and _CODE.match(match.group(2)):
            yield Cell("\n".join(body), None, False)
            (fence, info), body = match.groups(), []
        elif fence and match and match.group(1).startswith(fence) and not match.group(2):
            yield _fenced(info, body)
            fence, body = "", []
        else:
            body.append(line)
    yield _fenced(info, body) if fence else Cell("\n".join(body), None, False)


def _fenced(info: str, body: list[str]) -> Cell:
    """Return a cell of code without the options that MyST writes above it."""
    header = 0
    if body[:1] == ["---"] and "---" in body[1:]:
        header = body.index("---", 1) + 1
    while header < len(body) and re.match(r":[\w-]+:", body[header]):
        header += 1
    return Cell("\n".join(body[header:]), _part_in("\n".join([info, *body[:header]])))


if __name__ == "__main__":
    main(*sys.argv[1:])
