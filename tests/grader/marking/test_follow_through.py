"""Follow-through: later parts are marked on the student's earlier answers, and an easier problem earns nothing."""

import json
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import StageResults, compute_symbolic_stages, to_sympy_matrix
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.generation import generate
from qdot.exercises.mistakes.catalogue import CATALOGUE, apply_mistake
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.custom.definition import Definition, GivenValue, Texts
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step
from qdot.exercises.reference_answers import Expression
from qdot.grader.judging.verdict import Outcome, Verdict
from qdot.grader.marking.marking import MarkingRules, compute_points, mark, sum_points
from tests.support import DATA, read_cases
from tests.support.judging import list_earlier_parts
from tests.support.problems import get_problem
from tests.support.suites import SHAPES, few_families, on_families, sample_for_suite, select_for_suite

PLANAR, SCORBOT = make_planar_2r(), make_scorbot_arm()
QUESTION_NAMES = ("position", "jacobian", "determinant", "inverse-jacobian", "inverse-velocity", "singular-angles")


def make_problem(chain: Chain, names: tuple[str, ...] = QUESTION_NAMES) -> Problem:
    parts = []
    for name in names:
        question = QUESTIONS[name]
        answer, details = question.ask(chain, Stream(f"follow/{name}"))
        parts.append(Part(name, name, answer, question.points, question.prerequisites, details))
    return Problem(ProblemId("textbook", 1, names), chain, tuple(parts))


def mark_answers(problem: Problem, answers: dict[str, str], credit: Fraction = Fraction(4, 5)) -> dict[str, Verdict]:
    return {verdict.part: verdict for verdict in mark(problem, answers, secret="secret", rules=MarkingRules(credit))}


def write_answer(part: Part, stages: StageResults) -> str:
    matrix = to_sympy_matrix(compute_answer(stages, part))
    return format_expression(matrix[0]) if isinstance(part.answer, Expression) else str(matrix.tolist())


ANSWERS = json.loads((DATA / "followed_answers.json").read_text(encoding="utf-8"))
RELATIVE_ANGLES, TRICKS = ANSWERS["relative angles"], ANSWERS["tricks"]
"""What follows from relative angles in the position of the planar arm, and answers to easier, invented problems."""


def test_a_first_mistake_costs_a_fifth_of_later_parts() -> None:
    verdicts = mark_answers(make_problem(PLANAR), RELATIVE_ANGLES)
    first = verdicts.pop("position")
    assert (first.points, first.judgement.outcome, first.followed_from) == (0.5, Outcome.PARTIAL, None)
    assert first.diagnosis is not None and first.diagnosis.mistakes == ("relative-angle",)
    for verdict in verdicts.values():
        assert verdict.points == compute_points(verdict.max_points, 1.0, Fraction(4, 5)), verdict
        assert verdict.judgement.outcome is Outcome.PARTIAL
        assert verdict.followed_from in QUESTION_NAMES and "80 %" in verdict.judgement.reason
    assert verdicts["jacobian"].followed_from == "position"


def test_the_assignment_sets_the_credit_for_following() -> None:
    three_fifths = mark_answers(make_problem(PLANAR), RELATIVE_ANGLES, Fraction(3, 5))
    assert three_fifths["jacobian"].points == 1.2
    for as_much_or_less in (Fraction(1, 2), Fraction(0)):  # known as a mistake, it earns half
        jacobian = mark_answers(make_problem(PLANAR), RELATIVE_ANGLES, as_much_or_less)["jacobian"]
        assert jacobian.points == 1.0 and jacobian.followed_from is None


def test_an_answer_that_follows_from_an_attempt_and_from_no_attempt_is_followed_from_the_attempt() -> None:
    determinant = "a1*a2*sin(theta2 - theta1)*(2 + sin(3*theta1 + 5*theta2))"  # with the same zeros, but no attempt
    verdict = mark_answers(make_problem(PLANAR), {**RELATIVE_ANGLES, "determinant": determinant})["singular-angles"]
    assert verdict.followed_from == "jacobian" and verdict.points == compute_points(2, 1.0, Fraction(4, 5))


def test_nothing_follows_from_a_very_long_answer() -> None:
    position = RELATIVE_ANGLES["position"][:-1] + " + sin(theta1) - sin(theta1)" * 500 + "]"
    verdict = mark_answers(make_problem(PLANAR), {**RELATIVE_ANGLES, "position": position})["jacobian"]
    assert verdict.followed_from is None


