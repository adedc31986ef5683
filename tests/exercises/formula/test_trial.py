"""How a comparison in numbers decides: what doubles tell, which points want many digits, and what is shown."""

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
    chance_of_missing,
    choose_default_role,
    compare_entries,
    to_json_number,
)
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program
from qdot.exercises.formula.trees import find_names

ZERO = "sin(theta1 + theta2) - sin(theta1)*cos(theta2) - cos(theta1)*sin(theta2)"
HUGE = f"10^30*({ZERO})"
"""Nothing, of terms so large that 50 digits leave 1e-20 of it."""


def trial(
    student: str | list[str], reference: str | list[str], points: int = 200,
    allowed: tuple[float, float] = (0.0, 0.0), **values: list[float],
) -> Any:  # fmt: skip
    """Two answers at the same points, which are random where no values are given."""
    theirs, ours = (
        [parse_formula(text) for text in ([one] if isinstance(one, str) else one)] for one in (student, reference)
    )
    used = set().union(*(find_names(node) for node in theirs + ours))
    points = len(next(iter(values.values()))) if values else points
    at = Domain({name: choose_default_role(name) for name in used}).sample(used, points, Stream("trial"))
    at |= {name: np.array(column) for name, column in values.items()}
    programs = compile_program(theirs), compile_program(ours)
    return equality._NumericComparison(programs, [allowed] * len(theirs), at, {}, points)


def compared(student: str | list[str], reference: str | list[str], rounding: Rounding | None = None) -> Comparison:
    theirs, ours = (
        [parse_formula(text) for text in ([one] if isinstance(one, str) else one)] for one in (student, reference)
    )
    used = set().union(*(find_names(node) for node in theirs + ours))
    return compare_entries(theirs, ours, Domain({name: choose_default_role(name) for name in used}), "seed", rounding)


def example(student: str, reference: str) -> EntryDifference:
    found = compared(student, reference)
    assert found.is_correct == (False,)
    assert isinstance(found.certificate.counterexample, EntryDifference)
    return found.certificate.counterexample


def is_readable(at: Mapping[str, float]) -> bool:
    return all(round(value, 2) == value for value in at.values())


@pytest.mark.parametrize("unit", ["1e-6", "1", "1e6"])
def test_a_difference_is_clear_from_a_part_of_the_terms_on(unit: str) -> None:
    for part, clear in (("101*10^-11", True), ("99*10^-11", False)):
        found = trial(f"{unit}*a1*(1 + {part})", f"{unit}*a1")._is_clearly_different(0)
        assert found.all() if clear else not found.any()


def test_what_is_allowed_is_not_clear_and_what_is_off_by_less_is_settled() -> None:
    for factor, clear in (("1.004", False), ("1.006", True)):
        found = trial(f"{factor}*a1", "a1", allowed=(0.005, 0.0))
        assert (found._is_clearly_different(0) == clear).all()
        assert (found._is_clearly_allowed(0) != clear).all()


def test_rounding_is_counted_of_both_sides() -> None:
    """Two sums of large terms that cancel, each in its own way: what they differ by is no difference."""
    found = trial("a1 + 10^9*(sin(theta1)^2 + cos(theta1)^2 - 1)", "a1 + 10^9*(1 - sin(theta1)^2 - cos(theta1)^2)")
    assert found.difference.max() > 1e-8
    assert (found.difference <= found.rounding_error).all()
    assert not found._is_clearly_different(0).any()


def test_what_may_be_rounding_is_not_settled() -> None:
    found = trial(f"a1 + {HUGE}", "a1", allowed=(0.0, 0.01))
    assert not found._is_clearly_allowed(0).any()


def test_no_rounding_is_left_where_nothing_is_added() -> None:
    found = trial("0*sqrt(a1)", "0")
    assert found._is_clearly_allowed(0).all()
    assert found._points_to_check(0) == []


def test_scales_are_those_of_the_terms_and_of_the_largest_entry_for_a_zero() -> None:
    sizes = [[0.2, 0, 0, 0, np.nan, 0.5], [0.3, 0.5, 0, np.nan, 0.25, np.inf], [4.0, 0.25, 0, 2, 0.5, 0]]
    scales = [[0.2, 0.5, 1, 1, 1, 0.5], [0.3, 0.5, 1, 1, 0.25, 1], [4.0, 0.25, 1, 2, 0.5, 1]]
    assert equality._compute_term_scales(np.array(sizes)).tolist() == scales


