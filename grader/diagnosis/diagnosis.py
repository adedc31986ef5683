"""Name the mistake behind a wrong answer: the mistake of the catalogue that gives exactly this answer.

Answers are compared at random configurations, or at the configuration that the question gives. If no mistake of the
catalogue gives the whole answer, the errors are described entry by entry. If that isn't possible either, no mistake is
named.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import as_matrix
from qdot.exercises.formula.units import find_units
from qdot.exercises.mistakes.catalogue import (
    CATALOGUE,
    FORMULA_VARIANTS,
    LIKELIEST_IN_OWN_QUESTIONS,
    SIGN_MISTAKES_AT_ONE_PLACE,
    SIGN_MISTAKES_THROUGHOUT,
    PredictedAnswer,
    apply_mistake,
    generate_mistaken_answers,
    predict_wrong_answers,
)
from qdot.exercises.mistakes.question_formulas import find_formula
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.custom.question import CustomDetails, derive_formulas_of_numbers
from qdot.exercises.questions.quantities import is_quantity
from qdot.exercises.questions.results import is_made_of_jacobian, is_product
from qdot.exercises.short_questions import question_of
from qdot.exercises.short_questions.option_mistakes import explain_options
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.diagnosis.evaluated_answer import EvaluatedAnswer, evaluate_answer, transpose
from qdot.grader.diagnosis.formula_mistakes import (
    SURPLUS_BY_MISSING,
    describe_terms,
    explain_formulas,
    find_exchange,
)
from qdot.grader.diagnosis.numbers import RELATIVE_TOLERANCE, NumericAnswer, is_distinctive, normalize
from qdot.grader.diagnosis.residuals import explain_missing_links
from qdot.grader.diagnosis.rounding import explain_rounded_function, explain_rounding
from qdot.grader.diagnosis.set_mistakes import explain_set, find_mistake_by_judging, name_alternatives
from qdot.grader.diagnosis.term_comparison import TermComparison, compare_terms
from qdot.grader.judging.answer_parser import ParsedAnswer
from qdot.grader.judging.verdict import Diagnosis, locate_mistake

UNLIKELY_FREQUENCY = 0.2
"""A mistake with a lower `Mistake.frequency` is less likely than a single mistake in the finished formulas."""
LIKELY_FREQUENCY = 2.0
"""A mistake of at least this frequency, made throughout an answer, is likelier than a wrong sign of a single entry."""
MAX_ENTRIES_OF_ONE_MISTAKE = 2
"""Maximum number of wrong entries that a single mistake in the finished formulas may cause."""
SURPLUS_MISTAKES = set(SURPLUS_BY_MISSING.values())
"""The formula mistakes in which a term or a factor is surplus."""
SIGN_MISTAKES = {"term-sign-typed", "entry-sign"}
"""The formula mistakes that are likelier than a mistake that is usually made throughout an answer."""
EXCHANGE_MISTAKES = {"trig-throughout"}
"""The formula mistakes that are likelier than a rare mistake at several joints."""
LOCATION_WORDS = {"joint", "link", "one"}
"""The names of those values in a message that locate the mistake at one joint or entry.

A mistake without a location changes the whole answer, and hardly ever only the sign of a single entry."""
LAST_STEP_MISTAKES = {
    "all-sines-for-cosines", "entry-doubled", "entry-factor", "entry-halved", "entry-sign", "factor-missing",
    "number-typed", "relative-rates",
    "term-missing", "term-sign-typed", "term-signs", "trig-throughout", "trig-typed", "trigs-in-terms",
}  # fmt: skip
"""The mistakes in the last steps that are likelier than a mistake in the arm's derivation.

This holds if an instructor's question asks for more than a quantity of the arm."""
LAST_STEP_MISTAKES_IN_QUANTITIES = {"relative-rates"}
"""The mistakes in the last steps that are likelier even if an instructor's question asks for a quantity of the arm."""
UNIT_MISTAKES = {"centimetres", "millimetres", "thousandth"}
"""The mistakes in the unit of lengths. A unit that the student typed, as in 2.3 N mm, explains the numbers better."""
WRONG_UNIT_ADVICE = "Your number would be right in another unit. Check the unit that you typed."
MAX_SET_LENGTH = 600
"""Maximum length (characters) of a set that is compared with the sets that mistakes give; comparing is slow."""


