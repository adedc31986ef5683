"""Convert LaTeX, typographic signs and units to the plain text that the grammar parses."""

import re
from collections import Counter
from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from itertools import islice
from typing import Any

from qdot.exercises.formula.names import FUNCTIONS
from qdot.exercises.formula.units import UNIT, parse_unit
from qdot.exercises.formula.vocabulary import LIMITS, PATTERNS, SPACES, VOCABULARY

MAX_NESTING = LIMITS["latex_depth"]
_MAX_LATEX_LENGTH = LIMITS["latex_characters"]
_LONG_TEXT_LENGTH, _MIN_COUNTED_TERMS = LIMITS["long_text"], LIMITS["counted_terms"]
"""Minimum length of a text, and minimum number of terms of a sum in it, to combine equal terms."""

_LOOK_ALIKES = str.maketrans(
    VOCABULARY["look_alikes"] | {chr(ord(zero) + k): str(k) for zero in VOCABULARY["zeros"] for k in range(10)}
)
"""The ASCII characters that replace digits of all scripts, wide East Asian signs, special spaces and invisible
marks."""
_SUPERSCRIPT_CHARACTERS: dict[str, str] = VOCABULARY["superscripts"]
_SUPERSCRIPT_PATTERN = re.compile(f"[{''.join(_SUPERSCRIPT_CHARACTERS)}]+")
_SIGN_TABLE = str.maketrans(VOCABULARY["signs"])
"""Maps typographic signs, such as ·, to the text that the grammar parses."""

_UNITS: dict[str, str] = VOCABULARY["units"]
"""Maps each unit to the text that converts the number before the unit to SI units, such as /100 for cm."""


def _make_unit_pattern(units: Iterable[str]) -> str:
    """Return a regular expression for any of these units, which may have spaces around their slash, as in rad / s."""
    return "|".join(re.escape(unit).replace("/", " ?/ ?") for unit in sorted(units, key=len, reverse=True))


def _normalize_unit(typed_unit: str) -> str:
    """Return a unit as it is written in the vocabulary, without spaces around its slash."""
    return typed_unit.replace(" /", "/").replace("/ ", "/")


_BEFORE_UNIT = VOCABULARY["patterns"]["before_unit"]
_FINAL_UNIT_PATTERN = re.compile(f"{_BEFORE_UNIT}({_make_unit_pattern(_UNITS)})$")

_WHOLE_NUMBER_NAMES, _BEFORE_WHOLE_NUMBERS = VOCABULARY["whole_numbers"], tuple(VOCABULARY["before_whole_numbers"])

_TYPING_HABITS = [(habit["mark"], habit["pattern"], habit["replacement"]) for habit in VOCABULARY["habits"]]
"""(mark, pattern, replacement) for other notations, such as words before the result. Every text that matches the
pattern contains the mark, which is quicker to find.
"""


def to_plain_text(text: str, known_symbols: AbstractSet[str]) -> str:
    r"""Return an answer in plain text; the names in `known_symbols` are never taken for units.

    >>> to_plain_text("½ a1² cos(30°) m", {"a1"})
    '(1/2) a1^(2) cos((30*pi/180))'
    >>> to_plain_text(r"\frac{a_{1}}{2} \cos^{2}\theta_{1}", set())
    '((a1)/(2))  cos ^(2) theta1'
    """
    text = (text if text.isascii() else text.translate(_LOOK_ALIKES)).rstrip(SPACES)
    if len(text) > _LONG_TEXT_LENGTH:
        text = PATTERNS["symbols_in_a_row"].sub(lambda row: _combine_equal_terms(row.group(), known_symbols), text)
    for mark, pattern, replacement in _TYPING_HABITS:
        text = re.sub(pattern, replacement, text) if mark in text else text
    text = convert_units(text, known_symbols)
    is_latex = any(mark in text for mark in ("\\", "_{", "^{")) and len(text) <= _MAX_LATEX_LENGTH
    # most answers need none of the conversions below
    if text.isascii() and not (is_latex or text[-1:] in ".;$" or text[-1:].isalpha() or "^" in text[-5:]):
        return _name_rates_and_entries(text, known_symbols)
    text = _SUPERSCRIPT_PATTERN.sub(
        lambda match: f"^({''.join(_SUPERSCRIPT_CHARACTERS[sign] for sign in match.group())})", text
    )
    text = PATTERNS["rate_with_dot"].sub("qd", text).translate(_SIGN_TABLE)
    if (dollar_match := PATTERNS["dollars"].fullmatch(text)) is not None:
        text = dollar_match.group(2)
    if is_latex:
        text = _LatexReader(PATTERNS["latex_token"].findall(text)).read_until(())
    text_without_end = PATTERNS["end_of_text"].sub("", text.rstrip(SPACES))  # a full stop, for example
    text = _name_rates_and_entries(text_without_end, known_symbols)
    return _remove_final_unit(convert_units(text, known_symbols), known_symbols)