SIGNS = [f"sqrt((theta{k} - 1)^2)" for k in range(1, 6)]


def test_one_point_of_a_region_is_looked_at_and_the_three_that_are_off_most() -> None:
    text = " + ".join(f"abs(theta{k})" for k in range(1, 6))
    found = trial(text, text, 2000)
    assert len(set(found.region_numbers)) == 32
    found.difference[0] = found.rounding_error[0] * np.linspace(1.0, 0.5, 2000)
    worst = [1998, 1993, 1995]
    found.difference[0, worst] = found.rounding_error[0, worst] * [5, 4, 3]
    looked = found._points_to_check(0)
    firsts = {region: list(found.region_numbers).index(region) for region in set(found.region_numbers)}
    assert looked[:16] == sorted(firsts.values())[:16]
    assert sorted(looked[16:]) == sorted(worst)


def test_points_are_off_most_by_what_is_not_allowed_for_their_rounding() -> None:
    found = trial("sqrt(a1^2)", "a1", 20)
    found.difference[0], found.allowed_error[0], found.rounding_error[0] = 10.0, 0.0, 10.0
    rows = {11: (20, 0, 2), 12: (2, 0, 0.1), 13: (30, 10, 1.5), 14: (40, 39, 3), 15: (100, 0, 50)}
    for point, (off, room, noise) in rows.items():
        found.difference[0, point], found.allowed_error[0, point], found.rounding_error[0, point] = off, room, noise
    assert found._points_to_check(0)[0] == 0  # of the only region
    assert sorted(found._points_to_check(0)[1:]) == [11, 12, 13]


def test_a_readable_point_may_be_a_removable_singularity_and_no_other() -> None:
    text = "sqrt(a1^2)*(a1 - 1)/(a1 - 1)"
    at = [0.5, 1.5, 2.5, 0.25, 3.0, 4.0, 0.75, 0.3, 0.6, 0.7, 0.8, 0.9]
    for where, due in (([], True), ([0], True), ([3, 7], True), ([8], False), ([11], False)):
        found = trial(text, "a1", a1=[1.0 if k in where else value for k, value in enumerate(at)])
        assert found.is_equal(0) is due, where


def test_the_bound_counts_the_points_where_every_entry_has_a_value() -> None:
    texts = ["a1", "1/(abs(x) + x)"]
    found = trial(texts, texts, 2000)
    assert 900 < found.defined_count < 1100
    certificate = compared(texts, texts).certificate
    assert certificate.points == 2000
    assert certificate.bound is not None
    assert chance_of_missing(1100, 0.02) < certificate.bound < chance_of_missing(900, 0.02)


TERMS = f"(sqrt(a1^2)*(10^400/10^400) + 1e14*({ZERO}))*1e9"
"""Terms that no double holds, 1e14 times as large as what is left of them: 1e-36 with 50 digits, so that 200 decide."""
PARTLY = "1/(abs(x) + x)"
DECIDED = [
    # to 40 digits of the terms
    *((f"{unit}*sqrt(a1^2)*(10^41 + {part})/10^41", f"{unit}*a1", part < 10)
      for unit in ("1e-20", "1", "1e20") for part in (9, 11)),
    (f"sqrt(a1^2) + {HUGE}", "a1", True), (f"sqrt(a1^2)*(10^30 + 1)/10^30 + {HUGE}", "a1", False),
    *((f"{sign}{TERMS}*(10^30 + {off})/10^30", f"{sign}1e9*a1", off == 0) for sign in ("", "-") for off in (0, 1)),
    # defined with more digits only: of nothing with 50 digits, of -1e-16 with a double's
    ("log((3 + 3*10^-60)/3 - 1)", "log(10^-60)", True), ("log(1/49*(49 + 49*10^-60) - 1)", "log(10^-60)", True),
    ("sqrt(a1^2)/((3*10^60 + 3)/(3*10^60) - 1)", "10^60*a1", True),
    (PARTLY, PARTLY, True), (f"(10^30 + 1)/10^30*{PARTLY}", PARTLY, False),  # compared where the reference is defined
]  # fmt: skip


