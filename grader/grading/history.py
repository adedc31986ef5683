"""Store replaced results in graded/history/STUDENT.jsonl, and compare the results of a run with the previous results.

results.jsonl contains the results of the last run. That file is written after all other files, so an interrupted run
replaces nothing. A result is stored in the history before it disappears from results.jsonl.
"""

import contextlib
import datetime
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError, count_noun
from qdot.exercises.common.files import remove_leftovers, write_atomically
from qdot.exercises.common.json_form import parse_dataclass, to_jsonable
from qdot.grader.grading.result import MarkingVersions, Result
from qdot.grader.marking.marking import format_points, map_max_points, sum_points


@dataclass(frozen=True)
class MarkChange:
    """A changed mark for a part, or a changed total if `part` is empty.

    `old_points` and `new_points` are texts. All fields are displayed.
    """

    student: str
    part: str
    old_points: str
    new_points: str
    reason: str


def read_previous_results(assignment: Assignment) -> dict[str, Result]:
    """Map each student to the result of the previous run. Lines of results.jsonl that can't be parsed are omitted."""
    return {result.student: result for _, result in _read_previous_lines(assignment)}


def _read_previous_lines(assignment: Assignment) -> Iterator[tuple[bytes, Result]]:
    """Yield pairs of a line of results.jsonl and the result in it. Only one result at a time is in memory.

    A line that another version of qdot wrote may have additional fields, or lack optional fields.
    """
    try:
        content = results_path(assignment).read_bytes()
    except OSError:
        return
    for line in io.BytesIO(content):
        with contextlib.suppress(ValueError):
            yield line, parse_dataclass(Result, line)


def results_path(assignment: Assignment) -> Path:
    """Return the path of an assignment's results.jsonl."""
    return assignment.folder / "graded" / "results.jsonl"


def read_results_to_report(assignment: Assignment) -> tuple[Assignment, list[Result]]:
    """Return an assignment with only the graded students, and the results of these students, for a report.

    Both are in the order of the roster. Raises QdotError if nothing has been graded, or if the results belong to other
    problems or another version of qdot.
    """
    path = results_path(assignment)
    advice = f"run: qdot grade {assignment.folder}"
    if not path.exists():
        raise QdotError(f"{path} does not exist, because nothing has been graded; {advice}")
    lines = {result.student: (line, result) for line, result in _read_previous_lines(assignment)}
    roster = tuple(student for student in assignment.roster if student.id in lines)
    if not roster:
        raise QdotError(f"{path} contains no student of the roster; {advice}")
    max_points = list(map_max_points(assignment).items())
    results = []
    for line, result in (lines[student.id] for student in roster):
        if to_jsonable(result) != json.loads(line):
            raise QdotError(f"{path}: another version of qdot wrote the result of {result.student}; {advice}")
        if [(name, part.max_points) for name, part in result.parts.items()] != max_points:
            raise QdotError(f"{path}: assignment.toml has changed since the grading; {advice}")
        results.append(result)
    return replace(assignment, roster=roster), results


def store_previous_results(assignment: Assignment, results: Sequence[Result]) -> None:
    """Add previous results to the history if `results` replace them, or if their student is no longer on the roster.

    Unchanged results are not added. A result that an interrupted run has already added is not added again.
    """
    result_by_student = {result.student: result for result in results}
    folder = assignment.folder / "graded" / "history"
    remove_leftovers(folder / f"{result.student}.jsonl" for _, result in _read_previous_lines(assignment))
    for line, old_result in _read_previous_lines(assignment):
        path = folder / f"{old_result.student}.jsonl"
        new_result = result_by_student.get(old_result.student)
        if new_result is None or _clear_versions_and_times(old_result) != _clear_versions_and_times(new_result):
            _append_to_history(path, json.loads(line), describe_reasons(old_result, new_result))


def _append_to_history(path: Path, old_result: object, reason: str) -> None:
    """Append a result to the history file of its student, with the time and the reason why it was replaced."""
    try:
        lines = [line for line in path.read_text(encoding="utf-8").split("\n") if line]
    except (OSError, ValueError):
        lines = []
    with contextlib.suppress(ValueError, KeyError, TypeError, IndexError):  # raised if the last line is damaged
        if json.loads(lines[-1])["result"] == old_result:
            lines.pop()  # an interrupted run added this result, perhaps with another reason
    time = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    lines.append(json.dumps({"replaced": time, "why": reason, "result": old_result}, ensure_ascii=False))
    write_atomically(path, "".join(f"{line}\n" for line in lines), 0o600)


def _clear_versions_and_times(result: Result) -> Result:
    """Return a result as if read from results.jsonl, without versions and times.

    If only these differ, there is no reason to store the result. If a submission is late, the field `late` still
    contains its time.
    """
    attempts = tuple(replace(attempt, received=None) for attempt in result.attempts)
    submission = None if result.submission is None else replace(result.submission, received=None)
    cleared_result = replace(result, made_from=MarkingVersions(), attempts=attempts, submission=submission)
    return parse_dataclass(Result, json.dumps(to_jsonable(cleared_result)))


# --- reasons for changed results ---


