"""Compare sets of configurations that are given by conditions, such as "theta3 = 0 or pi, or a1 + a2*c2 + a3*c23 = 0".

A set is a union of pieces (`set_parser`). Random configurations are moved onto each piece of one set by Gauss-Newton
steps. The sets are equal if the other set contains these configurations, and vice versa. A configuration consists of
the joint values, in rad and m.
"""

import warnings
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import mpmath
import numpy as np

from qdot.exercises.common.stream import Stream
from qdot.exercises.formula import set_parser
from qdot.exercises.formula.equality import DOUBLE_TOLERANCE, Domain, Rounding, round_to_six_digits
from qdot.exercises.formula.program import (
    PRECISE_DIGITS,
    Program,
    compile_program,
    evaluate,
    evaluate_constant,
    evaluate_precisely,
)
from qdot.exercises.formula.set_parser import Atom, Piece
from qdot.exercises.formula.trees import Node, find_names

SAMPLE_COUNT = 50
"""The number of random configurations that are tried on each piece."""
ROUNDED_JOINT_VALUE = Rounding(absolute=5e-3)
"""A joint value that differs by less (in rad or m) from an expected value counts as the expected value, rounded."""
TYPED_TOLERANCE = 1e-9
"""Tolerance (in rad or m) for joint values that a student typed."""
SEARCH_TOLERANCE = 1e-7
"""Tolerance (in rad or m) for configurations that a search found. Rounding shifts a double zero, such as that of
|cos| - 1, by 2e-8."""

_STOP_STEP, _CONVERGED_STEP, _CONVERGED_RESIDUAL = 1e-10, 1e-5, 1e-9
"""A search stops if its steps (in rad or m) are below the first limit.

It has converged if its last step is below the second limit, and its residual, relative to its terms, below the third.
"""

_POLISHED_STEP = 1e-8
"""A search for a zero of the gradient has converged if its last step is below this limit."""

_MAX_STEPS, _MAX_STEP = 120, 0.7
"""Maximum number of steps of a search, and maximum step of a joint (in rad or m)."""
_MAX_POLISHING_STEPS, _MAX_POLISHING_STEP, _GRADIENT_STEP = 8, 0.05, 1e-5
"""The search for a zero of the gradient: maximum number of steps, maximum step of a joint, and step of finite
differences."""
_FLAT_GRADIENT = 1e-2
"""If the gradient is smaller, relative to the terms, the configuration may be near a double zero."""
_NEAR_MISS_RESIDUAL = 1e-3
"""If the relative residual is smaller, the conditions may have a zero that the search did not find."""
_MAX_STORED_VALUES, _MAX_RESIDUAL_SAMPLES = 5_000_000, 4000
"""Maximum number of values stored at once, and of random configurations at which residuals are compared. A program of
more than 1,250 steps is evaluated at fewer of them.
"""
_TINY = 1e-300
"""A divisor that replaces zero."""

Configurations = Mapping[str, np.ndarray]
"""For the name of each joint and of each other symbol, an array with one value for each configuration."""


class _Residuals(NamedTuple):
    """The values of expressions (nan if they are not real), and the sizes of their terms.

    Both have the shape (expressions, configurations).
    """

    values: np.ndarray
    sizes: np.ndarray


