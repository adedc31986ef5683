"""Mistakes in exponentials, propagation and rows of tables, against what they are said to do, multiplied out here."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.families import FAMILIES
from qdot.exercises.generation import generate, sample_chain
from qdot.exercises.mistakes.base import MistakeVariant
from qdot.exercises.mistakes.catalogue import CATALOGUE, apply_mistake
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.mistakes.position import find_first_joint_of_run, list_earlier_joints
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from tests.exercises.arm.poses import compute_exponential, rotate_about, translate
from tests.support.problems import get_problem
from tests.support.suites import on_families, sample_for_suite
from tests.tools.diagnoses import classify_diagnosis, make_wrong_answers

ARMS = ("elbow-3r/1@full@screws", "scara-rrrp/2@full@screws", "planar-2r/3@screws")
Values = dict[str, np.ndarray]


@on_families(sorted(FAMILIES))
def test_a_link_that_only_one_joint_rotates_has_no_relative_angle(family: str) -> None:
    chain = get_problem(family, 0).chain
    for link in range(chain.n):
        run = range(find_first_joint_of_run(chain, link), link + 1)
        revolute_joints = [i for i in run if chain.joints[i].is_revolute]
        assert list_earlier_joints(chain, link) == [i for i in revolute_joints if i != max(revolute_joints)]


def _asked(arm: str, question: str) -> tuple[Problem, Part, Values]:
    problem = generate(arm, [question])
    part = problem.parts[0]
    return problem, part, sample_configurations(problem.chain, part, problem.domain, 4, Stream("mistakes"))


def _given(values: Values, k: int) -> Callable[[object], float]:
    known = {name: float(value[k]) for name, value in values.items()}
    return lambda entry: float(entry.subs(known))  # type: ignore[attr-defined]


def _motions(problem: Problem, values: Values, k: int) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the exponentials at place k, those of joints that turn about the origin, and M."""
    number, (axes, point) = _given(values, k), compute_home_geometry(problem.chain)
    made = [
        compute_exponential([number(entry) for entry in axis.direction], number(q), axis.is_prismatic)
        for axis, q in zip(axes, problem.chain.q, strict=True)
    ]
    return made, translate(*(number(entry) for entry in point))


@pytest.mark.parametrize("arm", sample_for_suite(ARMS, 1))
def test_an_exponential_about_the_origin_gives_the_pose_of_the_product_without_its_column(arm: str) -> None:
    problem, part, values = _asked(arm, "body-pose")
    first = next(
        apply_mistake(CATALOGUE["exponential-about-origin"], compute_numeric_stages(problem.chain, values), part)
    )
    for k in range(4):
        motions, home = _motions(problem, values, k)
        assert np.allclose(first.answer[..., k], np.linalg.multi_dot([*motions, home]))


@pytest.mark.parametrize("arm", ARMS[:2])
def test_the_same_carries_screws_to_where_it_says(arm: str) -> None:
    problem, part, values = _asked(arm, "space-jacobian")
    w = compute_numeric_stages(problem.chain, values)
    ways = list(apply_mistake(CATALOGUE["exponential-about-origin"], w, part))
    wrong = next(way for way in ways if "space jacobian" in way.variant.changes)
    for k in range(4):
        motions, before = _motions(problem, values, k)[0], np.eye(4)
        for i, motion in enumerate(motions):
            home = w["home screws"][:, i, k]
            omega, v = before[:3, :3] @ home[:3], before[:3, :3] @ home[3:]
            v = v + np.cross(before[:3, 3], omega)
            assert np.allclose(wrong.answer[:, i, k], [*omega, *v])
            before = before @ motion


@pytest.mark.parametrize("arm", ["elbow-3r/1@full@modified-dh", "scara-rrrp/2@full@modified-dh"])
def test_rows_with_the_link_behind_give_the_product_of_these_rows(arm: str) -> None:
    """Rx(alpha_i) Tx(a_i) Rz(theta_i) Tz(d_i), with nothing behind the last row, and P where it is told."""
    problem, part, values = _asked(arm, "transform")
    wrong = next(
        apply_mistake(CATALOGUE["length-and-twist-of-link-i"], compute_numeric_stages(problem.chain, values), part)
    )
    rows, base = convention_of(problem.chain).rows, convention_of(problem.chain).base
    for k in range(4):
        number = _given(values, k)
        pose = translate(*(number(entry) for entry in base.position)) @ rotate_about("z", number(base.yaw))
        for row, behind in zip(rows, [*rows[1:], None], strict=True):
            a, alpha = (0.0, 0.0) if behind is None else (number(behind.a), number(behind.alpha))
            pose = pose @ rotate_about("x", alpha) @ translate(a, 0, 0)
            pose = pose @ rotate_about("z", number(row.theta)) @ translate(0, 0, number(row.d))
        assert np.allclose(wrong.answer[..., k], pose)
    told = make_wrong_answers(problem, part, mistakes=("length-and-twist-of-link-i",))
    assert [classify_diagnosis(one) for one in told] == ["named"]


