"""Name the mistake behind a wrong answer: the mistake of the catalogue that gives exactly this answer.

Answers are compared at random configurations, or at the configuration that the question gives. If no mistake of the
catalogue gives the whole answer, the errors are described entry by entry. If that isn't possible either, qdot doesn't
guess.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from qdot.exercises.arm.derivation_graph import Working, numbers
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.parser import read
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, ReadError, as_matrix, digits_of_decimals
from qdot.exercises.mistakes.catalogue import (
    ALIKE,
    CATALOGUE,
    Wrong,
    make_mistake,
    variant_frequency,
    wrong_answers,
)
from qdot.exercises.mistakes.configurations import Values, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.concepts import read_vector
from qdot.exercises.questions.results import is_derived, is_made_of_jacobian, is_product, result
from qdot.exercises.quizzes.options import list_blames
from qdot.exercises.writing.problem_texts import answer_code
from qdot.grader.diagnosis.formula_mistakes import TOO_MANY, Compared, explain_formulas
from qdot.grader.diagnosis.numbers import SAME, InNumbers, says_something, unit
from qdot.grader.diagnosis.residuals import missing_links
from qdot.grader.diagnosis.rounding import explain_rounded_function, explain_rounding, is_right
from qdot.grader.diagnosis.set_mistakes import explain_set, find_mistaken_answer, name_either
from qdot.grader.judging.answer import ParsedAnswer, Table
from qdot.grader.judging.verdict import Diagnosis, locate_mistake

POINTS = 16
THREE_DECIMALS = 6e-4
LEAST_LIKELY = 0.2
"""If a mistake has a lower frequency, a single mistake in the finished formulas is likelier."""
VERY_LIKELY = 2.0
"""From this frequency, a mistake made throughout an answer is likelier than the wrong sign of a single entry."""
MOST_IN_ONE_PLACE = 2
"""Maximum number of wrong entries that a single mistake in the finished formulas may cause."""
EXTRA = set(TOO_MANY.values())
SIGNS = {"term-sign-typed", "entry-sign"}
EXCHANGED = {"wave-throughout"}
"""The formula mistakes that are likelier than a rare mistake at several joints."""
OF_ONE_PLACE = {"joint", "link", "one"}
"""The words in messages of mistakes that are made at one joint or entry.

