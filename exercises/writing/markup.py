"""Convert Markdown with LaTeX formulas to HTML with MathML, to the body of a LaTeX document, and to terminal text.

Only what qdot's templates use is supported: headings, paragraphs, emphasis, code, lists, tables, formulas `$…$` and
displayed formulas `$$…$$`.
"""

import json
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache, partial
from html import escape
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from sympy.printing.pretty.pretty_symbology import line_width

from qdot.exercises.formula.latex import MARKDOWN_FORMULA, parse_latex
from qdot.exercises.formula.layout import Layout
from qdot.exercises.formula.printers.latex import print_latex
from qdot.exercises.formula.printers.mathml import print_mathml
from qdot.exercises.formula.printers.unicode import print_unicode
from qdot.exercises.writing.line_breaking import estimate_width, fit_formula, is_taller_than_line, is_too_wide_inline

if TYPE_CHECKING:  # importing markdown_it is slow, and grading does not need it, because grading uses stored HTML
    from markdown_it import MarkdownIt
    from markdown_it.token import Token
    from markdown_it.tree import SyntaxTreeNode

TERMINAL_WIDTH = 100
"""Maximum width of a line in a terminal, in characters."""
HTML_WIDTH, LATEX_WIDTH = 44.0, 38.0
"""Maximum width of formulas in em (see `line_breaking`): in HTML, for pages of 900 pixels or A4 paper, and in LaTeX."""
_TRIED_WIDTHS = (60.0, 52.0, 45.0, 39.0, 34.0, 29.0, 25.0, 21.0, 18.0, 15.0)
"""Maximum widths in em that are tried, until a formula fits into a terminal."""
MARKUP: dict[str, dict[str, str]] = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))
"""The markup in LaTeX and Typst of types of tokens that always have the same markup, and LaTeX's escapes."""
PLACEHOLDER_PATTERN = re.compile("\ue000(\\d+)\ue001")
"""Matches a placeholder, which contains a formula's number and replaces the formula while Markdown is parsed."""
_PLACEHOLDER_WITH_PUNCTUATION = re.compile(rf"([(„“]*){PLACEHOLDER_PATTERN.pattern}([.,;:!?)”]*)")
"""Matches a formula with the punctuation around it; browsers must not break a line between them."""


class MarkdownFormula(NamedTuple):
    """A formula in Markdown, and whether it is displayed on lines of its own."""

    latex: str
    is_displayed: bool


def parse_markdown(text: str) -> "tuple[list[Token], list[MarkdownFormula]]":
    """Return the tokens of a text with placeholders for formulas, and the formulas."""
    formulas: list[MarkdownFormula] = []

    def insert_placeholder(match: re.Match[str]) -> str:
        is_displayed = match.group(1) is not None
        latex = match.group(1) or match.group(2)
        if latex is None:
            return match[0]
        formulas.append(MarkdownFormula(" ".join(latex.split()), is_displayed))
        return f"\ue000{len(formulas) - 1}\ue001"

    return _get_parser().parse(MARKDOWN_FORMULA.sub(insert_placeholder, text)), formulas


@cache
def _get_parser() -> "MarkdownIt":
    """Return the parser of Markdown. It is created only once, because this takes longer than parsing a text."""
    from markdown_it import MarkdownIt

    return MarkdownIt("commonmark").enable("table")


ConvertFormula = Callable[[str, bool], str]
"""A function that converts a formula; its arguments are the LaTeX and whether the formula is displayed."""


def to_html(
    text: str, convert_formula: ConvertFormula | None = None, width_share: float = 1.0, joins_punctuation: bool = False
) -> str:
    """Return HTML with formulas as MathML, or converted by `convert_formula`; raw HTML in the text is kept.

    `width_share` is the fraction of a page's width that the text may take. Inline MathML is put in a span of class
    "whole" with the punctuation around it, and the style sheet forbids line breaks there. If `joins_punctuation`, the
    results of `convert_formula` are put in such spans, too.
    """
    tokens, formulas = parse_markdown(text)
    parser = _get_parser()
    html_text = parser.renderer.render(tokens, parser.options, {})

    convert = convert_formula or partial(_convert_to_mathml, max_width=width_share * HTML_WIDTH)
    uses_spans = convert_formula is None or joins_punctuation

    def convert_with_punctuation(match: re.Match[str]) -> str:
        prefix, number, suffix = match.groups()
        latex, is_displayed = formulas[int(number)]
        html = f"{prefix}{convert(latex, is_displayed)}{suffix}"
        is_single = not is_displayed and len(_split_equations(latex)) == 1
        return f'<span class="whole">{html}</span>' if uses_spans and is_single and (prefix or suffix) else html

    return _PLACEHOLDER_WITH_PUNCTUATION.sub(convert_with_punctuation, str(html_text))


