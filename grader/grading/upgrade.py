"""What this version of qdot would make of a folder that another one wrote: problems, notebooks, wording, marks.

Problems are held against the certificates that were kept when they were handed out. Nothing in the folder is changed.
"""

import contextlib
import shutil
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.assignment.draws import describe_own_failure
from qdot.exercises.assignment.release import certificate_path, handout, is_up_to_date, notebook_path
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import qdot_version
from qdot.exercises.common.parallel import ordered_map
from qdot.exercises.problem.problem import ENGINE, Problem
from qdot.grader.grading.attempt import GRADER, made_from
from qdot.grader.grading.batch import grade_class
from qdot.grader.grading.certificates import Failure, Kind, alterations, cell_digests, read_certificate
from qdot.grader.grading.certify import Task, changes_of, former_students, tasks_of_student
from qdot.grader.grading.history import Move, earlier_results, moves
from qdot.grader.grading.overrides import OVERRIDES
from qdot.grader.grading.result import Result
from qdot.grader.sandbox.own_folder import own_folder
from qdot.grader.sandbox.sandbox import Limits
from qdot.grader.submissions.submission import StudentFiles

UNKNOWN = (Kind.UNCERTIFIED, Kind.DAMAGED)
"""Why it can't be told whether a problem is the same."""
NAMED, TOLD = 5, 20
"""Cells or students that are named, and problems that are told of one by one, where many are concerned."""


@dataclass(frozen=True)
class OfStudent:
    """What would differ for a student: failures of problems, and what `qdot generate` would do.

    `made_by` are the versions of qdot and of its engine that are on record, `cells` those that would be worded anew.
    """

    student: str
    handed_out: bool = True
    problems: int = 0
    failures: tuple[Failure, ...] = ()
    made_by: frozenset[tuple[str, int]] = frozenset()
    is_kept: bool = True
    cells: tuple[str, ...] = ()


@dataclass(frozen=True)
class Comparison:
    """What would differ for a class: `every` student, and how many results are of another grader or assignment."""

    every: tuple[OfStudent, ...]
    graded: int
    graded_by: frozenset[int]
    again: int

    @property
    def handed_out(self) -> list[OfStudent]:
        """Those to whom something was handed out."""
        return [one for one in self.every if one.handed_out]

    @property
    def different(self) -> list[Failure]:
        """The problems that would be others."""
        return [one for each in self.every for one in each.failures if one.kind not in UNKNOWN]

    @property
    def unknown(self) -> list[Failure]:
        """The problems of which nothing says what they were."""
        return [one for each in self.every for one in each.failures if one.kind in UNKNOWN]

    @property
    def rewritten(self) -> list[str]:
        """The students whose notebooks `qdot generate` would write anew."""
        return [one.student for one in self.handed_out if not one.is_kept]

    @property
    def differs(self) -> bool:
        """Whether anything that students have would be another, or may be, as nothing tells."""
        return bool(self.different or self.unknown or self.rewritten)


def compare_class(assignment: Assignment, jobs: int, each: Callable[[], None]) -> Comparison:
    """Compare a class with what this version would make of it; `each` is told of every student."""
    roster = [student.id for student in assignment.roster]
    former = former_students(assignment)
    every = []
    work = [(student, student in roster) for student in (*roster, *former)]
    with closing(ordered_map(_of_student, work, jobs, _same, (assignment,))) as every_student:
        for of_student in every_student:
            every.append(of_student)
            each()
    results = [result for result in earlier_results(assignment).values() if result.student in roster]
    again = sum(result.made_from != made_from(assignment, result.student) for result in results)
    graded_by = frozenset(result.made_from.grader for result in results if result.made_from.grader)
    return Comparison(tuple(every), len(results), graded_by, again)


def _same(assignment: Assignment) -> Assignment:
    return assignment


def _of_student(assignment: Assignment, about: tuple[str, bool]) -> OfStudent:
    student, is_on_roster = about
    if not any(path(assignment, student).exists() for path in (certificate_path, notebook_path)):
        return OfStudent(student, handed_out=False)
    tasks = tasks_of_student(assignment, student)
    places = assignment.slots
    made = [_made(assignment, slot, task) for slot, task in zip(places, tasks[: len(places)], strict=True)]
    failures = [failure for _, failed in made for failure in failed]
    failures += [failure for task in tasks[len(places) :] for failure in task.against if failure.kind is Kind.CHANGED]
    problems = [(slot.name, problem) for slot, (problem, _) in zip(places, made, strict=True) if problem is not None]
    records = [task.record for task in tasks if task.record is not None]
    return OfStudent(
        student,
        problems=len(tasks),
        failures=tuple(failures),
        made_by=frozenset((record.qdot, record.engine) for record in records),
        is_kept=not is_on_roster or is_up_to_date(assignment, student),
        cells=_worded_anew(assignment, student, problems) if len(problems) == len(places) else (),
    )


