"""Derive all results of the chapter once per structure, and substitute the numbers of each arm.

A structure is a chain in which every nonzero length is a symbol and joint offsets are absorbed into the joint
variables. Its Jacobian is proved by two routes, which must give exactly the same formulas. Its results then hold for
every arm of that structure.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import combinations, product

import numpy as np
import sympy as sp
from sympy.polys.matrices import DomainMatrix

from qdot.exercises.arm.chain import ANGLE_PREFIXES, TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation_graph import compute_symbolic_stages, propagate_linear_rows, to_sympy_matrix
from qdot.exercises.arm.kinematics import frames_and_point, jacobian_seen_from, link_frames, task_matrix
from qdot.exercises.arm.trigonometry import (
    Factored,
    are_identical,
    factor_trig,
    remove_arctangents,
    remove_brackets,
    substitute,
    textbook_form,
    textbook_matrix,
)
from qdot.exercises.common.errors import QdotError

Values = dict[sp.Symbol, sp.Expr]

MAX_MINOR_TERMS, LONG_MINOR_TERMS = 3000, 100
"""Maximum number of terms in all maximal minors of a Jacobian, and the number of terms above which singularities are
found by elimination (`reciprocal`) instead.

The seven minors of a Panda have 400 terms.
"""


class TooLong(QdotError):
    """The error raised if a result would be too long to be derived or read."""


@dataclass(frozen=True)
class Structure:
    """The structure of an arm: a chain with symbols for all lengths and angles that may vary, and their values.

    Arms that differ only in the values share the chain, so that results are derived once for all of them.
    """

    chain: Chain
    values: tuple[tuple[sp.Symbol, sp.Expr], ...]


def structure(chain: Chain) -> Structure:
    """Return the structure of a chain, in which lengths, and angles that are not multiples of pi/2, become symbols.

    Multiples of pi/2, zeros and minus signs are kept.
    """
    values: Values = {q: q + offset for q, offset in zip(chain.q, chain.offsets, strict=True) if offset != 0}

    def generalize(name: str, value: sp.Expr) -> sp.Expr:
        symbol = sp.Symbol(name)
        if symbol in chain.q:
            return symbol
        if name.startswith(ANGLE_PREFIXES):
            if (2 * value / sp.pi).is_Integer:
                return sp.Mod(value, 2 * sp.pi)
        elif value == 0:
            return sp.S.Zero
        elif value.as_coeff_Mul()[0].is_negative and not name.startswith("base"):
            return -generalize(name, -value)  # the sign decides between stretched out and folded back
        if value != symbol:
            values[symbol] = value
        return symbol

    generic = chain.map_entries(generalize)
    generic = replace(generic, name="structure", title="", tool=generic.point, axis_points=())
    return Structure(generic, tuple(values.items()))


@lru_cache(maxsize=4096)
def _generic_position(chain: Chain) -> sp.Matrix:
    """Return the point of interest of a structure; if axes are skew, the other results take much longer."""
    return frames_and_point(chain)[1].applyfunc(textbook_form)


@lru_cache(maxsize=4096)
def _prove_geometry(chain: Chain) -> tuple[sp.Matrix, sp.Matrix, sp.Matrix]:
    """Return the axes, p* and the geometric Jacobian of a structure, after proving that both routes agree."""
    frames, point = frames_and_point(chain)
    z = sp.Matrix.hstack(*(frame.rotation[:, 2].applyfunc(textbook_form) for frame in frames[: chain.n]))
    on_axes = link_frames(chain)[convention_of(chain).frame_on_axis(1) :][: chain.n]
    p_star = sp.Matrix.hstack(*((point - frame.origin).applyfunc(textbook_form) for frame in on_axes))
    linear = _generic_position(chain).jacobian(chain.q).applyfunc(textbook_form)
    angular = sp.Matrix(3, chain.n, lambda r, i: z[r, i] if chain.joints[i].kind == "R" else sp.S.Zero)
    geometric = linear.col_join(angular)
    working = compute_symbolic_stages(chain)
    propagated = np.concatenate([propagate_linear_rows(working), working["angular"]])
    axes_of_convention = sp.Matrix.hstack(*(frame.rotation[:, 2] for frame in on_axes))
    for differentiated, by_propagation, quantity in (
        (z.T, working["axes"][: chain.n], "z"),
        (axes_of_convention.T, working["axes"][: chain.n], "z"),
        (p_star.T, working["arms"][: chain.n], "p*"),
        (geometric, propagated, "Jacobian"),
    ):
        if not all(are_identical(a, b) for a, b in zip(differentiated, to_sympy_matrix(by_propagation), strict=True)):
            raise RuntimeError(f"the two routes disagree on {quantity} of {chain}; please report this")
    return z, p_star, geometric


def _geometric_jacobian(chain: Chain) -> sp.Matrix:
    return _prove_geometry(chain)[2]


def determinant_of(matrix: sp.Matrix) -> sp.Expr:
    """Return the expanded determinant of a matrix; its sines and cosines are treated as independent symbols."""
    atoms = sorted(matrix.atoms(sp.sin, sp.cos), key=sp.default_sort_key)
    names = {atom: sp.Symbol(f"t_{i}") for i, atom in enumerate(atoms)}
    polynomials = DomainMatrix.from_Matrix(matrix.xreplace(names))
    return polynomials.domain.to_sympy(polynomials.det()).xreplace({symbol: atom for atom, symbol in names.items()})


def short_jacobian(chain: Chain) -> sp.Matrix:
    """Return a matrix with the same maximal minors as the task Jacobian but shorter entries, if the task has six rows.

    It is the Jacobian of the last link in frame k in the middle of the chain, with O_k as the reference point. Another
    frame and point of the same body multiply J from the left by a matrix of determinant 1, which leaves minors of all
    six rows unchanged. For other tasks, for fewer joints, or if P is not fixed to the last link, return the task
    Jacobian itself.
    """
    if set(chain.task) != set(TASK_ROWS) or chain.n < len(TASK_ROWS) or not moves_with_last_link(chain):
        return task_matrix(_geometric_jacobian(chain), chain.task)
    k = chain.n // 2
    return task_matrix(textbook_matrix(jacobian_seen_from(chain, k, k)), chain.task)


def moves_with_last_link(chain: Chain) -> bool:
    """Return whether P could as well be fixed to the last link, because the joints after P's link do not move it.

    A wrist centre is an example.
    """
    if chain.point.frame == chain.n:
        return True
    frames, point = frames_and_point(chain)
    later = list(zip(chain.joints, frames, strict=False))[chain.point.frame :]
    moments = (entry for _, frame in later for entry in frame.rotation[:, 2].cross(point - frame.origin))
    return all(joint.kind == "R" for joint, _ in later) and all(are_identical(entry, sp.S.Zero) for entry in moments)


@lru_cache(maxsize=4096)
def _expanded_minors(chain: Chain) -> tuple[sp.Expr, ...] | None:
    """Return every maximal minor of the task Jacobian as a sum, or None if they have too many terms."""
    jacobian = short_jacobian(chain)
    rows, cols = jacobian.shape
    minor_size = min(rows, cols)
    minors: list[sp.Expr] = []
    for indices in product(combinations(range(rows), minor_size), combinations(range(cols), minor_size)):
        minors.append(determinant_of(jacobian.extract(*map(list, indices))))
        if _count_terms(minors) > MAX_MINOR_TERMS:
            return None
    return tuple(minors)


def _count_terms(minors: Iterable[sp.Expr]) -> int:
    return sum(len(sp.Add.make_args(minor)) for minor in minors)


def minors_are_long(chain: Chain) -> bool:
    """Return whether the maximal minors of the task Jacobian have so many terms that elimination is preferred."""
    minors = _expanded_minors(structure(chain).chain)
    return minors is None or _count_terms(minors) > LONG_MINOR_TERMS


@lru_cache(maxsize=4096)
def _generic_minors(chain: Chain) -> tuple[Factored, ...]:
    """Return every maximal minor of the task Jacobian, factored; only the determinant if it is square.

    Raises TooLong.
    """
    minors = _expanded_minors(chain)
    if minors is None:
        subject = "the determinant has" if len(chain.task) == chain.n else "the minors of J have"
        raise TooLong(f"{subject} more than {MAX_MINOR_TERMS} terms, too many for readable conditions")
    return _factor_all(minors)


_stored_minors: dict[Chain, Callable[[], tuple[Factored, ...]]] = {}
_MAX_STORED = 64


def store_minors(chain: Chain, minors: Callable[[], tuple[Factored, ...]]) -> None:
    """Store a function that returns the minors of an arm's structure, so that the grader need not derive them."""
    if len(_stored_minors) >= _MAX_STORED:
        _stored_minors.clear()
    _stored_minors[chain] = minors


