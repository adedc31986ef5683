"""The pose in which an arm is drawn of its own accord, which the site's live arm takes, too; which poses are tried."""

import pytest

from exercises.arm.chain import Chain
from exercises.figure import arm_figure, figure_pose
from exercises.figure.pose import DEFAULT_LENGTH, candidates
from exercises.figure.shapes import Circle
from exercises.generation import sample_chain
from exercises.problem import ProblemId


def _point(chain: Chain, pose: dict[str, float] | None) -> tuple[float, float]:
    (dot,) = [s for s in arm_figure(chain, pose).shapes if isinstance(s, Circle) and s.style == "point"]
    return dot.center


@pytest.mark.parametrize("family", ["planar-2r", "planar-pr", "planar-3r"])
def test_a_flat_arm_in_that_pose_has_its_point_at_the_same_place(family: str) -> None:
    chain = sample_chain(ProblemId(family, 3, variation="full"))
    pose = figure_pose(chain)
    assert list(pose) == [q.name for q in chain.q]
    assert _point(chain, pose) == pytest.approx(_point(chain, None), abs=0.5)
    other = {name: value + 0.5 for name, value in pose.items()}
    assert _point(chain, other) != pytest.approx(_point(chain, None), abs=5)


@pytest.mark.parametrize(("family", "least", "most"), [("polar-rp", 1.5, 2.0), ("scara", 0.5, 1.0)])
def test_a_slide_is_drawn_longer_than_any_link_in_the_plane_and_only_there(
    family: str, least: float, most: float
) -> None:
    """In the plane its sleeve and its rod are seen from the side, and take room."""
    chain = sample_chain(ProblemId(family, 0))
    slide = next(i for i, joint in enumerate(chain.joints) if joint.kind == "P")
    lengths = [abs(float(v)) for joint in chain.joints for v in (joint.a, joint.d) if v.is_number]
    extensions = candidates(chain, chain)[:, slide] / (max([*lengths, 0.0]) or DEFAULT_LENGTH)
    assert least <= extensions.min() and extensions.max() <= most
