"""Read the [question.NAME] tables of a TOML file."""

import re
from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import pydantic

from qdot.exercises.common.errors import ErrorList, QdotError, make_name_error
from qdot.exercises.common.input_file import TomlFile, read_toml
from qdot.exercises.formula.equality import Rounding
from qdot.exercises.formula.units import parse_unit
from qdot.exercises.problem.rounding import parse_rounding
from qdot.exercises.questions.custom.definition import (
    GIVEN_GROUPS,
    SAMPLED_KINDS,
    TEXT_ANSWER,
    Definition,
    GivenValue,
    Option,
    Texts,
    split_units,
)
from qdot.exercises.questions.custom.question import make_question
from qdot.exercises.questions.custom.texts import check_latex, check_text, check_title
from qdot.exercises.questions.custom.units import UNIT_FORM, is_si_unit
from qdot.exercises.reference_answers import LETTERS

ONLY_NUMBERS = "only numbers have {}; with given values, a formula becomes a number"
MAX_TEXT_LENGTH, MAX_OPTIONS, HINT_COUNT = 5000, len(LETTERS), 3


class OptionEntry(pydantic.BaseModel):
    """One option, if it is not written as a text alone."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True, use_attribute_docstrings=True)
    text: str | None = None
    """What the option says. Each option has either `text` or `formula`."""
    formula: str | None = None
    """The formula that the option shows."""
    right: bool = False
    """Whether the option is correct."""


class TextsEntry(pydantic.BaseModel):
    """The texts of a question in another language, in [question.NAME.de]; texts that are missing stay in English."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True, use_attribute_docstrings=True)
    title: str | None = None
    """The title in this language."""
    prompt: str
    """The prompt in this language."""
    hints: list[str] = []
    """The hints in this language."""
    solution: str = ""
    """The solution in this language."""


class QuestionEntry(pydantic.BaseModel):
    """One [question.NAME]: a question of your own."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True, use_attribute_docstrings=True)
    title: str | None = None
    """The title that students see, in plain text. By default, the name of the question."""
    prompt: str
    """The question, in Markdown. A name in braces, as in {pose}, is replaced by the value in the student's problem."""
    answer: str | None = None
    """The formula of the answer, or "text" if a person marks it. Each question has either `answer` or `options`."""
    options: list[str | OptionEntry] | None = None
    """The options of a choice, shuffled for each student. If none is marked as right, the first one is."""
    shown: Literal["text", "formula"] = "text"
    """Whether plain options are texts or formulas."""
    given: list[str] | dict[str, str | float | int | list[float | int]] = []
    """The given values: groups ("pose", "rates", "velocity"), or for each symbol a kind, a range or a value."""
    rows: list[str] = []
    """The names of the entries of a vector in LaTeX, as in ["v_x", "v_y"]."""
    units: dict[str, str] = {}
    """The units of symbols that the arm does not have, as in {m = "kg"}."""
    unit: str = ""
    """The unit of a numeric answer, or the units of its entries, as in "rad/s, m/s"."""
    digits: int = pydantic.Field(default=3, ge=2, le=9)
    """The number of significant digits that a numeric answer needs."""
    tolerance: str | None = None
    """The error that a numeric answer may have, instead of `digits`."""
    up_to_factor: bool = False
    """Whether every nonzero multiple of a vector of formulas is also correct, as for a direction."""
    points: float = pydantic.Field(default=1.0, gt=0, lt=1e6)
    """The points of the question, if its [[problem]] does not set them."""
    hints: list[str] = []
    """Three hints, from vague to detailed."""
    solution: str = ""
    """How the answer is found. The answer itself is added."""
    de: TextsEntry | None = None
    """The texts in German."""


