"""Define the three kinds of values that a derivation can have: numbers, SymPy expressions, or formula trees.

A derivation (`derivation.graph`) is written once and works with each kind. A value is a NumPy array. Its first axes are
the rows and columns of a vector or matrix. Its last axes depend on the kind of values, which is called an arithmetic. A
*stepped* value also carries the derivatives with respect to the joint variables, from which a Jacobian is computed.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.formula.algebra import apply_function, differentiate
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import Program, compile_program, evaluate
from qdot.exercises.formula.sympy_text import format_expression
from qdot.exercises.formula.trees import Node

DERIVATIVE_STEP = 1e-30
"""The imaginary step of a joint variable for complex-step derivatives, which are exact up to rounding."""


class NumericArithmetic:
    """The arithmetic of numbers at N configurations; `values` maps the name of each symbol to its N values.

    Arrays end with an axis of N configurations. Stepped arrays end with the axes (N, n + 1) for n joints. The first of
    the n + 1 values is the value itself. In each other value, one joint variable is moved by an imaginary step.
    """

    sin, cos = np.sin, np.cos

    def __init__(self, joints: Sequence[str], values: Mapping[str, np.ndarray]) -> None:
        self.values = {name: np.asarray(value, dtype=float) for name, value in values.items()}
        self.configuration_count = len(next(iter(self.values.values())))
        self._joints = list(joints)
        self._stepped_entries: dict[sp.Expr, np.ndarray] = {}

    def convert_entry(self, expression: sp.Expr) -> np.ndarray:
        """Return the stepped value (N, n + 1) of an entry of the DH table."""
        if expression not in self._stepped_entries:
            names = [symbol.name for symbol in expression.free_symbols]
            stepped = self.evaluate_stepped(compile_expressions(expression), names)[0]
            stepped.flags.writeable = False
            self._stepped_entries[expression] = stepped
        return self._stepped_entries[expression]

    def evaluate_stepped(self, program: Program, names: Iterable[str]) -> np.ndarray:
        """Return the stepped values (…, N, n + 1) of the results of a program; `names` are its symbols."""
        values = {name: self._compute_stepped_values(name).ravel() for name in names}
        shape = (self.configuration_count, len(self._joints) + 1)
        return evaluate(program, values, shape[0] * shape[1]).values.reshape(-1, *shape)

    def _compute_stepped_values(self, name: str) -> np.ndarray:
        """Return the stepped value (N, n + 1) of a symbol."""
        stepped = np.repeat(self.values[name].astype(complex)[:, None], len(self._joints) + 1, axis=1)
        if name in self._joints:
            stepped[:, 1 + self._joints.index(name)] += DERIVATIVE_STEP * 1j
        return stepped

    def get_symbol_value(self, name: str) -> np.ndarray:
        """Return the value of a symbol, (N,)."""
        return self.values[name]

    def make_constant(self, value: sp.Expr) -> np.ndarray:
        """Return a constant, repeated for each configuration, (N,)."""
        return np.full(self.configuration_count, float(value))

    def sqrt(self, square: np.ndarray) -> np.ndarray:
        """Return the square roots; the root of a negative value is nan."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(square))

    def drop_derivatives(self, stepped: np.ndarray) -> np.ndarray:
        """Return the values (…, N) of a stepped array, without the derivatives."""
        return np.asarray(stepped[..., 0].real)

    def compute_derivatives(self, stepped: np.ndarray) -> np.ndarray:
        """Return the derivatives of stepped values with respect to the n joint variables, (n, …, N)."""
        return np.moveaxis(stepped[..., 1:].imag / DERIVATIVE_STEP, -1, 0)


@lru_cache(maxsize=4096)
def compile_expressions(*expressions: sp.Expr) -> Program:
    """Compile expressions that qdot itself produced into one numeric program."""
    return compile_program([parse_formula(str(expression)) for expression in expressions])


class _FormulaArithmetic:
    """The arithmetic of formulas, which need no steps because they can be differentiated.

    Arrays end with an axis of length 1. `apply_function(name, entry)` applies sin, cos or sqrt to a formula.
    `differentiate(joint, entry)` differentiates a formula with respect to the joint variable with that name.
    """

    def __init__(
        self, joints: Sequence[str], apply_function: Callable[[str, Any], Any], differentiate: Callable[[str, Any], Any]
    ) -> None:
        functions = (np.frompyfunc(partial(apply_function, name), 1, 1) for name in ("sin", "cos", "sqrt"))
        self.sin, self.cos, self.sqrt = functions
        self._differentiators = [np.frompyfunc(partial(differentiate, name), 1, 1) for name in joints]

    def drop_derivatives(self, stepped: np.ndarray) -> np.ndarray:
        """Return the array unchanged, because it carries no derivatives."""
        return stepped

    def compute_derivatives(self, stepped: np.ndarray) -> np.ndarray:
        """Return the derivatives of formulas with respect to the n joint variables, (n, …, 1)."""
        return np.stack([differentiate(stepped) for differentiate in self._differentiators])


