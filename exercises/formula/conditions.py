"""Sets of configurations given by conditions, as in "theta3 = 0 or pi, or a1 + a2*c2 + a3*c23 = 0".

A set is a union of pieces, a piece is a list of atoms that hold together, and an atom is either `expression = 0` or
`joint = value`. Two sets are compared by what they contain: random poses are moved onto each piece of one set
(Gauss-Newton) and looked for in the other.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from exercises.formula.expression import Node, ReadError, names
from exercises.formula.identity import TOLERANCE, Domain
from exercises.formula.tape import Tape, compile_tape, evaluate
from exercises.stream import Stream

SAMPLES = 48
MEMBER = 1e-6
"""How near a configuration found by Gauss-Newton must be: at a double zero, as of sin(theta)^2, it is that exact."""
_PROJECTED = 1e-14
_WHOLE_NUMBERS = ("k", "n", "m")
_MOST_PIECES = 500


@dataclass(frozen=True)
class Atom:
    """One condition: `zero` vanishes (joint is None), or `joint` has the value `zero` (modulo 2 pi for an angle)."""

    zero: Node
    joint: str | None = None


Piece = tuple[Atom, ...]


def pieces(node: Node, joints: Sequence[str]) -> list[Piece]:
    """Return the union of pieces that a tree stands for.

    Understood: equations, `theta2 in {0, pi}`, `{theta2: [0, pi]}`, a bare expression (that vanishes), `and`, `or`,
    lists of these, `k*pi` for every whole number k. Raises ReadError.
    """
    if node.kind in ("or", "list", "set"):
        return [piece for arg in node.args for piece in pieces(arg, joints)]
    if node.kind == "and":
        return _together([pieces(arg, joints) for arg in node.args])
    if node.kind == "dict":
        return _together([_assigned(pair.args[0], pair.args[1], joints) for pair in node.args])
    if node.kind == "in":
        return _assigned(node.args[0], node.args[1], joints)
    if node.kind == "eq":
        left, right = node.args
        if right.kind in ("list", "set"):
            return _assigned(left, right, joints)
        for own, other in ((left, right), (right, left)):
            if own.kind == "name" and own.value in joints and own.value not in names(other):
                return _assigned(own, other, joints)
        return _vanishing(Node("-", (left, right)))
    return _vanishing(node)


def _together(sets: Sequence[Sequence[Piece]]) -> list[Piece]:
    """Return the pieces of an intersection: every combination of one piece of each set."""
    count = math.prod(len(pieces_) for pieces_ in sets)
    if count > _MOST_PIECES:
        raise ReadError(f"the conditions make {count} cases; more than {_MOST_PIECES} are not read")
    return [sum(combination, ()) for combination in product(*sets)]


def _assigned(joint: Node, values: Node, joints: Sequence[str]) -> list[Piece]:
    listed = values.args if values.kind in ("list", "set", "or") else (values,)
    if joint.kind != "name" or joint.value not in joints:
        return [piece for value in listed for piece in _vanishing(Node("-", (joint, value)))]
    found: list[Piece] = []
    for value in listed:
        for plain in _whole_number_cases(value):
            compile_tape([plain])
            found.append((Atom(plain, str(joint.value)),))
    return found


def _vanishing(node: Node) -> list[Piece]:
    compile_tape([node])
    return [(Atom(case),) for case in _whole_number_cases(node)]


def _whole_number_cases(node: Node) -> list[Node]:
    free = [name for name in _WHOLE_NUMBERS if name in names(node)]
    cases = [node]
    for name in free:
        cases = [_replaced(case, name, k) for case in cases for k in (0, 1, -1, 2, -2)]
    return cases


def _replaced(node: Node, name: str, k: int) -> Node:
    if node.kind == "name" and node.value == name:
        whole = Node("number", value=abs(k))
        return Node("neg", (whole,)) if k < 0 else whole
    return Node(node.kind, tuple(_replaced(arg, name, k) for arg in node.args), node.value)


@dataclass
class _Ready:
    """A piece with its expressions compiled."""

    values: list[tuple[str, Tape]] = field(default_factory=list)
    zeros: Tape | None = None
    free: list[str] = field(default_factory=list)


def _ready(piece: Piece, joints: Sequence[str]) -> _Ready:
    ready = _Ready([(atom.joint, compile_tape([atom.zero])) for atom in piece if atom.joint is not None])
    zeros = [atom.zero for atom in piece if atom.joint is None]
    fixed = {joint for joint, _ in ready.values}
    if zeros:
        ready.zeros = compile_tape(zeros)
        ready.free = [j for j in joints if j not in fixed and any(j in names(zero) for zero in zeros)]
    return ready


class Space:
    """The joints, their kinds and the domain in which sets of configurations live."""

    def __init__(self, joints: Sequence[str], domain: Domain) -> None:
        self.joints, self.domain = tuple(joints), domain

    def names_of(self, sets: Sequence[Sequence[Piece]]) -> set[str]:
        """Return every name that occurs in the sets, and the joints."""
        atoms = (atom for pieces_ in sets for piece in pieces_ for atom in piece)
        return set(self.joints).union(*(names(atom.zero) for atom in atoms))

    def on_piece(self, piece: Piece, used: set[str], stream: Stream, count: int = SAMPLES) -> dict[str, np.ndarray]:
        """Return up to `count` configurations (with values of the open symbols) at which the piece holds."""
        values = self.domain.sample(used, count, stream)
        ready = _ready(piece, self.joints)
        good = self._assign(ready, values, count)
        if ready.zeros is not None:
            good &= self._project(ready, values, count)
            good &= self._assign(ready, values, count)
        return {name: column[good] for name, column in values.items()}

    def _assign(self, ready: _Ready, values: dict[str, np.ndarray], count: int) -> np.ndarray:
        good = np.ones(count, dtype=bool)
        for joint, tape in ready.values:
            found = evaluate(tape, values, count)[0][0]
            good &= np.isfinite(found) & (np.abs(found.imag) < MEMBER)
            values[joint] = np.where(good, found.real, 0.0)
        return good

    def _project(self, ready: _Ready, values: dict[str, np.ndarray], count: int) -> np.ndarray:
        """Move the free joints onto the zeros by Gauss-Newton steps of least norm; tell where that ended well."""
        assert ready.zeros is not None
        step = 1e-6
        for _ in range(80):
            residual, size = self._zeros(ready, values, count)
            with np.errstate(all="ignore"):
                done = np.all(np.abs(residual) <= _PROJECTED * (1 + size), axis=0)
            if not ready.free or done.all():
                return np.asarray(done)
            slopes = np.empty((count, len(residual), len(ready.free)))
            for k, joint in enumerate(ready.free):
                ahead = {**values, joint: values[joint] + step}
                behind = {**values, joint: values[joint] - step}
                change = self._zeros(ready, ahead, count)[0] - self._zeros(ready, behind, count)[0]
                slopes[:, :, k] = change.T / (2 * step)
            good = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(residual).all(axis=0)
            slopes[~good] = 0.0
            move = np.einsum("pij,jp->pi", np.linalg.pinv(slopes, rcond=1e-12), np.where(good, residual, 0.0))
            longest = np.maximum(np.abs(move).max(axis=1, keepdims=True), 1e-300)
            move *= np.minimum(1.0, 0.7 / longest)
            for k, joint in enumerate(ready.free):
                values[joint] = np.where(done, values[joint], values[joint] - move[:, k])
        return np.asarray(done)

    def _zeros(self, ready: _Ready, values: Mapping[str, np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
        assert ready.zeros is not None
        found, size = evaluate(ready.zeros, values, count)
        return np.where(np.abs(found.imag) < MEMBER, found.real, np.nan), size

    def shown(self, name: str, value: float) -> float:
        """Return a value of six digits, an angle between -pi and pi."""
        if self.domain.roles.get(name) == "angle":
            value = float(np.angle(np.exp(1j * value)))
        return float(f"{value:.6g}") + 0.0

    def contains(
        self, sets: Sequence[Piece], values: Mapping[str, np.ndarray], count: int, tolerance: float = MEMBER
    ) -> np.ndarray:
        """Tell for each configuration whether it lies in the union of the pieces."""
        member = np.zeros(count, dtype=bool)
        for piece in sets:
            holds = np.ones(count, dtype=bool)
            for atom in piece:
                holds &= self._holds(atom, values, count, tolerance)
            member |= holds
        return member

    def _holds(self, atom: Atom, values: Mapping[str, np.ndarray], count: int, tolerance: float) -> np.ndarray:
        found, size = evaluate(compile_tape([atom.zero]), values, count)
        if atom.joint is None:
            return np.asarray(np.abs(found[0]) <= tolerance * (1e-3 + size[0]))
        gap = values[atom.joint] - found[0].real
        if self.domain.roles.get(atom.joint) == "angle":
            gap = np.angle(np.exp(1j * np.where(np.isfinite(gap), gap, np.nan)))
        return np.asarray((np.abs(gap) <= tolerance) & (np.abs(found[0].imag) <= tolerance))


@dataclass(frozen=True)
class SetComparison:
    """Which reference pieces are covered (None: empty for these lengths), which claimed ones are sound, and where not.

    `missing` and `surplus` are configurations: singular but not claimed, claimed but not singular.
    """

    covered: tuple[bool | None, ...]
    sound: tuple[bool | None, ...]
    missing: Mapping[str, Any] | None
    surplus: Mapping[str, Any] | None
    points: int

    @property
    def equal(self) -> bool:
        """Whether the two sets hold the same configurations."""
        return False not in self.covered and False not in self.sound


def compare_sets(claimed: Sequence[Piece], reference: Sequence[Piece], space: Space, seed: str) -> SetComparison:
    """Compare a claimed set of configurations with the reference, piece by piece."""
    used = space.names_of([claimed, reference])
    points = 0

    def inclusion(inner: Sequence[Piece], outer: Sequence[Piece], tag: str) -> tuple[list[bool | None], Any]:
        nonlocal points
        held: list[bool | None] = []
        example = None
        for index, piece in enumerate(inner):
            values = space.on_piece(piece, used, Stream(f"{seed}/{tag}/{index}"))
            count = len(next(iter(values.values())))
            points += count
            # Values that were stated are held to the tolerance of all answers, what was projected to the projection's.
            stated = all(atom.joint is not None for atom in piece)
            inside = space.contains(outer, values, count, TOLERANCE if stated else MEMBER)
            held.append(None if count == 0 else bool(inside.all()))
            if count and not inside.all() and example is None:
                first = int(np.nonzero(~inside)[0][0])
                example = {name: space.shown(name, values[name][first]) for name in sorted(values)}
        return held, example

    covered, missing = inclusion(reference, claimed, "reference")
    sound, surplus = inclusion(claimed, reference, "claimed")
    if not claimed:
        missing = missing or {}
    return SetComparison(tuple(covered), tuple(sound), missing, surplus, points)
