"""Singular configurations and their type (6.8; Examples 6.2 and 6.3, with the shoulder that the book leaves out)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import sympy as sp

from exercises.chain import TASK_ROWS, Chain
from exercises.classification import Sample, classify_pieces, kind_at
from exercises.kinematics import NumericChain
from exercises.problem import Choice, ConditionSet
from exercises.questions.base import Asked, Question
from exercises.questions.inversion import conditioning, draw_lengths, draw_pose
from exercises.singularity import Component, singular_set
from exercises.stream import Stream

OPTIONS = {
    "boundary": "a boundary singularity",
    "internal": "an internal singularity",
    "regular": "no singularity: the Jacobian has full rank there",
}


def _conditions(chain: Chain, rng: Stream) -> Asked:
    return ConditionSet(singular_set(chain) or ()), {}


def _has_singularities(chain: Chain) -> str | None:
    found = singular_set(chain)
    if found is None:
        return "its Jacobian has less than full rank everywhere"
    return None if found else "it has no singular configuration"


@dataclass(frozen=True)
class Place:
    """The configurations that a question speaks of: given joint values, or a condition that ties several joints."""

    joints: dict[sp.Symbol, sp.Expr]
    condition: sp.Expr | None = None


def _type(chain: Chain, rng: Stream) -> Asked:
    """Draw the right answer first, then a place of that kind; the kind is established by computation."""
    components = singular_set(chain) or ()
    for kind in rng.shuffled(tuple(OPTIONS)):
        place = _place(chain, components, kind, rng)
        if place is not None:
            order = rng.shuffled(tuple(OPTIONS))
            return Choice(tuple(OPTIONS[k] for k in order), order.index(kind)), {"place": place, "type": kind}
    raise RuntimeError(f"no configuration of {chain} could be classified; please report this")


def _place(chain: Chain, components: tuple[Component, ...], kind: str, rng: Stream) -> Place | None:
    if kind == "regular":
        return _regular_place(chain, rng)
    for component in rng.shuffled(components):
        if component.solutions is None:
            if len(component.conditions) == 1 and _is_throughout(chain, component, kind):
                return Place({}, component.conditions[0])
        else:
            for joints in _poses(chain, component, rng):
                if _is_always(chain, joints, kind, rng):
                    return Place(joints)
    return None


def _regular_place(chain: Chain, rng: Stream) -> Place:
    while True:
        joints = draw_pose(chain, rng)
        clear = all(conditioning(chain, draw_lengths(chain, rng), joints) > 0.12 for _ in range(4))
        if clear and not _turns_singular(chain, joints, rng):
            return Place(joints)


def _turns_singular(chain: Chain, joints: dict[sp.Symbol, sp.Expr], rng: Stream) -> bool:
    """Tell whether det J has both signs at a pose as the open lengths vary, so that it vanishes for some of them."""
    if len(chain.task) != chain.n:
        return False
    rows = [TASK_ROWS.index(row) for row in chain.task]
    signs = {np.sign(np.linalg.det(s.arm.jacobian(s.q)[rows])) for s in _samples(chain, joints, rng, EXTREMES)}
    return len(signs) > 1


def _is_throughout(chain: Chain, component: Component, kind: str) -> bool:
    found = classify_pieces(chain, component.pieces())
    return found.uniform and found.kind == kind


def _poses(chain: Chain, component: Component, rng: Stream) -> Iterator[dict[sp.Symbol, sp.Expr]]:
    """Yield singular poses of a component: its values, with the other joints drawn anew each time."""
    assert component.solutions is not None
    joints = [joint for joint, _ in component.solutions]
    combinations = [
        dict(zip(joints, values, strict=True)) for values in product(*(values for _, values in component.solutions))
    ]
    for values in rng.shuffled(combinations * 2):
        yield {**draw_pose(chain, rng), **values}


LENGTHS = (0.107, 0.193, 0.391, 0.713, 1.193, 2.909)
"""What an open length is tried as, in m: whether a fold is the edge of the reach may turn on which link is longer."""

EXTREMES = (0.001, 0.1, 0.713, 5.0, 1000.0)
"""The same, for the sign of det J: a pose is regular for every length if the sign stays."""


def _is_always(chain: Chain, joints: dict[sp.Symbol, sp.Expr], kind: str, rng: Stream) -> bool:
    """Tell whether a pose is of one kind whatever the open lengths are."""
    return all(kind_at(chain, sample) == kind for sample in _samples(chain, joints, rng, LENGTHS))


def _samples(chain: Chain, joints: dict[sp.Symbol, sp.Expr], rng: Stream, lengths: Sequence[float]) -> Iterator[Sample]:
    columns = [rng.shuffled(lengths) for _ in chain.parameters]
    for row in zip(*columns, strict=True) if columns else [()]:
        values = dict(zip(chain.parameters, row, strict=True))
        numbers = {symbol: sp.Float(value) for symbol, value in values.items()}
        q = np.array([float(sp.N(joints[symbol].xreplace(numbers))) for symbol in chain.q])
        yield Sample(NumericChain(chain, {symbol.name: value for symbol, value in values.items()}), q)


QUESTIONS = (
    Question(
        "singular-angles", "Singular configurations", "6.8", _conditions, ("determinant", "jacobian"), 2.0,
        _has_singularities,
    ),
    Question("singularity-type", "Type of singularity", "below 6.7", _type, (), 1.0, _has_singularities),
)  # fmt: skip
