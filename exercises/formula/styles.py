r"""The letters of LaTeX's math alphabets, as in \mathbf{v} and \mathbb{R}.

Unicode has a character for each of these letters, so printers treat them like other letters.
"""

import re
import unicodedata

from qdot.exercises.formula.layout import SYMBOLS, Layout, make_row

STYLES: dict[str, list[str]] = SYMBOLS["styles"]
"""Maps each command to the names of its styles in Unicode. Of the styles that have a character, the last is used; some
styles lack characters.
"""

_CHARACTER_NAME = re.compile(r"(?:MATHEMATICAL )?([A-Z -]+?) (?:CAPITAL \w+|SMALL \w+|DIGIT \w+|NABLA|\w+ SYMBOL)")


def _find_styled_characters() -> dict[str, dict[str, str]]:
    """Map each style to its characters, each under the plain character that it shows."""
    characters: dict[str, dict[str, str]] = {}
    for code in (*range(0x2100, 0x2150), *range(0x1D400, 0x1D800)):
        decomposition_kind, _, plain_code = unicodedata.decomposition(chr(code)).partition(" ")
        match = _CHARACTER_NAME.fullmatch(unicodedata.name(chr(code), ""))
        if decomposition_kind == "<font>" and match is not None:
            characters.setdefault(match[1], {})[chr(int(plain_code, 16))] = chr(code)
    return characters


_STYLED_CHARACTERS = _find_styled_characters()
_TABLES = {
    command: {letter: styled_letter for name in names for letter, styled_letter in _STYLED_CHARACTERS[name].items()}
    for command, names in STYLES.items()
}
STYLED_LETTERS = {
    styled_letter: (command, letter)
    for command, table in reversed(_TABLES.items())
    for letter, styled_letter in table.items()
}
"""Maps each styled letter to its command and its plain letter."""


def apply_style(command: str, piece: Layout) -> Layout:
    r"""Return a piece with its letters and digits, except in scripts, in the style of a command such as \mathbf."""
    table = _TABLES[command]
    if piece.kind in ("letter", "number", "sign") and table:
        letters = [Layout("letter", table[char]) if char in table else piece._replace(text=char) for char in piece.text]
        return letters[0] if len(letters) == 1 else make_row(*letters)
    if piece.kind == "script":
        return piece._replace(inner=(apply_style(command, piece.inner[0]), *piece.inner[1:]))
    parts = tuple(apply_style(command, part) for part in piece.inner)
    return parts[0] if piece.kind == "row" and len(parts) == 1 else piece._replace(inner=parts)
