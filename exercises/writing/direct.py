r"""The LaTeX that we write ourselves as MathML, and how wide it is, in one pass: a page holds dozens of formulas.

What a single sign or command becomes is asked of latex2mathml, once for each; here are only its ways to put them
together, so that the result is the same to the letter (a test compares them). Whatever LaTeX has beside fractions,
roots, indices, powers, dots, brackets and matrices is left to latex2mathml itself.
"""

import re
import xml.etree.ElementTree as ET
from functools import cache, lru_cache
from typing import NamedTuple

from latex2mathml.converter import convert

SPACE = {"=": 1.05, "+": 0.95, "−": 0.95, "-": 0.95, "×": 0.95, "⋅": 0.7, "≠": 1.05, "≈": 1.05, ",": 0.45}
"""Widths of operators with the room around them, in em, as of all that follows."""
WIDE, SMALL, SCRIPT, COLUMN = set("mwMWOθωφψ"), set("ijlt.,'|()[]"), 0.71, 0.85

_SIGN = r"\\text\{[^{}$\\%]+\}|\\(?:begin|end)\{[a-z]+\*?\}|\\[a-zA-Z]+|\\[\\,;:!{}| ]|\d+(?:\.\d+)?|\.\d*|\S"
_SIGNS = re.compile(rf"([_^])(\d)|()({_SIGN})")
_FRACTION = r"\\tfrac\{[^{}]*\}\{[^{}]*\}"
_INSIDE = rf"[^\\{{}}()&_]|_\{{[a-z0-9]+\}}|\\(?:theta|varphi|pi|,)|{_FRACTION}"
_PIECE = re.compile(
    r"([_^])(\d)|((?<![_^])(?:(?:[a-zA-Z]|\\(?:theta|varphi|dot\{[a-z]\}))_\{[a-z0-9]+\}"
    rf"|{_FRACTION}|\\left\((?:{_INSIDE})*\\right\))(?!\s*[_^]))|({_SIGN})"
)
"""Signs, and pieces of which there are many, which are set once: letters with an index, fractions, sums of angles."""
_NOT_OURS = re.compile(
    r"[%'~#$]|\\text\{\s*[\d}]|\\[dt]?frac\s*[.\d]|\d\s*(?:in|mm|cm|pt|em|ex|pc|bp|dd|cc|sp|mu)|[^\x00-\x7f]"
)
"""What latex2mathml takes in a way of its own: comments, primes, lengths, fractions without braces."""
_LEAVES = frozenset(
    re.findall(
        r"\S+",
        r"\alpha \beta \gamma \delta \theta \varphi \phi \psi \omega \pi \sin \cos \tan \arcsin \arccos \arctan \ln"
        r" \exp \det \partial \cdot \times \in \neq \approx \leq \geq \le \ge \mid \pm \circ \infty \square \quad"
        r" \qquad \dots \ldots \cdots \, \; \: \! \{ \} \|",
    )
)
_ENVIRONMENTS = ("bmatrix", "align*")
_DEEPEST = 60


class Set(NamedTuple):
    """A part of a formula: its MathML, and its width where fractions have their full size, and where they are small."""

    shown: str
    full: float
    small: float


class _NotOurs(Exception):
    """The formula has something that is left to latex2mathml."""


@lru_cache(maxsize=2048)
def direct(latex: str) -> Set | None:
    r"""Return what stands inside of a formula's element, and its width; None where it is left to latex2mathml.

    >>> direct("a_{1}").shown
    '<mrow><msub><mi>a</mi><mrow><mn>1</mn></mrow></msub></mrow>'
    """
    if _NOT_OURS.search(latex):
        return None
    try:
        made, _ = _Reader(_tokens(_PIECE, latex)).row(0, "")
    except (_NotOurs, RecursionError):
        return None
    return _wrapped("mrow", made)


def _tokens(kind: re.Pattern[str], latex: str) -> list[str | Set]:
    found: list[str | Set] = []
    for mark, digit, piece, other in kind.findall(latex):
        if other:
            found.append(other)
        else:
            found += (_set(piece),) if piece else (mark, digit)
    return [*found, ""]


@lru_cache(maxsize=2048)
def _set(piece: str) -> Set:
    """Return a piece of a formula that is one thing, by its signs."""
    (made,), _ = _Reader(_tokens(_SIGNS, piece)).row(0, "")
    return made


