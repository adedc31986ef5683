"""`qdot forget`: remove everything that is stored about one student."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from qdot.exercises.common.console import print_result
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import require_extra
from qdot.grader.grading.forgetting import plan_forgetting

if TYPE_CHECKING:
    from qdot.grader.serve.models import Person

DATABASE_PATH = "online/database.sqlite3"
"""Where `qdot serve` has its database, unless another one was named."""
LIMITATION = "qdot can't remove copies on learning platforms, in repositories, e-mail, backups or elsewhere"


def forget(
    student: Annotated[str, typer.Argument(metavar="STUDENT", help="An identifier, a name or an email address.")],
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="A folder with one or several assignments. Default: this folder.")
    ] = Path(),
    yes: Annotated[bool, typer.Option("--yes", help="Remove without asking for confirmation.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="List what would be removed, but remove nothing.")] = False,
    database: Annotated[
        str,
        typer.Option(metavar="ADDRESS", envvar="QDOT_DATABASE", help="The database of `qdot serve`, if not in FOLDER."),
    ] = "",
) -> None:
    """Remove everything that is stored about one student.

    Removes submissions, notebooks, certificates, feedback, results and history, the student's own exported files, and
    the student's lines in roster.csv, overrides.csv, redrawn.csv and the results. Also removes the student from the
    database of `qdot serve`. Lists all of this first, with other files that name the student, and asks for
    confirmation. Other students' problems and marks do not change. If interrupted, run the same command again.
    docs/privacy.md says what is stored where.

    Examples:
      qdot forget s001 homework --dry-run
          list what is stored about a student
      qdot forget ada@example.org course --yes
          remove a student from every assignment of a course, without asking
    """
    people = _find_people_online(folder, student, database)
    plans = plan_forgetting(folder, student, is_optional=bool(people))
    for plan in plans:
        for line in plan.describe():
            print_result(line)
    if people:
        from qdot.grader.serve.forgetting_online import describe_people, forget_people

        print_result("the database of qdot serve:")
        for line in describe_people(people):
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
    if people:
        forget_people(people)
    for plan in plans:
        plan.carry_out()
    print_result("removed")


def _find_people_online(folder: Path, student: str, database: str) -> "list[Person]":
    """Return the student's rows in the database of a course, if there is a database. Raises QdotError."""
    paths = [*folder.glob(DATABASE_PATH), *folder.glob(f"*/{DATABASE_PATH}")]
    if not paths and not database:
        return []
    if len(paths) > 1:
        names = " and ".join(str(path.parent.parent) for path in paths)
        raise QdotError(f"{names} each have a database; run the command for one folder after the other")
    require_extra("serve", "removing a student from the database")
    from qdot.grader.serve.settings import ServiceOptions, configure

    served_folder = paths[0].parent.parent if paths else folder
    configure(ServiceOptions((served_folder.resolve(),), database))
    from qdot.grader.serve.forgetting_online import find_people

    return find_people(student)
