"""Check a singular set numerically: J loses rank on the set, and searches for rank loss end on the set.

J (m x n) loses rank at q if a unit wrench w does no work at any joint: J(q)^T w = 0 and w . w = 1. These are n + 1
equations in n + m unknowns. Minimum-norm Gauss-Newton steps from random starts lead to configurations all over the
singular set. The unit of lengths is the *arm length*, the total length of the links.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.singularities.axes import Sample, shorten_steps

START_COUNT, MAX_STEPS = 60, 80
"""Number of random starts per search, and the maximum number of steps from each start."""
LENGTH_SAMPLES, EXTRA_LENGTH_SAMPLES = 3, 12
"""Number of random choices of the symbolic lengths (those without a numeric value), and the number of further choices
for conditions that hold only for special lengths."""
EQUATION_TOLERANCE, RANK_TOLERANCE = 1e-11, 1e-7
"""Tolerances for residuals of solved equations, and for the smallest singular value of J over the largest."""
DISTANCE_TOLERANCE = 1e-3
"""Tolerance for the distance of a singular configuration from the set.

It is large, because rounding shifts a configuration at which the smallest singular value has a double zero.
"""
_SINGULAR_VALUE_FLOOR = 0.1
"""The largest singular value of J (lengths as fractions of the arm length) counts as at least this in comparisons."""
_MAX_STEP_SIZE = 0.7
"""Maximum step: radians for a revolute joint, fractions of the arm length for a prismatic joint."""
_PRISMATIC_LENGTH = 0.3
"""The length (m) that a prismatic joint adds to the arm length."""
_RELATIVE_CUTOFF = 1e-10
"""A step ignores singular values below this fraction of the largest (relative cutoff of the pseudoinverse)."""


@dataclass(frozen=True)
class RankCheck:
    """The result of checking the branches of a singular set.

    A *branch* is a list of conditions that hold simultaneously. The attributes are:

    - `arms`: the numeric arms, one for each choice of the symbolic lengths.
    - `samples`: for each branch, arms at configurations that satisfy the branch's conditions.
    - `full_rank_branches`: the indices of the branches with a sample at which J keeps full rank.
    - `searched_arm_count`: how many arms, the first in `arms`, were searched for rank loss.
    - `search_count`: the number of these searches.
    - `converged_count`: how many searches converged to a singular configuration.
    - `unexplained_configurations`: the singular configurations found by the searches that lie on no branch.
    """

    arms: tuple[NumericChain, ...]
    samples: tuple[tuple[Sample, ...], ...]
    full_rank_branches: tuple[int, ...]
    searched_arm_count: int
    search_count: int
    converged_count: int
    unexplained_configurations: tuple[np.ndarray, ...]


def check_rank_loss(
    chain: Chain, branches: Sequence[Sequence[sp.Expr]], start_count: int = START_COUNT, seed: str = "searched"
) -> RankCheck:
    """Check the claimed branches of a singular set, each a list of conditions that hold simultaneously.

    Symbolic lengths are sampled three times, and more often for a branch that holds for none of these lengths. Lengths
    for which no real arm exists are skipped. Random lengths and starts depend on `seed`.
    """
    arms: list[NumericChain] = []
    samples: list[list[Sample]] = [[] for _ in branches]
    full_rank_branches: set[int] = set()
    converged_count, unexplained_configurations = 0, []
    rng = Stream(seed)

    def find_zeros(k: int, branch: _Branch, rank_test: _RankTest) -> np.ndarray:
        """Return configurations on branch k, and store k if J keeps full rank at one of them."""
        has_converged, q = branch.find_zeros(rank_test.sample_configurations(start_count, rng))
        if has_converged.any() and not rank_test.loses_rank(q[has_converged]).all():
            full_rank_branches.add(k)
        return np.asarray(q[has_converged])

    for values, arm in _sample_lengths(chain, rng, LENGTH_SAMPLES):
        arms.append(arm)
        rank_test = _RankTest(arm, chain)
        numeric_branches = [_Branch(branch, chain, values) for branch in branches]
        for k, branch in enumerate(numeric_branches):
            samples[k] += [Sample(arm, configuration) for configuration in find_zeros(k, branch, rank_test)]
        q = rank_test.search_singular(rank_test.sample_configurations(start_count, rng), rng)
        converged_count += len(q)
        is_explained = np.zeros(len(q), dtype=bool)
        for branch in numeric_branches:
            is_explained |= branch.contains(q)
        unexplained_configurations += list(q[~is_explained])
    searched_arm_count = len(arms)
    for k in [k for k, branch_samples in enumerate(samples) if not branch_samples]:
        for values, arm in _sample_lengths(chain, rng, EXTRA_LENGTH_SAMPLES, min_numerator=300):
            zeros = find_zeros(k, _Branch(branches[k], chain, values), _RankTest(arm, chain))
            samples[k] += [Sample(arm, configuration) for configuration in zeros]
            arms += [arm] if len(zeros) else []
    return RankCheck(
        tuple(arms), tuple(map(tuple, samples)), tuple(sorted(full_rank_branches)), searched_arm_count,
        start_count * searched_arm_count, converged_count, tuple(unexplained_configurations),
    )  # fmt: skip


def _sample_lengths(
    chain: Chain, rng: Stream, sample_count: int, min_numerator: int = 3000
) -> Iterator[tuple[dict[sp.Symbol, sp.Rational], NumericChain]]:
    """Yield `sample_count` random choices of the symbolic lengths, each with its numeric arm.

    A choice for which no real arm exists is skipped. Lengths range from `min_numerator` / 10,007 m to 1.2 m. The
    denominator is prime, so the fractions can't be reduced.
    """
    value_count = 12000 - min_numerator  # 12,000 / 10,007 m is about 1.2 m
    for _ in range(sample_count if chain.parameters else 1):
        numerators = {symbol: min_numerator + rng.integer_below(value_count) for symbol in chain.parameters}
        values = {symbol: sp.Rational(numerator, 10007) for symbol, numerator in numerators.items()}
        try:
            arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in values.items()})
        except TypeError:  # a constant is not real for these lengths, e.g. sqrt(a1**2 - d1**2)
            continue
        yield values, arm


class _Branch:
    """The conditions of one branch as numeric functions; each is divided by the mean size of its coefficients."""

    def __init__(self, conditions: Sequence[sp.Expr], chain: Chain, values: dict[sp.Symbol, sp.Rational]) -> None:
        functions = [sp.expand(_make_zeros_simple(condition).xreplace(values)) for condition in conditions]
        expressions = [*functions, *(sp.diff(condition, q) for condition in functions for q in chain.q)]
        self._program = compile_program([parse_formula(str(expression)) for expression in expressions])
        self._coefficient_sizes = np.array([_compute_mean_coefficient(condition) for condition in functions])
        self._joint_names = [q.name for q in chain.q]

    def evaluate_at(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the values of the m conditions (k x m) and their derivatives (k x m x n) at k configurations."""
        k, m = len(q), len(self._coefficient_sizes)
        results = evaluate(self._program, dict(zip(self._joint_names, q.T, strict=True)), k).values.real
        derivatives = results[m:].reshape(m, -1, k).transpose(2, 0, 1)
        return results[:m].T / self._coefficient_sizes, derivatives / self._coefficient_sizes[:, None]

    def find_zeros(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Iterate from k starts; return whether each converged to a common zero, and the end points (k x n)."""
        return _solve(self.evaluate_at, q)

    def contains(self, q: np.ndarray) -> np.ndarray:
        """Return for each configuration whether it satisfies the conditions up to rounding."""
        if not len(q):
            return np.zeros(0, dtype=bool)
        has_converged, end_points = self.find_zeros(q)
        return np.asarray(has_converged & (np.abs(end_points - q).max(axis=1) < DISTANCE_TOLERANCE))


def _compute_mean_coefficient(condition: sp.Expr) -> float:
    """Return the mean absolute coefficient of the terms of a sum."""
    terms = sp.Add.make_args(condition)
    return max(sum(abs(float(term.as_coeff_Mul()[0])) for term in terms) / len(terms), 1e-12)


def _make_zeros_simple(condition: sp.Expr) -> sp.Expr:
    """Replace a (1 ± cos x) or a (1 ± sin x), which has double zeros, by a function with simple zeros at the same x.

    Gauss-Newton steps find simple zeros to full precision. The function is the cosine or the sine of half the angle.
    Other conditions are returned unchanged.
    """
    constant, remaining_term = condition.as_coeff_Add()
    factor, trig = remaining_term.as_coeff_Mul()
    if constant == 0 or abs(factor) != abs(constant) or not isinstance(trig, (sp.cos, sp.sin)):
        return condition
    angle = trig.args[0] if isinstance(trig, sp.cos) else trig.args[0] - sp.pi / 2
    return sp.sin(angle / 2) if factor == -constant else sp.cos(angle / 2)


Equations = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""A function that returns e residuals (k x e) and their derivatives (k x e x n) for k vectors of n unknowns (k x n)."""


def _solve(equations: Equations, x: np.ndarray, units: np.ndarray | float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Iterate from k starts (k x n); return whether each start converged to a solution (k), and the end points (k x n).

    Gauss-Newton steps have minimum norm if the unknowns are measured in `units`. The derivatives of the equations are
    in the same units.
    """
    x = x.copy()
    for _ in range(MAX_STEPS):
        values, derivatives = equations(x)
        is_active = ~(np.abs(values).max(axis=1) < EQUATION_TOLERANCE)
        if not is_active.any():
            break
        steps = -(np.linalg.pinv(derivatives[is_active], rcond=_RELATIVE_CUTOFF) @ values[is_active, :, None])[:, :, 0]
        x[is_active] += shorten_steps(steps, _MAX_STEP_SIZE) * units
    residuals, _ = equations(x)
    return np.abs(residuals).max(axis=1) < EQUATION_TOLERANCE, x


class _RankTest:
    """The numeric task Jacobian, with lengths divided by the arm length, for finding where it loses rank."""

    def __init__(self, arm: NumericChain, chain: Chain) -> None:
        self._arm, self._task_rows = arm, chain.task_rows
        link_lengths = np.abs(arm.a) + np.where(arm.is_revolute, np.abs(arm.fixed_entries), _PRISMATIC_LENGTH)
        self._arm_length = max(sum(link_lengths) + float(np.abs(arm.point_offset[:3]).sum()), 1e-3)
        self._joint_units = np.where(arm.is_revolute, 1.0, self._arm_length)

    def sample_configurations(self, configuration_count: int, rng: Stream) -> np.ndarray:
        """Return random configurations, configurations x n."""
        limits = np.where(self._arm.is_revolute, np.pi, self._arm_length)
        return np.array([[rng.uniform(-1, 1) for _ in limits] for _ in range(configuration_count)]) * limits

    def _compute_columns(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the linear and the angular part of each column of J at k configurations, each k x n x 3."""
        columns = self._arm.compute_jacobian(q).swapaxes(1, 2)
        return columns[:, :, :3] / self._arm_length * self._joint_units[:, None], columns[:, :, 3:]

    def compute_jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the task Jacobian at k configurations, k x m x n."""
        return np.asarray(np.concatenate(self._compute_columns(q), axis=2)[:, :, self._task_rows].swapaxes(1, 2))

    def loses_rank(self, q: np.ndarray) -> np.ndarray:
        """Return for each of k configurations whether J has less than full rank."""
        sigma = np.linalg.svd(self.compute_jacobian(q), compute_uv=False)
        return np.asarray(sigma[:, -1] < RANK_TOLERANCE * np.maximum(sigma[:, 0], _SINGULAR_VALUE_FLOOR))

    def search_singular(self, q: np.ndarray, rng: Stream) -> np.ndarray:
        """Return the singular configurations (at most k x n) to which searches from k starts (k x n) converge."""
        (k, n), (m, _) = q.shape, self.compute_jacobian(q[:1])[0].shape
        u, _, v_transposed = np.linalg.svd(self.compute_jacobian(q))
        vector = u[:, :, -1] if m <= n else v_transposed[:, -1]
        vector = vector + 0.1 * np.array([[rng.uniform(-1, 1) for _ in range(min(m, n))] for _ in range(k)])
        units = np.concatenate([self._joint_units, np.ones(min(m, n))])
        has_converged, x = _solve(self._evaluate_equations, np.concatenate([q, vector], axis=1), units)
        q = x[has_converged, :n]
        return np.asarray(q[self.loses_rank(q)])

    def _evaluate_equations(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residuals and their derivatives at x, which consists of joint variables and a vector.

        The vector is a wrench w, with the residuals w^T J, if there are at least as many joints as rows. Otherwise the
        vector is joint rates v, with the residuals J v. The last residual, (|vector|^2 - 1) / 2, makes it a unit
        vector. Derivatives by prismatic joint variables are in units of the arm length.
        """
        q, vector = np.split(x, [len(self._joint_units)], axis=1)
        jacobian, jacobian_derivatives = self.compute_jacobian(q), self._compute_jacobian_derivatives(q)
        if jacobian.shape[1] <= jacobian.shape[2]:
            jacobian, jacobian_derivatives = jacobian.swapaxes(1, 2), jacobian_derivatives.swapaxes(1, 2)
        products = (jacobian @ vector[:, :, None])[:, :, 0]
        joint_derivatives = np.einsum("kabj,kb->kaj", jacobian_derivatives, vector)
        norm_residual = (np.sum(vector**2, axis=1)[:, None] - 1) / 2
        product_derivatives = np.concatenate([joint_derivatives, jacobian], axis=2)
        norm_derivatives = np.concatenate([np.zeros((len(q), 1, q.shape[1])), vector[:, None]], axis=2)
        return np.concatenate([products, norm_residual], axis=1), np.concatenate(
            [product_derivatives, norm_derivatives], axis=1
        )

    def _compute_jacobian_derivatives(self, q: np.ndarray) -> np.ndarray:
        """Return the derivatives dJ/dq_j, k x m x n x n; the last axis is j.

        The derivative of column i = (v_i, w_i) is (w_j x v_i, w_j x w_i) if j <= i, and (w_i x v_j, 0) if j > i.
        """
        linear_parts, angular_parts = self._compute_columns(q)
        n = linear_parts.shape[1]
        w_j = angular_parts[:, None]
        earlier_derivatives = cross(w_j, linear_parts[:, :, None])  # k x (column i) x (joint j) x 3, for j <= i
        is_earlier = (np.arange(n)[:, None] >= np.arange(n))[:, :, None]
        linear_derivatives = np.where(is_earlier, earlier_derivatives, earlier_derivatives.swapaxes(1, 2))
        angular_derivatives = np.where(is_earlier, cross(w_j, angular_parts[:, :, None]), 0.0)
        derivative = np.concatenate([linear_derivatives, angular_derivatives], axis=3)[..., self._task_rows]
        return np.asarray(derivative.transpose(0, 3, 1, 2))