def _name_rates_and_entries(text: str, known_symbols: AbstractSet[str]) -> str:
    """Replace rates typed as derivatives, and entries of a joint vector such as q[0] and q(1), by their names.

    In parentheses, the first joint has the index 1, as in Matlab. In square brackets, it has the index 0, as in Python.
    But it has the index 1, as in Maple, if 0 is not used and if the largest index would otherwise belong to no joint.
    """
    if "'" in text or ("/" in text and "t" in text):
        text = PATTERNS["rate_as_derivative"].sub(lambda match: f" qd{next(filter(None, match.groups()))} ", text)
    if ".diff" in text:
        text = text.replace("(t).diff", ".diff")

    matches = PATTERNS["entry_of_vector"].finditer(text) if "[" in text else ()
    indices = {int(match.group(2)) for match in matches if match.group(2)}
    last_number = f"{max(indices, default=0) + 1}"
    is_beyond_last_joint = known_symbols and known_symbols.isdisjoint((f"theta{last_number}", f"d{last_number}"))
    first_number = 0 if indices and 0 not in indices and is_beyond_last_joint else 1

    def name_entry(match: re.Match[str]) -> str:
        number = int(match.group(2)) + first_number if match.group(2) else match.group(3)
        return f"{'q' if match.group(1) else 'qd'}{number}"

    return PATTERNS["entry_of_vector"].sub(name_entry, text)


_NUMBER, _AFTER_UNIT = VOCABULARY["patterns"]["number_before_unit"], VOCABULARY["patterns"]["after_unit"]
"""Regular expressions for a number before a unit, and for what may follow the unit (a lookahead)."""
_NUMBER_WITH_UNIT_PATTERN = re.compile(f"{_NUMBER}({_make_unit_pattern(_UNITS)}){_AFTER_UNIT}")


def convert_units(text: str, known_symbols: AbstractSet[str]) -> str:
    """Return a text in which numbers with units, such as 0.5 rad/s or 30 cm, are converted to SI units.

    The unit m is left to the grammar (`metres`).
    """

    def replace_unit(match: re.Match[str]) -> str:
        unit = _normalize_unit(match.group(2))
        is_symbol = unit in known_symbols or unit in _WHOLE_NUMBER_NAMES
        return match.group() if is_symbol else f"{match.group(1)}{_UNITS[unit]}"

    return _NUMBER_WITH_UNIT_PATTERN.sub(replace_unit, text)


_DECIMAL, _LENGTHS = VOCABULARY["patterns"]["decimal_before_length"], VOCABULARY["lengths"]
_LENGTH_WITH_COMMA_PATTERN = re.compile(f"{_DECIMAL}({_make_unit_pattern(_LENGTHS)}){_AFTER_UNIT}")


def use_points_in_lengths(text: str) -> str:
    """Return a text with decimal points instead of commas in lengths such as 0,2 m.

    >>> use_points_in_lengths("d3 = 0,2 m oder 20,5 cm, theta2 = 0,180°")
    'd3 = 0.2 m oder 20.5 cm, theta2 = 0,180°'
    """
    return _LENGTH_WITH_COMMA_PATTERN.sub(r"\1.\2\3", text)


_VALUE_WITH_UNIT_PATTERN = re.compile(f"(?:(?<=[0-9.]) ?|{_BEFORE_UNIT})(?:({UNIT})|\\[ ?({UNIT}) ?\\]){_AFTER_UNIT}")