def describe_reasons(old_result: Result, new_result: Result | None) -> str:
    """Return the reasons for a changed result, as text; `new_result` is None if the student left the roster."""
    if new_result is None:
        return "no longer on the roster"
    reasons = _find_grading_reasons(old_result, new_result)
    if old_result.overrides != new_result.overrides:
        reasons.append("override")
    results = (old_result, new_result)
    old_time, new_time = (result.submission and result.submission.received for result in results)
    old_deduction, new_deduction = (result.late and (result.late.due, result.late.penalty) for result in results)
    if old_time == new_time and old_deduction != new_deduction:
        reasons.append("late rule")
    elif old_time != new_time and old_result.late != new_result.late and not reasons:
        reasons.append("received at another time")
    return ", ".join(reasons) or "graded again"


def _find_grading_reasons(old_result: Result, new_result: Result) -> list[str]:
    """Return the reasons why the grader may have given different points."""
    reasons = []
    old_versions, new_versions = old_result.made_from, new_result.made_from
    submission = new_result.submission
    results = (old_result, new_result)
    old_file, new_file = ((result.file, result.submission and result.submission.sha256) for result in results)
    if old_file != new_file:
        earlier_attempts = [(attempt.file, attempt.received) for attempt in old_result.attempts]
        if submission is None:
            reasons.append("submission missing")
        elif (submission.file, submission.received) in earlier_attempts:
            reasons.append("another attempt counts")
        else:
            reasons.append("new submission")
    # The results of an older qdot lack the versions.
    if old_versions != MarkingVersions() and old_versions.assignment != new_versions.assignment:
        reasons.append("assignment changed")
    if (old_versions.engine, old_versions.grader) != (new_versions.engine, new_versions.grader):
        reasons.append("grader changed")
    return reasons


# --- changed marks ---


def find_mark_changes(previous_results: Mapping[str, Result], results: Sequence[Result]) -> list[MarkChange]:
    """Return the marks that changed since the previous run, with the reasons.

    Students on the roster come first, in the order of the roster.
    """
    changes: list[MarkChange] = []
    current_results = {result.student: result for result in results}
    for student, result in current_results.items():
        if student in previous_results:
            changes += _find_changes_of_student(student, previous_results[student], result)
        else:
            changes.append(MarkChange(student, "", "–", format_points(result.score), "new on the roster"))
    for student, result in previous_results.items():
        if student not in current_results:
            changes.append(MarkChange(student, "", format_points(result.score), "–", describe_reasons(result, None)))
    return changes


def _find_changes_of_student(student: str, old_result: Result, new_result: Result) -> list[MarkChange]:
    """Return the changed marks of a student: the parts, then the total."""
    changes = []
    for part in dict.fromkeys((*new_result.parts, *old_result.parts)):
        old_points, new_points = _describe_mark(old_result, part), _describe_mark(new_result, part)
        if old_points != new_points:
            reason = _describe_part_reason(part, old_result, new_result)
            changes.append(MarkChange(student, part, old_points, new_points, reason))
    if changes or old_result.score != new_result.score:
        old_points, new_points = format_points(old_result.score), format_points(new_result.score)
        changes.append(MarkChange(student, "", old_points, new_points, describe_reasons(old_result, new_result)))
    return changes


def _describe_mark(result: Result, part: str) -> str:
    """Return the points of a part as text; a dash if the result has no such part."""
    if part not in result.parts:
        return "–"
    points = result.parts[part].points
    return "ungraded" if points is None else format_points(points)


def _describe_part_reason(part: str, old_result: Result, new_result: Result) -> str:
    """Return the reasons for the changed mark of a part, as text."""
    reasons = _find_grading_reasons(old_result, new_result)
    old_override, new_override = old_result.overrides.get(part), new_result.overrides.get(part)
    if old_override != new_override:
        group = next((override.group for override in (new_override, old_override) if override is not None), None)
        reasons.append("override" if group is None else f"override of {group}")
    return ", ".join(reasons) or "graded again"


def describe_mark_changes(previous_results: Mapping[str, Result], results: Sequence[Result]) -> str:
    """Return the comparison of a run with the previous one, as `qdot grade --diff` prints it."""
    if not previous_results:
        return "there is nothing to compare with, because this is the first run"
    changes = find_mark_changes(previous_results, results)
    if not changes:
        return "no mark has changed since the last run"
    rows = [(row.student, row.part or "total", row.old_points, row.new_points, row.reason) for row in changes]
    student_width, part_width, old_width, new_width, _ = (max(map(len, column)) for column in zip(*rows, strict=True))
    row_format = f"{{:<{student_width}}}  {{:<{part_width}}}  {{:>{old_width}}} → {{:<{new_width}}}  {{}}"
    old_sum, new_sum = (sum_points(result.score for result in run) for run in (previous_results.values(), results))
    student_count = len({change.student for change in changes})
    marks = f"marks of {count_noun(student_count, 'student')} changed since the last run"
    difference = sum_points((new_sum, -old_sum))
    difference_words = f"{'+' if difference >= 0 else '−'}{format_points(abs(difference))}"
    total = f"total points {format_points(old_sum)} → {format_points(new_sum)} ({difference_words})"
    return "\n".join([*(row_format.format(*row) for row in rows), f"{marks}; {total}"])
