"""Compute an arm's frames, Jacobians and velocities numerically, to check the reference answers.

The numeric model uses products of 4 x 4 matrices, finite differences and the product of exponentials. The reference is
the correct answer of a problem, which was derived symbolically.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations, product
from operator import mul
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import REVOLUTE, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import Node
from qdot.exercises.problem.problem import Problem
from qdot.exercises.questions.inversion import Configuration
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import make_domain, sample_condition

ARM_COUNT, CONFIGURATIONS_PER_ARM = 3, 4
"""Number of choices of values for the symbolic lengths, and number of configurations for each choice."""

_STEP = 1e-5
"""Step of the finite differences, in radians or metres."""


class Check(NamedTuple):
    """The outcome of one test: its name, whether it passed, and details."""

    name: str
    passed: bool
    detail: str


Checks = Iterator[Check]
"""The checks of one part, which a test function yields."""


class NumericModel:
    """A numeric model of a problem's arm, evaluated at random samples.

    A sample is a choice of values for the symbolic lengths and a configuration. The first axis of every array runs over
    the samples:

    - `frames`: the frames of the standard table, (…, n + 1, 4, 4)
    - `convention_frames`: the frames that students see, (…, n + 1, 4, 4)
    - `point`: the tool point, (…, 3)
    - `jacobian`: the geometric Jacobian with columns (z x p*, z), (…, 6, n)
    - `exponential_jacobian`: the same matrix from the product of exponentials
    - `frame_velocities`: the linear and angular velocity of each frame at unit rate of each joint, (…, n, n + 1, 6)
    - `convention_velocities`: the same for the frames that students see
    - `point_velocities`: the velocity of the tool point at unit rate of each joint, (…, n, 3)
    - `home_frames`, `point_at_home`: frames and point at zero joint variables

    All velocities are computed by central differences. `task_rows` are the indices of the task's rows in the Jacobian.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.chain = problem, problem.chain
        self.rng = Stream(f"verify/{problem.id.stream_name}")
        self.task_rows = self.chain.task_rows
        self.symbol_names, self._trees = frozenset(problem.symbols), dict[str, Node]()
        self.lengths = [choose_random_lengths(self.chain, self.rng) for _ in range(ARM_COUNT)]
        self.arms = [NumericChain(self.chain, lengths) for lengths in self.lengths]
        samples = [choose_random_configurations(self.chain, self.rng, CONFIGURATIONS_PER_ARM) for _ in self.arms]
        self.configurations, self.sample_count = np.concatenate(samples), ARM_COUNT * CONFIGURATIONS_PER_ARM
        self.symbol_values = self._sample_values()
        self.frames = self.evaluate_for_each_arm(NumericChain.compute_frames)
        self.point = self.evaluate_for_each_arm(NumericChain.compute_point)
        self.jacobian = self.evaluate_for_each_arm(NumericChain.compute_jacobian)
        self.exponential_jacobian = self.evaluate_for_each_arm(compute_exponential_jacobian)
        frame_functions: list[Callable[[np.ndarray], np.ndarray]] = [arm.compute_frames for arm in self.arms]
        if convention_of(self.chain).is_proximal:
            frame_functions = [partial(compute_modified_frames, self.chain, lengths) for lengths in self.lengths]
        pairs = list(zip(frame_functions, samples, strict=True))
        self.convention_frames = np.concatenate([compute_frames(q) for compute_frames, q in pairs])
        self.convention_velocities = np.concatenate([differentiate_frames(function, q) for function, q in pairs])
        self.home_frames = self.evaluate_for_each_arm(lambda arm, q: arm.compute_frames(0 * q))
        self.point_at_home = self.evaluate_for_each_arm(lambda arm, q: arm.compute_point(0 * q))
        self.frame_velocities = self.evaluate_for_each_arm(lambda arm, q: differentiate_frames(arm.compute_frames, q))
        self.point_velocities = self.evaluate_for_each_arm(lambda arm, q: differentiate(arm.compute_point, q))

    def evaluate_for_each_arm(
        self, function: Callable[[NumericChain, np.ndarray], np.ndarray], configurations: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the values of a function of an arm and configurations (…, n), which are by default the samples."""
        samples = np.split(self.configurations if configurations is None else configurations, ARM_COUNT)
        return np.concatenate([function(arm, q) for arm, q in zip(self.arms, samples, strict=True)])

    def _sample_values(self) -> dict[str, np.ndarray]:
        """Return the values, (…), of each symbol of the problem; rates, velocities and loads get random values."""
        values = {q.name: self.configurations[:, i] for i, q in enumerate(self.chain.q)}
        values |= {
            symbol.name: np.repeat([lengths[symbol.name] for lengths in self.lengths], CONFIGURATIONS_PER_ARM)
            for symbol in self.chain.parameters
        }
        symbols = {name: info for part in self.problem.parts for name, info in part.symbols.items()}
        for name in (*(rate.name for rate in self.chain.rates), *VELOCITY_NAMES, *symbols):
            if name not in values:
                values[name] = np.array([self.rng.uniform(-2, 2) for _ in range(self.sample_count)])
                if name in symbols and symbols[name].is_positive:
                    values[name] = np.abs(values[name])
        return values

    @property
    def task_jacobian(self) -> np.ndarray:
        """The task Jacobian: the task's rows of the geometric Jacobian, (…, m, n)."""
        return self.jacobian[:, self.task_rows]

    @property
    def finite_difference_jacobian(self) -> np.ndarray:
        """The 6 x n Jacobian by finite differences: the point's velocity and the last link's angular velocity."""
        angular_velocities = self.frame_velocities[:, :, self.chain.n, 3:]
        return np.concatenate([self.point_velocities, angular_velocities], axis=2).transpose(0, 2, 1)

    @property
    def rates(self) -> np.ndarray:
        """Joint rates, (…, n, 1)."""
        return np.stack([self.symbol_values[rate.name] for rate in self.chain.rates], axis=1)[:, :, None]

    @property
    def task_velocities(self) -> np.ndarray:
        """Task velocities, (…, m, 1)."""
        return np.stack([self.symbol_values[row] for row in self.chain.task], axis=1)[:, :, None]

    def evaluate_constants(self, entries: sp.Matrix) -> np.ndarray:
        """Return the values, (…, rows), of expressions that depend only on the symbolic lengths."""
        rows = []
        for lengths in self.lengths:
            substitutions = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}
            rows += [[float(entry.xreplace(substitutions)) for entry in entries]] * CONFIGURATIONS_PER_ARM
        return np.array(rows)

    def parse(self, text: str) -> Node:
        """Return the tree of a text, parsed like an answer. Raises ParseError."""
        if text not in self._trees:
            self._trees[text] = parse_formula(text, self.symbol_names)
        return self._trees[text]

    def evaluate_printed_formulas(self, entries: sp.Matrix) -> np.ndarray:
        """Return the values of symbolic entries, (…, rows, columns); a complex array if any value is complex.

        Each entry is printed, and its text is parsed like an answer. This also checks the printed form.
        """
        program = compile_program([self.parse(format_expression(entry)) for entry in entries])
        values = evaluate(program, self.symbol_values, self.sample_count).values
        result = values.real if np.all(np.abs(values.imag) <= 1e-12 * (1 + np.abs(values))) else values
        return result.T.reshape(self.sample_count, *entries.shape)

    def sample_on_condition(self, condition: sp.Expr, arm_count: int, samples_per_arm: int) -> tuple[Sample, ...]:
        """Return configurations at which a condition is zero, `samples_per_arm` of them for each choice of lengths.

        More choices of lengths are tried if the condition has real roots only for a few of them.
        """
        attempts = (
            sample_condition(self.chain, f"{condition} = 0", f"verify/{self.problem.id}", arms, samples_per_arm)
            for arms in (arm_count, 4 * arm_count, 16 * arm_count)
        )
        return next(filter(None, attempts), ())

    # --- at the configuration of a question ---

    def sample_at(self, configuration: Configuration) -> Sample:
        """Return a question's configuration in floating point."""
        arm = NumericChain(self.chain, {symbol.name: float(value) for symbol, value in configuration.lengths.items()})
        return Sample(arm, np.array([float(sp.N(configuration.joints[q], 20)) for q in self.chain.q]))

    def jacobian_at(self, configuration: Configuration) -> np.ndarray:
        """Return the task Jacobian (m x n) at a question's configuration, by products of 4 x 4 matrices."""
        sample = self.sample_at(configuration)
        return np.asarray(sample.arm.compute_jacobian(sample.q)[self.task_rows])

    def exponential_jacobian_at(self, configuration: Configuration) -> np.ndarray:
        """Return the 6 x n Jacobian at a question's configuration, by the product of exponentials."""
        sample = self.sample_at(configuration)
        return np.asarray(compute_exponential_jacobian(sample.arm, sample.q[None])[0])


