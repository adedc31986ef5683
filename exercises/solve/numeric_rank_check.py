"""Check a singular set numerically: J loses rank on the set, and searches for rank loss end on the set."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.singularities.axes import Sample, shorten_steps
from qdot.exercises.verify.numeric_model import choose_random_configurations, choose_random_lengths
from qdot.exercises.verify.singular import find_singular_configurations

START_COUNT, MAX_STEPS = 60, 80
"""Number of random starts per search, and the maximum number of steps from each start to a branch."""
LENGTH_SAMPLES, EXTRA_LENGTH_SAMPLES = 3, 12
"""Number of random choices of the symbolic lengths, and number of further choices if conditions need special lengths.

The lengths of the further choices are from a quarter to four times as long.
"""
EQUATION_TOLERANCE, RANK_TOLERANCE = 1e-11, 1e-7
"""Tolerances for residuals of solved equations, and for the smallest singular value of J over the largest."""
DISTANCE_TOLERANCE = 1e-3
"""Tolerance for the distance of a singular configuration from the set.

It is large, because rounding shifts a configuration at which the smallest singular value has a double zero.
"""
_SINGULAR_VALUE_FLOOR = 0.1
"""The largest singular value of J counts as at least this in comparisons."""
_MAX_STEP_SIZE = 0.7
"""Maximum step of a joint variable (rad, m)."""
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

    def find_zeros(k: int, branch: _Branch, arm: NumericChain) -> np.ndarray:
        """Return configurations on branch k; add k to `full_rank_branches` if J keeps full rank at one of them."""
        has_converged, q = branch.find_zeros(choose_random_configurations(chain, rng, start_count))
        if has_converged.any() and not _loses_rank(arm, chain, q[has_converged]).all():
            full_rank_branches.add(k)
        return np.asarray(q[has_converged])

    for arm, lengths in _sample_arms(chain, rng, LENGTH_SAMPLES):
        arms.append(arm)
        numeric_branches = [_Branch(branch, chain, lengths) for branch in branches]
        for k, branch in enumerate(numeric_branches):
            samples[k] += [Sample(arm, configuration) for configuration in find_zeros(k, branch, arm)]
        starts = choose_random_configurations(chain, rng, start_count)
        q = find_singular_configurations(arm, starts, chain.task_rows)
        converged_count += len(q)
        is_explained = np.zeros(len(q), dtype=bool)
        for branch in numeric_branches:
            is_explained |= branch.contains(q)
        unexplained_configurations += list(q[~is_explained])
    searched_arm_count = len(arms)
    for k in [k for k, branch_samples in enumerate(samples) if not branch_samples]:
        for arm, lengths in _sample_arms(chain, rng, EXTRA_LENGTH_SAMPLES, max_factor=4.0):
            zeros = find_zeros(k, _Branch(branches[k], chain, lengths), arm)
            samples[k] += [Sample(arm, configuration) for configuration in zeros]
            arms += [arm] if len(zeros) else []
    return RankCheck(
        tuple(arms), tuple(map(tuple, samples)), tuple(sorted(full_rank_branches)), searched_arm_count,
        start_count * searched_arm_count, converged_count, tuple(unexplained_configurations),
    )  # fmt: skip


def _sample_arms(
    chain: Chain, rng: Stream, sample_count: int, max_factor: float = 1.0
) -> Iterator[tuple[NumericChain, dict[str, float]]]:
    """Yield `sample_count` numeric arms with random symbolic lengths, multiplied or divided by up to `max_factor`.

    Lengths for which no real arm exists are skipped.
    """
    for _ in range(sample_count if chain.parameters else 1):
        random_lengths = choose_random_lengths(chain, rng).items()
        lengths = {name: length * max_factor ** rng.uniform(-1, 1) for name, length in random_lengths}
        try:
            yield NumericChain(chain, lengths), lengths
        except TypeError:  # a constant is not real for these lengths, e.g. sqrt(a1**2 - d1**2)
            continue


def _loses_rank(arm: NumericChain, chain: Chain, q: np.ndarray) -> np.ndarray:
    """Return for each of k configurations (k x n) whether J has less than full rank."""
    sigma = np.linalg.svd(arm.compute_jacobian(q)[:, chain.task_rows], compute_uv=False)
    return np.asarray(sigma[:, -1] < RANK_TOLERANCE * np.maximum(sigma[:, 0], _SINGULAR_VALUE_FLOOR))


class _Branch:
    """The conditions of one branch as numeric functions, each divided by the mean size of its coefficients."""

    def __init__(self, conditions: Sequence[sp.Expr], chain: Chain, lengths: dict[str, float]) -> None:
        values = {symbol: sp.Rational(lengths[symbol.name]) for symbol in chain.parameters}
        functions = [sp.expand(_make_zeros_simple(condition).xreplace(values)) for condition in conditions]
        expressions = [*functions, *(sp.diff(condition, q) for condition in functions for q in chain.q)]
        self._program = compile_program([parse_formula(str(expression)) for expression in expressions])
        self._coefficient_sizes = np.array([_compute_mean_coefficient(condition) for condition in functions])
        self._joint_names = [q.name for q in chain.q]

    def _evaluate(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the values of the m conditions (k x m) and their derivatives (k x m x n) at k configurations."""
        k, m = len(q), len(self._coefficient_sizes)
        results = evaluate(self._program, dict(zip(self._joint_names, q.T, strict=True)), k).values.real
        derivatives = results[m:].reshape(m, -1, k).transpose(2, 0, 1)
        return results[:m].T / self._coefficient_sizes, derivatives / self._coefficient_sizes[:, None]

    def find_zeros(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Take Gauss-Newton steps from k starts (k x n); return whether each ends at a common zero, and the ends."""
        q = q.copy()
        for _ in range(MAX_STEPS):
            values, derivatives = self._evaluate(q)
            is_active = ~(np.abs(values).max(axis=1) < EQUATION_TOLERANCE)
            if not is_active.any():
                break
            inverses = np.linalg.pinv(derivatives[is_active], rcond=_RELATIVE_CUTOFF)
            q[is_active] += shorten_steps(-(inverses @ values[is_active, :, None])[:, :, 0], _MAX_STEP_SIZE)
        return np.abs(self._evaluate(q)[0]).max(axis=1) < EQUATION_TOLERANCE, q

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
