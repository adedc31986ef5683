"""Decide whether an answer is correct except for signs and a constant factor, and which of these are wrong.

First, entries of the reference get the signs of the answer's entries. Then the answer must be k times the reference at
every configuration, with a constant k > 0. Let s_i and r_i be the entries of the answer and of the reference with these
signs. Let s'_i and r'_i be the same entries at another configuration with the same constants, and r_p a nonzero entry.
The condition is s_i r'_p = r_i s'_p for all i. It is tested like the equality of an answer and its reference
(`equality`).
"""

from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import READABLE_POINTS, Domain, Rounding, compare_entries
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import ZERO, Node, Nodes, replace_names

EXTRA_POINTS = 6
"""Number of points in addition to those with two decimals. The signs of the entries are found at the last point."""


@dataclass(frozen=True)
class ConstantFactor:
    """The factor between an answer and its reference: whether signs are wrong, and whether its size differs from 1."""

    is_negative: bool
    changes_size: bool


def find_constant_factor(
    entries: Nodes, reference: Nodes, domain: Domain, varying_symbols: AbstractSet[str], seed: str,
    rounding: Rounding | None = None,
) -> ConstantFactor | None:  # fmt: skip
    """Return the constant factor between an answer and its reference, up to signs of entries; None if there is none.

    `varying_symbols` are the symbols that differ between configurations; all other symbols are constants.
    """
    pivot = next((k for k, entry in enumerate(reference) if entry != ZERO), None)
    if pivot is None:
        return None
    samples = domain.sample(set(domain.roles), READABLE_POINTS + EXTRA_POINTS, Stream(seed))
    # all constants are positive, so that a product of constants is not taken for a wrong sign
    values = {name: column if name in varying_symbols else np.abs(column) for name, column in samples.items()}
    entry_values = evaluate(compile_program([*entries, *reference]), values, READABLE_POINTS + EXTRA_POINTS).values
    with np.errstate(all="ignore"):
        ratios = entry_values[: len(reference)] / entry_values[len(reference) :]
    is_negative = ratios[:, -1].real < 0
    signed_reference = [-entry if flips else entry for entry, flips in zip(reference, is_negative, strict=True)]
    if is_negative.any():
        comparison = compare_entries(entries, signed_reference, domain, f"{seed}/sign", rounding)
        if all(comparison.is_correct):
            return ConstantFactor(is_negative=True, changes_size=False)
    # the symbols of the other configuration have a prime
    extended_domain = Domain({**domain.roles, **{f"{name}'": domain.roles[name] for name in varying_symbols}})
    primed_names = {name: Node("name", value=f"{name}'") for name in varying_symbols}
    other_entry, other_reference = (
        replace_names(tree, primed_names) for tree in (entries[pivot], signed_reference[pivot])
    )
    products = [entry * other_reference for entry in entries]
    expected_products = [entry * other_entry for entry in signed_reference]
    if not all(compare_entries(products, expected_products, extended_domain, f"{seed}/moved").is_correct):
        return None
    finite_ratios = ratios[pivot][np.isfinite(ratios[pivot])].real
    if not len(finite_ratios) or not np.all(np.abs(finite_ratios) > 0):
        return None
    return ConstantFactor(is_negative=bool(is_negative.any()), changes_size=True)
