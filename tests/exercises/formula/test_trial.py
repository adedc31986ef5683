"""Numeric comparison: what doubles decide, which points need many digits, and the counterexamples shown."""

from collections.abc import Mapping
from typing import Any

import mpmath
import numpy as np
import pytest

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import equality
from qdot.exercises.formula.equality import (
    Comparison,
    Domain,
    EntryDifference,
    Rounding,
    choose_default_role,
    compare_entries,
    compute_chance_of_missing,
    to_json_number,
)
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program
from qdot.exercises.formula.trees import Node, find_names

ZERO = "sin(theta1 + theta2) - sin(theta1)*cos(theta2) - cos(theta1)*sin(theta2)"
HUGE = f"10^30*({ZERO})"
"""Zero, with terms so large that 50 digits leave 1e-20."""


def parse_both(*answers: str | list[str]) -> list[list[Node]]:
    return [[parse_formula(text) for text in ([each] if isinstance(each, str) else each)] for each in answers]


def make_comparison(
    student: str | list[str], reference: str | list[str], points: int = 200,
    allowed: tuple[float, float] = (0.0, 0.0), **values: list[float],
) -> Any:  # fmt: skip
    theirs, ours = parse_both(student, reference)
    used = set().union(*(find_names(node) for node in theirs + ours))
    points = len(next(iter(values.values()))) if values else points
    at = Domain({name: choose_default_role(name) for name in used}).sample(used, points, Stream("trial"))
    at |= {name: np.array(column) for name, column in values.items()}
    programs = compile_program(theirs), compile_program(ours)
    return equality._NumericComparison(programs, [allowed] * len(theirs), at, {}, points)


def compare(student: str | list[str], reference: str | list[str], rounding: Rounding | None = None) -> Comparison:
    theirs, ours = parse_both(student, reference)
    used = set().union(*(find_names(node) for node in theirs + ours))
    return compare_entries(theirs, ours, Domain({name: choose_default_role(name) for name in used}), "seed", rounding)


def find_counterexample(student: str, reference: str) -> EntryDifference:
    comparison = compare(student, reference)
    assert comparison.is_correct == (False,)
    assert isinstance(comparison.certificate.counterexample, EntryDifference)
    return comparison.certificate.counterexample


def is_readable(at: Mapping[str, float]) -> bool:
    return all(round(value, 2) == value for value in at.values())


@pytest.mark.parametrize("unit", ["1e-6", "1", "1e6"])
def test_difference_is_clear_above_a_fraction_of_the_terms(unit: str) -> None:
    for part, clear in (("101*10^-11", True), ("99*10^-11", False)):
        is_clear = make_comparison(f"{unit}*a1*(1 + {part})", f"{unit}*a1")._is_clearly_different(0)
        assert is_clear.all() if clear else not is_clear.any()


def test_allowed_difference_is_not_clear() -> None:
    for factor, clear in (("1.004", False), ("1.006", True)):
        comparison = make_comparison(f"{factor}*a1", "a1", allowed=(0.005, 0.0))
        assert (comparison._is_clearly_different(0) == clear).all()
        assert (comparison._is_clearly_allowed(0) != clear).all()


def test_rounding_error_counts_both_sides() -> None:
    """Two sums of large terms cancel differently; their difference is only rounding."""
    comparison = make_comparison(
        "a1 + 10^9*(sin(theta1)^2 + cos(theta1)^2 - 1)", "a1 + 10^9*(1 - sin(theta1)^2 - cos(theta1)^2)"
    )
    assert comparison.difference.max() > 1e-8
    assert (comparison.difference <= comparison.rounding_error).all()
    assert not comparison._is_clearly_different(0).any()


def test_possible_rounding_is_not_clearly_allowed() -> None:
    comparison = make_comparison(f"a1 + {HUGE}", "a1", allowed=(0.0, 0.01))
    assert not comparison._is_clearly_allowed(0).any()


def test_product_with_zero_has_no_rounding_error() -> None:
    comparison = make_comparison("0*sqrt(a1)", "0")
    assert comparison._is_clearly_allowed(0).all()
    assert comparison._choose_points(0) == []


