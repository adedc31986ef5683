"""The command for students, `qdot check`. The code for classes isn't loaded, because that would double the run time."""

from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.common.console import print_result
from qdot.exercises.common.errors import QdotError, count_noun
from qdot.grader.grading.check import check_notebook


def check(
    notebook: Annotated[Path, typer.Argument(metavar="NOTEBOOK", help="Your notebook.")],
    report: Annotated[
        str, typer.Option(metavar="github=PATH", help="Also write a GitHub Actions job summary; - is standard output.")
    ] = "",
) -> None:
    """Show how qdot reads each answer in a notebook.

    For students: it gives no marks and needs no solutions. Exits with code 1 if an answer is blank or can't be read.

    Examples:
      qdot check velocity.ipynb
          before you submit: how qdot reads each answer
    """
    report_format, _, summary_path = report.partition("=")
    if report and (report_format != "github" or not summary_path):
        raise QdotError(f"--report {report}: expected github=PATH, as in github=summary.md")
    checked_notebook = check_notebook(notebook)
    for message in checked_notebook.notes:
        print_result(f"note: {message}")
    for row in checked_notebook.rows:
        print_result(f"{'ok ' if row.is_readable else '-- '} {row.part}: {row.message}")
    if summary_path:
        from qdot.grader.reports.formats import write_to_path
        from qdot.grader.reports.github import make_check_annotations, make_check_summary

        write_to_path(summary_path, make_check_summary(checked_notebook))
        if annotations := make_check_annotations(notebook, checked_notebook):
            print_result(annotations)
    readable_count = sum(row.is_readable for row in checked_notebook.rows)
    answers = f"{readable_count} of {count_noun(len(checked_notebook.rows), 'answer')}"
    print_result(f"{answers} can be read; qdot does not check here whether they are right")
    if readable_count < len(checked_notebook.rows):
        raise typer.Exit(1)
