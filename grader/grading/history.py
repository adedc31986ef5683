"""Store replaced results in graded/history/STUDENT.jsonl, and compare the results of a run with the previous ones.

results.jsonl contains the results of the last run. It is written after everything else, so an interrupted run replaces
nothing, and a result is stored in the history before it disappears from results.jsonl.
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
from qdot.exercises.common.json_form import as_json, from_json
from qdot.grader.grading.marking import format_points, map_max_points, sum_points
from qdot.grader.grading.result import MarkingVersions, Result


@dataclass(frozen=True)
class MarkChange:
    """A changed mark for a part, or a changed total if `part` is empty. The fields are texts to be displayed."""

    student: str
    part: str
    before: str
    after: str
    reason: str


def read_previous_results(assignment: Assignment) -> dict[str, Result]:
    """Return the results of the previous run by student, without lines that can't be parsed."""
    return {result.student: result for _, result in _read_previous_lines(assignment)}


def _read_previous_lines(assignment: Assignment) -> Iterator[tuple[bytes, Result]]:
    """Yield each line of the previous results and the result in it, one at a time to save memory.

    A line that another version of qdot wrote may have additional fields, or lack optional ones.
    """
    try:
        content = results_path(assignment).read_bytes()
    except OSError:
        return
    for line in io.BytesIO(content):
        with contextlib.suppress(ValueError):
            yield line, from_json(Result, line)


def results_path(assignment: Assignment) -> Path:
    """Return the path of results.jsonl."""
    return assignment.folder / "graded" / "results.jsonl"


def read_last_results(assignment: Assignment) -> tuple[Assignment, list[Result]]:
    """Return the assignment with only the graded students, and their results of the last run, in the roster's order.

    Raises QdotError if nothing has been graded, or if the results belong to other problems or another version of qdot.
    """
    path = results_path(assignment)
    advice = f"run: qdot grade {assignment.folder}"
    if not path.exists():
        raise QdotError(f"{path} does not exist, because nothing has been graded; {advice}")
    previous = {result.student: (line, result) for line, result in _read_previous_lines(assignment)}
    roster = tuple(student for student in assignment.roster if student.id in previous)
    if not roster:
        raise QdotError(f"{path} contains no student of the roster; {advice}")
    max_points = list(map_max_points(assignment).items())
    results = []
    for line, result in (previous[student.id] for student in roster):
        if as_json(result) != json.loads(line):
            raise QdotError(f"{path}: another version of qdot wrote the result of {result.student}; {advice}")
        if [(name, part.max_points) for name, part in result.parts.items()] != max_points:
            raise QdotError(f"{path}: assignment.toml has changed since the grading; {advice}")
        results.append(result)
    return replace(assignment, roster=roster), results


def store_previous_results(assignment: Assignment, results: Sequence[Result]) -> None:
    """Add previous results to the history if `results` replace them, or if their student is no longer on the roster.

    Unchanged results are not added, nor are results that an interrupted run has already added.
    """
    by_student = {result.student: result for result in results}
    folder = assignment.folder / "graded" / "history"
    remove_leftovers(folder / f"{result.student}.jsonl" for _, result in _read_previous_lines(assignment))
    for line, previous_result in _read_previous_lines(assignment):
        current_result = by_student.get(previous_result.student)
        if current_result is None or _noticeable_content(previous_result) != _noticeable_content(
            _round_trip(current_result)
        ):
            _append_to_history(
                folder / f"{previous_result.student}.jsonl",
                json.loads(line),
                describe_reasons(previous_result, current_result),
            )


def _append_to_history(path: Path, previous_result: object, reason: str) -> None:
    try:
        lines = [line for line in path.read_text(encoding="utf-8").split("\n") if line]
    except (OSError, ValueError):
        lines = []
    if lines and _parse_history_line(lines[-1]) == previous_result:
        lines.pop()  # an interrupted run added this result, perhaps with another reason
    replaced = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    lines.append(json.dumps({"replaced": replaced, "why": reason, "result": previous_result}, ensure_ascii=False))
    write_atomically(path, "".join(f"{line}\n" for line in lines), 0o600)


def _parse_history_line(line: str) -> object:
    try:
        return json.loads(line)["result"]
    except (ValueError, KeyError, TypeError):
        return None


def _round_trip(result: Result) -> Result:
    """Return a result as it will be when it is read back from results.jsonl."""
    return from_json(Result, json.dumps(as_json(result)))


def _noticeable_content(result: Result) -> Result:
    """Return a result without the fields in which nobody notices a change.

    If work is late, the field `late` still contains its time.
    """
    attempts = tuple(replace(attempt, received=None) for attempt in result.attempts)
    submission = None if result.submission is None else replace(result.submission, received=None)
    return replace(result, made_from=MarkingVersions(), attempts=attempts, submission=submission)


# --- reasons for changed results ---


