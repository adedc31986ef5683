r"""Our own LaTeX formulas as trees, for printers of other notations: what latex.py, the templates and `fit` write.

Whatever else LaTeX knows is refused, by name, so that a test over all families notices what a printer can't say.
"""

import re
from dataclasses import dataclass
from functools import lru_cache

LETTERS = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "theta": "θ", "kappa": "κ", "lambda": "λ", "mu": "μ",
    "pi": "π", "rho": "ρ", "sigma": "σ", "tau": "τ", "varphi": "φ", "phi": "φ", "psi": "ψ", "omega": "ω",
    "Delta": "Δ", "Omega": "Ω", "square": "□",
}  # fmt: skip
SIGNS = {
    "times": "×", "cdot": "⋅", "neq": "≠", "ne": "≠", "le": "≤", "leq": "≤", "ge": "≥", "geq": "≥", "approx": "≈",
    "partial": "∂", "sum": "∑", "pm": "±", "in": "∈", "to": "→", "cdots": "⋯", "dots": "…", "ldots": "…",
    "circ": "°", "{": "{", "}": "}", "%": "%", "|": "‖",
}  # fmt: skip
WORDS = ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "ln", "log", "exp", "det", "min", "max", "rank")
SPACES = {",": 0.17, ":": 0.22, ";": 0.28, " ": 0.33, "quad": 1.0, "qquad": 2.0, "!": -0.17}
SIZED = {"frac": "", "tfrac": "small", "dfrac": "large"}
BRACKETS = {"bmatrix": "[]", "pmatrix": "()", "aligned": ""}
_TOKEN = re.compile(r"\\text\{[^{}]*\}|\\[a-zA-Z]+|\\\\(?:\[\d+pt\])?|\\.|\d+(?:\.\d+)?|\S")


class UnknownLatex(ValueError):
    """A formula that is not of the LaTeX that qdot writes."""


@dataclass(frozen=True)
class Formula:
    """A piece of a formula: of a `kind`, with `text` or made of `inner` pieces.

    letter, number, sign, word, text: `text` is shown. space: `text` is its width in em. row: pieces side by side.
    script: base, what is below, what is above, these being empty rows where there is nothing. fraction: above and
    below the line; `text` is "small" or "large" where its size is told. root, dotted: what is below. fenced: `text`
    holds two brackets, "." for none. table: `text` holds two brackets, or nothing where lines are aligned; its pieces
    are rows of cells.
    """

    kind: str
    text: str = ""
    inner: tuple["Formula", ...] = ()


EMPTY = Formula("row")


@lru_cache(maxsize=1024)
def parsed(latex: str) -> Formula:
    r"""Return the tree of a formula. Raises UnknownLatex.

    >>> parsed("a_{1}").inner[0].kind, parsed("a_{1}").inner[0].inner[1].inner[0].text
    ('script', '1')
    """
    reader = _Reader(_TOKEN.findall(latex), latex)
    found = reader.row(())
    if reader.tokens:
        raise reader.unknown(reader.tokens[-1])
    return found


class _Reader:
    """Reads tokens from the front; they are kept the other way round."""

    def __init__(self, tokens: list[str], latex: str) -> None:
        self.tokens, self.latex = tokens[::-1], latex

    def unknown(self, what: str) -> UnknownLatex:
        return UnknownLatex(f"{what!r} in {self.latex!r}")

    def take(self, wanted: str = "") -> str:
        if not self.tokens or (wanted and self.tokens[-1] != wanted):
            raise self.unknown(self.tokens[-1] if self.tokens else "the end")
        return self.tokens.pop()

    def row(self, ends: tuple[str, ...]) -> Formula:
        """Return what stands before any of `ends`, or before the formula's end."""
        pieces: list[Formula] = []
        while self.tokens and not self.tokens[-1].startswith(ends or ("}",)):
            if self.tokens[-1] in ("_", "^", "'"):
                pieces.append(self.script(pieces.pop() if pieces else EMPTY))
            else:
                pieces.append(self.piece())
        return pieces[0] if len(pieces) == 1 and pieces[0].kind == "row" else Formula("row", inner=tuple(pieces))

    def script(self, base: Formula) -> Formula:
        below, above = EMPTY, EMPTY
        while self.tokens and self.tokens[-1] in ("_", "^", "'"):
            mark = self.take()
            if mark == "'":
                above = Formula("row", inner=(*above.inner, Formula("sign", "′")))
            elif mark == "_":
                below = self.argument()
            else:
                more = self.argument()
                above = Formula("row", inner=(*above.inner, *(more.inner if more.kind == "row" else (more,))))
        if above == Formula("row", inner=(Formula("sign", "°"),)):  # 90^\circ
            return Formula("row", inner=(base, Formula("sign", "°")))
        return Formula("script", inner=(base, below, above))

    def argument(self) -> Formula:
        if self.tokens and self.tokens[-1] == "{":
            return self.group()
        one = self.piece()
        return one if one.kind == "row" else Formula("row", inner=(one,))

    def group(self) -> Formula:
        self.take("{")
        found = self.row(("}",))
        self.take("}")
        return found

    def piece(self) -> Formula:
        found = self.take()
        if found == "{":
            self.tokens.append(found)
            return self.group()
        if found[0] == "\\":
            return self.command(found[1:])
        if found[0].isdigit():
            return Formula("number", found)
        sign = "−" if found == "-" else found
        return Formula("letter" if found.isalpha() else "sign", sign)

    def command(self, name: str) -> Formula:
        if name.startswith("text{"):
            return Formula("text", name[5:-1])
        for kind, known in (("letter", LETTERS), ("sign", SIGNS)):
            if name in known:
                return Formula(kind, known[name])
        if name in WORDS:
            return Formula("word", name)
        if name in SPACES:
            return Formula("space", str(SPACES[name]))
        if name in SIZED:
            return Formula("fraction", SIZED[name], (self.argument(), self.argument()))
        if name in ("sqrt", "dot"):
            return Formula({"sqrt": "root", "dot": "dotted"}[name], inner=(self.argument(),))
        if name == "left":
            return self.fenced()
        if name == "begin":
            return self.table()
        raise self.unknown(f"\\{name}")

    def fenced(self) -> Formula:
        opening = self.take().removeprefix("\\")
        inside = self.row((r"\right",))
        self.take(r"\right")
        return Formula("fenced", opening + self.take().removeprefix("\\"), (inside,))

    def table(self) -> Formula:
        self.take("{")
        name = ""
        while self.tokens and self.tokens[-1] != "}":
            name += self.take()
        self.take("}")
        if name not in BRACKETS:
            raise self.unknown(name)
        rows: list[list[Formula]] = [[]]
        while True:
            rows[-1].append(self.row(("&", "\\\\", r"\end")))
            mark = self.take()
            if mark.startswith("\\\\"):
                rows.append([])
            elif mark != "&":
                break
        for sign in ("{", *name, "}"):
            self.take(sign)
        lines = tuple(Formula("row", inner=tuple(cells)) for cells in rows)
        return Formula("table", BRACKETS[name], lines)
