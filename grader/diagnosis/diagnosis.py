"""Name the mistake behind a wrong answer: the mistake of the catalogue that gives exactly this answer.

Answers are compared at random configurations, or at the configuration that the question gives. If no mistake of the
catalogue gives the whole answer, the errors are described entry by entry. If that isn't possible either, qdot doesn't
guess.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from qdot.exercises.short_questions.options import list_blames

from qdot.exercises.arm.derivation_graph import Working, numeric_working
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, ParseError, as_matrix, count_decimal_digits
from qdot.exercises.mistakes.catalogue import (
    CATALOGUE,
    EQUIVALENT_MISTAKES,
    PredictedAnswer,
    apply_mistake,
    predict_wrong_answers,
    variant_frequency,
)
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import parse_vector
from qdot.exercises.questions.results import compute_answer, is_derived, is_made_of_jacobian, is_product
from qdot.exercises.writing.problem_texts import answer_code
from qdot.grader.diagnosis.formula_mistakes import SURPLUS_BY_MISSING, ComparedFormulas, explain_formulas
from qdot.grader.diagnosis.numbers import RELATIVE_TOLERANCE, NumericAnswer, is_distinctive, normalize
from qdot.grader.diagnosis.residuals import explain_missing_links
from qdot.grader.diagnosis.rounding import explain_rounded_function, explain_rounding, is_correct
from qdot.grader.diagnosis.set_mistakes import explain_set, find_mistaken_answer, name_alternatives
from qdot.grader.judging.answer import FunctionValues, ParsedAnswer
from qdot.grader.judging.verdict import Diagnosis, locate_mistake

SAMPLE_COUNT = 16
THREE_DECIMALS_TOLERANCE = 6e-4
UNLIKELY_FREQUENCY = 0.2
"""If a mistake has a lower frequency, a single mistake in the finished formulas is likelier."""
LIKELY_FREQUENCY = 2.0
"""From this frequency, a mistake made throughout an answer is likelier than the wrong sign of a single entry."""
MAX_ENTRIES_OF_ONE_MISTAKE = 2
"""Maximum number of wrong entries that a single mistake in the finished formulas may cause."""
SURPLUS_MISTAKES = set(SURPLUS_BY_MISSING.values())
SIGN_MISTAKES = {"term-sign-typed", "entry-sign"}
EXCHANGE_MISTAKES = {"wave-throughout"}
"""The formula mistakes that are likelier than a rare mistake at several joints."""
LOCATION_WORDS = {"joint", "link", "one"}
"""The words in messages of mistakes that are made at one joint or entry.

Other mistakes change everything, and so hardly ever only the sign of a single entry."""
MAX_SET_LENGTH = 600
"""Maximum length (characters) of a set that is compared with the sets that mistakes give; comparing is slow."""


@dataclass(frozen=True)
class Cause:
    """A mistake that was found in an earlier part: its name and words, and the name and title of the part."""

    mistake: str
    words: Mapping[str, object]
    part: str
    part_title: str


def diagnose(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str = "", causes: Sequence[Cause] = ()
) -> Diagnosis | None:
    """Return the mistake that gives a wrong answer, or None if no mistake in the catalogue gives it.

    If it is one of the `causes`, which were found in earlier parts, the diagnosis says so. `seed` determines the
    configurations at which the answer is compared with the answers that mistakes give.

    >>> from qdot import generate
    >>> from qdot import read_answer
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> (part,) = problem.parts
    >>> diagnose(problem, part, read_answer(problem, part, "d2 + 0.7")).mistakes
    ('determinant-sign',)
    """
    if parsed_answer.table is None:
        option_mistakes = _explain_option(part, parsed_answer)
        if option_mistakes is not None:
            return option_mistakes
        is_short = len(parsed_answer.text) <= MAX_SET_LENGTH
        if part.answer.is_set:
            return explain_set(problem, part, parsed_answer, seed) if is_short else None
        mistake_of_whole_answer = find_mistaken_answer(problem, part, parsed_answer, seed) if is_short else None
        if mistake_of_whole_answer is not None:
            return mistake_of_whole_answer
    wrong_answer = _evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return None
    values, reference = wrong_answer.numeric, wrong_answer.correct_values
    if parsed_answer.table is None:
        rounding = explain_rounding(part, values, reference, parsed_answer.entries)
    else:
        rounding = explain_rounded_function(values, reference)
    if rounding or is_correct(
        values, reference
    ):  # with correct values, mistakes without effect on this arm would match
        return rounding
    return _explain_values(wrong_answer.in_expected_shape, causes)


def is_one_mistake(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Return whether a single known mistake explains all wrong entries of an answer in formulas or several numbers.

    Entries that the mistake would also change may be correct. Then no cause is named, but a better answer must not earn
    less. Only mistakes that are found quickly count, so that no mark depends on how long the search takes.
    """
    wrong_answer = _evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return False
    values, reference = wrong_answer.numeric, wrong_answer.correct_values
    if values.values.shape != reference.shape or is_correct(values, reference):
        return False
    is_wrong = ~values.match_entries(reference)
    is_filled = np.abs(values.values[is_wrong]).max(axis=-1) > RELATIVE_TOLERANCE  # many mistakes give zeros
    for predicted in (
        predict_wrong_answers(wrong_answer.correct_working, part, values.is_precise) if is_filled.any() else ()
    ):
        fits = predicted.answer.shape == reference.shape and (values.match_entries(predicted.answer) | ~is_wrong).all()
        if fits and is_distinctive(predicted.answer):
            return True
    if is_product(part) or not is_filled.all():  # the factors of a product are marked separately
        return False
    formula_diagnoses = (
        explain_missing_links(wrong_answer.correct_working, part, reference, values.values),
        _explain_formulas(wrong_answer),
    )
    return any(diagnosis is not None and diagnosis.is_single_mistake for diagnosis in formula_diagnoses)


