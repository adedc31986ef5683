"""Give partial credit for a wrong answer, by a rule that depends on the type of answer (docs/partial-credit.md).

The shares are defined in `qdot.exercises.problem.credit`. The reference is the correct answer. The constant lengths and
angles of the arm are called constants. All other symbols vary with the configuration or its velocity.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, combinations, product
from math import prod
from typing import NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.common.errors import count_noun
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import split_factors
from qdot.exercises.formula.equality import READABLE_POINTS, Domain, compare_entries
from qdot.exercises.formula.parser import parse_reference
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.scale import ConstantFactor, find_constant_factor
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import ONE, ZERO, Node, find_names
from qdot.exercises.problem.credit import (
    MAX_WRONG_FACTORS,
    MISTAKE_FACTOR,
    compute_share_of_columns,
    compute_share_of_product,
    compute_share_up_to_sign_and_factor,
)
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import find_determinant_in_denominator, is_product
from qdot.exercises.reference_answers import Number
from qdot.grader.diagnosis.diagnosis import compare_wrong_terms, is_one_mistake
from qdot.grader.diagnosis.numbers import RELATIVE_TOLERANCE
from qdot.grader.judging.answer_parser import FunctionValues, ParsedAnswer
from qdot.grader.judging.verdict import Judgement, Outcome
from qdot.grader.marking.follow_through import IsCopied, never_copied

SHARE_WITH_WRONG_SIGNS = compute_share_up_to_sign_and_factor(is_sign_wrong=True, is_factor_wrong=False)
"""The share of an answer in which only signs are wrong."""
SAMPLE_COUNT = 6
"""Number of random configurations at which answers are evaluated."""
MAX_FACTORS = 6
"""Maximum number of factors of a product that are compared one by one."""
MAX_LENGTHS = 5
"""Maximum number of lengths whose powers are tried in a constant factor."""


@dataclass(frozen=True)
class AnswerInContext:
    """A parsed answer and its problem; `seed` determines the configurations at which the answer is evaluated."""

    problem: Problem
    part: Part
    parsed: ParsedAnswer
    seed: str

    @cached_property
    def domain(self) -> Domain:
        """The symbols of the problem, with their roles."""
        return self.problem.domain

    @cached_property
    def varying_names(self) -> set[str]:
        """The names of the symbols that vary: all except the constants of the arm."""
        return set(self.domain.roles) - self.problem.constants

    @property
    def has_unknown_symbols(self) -> bool:
        """Whether the answer contains symbols that the problem doesn't define."""
        return bool(self.parsed.symbols - set(self.domain.roles))

    def sample(self, purpose: str) -> dict[str, np.ndarray]:
        """Return `SAMPLE_COUNT` random values of each symbol. A constant is positive and the same in all samples.

        Each `purpose` has its own values.
        """
        count, stream = READABLE_POINTS + SAMPLE_COUNT, Stream(f"{self.seed}/{purpose}")
        return {  # the first samples have readable values and are omitted, because factors may be zero there
            name: column[READABLE_POINTS:] if name in self.varying_names else np.full(SAMPLE_COUNT, abs(column[-1]))
            for name, column in self.domain.sample(set(self.domain.roles), count, stream).items()
        }


class EarnedShare(NamedTuple):
    """A share of a part's points, and the reason for it."""

    share: Fraction
    reason: str


