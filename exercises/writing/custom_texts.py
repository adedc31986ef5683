"""Fill in the texts of custom questions: {name} in braces becomes what the student's own problem has, typeset.

A placeholder is a group of values ({pose}, {rates}, {velocity}, {given}), {base} for the frame in which results are
expressed, the name of a given value, or a formula of the question language.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import sympy as sp

from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.custom.definition import GIVEN_GROUPS, SAMPLED_KINDS, Texts
from qdot.exercises.questions.custom.question import CustomDetails, QuestionMaker
from qdot.exercises.questions.custom.texts import split_text
from qdot.exercises.questions.language import FormulaError
from qdot.exercises.writing.latex import tex, tex_length, tex_value

if TYPE_CHECKING:
    from qdot.exercises.writing.wording import Wording


def write_custom_text(part: Part, text_name: str, wording: "Wording") -> str:
    """Return the prompt or the solution of a custom question; `text_name` is "prompt" or "solution"."""
    return fill_text(str(getattr(_select_texts(part, wording), text_name)), part, wording)


def write_custom_hints(part: Part, wording: "Wording") -> list[str]:
    """Return the hints of a custom question."""
    return [fill_text(hint, part, wording) for hint in _select_texts(part, wording).hints]


def list_custom_symbols(part: Part, wording: "Wording") -> list[str]:
    """Return the names that an answer may contain besides joint variables and lengths, whole groups of names."""
    chain, used_names = wording.chain, {symbol.name for symbol in part.answer.as_matrix().free_symbols}
    groups = ([rate.name for rate in chain.rates], list(chain.task), list(part.symbols))
    return [name for names in groups if not used_names.isdisjoint(names) for name in names]


def write_custom_options(part: Part, wording: "Wording") -> list[str]:
    """Return the options of a custom question in the order in which they are shown."""
    details = part.details_as(CustomDetails)
    options = (details.definition.options[index] for index in details.order)
    return [
        fill_text(f"{{{option.content}}}" if option.is_formula else option.content, part, wording) for option in options
    ]


def _select_texts(part: Part, wording: "Wording") -> Texts:
    return part.details_as(CustomDetails).definition.texts_in(wording.messages.language)


def fill_text(text: str, part: Part, wording: "Wording") -> str:
    """Return a text of a custom question with its placeholders filled in. Raises FormulaError for unknown ones."""
    filled_pieces = []
    for piece in split_text(text):
        filled_text, is_formula = piece.text, False
        if piece.is_placeholder:
            filled_text, is_formula = _fill_placeholder(piece.text, part, wording)
        filled_pieces.append(f"${filled_text}$" if is_formula and not piece.is_in_formula else filled_text)
    return "".join(filled_pieces)


def _fill_placeholder(content: str, part: Part, wording: "Wording") -> tuple[str, bool]:
    """Return what a placeholder stands for, and whether it is LaTeX for a formula."""
    details, chain = part.details_as(CustomDetails), wording.chain
    if content == "base":
        return wording.frame, False
    values = {symbol.name: text for symbol, text in _write_values(details, wording).items()}
    if content in (*GIVEN_GROUPS, "given"):
        names = {
            "pose": [symbol.name for symbol in (*chain.q, *chain.parameters)],
            "rates": [rate.name for rate in chain.rates], "velocity": list(chain.task), "given": list(values),
        }[content]  # fmt: skip
        texts = [values[name] for name in names if name in values]
        if not texts:
            raise FormulaError(f"{{{content}}}: the question gives no such values; add {content!r} to `given`")
        return ",$ $".join(texts), True
    if content in values:
        return values[content], True
    maker = QuestionMaker(details.definition)
    return tex(maker.derive_text_formula(content, chain), chain), True


def _write_values(details: CustomDetails, wording: "Wording") -> Mapping[sp.Symbol, str]:
    """Return each given symbol with its value and unit, as LaTeX."""
    chain, texts = wording.chain, {}
    units = {value.name: SAMPLED_KINDS.get(value.kind, "") for value in details.definition.given}
    units |= dict(details.definition.units)
    for symbol, value in details.all_values.items():
        if symbol in chain.q:
            text = tex_value(value, symbol)
        elif symbol in chain.parameters:
            text = tex_length(value)
        else:
            unit = wording.find_unit(symbol) or units.get(symbol.name, "")
            text = rf"{float(value):g}\,\text{{{unit}}}" if unit else f"{float(value):g}"
        texts[symbol] = f"{tex(symbol, chain)} = {text}"
    return texts
