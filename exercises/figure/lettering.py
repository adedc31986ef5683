"""Write symbols, lengths and angles as lettering: the text of a label as runs, some italic, some subscripts."""

import re
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

FONT_SIZE = 15.0
"""Size of lettering in pixels."""
SMALL_LETTER_SCALE = {"ω": 1.25}
"""Magnification of letters that name an axis and look too small in the fonts of PDFs."""
SUBSCRIPT_SCALE = 0.72
"""Size of a subscript relative to its letter."""
GREEK_LETTERS = {
    "theta": "θ", "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "phi": "φ", "psi": "ψ",
    "lambda": "λ", "lamda": "λ", "rho": "ρ", "omega": "ω", "eta": "η", "mu": "μ",
}  # fmt: skip


@dataclass(frozen=True)
class FontRun:
    """A run of lettering in one font and size. `dy` lowers its baseline below that of the previous run, in pixels."""

    text: str
    is_italic: bool
    size: float
    dy: float


TextRun = tuple[str, bool, bool]
"""A text, whether it is italic, and whether it is a subscript."""
Lettering = tuple[TextRun, ...]
"""The text of a label."""


def write_upright(text: str) -> Lettering:
    """Return a text as upright lettering."""
    return ((text, False, False),)


def write_with_index(letter: str, index: str = "") -> Lettering:
    """Return an italic letter with a subscript, which is italic if it consists of letters."""
    subscript: Lettering = ((index, index.isalpha(), True),) if index else ()
    return ((letter, True, False), *subscript)


def write_symbol(name: str) -> Lettering:
    """Return the lettering of a symbol with a name such as "a1", "theta2", "b_x" or "h"."""
    match = re.fullmatch(r"([A-Za-z]+?)_?(\d+|(?<=_)\w+)?", name)
    letter, index = (match[1], match[2] or "") if match else (name, "")
    return write_with_index(GREEK_LETTERS.get(letter, letter), index)


def write_sign_and_size(expression: sp.Expr, is_angle: bool) -> tuple[str, Lettering]:
    """Return the sign ("+" or "−") of a length (m) or an angle (rad), and the lettering of the rest."""
    sign, size = ("−", -expression) if expression.could_extract_minus_sign() else ("+", expression)
    if size.is_number:
        text = f"{format_decimal(size * 180 / sp.pi)}°" if is_angle else f"{format_decimal(size)} m"
        return sign, write_upright(text)
    if isinstance(size, sp.Symbol):
        return sign, write_symbol(size.name)
    factor, other_factor = size.as_coeff_Mul()
    if isinstance(other_factor, sp.Symbol):
        return sign, (*write_upright(f"{format_decimal(factor)} "), *write_symbol(other_factor.name))
    if isinstance(size, sp.Add):
        runs: Lettering = ()
        for number, term in enumerate(size.as_ordered_terms()):
            term_sign, letters = write_sign_and_size(term, is_angle)
            sign_text = f" {term_sign} " if number else term_sign.strip("+")
            runs += (*(write_upright(sign_text) if sign_text else ()), *letters)
        return sign, runs
    return sign, write_upright(str(size))


def format_decimal(number: sp.Expr) -> str:
    """Return a number with at most three decimals and no needless zeros."""
    text = f"{float(number):.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


@lru_cache(maxsize=4096)
def write_length(expression: sp.Expr) -> Lettering:
    """Return the lettering of a length beside a drawn line, without its sign."""
    _, lettering = write_sign_and_size(expression, is_angle=False)
    return lettering


@lru_cache(maxsize=4096)
def write_joint_variable(variable: sp.Symbol, offset: sp.Expr, is_angle: bool) -> Lettering:
    """Return the lettering of a joint variable plus its offset, as in θ1 + 30°."""
    if offset == 0:
        return write_symbol(variable.name)
    sign, offset_letters = write_sign_and_size(offset, is_angle)
    return (*write_symbol(variable.name), *write_upright(f" {sign} "), *offset_letters)


@lru_cache(maxsize=4096)
def make_font_runs(lettering: Lettering) -> tuple[FontRun, ...]:
    """Return the runs of some lettering, with lowered and smaller subscripts."""
    font_runs, previous_shift = [], 0.0
    for text, is_italic, is_subscript in lettering:
        baseline_shift = 0.24 * FONT_SIZE if is_subscript else 0.0
        size = FONT_SIZE * _scale_letters(text, is_subscript)
        font_runs.append(FontRun(text, is_italic, size, baseline_shift - previous_shift))
        previous_shift = baseline_shift
    return tuple(font_runs)


def _scale_letters(text: str, is_subscript: bool) -> float:
    """Return the font size of a run of lettering relative to FONT_SIZE."""
    return SUBSCRIPT_SCALE if is_subscript else SMALL_LETTER_SCALE.get(text, 1.0)


LETTERING_HEIGHT = FONT_SIZE * 1.16
"""An upper estimate of the height (pixels) of lettering in any serif font."""


@lru_cache(maxsize=4096)
def measure_width(lettering: Lettering) -> float:
    """Return an upper estimate of the width (pixels) of some lettering in any serif font."""
    narrow_letters, wide_letters = set(" .,1iljt°"), set("mwMWOθ=+−ωφψ")
    width = 0.0
    for text, _, is_subscript in lettering:
        for letter in text:
            fraction = 0.34 if letter in narrow_letters else 0.74 if letter in wide_letters else 0.56
            width += fraction * FONT_SIZE * _scale_letters(text, is_subscript)
    return width + 2.0  # a margin of one pixel on each side
