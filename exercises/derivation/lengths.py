"""Substitute values for an arm's symbols, or replace all lengths of an arm by symbols."""

import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation.derivation import make_symbolic_arm

_LENGTH = re.compile(r"[ad]\d+|(base|point)_[xyz]")
"""The names of the symbols for lengths in a symbolic arm."""

_MAX_LENGTHS, _LENGTH_TOLERANCE = 8, 1e-9
"""Maximum number of lengths whose sums are checked, and the tolerance (m) below which a sum counts as zero."""


def substitute_in_arm(chain: Chain, values: Mapping[sp.Symbol, sp.Expr]) -> Chain:
    """Return an arm with values substituted for some of its symbolic lengths (m) and angles (rad)."""

    def substitute(name: str, entry: sp.Expr) -> sp.Expr:
        value = sp.sympify(entry).xreplace(values)
        return sp.expand(value) if name.startswith("point") else value

    axis_points = tuple(point and tuple(value.xreplace(values) for value in point) for point in chain.axis_points)
    return replace(chain.map_entries(substitute), axis_points=axis_points)


@lru_cache(maxsize=1024)
def replace_lengths_by_symbols(chain: Chain) -> tuple[Chain, dict[sp.Symbol, sp.Expr]]:
    """Return an arm with symbols for all nonzero lengths and without joint offsets, and the length of each symbol.

    Unlike in the symbolic arm, angles keep the arm's values.
    """
    symbolic_arm = make_symbolic_arm(chain)
    values = {symbol: value for symbol, value in symbolic_arm.values if symbol not in chain.q}
    lengths = {symbol: value for symbol, value in values.items() if _LENGTH.fullmatch(symbol.name)}
    angles = {symbol: value for symbol, value in values.items() if symbol not in lengths}
    return substitute_in_arm(symbolic_arm.chain, angles), lengths


def are_unrelated(lengths: Collection[sp.Expr]) -> bool:
    """Return whether no length (m) equals another one, or a sum or difference of other lengths.

    If lengths are related, an arm may have other singular configurations, or singularities of another kind. The result
    is False, without a check, if a length is a symbol or if there are more than eight lengths.

    >>> are_unrelated([sp.Rational(1, 2), sp.Rational(2, 5)]), are_unrelated([sp.S(1), sp.S(2), sp.S(3)])
    (True, False)
    """
    if len(lengths) > _MAX_LENGTHS or not all(length.is_number for length in lengths):
        return False
    signs = np.array(list(product((0, 1, -1), repeat=len(lengths)))[1:])
    return bool(np.all(np.abs(signs @ np.array([float(length) for length in lengths])) > _LENGTH_TOLERANCE))
