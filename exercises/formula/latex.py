"""Parse LaTeX from qdot or from an instructor as a layout (`layout`). symbols.json lists the supported commands.

Any other command is an error, so that every parsed formula can be printed in all notations. LaTeX in students' answers
is parsed by `notation`, for its meaning.
"""

import re
from functools import lru_cache

from qdot.exercises.formula.layout import ACCENTS, EMPTY, SPACES, SYMBOLS, Layout, list_row_pieces
from qdot.exercises.formula.styles import STYLES, apply_style

LETTERS: dict[str, str] = SYMBOLS["letters"]
SIGNS: dict[str, str] = SYMBOLS["signs"]
PRIMES = "′″‴"
_COMMANDS = {
    **{name: Layout("letter", char) for name, char in LETTERS.items()},
    **{name: Layout("sign", char) for name, char in SIGNS.items()},
    **{name: Layout("function", name) for name in SYMBOLS["functions"]},
    **{name: Layout("space", name) for name in SPACES},
}
"""Maps each command without arguments to its layout."""
_ONE_ARGUMENT_COMMANDS = {"sqrt": "root", **dict.fromkeys(ACCENTS, "accent")}
"""Maps each command with one argument to the kind of its layout."""
_TABLES: dict[str, str] = SYMBOLS["tables"]
"""Maps each environment for a matrix to the matrix's brackets."""
_UPRIGHT_TEXT_COMMANDS = ("text{", "textrm{", "mathrm{")
_DELIMITERS = {sign: sign for sign in "()[]|./<>"} | {f"\\{name}": char for name, char in SIGNS.items()}
"""Maps the LaTeX of each bracket after \\left or \\right to its character."""
_SIZE_COMMANDS = frozenset((
    *(r"\displaystyle", r"\textstyle", r"\limits", r"\nolimits", r"\middle"),
    *(f"\\{size}{side}" for size in ("big", "Big", "bigg", "Bigg") for side in ("", "l", "r", "m")),
))  # fmt: skip
"""Commands that change only sizes and positions, which printers choose themselves."""
COMMAND_NAMES = (
    *filter(str.isalpha, _COMMANDS), *_ONE_ARGUMENT_COMMANDS, *STYLES, "frac", "tfrac", "dfrac", "text", "textrm",
    "operatorname", "left", "right", "begin", "end",
)  # fmt: skip
"""The names of all commands that can be parsed, without those for sizes."""
_SCRIPT_MARKS = ("_", "^", "'")
_REFUSED_SIGNS = frozenset("&}$#%~\\")
_GROUP_COMMANDS = r"text|textrm|operatorname\*?|begin|end"
_TOKEN = re.compile(
    rf"\\(?:{_GROUP_COMMANDS})\{{[^{{}}]*\}}|\\mathrm\{{[^{{}}\\^_]*\}}|\\[a-zA-Z]+|\\\\(?:\[\d+pt\])?|\\.|\d+(?:(?:\.|\{{,\}})\d+)?|\S"
)
"""Matches a command, with its text if it is a text command, a line break, a number or any other character."""
MARKDOWN_FORMULA = re.compile(r"```.*?```|`[^`]+`|(?<!\\)\$\$(.+?)\$\$|(?<!\\)\$([^$]+?)\$", re.DOTALL)
"""Matches a formula in Markdown: its first group if the formula is displayed, else its second group.

It also matches code, because a dollar sign in code does not begin a formula.
"""

_PROBLEMS = {
    "": r"a closing brace, \right or \end is missing",
    "}": "a closing brace has no opening brace",
    "__": "a symbol has two subscripts",
    "^^": "a symbol has two superscripts",
    "&": "the sign & stands outside a matrix",
    "\\\\": "a line break stands outside a matrix",
}
"""Describes the error if a token is in a wrong place. The token "" is the end of the formula."""


class UnknownLatex(ValueError):
    """Raised for LaTeX that qdot can't print.

    `problem` says why, without the formula; `command` is the unsupported command, or "" if a sign is in a wrong place.
    """

    def __init__(self, token: str, latex: str) -> None:
        self.problem = _PROBLEMS.get(token) or f"{token} is not supported"
        self.command = "" if token in _PROBLEMS else token
        super().__init__(f"{self.problem} in {latex!r}")


@lru_cache(maxsize=2048)
def parse_latex(latex: str) -> Layout:
    r"""Return the layout of a formula. Raises UnknownLatex.

    >>> parse_latex("a_{1}").inner[0].kind, parse_latex("a_{1}").inner[0].inner[1].inner[0].text
    ('script', '1')
    """
    reader = _Reader([token for token in _TOKEN.findall(latex) if token not in _SIZE_COMMANDS], latex)
    layout = reader.read_row(("}",))
    if reader.tokens:  # an unmatched brace
        raise reader.make_error(reader.tokens[-1])
    return layout