def test_following_never_exceeds_full_marks_nor_lowers_right_answers() -> None:
    jacobian = write_answer(make_problem(PLANAR)["jacobian"], compute_symbolic_stages(PLANAR))
    verdicts = mark_answers(make_problem(PLANAR), {**RELATIVE_ANGLES, "jacobian": jacobian})
    assert verdicts["jacobian"].points == verdicts["jacobian"].max_points
    assert verdicts["determinant"].followed_from is None  # the earlier answer is right
    assert all((verdict.points or 0) <= verdict.max_points for verdict in verdicts.values())


def test_partial_credit_counts_if_it_is_higher() -> None:
    answers = {
        **RELATIVE_ANGLES,
        "jacobian": "[[-a1*sin(theta1) - a2*sin(theta1 + theta2), -a2*sin(theta1 + theta2)], [0, 0]]",
    }
    verdict = mark_answers(make_problem(PLANAR), answers)["jacobian"]
    assert verdict.points == 1.0 and verdict.followed_from is None


@pytest.mark.parametrize("trick", sample_for_suite(TRICKS, 5))
def test_easier_made_up_problems_earn_nothing(trick: str) -> None:
    names = tuple(name for name in QUESTION_NAMES if trick != "copied" or name in TRICKS["copied"])
    problem = make_problem(PLANAR, names)
    verdicts = mark_answers(problem, TRICKS[trick])
    assert all(verdict.followed_from is None for verdict in verdicts.values())
    for part in problem.parts:  # what agrees with the solution by chance counts as it would alone
        alone = mark_answers(problem, {part.name: TRICKS[trick].get(part.name, "")})[part.name]
        assert verdicts[part.name].points == alone.points, part.name
        assert alone.points is not None and alone.points <= 0.7 * part.points, part.name


def test_nothing_follows_from_an_answer_to_another_students_problem() -> None:
    names = ("position", "jacobian", "determinant")
    problem, answers = make_problem(PLANAR, names), {name: RELATIVE_ANGLES[name] for name in names}
    for rules, is_copied in ((MarkingRules(), False), (MarkingRules(is_copied=lambda part, rows: True), True)):
        verdicts = mark(problem, answers, secret="secret", rules=rules)
        assert [verdict.followed_from is None for verdict in verdicts] == [True, is_copied, is_copied]


def invent_answers(problem: Problem) -> dict[str, str]:
    """Return a position that ignores the arm, and the answers that follow from it."""
    q = problem.chain.q
    count = len(problem.chain.task)
    joints = [q[i % len(q)] for i in range(count + 1)]
    point = sp.Matrix([(i + 2) * sp.cos(joints[i] + i) + sp.sin(joints[i] - joints[i + 1]) for i in range(count)])
    jacobian = point.jacobian(q)
    answers = {"position": str(point.tolist()), "jacobian": str(jacobian.tolist())}
    if jacobian.rows == jacobian.cols:
        answers["determinant"] = str(jacobian.det())
        answers["singular-angles"] = f"Eq({jacobian.det()}, 0)"
    if jacobian.shape == (2, 2):
        inverse = jacobian.inv()
        answers["inverse-jacobian"] = str(inverse.tolist())
        answers["inverse-velocity"] = str((inverse * sp.Matrix(sp.symbols(problem.chain.task))).T.tolist()[0])
    return answers


@on_families(select_for_suite(("planar-2r",), tuple(SHAPES.values())))
def test_nothing_follows_from_answers_that_ignore_the_arm(family: str) -> None:
    problem = get_problem(family, 0)
    names = [part.name for part in problem.parts]
    is_point = set(problem.chain.task) <= {"vx", "vy", "vz"}
    if problem.chain.n > 3 or not is_point or not {"position", "jacobian"} <= set(names):
        return
    answers = {name: text for name, text in invent_answers(problem).items() if name in names}
    verdicts = mark_answers(problem, answers)
    assert [verdicts[name].points for name in answers] == [0.0] * len(answers)
    assert {verdicts[name].attempt for name in answers} <= {False, None}


INVENTED_DETERMINANT = "a1*a2*a3*sin(theta1)*sin(theta2)*sin(theta3)"
ALL_STRAIGHT = "[theta1 = 0, theta1 = pi, theta2 = 0, theta2 = pi, theta3 = 0, theta3 = pi]"
UNROTATED = "[[0, 0, 0], [0, 1, 1], [1, 0, 0]]"
X, Y, Z = (
    ["a1*c1 + a2*c1*c2 + a3*c1*c23", "a2*c1*c2 + a3*c1*c23", "a3*c1*c23"],
    ["a1*s1 + a2*s1*c2 + a3*s1*c23", "a2*s1*c2 + a3*s1*c23", "a3*s1*c23"],
    ["0", "-a2*s2 - a3*s23", "-a3*s23"],
)
FROM_UNROTATED = f"[[-({Y[0]}), {Z[1]}, {Z[2]}], [{X[0]}, 0, 0], [0, -({X[1]}), -({X[2]})], {UNROTATED[1:]}"


