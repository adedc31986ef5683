"""Our Markdown with LaTeX formulas as Typst markup, for PDF without a TeX installation.

Every formula is a call that has it in words, too: `#formula("words", $…$)` or, on lines of its own,
`#formulas("words", $…$, size)`; the template exports/paper.typ.j2 defines both. Punctuation is escaped: text can't
become markup.
"""

import re
from collections.abc import Sequence

from markdown_it.token import Token

from exercises.writing.fit import fitted, width
from exercises.writing.latex_tree import Formula, parsed
from exercises.writing.markup import HOLDER, parsed_markdown
from exercises.writing.spoken import spoken

ROOM = 40.0
"""How wide formulas may be on lines of their own, in em of the text: on A4 and on Letter, beside a rule at the left."""

_PUNCTUATION = re.compile(r"[!-/:-@\[-`{-~]")
_OPEN = {
    "strong_open": "#strong[", "em_open": "#emph[", "bullet_list_open": "\n#list(", "list_item_open": "[",
    "thead_open": "table.header(", "th_open": "[", "td_open": "[", "paragraph_open": "\n",
}  # fmt: skip
_CLOSE = {
    "strong_close": "]", "em_close": "]", "heading_close": "]\n", "bullet_list_close": ")\n",
    "ordered_list_close": ")\n", "list_item_close": "],\n", "thead_close": "),\n", "th_close": "], ", "td_close": "], ",
    "tr_close": "\n", "table_close": "table.hline())\n", "paragraph_close": "\n", "softbreak": "\n",
    "hardbreak": " \\\n",
}  # fmt: skip
_SIZED = {"": "frac({}, {})", "small": "inline(frac({}, {}))", "large": "display(frac({}, {}))"}


def typst_string(text: str) -> str:
    r"""Return a text as a string of Typst's code.

    >>> print(typst_string('a "b" \\ c'))
    "a \"b\" \\ c"
    """
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def typst_escaped(text: str) -> str:
    r"""Return plain text as markup.

    >>> typst_escaped("*1. a_b*")
    '\\*1\\. a\\_b\\*'
    """
    return _PUNCTUATION.sub(lambda found: "’" if found[0] == "'" else "\\" + found[0], text)


def to_typst(text: str, share: float = 1.0) -> str:
    """Return markup for the body of a document; raw HTML in the text is left out.

    It may take a `share` of a page's width.
    """
    tokens, formulas = parsed_markdown(text)

    def formula(match: re.Match[str]) -> str:
        latex, block = formulas[int(match.group(1))]
        words = typst_string(spoken(latex))
        if not block:
            return f"#formula({words}, ${typst_math(latex)}$)"
        shown = fitted(latex, share * ROOM)
        size = min(100, int(100 * share * ROOM / width(shown)))
        return f"#formulas({words}, $ {typst_math(shown)} $, {size}%)"

    return re.sub(r"\n{3,}", "\n\n", HOLDER.sub(formula, _markup(tokens))).strip() + "\n"


def _markup(tokens: Sequence[Token]) -> str:
    out: list[str] = []
    for index, token in enumerate(tokens):
        if token.type in _OPEN:
            out.append("" if token.hidden else _OPEN[token.type])
        elif token.type in _CLOSE:
            out.append("" if token.hidden else _CLOSE[token.type])
        elif token.type == "inline":
            out.append(_markup(token.children or []))
        elif token.type == "text":
            out.append(typst_escaped(token.content))
        elif token.type == "code_inline":
            out.append(f"#raw({typst_string(token.content)})")
        elif token.type == "heading_open":
            out.append(f"\n#heading(level: {token.tag[1]})[")
        elif token.type == "ordered_list_open":
            out.append(f"\n#enum(start: {token.attrGet('start') or 1}, ")
        elif token.type == "table_open":
            columns = sum(t.type == "th_open" for t in tokens[index:])
            out.append(f"\n#table(columns: {columns}, ")
    return "".join(out)


# --- formulas ---


def typst_math(latex: str) -> str:
    r"""Return a formula as Typst's mathematics. Raises UnknownLatex.

    >>> typst_math(r"\dot{\theta}_{1} = -\tfrac{1}{2} a_{1}")
    'dot(θ)_(1) = − inline(frac(1, 2)) a_(1)'
    """
    return _math(parsed(latex))


def _math(one: Formula) -> str:
    inner = one.inner
    if one.kind == "row":
        return " ".join(map(_math, inner)) or '""'
    if one.kind == "script":
        base, below, above = inner
        marks = (f"_({_math(below)})" if below.inner else "") + (f"^({_math(above)})" if above.inner else "")
        return (_math(base) if base.kind != "row" or len(base.inner) == 1 else f"({_math(base)})") + marks
    if one.kind == "fraction":
        return _SIZED[one.text].format(*map(_math, inner))
    if one.kind in ("root", "dotted"):
        return f"{'sqrt' if one.kind == 'root' else 'dot'}({_math(inner[0])})"
    if one.kind == "fenced":
        opening, closing = (_sign(sign) if sign != "." else "" for sign in one.text)
        return f"lr({opening} {_math(inner[0])} {closing})"
    if one.kind == "table":
        return _table(one)
    return _leaf(one)


def _leaf(one: Formula) -> str:
    if one.kind == "word":
        return f'op("{one.text}")'
    if one.kind == "text":
        return typst_string(one.text)
    if one.kind == "space":
        return f"#h({one.text}em)"
    return _sign(one.text)


def _sign(text: str) -> str:
    return f"\\{text}" if len(text) == 1 and text in "()[]{},;:|/*'_^&#$\"\\" else text


def _table(one: Formula) -> str:
    if not one.text:
        return " \\ ".join(" & ".join(map(_math, row.inner)) for row in one.inner)
    rows = "; ".join(", ".join(map(_math, row.inner)) for row in one.inner)
    return f'mat(delim: "{one.text[0]}", {rows})'
