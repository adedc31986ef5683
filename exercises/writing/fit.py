r"""Wide formulas on several lines: how wide a formula is, about, and where it is broken to fit a page.

A formula in pieces between \qquad, or with several signs of equality, gets a line for each. Of what is wider still,
products go on behind a dot or a cross, sums before a sign, and matrices behind a \cdots, with their other columns.
"""

import re
import xml.etree.ElementTree as ET
from functools import lru_cache

from exercises.writing.direct import direct, element_width
from exercises.writing.mathml import known, plain_mathml

Rows = list[tuple[str, str]]


@lru_cache(maxsize=2048)
def width(latex: str) -> float:
    r"""Return about how wide a formula is in em.

    >>> width(r"a_{1}") < width(r"\frac{a_{1}}{2}") + 0.3 < width(r"a_{1} + a_{2}")
    True
    """
    if not latex.strip():
        return 0.0
    found = direct(known(latex))
    return element_width(ET.fromstring(plain_mathml(latex, True))) if found is None else found.full  # noqa: S314


def fitted(latex: str, room: float) -> str:
    """Return a formula for lines of its own, broken where it is wider than `room` (em), as far as that can be."""
    if width(latex) <= room:
        return latex
    rows = [line for left, right in _rows(latex, room) for line in _equation(left, right, room)]
    return r"\begin{aligned} " + r" \\[6pt] ".join(" & ".join(row) for row in rows) + r" \end{aligned}"


def _rows(latex: str, room: float) -> Rows:
    """Return the equations in a formula as left sides, and right sides with their first sign.

    What stands beside each other in an aligned formula stays there where it fits.
    """
    aligned = re.fullmatch(r"\\begin\{aligned\} (.*) \\end\{aligned\}", latex)
    if aligned is None:
        return [_sides(piece) for piece in split(latex, r"\qquad")]
    found: Rows = []
    for row in re.split(r" \\\\(?:\[6pt\])? ", _hidden(aligned[1])):
        cells = [_shown(cell).strip() for cell in row.split("&")]
        pairs = [(cells[k], cells[k + 1]) for k in range(0, len(cells) - 1, 2)] or [("", cells[0])]
        if not pairs[0][0] and not pairs[0][1].startswith("=") and found:  # a sum goes on
            found[-1] = (found[-1][0], f"{found[-1][1]} {pairs[0][1].removeprefix(chr(92) + 'quad ')}")
            continue
        if len(pairs) > 1 and width(beside := r" \quad ".join(f"{a} {b}" for a, b in pairs)) <= room - 2.0:
            pairs = [(cells[0], beside.removeprefix(cells[0]).strip())]
        found += pairs
    return found


def _sides(equation: str) -> tuple[str, str]:
    left, *rest = split(equation, "=")
    return (left, "= " + " = ".join(rest)) if rest else ("", left)


def _equation(left: str, right: str, room: float) -> Rows:
    """Return the lines of one equation."""
    if width(f"{left} {right}") <= room - 1.0:
        return [(left, right)]
    start, *others = split(right, "=") if right.startswith("=") else ["", right]
    sign = "= " if right.startswith("=") else ""
    lines: Rows = []
    space = room - width(left) - 2.0 if left else room - 1.0
    for number, part in enumerate([start, *others] if start else others):
        shown = _broken(part, space)
        lines.append((left if number == 0 else "", f"{sign}{shown[0]}"))
        lines += [("", rf"\quad {line}") for line in shown[1:]]
    return lines


def _broken(part: str, room: float) -> list[str]:
    """Return one side of an equation in lines: between factors, before signs, inside matrices."""
    if width(part) <= room:
        return [part]
    for mark, lead in ((r"\times", r"{} \times "), (r"\begin{bmatrix}", r"{} \cdot ")):
        factors = _factors(part, mark)
        if len(factors) > 1:
            parts = [_broken(factor, room - 1.5) for factor in factors]
            return [*parts[0], *(line for first, *rest in parts[1:] for line in (lead + first, *rest))]
    terms = re.split(r" (?=[+-] )", _hidden(part))
    if len(terms) > 1:
        return _filled([_shown(term) for term in terms], room)
    return _fraction(part, room) or _columns(part, room)