def element_width(node: ET.Element, fraction: float = 1.0) -> float:
    """Return the width of a part of a formula; `fraction` is the size of fractions, smaller inside a matrix."""
    tag, inner = node.tag.split("}")[-1], list(node)
    if tag in ("mi", "mn", "mo", "mtext"):
        text = (node.text or "").strip("\u2061")
        if tag == "mo":
            return SPACE.get(text, 0.4 * len(text))
        room = 0.17 if tag == "mi" and len(text) > 1 else 0.0
        return room + sum(0.8 if letter in WIDE else 0.33 if letter in SMALL else 0.54 for letter in text)
    if tag == "mspace":
        return float(node.get("width", "0em").removesuffix("em") or 0)
    if tag == "mfrac":
        return 0.2 + fraction * max(element_width(one, fraction) for one in inner)
    if tag in ("msub", "msup"):
        return element_width(inner[0]) + SCRIPT * element_width(inner[1])
    if tag == "msubsup":
        return element_width(inner[0]) + SCRIPT * max(map(element_width, inner[1:]))
    if tag in ("mover", "munder"):
        return element_width(inner[0])
    if tag == "mtable":
        small = 1.0 if node.get("displaystyle") == "true" else SCRIPT
        rows = [[element_width(cell, small) for cell in row] for row in inner]
        return _table_width(rows)
    return sum(element_width(one, fraction) for one in inner) + (0.9 if tag == "msqrt" else 0.0)


def _table_width(rows: list[list[float]]) -> float:
    columns = max(map(len, rows), default=0)
    return sum(max((row[k] for row in rows if k < len(row)), default=0.0) + COLUMN for k in range(columns))


class _Reader:
    """Reads tokens from a place on; every method returns what it has set, and the place behind it."""

    def __init__(self, tokens: list[str | Set]) -> None:
        self.tokens, self.depth = tokens, 0

    def row(self, at: int, end: str) -> tuple[list[Set], int]:
        """Return what stands up to a closing sign."""
        made: list[Set] = []
        while (sign := self.tokens[at]) != end:
            if sign in ("_", "^"):
                if not made:
                    raise _NotOurs
                made[-1], at = self.scripted(made[-1], at)
                continue
            one, at = self.one(at)
            if len(one) > 1 and self.tokens[at] in ("_", "^"):
                raise _NotOurs
            made += one
        return made, at + 1

    def one(self, at: int) -> tuple[list[Set], int]:
        """Return the next thing; a matrix comes with its brackets beside it."""
        sign = self.tokens[at]
        if isinstance(sign, Set):
            return [sign], at + 1
        if sign == "{":
            inside, at = self.nested(at + 1, "}")
            return [_wrapped("mrow", inside)], at
        if sign in (r"\frac", r"\tfrac"):
            above, at = self.braced(at + 1)
            below, at = self.braced(at)
            return [_fraction(above, below, sign == r"\tfrac")], at
        if sign == r"\sqrt":
            inside_root, at = self.braced(at + 1)
            return [Set(f"<msqrt>{inside_root.shown}</msqrt>", inside_root.full + 0.9, inside_root.small + 0.9)], at
        if sign in (r"\dot", r"\ddot"):
            below, at = self.braced(at + 1)
            before, behind = _around(rf"{sign}{{Q}}", "<mrow><mi>Q</mi></mrow>")
            return [Set(before.shown + below.shown + behind.shown, *(below.full,) * 2)], at
        if sign == r"\left":
            return self.fenced(at)
        if sign.startswith(r"\begin"):
            return self.table(at)
        return [leaf(sign)], at + 1

    def nested(self, at: int, end: str) -> tuple[list[Set], int]:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise _NotOurs
        found = self.row(at, end)
        self.depth -= 1
        return found

    def braced(self, at: int) -> tuple[Set, int]:
        """Return an argument of a command, in braces."""
        if self.tokens[at] != "{":
            raise _NotOurs
        inside, at = self.nested(at + 1, "}")
        return _wrapped("mrow", inside), at

    def scripted(self, base: Set, at: int) -> tuple[Set, int]:
        """Return a thing with its index and its power."""
        found: dict[str, Set] = {}
        while (sign := self.tokens[at]) in ("_", "^"):
            if sign in found:
                raise _NotOurs
            if self.tokens[at + 1] == "{":
                found[sign], at = self.braced(at + 1)
            else:
                found[sign], at = leaf(self.tokens[at + 1]), at + 2
        tag = {"_": "msub", "^": "msup"}[next(iter(found))] if len(found) == 1 else "msubsup"
        scripts = [found[sign] for sign in ("_", "^") if sign in found]
        width = base.full + SCRIPT * max(one.full for one in scripts)
        return Set(f"<{tag}>{base.shown}{''.join(one.shown for one in scripts)}</{tag}>", width, width), at

    def fenced(self, at: int) -> tuple[list[Set], int]:
        opening = self.tokens[at + 1]
        inside, at = self.nested(at + 2, r"\right")
        before, behind = _around(rf"\left{_fence(opening)} Q \right{_fence(self.tokens[at])}", "<mi>Q</mi>")
        wide = (sum(one[k] for one in (before, *inside, behind)) for k in (1, 2))  # type: ignore[misc]
        return [Set(before.shown + "".join(one.shown for one in inside) + behind.shown, *wide)], at + 1

    def table(self, at: int) -> tuple[list[Set], int]:
        name = self.tokens[at][len(r"\begin{") : -1]
        if name not in _ENVIRONMENTS or self.tokens[at + 1] in ("[", "{"):
            raise _NotOurs
        end, at, aligned = rf"\end{{{name}}}", at + 1, name == "align*"
        rows: list[list[list[Set]]] = [[[]]]
        self.depth += 1
        while (sign := self.tokens[at]) != end:
            if sign in ("&", r"\\"):
                if sign == "&":
                    rows[-1].append([])
                else:
                    rows.append([[]])
                at += 1
                continue
            if sign in ("_", "^"):
                if not rows[-1][-1]:
                    raise _NotOurs
                rows[-1][-1][-1], at = self.scripted(rows[-1][-1][-1], at)
                continue
            one, at = self.one(at)
            if len(one) > 1 and self.tokens[at] in ("_", "^"):
                raise _NotOurs
            rows[-1][-1] += one
        self.depth -= 1
        if not rows[-1][-1] or self.depth > _DEEPEST:  # latex2mathml takes the last row away then
            raise _NotOurs
        return _table(rows, aligned), at + 1


