"""The welding robot: rates along a line and where one exceeds its limit, against closed forms and planted errors."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from math import acos, atan2, cos, hypot, sin
from typing import Any

import pytest
import sympy as sp

from exercises.answers import Number
from exercises.arm.chain import Chain
from exercises.arm.path import Line
from exercises.arm.precise import PRECISE
from exercises.families import FAMILIES
from exercises.generation import generate, questions_of, sample_chain
from exercises.problem import Problem, ProblemId
from exercises.questions import QUESTIONS
from exercises.questions.path import AtDistance, OnPath, Seam, ToLimit
from exercises.verify import certify
from exercises.writing.statement import prompt, worked_solution
from exercises.writing.worked import three_digits
from grader.certify import failures_of
from tests.support.judging import judge_numbers
from tests.support.problems import asked
from tests.support.suites import families_for, several

pytestmark = pytest.mark.xdist_group("path")  # the problems of all arms are made once

NAMES = ("path-rates", "path-limit")
TEXTBOOK = ("planar_2R", "planar_RP", "planar_PR", "spherical_RRP", "elbow_RRR", "orthogonal_3R")


ASKED = families_for([family for family in FAMILIES if set(NAMES) & set(questions_of(family))])


def arms(name: str, textbook_arms: dict[str, Any]) -> Iterator[Chain]:
    yield from (textbook_arms[arm].chain for arm in TEXTBOOK)
    for family in ASKED:
        chain = sample_chain(ProblemId(family, 1)) if not FAMILIES[family].varied else None
        if chain is not None and QUESTIONS[name].refusal(chain) is None:
            yield chain


def numbers(problem: Problem) -> list[float]:
    answer = problem.parts[0].answer
    assert isinstance(answer, Number)
    return [float(value) for value in answer.reference]


def seam_of(problem: Problem) -> Seam:
    return problem.parts[0].about(OnPath).seam


class Planar2R:
    """The arm of Example 6.1 on a seam, by the law of cosines; the elbow stays on the side on which it starts."""

    def __init__(self, seam: Seam) -> None:
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


def test_rates_of_the_chapters_arm_by_the_law_of_cosines(textbook_arms: dict[str, Any], seeds: range) -> None:
    for seed in seeds:
        problem = asked("path-rates", textbook_arms["planar_2R"].chain, seed)
        place = float(problem.parts[0].about(AtDistance).distance)
        assert numbers(problem) == pytest.approx(Planar2R(seam_of(problem)).rates(place), rel=1e-8, abs=1e-9)


def test_limit_of_the_chapters_arm_by_the_law_of_cosines(textbook_arms: dict[str, Any], seeds: range) -> None:
    for seed in seeds:
        problem = asked("path-limit", textbook_arms["planar_2R"].chain, seed)
        details, (s,) = problem.parts[0].about(ToLimit), numbers(problem)
        arm, joint, limit = Planar2R(details.seam), details.joint - 1, float(details.limit)
        assert abs(arm.rates(s)[joint]) == pytest.approx(limit, rel=1e-7)
        assert all(abs(arm.rates(s * k / 100)[joint]) < limit for k in range(100))
        assert abs(arm.rates(1.005 * s)[joint]) > 1.005 * limit
        assert 0.1 < s < arm.length


def test_a_line_in_thirty_digits_is_the_line_in_floats(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["elbow_RRR"].chain
    seam = seam_of(asked("path-rates", chain))
    rough, exact = seam.line(chain), seam.line(chain, PRECISE)
    stations = list(rough.follow(0.02, 0.15))
    assert len(stations) > 10
    for station in stations:
        q = exact.joints_at(PRECISE.mpf(station.s), [PRECISE.mpf(value) for value in station.joints])
        assert q is not None
        assert [float(value) for value in q] == pytest.approx(list(station.joints), abs=1e-11)
        assert [float(value) for value in exact.slopes(q)] == pytest.approx(list(station.slopes), abs=1e-9)


def test_a_line_ends_where_the_arm_does(textbook_arms: dict[str, Any]) -> None:
    chain = textbook_arms["planar_2R"].chain
    half = {symbol: sp.Rational(1, 2) for symbol in chain.parameters}
    joints = dict(zip(chain.q, (sp.S.Zero, sp.pi / 2), strict=True))  # P at (0.5, 0.5), reach 1
    line = Line(chain, half, joints, (sp.Rational(1, 2), sp.S(2)))
    last = list(line.follow(0.02, 0.05))[-1]
    assert 0.3 < last.s < 3**0.5 / 2 - 0.5
    assert line.joints_at(0.6, line.q) is None


@pytest.mark.parametrize("name", NAMES)
def test_references_pass_everything(name: str, textbook_arms: dict[str, Any], seeds: range) -> None:
    for chain in arms(name, textbook_arms):
        for seed in seeds[: several(1, 2)]:
            problem = asked(name, chain, seed)
            certificate = certify(problem)
            assert certificate.passed, (chain.name, seed, certificate.failures)
            assert not failures_of(problem, certificate)


@pytest.mark.parametrize("name", NAMES)
def test_wrong_numbers_are_found(name: str, textbook_arms: dict[str, Any]) -> None:
    for chain in islice(arms(name, textbook_arms), 0, None, several(3, 1)):
        problem = asked(name, chain)
        (part,) = problem.parts
        assert isinstance(part.answer, Number)
        right = part.answer.reference
        for wrong in (-right, right * sp.Float(1.0001), right + sp.ones(*right.shape) / 10**6, 2 * right):
            broken = replace(part, answer=replace(part.answer, reference=wrong))
            assert not certify(replace(problem, parts=(broken,))).passed
        details = part.about(OnPath)
        other = replace(part, details=replace(details, seam=replace(details.seam, speed=details.seam.speed * 2)))
        assert not certify(replace(problem, parts=(other,))).passed


@pytest.mark.parametrize("name", NAMES)
def test_given_numbers_are_such_as_a_person_works_with(name: str, textbook_arms: dict[str, Any]) -> None:
    for chain in arms(name, textbook_arms):
        seam = seam_of(asked(name, chain))
        assert all((100 * value).is_Integer for value in seam.target.values())
        assert all((20 * value).is_Integer for value in seam.lengths.values())
        for q, value in seam.joints.items():
            assert (36 * value / sp.pi if q.name.startswith("theta") else 20 * value).is_Integer
            assert -sp.pi < value <= sp.pi or not q.name.startswith("theta")


@pytest.mark.parametrize("name", NAMES)
def test_refusals(name: str, textbook_arms: dict[str, Any]) -> None:
    def refusal(arm: str) -> str:
        return QUESTIONS[name].refusal(textbook_arms[arm].chain) or ""

    assert "linear velocities only" in refusal("planar_3R_pose")
    assert "linear velocities only" in refusal("SCARA_RRRP")
    assert "not square" in refusal("planar_3R_position")
    assert "the same everywhere" in refusal("cartesian_PPP")
    assert "not square" in refusal("pan_tilt_2R")


def test_a_distance_is_typed_as_a_plain_number(textbook_arms: dict[str, Any]) -> None:
    problem = asked("path-limit", textbook_arms["planar_2R"].chain)
    answer = problem.parts[0].answer
    assert isinstance(answer, Number)
    (s,) = numbers(problem)
    judged = [judge_numbers(f"{s * k:.3g}", [s], answer.units, answer.tolerance, answer.floor) for k in (1, 1.03)]
    assert [judgement.share for judgement in judged] == [1, 0]


def test_words(textbook_arms: dict[str, Any]) -> None:
    for name in NAMES:
        for chain in arms(name, textbook_arms):
            problem = asked(name, chain)
            (part,) = problem.parts
            text, solution = prompt(problem, part), worked_solution(problem, part)
            assert "at the constant speed" in text
            assert three_digits(sp.Float(numbers(problem)[0])) in solution
            assert f"{numbers(problem)[0]:.4g}" not in text
            assert solution.count("\n|") == 7
            assert "None" not in text + solution


def test_solutions_tell_angles_in_degrees_as_questions_do() -> None:
    problem = generate("planar-2r/1", ["path-rates"])
    (part,) = problem.parts
    seam = part.about(OnPath).seam
    told = seam.at(problem.chain, sp.S.Zero).joints
    assert all(abs(angle - seam.joints[q] * 180 / sp.pi) < 1e-2 for q, angle in zip(problem.chain.q, told, strict=True))
    assert "rad," not in worked_solution(problem, part).replace("rad/s", "")
