"""Find mistakes in the finished formulas of an answer: one mistake in each wrong entry, or one in all entries.

If only some entries are wrong, the diagnosis names them. `mistakes.formula_edits` defines the mistakes and makes
them in a formula; an edit is a formula with one mistake.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import islice, product
from typing import NamedTuple

import numpy as np

from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.algebra import expand_terms
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import (
    ONE,
    ZERO,
    Node,
    count_nodes,
    find_names,
    format_tree,
    iterate_nodes,
    replace_names,
)
from qdot.exercises.mistakes import formula_edits
from qdot.exercises.mistakes.base import join_words
from qdot.exercises.mistakes.catalogue import CATALOGUE
from qdot.exercises.mistakes.configurations import SymbolValues
from qdot.grader.diagnosis.evaluated_answer import EvaluatedAnswer
from qdot.grader.diagnosis.numbers import NumericAnswer, is_distinctive
from qdot.grader.diagnosis.term_comparison import TermComparison, evaluate_formulas
from qdot.grader.judging.verdict import Diagnosis

MAX_ENTRIES = 8
"""Maximum number of wrong entries of an answer that is searched entry by entry."""
MAX_EVALUATED_NODES = 40_000
"""Maximum number of nodes of all the edited formulas that are evaluated for an answer."""

MAX_EDITS = 600
"""Maximum number of edits that are tried in an entry."""
MAX_TRIGS = 24
"""Maximum number of sines and cosines of an entry that are tried with a constant added to their angles."""
MIN_SAMPLES_FOR_CONSTANT = 4
"""Minimum number of configurations from which a constant is determined."""

MAX_REPLACEMENTS, REPLACEMENT_SAMPLE_COUNT = 300, 3
"""Maximum number of ways to replace an answer's lengths by the arm's, and number of configurations for each way."""

OWN_TABLE_HINT = "Use the lengths in the table of your own arm. See (6.1)."
SURPLUS_BY_MISSING = {"term-missing": "term-surplus", "factor-missing": "factor-surplus"}
"""Maps each mistake that omits a term or factor to its opposite.

