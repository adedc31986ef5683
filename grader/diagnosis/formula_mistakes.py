"""Slips in the finished formulas of an answer: one place in an entry, or the same everywhere (mistakes.finished).

Where single entries are meant, they are named: the rest of the answer is right.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import islice, product

import numpy as np

from qdot.exercises.formula.algebra import ONE, ZERO, plus, terms_of
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
    map_nodes,
    replace_each_wave,
    turn_wave,
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

    reference: Rows
    derivatives: np.ndarray
    typed: Rows | None = None


def explain_formulas(
    formulas: Compared, values: Values, answer: InNumbers, right: np.ndarray, any_number: bool = False
) -> Diagnosis | None:
    """Return what went wrong in the finished formulas, which have the shape of `right`.

    One slip in an entry is looked for, also a number or an angle that is wrong by `any_number`. Blanks are not wrong.
    """
    if answer.values.shape != right.shape:
        return None
    is_wrong = ~answer.like(right) & ~np.isnan(answer.values).any(axis=-1)
    places = [(int(i), int(j)) for i, j in np.argwhere(is_wrong)]
    if not places:
        return None
    if not len(places) == 1 < is_wrong.size:
        diagnosis = (
            _find_exchange(answer, right, places)
            or _find_throughout(formulas.reference, values, answer)
            or _find_other_lengths(formulas, values, answer, right)
        )
        if diagnosis is not None or len(places) > MOST_ENTRIES:
            return diagnosis
    return _find_in_places(formulas, values, answer, right, places, any_number)


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
        *first, last = [str(max(place) + 1) for place in places]
        return f"In entries {', '.join(first)} and {last}" if first else f"In entry {last}"
    *first, last = [f"row {i + 1}, column {j + 1}" for i, j in places]
    return f"In {', '.join(first)}, and {last}," if first else f"In {last},"


def _find_exchange(answer: InNumbers, right: np.ndarray, places: Sequence[Place]) -> Diagnosis | None:
    if len(places) != 2:
        return None
    swapped = right.copy()
    swapped[places[0]], swapped[places[1]] = right[places[1]], right[places[0]]
    return _name("entries-exchanged", places, right.shape) if answer.is_all(swapped) else None


def _find_throughout(rows: Rows, values: Values, answer: InNumbers) -> Diagnosis | None:
    """Return the mistake that was made everywhere in the formulas, as far as these are not too long."""
    size = sum(size_of(entry) for row in rows for entry in row)
    for name, changed in islice(edits_throughout(rows), MOST_NODES // max(size, 1)):
        wrong = _evaluate([entry for row in changed for entry in row], values).reshape(answer.values.shape)
        if answer.is_all(wrong) and says_something(wrong):
            return Diagnosis((name,), CATALOGUE[name].sentence({"Where": "In your answer"}))
    return None


def _find_other_lengths(formulas: Compared, values: Values, answer: InNumbers, right: np.ndarray) -> Diagnosis | None:
    """Return that an answer is right but for its lengths, of which several are not those of this arm.

    It is no mistake of the catalogue, for which something is paid: the arm may be another student's.
    """
    entries = [entry for row in formulas.typed or [] for entry in row]
    if sum(map(size_of, entries)) > LONGEST:
        return None
    typed = [leaf for entry in entries for leaf in _lengths_in(entry)]
    known = list(dict.fromkeys(leaf for row in formulas.reference for entry in row for leaf in _lengths_in(entry)))
    replaced = list(dict.fromkeys(typed))
    strange = [leaf for leaf in replaced if leaf not in known]
    if len(known) ** len(replaced) > MOST_WAYS:
        replaced = strange  # else others may stand for another length, too
    if sum(map(typed.count, strange)) < 2 or not 0 < len(known) ** len(replaced) <= MOST_WAYS:
        return None
    few = {name: value[:FEW_POINTS] for name, value in values.items()}
    ways = list(product(_evaluate(known, few), repeat=len(replaced)))
    names_of = {leaf: Node("name", value=f"length {k}") for k, leaf in enumerate(replaced)}
    lengths = {f"length {k}": np.concatenate([way[k] for way in ways]).real for k in range(len(replaced))}
    tiled = {name: np.tile(value, len(ways)) for name, value in few.items()}
    evaluated = _evaluate([map_nodes(entry, names_of.get) for entry in entries], tiled | lengths)
    answers = evaluated.reshape(*right.shape[:2], len(ways), -1)
    expected, size = right[..., :FEW_POINTS], answer.size[..., :FEW_POINTS]
    if not any(InNumbers(answers[:, :, k], size, answer.room).is_all(expected) for k in range(len(ways))):
        return None
    which = ", ".join(map(node_text, strange))
    return Diagnosis((), f"This would be right for an arm with other lengths ({which}): {OWN_TABLE}")


def _lengths_in(node: Node) -> Iterator[Node]:
    if node.kind == "decimal" or (node.kind == "name" and is_length(node.value)):
        yield node
    for arg in node.args:
        yield from _lengths_in(arg)


def _find_in_places(
    formulas: Compared, values: Values, answer: InNumbers, right: np.ndarray, places: Sequence[Place], any_number: bool
) -> Diagnosis | None:
    """Return the one kind of slip that was made in each of some entries, or up to two kinds."""
    count = answer.values[..., 0].size
    possible: dict[Place, list[Slip]] = {}
    for i, j in places:
        entry = _Entry(
            formulas.reference[i][j], formulas.typed[i][j] if formulas.typed else None,
            bool(formulas.derivatives[i, j]), values, answer.entry(i, j), right[i, j],
        )  # fmt: skip
        possible[i, j] = entry.slips(beside_others=3 < count != len(places), any_number=any_number)
        if not possible[i, j]:
            return None
    common = [name for name, _ in possible[places[0]] if all(name in dict(slips) for slips in possible.values())]
    made: dict[Slip, list[Place]] = {}
    for place, slips in possible.items():
        made.setdefault(next(slip for slip in slips if slip[0] in common[:1] or not common), []).append(place)
    mistakes = tuple(dict.fromkeys(name for name, _ in made))
    if len(mistakes) > 2:
        return None
    diagnoses = [_name(name, where, answer.values.shape, which) for (name, which), where in made.items()]
    known_by = tuple(name for diagnosis in diagnoses for name in diagnosis.known_by)
    return Diagnosis(mistakes, " ".join(diagnosis.says for diagnosis in diagnoses), known_by=known_by)


Slip = tuple[str, str]
"""The name of a mistake, and which term or factor is missing, in words."""


@dataclass(frozen=True)
class _Entry:
    """One wrong entry: as it is in the reference, as it was typed, and both in numbers."""

    reference: Node
    typed: Node | None
    is_derivative: bool
    values: Values
    answer: InNumbers
    right: np.ndarray

    def slips(self, beside_others: bool, any_number: bool) -> list[Slip]:
        """Return the slips that give the entry, the likelier first; a constant tells one only `beside_others`."""
        says = says_something(self.answer.values)
        if not (says or beside_others):
            return []
        if not self.answer.values.any():
            is_term = terms_of(self.reference, 1)
            return [
                ("term-missing", Edit("", self.reference, self.reference).which) if is_term else ("entry-missing", "")
            ]
        slips = list(dict.fromkeys((*self._edited(), *self._reversed(), *self._by_sign())))
        if slips or not (says and any_number):
            return slips
        return list(self._by_number()) or list(self._by_angle())

    def _edited(self) -> Iterator[Slip]:
        """Yield what gives the entry if it is done to the reference."""
        for edit in self._fitting_edits(self.reference, self.answer):
            yield edit.mistake, edit.which

    def _reversed(self) -> Iterator[Slip]:
        """Yield what is too many in the entry: the reference is what remains without it."""
        if self.typed is None:
            return
        expected = replace(self.answer, values=self.right[None, None])
        for edit in self._fitting_edits(self.typed, expected, TOO_MANY):
            yield TOO_MANY[edit.mistake], edit.which
        if expected.is_all(np.zeros_like(expected.values)):
            yield "term-surplus", Edit("", self.typed, self.typed).which

    def _fitting_edits(self, entry: Node, wanted: InNumbers, mistakes: Collection[str] = CATALOGUE) -> list[Edit]:
        """Return the edits of a formula, those that are certain mistakes, after which it has the wanted values."""
        if not self.is_derivative:
            mistakes = set(mistakes) - OF_DERIVATIVES
        changed = list(islice((edit for edit in edits(entry, self.values) if edit.mistake in mistakes), MOST_EDITS))
        answers = _evaluate([edit.entry for edit in changed], self.values)
        return [changed[k] for k in np.flatnonzero(wanted.like(answers[:, None, None]))] if changed else []

    def _by_number(self) -> Iterator[Slip]:
        """Yield a term, or all, that is multiplied by a wrong number, whatever that is, or that a number is added."""
        terms = (terms_of(self.reference, MOST_TERMS) if size_of(self.reference) <= LONGEST else None) or []
        parts = [*terms, ONE, *([self.reference] if len(terms) > 1 else [])]
        off = self.answer.values[0, 0] - self.right
        for part, values in zip(parts, _evaluate(parts, self.values), strict=True):
            with np.errstate(all="ignore"):
                share = off / values
            if np.isfinite(share).all() and np.ptp(share.real) <= 1e-6 * np.abs(share).max():
                about = ", ".join(sorted(names(part)))
                if part in terms and about:
                    yield "number-typed", f" (with {about} in it)"
                else:
                    yield ("entry-factor" if about else "constant-typed"), ""

    def _by_angle(self) -> Iterator[Slip]:
        """Yield that one angle is wrong by a constant, whatever that is.

        With w a sine or cosine and w' the same a quarter turn on, the entry is A + B (w cos c + w' sin c): c follows.
        """
        if size_of(self.reference) > LONGEST or self.right.shape[-1] < POINTS_FOR_CONSTANT:
            return
        without = replace_each_wave(self.reference, lambda _: ZERO)[:MOST_WAVES]
        turned = replace_each_wave(self.reference, turn_wave)[:MOST_WAVES]
        whole, *parts = _evaluate([self.reference, *without, *turned], self.values)
        for k, (rest, on) in enumerate(zip(parts[: len(without)], parts[len(without) :], strict=True)):
            slopes = np.stack([whole - rest, on - rest], axis=1)
            if not np.isfinite(slopes).all():
                continue
            (c, s), *_ = np.linalg.lstsq(slopes.real, (self.answer.values[0, 0] - rest).real, rcond=None)
            if abs(c * c + s * s - 1) > 1e-6:
                continue
            more = Node("decimal", value=Fraction(float(np.arctan2(s, c))))
            shift = partial(_add_to_angle, more)
            if self.answer.is_all(_evaluate([replace_each_wave(self.reference, shift)[k]], self.values)[None]):
                yield "angle-typed", ""
                return

    def _by_sign(self) -> Iterator[Slip]:
        """Yield that the entry has the right size, and the wrong sign in some configurations only."""
        values, right = self.answer.values[0, 0].real, self.right.real
        is_same_size = replace(self.answer, values=np.abs(values)[None, None]).is_all(np.abs(right)[None, None])
        if is_same_size and (values * right > 0).any() and (values * right < 0).any():
            yield "sign-lost", ""


def _add_to_angle(more: Node, wave: Node) -> Node:
    return Node("call", (plus(wave.args[0], more),), wave.value)


def _evaluate(entries: Sequence[Node], values: Values) -> np.ndarray:
    """Return values, (entries, N); nan where one can't be had."""
    return evaluate_each(entries, values, len(next(iter(values.values()))))


def _name(name: str, places: Sequence[Place], shape: tuple[int, ...], which: str = "") -> Diagnosis:
    where = in_words(places, shape)
    return Diagnosis((name,), CATALOGUE[name].sentence({"Where": where, "which": which}), known_by=(f"{name} {where}",))
