"""The command for students: check. It loads no code for classes, because that would double its run time."""

from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.common.console import say
from qdot.exercises.common.errors import QdotError, count_noun
from qdot.grader.grading.check import check_notebook


def check(
    notebook: Annotated[Path, typer.Argument(metavar="NOTEBOOK", help="Your notebook.")],
    report: Annotated[
        str, typer.Option(metavar="github=PATH", help="Also write a GitHub Actions job summary; - is standard output.")
    ] = "",
) -> None:
    """Show how qdot reads each answer of a notebook.

    For students: it gives no marks and needs no key. Exits with code 1 if an answer is blank or can't be read.

    Examples:
      qdot check velocity.ipynb
          before you submit: how qdot reads each answer
    """
    report_format, _, summary = report.partition("=")
    if report and (report_format != "github" or not summary):
        raise QdotError(f"--report {report}: expected github=PATH, as in github=summary.md")
    checked = check_notebook(notebook)
    rows = checked.rows
    for message in checked.notes:
        say(f"note: {message}")
    for row in rows:
        say(f"{'ok ' if row.is_readable else '-- '} {row.part}: {row.message}")
    if summary:
        from qdot.grader.reports.formats import write_to_path
        from qdot.grader.reports.github import make_check_annotations, make_check_summary

        write_to_path(summary, make_check_summary(checked))
        if annotations := make_check_annotations(notebook, checked):
            say(annotations)
    unreadable = sum(not row.is_readable for row in rows)
    readable = f"{len(rows) - unreadable} of {count_noun(len(rows), 'answer')}"
    say(f"{readable} can be read; qdot does not check here whether they are right")
    if unreadable:
        raise typer.Exit(1)
