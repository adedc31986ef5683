"""What hints describe of an arm and show of its results: one column or entry, if others are left to be found.

The same column of a matrix is shown wherever one is shown, so that the hints of several questions together do not add
up to a whole answer. World frame; notation of the chapter.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import Derivation, derive
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.formula.order import natural
from qdot.exercises.questions.wrist import blocks, objection_unless_partitioned
from qdot.exercises.writing.latex import tex
from qdot.exercises.writing.wording import join

READABLE = 18
"""Entries of the largest matrix of numbers that a hint shows."""


@dataclass(frozen=True)
class Entry:
    """An entry of a matrix and its place, from 1."""

    row: int
    column: int
    value: sp.Expr


class HintContext:
    """Facts about one arm and parts of its results for hints; templates read its properties."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.d: Derivation = derive(chain)

    @property
    def at_zero(self) -> dict[sp.Symbol, sp.Expr]:
        """All joint variables at zero, for substitution."""
        return dict.fromkeys(self.chain.q, sp.S.Zero)

    def symbols(self, matrix: sp.Matrix) -> list[str]:
        """Return the symbols in a matrix, joints first."""
        free = sorted(matrix.free_symbols, key=lambda symbol: (symbol not in self.chain.q, natural(symbol.name)))
        return [tex(symbol, self.chain) for symbol in free]

    def joints_of(self, formula: sp.Expr) -> str:
        """Return the joint variables in a formula as words."""
        return join([f"${tex(q, self.chain)}$" for q in self.chain.q if q in formula.free_symbols] or ["no joint"])

    # --- a part of a result ---

    @staticmethod
    def column(matrix: sp.Matrix) -> int | None:
        """Return the last column, from 1, that is no constant and leaves entries of another form to be found."""
        columns = [set(map(_without_sign, matrix.col(j))) - {sp.S.Zero} for j in range(matrix.cols)]
        for j in reversed(range(matrix.cols)):
            others = set().union(*(columns[:j] + columns[j + 1 :])) - columns[j]
            if any(map(_varies, columns[j])) and any(map(_varies, others)):
                return j + 1
        return None

    @staticmethod
    def entry(matrix: sp.Matrix) -> Entry | None:
        """Return the first entry that is no constant, where another one differs from it by more than its sign."""
        places = [(i, j) for i in range(matrix.rows) for j in range(matrix.cols) if _varies(matrix[i, j])]
        if len({_without_sign(matrix[place]) for place in places}) < 2:
            return None
        i, j = places[0]
        return Entry(i + 1, j + 1, matrix[i, j])

    @staticmethod
    def minor(minors: Sequence[tuple[str, sp.Expr]]) -> tuple[str, sp.Expr] | None:
        """Return the first minor that is no constant, where another one differs from it by more than its sign."""
        varied = [(label, minor) for label, minor in minors if _varies(minor)]
        return varied[0] if len({_without_sign(minor) for _, minor in varied}) > 1 else None

    @staticmethod
    def gives_away(shown: sp.Matrix, answer: sp.Expr | sp.Matrix) -> bool:
        """Tell whether an entry of what a hint would show is one of the answer's, up to sign and to three digits."""
        wanted = set(answer if isinstance(answer, sp.MatrixBase) else [answer]) - {sp.S.Zero, sp.S.One, -sp.S.One}
        return any(_alike(entry, value) for entry in shown for value in wanted)

    def is_readable(self, numbers: sp.Matrix) -> bool:
        """Tell whether J in numbers is small enough for a hint, and not the same in every configuration."""
        return len(numbers) <= READABLE and bool(self.d.jacobian.free_symbols & set(self.chain.q))

    @cached_property
    def joint(self) -> int | None:
        """The joint, from 1, whose effect hints show: the column of the geometric Jacobian."""
        return self.column(self.d.geometric)

    @cached_property
    def mover(self) -> int | None:
        """The joint, from 1, whose effect on P hints show: the column of the linear rows."""
        return self.column(self.d.linear)

    # --- what to look at on this arm ---

    def joints(self, kind: str, count: int | None = None) -> str:
        """Return those of the first `count` joints that are "R" or "P", as in "joints 1 and 3"; nothing for none."""
        numbers = [str(i) for i, joint in enumerate(self.chain.joints[:count], 1) if joint.kind == kind]
        return f"joint{'s' * (len(numbers) > 1)} {join(numbers)}" if numbers else ""

    @property
    def bare_links(self) -> str:
        """The links up to P whose vector r_i is zero, as in "$r_{1}$ and $r_{4}$"; nothing where there are none."""
        vectors = self.d.link_vectors[: self.chain.point.frame]
        bare = [f"$r_{{{i}}}$" for i, vector in enumerate(vectors, 1) if vector.is_zero_matrix]
        return join(bare) if bare else ""

    @property
    def axes(self) -> list[tuple[int, str, sp.Expr]]:
        """How z_i stands to z_{i-1}, i = 1 ... n-1: "same", "opposite", "right" or "other", and the twist."""
        shown = {sp.S.Zero: "same", sp.pi: "opposite", sp.pi / 2: "right"}
        return [
            (i, shown.get(sp.Abs(joint.alpha), "other"), joint.alpha)
            for i, joint in enumerate(self.chain.joints[:-1], 1)
        ]

    # --- determinants and singular configurations ---

    @cached_property
    def determines(self) -> list[str]:
        """The joint variables on which det J depends."""
        return [tex(q, self.chain) for q in self.chain.q if q in self.d.determinant.free_symbols]

    @property
    def arm_seen(self) -> sp.Matrix | None:
        """R_1^T J11 of an arm whose Jacobian falls into blocks, where it differs from J11; None for others.

        Also None for an arm that is described by its axes, for which there is no frame 1.
        """
        if objection_unless_partitioned(self.chain) is not None or not convention_of(self.chain).has_frames:
            return None
        partition = blocks(self.chain)
        return None if partition.arm_seen == partition.arm else partition.arm_seen

    @property
    def conditions(self) -> list[tuple[int, list[str]]]:
        """Of each part of the singular set: how many conditions hold together, and the joints that they are on."""
        return [
            (len(part.conditions), [tex(q, self.chain) for q in self.chain.q if any(c.has(q) for c in part.conditions)])
            for part in singular_set(self.chain) or ()
        ]


def _varies(entry: sp.Expr) -> bool:
    return bool(entry.free_symbols)


def _without_sign(entry: sp.Expr) -> sp.Expr:
    return -entry if entry.could_extract_minus_sign() else entry


def _alike(a: sp.Expr, b: sp.Expr) -> bool:
    if a.is_number and b.is_number:
        return bool(abs(abs(a) - abs(b)) <= sp.Rational(1, 200) * abs(b))
    return bool(_without_sign(a) == _without_sign(b))
