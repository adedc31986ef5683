"""Derive all results of the chapter with symbols for an arm's numbers, and then substitute the numbers.

The *symbolic arm* has a symbol for every nonzero length and for every angle that is not a multiple of pi/2, and no
joint offsets. Arms with the same symbolic arm have the same *structure*. The results for the symbolic arm hold for all
of these arms, so they are derived only once. The Jacobian is derived by two routes, which must give exactly the same
formulas.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
import sympy as sp
from sympy.polys.matrices import DomainMatrix

from qdot.exercises.arm.chain import ANGLE_PREFIXES, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import compute_frames_and_point, compute_jacobian_in_frame, compute_link_frames
from qdot.exercises.arm.trigonometry import (
    Factored,
    are_identical,
    count_written_terms,
    factor_trig,
    remove_arctangents,
    remove_brackets,
    to_textbook_form,
    to_textbook_matrix,
)
from qdot.exercises.common.errors import QdotError
from qdot.exercises.derivation.graph import compute_symbolic_stages, propagate_linear_rows, to_sympy_matrix

Values = dict[sp.Symbol, sp.Expr]

MAX_MINOR_TERMS = 3000
"""Maximum number of terms in all maximal minors of a Jacobian together; the seven minors of a Panda have 400."""
LONG_MINOR_TERMS = 100
"""If the minors together have more terms, the singular configurations are found by elimination
(`singularities.reciprocal`)."""


class TooLong(QdotError):
    """The error raised if a result would be too long to be derived or to be read."""


@dataclass(frozen=True)
class SymbolicArm:
    """The symbolic arm of an arm.

    - `chain`: the arm with symbols for lengths and angles, and without joint offsets.
    - `values`: the arm's value of each symbol. For a joint variable with an offset, the value is variable plus offset.
    """

    chain: Chain
    values: tuple[tuple[sp.Symbol, sp.Expr], ...]


def make_symbolic_arm(chain: Chain) -> SymbolicArm:
    """Return the symbolic arm of a chain: nonzero lengths, and angles that are not multiples of pi/2, become symbols.

    Minus signs stay, because they decide whether an arm is stretched out or folded back.
    """
    values: Values = {q: q + offset for q, offset in zip(chain.q, chain.offsets, strict=True) if offset != 0}

    def replace_by_symbol(name: str, value: sp.Expr) -> sp.Expr:
        """Return the symbol that replaces an entry of the arm, or the entry if it stays; store the symbol's value."""
        symbol = sp.Symbol(name)
        if symbol in chain.q:
            return symbol
        if name.startswith(ANGLE_PREFIXES):
            if (2 * value / sp.pi).is_Integer:
                return sp.Mod(value, 2 * sp.pi)
        elif value == 0:
            return sp.S.Zero
        elif value.as_coeff_Mul()[0].is_negative and not name.startswith("base"):  # the base may be anywhere
            return -replace_by_symbol(name, -value)
        if value != symbol:
            values[symbol] = value
        return symbol

    symbolic_chain = chain.map_entries(replace_by_symbol)
    symbolic_chain = replace(symbolic_chain, name="structure", title="", tool=symbolic_chain.point, axis_points=())
    return SymbolicArm(symbolic_chain, tuple(values.items()))


# --- results for symbolic arms ---


@lru_cache(maxsize=4096)
def _derive_position(chain: Chain) -> sp.Matrix:
    """Return the point of interest of a symbolic arm; this is quick even if the other results take minutes."""
    return compute_frames_and_point(chain).point.applyfunc(to_textbook_form)


class _Geometry(NamedTuple):
    """The axes (3 x n), the vectors p* (3 x n, m) and the geometric Jacobian (6 x n) of a symbolic arm."""

    z: sp.Matrix
    p_star: sp.Matrix
    jacobian: sp.Matrix


