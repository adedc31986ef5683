"""The commands for a class other than `qdot grade`: generate, release, verify, compare, doctor."""

import io
import json
import platform
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from qdot.exercises.assignment.assignment import check_definition_on_family
from qdot.exercises.assignment.certified_problems import FailedSlot, describe_replacements, raise_failed_slots
from qdot.exercises.assignment.handout import (
    INDEX_FILE,
    make_index_csv,
    write_folders,
    write_links,
    write_moodle_zip,
)
from qdot.exercises.assignment.release import ReleaseResult, is_released, make_notebook_path, release_notebooks
from qdot.exercises.common.console import check_choice, note, print_result, show_progress
from qdot.exercises.common.errors import QdotError, count_noun, write_first
from qdot.exercises.common.extras import find_qdot_version
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.input_file import read_toml
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate as generate_problem
from qdot.exercises.generation import look_up_family
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.grader.cli.options import (
    NO_FOLDER_HINT,
    ConventionOption,
    FolderArgument,
    JobsOption,
    JsonOption,
    TwistOption,
    VariationOption,
    name_argument,
    name_option,
)
from qdot.grader.grading.certificates import FailureKind
from qdot.grader.grading.certify import CERTIFIER, VerificationTask, find_former_students, list_tasks
from qdot.grader.grading.class_check import load_class
from qdot.grader.judging.compare_command import COMPARISON_TYPES, compare_lines, describe_judgement, guess_type
from qdot.grader.judging.compare_command import compare as compare_texts
from qdot.grader.sandbox import guarantees
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
    to date are not written again, so a stopped run continues where it stopped.

    Examples:
      qdot generate homework
          a notebook for each student on the roster
      qdot generate homework --jobs 2
          with two processes, if memory is short
    """
    assignment = load_class(folder)
    for message in assignment.notes:
        note(message)
    counts = dict.fromkeys(("written", "rewritten", "completed", "kept", "left out"), 0)
    failed_slots: list[FailedSlot] = []
    with show_progress("generating", len(assignment.roster)) as counter:

        def report_student(result: ReleaseResult) -> None:
            counts[result.outcome] += 1
            failed_slots.extend(result.failed_slots)
            for slot in result.failed_slots:
                note(str(slot))
            if result.failed_slots and (old_path := make_notebook_path(assignment, result.student)).exists():
                note(f"{old_path} belongs to an older version of the assignment; do not distribute it")
            counter.step()

        process_count = min(jobs, len(assignment.roster))
        released_assignment = release_notebooks(assignment, CERTIFIER, process_count, report_student)
    write_atomically(folder / "released" / INDEX_FILE, make_index_csv(released_assignment), 0o600)
    outcomes = ", ".join(f"{count} {outcome}" for outcome, count in counts.items() if count)
    next_step = f"hand out {folder / 'released'}, or pack it by qdot release; keep {folder / 'solutions'} private"
    print_result(f"{count_noun(len(assignment.roster), 'student')}: {outcomes}; {next_step}")
    if counts["rewritten"]:
        causes = "The assignment (its problems, title, points, hints or site), the secret or qdot"
        note(f"{causes} changed after the notebooks were written: distribute the new ones.")
    messages = describe_replacements(assignment, released_assignment)
    for message in (*messages, *describe_shared_answers(released_assignment)):
        note(message)
    if former_students := find_former_students(released_assignment):
        names = write_first(former_students, 3)
        note(f"do not distribute the notebooks of students not on the roster ({names}), in {folder / 'released'}")
    raise_failed_slots(released_assignment, failed_slots)


HANDOUT_TARGETS = ("folder", "moodle")
"""The values of `--to`."""


def release(
    folder: FolderArgument,
    worksheet: Annotated[
        Path | None, typer.Argument(metavar="WORKSHEET", help="With --to moodle: the assignment's grading worksheet.")
    ] = None,
    links: Annotated[
        bool, typer.Option("--links", help="Write a folder for any file server, with one address for each student.")
    ] = False,
    to: Annotated[str, name_option("Where the notebooks go: folder or moodle.", names=HANDOUT_TARGETS)] = "",
    url: Annotated[str, typer.Option(metavar="ADDRESS", help="With --links: the address of the uploaded folder.")] = "",
    out: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Folder. Default: DIR/handout/NAME.")] = None,
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Pack the notebooks of a class to hand them out.

    Generates notebooks that are missing or out of date. With --links, writes a folder to upload to any file server.
    Each student gets an address that nobody can guess; mail-merge.csv lists the addresses for e-mails to the students.
    With --to moodle, writes a zip that gives each student their notebook as a feedback file of an assignment. With --to
    folder, writes a folder named after each student, such as "Lovelace, Ada (501)".

    Examples:
      qdot release homework --links --url https://files.example.edu/rob101
          addresses for a mail merge
      qdot release homework worksheet.csv --to moodle
          the zip for "Upload feedback files in a zip"
    """
    if bool(to) == links:
        raise QdotError(f"choose one way: --links, or --to {' or --to '.join(HANDOUT_TARGETS)}")
    if to:
        check_choice(to, HANDOUT_TARGETS, "--to")
    if url and not re.match("https?://", url):
        raise QdotError(f"--url {url}: write the whole address, as in https://files.example.edu/rob101")
    if (worksheet is not None) != (to == "moodle"):
        advice = "give the grading worksheet, as in: qdot release homework worksheet.csv --to moodle"
        raise QdotError(advice if worksheet is None else "WORKSHEET applies to --to moodle only")
    assignment = load_class(folder)
    if not all(is_released(assignment, student.id) for student in assignment.roster):
        generate(folder, jobs)
        assignment = load_class(folder)
    target = out or folder / "handout" / (to or "links")
    if worksheet is not None:
        handout = write_moodle_zip(assignment, target, worksheet)
        next_step = "upload it in the assignment, Submissions > Actions > Upload feedback files in a zip"
    elif to:
        handout, next_step = write_folders(assignment, target), f"{target / INDEX_FILE} lists them"
    else:
        handout = write_links(assignment, target, url)
        next_step = f"upload it; {handout.table_path} contains the links: keep it private"
        if not url:
            note(f"{handout.table_path} has only paths; --url ADDRESS puts the address of the folder before them")
    print_result(f"{count_noun(len(assignment.roster), 'notebook')}: {handout.path}; {next_step}")


