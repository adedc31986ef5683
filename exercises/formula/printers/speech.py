"""Formulas in words, for those who hear a page: the text that stands for an equation in a tagged PDF."""

from functools import lru_cache

from qdot.exercises.formula.latex import LETTERS
from qdot.exercises.formula.layout import SPACES, Layout

_NAMES = {char: name for name, char in LETTERS.items()} | {"φ": "phi", "□": "blank", "′": "prime"}
_SIGNS = {
    "+": "plus", "−": "minus", "=": "equals", "×": "times", "⋅": "times", "≠": "is not", "≤": "is at most",
    "≥": "is at least", "≈": "is about", "∂": "partial", "∑": "sum", "±": "plus or minus", "∈": "is in", "→": "to",
    "⋯": "and so on", "…": "and so on", "∘": "degrees", "/": "over", "|": "bar",
    "*": "star", "%": "per cent", "<": "is less than", ">": "is greater than",
}  # fmt: skip
_POWERS = {"2": "squared", "3": "cubed", "T": "transposed", "minus 1": "inverse"}
_POWERS |= {word: word for word in ("prime", "degrees", "star")}
_WORDS = {
    "sin": "sine", "cos": "cosine", "tan": "tangent", "det": "determinant of", "ln": "natural logarithm of",
    "arcsin": "arc sine", "arccos": "arc cosine", "arctan": "arc tangent", "exp": "exponential of",
}  # fmt: skip


@lru_cache(maxsize=1024)
def spoken(formula: Layout) -> str:
    r"""Return a formula in words.

    >>> from qdot.exercises.formula.latex import parsed
    >>> spoken(parsed(r"\dot{\theta}_{1} = -\frac{a_{1} s_{12}}{2}"))
    'theta dot 1 equals minus (a 1 s 12) over 2'
    """
    return " ".join(_said(formula).replace(" ,", ",").replace("( ", "(").replace(" )", ")").split())


def _said(one: Layout) -> str:
    inner = one.inner
    if one.kind == "letter":
        return _NAMES.get(one.text, one.text)
    if one.kind == "word":
        return _WORDS.get(one.text, one.text)
    if one.kind == "sign":
        return _SIGNS.get(one.text, one.text)
    if one.kind == "space":
        return ", " if SPACES[one.text] >= 1 else " "
    if one.kind == "row":
        return " ".join(map(_said, inner))
    if one.kind == "script":
        return _script(*map(_said, inner))
    if one.kind == "fraction":
        above, below = map(_grouped, inner)
        return f"{above} over {below}"
    if one.kind == "root":
        return f"the square root of {_grouped(inner[0])}"
    if one.kind == "dotted":
        return f"{_said(inner[0])} dot"
    if one.kind == "fenced":
        return f" {one.text[0].strip('.')} {_said(inner[0])} {one.text[1].strip('.')} "
    if one.kind in ("matrix", "aligned"):
        return _table(one)
    return one.text


def _script(base: str, below: str, above: str) -> str:
    power = _POWERS.get(above, f"to the power {above}") if above else ""
    return " ".join(filter(None, (base, below, power)))


def _grouped(one: Layout) -> str:
    said = _said(one)
    return said if len(said.split()) == 1 else f"({said})"


def _table(one: Layout) -> str:
    rows = [[_said(cell) for cell in row.inner] for row in one.inner]
    if one.kind == "aligned":
        return "; ".join(" ".join(row) for row in rows)
    if len(rows[0]) == 1:
        return f"column with entries {'; '.join(row[0] for row in rows)}; end of column"
    listed = "; ".join(f"row {number}: {', '.join(row)}" for number, row in enumerate(rows, 1))
    return f"matrix of {len(rows)} rows and {len(rows[0])} columns, {listed}; end of matrix"
