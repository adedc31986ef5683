"""Derive reference answers in stages (`derivation.graph`).

Some stages have formulas in textbook form. The other stages, and the answers, are computed from these formulas. In
textbook form, sines and cosines of sums of angles are combined, and common factors are taken out.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.derivation.arithmetic import SympyArithmetic
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.derivation.graph import StageResults

TextbookFormulas = Mapping[str, Callable[[Chain], sp.Matrix | sp.Expr]]
"""For each stage, a function that returns the stage's formula for an arm, in textbook form."""

TEXTBOOK_FORMULAS: TextbookFormulas = {
    "point": lambda chain: derive(chain).position,
    "axes": lambda chain: derive(chain).z.T,
    "vectors to point": lambda chain: derive(chain).p_star.T,
    "linear rows": lambda chain: derive(chain).linear_rows,
    "geometric jacobian": lambda chain: derive(chain).geometric_jacobian,
    "jacobian": lambda chain: derive(chain).jacobian,
    "determinant": lambda chain: derive(chain).determinant,
    "inverse": lambda chain: derive(chain).inverse,
    "required rates": lambda chain: derive(chain).derive_rate_law(),
}
"""The formulas for all questions. The "vectors to point" are p*_i, and the "linear rows" are those of the 6 x n
Jacobian."""

VECTOR_STAGES = frozenset({"point", "last origin", "required rates"})
"""The stages that are vectors, although their formulas are matrices with one column."""


@dataclass
class ReferenceDerivation(StageResults):
    """A derivation that takes the formulas of some stages from `textbook_formulas`, and computes the other stages."""

    textbook_formulas: TextbookFormulas = field(default_factory=dict)

    def _compute(self, stage: str) -> Any:
        if stage not in self.textbook_formulas:
            return super()._compute(stage)
        formula = self.textbook_formulas[stage](self.chain)
        if isinstance(formula, sp.Expr):
            return self.arithmetic.make_constant(formula)
        rows = np.array(formula.tolist(), dtype=object)
        return rows if stage in VECTOR_STAGES else rows[..., None]

    def keep_first_joints(self, joint_count: int) -> StageResults:
        """Return the derivation of the arm of the first joints; its point is the origin of its last frame."""
        return derive_reference(convention_of(self.chain).keep_first_joints(joint_count), self.textbook_formulas)


def derive_reference(chain: Chain, textbook_formulas: TextbookFormulas) -> ReferenceDerivation:
    """Return the derivation of an arm with TEXTBOOK_FORMULAS and a question's own `textbook_formulas`."""
    return ReferenceDerivation(
        chain, SympyArithmetic([q.name for q in chain.q]), textbook_formulas={**TEXTBOOK_FORMULAS, **textbook_formulas}
    )
