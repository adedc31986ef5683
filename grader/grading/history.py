"""What earlier runs gave: kept in graded/history/STUDENT.jsonl when replaced, and compared with the run just made.

results.jsonl is the last run's word. It is written after everything else, so that a run that was stopped has replaced
nothing yet, and what an earlier run gave is in the history before it is gone from there.
"""

import contextlib
import datetime
import io
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import remove_left_behind, write_atomically
from qdot.exercises.common.json_form import as_json, from_json
from qdot.grader.grading.marking import number, total
from qdot.grader.grading.result import MadeFrom, Result


@dataclass(frozen=True)
class Move:
    """A mark that is another than it was: of a part, or in all where `part` is empty; texts, as they are shown."""

    student: str
    part: str
    was: str
    now: str
    why: str


def earlier_results(assignment: Assignment) -> dict[str, Result]:
    """Return the results of the run before by student; what can't be read is left out."""
    return {result.student: result for _, result in _earlier(assignment)}


def _earlier(assignment: Assignment) -> Iterator[tuple[bytes, Result]]:
    """Yield the same one by one, each with its line: those of a large class take as much memory as the ones just made.

    A line of another version of qdot may have more, or lack what may be missing of a `Result`.
    """
    try:
        written = results_path(assignment).read_bytes()
    except OSError:
        return
    for line in io.BytesIO(written):
        with contextlib.suppress(ValueError):
            yield line, from_json(Result, line)


def results_path(assignment: Assignment) -> Path:
    """Return where the results are."""
    return assignment.folder / "graded" / "results.jsonl"


def last_results(assignment: Assignment) -> tuple[Assignment, list[Result]]:
    """Return what the last run gave, in the roster's order, and the assignment with those students alone.

    Raises QdotError where nothing has been graded, or the results are of other problems or another version.
    """
    path = results_path(assignment)
    again = f"run: qdot grade {assignment.folder}"
    if not path.exists():
        raise QdotError(f"{path}: there is no such file; nothing has been graded, {again}")
    earlier = {result.student: (line, result) for line, result in _earlier(assignment)}
    roster = tuple(student for student in assignment.roster if student.id in earlier)
    if not roster:
        raise QdotError(f"{path}: no student of the roster is in it; {again}")
    names = [f"{slot.name}.{name}" for slot in assignment.slots for name in slot.questions]
    points = [most for slot in assignment.slots for most in slot.max_points]
    results = []
    for line, result in (earlier[student.id] for student in roster):
        if as_json(result) != json.loads(line):
            raise QdotError(f"{path}: the result of {result.student} is of another version of qdot; {again}")
        if list(result.parts) != names or [part.max_points for part in result.parts.values()] != points:
            raise QdotError(f"{path}: assignment.toml was changed after grading; {again}")
        results.append(result)
    return replace(assignment, roster=roster), results


def keep_earlier(assignment: Assignment, results: Sequence[Result]) -> None:
    """Add to the history what is about to be replaced by other results, or goes with a student who left the roster.

    A run that was stopped may have done so before: nothing is added twice. What is the same is not added at all.
    """
    by_student = {result.student: result for result in results}
    folder = assignment.folder / "graded" / "history"
    remove_left_behind(folder / f"{result.student}.jsonl" for _, result in _earlier(assignment))
    for line, was in _earlier(assignment):
        now = by_student.get(was.student)
        if now is None or _content(was) != _content(_as_written(now)):
            _add(folder / f"{was.student}.jsonl", json.loads(line), reasons(was, now))


def _add(path: Path, was: object, why: str) -> None:
    try:
        lines = [line for line in path.read_text(encoding="utf-8").split("\n") if line]
    except (OSError, ValueError):
        lines = []
    if lines and _result_in(lines[-1]) == was:
        lines.pop()  # a run that was stopped put it there, and may have had another reason
    replaced = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    lines.append(json.dumps({"replaced": replaced, "why": why, "result": was}, ensure_ascii=False))
    write_atomically(path, "".join(f"{line}\n" for line in lines), 0o600)


def _result_in(line: str) -> object:
    try:
        return json.loads(line)["result"]
    except (ValueError, KeyError, TypeError):
        return None


def _as_written(result: Result) -> Result:
    """Return a result as it will be read from its file."""
    return from_json(Result, json.dumps(as_json(result)))


def _content(result: Result) -> Result:
    """Return what of a result a student or the staff may notice; when it came is told where it is late."""
    attempts = tuple(replace(attempt, received=None) for attempt in result.attempts)
    submission = None if result.submission is None else replace(result.submission, received=None)
    return replace(result, made_from=MadeFrom(), attempts=attempts, submission=submission)


# --- why ---


def reasons(was: Result, now: Result | None) -> str:
    """Return in words why a result is another than it was."""
    if now is None:
        return "no longer on the roster"
    why = _reasons_of_grading(was, now)
    if was.overrides != now.overrides:
        why.append("override")
    if _received(was) == _received(now):
        if _rule_applied(was) != _rule_applied(now):
            why.append("late rule")
    elif was.late != now.late and not why:
        why.append("received at another time")
    return ", ".join(why) or "graded again"


