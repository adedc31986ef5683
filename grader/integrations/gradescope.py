"""Grade as Gradescope's autograder: `python -m qdot.grader.integrations.gradescope [ROOT] [--visibility WHEN]`.

ROOT is /autograder by default. The program reads submission_metadata.json and submission/, and writes
results/results.json. If the submission can't be marked (the student is unknown, or qdot fails), the program writes no
results and exits with code 2. Gradescope then reports that the autograder failed, gives no points, and shows the reason
to the staff.
"""

import argparse
import datetime
import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.attempt_policy import AttemptPolicy
from qdot.exercises.common.console import note, print_result
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.grader.grading.batch import grade_one, make_limits
from qdot.grader.marking.marking import format_points
from qdot.grader.reports.gradescope import VISIBILITY, GradescopeResults, make_gradescope_results
from qdot.grader.reports.part_rows import get_only_result
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.layouts import SubmittedPath
from qdot.grader.submissions.roster import Roster
from qdot.grader.submissions.submission import find_student_files, read_submission


def make_results(root: Path, visibility: str = "visible", seconds: float = Limits.seconds) -> GradescopeResults:
    """Return the contents of results.json. Raises QdotError if the submission can't be marked."""
    assignment = load_assignment(root / "source" / "assignment")
    metadata = read_metadata(root / "submission_metadata.json")
    submission = root / "submission"
    student = find_submitter(assignment, metadata, submission)
    results = grade_submission(assignment, student, submission, metadata, visibility, seconds)
    if assignment.attempt_policy.best_of is None:
        return results
    return apply_attempt_policy(results, metadata, assignment.attempt_policy)


def grade_submission(
    assignment: Assignment, student: Student, submission: Path, metadata: Mapping[str, Any],
    visibility: str = "visible", seconds: float = Limits.seconds,
) -> GradescopeResults:  # fmt: skip
    """Return the results of one submission. Raises QdotError if the submission can't be marked.

    The deadline and the time of the submission are those in Gradescope's `metadata`.
    """
    deadline = find_due_date(metadata)
    student_with_deadline = student if deadline is None else replace(student, due_date=deadline)
    files = find_student_files(assignment, submission, parse_time(metadata.get("created_at")), "Gradescope")
    result = get_only_result([grade_one(assignment, student_with_deadline, files, make_limits(seconds))])
    return make_gradescope_results(result, assignment, visibility)


def read_metadata(path: Path) -> dict[str, Any]:
    """Return Gradescope's description of a submission. Raises QdotError if it can't be read or names no users."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise QdotError(f"{path} can't be read: {error}") from None
    if not isinstance(content, dict) or not isinstance(content.get("users"), list) or not content["users"]:
        raise QdotError(f"{path} does not name the users who submitted")
    return content


def find_submitter(assignment: Assignment, metadata: dict[str, Any], submission: Path) -> Student:
    """Return the student who submitted, found by identifiers and names. Raises QdotError if this is not certain.

    If a group submitted, the submitter is the member whom the notebook names.
    """
    roster = Roster(assignment.roster)
    owners = set[str]()
    for user in metadata["users"]:
        ids = tuple(str(user[key]) for key in ("sid", "email", "id") if user.get(key))
        owner = roster.find_owner(SubmittedPath(submission, ids, str(user.get("name") or ""), "Gradescope"))
        owners |= set(owner.students) if owner.is_certain else set()
    if len(owners) > 1:
        files = find_student_files(assignment, submission)
        if files is not None and not files.ungraded_reason:
            owners &= {str(read_submission(files.files[0], assignment.key).qdot_metadata.get("student"))}
    if len(owners) != 1:
        user_names = ", ".join(str(user.get("email") or user.get("name")) for user in metadata["users"])
        advice = "add the e-mail address to roster.csv, and export again"
        raise QdotError(f"{user_names}: qdot can't tell which student in roster.csv this is; {advice}")
    return assignment.find_student(owners.pop())


def find_due_date(metadata: Mapping[str, Any]) -> datetime.datetime | None:
    """Return Gradescope's deadline for this student, including extensions; None if there is none."""
    sources = [*(user.get("assignment") for user in metadata.get("users") or ()), metadata.get("assignment")]
    deadlines = [parse_time(source.get("due_date")) for source in sources if isinstance(source, dict)]
    return next(filter(None, deadlines), None)


def apply_attempt_policy(
    results: GradescopeResults, metadata: dict[str, Any], policy: AttemptPolicy
) -> GradescopeResults:
    """Return the results with an earlier submission's score if that is higher, or if this submission doesn't count."""
    earlier_submissions = [
        submission
        for submission in metadata.get("previous_submissions") or ()
        if isinstance(submission.get("score"), int | float | str) and not submission.get("autograder_error")
    ]
    # A submission without a time gets a placeholder, which is before all real times.
    epoch = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)
    default_times = [epoch + datetime.timedelta(days=i) for i in range(len(earlier_submissions))]
    pairs = zip(earlier_submissions, default_times, strict=True)
    times = [parse_time(submission.get("submission_time")) or default_time for submission, default_time in pairs]
    submission_time = parse_time(metadata.get("created_at")) or datetime.datetime.now(datetime.UTC)
    counting_indices = policy.select_counting_indices([*times, submission_time])
    is_counting = len(earlier_submissions) in counting_indices
    earlier_scores = [float(submission["score"]) for submission in earlier_submissions]
    best_score = max((earlier_scores[i] for i in counting_indices if i < len(earlier_scores)), default=0.0)
    if is_counting and best_score <= results.score:
        return results
    score = format_points(results.score)
    message = f"your best earlier submission counts, with {format_points(best_score)} points; this one earned {score}"
    message += "" if is_counting else f"; {policy.rule}"
    return replace(results, score=best_score, output="\n".join(filter(None, (message, results.output))))


def parse_time(text: object) -> datetime.datetime | None:
    """Return the time in a text from Gradescope; None if the text contains no time."""
    try:
        moment = datetime.datetime.fromisoformat(str(text))
    except ValueError:
        return None
    return moment if moment.tzinfo else moment.replace(tzinfo=datetime.UTC)


def main(arguments: list[str] | None = None) -> int:
    """Grade one submission; return 0 if there are results, otherwise 2."""
    parser = argparse.ArgumentParser(prog="python -m qdot.grader.integrations.gradescope", description=__doc__)
    parser.add_argument("root", type=Path, nargs="?", default=Path("/autograder"))
    parser.add_argument("--visibility", choices=VISIBILITY, default="visible")
    parser.add_argument("--seconds", type=float, default=Limits.seconds)
    options = parser.parse_args(arguments)
    target = options.root / "results" / "results.json"
    try:
        target.unlink(missing_ok=True)
        results = make_results(options.root, options.visibility, options.seconds)
        write_atomically(target, results.text)
    except QdotError as error:
        note(f"qdot: {error}")
        return 2
    print_result(f"{results.extra_data.student}: {format_points(results.score)} points")
    return 0


if __name__ == "__main__":
    sys.exit(main())
