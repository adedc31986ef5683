"""Judging single answers: right in any form, wrong in the usual ways, hostile, empty. See test_forms.py, too."""

from fractions import Fraction

import pytest

from qdot.exercises.formula.equality import Domain, EntryDifference
from qdot.grader.judging.answer_parser import OR_HINT
from qdot.grader.judging.verdict import Outcome
from qdot.grader.reports.feedback_levels import remove_numbers
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

DOMAIN = Domain(
    {
        "theta1": "angle", "theta2": "angle", "theta3": "angle", "a1": "length", "a2": "length", "a3": "length",
        "d1": "length", "qd1": "signed", "qd2": "signed", "L": 0.35,
    }
)  # fmt: skip
PX = "a1*cos(theta1) + a2*cos(theta1 + theta2)"
J = [
    ["-a1*sin(theta1) - a2*sin(theta1 + theta2)", "-a2*sin(theta1 + theta2)"],
    ["a1*cos(theta1) + a2*cos(theta1 + theta2)", "a2*cos(theta1 + theta2)"],
]
JOINTS = ["theta1", "theta2", "theta3"]
CORRECT, PARTIAL, WRONG, MISSING = Outcome.CORRECT, Outcome.PARTIAL, Outcome.WRONG, Outcome.MISSING
GIVEN_LENGTHS = Domain(
    {"theta1": "angle", "theta2": "angle", "a1": 0.3, "a2": Fraction(1, 2), "a3": Fraction(1, 3), "d1": 0.5**0.5}
)
"""Lengths with given values."""


# --- formulas ---

EXPRESSIONS = {
    (PX, CORRECT): (
        PX, f"px = {PX}", "a2*cos(theta2 + theta1) + cos(theta1)*a1", "a1*c1 + a2*c12", "a_1 cos(θ_1) + a2 cos(θ₁+θ₂)",
        "a1*np.cos(theta1) + a2*(np.cos(theta1)*np.cos(theta2) - np.sin(theta1)*np.sin(theta2))",
        "a1*(1 - tan(theta1/2)**2)/(1 + tan(theta1/2)**2) + a2*sin(theta1 + theta2 + pi/2)",
        "sqrt(a1**2)*cos(theta1) + a2*cos(theta1 + theta2)",
        "a1*cos(theta1) + a2*cos(theta1 + theta2)*sin(theta2)/sin(theta2)",
        "a1*(exp(I*theta1) + exp(-I*theta1))/2 + a2*cos(theta1 + theta2)",
    ),
    (PX, WRONG): (
        "a1*cos(theta1) - a2*cos(theta1 + theta2)", "a1*cos(theta1) + a2*cos(theta2)", "a1*cos(theta1)",
        "a1*sin(theta1) + a2*sin(theta1 + theta2)", "a1*cos(pi*theta1/180) + a2*cos(pi*(theta1 + theta2)/180)",
        "a1*cos(theta1) + a2*cos(theta1 + theta2) + a2/10000", "a1*sqrt(cos(theta1)**2) + a2*cos(theta1 + theta2)",
        "a1*cos(theta1) + a2*cos(theta1 + theta2) + k",
        "nan", "oo", "None", "1e400", "0/0", "a1**9**9**9", "1/(9**9**9**9)",
        "__import__('os').system('true')", "(" * 5000, "sin(" * 2000, "lambda: 0", "{" + PX + "}", "\x00", "\ud800",
    ),
    (PX, MISSING): ("", "   ", "blank", "...", "Ellipsis"),
    ("7*cos(theta1)/20", CORRECT): ("L*cos(theta1)", "0.35*cos(theta1)"),
    ("7*cos(theta1)/20", WRONG): ("a1*cos(theta1)",),
    ("a1*cos(theta1)*qd1", CORRECT): ("a1*cos(theta1(t))*Derivative(theta1(t), t)",),
    ("a1*cos(theta1)/2", CORRECT): ("0,5*a1*cos(theta1)",),
    ("a1", WRONG): ("1,2", "a1, a2"),
    ("0", CORRECT): ("atan2(0,1)",),
}  # fmt: skip


@pytest.mark.parametrize(("reference", "expected"), EXPRESSIONS, ids=str)
def test_an_expression_is_judged_by_its_value(reference: str, expected: Outcome) -> None:
    for student in EXPRESSIONS[reference, expected]:
        assert judge_expression(student, reference, DOMAIN, "seed").outcome is expected, student[:200]


