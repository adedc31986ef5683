"""Make the pages on the book: a page with an interactive arm for each of Examples 6.1 to 6.4, and the errata."""

import json
from collections.abc import Callable, Iterator
from functools import partial

from qdot.exercises.arm.chain import Chain
from qdot.exercises.chapter import Example, read_errata, solve_examples
from qdot.exercises.figure.arm_figure import draw_figure_svg, draw_singular_svg
from qdot.exercises.problem.problem import Problem, ProblemId
from qdot.exercises.problem.record import Json
from qdot.exercises.site.page import Page
from qdot.exercises.site.record import list_determinant_factors, make_arm_record
from qdot.exercises.writing.languages import ENGLISH, LANGUAGES, load_catalogue
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.render import make_environment

SECTION = "examples"
OVERVIEW_PATH, ERRATA_PATH = "examples/index.html", "examples/errata.html"
FORMULA_SHARE = 0.62
"""The fraction of the page's width that is left for formulas beside the arm."""


def make_example_path(number: str) -> str:
    """Return the path of an example's page.

    >>> make_example_path("6.1")
    'examples/6-1.html'
    """
    return f"examples/{number.replace('.', '-')}.html"


def make_chapter_pages() -> Iterator[Page]:
    """Yield the overview of the chapter's examples, their pages, and the errata."""
    yield _make_translated_page(OVERVIEW_PATH, _write_overview, "wide")
    for index, example in enumerate(solve_examples()):
        yield _make_translated_page(make_example_path(example.number), partial(_write_example, index), "wide")
    yield _make_translated_page(ERRATA_PATH, _write_errata)


def _make_translated_page(path: str, write: Callable[[str], tuple[str, str]], kind: str = "") -> Page:
    """Return a page in all languages; `write` returns the title and the body in a language."""
    translations = {language: write(language) for language in LANGUAGES}
    return Page(path, *write(ENGLISH), section=SECTION, kind=kind, translations=translations)


def _list_examples(language: str) -> list[dict[str, object]]:
    """Return the number, title, address and figure of each example, and whether the figure's words are translated."""
    return [
        {"number": example.number, "title": example.title, "address": make_example_path(example.number)}
        | _draw_card_figure(example, language)
        for example in solve_examples(language)
    ]


def _write_overview(language: str) -> tuple[str, str]:
    """Return the title and body of the overview of the examples."""
    template = make_environment(language).get_template("site/examples.html.j2")
    title = load_catalogue(language).gettext("Examples 6.1 to 6.4")
    return title, template.render(examples=_list_examples(language), errata=len(read_errata()), errata_at=ERRATA_PATH)


def _draw_card_figure(example: Example, language: str) -> dict[str, object]:
    """Return the figure of an example in the list: the arm or, if an earlier example shows it, the singularities."""
    name = f"card-{example.number.replace('.', '-')}"
    if not example.shows_arm and example.shows_singularities:
        return {"figure": draw_singular_svg(example.arm, name, language), "is_translated": True}
    return {"figure": draw_figure_svg(example.arm, name), "is_translated": False}


def _write_errata(language: str) -> tuple[str, str]:
    """Return the title and body of the page of errata."""
    template = make_environment(language).get_template("site/errata.md.j2")
    text = template.render(errata=list(enumerate(read_errata(language), 1)), places=_find_errata_pages(), level="##")
    return load_catalogue(language).gettext("Errata for the chapter"), to_html(text)


def _write_example(index: int, language: str) -> tuple[str, str]:
    """Return the title and body of an example's page."""
    templates, all_examples = make_environment(language), _list_examples(language)
    example = solve_examples(language)[index]
    arm = example.arm
    path = make_example_path(example.number)
    numbers = [number for number, page in _find_errata_pages().items() if page == path]
    corrections_here = [(number, read_errata(language)[number - 1]) for number in numbers]
    errata_template = templates.get_template("site/errata-list.md.j2")
    errata_list = errata_template.render(errata=corrections_here, places={}, level="###")
    intro = templates.get_template("site/example-given.md.j2").render(example=example)
    title = load_catalogue(language).gettext("Example %(number)s", number=example.number)
    return title, templates.get_template("site/example.html.j2").render(
        example=example,
        given=to_html(intro),
        figure=draw_figure_svg(arm, f"{example.key}-arm"),
        steps=[(heading, to_html(text, width_share=FORMULA_SHARE)) for heading, text in example.steps],
        singular=draw_singular_svg(arm, f"{example.key}-singular", language) if example.shows_singularities else "",
        errata=to_html(errata_list, width_share=FORMULA_SHARE) if corrections_here else "",
        arm=json.dumps(make_arm_data(arm), ensure_ascii=False),
        before=all_examples[index - 1] if index else None,
        after=all_examples[index + 1] if index + 1 < len(all_examples) else None,
        errata_at=ERRATA_PATH,
    )


def make_arm_data(chain: Chain) -> Json:
    """Return the data of an interactive arm (`make_arm_record`), and the factors of det J."""
    return make_arm_record(Problem(ProblemId("docs", 0), chain, ())) | {"factors": list_determinant_factors(chain)}


def _find_errata_pages() -> dict[int, str]:
    """Map the number of each erratum in an example to the path of the example's page."""
    return {
        number: make_example_path(example.number)
        for number, erratum in enumerate(read_errata(), 1)
        for example in solve_examples()
        if erratum.place.startswith(f"Example {example.number}")
    }
