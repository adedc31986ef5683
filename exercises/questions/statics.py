"""A question on static joint torques, the dual of the velocity problem: tau = J^T F, by virtual work."""

from dataclasses import dataclass

import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix
from qdot.exercises.arm.chain import Chain
from qdot.exercises.common.stream import Stream
from qdot.exercises.problem.problem import Details, SymbolInfo
from qdot.exercises.questions.base import Question, make_length_objection


@dataclass(frozen=True, kw_only=True)
class LoadDetails(Details):
    """Details of a question about an arm that exerts a force or moment, with one component for each row of the task."""

    force: sp.Matrix


def make_load_symbols(chain: Chain) -> dict[str, SymbolInfo]:
    """Return the components of force and moment that correspond to the rows of the task: fx for vx, mx for wx."""
    loads = {"v": ("f", SymbolInfo("force", "N")), "w": ("m", SymbolInfo("moment", "N m"))}
    return {f"{loads[row[0]][0]}{row[1]}": loads[row[0]][1] for row in chain.task}


def _describe_load(chain: Chain, rng: Stream) -> LoadDetails:
    symbols = make_load_symbols(chain)
    units = tuple("N m" if joint.is_revolute else "N" for joint in chain.joints)
    return LoadDetails(symbols=symbols, force=sp.Matrix([sp.Symbol(name) for name in symbols]), units=units)


def _choose_title(chain: Chain) -> str:
    kinds = {joint.kind for joint in chain.joints}
    if len(kinds) > 1:
        return "Static joint torques and forces"
    return "Static joint torques" if kinds == {"R"} else "Static joint forces"


QUESTIONS = (
    Question(
        "joint-torques", "Static joint torques", "dual of 6.4", needs=("jacobian",), title_for=_choose_title,
        formula=lambda w, _: apply_matrix(w["transposed jacobian"], w.symbol_vector(make_load_symbols(w.chain))),
        make_details=_describe_load,
        entry_names=lambda chain, _: [rf"\tau_{{{joint}}}" for joint in range(1, chain.n + 1)],
        too_long=make_length_objection("jacobian"), is_made_of_jacobian=True,
    ),
)  # fmt: skip