Other mistakes change everything, and so hardly ever only the sign of a single entry."""
LONGEST_SET = 600
"""Maximum length (characters) of a set that is compared with the sets that mistakes give; comparing is slow."""


@dataclass(frozen=True)
class Cause:
    """A mistake that was found in an earlier part: its name and words, and the name and title of the part."""

    mistake: str
    words: Mapping[str, object]
    part: str
    title: str


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
        is_short = len(parsed_answer.text) <= LONGEST_SET
        if part.answer.is_a_set:
            return explain_set(problem, part, parsed_answer, seed) if is_short else None
        mistake_of_whole_answer = find_mistaken_answer(problem, part, parsed_answer, seed) if is_short else None
        if mistake_of_whole_answer is not None:
            return mistake_of_whole_answer
    wrong_answer = _evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return None
    values, reference = wrong_answer.in_numbers, wrong_answer.right
    if parsed_answer.table is None:
        rounding = explain_rounding(part, values, reference, parsed_answer.entries)
    else:
        rounding = explain_rounded_function(values, reference)
    if rounding or is_right(values, reference):  # with correct values, mistakes without effect on this arm would match
        return rounding
    return _explain(wrong_answer.upright, causes)


def is_one_mistake(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> bool:
    """Return whether a single known mistake explains all wrong entries of an answer in formulas or several numbers.

    Entries that the mistake would also change may be correct. Then no cause is named, but a better answer must not earn
    less. Only mistakes that are found quickly count, so that no mark depends on how long the search takes.
    """
    wrong_answer = _evaluate_answer(problem, part, parsed_answer, seed)
    if wrong_answer is None:
        return False
    values, reference = wrong_answer.in_numbers, wrong_answer.right
    if values.values.shape != reference.shape or is_right(values, reference):
        return False
    is_wrong = ~values.like(reference)
    is_filled = np.abs(values.values[is_wrong]).max(axis=-1) > SAME  # many mistakes give zeros
    for predicted in wrong_answers(wrong_answer.w, part, values.is_precise) if is_filled.any() else ():
        fits = predicted.answer.shape == reference.shape and (values.like(predicted.answer) | ~is_wrong).all()
        if fits and says_something(predicted.answer):
            return True
    if is_product(part) or not is_filled.all():  # the factors of a product are marked separately
        return False
    formula_diagnoses = (missing_links(wrong_answer.w, part, reference, values.values), _explain_formulas(wrong_answer))
    return any(diagnosis is not None and diagnosis.is_one for diagnosis in formula_diagnoses)


# --- the numeric values of the answer ---


@dataclass(frozen=True)
class WrongAnswer:
    """A wrong answer with its values at some configurations, and its formulas as typed, if there are any."""

    problem: Problem
    part: Part
    values: Values
    in_numbers: InNumbers
    rows: Rows | None = None

    @cached_property
    def w(self) -> Working:
        """The correct derivation, evaluated at the configurations."""
        return numbers(self.problem.chain, self.values)

    @cached_property
    def right(self) -> np.ndarray:
        """The values of the correct answer, (rows, columns, N)."""
        return result(self.w, self.part)

    @cached_property
    def derivatives(self) -> np.ndarray:
        """Whether each entry is found by differentiation, (rows, columns).

        Angular entries are not, and neither are results computed from a Jacobian.
        """
        if is_made_of_jacobian(self.part):
            return np.zeros(self.right.shape[:2], bool)
        result_for_doubled_rows = result(self.w.with_mistakes({"linear": lambda _, rows: 2 * rows}), self.part)
        return np.asarray((np.abs(result_for_doubled_rows - self.right) > SAME * np.abs(self.right)).any(axis=-1))

    @property
    def upright(self) -> "WrongAnswer":
        """The same answer, transposed if a vector was typed as a row instead of a column, or vice versa."""
        shape, transposed_values = self.right.shape, self.in_numbers.values.swapaxes(0, 1)
        if 1 not in shape[:2] or self.in_numbers.values.shape == shape or transposed_values.shape != shape:
            return self
        in_numbers = replace(self.in_numbers, values=transposed_values, size=self.in_numbers.size.swapaxes(0, 1))
        return replace(self, in_numbers=in_numbers, rows=None if self.rows is None else _transpose(self.rows))


def _evaluate_answer(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> WrongAnswer | None:
    """Evaluate an answer at configurations; return None if the part isn't derived or the answer has no values."""
    if not is_derived(part):
        return None
    if parsed_answer.table is not None:
        return _evaluate_function(problem, part, parsed_answer.table)
    values = sample_configurations(problem.chain, part, problem.domain(), POINTS, Stream(f"{seed}/diagnosis"))
    try:
        in_numbers = (
            _parse_option(part, parsed_answer)
            if part.answer.offered
            else _evaluate_entries(part, parsed_answer, values)
        )
    except ReadError:  # an answer that was refused may have statements as entries
        return None
    return None if in_numbers is None else WrongAnswer(problem, part, values, in_numbers, parsed_answer.rows)


def _evaluate_function(problem: Problem, part: Part, table: Table) -> WrongAnswer | None:
    """Return a Python function as a wrong answer, with the values that it returned in the sandbox."""
    if table.shape is None or len(table.shape) > 2:
        return None
    values = {name: column[:POINTS] for name, column in table.at.items()}
    rows = (*table.shape, *(1,) * (2 - len(table.shape)))
    outputs = table.values[:POINTS].T.reshape(*rows, -1)
    tolerances = (max(SAME, part.rounding.relative), part.rounding.absolute) if part.rounding else (SAME, 0.0)
    is_direction = part.answer.counts_up_to_a_factor
    return WrongAnswer(problem, part, values, InNumbers(outputs, np.abs(outputs), tolerances, is_direction))


