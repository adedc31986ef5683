"""The program `qdot`: load the module of the command that is called, and run the command.

Nothing slow is imported before `main` has made sure that Ctrl-C and SIGTERM end the program with one line.
"""

import ast
import atexit
import functools
import gc
import inspect
import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

if TYPE_CHECKING:
    import typer

HELP = """Generate velocity-kinematics problems for each student of a class, write notebooks, and grade them.

Start with `qdot demo`, which runs everything on a simulated class; then `qdot init DIR`. `qdot COMMAND --help` explains
a command, with examples."""

STOP_MESSAGES = {
    **dict.fromkeys(("generate", "grade", "demo"), "stopped; run the same command again to continue"),
    "forget": "stopped; run the same command again to remove the rest",
    "verify": "stopped; the same command starts over; --first-seed SEED continues a sweep at a later problem",
}
"""The message when Ctrl-C or SIGTERM stops a command; for a command that is missing here, the message is "stopped"."""

COMMANDS = {
    **dict.fromkeys(("init", "families", "questions", "show", "robots", "solve"), "qdot.grader.cli.problem_commands"),
    **dict.fromkeys(("verify", "generate", "release", "compare", "doctor"), "qdot.grader.cli.class_commands"),
    "grade": "qdot.grader.cli.grade_command",
    "check": "qdot.grader.cli.student_command",
    **dict.fromkeys(("export", "report", "return"), "qdot.grader.cli.export_commands"),
    "forget": "qdot.grader.cli.forget_command",
    "demo": "qdot.grader.cli.demo",
}
"""For each command, the module that defines the command as a function of the same name (`FUNCTION_NAMES`)."""
FUNCTION_NAMES = {"return": "return_pages", "import": "import_folder"}
"""The names of the functions of commands whose own names are Python keywords."""

ENDING_SIGNALS = [signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else [])]
"""The signals that end the program like Ctrl-C: a request to terminate, and a closed terminal."""
SITE_COMMANDS = {"build": "build_site", "serve": "serve"}
"""The commands of `qdot site`, each with the name of its function."""
SERVE_COMMANDS = ("start", "links", "register", "connect", "export", "import", "backup", "restore")
"""The commands of `qdot serve`; `qdot serve DIR` is `qdot serve start DIR`."""
SERVE_HELP = """Serve assignments online, and look after what is stored.

`qdot serve DIR` starts the service. It is short for `qdot serve start DIR`; its options, such as --port, --url and
--database, are listed by `qdot serve start --help`."""

COLLECTION_THRESHOLDS = 20_000, 10, 10
"""Python's thresholds for garbage collection of new, older and old objects. They are high because formulas are trees,
which need no collection; with the default thresholds, garbage collection takes a tenth of the time."""

LIST_COMMANDS = "--help"
"""The value of `needed_part` for a program that only lists the commands."""


