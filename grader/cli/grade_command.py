"""`qdot grade`: grade what a class has submitted, or one student."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from statistics import fmean
from typing import Annotated

import typer

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.common.console import note, print_result, show_progress
from qdot.exercises.common.errors import QdotError, count_noun, write_first
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.grader.cli.options import FolderArgument, JobsOption, SecondsOption
from qdot.grader.grading import batch
from qdot.grader.grading.class_check import check_class, check_secret, read_sample
from qdot.grader.grading.history import describe_mark_changes, read_previous_results
from qdot.grader.grading.overrides import OVERRIDES_FILE, describe_unused_groups, read_overrides
from qdot.grader.grading.result import Result
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.grades_table import (
    TO_MARK_FILE,
    count_overridden,
    find_work_status,
    has_points,
    is_marked,
    list_staff_notes,
)
from qdot.grader.sandbox.guarantees import note_sandbox_weakness
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import (
    OTHER_VERSION,
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
        bool, typer.Option("--allow-missing", help="Remove the marks of students who no longer have a submission.")
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
        str, typer.Option(metavar="TIME", help="With --student: time of submission, if the file does not record it.")
    ] = "",
    executor: Annotated[
        str, typer.Option(metavar="tcp://HOST:PORT", help="Run the notebooks on the cluster with this Dask scheduler.")
    ] = "",
) -> None:
    """Grade the submissions of a class, and write feedback.

    Reads SUBMISSIONS/STUDENT/*.ipynb (or SUBMISSIONS/STUDENT.ipynb) for each student on the roster, or a download from
    Moodle, Canvas or Gradescope, as a folder or as the zip (docs/submissions.md). Writes
    DIR/graded/results.jsonl, DIR/graded/grades.csv and DIR/graded/feedback/STUDENT.html. Unchanged submissions are
    not graded again, so a stopped run continues where it stopped. Earlier results are stored in
    DIR/graded/history/STUDENT.jsonl. DIR/overrides.csv (student,part,points,comment) sets points by hand. With a key
    from `qdot report` in its column group, a line sets the points of all equal wrong answers.
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
    is_report_printed = any(path == STDOUT for _, path in reports)
    print_line = note if is_report_printed else print_result  # nothing is printed beside a report
    for option, value in (("--executor", executor), ("--allow-missing", allow_missing)):
        if student and value:
            raise QdotError(f"{option} applies to a whole class; leave it out with --student")
    limits = batch.make_limits(seconds)
    if student:
        result = _grade_student(assignment, submissions, student, received, limits)
        results = [result]
        points = f", {format_points(result.score)} of {format_points(result.max_score)} points"
        summary = f"{result.student}: {find_work_status(result)}{points if has_points(result) else ''}"
    else:
        source = submissions or folder / "submitted"
        earlier_results, results, summary = _grade_class(assignment, source, limits, jobs, executor, allow_missing)
        if diff:
            print_line(describe_mark_changes(earlier_results, results))
    print_line(summary)
    write_requested_reports(assignment, results, reports)
    _check_graded(results)
    failed_students = [result.student for result in results if result.percent < fail_under]
    if failed_students:
        students = f"{len(failed_students)} of {count_noun(len(results), 'student')}"
        note(f"{students} have less than {fail_under:g} %, or no mark: {', '.join(failed_students)}")
        raise typer.Exit(1)


def _grade_class(
    assignment: Assignment, source: Path, limits: Limits, jobs: int, executor: str, allow_missing: bool
) -> tuple[Mapping[str, Result], list[Result], str]:
    """Grade a class's submissions and write feedback; `source` is the folder or zip with the submissions.

    Return a mapping from students to the results of the previous run, the new results, and a summary with the next
    command, if any.
    """
    from qdot.grader.reports.graded_folder import write_reports
    from qdot.grader.reports.returned_feedback import TARGETS

    with open_submissions(source) as root:
        submission_folder = find_submissions(assignment, root)
        check_class(assignment, submission_folder, root, source)
        for message in submission_folder.uncertain_owners:
            note(message)
        for name in submission_folder.not_on_roster:
            is_released_name = name == f"{assignment.key}.ipynb"
            hint = f"; put it into the student's folder, as in STUDENT/{name}" if is_released_name else ""
            note(f"{name}: the roster has no student with this name; not graded{hint}")
        if not executor:  # each worker of a cluster checks its own sandbox
            note_sandbox_weakness(assignment.sandbox == "strict")
        process_count = min(jobs, len(assignment.roster))
        with batch.lock_folder(assignment.folder):
            earlier_results = read_previous_results(assignment)
            if not allow_missing:
                _check_nobody_missing(assignment, source, earlier_results, submission_folder)
            with show_progress("grading", len(assignment.roster)) as counter:
                results = batch.grade_class(
                    assignment, submission_folder.by_student, process_count, limits, lambda _: counter.step(),
                    executor=executor,
                )  # fmt: skip
            with show_progress("writing feedback", len(results)) as counter:
                results = write_reports(assignment, results, process_count, counter.step)
    _print_staff_notes(results)
    group_sizes = Counter(part.group for result in results for part in result.parts.values() if part.group is not None)
    group_keys = [group for group, _ in group_sizes.most_common()]
    for message in describe_unused_groups(assignment, read_overrides(assignment), group_keys):
        note(message)
    ownerless_count = len(submission_folder.uncertain_owners) + len(submission_folder.not_on_roster)
    if not ownerless_count and all(result.submission is None for result in results):
        note(f"there are no submissions: put them into {source}, as STUDENT/{assignment.key}.ipynb")
    summary = _summarize(results, assignment.folder, ownerless_count)
    platforms = {files.platform for files in submission_folder.by_student.values()}
    for name, target in TARGETS.items():
        if target.layout in platforms:
            summary += f"\nreturn the pages: qdot return {assignment.folder} {source} --to {name}"
    return earlier_results, results, summary


def _check_nobody_missing(
    assignment: Assignment, source: Path, earlier_results: Mapping[str, Result], submission_folder: SubmissionFolder
) -> None:
    """Raise QdotError if students who had a submission in the last run have none now: they would lose their marks.

    For example, a second zip may contain only late submissions. Or the last run graded a platform's zip, but this run
    does not name the zip.
    """
    earlier_ids = {student for student, result in earlier_results.items() if result.submission is not None}
    lost_ids = earlier_ids - submission_folder.by_student.keys()
    ids = [student.id for student in assignment.roster]
    missing_ids = [student for student in ids if student in lost_ids]
    if missing_ids:
        students = f"{len(missing_ids)} of {count_noun(len(ids), 'student')} graded in the last run"
        raise QdotError(
            f"{source}: submissions of {students} are missing: {write_first(missing_ids, 5)}; put all submissions into "
            "one folder or zip, or add --allow-missing to remove these marks"
        )


def _grade_student(assignment: Assignment, path: Path | None, identifier: str, received: str, limits: Limits) -> Result:
    """Grade only the student with an identifier, and return the result.

    `path` is the student's notebook or folder; if it is None, the submission is taken from DIR/submitted. `received` is
    the text of `--received`, which may be empty.
    """
    student = assignment.find_student(identifier)
    submission_time = batch.parse_time(received) if received else None
    if path is not None:
        files = find_student_files(assignment, path, submission_time)
    else:
        files = find_submissions(assignment, assignment.folder / "submitted").by_student.get(student.id)
        if files is not None and submission_time is not None:
            files = replace(files, received=submission_time, platform="option")
    sample = read_sample(assignment, {} if files is None else {student.id: files}, [student.id])
    check_secret(assignment, [submission for _, submission in sample], path or assignment.folder / "submitted")
    note_sandbox_weakness(assignment.sandbox == "strict")
    result = batch.grade_one(assignment, student, files, limits)
    _print_staff_notes([result])
    return result


def _check_graded(results: list[Result]) -> None:
    """Print a note on the students who exceeded a limit. Raises QdotError if qdot failed to grade any student."""
    over_limit_ids = [result.student for result in results if find_work_status(result) == "over limit"]
    if over_limit_ids:
        advice = "the feedback says which limit, and you can set points in overrides.csv"
        note(f"no mark, because the submission exceeds a limit: {write_first(over_limit_ids, 5)}; {advice}")
    unmarked_ids = [result.student for result in results if find_work_status(result) == "to mark"]
    if unmarked_ids:
        advice = f"graded/{TO_MARK_FILE} lists them; enter points there, and copy the lines into overrides.csv"
        note(f"answers in words have no points yet: {write_first(unmarked_ids, 5)}; {advice}")
    if any(find_work_status(result) == "ungraded" for result in results):
        reasons = "feedback and grades.csv call them 'ungraded' and give the reason"
        raise QdotError(f"qdot failed on some answers, which have no mark; {reasons}. Please report it")


def _print_staff_notes(results: list[Result]) -> None:
    """Print a line for each note on a student's work, and one line about all outdated notebooks together."""
    for result in results:
        for message in list_staff_notes(result):
            if message != OTHER_VERSION:
                note(f"{result.student}: {message}")
    outdated_count = sum(OTHER_VERSION in result.staff_notes for result in results)
    if outdated_count:
        notebooks = count_noun(sum(result.submission is not None for result in results), "notebook")
        verb = "was" if outdated_count == 1 else "were"
        causes = "another assignment.toml, redrawn.csv or secret"
        advice = "distribute the new notebooks, or restore the old files"
        note(f"WARNING: {outdated_count} of {notebooks} {verb} made from {causes}: {advice}")


def _summarize(results: list[Result], folder: Path, ownerless_count: int) -> str:
    """Return a line that summarises the results; `ownerless_count` is the number of files without a certain owner."""
    counts = Counter(map(find_work_status, results))
    phrases = [", ".join(f"{count} {status}" for status, count in counts.items())]
    if percents := [result.percent for result in results if is_marked(result)]:
        phrases.append(f"mean {fmean(percents):.1f} % of work with a mark")
    if overridden_count := sum(map(count_overridden, results)):
        phrases.append(f"{overridden_count} set by {OVERRIDES_FILE}")
    if ownerless_count:
        phrases.append(f"{count_noun(ownerless_count, 'file')} with an unclear owner")
    return f"{count_noun(len(results), 'student')}: {'; '.join(phrases)}; see {folder / 'graded'}"
