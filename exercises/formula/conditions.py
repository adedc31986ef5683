"""Sets of configurations given by conditions, as in "theta3 = 0 or pi, or a1 + a2*c2 + a3*c23 = 0".

Two sets, unions of pieces (`pieces`), are compared by what they contain: random poses are moved onto each piece of one
(Gauss-Newton) and looked for in the other.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.identity import FLOATS, Domain, Rounding
from qdot.exercises.formula.program import DIGITS, Program, compile_program, evaluate, evaluate_precisely, value_of
from qdot.exercises.formula.set_parser import Atom, Piece, is_tied
from qdot.exercises.formula.trees import Node, names

SAMPLES = 50
ROUNDED = Rounding(absolute=5e-3)
"""A joint value this close to an expected one is that value, rounded."""
TYPED = 1e-9
"""How close a configuration must be that was typed as joint values."""
MEMBER = 1e-7
"""How close a configuration must be that a search found; at a double zero, as of |cos| = 1, rounding allows 2e-8."""

_STILL, _ARRIVED, _VANISHED = 1e-10, 1e-5, 1e-9
"""A step below which nothing moves, one at which a search has arrived, and how small the residual is then."""

_POLISHED = 1e-8
"""The last step of a search for where a slope vanishes that has found it."""

_MOST_STEPS = 120
_NEAR_MISS = 1e-3
_VALUES = 5_000_000
"""Numbers that are kept at once in a search at random: at more than 1,250 steps it has fewer points."""


@dataclass
class _Search:
    """A piece with its expressions compiled: values of joints, zeros, and the joints that a search for zeros moves."""

    values: list[tuple[str, Program]]
    zeros: Program
    free: list[str]


def _prepare(piece: Piece, joints: Sequence[str]) -> _Search:
    """Return a piece compiled: values without joints come first, then those that follow other joints.

    A value that is tied can't be put in: what it differs from its joint by is one more expression that vanishes.
    """
    assigned = [atom for atom in piece if atom.joint is not None]
    tied = [atom for atom in assigned if is_tied(atom, piece, joints)]
    untied = [atom for atom in assigned if atom not in tied]
    untied.sort(key=lambda atom: bool(names(atom.zero) & set(joints)))
    zeros = [atom.zero for atom in piece if atom.joint is None]
    zeros += [Node("-", (Node("name", value=atom.joint), atom.zero)) for atom in tied]
    searched = set().union(*map(names, zeros)) - {atom.joint for atom in untied}
    values = [(str(atom.joint), compile_program([atom.zero])) for atom in untied]
    return _Search(values, compile_program(zeros), [joint for joint in joints if joint in searched])


def same_value(value: Any, expected: Any, angles: bool) -> bool:
    """Tell whether two values are the same, angles modulo whole turns: to the digits that programs print of doubles."""
    with mpmath.workdps(DIGITS):
        off = value - expected
        if angles:
            off -= 2 * mpmath.pi * mpmath.nint(off / (2 * mpmath.pi))
        return bool(abs(off) <= FLOATS * max(1, abs(expected)))


def holds_at(zero: Node, at: Mapping[str, Any], symbols: Mapping[str, Any]) -> bool:
    """Tell whether an expression vanishes at values of joints, for some values of the other symbols."""
    program = compile_program([zero])
    values = {**symbols, **at}
    misses = evaluate_precisely(program, values, DIGITS)[0]
    size = float(evaluate(program, {name: np.array([float(value)]) for name, value in values.items()}, 1)[1][0, 0])
    return bool(mpmath.isfinite(misses) and abs(misses) <= FLOATS * max(size, 1e-300))


def _nudge(values: Mapping[str, np.ndarray], count: int, nudges: Sequence[tuple[str, Any]]) -> dict[str, np.ndarray]:
    """Return the configurations once for each nudge of a joint, one block after another: one walk through a program."""
    out = {name: np.tile(column, len(nudges)) for name, column in values.items()}
    for i, (joint, nudge) in enumerate(nudges):
        block = slice(i * count, (i + 1) * count)
        out[joint] = out[joint].astype(complex) if isinstance(nudge, complex) else out[joint]
        out[joint][block] += nudge
    return out


def _ignore_undefined(function: Callable[..., Any], rows: np.ndarray) -> np.ndarray:
    """Return nanmedian or nanmin of every row as a column, without NumPy's warning for rows that are all nan."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(function(rows, axis=1, keepdims=True))


