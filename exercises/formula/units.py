"""Parse the units of numbers, such as m/s^2: their size in SI units, and their dimension."""

import math
import re
from dataclasses import dataclass

from qdot.exercises.formula.vocabulary import VOCABULARY

_BASE_UNITS: dict[str, tuple[str, str, int, int, int]] = VOCABULARY["base_units"]
"""Maps each unit to the numerator and the denominator of its size in SI units, and to its powers of kg, m and s."""
_NAMES = "|".join(re.escape(name) for name in sorted(_BASE_UNITS, key=len, reverse=True))
_POWER, _SEPARATOR = (f"(?:{VOCABULARY['patterns'][name]})" for name in ("power_of_unit", "between_units"))
_DIGITS: dict[str, str] = VOCABULARY["superscripts"]

_FACTOR = f"(?:{_NAMES}){_POWER}?"
UNIT = f"(?:1 ?/ ?)?{_FACTOR}(?:{_SEPARATOR}{_FACTOR}){{0,4}}"
"""Regular expression for a unit: powers of units, separated by *, / or a space."""
_UNIT_PATTERN = re.compile(UNIT)
_FACTOR_PATTERN = re.compile(f"({_SEPARATOR})({_NAMES})({_POWER}?)")


@dataclass(frozen=True)
class Unit:
    """A unit of measurement.

    To convert a number to SI units, multiply it by all `multipliers` and divide it by all `divisors`, which are numbers
    or "pi". `dimension` contains the powers of kg, m and s, which are 0 for angles.
    """

    multipliers: tuple[str, ...]
    divisors: tuple[str, ...]
    dimension: tuple[int, ...]

    @property
    def conversion(self) -> str:
        """The text after a number that converts it to SI units, such as /100 for cm."""
        return "".join([*(f"*{factor}" for factor in self.multipliers), *(f"/{factor}" for factor in self.divisors)])

    @property
    def size(self) -> float:
        """The size in SI units."""
        multiplier, divisor = (
            math.prod(math.pi if factor == "pi" else float(factor) for factor in factors)
            for factors in (self.multipliers, self.divisors)
        )
        return multiplier / divisor


_SI_SYMBOLS: dict[tuple[int, ...], str] = {
    (0, 1, 0): "m", (0, 0, 0): "rad", (0, 0, 1): "s", (1, 0, 0): "kg", (1, 1, -2): "N", (1, 2, -2): "N m",
    (1, 2, -3): "W", (0, 0, -1): "rad/s", (0, 1, -1): "m/s",
}  # fmt: skip
"""Maps each dimension of a unit in the vocabulary to the SI unit."""
_SI_NAMES = {"m", "rad", "s", "kg", "N", "Nm", "J", "W"}
"""Names of SI units, which `convert_to_si` leaves unchanged."""


def convert_to_si(text: str) -> str:
    """Return the SI unit, in the usual symbols, that has the same dimension as a unit; "" if there is none.

    >>> [convert_to_si(text) for text in ("meter/sec", "mm/s^2", "kg m/s", "rpm", "furlong")]
    ['m/s', 'm/s^2', 'kg m/s', 'rad/s', '']
    """
    unit = parse_unit(text)
    if unit is None or text == "":
        return ""

    def replace_factor(match: re.Match[str]) -> str:
        _, _, *dimension = _BASE_UNITS[match[2]]
        name = match[2] if match[2] in _SI_NAMES else _SI_SYMBOLS[tuple(dimension)]
        return f"{match[1]}{name}{match[3]}"

    si_text = _FACTOR_PATTERN.sub(replace_factor, text if text[0] == "1" else f" {text}").strip()
    si_unit = parse_unit(si_text)
    return si_text if si_unit is not None and si_unit.dimension == unit.dimension else ""


def find_units(text: str) -> list[Unit]:
    """Return the units after the numbers of a text.

    >>> [unit.size for unit in find_units("[2.3 N mm, 0.4 N m, 5]")]
    [0.001, 1.0]
    """
    matches = re.findall(rf"(?<=\d) ?({UNIT})(?![\w^])", text)
    return [unit for match in matches if (unit := parse_unit(match)) is not None]


def parse_unit(text: str) -> Unit | None:
    """Return the unit that a text names; None if there is no such unit.

    >>> parse_unit("cm/s^2")
    Unit(multipliers=(), divisors=('100',), dimension=(0, 1, -2))
    >>> parse_unit("deg").conversion, parse_unit("N m").dimension == parse_unit("J").dimension, parse_unit("furlong")
    ('*pi/180', True, None)
    """
    if text in ("", "1"):
        return Unit((), (), (0, 0, 0))
    if _UNIT_PATTERN.fullmatch(text) is None:
        return None
    multipliers, divisors, dimension = list[str](), list[str](), [0, 0, 0]
    text_with_separator = text if text[0] == "1" else f" {text}"  # each match contains the separator before a factor
    for separator, name, power_text in _FACTOR_PATTERN.findall(text_with_separator):
        digits = "".join(_DIGITS.get(sign, sign) for sign in power_text).strip("^*()").replace("−", "-")
        power = int(digits or 1) * (-1 if "/" in separator else 1)
        numerator, denominator, *base_powers = _BASE_UNITS[name]
        (multipliers if power > 0 else divisors).extend([numerator] * abs(power))
        (divisors if power > 0 else multipliers).extend([denominator] * abs(power))
        dimension = [total + power * base for total, base in zip(dimension, base_powers, strict=True)]
    return Unit(
        tuple(factor for factor in multipliers if factor != "1"),
        tuple(factor for factor in divisors if factor != "1"),
        tuple(dimension),
    )


def write_power_of_metres(power: int) -> str:
    """Return the unit m^power as text; "" for the power 0."""
    return {0: "", 1: "m"}.get(power, f"m^{power}")
