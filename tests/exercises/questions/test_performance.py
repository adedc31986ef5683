"""Manipulability and condition number, against closed forms and planted errors."""

from dataclasses import replace
from math import cos, sin, sqrt
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.answers import Number
from exercises.arm.chain import Chain
from exercises.families import FAMILIES
from exercises.generation import sample_chain
from exercises.problem import Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.inversion import InSituation
from exercises.verify import certify
from exercises.writing.statement import prompt, worked_solution
from grader.certify import failures_of
from tests.support.problems import asked

NAMES = ("manipulability", "condition-number")


def found(problem: Problem) -> tuple[float, str, dict[str, float]]:
    """Return the number, its unit and all given values by name."""
    (part,) = problem.parts
    situation = part.about(InSituation).situation
    assert isinstance(part.answer, Number)
    given = {symbol.name: float(value) for symbol, value in (situation.lengths | situation.joints).items()}
    return float(part.answer.reference[0]), part.answer.units[0], given


def arms(name: str, textbook_arms: dict[str, Any]) -> list[Chain]:
    chains = [arm.chain for arm in textbook_arms.values()]
    chains += [sample_chain(ProblemId(family.name, 1)) for family in FAMILIES.values() if not family.varied]
    return [chain for chain in chains if QUESTIONS[name].refusal(chain) is None]


def test_manipulability_is_the_determinant_of_the_chapter(textbook_arms: dict[str, Any], seeds: range) -> None:
    for seed in seeds:
        w, unit, at = found(asked("manipulability", textbook_arms["planar_2R"].chain, seed))
        assert w == pytest.approx(at["a1"] * at["a2"] * abs(sin(at["theta2"])), rel=1e-9)
        assert unit == "m^2"
        name = "elbow_RRR_shoulder_offset_(Scorbot_point_P)"
        w, unit, at = found(asked("manipulability", textbook_arms[name].chain, seed))
        reach = at["a1"] + at["a2"] * cos(at["theta2"]) + at["a3"] * cos(at["theta2"] + at["theta3"])
        assert w == pytest.approx(abs(at["a2"] * at["a3"] * sin(at["theta3"]) * reach), rel=1e-9)
        assert unit == "m^3"


def test_units_follow_the_joints(textbook_arms: dict[str, Any]) -> None:
    def unit(name: str) -> str:
        return found(asked("manipulability", textbook_arms[name].chain))[1]

    assert unit("planar_RP") == "m"
    assert unit("spherical_RRP") == "m^2"
    assert unit("ZYZ_wrist") == ""
    assert unit("planar_3R_position") == "m^2"


def test_condition_number_of_a_wrist(textbook_arms: dict[str, Any], seeds: range) -> None:
    """Axes 1 and 3 meet at the angle theta2, axis 2 is perpendicular to both: sigma^2 is 1 and 1 ± cos(theta2)."""
    for seed in seeds:
        kappa, unit, at = found(asked("condition-number", textbook_arms["ZYZ_wrist"].chain, seed))
        c = abs(cos(at["theta2"]))
        assert kappa == pytest.approx(sqrt((1 + c) / (1 - c)), rel=1e-9)
        assert unit == ""


def test_condition_number_of_the_chapters_arm(textbook_arms: dict[str, Any], seeds: range) -> None:
    """kappa + 1/kappa = (sum of the squares of J's entries) / |det J| for a 2 x 2 matrix."""
    for seed in seeds:
        kappa, _, at = found(asked("condition-number", textbook_arms["planar_2R"].chain, seed))
        squares = at["a1"] ** 2 + 2 * at["a2"] ** 2 + 2 * at["a1"] * at["a2"] * cos(at["theta2"])
        expected = squares / abs(at["a1"] * at["a2"] * sin(at["theta2"]))
        assert kappa + 1 / kappa == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_references_pass_everything_and_broken_ones_do_not(
    name: str, textbook_arms: dict[str, Any], seeds: range
) -> None:
    for chain in arms(name, textbook_arms):
        for seed in seeds[:2]:
            problem = asked(name, chain, seed)
            assert certify(problem).passed, (chain.name, certify(problem).failures)
            assert not failures_of(problem)
        (part,) = problem.parts
        assert isinstance(part.answer, Number)
        right = part.answer.reference
        for wrong in (-right, 1 / right[0] * sp.eye(1), right * sp.Float(1.00001), right.applyfunc(lambda v: v**2)):
            broken = replace(part, answer=replace(part.answer, reference=wrong))
            assert (
                np.isclose(float(wrong[0]), float(right[0]), rtol=1e-7)
                or not certify(replace(problem, parts=(broken,))).passed
            )


def test_a_wrong_unit_is_found(textbook_arms: dict[str, Any]) -> None:
    problem = asked("manipulability", textbook_arms["spherical_RRP"].chain)
    (part,) = problem.parts
    assert isinstance(part.answer, Number)
    broken = replace(part, answer=replace(part.answer, units=("m^3",)))
    assert not certify(replace(problem, parts=(broken,))).passed


def test_refusals(textbook_arms: dict[str, Any]) -> None:
    def refusal(name: str, arm: str) -> str:
        return QUESTIONS[name].refusal(textbook_arms[arm].chain) or ""

    for name in NAMES:
        assert "common unit" in refusal(name, "planar_3R_pose")
        assert "common unit" in refusal(name, "PUMA560")
        assert "singular everywhere" in refusal(name, "pan_tilt_2R")
        assert "the same in every" in refusal(name, "cartesian_PPP")
    assert not refusal("manipulability", "planar_RP")
    assert "common unit" in refusal("condition-number", "planar_RP")


@pytest.mark.parametrize("name", NAMES)
def test_words(name: str, textbook_arms: dict[str, Any]) -> None:
    for chain in arms(name, textbook_arms):
        problem = asked(name, chain)
        (part,) = problem.parts
        text, solution = prompt(problem, part), worked_solution(problem, part)
        assert "one number to three significant digits" in text
        assert f"{found(problem)[0]:#.3g}".rstrip(".") in solution
        assert "None" not in text + solution
