"""The command line in this process: what it prints, and what it says of bad input."""

from pathlib import Path

from typer.testing import CliRunner

from grader.cli import app

runner = CliRunner()


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
