"""A student's result as Classroom 50's result.json (schema classroom50/result/v1), in whole numbers.

Where points are no whole numbers, everything is counted in hundredths. The tests' scores add up to the score, also
where lateness or a person changed it; the exact points of a part stand beside them.
"""

import datetime
import json
import os
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError
from qdot.grader.grading.result import Result
from qdot.grader.reports.rows import lateness, rows_of, the_only

NEVER = "1970-01-01T00:00:00Z"
"""The time of what was not handed in."""
NEEDED = ("CLASSROOM", "OWNER", "SUBMISSION_TAG", "COMMIT_URL", "RELEASE_URL")
"""Variables without which no result would be known for whose it is; OWNER may be called USERNAME."""
TAG = "submit/"
"""How the tags of submissions begin."""


def result_json(assignment: Assignment, results: Sequence[Result]) -> str:
    """Return result.json; what belongs to the submission's repository comes from the runner's environment."""
    return of_environment(assignment, the_only(results, "classroom50"), os.environ)


def of_environment(assignment: Assignment, result: Result, environment: Mapping[str, str]) -> str:
    """Return result.json for a runner's environment. Raises QdotError where that does not tell whose it is."""
    environment = {**environment, "OWNER": environment.get("OWNER") or environment.get("USERNAME", "")}
    lacking = [name for name in NEEDED if not environment.get(name)]
    if lacking:
        raise QdotError(
            f"--report classroom50 takes from the environment whose result it is, and {', '.join(lacking)} "
            f"{'is' if len(lacking) == 1 else 'are'} not set there; Classroom 50's runner sets them (docs/ci.md)"
        )
    if not environment["SUBMISSION_TAG"].startswith(TAG):
        said = environment["SUBMISSION_TAG"]
        raise QdotError(f"SUBMISSION_TAG is {said!r}; Classroom 50 collects what is tagged {TAG}…, and nothing else")
    rows = rows_of(result, assignment.feedback)
    exact = [Fraction(str(row.max_points)) for row in rows]
    unit = 1 if all(Fraction(str(row.points)).denominator == 1 for row in rows) and _whole(exact) else 100
    limits = [round(points * unit) for points in exact]
    score = min(round(Fraction(str(result.score)) * unit), sum(limits))
    scores = shared_out(score, [Fraction(str(row.points)) for row in rows], limits)
    tests = [
        {
            "test-name": f"{row.part}: {row.title}", "passed": row.passed, "score": own, "max-score": limit,
            "points": row.points, "max-points": row.max_points, "outcome": row.outcome, "message": row.said,
        }
        for row, own, limit in zip(rows, scores, limits, strict=True)
    ]  # fmt: skip
    commit = environment["COMMIT_URL"]
    content: dict[str, Any] = {
        "schema": "classroom50/result/v1",
        "classroom": environment["CLASSROOM"],
        "assignment": environment.get("ASSIGNMENT") or assignment.key,
        "assignment_type": environment.get("ASSIGNMENT_TYPE", "individual"),
        "owner": environment["OWNER"],
        "usernames": [environment["OWNER"]],  # what its collector went by before it knew groups
        "submission": environment["SUBMISSION_TAG"],
        "commit": commit,
        "release": environment["RELEASE_URL"],
        "review": environment.get("REVIEW_URL") or commit,
        "datetime": _instant(result),
        "score": score,
        "max-score": sum(limits),
        "tests": tests,
        "notes": [said for said in (*result.notes, lateness(result)) if said],
    }
    return json.dumps(content, ensure_ascii=False, indent=1) + "\n"


def _whole(points: Sequence[Fraction]) -> bool:
    return all(each.denominator == 1 for each in points)


def _instant(result: Result) -> str:
    submission = result.submission
    if submission is None or submission.received is None:
        return NEVER
    moment = datetime.datetime.fromisoformat(submission.received).astimezone(datetime.UTC)
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")


def shared_out(whole: int, weights: Sequence[Fraction], limits: Sequence[int]) -> list[int]:
    """Return whole numbers in proportion to `weights`, none above its limit, that add up to `whole`.

    >>> shared_out(5, [Fraction(1), Fraction(2), Fraction(4)], [1, 2, 4])
    [1, 1, 3]
    """
    total = sum(weights) or 1
    exact = [Fraction(whole) * weight / total for weight in weights]
    shares = [min(int(share), limit) for share, limit in zip(exact, limits, strict=True)]
    order = sorted(range(len(shares)), key=lambda i: (shares[i] - exact[i], i))
    while (left := whole - sum(shares)) > 0:
        for i in [i for i in order if shares[i] < limits[i]][:left]:
            shares[i] += 1
    return shares
