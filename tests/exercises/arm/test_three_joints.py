"""What an arm of three joints reaches, by a formula and by a search from many starts."""

from itertools import product

import numpy as np
import pytest
import sympy as sp

from exercises.arm.axes import Sample
from exercises.arm.beyond import reached_beyond
from exercises.arm.chain import Chain, Joint
from exercises.arm.kinematics import NumericChain
from exercises.arm.reach import reaches
from exercises.arm.three_joints import NO, UNSURE, YES, reaches_places
from exercises.stream import Stream

TASK = ("vx", "vy", "vz")
EVERY = ["".join(kinds) for kinds in product("RP", repeat=3) if kinds != ("P", "P", "P")]
ARMS, PLACES = 5, 3


def drawn(kinds: str, stream: Stream) -> NumericChain:
    """Return an arm with lengths of which some are zero, and twists of which some are right angles."""
    joints = []
    for i, kind in enumerate(kinds, 1):
        a, d = (round(stream.uniform(0.2, 1), 3) * stream.choice((0, 1)) for _ in range(2))
        a, alpha = a if i < 3 else round(stream.uniform(0.2, 0.9), 3), stream.choice((0, sp.pi / 2, -sp.pi / 2, 0.7))
        other = stream.choice((0, sp.pi / 2, 0.5))
        joints.append(Joint("R", f"theta{i}", d, a, alpha) if kind == "R" else Joint("P", other, f"d{i}", a, alpha))
    return NumericChain(Chain("drawn", tuple(joints), TASK), {})


def found(arm: NumericChain, place: np.ndarray, stream: Stream) -> bool:
    """Look for a configuration with the point in a place, by damped Newton."""
    q = np.array([[stream.uniform(-np.pi, np.pi) for _ in range(3)] for _ in range(60)])
    for _ in range(90):
        frames = arm.frames(q)
        off = place - arm.point_of(frames)
        if np.any(np.linalg.norm(off, axis=1) < 1e-8):
            return True
        jacobian = arm.jacobian_of(frames)[:, :3]
        across = jacobian.swapaxes(1, 2)
        move = (across @ np.linalg.solve(jacobian @ across + 1e-9 * np.eye(3), off[..., None]))[..., 0]
        q += move * np.minimum(1.0, 0.6 / np.maximum(np.abs(move).max(axis=1, keepdims=True), 1e-12))
    return False


@pytest.mark.parametrize("kinds", EVERY)
def test_the_formula_says_what_a_search_finds(kinds: str) -> None:
    stream = Stream(f"three joints/{kinds}")
    asked = 0
    for _ in range(ARMS):
        arm = drawn(kinds, stream)
        poses = np.array([[stream.uniform(-2, 2) for _ in range(3)] for _ in range(PLACES)])
        if np.abs(np.linalg.det(arm.jacobian(poses)[:, :3])).max() < 1e-6:
            continue  # singular everywhere
        elsewhere = np.array([[stream.uniform(-2, 2) for _ in range(3)] for _ in range(PLACES)])
        places = np.concatenate([arm.point(poses), elsewhere])
        told = reaches_places(NumericChain.several([arm] * len(places)), places)
        asked += len(places)
        assert UNSURE not in told
        assert (told[:PLACES] == YES).all()
        for place, answer in zip(places[PLACES:], told[PLACES:], strict=True):
            assert bool(answer == YES) == found(arm, place, stream), (kinds, arm.fixed, place)
            known = reaches(arm, [0, 1, 2], place)
            assert known is None or known == bool(answer == YES)
    assert asked > 2 * PLACES


def elbow(*lengths: float) -> NumericChain:
    a1, a2, a3 = lengths
    rows = (Joint("R", "theta1", 0, a1, -sp.pi / 2), Joint("R", "theta2", 0, a2, 0), Joint("R", "theta3", 0, a3, 0))
    return NumericChain(Chain("elbow", rows, TASK), {})


def test_several_arms_are_asked_at_once() -> None:
    arms = [elbow(0.2, 0.5, 0.4), elbow(0.0, 0.5, 0.4), elbow(0.2, 0.9, 0.2)]
    places = np.array([[1.05, 0.0, 0.0], [1.05, 0.0, 0.0], [0.3, 0.0, 0.1]])
    assert reaches_places(NumericChain.several(arms), places).tolist() == [YES, NO, NO]


def test_the_axis_of_an_elbow_is_inside_of_its_reach_up_to_a_hair() -> None:
    """Two pairs of roots are about to be one: the arm is nearly stretched, with the point on the first axis."""
    arm = elbow(0.2, 0.895, 0.6)
    sample = Sample(arm, np.array([0.03, 1.71462742, -0.02402041]))
    across = np.array([[np.sin(0.03), -np.cos(0.03), 0.0]])
    assert reached_beyond([sample, sample], [0, 1, 2], np.concatenate([across, -across])).all()


def test_a_spherical_arm_whose_slide_is_all_it_has_reaches_what_is_beside_its_centre() -> None:
    rows = (Joint("R", "theta1", 0, 0, -sp.pi / 2), Joint("R", "theta2", 0, 0, sp.pi / 2), Joint("P", 0, "d3", 0, 0))
    sample = Sample(NumericChain(Chain("spherical", rows, TASK), {}), np.array([0.17, -0.28, 0.0]))
    ways = np.concatenate([np.eye(3), -np.eye(3)])
    assert reached_beyond([sample] * 6, [0, 1, 2], ways).all()


def test_a_third_joint_that_moves_nothing_is_told_unsure() -> None:
    rows = (Joint("R", "theta1", 0, 0.5, sp.pi / 2), Joint("R", "theta2", 0, 0.4, 0), Joint("R", "theta3", 0.2, 0, 0))
    arm = NumericChain(Chain("still", rows, TASK), {})
    assert reaches_places(arm, np.array([[0.3, 0.3, 0.2]])).tolist() == [UNSURE]