MIN_SEPARATION, MAX_TRIES = 0.005, 30
"""Minimum absolute value (m) of a sum or difference of two or three lengths, and maximum number of attempts."""


def choose_random_lengths(chain: Chain, rng: Stream) -> dict[str, float]:
    """Return a random value for every symbolic parameter of the chain: a length in metres, or an angle in radians."""
    roles = make_domain(chain).roles
    bounds = {"angle": (-np.pi, np.pi), "length": (0.25, 1.25)}
    return sample_distinct_lengths(
        chain, lambda: {symbol.name: rng.uniform(*bounds[str(roles[symbol.name])]) for symbol in chain.parameters}
    )


def sample_distinct_lengths(chain: Chain, sample: Callable[[], dict[str, float]]) -> dict[str, float]:
    """Sample symbolic lengths until no two or three lengths of the arm nearly cancel, and return them.

    Lengths that cancel would make a special arm. If every attempt fails, the last sample is returned.
    """
    roles = make_domain(chain).roles
    entries = [joint.a for joint in chain.joints] + [joint.d for joint in chain.joints if joint.is_revolute]
    fixed_lengths = [abs(float(value)) for value in (*entries, *chain.point.offset) if value.is_number and value != 0]
    values = sample()
    for _ in range(MAX_TRIES):
        symbolic_lengths = [value for name, value in values.items() if roles[name] == "length"]
        lengths = [*symbolic_lengths, *fixed_lengths]
        subsets = [*combinations(lengths, 2), *combinations(lengths, 3)]
        if not any(_nearly_cancel(subset) for subset in subsets if subset[0] in symbolic_lengths):
            break
        values = sample()
    return values


