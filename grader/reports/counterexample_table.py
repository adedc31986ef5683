"""Make the table on a feedback page that shows where an answer is wrong.

The table has a configuration, the answer's value at this configuration, and the correct value.
"""

import math
import re
from dataclasses import dataclass

from qdot.exercises.formula.equality import Counterexample, EntryDifference, SetDifference
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.mathml import print_mathml
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.writing.latex import list_prismatic_joints, write_symbol
from qdot.exercises.writing.units import format_unit
from qdot.grader.judging.verdict import name_entry
from qdot.grader.reports.answer_display import make_visible
from qdot.grader.reports.counterexample_figure import caption_configurations

DIGITS, MAX_DIGITS = 4, 16
"""Number of significant digits that are shown; if two values then look the same, up to the maximum."""
ZERO_TOLERANCE = 1e-12
"""Values of symbols below this bound are shown as 0, because numeric searches end near zero, not at zero."""
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class ExampleRow:
    """A row of the table: its heading as HTML, which never contains a student's text, and the text of each cell."""

    heading_html: str
    cells: tuple[str, ...]


@dataclass(frozen=True)
class CounterexampleTable:
    """The table: its caption, the headings of its columns, the rows with the values of symbols, and the rows with the
    answer's value and the correct value.
    """

    caption: str
    columns: tuple[str, ...]
    symbol_rows: tuple[ExampleRow, ...]
    result_rows: tuple[ExampleRow, ...] = ()


def make_counterexample_table(problem: Problem, part: Part, example: Counterexample) -> CounterexampleTable | None:
    """Return a counterexample as a table.

    Correct values that the feedback level withholds are None in the counterexample, and are left out (see
    `feedback_levels.limit_feedback`). Return None if the answer contains symbols that the problem doesn't define, or if
    the table would only repeat a number of the answer.
    """
    captioned_configurations = (
        caption_configurations(part, example) if isinstance(example, SetDifference) else [("value", example.at)]
    )
    columns = ("Quantity", *(caption[0].upper() + caption[1:] for caption, _ in captioned_configurations))
    configurations = [configuration for _, configuration in captioned_configurations]
    symbol_infos, prismatic_names = problem.symbols, list_prismatic_joints(problem.chain)
    if any(set(configuration) - set(symbol_infos) for configuration in configurations):
        return None
    symbol_rows = []
    for name in symbol_infos:
        if not any(name in configuration for configuration in configurations):
            continue
        values = (configuration.get(name) for configuration in configurations)
        cells = tuple(_format_quantity(value, symbol_infos[name].unit) for value in values)
        symbol_rows.append(ExampleRow(print_mathml(parse_latex(write_symbol(name, prismatic_names))), cells))
    if isinstance(example, SetDifference):
        caption = "Configurations at which your answer is wrong"
        return CounterexampleTable(caption, columns, tuple(symbol_rows)) if symbol_rows else None
    if not symbol_rows and example.expected is None:
        return None
    caption = _write_caption(part, example, bool(symbol_rows))
    return CounterexampleTable(caption, columns, tuple(symbol_rows), _make_result_rows(part, example))


def _write_caption(part: Part, example: EntryDifference, has_configuration: bool) -> str:
    entry = _describe_entry(part, example)
    if has_configuration:
        return f"A configuration at which {entry or 'your answer'} is wrong"
    return entry.capitalize() or "Your answer and the correct one"


def _describe_entry(part: Part, example: EntryDifference) -> str:
    """Return the name of the entry that a counterexample concerns; "" if the answer has only one entry."""
    rows, columns = part.shape or (1, 1)
    if rows * columns == 1:
        return ""
    if part.answer.expected_units:  # the answer consists of numbers, each with a unit
        return f"number {example.entry + 1}"
    return name_entry(example.entry, columns)


def _make_result_rows(part: Part, example: EntryDifference) -> tuple[ExampleRow, ...]:
    units = part.answer.expected_units
    unit = units[example.entry] if units else ""
    if example.expected is None:
        return (ExampleRow("Your answer", (_format_value(example.yours, DIGITS, unit),)),)
    # a correct value is shown with the digits that an answer needs to be accepted
    digits = part.count_digits(example.expected, DIGITS) if isinstance(example.expected, float) else DIGITS
    answer_text, correct_text = _format_distinctly(example.yours, example.expected, unit, digits)
    heading = "Correct"
    if part.answer.is_direction and example.pivot is not None:
        # the correct direction is scaled so that its entry `pivot` equals the student's
        heading = f"Correct for your entry {example.pivot + 1}"
    return ExampleRow("Your answer", (answer_text,)), ExampleRow(heading, (correct_text,))


# --- numbers ---


def format_decimal(value: float, digits: int = DIGITS) -> str:
    """Return a number as text with `digits` significant digits, a true minus sign, and a power of ten if needed.

    >>> format_decimal(-0.728141), format_decimal(3.0), format_decimal(0.00000125)
    ('−0.7281', '3', '1.25·10⁻⁶')
    """
    mantissa, _, power = f"{value:.{digits}g}".partition("e")
    text = f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPT)}" if power else mantissa
    return text.replace("-", "−") if float(mantissa) else "0"


def _format_quantity(value: float | None, unit: str) -> str:
    """Return the value of a symbol with its unit, for an angle also in degrees; "any" for None."""
    if value is None:
        return "any"
    shown_value = value if abs(value) > ZERO_TOLERANCE else 0.0
    degrees = f" ({format_decimal(math.degrees(shown_value))}°)" if unit == "rad" else ""
    return f"{format_decimal(shown_value)} {format_unit(unit)}".rstrip() + degrees


def _format_distinctly(
    student_value: float | str, correct_value: float | str, unit: str, min_digits: int
) -> tuple[str, str]:  # fmt: skip
    """Return two values as texts, with enough digits to distinguish them."""
    for digits in range(min_digits, MAX_DIGITS + 1):
        answer_text, correct_text = (_format_value(value, digits, unit) for value in (student_value, correct_value))
        if answer_text != correct_text:
            break
    return answer_text, correct_text


def _format_value(value: float | str, digits: int, unit: str) -> str:
    """Return a value of an `EntryDifference` as a text.

    >>> _format_value(2.0, 4, "rad/s"), _format_value("blank", 4, ""), _format_value("0.3 + -0.2i", 4, "")
    ('2 rad/s', 'left blank', '0.3 − 0.2 i')
    >>> _format_value("-0.989949i", 4, "")
    '−0.9899 i'
    """
    if value == "blank":
        return "left blank"
    if isinstance(value, str):
        # 1 - 2i and 2i are our own forms, (1 - 2j) is Python's or mpmath's; older versions wrote 1 + -2i
        complex_number = re.fullmatch(r"\(?(?:([-\d.e]+) ([+-]) )?(-?)([\d.e-]+)[ij]\)?", value)
        if complex_number is None:
            return make_visible(value).replace("-", "−")
        real_part, sign, inner_minus, imaginary_part = complex_number.groups()
        imaginary_text = f"{format_decimal(float(imaginary_part), digits)} i"
        if real_part is None:
            return f"{inner_minus}{imaginary_text}".replace("-", "−")
        sign = "−" if (sign == "-") != bool(inner_minus) else "+"
        return f"{format_decimal(float(real_part), digits)} {sign} {imaginary_text}"
    return f"{format_decimal(float(value), digits)} {format_unit(unit)}".rstrip()
