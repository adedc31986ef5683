"""Solve the chapter's Examples 6.1 to 6.4, and read the errors in the printed chapter from errata.toml."""

import tomllib
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.writing.languages import ENGLISH, catalogue
from qdot.exercises.writing.problem_texts import worked_solution
from qdot.exercises.writing.wording import Wording

ERRATA = Path(__file__).with_name("errata.toml")


def planar_2r() -> Chain:
    """Return the arm of Examples 6.1, 6.2 and 6.4."""
    return sample_chain(ProblemId("planar-2r", 0, variation="chapter"))


def scorbot_arm() -> Chain:
    """Return the arm of Example 6.3: a Scorbot down to the wrist point P."""
    return replace(sample_chain(ProblemId("elbow-3r", 0, variation="chapter")), title="Scorbot, wrist point P")


@dataclass(frozen=True)
class Example:
    """One example of the chapter: its arm, its drawings (docs/examples/KEY.svg), and the title and text of each step.

    `shows_arm` says whether the example shows the arm, and `shows_singularities` whether it shows the singular
    configurations.
    """

    number: str
    title: str
    key: str
    arm: Chain
    steps: tuple[tuple[str, str], ...]
    shows_arm: bool
    shows_singularities: bool

    @property
    def rows(self) -> list[list[str]]:
        """The DH table as LaTeX."""
        return Wording(self.arm).rows

    @property
    def task(self) -> list[str]:
        """The rows of the task as LaTeX."""
        return Wording(self.arm).task


def gettext(message: str) -> str:
    """Return a message unchanged; the call marks it for translation."""
    return message


EXAMPLES = (
    ("6.1", gettext("the planar 2R arm by direct differentiation"), "planar-2r", ("position", "velocity", "jacobian")),
    (
        "6.2",
        gettext("inverse velocity and singularities of the same arm"),
        "planar-2r",
        ("determinant", "inverse-jacobian", "inverse-velocity", "singular-angles"),
    ),
    (
        "6.3",
        gettext("the arm of a Scorbot, down to its wrist point"),
        "scorbot",
        ("position", "jacobian", "determinant", "singular-angles"),
    ),
    (
        "6.4",
        gettext("the planar 2R arm by velocity propagation"),
        "planar-2r",
        ("joint-axes", "position-vectors", "geometric-jacobian", "twist"),
    ),
)
"""Number, title, arm and questions of each example."""


@cache
def examples(language: str = ENGLISH) -> tuple[Example, ...]:
    """Return the chapter's examples with their solutions."""
    words = catalogue(language)
    arms = {"planar-2r": planar_2r(), "scorbot": scorbot_arm()}
    solved: list[Example] = []
    for number, title, key, questions in EXAMPLES:
        steps = tuple((words.question(QUESTIONS[name].title), _solve(arms[key], name, language)) for name in questions)
        is_first_use = all(earlier.key != key for earlier in solved)
        solved.append(
            Example(number, words.gettext(title), key, arms[key], steps, is_first_use, "singular-angles" in questions)
        )
    return tuple(solved)


@dataclass(frozen=True)
class Erratum:
    """A correction of the chapter: its place, the printed and the correct text, the reason, and numbers as evidence.

    `kind` is "wrong", "incomplete" or "lost in the layout". `values` are numbers with their descriptions, at the
    configuration `at`.
    """

    where: str
    kind: str
    printed: str
    right: str
    why: str
    at: str
    values: tuple[tuple[str, str], ...]


@cache
def corrections(language: str = ENGLISH) -> tuple[Erratum, ...]:
    """Return the errors in the printed chapter, with their corrections, from errata.toml."""
    words = catalogue(language)

    def translate(text: str) -> str:
        return words.localize_formulas(words.pgettext("erratum", text))

    return tuple(
        Erratum(
            **{name: translate(text) for name, text in entry.items() if name != "values"},
            values=tuple(
                (translate(description), words.localize_number(translate(value)))
                for description, value in entry["values"]
            ),
        )
        for entry in tomllib.loads(ERRATA.read_text(encoding="utf-8"))["erratum"]
    )


@cache
def _solve(chain: Chain, name: str, language: str) -> str:
    answer, details = QUESTIONS[name].ask(chain, Stream("docs"))
    part = Part(name, name, answer, details=details)
    return worked_solution(Problem(ProblemId(chain.name, 0), _with_family_title(chain), (part,)), part, language)


def _with_family_title(chain: Chain) -> Chain:
    """Return an arm with the title of its family."""
    plain = FAMILIES[chain.name].textbook_arm
    return chain if plain is None else replace(chain, title=plain.title)
