r"""Print formulas as LaTeX that people can read: with spaces as in c_{1} (a_{1} + a_{2})."""

from functools import lru_cache
from itertools import pairwise

from qdot.exercises.formula.latex import LETTERS, PRIMES, SIGNS
from qdot.exercises.formula.layout import (
    EMPTY,
    MINUS,
    PLUS,
    SYMBOLS,
    THIN,
    Layout,
    Pieces,
    can_end_term,
    get_script_base,
    list_row_pieces,
    make_row,
)
from qdot.exercises.formula.styles import STYLED_LETTERS

_NAMES_AND_CHARACTERS = [*reversed(SIGNS.items()), *reversed(LETTERS.items())]
"""Names of commands and their characters, reversed, so that the first name of a character is used."""
_COMMANDS = {char: f"\\{name}" for name, char in _NAMES_AND_CHARACTERS if not char.isascii() or char in "{}%"}
_COMMANDS |= {"−": "-"}
_COMMANDS |= {
    char: f"\\{command}{{{_COMMANDS.get(letter, letter)}}}" for char, (command, letter) in STYLED_LETTERS.items()
}
"""Maps each character that LaTeX writes with a command to its LaTeX."""
_TABLES = {brackets: name for name, brackets in SYMBOLS["tables"].items()}
"""Maps the brackets of a matrix to its environment."""
_SPACED_SIGNS, _NO_SPACE_AFTER, _NO_SPACE_BEFORE = "=≠<>≤≥≈∈→⋅×±", "([{/+−", ")]},;/."
"""Signs with a space on both sides, signs without a space after them, and signs without a space before them."""
_STAR = Layout("sign", "*")


@lru_cache(maxsize=2048)
def print_latex(formula: Layout) -> str:
    r"""Return a formula as LaTeX.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> print_latex(parse_latex(r"-\frac a2\cos(x_{1}-1)"))
    '-\\frac{a}{2} \\cos(x_{1} - 1)'
    """
    return _print_row(formula.inner) if formula.kind == "row" else _print_piece(formula)


def _print_row(pieces: Pieces) -> str:
    """Return pieces side by side, with spaces between factors and around signs."""
    text, previous_piece, has_space = "", None, False
    for piece in pieces:
        is_binary_sign = piece in (MINUS, PLUS) and can_end_term(previous_piece)
        if previous_piece is not None:
            text += " " * (has_space or is_binary_sign or not _are_joined(previous_piece, piece))
        text += _print_piece(piece)
        previous_piece, has_space = piece, is_binary_sign
    return text


def _print_index(script_piece: Layout) -> str:
    """Return a subscript or a superscript, without spaces next to signs."""
    if script_piece.kind != "row":
        return _print_piece(script_piece)
    text = _print_piece(script_piece.inner[0])
    for previous_piece, piece in pairwise(script_piece.inner):
        text += ("" if "sign" in (previous_piece.kind, piece.kind) else " ") + _print_piece(piece)
    return f"{{{text}}}"


def _are_joined(previous_piece: Layout, piece: Layout) -> bool:
    """Return whether two pieces have no space between them."""
    if _is_sign(previous_piece, _SPACED_SIGNS) or _is_sign(piece, _SPACED_SIGNS):
        return False
    if _is_sign(previous_piece, _NO_SPACE_AFTER) or _is_sign(get_script_base(piece), _NO_SPACE_BEFORE) or piece == THIN:
        return True
    if previous_piece == THIN:
        return piece.kind == "text"
    if previous_piece.kind == "script" and previous_piece.inner[0] == EMPTY:  # {}^{0}z_{1}
        return True
    base = get_script_base(piece)
    return (base.kind == "fenced" or base.text == "(") and get_script_base(previous_piece).kind in ("function", "text")


def _is_sign(piece: Layout, signs: str) -> bool:
    return piece.kind == "sign" and piece.text in signs


def _print_piece(piece: Layout) -> str:
    kind, text, inner = piece
    if kind in ("letter", "sign"):
        return _COMMANDS.get(text, text)
    if kind == "number":
        return text.replace(",", "{,}")
    if kind == "script":
        return _print_script(*inner)
    if kind == "row":
        return f"{{{_print_row(inner)}}}"
    if kind == "function" and text not in SYMBOLS["functions"]:
        return rf"\operatorname{{{text}}}"
    if kind in ("function", "space"):
        return f"\\{text}"
    if kind == "text":
        return rf"\text{{{text}}}"
    if kind in ("fraction", "root", "accent"):  # the text is the command
        return f"\\{text}{''.join(f'{{{print_latex(part)}}}' for part in inner)}"
    if kind == "fenced":
        left_bracket, right_bracket = (_COMMANDS.get(bracket, bracket) for bracket in text)
        left_bracket += " " * left_bracket[-1].isalpha()
        return rf"\left{left_bracket}{print_latex(inner[0])}\right{right_bracket}"
    name, separator = (_TABLES[text], r" \\ ") if kind == "matrix" else ("aligned", r" \\[6pt] " if text else r" \\ ")
    rows = separator.join(" & ".join(map(print_latex, cells.inner)) for cells in inner)
    return rf"\begin{{{name}}} {rows} \end{{{name}}}"


@lru_cache(maxsize=2048)
def _print_script(base_piece: Layout, subscript: Layout, superscript: Layout) -> str:
    """Return a base with its scripts; a prime at the start of the superscript becomes an apostrophe."""
    superscript_pieces = list_row_pieces(superscript)
    has_text = bool(superscript_pieces) and superscript_pieces[0].text != ""
    prime_count = PRIMES.find(superscript_pieces[0].text) + 1 if has_text else 0
    superscript_after_primes = make_row(*superscript_pieces[1:]) if prime_count else superscript
    text = _print_piece(base_piece) + "'" * prime_count
    scripts = ("_", subscript), ("^", superscript_after_primes)
    for mark, part in reversed(scripts) if superscript == _STAR else scripts:  # p^*_{1}
        text += f"{mark}{_print_index(part)}" if part.inner or part.text else ""
    return text
