"""Certify problems: run the checks, and make sure that the reference answers earn full marks.

The certificates of a class are stored as certificates/STUDENT/KEY.json. `qdot verify DIR` reads these certificates to
check that the problems of an assignment are still those that were released. A problem without a valid certificate
fails. A slot is the place of a problem in the assignment, such as "p1".
"""

import unicodedata
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.assignment.certified_problems import raise_failures
from qdot.exercises.assignment.release import Certifier, make_certificate_path, make_notebook_path
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import find_qdot_version
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.common.parallel import map_in_order, return_state
from qdot.exercises.families import Family
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ENGINE, Problem, ProblemId
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.questions.custom import Definition
from qdot.exercises.reference_answers import Words
from qdot.exercises.singularities.difficulty import rate_difficulty
from qdot.exercises.verify.certificate import ProblemCertificate, certify
from qdot.exercises.writing.custom_texts import find_unstated_values
from qdot.exercises.writing.wording import Wording
from qdot.grader.grading import certificates
from qdot.grader.grading.certificates import Failure, FailureKind, ProblemRecord, StudentCertificate
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome


@dataclass(frozen=True)
class VerificationTask:
    """A problem to verify.

    `family` is set if the arm is an instructor's robot. `definitions` define the instructor's own questions that the
    problem asks. `record` is the problem's record in the certificate. `file_failures` lists the failures found in the
    student's certificate and notebook. `is_in_assignment` is False if the problem is no longer in the assignment, so
    that qdot can't generate the problem.
    """

    identity: ProblemId
    family: Family | None = None
    definitions: tuple[Definition, ...] = ()
    record: ProblemRecord | None = None
    student: str = ""
    file_failures: tuple[Failure, ...] = ()
    is_in_assignment: bool = True

    @property
    def name(self) -> str:
        """A description of the problem for messages: the student, the id and the questions."""
        questions = ", ".join(self.identity.questions) or "all questions"
        return f"{self.student + ': ' if self.student else ''}{self.identity} ({questions})"

    def make_failure(self, kind: FailureKind, message: str) -> Failure:
        """Return a failure whose message begins with the description of this problem."""
        return Failure(kind, f"{self.name}: {message}")


TaskAndFailures = tuple[VerificationTask, list[Failure]]
"""A problem to verify, and its failures; the list is empty if the problem passes."""


def find_failures(problem: Problem, certificate: ProblemCertificate | None = None) -> list[str]:
    """Return a message for each failed check of a problem and for each reference answer that doesn't earn full marks.

    `certificate` contains the results of the checks; the checks are run if it is None.
    """
    result = certificate or certify(problem)
    failures = [f"{check.name}: {check.detail}" for check in result.failures]
    for part in problem.parts:
        if isinstance(part.answer, Words):  # a person marks it
            continue
        judgement = judge(problem, part, part.answer.as_typed(), f"certify/{problem.id}/{part.name}")
        if judgement.outcome is not Outcome.CORRECT:
            failures.append(f"{part.name}: the reference answer is judged {judgement.outcome}: {judgement.reason}")
        if (message := find_unstated_values(part, Wording(problem.chain))) is not None:
            failures.append(f"{part.name}: {message}")
    return failures


def make_record(problem: Problem) -> ProblemRecord:
    """Return the record of a problem for the certificate. Raises UncertifiedProblem if the problem fails a check."""
    certificate = certify(problem)
    raise_failures(problem, find_failures(problem, certificate))
    checks = (*(check.name for check in certificate.checks), "full marks for the reference")
    return ProblemRecord(
        problem=str(problem.id), questions=tuple(part.name for part in problem.parts), band=problem.id.band,
        engine=problem.id.engine, qdot=find_qdot_version(), difficulty=rate_difficulty(problem.chain), checks=checks,
        **to_jsonable(certificate.digests),
    )  # fmt: skip


def make_certificate_text(
    assignment: Assignment, student: str, records: Mapping[str, ProblemRecord], notebook: Mapping[str, Any]
) -> str:
    """Return the content of a student's certificate file: the record of each slot, and digests of the notebook."""
    certificate = StudentCertificate(
        assignment=assignment.key, student=student, notebook_digest=assignment.notebook_digest_of(student),
        notebook=dict(certificates.compute_cell_digests(notebook)), problems=dict(records),
    )  # fmt: skip
    return certificate.model_dump_json(indent=1) + "\n"


CERTIFIER = Certifier(make_record, make_certificate_text)
"""The functions that certify the problems of a class: one for a problem, one for a student's file."""


# --- verify a class's problems, perhaps years later ---


def list_tasks(assignment: Assignment) -> list[VerificationTask]:
    """Return a task for every problem of a class, with its record and the failures found in the student's files.

    Students who are no longer on the roster are included, because their problems were also released.
    """
    students = [*(student.id for student in assignment.roster), *find_former_students(assignment)]
    return [task for student in students for task in _list_tasks_of_student(assignment, student)]


