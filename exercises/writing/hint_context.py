"""Select the parts of results that hints may show: a column or an entry, if students still have to find others.

All hints show the same column of a matrix, so that the hints of several questions together never show a whole answer.
All vectors are in the world frame, in the notation of the chapter.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.derivation.derivation import Derivation, derive
from qdot.exercises.formula.order import make_natural_sort_key
from qdot.exercises.questions.wrist import derive_blocks, find_block_objection
from qdot.exercises.singularities.singular_set import find_singular_set
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.wording import Wording

Item = TypeVar("Item")

MAX_SHOWN_ENTRIES = 18
"""Maximum number of entries of a numeric matrix that a hint shows."""


@dataclass(frozen=True)
class Entry:
    """An entry of a matrix with its row and column, from 1."""

    row: int
    column: int
    value: sp.Expr


class HintContext:
    """Facts about one arm and parts of its results for hints; templates read its properties."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.derivation: Derivation = derive(chain)
        self._join = Wording(chain).join

    def list_symbols(self, matrix: sp.Matrix) -> list[str]:
        """Return the symbols in a matrix, joint variables first, as LaTeX."""
        symbols = sorted(matrix.free_symbols, key=lambda s: (s not in self.chain.q, make_natural_sort_key(s.name)))
        return [tex(symbol, self.chain) for symbol in symbols]

    def name_variables(self, formula: sp.Expr) -> str:
        """Return the joint variables in a formula, as in "$d_{1}$ and $d_{2}$", or "no joint"."""
        variables = [f"${tex(q, self.chain)}$" for q in self.chain.q if q in formula.free_symbols]
        return self._join(variables or ["no joint"])

    # --- a part of a result ---

    @staticmethod
    def find_column(matrix: sp.Matrix) -> int | None:
        """Return the last column (from 1) that is not constant, if other columns have different variable entries.

        Entries are not different if they differ only by their sign. Returns None if there is no such column.
        """
        columns = [set(map(_remove_sign, matrix.col(j))) - {sp.S.Zero} for j in range(matrix.cols)]
        for j in reversed(range(matrix.cols)):
            other_entries = set().union(*(columns[:j] + columns[j + 1 :])) - columns[j]
            if any(map(_is_variable, columns[j])) and any(map(_is_variable, other_entries)):
                return j + 1
        return None

    @staticmethod
    def find_entry(matrix: sp.Matrix) -> Entry | None:
        """Return the first entry that is not constant, if another such entry differs by more than its sign."""
        entries = (Entry(i + 1, j + 1, matrix[i, j]) for i in range(matrix.rows) for j in range(matrix.cols))
        return _find_first_variable((entry, entry.value) for entry in entries)

    @staticmethod
    def find_minor(minors: Sequence[tuple[str, sp.Expr]]) -> tuple[str, sp.Expr] | None:
        """Return the first minor that is not constant, if another such minor differs by more than its sign."""
        return _find_first_variable(((label, value), value) for label, value in minors)

    @staticmethod
    def reveals_entry(shown_matrix: sp.Matrix, answer: sp.Expr | sp.Matrix) -> bool:
        """Return whether a hint's matrix contains an entry of the answer, up to its sign and an error of 0.5 %."""
        answer_entries = set(answer if isinstance(answer, sp.MatrixBase) else [answer]) - {0, 1, -1}
        return any(_are_nearly_equal(entry, value) for entry in shown_matrix for value in answer_entries)

    def is_small_enough(self, numbers: sp.Matrix) -> bool:
        """Return whether a numeric J is small enough for a hint and depends on the configuration."""
        return len(numbers) <= MAX_SHOWN_ENTRIES and bool(self.derivation.jacobian.free_symbols & set(self.chain.q))

    # --- what to look at on this arm ---

    def name_joints(self, kind: str, count: int | None = None) -> str:
        """Return the joints of `kind` among the first `count`, as in "joints 1 and 3"; "" if there are none."""
        numbers = [str(i) for i, joint in enumerate(self.chain.joints[:count], 1) if joint.kind == kind]
        return f"joint{'s' * (len(numbers) > 1)} {self._join(numbers)}" if numbers else ""

    @property
    def zero_link_vectors(self) -> str:
        """The zero link vectors up to P, as in "$r_{1}$ and $r_{4}$"; "" if there are none."""
        vectors = self.derivation.link_vectors[: self.chain.point.frame]
        zero_vectors = [f"$r_{{{i}}}$" for i, vector in enumerate(vectors, 1) if vector.is_zero_matrix]
        return self._join(zero_vectors) if zero_vectors else ""

    @property
    def axis_directions(self) -> list[tuple[int, str, sp.Expr]]:
        """For i = 1 ... n-1: i, the direction of z_i relative to z_{i-1}, and the twist between both axes.

        The direction is "same", "opposite", "right" (perpendicular) or "other".
        """
        directions = {sp.S.Zero: "same", sp.pi: "opposite", sp.pi / 2: "right"}
        twists = [joint.alpha for joint in self.chain.joints[:-1]]
        return [(i, directions.get(sp.Abs(alpha), "other"), alpha) for i, alpha in enumerate(twists, 1)]

    # --- determinants and singular configurations ---

    @cached_property
    def determinant_joints(self) -> list[str]:
        """The joint variables on which det J depends."""
        return [tex(q, self.chain) for q in self.chain.q if q in self.derivation.determinant.free_symbols]

    @property
    def arm_block_in_frame_1(self) -> sp.Matrix | None:
        """The block R_1^T J11 of a Jacobian with blocks J11 and J22; None if the Jacobian has no such blocks.

        Also None if the block equals J11, and if the arm is described by its axes, because there is no frame 1 then.
        """
        if find_block_objection(self.chain) is not None or not convention_of(self.chain).frame_numbers:
            return None
        blocks = derive_blocks(self.chain)
        return None if blocks.arm_block_in_frame_1 == blocks.arm_block else blocks.arm_block_in_frame_1

    @property
    def condition_summaries(self) -> list[tuple[int, list[str]]]:
        """For each component of the singular set, the number of its conditions and the joint variables in them."""
        summaries = []
        for component in find_singular_set(self.chain) or ():
            joints = [q for q in self.chain.q if any(condition.has(q) for condition in component.conditions)]
            summaries.append((len(component.conditions), [tex(q, self.chain) for q in joints]))
        return summaries


def _find_first_variable(items: Iterable[tuple[Item, sp.Expr]]) -> Item | None:
    """Return the first item whose value is not constant, if another such value differs by more than its sign."""
    variable_items = [(item, value) for item, value in items if _is_variable(value)]
    has_different_values = len({_remove_sign(value) for _, value in variable_items}) > 1
    return next((item for item, _ in variable_items), None) if has_different_values else None


def _is_variable(entry: sp.Expr) -> bool:
    return bool(entry.free_symbols)


def _remove_sign(entry: sp.Expr) -> sp.Expr:
    return -entry if entry.could_extract_minus_sign() else entry


def _are_nearly_equal(a: sp.Expr, b: sp.Expr) -> bool:
    if a.is_number and b.is_number:
        return bool(abs(abs(a) - abs(b)) <= sp.Rational(1, 200) * abs(b))
    return bool(_remove_sign(a) == _remove_sign(b))