@lru_cache(maxsize=4096)
def _factor_all(minors: tuple[sp.Expr, ...]) -> tuple[Factored, ...]:
    return tuple(factor_trig(minor) for minor in minors)


@lru_cache(maxsize=4096)
def _generic_inverse(chain: Chain) -> tuple[tuple[Factored, ...], ...]:
    """Return the entries of the inverse by the adjugate: cofactor over determinant, common factors cancelled."""
    jacobian = task_matrix(_geometric_jacobian(chain), chain.task)
    (determinant,) = _generic_minors(chain)
    n = jacobian.rows

    def entry(i: int, j: int) -> Factored:
        submatrix = jacobian.extract([r for r in range(n) if r != j], [c for c in range(n) if c != i])
        cofactor = factor_trig((-1) ** (i + j) * (determinant_of(submatrix) if n > 1 else sp.S.One))
        return cofactor.over(determinant)

    return tuple(tuple(entry(i, j) for j in range(n)) for i in range(n))


@lru_cache(maxsize=4096)
def _generic_rates(chain: Chain) -> tuple[Factored, ...]:
    """Return the joint rates, each as one fraction: (sum of cofactors times velocities) / det J."""
    jacobian = task_matrix(_geometric_jacobian(chain), chain.task)
    (determinant,) = _generic_minors(chain)
    velocity = sp.Matrix(task_velocity(chain))
    # Cramer's rule: the numerator of rate i is the determinant of J with the velocity as column i.
    matrices = (sp.Matrix.hstack(jacobian[:, :i], velocity, jacobian[:, i + 1 :]) for i in range(chain.n))
    rates = (factor_trig(determinant_of(matrix)).over(determinant) for matrix in matrices)
    return tuple(_collect_by_velocity(rate, tuple(velocity)) for rate in rates)


