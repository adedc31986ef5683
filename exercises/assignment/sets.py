"""Ready-made sets of problems, from which `qdot init --set NAME` makes an assignment: templates/init/sets/NAME.toml.

Variation and difficulty increase within a set, and its last part asks for the meaning of a result.
"""

import tomllib
from dataclasses import dataclass
from functools import cached_property

from qdot.exercises.common.errors import unknown
from qdot.exercises.quizzes import ASKED
from qdot.exercises.writing.render import template_folder


@dataclass(frozen=True)
class ProblemSet:
    """A set: its name, a title for the assignment, its purpose, and the minutes it should take.

    `note` tells the staff how to hand it out, if not only as notebooks; `variation` is the default of its problems.
    """

    name: str
    title: str
    purpose: str
    minutes: int
    note: str = ""
    variation: str = ""

    @cached_property
    def text(self) -> str:
        """Its [[problem]] tables for assignment.toml."""
        return (template_folder() / "init" / "sets" / f"{self.name}.toml").read_text(encoding="utf-8")

    @property
    def problems(self) -> int:
        """The number of its problems."""
        return len(tomllib.loads(self.text)["problem"])

    @property
    def points(self) -> float:
        """The total points of its parts."""
        return sum(
            sum(entry.get("points") or (ASKED[name].points for name in entry["questions"]))
            for entry in tomllib.loads(self.text)["problem"]
        )


DEFAULT_SET = "overview"

SETS = {
    problem_set.name: problem_set
    for problem_set in (
        ProblemSet(DEFAULT_SET, "Velocity kinematics", "a first week with a problem of each kind", 120),
        ProblemSet(
            "chapter", "Examples 6.1 to 6.4", "the chapter's examples, for class and practice; numbers differ", 120,
            variation="chapter",
        ),
        ProblemSet("first-jacobians", "First Jacobians", "position and Jacobian by differentiation", 75),
        ProblemSet("propagation", "Velocity propagation", "axes, position vectors, geometric Jacobian", 90),
        ProblemSet("inverse-velocity", "Inverse velocity", "from the velocity of P to joint rates", 100),
        ProblemSet("singularities", "Singularities", "where they are, of which type, and what they cost", 80),
        ProblemSet("redundant", "Redundant arms", "more joints than the task needs", 100),
        ProblemSet("six-joints", "Wrists and arms of six joints", "wrists, and arms that have one", 120),
        ProblemSet("quiz", "Weekly quiz", "eight short questions, answered by letters and numbers", 15),
        ProblemSet(
            "mid-term", "Mid-term", "three problems on paper, without a computer", 60,
            "qdot export . --to pdf --sheet exam     # the exam for everybody on the roster; --sheet key for you",
        ),
        ProblemSet(
            "exam", "Examination", "four problems in an hour and a half, in notebooks or on paper", 90,
            "qdot export . --to pdf --sheet exam --versions 4     # versions A to D for an exam hall",
        ),
    )
}  # fmt: skip
"""All sets by name; the first is the default of `qdot init`."""


def find_set(name: str) -> ProblemSet:
    """Return the set with this name. Raises QdotError if there is none."""
    if name not in SETS:
        raise unknown("set", name, list(SETS))
    return SETS[name]
