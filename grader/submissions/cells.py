"""Split a submitted file into cells: notebooks, scripts and Markdown. Other files are refused.

Nothing is executed. No notebook library is used: only the text of the cells is needed, and the student must get one
clear sentence about a damaged, hostile or enormous file. Scripts and Markdown are split in the formats of jupytext. A
large file is parsed by this module in a separate process, with limits of memory and time.
"""

import ast
import contextlib
import json
import re
import subprocess
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import islice
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # this module is also run as a program, which must start quickly
    from qdot.exercises.notebook.self_check import Problems

MAX_FILE_BYTES = 200_000_000
"""Maximum size of a file in bytes; it allows for a notebook with outputs of 100 MB."""

MAX_JSON_VALUES = 12_000_000
"""Maximum number of values in a JSON file; even a short value takes about 60 bytes of memory."""

MAX_CODE_CHARACTERS, MAX_CELLS = 20_000_000, 25_000
"""Maximum number of characters of code in all cells together, and maximum number of cells."""

MAX_BYTES_IN_THIS_PROCESS = 1_000_000
"""Maximum size in bytes of a file that this process parses itself, because parsing takes little memory and time."""

MAX_MEMORY_BYTES, MAX_SECONDS = 2_000_000_000, 20
"""Maximum memory in bytes, and processor time in seconds, for parsing a larger file in a separate process."""

MAX_SCRIPT_CHARACTERS = 200_000
"""Maximum length in characters of a script that is passed to Python's parser."""


class Unreadable(Exception):
    """Raised if a submission can't be graded at all; the text explains why to the student."""


class OverLimit(Unreadable):
    """Raised if a submission exceeds a limit. The submission then gets no mark, but this is not qdot's failure."""


@dataclass(frozen=True)
class Cell:
    """A cell of a notebook: its text, the part of the assignment named in its metadata, and whether it is code."""

    source: str
    part: str | None = None
    is_code: bool = True


@dataclass(frozen=True)
class Content:
    """The content of a submitted file: the cells, qdot's metadata of the notebook, and a note on the file's format.

    The note is empty for a notebook. `unknown_metadata` lists the keys of cell metadata that qdot did not write.
    """

    cells: tuple[Cell, ...]
    qdot_metadata: Mapping[str, Any]
    note: str = ""
    unknown_metadata: Sequence[str] = ()


SCRIPT_ENDINGS, MARKDOWN_ENDINGS = (".py",), (".md", ".rmd", ".qmd", ".markdown")
"""Endings of the names of scripts and of Markdown files."""

NOTEBOOK_ADVICE = "submit the notebook itself, the file that ends with .ipynb"
"""Advice at the end of messages about other files."""

OTHER_FILE_TYPES = (
    (b"%PDF", "a PDF"), (b"\xd0\xcf\x11\xe0", "an office document"), (b"{\\rtf", "a text document (RTF)"),
    (b"Rar!", "a RAR archive"), (b"7z\xbc\xaf", "a 7-Zip archive"), (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
)  # fmt: skip
"""First bytes of files that are not notebooks, and what they are called in messages."""


def make_printable(name: str) -> str:
    r"""Return a file's name for use in a sentence: one line of limited length.

    >>> print(make_printable("a\nb.ipynb"))
    a�b.ipynb
    """
    printable_text = "".join(char if char.isprintable() else "\N{REPLACEMENT CHARACTER}" for char in name)
    return printable_text if len(printable_text) <= 120 else f"{printable_text[:80]}…{printable_text[-30:]}"


def read_cells(name: str, data: bytes) -> Content:
    """Return the content of a file, recognised by its first bytes, else by its name. Raises Unreadable."""
    label = make_printable(name)
    if not data.strip():
        raise Unreadable(f"{label} is empty")
    if len(data) <= MAX_BYTES_IN_THIS_PROCESS:
        return _read_within_limits(name, label, data)
    return _read_in_subprocess(label, data)


def _read_in_subprocess(label: str, data: bytes) -> Content:
    """Return the content of a file, parsed by another process within limits. Raises Unreadable."""
    try:
        program = [sys.executable, "-I", __file__, label, str(MAX_MEMORY_BYTES), str(MAX_SECONDS)]
        process = subprocess.run(program, input=data, capture_output=True, timeout=10 * MAX_SECONDS)
        report = json.loads(process.stdout)
    except (subprocess.TimeoutExpired, ValueError):  # the process was killed, or ran out of memory
        raise OverLimit(_TOO_LARGE.format(label)) from None
    if "why" in report:
        raise (OverLimit if report["is_over_limit"] else Unreadable)(report["why"])
    return Content(tuple(Cell(**cell) for cell in report.pop("cells")), **report)


def print_content(label: str, memory: str, seconds: str) -> None:
    """Print the content of the file on standard input as JSON, or the reason why that file is unreadable.

    `label` is the file's name for messages. The other arguments limit this process, in bytes and in seconds.
    """
    with contextlib.suppress(ImportError):  # raised on Windows
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (int(memory), int(memory)))
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
    try:
        report: dict[str, Any] = asdict(_read_within_limits(label, label, sys.stdin.buffer.read()))
    except Unreadable as error:
        report = {"why": str(error), "is_over_limit": isinstance(error, OverLimit)}
    json.dump(report, sys.stdout)


