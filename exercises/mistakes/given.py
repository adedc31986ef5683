"""The configurations at which an answer is looked at: those that a question gives, else any."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy as sp

from exercises.arm.arithmetic import program_of
from exercises.arm.chain import Chain
from exercises.arm.precise import PRECISE
from exercises.formula.identity import READABLE, Domain
from exercises.formula.program import evaluate
from exercises.problem import Part
from exercises.questions.path import joints_on
from exercises.stream import Stream

Values = dict[str, np.ndarray]


def configurations(chain: Chain, part: Part, domain: Domain, count: int, stream: Stream) -> Values:
    """Return the values of all symbols, (N,) each: at the configuration that a part gives, or at `count` of them."""
    several = domain.sample(set(domain.roles), READABLE + count, stream)
    drawn = {name: value[READABLE:] for name, value in several.items()}  # the first are rounded, and may be singular
    details: Mapping[str, Any] = part.details
    if "seam" in details and "distance" in details:
        return _fixed(drawn, _on_path(chain, details))
    place = next((details[key] for key in ("situation", "place") if details.get(key) is not None), None)
    place = details["effect"].place if "effect" in details else place
    if place is not None and hasattr(place, "lengths"):
        return _fixed(drawn, {str(s): float(sp.N(value.xreplace(place.lengths))) for s, value in place.values.items()})
    if "lost" in details:
        for q, value in details["lost"].values:
            drawn[q.name] = _at(value, drawn)
    return drawn


def _fixed(drawn: Values, given: Mapping[str, float]) -> Values:
    """Return one configuration, what is given in place of what was drawn."""
    one = {name: np.array([float(value[0])]) for name, value in drawn.items()}
    return one | {name: np.array([value]) for name, value in given.items()}


def _at(value: sp.Expr, drawn: Values) -> np.ndarray:
    return evaluate(program_of(value), drawn, len(next(iter(drawn.values()))))[0][0].real


def _on_path(chain: Chain, details: Mapping[str, Any]) -> dict[str, float]:
    """Return the joint values at a distance on a line, and the velocity along it."""
    seam, s = details["seam"], details["distance"]
    line = seam.line(chain, PRECISE)
    joints = joints_on(line, seam.line(chain), s)
    given = {symbol.name: float(value) for symbol, value in seam.lengths.items()}
    given |= {q.name: float(value) for q, value in zip(chain.q, joints, strict=True)}
    return given | {row: float(u) * float(seam.speed) for row, u in zip(chain.task, line.unit, strict=True)}