def test_a_rejection_has_a_counterexample_or_names_unknown_symbols() -> None:
    judged = judge_expression("a1*cos(theta1)", PX, DOMAIN, "seed")
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


# --- matrices, numbers, options ---


def format_rows(rows: list[list[str]]) -> str:
    return str(rows).replace("'", "")


VECTOR, RATES = [["a1"], ["a2"], ["a3"]], [["qd2*a1"], ["a2"]]
ZERO, ZEROS, COLUMN = [["0"], ["cos(theta1)"]], [["0", "0"], ["0", "cos(theta1)"]], [["0", "a1"], ["0", "a2"]]
MATRICES: list[tuple[list[list[str]], float, tuple[str, ...]]] = [
    (J, 1.0, (format_rows(J), f"Matrix({format_rows(J)})")),
    (J, 0.5, (f"[[{J[0][0]}, {J[0][1]}], [blank, 0]]",)),
    (ZEROS, 0.0, ("[[0, 0], [0, 0]]", "[[0, 0], [1, cos(theta1)]]")),
    (ZEROS, 1.0, ("[[0, 0], [0, cos(theta1)]]",)),
    (VECTOR, 1.0, ("[a1, a2, a3]", "[[a1], [a2], [a3]]", "[[a1, a2, a3]]", "a1, a2, a3")),
    (ZERO, 1.0, ("[6.123233995736766e-17*a1, cos(theta1)]",)),
    (ZERO, 0.0, ("[1e-7*a1, cos(theta1)]",)),
    ([["0", "a1"], ["0", "0"], ["1", "1"]], 1.0, ("[[[0], [0], [1]], [[a1], [0], [1]]]",)),
    (COLUMN, 0.5, ("[[blank, a1], [blank, a2]]",)),
    (
        RATES, 1.0,
        ("{qd1: qd2*a1, qd2: a2}", "[{qd2: a2, qd1: qd2*a1}]", "{(qd2*a1, a2)}", "[Eq(qd1, a1*qd2), Eq(qd2, a2)]"),
    ),
    (RATES, 0.0, ("{qd1: a2, qd2: a1}",)),
]  # fmt: skip


def test_a_matrix_is_marked_by_its_entries() -> None:
    for reference, share, students in MATRICES:
        labels = ("qd1", "qd2") if reference is RATES else ()
        for student in students:
            judged = judge_matrix(student, reference, DOMAIN, "s", labels)
            assert judged.share == share, (student, judged)
            assert judged.outcome is (CORRECT if share == 1 else PARTIAL if share else WRONG), student
    half = judge_matrix(f"[[{J[0][0]}, {J[0][1]}], [blank, 0]]", J, DOMAIN, "s")
    assert half.entries == ((True, True), (False, False))
    transposed = judge_matrix(f"[[{J[0][0]}, {J[1][0]}], [{J[0][1]}, {J[1][1]}]]", J, DOMAIN, "s")
    assert transposed.outcome is PARTIAL and "entry (1, 2)" in transposed.reason


@pytest.mark.parametrize(
    ("student", "reason"),
    [("[1, 2, 3]", "3 × 1"), ("5", "1 × 1"), ("[[1, 2], [3]]", "different lengths"), ("[[1, 2], [3, [4]]]", "list"),
     ("sin(theta1", "')' is missing at the end"), ("{1: 2}", "1 × 1")],
)  # fmt: skip
def test_wrong_shapes_are_reported(student: str, reason: str) -> None:
    judged = judge_matrix(student, J, DOMAIN, "s")
    assert judged.outcome is WRONG and reason in judged.reason


@pytest.mark.parametrize(
    ("student", "expected"),
    [
        ("[1.00, -0.2]", CORRECT), ("[1.0045, -1/5]", CORRECT), ("[1.0, -0.21]", PARTIAL), ("[57.55, -11.46]", WRONG),
        ("[nan, -0.2]", WRONG), ("[blank, blank]", MISSING), ("[theta1, -0.2]", WRONG), ("1.0", WRONG),
        ("{qd2: -0.2, qd1: 1.0}", CORRECT), ("{qd1: -0.2, qd2: 1.0}", WRONG),
        ("[1.00952, -0.2]", CORRECT), ("[1.00954, -0.2]", PARTIAL),  # 0.5 % of the expected number, not of the answer
    ],
)  # fmt: skip
def test_numbers_are_judged_to_three_digits(student: str, expected: Outcome) -> None:
    labels = ("qd1", "qd2")
    assert judge_numbers(student, [1.0045, -0.2], ["rad/s", "rad/s"], 0.005, 0.001, labels).outcome is expected


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


