"""A direction that is lost, shown at one configuration in numbers, where formulas would be long."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import permutations

import numpy as np
import sympy as sp

from qdot.exercises.arm.axes import Sample
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.classification import domain_of
from qdot.exercises.arm.directions import lost_direction, task_rows
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import Space
from qdot.exercises.formula.expression import read
from qdot.exercises.formula.set_parser import parse_pieces
from qdot.exercises.questions.rank import Where

_LENGTHS = tuple(sp.Rational(n, 100) for n in (50, 40, 30, 60, 20, 70, 25, 35))
_DEGREES = (20, 40, 70, 25, 50, 35, 65)
_SLIDES = tuple(sp.Rational(n, 100) for n in (45, 55, 65, 75))
_TRIED = 24


@dataclass(frozen=True)
class LostExample:
    """Lengths (m) and joint values of a configuration, those of `about` rounded; J there, and what is lost."""

    lengths: dict[sp.Symbol, sp.Expr]
    joints: dict[sp.Symbol, sp.Expr]
    about: frozenset[sp.Symbol]
    jacobian: sp.Matrix
    lost: sp.Matrix


def lost_example(chain: Chain, where: Where) -> LostExample | None:
    """Return the first configuration in simple numbers that loses one direction clearly; None where none was found."""
    for lengths, joints, exact in _candidates(chain, where):
        sample = Sample(NumericChain(chain, {s.name: float(v) for s, v in lengths.items()}), exact)
        jacobian = sample.arm.jacobian(sample.q)[task_rows(chain)]
        lost = lost_direction(jacobian)
        if lost is not None:
            about = frozenset(q for q in chain.q if isinstance(joints[q], sp.Float))
            signed = lost * np.sign(lost[np.flatnonzero(np.abs(lost) > 1e-9)[0]])
            return LostExample(lengths, joints, about, _shown(jacobian), _shown(signed[:, None]))
    return None


Candidate = tuple[dict[sp.Symbol, sp.Expr], dict[sp.Symbol, sp.Expr], np.ndarray]


def _candidates(chain: Chain, where: Where) -> Iterator[Candidate]:
    """Yield lengths and joint values, as they are shown and (joint values) as they are."""
    for number, chosen in enumerate(permutations(_LENGTHS, min(len(chain.parameters), len(_LENGTHS)))):
        if number == _TRIED:
            return
        lengths = dict(zip(chain.parameters, chosen, strict=False))
        exact = _tied(chain, where.condition, lengths) if where.condition is not None else None
        if where.condition is None:
            joints = {q: value.xreplace(lengths) for q, value in _simple(chain, dict(where.values)).items()}
            numbers = np.array([complex(sp.N(value)) for value in joints.values()])
            if np.abs(numbers.imag).max() < 1e-12:
                shown = {
                    q: value if _is_short(q, value) else _rounded(q, float(sp.N(value))) for q, value in joints.items()
                }
                yield lengths, shown, numbers.real
        elif exact is not None:
            yield lengths, {q: _rounded(q, value) for q, value in zip(chain.q, exact, strict=True)}, exact


def _simple(chain: Chain, given: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    """Return a value for each joint, where none is given one that can be read."""
    degrees, slides = iter(_DEGREES), iter(_SLIDES)
    simple = [sp.pi * next(degrees) / 180 if joint.kind == "R" else next(slides) for joint in chain.joints]
    return {q: given.get(q, value) for q, value in zip(chain.q, simple, strict=True)}


def _tied(chain: Chain, condition: sp.Expr, lengths: Mapping[sp.Symbol, sp.Expr]) -> np.ndarray | None:
    """Return joint values at which a condition holds, None where there are none with these lengths."""
    joints = [q.name for q in chain.q]
    space = Space(joints, domain_of(chain, {symbol.name: float(value) for symbol, value in lengths.items()}))
    (piece,) = parse_pieces(read(f"{condition} = 0"), joints)
    values = space.on_piece(piece, space.names_of([[piece]]), Stream("example"), count=1)
    found = np.array([values[joint] for joint in joints])
    return found[:, 0] if found.shape[1] else None


def _is_short(q: sp.Symbol, value: sp.Expr) -> bool:
    share = value * 180 / sp.pi if q.name.startswith("theta") else value
    return bool(share.is_Rational)


def _rounded(q: sp.Symbol, value: float) -> sp.Float:
    """Return a value as it is shown: in degrees to two digits behind the point, or in m to four."""
    return sp.Float(f"{np.degrees(value):.2f}" if q.name.startswith("theta") else f"{value:.4f}")


def _shown(matrix: np.ndarray) -> sp.Matrix:
    return sp.Matrix(matrix).applyfunc(lambda x: sp.S.Zero if abs(x) < 1e-9 else sp.Float(f"{float(x):.4g}", 10))
