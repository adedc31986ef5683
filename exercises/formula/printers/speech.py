"""Print formulas in words, for screen readers: the alternative text of an equation in a tagged PDF."""

from collections.abc import Callable
from functools import lru_cache

from qdot.exercises.formula.latex import LETTERS
from qdot.exercises.formula.layout import ACCENTS, SPACES, SYMBOLS, Layout, print_layout
from qdot.exercises.formula.styles import STYLED_LETTERS

_LETTER_NAMES = {char: name for name, char in LETTERS.items()} | SYMBOLS["spoken_letters"]
_STYLE_NAMES = {"mathbf": "bold", "boldsymbol": "bold", "mathbb": "double", "mathcal": "script"}
_LETTER_NAMES |= {
    char: " ".join(filter(None, (_STYLE_NAMES.get(command), _LETTER_NAMES.get(letter, letter))))
    for char, (command, letter) in STYLED_LETTERS.items()
}
_SIGNS_WITH_BOUNDS = frozenset("∑∏∫")
_POWER_WORDS = {"2": "squared", "3": "cubed", "T": "transposed", "minus 1": "inverse"}
_POWER_WORDS |= {word: word for word in ("prime", "degrees", "star")}


@lru_cache(maxsize=1024)
def print_speech(formula: Layout) -> str:
    r"""Return a formula in words.

    >>> from qdot.exercises.formula.latex import parse_latex
    >>> print_speech(parse_latex(r"\dot{\theta}_{1} = -\frac{a_{1} s_{12}}{2}"))
    'theta dot 1 equals minus (a 1 s 12) over 2'
    """
    words = print_layout(formula, _PRINTERS).replace(" ,", ",").replace("( ", "(").replace(" )", ")")
    return " ".join(words.split())


def _speak_script(piece: Layout, base: str, subscript: str, superscript: str) -> str:
    if subscript and superscript and piece.inner[0].text in _SIGNS_WITH_BOUNDS:
        return f"{base} from {subscript} to {superscript} of"
    power = _POWER_WORDS.get(superscript, f"to the power {superscript}") if superscript else ""
    return " ".join(filter(None, (base, subscript, power)))


def _bracket_words(words: str) -> str:
    """Return several words in brackets, a single word unchanged."""
    return words if len(words.split()) == 1 else f"({words})"


def _speak_accent(piece: Layout, inside: str) -> str:
    is_long = len(piece.inner[0].inner) > 1
    return f"{_bracket_words(inside) if is_long else inside} {ACCENTS[piece.text].words}"


def _speak_bracket(sign: str) -> str:
    spoken_sign: str = SYMBOLS["spoken_signs"].get(sign, sign)
    return "" if sign == "." else spoken_sign


def _speak_matrix(piece: Layout, *rows: list[str]) -> str:
    if piece.text == "{.":
        return f"cases: {'; '.join(map(' '.join, rows))}; end of cases"
    if len(rows[0]) == 1:
        return f"column with entries {'; '.join(row[0] for row in rows)}; end of column"
    row_texts = "; ".join(f"row {number}: {', '.join(row)}" for number, row in enumerate(rows, 1))
    name = {"||": "determinant of a matrix", "‖‖": "norm of a matrix"}.get(piece.text, "matrix")
    return f"{name} of {len(rows)} rows and {len(rows[0])} columns, {row_texts}; end of matrix"


_PRINTERS: dict[str, Callable[..., str]] = {
    "letter": lambda piece: _LETTER_NAMES.get(piece.text, piece.text),
    "function": lambda piece: SYMBOLS["spoken_functions"].get(piece.text, piece.text),
    "sign": lambda piece: SYMBOLS["spoken_signs"].get(piece.text, piece.text),
    **dict.fromkeys(("number", "text"), lambda piece: piece.text),
    "space": lambda piece: ", " if SPACES[piece.text] >= 1 else " ",
    "row": lambda _, *pieces: " ".join(pieces),
    "script": _speak_script,
    "fraction": lambda _, numerator, divisor: f"{_bracket_words(numerator)} over {_bracket_words(divisor)}",
    "root": lambda _, inside: f"the square root of {_bracket_words(inside)}",
    "accent": _speak_accent,
    "fenced": lambda piece, inside: f" {_speak_bracket(piece.text[0])} {inside} {_speak_bracket(piece.text[1])} ",
    "aligned": lambda _, *rows: "; ".join(map(" ".join, rows)),
    "matrix": _speak_matrix,
}
