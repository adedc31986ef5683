"""What an answer earns that is right in part, by the rule of its type (docs/partial-credit.md).

Shares are those of `exercises.credit`. What depends on the configuration is told from lengths and angles of the arm,
which are constants.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import sympy as sp

from exercises.answers import Number
from exercises.credit import (
    MOST_WRONG,
    OWN,
    share_but_for_a_factor,
    share_of_columns,
    share_of_product,
)
from exercises.formula.algebra import ONE, ZERO, factors, times
from exercises.formula.expression import tree_of_reference
from exercises.formula.identity import READABLE, Domain, compare_entries
from exercises.formula.program import compile_program, evaluate
from exercises.formula.scale import Factor, constant_factor
from exercises.formula.text import text_of
from exercises.formula.trees import Node, names
from exercises.problem import Part, Problem
from exercises.questions.results import is_product
from exercises.stream import Stream
from grader.answer import Given
from grader.function_values import Table
from grader.verdict import Judgement, Outcome

POINTS = 6
MOST_FACTORS = 6
MOST_CONSTANTS = 5
SAME = 1e-9


def credited(problem: Problem, part: Part, judgement: Judgement, given: Given, seed: str) -> Judgement:
    """Return a judgement with the share that the assignment gives for an answer that is right in part."""
    if judgement.outcome not in (Outcome.WRONG, Outcome.PARTIAL) or given.refusal is not None:
        return judgement
    policy = part.credit or OWN
    if policy.by == "whole" or part.answer.counts_up_to_a_factor:
        return _earning(judgement, Fraction(0))
    share = Fraction(judgement.share).limit_denominator(1000)
    if part.answer.is_formulas:
        if part.shape is not None:
            judgement, share = _of_matrix(problem, part, judgement, share)
        better = _of_whole(problem, part, given, seed) or _of_product(problem, part, given, seed)
    else:
        better = _of_numbers(part, given)
    if better is not None and better.share > share:
        share = better.share
        judgement = replace(judgement, reason=f"{better.says}, which earns {share * policy.worth}; {judgement.reason}")
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


# --- right but for a constant factor ---


def _of_whole(problem: Problem, part: Part, given: Given, seed: str) -> _Credit | None:
    """Return what is earned by an answer that is right but for its sign or a constant factor.

    Of a single number, as a determinant may be, nothing would be left: any number would be right but for a factor.
    """
    domain = problem.domain()
    due = [entry for row in part.answer.trees(domain.roles) for entry in row]
    varying = set(domain.roles) - problem.constants
    if sum(entry != ZERO for entry in due) == 1 and not set().union(*map(names, due)) & varying:
        return None
    if given.table is not None:
        factor = _factor_of_values(given.table, due, domain, problem.constants)
    elif any(given.blanks) or given.symbols - set(domain.roles) or len(given.entries) != len(due):
        return None
    else:
        factor = constant_factor(given.entries, due, domain, varying, f"{seed}/factor", part.rounding)
    if factor is None:
        return None
    words = [word for word, is_wrong in (("its sign", factor.is_negative), ("a constant factor", factor.is_other))
             if is_wrong]  # fmt: skip
    share = share_but_for_a_factor(is_sign_wrong=factor.is_negative, is_constant_wrong=factor.is_other)
    return _Credit(share, f"right but for {' and '.join(words)}")


def _factor_of_values(table: Table, due: Sequence[Node], domain: Domain, constants: AbstractSet[str]) -> Factor | None:
    """Return by what number times lengths, or over them, the values of a function are off."""
    count = len(table.values)
    if table.shape is None or not count or table.values.shape[1] != len(due):
        return None
    reference = evaluate(compile_program(list(due)), table.at, count)[0]
    with np.errstate(all="ignore"):
        ratios = table.values.T / reference
    counted = [k for k, entry in enumerate(due) if entry != ZERO]
    zeros = np.array([table.values.T[k] for k, entry in enumerate(due) if entry == ZERO])
    ratio = ratios[counted[0]] if counted else np.array([np.nan])
    if not np.all(np.isfinite(ratio)) or (zeros.size and np.abs(zeros).max() > SAME):
        return None
    if not all(np.allclose(ratios[k], ratio, rtol=SAME, atol=0) for k in counted):
        return None
    lengths = sorted(name for name in constants if isinstance(domain.roles.get(name), str) and name in table.at)
    for powers in product((0, 1, -1), repeat=min(len(lengths), MOST_CONSTANTS)):
        left = ratio
        for name, power in zip(lengths, powers, strict=False):
            left = left * table.at[name] ** power
        if abs(left[0]) > SAME and np.allclose(left, left[0], rtol=SAME, atol=0):
            return Factor(bool(left[0].real < 0), any(powers) or abs(abs(left[0]) - 1) > SAME)
    return None


# --- factors of a product ---


def _of_product(problem: Problem, part: Part, given: Given, seed: str) -> _Credit | None:
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
        if lost < len(due) and _is_product_of(own, due, (lost, too_many), domain, varying, f"{seed}/factors"):
            extra = f", and {_counted(too_many, 'other')}" if too_many > lost else ""
            kept = len(due) - lost
            says = f"{kept} of {_counted(len(due), 'factor')} with joints {'is' if kept == 1 else 'are'} there{extra}"
            return _Credit(share_of_product(lost, too_many), says)
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
    sampled = domain.sample(set(domain.roles), READABLE + POINTS, Stream(seed))
    values = {  # readable ones may be zeros of a factor
        name: column[READABLE:] if name in varying else np.full(POINTS, column[-1]) for name, column in sampled.items()
    }
    evaluated = evaluate(compile_program([*own, *due]), values, POINTS)[0]
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


def _of_numbers(part: Part, given: Given) -> _Credit | None:
    """Return what is earned by several numbers with units that are right but for the sign of all."""
    if not part.answer.units_due or len(given.entries) < 2 or not all(part.answer.units_due) or any(given.blanks):
        return None
    due = np.array([float(value) for value in part.answer.as_matrix()])
    values = evaluate(compile_program(list(given.entries)), {}, 1)[0][:, 0]
    room = np.array(part.of(Number).room(part.rounding))
    if not np.all(np.isfinite(values)) or np.all(np.abs(due) <= room) or np.any(np.abs(values + due) > room):
        return None
    return _Credit(share_but_for_a_factor(is_sign_wrong=True, is_constant_wrong=False), "right but for the sign of all")
