"""Sums gathered by the joint that turns the whole arm: the same values, in fewer products."""

import numpy as np
import pytest
import sympy as sp

from exercises.arm.derivation import derive
from exercises.families import FAMILIES
from exercises.stream import Stream
from exercises.writing.gathering import gathered
from tests.support.problems import drawn

T1, T2, A2, A3, D2, R1, R2, R3 = sp.symbols("theta1 theta2 a2 a3 d2 qd1 qd2 qd3")


def same(first: sp.Expr, second: sp.Expr, seed: str) -> bool:
    symbols = sorted(first.free_symbols | second.free_symbols, key=str)
    stream = Stream(seed)
    values = [[stream.uniform(-2, 2) for _ in symbols] for _ in range(3)]
    here, there = ([float(sp.lambdify(symbols, e)(*each)) for each in values] for e in (first, second))
    return bool(np.allclose(here, there, atol=1e-9))


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        (
            A2 * sp.cos(T1) * sp.cos(T2) + A3 * sp.cos(T1) + D2 * sp.sin(T1),
            (A2 * sp.cos(T2) + A3) * sp.cos(T1) + D2 * sp.sin(T1),
        ),
        (sp.sin(T1) * R2 + sp.sin(T1) * R3, sp.sin(T1) * (R2 + R3)),
        (sp.sin(T1) * R2 - sp.sin(T1) * R3, sp.sin(T1) * (R2 - R3)),
        (A2 * sp.cos(T1) + A3 * sp.cos(T1 + T2), A2 * sp.cos(T1) + A3 * sp.cos(T1 + T2)),  # each link by its own angle
        (sp.cos(T1) * R1 + sp.cos(T1) * A2 * R2, sp.cos(T1) * R1 + sp.cos(T1) * A2 * R2),  # two rates, two coefficients
        (sp.cos(T1) * A2 + D2, sp.cos(T1) * A2 + D2),
    ],
)
def test_what_is_gathered(written: sp.Expr, expected: sp.Expr) -> None:
    assert gathered(sp.expand(written)) == expected


@pytest.mark.families(tuple(FAMILIES), most=8)
def test_values_stay_and_products_become_fewer(family: str) -> None:
    for step in ("chapter", "full"):
        chain = drawn(family, 0, step).chain
        d = derive(chain)
        for entry in (*d.position, *d.jacobian, *d.twist()):
            shorter = gathered(entry)
            assert same(entry, shorter, f"{family} {entry}")
            assert sp.count_ops(shorter) <= sp.count_ops(entry)