@functools.cache
def make_program(needed_part: str = "") -> "typer.Typer":
    """Return the program; if `needed_part` names a command, only with this command, because loading takes time.

    If `needed_part` is `LIST_COMMANDS`, the program can list the commands but not run them. The list is then made from
    the source of the modules, without loading the modules.
    """
    import typer

    settings: dict[str, Any] = {"rich_markup_mode": None, "pretty_exceptions_enable": False}
    app = typer.Typer(name="qdot", no_args_is_help=True, help=HELP, **settings)

    @app.callback(invoke_without_command=True)
    def print_version(
        version: Annotated[bool, typer.Option("--version", is_eager=True, help="Print the version and exit.")] = False,
    ) -> None:
        if version:
            from qdot.exercises.common.extras import find_qdot_version

            typer.echo(f"qdot {find_qdot_version()}")
            raise typer.Exit

    def add_command(group: typer.Typer, name: str, module: str, function: str) -> None:
        if needed_part == LIST_COMMANDS:
            command, docstring = (lambda: None), _parse_docstrings(module)[function]
        else:
            command = _report_errors(getattr(import_module(module), function))
            docstring = inspect.getdoc(command)
        text, _, examples = (docstring or "").partition("\nExamples:\n")
        context = {"ignore_unknown_options": name == "compare"}  # a formula may begin with a minus
        group.command(name, context_settings=context, help=text, epilog=f"\b\nExamples:\n{examples}")(command)

    for name, module in COMMANDS.items():
        if needed_part not in COMMANDS or name == needed_part:
            add_command(app, name, module, FUNCTION_NAMES.get(name, name))
    if needed_part not in COMMANDS:
        site = typer.Typer(no_args_is_help=True, help="Build the web site, or serve it on this machine.")
        for name, function in SITE_COMMANDS.items():
            add_command(site, name, "qdot.grader.cli.site_commands", function)
        app.add_typer(site, name="site")
        service = typer.Typer(no_args_is_help=True, cls=_make_group("start"), help=SERVE_HELP)
        for name in SERVE_COMMANDS:
            add_command(service, name, "qdot.grader.cli.serve_command", FUNCTION_NAMES.get(name, name))
        app.add_typer(service, name="serve")
    return app


def _make_group(default_command: str) -> "type[typer.core.TyperGroup]":
    """Return a class for a group of commands that runs a default command if the first argument names none.

    A first argument that resembles the name of a command, and is not a folder, is reported as a misspelt command.
    """
    import typer.core

    from qdot.exercises.common.errors import find_most_similar

    class GroupWithDefault(typer.core.TyperGroup):
        def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
            uses_default = bool(args) and args[0] not in self.commands and args[0] != "--help"
            similar_name = find_most_similar(args[0], list(self.commands)) if uses_default else ""
            if similar_name and not Path(args[0]).exists():
                ctx.fail(f"{args[0]!r} is neither a folder nor a command; did you mean {similar_name!r}?")
            return super().parse_args(ctx, [default_command, *args] if uses_default else args)

    return GroupWithDefault


@functools.cache
def _parse_docstrings(module: str) -> dict[str, str | None]:
    """Map the name of each function of a module to its docstring, without loading the module."""
    spec = find_spec(module)
    assert spec is not None and spec.origin is not None, module
    statements = ast.parse(Path(spec.origin).read_bytes()).body
    return {node.name: ast.get_docstring(node) for node in statements if isinstance(node, ast.FunctionDef)}


def __getattr__(name: str) -> Any:
    if name == "app":
        return make_program()
    raise AttributeError(name)


def _report_errors(command: Callable[..., None]) -> Callable[..., None]:
    """Return the command with errors reported in one line; the exit code is 2 for an error, 130 or 143 for a signal."""
    import typer

    from qdot.exercises.common.errors import QdotError, make_open_files_error

    @functools.wraps(command)
    def run(*args: object, **options: object) -> None:
        try:
            _prepare_command()
            command(*args, **options)
        except QdotError as error:
            _exit_with_message(str(error), 2)
        except KeyboardInterrupt as stop:
            signal_number = next(iter(stop.args), signal.SIGINT)
            _exit_with_message(STOP_MESSAGES.get(command.__name__, "stopped"), 128 + signal_number)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nobody reads the output any more
        except (typer.Exit, typer.Abort, typer.BadParameter):
            raise
        except Exception as error:
            if os.environ.get("QDOT_TRACEBACK"):
                raise
            report = f"{type(error).__name__}: {error}. Please report it; set QDOT_TRACEBACK=1 to see where"
            _exit_with_message(str(make_open_files_error(error) or f"qdot failed: {report}"), 2)

    return run


def _exit_with_message(message: str, code: int) -> NoReturn:
    """Print a message on standard error, and exit with a code."""
    import typer

    from qdot.exercises.common.console import escape_controls

    sys.stderr.write(f"qdot: {escape_controls(message)}\n")
    raise typer.Exit(code)


