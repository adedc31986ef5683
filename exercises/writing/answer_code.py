"""Answers as Python text with SymPy: references for the staff's notebook, placeholders for the student's."""

import re
import textwrap
from collections.abc import Sequence

import sympy as sp
from sympy.printing.str import StrPrinter

from exercises.arm.singularity import Component
from exercises.problem import (
    TRUE_FALSE,
    Choice,
    ConditionSet,
    Direction,
    Expression,
    Matching,
    Matrix,
    Number,
    Part,
    Selection,
)
from exercises.record import text_of

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


def answer_code(part: Part, taken: int = 0) -> str:
    """Return the reference as the right-hand side of an assignment, `taken` columns of whose line are used already."""
    answer = part.answer
    if isinstance(answer, Expression):
        return _bracketed(python_text(answer.reference), taken)
    if isinstance(answer, (Matrix, Direction)):
        return _matrix([[python_text(entry) for entry in row] for row in answer.reference.tolist()], taken)
    if isinstance(answer, Number) and len(answer.reference) == 1:
        return python_text(answer.reference[0])
    if isinstance(answer, Number):
        return _matrix([[python_text(value)] for value in answer.reference], taken)
    if isinstance(answer, ConditionSet):
        return _listed([text for component in answer.components for text in _alternatives(component)], taken)
    return f'"{answer.letters if isinstance(answer, (Selection, Matching)) else word_of(answer)}"'


def word_of(answer: Choice) -> str:
    """Return what is typed for the right option: its letter, or true or false."""
    return answer.options[answer.correct] if answer.options == TRUE_FALSE else answer.letter


def placeholder_code(part: Part, taken: int = 0) -> str:
    """Return a placeholder of the right shape: what an unanswered cell assigns."""
    if isinstance(part.answer, (Matrix, Number, Direction)):
        rows, columns = part.answer.reference.shape
        if isinstance(part.answer, Number) and rows == 1:
            return "blank"
        return _matrix([["blank"] * columns] * rows, taken)
    if isinstance(part.answer, ConditionSet):
        return "[blank]"
    return '"blank"' if isinstance(part.answer, (Choice, Selection, Matching)) else "blank"


def _matrix(rows: Sequence[Sequence[str]], taken: int) -> str:
    """Return a matrix row by row, a column as Matrix([..., ...])."""
    inside = taken + len("Matrix()")
    if all(len(row) == 1 for row in rows):
        return f"Matrix({_listed([row[0] for row in rows], inside)})"
    return f"Matrix({_listed([_listed(row, len('    ,'), 1) for row in rows], inside)})"


def _listed(items: Sequence[str], taken: int, depth: int = 0) -> str:
    """Return a list, on one line where it fits behind what is `taken`."""
    line = f"[{', '.join(items)}]"
    if taken + len(line) <= WIDTH and "\n" not in line:
        return line
    indent = "    " * depth
    shown = "".join(f"{_wrapped(item + ',', depth + 1)}\n" for item in items)
    return f"[\n{shown}{indent}]"


def _bracketed(text: str, taken: int) -> str:
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


def _alternatives(component: Component) -> list[str]:
    """Return the conditions of a component, one text for each value or combination of values."""
    if component.solutions is None:
        return [_together([f"Eq({python_text(condition)}, 0)" for condition in component.conditions])]
    combinations: list[list[str]] = [[]]
    for joint, values in component.solutions:
        combinations = [[*c, f"Eq({joint}, {python_text(value)})"] for c in combinations for value in values]
    return [_together(equations) for equations in combinations]


def _together(equations: list[str]) -> str:
    return equations[0] if len(equations) == 1 else f"And({', '.join(equations)})"
