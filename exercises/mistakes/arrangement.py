"""Mistakes in writing a result down: rows, columns, signs, rates that are left in or out."""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation_graph import RESULT, Change, Working
from qdot.exercises.mistakes.base import Mistake, Shape, Slip

PLANAR_ROWS = ("vx", "vy", "wz")
"""How a planar arm can move: its other rows are zero."""


def _exchanged(axis: int, i: int, j: int) -> Change:
    def changed(w: Working, found: np.ndarray) -> np.ndarray:
        order = list(range(found.shape[axis]))
        order[i], order[j] = j, i
        return found[order] if axis == 0 else found[:, order]

    return changed


def _negative(axis: int, i: int) -> Change:
    def changed(w: Working, found: np.ndarray) -> np.ndarray:
        out = np.array(found)
        if axis == 0:
            out[i] = -out[i]
        else:
            out[:, i] = -out[:, i]
        return out

    return changed


def _rows_exchanged(chain: Chain, shape: Shape) -> Iterator[Slip]:
    for i, j in combinations(range(shape[0]), 2):
        yield Slip({RESULT: _exchanged(0, i, j)}, {"one": i + 1, "other": j + 1})


def _columns_exchanged(chain: Chain, shape: Shape) -> Iterator[Slip]:
    for i, j in combinations(range(shape[1]), 2):
        yield Slip({RESULT: _exchanged(1, i, j)}, {"one": i + 1, "other": j + 1})


def _reversed_columns(chain: Chain, shape: Shape) -> Iterator[Slip]:
    if shape[1] > 2:
        yield Slip({RESULT: lambda w, found: found[:, ::-1]})


def _transposed(chain: Chain, shape: Shape) -> Iterator[Slip]:
    if min(shape) > 1:
        yield Slip({RESULT: lambda w, found: found.swapaxes(0, 1)})


def _row_sign(chain: Chain, shape: Shape) -> Iterator[Slip]:
    if shape[0] > 1:
        for i in range(shape[0]):
            yield Slip({RESULT: _negative(0, i)}, {"one": i + 1})


def _column_sign(chain: Chain, shape: Shape) -> Iterator[Slip]:
    if shape[1] > 1:
        for i in range(shape[1]):
            yield Slip({RESULT: _negative(1, i)}, {"one": i + 1})


def _sign(chain: Chain, shape: Shape) -> Iterator[Slip]:
    yield Slip({RESULT: lambda w, found: -found})


def _rates_left_in(chain: Chain, shape: Shape) -> Iterator[Slip]:
    if shape[1] == chain.n > 1:
        yield Slip({RESULT: lambda w, found: found * w.symbols(w.chain.rates)[None]})


def _rates_left_out(chain: Chain, shape: Shape) -> Iterator[Slip]:
    def ones(w: Working, rates: np.ndarray) -> np.ndarray:
        return rates * 0 + 1

    yield Slip({"joint rates": ones})


def _rates_exchanged(chain: Chain, shape: Shape) -> Iterator[Slip]:
    for i, j in combinations(range(chain.n), 2):
        yield Slip({"joint rates": _exchanged(0, i, j)}, {"one": i + 1, "other": j + 1})


def _rows(chosen: list[int], of_answer: bool) -> Change:
    def changed(w: Working, found: np.ndarray) -> np.ndarray:
        return (found if of_answer else w["geometric"])[chosen]

    return changed


def _other_rows(chain: Chain, shape: Shape) -> Iterator[Slip]:
    """All six rows, or all three of one kind, where others count; or some where all six are asked for."""
    six = convention_of(chain).velocities
    due = {(6, chain.n): six, (len(chain.task), chain.n): chain.task}.get(shape)
    if due is None:
        return
    of_answer = len(due) == 6
    kinds: list[tuple[str, Sequence[str]]] = [
        ("all six", six), ("the linear", TASK_ROWS[:3]), ("the angular", TASK_ROWS[3:]),
    ]  # fmt: skip
    if of_answer:
        kinds += [("only some", chain.task), ("only some", PLANAR_ROWS)]
    if of_answer and six != TASK_ROWS and len(chain.task) == 6:  # the task's six rows have the other order
        kinds = []
    order = six if of_answer else TASK_ROWS
    for words, rows in kinds:
        if tuple(rows) != tuple(due):
            chosen = [order.index(row) for row in rows]
            yield Slip({RESULT: _rows(chosen, of_answer=of_answer)}, {"rows": words})


MISTAKES = (
    Mistake(
        "transposed", "Transposed", "Rows and columns seem to be exchanged: the matrix is transposed.", "6.4",
        _transposed,
    ),
    Mistake(
        "other-rows", "Rows that the task does not count",
        "The matrix has {rows} rows, and others are asked for: look at which velocities they are.", "6.6",
        _other_rows,
    ),
    Mistake(
        "rows-exchanged", "Rows exchanged", "Rows {one} and {other} seem to be exchanged.", "6.6", _rows_exchanged
    ),
    Mistake(
        "columns-exchanged", "Columns exchanged", "Columns {one} and {other} seem to be exchanged.", "6.4",
        _columns_exchanged,
    ),
    Mistake(
        "columns-reversed", "Columns in reverse order",
        "The columns seem to be in reverse order: column i belongs to joint i.", "6.4", _reversed_columns,
    ),
    Mistake(
        "sign", "Everything with the wrong sign",
        "Everything seems to have the wrong sign.", "6.4", _sign,
    ),
    Mistake("column-sign", "Column with the wrong sign", "Column {one} seems to have the wrong sign.", "6.4",
            _column_sign),
    Mistake("row-sign", "Row with the wrong sign", "Row {one} seems to have the wrong sign.", "6.4", _row_sign),
    Mistake(
        "rates-left-in", "Joint rates left in the Jacobian",
        "The joint rates seem to stand in the Jacobian: it is what they are multiplied by.", "6.4", _rates_left_in,
    ),
    Mistake(
        "rates-left-out", "Joint rates left out",
        "The joint rates seem to be left out: every column is multiplied by its joint's rate.", "6.4",
        _rates_left_out,
    ),
    Mistake(
        "rates-exchanged", "Joint rates exchanged",
        "The rates of joints {one} and {other} seem to be exchanged.", "6.4", _rates_exchanged, rare=True,
    ),
)  # fmt: skip