class SympyArithmetic(_FormulaArithmetic):
    """The arithmetic of SymPy expressions."""

    def __init__(self, joints: Sequence[str]) -> None:
        super().__init__(
            joints, lambda name, entry: getattr(sp, name)(entry), lambda q, entry: sp.diff(entry, sp.Symbol(q))
        )

    def make_constant(self, value: sp.Expr) -> np.ndarray:
        """Return a constant, or any other SymPy expression, as an array (1,)."""
        return np.array([sp.sympify(value)], dtype=object)

    convert_entry = make_constant

    def get_symbol_value(self, name: str) -> np.ndarray:
        """Return the symbol with a name as an array (1,)."""
        return self.make_constant(sp.Symbol(name))


class TreeArithmetic(_FormulaArithmetic):
    """The arithmetic of formula trees, the form in which students' answers are parsed.

    Derivatives raise ParseError if a formula has none.
    """

    def __init__(self, joints: Sequence[str]) -> None:
        super().__init__(joints, apply_function, lambda q, tree: differentiate(tree, q))

    def make_constant(self, value: sp.Expr) -> np.ndarray:
        """Return a constant, or any other SymPy expression, as an array (1,) of trees."""
        return self.stack_trees([parse_formula(format_expression(sp.sympify(value)))])

    convert_entry = make_constant

    def get_symbol_value(self, name: str) -> np.ndarray:
        """Return the symbol with a name as an array (1,) of trees."""
        return self.stack_trees([Node("name", value=name)])

    @staticmethod
    def stack_trees(nodes: Sequence[Node]) -> np.ndarray:
        """Return n trees as an array, (n,)."""
        return np.array(list(nodes), dtype=object)

    @staticmethod
    def stack_rows(rows: Sequence[Sequence[Node]]) -> np.ndarray:
        """Return the rows of a matrix of trees as an array, (rows, columns, 1)."""
        return np.stack([TreeArithmetic.stack_trees(row) for row in rows])[:, :, None]


Arithmetic = NumericArithmetic | SympyArithmetic | TreeArithmetic
"""An arithmetic converts entries of the DH table and symbols to values, and applies functions to values."""


def list_rows(formulas: np.ndarray) -> list[list[Any]]:
    """Return formulas (rows, columns, 1) as rows; a vector (k, 1) becomes k rows, a scalar (1,) one row."""
    entries = formulas[..., 0]
    rows: list[list[Any]] = entries.reshape(len(entries) if entries.ndim else 1, -1).tolist()
    return rows


# --- vectors and matrices along the first array axes ---

MIN_FACTORIZED_ROWS = 5
"""Numeric determinants of matrices with at least this many rows are computed by factorization, others by minors."""


def matrix_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product of matrices (l, m, …) and (m, n, …)."""
    return np.asarray((a[:, :, None] * b[None]).sum(axis=1))


def apply_matrix(a: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return a matrix (m, n, …) times a vector (n, …)."""
    return np.asarray((a * v[None]).sum(axis=1))


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross product a x b of vectors (3, …)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def determinant(a: np.ndarray, sign: int = -1) -> np.ndarray:
    """Return the determinant of a matrix (n, n, …) by minors.

    If `sign` is 1, all terms are added. The result is the permanent, which students get by a common mistake.
    """
    if len(a) >= MIN_FACTORIZED_ROWS and a.dtype != object and sign == -1:
        return np.asarray(np.linalg.det(np.moveaxis(a, -1, 0)))
    minors_by_columns: dict[tuple[int, ...], np.ndarray] = {}

    def minor(columns: tuple[int, ...]) -> np.ndarray:
        row = len(a) - len(columns)
        if len(columns) == 1:
            return np.asarray(a[row, columns[0]])
        if columns not in minors_by_columns:
            minors_by_columns[columns] = sum(
                sign**k * a[row, c] * minor(columns[:k] + columns[k + 1 :]) for k, c in enumerate(columns)
            )
        return minors_by_columns[columns]

    return minor(tuple(range(len(a))))


def minors(a: np.ndarray) -> np.ndarray:
    """Return the matrix of minors, in which entry (i, j) omits row i and column j; 1 for a 1 x 1 matrix."""
    n = len(a)
    if n == 1:
        return np.asarray(a * 0 + 1)
    rows = [[r for r in range(n) if r != i] for i in range(n)]
    if n >= MIN_FACTORIZED_ROWS and a.dtype != object:
        blocks = np.stack([np.stack([a[rows[i]][:, rows[j]] for j in range(n)]) for i in range(n)])
        return np.asarray(np.linalg.det(np.moveaxis(blocks, -1, 2)))
    return np.stack([np.stack([determinant(a[rows[i]][:, rows[j]]) for j in range(n)]) for i in range(n)])


def cofactor_signs(n: int) -> np.ndarray:
    """Return the n x n signs of cofactors: (-1)^(i + j)."""
    return np.asarray((-1) ** np.add.outer(np.arange(n), np.arange(n)))