@pytest.mark.parametrize(
    ("student", "reason"),
    [
        ("A", "1 letter is right, 1 letter is missing"),
        ("A, C", "1 letter is right, 1 letter is wrong, 1 letter is missing"),
        ("C, D", "2 letters are wrong, 2 letters are missing"), ("A, B, C", "2 letters are right, 1 letter is wrong"),
    ],
)  # fmt: skip
def test_the_reason_counts_the_letters_of_a_selection(student: str, reason: str) -> None:
    assert judge_selection(student, 5, (0, 1)).reason == reason


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


# --- singular configurations ---

SHOULDER = "Eq(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3), 0)"
ELBOW = ["theta3 = 0", "theta3 = pi", "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"]
SINE, FACTORS = ["sin(theta3) = 0"], ["sin(theta3) = 0", ELBOW[2]]
FOUR = [f"theta2 = {p} and theta3 = {q}" for p in ("0", "pi") for q in ("0", "pi")]
ANGLE = "acos((-a1 - a2*cos(theta2))/a3)"
MINOR = "a2*sin(theta2) + a3*sin(theta2 + theta3)"
ROOTS = "theta2 in {acos(-3/5), -acos(-3/5)}"
SETS: dict[tuple[str, Outcome | None], tuple[list[str], tuple[str, ...]]] = {
    ("conditions one by one", CORRECT): (
        ELBOW,
        (
            f"[Eq(sin(theta3), 0), {SHOULDER}]", f"[{{theta3: [0, pi]}}, {SHOULDER}]",
            f"[{{theta3: {{-pi, 0}}}}, {SHOULDER}]", f"theta3 in {{0, pi}}, {SHOULDER}", f"theta3 = k*pi, {SHOULDER}",
            f"[sin(theta3), {SHOULDER}]", f"Or(Eq(tan(theta3), 0), {SHOULDER})",
            "sin(theta3)*(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3)) = 0",
            f"[blank, Eq(sin(theta3)**2, 0), {SHOULDER}]",
        ),
    ),
    ("conditions one by one", PARTIAL): (
        ELBOW,
        (
            "[Eq(sin(theta3), 0)]", f"[Eq(theta3, 0), {SHOULDER}]", "[{theta3: [0, 180]}]",
            f"[Eq(sin(theta2), 0), Eq(sin(theta3), 0), {SHOULDER}]", "[Eq(sin(theta2), 0), Eq(sin(theta3), 0)]",
        ),
    ),
    ("conditions one by one", WRONG): (
        ELBOW, ("[Eq(sin(theta2), 0)]", "[]", "Eq(cos(theta1)**2 + sin(theta1)**2, 1)", "[0, pi]", "True"),
    ),
    ("conditions one by one", MISSING): (ELBOW, ("[blank]",)),
    ("what holds nowhere", None): (ELBOW, ("theta3 = 0 or theta3 = pi or 1e-10 = 0", "Eq(1e-10*theta3, 0)")),
    ("one joint", CORRECT): (
        SINE,
        (
            "cos(theta3)**2 = 1", "cos(theta3) = 1 or cos(theta3) = -1", "sin(theta3)**2 = 0", "1 - cos(2*theta3) = 0",
            "abs(cos(theta3)) = 1", "1e-9*sin(theta3) = 0",
            "theta3 in Union(ImageSet(Lambda(_n, 2*_n*pi + pi), Integers), ImageSet(Lambda(_n, 2*_n*pi), Integers))",
        ),
    ),
    ("one joint", None): (
        SINE,
        (
            "1e-13 = 0", "Eq(1e-13*cos(theta1)**2 + 1e-13*sin(theta1)**2 + 0*theta1, 0)", "theta3 = pi", "theta3 = 0",
            "theta3 = 0, pi, sqrt(cos(theta1)) = 0", "theta3 = 0, theta3 = 3.1416", "theta3 = 0.000001, theta3 = pi",
        ),
    ),
    ("factors", CORRECT): (
        FACTORS,
        (
            f"sin(theta3)**3 = 0, {SHOULDER}", f"theta3 = 0 or pi, {SHOULDER}", f"theta3 = 0, pi, {SHOULDER}",
            f"[(theta3, [0, pi]), {SHOULDER}]", f"[(theta3, 0), (theta3, pi), {SHOULDER}]",
            f"sin(theta3) = 0, theta3 = -theta2 + {ANGLE}, theta3 = -theta2 - {ANGLE}",
            f"sin(theta3) = 0, cos(theta2) = 2, {SHOULDER}",
        ),
    ),
    ("factors", None): (
        FACTORS,
        (
            f"sin(theta3) = 0, theta3 = -theta2 + {ANGLE}",
            "sin(theta3) = 0, a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) + 1e-6 = 0",
        ),
    ),
    ("together", CORRECT): (
        FOUR,
        (
            "And(Eq(sin(theta2), 0), Eq(sin(theta3), 0))", "{theta2: [0, pi], theta3: [0, pi]}",
            f"a1**2*a2**2*sin(theta2)**2 + a2**2*a3**2*sin(theta3)**2 + a1**2*({MINOR})**2 = 0",
        ),
    ),
    ("together", None): (FOUR, ("sin(theta2) = 0, sin(theta3) = 0",)),
    ("six values", CORRECT): (["sin(6*theta2) = 0"], ("theta2 = k*pi/6",)),
    ("quarter turns", CORRECT): (["cos(2*theta2) = 0"], ("theta2 = pi/4 + n*pi/2",)),
    ("half turns", CORRECT): (
        ["sin(theta2) = 0"],
        ("theta2 = -k*pi", "theta2 = k*pi", "{theta2: [0, pi]}", "{theta2: [0.0, 3.141592653589793]}",
         "theta2 = 0 or 3.14159265358979"),
    ),
}  # fmt: skip
"""References with students' answers; None: anything but correct."""


