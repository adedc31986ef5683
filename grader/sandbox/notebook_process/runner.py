"""Run the cells of one notebook and report its answers and errors; nothing else leaves the process.

Whatever a notebook does, it can report only about itself, not about another notebook.
"""

import re
import signal
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy
import sympy

from .answer_formatting import MAX_LIST_DEPTH, format_value
from .function_answers import FUNCTION_TYPES, TABLE_PREFIX, evaluate_function
from .isolation import MAX_REPLACED_SYMBOLS, MAX_SLOWDOWN
from .session import FailedImport, Session, find_position

JsonObject = dict[str, Any]
SendReport = Callable[[JsonObject], None]

MAX_ANSWER_LENGTH = 400_000
"""Maximum number of characters of an answer that the grader accepts."""


def list_immutable_parts(value: Any, depth: int = 0) -> list[Any] | None:
    """Return the immutable parts that a value consists of; None if the value may have other parts.

    `depth` is the number of lists around the value.
    """
    value_type = type(value)
    if value_type in (int, float, complex, str, bool, type(None)) or isinstance(value, sympy.Basic):
        return [value]
    if value_type is sympy.Matrix:
        return [value_type, value.rows, *value.flat()]
    is_sequence = value_type in (list, tuple)
    if not is_sequence or len(value) >= 1000 or depth >= MAX_LIST_DEPTH:  # comparing 1000 values would take too long
        return None
    item_parts = [list_immutable_parts(item, depth + 1) for item in value]
    if None in item_parts:
        return None
    return [value_type, len(value), *(part for parts in item_parts for part in parts or ())]


def is_unchanged(previous_parts: list[Any] | None, current_parts: list[Any] | None) -> bool:
    """Return whether a value is certainly unchanged, judging by its parts, so its text need not be made again."""
    if previous_parts is None or current_parts is None or len(previous_parts) != len(current_parts):
        return False
    pairs = zip(previous_parts, current_parts, strict=True)
    return all(a is b or (type(a) is type(b) is int and a == b) for a, b in pairs)


class Overtime(BaseException):
    """Raised if a cell takes too long. Overtime is no Exception, so that `except Exception` does not catch it."""


