"""Slips in the finished formulas of an answer: one place in an entry, or the same everywhere (mistakes.finished).

Where single entries are meant, they are named: the rest of the answer is right.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice, product

import numpy as np

from qdot.exercises.formula.algebra import ONE, terms_of
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.program import evaluate_each
from qdot.exercises.formula.trees import Node, names, node_text, size_of
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.mistakes.configurations import Values
from qdot.exercises.mistakes.finished import (
    LONGEST,
    MOST_TERMS,
    OF_DERIVATIVES,
    Edit,
    edits,
    edits_throughout,
    is_length,
    waves_in,
)
from qdot.grader.diagnosis.numbers import InNumbers, says_something
from qdot.grader.judging.verdict import Diagnosis

MOST_ENTRIES = 8
"""Wrong entries in which single slips are looked for."""
MOST_NODES = 40_000
"""Nodes of all changed formulas that are evaluated for an answer."""

MOST_EDITS = 600
"""Slips that are tried in an entry."""
MOST_WAVES = 24
"""Sines and cosines of an entry whose angle may be wrong by any constant."""
POINTS_FOR_CONSTANT = 4

MOST_WAYS, FEW_POINTS = 300, 3
"""Ways to put an arm's own lengths in the place of those in an answer that are tried, and at how many points."""

OWN_TABLE = "use the lengths in the table of your own arm. See (6.1)."
TOO_MANY = {"term-missing": "term-surplus", "factor-missing": "factor-surplus"}
"""What is missing in what is due beside an answer is too many in the answer beside what is due."""

Place = tuple[int, int]


@dataclass(frozen=True)
class Compared:
    """The formulas of the reference, (rows, columns), and the student's beside them, where there are any.

    `derivatives` tells which entries are differentiated.
    """

    due: Rows
    derivatives: np.ndarray
    mine: Rows | None = None


def finished(
    formulas: Compared, values: Values, found: InNumbers, right: np.ndarray, any_number: bool = False
) -> Diagnosis | None:
    """Return what went wrong in the finished formulas, which have the shape of `right`.

    One slip in an entry is looked for, also a number or an angle that is wrong by `any_number`. What is blank is not
    wrong.
    """
    if found.values.shape != right.shape:
        return None
    wrong = ~found.like(right) & ~np.isnan(found.values).any(axis=-1)
    places = [(int(i), int(j)) for i, j in np.argwhere(wrong)]
    if not places:
        return None
    if len(places) == 1 < wrong.size:
        return _in_places(formulas, values, found, right, places, any_number)
    return (
        _exchanged(found, right, places)
        or _everywhere(formulas.due, values, found)
        or _of_another_arm(formulas, values, found, right)
        or (_in_places(formulas, values, found, right, places, any_number) if len(places) <= MOST_ENTRIES else None)
    )


def in_words(places: Sequence[Place], shape: tuple[int, ...]) -> str:
    """Return where entries stand, to begin a sentence.

    >>> in_words([(0, 1), (1, 1)], (2, 2))
    'In row 1, column 2, and row 2, column 2,'
    >>> in_words([(1, 0)], (3, 1)), in_words([(0, 0)], (1, 1))
    ('In entry 2', 'In your answer')
    """
    if shape[:2] == (1, 1):
        return "In your answer"
    if 1 in shape[:2]:
        numbers = [str(max(place) + 1) for place in places]
        return (
            f"In entry {numbers[0]}" if len(numbers) == 1 else f"In entries {', '.join(numbers[:-1])} and {numbers[-1]}"
        )
    said = [f"row {i + 1}, column {j + 1}" for i, j in places]
    return f"In {said[0]}," if len(said) == 1 else f"In {', '.join(said[:-1])}, and {said[-1]},"


def _exchanged(found: InNumbers, right: np.ndarray, places: Sequence[Place]) -> Diagnosis | None:
    if len(places) != 2:
        return None
    swapped = right.copy()
    one, other = places
    swapped[one], swapped[other] = right[other], right[one]
    return _said("entries-exchanged", places, right.shape) if found.is_all(swapped) else None


def _everywhere(rows: Rows, values: Values, found: InNumbers) -> Diagnosis | None:
    room = MOST_NODES
    size = sum(size_of(entry) for row in rows for entry in row)
    for name, changed in edits_throughout(rows):
        room -= size
        if room < 0:
            return None
        answer = _evaluated([entry for row in changed for entry in row], values).reshape(found.values.shape)
        if found.is_all(answer) and says_something(answer):
            return Diagnosis((name,), CATALOGUE[name].sentence({"Where": "In your answer"}))
    return None