def give_partial_credit(answer: AnswerInContext, judgement: Judgement, is_copied: IsCopied = never_copied) -> Judgement:
    """Return the judgement with the share that the assignment gives for a partly correct answer.

    `is_copied` returns whether an answer is correct for another student's problem. Such an answer gets no credit for a
    known mistake.
    """
    if judgement.outcome not in (Outcome.WRONG, Outcome.PARTIAL) or answer.parsed.refusal is not None:
        return judgement
    part, rules = answer.part, answer.part.credit
    if rules.rule == "whole" or part.answer.is_direction:
        return _replace_share(judgement, Fraction(0))
    # The share was computed as a fraction with a small denominator, and stored as a float.
    share, reason = Fraction(judgement.share).limit_denominator(1000), judgement.reason
    credit: EarnedShare | None = None
    if part.answer.is_symbolic and part.shape is not None:
        judgement, share = _credit_entries(answer, judgement, share)
    if part.answer.is_symbolic:
        credit = _credit_except_factor(answer, judgement) or _credit_factors(answer)
        if max(share, credit.share if credit else 0) < SHARE_WITH_WRONG_SIGNS:  # the most that terms can earn
            credit = max(filter(None, [credit, _credit_terms(answer, is_copied)]), default=None)
    elif part.answer.expected_units:
        credit = _credit_except_signs(answer)
    if rules.covers_known_mistakes and max(share, credit.share if credit else 0) < MISTAKE_FACTOR:
        credit = _credit_one_mistake(answer, is_copied) or credit
    if credit is not None and credit.share > share:
        share = credit.share
        # The share is not the share of correct entries, so their number is left out.
        count_pattern = r"^(\d+ of \d+|(none of the|all) \d+|neither of the two|both|the only) [a-z ]+ right[^;]*; "
        detail = re.sub(count_pattern, "", reason)
        words = f"{credit.reason}, so you earn {_format_share(share * rules.factor)} of the points"
        judgement = replace(judgement, reason=f"{words}; {detail}")
    return _replace_share(judgement, share * rules.factor)


def _format_share(share: Fraction) -> str:
    """Return a share of the points in words.

    >>> _format_share(Fraction(1, 2)), _format_share(Fraction(4, 5)), _format_share(Fraction(2, 3))
    ('half', '80 %', '2/3')
    """
    percent = 100 * share
    if percent == 50:
        return "half"
    return f"{percent} %" if percent.denominator == 1 else str(share)


def _replace_share(judgement: Judgement, share: Fraction) -> Judgement:
    """Return the judgement with another share, and the outcome that fits this share."""
    outcome = Outcome.PARTIAL if share > 0 else Outcome.WRONG
    return replace(judgement, outcome=outcome, share=float(share))


# --- matrices ---


def _credit_entries(answer: AnswerInContext, judgement: Judgement, share: Fraction) -> tuple[Judgement, Fraction]:
    """Return the judgement on a matrix and its share, computed by columns if that is the assignment's rule.

    The share is 0 if all correct entries are constant and some entry of the reference varies.
    """
    entries = judgement.entries
    if entries is None:
        return judgement, share
    reference = answer.part.answer.as_matrix()
    varying_flags = _flag_varying_entries(answer)
    columns = list(zip(*entries, strict=True))
    if answer.part.credit.rule == "columns" and len(columns) > 1:
        # Columns that are zero in the reference don't count.
        are_correct = [all(column) for k, column in enumerate(columns) if any(reference.col(k))]
        share = compute_share_of_columns(are_correct)
        reason = f"{sum(are_correct)} of {len(are_correct)} columns are right; {judgement.reason}"
        judgement = replace(judgement, reason=reason)
    flags = zip(chain.from_iterable(entries), varying_flags, strict=False)
    is_varying_entry_correct = any(is_correct and varies for is_correct, varies in flags)
    if share and any(varying_flags) and not is_varying_entry_correct:
        reason = f"none of the entries that depend on the configuration is right; {judgement.reason}"
        return replace(judgement, reason=reason), Fraction(0)
    return judgement, share


def _flag_varying_entries(answer: AnswerInContext) -> list[bool]:
    """Return for each entry of the reference whether it varies."""
    constants = answer.problem.constants
    entries = answer.part.answer.as_matrix()
    return [any(symbol.name not in constants for symbol in entry.free_symbols) for entry in entries]


# --- correct except for signs or a common factor ---


