"""Convert LaTeX, typographic signs and units to the plain text that the grammar parses."""

import re
from collections import Counter
from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from typing import Any

from qdot.exercises.formula.names import FUNCTIONS
from qdot.exercises.formula.vocabulary import LIMITS, SPACES, VOCABULARY, pattern

MAX_NESTING = LIMITS["latex_depth"]
_LONGEST_LATEX = LIMITS["latex_characters"]
_LONG, _MANY = LIMITS["long"], LIMITS["many"]

_LOOK_ALIKES = str.maketrans(
    VOCABULARY["look_alikes"] | {chr(ord(zero) + k): str(k) for zero in VOCABULARY["zeros"] for k in range(10)}
)
"""ASCII equivalents of digits in all scripts, wide East Asian signs, typesetters' spaces and invisible marks."""
_SUPERSCRIPT: dict[str, str] = VOCABULARY["superscripts"]
_SUPERSCRIPTS = re.compile(f"[{''.join(_SUPERSCRIPT)}]+")
_SIGNS = str.maketrans(VOCABULARY["signs"])
_RATE_WITH_DOT, _DOLLARS = pattern("rate_with_dot"), pattern("dollars")
_END = pattern("end")
"""The semicolon or full stop that ends a statement or a sentence."""

_UNITS: dict[str, str] = VOCABULARY["units"]


def _pattern_of_units(units: Iterable[str]) -> str:
    """Return a regular expression for any of these units, also with spaces around the slash, as in rad / s."""
    return "|".join(re.escape(unit).replace("/", " ?/ ?") for unit in sorted(units, key=len, reverse=True))


def _unit(written: str) -> str:
    """Return a unit without spaces around its slash, as in the vocabulary."""
    return written.replace(" /", "/").replace("/ ", "/")


_UNIT_AT_END = re.compile(f"{VOCABULARY['patterns']['before_unit']}({_pattern_of_units(_UNITS)})$")

_WHOLE, _BEFORE_WHOLE = VOCABULARY["whole_numbers"], tuple(VOCABULARY["before_whole_numbers"])

_HABITS = [(habit["mark"], re.compile(habit["pattern"]), habit["meant"]) for habit in VOCABULARY["habits"]]
"""Patterns for text before the result, a unit in brackets after it, degrees inside it, and root signs.

Each comes with a mark that any matching text contains, because testing for the mark is faster than a search."""


def plain(text: str, known: AbstractSet[str]) -> str:
    r"""Return an answer in plain text; the names in `known` are never taken for units.

    >>> plain("½ a1² cos(30°) m", {"a1"})
    '(1/2) a1^(2) cos((30*pi/180))'
    >>> plain(r"\frac{a_{1}}{2} \cos^{2}\theta_{1}", set())
    '((a1)/(2))  cos ^(2) theta1'
    """
    text = (text if text.isascii() else text.translate(_LOOK_ALIKES)).rstrip(SPACES)
    if len(text) > _LONG:
        text = _SYMBOLS_IN_A_ROW.sub(lambda row: _count_symbols(row.group(), known), text)
    for mark, habit, meant in _HABITS:
        text = habit.sub(meant, text) if mark in text else text
    text = without_units(text, known)
    is_latex = any(mark in text for mark in ("\\", "_{", "^{")) and len(text) <= _LONGEST_LATEX
    if text.isascii() and not (is_latex or text[-1:] in ".;$" or text[-1:].isalpha() or "^" in text[-5:]):
        return _of_joints(text, known)
    text = _SUPERSCRIPTS.sub(lambda match: f"^({''.join(_SUPERSCRIPT[sign] for sign in match.group())})", text)
    text = _RATE_WITH_DOT.sub("qd", text).translate(_SIGNS)
    if (math_in_dollars := _DOLLARS.fullmatch(text)) is not None:
        text = math_in_dollars.group(2)
    if is_latex:
        text = _LatexReader(_LATEX_TOKEN.findall(text)).read_until(())
    text = _of_joints(_END.sub("", text.rstrip(SPACES)), known)
    return _without_unit(without_units(text, known), known)


_RATES, _VECTORS = pattern("rate_as_derivative"), pattern("entry_of_vector")


def _of_joints(text: str, known: AbstractSet[str]) -> str:
    """Return the text with names instead of rates typed as derivatives and of entries of a joint vector, q[0] or q(1).

    In square brackets the first joint has the index 0, as in Python. It has the index 1, as in Maple, if 0 is unused
    and the last index would otherwise exceed the problem's joints. In parentheses it has the index 1, as in Matlab.
    """
    if "'" in text or ("/" in text and "t" in text):
        text = _RATES.sub(lambda match: f" qd{next(filter(None, match.groups()))} ", text)
    if ".diff" in text:
        text = text.replace("(t).diff", ".diff")

    matches = _VECTORS.finditer(text) if "[" in text else ()
    indices = {int(match.group(2)) for match in matches if match.group(2)}
    last_number = f"{max(indices, default=0) + 1}"
    first_number = (
        0 if indices and 0 not in indices and known and not {f"theta{last_number}", f"d{last_number}"} & known else 1
    )

    def name_entry(match: re.Match[str]) -> str:
        number = int(match.group(2)) + first_number if match.group(2) else match.group(3)
        return f"{'q' if match.group(1) else 'qd'}{number}"

    return _VECTORS.sub(name_entry, text)


