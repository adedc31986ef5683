"""The commands about arms and problems: init, families, questions, show, robots, solve."""

import json
import sys
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import qdot
from qdot import ALL_QUESTIONS, FAMILIES, ProblemId, QdotError
from qdot import generate as make_problem
from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS, find_set
from qdot.exercises.common.console import check_choice, note, print_result, show_status
from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.time_limit import DEFAULT_SECONDS, MIN_SECONDS, parse_seconds
from qdot.exercises.families import Family
from qdot.exercises.families.robot_family import read_robot_family
from qdot.exercises.generation import find_listing, look_up_family, select_quiz_questions
from qdot.exercises.problem.problem import normalize_convention
from qdot.exercises.robots.library import FILE_EXTENSIONS, find_robot_path, is_in_library, list_robots
from qdot.exercises.robots.robot_file import read_robot_file
from qdot.exercises.robots.robot_text import write_robot_text
from qdot.exercises.short_questions import SHORT_QUESTIONS
from qdot.grader.cli.options import (
    NO_FOLDER_HINT,
    ConventionOption,
    JsonOption,
    TwistOption,
    VariationOption,
    name_argument,
    name_option,
)
from qdot.grader.cli.overview import describe_families, describe_family, describe_robots, list_refusals

if TYPE_CHECKING:
    from qdot.exercises.assignment.assignment import Assignment

SHOW_FORMATS = ("text", "latex", "html", "json", "ipynb", "pdf")
SOLVE_FORMATS = ("text", "latex", "json")
QUESTIONS_HELP = "Question names separated by commas, or quiz. Default: all that apply, except short ones."


def init(
    folder: Annotated[Path | None, typer.Argument(metavar="DIR", help="The folder to create.")] = None,
    title: Annotated[str, typer.Option(help="The assignment's title. Default: that of the set.")] = "",
    key: Annotated[str, typer.Option(help="File name of the notebooks, without .ipynb.")] = "velocity",
    roster: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Your class: a roster, or an export from Canvas or Moodle.")
    ] = None,
    problems: Annotated[str, name_option("Start with a ready set of problems.", "--set", names=SETS)] = DEFAULT_SET,
    list_sets: Annotated[bool, typer.Option("--list", help="List the sets and exit.")] = False,
) -> None:
    """Create a new assignment folder.

    It contains assignment.toml, roster.csv, .gitignore, a secret, a README and the folder submitted. Edit
    assignment.toml and roster.csv, then run `qdot generate DIR`. Existing files are not overwritten.

    Examples:
      qdot init homework
          a first week with a problem of each kind
      qdot init homework --set singularities --roster canvas.csv
          a ready-made set, for a class from Canvas
      qdot init --list
          list the sets
    """
    if list_sets:
        for problem_set in SETS.values():
            print_result(f"{problem_set.name:<18} {problem_set.title}: {problem_set.purpose}")
            size = f"{problem_set.problem_count} problems, {problem_set.total_points:g} points"
            print_result(f"{'':<18} {size}, about {problem_set.minutes} minutes")
        return
    if folder is None:
        raise QdotError("give the folder to create, as in 'qdot init homework'; 'qdot init --list' lists the sets")
    from qdot.exercises.assignment.assignment import read_roster
    from qdot.exercises.assignment.release import init_assignment

    chosen_set = find_set(problems)
    init_assignment(folder, title or chosen_set.title, key, roster=roster, problem_set=chosen_set)
    outcome, next_step = f"created {folder}", f"put your class into {folder / 'roster.csv'}"
    if roster is not None:
        outcome, next_step = f"{outcome} for {count_noun(len(read_roster(roster)), 'student')}", "edit assignment.toml"
    print_result(f"{outcome}: {next_step}, then run: qdot generate {folder}")