@lru_cache(maxsize=4096)
def _derive_geometry(chain: Chain) -> _Geometry:
    """Return the geometry of a symbolic arm. Raises RuntimeError unless both routes of derivation agree exactly."""
    frames, point = compute_frames_and_point(chain)
    z = sp.Matrix.hstack(*(frame.rotation[:, 2].applyfunc(to_textbook_form) for frame in frames[: chain.n]))
    # frames 0 ... n-1 of a standard table, frames 1 ... n of a modified table
    frames_on_axes = compute_link_frames(chain)[convention_of(chain).find_frame_on_axis(1) :][: chain.n]
    p_star = sp.Matrix.hstack(*((point - frame.origin).applyfunc(to_textbook_form) for frame in frames_on_axes))
    linear_rows = _derive_position(chain).jacobian(chain.q).applyfunc(to_textbook_form)
    angular_rows = sp.Matrix(3, chain.n, lambda r, i: z[r, i] if chain.joints[i].is_revolute else sp.S.Zero)
    jacobian = linear_rows.col_join(angular_rows)
    stages = compute_symbolic_stages(chain)
    propagated_jacobian = np.concatenate([propagate_linear_rows(stages), stages["angular rows"]])
    axes_of_convention = sp.Matrix.hstack(*(frame.rotation[:, 2] for frame in frames_on_axes))
    for by_differentiation, by_propagation, quantity in (
        (z.T, stages["axes"][: chain.n], "z"),
        (axes_of_convention.T, stages["axes"][: chain.n], "z"),
        (p_star.T, stages["vectors to point"][: chain.n], "p*"),
        (jacobian, propagated_jacobian, "Jacobian"),
    ):
        entries = zip(by_differentiation, to_sympy_matrix(by_propagation), strict=True)
        if not all(are_identical(a, b) for a, b in entries):
            raise RuntimeError(f"the two routes disagree on {quantity} of {chain}; please report this")
    return _Geometry(z, p_star, jacobian)


def _derive_task_jacobian(chain: Chain) -> sp.Matrix:
    return _derive_geometry(chain).jacobian[chain.task_rows, :]


def expand_determinant(matrix: sp.Matrix) -> sp.Expr:
    """Return the expanded determinant of a matrix, in which sines and cosines are treated as independent symbols."""
    atoms = sorted(matrix.atoms(sp.sin, sp.cos), key=sp.default_sort_key)
    names = {atom: sp.Symbol(f"t_{i}") for i, atom in enumerate(atoms)}
    polynomials = DomainMatrix.from_Matrix(matrix.xreplace(names))
    return polynomials.domain.to_sympy(polynomials.det()).xreplace({symbol: atom for atom, symbol in names.items()})


def shorten_jacobian(chain: Chain) -> sp.Matrix:
    """Return a matrix with the same maximal minors as the task Jacobian, but with shorter entries if possible.

    For a task of six rows, the matrix is the Jacobian of the last link about O_k, in the coordinates of frame k in the
    middle of the arm. A change of frame and reference point multiplies J from the left by a matrix with determinant 1.
    Therefore the minors of all six rows stay the same. For other tasks, for fewer than six joints, or if P does not
    move with the last link, the matrix is the task Jacobian itself.
    """
    if set(chain.task) != set(VELOCITY_NAMES) or chain.n < len(VELOCITY_NAMES) or not point_moves_with_last_link(chain):
        return _derive_task_jacobian(chain)
    k = chain.n // 2
    return to_textbook_matrix(compute_jacobian_in_frame(chain, k, k))[chain.task_rows, :]


def point_moves_with_last_link(chain: Chain) -> bool:
    """Return whether P could as well be fixed to the last link, because the joints after P's link do not move P.

    For example, the wrist centre is fixed to the forearm, and lies on the axes of all three joints of the wrist.
    """
    if chain.point.frame == chain.n:
        return True
    frames, point = compute_frames_and_point(chain)
    later_joints = range(chain.point.frame, chain.n)
    moments = (entry for i in later_joints for entry in frames[i].rotation[:, 2].cross(point - frames[i].origin))
    return all(chain.joints[i].is_revolute for i in later_joints) and all(are_identical(x, sp.S.Zero) for x in moments)


@lru_cache(maxsize=4096)
def _expand_minors(chain: Chain) -> tuple[sp.Expr, ...] | None:
    """Return every maximal minor of a symbolic arm's task Jacobian as a sum; None if the sums have too many terms."""
    jacobian = shorten_jacobian(chain)
    rows, columns = jacobian.shape
    minor_size = min(rows, columns)
    minors: list[sp.Expr] = []
    for indices in product(combinations(range(rows), minor_size), combinations(range(columns), minor_size)):
        minors.append(expand_determinant(jacobian.extract(*map(list, indices))))
        if count_written_terms(minors) > MAX_MINOR_TERMS:
            return None
    return tuple(minors)


def has_long_minors(chain: Chain) -> bool:
    """Return whether the maximal minors of an arm's task Jacobian have more terms than LONG_MINOR_TERMS together."""
    minors = _expand_minors(make_symbolic_arm(chain).chain)
    return minors is None or count_written_terms(minors) > LONG_MINOR_TERMS


