"""The commands for a class: generate, verify, compare, grade, doctor, demo."""

import io
import json
import platform
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.draws import FailedSlot, describe_redraws, raise_left_out
from qdot.exercises.assignment.release import CORES, ReleaseResult, notebook_path, release
from qdot.exercises.common.completion import complete_names
from qdot.exercises.common.console import VariationOption, note, progress, say
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.extras import qdot_version
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import family_named
from qdot.exercises.problem.problem import ProblemId
from qdot.grader.cli.options import ConventionOption, TwistOrderOption
from qdot.grader.grading.batch import WritePage, alone, grade_class
from qdot.grader.grading.certificates import Kind
from qdot.grader.grading.certify import CERTIFIER, Task, former_students, record_of, tasks_of, unknown_files
from qdot.grader.grading.class_check import check_class, check_secret, load_class, read_some
from qdot.grader.grading.cluster import connected
from qdot.grader.grading.marking import number
from qdot.grader.grading.one_student import found_of_one, grade_one, limits_of, read_time, student_named
from qdot.grader.grading.overrides import OVERRIDES, read_overrides, without_answers
from qdot.grader.grading.result import Result
from qdot.grader.judging.compare import TYPES, compare_lines, content_of, likely_type
from qdot.grader.judging.compare import compare as compare_texts
from qdot.grader.reports.tables import NO_MARK, count_set, staff_notes, status
from qdot.grader.sandbox import guarantees
from qdot.grader.sandbox.sandbox import Limits, check_system
from qdot.grader.statistics.shared_answers import shared_answers
from qdot.grader.submissions.submission import OTHER_EDITION, StudentFiles, find_submissions, open_submissions

Jobs = Annotated[
    int, typer.Option("--jobs", "-j", min=1, help="How many processes work at once.", show_default="cores")
]


def generate(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An assignment folder, as `qdot init` makes one.")],
    jobs: Jobs = CORES,
) -> None:
    """Write a class's notebooks, with solutions and certificates.

    A problem leaves only if it passes its certificate, which certificates/STUDENT/KEY.json keeps for `qdot verify`. One
    that does not is drawn anew for its student, which DIR/redrawn.csv tells; where no draw passes, the student is left
    out, all others have their notebooks, and the command leaves with code 2 and says what could be asked instead.
    Every student has released/STUDENT/KEY.ipynb, and the staff solutions/STUDENT/KEY.ipynb. Notebooks that are up
    to date are kept, so that a run that was stopped goes on where it was.
    """
    assignment = load_class(folder)
    for said in assignment.notes:
        note(said)
    counts = {"written": 0, "rewritten": 0, "completed": 0, "kept": 0, "left out": 0}
    given_up: list[FailedSlot] = []
    with progress("generating", len(assignment.roster)) as counter:

        def each(released: ReleaseResult) -> None:
            counts[released.outcome] += 1
            given_up.extend(released.given_up)
            for given in released.given_up:
                note(str(given))
            if released.given_up and (old := notebook_path(assignment, released.student)).exists():
                note(f"{old} is of an older assignment; do not hand it out")
            counter.step()

        after = release(assignment, CERTIFIER, min(jobs, len(assignment.roster)), each)
    said = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count)
    say(f"{len(assignment.roster)} students: {said}; hand out {folder / 'released'}, keep {folder / 'solutions'}")
    if counts["rewritten"]:
        note("The assignment, the secret or qdot changed since notebooks were written: hand the new ones out.")
    for told in (*describe_redraws(assignment, after), *shared_answers(after), *_of_nobody(after)):
        note(told)
    raise_left_out(after, given_up, record_of)