def families(
    name: Annotated[
        str,
        name_argument("NAME", "A family, a real robot or a file: which questions apply to it.", FAMILIES, list_robots),
    ] = "",
    convention: Annotated[str, name_option(f"Convention of NAME: {', '.join(CONVENTIONS)}.", names=CONVENTIONS)] = "",
    as_json: JsonOption = False,
) -> None:
    """List the robot families and the questions for each.

    The difficulty, from 0 to 4, says how much work the arms are by hand. Use a family's name in assignment.toml
    (family = "planar-2r") or before a seed: `qdot show planar-2r/7`. With the NAME of a family or a real robot (ur5),
    or with your own ROBOT.toml or URDF, lists the questions that apply, and why the others do not. This may take a
    minute.

    Examples:
      qdot families
          all families
      qdot families planar-2r
          one of them: which questions apply, and why the others don't
      qdot families ur5 --convention modified-dh
          a real robot, described by a modified table
    """
    if convention:
        normalize_convention(convention)
        if not name:
            raise QdotError("--convention needs a family or robot, as in 'qdot families ur5 --convention dh'")
    if name:
        family = _find_family(name)
        with show_status(f"finding the questions for {family.name}"):  # takes a minute for long arms
            text = describe_family(family, convention)
            if as_json:
                row = {**_make_family_row(family, convention), "refused": list_refusals(family, convention)}
                text = json.dumps(row, ensure_ascii=False, indent=1)
        print_result(text)
    elif as_json:
        rows = [_make_family_row(family) for family in FAMILIES.values()]
        print_result(json.dumps(rows, ensure_ascii=False, indent=1))
    else:
        print_result(describe_families())


def _find_family(name: str) -> Family:
    """Return a registered family, or the family made from a robot or a robot file. Raises QdotError."""
    if name not in FAMILIES and (name.lower().endswith(FILE_EXTENSIONS) or Path(name).is_file() or is_in_library(name)):
        path = find_robot_path(name)
        robot = read_robot_file(path)
        for message in robot.notes:
            note(message)
        return read_robot_family(path, robot)
    return look_up_family(name)


def _make_family_row(family: Family, convention: str = "") -> dict[str, Any]:
    listing = find_listing(family, convention)
    return {
        "name": family.name, "title": family.title, "source": family.source, "joints": listing.kinds or "varied",
        "questions": list(listing.questions),
        "difficulty": listing.band_range[1], "difficulties": list(listing.band_range),
    }  # fmt: skip


def questions(as_json: JsonOption = False) -> None:
    """List all questions.

    They follow the chapter's order, each with its equation; the short questions for quizzes come last.
    Use their names in assignment.toml: questions = ["position", "jacobian"].

    Examples:
      qdot questions
          all questions, in the chapter's order
    """
    if as_json:
        rows = [
            {"name": name, "title": question.title, "source": question.source, "points": question.points,
             "needs": question.prerequisites, "form": question.form}
            for name, question in ALL_QUESTIONS.items()
        ]  # fmt: skip
        print_result(json.dumps(rows, ensure_ascii=False, indent=1))
        return
    for name, question in ALL_QUESTIONS.items():
        if name == next(iter(SHORT_QUESTIONS)):
            print_result('\nShort questions for quizzes; questions = "quiz" uses one of each form:\n')
        print_result(f"{name:<24} {question.title} ({question.source}{'; ' if question.form else ''}{question.form})")