# --- the numeric values of the answer ---


@dataclass(frozen=True)
class WrongAnswer:
    """A wrong answer with its values at some configurations, and its formulas as typed, if there are any."""

    problem: Problem
    part: Part
    values: SymbolValues
    numeric: NumericAnswer
    rows: Rows | None = None

    @cached_property
    def correct_working(self) -> Working:
        """The correct derivation, evaluated at the configurations."""
        return numeric_working(self.problem.chain, self.values)

    @cached_property
    def correct_values(self) -> np.ndarray:
        """The values of the correct answer, (rows, columns, N)."""
        return compute_answer(self.correct_working, self.part)

    @cached_property
    def is_differentiated(self) -> np.ndarray:
        """Whether each entry is found by differentiation, (rows, columns).

        Angular entries are not, and neither are results computed from a Jacobian.
        """
        if is_made_of_jacobian(self.part):
            return np.zeros(self.correct_values.shape[:2], bool)
        result_for_doubled_rows = compute_answer(
            self.correct_working.with_mistakes({"linear": lambda _, rows: 2 * rows}), self.part
        )
        return np.asarray(
            (
                np.abs(result_for_doubled_rows - self.correct_values) > RELATIVE_TOLERANCE * np.abs(self.correct_values)
            ).any(axis=-1)
        )

    @property
    def in_expected_shape(self) -> "WrongAnswer":
        """The same answer, transposed if a vector was typed as a row instead of a column, or vice versa."""
        shape, transposed_values = self.correct_values.shape, self.numeric.values.swapaxes(0, 1)
        if 1 not in shape[:2] or self.numeric.values.shape == shape or transposed_values.shape != shape:
            return self
        in_numbers = replace(self.numeric, values=transposed_values, term_size=self.numeric.term_size.swapaxes(0, 1))
        return replace(self, numeric=in_numbers, rows=None if self.rows is None else _transpose(self.rows))