def _of_nobody(assignment: Assignment) -> Iterator[str]:
    """Yield a line about notebooks that an earlier roster's students have, who are not on it any more."""
    gone = former_students(assignment)
    if gone:
        named = ", ".join(gone[:3]) + (f" and {len(gone) - 3} more" if len(gone) > 3 else "")
        folder = assignment.folder
        yield (
            f"{folder / 'released'} still has notebooks of who is not on the roster ({named}): hand these out to "
            f"nobody; 'qdot forget {gone[0]} {folder}' removes all that there is of one"
        )


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
        str,
        typer.Option(
            help="Sweep over problems of this family, or of `all` …", autocompletion=complete_names(FAMILIES, ["all"])
        ),
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
    """
    from qdot.grader.grading.certify import certify_all

    tasks = _tasks(what, family, range(first, first + count), _Told(variation, convention, twist_order))
    started = time.monotonic()
    failed, passed = Counter[Kind](), dict.fromkeys((task.identity.family for task in tasks), 0)
    told: set[str] = set()
    with progress("verifying", len(tasks)) as counter, closing(certify_all(tasks, jobs)) as every:
        for task, failures in every:
            counter.step()
            failed.update(failure.kind for failure in failures[:1])
            passed[task.identity.family] += not failures
            for failure in failures:
                if failure.said not in told:  # what concerns all problems of a student is told once
                    say(failure.said)
                told.add(failure.said)
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


@dataclass(frozen=True)
class _Told:
    """How arms vary, and how they are told, where the command says so."""

    variation: str
    convention: str
    twist_order: str

    def task(self, identity: ProblemId) -> Task:
        """Return what is to be verified of a problem. Raises QdotError."""
        return Task(identity.with_variation(self.variation).with_convention(self.convention, self.twist_order))

    def check_folder(self, name: str) -> None:
        """Raise QdotError where the command says what is an assignment's to say."""
        said = {"--variation": self.variation, "--convention": self.convention, "--twist-order": self.twist_order}
        for option, value in said.items():
            if value:
                how = "vary" if option == "--variation" else "are told"
                raise QdotError(f"{option} is for problems; {name}/assignment.toml says how its arms {how}")