FORMS = {
    "title": 'expected a text, as in title = "Velocity of the middle of link 2"',
    "prompt": 'expected a text, as in prompt = "Find the velocity of the middle of link 2 in {base}."',
    "answer": 'expected a formula in quotes, as in answer = "ddt((o1 + o2)/2)", or answer = "text"',
    "options": 'expected a list of texts, as in options = ["z1", "x1", "z0"], or of tables, as in '
    '[{formula = "z1", right = true}, {text = "none of these"}]',
    "shown": 'expected "text" or "formula"',
    "given": 'expected a list of groups, as in given = ["pose", "rates"], or a table of symbols, as in '
    'given = {theta1 = "angle", m = [1, 5]}; kinds are ' + ", ".join(SAMPLED_KINDS),
    "rows": 'expected a list of names in LaTeX, as in rows = ["v_x", "v_y"]',
    "units": 'expected a table, as in units = {m = "kg", g = "m/s^2"}',
    "unit": 'expected a unit, as in unit = "m/s", or one for each entry, as in unit = "rad/s, m/s"',
    "digits": "expected a whole number from 2 to 9, as in digits = 3",
    "tolerance": 'expected a tolerance with its unit in quotes, as in tolerance = "0.01 m/s"',
    "up_to_factor": "expected true or false, without quotes",
    "points": "expected a positive number, as in points = 2",
    "hints": "expected a list of three texts, from vague to detailed",
    "solution": "expected a text in quotes",
    "de": "expected the texts in German: prompt, and perhaps title, hints and solution",
}  # fmt: skip
"""The expected form of each key, for messages and for the docs."""


def read_definitions(file: TomlFile, known_names: Collection[str]) -> dict[str, Definition]:
    """Return the questions that the [question.NAME] tables of a file define, by name.

    `known_names` are the names of the built-in questions. Raises QdotError with the file, the line and the key.
    """
    tables = file.content.get("question", {})
    if not isinstance(tables, dict):
        with file.locate_errors("question"):
            raise QdotError("write [question.NAME], with the name of the question")
    definitions, errors = dict[str, Definition](), ErrorList()
    for name in tables:
        with errors.collect():
            with file.locate_errors("question", name):
                _check_name(name, known_names)
                if not isinstance(tables[name], dict):
                    raise QdotError(f"expected a table, [question.{name}]")
            with errors.collect():
                file.check_keys(("question", name), tuple(QuestionEntry.model_fields), ("prompt",))
            with errors.collect():
                if isinstance(tables[name].get("de"), dict):
                    file.check_keys(("question", name, "de"), tuple(TextsEntry.model_fields), ("prompt",))
            entry = _validate(file, name, tables[name], errors)
            if entry is not None:
                definitions[name] = _read_definition(file, name, entry)
    errors.raise_all()
    return definitions


def read_question_file(path: Path, known_names: Collection[str]) -> tuple[TomlFile, dict[str, Definition]]:
    """Return a file and the questions that it defines; it may be the assignment.toml of an assignment.

    Raises QdotError with the file, the line and the key.
    """
    file = read_toml(path, "it should define questions, each in a table [question.NAME]", float)
    file.check_keys((), tuple(file.content) if "problem" in file.content else ("question",), ("question",))
    return file, read_definitions(file, known_names)


def _check_name(name: str, known_names: Collection[str]) -> None:
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name) or len(name) > 40:
        raise QdotError("the name of a question has small letters, digits and hyphens, as in tip-speed")
    if name in known_names:
        raise QdotError(f"{name!r} is the name of a built-in question; choose another name")


def _validate(file: TomlFile, name: str, table: dict[str, Any], errors: ErrorList) -> QuestionEntry | None:
    """Return the content of a question's table; None if it has wrong values, which are added to `errors`."""
    try:
        return QuestionEntry.model_validate(table)
    except pydantic.ValidationError as error:
        for detail in error.errors():
            location = detail["loc"]
            key_path = [str(key) for key in location[: 2 if location[0] == "de" else 1]]
            if detail["type"] in ("extra_forbidden", "missing") and len(location) == len(key_path):
                continue  # check_keys has reported these
            with errors.collect(), file.locate_errors("question", name, *key_path):
                raise QdotError(FORMS[key_path[-1]]) from None
    return None


