"""The command `qdot`: one program, composed of the commands that each package defines."""

import functools
import os
import sys
from collections.abc import Callable
from importlib.metadata import version
from typing import Annotated

import typer

from exercises import commands as asking
from exercises.errors import QdotError
from grader import commands as grading

app = typer.Typer(
    name="qdot",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="""Velocity-kinematics problems for a class: drawn for each student, written out as notebooks, graded.

    Start with `qdot demo`, which does all of it for a simulated class; then `qdot init DIR`.""",
)


@app.callback(invoke_without_command=True)
def _top(
    show_version: Annotated[bool, typer.Option("--version", is_eager=True, help="Print the version.")] = False,
) -> None:
    if show_version:
        typer.echo(f"qdot {version('qdot')}")
        raise typer.Exit


def _guarded(command: Callable[..., None]) -> Callable[..., None]:
    """Return the command with its errors told in one line: 2 for bad input or our own failure, 130 for Ctrl-C."""

    @functools.wraps(command)
    def run(*args: object, **options: object) -> None:
        try:
            command(*args, **options)
        except QdotError as error:
            _leave(str(error), 2)
        except KeyboardInterrupt:
            _leave("stopped; run the same command again to go on", 130)
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # whoever read our output has gone
        except (typer.Exit, typer.Abort, typer.BadParameter):
            raise
        except Exception as error:
            if os.environ.get("QDOT_TRACEBACK"):
                raise
            said = f"{type(error).__name__}: {error}"
            _leave(f"qdot itself failed: {said}. Please report it; QDOT_TRACEBACK=1 shows where", 2)

    return run


def _leave(message: str, code: int) -> None:
    sys.stderr.write(f"qdot: {message}\n")
    raise typer.Exit(code)


for command in (
    asking.init, asking.families, asking.questions, asking.show, asking.solve, grading.verify, asking.generate,
    grading.check, grading.compare, grading.grade, grading.demo,
):  # fmt: skip
    app.command()(_guarded(command))


def main() -> None:
    """Run the command line: 0 done, 1 something is not as it should be, 2 bad input or our own failure."""
    app()


if __name__ == "__main__":
    main()
