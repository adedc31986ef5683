"""Make the page "The arms", a gallery: every family with its picture, its questions, and a link for practice."""

from collections.abc import Collection

from qdot.exercises.families import FAMILIES
from qdot.exercises.families.listing import read_listing
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.mathml import print_mathml
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.site.page import Page
from qdot.exercises.writing.languages import LANGUAGES, load_catalogue
from qdot.exercises.writing.render import render
from qdot.exercises.writing.wording import Wording

GALLERY_PATH = "arms.html"


def make_gallery_page(bank_families: Collection[str]) -> Page:
    """Return the page; `bank_families` are the families in the site's bank, which can be practised."""
    catalogues = {code: load_catalogue(code) for code in LANGUAGES}
    body = render(
        "site/arms.html.j2",
        families=FAMILIES,
        listing=read_listing(),
        practised=bank_families,
        tasks={name: _write_task(name) for name, family in FAMILIES.items() if not family.has_varied_structure},
        questions={name: question.title for name, question in QUESTIONS.items()},
        translate_family=lambda title: {code: c.translate_family(title) for code, c in catalogues.items()},
        translate_question=lambda title: {code: c.translate_question(title) for code, c in catalogues.items()},
    )
    return Page(GALLERY_PATH, "The arms", body, section="arms", kind="wide")


def _write_task(name: str) -> str:
    """Return the task of a family's arms, such as x, y, as MathML."""
    return print_mathml(parse_latex(", ".join(Wording(sample_chain(ProblemId(name, 0))).task)))