def test_term_scales_fall_back_to_the_largest_entry() -> None:
    sizes = [[0.2, 0, 0, 0, np.nan, 0.5], [0.3, 0.5, 0, np.nan, 0.25, np.inf], [4.0, 0.25, 0, 2, 0.5, 0]]
    scales = [[0.2, 0.5, 1, 1, 1, 0.5], [0.3, 0.5, 1, 1, 0.25, 1], [4.0, 0.25, 1, 2, 0.5, 1]]
    assert equality._compute_term_scales(np.array(sizes)).tolist() == scales


def test_chosen_points_cover_regions_and_the_largest_differences() -> None:
    text = " + ".join(f"abs(theta{k})" for k in range(1, 6))
    comparison = make_comparison(text, text, 2000)
    assert len(set(comparison.region_numbers)) == 32
    comparison.difference[0] = comparison.rounding_error[0] * np.linspace(1.0, 0.5, 2000)
    worst = [1998, 1993, 1995]
    comparison.difference[0, worst] = comparison.rounding_error[0, worst] * [5, 4, 3]
    looked = comparison._choose_points(0)
    firsts = {region: list(comparison.region_numbers).index(region) for region in set(comparison.region_numbers)}
    assert looked[:16] == sorted(firsts.values())[:16]
    assert sorted(looked[16:]) == sorted(worst)


def test_largest_differences_are_relative_to_rounding() -> None:
    comparison = make_comparison("sqrt(a1^2)", "a1", 20)
    comparison.difference[0], comparison.allowed_error[0], comparison.rounding_error[0] = 10.0, 0.0, 10.0
    rows = {11: (20, 0, 2), 12: (2, 0, 0.1), 13: (30, 10, 1.5), 14: (40, 39, 3), 15: (100, 0, 50)}
    for point, (off, room, noise) in rows.items():
        comparison.difference[0, point], comparison.allowed_error[0, point] = off, room
        comparison.rounding_error[0, point] = noise
    assert comparison._choose_points(0)[0] == 0  # of the only region
    assert sorted(comparison._choose_points(0)[1:]) == [11, 12, 13]


def test_only_readable_points_may_be_removable_singularities() -> None:
    text = "sqrt(a1^2)*(a1 - 1)/(a1 - 1)"
    at = [0.5, 1.5, 2.5, 0.25, 3.0, 4.0, 0.75, 0.3, 0.6, 0.7, 0.8, 0.9]
    for where, expected in (([], True), ([0], True), ([3, 7], True), ([8], False), ([11], False)):
        comparison = make_comparison(text, "a1", a1=[1.0 if k in where else value for k, value in enumerate(at)])
        assert comparison.is_equal(0) is expected, where


def test_bound_counts_points_where_all_entries_are_defined() -> None:
    texts = ["a1", "1/(abs(x) + x)"]
    comparison = make_comparison(texts, texts, 2000)
    assert 900 < comparison.defined_count < 1100
    certificate = compare(texts, texts).certificate
    assert certificate.points == 2000
    assert certificate.bound is not None
    assert compute_chance_of_missing(1100, 0.02) < certificate.bound < compute_chance_of_missing(900, 0.02)


TERMS = f"(sqrt(a1^2)*(10^400/10^400) + 1e14*({ZERO}))*1e9"
"""Terms beyond doubles, 1e14 times their sum: 50 digits leave 1e-36, so 200 digits decide."""
PARTLY = "1/(abs(x) + x)"
DECIDED = [
    # to 40 digits of the terms
    *((f"{unit}*sqrt(a1^2)*(10^41 + {part})/10^41", f"{unit}*a1", part < 10)
      for unit in ("1e-20", "1", "1e20") for part in (9, 11)),
    (f"sqrt(a1^2) + {HUGE}", "a1", True), (f"sqrt(a1^2)*(10^30 + 1)/10^30 + {HUGE}", "a1", False),
    *((f"{sign}{TERMS}*(10^30 + {off})/10^30", f"{sign}1e9*a1", off == 0) for sign in ("", "-") for off in (0, 1)),
    # defined only with more digits: the argument is 0 with 50 digits, and -1e-16 in doubles
    ("log((3 + 3*10^-60)/3 - 1)", "log(10^-60)", True), ("log(1/49*(49 + 49*10^-60) - 1)", "log(10^-60)", True),
    ("sqrt(a1^2)/((3*10^60 + 3)/(3*10^60) - 1)", "10^60*a1", True),
    (PARTLY, PARTLY, True), (f"(10^30 + 1)/10^30*{PARTLY}", PARTLY, False),  # compared where the reference is defined
]  # fmt: skip