def _collect_by_velocity(rate: Factored, velocity: tuple[sp.Symbol, ...]) -> Factored:
    """Collect the numerator of a joint rate by the components of the task velocity, as in the book."""

    def collect(factor: sp.Expr) -> sp.Expr:
        has_velocity = factor.free_symbols & set(velocity)
        return sp.collect(sp.expand(factor), velocity, textbook_form) if has_velocity else factor

    return Factored(rate.coefficient, tuple((collect(factor), power) for factor, power in rate.factors))


class Derivation:
    """The results for one arm: SymPy matrices in the arm's own numbers and symbols, in the world frame."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        generic = structure(chain)
        self._structure, self._values = generic.chain, dict(generic.values)

    # These are computed on demand, because the determinant of a 6-DOF arm needs none of them.
    @cached_property
    def position(self) -> sp.Matrix:
        """The point of interest, 3 x 1 (m)."""
        return self.substitute_matrix(_generic_position(self._structure))

    @cached_property
    def z(self) -> sp.Matrix:
        """The joint axes, 3 x n: z_0 ... z_{n-1}, or z_1 ... z_n of a modified table."""
        return self.substitute_matrix(_prove_geometry(self._structure)[0])

    @cached_property
    def p_star(self) -> sp.Matrix:
        """The vectors from the origin of the frame on each axis to the point of interest, 3 x n (m).

        They are p*_0 ... p*_{n-1}, or p*_1 ... p*_n of a modified table.
        """
        return self.substitute_matrix(_prove_geometry(self._structure)[1])

    @cached_property
    def geometric(self) -> sp.Matrix:
        """The geometric Jacobian, 6 x n (6.11, 6.12)."""
        return self.substitute_matrix(_geometric_jacobian(self._structure))

    @cached_property
    def jacobian(self) -> sp.Matrix:
        """The rows of the task in the geometric Jacobian, m x n."""
        return task_matrix(self.geometric, self.chain.task)

    def substitute_values(self, expression: sp.Expr) -> sp.Expr:
        """Return an expression of the structure with this arm's numbers and symbols substituted."""
        return substitute(expression, self._values)

    def substitute_matrix(self, matrix: sp.Matrix) -> sp.Matrix:
        """Return a matrix of the structure with this arm's numbers and symbols substituted.

        If the arm is described by its axes, its DH table has roots and angles that its file doesn't mention; these are
        simplified.
        """
        filled = matrix.applyfunc(self.substitute_values)
        if convention_of(self.chain).shows_table:
            return filled
        return filled.applyfunc(remove_arctangents).applyfunc(remove_brackets)

    @property
    def linear(self) -> sp.Matrix:
        """The linear rows of the geometric Jacobian, 3 x n."""
        return self.geometric[:3, :]

    @cached_property
    def generic_minors(self) -> tuple[Factored, ...]:
        """The maximal minors of the structure's task Jacobian (one, the determinant, if square), factored."""
        stored = _stored_minors.get(self.chain)
        return _generic_minors(self._structure) if stored is None else stored()

    @property
    def generic_joints(self) -> tuple[sp.Symbol, ...]:
        """The joint variables of the structure (without offsets)."""
        return self._structure.q

    @property
    def rotations(self) -> list[sp.Matrix]:
        """R_0 ... R_n, with absolute angles within a run of parallel joints."""
        return [self.substitute_matrix(frame.rotation) for frame in link_frames(self._structure)]

    @property
    def link_vectors(self) -> list[sp.Matrix]:
        """r_1 ... r_n, each from O_{i-1} to O_i in frame i-1 (below 6.13)."""
        convention = convention_of(self.chain)
        return [convention.link_vector(row) for row in convention.rows]

    @property
    def is_square(self) -> bool:
        """Whether the task has as many rows as the arm has joints, so that J has a determinant."""
        return len(self.chain.task) == self.chain.n

    @property
    def determinant(self) -> sp.Expr:
        """det J in factored form; ValueError if J is not square."""
        self._require_square("determinant")
        return self.generic_minors[0].substitute(self._values)

    @property
    def inverse(self) -> sp.Matrix:
        """J^-1, n x n, by the adjugate; ValueError if J is not square or never invertible."""
        self._require_square("inverse")
        if self.generic_minors[0].is_zero:
            raise ValueError(f"{self.chain.name}: det J = 0 everywhere, so J has no inverse")
        rows = [[entry.substitute(self._values) for entry in row] for row in _generic_inverse(self._structure)]
        return sp.Matrix(rows)

    def _require_square(self, quantity: str) -> None:
        """Raise ValueError if J is not square; `quantity` is the subject of the message."""
        if not self.is_square:
            shape = f"{len(self.chain.task)} x {self.chain.n}"
            raise ValueError(f"{self.chain.name}: the {quantity} needs a square Jacobian, but this one is {shape}")

    def link_jacobian(self, k: int) -> sp.Matrix:
        """Return the 6 x n Jacobian of frame k: the velocity of O_k and of link k ((6.9), (6.10), sums up to k)."""
        first_columns = derive(convention_of(self.chain).first_joints(k)).geometric
        return sp.Matrix.hstack(first_columns, sp.zeros(6, self.chain.n - k))

    def twist(self, jacobian: sp.Matrix | None = None) -> sp.Matrix:
        """Return J qd for the geometric Jacobian (6.4), or for another matrix with n columns."""
        return (self.geometric if jacobian is None else jacobian) * sp.Matrix(self.chain.rates)

    def rate_law(self) -> sp.Matrix:
        """Return the joint rates qd = J^-1 xd for the task velocity symbols vx ... wz (6.7)."""
        self._require_square("inverse velocity")
        if self.generic_minors[0].is_zero:
            raise ValueError(f"{self.chain.name}: det J = 0 everywhere, so the joint rates can't be found")
        return sp.Matrix([rate.substitute(self._values) for rate in _generic_rates(self._structure)])


def task_velocity(chain: Chain) -> tuple[sp.Symbol, ...]:
    """Return the symbols of the task's velocity, such as vx, vy."""
    return tuple(sp.Symbol(row) for row in chain.task)


@lru_cache(maxsize=512)
def derive(chain: Chain) -> Derivation:
    """Return the derivation of `chain`; it is cached, because several questions use that of the same arm."""
    return Derivation(chain)
