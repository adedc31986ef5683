"""Judging single answers: right in any form, wrong in the usual ways, hostile, empty. See test_forms.py, too.

A case in tests/data/judgements.jsonl has the expected outcome, share or reason, in which * stands for any text.
"""

import json
from fnmatch import fnmatchcase
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

from qdot.exercises.formula.equality import (
    Certificate,
    Domain,
    EntryDifference,
    Rounding,
    SetDifference,
    compute_chance_of_missing,
)
from qdot.grader.diagnosis.advice import _name_entry
from qdot.grader.judging.answer_parser import OR_HINT, replace_decimal_commas
from qdot.grader.judging.verdict import Judgement, Outcome
from qdot.grader.reports.feedback_levels import remove_numbers
from tests.support import DATA, read_cases
from tests.support.judging import (
    judge_angles,
    judge_choice,
    judge_direction,
    judge_expression,
    judge_matrix,
    judge_numbers,
    judge_selection,
    judge_singular,
)
from tests.support.suites import sample_for_suite

JOINTS = ["theta1", "theta2", "theta3"]
LENGTHS, RATES = dict.fromkeys(("a1", "a2", "a3", "d1"), "length"), dict.fromkeys(("qd1", "qd2"), "signed")
DOMAIN = Domain({**dict.fromkeys(JOINTS, "angle"), **LENGTHS, **RATES, "L": 0.35})
CORRECT, PARTIAL, WRONG, MISSING = Outcome.CORRECT, Outcome.PARTIAL, Outcome.WRONG, Outcome.MISSING
GIVEN_LENGTHS = Domain(
    {"theta1": "angle", "theta2": "angle", "a1": 0.3, "a2": Fraction(1, 2), "a3": Fraction(1, 3), "d1": 0.5**0.5}
)
"""Lengths with given values."""
CASES = [json.loads(line) for line in (DATA / "judgements.jsonl").read_text(encoding="utf-8").splitlines()]


def judge_rates(student: str, *reference: float, labels: tuple[str, ...] = ()) -> Judgement:
    return judge_numbers(student, reference, ["rad/s"] * len(reference), 0.005, 0.001, labels)


def judge_set(student: str, *reference: str, rounding: Rounding | None = None) -> Judgement:
    return judge_singular(student, reference, JOINTS, DOMAIN, "s", rounding)


def judge_case(case: dict[str, Any]) -> Judgement:
    student, reference, labels = case["student"], case["reference"], tuple(case.get("labels", ()))
    match case["type"]:
        case "expression":
            return judge_expression(student, reference, DOMAIN, "s")
        case "matrix":
            return judge_matrix(student, reference, DOMAIN, "s", labels)
        case "numbers":
            return judge_rates(student, *reference, labels=labels)
    return judge_set(student, *reference)


@pytest.mark.parametrize("case", sample_for_suite(CASES, 160), ids=lambda case: case["student"][:30])
def test_a_checked_answer_gets_its_outcome_share_and_reason(case: dict[str, Any]) -> None:
    judgement = judge_case(case)
    if outcome := case.get("outcome"):
        is_expected = judgement.outcome is not CORRECT if outcome == "not correct" else judgement.outcome == outcome
        assert is_expected, judgement
    assert judgement.share == pytest.approx(case.get("share", judgement.share)), judgement
    if reason := case.get("reason"):
        assert fnmatchcase(judgement.reason, reason), judgement.reason
        assert ("degrees" in judgement.reason) is ("degrees" in reason)


# --- formulas ---


@pytest.mark.parametrize("text", ["(" * 5000, "sin(" * 2000, "\x00", "\ud800"])
def test_a_hostile_expression_is_wrong(text: str) -> None:
    assert judge_expression(text, "a1", DOMAIN, "s").outcome is WRONG


