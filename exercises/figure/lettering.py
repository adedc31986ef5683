"""Write symbols, lengths and angles as lettering: pieces of text, some italic, some subscripts."""

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
    """A piece of lettering in one font; `dy` shifts its baseline from that of the previous piece, in pixels."""

    text: str
    italic: bool
    size: float
    dy: float


TextRun = tuple[str, bool, bool]
"""Text, whether it is italic, whether it is a subscript."""
Lettering = tuple[TextRun, ...]
"""The pieces of a label."""


def upright_lettering(text: str) -> Lettering:
    """Return upright lettering."""
    return ((text, False, False),)


def indexed_lettering(letter: str, index: str = "") -> Lettering:
    """Return an italic letter with an upright subscript."""
    sub: Lettering = ((index, index.isalpha(), True),) if index else ()
    return ((letter, True, False), *sub)


def symbol_lettering(name: str) -> Lettering:
    """Return the lettering of a symbol with a name such as "a1", "theta2", "b_x" or "h"."""
    match = re.fullmatch(r"([A-Za-z]+?)_?(\d+|(?<=_)\w+)?", name)
    letter, index = (match[1], match[2] or "") if match else (name, "")
    return indexed_lettering(GREEK_LETTERS.get(letter, letter), index)


def sign_and_lettering(expression: sp.Expr, is_angle: bool) -> tuple[str, Lettering]:
    """Return the sign ("+" or "−") and the lettering of the rest of a length (m) or an angle (rad)."""
    sign, size = ("−", -expression) if expression.could_extract_minus_sign() else ("+", expression)
    if size.is_number:
        text = f"{format_decimal(size * 180 / sp.pi)}°" if is_angle else f"{format_decimal(size)} m"
        return sign, upright_lettering(text)
    if isinstance(size, sp.Symbol):
        return sign, symbol_lettering(size.name)
    factor, rest = size.as_coeff_Mul()
    if isinstance(rest, sp.Symbol):
        return sign, (*upright_lettering(f"{format_decimal(factor)} "), *symbol_lettering(rest.name))
    if isinstance(size, sp.Add):
        pieces: Lettering = ()
        for number, term in enumerate(size.as_ordered_terms()):
            inner, letters = sign_and_lettering(term, is_angle)
            sign_text = f" {inner} " if number else inner.strip("+")
            pieces += (*(upright_lettering(sign_text) if sign_text else ()), *letters)
        return sign, pieces
    return sign, upright_lettering(str(size))


def format_decimal(number: sp.Expr) -> str:
    """Return a number with at most three decimals and no needless zeros."""
    text = f"{float(number):.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


@lru_cache(maxsize=4096)
def length_lettering(expression: sp.Expr) -> Lettering:
    """Return the lettering of a length beside a drawn line, without its sign."""
    return sign_and_lettering(expression, is_angle=False)[1]


@lru_cache(maxsize=4096)
def joint_lettering(variable: sp.Symbol, offset: sp.Expr, is_angle: bool) -> Lettering:
    """Return the lettering of a joint variable plus its offset, as in θ1 + 30°."""
    if offset == 0:
        return symbol_lettering(variable.name)
    sign, rest = sign_and_lettering(offset, is_angle)
    return (*symbol_lettering(variable.name), *upright_lettering(f" {sign} "), *rest)


@lru_cache(maxsize=4096)
def make_font_runs(pieces: Lettering) -> tuple[FontRun, ...]:
    """Return the runs of some lettering, with lowered and smaller subscripts."""
    font_runs, baseline_shift = [], 0.0
    for text, italic, sub in pieces:
        level = 0.24 * FONT_SIZE if sub else 0.0
        font_runs.append(FontRun(text, italic, FONT_SIZE * _letter_scale(text, sub), level - baseline_shift))
        baseline_shift = level
    return tuple(font_runs)


def _letter_scale(text: str, sub: bool) -> float:
    return SUBSCRIPT_SCALE if sub else SMALL_LETTER_SCALE.get(text, 1.0)


@lru_cache(maxsize=4096)
def lettering_size(pieces: Lettering) -> tuple[float, float]:
    """Return an upper estimate of width and height (pixels) of some lettering in any serif font."""
    narrow_letters, wide_letters = set(" .,1iljt°"), set("mwMWOθ=+−ωφψ")
    width = 0.0
    for text, _, sub in pieces:
        for letter in text:
            share = 0.34 if letter in narrow_letters else 0.74 if letter in wide_letters else 0.56
            width += share * FONT_SIZE * _letter_scale(text, sub)
    return width + 2.0, FONT_SIZE * 1.16
