"""Texts on partial credit, follow-through and blanks are true and tell students what to do next."""

from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ProblemId
from qdot.grader.judging.verdict import Verdict
from qdot.grader.marking.marking import mark
from qdot.grader.reports.feedback_levels import remove_numbers

QUESTIONS = ("position", "jacobian", "determinant")
RELATIVE_POSITION = "[a1*cos(theta1) + a2*cos(theta2), a1*sin(theta1) + a2*sin(theta2)]"
RELATIVE_JACOBIAN = "[[-a1*sin(theta1), -a2*sin(theta2)], [a1*cos(theta1), a2*cos(theta2)]]"


def mark_answers(**answers: str) -> dict[str, Verdict]:
    problem = generate(ProblemId("planar-2r", 1, QUESTIONS, variation="chapter"))
    return {verdict.part: verdict for verdict in mark(problem, answers, secret="s")}


def test_a_part_that_follows_states_one_share_of_the_points() -> None:
    verdicts = mark_answers(position=RELATIVE_POSITION, jacobian=RELATIVE_JACOBIAN)
    assert "so you earn half of the points" in verdicts["position"].judgement.reason
    reason = verdicts["jacobian"].judgement.reason
    assert "it earns 80 % of the points" in reason and "you earn" not in reason


def test_a_blank_from_an_earlier_part_is_named() -> None:
    verdicts = mark_answers(jacobian="[[blank, a1], [a2, blank]]", determinant="a1*a2*blank + a2")
    assert "Fill in 'jacobian' first" in verdicts["determinant"].judgement.reason
    assert "2 entries still contain a blank" in verdicts["jacobian"].judgement.reason


def test_a_mistake_that_can_be_made_anywhere_refers_to_the_question() -> None:
    position = "[a1*cos(theta1) + a2*cos(theta1 + theta2), -a1*sin(theta1) + a2*sin(theta1 + theta2)]"
    diagnosis = mark_answers(position=position)["position"].diagnosis
    assert diagnosis is not None and diagnosis.feedback.endswith("See (6.1).")


def test_a_capital_letter_does_not_reveal_a_missing_configuration() -> None:
    assert remove_numbers("Compared with the solution: a singular configuration is missing: theta2 = 0.5") == (
        "Compared with the solution: a singular configuration is missing"
    )
