r"""Convert tables to lists.

A table has rows on separate lines, with tabs or gaps between entries, or is typed as in Matlab, [a b; c d]. These
separators may have another meaning: a sum may continue on the next line, and a space may be a product. So a text is
parsed as a table only if it does not have the expected shape otherwise. Every row must have the expected number of
entries.
"""

import re
from collections.abc import Iterator

from qdot.exercises.formula.notation import convert_units
from qdot.exercises.formula.vocabulary import PATTERNS, SPACES, VOCABULARY

_UNIT_FACTORS = sorted({factor for factor in VOCABULARY["units"].values() if factor})
"""The texts that convert numbers with units, such as *pi/180."""
MAX_TABLE_LENGTH = 4000
"""Maximum number of characters of a table."""

_COMMA, _NO_SEPARATOR = re.compile(","), re.compile("(?!)")
"""Separators of entries: a comma, and a pattern that never matches, for lines with a single entry."""
_ENTRY_SEPARATORS = (PATTERNS["gap_of_matlab"], _COMMA, PATTERNS["comma_of_list"])
"""The separators of entries in a row, in the order in which they are tried."""

_Cells = list[list[str]]
"""The texts of the entries, row by row."""


def convert_table(text: str, shape: tuple[int, int]) -> str | None:
    r"""Return a table as the text of a list of rows; None if it has another shape (rows, columns) or is ambiguous.

    >>> [convert_table(text, (2, 2)) for text in ("a1\ta2\n0\t1", "[a1 -a2; 0 1]", "a1, 0,5\n0, 1")]
    ['[[a1, a2], [0, 1]]', '[[a1, -a2], [0, 1]]', '[[a1, 0.5], [0, 1]]']
    >>> convert_table("| a1 | a2 |\n|---|---|\n| 0 | 1 |", (2, 2)), convert_table("=a1\n=a2", (2, 1))
    ('[[a1, a2], [0, 1]]', '[a1, a2]')
    >>> convert_table("a1\n+ a2", (2, 1))
    """
    if len(text) > MAX_TABLE_LENGTH:
        return None
    tables = _split_into_tables(PATTERNS["name_of_table"].sub("", text), *shape)
    texts = [_write_cells(cells) for cells in tables if _is_table(cells, shape)]
    # "1,2 x" may mean 1.2 and x, or 1 and 2 x
    is_unambiguous = len(set(texts)) == 1 or not PATTERNS["comma_of_number"].search(text)
    return texts[0] if texts and is_unambiguous else None


def _split_into_tables(text: str, row_count: int, column_count: int) -> Iterator[_Cells]:
    """Yield the cells of a text for each pair of a row separator (line break, semicolon) and an entry separator."""
    lines = text.split("\n")
    markdown_rule = PATTERNS["rule_of_markdown"].fullmatch
    is_markdown = any(map(markdown_rule, lines))
    lines = [PATTERNS["frame_of_table"].sub("", line) for line in lines if not markdown_rule(line)]
    lines = [line for line in lines if line.strip(f"{SPACES}|")]
    if all(map(PATTERNS["sign_of_spreadsheet"].match, lines)):
        lines = [PATTERNS["sign_of_spreadsheet"].sub(r"\1", line) for line in lines]
    if row_count > 1 and not any(PATTERNS["line_goes_on"].match(line) for line in lines[1:]):
        separators: tuple[re.Pattern[str], ...] = (PATTERNS["gap_of_table"], *_ENTRY_SEPARATORS)
        if column_count == 1:
            separators = (_NO_SEPARATOR,)
        elif is_markdown:
            separators = (PATTERNS["bar_of_markdown"],)
        for separator in separators:
            yield [_split_entries(line, separator) for line in lines]
    if (matlab_match := PATTERNS["rows_of_matlab"].fullmatch(text.strip(SPACES))) is None:
        return
    content = matlab_match.group(1) or matlab_match.group(2)
    for row_separator in (";", "[;\n]"):
        row_texts = [row for row in re.split(row_separator, content) if row.strip(SPACES)]
        for separator in (_NO_SEPARATOR, *_ENTRY_SEPARATORS) if column_count == 1 else _ENTRY_SEPARATORS:
            cells = [_split_entries(row, separator) for row in row_texts]
            # a single row counts as a column, except with commas, because the parser accepts such a list
            is_column = column_count == 1 and len(cells) == 1 and separator is not _COMMA
            yield [[cell] for cell in cells[0]] if is_column else cells


