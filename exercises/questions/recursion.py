"""A question on velocities from frame to frame in each frame's own coordinates, for arms with a modified table (Craig).

With R = R_{i-1,i}^T and P_i the origin of frame i in frame i-1, and each vector in the frame of its prefix:

    i_omega_i = R i-1_omega_i-1 + qd_i z,   i_v_i = R (i-1_v_i-1 + i-1_omega_i-1 x P_i)           revolute
    i_omega_i = R i-1_omega_i-1,            i_v_i = R (i-1_v_i-1 + i-1_omega_i-1 x P_i) + qd_i z   prismatic
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES_OF_JOINTS
from qdot.exercises.arm.derivation import derive, symbolic_arm_of
from qdot.exercises.arm.derivation_graph import Working
from qdot.exercises.arm.kinematics import Z
from qdot.exercises.arm.trigonometry import count_terms, textbook_form
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details
from qdot.exercises.questions.base import MAX_TERMS, Question, name_velocity_components

LAST_FRAME = 3
"""The last frame that is asked for; later frames are too much work by hand."""


@dataclass(frozen=True)
class RecursionStep:
    """One step of the recursion: the rotation from the previous frame, the origin in that frame, omega and v.

    The velocities are in the coordinates of the new frame.
    """

    number: int
    kind: str
    rotation: sp.Matrix
    origin: sp.Matrix
    omega: sp.Matrix
    v: sp.Matrix


@dataclass(frozen=True, kw_only=True)
class RecursionDetails(Details):
    """Details of a question about the velocity of a frame, with the steps of the recursion up to it."""

    frame: int
    steps: tuple[RecursionStep, ...]


@lru_cache(maxsize=1024)
def _derive_steps(generic: Chain) -> tuple[RecursionStep, ...]:
    """Return the steps of the recursion for all frames of a structure."""
    omega = v = sp.zeros(3, 1)
    steps = []
    convention = convention_of(generic)
    for number, (row, rate) in enumerate(zip(convention.rows, generic.rates, strict=True), 1):
        rotation, origin = convention.rotation(row).T, convention.link_vector(row)
        joint_velocity = rate * Z
        v = _collect_rates(rotation * (v + omega.cross(origin)), generic)
        omega = _collect_rates(rotation * omega, generic)
        v, omega = (v, omega + joint_velocity) if row.is_revolute else (v + joint_velocity, omega)
        steps.append(RecursionStep(number, row.kind, rotation, origin, omega, v))
    return tuple(steps)


def _collect_rates(vector: sp.Matrix, generic: Chain) -> sp.Matrix:
    """Return a vector with each entry as a sum over the joint rates, and their coefficients in textbook form."""

    def entry(value: sp.Expr) -> sp.Expr:
        value = sp.expand(value)
        return sp.Add(*(textbook_form(value.coeff(rate)) * rate for rate in generic.rates if value.coeff(rate) != 0))

    return vector.applyfunc(entry)


def _choose_frame(chain: Chain, rng: Stream) -> RecursionDetails:
    fill, frame = derive(chain).substitute_matrix, rng.choice(_find_frames(chain))
    steps = (
        RecursionStep(step.number, step.kind, *map(fill, (step.rotation, step.origin, step.omega, step.v)))
        for step in _derive_steps(symbolic_arm_of(chain).chain)[:frame]
    )
    return RecursionDetails(frame=frame, steps=tuple(steps))


def _find_frames(chain: Chain) -> list[int]:
    """Return the frames whose velocity depends on more than one joint and can be worked out by hand."""
    return [frame for frame in range(2, min(chain.n, LAST_FRAME) + 1) if _count_terms(chain, frame) <= MAX_TERMS]


@lru_cache(maxsize=4096)
def _count_terms(chain: Chain, frame: int) -> int:
    step = _derive_steps(symbolic_arm_of(chain).chain)[frame - 1]
    return count_terms(derive(chain).substitute_matrix(step.v.col_join(step.omega)))


def _object_to_length(chain: Chain) -> str | None:
    return None if _find_frames(chain) else "the velocities of its frames are too long to work out by hand"


def _derive_velocity(w: Working, details: Details) -> np.ndarray:
    assert isinstance(details, RecursionDetails)
    return apply_matrix(w.for_first_joints(details.frame)["tool jacobian"], w["joint rates"][: details.frame])


def _write_velocity(chain: Chain, details: Details) -> sp.Matrix:
    assert isinstance(details, RecursionDetails)
    return details.steps[-1].v.col_join(details.steps[-1].omega)


QUESTIONS = (
    Question(
        "own-frame-velocity", "Velocity of a frame in its own coordinates", "6.9 and 6.10", points=2.0,
        required_feature=FRAMES_OF_JOINTS, formula=_derive_velocity, reference=_write_velocity,
        make_details=_choose_frame, entry_names=lambda chain, _: name_velocity_components(TASK_ROWS),
        too_long=_object_to_length, objection=lambda chain: None if chain.n > 1 else "it has one joint",
    ),
)  # fmt: skip
