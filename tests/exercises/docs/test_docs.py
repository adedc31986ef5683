"""The generated pages of docs/ are up to date and complete; singular sets of robots are described as recorded.

Finding the questions of all families takes long, so they are read from the stored listing, which is compared with some
families, and in `make whole` with all.
"""

import json
import re
import struct
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm, read_errata
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.listing import LISTING_FILE, read_listing
from qdot.exercises.generation import compute_listing
from qdot.exercises.robots.library import list_robots
from qdot.exercises.robots.robot_file import read_robot_file
from qdot.exercises.short_questions import ALL_QUESTIONS
from qdot.exercises.singularities.classification import classify_conditions
from qdot.exercises.site.guide import arrange_pages
from qdot.exercises.site.pages import link_pages
from qdot.exercises.solve.solver import solve
from qdot.exercises.writing.markup import to_html
from tests.support import DATA, ROOT
from tests.support.suites import select_families
from tests.tools import docs_pages, reference_pages
from tests.tools.docs_pages import make_documents, make_listing_text

DOCS = ROOT / "docs"
OTHER_PAGES = {
    "robots": docs_pages.make_robots_page, "export-formats": reference_pages.make_export_formats_page,
    "library": reference_pages.make_library_page, "compatibility": reference_pages.make_compatibility_page,
}  # fmt: skip
together = pytest.mark.xdist_group("docs")
"""Run in one process, which generates the pages once; families have their own groups."""


@pytest.fixture(scope="module", autouse=True)
def _use_stored_listing() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(docs_pages, "list_families", read_listing)
        make_documents.cache_clear()
        yield
    make_documents.cache_clear()


@together
def test_pages_are_up_to_date() -> None:
    """If this fails, run: make docs"""
    for name, text in {**make_documents(), **{f"{name}.md": make() for name, make in OTHER_PAGES.items()}}.items():
        assert (DOCS / name).is_file() and (DOCS / name).read_text(encoding="utf-8") == text, name
    assert LISTING_FILE.read_text(encoding="utf-8") == make_listing_text()


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
        r'^\| <img src="families/([a-z0-9-]+)\.svg".*?> \| `(.*?)`: (.*?) \|',
        make_documents()["families.md"],
        re.MULTILINE,
    )
    assert rows == [(name, name, family.title) for name, family in FAMILIES.items()]


@together
def test_pages_have_all_questions_valid_links_and_figures() -> None:
    rows = re.findall(r"^\| `([a-z-]+)` \|", make_documents()["questions.md"], re.MULTILINE)
    assert rows == list(ALL_QUESTIONS) and list(read_listing()) == list(FAMILIES)
    for page in ("families.md", "errata.md", "questions.md"):
        for target in re.findall(r"\]\(([^)#]+)\)|src=\"([^\"]+)\"", make_documents()[page]):
            assert "".join(target) in make_documents() or (DOCS / "".join(target)).is_file()
    for name, text in make_documents().items():
        if name.endswith(".svg"):
            assert ET.fromstring(text).get("role") == "img"
    drawn = {name for name in make_documents() if name.startswith("families/")}
    assert {f"families/{path.name}" for path in (DOCS / "families").iterdir()} == drawn


def test_every_page_is_linked_from_the_readme() -> None:
    reached, to_visit = set(), [ROOT / "README.md"]
    while to_visit:
        page = to_visit.pop()
        reached.add(page)
        targets = re.findall(r"\]\(([^)#:]+\.md)[^)]*\)", page.read_text(encoding="utf-8"))
        to_visit += {(page.parent / target).resolve() for target in targets} - reached
    assert set(DOCS.glob("*.md")) <= reached


RECORDED = json.loads((DATA / "singular_robots.json").read_text(encoding="utf-8"))
"""The descriptions of each robot's singular configurations; none if a condition is too long."""
SOME = ("cobra600", "stanford")
LONG = ("baxter", "gen3", "panda", "sawyer")
"""Arms with seven joints and offsets, whose singularity conditions are too long."""
MOST_TERMS = 10
"""The most terms of a condition that is described in words."""


def describe_singular_set(name: str) -> tuple[str, ...]:
    """Describe each component of a robot's singular set; nothing if a condition is too long."""
    if name in LONG:
        return ()
    chain = read_robot_file(list_robots()[name].path).chain
    components = solve(chain).singular or ()
    if any(len(condition.args) > MOST_TERMS for component in components for condition in component.conditions):
        return ()
    return tuple(convention_of(chain).rename_origins(component.classification.meaning) for component in components)


