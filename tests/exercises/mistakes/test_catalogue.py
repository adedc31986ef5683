"""The catalogue: every mistake is made by some arm, gives a wrong answer there, and is named behind it."""

from functools import cache

import pytest

from qdot.exercises.chapter import make_planar_2r
from qdot.exercises.mistakes.catalogue import ANSWERS, CATALOGUE, FORMULA_VARIANTS, SECTIONS, VARIANTS
from tests.support.judging import diagnose
from tests.support.problems import ask_question, get_problem
from tests.support.suites import select_for_suite
from tests.tools.diagnoses import WrongAnswer, classify_diagnosis, make_wrong_answers

ASKED = {
    "planar-2r": (
        "velocity", "singularity-type", "condition-number", "singularity-meaning", "rank",
        "joint-torques", "manipulability", "path-rates",
    ),
    "cartesian": ("transform", "geometric-jacobian"), "planar-rpr": ("geometric-jacobian", "velocity"),
    "planar-3r": ("gram-determinant", "least-norm-rates", "singular-angles"),
    "elbow-3r": ("position-vectors", "geometric-jacobian", "rank", "singular-angles", "jacobian-size", "path-rates"),
    "pan-tilt": ("invertibility", "link-velocity", "tool-jacobian"), "orthogonal-3r": ("singular-angles",),
    "stanford-6r": ("joint-rates",), "elbow-3r@modified-dh": ("position", "geometric-jacobian"),
    "planar-2r@screws": ("home-screws", "body-pose", "space-jacobian", "body-jacobian"),
    "planar-rpr@screws": ("home-screws",), "polar-rp@screws": ("body-adjoint",),
}  # fmt: skip
"""Questions in which all mistakes can be made, those first whose answers are short."""
IN_FORMULAS = {mistake.name for mistake in SECTIONS["The finished formulas"]}
"""Mistakes in finished formulas, which do not change a derivation: test_diagnosis.py makes them."""
SELDOM = {
    "rank-of-one-condition", "orientation-as-one-component", "square-lost", "tangent-inverted",
    "value-called-singular",
}  # fmt: skip
"""Mistakes that are made on few arms, or beside others: tests/grader/diagnosis/test_mistakes.py has some of them."""
BY_SHORT_QUESTIONS = {
    "motion-reversed", "joint-without-effect", "column-of-other-joint", "components-added", "component-alone",
    "speed-squared",
}  # fmt: skip
"""Mistakes in the answers to short questions: test_concepts.py and test_site.py have them."""
IN_NUMBERS = {"direction-that-moves", "null-vector-of-jacobian"}
"""Mistakes about a direction, which are worked out at a configuration, and tested by themselves below."""
IN_OWN_FORMULAS = FORMULA_VARIANTS.keys()
"""Mistakes in the formulas of instructors' questions: tests/grader/diagnosis/test_own_formulas.py makes them."""
NAMED = ("named", "same answer")
pytestmark = pytest.mark.xdist_group("catalogue")  # one process makes the mistakes


@cache
def made(arm: str) -> dict[str, WrongAnswer]:
    """Return an answer of an arm for every mistake that no arm before it makes, of the first question it applies to."""
    before = list(ASKED)[: list(ASKED).index(arm)]
    known = {name for other in before for name in made(other)}
    family, _, convention = arm.partition("@")
    problem, answers = get_problem(family, 0, convention=convention), dict[str, WrongAnswer]()
    for part in problem.parts:
        if part.name in ASKED[arm]:
            for one in make_wrong_answers(problem, part, mistakes=CATALOGUE.keys() - known - answers.keys()):
                answers.setdefault(one.mistake, one)
    return answers


@pytest.mark.parametrize("arm", select_for_suite([arm for arm in ASKED if arm != "planar-2r"], list(ASKED)))
def test_every_mistake_is_wrong_and_named(arm: str) -> None:
    """By its name, or by that of another that gives the very same answer."""
    its = made(arm)
    verdicts = {name: classify_diagnosis(one) for name, one in its.items()}
    assert its
    assert not {name: (verdict, its[name]) for name, verdict in verdicts.items() if verdict not in NAMED}
    assert sum(verdict == "named" for verdict in verdicts.values()) >= 0.7 * len(verdicts)


def test_every_mistake_is_made_by_some_arm() -> None:
    missing = CATALOGUE.keys() - {name for arm in ASKED for name in made(arm)}
    assert missing <= IN_NUMBERS | IN_FORMULAS | SELDOM | BY_SHORT_QUESTIONS | IN_OWN_FORMULAS


def test_every_function_makes_a_mistake_of_the_catalogue() -> None:
    assert VARIANTS.keys() | ANSWERS.keys() <= CATALOGUE.keys()
    assert not VARIANTS.keys() & ANSWERS.keys()
    assert {name for mistake in CATALOGUE.values() for name in mistake.equivalent_mistakes} <= CATALOGUE.keys()


@pytest.mark.parametrize(
    ("answer", "mistake"),
    [("[-sin(theta1), cos(theta1)]", "direction-that-moves"), ("[a2, -a1 - a2]", "null-vector-of-jacobian")],
)
def test_the_mistakes_about_a_direction_are_named(answer: str, mistake: str) -> None:
    """If the planar arm is stretched out, its tip can't move along the arm."""
    problem = ask_question("lost-direction", make_planar_2r())
    found = diagnose(problem, problem.parts[0], answer, "catalogue")
    assert found is not None and mistake in found.mistakes
