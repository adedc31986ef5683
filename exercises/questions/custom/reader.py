"""Read the [question.NAME] tables of a TOML file."""

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import cycle, islice
from pathlib import Path
from typing import Any, Literal, NamedTuple

import pydantic

from qdot.exercises.common.errors import ErrorList, QdotError, make_name_error
from qdot.exercises.common.input_file import TomlFile, read_toml
from qdot.exercises.formula.equality import Rounding
from qdot.exercises.formula.names import FUNCTIONS, normalize_name
from qdot.exercises.formula.units import parse_unit
from qdot.exercises.problem.rounding import Tolerance, parse_rounding, parse_tolerance
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
from qdot.exercises.questions.custom.question import check_question_names, make_question
from qdot.exercises.questions.custom.texts import check_latex, check_text, check_title
from qdot.exercises.questions.custom.units import check_si_unit
from qdot.exercises.reference_answers import LETTERS

ONLY_NUMBERS = "only numbers have {}; with given values, a formula becomes a number"
"""The error for a key that only numeric answers may have; {} is what the key sets."""
RESERVED_NAMES = {*FUNCTIONS, "pi"}
"""Names that have another meaning in students' answers, so symbols can't have them."""
MAX_TEXT_LENGTH = 5000
"""The most characters in one text of a question."""
MAX_OPTIONS = len(LETTERS)
"""The most options in a question: each has its own letter."""
HINT_COUNT = 3
"""The number of hints in a question with hints."""


class OptionEntry(pydantic.BaseModel):
    """One option, if it is not written as a text alone."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True)
    text: str | None = None
    """What the option says. Each option has either `text` or `formula`."""
    formula: str | None = None
    """The formula that the option shows."""
    right: bool = False
    """Whether the option is correct."""


class TextsEntry(pydantic.BaseModel):
    """The texts of a question in another language, in [question.NAME.de]; texts that are missing stay in English."""

    model_config = pydantic.ConfigDict(extra="forbid", strict=True)
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

    model_config = pydantic.ConfigDict(extra="forbid", strict=True)
    title: str | None = None
    """The title that students see, in plain text. By default, the name of the question."""
    prompt: str
    """The question, in Markdown. A name in braces, as in {pose}, is replaced by the value in the student's problem."""
    answer: str | None = None
    """The formula of the answer, or "text" if a person marks the answers. Each question has either `answer`
    or `options`."""
    options: list[str | OptionEntry] | None = None
    """The options of a choice, shuffled for each student. If none is marked as right, the first one is right."""
    shown: Literal["text", "formula"] = "text"
    """Whether options in quotes are texts or formulas."""
    given: list[str] | dict[str, str | float | int | list[float | int]] = []
    """The given values: groups (pose, rates, velocity, force), or for each symbol a kind, a range or a value."""
    rows: list[str] = []
    """The names, in LaTeX, of a vector's entries."""
    units: dict[str, str] = {}
    """The units of symbols that the arm does not have."""
    unit: str = ""
    """The unit of a numeric answer, or the units of its entries."""
    digits: int = pydantic.Field(default=3, ge=2, le=9)
    """The number of significant digits that a numeric answer needs."""
    tolerance: str | None = None
    """The allowed error of a numeric answer, or of each of its entries. Use it instead of `digits`."""
    up_to_factor: bool = False
    """Whether every nonzero multiple of a vector of formulas is also correct, as for a direction."""
    points: float = pydantic.Field(default=1.0, gt=0, lt=1e6)
    """The points of the question, if its [[problem]] does not set them."""
    hints: list[str] = []
    """Three hints."""
    solution: str = ""
    """How to find the answer. qdot appends the answer."""
    de: TextsEntry | None = None
    """German translations."""


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
    "tolerance": 'expected a tolerance with its unit in quotes, as in tolerance = "0.01 m/s", or one for each entry, '
    'as in tolerance = "0.01 rad/s, 0.01 m/s"',
    "up_to_factor": "expected true or false, without quotes",
    "points": "expected a positive number, as in points = 2",
    "hints": "expected a list of three texts, from vague to detailed",
    "solution": "expected a text in quotes",
    "de": "expected the texts in German: prompt, and perhaps title, hints and solution",
}  # fmt: skip
"""The expected form of each key, for messages and for the docs."""


