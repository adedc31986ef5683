"""Fill in the texts of custom questions: {name} in braces is replaced by the value in the student's problem, typeset.

A placeholder is a group of values ({pose}, {rates}, {velocity}, {given}), the name of a given value, or a formula of
the question language. {base} stands for the frame in which results are expressed.
"""

import operator
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import sympy as sp

from qdot.exercises.common.errors import make_name_error
from qdot.exercises.problem.problem import Part, list_table_numbers
from qdot.exercises.questions.base import Question
from qdot.exercises.questions.custom.definition import GIVEN_GROUPS, SAMPLED_KINDS, Texts
from qdot.exercises.questions.custom.question import CustomDetails, CustomQuestion, DefinitionEvaluator
from qdot.exercises.questions.custom.texts import split_text
from qdot.exercises.questions.language import FormulaError, UnknownName
from qdot.exercises.questions.quantities import name_accelerations, name_load
from qdot.exercises.writing.languages import Catalogue, load_catalogue
from qdot.exercises.writing.latex import tex, tex_length, tex_value
from qdot.exercises.writing.units import tex_unit

if TYPE_CHECKING:
    from qdot.exercises.writing.wording import Wording

BASE, GIVEN = "base", "given"
"""The placeholders for the frame in which results are expressed, and for all given values."""


def write_custom_text(part: Part, text_name: str, wording: "Wording") -> str:
    """Return the prompt or the solution of a custom question; `text_name` is "prompt" or "solution"."""
    texts, text_wording = _find_texts(part, wording, operator.attrgetter(text_name))
    return fill_text(str(getattr(texts, text_name)), part, text_wording)


def write_custom_hints(part: Part, wording: "Wording") -> list[str]:
    """Return the hints of a custom question."""
    texts, text_wording = _find_texts(part, wording, lambda texts: texts.hints)
    return [fill_text(hint, part, text_wording) for hint in texts.hints]


def write_custom_symbols(part: Part, wording: "Wording") -> str:
    """Return the names that an answer may contain besides joint variables and lengths.

    If an answer contains one of the joint rates, all of them are listed, so that the list does not reveal which. The
    same is true of the velocity components, of the joint accelerations and of all other names. The problem's statement
    does not present the joint accelerations, so these are also typeset.
    """
    chain, used_names = wording.chain, {symbol.name for symbol in part.answer.as_matrix().free_symbols}
    accelerations = [name for name in part.symbols if name in name_accelerations(chain)]
    other_names = [name for name in part.symbols if name not in accelerations]
    groups = ([rate.name for rate in chain.rates], list(chain.task), other_names)
    codes = [f"`{name}`" for names in groups if not used_names.isdisjoint(names) for name in names]
    if not used_names.isdisjoint(accelerations):
        formulas = ", ".join(f"${tex(sp.Symbol(name), chain)}$" for name in accelerations)
        codes_text = ", ".join(f"`{name}`" for name in accelerations)
        codes.append(wording.messages.gettext("%(formulas)s (typed %(codes)s)", formulas=formulas, codes=codes_text))
    return ", ".join(codes)


def write_custom_options(part: Part, wording: "Wording") -> list[str]:
    """Return the options of a custom question in the order in which they are shown."""
    details = part.details_as(CustomDetails)
    options = (details.definition.options[index] for index in details.order)
    return [
        fill_text(f"{{{option.content}}}" if option.is_formula else option.content, part, wording) for option in options
    ]


def translate_title(question: Question, messages: Catalogue) -> str:
    """Return the title of a built-in or custom question in another language; in English if it is not translated."""
    if not isinstance(question, CustomQuestion):
        return messages.translate_question(question.title)
    return question.definition.find_texts(messages.language, lambda texts: texts.title).title


def _find_texts(part: Part, wording: "Wording", has_text: Callable[[Texts], object]) -> tuple[Texts, "Wording"]:
    """Return the texts and a wording in the language of `wording`, or both in English if a text is missing."""
    definition, messages = part.details_as(CustomDetails).definition, wording.messages
    texts = definition.find_texts(messages.language, has_text)
    has_language = texts.language == messages.language
    return texts, wording if has_language else replace(wording, messages=load_catalogue(texts.language))