def _evaluate_entries(part: Part, parsed_answer: ParsedAnswer, values: Values) -> InNumbers | None:
    entries, blanks = parsed_answer.entries, parsed_answer.blanks
    if parsed_answer.rows is None or all(blanks) or parsed_answer.symbols - set(values):
        return None
    filled = [Node("name", value="pi") if blank else entry for entry, blank in zip(entries, blanks, strict=True)]
    count = len(next(iter(values.values())))
    entry_values, term_size = evaluate(compile_program(filled), values, count)
    entry_values[blanks] = np.nan
    shape, is_direction = (
        (len(parsed_answer.rows), len(parsed_answer.rows[0]), count),
        part.answer.counts_up_to_a_factor,
    )
    return InNumbers(entry_values.reshape(shape), term_size.reshape(shape), _room(part, filled), is_direction)


def _room(part: Part, entries: Sequence[Node]) -> tuple[float, float]:
    """Return the relative and the absolute tolerance for an answer.

    For numbers, it depends on the digits required, or on the digits typed if these are more.
    """
    relative, absolute = (0.0, 0.0) if part.rounding is None else (part.rounding.relative, part.rounding.absolute)
    if not part.answer.is_in_numbers:
        return max(SAME, relative), absolute
    digits = max(map(digits_of_decimals, entries))
    return max(min(relative or 5e-3, 0.6 * 10.0 ** (1 - max(digits, 3))), 1e-5), 0.0


def _parse_option(part: Part, parsed_answer: ParsedAnswer) -> InNumbers | None:
    if not parsed_answer.chosen:
        return None
    values = np.array(read_vector(part.answer.offered[parsed_answer.chosen[0]]))[:, None, None]
    return InNumbers(values, np.abs(values), (0.0, THREE_DECIMALS))


# --- the mistake behind it ---


def _explain_option(part: Part, parsed_answer: ParsedAnswer) -> Diagnosis | None:
    """Return the mistakes behind the first wrong option that was chosen, which were stored with the option."""
    for index in parsed_answer.chosen:
        blames = [] if index in part.answer.right else list_blames(part, index)
        if blames:
            sentences = dict.fromkeys(blame.sentence for blame in blames)
            return Diagnosis(tuple(dict.fromkeys(blame.mistake for blame in blames)), " ".join(sentences))
    return None


def _explain(answer: WrongAnswer, causes: Sequence[Cause]) -> Diagnosis | None:
    """Return the mistake that gives the values of an answer, or None.

    If several mistakes do, one that was found in an earlier part is named as the cause, otherwise the likeliest. If
    none does, the errors are described entry by entry, provided that each wrong entry has a single mistake.
    """
    in_numbers, reference, part = answer.in_numbers, answer.right, answer.part
    if in_numbers.is_direction and _moves(reference, in_numbers.values):
        return Diagnosis(("direction-that-moves",), CATALOGUE["direction-that-moves"].sentence({}))
    fitting_predictions = []
    for predicted in wrong_answers(answer.w, part, in_numbers.is_precise):
        if _gives(predicted, in_numbers):
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
        missing_links(answer.w, part, reference, in_numbers.values)
        or _explain_formulas(answer)
        or _explain_formulas(answer, any_number=True)
    )


def _gives(wrong: Wrong, in_numbers: InNumbers) -> bool:
    return in_numbers.is_all(wrong.answer) and says_something(wrong.answer)


def _moves(lost: np.ndarray, direction: np.ndarray) -> bool:
    """Return whether the arm can move in a direction, because this has no component along the lost direction."""
    if lost.shape != direction.shape or lost.shape[1] != 1:
        return False
    with np.errstate(all="ignore"):
        component = np.abs((unit(lost) * unit(direction)).sum(axis=0))
    return bool(np.isfinite(component).all() and (component < 1e-3).all())


def _find_cause(wrong: Wrong, causes: Sequence[Cause]) -> Cause | None:
    return next(
        (cause for cause in causes if (cause.mistake, cause.words) == (wrong.mistake.name, dict(wrong.variant.words))),
        None,
    )