@lru_cache(maxsize=4096)
def _derive_minors(chain: Chain) -> tuple[Factored, ...]:
    """Return every maximal minor of a symbolic arm's task Jacobian, factored. Raises TooLong.

    The only maximal minor of a square Jacobian is its determinant.
    """
    minors = _expand_minors(chain)
    if minors is None:
        subject = "the determinant has" if chain.has_square_jacobian else "the minors of J have"
        raise TooLong(f"{subject} more than {MAX_MINOR_TERMS} terms, too many for readable conditions")
    return tuple(map(factor_trig, minors))


_minor_loaders: dict[Chain, Callable[[], tuple[Factored, ...]]] = {}
"""For some arms, a function that loads the minors of the symbolic arm from the grader's files."""
_MAX_LOADERS = 64
"""If there are loaders for this many arms, all are removed, so that grading a large class does not fill the memory."""


def register_minors(chain: Chain, load_minors: Callable[[], tuple[Factored, ...]]) -> None:
    """Register a function that loads the minors of an arm's symbolic arm, so that the grader need not derive them."""
    if len(_minor_loaders) >= _MAX_LOADERS:
        _minor_loaders.clear()
    _minor_loaders[chain] = load_minors


@lru_cache(maxsize=4096)
def _derive_inverse(chain: Chain) -> tuple[tuple[Factored, ...], ...]:
    """Return the n x n entries of a symbolic arm's J^-1: cofactor over determinant, common factors cancelled."""
    jacobian = _derive_task_jacobian(chain)
    (determinant,) = _derive_minors(chain)
    n = jacobian.rows

    def derive_entry(i: int, j: int) -> Factored:
        submatrix = jacobian.extract([r for r in range(n) if r != j], [c for c in range(n) if c != i])
        cofactor = factor_trig((-1) ** (i + j) * (expand_determinant(submatrix) if n > 1 else sp.S.One))
        return cofactor.divide_by(determinant)

    return tuple(tuple(derive_entry(i, j) for j in range(n)) for i in range(n))


@lru_cache(maxsize=4096)
def _derive_rates(chain: Chain) -> tuple[Factored, ...]:
    """Return the n joint rates of a symbolic arm as fractions: (sum of cofactors times velocities) / det J."""
    jacobian = _derive_task_jacobian(chain)
    (determinant,) = _derive_minors(chain)
    velocity = sp.Matrix(make_task_velocity(chain))
    # Cramer's rule: the numerator of rate i is the determinant of J with the velocity as column i.
    matrices = (sp.Matrix.hstack(jacobian[:, :i], velocity, jacobian[:, i + 1 :]) for i in range(chain.n))
    rates = (factor_trig(expand_determinant(matrix)).divide_by(determinant) for matrix in matrices)
    return tuple(_collect_by_velocity(rate, tuple(velocity)) for rate in rates)


def _collect_by_velocity(rate: Factored, velocity: tuple[sp.Symbol, ...]) -> Factored:
    """Collect the numerator of a joint rate by the components of the task velocity, as in the book."""

    def collect(factor: sp.Expr) -> sp.Expr:
        has_velocity = factor.free_symbols & set(velocity)
        return sp.collect(sp.expand(factor), velocity, to_textbook_form) if has_velocity else factor

    return Factored(rate.coefficient, tuple((collect(factor), power) for factor, power in rate.factors))