@pytest.mark.parametrize(
    ("answers", "points"),
    [
        # one factor is shared with what is right
        ({"determinant": INVENTED_DETERMINANT, "singular-angles": ALL_STRAIGHT}, [0.0, 0.0]),
        (
            {
                "position": "[a1*cos(theta1), a2*cos(theta2), a3*cos(theta3)]",
                "jacobian": "[[-a1*sin(theta1), 0, 0], [0, -a2*sin(theta2), 0], [0, 0, -a3*sin(theta3)]]",
                "determinant": f"-{INVENTED_DETERMINANT}", "singular-angles": ALL_STRAIGHT,
            },
            [0.0, 0.0, 0.0, 0.0],
        ),
        ({"singular-angles": "theta3 = 0, pi"}, [1.0]),
        (
            {"determinant": "a1*a3*sin(theta1)*sin(theta3)", "singular-angles": "theta1 = 0, pi; theta3 = 0, pi"},
            [0.5, 0.5],
        ),
        # an honest attempt, whether what it builds on was answered, left blank or not asked
        ({"joint-axes": UNROTATED, "geometric-jacobian": FROM_UNROTATED}, [0.0, 1.6]),
        ({"joint-axes": UNROTATED, "position-vectors": "", "geometric-jacobian": FROM_UNROTATED}, [0.0, 0.0, 1.6]),
    ],
)  # fmt: skip
def test_answers_are_followed_if_the_first_is_an_attempt(answers: dict[str, str], points: list[float]) -> None:
    problem = generate(ProblemId("elbow-3r", 1, tuple(answers), variation="chapter"))
    assert [verdict.points for verdict in mark(problem, answers, secret="secret")] == points


def test_an_answer_explained_only_by_two_mistakes_is_no_attempt() -> None:
    invention = {
        "position": "[a1*cos(theta1), a2*sin(theta2)]",
        "jacobian": "[[-a1*sin(theta1), 0], [0, a2*cos(theta2)]]", "determinant": "-a1*a2*sin(theta1)*cos(theta2)",
        "singular-angles": "[theta1 = 0, theta1 = pi, theta2 = pi/2, theta2 = -pi/2]",
    }  # fmt: skip
    assert all(verdict.points == 0.0 for verdict in mark_answers(make_problem(PLANAR), invention).values())


def test_blank_intermediate_parts_are_derived() -> None:
    for blanks in ({"jacobian": ""}, {"jacobian": "", "determinant": ""}):
        verdicts = mark_answers(make_problem(PLANAR), {**RELATIVE_ANGLES, **blanks})
        assert verdicts["singular-angles"].points == verdicts["inverse-velocity"].points == 1.6
        assert verdicts["jacobian"].points == 0.0
    without = make_problem(PLANAR, ("position", "determinant"))
    assert mark_answers(without, RELATIVE_ANGLES)["determinant"].followed_from == "position"


@pytest.mark.parametrize(("answer", "is_attempt"), read_cases("answers")["attempts"])
def test_half_of_the_terms_are_an_attempt(answer: str, is_attempt: bool) -> None:
    verdict = mark_answers(make_problem(PLANAR, ("position",)), {"position": answer})["position"]
    assert (verdict.points, verdict.attempt) == (0.0, is_attempt), verdict.diagnosis


EARLY_MISTAKES = ("relative-angle", "sine-for-cosine", "link-subtracted", "chain-rule", "term-sign")


@few_families
def test_mistakes_are_followed_on_every_family(family: str) -> None:
    """Derive all answers with one mistake: a large share of those that differ must be followed."""
    problem = get_problem(family, 0)
    later = [
        part
        for part in problem.parts
        if any(list_earlier_parts(part)) and is_derived_step_by_step(part) and is_formula(part)
    ]
    if problem.chain.n > 3 or not later:
        return
    stages = compute_symbolic_stages(problem.chain)
    tried = followed = 0
    for mistake in EARLY_MISTAKES[:: select_for_suite(2, 1)]:
        for wrong in list(apply_mistake(CATALOGUE[mistake], stages, later[0]))[: select_for_suite(1, 2)]:
            parts = [part for part in problem.parts if is_derived_step_by_step(part) and is_formula(part)]
            texts = {part.name: write_answer(part, wrong.stages) for part in parts}
            if any(len(text) > 4000 or "zoo" in text or "nan" in text for text in texts.values()):
                continue
            verdicts = mark_answers(problem, texts)
            for part in later:
                verdict = verdicts[part.name]
                if verdict.judgement.outcome is not Outcome.CORRECT and depends_on_wrong_part(part, verdicts):
                    tried += 1
                    followed += (verdict.points or 0.0) >= 0.8 * verdict.max_points
    assert followed >= 0.4 * tried, (followed, tried)