def _of_another_arm(formulas: Compared, values: Values, found: InNumbers, right: np.ndarray) -> Diagnosis | None:
    """Return that an answer is right but for its lengths, of which several are not those of this arm.

    It is no mistake of the catalogue, for which something is paid: the arm may be another student's.
    """
    entries = [entry for row in formulas.mine or [] for entry in row]
    if sum(map(size_of, entries)) > LONGEST:
        return None
    mine = [leaf for entry in entries for leaf in _lengths_in(entry)]
    known = list(dict.fromkeys(leaf for row in formulas.due for entry in row for leaf in _lengths_in(entry)))
    own = list(dict.fromkeys(mine))
    strange = [leaf for leaf in own if leaf not in known]
    own = own if len(known) ** len(own) <= MOST_WAYS else strange  # others may stand for another length, too
    if sum(map(mine.count, strange)) < 2 or not 0 < len(known) ** len(own) <= MOST_WAYS:
        return None
    some = {name: value[:FEW_POINTS] for name, value in values.items()}
    ways = list(product(_evaluated(known, some), repeat=len(own)))
    put = {leaf: Node("name", value=f"length {k}") for k, leaf in enumerate(own)}
    lengths = {f"length {k}": np.concatenate([way[k] for way in ways]).real for k in range(len(own))}
    tiled = {name: np.tile(value, len(ways)) for name, value in some.items()}
    evaluated = _evaluated([_with_leaves(entry, put) for entry in entries], tiled | lengths)
    answers = evaluated.reshape(*right.shape[:2], len(ways), -1)
    due, size = right[..., :FEW_POINTS], found.size[..., :FEW_POINTS]
    if not any(InNumbers(answers[:, :, k], size, found.room).is_all(due) for k in range(len(ways))):
        return None
    which = ", ".join(map(node_text, strange))
    return Diagnosis((), f"This would be right for an arm with other lengths ({which}): {OWN_TABLE}")


def _lengths_in(node: Node) -> Iterator[Node]:
    if node.kind == "decimal" or (node.kind == "name" and is_length(node.value)):
        yield node
    for arg in node.args:
        yield from _lengths_in(arg)


def _with_leaves(node: Node, put: Mapping[Node, Node]) -> Node:
    if not node.args:
        return put.get(node, node)
    return Node(node.kind, tuple(_with_leaves(arg, put) for arg in node.args), node.value)


def _in_places(
    formulas: Compared, values: Values, found: InNumbers, right: np.ndarray, places: Sequence[Place], any_number: bool
) -> Diagnosis | None:
    """Return the one kind of slip that was made in each of some entries, or up to two kinds."""
    several, is_all = found.values[..., 0].size > 3, len(places) == found.values[..., 0].size
    possible: dict[Place, list[Slip]] = {}
    for i, j in places:
        mine = formulas.mine[i][j] if formulas.mine else None
        is_derivative = bool(formulas.derivatives[i, j])
        entry = _Entry(formulas.due[i][j], mine, is_derivative, values, found.entry(i, j), right[i, j])
        possible[i, j] = entry.slips(beside_others=several and not is_all, any_number=any_number)
        if not possible[i, j]:
            return None
    common = [name for name, _ in possible[places[0]] if all(name in dict(slips) for slips in possible.values())]
    made: dict[Slip, list[Place]] = {}
    for place, slips in possible.items():
        made.setdefault(next(slip for slip in slips if slip[0] in common[:1] or not common), []).append(place)
    names = tuple(dict.fromkeys(name for name, _ in made))
    if len(names) > 2:
        return None
    said = [_said(name, where, found.values.shape, which) for (name, which), where in made.items()]
    known_by = tuple(name for one in said for name in one.known_by)
    return Diagnosis(names, " ".join(one.says for one in said), known_by=known_by)


Slip = tuple[str, str]
"""The name of a mistake, and which term or factor is missing, in words."""


