"""What a worked solution says of its steps is so for the arm that it is about."""

import pytest

from exercises import generate, show
from exercises.problem import Problem
from exercises.quizzes import ASKED
from exercises.writing.statement import hints, prompt, statement, worked_solution, worked_solutions
from exercises.writing.worked import Worked


def solved(problem_id: str, *names: str) -> dict[str, str]:
    """Return the solutions of some questions in one text."""
    return worked_solutions(generate(problem_id, list(names)))


@pytest.mark.parametrize(
    ("problem_id", "inverse", "rates"),
    [
        ("cartesian/738@zeros", False, False),
        ("polar-rp/837@frames@modified-dh", False, False),
        ("planar-rpr/835@frames", False, False),
        ("random-3/638@chapter@modified-dh", False, False),
        ("planar-3r-pose/819@lengths", True, True),
        ("planar-3r-pose/30003@lengths", True, True),  # 9/40 over 3/10: a length has cancelled
        ("wrist-zyz/241@lengths", True, True),
        ("elbow/640@lengths", True, True),
    ],
)
def test_factors_cancel_where_it_is_said(problem_id: str, inverse: bool, rates: bool) -> None:
    problem = generate(problem_id, ["inverse-jacobian", "inverse-velocity"])
    steps = Worked(problem.chain)
    assert (steps.inverse_cancels, steps.rates_cancel) == (inverse, rates)
    texts = {part.kind: worked_solution(problem, part) for part in problem.parts}
    assert ("common factors cancel" in texts["inverse-jacobian"]) == (inverse and problem.chain.n > 2)
    assert ("after cancelling common factors" in texts["inverse-velocity"]) == rates


def test_the_rates_go_on_from_the_inverse_that_was_found() -> None:
    both = solved("elbow-lateral/607@zeros", "inverse-jacobian", "inverse-velocity")["inverse-velocity"]
    alone = solved("elbow-lateral/607@zeros", "inverse-velocity")["inverse-velocity"]
    assert "With the inverse found above, row by row:" in both and r"\begin{bmatrix}" not in both
    assert "as the transposed cofactors" in alone and r"\begin{bmatrix}" in alone


def test_signs_are_alike_in_a_row_of_the_inverse() -> None:
    text = solved("elbow-lateral/607@zeros", "inverse-jacobian", "inverse-velocity")
    assert "-0.45 c_{2} + a_{3}" not in text["inverse-jacobian"].partition("common factors")[2]
    for problem_id in ("elbow-lateral/295@full@screws", "spherical-offset/339@chapter"):
        rates = solved(problem_id, "inverse-jacobian", "inverse-velocity")["inverse-velocity"]
        assert "(-" not in rates


def test_squares_are_taken_together_in_an_inverse() -> None:
    text = solved("orthogonal-3r/647@frames", "inverse-jacobian")["inverse-jacobian"]
    assert "0.5 c_{2}^{2}" in text and "0.5 s_{2}^{2}" not in text


@pytest.mark.parametrize(("problem_id", "always"), [("cartesian/738@zeros", True), ("elbow/640@lengths", False)])
def test_an_inverse_that_always_exists_is_asked_for_without_more(problem_id: str, always: bool) -> None:
    problem = generate(problem_id, ["inverse-jacobian", "inverse-velocity"])
    inverse, rates = (prompt(problem, part) for part in problem.parts)
    assert ("in which it exists" in inverse) != always and ("is invertible" in rates) != always


def test_headings_are_true_of_the_arm() -> None:
    wrist, slides, plain = (
        show(generate(problem_id, ["jacobian", "joint-torques"]))
        for problem_id in ("wrist-zyz/241@lengths", "cartesian/738@zeros", "planar-2r/1")
    )
    assert "Jacobian from the joint axes" in wrist and "by differentiation" not in wrist.partition("1. ")[2]
    assert "Static joint forces" in slides and "Static joint torques" in plain and "Jacobian by diff" in plain
    assert ASKED["joint-torques"].heading(generate("scara/1", ["jacobian"]).chain) == "Static joint torques and forces"


def test_the_jacobian_of_a_wrist_is_made_of_axes_that_are_found() -> None:
    texts = solved("wrist-zyz/241@lengths", "jacobian", "joint-axes")
    assert "the last column of $R_{i-1}$" in texts["jacobian"] and "Side by side, they are" in texts["jacobian"]
    assert "The axes have been found above" in texts["joint-axes"] and "$R_{i-1}$" not in texts["joint-axes"]
    assert "the last column of $R_{i-1}$" in solved("wrist-zyz/241@lengths", "joint-axes")["joint-axes"]


def test_one_joint_slides_along_its_axis() -> None:
    text = solved("planar-pr/675@chapter", "link-velocity")["link-velocity"]
    assert "Only joint 1 moves frame 1. It slides along its axis:" in text


@pytest.mark.parametrize(
    ("problem_id", "turned"),
    [("planar-2r/416@frames", False), ("planar-3r/550@chapter", False), ("scara/808@lengths", True)],
)
def test_a_half_twist_is_told_where_there_is_one(problem_id: str, turned: bool) -> None:
    assert ("a twist of 180° reverses the axes that follow" in solved(problem_id, "joint-axes")["joint-axes"]) == turned


SCREWS = (
    "home-screws", "position", "joint-axes", "joint-effect", "geometric-jacobian", "space-jacobian",
    "space-twist", "body-pose",
)  # fmt: skip


def told(problem: Problem) -> str:
    """Return statement, hints and solutions."""
    parts = [text for part in problem.parts for text in (*hints(problem, part), worked_solution(problem, part))]
    return "".join((statement(problem, ""), *parts))


def test_slides_are_spoken_of_where_there_are_some() -> None:
    revolute = told(generate("elbow-lateral/295@full@screws", list(SCREWS)))
    wrist = told(generate("wrist-rpy/745@zeros@screws", ["jacobian", "joint-axes"]))
    assert not [word for word in ("slide", "prismatic", "v_i'", "v_{i}'") if word in revolute + wrist]
    both = told(generate("scara/1@chapter@screws", ["position", "joint-axes", "space-jacobian", "space-twist"]))
    assert "a prismatic one slides along" in both and "v_i'" in both
