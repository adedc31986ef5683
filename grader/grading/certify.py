"""The certificate of a problem from the grader's side, above both packages: the reference earns full marks.

The certificates of a class are kept as certificates/STUDENT/KEY.json; by them `qdot verify DIR` knows whether the
problems of a folder are still those that were handed out. Where nothing vouches for a problem, it has failed.
"""

import unicodedata
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from qdot.exercises.arm.difficulty import difficulty
from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.draws import check
from qdot.exercises.assignment.release import Certifier, certificate_path, notebook_path
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import qdot_version
from qdot.exercises.common.json_form import as_json
from qdot.exercises.common.parallel import ordered_map
from qdot.exercises.families import Family
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ENGINE, Problem, ProblemId
from qdot.exercises.problem.record import digests
from qdot.exercises.verify import ProblemCertificate, certify
from qdot.grader.grading.certificates import (
    Certificate,
    Failure,
    Kind,
    Record,
    cell_digests,
    missing,
    notebook_failures,
    read_certificate,
)
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome


@dataclass(frozen=True)
class Task:
    """A problem to verify: its identity, its family where that is an instructor's robot, and the record kept of it.

    `against` is what the files of its student say against it; one that can't be `made` any more is only told of.
    """

    identity: ProblemId
    family: Family | None = None
    record: Record | None = None
    owner: str = ""
    against: tuple[Failure, ...] = ()
    made: bool = True

    @property
    def name(self) -> str:
        """The problem in words, with the student whose it is."""
        asked = ", ".join(self.identity.questions) or "all questions"
        return f"{self.owner + ': ' if self.owner else ''}{self.identity} ({asked})"


def failures_of(problem: Problem, certificate: ProblemCertificate | None = None) -> list[str]:
    """Return what is wrong with a problem: failed checks, and references that do not get full marks."""
    checked = certificate or certify(problem)
    failed = [f"{check.name}: {check.detail}" for check in checked.failures]
    for part in problem.parts:
        judgement = judge(problem, part, part.answer.as_typed(), f"certify/{problem.id}/{part.name}")
        if judgement.outcome is not Outcome.CORRECT:
            failed.append(f"{part.name}: the reference itself is judged {judgement.outcome}: {judgement.reason}")
    return failed


def record_of(problem: Problem) -> Record:
    """Return the record that is kept of a problem. Raises Uncertified where it does not pass."""
    certificate = certify(problem)
    check(problem, failures_of(problem, certificate))
    return Record(
        problem=str(problem.id),
        questions=tuple(part.name for part in problem.parts),
        band=problem.id.band,
        engine=problem.id.engine,
        qdot=qdot_version(),
        difficulty=difficulty(problem.chain),
        **as_json(certificate.digests),
        checks=(*(check.name for check in certificate.checks), "full marks for the reference"),
    )


def certificate_text(
    assignment: Assignment, student: str, records: Mapping[str, Record], notebook: Mapping[str, Any]
) -> str:
    """Return the text of a student's certificate file."""
    return Certificate(
        assignment=assignment.key,
        student=student,
        edition=assignment.edition_of(student),
        notebook=dict(cell_digests(notebook)),
        problems=dict(records),
    ).text


CERTIFIER = Certifier(record_of, certificate_text)
"""What certifies the problems of a class."""


# --- a folder, years later ---


def tasks_of(assignment: Assignment) -> list[Task]:
    """Return every problem of a class with its record, and what the files of its student say against it.

    Those who have left the roster since are of the class: their problems were handed out, too.
    """
    students = [student.id for student in assignment.roster]
    students += former_students(assignment)
    return [task for student in students for task in tasks_of_student(assignment, student)]


def former_students(assignment: Assignment) -> list[str]:
    """Return who has a notebook or a certificate and is not on the roster."""
    paths = [path for make in (notebook_path, certificate_path) for path in _of_anybody(make(assignment, "*"))]
    names = {unicodedata.normalize("NFC", path.parent.name) for path in paths}
    return sorted(names - {student.id for student in assignment.roster})


def unknown_files(assignment: Assignment) -> list[Path]:
    """Return the files among notebooks and certificates that are neither; they are not looked at."""
    unknown: set[Path] = set()
    for pattern in (notebook_path(assignment, "*"), certificate_path(assignment, "*")):
        root = pattern.parent.parent
        files = {path for path in root.rglob("*") if path.is_file()} - set(_of_anybody(pattern))
        unknown |= {path for path in files if not any(name.startswith(".") for name in path.relative_to(root).parts)}
    return sorted(unknown)


def _of_anybody(pattern: Path) -> list[Path]:
    return [path for path in pattern.parent.parent.glob(f"*/{pattern.name}") if not path.parent.name.startswith(".")]


