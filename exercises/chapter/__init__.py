"""Solve the chapter's Examples 6.1 to 6.4, and read the errors in the printed chapter from errata.toml."""

import tomllib
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.writing.languages import ENGLISH, load_catalogue
from qdot.exercises.writing.problem_texts import write_solution
from qdot.exercises.writing.wording import Wording

FILES = {"example": "examples.toml", "erratum": "errata.toml"}
"""The file beside this module for each kind of entry."""


def read_entries(kind: str) -> list[dict[str, Any]]:
    """Return the entries of a kind ("example" or "erratum") from their file."""
    text = Path(__file__).with_name(FILES[kind]).read_text(encoding="utf-8")
    entries: list[dict[str, Any]] = tomllib.loads(text)[kind]
    return entries


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


@cache
def examples(language: str = ENGLISH) -> tuple[Example, ...]:
    """Return the chapter's examples with their solutions."""
    words = load_catalogue(language)
    arms = {"planar-2r": planar_2r(), "scorbot": scorbot_arm()}
    solved: list[Example] = []
    for number, title, key, questions in (entry.values() for entry in read_entries("example")):
        steps = tuple(
            (words.translate_question(QUESTIONS[name].title), _solve(arms[key], name, language)) for name in questions
        )
        is_first_use = all(earlier.key != key for earlier in solved)
        has_singularities = "singular-angles" in questions
        solved.append(Example(number, words.gettext(title), key, arms[key], steps, is_first_use, has_singularities))
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
    words = load_catalogue(language)

    def translate(text: str) -> str:
        return words.localize_formulas(words.pgettext("erratum", text))

    errata = []
    for entry in read_entries("erratum"):
        values = tuple((translate(name), words.localize_number(translate(value))) for name, value in entry["values"])
        texts = {name: translate(text) for name, text in entry.items() if name != "values"}
        errata.append(Erratum(**texts, values=values))
    return tuple(errata)


@cache
def _solve(chain: Chain, name: str, language: str) -> str:
    answer, details = QUESTIONS[name].ask(chain, Stream("docs"))
    part = Part(name, name, answer, details=details)
    return write_solution(Problem(ProblemId(chain.name, 0), _with_family_title(chain), (part,)), part, language)


def _with_family_title(chain: Chain) -> Chain:
    """Return an arm with the title of its family."""
    plain = FAMILIES[chain.name].textbook_arm
    return chain if plain is None else replace(chain, title=plain.title)