@dataclass(frozen=True)
class _CompiledPiece:
    """A piece as programs, for a search that moves configurations onto the piece.

    - `assignments` are the joints that have a value in the piece, each with the program that computes the value.
    - `residual_program` is the program that computes the expressions that vanish on the piece.
    - `free_joints` are the joints that the search moves.
    """

    assignments: list[tuple[str, Program]]
    residual_program: Program
    free_joints: list[str]

    def assign_joints(self, values: dict[str, np.ndarray]) -> np.ndarray:
        """Set the joints that have assigned values; return for each configuration whether these values are real."""
        is_valid = np.ones(_count_configurations(values), dtype=bool)
        for joint, program in self.assignments:
            joint_values = evaluate(program, values, len(is_valid)).values[0]
            is_valid &= np.isfinite(joint_values) & (np.abs(joint_values.imag) < SEARCH_TOLERANCE)
            values[joint] = np.where(is_valid, joint_values.real, 0.0)
        return is_valid

    def compute_residuals(self, values: Configurations) -> _Residuals:
        """Return the values, at configurations, of the expressions that vanish on the piece."""
        complex_values, sizes = evaluate(self.residual_program, values, _count_configurations(values))
        is_real = np.abs(complex_values.imag) < SEARCH_TOLERANCE
        return _Residuals(np.where(is_real, complex_values.real, np.nan), sizes)

    def compute_derivatives(self, values: Configurations, squares_residuals: bool = False) -> np.ndarray:
        """Return the derivatives (configurations, expressions, joints) by central differences of the free joints.

        If `squares_residuals`, the expressions are squared first: sqrt(x^2) has no derivative at its zero, but x^2 has.
        """
        step = 1e-6  # rad or m
        shifts = [(joint, sign * step) for sign in (1, -1) for joint in self.free_joints]
        shifted_residuals = self.compute_residuals(_shift_joints(values, shifts)).values
        shifted_residuals = shifted_residuals.reshape(-1, 2, len(self.free_joints), _count_configurations(values))
        shifted_residuals = shifted_residuals**2 if squares_residuals else shifted_residuals
        return np.asarray((shifted_residuals[:, 0] - shifted_residuals[:, 1]).transpose(2, 0, 1) / (2 * step))

    def project_onto_zeros(self, values: dict[str, np.ndarray]) -> np.ndarray:
        """Move the free joints onto the zeros by minimum-norm Gauss-Newton steps.

        Return for each configuration whether its search converged. A search stops when the steps, not the residuals,
        are tiny, because sin(theta)^2 is only 1e-14 at a distance of 1e-7 from its double zero. If no search
        converges, as for sqrt(s1^2 + s2^2), all searches are repeated with the squares of the expressions.
        """
        start_values = {joint: values[joint].copy() for joint in self.free_joints}
        is_converged = self._search_zeros(values, squares_residuals=False)
        if self.free_joints and not is_converged.any():
            values.update({joint: column.copy() for joint, column in start_values.items()})
            is_converged = self._search_zeros(values, squares_residuals=True)
        return is_converged

    def _subtract_steps(self, values: dict[str, np.ndarray], steps: np.ndarray) -> None:
        """Subtract steps (configurations, joints) from the values of the free joints."""
        for k, joint in enumerate(self.free_joints):
            values[joint] = values[joint] - steps[:, k]

    def _search_zeros(self, values: dict[str, np.ndarray], squares_residuals: bool) -> np.ndarray:
        """Move the free joints until they converge; return for each configuration whether its search converged."""
        last_steps = np.full(_count_configurations(values), np.inf)
        # Use the sizes at the random start: near a zero, terms may be small, such as the only term of sin(theta).
        start_residuals, start_sizes = self.compute_residuals(values)
        typical_sizes = _reduce_without_warning(np.nanmedian, start_sizes)
        # A rounding error at every random start is no zero to move to: sin(pi)*sin(theta1) vanishes everywhere.
        varies = ~np.all(np.abs(start_residuals) <= 1e-15 * start_sizes, axis=1)
        for _ in range(_MAX_STEPS):
            residual = self.compute_residuals(values).values * varies[:, None]
            if not self.free_joints or np.all((last_steps < _STOP_STEP) | ~np.isfinite(residual).all(axis=0)):
                break
            derivatives = self.compute_derivatives(values, squares_residuals) * varies[:, None]
            if squares_residuals:
                residual = residual**2
            is_finite = np.isfinite(derivatives).all(axis=(1, 2)) & np.isfinite(residual).all(axis=0)
            derivatives[~is_finite] = 0.0
            steps = _compute_minimum_norm_steps(derivatives, np.where(is_finite, residual, 0.0))
            largest_change = np.maximum(np.abs(steps).max(axis=1, keepdims=True), _TINY)
            steps *= np.minimum(1.0, _MAX_STEP / largest_change)
            last_steps = np.where(is_finite, np.abs(steps).max(axis=1), np.inf)
            self._subtract_steps(values, steps)
        if not squares_residuals:
            last_steps = np.minimum(last_steps, self._polish(values, typical_sizes[0]))
        residual, _ = self.compute_residuals(values)
        # a zero of a square is a double zero, and only half of its digits can be found
        largest_residual = 1e-7 if squares_residuals else _CONVERGED_RESIDUAL
        with np.errstate(all="ignore"):
            is_near = np.all(np.abs(residual) <= largest_residual * typical_sizes, axis=0)
        return np.asarray(is_near & ((last_steps < _CONVERGED_STEP) | (not self.free_joints)))

    def _polish(self, values: dict[str, np.ndarray], typical_size: np.ndarray) -> np.ndarray:
        """Move configurations near a double zero, such as those of det(J J^T), to a zero of the gradient.

        Return the size of each configuration's last step; inf if the configuration was not moved. Near a double zero,
        the expression determines only half of the configuration's digits. The gradient, computed by complex steps,
        determines almost all digits. It does not exist for functions with branches. A configuration that doesn't
        improve is restored, because large terms that cancel can make a gradient look small.
        """
        count, joint_count = _count_configurations(values), len(self.free_joints)
        last_steps = np.full(count, np.inf)
        if len(self.residual_program.outputs) != 1 or self.residual_program.has_branches or not self.free_joints:
            return last_steps
        start_values = {joint: values[joint].copy() for joint in self.free_joints}
        start_residual = np.abs(self.compute_residuals(values).values[0])
        for _ in range(_MAX_POLISHING_STEPS):
            gradient = self._compute_gradient(values)
            is_flat = np.linalg.norm(gradient, axis=1) < _FLAT_GRADIENT * typical_size
            if not is_flat.any():  # no configuration moves, now or later
                last_steps = np.full(count, np.inf)
                break
            hessian = np.empty((count, joint_count, joint_count))
            for k, joint in enumerate(self.free_joints):
                forward_gradient, backward_gradient = (
                    self._compute_gradient({**values, joint: values[joint] + shift})
                    for shift in (_GRADIENT_STEP, -_GRADIENT_STEP)
                )
                hessian[:, :, k] = (forward_gradient - backward_gradient) / (2 * _GRADIENT_STEP)
            is_valid = is_flat & np.isfinite(hessian).all(axis=(1, 2))
            hessian[~is_valid] = 0.0
            # the pseudoinverse ignores directions without curvature, in which the zeros continue
            steps = np.einsum("pij,pj->pi", np.linalg.pinv(hessian, rcond=1e-7), gradient)
            steps = np.where(is_valid[:, None], np.clip(steps, -_MAX_POLISHING_STEP, _MAX_POLISHING_STEP), 0.0)
            last_steps = np.where(is_valid, np.abs(steps).max(axis=1), np.inf)
            self._subtract_steps(values, steps)
        with np.errstate(all="ignore"):
            is_improved = np.abs(self.compute_residuals(values).values[0]) <= start_residual + 1e-15 * typical_size
            is_polished = (last_steps < _POLISHED_STEP) & is_improved
        for joint, column in start_values.items():
            values[joint] = np.where(is_polished, values[joint], column)
        return np.where(is_polished, last_steps, np.inf)

    def _compute_gradient(self, values: Configurations) -> np.ndarray:
        """Return the gradient of the piece's single expression, (configurations, joints), without loss of digits.

        The complex-step derivative Im f(x + ih) / h contains no difference, so no digits cancel.
        """
        stepped_values = _shift_joints(values, [(joint, 1e-20j) for joint in self.free_joints])
        complex_residuals, _ = evaluate(self.residual_program, stepped_values, _count_configurations(stepped_values))
        gradient = complex_residuals[0].imag.reshape(len(self.free_joints), -1).T / 1e-20
        return np.where(np.isfinite(gradient), gradient, 0.0)

    def is_zero(self, values: Configurations, tolerance: float) -> np.ndarray:
        """Return for each configuration whether it is a zero of the piece's single expression f.

        The distance to a zero is estimated by |f| / |grad f|, and must be within the tolerance. At a multiple zero the
        gradient vanishes, too; there |f| itself must be as small as a rounding error.
        """
        residual = np.abs(self.compute_residuals(values).values[0])
        if not self.free_joints:
            return np.asarray(residual <= 0.0)
        gradient_norm = np.linalg.norm(self.compute_derivatives(values)[:, 0], axis=1)
        with np.errstate(all="ignore"):
            rounding_error = 1e-14 * self._compute_typical_term_size(values)
            return np.asarray((residual <= tolerance * gradient_norm) | (residual <= rounding_error))

    def _compute_typical_term_size(self, values: Configurations) -> float:
        """Return the median size of the expression's terms at random configurations; at a zero, terms may vanish."""
        stream, count = Stream("typical"), _count_configurations(values)
        random_values = {q: np.array([stream.uniform(-3, 3) for _ in range(count)]) for q in self.free_joints}
        sizes = self.compute_residuals({**values, **random_values}).sizes
        return float(_reduce_without_warning(np.nanmedian, sizes[:1])[0, 0])


