"""The commands for a folder that is kept for years: upgrade-check."""

from pathlib import Path
from typing import Annotated

import typer

from exercises.assignment import Assignment, load_assignment
from exercises.console import note, progress, say
from exercises.release import CORES
from grader import upgrade
from grader.commands import Jobs, check_sandbox
from grader.history import Move
from grader.sandbox import Limits
from grader.single import limits_of
from grader.submission import find_submissions, opened


def upgrade_check(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An assignment folder that another version wrote.")],
    submissions: Annotated[
        Path | None,
        typer.Argument(metavar="SUBMISSIONS", help="With --marks: what was handed in. Default: DIR/submitted."),
    ] = None,
    marks: Annotated[
        bool, typer.Option("--marks", help="Grade again, beside the folder, and say whose mark would move.")
    ] = False,
    seconds: Annotated[
        float, typer.Option(min=1, help="With --marks: processor time that a notebook may take.")
    ] = Limits().seconds,
    jobs: Jobs = CORES,
) -> None:
    """Say what an upgrade of qdot changes for a class.

    Run it with the new version, before anything else is done with the folder: every problem is made anew and compared
    with the certificate that was kept when it was handed out. It is told which problems would be others, which
    notebooks `qdot generate` would write anew, what would be worded otherwise, and how many results would be graded
    again; with --marks it is tried whose mark would move. Nothing in the folder is written. Leaves with code 1 if
    anything that students have, or a mark, would be another.
    """
    assignment = load_assignment(folder)
    with progress("comparing", len(assignment.roster)) as counter:
        found = upgrade.compared(assignment, jobs, counter.step)
    for line in upgrade.told(found, folder):
        say(line)
    moved = _marks(assignment, submissions or folder / "submitted", jobs, limits_of(seconds)) if marks else []
    if found.differs or moved:
        raise typer.Exit(1)


def _marks(assignment: Assignment, submissions: Path, jobs: int, limits: Limits) -> list[Move]:
    """Return whose mark would move, having told it."""
    check_sandbox(assignment.sandbox == "strict")
    with opened(submissions) as root, progress("grading", len(assignment.roster)) as counter:
        looked = find_submissions(assignment, root)
        for said in looked.unsure:
            note(said)
        moved = list(upgrade.marks_moved(assignment, looked.found, jobs, limits, lambda _: counter.step()))
    for move in moved:
        say(f"{move.student}  {move.part or 'total'}  {move.was} → {move.now}  {move.why}")
    students = len({move.student for move in moved})
    marks = "1 student's mark" if students == 1 else f"{students} students' marks"
    say(f"{marks} would move" if moved else "no mark would move")
    return moved