class Derivation:
    """The results for one arm, in the arm's numbers and symbols; vectors and matrices are in the world frame.

    Results are computed on demand, because they may take long, and the determinant of a 6-DOF arm needs few of them.
    """

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        symbolic_arm = make_symbolic_arm(chain)
        self._symbolic_chain, self._values = symbolic_arm.chain, dict(symbolic_arm.values)

    @cached_property
    def position(self) -> sp.Matrix:
        """The point of interest, 3 x 1 (m)."""
        return self.substitute_matrix(_derive_position(self._symbolic_chain))

    @cached_property
    def z(self) -> sp.Matrix:
        """The joint axes, 3 x n: z_0 ... z_{n-1}, or z_1 ... z_n of a modified table."""
        return self.substitute_matrix(_derive_geometry(self._symbolic_chain).z)

    @cached_property
    def p_star(self) -> sp.Matrix:
        """The vectors from the origin of the frame on each axis to the point of interest, 3 x n (m).

        The columns are p*_0 ... p*_{n-1}, or p*_1 ... p*_n of a modified table.
        """
        return self.substitute_matrix(_derive_geometry(self._symbolic_chain).p_star)

    @cached_property
    def geometric_jacobian(self) -> sp.Matrix:
        """The geometric Jacobian, 6 x n (6.11, 6.12)."""
        return self.substitute_matrix(_derive_geometry(self._symbolic_chain).jacobian)

    @cached_property
    def jacobian(self) -> sp.Matrix:
        """The task Jacobian: the m rows of the geometric Jacobian that belong to the task, m x n."""
        return self.geometric_jacobian[self.chain.task_rows, :]

    def substitute_values(self, expression: sp.Expr) -> sp.Expr:
        """Return an expression of the symbolic arm with this arm's numbers and symbols substituted."""
        return expression.xreplace(self._values)

    def substitute_matrix(self, matrix: sp.Matrix) -> sp.Matrix:
        """Return a matrix of the symbolic arm with this arm's numbers and symbols substituted.

        The DH table of an arm that is described by its axes has roots and arctangents that students don't know. These
        are removed if possible.
        """
        new_matrix = matrix.applyfunc(self.substitute_values)
        if convention_of(self.chain).shows_table:
            return new_matrix
        return new_matrix.applyfunc(remove_arctangents).applyfunc(remove_brackets)

    @property
    def linear_rows(self) -> sp.Matrix:
        """The linear rows of the geometric Jacobian, 3 x n."""
        return self.geometric_jacobian[:3, :]

    @cached_property
    def symbolic_minors(self) -> tuple[Factored, ...]:
        """The maximal minors of the symbolic arm's task Jacobian, factored; the determinant alone if J is square."""
        load_minors = _minor_loaders.get(self.chain)
        return _derive_minors(self._symbolic_chain) if load_minors is None else load_minors()

    @property
    def symbolic_joints(self) -> tuple[sp.Symbol, ...]:
        """The joint variables of the symbolic arm, which has no joint offsets."""
        return self._symbolic_chain.q

    @property
    def rotations(self) -> list[sp.Matrix]:
        """The rotations R_0 ... R_n (3 x 3); the angles of successive parallel joints are added."""
        return [self.substitute_matrix(frame.rotation) for frame in compute_link_frames(self._symbolic_chain)]

    @property
    def link_vectors(self) -> list[sp.Matrix]:
        """The vectors r_1 ... r_n (3 x 1, m), each from O_{i-1} to O_i in frame i-1 (below 6.13)."""
        convention = convention_of(self.chain)
        return [convention.make_link_vector(row) for row in convention.rows]

    @property
    def is_square(self) -> bool:
        """Whether J is square, so that it has a determinant."""
        return self.chain.has_square_jacobian

    @property
    def determinant(self) -> sp.Expr:
        """The determinant of J in factored form; raises ValueError if J is not square."""
        self._require_square("determinant")
        return self.symbolic_minors[0].substitute(self._values)

    @property
    def inverse(self) -> sp.Matrix:
        """The inverse of J (n x n) by the adjugate; raises ValueError if J is not square or never invertible."""
        self._require_square("inverse", "so J has no inverse")
        rows = [[entry.substitute(self._values) for entry in row] for row in _derive_inverse(self._symbolic_chain)]
        return sp.Matrix(rows)

    def _require_square(self, quantity: str, consequence: str = "") -> None:
        """Raise ValueError if J is not square, or if a `consequence` of det J = 0 is given and det J is always zero."""
        if not self.is_square:
            shape = f"{len(self.chain.task)} x {self.chain.n}"
            raise ValueError(f"the {quantity} needs a square Jacobian, but this one is {shape}")
        if consequence and self.symbolic_minors[0].is_zero:
            raise ValueError(f"det J = 0 everywhere, {consequence}")

    def derive_link_jacobian(self, k: int) -> sp.Matrix:
        """Return the 6 x n Jacobian of frame k, for the velocity of O_k and of link k ((6.9), (6.10), sums up to k)."""
        first_columns = derive(convention_of(self.chain).keep_first_joints(k)).geometric_jacobian
        return sp.Matrix.hstack(first_columns, sp.zeros(6, self.chain.n - k))

    def derive_rate_law(self) -> sp.Matrix:
        """Return the joint rates qd = J^-1 xd (n x 1) for a task velocity xd given by the symbols vx ... wz (6.7)."""
        self._require_square("inverse velocity", "so the joint rates can't be found")
        return sp.Matrix([rate.substitute(self._values) for rate in _derive_rates(self._symbolic_chain)])


def make_task_velocity(chain: Chain) -> tuple[sp.Symbol, ...]:
    """Return the symbols of the task velocity, for example vx and vy."""
    return tuple(sp.Symbol(row) for row in chain.task)


@lru_cache(maxsize=512)
def derive(chain: Chain) -> Derivation:
    """Return the derivation for an arm; it is cached, because several questions ask about the same arm."""
    return Derivation(chain)
