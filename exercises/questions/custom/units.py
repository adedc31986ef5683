"""Check the unit of a number: how the number grows if every length of the arm grows."""

import math
import re
from collections.abc import Mapping

import sympy as sp

POWERS_OF_METRES = {"m": 1, "s": 0, "rad": 0, "deg": 0, "kg": 0, "N": 1, "Nm": 2, "J": 2, "W": 2, "Hz": 0, "1": 0}
"""For each unit, the power of metres that it contains: a newton is a kg m/s^2."""

UNIT_FORM = f"numbers are in SI units, made of {', '.join(POWERS_OF_METRES)}, as in m/s^2"
"""The expected form of a unit, for messages."""

_FACTOR = re.compile(r"([*/]?)\s*([A-Za-z1]+)(?:\^(-?\d))?\s*")
SCALES = (1, 2, 4)
"""The factors by which lengths are multiplied."""


def find_power_of_metres(unit: str) -> int | None:
    """Return the power of metres in a unit; None if the unit is not known.

    >>> [find_power_of_metres(unit) for unit in ("m/s^2", "N*m", "rad/s", "", "furlong")]
    [1, 2, 0, 0, None]
    """
    power, position = 0, 0
    while position < len(unit):
        match = _FACTOR.match(unit, position)
        if match is None or match[2] not in POWERS_OF_METRES:
            return None
        sign = -1 if match[1] == "/" else 1
        power += sign * POWERS_OF_METRES[match[2]] * int(match[3] or 1)
        position = match.end()
    return power


def describe_power(power: float) -> str:
    """Return a power of lengths in words.

    >>> describe_power(0.0), describe_power(1.0), describe_power(-1.0)
    ('a number without lengths', 'a length', 'length^-1')
    """
    return {0.0: "a number without lengths", 1.0: "a length"}.get(round(power, 6), f"length^{power:.3g}")


def find_unit_objection(
    answer: sp.Matrix, values: Mapping[sp.Symbol, sp.Expr], units: Mapping[str, str], answer_unit: str
) -> str | None:
    """Return why numbers can't have a unit, or None.

    `answer` has formulas in which every length is a symbol, and `units` has the unit of each symbol that is not a
    length. An answer in m^k becomes 2^k times as large if all lengths are doubled.
    """
    powers = {symbol: find_power_of_metres(units.get(symbol.name, "m")) for symbol in values}
    expected_power = find_power_of_metres(answer_unit)
    if expected_power is None or None in powers.values():
        return None
    scaled = [{symbol: value * scale ** (powers[symbol] or 0) for symbol, value in values.items()} for scale in SCALES]
    for entry in answer:
        numbers = [complex(sp.N(entry.xreplace(dict(each)).xreplace(dict(each)))) for each in scaled]
        if min(map(abs, numbers)) < 1e-9 or not all(math.isfinite(abs(number)) for number in numbers):
            continue
        first, second = (math.log2(abs(numbers[k + 1] / numbers[k])) for k in (0, 1))
        if abs(first - second) > 1e-6:
            return "it has no unit, because it combines lengths with angles or other numbers"
        if abs(first - expected_power) > 1e-6:
            unit = f"its unit {answer_unit} doesn't fit, because" if answer_unit else "it has no unit, but"
            return f"{unit} it grows like {describe_power(first)} if all lengths grow"
    return None
