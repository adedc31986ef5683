"""Generate wrong formulas as options, which known mistakes make as plausible as the correct formula.

Two mistakes give three wrong options: with the first mistake, with the second, and with both. Each mistake then occurs
in two of the four options, so the correct option is not more similar to the others than they are to each other. It is
random whether the correct option is the longest, the shortest, or in between. Formulas are derived once for the
structure of an arm (the arm with symbols for all lengths and oblique angles), and then get the arm's numbers. Only
formulas that depend on the home position are derived for the arm itself. In this module, `symbolic_chain` is the chain
for which the formulas are derived.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import combinations, islice

import numpy as np
import sympy as sp
from sympy.polys.polyerrors import BasePolynomialError

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import SCREWS
from qdot.exercises.arm.trigonometry import factor_trig, to_textbook_form, write_in_textbook_form
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation import graph
from qdot.exercises.derivation.derivation import derive, make_symbolic_arm
from qdot.exercises.derivation.graph import Change, StageResults
from qdot.exercises.formula.equality import READABLE_POINTS, Domain
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.mistakes import screws
from qdot.exercises.mistakes.catalogue import predict_wrong_answers
from qdot.exercises.problem.problem import Part, recorded_as
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.results import compute_answer
from qdot.exercises.short_questions import options
from qdot.exercises.short_questions.options import Blame, OfferedOption
from qdot.exercises.singularities.classification import make_domain

SAMPLE_COUNT = 5
"""Number of random points at which formulas are compared."""
MIN_RELATIVE_DIFFERENCE = 1e-6
"""Minimum relative difference, at some point, of two answers that count as different."""
MAX_PAIRS, MAX_WRITTEN_TRIPLES = 300, 12
"""Maximum number of pairs of mistakes that are compared numerically, and of triples of options that are derived as
formulas."""
MAX_VARIANTS_FOR_ANY_PAIR = 8
"""Maximum number of variants of mistakes for which two variants of the same mistake may be combined."""
SCREW_MISTAKES = frozenset(screws.VARIANTS)
"""The names of the mistakes about screws. Options about screws come only from these mistakes, not from mistakes in the
order or the signs of entries."""
NOT_A_NUMBER = (sp.nan, sp.zoo, sp.oo)
"""SymPy's results of operations that are undefined, such as a division by zero."""
MAX_CHARACTERS_PER_ENTRY, MIN_CHARACTER_LIMIT = 110, 260
"""The maximum length of an option: a number of characters for each of up to four entries, but at least the minimum."""
MAX_JOINTS_FOR_MINORS = 4
"""Maximum number of joints for which determinants are derived as formulas, which takes minutes for more joints."""


@dataclass(frozen=True)
class OptionSubject:
    """The result that the options claim to show: the answer to the base question, or its column or entry."""

    base_question: str = field(metadata=recorded_as("base"))
    column: int | None = None
    row: int | None = None

    @property
    def depends_on_home_position(self) -> bool:
        """Whether the result depends on the arm's home configuration, which the arm's structure does not determine."""
        return QUESTIONS[self.base_question].required_feature == SCREWS

    @property
    def has_denominator(self) -> bool:
        """Whether the correct answer has a denominator."""
        return "inverse" in self.base_question

    def extract_from(self, whole_answer: np.ndarray) -> np.ndarray:
        """Return the rows and columns of a whole answer, (rows, columns, …), that the options show."""
        rows = slice(None) if self.row is None else slice(self.row, self.row + 1)
        return whole_answer[rows, slice(None) if self.column is None else slice(self.column, self.column + 1)]


@dataclass(frozen=True)
class _Variant:
    """A variant of a mistake: the mistake with its words, the numeric answer it gives, and its changes of stages."""

    blame: Blame
    values: np.ndarray
    changes: tuple[tuple[str, Change], ...]


VariantIndices = tuple[int, ...]
"""The indices, in the result of `_find_variants`, of the variants of mistakes in one option; () for the correct
option."""


