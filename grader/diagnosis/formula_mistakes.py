"""Find mistakes in the finished formulas of an answer: one in each wrong entry, or the same one everywhere.

If only some entries are wrong, the diagnosis names these entries. `mistakes.finished` defines the mistakes.
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
"""An answer with more wrong entries than this is not searched entry by entry."""
MOST_NODES = 40_000
"""Maximum number of nodes of all the edited formulas that are evaluated for an answer."""

MOST_EDITS = 600
"""Maximum number of edits that are tried in an entry."""
MOST_WAVES = 24
"""Maximum number of sines and cosines of an entry that are tried with a constant added to their angle."""
POINTS_FOR_CONSTANT = 4

MOST_WAYS, FEW_POINTS = 300, 3
"""How many ways of replacing an answer's lengths by those of the arm are tried, and at how many configurations."""

OWN_TABLE = "use the lengths in the table of your own arm. See (6.1)."
TOO_MANY = {"term-missing": "term-surplus", "factor-missing": "factor-surplus"}
"""Maps a missing term or factor to a surplus one: what the reference lacks, compared with the answer, is surplus."""

Place = tuple[int, int]


@dataclass(frozen=True)
class Compared:
    """The formulas of the reference, (rows, columns), and those that the student typed, if any.

    `derivatives` is whether each entry is found by differentiation.
    """

    reference: Rows
    derivatives: np.ndarray
    typed: Rows | None = None


def explain_formulas(
    formulas: Compared, values: Values, answer: InNumbers, right: np.ndarray, any_number: bool = False
) -> Diagnosis | None:
    """Return the mistake in the finished formulas of an answer that has the shape of `right`.

    Each wrong entry is searched for one mistake. If `any_number`, a number or an angle may also be wrong by any amount.
    Blanks don't count as wrong.
    """
    if answer.values.shape != right.shape:
        return None
    is_wrong = ~answer.like(right) & ~np.isnan(answer.values).any(axis=-1)
    wrong_entries = [(int(i), int(j)) for i, j in np.argwhere(is_wrong)]
    if not wrong_entries:
        return None
    if not len(wrong_entries) == 1 < is_wrong.size:
        diagnosis = (
            _find_exchange(answer, right, wrong_entries)
            or _find_throughout(formulas.reference, values, answer)
            or _find_other_lengths(formulas, values, answer, right)
        )
        if diagnosis is not None or len(wrong_entries) > MOST_ENTRIES:
            return diagnosis
    return _find_in_places(formulas, values, answer, right, wrong_entries, any_number)


def in_words(places: Sequence[Place], shape: tuple[int, ...]) -> str:
    """Return the positions of entries in words, as the beginning of a sentence.

    >>> in_words([(0, 1), (1, 1)], (2, 2))
    'In row 1, column 2, and row 2, column 2,'
    >>> in_words([(1, 0)], (3, 1)), in_words([(0, 0)], (1, 1))
    ('In entry 2', 'In your answer')
    """
    if shape[:2] == (1, 1):
        return "In your answer"
    if 1 in shape[:2]:
        *others, last_entry = [str(max(index) + 1) for index in places]
        return f"In entries {', '.join(others)} and {last_entry}" if others else f"In entry {last_entry}"
    *others, last_entry = [f"row {i + 1}, column {j + 1}" for i, j in places]
    return f"In {', '.join(others)}, and {last_entry}," if others else f"In {last_entry},"


def _find_exchange(answer: InNumbers, right: np.ndarray, places: Sequence[Place]) -> Diagnosis | None:
    if len(places) != 2:
        return None
    exchanged_values = right.copy()
    exchanged_values[places[0]], exchanged_values[places[1]] = right[places[1]], right[places[0]]
    return _name("entries-exchanged", places, right.shape) if answer.is_all(exchanged_values) else None


