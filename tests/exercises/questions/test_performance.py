"""Manipulability and condition number agree with closed forms, and planted errors are detected."""

from dataclasses import replace
from math import cos, sin, sqrt
from typing import Any

import pytest

from qdot.exercises.problem.problem import Problem
from qdot.exercises.questions.inversion import VelocityDetails
from qdot.exercises.reference_answers import Number
from qdot.exercises.verify.certificate import certify
from tests.support.problems import ask_question

NAMES = ("manipulability", "condition-number")


def get_result(problem: Problem) -> tuple[float, str, dict[str, float]]:
    """Return the number, its unit and all given values by name."""
    (part,) = problem.parts
    configuration = part.details_as(VelocityDetails).configuration
    values = {symbol.name: float(value) for symbol, value in (configuration.lengths | configuration.joints).items()}
    return float(part.answer_as(Number).reference[0]), part.answer_as(Number).units[0], values


def test_manipulability_is_the_absolute_determinant(textbook_arms: dict[str, Any], seeds: range) -> None:
    for seed in seeds:
        w, unit, at = get_result(ask_question("manipulability", textbook_arms["planar_2R"].chain, seed))
        assert w == pytest.approx(at["a1"] * at["a2"] * abs(sin(at["theta2"])), rel=1e-9)
        assert unit == "m^2"
        name = "elbow_RRR_shoulder_offset_(Scorbot_point_P)"
        w, unit, at = get_result(ask_question("manipulability", textbook_arms[name].chain, seed))
        reach = at["a1"] + at["a2"] * cos(at["theta2"]) + at["a3"] * cos(at["theta2"] + at["theta3"])
        assert w == pytest.approx(abs(at["a2"] * at["a3"] * sin(at["theta3"]) * reach), rel=1e-9)
        assert unit == "m^3"


def test_unit_of_manipulability_follows_from_the_joints(textbook_arms: dict[str, Any]) -> None:
    def get_unit(name: str) -> str:
        return get_result(ask_question("manipulability", textbook_arms[name].chain))[1]

    assert get_unit("planar_RP") == "m"
    assert get_unit("spherical_RRP") == "m^2"
    assert get_unit("ZYZ_wrist") == ""
    assert get_unit("planar_3R_position") == "m^2"


def test_condition_number_of_wrist_has_closed_form(textbook_arms: dict[str, Any], seeds: range) -> None:
    """Axes 1 and 3 meet at the angle theta2, axis 2 is perpendicular to both: sigma^2 is 1 and 1 ± cos(theta2)."""
    for seed in seeds:
        kappa, unit, at = get_result(ask_question("condition-number", textbook_arms["ZYZ_wrist"].chain, seed))
        c = abs(cos(at["theta2"]))
        assert kappa == pytest.approx(sqrt((1 + c) / (1 - c)), rel=1e-9)
        assert unit == ""


def test_condition_number_of_planar_arm_has_closed_form(textbook_arms: dict[str, Any], seeds: range) -> None:
    """kappa + 1/kappa = (sum of the squares of J's entries) / |det J| for a 2 x 2 matrix."""
    for seed in seeds:
        kappa, _, at = get_result(ask_question("condition-number", textbook_arms["planar_2R"].chain, seed))
        squares = at["a1"] ** 2 + 2 * at["a2"] ** 2 + 2 * at["a1"] * at["a2"] * cos(at["theta2"])
        expected = squares / abs(at["a1"] * at["a2"] * sin(at["theta2"]))
        assert kappa + 1 / kappa == pytest.approx(expected, rel=1e-9)


def test_certificate_detects_wrong_unit(textbook_arms: dict[str, Any]) -> None:
    problem = ask_question("manipulability", textbook_arms["spherical_RRP"].chain)
    (part,) = problem.parts
    broken = replace(part, answer=replace(part.answer_as(Number), units=("m^3",)))
    assert not certify(replace(problem, parts=(broken,))).passed