@lru_cache(maxsize=512)
def _convert_to_mathml(latex: str, is_displayed: bool, max_width: float) -> str:
    if not is_displayed:
        return "".join(print_mathml(parse_latex(piece)) + separator for piece, separator in _split_equations(latex))
    fitted_layout = fit_formula(parse_latex(latex), max_width)
    return print_mathml(fitted_layout, True, find_percent(fitted_layout, max_width))


def find_percent(formula: Layout, max_width: float) -> int:
    """Return the size in per cent, at most 100, that makes a formula fit into `max_width` (em)."""
    width = estimate_width(formula)
    return 100 if width <= max_width else int(100 * max_width / width)


def _split_equations(latex: str) -> list[tuple[str, str]]:
    r"""Return each equation of a list with the separator after it, so that browsers can break lines between equations.

    >>> _split_equations("a_1 = 1, a_2 = 2, P = (0, 1)")
    [('a_1 = 1', ', '), ('a_2 = 2', ', '), ('P = (0, 1)', '')]
    >>> _split_equations("a = 1,\\; b = 2,\\; c = 3")
    [('a = 1', ', '), ('b = 2', ', '), ('c = 3', '')]
    >>> _split_equations("f(x, y)")
    [('f(x, y)', '')]
    """
    *pieces, last_piece = re.split(r"(?<=[,;])(?<!\\[,;])(?: |\\; )(?=[^,;]*=)", latex)
    return [*((piece[:-1].strip(), f"{piece[-1]} ") for piece in pieces), (last_piece.strip(), "")]


def fit_latex(latex: str, max_width: float) -> str:
    """Return the LaTeX of a displayed formula, broken into lines only if it is wider than `max_width` (em)."""
    layout = parse_latex(latex)
    fitted_layout = fit_formula(layout, max_width)
    return latex if fitted_layout is layout else print_latex(fitted_layout)


def to_html_for_mathjax(text: str) -> str:
    r"""Return HTML for platforms that typeset formulas themselves: formulas as LaTeX in `\(…\)` and `\[…\]`.

    Tables have the classes that make the themes of Moodle and PrairieLearn show lines and padding. In a window
    narrower than a table, only the table scrolls sideways; absolutely positioned elements in it scroll with it.
    """

    def convert_formula(latex: str, is_displayed: bool) -> str:
        if is_displayed:
            return rf"\[{escape(fit_latex(latex, HTML_WIDTH), quote=False)}\]"
        pieces = _split_equations(latex)
        return "".join(rf"\({escape(piece, quote=False)}\)" + separator for piece, separator in pieces)

    html_text = to_html(text, convert_formula).replace("</table>", "</table></div>")
    table_tag = '<table class="generaltable table table-bordered" style="width: auto">'
    return html_text.replace("<table>", f'<div style="overflow-x: auto; position: relative">{table_tag}')


# --- LaTeX ---

_BEGIN_TABLE = "\n\\begin{{center}}\n\\begin{{tabular}}{{{}}}\n\\toprule\n"
_BEGIN_ALIGNED, _END_ALIGNED = r"\begin{aligned}", r"\end{aligned}"
MAX_UNBROKEN_LINES = 8
"""A formula with at most this many lines is not broken across pages."""
_TABLE_PATTERN = re.compile(r"(\n\\begin\{tabular\}.*?\\end\{tabular\}\n)", re.DOTALL)
_PLACEHOLDER_BEFORE_PUNCTUATION = re.compile(PLACEHOLDER_PATTERN.pattern + "([,.;:]?)")
"""Matches a formula's placeholder with the punctuation after it, which becomes part of a displayed formula."""
_SHRINK_TO_LINE = r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"
"""The beginning of a LaTeX box that is shrunk to the width of the line if it is wider than the line."""
_SECTION_COMMANDS = {"h1": "section", "h2": "section", "h3": "subsection"}


def escape_latex(text: str) -> str:
    """Return plain text with LaTeX's special characters escaped."""
    return "".join(MARKUP["latex_characters"].get(ch, ch) for ch in text)


