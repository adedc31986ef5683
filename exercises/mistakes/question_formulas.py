"""Mistakes in the formula of an instructor's question, such as another component or frame, or a forgotten root.

The stages of the derivation stay correct. A mistake rewrites the formula of the question, and the wrong answer is the
value of the new formula.
"""

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from functools import partial
from itertools import combinations

import numpy as np

from qdot.exercises.derivation.graph import RESULT, StageResults
from qdot.exercises.mistakes.base import FormulaVariantGenerator, MistakeVariant
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.custom import CustomDetails
from qdot.exercises.questions.custom.question import QuestionMaker
from qdot.exercises.questions.language import AXES, find_names, parse

Rewriting = Callable[[ast.expr], ast.expr | None]
"""Returns the new form of a node of a formula, or None for a node that stays unchanged."""
ALL_OF_ANSWER = "In your answer,"
"""The place of a mistake that concerns the whole answer."""
_FRAME_NUMBER = re.compile(r"([oxyz]|[RT]\d)(\d)")
"""Matches names such as o1, z0 and R02, and the last frame in them."""


def find_formula(part: Part) -> ast.expr | None:
    """Return the formula of an instructor's question; None for other questions, sets, options and texts."""
    if not isinstance(part.details, CustomDetails) or part.answer.offered_options:
        return None
    maker = QuestionMaker(part.details.definition)
    return maker.formulas[0] if maker.formulas and not maker.is_set else None


def _vary_formula(list_variants: Callable[[ast.expr, Part], Iterator[MistakeVariant]]) -> FormulaVariantGenerator:
    """Return a function that yields the variants of a mistake in the formula of an instructor's question, if any."""

    def generate(part: Part) -> Iterator[MistakeVariant]:
        formula = find_formula(part)
        return iter(()) if formula is None else list_variants(formula, part)

    return generate


def _rewrite_each(list_rewritings: Callable[[ast.expr], Iterator[Rewriting]]) -> FormulaVariantGenerator:
    """Return a function that yields a variant for each rewriting that changes the formula."""

    def list_variants(formula: ast.expr, part: Part) -> Iterator[MistakeVariant]:
        for rewriting in list_rewritings(formula):
            new_formula = _rewrite(formula, rewriting)
            if ast.dump(new_formula) != ast.dump(formula):
                yield _make_variant(part, new_formula)

    return _vary_formula(list_variants)


def _make_variant(part: Part, new_formula: ast.expr, which: str = "") -> MistakeVariant:
    maker = QuestionMaker(part.details_as(CustomDetails).definition)

    def compute_new_formula(stages: StageResults, _: np.ndarray) -> np.ndarray:
        value = maker.compute_formula(new_formula, stages)
        return value[:, None] if value.ndim == 2 else value

    return MistakeVariant({RESULT: compute_new_formula}, words={"Where": ALL_OF_ANSWER, "which": which})


class _Rewriter(ast.NodeTransformer):
    """Replaces the nodes of a formula for which a rewriting returns another one, from the inner nodes to the outer."""

    def __init__(self, rewriting: Rewriting) -> None:
        self.rewriting = rewriting

    def visit(self, node: ast.AST) -> ast.AST:
        """Return the node with its replaced parts, or its own replacement."""
        node = self.generic_visit(node)
        return (self.rewriting(node) if isinstance(node, ast.expr) else None) or node


def _rewrite(formula: ast.expr, rewriting: Rewriting) -> ast.expr:
    new_formula = _Rewriter(rewriting).visit(deepcopy(formula))
    assert isinstance(new_formula, ast.expr)
    return new_formula


# --- another component or frame ---


def _exchange_components(formula: ast.expr) -> Iterator[Rewriting]:
    """Yield the exchange of x and y, and of other pairs of components or rows, wherever the formula selects one."""
    for i, j in combinations(range(len(AXES)), 2):
        yield partial(_select_other_component, i=i, j=j)


