"""Mistakes in writing a result down: rows, columns, signs, rates left in or out."""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation_graph import RESULT, Change, Working
from qdot.exercises.mistakes.base import Mistake, MistakeVariant, Shape

PLANAR_ROWS = ("vx", "vy", "wz")
"""How a planar arm can move: its other rows are zero."""


def _exchange(axis: int, i: int, j: int) -> Change:
    def apply_change(w: Working, values: np.ndarray) -> np.ndarray:
        order = list(range(values.shape[axis]))
        order[i], order[j] = j, i
        return values[order] if axis == 0 else values[:, order]

    return apply_change


def _negate(axis: int, i: int) -> Change:
    def apply_change(w: Working, values: np.ndarray) -> np.ndarray:
        out = np.array(values)
        if axis == 0:
            out[i] = -out[i]
        else:
            out[:, i] = -out[:, i]
        return out

    return apply_change


def _exchange_rows(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    for i, j in combinations(range(shape[0]), 2):
        yield MistakeVariant({RESULT: _exchange(0, i, j)}, {"one": i + 1, "other": j + 1})


def _exchange_columns(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    for i, j in combinations(range(shape[1]), 2):
        yield MistakeVariant({RESULT: _exchange(1, i, j)}, {"one": i + 1, "other": j + 1})


def _reverse_columns(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    if shape[1] > 2:
        yield MistakeVariant({RESULT: lambda w, values: values[:, ::-1]})


def _transpose(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    if min(shape) > 1:
        yield MistakeVariant({RESULT: lambda w, values: values.swapaxes(0, 1)})


def _flip_row_sign(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    if shape[0] > 1:
        for i in range(shape[0]):
            yield MistakeVariant({RESULT: _negate(0, i)}, {"one": i + 1})


def _flip_column_sign(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    if shape[1] > 1:
        for i in range(shape[1]):
            yield MistakeVariant({RESULT: _negate(1, i)}, {"one": i + 1})


def _flip_sign(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    yield MistakeVariant({RESULT: lambda w, values: -values})


def _keep_rates(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    if shape[1] == chain.n > 1:
        yield MistakeVariant({RESULT: lambda w, values: values * w.symbols(w.chain.rates)[None]})


def _drop_rates(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    def ones(w: Working, rates: np.ndarray) -> np.ndarray:
        return rates * 0 + 1

    yield MistakeVariant({"joint rates": ones})


def _exchange_rates(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    for i, j in combinations(range(chain.n), 2):
        yield MistakeVariant({"joint rates": _exchange(0, i, j)}, {"one": i + 1, "other": j + 1})


def _select_rows(chosen: list[int], of_answer: bool) -> Change:
    def apply_change(w: Working, values: np.ndarray) -> np.ndarray:
        return (values if of_answer else w["geometric"])[chosen]

    return apply_change


def _take_other_rows(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    """Take all six rows, or the three of one kind, instead of the task's; or only some if all six are expected."""
    six = convention_of(chain).velocities
    expected_rows = {(6, chain.n): six, (len(chain.task), chain.n): chain.task}.get(shape)
    if expected_rows is None:
        return
    of_answer = len(expected_rows) == 6
    kinds: list[tuple[str, Sequence[str]]] = [
        ("all six", six), ("the linear", TASK_ROWS[:3]), ("the angular", TASK_ROWS[3:]),
    ]  # fmt: skip
    if of_answer:
        kinds += [("only some", chain.task), ("only some", PLANAR_ROWS)]
    if of_answer and six != TASK_ROWS and len(chain.task) == 6:  # the task's six rows have the other order
        kinds = []
    order = six if of_answer else TASK_ROWS
    for words, rows in kinds:
        if tuple(rows) != tuple(expected_rows):
            chosen = [order.index(row) for row in rows]
            yield MistakeVariant({RESULT: _select_rows(chosen, of_answer=of_answer)}, {"rows": words})


MISTAKES = (
    Mistake(
        "transposed", "Transposed", "Rows and columns seem to be exchanged: the matrix is transposed.", "6.4",
        _transpose,
    ),
    Mistake(
        "other-rows", "Rows that the task does not count",
        "The matrix has {rows} rows, and others are asked for: look at which velocities they are.", "6.6",
        _take_other_rows,
    ),
    Mistake(
        "rows-exchanged", "Rows exchanged", "Rows {one} and {other} seem to be exchanged.", "6.6", _exchange_rows
    ),
    Mistake(
        "columns-exchanged", "Columns exchanged", "Columns {one} and {other} seem to be exchanged.", "6.4",
        _exchange_columns,
    ),
    Mistake(
        "columns-reversed", "Columns in reverse order",
        "The columns seem to be in reverse order: column i belongs to joint i.", "6.4", _reverse_columns,
    ),
    Mistake(
        "sign", "Everything with the wrong sign",
        "Everything seems to have the wrong sign.", "6.4", _flip_sign,
    ),
    Mistake("column-sign", "Column with the wrong sign", "Column {one} seems to have the wrong sign.", "6.4",
            _flip_column_sign),
    Mistake("row-sign", "Row with the wrong sign", "Row {one} seems to have the wrong sign.", "6.4", _flip_row_sign),
    Mistake(
        "rates-left-in", "Joint rates left in the Jacobian",
        "The joint rates seem to stand in the Jacobian: it is what they are multiplied by.", "6.4", _keep_rates,
    ),
    Mistake(
        "rates-left-out", "Joint rates left out",
        "The joint rates seem to be left out: every column is multiplied by its joint's rate.", "6.4",
        _drop_rates,
    ),
    Mistake(
        "rates-exchanged", "Joint rates exchanged",
        "The rates of joints {one} and {other} seem to be exchanged.", "6.4", _exchange_rates, rare=True,
    ),
)  # fmt: skip