@lru_cache(maxsize=512)
def ask_base_question(symbolic_chain: Chain, question: str) -> Part:
    """Return the part that asks a question with an answer that does not depend on random numbers."""
    answer, details = QUESTIONS[question].ask(symbolic_chain, Stream("quiz"))
    return Part(question, question, answer, details=details)


@lru_cache(maxsize=512)
def _sample_values(symbolic_chain: Chain, question: str) -> Mapping[str, np.ndarray]:
    """Return random values of all symbols of a question, by name: SAMPLE_COUNT values each.

    The first READABLE_POINTS samples are omitted, because they are rounded and may be singular.
    """
    roles = make_domain(symbolic_chain).roles
    rates = (rate.name for rate in symbolic_chain.rates)
    names = {*roles, *rates, *symbolic_chain.task, *ask_base_question(symbolic_chain, question).symbols}
    samples = Domain(roles).sample(names, READABLE_POINTS + SAMPLE_COUNT, Stream(f"quiz/{question}"))
    return {name: values[READABLE_POINTS:] for name, values in samples.items()}


@lru_cache(maxsize=512)
def _evaluate_correct_answer(symbolic_chain: Chain, subject: OptionSubject) -> tuple[StageResults, np.ndarray]:
    """Return the correct derivation at random values of all symbols, and the values of the correct option."""
    stages = graph.compute_numeric_stages(symbolic_chain, _sample_values(symbolic_chain, subject.base_question))
    return stages, _compute_subject(stages, subject)


def _compute_subject(stages: StageResults, subject: OptionSubject) -> np.ndarray:
    """Return the result that the options show, (rows, columns, …), from the stages of a derivation."""
    return subject.extract_from(compute_answer(stages, ask_base_question(stages.chain, subject.base_question)))


@lru_cache(maxsize=512)
def _find_variants(symbolic_chain: Chain, subject: OptionSubject) -> tuple[_Variant, ...]:
    """Return the variants of mistakes that change the result that options show, one for each wrong result."""
    stages, correct = _evaluate_correct_answer(symbolic_chain, subject)
    variants: list[_Variant] = []
    for prediction in predict_wrong_answers(stages, ask_base_question(symbolic_chain, subject.base_question)):
        values = subject.extract_from(prediction.answer)
        known_values = (correct, *(variant.values for variant in variants))
        is_suitable = prediction.mistake.name in SCREW_MISTAKES or not subject.depends_on_home_position
        if is_suitable and options.is_plausible(prediction.mistake) and _is_new_answer(values, known_values):
            blame = Blame.from_mistake(prediction.mistake, prediction.variant.words.items())
            variants.append(_Variant(blame, values, prediction.stages.changes))
    return tuple(variants)


def _is_new_answer(values: np.ndarray, known_answers: Sequence[np.ndarray]) -> bool:
    """Return whether an answer is finite, has the same shape as the known answers, and differs from all of them."""
    if values.shape != known_answers[0].shape or not np.isfinite(values).all():
        return False
    return all(have_different_values(values, known_values) for known_values in known_answers)


