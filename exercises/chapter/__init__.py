"""Solve the chapter's Examples 6.1 to 6.4, and read the errors in the printed chapter from errata.toml."""

import tomllib
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.writing.languages import ENGLISH, load_catalogue
from qdot.exercises.writing.problem_texts import write_solution
from qdot.exercises.writing.wording import Wording


def read_entries(name: str) -> list[dict[str, Any]]:
    """Return the entries of examples.toml (`name` "examples") or errata.toml (`name` "errata")."""
    text = Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8")
    entries: list[dict[str, Any]] = tomllib.loads(text)[name]
    return entries


def make_planar_2r() -> Chain:
    """Return the arm of Examples 6.1, 6.2 and 6.4."""
    return sample_chain(ProblemId("planar-2r", 0, variation="chapter"))


def make_scorbot_arm() -> Chain:
    """Return the arm of Example 6.3: a Scorbot up to the wrist point P."""
    return replace(sample_chain(ProblemId("elbow-3r", 0, variation="chapter")), title="Scorbot, wrist point P")


@dataclass(frozen=True)
class Example:
    """An example of the chapter, with its solution.

    - `number` is the example's number in the chapter, such as "6.1".
    - `key` is the arm's name, such as "planar-2r", in the file names of its drawings.
    - `steps` are the steps of the solution, each with a title and a text.
    - `shows_arm` says whether the example shows a drawing of the arm, because no earlier example has the same arm.
    - `shows_singularities` says whether the example shows drawings of singular configurations.
    """

    number: str
    title: str
    key: str
    arm: Chain
    steps: tuple[tuple[str, str], ...]
    shows_arm: bool
    shows_singularities: bool

    @property
    def wording(self) -> Wording:
        """The words and the LaTeX that describe the arm, such as its DH table."""
        return Wording(self.arm)


@cache
def solve_examples(language: str = ENGLISH) -> tuple[Example, ...]:
    """Return the chapter's examples with their solutions in a language."""
    catalogue = load_catalogue(language)
    arms = {"planar-2r": make_planar_2r(), "scorbot": make_scorbot_arm()}
    examples: list[Example] = []
    for entry in read_entries("examples"):
        key, title, questions = entry["key"], entry["title"], entry["questions"]
        titles = [catalogue.translate_question(QUESTIONS[name].title) for name in questions]
        solutions = [_write_worked_solution(arms[key], name, language) for name in questions]
        steps = tuple(zip(titles, solutions, strict=True))
        examples.append(
            Example(
                number=entry["number"], title=catalogue.gettext(title), key=key, arm=arms[key], steps=steps,
                shows_arm=all(example.key != key for example in examples),
                shows_singularities="singular-angles" in questions,
            )
        )  # fmt: skip
    return tuple(examples)


@cache
def _write_worked_solution(chain: Chain, question: str, language: str) -> str:
    """Return the worked solution of a question about an arm."""
    answer, details = QUESTIONS[question].ask(chain, Stream("docs"))
    part = Part(question, question, answer, details=details)
    return write_solution(Problem(ProblemId(chain.name, 0), chain, (part,)), part, language)


@dataclass(frozen=True)
class Erratum:
    """An error in the printed chapter, with its correction.

    - `place` is the place in the chapter, and `kind` is "wrong", "incomplete" or "lost in typesetting".
    - `printed` and `correction` are the printed and the correct text, and `reason` says why the error matters.
    - `values` are pairs (description, number) that show the error at the `configuration`.
    """

    place: str
    kind: str
    printed: str
    correction: str
    reason: str
    configuration: str
    values: tuple[tuple[str, str], ...]


@cache
def read_errata(language: str = ENGLISH) -> tuple[Erratum, ...]:
    """Return the errors in the printed chapter, with their corrections in a language, from errata.toml."""
    catalogue = load_catalogue(language)

    def translate(text: str) -> str:
        return catalogue.localize_formulas(catalogue.pgettext("erratum", text))

    errata = []
    for entry in read_entries("errata"):
        pairs = ((translate(name), translate(value)) for name, value in entry["values"])
        values = tuple((name, catalogue.localize_number(value)) for name, value in pairs)
        texts = {name: translate(text) for name, text in entry.items() if name != "values"}
        errata.append(Erratum(**texts, values=values))
    return tuple(errata)