FORMS_OF_SYMBOLS = {
    "given": f"expected a kind ({', '.join(SAMPLED_KINDS)}), a range such as [1, 5], or a number",
    "units": 'expected a unit in quotes, as in m = "kg"',
}
"""The expected form of the value of a symbol in a table, for messages."""


def read_definitions(file: TomlFile, known_names: Collection[str]) -> dict[str, Definition]:
    """Return the questions that the [question.NAME] tables of a file define, by name.

    `known_names` are the names of the built-in questions. Raises QdotError with the file, the line and the key.
    """
    tables = file.content.get("question", {})
    if not isinstance(tables, dict):
        with file.locate_errors("question"):
            raise QdotError("expected a table [question.NAME] for each question of your own")
    definitions, errors = dict[str, Definition](), ErrorList()
    for name in tables:
        with errors.collect():
            with file.locate_errors("question", name):
                _check_name(name, known_names)
                if not isinstance(tables[name], dict):
                    raise QdotError(f"expected a table, [question.{name}]")
            _check_tables(file, name, tables[name])
            with errors.collect():
                file.check_keys(("question", name), tuple(QuestionEntry.model_fields), ("prompt",))
            with errors.collect():
                if isinstance(tables[name].get("de"), dict):
                    file.check_keys(("question", name, "de"), tuple(TextsEntry.model_fields), ("prompt",))
            entry = _validate(file, name, tables[name], errors)
            if entry is not None:
                definitions[name] = _read_definition(file, name, entry)
    errors.raise_all()
    for name, definition in definitions.items():
        with file.locate_errors("question", name, definition.answer_key):
            check_question_names(definition, definitions)
    return definitions


class QuestionFile(NamedTuple):
    """A file, and the questions that it defines, by name."""

    file: TomlFile
    definitions: dict[str, Definition]


def read_question_file(path: Path, known_names: Collection[str]) -> QuestionFile:
    """Read a file that defines questions. The file may be an assignment.toml.

    Raises QdotError with the file, the line and the key.
    """
    file = read_toml(path, "it should define questions, each in a table [question.NAME]", float)
    file.check_keys((), tuple(file.content) if "problem" in file.content else ("question",))
    if not file.content.get("question"):
        raise QdotError(f"{path}: it defines no questions; write each in a table [question.NAME]")
    return QuestionFile(file, read_definitions(file, known_names))


def _check_name(name: str, known_names: Collection[str]) -> None:
    """Raise QdotError if a name can't be that of an instructor's question."""
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name) or len(name) > 40:
        raise QdotError("the name of a question has small letters, digits and hyphens, as in tip-speed")
    if name in known_names:
        raise QdotError(f"{name!r} is the name of a built-in question; choose another name")


def _check_tables(file: TomlFile, name: str, table: dict[str, Any]) -> None:
    """Raise QdotError, with the line, if a question contains a table that is not for a known language."""
    for key, value in table.items():
        if isinstance(value, dict) and key not in QuestionEntry.model_fields:
            with file.locate_errors("question", name, key):
                if re.fullmatch(r"[a-z]{2}", key):
                    raise QdotError(f"besides English, texts can be in German only, in [question.{name}.de]")
                raise QdotError(f"write the name of the question without a dot: [question.{name}-{key}]")