def verify(
    targets: Annotated[
        list[str],
        name_argument(
            "PROBLEM… | DIR",
            "Problems (FAMILY/SEED), an assignment folder, or a file of questions.",
            FAMILIES,
            suffix="/1",
        ),
    ] = [],  # noqa: B006
    family: Annotated[str, name_option("Verify problems of a family, or of `all`.", names=[*FAMILIES, "all"])] = "",
    count: Annotated[int, typer.Option(min=1, help="With --family: how many problems, with seeds 0, 1, 2, …")] = 100,
    first_seed: Annotated[int, typer.Option(metavar="SEED", min=0, max=1 << 62, help="With --family: first seed.")] = 0,
    variation: VariationOption = "",
    convention: ConventionOption = "",
    twist_order: TwistOption = "",
    jobs: JobsOption = CORE_COUNT,
) -> None:
    """Certify problems, or check that an assignment is unchanged.

    Checks that four derivations of the Jacobian agree, that the singular configurations are correct and complete, and
    that the references get full marks. For an assignment folder, also checks that problems and notebooks still match
    the certificates written by `qdot generate`; a problem without a certificate fails. Prints each failure with its
    cause, and exits with code 1 if a problem fails.

    With a file of your own questions, verifies each question on arms of the families, and prints three answers. If the
    file is an assignment.toml, the families are those of its problems unless you name one.

    Examples:
      qdot verify planar-2r/7
          one problem
      qdot verify questions.toml --family planar-2r --count 20
          your own questions, on 20 arms of a family
      qdot verify homework
          a class: do problems and notebooks still match what was distributed?
      qdot verify --family all --count 1000
          a sweep over all families
    """
    from qdot.grader.grading.certify import verify_all

    families = [family] if family else _list_families_of_files(targets)
    if family == "all":
        families = list(FAMILIES)
    family_problems = _list_family_problems(families, first_seed, count)
    tasks = _list_verification_tasks(targets, family_problems, variation, convention, twist_order)
    failure_counts, passed_counts = Counter[FailureKind](), Counter[str]()
    printed_messages: set[str] = set()
    with show_progress("verifying", len(tasks)) as counter, closing(verify_all(tasks, jobs)) as verified_tasks:
        for task, failures in verified_tasks:
            counter.step()
            failure_counts.update(failure.kind for failure in failures[:1])  # the number of problems, not of failures
            passed_counts[task.identity.family] += not failures
            for failure in failures:  # a message that concerns all problems of a student is printed once
                if failure.message not in printed_messages:
                    print_result(failure.message)
                printed_messages.add(failure.message)
    if family == "all":
        for name, number in passed_counts.items():
            print_result(f"{name:<20} {number} passed")
    kinds = ", ".join(f"{number} {failure_kind}" for failure_kind, number in sorted(failure_counts.items()))
    problems = count_noun(len(tasks), "problem")
    print_result(f"{problems} verified, {failure_counts.total()} failed{': ' if kinds else ''}{kinds}")
    if failure_counts:
        raise typer.Exit(1)