def find_units(text: str) -> list[tuple[str, str, int]]:
    """Return (name, unit, index) for each value with a unit.

    The name is the text before an equals sign or colon, or "". The value ends at the index.

    >>> find_units("qd1 = 0.5 rad/s, -sqrt(2) mm/s")
    [('qd1', 'rad/s', 9), ('', 'mm/s', 25)]
    """
    units, end_of_last_unit = [], 0
    for match in islice(_VALUE_WITH_UNIT_PATTERN.finditer(text), _MAX_UNITS):
        names = PATTERNS["name_of_number"].findall(text, end_of_last_unit, match.start())
        units.append((names[-1] if names else "", _normalize_unit(match.group(1) or match.group(2)), match.start()))
        end_of_last_unit = match.end()
    return units


_MAX_UNITS = 100
"""Maximum number of units that are found in an answer."""


def convert_units_of_numbers(text: str) -> str:
    """Convert the units in a numeric answer that `to_plain_text` leaves unchanged because they could be symbols.

    >>> convert_units_of_numbers("[2 kN, 30 cm]"), convert_units_of_numbers("0.5 m/s²")
    ('[2*1000, 30 cm]', '0.5')
    """

    def convert_unit(match: re.Match[str]) -> str:
        unit_text = match.group(1) or match.group(2)
        unit = parse_unit(unit_text)
        is_list = match.string[match.start() - 1] in "]}"  # a list can't be converted
        if unit is None or _normalize_unit(unit_text) in _UNITS or (is_list and unit.conversion):
            return match.group()
        return unit.conversion

    return _VALUE_WITH_UNIT_PATTERN.sub(convert_unit, text)


def replace_latex_units(text: str) -> str:
    r"""Return a numeric answer with plain units instead of units in LaTeX.

    >>> replace_latex_units(r"0.5\,\mathrm{m/s}")
    '0.5 m/s'
    """
    return PATTERNS["latex_unit"].sub(r" \1", text)


def _combine_equal_terms(symbol_sum: str, known_symbols: AbstractSet[str]) -> str:
    """Combine equal terms of a sum such as + a1 - a1 + a1 …, so that even a very long sum is parsed quickly.

    The first and the last term stay unchanged, because they may belong to a product or power.
    """
    terms = PATTERNS["signed_symbol"].findall(symbol_sum)
    inner_counts = Counter(terms[1:-1])
    if len(terms) < _MIN_COUNTED_TERMS or not {name for _, name in inner_counts} <= known_symbols:
        return symbol_sum
    sums = (f"{sign}{count}*{name}" for (sign, name), count in sorted(inner_counts.items()))
    return f"{''.join(terms[0])}{''.join(sums)}{''.join(terms[-1])}"


def _remove_final_unit(text: str, known_symbols: AbstractSet[str]) -> str:
    """Return a text without the unit at its end, with the value converted to SI units."""
    match = _FINAL_UNIT_PATTERN.search(text)
    if match is None or (unit := _normalize_unit(match.group(1))) in known_symbols:
        return text
    factor, value_text = _UNITS[unit], text[: match.start()]
    is_whole_number = unit in _WHOLE_NUMBER_NAMES and value_text.endswith(_BEFORE_WHOLE_NUMBERS)
    if (factor and value_text[:1] in "[{") or "=" in text or is_whole_number:
        return text  # a list can't be scaled, and m stands for any whole number in theta2 = pi*m
    return f"({value_text}){factor}" if factor else value_text


# --- LaTeX ---

_LATEX: dict[str, Any] = VOCABULARY["latex"]
_COMMANDS: dict[str, str] = {
    **_LATEX["words"], **dict.fromkeys(_LATEX["spaces"], " "), **dict.fromkeys(_LATEX["nothing"], ""),
    **{brace: brace for brace in _LATEX["braces"]},
}  # fmt: skip
"""Maps LaTeX commands without arguments to their plain text."""
_CONTINUATIONS = ("", "=", "+", "-", "*", "/", ")", "]", *_LATEX["row_ends"])
"""Tokens that, after \\\\ or &, continue the same statement."""


