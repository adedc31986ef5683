"""Write units, such as m/s^2, with superscripts: as plain text, in a sentence, and after a number in a formula."""

import re

_POWER = re.compile(r"\^(-?\d+)")
_SUPERSCRIPTS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def format_unit(unit: str) -> str:
    """Return a unit as plain text.

    >>> format_unit("m^2/s"), format_unit("N*m")
    ('m²/s', 'N m')
    """
    return _POWER.sub(lambda match: match[1].translate(_SUPERSCRIPTS), unit).replace("*", " ")


def write_unit(unit: str) -> str:
    r"""Return a unit in Markdown: as a formula if it has a power.

    >>> print(write_unit("m/s"), write_unit("m/s^2"))
    m/s $\text{m/s}^{2}$
    """
    return f"${_write_latex(unit)}$" if "^" in unit else format_unit(unit)


def tex_unit(unit: str) -> str:
    r"""Return the LaTeX of a unit that follows a number.

    >>> print(tex_unit("m^2/s"))
    \,\text{m}^{2}\text{/s}
    """
    return rf"\,{_write_latex(unit)}" if unit else ""


def _write_latex(unit: str) -> str:
    pieces = _POWER.split(unit.replace("*", " "))
    return "".join(rf"^{{{piece}}}" if k % 2 else rf"\text{{{piece}}}" for k, piece in enumerate(pieces) if piece)
