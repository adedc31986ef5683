"""Mistakes that only show in numbers: degrees, units, roots that are left out."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import sympy as sp

from exercises.arm.chain import Chain
from exercises.arm.stages import RESULT, Table, Working
from exercises.mistakes.base import Mistake, Shape, Slip


def _degrees_as_radians(chain: Chain, _: Shape) -> Iterator[Slip]:
    def large(w: Working, table: Table) -> Table:
        part = w.arithmetic.stepped(180 / sp.pi)
        rows = (
            replace(row, theta=row.theta * part) if joint.kind == "R" else row
            for row, joint in zip(table.rows, w.chain.joints, strict=True)
        )
        return replace(table, rows=tuple(rows))

    if any(joint.kind == "R" for joint in chain.joints):
        yield Slip({"table": large})
    if any(joint.kind == "R" and offset != 0 for joint, offset in zip(chain.joints, chain.offsets, strict=True)):
        yield Slip({"table": _variables_in_degrees})


def _variables_in_degrees(w: Working, table: Table) -> Table:
    """Put the joint variables in as degrees, beside constants in radians."""
    more = 180 / sp.pi - 1
    for i, (joint, q) in enumerate(zip(w.chain.joints, w.chain.q, strict=True)):
        if joint.kind == "R":
            table = table.with_row(i, theta=table.rows[i].theta + w.arithmetic.stepped(more * q))
    return table


def _times(factor: float) -> Callable[[Chain, Shape], Iterator[Slip]]:
    def slips(chain: Chain, _: Shape) -> Iterator[Slip]:
        yield Slip({RESULT: lambda w, found: found * factor})

    return slips


def _angular(factor: float) -> Callable[[Chain, Shape], Iterator[Slip]]:
    """Return the slip of a factor on what belongs to revolute joints, with an entry for each joint."""

    def slips(chain: Chain, shape: Shape) -> Iterator[Slip]:
        if shape == (chain.n, 1):
            factors = np.array([factor if joint.kind == "R" else 1.0 for joint in chain.joints])
            yield Slip({RESULT: lambda w, found: found * factors[:, None, None]})

    return slips


def _stage(stage: str, change: Callable[[Working, np.ndarray], np.ndarray]) -> Callable[[Chain, Shape], Iterator[Slip]]:
    def slips(chain: Chain, _: Shape) -> Iterator[Slip]:
        yield Slip({stage: change})

    return slips


MISTAKES = (
    Mistake(
        "degrees-as-radians", "Degrees taken for radians",
        "The angles seem to be put into sine and cosine in degrees: they must be turned into radians first.", "6.1",
        _degrees_as_radians,
    ),
    Mistake(
        "rates-in-degrees", "Rates in degrees per second",
        "The rates of revolute joints seem to be in degrees per second: rad/s is asked for.", "6.5",
        _angular(float(180 / np.pi)),
    ),
    Mistake(
        "rates-in-turns", "Rates in revolutions",
        "The rates of revolute joints seem to be in revolutions per second: rad/s is asked for.", "6.5",
        _angular(float(0.5 / np.pi)),
    ),
    Mistake(
        "millimetres", "Millimetres for metres",
        "The result is a thousand times too large: are lengths in millimetres?", "6.4", _times(1000.0),
    ),
    Mistake(
        "thousandth", "A thousandth of the result",
        "The result is a thousand times too small: are lengths in millimetres?", "6.4", _times(0.001),
    ),
    Mistake(
        "centimetres", "Centimetres for metres",
        "The result is a hundred times too large: are lengths in centimetres?", "6.4", _times(100.0),
    ),
    Mistake(
        "root-forgotten", "Root forgotten",
        "The square root of det(J J^T) seems to be forgotten.", "below 6.8",
        _stage("manipulability", lambda w, _: w["gram determinant"]),
    ),
    Mistake(
        "ratio-turned-over", "Ratio the wrong way round",
        "The condition number is the largest singular value over the smallest, so at least 1.", "below 6.8",
        _stage("condition number", lambda w, found: 1 / found),
    ),
    Mistake(
        "eigenvalues-for-singular-values", "Eigenvalues of J J^T for singular values",
        "The eigenvalues of J J^T are the squares of the singular values of J: the root seems to be forgotten.",
        "below 6.8", _stage("condition number", lambda w, found: found**2),
    ),
)  # fmt: skip
