"""`qdot forget`: remove everything that is stored about one student."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.common.console import say
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.forgetting import plan_forgetting

NOT_REACHED = "not reached: learning platforms, repositories, e-mail, backups, and copies made elsewhere"


def forget(
    student: Annotated[
        str, typer.Argument(metavar="STUDENT", help="The roster's identifier, or a name or email of one student only.")
    ],
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="An assignment folder, or a folder with several. Default: here.")
    ] = Path(),
    yes: Annotated[bool, typer.Option("--yes", help="Remove without asking.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="List what would be removed, and remove nothing.")] = False,
) -> None:
    """Remove everything that is stored about one student.

    Submissions, notebooks, certificates, feedback, results and history, the student's own exported files, and the
    student's lines in roster.csv, overrides.csv, redrawn.csv and the results. First lists it, with other files that
    name the student, and asks. Nobody else's problems or marks change. The same command finishes what was
    interrupted. docs/privacy.md says what is stored where.

    Examples:
      qdot forget s001 homework --dry-run
          what there is of a student
      qdot forget ada@example.org course --yes
          removed from every assignment of a course, without asking
    """
    plans = plan_forgetting(folder, student)
    for plan in plans:
        for line in plan.describe():
            say(line)
    say(NOT_REACHED)
    if dry_run:
        say("nothing was removed: --dry-run")
        return
    if not yes and not _confirm():
        say("nothing was removed")
        raise typer.Exit(1)
    for plan in plans:
        plan.carry_out()
    say("removed")


def _confirm() -> bool:
    """Ask at the terminal whether to remove everything. Raises QdotError if there is no terminal."""
    if not sys.stdin.isatty():
        raise QdotError("there is no terminal to ask: --yes removes it, --dry-run only lists it")
    return typer.confirm("Remove this permanently?", err=True)