def _nearly_cancel(lengths: Sequence[float]) -> bool:
    """Return whether the sum of the lengths, with some choice of signs, is closer to zero than MIN_SEPARATION."""
    sign_choices = product((1, -1), repeat=len(lengths))
    return any(abs(sum(map(mul, signs, lengths))) < MIN_SEPARATION for signs in sign_choices)


def compute_modified_frames(chain: Chain, lengths: Mapping[str, float], q: np.ndarray) -> np.ndarray:
    """Return frames 0 ... n of a modified DH table, (…, n + 1, 4, 4), as in the problem statement.

    Each frame is the previous frame times Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(theta_i) Tz(d_i), a product of four matrices.
    """
    substitutions = {sp.Symbol(name): sp.Float(value) for name, value in lengths.items()}

    def evaluate_entry(expression: sp.Expr) -> np.ndarray:
        return np.full(q.shape[:-1], float(expression.xreplace(substitutions)))

    base = convention_of(chain).base
    frames = [_make_rotations(2, evaluate_entry(base.yaw))]
    frames[0][..., :3, 3] = np.stack([evaluate_entry(entry) for entry in base.position], axis=-1)
    for i, (row, variable) in enumerate(zip(convention_of(chain).rows, chain.q, strict=True)):
        theta_0, d_0 = (evaluate_entry(entry.xreplace({variable: sp.S.Zero})) for entry in (row.theta, row.d))
        theta, d = (theta_0 + q[..., i], d_0) if row.is_revolute else (theta_0, d_0 + q[..., i])
        link_transform = _make_rotations(0, evaluate_entry(row.alpha)) @ _make_translations(0, evaluate_entry(row.a))
        frames.append(frames[-1] @ link_transform @ _make_rotations(2, theta) @ _make_translations(2, d))
    return np.stack(frames, axis=-3)


def _make_rotations(axis: int, angle: np.ndarray) -> np.ndarray:
    """Return rotations about x (0) or z (2), (…, 4, 4)."""
    row, column = (axis + 1) % 3, (axis + 2) % 3
    pose = np.broadcast_to(np.eye(4), (*angle.shape, 4, 4)).copy()
    pose[..., row, row] = pose[..., column, column] = np.cos(angle)
    pose[..., column, row] = np.sin(angle)
    pose[..., row, column] = -np.sin(angle)
    return pose


def _make_translations(axis: int, distance: np.ndarray) -> np.ndarray:
    """Return translations along x, y or z, (…, 4, 4)."""
    pose = np.broadcast_to(np.eye(4), (*distance.shape, 4, 4)).copy()
    pose[..., axis, 3] = distance
    return pose


def choose_random_configurations(chain: Chain, rng: Stream, count: int) -> np.ndarray:
    """Return `count` random configurations, (count, n), with angles from the whole circle."""
    bounds = [(-np.pi, np.pi) if joint.is_revolute else (-1.5, 1.5) for joint in chain.joints]
    return np.array([[rng.uniform(*bound) for bound in bounds] for _ in range(count)])


def differentiate(function: Callable[[np.ndarray], np.ndarray], q: np.ndarray) -> np.ndarray:
    """Return the derivatives of a function with respect to each joint variable, (…, n, …), by central differences.

    The function takes configurations, (…, n); `q` are the configurations at which it is differentiated.
    """
    nudge = _STEP * np.eye(q.shape[1])
    return (function(q[:, None, :] + nudge) - function(q[:, None, :] - nudge)) / (2 * _STEP)


