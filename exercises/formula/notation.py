"""What people bring along, turned into the plain text that the grammar reads: LaTeX, typography, units."""

import re
from collections import Counter
from collections.abc import Set as AbstractSet
from itertools import pairwise

from exercises.formula.names import FUNCTIONS

MAX_NESTING = 40
_LONGEST_LATEX = 20_000

_SUPERSCRIPT = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_SIGNS = str.maketrans(
    {"−": "-", "–": "-", "×": "*", "·": "*", "⋅": "*", "∗": "*", "÷": "/", "…": "...", "√": "sqrt", "ḋ": "qd", "′": "'"}
    | {"½": "(1/2)", "⅓": "(1/3)", "⅔": "(2/3)", "¼": "(1/4)", "¾": "(3/4)", "⅛": "(1/8)", "\u00a0": " ", "\u2009": " "}
)
_UNITS = {"m": "", "rad": "", "m/s": "", "rad/s": "", "N": "", "Nm": "", "N*m": "", "N m": ""}
_UNITS |= {"cm": "/100", "mm": "/1000", "deg": "*pi/180", "degree": "*pi/180", "degrees": "*pi/180"}
_LAST = 30
"""So near to the end of a text a unit begins: a search from its start would take long where there is much space."""
_UNIT_AT_END = re.compile(rf"(?<=[\w)\]}}])(?:\s*\*\s*|\s+)({'|'.join(sorted(_UNITS, key=len, reverse=True))})$")

_HABITS = (
    ("=", re.compile(r"\A(\s{0,9}\${0,2}) ?(?:\\?det ?[({]? ?J ?[)}]?|(?:\\left)?\|J(?:\\right)?\|) ?=(?!=)"), r"\1"),
    ("]", re.compile(r"(?<=[\w)\]}])\s?\[(?:m|rad|m/s|rad/s)\]\s*$"), ""),
    ("deg", re.compile(r"(?<![\w.])(\d{1,9}(?:\.\d{1,12})?) ?deg(?:rees?)?\b"), r"(\1*pi/180)"),
    ("√", re.compile(r"√ ?(\d{1,9}(?:\.\d{1,12})?)(?![\d.])"), r"sqrt(\1)"),
    ("sqrt", re.compile(r"(?<![A-Za-z_\\])sqrt(\d{1,9}(?:\.\d{1,12})?)(?![\d.])"), r"sqrt(\1)"),
    ("√", re.compile(r"√ ?([^\W\d]\w{0,20})\b"), r"sqrt(\1)"),
)
"""What stands before the result, a unit in brackets behind it, degrees inside it, roots by their sign; each with what
there must be in a text that has it, for the search takes longer."""


def plain(text: str, known: AbstractSet[str]) -> str:
    r"""Return an answer in plain text; the names that are `known` are never taken for units.

    >>> plain("½ a1² cos(30°) m", {"a1"})
    '(1/2) a1^(2) cos(30*pi/180)'
    >>> plain(r"\frac{a_{1}}{2} \cos^{2}\theta_{1}", set())
    '((a1)/(2))  cos ^(2) theta1'
    """
    if len(text) > _LONG:
        text = _SYMBOLS_IN_A_ROW.sub(lambda row: _counted(row.group(), known), text)
    for mark, pattern, meant in _HABITS:
        text = pattern.sub(meant, text) if mark in text else text
    latex = any(mark in text for mark in ("\\", "_{", "^{")) and len(text) <= _LONGEST_LATEX
    if text.isascii() and not (latex or text[-1:] in ".;\n$" or text[-1:].isalpha()):
        return _of_joints(text)
    text = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺]+", lambda found: f"^({found.group().translate(_SUPERSCRIPT)})", text)
    text = re.sub("(?:θ|q|d|theta|ϑ)\u0307_?", "qd", text).translate(_SIGNS)
    framed = re.fullmatch(r"\s*(\$\$?)([^$]*)\1\s*", text)
    text = framed.group(2) if framed is not None else text
    if latex:
        text = _from_latex(text)
    return _without_unit(_of_joints(_without_end(text).replace("°", "*pi/180")), known)


