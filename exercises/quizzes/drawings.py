"""Questions about drawings: is a statement about this configuration true, and which of these is singular?"""

from collections.abc import Iterator
from dataclasses import dataclass

from qdot.exercises.answers import TRUE_FALSE, Choice
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions.base import Asked
from qdot.exercises.questions.geometry import AtPose, evaluate_precisely, sample_regular_pose, sample_shown_pose
from qdot.exercises.quizzes.asking import ShortQuestion
from qdot.exercises.quizzes.options import Places
from qdot.exercises.quizzes.places import regular_poses, singular_poses, take_distinct, with_random_lengths, write_pose

SEEN = 0.08
"""Least component of a velocity (m/s for a unit rate) whose sign is asked for, large enough to see in the drawing."""


@dataclass(frozen=True, kw_only=True)
class PoseStatement(AtPose):
    """A statement about a pose; `said` is "singular" or "moves", a name that the digests of problems hold."""

    said: str


@dataclass(frozen=True, kw_only=True)
class JointStatement(PoseStatement):
    """The statement that a joint (from 1) moves the point in one sense along an axis, that of the velocity in `row`."""

    joint: int
    row: str
    positive: bool


# --- true or false ---


def _ask_true_or_false(chain: Chain, rng: Stream) -> Asked | None:
    """Choose whether the statement is true, then the statement."""
    truth = rng.choice((True, False))
    for _ in range(30):
        for statement in _sample_statements(chain, truth, rng):
            return Choice(TRUE_FALSE, TRUE_FALSE.index("true" if truth else "false")), statement
    return None


def _sample_statements(chain: Chain, truth: bool, rng: Stream) -> Iterator[PoseStatement]:
    for kind in rng.permutation(("singular", "moves")):
        if kind == "singular" and (components := singular_set(chain)):
            if truth:
                pose = sample_shown_pose(chain, (rng.choice(components),), rng)
            else:
                pose = sample_regular_pose(chain, rng, 0.12)
            if pose is not None:
                yield PoseStatement(said="singular", place=pose, pose=pose.figure)
        if kind == "moves":
            yield from _sample_joint_statements(chain, truth, rng)


def _sample_joint_statements(chain: Chain, truth: bool, rng: Stream) -> Iterator[PoseStatement]:
    """Yield in which sense a joint moves the point along an axis; a false statement has the opposite sign."""
    pose = sample_regular_pose(chain, rng, 0.05, misleading=False)
    if pose is None:
        return
    linear = evaluate_precisely(chain, pose, derive(chain).linear)
    seen = [(row, joint) for row in range(3) for joint in range(chain.n) if abs(float(linear[row, joint])) > SEEN]
    if seen:
        row, joint = rng.choice(seen)
        positive = bool(linear[row, joint] > 0) == truth
        yield JointStatement(
            said="moves", place=pose, pose=pose.figure, joint=joint + 1, row=TASK_ROWS[row], positive=positive
        )


# --- which drawing? ---


def _ask_which_drawing(chain: Chain, rng: Stream) -> Asked | None:
    for _ in range(4):
        arm, lengths = with_random_lengths(chain, rng)
        right = take_distinct(singular_poses(arm, rng), 1)
        wrong = take_distinct(regular_poses(arm, rng), 3, [pose for pose, _ in right])
        if right and len(wrong) == 3:
            order = rng.permutation([*right, *wrong])
            places, blames = (tuple(column) for column in zip(*order, strict=True))
            answer = Choice(tuple(write_pose(pose) for pose in places), order.index(right[0]))
            return answer, Places(places=places, lengths=lengths, blames=blames, drawn=True)
    return None


DRAWN = (
    ShortQuestion(
        "true-or-false", "True or false?", "6.12", sample=_ask_true_or_false, form="true or false", about="jacobian",
        otherwise="nothing can be said of its configurations",
    ),
    ShortQuestion(
        "singular-drawing", "Which drawing shows a singular configuration?", "6.8", sample=_ask_which_drawing,
        form="choice", about="singular-angles", otherwise="it has no four configurations to choose from",
        shows=("singular-angles",),
    ),
)  # fmt: skip