@pytest.mark.parametrize(("mistake", "stage"), [("next-arm", "vectors to point"), ("next-axis", "axes")])
def test_the_next_one_is_taken_and_at_the_last_joint_its_own(mistake: str, stage: str) -> None:
    """Three joints, so that it is told apart from taking the second one twice, or the first."""
    problem = get_problem("elbow-3r", 0)
    part = next(part for part in problem.parts if part.kind == "geometric-jacobian")
    values = sample_configurations(problem.chain, part, problem.domain, 3, Stream("propagation"))
    right = compute_numeric_stages(problem.chain, values)
    count, columns = right.n, []
    for i in range(count):
        k = min(i + 1, len(right[stage]) - 1)
        axis, vector = (right[name][k if stage == name else i] for name in ("axes", "vectors to point"))
        columns.append(np.cross(axis, vector, axis=0))
    expected = np.stack(columns, axis=1)
    answers = [wrong.answer[:3] for wrong in apply_mistake(CATALOGUE[mistake], right, part)]
    assert any(np.allclose(answer, expected) for answer in answers)


FIXED = [name for name, family in FAMILIES.items() if not family.has_varied_structure]
ENTRIES = {"length-forgotten": "a", "distance-forgotten": "d", "twist-forgotten": "alpha", "twist-sign": "alpha"}
HALF = sp.pi / 2
IN_ROW_1 = Chain("crane", (Joint("R", "theta1", "d1", "a1", HALF), Joint("R", "theta2", 0, "a2", 0)), ("vx", "vz"),
                 convention="modified-dh")  # fmt: skip


def read_wrongly(name: str, slip: MistakeVariant, rows: list[Joint]) -> list[Joint]:
    """Return the table as it is told, with the mistake that the words of a slip speak of."""
    words, rows = slip.words, list(rows)
    k = int(str(words["link"] if "link" in words else words["joint"])) - 1
    if name == "lengths-exchanged":
        other = int(str(words["other"])) - 1
        rows[k], rows[other] = replace(rows[k], a=rows[other].a), replace(rows[other], a=rows[k].a)
    elif name == "row-misread":
        entry = str(words["entry"])
        rows[k] = replace(rows[k], **{entry: getattr(rows[int(str(words["other"])) - 1], entry)})
    elif name == "a-and-d-exchanged":
        rows[k] = replace(rows[k], a=rows[k].d, d=rows[k].a)
    else:
        entry = ENTRIES[name]
        changed: dict[str, Any] = {entry: -getattr(rows[k], entry) if name == "twist-sign" else 0}
        rows[k] = replace(rows[k], **changed)
    return rows


def led_to(base: Base, rows: list[Joint], offset: tuple[sp.Expr, ...], known: dict[sp.Symbol, float]) -> np.ndarray:
    """Return where a modified table leads, by Rx Tx Rz Tz row by row."""

    def number(entry: sp.Expr) -> float:
        return float(sp.sympify(entry).subs(known))

    pose = translate(*map(number, base.position)) @ rotate_about("z", number(base.yaw))
    pose = pose @ rotate_about("x", number(base.tilt))
    for row in rows:
        pose = pose @ translate(number(row.a), 0, 0) @ rotate_about("x", number(row.alpha))
        pose = pose @ rotate_about("z", number(row.theta)) @ translate(0, 0, number(row.d))
    return np.asarray((pose @ [*map(number, offset), 1])[:3])


def checked(arm: Chain) -> list[str]:
    stream, found = Stream(f"rows/{arm.name}"), []
    known = {symbol: stream.uniform(0.3, 1.7) for symbol in (*arm.parameters, *arm.q)}
    stages = compute_numeric_stages(arm, {symbol.name: np.array([value]) for symbol, value in known.items()})
    for name in (*ENTRIES, "lengths-exchanged", "row-misread", "a-and-d-exchanged"):
        for slip in CATALOGUE[name].generate_variants(arm, (3, 1)):
            if slip.words.get("entry") == "the constant that is added to the joint variable":
                continue
            point = convention_of(arm).point
            rows = read_wrongly(name, slip, convention_of(arm).rows)
            expected = led_to(convention_of(arm).base, rows, point.offset, known)
            made = np.asarray(stages.with_mistakes(slip.changes)["point"])[:, 0]
            assert np.allclose(made, expected, atol=1e-9), (name, slip.words)
            found.append(name)
    return found


@on_families(FIXED)
def test_the_row_that_is_named_is_the_row_as_it_is_told(family: str) -> None:
    arm = sample_chain(ProblemId(family, 3, variation="full", convention="modified-dh"))
    if arm.point.frame != arm.n:
        pytest.skip("the table leads on behind the point")
    assert arm.n == 1 or checked(arm)


@pytest.mark.parametrize(
    "base",
    [
        Base((sp.Symbol("b"), sp.S.Zero, sp.S.Zero), sp.S.Zero, HALF),
        Base((sp.S.One, sp.S(2), sp.S.Zero), sp.pi / 3, HALF),
    ],
)
def test_what_the_first_row_takes_from_the_base_is_in_that_row(base: Base) -> None:
    arm = replace(IN_ROW_1, base=base)
    assert set(checked(arm)) >= {"length-forgotten", "twist-sign", "row-misread"}
    rows = [slip.words["link"] for slip in CATALOGUE["twist-forgotten"].generate_variants(arm, (3, 1))]
    assert 1 in rows or convention_of(arm).base.tilt != 0
    forgotten = list(CATALOGUE["base-forgotten"].generate_variants(arm, (3, 1)))
    assert len(forgotten) == (0 if convention_of(arm).base.is_world else 1)
