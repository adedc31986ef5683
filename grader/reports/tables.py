"""results.jsonl, a line a student, and grades.csv, a table for people."""

import csv
import io
import json
from collections.abc import Sequence
from typing import Any

from exercises.assignment import Student


def results_jsonl(results: Sequence[dict[str, Any]]) -> str:
    """Return a JSON object a line, one for each student."""
    return "".join(json.dumps(result, ensure_ascii=False, allow_nan=False) + "\n" for result in results)


def grades_csv(results: Sequence[dict[str, Any]], roster: Sequence[Student]) -> str:
    """Return the table: student, name, email, a column a part, score, points to be had, percent, status, note."""
    by_id = {student.id: student for student in roster}
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    parts = [f"{problem['slot']}.{part['name']}" for problem in results[0]["problems"] for part in problem["parts"]]
    others = [name for name, _ in roster[0].others]
    writer.writerow(["student", "name", "email", *others, *parts, "score", "max_score", "percent", "status", "note"])
    for result in results:
        student = by_id[result["student"]]
        points = [part["points"] for problem in result["problems"] for part in problem["parts"]]
        percent = 100 * result["score"] / result["max_score"]
        cells = [student.id, student.name, student.email, *(value for _, value in student.others)]
        numbers = ["" if value is None else f"{value:g}" for value in points]
        total = [f"{result['score']:g}", f"{result['max_score']:g}", f"{percent:.1f}", status(result)]
        note = "; ".join(staff_notes(result))
        writer.writerow([*map(_no_formula, cells), *numbers, *total, _no_formula(note)])
    return out.getvalue()


def status(result: dict[str, Any]) -> str:
    """Return the state of a student's work in a word.

    "missing": nothing handed in; "unusable": no notebook of this assignment; "ungraded": qdot failed; "late"; "graded".
    """
    outcomes = {part["outcome"] for problem in result["problems"] for part in problem["parts"]}
    if "ungraded" in outcomes:
        return "ungraded"
    if result["submission"] is None:
        return "missing"
    if result["obstacle"] is not None:
        return "unusable"
    return "late" if result["late"] else "graded"


def staff_notes(result: dict[str, Any]) -> list[str]:
    """Return what the staff should know of a submission: why it is unusable, whose notebook it is, …"""
    unusable = [result["obstacle"]] if status(result) == "unusable" else []
    return [*unusable, *result["staff_notes"]]


def _no_formula(text: str) -> str:
    """Keep a spreadsheet from taking a name for a formula."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t", "\r") else text
