"""Write the first cell of a notebook, which defines the symbols of all its problems; the grader runs it, too."""

from collections.abc import Sequence

from qdot.exercises.formula.order import natural_sort_key
from qdot.exercises.formula.printers.python import MAX_CODE_WIDTH
from qdot.exercises.notebook.self_check import Problems
from qdot.exercises.writing.render import render


def setup_cell(problems: Problems) -> str:
    """Return the first cell, which defines the symbols of all problems."""
    names: dict[str, list[str]] = {}
    for _, problem in problems:
        for name, info in problem.symbols().items():
            role_names = names.setdefault(info.role, [])
            if name not in role_names:
                role_names.append(name)
    return setup_cell_for_names(*(sorted(role_names, key=natural_sort_key) for role_names in names.values()))


def setup_cell_for_names(*names: Sequence[str]) -> str:
    """Return a first cell that defines symbols with the given names, with one line of code for each list of names."""
    return render(
        "notebook/setup.py.j2", symbol_lines=[_symbols_line(line_names) for line_names in names if line_names]
    )


def _symbols_line(names: Sequence[str]) -> str:
    if len(names) == 1:
        return f'{names[0]} = Symbol("{names[0]}")'
    line = f'{", ".join(names)} = symbols("{" ".join(names)}")'
    if len(line) <= MAX_CODE_WIDTH:
        return line
    half = (len(names) + 1) // 2
    return "\n".join(map(_symbols_line, (names[:half], names[half:])))