def is_formula(part: Part) -> bool:
    return part.type in ("expression", "matrix") and part.kind != "link-velocity"  # which has separate mistakes


def depends_on_wrong_part(part: Part, verdicts: dict[str, Verdict]) -> bool:
    wrong = {name for name, verdict in verdicts.items() if (verdict.points or 0.0) < verdict.max_points}
    return bool(wrong & set(list_earlier_parts(part)))


def test_points_are_exact_and_add_up() -> None:
    assert sum_points([0.1, 0.2, None]) == 0.3
    assert [compute_points(3, k / 7) for k in range(8)] == [0.0, 0.4286, 0.8571, 1.2857, 1.7143, 2.1429, 2.5714, 3.0]
    assert str(sum_points(compute_points(0.7, 1 / 3) for _ in range(3))) == "0.6999"
    assert compute_points(1.1, 1.0) == 1.1


BY_NUMPY: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "joint-rates": np.linalg.solve,
    "path-rates": np.linalg.solve,
    "least-norm-rates": lambda jacobian, v: np.linalg.pinv(jacobian) @ v,
    "manipulability": lambda jacobian, _: np.array([np.sqrt(np.linalg.det(jacobian @ jacobian.T))]),
    "condition-number": lambda jacobian, _: np.array([np.linalg.cond(jacobian)]),
}
"""Results that NumPy computes from a Jacobian and a task velocity."""


@pytest.mark.parametrize(
    ("name", "family"),
    [
        *((name, "planar-3r" if name == "least-norm-rates" else "planar-2r") for name in sample_for_suite(BY_NUMPY, 3)),
        pytest.param("joint-rates", "stanford-6r", marks=pytest.mark.whole),
    ],
)
def test_numbers_follow_from_the_students_jacobian(name: str, family: str) -> None:
    problem = generate(ProblemId(family, 1, ("jacobian", name)))
    jacobian, part = problem.parts
    wrong = jacobian.answer.as_matrix().as_mutable()
    wrong[0, 0] = 2 * wrong[0, 0]
    values = sample_configurations(problem.chain, part, problem.domain, 1, Stream("test"))
    numbers = {symbol: float(values[symbol][0]) for symbol in values}
    wrong_values = np.array(sp.Matrix(wrong).subs(numbers).evalf().tolist(), dtype=float)
    rates = BY_NUMPY[name](wrong_values, np.array([numbers[row] for row in problem.chain.task]))
    answers = {"jacobian": str(wrong.tolist()), name: str([float(f"{rate:.5g}") for rate in rates])}
    verdict = mark_answers(problem, answers)[name]
    assert verdict.followed_from == "jacobian", verdict
    assert verdict.points == pytest.approx(0.8 * verdict.max_points)
    unrelated = {**answers, name: str([float(f"{1.3 * rate + 0.2:.5g}") for rate in rates])}
    assert mark_answers(problem, unrelated)[name].followed_from is None


def test_a_self_motion_follows_up_to_a_factor() -> None:
    problem = generate(ProblemId("planar-3r", 1, ("jacobian", "self-motion")))
    jacobian, part = problem.parts
    assert not part.answer.is_numeric
    wrong = jacobian.answer.as_matrix().as_mutable()
    wrong[0, 0] = 2 * wrong[0, 0]
    motion = -3 * wrong.row(0).cross(wrong.row(1))
    for source in ("jacobian", None):
        answers = {"jacobian": str(wrong.tolist()), "self-motion": str(list(motion))}
        verdict = mark_answers(problem, answers)["self-motion"]
        assert verdict.followed_from == source, verdict
        motion[0] = motion[0] + 1


def define(answer: str, **settings: Any) -> Definition:
    return Definition("mine", answer, (Texts("Mine", "x"),), **settings)


