"""Compare an answer term by term with the correct answer (its reference): wrong signs, sines for cosines, numbers.

Both formulas are expanded into sums of products, and like terms are added. Each term of the answer must match a term of
the reference, or differ from it by its sign, by exchanged sines and cosines, or by a numeric factor. This factor must
be the same for all wrong terms. If both formulas are products that contain square roots, their squares are compared.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod

import numpy as np

from qdot.exercises.formula.algebra import expand_terms, split_factors
from qdot.exercises.formula.program import evaluate_trees
from qdot.exercises.formula.trees import ONE, Node, count_nodes
from qdot.exercises.mistakes.configurations import SymbolValues
from qdot.exercises.mistakes.formula_edits import MAX_ENTRY_NODES, MAX_TERMS, exchange_trigs

RELATIVE_TOLERANCE = 1e-9
"""Two values count as equal if they differ by at most this fraction of the larger one."""
MAX_TRIGS_OF_TERM = 4
"""If a term has more sines and cosines than this, either all of them are exchanged or none."""


@dataclass(frozen=True)
class TermDifference:
    """A term of the reference that differs from a term of the answer: in its sign, its trigs, or its number.

    `factor` is the ratio of the answer's term to the expected term; it is 1 if the trigs are exchanged.
    """

    node: Node
    has_wrong_sign: bool = False
    has_exchanged_trigs: bool = False
    factor: float = 1.0


@dataclass(frozen=True)
class TermComparison:
    """All terms of an answer that differ from the reference, each with the index of its entry."""

    differences: tuple[tuple[int, TermDifference], ...]

    @property
    def terms(self) -> list[TermDifference]:
        """The differences of all terms."""
        return [term for _, term in self.differences]

    @property
    def has_wrong_signs(self) -> bool:
        """Whether a sign is wrong."""
        return any(term.has_wrong_sign for term in self.terms)

    @property
    def has_exchanged_trigs(self) -> bool:
        """Whether a sine is in the place of a cosine, or the other way round."""
        return any(term.has_exchanged_trigs for term in self.terms)

    @property
    def has_wrong_number(self) -> bool:
        """Whether a number is wrong."""
        return any(term.factor != 1 for term in self.terms)


@np.errstate(all="ignore")  # an answer may overflow
def compare_terms(
    entries: Sequence[Node], reference: Sequence[Node], wrong_indices: Sequence[int], values: SymbolValues
) -> TermComparison | None:
    """Return how the terms of an answer's wrong entries differ from those of the reference.

    Returns None if a term matches no term of the reference, if numbers are wrong by different factors, or if a number
    is wrong and sines and cosines are exchanged.
    """
    differences: list[tuple[int, TermDifference]] = []
    for index in wrong_indices:
        differences_of_entry = _compare_entry(entries[index], reference[index], values)
        if not differences_of_entry:
            return None
        differences += [(index, difference) for difference in differences_of_entry]
    comparison = TermComparison(tuple(differences))
    factors = [term.factor for term in comparison.terms if term.factor != 1]
    if factors and (comparison.has_exchanged_trigs or not np.allclose(factors, factors[0], rtol=1e-6, atol=0)):
        return None
    return comparison if differences else None


@dataclass(frozen=True)
class _Term:
    """The sum of like terms: the first of them, its values, and the ratio of the sum to it."""

    node: Node
    first_values: np.ndarray
    factor: float = 1.0

    @property
    def values(self) -> np.ndarray:
        """The values of the sum."""
        return self.factor * self.first_values


def _compare_entry(entry: Node, reference: Node, values: SymbolValues) -> list[TermDifference] | None:
    """Return how the terms of an entry differ from those of its reference; None if some terms don't match."""
    if max(count_nodes(entry), count_nodes(reference)) > MAX_ENTRY_NODES:
        return None
    square, expected_square = _square_product_with_root(entry), _square_product_with_root(reference)
    if square is not None and expected_square is not None:
        entry, reference = square, expected_square
    expected_terms = _list_terms(reference, values)
    unmatched_values = _UnmatchedValues(values, [term.values for term in _list_terms(entry, values)])
    if len(unmatched_values.typed_values) != len(expected_terms):
        return None
    unmatched_terms = [term for term in expected_terms if not unmatched_values.take(term.values)]
    differences: list[TermDifference] = []
    # Each kind of variant, the likeliest first, is tried on all terms before the next kind.
    for generate_variants in (_negate, unmatched_values.exchange_trigs, unmatched_values.change_number):
        remaining_terms, unmatched_terms = unmatched_terms, []
        for term in remaining_terms:
            variants = (
                variant for variant, variant_values in generate_variants(term) if unmatched_values.take(variant_values)
            )
            variant = next(variants, None)
            if variant is None:
                unmatched_terms.append(term)
            else:
                differences.append(variant)
    return None if unmatched_terms else differences


