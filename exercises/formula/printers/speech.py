"""Print formulas in words, for screen readers: the alternative text of an equation in a tagged PDF."""

from collections.abc import Callable
from functools import lru_cache

from qdot.exercises.formula.latex import LETTERS
from qdot.exercises.formula.layout import SPACES, SYMBOLS, Layout, print_layout

_LETTER_NAMES = {char: name for name, char in LETTERS.items()} | {"φ": "phi", "□": "blank", "′": "prime"}
_POWER_WORDS = {"2": "squared", "3": "cubed", "T": "transposed", "minus 1": "inverse"}
_POWER_WORDS |= {word: word for word in ("prime", "degrees", "star")}


@lru_cache(maxsize=1024)
def speak(formula: Layout) -> str:
    r"""Return a formula in words.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> speak(parse_latex(r"\dot{\theta}_{1} = -\frac{a_{1} s_{12}}{2}"))
    'theta dot 1 equals minus (a 1 s 12) over 2'
    """
    words = print_layout(formula, _PRINTERS).replace(" ,", ",").replace("( ", "(").replace(" )", ")")
    return " ".join(words.split())


def _speak_script(_: Layout, base: str, subscript: str, superscript: str) -> str:
    power = _POWER_WORDS.get(superscript, f"to the power {superscript}") if superscript else ""
    return " ".join(filter(None, (base, subscript, power)))


def _bracket_words(words: str) -> str:
    """Return several words in brackets, a single word unchanged."""
    return words if len(words.split()) == 1 else f"({words})"


def _speak_matrix(_: Layout, *rows: list[str]) -> str:
    if len(rows[0]) == 1:
        return f"column with entries {'; '.join(row[0] for row in rows)}; end of column"
    row_texts = "; ".join(f"row {number}: {', '.join(row)}" for number, row in enumerate(rows, 1))
    return f"matrix of {len(rows)} rows and {len(rows[0])} columns, {row_texts}; end of matrix"


_PRINTERS: dict[str, Callable[..., str]] = {
    "letter": lambda piece: _LETTER_NAMES.get(piece.text, piece.text),
    "word": lambda piece: SYMBOLS["spoken_functions"].get(piece.text, piece.text),
    "sign": lambda piece: SYMBOLS["spoken_signs"].get(piece.text, piece.text),
    **dict.fromkeys(("number", "text"), lambda piece: piece.text),
    "space": lambda piece: ", " if SPACES[piece.text] >= 1 else " ",
    "row": lambda _, *pieces: " ".join(pieces),
    "script": _speak_script,
    "fraction": lambda _, numerator, divisor: f"{_bracket_words(numerator)} over {_bracket_words(divisor)}",
    "root": lambda _, inside: f"the square root of {_bracket_words(inside)}",
    "dotted": lambda _, letter: f"{letter} dot",
    "fenced": lambda piece, inside: f" {piece.text[0].strip('.')} {inside} {piece.text[1].strip('.')} ",
    "aligned": lambda _, *rows: "; ".join(map(" ".join, rows)),
    "matrix": _speak_matrix,
}
