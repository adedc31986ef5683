"""Write the texts of `qdot families` and `qdot robots`: lists of families and robots, and the questions for an arm."""

import textwrap
from typing import Any

from qdot.exercises.common.errors import count_noun
from qdot.exercises.families import FAMILIES, Family
from qdot.exercises.generation import find_listing, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.robots.library import list_robots

LINE_WIDTH = 100


def group_families_by_heading() -> dict[str, list[Family]]:
    """Map each heading to its families; the headings are in the order of their first families."""
    families_by_heading: dict[str, list[Family]] = {}
    for family in FAMILIES.values():
        families_by_heading.setdefault(_choose_heading(family), []).append(family)
    return families_by_heading


def _choose_heading(family: Family) -> str:
    """Return the heading for a family: the kind of its arms."""
    if family.has_varied_structure:
        return "Arms with a random structure"
    chain = sample_chain(ProblemId(family.name, 0), family)
    if chain.n >= 5:
        return "Arms of five to seven joints"
    if not chain.linear_axes:  # the task has no linear velocities
        return "Wrists"
    if len(chain.linear_axes) < 3:
        return "Planar arms"
    return "Spatial arms with prismatic joints" if chain.prismatic_joints else "Spatial arms of revolute joints"


def describe_families() -> str:
    """Return a text that lists all families under headings, each with the number of questions that apply to it."""
    lines = ["The families: joints, difficulty from 0 to 4, title and source:"]
    for heading, families in group_families_by_heading().items():
        lines += ["", heading, ""]
        for family in families:
            listing = find_listing(family.name)
            prefix = f"  {family.name:<20}{listing.kinds or 'varied':<9}{listing.difficulty:<8}"
            lines += _wrap(prefix, f"{family.title}; {family.source}; {count_noun(len(listing.questions), 'question')}")
    lines += ["", "The questions for one of them: qdot families NAME. Drawings of all: docs/families.md"]
    return "\n".join(lines)


def describe_robots() -> str:
    """Return a text that lists the robots of the library: name, joints, convention, description and source."""
    lines = ["Real robots: name, joints, convention, title and source of the data:", ""]
    for robot in list_robots().values():
        prefix = f"  {robot.name:<16}{robot.joints:<9}{robot.convention:<13}"
        lines += _wrap(prefix, f"{robot.title}; {robot.source}")
    lines += ["", "Everything about one of them: qdot solve NAME. As a file: qdot solve NAME --convert dh > arm.toml"]
    return "\n".join(lines)


def describe_family(family: Family, convention: str = "") -> str:
    """Return a text about a family or robot: joints, difficulty, the questions that apply, and why the others don't.

    The arms are described in `convention`; if it is empty, in the convention of the family or of the robot's file.
    """
    listing = find_listing(family, convention)
    joints = f"joints {listing.kinds}" if listing.kinds else "joints of several kinds"
    lines = [f"{family.name}: {family.title}; {family.source}", f"{joints}, difficulty {listing.difficulty}", ""]
    lines += _wrap("questions        ", ", ".join(name for name in QUESTIONS if name in listing.questions))
    names_by_reason: dict[str, list[str]] = {}
    for name, reason in list_refusals(family, convention).items():
        names_by_reason.setdefault(reason, []).append(name)
    if names_by_reason:
        lines += ["", f"not applicable{' to arms such as this one' if family.has_varied_structure else ''}"]
    for reason, names in names_by_reason.items():
        lines += _wrap("  ", f"{', '.join(names)}: {reason}")
    if family.is_robot:
        solve_command = f"qdot solve {family.robot_argument}"
        advice = f"To use it, set robot in assignment.toml. Everything derived for it: {solve_command}"
    else:
        problem = f"{family.name}/1@{convention}" if convention else f"{family.name}/1"
        advice = f"Short questions for quizzes: qdot questions. An example: qdot show {problem} --solution"
    lines += ["", advice]
    return "\n".join(lines)


def list_refusals(family: Family, convention: str = "") -> dict[str, str]:
    """Map each question that doesn't apply to a family's arms in a convention to the reason."""
    applicable_questions = find_listing(family, convention).questions
    chain = sample_chain(ProblemId(family.name, 0, convention=convention), family)
    default_reason = "can't be asked about other arms of the family"
    refused_questions = [question for name, question in QUESTIONS.items() if name not in applicable_questions]
    return {question.name: question.find_obstacle(chain) or default_reason for question in refused_questions}


def _wrap(prefix: str, text: str) -> list[str]:
    """Return a text in lines: the first line begins with `prefix`, and the others are indented by its length.

    Words with hyphens are not broken, because they are names.
    """
    options: Any = {"break_on_hyphens": False, "break_long_words": False}
    return textwrap.wrap(text, LINE_WIDTH, initial_indent=prefix, subsequent_indent=" " * len(prefix), **options)