def _made(assignment: Assignment, slot: Slot, task: Task) -> tuple[Problem | None, list[Failure]]:
    """Return a student's problem as this version makes it, and how it is another than was handed out."""
    nothing = [failure for failure in task.against if failure.kind in UNKNOWN]
    try:
        problem = slot.problem(assignment.secret, task.owner, assignment.draw_of(slot, task.owner))
    except Exception as error:  # it is one problem's: all others are compared
        said = str(error) if isinstance(error, (QdotError, RuntimeError)) else describe_own_failure(error)
        return None, nothing or [Failure(Kind.CHANGED, f"{task.name}: this version can't make it: {said}")]
    record = task.record
    if record is None or nothing:
        return problem, nothing
    if record.engine != ENGINE:
        said = f"made by engine {record.engine} of qdot {record.qdot}; engine {ENGINE} of this version draws another"
        return problem, [Failure(Kind.OTHER_ENGINE, f"{task.name}: {said}")]
    return problem, changes_of(task, problem, record)


def _worded_anew(assignment: Assignment, student: str, problems: Sequence[tuple[str, Problem]]) -> tuple[str, ...]:
    """Return the cells of a notebook that would read otherwise if it were made now; its metadata is not read."""
    with contextlib.suppress(QdotError):
        certificate = read_certificate(certificate_path(assignment, student), assignment.key, student)
        if certificate is not None:
            now = cell_digests(handout(assignment, student, problems))
            return tuple(cell for cell, _ in alterations(certificate.notebook, now) if cell != "metadata")
    return ()


# --- in words ---


def told(found: Comparison, folder: Path) -> Iterator[str]:
    """Yield the lines of the comparison, first what it is of, then a line for each thing that may differ."""
    made_by = sorted({version for one in found.handed_out for version in one.made_by})
    before = ", ".join(f"qdot {number} (engine {engine})" for number, engine in made_by) or "no version that is known"
    yield f"this is qdot {qdot_version()} (engine {ENGINE}, grader {GRADER}); {folder} was handed out by {before}"
    if not found.handed_out:
        yield "nothing was handed out yet: there is nothing that could be another"
        return
    said = list(dict.fromkeys(failure.said for failure in (*found.different, *found.unknown)))
    yield from said[:TOLD]
    if len(said) > TOLD:
        yield f"… and {len(said) - TOLD} more such lines"
    problems = sum(one.problems for one in found.handed_out)
    different, unknown = len(found.different), len(found.unknown)
    others = f", {different} {'is another' if different == 1 else 'are others'}" if different else ""
    untold = f", of {unknown} nothing tells what they were" if unknown else ""
    yield f"problems   {problems - different - unknown} of {problems} are the same as were handed out{others}{untold}"
    yield f"notebooks  {_of_notebooks(found)}"
    yield f"wording    {_of_wording(found)}"
    yield f"marks      {_of_marks(found)}"


def _of_notebooks(found: Comparison) -> str:
    rewritten, handed_out = found.rewritten, len(found.handed_out)
    if not rewritten:
        return f"'qdot generate' keeps all {handed_out} as they are"
    return (
        f"'qdot generate' would write {len(rewritten)} of {handed_out} anew ({_named(rewritten)}), as the engine is "
        "another, or the assignment was changed after handing out"
    )


def _of_wording(found: Comparison) -> str:
    cells = Counter(cell for one in found.handed_out for cell in one.cells)
    if not cells:
        return "a notebook that is made anew reads the same"
    students = sum(bool(one.cells) for one in found.handed_out)
    which = (
        "1 notebook would read otherwise if it"
        if students == 1
        else f"{students} notebooks would read otherwise if each"
    )
    return f"{which} were made anew ({_named(list(cells))}); what is handed out stays as it is"


def _of_marks(found: Comparison) -> str:
    if not found.graded:
        return "nothing has been graded"
    if not found.again:
        return f"{found.graded} results are of this very grader; 'qdot grade' grades none again"
    graders = ", ".join(map(str, sorted(found.graded_by - {GRADER})))
    of = f" of grader {graders}" if graders else ""
    be = "result is" if found.again == 1 else "results are"
    return (
        f"{found.again} of {found.graded} {be}{of or ' of another assignment.toml'}: 'qdot grade' grades them again; "
        "with --marks it is tried here whose mark would move"
    )


def _named(names: Sequence[str]) -> str:
    return ", ".join(names[:NAMED]) + (", …" if len(names) > NAMED else "")


# --- marks ---


def marks_moved(
    assignment: Assignment, found: dict[str, StudentFiles], jobs: int, limits: Limits, each: Callable[[Result], None]
) -> Generator[Move, None, None]:
    """Grade everything again in a temporary folder, and yield whose mark would be another than in results.jsonl.

    Raises QdotError.
    """
    with own_folder("qdot-upgrade-") as folder:
        if (assignment.folder / OVERRIDES).exists():
            shutil.copyfile(assignment.folder / OVERRIDES, folder / OVERRIDES)
        elsewhere = replace(assignment, folder=folder)
        results = grade_class(elsewhere, found, min(jobs, len(assignment.roster)), limits, each)
    yield from moves(earlier_results(assignment), results)
