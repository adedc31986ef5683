"""Judging one answer: right in any form, wrong in the usual ways, hostile, empty."""

from fractions import Fraction

import pytest

from exercises.formula.identity import Domain
from grader.verdict import Outcome
from tests.support.judging import (
    judge_angles,
    judge_choice,
    judge_expression,
    judge_matrix,
    judge_numbers,
    judge_singular,
)

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
ELBOW = ["theta3 = 0", "theta3 = pi", "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"]
JOINTS = ["theta1", "theta2", "theta3"]


def expression(student: str) -> Outcome:
    return judge_expression(student, PX, DOMAIN, "seed").outcome


@pytest.mark.parametrize(
    "student",
    [
        PX,
        "a2*cos(theta2 + theta1) + cos(theta1)*a1",
        "a1*c1 + a2*c12",
        "a_1 cos(θ_1) + a2 cos(θ₁+θ₂)",
        "a1*np.cos(theta1) + a2*(np.cos(theta1)*np.cos(theta2) - np.sin(theta1)*np.sin(theta2))",
        "a1*(1 - tan(theta1/2)**2)/(1 + tan(theta1/2)**2) + a2*sin(theta1 + theta2 + pi/2)",
        "sqrt(a1**2)*cos(theta1) + a2*cos(theta1 + theta2)",
        "a1*cos(theta1) + a2*cos(theta1 + theta2)*sin(theta2)/sin(theta2)",
        "a1*(exp(I*theta1) + exp(-I*theta1))/2 + a2*cos(theta1 + theta2)",
    ],
)
def test_any_equivalent_form_is_right(student: str) -> None:
    assert expression(student) is Outcome.CORRECT


@pytest.mark.parametrize(
    "student",
    [
        "a1*cos(theta1) - a2*cos(theta1 + theta2)",
        "a1*cos(theta1) + a2*cos(theta2)",
        "a1*sin(theta1) + a2*sin(theta1 + theta2)",
        "a1*cos(theta1)",
        "a1*cos(pi*theta1/180) + a2*cos(pi*(theta1 + theta2)/180)",
        "a1*cos(theta1) + a2*cos(theta1 + theta2) + a2/10000",
        "a1*sqrt(cos(theta1)**2) + a2*cos(theta1 + theta2)",
        "a1*cos(theta1) + a2*cos(theta1 + theta2) + k",
        "nan", "oo", "None", "1e400", "0/0", "a1**9**9**9", "1/(9**9**9**9)",
        "__import__('os').system('true')", "(" * 5000, "sin(" * 2000, "lambda: 0", "{" + PX + "}", "\x00", "\ud800",
    ],
)  # fmt: skip
def test_wrong_and_hostile_answers_fail(student: str) -> None:
    assert expression(student) is Outcome.WRONG


@pytest.mark.parametrize("student", ["", "   ", "blank", "...", "Ellipsis"])
def test_blank_is_missing(student: str) -> None:
    assert expression(student) is Outcome.MISSING


def test_a_rejection_shows_where_and_both_values() -> None:
    judged = judge_expression("a1*cos(theta1)", PX, DOMAIN, "seed")
    assert judged.certificate is not None
    example = judged.certificate.counterexample
    assert example is not None
    assert set(example["at"]) == {"a1", "a2", "theta1", "theta2"}
    assert "yours" in judged.reason
    assert "expected" in judged.reason


