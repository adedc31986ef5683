"""Comparing formulas: the verdicts of tests/data/corpus.jsonl, and answers that fool simpler checkers."""

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import equality
from qdot.exercises.formula.equality import (
    READABLE_POINTS,
    Comparison,
    Domain,
    EntryDifference,
    Rounding,
    choose_decimal_tolerance,
    choose_default_role,
    compare_entries,
    compute_chance_of_missing,
)
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import find_names
from qdot.grader.judging.compare_command import compare_line
from tests.support import DATA, read_cases
from tests.support.suites import select_for_suite

CASES = [json.loads(line) for line in (DATA / "corpus.jsonl").read_text(encoding="utf-8").splitlines()]


def compare(student: str, reference: str, seed: str = "seed") -> Comparison:
    ours, theirs = parse_formula(reference), parse_formula(student)
    used = find_names(ours) | find_names(theirs)
    return compare_entries([theirs], [ours], Domain({name: choose_default_role(name) for name in used}), seed)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case['id']}-{case['tag']}")
def test_verdicts_of_the_corpus_are_reproduced(case: dict[str, Any]) -> None:
    judged = compare_line(json.dumps(case), 1)
    assert (judged["outcome"] == "correct") == case["correct"], judged
    assert ((judged["certificate"] or {}).get("bound") or 0) < 1e-15
    assert judged["outcome"] != "ungraded"


NOISY = (
    "a1*cos(theta1) - 6.12323399573677e-17*a2*sin(theta1)", "a1*cos(theta1) - 6.123233995736766e-17*a2*sin(theta1)",
    "a1*cos(theta1) - 612323399573677*a2*sin(theta1)/10**31", "a1*cos(theta1) + a2*a3*a4*1.2E-16*cos(theta2)/3",
    "a1*cos(theta1 + 6e-17)", "(1 + 1e-16*a2)*a1*cos(theta1)", "1e-17*a2 + a1*cos(theta1)*1e-17/1e-17",
    "a1*cos(theta1)*(1 - 1e-16) - (6e-9)**2*a2", "\\cos{\\left(\\theta_1\\right)} a_1 - 6.1 \\cdot 10^{-17} a_2",
)  # fmt: skip


@pytest.mark.parametrize("text", NOISY)
def test_floating_point_remainder_of_zero_is_ignored(text: str) -> None:
    assert compare(text, "a1*cos(theta1)").is_correct == (True,)


@pytest.mark.parametrize(
    "text",
    ["a1*cos(theta1) + 1e-9*a2", "a1*cos(theta1) + a2/10**9", "a1*cos(theta1) - 1e-17*a2/1e-17", "1e-17*a1*cos(theta1)",
     "a1*cos(theta1) + (1e-17)**0*a2", "a1*cos(theta1)/1e-17", "a1*cos(theta1) + (10^17*a2 + 10^17)/10^17",
     "a1*cos(theta1) + sqrt(10^34)*a2*1e-17", "a1*cos(theta1) + (10^13 + 9)/10^13*a2"],
)  # fmt: skip
def test_small_term_is_significant(text: str) -> None:
    assert compare(text, "a1*cos(theta1)").is_correct == (False,)


def test_entry_that_is_only_rounding_noise_is_zero() -> None:
    assert compare("6.12323399573677e-17*a2*cos(theta1)", "0").is_correct == (True,)


def test_reference_may_be_a_long_sum() -> None:
    request = {"type": "matrix", "reference": f"[[{'a1+' * 2000}a1, 0]]", "student": "[[2001*a1, 0]]"}
    assert compare_line(json.dumps(request), 1)["outcome"] == "correct"


@pytest.mark.parametrize("line", ["", "[" * 100_000, '{"type": ' * 100_000, "9" * 5000], ids=lambda line: line[:9])
def test_invalid_json_line_is_reported(line: str) -> None:
    with pytest.raises(QdotError, match="line 7 is not JSON"):
        compare_line(line, 7)


