"""Decide whether arms of three joints reach target points, for many arms and targets at once, without a search.

The first joint cannot change two quantities of the point P:

- If the first joint is revolute: the height of P along its axis, and the distance of P from its axis.
- If the first joint is prismatic: the two coordinates of P perpendicular to its axis.

The second joint moves P on a circle or a line, on which both quantities are linear. P reaches the target if both
quantities reach those of the target. After the second joint is eliminated, one condition on the third joint remains.
The third joint also moves P on a circle or a line, on which the condition is a function of coordinates x and y. In
general the condition is a polynomial, whose sign shows whether it has a root. But the condition is linear if the second
joint cannot change one of the quantities. Then the other quantity must be in the second joint's range at a root.
"""

from dataclasses import dataclass

import numpy as np

from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross, dot, find_perpendicular_vectors, norms, remove_component

YES, NO, UNSURE = 1, 0, -1
"""The possible answers."""

_ZERO_TOLERANCE = 1e-9
"""A quantity below this fraction of the arm's size counts as zero."""
_SIGN_TOLERANCE = 1e-10
"""The sign of a polynomial is certain if its absolute value is above this fraction of the sum of its absolute terms."""
_GRID_SIZE, _START_COUNT, _MAX_NEWTON_STEPS, _MIN_STEP_SIZE = 48, 4, 25, 1e-9
"""The search for the minimum of a polynomial on the circle:

- the number of points at which the polynomial is evaluated;
- the number of Newton searches, which start from the lowest of these points;
- the maximum number of steps; if two minima merge, a step removes only a third of the remaining distance;
- the step size (rad) below which the search ends.
"""


def reaches_targets(arms: NumericChain, targets: np.ndarray) -> np.ndarray:
    """Return an array (k) with YES, NO or UNSURE: whether each of k arms reaches its target (k x 3).

    `arms` combines the arms (`NumericChain.stack`). They have three joints, all of which move P.
    """
    normalized_arms = _normalize(arms, targets)
    with np.errstate(all="ignore"):  # a division by zero makes the answer UNSURE
        condition = _eliminate_second_joint(normalized_arms)
        sign_answers, root_answers = _decide_by_sign(condition), _decide_by_roots(condition)
    answers = np.where(condition.is_only_condition, sign_answers, root_answers)
    third_joint_moves_point = norms(normalized_arms.x_vector) > _ZERO_TOLERANCE
    return np.asarray(np.where(third_joint_moves_point, answers, UNSURE))