@pytest.mark.parametrize(("name", "expected"), sample_for_suite(SETS, 5), ids=str)
def test_a_set_is_judged_by_its_configurations(name: str, expected: Outcome | None) -> None:
    reference, students = SETS[name, expected]
    for student in students:
        judged = judge_singular(student, reference, JOINTS, DOMAIN, "s")
        assert judged.outcome is expected if expected else judged.outcome is not CORRECT, (student, judged.reason)


def test_a_blank_or_narrow_condition_costs_only_its_share() -> None:
    for student, reference in (
        ("[blank, Eq(theta2, blank), Eq(theta2, pi)]", ["theta2 = 0", "theta2 = pi"]),
        ("And(Eq(theta2, 0), Eq(theta3, 0))", FOUR),
    ):
        assert judge_singular(student, reference, JOINTS, DOMAIN, "s").share == pytest.approx(2 / 3)


def test_values_without_a_joint_are_refused_if_several_joints_are_possible() -> None:
    """Taking the joint from the reference would make {0, pi} right for any joint."""
    for text in ("{0, pi}", "[0, pi]", "k*pi", "0, pi"):
        judged = judge_singular(text, ["sin(theta2) = 0"], JOINTS, DOMAIN, "s")
        assert judged.outcome is WRONG and "say which joint variable" in judged.reason, text
    assert "has no value" in judge_singular("theta2", SINE, JOINTS, DOMAIN, "s").reason
    one_joint = Domain({"theta1": "angle"})
    assert judge_singular("{0, pi}", ["sin(theta1) = 0"], ["theta1"], one_joint, "s").outcome is CORRECT


def test_angles_are_equal_modulo_whole_turns() -> None:
    assert judge_angles("{2*pi, 3*pi}", "{0, pi}", DOMAIN, "s").outcome is CORRECT
    assert judge_angles("{0, pi/2, pi}", "{0, pi}", DOMAIN, "s").outcome is PARTIAL
    assert judge_angles("{0, 3.14}", "{0, pi}", DOMAIN, "s").outcome is not CORRECT


