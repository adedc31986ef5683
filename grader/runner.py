"""The program in which students' notebooks run: nothing of qdot is imported here, and no reference is ever present.

It reads one JSON request a line, forks a child for each, and writes what the child reports, a JSON line at a time. The
child has NumPy and SymPy loaded already, limits on memory, processor time, file size and wall time, and a folder of
its own. Answers leave it as text. Whatever a notebook does, it can only report about itself.
"""

import contextlib
import ctypes
import importlib.util
import json
import os
import re
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy
import sympy
from sympy.printing.str import StrPrinter

Report = Callable[[dict[str, Any]], None]
Answer = Callable[[str], None]


def load_beside(name: str) -> Any:
    """Return a module that lies beside this file: it is no package here."""
    spec: Any = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


callables = load_beside("callables")

LONGEST_ANSWER = 400_000
LONGEST_REPORT = 4_000_000


class _Printer(StrPrinter):
    """Prints doubles with all their digits: SymPy prints 15, and 0.866025403784439 is not the root of 3/4."""

    def _print_Float(self, number: sympy.Float) -> str:
        return repr(float(number)) if number._prec <= 53 else str(sympy.sstr(number, full_prec=True))


def text_of(value: Any, depth: int = 0) -> str:
    """Return a value as the text of an expression; raise TypeError for what is none."""
    if depth > 6:
        raise TypeError("lists nest too deeply")
    if isinstance(value, str):
        return value
    if isinstance(value, (sympy.MatrixBase, numpy.ndarray)):
        return text_of(value.tolist(), depth + 1)
    if isinstance(value, sympy.Basic):
        return str(_Printer().doprint(value))
    if isinstance(value, numpy.generic):
        return text_of(value.item(), depth + 1)
    if value is Ellipsis:
        return "blank"
    if value is None or isinstance(value, (bool, int, float)):
        return repr(value)
    if isinstance(value, complex):
        return f"({value.real!r} + I*({value.imag!r}))"
    return text_of_container(value, depth + 1)