def _list_verification_tasks(
    targets: Sequence[str], family_problems: Sequence[ProblemId], variation: str, convention: str, twist_order: str
) -> list[VerificationTask]:
    """Return the tasks for the arguments of `qdot verify`. Raises QdotError if they don't go together."""
    folders = [Path(target) for target in targets if Path(target).is_dir()]
    question_files = [Path(target) for target in targets if target.lower().endswith(".toml")]
    if not family_problems and not targets:
        raise QdotError("give problems (planar-2r/7), an assignment folder, or --family FAMILY (or all) with --count")
    if question_files and (not family_problems or len(question_files) < len(targets)):
        raise QdotError(f"name the families for the questions of {question_files[0]}, as in --family planar-2r")
    if family_problems and targets and not question_files:
        raise QdotError(f"give either --family, which verifies a whole family, or {targets[0]!r}")
    if folders and (variation or convention or twist_order):
        advice = f"for an assignment, set them in {folders[0]}/assignment.toml"
        raise QdotError(f"--variation, --convention and --twist-order apply to problems only; {advice}")
    problem_texts = [target for target in targets if not Path(target).is_dir()]
    identities = family_problems or [ProblemId.parse(text, NO_FOLDER_HINT) for text in problem_texts]
    identities = [
        identity.with_variation(variation).with_convention(convention, twist_order) for identity in identities
    ]
    if question_files:
        return [task for path in question_files for task in _list_question_tasks(path, identities)]
    return [*map(VerificationTask, identities), *(task for folder in folders for task in _list_class_tasks(folder))]


def _list_families_of_files(targets: Sequence[str]) -> list[str]:
    """Return the families of the problems in each assignment.toml among the targets."""
    contents = [read_toml(Path(target), "", float).content for target in targets if target.lower().endswith(".toml")]
    problems = [problem for content in contents for problem in content.get("problem", ()) if isinstance(problem, dict)]
    families = dict.fromkeys(str(problem.get("family")) for problem in problems)
    return [family for family in families if family in FAMILIES]


def _list_family_problems(families: Sequence[str], first_seed: int, count: int) -> list[ProblemId]:
    """Return the ids of `count` problems, family by family, so that a process can use a derivation for several arms.

    The families share the number evenly, each beginning at `first_seed`. Raises QdotError for an unknown family.
    """
    problems = []
    for index, name in enumerate(families):
        family_count = len(range(index, count, len(families)))  # one more for the first families if there is a rest
        problems += [ProblemId(look_up_family(name).name, first_seed + i) for i in range(family_count)]
    return problems


def _list_class_tasks(folder: Path) -> list[VerificationTask]:
    """Return a task for each problem of a class; print a note on each student who has left the class."""
    assignment = load_class(folder)
    for student in find_former_students(assignment):
        note(f"{student} is not on the roster but has a notebook or certificate, which was verified too")
    return list_tasks(assignment)


SAMPLE_COUNT = 3
"""The number of sample answers that are printed for each question of a file."""


