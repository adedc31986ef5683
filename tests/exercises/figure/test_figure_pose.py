"""The pose in which an arm is drawn of its own accord, as the site's live arm takes it."""

import pytest

from exercises.arm.chain import Chain
from exercises.figure import arm_figure, figure_pose
from exercises.figure.shapes import Circle
from exercises.generation import generate
from exercises.problem import ProblemId


def _arm(family: str, variation: str) -> Chain:
    return generate(ProblemId(family, 3, ("position",), variation=variation)).chain


def _point(chain: Chain, pose: dict[str, float] | None) -> tuple[float, float]:
    (dot,) = [s for s in arm_figure(chain, pose).shapes if isinstance(s, Circle) and s.style == "point"]
    return dot.center


@pytest.mark.parametrize("family", ["planar-2r", "planar-pr", "planar-3r"])
def test_a_flat_arm_told_that_pose_has_its_point_at_the_same_place(family: str) -> None:
    chain = _arm(family, "full")
    assert _point(chain, figure_pose(chain)) == pytest.approx(_point(chain, None), abs=0.5)
    other = {name: value + 0.5 for name, value in figure_pose(chain).items()}
    assert _point(chain, other) != pytest.approx(_point(chain, None), abs=5)


def test_every_joint_is_told() -> None:
    assert list(figure_pose(_arm("scara", "chapter"))) == ["theta1", "theta2", "d3", "theta4"]
