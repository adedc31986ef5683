"""Find the configurations at which an answer is evaluated: the question's configuration, or random configurations."""

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import compile_expressions
from qdot.exercises.formula.equality import READABLE_POINTS, Domain
from qdot.exercises.formula.program import evaluate
from qdot.exercises.problem.problem import Part

SymbolValues = dict[str, np.ndarray]
"""Maps the name of each symbol to its values at N configurations, (N,)."""


def sample_values(domain: Domain, count: int, stream: Stream) -> SymbolValues:
    """Return `count` random values of each symbol.

    The first READABLE_POINTS samples are omitted, because they are rounded and may be singular.
    """
    sampled_values = domain.sample(set(domain.roles), READABLE_POINTS + count, stream)
    return {name: values[READABLE_POINTS:] for name, values in sampled_values.items()}


def sample_configurations(chain: Chain, part: Part, domain: Domain, count: int, stream: Stream) -> SymbolValues:
    """Return N values of each symbol: at the configuration of the question (N = 1), or at random (N = `count`).

    A question may also give the values of only some joints; the other symbols are then random.
    """
    sampled_values = sample_values(domain, count, stream)
    given_values = part.details.list_given_values(chain)
    if not given_values:
        return fix_given_joints(part, sampled_values)
    first_values = {name: np.array([float(values[0])]) for name, values in sampled_values.items()}
    return first_values | {name: np.array([value]) for name, value in given_values.items()}


def fix_given_joints(part: Part, values: SymbolValues) -> SymbolValues:
    """Return the values of all symbols; joint values that the question gives replace random ones."""
    count = len(next(iter(values.values())))
    programs = {q.name: compile_expressions(value) for q, value in part.details.given_joints.items()}
    return values | {name: evaluate(program, values, count).values[0].real for name, program in programs.items()}
