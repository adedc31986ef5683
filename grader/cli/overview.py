"""The families for `qdot families`, by kind of arm, what can be asked of one, and the real robots."""

import textwrap
from collections.abc import Callable

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.library import robots
from qdot.exercises.families import FAMILIES, Family
from qdot.exercises.generation import listing_of, sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS

WIDTH = 100

KINDS: tuple[tuple[str, Callable[[Chain], bool]], ...] = (
    ("Arms of five to seven joints", lambda chain: chain.n >= 5),
    ("Wrists", lambda chain: not chain.linear_rows),
    ("Planar arms", lambda chain: len(chain.linear_rows) < 3),
    ("Spatial arms with slides", lambda chain: any(joint.kind == "P" for joint in chain.joints)),
    ("Spatial arms of revolute joints", lambda _: True),
)
"""Kinds of arms: an arm is of the first kind whose test it passes."""
RANDOM = "Arms whose structure is drawn, too"
ORDER = (
    "Planar arms", "Spatial arms of revolute joints", "Spatial arms with slides", "Wrists",
    "Arms of five to seven joints", RANDOM,
)  # fmt: skip


def kinds() -> dict[str, list[Family]]:
    """Return the families by kind of arm, in the order in which they are shown."""
    kinds: dict[str, list[Family]] = {name: [] for name in ORDER}
    for family in FAMILIES.values():
        kinds[_kind(family)].append(family)
    return kinds


def _kind(family: Family) -> str:
    if family.varied:
        return RANDOM
    chain = sample_chain(ProblemId(family.name, 0), family)
    return next(name for name, is_such in KINDS if is_such(chain))


def overview() -> str:
    """Return all families by kind, each with how many questions can be asked of it."""
    lines = ["The families: joints, difficulty from 0 to 4, and what they are an example of:"]
    for kind, families in kinds().items():
        lines += ["", kind, ""]
        for family in families:
            about = listing_of(family.name)
            first = f"  {family.name:<20}{about.kinds or 'varied':<9}{about.difficulty:<8}"
            lines += _wrap(first, f"{family.title}; {family.source}; {len(about.questions)} questions")
    lines += ["", "What can be asked of one of them: qdot families NAME. Drawings of all: docs/families.md"]
    return "\n".join(lines)


def robots_overview() -> str:
    """Return the robots of the library: name, joints, convention, what it is and its source."""
    lines = ["Real robots: name, joints, convention, what it is, and where its numbers are from:", ""]
    for robot in robots().values():
        first = f"  {robot.name:<16}{robot.joints:<9}{robot.convention:<13}"
        lines += _wrap(first, f"{robot.title}; {robot.source}")
    lines += ["", "All that is derived of one: qdot solve NAME. As a file: qdot solve NAME --convert dh > arm.toml"]
    return "\n".join(lines)


def describe_family(family: Family, convention: str = "") -> str:
    """Describe a family, or a robot: what it is, what can be asked of its arms, and why the rest can't be asked.

    The arms are described in a convention, if one is named, else in that of the family or the robot's file.
    """
    about = listing_of(family, convention)
    joints = f"joints {about.kinds}" if about.kinds else "joints of several kinds"
    lines = [f"{family.name}: {family.title}; {family.source}", f"{joints}, difficulty {about.difficulty}", ""]
    lines += _wrap("can be asked     ", ", ".join(name for name in QUESTIONS if name in about.questions))
    by_reason: dict[str, list[str]] = {}
    for name, why in refusals(family, convention).items():
        by_reason.setdefault(why, []).append(name)
    if by_reason:
        lines += ["", f"can't be asked{' of any, as of this one,' if family.varied else ''}"]
    for why, names in by_reason.items():
        lines += _wrap("  ", f"{', '.join(names)}: {why}")
    if family.robot:
        last = f"Ask about it by robot in assignment.toml. All that is derived of it: qdot solve {family.robot}"
    else:
        problem = f"{family.name}/1@{convention}" if convention else f"{family.name}/1"
        last = f"Short questions for quizzes: qdot questions. One such arm: qdot show {problem} --solution"
    lines += ["", last]
    return "\n".join(lines)


def refusals(family: Family, convention: str = "") -> dict[str, str]:
    """Return why each question that can't be asked of a family's arms in a convention is refused."""
    missing = [name for name in QUESTIONS if name not in listing_of(family, convention).questions]
    chain = sample_chain(ProblemId(family.name, 0, convention=convention), family)
    return {name: QUESTIONS[name].refusal(chain) or "other arms of the family can't be asked" for name in missing}


def _wrap(first: str, text: str) -> list[str]:
    """Return a text in lines, after what the first begins with; words with hyphens are names, and stay whole."""
    return textwrap.wrap(
        text, WIDTH, initial_indent=first, subsequent_indent=" " * len(first), break_on_hyphens=False,
        break_long_words=False,
    )  # fmt: skip
