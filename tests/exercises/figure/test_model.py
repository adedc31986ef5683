"""Models of arms: what looks alike is drawn once, with labels of its own, and nothing else of an arm is changed."""

import pytest
import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.figure import arm_figure, figure_pose
from exercises.figure.model import model_of
from exercises.figure.pose import told_pose
from exercises.figure.shapes import Figure, extent
from exercises.generation import sample_chain
from exercises.problem import ProblemId

Q1, Q2, Q3 = sp.symbols("theta1 theta2 theta3")


def planar(*rows: tuple[sp.Expr, object], base: Base = Base()) -> Chain:  # noqa: B008 - frozen
    return Chain("arm", tuple(Joint("R", theta, 0, a, 0) for theta, a in rows), ("vx", "vy"), base)


def texts(figure: Figure) -> list[str]:
    return ["".join(run.text for run in text.runs) for text in figure.texts]


def test_arms_that_look_alike_have_one_model_and_their_own_labels() -> None:
    one = planar((Q1 + sp.pi / 4, sp.Rational(45, 100)), (Q2, sp.Rational(3, 10)))
    other = planar((Q1 - sp.pi / 2, sp.Rational(6, 10)), (Q2, sp.Rational(4, 10)))
    assert model_of(one).chain == model_of(other).chain
    first, second = arm_figure(one), arm_figure(other)
    assert first.shapes == second.shapes
    assert [(text.x, text.y) for text in first.texts] == [(text.x, text.y) for text in second.texts]
    assert {"0.45 m", "0.3 m", "θ1 + 45°"} <= set(texts(first))
    assert {"0.6 m", "0.4 m", "θ1 − 90°"} <= set(texts(second))


def test_longer_lengths_are_longer_and_equal_ones_equal() -> None:
    lengths = [sp.Rational(k, 100) for k in (70, 68, 70)]
    rows = model_of(planar(*zip((Q1, Q2, Q3), lengths, strict=True))).chain.joints
    assert rows[0].a == rows[2].a > rows[1].a > 0
    negative = model_of(planar((Q1, sp.Rational(1, 2)), (Q2, -sp.Rational(1, 2)))).chain.joints
    assert negative[0].a == -negative[1].a > 0


def test_an_arm_that_can_have_no_other_is_its_own() -> None:
    """Its base stands at numbers, a label would be too wide, or it has more lengths than there are steps."""
    alone = planar((Q1, sp.Rational(1, 2)), (Q2, sp.Symbol("a2")), base=Base((sp.Rational(1, 3), sp.S.Zero, sp.S.Zero)))
    assert model_of(alone).chain.joints == alone.joints
    wide = planar((Q1 + sp.pi / 180 * sp.Rational(225, 2), sp.Rational(12345, 100)), (Q2, sp.Rational(1, 2)))
    assert model_of(wide).chain.joints == wide.joints
    joints = tuple(Joint("R", f"theta{i}", sp.Rational(i, 10), sp.Rational(i, 7), sp.pi / 2) for i in range(1, 6))
    many = Chain("many", joints, ("vx", "vy", "vz"))
    assert model_of(many).chain.joints == many.joints


def test_symbols_stay_as_they_are() -> None:
    chain = planar((Q1, sp.Symbol("a1")), (Q2 + sp.Symbol("beta"), sp.Rational(1, 4)))
    joints = model_of(chain).chain.joints
    assert (joints[0].a, joints[1].theta) == (chain.joints[0].a, chain.joints[1].theta)


@pytest.mark.parametrize("name", ["polar-rp/5", "random-3/4", "cylindrical/3@modified-dh", "planar-rpr/4@full"])
def test_a_pose_of_the_model_is_the_arms(name: str) -> None:
    """Slides are as much longer as the arm is, and angles the same, with other zeros."""
    chain = sample_chain(ProblemId.parse(name))
    model, pose = model_of(chain), figure_pose(chain)
    entries = told_pose(model.chain, dict(model.pose(pose)))
    assert model.entries(entries) == pytest.approx(told_pose(chain, pose), abs=1e-8)


@pytest.mark.parametrize("name", ["planar-3r/2", "elbow-3r/8", "scara/2", "puma-560/1"])
def test_the_arms_labels_find_the_room_that_its_models_have(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    for text in arm_figure(chain).texts:
        width = sum(extent(((run.text, run.italic, run.size < 15.0),))[0] - 2.0 for run in text.runs) + 2.0
        assert width <= text.box[2] - text.box[0] + 1e-6
