"""Questions about drawings: is what is said of this configuration true, and which of these is singular?"""

from collections.abc import Iterator
from dataclasses import dataclass

from qdot.exercises.answers import TRUE_FALSE, Choice
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.questions.base import Asked
from qdot.exercises.questions.geometry import AtPose, precise, regular_pose, shown_pose
from qdot.exercises.quizzes.asking import short_question
from qdot.exercises.quizzes.options import Places
from qdot.exercises.quizzes.places import drawn_lengths, regular_poses, several, singular_poses, words

SEEN = 0.08
"""Least component of a velocity (m/s for a unit rate) whose sign is asked for: it is seen in the drawing."""


@dataclass(frozen=True, kw_only=True)
class Said(AtPose):
    """What is said of a pose: "singular", or "moves"."""

    said: str


@dataclass(frozen=True, kw_only=True)
class SaidOfJoint(Said):
    """That a joint (from 1) moves the point to one side along an axis: `row` is the component of its velocity."""

    joint: int
    row: str
    positive: bool


# --- true or false ---


def _true_or_false(chain: Chain, rng: Stream) -> Asked | None:
    """Draw first whether it is true, then what is said."""
    truth = rng.choice((True, False))
    for _ in range(30):
        for said in _statements(chain, truth, rng):
            return Choice(TRUE_FALSE, TRUE_FALSE.index("true" if truth else "false")), said
    return None


def _statements(chain: Chain, truth: bool, rng: Stream) -> Iterator[Said]:
    for kind in rng.shuffled(("singular", "moves")):
        if kind == "singular" and (components := singular_set(chain)):
            pose = shown_pose(chain, (rng.choice(components),), rng) if truth else regular_pose(chain, rng, 0.12)
            if pose is not None:
                yield Said(said="singular", place=pose, pose=pose.figure)
        if kind == "moves":
            yield from _motion(chain, truth, rng)


def _motion(chain: Chain, truth: bool, rng: Stream) -> Iterator[Said]:
    """Say of one joint which way it moves the point along one axis; what is false has the other sign."""
    pose = regular_pose(chain, rng, 0.05, slips=False)
    if pose is None:
        return
    linear = precise(chain, pose, derive(chain).linear)
    seen = [(row, joint) for row in range(3) for joint in range(chain.n) if abs(float(linear[row, joint])) > SEEN]
    if seen:
        row, joint = rng.choice(seen)
        positive = bool(linear[row, joint] > 0) == truth
        yield SaidOfJoint(
            said="moves", place=pose, pose=pose.figure, joint=joint + 1, row=TASK_ROWS[row], positive=positive
        )


# --- which drawing? ---


def _which_drawing(chain: Chain, rng: Stream) -> Asked | None:
    for _ in range(4):
        arm, lengths = drawn_lengths(chain, rng)
        right = several(singular_poses(arm, rng), 1)
        wrong = several(regular_poses(arm, rng), 3, [pose for pose, _ in right])
        if right and len(wrong) == 3:
            order = rng.shuffled([*right, *wrong])
            places, blames = (tuple(column) for column in zip(*order, strict=True))
            answer = Choice(tuple(words(pose) for pose in places), order.index(right[0]))
            return answer, Places(places=places, lengths=lengths, blames=blames, drawn=True)
    return None


DRAWN = (
    short_question(
        "true-or-false", "True or false?", "6.12", _true_or_false, "true or false", "jacobian",
        "nothing can be said of its configurations",
        undiagnosed="one of two answers tells of no way to it",
    ),
    short_question(
        "singular-drawing", "Which drawing shows a singular configuration?", "6.8", _which_drawing, "choice",
        "singular-angles", "it has no four configurations to choose from", ("singular-angles",),
    ),
)  # fmt: skip