def test_a_rejection_has_a_counterexample_or_names_unknown_symbols() -> None:
    judged = judge_expression("a1*cos(theta1)", "a1*cos(theta1) + a2*cos(theta1 + theta2)", DOMAIN, "seed")
    assert judged.certificate is not None and isinstance(judged.certificate.counterexample, EntryDifference)
    assert set(judged.certificate.counterexample.at) == {"a1", "a2", "theta1", "theta2"}
    assert "yours" in judged.reason and "expected" in judged.reason
    unknown = judge_expression("k*a1", "a1", DOMAIN, "s").reason
    assert unknown.startswith("'k'") and "L, a1," in unknown
    assert "list" in judge_expression("a1, a2", "a1", DOMAIN, "s").reason


def test_a_named_given_length_is_exact() -> None:
    for reference, right, wrong in (
        ("3/10*cos(theta1)", ("a1*cos(theta1)", "sqrt(a1^2)*cos(theta1)"), ()),
        ("cos(theta1)/3", ("a3*cos(theta1)", "sqrt(a3)^2*cos(theta1)", "0.3333333333333333*cos(theta1)"),
         ("0.3333*cos(theta1)", "a1*cos(theta1)")),
        ("sqrt(2)/2*cos(theta1)", ("d1*cos(theta1)", "sqrt(d1^2)*cos(theta1)"), ()),
        ("0.3333*cos(theta1)", (), ("a3*cos(theta1)",)), ("0.7071*cos(theta1)", (), ("d1*cos(theta1)",)),
    ):  # fmt: skip
        for student in (*right, *wrong):
            is_right = judge_expression(student, reference, GIVEN_LENGTHS, "s").outcome is CORRECT
            assert is_right == (student in right), (student, reference)


@pytest.mark.parametrize("student", ["Eq(a1, a1*a2)", "Eq(2*detJ, a1*a2)", "Eq(a1*a2, a1)", "Eq(a1*a2, a1*a2)"])
def test_only_a_new_name_may_stand_on_the_other_side_of_an_equation(student: str) -> None:
    for text, is_right in ((student, False), ("Eq(detJ, a1*a2)", True), ("Eq(a1*a2, detJ)", True)):
        judgement = judge_expression(text, "a1*a2", DOMAIN, "s")
        assert (judgement.outcome is Outcome.CORRECT) is is_right
        assert is_right or "found an equation" in judgement.reason
        as_matrix = judge_matrix(text.replace("a1*a2", "[a1, a2]"), [["a1"], ["a2"]], DOMAIN, "s")
        is_symbol = text in ("Eq(a1, a1*a2)", "Eq(a1*a2, a1)")  # before a matrix, a symbol can only be a name
        assert (as_matrix.outcome is Outcome.CORRECT) is (is_right or is_symbol)


@pytest.mark.parametrize(("text", "expected"), read_cases("answers")["decimal_commas"])
def test_decimal_commas_are_replaced(text: str, expected: str) -> None:
    assert replace_decimal_commas(text) == expected


# --- matrices, numbers, options ---


def test_a_matrix_is_marked_by_its_entries() -> None:
    reference = [["a1", "a2"], ["a2*cos(theta1)", "a1*sin(theta1)"]]
    half = judge_matrix("[[a1, a2], [blank, 0]]", reference, DOMAIN, "s")
    assert (half.share, half.entries) == (0.5, ((True, True), (False, False)))
    transposed = judge_matrix("[[a1, a2*cos(theta1)], [a2, a1*sin(theta1)]]", reference, DOMAIN, "s")
    assert transposed.outcome is PARTIAL and "entry (1, 2)" in transposed.reason


@pytest.mark.parametrize("tolerance", [None, 0.005])
def test_a_direction_is_right_up_to_any_factor_but_zero(tolerance: float | None) -> None:
    factors = ("2", "-2") if tolerance else ("2", "-2", "cos(theta1)", "1/a1")
    for factor in factors:
        assert judge_direction(f"[3*{factor}, -4*{factor}]", ["3", "-4"], DOMAIN, "s", tolerance).outcome is CORRECT
    for wrong, reason in (("[0, 0]", "the zero vector"), ("[3, 4]", "the right direction"), ("[3 + i, -4]", "")):
        judged = judge_direction(wrong, ["3", "-4"], DOMAIN, "s", tolerance)
        assert judged.outcome is WRONG and reason in judged.reason, wrong


