"""Run a notebook's cells as Jupyter does, with harmless replacements of what IPython adds to Python.

Shell commands (`!`) do nothing, `input()` returns an empty string, help and most magics do nothing, and nothing is
displayed. What notebooks depend on works: `await`, the last results (`_`, `Out`), and files and modules that a notebook
has written.
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

from . import stand_ins
from .ipython import NON_PYTHON_MAGICS, translate_to_python

_RESULT_NAMES = re.compile(r"(?<![\w.])(?:_{1,3}\d*|Out)(?!\w)")
"""Names of the results of earlier cells; results are stored only if some cell mentions such a name."""

_AWAIT_FLAG = ast.PyCF_ALLOW_TOP_LEVEL_AWAIT


class FailedImport(NamedTuple):
    """A failed import after which its cell continued: the line, and the exception."""

    line: int
    error: BaseException


class Session:
    """Runs the cells of one notebook; `variables` are the notebook's variables."""

    def __init__(self, cells: Sequence[str], setup: str = "") -> None:
        """Run qdot's own code `setup` first, because the student may have changed the notebook's first cell.

        `cells` are the sources of all cells that will be run.
        """
        self._last_results: dict[str, Any] = dict.fromkeys(("_", "__", "___"), "")
        self.variables: dict[str, Any] = {"__name__": "__main__", "Out": {}, **self._last_results}
        self.asked_for_input = False
        self._stores_results = any(map(_RESULT_NAMES.search, cells))
        self._cell_count = 0
        shell = Shell(self)
        vars(builtins).update(get_ipython=lambda: shell, display=lambda *_args, **_options: None, input=self._input)
        stand_ins.install(lambda: shell)
        sys.path.insert(0, "")  # so that a notebook can import files that it wrote, as in Jupyter
        exec(setup, self.variables)  # noqa: S102 - this is the isolated process

    def run(
        self, source: str, cell_name: str, handle_failed_import: Callable[[FailedImport], None] = lambda _: None
    ) -> None:
        """Run a cell; `cell_name` is its file name in error messages. Raises what the cell raises.

        If an import fails, continue after the import; call `handle_failed_import` if there is no stand-in.
        """
        self._cell_count += 1
        with contextlib.suppress(OSError):  # raised if the folder is gone
            # Python would miss a new file if the folder's time of change is still the same.
            sys.path_importer_cache.pop(os.getcwd(), None)
        python_source = translate_to_python(source)
        codes: Sequence[CodeType] = self._compile(python_source, cell_name)
        while codes:
            try:
                for code in codes:
                    self._execute(code)
                return
            except Exception as error:
                split_cell = _split_at_failed_import(error, python_source, cell_name)
                if split_cell is None:
                    raise
                statement, remaining_code = split_cell
                if not self._use_stand_ins(statement):
                    handle_failed_import(FailedImport(statement.lineno, error))
                codes = [compile(remaining_code, cell_name, "exec", _AWAIT_FLAG, True)]

    def _compile(self, source: str, name: str) -> list[CodeType]:
        """Return a cell's code; if results are stored, the last expression, which is the result, has separate code."""
        if self._stores_results and not source.rstrip().endswith(";"):
            with contextlib.suppress(RecursionError):  # raised for a sum of a thousand terms: its tree is too deep
                tree = ast.parse(source, name)
                if tree.body and isinstance(last_statement := tree.body[-1], ast.Expr):
                    other_statements = ast.Module(tree.body[:-1], tree.type_ignores)
                    code = compile(other_statements, name, "exec", _AWAIT_FLAG, True)
                    return [code, compile(ast.Expression(last_statement.value), name, "eval", _AWAIT_FLAG, True)]
        return [compile(source, name, "exec", _AWAIT_FLAG, True)]

    def _execute(self, code: CodeType) -> None:
        value = eval(code, self.variables)  # noqa: S307 - this is the isolated process
        if code.co_flags & inspect.CO_COROUTINE:
            value = self._await_result(value)
        if self._stores_results and value is not None:
            self._store_result(value)

    def _store_result(self, value: Any) -> None:
        """Store a result as IPython does; if the notebook itself has set `_`, that variable is not overwritten."""
        last_results = self._last_results
        self.variables[f"_{self._cell_count}"] = value
        if isinstance(out := self.variables.get("Out"), dict):
            out[self._cell_count] = value
        if all(self.variables.get(name, result) is result for name, result in last_results.items()):
            self._last_results = {"_": value, "__": last_results["_"], "___": last_results["__"]}
            self.variables.update(self._last_results)

    def _await_result(self, coroutine: Any) -> Any:
        """Return the result of a cell that awaits something, without an event loop, which would need a socket."""
        while True:
            try:
                coroutine.send(None)
            except StopIteration as end:
                return end.value

    def _input(self, _prompt: object = "") -> str:
        self.asked_for_input = True
        return ""

    def _use_stand_ins(self, statement: ast.Import | ast.ImportFrom) -> bool:
        """Set the names of a failed import to stand-ins; return False if any of its modules has no stand-in."""
        modules = [alias.name for alias in statement.names]
        if isinstance(statement, ast.ImportFrom):
            modules = [statement.module or ""]
        if not all(map(stand_ins.has_stand_in, modules)):
            return False
        for alias in statement.names:
            self.variables[alias.asname or alias.name.partition(".")[0]] = stand_ins.STAND_IN
        return True