def _list_terms(entry: Node, values: SymbolValues) -> list[_Term]:
    """Return the terms of an entry as a sum of products, with like terms added; the entry itself if it has too many."""
    nodes = expand_terms(_write_as_products(entry), MAX_TERMS) or [entry]
    terms: list[_Term] = []
    for node, term_values in zip(nodes, evaluate_formulas(nodes, values), strict=True):
        for k, term in enumerate(terms):
            ratio = _find_constant_ratio(term_values, term.first_values)
            if ratio is not None:
                terms[k] = replace(term, factor=term.factor + ratio)
                break
        else:
            terms.append(_Term(node, term_values))
    return [term for term in terms if abs(term.factor) > RELATIVE_TOLERANCE and term.first_values.any()]


def _square_product_with_root(node: Node) -> Node | None:
    """Return the square of a product with a square root among its factors, to remove it; None for other formulas."""
    factors = split_factors(node)
    if not any(_is_root(factor) for factor in factors):
        return None
    return prod((factor.args[0] if _is_root(factor) else factor * factor for factor in factors), start=ONE)


def _is_root(node: Node) -> bool:
    return node.kind == "call" and node.value == "sqrt"


def _write_as_products(node: Node) -> Node:
    """Return a tree in which powers and quotients are written as products."""
    node = node.with_args([_write_as_products(arg) for arg in node.args])
    return prod(split_factors(node), start=ONE) if node.kind in ("^", "/") else node


_Variants = Iterator[tuple[TermDifference, np.ndarray]]
"""The variants of a term that an answer may contain: how each differs from the term, and its values."""


def _negate(term: _Term) -> _Variants:
    yield TermDifference(term.node, has_wrong_sign=True), -term.values


@dataclass
class _UnmatchedValues:
    """The values of those terms of an answer's entry that are not yet matched with an expected term.

    `values` has the values of all symbols.
    """

    values: SymbolValues
    typed_values: list[np.ndarray]

    def take(self, expected_values: np.ndarray) -> bool:
        """Remove a term with these values; return False if there is none."""
        tolerance = RELATIVE_TOLERANCE * float(np.abs(expected_values).max())
        for k, typed_values in enumerate(self.typed_values):
            if np.abs(typed_values - expected_values).max() <= tolerance:
                del self.typed_values[k]
                return True
        return False

    def exchange_trigs(self, term: _Term) -> _Variants:
        """Yield the term with some of its sines and cosines exchanged, with the right and with the wrong sign."""
        variants = exchange_trigs(term.node, MAX_TRIGS_OF_TERM)
        for variant_values, sign in product(evaluate_formulas(variants, self.values), (1, -1)):
            difference = TermDifference(term.node, has_wrong_sign=sign < 0, has_exchanged_trigs=True)
            yield difference, sign * term.factor * variant_values

    def change_number(self, term: _Term) -> _Variants:
        """Yield the term multiplied by its ratio to each unmatched term of the answer, if this ratio is constant."""
        for typed_values in list(self.typed_values):
            ratio = _find_constant_ratio(typed_values, term.values)
            if ratio is not None:
                yield TermDifference(term.node, has_wrong_sign=ratio < 0, factor=abs(ratio)), ratio * term.values


def _find_constant_ratio(numerator: np.ndarray, denominator: np.ndarray) -> float | None:
    ratios = numerator / denominator
    is_constant = np.isfinite(ratios).all() and np.allclose(ratios, ratios[0], rtol=RELATIVE_TOLERANCE, atol=0)
    return float(ratios[0].real) if is_constant else None


def evaluate_formulas(nodes: Sequence[Node], values: SymbolValues) -> np.ndarray:
    """Return the values of formulas at N configurations, (formulas, N); nan if a value can't be computed."""
    return evaluate_trees(nodes, values, len(next(iter(values.values()))))