def _credit_except_factor(answer: AnswerInContext, judgement: Judgement) -> EarnedShare | None:
    """Return the credit for an answer whose wrong entries are all correct except for signs or a common factor.

    The factor is a constant. If the reference is divided by the determinant, the factor may also be the determinant.
    If the expected entries are numbers, only wrong signs earn credit, because any number is correct up to a factor. A
    single nonzero number earns nothing.
    """
    part, parsed, domain, varying_names = answer.part, answer.parsed, answer.domain, answer.varying_names
    reference_entries = [entry for row in part.answer.parse_trees(domain.roles) for entry in row]
    is_numeric = not set().union(*map(find_names, reference_entries)) & varying_names
    if any(parsed.is_blank) or (is_numeric and sum(entry != ZERO for entry in reference_entries) == 1):
        return None
    wrong_indices = list(range(len(reference_entries)))
    if judgement.entries is not None:
        wrong_indices = [k for k, is_correct in enumerate(chain.from_iterable(judgement.entries)) if not is_correct]
    expected_entries = [reference_entries[k] for k in wrong_indices]
    if parsed.table is not None:
        factor = _find_factor_of_values(parsed.table, wrong_indices, expected_entries, answer.problem)
    elif not wrong_indices or answer.has_unknown_symbols or len(parsed.entries) <= max(wrong_indices):
        return None
    else:
        entries = [parsed.entries[k] for k in wrong_indices]
        seed = f"{answer.seed}/factor"
        factor = find_constant_factor(entries, expected_entries, domain, varying_names, seed, part.rounding)
        may_lack_divisor = factor is None and part.credit.covers_known_mistakes
        det = find_determinant_in_denominator(answer.problem.chain, part, domain.roles) if may_lack_divisor else None
        if det is not None:
            expected_entries = [entry * det for entry in expected_entries]
            factor = find_constant_factor(entries, expected_entries, domain, varying_names, seed, part.rounding)
            factor = factor and replace(factor, changes_size=True)  # the missing divisor is a wrong factor
    if factor is None or (factor.changes_size and not set().union(*map(find_names, expected_entries)) & varying_names):
        return None
    is_single = len(wrong_indices) == 1
    sign_words, factor_words = ("one sign", "a factor") if is_single else ("signs", "a common factor")
    words = []
    if factor.is_negative:
        words.append("the sign" if part.shape is None else sign_words)
    if factor.changes_size:
        words.append(factor_words)
    if not words:  # no error was found, which doesn't mean that the answer is correct
        return None
    share = compute_share_up_to_sign_and_factor(factor.is_negative, factor.changes_size)
    verb = "are" if len(words) > 1 or words == ["signs"] else "is"
    return EarnedShare(share, f"only {' and '.join(words)} {verb} wrong")


def _find_factor_of_values(
    table: FunctionValues, entry_indices: Sequence[int], expected: Sequence[Node], problem: Problem
) -> ConstantFactor | None:
    """Return the constant factor between a function's values and the `expected` entries; None if there is none.

    `entry_indices` are the indices of these entries in a row of values. The entries may also differ in their signs. The
    factor is a number, which may be multiplied or divided by lengths.
    """
    count = len(table.values)
    if table.shape is None or not count or not entry_indices or table.values.shape[1] <= max(entry_indices):
        return None
    reference = evaluate(compile_program(list(expected)), table.arguments, count).values
    with np.errstate(all="ignore"):
        ratios = table.values.T[list(entry_indices)] / reference
    sign_differs = ratios[:, 0].real < 0
    ratios = np.where(sign_differs[:, None], -ratios, ratios)
    if not np.all(np.isfinite(ratios)) or not _are_equal(ratios, ratios[0]):
        return None
    is_negative, roles = bool(sign_differs.any()), problem.domain.roles
    lengths = sorted(name for name in problem.constants & set(table.arguments) if isinstance(roles.get(name), str))
    for powers in product((0, 1, -1), repeat=min(len(lengths), MAX_LENGTHS)):
        quotient = ratios[0]
        for name, power in zip(lengths, powers, strict=False):
            quotient = quotient * table.arguments[name] ** power
        if abs(quotient[0]) > RELATIVE_TOLERANCE and _are_equal(quotient, quotient[0]):
            changes_size = any(powers) or bool(abs(abs(quotient[0]) - 1) > RELATIVE_TOLERANCE)
            return ConstantFactor(is_negative, changes_size)
    return None


