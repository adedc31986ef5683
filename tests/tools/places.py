"""Marks at places of a module: a call before the statement that holds a line, to see which test comes there."""

import ast
from collections import defaultdict
from collections.abc import Iterator, Mapping

HEAD = """try:
    from qdot_markers import mark as _qdot_mark
except BaseException:
    def _qdot_mark(number): pass
"""
"""What a marked module begins with; where the marks can't be had, it does what it did."""


def marked(text: str, lines: Mapping[int, int]) -> str:
    """Return a module's text with a mark of each number at its line; all lines must be inside functions."""
    tree, rows = ast.parse(text), text.split("\n")
    before: dict[int, list[str]] = defaultdict(list)
    for number, line in lines.items():
        at = _row(rows, _innermost(tree, line))
        before[at].append(_indent(rows[at - 1]) + f"_qdot_mark({number})")
    written: list[str] = []
    for k, row in enumerate(rows, 1):
        written += [*before[k], row, *(HEAD.splitlines() if k == _end_of_head(tree) else [])]
    return "\n".join(written)


def _statements(tree: ast.Module) -> Iterator[ast.stmt]:
    """Every statement inside a function."""
    for function in ast.walk(tree):
        if isinstance(function, (ast.FunctionDef, ast.AsyncFunctionDef)):
            for node in ast.walk(function):
                if isinstance(node, ast.stmt) and node is not function:
                    yield node


def _innermost(tree: ast.Module, line: int) -> ast.stmt:
    holding = [one for one in _statements(tree) if one.lineno <= line <= (one.end_lineno or one.lineno)]
    if not holding:
        raise ValueError(f"line {line} is in no function")
    return max(holding, key=lambda one: (one.lineno, -(one.end_lineno or one.lineno)))


def _row(rows: list[str], statement: ast.stmt) -> int:
    """Return the number of the row before which a mark can stand: an `elif` belongs to its `if`."""
    at = statement.lineno
    while rows[at - 1].lstrip().startswith(("elif ", "else:")) or len(_indent(rows[at - 1])) > statement.col_offset:
        at -= 1
    return at


def _indent(row: str) -> str:
    return row[: len(row) - len(row.lstrip())]


def _end_of_head(tree: ast.Module) -> int:
    """Return the last row of the docstring, or of the imports from the future behind it."""
    end = 0
    for k, node in enumerate(tree.body):
        is_text = k == 0 and isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if is_text or (isinstance(node, ast.ImportFrom) and node.module == "__future__"):
            end = node.end_lineno or end
    return end
