"""Mistakes in reading a modified table: the row that is named is the row in which the entry stands."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.arm.stages import numbers
from exercises.arm.told import told_base, told_point, told_rows
from exercises.families import FAMILIES
from exercises.generation import sample_chain
from exercises.mistakes.base import Slip
from exercises.mistakes.catalogue import CATALOGUE
from exercises.problem import ProblemId
from exercises.stream import Stream
from tests.support.suites import of_families

FIXED = [name for name, family in FAMILIES.items() if not family.varied]
ENTRIES = {"length-forgotten": "a", "distance-forgotten": "d", "twist-forgotten": "alpha", "twist-sign": "alpha"}
HALF = sp.pi / 2
IN_ROW_1 = Chain("crane", (Joint("R", "theta1", "d1", "a1", HALF), Joint("R", "theta2", 0, "a2", 0)), ("vx", "vz"),
                 convention="modified-dh")  # fmt: skip


def read_wrongly(name: str, slip: Slip, rows: list[Joint]) -> list[Joint]:
    """Return the table as it is told, with the mistake that the words of a slip speak of."""
    words, rows = slip.words, list(rows)
    k = int(str(words["link"] if "link" in words else words["joint"])) - 1
    if name == "lengths-exchanged":
        other = int(str(words["other"])) - 1
        rows[k], rows[other] = replace(rows[k], a=rows[other].a), replace(rows[other], a=rows[k].a)
    elif name == "row-misread":
        entry = str(words["entry"])
        rows[k] = replace(rows[k], **{entry: getattr(rows[int(str(words["other"])) - 1], entry)})
    elif name == "a-and-d-exchanged":
        rows[k] = replace(rows[k], a=rows[k].d, d=rows[k].a)
    else:
        entry = ENTRIES[name]
        changed: dict[str, Any] = {entry: -getattr(rows[k], entry) if name == "twist-sign" else 0}
        rows[k] = replace(rows[k], **changed)
    return rows


def led_to(base: Base, rows: list[Joint], offset: tuple[sp.Expr, ...], known: dict[sp.Symbol, float]) -> np.ndarray:
    """Return where a modified table leads, by Rx Tx Rz Tz row by row."""

    def number(entry: sp.Expr) -> float:
        return float(sp.sympify(entry).subs(known))

    def about(axis: int, angle: float) -> np.ndarray:
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[1, 0, 0], [0, c, -s], [0, s, c]] if axis == 0 else [[c, -s, 0], [s, c, 0], [0, 0, 1]])

    place = np.array([number(value) for value in base.position])
    turn = about(2, number(base.yaw)) @ about(0, number(base.tilt))
    for row in rows:
        place = place + turn @ np.array([number(row.a), 0, 0])
        turn = turn @ about(0, number(row.alpha)) @ about(2, number(row.theta))
        place = place + turn @ np.array([0, 0, number(row.d)])
    return place + turn @ np.array([number(value) for value in offset])


def checked(arm: Chain) -> list[str]:
    """Check every slip of the mistakes in rows on an arm, and return the names of those that there were."""
    stream, found = Stream(f"rows/{arm.name}"), []
    known = {symbol: stream.uniform(0.3, 1.7) for symbol in (*arm.parameters, *arm.q)}
    working = numbers(arm, {symbol.name: np.array([value]) for symbol, value in known.items()})
    for name in (*ENTRIES, "lengths-exchanged", "row-misread", "a-and-d-exchanged"):
        for slip in CATALOGUE[name].slips(arm, (3, 1)):
            if slip.words.get("entry") == "constant of the joint variable":
                continue
            point = told_point(arm)
            rows = read_wrongly(name, slip, told_rows(arm))
            expected = led_to(told_base(arm), rows, point.offset, known)
            made = np.asarray(working.but(slip.changes)["point"])[:, 0]
            assert np.allclose(made, expected, atol=1e-9), (name, slip.words)
            found.append(name)
    return found


@of_families(FIXED)
def test_the_row_that_is_named_is_the_row_as_it_is_told(family: str) -> None:
    arm = sample_chain(ProblemId(family, 3, variation="full", convention="modified-dh"))
    if arm.point.frame != arm.n:
        pytest.skip("the table leads on behind the point")
    assert arm.n == 1 or checked(arm)


@pytest.mark.parametrize(
    "base",
    [
        Base((sp.Symbol("b"), sp.S.Zero, sp.S.Zero), sp.S.Zero, HALF),
        Base((sp.S.One, sp.S(2), sp.S.Zero), sp.pi / 3, HALF),
    ],
)
def test_what_the_first_row_takes_from_the_base_is_in_that_row(base: Base) -> None:
    arm = replace(IN_ROW_1, base=base)
    assert set(checked(arm)) >= {"length-forgotten", "twist-sign", "lengths-exchanged", "row-misread"}
    rows = [slip.words["link"] for slip in CATALOGUE["twist-forgotten"].slips(arm, (3, 1))]
    assert 1 in rows or told_base(arm).tilt != 0
    forgotten = list(CATALOGUE["base-forgotten"].slips(arm, (3, 1)))
    assert len(forgotten) == (0 if told_base(arm).is_world else 1)