def _table(rows: list[list[list[Set]]], aligned: bool) -> list[Set]:
    cells = (' columnalign="right"', ' columnalign="left"') if aligned else ("", "")

    def cell(k: int, inside: list[Set]) -> str:
        text = ("<mi />" if aligned and k % 2 else "") + "".join([one.shown for one in inside])
        return f"<mtd{cells[k % 2]}>{text}</mtd>" if text else f"<mtd{cells[k % 2]} />"

    shown = "".join(f"<mtr>{''.join(cell(k, inside) for k, inside in enumerate(row))}</mtr>" for row in rows)
    size = 1 if aligned else 2
    wide = _table_width([[sum(one[size] for one in cell) for cell in row] for row in rows])  # type: ignore[misc]
    if not aligned:
        before, behind = leaf("["), leaf("]")
        left, right = (Set(f"<mo>&#x0005{sign};</mo>", *one[1:]) for sign, one in (("B", before), ("D", behind)))
        return [left, Set(f"<mtable>{shown}</mtable>", wide, wide), right]
    spaces = " ".join(("0em", "2em") * (max(map(len, rows)) // 2))
    spaced = f' columnspacing="{spaces}"'
    begin = _around(r"\begin{align*} Q \end{align*}", '<mtr><mtd columnalign="right"><mi>Q</mi></mtd></mtr>')[0].shown
    begin = re.sub(r' columnspacing="[^"]*"', "", begin)
    return [Set(f"{begin.removesuffix('>')}{spaced}>{shown}</mtable>", wide, wide)]


def _wrapped(tag: str, inside: list[Set]) -> Set:
    if not inside:
        return Set(f"<{tag} />", 0.0, 0.0)
    shown = f"<{tag}>{''.join([one.shown for one in inside])}</{tag}>"
    return Set(shown, sum([one.full for one in inside]), sum([one.small for one in inside]))


def _fraction(above: Set, below: Set, small: bool) -> Set:
    shown = f"<mfrac>{above.shown}{below.shown}</mfrac>"
    if small:
        shown = f'<mstyle displaystyle="false" scriptlevel="0">{shown}</mstyle>'
    return Set(shown, 0.2 + 1.0 * max(above.full, below.full), 0.2 + SCRIPT * max(above.small, below.small))


def _fence(sign: str | Set) -> str:
    if isinstance(sign, Set) or sign not in ("(", ")", "[", "]", "|", r"\{", r"\}"):
        raise _NotOurs
    return sign


@cache
def _around(latex: str, hole: str) -> tuple[Set, Set]:
    """Return what latex2mathml puts before and behind a thing; the width is that of all operators there."""
    before, behind = _inside(convert(latex)).split(hole)
    signs = [re.findall(r"(<mo[ >].*?</mo>)", side) for side in (before, behind)]
    wide = [sum(element_width(ET.fromstring(sign)) for sign in side) for side in signs]  # noqa: S314 - our own
    return Set(before, wide[0], wide[0]), Set(behind, wide[1], wide[1])


@lru_cache(maxsize=4096)
def leaf(sign: str | Set) -> Set:
    """Return what latex2mathml makes of one sign or command. Raises _NotOurs where it does not stand for itself."""
    if (
        isinstance(sign, Set)
        or sign in ("", "{", "}", "&", "_", "^", r"\\")
        or (len(sign) > 1 and sign[0] == "\\" and sign not in _LEAVES and not sign.startswith(r"\text{"))
    ):
        raise _NotOurs
    shown = _inside(convert(sign))
    wide = element_width(ET.fromstring(f"<mrow>{shown}</mrow>"))  # noqa: S314 - our own
    return Set(shown, wide, wide)


def _inside(shown: str) -> str:
    """Return what stands in the row of a formula's element."""
    return re.sub(r"^<math[^>]*><mrow>|</mrow></math>$", "", shown)