@pytest.mark.parametrize(
    ("student", "reason"),
    [
        ("{theta2: [0, 3.1415926536]}", "rounding"), ("{theta2: [0, 3.1416]}", "rounding"),
        ("{theta2: [0, 2.9]}", "theta1 ="), ("theta2 = k*180", "degrees"), ("theta2 in {0, 180}", "degrees"),
        ("theta2 = 0", "missing"),
    ],
)  # fmt: skip
def test_inexact_angles_are_wrong_and_the_reason_is_given(student: str, reason: str) -> None:
    judged = judge_singular(student, ["sin(theta2) = 0"], ["theta1", "theta2"], DOMAIN, "s")
    assert judged.outcome is not CORRECT and reason in judged.reason


@pytest.mark.parametrize(
    ("student", "is_explained"),
    [
        ("theta1 = 90° or -90°, theta2 = 0", True), ("theta2 = 0, theta1 = pi/2, -pi/2", True),
        ("(theta1 = ±90°), theta2 = 0", True), ("[Eq(theta1, pi/2), Eq(theta1, -pi/2), Eq(theta2, 0)]", True),
        ("theta1 = pi, theta2 = 0", False), ("theta1 = 90°, theta1 = -90°", False),
        ("theta1 = 90° and theta2 = 0", False),
    ],
)  # fmt: skip
def test_the_reading_of_a_comma_is_explained_if_it_decides_the_mark(student: str, is_explained: bool) -> None:
    reference = ["theta1 = pi/2 and theta2 = 0", "theta1 = -pi/2 and theta2 = 0"]
    judged = judge_singular(student, reference, ["theta1", "theta2"], DOMAIN, "s")
    assert judged.outcome is not CORRECT and judged.reason.startswith(OR_HINT) is is_explained


@pytest.mark.parametrize(
    ("student", "share", "reason"),
    [
        ("theta2 = 0, theta2 = 3.1416 rad", 4 / 5, "you found the condition; correct except for rounding: theta1 ="),
        ("theta2 = 0, 22/7", 4 / 5, "rounding"), ("theta2 = 0°, 179.9°", 4 / 5, "rounding"),
        ("theta2 = 3.14", 8 / 15, "rounding"), ("theta2 = 0, 3.14, 1", 2 / 5, "is not singular"),
        ("theta2 = 0, 3.1", 1 / 3, "is not singular"),
    ],
)  # fmt: skip
def test_rounded_angles_lose_a_fifth(student: str, share: float, reason: str) -> None:
    judged = judge_singular(student, ["theta2 = 0", "theta2 = pi"], ["theta1", "theta2"], DOMAIN, "s")
    assert judged.share == pytest.approx(share) and reason in judged.reason


@pytest.mark.parametrize(
    ("student", "share"),
    [
        ("theta1 + theta2 = 0, pi, -pi", 1), ("Eq(theta1 + theta2, 0)", 2 / 3), ("theta1 = pi - theta2", 2 / 3),
        ("theta1 + theta2 = 0 or pi/2", 1 / 3), ("theta1 + theta2 = 0 or 3.14", 4 / 5), ("theta1 = 0 or pi", 0),
    ],
)  # fmt: skip
def test_values_of_a_sum_of_angles_earn_their_share(student: str, share: float) -> None:
    """Each value of the sum counts modulo 2 pi, as a value of a single joint does."""
    for reference in ("sin(theta1 + theta2) = 0", "cos(theta1 + theta2 - pi/2) = 0"):
        judged = judge_singular(student, [reference], ["theta1", "theta2"], DOMAIN, "s")
        assert judged.share == pytest.approx(share), (reference, judged.reason)


def test_a_singular_set_may_name_given_lengths() -> None:
    third = "theta2 in {acos(-3*sqrt(2)/10), -acos(-3*sqrt(2)/10)}"
    rows = [("a1 + d1*cos(theta2) = 0", ROOTS, WRONG), ("d1*cos(theta2) + a1 = 0", third, CORRECT)]
    for student in ("a1 + a2*cos(theta2) = 0", "{theta2: [acos(-a1/a2), -acos(-a1/a2)]}", "cos(theta2) = -3/5"):
        rows += [(student, reference, CORRECT) for reference in (ROOTS, "3/10 + cos(theta2)/2 = 0")]
    for student, reference, expected in rows:
        judged = judge_singular(student, [reference], ["theta1", "theta2"], GIVEN_LENGTHS, "s")
        assert judged.outcome is expected, (student, reference, judged.reason)
