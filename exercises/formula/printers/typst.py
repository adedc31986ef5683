"""Formulas as Typst's mathematics."""

from qdot.exercises.formula.layout import DEGREE, SPACES, Layout

_SIZED = {"frac": "frac({}, {})", "tfrac": "inline(frac({}, {}))", "dfrac": "display(frac({}, {}))"}


def typst_string(text: str) -> str:
    r"""Return a text as a string of Typst's code.

    >>> print(typst_string('a "b" \\ c'))
    "a \"b\" \\ c"
    """
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def typst_math(one: Layout) -> str:
    r"""Return a formula as Typst's mathematics.

    >>> from qdot.exercises.formula.latex import parsed
    >>> typst_math(parsed(r"\dot{\theta}_{1} = -\tfrac{1}{2} a_{1}"))
    'dot(θ)_(1) = − inline(frac(1, 2)) a_(1)'
    """
    inner = one.inner
    if one.kind == "row":
        return " ".join(map(typst_math, inner)) or '""'
    if one.kind == "script":
        return _script(*inner)
    if one.kind == "fraction":
        return _SIZED[one.text].format(*map(typst_math, inner))
    if one.kind in ("root", "dotted"):
        return f"{'sqrt' if one.kind == 'root' else 'dot'}({typst_math(inner[0])})"
    if one.kind == "fenced":
        opening, closing = (_sign(sign) if sign != "." else "" for sign in one.text)
        return f"lr({opening} {typst_math(inner[0])} {closing})"
    if one.kind == "aligned":
        return " \\ ".join(" & ".join(map(typst_math, cells.inner)) for cells in inner)
    if one.kind == "matrix":
        rows = "; ".join(", ".join(map(typst_math, cells.inner)) for cells in inner)
        return f'mat(delim: "{one.text[0]}", {rows})'
    if one.kind == "word":
        return f'op("{one.text}")'
    if one.kind == "space":
        return f"#h({round(SPACES[one.text], 2)}em)"
    if one.kind == "text" or "," in one.text.strip(","):  # a decimal comma would part two numbers
        return typst_string(one.text)
    return _sign(one.text)


def _script(base: Layout, below: Layout, above: Layout) -> str:
    shown = typst_math(base) if base.kind != "row" or len(base.inner) == 1 else f"({typst_math(base)})"
    if above == DEGREE:
        return f"{shown} °"
    for mark, part in (("_", below), ("^", above)):
        shown += f"{mark}({typst_math(part)})" if part.inner or part.text else ""
    return shown


def _sign(text: str) -> str:
    return f"\\{text}" if len(text) == 1 and text in "()[]{},;:|/*'_^&#$\"\\" else text
