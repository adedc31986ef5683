"""LaTeX formulas as MathML, which browsers show without a script.

Chromium stretches brackets only where a mathematical font is installed, and aligns no columns; so brackets around a
matrix are drawn as its border, and alignment is written as a style.
"""

import re
from functools import lru_cache

from latex2mathml.converter import convert

from exercises.writing.direct import direct

_CORNERS = ", ".join(
    f"linear-gradient(currentColor, currentColor) {x} {y} / 5px 1.5px" for x in ("0", "100%") for y in ("0", "100%")
)
_BRACKETS = (
    f"border: solid currentColor; border-width: 0 1.5px; padding: 0.15em 0.2em; background: {_CORNERS}; "
    "background-repeat: no-repeat"
)
_MATRIX = re.compile(r"<mo>&#x0005B;</mo><mtable>((?:[^<]++|<(?!mtable))*?)</mtable><mo>&#x0005D;</mo>")
_APART = r"\\[6pt]"
_FUNCTION = re.compile(r"<mi>(arc|)(?:sin|cos|tan)</mi>")
_BEFORE, _BEHIND = ("</mn>", "</mi>", "</msub>", "&#x00029;</mo>"), ("<mi>", "<msub>")
"""What a function's name stands apart from: a factor before it, and its argument where that is in no brackets."""
_THIN = '<mspace width="0.17em" />'
_SIGN = re.compile(r"(<mo[^>]*>(?:&#x000(?:28|2C|3D|5B)|);</mo>)<mo>(&#x02212;|&#x0002B;)</mo>")
"""A sign behind a bracket, a comma or an equals sign, which belongs to the number behind it."""
_DECIMAL = re.compile(r"(?<=<mn>)(\d+)</mn><mrow><mo>&#x0002C;</mo></mrow><mn>(?=\d+</mn>)")
"""A decimal comma, which LaTeX has in braces."""


@lru_cache(maxsize=512)
def mathml(latex: str, block: bool = False, percent: int = 100) -> str:
    r"""Return a formula as a MathML element for a browser; `block` is for one that stands on lines of its own.

    `percent` is its size, for one that is too wide for a page.

    >>> mathml("a_{1}")
    '<math xmlns="http://www.w3.org/1998/Math/MathML" display="inline"><mrow><msub>...</msub></mrow></math>'
    """
    shown = plain_mathml(latex, block)
    shown = _MATRIX.sub(rf'<mtable style="{_BRACKETS}">\1</mtable>', shown)
    over = "1.1ex" if _APART in latex else "0.5ex"
    for side, gap in (("right", "0.3em"), ("left", "1.5em")):
        style = f"text-align: {side}; padding: {over} {gap} {over} 0"
        shown = shown.replace(f' columnalign="{side}"', f' style="{style}"')
    if percent < 100:
        shown = shown.replace("<math ", f'<math style="font-size: {percent}%" ', 1)
    shown = _DECIMAL.sub(r"\1,", shown).replace("<mi>;</mi>", "<mo>;</mo>")  # a semicolon parts what is beside it
    shown = _SIGN.sub(r'\1<mo form="prefix">\2</mo>', shown)
    return _with_functions_apart(shown)


def _with_functions_apart(shown: str) -> str:
    def apart(name: re.Match[str]) -> str:
        start, end = name.span()
        before = _THIN if shown.endswith(_BEFORE, 0, start) else ""
        is_bare = not name[1] and shown.startswith(_BEHIND, end) and not _FUNCTION.match(shown, end)
        return f"{before}{name[0]}{_THIN if is_bare else ''}"

    return _FUNCTION.sub(apart, shown)


def plain_mathml(latex: str, block: bool = False) -> str:
    """Return a formula as MathML without regard to what browsers make of it."""
    display = "block" if block else "inline"
    found = direct(known(latex))
    if found is None:
        return str(convert(known(latex), display=display))
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="{display}">{found.shown}</math>'


def known(latex: str) -> str:
    """Return a formula as latex2mathml knows it.

    It knows align*, which is laid out as aligned is, and not aligned itself; nor room between rows.
    """
    return latex.replace("{aligned}", "{align*}").replace(_APART, r"\\")