@pytest.mark.parametrize(("student", "reference", "expected"), DECIDED)
def test_precision_increases_until_decided(student: str, reference: str, expected: bool) -> None:
    assert compare(student, reference).is_correct == (expected,)


def test_relative_rounding_applies_where_the_reference_is_defined() -> None:
    assert compare(f"1.001*{PARTLY}", PARTLY, Rounding(0.005)).is_correct == (True,)
    assert compare(f"1.01*{PARTLY}", PARTLY, Rounding(0.005)).is_correct == (False,)


def test_number_of_precise_evaluations_is_limited() -> None:
    comparison = make_comparison("sqrt(a1^2)", "a1")
    comparison.remaining_evaluations = 3
    is_left_out = [comparison._evaluate_precisely(point, 50) is None for point in range(5)]
    assert is_left_out == [False, False, False, True, True]
    assert comparison._evaluate_precisely(1, 50) is not None  # cached


def test_long_answers_get_fewer_precise_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(equality, "_MAX_PRECISE_STEPS", 1000)
    short, long = make_comparison("sqrt(a1^2)", "a1"), make_comparison("sqrt(a1^2 + a2 - a1*a2/a1)", "a1")
    for comparison in (short, long):
        steps = sum(len(program.steps) for program in comparison.programs)
        assert 1000 / 2 - steps < comparison.remaining_evaluations * steps <= 1000
    assert long.remaining_evaluations < short.remaining_evaluations


def test_long_answers_with_branches_get_fewer_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(equality, "_MAX_VALUES", 600)
    steps = len(compile_program([parse_formula("sqrt(a1^2)")]).steps)
    assert compare("sqrt(a1^2)", "a1").certificate.points == 600 // steps
    monkeypatch.setattr(equality, "_MAX_VALUES", 10)
    assert compare("sqrt(a1^2)", "a1").certificate.points == equality.POINT_COUNT


