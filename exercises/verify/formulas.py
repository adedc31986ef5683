"""Check reference formulas against independent numeric computations at random samples.

A reference is the correct answer to a part of a problem. A sample is an arm with numeric lengths in a configuration.
"""

from collections.abc import Callable

import numpy as np

from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.differentiation import AxisDetails, list_linear_task_rows
from qdot.exercises.questions.propagation import FrameDetails, RecursionDetails
from qdot.exercises.verify.numeric_model import Check, Checks, NumericModel

EXACT_TOLERANCE, DIFFERENCE_TOLERANCE = 1e-9, 1e-7
"""Relative error allowed when a reference is compared with products of matrices, and with finite differences."""


def check_agreement(name: str, values: np.ndarray, expected: np.ndarray, tolerance: float) -> Check:
    """Check that values agree with the expected values within a relative error; both are (samples, rows, columns)."""
    if values.shape != expected.shape:
        shapes = [" x ".join(map(str, array.shape[1:])) for array in (values, expected)]
        return Check(name, False, f"the reference is {shapes[0]}, expected {shapes[1]}")
    scale = 1 + np.abs(expected).max(axis=(1, 2), keepdims=True)
    error = np.where(np.isfinite(values), np.abs(values - expected) / scale, np.inf)
    worst_index = np.unravel_index(int(error.argmax()), error.shape)
    if error[worst_index] <= tolerance:
        return Check(name, True, f"{len(values)} samples, error at most {error[worst_index]:.1e}")
    position = f"entry ({worst_index[1] + 1}, {worst_index[2] + 1})"
    return Check(name, False, f"{position}: {values[worst_index]:.6g}, expected {expected[worst_index]:.6g}")


ExpectedValues = dict[str, tuple[np.ndarray, float]]
"""Maps the name of each independent method to the values that it computes and the relative error that is allowed."""
PartCheck = Callable[[NumericModel, Part], Checks]
"""A function that checks the reference answer of a part against numeric computations."""


def make_formula_check(compute_expected: Callable[[NumericModel, Part], ExpectedValues]) -> PartCheck:
    """Return a function that compares a symbolic reference with the values that each independent method computes."""

    def check(model: NumericModel, part: Part) -> Checks:
        reference_values = model.evaluate_printed_formulas(part.answer.as_matrix())
        for name, (expected, tolerance) in compute_expected(model, part).items():
            yield check_agreement(name, reference_values, expected, tolerance)

    return check


def make_jacobian_check(compute: Callable[[NumericModel, Part, np.ndarray], np.ndarray]) -> PartCheck:
    """Return a function that compares a symbolic reference with a function of the 6 x n Jacobian, (…, 6, n).

    The Jacobian is computed by three methods: from frames, by finite differences and with exponentials.
    """

    def compute_expected(model: NumericModel, part: Part) -> ExpectedValues:
        return {
            "frames": (compute(model, part, model.jacobian), EXACT_TOLERANCE),
            "finite differences": (compute(model, part, model.finite_difference_jacobian), DIFFERENCE_TOLERANCE),
            "product of exponentials": (compute(model, part, model.exponential_jacobian), EXACT_TOLERANCE),
        }

    return make_formula_check(compute_expected)


def _list_convention_rows(model: NumericModel) -> list[int]:
    """Return the indices of the rows of the 6 x n Jacobian in the order of the arm's convention."""
    return [VELOCITY_NAMES.index(row) for row in convention_of(model.chain).velocity_names]


def _transpose(matrices: np.ndarray) -> np.ndarray:
    return matrices.swapaxes(1, 2)


def _compute_position_vectors(model: NumericModel, _: Part) -> ExpectedValues:
    """Return the vectors from the origin of a frame on each joint axis to the tool point."""
    first_frame, n = convention_of(model.chain).find_frame_on_axis(1), model.chain.n
    origins = model.convention_frames[:, first_frame : first_frame + n, :3, 3]
    return {"frames": (_transpose(model.point[:, None] - origins), EXACT_TOLERANCE)}


def _compute_link_velocity(model: NumericModel, part: Part) -> ExpectedValues:
    """Return the velocity of a frame's origin and the angular velocity of its link, in the world frame."""
    frame_velocities = model.convention_velocities[:, :, part.details_as(FrameDetails).frame]
    return {"finite differences": (_transpose(frame_velocities) @ model.rates, DIFFERENCE_TOLERANCE)}


def _compute_velocity_in_own_frame(model: NumericModel, part: Part) -> ExpectedValues:
    """Return the velocity of a frame's origin and the angular velocity of its link, in this frame."""
    frame = part.details_as(RecursionDetails).frame
    velocity = _transpose(model.convention_velocities[:, :, frame]) @ model.rates
    rotated_velocity = _rotate_halves(_transpose(model.convention_frames[:, frame, :3, :3]), velocity)
    return {"finite differences": (rotated_velocity, DIFFERENCE_TOLERANCE)}


def _rotate_halves(rotation: np.ndarray, velocities: np.ndarray) -> np.ndarray:
    """Return velocities (…, 6, k) with the linear and the angular half of each rotated by a matrix (…, 3, 3)."""
    return np.concatenate([rotation @ velocities[:, :3], rotation @ velocities[:, 3:]], axis=1)


