"""Convert Markdown with LaTeX formulas to Typst markup, for PDF without a TeX installation.

Every formula is a call that also contains the formula in words: `#formula("words", $…$)` for an inline formula, and
`#formulas("words", $…$, size)` for a displayed formula. The template exports/paper.typ.j2 defines both functions.
Punctuation is escaped, so that text can't become markup.
"""

import re
from collections.abc import Sequence
from functools import partial
from itertools import takewhile

from markdown_it.token import Token

from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.speech import print_speech
from qdot.exercises.formula.printers.typst import print_typst, quote_for_typst
from qdot.exercises.writing import markup
from qdot.exercises.writing.line_breaking import fit_formula, is_too_wide_inline
from qdot.exercises.writing.markup import PLACEHOLDER_PATTERN, TokenWriters, count_columns, has_tall_formula

TYPST_WIDTH = 40.0
"""Maximum width of displayed formulas in em, on A4 or Letter paper, beside the vertical line at their left."""

_PLACEHOLDER_BEFORE_PUNCTUATION = re.compile(PLACEHOLDER_PATTERN.pattern + r"(\\[,.;:])?")
"""Matches a formula's placeholder with the punctuation after it, which becomes part of a displayed formula."""
_PUNCTUATION = re.compile(r"[!-/:-@\[-`{-~]")


def escape_typst(text: str) -> str:
    r"""Return plain text as Typst markup, with punctuation escaped.

    >>> escape_typst("*1. a_b*")
    '\\*1\\. a\\_b\\*'
    """
    return _PUNCTUATION.sub(lambda match: "’" if match[0] == "'" else "\\" + match[0], text)


def to_typst(text: str, width_share: float = 1.0) -> str:
    """Return Typst markup for the body of a document; raw HTML in the text is omitted.

    `width_share` is the fraction of a page's width that the text may take.
    """
    tokens, formulas = markup.parse_markdown(text)

    def convert_formula(match: re.Match[str]) -> str:
        latex, is_displayed = formulas[int(match.group(1))]
        punctuation = match.group(2) or ""
        layout, max_width = parse_latex(latex), width_share * TYPST_WIDTH
        words = quote_for_typst(print_speech(layout))
        if not is_displayed and not is_too_wide_inline(layout, max_width):
            return f"#formula({words}, ${print_typst(layout)}$){punctuation}"
        fitted_layout = fit_formula(layout, max_width)
        size = markup.find_percent(fitted_layout, max_width)
        if is_displayed:
            return f"#formulas({words}, $ {print_typst(fitted_layout)} $, {size}%){punctuation}"
        quoted_punctuation = f' "{punctuation[1:]}"' if punctuation else ""
        return f"#formulas({words}, $ {print_typst(fitted_layout)}{quoted_punctuation} $, {size}%)"

    token_writers: TokenWriters = {**_TOKEN_WRITERS, "table_open": partial(_open_table, formulas=formulas)}
    body = markup.write_tokens(tokens, markup.MARKUP["typst"], token_writers)
    return re.sub(r"\n{3,}", "\n\n", _PLACEHOLDER_BEFORE_PUNCTUATION.sub(convert_formula, body)).strip() + "\n"


def _open_table(tokens: Sequence[Token], index: int, formulas: Sequence[markup.MarkdownFormula]) -> str:
    table = takewhile(lambda token: token.type != "table_close", tokens[index:])
    is_tall = has_tall_formula("".join(token.content for token in table), formulas)
    inset = "inset: (x: 0.65em, y: 0.62em), " if is_tall else ""
    return f"\n#table(columns: {count_columns(tokens[index:])}, {inset}"


_TOKEN_WRITERS: TokenWriters = {
    "text": lambda tokens, i: escape_typst(tokens[i].content),
    "code_inline": lambda tokens, i: f"#raw({quote_for_typst(tokens[i].content)})",
    "heading_open": lambda tokens, i: f"\n#heading(level: {tokens[i].tag[1]})[",
    "ordered_list_open": lambda tokens, i: f"\n#enum(start: {tokens[i].attrGet('start') or 1}, ",
}
