"""Check reference formulas against independent numeric computations at random samples."""

from collections.abc import Callable

import numpy as np

from qdot.exercises.arm.chain import TASK_ROWS
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.differentiation import AxisDetails, list_linear_task_rows
from qdot.exercises.questions.propagation import FrameDetails, RecursionDetails
from qdot.exercises.verify.numeric_reference import Check, Checks, NumericReference

EXACT_TOLERANCE, DIFFERENCE_TOLERANCE = 1e-9, 1e-7
"""Relative error allowed when a reference is compared with products of matrices, and with finite differences."""


def check_agreement(name: str, values: np.ndarray, expected: np.ndarray, tolerance: float) -> Check:
    """Check that values agree with the expected values within a relative error; both are (…, rows, columns)."""
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
"""Maps the name of each independent method to the values that it computes and the relative error allowed."""
PartCheck = Callable[[NumericReference, Part], Checks]
"""A function that checks the reference answer of a part against numeric computations."""


def make_formula_check(compute_expected: Callable[[NumericReference, Part], ExpectedValues]) -> PartCheck:
    """Return a function that compares a symbolic reference with the values that each independent method computes."""

    def check(numeric: NumericReference, part: Part) -> Checks:
        reference_values = numeric.evaluate_printed_formulas(part.answer.as_matrix())
        for name, (expected, tolerance) in compute_expected(numeric, part).items():
            yield check_agreement(name, reference_values, expected, tolerance)

    return check


def apply_three_methods(numeric: NumericReference, function: Callable[[np.ndarray], np.ndarray]) -> ExpectedValues:
    """Apply a function to the 6 x n Jacobian from each of three methods: frames, differences and exponentials."""
    return {
        "frames": (function(numeric.jacobian), EXACT_TOLERANCE),
        "finite differences": (function(numeric.finite_difference_jacobian), DIFFERENCE_TOLERANCE),
        "product of exponentials": (function(numeric.exponential_jacobian), EXACT_TOLERANCE),
    }


def _position(numeric: NumericReference, _: Part) -> ExpectedValues:
    return {"frames": (numeric.point[:, list_linear_task_rows(numeric.chain), None], EXACT_TOLERANCE)}


def _velocity(numeric: NumericReference, _: Part) -> ExpectedValues:
    rows = list_linear_task_rows(numeric.chain)
    return apply_three_methods(numeric, lambda jacobian: jacobian[:, rows] @ numeric.rates)


def _velocity_component(numeric: NumericReference, part: Part) -> ExpectedValues:
    row = part.details_as(AxisDetails).row
    return apply_three_methods(numeric, lambda jacobian: jacobian[:, [row]] @ numeric.rates)


def _jacobian(numeric: NumericReference, _: Part) -> ExpectedValues:
    return apply_three_methods(numeric, lambda jacobian: jacobian[:, numeric.task])


def _joint_axes(numeric: NumericReference, _: Part) -> ExpectedValues:
    return {"frames": (numeric.frames[:, :-1, :3, 2].transpose(0, 2, 1), EXACT_TOLERANCE)}


def _position_vectors(numeric: NumericReference, _: Part) -> ExpectedValues:
    """Return the vectors from the origin of a frame on each joint axis to the tool point."""
    first_frame, n = convention_of(numeric.chain).frame_on_axis(1), numeric.chain.n
    origins = numeric.convention_frames[:, first_frame : first_frame + n, :3, 3]
    return {"frames": ((numeric.point[:, None] - origins).transpose(0, 2, 1), EXACT_TOLERANCE)}


def _geometric_jacobian(numeric: NumericReference, _: Part) -> ExpectedValues:
    """Return the geometric Jacobian, with its rows in the order of the arm's convention."""
    order = [TASK_ROWS.index(row) for row in convention_of(numeric.chain).velocity_names]
    return apply_three_methods(numeric, lambda jacobian: jacobian[:, order])


def _twist(numeric: NumericReference, _: Part) -> ExpectedValues:
    order = [TASK_ROWS.index(row) for row in convention_of(numeric.chain).velocity_names]
    return apply_three_methods(numeric, lambda jacobian: jacobian[:, order] @ numeric.rates)


def _link_velocity(numeric: NumericReference, part: Part) -> ExpectedValues:
    frame = part.details_as(FrameDetails).frame
    frame_velocities = numeric.convention_velocities[:, :, frame].transpose(0, 2, 1)
    return {"finite differences": (frame_velocities @ numeric.rates, DIFFERENCE_TOLERANCE)}


def _own_frame_velocity(numeric: NumericReference, part: Part) -> ExpectedValues:
    """Return the linear and the angular velocity of a link, in the frame of that link."""
    frame = part.details_as(RecursionDetails).frame
    velocity = (numeric.convention_velocities[:, :, frame].transpose(0, 2, 1) @ numeric.rates)[..., 0]
    rotation_to_link, halves = (
        numeric.convention_frames[:, frame, :3, :3].swapaxes(1, 2),
        (velocity[:, :3], velocity[:, 3:]),
    )
    local_velocity = np.concatenate([np.einsum("kij,kj->ki", rotation_to_link, half) for half in halves], axis=1)
    return {"finite differences": (local_velocity[..., None], DIFFERENCE_TOLERANCE)}


def _determinant(numeric: NumericReference, _: Part) -> ExpectedValues:
    return {"LU decomposition": (np.linalg.det(numeric.task_jacobian)[:, None, None], EXACT_TOLERANCE)}


