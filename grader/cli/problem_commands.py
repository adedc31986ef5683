"""The commands about arms and problems: init, families, questions, show, robots, solve."""

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from qdot import ASKED, FAMILIES, ProblemId, QdotError
from qdot import generate as make_problem
from qdot import show as show_problem
from qdot.exercises.arm.chain import CONVENTIONS
from qdot.exercises.arm.library import FILE_EXTENSIONS, is_in_library, robot_path
from qdot.exercises.arm.library import robots as library
from qdot.exercises.arm.robot_file import read_robot_file
from qdot.exercises.arm.robot_text import robot_text
from qdot.exercises.assignment.sets import DEFAULT_SET, SETS, find_set
from qdot.exercises.common.completion import complete_names
from qdot.exercises.common.console import VariationOption, check_choice, note, progress, say, show_status
from qdot.exercises.common.time_limit import DEFAULT_SECONDS as SECONDS
from qdot.exercises.common.time_limit import MIN_SECONDS, parse_seconds
from qdot.exercises.families import Family
from qdot.exercises.families.own import read_robot_family
from qdot.exercises.generation import find_listing, look_up_family, sample_chain, select_quiz_questions
from qdot.exercises.problem.problem import find_convention
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.quizzes import QUIZZES
from qdot.grader.cli.options import ConventionOption, JsonOption, TwistOrderOption, name_option
from qdot.grader.cli.overview import describe_families, describe_family, describe_robots, list_refusals

SHOW_FORMATS = ("text", "latex", "html", "json", "ipynb")
SOLVE_FORMATS = ("text", "latex", "json")


def init(
    folder: Annotated[Path | None, typer.Argument(metavar="DIR", help="The folder to make.")] = None,
    title: Annotated[str, typer.Option(help="The assignment's title; default: the set's.")] = "",
    key: Annotated[str, typer.Option(help="File name of the notebooks, without .ipynb.")] = "velocity",
    roster: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Your class: a roster, or what Canvas or Moodle exports.")
    ] = None,
    problems: Annotated[
        str, name_option("Begin with a ready-made set of problems.", "--set", names=SETS)
    ] = DEFAULT_SET,
    list_sets: Annotated[bool, typer.Option("--list", help="List the sets, and make nothing.")] = False,
) -> None:
    """Make a new assignment folder.

    In it are assignment.toml, roster.csv, .gitignore, a secret, a README and the folder submitted. Edit
    assignment.toml and roster.csv, then run `qdot generate DIR`. Nothing that is there already is overwritten.

    Examples:
      qdot init homework
          a first week with a problem of each kind
      qdot init homework --set singularities --roster canvas.csv
          a ready-made set, for a class from Canvas
      qdot init --list
          which sets there are
    """
    if list_sets:
        for problem_set in SETS.values():
            say(f"{problem_set.name:<18} {problem_set.title}: {problem_set.purpose}")
            say(
                f"{'':<18} {problem_set.problems} problems, {problem_set.points:g} points, "
                f"about {problem_set.minutes} minutes"
            )
        return
    if folder is None:
        raise QdotError("name the folder to make, as in 'qdot init homework', or list the sets with 'qdot init --list'")
    from qdot.exercises.assignment.release import init_assignment

    chosen_set = find_set(problems)
    init_assignment(folder, title or chosen_set.title, key, roster=roster, problems=chosen_set)
    next_step = f"put your class into {folder / 'roster.csv'}" if roster is None else "edit assignment.toml"
    say(f"made {folder}: {next_step}, then run: qdot generate {folder}")


def families(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="One of them, a real robot or a file: what it can be asked, and why not the rest.",
            autocompletion=complete_names(FAMILIES, library),
        ),
    ] = "",
    convention: Annotated[
        str, name_option(f"Of one of them: how its arms are told, {', '.join(CONVENTIONS)}.", names=CONVENTIONS)
    ] = "",
    as_json: JsonOption = False,
) -> None:
    """List the robot families and what each can be asked.

    The difficulty is a step from 0 to 4 of a scale: how much there is to work out for such an arm by hand. A
    family's name goes into assignment.toml (family = "planar-2r") and before a seed: `qdot show planar-2r/7`. With a
    NAME it is told of this family what it can be asked, question by question, and in a few words why not the rest; so
    it is of a real robot (ur5) and of your own ROBOT.toml or URDF, which may take a minute.

    Examples:
      qdot families
          all arms, and what each can be asked
      qdot families planar-2r
          one of them: why not the rest
      qdot families ur5 --convention modified-dh
          a real robot, told by a modified table
    """
    if convention:
        find_convention(convention)
        if not name:
            raise QdotError("--convention is for one family or robot; name it, as in 'qdot families ur5'")
    if name:
        family = _find_family(name)
        _derive_questions(family, convention)
        row = {**_family_as_json(family, convention), "refused": list_refusals(family, convention)} if as_json else {}
        say(json.dumps(row, ensure_ascii=False, indent=1) if as_json else describe_family(family, convention))
    elif as_json:
        say(json.dumps([_family_as_json(family) for family in FAMILIES.values()], ensure_ascii=False, indent=1))
    else:
        say(describe_families())


