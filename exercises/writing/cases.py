"""Where all maximal minors of a Jacobian that is not square vanish together, case by case, as a person finds it.

What all of them share vanishes first. Then one of the shortest is taken: one of its factors has to vanish, and for each
of these it is seen what is left of the others. All of it is for an arm's structure; numbers are put in later.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.arm.trigonometry import factor_trig
from qdot.exercises.writing.expansion import Expansion, Step, expanded, seen_for_minors

Numbered = tuple[tuple[int, sp.Expr], ...]
"""Minors with their numbers, from 1."""


@dataclass(frozen=True)
class Minors:
    """The matrix that minors are taken of, how it is seen, the minors, and how each is worked out."""

    matrix: sp.Matrix
    step: Step | None
    at_zero: bool
    values: tuple[sp.Expr, ...]
    expansions: tuple[Expansion, ...]


@dataclass(frozen=True)
class Case:
    """A factor that vanishes, what is left of the minors then, and what else has to vanish, each at once."""

    factor: sp.Expr
    left: Numbered
    others: tuple[tuple[sp.Expr, ...], ...]


@dataclass(frozen=True)
class Cases:
    """Factors that all minors share, the number of the minor that is looked at next, and one case for each factor."""

    shared: tuple[sp.Expr, ...]
    pivot: int
    cases: tuple[Case, ...]


def minors_of(chain: Chain) -> Minors:
    """Return the maximal minors of a structure's Jacobian that is not square, and where they come from."""
    matrix, step, at_zero = seen_for_minors(chain)
    size = min(matrix.shape)
    chosen = product(combinations(range(matrix.rows), size), combinations(range(matrix.cols), size))
    parts = [sp.ImmutableMatrix(matrix.extract(list(rows), list(columns))) for rows, columns in chosen]
    expansions = tuple(map(expanded, parts))
    if at_zero:  # seen from the base: rows of a turned base have other minors than those of the world
        values = tuple(factor_trig(sp.expand(expansion.products[-1])).expression() for expansion in expansions)
    else:
        values = tuple(minor.expression() for minor in derive(chain).generic_minors)
    return Minors(matrix, step, at_zero, values, expansions)


def cases_of(chain: Chain, minors: Sequence[sp.Expr]) -> Cases | None:
    """Return how the singular set of a structure follows from its minors; None where it does not in a step or two."""
    components = [component.conditions for component in singular_set(chain) or ()]
    numbered = [(number, minor) for number, minor in enumerate(minors, 1) if minor != 0]
    factors = {number: _factors(minor, chain) for number, minor in numbered}
    shared = [f for f in factors[numbered[0][0]] if all(_among(f, of) for of in factors.values())]
    rest = {number: [f for f in of if not _among(f, shared)] for number, of in factors.items()}
    pivot = min(rest, key=lambda number: (sum(f.is_Add for f in rest[number]), len(rest[number]), number))
    found = [conditions for conditions in components if len(conditions) == 1 and _among(conditions[0], shared)]
    if len(found) != len(shared):
        return None
    cases = []
    for factor in rest[pivot]:
        here = [conditions for conditions in components if conditions not in found and _among(factor, conditions)]
        found += here
        left = ((number, _where_zero(minor, factor)) for number, minor in numbered if number != pivot)
        others = tuple(tuple(c for c in conditions if not _among(c, (factor,))) for conditions in here)
        cases.append(Case(factor, tuple((number, minor) for number, minor in left if minor != 0), others))
    return Cases(tuple(shared), pivot, tuple(cases)) if len(found) == len(components) else None


def _factors(minor: sp.Expr, chain: Chain) -> list[sp.Expr]:
    """Return what of a product may vanish."""
    bases = (factor.as_base_exp()[0] for factor in sp.Mul.make_args(minor))
    return sorted((base for base in bases if base.free_symbols & set(chain.q)), key=sp.default_sort_key)


def _among(factor: sp.Expr, others: Sequence[sp.Expr]) -> bool:
    """Tell whether a factor, or minus it, is one of several."""
    return any(sp.expand(factor - other) == 0 or sp.expand(factor + other) == 0 for other in others)


def _where_zero(minor: sp.Expr, factor: sp.Expr) -> sp.Expr:
    """Return what a minor is where a factor is zero; sines and cosines of sums with a joint in it are taken apart."""
    if any(_among(factor, (f.as_base_exp()[0],)) for f in sp.Mul.make_args(minor)):
        return sp.S.Zero
    if factor.func not in (sp.sin, sp.cos):
        return minor
    (angle,) = factor.args
    sine, cosine = sp.sin(angle), sp.cos(angle)
    apart = {}
    if angle.is_Symbol:
        for atom in minor.atoms(sp.sin, sp.cos):
            beside = atom.args[0] - angle
            if atom.has(angle) and beside != 0 and not beside.has(angle):
                s, c = sp.sin(beside), sp.cos(beside)
                apart[atom] = sine * c + cosine * s if atom.func is sp.sin else cosine * c - sine * s
    there = sp.expand(sp.expand(minor.xreplace(apart)).xreplace({factor: sp.S.Zero}))
    other = cosine if factor == sine else sine
    gathered = factor_trig(there).expression()
    return gathered.replace(lambda e: e.is_Pow and e.base == other and e.exp == 2, lambda _: sp.S.One)
