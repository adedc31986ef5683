"""What hints tell of an arm and show of its results: one column or entry, only where others are left to be found.

The same column of a matrix is shown wherever one is shown, so that the hints of several questions together do not add
up to a whole answer. World frame; notation of the chapter.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import Derivation, derive, structure
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.arm.trigonometry import textbook
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


@dataclass(frozen=True)
class Telling:
    """A configuration at which formulas are held against each other: all joints at zero, but for those that are named.

    These are at a right angle or half of one, or a metre out. `value` is that of the right one there; others may be
    `alike`.
    """

    named: Mapping[sp.Symbol, sp.Expr]
    value: sp.Expr | sp.Matrix
    alike: bool


class HintContext:
    """What there is to tell and to show of one arm; templates read its properties."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.d: Derivation = derive(chain)

    # --- a configuration that is easy to put in ---

    @staticmethod
    def is_undefined(formula: sp.Expr | sp.Matrix) -> bool:
        """Whether a formula in numbers divides by zero."""
        return bool(formula.has(sp.nan, sp.zoo, sp.oo))

    @property
    def at_zero(self) -> dict[sp.Symbol, sp.Expr]:
        """All joint variables at zero, for substitution."""
        return dict.fromkeys(self.chain.q, sp.S.Zero)

    def telling(self, right: sp.Expr | sp.Matrix, others: Sequence[sp.Expr | sp.Matrix]) -> Telling | None:
        """Return where the fewest of the others are as the right one is, with as few joints elsewhere than at zero.

        Up to two are at right angles, or one at half of that, where products of sines and cosines show. None where the
        right one divides by zero in each of these configurations.
        """
        ends = {
            q: sp.pi / 2 if joint.kind == "R" else sp.S.One
            for q, joint in zip(self.chain.q, self.chain.joints, strict=True)
        }
        best: tuple[int, Telling] | None = None
        square = [some for count in range(3) for some in combinations(ends.items(), count)]
        halfway = [
            ((q, sp.pi / 4),) for q, joint in zip(self.chain.q, self.chain.joints, strict=True) if joint.kind == "R"
        ]
        for named in (*square, *halfway):
            there = self.at_zero | dict(named)
            value = right.xreplace(there)
            if self.is_undefined(value):
                continue
            alike = sum(_is_same(other.xreplace(there), value) for other in others)
            if best is None or alike < best[0]:
                best = alike, Telling(dict(named), value, alike > 0)
            if alike == 0:
                break
        return best and best[1]

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
        columns = [set(map(_unsigned, matrix.col(j))) - {sp.S.Zero} for j in range(matrix.cols)]
        for j in reversed(range(matrix.cols)):
            others = set().union(*(columns[:j] + columns[j + 1 :])) - columns[j]
            if any(map(_varies, columns[j])) and any(map(_varies, others)):
                return j + 1
        return None

    @staticmethod
    def entry(matrix: sp.Matrix) -> Entry | None:
        """Return the first entry that is no constant, where another one differs from it by more than its sign."""
        places = [(i, j) for i in range(matrix.rows) for j in range(matrix.cols) if _varies(matrix[i, j])]
        if len({_unsigned(matrix[place]) for place in places}) < 2:
            return None
        i, j = places[0]
        return Entry(i + 1, j + 1, matrix[i, j])

    @staticmethod
    def minor(minors: Sequence[tuple[str, sp.Expr]]) -> tuple[str, sp.Expr] | None:
        """Return the first minor that is no constant, where another one differs from it by more than its sign."""
        varied = [(label, minor) for label, minor in minors if _varies(minor)]
        return varied[0] if len({_unsigned(minor) for _, minor in varied}) > 1 else None

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

    @cached_property
    def turned_back(self) -> tuple[sp.Expr, sp.Matrix] | None:
        """A value of joint 1 at which J is short, and J there: it has the same determinant. None for other arms."""
        known = structure(self.chain)
        generic, first = derive(known.chain), known.chain.q[0]
        if self.chain.joints[0].kind == "P" or not 1 < self.chain.n <= 4:
            return None
        if not generic.jacobian.has(first) or generic.determinant.has(first):
            return None
        base = known.chain.base  # a turn of the base about the axis of joint 1 is undone by this joint
        straight = {sp.S.Zero: -base.yaw, sp.pi: base.yaw}.get(base.tilt, sp.S.Zero)
        value = sp.expand(straight.xreplace(dict(known.values)) - self.chain.offsets[0])
        short = self._filled(generic.jacobian.xreplace({first: straight}))
        return sp.pi - sp.Mod(sp.pi - value, 2 * sp.pi) if value.is_number else value, short

    @property
    def arm_seen(self) -> sp.Matrix | None:
        """R_1^T J11 of an arm whose Jacobian falls into blocks, where it differs from J11; None for others.

        None, too, of an arm that is told by its axes, for which there is no frame 1.
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

    def jacobian_at(self, values: Sequence[tuple[sp.Symbol, sp.Expr]]) -> sp.Matrix | None:
        """Return the task Jacobian of up to three joints with some put to values, where their sines are short."""
        known, own = structure(self.chain), dict(values)
        generic = {
            symbol: own[q] + offset
            for q, symbol, offset in zip(self.chain.q, known.chain.q, self.chain.offsets, strict=True)
            if q in own
        }
        slides = {q for q, joint in zip(known.chain.q, known.chain.joints, strict=True) if joint.kind == "P"}
        short = all(q in slides or (12 * value / sp.pi).is_Integer for q, value in generic.items())
        if self.chain.n > 3 or not short:
            return None
        return self._filled(derive(known.chain).jacobian.xreplace(generic))

    def _filled(self, generic: sp.Matrix) -> sp.Matrix:
        return generic.applyfunc(lambda entry: self.d.fill(_textbook(sp.expand(entry))))


def _textbook(entry: sp.Expr) -> sp.Expr:
    """Return an entry as a textbook prints it; roots, as of the sine of 60 degrees, are taken as lengths are."""
    numbers = [power for power in entry.atoms(sp.Pow) if power.is_number]
    roots = {number: sp.Symbol(f"_root{k}") for k, number in enumerate(sorted(numbers, key=sp.default_sort_key))}
    return textbook(entry.xreplace(roots)).xreplace({symbol: root for root, symbol in roots.items()})


def _varies(entry: sp.Expr) -> bool:
    return bool(entry.free_symbols)


def _unsigned(entry: sp.Expr) -> sp.Expr:
    return -entry if entry.could_extract_minus_sign() else entry


def _alike(a: sp.Expr, b: sp.Expr) -> bool:
    if a.is_number and b.is_number:
        return bool(abs(abs(a) - abs(b)) <= sp.Rational(1, 200) * abs(b))
    return bool(_unsigned(a) == _unsigned(b))


def _is_same(one: sp.Expr | sp.Matrix, other: sp.Expr | sp.Matrix) -> bool:
    """Tell whether formulas without joint variables are the same, entry by entry."""
    left, right = (list(formula) if isinstance(formula, sp.MatrixBase) else [formula] for formula in (one, other))
    return len(left) == len(right) and all(sp.expand(a - b) == 0 for a, b in zip(left, right, strict=True))