def _evaluate_answer(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> WrongAnswer | None:
    """Evaluate an answer at configurations; return None if the part isn't derived or the answer has no values."""
    if not is_derived(part):
        return None
    if parsed_answer.table is not None:
        return _evaluate_function(problem, part, parsed_answer.table)
    values = sample_configurations(problem.chain, part, problem.domain(), SAMPLE_COUNT, Stream(f"{seed}/diagnosis"))
    try:
        if part.answer.offered_options:
            in_numbers = _parse_option(part, parsed_answer)
        else:
            in_numbers = _evaluate_entries(part, parsed_answer, values)
    except ParseError:  # an answer that was refused may have statements as entries
        return None
    return None if in_numbers is None else WrongAnswer(problem, part, values, in_numbers, parsed_answer.rows)


def _evaluate_function(problem: Problem, part: Part, table: FunctionValues) -> WrongAnswer | None:
    """Return a Python function as a wrong answer, with the values that it returned in the sandbox."""
    if table.shape is None or len(table.shape) > 2:
        return None
    values = {name: column[:SAMPLE_COUNT] for name, column in table.arguments.items()}
    rows = (*table.shape, *(1,) * (2 - len(table.shape)))
    outputs = table.values[:SAMPLE_COUNT].T.reshape(*rows, -1)
    if part.rounding:
        tolerances = (max(RELATIVE_TOLERANCE, part.rounding.relative), part.rounding.absolute)
    else:
        tolerances = (RELATIVE_TOLERANCE, 0.0)
    is_direction = part.answer.counts_up_to_a_factor
    return WrongAnswer(problem, part, values, NumericAnswer(outputs, np.abs(outputs), tolerances, is_direction))


def _evaluate_entries(part: Part, parsed_answer: ParsedAnswer, values: SymbolValues) -> NumericAnswer | None:
    entries, blanks = parsed_answer.entries, parsed_answer.blanks
    if parsed_answer.rows is None or all(blanks) or parsed_answer.symbols - set(values):
        return None
    filled = [Node("name", value="pi") if blank else entry for entry, blank in zip(entries, blanks, strict=True)]
    count = len(next(iter(values.values())))
    entry_values, term_size = evaluate(compile_program(filled), values, count)
    entry_values[blanks] = np.nan
    shape = (len(parsed_answer.rows), len(parsed_answer.rows[0]), count)
    is_direction = part.answer.counts_up_to_a_factor
    return NumericAnswer(entry_values.reshape(shape), term_size.reshape(shape), _tolerance(part, filled), is_direction)


def _tolerance(part: Part, entries: Sequence[Node]) -> tuple[float, float]:
    """Return the relative and the absolute tolerance for an answer.

    For numbers, it depends on the digits required, or on the digits typed if these are more.
    """
    relative, absolute = (0.0, 0.0) if part.rounding is None else (part.rounding.relative, part.rounding.absolute)
    if not part.answer.is_numeric:
        return max(RELATIVE_TOLERANCE, relative), absolute
    digits = max(map(count_decimal_digits, entries))
    return max(min(relative or 5e-3, 0.6 * 10.0 ** (1 - max(digits, 3))), 1e-5), 0.0


def _parse_option(part: Part, parsed_answer: ParsedAnswer) -> NumericAnswer | None:
    if not parsed_answer.chosen:
        return None
    values = np.array(parse_vector(part.answer.offered_options[parsed_answer.chosen[0]]))[:, None, None]
    return NumericAnswer(values, np.abs(values), (0.0, THREE_DECIMALS_TOLERANCE))


# --- the mistake behind it ---


def _explain_option(part: Part, parsed_answer: ParsedAnswer) -> Diagnosis | None:
    """Return the mistakes behind the first wrong option that was chosen, which were stored with the option."""
    for index in parsed_answer.chosen:
        blames = [] if index in part.answer.correct_indices else list_blames(part, index)
        if blames:
            sentences = dict.fromkeys(blame.sentence for blame in blames)
            return Diagnosis(tuple(dict.fromkeys(blame.mistake for blame in blames)), " ".join(sentences))
    return None


def _explain_values(answer: WrongAnswer, causes: Sequence[Cause]) -> Diagnosis | None:
    """Return the mistake that gives the values of an answer, or None.

    If several mistakes do, one that was found in an earlier part is named as the cause, otherwise the likeliest. If
    none does, the errors are described entry by entry, provided that each wrong entry has a single mistake.
    """
    in_numbers, reference, part = answer.numeric, answer.correct_values, answer.part
    if in_numbers.is_direction and _arm_can_move(reference, in_numbers.values):
        return Diagnosis(("direction-that-moves",), CATALOGUE["direction-that-moves"].sentence({}))
    fitting_predictions = []
    for predicted in predict_wrong_answers(answer.correct_working, part, in_numbers.is_precise):
        if _is_predicted(predicted, in_numbers):
            if cause := _find_cause(predicted, causes):
                return _name_inherited(predicted, cause)
            fitting_predictions.append(predicted)
            if not causes and variant_frequency(predicted) >= 1:
                break
    if fitting_predictions:
        return _name_likeliest(answer, fitting_predictions)
    if in_numbers.values.shape != reference.shape or in_numbers.is_direction:
        return None
    return (
        explain_missing_links(answer.correct_working, part, reference, in_numbers.values)
        or _explain_formulas(answer)
        or _explain_formulas(answer, allows_any_number=True)
    )


def _is_predicted(predicted: PredictedAnswer, numeric_answer: NumericAnswer) -> bool:
    return numeric_answer.equals(predicted.answer) and is_distinctive(predicted.answer)


def _arm_can_move(lost_direction: np.ndarray, direction: np.ndarray) -> bool:
    """Return whether the arm can move in a direction, because this has no component along the lost direction."""
    if lost_direction.shape != direction.shape or lost_direction.shape[1] != 1:
        return False
    with np.errstate(all="ignore"):
        component = np.abs((normalize(lost_direction) * normalize(direction)).sum(axis=0))
    return bool(np.isfinite(component).all() and (component < 1e-3).all())


def _find_cause(predicted: PredictedAnswer, causes: Sequence[Cause]) -> Cause | None:
    return next(
        (
            cause
            for cause in causes
            if (cause.mistake, cause.words) == (predicted.mistake.name, dict(predicted.variant.words))
        ),
        None,
    )


def _name_inherited(predicted: PredictedAnswer, cause: Cause) -> Diagnosis:
    """Return the diagnosis for a mistake that was already found in an earlier part."""
    message = f"This follows from what went wrong in {cause.part_title!r}: the same mistake gives this answer."
    signature = locate_mistake(predicted.mistake.name, predicted.variant.words)
    return Diagnosis((), message, inherited=cause.part, signature=(signature,))


def _name_likeliest(answer: WrongAnswer, predictions: Sequence[PredictedAnswer]) -> Diagnosis:
    """Return the most frequent of the fitting mistakes, or the first two if they are equally frequent.

    If a single mistake in the finished formulas is likelier, it is returned instead.
    """
    in_numbers, first = answer.numeric, max(predictions, key=variant_frequency)
    alike_names = list(EQUIVALENT_MISTAKES.get(first.mistake.name, ()))
    if in_numbers.is_direction and first.mistake.name == "row-sign":  # either one row or all the others
        alike_names.append("row-sign")
    alternatives = (
        wrong for name in alike_names for wrong in apply_mistake(CATALOGUE[name], answer.correct_working, answer.part)
    )
    candidates = [
        first,
        *(wrong for wrong in alternatives if _is_predicted(wrong, in_numbers) and wrong.sentence != first.sentence),
    ]
    highest = max(map(variant_frequency, candidates))
    if in_numbers.values.shape == answer.correct_values.shape:
        wrong_count = int((~in_numbers.match_entries(answer.correct_values)).sum())
    else:
        wrong_count = 0
    is_rare = highest < UNLIKELY_FREQUENCY and wrong_count <= MAX_ENTRIES_OF_ONE_MISTAKE
    is_throughout = wrong_count == 1 < in_numbers.values[..., 0].size and not LOCATION_WORDS & set(first.variant.words)
    is_at_several = first.mistake.rare and len(first.variant.joints) > 1
    is_less_likely = is_rare or is_at_several or (is_throughout and highest < LIKELY_FREQUENCY)
    single_mistake = (
        _explain_formulas(answer) if wrong_count and not in_numbers.is_direction and is_less_likely else None
    )
    if single_mistake is not None:
        is_likelier = is_rare and not SURPLUS_MISTAKES & set(single_mistake.mistakes)
        if is_likelier or set(single_mistake.mistakes) <= (EXCHANGE_MISTAKES if is_at_several else SIGN_MISTAKES):
            return single_mistake
    likeliest = [wrong for wrong in candidates if variant_frequency(wrong) == highest][:2]
    diagnosis = name_alternatives([(wrong.mistake, wrong.variant.words, _describe(wrong)) for wrong in likeliest])
    cause = (likeliest[0].mistake.name, dict(likeliest[0].variant.words)) if len(likeliest) == 1 else None
    return replace(diagnosis, cause=cause)


def _describe(predicted: PredictedAnswer) -> str:
    missing = predicted.variant.missing_symbols
    return f"{predicted.sentence} What is missing has {missing} in it." if missing else predicted.sentence


def _explain_formulas(answer: WrongAnswer, allows_any_number: bool = False) -> Diagnosis | None:
    """Return the mistake in the finished formulas, in the form of the worked solution or in the form compared.

    A mistake made everywhere in either form is preferred to mistakes in some of the entries.
    """
    diagnoses = []
    for form in _reference_forms(answer.problem, answer.part):
        shape = answer.correct_values.shape[:2]
        rows = form if (len(form), len(form[0])) == shape else _transpose(form)
        if (len(rows), len(rows[0])) == shape:
            formulas = ComparedFormulas(rows, answer.is_differentiated, answer.rows)
            diagnoses.append(
                explain_formulas(formulas, answer.values, answer.numeric, answer.correct_values, allows_any_number)
            )
    return min(
        filter(None, diagnoses), key=lambda each: (len(each.signature) > 0, not each.is_single_mistake), default=None
    )


def _transpose(rows: Rows) -> Rows:
    return [list(column) for column in zip(*rows, strict=True)]


def _reference_forms(problem: Problem, part: Part) -> Iterator[Rows]:
    """Yield the entries of the reference, first in the form of the worked solution, then in the form compared."""
    if not part.answer.is_numeric and part.answer.entries() and part.type != "number":
        roles = problem.domain().roles
        worked_form = as_matrix(parse_formula(answer_code(problem, part), roles))
        compared_form = part.answer.trees(roles)
        if worked_form is not None:
            yield worked_form
        if compared_form != worked_form:
            yield compared_form