def _check_inverse(numeric: NumericReference, part: Part) -> Checks:
    """Check that the Jacobian times its inverse is the identity."""
    yield _check_product(numeric, part, np.broadcast_to(np.eye(numeric.chain.n), numeric.task_jacobian.shape))


def _check_inverse_velocity(numeric: NumericReference, part: Part) -> Checks:
    """Check that the Jacobian times the rates is the desired velocity."""
    yield _check_product(numeric, part, numeric.task_velocities)


def _check_product(numeric: NumericReference, part: Part, expected: np.ndarray) -> Check:
    reference_values = numeric.evaluate_printed_formulas(part.answer.as_matrix())
    if reference_values.shape != expected.shape:
        return check_agreement("J times it", reference_values, expected, EXACT_TOLERANCE)
    scale = (np.abs(numeric.task_jacobian) @ np.abs(reference_values)).max(axis=(1, 2), keepdims=True)
    return check_agreement(
        "J times it", numeric.task_jacobian @ reference_values / scale, expected / scale, EXACT_TOLERANCE
    )


# --- transforms, wrists and statics ---


def _transform(numeric: NumericReference, _: Part) -> ExpectedValues:
    return {"frames": (numeric.convention_frames[:, -1], EXACT_TOLERANCE)}


def _tool_jacobian(numeric: NumericReference, _: Part) -> ExpectedValues:
    """Return the geometric Jacobian in the frame of the last link."""
    rotation_to_link = numeric.convention_frames[:, -1, :3, :3].swapaxes(1, 2)
    return apply_three_methods(
        numeric,
        lambda jacobian: np.concatenate(
            [rotation_to_link @ jacobian[:, :3], rotation_to_link @ jacobian[:, 3:]], axis=1
        ),
    )


def _arm_block(numeric: NumericReference, _: Part) -> ExpectedValues:
    """Return the linear rows of J for the first three joints, of an arm with a spherical wrist."""
    return apply_three_methods(numeric, lambda jacobian: jacobian[:, :3, :3])


def _wrist_block(numeric: NumericReference, _: Part) -> ExpectedValues:
    """Return the angular rows of J for the wrist's joints, in the frame on the axis of joint 4."""
    rotation_to_wrist = numeric.convention_frames[:, convention_of(numeric.chain).frame_on_axis(4), :3, :3].swapaxes(
        1, 2
    )
    return apply_three_methods(numeric, lambda jacobian: rotation_to_wrist @ jacobian[:, 3:, 3:])


def _check_block_determinants(numeric: NumericReference, part: Part) -> Checks:
    """Compare each determinant with its block, and their product with det J of all six rows."""
    reference_values = numeric.evaluate_printed_formulas(part.answer.as_matrix())
    rotation_to_wrist = numeric.frames[:, 3, :3, :3].swapaxes(1, 2)
    blocks = (numeric.jacobian[:, :3, :3], rotation_to_wrist @ numeric.jacobian[:, 3:, 3:])
    expected = np.stack([np.linalg.det(block) for block in blocks], axis=1)[:, :, None]
    yield check_agreement("LU decomposition", reference_values, expected, EXACT_TOLERANCE)
    if reference_values.shape == expected.shape:
        full_determinant, products = np.linalg.det(numeric.task_jacobian), reference_values.prod(axis=1, keepdims=True)
        yield check_agreement("their product is det J", products, full_determinant[:, None, None], EXACT_TOLERANCE)
    effect = np.abs(numeric.jacobian[:, :3, 3:]).max()
    detail = f"largest entry of J12: {effect:.1e}"
    yield Check("the wrist does not move P", bool(effect < EXACT_TOLERANCE), detail)


def _joint_torques(numeric: NumericReference, part: Part) -> ExpectedValues:
    """Return the joint torques. Torque i is the power of the force when only joint i moves, at unit rate."""
    force = np.stack([numeric.symbol_values[name] for name in part.symbols], axis=1)
    return apply_three_methods(
        numeric, lambda jacobian: np.einsum("pij,pi->pj", jacobian[:, numeric.task], force)[:, :, None]
    )


def _gram_determinant(numeric: NumericReference, _: Part) -> ExpectedValues:
    def compute_determinant(jacobian: np.ndarray) -> np.ndarray:
        rows = jacobian[:, numeric.task]
        return np.asarray(np.linalg.det(rows @ rows.swapaxes(1, 2)))[:, None, None]

    return apply_three_methods(numeric, compute_determinant)


CHECKS: dict[str, PartCheck] = {
    "position": make_formula_check(_position),
    "velocity": make_formula_check(_velocity),
    "velocity-component": make_formula_check(_velocity_component),
    "jacobian": make_formula_check(_jacobian),
    "joint-axes": make_formula_check(_joint_axes),
    "position-vectors": make_formula_check(_position_vectors),
    "geometric-jacobian": make_formula_check(_geometric_jacobian),
    "twist": make_formula_check(_twist),
    "link-velocity": make_formula_check(_link_velocity),
    "own-frame-velocity": make_formula_check(_own_frame_velocity),
    "determinant": make_formula_check(_determinant),
    "inverse-jacobian": _check_inverse,
    "inverse-velocity": _check_inverse_velocity,
    "transform": make_formula_check(_transform),
    "tool-jacobian": make_formula_check(_tool_jacobian),
    "arm-block": make_formula_check(_arm_block),
    "wrist-block": make_formula_check(_wrist_block),
    "block-determinants": _check_block_determinants,
    "joint-torques": make_formula_check(_joint_torques),
    "gram-determinant": make_formula_check(_gram_determinant),
}