def _find_invalid_value(table: dict[str, Any], locations: Sequence[Sequence[str | int]]) -> tuple[list[str], str]:
    """Return the keys that lead to an invalid value, and the expected form.

    `locations` are the places of pydantic's errors, all of which are in the value of one key of the table.
    """
    key = locations[0][0]
    inner_keys = [inner_key for location in locations for inner_key in location[1:]]
    value = table[str(key)]
    if key == "de" and isinstance(value, dict):
        return ["de", str(inner_keys[0])], FORMS[str(inner_keys[0])]
    inner_key = next((str(inner) for inner in inner_keys if isinstance(value, dict) and inner in value), None)
    if inner_key is not None:
        return [str(key), inner_key], FORMS_OF_SYMBOLS[str(key)]
    number = next((inner + 1 for inner in inner_keys if isinstance(inner, int) and isinstance(value, list)), 0)
    prefix = f"number {number} of the list: " if number else ""
    return [str(key)], f"{prefix}{FORMS[str(key)]}"


def _validate(file: TomlFile, name: str, table: dict[str, Any], errors: ErrorList) -> QuestionEntry | None:
    """Return the content of a question's table; None if it has wrong values. Their messages are added to `errors`."""
    try:
        return QuestionEntry.model_validate(table)
    except pydantic.ValidationError as error:
        reported_types = ("extra_forbidden", "missing")  # check_keys has reported these
        locations = [
            details["loc"]
            for details in error.errors()
            if len(details["loc"]) > 2 or details["type"] not in reported_types
        ]
        for key in dict.fromkeys(location[0] for location in locations):
            key_path, form = _find_invalid_value(table, [location for location in locations if location[0] == key])
            with errors.collect(), file.locate_errors("question", name, *key_path):
                raise QdotError(form) from None
    return None


def _read_definition(file: TomlFile, name: str, entry: QuestionEntry) -> Definition:
    """Return the definition in a valid entry. Raises QdotError with all errors, each with its line and key."""
    errors, table = ErrorList(), file.content["question"][name]
    with errors.collect(), file.locate_errors("question", name):
        if (entry.answer is None) == (entry.options is None):
            raise QdotError("a question needs either an answer or options")
    with errors.collect(), file.locate_errors("question", name, "answer"):
        if entry.answer is not None and not entry.answer.strip():
            raise QdotError(FORMS["answer"])
        if entry.answer != TEXT_ANSWER and (entry.answer or "").strip().lower() == TEXT_ANSWER:
            raise QdotError('for a text that a person marks, write answer = "text"')
    _check_texts(file, name, entry, errors)
    with errors.collect():
        _check_keys_of_answer(file, name, entry)
    errors.raise_all()
    with errors.collect():
        _check_options_and_units(file, name, entry)
    with errors.collect(), file.locate_errors("question", name, "options"):
        options = _read_options(entry)
    with errors.collect(), file.locate_errors("question", name, "given"):
        given = _read_given(entry)
    with errors.collect(), file.locate_errors("question", name, "digits" if entry.tolerance is None else "tolerance"):
        rounding = _read_rounding(entry)
    errors.raise_all()
    title = entry.title or name.replace("-", " ").capitalize()
    texts = [Texts(title, entry.prompt, tuple(entry.hints), entry.solution)]
    if entry.de is not None:
        texts.append(Texts(entry.de.title or "", entry.de.prompt, tuple(entry.de.hints), entry.de.solution, "de"))
    definition = Definition(
        name, entry.answer or "", tuple(texts), options, given, tuple(entry.rows), tuple(sorted(entry.units.items())),
        entry.unit, rounding, entry.up_to_factor, entry.points, _locate_keys(file, name, table),
    )  # fmt: skip
    with file.locate_errors("question", name, definition.answer_key):
        question = make_question(definition)  # parses the formulas
    with file.locate_errors("question", name, "up_to_factor"):
        if entry.up_to_factor and (question.compute is None or given):
            raise QdotError("only a vector of formulas can count up to a factor; leave this key out")
    return definition


def _locate_keys(file: TomlFile, name: str, table: dict[str, Any]) -> dict[str, str]:
    """Return the file, the line and the key of each value of a question, by key.

    A key in a table has a dot, as in given.m.
    """
    key_paths: list[tuple[str, ...]] = [(key,) for key in table]
    tables = {key: value for key, value in table.items() if key in ("given", "units") and isinstance(value, dict)}
    key_paths += [(key, inner_key) for key, inner_table in tables.items() for inner_key in inner_table]
    return {".".join(key_path): file.describe_value("question", name, *key_path) for key_path in key_paths}