def test_numbers_that_are_zero_earn_nothing() -> None:
    judged = judge_numbers("[0, 2]", [0.0, 1.0], ["m", "m"], 0.005, 0.001)
    assert (judged.outcome, judged.share) == (WRONG, 0.0)


def test_the_reason_names_a_single_number_without_an_index() -> None:
    judged = judge_numbers("-5.2", [5.229], ["N m"], 0.005, 0.001)
    assert judged.reason == "your number is -5.2, and 5.229 N m is right"
    assert remove_numbers(judged.reason) == "your number is not right"
    judged = judge_numbers("[1, 2]", [1.0, 3.0], ["m", "m"], 0.005, 0.001)
    assert remove_numbers(judged.reason) == "1 of 2 numbers is right; number 2 is not right"


@pytest.mark.parametrize(("student", "reason"), read_cases("answers")["selections"])
def test_the_reason_counts_the_letters_of_a_selection(student: str, reason: str) -> None:
    assert judge_selection(student, 5, (0, 1)).reason == reason


def test_numbers_get_a_numeric_certificate() -> None:
    assert judge_rates("[1, 2]", 1, 2).certificate == Certificate("numeric", 1, 0.0)
    example = EntryDifference(1, {}, 3.0, 2.0)
    assert judge_rates("[1, 3]", 1, 2).certificate == Certificate("numeric", 1, 0.0, example)


def test_numbers_are_right_within_their_tolerance() -> None:
    assert judge_rates("[-2.009, 0.25]", -2, 0.25).outcome is Outcome.CORRECT
    assert judge_rates("[-2.011, 0.25]", -2, 0.25).share == 0.5
    assert judge_numbers("0.5", [0.0], [""], 0.005, 0.5).outcome is Outcome.CORRECT
    judgement = judge_rates("[1, blank]", 1, 2.71828)
    assert (judgement.outcome, judgement.share, judgement.entries) == (Outcome.PARTIAL, 0.5, ((True,), (False,)))
    assert judgement.certificate and isinstance(judgement.certificate.counterexample, EntryDifference)
    assert judgement.certificate.counterexample.yours == "blank"


@pytest.mark.parametrize(
    ("student", "is_right", "reason"),
    [
        ("C", False, "'C' is not one of the options A, B"), ("int", False, "'int' is not one of *"),
        ("B", True, "right"), ("A, B", False, "'A, B' names several options; choose one of A, B"),
        ("inte", True, "right"), ("A", False, "A is not *"), ("singularity", False, "'singularity' is not one of *"),
        ("wxyz" * 20, False, f"'{'wxyz' * 10}' is not one of *"),
    ],
)  # fmt: skip
def test_reason_for_a_choice(student: str, is_right: bool, reason: str) -> None:
    judgement = judge_choice(student, ("a boundary singularity", "an internal singularity"), 1)
    assert (judgement.outcome is Outcome.CORRECT) is is_right
    assert fnmatchcase(judgement.reason, reason), judgement.reason
    assert judgement.certificate == (None if "one of" in reason else Certificate("exact", 1, 0.0))


OPTIONS = ("a boundary singularity", "an internal singularity", "no singularity: full rank")


@pytest.mark.parametrize(
    ("student", "right"),
    [
        *((student, 1) for student in ("B", "b", '"B"', "(B)", "B.", "an internal singularity")),
        *((student, 2) for student in ("C. no singularity", "C) whatever", "no singularity", "c")),
        ("singularity", None), ("D", None), ("B" + " " * 300_000, 1),
        *((f"B{' ' * count}C", None) for count in (1, 1000, 300_000)), ("B" * 5000, None),
    ],
)  # fmt: skip
def test_a_choice_is_a_letter_or_an_unambiguous_text(student: str, right: int | None) -> None:
    for option in range(3):
        assert judge_choice(student, OPTIONS, option).outcome is (CORRECT if option == right else WRONG)
    assert judge_choice("blank", OPTIONS, 0).outcome is MISSING