@dataclass(frozen=True)
class EarlierMistake:
    """A mistake that was found in an earlier part: its name, the values in its message, the part's name and title."""

    mistake: str
    words: Mapping[str, object]
    part: str
    part_title: str


def diagnose(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str = "",
    earlier_mistakes: Sequence[EarlierMistake] = (),
) -> Diagnosis | None:  # fmt: skip
    """Return the known mistake that explains a wrong answer, or None if no mistake in the catalogue does.

    If the mistake is one of the `earlier_mistakes`, which were found in earlier parts, the diagnosis names the earlier
    part. `seed` determines the configurations at which the answer is compared with answers that known mistakes give.

    >>> from qdot import generate
    >>> from qdot import read_answer
    >>> problem = generate("polar-rp/1", ["determinant"])
    >>> (part,) = problem.parts
    >>> diagnose(problem, part, read_answer(problem, part, "d2 + 0.7")).mistakes
    ('determinant-sign',)
    """
    diagnosis = _find_mistake(problem, part, parsed_answer, seed, earlier_mistakes)
    chapter_reference = _refer_to_chapter(question_of(part).source)
    if diagnosis is None or not diagnosis.mistakes or not chapter_reference:
        return diagnosis
    if any(CATALOGUE[name].source for name in diagnosis.mistakes):  # the message refers to the chapter already
        return diagnosis
    return replace(diagnosis, feedback=f"{diagnosis.feedback} See {chapter_reference}.")


def _refer_to_chapter(source: str) -> str:
    """Return the source of a question as a reference to the chapter; "" for a source that an instructor has worded.

    >>> _refer_to_chapter("6.8 for m < n"), _refer_to_chapter("below 6.10"), _refer_to_chapter("appendix")
    ('(6.8)', 'the text below (6.10)', 'the appendix')
    >>> _refer_to_chapter("dual of 6.4")
    '(6.4), whose transpose relates forces to joint torques'
    """
    match = re.match(r"(below |dual of |)(6\.\d+(?: and 6\.\d+)?)", source)
    if match is None:
        return f"the {source}" if source in ("appendix", "product of exponentials") else ""
    if match[1] == "dual of ":
        return f"({match[2]}), whose transpose relates forces to joint torques"
    return ("the text below " if match[1] else "") + f"({match[2]})"


def _find_mistake(
    problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str, earlier_mistakes: Sequence[EarlierMistake]
) -> Diagnosis | None:
    """Return the diagnosis of a wrong answer, without a reference to the source of the question."""
    if parsed_answer.table is None:
        if part.answer.offered_options:
            return _explain_option(problem, part, parsed_answer, seed)
        is_short = len(parsed_answer.text) <= MAX_SET_LENGTH
        if part.answer.is_set:
            return explain_set(problem, part, parsed_answer, seed) if is_short else None
        mistaken_answers = generate_mistaken_answers(problem.chain, part) if is_short else ()
        mistake_of_whole_answer = find_mistake_by_judging(problem, part, parsed_answer, seed, mistaken_answers)
        if mistake_of_whole_answer is not None:
            return mistake_of_whole_answer
    wrong_answer = evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return None
    if parsed_answer.table is None:
        rounding = explain_rounding(wrong_answer, parsed_answer.entries)
    else:
        rounding = explain_rounded_function(wrong_answer)
    if rounding or wrong_answer.is_correct:  # with correct values, mistakes without effect on this arm would match
        return rounding
    diagnosis = _explain_values(wrong_answer.transpose_vector_if_needed(), earlier_mistakes)
    if diagnosis is not None and UNIT_MISTAKES.issuperset(diagnosis.mistakes) and diagnosis.mistakes:
        has_scaled_unit = any(unit.size != 1 for unit in find_units(parsed_answer.text))
        return Diagnosis((), WRONG_UNIT_ADVICE) if has_scaled_unit else diagnosis
    return diagnosis


