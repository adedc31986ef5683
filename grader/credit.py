"""What an answer earns that is right in part: by entry, by column, by factor of a determinant, by piece of a set."""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations

import numpy as np
import sympy as sp

from exercises.credit import OWN
from exercises.formula.algebra import number, times
from exercises.formula.expression import tree_of_reference
from exercises.formula.identity import READABLE, Domain, compare_entries
from exercises.formula.program import compile_program, evaluate
from exercises.formula.text import text_of
from exercises.formula.trees import Node, names
from exercises.problem import Part, Problem
from exercises.questions.results import is_product
from exercises.stream import Stream
from grader.answer import Given
from grader.verdict import Judgement, Outcome

POINTS = 4
MOST_FACTORS = 6
JOINTS_WEIGH = 2
"""A factor that depends on the joints counts twice: it says where the arm is singular."""


def credited(problem: Problem, part: Part, judgement: Judgement, given: Given, seed: str) -> Judgement:
    """Return a judgement with the share that the assignment gives for an answer that is right in part."""
    if judgement.outcome not in (Outcome.WRONG, Outcome.PARTIAL):
        return judgement
    policy = part.credit or OWN
    if policy.by == "whole":
        return _with_share(judgement, Fraction(0))
    if policy.by == "columns" and part.answer.is_formulas and (part.shape or (1, 1))[1] > 1:
        judgement = _by_columns(part.answer.as_matrix(), judgement)
    elif policy.by in ("", "factors") and is_product(part):
        (reference,) = part.answer.entries()
        judgement = _by_factors(problem, reference, judgement, given, seed)
    return _with_share(judgement, Fraction(judgement.share).limit_denominator(1000) * policy.worth)


def _with_share(judgement: Judgement, share: Fraction) -> Judgement:
    outcome = Outcome.PARTIAL if share > 0 else Outcome.WRONG
    return replace(judgement, outcome=outcome, share=float(share))


def _by_columns(reference: sp.Matrix, judgement: Judgement) -> Judgement:
    """Count the columns in which every entry is right, less those of zeros, which nobody had to work out."""
    if judgement.entries is None:
        return judgement
    columns = list(zip(*judgement.entries, strict=True))
    counted = [all(column) for k, column in enumerate(columns) if any(entry != 0 for entry in reference.col(k))]
    share = Fraction(sum(counted), max(len(counted), 1))
    if all(counted):  # a column of zeros was answered with something else
        share = Fraction(len(counted) - 1, len(counted))
    said = f"{sum(counted)} of {len(counted)} columns are right; {judgement.reason}"
    return replace(_with_share(judgement, share), reason=said)


def _by_factors(problem: Problem, reference: sp.Expr, judgement: Judgement, given: Given, seed: str) -> Judgement:
    """Count the factors of a product that are there, and the number before them, where nothing else is wrong.

    A constant earns nothing where the determinant is none.
    """
    domain = problem.domain()
    coefficient, product = reference.as_coeff_Mul()
    factors = [factor for factor in sp.Mul.make_args(product) if factor.free_symbols]
    if given.refusal is not None or given.tree is None or len(factors) > MOST_FACTORS:
        return judgement
    kept = _kept(given.tree, coefficient, factors, domain, seed)
    if kept is None:
        return judgement
    chosen, is_number_right = kept
    joints = set(problem.chain.q)
    weights = [JOINTS_WEIGH if factor.free_symbols & joints else 1 for factor in factors]
    if max(weights[k] for k in chosen) < max(weights):  # a constant says that no configuration is singular
        return judgement
    share = Fraction(sum(weights[k] for k in chosen) + is_number_right, sum(weights) + 1)
    number_said = "" if is_number_right else "; the sign or the number before them is not"
    said = f"{len(chosen)} of {len(factors)} factors are right{number_said}; {judgement.reason}"
    return replace(_with_share(judgement, share), reason=said)


def _kept(
    node: Node, coefficient: sp.Expr, factors: list[sp.Expr], domain: Domain, seed: str
) -> tuple[tuple[int, ...], bool] | None:
    """Return which factors an answer has, and whether its number is right; None where it is no such product."""
    if names(node) - set(domain.roles):
        return None
    known = frozenset(domain.roles)
    trees = [tree_of_reference(text_of(factor), known) for factor in factors]
    several = domain.sample(set(domain.roles), READABLE + POINTS, Stream(f"{seed}/factors"))
    values = {name: value[READABLE:] for name, value in several.items()}
    evaluated = evaluate(compile_program([node, *trees]), values, POINTS)[0]
    due = complex(coefficient)
    for size in range(len(factors), 0, -1):
        for chosen in combinations(range(len(factors)), size):
            with np.errstate(all="ignore"):
                ratio = evaluated[0] / evaluated[1:][list(chosen)].prod(axis=0)
            if not np.all(np.isfinite(ratio)) or np.ptp(ratio.real) > 1e-9 * abs(ratio[0]) or not abs(ratio[0]) > 1e-9:
                continue
            exact = Fraction(float(ratio[0].real)).limit_denominator(1000)
            product = number(exact)
            for k in chosen:
                product = times(product, trees[k])
            if exact and compare_entries([node], [product], domain, f"{seed}/factors").equal[0]:
                return chosen, abs(ratio[0] - due) <= 1e-9 * abs(due)
    return None
