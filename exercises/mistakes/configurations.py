"""Sample the configurations at which an answer is evaluated: those of the question, otherwise random ones."""

import numpy as np

from qdot.exercises.arm.arithmetic import program_of
from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.identity import READABLE, Domain
from qdot.exercises.formula.program import evaluate
from qdot.exercises.problem.problem import Part

Values = dict[str, np.ndarray]


def sample_values(domain: Domain, count: int, stream: Stream) -> Values:
    """Return random values of all symbols, (N,) each.

    The first samples are left out, because they are rounded and may be singular.
    """
    sampled = domain.sample(set(domain.roles), READABLE + count, stream)
    return {name: value[READABLE:] for name, value in sampled.items()}


def sample_configurations(chain: Chain, part: Part, domain: Domain, count: int, stream: Stream) -> Values:
    """Return the values of all symbols, (N,) each: at the configuration of a part, or at `count` random ones."""
    sampled = sample_values(domain, count, stream)
    fixed = part.details.given_values(chain)
    if not fixed:
        return fix_given_joints(part, sampled)
    single = {name: np.array([float(value[0])]) for name, value in sampled.items()}
    return single | {name: np.array([value]) for name, value in fixed.items()}


def fix_given_joints(part: Part, values: Values) -> Values:
    """Return the values of symbols, with the joint values that a part fixes inserted."""
    count = len(next(iter(values.values())))
    fixed = part.details.given_joints.items()
    return values | {q.name: evaluate(program_of(value), values, count)[0][0].real for q, value in fixed}