def fill_text(text: str, part: Part, wording: "Wording") -> str:
    """Return a text of a custom question with its placeholders filled in. Raises FormulaError for unknown ones."""
    filled_pieces: list[str] = []
    for piece in split_text(text):
        filled_text, is_formula = piece.text, False
        if piece.is_placeholder:
            if piece.text == BASE:
                filled_pieces[-1] = wording.messages.add_article(filled_pieces[-1])
            filled_text, is_formula = _fill_placeholder(piece.text, part, wording)
        filled_pieces.append(f"${filled_text}$" if is_formula and not piece.is_in_formula else filled_text)
    return "".join(filled_pieces)


def find_unstated_values(part: Part, wording: "Wording") -> str | None:
    """Return a message on given values that a custom question needs but does not state; None if there are none."""
    try:
        if isinstance(part.details, CustomDetails) and part.details.all_values:
            check_given_values(write_custom_text(part, "prompt", wording), part, wording)
    except FormulaError as error:
        return str(error)
    return None


def check_given_values(prompt: str, part: Part, wording: "Wording") -> None:
    """Raise FormulaError if a prompt, already filled in, lacks a value that the student needs.

    A fixed value may be in the prompt in other words.
    """
    details = part.details_as(CustomDetails)
    unstated_symbols = [symbol for symbol, text in _write_values(details, wording).items() if text not in prompt]
    missing_names = DefinitionEvaluator(details.definition).list_needed_values(wording.chain, details, unstated_symbols)
    if missing_names:
        raise FormulaError(
            f"the text does not state the given values of {', '.join(missing_names)}; write {{given}}, or "
            f"{{{missing_names[0]}}} for a single value"
        )


def _fill_placeholder(content: str, part: Part, wording: "Wording") -> tuple[str, bool]:
    """Return the text for a placeholder, and whether this text is LaTeX for a formula."""
    details, chain = part.details_as(CustomDetails), wording.chain
    if content == BASE:
        return wording.frame, False
    values = {symbol.name: text for symbol, text in _write_values(details, wording).items()}
    if content in (*GIVEN_GROUPS, GIVEN):
        names = {
            "pose": [symbol.name for symbol in (*chain.q, *chain.parameters)],
            "rates": [rate.name for rate in chain.rates], "velocity": list(chain.task), "force": list(name_load(chain)),
            GIVEN: list(values),
        }[content]  # fmt: skip
        texts = [values[name] for name in names if name in values]
        if not texts:
            advice = 'write, for example, given = ["pose"]' if content == GIVEN else f"add {content!r} to `given`"
            raise FormulaError(f"{{{content}}}: the question gives no such values; {advice}")
        return ",$ $".join(texts), True
    if content in values:
        return values[content], True
    evaluator = DefinitionEvaluator(details.definition)
    try:
        return tex(evaluator.derive_text_formula(content, chain), chain), True
    except UnknownName as error:
        if error.name != content:
            raise
        known_names = [*GIVEN_GROUPS, GIVEN, BASE, *dict.fromkeys((*values, *error.known_names))]
        raise FormulaError(str(make_name_error("name", content, known_names))) from None


def _write_values(details: CustomDetails, wording: "Wording") -> Mapping[sp.Symbol, str]:
    """Return each given symbol with its value and unit, as LaTeX."""
    chain, texts = wording.chain, {}
    units = {value.name: SAMPLED_KINDS.get(value.kind, "") for value in details.definition.given}
    units |= {name: info.unit for name, info in (details.symbols or {}).items()}
    for symbol, value in details.all_values.items():
        if symbol in chain.q:
            text = tex_value(value, symbol)
        elif symbol in chain.parameters or symbol.name in list_table_numbers(chain):
            text = tex_length(value)
        else:
            unit = wording.find_unit(symbol) or units.get(symbol.name, "")
            text = f"{float(value):g}{tex_unit(unit)}"
        texts[symbol] = f"{tex(symbol, chain)} = {text}"
    return texts
