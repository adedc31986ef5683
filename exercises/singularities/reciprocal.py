"""Find the singular configurations of an arm with more joints than task rows by elimination instead of minors.

J (6 x n) loses rank if a wrench does no work at any joint; such a wrench is called reciprocal to all n screws. The rank
depends neither on the frame nor on the reference point of the last link for which J is written. In a frame in the
middle of the arm, and about a point in which axes meet, most entries of J are zero. The row and the column of an entry
that is never zero can be eliminated, which solves one condition on the wrench. For example, if three axes meet in S, a
wrench reciprocal to them is a force through S, and its line must meet all other axes. A small matrix with few angles
remains. Its rank is examined in separate cases, in each of which certain factors of entries are zero.

If the task is a position (vx, vy, vz), the wrench is a force at P, and only the frame can be chosen.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import combinations, product

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import ANGLE_PREFIXES, Base, Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain, compute_jacobian_in_frame
from qdot.exercises.arm.trigonometry import Factored, factor_trig
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import (
    TooLong,
    expand_determinant,
    has_long_minors,
    point_moves_with_last_link,
)
from qdot.exercises.singularities import singular_set
from qdot.exercises.singularities.joint_solvability import drop_implied, may_hold_simultaneously
from qdot.exercises.singularities.singular_set import Conjunction, Search

_POSITION_ROWS = VELOCITY_NAMES[:3]
MAX_CASES = 400
"""Maximum number of cases that are examined."""
MAX_FRAME_PAIRS = 2
"""Maximum number of pairs that are tried, each with a frame and the frame of a reference point."""
SHORT_OPERATION_COUNT = 200
"""If the conditions that are found for a pair have fewer operations in total, no further pair is tried."""
_SPARSITY_TOLERANCE = 1e-9
"""An entry of the numeric Jacobian counts as zero if it is below this limit."""


@dataclass(frozen=True)
class FrameJacobian:
    """J of an arm in coordinates of frame `frame`.

    The reference point is the origin of frame `reference_frame`, or P if `reference_frame` is None.
    """

    frame: int
    reference_frame: int | None
    matrix: sp.ImmutableMatrix


@dataclass(frozen=True)
class ReducedCase:
    """The matrix whose rank shows whether J loses rank in one case.

    - `conditions`: the conditions of the case.
    - `joints`: the joint (counted from 1) to which each column of the matrix belongs; 0 if a column combines two
      joints.
    - `branches`: lists of conditions under which the matrix has less than full rank.
    """

    conditions: Conjunction
    matrix: sp.ImmutableMatrix
    joints: tuple[int, ...]
    branches: tuple[Conjunction, ...]


def elimination_applies(chain: Chain) -> bool:
    """Return whether elimination applies to an arm.

    Elimination applies to a task of all six rows of the last link if the arm has more than six joints. It applies to a
    position task if the arm has more than three joints and the minors of J are long.
    """
    if chain.n <= len(chain.task):
        return False
    if set(chain.task) == set(_POSITION_ROWS):
        return has_long_minors(chain)
    arm, _ = make_polynomial_arm(chain)
    return set(chain.task) == set(VELOCITY_NAMES) and point_moves_with_last_link(arm)


def make_polynomial_arm(chain: Chain) -> tuple[Chain, dict[sp.Symbol, sp.Expr]]:
    """Return an arm whose Jacobian has polynomials in lengths, sines and cosines as entries, and values of its symbols.

    The arm has no joint offsets, and its base is at the world's origin. Symbols replace angles that are not multiples
    of a right angle, and lengths that contain roots.
    """
    values: dict[sp.Symbol, sp.Expr] = {
        q: q + offset for q, offset in zip(chain.q, chain.offsets, strict=True) if offset != 0
    }

    def replace_entry(name: str, value: sp.Expr) -> sp.Expr:
        if sp.Symbol(name) in chain.q:
            return sp.Symbol(name)
        is_angle = name.startswith(ANGLE_PREFIXES)
        if is_angle and (2 * value / sp.pi).is_Integer:
            return sp.Mod(value, 2 * sp.pi)
        if not is_angle and _is_polynomial(value):
            return value
        symbol = sp.Symbol(name if is_angle or name.startswith("point") else f"length_{name}")
        if value != symbol:
            values[symbol] = value
        return symbol

    polynomial_arm = replace(chain, base=Base()).map_entries(replace_entry)
    return replace(polynomial_arm, tool=polynomial_arm.point), values


def _is_polynomial(value: sp.Expr) -> bool:
    """Return whether a length is a polynomial with rational coefficients."""
    numbers = value.atoms(sp.Number, sp.NumberSymbol, sp.Function)
    roots = [power for power in value.atoms(sp.Pow) if not (power.exp.is_Integer and power.exp > 0)]
    return not roots and all(number.is_Rational for number in numbers)


def _find_sparsest_frames(chain: Chain) -> list[tuple[int, int | None]]:
    """Return pairs (frame, reference_frame) as in FrameJacobian, beginning with the pair with the most zeros in J.

    Among pairs with equally many zeros, frames near the middle of the arm come first. For a position task, the
    reference point is P.
    """
    middle_frames = [frame for frame in range(chain.n) if abs(2 * frame - chain.n) < 2]
    if set(chain.task) == set(_POSITION_ROWS):
        frames_before_point = [frame for frame in reversed(middle_frames) if frame <= chain.point.frame]
        return [(frame, None) for frame in frames_before_point or [chain.point.frame]]
    rng = Stream("sparsest")
    values = {symbol.name: rng.uniform(0.4, 1.4) for symbol in chain.parameters}
    arm = NumericChain(chain, values)
    frames = arm.compute_frames(np.array([rng.uniform(-3, 3) for _ in chain.q]))
    z, origins = frames[:-1, :3, 2], frames[:-1, :3, 3]
    is_revolute = arm.is_revolute[:, None]
    candidates = []
    for frame, reference_frame in product(middle_frames, range(chain.n + 1)):
        rotation, point = frames[frame, :3, :3], frames[reference_frame, :3, 3]
        linear_parts, angular_parts = np.where(is_revolute, np.cross(z, point - origins), z), z * is_revolute
        zeros = np.abs(np.hstack([linear_parts @ rotation, angular_parts @ rotation])) < _SPARSITY_TOLERANCE
        distances = abs(2 * frame - chain.n), abs(reference_frame - frame)
        candidates.append((-int(zeros.sum()), *distances, frame, reference_frame, zeros.tobytes()))
    pair_by_zero_pattern: dict[bytes, tuple[int, int | None]] = {}
    for *_, frame, reference_frame, pattern in sorted(candidates):
        pair_by_zero_pattern.setdefault(pattern, (frame, reference_frame))
    return list(pair_by_zero_pattern.values())


def _factor_entry(entry: sp.Expr) -> sp.Expr:
    return factor_trig(sp.expand(entry)).to_expression()


# --- elimination ---


@dataclass
class _Elimination:
    """The elimination for one arm; it collects the reduced matrices in `reduced_cases`."""

    search: Search
    reduced_cases: list[ReducedCase] = field(default_factory=list)
    symbols: dict[sp.Expr, sp.Symbol] = field(default_factory=dict)
    """Maps each condition 1 - cos(q - root) with an arctangent in the root to a symbol. The symbol stands for the
    condition and protects it from substitutions.
    """

    def find_branches(self, matrix: sp.Matrix, joints: tuple[int, ...], case: Conjunction) -> Iterator[Conjunction]:
        """Yield the branches on which a matrix has less than full row rank.

        A branch includes the conditions of the case. `joints` are the joints of the columns, as in ReducedCase.
        """
        nonzero_columns = [c for c in range(matrix.cols) if not matrix.col(c).is_zero_matrix]
        nonzero_matrix = matrix.extract(list(range(matrix.rows)), nonzero_columns)
        remaining_joints = tuple(joints[c] for c in nonzero_columns)
        rows, columns = nonzero_matrix.shape
        if rows == 0:
            return
        if columns < rows or any(nonzero_matrix.row(r).is_zero_matrix for r in range(rows)):
            self.reduced_cases.append(ReducedCase(case, sp.ImmutableMatrix(nonzero_matrix), remaining_joints, ((),)))
            yield case
            return
        if len(self.reduced_cases) > MAX_CASES:
            raise TooLong(f"J may lose rank in more than {MAX_CASES} ways")
        yield from self._eliminate_next(nonzero_matrix, remaining_joints, case)

    def _eliminate_next(self, matrix: sp.Matrix, joints: tuple[int, ...], case: Conjunction) -> Iterator[Conjunction]:
        """Do one step of the elimination in a matrix; yield the branches as `find_branches` does."""
        for r in range(matrix.rows):
            common_factors = self._find_common_factors(matrix.row(r))
            if common_factors:
                for factor in common_factors:
                    self.reduced_cases.append(ReducedCase((*case, factor), sp.ImmutableMatrix(), (), ((),)))
                    yield (*case, factor)
                yield from self.find_branches(_divide_by_factors(matrix, common_factors, row=r), joints, case)
                return
        for c in range(matrix.cols):
            common_factors = self._find_common_factors(matrix.col(c))
            if common_factors:
                yield from self._eliminate_column(matrix, joints, case, c, common_factors)
                yield from self.find_branches(_divide_by_factors(matrix, common_factors, column=c), joints, case)
                return
        if (pivot := self._find_pivot(matrix)) is not None:
            r, c = pivot
            yield from self.find_branches(_compute_schur_complement(matrix, r, c), joints[:c] + joints[c + 1 :], case)
        elif (combination := self._combine_pair(matrix)) is not None:
            smaller_matrix, columns = combination
            yield from self.find_branches(smaller_matrix, tuple(joints[c] if c >= 0 else 0 for c in columns), case)
        else:
            yield from self._find_branches_by_minors(matrix, joints, case)

    def _eliminate_column(
        self, matrix: sp.Matrix, joints: tuple[int, ...], case: Conjunction, c: int, common_factors: list[sp.Expr]
    ) -> Iterator[Conjunction]:
        """Yield the branches on which a common factor of column `c` is zero, and the other columns lose rank."""
        other_columns, remaining_joints = _delete_column(matrix, c), joints[:c] + joints[c + 1 :]
        for factor in common_factors:
            for condition, values in self._list_zero_cases(factor):
                evaluate = partial(self._evaluate_at_zero, factor=factor, values=values)
                smaller_matrix = _clear_denominators(other_columns.applyfunc(evaluate))
                yield from self.find_branches(smaller_matrix, remaining_joints, (*case, condition))

    def _list_zero_cases(self, factor: sp.Expr) -> list[tuple[sp.Expr, dict[sp.Expr, sp.Expr]]]:
        """Return the cases in which a factor is zero.

        A case consists of a condition, and of values to substitute for sines, cosines and joint variables.
        """
        if isinstance(factor, (sp.sin, sp.cos)):
            return [(condition, dict(values)) for condition, values in singular_set.split_zero_cases(factor)]
        roots = find_half_angle_roots(factor, self.search)
        if not roots:
            return [(factor, {})]
        for condition, _ in roots:
            self.symbols.setdefault(condition, sp.Symbol(f"root{len(self.symbols) + 1}"))
        return [(self.symbols[condition], values) for condition, values in roots]

    def _evaluate_at_zero(self, entry: sp.Expr, factor: sp.Expr, values: dict[sp.Expr, sp.Expr]) -> sp.Expr:
        """Return an entry after the substitution of values at which a factor is zero.

        If there are no values, only multiples of the factor become zero.
        """
        if entry == 0:
            return entry
        if not values:
            return sp.S.Zero if factor in dict(factor_trig(entry).factors) else entry
        expanded = entry if all(key.is_Symbol for key in values) else sp.expand_trig(entry)
        substituted = expanded.xreplace(values)
        has_symbols = any(value.free_symbols for value in values.values())
        return sp.cancel(sp.expand(substituted)) if has_symbols else _factor_entry(substituted)

    def _find_common_factors(self, entries: sp.Matrix) -> list[sp.Expr]:
        """Return the factors that contain joint variables and that all nonzero entries have in common."""
        first_factors, *other_factors = [dict(factor_trig(entry).factors) for entry in entries if entry != 0]
        common_factors = (f for f in first_factors if all(f in factors for factors in other_factors))
        return list(filter(self.search.contains_joints, common_factors))

    def _find_pivot(self, matrix: sp.Matrix) -> tuple[int, int] | None:
        """Return the row and column of a nonzero constant entry with the most zeros in its row and column, or None."""
        keys = []
        for r, c in product(range(matrix.rows), range(matrix.cols)):
            entry, row, column = matrix[r, c], matrix.row(r), matrix.col(c)
            if not (entry == 0 or self.search.contains_joints(entry) or self._may_be_zero(entry)):
                changed_count = _count_other_nonzeros(row) * _count_other_nonzeros(column)
                keys.append((changed_count, sp.count_ops(row) + sp.count_ops(column), r, c))
        return min(keys)[2:] if keys else None

    def _may_be_zero(self, constant: sp.Expr) -> bool:
        """Return whether a constant contains a sum, and is zero for the arm's numbers."""
        return any(f.is_Add for f, _ in factor_trig(constant).factors) and self.search.is_zero(constant)

    def _combine_pair(self, matrix: sp.Matrix) -> tuple[sp.Matrix, list[int]] | None:
        """Eliminate a column with two entries that are never both zero, or a row with two such entries.

        A linear combination, whose entry in the column is zero, replaces the two rows of the entries. Two columns are
        combined likewise. Return the smaller matrix, and the index in `matrix` of each of its columns (-1 for a
        combined column). Return None if there are no such entries.
        """
        best_key, best_reduction = None, None
        for is_transposed in (False, True):
            m = matrix.T if is_transposed else matrix
            for c in range(m.cols):
                if best_key is not None and _count_other_nonzeros(m.col(c)) > best_key[0]:
                    continue
                reduction = self._reduce_to_two_entries(m, c)
                if reduction is None:
                    continue
                reduced_matrix, (a, b) = reduction
                u, v = reduced_matrix[a, c], reduced_matrix[b, c]
                if may_hold_simultaneously([u, v], self.search.joints):
                    continue
                other_rows = [r for r in range(m.rows) if r not in (a, b)]
                columns = [k for k in range(m.cols) if k != c]
                combined_row = (reduced_matrix.row(a) * v - reduced_matrix.row(b) * u).extract([0], columns)
                combined_row = combined_row.applyfunc(_factor_entry)
                smaller_matrix = reduced_matrix.extract(other_rows, columns).col_join(combined_row)
                column_indices = [*other_rows, -1] if is_transposed else columns
                key = _count_other_nonzeros(m.col(c)), sp.count_ops(smaller_matrix), is_transposed, c
                if best_key is None or key < best_key:
                    smaller_matrix = smaller_matrix.T if is_transposed else smaller_matrix
                    best_key, best_reduction = key, (smaller_matrix, column_indices)
        return best_reduction

    def _reduce_to_two_entries(self, matrix: sp.Matrix, c: int) -> tuple[sp.Matrix, tuple[int, int]] | None:
        """Reduce a column to two nonzero entries by adding constant multiples of rows.

        Return the matrix, and the indices of the two rows; None if that is impossible.
        """
        rows_by_factors: dict[tuple[tuple[sp.Expr, int], ...], int] = {}
        reduced_matrix = matrix
        for r in range(matrix.rows):
            if matrix[r, c] == 0:
                continue
            powers = factor_trig(matrix[r, c]).factors
            factors = tuple((f, power) for f, power in powers if self.search.contains_joints(f))
            if factors not in rows_by_factors:
                rows_by_factors[factors] = r
                continue
            pivot_row = rows_by_factors[factors]
            numerator, denominator = sp.fraction(sp.cancel(matrix[r, c] / matrix[pivot_row, c]))
            if self.search.contains_joints(numerator) or self.search.contains_joints(denominator):
                return None
            row = reduced_matrix.row(r) * denominator - reduced_matrix.row(pivot_row) * numerator
            row = row.applyfunc(_factor_entry)
            reduced_matrix = sp.Matrix.vstack(reduced_matrix[:r, :], row, reduced_matrix[r + 1 :, :])
        if len(rows_by_factors) != 2:
            return None
        first_row, second_row = rows_by_factors.values()
        return reduced_matrix, (first_row, second_row)

    def _find_branches_by_minors(
        self, matrix: sp.Matrix, joints: tuple[int, ...], case: Conjunction
    ) -> Iterator[Conjunction]:
        """Yield the branches on which all maximal minors of a matrix are zero."""
        column_sets = combinations(range(matrix.cols), matrix.rows)
        rows = list(range(matrix.rows))
        minors = [factor_trig(expand_determinant(matrix.extract(rows, list(columns)))) for columns in column_sets]
        zeros = singular_set.find_common_zeros(minors, self.search)
        branches = ((),) if zeros is None else tuple(zeros)
        self.reduced_cases.append(ReducedCase(case, sp.ImmutableMatrix(matrix), joints, branches))
        for branch in branches:
            yield (*case, *branch)


