"""`qdot grade`: grade what a class has submitted, or one student."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from statistics import fmean
from typing import Annotated

import typer

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.assignment.release import CORE_COUNT
from qdot.exercises.common.console import note, say, show_progress
from qdot.exercises.common.errors import QdotError, count_noun, list_some
from qdot.grader.cli.options import FolderArgument, JobsOption, SecondsOption
from qdot.grader.grading.batch import (
    find_student,
    grade_class,
    grade_one,
    lock_folder,
    make_limits,
    parse_time,
)
from qdot.grader.grading.class_check import check_class, check_secret, read_sample
from qdot.grader.grading.history import describe_mark_changes, read_previous_results
from qdot.grader.grading.marking import format_points
from qdot.grader.grading.overrides import OVERRIDES_FILE, describe_unused_groups, read_overrides
from qdot.grader.grading.result import Result
from qdot.grader.reports.tables import UNMARKED_STATES, count_overridden, list_staff_notes, work_status
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits, check_system
from qdot.grader.submissions.submission import (
    OTHER_VERSION,
    StudentFiles,
    SubmissionFolder,
    find_student_files,
    find_submissions,
    open_submissions,
)


def grade(
    folder: FolderArgument,
    submissions: Annotated[
        Path | None, typer.Argument(metavar="SUBMISSIONS", help="A folder or a platform's zip. Default: DIR/submitted.")
    ] = None,
    jobs: JobsOption = CORE_COUNT,
    fail_under: Annotated[
        float, typer.Option(metavar="PERCENT", help="Exit with code 1 if a student has less than this, or no mark.")
    ] = 0.0,
    seconds: SecondsOption = Limits.seconds,
    diff: Annotated[
        bool, typer.Option("--diff", help="List the students whose marks changed since the last run, and why.")
    ] = False,
    allow_missing: Annotated[
        bool, typer.Option("--allow-missing", help="Remove the marks of students with nothing in SUBMISSIONS any more.")
    ] = False,
    report: Annotated[
        list[str],
        typer.Option(metavar="FORMAT=PATH", help="Also write this report. Repeatable; - is standard output."),
    ] = [],  # noqa: B006
    student: Annotated[
        str,
        typer.Option(metavar="ID", help="Grade only this student; SUBMISSIONS is the student's notebook or folder."),
    ] = "",
    received: Annotated[
        str, typer.Option(metavar="TIME", help="With --student: time of submission, if the file does not have it.")
    ] = "",
    executor: Annotated[
        str, typer.Option(metavar="tcp://HOST:PORT", help="Run the notebooks on the cluster with this Dask scheduler.")
    ] = "",
) -> None:
    """Grade the submissions of a class, and write feedback.

    Reads SUBMISSIONS/STUDENT/*.ipynb (or SUBMISSIONS/STUDENT.ipynb) for each student on the roster, or a download from
    Moodle, Canvas or Gradescope, as a folder or as the zip (docs/submissions.md). Writes
    DIR/graded/results.jsonl, DIR/graded/grades.csv and DIR/graded/feedback/STUDENT.html. Unchanged submissions are
    not graded again, so a stopped run continues where it was. Earlier results are stored in
    DIR/graded/history/STUDENT.jsonl. DIR/overrides.csv (student,part,points,comment) sets points by hand; its column
    group sets those of all equal wrong answers, by the key that `qdot report` shows.
    The formats of --report are in docs/export-formats.md. With --student, only these reports are written.

    Examples:
      qdot grade homework
          the submissions in homework/submitted
      qdot grade homework moodle.zip
          a download from Moodle, Canvas or Gradescope
      qdot grade homework --diff
          also list whose marks changed since the last run
      qdot grade homework --report canvas=canvas.csv --report xlsx=grades.xlsx
          marks for other programs
      qdot grade homework late.ipynb --student s001 --report json=-
          only one student; no files are written
    """
    from qdot.grader.reports.formats import STDOUT, parse_report_options, write_requested_reports

    reports = parse_report_options(report, bool(student))
    if received and not student:
        raise QdotError("--received applies to one student's notebook: add --student ID")
    assignment = load_assignment(folder)
    print_line = note if any(path == STDOUT for _, path in reports) else say
    if student and executor:
        raise QdotError("--executor applies to a whole class; leave it out with --student")
    if allow_missing and student:
        raise QdotError("--allow-missing applies to a whole class; leave it out with --student")
    if student:
        results = [_grade_student(assignment, submissions, student, received, make_limits(seconds))]
        points = f"{format_points(results[0].score)} of {format_points(results[0].max_score)} points"
        summary = f"{results[0].student}: {work_status(results[0])}, {points}"
    else:
        source = submissions or folder / "submitted"
        limits = make_limits(seconds)
        earlier_results, results, summary = _grade_class(assignment, source, limits, jobs, executor, allow_missing)
        if diff:
            print_line(describe_mark_changes(earlier_results, results))
    print_line(summary)
    write_requested_reports(assignment, results, reports)
    _check_graded(results)
    failed_students = [result.student for result in results if result.percent < fail_under]
    if failed_students:
        students = f"{len(failed_students)} of {count_noun(len(results), 'student')}"
        note(f"{students} below {fail_under:g} %, or without a mark: {', '.join(failed_students)}")
        raise typer.Exit(1)


def _grade_class(
    assignment: Assignment, source: Path, limits: Limits, jobs: int, executor: str, allow_missing: bool
) -> tuple[Mapping[str, Result], list[Result], str]:
    """Grade a class's submissions, in a folder or a zip, and write feedback.

    Return the results of the previous run, the new results, and a summary.
    """
    from qdot.grader.reports.write import write_reports

    with open_submissions(source) as root:
        submission_folder = find_submissions(assignment, root)
        check_class(assignment, submission_folder, root, source)
        _note_ownerless(assignment, submission_folder)
        if not executor:  # each worker of a cluster checks its own sandbox
            check_sandbox(assignment.sandbox == "strict")
        with lock_folder(assignment.folder):
            earlier_results = read_previous_results(assignment)
            if not allow_missing:
                _check_nobody_missing(assignment, source, earlier_results, submission_folder.by_student)
            with show_progress("grading", len(assignment.roster)) as counter:
                jobs = min(jobs, len(assignment.roster))
                by_student = submission_folder.by_student
                results = grade_class(assignment, by_student, jobs, limits, lambda _: counter.step(), executor=executor)
            with show_progress("writing feedback", len(results)) as counter:
                results = write_reports(assignment, results, jobs, counter.step)
    _print_staff_notes(results)
    groups = Counter(part.group for result in results for part in result.parts.values() if part.group is not None)
    largest_first = [group for group, _ in groups.most_common()]
    for message in describe_unused_groups(assignment, read_overrides(assignment), largest_first):
        note(message)
    ownerless = len(submission_folder.uncertain_owners) + len(submission_folder.not_on_roster)
    if not ownerless and all(result.submission is None for result in results):
        note(f"there are no submissions: put them into {source}, as STUDENT/{assignment.key}.ipynb")
    return earlier_results, results, _summarize(results, assignment.folder, ownerless)


def _check_nobody_missing(
    assignment: Assignment, source: Path, earlier_results: Mapping[str, Result], by_student: Mapping[str, StudentFiles]
) -> None:
    """Raise QdotError if students who had a submission in the last run have none now: they would lose their marks.

    This happens if a second zip contains only late submissions, or if a platform's zip was graded but is not named in
    this run.
    """
    names = [student.id for student in assignment.roster]
    students_with_submission = {name for name, result in earlier_results.items() if result.submission is not None}
    missing = [name for name in names if name not in by_student and name in students_with_submission]
    if missing:
        students = f"{len(missing)} of {count_noun(len(names), 'student')} graded in the last run"
        raise QdotError(
            f"{source}: submissions of {students} are missing: {list_some(missing, 5)}; put all submissions into "
            "one folder or zip, or add --allow-missing to remove these marks"
        )


def _note_ownerless(assignment: Assignment, submitted: SubmissionFolder) -> None:
    """Print notes on the files that belong to nobody on the roster or fit several students."""
    for message in submitted.uncertain_owners:
        note(message)
    for name in submitted.not_on_roster:
        hint = f"; put it into the student's folder, as in STUDENT/{name}" * (name == f"{assignment.key}.ipynb")
        note(f"{name}: the roster has no student with this name; not graded{hint}")


def _grade_student(assignment: Assignment, path: Path | None, name: str, received: str, limits: Limits) -> Result:
    """Grade only one student, from a notebook or folder, or from the submissions of the class."""
    student = find_student(assignment, name)
    time = parse_time(received) if received else None
    if path is not None:
        files = find_student_files(assignment, path, time)
    else:
        files = find_submissions(assignment, assignment.folder / "submitted").by_student.get(student.id)
        if files is not None and time is not None:
            files = replace(files, received=time, platform="option")
    sample = read_sample(assignment, {} if files is None else {student.id: files}, [student.id])
    check_secret(assignment, [submission for _, submission in sample], path or assignment.folder / "submitted")
    check_sandbox(assignment.sandbox == "strict")
    result = grade_one(assignment, student, files, limits)
    _print_staff_notes([result])
    return result


def _check_graded(results: list[Result]) -> None:
    """Print a note on the students who exceeded a limit. Raises QdotError if qdot failed to grade any student."""
    over_limit = [result.student for result in results if work_status(result) == "over limit"]
    if over_limit:
        advice = "the feedback says which limit, and you can set points in overrides.csv"
        note(f"no mark, because the submission exceeds a limit: {list_some(over_limit, 5)}; {advice}")
    if any(work_status(result) == "ungraded" for result in results):
        reasons = "feedback and grades.csv call them 'ungraded' and give the reason"
        raise QdotError(f"qdot failed on some answers, which have no mark; {reasons}. Please report it")


def check_sandbox(must_be_strict: bool) -> None:
    """Print a note on what this machine's sandbox does not enforce. If `must_be_strict`, raise QdotError instead."""
    check_system()
    findings = guarantees.probe(quick=not must_be_strict)
    if must_be_strict and not findings.is_strict:
        raise QdotError(guarantees.explain_refusal(findings))
    if warning := guarantees.describe_weakness(findings):
        note(warning)


def _print_staff_notes(results: list[Result]) -> None:
    """Print the notes for the staff, one line for each note of a student, and one line about all outdated notebooks."""
    for result in results:
        for message in list_staff_notes(result):
            if message != OTHER_VERSION:
                note(f"{result.student}: {message}")
    submitted_count = sum(result.submission is not None for result in results)
    outdated_count = sum(OTHER_VERSION in result.staff_notes for result in results)
    if outdated_count:
        number = (
            f"{outdated_count} of {count_noun(submitted_count, 'notebook')} {'was' if outdated_count == 1 else 'were'}"
        )
        other_inputs = "another assignment.toml, redrawn.csv or secret"
        note(f"WARNING: {number} made from {other_inputs}: distribute the new notebooks, or restore the old files")


def _summarize(results: list[Result], folder: Path, ownerless: int) -> str:
    """Return a line that summarises the results; `ownerless` is the number of files without a certain owner."""
    kinds = ", ".join(f"{count} {kind}" for kind, count in Counter(map(work_status, results)).items())
    marked_results = [result for result in results if result.submission and work_status(result) not in UNMARKED_STATES]
    percents = [result.percent for result in marked_results]
    mean = f"mean {fmean(percents):.1f} % of submitted work; " if percents else ""
    not_graded = f"{count_noun(ownerless, 'file')} without a certain owner on the roster; " if ownerless else ""
    overridden_count = sum(map(count_overridden, results))
    by_hand = f"{overridden_count} set by {OVERRIDES_FILE}; " if overridden_count else ""
    return f"{count_noun(len(results), 'student')}: {kinds}; {mean}{by_hand}{not_graded}see {folder / 'graded'}"
