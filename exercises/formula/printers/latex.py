r"""Print formulas as LaTeX, with spaces between factors and around signs, as in c_{1} (a_{1} + a_{2})."""

from functools import lru_cache
from itertools import pairwise

from qdot.exercises.formula.latex import LETTERS, PRIMES, SIGNS
from qdot.exercises.formula.layout import EMPTY, MINUS, PLUS, THIN, Layout, Pieces, base, is_binary, parts, row

_COMMANDS = {char: f"\\{name}" for known in (SIGNS, LETTERS) for name, char in reversed(known.items())} | {"−": "-"}
_AROUND, _OPENS, _CLOSES = "=≠<>≤≥≈∈→⋅×±", "([{/+−", ")]},;/."
_STAR = Layout("sign", "*")


@lru_cache(maxsize=2048)
def latex(formula: Layout) -> str:
    r"""Return a formula as LaTeX.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> latex(parse_latex(r"-\frac a2\cos(x_{1}-1)"))
    '-\\frac{a}{2} \\cos(x_{1} - 1)'
    """
    return _row(formula.inner) if formula.kind == "row" else _piece(formula)


def _row(pieces: Pieces) -> str:
    text, previous, previous_is_binary = "", None, False
    for piece in pieces:
        is_binary_sign = piece in (MINUS, PLUS) and is_binary(previous)
        if previous is not None and (is_binary_sign or previous_is_binary or not _touch(previous, piece)):
            text += " "
        text += _piece(piece)
        previous, previous_is_binary = piece, is_binary_sign
    return text


def _index(index: Layout) -> str:
    """Return a subscript or superscript, without spaces next to signs."""
    if index.kind != "row":
        return _piece(index)
    text = _piece(index.inner[0])
    for previous, piece in pairwise(index.inner):
        text += ("" if "sign" in (previous.kind, piece.kind) else " ") + _piece(piece)
    return f"{{{text}}}"


def _touch(before: Layout, piece: Layout) -> bool:
    """Return whether two pieces have no space between them."""
    if _is_sign(before, _AROUND) or _is_sign(piece, _AROUND):
        return False
    if _is_sign(before, _OPENS) or _is_sign(base(piece), _CLOSES) or piece == THIN:
        return True
    if before == THIN:
        return piece.kind == "text"
    if before.kind == "script" and before.inner[0] == EMPTY:  # {}^{0}z_{1}
        return True
    return (base(piece).kind == "fenced" or base(piece).text == "(") and base(before).kind in ("word", "text")


def _is_sign(piece: Layout, signs: str) -> bool:
    return piece.kind == "sign" and piece.text in signs


def _piece(piece: Layout) -> str:
    kind, text, inner = piece
    if kind in ("letter", "sign"):
        return _COMMANDS.get(text, text)
    if kind == "number":
        return text.replace(",", "{,}")
    if kind == "script":
        return _script(*inner)
    if kind == "row":
        return f"{{{_row(inner)}}}"
    if kind in ("word", "space"):
        return f"\\{text}"
    if kind == "text":
        return rf"\text{{{text}}}"
    if kind in ("fraction", "root", "dotted"):  # their text is their command
        return f"\\{text}{''.join(f'{{{latex(part)}}}' for part in inner)}"
    if kind == "fenced":
        left, right = (f"\\{bracket}" if bracket in "{}" else bracket for bracket in text)
        return rf"\left{left}{latex(inner[0])}\right{right}"
    name, separator = ("bmatrix", r" \\ ") if kind == "matrix" else ("aligned", r" \\[6pt] " if text else r" \\ ")
    rows = separator.join(" & ".join(map(latex, cells.inner)) for cells in inner)
    return rf"\begin{{{name}}} {rows} \end{{{name}}}"


@lru_cache(maxsize=2048)
def _script(foot: Layout, below: Layout, above: Layout) -> str:
    first, *others = *parts(above), EMPTY
    primes = PRIMES.find(first.text) + 1 if first.text else 0
    above = row(*others[:-1]) if primes else above
    text = f"{_piece(foot)}{chr(39) * primes}"
    scripts = ("_", below), ("^", above)
    for mark, part in reversed(scripts) if above == _STAR else scripts:  # p^*_{1}
        text += f"{mark}{_index(part)}" if part.inner or part.text else ""
    return text
