"""Evaluate a wrong answer at some configurations, to compare it there with the answers that mistakes give."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import StageResults, compute_numeric_stages
from qdot.exercises.formula.algebra import Matrix as Rows
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, ParseError, count_decimal_digits
from qdot.exercises.mistakes.configurations import SymbolValues, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step, is_made_of_jacobian
from qdot.grader.diagnosis.numbers import RELATIVE_TOLERANCE, NumericAnswer, Tolerances
from qdot.grader.judging.answer_parser import FunctionValues, ParsedAnswer

SAMPLE_COUNT = 16
"""Number of configurations at which answers are compared, unless the question gives a configuration."""
THREE_DIGITS_TOLERANCE = 5e-3
"""Relative error of numbers that are rounded to three significant digits (1.00 stands for 0.995 to 1.005)."""
MIN_NUMBER_TOLERANCE = 1e-5
"""Minimum relative tolerance of numbers, even if they were typed with many digits."""


@dataclass(frozen=True)
class EvaluatedAnswer:
    """A wrong answer with its values at some configurations, and its formulas as typed, if there are any.

    `symbol_values` has the values of all symbols at the configurations, and `numeric` the values of the answer.
    """

    problem: Problem
    part: Part
    symbol_values: SymbolValues
    numeric: NumericAnswer
    rows: Rows | None = None

    @cached_property
    def correct_stages(self) -> StageResults:
        """The correct derivation, evaluated at the configurations."""
        return compute_numeric_stages(self.problem.chain, self.symbol_values)

    @cached_property
    def correct_values(self) -> np.ndarray:
        """The values of the correct answer, (rows, columns, N), at N configurations."""
        return compute_answer(self.correct_stages, self.part)

    @cached_property
    def is_differentiated(self) -> np.ndarray:
        """For each entry, whether it is found by differentiation, (rows, columns).

        Angular entries are not, and neither are results computed from a Jacobian.
        """
        if is_made_of_jacobian(self.part):
            return np.zeros(self.correct_values.shape[:2], bool)
        # Only entries that are found by differentiation change if the rows of linear velocities are doubled.
        doubled_rows = self.correct_stages.with_mistakes({"linear rows": lambda _, rows: 2 * rows})
        change = np.abs(compute_answer(doubled_rows, self.part) - self.correct_values)
        return np.asarray((change > RELATIVE_TOLERANCE * np.abs(self.correct_values)).any(axis=-1))

    @property
    def has_expected_shape(self) -> bool:
        """Whether the answer has as many rows and columns as the correct answer."""
        return self.numeric.values.shape == self.correct_values.shape

    @property
    def is_correct(self) -> bool:
        """Whether all values are correct within the tolerance."""
        return self.has_expected_shape and bool(self.numeric.match_entries(self.correct_values).all())

    @property
    def is_precise(self) -> bool:
        """Whether the answer can hardly match a mistake by chance, because it is a formula or has precise numbers."""
        return not self.part.answer.is_numeric or self.numeric.is_precise

    def list_wrong_entries(self) -> list[tuple[int, int]]:
        """Return the row and the column of each wrong entry, from 0; blanks don't count as wrong."""
        is_blank = np.isnan(self.numeric.values).any(axis=-1)
        is_wrong = ~self.numeric.match_entries(self.correct_values) & ~is_blank
        return [(int(i), int(j)) for i, j in np.argwhere(is_wrong)]

    def transpose_vector_if_needed(self) -> "EvaluatedAnswer":
        """Return the same answer, transposed if a vector was typed as a row instead of a column, or vice versa."""
        shape, transposed_values = self.correct_values.shape, self.numeric.values.swapaxes(0, 1)
        if 1 not in shape[:2] or self.numeric.values.shape == shape or transposed_values.shape != shape:
            return self
        numeric = replace(self.numeric, values=transposed_values, term_size=self.numeric.term_size.swapaxes(0, 1))
        return replace(self, numeric=numeric, rows=None if self.rows is None else transpose(self.rows))


