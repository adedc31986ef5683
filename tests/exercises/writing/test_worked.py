"""What a worked solution says of its steps, and of singular configurations, is so for the arm that it is about."""

import re
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

from exercises import show
from exercises.arm.chain import CONVENTIONS
from exercises.arm.directions import task_rows
from exercises.arm.kinematics import NumericChain
from exercises.arm.told import told_words
from exercises.families import FAMILIES
from exercises.generation import generate, sample_chain
from exercises.problem import Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.inversion import InSituation
from exercises.questions.rank import OfMotion
from exercises.quizzes import ASKED
from exercises.writing.statement import hints, prompt, statement, worked_solution, worked_solutions, worked_steps
from exercises.writing.worked import Worked
from tests.support.suites import of_families


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
    assert ("common factors" in texts["inverse-jacobian"]) == (inverse and problem.chain.n > 2)
    assert ("common factors" in texts["inverse-velocity"]) == rates


BOTH = ("inverse-jacobian", "inverse-velocity")
TABLE = r"\begin{bmatrix}"
LAST_COLUMN = "the last column of $R_{i-1}$"
SAYS = [
    # problem, questions, the one that is looked at, what its solution says, and what it does not say
    ("elbow-lateral/607@zeros", BOTH, 1, "found above", TABLE),  # the rates go on from the inverse
    ("elbow-lateral/607@zeros", BOTH[1:], 0, TABLE, "found above"),
    ("elbow-lateral/607@zeros", BOTH, 0, "", "-0.45 c_{2} + a_{3}"),  # signs are alike in a row
    ("elbow-lateral/295@full@screws", BOTH, 1, "", "(-"),
    ("spherical-offset/339@chapter", BOTH, 1, "", "(-"),
    ("orthogonal-3r/647@frames", BOTH[:1], 0, "0.5 c_{2}^{2}", "0.5 s_{2}^{2}"),  # squares are taken together
    ("wrist-zyz/241@lengths", ("jacobian", "joint-axes"), 0, LAST_COLUMN, "found above"),
    ("wrist-zyz/241@lengths", ("jacobian", "joint-axes"), 1, "found above", "$R_{i-1}$"),
    ("wrist-zyz/241@lengths", ("joint-axes",), 0, LAST_COLUMN, "found above"),
    ("planar-pr/675@chapter", ("link-velocity",), 0, "slides along its axis", "turns about"),
    ("planar-2r/416@frames", ("joint-axes",), 0, "", "180°"),  # no half twist
    ("planar-3r/550@chapter", ("joint-axes",), 0, "", "180°"),
    ("scara/808@lengths", ("joint-axes",), 0, "180°", "found above"),
]


@pytest.mark.parametrize(("problem_id", "names", "which", "there", "not_there"), SAYS)
def test_steps_are_told_as_they_are_for_this_arm(
    problem_id: str, names: tuple[str, ...], which: int, there: str, not_there: str
) -> None:
    text = worked_solutions(generate(problem_id, list(names)))[names[which]].rpartition("common factors")[2]
    assert there in text and not_there not in text


@pytest.mark.parametrize(("problem_id", "always"), [("cartesian/738@zeros", True), ("elbow/640@lengths", False)])
def test_an_inverse_that_always_exists_is_asked_for_without_more(problem_id: str, always: bool) -> None:
    problem = generate(problem_id, list(BOTH))
    inverse, rates = (prompt(problem, part) for part in problem.parts)
    assert ("exists" in inverse) != always and ("invertible" in rates) != always


def test_headings_are_true_of_the_arm() -> None:
    wrist, slides, plain = (
        show(generate(problem_id, ["jacobian", "joint-torques"]))
        for problem_id in ("wrist-zyz/241@lengths", "cartesian/738@zeros", "planar-2r/1")
    )
    assert "Jacobian from the joint axes" in wrist and "by differentiation" not in wrist.partition("1. ")[2]
    assert "Static joint forces" in slides and "Static joint torques" in plain and "Jacobian by diff" in plain
    assert ASKED["joint-torques"].heading(generate("scara/1", ["jacobian"]).chain) == "Static joint torques and forces"


SCREWS = (
    "home-screws", "position", "joint-axes", "joint-effect", "geometric-jacobian", "space-jacobian",
    "space-twist", "body-pose",
)  # fmt: skip


def told(problem_id: str, *names: str) -> str:
    """Return statement, hints and solutions."""
    problem = generate(problem_id, list(names))
    parts = [text for part in problem.parts for text in (*hints(problem, part), worked_solution(problem, part))]
    return "".join((statement(problem, ""), *parts))


def test_slides_are_spoken_of_where_there_are_some() -> None:
    revolute = told("elbow-lateral/295@full@screws", *SCREWS)
    revolute += told("wrist-rpy/745@zeros@screws", "jacobian", "joint-axes")
    assert not [word for word in ("slide", "prismatic", "v_i'", "v_{i}'") if word in revolute]
    both = told("scara/1@chapter@screws", "position", "joint-axes", "space-jacobian", "space-twist")
    assert "prismatic" in both and "v_i'" in both