class _Reader:
    """Parses tokens. `tokens` has them in reverse order, so that the next token can be popped from the end."""

    def __init__(self, tokens: list[str], latex: str) -> None:
        self.tokens, self.latex = tokens[::-1], latex

    def make_error(self, token: str) -> UnknownLatex:
        return UnknownLatex(token, self.latex)

    def take(self, expected_token: str = "") -> str:
        if not self.tokens or (expected_token and self.tokens[-1] != expected_token):
            raise self.make_error(self.tokens[-1] if self.tokens else "")
        return self.tokens.pop()

    def read_row(self, end_tokens: tuple[str, ...]) -> Layout:
        """Return the row of all pieces before a token that begins with one of `end_tokens`, or before the end."""
        pieces: list[Layout] = []
        while self.tokens and not self.tokens[-1].startswith(end_tokens):
            if self.tokens[-1] in _SCRIPT_MARKS:
                pieces.append(self.read_script(pieces.pop() if pieces else EMPTY))
            else:
                pieces.append(self.read_piece())
        return Layout("row", "", tuple(pieces))

    def read_script(self, base: Layout) -> Layout:
        """Return a base with the subscript, the superscript and the primes that follow it."""
        subscript, superscript, primes = EMPTY, EMPTY, 0
        while self.tokens and self.tokens[-1] in _SCRIPT_MARKS:
            mark = self.take()
            if mark == "'":
                primes += 1
            elif (subscript if mark == "_" else superscript) != EMPTY:
                raise self.make_error(2 * mark)
            elif mark == "_":
                subscript = self.read_argument()
            else:
                superscript = self.read_argument()
        if primes > len(PRIMES):
            raise self.make_error("'" * primes)
        if primes:
            prime = Layout("letter", PRIMES[primes - 1])
            superscript = Layout("row", "", (prime, *list_row_pieces(superscript))) if superscript != EMPTY else prime
        return Layout("script", "", (base, subscript, superscript))

    def read_argument(self) -> Layout:
        """Return the next argument: a group in braces, a command, or one character (of a number, its first digit)."""
        symbol = self.tokens[-1] if self.tokens else ""
        if symbol.isdigit() and len(symbol) > 1:
            self.tokens[-1:] = [symbol[1:], symbol[0]]
        return self.read_piece()

    def read_piece(self) -> Layout:
        symbol = self.take()
        if symbol == "{":
            inner_row = self.read_row(("}",))
            self.take("}")
            return inner_row
        if symbol[0] == "\\":
            return self.read_command(symbol[1:])
        if symbol in _REFUSED_SIGNS:
            raise self.make_error(symbol)
        if symbol[0].isdigit():
            return Layout("number", symbol.replace("{,}", ","))
        return Layout("letter" if symbol.isalpha() else "sign", "−" if symbol == "-" else symbol)

    def read_command(self, name: str) -> Layout:
        piece = _COMMANDS.get(name)
        if piece is not None:
            return piece
        if name.startswith(_UPRIGHT_TEXT_COMMANDS):
            text = name[name.index("{") + 1 : -1]
            if "\\" in text:
                raise self.make_error("\\" + name)
            return Layout("text", text)
        if name.startswith("operatorname"):
            return Layout("function", name[name.index("{") + 1 : -1].replace(r"\,", ""))
        if name in ("frac", "tfrac", "dfrac"):
            return Layout("fraction", name, (self.read_argument(), self.read_argument()))
        if name in _ONE_ARGUMENT_COMMANDS and self.tokens[-1:] != ["["]:
            return Layout(_ONE_ARGUMENT_COMMANDS[name], name, (self.read_argument(),))
        if name == "left":
            opening = self.take_delimiter()
            inside = self.read_row((r"\right",))
            self.take(r"\right")
            return Layout("fenced", opening + self.take_delimiter(), (inside,))
        if name in STYLES:
            return apply_style(name, self.read_argument())
        if name.startswith("begin{"):
            return self.read_table(name.removeprefix("begin{")[:-1])
        raise self.make_error(f"\\{name}" + "[…]" * (name == "sqrt"))

    def take_delimiter(self) -> str:
        """Return the next token as a bracket; "." is a missing bracket."""
        token = self.take()
        if token not in _DELIMITERS:
            raise self.make_error(token)
        return _DELIMITERS[token]

    def read_table(self, name: str) -> Layout:
        if name not in (*_TABLES, "aligned"):
            raise self.make_error(rf"\begin{{{name}}}")
        rows: list[list[Layout]] = [[]]
        kind, text = ("matrix", _TABLES[name]) if name in _TABLES else ("aligned", "")
        while True:
            rows[-1].append(self.read_row(("&", "\\\\", r"\end")))
            separator = self.take()
            if separator.startswith("\\\\"):
                rows.append([])
                text = "apart" if separator.endswith("]") else text
            elif separator != "&":
                break
        if separator != rf"\end{{{name}}}":
            raise self.make_error(separator)
        if kind == "matrix" and len(rows) > 1 and rows[-1] == [EMPTY]:  # a line break after the last row
            rows.pop()
        return Layout(kind, text, tuple(Layout("row", "", tuple(cells)) for cells in rows))