def _name_inherited(wrong: Wrong, cause: Cause) -> Diagnosis:
    """Return the diagnosis for a mistake that was already found in an earlier part."""
    message = f"This follows from what went wrong in {cause.title!r}: the same mistake gives this answer."
    signature = locate_mistake(wrong.mistake.name, wrong.variant.words)
    return Diagnosis((), message, inherited=cause.part, known_by=(signature,))


def _name_likeliest(answer: WrongAnswer, fitting: Sequence[Wrong]) -> Diagnosis:
    """Return the most frequent of the fitting mistakes, or the first two if they are equally frequent.

    If a single mistake in the finished formulas is likelier, it is returned instead.
    """
    in_numbers, first = answer.in_numbers, max(fitting, key=variant_frequency)
    alike_names = list(ALIKE.get(first.mistake.name, ()))
    if in_numbers.is_direction and first.mistake.name == "row-sign":  # either one row or all the others
        alike_names.append("row-sign")
    alternatives = (wrong for name in alike_names for wrong in make_mistake(CATALOGUE[name], answer.w, answer.part))
    candidates = [
        first,
        *(wrong for wrong in alternatives if _gives(wrong, in_numbers) and wrong.sentence != first.sentence),
    ]
    highest = max(map(variant_frequency, candidates))
    wrong_count = int((~in_numbers.like(answer.right)).sum()) if in_numbers.values.shape == answer.right.shape else 0
    is_rare = highest < LEAST_LIKELY and wrong_count <= MOST_IN_ONE_PLACE
    is_throughout = wrong_count == 1 < in_numbers.values[..., 0].size and not OF_ONE_PLACE & set(first.variant.words)
    is_at_several = first.mistake.rare and len(first.variant.places) > 1
    is_less_likely = is_rare or is_at_several or (is_throughout and highest < VERY_LIKELY)
    single_mistake = (
        _explain_formulas(answer) if wrong_count and not in_numbers.is_direction and is_less_likely else None
    )
    if single_mistake is not None:
        is_likelier = is_rare and not EXTRA & set(single_mistake.mistakes)
        if is_likelier or set(single_mistake.mistakes) <= (EXCHANGED if is_at_several else SIGNS):
            return single_mistake
    likeliest = [wrong for wrong in candidates if variant_frequency(wrong) == highest][:2]
    diagnosis = name_either([(wrong.mistake, wrong.variant.words, _sentence(wrong)) for wrong in likeliest])
    cause = (likeliest[0].mistake.name, dict(likeliest[0].variant.words)) if len(likeliest) == 1 else None
    return replace(diagnosis, cause=cause)


def _sentence(wrong: Wrong) -> str:
    missing = wrong.variant.missing
    return f"{wrong.sentence} What is missing has {missing} in it." if missing else wrong.sentence


def _explain_formulas(answer: WrongAnswer, any_number: bool = False) -> Diagnosis | None:
    """Return the mistake in the finished formulas, in the form of the worked solution or in the form compared.

    A mistake made everywhere in either form is preferred to mistakes in some of the entries.
    """
    diagnoses = []
    for form in _reference_forms(answer.problem, answer.part):
        shape = answer.right.shape[:2]
        rows = form if (len(form), len(form[0])) == shape else _transpose(form)
        if (len(rows), len(rows[0])) == shape:
            formulas = Compared(rows, answer.derivatives, answer.rows)
            diagnoses.append(explain_formulas(formulas, answer.values, answer.in_numbers, answer.right, any_number))
    return min(filter(None, diagnoses), key=lambda each: (len(each.known_by) > 0, not each.is_one), default=None)


def _transpose(rows: Rows) -> Rows:
    return [list(column) for column in zip(*rows, strict=True)]


def _reference_forms(problem: Problem, part: Part) -> Iterator[Rows]:
    """Yield the entries of the reference, first in the form of the worked solution, then in the form compared."""
    if not part.answer.is_in_numbers and part.answer.entries() and part.type != "number":
        roles = problem.domain().roles
        worked_form, compared_form = as_matrix(read(answer_code(problem, part), roles)), part.answer.trees(roles)
        if worked_form is not None:
            yield worked_form
        if compared_form != worked_form:
            yield compared_form