def _are_equal(values: np.ndarray, other_values: np.ndarray) -> bool:
    """Return whether two arrays are equal up to rounding errors."""
    return np.allclose(values, other_values, rtol=RELATIVE_TOLERANCE, atol=0)


# --- terms of sums ---


def _credit_terms(answer: AnswerInContext, is_copied: IsCopied) -> EarnedShare | None:
    """Return the credit for an answer whose terms are all right except for signs, sines for cosines, or one number.

    Products are marked by their factors instead.
    """
    part, parsed = answer.part, answer.parsed
    if is_product(part) or any(parsed.is_blank) or not _varies_as_expected(answer):
        return None
    comparison = compare_wrong_terms(answer.problem, part, parsed, answer.seed)
    if comparison is None or (parsed.rows is not None and is_copied(part, parsed.rows)):
        return None
    if not (comparison.has_exchanged_trigs or comparison.has_wrong_number):
        is_single_sign = len(comparison.differences) == 1
        return EarnedShare(SHARE_WITH_WRONG_SIGNS, f"only {'one sign is' if is_single_sign else 'signs are'} wrong")
    if not part.credit.covers_known_mistakes:
        return None
    words = "only sines and cosines are exchanged" if comparison.has_exchanged_trigs else "only one number is wrong"
    signs = " and signs are wrong" if comparison.has_exchanged_trigs else " besides signs"
    return EarnedShare(MISTAKE_FACTOR, f"{words}{signs if comparison.has_wrong_signs else ''}")


# --- factors of a product ---


def _credit_factors(answer: AnswerInContext) -> EarnedShare | None:
    """Return the credit for a determinant in which only some of the factors are wrong.

    Only factors that vary count. A wrong factor counts as a missing factor and a surplus factor. The constant factor is
    ignored, because the numbers and lengths in it may belong to a wrong factor.
    """
    part, names = answer.part, frozenset(answer.domain.roles)
    if not is_product(part) or part.credit.rule not in ("", "factors"):
        return None
    if answer.parsed.tree is None or answer.parsed.table is not None or answer.has_unknown_symbols:
        return None
    (reference,) = part.answer.list_entries()
    all_factors = [parse_reference(format_expression(factor), names) for factor in _list_factors(reference)]
    expected_factors = [factor for factor in all_factors if find_names(factor) & answer.varying_names]
    (entry,) = answer.parsed.entries
    typed_factors = [factor for factor in split_factors(entry) if find_names(factor) & answer.varying_names]
    if not typed_factors or max(len(typed_factors), len(expected_factors)) > MAX_FACTORS:
        return None
    counts = range(MAX_WRONG_FACTORS + 1)
    # The numbers of missing and surplus factors, the smallest first. (0, 0) is left out, because the answer is wrong.
    error_counts = sorted(product(counts, counts), key=lambda pair: (max(pair), pair))[1:]
    for missing_count, surplus_count in error_counts:
        share = compute_share_of_product(len(expected_factors), missing_count, surplus_count)
        if share and _have_equal_products(answer, typed_factors, expected_factors, missing_count, surplus_count):
            correct_count = len(expected_factors) - missing_count
            verb = "is" if correct_count == 1 else "are"
            subject = f"{correct_count} of the {len(expected_factors)} factors that depend on the joints {verb}"
            if len(expected_factors) == 1:
                subject = "the factor that depends on the joints is"
            addition = f", but you have {count_noun(surplus_count, 'factor')} too many"
            reason = f"{subject} right{addition if surplus_count > missing_count else ''}"
            return EarnedShare(share, reason)
    return None


def _list_factors(reference: sp.Expr) -> list[sp.Expr]:
    """Return the factors of a product; a factor with a power is repeated."""
    factors_with_powers: list[sp.Expr] = []
    for factor in sp.Mul.make_args(reference):
        base, power = factor.as_base_exp()
        factors_with_powers += [base] * int(power) if power.is_Integer and power > 0 else [factor]
    return factors_with_powers


