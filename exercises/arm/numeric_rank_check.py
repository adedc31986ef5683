"""Check a singular set numerically: rank is lost on it, and searches for lost rank end on it.

J loses rank at q if a unit wrench w does no work at any joint: J(q)^T w = 0, w . w = 1. For m rows these are n + 1
equations in n + m unknowns; Gauss-Newton steps of least length lead from random starts to configurations all over the
set.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.vectors import cross
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.program import compile_program, evaluate

STARTS, STEPS = 60, 80
"""Searches for each purpose, and steps of each."""
CHOICES, FURTHER = 3, 12
"""How often open lengths are sampled, and how often again for conditions that hold only for special lengths."""
ON_IT, LOST, BESIDE = 1e-11, 1e-7, 1e-3
"""Tolerances: for solved equations, for the smallest singular value of J over the largest, and for the distance between
the end of a search and the conditions (if rank is lost to second order, rounding shifts the end)."""
_TINY = 0.1
"""The largest singular value of J (lengths in parts of the reach) below which all of them are negligible."""
_LONGEST = 0.7
"""Radians (parts of the reach) that a step may take."""
_LEAST = 1e-10
"""Singular values of a system of equations below this part of the largest are left out of a step."""


@dataclass(frozen=True)
class RankCheck:
    """The outcome: `samples` has, for each way in which rank is lost, configurations at which its conditions hold.

    Each is n joint values with the number of its arm in `arms`. `wrong` are the numbers (from 0) of ways on which some
    configuration keeps its rank. Of `searches` for lost rank with the first `choices` of arms, `ended` found a
    configuration, of which the `unexplained` ones satisfy none of the ways.
    """

    arms: tuple[NumericChain, ...]
    samples: tuple[tuple[tuple[int, np.ndarray], ...], ...]
    wrong: tuple[int, ...]
    choices: int
    searches: int
    ended: int
    unexplained: tuple[np.ndarray, ...]


def check_rank_loss(
    chain: Chain, ways: Sequence[Sequence[sp.Expr]], starts: int = STARTS, stream: str = "searched"
) -> RankCheck:
    """Check ways in which J of the task is claimed to lose rank: conditions that hold together.

    Open lengths are sampled three times, and more often for conditions that hold for none of these; lengths that make
    no real arm are left out. Another name of the `stream` gives other lengths and starts.
    """
    arms: list[NumericChain] = []
    samples: list[list[tuple[int, np.ndarray]]] = [[] for _ in ways]
    wrong: set[int] = set()
    ended, unexplained = 0, []
    draws = Stream(stream)
    for values, arm in _sample_lengths(chain, draws, CHOICES):
        arms.append(arm)
        rank = _RankTest(arm, chain.task)
        conditions = [_Way(way, chain, values) for way in ways]
        for k, way in enumerate(conditions):
            on_it, q = way.solve(rank.starts(starts, draws))
            samples[k] += [(len(arms) - 1, each) for each in q[on_it]]
            if on_it.any() and not rank.is_lost(q[on_it]).all():
                wrong.add(k)
        q = rank.search(rank.starts(starts, draws), draws)
        ended += len(q)
        explained = np.zeros(len(q), dtype=bool)
        for way in conditions:
            explained |= way.is_near(q)
        unexplained += list(q[~explained])
    choices = len(arms)
    for k in [k for k, way_samples in enumerate(samples) if not way_samples]:
        for values, arm in _sample_lengths(chain, draws, FURTHER, least=300):
            rank = _RankTest(arm, chain.task)
            on_it, q = _Way(ways[k], chain, values).solve(rank.starts(starts, draws))
            if on_it.any():
                arms.append(arm)
                samples[k] += [(len(arms) - 1, each) for each in q[on_it]]
                wrong |= set() if rank.is_lost(q[on_it]).all() else {k}
    searched = starts * choices, ended, tuple(unexplained)
    return RankCheck(tuple(arms), tuple(map(tuple, samples)), tuple(sorted(wrong)), choices, *searched)


def ways_covering(chain: Chain, way: Sequence[sp.Expr], others: Sequence[Sequence[sp.Expr]]) -> frozenset[int] | None:
    """Return the numbers of other ways that together contain the configurations found on a way, the first for each.

    None if a configuration lies on none of them, or none was found.
    """
    draws, on = Stream("lies on"), set()
    for values, arm in _sample_lengths(chain, draws, CHOICES):
        on_it, q = _Way(way, chain, values).solve(_RankTest(arm, chain.task).starts(STARTS, draws))
        q = q[on_it]
        for number, other_way in enumerate(others):
            beside = _Way(other_way, chain, values).is_near(q)
            on |= {number} if beside.any() else set()
            q = q[~beside]
        if len(q):
            return None
    return frozenset(on) or None


def _sample_lengths(
    chain: Chain, draws: Stream, times: int, least: int = 3000
) -> Iterator[tuple[dict[sp.Symbol, sp.Rational], NumericChain]]:
    """Yield values for open lengths, so many times, with the arm; skip values that make no real arm.

    The shortest is `least` / 10,007 metres, the longest 1.2 m.
    """
    for _ in range(times if chain.parameters else 1):
        values = {symbol: sp.Rational(least + draws.below(12000 - least), 10007) for symbol in chain.parameters}
        try:
            arm = NumericChain(chain, {symbol.name: float(value) for symbol, value in values.items()})
        except TypeError:  # no real number with these lengths, as sqrt(a1**2 - d1**2)
            continue
        yield values, arm


class _Way:
    """Conditions in numbers, each scaled by the size of its terms."""

    def __init__(self, conditions: Sequence[sp.Expr], chain: Chain, values: dict[sp.Symbol, sp.Rational]) -> None:
        filled = [sp.expand(_simple_zero(condition).xreplace(values)) for condition in conditions]
        wanted = [*filled, *(sp.diff(condition, q) for condition in filled for q in chain.q)]
        self._program = compile_program([read(str(expression)) for expression in wanted])
        self._sizes = np.array([_size(condition) for condition in filled])
        self._joints = [q.name for q in chain.q]

    def at(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return values (k x m) and slopes (k x m x n) at k configurations."""
        k, m = len(q), len(self._sizes)
        out = evaluate(self._program, dict(zip(self._joints, q.T, strict=True)), k)[0].real
        return out[:m].T / self._sizes, out[m:].reshape(m, -1, k).transpose(2, 0, 1) / self._sizes[:, None]

    def solve(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return for k starts whether steps lead to where all conditions hold, and the configurations (k x n)."""
        q = q.copy()
        for _ in range(STEPS):
            values, slopes = self.at(q)
            left = ~(np.abs(values).max(axis=1) < ON_IT)
            if not left.any():
                break
            q[left] += _limit_steps(_step(slopes[left], values[left]))
        return np.abs(self.at(q)[0]).max(axis=1) < ON_IT, q

    def is_near(self, q: np.ndarray) -> np.ndarray:
        """Return for each configuration whether the conditions hold there, or so close that only rounding differs."""
        if not len(q):
            return np.zeros(0, dtype=bool)
        on_it, there = self.solve(q)
        return np.asarray(on_it & (np.abs(there - q).max(axis=1) < BESIDE))


def _size(condition: sp.Expr) -> float:
    """Return the mean absolute coefficient of the terms of a sum."""
    terms = sp.Add.make_args(condition)
    return max(sum(abs(float(term.as_coeff_Mul()[0])) for term in terms) / len(terms), 1e-12)


def _simple_zero(condition: sp.Expr) -> sp.Expr:
    """Return a function with a simple zero where a (1 + cos x), a (1 - cos x) or the same of a sine has a double one.

    It is the cosine or sine of half the angle, which steps solve to full precision.
    """
    constant, rest = condition.as_coeff_Add()
    factor, trig = rest.as_coeff_Mul()
    if constant == 0 or abs(factor) != abs(constant) or not isinstance(trig, (sp.cos, sp.sin)):
        return condition
    angle = trig.args[0] if isinstance(trig, sp.cos) else trig.args[0] - sp.pi / 2
    return sp.sin(angle / 2) if factor == -constant else sp.cos(angle / 2)


def _step(slopes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the steps of least length that bring values to zero, to first order."""
    return np.asarray(-(np.linalg.pinv(slopes, rcond=_LEAST) @ values[:, :, None])[:, :, 0])


def _limit_steps(steps: np.ndarray) -> np.ndarray:
    longest = np.abs(steps).max(axis=1, keepdims=True)
    return np.asarray(steps * np.minimum(1.0, _LONGEST / np.maximum(longest, 1e-300)))


class _RankTest:
    """J of a task in numbers, lengths in parts of the arm's reach, and its slopes: to find where it loses rank."""

    def __init__(self, arm: NumericChain, task: Sequence[str]) -> None:
        self._arm, self._rows = arm, [TASK_ROWS.index(row) for row in task]
        self._turns = np.array([kind == "R" for kind in arm.kinds])
        links = (
            abs(a) + (abs(d) if kind == "R" else 0.3) for kind, (d, a, _) in zip(arm.kinds, arm.fixed, strict=True)
        )
        self._reach = max(sum(links) + float(np.abs(arm.offset[:3]).sum()), 1e-3)
        self._units = np.where(self._turns, 1.0, self._reach)

    def starts(self, count: int, draws: Stream) -> np.ndarray:
        """Return random configurations, count x n."""
        sizes = np.where(self._turns, np.pi, self._reach)
        return np.array([[draws.uniform(-1, 1) for _ in sizes] for _ in range(count)]) * sizes

    def _parts(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the linear and the angular parts of the columns at k configurations, each k x n x 3."""
        columns = self._arm.jacobian(q).swapaxes(1, 2)
        return columns[:, :, :3] / self._reach * self._units[:, None], columns[:, :, 3:]

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return J at k configurations, k x m x n."""
        return np.asarray(np.concatenate(self._parts(q), axis=2)[:, :, self._rows].swapaxes(1, 2))

    def is_lost(self, q: np.ndarray) -> np.ndarray:
        """Return for each of k configurations whether J has less than full rank."""
        sigma = np.linalg.svd(self.jacobian(q), compute_uv=False)
        return np.asarray(sigma[:, -1] < LOST * np.maximum(sigma[:, 0], _TINY))

    def search(self, q: np.ndarray, draws: Stream) -> np.ndarray:
        """Return the configurations with lost rank to which k starts lead, at most k x n."""
        (k, n), (m, _) = q.shape, self.jacobian(q[:1])[0].shape
        u, _, vt = np.linalg.svd(self.jacobian(q))
        vector = u[:, :, -1] if m <= n else vt[:, -1]
        vector = vector + 0.1 * np.array([[draws.uniform(-1, 1) for _ in range(min(m, n))] for _ in range(k)])
        q = q.copy()
        for _ in range(STEPS):
            values, slopes = self._equations(q, vector)
            left = ~(np.abs(values).max(axis=1) < ON_IT)
            if not left.any():
                break
            steps = _limit_steps(_step(slopes[left], values[left]))
            q[left] += steps[:, :n] * self._units
            vector[left] += steps[:, n:]
        ended = np.abs(self._equations(q, vector)[0]).max(axis=1) < ON_IT
        ended[ended] = self.is_lost(q[ended])
        return np.asarray(q[ended])

    def _equations(self, q: np.ndarray, vector: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residuals and their slopes with respect to joints (slides in parts of the reach) and vector.

        With at least as many joints as rows they are w^T J for a wrench w, else J v for joint rates v; and half the
        excess of the vector's square over one.
        """
        jacobian, slopes_of_jacobian = self.jacobian(q), self._jacobian_slopes(q)
        if jacobian.shape[1] <= jacobian.shape[2]:
            jacobian, slopes_of_jacobian = jacobian.swapaxes(1, 2), slopes_of_jacobian.swapaxes(1, 2)
        values = (jacobian @ vector[:, :, None])[:, :, 0]
        by_joint = np.einsum("kabj,kb->kaj", slopes_of_jacobian, vector)
        size = (np.sum(vector**2, axis=1)[:, None] - 1) / 2
        top = np.concatenate([by_joint, jacobian], axis=2)
        below = np.concatenate([np.zeros((len(q), 1, q.shape[1])), vector[:, None]], axis=2)
        return np.concatenate([values, size], axis=1), np.concatenate([top, below], axis=1)

    def _jacobian_slopes(self, q: np.ndarray) -> np.ndarray:
        """Return dJ/dq_j, k x m x n x n: joints before a column rotate it, and later joints move the point."""
        linear, angular = self._parts(q)
        n = linear.shape[1]
        by_before = cross(angular[:, None], linear[:, :, None])  # k x (column i) x (joint j) x 3, for j <= i
        before = np.arange(n)[:, None] >= np.arange(n)
        point = np.where(before[:, :, None], by_before, by_before.swapaxes(1, 2))
        turns = np.where(before[:, :, None], cross(angular[:, None], angular[:, :, None]), 0.0)
        whole = np.concatenate([point, turns], axis=3)[..., self._rows]
        return np.asarray(whole.transpose(0, 3, 1, 2))