def _count_other_nonzeros(line: sp.Matrix) -> int:
    """Return the number of nonzero entries of a row or column besides one nonzero entry."""
    return sum(entry != 0 for entry in line) - 1


def _delete_column(matrix: sp.Matrix, c: int) -> sp.Matrix:
    return matrix.extract(list(range(matrix.rows)), [k for k in range(matrix.cols) if k != c])


def _divide_by_factors(matrix: sp.Matrix, common_factors: list[sp.Expr], row: int = -1, column: int = -1) -> sp.Matrix:
    """Return a matrix with one row or one column divided by common factors."""
    divisor = Factored(sp.S.One, tuple((factor, 1) for factor in common_factors))

    def divide_entry(r: int, c: int) -> sp.Expr:
        value = matrix[r, c]
        is_divided = value != 0 and (r == row or c == column)
        return factor_trig(value).divide_by(divisor).to_expression() if is_divided else value

    return sp.Matrix(matrix.rows, matrix.cols, divide_entry)


def _compute_schur_complement(matrix: sp.Matrix, r: int, c: int) -> sp.Matrix:
    """Return the Schur complement of a nonzero entry: eliminate its column, then drop its row and column."""
    rows = []
    for i in [i for i in range(matrix.rows) if i != r]:
        row = matrix.row(i)
        if row[c] != 0:
            numerator, denominator = sp.fraction(sp.cancel(row[c] / matrix[r, c]))
            row = (row * denominator - matrix.row(r) * numerator).applyfunc(_factor_entry)
        rows.append(row)
    return _delete_column(sp.Matrix.vstack(*rows), c) if rows else sp.zeros(0, matrix.cols - 1)


