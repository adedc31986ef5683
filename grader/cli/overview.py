"""Makes the texts of `qdot families` and `qdot robots`: the families, the questions for one of them, the robots."""

import textwrap
from collections.abc import Callable

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.library import robots
from qdot.exercises.common.errors import count_noun
from qdot.exercises.families import FAMILIES, Family
from qdot.exercises.generation import find_listing, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS

LINE_WIDTH = 100

ARM_KINDS: tuple[tuple[str, Callable[[Chain], bool]], ...] = (
    ("Arms of five to seven joints", lambda chain: chain.n >= 5),
    ("Wrists", lambda chain: not chain.linear_axes),
    ("Planar arms", lambda chain: len(chain.linear_axes) < 3),
    ("Spatial arms with prismatic joints", lambda chain: bool(chain.prismatic_joints)),
    ("Spatial arms of revolute joints", lambda _: True),
)
"""The kinds of arms, each with a test: an arm is of the first kind whose test it passes."""
RANDOM_KIND = "Arms with a random structure"
"""The kind of the families with random structures."""
KIND_ORDER = (
    "Planar arms", "Spatial arms of revolute joints", "Spatial arms with prismatic joints", "Wrists",
    "Arms of five to seven joints", RANDOM_KIND,
)  # fmt: skip
"""The kinds of arms in the order in which they are listed."""


def group_families() -> dict[str, list[Family]]:
    """Return the families by kind of arm, in the order in which they are shown."""
    families_by_kind: dict[str, list[Family]] = {name: [] for name in KIND_ORDER}
    for family in FAMILIES.values():
        families_by_kind[_find_kind(family)].append(family)
    return families_by_kind


def _find_kind(family: Family) -> str:
    if family.has_varied_structure:
        return RANDOM_KIND
    chain = sample_chain(ProblemId(family.name, 0), family)
    return next(name for name, is_of_kind in ARM_KINDS if is_of_kind(chain))


def describe_families() -> str:
    """Return a text that lists all families by kind, each with the number of questions that apply to it."""
    lines = ["The families: joints, difficulty from 0 to 4, title and source:"]
    for kind, families in group_families().items():
        lines += ["", kind, ""]
        for family in families:
            listing = find_listing(family.name)
            prefix = f"  {family.name:<20}{listing.kinds or 'varied':<9}{listing.difficulty:<8}"
            lines += _wrap(prefix, f"{family.title}; {family.source}; {count_noun(len(listing.questions), 'question')}")
    lines += ["", "The questions for one of them: qdot families NAME. Drawings of all: docs/families.md"]
    return "\n".join(lines)


def describe_robots() -> str:
    """Return a text that lists the robots of the library: name, joints, convention, description and source."""
    lines = ["Real robots: name, joints, convention, title and source of the data:", ""]
    for robot in robots().values():
        prefix = f"  {robot.name:<16}{robot.joints:<9}{robot.convention:<13}"
        lines += _wrap(prefix, f"{robot.title}; {robot.source}")
    lines += ["", "Everything about one of them: qdot solve NAME. As a file: qdot solve NAME --convert dh > arm.toml"]
    return "\n".join(lines)


def describe_family(family: Family, convention: str = "") -> str:
    """Return a text about a family or robot: what it is, which questions apply to its arms, and why the rest don't.

    The arms are described in the named convention or, without one, in the convention of the family or the robot's file.
    """
    listing = find_listing(family, convention)
    joints = f"joints {listing.kinds}" if listing.kinds else "joints of several kinds"
    lines = [f"{family.name}: {family.title}; {family.source}", f"{joints}, difficulty {listing.difficulty}", ""]
    lines += _wrap("questions        ", ", ".join(name for name in QUESTIONS if name in listing.questions))
    by_reason: dict[str, list[str]] = {}
    for name, reason in list_refusals(family, convention).items():
        by_reason.setdefault(reason, []).append(name)
    if by_reason:
        lines += ["", f"not applicable{' to arms such as this one' if family.has_varied_structure else ''}"]
    for reason, names in by_reason.items():
        lines += _wrap("  ", f"{', '.join(names)}: {reason}")
    if family.robot_argument:
        solve = f"qdot solve {family.robot_argument}"
        advice = f"To use it, set robot in assignment.toml. Everything derived for it: {solve}"
    else:
        problem = f"{family.name}/1@{convention}" if convention else f"{family.name}/1"
        advice = f"Short questions for quizzes: qdot questions. An example: qdot show {problem} --solution"
    lines += ["", advice]
    return "\n".join(lines)


def list_refusals(family: Family, convention: str = "") -> dict[str, str]:
    """Return the questions that don't apply to a family's arms in a convention, each with the reason."""
    refused_questions = [name for name in QUESTIONS if name not in find_listing(family, convention).questions]
    chain = sample_chain(ProblemId(family.name, 0, convention=convention), family)
    general_reason = "does not apply to other arms of the family"
    return {name: QUESTIONS[name].find_obstacle(chain) or general_reason for name in refused_questions}


def _wrap(prefix: str, text: str) -> list[str]:
    """Return a text in lines, indented under the prefix `prefix` of the first line.

    Words with hyphens are not broken, because they are names.
    """
    return textwrap.wrap(
        text, LINE_WIDTH, initial_indent=prefix, subsequent_indent=" " * len(prefix), break_on_hyphens=False,
        break_long_words=False,
    )  # fmt: skip