def _split_entries(line: str, separator: re.Pattern[str]) -> list[str]:
    """Return the entries of a row, with points instead of decimal commas. The last entry may have a comma after it."""
    cells = separator.split(line.strip(SPACES).removesuffix(",").strip(SPACES))
    return [PATTERNS["comma_of_number"].sub(".", cell) for cell in cells]


def _is_table(cells: _Cells, shape: tuple[int, int]) -> bool:
    """Return whether cells have a shape, and each contains a single entry."""
    rows, columns = shape
    return len(cells) == rows and all(len(row) == columns and all(map(_is_single_entry, row)) for row in cells)


def convert_numbers(text: str, count: int) -> str | None:
    """Return numbers as the text of a list; None for other texts, and for numbers separated by commas alone.

    >>> convert_numbers("0,5; -1,25", 2), convert_numbers("0,5, -1,25", 2), convert_numbers("0,5,-1,25", 2)
    ('[0.5, -1.25]', '[0.5, -1.25]', None)
    >>> convert_numbers("x = 0,5 und y=-1,25", 2), convert_numbers("x = 1 2", 2)
    ('[x = 0.5, y = -1.25]', None)
    """
    if count < 2 or len(text) > MAX_TABLE_LENGTH:
        return None
    content = convert_units(text, frozenset()).strip(SPACES)
    if content[:1] + content[-1:] in ("()", "[]") or (content[:1] + content[-1:] == "{}" and ";" in content):
        content = content[1:-1]
    if assignments := _find_named_numbers(content):
        return f"[{', '.join(assignments)}]" if len(assignments) == count else None
    entries = [entry.strip(SPACES) for entry in PATTERNS["between_numbers"].split(content)]
    if len(entries) == count and all(map(_is_number, entries)):
        return f"[{', '.join(entry.replace(',', '.') for entry in entries)}]"
    return convert_table(text, (count, 1))


def _find_named_numbers(text: str) -> list[str]:
    """Return equations with decimal points for named numbers, as in x = 0,5 y = 1; [] for any other text."""
    numbers, position = list[str](), 0
    while position < len(text):
        match = PATTERNS["named_number"].match(text, position)
        if match is None:
            return []
        numbers.append(f"{match.group(1)} = {match.group(2).replace(',', '.')}")
        position = match.end()
    return numbers


def _is_number(entry: str) -> bool:
    """Return whether an entry is a number, which may be multiplied by the factor of its unit."""
    factors = (factor for factor in ("", *_UNIT_FACTORS) if entry.endswith(factor))
    return any(PATTERNS["decimal_with_comma"].fullmatch(entry.removesuffix(factor)) for factor in factors)


def _write_cells(cells: list[list[str]]) -> str:
    """Return the text of a list of rows, or of a list of entries if there is one column."""
    rows = [", ".join(cell.strip(SPACES) for cell in row) for row in cells]
    return "[" + ", ".join(rows if len(cells[0]) == 1 else [f"[{row}]" for row in rows]) + "]"


def _is_single_entry(cell: str) -> bool:
    """Return whether a cell is a single entry: it has no separators, no number with two points, no open bracket."""
    has_closed_brackets = all(cell.count(opening) == cell.count(closing) for opening, closing in ("()", "[]", "{}"))
    return has_closed_brackets and bool(cell.strip(SPACES)) and not re.search(r"[,;=]|\.[0-9]{1,18}\.", cell)
