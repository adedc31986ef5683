"""The configurations at which an answer is looked at: those that a question gives, else any."""

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


def configurations(chain: Chain, part: Part, domain: Domain, count: int, stream: Stream) -> Values:
    """Return the values of all symbols, (N,) each: at the configuration that a part gives, or at `count` of them."""
    several = domain.sample(set(domain.roles), READABLE + count, stream)
    drawn = {name: value[READABLE:] for name, value in several.items()}  # the first are rounded, and may be singular
    given = part.details.given_values(chain)
    if given:
        return _fixed(drawn, given)
    return at_given_joints(part, drawn)


def at_given_joints(part: Part, values: Values) -> Values:
    """Return values of symbols with the joints where a part has them."""
    return values | {q.name: _at(value, values) for q, value in part.details.given_joints.items()}


def _fixed(drawn: Values, given: Mapping[str, float]) -> Values:
    """Return one configuration, what is given in place of what was drawn."""
    one = {name: np.array([float(value[0])]) for name, value in drawn.items()}
    return one | {name: np.array([value]) for name, value in given.items()}


def _at(value: sp.Expr, drawn: Values) -> np.ndarray:
    return evaluate(program_of(value), drawn, len(next(iter(drawn.values()))))[0][0].real
