"""The gallery of the arms: every family with its thumbnail, its questions, and a link to practise with it."""

from collections.abc import Collection
from dataclasses import dataclass

from qdot.exercises.families import FAMILIES
from qdot.exercises.families.listing import listing
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.mathml import mathml
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.site.page import Page
from qdot.exercises.writing.languages import LANGUAGES, catalogue
from qdot.exercises.writing.render import render
from qdot.exercises.writing.wording import Wording

PATH = "arms.html"


@dataclass(frozen=True)
class Card:
    """A family as the gallery shows it, with its titles in other languages.

    `task` is MathML, `kinds` the joints as in RRP; both are empty if they vary. `practised` says whether the bank has
    problems of it.
    """

    name: str
    title: str
    titles: dict[str, str]
    source: str
    kinds: str
    task: str
    difficulty: str
    asked: tuple[str, ...]
    practised: bool


def gallery(practised: Collection[str]) -> Page:
    """Return the gallery; `practised` are the families that the site's bank has."""
    cards = [_card(name, name in practised) for name in FAMILIES]
    titles = {name: question.title for name, question in QUESTIONS.items()}
    translations = {
        name: {code: catalogue(code).question(title) for code in LANGUAGES} for name, title in titles.items()
    }
    body = render("site/arms.html.j2", cards=cards, questions=titles, translated_questions=translations)
    return Page(PATH, "The arms", body, section="arms", kind="wide")


def _card(name: str, practised: bool) -> Card:
    family, listed = FAMILIES[name], listing()[name]
    task = Wording(sample_chain(ProblemId(name, 0))).task
    return Card(
        name=name,
        title=family.title,
        titles={code: catalogue(code).family(family.title) for code in LANGUAGES},
        source=family.source,
        kinds="" if family.varied else listed.kinds,
        task="" if family.varied else mathml(parse_latex(", ".join(task))),
        difficulty=listed.difficulty,
        asked=listed.questions,
        practised=practised,
    )