def _clear_denominators(matrix: sp.Matrix) -> sp.Matrix:
    """Return a matrix with each row multiplied by the common denominator of its entries."""
    rows = []
    for r in range(matrix.rows):
        denominators = [sp.denom(sp.together(entry)) for entry in matrix.row(r)]
        has_symbols = any(denominator.free_symbols for denominator in denominators)
        common_multiple = sp.lcm_list(denominators) if has_symbols else sp.S.One
        row = matrix.row(r)
        if common_multiple != 1:
            row = (row * common_multiple).applyfunc(lambda entry: _factor_entry(sp.cancel(entry)))
        rows.append(row)
    return sp.Matrix.vstack(*rows) if rows else matrix


def find_half_angle_roots(factor: sp.Expr, search: Search) -> list[tuple[sp.Expr, dict[sp.Expr, sp.Expr]]]:
    """Return the roots of a factor A + B cos q + C sin q if tan(q/2) contains no square root there.

    A root is a pair: the condition that q is at the root, and the values of cos q and sin q there. Return an empty list
    if the factor has another form, or if a square root is needed.
    """
    trigs = factor.atoms(sp.sin, sp.cos)
    angles = {trig.args[0] for trig in trigs if search.contains_joints(trig)}
    if len(angles) != 1 or (angle := angles.pop()) not in search.joints:
        return []
    coefficients = singular_set.find_trig_coefficients(factor, angle, angle)
    if coefficients is None:
        return []
    a, b, c = coefficients
    if sp.expand(a - b) == 0:  # one root is pi; in the next case, one root is 0
        roots, tangent = [(sp.pi, sp.S.NegativeOne, sp.S.Zero)], -a / c
    elif sp.expand(a + b) == 0:
        roots, tangent = [(sp.S.Zero, sp.S.One, sp.S.Zero)], -c / a
    else:
        return []
    if c != 0:
        tangent = sp.cancel(tangent)
        scale = 1 + tangent**2
        roots.append((2 * sp.atan(tangent), sp.cancel((1 - tangent**2) / scale), sp.cancel(2 * tangent / scale)))
    return [(1 - sp.cos(angle - root), {sp.cos(angle): cosine, sp.sin(angle): sine}) for root, cosine, sine in roots]


