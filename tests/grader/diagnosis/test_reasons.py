"""The reasons, shares and certificates of judgements, word by word."""

from fnmatch import fnmatchcase
from types import SimpleNamespace

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
from qdot.grader.judging.answer_parser import replace_decimal_commas
from qdot.grader.judging.verdict import Judgement, Outcome
from tests.support.judging import (
    judge_choice,
    judge_expression,
    judge_matrix,
    judge_numbers,
    judge_singular,
)

JOINTS = ["theta1", "theta2", "theta3"]
LENGTHS, RATES = dict.fromkeys(("a1", "a2", "a3", "d1"), "length"), dict.fromkeys(("qd1", "qd2"), "signed")
DOMAIN = Domain({**dict.fromkeys(JOINTS, "angle"), **LENGTHS, **RATES})


def judge_rows(student: str, reference: list[list[str]], *labels: str) -> Judgement:
    return judge_matrix(student, reference, DOMAIN, "s", labels)


def judge_rates(student: str, *reference: float, labels: tuple[str, ...] = ()) -> Judgement:
    return judge_numbers(student, reference, ["rad/s"] * len(reference), 0.005, 0.001, labels)


def judge_set(student: str, *reference: str, rounding: Rounding | None = None) -> Judgement:
    return judge_singular(student, reference, JOINTS, DOMAIN, "s", rounding)


@pytest.mark.parametrize("student", ["Eq(a1, a1*a2)", "Eq(2*detJ, a1*a2)", "Eq(a1*a2, a1)", "Eq(a1*a2, a1*a2)"])
def test_only_a_new_name_may_stand_on_the_other_side_of_an_equation(student: str) -> None:
    for text, is_right in ((student, False), ("Eq(detJ, a1*a2)", True), ("Eq(a1*a2, detJ)", True)):
        judgement = judge_expression(text, "a1*a2", DOMAIN, "s")
        assert (judgement.outcome is Outcome.CORRECT) is is_right
        assert is_right or "found an equation" in judgement.reason
        as_matrix = judge_rows(text.replace("a1*a2", "[a1, a2]"), [["a1"], ["a2"]])
        is_symbol = text in ("Eq(a1, a1*a2)", "Eq(a1*a2, a1)")  # before a matrix, a symbol can only be a name
        assert (as_matrix.outcome is Outcome.CORRECT) is (is_right or is_symbol)


@pytest.mark.parametrize("student", ["{a1}", "{a1: 2}", "{a1, a2}", "[[a1, a2]]"])
def test_a_list_is_refused_for_an_expression(student: str) -> None:
    assert judge_expression(student, "a1", DOMAIN, "s").reason.startswith("your answer is a list or matrix")


@pytest.mark.parametrize(
    ("student", "is_right"),
    [
        ("[Eq(qd1, qd2*a1), Eq(qd2, a2)]", True), ("[{qd2: a2, qd1: qd2*a1}]", True),
        ("{{qd2: a2, qd1: qd2*a1}}", True), ("-[qd2*a1, a2]", False), ("-{qd1: qd2*a1, qd2: a2}", False),
        ("[{qd1: qd2*a1, qd2: a2}, {qd1: 0, qd2: 0}]", False), ("[Eq(qd1, qd2*a1), a2]", False),
        ("Or(Eq(qd1, qd2*a1), Eq(qd2, a2))", False), ("[{qd1: qd2*a1, d1: a2}]", False),
    ],
)  # fmt: skip
def test_entries_of_a_vector_may_be_labelled(student: str, is_right: bool) -> None:
    assert (judge_rows(student, [["qd2*a1"], ["a2"]], "qd1", "qd2").outcome is Outcome.CORRECT) is is_right


def test_row_and_column_vectors_are_accepted() -> None:
    assert judge_rows("[Eq(qd1, a1)]", [["a1"]], "qd1").outcome is Outcome.CORRECT
    assert judge_rows("[[a1, a2]]", [["a1", "a2"]]).outcome is Outcome.CORRECT
    assert judge_rows("[[a1, a2], [0, 0]]", [["a1"], ["a2"]]).outcome is Outcome.WRONG
    assert judge_rates("[[1, 2]]", 1, 2).outcome is Outcome.CORRECT


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0,5*a1", "0.5*a1"), ("1,5 - 2,25", "1.5 - 2.25"), ("atan2(0,1)", "atan2(0,1)"), ("[1,5]", "[1,5]"),
        ("atan2(0,1) + 0,5", "atan2(0,1) + 0.5"), ("{1,2}*1,5*[1,2]", "{1,2}*1.5*[1,2]"),
        ("f((1),0,1)", "f((1),0,1)"), ("a,5", "a,5"), ("5,a", "5,a"), ("5, 6", "5, 6"), ("5,", "5,"), (",5", ",5"),
    ],
)  # fmt: skip
def test_decimal_commas_are_replaced(text: str, expected: str) -> None:
    assert replace_decimal_commas(text) == expected