def _find_family(name: str) -> Family:
    """Return the family with this name, or that of a robot file or of a robot in the library. Raises QdotError."""
    if name not in FAMILIES and (name.lower().endswith(FILE_EXTENSIONS) or Path(name).is_file() or is_in_library(name)):
        path = robot_path(name)
        robot = read_robot_file(path)
        for message in robot.notes:
            note(message)
        return read_robot_family(path, robot)
    return look_up_family(name)


def _derive_questions(family: Family, convention: str) -> None:
    """Find out which questions apply to an arm, with a progress bar, because this takes a minute for long arms.

    The results are cached. For registered families in their own convention, they are listed already.
    """
    if family.has_varied_structure or not (family.robot_argument or convention):
        return
    chain = sample_chain(ProblemId(family.name, 0, convention=convention), family)
    with progress(f"looking at what {family.name} can be asked", len(QUESTIONS)) as counter:
        for question in QUESTIONS.values():
            question.find_obstacle(chain)
            counter.step()


def _family_as_json(family: Family, convention: str = "") -> dict[str, Any]:
    listing = find_listing(family, convention)
    return {
        "name": family.name, "title": family.title, "source": family.source, "joints": listing.kinds or "varied",
        "questions": list(listing.questions), "difficulty": listing.steps[1], "difficulties": list(listing.steps),
    }  # fmt: skip


def questions(as_json: JsonOption = False) -> None:
    """List the questions that can be asked.

    They stand in the chapter's order, with the equation that each is about; behind them the short ones for quizzes.
    Their names go into assignment.toml: questions = ["position", "jacobian"].

    Examples:
      qdot questions
          all questions, in the chapter's order
    """
    if as_json:
        keys = ("name", "title", "source", "points", "needs", "form")
        rows = [{key: getattr(question, key) for key in keys} for question in ASKED.values()]
        say(json.dumps(rows, ensure_ascii=False, indent=1))
        return
    for name, question in ASKED.items():
        if name == next(iter(QUIZZES)):
            say('\nShort questions for quizzes; questions = "quiz" asks one of each form:\n')
        say(f"{name:<24} {question.title} ({question.source}{'; ' if question.form else ''}{question.form})")


def show(
    problem: Annotated[
        str,
        typer.Argument(
            metavar="PROBLEM",
            help="FAMILY/SEED, as in planar-2r/7.",
            autocompletion=complete_names(FAMILIES, suffix="/1"),
        ),
    ],
    solution: Annotated[bool, typer.Option("--solution", help="Add the reference and the worked steps.")] = False,
    format: Annotated[
        str, name_option(f"One of {', '.join(SHOW_FORMATS)}.", "--format", "-f", names=SHOW_FORMATS)
    ] = "text",
    ask: Annotated[
        str | None,
        typer.Option(
            "--questions",
            help="Names with commas between, or quiz; default: all that apply but short ones.",
            autocompletion=complete_names(ASKED, ["quiz"], separator=","),
        ),
    ] = None,
    hints: Annotated[bool, typer.Option("--hints", help="Add three hints to every part.")] = False,
    variation: VariationOption = "",
    convention: ConventionOption = "",
    twist_order: TwistOrderOption = "",
) -> None:
    """Show one problem, with hints or solution if wanted.

    It has statement, figure and parts; with --hints three hints a part, from gentle to nearly there, in HTML and
    notebooks to be opened one by one (JSON always has them); with --solution the answers and how they are derived.
    The same FAMILY/SEED shows the same problem on every machine; FAMILY/SEED@VARIATION is short for --variation,
    FAMILY/SEED@CONVENTION for --convention, and FAMILY/SEED@v-omega for --twist-order.

    Examples:
      qdot show planar-2r/7
          a problem as a student has it
      qdot show planar-2r/7 --solution
          with answers and worked steps
      qdot show elbow-3r/3@full --questions jacobian,determinant --format html > problem.html
          two questions
    """
    check_choice(format, SHOW_FORMATS, "--format")
    identity = ProblemId.parse(problem).with_variation(variation).with_convention(convention, twist_order)
    if ask is not None:
        identity = replace(
            identity,
            questions=select_quiz_questions(identity.family, identity.convention)
            if ask == "quiz"
            else _split_names(ask),
        )
    generated = make_problem(identity)
    certificate = None
    if format == "json":
        from qdot import certify

        certificate = certify(generated).as_json()
    say(show_problem(generated, solution, format, certificate, hints))