def _stop_at_once(signal_number: int, _: object) -> NoReturn:
    """Handle a signal that arrives before a command has begun: end the process immediately."""
    os.write(2, f"qdot: {STOP_MESSAGES.get(' '.join(sys.argv[1:2]), 'stopped')}\n".encode())
    os._exit(128 + signal_number)


def _prepare_command() -> None:
    """Let Ctrl-C, SIGTERM and SIGHUP end the command only after it has cleaned up, and let Python collect garbage."""
    if not gc.isenabled():
        gc.freeze()
        gc.set_threshold(*COLLECTION_THRESHOLDS)
        gc.enable()
    handlers: dict[int, Any] = dict.fromkeys(ENDING_SIGNALS, _interrupt_command)
    handlers[signal.SIGINT] = signal.default_int_handler
    for signal_number, handler in handlers.items():
        if signal.getsignal(signal_number) is _stop_at_once:
            signal.signal(signal_number, handler)


def _interrupt_command(signal_number: int, _: object) -> NoReturn:
    """Handle a signal like Ctrl-C, so that the command ends its processes and cleans up."""
    signal.signal(signal_number, signal.SIG_IGN)  # ignore the signal if it comes again
    raise KeyboardInterrupt(signal_number)


def find_needed_part(arguments: Sequence[str], environment: Mapping[str, str]) -> str:
    """Return the `needed_part` of the program: the command that is called or completed, or `LIST_COMMANDS`.

    >>> find_needed_part(["grade", "homework"], {}), find_needed_part([], {}), find_needed_part(["site", "build"], {})
    ('grade', '--help', 'site')
    >>> begun = {"_QDOT_COMPLETE": "complete_bash", "COMP_WORDS": "qdot grade --di"}
    >>> find_needed_part([], begun), find_needed_part([], {**begun, "COMP_WORDS": "qdot gr"})
    ('grade', '--help')
    """
    if "_QDOT_COMPLETE" in environment:  # a shell asks for completions
        line = environment.get("COMP_WORDS") or environment.get("_TYPER_COMPLETE_ARGS") or ""
        words = f"{line}x".split()[1:]  # the added x makes sure that there is a last, unfinished word
        return words[0] if len(words) > 1 else LIST_COMMANDS
    if arguments and arguments[0] not in ("--help", "--version", *COMPLETION_OPTIONS):
        return arguments[0]
    return LIST_COMMANDS


COMPLETION_OPTIONS = ("--install-completion", "--show-completion")
"""Typer's options for completion in a shell."""


def main() -> None:
    """Run the command line. Exit codes: 0 for success, 1 if a check failed, 2 for bad input or a failure of qdot."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:  # Ctrl-C is ignored in the background
        signal.signal(signal.SIGINT, _stop_at_once)  # nothing has to be cleaned up yet
    for signal_number in ENDING_SIGNALS:
        if signal.getsignal(signal_number) is not signal.SIG_IGN:  # SIGHUP is ignored under nohup
            signal.signal(signal_number, _stop_at_once)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices are small; threads prevent forking
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # Pydantic would search all installed packages
    gc.disable()  # disabled until everything is loaded, because nothing loaded becomes garbage
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # Files and other programs get UTF-8, also on Windows, which has another default.
            encoding = None if stream.isatty() or os.environ.get("PYTHONIOENCODING") else "utf-8"
            stream.reconfigure(encoding=encoding, errors="replace")  # a terminal without "θ" shows "?"
    make_program(find_needed_part(sys.argv[1:], os.environ))()


def run() -> NoReturn:
    """Run the command line, and exit without unloading the modules, because unloading takes a third of a second."""
    code: object = 1
    try:
        main()
        code = 0
    except SystemExit as end:
        code = end.code
    if threading.active_count() > 1 or not (code is None or isinstance(code, int)):
        sys.exit(code)
    atexit._run_exitfuncs()
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except (OSError, ValueError):  # the reading program has ended
        code = code or 120  # the exit code of Python in this case
    os._exit(code or 0)


if __name__ == "__main__":
    run()
