"""The texts of a number that students may type, for platforms that compare texts: a list of texts, or a pattern."""

import math
import re
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction

DECIMALS_NOTE = (
    "<p>Type each number as a decimal, for example -0.25. "
    "Other forms, such as 2.5e-1 or 1/4, are not recognised here.</p>"
)
"""Instructions for students, as HTML, for platforms that compare texts and not numbers."""
SHOWN_DIGITS = 3
"""Number of significant digits of the first listed text, which platforms show as the correct answer."""
MAX_LISTED = 12
"""If more numbers than this have the same count of decimals, only the rounded and the truncated value are listed."""
MAX_DIGITS = 6
"""Maximum number of significant digits of a listed number, unless the tolerance requires more."""
ZEROS = ("0", "0.0", "0.00", "0.000", "-0")
MIN_STEPS, MAX_PATTERN_DECIMALS = 100, 30
"""A pattern has so many decimals (at most MAX_PATTERN_DECIMALS) that its range has at least MIN_STEPS steps of the last
decimal. The pattern may refuse numbers in the first and in the last step."""
_PLUS, _MINUS = r"\+?", "[-−]"
"""Patterns for the sign; the second minus sign is the one in typeset text."""


def list_accepted_texts(value: float, tolerance: float) -> tuple[str, ...]:
    """Return texts of numbers within a tolerance of a value; the first is the value to three or more digits.

    All numbers with few digits are listed. Of the numbers with more digits, only the rounded and the truncated value
    are listed.

    >>> list_accepted_texts(-20.71, 0.02)
    ('-20.7', '-20.73', '-20.72', '-20.71', '-20.70', '-20.69', '-20.710', '-20.7100')
    >>> list_accepted_texts(0.5, 0.0004)[:8]
    ('0.500', '.500', '0.5', '.5', '0.50', '.50', '0.4996', '.4996')
    """
    if value == 0:
        return ZEROS
    zeros = ZEROS if abs(value) <= tolerance else ()
    magnitude = math.floor(math.log10(abs(value)))
    shown_decimals = SHOWN_DIGITS - 1 - magnitude if tolerance else 0
    needed_decimals = math.ceil(-math.log10(2 * tolerance)) if tolerance else 0
    shown_texts, texts = list[str](), list[str]()
    for decimals in range(max(needed_decimals + 1, MAX_DIGITS - magnitude, 1)):
        scaled_value, scaled_tolerance = (Fraction(str(number)) * 10**decimals for number in (value, tolerance))
        numerators = [round(scaled_value), math.trunc(scaled_value)]
        if decimals >= shown_decimals:
            shown_texts.append(_format_fixed(numerators[0], decimals))
        if 2 * scaled_tolerance < MAX_LISTED:
            first, last = math.ceil(scaled_value - scaled_tolerance), math.floor(scaled_value + scaled_tolerance)
            numerators = list(range(first, last + 1))
        accepted_numerators = [n for n in numerators if n and abs(n - scaled_value) <= scaled_tolerance]
        texts += [_format_fixed(n, decimals) for n in accepted_numerators]
    first_text = next((text for text in shown_texts if text in texts), texts[-1])
    listed_texts: list[str] = []
    for text in (first_text, *texts):
        listed_texts += [text, re.sub(r"^(-?)0\.", r"\1.", text)]
    return tuple(dict.fromkeys((*listed_texts, *zeros)))


def _format_fixed(numerator: int, decimals: int) -> str:
    return f"{Decimal(numerator).scaleb(-decimals):f}"


def make_number_pattern(value: float, tolerance: float) -> str:
    r"""Return a regular expression for the numbers within a tolerance of a value, typed with any number of decimals.

    >>> make_number_pattern(-0.25, 0.005)
    '^\\s*(?:[-−](?:0?[.,]24[56789]\\d*|0?[.,]25(?:0\\d*)?|0?[.,]25[1234]\\d*))\\s*$'
    >>> make_number_pattern(12, 0)
    '^\\s*\\+?12(?:[.,]0*)?\\s*$'
    """
    exact_value, exact_tolerance = Fraction(str(value)), Fraction(str(tolerance))
    if tolerance == 0:
        return rf"^\s*{_PLUS if value >= 0 else _MINUS}{abs(value):.0f}(?:[.,]0*)?\s*$"
    low, high = exact_value - exact_tolerance, exact_value + exact_tolerance
    alternatives = []
    if high > 0:
        alternatives.append(f"{_PLUS}(?:{_write_range(max(low, Fraction(0)), high)})")
    if low < 0:
        alternatives.append(f"{_MINUS}(?:{_write_range(max(-high, Fraction(0)), -low)})")
    return rf"^\s*(?:{'|'.join(alternatives)})\s*$"


def _write_range(low: Fraction, high: Fraction) -> str:
    """Return a pattern for the decimal numbers without a sign from `low` to `high`."""
    decimals = next(count for count in range(1, MAX_PATTERN_DECIMALS) if (high - low) * 10**count >= MIN_STEPS)
    first, end = math.ceil(low * 10**decimals), math.floor(high * 10**decimals)
    # Blocks that differ only in their last fixed digit become one alternative, as in 24[56789].
    last_digits: dict[tuple[str, str], str] = {}
    for prefix, free_digits in _split_range(first, end, decimals):
        head, tail = _write_block(prefix, free_digits, decimals)
        last_digits[head[:-1], tail] = last_digits.get((head[:-1], tail), "") + head[-1]
    return "|".join(
        f"{head}{digits if len(digits) == 1 else f'[{digits}]'}{tail}" for (head, tail), digits in last_digits.items()
    )


def _split_range(first: int, end: int, decimals: int) -> Iterator[tuple[int, int]]:
    """Split the integers from `first` up to `end`, without `end`, into blocks of all integers with the same prefix.

    Yield for each block the prefix, and how many digits follow it. In the block that begins with 0, at least one
    decimal is in the prefix.
    """
    block_start = first
    while block_start < end:
        free_digits = 0
        while block_start % 10 ** (free_digits + 1) == 0 and block_start + 10 ** (free_digits + 1) <= end:
            if block_start == 0 and free_digits == decimals - 1:
                break
            free_digits += 1
        yield block_start // 10**free_digits, free_digits
        block_start += 10**free_digits


def _write_block(prefix: int, free_digits: int, decimals: int) -> tuple[str, str]:
    """Return a pattern for a block of numbers in two parts: up to the last fixed digit, and after it.

    Students may leave out a zero before the decimal point, and zeros at the end.
    """
    if free_digits >= decimals:
        return str(prefix), rf"\d{{{free_digits - decimals}}}" * (free_digits > decimals) + r"(?:[.,]\d*)?"
    whole, fraction = divmod(prefix, 10 ** (decimals - free_digits))
    digits = f"{fraction:0{decimals - free_digits}d}"
    fixed_digits = digits.rstrip("0")
    tail = r"\d*"
    for _ in range(len(digits) - len(fixed_digits)):
        tail = f"(?:0{tail})?"
    if not fixed_digits:
        return str(whole), f"(?:[.,]{tail})?"
    return f"{whole or '0?'}[.,]{fixed_digits}", tail