@pytest.mark.parametrize(("student", "reference", "due"), DECIDED)
def test_as_many_digits_are_taken_as_decide(student: str, reference: str, due: bool) -> None:
    assert compared(student, reference).is_correct == (due,)


def test_a_part_may_be_off_where_the_reference_is_defined() -> None:
    assert compared(f"1.001*{PARTLY}", PARTLY, Rounding(0.005)).is_correct == (True,)
    assert compared(f"1.01*{PARTLY}", PARTLY, Rounding(0.005)).is_correct == (False,)


def test_so_many_evaluations_and_no_more() -> None:
    found = trial("sqrt(a1^2)", "a1")
    found.remaining_evaluations = 3
    assert [found._evaluate_precisely(point, 50) is None for point in range(5)] == [False, False, False, True, True]
    assert found._evaluate_precisely(1, 50) is not None  # known already


def test_long_answers_are_evaluated_less_often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(equality, "_MAX_PRECISE_STEPS", 1000)
    short, long = trial("sqrt(a1^2)", "a1"), trial("sqrt(a1^2 + a2 - a1*a2/a1)", "a1")
    for found in (short, long):
        steps = sum(len(program.steps) for program in found.programs)
        assert 1000 / 2 - steps < found.remaining_evaluations * steps <= 1000
    assert long.remaining_evaluations < short.remaining_evaluations


def test_long_answers_with_branches_are_tried_at_fewer_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(equality, "_MAX_VALUES", 600)
    steps = len(compile_program([parse_formula("sqrt(a1^2)")]).steps)
    assert compared("sqrt(a1^2)", "a1").certificate.points == 600 // steps
    monkeypatch.setattr(equality, "_MAX_VALUES", 10)
    assert compared("sqrt(a1^2)", "a1").certificate.points == equality.POINT_COUNT


def test_without_effort_clear_differences_count_and_nothing_else_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(equality, "_MAX_PRECISE_STEPS", 0)
    assert compared("sqrt(a1^2)", "a1").is_correct == (False,)
    assert compared("1.001*sqrt(a1^2)", "a1", Rounding(0.005)).is_correct == (True,)  # doubles are enough for that
    assert compared("0*sqrt(a1)", "0").is_correct == (True,)
    assert compared("sqrt(sin(theta1)^2)", "sin(theta1)", Rounding(0.005)).is_correct == (False,)
    shown = example("sqrt(a1^2)*2", "a1")
    assert shown.yours == pytest.approx(2 * shown.at["a1"])
    assert shown.expected == pytest.approx(shown.at["a1"])


def test_a_difference_that_50_digits_show_takes_no_more() -> None:
    found = trial("sqrt(a1^2)*(1 + 10^-20)", "a1")
    found.remaining_evaluations = 1
    assert found._agrees_precisely(0, 12) is False
    assert found._agrees_precisely(0, 13) is None


def test_a_clear_difference_is_shown_at_a_readable_point() -> None:
    found = example("sqrt(a1^2) + a1*sin(theta1)", "a1")
    assert is_readable(found.at)
    at = found.at
    assert found.yours == pytest.approx(at["a1"] * (1 + np.sin(at["theta1"])), rel=1e-5)
    assert found.expected == at["a1"]


@pytest.mark.parametrize("part", ["1", "10^-13"])
def test_a_difference_is_shown_where_there_is_one(part: str) -> None:
    """For long a1 only, and by so much that doubles tell, or by so little that they don't."""
    found = example(f"sqrt(a1^2) + {part}*(abs(a1 - 10) - (10 - a1))", "a1")
    assert found.at["a1"] > 10
    assert found.yours != found.expected
    yours, expected = (mpmath.mpf(value) for value in (found.yours, found.expected))
    excess = 2 * (found.at["a1"] - 10) * (1 if part == "1" else 1e-13)
    assert float(yours - expected) == pytest.approx(excess, rel=0.1, abs=0)


def test_an_answer_without_a_value_is_shown_as_one() -> None:
    for student in ("a1/(a2 - a2)", "sqrt(a1^2)/(a2 - a2)"):
        found = example(student, "a1")
        assert is_readable(found.at)
        assert found.yours == "not a finite number"
        assert found.expected == found.at["a1"]


