"""The commands for a class: generate, verify, compare, grade, doctor, demo."""

import io
import json
import platform
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any

import typer

from qdot.exercises.assignment.assignment import Assignment, load_assignment
from qdot.exercises.assignment.draws import FailedSlot, describe_redraws, raise_left_out
from qdot.exercises.assignment.release import CORES, ReleaseResult, notebook_path, release
from qdot.exercises.common.completion import complete_names
from qdot.exercises.common.console import VariationOption, note, progress, say
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import qdot_version
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import look_up_family
from qdot.exercises.problem.problem import ProblemId
from qdot.grader.cli.options import (
    AsJson,
    ConventionOption,
    Folder,
    Jobs,
    Seconds,
    TwistOrderOption,
    name_option,
)
from qdot.grader.grading.batch import (
    find_student,
    find_student_files,
    grade_class,
    grade_one,
    lock_folder,
    make_limits,
    read_time,
)
from qdot.grader.grading.certificates import Kind
from qdot.grader.grading.certify import CERTIFIER, Task, find_former_students, list_tasks
from qdot.grader.grading.class_check import check_class, check_secret, load_class, read_sample
from qdot.grader.grading.history import describe_moves, read_earlier_results
from qdot.grader.grading.marking import format_points
from qdot.grader.grading.overrides import OVERRIDES, note_unused_groups, read_overrides
from qdot.grader.grading.result import Result
from qdot.grader.judging.compare import TYPES, compare_lines, content_of, likely_type
from qdot.grader.judging.compare import compare as compare_texts
from qdot.grader.reports.tables import NO_MARK, count_overridden, list_staff_notes, status
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits, check_system
from qdot.grader.statistics.shared_answers import describe_shared_answers
from qdot.grader.submissions.submission import (
    OTHER_EDITION,
    StudentFiles,
    SubmissionFolder,
    find_submissions,
    open_submissions,
)


def generate(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An assignment folder, as `qdot init` makes one.")],
    jobs: Jobs = CORES,
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
    failed: list[FailedSlot] = []
    with progress("generating", len(assignment.roster)) as counter:

        def report_student(released: ReleaseResult) -> None:
            counts[released.outcome] += 1
            failed.extend(released.given_up)
            for slot in released.given_up:
                note(str(slot))
            if released.given_up and (old := notebook_path(assignment, released.student)).exists():
                note(f"{old} is of an older assignment; do not hand it out")
            counter.step()

        after = release(assignment, CERTIFIER, min(jobs, len(assignment.roster)), report_student)
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count)
    say(f"{len(assignment.roster)} students: {outcomes}; hand out {folder / 'released'}, keep {folder / 'solutions'}")
    if counts["rewritten"]:
        note("The assignment, the secret or qdot changed since notebooks were written: hand the new ones out.")
    for message in (*describe_redraws(assignment, after), *describe_shared_answers(after)):
        note(message)
    if former := find_former_students(after):
        named = ", ".join(former[:3]) + (f" and {len(former) - 3} more" if len(former) > 3 else "")
        released = folder / "released"
        note(f"{released} still has notebooks of who is not on the roster ({named}): hand these out to nobody")
    raise_left_out(after, failed)


