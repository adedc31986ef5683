"""What an answer earns that is right in part, and how an assignment sets it."""

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

from exercises.answers import Expression
from exercises.arm.chain import Chain
from exercises.assignment import load_assignment
from exercises.credit import OWN, WAYS, Credit, read_credit
from exercises.docs import planar_2r, scorbot_arm
from exercises.errors import QdotError
from exercises.formula.text import text_of
from exercises.release import init_assignment
from grader.verdict import Judgement, Outcome
from tests.support.judging import earned as share_earned
from tests.support.problems import asked

PLANAR, SCORBOT = planar_2r(), scorbot_arm()
DETERMINANT = "a2*a3*(a1 + a2*cos(theta2) + a3*cos(theta2 + theta3))*sin(theta3)"
J_WITHOUT = "[[-a1*sin(theta1) - a2*sin(theta1 + theta2), SECOND], [a1*cos(theta1) + a2*cos(theta1 + theta2), THIRD]]"


def earned(question: str, answer: str, credit: Credit = OWN, chain: Chain = PLANAR) -> Judgement:
    problem = asked(question, chain)
    part = replace(problem.parts[0], credit=credit)
    return share_earned(problem, part, answer, "credit")


@pytest.mark.parametrize(
    ("answer", "share"),
    [
        ("a1*a2*sin(theta2)", 1.0),
        ("-a1*a2*sin(theta2)", 0.8),
        ("a2*sin(theta2)", 0.8),
        ("2*a2*sin(theta2)", 0.6),
        ("a1*a2*cos(theta2)", 0.0),
        ("a1*a2", 0.0),
        ("a1*(a2 + a1)*sin(theta2)", 0.0),
        ("a1*a2*sin(theta2)*cos(theta1)", 0.0),
        ("a1*a1*a2*sin(theta2)", 0.0),
        ("sin(theta2)*(a1*a2 + 0)/a1", 0.8),
        ("0", 0.0), ("1", 0.0), ("a1/0", 0.0), ("x*a1*a2", 0.0), ("[a1, a2]", 0.0), ("{{", 0.0),
    ],
)  # fmt: skip
def test_a_determinant_is_marked_by_its_factors(answer: str, share: float) -> None:
    found = earned("determinant", answer)
    assert found.share == share
    assert found.outcome is (Outcome.CORRECT if share == 1 else Outcome.PARTIAL if share else Outcome.WRONG)


def test_each_factor_that_is_there_counts_and_the_reason_says_so(family: str, drawn: object) -> None:
    problem = drawn(family, 0)  # type: ignore[operator]
    for part in problem.parts:
        if part.kind != "determinant" or not isinstance(part.answer, Expression):
            continue
        _, product = part.answer.reference.as_coeff_Mul()
        factors = [factor for factor in product.as_ordered_factors() if factor.free_symbols]
        for left_out in factors if 1 < len(factors) <= 6 else ():
            answer = text_of(part.answer.reference / left_out)
            judgement = share_earned(problem, part, answer, "f")
            weights = [2 if factor.free_symbols & set(problem.chain.q) else 1 for factor in factors]
            lost = weights[factors.index(left_out)]
            if lost == 1 or weights.count(2) > 1:
                assert judgement.share == pytest.approx(1 - lost / (sum(weights) + 1)), (answer, judgement)
                assert f"{len(factors) - 1} of {len(factors)} factors are right" in judgement.reason
            else:
                assert judgement.share == 0.0


def test_the_factor_that_ties_joints_counts_as_one() -> None:
    assert earned("determinant", DETERMINANT, chain=SCORBOT).share in (6 / 7, 1.0)  # the sign is a matter of the frames
    without = DETERMINANT.replace("*sin(theta3)", "")
    assert earned("determinant", without, chain=SCORBOT).share in (4 / 7, 5 / 7)


def test_a_matrix_is_marked_by_entries_or_columns_or_as_a_whole() -> None:
    one_wrong = J_WITHOUT.replace("SECOND", "-a2*sin(theta1 + theta2)").replace("THIRD", "a2*sin(theta2)")
    assert earned("jacobian", one_wrong).share == 0.75
    by_columns = earned("jacobian", one_wrong, Credit("columns"))
    assert by_columns.share == 0.5 and by_columns.reason.startswith("1 of 2 columns are right")
    assert earned("jacobian", one_wrong, Credit("whole")).outcome is Outcome.WRONG
    assert earned("jacobian", one_wrong, Credit("", Fraction(1, 2))).share == 0.375


def test_no_way_gives_full_marks_for_what_is_not_right_or_takes_any_from_what_is() -> None:
    right = J_WITHOUT.replace("SECOND", "-a2*sin(theta1 + theta2)").replace("THIRD", "a2*cos(theta1 + theta2)")
    for by in WAYS:
        assert earned("jacobian", right, Credit(by)).share == 1.0
        assert earned("jacobian", right.replace("a2*cos", "a1*cos"), Credit(by)).share < 1.0
        assert earned("singular-angles", "theta2 = 0", Credit(by)).share == (0.0 if by == "whole" else 0.5)


TOML = """title = "T"
key = "t"
follow_through = 1
[[problem]]
family = "planar-2r"
questions = ["jacobian", "determinant"]
"""


def test_an_assignment_says_how_and_a_mistake_in_it_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "hw"
    init_assignment(folder, "T", "t", secret="0123456789abcdef")
    file = folder / "assignment.toml"
    file.write_text(TOML + 'credit = {jacobian = "columns", determinant = 0.5}\n')
    assignment = load_assignment(folder)
    parts = {part.name: part for part in assignment.slots[0].problem(assignment.secret, "s").parts}
    assert parts["jacobian"].credit == Credit("columns") and parts["determinant"].credit == Credit("", Fraction(1, 2))
    assert assignment.follow_through == 1
    before = assignment.marking
    file.write_text(TOML + "credit = 0\n")
    assert load_assignment(folder).marking != before
    for wrong in ('credit = "rows"', "credit = 2", "credit = true", 'credit = {rank = "whole"}', "credit = [1]"):
        file.write_text(TOML + wrong + "\n")
        with pytest.raises(QdotError, match=r"assignment.toml: line 7.*credit"):
            load_assignment(folder)
    for wrong in ("follow_through = 1.5", 'follow_through = "80%"', "follow_through = true"):
        file.write_text(TOML.replace("follow_through = 1", wrong))
        with pytest.raises(QdotError, match=r"line 3.*from 0 to 1"):
            load_assignment(folder)


def test_nothing_said_is_each_questions_own_way() -> None:
    assert read_credit(None, ["jacobian"]) == ()
    assert read_credit("whole", ["jacobian"]) == (("jacobian", Credit("whole")),)