def have_different_values(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two answers have clearly different values at some point."""
    return bool(np.abs(a - b).max() > MIN_RELATIVE_DIFFERENCE * max(np.abs(a).max(), np.abs(b).max(), 1e-12))


def _combine_to_new_answer(symbolic_chain: Chain, subject: OptionSubject, a: _Variant, b: _Variant) -> bool:
    """Return whether two mistakes together give a wrong answer that neither mistake alone gives."""
    stages, correct = _evaluate_correct_answer(symbolic_chain, subject)
    both_mistakes = stages.with_mistakes(dict(a.changes)).with_mistakes(dict(b.changes))
    with np.errstate(all="ignore"):
        values = _compute_subject(both_mistakes, subject)
    return _is_new_answer(values, (correct, a.values, b.values))


# --- as formulas ---


@lru_cache(maxsize=512)
def derive_simplified_formulas(symbolic_chain: Chain) -> StageResults:
    """Return the correct derivation in formulas, with simplified intermediate results."""
    changes = {"rotations": _simplify_matrices, "link vectors": _simplify_matrices}
    return graph.compute_symbolic_stages(symbolic_chain).with_mistakes(changes)


def _simplify_matrices(_: StageResults, matrices: list[np.ndarray]) -> list[np.ndarray]:
    simplify = np.frompyfunc(write_in_textbook_form, 1, 1)  # it also accepts cos(pi*theta1/180), a mistake
    return [np.asarray(simplify(matrix)) for matrix in matrices]


@lru_cache(maxsize=20_000)
def _write_answer(symbolic_chain: Chain, subject: OptionSubject, variants: VariantIndices) -> sp.Matrix | None:
    """Return the answer with these variants of mistakes as formulas, or None if it is too long."""
    if not _has_short_answer(symbolic_chain, subject):
        return None
    derive_stages = graph.compute_symbolic_stages if subject.depends_on_home_position else derive_simplified_formulas
    stages = derive_stages(symbolic_chain)
    for index in variants:
        stages = stages.with_mistakes(dict(_find_variants(symbolic_chain, subject)[index].changes))
    entries = graph.to_sympy_matrix(_compute_subject(stages, subject))
    if entries.has(*NOT_A_NUMBER):
        return None
    try:
        simplified_entries = entries.applyfunc(_expand_numbers if subject.depends_on_home_position else tidy_entry)
    except (ValueError, BasePolynomialError):  # not a trigonometric polynomial
        return None
    if not subject.has_denominator and any(sp.fraction(entry)[1].free_symbols for entry in simplified_entries):
        return None  # a student would not expect a quotient here
    return simplified_entries if _is_short_enough(simplified_entries) else None


def _is_short_enough(option: sp.Matrix) -> bool:
    return len(str(option.tolist())) <= max(MAX_CHARACTERS_PER_ENTRY * min(len(option), 4), MIN_CHARACTER_LIMIT)


@lru_cache(maxsize=2048)
def _has_short_answer(symbolic_chain: Chain, subject: OptionSubject) -> bool:
    """Return whether the correct answer is short; this is faster than deriving wrong formulas."""
    if symbolic_chain.n > MAX_JOINTS_FOR_MINORS and QUESTIONS[subject.base_question].is_made_of_minors:
        return False
    answer = ask_base_question(symbolic_chain, subject.base_question).answer.as_matrix()
    return _is_short_enough(sp.Matrix(subject.extract_from(np.array(answer.tolist(), dtype=object))))


def _expand_numbers(entry: sp.Expr) -> sp.Expr:
    """Return an entry with products of the arm's numbers multiplied out.

    Raises ValueError for a formula with roots, or with constant angles of the arm, such as theta1 + 30 degrees.
    """
    if not entry.has(sp.sin, sp.cos):
        return sp.expand(entry)
    if any(power.is_number and not power.is_Rational for power in entry.atoms(sp.Pow)):
        raise ValueError(f"{entry} has roots")
    return tidy_entry(entry)


def tidy_entry(entry: sp.Expr) -> sp.Expr:
    """Return an entry in textbook form, with common factors of a quotient cancelled. Raises ValueError for x / 0."""
    if any(power.exp.is_negative for power in entry.atoms(sp.Pow)):
        numerator, denominator = (sp.expand(side) for side in sp.fraction(sp.together(entry)))
        factored_denominator = factor_trig(denominator) if not denominator.has(*NOT_A_NUMBER) else None
        if factored_denominator is None or factored_denominator.is_zero or numerator.has(*NOT_A_NUMBER):
            raise ValueError(f"{entry} divides by zero")
        return factor_trig(numerator).divide_by(factored_denominator).to_expression()
    return to_textbook_form(sp.expand(entry))


# --- four options ---


def make_four_options(chain: Chain, subject: OptionSubject, rng: Stream) -> list[OfferedOption] | None:
    """Return the correct option and three wrong options of similar length, or None if there are no such options."""
    symbolic_chain = chain if subject.depends_on_home_position else make_symbolic_arm(chain).chain
    if _write_answer(symbolic_chain, subject, ()) is None:
        return None
    intended_rank = rng.integer_below(4)
    candidates: list[tuple[options.LengthMismatch, tuple[VariantIndices, ...]]] = []
    for triple in islice(_make_wrong_triples(symbolic_chain, subject, rng), MAX_WRITTEN_TRIPLES):
        lengths = [_measure_length(symbolic_chain, subject, indices) for indices in ((), *triple)]
        mismatch = options.find_length_mismatch(lengths, intended_rank) if all(lengths) else None
        if mismatch is not None:
            candidates.append((mismatch, triple))
            if mismatch.is_best:
                break
    substitute = sp.Matrix if symbolic_chain is chain else derive(chain).substitute_matrix
    variants = _find_variants(symbolic_chain, subject)
    for _, triple in sorted(candidates):
        formulas = [substitute(_write_answer(symbolic_chain, subject, indices)) for indices in ((), *triple)]
        if are_different_functions(chain, formulas):
            blames = (tuple(variants[index].blame for index in indices) for indices in ((), *triple))
            return [OfferedOption(*formula_and_blames) for formula_and_blames in zip(formulas, blames, strict=True)]
    return None


@lru_cache(maxsize=20_000)
def _measure_length(symbolic_chain: Chain, subject: OptionSubject, variants: VariantIndices) -> int:
    """Return the number of characters of an option, or 0 if it is too long."""
    answer = _write_answer(symbolic_chain, subject, variants)
    return 0 if answer is None else len(str(answer.tolist()))


def _make_wrong_triples(
    symbolic_chain: Chain, subject: OptionSubject, rng: Stream
) -> Iterator[tuple[VariantIndices, ...]]:
    """Yield triples of wrong options, each given by its variants of mistakes.

    The first triples consist of a mistake, another mistake, and both mistakes together. The later triples consist of
    three single mistakes.
    """
    variants = _find_variants(symbolic_chain, subject)
    pairs = rng.permutation(list(combinations(range(len(variants)), 2)))
    for a, b in pairs[:MAX_PAIRS]:
        is_same_mistake = variants[a].blame.mistake == variants[b].blame.mistake
        if is_same_mistake and len(variants) > MAX_VARIANTS_FOR_ANY_PAIR:
            continue
        if _combine_to_new_answer(symbolic_chain, subject, variants[a], variants[b]):
            yield (a,), (b,), (a, b)
    for a, b, c in rng.permutation(list(islice(combinations(range(len(variants)), 3), MAX_PAIRS))):
        yield (a,), (b,), (c,)


def are_different_functions(chain: Chain, formulas: list[sp.Matrix]) -> bool:
    """Return whether formulas are different functions for an arm, because its numeric lengths may make them equal."""
    programs = compile_program([parse_formula(str(entry)) for formula in formulas for entry in formula])
    names = {symbol.name for formula in formulas for symbol in formula.free_symbols}
    count = READABLE_POINTS + SAMPLE_COUNT
    samples = Domain(make_domain(chain).roles).sample(names, count, Stream("quiz"))
    all_values = evaluate(programs, samples or {"any": np.ones(count)}, count).values  # `evaluate` needs a symbol
    values = all_values.reshape(len(formulas), -1, count)[:, :, READABLE_POINTS:]
    return bool(np.isfinite(values).all()) and all(have_different_values(a, b) for a, b in combinations(values, 2))


def find_wrong_formulas(symbolic_chain: Chain, subject: OptionSubject) -> list[tuple[sp.Expr, Blame]]:
    """Return the wrong formulas for an entry that single mistakes give, each with its mistake."""
    return [
        (answer[0], variant.blame)
        for index, variant in enumerate(_find_variants(symbolic_chain, subject))
        if (answer := _write_answer(symbolic_chain, subject, (index,))) is not None
    ]