_NUMBER_IN_UNIT = re.compile(
    f"{VOCABULARY['patterns']['number_in_unit']}({_pattern_of_units(_UNITS)}){VOCABULARY['patterns']['behind_unit']}"
)


def without_units(text: str, known: AbstractSet[str]) -> str:
    """Return the text with numbers such as 0.5 rad/s and 30 cm converted to SI units; the grammar handles m."""

    def replace_unit(match: re.Match[str]) -> str:
        unit = _unit(match.group(2))
        return match.group() if unit in known or unit in _WHOLE else f"{match.group(1)}{_UNITS[unit]}"

    return _NUMBER_IN_UNIT.sub(replace_unit, text)


_LENGTH_WITH_COMMA = re.compile(
    f"{VOCABULARY['patterns']['decimal_in_unit']}({_pattern_of_units(VOCABULARY['lengths'])})"
    f"{VOCABULARY['patterns']['behind_unit']}"
)


def with_points_of_lengths(text: str) -> str:
    """Return the text with decimal points in lengths such as 0,2 m, because their comma can't separate two values.

    >>> with_points_of_lengths("d3 = 0,2 m oder 20,5 cm, theta2 = 0,180°")
    'd3 = 0.2 m oder 20.5 cm, theta2 = 0,180°'
    """
    return _LENGTH_WITH_COMMA.sub(r"\1.\2\3", text)


_NAMED_IN_UNIT = re.compile(
    f"{VOCABULARY['patterns']['name_of_number']}{VOCABULARY['patterns']['number_in_unit']}"
    f"({_pattern_of_units([*_UNITS, *VOCABULARY['degrees']])}){VOCABULARY['patterns']['behind_unit']}"
)


def units_of_numbers(text: str) -> list[tuple[str, str, int]]:
    """Return (name, unit, index) for each number with a unit: the name before it or "", and where the match begins.

    >>> units_of_numbers("qd1 = 0.5 rad/s, 118 mm/s")
    [('qd1', 'rad/s', 0), ('', 'mm/s', 16)]
    """
    matches = _NAMED_IN_UNIT.finditer(text)
    return [(match.group(1) or "", _unit(match.group(3)), match.start()) for match in matches]


def kind_of_unit(unit: str) -> str:
    """Return "length" for metres and metres per second, "angle" for radians and degrees, "" for any other unit."""
    for per_second in VOCABULARY["per_second"]:
        unit = unit.removesuffix(per_second)
    return "length" if unit in VOCABULARY["lengths"] else "angle" if unit in VOCABULARY["angles"] else ""


_SYMBOLS_IN_A_ROW, _SIGNED_SYMBOL = pattern("symbols_in_a_row"), pattern("signed_symbol")


def _count_symbols(row: str, known: AbstractSet[str]) -> str:
    """Return + a1 - a1 + a1 … with equal terms counted, so that even a very long sum is parsed quickly.

    The first and last terms stay, because they may belong to a power or product before or after the sum.
    """
    terms = _SIGNED_SYMBOL.findall(row)
    inner_counts = Counter(terms[1:-1])
    if len(terms) < _MANY or not {name for _, name in inner_counts} <= known:
        return row
    sums = (f"{sign}{count}*{name}" for (sign, name), count in sorted(inner_counts.items()))
    return f"{''.join(terms[0])}{''.join(sums)}{''.join(terms[-1])}"


def _without_unit(text: str, known: AbstractSet[str]) -> str:
    match = _UNIT_AT_END.search(text)
    if match is None or (unit := _unit(match.group(1))) in known:
        return text
    factor, rest = _UNITS[unit], text[: match.start()]
    if (factor and rest[:1] in "[{") or "=" in text or (unit in _WHOLE and rest.endswith(_BEFORE_WHOLE)):
        return text  # a list can't be scaled, and in theta2 = pi*m the m is any whole number
    return f"({rest}){factor}" if factor else rest


# --- LaTeX ---

_LATEX_TOKEN = pattern("latex_token")
_LATEX: dict[str, Any] = VOCABULARY["latex"]
_COMMANDS: dict[str, str] = {
    **_LATEX["words"], **dict.fromkeys(_LATEX["spaces"], " "), **dict.fromkeys(_LATEX["nothing"], ""),
    **{brace: brace for brace in _LATEX["braces"]},
}  # fmt: skip
_GOES_ON = ("", "=", "+", "-", "*", "/", ")", "]", *_LATEX["row_ends"])
_HEIGHT, _SUM_OF_DIGITS = pattern("height_of_row"), pattern("sum_of_digits")


