"""Where an answer differs, as a table: the configuration with units, the answer's value there and the right one."""

import math
import re
from dataclasses import dataclass

from qdot.exercises.formula.identity import Counterexample, EntryDifference, SetDifference
from qdot.exercises.formula.latex import parse_latex
from qdot.exercises.formula.printers.mathml import mathml
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.writing.latex import prismatic_joints, symbol_latex
from qdot.grader.judging.verdict import entry_name
from qdot.grader.reports.answers import visible

DIGITS, MOST_DIGITS = 4, 16
ROUNDING = 1e-12
"""What a joint's value is off that was searched for, where it is zero."""
WORDS = {"not a finite number": "not a finite number", "blank": "left blank"}
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class ExampleRow:
    """A row: its head as HTML, which is never a student's, and the text of a cell for each column."""

    head: str
    cells: tuple[str, ...]


@dataclass(frozen=True)
class Table:
    """A table: what it says, the heads of its columns, rows of symbols, rows of results."""

    caption: str
    columns: tuple[str, ...]
    symbols: tuple[ExampleRow, ...]
    results: tuple[ExampleRow, ...] = ()


def table_of(problem: Problem, part: Part, example: Counterexample) -> Table | None:
    """Return a counterexample as a table; None where it can't be followed.

    There is none to follow where the answer has symbols that the problem does not have. What is right is left out where
    that is kept back.
    """
    every = (example.missing, example.surplus) if isinstance(example, SetDifference) else (example.at,)
    places = [at for at in every if at is not None]
    known = problem.symbols()
    if any(set(at) - set(known) for at in places):
        return None
    names = [name for name in known if any(name in at for at in places)]
    symbols = tuple(
        ExampleRow(_symbol(problem, name), tuple(_quantity(at.get(name), known[name].unit) for at in places))
        for name in names
    )
    if isinstance(example, SetDifference):
        return _of_sets(example, symbols)
    return Table(_caption(part, example, bool(names)), ("Quantity", "Value"), symbols, _results(part, example))


def _of_sets(example: SetDifference, symbols: tuple[ExampleRow, ...]) -> Table | None:
    heads = {
        "Singular, and not in your answer": example.missing, "In your answer, and not singular": example.surplus
    }  # fmt: skip
    columns = tuple(head for head, at in heads.items() if at is not None)
    return Table("Configurations where it differs", ("Quantity", *columns), symbols) if columns and symbols else None


def _caption(part: Part, example: EntryDifference, at_a_place: bool) -> str:
    what = _what(part, example)
    return f"Where {what or 'it'} differs" if at_a_place else what.capitalize() or "Your answer and what is right"


def _what(part: Part, example: EntryDifference) -> str:
    """Return what the entry of a counterexample is called; nothing where there is one alone."""
    rows, columns = part.shape or (1, 1)
    if rows * columns == 1:
        return ""
    if part.answer.units_due:
        return f"number {example.entry + 1}"
    return entry_name(example.entry, columns)


def _results(part: Part, example: EntryDifference) -> tuple[ExampleRow, ...]:
    unit = part.answer.unit(example.entry)
    if example.expected is None:
        return (ExampleRow("Your answer", (_value(example.yours, DIGITS, unit),)),)
    yours, right = _values(example.yours, example.expected, unit)
    heads = "Your answer", "Right"
    if part.answer.counts_up_to_a_factor:
        heads = heads[0], "Right" if example.pivot is None else f"Right for your entry {example.pivot + 1}"
    return ExampleRow(heads[0], (yours,)), ExampleRow(heads[1], (right,))


def _symbol(problem: Problem, name: str) -> str:
    return mathml(parse_latex(symbol_latex(name, prismatic_joints(problem.chain))))


# --- numbers ---


def decimal(value: float, digits: int = DIGITS) -> str:
    """Return a number for people, with a true minus sign.

    >>> decimal(-0.728141), decimal(3.0), decimal(0.00000125)
    ('−0.7281', '3', '1.25·10⁻⁶')
    """
    mantissa, _, power = f"{value:.{digits}g}".partition("e")
    shown = f"{mantissa}·10{str(int(power)).translate(SUPERSCRIPT)}" if power else mantissa
    return shown.replace("-", "−") if float(mantissa) else "0"


def _quantity(value: float | None, unit: str) -> str:
    """Return a value with its unit, an angle in degrees too."""
    if value is None:
        return "any"
    value = value if abs(value) > ROUNDING else 0.0
    degrees = f" ({decimal(math.degrees(value))}°)" if unit == "rad" else ""
    return f"{decimal(value)} {unit}".rstrip() + degrees


def _values(yours: float | str, right: float | str, unit: str) -> tuple[str, str]:
    """Return two values with as many digits as it takes to tell them apart."""
    for digits in range(DIGITS, MOST_DIGITS + 1):
        shown = _value(yours, digits, unit), _value(right, digits, unit)
        if shown[0] != shown[1]:
            break
    return shown


def _value(value: float | str, digits: int, unit: str) -> str:
    if isinstance(value, str):
        complex_number = re.fullmatch(r"\(?([-\d.e]+) ([+-]) (-?)([\d.e-]+)[ij]\)?", value)
        if complex_number is None:
            return WORDS.get(value) or visible(value).replace("-", "−")
        real, sign, minus, imaginary = complex_number.groups()
        sign = "−" if (sign == "-") != bool(minus) else "+"
        return f"{decimal(float(real), digits)} {sign} {decimal(float(imaginary), digits)} i"
    return f"{decimal(float(value), digits)} {unit}".rstrip()
