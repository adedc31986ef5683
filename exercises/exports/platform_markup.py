"""Write texts with figures as HTML, and numbers as text, for exports to learning platforms."""

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal

from qdot.exercises.figure.arm_figure import describe_part_figure, draw_figure_svg, draw_part_svg
from qdot.exercises.figure.words import describe_figure
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.layout import Layout
from qdot.exercises.notebook.notebook import draw_singular_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.writing.line_breaking import fit_formula
from qdot.exercises.writing.markup import HTML_WIDTH, to_html, to_html_for_mathjax
from qdot.exercises.writing.render import render

DIGITS = 10
"""Significant digits of correct values in exports."""

FormulaPrinter = Callable[[Layout, bool], str]
"""A function that prints a formula for a platform; its arguments are the layout, and whether the formula is displayed.

For platforms without such a function, formulas stay LaTeX, which MathJax typesets.
"""


@dataclass(frozen=True)
class Picture:
    """A figure in a text: its name, its SVG, and a description in words."""

    name: str
    svg: str
    alt: str


def draw_arm(problem: Problem, name: str = "arm") -> Picture:
    """Return the drawing of a problem's arm."""
    return Picture(name, draw_figure_svg(problem.chain, name), describe_figure(problem.chain))


def draw_prompt_figure(problem: Problem, part: Part, name: str) -> Picture | None:
    """Return the figure of a part's prompt; None if the prompt has no figure."""
    svg = draw_part_svg(problem.chain, part, name)
    return Picture(name, svg, describe_part_figure(problem.chain, part)) if svg else None


def draw_solution_figure(problem: Problem, part: Part, name: str) -> Picture | None:
    """Return the figure of a part's worked solution; None if the solution has no figure."""
    svg = draw_singular_configurations(problem, part, name)
    return Picture(name, svg, "The arm in a regular and in its singular configurations") if svg else None


def write_html(text: str, print_formula: FormulaPrinter | None = None) -> str:
    """Return Markdown as HTML for a platform."""
    if print_formula is None:
        return to_html_for_mathjax(text).strip()

    def convert_formula(latex: str, is_displayed: bool) -> str:
        layout = parse_latex(latex)
        return print_formula(fit_formula(layout, HTML_WIDTH) if is_displayed else layout, is_displayed)

    return to_html(text, convert_formula).strip()


def write_line_html(text: str, print_formula: FormulaPrinter | None = None) -> str:
    """Return one line of Markdown as HTML without a paragraph around it."""
    paragraph_html = write_html(text, print_formula)
    inner_html = paragraph_html.removeprefix("<p>").removesuffix("</p>")
    return inner_html if "<p>" not in inner_html else paragraph_html


def write_html_with_figures(
    body: Sequence[str | Picture], find_address: Callable[[Picture], str], print_formula: FormulaPrinter | None = None
) -> str:
    """Return a text with its figures as HTML; `find_address` returns the address of a picture's file."""
    pieces = [
        {"picture": piece, "source": find_address(piece), "html": ""}
        if isinstance(piece, Picture)
        else {"picture": None, "source": "", "html": write_html(piece, print_formula)}
        for piece in body
    ]
    return render("exports/body.html.j2", pieces=pieces).strip()


def find_pictures(body: Sequence[str | Picture]) -> list[Picture]:
    """Return the figures of a text."""
    return [piece for piece in body if isinstance(piece, Picture)]


def name_picture_file(picture: Picture) -> str:
    """Return the name of a figure's file, which depends only on the figure. So equal figures share a file."""
    return f"{picture.name}-{hashlib.sha256(picture.svg.encode()).hexdigest()[:12]}.svg"


def make_svg_file(picture: Picture) -> bytes:
    """Return the content of a figure's file."""
    return ('<?xml version="1.0" encoding="UTF-8"?>\n' + picture.svg.strip() + "\n").encode()


def replace_angle_brackets(text: str) -> str:
    """Return a name without < and >. Platforms would take the text between them for a tag.

    >>> replace_angle_brackets("Arms & <signs>")
    'Arms & ‹signs›'
    """
    return text.translate(str.maketrans("<>", "‹›"))


def format_decimal(value: float, digits: int = DIGITS) -> str:
    """Return a number in decimal notation without an exponent, as platforms require.

    >>> format_decimal(-0.00000012345), format_decimal(3.0), format_decimal(0.1 + 0.2)
    ('-0.00000012345', '3', '0.3')
    """
    number_text = f"{Decimal(f'{value:.{digits}g}'):f}"
    return number_text.rstrip("0").rstrip(".") if "." in number_text else number_text


def format_tolerance(tolerance: float) -> str:
    """Return a tolerance as text, rounded up to four significant digits.

    >>> format_tolerance(0.00123456), format_tolerance(0)
    ('0.001235', '0')
    """
    if tolerance == 0:
        return "0"
    step = 10.0 ** (math.floor(math.log10(tolerance)) - 3)
    return format_decimal(math.ceil(tolerance / step - 1e-9) * step)


def format_limits(value: float, tolerance: float) -> tuple[str, str]:
    """Return the smallest and the largest value within a tolerance, as text."""
    rounded_tolerance = float(format_tolerance(tolerance))
    return format_decimal(value - rounded_tolerance), format_decimal(value + rounded_tolerance)
