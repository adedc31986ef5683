"""Name the mistake behind a wrong answer: the mistake of the catalogue that gives exactly this answer.

Answers are compared at random configurations, or at the configuration that the question gives. If no mistake of the
catalogue gives the whole answer, the errors are described entry by entry. If that isn't possible either, qdot doesn't
guess.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.trees import as_matrix
from qdot.exercises.mistakes.catalogue import (
    CATALOGUE,
    PredictedAnswer,
    apply_mistake,
    predict_wrong_answers,
    variant_frequency,
)
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import is_product
from qdot.exercises.short_questions.options import list_blames
from qdot.exercises.writing.problem_texts import write_answer_code
from qdot.grader.diagnosis.formula_mistakes import SURPLUS_BY_MISSING, explain_formulas
from qdot.grader.diagnosis.numbers import RELATIVE_TOLERANCE, NumericAnswer, is_distinctive, normalize
from qdot.grader.diagnosis.residuals import explain_missing_links
from qdot.grader.diagnosis.rounding import explain_rounded_function, explain_rounding
from qdot.grader.diagnosis.set_mistakes import explain_set, find_mistaken_answer, name_alternatives
from qdot.grader.diagnosis.wrong_answer import WrongAnswer, evaluate_answer, transpose
from qdot.grader.judging.answer import ParsedAnswer
from qdot.grader.judging.verdict import Diagnosis, locate_mistake

UNLIKELY_FREQUENCY = 0.2
"""If a mistake has a lower frequency, a single mistake in the finished formulas is likelier."""
LIKELY_FREQUENCY = 2.0
"""A mistake of at least this frequency, made throughout an answer, is likelier than a wrong sign of a single entry."""
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
    """Return the known mistake that explains a wrong answer, or None if no mistake in the catalogue does.

    If it is one of the `causes`, which were found in earlier parts, the diagnosis names that part. `seed` determines
    the configurations at which the answer is compared with the answers that known mistakes produce.

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
    wrong_answer = evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return None
    if parsed_answer.table is None:
        rounding = explain_rounding(wrong_answer, parsed_answer.entries)
    else:
        rounding = explain_rounded_function(wrong_answer)
    if rounding or wrong_answer.is_correct:  # with correct values, mistakes without effect on this arm would match
        return rounding
    return _explain_values(wrong_answer.in_expected_shape, causes)