def _fraction(part: str, room: float) -> list[str]:
    """Return a wide fraction as the fraction of one times what was above the line, in lines; nothing for others."""
    found = re.fullmatch(r"(-?)\\frac\{([^{}]*)\}\{([^{}]*)\}", _braced(part))
    if found is None:
        return []
    sign, above, below = map(_unbraced, found.groups())
    scaled = re.fullmatch(r"([\d.]+) \((.*)\)", above)  # 0.5 (a + b) above the line
    factor, above = scaled.groups() if scaled else ("1", above)
    before = rf"{sign}\frac{{{factor}}}{{{below}}} ("
    lines = _filled([_shown(term) for term in re.split(r" (?=[+-] )", _hidden(above))], room - width(below))
    return [before + lines[0], *lines[1:-1], lines[-1] + ")"] if len(lines) > 1 else []


def _braced(text: str) -> str:
    """Return a text with the braces inside of braces hidden."""
    depth, out = 0, []
    for sign in text:
        depth -= sign == "}"
        out.append(_INNER.get(sign, sign) if depth else sign)
        depth += sign == "{"
    return "".join(out)


def _unbraced(text: str) -> str:
    for plain, hidden in _INNER.items():
        text = text.replace(hidden, plain)
    return text


def _factors(part: str, mark: str) -> list[str]:
    if mark == r"\times":
        return split(part, mark)
    if mark not in part:  # the search for it would take long in a long sum
        return [part]
    found = re.findall(r"(?:(?!\\begin\{bmatrix\}).)*\\begin\{bmatrix\}.*?\\end\{bmatrix\}[^\\]*", part)
    return [factor.strip() for factor in found] if "".join(found) == part else [part]


def _filled(terms: list[str], room: float) -> list[str]:
    """Return lines of terms, each as full as it may be."""
    lines, used = [terms[0]], width(terms[0])
    for term in terms[1:]:
        more = width(term)  # widths add up: a line is not measured anew with every term
        if used + more <= room - 1.0:
            lines[-1] += f" {term}"
            used += more
        else:
            lines.append(f"{{}} {term}")
            used = more
    return lines


def _columns(part: str, room: float) -> list[str]:
    r"""Return a matrix in several with some columns each: [a b ...] and [... c d]; anything else as it is."""
    found = re.fullmatch(r"(.*?)\\begin\{bmatrix\} (.*?) \\end\{bmatrix\}(.*?)", part)
    if found is None or r"\begin" in found[3]:
        return [part]
    rows = [row.split(" & ") for row in found[2].split(r" \\ ")]
    room -= width(found[1])
    if len(rows[0]) == 1:
        room -= 1.0
        terms = [re.split(r" (?=[+-] )", _hidden(entry)) for (entry,) in rows]
        lines = [_filled([_shown(term) for term in entry], room) for entry in terms]
        shown = [rf"\quad {line}" if k else line for entry in lines for k, line in enumerate(entry)]
        return [found[1] + _matrix([[line] for line in shown], [0], False, False) + found[3]]
    groups: list[list[int]] = [[]]
    for k in range(len(rows[0])):
        if groups[-1] and width(_matrix(rows, [*groups[-1], k], True, True)) > room:
            groups.append([])
        groups[-1].append(k)
    last = len(groups) - 1
    shown = [_matrix(rows, group, k > 0, k < last) for k, group in enumerate(groups)]
    return [(found[1] if k == 0 else "") + one + (found[3] if k == last else "") for k, one in enumerate(shown)]


def _matrix(rows: list[list[str]], columns: list[int], before: bool, behind: bool) -> str:
    dots = [r"\cdots"]
    lines = [" & ".join(dots * before + [row[k] for k in columns] + dots * behind) for row in rows]
    return r"\begin{bmatrix} " + r" \\ ".join(lines) + r" \end{bmatrix}"


# --- what stands inside of brackets and matrices is hidden while a formula is taken apart ---

_HIDE = {" ": "\1", "&": "\2", "\\\\": "\3"}
_INNER = {"{": "\4", "}": "\5"}


_MARK = re.compile(r"\\begin|\\end|\\\\|[ &(){}]")


def _hidden(text: str) -> str:
    depth = 0

    def hide(found: re.Match[str]) -> str:
        nonlocal depth
        sign = found[0]
        depth += (sign in ("(", "{", r"\begin")) - (sign in (")", "}", r"\end"))
        return _HIDE.get(sign, sign) if depth else sign

    return _MARK.sub(hide, text)


def _shown(text: str) -> str:
    for plain, hidden in _HIDE.items():
        text = text.replace(hidden, plain)
    return text


def split(text: str, mark: str) -> list[str]:
    """Return what stands between marks outside of all brackets and matrices."""
    if mark not in text:  # hiding takes longer than all the rest
        return [text.strip()]
    return [_shown(piece).strip() for piece in re.split(rf"(?:^| ){re.escape(mark)}(?: |$)", _hidden(text))]
