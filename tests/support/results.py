"""Results made by hand or read from files, without running anything."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.json_form import parse_dataclass
from qdot.grader.grading.result import CountingSubmission, Override, PartResult, ProblemResult, Result
from qdot.grader.judging.verdict import Outcome
from qdot.grader.marking.marking import sum_points


def make_override(points: float | None, comment: str = "", group: str | None = None) -> Override:
    return Override(points, comment, None, group)


SHARES = {"correct": 1.0, "partial": 0.5, "wrong": 0.0, "missing": 0.0, "ungraded": None}


def make_part(name: str, outcome: str, max_points: float, answer: str | None = None, **others: Any) -> PartResult:
    share = SHARES[outcome]
    fields = {"points": None if share is None else share * max_points, "reason": "because", **others}
    return PartResult(name=name, outcome=Outcome(outcome), max_points=max_points, answer=answer, **fields)


def make_result(
    assignment: Assignment, student: str, outcomes: Sequence[str] = (), answers: Sequence[str | None] = (),
    **others: Any,
) -> Result:  # fmt: skip
    """Return a student's result with one outcome per part, in order. No outcomes mean that nothing was submitted."""
    outcome, answer = iter(outcomes or ["missing"] * 99), iter([*answers, *[None] * 99])
    problems = list[ProblemResult]()
    for slot in assignment.slots:
        names_and_points = zip(slot.questions, slot.max_points, strict=True)
        slot_parts = [make_part(name, next(outcome), points, next(answer)) for name, points in names_and_points]
        problems.append(ProblemResult(str(assignment.make_problem_id(slot, student)), slot.name, tuple(slot_parts)))
    parts = [part for problem in problems for part in problem.parts]
    result = Result(
        student=student,
        assignment=assignment.key,
        submission=CountingSubmission(f"{student}.ipynb", "0", None) if outcomes else None,
        score=sum_points(part.points for part in parts),
        max_score=sum_points(part.max_points for part in parts),
        late=None,
        obstacle=None if outcomes else "nothing was submitted",
        problems=tuple(problems),
    )
    return replace(result, **others)


def change_part(result: Result, part_name: str, **changes: Any) -> Result:
    """Return a result with changes to one part, such as "p1.jacobian"; its sums stay unchanged."""
    problems = list[ProblemResult]()
    for problem in result.problems:
        names = [f"{problem.slot}.{part.name}" for part in problem.parts]
        pairs = zip(names, problem.parts, strict=True)
        parts = (replace(part, **changes) if name == part_name else part for name, part in pairs)
        problems.append(replace(problem, parts=tuple(parts)))
    return replace(result, problems=tuple(problems))


def index_by_student(results: Iterable[Result]) -> dict[str, Result]:
    return {result.student: result for result in results}


def get_counted_file(result: Result) -> str:
    return "" if result.submission is None else result.submission.file


def get_received_time(result: Result) -> str | None:
    return None if result.submission is None else result.submission.received


def read_results(folder: Path) -> dict[str, Result]:
    lines = (folder / "graded" / "results.jsonl").read_bytes().splitlines()
    return index_by_student(parse_dataclass(Result, line) for line in lines)
