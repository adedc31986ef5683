"""Files that people write, read such that whatever is wrong in them is told by its place.

Every message is of one form, FILE: line N: joint 2: alpha = "90 deg": what is wrong, and what would be right. The line
is left out where it isn't known, the value where it is long.
"""

import codecs
import csv
import datetime
import io
import json
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

from qdot.exercises.common.errors import QdotError, likeliest, unknown

Place = Sequence[str | int]
"""Keys and places in lists from the file down: ("joint", 0, "alpha") is alpha of the first [[joint]]."""

_SHORT = 48
_HINTS = (
    ("invalid value", '; put text and formulas in quotes, as in "pi/2"; numbers are written 0.5'),
    ("expected newline or end of document", '; numbers are written 0.5, without a unit, all else in quotes: "pi/2"'),
    ("cannot overwrite a value", "; a key is given twice"),
    ("illegal character '\\n'", "; a quote is not closed"),
    ("unclosed array", "; names stand in quotes with commas between them, and the list ends with ]"),
    ("twice", "; what there may be several of has double brackets, as in [[joint]]"),
    ("invalid date", "; a day with a time is written 2027-01-15T23:59:00+01:00"),
    ("invalid statement", "; a line is KEY = VALUE, a [[header]] or a # comment"),
    ("array declaration", "; a header has nothing but a name in it, as in [[joint]]"),
    ("unescaped '\\'", '; formulas have no backslash, as in "pi/2", and paths have /'),
)
"""What a TOML reader says, and what is mostly meant."""


def read_text(path: Path, missing: str = "") -> str:
    """Return the text of a file. Raises QdotError; `missing` says what to do where there is none."""
    content = _read_bytes(path, missing)
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise QdotError(f"{path}: line {line}: this is not text in UTF-8; save the file as UTF-8") from None


def read_table_text(path: Path, missing: str = "") -> str:
    """Return the text of a file in CSV, in any encoding in which Excel writes one. Raises QdotError.

    They are UTF-8, UTF-16 with its mark at the beginning ("Unicode text"), and Windows-1252 (plain "CSV"), for which
    is taken what is no UTF-8 and has nothing in UTF-8 in it.
    """
    content = _read_bytes(path, missing)
    if content.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise QdotError(f'{path}: this is an Excel workbook, whatever its name says; in Excel, save it as "CSV UTF-8"')
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = content.decode("utf-16", "replace")
    else:
        text = content.decode("utf-8-sig", "replace")
        if "\ufffd" in text and not _IN_UTF_8.search(content):
            text = content.decode("cp1252", "replace")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    for number, line in enumerate(text.split("\n"), 1):
        if "\0" in line or "\ufffd" in line:
            raise QdotError(
                f'{path}: line {number}: this is no text in UTF-8, UTF-16 or Windows-1252; save the file as "CSV UTF-8"'
            )
    return text


_IN_UTF_8 = re.compile(rb"[\xc2-\xdf][\x80-\xbf]|[\xe0-\xef][\x80-\xbf]{2}|[\xf0-\xf4][\x80-\xbf]{3}")
"""A character of several bytes in UTF-8; in Windows-1252, it would be a letter with accent before a sign."""


def _read_bytes(path: Path, missing: str) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise QdotError(f"{path}: there is no such file" + (f"; {missing}" if missing else "")) from None
    except OSError as error:
        raise QdotError(f"{path}: the file can't be read: {error.strerror}") from None


