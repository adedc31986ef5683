"""Figures in the dark: ink on a card of their own, and readable, too, where a page of ours turns lightness round."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from qdot.exercises.figure.arm_figure import draw_figure_svg, draw_options_svg, draw_singular_svg, draw_thumbnail_svg
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId

ROOT = Path(__file__).parents[3]
SVG = "{http://www.w3.org/2000/svg}"
PAGES = ("site/src/site.css", "templates/reports/feedback.css.j2", "templates/exports/paper.css.j2")
"""Style sheets of pages that are dark by themselves and show figures."""
FILTER = re.compile(r"invert\(([\d.]+)\) hue-rotate\(180deg\)")
HALF_TURN = np.array([[-0.574, 1.43, 0.144], [0.426, 0.43, 0.144], [0.426, 1.43, -0.856]])
"""The matrix by which hue-rotate(180deg) multiplies red, green and blue (Filter Effects, section 9.8)."""
LETTERS, LINES = 4.5, 3.0
"""Contrast that WCAG asks for, of letters and of what else has to be told apart."""
FILLING = ("link-inside", "rod-inside", "rod", "link", "joint-face", "joint-side", "plate", "pedestal", "hatch")
"""Bodies and the ground, which have outlines or are told by their shape."""


def drawings() -> Iterator[str]:
    arm = sample_chain(ProblemId.parse("elbow-3r/1@chapter"))
    numbers = sample_chain(ProblemId.parse("planar-2r/1@full"))
    yield from (draw_figure_svg(arm), draw_singular_svg(arm), draw_thumbnail_svg(arm), draw_figure_svg(numbers))
    yield draw_options_svg(arm, [{q.name: 0.3 * k for q in arm.q} for k in range(4)])


def colour(code: str) -> np.ndarray:
    return np.array([int(code[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def turned_round(rgb: np.ndarray, amount: float) -> np.ndarray:
    inverted = np.clip(amount + rgb * (1 - 2 * amount), 0, 1)
    return np.clip(HALF_TURN @ inverted, 0, 1)


def luminance(rgb: np.ndarray) -> float:
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def contrast(first: np.ndarray, second: np.ndarray) -> float:
    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


def inks() -> dict[str, tuple[str, float]]:
    """The colours of lines and lettering by class, and the contrast that each needs."""
    shapes = (ROOT / "templates/figure/shapes.svg.j2").read_text()
    lines = re.findall(r'"([\w-]+)": .*?(?:fill|stroke)="(#\w{6})"', shapes)
    letters = re.findall(r'"(\w+)": "(#\w{6})"', shapes)
    wanted = {name: (code, LINES) for name, code in lines if name not in FILLING}
    return wanted | {f"letters of {name}": (code, LETTERS) for name, code in letters}


def test_every_drawing_lies_on_a_light_card_of_its_own() -> None:
    """JupyterLab and others are dark whatever the reader's system is: a picture there can't know, so it needs none."""
    for svg in drawings():
        root = ET.fromstring(svg)
        card = next(one for one in root if one.tag not in (f"{SVG}title", f"{SVG}desc"))
        assert card.tag == f"{SVG}rect" and card.get("fill") == "#ffffff"
        left, top, wide, high = map(float, (root.get("viewBox") or "").split())
        assert (left, top) == (0, 0)
        assert (float(card.get("width", 0)), float(card.get("height", 0))) == (wide - 1, high - 1)


@pytest.mark.parametrize("page", PAGES)
def test_what_is_drawn_is_readable_on_its_card_and_turned_round(page: str) -> None:
    amounts = {float(amount) for amount in FILTER.findall((ROOT / page).read_text())}
    assert len(amounts) == 1, "a dark page turns the lightness of drawings round"
    (amount,) = amounts
    white = np.ones(3)
    found = inks()
    assert {"axis-x", "arc", "lost", "letters of angle", "letters of z"} <= set(found)
    for name, (code, least) in found.items():
        assert contrast(colour(code), white) >= least, name
        assert contrast(turned_round(colour(code), amount), turned_round(white, amount)) >= least, name