@pytest.mark.parametrize("shape", [None, (1, 1)])
def test_a_single_entry_is_called_the_result(shape: tuple[int, int] | None) -> None:
    assert _name_entry(SimpleNamespace(shape=shape), 0) == "the result"  # type: ignore[arg-type]


# --- singular configurations ---

FOLD = ("theta2 = 0", "theta2 = pi")
ROOTS = "theta2 in {acos(-3/5), -acos(-3/5)}"


def test_allowed_rounding_is_not_mentioned() -> None:
    judgement = judge_set("{theta2: 3.14}", *FOLD, rounding=Rounding(0.005))
    assert judgement.share == pytest.approx(2 / 3) and "rounding" not in judgement.reason


def test_the_certificate_of_a_set_has_counterexamples() -> None:
    assert judge_set("sin(theta2) = 0", *FOLD).certificate == Certificate("numeric", 50, compute_chance_of_missing(50))
    certificate = judge_set("{theta2: [0, 1]}", *FOLD).certificate
    assert certificate is not None
    assert isinstance(certificate.counterexample, SetDifference)
    missing, surplus = certificate.counterexample.missing, certificate.counterexample.surplus
    assert missing is not None and missing["theta2"] == pytest.approx(3.14159)
    assert surplus is not None and surplus["theta2"] == 1


def test_values_without_a_joint_are_refused_if_several_joints_are_possible() -> None:
    """Taking the joint from the reference would make {0, pi} right for any joint."""
    for text in ("{0, pi}", "[0, pi]", "k*pi", "0, pi"):
        judged = judge_set(text, "sin(theta2) = 0")
        assert judged.outcome is WRONG and "say which joint variable" in judged.reason, text
    assert "has no value" in judge_set("theta2", "sin(theta3) = 0").reason
    one_joint = Domain({"theta1": "angle"})
    assert judge_singular("{0, pi}", ["sin(theta1) = 0"], ["theta1"], one_joint, "s").outcome is CORRECT


def test_angles_are_equal_modulo_whole_turns() -> None:
    assert judge_angles("{2*pi, 3*pi}", "{0, pi}", DOMAIN, "s").outcome is CORRECT
    assert judge_angles("{0, pi/2, pi}", "{0, pi}", DOMAIN, "s").outcome is PARTIAL
    assert judge_angles("{0, 3.14}", "{0, pi}", DOMAIN, "s").outcome is not CORRECT


@pytest.mark.parametrize(("student", "is_explained"), read_cases("answers")["deciding_commas"])
def test_the_reading_of_a_comma_is_explained_if_it_decides_the_mark(student: str, is_explained: bool) -> None:
    reference = ["theta1 = pi/2 and theta2 = 0", "theta1 = -pi/2 and theta2 = 0"]
    judged = judge_singular(student, reference, ["theta1", "theta2"], DOMAIN, "s")
    assert judged.outcome is not CORRECT and judged.reason.startswith(OR_HINT) is is_explained


def test_a_singular_set_may_name_given_lengths() -> None:
    third = "theta2 in {acos(-3*sqrt(2)/10), -acos(-3*sqrt(2)/10)}"
    rows = [("a1 + d1*cos(theta2) = 0", ROOTS, WRONG), ("d1*cos(theta2) + a1 = 0", third, CORRECT)]
    for student in ("a1 + a2*cos(theta2) = 0", "{theta2: [acos(-a1/a2), -acos(-a1/a2)]}", "cos(theta2) = -3/5"):
        rows += [(student, reference, CORRECT) for reference in (ROOTS, "3/10 + cos(theta2)/2 = 0")]
    for student, reference, expected in rows:
        judged = judge_singular(student, [reference], ["theta1", "theta2"], GIVEN_LENGTHS, "s")
        assert judged.outcome is expected, (student, reference, judged.reason)
