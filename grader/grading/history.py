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
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import remove_left_behind, write_atomically
from qdot.exercises.common.json_form import as_json, from_json
from qdot.grader.grading.marking import format_points, list_max_points, sum_points
from qdot.grader.grading.result import MadeFrom, Result


@dataclass(frozen=True)
class Move:
    """A changed mark for a part, or a changed total if `part` is empty. The fields are texts to be displayed."""

    student: str
    part: str
    was: str
    now: str
    why: str


def read_earlier_results(assignment: Assignment) -> dict[str, Result]:
    """Return the results of the previous run by student, without lines that can't be parsed."""
    return {result.student: result for _, result in _earlier_lines(assignment)}


def _earlier_lines(assignment: Assignment) -> Iterator[tuple[bytes, Result]]:
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
        raise QdotError(f"{path}: there is no such file; nothing has been graded, {advice}")
    previous = {result.student: (line, result) for line, result in _earlier_lines(assignment)}
    roster = tuple(student for student in assignment.roster if student.id in previous)
    if not roster:
        raise QdotError(f"{path}: no student of the roster is in it; {advice}")
    max_points = list(list_max_points(assignment).items())
    results = []
    for line, result in (previous[student.id] for student in roster):
        if as_json(result) != json.loads(line):
            raise QdotError(f"{path}: the result of {result.student} is of another version of qdot; {advice}")
        if [(name, part.max_points) for name, part in result.parts.items()] != max_points:
            raise QdotError(f"{path}: assignment.toml was changed after grading; {advice}")
        results.append(result)
    return replace(assignment, roster=roster), results


def keep_earlier_results(assignment: Assignment, results: Sequence[Result]) -> None:
    """Add previous results to the history if `results` replace them, or if their student is no longer on the roster.

    Unchanged results are not added, nor are results that an interrupted run has already added.
    """
    by_student = {result.student: result for result in results}
    folder = assignment.folder / "graded" / "history"
    remove_left_behind(folder / f"{result.student}.jsonl" for _, result in _earlier_lines(assignment))
    for line, was in _earlier_lines(assignment):
        now = by_student.get(was.student)
        if now is None or _noticeable_content(was) != _noticeable_content(_round_trip(now)):
            _append_to_history(folder / f"{was.student}.jsonl", json.loads(line), describe_reasons(was, now))


def _append_to_history(path: Path, was: object, why: str) -> None:
    try:
        lines = [line for line in path.read_text(encoding="utf-8").split("\n") if line]
    except (OSError, ValueError):
        lines = []
    if lines and _result_of_line(lines[-1]) == was:
        lines.pop()  # an interrupted run added this result, perhaps with another reason
    replaced = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    lines.append(json.dumps({"replaced": replaced, "why": why, "result": was}, ensure_ascii=False))
    write_atomically(path, "".join(f"{line}\n" for line in lines), 0o600)


def _result_of_line(line: str) -> object:
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
    return replace(result, made_from=MadeFrom(), attempts=attempts, submission=submission)


# --- reasons for changed results ---


def describe_reasons(was: Result, now: Result | None) -> str:
    """Return the reasons for a changed result, as text."""
    if now is None:
        return "no longer on the roster"
    reasons = _reasons_of_grading(was, now)
    if was.overrides != now.overrides:
        reasons.append("override")
    if _received_time(was) == _received_time(now):
        if _late_rule(was) != _late_rule(now):
            reasons.append("late rule")
    elif was.late != now.late and not reasons:
        reasons.append("received at another time")
    return ", ".join(reasons) or "graded again"


def _reasons_of_grading(was: Result, now: Result) -> list[str]:
    """Return the reasons why the grader may have given different points."""
    reasons = []
    if _counting_file(was) != _counting_file(now):
        if now.submission is None:
            reasons.append("submission gone")
        else:
            earlier_attempts = [(attempt.file, attempt.received) for attempt in was.attempts]
            is_known = (now.submission.file, now.submission.received) in earlier_attempts
            reasons.append("another attempt counts" if is_known else "new submission")
    before, after = was.made_from, now.made_from
    if before != MadeFrom() and before.assignment != after.assignment:  # results of an older qdot lack it
        reasons.append("assignment changed")
    if (before.engine, before.grader) != (after.engine, after.grader):
        reasons.append("grader changed")
    return reasons


