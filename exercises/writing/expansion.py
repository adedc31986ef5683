"""Expand a determinant in steps as by hand: simplify the matrix, expand along a row or column, and multiply out.

No step changes the determinant (see `ExpansionStep`). The steps are derived for an arm's structure, that is, for the
arm with symbols for its lengths. The arm's numbers are substituted later.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.trigonometry import to_textbook_form
from qdot.exercises.derivation.derivation import derive, shorten_jacobian

Substitution = Callable[[sp.Expr], sp.Expr]
"""A function that substitutes an arm's numbers in an expression of its structure."""


@dataclass(frozen=True)
class ExpansionStep:
    """A step of an expansion. After the step, the determinant is `factor` times the determinant of `matrix`.

    The kinds are:

    * "joint": joint 1 gets a value that shortens the matrix;
    * "link": J is expressed in axes fixed in link `number`, and about a point of that link;
    * "alone": `entry` is the only nonzero entry of `line`, for example of "row 2".
    """

    kind: str
    factor: sp.Expr
    matrix: sp.Matrix
    number: int = 0
    line: str = ""
    entry: sp.Expr = sp.S.Zero

    def with_numbers(self, substitute: Substitution) -> "ExpansionStep":
        """Return the step with numbers substituted."""
        factor, matrix, entry = substitute(self.factor), self.matrix.applyfunc(substitute), substitute(self.entry)
        return replace(self, factor=factor, matrix=matrix, entry=entry)


@dataclass(frozen=True)
class Expansion:
    """The steps of an expansion, and then the determinant in one or two forms (`products`), the last form simplified.

    `line` names the row or column along which a matrix with more than two rows is expanded. `uses_identities` says
    whether trigonometric identities lead from the first form to the last.
    """

    steps: tuple[ExpansionStep, ...]
    line: str
    products: tuple[sp.Expr, ...]
    uses_identities: bool = False

    def with_numbers(self, substitute: Substitution, result: sp.Expr) -> "Expansion":
        """Return the expansion with numbers substituted, and with the simplified `result` as the last form."""
        steps = tuple(step.with_numbers(substitute) for step in self.steps)
        (first_form,) = map(substitute, self.products)
        is_expanded = sp.expand(first_form - result) == 0  # quicker than the next test, which needs ±result
        if is_expanded or sp.expand(first_form + result) == 0:
            unsigned_forms = {_remove_signs(first_form), _remove_signs(sp.factor_terms(first_form))}
            if unsigned_forms & {_remove_signs(result), _remove_signs(sp.factor_terms(result))}:
                return replace(self, steps=steps, products=(result,))
        return replace(self, steps=steps, products=(first_form, result), uses_identities=not is_expanded)


def _remove_signs(product: sp.Expr) -> sp.Expr:
    """Return a product with a canonical sign of each factor; products that differ only by signs become equal."""
    factors = (-factor if factor.could_extract_minus_sign() else factor for factor in sp.Mul.make_args(product))
    return sp.Mul(*map(sp.expand, factors))


def _simplify_entry(entry: sp.Expr) -> sp.Expr:
    """Return an entry multiplied out, and in the textbook's form unless it contains roots of numbers."""
    new_entry = sp.expand(entry)
    return new_entry if any(power.is_number for power in new_entry.atoms(sp.Pow)) else to_textbook_form(new_entry)


def find_joint_1_value(chain: Chain) -> sp.Expr:
    """Return the value of joint 1 that cancels the rotation of a structure's base, or zero if no value does."""
    return {sp.S.Zero: -chain.base.yaw, sp.pi: chain.base.yaw}.get(chain.base.tilt, sp.S.Zero)


@lru_cache(maxsize=512)
def shorten_by_joint_1(chain: Chain) -> sp.Matrix | None:
    """Return J with joint 1 at `find_joint_1_value`; None if det J depends on joint 1, or if J does not."""
    derivation, theta_1 = derive(chain), chain.q[0]
    jacobian = derivation.jacobian
    if chain.joints[0].is_prismatic or not jacobian.has(theta_1) or derivation.determinant.has(theta_1):
        return None
    return jacobian.xreplace({theta_1: find_joint_1_value(chain)}).applyfunc(_simplify_entry)


@lru_cache(maxsize=1024)
def expand_jacobian(chain: Chain) -> Expansion:
    """Return the steps that expand det J of a structure."""
    jacobian_of_link = shorten_jacobian(chain)
    if jacobian_of_link != derive(chain).jacobian:
        step = ExpansionStep("link", sp.S.One, jacobian_of_link, number=chain.n // 2)
        return expand_determinant(jacobian_of_link, (step,))
    jacobian_at_value = shorten_by_joint_1(chain) if chain.n > 2 else None
    if jacobian_at_value is None:
        return expand_determinant(derive(chain).jacobian)
    return expand_determinant(jacobian_at_value, (ExpansionStep("joint", sp.S.One, jacobian_at_value),))


def expand_determinant(matrix: sp.Matrix, steps: tuple[ExpansionStep, ...] = ()) -> Expansion:
    """Return the steps that expand the determinant of a matrix, after the `steps` that led to the matrix."""
    factor: sp.Expr = sp.S.One
    submatrix, all_steps = matrix, steps
    line, positions = find_sparsest_line(submatrix)
    while submatrix.rows > 2 and len(positions) == 1:
        (position,) = positions
        entry = submatrix[position]
        factor = (-1) ** sum(position) * entry * factor
        submatrix = submatrix.minor_submatrix(*position)
        all_steps = (*all_steps, ExpansionStep("alone", factor, submatrix, line=line, entry=entry))
        line, positions = find_sparsest_line(submatrix)
    if submatrix.rows == 1:
        return Expansion(all_steps, "", (factor * submatrix[0, 0],))
    if submatrix.rows == 2:
        determinant = submatrix[0, 0] * submatrix[1, 1] - submatrix[0, 1] * submatrix[1, 0]
        return Expansion(all_steps, "", (factor * determinant,))
    products = []
    for position in positions:
        minor = to_textbook_form(sp.expand(submatrix.minor_submatrix(*position).det(method="berkowitz")))
        products.append((-1) ** sum(position) * submatrix[position] * minor)
    return Expansion(all_steps, line, (factor * sp.Add(*products),))


class Line(NamedTuple):
    """A row or column of a matrix: its name, such as "row 2", and the positions (row, column) of nonzero entries."""

    name: str
    positions: list[tuple[int, int]]


def find_sparsest_line(matrix: sp.Matrix) -> Line:
    """Return the row or column with the fewest nonzero entries; if several have as few, the one with the simplest."""
    rows = [Line(f"row {i + 1}", [(i, j) for j in range(matrix.cols)]) for i in range(matrix.rows)]
    columns = [Line(f"column {j + 1}", [(i, j) for i in range(matrix.rows)]) for j in range(matrix.cols)]
    lines = [Line(name, [p for p in positions if matrix[p] != 0]) for name, positions in rows + columns]
    return min(lines, key=lambda line: (len(line.positions), sum(sp.count_ops(matrix[p]) for p in line.positions)))