def text_of_container(value: Any, depth: int) -> str:
    """Return a list, set or dictionary as text; raise TypeError for anything else."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{text_of(k, depth)}: {text_of(v, depth)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(text_of(item, depth) for item in value) + "]"
    if isinstance(value, (set, frozenset)):
        return "{" + ", ".join(sorted(text_of(item, depth) for item in value)) + "}"
    raise TypeError(f"a {type(value).__name__} is not an expression")


def parts_of(value: Any, depth: int = 0) -> list[Any] | None:
    """Return what a value is made of, down to what can't change in place; None where that isn't known."""
    kind = type(value)
    if kind in (int, float, complex, str, bool, type(None)) or isinstance(value, sympy.Basic):
        return [value]
    if kind is sympy.Matrix:
        return [kind, value.rows, *value.flat()]
    if kind in (list, tuple) and len(value) < 1000 and depth < 6:
        inner = [parts_of(item, depth + 1) for item in value]
        return None if None in inner else [kind, len(value), *(part for item in inner for part in item or ())]
    return None


def is_same(before: list[Any] | None, now: list[Any] | None) -> bool:
    """Tell whether a value surely is what it was, so that its text need not be made again after every cell."""
    if before is None or now is None or len(before) != len(now):
        return False
    return all(a is b or (type(a) is type(b) is int and a == b) for a, b in zip(before, now, strict=True))


def plain_python(source: str) -> str:
    """Return a cell's source with IPython's magic lines (%..., !...) taken out."""
    return re.sub(r"(?m)^(\s*)[%!].*$", r"\1pass", source)


class Overtime(BaseException):
    """A cell ran longer than it may. Not an Exception, so that `except Exception` does not swallow it."""


def _ring(_signal: int, _frame: Any) -> None:
    raise Overtime


class Told(NamedTuple):
    """What was reported of an answer, and what the answer was made of."""

    parts: list[Any] | None
    found: dict[str, str]


def set_alarm(seconds: float) -> None:
    """Ring after so much processor time, which a busy machine does not shorten, or thrice that on the clock."""
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.setitimer(signal.ITIMER_REAL, 3 * seconds)


def run_cells(request: dict[str, Any], report: Report) -> None:
    """Run the cells in order, each within its time; report every answer as soon as it is there."""
    wanted = request["names"]
    namespace: dict[str, Any] = {"__name__": "__main__", "display": lambda *_args, **_options: None}
    last: dict[str, Told] = {}
    signal.signal(signal.SIGALRM, _ring)
    signal.signal(signal.SIGPROF, _ring)
    for index, source in enumerate(request["cells"]):
        error = None
        try:
            set_alarm(request["cell_seconds"])
            code = compile(plain_python(source), f"<cell {index + 1}>", "exec", dont_inherit=True)
            exec(code, namespace)  # noqa: S102 - this is the contained process
        except Overtime:
            error = f"it ran longer than {request['cell_seconds']:g} s"
        except SystemExit:
            error = "it called exit()"
        except BaseException as raised:
            error = describe(raised)
        finally:
            set_alarm(0)
        if error is not None:
            report({"cell": index, "error": error})
        report_answers(namespace, wanted, last, request, report)
    report({"done": True})


def describe(raised: BaseException) -> str:
    """Return an exception as one short line; a hostile one must not break the report."""
    try:
        return f"{type(raised).__name__}: {raised}".splitlines()[0][:300]
    except BaseException:
        return "an exception that can't be shown"


def value_of(answer: Any, name: str, request: dict[str, Any]) -> Any:
    """Return an answer, or what it gives where it is a function."""
    if not isinstance(answer, callables.FUNCTIONS):
        return answer
    asked = next((asked for begin, asked in request["asked"].items() if name.startswith(f"{begin}_")), None)
    return callables.TABLE if asked is None else callables.called(answer, asked)


def report_answers(
    namespace: dict[str, Any], wanted: list[str], last: dict[str, Told], request: dict[str, Any], report: Report
) -> None:
    """Report each answer that is new or has changed, as text or as the reason why it is none."""
    for name in wanted:
        if name not in namespace:
            continue
        before, parts = last.get(name, Told(None, {})), None
        try:
            set_alarm(request["cell_seconds"])
            parts = parts_of(namespace[name])
            found = (
                before.found
                if is_same(before.parts, parts)
                else {"text": text_of(value_of(namespace[name], name, request))[: LONGEST_ANSWER + 1]}
            )
        except Overtime:
            found = {"error": f"working it out took longer than {request['cell_seconds']:g} s"}
        except BaseException as raised:
            found = {"error": describe(raised)}
        finally:
            set_alarm(0)
        last[name] = Told(parts, found)
        if found != before.found:
            report({"name": name, **found})


def limit(request: dict[str, Any]) -> None:
    """Set the limits of the child; a limit that this machine does not know is left out."""
    memory, seconds = request["memory"], int(request["seconds"]) + 1
    wanted = [
        ("RLIMIT_CPU", seconds), ("RLIMIT_FSIZE", 10_000_000), ("RLIMIT_NOFILE", 64), ("RLIMIT_CORE", 0),
        ("RLIMIT_AS", memory),
    ]  # fmt: skip
    for name, value in wanted:
        with contextlib.suppress(AttributeError, ValueError, OSError):
            resource.setrlimit(getattr(resource, name), (value, value))


def close_all_but(kept: set[int]) -> None:
    """Close every descriptor above standard error except those in `kept`: other notebooks' channels among them."""
    low = 3
    for descriptor in sorted(kept):
        os.closerange(low, descriptor)
        low = descriptor + 1
    os.closerange(low, resource.getrlimit(resource.RLIMIT_NOFILE)[0] if sys.platform == "darwin" else 65536)