def _select_other_component(node: ast.expr, i: int, j: int) -> ast.expr | None:
    axes, exchanged = list(AXES), {i: j, j: i}
    if isinstance(node, ast.Attribute) and AXES.get(node.attr) in exchanged:
        return ast.Attribute(node.value, axes[exchanged[AXES[node.attr]]])
    if isinstance(node, ast.Subscript):
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        row = indices[0].value if isinstance(indices[0], ast.Constant) else 0
        if isinstance(row, int) and row - 1 in exchanged:
            new_indices = [ast.Constant(exchanged[row - 1] + 1), *indices[1:]]
            return ast.Subscript(node.value, ast.Tuple(new_indices) if len(new_indices) > 1 else new_indices[0])
    if isinstance(node, ast.List) and len(node.elts) == len(axes) == 1 + sum(map(_is_zero, node.elts)):
        return ast.List([node.elts[exchanged.get(k, k)] for k in range(len(axes))])
    return None


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == 0


def _omit_components(formula: ast.expr) -> Iterator[Rewriting]:
    """Yield the omission of the first, second or third component of each vector with several components."""
    for index in range(len(AXES)):
        yield partial(_omit_component, index=index)


def _omit_component(node: ast.expr, index: int) -> ast.expr | None:
    if isinstance(node, ast.List) and len(node.elts) > max(index, 1 + sum(map(_is_zero, node.elts))):
        return ast.List([*node.elts[:index], ast.Constant(0), *node.elts[index + 1 :]])
    match node:
        case ast.Call(func=ast.Name(id="dot"), args=[u, w]) if ast.List not in (type(u), type(w)):
            entries = [ast.Subscript(vector, ast.Constant(index + 1)) for vector in (u, w)]
            return ast.BinOp(node, ast.Sub(), ast.BinOp(entries[0], ast.Mult(), entries[1]))
    return None


def _choose_next_frames(formula: ast.expr) -> Iterator[Rewriting]:
    """Yield the replacement of every frame in the formula by the frame before it, or after it."""
    for step in (-1, 1):
        yield partial(_shift_frame, step=step)


def _shift_frame(node: ast.expr, step: int) -> ast.expr | None:
    match = _FRAME_NUMBER.fullmatch(node.id) if isinstance(node, ast.Name) else None
    return match and ast.Name(f"{match[1]}{int(match[2]) + step}")


def _replace_name(node: ast.expr, name: str, replacement: ast.expr) -> ast.expr | None:
    return replacement if isinstance(node, ast.Name) and node.id == name else None


# --- lengths of vectors ---


def _replace_norm(*new_formulas: str) -> Callable[[ast.expr], Iterator[Rewriting]]:
    """Return a function that yields the replacement of norm(u), or of the root of squares, by each formula in u."""

    def replace(node: ast.expr, new_formula: str) -> ast.expr | None:
        match node:
            case ast.Call(func=ast.Name(id="norm"), args=[vector]):
                pass
            case ast.Call(func=ast.Name(id="sqrt"), args=[radicand]) if components := _list_squared(radicand):
                vector = ast.List(components)
            case _:
                return None
        return _rewrite(parse(new_formula), partial(_replace_name, name="u", replacement=vector))

    return lambda formula: (partial(replace, new_formula=text) for text in new_formulas)


def _list_squared(radicand: ast.expr) -> list[ast.expr]:
    """Return what is squared in a square or a sum of squares; nothing for another formula."""
    match radicand:
        case ast.BinOp(left=base, op=ast.Pow(), right=ast.Constant(value=2)):
            return [base]
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            parts = [_list_squared(left), _list_squared(right)]
            return [*parts[0], *parts[1]] if all(parts) else []
    return []


def _omit_square(node: ast.expr) -> ast.expr | None:
    match node:
        case ast.BinOp(left=base, op=ast.Pow(), right=ast.Constant(value=2)):
            return base
        case ast.Call(func=ast.Name(id="dot"), args=[u, w]) if ast.dump(u) == ast.dump(w):
            return ast.Call(ast.Name("norm"), [u], [])
    return None


# --- transposed matrices ---