class Alarm:
    """Raises Overtime in a block after a number of seconds of processor time, or of waiting.

    The waiting time is the real time minus `MAX_SLOWDOWN` times the processor time, because a busy machine may make a
    notebook slower by this factor. The alarm repeats until the block has ended, because other code may catch the
    exception (mpmath, for example, has a bare `except:` in its parser of floats), and because a signal that arrives
    just before the process starts to wait does not end the wait.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds, self._start_time, self._start_processor_time = seconds, 0.0, 0.0
        signal.signal(signal.SIGPROF, self._raise_overtime)
        signal.signal(signal.SIGALRM, self._check_waiting_time)

    def __enter__(self) -> None:
        self._start_time, self._start_processor_time = time.monotonic(), time.process_time()
        signal.setitimer(signal.ITIMER_PROF, self._seconds, ALARM_INTERVAL)
        signal.setitimer(signal.ITIMER_REAL, self._seconds, ALARM_INTERVAL)

    def __exit__(self, *_error: object) -> None:
        while True:
            try:
                signal.setitimer(signal.ITIMER_PROF, 0)
                signal.setitimer(signal.ITIMER_REAL, 0)
                return
            except Overtime:  # the alarm rang while it was being switched off
                continue

    def _raise_overtime(self, _signal: int, _frame: Any) -> None:
        raise Overtime(f"took longer than {self._seconds:g} s of processor time")

    def _check_waiting_time(self, _signal: int, _frame: Any) -> None:
        used_seconds = time.process_time() - self._start_processor_time
        remaining = self._start_time + self._seconds + MAX_SLOWDOWN * used_seconds - time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, remaining if remaining > 0 else ALARM_INTERVAL, ALARM_INTERVAL)
        if remaining <= 0:
            raise Overtime(f"waited longer than {self._seconds:g} s")


ALARM_INTERVAL = 0.2
"""Seconds after which the alarm repeats."""


class AnswerReport(NamedTuple):
    """The last report of an answer, and the immutable parts of the answer at that time."""

    parts: list[Any] | None
    message: dict[str, str]


def run_cells(request: dict[str, Any], report: SendReport) -> None:
    """Run the cells of a request in order, each within its time limit; report each answer after a cell changes it.

    `request` is made by `Sandbox.run`.
    """
    cells = {index: source for index, source in enumerate(request["cells"]) if source is not None}
    session = Session(list(cells.values()), request.get("setup", ""))
    last_reports: dict[str, AnswerReport] = {}
    tracker, alarm = _SymbolTracker(), Alarm(request["cell_seconds"])
    for index, source in cells.items():
        report({"begun": index})
        _run_cell(session, index, source, alarm, report)
        tracker.update(session.variables, index)
        for answer_text in report_answers(session.variables, last_reports, request, alarm, report):
            tracker.report_replaced(source, answer_text, report)
    report({"done": True})


def _run_cell(session: Session, index: int, source: str, alarm: Alarm, report: SendReport) -> None:
    """Run a cell; report each import that failed, and if the cell stopped, the error and the line."""
    outcome: dict[str, Any] = {}
    failed_imports: list[FailedImport] = []
    name = f"<cell {index + 1}>"
    session.asked_for_input = False
    try:
        with alarm:
            session.run(source, name, failed_imports.append)
    except Overtime as overtime:
        outcome = {"error": f"it {overtime}"}
    except SystemExit:
        outcome = {"error": "it called exit()"}
    except BaseException as raised:
        advice = INPUT_ADVICE if session.asked_for_input else ""
        outcome = {"error": describe_error(raised) + advice, "line": _find_stop_line(raised, name)}
    for failed_import in failed_imports[:MAX_FAILED_IMPORTS]:
        report({"import": index, "error": describe_error(failed_import.error), "line": failed_import.line})
    if outcome:
        report({"cell": index, **outcome})


MAX_FAILED_IMPORTS = 20
"""Maximum number of failed imports that are reported for a cell."""
INPUT_ADVICE = "; input() returns an empty string when a notebook is graded: write the value into the cell instead"
"""The advice that is added to the error of a cell that has asked for input."""


def _find_stop_line(error: BaseException, cell_name: str) -> int | None:
    """Return the line on which a cell stopped; None if it is unknown."""
    try:
        position = find_position(error, cell_name)
    except BaseException:  # a student's exception must not break the report
        return None
    return None if position is None else position.line


class _SymbolTracker:
    """Finds variables that were symbols and are now numbers, for example after `theta1 = 0.5`.

    If a later cell uses such a variable in an answer, the answer contains the number instead of the symbol. `replaced`
    maps each such variable to the index of the cell that set the number, and to the number.
    """

    def __init__(self) -> None:
        self.symbol_names: dict[str, str] = {}
        self.replaced: dict[str, tuple[int, str]] = {}

    def update(self, namespace: dict[str, Any], cell_index: int) -> None:
        """Look at all variables after a cell has been run."""
        for name, value in list(namespace.items()):
            if type(value) is sympy.Symbol:
                self.symbol_names[name] = value.name
                self.replaced.pop(name, None)
            elif name in self.symbol_names and name not in self.replaced and _is_number(value):
                self.replaced[name] = cell_index, repr(value)[:40]

    def report_replaced(self, source: str, answer_text: str, report: SendReport) -> None:
        """Report each replaced variable that `source` mentions, if the answer does not contain its symbol."""
        for name, (index, value) in list(self.replaced.items())[:MAX_REPLACED_SYMBOLS]:
            if _mentions(name, source) and not _mentions(self.symbol_names[name], answer_text):
                report({"replaced": name, "set": index, "value": value})


def _mentions(name: str, text: str) -> bool:
    return re.search(rf"\b{re.escape(name)}\b", text) is not None


def _is_number(value: Any) -> bool:
    """Return whether a value is a number, such as pi/2, without calling a method that a notebook may have defined."""
    value_type = type(value)
    is_formula = issubclass(value_type, sympy.Expr) and value_type.__module__.startswith("sympy.")
    return value_type in NUMBER_TYPES or (is_formula and bool(value.is_number))


NUMBER_TYPES = (int, float, complex, numpy.float64, numpy.int64)


def describe_error(error: BaseException) -> str:
    """Return an exception's type and message as one short line, with advice if `ADVICE_BY_ERROR` has any."""
    try:
        message = error.msg if isinstance(error, SyntaxError) else error  # msg does not name the cell and line
        text = f"{type(error).__name__}: {message}".splitlines()[0][:300].removesuffix(": ")
        advice = next((f"; {advice}" for pattern, advice in ADVICE_BY_ERROR.items() if pattern in text), "")
        return re.sub(PYTHON_HINTS, "", text).rstrip("." if advice else "") + advice
    except BaseException:  # a student's exception must not break the report
        return "an exception that can't be shown"