def _counting_file(result: Result) -> tuple[str, str | None] | None:
    return None if result.submission is None else (result.submission.file, result.submission.sha256)


def _received_time(result: Result) -> str | None:
    return None if result.submission is None else result.submission.received


def _late_rule(result: Result) -> tuple[str, float] | None:
    """Return the deadline and the penalty of late work; None if the work is on time."""
    return None if result.late is None else (result.late.due, result.late.penalty)


# --- changed marks ---


def find_moves(earlier: Mapping[str, Result], results: Sequence[Result]) -> list[Move]:
    """Return the marks that changed since the previous run, with the reasons.

    Students on the roster come first, in its order.
    """
    changes: list[Move] = []
    current_results = {result.student: result for result in results}
    for student, result in current_results.items():
        if student in earlier:
            changes += _moves_of_student(student, earlier[student], result)
        else:
            changes.append(Move(student, "", "–", _points_in_words(result.score), "new on the roster"))
    for student, was in earlier.items():
        if student not in current_results:
            changes.append(Move(student, "", _points_in_words(was.score), "–", describe_reasons(was, None)))
    return changes


def _moves_of_student(student: str, was: Result, now: Result) -> list[Move]:
    old_overrides, new_overrides = was.overrides, now.overrides
    grading_reasons = ", ".join(_reasons_of_grading(was, now)) or "graded again"
    changes = []
    for part in dict.fromkeys((*now.parts, *was.parts)):
        old_points, new_points = (
            _points_in_words(parts[part].points) if part in parts else "–" for parts in (was.parts, now.parts)
        )
        if old_points != new_points:
            is_overridden = old_overrides.get(part) != new_overrides.get(part)
            changes.append(
                Move(
                    student,
                    part,
                    old_points,
                    new_points,
                    _describe_override(part, was, now) if is_overridden else grading_reasons,
                )
            )
    if changes or was.score != now.score:
        before, after = _points_in_words(was.score), _points_in_words(now.score)
        changes.append(Move(student, "", before, after, describe_reasons(was, now)))
    return changes


def _describe_override(part: str, was: Result, now: Result) -> str:
    """Return a description of the override that was added or removed.

    If a student's answer changes, the override of its previous group no longer applies.
    """
    old_override, new_override = was.overrides.get(part), now.overrides.get(part)
    override = new_override or old_override
    if override is None or override.group is None:
        return "override"
    if new_override is None and now.parts[part].group != override.group:
        return ", ".join([*_reasons_of_grading(was, now), f"no longer in {override.group}"])
    return f"override of {override.group}"


def _points_in_words(points: float | None) -> str:
    return "ungraded" if points is None else format_points(points)


def describe_moves(earlier: Mapping[str, Result], results: Sequence[Result]) -> str:
    """Return the comparison of a run with the previous one, as `qdot grade --diff` prints it."""
    if not earlier:
        return "nothing to compare with: this is the first run"
    changes = find_moves(earlier, results)
    if not changes:
        return "no mark moved since the last run"
    rows = [(move.student, move.part or "total", move.was, move.now) for move in changes]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        f"{student:<{widths[0]}}  {part:<{widths[1]}}  {was:>{widths[2]}} → {now:<{widths[3]}}  {move.why}"
        for move, (student, part, was, now) in zip(changes, rows, strict=True)
    ]
    old_sum, new_sum = (sum_points(result.score for result in run) for run in (earlier.values(), results))
    students = len({move.student for move in changes})
    change = sum_points((new_sum, -old_sum))
    marks = "1 student's mark" if students == 1 else f"{students} students' marks"
    sign = "+" if change >= 0 else "−"
    summary = (
        f"{marks} moved since the last run; all points together {format_points(old_sum)} → {format_points(new_sum)}"
    )
    return "\n".join([*lines, f"{summary} ({sign}{format_points(abs(change))})"])