HIDDEN = ("exercises", "grader")
"""Packages that a notebook may not load: with them and the secret, the answers could be regenerated."""


def library_folders() -> list[str]:
    """Return the folders that modules come from, but not a checkout of qdot (an editable install)."""
    kept = [path for path in sys.path if "site-packages" in path or "dist-packages" in path]
    other = [path for path in sys.path if path and path not in kept]
    return kept + [path for path in other if not any(Path(path, name).is_dir() for name in HIDDEN)]


READABLE = tuple(
    os.path.realpath(path)
    for path in (
        sys.prefix, sys.base_prefix, *library_folders(), "/usr/lib", "/usr/share", "/usr/local/lib", "/lib", "/lib64",
        "/System/Library", "/Library/Fonts", "/etc/localtime", "/etc/fonts", "/etc/ssl", "/dev/null", "/dev/urandom",
        "/dev/random",
    )
)  # fmt: skip
"""What Python and its libraries read; everything else on the machine is none of a notebook's business."""

REFUSED = (
    "subprocess.", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.kill", "os.killpg", "pty.",
    "socket.", "ctypes.", "signal.pthread_kill", "os.link", "os.symlink", "os.chown", "sys.setprofile", "sys.settrace",
    "gc.get_", "webbrowser.", "ftplib.", "smtplib.", "urllib.",
)  # fmt: skip


def is_inside(path: Any, folders: tuple[str, ...]) -> bool:
    """Tell whether a path, links resolved, is one of the folders or lies in it; a descriptor that is open does."""
    if isinstance(path, int) or path is None:
        return True
    real = os.path.realpath(os.fsdecode(path))
    return any(real == folder or real.startswith(folder.rstrip("/") + "/") for folder in folders)


