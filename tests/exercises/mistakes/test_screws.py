"""Mistakes with exponentials and with rows of the wrong link, against matrices multiplied out here."""

from collections.abc import Callable

import numpy as np
import pytest

from exercises.arm.conventions import axes_of
from exercises.arm.stages import numbers
from exercises.arm.told import told_base, told_rows
from exercises.generation import generate
from exercises.mistakes.catalogue import CATALOGUE, made
from exercises.mistakes.given import configurations
from exercises.problem import Part, Problem
from exercises.stream import Stream
from tests.tools.diagnoses import answers_with, verdict_on

ARMS = ("elbow-3r/1@full@screws", "scara-rrrp/2@full@screws", "planar-2r/3@screws")
Values = dict[str, np.ndarray]


def _asked(arm: str, question: str) -> tuple[Problem, Part, Values]:
    problem = generate(arm, [question])
    part = problem.parts[0]
    return problem, part, configurations(problem.chain, part, problem.domain(), 4, Stream("mistakes"))


def _given(values: Values, k: int) -> Callable[[object], float]:
    known = {name: float(value[k]) for name, value in values.items()}
    return lambda entry: float(entry.subs(known))  # type: ignore[attr-defined]


def _motion(axis: np.ndarray, point: np.ndarray, value: float, slides: bool, shifted: bool = True) -> np.ndarray:
    pose, hat = np.eye(4), np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    if slides:
        pose[:3, 3] = value * axis
        return pose
    pose[:3, :3] += np.sin(value) * hat + (1 - np.cos(value)) * hat @ hat
    pose[:3, 3] = (point - pose[:3, :3] @ point) * shifted
    return pose


def _motions(problem: Problem, values: Values, k: int, about_origin: set[int]) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the exponentials at place k, those of some joints about the origin, and M."""
    number, (axes, point) = _given(values, k), axes_of(problem.chain)
    found, home = [], np.eye(4)
    for i, (axis, q) in enumerate(zip(axes, problem.chain.q, strict=True)):
        u, o = (np.array([number(entry) for entry in vector]) for vector in (axis.direction, axis.point))
        found.append(_motion(u, o, number(q), axis.kind == "P", i not in about_origin))
    home[:3, 3] = [number(entry) for entry in point]
    return found, home


@pytest.mark.parametrize("arm", ARMS)
def test_an_exponential_about_the_origin_gives_the_pose_of_the_product_without_its_column(arm: str) -> None:
    problem, part, values = _asked(arm, "body-pose")
    turning = {i for i, joint in enumerate(problem.chain.joints) if joint.kind == "R"}
    first = next(made(CATALOGUE["exponential-about-origin"], numbers(problem.chain, values), part))
    for k in range(4):
        motions, home = _motions(problem, values, k, turning)
        assert np.allclose(first.answer[..., k], np.linalg.multi_dot([*motions, home]))


@pytest.mark.parametrize("arm", ARMS[:2])
def test_the_same_carries_screws_to_where_it_says(arm: str) -> None:
    problem, part, values = _asked(arm, "space-jacobian")
    w = numbers(problem.chain, values)
    turning = {i for i, joint in enumerate(problem.chain.joints) if joint.kind == "R"}
    ways = list(made(CATALOGUE["exponential-about-origin"], w, part))
    wrong = next(way for way in ways if "space jacobian" in way.slip.changes)
    for k in range(4):
        motions, before = _motions(problem, values, k, turning)[0], np.eye(4)
        for i, motion in enumerate(motions):
            home = w["home screws"][:, i, k]
            omega, v = before[:3, :3] @ home[:3], before[:3, :3] @ home[3:]
            v = v + np.cross(before[:3, 3], omega)
            assert np.allclose(wrong.answer[:, i, k], [*omega, *v])
            before = before @ motion


MIXED_UP = ("screws-at-home", "points-at-home", "exponential-about-origin", "joints-in-degrees")


@pytest.mark.parametrize("question", ["body-pose", "space-jacobian"])
def test_mistakes_with_exponentials_are_named(question: str) -> None:
    problem, part, _ = _asked(ARMS[0], question)
    verdicts = {(one.mistake, verdict_on(one)) for one in answers_with(problem, part, only=MIXED_UP)}
    assert {verdict for _, verdict in verdicts} == {"named"}
    due = set(MIXED_UP) if question == "space-jacobian" else {"exponential-about-origin", "joints-in-degrees"}
    assert {name for name, _ in verdicts} == due


@pytest.mark.parametrize("arm", ["elbow-3r/1@full@modified-dh", "scara-rrrp/2@full@modified-dh"])
def test_rows_with_the_link_behind_give_the_product_of_these_rows(arm: str) -> None:
    """Rx(alpha_i) Tx(a_i) Rz(theta_i) Tz(d_i), with nothing behind the last row, and P where it is told."""
    problem, part, values = _asked(arm, "transform")
    wrong = next(made(CATALOGUE["link-behind"], numbers(problem.chain, values), part))
    rows, base = told_rows(problem.chain), told_base(problem.chain)
    for k in range(4):
        number = _given(values, k)
        pose = np.eye(4)
        pose[:3, 3] = [number(entry) for entry in base.position]
        pose = pose @ _motion(np.array([0.0, 0, 1]), np.zeros(3), number(base.yaw), slides=False)
        for row, behind in zip(rows, [*rows[1:], None], strict=True):
            a, alpha = (0.0, 0.0) if behind is None else (number(behind.a), number(behind.alpha))
            for axis, turn, way in ((0, alpha, a), (2, number(row.theta), number(row.d))):
                along = np.eye(3)[axis]
                pose = (
                    pose
                    @ _motion(along, np.zeros(3), turn, slides=False)
                    @ _motion(along, np.zeros(3), way, slides=True)
                )
        assert np.allclose(wrong.answer[..., k], pose)
    told = answers_with(problem, part, only=("link-behind",))
    assert [verdict_on(one) for one in told] == ["named"]
