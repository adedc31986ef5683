"""How a determinant is worked out by hand: written in a short form, taken apart, and multiplied out.

Each step leaves the determinant unchanged: a value for joint 1, other axes and another point of the same body, or the
only entry of a row or column times its cofactor. All of it is done for an arm's structure; numbers are put in later.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import derive, short_jacobian
from qdot.exercises.arm.trigonometry import textbook

Fill = Callable[[sp.Expr], sp.Expr]


@dataclass(frozen=True)
class Step:
    """One step: its kind, and the determinant after it, `factor` times that of `matrix`.

    The kinds: "joint" (joint 1 has a value at which the matrix is short), "link" (in axes that are fixed in link
    `number`, and about a point of it), "alone" (`entry` is the only one in `line`, "row 2" say).
    """

    kind: str
    factor: sp.Expr
    matrix: sp.Matrix
    number: int = 0
    line: str = ""
    entry: sp.Expr = sp.S.Zero


@dataclass(frozen=True)
class Expansion:
    """The steps to a determinant, and what is left: a sum of products, and the result.

    `along` is the row or column along which a matrix of more than two rows is expanded; `uses_identities` says whether
    identities of sine and cosine lead from the products to the result.
    """

    steps: tuple[Step, ...]
    along: str
    products: tuple[sp.Expr, ...]
    uses_identities: bool = False

    def fill(self, fill: Fill, result: sp.Expr) -> "Expansion":
        """Return the expansion with numbers put in, and the result after its products."""
        steps = tuple(
            replace(step, factor=fill(step.factor), matrix=step.matrix.applyfunc(fill), entry=fill(step.entry))
            for step in self.steps
        )
        (products,) = map(fill, self.products)
        shown = {_without_sign(products), _without_sign(sp.factor_terms(products))}
        if shown & {_without_sign(result), _without_sign(sp.factor_terms(result))}:
            return replace(self, steps=steps, products=(result,))
        uses_identities = sp.expand(products - result) != 0
        return replace(self, steps=steps, products=(products, result), uses_identities=uses_identities)


def _without_sign(product: sp.Expr) -> sp.Expr:
    """Return a product up to its sign, which may stand before it or inside one of its brackets."""
    factors = (-factor if factor.could_extract_minus_sign() else factor for factor in sp.Mul.make_args(product))
    return sp.Mul(*map(sp.expand, factors))


def _tidy(entry: sp.Expr) -> sp.Expr:
    """Return an entry multiplied out, and as a textbook prints it if it has no roots of numbers."""
    expanded = sp.expand(entry)
    return expanded if any(power.is_number for power in expanded.atoms(sp.Pow)) else textbook(expanded)


def straight_joint_1(chain: Chain) -> sp.Expr:
    """Return the value of a structure's joint 1 that undoes the turn of its base, if one does, else zero."""
    return {sp.S.Zero: -chain.base.yaw, sp.pi: chain.base.yaw}.get(chain.base.tilt, sp.S.Zero)


@lru_cache(maxsize=512)
def jacobian_at_joint_1(chain: Chain) -> sp.Matrix | None:
    """Return J of a structure at that value of joint 1, None if this changes det J, or J stays as it is."""
    d, first = derive(chain), chain.q[0]
    if chain.joints[0].kind == "P" or not d.jacobian.has(first) or d.determinant.has(first):
        return None
    short = d.jacobian.xreplace({first: straight_joint_1(chain)})
    return short.applyfunc(_tidy)


@lru_cache(maxsize=1024)
def expand_jacobian(chain: Chain) -> Expansion:
    """Return how det J of a structure is worked out."""
    jacobian, short = derive(chain).jacobian, short_jacobian(chain)
    if short != jacobian:
        return expand_determinant(short, (Step("link", sp.S.One, short, number=chain.n // 2),))
    at_joint_1 = jacobian_at_joint_1(chain) if chain.n > 2 else None
    if at_joint_1 is None:
        return expand_determinant(jacobian)
    return expand_determinant(at_joint_1, (Step("joint", sp.S.One, at_joint_1),))


def expand_determinant(matrix: sp.Matrix, steps: tuple[Step, ...] = ()) -> Expansion:
    """Return how the determinant of a matrix is worked out, after `steps` that led to it."""
    factor: sp.Expr = sp.S.One
    line, places = sparsest_line(matrix)
    while matrix.rows > 2 and len(places) == 1:
        (place,) = places
        entry = matrix[place]
        factor, matrix = (-1) ** sum(place) * entry * factor, matrix.minor_submatrix(*place)
        steps = (*steps, Step("alone", factor, matrix, line=line, entry=entry))
        line, places = sparsest_line(matrix)
    if matrix.rows <= 2:
        total = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0] if matrix.rows == 2 else matrix[0, 0]
        return Expansion(steps, "", (factor * total,))
    minors = (textbook(sp.expand(matrix.minor_submatrix(*place).det(method="berkowitz"))) for place in places)
    products = ((-1) ** sum(place) * matrix[place] * minor for place, minor in zip(places, minors, strict=True))
    return Expansion(steps, line, (factor * sp.Add(*products),))


def sparsest_line(matrix: sp.Matrix) -> tuple[str, list[tuple[int, int]]]:
    """Return the row or column with the fewest and simplest entries other than zero, in words, and their places."""
    rows = [(f"row {i + 1}", [(i, j) for j in range(matrix.cols)]) for i in range(matrix.rows)]
    columns = [(f"column {j + 1}", [(i, j) for i in range(matrix.rows)]) for j in range(matrix.cols)]
    lines = [(name, [place for place in places if matrix[place] != 0]) for name, places in rows + columns]
    return min(lines, key=lambda line: (len(line[1]), sum(sp.count_ops(matrix[place]) for place in line[1])))
