"""What an answer earns that is right in part, by the rule of its type (docs/partial-credit.md).

Shares are those of `qdot.exercises.problem.credit`. Lengths and angles of the arm are constants; what else there is
depends on the configuration.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import sympy as sp

from qdot.exercises.answers import Number
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.algebra import ONE, ZERO, factors, times
from qdot.exercises.formula.expression import tree_of_reference
from qdot.exercises.formula.identity import READABLE, Domain, compare_entries
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.scale import Factor, constant_factor
from qdot.exercises.formula.text import text_of
from qdot.exercises.formula.trees import Node, names
from qdot.exercises.problem.credit import (
    HALF,
    MOST_WRONG,
    OWN,
    share_but_for_a_factor,
    share_of_columns,
    share_of_product,
)
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import divisor, is_product
from qdot.grader.diagnosis.diagnosis import is_one_mistake
from qdot.grader.diagnosis.follow_through import IsCopied, nothing_copied
from qdot.grader.judging.answer import ParsedAnswer, Table
from qdot.grader.judging.verdict import Judgement, Outcome

POINTS = 6
MOST_FACTORS = 6
MOST_CONSTANTS = 5
SAME = 1e-9


def credited(
    problem: Problem,
    part: Part,
    judgement: Judgement,
    given: ParsedAnswer,
    seed: str,
    is_copied: IsCopied = nothing_copied,
) -> Judgement:
    """Return a judgement with the share that the assignment gives for an answer that is right in part.

    What is right for somebody else's problem, as `is_copied` tells, is no mistake.
    """
    if judgement.outcome not in (Outcome.WRONG, Outcome.PARTIAL) or given.refusal is not None:
        return judgement
    policy = part.credit or OWN
    if policy.by == "whole" or part.answer.counts_up_to_a_factor:
        return _earning(judgement, Fraction(0))
    share, reason = Fraction(judgement.share).limit_denominator(1000), judgement.reason
    if part.answer.is_formulas and part.shape is not None:
        judgement, share = _of_matrix(problem, part, judgement, share)
    better = None
    if part.answer.is_formulas:
        better = _of_factor(problem, part, given, judgement, seed) or _of_product(problem, part, given, seed)
    elif part.answer.units_due:
        better = _of_numbers(part, given)
    if policy.is_by_mistakes and max(share, better.share if better else 0) < HALF:
        better = _of_one_mistake(problem, part, given, seed, is_copied) or better
    if better is not None and better.share > share:
        share = better.share
        judgement = replace(judgement, reason=f"{better.says}, which earns {share * policy.worth}; {reason}")
    return _earning(judgement, share * policy.worth)


def _earning(judgement: Judgement, share: Fraction) -> Judgement:
    outcome = Outcome.PARTIAL if share > 0 else Outcome.WRONG
    return replace(judgement, outcome=outcome, share=float(share))


@dataclass(frozen=True)
class _Credit:
    """A share, and in words what it is for."""

    share: Fraction
    says: str


# --- matrices ---


def _of_matrix(problem: Problem, part: Part, judgement: Judgement, share: Fraction) -> tuple[Judgement, Fraction]:
    """Count columns where the assignment says so; nothing where no entry is right that depends on the configuration."""
    entries = judgement.entries
    if entries is None:
        return judgement, share
    reference = part.answer.as_matrix()
    varies = _varies(reference, problem.constants)
    columns = list(zip(*entries, strict=True))
    if (part.credit or OWN).by == "columns" and len(columns) > 1:
        counted = [all(column) for k, column in enumerate(columns) if any(reference.col(k))]
        share = share_of_columns(counted)
        judgement = replace(judgement, reason=f"{sum(counted)} of {len(counted)} columns are right; {judgement.reason}")
    said = [same for row in entries for same in row]
    if share and any(varies) and not any(same and moves for same, moves in zip(said, varies, strict=True)):
        reason = f"none of the entries that depend on the configuration is right; {judgement.reason}"
        return replace(judgement, reason=reason), Fraction(0)
    return judgement, share


def _varies(reference: sp.Matrix, constants: AbstractSet[str]) -> list[bool]:
    """Return which entries depend on the configuration or its velocity."""
    return [any(symbol.name not in constants for symbol in entry.free_symbols) for entry in reference]


# --- right but for signs or a common factor ---


def _of_factor(problem: Problem, part: Part, given: ParsedAnswer, judgement: Judgement, seed: str) -> _Credit | None:
    """Return what is earned if all that is wrong is right but for signs, or for a common factor.

    That is a constant, or the determinant in what is divided by it. Of what depends on nothing, signs count only: any
    number would be right but for a factor; and of a single number, nothing would be left.
    """
    domain = problem.domain()
    due = [entry for row in part.answer.trees(domain.roles) for entry in row]
    varying = set(domain.roles) - problem.constants
    is_of_numbers = not set().union(*map(names, due)) & varying
    if any(given.blanks) or (is_of_numbers and sum(entry != ZERO for entry in due) == 1):
        return None
    wrong = list(range(len(due)))
    if judgement.entries is not None:
        wrong = [k for k, same in enumerate(same for row in judgement.entries for same in row) if not same]
    due = [due[k] for k in wrong]
    if given.table is not None:
        factor = _factor_of_values(given.table, wrong, due, domain, problem.constants)
    elif not wrong or given.symbols - set(domain.roles) or len(given.entries) <= max(wrong):
        return None
    else:
        own = [given.entries[k] for k in wrong]
        factor = constant_factor(own, due, domain, varying, f"{seed}/factor", part.rounding)
        is_open = factor is None and (part.credit or OWN).is_by_mistakes
        if is_open and (det := divisor(problem.chain, part, domain.roles)) is not None:
            due = [times(entry, det) for entry in due]
            factor = constant_factor(own, due, domain, varying, f"{seed}/factor", part.rounding)
            factor = factor and replace(factor, is_other=True)
    if factor is None or (factor.is_other and not set().union(*map(names, due)) & varying):
        return None
    signs = "its sign" if part.shape is None else "signs"
    words = [word for word, is_wrong in ((signs, factor.is_negative), ("a common factor", factor.is_other)) if is_wrong]
    if not words:  # nothing is found to be wrong, which is not to say that it is right
        return None
    share = share_but_for_a_factor(factor.is_negative, factor.is_other)
    return _Credit(share, f"right but for {' and '.join(words)}")


def _moved_values(domain: Domain, varying: AbstractSet[str], seed: str) -> dict[str, np.ndarray]:
    """Return configurations of one arm, all constants of which are positive."""
    sampled = domain.sample(set(domain.roles), READABLE + POINTS, Stream(seed))
    return {  # readable ones may be zeros of a factor
        name: column[READABLE:] if name in varying else np.full(POINTS, abs(column[-1]))
        for name, column in sampled.items()
    }


def _factor_of_values(
    table: Table, which: Sequence[int], due: Sequence[Node], domain: Domain, constants: AbstractSet[str]
) -> Factor | None:
    """Return by what number times lengths, or over them, values of a function are off, whatever their signs."""
    count = len(table.values)
    if table.shape is None or not count or not which or table.values.shape[1] <= max(which):
        return None
    reference = evaluate(compile_program(list(due)), table.at, count)[0]
    with np.errstate(all="ignore"):
        ratios = table.values.T[list(which)] / reference
    negative_ones = ratios[:, 0].real < 0
    ratios = np.where(negative_ones[:, None], -ratios, ratios)
    if not np.all(np.isfinite(ratios)) or not np.allclose(ratios, ratios[0], rtol=SAME, atol=0):
        return None
    is_negative = bool(negative_ones.any())
    lengths = sorted(name for name in constants if isinstance(domain.roles.get(name), str) and name in table.at)
    for powers in product((0, 1, -1), repeat=min(len(lengths), MOST_CONSTANTS)):
        left = ratios[0]
        for name, power in zip(lengths, powers, strict=False):
            left = left * table.at[name] ** power
        if abs(left[0]) > SAME and np.allclose(left, left[0], rtol=SAME, atol=0):
            return Factor(is_negative, any(powers) or abs(abs(left[0]) - 1) > SAME)
    return None


# --- factors of a product ---


def _of_product(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> _Credit | None:
    """Return what a determinant earns some of whose factors that depend on the configuration are wrong.

    A factor that is another is lost and too many. Where one is, nobody can tell what belongs to it of the number and
    the lengths before it, and these don't count.
    """
    if not is_product(part) or (part.credit or OWN).by not in ("", "factors"):
        return None
    domain = problem.domain()
    if given.tree is None or given.table is not None or given.symbols - set(domain.roles):
        return None
    varying = set(domain.roles) - problem.constants
    (reference,) = part.answer.entries()
    due = [tree_of_reference(text_of(factor), frozenset(domain.roles)) for factor in _factors(reference)]
    due = [factor for factor in due if names(factor) & varying]
    (answer,) = given.entries
    own = [factor for factor in factors(answer) if names(factor) & varying]
    if not own or max(len(own), len(due)) > MOST_FACTORS:
        return None
    up_to = range(MOST_WRONG + 1)
    ways = sorted(product(up_to, up_to), key=lambda way: (max(way), way))[1:]
    for lost, too_many in ways:
        share = share_of_product(len(due), lost, too_many)
        if share and _is_product_of(own, due, (lost, too_many), domain, varying, f"{seed}/factors"):
            extra = f", and {_counted(too_many, 'other')}" if too_many > lost else ""
            kept = len(due) - lost
            says = f"{kept} of {_counted(len(due), 'factor')} with joints {'is' if kept == 1 else 'are'} there{extra}"
            return _Credit(share, says)
    return None


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _factors(reference: sp.Expr) -> list[sp.Expr]:
    """Return the factors of a product, each as often as its power says."""
    out: list[sp.Expr] = []
    for factor in sp.Mul.make_args(reference):
        base, power = factor.as_base_exp()
        out += [base] * int(power) if power.is_Integer and power > 0 else [factor]
    return out


def _is_product_of(
    own: Sequence[Node], due: Sequence[Node], without: tuple[int, int], domain: Domain, varying: set[str], seed: str
) -> bool:
    """Return whether some of the factors of an answer are some of those that are due, but for a constant factor."""
    evaluated = evaluate(compile_program([*own, *due]), _moved_values(domain, varying, seed), POINTS)[0]
    lost, too_many = without
    ways = product(
        combinations(range(len(own)), len(own) - too_many) if too_many < len(own) else (),
        combinations(range(len(due)), len(due) - lost),
    )
    for kept, chosen in ways:
        with np.errstate(all="ignore"):
            ratio = evaluated[list(kept)].prod(axis=0) / evaluated[[len(own) + k for k in chosen]].prod(axis=0)
        if np.all(np.isfinite(ratio)) and abs(ratio[0]) > 0 and np.allclose(ratio, ratio[0], rtol=SAME, atol=0):
            left, right = (_product([trees[k] for k in some]) for trees, some in ((own, kept), (due, chosen)))
            if _is_same_but_for_a_factor(left, right, domain, varying, seed):
                return True
    return False


def _is_same_but_for_a_factor(left: Node, right: Node, domain: Domain, varying: set[str], seed: str) -> bool:
    same = compare_entries([left], [right], domain, f"{seed}/same").equal[0]
    return same or constant_factor([left], [right], domain, varying, seed) is not None


def _product(trees: Sequence[Node]) -> Node:
    result = ONE
    for tree in trees:
        result = times(result, tree)
    return result


# --- numbers ---


def _of_numbers(part: Part, given: ParsedAnswer) -> _Credit | None:
    """Return what is earned by several numbers with units that are right but for signs."""
    if len(given.entries) < 2 or not all(part.answer.units_due) or any(given.blanks):
        return None
    due = np.array([float(value) for value in part.answer.as_matrix()])
    values = evaluate(compile_program(list(given.entries)), {}, 1)[0][:, 0]
    room = np.array(part.of(Number).room(part.rounding))
    off = np.minimum(np.abs(values - due), np.abs(values + due))
    if not np.all(np.isfinite(values)) or np.all(np.abs(due) <= room) or np.any(off > room):
        return None
    return _Credit(share_but_for_a_factor(is_sign_wrong=True, is_factor_wrong=False), "right but for signs")


# --- one known mistake ---


def _of_one_mistake(
    problem: Problem, part: Part, given: ParsedAnswer, seed: str, is_copied: IsCopied
) -> _Credit | None:
    """Return what is earned where one known mistake gives all that is wrong, however many entries it touches."""
    if any(given.blanks) or not (part.answer.is_formulas or len(part.answer.units_due) > 1):
        return None
    if not _moves_as_due(problem, part, given, seed) or not is_one_mistake(problem, part, given, seed):
        return None
    if given.rows is not None and is_copied(part, given.rows):
        return None
    return _Credit(HALF, "one mistake gives all that is wrong")


def _moves_as_due(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> bool:
    """Tell whether an answer depends on the configuration, as the reference does: constants may be there by chance."""
    domain = problem.domain()
    if not part.answer.is_formulas or given.table is not None:
        return True
    if not any(_varies(part.answer.as_matrix(), problem.constants)) or given.symbols - set(domain.roles):
        return False
    varying = set(domain.roles) - problem.constants
    values = evaluate(compile_program(list(given.entries)), _moved_values(domain, varying, f"{seed}/moves"), POINTS)[0]
    with np.errstate(all="ignore"):
        return bool((np.abs(values - values[:, :1]).max(axis=1) > SAME * np.abs(values).max()).any())
