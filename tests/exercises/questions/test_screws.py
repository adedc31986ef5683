"""Arms told by their axes: published Jacobians, exponentials as another way, and texts without frames on the links."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

from exercises.arm.chain import Chain, Joint, Point
from exercises.arm.conventions import axes_of
from exercises.arm.placing import Axis
from exercises.families import FAMILIES
from exercises.families.base import Family
from exercises.families.own import own_family
from exercises.generation import applicable, generate, sample_chain
from exercises.mistakes.catalogue import CATALOGUE, taken
from exercises.problem import Problem, ProblemId
from exercises.questions.screws import (
    QUESTIONS,
    body_jacobian,
    body_pose,
    body_rotation,
    home_screws,
    space_jacobian,
)
from exercises.quizzes import QUIZZES
from exercises.verify import certify
from exercises.writing.statement import hints, prompt, statement, worked_solution
from tests.support.suites import few_families, of_families, several

FIXED = [name for name, family in FAMILIES.items() if not family.varied]
NAMES = tuple(question.name for question in QUESTIONS)
Q1, Q2, Q3 = sp.symbols("theta1:4")
A1, A2, A3, D1 = sp.symbols("a1 a2 a3 d1")


def by_axes(family: str, variation: str = "full", seed: int = 1) -> Chain:
    return sample_chain(ProblemId(family, seed, variation=variation, convention="screws"))


def same(found: sp.Matrix, published: list[list[sp.Expr]]) -> bool:
    return (found - sp.Matrix(published)).applyfunc(sp.simplify).is_zero_matrix


def test_the_planar_arm_has_its_published_jacobians() -> None:
    """Those of any book with screws: J_s holds the joints before, J_b the joints behind."""
    arm = by_axes("planar-2r", "chapter")
    assert same(space_jacobian(arm), [[0, 0], [0, 0], [1, 1], [0, A1 * sp.sin(Q1)], [0, -A1 * sp.cos(Q1)], [0, 0]])
    below = [[A1 * sp.sin(Q2), 0], [A1 * sp.cos(Q2) + A2, A2], [0, 0]]
    assert same(body_jacobian(arm), [[0, 0], [0, 0], [1, 1], *below])


def test_a_scara_has_its_published_space_jacobian() -> None:
    """Three parallel axes and a slide along them (the first example of most courses)."""
    arm = by_axes("scara-rrrp", "chapter")
    jacobian, s1, c1 = space_jacobian(arm), sp.sin(Q1), sp.cos(Q1)
    x, y = A1 * c1 + A2 * sp.cos(Q1 + Q2), A1 * s1 + A2 * sp.sin(Q1 + Q2)
    assert same(jacobian[:, :3], [[0] * 3, [0] * 3, [1] * 3, [0, A1 * s1, y], [0, -A1 * c1, -x], [0] * 3])
    assert same(jacobian[:, 3], [[0]] * 5 + [[-1]])


@of_families(FIXED)
def test_what_is_asked_of_screws_is_certified(family: str) -> None:
    """By exponentials of the axes as they are told, which know of no table, and by differences."""
    asked = tuple(name for name in applicable(by_axes(family)) if name in NAMES)
    certificate = certify(generate(ProblemId(family, 1, asked, variation="full", convention="screws")))
    assert certificate.passed, certificate.failures


@of_families(FIXED)
def test_at_home_jacobians_are_the_screws(family: str) -> None:
    """And the body frame is parallel to the space frame there, with its origin in P."""
    arm = by_axes(family, "zeros")
    home = dict.fromkeys(arm.q, sp.S.Zero)
    screws = sp.Matrix.hstack(*(one.screw for one in home_screws(arm)))
    lengths = dict.fromkeys(arm.parameters, sp.Rational(7, 10))
    assert (space_jacobian(arm).xreplace(home) - screws).xreplace(lengths).n(30).applyfunc(_dust).is_zero_matrix
    if arm.point.frame == arm.n and arm.n < 5:
        assert body_rotation(arm).xreplace(home).n(30).applyfunc(_dust) == sp.eye(3)
        place = body_pose(arm)[:3, 3].xreplace(home) - axes_of(arm)[1]
        assert place.xreplace(lengths).n(30).applyfunc(_dust).is_zero_matrix


def _dust(value: sp.Expr) -> sp.Expr:
    return sp.nsimplify(value.round(20)) if value.is_number else value


OF_FRAMES = re.compile(
    r"O_\{?[0-9]|z_\{|(?<!\$)\bz_[0-9]|p\^\*|(?<!\d )R_\{?[0-9i]|[Ff]rame (?:\$?[0-9]|\$i)"
    r"|base frame|world frame|Denavit|twist \$\\alpha|by the twists|row of the table"
)
"""What only a table puts on the links."""


@few_families
def test_no_text_speaks_of_frames_on_the_links(family: str) -> None:
    if family not in FIXED:
        pytest.skip("its arms are of many structures")
    arm = by_axes(family)
    names = [*applicable(arm), *applicable(arm, QUIZZES)]
    wrong: dict[str, str] = {}
    for name in names[:: several(7, 1)]:
        problem = generate(ProblemId(family, 1, (name,), variation="full", convention="screws"))
        for where, text in _texts(problem):
            if found := OF_FRAMES.search(text):
                wrong[f"{name}, {where}"] = text[max(found.start() - 40, 0) : found.end() + 40]
    assert not wrong


@few_families
def test_no_mistake_speaks_of_a_table_or_of_frames_on_the_links(family: str) -> None:
    if family not in FIXED:
        pytest.skip("its arms are of many structures")
    arm = by_axes(family)
    shapes = ((3, 1), (6, arm.n), (6, 1), (arm.n, arm.n), (1, 1))
    said = {m.sentence(slip.words) for m in CATALOGUE.values() for shape in shapes for slip in m.slips(arm, shape)}
    for part in generate(ProblemId(family, 1, tuple(applicable(arm)), variation="full", convention="screws")).parts:
        said |= {mistake.sentence(take.words) for mistake, take in taken(arm, part)}
    table = re.compile(r"\b(table|frames?|rows?) (\d|i\b|of the table|below)|\btable\b|(base|last|own) frame|p\*|\bO\d")
    assert not [sentence for sentence in said if table.search(sentence)]


def _texts(problem: Problem) -> list[tuple[str, str]]:
    (part,) = problem.parts
    return [
        ("statement", statement(problem, "")),
        ("prompt", prompt(problem, part)),
        ("hints", "\n".join(hints(problem, part))),
        ("solution", worked_solution(problem, part)),
    ]


def test_an_arm_of_a_table_is_asked_nothing_of_screws() -> None:
    arm = sample_chain(ProblemId("planar-2r", 1))
    assert not set(applicable(arm)) & set(NAMES)
    by = by_axes("planar-2r")
    assert set(NAMES) <= set(applicable(by))
    assert not {"transform", "position-vectors", "link-velocity", "tool-jacobian"} & set(applicable(by))


def test_a_certificate_sees_axes_that_lead_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where nothing is asked of the screws themselves: the statement tells them."""
    problem = generate("elbow-3r/1@screws", ["position"])
    assert {"axes at home: point", "axes at home: velocities"} <= {check.name for check in certify(problem).checks}

    def other(chain: Chain) -> tuple[list[Axis], sp.Matrix]:
        (first, second, third), point = axes_of(chain)
        return [first, replace(second, direction=-second.direction), third], point

    monkeypatch.setattr("exercises.verify.screws.axes_of", other)
    assert {check.name for check in certify(problem).failures} == {"axes at home: point", "axes at home: velocities"}


def test_a_point_on_an_inner_link_is_certified_by_the_axes_before_it() -> None:
    joints = tuple(Joint("R", f"theta{i}", 0, f"a{i}", "pi/2" if i == 1 else 0) for i in (1, 2, 3))
    arm = Chain("m", joints, ("vx", "vy"), tool=Point(2), convention="screws")
    certificate = certify(generate(ProblemId("m", 1, ("position",)), family=Family("m", "m", "m", arm)))
    assert certificate.passed, certificate.failures


def test_a_length_of_an_arm_told_by_axes_may_be_called_as_one_of_the_table_that_is_not_told(
    tmp_path: Path,
) -> None:
    """Joint 1 has the length 0.3 in that table, where a1 would be looked for."""
    path = tmp_path / "arm.toml"
    joint = '[[joint]]\nkind = "R"\naxis = [0, 0, 1]\npoint = [{}, 0, 0]\n'
    head = 'name = "m"\nconvention = "screws"\npoint = ["a1 + 0.3", 0, 0]\n'
    path.write_text(head + joint.format(0) + joint.format(0.3))
    family = own_family(path)
    certificate = certify(generate(ProblemId(family.name, 1, ("position", "determinant")), family=family))
    assert certificate.passed, certificate.failures
