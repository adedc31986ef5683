"""What earlier runs gave: kept in graded/history/STUDENT.jsonl when replaced, and compared with the run just made.

results.jsonl is the last run's word. It is written after everything else, so that a run that was stopped has replaced
nothing yet, and what an earlier run gave is in the history before it is gone from there.
"""

import datetime
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import remove_left_behind, write_atomically
from qdot.grader.grading.final_result import Result
from qdot.grader.grading.marking import number, total


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
    return dict(_earlier(assignment))


def _earlier(assignment: Assignment) -> Iterator[tuple[str, Result]]:
    """Yield the same one by one: those of a large class take as much memory again as the ones just made."""
    try:
        written = results_path(assignment).read_bytes()
    except OSError:
        return
    for line in io.BytesIO(written):
        try:
            result = json.loads(line)
            points = [result["score"], *(part["points"] or 0 for part in _parts(result).values())]
            if all(isinstance(each, (int, float)) for each in points) and {"submission", "late"} <= set(result):
                yield str(result["student"]), result
        except (ValueError, KeyError, TypeError):
            continue


def results_path(assignment: Assignment) -> Path:
    """Return where the results are."""
    return assignment.folder / "graded" / "results.jsonl"


def last_results(assignment: Assignment) -> tuple[Assignment, list[Result]]:
    """Return what the last run gave, in the roster's order, and the assignment with those students alone.

    Raises QdotError where nothing has been graded, or the results are of other problems or another version.
    """
    path = results_path(assignment)
    earlier = earlier_results(assignment)
    again = f"run: qdot grade {assignment.folder}"
    if not path.exists():
        raise QdotError(f"{path}: there is no such file; nothing has been graded, {again}")
    roster = tuple(student for student in assignment.roster if student.id in earlier)
    results = [earlier[student.id] for student in roster]
    if not results:
        raise QdotError(f"{path}: no student of the roster is in it; {again}")
    names = [f"{slot.name}.{name}" for slot in assignment.slots for name in slot.questions]
    points = [most for slot in assignment.slots for most in slot.max_points]
    for result in results:
        parts = _parts(result)
        if not set(_KEYS) <= set(result) or not all(set(_PART_KEYS) <= set(part) for part in parts.values()):
            raise QdotError(f"{path}: the result of {result['student']} is of another version of qdot; {again}")
        if list(parts) != names or [part["max_points"] for part in parts.values()] != points:
            raise QdotError(f"{path}: assignment.toml was changed after grading; {again}")
    return replace(assignment, roster=roster), results


_KEYS = ("score", "max_score", "submission", "obstacle", "late", "override", "staff_notes", "problems")
_PART_KEYS = ("outcome", "points", "max_points", "override", "mistake", "followed_from", "group", "answer")


def keep_earlier(assignment: Assignment, results: Sequence[Result]) -> None:
    """Add to the history what is about to be replaced by other results, or goes with a student who left the roster.

    A run that was stopped may have done so before: nothing is added twice. What is the same is not added at all.
    """
    by_student = {result["student"]: result for result in results}
    folder = assignment.folder / "graded" / "history"
    remove_left_behind(folder / f"{student}.jsonl" for student, _ in _earlier(assignment))
    for student, was in _earlier(assignment):
        now = _as_written(by_student[student]) if student in by_student else None
        if now is None or _content(was) != _content(now):
            _add(folder / f"{student}.jsonl", was, reasons(was, now))


def _add(path: Path, was: Result, why: str) -> None:
    try:
        lines = [line for line in path.read_text(encoding="utf-8").split("\n") if line]
    except (OSError, ValueError):
        lines = []
    if lines and _result_in(lines[-1]) == was:
        lines.pop()  # a run that was stopped put it there, and may have had another reason
    replaced = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    lines.append(json.dumps({"replaced": replaced, "why": why, "result": was}, ensure_ascii=False))
    write_atomically(path, "".join(f"{line}\n" for line in lines), 0o600)


def _result_in(line: str) -> Any:
    try:
        return json.loads(line)["result"]
    except (ValueError, KeyError, TypeError):
        return None


def _as_written(result: Result) -> Result:
    """Return a result as it will be read from its file."""
    written: Result = json.loads(json.dumps(result))
    return written


def _content(result: Result) -> Result:
    """Return what of a result a student or the staff may notice; when it came is told where it is late."""
    attempts = [{**one, "received": None} for one in result.get("attempts", [])]
    submission = result["submission"] and {**result["submission"], "received": None}
    others = {name: value for name, value in result.items() if name != "made_from"}
    return {**others, "attempts": attempts, "submission": submission}


# --- why ---


def reasons(was: Result, now: Result | None) -> str:
    """Return in words why a result is another than it was."""
    if now is None:
        return "no longer on the roster"
    why = _of_grading(was, now)
    if _overrides(was) != _overrides(now):
        why.append("override")
    if _received(was) == _received(now):
        if _lateness(was) != _lateness(now):
            why.append("late rule")
    elif was["late"] != now["late"] and not why:
        why.append("received at another time")
    return ", ".join(why) or "graded again"