def _transpose_otherwise(formula: ast.expr) -> Iterator[Rewriting]:
    if "f" not in find_names(formula):  # otherwise, the catalogue has a mistake about the load
        yield _drop_transposition
    yield _transpose_other_factor
    yield _transpose_last_factor
    for columns in ((0, 1), (0, 2)):
        yield partial(_multiply_by_task_rows, columns=columns)


def _drop_transposition(node: ast.expr) -> ast.expr | None:
    match node:
        case ast.Call(func=ast.Name(id="transpose"), args=[matrix]):
            return matrix
    return None


def _transpose_other_factor(node: ast.expr) -> ast.expr | None:
    """Return J^T J for J J^T, and vice versa."""
    match node:
        case (
            ast.BinOp(left=ast.Call(func=ast.Name(id="transpose")), op=ast.Mult())
            | ast.BinOp(op=ast.Mult(), right=ast.Call(func=ast.Name(id="transpose")))
        ):
            factors = [_drop_transposition(node.left), _drop_transposition(node.right)]
            if (factors[0] is None) != (factors[1] is None):
                return ast.BinOp(node.right, ast.Mult(), node.left)
    return None


def _transpose_last_factor(node: ast.expr) -> ast.expr | None:
    """Return m J J^T for m J^T J, and J m J^T for J^T m J."""
    match node:
        case ast.BinOp(left=ast.BinOp(left=first, op=ast.Mult(), right=second), op=ast.Mult(), right=last):
            matrices = [first, second]
            for i, factor in enumerate(matrices):
                matrix = _drop_transposition(factor)
                if matrix is not None and ast.dump(matrix) == ast.dump(last):
                    matrices[i] = last
                    return ast.BinOp(ast.BinOp(matrices[0], ast.Mult(), matrices[1]), ast.Mult(), factor)
    return None


def _multiply_by_task_rows(node: ast.expr, columns: Sequence[int]) -> ast.expr | None:
    """Return J f, with two components of f, for Jv^T f, because Jv f has no meaning for a planar arm."""
    match node:
        case ast.BinOp(left=ast.Call(func=ast.Name(id="transpose"), args=[ast.Name(id="Jv")]), right=ast.List(elts=f)):
            if len(f) == len(AXES):
                return ast.BinOp(ast.Name("J"), ast.Mult(), ast.List([f[k] for k in columns]))
    return None


# --- factors of numbers ---


def _forget_factors(formula: ast.expr, part: Part) -> Iterator[MistakeVariant]:
    """Yield the number without each symbol that the question introduces or gives, such as g or a joint rate."""
    details = part.details_as(CustomDetails)
    names = {name for name, _ in details.definition.units} | {symbol.name for symbol in details.values}
    for name in sorted(find_names(formula) & names) if part.type == "number" else ():
        replacement = partial(_replace_name, name=name, replacement=ast.Constant(1))
        yield _make_variant(part, _rewrite(formula, replacement), f" (with {name})")


FORMULA_VARIANTS: dict[str, FormulaVariantGenerator] = {
    "other-component": _rewrite_each(_exchange_components),
    "component-left-out": _rewrite_each(_omit_components),
    "other-frame": _rewrite_each(_choose_next_frames),
    "speed-squared": _rewrite_each(_replace_norm("dot(u, u)")),
    "square-missing": _rewrite_each(lambda _: iter([_omit_square])),
    "components-added": _rewrite_each(_replace_norm(
        "dot(u, [1, 1])", "dot(u, [1, 1, 1])", "abs(u[1]) + abs(u[2]) + 0*dot(u, [1, 1])",
        "abs(u[1]) + abs(u[2]) + abs(u[3])",
    )),
    "component-alone": _rewrite_each(_replace_norm("u[1]", "u[2]", "u[3]", "abs(u[1])", "abs(u[2])", "abs(u[3])")),
    "transposed-wrongly": _rewrite_each(_transpose_otherwise),
    "factor-missing": _vary_formula(_forget_factors),
}  # fmt: skip
"""Maps the name of each mistake in the formula of a question to the function that yields its variants."""
