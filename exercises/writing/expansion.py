"""How a determinant is worked out by hand: seen from a frame where it is short, taken apart, and multiplied out.

Each step leaves the determinant as it is: another frame, a column taken from another one, the only entry of a row or
column times its cofactor, blocks beside zeros. What is left are determinants of two rows, whose products are written
out before they are gathered. All of it is for an arm's structure, whose results are short; numbers are put in later.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations, pairwise, permutations

import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Base, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.derivation import derive, short_jacobian
from qdot.exercises.arm.kinematics import Z, frame_behind, link_frames, task_matrix
from qdot.exercises.arm.trigonometry import are_identical, textbook
from qdot.exercises.arm.vectors import rot_x

Fill = Callable[[sp.Expr], sp.Expr]
Values = Mapping[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class Step:
    """One step: its kind, what is special about it, and the determinant after it, `outside` times those of `inside`.

    The kinds: "frame" (the matrix is seen from frame `number`, about that frame's origin if `moved`), "columns" (of
    `pairs` of a column, a sign and another column, counted from 1, the other one is taken from or added to the first),
    "alone" (`entry` is the only one in `line`, "row 2" say, of a matrix), "blocks" (columns `number` at a time).
    """

    kind: str
    outside: sp.Expr
    inside: tuple[sp.Matrix, ...]
    number: int = 0
    moved: bool = False
    pairs: tuple[tuple[int, int, int], ...] = ()
    line: str = ""
    entry: sp.Expr = sp.S.Zero


@dataclass(frozen=True)
class Expansion:
    """The steps to a determinant, and what it is multiplied out: products as they come, gathered, and the result.

    `along` is the row or column along which what is left is expanded where it has more than two rows; `theorem` says
    by what the products become the result: "pythagoras", "addition", "both", or "" where it is plain algebra. It is
    `seen` where what is left has a single product without a zero.
    """

    steps: tuple[Step, ...]
    products: tuple[sp.Expr, ...]
    along: str
    theorem: str
    seen: bool

    def starts_with(self, kind: str) -> bool:
        """Tell whether a step of a kind comes first."""
        return bool(self.steps) and self.steps[0].kind == kind

    def filled(self, fill: Fill, result: sp.Expr, zeros: Values | None = None) -> "Expansion":
        """Return the same with numbers put in, and the result behind the products; nothing is there twice.

        That is looked for where joints are counted from their `zeros`, once for arms that differ in these.
        """
        steps = tuple(
            replace(
                step,
                outside=fill(step.outside),
                inside=tuple(matrix.applyfunc(fill) for matrix in step.inside),
                entry=fill(step.entry),
            )
            for step in self.steps
        )
        lines = [*map(fill, self.products), result]
        plain = [line.xreplace(zeros) for line in lines] if zeros else lines
        told = [line for line, pair in zip(lines, pairwise(plain), strict=False) if not _same_product(*pair)]
        return replace(self, steps=steps, products=(*told, result))


# --- frames ---


def frames_to_see_from(chain: Chain) -> Iterator[tuple[int, sp.Matrix]]:
    """Yield the numbers of frames, and the task Jacobian of P in their coordinates, with the same maximal minors.

    Those are left out in which the rows of the task would mix with others, or the minors would change their sign.
    """
    frames = link_frames(chain)
    rows = [TASK_ROWS.index(row) for row in chain.task]
    for k in range(1, chain.point.frame + 1):
        turned = sp.diag(frames[k].rotation.T, frames[k].rotation.T)
        others = [row for row in range(6) if row not in rows]
        if any(entry != 0 for entry in turned.extract(rows, others)):
            continue
        if are_identical(sp.expand(turned.extract(rows, rows).det(method="berkowitz")), sp.S.One):
            yield k, task_matrix(_seen_from(chain, k), chain.task)


@lru_cache(maxsize=1024)
def _seen_from(chain: Chain, k: int) -> sp.Matrix:
    """Return the geometric Jacobian (6.12) with all vectors in frame k, which is not behind P."""
    point = frame_behind(chain.joints[k : chain.point.frame]) if k < chain.point.frame else None
    offset = sp.Matrix(chain.point.offset)
    p = offset if point is None else point.origin + point.rotation * offset
    columns = []
    for i, joint in enumerate(chain.joints):
        between = frame_behind(chain.joints[min(i, k) : max(i, k)])
        if i < k:  # frame k seen from frame i
            z, arm = between.rotation.T * Z, between.rotation.T * between.origin + p
        else:
            z, arm = between.rotation * Z, p - between.origin
        linear, angular = (z.cross(arm), z) if joint.kind == "R" else (z, sp.zeros(3, 1))
        columns.append((linear if i < chain.point.frame else sp.zeros(3, 1)).col_join(angular))
    turn = _into_told(chain, k)
    return (sp.diag(turn, turn) * sp.Matrix.hstack(*columns)).applyfunc(lambda entry: textbook(sp.expand(entry)))


def _into_told(chain: Chain, k: int) -> sp.Matrix:
    """Return the rotation from standard frame k into the frame k that the arm's convention has on the same link."""
    return rot_x(convention_of(chain).from_standard(k)[0])