def show(
    problem: Annotated[
        str, name_argument("PROBLEM", "FAMILY/SEED, as in planar-2r/7, or an assignment folder.", FAMILIES, suffix="/1")
    ],
    solution: Annotated[bool, typer.Option("--solution", help="Add reference answers and worked steps.")] = False,
    format: Annotated[
        str, name_option(f"Output format: {', '.join(SHOW_FORMATS)}.", "--format", "-f", names=SHOW_FORMATS)
    ] = "text",
    asked_questions: Annotated[
        str | None,
        name_option(QUESTIONS_HELP, "--questions", names=[*ALL_QUESTIONS, "quiz"], metavar="NAMES", separator=","),
    ] = None,
    hints: Annotated[bool, typer.Option("--hints", help="Add three hints to every question.")] = False,
    variation: VariationOption = "",
    convention: ConventionOption = "",
    twist_order: TwistOption = "",
    student: Annotated[
        str, typer.Option("--student", metavar="ID", help="With an assignment folder: show this student's problems.")
    ] = "",
) -> None:
    """Show a problem, or an assignment with one student's numbers.

    Prints the statement, the figure and the questions. --hints adds three hints to each question, from a gentle nudge
    to an intermediate result; in HTML and notebooks, students open them one by one (JSON always has them). --solution
    adds the answers and their derivations.
    The same FAMILY/SEED shows the same problem on every machine; FAMILY/SEED@VARIATION is short for --variation,
    FAMILY/SEED@CONVENTION for --convention, and FAMILY/SEED@v-omega for --twist-order.

    For the folder of an assignment, the problems are those of a made-up student, who is not on the roster. --student
    shows the problems of a student on the roster.

    Examples:
      qdot show planar-2r/7
          a problem as students see it
      qdot show homework --solution
          a preview of an assignment
      qdot show homework --format pdf > preview.pdf
          the same on paper
      qdot show planar-2r/7 --solution
          with answers and worked steps
      qdot show elbow-3r/3@full --questions jacobian,determinant --format html > problem.html
          two questions
    """
    check_choice(format, SHOW_FORMATS, "--format")
    if Path(problem).is_dir():
        problem_options = asked_questions, variation, convention, twist_order
        _preview_assignment(Path(problem), student, solution, format, hints, *problem_options)
        return
    if format == "pdf":
        raise QdotError("--format pdf needs the folder of an assignment; for one problem, use html or latex")
    if student:
        raise QdotError("--student needs the folder of an assignment, as in 'qdot show homework --student ID'")
    identity = ProblemId.parse(problem, NO_FOLDER_HINT)
    identity = identity.with_variation(variation).with_convention(convention, twist_order)
    if asked_questions is not None:
        names = tuple(name.strip() for name in asked_questions.split(","))
        if not any(names):
            raise QdotError("--questions is empty; leave it out to use all questions that apply")
        if asked_questions == "quiz":
            names = select_quiz_questions(identity.family, identity.convention)
        identity = replace(identity, questions=names)
    generated_problem = make_problem(identity)
    certificate = qdot.certify(generated_problem).as_json() if format == "json" else None
    print_result(qdot.show(generated_problem, solution, format, certificate, hints))


SAMPLE_STUDENT = "preview"
"""The identifier of the made-up student of a preview; no roster has it, because its problems are not secret."""


def _preview_assignment(
    folder: Path, student: str, solution: bool, format: str, hints: bool, *problem_options: str | None
) -> None:  # fmt: skip
    """Print the problems of an assignment for one student. Raises QdotError for options that belong to a problem."""
    if any(problem_options):
        raise QdotError(
            "--questions, --variation, --convention and --twist-order apply to a single problem; "
            "for a class, edit assignment.toml"
        )
    from qdot.exercises.assignment.assignment import load_assignment
    from qdot.exercises.notebook.problem_formats import show_assignment

    assignment = load_assignment(folder, is_preview=not student)
    for message in assignment.notes:
        note(message)
    identifier = assignment.find_student(student).id if student else SAMPLE_STUDENT
    problems = assignment.generate_problems(identifier)
    if format == "text":
        print_result("\n".join((*_describe_settings(assignment), "")))
    if format != "pdf":
        has_hints = hints or assignment.hints
        print_result(show_assignment(assignment.title, problems, solution, format, has_hints, assignment.site))
        return
    from qdot.exercises.exports.paper import make_pdf_preview

    if sys.stdout.isatty():
        raise QdotError(f"write the PDF into a file: qdot show {folder} --format pdf > preview.pdf")
    preview = replace(assignment, hints=hints or assignment.hints)
    sys.stdout.buffer.write(make_pdf_preview(preview, identifier, [problem for _, problem in problems], solution))


