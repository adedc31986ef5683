"""Write expressions as text, by which they are compared, stored and sorted; each text is cached."""

from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import sympy as sp

from qdot.exercises.formula.printing import Printer


@lru_cache(maxsize=1024, typed=True)
def format_expression(expression: sp.Expr) -> str:
    """Return an expression as text."""
    return _stored_texts.get((type(expression), expression)) or Printer().doprint(expression)


_stored_texts: dict[tuple[type[sp.Expr], sp.Expr], str] = {}
_MAX_STORED_TEXTS = 8192


def store_texts(texts: Iterable[tuple[sp.Expr, str]]) -> None:
    """Store texts of expressions, because printing all references would take half as long as grading."""
    if len(_stored_texts) > _MAX_STORED_TEXTS:
        _stored_texts.clear()
    _stored_texts.update(((type(expression), expression), text) for expression, text in texts)


def format_matrix_rows(matrix: sp.Matrix) -> list[list[str]]:
    """Return the entries of a matrix as text, row by row."""
    return [[format_expression(entry) for entry in row] for row in matrix.tolist()]


def make_matrix_json(matrix: sp.Matrix) -> list[Any]:
    """Return a matrix as a list of rows of text, a column as a plain list."""
    return [format_expression(entry) for entry in matrix] if matrix.cols == 1 else format_matrix_rows(matrix)