_TOO_LARGE = "reading {} takes too much memory or time; clear its outputs and submit it again"
"""The message on a file that takes too much memory or time; the braces stand for the file's name."""


def _read_within_limits(name: str, label: str, data: bytes) -> Content:
    """Return the content of a file, whose name in messages is `label`. Raises Unreadable, also for too many cells."""
    content = _parse_content(name, label, data)
    if sum(len(cell.source) for cell in content.cells if cell.is_code) > MAX_CODE_CHARACTERS:
        size = f"{MAX_CODE_CHARACTERS // 1_000_000} MB"
        raise OverLimit(f"{label} has more than {size} of code in its cells; remove code that is not part of an answer")
    if len(content.cells) > MAX_CELLS:
        raise OverLimit(f"{label} has more than {MAX_CELLS} cells; submit a notebook with only your answers")
    return content


def _parse_content(name: str, label: str, data: bytes) -> Content:
    """Return the content of a file of any size. Raises Unreadable."""
    for first_bytes, file_type in OTHER_FILE_TYPES:
        if data.startswith(first_bytes):
            raise Unreadable(f"{label} is {file_type}, not a notebook; {NOTEBOOK_ADVICE}")
    text = _decode(label, data)
    suffix = PurePath(name).suffix.lower()
    if text.lstrip()[:1] == "{":
        return _parse_notebook(label, text)
    if re.match(r"\s*<(!doctype|html|\?xml)", text[:200], re.IGNORECASE):
        raise Unreadable(f"{label} is a web page, such as an export of a notebook; {NOTEBOOK_ADVICE}")
    if suffix in MARKDOWN_ENDINGS:
        return _make_text_content(_split_markdown(text), "Markdown")
    if suffix in SCRIPT_ENDINGS or (suffix == ".txt" and re.search(r"(?m)^p\d+_\w+ *=", text)):
        return _make_text_content(_split_script(text), "a Python script")
    if suffix in (".ipynb", ".json"):
        raise Unreadable(f"{label} is not a Jupyter notebook, or it is incomplete (an error in line 1 of the file)")
    raise Unreadable(f"{label} is not a notebook; {NOTEBOOK_ADVICE}")


def _decode(label: str, data: bytes) -> str:
    """Return the text of a file in any encoding that editors use, with Unix line ends. Raises Unreadable."""
    # latin-1 decodes any bytes, so it is not tried if a zero byte shows that the file may not be text.
    encodings = ["utf-8-sig"] if b"\0" in data[:4096] else ["utf-8-sig", "cp1252", "latin-1"]
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        encodings = ["utf-16"]
    elif data[1:2] == b"\0":  # UTF-16 without a byte order mark
        encodings = ["utf-16-le"]
    for encoding in encodings:
        with contextlib.suppress(UnicodeDecodeError):
            return _use_unix_newlines(data.decode(encoding))
    raise Unreadable(f"{label} is not a Jupyter notebook: it is not text")


def _use_unix_newlines(text: str) -> str:
    """Return a text with the line ends of Windows and of old Macs replaced by newlines."""
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


# --- notebooks ---


