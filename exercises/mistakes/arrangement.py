"""Mistakes in writing down a finished result: in rows, columns, signs or joint rates."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.derivation.graph import RESULT, StageResults
from qdot.exercises.mistakes import base
from qdot.exercises.mistakes.base import AnswerShape, MistakeVariant, VariantGenerator

PLANAR_ROWS = ("vx", "vy", "wz")
"""The components of velocity that a planar arm can have: the other rows of its Jacobian are zero."""


def _exchange_two(axis: int) -> VariantGenerator:
    """Return a function that yields variants with two rows (axis 0) or columns (axis 1) of the result exchanged."""
    return lambda chain, shape: (
        MistakeVariant({RESULT: base.exchange(i, j, axis)}, words={"one": _name_lines(axis, shape, [i, j])})
        for i, j in combinations(range(shape[axis]), 2)
    )


def _name_lines(axis: int, shape: AnswerShape, indices: Sequence[int]) -> str:
    """Return the name of rows (axis 0) or columns (axis 1) of an answer, such as "row 2", or "entry 2" of a vector."""
    noun = "entry" if shape[1 - axis] == 1 else ("row", "column")[axis]
    return base.name_items(noun, [index + 1 for index in indices])


def _negate_one(axis: int) -> VariantGenerator:
    """Return a function that yields one variant for each row (axis 0) or column (axis 1), with the opposite sign.

    An answer with a single row or column has no such variant.
    """
    return lambda chain, shape: (
        MistakeVariant(  # the index is (i,) for row i, and (slice(None), i) for column i
            {RESULT: base.scale_entries((slice(None),) * axis + (i,), factor=-1)},
            words={"one": _name_lines(axis, shape, [i])},
        )
        for i in (range(shape[axis]) if shape[axis] > 1 else ())
    )


def _change_result(
    change: Callable[[StageResults, np.ndarray], np.ndarray], applies: Callable[[Chain, AnswerShape], bool]
) -> VariantGenerator:
    """Return a function that yields the variant with the finished result changed if `applies` is true."""
    return lambda chain, shape: iter([MistakeVariant({RESULT: change})] if applies(chain, shape) else [])


def _take_other_rows(chain: Chain, shape: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with all six rows of J, or its three linear or angular rows, instead of the task's rows.

    If all six rows are expected, yield variants with only some of them.
    """
    all_rows = convention_of(chain).velocity_names
    expected_rows = {(6, chain.n): all_rows, (len(chain.task), chain.n): chain.task}.get(shape)
    # six rows may be expected in the order of the task or of a twist, and the shape does not show which
    has_ambiguous_order = len(chain.task) == 6 and all_rows != VELOCITY_NAMES
    if expected_rows is None or has_ambiguous_order:
        return
    expects_all_rows = len(expected_rows) == 6

    def select_rows(stages: StageResults, values: np.ndarray, row_indices: list[int]) -> np.ndarray:
        return (values if expects_all_rows else stages["geometric jacobian"])[row_indices]

    row_choices: list[tuple[str, Sequence[str]]] = [
        ("all six", all_rows), ("the linear", VELOCITY_NAMES[:3]), ("the angular", VELOCITY_NAMES[3:]),
    ]  # fmt: skip
    if expects_all_rows:
        row_choices += [("only some", chain.task), ("only some", PLANAR_ROWS)]

    order = all_rows if expects_all_rows else VELOCITY_NAMES
    for words, rows in row_choices:
        if tuple(rows) != tuple(expected_rows):
            change = partial(select_rows, row_indices=[order.index(row) for row in rows])
            yield MistakeVariant({RESULT: change}, words={"rows": words})


VARIANTS: dict[str, VariantGenerator] = {
    "transposed": _change_result(lambda stages, values: values.swapaxes(0, 1), lambda chain, shape: min(shape) > 1),
    "other-rows": _take_other_rows,
    "rows-exchanged": _exchange_two(axis=0),
    "columns-exchanged": _exchange_two(axis=1),
    "columns-reversed": _change_result(lambda stages, values: values[:, ::-1], lambda chain, shape: shape[1] > 2),
    "sign": base.vary_always({RESULT: lambda stages, values: -values}),
    "column-sign": _negate_one(axis=1),
    "row-sign": _negate_one(axis=0),
    "rates-left-in": _change_result(
        lambda stages, values: values * stages.stack_symbol_values(stages.chain.rates)[None],
        lambda chain, shape: shape[1] == chain.n > 1,
    ),
    "rates-left-out": base.vary_always({"joint rates": lambda stages, rates: rates * 0 + 1}),
    "rates-exchanged": lambda chain, _: (
        MistakeVariant({"joint rates": base.exchange(i, j)}, words={"one": i + 1, "other": j + 1})
        for i, j in combinations(range(chain.n), 2)
    ),
}