def to_latex(text: str, width_share: float = 1.0) -> str:
    """Return the body of a LaTeX document, which needs amsmath, booktabs and graphicx; raw HTML is omitted.

    `width_share` is the fraction of a page's width that the text may take.
    """
    tokens, formulas = parse_markdown(text)
    max_width = width_share * LATEX_WIDTH

    def convert_formula(match: re.Match[str]) -> str:
        latex, is_displayed = formulas[int(match.group(1))]
        if is_displayed:
            return _write_display(latex, max_width) + match.group(2)
        if is_too_wide_inline(parse_latex(latex), max_width):
            return _write_display(latex, max_width, match.group(2))
        return f"${latex}${match.group(2)}"

    def convert_cell_formula(match: re.Match[str]) -> str:
        return f"${formulas[int(match.group(1))].latex}$"

    def convert_table(latex: str) -> str:
        stretch_command = "\\renewcommand{\\arraystretch}{1.5}" if has_tall_formula(latex, formulas) else ""
        table = PLACEHOLDER_PATTERN.sub(convert_cell_formula, latex).rstrip()
        return f"\n{_SHRINK_TO_LINE}{stretch_command}{table}}}\n"

    pieces = _TABLE_PATTERN.split(write_tokens(tokens, MARKUP["latex"], _TOKEN_WRITERS))
    pieces[::2] = [_PLACEHOLDER_BEFORE_PUNCTUATION.sub(convert_formula, piece) for piece in pieces[::2]]
    pieces[1::2] = map(convert_table, pieces[1::2])
    return "".join(pieces).strip() + "\n"


def has_tall_formula(text: str, formulas: Sequence[MarkdownFormula]) -> bool:
    """Return whether a text with placeholders contains a formula that is higher than a line."""
    numbers = map(int, PLACEHOLDER_PATTERN.findall(text))
    return any(is_taller_than_line(parse_latex(formulas[number].latex)) for number in numbers)


def _write_display(latex: str, max_width: float, punctuation: str = "") -> str:
    """Return a displayed formula that fits into `max_width` (em), followed by `punctuation`."""
    fitted_latex = fit_latex(latex, max_width)
    layout = parse_latex(fitted_latex)
    is_aligned = [piece.kind for piece in layout.inner] == ["aligned"]
    if is_aligned and len(layout.inner[0].inner) > MAX_UNBROKEN_LINES:
        rows = fitted_latex.removeprefix(_BEGIN_ALIGNED).removesuffix(_END_ALIGNED)
        return f"{{\\allowdisplaybreaks\n\\begin{{align*}}\n{rows.strip()}{punctuation}\n\\end{{align*}}\n}}"
    if estimate_width(layout) <= max_width:
        return f"\\[\n{fitted_latex}{punctuation}\n\\]"
    # The width is only estimated, so LaTeX decides whether the formula has to be shrunk.
    return f"\\[\n{_SHRINK_TO_LINE}\n$\\displaystyle {fitted_latex}{punctuation}$}}\n\\]"


TokenWriters = Mapping[str, "Callable[[Sequence[Token], int], str]"]
"""For each type of token, a function that writes it; its arguments are all tokens and the token's index."""


def write_tokens(tokens: "Sequence[Token]", fixed_markup: Mapping[str, str], token_writers: TokenWriters) -> str:
    """Return the markup of tokens: for each token, a text of `fixed_markup` or the result of a token writer."""
    pieces: list[str] = []
    for index, token in enumerate(tokens):
        if token.type == "inline":
            pieces.append(write_tokens(token.children or [], fixed_markup, token_writers))
        elif token.type in token_writers:
            pieces.append(token_writers[token.type](tokens, index))
        elif not token.hidden:
            pieces.append(fixed_markup.get(token.type, ""))
        elif token.type == "paragraph_close":
            pieces.append("\n")
    return "".join(pieces)


def count_columns(tokens: "Sequence[Token]") -> int:
    """Return the number of columns of the table at the beginning of the tokens."""
    return sum(token.type == "th_open" for token in takewhile(lambda token: token.type != "table_close", tokens))


def _end_cell(tokens: "Sequence[Token]", index: int) -> str:
    return r" \\" + "\n" if tokens[index + 1].type == "tr_close" else " & "


