"""`qdot forget`: remove everything that is stored about one student."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.common.console import print_result
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.forgetting import plan_forgetting

LIMITATION = "qdot can't remove copies on learning platforms, in repositories, e-mail, backups or elsewhere"


def forget(
    student: Annotated[str, typer.Argument(metavar="STUDENT", help="An identifier, a name or an email address.")],
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="A folder with one or several assignments. Default: this folder.")
    ] = Path(),
    yes: Annotated[bool, typer.Option("--yes", help="Remove without asking for confirmation.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="List what would be removed, but remove nothing.")] = False,
) -> None:
    """Remove everything that is stored about one student.

    Removes submissions, notebooks, certificates, feedback, results and history, the student's own exported files, and
    the student's lines in roster.csv, overrides.csv, redrawn.csv and the results. Lists these first, with other files
    that name the student, and asks for confirmation. Other students' problems and marks do not change. If interrupted,
    run the same command again. docs/privacy.md says what is stored where.

    Examples:
      qdot forget s001 homework --dry-run
          list what is stored about a student
      qdot forget ada@example.org course --yes
          remove a student from every assignment of a course, without asking
    """
    plans = plan_forgetting(folder, student)
    for plan in plans:
        for line in plan.describe():
            print_result(line)
    print_result(LIMITATION)
    if dry_run:
        print_result("nothing was removed: --dry-run")
        return
    if not yes:
        if not sys.stdin.isatty():
            advice = "use --yes to remove, or --dry-run to list only"
            raise QdotError(f"can't ask for confirmation without a terminal: {advice}")
        if not typer.confirm("Remove this permanently?", err=True):
            print_result("nothing was removed")
            raise typer.Exit(1)
    for plan in plans:
        plan.carry_out()
    print_result("removed")