def _least_steps(slopes: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Return the shortest steps (points x joints) that take off residuals (conditions x points), by their slopes."""
    if slopes.shape[1] == 1:
        return np.asarray(slopes[:, 0] * (residual[0] / np.maximum(np.sum(slopes[:, 0] ** 2, axis=1), 1e-300))[:, None])
    return np.asarray(np.einsum("pij,jp->pi", np.linalg.pinv(slopes, rcond=1e-12), residual))


class Space:
    """The joints, their kinds and the domain in which sets of configurations live."""

    def __init__(self, joints: Sequence[str], domain: Domain, rounding: Rounding | None = None) -> None:
        self.joints, self.domain, self.rounding = tuple(joints), domain, rounding

    @property
    def typed_tolerance(self) -> float:
        """How far off typed joint values may be."""
        if self.rounding is None:
            return TYPED
        return max(TYPED, self.rounding.absolute, self.rounding.relative * np.pi)

    def names_of(self, sets: Sequence[Sequence[Piece]]) -> set[str]:
        """Return every name that occurs in the sets, and the joints."""
        atoms = (atom for pieces_ in sets for piece in pieces_ for atom in piece)
        return set(self.joints).union(*(names(atom.zero) for atom in atoms))

    def on_piece(self, piece: Piece, used: set[str], stream: Stream, count: int = SAMPLES) -> dict[str, np.ndarray]:
        """Return up to `count` random configurations (with values of the other symbols) at which the piece holds."""
        values = self.domain.sample(used, count, stream)
        search = _prepare(piece, self.joints)
        good = self._assign(search, values, count)
        if search.zeros.outputs:
            good &= self._project(search, values, count)
            good &= self._assign(search, values, count)
        return {name: column[good] for name, column in values.items()}

    def _assign(self, search: _Search, values: dict[str, np.ndarray], count: int) -> np.ndarray:
        good = np.ones(count, dtype=bool)
        for joint, program in search.values:
            assigned = evaluate(program, values, count)[0][0]
            good &= np.isfinite(assigned) & (np.abs(assigned.imag) < MEMBER)
            values[joint] = np.where(good, assigned.real, 0.0)
        return good

    def _project(self, search: _Search, values: dict[str, np.ndarray], count: int) -> np.ndarray:
        """Move the free joints onto the zeros by Gauss-Newton steps of least norm; return where that succeeded.

        It ends when steps have become tiny, not when residuals have: at a double zero, as of sin(theta)^2, a residual
        of 1e-14 is still 1e-7 away. A zero like that of sqrt(s1^2 + s2^2) is found through the square of the residual.
        """
        start = {joint: values[joint].copy() for joint in search.free}
        good = self._descend(search, values, count, squared=False)
        if search.free and not good.any():
            values.update({joint: column.copy() for joint, column in start.items()})
            good = self._descend(search, values, count, squared=True)
        return good

    def _descend(self, search: _Search, values: dict[str, np.ndarray], count: int, squared: bool) -> np.ndarray:
        last = np.full(count, np.inf)
        # How large the terms are at random, not where they vanish: near 0, sin(theta) has no larger terms than itself.
        typical = _ignore_undefined(np.nanmedian, self._zeros(search, values, count)[1])
        for _ in range(_MOST_STEPS):
            residual, _ = self._zeros(search, values, count)
            if not search.free or np.all((last < _STILL) | ~np.isfinite(residual).all(axis=0)):
                break
            slopes = self._slopes(search, values, count, squared)
            if squared:
                residual = residual**2
            good = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(residual).all(axis=0)
            slopes[~good] = 0.0
            move = _least_steps(slopes, np.where(good, residual, 0.0))
            longest = np.maximum(np.abs(move).max(axis=1, keepdims=True), 1e-300)
            move *= np.minimum(1.0, 0.7 / longest)
            last = np.where(good, np.abs(move).max(axis=1), np.inf)
            for k, joint in enumerate(search.free):
                values[joint] = values[joint] - move[:, k]
        if not squared:
            last = np.minimum(last, self._polish(search, values, count, typical[0]))
        residual, _ = self._zeros(search, values, count)
        with np.errstate(all="ignore"):
            near = np.all(np.abs(residual) <= (1e-7 if squared else _VANISHED) * typical, axis=0)
        return np.asarray(near & ((last < _ARRIVED) | (not search.free)))

    def _polish(self, search: _Search, values: dict[str, np.ndarray], count: int, typical: np.ndarray) -> np.ndarray:
        """Move poses near a double zero, as of det(J J^T), to where the slope vanishes; return the last steps.

        There the expression itself tells the place to half the digits only; its slope, by complex steps, tells it to
        almost all. Expressions with branches have no such slope, and are left as they are. So are poses that get
        nowhere by it: large terms that cancel make a slope look flat where it is not.
        """
        last = np.full(count, np.inf)
        if len(search.zeros.outputs) != 1 or search.zeros.branches or not search.free:
            return last
        before = {joint: values[joint].copy() for joint in search.free}
        off = np.abs(self._zeros(search, values, count)[0][0])
        for _ in range(8):
            slope = self._complex_slopes(search, values, count)
            flat = np.linalg.norm(slope, axis=1) < 1e-2 * typical
            if not flat.any():  # nothing moves, now or later
                last = np.full(count, np.inf)
                break
            bend = np.empty((count, len(search.free), len(search.free)))
            for k, joint in enumerate(search.free):
                ahead, behind = ({**values, joint: values[joint] + side * 1e-5} for side in (1, -1))
                ahead_slope, behind_slope = (self._complex_slopes(search, at, count) for at in (ahead, behind))
                bend[:, :, k] = (ahead_slope - behind_slope) / 2e-5
            good = flat & np.isfinite(bend).all(axis=(1, 2))
            bend[~good] = 0.0
            move = np.einsum("pij,pj->pi", np.linalg.pinv(bend, rcond=1e-7, hermitian=False), slope)
            move = np.where(good[:, None], np.clip(move, -0.05, 0.05), 0.0)
            last = np.where(good, np.abs(move).max(axis=1), np.inf)
            for k, joint in enumerate(search.free):
                values[joint] = values[joint] - move[:, k]
        with np.errstate(all="ignore"):
            polished = (last < _POLISHED) & (np.abs(self._zeros(search, values, count)[0][0]) <= off + 1e-15 * typical)
        for joint, column in before.items():
            values[joint] = np.where(polished, values[joint], column)
        return np.where(polished, last, np.inf)

    def _complex_slopes(self, search: _Search, values: Mapping[str, np.ndarray], count: int) -> np.ndarray:
        """Return the slope of one zero, (count, joints), to the last digit: Im f(x + ih) / h needs no difference."""
        nudged = _nudge(values, count, [(joint, 1e-20j) for joint in search.free])
        nudged_zeros, _ = evaluate(search.zeros, nudged, count * len(search.free))
        slopes = nudged_zeros[0].imag.reshape(len(search.free), count).T / 1e-20
        return np.where(np.isfinite(slopes), slopes, 0.0)

    def _slopes(
        self, search: _Search, values: Mapping[str, np.ndarray], count: int, squared: bool = False
    ) -> np.ndarray:
        """Return the derivatives of the zeros, or of their squares, for the free joints, by central differences.

        Of shape (count, zeros, joints). At a zero, sqrt(x^2) has no slope that differences could tell, but x^2 has one.
        """
        step, joints = 1e-6, len(search.free)
        nudged = _nudge(values, count, [(joint, side * step) for side in (1, -1) for joint in search.free])
        ends = self._zeros(search, nudged, 2 * joints * count)[0].reshape(-1, 2, joints, count)
        ends = ends**2 if squared else ends
        return np.asarray((ends[:, 0] - ends[:, 1]).transpose(2, 0, 1) / (2 * step))

    def nearest_miss(self, piece: Piece, used: set[str], stream: Stream) -> float:
        """Return how near to zero a piece's conditions come at random, relative to their terms; large for phantoms."""
        search = _prepare(piece, self.joints)
        if not search.free:
            return float("inf")
        count = min(4000, max(SAMPLES, _VALUES // len(search.zeros.steps)))
        misses, size = evaluate(search.zeros, self.domain.sample(used, count, stream), count)
        with np.errstate(all="ignore"):
            nearness = np.max(np.abs(misses) / np.maximum(size, 1e-300), axis=0)
        return float(_ignore_undefined(np.nanmin, nearness[None])[0, 0])

    def _zeros(self, search: _Search, values: Mapping[str, np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
        zeros, size = evaluate(search.zeros, values, count)
        return np.where(np.abs(zeros.imag) < MEMBER, zeros.real, np.nan), size

    def round_value(self, name: str, value: float) -> float:
        """Return a value of six digits, an angle between -pi and pi; 0 for the residue of a search for a zero."""
        if self.domain.roles.get(name) == "angle":
            value = float(np.angle(np.exp(1j * value)))
        return float(f"{value:.6g}") if abs(value) > TYPED else 0.0

    def contains(
        self, sets: Sequence[Piece], values: Mapping[str, np.ndarray], count: int, tolerance: float = MEMBER
    ) -> np.ndarray:
        """Tell for each configuration whether it lies in the union of the pieces."""
        if count == 0:
            return np.zeros(0, dtype=bool)
        member = np.zeros(count, dtype=bool)
        for piece in sets:
            holds = np.ones(count, dtype=bool)
            for atom in piece:
                holds &= self._holds(atom, values, count, tolerance)
            member |= holds
        return member

    def _holds(self, atom: Atom, values: Mapping[str, np.ndarray], count: int, tolerance: float) -> np.ndarray:
        if atom.joint is None:
            return self._vanishes(atom, values, count, tolerance)
        misses = evaluate(compile_program([atom.zero]), values, count)[0][0]
        gap = values[atom.joint] - misses.real
        if self.domain.roles.get(atom.joint) == "angle":
            gap = np.angle(np.exp(1j * np.where(np.isfinite(gap), gap, np.nan)))
        return np.asarray((np.abs(gap) <= tolerance) & (np.abs(misses.imag) <= tolerance))

    def holds_exactly(self, piece: Piece, outer: Sequence[Piece], symbols: Mapping[str, Any]) -> bool:
        """Tell whether values of joints that were typed as numbers meet the conditions of a piece to a double's digits.

        Conditions for joints that have no such value are left to the search.
        """
        values = {str(atom.joint): value_of(atom.zero) for atom in piece if atom.joint is not None}
        typed = {joint: value for joint, value in values.items() if value is not None}
        return any(all(self._meets(atom, typed, symbols) for atom in expected) for expected in outer)

    def _meets(self, atom: Atom, typed: Mapping[str, Any], symbols: Mapping[str, Any]) -> bool:
        if atom.joint is not None:
            expected = value_of(atom.zero)
            if expected is None or atom.joint not in typed:
                return True
            return same_value(typed[atom.joint], expected, self.domain.roles.get(atom.joint) == "angle")
        used = names(atom.zero)
        if not used & set(typed) or used & set(self.joints) - set(typed):
            return True
        return holds_at(atom.zero, {joint: typed[joint] for joint in used & set(typed)},
                        {name: symbols[name] for name in used - set(typed)})  # fmt: skip

    def _typical(self, search: _Search, values: Mapping[str, np.ndarray], count: int) -> float:
        """Return how large the terms of an expression are at random poses (where it vanishes they may vanish, too)."""
        stream = Stream("typical")
        poses = {joint: np.array([stream.uniform(-3, 3) for _ in range(count)]) for joint in search.free}
        return float(_ignore_undefined(np.nanmedian, self._zeros(search, {**values, **poses}, count)[1][:1])[0, 0])

    def _vanishes(self, atom: Atom, values: Mapping[str, np.ndarray], count: int, tolerance: float) -> np.ndarray:
        """Return where an expression is zero, by the distance to its zero: |f| / |f's slope|, at any scale.

        At a multiple zero the slope is nothing, too; there |f| itself has to be no more than rounding.
        """
        search = _prepare((atom,), self.joints)
        residual = self._zeros(search, values, count)[0][0]
        slope = np.linalg.norm(self._slopes(search, values, count)[:, 0], axis=1) if search.free else np.zeros(count)
        with np.errstate(all="ignore"):
            rounding = 1e-14 * self._typical(search, values, count) if search.free else 0.0
            return np.asarray((np.abs(residual) <= tolerance * slope) | (np.abs(residual) <= rounding))


@dataclass(frozen=True)
class SetComparison:
    """Which reference pieces are covered (None: empty for these lengths), which claimed ones are sound, and where not.

    A claimed piece is None where it holds nowhere: it claims nothing, and covers nothing.

    `points` are the configurations tried, `least` those on the piece with the fewest. `missing` and `surplus` are
    configurations: singular but not claimed, claimed but not singular; `rounded` says that a value would be right but
    for its digits.
    """

    covered: tuple[bool | None, ...]
    sound: tuple[bool | None, ...]
    missing: Mapping[str, float] | None
    surplus: Mapping[str, float] | None
    points: int
    least: int
    rounded: bool = False

    @property
    def equal(self) -> bool:
        """Whether the two sets hold the same configurations."""
        return False not in self.covered and False not in self.sound


@np.errstate(all="ignore")  # what overflows on the way is no place of a zero
def compare_sets(claimed: Sequence[Piece], reference: Sequence[Piece], space: Space, seed: str) -> SetComparison:
    """Compare a claimed set of configurations with the reference, piece by piece."""
    used = space.names_of([claimed, reference])
    counts: list[int] = []
    rounded = False

    def inclusion(inner: Sequence[Piece], outer: Sequence[Piece], tag: str) -> tuple[list[bool | None], Any]:
        nonlocal rounded
        held: list[bool | None] = []
        example = None
        for index, piece in enumerate(inner):
            values = space.on_piece(piece, used, Stream(f"{seed}/{tag}/{index}"))
            count = len(next(iter(values.values())))
            counts.append(count)
            # Values that were stated are held to the tolerance of all answers, what was projected to the projection's.
            stated = all(atom.joint is not None for atom in piece)
            searched = MEMBER if tag == "claimed" else max(MEMBER, space.typed_tolerance)
            inside = space.contains(outer, values, count, space.typed_tolerance if stated else searched)
            if stated and count and inside.all() and space.rounding is None:
                constants = space.domain.fixed_values()
                symbols = {name: constants.get(name) or float(column[0]) for name, column in values.items()}
                if not space.holds_exactly(piece, outer, symbols):
                    inside, rounded = np.zeros(count, dtype=bool), rounded or tag == "claimed"
            elif stated and count and not inside.all() and tag == "claimed":
                rounded |= bool(space.contains(outer, values, count, ROUNDED.absolute).all())
            held.append(None if count == 0 else bool(inside.all()))
            if count and not inside.all() and example is None:
                first = int(np.nonzero(~inside)[0][0])
                example = {name: space.round_value(name, values[name][first]) for name in sorted(values)}
        return held, example

    sound, surplus = inclusion(claimed, reference, "claimed")
    for index, (piece, held) in enumerate(zip(claimed, sound, strict=True)):
        # No configuration was found on it, yet it comes near to zero: what can't be followed is not taken for sound.
        if held is None and space.nearest_miss(piece, used, Stream(f"{seed}/miss/{index}")) < _NEAR_MISS:
            sound[index] = False
    real = [piece for piece, held in zip(claimed, sound, strict=True) if held is not None]
    covered, missing = inclusion(reference, real, "reference")
    least = min(filter(None, counts), default=0)
    return SetComparison(tuple(covered), tuple(sound), missing, surplus, sum(counts), least, rounded)
