"""The commands for a class beside `qdot grade`: generate, verify, compare, doctor, demo."""

import io
import json
import platform
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import typer

from qdot.exercises.assignment.draws import FailedSlot, describe_redraws, raise_failed_slots
from qdot.exercises.assignment.release import CORE_COUNT, ReleaseResult, notebook_path, release_notebooks
from qdot.exercises.common.completion import complete_names
from qdot.exercises.common.console import VariationOption, note, progress, say
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import qdot_version
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import look_up_family
from qdot.exercises.problem.problem import ProblemId
from qdot.grader.cli.options import (
    ConventionOption,
    JobsOption,
    JsonOption,
    TwistOrderOption,
    name_option,
)
from qdot.grader.grading.certificates import FailureKind
from qdot.grader.grading.certify import CERTIFIER, VerificationTask, find_former_students, list_tasks
from qdot.grader.grading.class_check import load_class
from qdot.grader.judging.compare import COMPARISON_TYPES, compare_lines, guess_type, judgement_content
from qdot.grader.judging.compare import compare as compare_texts
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import check_system
from qdot.grader.statistics.shared_answers import describe_shared_answers


def generate(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An assignment folder, as `qdot init` makes one.")],
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Write a class's notebooks, with solutions and certificates.

    A problem leaves only if it passes its certificate, which certificates/STUDENT/KEY.json keeps for `qdot verify`. One
    that does not is drawn anew for its student, which DIR/redrawn.csv tells; where no draw passes, the student is left
    out, all others have their notebooks, and the command leaves with code 2 and says which problems to change.
    Every student has released/STUDENT/KEY.ipynb, and the staff solutions/STUDENT/KEY.ipynb. Notebooks that are up
    to date are kept, so that a run that was stopped goes on where it was.

    Examples:
      qdot generate homework
          a notebook for everybody on the roster
      qdot generate homework --jobs 2
          on two processes, where memory is short
    """
    assignment = load_class(folder)
    for message in assignment.notes:
        note(message)
    counts = {"written": 0, "rewritten": 0, "completed": 0, "kept": 0, "left out": 0}
    failed_slots: list[FailedSlot] = []
    with progress("generating", len(assignment.roster)) as counter:

        def report_student(released: ReleaseResult) -> None:
            counts[released.outcome] += 1
            failed_slots.extend(released.failed_slots)
            for slot in released.failed_slots:
                note(str(slot))
            if released.failed_slots and (old := notebook_path(assignment, released.student)).exists():
                note(f"{old} is of an older assignment; do not hand it out")
            counter.step()

        released_assignment = release_notebooks(
            assignment, CERTIFIER, min(jobs, len(assignment.roster)), report_student
        )
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count)
    say(f"{len(assignment.roster)} students: {outcomes}; hand out {folder / 'released'}, keep {folder / 'solutions'}")
    if counts["rewritten"]:
        note("The assignment, the secret or qdot changed since notebooks were written: hand the new ones out.")
    for message in (*describe_redraws(assignment, released_assignment), *describe_shared_answers(released_assignment)):
        note(message)
    if former := find_former_students(released_assignment):
        name_list = ", ".join(former[:3]) + (f" and {len(former) - 3} more" if len(former) > 3 else "")
        released = folder / "released"
        note(f"{released} still has notebooks of who is not on the roster ({name_list}): hand these out to nobody")
    raise_failed_slots(released_assignment, failed_slots)


def verify(
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="PROBLEM… | DIR",
            help="Problems, or an assignment folder.",
            autocompletion=complete_names(FAMILIES, suffix="/1"),
        ),
    ] = [],  # noqa: B006
    family: Annotated[
        str, name_option("Sweep over problems of this family, or of `all` …", names=[*FAMILIES, "all"])
    ] = "",
    count: Annotated[int, typer.Option(min=1, help="… that many together, seeds 0, 1, 2, …")] = 100,
    first: Annotated[
        int, typer.Option("--first-seed", metavar="SEED", min=0, max=1 << 62, help="… or seeds from this one on.")
    ] = 0,
    variation: VariationOption = "",
    convention: ConventionOption = "",
    twist_order: TwistOrderOption = "",
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Certify problems: their references hold in numbers.

    The Jacobian by four routes agrees, singular sets are sound and complete, and the references get full marks from
    the grader. For an assignment folder, the problems are compared with the certificates that `qdot generate` kept: are
    they still the same? One without a certificate fails. Leaves with code 1 if a problem fails; each failure is printed
    with what was found.

    Examples:
      qdot verify planar-2r/7
          one problem
      qdot verify homework
          a class: are its problems and notebooks still what was handed out?
      qdot verify --family all --count 1000
          a sweep over all families
    """
    from qdot.grader.grading.certify import verify_all

    def make_task(identity: ProblemId) -> VerificationTask:
        return VerificationTask(identity.with_variation(variation).with_convention(convention, twist_order))

    tasks = _list_tasks(
        what, family, range(first, first + count), make_task, bool(variation or convention or twist_order)
    )
    started = time.monotonic()
    failed, passed = Counter[FailureKind](), dict.fromkeys((task.identity.family for task in tasks), 0)
    printed: set[str] = set()
    with progress("verifying", len(tasks)) as counter, closing(verify_all(tasks, jobs)) as certified:
        for task, failures in certified:
            counter.step()
            failed.update(failure.kind for failure in failures[:1])
            passed[task.identity.family] += not failures
            for failure in failures:
                if failure.message not in printed:  # a message that concerns all problems of a student is printed once
                    say(failure.message)
                printed.add(failure.message)
    if family == "all":
        for name, number in passed.items():
            say(f"{name:<20} {number} passed")
    seconds = time.monotonic() - started
    kinds = ", ".join(f"{number} {kind}" for kind, number in sorted(failed.items()))
    say(f"{len(tasks)} problems verified, {failed.total()} failed{': ' if kinds else ''}{kinds}")
    note(f"in {seconds:.1f} s, {60 * len(tasks) / max(seconds, 1e-9):.0f} a minute")
    if failed:
        raise typer.Exit(1)


NO_FOLDER_HINT = "; there is no folder of that name, either"
"""The end of the message about an argument that is neither a problem nor a folder."""


def _list_tasks(
    problems_or_folders: list[str],
    family: str,
    seeds: range,
    make_task: Callable[[ProblemId], VerificationTask],
    has_variation: bool,
) -> list[VerificationTask]:
    """Return a task for each problem to verify.

    The problems are those named by `problems_or_folders`, or those of the family with the seeds. Several families share
    the number of seeds evenly, each beginning at the first seed. Raises QdotError.
    """
    if not family and not problems_or_folders:
        raise QdotError("name problems (planar-2r/7), an assignment folder, or --family (or --family all) with --count")
    if family and problems_or_folders:
        raise QdotError(
            f"--family sweeps over a family, and {problems_or_folders[0]!r} is verified without it: "
            "give one or the other"
        )
    families = list(FAMILIES) if family == "all" else [look_up_family(family).name] if family else []
    numbers = range(len(seeds) if families else 0)
    tasks = [make_task(ProblemId(families[i % len(families)], seeds.start + i // len(families))) for i in numbers]
    tasks.sort(
        key=lambda task: families.index(task.identity.family)
    )  # then each process derives an arm's structure only once
    for item in problems_or_folders:
        if not Path(item).is_dir():
            tasks.append(make_task(ProblemId.parse(item, NO_FOLDER_HINT)))
        elif has_variation:
            raise QdotError(
                "--variation, --convention and --twist-order are for problems; "
                f"{item}/assignment.toml says how its arms vary and are told"
            )
        else:
            tasks += _list_tasks_of_folder(Path(item))
    return tasks


def _list_tasks_of_folder(folder: Path) -> list[VerificationTask]:
    """Return the tasks for the problems of an assignment, and print a note on each former student."""
    assignment = load_class(folder)
    for student in find_former_students(assignment):
        note(f"{student} is not on the roster, and has a notebook or certificate, which is verified all the same")
    return list_tasks(assignment)


def compare(
    student: Annotated[str, typer.Argument(metavar="STUDENT", help="The answer, as text.")] = "",
    reference: Annotated[str, typer.Argument(metavar="REFERENCE", help="What it is compared with.")] = "",
    type: Annotated[
        str,
        name_option(
            f"One of {', '.join(COMPARISON_TYPES)}; default: by the reference.", "--type", names=COMPARISON_TYPES
        ),
    ] = "",
    joints: Annotated[str, typer.Option(help="Joint variables of a singular set, with commas between.")] = "",
    batch: Annotated[
        str, typer.Option("--batch", metavar="FILE.jsonl", help="Many, one JSON object a line; - reads standard input.")
    ] = "",
) -> None:
    """Compare two answers as the grader does.

    It says how sure it is.

    Examples:
      qdot compare "a1*a2*s2" "a1*a2*sin(theta2)"
          an answer and what is right
      qdot compare --batch answers.jsonl
          many, a JSON object a line
    """
    if batch:
        refused: list[str] = []
        for answer in compare_lines(_read_lines(batch), refused):
            say(answer)
        if refused:
            others_clause = f", and {len(refused) - 1} more lines are no requests" if len(refused) > 1 else ""
            raise QdotError(f"{refused[0]}{others_clause}; all others were compared")
        return
    if not reference:
        raise QdotError("compare takes two texts, STUDENT and REFERENCE, or --batch FILE.jsonl")
    kind = type or guess_type(reference)
    texts: Any = [reference] if kind == "singular" else reference
    names = tuple(name.strip() for name in joints.split(",") if name.strip())
    say(json.dumps(judgement_content(compare_texts(kind, student, texts, names)), ensure_ascii=False))


def _read_lines(batch: str) -> Iterable[str]:
    """Yield the lines of a file, or of standard input for "-". Raises QdotError if the file can't be read."""
    if batch == "-":
        if isinstance(sys.stdin, io.TextIOWrapper):
            sys.stdin.reconfigure(errors="surrogateescape")
        yield from sys.stdin
        return
    try:
        with Path(batch).open(encoding="utf-8", errors="surrogateescape") as file:
            yield from file
    except OSError as error:
        raise QdotError(f"{batch} can't be read: {error}") from None


def doctor(as_json: JsonOption = False) -> None:
    """Show what this machine enforces while students' code runs.

    Each guarantee is tried: a probe runs where a notebook would and attempts to break out. With all of them enforced
    by the kernel, sandbox = "strict" in assignment.toml can be had here. The code is 0 whatever is found.

    Examples:
      qdot doctor
          what holds students' code on this machine
    """
    from importlib.metadata import version

    findings = guarantees.probe()
    versions = {"qdot": qdot_version(), **{name: version(name) for name in ("sympy", "numpy")}}
    environment = {"python": platform.python_version(), **versions, "system": platform.platform(), "cores": CORE_COUNT}
    if as_json:
        say(json.dumps({**environment, **findings.as_json()}, ensure_ascii=False, indent=2))
        return
    say(", ".join(f"{name} {value}" for name, value in environment.items()))
    say("")
    for guarantee in findings.guarantees:
        say(f"{guarantee.name:<11} {guarantee.by:<23} {', '.join(guarantee.means)}")
        say(f"{'':<11} a notebook {guarantee.promise}")
        for achieved in guarantee.achieved:
            say(f"{'':<11} the probe {achieved}")
    say("")
    for remedy in guarantees.list_remedies(findings):
        say(remedy)
    verb = "can" if findings.is_strict else "can't"
    say(f'sandbox = "strict" in assignment.toml {verb} be had on this machine')


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where to put it.")] = Path("qdot-demo"),
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Do the whole loop on a simulated class of 30.

    Makes the folder, generates, hands in what is right, wrong, blank or broken, and grades it.

    Examples:
      qdot demo
          a class of 30, from problems to feedback, in qdot-demo
    """
    from qdot.grader.cli.demo import run_demo

    check_system()
    run_demo(folder, jobs)