@dataclass(frozen=True)
class _Entry:
    """One wrong entry: as it is due, as it was typed, and both in numbers."""

    due: Node
    mine: Node | None
    is_derivative: bool
    values: Values
    found: InNumbers
    right: np.ndarray

    def slips(self, beside_others: bool, any_number: bool) -> list[Slip]:
        """Return the slips that give the entry, the likelier first; a constant tells one only `beside_others`."""
        says = says_something(self.found.values)
        if not (says or beside_others):
            return []
        if not self.found.values.any():
            return [
                ("term-missing", Edit("", self.due, self.due).which) if terms_of(self.due, 1) else ("entry-missing", "")
            ]
        slips = list(dict.fromkeys((*self._edited(), *self._reversed(), *self._by_sign())))
        if slips or not (says and any_number):
            return slips
        is_turned = _by_a_constant(self.due, self.values, self.found)
        return list(self._by_number()) or ([("angle-typed", "")] if is_turned else [])

    def _edited(self) -> Iterator[Slip]:
        """Yield what gives the entry if it is done to what is due."""
        some = (
            edit for edit in edits(self.due, self.values) if self.is_derivative or edit.mistake not in OF_DERIVATIVES
        )
        changed = list(islice(some, MOST_EDITS))
        answers = _evaluated([edit.entry for edit in changed], self.values)
        for k in np.flatnonzero(self.found.like(answers[:, None, None])) if changed else ():
            yield changed[k].mistake, changed[k].which

    def _reversed(self) -> Iterator[Slip]:
        """Yield what is too many in the entry: what is due is what remains without it."""
        if self.mine is None:
            return
        some = (edit for edit in edits(self.mine, self.values) if edit.mistake in TOO_MANY)
        changed = list(islice(some, MOST_EDITS))
        answers = _evaluated([edit.entry for edit in changed], self.values)
        due = replace(self.found, values=self.right[None, None])
        for k in np.flatnonzero(due.like(answers[:, None, None])) if changed else ():
            yield TOO_MANY[changed[k].mistake], changed[k].which
        if due.is_all(np.zeros_like(due.values)):
            yield "term-surplus", Edit("", self.mine, self.mine).which

    def _by_number(self) -> Iterator[Slip]:
        """Yield a term, or all, that is multiplied by a wrong number, whatever that is, or that a number is added."""
        terms = (terms_of(self.due, MOST_TERMS) if size_of(self.due) <= LONGEST else None) or []
        parts = [*terms, ONE, *([self.due] if len(terms) > 1 else [])]
        off = self.found.values[0, 0] - self.right
        for part, values in zip(parts, _evaluated(parts, self.values), strict=True):
            with np.errstate(all="ignore"):
                share = off / values
            if np.isfinite(share).all() and np.ptp(share.real) <= 1e-6 * np.abs(share).max():
                about = ", ".join(sorted(names(part)))
                if part in terms and about:
                    yield "number-typed", f" (with {about} in it)"
                else:
                    yield ("entry-factor" if about else "constant-typed"), ""

    def _by_sign(self) -> Iterator[Slip]:
        """Yield that the entry has the size that is due, and the wrong sign in some configurations only."""
        mine, due = self.found.values[0, 0].real, self.right.real
        of_size = replace(self.found, values=np.abs(mine)[None, None]).is_all(np.abs(due)[None, None])
        if of_size and (mine * due > 0).any() and (mine * due < 0).any():
            yield "sign-lost", ""


def _by_a_constant(entry: Node, values: Values, found: InNumbers) -> bool:
    """Tell whether one angle is wrong by a constant, whatever that is.

    With w and w' a sine or cosine and what is a quarter turn on, the entry is A + B (w cos c + w' sin c): c follows.
    """
    gone = list(islice(waves_in(entry), MOST_WAVES)) if size_of(entry) <= LONGEST else []
    if not gone or found.values.shape[-1] < POINTS_FOR_CONSTANT:
        return False
    probes = _evaluated([entry, *(tree for one in gone for tree in (one.without, one.on))], values)
    mine = found.values[0, 0]
    for k, one in enumerate(gone):
        without, on = probes[2 * k + 1], probes[2 * k + 2]
        slopes = np.stack([probes[0] - without, on - without], axis=1)
        if not (np.isfinite(slopes).all() and np.isfinite(without).all()):
            continue
        (c, s), *_ = np.linalg.lstsq(slopes.real, (mine - without).real, rcond=None)
        if abs(c * c + s * s - 1) > 1e-6:
            continue
        more = Node("decimal", value=Fraction(float(np.arctan2(s, c))))
        if found.is_all(_evaluated([one.turned(more)], values)[None]):
            return True
    return False


def _evaluated(entries: Sequence[Node], values: Values) -> np.ndarray:
    """Return values, (entries, N); nan where one can't be had."""
    return evaluate_each(entries, values, len(next(iter(values.values()))))


def _said(name: str, places: Sequence[Place], shape: tuple[int, ...], which: str = "") -> Diagnosis:
    where = in_words(places, shape)
    return Diagnosis((name,), CATALOGUE[name].sentence({"Where": where, "which": which}), known_by=(f"{name} {where}",))
