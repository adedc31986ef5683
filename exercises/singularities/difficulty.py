"""Rate how hard an arm is to work through by hand: by a number (the difficulty) and a level from 0 to 4 (hardest)."""

from functools import lru_cache

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import count_written_terms
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.singularities.singular_set import find_singular_set

LEVEL_MINIMUMS = (10, 16, 24, 34)
"""The minimum difficulty of levels 1, 2, 3 and 4."""

HARDEST_LEVEL = len(LEVEL_MINIMUMS)
"""The level of the hardest arms."""


@lru_cache(maxsize=256)
def rate_difficulty(chain: Chain) -> int:
    """Return the difficulty of an arm, the sum of these numbers:

    - the number of terms of J;
    - 4 for each condition of the singular set (if J is square, each factor of det J that can vanish);
    - 8 more for each condition that involves several joints;
    - 1 for each deviation from the chapter's arms: an offset of a joint, a displaced base, a rotated base, and a point
      of interest that is not an origin.

    Example 6.3 has 15 + 8 + 8 = 31.
    """
    factors = {condition for component in find_singular_set(chain) or () for condition in component.conditions}
    joint_counts = [len(factor.free_symbols & set(chain.q)) for factor in factors]
    difficulty_of_conditions = sum(4 + 8 * (joint_count > 1) for joint_count in joint_counts)
    return _count_jacobian_terms(chain) + difficulty_of_conditions + _count_deviations(chain)


def _count_jacobian_terms(chain: Chain) -> int:
    """Return the number of terms of J after its entries are multiplied out."""
    entries = (entry if _is_multiplied_out(entry) else sp.expand(entry) for entry in derive(chain).jacobian)
    return count_written_terms(entries)


def _is_multiplied_out(expression: sp.Expr) -> bool:
    """Return whether an expression is a sum of products of numbers, symbols, sines and cosines of sums of symbols.

    For such an expression, `expand` would take a hundred times as long as this test and change nothing.
    """
    factors = {factor for term in sp.Add.make_args(expression) for factor in sp.Mul.make_args(term)}
    trigs = {factor for factor in factors if isinstance(factor, (sp.sin, sp.cos))}
    # an angle is a sum of rational multiples of these bases
    bases = {term.as_coeff_Mul()[1] for trig in trigs for term in sp.Add.make_args(trig.args[0])}
    return all(factor.is_Symbol or factor.is_Rational for factor in factors - trigs) and all(
        base.is_Symbol or base in (1, sp.pi) for base in bases
    )


def _count_deviations(chain: Chain) -> int:
    """Return the number of deviations from the chapter's arms, as listed in `rate_difficulty`."""
    base = chain.base
    is_rotated = base.yaw != 0 or base.tilt != 0
    return sum([*(offset != 0 for offset in chain.offsets), any(base.position), is_rotated, not chain.point.is_origin])


def rate_difficulty_level(chain: Chain) -> int:
    """Return the level of an arm's difficulty, which is the number of LEVEL_MINIMUMS that the difficulty reaches."""
    # for a hard arm, the singular set is not needed; finding it may take a minute
    if _count_jacobian_terms(chain) + _count_deviations(chain) >= LEVEL_MINIMUMS[-1]:
        return HARDEST_LEVEL
    return sum(rate_difficulty(chain) >= minimum for minimum in LEVEL_MINIMUMS)


def describe_band(low: int, high: int) -> str:
    """Describe a band, which is a range of levels, such as "2" or "1 to 3"."""
    return str(low) if low == high else f"{low} to {high}"