class _LatexReader:
    """Converts the tokens of a LaTeX formula to plain text; unknown tokens stay, so that the grammar reports them."""

    def __init__(self, tokens: list[str]) -> None:
        self.tokens, self.at, self.depth = tokens, 0, 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self) -> str:
        token = self.peek()
        self.at += 1
        return token

    def read_until(self, ends: tuple[str, ...]) -> str:
        """Return the text up to one of the tokens `ends`, which is not consumed."""
        self.depth += 1
        pieces: list[str] = []
        while self.at < len(self.tokens) and self.peek() not in ends and self.depth <= MAX_NESTING:
            pieces.append(self.read_piece())
        self.depth -= 1
        return "".join(pieces)

    def read_piece(self) -> str:
        symbol = self.take()
        if symbol[0] in SPACES:
            return " "
        if symbol == "{":
            inner = self.read_group()
            return f"{{{inner}}}" if ":" in inner else f"({inner})"  # a SymPy dictionary, {\theta_2: [0, pi]}
        if symbol == "_":
            return self.read_subscript()
        if symbol == "^":
            return f"^({self.read_argument()})"
        if symbol in _LATEX["row_ends"] or symbol == "&":
            return self.read_row_end(symbol)
        return self.read_command(symbol[1:]) if symbol[0] == "\\" and len(symbol) > 1 else symbol

    def read_row_end(self, sign: str) -> str:
        r"""Return the separator of two statements for \\\\, or a space if the next line continues, as in & = b."""
        while self.peek() and (self.peek()[0] in SPACES or self.peek()[1:] in _LATEX["spaces"] or self.peek() == "&"):
            self.at += 1
        continues = self.peek() in _GOES_ON or self.peek() == "\\end"
        return " " if continues else " & " if sign == "&" else "; "

    def read_subscript(self) -> str:
        r"""Return a subscript as plain text: 12 for {1,2} and {1+2}, but (theta1+theta2) for {\theta_1+\theta_2}."""
        index = re.sub(f"[{SPACES},()]+", "", self.read_argument())
        index = index.replace("+", "") if _SUM_OF_DIGITS.fullmatch(index) else index
        if "+" in index or "-" in index:
            return f"({index})"
        return f"{index} " if re.search("[0-9]$", index) and self.peek()[:1].isalpha() else index  # a_1c \theta_1

    def read_group(self) -> str:
        """Return the text up to the closing brace, and consume the brace."""
        inner = self.read_until(("}",))
        self.at += 1
        return inner

    def read_argument(self) -> str:
        """Return the next group or single token; "" if there is none, or if groups are nested too deeply."""
        while self.peek() and self.peek()[0] in SPACES:
            self.at += 1
        if self.at >= len(self.tokens) or self.depth > MAX_NESTING:
            return ""
        self.depth += 1
        is_group = self.peek() == "{"
        self.at += is_group
        text = self.read_group() if is_group else self.read_piece()
        self.depth -= 1
        return text

    def read_command(self, name: str) -> str:
        if name in _COMMANDS:
            return _COMMANDS[name]
        if name in _LATEX["fonts"]:
            return self.read_argument().strip(SPACES)
        if name in _LATEX["fractions"]:
            return f"(({self.read_argument()})/({self.read_argument()}))"
        if name in _LATEX["roots"]:
            return self.read_root()
        if name in _LATEX["rates"]:  # the rate of the joint whose variable follows
            variable = self.read_argument().strip(" ()")
            velocity = _LATEX["velocities"].get(name, {}).get(variable)
            index = re.search("[0-9]*$", variable)
            return f" {velocity or _LATEX['rates'][name] + (index.group() if index else '')}"
        if name == "begin":
            return self.read_matrix()
        if name == "end":
            self.read_argument()
            return " "
        if name in _LATEX["matrices"] and self.peek() == "{":
            self.at += 1
            return self.read_rows("}")
        return f" {name} " if name in FUNCTIONS else f" {name}"

    def read_root(self) -> str:
        if self.peek() != "[":
            return f" sqrt({self.read_argument()})"
        self.at += 1
        degree = self.read_until(("]",))
        self.at += 1
        return f"({self.read_argument()})^(1/({degree}))"

    def read_matrix(self) -> str:
        r"""Return the rows of \begin{matrix} … \end{matrix} as nested lists."""
        kind = self.read_argument()
        if kind not in _LATEX["matrices"]:
            return " "
        if kind in _LATEX["with_columns"] and self.peek() == "{":
            self.read_argument()
        text = self.read_rows("\\end")
        self.read_argument()
        return text

    def read_rows(self, close: str) -> str:
        """Return the rows up to the token `close` as nested lists, and consume that token."""
        rows: list[list[str]] = [[]]
        while self.at < len(self.tokens):
            rows[-1].append(self.read_until(("&", *_LATEX["row_ends"], close)).strip(SPACES))
            end = self.take()
            if end in _LATEX["row_ends"]:
                rows.append([])
                self.pass_height()
            elif end != "&":
                break
        return "[" + ", ".join(f"[{', '.join(row)}]" for row in rows if any(row)) + "]"

    def pass_height(self) -> None:
        r"""Skip the distance between two rows, as in \\\\[2pt]."""
        if self.peek() == "[" and _HEIGHT.match("".join(self.tokens[self.at : self.at + 12])):
            while self.take() != "]":
                pass