def _split_names(text: str) -> tuple[str, ...]:
    """Return the names in a text with commas between them. Raises QdotError if there are none."""
    names = tuple(name.strip() for name in text.split(","))
    if not any(names):
        raise QdotError("--questions names no question; leave the option out to ask all that apply")
    return names


def robots(as_json: JsonOption = False) -> None:
    """List the real robots that `qdot solve NAME` knows.

    Capital letters and hyphens in a name don't count. robot = "panda" in assignment.toml asks about one, and `qdot
    solve panda --convert dh > arm.toml` makes a file of it that you can change.

    Examples:
      qdot robots
          all real robots, with who publishes their numbers
    """
    if as_json:
        say(json.dumps([asdict(robot) for robot in library().values()], ensure_ascii=False, indent=1))
    else:
        say(describe_robots())


def solve(
    robot: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT",
            help="Your arm: ROBOT.toml or a URDF; or the name of a real one: panda.",
            autocompletion=complete_names(library),
        ),
    ],
    format: Annotated[
        str, name_option(f"One of {', '.join(SOLVE_FORMATS)}.", "--format", "-f", names=SOLVE_FORMATS)
    ] = "text",
    tip: Annotated[str, typer.Option(metavar="LINK", help="URDF: the link at the end, if there are several.")] = "",
    convert: Annotated[
        str, name_option(f"Write the arm as ROBOT.toml in a convention: {', '.join(CONVENTIONS)}.", names=CONVENTIONS)
    ] = "",
    time: Annotated[
        str, typer.Option(metavar="SECONDS", help=f"Processor time after which it ends, {MIN_SECONDS:g} or more.")
    ] = f"{SECONDS:g}",
) -> None:
    """Derive all the book would for your own arm or a real one.

    That is position, Jacobian both ways, determinant and singularities. ROBOT.toml has a name, optionally task =
    ["vx", "vy"] and point = "O3" or [x, y, z], and a [[joint]] for each row of the standard DH table: kind = "R" or
    "P", theta, d, a, alpha; lengths in metres, angles in radians. With convention = "modified-dh" the rows are those of
    the modified table (Craig), with convention = "screws" joints are given by their axes: docs/robots.md.

    In JSON, `jacobian` is that of the point, 3 x n, and `geometric_jacobian` 6 x n; of the latter, the rows that `task`
    names are those whose `determinant` and `singular` follow. `determinant` is null where these are not square.
    `singular` is null where they have less than full rank in every configuration, and empty where they have full rank
    in every one; `note` says so in words. Arms that are told by their axes have `space_jacobian` and `body_jacobian`.

    Results are written as they are ready. With --time, or by Ctrl-C, it ends earlier, and says what is missing; JSON
    has `missing` then, a list of what was not worked out.

    Examples:
      qdot solve arm.toml
          your own arm: position, Jacobian, determinant, singularities
      qdot solve panda --time 300
          a real one, with more time
      qdot solve panda --convert dh > arm.toml
          as a file of your own
    """
    check_choice(format, SOLVE_FORMATS, "--format")
    from qdot.exercises.solve.time_limited import write_solution

    seconds = parse_seconds(time)
    parsed_robot = read_robot_file(robot_path(robot), tip)
    for message in parsed_robot.notes:
        note(message)
    if convert:
        check_choice(convert, CONVENTIONS, "--convert")
        if format != "text":
            raise QdotError("--convert writes a ROBOT.toml, and --format is for what is derived; give one of both")
        say(robot_text(parsed_robot, convert).rstrip())
        return
    write_solution(parsed_robot, format, seconds, say, show_status)
