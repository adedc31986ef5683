r"""Split the texts of custom questions at their placeholders, and check their braces, dollar signs and LaTeX.

A placeholder is in braces, as in {pose}. In a formula between dollar signs, a brace belongs to LaTeX if it comes
directly after a letter or one of _ ^ } ]. Empty braces and \{ \} belong to LaTeX, too. Double braces stand for a brace.
"""

import re
from typing import NamedTuple

from qdot.exercises.common.errors import QdotError, find_most_similar, shorten
from qdot.exercises.formula.latex import COMMAND_NAMES, MARKDOWN_FORMULA, UnknownLatex, parse_latex
from qdot.exercises.formula.layout import Layout
from qdot.exercises.formula.printers.speech import print_speech

EXAMPLES_OF_LATEX = r"\vec{v}, \dot{q}, \mathbf{J}, \frac{a}{b}, \text{if}, \begin{bmatrix}"
"""LaTeX that qdot supports, for messages about LaTeX that it does not."""
QUOTES_ADVICE = r"write texts with backslashes in single quotes, as in 'Find $\theta_1$.'"
_SPECIAL_SIGN = re.compile(r"\\.|\$\$?|\{\{|\}\}|\{(?P<content>[^{}$]*)\}|[{}]", re.DOTALL)
"""Matches the signs that separate the pieces of a text: $, braces and placeholders, or a character after a backslash.
"""
_CHARACTER_BEFORE_LATEX_BRACE = re.compile(r"[A-Za-z_^}\]]$")
"""Matches the end of a text after which a brace belongs to LaTeX, as in \\vec{v} or q_{12}, and starts no placeholder.
"""
_CONTROL_CHARACTER = re.compile(r"([\x00-\x08\x0b-\x1f\x7f])([a-zA-Z]*)")
"""Matches a control character other than a tab and a line break, with the letters after it."""
_ESCAPE_LETTERS = {"\b": "b", "\t": "t", "\n": "n", "\f": "f", "\r": "r"}
"""Maps each control character that TOML reads from an escape, as in "\\frac", to the letter of the escape."""
_SIGN_IN_TEXT = re.compile(r"(\\text(?:rm)?\{[^{}]*?([\^_&#%~]))")
"""Matches \\text{ or \\textrm{ up to a sign that has another meaning there."""
_MAX_SHOWN_LENGTH, MAX_DEPTH = 60, 50
"""Maximum length of a formula in a message, and maximum depth of nested pieces of a formula."""


class TextPiece(NamedTuple):
    """A piece of a text: whether it is the content of a placeholder, and whether it is in a formula."""

    text: str
    is_placeholder: bool
    is_in_formula: bool


def split_text(text: str) -> list[TextPiece]:
    """Return the pieces of a text. Raises QdotError if a brace is unmatched.

    >>> [piece.text for piece in split_text("At {pose}, $M_{1} = {o1}$") if piece.is_placeholder]
    ['pose', 'o1']
    """
    pieces: list[TextPiece] = []
    position, depth, is_in_formula = 0, 0, False
    while match := _SPECIAL_SIGN.search(text, position):
        sign, content, is_placeholder = match[0], match["content"], False
        text_before = text[: match.start()]
        pieces.append(TextPiece(text[position : match.start()], is_placeholder=False, is_in_formula=is_in_formula))
        position = match.end()
        is_latex_brace = sign[0] == "{" and is_in_formula and _CHARACTER_BEFORE_LATEX_BRACE.search(text_before)
        if is_latex_brace or (sign[0] == "}" and depth):
            depth += 1 if is_latex_brace else -1
            sign, position = sign[0], match.start() + 1
        elif sign[0] == "$":
            if depth:
                raise QdotError(f"unmatched brace {{ in {_show(text_before.rpartition('$')[2])}")
            is_in_formula = not is_in_formula
        elif sign in ("{{", "}}"):
            sign = sign[0]
        elif sign in ("{", "}"):
            raise QdotError(f"unmatched brace {sign}; for a brace in the text, write {2 * sign}")
        elif content is not None and (content or not is_in_formula):
            sign, is_placeholder = content.strip(), True
        pieces.append(TextPiece(sign, is_placeholder, is_in_formula))
    return [*pieces, TextPiece(text[position:], is_placeholder=False, is_in_formula=is_in_formula)]


