"""The commands that write problems and results for other programs and for people: export, report."""

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.assignment.certified_problems import FailedSlot, describe_replacements, raise_failed_slots
from qdot.exercises.assignment.release import CORE_COUNT
from qdot.exercises.assignment.replacements import read_replacements
from qdot.exercises.common.console import BankVariationOption, note, say, show_progress
from qdot.exercises.common.errors import QdotError, count_noun, make_name_error
from qdot.exercises.common.files import write_atomically
from qdot.exercises.exports.export_format import PAPER_SIZES, SHEET_KINDS, ExportRequest
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.sheet import VERSION_LETTERS
from qdot.grader.cli.options import FolderArgument, JobsOption, name_option
from qdot.grader.grading.certify import find_failures
from qdot.grader.grading.class_check import load_class
from qdot.grader.grading.marking import compute_earned_share

SHEET_HELP = f"Paper and HTML: kind of sheet, {', '.join(SHEET_KINDS)} (docs/paper.md)."
PASSING_HELP = "this percentage of the points; without it, the package does not report pass or fail"


def export(
    folder: FolderArgument,
    to: Annotated[
        list[str],
        name_option(f"Export format: {', '.join(EXPORT_FORMATS)}. Repeatable.", names=EXPORT_FORMATS, metavar="FORMAT"),
    ] = [],  # noqa: B006
    out: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Output folder. Default: DIR/exports/FORMAT.")
    ] = None,
    variants: Annotated[
        int, typer.Option(min=1, max=10_000, help="Question banks: how many variants of each problem.")
    ] = 20,
    variation: BankVariationOption = "",
    solutions: Annotated[
        bool, typer.Option("--solutions", help="Paper, HTML, Canvas, QTI, SCORM: include the worked solutions.")
    ] = False,
    sheet: Annotated[str, name_option(SHEET_HELP, names=SHEET_KINDS, metavar="SHEET")] = SHEET_KINDS[0],
    versions: Annotated[
        int, typer.Option(min=0, max=len(VERSION_LETTERS), help="Paper: number of versions A, B, … for an exam hall.")
    ] = 0,
    page: Annotated[
        str, name_option(f"PDF and LaTeX: paper size, {' or '.join(PAPER_SIZES)}.", names=PAPER_SIZES, metavar="SIZE")
    ] = PAPER_SIZES[0],
    passing: Annotated[
        int | None,
        typer.Option("--pass", min=1, max=100, metavar="PERCENT", help=f"SCORM: students pass with {PASSING_HELP}."),
    ] = None,
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Write an assignment for other platforms, or for paper.

    Writes quizzes for learning platforms, handouts and exams, and repositories and autograders that grade on their own.

    For platforms that choose each student's problem from a question bank, the bank has --variants certified variants
    of each problem. Handouts are written for each student on the roster. If one of several formats can't be written,
    the others still are. docs/export-formats.md describes all formats.

    Examples:
      qdot export homework --to html --sheet exam
          an exam on paper for each student
      qdot export homework --to pdf --sheet exam --versions 4
          four versions for an exam hall
      qdot export homework --to moodle --variants 30
          a quiz and a bank of 30 variants for Moodle
    """
    names = list(dict.fromkeys(to))
    if not names:
        raise QdotError(f"give an export format, as in --to html; known: {', '.join(EXPORT_FORMATS)}")
    _check_options(names, sheet, page, variation)
    assignment = load_class(folder)
    if variation:
        assignment = assignment.with_variation(variation)
    failed_slots: list[FailedSlot] = []
    order = ExportRequest(
        assignment, find_failures, variants, solutions, sheet, versions, page, jobs, report=note,
        on_left_out=failed_slots.append, earned_share=compute_earned_share,
        passing_share=None if passing is None else Fraction(passing, 100),
    )  # fmt: skip
    for name in names:
        EXPORT_FORMATS[name].check(order)
    for message in assignment.notes:
        note(message)
    parent = folder / "exports" if out is None else out
    targets = {name: parent if out and len(names) == 1 else parent / name for name in names}
    failed_formats = _write_exports(order, targets)
    final_assignment = replace(assignment, replacements=read_replacements(folder))
    for message in (*describe_replacements(assignment, final_assignment), *dict.fromkeys(map(str, failed_slots))):
        note(message)
    if failed_formats and failed_slots:  # report both, the failed slots as the error
        note(_describe_failures(failed_formats, names))
    raise_failed_slots(final_assignment, failed_slots)
    if failed_formats:
        raise QdotError(_describe_failures(failed_formats, names))


def report(
    folder: FolderArgument,
    out: Annotated[
        Path | None, typer.Option(metavar="PATH", help="Output file. Default: DIR/graded/report.html.")
    ] = None,
    report: Annotated[
        list[str],
        typer.Option(metavar="FORMAT=PATH", help="Write this report instead. Repeatable; - is standard output."),
    ] = [],  # noqa: B006
) -> None:
    """Write an overview of the class, on a page for the staff.

    Uses the results of the last `qdot grade`; nothing is graded again.

    The page shows the distribution of scores, difficulty and discrimination of each part, mistakes and who made them,
    equal wrong answers with their key for overrides.csv, right answers in unusual forms, whether some variants were
    harder, late and missing work, and wrong answers that are nearly the same (docs/report.md). With --report, only
    the named formats are written (docs/export-formats.md).

    Examples:
      qdot report homework
          an overview page, from the last results
      qdot report homework --report csv=-
          the marks for another program
    """
    from qdot.grader.grading.history import read_last_results
    from qdot.grader.reports.formats import STDOUT, parse_report_options, write_requested_reports

    reports = parse_report_options(report, has_one_student=False)
    whole_class = load_class(folder)
    assignment, results = read_last_results(whole_class)
    left_out = [student.id for student in whole_class.roster if student not in assignment.roster]
    if left_out:
        note(f"{', '.join(left_out)}: on the roster but not yet graded; left out")
    if not reports or out is not None:
        reports.append(("html", str(out or folder / "graded" / "report.html")))
    write_requested_reports(assignment, results, reports)
    if all(path != STDOUT for _, path in reports):
        for name, path in reports:
            say(f"{name}: {path}, {count_noun(len(results), 'student')}")


def _check_options(names: Sequence[str], sheet: str, page: str, variation: str) -> None:
    """Check the options of `export` that don't depend on the assignment. Raises QdotError if one is invalid."""
    for name in names:
        if name not in EXPORT_FORMATS:
            raise make_name_error("export format", name, list(EXPORT_FORMATS))
        if variation and not EXPORT_FORMATS[name].contains_bank:
            banks = ", ".join(name for name, export_format in EXPORT_FORMATS.items() if export_format.contains_bank)
            advice = f"for {name}, set the variation in assignment.toml"
            raise QdotError(f"--variation applies to question banks only ({banks}); {advice}")
    for value, choices, description in ((sheet, SHEET_KINDS, "sheet"), (page, PAPER_SIZES, "page size")):
        if value not in choices:
            raise make_name_error(description, value, list(choices))