def tasks_of_student(assignment: Assignment, student: str) -> list[Task]:
    """Return a student's problems, those of the assignment's places first, then those in places that it has no more."""
    certificate, failures = _kept(assignment, student)
    records = dict(certificate.problems) if certificate else {}
    tasks = []
    for slot in assignment.slots:
        record, against = records.pop(slot.name, None), _concerning(slot.name, failures)
        identity = assignment.identity(slot, student)
        if certificate and record is None:
            path = certificate_path(assignment, student)
            said = f"{student}: {path} has no {slot.name}, which came into assignment.toml after handing out"
            against = (Failure(Kind.UNCERTIFIED, said), *against)
        tasks.append(Task(identity, slot.family, record, student, against))
    return tasks + [_dropped(student, name, record, _concerning(name, failures)) for name, record in records.items()]


def _concerning(slot: str, found: Sequence[Failure]) -> tuple[Failure, ...]:
    return tuple(failure for failure in found if failure.slot in ("", slot))


def _dropped(student: str, slot: str, record: Record, against: tuple[Failure, ...]) -> Task:
    """Return the task of a problem that was handed out in a slot which the assignment has no more."""
    identity = replace(ProblemId.parse(record.problem), questions=record.questions)
    task = Task(identity, owner=student, made=False)
    said = f"{task.name}: it was handed out as {slot}, and is not in assignment.toml any more"
    return replace(task, against=(Failure(Kind.CHANGED, said), *against))


def _kept(assignment: Assignment, student: str) -> tuple[Certificate | None, list[Failure]]:
    """Return a student's certificate, None where none can be read, and what is wrong with it or the notebook."""
    path, notebook = certificate_path(assignment, student), notebook_path(assignment, student)
    try:
        certificate = read_certificate(path, assignment.key, student)
    except QdotError as error:
        return None, [Failure(Kind.DAMAGED, f"{student}: {error}")]
    if certificate is None:
        return None, [Failure(Kind.UNCERTIFIED, f"{student}: {missing(path, notebook)}")]
    return certificate, notebook_failures(notebook, certificate)


def changes_of(task: Task, problem: Problem, record: Record) -> list[Failure]:
    """Return how a problem differs from the record that was kept of it."""
    now = digests(problem)
    if record.problem != str(problem.id):
        said = f"another problem than was handed out, {record.problem}: the assignment or secret was changed"
    elif record.sha256 != now.sha256:
        changed = [name for name, digest in now.parts.items() if record.parts.get(name) != digest]
        changed += [name for name in record.parts if name not in now.parts]
        what = "the arm" if record.arm != now.arm else ", ".join(changed) or "its digest"
        said = f"no longer the problem that was handed out: {what} changed since qdot {record.qdot}"
    elif (record.arm, record.parts, set(record.questions)) != (now.arm, now.parts, set(now.parts)):
        said = "its certificate contradicts itself: it was altered; restore it from a backup"
        return _found(Kind.DAMAGED, task, [said])
    else:
        return []
    return _found(Kind.CHANGED, task, [said])


def _failures(_: None, task: Task) -> list[Failure]:
    record = task.record
    if not task.made:
        return list(task.against)
    if record is not None and record.engine != ENGINE:
        said = (
            f"made by engine {record.engine} of qdot {record.qdot}; this version has engine {ENGINE} and can't say "
            "whether it is the same problem; verify with that version"
        )
        return [*_found(Kind.OTHER_ENGINE, task, [said]), *task.against]
    try:
        problem = generate(task.identity, family=task.family)
        changes = changes_of(task, problem, record) if record is not None else []
        failures = [*changes, *_found(Kind.UNSOUND, task, failures_of(problem))]
    except (RuntimeError, QdotError) as error:
        failures = _found(Kind.UNSOUND, task, [str(error)])
    except Exception as error:  # whatever it is, it is one problem's, and the others are verified
        said = f"qdot itself failed: {type(error).__name__}: {error}; please report it"
        failures = _found(Kind.UNSOUND, task, [said])
    return [*failures, *task.against]


def _found(kind: Kind, task: Task, said: Sequence[str]) -> list[Failure]:
    return [Failure(kind, f"{task.name}: {line}") for line in said]


def certify_all(tasks: Sequence[Task], jobs: int) -> Generator[tuple[Task, list[Failure]], None, None]:
    """Yield every problem with what is wrong with it, the gravest first, in order."""
    with closing(ordered_map(_failures, tasks, jobs, _nothing, ())) as failures:
        yield from zip(tasks, failures, strict=True)


def _nothing() -> None:
    """Prepare nothing."""
