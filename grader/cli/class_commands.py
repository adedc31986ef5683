"""The commands for a class other than `qdot grade`: generate, verify, compare, doctor, demo."""

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

from qdot.exercises.assignment.certified_problems import FailedSlot, describe_replacements, raise_failed_slots
from qdot.exercises.assignment.release import CORE_COUNT, ReleaseResult, notebook_path, release_notebooks
from qdot.exercises.common.console import VariationOption, note, say, show_progress
from qdot.exercises.common.errors import QdotError, count_noun, list_some
from qdot.exercises.common.extras import find_qdot_version
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import look_up_family
from qdot.exercises.problem.problem import ProblemId
from qdot.grader.cli.options import (
    ConventionOption,
    JobsOption,
    JsonOption,
    TwistOrderOption,
    name_argument,
    name_option,
)
from qdot.grader.grading.certificates import FailureKind
from qdot.grader.grading.certify import CERTIFIER, VerificationTask, find_former_students, list_tasks
from qdot.grader.grading.class_check import load_class
from qdot.grader.judging.compare_command import COMPARISON_TYPES, compare_lines, guess_type, judgement_content
from qdot.grader.judging.compare_command import compare as compare_texts
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import check_system
from qdot.grader.statistics.shared_answers import describe_shared_answers


def generate(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An assignment folder made by `qdot init`.")],
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Write a class's notebooks, with solutions and certificates.

    Each student gets released/STUDENT/KEY.ipynb; the staff get solutions/STUDENT/KEY.ipynb. Only problems that pass
    their certificate are written; the certificates are stored in certificates/STUDENT/KEY.json for `qdot verify`. If a
    problem does not pass, it is regenerated for the student and recorded in DIR/redrawn.csv. If no attempt passes, the
    student is left out; the command then exits with code 2 and says which problems to change. Notebooks that are up
    to date are not written again, so a stopped run continues where it was.

    Examples:
      qdot generate homework
          a notebook for each student on the roster
      qdot generate homework --jobs 2
          with two processes, if memory is short
    """
    assignment = load_class(folder)
    for message in assignment.notes:
        note(message)
    counts = {"written": 0, "rewritten": 0, "completed": 0, "kept": 0, "left out": 0}
    failed_slots: list[FailedSlot] = []
    with show_progress("generating", len(assignment.roster)) as counter:

        def report_student(result: ReleaseResult) -> None:
            counts[result.outcome] += 1
            failed_slots.extend(result.failed_slots)
            for slot in result.failed_slots:
                note(str(slot))
            if result.failed_slots and (old_path := notebook_path(assignment, result.student)).exists():
                note(f"{old_path} belongs to an older version of the assignment; do not distribute it")
            counter.step()

        release_results = release_notebooks(assignment, CERTIFIER, min(jobs, len(assignment.roster)), report_student)
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count)
    targets = f"distribute {folder / 'released'}, keep {folder / 'solutions'} private"
    say(f"{count_noun(len(assignment.roster), 'student')}: {outcomes}; {targets}")
    if counts["rewritten"]:
        note("The assignment, the secret or qdot changed after the notebooks were written: distribute the new ones.")
    for message in (*describe_replacements(assignment, release_results), *describe_shared_answers(release_results)):
        note(message)
    if former_students := find_former_students(release_results):
        names = list_some(former_students, 3)
        note(f"do not distribute the notebooks of students not on the roster ({names}), in {folder / 'released'}")
    raise_failed_slots(release_results, failed_slots)


def verify(
    what: Annotated[
        list[str],
        name_argument("PROBLEM… | DIR", "Problems (FAMILY/SEED) or an assignment folder.", FAMILIES, suffix="/1"),
    ] = [],  # noqa: B006
    family: Annotated[
        str, name_option("Verify problems of this family, or of `all` families.", names=[*FAMILIES, "all"])
    ] = "",
    count: Annotated[int, typer.Option(min=1, help="With --family: how many problems, with seeds 0, 1, 2, …")] = 100,
    first_seed: Annotated[int, typer.Option(metavar="SEED", min=0, max=1 << 62, help="With --family: first seed.")] = 0,
    variation: VariationOption = "",
    convention: ConventionOption = "",
    twist_order: TwistOrderOption = "",
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Certify problems, or check that an assignment is unchanged.

    Checks that four derivations of the Jacobian agree, that the singular configurations are correct and complete, and
    that the references get full marks. For an assignment folder, also checks that problems and notebooks still match
    the certificates written by `qdot generate`; a problem without a certificate fails. Prints each failure with its
    cause, and exits with code 1 if a problem fails.

    Examples:
      qdot verify planar-2r/7
          one problem
      qdot verify homework
          a class: do problems and notebooks still match what was distributed?
      qdot verify --family all --count 1000
          a sweep over all families
    """
    from qdot.grader.grading.certify import verify_all

    def make_task(identity: ProblemId) -> VerificationTask:
        return VerificationTask(identity.with_variation(variation).with_convention(convention, twist_order))

    seeds, is_varied = range(first_seed, first_seed + count), bool(variation or convention or twist_order)
    tasks = _list_tasks(what, family, seeds, make_task, is_varied)
    started = time.monotonic()
    failure_counts, passed_count_by_family = (
        Counter[FailureKind](),
        dict.fromkeys((task.identity.family for task in tasks), 0),
    )
    printed: set[str] = set()
    with show_progress("verifying", len(tasks)) as counter, closing(verify_all(tasks, jobs)) as verified_tasks:
        for task, failures in verified_tasks:
            counter.step()
            failure_counts.update(failure.kind for failure in failures[:1])
            passed_count_by_family[task.identity.family] += not failures
            for failure in failures:
                if failure.message not in printed:  # a message that concerns all problems of a student is printed once
                    say(failure.message)
                printed.add(failure.message)
    if family == "all":
        for name, number in passed_count_by_family.items():
            say(f"{name:<20} {number} passed")
    seconds = time.monotonic() - started
    kinds = ", ".join(f"{number} {kind}" for kind, number in sorted(failure_counts.items()))
    say(f"{count_noun(len(tasks), 'problem')} verified, {failure_counts.total()} failed{': ' if kinds else ''}{kinds}")
    note(f"in {seconds:.1f} s, {60 * len(tasks) / max(seconds, 1e-9):.0f} a minute")
    if failure_counts:
        raise typer.Exit(1)


MakeTask = Callable[[ProblemId], VerificationTask]
NO_FOLDER_HINT = "; there is no folder with that name either"
"""The end of the message about an argument that is neither a problem nor a folder."""


def _list_tasks(
    problems_or_folders: list[str], family: str, seeds: range, make_task: MakeTask, has_variation: bool
) -> list[VerificationTask]:
    """Return a task for each problem to verify.

    The problems are either named by `problems_or_folders`, or given by the family and the seeds. Several families share
    the number of seeds evenly, each beginning at the first seed. Raises QdotError.
    """
    if not family and not problems_or_folders:
        raise QdotError("give problems (planar-2r/7), an assignment folder, or --family FAMILY (or all) with --count")
    if family and problems_or_folders:
        raise QdotError(f"give either --family, which verifies a whole family, or {problems_or_folders[0]!r}")
    families = list(FAMILIES) if family == "all" else [look_up_family(family).name] if family else []
    numbers = range(len(seeds) if families else 0)
    tasks = [make_task(ProblemId(families[i % len(families)], seeds.start + i // len(families))) for i in numbers]
    # Each process then derives an arm's structure only once.
    tasks.sort(key=lambda task: families.index(task.identity.family))
    for item in problems_or_folders:
        if not Path(item).is_dir():
            tasks.append(make_task(ProblemId.parse(item, NO_FOLDER_HINT)))
        elif has_variation:
            options = "--variation, --convention and --twist-order"
            raise QdotError(f"{options} apply to problems only; for an assignment, set them in {item}/assignment.toml")
        else:
            assignment = load_class(Path(item))
            for student in find_former_students(assignment):
                note(f"{student} is not on the roster but has a notebook or certificate, which was verified too")
            tasks += list_tasks(assignment)
    return tasks


def compare(
    student: Annotated[str, typer.Argument(metavar="STUDENT", help="The student's answer, as text.")] = "",
    reference: Annotated[str, typer.Argument(metavar="REFERENCE", help="The correct answer, as text.")] = "",
    type: Annotated[
        str,
        name_option(f"Type: {', '.join(COMPARISON_TYPES)}. Default: that of the reference.", names=COMPARISON_TYPES),
    ] = "",
    joints: Annotated[
        str, typer.Option(help="The joint variables of a set of angles or conditions, separated by commas.")
    ] = "",
    batch: Annotated[
        str, typer.Option(metavar="FILE.jsonl", help="One comparison per line, as JSON; - reads standard input.")
    ] = "",
) -> None:
    """Compare two answers as the grader does.

    Prints the verdict and how certain it is.

    Examples:
      qdot compare "a1*a2*s2" "a1*a2*sin(theta2)"
          an answer and its reference
      qdot compare --batch answers.jsonl
          many comparisons, one JSON object per line
    """
    if batch:
        refused: list[str] = []
        for answer in compare_lines(_read_lines(batch), refused):
            say(answer)
        if refused:
            others_text = f", and {count_noun(len(refused) - 1, 'more line')} with errors" if len(refused) > 1 else ""
            raise QdotError(f"{refused[0]}{others_text}; all other lines were compared")
        return
    if not reference:
        raise QdotError("give two texts, STUDENT and REFERENCE, or --batch FILE.jsonl")
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
    """Show what this machine's sandbox enforces.

    Tests each guarantee with a probe, which runs in place of a notebook and tries to break out. If the kernel enforces
    all of them, you can use sandbox = "strict" in assignment.toml. Exits with code 0 whatever it finds.

    Examples:
      qdot doctor
          what the sandbox of this machine enforces
    """
    from importlib.metadata import version

    findings = guarantees.probe()
    versions = {"qdot": find_qdot_version(), **{name: version(name) for name in ("sympy", "numpy")}}
    environment = {"python": platform.python_version(), **versions, "system": platform.platform(), "cores": CORE_COUNT}
    if as_json:
        say(json.dumps({**environment, **findings.as_json()}, ensure_ascii=False, indent=2))
        return
    say(", ".join(f"{name} {value}" for name, value in environment.items()))
    say("")
    for guarantee in findings.guarantees:
        say(f"{guarantee.name:<11} {guarantee.by:<23} {', '.join(guarantee.means)}")
        say(f"{'':<11} a notebook {guarantee.promise}")
        for achievement in guarantee.achieved:
            say(f"{'':<11} the probe {achievement}")
    say("")
    for remedy in guarantees.list_remedies(findings):
        say(remedy)
    verb = "can" if findings.is_strict else "can't"
    say(f'this machine {verb} use sandbox = "strict" in assignment.toml')


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder for the demo.")] = Path("qdot-demo"),
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Run everything on a simulated class of 30.

    Creates an assignment folder, generates notebooks, submits right, wrong, blank and broken ones, and grades them.

    Examples:
      qdot demo
          a class of 30, from problems to feedback, in qdot-demo
    """
    from qdot.grader.cli.demo import run_demo

    check_system()
    run_demo(folder, jobs)
