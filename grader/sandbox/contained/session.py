"""A notebook's cells run as Jupyter runs them: its variables, and what IPython puts beside them, in an inert form.

`!` starts nothing, `input()` gives an empty text, help and most magics do nothing, and nothing is shown. What a
notebook can't do without is there: `await`, the last results (`_`, `Out`), the files that it wrote, and its modules.
"""

import ast
import builtins
import contextlib
import inspect
import os
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import CodeType
from typing import Any, NamedTuple

from . import standins
from .ipython import NOT_PYTHON, python_of

_RESULTS = re.compile(r"(?<![\w.])(?:_{1,3}\d*|Out)(?!\w)")
"""What speaks of the last results; to keep them, a cell has to be taken apart."""

_AWAIT = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT


class Missed(NamedTuple):
    """An import that failed, behind which its cell went on."""

    line: int
    error: BaseException


class Session:
    """The variables of a notebook, and how its cells are run."""

    def __init__(self, cells: Sequence[str], setup: str = "") -> None:
        """Begin with what `setup` sets: what qdot itself wrote into the notebook, whatever has become of that cell."""
        self._last: dict[str, Any] = dict.fromkeys(("_", "__", "___"), "")
        self.variables: dict[str, Any] = {"__name__": "__main__", "Out": {}, **self._last}
        self.asked_for_input = False
        self._keeps_results = any(map(_RESULTS.search, cells))
        self._count = 0
        self._loop: Any = None
        shell = Shell(self)
        vars(builtins).update(get_ipython=lambda: shell, display=lambda *_args, **_options: None, input=self._input)
        standins.install(lambda: shell)
        sys.path.insert(0, "")  # where Jupyter finds what a notebook wrote
        exec(setup, self.variables)  # noqa: S102 - this is the contained process

    def run(self, source: str, name: str, missed: Callable[[Missed], None] = lambda _: None) -> None:
        """Run a cell called `name`; tell of its imports that fail, behind which it goes on. Raises what it raises."""
        self._count += 1
        with contextlib.suppress(OSError):  # its folder is gone
            sys.path_importer_cache.pop(os.getcwd(), None)  # cells may follow faster than the time of a folder changes
        source = python_of(source)
        codes: Sequence[CodeType] = self._compiled(source, name)
        while codes:
            try:
                for code in codes:
                    self._execute(code)
                return
            except Exception as error:
                failed = _failed_import(error, source, name)
                if failed is None:
                    raise
                statement, rest = failed
                if not self._stand_in(statement):
                    missed(Missed(statement.lineno, error))
                codes = [compile(rest, name, "exec", _AWAIT, True)]

    def _compiled(self, source: str, name: str) -> list[CodeType]:
        """Return a cell's code; where results are kept, that of its last expression by itself."""
        with contextlib.suppress(RecursionError):  # a sum of a thousand terms is too deep for a tree
            shows = self._keeps_results and not source.rstrip().endswith(";")
            tree = ast.parse(source, name) if shows else ast.Module([], [])
            if tree.body and isinstance(last := tree.body[-1], ast.Expr):
                before = ast.Module(tree.body[:-1], tree.type_ignores)
                return [
                    compile(before, name, "exec", _AWAIT, True),
                    compile(ast.Expression(last.value), name, "eval", _AWAIT, True),
                ]
        return [compile(source, name, "exec", _AWAIT, True)]

    def _execute(self, code: CodeType) -> None:
        value = eval(code, self.variables)  # noqa: S307 - this is the contained process
        if code.co_flags & inspect.CO_COROUTINE:
            value = self._awaited(value)
        if self._keeps_results and value is not None:
            self._keep(value)

    def _keep(self, value: Any) -> None:
        """Keep a result as IPython does, which leaves a variable `_` of the notebook's own alone."""
        last, self.variables[f"_{self._count}"] = self._last, value
        if isinstance(out := self.variables.get("Out"), dict):
            out[self._count] = value
        if all(self.variables.get(name, result) is result for name, result in last.items()):
            self._last = {"_": value, "__": last["_"], "___": last["__"]}
            self.variables.update(self._last)

    def _awaited(self, coroutine: Any) -> Any:
        if self._loop is None:
            import asyncio
            import selectors

            class Loop(asyncio.SelectorEventLoop):
                """An event loop that nobody wakes from outside: a notebook has no sockets."""

                def _make_self_pipe(self) -> None:
                    self._ssock = self._csock = None

                def _close_self_pipe(self) -> None:
                    pass

            self._loop = Loop(selectors.SelectSelector())
        return self._loop.run_until_complete(coroutine)

    def _input(self, _prompt: object = "") -> str:
        self.asked_for_input = True
        return ""

    def _stand_in(self, statement: ast.Import | ast.ImportFrom) -> bool:
        """Set the names of an import that failed, where stand-ins are there for all of it; return whether they are."""
        from_one = [statement.module or ""] if isinstance(statement, ast.ImportFrom) else []
        if not all(map(standins.stands_for, from_one or [alias.name for alias in statement.names])):
            return False
        for alias in statement.names:
            self.variables[alias.asname or alias.name.partition(".")[0]] = standins.NOTHING
        return True


class Shell(standins.StandIn):
    """What `get_ipython()` returns: magics that run or write something do, and nothing else does anything."""

    def __init__(self, session: Session) -> None:
        vars(self)["_session"] = session

    def run_line_magic(self, name: str, line: str, *_others: object) -> None:
        """Carry out `%name line`."""
        if name == "run":
            path, *_ = line.split()
            path = path if path.endswith(".py") else f"{path}.py"
            self._session.run(Path(path).read_text(encoding="utf-8"), path)
        elif name == "time":
            self._session.run(line, "<%time>")

    def run_cell_magic(self, name: str, line: str, body: str) -> None:
        """Carry out `%%name line` with the cell below it."""
        if name in ("writefile", "file"):
            *options, path = line.split()
            with open(path.strip("'\""), "a" if "-a" in options else "w", encoding="utf-8") as file:
                file.write(body)
        elif name not in NOT_PYTHON:
            self._session.run(body, f"<%%{name}>")

    def magic(self, line: str) -> None:
        """Carry out `%line`, as older notebooks have it."""
        self.run_line_magic(*line.partition(" ")[::2])

    def getoutput(self, *_args: object) -> list[str]:
        """Return what a command printed: it was not started."""
        return []

    def system(self, *_args: object) -> None:
        """Start nothing."""


def place_of(error: BaseException, name: str) -> tuple[int, int] | None:
    """Return where in the cell of this name an exception came from: line and column; None for anywhere else."""
    if isinstance(error, SyntaxError) and error.filename == name:
        return int(error.lineno or 1), 0
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_filename != name:
        trace = trace.tb_next
    if trace is None:
        return None
    positions = list(trace.tb_frame.f_code.co_positions())[trace.tb_lasti // 2]
    return trace.tb_lineno, positions[2] or 0


def _failed_import(error: Exception, source: str, name: str) -> tuple[ast.Import | ast.ImportFrom, ast.Module] | None:
    """Return the statement in which an import failed, and what of the cell is behind it; None for another failure."""
    place = place_of(error, name)
    if place is None or (isinstance(error, SyntaxError) and error.filename == name):
        return None
    try:
        body = ast.parse(source).body
    except RecursionError:
        return None
    for number, statement in enumerate(body):
        ends = (statement.end_lineno or 0, statement.end_col_offset or 0)
        if (statement.lineno, statement.col_offset) <= place < ends:
            if isinstance(statement, ast.Import | ast.ImportFrom):
                return statement, ast.Module(body[number + 1 :], [])
            return None
    return None