SIGN_OF_Y = "[a1*c1 + a2*c12, a1*s1 - a2*s12]"
"""A wrong position, which depends on the same symbols as the right one."""
CUSTOM_FOLLOWING = [
    ("position", SIGN_OF_Y, define("p.x^2 + p.y^2"), "(a1*c1 + a2*c12)^2 + (a1*s1 - a2*s12)^2"),
    ("position", SIGN_OF_Y, define("cross([0, 0, 1], p - o1)", is_up_to_factor=True, rows=("x", "y")), "[-s12, -c12]"),
    ("position", "[a1*c1 + a2*c12, a1*s1 + 2*a2*s12]", define("v", rows=("v_x", "v_y")),
     "[-a1*qd1*s1 - a2*(qd1 + qd2)*s12, a1*qd1*c1 + 2*a2*(qd1 + qd2)*c12]"),
    ("jacobian", RELATIVE_ANGLES["jacobian"], define("zeros(det(J))"), "theta2 = theta1 or theta2 = theta1 + pi"),
    pytest.param("jacobian", RELATIVE_ANGLES["jacobian"], define("zeros(J[1,1], J[2,2])"),
                 "sin(theta1) = 0 and cos(theta2) = 0", marks=pytest.mark.whole),
]  # fmt: skip


@pytest.mark.parametrize(("name", "wrong", "definition", "following"), CUSTOM_FOLLOWING)
def test_custom_questions_follow_only_the_students_own_result(
    name: str, wrong: str, definition: Definition, following: str
) -> None:
    problem = generate(ProblemId("planar-2r", 3, (name, "mine"), variation="chapter"), definitions=[definition])
    verdict = mark_answers(problem, {name: wrong, "mine": following})["mine"]
    assert (verdict.points, verdict.followed_from) == (0.8, name), verdict.judgement.reason
    unrelated = following.replace("theta2", "2*theta2").replace("12", "2")
    assert mark_answers(problem, {name: wrong, "mine": unrelated})["mine"].followed_from is None


@pytest.mark.parametrize(
    "answer", sample_for_suite(["norm(v)", "v.x", "sqrt(v.x^2 + v.y^2)", "norm(J*qd)", "norm(p)"], 2)
)
@pytest.mark.parametrize("family", sample_for_suite(["planar-2r", "elbow-3r"], 1))
def test_a_number_follows_from_the_students_position(answer: str, family: str) -> None:
    """A number that no earlier answer explains is wrong, never ungraded."""
    definition = define(answer, given=(GivenValue("pose"), GivenValue("rates")))
    problem = generate(ProblemId(family, 3, ("position", "mine"), variation="chapter"), definitions=[definition])
    position = sp.Matrix(problem["position"].answer.as_matrix())
    position[1] = position[1].subs(problem.chain.q[1], 2 * problem.chain.q[1])
    details = problem["mine"].details
    values = {sp.Symbol(name): value for name, value in details.list_given_values(problem.chain).items()}
    velocity = (position.jacobian(problem.chain.q) * sp.Matrix(problem.chain.rates)).subs(values).evalf()
    numbers = {
        "norm(p)": position.subs(values).evalf().norm(), "v.x": velocity[0],
        "sqrt(v.x^2 + v.y^2)": velocity[:2, :].norm(),
    }  # fmt: skip
    expected = numbers.get(answer, velocity.norm())
    answers = {"position": str(position.tolist()), "mine": f"{float(expected):.6g}"}
    verdict = mark_answers(problem, answers)["mine"]
    assert verdict.judgement.outcome is not Outcome.UNGRADED, verdict.judgement.reason
    if answer not in ("v.x", "norm(J*qd)"):  # v.x is right, and J is that of the reference
        assert (verdict.points, verdict.followed_from) == (0.8, "position"), verdict.judgement.reason
    other = mark_answers(problem, {**answers, "mine": "12.34"})["mine"]
    assert (other.judgement.outcome, other.points) == (Outcome.WRONG, 0)


def test_zeros_of_a_matrix_earn_nothing_for_following() -> None:
    definition = define("m*transpose(J)*J", units=(("m", "kg"),))
    problem = generate(ProblemId("spherical", 3, ("jacobian", "mine"), variation="chapter"), definitions=[definition])
    right = problem["jacobian"].answer.as_typed()
    diagonal = "[[m*d3*sin(theta2), 0, 0], [0, 5*m*d3, 0], [0, 0, 7*m]]"
    for jacobian in (right, right.replace("d3", "(d3 + 0.4)")):
        assert mark_answers(problem, {"jacobian": jacobian, "mine": diagonal})["mine"].points == 0


def test_one_wrong_number_is_one_mistake() -> None:
    problem = generate(
        ProblemId("planar-2r", 3, ("mine",), variation="chapter"),
        definitions=[define("ddt(o1 + (o2 - o1)/3)", rows=("v_x", "v_y"))],
    )
    right = problem["mine"].answer.as_typed()
    for wrong in (right.replace("/3", "/2"), right.replace("/3", "")):
        assert mark_answers(problem, {"mine": wrong})["mine"].points == 0.5, wrong
