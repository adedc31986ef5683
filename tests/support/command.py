"""Run qdot commands in this process, and return their output and their one-line errors."""

from contextlib import nullcontext
from pathlib import Path
from typing import Any

from typer.testing import CliRunner, Result

from qdot.grader.cli.main import app
from tests.support.submitting import work_in_one_process


class _Runner(CliRunner):
    def invoke(self, *args: Any, **options: Any) -> Result:
        command = [str(arg) for arg in args[1]]
        is_parallel = "--jobs" in command and command[command.index("--jobs") + 1] != "1"
        with nullcontext() if is_parallel else work_in_one_process():
            return super().invoke(*args, **options)


runner = _Runner()


def run(*args: str | Path, code: int = 0, stdin: str | None = None) -> str:
    result = runner.invoke(app, [str(arg) for arg in args], input=stdin)
    assert result.exit_code == code, result.output + str(result.exception)
    return result.stdout


def run_and_fail(*args: str | Path) -> str:
    result = runner.invoke(app, [str(arg) for arg in args])
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1
    return lines[0]