def _of_grading(was: Result, now: Result) -> list[str]:
    """Return why the grader may have given something else."""
    why = []
    old, new = was["submission"] or {}, now["submission"] or {}
    if (old.get("file"), old.get("sha256")) != (new.get("file"), new.get("sha256")):
        known = [(one["file"], one["received"]) for one in was.get("attempts", [])]
        another = (new.get("file"), new.get("received")) in known
        why.append("submission gone" if not new else "another attempt counts" if another else "new submission")
    made, anew = was.get("made_from", {}), now.get("made_from", {})
    if made and made.get("assignment") != anew.get("assignment"):  # an older qdot didn't say
        why.append("assignment changed")
    if [made.get(name) for name in ("engine", "grader")] != [anew.get(name) for name in ("engine", "grader")]:
        why.append("grader changed")
    return why


def _received(result: Result) -> str | None:
    return (result["submission"] or {}).get("received")


def _lateness(result: Result) -> tuple[Any, ...]:
    """Return what the late rule decides."""
    late = result["late"] or {}
    return late.get("due"), late.get("penalty")


def _overrides(result: Result) -> dict[str, Any]:
    parts = {name: part["override"] for name, part in _parts(result).items() if part.get("override")}
    return {**parts, "": result.get("override")}


def _parts(result: Result) -> dict[str, dict[str, Any]]:
    return {f"{problem['slot']}.{part['name']}": part for problem in result["problems"] for part in problem["parts"]}


# --- whose mark moved ---


def moves(earlier: Mapping[str, Result], results: Sequence[Result]) -> list[Move]:
    """Return whose mark is another than in the run before, and why; first those on the roster, in its order."""
    moved: list[Move] = []
    now = {result["student"]: result for result in results}
    for student, result in now.items():
        if student in earlier:
            moved += _moves_of(student, earlier[student], result)
        else:
            moved.append(Move(student, "", "–", _shown(result["score"]), "new on the roster"))
    for student, was in earlier.items():
        if student not in now:
            moved.append(Move(student, "", _shown(was["score"]), "–", reasons(was, None)))
    return moved


def _moves_of(student: str, was: Result, now: Result) -> list[Move]:
    before, after = _parts(was), _parts(now)
    set_before, set_now = _overrides(was), _overrides(now)
    of_grading = ", ".join(_of_grading(was, now)) or "graded again"
    moved = []
    for part in dict.fromkeys((*after, *before)):
        old, new = (_shown(parts[part]["points"]) if part in parts else "–" for parts in (before, after))
        if old != new:
            by_hand = set_before.get(part) != set_now.get(part)
            moved.append(Move(student, part, old, new, _which(part, was, now) if by_hand else of_grading))
    if moved or was["score"] != now["score"]:
        moved.append(Move(student, "", _shown(was["score"]), _shown(now["score"]), reasons(was, now)))
    return moved


def _which(part: str, was: Result, now: Result) -> str:
    """Return the override that came or went, in words; whoever answers otherwise leaves a group."""
    before, after = _overrides(was).get(part), _overrides(now).get(part)
    group = (after or before or {}).get("group")
    if after is None and group and _parts(now)[part]["group"] != group:
        return ", ".join([*_of_grading(was, now), f"no longer in {group}"])
    return f"override of {group}" if group else "override"


def told_anew(earlier: Mapping[str, Result], results: Sequence[Result]) -> list[str]:
    """Return, a line for each group, how many students are told a comment that they were not, where no mark moves."""
    count: dict[str, int] = {}
    for result in results:
        before = _overrides(earlier[result["student"]]) if result["student"] in earlier else {}
        for part, override in _overrides(result).items():
            if override and override["points"] is None and override != before.get(part):
                count[override["group"]] = count.get(override["group"], 0) + 1
    return [
        f"{group}: {number} {'student is' if number == 1 else 'students are'} told the comment of overrides.csv"
        for group, number in count.items()
    ]


def _shown(points: float | None) -> str:
    return "ungraded" if points is None else number(points)


def told(earlier: Mapping[str, Result], results: Sequence[Result]) -> str:
    """Return the comparison of a run with the one before as `qdot grade --diff` prints it."""
    if not earlier:
        return "nothing to compare with: this is the first run"
    moved, comments = moves(earlier, results), told_anew(earlier, results)
    if not moved:
        return "\n".join([*comments, "no mark moved since the last run"])
    rows = [(move.student, move.part or "total", move.was, move.now, move.why) for move in moved]
    wide = [max(len(row[column]) for row in rows) for column in range(4)]
    lines = [
        f"{student:<{wide[0]}}  {part:<{wide[1]}}  {was:>{wide[2]}} → {now:<{wide[3]}}  {why}"
        for student, part, was, now, why in rows
    ]
    before, after = (total(one["score"] for one in those) for those in (earlier.values(), results))
    students = len({move.student for move in moved})
    change = total((after, -before))
    marks = "1 student's mark" if students == 1 else f"{students} students' marks"
    sign = "+" if change >= 0 else "−"
    said = f"{marks} moved since the last run; all points together {number(before)} → {number(after)}"
    return "\n".join([*lines, *comments, f"{said} ({sign}{number(abs(change))})"])