def _write_exports(order: ExportRequest, targets: Mapping[str, Path]) -> dict[str, str]:
    """Write each export format into its folder; return the formats that can't be written, each with the reason."""
    failed_formats = {name: reason for name in targets if (reason := EXPORT_FORMATS[name].explain_missing())}
    for name, target in targets.items():
        if name in failed_formats:
            continue
        replacements = read_replacements(order.assignment.folder)  # the previous format may have added to it
        request = replace(order, assignment=replace(order.assignment, replacements=replacements))
        try:
            say(f"{name}: {count_noun(_export_one(request, name, target), 'file')} in {target}")
        except QdotError as error:
            failed_formats[name] = str(error)
    return failed_formats


def _describe_failures(failed: Mapping[str, str], names: Sequence[str]) -> str:
    """Return a message that names the export formats that were not written, with the reasons."""
    if len(names) == 1:
        return failed[names[0]]
    verb = "was" if len(failed) == 1 else "were"
    others_clause = "; all other formats were written" if len(failed) < len(names) else ""
    reasons = ". ".join(f"{name}: {error}" for name, error in failed.items())
    return f"{', '.join(failed)} {verb} not written{others_clause}. {reasons}"


def _export_one(order: ExportRequest, name: str, target: Path) -> int:
    """Write the files of one export format into a folder; return their number."""
    export_format = EXPORT_FORMATS[name]
    count = 0
    with (
        show_progress(f"exporting to {name}", export_format.count_steps(order)) as counter,
        contextlib.closing(export_format.export(replace(order, on_step=counter.step))) as files,
    ):
        for file in files:
            write_atomically(target / file.path, file.content, 0o600 if file.is_private else 0o644)
            count += 1
    return count
