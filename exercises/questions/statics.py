"""Static joint torques, the dual of the velocity problem: tau = J^T F, by virtual work."""

from dataclasses import dataclass

import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.derivation import derive
from exercises.problem import Matrix, SymbolInfo
from exercises.questions.base import Asked, Question, by_hand
from exercises.stream import Stream


def load(chain: Chain) -> dict[str, SymbolInfo]:
    """Return the components of force and moment that go with the rows of the task: fx for vx, mx for wx."""
    return {
        f"{'f' if row[0] == 'v' else 'm'}{row[1]}": SymbolInfo(
            *(("force", "N") if row[0] == "v" else ("moment", "N m"))
        )
        for row in chain.task
    }


@dataclass(frozen=True)
class Shown:
    """The load and the torques as they are printed: f_x for the symbol that is typed fx."""

    load: sp.Matrix
    torques: sp.Matrix


def _shown(force: sp.Matrix, torques: sp.Matrix) -> Shown:
    printed = {symbol: sp.Symbol(f"{symbol.name[0]}_{symbol.name[1]}") for symbol in force}
    return Shown(force.xreplace(printed), torques.xreplace(printed))


def _torques(chain: Chain, rng: Stream) -> Asked:
    symbols = load(chain)
    force = sp.Matrix([sp.Symbol(name) for name in symbols])
    units = tuple("N m" if joint.kind == "R" else "N" for joint in chain.joints)
    torques = derive(chain).jacobian.T * force
    return Matrix(torques), {"symbols": symbols, "force": force, "units": units, "shown": _shown(force, torques)}


QUESTIONS = (
    Question(
        "joint-torques",
        "Static joint torques",
        "dual of 6.4",
        _torques,
        ("jacobian",),
        1.0,
        too_long=by_hand("jacobian"),
    ),
)
