"""An arm's lengths: numbers in the place of open ones, and all of them left open."""

import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.arm.derivation import structure

_LENGTH = re.compile(r"[ad]\d+|(base|point)_[xyz]")
"""What lengths are called in a structure."""

_MOST, _SAME = 8, 1e-9
"""Of how many lengths sums are looked at, and what counts as nothing, in metres."""


def with_lengths(chain: Chain, values: Mapping[sp.Symbol, sp.Expr]) -> Chain:
    """Return an arm with values, in metres (in radians if angles are open, too), for some of what it leaves open."""

    def put(value: sp.Expr) -> sp.Expr:
        return value.xreplace(values)

    joints = (Joint(one.kind, put(one.theta), put(one.d), put(one.a), put(one.alpha)) for one in chain.joints)
    x, y, z = map(put, chain.base.position)
    base = Base((x, y, z), put(chain.base.yaw), put(chain.base.tilt))
    u, v, w = (sp.expand(put(value)) for value in chain.point.offset)
    tool = chain.tool and replace(chain.tool, offset=(u, v, w))
    return replace(chain, joints=tuple(joints), base=base, tool=tool)


@lru_cache(maxsize=1024)
def with_open_lengths(chain: Chain) -> tuple[Chain, dict[sp.Symbol, sp.Expr]]:
    """Return an arm with symbols for all lengths and without offsets of joints, and the lengths that it has for them.

    Angles are those of the arm.
    """
    general = structure(chain)
    values = {symbol: value for symbol, value in general.values if symbol not in chain.q}
    lengths = {symbol: value for symbol, value in values.items() if _LENGTH.fullmatch(symbol.name)}
    angles = {symbol: value for symbol, value in values.items() if symbol not in lengths}
    return with_lengths(general.chain, angles), lengths


def are_unrelated(lengths: Collection[sp.Expr]) -> bool:
    """Tell whether lengths in metres are neither equal nor sums of others, with any signs: where they are, an arm may
    be singular where others are not, or in another way. Lengths that are not numbers, and many, are not looked at.

    >>> are_unrelated([sp.Rational(1, 2), sp.Rational(2, 5)]), are_unrelated([sp.S(1), sp.S(2), sp.S(3)])
    (True, False)
    """
    if len(lengths) > _MOST or not all(length.is_number for length in lengths):
        return False
    signs = np.array(list(product((0, 1, -1), repeat=len(lengths)))[1:])
    return bool(np.all(np.abs(signs @ np.array([float(length) for length in lengths])) > _SAME))