def check_text(text: str, source: str = "") -> None:
    r"""Raise QdotError if a Markdown text has an unmatched brace or dollar sign, or LaTeX that qdot does not support.

    `source` is the TOML file that contains the text. In double quotes, TOML turns the beginning of \theta into a tab.
    """
    _check_escapes(text, source)
    check_formulas("".join("x" if piece.is_placeholder else piece.text for piece in split_text(text)))


def check_formulas(markdown: str) -> None:
    """Raise QdotError if a dollar sign is unmatched, or if a formula has LaTeX that qdot does not support."""
    for match in MARKDOWN_FORMULA.finditer(markdown):
        latex = match[1] or match[2]
        if latex is not None:
            check_latex(" ".join(latex.split()))
    if re.search(r"(?<!\\)\$", MARKDOWN_FORMULA.sub("", markdown)):
        raise QdotError(r"unmatched dollar sign; put a formula between two dollar signs, and write \$ for a dollar")


def check_title(title: str, source: str = "") -> None:
    """Raise QdotError if a title is not plain text, because some platforms show only plain text in titles."""
    _check_escapes(title, source)
    if match := re.search(r"[$\\{}\n]", title):
        raise QdotError(f'a title is plain text without {match[0]!r}; write formulas as text, as in "Speed of P"')


def check_latex(latex: str) -> None:
    """Raise QdotError if a formula has LaTeX that qdot does not support."""
    if match := _SIGN_IN_TEXT.search(latex):
        raise QdotError(f"{match[1]}…}} contains {match[2]}; write it outside \\text, as in \\text{{m/s}}^2")
    try:
        layout = parse_latex(latex)
        if _find_depth(layout) > MAX_DEPTH:
            raise RecursionError
        if not print_speech(layout).strip(" ,"):
            raise QdotError(f"the formula {_show(latex)} shows nothing")
    except RecursionError:
        raise QdotError(f"{_show(latex)} is nested too deeply") from None
    except UnknownLatex as error:
        message = f"{error.problem} in {_show(latex)}"
        if error.command:
            guess = find_most_similar(error.command.lstrip("\\"), COMMAND_NAMES)
            hint = f" (did you mean \\{guess}?)" if guess else ""
            message += f"{hint}; supported are, for example, {EXAMPLES_OF_LATEX}"
        raise QdotError(message) from None


def _find_depth(layout: Layout) -> int:
    return 1 + max(map(_find_depth, layout.inner), default=0)


def _check_escapes(text: str, source: str) -> None:
    r"""Raise QdotError if a text has a control character, or a line break that was typed as the \n of \nabla."""
    breaks = re.finditer(r"(\n)([a-zA-Z]+)", "\0".join(match[0] for match in MARKDOWN_FORMULA.finditer(text)))
    for match in (*_CONTROL_CHARACTER.finditer(text), *re.finditer("(\t)([a-zA-Z]+)", text), *breaks):
        letter, other_letters = _ESCAPE_LETTERS.get(match[1], ""), match[2]
        command = letter + other_letters
        if match[1] not in "\n\t" or (command in COMMAND_NAMES and f"\\{command}" in source):
            cause = f"in double quotes, TOML reads \\{letter} as this character; " if letter else ""
            raise QdotError(f"the text has a control character before {other_letters!r}: {cause}{QUOTES_ADVICE}")


def _show(latex: str) -> str:
    return f"${shorten(' '.join(latex.split()), _MAX_SHOWN_LENGTH)}$"