def _reasons_of_grading(was: Result, now: Result) -> list[str]:
    """Return why the grader may have given something else."""
    why = []
    if _file(was) != _file(now):
        if now.submission is None:
            why.append("submission gone")
        else:
            known = [(attempt.file, attempt.received) for attempt in was.attempts]
            another = (now.submission.file, now.submission.received) in known
            why.append("another attempt counts" if another else "new submission")
    before, after = was.made_from, now.made_from
    if before != MadeFrom() and before.assignment != after.assignment:  # an older qdot didn't say
        why.append("assignment changed")
    if (before.engine, before.grader) != (after.engine, after.grader):
        why.append("grader changed")
    return why


def _file(result: Result) -> tuple[str, str | None] | None:
    return None if result.submission is None else (result.submission.file, result.submission.sha256)


def _received(result: Result) -> str | None:
    return None if result.submission is None else result.submission.received


def _rule_applied(result: Result) -> tuple[str, float] | None:
    """Return what the late rule decides."""
    return None if result.late is None else (result.late.due, result.late.penalty)


# --- whose mark moved ---


def moves(earlier: Mapping[str, Result], results: Sequence[Result]) -> list[Move]:
    """Return whose mark is another than in the run before, and why; first those on the roster, in its order."""
    moved: list[Move] = []
    now = {result.student: result for result in results}
    for student, result in now.items():
        if student in earlier:
            moved += _moves_of(student, earlier[student], result)
        else:
            moved.append(Move(student, "", "–", _shown(result.score), "new on the roster"))
    for student, was in earlier.items():
        if student not in now:
            moved.append(Move(student, "", _shown(was.score), "–", reasons(was, None)))
    return moved


def _moves_of(student: str, was: Result, now: Result) -> list[Move]:
    set_before, set_now = was.overrides, now.overrides
    of_grading = ", ".join(_reasons_of_grading(was, now)) or "graded again"
    moved = []
    for part in dict.fromkeys((*now.parts, *was.parts)):
        old, new = (_shown(parts[part].points) if part in parts else "–" for parts in (was.parts, now.parts))
        if old != new:
            by_hand = set_before.get(part) != set_now.get(part)
            moved.append(Move(student, part, old, new, _which_override(part, was, now) if by_hand else of_grading))
    if moved or was.score != now.score:
        moved.append(Move(student, "", _shown(was.score), _shown(now.score), reasons(was, now)))
    return moved


def _which_override(part: str, was: Result, now: Result) -> str:
    """Return the override that came or went, in words; whoever answers otherwise leaves a group."""
    before, after = was.overrides.get(part), now.overrides.get(part)
    override = after or before
    if override is None or override.group is None:
        return "override"
    if after is None and now.parts[part].group != override.group:
        return ", ".join([*_reasons_of_grading(was, now), f"no longer in {override.group}"])
    return f"override of {override.group}"


def new_comments(earlier: Mapping[str, Result], results: Sequence[Result]) -> list[str]:
    """Return, a line for each group, how many students are told a comment that they were not, where no mark moves."""
    count = Counter[str]()
    for result in results:
        before = earlier[result.student].overrides if result.student in earlier else {}
        for part, override in result.overrides.items():
            if override.group is not None and override.points is None and override != before.get(part):
                count[override.group] += 1
    return [
        f"{group}: {number} {'student is' if number == 1 else 'students are'} told the comment of overrides.csv"
        for group, number in count.items()
    ]


def _shown(points: float | None) -> str:
    return "ungraded" if points is None else number(points)


def describe_moves(earlier: Mapping[str, Result], results: Sequence[Result]) -> str:
    """Return the comparison of a run with the one before as `qdot grade --diff` prints it."""
    if not earlier:
        return "nothing to compare with: this is the first run"
    moved, comments = moves(earlier, results), new_comments(earlier, results)
    if not moved:
        return "\n".join([*comments, "no mark moved since the last run"])
    rows = [(move.student, move.part or "total", move.was, move.now, move.why) for move in moved]
    wide = [max(len(row[column]) for row in rows) for column in range(4)]
    lines = [
        f"{student:<{wide[0]}}  {part:<{wide[1]}}  {was:>{wide[2]}} → {now:<{wide[3]}}  {why}"
        for student, part, was, now, why in rows
    ]
    before, after = (total(result.score for result in run) for run in (earlier.values(), results))
    students = len({move.student for move in moved})
    change = total((after, -before))
    marks = "1 student's mark" if students == 1 else f"{students} students' marks"
    sign = "+" if change >= 0 else "−"
    summary = f"{marks} moved since the last run; all points together {number(before)} → {number(after)}"
    return "\n".join([*lines, *comments, f"{summary} ({sign}{number(abs(change))})"])
