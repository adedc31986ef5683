"""Read TOML and CSV files that people write, with error messages that name the file, the line and the key.

Every message has the form FILE: line N: joint 2: alpha = "90 deg": what is wrong, and what is expected. The line number
is omitted if it is unknown, and the value if it is long.
"""

import codecs
import csv
import datetime
import io
import json
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from pathlib import Path
from typing import Any

from qdot.exercises.common.errors import ErrorList, QdotError, count_noun, find_most_similar, make_name_error

KeyPath = Sequence[str | int]
"""A path of keys and list indices: ("joint", 0, "alpha") is alpha of the first [[joint]]."""

_MAX_VALUE_LENGTH = 48
_BACKSLASH_HINT = (
    "; write LaTeX in single quotes, as in '$\\alpha$', other formulas without backslashes, as in \"pi/2\", and paths "
    "with /"
)
_HINTS = (
    ("invalid value", '; put text and formulas in quotes, as in "pi/2", and write numbers as 0.5'),
    ("expected newline or end", '; write numbers without a unit, as in 0.5, and everything else in quotes: "pi/2"'),
    ("cannot overwrite a value", "; the key of this line is used twice; remove one of the two"),
    ("duplicate inline table key", "; remove one of the two"),
    ("immutable namespace", "; a table in braces ends with its }; write all of its keys between the braces"),
    ("illegal character '\\n'", "; a closing quote is missing"),
    ("unclosed array", "; put names in quotes, separate them with commas, and end the list with ]"),
    (" twice", "; write it once, or with double brackets if it may occur several times, as in [[joint]]"),
    ("invalid date", "; write a date with a time as 2027-01-15T23:59:00+01:00"),
    ("invalid statement", "; each line must be KEY = VALUE, a [[header]] or a # comment"),
    ("array declaration", "; a header contains only a name, as in [[joint]]"),
    ("unescaped '\\'", _BACKSLASH_HINT),
    ("invalid hex value", _BACKSLASH_HINT),
)
"""Parts of the messages of Python's TOML parser, each with a hint at the usual cause."""

_KEY = r"""(?:"[^"\n]*"|'[^'\n]*'|[\w-]+)"""
_KEYS = rf"{_KEY}(?:\s*\.\s*{_KEY})*"
_HEADER_LINE = re.compile(rf"\s*(\[\[?)\s*({_KEYS})\s*\]")
_KEY_LINE = re.compile(rf"\s*({_KEYS})\s*=")
_TEXT_OR_COMMENT = re.compile(
    r""""{3}(?:\\.|[^\\])*?"{3,5}|'{3}.*?'{3,5}|"(?:\\.|[^"\\\n])*"|'[^'\n]*'|\#[^\n]*""", re.DOTALL
)
_TWICE = re.compile(r"cannot declare '(.+)' twice", re.IGNORECASE)


def read_text(path: Path, missing_hint: str = "") -> str:
    """Return the text of a file. Raises QdotError; `missing_hint` says what to do if there is no such file."""
    content = _read_bytes(path, missing_hint)
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise QdotError(f"{path}: line {line}: not valid UTF-8; save the file as UTF-8") from None


