"""Decide whether an answer is correct except for signs and a constant factor, and which of these are wrong.

Some entries of the reference may change their sign. The answer must then be k times the reference at every
configuration, with a constant k > 0. Let s_i and r_i be the entries of answer and reference (with these signs), and
s'_i and r'_i the same at another configuration with the same constants. Let r_p be a nonzero entry. The condition is
s_i r'_p = r_i s'_p for all i. It is tested like the equality of an answer and its reference (`equality`).
"""

from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import READABLE_POINTS, Domain, Rounding, compare_entries
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import ZERO, Node, Nodes, replace_names

EXTRA_POINTS = 6


@dataclass(frozen=True)
class ConstantFactor:
    """The factor between an answer and its reference: whether signs are wrong, and whether it differs from 1 and -1."""

    is_negative: bool
    changes_size: bool


def find_constant_factor(
    entries: Nodes,
    reference: Nodes,
    domain: Domain,
    varying: AbstractSet[str],
    seed: str,
    rounding: Rounding | None = None,
) -> ConstantFactor | None:
    """Return the constant factor between all entries and the reference, up to signs; None if there is none."""
    pivot = next((k for k, entry in enumerate(reference) if entry != ZERO), None)
    if pivot is None:
        return None
    sampled = domain.sample(set(domain.roles), READABLE_POINTS + EXTRA_POINTS, Stream(seed))
    values = {name: column if name in varying else np.abs(column) for name, column in sampled.items()}
    evaluated = evaluate(compile_program([*entries, *reference]), values, READABLE_POINTS + EXTRA_POINTS)[0]
    with np.errstate(all="ignore"):
        ratios = evaluated[: len(reference)] / evaluated[len(reference) :]
    is_negative = ratios[:, -1].real < 0
    signed = [-entry if minus else entry for entry, minus in zip(reference, is_negative, strict=True)]
    if is_negative.any() and all(compare_entries(entries, signed, domain, f"{seed}/sign", rounding).is_correct):
        return ConstantFactor(is_negative=True, changes_size=False)
    # a prime marks the symbols of the second configuration
    extended_domain = Domain({**domain.roles, **{f"{name}'": domain.roles[name] for name in varying}})
    renamed = {name: Node("name", value=f"{name}'") for name in varying}
    answered, expected = (replace_names(tree, renamed) for tree in (entries[pivot], signed[pivot]))
    products = [entry * expected for entry in entries]
    expected_products = [entry * answered for entry in signed]
    if not all(compare_entries(products, expected_products, extended_domain, f"{seed}/moved").is_correct):
        return None
    finite_ratios = ratios[pivot][np.isfinite(ratios[pivot])].real
    if not len(finite_ratios) or not np.all(np.abs(finite_ratios) > 0):
        return None
    return ConstantFactor(is_negative=bool(is_negative.any()), changes_size=True)
