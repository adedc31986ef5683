"""The command line in this process: what it prints, and what it says of bad input."""

from contextlib import nullcontext
from pathlib import Path
from typing import Any

from typer.testing import CliRunner, Result

from qdot.grader.cli.main import app
from tests.support.handing_in import one_process


class _Runner(CliRunner):
    """Runs commands, which start no processes unless they are told to use more than one."""

    def invoke(self, *args: Any, **options: Any) -> Result:
        command = [str(arg) for arg in args[1]]
        several = "--jobs" in command and command[command.index("--jobs") + 1] != "1"
        with nullcontext() if several else one_process():
            return super().invoke(*args, **options)


runner = _Runner()


def run(*args: str | Path, code: int = 0, stdin: str | None = None) -> str:
    result = runner.invoke(app, [str(arg) for arg in args], input=stdin)
    assert result.exit_code == code, result.output + str(result.exception)
    return result.stdout


def fails(*args: str | Path) -> str:
    result = runner.invoke(app, [str(arg) for arg in args])
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1
    return lines[0]
