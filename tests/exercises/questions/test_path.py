"""The welding robot: joint rates along a line, compared with closed forms."""

from math import acos, atan2, cos, hypot, sin
from typing import Any

import pytest
import sympy as sp

from qdot.exercises.arm.mpmath_kinematics import PRECISE_CONTEXT
from qdot.exercises.arm.path import StraightPath
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import Problem
from qdot.exercises.questions.path import PathDetails, WeldingLine
from qdot.exercises.reference_answers import Number
from qdot.exercises.writing.problem_texts import write_prompt, write_solution
from qdot.exercises.writing.solution_steps import format_number
from tests.support.problems import ask_question, get_problem


def get_numbers(problem: Problem) -> list[float]:
    answer = problem.parts[0].answer_as(Number)
    return [float(value) for value in answer.reference]


def get_welding_line(problem: Problem) -> WeldingLine:
    return problem.parts[0].details_as(PathDetails).welding_line


class Planar2R:
    """The arm of Example 6.1 on a welding line, by the law of cosines; the elbow stays on its side."""

    def __init__(self, seam: WeldingLine) -> None:
        self.a1, self.a2 = (float(seam.lengths[sp.Symbol(name)]) for name in ("a1", "a2"))
        t1, t2 = (float(seam.joints[sp.Symbol(name)]) for name in ("theta1", "theta2"))
        self.side = 1 if sin(t2) > 0 else -1
        self.x = self.a1 * cos(t1) + self.a2 * cos(t1 + t2)
        self.y = self.a1 * sin(t1) + self.a2 * sin(t1 + t2)
        to_x, to_y = float(seam.target["x"]) - self.x, float(seam.target["y"]) - self.y
        self.length, self.speed = hypot(to_x, to_y), float(seam.speed)
        self.ux, self.uy = to_x / self.length, to_y / self.length

    def rates(self, s: float) -> list[float]:
        x, y = self.x + s * self.ux, self.y + s * self.uy
        t2 = self.side * acos((x * x + y * y - self.a1**2 - self.a2**2) / (2 * self.a1 * self.a2))
        t1 = atan2(y, x) - atan2(self.a2 * sin(t2), self.a1 + self.a2 * cos(t2))
        vx, vy = self.ux * self.speed, self.uy * self.speed
        c12, s12 = cos(t1 + t2), sin(t1 + t2)
        first = (c12 * vx + s12 * vy) / (self.a1 * sin(t2))
        second = -(x * vx + y * vy) / (self.a1 * self.a2 * sin(t2))
        return [first, second]


def test_path_rates_agree_with_the_law_of_cosines(textbook_arms: dict[str, Any], seeds: range) -> None:
    for seed in seeds:
        problem = ask_question("path-rates", textbook_arms["planar_2R"].chain, seed)
        place = float(problem.parts[0].details_as(PathDetails).distance)
        assert get_numbers(problem) == pytest.approx(
            Planar2R(get_welding_line(problem)).rates(place), rel=1e-8, abs=1e-9
        )


def test_precise_and_float_paths_agree(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["elbow_RRR"].chain
    seam = get_welding_line(ask_question("path-rates", chain))
    rough, exact = seam.make_path(chain), seam.make_path(chain, PRECISE_CONTEXT)
    stations = list(rough.follow(0.02, 0.15))
    assert len(stations) > 10
    for station in stations:
        q = exact.find_joint_values(
            PRECISE_CONTEXT.mpf(station.s), [PRECISE_CONTEXT.mpf(value) for value in station.joint_values]
        )
        assert q is not None
        assert [float(value) for value in q] == pytest.approx(list(station.joint_values), abs=1e-11)
        assert [float(value) for value in exact.compute_derivatives(q)] == pytest.approx(
            list(station.derivatives), abs=1e-9
        )


def test_path_ends_at_the_limit_of_reach(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["planar_2R"].chain
    half = {symbol: sp.Rational(1, 2) for symbol in chain.parameters}
    joints = dict(zip(chain.q, (sp.S.Zero, sp.pi / 2), strict=True))  # P at (0.5, 0.5), reach 1
    line = StraightPath(chain, half, joints, (sp.Rational(1, 2), sp.S(2)))
    last = list(line.follow(0.02, 0.05))[-1]
    assert 0.3 < last.s < 3**0.5 / 2 - 0.5
    assert line.find_joint_values(0.6, line.start_joint_values) is None


def test_path_questions_use_simple_numbers_and_hide_the_result(family: str) -> None:
    problem = get_problem(family, 0)
    for part in (part for part in problem.parts if part.name == "path-rates"):
        seam, number = part.details_as(PathDetails).welding_line, part.answer_as(Number).reference[0]
        assert all((100 * value).is_Integer for value in seam.target.values())
        assert all((20 * value).is_Integer for value in seam.lengths.values())
        for q, value in seam.joints.items():
            assert (36 * value / sp.pi if q.name.startswith("theta") else 20 * value).is_Integer
            assert -sp.pi < value <= sp.pi or not q.name.startswith("theta")
        assert format_number(sp.Float(number)) in write_solution(problem, part)
        assert f"{float(number):.4g}" not in write_prompt(problem, part)


def test_solutions_give_angles_in_degrees() -> None:
    problem = generate("planar-2r/1", ["path-rates"])
    (part,) = problem.parts
    seam = part.details_as(PathDetails).welding_line
    joint_angles = seam.compute_results(problem.chain, sp.S.Zero).joints
    assert seam.compute_results(problem.chain, sp.S.Zero).joints is joint_angles, "computed only once"
    assert all(
        abs(angle - seam.joints[q] * 180 / sp.pi) < 1e-2 for q, angle in zip(problem.chain.q, joint_angles, strict=True)
    )
    assert "rad," not in write_solution(problem, part).replace("rad/s", "")
