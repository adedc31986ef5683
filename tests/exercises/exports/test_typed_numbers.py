"""Listed texts and patterns accept only numbers within the tolerance, and right numbers with any number of digits."""

import random
import re
from fractions import Fraction

import pytest

from qdot.exercises.exports.typed_numbers import list_accepted_texts, make_number_pattern


def sample_value_and_tolerance(rng: random.Random) -> tuple[float, float]:
    value = float(f"{rng.choice([-1, 1]) * rng.uniform(1, 10) * 10 ** rng.randint(-3, 3):.10g}")
    floor = rng.choice([1e-5, 0.001, 0.02, 2])
    return (0.0 if rng.random() < 0.1 else value), float(f"{max(0.005 * abs(value), floor):.4g}")


def is_within(text: str, value: float, tolerance: Fraction) -> bool:
    return abs(Fraction(text) - Fraction(str(value))) <= tolerance


@pytest.mark.parametrize("seed", range(5))
def test_only_numbers_within_the_tolerance_are_accepted(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(100):
        value, tolerance = sample_value_and_tolerance(rng)
        exact_tolerance = Fraction(str(tolerance))
        texts, pattern = list_accepted_texts(value, tolerance), re.compile(make_number_pattern(value, tolerance))
        assert [text for text in texts if not is_within(text, value, exact_tolerance)] == []
        assert pattern.search(texts[0]) and len(texts) <= 40
        for _ in range(40):
            text = f"{value + rng.uniform(-2, 2) * tolerance:.{rng.randint(0, 8)}f}"
            if pattern.search(text):
                assert is_within(text, value, exact_tolerance), (value, tolerance, text)
            else:  # the first and the last of 100 steps may be refused
                assert not is_within(text, value, exact_tolerance * Fraction(97, 100)), (value, tolerance, text)


@pytest.mark.parametrize("text", ["-0.707", "-.707", "-0.71", "-0.7071", "-0.70711", "-0.707107", "-0.70710"])
def test_rounded_and_truncated_values_are_listed(text: str) -> None:
    assert text in list_accepted_texts(-0.70710678118, 0.0036)


@pytest.mark.parametrize("text", [" -0.707 ", "-,7071", "−0.70710678118", "-0.7100", "-0.71"])
def test_patterns_accept_commas_spaces_and_typeset_minus_signs(text: str) -> None:
    assert re.search(make_number_pattern(-0.70710678118, 0.0036), text)


@pytest.mark.parametrize("text", ["0.707", "-0.7", "-0.707 m", "-0.7.07", "", "-", "1-0.707", "-0.707\n1"])
def test_patterns_refuse_other_texts(text: str) -> None:
    assert not re.search(make_number_pattern(-0.70710678118, 0.0036), text)


def test_counts_are_exact() -> None:
    assert list_accepted_texts(3, 0) == ("3", "3.0", "3.00", "3.000", "3.0000", "3.00000")
    pattern = make_number_pattern(3, 0)
    assert [bool(re.search(pattern, text)) for text in ("3", "+3", "3.00", "3.01", "33", "-3")] == [True] * 3 + [
        False
    ] * 3


@pytest.mark.parametrize(("value", "tolerance"), [(173.123456789, 5e-7), (-0.123456789, 1e-9), (2.5e-7, 1e-9)])
def test_numbers_that_need_many_digits_are_listed(value: float, tolerance: float) -> None:
    texts = list_accepted_texts(value, tolerance)
    assert texts and all(is_within(text, value, Fraction(str(tolerance))) for text in texts)