_JOINT = r"(?:theta|th|q|θ|ϑ)_?(\d)"
_RATES = re.compile(
    rf"\(\( ?d ?{_JOINT} ?\)/\( ?d ?t ?\)\)"  # \frac{{d theta1}}{{dt}}
    rf"|\(\( ?d ?\)/\( ?d ?t ?\)\) ?{_JOINT}"
    rf"|\bd ?{_JOINT} ?/ ?d ?t\b"
    rf"|\b{_JOINT}(?:\(t\))?'"
)
_VECTORS = re.compile(
    r"\b(?:(q|theta|th)|(?:qd|dq|qp|qdot|q_dot|dtheta|thetadot|theta_dot))(?:\[([0-8])\]|\(([1-9])\))"
)


def _of_joints(text: str) -> str:
    """Return a text with rates written as derivatives, and joints as the entries q[0] or q(1) of a vector, by name.

    In brackets the first joint has the number 0, as in Python; in parentheses 1, as in Matlab.
    """
    if "'" in text or ("/" in text and "t" in text):
        text = _RATES.sub(lambda found: f" qd{next(filter(None, found.groups()))} ", text)
    if ".diff" in text:
        text = text.replace("(t).diff", ".diff")

    def entry(found: re.Match[str]) -> str:
        number = int(found.group(2)) + 1 if found.group(2) else found.group(3)
        return f"{'q' if found.group(1) else 'qd'}{number}"

    return _VECTORS.sub(entry, text)


_LONG = 2000
_SYMBOLS_IN_A_ROW = re.compile(r"(?:[-+]\s{0,2}[^\W\d]\w*(?![\w.(\[{])\s{0,2})+")
_SIGNED_SYMBOL = re.compile(r"([-+])\s*(\w+)")


def _counted(row: str, known: AbstractSet[str]) -> str:
    """Return + a1 - a1 + a1 … with equal symbols counted: it is read in no time then, however long it is.

    The first may belong to a power or a product before it, the last to what follows.
    """
    terms = _SIGNED_SYMBOL.findall(row)
    inner = Counter(terms[1:-1])
    if len(terms) < _MANY or not {name for _, name in inner} <= known:
        return row
    sums = (f"{sign}{count}*{name}" for (sign, name), count in sorted(inner.items()))
    return f"{''.join(terms[0])}{''.join(sums)}{''.join(terms[-1])}"


_MANY = 100


def _without_end(text: str) -> str:
    """Return a text without the semicolon or full stop that ends a statement or a sentence."""
    text = text.rstrip()
    ends = text.endswith(";") or (text.endswith(".") and not text.endswith(".."))
    return text[:-1].rstrip() if ends else text


def _without_unit(text: str, known: AbstractSet[str]) -> str:
    last = max(0, len(text) - _LAST)
    found = _UNIT_AT_END.search(text, last)
    if found is None or found.group(1) in known:
        return text
    factor, rest = _UNITS[found.group(1)], text[: found.start()]
    if (factor and rest[:1] in "[{") or "=" in text or (found.group(1) == "m" and rest.endswith(("pi", "π"))):
        return text  # a list can't be scaled, and in theta2 = pi*m the m is any whole number
    return f"({rest}){factor}" if factor else rest


# --- LaTeX ---

_LATEX_TOKEN = re.compile(r"\\[a-zA-Z]+|\\.|\s+|.", re.DOTALL)
_SPACES = {"quad", "qquad", ",", ";", ":", " "}
_NOTHING = {"left", "right", "displaystyle", "limits", "big", "Big", "bigl", "bigr", "!", "(", ")", "[", "]"}
_FONTS = {"mathrm", "text", "operatorname", "mathbf", "mathit", "rm", "textrm", "mathsf", "boldsymbol"}
_WORDS = {
    **{"cdot": "*", "times": "*", "ast": "*", "div": "/", "arcsin": " asin", "arccos": " acos", "arctan": " atan"},
    **{"infty": " oo", "in": " in ", "lor": " or ", "vee": " or ", "land": " and ", "wedge": " and "},
}
_MATRIX = re.compile(r"[bpvBV]?matrix|array|smallmatrix")