TWO_BY_TWO = [["0", "a1"], ["0", "a2"]]


@pytest.mark.parametrize(
    ("student", "reference", "share", "reason"),
    [
        ("[[0, a1], [0, a1]]", TWO_BY_TWO, 1 / 2,
         "1 of 2 nonzero entries is right; entry (2, 2) differs at *: yours *, expected *"),
        ("[[1, a1], [0, a1]]", TWO_BY_TWO, 0, "1 of 2 *, but 1 that should be zero is not; entry (1, 1) *"),
        ("[[0, a1], [2, a2]]", TWO_BY_TWO, 1 / 2, "both nonzero *, but 1 that should be zero is not; entry (2, 1) *"),
        ("[[1, a1], [2, a1]]", TWO_BY_TWO, 0, "1 of 2 *, but 2 that should be zero are not; entry (1, 1) *"),
        ("[[blank, a1], [0, a2]]", TWO_BY_TWO, 1 / 2, "both nonzero *; *blank"),
        ("[[blank, a1], [blank, a1]]", TWO_BY_TWO, 1 / 2, "1 of 2 *; entry (2, 2) *"),
        ("[a1, a1, a3]", [["a1"], ["a2"], ["a3"]], 2 / 3, "2 of 3 *; entry 2 *"),
        ("[[a2, a1]]", [["a1", "a2"]], 0, "neither of the two *; entry (1, 1) *"),
        ("[blank, a2]", [["a1"], ["a2"]], 1 / 2, "1 of 2 *blank"),
        ("[blank, a1]", [["a1"], ["a2"]], 0, "neither of the two *2 *"),
        ("[0, 1]", [["0"], ["0"]], 1 / 2, "1 of 2 *; entry 2 *: yours 1, expected 0"),
        ("a2", [["a1"]], 0, "your answer differs at a1 = *, a2 = *: yours *, expected *"),
        ("1", [["0"]], 0, "your answer differs: yours 1, expected 0"),
        ("[0, a2]", [["0"], ["a1"]], 0, "the only nonzero entry is not right; entry 2 differs *"),
        ("[1, a1]", [["0"], ["a1"]], 0, "the only nonzero entry is right, but 1 that should be zero is not; entry 1 *"),
        ("[k*a1, a2]", [["a1"], ["a2"]], 1 / 2, "1 of 2 *; 'k' * are a1, a2, *"),
        ("[f + g + h + k + m + n, a2]", [["a1"], ["a2"]], 1 / 2, "1 of 2 *; 'f', 'g', 'h', 'k', 'm' are *"),
    ],
)  # fmt: skip
def test_reason_for_a_matrix(student: str, reference: list[list[str]], share: float, reason: str) -> None:
    judgement = judge_rows(student, reference)
    assert fnmatchcase(judgement.reason, reason), judgement.reason
    assert judgement.share == pytest.approx(share)


@pytest.mark.parametrize(
    ("student", "shape", "reason"),
    [
        ("[[1, 2], [3, 4], [5, 6]]", (2, 3), "*3 × 2, but it must be 2 × 3*compared*"),
        ("[[1, 2], [3, 4], [5, 6]]", (2, 2), "*3 × 2, but it must be 2 × 2; *[[][[]a, b], [[]c, d]]"),
        ("[[1, 2], [3, 4], [5, 6]]", (2, 4), "*3 × 2, but it must be 2 × 4; * 2 rows of 4"),
        ("[1, 2]", (1, 3), "*2 × 1, but it must be 1 × 3; *[[][[]a, b, c]]"),
        ("{}", (2, 2), "*1 × 1, but it must be 2 × 2*"),
        ("[[1, 2]]", (2, 2), "*1 × 2, but it must be 2 × 2*"),
        ("[[1, 2, 3]]", (2, 1), "*has 3 entries, but it must have 2; * [[]a, b]"),
        ("[{1, 2}]", (2, 1), "*itself a list"), ("[Eq(a1, a2), 0]", (2, 1), "*couldn't parse*an equation*"),
    ],
)  # fmt: skip
def test_reason_for_a_wrong_shape(student: str, shape: tuple[int, int], reason: str) -> None:
    judgement = judge_rows(student, [["a1"] * shape[1]] * shape[0])
    assert fnmatchcase(judgement.reason, reason), judgement.reason