def _parse_notebook(label: str, text: str) -> Content:
    """Return the content of a notebook. Raises Unreadable, with a message for students."""
    if sum(map(text.count, ",[{")) > MAX_JSON_VALUES:  # one of these characters precedes each value
        raise OverLimit(_TOO_LARGE.format(label))
    try:
        # Integers are parsed as floats, because Python refuses integers with thousands of digits.
        data = json.loads(text, object_pairs_hook=_drop_outputs, parse_int=float)
    except json.JSONDecodeError as error:
        cause = ""
        if re.search(r"(?m)^(<{7} .*|={7}|>{7} .*)$", text):
            cause = ", because it contains conflict markers of Git; finish the merge and submit it again"
        problem = f"is not a Jupyter notebook, or it is incomplete (an error in line {error.lineno} of the file)"
        raise Unreadable(f"{label} {problem}{cause}") from None
    except RecursionError:
        raise Unreadable(f"{label} is not a Jupyter notebook: it is nested too deeply") from None
    if not isinstance(data.get("cells"), list):
        raise Unreadable(f"{label} is not a Jupyter notebook: it is JSON, but has no valid cells")
    raw_cells = [cell for cell in data["cells"] if isinstance(cell, dict)]
    metadata = [find_qdot_metadata(cell) for cell in raw_cells]
    parts = [part if isinstance(part := entry.get("part"), str) else None for entry in metadata]
    are_code = [cell.get("cell_type") == "code" for cell in raw_cells]
    cells = tuple(map(Cell, map(_get_cell_text, raw_cells), parts, are_code))
    items = [item for entry in metadata for item in entry.items()]
    unknown_keys = {make_printable(key) for key, value in items if key != "part" or not _is_part_name(value)}
    return Content(cells, find_qdot_metadata(data), "", sorted(unknown_keys))