def _tasks(what: list[str], family: str, seeds: range, told: _Told) -> list[Task]:
    """Return what is to be verified: of families, as many problems together as there are seeds. Raises QdotError."""
    if not family and not what:
        raise QdotError("name problems (planar-2r/7), an assignment folder, or --family (or --family all) with --count")
    if family and what:
        raise QdotError(f"--family sweeps over a family, and {what[0]!r} is verified without it: give one or the other")
    families = list(FAMILIES) if family == "all" else [family_named(family).name] if family else []
    every = range(len(seeds) if families else 0)
    tasks = [told.task(ProblemId(families[i % len(families)], seeds.start + i // len(families))) for i in every]
    tasks.sort(key=lambda task: families.index(task.identity.family))  # a structure is derived once in each process
    for item in what:
        if not Path(item).is_dir():
            tasks.append(told.task(ProblemId.parse(item, NO_FOLDER)))
        else:
            told.check_folder(item)
            tasks += _tasks_of_folder(Path(item))
    return tasks


def _tasks_of_folder(folder: Path) -> list[Task]:
    assignment = load_class(folder)
    for student in former_students(assignment):
        note(f"{student} is not on the roster, and has a notebook or certificate, which is verified all the same")
    unknown = unknown_files(assignment)
    if unknown:
        named = ", ".join(map(str, unknown[:3])) + (", …" if len(unknown) > 3 else "")
        note(f"not looked at, neither notebooks nor certificates of this assignment: {len(unknown)}, as {named}")
    return tasks_of(assignment)


def compare(
    student: Annotated[str, typer.Argument(metavar="STUDENT", help="The answer, as text.")] = "",
    reference: Annotated[str, typer.Argument(metavar="REFERENCE", help="What it is compared with.")] = "",
    type: Annotated[
        str,
        typer.Option(
            "--type",
            "-t",
            help=f"One of {', '.join(TYPES)}; default: by the reference.",
            autocompletion=complete_names(TYPES),
        ),
    ] = "",
    joints: Annotated[str, typer.Option(help="Joint variables of a singular set, with commas between.")] = "",
    batch: Annotated[
        str, typer.Option("--batch", metavar="FILE.jsonl", help="Many, one JSON object a line; - reads standard input.")
    ] = "",
) -> None:
    """Compare two answers as the grader does.

    It says how sure it is. Example: qdot compare "a1*a2*s2" "a1*a2*sin(theta2)"
    """
    if batch:
        refused: list[str] = []
        for answer in compare_lines(_lines(batch), refused):
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


def _lines(batch: str) -> Iterable[str]:
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
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The assignment folder.")],
    submissions: Annotated[
        Path | None,
        typer.Argument(metavar="SUBMISSIONS", help="A folder, or a platform's zip. Default: DIR/submitted."),
    ] = None,
    jobs: Jobs = CORES,
    fail_under: Annotated[
        float, typer.Option(metavar="PERCENT", help="Leave with code 1 if a student has less, or no mark.")
    ] = 0.0,
    seconds: Annotated[float, typer.Option(min=1, help="Processor time that a notebook may take.")] = Limits().seconds,
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
        str, typer.Option(metavar="tcp://HOST:PORT", help="Run the notebooks on this Dask scheduler's cluster.")
    ] = "",
) -> None:
    """Grade what a class has handed in, and write feedback.

    Reads SUBMISSIONS/STUDENT/*.ipynb (or SUBMISSIONS/STUDENT.ipynb) of everybody on the roster, or what Moodle, Canvas
    and Gradescope let you download, as a folder or as the zip (docs/submissions.md). Writes
    DIR/graded/results.jsonl, DIR/graded/grades.csv and DIR/graded/feedback/STUDENT.html. What has been graded and
    has not changed is not graded again, so that a run that was stopped goes on where it was. Results that are replaced
    stay in DIR/graded/history/STUDENT.jsonl. DIR/overrides.csv (student,part,points,comment) sets points by
    hand; with the column group, those of all equal wrong answers, by the key that `qdot report` shows.
    The formats of --report are in docs/outlets.md. With --student, nothing else is written than these reports. Several
    machines can grade a class together: docs/scaling.md.
    """
    from qdot.grader.reports.formats import STDOUT, read_reports, write_asked

    asked = read_reports(report, bool(student))
    if received and not student:
        raise QdotError("--received is the time of one student's notebook: name the student with --student ID")
    assignment = load_assignment(folder)
    limits = limits_of(seconds)
    tell = note if any(path == STDOUT for _, path in asked) else say
    if student and executor:
        raise QdotError("--student is graded here; --executor is for a class")
    if allow_missing and student:
        raise QdotError("--allow-missing is about a whole class; --student takes no marks away")
    if student:
        results = [_grade_one(assignment, submissions, student, received, seconds, tell)]
    else:
        named = submissions or folder / "submitted"
        with open_submissions(named) as root:
            whole = None if allow_missing else named
            results = _grade(assignment, root, named, jobs, limits, diff, tell, executor, whole)
    write_asked(assignment, results, asked)
    _check_graded(results)
    under = [result.student for result in results if result.percent < fail_under]
    if under:
        note(f"{len(under)} of {len(results)} students have less than {fail_under:g} %, or no mark: {', '.join(under)}")
        raise typer.Exit(1)


def _grade(
    assignment: Assignment, submissions: Path, named: Path, jobs: int, limits: Limits, diff: bool,
    tell: Callable[[str], None], executor: str, whole: Path | None,
) -> list[Result]:  # fmt: skip
    from qdot.grader.grading.history import describe_moves, earlier_results
    from qdot.grader.reports.write import write_page, write_reports

    looked = find_submissions(assignment, submissions)
    check_class(assignment, looked, submissions, named)
    for said in looked.unsure:
        note(said)
    for name in looked.strangers:
        whose = (
            f"; whose is it? it is told by the folder, as in STUDENT/{name}"
            if name == f"{assignment.key}.ipynb"
            else ""
        )
        note(f"{name}: no student of that name is on the roster; not graded{whose}")
    if not executor:  # each worker looks for itself
        check_sandbox(assignment.sandbox == "strict")
    with alone(assignment.folder):
        earlier = earlier_results(assignment)
        if whole is not None:
            _check_all_there(assignment, earlier, looked.by_student, whole)
        results = _results(assignment, looked.by_student, assignment.roster, jobs, limits, executor, write_page)
        with progress("writing feedback", len(results)) as counter:
            results = write_reports(assignment, results, min(jobs, len(results)), counter.step)
    _tell_notes(results)
    for said in without_answers(assignment, read_overrides(assignment), _groups_of(results)):
        note(said)
    if diff:
        tell(describe_moves(earlier, results))
    tell(_summary(results, assignment.folder, len(looked.unsure) + len(looked.strangers)))
    if all(result.submission is None for result in results) and not (looked.unsure or looked.strangers):
        note(
            f"nobody has handed in anything: put what comes back into {submissions}, as STUDENT/{assignment.key}.ipynb"
        )
    return results


def _check_all_there(
    assignment: Assignment, earlier: Mapping[str, Result], found: Mapping[str, StudentFiles], submissions: Path
) -> None:
    """Raise QdotError where students had handed in at the last run and have not now: they would lose their marks.

    So it is with a second zip that has latecomers only, or where a platform's zip was graded and is not named again.
    """
    names = [student.id for student in assignment.roster]
    handed_in = {name for name, result in earlier.items() if result.submission is not None}
    lost = [name for name in names if name not in found and name in handed_in]
    if lost:
        some = ", ".join(lost[:5]) + (f" and {len(lost) - 5} more" if len(lost) > 5 else "")
        raise QdotError(
            f"{submissions}: nothing is here of {len(lost)} of {len(names)} students, who had handed in at the last "
            f"run: {some}; put theirs with the rest, everybody's into one folder or zip, or say --allow-missing "
            "to take their marks away"
        )


def _groups_of(results: list[Result]) -> list[str]:
    """Return the keys of the groups of equal wrong answers, those of most students first."""
    every = (part.group for result in results for part in result.parts.values())
    return [group for group, _ in Counter(group for group in every if group is not None).most_common()]


def _grade_one(
    assignment: Assignment, path: Path | None, named: str, received: str, seconds: float, tell: Callable[[str], None]
) -> Result:
    student = student_named(assignment, named)
    time = read_time(received) if received else None
    if path is not None:
        handed_in = found_of_one(assignment, path, time)
    else:
        handed_in = find_submissions(assignment, assignment.folder / "submitted").by_student.get(student.id)
        if handed_in is not None and time is not None:
            handed_in = replace(handed_in, received=time, platform="option")
    read = read_some(assignment, {} if handed_in is None else {student.id: handed_in}, [student.id])
    check_secret(assignment, [one for _, one in read], path or assignment.folder / "submitted")
    check_sandbox(assignment.sandbox == "strict")
    result = grade_one(assignment, student, handed_in, limits_of(seconds))
    _tell_notes([result])
    points = f"{number(result.score)} of {number(result.max_score)} points"
    tell(f"{student.id}: {status(result)}, {points}")
    return result


def _results(
    assignment: Assignment, found: dict[str, StudentFiles], students: Sequence[Student], jobs: int, limits: Limits,
    executor: str, write_page: WritePage | None = None,
) -> list[Result]:  # fmt: skip
    """Return the results of students, with progress shown."""

    def each(_: Result) -> None:
        counter.step()

    if not executor:
        with progress("grading", len(students)) as counter:
            return grade_class(
                assignment, found, min(jobs, len(students)), limits, each, students, write_page=write_page
            )
    with connected(executor) as (workers, room), progress("grading", len(students)) as counter:
        return grade_class(assignment, found, jobs, limits, each, students, workers, room)


def _check_graded(results: list[Result]) -> None:
    """Say who has no mark because a limit was exceeded. Raises QdotError where qdot failed."""
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
        raise QdotError(guarantees.refusal(findings))
    said = guarantees.warning(findings)
    if said:
        note(said)


def doctor(as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """Show what this machine enforces while students' code runs.

    Each guarantee is tried: a probe runs where a notebook would and attempts to break out. With all of them enforced
    by the kernel, sandbox = "strict" in assignment.toml can be had here. The code is 0 whatever is found.
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
    for advised in guarantees.advice(findings):
        say(advised)
    can = "can" if findings.is_strict else "can't"
    say(f'sandbox = "strict" in assignment.toml {can} be had on this machine')


def _tell_notes(results: list[Result]) -> None:
    """Tell the staff what is odd, a line for each student and note; other editions in one line for the whole class."""
    for result in results:
        for said in staff_notes(result):
            if said != OTHER_EDITION:
                note(f"{result.student}: {said}")
    handed_in = sum(result.submission is not None for result in results)
    others = sum(OTHER_EDITION in result.staff_notes for result in results)
    if others:
        note(
            f"WARNING: {others} of {handed_in} notebooks were made from another assignment.toml, redrawn.csv or "
            "secret: hand out the new ones, or put the old ones back"
        )


def _summary(results: list[Result], folder: Path, nobodys: int) -> str:
    kinds: dict[str, int] = {}
    for result in results:
        kinds[status(result)] = kinds.get(status(result), 0) + 1
    marked = [result for result in results if result.submission is not None and status(result) not in NO_MARK]
    handed_in = [result.percent for result in marked]
    mean = f"mean {sum(handed_in) / len(handed_in):.1f} % of those handed in; " if handed_in else ""
    said = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
    left = f"{nobodys} of nobody on the roster, or not surely of one; " if nobodys else ""
    of_people = sum(map(count_set, results))
    by_hand = f"{of_people} set by {OVERRIDES}; " if of_people else ""
    return f"{len(results)} students: {said}; {mean}{by_hand}{left}see {folder / 'graded'}"


def demo(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where to put it.")] = Path("qdot-demo"),
    jobs: Jobs = CORES,
) -> None:
    """Do the whole loop on a simulated class of 30.

    Makes the folder, generates, hands in what is right, wrong, blank or broken, and grades it.
    """
    from qdot.grader.cli.demo import run_demo

    check_system()
    run_demo(folder, jobs)