def _from_latex(text: str) -> str:
    return _Latex(_LATEX_TOKEN.findall(text)).until(())


class _Latex:
    """Walks through the tokens of a formula; what it does not know it leaves, for the grammar to complain about."""

    def __init__(self, tokens: list[str]) -> None:
        self.tokens, self.at, self.depth = tokens, 0, 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def until(self, ends: tuple[str, ...]) -> str:
        """Return the text up to one of the tokens, which stays."""
        self.depth += 1
        out: list[str] = []
        while self.at < len(self.tokens) and self.peek() not in ends and self.depth <= MAX_NESTING:
            out.append(self.one())
        self.depth -= 1
        return "".join(out)

    def one(self) -> str:
        found = self.peek()
        self.at += 1
        if found.isspace():
            return " "
        if found == "{":
            return f"({self.group()})"
        if found == "_":
            return re.sub(r"[\s,()]+", "", self.argument())
        if found == "^":
            return f"^({self.argument()})"
        return self.command(found[1:]) if found[0] == "\\" and len(found) > 1 else found

    def group(self) -> str:
        """Return what stands up to the closing brace, and pass that."""
        inner = self.until(("}",))
        self.at += 1
        return inner

    def argument(self) -> str:
        """Return a group, or the one token that stands for it; nothing where there is none, or too deep a nest."""
        while self.peek().isspace():
            self.at += 1
        if self.at >= len(self.tokens) or self.depth > MAX_NESTING:
            return ""
        self.depth += 1
        if self.peek() == "{":
            self.at += 1
            found = self.group()
        else:
            found = self.one()
        self.depth -= 1
        return found

    def command(self, name: str) -> str:
        if name in _NOTHING or name in _SPACES:
            return " " if name in _SPACES else ""
        if name in "{}":
            return name
        if name in _FONTS:
            return self.argument().strip()
        if name in ("frac", "dfrac", "tfrac"):
            return f"(({self.argument()})/({self.argument()}))"
        if name == "sqrt":
            return self.root()
        if name in ("dot", "ddot"):  # the rate of whichever joint variable has the index inside, or that follows
            index = re.search(r"\d*$", self.argument().strip(" ()"))
            return f" {'qd' if name == 'dot' else 'qdd'}{index.group() if index else ''}"
        if name == "begin":
            return self.matrix()
        return _WORDS.get(name, f" {name} " if name in FUNCTIONS else f" {name}")

    def root(self) -> str:
        if self.peek() != "[":
            return f" sqrt({self.argument()})"
        self.at += 1
        degree = self.until(("]",))
        self.at += 1
        return f"({self.argument()})^(1/({degree}))"

    def matrix(self) -> str:
        r"""Return the rows of \begin{matrix} … \end{matrix} as nested lists."""
        kind = self.argument()
        if not _MATRIX.fullmatch(kind):
            return ""
        if kind == "array" and self.peek() == "{":
            self.argument()
        rows: list[list[str]] = [[]]
        while self.at < len(self.tokens):
            rows[-1].append(self.until(("&", "\\\\", "\\end")))
            end = self.peek()
            self.at += 1
            if end == "\\\\":
                rows.append([])
            elif end != "&":
                self.argument()
                break
        filled = [row for row in rows if any(entry.strip() for entry in row)]
        return "[" + ", ".join("[" + ", ".join(entry.strip() for entry in row) + "]" for row in filled) + "]"


def rows_of_semicolons(text: str) -> str:
    """Return a matrix whose rows end with semicolons, [a, b; c, d], as nested lists; any other text as it is."""
    inner = text.strip()
    if ";" not in inner or len(inner) < 2 or inner[0] + inner[-1] not in ("[]", "{}", "()"):
        return text
    ends = [-1, *(at for at, char in enumerate(inner[1:-1]) if char == ";"), len(inner) - 2]
    rows = [inner[1:-1][start + 1 : end] for start, end in pairwise(ends)]
    return "[" + ", ".join(f"[{row}]" for row in rows if row.strip()) + "]"
