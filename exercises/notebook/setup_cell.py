"""Write the first cell of a notebook, which defines the symbols of all its problems; the grader runs this cell, too."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from qdot.exercises.formula.order import make_natural_sort_key
from qdot.exercises.formula.printers.python import MAX_CODE_WIDTH

if TYPE_CHECKING:
    from qdot.exercises.notebook.self_check import Problems

IMPORTS = """# Run this cell first. It defines the symbols of all problems with SymPy and NumPy.
import numpy as np
from sympy import And, Eq, Matrix, Or, Rational, Symbol, acos, asin, atan, atan2, cos
from sympy import diff, expand, factor, lambdify, pi, simplify, sin, solve, sqrt
from sympy import symbols, tan, trigsimp
"""
IMPORTS_FOR_CUSTOM_QUESTIONS = "from sympy import Abs, exp, log\n"


def write_setup_cell(problems: "Problems") -> str:
    """Return the first cell for some problems, with a list of symbols for each role (joints, rates, …)."""
    names_by_role: dict[str, dict[str, None]] = {}
    for _, problem in problems:
        for name, info in problem.symbols.items():
            names_by_role.setdefault(info.role, {})[name] = None
    has_custom_questions = any(part.details.question for _, problem in problems for part in problem.parts)
    name_lists = (sorted(names, key=make_natural_sort_key) for names in names_by_role.values())
    return write_setup_cell_for_names(*name_lists, has_custom_questions=has_custom_questions)


def write_setup_cell_for_names(*name_lists: Sequence[str], has_custom_questions: bool = False) -> str:
    """Return a first cell that defines symbols with the names in some lists; each list has its own line of code.

    With custom questions, the cell imports all functions of their answers.
    """
    imports = IMPORTS + (IMPORTS_FOR_CUSTOM_QUESTIONS if has_custom_questions else "")
    lines = [*map(_define_symbols, filter(None, name_lists)), 'blank = Symbol("blank")  # replace it with your answer']
    return "\n".join((imports, *lines, ""))


def _define_symbols(names: Sequence[str]) -> str:
    """Return the code that defines symbols; if the line would be too long, each half of the names gets its own line."""
    if len(names) == 1:
        return f'{names[0]} = Symbol("{names[0]}")'
    line = f'{", ".join(names)} = symbols("{" ".join(names)}")'
    if len(line) <= MAX_CODE_WIDTH:
        return line
    half = (len(names) + 1) // 2
    return "\n".join(map(_define_symbols, (names[:half], names[half:])))