def test_only_clear_verdicts_remain_without_precise_evaluations(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(equality, "_MAX_PRECISE_STEPS", 0)
    assert compare("sqrt(a1^2)", "a1").is_correct == (False,)
    assert compare("1.001*sqrt(a1^2)", "a1", Rounding(0.005)).is_correct == (True,)  # doubles suffice
    assert compare("0*sqrt(a1)", "0").is_correct == (True,)
    assert compare("sqrt(sin(theta1)^2)", "sin(theta1)", Rounding(0.005)).is_correct == (False,)
    shown = find_counterexample("sqrt(a1^2)*2", "a1")
    assert shown.yours == pytest.approx(2 * shown.at["a1"])
    assert shown.expected == pytest.approx(shown.at["a1"])


def test_fifty_digits_suffice_if_they_show_a_difference() -> None:
    comparison = make_comparison("sqrt(a1^2)*(1 + 10^-20)", "a1")
    comparison.remaining_evaluations = 1
    assert comparison._agrees_precisely(0, 12) is False
    assert comparison._agrees_precisely(0, 13) is None


def test_clear_difference_is_shown_at_a_readable_point() -> None:
    comparison = find_counterexample("sqrt(a1^2) + a1*sin(theta1)", "a1")
    assert is_readable(comparison.at)
    at = comparison.at
    assert comparison.yours == pytest.approx(at["a1"] * (1 + np.sin(at["theta1"])), rel=1e-5)
    assert comparison.expected == at["a1"]


@pytest.mark.parametrize("part", ["1", "10^-13"])
def test_counterexample_lies_where_the_answers_differ(part: str) -> None:
    """They differ for a1 > 10 only, by an amount that doubles can or cannot show."""
    comparison = find_counterexample(f"sqrt(a1^2) + {part}*(abs(a1 - 10) - (10 - a1))", "a1")
    assert comparison.at["a1"] > 10
    assert comparison.yours != comparison.expected
    yours, expected = (mpmath.mpf(value) for value in (comparison.yours, comparison.expected))
    excess = 2 * (comparison.at["a1"] - 10) * (1 if part == "1" else 1e-13)
    assert float(yours - expected) == pytest.approx(excess, rel=0.1, abs=0)


def test_undefined_answer_is_shown_as_undefined() -> None:
    for student in ("a1/(a2 - a2)", "sqrt(a1^2)/(a2 - a2)"):
        comparison = find_counterexample(student, "a1")
        assert is_readable(comparison.at)
        assert comparison.yours == "undefined or too large"
        assert comparison.expected == comparison.at["a1"]


@pytest.mark.parametrize("power", [12, 30])
@pytest.mark.parametrize("student", ["a1", "sqrt(a1^2)"])
def test_tiny_difference_is_shown_with_enough_digits(student: str, power: int) -> None:
    comparison = find_counterexample(f"{student}*(10^{power} + 1)/10^{power}", "a1")
    assert is_readable(comparison.at)
    assert float(comparison.expected or 0) == pytest.approx(comparison.at["a1"], rel=1e-9)
    with mpmath.workdps(60):
        part = mpmath.mpf(comparison.yours) / mpmath.mpf(comparison.expected) - 1
        assert float(part) == pytest.approx(10.0**-power, rel=0.2, abs=0)


def test_difference_too_small_to_show_comes_with_its_values(monkeypatch: pytest.MonkeyPatch) -> None:
    """The point is readable if doubles see the difference only elsewhere, or if no precise evaluations remain."""
    assert is_readable(find_counterexample("(10^14*a1 + a1^9)/10^14", "a1").at)  # at most 1e-12 of a1 there
    tiny = find_counterexample("(2^1000*a1 + theta1)/2^1000", "a1")
    monkeypatch.setattr(equality, "_MAX_PRECISE_STEPS", 0)
    for shown in (tiny, find_counterexample("a1*(2^100 + 1)/2^100", "a1")):
        assert shown.yours == shown.expected == shown.at["a1"]


def test_values_are_shown_with_enough_digits_to_differ() -> None:
    def show(off: str) -> tuple[Any, Any]:
        with mpmath.workdps(60):
            return equality.format_difference(mpmath.pi + mpmath.mpf(off), +mpmath.pi)

    assert show("1e-3") == (3.14259, 3.14159)
    assert show("1e-7") == ("3.1415928", "3.1415927")
    assert show("1e-8") == ("3.141592664", "3.141592654")
    assert show("1e-30")[0] != show("1e-30")[1]
    assert show("1e-55") == (3.14159, 3.14159)
    assert equality.format_difference(complex(np.nan), 0.5) == ("undefined or too large", 0.5)


def test_numbers_are_shown_with_six_digits() -> None:
    assert to_json_number(0j) == 0.0
    assert to_json_number(-1234.5678 + 0j) == -1234.57
    assert to_json_number(1.5 + 2.25j) == "1.5 + 2.25i"
    assert [to_json_number(value) for value in (1.5 - 2j, 2j, -2j)] == ["1.5 - 2i", "2i", "-2i"]
    for complex_, real in ((1 + 1.5e-9j, False), (1 - 1.5e-9j, False), (1 + 7e-10j, True), (1e6 - 1e-6j, True)):
        assert isinstance(to_json_number(complex_), float) is real
    for undefined in (np.nan, np.inf, complex(0, -np.inf)):
        assert to_json_number(complex(undefined)) == "undefined or too large"


def test_numeric_certificate_states_points_and_bound() -> None:
    for student, reference, points, bound in (
        ("sqrt(a1^2)", "a1", 2000, 0.98**2000), ("a1*(1 + sin(1) - sin(1))", "a1", 50, 0.5**50),
        ("sqrt(a1^2)*2", "a1", 2000, 0.98**2000),
    ):  # fmt: skip
        comparison = compare(student, reference).certificate
        assert (comparison.method, comparison.points) == ("numeric", points)
        assert comparison.bound == pytest.approx(bound, rel=1e-6, abs=0)


def test_certificate_is_that_of_the_most_demanding_entry() -> None:
    mixed, high = compare(["a1", "sqrt(a2^2)"], ["a1", "a2"]), ["a1", "(((a1 + a2)^900)^900)^400"]
    assert mixed.is_correct == (True, True)
    assert (mixed.certificate.method, mixed.certificate.points) == ("numeric", 2000)
    certificate = compare(high, high).certificate
    assert (certificate.method, certificate.points) == ("exact", 2)


def test_default_role_follows_from_the_name() -> None:
    names = {"angle": "theta1 theta", "length": "a1 d12 L2 l3", "signed": "a d ab1 q1 qd2 k"}
    for role, texts in names.items():
        assert [choose_default_role(name) for name in texts.split()] == [role] * len(texts.split())