def is_one_mistake(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Return whether a single known mistake explains all wrong entries of an answer in formulas or several numbers.

    The answer may be correct in entries that the mistake would also change. No cause is named for such an answer, but
    the function returns True, because a better answer must not earn less. Only mistakes that are found quickly count,
    so that no mark depends on how long the search takes.
    """
    wrong_answer = evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return False
    values, reference = wrong_answer.numeric, wrong_answer.correct_values
    if not wrong_answer.has_expected_shape or wrong_answer.is_correct:
        return False
    is_wrong = ~values.match_entries(reference)
    is_filled = np.abs(values.values[is_wrong]).max(axis=-1) > RELATIVE_TOLERANCE  # many mistakes give zeros
    predictions = predict_wrong_answers(wrong_answer.correct_working, part, values.is_precise)
    for predicted in predictions if is_filled.any() else ():
        fits = predicted.answer.shape == reference.shape and (values.match_entries(predicted.answer) | ~is_wrong).all()
        if fits and is_distinctive(predicted.answer):
            return True
    if is_product(part) or not is_filled.all():  # the factors of a product are marked separately
        return False
    diagnoses = (explain_missing_links(wrong_answer), _explain_formulas(wrong_answer))
    return any(diagnosis is not None and diagnosis.is_single_mistake for diagnosis in diagnoses)


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

    If several mistakes give the values, the cause is a mistake that was found in an earlier part, or otherwise the
    likeliest mistake. If no mistake gives the values, the errors are described entry by entry, provided that each wrong
    entry has a single mistake.
    """
    in_numbers = answer.numeric
    if in_numbers.is_direction and _arm_can_move(answer.correct_values, in_numbers.values):
        return Diagnosis(("direction-that-moves",), CATALOGUE["direction-that-moves"].sentence({}))
    fitting_predictions = []
    for predicted in predict_wrong_answers(answer.correct_working, answer.part, in_numbers.is_precise):
        if _is_predicted(predicted, in_numbers):
            if cause := _find_cause(predicted, causes):
                return _name_inherited(predicted, cause)
            fitting_predictions.append(predicted)
            if not causes and variant_frequency(predicted) >= 1:
                break
    if fitting_predictions:
        return _name_likeliest(answer, fitting_predictions)
    if not answer.has_expected_shape or in_numbers.is_direction:
        return None
    return (
        explain_missing_links(answer) or _explain_formulas(answer) or _explain_formulas(answer, allows_any_number=True)
    )


def _is_predicted(predicted: PredictedAnswer, numeric_answer: NumericAnswer) -> bool:
    return numeric_answer.equals(predicted.answer) and is_distinctive(predicted.answer)


def _arm_can_move(lost_direction: np.ndarray, direction: np.ndarray) -> bool:
    """Return whether the arm can move in a direction, because it has no component along the lost direction."""
    if lost_direction.shape != direction.shape or lost_direction.shape[1] != 1:
        return False
    with np.errstate(all="ignore"):
        component = np.abs((normalize(lost_direction) * normalize(direction)).sum(axis=0))
    return bool(np.isfinite(component).all() and (component < 1e-3).all())


def _find_cause(predicted: PredictedAnswer, causes: Sequence[Cause]) -> Cause | None:
    mistake, words = predicted.mistake.name, dict(predicted.variant.words)
    return next((cause for cause in causes if (cause.mistake, cause.words) == (mistake, words)), None)


def _name_inherited(predicted: PredictedAnswer, cause: Cause) -> Diagnosis:
    """Return the diagnosis for a mistake that was already found in an earlier part."""
    message = f"You seem to have made the same mistake as in {cause.part_title!r}. Correct that part first."
    signature = locate_mistake(predicted.mistake.name, predicted.variant.words)
    return Diagnosis((), message, inherited=cause.part, signature=(signature,))


def _name_likeliest(answer: WrongAnswer, predictions: Sequence[PredictedAnswer]) -> Diagnosis:
    """Return the most frequent of the fitting mistakes, or the first two if they are equally frequent.

    If a single mistake in the finished formulas is likelier, that mistake is returned instead.
    """
    in_numbers, first_prediction = answer.numeric, max(predictions, key=variant_frequency)
    equivalent_names = list(first_prediction.mistake.equivalent_mistakes)
    if in_numbers.is_direction and first_prediction.mistake.name == "row-sign":  # either one row or all the others
        equivalent_names.append("row-sign")
    alternatives = (
        wrong
        for name in equivalent_names
        for wrong in apply_mistake(CATALOGUE[name], answer.correct_working, answer.part)
    )
    candidates = [
        first_prediction,
        *(
            wrong
            for wrong in alternatives
            if _is_predicted(wrong, in_numbers) and wrong.sentence != first_prediction.sentence
        ),
    ]
    highest_frequency = max(map(variant_frequency, candidates))
    wrong_count = int((~in_numbers.match_entries(answer.correct_values)).sum()) if answer.has_expected_shape else 0
    is_rare = highest_frequency < UNLIKELY_FREQUENCY and wrong_count <= MAX_ENTRIES_OF_ONE_MISTAKE
    is_throughout = wrong_count == 1 < in_numbers.values[..., 0].size and not LOCATION_WORDS & set(
        first_prediction.variant.words
    )
    is_at_several = first_prediction.mistake.rare and len(first_prediction.variant.joints) > 1
    is_less_likely = is_rare or is_at_several or (is_throughout and highest_frequency < LIKELY_FREQUENCY)
    may_be_single = wrong_count and not in_numbers.is_direction and is_less_likely
    if may_be_single and (single_mistake := _explain_formulas(answer)) is not None:
        is_likelier = is_rare and not SURPLUS_MISTAKES & set(single_mistake.mistakes)
        if is_likelier or set(single_mistake.mistakes) <= (EXCHANGE_MISTAKES if is_at_several else SIGN_MISTAKES):
            return single_mistake
    likeliest_predictions = [wrong for wrong in candidates if variant_frequency(wrong) == highest_frequency][:2]
    diagnosis = name_alternatives(
        [(wrong.mistake, wrong.variant.words, _describe(wrong)) for wrong in likeliest_predictions]
    )
    cause = (
        (likeliest_predictions[0].mistake.name, dict(likeliest_predictions[0].variant.words))
        if len(likeliest_predictions) == 1
        else None
    )
    return replace(diagnosis, cause=cause)


def _describe(predicted: PredictedAnswer) -> str:
    missing_symbols = predicted.variant.missing_symbols
    return (
        f"{predicted.sentence} The missing part contains {missing_symbols}." if missing_symbols else predicted.sentence
    )


def _explain_formulas(answer: WrongAnswer, allows_any_number: bool = False) -> Diagnosis | None:
    """Return the mistake in the finished formulas, in the form of the worked solution or in the form compared.

    A mistake made everywhere in either form is preferred to mistakes in some of the entries.
    """
    shape = answer.correct_values.shape[:2]
    forms = [
        form if _shape(form) == shape else transpose(form) for form in _reference_forms(answer.problem, answer.part)
    ]
    diagnoses = [explain_formulas(answer, form, allows_any_number) for form in forms if _shape(form) == shape]
    return min(
        filter(None, diagnoses), key=lambda each: (len(each.signature) > 0, not each.is_single_mistake), default=None
    )


def _shape(rows: Rows) -> tuple[int, int]:
    return len(rows), len(rows[0])


def _reference_forms(problem: Problem, part: Part) -> Iterator[Rows]:
    """Yield the entries of the reference, as written in the worked solution, and then as used for comparison."""
    if not part.answer.is_numeric and part.answer.list_entries() and part.type != "number":
        roles = problem.domain.roles
        worked_form = as_matrix(parse_formula(write_answer_code(problem, part), roles))
        compared_form = part.answer.parse_trees(roles)
        if worked_form is not None:
            yield worked_form
        if compared_form != worked_form:
            yield compared_form