def _have_equal_products(
    answer: AnswerInContext, factors: Sequence[Node], expected: Sequence[Node], missing_count: int, surplus_count: int
) -> bool:
    """Return whether some factors of an answer and some of the expected ones have equal products, up to a constant.

    `surplus_count` factors of the answer are omitted, and `missing_count` of the expected factors.
    """
    if surplus_count >= len(factors):
        return False
    domain, seed = answer.domain, f"{answer.seed}/factors"
    all_values = evaluate(compile_program([*factors, *expected]), answer.sample("factors"), SAMPLE_COUNT).values
    values, expected_values = all_values[: len(factors)], all_values[len(factors) :]
    subsets = combinations(range(len(factors)), len(factors) - surplus_count)
    expected_subsets = combinations(range(len(expected)), len(expected) - missing_count)
    for indices, expected_indices in product(subsets, expected_subsets):
        with np.errstate(all="ignore"):
            ratio = values[list(indices)].prod(axis=0) / expected_values[list(expected_indices)].prod(axis=0)
        if np.all(np.isfinite(ratio)) and abs(ratio[0]) > 0 and _are_equal(ratio, ratio[0]):
            # Numbers may agree by chance, so the formulas are compared, too.
            product_of_answer = prod((factors[k] for k in indices), start=ONE)
            expected_product = prod((expected[k] for k in expected_indices), start=ONE)
            pair = [product_of_answer], [expected_product]
            is_equal = compare_entries(*pair, domain, f"{seed}/same").is_correct[0]
            if is_equal or find_constant_factor(*pair, domain, answer.varying_names, seed) is not None:
                return True
    return False


# --- numbers ---


def _credit_except_signs(answer: AnswerInContext) -> EarnedShare | None:
    """Return the credit for two or more numbers that are correct except for signs."""
    part, parsed = answer.part, answer.parsed
    if len(parsed.entries) < 2 or any(parsed.is_blank):
        return None
    expected_numbers = np.array([float(value) for value in part.answer.as_matrix()])
    numbers = evaluate(compile_program(list(parsed.entries)), {}, 1).values[:, 0]
    tolerance = np.array(part.answer_as(Number).list_allowed_errors(part.rounding))
    error = np.minimum(np.abs(numbers - expected_numbers), np.abs(numbers + expected_numbers))
    if not np.all(np.isfinite(numbers)) or np.all(np.abs(expected_numbers) <= tolerance) or np.any(error > tolerance):
        return None
    is_single_sign = int((np.abs(numbers - expected_numbers) > tolerance).sum()) == 1
    return EarnedShare(SHARE_WITH_WRONG_SIGNS, f"only {'one sign is' if is_single_sign else 'signs are'} wrong")


# --- one known mistake ---


def _credit_one_mistake(answer: AnswerInContext, is_copied: IsCopied) -> EarnedShare | None:
    """Return the credit for an answer in which a single known mistake explains all wrong entries."""
    part, parsed = answer.part, answer.parsed
    if any(parsed.is_blank) or not (part.answer.is_symbolic or len(part.answer.expected_units) > 1):
        return None
    if not _varies_as_expected(answer) or not is_one_mistake(answer.problem, part, parsed, answer.seed):
        return None
    if parsed.rows is not None and is_copied(part, parsed.rows):
        return None
    return EarnedShare(MISTAKE_FACTOR, "a single mistake explains all your errors")


def _varies_as_expected(answer: AnswerInContext) -> bool:
    """Return whether both an answer in formulas and its reference vary, because a constant may match by chance.

    Return True for all other answers.
    """
    if not answer.part.answer.is_symbolic or answer.parsed.table is not None:
        return True
    if not any(_flag_varying_entries(answer)) or answer.has_unknown_symbols:
        return False
    values = evaluate(compile_program(list(answer.parsed.entries)), answer.sample("moves"), SAMPLE_COUNT).values
    with np.errstate(all="ignore"):
        return bool((np.abs(values - values[:, :1]).max(axis=1) > RELATIVE_TOLERANCE * np.abs(values).max()).any())
