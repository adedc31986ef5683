"""The quantities of an arm that the formulas of custom questions name, computed from stages in any arithmetic."""

import ast
import operator
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain, is_angle_symbol
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import FRAMES
from qdot.exercises.derivation.arithmetic import (
    NumericArithmetic,
    SympyArithmetic,
    TreeArithmetic,
    apply_matrix,
    matrix_product,
)
from qdot.exercises.derivation.graph import StageResults, compute_convention_rotation
from qdot.exercises.formula import algebra
from qdot.exercises.formula.trees import ZERO, Node, replace_names
from qdot.exercises.problem.problem import list_table_numbers
from qdot.exercises.questions.language import AXES, FormulaError, compute, describe_shape

STAGES_BY_NAME = {
    "p": "point", "J": "jacobian", "Jv": "linear rows", "Jw": "angular rows",
    "qd": "joint rates", "xd": "wanted velocity",
    "det(J)": "determinant", "inv(J)": "inverse", "inv(J) * xd": "required rates",
    "transpose(J)": "transposed jacobian",
    "det(J * transpose(J))": "gram determinant", "sqrt(det(J * transpose(J)))": "manipulability",
}  # fmt: skip
"""Maps formulas, as `ast.unparse` writes them, to the stages of the derivation with their values. The formulas contain
the position p of the tool, the Jacobian J of the task, the linear and angular Jacobians Jv and Jw (3 x n), the joint
rates qd, and the velocity xd in the rows of the task."""

RESULTS: dict[str, Callable[[StageResults], np.ndarray]] = {
    **{name: operator.itemgetter(stage) for name, stage in STAGES_BY_NAME.items()},
    "v": lambda stages: apply_matrix(stages["linear rows"], stages["joint rates"]),
    "w": lambda stages: apply_matrix(stages["angular rows"], stages["joint rates"]),
    "q": lambda stages: stages.stack_symbol_values(stages.chain.q),
    "qdd": lambda stages: stages.stack_symbol_values(name_accelerations(stages.chain)),
    "f": lambda stages: stages.stack_symbol_values(name_load(stages.chain)),
    "least_norm(J, xd)": lambda stages: apply_matrix(stages["pseudo-inverse"], stages["wanted velocity"]),
}
"""Maps each result that formulas may name to a function that computes it. In addition to the stages, these are the
velocity v and angular velocity w of the tool, the joint variables q and accelerations qdd, and the load f, which has a
force or moment for each row of the task."""

SQUARE_RESULTS = ("det(J)", "inv(J)", "inv(J) * xd")
"""The results that only arms with a square Jacobian have."""

_FRAME_NAME = re.compile(r"(?:(o|[xyz])(\d)|([RT])(\d)(\d))")
"""Matches origins and axes of frames, as in o1 and z0, and rotations and transforms between frames, as in R01 and
T02."""

STENCIL = ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
"""Central differences of order eight: for each difference, its number of steps to each side, and its weight."""
STEP = 0.02
"""The usual step (rad or m). The derivatives of an arm's sines and cosines then have errors of about 1e-12."""


def name_load(chain: Chain) -> tuple[str, ...]:
    """Return the names of the components of force and moment in the rows of the task: fx for vx, mx for wx."""
    return tuple(("f" if row[0] == "v" else "m") + row[1] for row in chain.task)


def name_accelerations(chain: Chain) -> tuple[str, ...]:
    """Return the names of the joint accelerations: qdd1, qdd2, …"""
    return tuple(f"qdd{number}" for number in range(1, chain.n + 1))


def has_frames(chain: Chain) -> bool:
    """Return whether the arm's convention gives every link a frame."""
    return FRAMES in convention_of(chain).features


class FrameName(NamedTuple):
    """The letter and the frames in a name such as o1, z0 or R12.

    The letter is o for an origin, and x, y or z for an axis; both frames are then the same. It is R for a rotation and
    T for a transform from the last frame to the first.
    """

    letter: str
    first_frame: int
    last_frame: int


def parse_frame_name(name: str, chain: Chain) -> FrameName | None:
    """Return the letter and the frames in a name such as R12; None for other names.

    Raises FormulaError for frames that the arm does not have.
    """
    match = _FRAME_NAME.fullmatch(name)
    if match is None:
        return None
    if not has_frames(chain):
        raise FormulaError(f"{name!r} needs a DH table, but this arm is described by screw axes")
    axis, frame, matrix, first_frame, last_frame = match.groups()
    frame_name = FrameName(axis or matrix, int(frame or first_frame), int(frame or last_frame))
    if max(frame_name.first_frame, frame_name.last_frame) > chain.n:
        raise FormulaError(f"{name!r}: the frames of this arm have the numbers 0 to {chain.n}")
    return frame_name