def describe_reasons(previous: Result, current: Result | None) -> str:
    """Return the reasons for a changed result, as text."""
    if current is None:
        return "no longer on the roster"
    reasons = _find_grading_reasons(previous, current)
    if previous.overrides != current.overrides:
        reasons.append("override")
    received_times = [result.submission and result.submission.received for result in (previous, current)]
    late_rules = [result.late and (result.late.due, result.late.penalty) for result in (previous, current)]
    if received_times[0] == received_times[1]:
        if late_rules[0] != late_rules[1]:
            reasons.append("late rule")
    elif previous.late != current.late and not reasons:
        reasons.append("received at another time")
    return ", ".join(reasons) or "graded again"


def _find_grading_reasons(previous: Result, current: Result) -> list[str]:
    """Return the reasons why the grader may have given different points."""
    reasons = []
    files = [result.submission and (result.submission.file, result.submission.sha256) for result in (previous, current)]
    if files[0] != files[1]:
        if current.submission is None:
            reasons.append("submission missing")
        else:
            earlier_attempts = [(attempt.file, attempt.received) for attempt in previous.attempts]
            is_known = (current.submission.file, current.submission.received) in earlier_attempts
            reasons.append("another attempt counts" if is_known else "new submission")
    previous_versions, current_versions = previous.made_from, current.made_from
    # results of an older qdot lack the versions
    if previous_versions != MarkingVersions() and previous_versions.assignment != current_versions.assignment:
        reasons.append("assignment changed")
    if (previous_versions.engine, previous_versions.grader) != (current_versions.engine, current_versions.grader):
        reasons.append("grader changed")
    return reasons


# --- changed marks ---


def find_mark_changes(previous_results: Mapping[str, Result], results: Sequence[Result]) -> list[MarkChange]:
    """Return the marks that changed since the previous run, with the reasons.

    Students on the roster come first, in its order.
    """
    changes: list[MarkChange] = []
    current_results = {result.student: result for result in results}
    for student, result in current_results.items():
        if student in previous_results:
            changes += _find_changes_of_student(student, previous_results[student], result)
        else:
            changes.append(MarkChange(student, "", "–", _points_text(result.score), "new on the roster"))
    for student, previous_result in previous_results.items():
        if student not in current_results:
            changes.append(
                MarkChange(
                    student, "", _points_text(previous_result.score), "–", describe_reasons(previous_result, None)
                )
            )
    return changes


def _find_changes_of_student(student: str, previous: Result, current: Result) -> list[MarkChange]:
    changes = []
    for part in dict.fromkeys((*current.parts, *previous.parts)):
        before, after = (
            _points_text(parts[part].points) if part in parts else "–" for parts in (previous.parts, current.parts)
        )
        if before != after:
            changes.append(MarkChange(student, part, before, after, _describe_part_reason(part, previous, current)))
    if changes or previous.score != current.score:
        before, after = _points_text(previous.score), _points_text(current.score)
        changes.append(MarkChange(student, "", before, after, describe_reasons(previous, current)))
    return changes


def _describe_part_reason(part: str, previous: Result, current: Result) -> str:
    """Return the reason for the changed mark of a part: an override that was added or removed, or the grader.

    If a student's answer changes, the override of its previous group no longer applies.
    """
    old_override, new_override = previous.overrides.get(part), current.overrides.get(part)
    if old_override == new_override:
        return ", ".join(_find_grading_reasons(previous, current)) or "graded again"
    override = new_override or old_override
    if override is None or override.group is None:
        return "override"
    if new_override is None and current.parts[part].group != override.group:
        return ", ".join([*_find_grading_reasons(previous, current), f"no longer in {override.group}"])
    return f"override of {override.group}"


def _points_text(points: float | None) -> str:
    return "ungraded" if points is None else format_points(points)


def describe_mark_changes(previous_results: Mapping[str, Result], results: Sequence[Result]) -> str:
    """Return the comparison of a run with the previous one, as `qdot grade --diff` prints it."""
    if not previous_results:
        return "there is nothing to compare with, because this is the first run"
    changes = find_mark_changes(previous_results, results)
    if not changes:
        return "no mark has changed since the last run"
    rows = [(each.student, each.part or "total", each.before, each.after, each.reason) for each in changes]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        f"{student:<{widths[0]}}  {part:<{widths[1]}}  {old_mark:>{widths[2]}} → {new_mark:<{widths[3]}}  {reason}"
        for student, part, old_mark, new_mark, reason in rows
    ]
    old_sum, new_sum = (sum_points(result.score for result in run) for run in (previous_results.values(), results))
    students, change = len({each.student for each in changes}), sum_points((new_sum, -old_sum))
    marks = f"marks of {count_noun(students, 'student')} changed since the last run"
    difference = f"{'+' if change >= 0 else '−'}{format_points(abs(change))}"
    total = f"total points {format_points(old_sum)} → {format_points(new_sum)} ({difference})"
    return "\n".join([*lines, f"{marks}; {total}"])