def verify(
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="PROBLEM… | DIR",
            help="Problems, or an assignment folder.",
            autocompletion=complete_names(FAMILIES, behind="/1"),
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
    jobs: Jobs = CORES,
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
    from qdot.grader.grading.certify import certify_all

    def task_of(identity: ProblemId) -> Task:
        return Task(identity.with_variation(variation).with_convention(convention, twist_order))

    tasks = _tasks(what, family, range(first, first + count), task_of, bool(variation or convention or twist_order))
    started = time.monotonic()
    failed, passed = Counter[Kind](), dict.fromkeys((task.identity.family for task in tasks), 0)
    printed: set[str] = set()
    with progress("verifying", len(tasks)) as counter, closing(certify_all(tasks, jobs)) as certified:
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


NO_FOLDER = "; there is no folder of that name, either"


def _tasks(
    what: list[str], family: str, seeds: range, task_of: Callable[[ProblemId], Task], varied: bool
) -> list[Task]:
    """Return what is to be verified: of families, as many problems together as there are seeds. Raises QdotError."""
    if not family and not what:
        raise QdotError("name problems (planar-2r/7), an assignment folder, or --family (or --family all) with --count")
    if family and what:
        raise QdotError(f"--family sweeps over a family, and {what[0]!r} is verified without it: give one or the other")
    families = list(FAMILIES) if family == "all" else [look_up_family(family).name] if family else []
    numbers = range(len(seeds) if families else 0)
    tasks = [task_of(ProblemId(families[i % len(families)], seeds.start + i // len(families))) for i in numbers]
    tasks.sort(key=lambda task: families.index(task.identity.family))  # a structure is derived once in each process
    for item in what:
        if not Path(item).is_dir():
            tasks.append(task_of(ProblemId.parse(item, NO_FOLDER)))
        elif varied:
            raise QdotError(
                "--variation, --convention and --twist-order are for problems; "
                f"{item}/assignment.toml says how its arms vary and are told"
            )
        else:
            tasks += _tasks_of_folder(Path(item))
    return tasks


def _tasks_of_folder(folder: Path) -> list[Task]:
    assignment = load_class(folder)
    for student in find_former_students(assignment):
        note(f"{student} is not on the roster, and has a notebook or certificate, which is verified all the same")
    return list_tasks(assignment)


def compare(
    student: Annotated[str, typer.Argument(metavar="STUDENT", help="The answer, as text.")] = "",
    reference: Annotated[str, typer.Argument(metavar="REFERENCE", help="What it is compared with.")] = "",
    type: Annotated[
        str, name_option(f"One of {', '.join(TYPES)}; default: by the reference.", "--type", names=TYPES)
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
            more = f", and {len(refused) - 1} more lines are no requests" if len(refused) > 1 else ""
            raise QdotError(f"{refused[0]}{more}; all others were compared")
        return
    if not reference:
        raise QdotError("compare takes two texts, STUDENT and REFERENCE, or --batch FILE.jsonl")
    kind = type or likely_type(reference)
    texts: Any = [reference] if kind == "singular" else reference
    names = tuple(name.strip() for name in joints.split(",") if name.strip())
    say(json.dumps(content_of(compare_texts(kind, student, texts, names)), ensure_ascii=False))


def _read_lines(batch: str) -> Iterable[str]:
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


def grade(
    folder: Folder,
    submissions: Annotated[
        Path | None,
        typer.Argument(metavar="SUBMISSIONS", help="A folder, or a platform's zip. Default: DIR/submitted."),
    ] = None,
    jobs: Jobs = CORES,
    fail_under: Annotated[
        float, typer.Option(metavar="PERCENT", help="Leave with code 1 if a student has less, or no mark.")
    ] = 0.0,
    seconds: Seconds = Limits.seconds,
    diff: Annotated[bool, typer.Option("--diff", help="Say whose mark moved since the last run, and why.")] = False,
    allow_missing: Annotated[
        bool, typer.Option("--allow-missing", help="Take marks away where nothing of a student is left in SUBMISSIONS.")
    ] = False,
    report: Annotated[
        list[str], typer.Option(metavar="FORMAT=PATH", help="Also write the results so; repeatable. - is stdout.")
    ] = [],  # noqa: B006
    student: Annotated[
        str, typer.Option(metavar="ID", help="Grade this student alone; SUBMISSIONS is their notebook or folder.")
    ] = "",
    received: Annotated[
        str, typer.Option(metavar="TIME", help="With --student: when it was handed in, if the file does not tell.")
    ] = "",
    executor: Annotated[
        str, typer.Option(metavar="tcp://HOST:PORT", help="Run the notebooks on the cluster of this Dask scheduler.")
    ] = "",
) -> None:
    """Grade what a class has handed in, and write feedback.

    Reads SUBMISSIONS/STUDENT/*.ipynb (or SUBMISSIONS/STUDENT.ipynb) of everybody on the roster, or what Moodle, Canvas
    and Gradescope let you download, as a folder or as the zip (docs/submissions.md). Writes
    DIR/graded/results.jsonl, DIR/graded/grades.csv and DIR/graded/feedback/STUDENT.html. What has been graded and
    has not changed is not graded again, so that a run that was stopped goes on where it was. Results that are replaced
    stay in DIR/graded/history/STUDENT.jsonl. DIR/overrides.csv (student,part,points,comment) sets points by
    hand; with the column group, those of all equal wrong answers, by the key that `qdot report` shows.
    The formats of --report are in docs/outlets.md. With --student, nothing else is written than these reports.

    Examples:
      qdot grade homework
          what lies in homework/submitted
      qdot grade homework moodle.zip
          a download of Moodle, Canvas or Gradescope
      qdot grade homework --diff
          and whose mark moved since the last run
      qdot grade homework --report canvas=canvas.csv --report xlsx=grades.xlsx
          marks to go elsewhere
      qdot grade homework late.ipynb --student s001 --report json=-
          one student's, and nothing is written
    """
    from qdot.grader.reports.formats import STDOUT, read_reports, write_asked

    reports = read_reports(report, bool(student))
    if received and not student:
        raise QdotError("--received is the time of one student's notebook: name the student with --student ID")
    assignment = load_assignment(folder)
    tell = note if any(path == STDOUT for _, path in reports) else say
    if student and executor:
        raise QdotError("--student is graded here; --executor is for a class")
    if allow_missing and student:
        raise QdotError("--allow-missing is about a whole class; --student takes no marks away")
    if student:
        results = [_grade_student(assignment, submissions, student, received, make_limits(seconds))]
        points = f"{format_points(results[0].score)} of {format_points(results[0].max_score)} points"
        summary = f"{results[0].student}: {status(results[0])}, {points}"
    else:
        place = submissions or folder / "submitted"
        earlier, results, summary = _grade_class(assignment, place, make_limits(seconds), jobs, executor, allow_missing)
        if diff:
            tell(describe_moves(earlier, results))
    tell(summary)
    write_asked(assignment, results, reports)
    _check_graded(results)
    under = [result.student for result in results if result.percent < fail_under]
    if under:
        note(f"{len(under)} of {len(results)} students have less than {fail_under:g} %, or no mark: {', '.join(under)}")
        raise typer.Exit(1)


def _grade_class(
    assignment: Assignment, place: Path, limits: Limits, jobs: int, executor: str, allow_missing: bool
) -> tuple[Mapping[str, Result], list[Result], str]:
    """Grade a class's submissions, in a folder or a zip, and write feedback.

    Returns the results of the last run, the new ones, and a summary.
    """
    from qdot.grader.reports.write import write_reports

    with open_submissions(place) as root:
        submitted = find_submissions(assignment, root)
        check_class(assignment, submitted, root, place)
        _note_ownerless(assignment, submitted)
        if not executor:  # each worker looks for itself
            check_sandbox(assignment.sandbox == "strict")
        with lock_folder(assignment.folder):
            earlier = read_earlier_results(assignment)
            if not allow_missing:
                _check_all_there(assignment, place, earlier, submitted.by_student)
            with progress("grading", len(assignment.roster)) as counter:
                jobs = min(jobs, len(assignment.roster))
                results = grade_class(
                    assignment, submitted.by_student, jobs, limits, lambda _: counter.step(), executor=executor
                )
            with progress("writing feedback", len(results)) as counter:
                results = write_reports(assignment, results, jobs, counter.step)
    _tell_notes(results)
    groups = Counter(part.group for result in results for part in result.parts.values() if part.group is not None)
    by_size = [group for group, _ in groups.most_common()]
    for message in note_unused_groups(assignment, read_overrides(assignment), by_size):
        note(message)
    ownerless = len(submitted.unsure) + len(submitted.strangers)
    if not ownerless and all(result.submission is None for result in results):
        note(f"nobody has handed in anything: put what comes back into {place}, as STUDENT/{assignment.key}.ipynb")
    return earlier, results, _summary(results, assignment.folder, ownerless)


def _check_all_there(
    assignment: Assignment, place: Path, earlier: Mapping[str, Result], by_student: Mapping[str, StudentFiles]
) -> None:
    """Raise QdotError if students had submitted at the last run and have not now: they would lose their marks.

    This happens with a second zip of latecomers only, or if a platform's zip was graded and is not named again.
    """
    names = [student.id for student in assignment.roster]
    submitted = {name for name, result in earlier.items() if result.submission is not None}
    lost = [name for name in names if name not in by_student and name in submitted]
    if lost:
        some = ", ".join(lost[:5]) + (f" and {len(lost) - 5} more" if len(lost) > 5 else "")
        raise QdotError(
            f"{place}: nothing is here of {len(lost)} of {len(names)} students, who had handed in at "
            f"the last run: {some}; put theirs with the rest, everybody's into one folder or zip, or say "
            "--allow-missing to take their marks away"
        )


def _note_ownerless(assignment: Assignment, submitted: SubmissionFolder) -> None:
    """Tell the staff which files belong to nobody on the roster, or possibly to several students."""
    for message in submitted.unsure:
        note(message)
    for name in submitted.strangers:
        hint = f"; whose is it? it is told by the folder, as in STUDENT/{name}" * (name == f"{assignment.key}.ipynb")
        note(f"{name}: no student of that name is on the roster; not graded{hint}")


def _grade_student(assignment: Assignment, path: Path | None, name: str, received: str, limits: Limits) -> Result:
    """Grade one student alone, from a notebook or folder, or from what the class has submitted."""
    student = find_student(assignment, name)
    time = read_time(received) if received else None
    if path is not None:
        files = find_student_files(assignment, path, time)
    else:
        files = find_submissions(assignment, assignment.folder / "submitted").by_student.get(student.id)
        if files is not None and time is not None:
            files = replace(files, received=time, platform="option")
    read = read_sample(assignment, {} if files is None else {student.id: files}, [student.id])
    check_secret(assignment, [submission for _, submission in read], path or assignment.folder / "submitted")
    check_sandbox(assignment.sandbox == "strict")
    result = grade_one(assignment, student, files, limits)
    _tell_notes([result])
    return result


def _check_graded(results: list[Result]) -> None:
    """Report the students who have no mark because a limit was exceeded. Raises QdotError if qdot failed."""
    over = [result.student for result in results if status(result) == "over limit"]
    if over:
        note(
            f"without a mark, for what they handed in takes more to grade than a limit allows: {', '.join(over[:5])}"
            f"{', …' if len(over) > 5 else ''}; feedback says which, and overrides.csv can set points"
        )
    if any(status(result) == "ungraded" for result in results):
        raise QdotError(
            "qdot failed on some answers, which have no mark: feedback and grades.csv say 'ungraded', and why; "
            "please report it"
        )


def check_sandbox(strict: bool) -> None:
    """Say what this machine does not enforce. Raises QdotError where the assignment demands that it does."""
    check_system()
    findings = guarantees.probe(quick=not strict)
    if strict and not findings.is_strict:
        raise QdotError(guarantees.explain_refusal(findings))
    if warning := guarantees.describe_weakness(findings):
        note(warning)


def doctor(as_json: AsJson = False) -> None:
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
    about = {"python": platform.python_version(), **versions, "system": platform.platform(), "cores": CORES}
    if as_json:
        say(json.dumps({**about, **findings.as_json()}, ensure_ascii=False, indent=2))
        return
    say(", ".join(f"{name} {value}" for name, value in about.items()))
    say("")
    for each in findings.guarantees:
        say(f"{each.name:<11} {each.by:<23} {', '.join(each.means)}")
        say(f"{'':<11} a notebook {each.promise}")
        for achieved in each.achieved:
            say(f"{'':<11} the probe {achieved}")
    say("")
    for advised in guarantees.list_remedies(findings):
        say(advised)
    can = "can" if findings.is_strict else "can't"
    say(f'sandbox = "strict" in assignment.toml {can} be had on this machine')


def _tell_notes(results: list[Result]) -> None:
    """Tell the staff what is odd, in a line for each student and note; outdated notebooks in one line for the class."""
    for result in results:
        for message in list_staff_notes(result):
            if message != OTHER_EDITION:
                note(f"{result.student}: {message}")
    submitted = sum(result.submission is not None for result in results)
    outdated = sum(OTHER_EDITION in result.staff_notes for result in results)
    if outdated:
        note(
            f"WARNING: {outdated} of {submitted} notebooks were made from another assignment.toml, redrawn.csv or "
            "secret: hand out the new ones, or put the old ones back"
        )


def _summary(results: list[Result], folder: Path, ownerless: int) -> str:
    kinds = ", ".join(f"{count} {kind}" for kind, count in Counter(map(status, results)).items())
    percents = [result.percent for result in results if result.submission is not None and status(result) not in NO_MARK]
    mean = f"mean {fmean(percents):.1f} % of those handed in; " if percents else ""
    left = f"{ownerless} of nobody on the roster, or not surely of one; " if ownerless else ""
    overridden = sum(map(count_overridden, results))
    by_hand = f"{overridden} set by {OVERRIDES}; " if overridden else ""
    return f"{len(results)} students: {kinds}; {mean}{by_hand}{left}see {folder / 'graded'}"


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where to put it.")] = Path("qdot-demo"),
    jobs: Jobs = CORES,
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