_SYMBOL = re.compile(r"(?:theta|alpha|a|d|qd|qdd)\d|[vw][xyz]|[fm][xyz]|pi")
"""Matches names of symbols of arms, of components of loads, and pi."""


def is_result_or_symbol(name: str) -> bool:
    """Return whether a name is a result of a derivation, or a symbol, for some arm.

    >>> [is_result_or_symbol(name) for name in ("p", "o7", "theta1", "speed")]
    [True, True, True, False]
    """
    return name in RESULTS or any(pattern.fullmatch(name) for pattern in (_FRAME_NAME, _SYMBOL))


def is_quantity(formula: ast.expr) -> bool:
    """Return whether a formula is a quantity of an arm, an entry of such a quantity, or the velocity of an origin.

    >>> [is_quantity(ast.parse(text, mode="eval").body) for text in ("v.x", "J[1, 2]", "ddt(o2)", "m*v.x")]
    [True, True, True, False]
    """
    whole = formula  # without the selection of a component or entry
    while isinstance(whole, (ast.Attribute, ast.Subscript)):
        whole = whole.value
    match whole:
        case ast.Call(func=ast.Name(id="ddt"), args=[ast.Name(id=name)]):
            return name == "p" or _FRAME_NAME.fullmatch(name) is not None
    text = ast.unparse(whole)
    return text in RESULTS or _FRAME_NAME.fullmatch(text) is not None


def list_result_names(chain: Chain) -> list[str]:
    """Return the names of all results that a formula on an arm may use."""
    frames = range(chain.n + 1) if has_frames(chain) else ()
    axes = [f"{letter}{frame}" for letter in "oxyz" for frame in frames]
    transforms = [f"{letter}{i}{j}" for letter in "RT" for i in frames for j in frames if i < j]
    return [*(name for name in RESULTS if name.isalpha()), *axes, *transforms]