def test_a_given_length_may_be_called_by_its_name() -> None:
    assert judge_expression("L*cos(theta1)", "7*cos(theta1)/20", DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_expression("0.35*cos(theta1)", "7*cos(theta1)/20", DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_expression("a1*cos(theta1)", "7*cos(theta1)/20", DOMAIN, "s").outcome is Outcome.WRONG


def test_matrix_is_marked_by_entry() -> None:
    text = str(J).replace("'", "")
    assert judge_matrix(text, J, DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_matrix(f"Matrix({text})", J, DOMAIN, "s").outcome is Outcome.CORRECT
    half = judge_matrix(f"[[{J[0][0]}, {J[0][1]}], [blank, 0]]", J, DOMAIN, "s")
    assert half.outcome is Outcome.PARTIAL
    assert half.share == 0.5
    assert half.entries == ((True, True), (False, False))
    turned = judge_matrix(f"[[{J[0][0]}, {J[1][0]}], [{J[0][1]}, {J[1][1]}]]", J, DOMAIN, "s")
    assert turned.outcome is Outcome.PARTIAL
    assert "entry (1, 2)" in turned.reason


def test_zeros_earn_nothing_by_themselves() -> None:
    reference = [["0", "0"], ["0", "cos(theta1)"]]
    assert judge_matrix("[[0, 0], [0, 0]]", reference, DOMAIN, "s").share == 0
    assert judge_matrix("[[0, 0], [1, cos(theta1)]]", reference, DOMAIN, "s").share == 0
    assert judge_matrix("[[0, 0], [0, cos(theta1)]]", reference, DOMAIN, "s").outcome is Outcome.CORRECT


@pytest.mark.parametrize(
    ("student", "said"),
    [("[1, 2, 3]", "3 x 1"), ("5", "1 x 1"), ("[[1, 2], [3]]", "different lengths"), ("[[1, 2], [3, [4]]]", "list"),
     ("sin(theta1", "expected ')'"), ("{1: 2}", "1 x 1")],
)  # fmt: skip
def test_wrong_shapes_are_told(student: str, said: str) -> None:
    judged = judge_matrix(student, J, DOMAIN, "s")
    assert judged.outcome is Outcome.WRONG
    assert said in judged.reason


def test_a_vector_may_lie_or_stand() -> None:
    reference = [["a1"], ["a2"], ["a3"]]
    for student in ("[a1, a2, a3]", "[[a1], [a2], [a3]]", "[[a1, a2, a3]]", "a1, a2, a3"):
        assert judge_matrix(student, reference, DOMAIN, "s").outcome is Outcome.CORRECT


def test_zero_entries_accept_rounding_noise_and_nothing_else() -> None:
    reference = [["0"], ["cos(theta1)"]]
    assert judge_matrix("[6.123233995736766e-17*a1, cos(theta1)]", reference, DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_matrix("[1e-7*a1, cos(theta1)]", reference, DOMAIN, "s").outcome is not Outcome.CORRECT


def test_numbers_to_three_digits() -> None:
    def outcome(student: str) -> Outcome:
        return judge_numbers(student, [1.0045, -0.2], ["rad/s", "rad/s"], 0.005, 0.001).outcome

    assert outcome("[1.00, -0.2]") is Outcome.CORRECT
    assert outcome("[1.0045, -1/5]") is Outcome.CORRECT
    assert outcome("[1.0, -0.21]") is Outcome.PARTIAL
    assert outcome("[57.55, -11.46]") is Outcome.WRONG
    assert outcome("[nan, -0.2]") is Outcome.WRONG
    assert outcome("[blank, blank]") is Outcome.MISSING
    assert outcome("[theta1, -0.2]") is Outcome.WRONG
    assert outcome("1.0") is Outcome.WRONG


@pytest.mark.parametrize("student", ["B", "b", '"B"', "(B)", "B.", "an internal singularity"])
def test_choice_accepts_letter_and_text(student: str) -> None:
    options = ("a boundary singularity", "an internal singularity", "none")
    assert judge_choice(student, options, 1).outcome is Outcome.CORRECT
    assert judge_choice(student, options, 0).outcome is Outcome.WRONG


def test_choice_blank_or_unknown() -> None:
    assert judge_choice("blank", ("x", "y"), 0).outcome is Outcome.MISSING
    assert judge_choice("C", ("x", "y"), 0).outcome is Outcome.WRONG


SHOULDER = "Eq(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3), 0)"


@pytest.mark.parametrize(
    "student",
    [
        f"[Eq(sin(theta3), 0), {SHOULDER}]",
        f"[{{theta3: [0, pi]}}, {SHOULDER}]",
        f"[{{theta3: {{-pi, 0}}}}, {SHOULDER}]",
        f"theta3 in {{0, pi}}, {SHOULDER}",
        f"theta3 = k*pi, {SHOULDER}",
        f"[sin(theta3), {SHOULDER}]",
        f"Or(Eq(tan(theta3), 0), {SHOULDER})",
        "sin(theta3)*(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3)) = 0",
        f"[blank, Eq(sin(theta3)**2, 0), {SHOULDER}]",
    ],
)
def test_singular_sets_in_many_forms(student: str) -> None:
    assert judge_singular(student, ELBOW, JOINTS, DOMAIN, "s").outcome is Outcome.CORRECT


@pytest.mark.parametrize(
    ("student", "outcome"),
    [
        ("[Eq(sin(theta3), 0)]", Outcome.PARTIAL),
        (f"[Eq(theta3, 0), {SHOULDER}]", Outcome.PARTIAL),
        (f"[Eq(sin(theta2), 0), Eq(sin(theta3), 0), {SHOULDER}]", Outcome.PARTIAL),
        ("[Eq(sin(theta2), 0), Eq(sin(theta3), 0)]", Outcome.PARTIAL),
        ("[Eq(sin(theta2), 0)]", Outcome.WRONG),
        ("[{theta3: [0, 180]}]", Outcome.PARTIAL),
        ("[blank]", Outcome.MISSING),
        ("[]", Outcome.WRONG),
        ("Eq(cos(theta1)**2 + sin(theta1)**2, 1)", Outcome.WRONG),
        ("[0, pi]", Outcome.WRONG),
        ("True", Outcome.WRONG),
    ],
)
def test_missing_and_surplus_conditions(student: str, outcome: Outcome) -> None:
    assert judge_singular(student, ELBOW, JOINTS, DOMAIN, "s").outcome is outcome


def test_bare_values_are_refused_where_several_joints_could_be_meant() -> None:
    """The reference is nobody to ask: it would make {0, pi} right for any joint."""
    for text in ("{0, pi}", "[0, pi]", "k*pi", "0, pi"):
        judged = judge_singular(text, ["sin(theta2) = 0"], JOINTS, DOMAIN, "s")
        assert judged.outcome is Outcome.WRONG and "say which joint has these values, as in" in judged.reason, text
    alone = Domain({"theta1": "angle"})
    assert judge_singular("{0, pi}", ["sin(theta1) = 0"], ["theta1"], alone, "s").outcome is Outcome.CORRECT


def test_conditions_that_hold_together() -> None:
    reference = [f"theta2 = {p} and theta3 = {q}" for p in ("0", "pi") for q in ("0", "pi")]
    together = "And(Eq(sin(theta2), 0), Eq(sin(theta3), 0))"
    assert judge_singular(together, reference, JOINTS, DOMAIN, "s").outcome is Outcome.CORRECT
    assert (
        judge_singular("{theta2: [0, pi], theta3: [0, pi]}", reference, JOINTS, DOMAIN, "s").outcome is Outcome.CORRECT
    )
    assert (
        judge_singular("sin(theta2) = 0, sin(theta3) = 0", reference, JOINTS, DOMAIN, "s").outcome
        is not Outcome.CORRECT
    )
    assert judge_singular("And(Eq(theta2, 0), Eq(theta3, 0))", reference, JOINTS, DOMAIN, "s").share == pytest.approx(
        2 / 3
    )


def test_angles_are_equal_modulo_whole_turns() -> None:
    assert judge_angles("{2*pi, 3*pi}", "{0, pi}", DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_angles("{0, pi/2, pi}", "{0, pi}", DOMAIN, "s").outcome is Outcome.PARTIAL
    assert judge_angles("{0, 3.14}", "{0, pi}", DOMAIN, "s").outcome is not Outcome.CORRECT


THREE = [f"theta2 = {p} and theta3 = {q}" for p in ("0", "pi") for q in ("0", "pi")]
SINE, FACTORS = ["sin(theta3) = 0"], ["sin(theta3) = 0", "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) = 0"]
ANGLE = "acos((-a1 - a2*cos(theta2))/a3)"


@pytest.mark.parametrize(
    ("reference", "student"),
    [
        (SINE, "cos(theta3)**2 = 1"),
        (SINE, "cos(theta3) = 1 or cos(theta3) = -1"),
        (SINE, "sin(theta3)**2 = 0"),
        (SINE, "1 - cos(2*theta3) = 0"),
        (SINE, "abs(cos(theta3)) = 1"),
        (SINE, "1e-9*sin(theta3) = 0"),
        (
            SINE,
            "theta3 in Union(ImageSet(Lambda(_n, 2*_n*pi + pi), Integers), ImageSet(Lambda(_n, 2*_n*pi), Integers))",
        ),
        (FACTORS, f"sin(theta3)**3 = 0, {SHOULDER}"),
        (FACTORS, f"theta3 = 0 or pi, {SHOULDER}"),
        (FACTORS, f"theta3 = 0, pi, {SHOULDER}"),
        (FACTORS, f"[(theta3, [0, pi]), {SHOULDER}]"),
        (FACTORS, f"[(theta3, 0), (theta3, pi), {SHOULDER}]"),
        (FACTORS, f"sin(theta3) = 0, theta3 = -theta2 + {ANGLE}, theta3 = -theta2 - {ANGLE}"),
        (FACTORS, f"sin(theta3) = 0, cos(theta2) = 2, {SHOULDER}"),
        (
            THREE,
            (
                "a1**2*a2**2*sin(theta2)**2 + a2**2*a3**2*sin(theta3)**2"
                " + a1**2*(a2*sin(theta2) + a3*sin(theta2 + theta3))**2 = 0"
            ),
        ),
    ],
)
def test_conditions_of_any_order_and_scale_are_right(reference: list[str], student: str) -> None:
    reference = ["theta3 = 0", "theta3 = pi"] if student.startswith("Union") else reference
    assert judge_singular(student, reference, JOINTS, DOMAIN, "s").outcome is Outcome.CORRECT


@pytest.mark.parametrize(
    ("reference", "student"),
    [
        (SINE, "1e-13 = 0"),
        (SINE, "Eq(1e-13*cos(theta1)**2 + 1e-13*sin(theta1)**2 + 0*theta1, 0)"),
        (ELBOW, "theta3 = 0 or theta3 = pi or 1e-10 = 0"),
        (ELBOW, "Eq(1e-10*theta3, 0)"),
        (SINE, "theta3 = 0, pi, sqrt(cos(theta1)) = 0"),
        (SINE, "theta3 = pi"),
        (SINE, "theta3 = 0"),
        (SINE, "theta3 = 0, theta3 = 3.1416"),
        (SINE, "theta3 = 0.000001, theta3 = pi"),
        (FACTORS, f"sin(theta3) = 0, theta3 = -theta2 + {ANGLE}"),
        (FACTORS, "sin(theta3) = 0, a1 + a2*cos(theta2) + a3*cos(theta2 + theta3) + 1e-6 = 0"),
    ],
)
def test_what_holds_nowhere_or_beside_is_not_right(reference: list[str], student: str) -> None:
    assert judge_singular(student, reference, JOINTS, DOMAIN, "s").outcome is not Outcome.CORRECT


def test_vectors_of_rates_as_sympy_solves_them() -> None:
    reference, labels = [["qd2*a1"], ["a2"]], ("qd1", "qd2")
    for student in (
        "{qd1: qd2*a1, qd2: a2}",
        "[{qd2: a2, qd1: qd2*a1}]",
        "{(qd2*a1, a2)}",
        "[Eq(qd1, a1*qd2), Eq(qd2, a2)]",
    ):
        assert judge_matrix(student, reference, DOMAIN, "s", labels).outcome is Outcome.CORRECT
    assert judge_matrix("{qd1: a2, qd2: a1}", reference, DOMAIN, "s", labels).outcome is Outcome.WRONG
    assert judge_numbers("{qd2: 2.0, qd1: 1.0}", [1, 2], ["", ""], 0.005, 0.001, labels).outcome is Outcome.CORRECT


def test_plausible_ways_to_write_an_answer() -> None:
    assert judge_expression("detJ = a1*a2", "a1*a2", DOMAIN, "s").outcome is Outcome.CORRECT
    text = "a1*cos(theta1(t))*Derivative(theta1(t), t)"
    assert judge_expression(text, "a1*cos(theta1)*qd1", DOMAIN, "s").outcome is Outcome.CORRECT
    columns = "[[[0], [0], [1]], [[a1], [0], [1]]]"
    assert judge_matrix(columns, [["0", "a1"], ["0", "0"], ["1", "1"]], DOMAIN, "s").outcome is Outcome.CORRECT
    options = ("a boundary singularity", "an internal singularity", "no singularity: full rank")
    for student in ("C. no singularity", "C) whatever", "no singularity", "c"):
        assert judge_choice(student, options, 2).outcome is Outcome.CORRECT
    assert judge_choice("singularity", options, 2).outcome is Outcome.WRONG


def test_a_blank_costs_itself_only() -> None:
    reference = [["0", "a1"], ["0", "a2"]]
    assert judge_matrix("[[blank, a1], [blank, a2]]", reference, DOMAIN, "s").share == 0.5
    assert judge_matrix("[[blank, a1], [blank, a2]]", reference, DOMAIN, "s").outcome is Outcome.PARTIAL
    judged = judge_singular(
        "[blank, Eq(theta2, blank), Eq(theta2, pi)]", ["theta2 = 0", "theta2 = pi"], JOINTS, DOMAIN, "s"
    )
    assert judged.share == pytest.approx(2 / 3)


def test_an_unknown_symbol_is_named_first() -> None:
    judged = judge_expression("k*a1", "a1", DOMAIN, "s")
    assert judged.reason.startswith("'k' is no symbol of this problem; known: L, a1,")


def test_a_bare_joint_or_value_is_asked_about() -> None:
    assert "stands alone" in judge_singular("theta2", SINE, JOINTS, DOMAIN, "s").reason


# --- values of joints, to the last digit ---


@pytest.mark.parametrize(
    ("student", "right", "said"),
    [
        ("{theta2: [0, pi]}", True, ""),
        ("{theta2: [0.0, 3.141592653589793]}", True, ""),
        ("theta2 = k*pi", True, ""),
        ("{theta2: [0, 3.14159265358979]}", False, "right but for rounding"),
        ("{theta2: [0, 3.1416]}", False, "right but for rounding"),
        ("{theta2: [0, 2.9]}", False, "no singular configuration: theta1 ="),
        ("theta2 = k*180", False, "these values are in degrees, and radians are due"),
        ("theta2 in {0, 180}", False, "these values are in degrees, and radians are due"),
        ("theta2 = 0", False, "a singular configuration is missing"),
    ],
)
def test_values_are_exact_doubles_or_wrong(student: str, right: bool, said: str) -> None:
    judged = judge_singular(student, ["sin(theta2) = 0"], ["theta1", "theta2"], DOMAIN, "s")
    assert (judged.outcome is Outcome.CORRECT) == right
    assert said in judged.reason


def test_all_values_of_a_whole_number_are_meant() -> None:
    for student, reference in (
        ("k*pi/6", "sin(6*theta2)"),
        ("pi/4 + n*pi/2", "cos(2*theta2)"),
        ("-k*pi", "sin(theta2)"),
    ):
        judged = judge_singular(f"theta2 = {student}", [f"{reference} = 0"], ["theta1", "theta2"], DOMAIN, "s")
        assert judged.outcome is Outcome.CORRECT, judged.reason


def test_a_comma_may_stand_for_the_point_of_a_decimal() -> None:
    assert judge_expression("0,5*a1*cos(theta1)", "a1*cos(theta1)/2", DOMAIN, "s").outcome is Outcome.CORRECT
    assert judge_expression("1,2", "a1", DOMAIN, "s").outcome is Outcome.WRONG
    assert "list" in judge_expression("a1, a2", "a1", DOMAIN, "s").reason
    assert judge_expression("atan2(0,1)", "0", DOMAIN, "s").outcome is Outcome.CORRECT


# --- lengths that are given, by name ---

GIVEN = Domain(
    {"theta1": "angle", "theta2": "angle", "a1": 0.3, "a2": Fraction(1, 2), "a3": Fraction(1, 3), "d1": 0.5**0.5}
)


@pytest.mark.parametrize(
    ("student", "reference", "right"),
    [
        ("a1*cos(theta1)", "3/10*cos(theta1)", True),
        ("sqrt(a1^2)*cos(theta1)", "3/10*cos(theta1)", True),
        ("a3*cos(theta1)", "cos(theta1)/3", True),
        ("sqrt(a3)^2*cos(theta1)", "cos(theta1)/3", True),
        ("d1*cos(theta1)", "sqrt(2)/2*cos(theta1)", True),
        ("sqrt(d1^2)*cos(theta1)", "sqrt(2)/2*cos(theta1)", True),
        ("0.3333333333333333*cos(theta1)", "cos(theta1)/3", True),
        ("0.3333*cos(theta1)", "cos(theta1)/3", False),
        ("a3*cos(theta1)", "0.3333*cos(theta1)", False),
        ("d1*cos(theta1)", "0.7071*cos(theta1)", False),
        ("a1*cos(theta1)", "cos(theta1)/3", False),
    ],
)
def test_given_lengths_are_exact_by_name(student: str, reference: str, right: bool) -> None:
    assert (judge_expression(student, reference, GIVEN, "s").outcome is Outcome.CORRECT) == right


def test_a_singular_set_may_name_given_lengths() -> None:
    values = "theta2 in {acos(-3/5), -acos(-3/5)}"
    for student in ("a1 + a2*cos(theta2) = 0", "{theta2: [acos(-a1/a2), -acos(-a1/a2)]}", "cos(theta2) = -3/5"):
        for reference in (values, "3/10 + cos(theta2)/2 = 0"):
            judged = judge_singular(student, [reference], ["theta1", "theta2"], GIVEN, "s")
            assert judged.outcome is Outcome.CORRECT, (student, reference, judged.reason)
    judged = judge_singular("a1 + d1*cos(theta2) = 0", [values], ["theta1", "theta2"], GIVEN, "s")
    assert judged.outcome is Outcome.WRONG
    roots = "theta2 in {acos(-3*sqrt(2)/10), -acos(-3*sqrt(2)/10)}"
    judged = judge_singular("d1*cos(theta2) + a1 = 0", [roots], ["theta1", "theta2"], GIVEN, "s")
    assert judged.outcome is Outcome.CORRECT, judged.reason