def _check_texts(file: TomlFile, name: str, entry: QuestionEntry, errors: ErrorList) -> None:
    """Add to `errors` each text that is too long or contains unsupported LaTeX, with its line and key."""
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


ANSWERS_WITH_KEY = {
    "shown": "options", "rows": "a vector", "up_to_factor": "a vector of formulas", "given": "a formula as the answer",
    "unit": "numbers", "digits": "numbers", "tolerance": "numbers", "units": "formulas",
}  # fmt: skip
"""Maps each key that only some questions may have to the answers or options of these questions, in words."""


def _check_keys_of_answer(file: TomlFile, name: str, entry: QuestionEntry) -> None:
    """Raise QdotError, with the line, if a key has no meaning for the question's kind of answer."""
    kind = "a formula"
    if entry.answer == TEXT_ANSWER:
        kind = "a text"
    elif entry.options is not None:
        kind = "options"
    elif re.match(r"\s*zeros\s*\(", entry.answer or ""):
        kind = "a set of configurations"
    shows_formulas = entry.shown == "formula" or any(
        isinstance(option, OptionEntry) and option.formula is not None for option in entry.options or ()
    )
    meaningless_keys = {"shown"} if kind == "a formula" else {*ANSWERS_WITH_KEY}
    if kind == "options":
        meaningless_keys -= {"shown", "units"} if shows_formulas else {"shown"}
    for key in entry.model_fields_set & meaningless_keys:
        with file.locate_errors("question", name, key):
            owner = ANSWERS_WITH_KEY[key]
            raise QdotError(f"only {owner} can have this key, but the answer is {kind}; leave it out")


def _check_options_and_units(file: TomlFile, name: str, entry: QuestionEntry) -> None:
    """Raise QdotError, with line and key, if qdot can't show an option, the name of a row or a unit."""
    with file.locate_errors("question", name, "options"):
        for option in entry.options or ():
            if not isinstance(option, str):
                check_text(option.text or "", file.text)
            elif entry.shown == "text":
                check_text(option, file.text)
    with file.locate_errors("question", name, "rows"):
        for row_name in entry.rows:
            check_latex(row_name)
    with file.locate_errors("question", name, "unit"):
        for unit in split_units(entry.unit):
            if entry.unit and not unit:
                raise QdotError("each entry needs a unit between the commas; write 1 for a number without a unit")
            check_si_unit(unit)
        if entry.unit and not entry.given:
            raise QdotError(ONLY_NUMBERS.format("a unit"))
    for symbol_name, unit in entry.units.items():
        with file.locate_errors("question", name, "units", symbol_name):
            if symbol_name in RESERVED_NAMES:
                raise QdotError(f"{symbol_name} has another meaning in formulas; choose another name")
            if not re.fullmatch(r"[A-Za-z]\w*", symbol_name, re.ASCII):
                raise QdotError("the name of a symbol has letters and digits, as in m, m1 or F")
            if normalize_name(symbol_name) != symbol_name:
                raise QdotError(f"write the name as {normalize_name(symbol_name)}, as students type it")
            check_si_unit(unit)


MIN_TOLERANCE = 1e-9
"""The smallest tolerance of a number, in SI units."""