class StageQuantities(ABC):
    """The quantities of an arm, computed from the stages of a derivation that may contain mistakes.

    `symbols` are the names of all symbols that a formula may use. `numbers` are the numeric lengths in the arm's table,
    by name.
    """

    def __init__(self, stages: StageResults, symbols: frozenset[str], numbers: Mapping[str, sp.Expr]) -> None:
        self.stages, self.symbols, self.numbers = stages, symbols, numbers

    @cached_property
    def names(self) -> tuple[str, ...]:
        """All names that a formula may contain, except those of functions."""
        return (*list_result_names(self.stages.chain), *sorted(self.symbols), *sorted(self.numbers), "pi")

    def look_up(self, name: str) -> np.ndarray | None:
        """Return the value of a name, or of a formula in RESULTS; None if there is none."""
        if name in self.symbols:
            return self.stages.arithmetic.get_symbol_value(name)
        if name in RESULTS:
            is_square = self.stages.chain.has_square_jacobian
            return np.asarray(RESULTS[name](self.stages)) if is_square or name not in SQUARE_RESULTS else None
        if name == "pi" or name in self.numbers:
            return self.stages.arithmetic.make_constant(sp.pi if name == "pi" else self.numbers[name])
        frame = parse_frame_name(name, self.stages.chain)
        return None if frame is None else self._look_up_frame(*frame)

    def _look_up_frame(self, letter: str, first_frame: int, last_frame: int) -> np.ndarray:
        """Return an origin or an axis of a frame, or the rotation or transform from one frame to another."""
        stages = self.stages
        if letter == "o":
            return self._find_origin(first_frame)
        if letter in AXES:
            return compute_convention_rotation(stages, first_frame)[:, AXES[letter]]
        to_first = compute_convention_rotation(stages, first_frame).swapaxes(0, 1)
        rotation = matrix_product(to_first, compute_convention_rotation(stages, last_frame))
        if letter == "R":
            return rotation
        origin = apply_matrix(to_first, self._find_origin(last_frame) - self._find_origin(first_frame))
        upper_rows = np.concatenate([rotation, origin[:, None]], axis=1)
        last_row = np.stack([self.make_constant(Fraction(value)) for value in (0, 0, 0, 1)])
        return np.concatenate([upper_rows, last_row[None]])

    def _find_origin(self, frame: int) -> np.ndarray:
        """Return the origin of a frame of the arm's convention, (3, …)."""
        convention = convention_of(self.stages.chain)
        if not convention.is_proximal:
            return np.asarray(self.stages["origins"][frame])
        if frame:
            return np.asarray(self.stages["origins on axes"][frame - 1])
        position = self.stages.arithmetic.drop_derivatives(self.stages["table"].base_position)
        # A shift along x may belong to the first row of the table; frame 0 is then the world frame.
        return np.asarray(position if any(convention.base.position) else 0 * position)

    def make_constant(self, value: Fraction) -> np.ndarray:
        """Return a number as a value of the arithmetic."""
        return self.stages.arithmetic.make_constant(sp.Rational(value.numerator, value.denominator))

    @property
    def time_rates(self) -> Mapping[str, np.ndarray]:
        """The rates of change of the joint variables and of the joint rates, by name."""
        chain, get_symbol_value = self.stages.chain, self.stages.arithmetic.get_symbol_value
        rates = {q.name: get_symbol_value(rate.name) for q, rate in zip(chain.q, chain.rates, strict=True)}
        accelerations = zip(chain.rates, name_accelerations(chain), strict=True)
        return rates | {rate.name: get_symbol_value(name) for rate, name in accelerations if name in self.symbols}

    @abstractmethod
    def apply(self, function: str, value: np.ndarray) -> np.ndarray:
        """Return a function of each entry."""

    @abstractmethod
    def differentiate(self, formula: ast.expr, rates: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the derivative of a formula while the symbols change at the given rates."""

    @abstractmethod
    def substitute_values(self, formula: ast.expr, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the value of a formula with other values of some symbols."""


class NumericQuantities(StageQuantities):
    """The quantities as numbers at several configurations.

    Derivatives are central differences of order eight. If a mistake changes the unit of length, lengths and rates of
    prismatic joints have the changed unit. Derivatives are taken with respect to the symbols in SI units.
    """

    @cached_property
    def _names_with_length_unit(self) -> set[str]:
        chain = self.stages.chain
        names = {*self.numbers, *(symbol.name for symbol in chain.parameters if not is_angle_symbol(symbol))}
        for i in chain.prismatic_joints:
            names |= {chain.q[i].name, chain.rates[i].name}
        return names

    def look_up(self, name: str) -> np.ndarray | None:
        """Return the value of a name, or of a formula in RESULTS; None if there is none."""
        value = super().look_up(name)
        if value is None or name not in self._names_with_length_unit:
            return value
        return np.asarray(value * self.stages["length unit"])

    def get_si_value(self, name: str) -> np.ndarray:
        """Return the value of a symbol in SI units."""
        return self.stages.arithmetic.get_symbol_value(name)

    def apply(self, function: str, value: np.ndarray) -> np.ndarray:
        """Return a function of each entry; an entry for which it is not defined becomes nan."""
        with np.errstate(all="ignore"):
            return np.asarray(NUMPY_FUNCTIONS[function](value))

    def differentiate(self, formula: ast.expr, rates: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the derivative by central differences."""
        return differentiate_numerically(self, formula, rates, STEP)

    def substitute_values(self, formula: ast.expr, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the value of a formula at other configurations, with the same mistakes in the stages."""
        stages, arithmetic = self.stages, self.stages.arithmetic
        assert isinstance(arithmetic, NumericArithmetic)
        other_arithmetic = NumericArithmetic([q.name for q in stages.chain.q], {**arithmetic.values, **values})
        other_stages = StageResults(stages.chain, other_arithmetic, stages.changes)
        return compute(formula, NumericQuantities(other_stages, self.symbols, self.numbers))


NUMPY_FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "sqrt": np.sqrt, "exp": np.exp, "log": np.log, "abs": np.abs,
}  # fmt: skip


def differentiate_numerically(
    quantities: Any, formula: ast.expr, rates: Mapping[str, np.ndarray], step: float
) -> np.ndarray:
    """Return the derivative of a formula while the symbols change at the given rates, by central differences."""
    derivative: Any = 0
    for step_count, weight in STENCIL:
        for shift in (step_count * step, -step_count * step):
            shifted_values = {name: quantities.get_si_value(name) + shift * rate for name, rate in rates.items()}
            value = quantities.substitute_values(formula, shifted_values)
            derivative = derivative + step_count * weight / shift * value
    return np.asarray(derivative)


class SymbolicQuantities(StageQuantities):
    """The quantities as SymPy expressions."""

    def apply(self, function: str, value: np.ndarray) -> np.ndarray:
        """Return a function of each entry."""
        return self._map_entries(getattr(sp, {"abs": "Abs"}.get(function, function)), value)

    def differentiate(self, formula: ast.expr, rates: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the sum of the partial derivatives, each times its rate."""
        value = compute(formula, self)

        def differentiate(entry: sp.Expr) -> sp.Expr:
            symbols = entry.free_symbols if entry.has(sp.Abs) else ()  # |x| has a derivative only for real x
            real_symbols = {symbol: sp.Symbol(symbol.name, real=True) for symbol in symbols}
            formula_of_reals = entry.xreplace(real_symbols)
            derivatives = (
                (sp.diff(formula_of_reals, real_symbols.get(sp.Symbol(name), sp.Symbol(name))), rate[0])
                for name, rate in rates.items()
            )
            original_symbols = {real_symbol: symbol for symbol, real_symbol in real_symbols.items()}
            return sp.Add(*(derivative.xreplace(original_symbols) * rate for derivative, rate in derivatives))

        return self._map_entries(differentiate, value)

    def substitute_values(self, formula: ast.expr, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the value of a formula in which expressions replace symbols."""
        substitution = {sp.Symbol(name): value[0] for name, value in values.items()}
        return self._map_entries(lambda entry: entry.xreplace(substitution), compute(formula, self))

    @staticmethod
    def _map_entries(function: Callable[[sp.Expr], sp.Expr], value: np.ndarray) -> np.ndarray:
        return np.asarray(np.frompyfunc(lambda entry: function(sp.sympify(entry)), 1, 1)(value))


class TreeQuantities(StageQuantities):
    """The quantities as formula trees, like students' parsed answers."""

    def apply(self, function: str, value: np.ndarray) -> np.ndarray:
        """Return a function of each entry."""
        return self._map_entries(lambda node: algebra.apply_function(function, node), value)

    def differentiate(self, formula: ast.expr, rates: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the sum of the partial derivatives, each times its rate. Raises ParseError if there is none."""

        def differentiate(node: Node) -> Node:
            return sum((algebra.differentiate(node, name) * rate[0] for name, rate in rates.items()), ZERO)

        return self._map_entries(differentiate, compute(formula, self))

    def substitute_values(self, formula: ast.expr, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the value of a formula in which trees replace symbols."""
        trees = {name: value[0] for name, value in values.items()}
        return self._map_entries(lambda node: replace_names(node, trees), compute(formula, self))

    @staticmethod
    def _map_entries(function: Callable[[Node], Node], value: np.ndarray) -> np.ndarray:
        return np.asarray(np.frompyfunc(function, 1, 1)(value))


QUANTITIES: dict[type, type[StageQuantities]] = {
    NumericArithmetic: NumericQuantities, SympyArithmetic: SymbolicQuantities, TreeArithmetic: TreeQuantities,
}  # fmt: skip


def make_quantities(stages: StageResults, symbols: frozenset[str], numbers: Mapping[str, sp.Expr]) -> StageQuantities:
    """Return the quantities that follow from stages, in their arithmetic."""
    return QUANTITIES[type(stages.arithmetic)](stages, symbols, numbers)


def compile_formula(formula: ast.expr, symbols: Sequence[str] = ()) -> Callable[[StageResults], np.ndarray]:
    """Return a function that computes the value of a formula, (…), (rows, …) or (rows, columns, …), from the stages.

    `symbols` are the names of symbols that the arm does not have. The returned function may raise FormulaError.
    """
    if (compute_result := RESULTS.get(ast.unparse(formula))) is not None and not symbols:
        return compute_result

    def compute_value(stages: StageResults) -> np.ndarray:
        chain = stages.chain
        names = frozenset(map(str, (*chain.q, *chain.rates, *chain.parameters, *chain.task, *symbols)))
        return compute(formula, make_quantities(stages, names, list_table_numbers(chain)))

    return compute_value


def select_components(value: np.ndarray, names: Sequence[str]) -> np.ndarray:
    r"""Return the components of a vector that names such as v_x and \omega_{z} select by their last letters.

    If there are no names, or one for each entry, or if the value is a number, the value is returned unchanged. Raises
    FormulaError if the names don't fit the value.
    """
    if not names or value.ndim == 1 or len(names) == len(value):
        return value
    axes = [name.rstrip("}")[-1:] for name in names]
    if value.shape[:-1] != (3,) or not all(axis in AXES for axis in axes):
        expected = "names of components that end in x, y or z" if len(value) == 3 else f"{len(value)} names"
        raise FormulaError(f"rows has {len(names)} names, but the answer is {describe_shape(value)}: write {expected}")
    return value[[AXES[axis] for axis in axes]]