def _compile_piece(piece: Piece, joints: Sequence[str], angles: Collection[str]) -> _CompiledPiece:
    """Compile a piece; it assigns constant joint values first, then values that depend on other joints.

    A tied joint (`is_tied`) can't be assigned its value. Instead, one more expression vanishes: joint - value or, if
    the joint is one of the `angles`, the sine of half this difference.
    """
    tied_atoms = [atom for atom in piece if atom.joint is not None and set_parser.is_tied(atom, piece, joints)]
    untied_atoms = [atom for atom in piece if atom.joint is not None and atom not in tied_atoms]
    untied_atoms.sort(key=lambda atom: bool(find_names(atom.expression) & set(joints)))
    vanishing_expressions = [atom.expression for atom in piece if atom.joint is None]
    for atom in tied_atoms:
        difference = Node("-", (Node("name", value=atom.joint), atom.expression))
        vanishing_expressions.append(set_parser.make_half_sine(difference) if atom.joint in angles else difference)
    free_names = set().union(*map(find_names, vanishing_expressions)) - {atom.joint for atom in untied_atoms}
    assignments = [(str(atom.joint), compile_program([atom.expression])) for atom in untied_atoms]
    free_joints = [joint for joint in joints if joint in free_names]
    return _CompiledPiece(assignments, compile_program(vanishing_expressions), free_joints)