@pytest.mark.parametrize("power", [12, 30])
@pytest.mark.parametrize("student", ["a1", "sqrt(a1^2)"])
def test_a_tiny_difference_is_shown_with_enough_digits(student: str, power: int) -> None:
    found = example(f"{student}*(10^{power} + 1)/10^{power}", "a1")
    assert is_readable(found.at)
    assert float(found.expected or 0) == pytest.approx(found.at["a1"], rel=1e-9)
    with mpmath.workdps(60):
        part = mpmath.mpf(found.yours) / mpmath.mpf(found.expected) - 1
        assert float(part) == pytest.approx(10.0**-power, rel=0.2, abs=0)


def test_a_difference_too_small_to_show_comes_with_the_values_of_its_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """A readable one, if doubles do not tell there but elsewhere; so has one for which effort is used up."""
    assert is_readable(example("(10^14*a1 + a1^9)/10^14", "a1").at)  # at most 1e-12 of a1 there
    tiny = example("(2^1000*a1 + theta1)/2^1000", "a1")
    monkeypatch.setattr(equality, "_MAX_PRECISE_STEPS", 0)
    for shown in (tiny, example("a1*(2^100 + 1)/2^100", "a1")):
        assert shown.yours == shown.expected == shown.at["a1"]


def test_two_values_are_shown_with_as_many_digits_as_it_takes() -> None:
    def shown(off: str) -> tuple[Any, Any]:
        with mpmath.workdps(60):
            return equality.show_difference(mpmath.pi + mpmath.mpf(off), +mpmath.pi)

    assert shown("1e-3") == (3.14259, 3.14159)
    assert shown("1e-7") == ("3.1415928", "3.1415927")
    assert shown("1e-8") == ("3.141592664", "3.141592654")
    assert shown("1e-30")[0] != shown("1e-30")[1]
    assert shown("1e-55") == (3.14159, 3.14159)
    assert equality.show_difference(complex(np.nan), 0.5) == ("not a finite number", 0.5)


def test_numbers_are_shown_with_six_digits_or_in_words() -> None:
    assert to_json_number(0j) == 0.0
    assert to_json_number(-1234.5678 + 0j) == -1234.57
    assert to_json_number(1.5 + 2.25j) == "1.5 + 2.25i"
    for complex_, real in ((1 + 1.5e-9j, False), (1 - 1.5e-9j, False), (1 + 7e-10j, True), (1e6 - 1e-6j, True)):
        assert isinstance(to_json_number(complex_), float) is real
    for undefined in (np.nan, np.inf, complex(0, -np.inf)):
        assert to_json_number(complex(undefined)) == "not a finite number"


def test_how_many_points_are_tried_and_what_the_bound_is() -> None:
    for student, reference, points, bound in (
        ("sqrt(a1^2)", "a1", 2000, 0.98**2000), ("a1*(1 + sin(1) - sin(1))", "a1", 50, 0.5**50),
        ("sqrt(a1^2)*2", "a1", 2000, 0.98**2000),
    ):  # fmt: skip
        found = compared(student, reference).certificate
        assert (found.method, found.points) == ("numeric", points)
        assert found.bound == pytest.approx(bound, rel=1e-6, abs=0)


def test_a_comparison_has_the_method_and_the_points_of_the_entry_that_wants_most() -> None:
    mixed, high = compared(["a1", "sqrt(a2^2)"], ["a1", "a2"]), ["a1", "(((a1 + a2)^900)^900)^400"]
    assert mixed.is_correct == (True, True)
    assert (mixed.certificate.method, mixed.certificate.points) == ("numeric", 2000)
    certificate = compared(high, high).certificate
    assert (certificate.method, certificate.points) == ("exact", 2)


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("theta1", "angle"), ("theta", "angle"), ("a1", "length"), ("d12", "length"), ("L2", "length"),
        ("l3", "length"), ("a", "signed"), ("d", "signed"), ("ab1", "signed"),
        ("q1", "signed"), ("qd2", "signed"), ("k", "signed"),
    ],
)  # fmt: skip
def test_roles_by_name(name: str, role: str) -> None:
    assert choose_default_role(name) == role