def _read_rounding(entry: QuestionEntry) -> Rounding | None:
    """Return the tolerance of a numeric answer; None for the usual three digits, or if the answer is not numeric."""
    sets_digits = "digits" in entry.model_fields_set
    if not sets_digits and entry.tolerance is None:
        return None
    if not entry.given:
        raise QdotError(ONLY_NUMBERS.format("digits or a tolerance"))
    if entry.tolerance is None:
        return parse_rounding(entry.digits)
    if sets_digits:
        raise QdotError("a number has either digits or a tolerance")
    if re.search(r"\d,\d", entry.tolerance):
        raise QdotError(f"write decimals with a point; {FORMS['tolerance']}")
    units = split_units(entry.unit)
    tolerances = [parse_tolerance(text, FORMS["tolerance"]) for text in split_units(entry.tolerance)]
    count = max(len(tolerances), len(units))
    if {len(tolerances), len(units)} - {1, count}:
        counts = f"{len(tolerances)} tolerances, but `unit` has {len(units)} units"
        raise QdotError(f"it has {counts}; write one for each entry, or one for all entries")
    for tolerance, unit in islice(zip(cycle(tolerances), cycle(units), strict=True), count):
        _check_tolerance(tolerance, unit, entry.unit)
    sizes = tuple(tolerance.size for tolerance in tolerances)
    texts = [tolerance.words for tolerance in tolerances]
    words = texts[0] if len(set(texts)) == 1 else ", ".join(texts)
    return Rounding(0.0, min(sizes), words, sizes if len(sizes) > 1 else ())


def _check_tolerance(tolerance: Tolerance, unit_text: str, all_units: str) -> None:
    """Raise QdotError if the tolerance of an entry is too small, or does not fit the unit of the entry."""
    unit = parse_unit(unit_text) if unit_text else None
    if unit is not None and unit_text != "1" and not tolerance.unit_text:
        raise QdotError(f'its unit is missing; write, for example, tolerance = "{tolerance.amount_text} {unit_text}"')
    if unit is not None and tolerance.unit.dimension != unit.dimension:
        several = ", one for each entry" if "," in all_units else ""
        example = ", ".join(f"0.01 {each}" for each in split_units(all_units))
        raise QdotError(
            f"the unit of the tolerance doesn't fit: the answer is in {all_units}; write a tolerance{several}, as in "
            f'tolerance = "{example}"'
        )
    if tolerance.size < MIN_TOLERANCE:
        raise QdotError(f"the tolerance must be at least {MIN_TOLERANCE:g}, because references have ten digits")


def _read_options(entry: QuestionEntry) -> tuple[Option, ...]:
    """Return the options of a choice; () for other questions. Raises QdotError."""
    if entry.options is None:
        return ()
    options = []
    for number, option in enumerate(entry.options, 1):
        if isinstance(option, str):
            options.append(Option(option, entry.shown == "formula", is_correct=False))
        elif (option.text is None) == (option.formula is None):
            raise QdotError(f"option {number} needs either text or formula")
        else:
            options.append(Option(str(option.formula or option.text), option.formula is not None, option.right))
        if not options[-1].content.strip():
            raise QdotError(f"option {number} is empty")
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
    """Return the values that the question gives: groups, or values of single symbols. Raises QdotError."""
    if entry.given and entry.answer in (None, TEXT_ANSWER):
        raise QdotError("values are given only with a formula as the answer")
    if isinstance(entry.given, list):
        for name in entry.given:
            if name not in GIVEN_GROUPS:
                raise make_name_error("group", name, tuple(GIVEN_GROUPS))
            if entry.given.count(name) > 1:
                raise QdotError(f"{name!r} is listed twice")
        return tuple(map(GivenValue, entry.given))
    return tuple(_read_given_value(name, value) for name, value in entry.given.items())


def _read_given_value(name: str, value: str | float | list[float]) -> GivenValue:
    """Return the value of a symbol, from its kind, its range [low, high], or a number. Raises QdotError."""
    if name in GIVEN_GROUPS:
        raise QdotError(f'{name}: write given = ["{name}"], or name each symbol')
    if isinstance(value, str):
        if value not in SAMPLED_KINDS:
            raise QdotError(f"{name}: {make_name_error('kind of value', value, tuple(SAMPLED_KINDS))}")
        return GivenValue(name, value)
    limits = value if isinstance(value, list) else [value, value]
    if len(limits) != 2 or not limits[0] <= limits[1] or not all(abs(limit) < 1e6 for limit in limits):
        raise QdotError(f"{name}: expected a range [low, high], a number, or a kind ({', '.join(SAMPLED_KINDS)})")
    return GivenValue(name, "", float(limits[0]), float(limits[1]))