def evaluate_answer(problem: Problem, part: Part, parsed_answer: ParsedAnswer, seed: str) -> EvaluatedAnswer | None:
    """Evaluate an answer at configurations; None if the part isn't derived step by step or the answer has no values."""
    if not is_derived_step_by_step(part):
        return None
    if parsed_answer.table is not None:
        return _evaluate_function(problem, part, parsed_answer.table)
    values = sample_configurations(problem.chain, part, problem.domain, SAMPLE_COUNT, Stream(f"{seed}/diagnosis"))
    try:
        numeric = _evaluate_entries(part, parsed_answer, values)
    except ParseError:  # a refused answer may contain equations, which have no value
        return None
    return None if numeric is None else EvaluatedAnswer(problem, part, values, numeric, parsed_answer.rows)


def _evaluate_function(problem: Problem, part: Part, table: FunctionValues) -> EvaluatedAnswer | None:
    """Return the wrong answer of a Python function, with the values that the function returned in the sandbox."""
    if table.shape is None or len(table.shape) > 2:
        return None
    values = {name: column[:SAMPLE_COUNT] for name, column in table.arguments.items()}
    rows_and_columns = (*table.shape, 1, 1)[:2]
    outputs = table.values[:SAMPLE_COUNT].T.reshape(*rows_and_columns, -1)
    numeric = NumericAnswer(outputs, np.abs(outputs), _choose_formula_tolerances(part), part.answer.is_direction)
    return EvaluatedAnswer(problem, part, values, numeric)


def _choose_formula_tolerances(part: Part) -> Tolerances:
    """Return the tolerances for formulas: the errors that the assignment allows for decimals, if it allows any."""
    if part.rounding is None:
        return Tolerances(RELATIVE_TOLERANCE, 0.0)
    return Tolerances(max(RELATIVE_TOLERANCE, part.rounding.relative), part.rounding.absolute)


def _evaluate_entries(part: Part, parsed_answer: ParsedAnswer, values: SymbolValues) -> NumericAnswer | None:
    """Return the values of the entries, with nan for blanks.

    Return None if all entries are blank or if a symbol is unknown.
    """
    is_blank, placeholder = parsed_answer.is_blank, Node("name", value="pi")
    if parsed_answer.rows is None or all(is_blank) or parsed_answer.symbols - set(values):
        return None
    pairs = zip(parsed_answer.entries, is_blank, strict=True)
    entries = [placeholder if blank else entry for entry, blank in pairs]
    count = len(next(iter(values.values())))
    entry_values, term_size = evaluate(compile_program(entries), values, count)
    if part.answer.is_numeric:  # large terms in a typed calculation must not widen the tolerance
        term_size = np.abs(entry_values)
    entry_values[is_blank] = np.nan
    shape = (len(parsed_answer.rows), len(parsed_answer.rows[0]), count)
    tolerances = _choose_tolerances(part, entries)
    return NumericAnswer(entry_values.reshape(shape), term_size.reshape(shape), tolerances, part.answer.is_direction)


def _choose_tolerances(part: Part, entries: Sequence[Node]) -> Tolerances:
    """Return the tolerances for an answer.

    The relative tolerance for numbers depends on the required number of digits, or on the number of typed digits if
    that is larger.
    """
    if not part.answer.is_numeric:
        return _choose_formula_tolerances(part)
    digits = max(3, *map(count_decimal_digits, entries))
    allowed_error = (part.rounding.relative if part.rounding else 0.0) or THREE_DIGITS_TOLERANCE
    # 0.6 units of the last digit: rounding changes a number by 0.5 units at most
    rounding_error = 0.6 * 10.0 ** (1 - digits)
    return Tolerances(relative=max(min(allowed_error, rounding_error), MIN_NUMBER_TOLERANCE), absolute=0.0)


def transpose(rows: Rows) -> Rows:
    """Return the rows with rows and columns exchanged."""
    return [list(column) for column in zip(*rows, strict=True)]