@dataclass(frozen=True)
class ReciprocalSet:
    """The singular set of an arm as elimination finds it.

    - `start`: the Jacobian with which the elimination started.
    - `cases`: the matrices with which the elimination ended.
    - `branches`: lists of conditions under which J loses rank.
    """

    start: FrameJacobian
    cases: tuple[ReducedCase, ...]
    branches: tuple[Conjunction, ...]


@lru_cache(maxsize=64)
def find_reciprocal_set(chain: Chain, symbol_values: tuple[tuple[sp.Symbol, sp.Expr], ...] = ()) -> ReciprocalSet:
    """Return the singular set of a polynomial arm, with the frame and the point that lead to the shortest conditions.

    `symbol_values` are the values of symbols that stand for the arm's numbers. Constants that are zero for these values
    are not used as pivots. Raises TooLong.
    """
    values = dict(symbol_values)
    is_zero = singular_set.make_zero_test(chain, lambda constant: constant.xreplace(values))

    def is_possible(branch: Conjunction) -> bool:
        return may_hold_simultaneously([condition.xreplace(values) for condition in branch], chain.q)

    candidates, errors = [], []
    for frame, reference_frame in _find_sparsest_frames(chain)[:MAX_FRAME_PAIRS]:
        try:
            reciprocal_set = _eliminate_in_frame(chain, frame, reference_frame, is_zero)
        except TooLong as error:
            errors.append(error)
            continue
        candidates.append(replace(reciprocal_set, branches=tuple(filter(is_possible, reciprocal_set.branches))))
        if _count_operations(candidates[-1]) < SHORT_OPERATION_COUNT:
            break
    if not candidates:
        raise errors[-1]
    return min(candidates, key=_count_operations)