def _read_definition(file: TomlFile, name: str, entry: QuestionEntry) -> Definition:
    errors = ErrorList()
    with errors.collect(), file.locate_errors("question", name):
        if (entry.answer is None) == (entry.options is None):
            raise QdotError("a question needs either an answer or options")
    _check_texts(file, name, entry, errors)
    _check_options_and_units(file, name, entry, errors)
    with errors.collect(), file.locate_errors("question", name, "options"):
        options = _read_options(entry)
    with errors.collect(), file.locate_errors("question", name, "given"):
        given = _read_given(entry)
    with errors.collect(), file.locate_errors("question", name, "unit"):
        if entry.unit and not entry.given:
            raise QdotError(ONLY_NUMBERS.format("a unit"))
    with errors.collect(), file.locate_errors("question", name, "digits" if entry.tolerance is None else "tolerance"):
        rounding = _read_rounding(entry)
    errors.raise_all()
    answer_key = "answer" if entry.options is None else "options"
    title = entry.title or name.replace("-", " ").capitalize()
    texts = [("en", Texts(title, entry.prompt, tuple(entry.hints), entry.solution))]
    if entry.de is not None:
        texts.append(("de", Texts(entry.de.title or "", entry.de.prompt, tuple(entry.de.hints), entry.de.solution)))
    definition = Definition(
        name, entry.answer or "", tuple(texts), options, given, tuple(entry.rows), tuple(sorted(entry.units.items())),
        entry.unit, rounding, entry.up_to_factor, entry.points,
        file.describe_value("question", name, answer_key),
    )  # fmt: skip
    with file.locate_errors("question", name, answer_key):
        question = make_question(definition)  # parses the formulas
    with file.locate_errors("question", name, "up_to_factor"):
        if entry.up_to_factor and (question.compute is None or given):
            raise QdotError("only a vector of formulas can count up to a factor; leave this key out")
    return definition


def _check_texts(file: TomlFile, name: str, entry: QuestionEntry, errors: ErrorList) -> None:
    """Add to `errors` the texts that are too long or have LaTeX that qdot doesn't support, with lines and keys."""
    languages: dict[tuple[str, ...], QuestionEntry | TextsEntry | None] = {(): entry, ("de",): entry.de}
    for key_path, texts in languages.items():
        if texts is None:
            continue
        for key in ("prompt", "hints", "solution"):
            value = getattr(texts, key)
            with errors.collect(), file.locate_errors("question", name, *key_path, key):
                if isinstance(value, list) and len(value) not in (0, HINT_COUNT):
                    raise QdotError(FORMS["hints"])
                for text in [value] if isinstance(value, str) else value:
                    if len(text) > MAX_TEXT_LENGTH:
                        raise QdotError(f"the text has more than {MAX_TEXT_LENGTH} characters")
                    check_text(text, file.text)
                if key == "prompt" and not value.strip():
                    raise QdotError(FORMS[key])
        with errors.collect(), file.locate_errors("question", name, *key_path, "title"):
            check_title(texts.title or "", file.text)


def _check_options_and_units(file: TomlFile, name: str, entry: QuestionEntry, errors: ErrorList) -> None:
    """Add to `errors` the options, names of rows and units that qdot can't show, with the line and the key."""
    with errors.collect(), file.locate_errors("question", name, "options"):
        for option in entry.options or ():
            if not isinstance(option, str):
                check_text(option.text or "", file.text)
            elif entry.shown == "text":
                check_text(option, file.text)
    with errors.collect(), file.locate_errors("question", name, "rows"):
        for row_name in entry.rows:
            check_latex(row_name)
    for key, units in (("unit", split_units(entry.unit)), ("units", entry.units.values())):
        with errors.collect(), file.locate_errors("question", name, key):
            for unit in units:
                if entry.unit and key == "unit" and not unit:
                    raise QdotError("each entry needs a unit between the commas; write 1 for a number without a unit")
                if not is_si_unit(unit):
                    raise QdotError(f"{unit!r} is not a unit that qdot knows; {UNIT_FORM}")


