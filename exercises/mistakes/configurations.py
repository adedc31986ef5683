"""The configurations at which an answer is evaluated: those of the question, else random ones."""

from collections.abc import Mapping

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import program_of
from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.identity import READABLE, Domain
from qdot.exercises.formula.program import evaluate
from qdot.exercises.problem.problem import Part

Values = dict[str, np.ndarray]


def sample_configurations(chain: Chain, part: Part, domain: Domain, count: int, stream: Stream) -> Values:
    """Return the values of all symbols, (N,) each: at the configuration of a part, or at `count` random ones."""
    all_values = domain.sample(set(domain.roles), READABLE + count, stream)
    sampled = {
        name: value[READABLE:] for name, value in all_values.items()
    }  # the first are rounded, and may be singular
    fixed = part.details.given_values(chain)
    if fixed:
        return _fix_values(sampled, fixed)
    return fix_given_joints(part, sampled)


def fix_given_joints(part: Part, values: Values) -> Values:
    """Return values of symbols with the joint values that a part fixes."""
    return values | {q.name: _evaluate(value, values) for q, value in part.details.given_joints.items()}


def _fix_values(sampled: Values, fixed: Mapping[str, float]) -> Values:
    """Return one configuration, with fixed values in place of sampled ones."""
    single = {name: np.array([float(value[0])]) for name, value in sampled.items()}
    return single | {name: np.array([value]) for name, value in fixed.items()}


def _evaluate(value: sp.Expr, values: Values) -> np.ndarray:
    return evaluate(program_of(value), values, len(next(iter(values.values()))))[0][0].real
