"""Check the unit of a number by computing how the number changes if the units of mass, length and time change."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from qdot.exercises.common.errors import QdotError
from qdot.exercises.formula.units import convert_to_si, parse_unit
from qdot.exercises.questions.custom.definition import SAMPLED_KINDS

UNIT_FORM = "numbers are in SI units, made of m, s, rad, kg, N, J and W, as in m/s^2"
"""The expected form of a unit, for messages."""

Dimension = tuple[int, ...]
"""The powers of kg, m and s."""

_BASE_COUNT = 3
"""The number of base units: kg, m and s."""
_SCALES = (2, 4)
"""The factors by which masses, lengths or times are multiplied, one kind at a time."""
_MAX_ATTEMPTS = 3
"""Maximum number of sets of values that are tried until the result is finite."""
_GOLDEN_RATIO = 0.6180339887
"""The fractional parts of its multiples are spread evenly, so that no two values are nearly equal."""
_NEAR_ZERO = 1e-9
"""The size below which a value may be a rounding error."""
MIXED_UNITS = (
    "it has no unit, because it adds quantities of different units, or contains a function of a quantity with a unit"
)
"""Why a result has no unit, as a clause."""
_POWER_TOLERANCE = 1e-6
"""Tolerance for the computed powers of kg, m and s."""
_NAMES_OF_DIMENSIONS: dict[Dimension, str] = {
    (0, 0, 0): "a number without a unit", (0, 0, -1): "in rad/s or 1/s", (0, 0, -2): "in rad/s^2 or 1/s^2",
    (1, 1, -2): "in N", (1, 2, -2): "in N m", (1, 2, -3): "in W",
}  # fmt: skip


def check_si_unit(unit: str) -> None:
    """Raise QdotError if a unit is not an SI unit with the usual symbols, because students see it."""
    if unit in ("", "1"):
        return
    si_unit = convert_to_si(unit)
    if parse_unit(unit) is None:
        raise QdotError(f"{unit!r} is not a unit that qdot knows; {UNIT_FORM}")
    if si_unit != unit:
        advice = f"write {si_unit}; students may use other units, too" if si_unit else UNIT_FORM
        raise QdotError(f"{unit!r} is not an SI unit: {advice}")


def has_unit_of_kind(unit: str, kind: str) -> bool:
    """Return whether a symbol with a unit can have random values of a kind (SAMPLED_KINDS).

    >>> has_unit_of_kind("rad", "angle"), has_unit_of_kind("rad", "length"), has_unit_of_kind("m/s^2", "rate")
    (True, False, True)
    """
    dimension, dimension_of_kind = _find_dimension(unit), _find_dimension(SAMPLED_KINDS[kind])
    has_time = dimension[2] < 0 == dimension[0] and 0 <= dimension[1] <= 1
    is_moment = kind == "force" and dimension == (1, 2, -2)
    return dimension == dimension_of_kind or is_moment or (kind in ("rate", "velocity") and has_time)


def describe_dimension(dimension: Dimension) -> str:
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


@dataclass(frozen=True)
class EntryDimensions:
    """The powers of kg, m and s of each entry of a result; None if the powers of an entry can't be found.

    If `is_mixed`, an entry has no unit, because it is a sum of quantities with different units.
    """

    dimensions: tuple[Dimension | None, ...]
    is_mixed: bool = False


def find_dimensions(
    compute_entries: Callable[[Mapping[str, np.ndarray]], np.ndarray], units: Mapping[str, str]
) -> EntryDimensions:
    """Return the dimensions of the entries of a result that depends on symbols; `units` has the unit of each symbol.

    `compute_entries` returns the values of the entries, (entries, N), from the values of the symbols, (N,). An entry in
    m^k becomes 2^k times as large if all lengths are doubled, and so on for masses and times.

    >>> find_dimensions(lambda values: np.stack([values["m"] * values["v"] ** 2]), {"m": "kg", "v": "m/s"}).dimensions
    ((1, 2, -2),)
    """
    scales = np.ones((_BASE_COUNT, 1 + _BASE_COUNT * len(_SCALES)))  # in the first column, no base unit is scaled
    for base in range(_BASE_COUNT):
        first = 1 + base * len(_SCALES)
        scales[base, first : first + len(_SCALES)] = _SCALES
    for attempt in range(_MAX_ATTEMPTS):
        values = {
            name: (0.35 + (k + attempt + 1) * _GOLDEN_RATIO % 1) * np.prod(scales.T ** _find_dimension(unit), axis=1)
            for k, (name, unit) in enumerate(sorted(units.items()))
        }
        with np.errstate(all="ignore"):
            entries = np.abs(compute_entries(values))
        if np.isfinite(entries).all():
            break
    dimensions = [_find_powers(entry) for entry in entries]
    return EntryDimensions(tuple(dimension or None for dimension in dimensions), () in dimensions)


def _find_powers(entry: np.ndarray) -> Dimension | None:
    """Return the dimension of an entry, given its values for all scales; () if there is none, None if it is unknown."""
    if not np.isfinite(entry).all() or entry.min() < _NEAR_ZERO:
        return None
    ratios = np.log2(entry[1:].reshape(_BASE_COUNT, len(_SCALES)) / entry[0])
    powers = ratios[:, 0] / math.log2(_SCALES[0])
    if np.abs(ratios / np.log2(_SCALES) - powers[:, None]).max() > _POWER_TOLERANCE:
        return ()
    is_whole = np.abs(powers - np.round(powers)).max() < _POWER_TOLERANCE
    return tuple(map(round, powers.tolist())) if is_whole else None


def find_unit_objection(entries: EntryDimensions, answer_units: tuple[str, ...]) -> str | None:
    """Return why numbers can't have their units (one for all, or one for each), as a clause, or None."""
    if entries.is_mixed:
        return MIXED_UNITS
    expected_units = answer_units if len(answer_units) > 1 else answer_units * len(entries.dimensions)
    pairs = list(zip(expected_units, entries.dimensions, strict=True))
    if all(dimension in (None, _find_dimension(unit)) for unit, dimension in pairs):
        return None
    answer_unit = ", ".join(answer_units)
    known_dimensions = {dimension for dimension in entries.dimensions if dimension is not None}
    statement = f"its unit {answer_unit} doesn't fit, because" if answer_unit else "it has no unit, but"
    if len(known_dimensions) == 1:
        return f"{statement} the answer is {describe_dimension(known_dimensions.pop())}"
    names = ", ".join("?" if dimension is None else describe_dimension(dimension) for dimension in entries.dimensions)
    return f'{statement} its entries have different units ({names}); give each its own, as in unit = "rad/s, m/s"'


def _find_dimension(unit: str) -> Dimension:
    parsed_unit = parse_unit(unit)
    return parsed_unit.dimension if parsed_unit else (0, 0, 0)