def test_singular_sets_of_all_robots_are_recorded() -> None:
    assert list(RECORDED) == list(list_robots())
    assert all(RECORDED[name] == [] for name in LONG)


@pytest.mark.parametrize(
    "name", [name if name in SOME else pytest.param(name, marks=pytest.mark.whole) for name in list_robots()]
)
def test_derived_singular_set_is_described_as_recorded(name: str) -> None:
    """If this fails and the new description is right, correct tests/data/singular_robots.json."""
    assert list(describe_singular_set(name)) == RECORDED[name]


PICTURES = sorted((DOCS / "pictures").glob("*"))
PICTURE_LINK = re.compile(r"!\[([^\]]*)\]\((pictures/[^)]+)\)")
MAX_BYTES, MAX_WIDTH = 60_000, 900
"""Limits on bytes and pixels, because the wheel and the site contain the pictures."""
MIN_ALT_LENGTH = 30
"""The least number of characters of an alternative text."""


def find_alt_texts() -> dict[str, list[str]]:
    alt_texts: dict[str, list[str]] = {}
    for page in sorted(DOCS.glob("*.md")):
        for words, path in PICTURE_LINK.findall(page.read_text(encoding="utf-8")):
            alt_texts.setdefault(path, []).append(words)
    return alt_texts


def test_every_picture_is_used_and_has_its_own_long_alternative_text() -> None:
    assert sorted(find_alt_texts()) == [path.relative_to(DOCS).as_posix() for path in PICTURES] != []

    alt_texts = [words for texts in find_alt_texts().values() for words in texts]
    assert [words for words in alt_texts if len(words) < MIN_ALT_LENGTH] == []
    assert len(set(alt_texts)) == len(alt_texts)


def test_pictures_are_small() -> None:
    for path in PICTURES:
        content = path.read_bytes()
        assert content.startswith(b"\x89PNG"), path
        (width,) = struct.unpack(">I", content[16:20])
        assert (width <= MAX_WIDTH, len(content) <= MAX_BYTES) == (True, True), (path, width, len(content))


def test_the_site_shows_pictures_on_listed_pages() -> None:
    listed = [entry.name for entries in arrange_pages(DOCS).values() for entry in entries]
    pages = [page for page in sorted(DOCS.glob("*.md")) if PICTURE_LINK.search(page.read_text(encoding="utf-8"))]
    for page in pages:
        text = page.read_text(encoding="utf-8")
        html = link_pages(to_html(text))
        assert page.stem in listed
        for words, path in PICTURE_LINK.findall(text):
            assert re.search(rf'<img src="{re.escape(path)}" alt="{re.escape(words)}"', html), (page, path)


A1, A2, A3, T1, T2, T3, QD1, QD2 = sp.symbols("a1 a2 a3 theta1 theta2 theta3 qd1 qd2")
HALF, TWO_FIFTHS = sp.Rational(1, 2), sp.Rational(2, 5)


def to_radians(value: int) -> sp.Expr:
    return sp.pi * sp.Rational(value, 180)


TWO_R = {A1: HALF, A2: TWO_FIFTHS, T1: to_radians(20), T2: to_radians(40)}
RATES = {QD1: sp.Integer(1), QD2: sp.Integer(2)}
ELBOW = {A1: sp.Rational(1, 10), A2: HALF, A3: TWO_FIFTHS, T1: to_radians(30), T2: to_radians(-40), T3: to_radians(70)}


def read_numbers(place: str) -> list[float]:
    (erratum,) = [erratum for erratum in read_errata() if place in erratum.place]
    return [float(value.removesuffix(" m/s").replace("−", "-")) for _, value in erratum.values]


def compute_rank(chain: Chain, configuration: Mapping[sp.Symbol, sp.Expr]) -> int:
    jacobian = np.array(derive(chain).jacobian.xreplace(dict(configuration)).evalf(20).tolist(), dtype=float)
    return int(np.linalg.matrix_rank(jacobian, tol=1e-9))


def count_inverse_solutions(a1: float, a2: float, distance: float) -> int:
    """Count the poses of a planar 2R arm that reach a point at this distance, by the law of cosines."""
    cosine = (distance**2 - a1**2 - a2**2) / (2 * a1 * a2)
    return 1 if abs(abs(cosine) - 1) < 1e-12 else 2 if abs(cosine) < 1 else 0


def classify_folded_arm(second: sp.Expr) -> str:
    planar = make_planar_2r()
    joints = tuple(replace(joint, a=a) for joint, a in zip(planar.joints, (HALF, second), strict=True))
    return classify_conditions(replace(planar, joints=joints), ("theta2 = pi",)).kind