def read_table_text(path: Path, missing_hint: str = "") -> str:
    """Return the text of a CSV file in any of the encodings that Excel writes. Raises QdotError.

    Excel writes UTF-8, UTF-16 with a byte order mark ("Unicode text"), and Windows-1252 (plain "CSV"). A file is taken
    to be Windows-1252 if it is not valid UTF-8 and contains no multi-byte character of UTF-8.
    """
    content = _read_bytes(path, missing_hint)
    if content.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise QdotError(f'{path}: this is an Excel workbook, despite its name; in Excel, save it as "CSV UTF-8"')
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = content.decode("utf-16", "replace")
    else:
        text = content.decode("utf-8-sig", "replace")
        if "\ufffd" in text and not _MULTI_BYTE_CHARACTER.search(content):
            text = content.decode("cp1252", "replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    for number, line in enumerate(text.split("\n"), 1):
        if "\0" in line or "\ufffd" in line:
            encodings = "UTF-8, UTF-16 or Windows-1252"
            raise QdotError(f'{path}: line {number}: not text in {encodings}; save the file as "CSV UTF-8"')
    return text


_MULTI_BYTE_CHARACTER = re.compile(rb"[\xc2-\xdf][\x80-\xbf]|[\xe0-\xef][\x80-\xbf]{2}|[\xf0-\xf4][\x80-\xbf]{3}")
"""Matches a multi-byte character of UTF-8; in Windows-1252, its bytes would be an accented letter before a symbol."""


def _read_bytes(path: Path, missing_hint: str) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise QdotError(f"{path}: file not found" + (f"; {missing_hint}" if missing_hint else "")) from None
    except OSError as error:
        raise QdotError(f"{path}: the file can't be read: {error.strerror}") from None


@dataclass(frozen=True)
class TomlFile:
    """A TOML file: its path, its text and its parsed content."""

    path: Path
    text: str
    content: Mapping[str, Any]

    @contextmanager
    def locate_errors(self, *key_path: str | int) -> Iterator[None]:
        """Prefix the message of a QdotError raised in the block with the file, the line and the key.

        The value of the key may be a table. If the message then begins with a key of this table and a colon, the line
        of the inner key is given. The inner key may be a path with dots.
        """
        try:
            yield
        except QdotError as error:
            raise QdotError("\n".join(self._locate(key_path, line) for line in str(error).split("\n"))) from None

    def _locate(self, key_path: KeyPath, message: str) -> str:
        """Return a message with the file, the line and the key before it."""
        inner_keys, _, inner_message = message.partition(": ")
        inner_path = (*key_path, *inner_keys.split("."))
        if isinstance(self._find_value(key_path), dict) and self._find_value(inner_path) is not None:
            return f"{self.describe_value(*inner_path)}: {inner_message}"
        return f"{self.describe_value(*key_path)}: {message}"

    def describe_value(self, *key_path: str | int) -> str:
        """Return the file, the line, the key and, if it is short, the value of an entry, for a message."""
        value = self._find_value(key_path)
        location = self._describe_location(key_path, key_path)
        has_tables = any(isinstance(item, dict) for item in (value if isinstance(value, list) else [value]))
        text = format_toml(value) if key_path and value is not None and not has_tables else ""
        return f"{location} = {text}" if text and len(text) <= _MAX_VALUE_LENGTH else location

    def _find_value(self, key_path: KeyPath) -> Any:
        """Return the value of an entry; None if there is none."""
        value: Any = self.content
        for key in key_path:
            has_key = key in value if isinstance(value, dict) else isinstance(value, list) and isinstance(key, int)
            value = value[key] if has_key else None
        return value

    def describe_key(self, *key_path: str | int) -> str:
        """Return the file, the line of a wrong key, and the table that contains it, for a message."""
        return self._describe_location(key_path[:-1], key_path)

    def _describe_location(self, key_path: KeyPath, line_path: KeyPath) -> str:
        """Return the file, the line of `line_path` and the keys of `key_path`, as in FILE: line 7: joint 2: alpha.

        If the line of a key is unknown, return the line of the table or the key that contains it.
        """
        outer_paths = (tuple(line_path[:length]) for length in range(len(line_path), 0, -1))
        number = next((self._line_numbers[path] for path in outer_paths if path in self._line_numbers), None)
        parts = [str(self.path), *([f"line {number}"] if number else [])]
        for key_or_index in key_path:
            if isinstance(key_or_index, int):
                parts[-1] += f" {key_or_index + 1}"
            else:
                parts.append(key_or_index)
        return ": ".join(parts)

    def check_keys(
        self, key_path: KeyPath, known_keys: Sequence[str], required_keys: Sequence[str] = (),
        top_level_keys: Sequence[str] = (),
    ) -> None:  # fmt: skip
        """Raise QdotError if a table has keys that are not `known_keys`, or else if it lacks a required key.

        `top_level_keys` are the top-level keys of the file. If one of them is written below a [[header]], TOML makes it
        a key of that table, and the message says so.
        """
        table: Any = self.content
        for key in key_path:
            table = table[key]
        errors = ErrorList()
        for key in (key for key in table if key not in known_keys):
            with errors.collect():
                location = self._describe_location(key_path, (*key_path, key))
                guess = find_most_similar(key, (*known_keys, *top_level_keys))
                if guess not in top_level_keys or guess in known_keys:
                    raise QdotError(f"{location}: {make_name_error('key', key, tuple(known_keys))}")
                subject = "the key" if guess == key else f"unknown key {key!r} (did you mean {guess!r}?);"
                advice = f"{guess!r} belongs at the top of the file, above every [[{key_path[0]}]]"
                raise QdotError(f"{location}: {subject} {advice}")
        errors.raise_all()
        for key in required_keys:
            if key not in table:
                location = self._describe_location(key_path, key_path)
                raise QdotError(f"{location}: the key {key!r} is missing; needed: {', '.join(required_keys)}")

    @cached_property
    def _line_numbers(self) -> dict[tuple[str | int, ...], int]:
        """Maps the path of each key and of each table to the number of its first line."""
        table: tuple[str | int, ...] = ()
        numbers: dict[tuple[str | int, ...], int] = {}
        for number, line in enumerate(_blank_multiline_texts(self.text).split("\n"), 1):
            header = _HEADER_LINE.match(line)
            if header is not None and isinstance(self._find_value(split_key(header[2])[:1]), (dict, list)):
                table = ()
                keys = split_key(header[2])
                for key in keys:
                    table = (*table, key)
                    numbers.setdefault(table, number)
                    # The last key of a [[header]] begins another table; an earlier key stands for its latest table.
                    if isinstance(self._find_value(table), list):
                        table_count = sum(path[:-1] == table and isinstance(path[-1], int) for path in numbers)
                        is_new = header[1] == "[[" and len([k for k in table if isinstance(k, str)]) == len(keys)
                        table = (*table, table_count if is_new else max(table_count - 1, 0))
                        numbers.setdefault(table, number)
            elif key_match := _KEY_LINE.match(line):
                numbers.setdefault((*table, *split_key(key_match[1])), number)
        return numbers


def split_key(text: str) -> tuple[str, ...]:
    """Return the keys in the text of a key or of a header, without quotes.

    >>> split_key('question."my question".de')
    ('question', 'my question', 'de')
    """
    return tuple(key[1:-1] if key[0] in "\"'" else key for key in re.findall(_KEY, text))


def _blank_multiline_texts(text: str) -> str:
    """Return TOML with each multi-line text replaced by its line breaks, because its lines may look like keys."""
    return _TEXT_OR_COMMENT.sub(lambda match: match[0] if "\n" not in match[0] else "\n" * match[0].count("\n"), text)


def read_toml(path: Path, missing_hint: str = "", parse_decimal: Callable[[str], Any] = Decimal) -> TomlFile:
    """Parse a TOML file; `parse_decimal` converts decimal numbers such as 0.5. Raises QdotError with the line."""
    text = read_text(path, missing_hint)
    try:
        return TomlFile(path, text, tomllib.loads(text, parse_float=parse_decimal))
    except tomllib.TOMLDecodeError as error:
        match = re.fullmatch(r"(.*) \(at (?:line (\d+), column \d+|end of document)\)", str(error))
        problem, line_text = match.groups() if match else (str(error), None)
        for keys in re.finditer(r"\((('.*?',? ?)+)\)", problem):  # a key in Python's notation
            problem = problem.replace(keys[0], "'" + ".".join(re.findall("'(.*?)'", keys[1])) + "'")
        lines = text.split("\n")
        number = int(line_text or max(1, len(text.splitlines())))
        hint = next((hint for phrase, hint in _HINTS if phrase in problem.lower()), "")
        if (header_match := _TWICE.match(problem)) is not None:
            headers = (header and ".".join(split_key(header[2])) for header in map(_HEADER_LINE.match, lines))
            first_number = next((k for k, header in enumerate(headers, 1) if header == header_match[1]), number)
            if "." in header_match[1] and first_number < number:
                hint = f"; the first is in line {first_number}; rename one of them"
        if any(quote in lines[number - 1] for quote in "“”„‘’"):
            hint = '; replace the curly quotes with straight ones: "'
        raise QdotError(f"{path}: line {number}: not valid TOML: {problem[:1].lower()}{problem[1:]}{hint}") from None
    except RecursionError:
        raise QdotError(f"{path}: not valid TOML: its brackets are nested too deeply") from None


def format_toml(value: object) -> str:
    """Return a value in TOML notation.

    >>> print(format_toml(["a", Decimal("0.40"), True]))
    ["a", 0.40, true]
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (float, Decimal)):
        return str(value).replace("Infinity", "inf").replace("NaN", "nan")
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(format_toml, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {format_toml(item)}' for key, item in value.items())}}}"
    return value.isoformat() if isinstance(value, (datetime.date, datetime.time)) else str(value)


# --- tables ---


def read_table(
    path: Path, first_column: str, example_header: str, missing_hint: str = ""
) -> list[tuple[int, dict[str, str]]]:
    """Return the nonempty rows of a CSV file, each with the number of its first line and its cells by column name.

    Column names are converted to lower case. The first column must be `first_column`. Error messages show the sample
    header `example_header`. The file may have any encoding that Excel writes, and commas, semicolons or tabs as
    separators. Raises QdotError.
    """
    text = read_table_text(path, missing_hint)
    row_lines: list[int] = []
    try:
        rows = list(parse_csv_rows(text, row_lines))
    except csv.Error as error:
        hint = "close each double quote, and double it inside a cell" if '"' in text else 'save it as "CSV UTF-8"'
        raise QdotError(f"{path}: line {row_lines[-1]}: qdot can't parse this ({error}); {hint}") from None
    if not rows:
        expected_form = f"the first line {example_header!r}, then one line per {first_column}"
        raise QdotError(f"{path}: the file is empty; it needs {expected_form}")
    header = _parse_header(path, *rows[0], first_column, example_header)
    for number, row in rows[1:]:
        if any(cell.strip() for cell in row[len(header) :]):
            cells = f"{count_noun(len(row), 'cell')}, but the header has {len(header)}"
            hint = 'put text with a comma or semicolon in double quotes, as in "Lovelace, Ada"'
            raise QdotError(f"{path}: line {number}: {cells}; {hint}")
        if any("\n" in cell or "\r" in cell for cell in row):
            problem = "a cell continues past the end of the line; check whether a closing double quote is missing"
            raise QdotError(f"{path}: line {number}: {problem}")
    return [(number, dict(zip(header, row, strict=False))) for number, row in rows[1:]]


SEPARATORS = ",;\t"
"""Column separators: Excel writes a comma or a semicolon, depending on the country settings, and tabs in text files."""


def parse_csv_rows(text: str, row_lines: list[int] | None = None) -> Iterator[tuple[int, list[str]]]:
    """Yield the nonempty rows of a CSV text, each with the number of its first line. Raises csv.Error.

    A first line such as "sep=;" states the separator, as in Excel. Without such a line, the separator is the one that
    splits the first line into the most cells. The number of every row's first line is appended to `row_lines`, even if
    the row can't be parsed.
    """
    line_numbers = [] if row_lines is None else row_lines
    first_line, _, following_lines = text.partition("\n")
    separator_line = re.fullmatch(f'"?sep=([{SEPARATORS}])"?', first_line.strip("\ufeff"), re.IGNORECASE)
    separator = separator_line[1] if separator_line else max(SEPARATORS, key=re.sub('"[^"]*"', "", first_line).count)
    table_text, first_number = (following_lines, 2) if separator_line else (text, 1)
    reader = csv.reader(io.StringIO(table_text, newline=""), delimiter=separator, strict=True)
    line_numbers.append(first_number)
    for row in reader:
        if any(cell.strip() for cell in row):
            yield line_numbers[-1], row
        line_numbers.append(reader.line_num + first_number)


BYTE_ORDER_MARK = "\ufeff"
"""Begins a table for Word or Excel. Without it, they decode accented letters wrongly (as Windows-1252)."""


def format_csv(rows: Iterable[Iterable[object]]) -> str:
    """Return rows as CSV text with commas and one line for each row."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _parse_header(path: Path, line: int, row: list[str], first_column: str, example_header: str) -> list[str]:
    """Return the column names in lower case. Raises QdotError if the first one is wrong, or if two are equal."""
    header = [name.strip().lower() for name in row]
    if header[0] != first_column:
        other_columns = f"then {', '.join(example_header.split(',')[1:])}, …"
        requirement = f"must be {first_column!r} ({other_columns})"
        raise QdotError(f"{path}: line {line}: the first column is {row[0]!r}, but {requirement}")
    repeated_names = [name for name in header if name and header.count(name) > 1]
    if repeated_names:
        raise QdotError(f"{path}: line {line}: two columns are called {repeated_names[0]!r}; give them different names")
    return header