@dataclass(frozen=True)
class _NormalizedArms:
    """Arms (k) with their targets, divided by the size of both, in coordinates about a point on the first axis.

    `axes` and `origins` (k x 3 joints x 3) are those at home. The third joint brings P to the position `center`
    + x `x_vector` + y `y_vector` (k x 3 each). If that joint is revolute, (x, y) lies on the unit circle; if it is
    prismatic, y is 0. `is_revolute` (3) says which of the joints are revolute.
    """

    is_revolute: np.ndarray
    axes: np.ndarray
    origins: np.ndarray
    target: np.ndarray
    center: np.ndarray
    x_vector: np.ndarray
    y_vector: np.ndarray

    def compute_point(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the position of P (k x m x 3) with the third joint at x and y (m, or k x m)."""
        center, x_vector, y_vector = (vectors[:, None] for vectors in (self.center, self.x_vector, self.y_vector))
        return np.asarray(center + x[..., None] * x_vector + y[..., None] * y_vector)


def _normalize(arms: NumericChain, targets: np.ndarray) -> _NormalizedArms:
    """Return arms with their targets in normalized coordinates."""
    home = arms.compute_frames(np.zeros((len(targets), 1, 3)))
    point, home = arms.compute_point_of(home)[:, 0], home[:, 0]
    axes, origins = home[:, :3, :3, 2], home[:, :3, :3, 3]
    first_axis = axes[:, 0]
    # the new origin is the foot of the perpendicular from the second origin to the first axis
    foot = origins[:, 0] + first_axis * dot(origins[:, 1] - origins[:, 0], first_axis)[:, None]
    arm_size = norms(np.diff(np.concatenate([origins, point[:, None]], axis=1), axis=1)).sum(axis=1)
    size = arm_size + norms(targets - foot)  # with the target, because a prismatic joint may be the only length
    size = np.maximum(size, 1e-12)[:, None]
    origins, point = (origins - foot[:, None]) / size[:, None], (point - foot) / size
    if arms.is_revolute[2]:
        x_vector = remove_component(point - origins[:, 2], axes[:, 2])
        center, y_vector = point - x_vector, cross(axes[:, 2], x_vector)
    else:
        center, x_vector, y_vector = point, axes[:, 2], np.zeros_like(point)
    return _NormalizedArms(arms.is_revolute, axes, origins, (targets - foot) / size, center, x_vector, y_vector)


@dataclass(frozen=True)
class _Condition:
    """The condition on the third joint, a function of x and y: a residual must be zero, and a margin positive.

    If a polynomial is the only condition of an arm, the polynomial is the residual, and the margin is 1. Otherwise the
    residual is linear, and the margin is positive if the other quantity is in the second joint's range.

    - `is_only_condition`: for each arm (k), whether a polynomial is the only condition.
    - `matrix`: how the second joint changes the two quantities (k x 2 x 2). For a prismatic joint, the matrix says how
      the joint changes the height (k x 1 x 1).
    """

    arms: _NormalizedArms
    is_only_condition: np.ndarray
    matrix: np.ndarray

    def evaluate(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual and the margin, k x m each."""
        point = self.arms.compute_point(x, y)
        return self._evaluate_revolute(point) if self.arms.is_revolute[1] else self._evaluate_prismatic(point)

    def _evaluate_revolute(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return residual and margin for a revolute second joint.

        The third joint determines the length of the vector from the second axis to P. The target determines two
        components of this vector, which must be compatible with its length.
        """
        arms = self.arms
        vector_to_point = point - arms.origins[:, None, 1]
        axis = arms.axes[:, None, 1]
        height = dot(vector_to_point, axis)
        squared_length = dot(vector_to_point, vector_to_point)
        required_components = _compute_required_components(arms, height, squared_length)
        u, sigma, _ = np.linalg.svd(self.matrix)
        components = np.einsum("kji,kmj->kmi", u, required_components)
        squared_radius = squared_length - height**2
        polynomial = np.sum((components / sigma[:, None]) ** 2, axis=2) - squared_radius
        margin = squared_radius - (components[..., 0] / sigma[:, None, 0]) ** 2
        return self._select(polynomial, components[..., 1], margin)

    def _evaluate_prismatic(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return residual and margin for a prismatic second joint."""
        arms = self.arms
        first_axis, second_axis = arms.axes[:, None, 0], arms.axes[:, None, 1]
        if not arms.is_revolute[0]:
            residual = dot(cross(first_axis, second_axis), point - arms.target[:, None])
            return residual, np.ones_like(residual)
        height, squared_distance = dot(arms.target, arms.axes[:, 0])[:, None], dot(arms.target, arms.target)[:, None]
        height_change = height - dot(point, first_axis)
        moved_point = point + (height_change / self.matrix[:, :1, 0])[..., None] * second_axis
        polynomial = dot(moved_point, moved_point) - squared_distance
        margin = dot(point, second_axis) ** 2 - dot(point, point) + squared_distance
        return self._select(polynomial, height_change, margin)

    def _select(
        self, polynomial: np.ndarray, linear_residual: np.ndarray, margin: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return (polynomial, 1) for arms whose only condition is the polynomial, else (linear_residual, margin)."""
        is_only_condition = self.is_only_condition[:, None]
        return np.where(is_only_condition, polynomial, linear_residual), np.where(is_only_condition, 1.0, margin)


def _eliminate_second_joint(arms: _NormalizedArms) -> _Condition:
    """Return the condition on the third joint that remains after the second joint is eliminated."""
    first_axis, second_axis = arms.axes[:, 0], arms.axes[:, 1]
    if not arms.is_revolute[1]:
        axis_cosine = dot(first_axis, second_axis)
        is_only_condition = (np.abs(axis_cosine) > _ZERO_TOLERANCE) & arms.is_revolute[0]
        return _Condition(arms, is_only_condition, axis_cosine[:, None, None])
    directions = (first_axis, 2 * arms.origins[:, 1]) if arms.is_revolute[0] else find_perpendicular_vectors(first_axis)
    matrix = np.stack(directions, axis=1) @ np.stack(find_perpendicular_vectors(second_axis), axis=1).swapaxes(1, 2)
    return _Condition(arms, np.linalg.svd(matrix, compute_uv=False)[:, 1] > _ZERO_TOLERANCE, matrix)


def _compute_required_components(arms: _NormalizedArms, height: np.ndarray, squared_length: np.ndarray) -> np.ndarray:
    """Return two components (k x m x 2) that the target requires of the vector from the second axis to P.

    `height` is the component of this vector along the second axis, and `squared_length` is its squared length.
    """
    first_axis, second_axis, origin = arms.axes[:, 0], arms.axes[:, 1], arms.origins[:, 1]
    if arms.is_revolute[0]:
        height_change = dot(arms.target, first_axis) - dot(origin, first_axis)
        square_change = dot(arms.target, arms.target) - dot(origin, origin)
        required_height = height_change[:, None] - dot(first_axis, second_axis)[:, None] * height
        required_square = square_change[:, None] - squared_length - 2 * dot(origin, second_axis)[:, None] * height
        return np.stack([required_height, required_square], axis=2)
    normals = find_perpendicular_vectors(first_axis)
    components = [dot(u, arms.target - origin)[:, None] - dot(u, second_axis)[:, None] * height for u in normals]
    return np.stack(components, axis=2)


# --- a polynomial as the only condition ---


def _decide_by_sign(condition: _Condition) -> np.ndarray:
    """Decide whether the polynomial has a root, that is, whether its values have both signs or are zero."""
    if condition.arms.is_revolute[2]:
        return _decide_on_circle(condition)
    return (_decide_by_minimum if condition.arms.is_revolute[:2].all() else _decide_on_line)(condition)


def _decide_on_circle(condition: _Condition) -> np.ndarray:
    """Decide whether the polynomial a0 + a1 cos x + b1 sin x + a2 cos 2x + b2 sin 2x takes both signs."""
    angles = np.arange(8) * np.pi / 4
    residuals, _ = condition.evaluate(np.cos(angles), np.sin(angles))
    coefficients = np.fft.rfft(residuals, axis=1)[:, :3] / 4
    a, b = coefficients.real, -coefficients.imag
    a[:, 0] /= 2
    coefficient_sums = np.abs(a).sum(axis=1) + np.abs(b[:, 1:]).sum(axis=1)
    grid = np.linspace(0, 2 * np.pi, _GRID_SIZE, endpoint=False)
    values = _evaluate_trig_polynomial(a, b, np.broadcast_to(grid, (len(a), _GRID_SIZE)), 0)
    tolerance = _SIGN_TOLERANCE * coefficient_sums
    has_positive, has_negative = values.max(axis=1) > tolerance, values.min(axis=1) < -tolerance
    answer = np.where(has_positive & has_negative, YES, UNSURE)
    for sign, has_only_this_sign in ((1, has_positive & ~has_negative), (-1, has_negative & ~has_positive)):
        rows = np.flatnonzero(has_only_this_sign)
        if len(rows):
            starts = grid[np.argsort(sign * values[rows], axis=1, kind="stable")[:, :_START_COUNT]]
            minimum = _find_trig_minimum(sign * a[rows], sign * b[rows], starts)
            answer[rows] = _decide(-minimum, tolerance[rows])
    return answer


def _evaluate_trig_polynomial(a: np.ndarray, b: np.ndarray, angle: np.ndarray, order: int) -> np.ndarray:
    """Return trigonometric polynomials, or their derivatives of an order, at angles (k x m).

    `a` and `b` (k x 3) are the coefficients of the cosines and sines.
    """
    multiples = np.arange(3)
    phases = angle[..., None] * multiples + order * np.pi / 2
    scale = multiples**order if order else np.ones(3)
    cosines, sines = (np.einsum("kmi,ki->km", trig(phases), c * scale) for trig, c in ((np.cos, a), (np.sin, b)))
    return np.asarray(cosines + sines)


def _find_trig_minimum(a: np.ndarray, b: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the minimum (k) of each trigonometric polynomial, by Newton steps from angles (k x m)."""
    for _ in range(_MAX_NEWTON_STEPS):
        curvature = _evaluate_trig_polynomial(a, b, angle, 2)
        step = np.where(
            curvature > 0, _evaluate_trig_polynomial(a, b, angle, 1) / np.where(curvature > 0, curvature, 1.0), 0.0
        )
        angle = angle - np.clip(step, -2 * np.pi / _GRID_SIZE, 2 * np.pi / _GRID_SIZE)
        if np.abs(step).max() < _MIN_STEP_SIZE:
            break
    return np.asarray(_evaluate_trig_polynomial(a, b, angle, 0).min(axis=1))


def _decide_by_minimum(condition: _Condition) -> np.ndarray:
    """Decide whether the polynomial, of degree four with a positive leading term, has a root on the line.

    The minimum is at a root of the derivative, and these roots are the eigenvalues of its companion matrix.
    """
    coefficients = _fit_polynomial(condition, 4)
    is_quartic = coefficients[:, 4] > _ZERO_TOLERANCE
    derivatives = coefficients[:, 1:] * np.arange(1, 5)
    companion = np.zeros((len(coefficients), 3, 3))
    companion[:, 1, 0] = companion[:, 2, 1] = 1.0
    companion[:, :, 2] = -derivatives[:, :3] / np.where(is_quartic, derivatives[:, 3], 1.0)[:, None]
    extremes = np.linalg.eigvals(companion).real
    values = np.sum(coefficients[:, None] * extremes[..., None] ** np.arange(5), axis=2)
    scale = np.sum(np.abs(coefficients[:, None]) * np.abs(extremes[..., None]) ** np.arange(5), axis=2)
    rows, lowest_indices = np.arange(len(coefficients)), np.argmin(values, axis=1)
    minimum, tolerance = values[rows, lowest_indices], _SIGN_TOLERANCE * scale[rows, lowest_indices]
    return np.where(is_quartic, _decide(-minimum, tolerance), UNSURE)


def _decide_on_line(condition: _Condition) -> np.ndarray:
    """Decide whether the polynomial, of degree two, has a root on the line."""
    coefficients = _fit_polynomial(condition, 2)
    coefficient_sums = np.abs(coefficients).sum(axis=1)
    constant, linear, quadratic = coefficients.T
    is_quadratic = np.abs(quadratic) > _ZERO_TOLERANCE * coefficient_sums
    linear_answers = np.where(np.abs(linear) > _SIGN_TOLERANCE * coefficient_sums, YES, UNSURE)
    return np.where(is_quadratic, _decide_by_discriminant(constant, linear, quadratic), linear_answers)


def _decide(value: np.ndarray, tolerance: np.ndarray | float) -> np.ndarray:
    """Return YES for a certainly positive value, NO for a certainly negative value, and UNSURE for other values."""
    return np.where(value > tolerance, YES, np.where(value < -tolerance, NO, UNSURE))


def _decide_by_discriminant(constant: np.ndarray, linear: np.ndarray, quadratic: np.ndarray) -> np.ndarray:
    """Decide whether quadratic polynomials have a root."""
    product = 4 * quadratic * constant
    return _decide(linear**2 - product, _SIGN_TOLERANCE * (linear**2 + np.abs(product)))


def _fit_polynomial(condition: _Condition, degree: int) -> np.ndarray:
    """Return the coefficients of the residual along the line, k x (degree + 1); the lowest power comes first."""
    x = np.linspace(-1, 1, degree + 1)
    residuals, _ = condition.evaluate(x, np.zeros_like(x))
    return np.asarray(residuals @ np.linalg.inv(np.vander(x, increasing=True)).T)


# --- a linear condition, and a quantity that must be in range ---


def _decide_by_roots(condition: _Condition) -> np.ndarray:
    """Decide whether the other quantity is in the second joint's range at a root of the linear condition."""
    find_roots = _find_roots_on_circle if condition.arms.is_revolute[2] else _find_roots_on_line
    x, y, existence_answers = find_roots(condition)
    _, margin = condition.evaluate(x, y)
    has_roots, has_no_root = existence_answers[:, None] == YES, existence_answers == NO
    is_in_range = np.any(has_roots & (margin > _SIGN_TOLERANCE), axis=1)
    is_out_of_range = np.all(has_roots & (margin < -_SIGN_TOLERANCE), axis=1)
    return np.where(has_no_root | is_out_of_range, NO, np.where(is_in_range, YES, UNSURE))


def _find_roots_on_circle(condition: _Condition) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the roots x and y (k x 2 each) of a residual that is linear in x and y, and YES, NO or UNSURE (k).

    The answer says whether the roots exist.
    """
    angles = np.arange(3) * np.pi / 2
    residuals, _ = condition.evaluate(np.cos(angles), np.sin(angles))
    value_at_0, value_at_90, value_at_180 = residuals.T  # at these angles in degrees
    constant, x_slope = (value_at_0 + value_at_180) / 2, (value_at_0 - value_at_180) / 2
    y_slope = value_at_90 - constant
    amplitude = np.hypot(x_slope, y_slope)
    ratio = constant / np.where(amplitude > _ZERO_TOLERANCE, amplitude, 1.0)
    roots = np.arctan2(y_slope, x_slope)[:, None] + np.arccos(np.clip(-ratio, -1, 1))[:, None] * np.array([1, -1])
    existence_answers = _decide(1 - np.abs(ratio), _SIGN_TOLERANCE)
    constant_answers = np.where(np.abs(constant) > _SIGN_TOLERANCE, NO, UNSURE)
    return np.cos(roots), np.sin(roots), np.where(amplitude > _ZERO_TOLERANCE, existence_answers, constant_answers)


def _find_roots_on_line(condition: _Condition) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the roots x and y (k x 2 each) of a residual of degree at most two, and whether they exist, as above."""
    constant, linear, quadratic = _fit_polynomial(condition, 2).T
    is_quadratic = np.abs(quadratic) > _ZERO_TOLERANCE
    discriminant = linear**2 - 4 * quadratic * constant
    signed_roots = np.sqrt(np.maximum(discriminant, 0.0))[:, None] * np.array([1, -1])
    linear_root = -constant / np.where(np.abs(linear) > _ZERO_TOLERANCE, linear, 1.0)
    quadratic_roots = (signed_roots - linear[:, None]) / np.where(is_quadratic, 2 * quadratic, 1.0)[:, None]
    x = np.where(is_quadratic[:, None], quadratic_roots, linear_root[:, None])
    discriminant_answers = _decide_by_discriminant(constant, linear, quadratic)
    linear_answers = np.where(
        np.abs(linear) > _ZERO_TOLERANCE, YES, np.where(np.abs(constant) > _SIGN_TOLERANCE, NO, UNSURE)
    )
    return x, np.zeros_like(x), np.where(is_quadratic, discriminant_answers, linear_answers)
