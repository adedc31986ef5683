"""Reference answers: the stages of a derivation in textbook form, from which answers are derived."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import Formulas
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.derivation_graph import Working

Written = Mapping[str, Callable[[Chain], sp.Matrix | sp.Expr]]
"""Formulas of stages in textbook form, by name: derived for the arm's structure, then filled with its numbers."""

WRITTEN: Written = {
    "point": lambda chain: derive(chain).position,
    "axes": lambda chain: derive(chain).z.T,
    "arms": lambda chain: derive(chain).p_star.T,
    "linear": lambda chain: derive(chain).linear,
    "geometric": lambda chain: derive(chain).geometric,
    "jacobian": lambda chain: derive(chain).jacobian,
    "determinant": lambda chain: derive(chain).determinant,
    "inverse": lambda chain: derive(chain).inverse,
    "rates": lambda chain: derive(chain).rate_law(),
}

VECTORS = frozenset({"point", "last origin", "rates"})
"""Stages that are vectors; their formulas are matrices with one column."""


@dataclass
class ReferenceWorking(Working):
    """A derivation that takes the stages in `written` in textbook form and computes the others from them."""

    written: Written = field(default_factory=dict)

    def _compute(self, stage: str) -> Any:
        if stage not in self.written:
            return super()._compute(stage)
        formula = self.written[stage](self.chain)
        if isinstance(formula, sp.Expr):
            return self.arithmetic.number(formula)
        rows = np.array(formula.tolist(), dtype=object)
        return rows if stage in VECTORS else rows[..., None]

    def up_to(self, frame: int) -> Working:
        """Return the derivation for the first joints of the arm, up to a frame."""
        return reference_working(convention_of(self.chain).first_joints(frame), self.written)


def reference_working(chain: Chain, written: Written) -> ReferenceWorking:
    """Return the derivation of an arm with the stages of WRITTEN and those that a question adds in `written`."""
    return ReferenceWorking(chain, Formulas([q.name for q in chain.q]), written={**WRITTEN, **written})
