"""Print formulas as Typst mathematics."""

from collections.abc import Callable

from qdot.exercises.formula.layout import ACCENTS, DEGREE, SPACES, SYMBOLS, Layout, print_layout

_MATRIX_DELIMITERS = {"[]": '"["', "()": '"("', "||": '"|"', "‖‖": '"||"', "{}": '"{"', "..": "#none"}
_CLASSES = {"|": "normal", "‖": "normal", "⊥": "relation"}
"""Signs whose spacing in Typst differs from LaTeX, and the class that gives them the spacing of LaTeX."""
_LIMITS_OPTION = ", limits: #true"
_FRACTION_TEMPLATES = {"frac": "frac({}, {})", "tfrac": "inline(frac({}, {}))", "dfrac": "display(frac({}, {}))"}


def quote_for_typst(text: str) -> str:
    r"""Return a text as a string literal in Typst code.

    >>> print(quote_for_typst('a "b" \\ c'))
    "a \"b\" \\ c"
    """
    escaped_text = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped_text}"'


def print_typst(formula: Layout) -> str:
    r"""Return a formula as Typst mathematics.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> print_typst(parse_latex(r"\dot{\theta}_{1} = -\tfrac{1}{2} a_{1}"))
    'dot(θ)_(1) = − inline(frac(1, 2)) a_(1)'
    """
    return print_layout(formula, _PRINTERS)


def _print_sign(piece: Layout) -> str:
    """Return a letter, a number or a sign."""
    if piece.text in _CLASSES:
        return f'class("{_CLASSES[piece.text]}", {_escape_sign(piece.text)})'
    has_decimal_comma = "," in piece.text.strip(",")  # Typst would take this comma for a separator
    return quote_for_typst(piece.text) if has_decimal_comma else _escape_sign(piece.text)


def _print_script(piece: Layout, base: str, *scripts: str) -> str:
    base_piece, _, superscript = piece.inner
    bracketed_base = base if base_piece.kind != "row" or len(base_piece.inner) < 2 else f"({base})"
    if superscript == DEGREE:
        return f"{bracketed_base} °"
    marked_scripts = zip("_^", piece.inner[1:], scripts, strict=True)
    return bracketed_base + "".join(f"{mark}({text})" for mark, part, text in marked_scripts if part.inner or part.text)


def _print_fenced(piece: Layout, inside: str) -> str:
    opening, closing = (_escape_sign(sign) if sign != "." else "" for sign in piece.text)
    return f"lr({opening} {inside} {closing})"


def _print_table(piece: Layout, *rows: list[str]) -> str:
    cell_separator, row_separator = (" & ", " \\ ") if piece.kind == "aligned" else (", ", "; ")
    if piece.text == "{.":
        return f"cases({', '.join(map(' & '.join, rows))})"
    table = row_separator.join(map(cell_separator.join, rows))
    return table if piece.kind == "aligned" else f"mat(delim: {_MATRIX_DELIMITERS[piece.text]}, {table})"


def _escape_sign(text: str) -> str:
    """Return a text with a backslash before a sign that has a meaning in Typst."""
    return f"\\{text}" if len(text) == 1 and text in "()[]{},;:|/*'_^&#$\"\\⟨⟩⌊⌋⌈⌉√∛∜" else text


_PRINTERS: dict[str, Callable[..., str]] = {
    **dict.fromkeys(("letter", "number", "sign"), _print_sign),
    "text": lambda piece: quote_for_typst(piece.text),
    "function": lambda piece: f'op("{piece.text}"{_LIMITS_OPTION * (piece.text in SYMBOLS["functions_with_limits"])})',
    "space": lambda piece: f"#h({round(SPACES[piece.text], 2)}em)",
    "row": lambda _, *pieces: " ".join(pieces) or '""',
    "script": _print_script,
    "fraction": lambda piece, *operands: _FRACTION_TEMPLATES[piece.text].format(*operands),
    "root": lambda _, inside: f"sqrt({inside})",
    "accent": lambda piece, inside: f"{ACCENTS[piece.text].typst_name}({inside})",
    "fenced": _print_fenced,
    **dict.fromkeys(("matrix", "aligned"), _print_table),
}