def _describe_settings(assignment: "Assignment") -> Iterator[str]:
    """Yield lines on the names p1 and p1.position, on the points for follow-through, and on the link to the site."""
    from qdot.exercises.notebook.notebook import make_check_page_address

    slots = assignment.slots
    name, question = slots[0].name, slots[0].questions[0]
    problems = f"{name} is the problem" if len(slots) == 1 else f"{name} to {slots[-1].name} are the problems"
    example = f"{name}.{question} is the question {question} of {name}"
    yield f"{problems}, in the order of the [[problem]] tables in assignment.toml; {example}"
    share = float(assignment.follow_through)
    earned = f"{100 * share:g} % of its points" if share else "no points"
    subject = "an answer that follows from the student's own wrong earlier answer"
    yield f"{subject} earns {earned} (follow_through = {share:g})"
    if assignment.site:
        yield f"notebooks link to {make_check_page_address(assignment.site)}, where students see how answers are read"


def robots(as_json: JsonOption = False) -> None:
    """List the real robots that `qdot solve NAME` knows.

    Capital letters and hyphens in a name don't matter. To use a robot in assignment.toml, write robot = "panda". `qdot
    solve panda --convert dh > arm.toml` writes it to a file that you can edit.

    Examples:
      qdot robots
          all real robots, with the source of their data
    """
    if as_json:
        print_result(json.dumps([asdict(robot) for robot in list_robots().values()], ensure_ascii=False, indent=1))
    else:
        print_result(describe_robots())


def solve(
    robot: Annotated[
        str, name_argument("ROBOT", "Your arm as ROBOT.toml or URDF, or the name of a real robot (panda).", list_robots)
    ],
    format: Annotated[
        str, name_option(f"Output format: {', '.join(SOLVE_FORMATS)}.", "--format", "-f", names=SOLVE_FORMATS)
    ] = "text",
    tip: Annotated[str, typer.Option(metavar="LINK", help="URDF: the last link, if the robot has several ends.")] = "",
    base: Annotated[str, typer.Option(metavar="LINK", help="URDF: the link at which the chain begins.")] = "",
    convert: Annotated[
        str,
        name_option(f"Only write the arm as ROBOT.toml, in a convention: {', '.join(CONVENTIONS)}.", names=CONVENTIONS),
    ] = "",
    time: Annotated[
        str, typer.Option(metavar="SECONDS", help=f"Maximum processor time in seconds, {MIN_SECONDS:g} or more.")
    ] = f"{DEFAULT_SECONDS:g}",
) -> None:
    """Derive the velocity kinematics of your own arm or a real one.

    Derives the position, the Jacobian in two ways, the determinant and the singularities. ROBOT.toml has a name,
    optionally task = ["vx", "vy"] and point = "O3" or [x, y, z], and a [[joint]] for each row of the standard DH table:
    kind = "R" or "P", theta, d, a, alpha; lengths in metres, angles in radians. With convention = "modified-dh", the
    rows are those of the modified table (Craig). With convention = "screws", joints are described by their axes:
    docs/robots.md.

    In JSON, `jacobian` is that of the point, 3 x n, and `geometric_jacobian` is 6 x n. `determinant` and `singular`
    belong to the rows named in `task`. `determinant` is null if these rows are not square. `singular` is null if they
    have less than full rank in every configuration, and empty if they always have full rank; `note` explains this in
    words. Arms described by screw axes have `space_jacobian` and `body_jacobian`.

    Results are printed as soon as they are ready. --time or Ctrl-C ends the derivation early; the output then says what
    is missing, in JSON as the list `missing`.

    Examples:
      qdot solve arm.toml
          your own arm: position, Jacobian, determinant, singularities
      qdot solve panda --time 300
          a real robot, with more time
      qdot solve panda --convert dh > arm.toml
          write it to a file that you can edit
    """
    check_choice(format, SOLVE_FORMATS, "--format")
    from qdot.exercises.solve.time_limited import write_solution

    seconds = parse_seconds(time)
    parsed_robot = read_robot_file(find_robot_path(robot), tip, base)
    for message in parsed_robot.notes:
        note(message)
    if convert:
        check_choice(convert, CONVENTIONS, "--convert")
        if format != "text":
            raise QdotError("--convert writes a ROBOT.toml and --format writes what is derived; give only one of them")
        print_result(write_robot_text(parsed_robot, convert).rstrip())
        return
    write_solution(parsed_robot, format, seconds, print_result, show_status)