def approximate(*computed: object) -> object:
    """Return what compares equal to the numbers rounded to four digits."""
    return pytest.approx([float(value) for value in computed], rel=6e-4, abs=1e-12)  # type: ignore[arg-type]


def test_numbers_of_planar_arm_are_those_computed() -> None:
    planar = derive(make_planar_2r())
    rotation, jacobian = planar.rotations[2].xreplace(TWO_R), planar.jacobian.xreplace(TWO_R).evalf()
    cosine = sp.cos(T1 + T2).xreplace(TWO_R)
    assert read_numbers("of $T$") == approximate(sp.sqrt(rotation[0, 0] ** 2 + cosine**2 + rotation[2, 0] ** 2), 1)
    assert rotation[:, 0].norm() == 1

    printed = -A1 * sp.sin(T1) * QD1 - A2 * sp.sin(T1 + T2) * QD1 + QD2
    right = (planar.geometric_jacobian[0, :] * sp.Matrix([QD1, QD2]))[0]
    assert read_numbers("$v_x$ and $v_y$") == approximate(*(v.xreplace({**TWO_R, **RATES}) for v in (printed, right)))

    wrong_inverse = jacobian.inv().as_mutable()
    wrong_inverse[0, 1] *= -1
    assert read_numbers("$J^{-1}$") == approximate(*(jacobian * wrong_inverse * sp.Matrix([0, sp.Rational(1, 5)])), 0)

    stretched, folded = ({**TWO_R, T2: angle} for angle in (sp.S.Zero, sp.pi))
    ranks = [compute_rank(make_planar_2r(), where) for where in (TWO_R, stretched)]
    assert read_numbers("aligned") == ranks == [2, 1]
    at_stop, at_stretch, at_fold = (planar.determinant.xreplace(where) for where in (TWO_R, stretched, folded))
    assert read_numbers("boundary singularities") == approximate(at_stop, at_stretch)
    assert read_numbers("not invertible") == approximate(at_stretch, at_fold)


def test_solutions_and_kinds_of_planar_arm_are_those_computed() -> None:
    point = NumericChain(make_planar_2r(), {"a1": 0.5, "a2": 0.4}).compute_point(np.array([0.0, np.pi / 3]))
    distance = float(np.linalg.norm(point))
    (erratum,) = [erratum for erratum in read_errata() if "inverse-kinematics solutions" in erratum.place]
    assert f"at {distance:.3f} m" in erratum.values[1][0]
    solutions = [count_inverse_solutions(0.5, 0.4, 0.9), count_inverse_solutions(0.5, 0.4, distance)]
    assert read_numbers("inverse-kinematics solutions") == solutions == [1, 2]
    (erratum,) = [erratum for erratum in read_errata() if "$s_2 = 0$" in erratum.place]
    assert [kind for _, kind in erratum.values] == [classify_folded_arm(HALF), classify_folded_arm(TWO_FIFTHS)]


def test_numbers_of_scorbot_are_those_computed() -> None:
    scorbot, arm = derive(make_scorbot_arm()), make_scorbot_arm()
    printed = -sp.sin(T1) * (A2 * sp.sin(T2) + A3 * sp.cos(T2 + T3))
    step = sp.Rational(1, 10**5)
    ahead, behind = (scorbot.position[1].xreplace({**ELBOW, T2: ELBOW[T2] + side * step}) for side in (1, -1))
    difference = (ahead - behind).evalf(30) / (2 * step)
    right = scorbot.geometric_jacobian[1, 1].xreplace(ELBOW)
    assert read_numbers("partial") == approximate(printed.xreplace(ELBOW), right, difference)

    terms, product = sp.expand(scorbot.jacobian.det(method="berkowitz")), scorbot.determinant
    count = len(sp.Add.make_args(terms))
    assert read_numbers(r"$\det J$") == approximate(count, terms.xreplace(ELBOW), product.xreplace(ELBOW))

    bent = {symbol: value for symbol, value in ELBOW.items() if symbol != T2}
    shoulder = {**bent, T2: sp.nsolve(product.xreplace(bent), T2, 2.0, prec=30)}
    straight = {**bent, T2: sp.S.Zero}
    ranks = [compute_rank(arm, where) for where in (straight, shoulder)]
    values = [product.xreplace(where) for where in (straight, shoulder)]
    assert read_numbers("Example 6.3, singular") == approximate(3, values[0], 2, values[1]) and ranks == [3, 2]
    (erratum,) = [erratum for erratum in read_errata() if "Example 6.3, singular" in erratum.place]
    assert rf"\theta_2 = {float(sp.deg(shoulder[T2])):.2f}^\circ" in erratum.configuration