NAMES = {"dh": "$O_{2}$ lies", "modified-dh": "$O_{3}$ lies", "screws": "$q_{3}'$ lies"}
LEAST = "It holds somewhere only if"


def solution(identity: str, question: str, convention: str = "dh") -> str:
    problem = generate(replace(ProblemId.parse(identity), questions=(question,)).told(convention))
    (part,) = problem.parts
    return worked_solution(problem, part)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_an_origin_has_the_name_that_the_arms_convention_has_for_it(convention: str) -> None:
    """O_2 of the standard table is on the axis of joint 3: the origin of frame 3 of a modified one."""
    assert NAMES[convention] in solution("orthogonal-3r/776@frames", "singular-angles", convention)


def test_where_an_arm_has_no_name_for_an_origin_what_is_true_of_all_is_said() -> None:
    chain = sample_chain(ProblemId.parse("cylindrical/1@chapter").told("screws"))  # joints 2 and 3 are slides
    assert told_words(chain, "the origin O2 lies on the axis of joint 1") == "the columns of J are linearly dependent"


def test_values_that_are_of_different_kinds_are_told_apart_and_equal_ones_together() -> None:
    """Of a planar arm of three joints: stretched out, or folded back in any of three ways."""
    text = solution("planar-3r/550@chapter", "singular-angles")
    stretched, folded = (next(line for line in text.split("\n") if word in line) for word in ("stretched", "folded"))
    pair = r"\$\\theta_\{2\} = (0|180\^\\circ)\$ and \$\\theta_\{3\} = (0|180\^\\circ)\$"
    assert re.findall(pair, stretched.partition("stretched")[0]) == [("0", "0")]
    half = r"180^\circ"
    assert set(re.findall(pair, folded.partition("folded")[0])) >= {("0", half), (half, "0"), (half, half)}


@pytest.mark.whole  # see test_solving: the Scorbot's shoulder
def test_what_lengths_have_to_satisfy_is_told_where_a_condition_may_not_hold() -> None:
    assert rf"{LEAST} $a_{{1}} \le a_{{2}} + \sqrt{{" in solution("industrial-6r/305@chapter", "singular-angles")
    assert LEAST not in solution("elbow/1@chapter", "singular-angles")  # a2 c2 + a3 c23 = 0 holds somewhere for all


@of_families(tuple(FAMILIES))
def test_a_direction_that_is_lost_is_perpendicular_to_all_columns_that_are_shown(family: str) -> None:
    for step in ("chapter", "full"):
        problem = _asking(family, step, "lost-motion")
        if problem is None:
            return
        chain, (part,) = problem.chain, problem.parts
        example = worked_steps(chain).lost_example(part.about(OfMotion).asked.where)
        assert example is not None
        jacobian, lost = (np.array(matrix.tolist(), dtype=float) for matrix in (example.jacobian, example.lost))
        assert np.abs(jacobian.T @ lost).max() < 2e-3 * np.abs(jacobian).max()
        if not example.about:
            arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in example.lengths.items()})
            own = arm.jacobian(np.array([float(sp.N(example.joints[q])) for q in chain.q]))[task_rows(chain)]
            assert np.allclose(own, jacobian, rtol=1e-3, atol=1e-4)
        is_long = worked_steps(chain).lost_where(part.about(OfMotion).asked.where) is None
        assert is_long == ("In numbers, " in worked_solution(problem, part))


def _asking(family: str, step: str, question: str) -> Problem | None:
    identity = ProblemId(family, 3).varied(step)
    if QUESTIONS[question].objects(sample_chain(identity)) is not None:
        return None
    return generate(replace(identity, questions=(question,)))


@pytest.mark.parametrize("family", ["stanford-6r", "puma-560", "anthropomorphic-6r"])
def test_rates_by_blocks_are_the_reference(family: str) -> None:
    problem = generate(ProblemId(family, 4, ("joint-rates",)).varied("zeros"))
    (part,) = problem.parts
    blocks = worked_steps(problem.chain).rates_by_blocks(part.about(InSituation).situation)
    assert blocks is not None
    shown = np.array([*blocks.first, *blocks.last], dtype=float)
    assert np.allclose(shown, np.array(part.answer.as_matrix(), dtype=float).ravel(), rtol=1e-3, atol=1e-6)
    for inverse, right, rates in ((blocks.arm, blocks.linear, blocks.first), (blocks.wrist, blocks.left, blocks.last)):
        assert np.allclose(np.array(inverse * right - rates, dtype=float), 0, atol=5e-3)


def test_determinants_of_blocks_are_not_worked_out_twice() -> None:
    problem = generate(ProblemId("stanford-6r", 4, ("block-determinants", "determinant")).varied("zeros"))
    first, second = worked_solutions(problem).values()
    assert "found above" in second and "The wrist" not in second and "found above" not in first