@lru_cache(maxsize=1024)
def _short(chain: Chain) -> sp.Matrix:
    """Return `short_jacobian` in frame k and about its origin as the arm's convention has them."""
    short, k = short_jacobian(chain), chain.n // 2
    if not convention_of(chain).has_frames_of_joints or short == derive(chain).jacobian:
        return short
    linear, angular = short[:3, :], short[3:, :]
    back = sp.Matrix([chain.joints[k - 1].a, 0, 0])  # from the origin of the told frame to that of the standard one
    moved = [linear[:, i] - angular[:, i].cross(back) for i in range(chain.n)]
    turn = _into_told(chain, k)
    whole = (turn * sp.Matrix.hstack(*moved)).col_join(turn * angular)
    return whole.applyfunc(lambda entry: textbook(sp.expand(entry)))


def seen_for_minors(chain: Chain) -> tuple[sp.Matrix, Step | None, bool]:
    """Return a matrix with the rank of a Jacobian that is not square, how it is seen, and whether joint 1 is at zero.

    A wide one is seen from a frame in which its maximal minors are the same and its entries are short. A tall one whose
    rows are all of a vector is seen from the base, with joint 1 at zero: it turns the whole arm, and no rank.
    """
    jacobian, step = derive(chain).jacobian, None
    if (short := _short(chain)) != jacobian:
        return short, Step("frame", sp.S.One, (short,), number=chain.n // 2, moved=True), False
    if jacobian.rows > jacobian.cols:
        whole = chain.task in (TASK_ROWS, TASK_ROWS[:3], TASK_ROWS[3:]) and chain.joints[0].kind == "R"
        if not whole:
            return jacobian, None, False
        convention = convention_of(chain)
        base = Base(tilt=chain.base.tilt - convention.base.tilt)  # by which the first row turns
        upright = replace(chain, base=base)
        seen = task_matrix(_seen_from(upright, 0), chain.task) if convention.has_frames else jacobian
        return seen.xreplace({chain.q[0]: sp.S.Zero}), None, True
    best = jacobian
    for k, seen in frames_to_see_from(chain):
        if _length(seen) < _length(best):
            best, step = seen, Step("frame", sp.S.One, (seen,), number=k)
    return best, step, False


def _length(matrix: sp.Matrix) -> int:
    return sum(map(sp.count_ops, matrix)) + _filled_places(matrix)


# --- the steps ---


@lru_cache(maxsize=1024)
def expansion_of(chain: Chain) -> Expansion:
    """Return how det J of a structure is worked out, from the frame in which that is short."""
    jacobian = derive(chain).jacobian
    if (short := _short(chain)) != jacobian:
        step = Step("frame", sp.S.One, (short,), number=chain.n // 2, moved=True)
        return _expanded(short, (step,))
    plain = _expanded(jacobian)
    if not plain.along:
        return plain
    ways = [plain]
    for k, seen in frames_to_see_from(chain):
        ways.append(_expanded(seen, (Step("frame", sp.S.One, (seen,), number=k),)))
    return min(ways, key=lambda way: (bool(way.along), sum(map(sp.count_ops, way.products))))


@lru_cache(maxsize=1024)
def expanded(matrix: sp.ImmutableMatrix) -> Expansion:
    """Return how the determinant of a matrix is worked out as it stands."""
    return _expanded(sp.Matrix(matrix))


def _expanded(matrix: sp.Matrix, steps: tuple[Step, ...] = ()) -> Expansion:
    outside: sp.Expr = sp.S.One
    done: list[sp.Matrix] = []
    left = [matrix]
    while left:
        first, *others = left
        step, parts = _next_step(first) if first.rows > 2 else (None, [])
        if step is None:
            done, left = [*done, first], others
            continue
        outside *= step.outside
        left = [*parts, *others]
        step = replace(step, outside=outside, inside=(*done, *left))
        if steps and step.kind == steps[-1].kind == "columns":
            steps, step = steps[:-1], replace(step, pairs=steps[-1].pairs + step.pairs)
        steps = (*steps, step)
    lines = [sparsest(part) if part.rows > 2 and only_product(part) is None else ("", []) for part in done]
    written = [_written_out(part, line) for part, (_, line) in zip(done, lines, strict=True)]
    raw, gathered = sp.Mul(outside, *written), sp.Mul(outside, *map(_gathered, written))
    along = next((name for name, _ in lines if name), "")
    theorem = _theorem(gathered)
    seen = len(done) == 1 and done[0].rows > 1 and only_product(done[0]) is not None
    # What needs no theorem is gathered in one step with the result.
    return Expansion(steps, tuple(dict.fromkeys((raw, gathered))) if theorem else (raw,), along, theorem, seen)


def _next_step(matrix: sp.Matrix) -> tuple[Step | None, list[sp.Matrix]]:
    """Return what makes a matrix smaller, and the matrices that are left; (None, []) where it is seen as it is."""
    if only_product(matrix) is not None:
        return None, []
    if (alone := _alone(matrix)) is not None:
        line, row, column = alone
        sign = -1 if (row + column) % 2 else 1
        entry = matrix[row, column]
        return Step("alone", sign * entry, (), line=line, entry=entry), [matrix.minor_submatrix(row, column)]
    if (pair := _taken_from(matrix)) is not None:
        column, sign, other, simpler = pair
        return Step("columns", sp.S.One, (), pairs=((column + 1, sign, other + 1),)), [simpler]
    if (rows_columns := _block(matrix)) is not None:
        rows, columns = rows_columns
        size = matrix.rows
        other_rows = [i for i in range(size) if i not in rows]
        other_columns = [j for j in range(size) if j not in columns]
        sign = sp.S(-1) if (sum(rows) + sum(columns)) % 2 else sp.S.One
        blocks = [matrix.extract(rows, columns), matrix.extract(other_rows, other_columns)]
        return Step("blocks", sign, (), number=len(rows)), blocks
    return None, []


MOST_ROWS_AT_ONCE = 4


def only_product(matrix: sp.Matrix) -> sp.Expr | None:
    """Return the determinant of a small matrix where of the products that it is the sum of one has no zero in it."""
    if matrix.rows > MOST_ROWS_AT_ONCE:
        return None
    orders = permutations(range(matrix.rows))
    left = [order for order in orders if all(matrix[i, j] != 0 for i, j in enumerate(order))]
    if len(left) != 1:
        return None
    (order,) = left
    swaps = sum(a > b for a, b in combinations(order, 2))
    return (-1) ** swaps * sp.Mul(*(matrix[i, j] for i, j in enumerate(order)))


def _lines(matrix: sp.Matrix) -> list[tuple[str, list[tuple[int, int]]]]:
    """Return every row and column in words, with the places of its entries that are not zero."""
    rows = [(f"row {i + 1}", [(i, j) for j in range(matrix.cols)]) for i in range(matrix.rows)]
    columns = [(f"column {j + 1}", [(i, j) for i in range(matrix.rows)]) for j in range(matrix.cols)]
    return [(name, [place for place in places if matrix[place] != 0]) for name, places in rows + columns]


def sparsest(matrix: sp.Matrix) -> tuple[str, list[tuple[int, int]]]:
    """Return the row or column with the most zeros, in words, and the places of its other entries."""
    return min(_lines(matrix), key=lambda line: (len(line[1]), sum(sp.count_ops(matrix[place]) for place in line[1])))


def _alone(matrix: sp.Matrix) -> tuple[str, int, int] | None:
    """Return the row or column with a single entry, and where that is; the simplest entry if there are several."""
    found = [(name, *places[0]) for name, places in _lines(matrix) if len(places) == 1]
    return min(found, key=lambda one: sp.count_ops(matrix[one[1], one[2]])) if found else None


def _taken_from(matrix: sp.Matrix) -> tuple[int, int, int, sp.Matrix] | None:
    """Return (column, sign, other, matrix): the other column, times the sign, taken from the first leaves zeros."""
    best = None
    for i, j in permutations(range(matrix.cols), 2):
        for sign in (1, -1):
            difference = (matrix[:, i] - sign * matrix[:, j]).applyfunc(lambda e: textbook(sp.expand(e)))
            saved = _filled_places(matrix[:, i]) - _filled_places(difference)
            key = (saved, -sum(map(sp.count_ops, difference)))
            if saved > 0 and (best is None or key > best[0]):
                best = key, i, sign, j, difference
    if best is None:
        return None
    _, i, sign, j, difference = best
    simpler = matrix.as_mutable()
    simpler[:, i] = difference
    return i, sign, j, simpler


def _filled_places(matrix: sp.Matrix) -> int:
    return sum(entry != 0 for entry in matrix)


def _block(matrix: sp.Matrix) -> tuple[list[int], list[int]] | None:
    """Return rows and columns of a square block beside or below which all entries are zero."""
    size = matrix.rows
    for count in range(2, size - 1):
        for columns in combinations(range(size), count):
            rows = [i for i in range(size) if any(matrix[i, j] != 0 for j in columns)]
            if len(rows) == count:
                return rows, list(columns)
    return None


# --- multiplied out ---


def _written_out(matrix: sp.Matrix, line: list[tuple[int, int]]) -> sp.Expr:
    """Return the determinant as products of entries; of a larger matrix, of entries of a row or column and minors."""
    if (product := only_product(matrix)) is not None:
        return product
    if matrix.rows == 2:
        return matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
    minors = (textbook(sp.expand(matrix.minor_submatrix(i, j).det(method="berkowitz"))) for i, j in line)
    return sp.Add(*((-1) ** (i + j) * matrix[i, j] * minor for (i, j), minor in zip(line, minors, strict=True)))


def _gathered(expression: sp.Expr) -> sp.Expr:
    """Return a sum multiplied out, with what all terms share outside; no theorem on angles is used.

    Sums of lengths stay together, where they are before several products: (d_3 + a_2)(c_1^2 + s_1^2).
    """
    if not expression.has(sp.Add):
        return expression
    plain = sp.factor_terms(sp.expand(expression))
    by_lengths = _by_lengths(plain)
    return by_lengths if sp.count_ops(by_lengths) < sp.count_ops(plain) else plain


def _by_lengths(product: sp.Expr) -> sp.Expr:
    """Return a product with the products of sines and cosines in its sums behind the lengths that several share."""
    return sp.Mul(*(_total_by_lengths(f) if f.is_Add else f for f in sp.Mul.make_args(product)))


def _total_by_lengths(total: sp.Expr) -> sp.Expr:
    lengths: dict[sp.Expr, list[sp.Expr]] = {}
    for term in sp.Add.make_args(sp.expand(total)):
        length, turning = term.as_independent(sp.sin, sp.cos, as_Add=False)
        lengths.setdefault(turning, []).append(length)
    turnings: dict[sp.Expr, list[sp.Expr]] = {}
    for turning, several in lengths.items():
        length = sp.Add(*several)
        sign = -1 if length.could_extract_minus_sign() else 1
        turnings.setdefault(sign * length, []).append(sign * turning)
    return sp.Add(*(length * sp.Add(*several) for length, several in turnings.items()))


@lru_cache(maxsize=4096)
def _same_product(one: sp.Expr, other: sp.Expr) -> bool:
    """Tell whether two products have the same factors, whichever of them have the minus signs."""

    def factors(product: sp.Expr) -> list[tuple[sp.Expr, sp.Expr]]:
        bases = (factor.as_base_exp() for factor in sp.Mul.make_args(sp.factor_terms(product)))
        plain = ((sp.expand(-base if base.could_extract_minus_sign() else base), power) for base, power in bases)
        return sorted((pair for pair in plain if pair[0] != 1), key=sp.default_sort_key)

    return one == other or (sp.expand(one - other) == 0 and factors(one) == factors(other))


def _theorem(expression: sp.Expr) -> str:
    """Return what is used to write products of sines and cosines shorter, if anything is."""
    result = textbook(sp.expand(expression))
    names = _names(expression, result)
    rules = [names[sp.sin(angle)] ** 2 + names[sp.cos(angle)] ** 2 - 1 for angle in _angles(expression, result)]
    difference = sp.expand((expression - result).xreplace(names))
    if difference == 0:
        return ""
    if sp.reduced(difference, rules, *names.values(), order="lex")[1] == 0:
        return "pythagoras"
    squares = any(power.base.func in (sp.sin, sp.cos) for power in sp.expand(expression).atoms(sp.Pow))
    return "both" if squares else "addition"


def _angles(*expressions: sp.Expr) -> list[sp.Expr]:
    angles = {atom.args[0] for expression in expressions for atom in expression.atoms(sp.sin, sp.cos)}
    return sorted(angles, key=sp.default_sort_key)


def _names(*expressions: sp.Expr) -> dict[sp.Expr, sp.Symbol]:
    """Return a symbol for the sine and for the cosine of every angle, each sum of angles being one of its own."""
    angles = _angles(*expressions)
    return {trig(angle): sp.Symbol(f"{trig}_{k}") for k, angle in enumerate(angles) for trig in (sp.sin, sp.cos)}
