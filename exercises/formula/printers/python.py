"""Expressions, matrices and lists as Python code with SymPy, as a notebook's cell holds it."""

import re
import textwrap
from collections.abc import Sequence

import sympy as sp
from sympy.printing.str import StrPrinter

from exercises.formula.text import text_of

WIDTH = 88
"""Columns of a line of code in a notebook, as far as it can be broken."""


class _Exact(StrPrinter):
    """SymPy's own text, with fractions that Python does not round."""

    def _print_Rational(self, expr: sp.Rational) -> str:
        return str(expr.p) if expr.q == 1 else f"Rational({expr.p}, {expr.q})"

    def _print_Float(self, expr: sp.Float) -> str:
        return f"{float(expr):.10g}"


def python_text(expression: sp.Expr) -> str:
    """Return an expression as Python text that means exactly the same.

    >>> python_text(sp.Rational(2, 5) - sp.atan(sp.Rational(2, 7)))
    'Rational(2, 5) - atan(Rational(2, 7))'
    """
    text = text_of(expression)  # of most expressions it is there already, and has neither fractions nor decimals
    return str(_Exact().doprint(expression)) if _NUMBERS.search(text) else text


_NUMBERS = re.compile(r"(?<![A-Za-z_0-9])\d+/\d|\d\.|\.\d|e[-+]\d")
"""A fraction of numbers, or a decimal: not what is left of 7*a1/20, which Python divides as it should."""


def matrix_code(rows: Sequence[Sequence[str]], taken: int) -> str:
    """Return a matrix row by row, a column as Matrix([..., ...]); `taken` columns of its line are used already."""
    inside = taken + len("Matrix()")
    if all(len(row) == 1 for row in rows):
        return f"Matrix({list_code([row[0] for row in rows], inside)})"
    return f"Matrix({list_code([list_code(row, len('    ,'), 1) for row in rows], inside)})"


def list_code(items: Sequence[str], taken: int, depth: int = 0) -> str:
    """Return a list, on one line where it fits behind what is `taken`."""
    line = f"[{', '.join(items)}]"
    if taken + len(line) <= WIDTH and "\n" not in line:
        return line
    indent = "    " * depth
    shown = "".join(f"{_wrapped(item + ',', depth + 1)}\n" for item in items)
    return f"[\n{shown}{indent}]"


def bracketed(text: str, taken: int) -> str:
    """Return a formula, in brackets on lines of its own where it does not fit behind what is `taken`."""
    return text if taken + len(text) <= WIDTH else f"(\n{_wrapped(text, 1)}\n)"


def _wrapped(text: str, depth: int) -> str:
    """Return text that stands in brackets on lines of its own, broken before operators and never inside cos(...)."""
    indent = "    " * depth
    if "\n" in text:  # broken already
        return indent + text
    tied = re.sub(r"(?<=[a-z]\()[^()]*(?=\))", lambda match: match.group().replace(" ", "\0"), text)
    tied = re.sub(r" ([-+]) ", " \\1\0", tied)
    if max(map(len, tied.split(" "))) > WIDTH - len(indent) - 4:  # a long product is broken before its factors too
        tied = re.sub(r"(?<=\))(\*|/)(?=[(a-z])", " \\1\0", tied)
    wrapper = textwrap.TextWrapper(WIDTH, indent, indent + "    ", break_long_words=False, break_on_hyphens=False)
    return wrapper.fill(tied).replace("\0", " ")