class _LatexReader:
    """Converts the tokens of a LaTeX formula to plain text.

    Unknown tokens stay unchanged, so that the parser reports them.
    """

    def __init__(self, tokens: list[str]) -> None:
        self.tokens, self.position, self.depth = tokens, 0, 0

    def peek(self) -> str:
        return self.tokens[self.position] if self.position < len(self.tokens) else ""

    def take(self) -> str:
        token = self.peek()
        self.position += 1
        return token

    def read_until(self, end_tokens: tuple[str, ...]) -> str:
        """Return the text of the tokens before one of `end_tokens`."""
        self.depth += 1
        pieces: list[str] = []
        while self.position < len(self.tokens) and self.peek() not in end_tokens and self.depth <= MAX_NESTING:
            pieces.append(self.read_piece())
        self.depth -= 1
        return "".join(pieces)

    def read_piece(self) -> str:
        symbol = self.take()
        if symbol[0] in SPACES:
            return " "
        if symbol == "{":
            content = self.read_group()
            return f"{{{content}}}" if ":" in content else f"({content})"  # a SymPy dictionary, {\theta_2: [0, pi]}
        if symbol == "_":
            return self.read_subscript()
        if symbol == "^":
            return f"^({self.read_argument()})"
        if symbol in _LATEX["row_ends"] or symbol == "&":
            return self.read_row_end(symbol)
        return self.read_command(symbol[1:]) if symbol[0] == "\\" and len(symbol) > 1 else symbol

    def read_row_end(self, symbol: str) -> str:
        r"""Return the separator of two statements for \\ or &, or a space if the formula continues, as in & = b."""
        while self.peek() and (self.peek()[0] in SPACES or self.peek()[1:] in _LATEX["spaces"] or self.peek() == "&"):
            self.position += 1
        continues = self.peek() in _CONTINUATIONS or self.peek() == "\\end"
        return " " if continues else " & " if symbol == "&" else "; "

    def read_subscript(self) -> str:
        r"""Return a subscript as plain text: 12 for {1,2} and {1+2}, but (theta1+theta2) for {\theta_1+\theta_2}."""
        index = re.sub(f"[{SPACES},()]+", "", self.read_argument())
        index = index.replace("+", "") if PATTERNS["sum_of_digits"].fullmatch(index) else index
        if "+" in index or "-" in index:
            return f"({index})"
        return f"{index} " if re.search("[0-9]$", index) and self.peek()[:1].isalpha() else index  # a_1c \theta_1

    def read_group(self) -> str:
        """Return the text before the closing brace, and skip the brace."""
        content = self.read_until(("}",))
        self.position += 1
        return content

    def read_argument(self) -> str:
        """Return the next group or token as text; "" if there is none, or if groups are nested too deeply."""
        while self.peek() and self.peek()[0] in SPACES:
            self.position += 1
        if self.position >= len(self.tokens) or self.depth > MAX_NESTING:
            return ""
        self.depth += 1
        is_group = self.peek() == "{"
        self.position += is_group
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
        if name in _LATEX["rates"]:  # the rate of the joint variable that follows
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
            self.position += 1
            return self.read_rows("}")
        return f" {name} " if name in FUNCTIONS else f" {name}"

    def read_root(self) -> str:
        if self.peek() != "[":
            return f" sqrt({self.read_argument()})"
        self.position += 1
        degree = self.read_until(("]",))
        self.position += 1
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

    def read_rows(self, end_token: str) -> str:
        """Return the rows before the token `end_token` as nested lists, and skip that token."""
        rows: list[list[str]] = [[]]
        while self.position < len(self.tokens):
            rows[-1].append(self.read_until(("&", *_LATEX["row_ends"], end_token)).strip(SPACES))
            end = self.take()
            if end in _LATEX["row_ends"]:
                rows.append([])
                self.skip_row_height()
            elif end != "&":
                break
        return "[" + ", ".join(f"[{', '.join(row)}]" for row in rows if any(row)) + "]"

    def skip_row_height(self) -> None:
        r"""Skip the distance between two rows, as in \\[2pt]."""
        tokens_of_height = self.tokens[self.position : self.position + 12]  # a height such as [-10.25 pt] has fewer
        if self.peek() == "[" and PATTERNS["height_of_row"].match("".join(tokens_of_height)):
            while self.take() != "]":
                pass
