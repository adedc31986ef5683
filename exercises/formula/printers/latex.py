r"""Print formulas as LaTeX that people can read: with spaces as in c_{1} (a_{1} + a_{2})."""

from functools import lru_cache
from itertools import pairwise

from qdot.exercises.formula import layout
from qdot.exercises.formula.latex import LETTERS, PRIMES, SIGNS
from qdot.exercises.formula.layout import (
    EMPTY,
    MINUS,
    PLUS,
    SYMBOLS,
    THIN,
    Layout,
    Pieces,
    get_script_base,
    is_binary,
    row,
)
from qdot.exercises.formula.styles import STYLED_LETTERS

_SYMBOLS = [*reversed(SIGNS.items()), *reversed(LETTERS.items())]
_COMMANDS = {char: f"\\{name}" for name, char in _SYMBOLS if not char.isascii() or char in "{}%"} | {"−": "-"}
_COMMANDS |= {
    char: f"\\{command}{{{_COMMANDS.get(plain, plain)}}}" for char, (command, plain) in STYLED_LETTERS.items()
}
_TABLES = {brackets: name for name, brackets in SYMBOLS["tables"].items()}
_SPACED_SIGNS, _NO_SPACE_AFTER, _NO_SPACE_BEFORE = "=≠<>≤≥≈∈→⋅×±", "([{/+−", ")]},;/."
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
    text, previous, has_space = "", None, False
    for piece in pieces:
        is_binary_sign = piece in (MINUS, PLUS) and is_binary(previous)
        if previous is not None:
            text += " " * (has_space or is_binary_sign or not _are_joined(previous, piece))
        text += _print_piece(piece)
        previous, has_space = piece, is_binary_sign
    return text


def _print_index(script_piece: Layout) -> str:
    """Return a subscript or a superscript, without spaces next to signs."""
    if script_piece.kind != "row":
        return _print_piece(script_piece)
    text = _print_piece(script_piece.inner[0])
    for previous, piece in pairwise(script_piece.inner):
        text += ("" if "sign" in (previous.kind, piece.kind) else " ") + _print_piece(piece)
    return f"{{{text}}}"


def _are_joined(previous: Layout, piece: Layout) -> bool:
    """Return whether two pieces have no space between them."""
    if _is_sign(previous, _SPACED_SIGNS) or _is_sign(piece, _SPACED_SIGNS):
        return False
    if _is_sign(previous, _NO_SPACE_AFTER) or _is_sign(get_script_base(piece), _NO_SPACE_BEFORE) or piece == THIN:
        return True
    if previous == THIN:
        return piece.kind == "text"
    if previous.kind == "script" and previous.inner[0] == EMPTY:  # {}^{0}z_{1}
        return True
    base = get_script_base(piece)
    return (base.kind == "fenced" or base.text == "(") and get_script_base(previous).kind in ("word", "text")


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
    if kind == "word" and text not in SYMBOLS["words"]:
        return rf"\operatorname{{{text}}}"
    if kind in ("word", "space"):
        return f"\\{text}"
    if kind == "text":
        return rf"\text{{{text}}}"
    if kind in ("fraction", "root", "accent"):  # their text is their command
        return f"\\{text}{''.join(f'{{{print_latex(part)}}}' for part in inner)}"
    if kind == "fenced":
        left, right = (_COMMANDS.get(bracket, bracket) for bracket in text)
        left += " " * left[-1].isalpha()
        return rf"\left{left}{print_latex(inner[0])}\right{right}"
    name, separator = (_TABLES[text], r" \\ ") if kind == "matrix" else ("aligned", r" \\[6pt] " if text else r" \\ ")
    rows = separator.join(" & ".join(map(print_latex, cells.inner)) for cells in inner)
    return rf"\begin{{{name}}} {rows} \end{{{name}}}"


@lru_cache(maxsize=2048)
def _print_script(base_piece: Layout, subscript: Layout, superscript: Layout) -> str:
    first_piece, *other_pieces = *layout.row_pieces(superscript), EMPTY
    primes = PRIMES.find(first_piece.text) + 1 if first_piece.text else 0
    superscript = row(*other_pieces[:-1]) if primes else superscript
    text = f"{_print_piece(base_piece)}{chr(39) * primes}"
    scripts = ("_", subscript), ("^", superscript)
    for mark, part in reversed(scripts) if superscript == _STAR else scripts:  # p^*_{1}
        text += f"{mark}{_print_index(part)}" if part.inner or part.text else ""
    return text