class Shell(stand_ins.StandIn):
    """The object that `get_ipython()` returns: magics that run code or write files work, others do nothing."""

    _session: Session

    def __init__(self, session: Session) -> None:
        vars(self)["_session"] = session

    def run_line_magic(self, name: str, line: str, *_others: object) -> None:
        """Execute `%name line`."""
        if name == "run":
            path, *_ = line.split()
            path = path if path.endswith(".py") else f"{path}.py"
            self._session.run(Path(path).read_text(encoding="utf-8"), path)
        elif name == "time":
            self._session.run(line, "<%time>")

    def run_cell_magic(self, name: str, line: str, body: str) -> None:
        """Execute `%%name line` with the cell below it."""
        if name in ("writefile", "file"):
            *options, path = line.split()
            with open(path.strip("'\""), "a" if "-a" in options else "w", encoding="utf-8") as file:
                file.write(body)
        elif name not in NON_PYTHON_MAGICS:
            self._session.run(body, f"<%%{name}>")

    def magic(self, line: str) -> None:
        """Execute `%line`, as in older notebooks."""
        name, _, arguments = line.partition(" ")
        self.run_line_magic(name, arguments)

    def getoutput(self, *_args: object) -> list[str]:
        """Return an empty output without starting a command."""
        return []


class Position(NamedTuple):
    """A position in a cell."""

    line: int
    column: int


def find_position(error: BaseException, cell_name: str) -> Position | None:
    """Return the position at which the cell raised an exception; None if the exception has another source."""
    if isinstance(error, SyntaxError) and error.filename == cell_name:
        return Position(int(error.lineno or 1), 0)
    trace = error.__traceback__
    while trace is not None and trace.tb_frame.f_code.co_filename != cell_name:
        trace = trace.tb_next
    if trace is None:
        return None
    _, _, column, _ = list(trace.tb_frame.f_code.co_positions())[trace.tb_lasti // 2]
    return Position(trace.tb_lineno, column or 0)


def _split_at_failed_import(
    error: Exception, source: str, cell_name: str
) -> tuple[ast.Import | ast.ImportFrom, ast.Module] | None:
    """Return the import that raised the error, and the rest of its cell; None if no import raised the error."""
    position = find_position(error, cell_name)
    if position is None or (isinstance(error, SyntaxError) and error.filename == cell_name):
        return None
    with contextlib.suppress(RecursionError):
        body = ast.parse(source).body
        for number, statement in enumerate(body):
            end = (statement.end_lineno or 0, statement.end_col_offset or 0)
            contains_error = (statement.lineno, statement.col_offset) <= position < end
            if contains_error and isinstance(statement, ast.Import | ast.ImportFrom):
                return statement, ast.Module(body[number + 1 :], [])
    return None
