"""The commands for a folder that is kept for years: upgrade-check, forget."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.assignment.release import CORES
from qdot.exercises.common.console import note, progress, say
from qdot.exercises.common.errors import QdotError
from qdot.grader.cli.class_commands import check_sandbox
from qdot.grader.cli.options import Jobs
from qdot.grader.grading import forgetting, upgrade
from qdot.grader.grading.history import Move
from qdot.grader.grading.one_student import limits_of
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import find_submissions, open_submissions


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

    Examples:
      qdot upgrade-check homework
          run with the new version: would anything be another?
      qdot upgrade-check homework --marks
          and would any mark move?
    """
    assignment = load_assignment(folder)
    with progress("comparing", len(assignment.roster)) as counter:
        changes = upgrade.compare_class(assignment, jobs, counter.step)
    for line in upgrade.told(changes, folder):
        say(line)
    moved = _marks(assignment, submissions or folder / "submitted", jobs, limits_of(seconds)) if marks else []
    if changes.differs or moved:
        raise typer.Exit(1)


def _marks(assignment: Assignment, submissions: Path, jobs: int, limits: Limits) -> list[Move]:
    """Return whose mark would move, having told it."""
    check_sandbox(assignment.sandbox == "strict")
    with open_submissions(submissions) as root, progress("grading", len(assignment.roster)) as counter:
        submitted = find_submissions(assignment, root)
        for message in submitted.unsure:
            note(message)
        moved = list(upgrade.marks_moved(assignment, submitted.by_student, jobs, limits, lambda _: counter.step()))
    for move in moved:
        say(f"{move.student}  {move.part or 'total'}  {move.was} → {move.now}  {move.why}")
    students = len({move.student for move in moved})
    marks = "1 student's mark" if students == 1 else f"{students} students' marks"
    say(f"{marks} would move" if moved else "no mark would move")
    return moved


def forget(
    student: Annotated[
        str,
        typer.Argument(metavar="STUDENT", help="The roster's identifier, or a name or email that is one student's."),
    ],
    folder: Annotated[
        Path,
        typer.Argument(metavar="FOLDER", help="An assignment folder, or one with those of a course. Default: here."),
    ] = Path(),
    yes: Annotated[bool, typer.Option("--yes", help="Remove without asking.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Tell what would be removed, and remove nothing.")] = False,
) -> None:
    """Remove all that a folder has of one student.

    Submissions, notebooks, certificates, feedback, results with what earlier runs gave, what was kept of grading, and
    the lines in roster.csv, overrides.csv, redrawn.csv, results.jsonl, grades.csv and costs.csv; of exports, the
    student's own files. It is told first, with what names the student and stays, and asked about. Nobody else's
    problems or marks change. What was stopped is ended by the same command. docs/privacy.md says what is kept, where
    and for how long.

    Examples:
      qdot forget s001 homework --dry-run
          what there is of a student
      qdot forget ada@example.org course --yes
          removed from every assignment of a course, without asking
    """
    plans = forgetting.plans(folder, student)
    for plan in plans:
        for line in forgetting.told(plan):
            say(line)
    say(forgetting.ELSEWHERE)
    if dry_run:
        say("nothing was removed: --dry-run")
        return
    if not yes and not _confirm():
        say("nothing was removed")
        raise typer.Exit(1)
    for plan in plans:
        forgetting.carry_out(plan)
    removed, shorter = sum(len(plan.removed) for plan in plans), sum(len(plan.shorter) for plan in plans)
    say(f"removed {removed} files and folders, and the lines in {shorter} tables")


def _confirm() -> bool:
    """Ask at the terminal whether to remove everything. Raises QdotError if nobody is there to be asked."""
    if not sys.stdin.isatty():
        raise QdotError("nobody is there to be asked: --yes removes it, --dry-run tells and removes nothing")
    return typer.confirm("Remove this for good?", err=True)