@pytest.mark.parametrize(
    ("student", "share", "reason"),
    [
        ("[1, 2, 3]", 1, "right to 0.5 %"),
        ("[1, 2.5, 7]", 1 / 3, "1 of 3 numbers is right; number 2 is 2.5, and 2 rad/s is right"),
        ("[1, blank, 3]", 2 / 3, "2 of 3 *; number 2 *blank"), ("[1/0, 2, 3]", 2 / 3, "2 of 3 *; number 1 *1 rad/s *"),
        ("[1, 2]", 0, "*has 2 entries, but it must have 3; * [[]a, b, c]"),
        ("[[1, 2, 3, 4]]", 0, "*has 4 entries, but it must have 3; *"),
        ("[[1, 2], [3]]", 0, "*couldn't parse*different lengths: 2, 1"), ("[{1, 2}, 2, 3]", 0, "*itself a list"),
        ("[Eq(qd9, 1), 2, 3]", 0, "* asks for numbers, but your answer contains qd9; *"),
        ("[f + g + h + k + m + n, 2, 3]", 0, "* asks for numbers, but your answer contains f, g, h, k, m; *"),
    ],
)  # fmt: skip
def test_reason_for_numbers(student: str, share: float, reason: str) -> None:
    judgement = judge_rates(student, 1, 2, 3)
    assert fnmatchcase(judgement.reason, reason), judgement.reason
    assert judgement.share == pytest.approx(share)


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


FOLD = ("theta2 = 0", "theta2 = pi")
ELBOW = ("theta3 = 0", "theta3 = pi", "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0")


@pytest.mark.parametrize(
    ("student", "reference", "share", "reason"),
    [
        ("theta2 = 0", FOLD, 2 / 3,
         "you found part of the condition; * missing: *, theta2 = 3.142, *"),
        ("{theta2: [0, 2.9]}", FOLD, 1 / 3,
         "you found part of the condition; 1 of *; * missing: *; this configuration is not *: *"),
        ("{theta2: [0.1, 0.2, 0.3]}", FOLD, 0, "* is missing: *; this configuration *"),
        ("[]", ELBOW, 0, "* is missing: *"),
        ("{theta3: [0, pi]}", ELBOW, 1 / 2,
         "you found 1 of the 2 *; * missing: theta1 = *, theta2 = *, *, a1 = *, a3 = *"),
        ("{theta2: [0, 180]}", FOLD, 1 / 3, "you found part of *; your values are in degrees, but * radians"),
        ("cos(theta2) = 0", FOLD, 0, "* is missing: *; this configuration is not singular*"),
        ("theta2 = 180 or sin(theta2) = 0", FOLD, 1 / 2, "you found the condition; 1 of *; * is not *"),
        ("[]", ("cos(theta2) = 2",), 0, "your answer contains no configuration"),
        ("[Eq(a1, 0)]", FOLD, 0, "* is missing: *"),
        ("[0, pi]", ELBOW, 0, "*couldn't parse*say which joint variable*"),
    ],
)  # fmt: skip
def test_reason_for_singular_configurations(
    student: str, reference: tuple[str, ...], share: float, reason: str
) -> None:
    judgement = judge_set(student, *reference)
    assert fnmatchcase(judgement.reason, reason), judgement.reason
    assert judgement.share == pytest.approx(share)
    assert ("degrees" in judgement.reason) is ("degrees" in reason)


def test_allowed_rounding_is_not_mentioned() -> None:
    judgement = judge_set("{theta2: 3.14}", *FOLD, rounding=Rounding(0.005))
    assert judgement.share == pytest.approx(2 / 3)
    assert fnmatchcase(
        judgement.reason, "you found part of the condition; * missing: theta1 = *, theta2 = 0, theta3 = *"
    )


def test_the_certificate_of_a_set_has_counterexamples() -> None:
    assert judge_set("sin(theta2) = 0", *FOLD).certificate == Certificate("numeric", 50, compute_chance_of_missing(50))
    certificate = judge_set("{theta2: [0, 1]}", *FOLD).certificate
    assert certificate is not None
    assert isinstance(certificate.counterexample, SetDifference)
    missing, surplus = certificate.counterexample.missing, certificate.counterexample.surplus
    assert missing is not None and missing["theta2"] == pytest.approx(3.14159)
    assert surplus is not None and surplus["theta2"] == 1


@pytest.mark.parametrize("shape", [None, (1, 1)])
def test_a_single_entry_is_called_the_result(shape: tuple[int, int] | None) -> None:
    assert _name_entry(SimpleNamespace(shape=shape), 0) == "the result"  # type: ignore[arg-type]