MIN_TOLERANCE = 1e-9
"""The smallest tolerance of a number, in SI units."""


def _read_rounding(entry: QuestionEntry) -> Rounding | None:
    """Return the tolerance of a number; None for the usual three digits, and for other answers."""
    sets_digits = "digits" in entry.model_fields_set
    if not sets_digits and entry.tolerance is None:
        return None
    if not entry.given:
        raise QdotError(ONLY_NUMBERS.format("digits or a tolerance"))
    if entry.tolerance is None:
        return parse_rounding(entry.digits)
    if sets_digits:
        raise QdotError("a number has either digits or a tolerance")
    rounding = parse_rounding(entry.tolerance)
    if rounding is None or entry.tolerance is None:
        raise QdotError(FORMS["tolerance"])
    units = [parse_unit(unit) for unit in split_units(entry.unit) if unit]
    tolerance_unit = parse_unit(entry.tolerance.strip().lstrip("0123456789.eE+- "))
    if tolerance_unit and any(unit and tolerance_unit.dimension != unit.dimension for unit in units):
        raise QdotError(f"the unit of the tolerance doesn't fit: the answer is in {entry.unit}")
    if rounding.absolute < MIN_TOLERANCE:
        raise QdotError(f"the tolerance must be at least {MIN_TOLERANCE:g}, because references have ten digits")
    return rounding


def _read_options(entry: QuestionEntry) -> tuple[Option, ...]:
    if entry.options is None:
        return ()
    options = []
    for item in entry.options:
        if isinstance(item, str):
            options.append(Option(item, entry.shown == "formula", False))
        elif (item.text is None) == (item.formula is None):
            raise QdotError("an option needs either text or formula")
        else:
            options.append(Option(str(item.formula or item.text), item.formula is not None, item.right))
    if not 2 <= len(options) <= MAX_OPTIONS:
        raise QdotError(f"a question has from 2 to {MAX_OPTIONS} options")
    if not any(option.is_correct for option in options):
        first_entry = entry.options[0]
        if isinstance(first_entry, OptionEntry) and "right" in first_entry.model_fields_set:
            raise QdotError("no option is right; write right = true for at least one")
        options[0] = replace(options[0], is_correct=True)
    if all(option.is_correct for option in options):
        raise QdotError("all options are right; at least one must be wrong")
    contents = [option.content for option in options]
    for content in contents:
        if contents.count(content) > 1:
            raise QdotError(f"two options are {content!r}")
    return tuple(options)


def _read_given(entry: QuestionEntry) -> tuple[GivenValue, ...]:
    if entry.given and entry.answer in (None, TEXT_ANSWER):
        raise QdotError("values are given only with a formula as the answer")
    if isinstance(entry.given, list):
        for name in entry.given:
            if name not in GIVEN_GROUPS:
                raise make_name_error("group", name, GIVEN_GROUPS)
        return tuple(map(GivenValue, entry.given))
    return tuple(_read_given_value(name, value) for name, value in entry.given.items())


def _read_given_value(name: str, value: str | float | list[float]) -> GivenValue:
    if name in GIVEN_GROUPS:
        raise QdotError(f'write given = ["{name}"], or name each symbol')
    if isinstance(value, str):
        if value not in SAMPLED_KINDS:
            raise make_name_error("kind of value", value, tuple(SAMPLED_KINDS))
        return GivenValue(name, value)
    limits = value if isinstance(value, list) else [value, value]
    if len(limits) != 2 or not limits[0] <= limits[1] or not all(abs(limit) < 1e6 for limit in limits):
        raise QdotError(f"{name}: expected a range [low, high], a number, or a kind ({', '.join(SAMPLED_KINDS)})")
    return GivenValue(name, "", float(limits[0]), float(limits[1]))
