"""Parse the tolerances for rounded answers: in `decimals` of a [[problem]], and in `tolerance` of a custom question."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite

from qdot.exercises.common.errors import QdotError
from qdot.exercises.formula.equality import Rounding
from qdot.exercises.formula.units import Unit, parse_unit
from qdot.exercises.problem.credit import list_settings_by_question
from qdot.exercises.reference_answers.base import Answer
from qdot.exercises.reference_answers.formulas import Direction, Number

ROUNDING_FORM = (
    'expected "exact", a number of significant digits from 2 to 12 (decimals = 3), a tolerance with its unit '
    '(decimals = "0.01 rad/s"), or a table of these by question, as in decimals = {jacobian = 4, '
    'joint-rates = "1 deg/s"}'
)
"""The expected form of `decimals`, for messages and for the docs."""

_NUMBER_WORDS = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")


def read_decimals(
    setting: int | str | Mapping[str, int | str] | None, questions: Sequence[str]
) -> tuple[tuple[str, Rounding], ...]:
    """Return the allowed rounding of each question that accepts rounded decimals. Raises QdotError.

    >>> read_decimals({"jacobian": 4}, ["position", "jacobian"])
    (('jacobian', Rounding(relative=0.0005, absolute=0.0, words='to four significant digits')),)
    """
    roundings = ((name, parse_rounding(value)) for name, value in list_settings_by_question(setting, questions))
    return tuple((name, rounding) for name, rounding in roundings if rounding is not None)


def check_units(
    setting: int | str | Mapping[str, int | str], questions: Sequence[str], answers: Mapping[str, Answer]
) -> None:
    """Raise QdotError if the unit of a tolerance doesn't fit the numbers in an answer.

    `answers` has the answers to the questions to check. Counts need no tolerance. The entries of a direction have no
    unit.
    """
    for name, text in list_settings_by_question(setting, questions):
        answer = answers.get(name)
        if answer is None or not isinstance(text, str) or text == "exact":
            continue
        if isinstance(answer, Number) and answer.is_count:
            continue
        expected_units = [""] if isinstance(answer, Direction) else list(dict.fromkeys(answer.expected_units))
        dimensions = {unit.dimension for unit in map(parse_unit, expected_units) if unit is not None}
        if dimensions - {parse_tolerance(text, ROUNDING_FORM).unit.dimension}:
            units = " and ".join(filter(None, expected_units))
            raise QdotError(
                f"{text!r} doesn't fit {name}, whose numbers {f'are in {units}' if units else 'have no unit'}; "
                f"give {name} its own setting, as in decimals = {{{name} = 3}}"
            )


def parse_rounding(setting: int | str) -> Rounding | None:
    """Return the allowed rounding; None for "exact", which is the default. Raises QdotError."""
    if setting == "exact":
        return None
    if isinstance(setting, int):
        if isinstance(setting, bool) or not 2 <= setting <= 12:
            raise QdotError(ROUNDING_FORM)
        return Rounding(5.0 * 10.0**-setting, 0.0, f"to {_NUMBER_WORDS[setting - 2]} significant digits")
    tolerance = parse_tolerance(setting, ROUNDING_FORM)
    if not tolerance.unit_text:
        raise QdotError(ROUNDING_FORM)
    return Rounding(0.0, tolerance.size, tolerance.words)


@dataclass(frozen=True)
class Tolerance:
    """An absolute error: its size in SI units, and the amount and the unit that an instructor typed."""

    size: float
    amount_text: str
    unit_text: str
    unit: Unit

    @property
    def words(self) -> str:
        """The error in words, as in "within 0.01 rad/s"."""
        return f"within {self.amount_text} {self.unit_text}".strip()


def parse_tolerance(text: str, form: str) -> Tolerance:
    """Parse a tolerance such as "0.01 rad/s". Raises QdotError, whose message has `form`, the expected form.

    >>> parse_tolerance("1 cm", "").size, parse_tolerance("0.5", "").words
    (0.01, 'within 0.5')
    """
    match = re.fullmatch(r"\s*(\d*\.?\d+(?:[eE][-+]?\d+)?)\s*([A-Za-z°µμ].*?)?\s*", text)
    if match is None:
        raise QdotError(form)
    amount, unit_text = float(match[1]), match[2] or ""
    unit = parse_unit(unit_text)
    if unit is None:
        raise QdotError(f"{unit_text!r} is not a known unit; {form}")
    if not (isfinite(amount) and amount > 0):
        raise QdotError(f"a tolerance must be more than 0; {form}")
    return Tolerance(amount * unit.size, match[1], unit_text, unit)