_TOKEN_WRITERS: TokenWriters = {
    "text": lambda tokens, i: escape_latex(tokens[i].content),
    "code_inline": lambda tokens, i: rf"\texttt{{{escape_latex(tokens[i].content)}}}",
    "heading_open": lambda tokens, i: f"\n\\{_SECTION_COMMANDS.get(tokens[i].tag, 'subsubsection')}*{{",
    "table_open": lambda tokens, i: _BEGIN_TABLE.format("c" * count_columns(tokens[i:])),
    **dict.fromkeys(("th_close", "td_close"), _end_cell),
}


# --- terminal ---


_INDENT = 4 * " "
"""The space before displayed formulas and tables."""


def to_text(text: str) -> str:
    """Return text for a terminal, at most `TERMINAL_WIDTH` characters wide except for formulas that can't be broken."""
    from markdown_it.tree import SyntaxTreeNode

    tokens, formulas = parse_markdown(text)

    def convert_formula(match: re.Match[str]) -> str:
        latex, is_displayed = formulas[int(match.group(1))]
        if is_displayed:
            return f"\n\n{textwrap.indent(_write_display_as_text(latex), _INDENT)}\n\n"
        return print_unicode(parse_latex(latex)).strip()

    def convert_inline(inline: "SyntaxTreeNode") -> str:
        breaks = {"softbreak": " ", "hardbreak": "\n"}
        children = inline.token.children if inline.token else None
        markdown = "".join(breaks.get(child.type, child.content) for child in children or [])
        return PLACEHOLDER_PATTERN.sub(convert_formula, markdown)

    blocks = _write_text_blocks(SyntaxTreeNode(tokens), convert_inline, TERMINAL_WIDTH)
    return re.sub(r"\n{3,}", "\n\n", "\n\n".join(blocks)).strip() + "\n"


def _write_display_as_text(latex: str) -> str:
    """Return a displayed formula as text, broken into lines if it is too wide for the terminal.

    A width in em says little about a width in characters. Therefore the formula is fitted to smaller and smaller widths
    in em until its text is narrow enough. If no text is, the narrowest one is returned.
    """
    formula = parse_latex(latex)
    narrowest_text = print_unicode(formula)
    for max_width in _TRIED_WIDTHS:
        if _measure_text(narrowest_text) <= TERMINAL_WIDTH - len(_INDENT):
            break
        narrowest_text = min(narrowest_text, print_unicode(fit_formula(formula, max_width)), key=_measure_text)
    return narrowest_text


def _measure_text(text: str) -> int:
    """Return the width of the widest line of a text, in characters."""
    return max(map(line_width, text.splitlines()))


def _write_text_blocks(
    node: "SyntaxTreeNode", convert_inline: "Callable[[SyntaxTreeNode], str]", width: int
) -> list[str]:
    """Return the headings, paragraphs, quotations, tables and lists inside a node as text."""
    blocks: list[str] = []
    for child in node.children:
        if child.type == "heading":
            text = convert_inline(child.children[0])
            blocks.append(f"{text}\n{('=' if child.tag in ('h1', 'h2') else '-') * line_width(text)}")
        elif child.type == "paragraph":
            blocks += _wrap(convert_inline(child.children[0]), width)
        elif child.type == "blockquote":
            blocks += [textwrap.indent(block, "  ") for block in _write_text_blocks(child, convert_inline, width - 2)]
        elif child.type == "table":
            rows = [row for section in child.children for row in section.children]  # the head and the body
            blocks.append(_write_table([[convert_inline(cell.children[0]) for cell in row.children] for row in rows]))
        elif child.type in ("bullet_list", "ordered_list"):
            separator = "\n" if child.children[0].children[0].hidden else "\n\n"
            items = []
            for item in child.children:
                marker = f"  {item.info}. " if item.info else "  • "
                content = separator.join(_write_text_blocks(item, convert_inline, width - len(marker)))
                content = textwrap.indent(content, " " * len(marker))
                items.append(marker + content[len(marker) :])
            blocks.append(separator.join(items))
    return blocks


def _wrap(text: str, width: int) -> list[str]:
    """Return the pieces of a paragraph: wrapped prose, and displayed formulas (indented) unchanged."""
    pieces = [piece for piece in re.split(r"\n{2,}", text) if piece.strip()]
    return [piece if piece.startswith(_INDENT) else textwrap.fill(piece, width) for piece in pieces]


def _write_table(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(line_width(row[column]) for row in rows) for column in range(len(rows[0]))]
    lines = ["  ".join(cell.center(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    lines.insert(1, "  ".join("─" * width for width in widths))
    return textwrap.indent("\n".join(lines), _INDENT)
