"""Check the unit of a number: how the number changes if the units of mass, length and time change."""

import math
from collections.abc import Mapping

import sympy as sp

from qdot.exercises.formula.units import parse_unit

UNIT_FORM = "numbers are in SI units, made of m, s, rad, kg, N, J and W, as in m/s^2"
"""The expected form of a unit, for messages."""

_BASE_COUNT = 3
"""The number of base units: kg, m and s."""
_SCALES = (1, 2, 4)
"""The factors by which masses, lengths or times are multiplied."""
_POWER_TOLERANCE = 1e-6
"""Tolerance for the powers of kg, m and s that are computed from numbers."""
_NAMES_OF_DIMENSIONS: dict[tuple[int, ...], str] = {
    (0, 0, 0): "a number without a unit", (0, 0, -1): "in rad/s or 1/s", (0, 0, -2): "in rad/s^2 or 1/s^2",
    (1, 1, -2): "in N", (1, 2, -2): "in N m", (1, 2, -3): "in W",
}  # fmt: skip


def is_si_unit(unit: str) -> bool:
    """Return whether qdot knows a unit, and numbers in this unit are in SI units.

    >>> [is_si_unit(unit) for unit in ("m/s^2", "N*m", "rad/s", "", "deg", "furlong")]
    [True, True, True, True, False, False]
    """
    parsed_unit = parse_unit(unit)
    return parsed_unit is not None and not parsed_unit.conversion


def describe_dimension(dimension: tuple[int, ...]) -> str:
    """Return the powers of kg, m and s in words.

    >>> describe_dimension((0, 1, -2)), describe_dimension((1, 2, -2)), describe_dimension((0, 0, 0))
    ('in m/s^2', 'in N m', 'a number without a unit')
    """
    if name := _NAMES_OF_DIMENSIONS.get(dimension):
        return name
    powers = dict(zip(("kg", "m", "s"), dimension, strict=True))
    factors, divisors = (
        [unit if abs(power) == 1 else f"{unit}^{abs(power)}" for unit, power in powers.items() if power * sign > 0]
        for sign in (1, -1)
    )
    return f"in {' '.join(factors) or '1'}{''.join(f'/{divisor}' for divisor in divisors)}"


def find_unit_objection(
    answer: sp.Matrix, values: Mapping[sp.Symbol, sp.Expr], units: Mapping[str, str], answer_units: tuple[str, ...]
) -> str | None:
    """Return why numbers can't have their units (one for all, or one for each), or None.

    `answer` has formulas in which every length is a symbol, and `units` has the unit of each symbol that is not a
    length. An answer in m^k becomes 2^k times as large if all lengths are doubled, and so on for masses and times.
    """
    dimensions = {symbol: _find_dimension(units.get(symbol.name, "m")) for symbol in values}
    entry_dimensions: list[tuple[int, ...] | None] = []  # None if it can't be found
    for entry in answer:
        powers = []
        for base in range(_BASE_COUNT):
            symbol_powers = {symbol: dimension[base] for symbol, dimension in dimensions.items()}
            numbers = _evaluate_at_scales(entry, values, symbol_powers)
            if numbers is None:
                entry_dimensions.append(None)
                break
            first_power, second_power = (math.log2(numbers[k + 1] / numbers[k]) for k in (0, 1))
            if abs(first_power - second_power) > _POWER_TOLERANCE:
                return "it has no unit, because it adds quantities of different units, such as a length and an angle"
            powers.append(first_power)
        else:
            are_whole_numbers = all(abs(power - round(power)) < _POWER_TOLERANCE for power in powers)
            entry_dimensions.append(tuple(map(round, powers)) if are_whole_numbers else None)
    expected_units = answer_units if len(answer_units) > 1 else answer_units * len(entry_dimensions)
    pairs = list(zip(expected_units, entry_dimensions, strict=True))
    if all(dimension in (None, _find_dimension(unit)) for unit, dimension in pairs):
        return None
    answer_unit, found_dimensions = ", ".join(answer_units), {each for each in entry_dimensions if each is not None}
    statement = f"its unit {answer_unit} doesn't fit, because" if answer_unit else "it has no unit, but"
    if len(found_dimensions) == 1:
        return f"{statement} the answer is {describe_dimension(found_dimensions.pop())}"
    names = ", ".join("?" if each is None else describe_dimension(each) for each in entry_dimensions)
    return f'{statement} its entries have different units ({names}); give each its own, as in unit = "rad/s, m/s"'


def _evaluate_at_scales(
    entry: sp.Expr, values: Mapping[sp.Symbol, sp.Expr], symbol_powers: Mapping[sp.Symbol, int]
) -> list[float] | None:
    """Return the absolute value of an entry for each of _SCALES; None if one of them is infinite or almost zero.

    Each symbol's value is multiplied by the scale to the symbol's power.
    """
    numbers = []
    for scale in _SCALES:
        scaled_values = {symbol: value * scale ** symbol_powers[symbol] for symbol, value in values.items()}
        # twice, because the value of a joint may contain lengths
        numbers.append(abs(complex(sp.N(entry.xreplace(scaled_values).xreplace(scaled_values)))))
    return numbers if min(numbers) >= 1e-9 and all(map(math.isfinite, numbers)) else None


def _find_dimension(unit: str) -> tuple[int, ...]:
    parsed_unit = parse_unit(unit)
    return parsed_unit.dimension if parsed_unit else (0, 0, 0)