def agree_to_double_precision(value: Any, expected: Any, are_angles: bool) -> bool:
    """Return whether two values agree to the precision of printed doubles, angles modulo 2 pi."""
    with mpmath.workdps(PRECISE_DIGITS):
        difference = value - expected
        if are_angles:
            difference -= 2 * mpmath.pi * mpmath.nint(difference / (2 * mpmath.pi))
        return bool(abs(difference) <= DOUBLE_TOLERANCE * max(1, abs(expected)))


def vanishes_at(expression: Node, joint_values: Mapping[str, Any], symbols: Mapping[str, Any]) -> bool:
    """Return whether an expression vanishes in double precision, given the values of its joints and other symbols."""
    program = compile_program([expression])
    values = {**symbols, **joint_values}
    (residual,) = evaluate_precisely(program, values, PRECISE_DIGITS)
    arrays = {name: np.array([float(value)]) for name, value in values.items()}
    size = float(evaluate(program, arrays, 1).magnitudes[0, 0])
    return bool(mpmath.isfinite(residual) and abs(residual) <= DOUBLE_TOLERANCE * max(size, _TINY))


def _count_configurations(values: Configurations) -> int:
    return len(next(iter(values.values())))


def _shift_joints(values: Configurations, shifts: Sequence[tuple[str, complex]]) -> dict[str, np.ndarray]:
    """Return a copy of all configurations for each shift of a joint, one after another, for a common evaluation."""
    shifted_values = {name: np.tile(column, len(shifts)) for name, column in values.items()}
    count = _count_configurations(values)
    for i, (joint, shift) in enumerate(shifts):
        if isinstance(shift, complex):
            shifted_values[joint] = shifted_values[joint].astype(complex)
        shifted_values[joint][i * count : (i + 1) * count] += shift
    return shifted_values