def _list_question_tasks(path: Path, identities: Sequence[ProblemId]) -> list[VerificationTask]:
    """Return a task for each question of a file and each arm to which it applies, and print sample answers.

    `identities` are the problems with these arms. If the file is an assignment, a question is verified only on the
    families whose problems ask it. Raises QdotError if a question does not apply to such a family, or applies to none.
    """
    from qdot.exercises.questions.custom.reader import read_question_file

    tasks, all_refusals, errors = list[VerificationTask](), list[str](), list[str]()
    families = list(dict.fromkeys(identity.family for identity in identities))
    file, definitions = read_question_file(path, ALL_QUESTIONS)
    families_by_question = _list_families_by_question(file.content)
    for definition in definitions.values():
        refusals: dict[str, str] = {}
        families_of_question = families_by_question.get(definition.name, set())
        tested_families = [family for family in families if family in families_of_question] or families
        for family in tested_families:
            try:
                with file.locate_errors("question", definition.name):
                    warnings = check_definition_on_family(definition, look_up_family(family))
            except QdotError as error:
                refusals[family] = str(error)
            else:
                for warning in warnings:
                    note(warning)
        all_refusals += refusals.values()
        errors += [text for family, text in refusals.items() if family in families_of_question]
        if len(refusals) == len(families) and not families_by_question:  # a file without problems
            errors.append(refusals[families[0]])
        accepted_families = set(tested_families) - set(refusals)
        accepted_identities = [identity for identity in identities if identity.family in accepted_families]
        question_identities = [replace(identity, questions=(definition.name,)) for identity in accepted_identities]
        tasks += [VerificationTask(identity, definitions=(definition,)) for identity in question_identities]
        for identity in question_identities[:SAMPLE_COUNT]:
            part = generate_problem(identity, definitions=(definition,)).parts[0]
            print_result(f"{definition.name} for {identity}: {part.answer.as_json() or part.answer.type}")
    if errors or not tasks:
        raise QdotError("\n".join(dict.fromkeys(errors or all_refusals)))
    for refusal in all_refusals:
        note(refusal)
    return tasks


def _list_families_by_question(content: Mapping[str, Any]) -> dict[str, set[str]]:
    """Map each question in the content of an assignment to the families of the problems that ask it."""
    families_by_question: dict[str, set[str]] = {}
    for problem in content.get("problem", ()):
        questions = problem.get("questions", ()) if isinstance(problem, dict) else ()
        for question in questions if isinstance(questions, list) else ():
            families_by_question.setdefault(str(question), set()).add(str(problem.get("family")))
    return families_by_question


def compare(
    student: Annotated[str, typer.Argument(metavar="STUDENT", help="The student's answer, as text.")] = "",
    reference: Annotated[str, typer.Argument(metavar="REFERENCE", help="The correct answer, as text.")] = "",
    type: Annotated[
        str,
        name_option(f"Type: {', '.join(COMPARISON_TYPES)}. Default: that of the reference.", names=COMPARISON_TYPES),
    ] = "",
    joints: Annotated[str, typer.Option(help="Joint variables of angles or conditions, separated by commas.")] = "",
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
        errors: list[str] = []
        for response in compare_lines(_read_lines(batch), errors):
            print_result(response)
        if errors:
            others_text = f", and {count_noun(len(errors) - 1, 'more line')} with errors" if len(errors) > 1 else ""
            raise QdotError(f"{errors[0]}{others_text}; all other lines were compared")
        return
    if not reference:
        raise QdotError("give two texts, STUDENT and REFERENCE, or --batch FILE.jsonl")
    answer_type = type or guess_type(reference)
    reference_answer: Any = [reference] if answer_type == "singular" else reference
    names = tuple(name.strip() for name in joints.split(",") if name.strip())
    judgement = compare_texts(answer_type, student, reference_answer, names)
    print_result(json.dumps(describe_judgement(judgement), ensure_ascii=False))


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
        raise QdotError(f"{batch} can't be read: {error.strerror}") from None


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
    versions = {"qdot": find_qdot_version(), "sympy": version("sympy"), "numpy": version("numpy")}
    environment = {"python": platform.python_version(), **versions, "system": platform.platform(), "cores": CORE_COUNT}
    if as_json:
        content = {**environment, "strict": findings.is_strict, **to_jsonable(findings)}
        print_result(json.dumps(content, ensure_ascii=False, indent=2))
        return
    print_result(", ".join(f"{name} {value}" for name, value in environment.items()))
    print_result("")
    for guarantee in findings.guarantees:
        print_result(f"{guarantee.name:<11} {guarantee.enforcement:<23} {', '.join(guarantee.means)}")
        print_result(f"{'':<11} a notebook {guarantee.promise}")
        for achievement in guarantee.achieved:
            print_result(f"{'':<11} the probe {achievement}")
    print_result("")
    for remedy in guarantees.list_remedies(findings):
        print_result(remedy)
    verb = "can" if findings.is_strict else "can't"
    print_result(f'this machine {verb} use sandbox = "strict" in assignment.toml')