def _make_product_check(compute_expected: Callable[[NumericModel], np.ndarray]) -> PartCheck:
    """Return a function that checks that the task Jacobian times the reference gives the expected values."""

    def check(model: NumericModel, part: Part) -> Checks:
        expected = compute_expected(model)
        values = model.evaluate_printed_formulas(part.answer.as_matrix())
        if values.shape == expected.shape:
            scale = (np.abs(model.task_jacobian) @ np.abs(values)).max(axis=(1, 2), keepdims=True)
            values, expected = model.task_jacobian @ values / scale, expected / scale
        yield check_agreement("J times it", values, expected, EXACT_TOLERANCE)

    return check


# --- transforms, wrists and statics ---


def _rotate_to_tool_frame(model: NumericModel, _: Part, jacobian: np.ndarray) -> np.ndarray:
    """Return the geometric Jacobian in the frame of the last link."""
    return _rotate_halves(_transpose(model.convention_frames[:, -1, :3, :3]), jacobian)


def _compute_wrist_block(model: NumericModel, _: Part, jacobian: np.ndarray) -> np.ndarray:
    """Return the angular rows of J for the wrist's joints, in the frame on the axis of joint 4."""
    frame = convention_of(model.chain).find_frame_on_axis(4)
    return _transpose(model.convention_frames[:, frame, :3, :3]) @ jacobian[:, 3:, 3:]


def _check_block_determinants(model: NumericModel, part: Part) -> Checks:
    """Check the determinants of the arm block and the wrist block, and that their product is det J of all six rows."""
    reference_values = model.evaluate_printed_formulas(part.answer.as_matrix())
    blocks = (model.jacobian[:, :3, :3], _transpose(model.frames[:, 3, :3, :3]) @ model.jacobian[:, 3:, 3:])
    expected = np.stack([np.linalg.det(block) for block in blocks], axis=1)[:, :, None]
    yield check_agreement("LU decomposition", reference_values, expected, EXACT_TOLERANCE)
    if reference_values.shape == expected.shape:
        products = reference_values.prod(axis=1, keepdims=True)
        full_determinant = np.linalg.det(model.task_jacobian)[:, None, None]
        yield check_agreement("their product is det J", products, full_determinant, EXACT_TOLERANCE)
    largest_entry = np.abs(model.jacobian[:, :3, 3:]).max()
    detail = f"largest entry of J12: {largest_entry:.1e}"
    yield Check("the wrist does not move P", bool(largest_entry < EXACT_TOLERANCE), detail)


def _compute_joint_torques(model: NumericModel, part: Part, jacobian: np.ndarray) -> np.ndarray:
    """Return the joint torques. Torque i is the power of the force when only joint i moves, at unit rate."""
    force = np.stack([model.symbol_values[name] for name in part.symbols], axis=1)
    return np.einsum("pij,pi->pj", jacobian[:, model.task_rows], force)[:, :, None]


def _compute_gram_determinant(model: NumericModel, _: Part, jacobian: np.ndarray) -> np.ndarray:
    rows = jacobian[:, model.task_rows]
    return np.asarray(np.linalg.det(rows @ _transpose(rows)))[:, None, None]


CHECKS: dict[str, PartCheck] = {
    "position": make_formula_check(
        lambda model, _: {"frames": (model.point[:, list_linear_task_rows(model.chain), None], EXACT_TOLERANCE)}
    ),
    "velocity": make_jacobian_check(
        lambda model, _, jacobian: jacobian[:, list_linear_task_rows(model.chain)] @ model.rates
    ),
    "velocity-component": make_jacobian_check(
        lambda model, part, jacobian: jacobian[:, [part.details_as(AxisDetails).row]] @ model.rates
    ),
    "jacobian": make_jacobian_check(lambda model, _, jacobian: jacobian[:, model.task_rows]),
    "joint-axes": make_formula_check(
        lambda model, _: {"frames": (_transpose(model.frames[:, :-1, :3, 2]), EXACT_TOLERANCE)}
    ),
    "position-vectors": make_formula_check(_compute_position_vectors),
    "geometric-jacobian": make_jacobian_check(lambda model, _, jacobian: jacobian[:, _list_convention_rows(model)]),
    "twist": make_jacobian_check(lambda model, _, jacobian: jacobian[:, _list_convention_rows(model)] @ model.rates),
    "link-velocity": make_formula_check(_compute_link_velocity),
    "own-frame-velocity": make_formula_check(_compute_velocity_in_own_frame),
    "determinant": make_formula_check(
        lambda model, _: {"LU decomposition": (np.linalg.det(model.task_jacobian)[:, None, None], EXACT_TOLERANCE)}
    ),
    "inverse-jacobian": _make_product_check(
        lambda model: np.broadcast_to(np.eye(model.chain.n), model.task_jacobian.shape)
    ),
    "inverse-velocity": _make_product_check(lambda model: model.task_velocities),
    "transform": make_formula_check(lambda model, _: {"frames": (model.convention_frames[:, -1], EXACT_TOLERANCE)}),
    "tool-jacobian": make_jacobian_check(_rotate_to_tool_frame),
    "arm-block": make_jacobian_check(lambda _model, _part, jacobian: jacobian[:, :3, :3]),
    "wrist-block": make_jacobian_check(_compute_wrist_block),
    "block-determinants": _check_block_determinants,
    "joint-torques": make_jacobian_check(_compute_joint_torques),
    "gram-determinant": make_jacobian_check(_compute_gram_determinant),
}