def _reduce_without_warning(function: Callable[..., Any], rows: np.ndarray) -> np.ndarray:
    """Return the nanmedian or nanmin of every row as a column, without NumPy's warning for rows that are all nan."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(function(rows, axis=1, keepdims=True))


def _compute_minimum_norm_steps(derivatives: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """Return the minimum-norm Gauss-Newton steps (configurations, joints).

    The derivatives have the shape (configurations, expressions, joints), the residuals (expressions, configurations).
    """
    if derivatives.shape[1] > 1:
        return np.asarray(np.einsum("pij,jp->pi", np.linalg.pinv(derivatives, rcond=1e-12), residuals))
    gradients = derivatives[:, 0]
    squared_norms = np.maximum(np.sum(gradients**2, axis=1), _TINY)
    return np.asarray(gradients * (residuals[0] / squared_norms)[:, None])


class ConfigurationSpace:
    """The configurations that sets can contain: the joints, the domain of all symbols, and the allowed rounding."""

    def __init__(self, joints: Sequence[str], domain: Domain, rounding: Rounding | None = None) -> None:
        self.joints, self.domain, self.rounding = tuple(joints), domain, rounding
        self.angles = tuple(joint for joint in self.joints if domain.roles.get(joint) == "angle")

    @property
    def typed_tolerance(self) -> float:
        """The absolute error (rad or m) allowed for typed joint values.

        An allowed relative error is taken of pi, the largest angle.
        """
        if self.rounding is None:
            return TYPED_TOLERANCE
        return max(TYPED_TOLERANCE, self.rounding.absolute, self.rounding.relative * np.pi)

    def parse_reference(self, conditions: Iterable[Node]) -> list[Piece]:
        """Return the pieces of reference conditions: one for each value of an angle, because each earns partial credit.

        The condition sin(theta1 + theta2) = 0 has two pieces.
        """
        pieces = [piece for condition in conditions for piece in set_parser.parse_pieces(condition, self.joints)]
        return [smaller_piece for piece in pieces for smaller_piece in set_parser.split_zeros(piece, self.angles)]

    def collect_names(self, unions: Sequence[Sequence[Piece]]) -> set[str]:
        """Return all joints, and every other name in the unions of pieces."""
        atoms = (atom for pieces in unions for piece in pieces for atom in piece)
        return set(self.joints).union(*(find_names(atom.expression) for atom in atoms))

    def sample_piece(
        self, piece: Piece, used_names: set[str], stream: Stream, count: int = SAMPLE_COUNT
    ) -> dict[str, np.ndarray]:
        """Return up to `count` random configurations on a piece, with values of all `used_names`."""
        values = self.domain.sample(used_names, count, stream)
        compiled_piece = _compile_piece(piece, self.joints, self.angles)
        is_valid = compiled_piece.assign_joints(values)
        if compiled_piece.residual_program.outputs:
            is_valid &= compiled_piece.project_onto_zeros(values)
            is_valid &= compiled_piece.assign_joints(values)
        return {name: column[is_valid] for name, column in values.items()}

    def compute_smallest_residual(self, piece: Piece, used_names: set[str], stream: Stream) -> float:
        """Return the smallest residual of a piece at random configurations, relative to the size of the terms.

        The residual of a configuration is the largest absolute value of the vanishing expressions. If these have no
        common zero, even the smallest residual is large.
        """
        compiled_piece = _compile_piece(piece, self.joints, self.angles)
        if not compiled_piece.free_joints:
            return float("inf")
        program = compiled_piece.residual_program
        count = min(_MAX_RESIDUAL_SAMPLES, max(SAMPLE_COUNT, _MAX_STORED_VALUES // len(program.steps)))
        residuals, sizes = evaluate(program, self.domain.sample(used_names, count, stream), count)
        with np.errstate(all="ignore"):
            relative_residuals = np.max(np.abs(residuals) / np.maximum(sizes, _TINY), axis=0)
        return float(_reduce_without_warning(np.nanmin, relative_residuals[None])[0, 0])

    def round_value(self, name: str, value: float) -> float:
        """Return a value with six digits: an angle is wrapped to (-pi, pi], and a mere rounding error becomes 0."""
        is_angle = self.domain.roles.get(name) == "angle"
        wrapped_value = float(np.angle(np.exp(1j * value))) if is_angle else value
        return round_to_six_digits(wrapped_value) if abs(wrapped_value) > TYPED_TOLERANCE else 0.0

    def contains(
        self, pieces: Sequence[Piece], values: Configurations, count: int, tolerance: float = SEARCH_TOLERANCE
    ) -> np.ndarray:
        """Return for each of `count` configurations whether it lies in the union of the pieces."""
        is_member = np.zeros(count, dtype=bool)
        for piece in pieces if count else ():
            is_member |= np.all([self._holds(atom, values, tolerance) for atom in piece], axis=0)
        return is_member

    def _holds(self, atom: Atom, values: Configurations, tolerance: float) -> np.ndarray:
        """Return for each configuration whether an atom holds."""
        if atom.joint is None:
            return _compile_piece((atom,), self.joints, self.angles).is_zero(values, tolerance)
        expected = evaluate(compile_program([atom.expression]), values, _count_configurations(values)).values[0]
        difference = values[atom.joint] - expected.real
        if atom.joint in self.angles:
            difference = np.angle(np.exp(1j * np.where(np.isfinite(difference), difference, np.nan)))
        return np.asarray((np.abs(difference) <= tolerance) & (np.abs(expected.imag) <= tolerance))

    def holds_exactly(self, piece: Piece, containing_pieces: Sequence[Piece], symbols: Mapping[str, Any]) -> bool:
        """Return whether the numbers typed in `piece` satisfy a piece of `containing_pieces` in double precision.

        Conditions on joints without a typed number are ignored here, because the search checks them.
        """
        values = {str(atom.joint): evaluate_constant(atom.expression) for atom in piece if atom.joint is not None}
        typed_values = {joint: value for joint, value in values.items() if value is not None}
        return any(
            all(self._satisfies(typed_values, atom, symbols) for atom in other_piece)
            for other_piece in containing_pieces
        )

    def _satisfies(self, typed_values: Mapping[str, Any], atom: Atom, symbols: Mapping[str, Any]) -> bool:
        """Return whether typed joint values satisfy an atom; True if a joint of the atom has no typed value."""
        if atom.joint is not None:
            names = find_names(atom.expression)
            if not (names & set(self.joints)) | {atom.joint} <= set(typed_values):
                return True
            values = {name: typed_values.get(name, symbols.get(name)) for name in names}
            (expected,) = evaluate_precisely(compile_program([atom.expression]), values, PRECISE_DIGITS)
            return agree_to_double_precision(typed_values[atom.joint], expected, atom.joint in self.angles)
        used_names = find_names(atom.expression)
        joint_values = {joint: value for joint, value in typed_values.items() if joint in used_names}
        if not joint_values or used_names & set(self.joints) - set(joint_values):
            return True
        other_values = {name: symbols[name] for name in used_names - set(joint_values)}
        return vanishes_at(atom.expression, joint_values, other_values)


@dataclass(frozen=True)
class SetComparison:
    """The result of comparing a student's set of configurations with the reference set.

    - `is_covered`: whether the student's set contains each reference piece; None for an empty piece
    - `is_sound`: whether the reference set contains each claimed piece, a piece of the student's set; None for an empty
      piece
    - `missing`: a configuration that is only in the reference set
    - `surplus`: a configuration that is only in the student's set
    - `configuration_count`: the number of configurations tried
    - `fewest_configurations`: the number of configurations on the piece with the fewest
    - `is_only_rounded`: whether a claimed value is correct except for rounding
    """

    is_covered: tuple[bool | None, ...]
    is_sound: tuple[bool | None, ...]
    missing: Mapping[str, float] | None
    surplus: Mapping[str, float] | None
    configuration_count: int
    fewest_configurations: int
    is_only_rounded: bool = False

    @property
    def are_equal(self) -> bool:
        """Whether the two sets contain the same configurations."""
        return False not in self.is_covered and False not in self.is_sound


@np.errstate(all="ignore")  # a search that overflows finds no zero
def compare_sets(
    claimed_pieces: Sequence[Piece], reference_pieces: Sequence[Piece], space: ConfigurationSpace, seed: str
) -> SetComparison:
    """Compare a student's set of configurations with the reference set, piece by piece.

    `seed` determines the random configurations.
    """

    def solve_for_angles(pieces: Sequence[Piece]) -> list[Piece]:
        return [tuple(set_parser.solve_for_angle(atom, space.angles) for atom in piece) for piece in pieces]

    claimed_union, reference_union = solve_for_angles(claimed_pieces), solve_for_angles(reference_pieces)
    used_names = space.collect_names([claimed_union, reference_union])
    counts: list[int] = []
    is_only_rounded = False

    def check_inclusion(
        pieces: Sequence[Piece], union: Sequence[Piece], set_name: str
    ) -> tuple[list[bool | None], dict[str, float] | None]:
        """Return whether the union contains each piece (None for an empty piece), and a configuration outside it."""
        nonlocal is_only_rounded
        is_contained: list[bool | None] = []
        example: dict[str, float] | None = None
        for index, piece in enumerate(pieces):
            values = space.sample_piece(piece, used_names, Stream(f"{seed}/{set_name}/{index}"))
            count = _count_configurations(values)
            counts.append(count)
            is_typed = all(atom.joint is not None for atom in piece)
            tolerance = space.typed_tolerance if is_typed else SEARCH_TOLERANCE
            if set_name == "reference":  # the union consists of the student's pieces, whose values may be rounded
                tolerance = max(tolerance, space.typed_tolerance)
            is_inside = space.contains(union, values, count, tolerance)
            if is_typed and count and is_inside.all() and space.rounding is None:
                fixed_values = space.domain.list_fixed_values()
                symbols = {name: fixed_values.get(name) or float(column[0]) for name, column in values.items()}
                if not space.holds_exactly(piece, union, symbols):
                    is_inside = np.zeros(count, dtype=bool)
                    is_only_rounded |= set_name == "claimed"
            elif is_typed and count and not is_inside.all() and set_name == "claimed":
                is_only_rounded |= bool(space.contains(union, values, count, ROUNDED_JOINT_VALUE.absolute).all())
            is_contained.append(None if count == 0 else bool(is_inside.all()))
            if count and not is_inside.all() and example is None:
                first_outside = int(np.nonzero(~is_inside)[0][0])
                example = {name: space.round_value(name, values[name][first_outside]) for name in sorted(values)}
        return is_contained, example

    is_sound, surplus = check_inclusion(claimed_union, reference_union, "claimed")
    for index, (piece, is_contained) in enumerate(zip(claimed_union, is_sound, strict=True)):
        # A piece that only seems to be empty, because its expressions almost vanish, doesn't count as sound.
        stream = Stream(f"{seed}/miss/{index}")
        if is_contained is None and space.compute_smallest_residual(piece, used_names, stream) < _NEAR_MISS_RESIDUAL:
            is_sound[index] = False
    nonempty_pieces = [piece for piece, sound in zip(claimed_union, is_sound, strict=True) if sound is not None]
    is_covered, missing = check_inclusion(reference_union, nonempty_pieces, "reference")
    min_count = min(filter(None, counts), default=0)
    return SetComparison(tuple(is_covered), tuple(is_sound), missing, surplus, sum(counts), min_count, is_only_rounded)