ADVICE_BY_ERROR = {
    "you meant '=='": "write an equation as Eq(theta2, 0)",
    "forgot a comma": "a comma or a multiplication sign (*) seems to be missing",
    "invalid decimal literal": "every multiplication needs *, as in 2*theta1",
    "SyntaxError: invalid syntax": "check the brackets, and that every multiplication has its *",
    "SyntaxError: invalid character": "put an answer with such a character into quotes, as text",
    "for ^:": "in Python, write a power with **, as in a1**2; or put the answer into quotes, as text",
    "must be square": "the matrix that you solve with or invert must have as many rows as columns",
    "NonSquareMatrixError": "this needs a matrix with as many rows as columns",
    "Singular matrix": "the matrix has no inverse, because its determinant is zero",
    "not invertible": "the matrix has no inverse, because its determinant is zero",
    "Matrix size mismatch": "matrices of these sizes can't be combined; print the .shape of each of them",
    "ZeroDivisionError": "look for a denominator that is zero",
    "' object is not callable": "every multiplication needs *, as in a1*(a2 + a3)",
    "'list' object has no attribute": "a list is not a matrix: write Matrix([…])",
    "truth value of Relational": "'or' and 'and' can't join equations: write a list of them, or Or(Eq(theta1, 0), "
    "Eq(theta2, pi))",
    "loop of ufunc does not support": "NumPy's functions accept only numbers: use SymPy's, as in sin(theta1)",
    "convert expression to float": "float() and the math module accept only numbers: use SymPy's functions, as in "
    "sin(theta1)",
    "Cannot cast ufunc": "numpy.linalg accepts only numbers: write Matrix(…).det() or Matrix(…).inv()",
    "'FunctionClass'": "a function has no argument: write sin(theta1), for example",
    "and 'function'": "a function has no argument: write rad(30), for example, or the number alone",
    "unsupported operand type(s) for /: 'list'": "a list can't be divided: write Matrix([…])/…",
    "unsupported operand type(s) for *: 'list'": "a list can't be multiplied: write Matrix([…])*…",
    "No module named": "this library is not available for grading: use SymPy, NumPy or .py files that you submit with "
    "the notebook",
}
"""Parts of Python's error messages, and the advice that is added to each: how to write what the student meant."""
PYTHON_HINTS = r"\. (Maybe you meant|Perhaps you forgot|Did you mean) .*\?$"
"""Matches the advice at the end of Python's error messages; such advice is for programs and not for formulas."""


def evaluate_answer(answer: Any, name: str, request: dict[str, Any]) -> Any:
    """Return an answer or, for a function, its result.

    Without arguments in the request, the result is `TABLE_PREFIX` alone, by which the grader recognises a function.
    """
    if not issubclass(type(answer), FUNCTION_TYPES):  # isinstance would believe an object's `__class__`
        return answer
    arguments = next((value for slot, value in request["arguments"].items() if name.startswith(f"{slot}_")), None)
    return TABLE_PREFIX if arguments is None else evaluate_function(answer, arguments)


def report_answers(
    namespace: JsonObject, last_reports: dict[str, AnswerReport], request: JsonObject, alarm: Alarm, report: SendReport
) -> list[str]:
    """Report each new or changed answer, as text or with the reason why it has no text; return the texts.

    `last_reports` has the last report of each answer, and is updated.
    """
    texts = []
    for name in request["names"]:
        if name not in namespace:
            continue
        previous_report, parts = last_reports.get(name, AnswerReport(None, {})), None
        try:
            with alarm:
                parts = list_immutable_parts(namespace[name])
                if is_unchanged(previous_report.parts, parts):
                    message = previous_report.message
                else:
                    text = format_value(evaluate_answer(namespace[name], name, request))
                    message = {"text": text[: MAX_ANSWER_LENGTH + 1]}
        except Overtime as overtime:
            message = {"error": f"computing the answer {overtime}"}
        except BaseException as raised:
            message = {"error": describe_error(raised)}
        last_reports[name] = AnswerReport(parts, message)
        if message != previous_report.message:
            report({"name": name, **message})
            if "text" in message:
                texts.append(message["text"])
    return texts


def warm_up() -> None:
    """Do what notebooks do, so that SymPy does its one-time work before the fork.

    Every run of the grader does this, so the function contains only operations that are faster the second time. The
    first `simplify` loads SymPy's units, which takes 0.1 s. A second `trigsimp` or `solve` takes as long as the first.
    `lambdify` takes 0.1 s to load parts of NumPy, but few notebooks use it except in self-checks, which are not run.
    """
    x, y = sympy.symbols("x y")
    matrix = sympy.Matrix([[sympy.cos(x), 1], [0, y]])
    sympy.simplify(matrix.det())
    matrix.inv()
    matrix.diff(x)
    sympy.N((sympy.sin(x) * y).subs({x: 0.3, y: 0.7}))
    theta1, theta2, a1, a2, vx = sympy.symbols("theta1:3 a1:3 vx")  # fill SymPy's caches for typical answers
    entry = -vx * (a1 * sympy.sin(theta1) + a2 * sympy.cos(theta1 + theta2) / 10) / (a1 * sympy.cos(theta2))
    format_value([sympy.Matrix([entry, -entry]), sympy.Eq(theta1, sympy.acos(sympy.Rational(7, 25)) - sympy.pi)])