@dataclass(frozen=True)
class TomlFile:
    """A file in TOML: its path, its text and what it says."""

    path: Path
    text: str
    content: Mapping[str, Any]

    @contextmanager
    def at(self, *place: str | int) -> Iterator[None]:
        """Put the place before the message of any QdotError raised inside."""
        try:
            yield
        except QdotError as error:
            raise QdotError(f"{self.place(*place)}: {error}") from None

    def place(self, *place: str | int) -> str:
        """Return a place as messages name it, with the value where that is short."""
        value: Any = self.content
        for key in place:
            known = key in value if isinstance(value, dict) else isinstance(value, list)
            value = value[key] if known else None
        where = self._describe_place(place, place)
        simple = place and value is not None and not isinstance(value, dict) and not _holds_tables(value)
        text = toml_text(value) if simple else ""
        return f"{where} = {text}" if text and len(text) <= _SHORT else where

    def place_of_key(self, *place: str | int) -> str:
        """Return the place of a table as messages name it, with the line of its last key, which is the odd one."""
        return self._describe_place(place[:-1], place)

    def _describe_place(self, place: Place, key: Place) -> str:
        """Return the file, the line of `key` and the place as in "joint 2: alpha"."""
        number = self.line(key)
        parts = [str(self.path), *([f"line {number}"] if number else [])]
        for step in place:
            if isinstance(step, int):
                parts[-1] += f" {step + 1}"
            else:
                parts.append(step)
        return ": ".join(parts)

    def check_keys(
        self, place: Place, known: Sequence[str], needed: Sequence[str] = (), above: Sequence[str] = ()
    ) -> None:
        """Raise QdotError for a key that the table in a place can't have, before one that it lacks.

        `above` are the keys of the file itself: in TOML, what stands below a [[header]] belongs to that table.
        """
        table: Any = self.content
        for key in place:
            table = table[key]
        for key in table:
            where = self._describe_place(place, (*place, key))
            if key in above and key not in known:
                raise QdotError(f"{where}: the key {key!r} stands at the top of the file, above every [[{place[0]}]]")
            if key not in known:
                meant = likeliest(key, (*known, *above))
                if meant in above and meant not in known:
                    raise QdotError(
                        f"{where}: unknown key {key!r}; the key {meant!r} is meant, probably, and stands at the top of "
                        f"the file, above every [[{place[0]}]]"
                    )
                raise QdotError(f"{where}: {unknown('key', key, tuple(known))}")
        for key in needed:
            if key not in table:
                raise QdotError(
                    f"{self._describe_place(place, place)}: the key {key!r} is missing; needed: {', '.join(needed)}"
                )

    def line(self, place: Place) -> int | None:
        """Return the number of the line where a place is written: of its key, else of its [header]; None if unknown."""
        lines = self.text.splitlines()
        headers = [i for i, line in enumerate(lines) if re.match(r"\s*\[\[?\s*[\w.-]+\s*\]", line)]
        start, header = 0, None
        keys = [key for key in place if isinstance(key, str)]
        top = self.content.get(keys[0]) if keys else None
        if len(place) > 1 or isinstance(top, dict) or _holds_tables(top):
            index = place[1] if len(place) > 1 and isinstance(place[1], int) else 0
            headers_of_place = [
                i for i in headers if re.match(rf"\s*\[\[?\s*{re.escape(str(place[0]))}\s*\]", lines[i])
            ]
            if index < len(headers_of_place):
                header = headers_of_place[index]
                start = header + 1
        end = next((i for i in headers if i >= start), len(lines))
        for number in range(start, end):
            if keys and re.match(rf"""\s*["']?{re.escape(keys[-1])}["']?\s*=""", lines[number]):
                return number + 1
        return None if header is None else header + 1


def _holds_tables(value: object) -> bool:
    return isinstance(value, list) and any(isinstance(item, dict) for item in value)


def read_toml(path: Path, missing: str = "", decimals: Callable[[str], Any] = Decimal) -> TomlFile:
    """Return what a file in TOML says; `decimals` makes numbers of 0.5. Raises QdotError with the line."""
    text = read_text(path, missing)
    try:
        return TomlFile(path, text, tomllib.loads(text, parse_float=decimals))
    except tomllib.TOMLDecodeError as error:
        match = re.fullmatch(r"(.*) \(at (?:line (\d+), column \d+|end of document)\)", str(error))
        what, line = match.groups() if match else (str(error), None)
        what = re.sub(r"\('(.*?)',?\)", r"'\1'", what)  # a key, as Python writes it
        number = line or str(max(1, len(text.splitlines())))
        hint = next((hint for sign, hint in _HINTS if sign in what.lower()), "")
        if any(quote in text.splitlines()[int(number) - 1] for quote in "“”„‘’"):
            hint = '; its quotes are curly, write straight ones: "'
        raise QdotError(f"{path}: line {number}: not valid TOML: {what[:1].lower()}{what[1:]}{hint}") from None


