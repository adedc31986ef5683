"""Reference answers: the stages of a derivation in textbook form, from which answers are derived."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import SympyArithmetic
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.derivation_graph import Working

TextbookStages = Mapping[str, Callable[[Chain], sp.Matrix | sp.Expr]]
"""Formulas of stages in textbook form, by name: derived for the arm's structure, then filled with its numbers."""

TEXTBOOK_STAGES: TextbookStages = {
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

VECTOR_STAGES = frozenset({"point", "last origin", "rates"})
"""Stages that are vectors; their formulas are matrices with one column."""


@dataclass
class ReferenceDerivation(Working):
    """A derivation that takes the stages in `textbook_stages` in textbook form and computes the others from them."""

    textbook_stages: TextbookStages = field(default_factory=dict)

    def _compute(self, stage: str) -> Any:
        if stage not in self.textbook_stages:
            return super()._compute(stage)
        formula = self.textbook_stages[stage](self.chain)
        if isinstance(formula, sp.Expr):
            return self.arithmetic.constant(formula)
        rows = np.array(formula.tolist(), dtype=object)
        return rows if stage in VECTOR_STAGES else rows[..., None]

    def for_first_joints(self, frame: int) -> Working:
        """Return the derivation for the first joints of the arm, up to a frame."""
        return derive_reference(convention_of(self.chain).keep_first_joints(frame), self.textbook_stages)


def derive_reference(chain: Chain, textbook_stages: TextbookStages) -> ReferenceDerivation:
    """Return the derivation of an arm with TEXTBOOK_STAGES and the stages that a question adds, `textbook_stages`."""
    return ReferenceDerivation(
        chain, SympyArithmetic([q.name for q in chain.q]), textbook_stages={**TEXTBOOK_STAGES, **textbook_stages}
    )
