"""The commands that write problems and results for other programs and for people: export, report, return."""

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Annotated

import typer

from qdot.exercises.assignment.certified_problems import FailedSlot, describe_replacements, raise_failed_slots
from qdot.exercises.assignment.replacements import read_replacements
from qdot.exercises.common.console import check_choice, note, print_result, show_progress
from qdot.exercises.common.errors import QdotError, count_noun, make_name_error
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.exercises.exports.export_format import PAPER_SIZES, SHEET_KINDS, ExportRequest
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.exports.sheet import VERSION_LETTERS
from qdot.grader.cli.options import BankVariationOption, FolderArgument, JobsOption, name_option
from qdot.grader.grading.certify import find_failures
from qdot.grader.grading.class_check import load_class
from qdot.grader.marking.marking import compute_earned_share
from qdot.grader.reports.gradebooks import describe_unmarked_students
from qdot.grader.reports.returned_feedback import FOLDER, TARGETS, return_feedback

SHEET_HELP = f"Paper and HTML: kind of sheet, {', '.join(SHEET_KINDS)} (docs/paper.md)."
PASSING_HELP = "this percentage of the points; without it, the package does not report pass or fail"


def export(
    folder: FolderArgument,
    to: Annotated[
        list[str],
        name_option(f"Export format: {', '.join(EXPORT_FORMATS)}. Repeatable.", names=EXPORT_FORMATS, metavar="FORMAT"),
    ] = [],  # noqa: B006
    out: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Folder. Default: DIR/exports/FORMAT.")] = None,
    variants: Annotated[int, typer.Option(min=1, max=10_000, help="Question banks: variants of each problem.")] = 20,
    variation: BankVariationOption = "",
    solutions: Annotated[
        bool,
        typer.Option(
            "--solutions", help="Paper, HTML, Canvas, Common Cartridge, QTI, SCORM: include the worked solutions."
        ),
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
    note_once = cache(note)  # several formats have the same notes on the generated problems
    request = ExportRequest(
        assignment, find_failures, variants, solutions, sheet, versions, page, jobs, report=note_once,
        on_left_out=failed_slots.append, compute_earned_share=compute_earned_share,
        passing_share=None if passing is None else Fraction(passing, 100),
    )  # fmt: skip
    for name in names:
        EXPORT_FORMATS[name].check(request)
    for message in assignment.notes:
        note(message)
    parent = folder / "exports" if out is None else out
    target_folders = {name: parent if out and len(names) == 1 else parent / name for name in names}
    failed_formats = _write_exports(request, target_folders)
    final_assignment = replace(assignment, replacements=read_replacements(folder))
    for message in (*describe_replacements(assignment, final_assignment), *dict.fromkeys(map(str, failed_slots))):
        note(message)
    if failed_formats and failed_slots:  # report the failed formats as a note, and the failed slots as the error
        note(_describe_failures(failed_formats, names))
    raise_failed_slots(final_assignment, failed_slots)
    if failed_formats:
        raise QdotError(_describe_failures(failed_formats, names))


def report(
    folder: FolderArgument,
    out: Annotated[Path | None, typer.Option(metavar="PATH", help="File. Default: DIR/graded/report.html.")] = None,
    report: Annotated[
        list[str],
        typer.Option(metavar="FORMAT=PATH", help="Write this report instead. Repeatable; - is standard output."),
    ] = [],  # noqa: B006
) -> None:
    """Write an overview of the class, on a page for the staff.

    Uses the results of the last `qdot grade`; nothing is graded again.

    The page shows the distribution of scores, difficulty and discrimination of each part, mistakes and who made them,
    equal wrong answers with their key for overrides.csv, whether some variants were harder, late and missing work, and
    students whose wrong answers ignore their own arm (docs/report.md). With --report, only the named formats are
    written (docs/export-formats.md).

    Examples:
      qdot report homework
          an overview page, from the last results
      qdot report homework --report csv=-
          the marks for another program
    """
    from qdot.grader.grading.history import read_results_to_report
    from qdot.grader.reports.formats import STDOUT, parse_report_options, write_requested_reports

    reports = parse_report_options(report, has_one_student=False)
    current_assignment = load_class(folder)
    graded_assignment, results = read_results_to_report(current_assignment)
    ungraded_ids = [student.id for student in current_assignment.roster if student not in graded_assignment.roster]
    if ungraded_ids:
        note(f"{', '.join(ungraded_ids)}: on the roster but not yet graded; left out")
    if not reports or out is not None:
        reports.append(("html", str(out or folder / "graded" / "report.html")))
    write_requested_reports(graded_assignment, results, reports)
    if all(path != STDOUT for _, path in reports):
        for name, path in reports:
            print_result(f"{name}: {path}, {count_noun(len(results), 'student')}")


def return_pages(
    folder: FolderArgument,
    submissions: Annotated[
        Path | None, typer.Argument(metavar="SUBMISSIONS", help="What was graded. Default: DIR/submitted.")
    ] = None,
    to: Annotated[
        str, name_option(f"Where the pages go: {', '.join((*TARGETS, FOLDER))}.", names=(*TARGETS, FOLDER))
    ] = "",
    out: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Folder. Default: DIR/returned/NAME.")] = None,
) -> None:
    """Pack the feedback pages for upload to a platform.

    For Moodle, Canvas and Brightspace, writes a zip that gives each student their page, named as in the platform's
    download of the submissions, and the table of marks that the platform imports. Pass the download that you graded.
    For a folder, writes a page named after each student, such as "Lovelace, Ada (501).html". Nothing is written if a
    page is out of date, or if the platform has no place for it. docs/hand-out-and-return.md says where to upload the
    files.

    Examples:
      qdot return homework moodle.zip --to moodle
          the zip for "Upload feedback files in a zip"
      qdot return homework --to folder
          a folder of pages to send by mail
    """
    from qdot.grader.grading.history import read_results_to_report
    from qdot.grader.submissions.submission import open_submissions

    if not to:
        raise QdotError(f"say where the pages go, as in --to moodle; known: {', '.join((*TARGETS, FOLDER))}")
    check_choice(to, (*TARGETS, FOLDER), "--to")
    assignment, results = read_results_to_report(load_class(folder))
    with open_submissions(submissions or folder / "submitted") as root:
        feedback = return_feedback(assignment, results, to, root, out or folder / "returned" / to)
    for message in (*feedback.notes, *describe_unmarked_students(assignment, results)):
        note(message)
    upload_words = "" if to == FOLDER else f"; upload it {TARGETS[to].upload_words}"
    print_result(f"{count_noun(feedback.page_count, 'page')}: {feedback.pages_path}{upload_words}")
    import_words = "" if to == FOLDER else "; import it into the gradebook"
    print_result(f"marks: {feedback.marks_path}{import_words}")


def _check_options(names: Sequence[str], sheet: str, page: str, variation: str) -> None:
    """Check the options of `export` that don't depend on the assignment. Raises QdotError if an option is invalid."""
    for name in names:
        if name not in EXPORT_FORMATS:
            raise make_name_error("export format", name, list(EXPORT_FORMATS))
        if variation and not EXPORT_FORMATS[name].contains_bank:
            banks = ", ".join(bank for bank, export_format in EXPORT_FORMATS.items() if export_format.contains_bank)
            advice = f"for {name}, set the variation in assignment.toml"
            raise QdotError(f"--variation applies to question banks only ({banks}); {advice}")
    check_choice(sheet, tuple(SHEET_KINDS), "sheet")
    check_choice(page, tuple(PAPER_SIZES), "page size")


def _write_exports(request: ExportRequest, target_folders: Mapping[str, Path]) -> dict[str, str]:
    """Write each export format into its folder; return the formats that can't be written, each with the reason."""
    reasons = {name: EXPORT_FORMATS[name].explain_missing() for name in target_folders}
    failed_formats = {name: reason for name, reason in reasons.items() if reason}
    names = [name for name in target_folders if name not in failed_formats]
    if not names:
        return failed_formats
    step_count = sum(EXPORT_FORMATS[name].count_steps(request) for name in names)
    results: list[str] = []  # printed when the progress bar is gone
    with show_progress(f"exporting to {', '.join(names)}", step_count) as counter:
        for name in names:
            replacements = read_replacements(request.assignment.folder)  # the previous format may have added to them
            assignment = replace(request.assignment, replacements=replacements)
            current_request = replace(request, assignment=assignment, on_step=counter.step)
            folder = target_folders[name]
            try:
                file_count = _write_export(current_request, name, folder)
                results.append(f"{name}: {count_noun(file_count, 'file')} in {folder}")
            except QdotError as error:
                failed_formats[name] = str(error)
    for result in results:
        print_result(result)
    return failed_formats


def _describe_failures(failed_formats: Mapping[str, str], names: Sequence[str]) -> str:
    """Return a message about the export formats that were not written, each with its reason.

    `names` are the formats that the user asked for.
    """
    if len(names) == 1:
        return failed_formats[names[0]]
    verb = "was" if len(failed_formats) == 1 else "were"
    others_clause = "; all other formats were written" if len(failed_formats) < len(names) else ""
    reasons = ". ".join(f"{name}: {error}" for name, error in failed_formats.items())
    return f"{', '.join(failed_formats)} {verb} not written{others_clause}. {reasons}"


def _write_export(request: ExportRequest, name: str, folder: Path) -> int:
    """Write the files of one export format into a folder; return their number."""
    file_count = 0
    with contextlib.closing(EXPORT_FORMATS[name].export(request)) as files:
        for file in files:
            write_atomically(folder / file.path, file.content, 0o600 if file.is_private else 0o644)
            file_count += 1
    return file_count