def is_one_mistake(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Return whether a single known mistake explains all wrong entries of an answer in formulas or several numbers.

    The answer may be correct in entries that the mistake would also change. No mistake is named for such an answer, but
    the function returns True, because a better answer must not earn less. Only mistakes that are found quickly count,
    so that no mark depends on the duration of the search.
    """
    wrong_answer = evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return False
    numeric, correct_values = wrong_answer.numeric, wrong_answer.correct_values
    if not wrong_answer.has_expected_shape or wrong_answer.is_correct:
        return False
    is_wrong = ~numeric.match_entries(correct_values)
    is_nonzero = np.abs(numeric.values[is_wrong]).max(axis=-1) > RELATIVE_TOLERANCE  # many mistakes give zeros
    if is_nonzero.any():
        for prediction in predict_wrong_answers(wrong_answer.correct_stages, part, numeric.is_precise):
            values = prediction.answer
            fits = values.shape == correct_values.shape and (numeric.match_entries(values) | ~is_wrong).all()
            if fits and is_distinctive(values):
                return True
    # The factors of a product are marked separately, and many mistakes give zeros.
    if is_product(part) or not is_nonzero.all():
        return False
    diagnoses = (explain_missing_links(wrong_answer), _explain_formulas(wrong_answer, tries_any_number=True))
    return any(diagnosis is not None and diagnosis.is_single_mistake for diagnosis in diagnoses)


def compare_wrong_terms(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> TermComparison | None:
    """Return how the terms of an answer in formulas differ from the expected terms.

    Returns None if some terms don't match, or if two entries were exchanged.
    """
    wrong_answer = evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None or not part.answer.is_symbolic or part.answer.is_direction:
        return None
    has_exchanged_entries = wrong_answer.has_expected_shape and find_exchange(wrong_answer) is not None
    return None if has_exchanged_entries else _compare_terms(wrong_answer)


def _compare_terms(answer: EvaluatedAnswer) -> TermComparison | None:
    """Compare the terms with each form of the correct answer (`_list_correct_forms`); return the closest comparison.

    Return None if the terms can't be compared.
    """
    if answer.rows is None or not answer.has_expected_shape or answer.numeric.is_direction:
        return None
    wrong_indices = np.flatnonzero(~answer.numeric.match_entries(answer.correct_values)).tolist()
    entries, shape = [entry for row in answer.rows for entry in row], answer.correct_values.shape[:2]
    if any(entry.kind == "blank" for entry in entries):
        return None
    comparisons = [
        compare_terms(entries, [entry for row in form for entry in row], wrong_indices, answer.symbol_values)
        for form in _list_correct_forms(answer)
        if _find_shape(form) == shape
    ]
    # Wrong signs are the smallest difference, and a wrong number is the largest.
    return min(
        filter(None, comparisons),
        key=lambda comparison: (comparison.has_wrong_number, comparison.has_exchanged_trigs),
        default=None,
    )


# --- the mistake behind an answer ---


def _explain_option(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> Diagnosis | None:
    """Return the mistakes behind the first wrong option that was chosen, or that was assigned to a wrong item."""
    correct_indices, indices = part.answer.correct_indices, parsed_answer.chosen_indices
    if part.answer.matched_items:
        wrong_indices = [index for index, expected in zip(indices, correct_indices, strict=False) if index != expected]
    else:
        wrong_indices = [index for index in indices if index not in correct_indices]
    blames_by_option = explain_options(problem, part, Stream(f"{seed}/options")) if wrong_indices else []
    for blames in (blames_by_option[index] for index in wrong_indices):
        if blames:
            sentences = dict.fromkeys(blame.sentence for blame in blames)
            return Diagnosis(tuple(dict.fromkeys(blame.mistake for blame in blames)), " ".join(sentences))
    return None


def _explain_values(answer: EvaluatedAnswer, earlier_mistakes: Sequence[EarlierMistake]) -> Diagnosis | None:
    """Return the mistake that gives the values of an answer, or None.

    If several mistakes give the values, a mistake that was found in an earlier part is named, or otherwise the
    likeliest mistake. If no mistake gives the values, the errors are described entry by entry, provided that each wrong
    entry has a single mistake.
    """
    numeric = answer.numeric
    asks_for_lost_direction = numeric.is_direction and is_made_of_jacobian(answer.part)
    if asks_for_lost_direction and _arm_can_move(answer.correct_values, numeric.values):
        return Diagnosis(("direction-that-moves",), CATALOGUE["direction-that-moves"].format_message({}))
    if division := _explain_missing_division(answer):
        return division
    fitting_predictions = []
    has_opposite_sign = not numeric.is_direction and numeric.equals(-answer.correct_values)
    formula, is_number = find_formula(answer.part), answer.part.type == "number"
    asks_for_more_than_quantity = formula is not None and (is_number or not is_quantity(formula))
    # If all signs are wrong, many mistakes may be the cause, but hardly one that changes signs at one place only.
    for prediction in predict_wrong_answers(answer.correct_stages, answer.part, numeric.is_precise):
        if _explains(prediction, answer):
            if not has_opposite_sign and (cause := _find_cause(prediction, earlier_mistakes)):
                return _name_inherited(prediction, cause)
            if has_opposite_sign and prediction.mistake.name in SIGN_MISTAKES_AT_ONE_PLACE:
                continue
            if has_opposite_sign and asks_for_more_than_quantity and prediction.mistake.name != "sign":
                continue
            fitting_predictions.append(prediction)
            if not earlier_mistakes and prediction.frequency >= 1:
                break
    if not has_opposite_sign and (last_step_mistake := _find_last_step_mistake(answer, fitting_predictions)):
        return last_step_mistake
    if fitting_predictions:
        return _name_likeliest(answer, fitting_predictions)
    if not answer.has_expected_shape or numeric.is_direction:
        return None
    return (
        explain_missing_links(answer)
        or _explain_formulas(answer)
        or _explain_formulas(answer, tries_any_number=True)
        or _explain_terms(answer)
    )


def _find_last_step_mistake(answer: EvaluatedAnswer, predictions: Sequence[PredictedAnswer]) -> Diagnosis | None:
    """Return a mistake in the last steps of an answer to an instructor's question, if likelier than the predictions.

    Most of these questions ask for more than a quantity of the arm. Then a wrong sign or number in the last steps is
    likelier than a mistake in the arm's derivation that happens to give the same answer. A mistake in the use of the
    question's own formula, such as the wrong component, is likelier still.
    """
    formula = find_formula(answer.part)
    if formula is None or not predictions or answer.part.type == "number":
        return None
    last_step_mistakes = LAST_STEP_MISTAKES_IN_QUANTITIES if is_quantity(formula) else LAST_STEP_MISTAKES
    if any(prediction.mistake.name in LIKELIEST_IN_OWN_QUESTIONS for prediction in predictions):
        return None
    searches = (_explain_formulas, partial(_explain_formulas, tries_any_number=True), _explain_terms)
    for diagnosis in (search(answer) for search in searches):
        if diagnosis is not None and diagnosis.is_single_mistake and last_step_mistakes.issuperset(diagnosis.mistakes):
            return diagnosis
    return None


def _explain_terms(answer: EvaluatedAnswer) -> Diagnosis | None:
    """Return the diagnosis of signs, sines for cosines or a number that are wrong in some terms, or None.

    Signs and sines together are named only in an instructor's formula, because a mistake in the derivation of an arm's
    quantity is likelier.
    """
    comparison = _compare_terms(answer) if answer.part.answer.is_symbolic else None
    if comparison is None:
        return None
    has_two_mistakes = comparison.has_exchanged_trigs and comparison.has_wrong_signs
    if has_two_mistakes and find_formula(answer.part) is None:
        return None
    return describe_terms(comparison, answer.correct_values.shape)


def _explain_missing_division(answer: EvaluatedAnswer) -> Diagnosis | None:
    """Return the diagnosis that an answer lacks the division by -det J, or None.

    The denominator of a solution may be -det J, but the catalogue's mistake is that the division by det J is missing.
    """
    for prediction in apply_mistake(CATALOGUE["determinant-forgotten"], answer.correct_stages, answer.part):
        changes_answer = not np.allclose(prediction.answer, answer.correct_values)
        if changes_answer and is_distinctive(prediction.answer) and answer.numeric.equals(-prediction.answer):
            return name_alternatives([(prediction.mistake, prediction.variant.words, prediction.sentence)])
    return None


def _has_values(prediction: PredictedAnswer, numeric_answer: NumericAnswer) -> bool:
    """Return whether a predicted answer equals a student's answer, and is too specific to match it by chance."""
    return numeric_answer.equals(prediction.answer) and is_distinctive(prediction.answer)


def _explains(prediction: PredictedAnswer, answer: EvaluatedAnswer) -> bool:
    """Return whether a predicted answer equals a wrong answer; zeros alone don't identify a mistake in a formula."""
    if not _has_values(prediction, answer.numeric):
        return False
    if prediction.mistake.name not in FORMULA_VARIANTS or not answer.has_expected_shape:
        return True
    return bool(answer.numeric.values[~answer.numeric.match_entries(answer.correct_values)].any())


def _arm_can_move(lost_direction: np.ndarray, direction: np.ndarray) -> bool:
    """Return whether the arm can move in a direction, because it has no component along the lost direction."""
    if lost_direction.shape != direction.shape or lost_direction.shape[1] != 1:
        return False
    with np.errstate(all="ignore"):
        component = np.abs((normalize(lost_direction) * normalize(direction)).sum(axis=0))
    is_zero = component < 1e-3  # of unit vectors, which may be rounded to three decimals
    return bool(np.isfinite(component).all() and is_zero.all())


def _find_cause(prediction: PredictedAnswer, earlier_mistakes: Sequence[EarlierMistake]) -> EarlierMistake | None:
    key = prediction.mistake.name, dict(prediction.variant.words)
    return next((mistake for mistake in earlier_mistakes if (mistake.mistake, mistake.words) == key), None)


def _name_inherited(prediction: PredictedAnswer, cause: EarlierMistake) -> Diagnosis:
    """Return the diagnosis for a mistake that was already found in an earlier part."""
    message = f"You seem to have made the same mistake as in {cause.part_title!r}. "
    message += "Correct that answer first, then this one."
    signature = locate_mistake(prediction.mistake.name, prediction.variant.words)
    return Diagnosis((), message, inherited=cause.part, signature=(signature,))


def _name_likeliest(answer: EvaluatedAnswer, predictions: Sequence[PredictedAnswer]) -> Diagnosis:
    """Return the most frequent of the fitting mistakes, or the first two if several are equally frequent.

    If a single mistake in the finished formulas is likelier, return that mistake instead.
    """
    first_prediction = max(predictions, key=lambda prediction: prediction.frequency)
    equivalent_names = list(first_prediction.mistake.equivalent_mistakes)
    if answer.numeric.is_direction and first_prediction.mistake.name == "row-sign":
        equivalent_names.append("row-sign")  # a reversed row gives the same direction as all others reversed
    # If all signs are wrong, a mistake that reverses all of them is likelier than any other.
    if answer.numeric.equals(-answer.correct_values) and first_prediction.mistake.name not in SIGN_MISTAKES_THROUGHOUT:
        sign_predictions = list(apply_mistake(CATALOGUE["sign"], answer.correct_stages, answer.part))
        sign_candidates = [*sign_predictions, first_prediction]
        return _name_predictions([item for item in sign_candidates if _has_values(item, answer.numeric)])
    candidates = [first_prediction] + [
        prediction
        for name in equivalent_names
        for prediction in apply_mistake(CATALOGUE[name], answer.correct_stages, answer.part)
        if _has_values(prediction, answer.numeric) and prediction.sentence != first_prediction.sentence
    ]
    highest_frequency = max(candidate.frequency for candidate in candidates)
    single_mistake = _find_likelier_mistake(answer, first_prediction, highest_frequency)
    if single_mistake is not None:
        return single_mistake
    likeliest_predictions = [candidate for candidate in candidates if candidate.frequency == highest_frequency][:2]
    first_likeliest = likeliest_predictions[0]
    diagnosis = _name_predictions(likeliest_predictions)
    return replace(diagnosis, cause=(first_likeliest.mistake.name, dict(first_likeliest.variant.words)))


def _name_predictions(predictions: Sequence[PredictedAnswer]) -> Diagnosis:
    """Return the diagnosis that one of the predicted mistakes was made."""
    return name_alternatives([(item.mistake, item.variant.words, _write_message(item)) for item in predictions])


def _find_likelier_mistake(answer: EvaluatedAnswer, prediction: PredictedAnswer, frequency: float) -> Diagnosis | None:
    """Return a single mistake in the finished formulas that is likelier than the predicted mistake, or None.

    `frequency` is the frequency of the predicted mistake and of others that give the same answer.
    """
    numeric = answer.numeric
    if numeric.is_direction or not answer.has_expected_shape or answer.is_correct:
        return None
    wrong_count = int((~numeric.match_entries(answer.correct_values)).sum())
    is_unlikely = frequency < UNLIKELY_FREQUENCY and wrong_count <= MAX_ENTRIES_OF_ONE_MISTAKE
    has_one_wrong_entry = wrong_count == 1 and numeric.values[..., 0].size > 1
    is_made_throughout = has_one_wrong_entry and not LOCATION_WORDS & set(prediction.variant.words)
    is_made_at_several_joints = prediction.mistake.is_rare and len(prediction.variant.joints) > 1
    if not (is_unlikely or is_made_at_several_joints or (is_made_throughout and frequency < LIKELY_FREQUENCY)):
        return None
    single_mistake = _explain_formulas(answer)
    if single_mistake is None:
        return None
    names = set(single_mistake.mistakes)
    likelier_mistakes = EXCHANGE_MISTAKES if is_made_at_several_joints else SIGN_MISTAKES
    is_likelier = (is_unlikely and not SURPLUS_MISTAKES & names) or names <= likelier_mistakes
    return single_mistake if is_likelier else None


def _write_message(prediction: PredictedAnswer) -> str:
    sentence, separator, chapter_reference = prediction.sentence.partition(" See ")
    if prediction.variant.missing_symbols:
        sentence += f" The missing part contains {prediction.variant.missing_symbols}."
    return sentence + separator + chapter_reference


def _explain_formulas(answer: EvaluatedAnswer, tries_any_number: bool = False) -> Diagnosis | None:
    """Return the mistake in the finished formulas, or None.

    The mistake is looked for in the formulas of the worked solution and in those with which answers are compared. A
    mistake that was made everywhere is preferred to mistakes in some of the entries.
    """
    shape = answer.correct_values.shape[:2]
    forms = [form if _find_shape(form) == shape else transpose(form) for form in _list_correct_forms(answer)]
    diagnoses = [explain_formulas(answer, form, tries_any_number) for form in forms if _find_shape(form) == shape]
    # A mistake that was made everywhere has no signature, because it needs no location.
    return min(
        filter(None, diagnoses),
        key=lambda diagnosis: (len(diagnosis.signature) > 0, not diagnosis.is_single_mistake),
        default=None,
    )


def _find_shape(rows: Rows) -> tuple[int, int]:
    return len(rows), len(rows[0])


def _list_correct_forms(answer: EvaluatedAnswer) -> Iterator[Rows]:
    """Yield the formulas of the correct answer as in the worked solution, and then as used for comparison.

    If an instructor's question asks for a number, the formulas are those from which the number is computed; long
    formulas are left out.
    """
    problem, part = answer.problem, answer.part
    if part.type == "number" and find_formula(part) is not None:
        formulas = derive_formulas_of_numbers(part.details_as(CustomDetails).definition, problem.chain)
        yield from [formulas] if formulas else []
    if not part.answer.is_numeric and part.answer.list_entries() and part.type != "number":
        roles = problem.domain.roles
        worked_form = as_matrix(parse_formula(write_answer_code(problem, part), roles))
        compared_form = part.answer.parse_trees(roles)
        if worked_form is not None:
            yield worked_form
        if compared_form != worked_form:
            yield compared_form
