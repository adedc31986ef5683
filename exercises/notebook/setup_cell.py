"""The first cell of a notebook, which makes the symbols of all its problems; the grader runs it, too."""

from collections.abc import Sequence

from qdot.exercises.formula.order import natural
from qdot.exercises.formula.printers.python import WIDTH
from qdot.exercises.notebook.self_check import Problems
from qdot.exercises.writing.render import render


def setup_cell(problems: Problems) -> str:
    """Return the first cell, which makes the symbols of all problems."""
    names: dict[str, list[str]] = {}
    for _, problem in problems:
        for name, info in problem.symbols().items():
            listed = names.setdefault(info.role, [])
            if name not in listed:
                listed.append(name)
    return setup_of(*(sorted(listed, key=natural) for listed in names.values()))


def setup_of(*names: Sequence[str]) -> str:
    """Return a first cell that makes symbols of these names, on a line for each of several lists."""
    return render("notebook/setup.py.j2", symbol_lines=[_symbols_line(listed) for listed in names if listed])


def _symbols_line(names: Sequence[str]) -> str:
    if len(names) == 1:
        return f'{names[0]} = Symbol("{names[0]}")'
    line = f'{", ".join(names)} = symbols("{" ".join(names)}")'
    if len(line) <= WIDTH:
        return line
    half = (len(names) + 1) // 2
    return "\n".join(map(_symbols_line, (names[:half], names[half:])))
