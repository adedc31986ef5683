"""The wrist-partitioned problem of six joints: det J = det J11 det J22.

Where the axes of the last three joints meet in P, these joints do not move P: columns 4 to 6 of J have no linear
part, and J is block triangular. J11 (3 x 3) is what the arm does to P, J22 what the wrist does to the hand's turn.
"""

from functools import lru_cache

import sympy as sp

from exercises.arm.chain import TASK_ROWS, Chain, Point
from exercises.arm.classification import wrist_centre
from exercises.arm.derivation import derive, structure
from exercises.arm.kinematics import Z, frame_behind
from exercises.arm.trigonometry import Factored, factored, textbook
from exercises.problem import Matrix
from exercises.questions.base import Asked, Question, square
from exercises.stream import Stream


@lru_cache(maxsize=1024)
def _wrist_axes(generic: Chain) -> sp.Matrix:
    """Return z_3, z_4, z_5 of a structure in the coordinates of frame 3 (3 x 3)."""
    axes = [frame_behind(generic.joints[3:i]).rotation * Z for i in (3, 4, 5)]
    return sp.Matrix.hstack(*axes).applyfunc(lambda entry: textbook(sp.expand(entry)))


@lru_cache(maxsize=1024)
def _determinants(generic: Chain) -> tuple[Factored, Factored]:
    """Return det J11 and det J22 of a structure; J11 is seen from frame 1, which keeps its determinant."""
    arm = derive(generic).geometric[:3, :3]
    return factored(sp.expand(arm.det(method="berkowitz"))), factored(sp.expand(_wrist_axes(generic).det()))


def arm_block(chain: Chain) -> sp.Matrix:
    """Return J11, the linear rows of joints 1 to 3, world frame (3 x 3)."""
    return derive(chain).geometric[:3, :3]


def wrist_block(chain: Chain) -> sp.Matrix:
    """Return J22, the axes of joints 4 to 6, in frame 3 (3 x 3)."""
    return _wrist_axes(structure(chain).chain).applyfunc(derive(chain).fill)


def block_determinants(chain: Chain) -> sp.Matrix:
    """Return [det J11, det J22] in factored form."""
    values = dict(structure(chain).values)
    return sp.Matrix([found.substituted(values) for found in _determinants(structure(chain).chain)])


def _arm(chain: Chain, rng: Stream) -> Asked:
    return Matrix(arm_block(chain)), {}


def _wrist(chain: Chain, rng: Stream) -> Asked:
    return Matrix(wrist_block(chain)), {}


def _both(chain: Chain, rng: Stream) -> Asked:
    return Matrix(block_determinants(chain)), {"arm": arm_block(chain), "wrist": wrist_block(chain)}


def not_partitioned(chain: Chain) -> str | None:
    """Return the objection to arms whose Jacobian does not fall into blocks at P."""
    if chain.n != 6 or chain.task != TASK_ROWS:
        return "it has not six joints for all six rows"
    centre = wrist_centre(chain)
    if centre is None or chain.point != Point(centre):
        return "the axes of its last three joints do not meet in its point"
    return square(chain)


QUESTIONS = (
    Question("arm-block", "Arm block of the Jacobian", "6.12", _arm, (), 2.0, not_partitioned),
    Question("wrist-block", "Wrist block of the Jacobian", "6.12", _wrist, (), 1.0, not_partitioned),
    Question(
        "block-determinants", "Determinants of the blocks", "6.8", _both, ("arm-block", "wrist-block"), 2.0,
        not_partitioned,
    ),
)  # fmt: skip