@pytest.mark.parametrize(("inner", "share"), [("sin(theta2)", 0.5), ("sin(theta2/2 + 3/4*pi)", 0.25)])
def test_numeric_comparison_errs_at_the_rate_of_its_bound(
    inner: str, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With three points, an answer that is wrong on a share of the circle passes at the rate of the bound."""
    for constant in ("POINT_COUNT", "POINT_COUNT_BRANCHING"):
        monkeypatch.setattr(equality, constant, 3)
    comparison = [compare(f"sqrt(({inner})^2)", inner, str(seed)) for seed in range(400)]
    passed = [comparison for comparison in comparison if comparison.is_correct == (True,)]
    assert len(passed) / len(comparison) == pytest.approx(compute_chance_of_missing(3, share), abs=0.07)
    bound = compute_chance_of_missing(3, equality.WRONG_SHARE_BRANCHING)
    assert all(comparison.certificate.bound == bound for comparison in passed)


@pytest.mark.parametrize("seed", ["one", "two", "three"])
def test_equal_functions_are_right_and_partly_equal_ones_are_wrong(seed: str) -> None:
    for expected, pairs in ((True, read_cases("equal")["right"]), (False, read_cases("equal")["wrong_in_places"])):
        for student, reference in pairs:
            assert compare(student, reference, seed).is_correct == (expected,), student


def test_counterexample_has_readable_values() -> None:
    certificate = compare("a1*cos(theta1)", "a1*sin(theta1)").certificate
    comparison = certificate.counterexample
    assert isinstance(comparison, EntryDifference)
    assert comparison.entry == 0
    assert set(comparison.at) == {"a1", "theta1"}
    assert all(round(number, 2) == number for number in comparison.at.values())
    assert comparison.yours != comparison.expected
    assert (certificate.method, certificate.bound) == ("exact", 0.0)


def test_each_entry_is_judged_by_itself() -> None:
    """Two entries are compared in numbers, because of their roots, and two exactly."""
    typed, due = ["sqrt(a1*a2)", "a2", "sqrt(a1 + 2)", "a1"], ["sqrt(a1)*sqrt(a2)", "a2", "sqrt(a1 + 1)", "a2"]
    student, reference = ([parse_formula(text) for text in texts] for texts in (typed, due))
    comparison = compare_entries(student, reference, Domain({"a1": "length", "a2": "length"}), "seed")
    assert comparison.is_correct == (True, True, False, False)
    assert isinstance(comparison.certificate.counterexample, EntryDifference)
    assert comparison.certificate.counterexample.entry == 2


def test_long_cancelling_answer_does_not_stall_the_comparison() -> None:
    """A long answer with branches whose terms nearly cancel would need many digits at every point."""
    trigs = "".join(
        f"{sign}1e9*cos({k}*theta1)*sqrt(a1)" for sign in ("+", "-1.0*") for k in range(2, select_for_suite(1500, 4000))
    )
    compare("a1*cos(theta1)" + trigs, "a1*cos(theta1)")


def test_points_cover_the_range_of_each_symbol() -> None:
    domain = Domain({"theta1": "angle", "a1": "length", "d2": "signed", "a2": 0.35})
    samples = domain.sample({"theta1", "a1", "d2", "a2", "x"}, 4000, Stream("points"))
    others = {name: values[READABLE_POINTS:] for name, values in samples.items()}
    low_high = {name: (values.min(), values.max()) for name, values in others.items()}
    assert low_high["theta1"] == pytest.approx((-np.pi, np.pi), abs=0.02)
    assert low_high["a1"] == (pytest.approx(0.05, rel=0.02), pytest.approx(40, rel=0.02))
    assert np.median(samples["a1"]) == pytest.approx((0.05 * 40) ** 0.5, rel=0.2)
    assert low_high["a2"] == (0.35, 0.35)
    for name in ("d2", "x"):  # an unknown name is a signed number
        assert low_high[name] == pytest.approx((-2, 2), abs=0.02)
        assert np.abs(samples[name]).min() == pytest.approx(0.2, abs=0.02)
        assert np.mean(samples[name] > 0) == pytest.approx(0.5, abs=0.05)
    for name in ("theta1", "a1", "d2"):
        assert all(round(value, 2) == value for value in samples[name][:READABLE_POINTS])
    lengths = [Domain({"a1": "length"}).sample({"a1"}, 20, Stream(str(k)))["a1"][:READABLE_POINTS] for k in range(200)]
    assert (np.min(lengths), np.max(lengths)) == (pytest.approx(0.2, abs=0.011), pytest.approx(1.5, abs=0.011))
    assert not all(round(value, 2) == value for value in samples["a1"][READABLE_POINTS : READABLE_POINTS + 5])


def test_given_numbers_are_fractions_if_possible() -> None:
    domain = Domain({"a1": Fraction(1, 3), "a2": 0.35, "a3": 2**0.5, "a4": "length", "d1": -0.25})
    fixed_values = {"a1": Fraction(1, 3), "a2": Fraction(7, 20), "a3": None, "d1": Fraction(-1, 4)}
    assert domain.list_fixed_values() == fixed_values


@pytest.mark.parametrize(("text", "allowed"), read_cases("equal")["decimals"])
def test_only_decimals_with_the_digits_of_a_double_may_be_off(text: str, allowed: float) -> None:
    assert choose_decimal_tolerance(parse_formula(text)) == allowed


@pytest.mark.parametrize("length", [Fraction(1, 3), 0.375])
def test_given_fraction_is_compared_exactly_and_root_as_double(length: float | Fraction) -> None:
    def is_right(student: str, **roles: float | Fraction) -> bool:
        domain = Domain({"theta1": "angle", **roles})
        return compare_entries([parse_formula(student)], [parse_formula("a1*cos(theta1)")], domain, "s").is_correct[0]

    assert is_right("a1*cos(theta1)", a1=length)
    assert not is_right("a1*cos(theta1)*(10^13 + 1)/10^13", a1=length)
    # A double that the answer does not use.
    assert not is_right("a1*cos(theta1)*(10^13 + 1)/10^13", a1=length, a2=2**0.5)
    assert is_right("a1*cos(theta1)*(10^13 + 1)/10^13", a1=2**0.5)
    assert not is_right("a1*cos(theta1)*(1 + 10^-11)", a1=2**0.5)


@pytest.mark.parametrize(
    ("rounding", "off", "expected"),
    [
        (Rounding(0.005), "1.004", True), (Rounding(0.005), "1.006", False), (None, "1.004", False),
        (Rounding(0.0, 0.01), "1 + 0.009/a1", True),
        (Rounding(0.0, 0.01), "1 + 0.011/a1", False),
    ],
)  # fmt: skip
def test_assignment_may_allow_relative_or_absolute_rounding(
    rounding: Rounding | None, off: str, expected: bool
) -> None:
    student, reference = parse_formula(f"a1*({off})"), parse_formula("a1")
    comparison = compare_entries([student], [reference], Domain({"a1": "length"}), "seed", rounding)
    assert comparison.is_correct == (expected,)


def test_bound_is_that_of_the_worst_entry() -> None:
    texts = ["a1", "(a1 + a2)^900", "a2"]
    right, a2, a3 = [parse_formula(text) for text in texts], parse_formula("a2"), parse_formula("a3")
    comparison = compare_entries(right, right, Domain({}), "seed")
    alone = [compare(text, text).certificate.bound or 0.0 for text in texts]
    assert comparison.certificate.bound == max(alone) > 2 * min(alone)
    wrong = compare_entries([*right, a3], [*right, a2], Domain({}), "seed")
    assert (wrong.is_correct, wrong.certificate.bound) == ((True, True, True, False), max(alone))
