"""Static joint torques, the dual of the velocity problem: tau = J^T F, by virtual work."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.answers import Matrix
from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, SymbolInfo
from qdot.exercises.questions.base import Asked, Question, objection_to_length


@dataclass(frozen=True, kw_only=True)
class Loaded(Details):
    """About an arm that exerts a force, which has the rows of the task."""

    force: sp.Matrix


def load_symbols(chain: Chain) -> dict[str, SymbolInfo]:
    """Return the components of force and moment that go with the rows of the task: fx for vx, mx for wx."""
    return {
        f"{'f' if row[0] == 'v' else 'm'}{row[1]}": SymbolInfo(
            *(("force", "N") if row[0] == "v" else ("moment", "N m"))
        )
        for row in chain.task
    }


def _ask_torques(chain: Chain, rng: Stream) -> Asked:
    symbols = load_symbols(chain)
    force = sp.Matrix([sp.Symbol(name) for name in symbols])
    units = tuple("N m" if joint.kind == "R" else "N" for joint in chain.joints)
    torques = derive(chain).jacobian.T * force
    return Matrix(torques), Loaded(symbols=symbols, force=force, units=units)


def _title(chain: Chain) -> str:
    kinds = {joint.kind for joint in chain.joints}
    return {"R": "Static joint torques", "P": "Static joint forces"}[kinds.pop()] if len(kinds) == 1 else _BOTH


_BOTH = "Static joint torques and forces"

QUESTIONS = (
    Question(
        name="joint-torques",
        title="Static joint torques",
        title_for=_title,
        source="dual of 6.4",
        ask=_ask_torques,
        needs=("jacobian",),
        too_long=objection_to_length("jacobian"),
        result=lambda w, part: apply_matrix(w["transposed jacobian"], w.symbols(part.symbols)),
        entry_names=lambda chain, _: [rf"\tau_{{{joint}}}" for joint in range(1, chain.n + 1)],
        is_made_of_jacobian=True,
        follows=(("jacobian",),),
    ),
)
