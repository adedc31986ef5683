"""The book's side of the site: a page for each of Examples 6.1 to 6.4 with the live arm beside it, and the errata."""

import json
from collections.abc import Iterator, Sequence

from exercises.arm.chain import Chain
from exercises.docs import Example, corrections, examples
from exercises.docs.errata import Erratum
from exercises.figure import figure_svg, singular_svg
from exercises.problem import Problem, ProblemId
from exercises.record import Json
from exercises.render import render
from exercises.site.page import Page
from exercises.site.record import arm_record, determinant_factors
from exercises.writing.markup import to_html

SECTION = "examples"
Corrections = Sequence[tuple[int, Erratum]]
START, ERRATA = "examples/index.html", "examples/errata.html"
ASIDE = 0.62
"""The part of a page's width that a formula may take beside the arm."""


def address(number: str) -> str:
    """Return where the page of an example is.

    >>> address("6.1")
    'examples/6-1.html'
    """
    return f"examples/{number.replace('.', '-')}.html"


def chapter_pages() -> Iterator[Page]:
    """Yield the pages of the chapter's examples, what leads to them, and the errata."""
    every = examples()
    pages = [
        {"number": e.number, "title": e.title, "address": address(e.number), "figure": _card_figure(e)} for e in every
    ]
    errata = list(enumerate(corrections(), 1))
    lead = render("site/examples.html.j2", examples=pages, errata=len(errata), errata_at=ERRATA)
    yield Page(START, "Examples 6.1 to 6.4", lead, section=SECTION, kind="wide")
    for place, example in enumerate(every):
        yield Page(
            address(example.number),
            f"Example {example.number}",
            _example(example, pages, place, errata),
            section=SECTION,
            kind="wide",
        )
    text = render("site/errata.md.j2", errata=errata, places=_places(errata), level="##")
    yield Page(ERRATA, "Errata of the chapter", to_html(text), section=SECTION)


def _card_figure(example: Example) -> str:
    name = f"card-{example.number.replace('.', '-')}"
    seen = not example.drawn  # an example before it shows the arm
    return singular_svg(example.arm, name) if seen and example.singular else figure_svg(example.arm, name)


def _example(example: Example, every: list[dict[str, str]], place: int, errata: Corrections) -> str:
    arm = example.arm
    own = [(number, e) for number, e in errata if e.where.startswith(f"Example {example.number}")]
    differs = render("site/errata-list.md.j2", errata=own, places={}, level="###")
    return render(
        "site/example.html.j2",
        example=example,
        given=to_html(render("site/example-given.md.j2", example=example)),
        figure=figure_svg(arm, f"{example.key}-arm"),
        steps=[(title, to_html(text, share=ASIDE)) for title, text in example.steps],
        singular=singular_svg(arm, f"{example.key}-singular") if example.singular else "",
        errata=to_html(differs, share=ASIDE) if own else "",
        arm=json.dumps(told_arm(arm), ensure_ascii=False),
        before=every[place - 1] if place else None,
        after=every[place + 1] if place + 1 < len(every) else None,
        errata_at=ERRATA,
    )


def told_arm(chain: Chain) -> Json:
    """Return what the live arm is drawn from, with the factors of its determinant."""
    return arm_record(Problem(ProblemId("docs", 0), chain, ())) | {"factors": determinant_factors(chain)}


def _places(errata: Corrections) -> dict[int, str]:
    """Return the page of the example that a correction is about, by the correction's number."""
    known = {f"Example {e.number}": address(e.number) for e in examples()}
    return {number: at for number, e in errata for name, at in known.items() if e.where.startswith(name)}
