r"""Parse tables: entries in lines, in columns with tabs or gaps, as in Matlab's [a b; c d], or as in 0,5; 1,25.

These separators may have another meaning (a sum continues in the next line, a space is a product). So a table is tried
only if a text does not have the expected shape, and accepted only if every row has the expected number of entries.
"""

import re
from collections.abc import Callable, Iterator

from qdot.exercises.formula.notation import convert_units
from qdot.exercises.formula.vocabulary import SPACES, VOCABULARY, compile_pattern

_TABLE_FRAME, _COLUMN_GAP = compile_pattern("frame_of_table"), compile_pattern("gap_of_table")
_MATLAB_GAP, _MATLAB_ROWS = compile_pattern("gap_of_matlab"), compile_pattern("rows_of_matlab")
_MARKDOWN_RULE, _MARKDOWN_BAR = compile_pattern("rule_of_markdown"), compile_pattern("bar_of_markdown")
_SPREADSHEET_SIGN, _CONTINUED_LINE = compile_pattern("sign_of_spreadsheet"), compile_pattern("line_goes_on")
_NUMBER_SEPARATOR, _NAMED_NUMBER = compile_pattern("between_numbers"), compile_pattern("named_number")
_DECIMAL_NUMBER, _TABLE_NAME = compile_pattern("decimal_with_comma"), compile_pattern("name_of_table")
_LIST_COMMA, _DECIMAL_COMMA = compile_pattern("comma_of_list"), compile_pattern("comma_of_number")
_UNIT_FACTORS = sorted({factor for factor in VOCABULARY["units"].values() if factor})
MAX_TABLE_LENGTH = 4000
"""Maximum number of characters of a table."""

_Cells = list[list[str]]
_SplitRow = Callable[[str], list[str]]


def convert_table(text: str, shape: tuple[int, int]) -> str | None:
    r"""Return a table as the text of a list of rows; None for another shape, or if the table is ambiguous.

    >>> [convert_table(text, (2, 2)) for text in ("a1\ta2\n0\t1", "[a1 -a2; 0 1]", "a1, 0,5\n0, 1")]
    ['[[a1, a2], [0, 1]]', '[[a1, -a2], [0, 1]]', '[[a1, 0.5], [0, 1]]']
    >>> convert_table("| a1 | a2 |\n|---|---|\n| 0 | 1 |", (2, 2)), convert_table("=a1\n=a2", (2, 1))
    ('[[a1, a2], [0, 1]]', '[a1, a2]')
    >>> convert_table("a1\n+ a2", (2, 1))
    """
    if len(text) > MAX_TABLE_LENGTH:
        return None
    tables = _split_into_tables(_TABLE_NAME.sub("", text), *shape)
    texts = [_write_cells(cells) for cells in tables if _is_table(cells, shape)]
    is_clear = len(set(texts)) == 1 or not _DECIMAL_COMMA.search(text)  # 1,2 x is 1.2 and x, or 1 and 2 x
    return texts[0] if texts and is_clear else None


def _split_into_tables(text: str, rows: int, columns: int) -> Iterator[_Cells]:
    """Yield the cells of a text for each combination of row separator (lines, semicolons) and entry separator."""
    lines = text.split("\n")
    is_markdown = any(map(_MARKDOWN_RULE.fullmatch, lines))
    lines = [_TABLE_FRAME.sub("", line) for line in lines if not _MARKDOWN_RULE.fullmatch(line)]
    lines = [line for line in lines if line.strip(f"{SPACES}|")]
    if all(map(_SPREADSHEET_SIGN.match, lines)):
        lines = [_SPREADSHEET_SIGN.sub(r"\1", line) for line in lines]
    if rows > 1 and not any(_CONTINUED_LINE.match(line) for line in lines[1:]):
        by_line: tuple[_SplitRow, ...] = (_keep_whole_line,)
        if columns > 1:
            by_line = (_MARKDOWN_BAR.split,) if is_markdown else (_COLUMN_GAP.split, *_ROW_SPLITTERS)
        for split in by_line:
            yield [_split_entries(line, split) for line in lines]
    if (matlab_match := _MATLAB_ROWS.fullmatch(text.strip(SPACES))) is None:
        return
    inner = matlab_match.group(1) or matlab_match.group(2)
    for separator in (";", "[;\n]"):
        rows_of_text = [row for row in re.split(separator, inner) if row.strip(SPACES)]
        for split in (_keep_whole_line, *_ROW_SPLITTERS) if columns == 1 else _ROW_SPLITTERS:
            cells = [_split_entries(row, split) for row in rows_of_text]
            # a single row is accepted as the expected column; commas without spaces already make a list
            is_column = columns == 1 and len(cells) == 1 and split is not _split_at_commas
            yield [[cell] for cell in cells[0]] if is_column else cells


def _keep_whole_line(line: str) -> list[str]:
    return [line]


def _split_at_commas(line: str) -> list[str]:
    return line.split(",")


_ROW_SPLITTERS: tuple[_SplitRow, ...] = (_MATLAB_GAP.split, _split_at_commas, _LIST_COMMA.split)


def _split_entries(line: str, split_row: _SplitRow) -> list[str]:
    """Return the entries of a row, with decimal commas as points; the last entry may be followed by a comma."""
    cells = split_row(line.strip(SPACES).removesuffix(",").strip(SPACES))
    return [_DECIMAL_COMMA.sub(".", cell) for cell in cells]


def _is_table(cells: _Cells, shape: tuple[int, int]) -> bool:
    rows, columns = shape
    return len(cells) == rows and all(len(row) == columns and all(map(_is_single_entry, row)) for row in cells)


def convert_numbers(text: str, count: int) -> str | None:
    """Return the text of a list of numbers that are separated by more than a comma, else None.

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
    entries = [entry.strip(SPACES) for entry in _NUMBER_SEPARATOR.split(content)]
    if len(entries) == count and all(map(_is_number, entries)):
        return f"[{', '.join(entry.replace(',', '.') for entry in entries)}]"
    return convert_table(text, (count, 1))


def _find_named_numbers(text: str) -> list[str]:
    """Return named numbers, as in x = 0,5 and y = 1; an empty list if the text contains anything else."""
    numbers, position = list[str](), 0
    while position < len(text):
        match = _NAMED_NUMBER.match(text, position)
        if match is None:
            return []
        numbers.append(f"{match.group(1)} = {match.group(2).replace(',', '.')}")
        position = match.end()
    return numbers


def _is_number(entry: str) -> bool:
    """Return whether an entry is a number, perhaps times the factor of its unit."""
    factors = (factor for factor in ("", *_UNIT_FACTORS) if entry.endswith(factor))
    return any(_DECIMAL_NUMBER.fullmatch(entry.removesuffix(factor)) for factor in factors)


def _write_cells(cells: list[list[str]]) -> str:
    rows = [", ".join(cell.strip(SPACES) for cell in row) for row in cells]
    return "[" + ", ".join(rows if len(cells[0]) == 1 else [f"[{row}]" for row in rows]) + "]"


def _is_single_entry(cell: str) -> bool:
    """Return whether a cell is one entry: no separators, no number with two points, and all brackets closed."""
    has_closed_brackets = all(cell.count(opening) == cell.count(closing) for opening, closing in ("()", "[]", "{}"))
    return has_closed_brackets and bool(cell.strip(SPACES)) and not re.search(r"[,;=]|\.[0-9]{1,18}\.", cell)