def _find_throughout(rows: Rows, values: Values, answer: InNumbers) -> Diagnosis | None:
    """Return the mistake that was made everywhere in the formulas; None if there is none or they are too long."""
    size = sum(size_of(entry) for row in rows for entry in row)
    for name, edited_rows in islice(edits_throughout(rows), MOST_NODES // max(size, 1)):
        predicted = _evaluate([entry for row in edited_rows for entry in row], values).reshape(answer.values.shape)
        if answer.is_all(predicted) and says_something(predicted):
            return Diagnosis((name,), CATALOGUE[name].sentence({"Where": "In your answer"}))
    return None


def _find_other_lengths(formulas: Compared, values: Values, answer: InNumbers, right: np.ndarray) -> Diagnosis | None:
    """Return the diagnosis that an answer would be correct for an arm with other lengths, of which several differ.

    This is not a mistake of the catalogue and earns no partial credit, because the arm may be another student's.
    """
    entries = [entry for row in formulas.typed or [] for entry in row]
    if sum(map(size_of, entries)) > LONGEST:
        return None
    typed_lengths = [leaf for entry in entries for leaf in _lengths_in(entry)]
    arm_lengths = list(
        dict.fromkeys(leaf for row in formulas.reference for entry in row for leaf in _lengths_in(entry))
    )
    replaced = list(dict.fromkeys(typed_lengths))
    other_lengths = [leaf for leaf in replaced if leaf not in arm_lengths]
    if len(arm_lengths) ** len(replaced) > MOST_WAYS:
        replaced = other_lengths  # if there are few combinations, the arm's own lengths may also be exchanged
    if sum(map(typed_lengths.count, other_lengths)) < 2 or not 0 < len(arm_lengths) ** len(replaced) <= MOST_WAYS:
        return None
    sampled_values = {name: value[:FEW_POINTS] for name, value in values.items()}
    replacements = list(product(_evaluate(arm_lengths, sampled_values), repeat=len(replaced)))
    names_of = {leaf: Node("name", value=f"length {k}") for k, leaf in enumerate(replaced)}
    lengths = {
        f"length {k}": np.concatenate([replacement[k] for replacement in replacements]).real
        for k in range(len(replaced))
    }
    repeated_values = {name: np.tile(value, len(replacements)) for name, value in sampled_values.items()}
    values_of_entries = _evaluate([map_nodes(entry, names_of.get) for entry in entries], repeated_values | lengths)
    answers = values_of_entries.reshape(*right.shape[:2], len(replacements), -1)
    expected, size = right[..., :FEW_POINTS], answer.size[..., :FEW_POINTS]
    if not any(InNumbers(answers[:, :, k], size, answer.room).is_all(expected) for k in range(len(replacements))):
        return None
    length_words = ", ".join(map(node_text, other_lengths))
    return Diagnosis((), f"This would be right for an arm with other lengths ({length_words}): {OWN_TABLE}")


def _lengths_in(node: Node) -> Iterator[Node]:
    if node.kind == "decimal" or (node.kind == "name" and is_length(node.value)):
        yield node
    for arg in node.args:
        yield from _lengths_in(arg)


def _find_in_places(
    formulas: Compared, values: Values, answer: InNumbers, right: np.ndarray, places: Sequence[Place], any_number: bool
) -> Diagnosis | None:
    """Return the mistake that was made in each wrong entry: the same in all, or one of at most two kinds."""
    count = answer.values[..., 0].size
    mistakes_by_entry: dict[Place, list[Slip]] = {}
    for i, j in places:
        entry = _Entry(
            formulas.reference[i][j], formulas.typed[i][j] if formulas.typed else None,
            bool(formulas.derivatives[i, j]), values, answer.entry(i, j), right[i, j],
        )  # fmt: skip
        mistakes_by_entry[i, j] = entry.slips(beside_others=3 < count != len(places), any_number=any_number)
        if not mistakes_by_entry[i, j]:
            return None
    common = [
        name
        for name, _ in mistakes_by_entry[places[0]]
        if all(name in dict(slips) for slips in mistakes_by_entry.values())
    ]
    entries_by_mistake: dict[Slip, list[Place]] = {}
    for entry_index, slips in mistakes_by_entry.items():
        entries_by_mistake.setdefault(next(slip for slip in slips if slip[0] in common[:1] or not common), []).append(
            entry_index
        )
    mistakes = tuple(dict.fromkeys(name for name, _ in entries_by_mistake))
    if len(mistakes) > 2:
        return None
    diagnoses = [
        _name(name, entry_indices, answer.values.shape, missing_words)
        for (name, missing_words), entry_indices in entries_by_mistake.items()
    ]
    known_by = tuple(name for diagnosis in diagnoses for name in diagnosis.known_by)
    return Diagnosis(mistakes, " ".join(diagnosis.says for diagnosis in diagnoses), known_by=known_by)


Slip = tuple[str, str]
"""The name of a mistake, and words that identify the missing term or factor, if any."""


@dataclass(frozen=True)
class _Entry:
    """One wrong entry of an answer, with its reference: the formulas and the values of both."""

    reference: Node
    typed: Node | None
    is_derivative: bool
    values: Values
    answer: InNumbers
    right: np.ndarray

    def slips(self, beside_others: bool, any_number: bool) -> list[Slip]:
        """Return the mistakes that give the entry, the likelier first.

        A constant entry identifies a mistake only if there are enough correct entries (`beside_others`).
        """
        is_informative = says_something(self.answer.values)
        if not (is_informative or beside_others):
            return []
        if not self.answer.values.any():
            is_term = terms_of(self.reference, 1)
            return [
                ("term-missing", Edit("", self.reference, self.reference).which) if is_term else ("entry-missing", "")
            ]
        mistakes = list(dict.fromkeys((*self._edited(), *self._reversed(), *self._by_sign())))
        if mistakes or not (is_informative and any_number):
            return mistakes
        return list(self._by_number()) or list(self._by_angle())

    def _edited(self) -> Iterator[Slip]:
        """Yield the mistakes that give the entry when they are made in the reference."""
        for edit in self._fitting_edits(self.reference, self.answer):
            yield edit.mistake, edit.which

    def _reversed(self) -> Iterator[Slip]:
        """Yield a mistake if the entry without one of its terms or factors equals the reference."""
        if self.typed is None:
            return
        expected = replace(self.answer, values=self.right[None, None])
        for edit in self._fitting_edits(self.typed, expected, TOO_MANY):
            yield TOO_MANY[edit.mistake], edit.which
        if expected.is_all(np.zeros_like(expected.values)):
            yield "term-surplus", Edit("", self.typed, self.typed).which

    def _fitting_edits(self, entry: Node, wanted: InNumbers, mistakes: Collection[str] = CATALOGUE) -> list[Edit]:
        """Return the edits of a formula that give the expected values, among the edits for the given mistakes."""
        if not self.is_derivative:
            mistakes = set(mistakes) - OF_DERIVATIVES
        candidates = list(islice((edit for edit in edits(entry, self.values) if edit.mistake in mistakes), MOST_EDITS))
        answers = _evaluate([edit.entry for edit in candidates], self.values)
        return [candidates[k] for k in np.flatnonzero(wanted.like(answers[:, None, None]))] if candidates else []

    def _by_number(self) -> Iterator[Slip]:
        """Yield a mistake if a term or the entry is multiplied by any number, or if any number is added."""
        terms = (terms_of(self.reference, MOST_TERMS) if size_of(self.reference) <= LONGEST else None) or []
        parts = [*terms, ONE, *([self.reference] if len(terms) > 1 else [])]
        difference = self.answer.values[0, 0] - self.right
        for part, values in zip(parts, _evaluate(parts, self.values), strict=True):
            with np.errstate(all="ignore"):
                ratio = difference / values
            if np.isfinite(ratio).all() and np.ptp(ratio.real) <= 1e-6 * np.abs(ratio).max():
                symbols = ", ".join(sorted(names(part)))
                if part in terms and symbols:
                    yield "number-typed", f" (with {symbols} in it)"
                else:
                    yield ("entry-factor" if symbols else "constant-typed"), ""

    def _by_angle(self) -> Iterator[Slip]:
        """Yield a mistake if one angle is wrong by any constant c.

        Let w be a sine or cosine of the angle, and w' the same with pi/2 added. The wrong entry is
        A + B (w cos c + w' sin c), which is solved for c by least squares.
        """
        if size_of(self.reference) > LONGEST or self.right.shape[-1] < POINTS_FOR_CONSTANT:
            return
        without_trig = replace_each_wave(self.reference, lambda _: ZERO)[:MOST_WAVES]
        turned_trig = replace_each_wave(self.reference, turn_wave)[:MOST_WAVES]
        entry_values, *variants = _evaluate([self.reference, *without_trig, *turned_trig], self.values)
        for k, (constant_part, turned_values) in enumerate(
            zip(variants[: len(without_trig)], variants[len(without_trig) :], strict=True)
        ):
            coefficients = np.stack([entry_values - constant_part, turned_values - constant_part], axis=1)
            if not np.isfinite(coefficients).all():
                continue
            (c, s), *_ = np.linalg.lstsq(coefficients.real, (self.answer.values[0, 0] - constant_part).real, rcond=None)
            if abs(c * c + s * s - 1) > 1e-6:
                continue
            constant = Node("decimal", value=Fraction(float(np.arctan2(s, c))))
            shift = partial(_add_to_angle, constant)
            if self.answer.is_all(_evaluate([replace_each_wave(self.reference, shift)[k]], self.values)[None]):
                yield "angle-typed", ""
                return

    def _by_sign(self) -> Iterator[Slip]:
        """Yield a mistake if the absolute value is correct, but the sign is wrong at some configurations only."""
        values, reference = self.answer.values[0, 0].real, self.right.real
        is_same_size = replace(self.answer, values=np.abs(values)[None, None]).is_all(np.abs(reference)[None, None])
        if is_same_size and (values * reference > 0).any() and (values * reference < 0).any():
            yield "sign-lost", ""


def _add_to_angle(more: Node, wave: Node) -> Node:
    return Node("call", (plus(wave.args[0], more),), wave.value)


def _evaluate(entries: Sequence[Node], values: Values) -> np.ndarray:
    """Return the values of entries, (entries, N); nan if a value can't be computed."""
    return evaluate_each(entries, values, len(next(iter(values.values()))))


def _name(name: str, places: Sequence[Place], shape: tuple[int, ...], which: str = "") -> Diagnosis:
    where = in_words(places, shape)
    return Diagnosis((name,), CATALOGUE[name].sentence({"Where": where, "which": which}), known_by=(f"{name} {where}",))
