"""The generated pages of docs/ are up to date, complete, and agree with the chapter.

Finding the questions of all families takes long, so they are read from the stored listing, which is compared with some
families, and in `make whole` with all.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import pytest

from qdot.exercises.chapter import solve_examples
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.listing import LISTING_FILE, read_listing
from qdot.exercises.generation import compute_listing
from qdot.exercises.short_questions import ALL_QUESTIONS
from tests.support import ROOT
from tests.support.suites import select_families
from tests.tools import docs_pages
from tests.tools.docs_pages import documents, listing_text, write

DOCS = ROOT / "docs"
together = pytest.mark.xdist_group("docs")
"""Run in one process, which generates the pages once; families have their own groups."""


@pytest.fixture(scope="module", autouse=True)
def _use_stored_listing() -> Iterator[None]:
    """Generate pages from the stored listing."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(docs_pages, "list_families", read_listing)
        documents.cache_clear()
        yield
    documents.cache_clear()


@together
def test_pages_are_up_to_date() -> None:
    """If this fails, run: make docs"""
    stale = [
        name
        for name, text in documents().items()
        if not (DOCS / name).is_file() or (DOCS / name).read_text(encoding="utf-8") != text
    ]
    assert not stale
    assert LISTING_FILE.read_text(encoding="utf-8") == listing_text()


SLOW = ("lbr-7r", "random-3", "random-4")


@pytest.mark.parametrize(
    "family", [pytest.param(name, marks=[pytest.mark.whole] if name in SLOW else []) for name in select_families()]
)
def test_listing_of_family_agrees_with_its_arms(family: str) -> None:
    """If this fails, run: make docs"""
    assert read_listing()[family] == compute_listing(FAMILIES[family])


def test_listing_has_difficulty_of_every_variation_step() -> None:
    for name, listed in read_listing().items():
        assert list(listed.step_difficulties) == sorted(listed.step_difficulties)
        assert len(listed.step_difficulties) == (0 if FAMILIES[name].has_varied_structure else len(VARIATION_STEPS))


@together
def test_families_page_lists_every_family_with_figure_and_title() -> None:
    rows = re.findall(
        r'^\| <img src="families/([a-z0-9-]+)\.svg".*?> \| `(.*?)`: (.*?) \|', documents()["families.md"], re.MULTILINE
    )
    assert rows == [(name, name, family.title) for name, family in FAMILIES.items()]


@together
def test_pages_have_all_questions_valid_links_figures_and_chapter_results() -> None:
    rows = re.findall(r"^\| `([a-z-]+)` \|", documents()["questions.md"], re.MULTILINE)
    assert rows == list(ALL_QUESTIONS) and list(read_listing()) == list(FAMILIES)
    for page in ("families.md", "errata.md", "questions.md"):
        for target in re.findall(r"\]\(([^)#]+)\)|src=\"([^\"]+)\"", documents()[page]):
            assert "".join(target) in documents() or (DOCS / "".join(target)).is_file()
    for name, text in documents().items():
        if name.endswith(".svg"):
            assert ET.fromstring(text).get("role") == "img"
    drawn = {name for name in documents() if name.startswith("families/")}
    assert {f"families/{path.name}" for path in (DOCS / "families").iterdir()} == drawn
    solutions = "".join(text for example in solve_examples() for _, text in example.steps)
    for formula in (
        r"\det J = a_{1} a_{2} s_{2}",
        r"-a_{1} s_{1} - a_{2} s_{12} & -a_{2} s_{12}",
        r"\frac{1}{a_{1} a_{2} s_{2}} \begin{bmatrix} a_{2} c_{12} & a_{2} s_{12}",
        r"a_{2} a_{3} s_{3} (a_{1} + a_{2} c_{2} + a_{3} c_{23})",
    ):
        assert formula in solutions


@together
def test_pages_can_be_written_to_any_folder(tmp_path: Path) -> None:
    written = write(tmp_path)
    assert {str(path.relative_to(tmp_path)) for path in written} == set(documents())
    assert all(path.read_text(encoding="utf-8") == documents()[str(path.relative_to(tmp_path))] for path in written)


def test_every_page_is_linked_from_the_readme() -> None:
    reached, to_visit = set(), [ROOT / "README.md"]
    while to_visit:
        page = to_visit.pop()
        reached.add(page)
        targets = re.findall(r"\]\(([^)#:]+\.md)[^)]*\)", page.read_text(encoding="utf-8"))
        to_visit += {(page.parent / target).resolve() for target in targets} - reached
    assert set(DOCS.glob("*.md")) <= reached
