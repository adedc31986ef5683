"""Read the ready-made sets of problems for `qdot init --set NAME` from templates/init/sets.toml.

Within a set, variation and difficulty increase, and the last question asks for the meaning of a result.
"""

import tomllib
from dataclasses import dataclass
from functools import cached_property

from qdot.exercises.common.errors import make_name_error
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.writing.render import find_template_folder


@dataclass(frozen=True)
class ProblemSet:
    """A set of problems: its name, a title for the assignment, its purpose, and the minutes that it should take.

    `note` says how to release a set that is not for notebooks; it is empty for other sets. `variation` is the setting
    in the new assignment.
    """

    name: str
    title: str
    purpose: str
    minutes: int
    note: str = ""
    variation: str = ""

    @cached_property
    def text(self) -> str:
        """The set's [[problem]] tables for assignment.toml."""
        return (find_template_folder() / "init" / "sets" / f"{self.name}.toml").read_text(encoding="utf-8")

    @property
    def problem_count(self) -> int:
        """The number of problems in the set."""
        return len(tomllib.loads(self.text)["problem"])

    @property
    def total_points(self) -> float:
        """The total points of all questions in the set."""
        total: float = 0
        for entry in tomllib.loads(self.text)["problem"]:
            total += sum(entry.get("points") or [ALL_QUESTIONS[name].points for name in entry["questions"]])
        return total


_SETS_TEXT = (find_template_folder() / "init" / "sets.toml").read_text(encoding="utf-8")
SETS = {name: ProblemSet(name, **fields) for name, fields in tomllib.loads(_SETS_TEXT).items()}
"""All sets by name."""
DEFAULT_SET = next(iter(SETS))


def find_set(name: str) -> ProblemSet:
    """Return the set with this name. Raises QdotError if there is none."""
    if name not in SETS:
        raise make_name_error("set", name, list(SETS))
    return SETS[name]
