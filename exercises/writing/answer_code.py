"""Answers as Python text with SymPy: references for the staff's notebook, placeholders for the student's."""

from collections.abc import Sequence

import sympy as sp
from sympy.printing.str import StrPrinter

from exercises.arm.singularity import Component
from exercises.problem import Choice, ConditionSet, Expression, Matrix, Number, Part


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
    return str(_Exact().doprint(expression))


def answer_code(part: Part) -> str:
    """Return the reference as the right-hand side of an assignment."""
    answer = part.answer
    if isinstance(answer, Expression):
        return python_text(answer.reference)
    if isinstance(answer, Matrix):
        return _matrix([[python_text(entry) for entry in row] for row in answer.reference.tolist()])
    if isinstance(answer, Number):
        return f"Matrix([{', '.join(python_text(value) for value in answer.reference)}])"
    if isinstance(answer, ConditionSet):
        return _listed([text for component in answer.components for text in _alternatives(component)])
    return f'"{answer.letter}"'


def placeholder_code(part: Part) -> str:
    """Return a placeholder of the right shape: what an unanswered cell assigns."""
    if isinstance(part.answer, (Matrix, Number)):
        rows, columns = part.answer.reference.shape
        if isinstance(part.answer, Number):
            return f"Matrix([{', '.join(['blank'] * rows)}])"
        return _matrix([["blank"] * columns] * rows)
    if isinstance(part.answer, ConditionSet):
        return "[blank]"
    return '"blank"' if isinstance(part.answer, Choice) else "blank"


def _listed(items: Sequence[str]) -> str:
    if sum(map(len, items)) < 80:
        return f"[{', '.join(items)}]"
    return "[\n" + "".join(f"    {item},\n" for item in items) + "]"


def _matrix(rows: Sequence[Sequence[str]]) -> str:
    shown = [f"[{', '.join(row)}]" for row in rows]
    if sum(map(len, shown)) < 80:
        return f"Matrix([{', '.join(shown)}])"
    lines = "".join(f"    {row},\n" for row in shown)
    return f"Matrix([\n{lines}])"


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
