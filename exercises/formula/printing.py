"""Print expressions exactly as SymPy does, but faster, because each part is printed only once.

This module imports nothing from qdot: the process in which notebooks run loads this file alone
(`grader/sandbox/notebook_process/answer_formatting`).
"""

from typing import Any

import sympy
from sympy.printing.str import StrPrinter

MAX_CACHED_TEXTS, MAX_CACHED_LENGTH = 4096, 1000
"""Maximum number of cached texts, and maximum length of each."""

_texts: dict[tuple[type, int], tuple[sympy.Basic, str]] = {}
"""Maps a printer and the id of an expression to the expression and its text. The id is the key, because equal
expressions may have different texts, such as 0.5 and 0.50."""


class Printer(StrPrinter):
    """Prints the same text as SymPy's printer, and caches the texts of immutable expressions."""

    def _print(self, expr: Any, **settings: Any) -> str:
        if settings or not isinstance(expr, sympy.Basic):
            return str(super()._print(expr, **settings))
        key = type(self), id(expr)
        cached_expression, text = _texts.get(key, (None, ""))
        if cached_expression is not expr:
            text = str(super()._print(expr))
            if len(text) <= MAX_CACHED_LENGTH:
                if len(_texts) >= MAX_CACHED_TEXTS:
                    _texts.clear()
                _texts[key] = expr, text
        return text


class FullPrinter(Printer):
    """Prints doubles with all digits: SymPy prints only 15, and 0.866025403784439 is not the root of 3/4."""

    def _print_Float(self, number: sympy.Float) -> str:
        is_double = number._prec <= 53  # bits
        return repr(float(number)) if is_double else str(sympy.sstr(number, full_prec=True))