def toml_text(value: object) -> str:
    """Return a value as TOML has it.

    >>> print(toml_text(["a", Decimal("0.40"), True]))
    ["a", 0.40, true]
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (float, Decimal)):
        return str(value).replace("Infinity", "inf").replace("NaN", "nan")
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_text, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {toml_text(item)}' for key, item in value.items())}}}"
    return value.isoformat() if isinstance(value, (datetime.date, datetime.time)) else str(value)


# --- tables ---


_QUOTED = 'a text with a comma or semicolon in it stands in double quotes, as in "Lovelace, Ada"'


def read_table(
    path: Path, first: str, example: str, missing: str = "", too_long: str = _QUOTED
) -> list[tuple[int, dict[str, str]]]:
    """Return the lines of a CSV file with anything in them: the number of each, and its cells by column.

    The columns' names are in small letters. The `first` column is always there; `example` is a header as it may be,
    and `too_long` says what a row with more cells than the header probably has.
    It is in any encoding in which Excel writes one, and commas, semicolons or tabs separate. Raises QdotError.
    """
    rows = _rows(path, missing)
    if not rows:
        raise QdotError(f"{path}: the file is empty; its first line is {example!r}, then a line a {first}")
    header = _header(path, *rows[0], first, example)
    for number, row in rows[1:]:
        if any(cell.strip() for cell in row[len(header) :]):
            raise QdotError(f"{path}: line {number}: {len(row)} cells, and the header has {len(header)}; {too_long}")
        if any("\n" in cell or "\r" in cell for cell in row):
            raise QdotError(
                f"{path}: line {number}: a cell goes on over the end of the line; is a double quote not closed?"
            )
    return [(number, dict(zip(header, row, strict=False))) for number, row in rows[1:]]


def _rows(path: Path, missing: str) -> list[tuple[int, list[str]]]:
    """Return the rows that hold anything, each with the line that it begins on. Raises QdotError."""
    text = read_table_text(path, missing)
    begins: list[int] = []
    try:
        return list(csv_rows(text, begins))
    except csv.Error as error:
        hint = "is a double quote not closed, or not doubled?" if '"' in text else 'save it as "CSV UTF-8"'
        raise QdotError(f"{path}: line {begins[-1]}: this can't be read ({error}); {hint}") from None


SEPARATORS = ",;\t"
"""What separates columns: Excel writes a comma or a semicolon by the country that it is set to, and tabs as text."""


def csv_rows(text: str, begins: list[int] | None = None) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows of a text in CSV that hold anything, each with the line that it begins on.

    They are separated as gives the first line most cells, or as a line "sep=;" before it says, which Excel knows. In
    `begins` are put the lines on which rows begin, also of one that can't be read. Raises csv.Error.
    """
    begins = [] if begins is None else begins
    first, _, rest = text.partition("\n")
    skipped, match = 0, re.fullmatch(r'"?sep=(.)"?', first.strip("\ufeff"), re.IGNORECASE)
    if match and match[1] in SEPARATORS:
        text, skipped = rest, 1
    separator = match[1] if skipped and match else _separator(first)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    begins.append(1 + skipped)
    for row in reader:
        if any(cell.strip() for cell in row):
            yield begins[-1], row
        begins.append(reader.line_num + 1 + skipped)


def _separator(header: str) -> str:
    """Return what gives a line the most cells; of equal ones, the first."""

    def cells(separator: str) -> int:
        try:
            return len(next(csv.reader([header], delimiter=separator), []))
        except csv.Error:
            return 0

    return max(SEPARATORS, key=cells)


def _header(path: Path, line: int, row: list[str], first: str, example: str) -> list[str]:
    """Return the names of the columns in small letters."""
    header = [name.strip().lower() for name in row]
    if header[0] != first:
        others = ", ".join(example.split(",")[1:])
        raise QdotError(
            f"{path}: line {line}: the first column is {row[0]!r}, and must be {first!r} (then {others}, …)"
        )
    twice = [name for name in header if name and header.count(name) > 1]
    if twice:
        raise QdotError(f"{path}: line {line}: two columns are called {twice[0]!r}; give each a name of its own")
    return header