def _drop_outputs(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object without outputs, which would take much memory."""
    return {key: value for key, value in pairs if key != "outputs"}


def _get_cell_text(cell: dict[str, Any]) -> str:
    source = cell.get("source", "")
    return _use_unix_newlines("".join(map(str, source)) if isinstance(source, list) else str(source))


def _is_part_name(value: Any) -> bool:
    """Return whether a value is the name of a part, such as "p1.jacobian"."""
    return isinstance(value, str) and re.fullmatch(r"[A-Za-z0-9]+\.[A-Za-z0-9-]+", value) is not None


def find_qdot_metadata(item: dict[str, Any]) -> dict[str, Any]:
    """Return qdot's metadata of a notebook or of a cell; an empty dictionary if there are none."""
    return dict_or_empty(dict_or_empty(item.get("metadata")).get("qdot"))


def dict_or_empty(value: Any) -> dict[str, Any]:
    """Return a value that should be a dictionary; an empty dictionary if the value is anything else."""
    return value if isinstance(value, dict) else {}


# --- scripts and Markdown ---

_PART_NAME = re.compile(r"""\bpart['"]?\s*[:=]\s*['"]?([A-Za-z0-9]+\.[A-Za-z0-9-]+)""")
"""Matches the option of a cell that names its part, as in part="p1.jacobian"; the group is the part."""
_CELL_HEADER = re.compile(r"# ?%%((?:\s.*)?)")
"""Matches the line before a cell of a script; the group is what follows # %%."""
_FENCE_LINE = re.compile(r"\s*(`{3,}|~{3,})\s*(.*)")
"""Matches a line of Markdown that begins or ends a block of code; the groups are the fence and the text after it."""
_PYTHON_FENCE = re.compile(r"\{?\s*(\{code-cell\}|code-cell|ipython3?|python3?|py|sympy)\b", re.IGNORECASE)
"""Matches the text after a fence that begins a block of Python code."""


def _make_text_content(cells: Iterator[Cell], file_type: str) -> Content:
    """Return the content of a script or a Markdown file, with a note on its conversion."""
    return Content(tuple(islice(cells, MAX_CELLS + 1)), {}, f"it is {file_type}, which qdot converted to a notebook")


def _find_part(text: str) -> str | None:
    """Return the part, such as "p1.jacobian", that the options of a cell name; None if they name no part."""
    match = _PART_NAME.search(text)
    return match.group(1) if match else None


def _split_script(text: str) -> Iterator[Cell]:
    """Yield the cells of a script, split at lines with `# %%`; without such lines, at gaps between statements."""
    lines = text.split("\n")
    headers = [(number, match.group(1)) for number, line in enumerate(lines) if (match := _CELL_HEADER.fullmatch(line))]
    if not headers:
        yield from _split_statements(text, lines)
        return
    cell_starts = [number for number, _ in headers]
    if cell_starts[0]:
        yield Cell("\n".join(lines[: cell_starts[0]]))
    for (number, header), end in zip(headers, [*cell_starts[1:], len(lines)], strict=True):
        body, is_text = lines[number + 1 : end], re.search(r"\[(markdown|md|raw)\]", header)
        if is_text:
            body = [re.sub(r"^# ?", "", line) for line in body]
        yield Cell("\n".join(body).strip("\n"), _find_part(header), is_code=not is_text)


def _split_statements(text: str, lines: list[str]) -> Iterator[Cell]:
    """Yield adjacent statements as one cell; a statement after a blank line or a comment begins the next cell.

    In the comment above a cell, a line that begins with "# +" has the options of the cell.
    """
    begins_cell = [n == 0 or not lines[n - 1].strip() or lines[n - 1].startswith("#") for n in range(len(lines))]
    cell_starts = [number for number in _find_statements(text, lines) if begins_cell[number]]
    for begin, end in zip(cell_starts, [*cell_starts[1:], len(lines)], strict=True):
        first_line = begin
        while first_line and lines[first_line - 1].startswith("#") and not lines[first_line].startswith("# +"):
            first_line -= 1
        part = _find_part(lines[first_line]) if lines[first_line].startswith("# +") else None
        yield Cell("\n".join(lines[begin:end]).strip("\n"), part)


def _find_statements(text: str, lines: list[str]) -> list[int]:
    """Return the indices of the lines on which statements begin; guess by indentation if the script can't be parsed."""
    tree = parse_python(text, MAX_SCRIPT_CHARACTERS)
    if tree is not None:
        first_nodes = ([*getattr(node, "decorator_list", ()), node][0] for node in tree.body)
        return sorted({node.lineno - 1 for node in first_nodes})
    continuation = r"[\s#)\]}]|(else|elif|except|finally)\b"
    return [number for number, line in enumerate(lines) if line and not re.match(continuation, line)]


def parse_python(source: str, max_length: int) -> ast.Module | None:
    """Return the syntax tree of a text; None if the text is not Python or longer than `max_length` characters."""
    tree = _parse(source) if len(source) <= max_length else None
    return tree if isinstance(tree, ast.Module) else None


def find_first_syntax_error(source: str) -> int:
    """Return the line number of the first syntax error in a text; 1 if it is unknown."""
    error = _parse(source)
    return (error.lineno or 1) if isinstance(error, SyntaxError) else 1


def _parse(source: str) -> ast.Module | Exception:
    """Return the syntax tree of a text, or the exception that Python's parser raised."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        return error


def _split_markdown(text: str) -> Iterator[Cell]:
    """Yield each fenced block of Python code as a code cell, and the text between blocks as text cells.

    `info` is the text after the fence that opens a block, such as "python".
    """
    fence, info, body = "", "", list[str]()
    for line in text.split("\n"):
        match = _FENCE_LINE.fullmatch(line)
        if not fence and match and _PYTHON_FENCE.match(match.group(2)):
            yield Cell("\n".join(body), is_code=False)
            (fence, info), body = match.groups(), []
        elif fence and match and match.group(1).startswith(fence) and not match.group(2):
            yield _make_fenced_cell(info, body)
            fence, body = "", []
        else:
            body.append(line)
    yield _make_fenced_cell(info, body) if fence else Cell("\n".join(body), is_code=False)


def _make_fenced_cell(info: str, body: list[str]) -> Cell:
    """Return the code cell of a fenced block, without the options that MyST writes above the code."""
    code_start = 0
    if body[:1] == ["---"] and "---" in body[1:]:
        code_start = body.index("---", 1) + 1
    while code_start < len(body) and re.match(r":[\w-]+:", body[code_start]):
        code_start += 1
    return Cell("\n".join(body[code_start:]), _find_part("\n".join([info, *body[:code_start]])))


# --- cells that do not have to be run ---


def empty_self_checks(cells: Sequence[Cell], problems: "Problems") -> Sequence[Cell]:
    """Return the cells with qdot's self-checks emptied; unchanged if the code of another cell mentions self-checks.

    `problems` are the student's problems. Self-checks only print results, but take half of the time of all cells
    together.
    """
    from qdot.exercises.notebook.self_check import SELF_CHECK, write_self_check_cell

    check_source = write_self_check_cell(problems)
    if any(SELF_CHECK in cell.source for cell in cells if cell.is_code and cell.source.strip() != check_source):
        return cells
    return [
        replace(cell, source="") if cell.is_code and cell.source.strip() == check_source else cell for cell in cells
    ]


if __name__ == "__main__":
    print_content(*sys.argv[1:])