def guard(folder: str) -> Callable[[str, tuple[Any, ...]], None]:
    """Return an audit hook: read the libraries, write in the own folder, and nothing else.

    Once added, a hook can't be removed. It watches what Python code does; what a hostile C library would do is for the
    operating system's means.
    """
    own = (os.path.realpath(folder),)
    writing = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
    packages = tuple(os.path.realpath(f"{path}/{name}") for path in sys.path for name in HIDDEN)

    def refuse(what: str) -> NoReturn:
        raise PermissionError(f"a notebook that is graded may not {what}")

    def hook(event: str, args: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = args
            changes = isinstance(flags, int) and flags & writing and path not in ("/dev/null", b"/dev/null")
            if not is_inside(path, own if changes else (*own, *READABLE)) or is_inside_hidden(path):
                refuse(f"open {str(path)[:200]!r}")
        elif event == "import" and str(args[0]).split(".")[0] in HIDDEN:
            refuse(f"import {str(args[0])[:100]}")
        elif event.startswith(("os.listdir", "os.scandir", "os.walk", "glob.", "os.chdir")):
            if not is_inside(args[0], (*own, *READABLE)):
                refuse(f"look into {str(args[0])[:200]!r}")
        elif event.startswith(
            ("os.rename", "os.remove", "os.rmdir", "os.mkdir", "os.chmod", "os.truncate", "os.utime")
        ):
            if not all(is_inside(arg, own) for arg in args[:2] if isinstance(arg, (str, bytes))):
                refuse(f"change {str(args[0])[:200]!r}")
        elif event.startswith(REFUSED):
            refuse(f"use {event}")

    def is_inside_hidden(path: Any) -> bool:
        return not isinstance(path, int) and is_inside(path, packages)

    return hook


def die_with_parent(parent: int) -> None:
    """Have Linux kill this process when its parent ends: a stopped grader leaves nothing running."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(1, signal.SIGKILL)
    if os.getppid() != parent:  # it has ended before this was asked for
        os._exit(1)


def child(request: dict[str, Any], folder: str, output: int, received: int) -> NoReturn:
    """Be the process in which one notebook runs; never return."""
    try:
        os.setsid()
        die_with_parent(request["runner"])
        null = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(null, descriptor)
        close_all_but({output, received})
        os.chdir(folder)
        limit(request)
        sys.setrecursionlimit(3000)
        os.environ.update(HOME=folder, TMPDIR=folder, MPLCONFIGDIR=folder, XDG_CACHE_HOME=folder)
        tempfile.tempdir = folder
        sys.addaudithook(guard(folder))
        sent = 0

        def report(line: dict[str, Any]) -> None:
            nonlocal sent
            data = (json.dumps(line) + "\n").encode()
            sent += len(data)
            if sent <= LONGEST_REPORT:
                while data:
                    data = data[os.write(output, data) :]
                os.read(received, 1)  # wait until it is safe outside, whatever the next cell does

        run_cells(request, report)
    finally:
        os._exit(0)


def serve(request: dict[str, Any], answer: Answer) -> None:
    """Run one notebook in a child and pass its report on; kill whatever is left of it."""
    folder = tempfile.mkdtemp(prefix="qdot-run-")
    reading, writing = os.pipe()
    received, receipt = os.pipe()
    request["runner"] = os.getpid()
    pid = os.fork()
    if pid == 0:
        child(request, folder, writing, received)
    os.close(writing)
    os.close(received)
    os.set_blocking(receipt, False)
    ended = relay(reading, receipt, time.monotonic() + request["seconds"], answer)
    os.close(receipt)
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL)
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
    os.close(reading)
    _, status = os.waitpid(pid, 0)
    shutil.rmtree(folder, ignore_errors=True)
    crashed = os.WIFSIGNALED(status) and os.WTERMSIG(status) != signal.SIGKILL
    answer(json.dumps({"end": ended if ended != "closed" or not crashed else "crashed"}))


def relay(reading: int, receipt: int, deadline: float, answer: Answer) -> str:
    """Pass whole lines on until the child is done, closes its end, says too much or runs out of time."""
    buffer, total = b"", 0
    while True:
        left = deadline - time.monotonic()
        if left <= 0 or not select.select([reading], [], [], left)[0]:
            return "overtime"
        data = os.read(reading, 65536)
        total += len(data)
        if not data or total > LONGEST_REPORT + 100_000:
            return "closed"
        *lines, buffer = (buffer + data).split(b"\n")
        for line in lines:
            content: Any = {}
            with contextlib.suppress(ValueError, RecursionError):  # a notebook may write anything into its pipe
                content = json.loads(line)
            if isinstance(content, dict) and "end" not in content:
                answer(json.dumps(content))
                if content.get("done") is True:
                    return "done"
            with contextlib.suppress(OSError):
                os.write(receipt, b".")


def warm_up() -> None:
    """Do once what reference-like code does, so that SymPy's first-use costs are paid before the fork."""
    x, y = sympy.symbols("x y")
    matrix = sympy.Matrix([[sympy.cos(x), -sympy.sin(x)], [sympy.sin(x), y * sympy.cos(x + y)]])
    sympy.simplify(matrix.det())
    matrix.inv()
    matrix.diff(x)
    _Printer().doprint(sympy.And(sympy.Eq(x, 0), sympy.Eq(y, sympy.atan2(1, 2))))
    numpy.linalg.svd(numpy.eye(3))


def main() -> None:
    """Serve requests until the input ends."""
    results = os.fdopen(os.dup(1), "w", encoding="utf-8")
    requests = os.fdopen(os.dup(0), encoding="utf-8")
    os.set_inheritable(results.fileno(), False)
    warm_up()
    os.dup2(2, 1)

    def answer(line: str) -> None:
        results.write(line + "\n")
        results.flush()

    answer(json.dumps({"ready": True}))
    for line in iter(requests.readline, ""):
        serve(json.loads(line), answer)


if __name__ == "__main__":
    main()
