"""The certificate of a problem from the grader's side, above both packages: the reference earns full marks.

The certificates of a class are kept as certificates/STUDENT/KEY.json, one record for each problem: its identity, the
engine and version that made it, digests of arm and parts, difficulty, and the names of the checks it passed. Figures
such as rounding errors differ between machines and are not kept; `qdot verify` finds them again.
"""

import json
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from exercises import ENGINE
from exercises.assignment import Assignment
from exercises.difficulty import difficulty
from exercises.errors import QdotError
from exercises.families import Family
from exercises.generate import generate
from exercises.parallel import ordered_map
from exercises.problem import Choice, ConditionSet, Expression, Part, Problem, ProblemId
from exercises.record import digests, text_of
from exercises.verify import ProblemCertificate, certify
from grader.marking import judge
from grader.verdict import Outcome

Record = Mapping[str, Any]


@dataclass(frozen=True)
class Task:
    """A problem to verify: its identity, its family where that is an instructor's robot, and the record kept of it."""

    identity: ProblemId
    family: Family | None = None
    record: Record | None = None
    owner: str = ""

    @property
    def name(self) -> str:
        """The problem in words, with the student whose it is."""
        asked = ", ".join(self.identity.questions) or "all questions"
        return f"{self.owner + ': ' if self.owner else ''}{self.identity} ({asked})"


def reference_text(part: Part) -> str:
    """Return the reference as a student would have to type it."""
    answer = part.answer
    if isinstance(answer, Choice):
        return answer.letter
    if isinstance(answer, ConditionSet):
        return "[" + ", ".join(piece for piece in answer.pieces()) + "]"
    if isinstance(answer, Expression):
        return text_of(answer.reference)
    rows = [", ".join(map(text_of, row)) for row in answer.reference.tolist()]
    return f"[{', '.join(f'[{row}]' for row in rows)}]"


def failures_of(problem: Problem, certificate: ProblemCertificate | None = None) -> list[str]:
    """Return what is wrong with a problem: failed checks, and references that do not get full marks."""
    checked = certificate or certify(problem)
    failed = [f"{check.name}: {check.detail}" for check in checked.failures]
    for part in problem.parts:
        judgement = judge(problem, part, reference_text(part), f"certify/{problem.id}/{part.name}")
        if judgement.outcome is not Outcome.CORRECT:
            failed.append(f"{part.name}: the reference itself is judged {judgement.outcome}: {judgement.reason}")
    return failed


def record_of(problem: Problem) -> Record:
    """Return the record that is kept of a problem. Raises QdotError where it does not pass."""
    certificate = certify(problem)
    failed = failures_of(problem, certificate)
    if failed:
        raise QdotError(
            f"the problem {problem.id} failed its own certificate and is not handed out: {failed[0]}; please report it"
        )
    band = None if problem.id.band is None else list(problem.id.band)
    return {
        "problem": str(problem.id),
        "questions": [part.name for part in problem.parts],
        "band": band,
        "engine": problem.id.engine,
        "qdot": version("qdot"),
        "difficulty": difficulty(problem.chain),
        **digests(problem),
        "checks": [*(check.name for check in certificate.checks), "full marks for the reference"],
    }


def certificate_text(assignment: Assignment, student: str, problems: Sequence[tuple[str, Problem]]) -> str:
    """Return the text of a student's certificate file. Raises QdotError where a problem does not pass."""
    records = {slot: record_of(problem) for slot, problem in problems}
    found = {"assignment": assignment.key, "student": student, "edition": assignment.edition, "problems": records}
    return json.dumps(found, indent=1, ensure_ascii=False) + "\n"


def kept_records(path: Path) -> Mapping[str, Record]:
    """Return the records of a certificate file by slot, none where there is no file. Raises QdotError."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))["problems"]
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise QdotError(f"{path} can't be read as a certificate ({error}); 'qdot generate' writes it anew") from None
    if not isinstance(found, dict) or not all(isinstance(record, dict) for record in found.values()):
        raise QdotError(f"{path} is no certificate; 'qdot generate' writes it anew")
    return found


def _changes(problem: Problem, record: Record) -> list[str]:
    """Return how a problem differs from the record that was kept of it."""
    now = digests(problem)
    if record.get("sha256") == now["sha256"]:
        return []
    parts = record.get("parts", {})
    changed = [name for name, digest in now["parts"].items() if parts.get(name) != digest]
    changed += [name for name in parts if name not in now["parts"]]
    if record.get("problem") != str(problem.id):
        return [f"another problem than was handed out, {record.get('problem')}: the assignment or secret was changed"]
    what = "the arm" if record.get("arm") != now["arm"] else ", ".join(changed) or "its digest"
    return [f"no longer the problem that was handed out: {what} changed since qdot {record.get('qdot')}"]


def _failures(_: None, task: Task) -> list[str]:
    record = task.record
    if record is not None and record.get("engine") != ENGINE:
        made = f"made by engine {record.get('engine')} of qdot {record.get('qdot')}"
        return [f"{made}; this version has engine {ENGINE} and can't say whether it is the same problem"]
    try:
        problem = generate(task.identity, None, task.family)
        return (_changes(problem, record) if record is not None else []) + failures_of(problem)
    except (RuntimeError, QdotError) as error:
        return [str(error)]


def certify_all(tasks: Sequence[Task], jobs: int) -> Generator[tuple[Task, list[str]], None, None]:
    """Yield every problem with its failures, in order."""
    with closing(ordered_map(_failures, tasks, jobs, _nothing, ())) as found:
        yield from zip(tasks, found, strict=True)


def _nothing() -> None:
    """Prepare nothing."""
