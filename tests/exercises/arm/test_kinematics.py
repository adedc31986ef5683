"""The two symbolic routes and the numeric one agree with each other and with finite differences, for any chain."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from exercises.arm.chain import CONVENTIONS, Base, Chain, Joint, Point
from exercises.arm.derivation import structure
from exercises.arm.kinematics import (
    NumericChain,
    differentiated_jacobian,
    frames_and_point,
    link_frames,
    propagated_jacobian,
    propagated_p_star,
    propagated_rotations,
)
from exercises.formula.expression import read
from exercises.formula.program import compile_program, evaluate
from exercises.stream import Stream
from exercises.verify.exponentials import exponential_jacobian
from exercises.verify.numeric_reference import random_poses
from tests.support.problems import drawn
from tests.support.suites import several

RIGHT = st.sampled_from([sp.S.Zero, sp.pi / 2, sp.pi, -sp.pi / 2])
LENGTH = st.sampled_from([sp.S.Zero, sp.Rational(1, 2), sp.Rational(-3, 10), sp.Symbol("h")])
ODD = st.sampled_from([sp.S.Zero, sp.pi / 6, -sp.pi / 2, sp.Rational(1, 3)])


@st.composite
def chains(draw: st.DrawFn) -> Chain:
    joints = []
    for i in range(1, draw(st.integers(1, 4)) + 1):
        kind = draw(st.sampled_from("RRP"))
        own = sp.Symbol(f"theta{i}" if kind == "R" else f"d{i}") + draw(ODD)
        other = draw(LENGTH) if kind == "R" else draw(ODD)
        theta, d = (own, other) if kind == "R" else (other, own)
        joints.append(Joint(kind, theta, d, draw(LENGTH), draw(st.one_of(RIGHT, ODD))))
    base = Base((draw(LENGTH), draw(LENGTH), draw(LENGTH)), draw(ODD), draw(st.one_of(RIGHT, ODD)))
    point = Point(draw(st.integers(0, len(joints))), (draw(LENGTH), draw(LENGTH), draw(LENGTH)))
    return Chain("any", tuple(joints), ("vx",), base, point)


def values_of(matrix: sp.Matrix, chain: Chain, q: np.ndarray) -> np.ndarray:
    values = {joint.name: np.array([value]) for joint, value in zip(chain.q, q, strict=True)}
    values["h"] = np.array([0.37])
    found = evaluate(compile_program([read(str(entry)) for entry in matrix]), values, 1)[0].real
    return found.reshape(matrix.shape)


@settings(max_examples=several(25, 60))
@given(chains(), st.integers(0, 10**6))
def test_all_routes_agree(chain: Chain, seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-2, 2, chain.n)
    arm = NumericChain(chain, {"h": 0.37})
    poses, jacobian = arm.frames(q), arm.jacobian(q)
    frames, point = frames_and_point(chain)
    for i, (frame, rotation) in enumerate(zip(frames, propagated_rotations(chain), strict=True)):
        np.testing.assert_allclose(values_of(frame.rotation, chain, q), poses[i, :3, :3], atol=1e-12)
        np.testing.assert_allclose(values_of(rotation, chain, q), poses[i, :3, :3], atol=1e-12)
        np.testing.assert_allclose(values_of(frame.origin, chain, q)[:, 0], poses[i, :3, 3], atol=1e-12)
    np.testing.assert_allclose(values_of(point, chain, q)[:, 0], arm.point(q), atol=1e-12)
    np.testing.assert_allclose(values_of(propagated_jacobian(chain), chain, q), jacobian, atol=1e-12)
    np.testing.assert_allclose(values_of(differentiated_jacobian(point, chain.q), chain, q), jacobian[:3], atol=1e-12)
    for i, p_star in enumerate(propagated_p_star(chain)):
        np.testing.assert_allclose(values_of(p_star, chain, q)[:, 0], arm.point(q) - poses[i, :3, 3], atol=1e-12)


@settings(max_examples=60)
@given(chains(), st.integers(0, 10**6))
def test_the_jacobian_is_the_slope_of_the_pose(chain: Chain, seed: int) -> None:
    q = np.random.default_rng(seed).uniform(-2, 2, chain.n)
    arm, h = NumericChain(chain, {"h": 0.37}), 1e-5
    ahead, behind = (arm.frames(q + side * h * np.eye(chain.n)) for side in (1, -1))
    linear = (arm.point_of(ahead) - arm.point_of(behind)).T / (2 * h)
    spin = (ahead - behind)[:, -1, :3, :3] / (2 * h) @ arm.frames(q)[-1, :3, :3].T
    angular = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]])
    np.testing.assert_allclose(arm.jacobian(q), np.vstack([linear, angular]), atol=1e-8)


def test_many_poses_at_once_are_as_one_at_a_time() -> None:
    joints = (Joint("R", sp.Symbol("theta1"), 0, sp.Symbol("a1"), sp.pi / 2), Joint("P", 0, sp.Symbol("d2"), 0, 0))
    arm = NumericChain(Chain("arm", joints, ("vx", "vy")), {"a1": 0.4})
    q = np.random.default_rng(1).uniform(-1, 1, (5, 3, 2))
    assert arm.frames(q).shape == (5, 3, 3, 4, 4)
    assert arm.point(q).shape == (5, 3, 3)
    np.testing.assert_array_equal(arm.jacobian(q)[2, 1], arm.jacobian(q[2, 1]))


def test_an_open_length_needs_a_value() -> None:
    chain = Chain("arm", (Joint("R", sp.Symbol("theta1"), 0, sp.Symbol("a1"), 0),), ("vx",))
    with pytest.raises(KeyError, match="a1"):
        NumericChain(chain, {})


@settings(max_examples=25)
@given(chains())
def test_the_product_of_exponentials_is_the_same_jacobian(chain: Chain) -> None:
    numeric = NumericChain(chain, {symbol.name: 0.3 + 0.1 * i for i, symbol in enumerate(chain.parameters)})
    poses = random_poses(chain, Stream("exponentials"), 6)
    assert np.allclose(exponential_jacobian(numeric, poses), numeric.jacobian(poses), atol=1e-12)


@pytest.mark.parametrize("convention", CONVENTIONS[:2])
def test_the_frames_of_a_structure_are_worked_out_once(convention: str) -> None:
    chain = replace(structure(drawn("elbow-3r", 1).chain).chain, convention=convention)
    assert link_frames(chain) is link_frames(chain)
    assert frames_and_point(chain) is frames_and_point(chain)