def find_former_students(assignment: Assignment) -> list[str]:
    """Return the students who have a notebook or a certificate but are not on the roster."""
    patterns = [make_notebook_path(assignment, "*"), make_certificate_path(assignment, "*")]
    paths = [path for pattern in patterns for path in pattern.parent.parent.glob(f"*/{pattern.name}")]
    names = {unicodedata.normalize("NFC", path.parent.name) for path in paths}
    current_names = {student.id for student in assignment.roster}
    return sorted(name for name in names - current_names if not name.startswith("."))


def _list_tasks_of_student(assignment: Assignment, student: str) -> list[VerificationTask]:
    """Return a task for each problem of a student: first the problems in current slots, then those in removed slots."""
    certificate, failures = _read_certificate(assignment, student)
    records = dict(certificate.problems) if certificate else {}

    def select_failures(slot: str) -> list[Failure]:
        return [failure for failure in failures if failure.slot in ("", slot)]

    tasks = []
    for slot in assignment.slots:
        record = records.pop(slot.name, None)
        slot_failures = select_failures(slot.name)
        if certificate and record is None:
            path = make_certificate_path(assignment, student)
            message = f"{student}: {path} has no {slot.name}; it was added to assignment.toml after the release"
            slot_failures.insert(0, Failure(FailureKind.UNCERTIFIED, message))
        identity = assignment.make_problem_id(slot, student)
        tasks.append(VerificationTask(identity, slot.family, slot.definitions, record, student, tuple(slot_failures)))
    for name, record in records.items():
        identity = replace(ProblemId.parse(record.problem), questions=record.questions)
        task = VerificationTask(identity, student=student, is_in_assignment=False)
        message = f"it was released as {name}, which is no longer in assignment.toml"
        failure = task.make_failure(FailureKind.CHANGED, message)
        tasks.append(replace(task, file_failures=(failure, *select_failures(name))))
    return tasks


def _read_certificate(assignment: Assignment, student: str) -> tuple[StudentCertificate | None, list[Failure]]:
    """Return a student's certificate (None if it can't be read), and the failures of certificate and notebook."""
    path = make_certificate_path(assignment, student)
    try:
        certificate = certificates.read_certificate(path, assignment.key, student)
    except QdotError as error:
        return None, [Failure(FailureKind.DAMAGED, f"{student}: {error}")]
    if certificate is None:
        advice = "Restore it from a backup, or run 'qdot generate' if nothing was released to this student"
        message = f"{student}: {path} is missing, so qdot does not know what was released. {advice}"
        return None, [Failure(FailureKind.UNCERTIFIED, message)]
    return certificate, certificates.find_notebook_failures(make_notebook_path(assignment, student), certificate)


def _find_changes(task: VerificationTask, problem: Problem, record: ProblemRecord) -> list[Failure]:
    """Return the failure of a problem that differs from its record; an empty list if they agree."""
    failure_kind = FailureKind.CHANGED
    digests = compute_digests(problem)
    if record.problem != str(problem.id):
        message = f"{record.problem} was released instead, because the assignment or the secret has changed"
    elif record.sha256 != digests.sha256:
        names = {**digests.parts, **record.parts}
        changed_parts = [name for name in names if record.parts.get(name) != digests.parts.get(name)]
        difference = ", ".join(changed_parts) or "its digest"
        if record.arm != digests.arm:
            difference = "the arm"
        message = f"this is no longer the released problem: {difference} changed since qdot {record.qdot}"
    elif (record.arm, record.parts, set(record.questions)) != (digests.arm, digests.parts, set(digests.parts)):
        failure_kind = FailureKind.DAMAGED
        message = "its certificate contradicts itself, because it was altered; restore it from a backup"
    else:
        return []
    return [task.make_failure(failure_kind, message)]


def _verify_task(_: None, task: VerificationTask) -> list[Failure]:
    """Return the failures of a problem, which is generated and checked again. The first parameter is not used."""
    record = task.record
    if not task.is_in_assignment:
        return list(task.file_failures)
    if record is not None and record.engine != ENGINE:
        message = (
            f"qdot {record.qdot} generated it with version {record.engine} of the generator, but this qdot has version "
            f"{ENGINE} and can't compare the problems; verify with qdot {record.qdot}"
        )
        return [task.make_failure(FailureKind.OTHER_ENGINE, message), *task.file_failures]
    try:
        problem = generate(task.identity, family=task.family, definitions=task.definitions)
        failures = _find_changes(task, problem, record) if record is not None else []
        failures += [task.make_failure(FailureKind.UNSOUND, message) for message in find_failures(problem)]
    except (RuntimeError, QdotError) as error:
        failures = [task.make_failure(FailureKind.UNSOUND, str(error))]
    except Exception as error:  # an error in one problem must not stop the verification of the others
        message = f"qdot failed: {type(error).__name__}: {error}; please report this error"
        failures = [task.make_failure(FailureKind.UNSOUND, message)]
    return [*failures, *task.file_failures]


def verify_all(tasks: Sequence[VerificationTask], jobs: int) -> Generator[TaskAndFailures, None, None]:
    """Verify problems on several processes; yield each in order with its failures, the most serious first."""
    with closing(map_in_order(_verify_task, tasks, jobs, setup=return_state, arguments=(None,))) as failures:
        yield from zip(tasks, failures, strict=True)
