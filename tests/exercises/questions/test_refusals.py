"""A question that does not apply to an arm is refused with the deciding reason; others are not refused."""

from typing import Any

import pytest

from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.questions import QUESTIONS

RANK = ("rank", "lost-direction", "singularity-meaning")
PATH = ("path-rates",)
PERFORMANCE = ("manipulability", "condition-number")
REDUNDANT = ("gram-determinant", "least-norm-rates", "self-motion")
BLOCKS = ("arm-block", "wrist-block", "block-determinants")
TEXTBOOK_CASES = [
    (RANK, "elbow_RRR", ""), (RANK, "cartesian_PPP", "no singular configuration"),
    (RANK[1:2], "pan_tilt_2R", "its 2 joints can never"), (RANK[1:2], "PUMA560", "6 rows"),
    (PATH, "planar_3R_pose", "only linear velocities"), (PATH, "SCARA_RRRP", "only linear velocities"),
    (PATH, "planar_3R_position", "not square"), (PATH, "pan_tilt_2R", "not square"),
    (PATH, "cartesian_PPP", "its Jacobian is constant"),
    (PERFORMANCE, "planar_3R_pose", "different units"), (PERFORMANCE, "PUMA560", "different units"),
    (PERFORMANCE, "pan_tilt_2R", "singular everywhere"), (PERFORMANCE, "cartesian_PPP", "the same in every"),
    (PERFORMANCE[:1], "planar_RP", ""), (PERFORMANCE[1:], "planar_RP", "different units"),
    (REDUNDANT, "planar_2R", "more joints than rows"), (REDUNDANT, "pan_tilt_2R", "more joints than rows"),
    (REDUNDANT, "Scorbot_5R_task_xyz_pitch_roll_at_P", "does not move"),
]  # fmt: skip
FAMILY_CASES = [
    (("joint-torques",), "puma-560", "too many"), (("joint-torques",), "lbr-7r", "too many"),
    (("joint-torques",), "ur-6r", "too many"), (("transform",), "puma-560", "6 joints"),
    (("tool-jacobian",), "ur-6r", "6 joints"), (("tool-jacobian",), "scorbot-tip", "terms"),
    (("tool-jacobian",), "scorbot-wrist", "frame 4"), (BLOCKS, "planar-2r", ""), (BLOCKS, "ur-6r", ""),
    (BLOCKS, "lbr-7r", ""), (BLOCKS, "wrist-zyz", ""), (BLOCKS, "scorbot-tip", ""),
]  # fmt: skip


@pytest.mark.parametrize(("names", "arm", "why"), TEXTBOOK_CASES)
def test_textbook_arm_is_refused_with_a_reason(
    names: tuple[str, ...], arm: str, why: str, textbook_arms: dict[str, Any]
) -> None:
    for name in names:
        refusal = QUESTIONS[name].find_obstacle(textbook_arms[arm].chain)
        assert (refusal is not None and why in refusal) if why else refusal is None, (name, refusal)


@pytest.mark.parametrize(("names", "family", "why"), FAMILY_CASES)
def test_every_arm_of_the_family_is_refused(names: tuple[str, ...], family: str, why: str) -> None:
    for name in names:
        refusals = [QUESTIONS[name].find_obstacle(sample_chain(ProblemId(family, seed))) for seed in range(3)]
        assert all(refusals) and any(why in str(refusal) for refusal in refusals), (name, refusals)