If omitting a term or factor from the answer gives the reference, that term or factor was surplus.
"""

MISTAKES_IN_NUMBERS: tuple[Collection[str], ...] = (
    ("entry-halved", "entry-doubled"), ("term-sign-typed", "term-missing", "trig-typed", "symbol-typed"), CATALOGUE,
)  # fmt: skip
"""Groups of mistakes, tried in turn until one explains the number. In their names, `-typed` means typed wrongly."""
MAX_CHANCE = 0.05
"""Maximum probability that a mistake of a group gives a number by chance; if it is larger, the group is skipped."""

EntryIndex = tuple[int, int]
"""The row and the column of an entry, from 0."""


def explain_formulas(answer: EvaluatedAnswer, reference: Rows, tries_any_number: bool = False) -> Diagnosis | None:
    """Return the mistake in the finished formulas of an answer; `reference` has the formulas of the correct answer.

    The search looks for one mistake in each wrong entry. If `tries_any_number`, a number or an angle may also be wrong
    by any amount, unless the answer consists of numbers. Blanks don't count as wrong.
    """
    if not answer.has_expected_shape:
        return None
    if answer.part.answer.is_numeric:
        answer, tries_any_number = replace(answer, rows=None), False  # a typed number is not a formula
    wrong_entries = answer.list_wrong_entries()
    if not wrong_entries:
        return None
    if number_for_symbol := _find_number_for_symbol(answer, reference):
        return number_for_symbol
    entry_count = answer.correct_values[..., 0].size
    only_one_entry_is_wrong = len(wrong_entries) == 1 and entry_count > 1
    if not only_one_entry_is_wrong:
        diagnosis = (
            find_exchange(answer)
            or (_find_mistake_everywhere(answer, reference) if answer.is_precise else None)
            or _find_other_lengths(answer, reference)
        )
        if diagnosis is not None or len(wrong_entries) > MAX_ENTRIES:
            return diagnosis
    return _find_mistakes_in_entries(answer, reference, wrong_entries, tries_any_number)


def describe_terms(comparison: TermComparison, shape: tuple[int, ...]) -> Diagnosis | None:
    """Return the diagnosis of the terms in which an answer differs from the reference.

    `shape` is the shape of the answer. Returns None if the terms with a wrong number have no symbol in common.
    """
    columns = shape[1] if len(shape) > 1 else 1
    entries = list(dict.fromkeys(divmod(index, columns) for index, _ in comparison.differences))
    terms = comparison.terms
    if comparison.has_wrong_number:
        names = sorted(set.intersection(*(find_names(term.node) for term in terms)))
        return _make_diagnosis("number-typed", entries, shape, f" (with {join_words(names)})") if names else None
    is_single = len(terms) == 1
    mistakes = ["trig-typed" if is_single else "trigs-in-terms"] if comparison.has_exchanged_trigs else []
    if comparison.has_wrong_signs:
        is_single_sign = sum(term.has_wrong_sign for term in terms) == 1
        mistakes.append("term-sign-typed" if is_single_sign else "term-signs")
    return _join_diagnoses([_make_diagnosis(name, entries, shape) for name in mistakes])


def _join_diagnoses(diagnoses: Sequence[Diagnosis]) -> Diagnosis:
    """Return one diagnosis that names all mistakes.

    If there are several, "The rest is right." is left out of each message.
    """
    names = dict.fromkeys(name for diagnosis in diagnoses for name in diagnosis.mistakes)
    feedback = " ".join(diagnosis.feedback for diagnosis in diagnoses)
    if len(diagnoses) > 1:
        feedback = feedback.replace(" The rest is right.", "")
    signature = tuple(name for diagnosis in diagnoses for name in diagnosis.signature)
    return Diagnosis(tuple(names), feedback, signature=signature)


MAX_NAMED_ENTRIES = 3
"""Maximum number of entries that a message names one by one."""


def locate_entries(entry_indices: Sequence[EntryIndex], shape: tuple[int, ...]) -> str:
    """Return the positions of entries in words, as the beginning of a sentence about each of them.

    >>> locate_entries([(0, 1), (1, 1)], (2, 2))
    'In each of the entries (1, 2) and (2, 2),'
    >>> locate_entries([(1, 0)], (3, 1)), locate_entries([(0, 0)], (1, 1))
    ('In entry 2,', 'In your answer,')
    """
    if shape[:2] == (1, 1):
        return "In your answer,"
    if len(entry_indices) > MAX_NAMED_ENTRIES:
        return f"In each of {len(entry_indices)} entries, such as {name_entries(entry_indices[:1], shape)},"
    names = name_entries(entry_indices, shape)
    return f"In each of the {names}," if len(entry_indices) > 1 else f"In {names},"


def name_entries(entry_indices: Sequence[EntryIndex], shape: tuple[int, ...]) -> str:
    """Return the names of entries: their rows and columns, or their numbers if the answer has one row or column.

    >>> name_entries([(0, 1), (1, 1)], (2, 2)), name_entries([(1, 0)], (3, 1))
    ('entries (1, 2) and (2, 2)', 'entry 2')
    """
    is_vector = 1 in shape[:2]
    numbers = [str(max(i, j) + 1) if is_vector else f"({i + 1}, {j + 1})" for i, j in entry_indices]
    return f"{'entries' if len(numbers) > 1 else 'entry'} {join_words(numbers)}"


def _identify_entries(entry_indices: Sequence[EntryIndex], shape: tuple[int, ...]) -> str:
    """Return the positions of entries for the signature of a diagnosis.

    The keys of groups in overrides.csv depend on these texts, so they must not change.
    """
    if shape[:2] == (1, 1):
        return "In your answer"
    if 1 in shape[:2]:
        *other_entries, last_entry = [str(max(index) + 1) for index in entry_indices]
        return f"In entries {', '.join(other_entries)} and {last_entry}" if other_entries else f"In entry {last_entry}"
    *other_entries, last_entry = [f"row {i + 1}, column {j + 1}" for i, j in entry_indices]
    return f"In {', '.join(other_entries)}, and {last_entry}," if other_entries else f"In {last_entry},"


def find_exchange(answer: EvaluatedAnswer) -> Diagnosis | None:
    """Return the diagnosis that the only two wrong entries were exchanged, or None."""
    entry_indices = answer.list_wrong_entries()
    if len(entry_indices) != 2:
        return None
    exchanged_values = answer.correct_values.copy()
    for index, other_index in (entry_indices, entry_indices[::-1]):
        exchanged_values[index] = answer.correct_values[other_index]
    if answer.numeric.equals(exchanged_values):
        return _make_diagnosis("entries-exchanged", entry_indices, exchanged_values.shape)
    return None


def _find_mistake_everywhere(answer: EvaluatedAnswer, reference: Rows) -> Diagnosis | None:
    """Return the mistake that, made everywhere in the reference, gives the answer; None if there is none.

    If the formulas are long, fewer mistakes are tried.
    """
    size = sum(count_nodes(entry) for row in reference for entry in row)
    for name, edited_rows in islice(formula_edits.edit_all_entries(reference), MAX_EVALUATED_NODES // max(size, 1)):
        entries = [entry for row in edited_rows for entry in row]
        predicted_values = evaluate_formulas(entries, answer.symbol_values).reshape(answer.correct_values.shape)
        if answer.numeric.equals(predicted_values) and is_distinctive(predicted_values):
            return Diagnosis((name,), CATALOGUE[name].format_message({"Where": "In your answer,"}))
    return None


def _find_number_for_symbol(answer: EvaluatedAnswer, reference: Rows) -> Diagnosis | None:
    """Return the diagnosis that an answer is right except for a number in place of a symbol such as g, or None.

    A number in the place of a length may be a length of another student's arm.
    """
    typed_entries = [entry for row in answer.rows or [] for entry in row]
    entries = [entry for row in reference for entry in row]
    missing_names = set().union(*map(find_names, entries)) - set().union(*map(find_names, typed_entries))
    numbers = {node for entry in typed_entries for node in iterate_nodes(entry) if node.kind in ("number", "decimal")}
    if sum(map(count_nodes, entries)) * len(missing_names) * len(numbers) > MAX_EVALUATED_NODES:
        return None
    symbols = [name for name in sorted(missing_names) if not formula_edits.is_length(name)]
    for name, number in product(symbols, sorted(numbers, key=format_tree)):
        symbol = Node("name", value=name)
        new_entries = [formula_edits.replace_nodes(entry, {symbol: number}.get) for entry in entries]
        values = evaluate_formulas(new_entries, answer.symbol_values).reshape(answer.correct_values.shape)
        if answer.numeric.equals(values) and is_distinctive(values):
            # A 1 in place of the symbol means that the symbol was left out.
            if evaluate(compile_program([number]), {}, 1).values == 1:
                words = {"Where": "In your answer,", "which": f" (with {name})"}
                return Diagnosis(("factor-missing",), CATALOGUE["factor-missing"].format_message(words))
            return Diagnosis(("number-for-symbol",), CATALOGUE["number-for-symbol"].format_message({"symbol": name}))
    return None


def _find_other_lengths(answer: EvaluatedAnswer, reference: Rows) -> Diagnosis | None:
    """Return the diagnosis that an answer would be correct for an arm with other lengths, or None.

    The answer must have lengths that are not the arm's in at least two places. The answer's lengths are replaced by the
    arm's lengths in every possible way. This is not a mistake of the catalogue and earns no partial credit, because the
    arm may be another student's.
    """
    entries = [entry for row in answer.rows or [] for entry in row]
    if sum(map(count_nodes, entries)) > formula_edits.MAX_ENTRY_NODES:
        return None
    typed_lengths = [leaf for entry in entries for leaf in _find_lengths(entry)]
    arm_lengths = list(dict.fromkeys(leaf for row in reference for entry in row for leaf in _find_lengths(entry)))
    replaceable_lengths = list(dict.fromkeys(typed_lengths))
    other_lengths = [leaf for leaf in replaceable_lengths if leaf not in arm_lengths]
    if len(arm_lengths) ** len(replaceable_lengths) > MAX_REPLACEMENTS:
        replaceable_lengths = other_lengths  # too many combinations: keep the answer's lengths that are the arm's own
    count = len(arm_lengths) ** len(replaceable_lengths)
    if sum(map(typed_lengths.count, other_lengths)) < 2 or not 0 < count <= MAX_REPLACEMENTS:
        return None
    sampled_values = {name: value[:REPLACEMENT_SAMPLE_COUNT] for name, value in answer.symbol_values.items()}
    combinations = product(arm_lengths, repeat=len(replaceable_lengths))
    replacements = [dict(zip(replaceable_lengths, combination, strict=True)) for combination in combinations]
    new_entries = [
        formula_edits.replace_nodes(entry, replacement.get) for replacement in replacements for entry in entries
    ]
    answers = evaluate_formulas(new_entries, sampled_values).reshape(count, *answer.correct_values.shape[:2], -1)
    first_samples = (..., slice(REPLACEMENT_SAMPLE_COUNT))
    expected_values, size = answer.correct_values[first_samples], answer.numeric.term_size[first_samples]
    if not any(NumericAnswer(values, size, answer.numeric.tolerances).equals(expected_values) for values in answers):
        return None
    words = join_words([*map(format_tree, other_lengths)])
    return Diagnosis((), f"Your answer is correct for an arm with other lengths ({words}). {OWN_TABLE_HINT}")


def _find_lengths(node: Node) -> Iterator[Node]:
    """Yield the lengths in a formula: their names, and all decimals, because a decimal may be a typed length."""
    if node.kind == "decimal" or (node.kind == "name" and formula_edits.is_length(node.value)):
        yield node
    for arg in node.args:
        yield from _find_lengths(arg)


def _find_mistakes_in_entries(
    answer: EvaluatedAnswer, reference: Rows, wrong_entries: Sequence[EntryIndex], tries_any_number: bool
) -> Diagnosis | None:
    """Return the mistakes that were made in the wrong entries.

    A mistake that explains all wrong entries is preferred. Returns None if an entry has no explanation, or if there are
    more than two kinds of mistakes.
    """
    entry_count = answer.correct_values[..., 0].size
    is_partly_right = entry_count != len(wrong_entries)
    mistakes_by_entry: dict[EntryIndex, list[EntryMistake]] = {}
    for i, j in wrong_entries:
        typed_formula = answer.rows[i][j] if answer.rows else None
        is_derivative = bool(answer.is_differentiated[i, j])
        numeric, correct_values = answer.numeric.select_entry(i, j), answer.correct_values[i, j]
        entry = _WrongEntry(
            reference[i][j], typed_formula, is_derivative, answer.symbol_values, numeric, correct_values
        )
        mistakes_by_entry[i, j] = entry.find_mistakes(is_partly_right, entry_count, tries_any_number)
        if not mistakes_by_entry[i, j]:
            return None
    name_sets = [{name for name, _ in mistakes} for mistakes in mistakes_by_entry.values()]
    common_names = set.intersection(*name_sets)
    common_name = next((name for name, _ in mistakes_by_entry[wrong_entries[0]] if name in common_names), None)
    entries_by_mistake: dict[EntryMistake, list[EntryIndex]] = {}
    for entry_index, entry_mistakes in mistakes_by_entry.items():
        likeliest_mistake = next(mistake for mistake in entry_mistakes if common_name in (None, mistake.name))
        entries_by_mistake.setdefault(likeliest_mistake, []).append(entry_index)
    if len({name for name, _ in entries_by_mistake}) > 2:
        return None
    diagnoses = [
        _make_diagnosis(name, entry_indices, answer.correct_values.shape, term_words)
        for (name, term_words), entry_indices in entries_by_mistake.items()
    ]
    return _join_diagnoses(diagnoses)


class EntryMistake(NamedTuple):
    """The name of a mistake in an entry, and words that identify the term or factor that it concerns, if any."""

    name: str
    term_words: str = ""


@dataclass(frozen=True)
class _WrongEntry:
    """One wrong entry of an answer, with the formulas and the values of the answer and of the reference.

    `is_derivative` is whether the entry is found by differentiation. `symbol_values` has the values of all symbols.
    """

    reference: Node
    typed_formula: Node | None
    is_derivative: bool
    symbol_values: SymbolValues
    answer: NumericAnswer
    correct_values: np.ndarray

    def find_mistakes(self, is_partly_right: bool, entry_count: int, tries_any_number: bool) -> list[EntryMistake]:
        """Return the mistakes that give the entry, the likelier mistakes first.

        A constant entry identifies a mistake only if other entries of the answer are correct. If the constant is not
        zero, the answer must also have more than three entries (`entry_count`).
        """
        is_informative, is_zero = is_distinctive(self.answer.values), not self.answer.values.any()
        if not (is_informative or (is_partly_right and (is_zero or entry_count > 3))):
            return []
        if is_zero:
            words = formula_edits.describe_term(self.reference)
            has_one_term = bool(expand_terms(self.reference, 1))
            return [EntryMistake("term-missing", words) if has_one_term else EntryMistake("entry-missing")]
        mistakes = list(dict.fromkeys((*self._find_edits(), *self._find_surplus(), *self._find_lost_sign())))
        if mistakes or not (is_informative and tries_any_number):
            return mistakes
        return list(self._find_wrong_number()) or list(self._find_wrong_angle())

    @property
    def _has_one_configuration(self) -> bool:
        """Whether values at only one configuration are compared, because the answer is a number."""
        return self.correct_values.shape[-1] == 1

    def _find_edits(self) -> Iterator[EntryMistake]:
        """Yield the mistakes that give the entry when they are made in the reference."""
        searches = (self._list_fitting_edits(self.reference, self.answer, names) for names in MISTAKES_IN_NUMBERS)
        edits = (
            next(filter(None, searches), [])
            if self._has_one_configuration
            else self._list_fitting_edits(self.reference, self.answer)
        )
        for edit in edits:
            yield EntryMistake(edit.mistake, edit.term_words)

    def _find_surplus(self) -> Iterator[EntryMistake]:
        """Yield a mistake if the entry without a term or factor, or without some symbols, equals the reference."""
        if self.typed_formula is None:
            return
        correct_answer = replace(self.answer, values=self.correct_values[None, None])
        for edit in self._list_fitting_edits(self.typed_formula, correct_answer, SURPLUS_BY_MISSING):
            yield EntryMistake(SURPLUS_BY_MISSING[edit.mistake], edit.term_words)
        if correct_answer.equals(np.zeros_like(correct_answer.values)):
            words = formula_edits.describe_term(self.typed_formula)
            yield EntryMistake("term-surplus", words)
        surplus_names = sorted(find_names(self.typed_formula) - find_names(self.reference))
        formula = replace_names(self.typed_formula, dict.fromkeys(surplus_names, ZERO))
        if surplus_names and correct_answer.equals(evaluate_formulas([formula], self.symbol_values)[None]):
            yield EntryMistake("term-surplus", f" (with {join_words(surplus_names)})")

    def _list_fitting_edits(
        self, formula: Node, target: NumericAnswer, allowed_mistakes: Collection[str] = CATALOGUE
    ) -> list[formula_edits.Edit]:
        """Return the edits of a formula that give the target, considering only some mistakes."""
        impossible_mistakes = frozenset[str]() if self.is_derivative else formula_edits.DERIVATIVE_MISTAKES
        possible_mistakes = set(allowed_mistakes) - impossible_mistakes
        edits = (
            edit for edit in formula_edits.edit_entry(formula, self.symbol_values) if edit.mistake in possible_mistakes
        )
        candidates = list(islice(edits, MAX_EDITS))
        if not candidates:
            return []
        answers = evaluate_formulas([edit.entry for edit in candidates], self.symbol_values)
        prediction_count = len(set(answers[:, 0].real.round(12))) if self._has_one_configuration else 0
        # Each prediction matches all numbers in an interval; its relative width is twice the tolerance.
        if 2 * target.tolerances.relative * prediction_count > MAX_CHANCE:
            return []
        return [candidates[k] for k in np.flatnonzero(target.match_entries(answers[:, None, None]))]

    def _find_wrong_number(self) -> Iterator[EntryMistake]:
        """Yield a mistake if a term or the entry is multiplied by some number, or if some number is added."""
        is_short = count_nodes(self.reference) <= formula_edits.MAX_ENTRY_NODES
        terms = (expand_terms(self.reference, formula_edits.MAX_TERMS) if is_short else None) or []
        # A wrong factor of a part changes the entry by a multiple of the part; an added number is a multiple of 1.
        parts = [*terms, ONE, *([self.reference] if len(terms) > 1 else [])]
        difference = self.answer.values[0, 0] - self.correct_values
        for part, values in zip(parts, evaluate_formulas(parts, self.symbol_values), strict=True):
            with np.errstate(all="ignore"):
                ratio = difference / values
            if np.isfinite(ratio).all() and np.ptp(ratio.real) <= 1e-6 * np.abs(ratio).max():
                symbols = sorted(find_names(part))
                if part in terms and symbols:
                    yield EntryMistake("number-typed", f" (with {join_words(symbols)})")
                else:
                    yield EntryMistake("entry-factor" if symbols else "constant-typed")

    def _find_wrong_angle(self) -> Iterator[EntryMistake]:
        """Yield a mistake if one angle is wrong by some constant c.

        Let w be the sine or cosine of the angle, and w' the same function of the angle plus pi/2. The wrong entry is
        A + B (w cos c + w' sin c). A, which is the reference without w, and B don't depend on c. This equation is
        solved for c by least squares.
        """
        has_few_samples = self.correct_values.shape[-1] < MIN_SAMPLES_FOR_CONSTANT
        if has_few_samples or count_nodes(self.reference) > formula_edits.MAX_ENTRY_NODES:
            return
        parts_without_trig = formula_edits.replace_each_trig(self.reference, lambda _: ZERO)[:MAX_TRIGS]
        shifted_formulas = formula_edits.replace_each_trig(self.reference, formula_edits.add_quarter_turn)[:MAX_TRIGS]
        (entry_values,) = evaluate_formulas([self.reference], self.symbol_values)
        values_without_trig = evaluate_formulas(parts_without_trig, self.symbol_values)
        values_with_shift = evaluate_formulas(shifted_formulas, self.symbol_values)
        for k, (rest_values, shifted_values) in enumerate(zip(values_without_trig, values_with_shift, strict=True)):
            coefficients = np.stack([entry_values - rest_values, shifted_values - rest_values], axis=1)
            if not np.isfinite(coefficients).all():
                continue
            remainder = self.answer.values[0, 0] - rest_values
            (cos_c, sin_c), *_ = np.linalg.lstsq(coefficients.real, remainder.real, rcond=None)
            if abs(cos_c**2 + sin_c**2 - 1) > 1e-6:
                continue
            constant = Node("decimal", value=Fraction(float(np.arctan2(sin_c, cos_c))))
            formulas = formula_edits.replace_each_trig(self.reference, partial(_add_to_angle, constant))
            if self.answer.equals(evaluate_formulas([formulas[k]], self.symbol_values)[None]):
                yield EntryMistake("angle-typed")
                return

    def _find_lost_sign(self) -> Iterator[EntryMistake]:
        """Yield a mistake if the absolute value is correct, but the sign is wrong at some configurations only."""
        values, reference = self.answer.values[0, 0].real, self.correct_values.real
        is_same_size = replace(self.answer, values=np.abs(values)[None, None]).equals(np.abs(reference)[None, None])
        if is_same_size and (values * reference > 0).any() and (values * reference < 0).any():
            yield EntryMistake("sign-lost")


def _add_to_angle(term: Node, trig: Node) -> Node:
    return Node("call", (trig.args[0] + term,), trig.value)


def _make_diagnosis(
    name: str, entry_indices: Sequence[EntryIndex], shape: tuple[int, ...], term_words: str = ""
) -> Diagnosis:
    """Return the diagnosis that names a mistake and the entries in which it was made."""
    location = locate_entries(entry_indices, shape)
    words = {"Where": location, "which": term_words, "entries": name_entries(entry_indices, shape)}
    message = CATALOGUE[name].format_message(words)
    return Diagnosis((name,), message, signature=(f"{name} {_identify_entries(entry_indices, shape)}",))