def differentiate_frames(compute_frames: Callable[[np.ndarray], np.ndarray], q: np.ndarray) -> np.ndarray:
    """Return the linear and angular velocity of each frame for the unit rate of each joint, (…, n, n + 1, 6)."""
    derivative = differentiate(compute_frames, q)
    angular_matrix = derivative[..., :3, :3] @ compute_frames(q)[:, None, :, :3, :3].swapaxes(-1, -2)
    omega = np.stack([angular_matrix[..., 2, 1], angular_matrix[..., 0, 2], angular_matrix[..., 1, 0]], axis=-1)
    return np.concatenate([derivative[..., :3, 3], omega], axis=-1)


# --- the product of exponentials ---


def compute_exponential_jacobian(arm: NumericChain, q: np.ndarray) -> np.ndarray:
    """Return the 6 x n Jacobian of the point and of the last link, (…, 6, n), for q (…, n), from screws.

    The screws are computed from the table once, at home (all joint variables zero). At home, joint i has the unit screw
    S_i = (v, w). For a revolute joint, w = z and v = o x z, where z is the axis and o a point on the axis. For a
    prismatic joint, w = 0 and v = z. The pose of the body is exp(S_1 q_1) ... exp(S_n q_n) M. Column i of the space
    Jacobian is S_i transformed by the exponentials before it. The returned Jacobian is in the world frame, with the
    linear part first, as in (6.6) of the chapter.
    """
    home = arm.compute_frames(np.zeros(q.shape[-1]))
    z, origins, point = home[:-1, :3, 2], home[:-1, :3, 3], arm.compute_point_of(home)
    is_revolute = np.array([[kind == REVOLUTE] for kind in arm.kinds])
    omegas, linear_parts = np.where(is_revolute, z, 0 * z), np.where(is_revolute, np.cross(origins, z), z)
    pose, screws = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4)), []
    for i, (omega, v) in enumerate(zip(omegas, linear_parts, strict=True)):
        if i == arm.point_frame:
            point = transform_point(pose, point)
        angular_part = pose[..., :3, :3] @ omega
        screws.append((angular_part, pose[..., :3, :3] @ v + cross(pose[..., :3, 3], angular_part)))
        pose = pose @ compute_screw_exponential(omega, v, q[..., i])
    if arm.point_frame == q.shape[-1]:
        point = transform_point(pose, point)
    columns = []
    for i, (angular_part, linear_part) in enumerate(screws):
        velocity = linear_part + cross(angular_part, point)
        moves_point = i < arm.point_frame
        columns.append(np.concatenate([velocity if moves_point else 0 * velocity, angular_part], axis=-1))
    return np.stack(columns, axis=-1)


def compute_conditioning_ratios(jacobians: np.ndarray) -> np.ndarray:
    """Return sigma_min/sigma_max of Jacobians (…, m, n), or almost zero for a Jacobian that is nearly zero."""
    sigma = np.linalg.svd(jacobians, compute_uv=False)
    return np.asarray(sigma[..., -1] / np.maximum(sigma[..., 0], 1e-6))


def transform_point(pose: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return a point (3) moved by poses (…, 4, 4)."""
    return np.asarray(pose[..., :3, :3] @ point + pose[..., :3, 3])


def compute_screw_exponential(omega: np.ndarray, v: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Return e^([S] theta) as 4 x 4 matrices, by the closed form of the series.

    `omega` and `v` are the angular and the linear part of the screws, (…, 3); `theta` is the joint variable, (…).
    """
    matrix, angle = make_skew_matrix(omega), theta[..., None, None]
    is_revolute = (np.linalg.norm(omega, axis=-1) > 0.5)[..., None, None]  # omega is a unit vector or zero
    identity = np.broadcast_to(np.eye(3), matrix.shape)
    rotation = identity + np.sin(angle) * matrix + (1 - np.cos(angle)) * matrix @ matrix
    prismatic_part = angle * identity
    revolute_part = prismatic_part + (1 - np.cos(angle)) * matrix + (angle - np.sin(angle)) * matrix @ matrix
    v_matrix = np.where(is_revolute, revolute_part, prismatic_part)
    pose = np.zeros((*rotation.shape[:-2], 4, 4))
    pose[..., :3, :3], pose[..., 3, 3] = rotation, 1.0
    pose[..., :3, 3] = (v_matrix @ v[..., None])[..., 0]
    return pose


def make_skew_matrix(vector: np.ndarray) -> np.ndarray:
    """Return the skew-symmetric matrices [v] with [v] u = v x u, (…, 3, 3)."""
    zero = 0 * vector[..., 0]
    x, y, z = (vector[..., k] for k in range(3))
    return np.stack([np.stack([zero, -z, y], -1), np.stack([z, zero, -x], -1), np.stack([-y, x, zero], -1)], -2)