def _count_operations(reciprocal_set: ReciprocalSet) -> int:
    """Return the number of operations in all conditions of a singular set together."""
    return sum(int(sp.count_ops(condition)) for branch in reciprocal_set.branches for condition in branch)


def _eliminate_in_frame(
    chain: Chain, frame: int, reference_frame: int | None, is_zero: Callable[[sp.Expr], bool]
) -> ReciprocalSet:
    """Return the singular set by elimination in J for one frame and one reference point. Raises TooLong."""
    jacobian = compute_jacobian_in_frame(chain, frame, reference_frame).applyfunc(_factor_entry)
    start = FrameJacobian(frame, reference_frame, sp.ImmutableMatrix(jacobian))
    elimination = _Elimination(Search(chain.q, is_zero))
    branches = list(elimination.find_branches(sp.Matrix(start.matrix), tuple(range(1, chain.n + 1)), ()))
    if () in branches:
        return ReciprocalSet(start, tuple(elimination.reduced_cases), ((),))
    search = Search((*chain.q, *elimination.symbols.values()), is_zero)
    tidied_branches = singular_set.tidy_branches(branches, search, "the remaining minors of J")
    conditions_by_symbol = {symbol: condition for condition, symbol in elimination.symbols.items()}

    def restore(conditions: Conjunction) -> Conjunction:
        return tuple(condition.xreplace(conditions_by_symbol) for condition in conditions)

    cases = elimination.reduced_cases
    restored_cases = tuple(
        replace(case, conditions=restore(singular_set.replace_marks(case.conditions))) for case in cases
    )
    restored_branches = tuple(restore(drop_implied(branch, chain.q)) for branch in tidied_branches)
    return ReciprocalSet(start, restored_cases, restored_branches)
