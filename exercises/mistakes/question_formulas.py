"""Mistakes in the formula of an instructor's question, such as another component or frame, or a missing root.

The stages of the derivation stay correct. A mistake rewrites the formula, or substitutes other values for its symbols.
The wrong answer is the value of the new formula.
"""

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from functools import partial, reduce
from itertools import combinations

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.derivation.graph import RESULT, StageResults
from qdot.exercises.mistakes.base import FormulaVariantGenerator, MistakeVariant
from qdot.exercises.mistakes.formula_edits import find_stem, is_length
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions.custom import CustomDetails
from qdot.exercises.questions.language import AXES, find_names, parse

Rewriting = Callable[[ast.expr], ast.expr | None]
"""A function that returns a new node in place of a node of a formula, or None to leave the node unchanged."""
ALL_OF_ANSWER = "In your answer,"
"""The words in a message for a mistake that concerns the whole answer."""
_FRAME_NUMBER = re.compile(r"([oxyz]|[RT]\d)(\d)")
"""Matches names such as o1, z0 and R02. The second group is the last frame."""


def find_formula(part: Part) -> ast.expr | None:
    """Return the formula of an instructor's question; None for other questions, and for sets, options and texts."""
    if not isinstance(part.details, CustomDetails) or part.answer.offered_options:
        return None
    evaluator = part.details.evaluator
    return evaluator.formulas[0] if evaluator.formulas and not evaluator.is_set else None


def _vary_formula(
    list_variants: Callable[[ast.expr, Chain, Part], Iterator[MistakeVariant]],
) -> FormulaVariantGenerator:
    """Return a function that yields the variants of a mistake in the formula of a question, if there is a formula."""

    def generate(chain: Chain, part: Part) -> Iterator[MistakeVariant]:
        formula = find_formula(part)
        return iter(()) if formula is None else list_variants(formula, chain, part)

    return generate


def _rewrite_each(list_rewritings: Callable[[ast.expr], Iterator[Rewriting]]) -> FormulaVariantGenerator:
    """Return a function that yields a variant for each rewriting that changes the formula."""

    def list_variants(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
        for rewriting in list_rewritings(formula):
            new_formula = _rewrite(formula, rewriting)
            if ast.dump(new_formula) != ast.dump(formula):
                yield _make_variant(part, new_formula)

    return _vary_formula(list_variants)


def _make_variant(part: Part, new_formula: ast.expr, **words: str) -> MistakeVariant:
    """Return the variant in which the answer is the value of the new formula."""
    evaluator = part.details_as(CustomDetails).evaluator

    def compute_new_formula(stages: StageResults, _: np.ndarray) -> np.ndarray:
        value = evaluator.compute_formula(new_formula, stages)
        return value[:, None] if value.ndim == 2 else value

    return MistakeVariant({RESULT: compute_new_formula}, words={"Where": ALL_OF_ANSWER, "which": "", **words})


class _Rewriter(ast.NodeTransformer):
    """Replaces the nodes of a formula for which a rewriting returns a new node, inner nodes first."""

    def __init__(self, rewriting: Rewriting) -> None:
        self.rewriting = rewriting

    def visit(self, node: ast.AST) -> ast.AST:
        """Return the node with its inner nodes replaced, or the new node."""
        new_node = self.generic_visit(node)
        return (self.rewriting(new_node) if isinstance(new_node, ast.expr) else None) or new_node


def _rewrite(formula: ast.expr, rewriting: Rewriting) -> ast.expr:
    new_formula = _Rewriter(rewriting).visit(deepcopy(formula))
    assert isinstance(new_formula, ast.expr)
    return new_formula


# --- another component or frame ---


def _exchange_components(formula: ast.expr) -> Iterator[Rewriting]:
    """Yield the rewritings that exchange two components, or two rows, wherever the formula selects one of them."""
    for i, j in combinations(range(len(AXES)), 2):
        yield partial(_select_other_component, i=i, j=j)


def _select_other_component(node: ast.expr, i: int, j: int) -> ast.expr | None:
    """Return a node that selects component j instead of i, or i instead of j; None if it selects neither of them."""
    axes, exchanged = list(AXES), {i: j, j: i}
    if isinstance(node, ast.Attribute) and AXES.get(node.attr) in exchanged:
        return ast.Attribute(node.value, axes[exchanged[AXES[node.attr]]])
    if isinstance(node, ast.Subscript):
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        row = indices[0].value if isinstance(indices[0], ast.Constant) else 0
        if isinstance(row, int) and row - 1 in exchanged:
            new_indices = [ast.Constant(exchanged[row - 1] + 1), *indices[1:]]
            return ast.Subscript(node.value, ast.Tuple(new_indices) if len(new_indices) > 1 else new_indices[0])
    # a vector along an axis, such as [0, 0, 1], whose dot product selects a component
    if isinstance(node, ast.List) and len(node.elts) == len(axes) == 1 + sum(map(_is_zero, node.elts)):
        return ast.List([node.elts[exchanged.get(k, k)] for k in range(len(axes))])
    return None


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value == 0


def _omit_components(formula: ast.expr) -> Iterator[Rewriting]:
    """Yield the rewritings that omit the first, second or third component of vectors with several components."""
    for index in range(len(AXES)):
        yield partial(_omit_component, index=index)


def _omit_component(node: ast.expr, index: int) -> ast.expr | None:
    """Return a vector with 0 as one component, or u.w without one product of components; None for other nodes."""
    if isinstance(node, ast.List) and len(node.elts) > max(index, 1 + sum(map(_is_zero, node.elts))):
        return ast.List([*node.elts[:index], ast.Constant(0), *node.elts[index + 1 :]])
    match node:
        case ast.Call(func=ast.Name(id="dot"), args=[u, w]) if ast.List not in (type(u), type(w)):
            entries = [ast.Subscript(vector, ast.Constant(index + 1)) for vector in (u, w)]
            return ast.BinOp(node, ast.Sub(), ast.BinOp(entries[0], ast.Mult(), entries[1]))
    return None


def _choose_adjacent_frames(formula: ast.expr) -> Iterator[Rewriting]:
    """Yield the rewritings that replace the last frame in names such as R02 by the frame before it, or after it."""
    for step in (-1, 1):
        yield partial(_shift_frame, step=step)


def _shift_frame(node: ast.expr, step: int) -> ast.expr | None:
    match = _FRAME_NUMBER.fullmatch(node.id) if isinstance(node, ast.Name) else None
    return match and ast.Name(f"{match[1]}{int(match[2]) + step}")


def _replace_name(node: ast.expr, name: str, replacement: ast.expr) -> ast.expr | None:
    return replacement if isinstance(node, ast.Name) and node.id == name else None


# --- lengths of vectors ---


def _replace_norm(*new_formulas: str) -> Callable[[ast.expr], Iterator[Rewriting]]:
    """Return a function that yields the rewritings that replace norm(u), or a root of squares, by formulas in u."""

    def replace(node: ast.expr, new_formula: str) -> ast.expr | None:
        match node:
            case ast.Call(func=ast.Name(id="norm"), args=[vector]):
                pass
            case ast.Call(func=ast.Name(id="sqrt"), args=[radicand]) if components := _list_squared_bases(radicand):
                vector = ast.List(components)
            case _:
                return None
        return _rewrite(parse(new_formula), partial(_replace_name, name="u", replacement=vector))

    return lambda formula: (partial(replace, new_formula=text) for text in new_formulas)


def _list_squared_bases(radicand: ast.expr) -> list[ast.expr]:
    """Return the bases in a square or a sum of squares; [] for any other formula."""
    match radicand:
        case ast.BinOp(left=base, op=ast.Pow(), right=ast.Constant(value=2)):
            return [base]
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            left_bases, right_bases = _list_squared_bases(left), _list_squared_bases(right)
            return [*left_bases, *right_bases] if left_bases and right_bases else []
    return []


def _omit_square(node: ast.expr) -> ast.expr | None:
    """Return x for x^2, and norm(u) for dot(u, u); None for other nodes."""
    match node:
        case ast.BinOp(left=base, op=ast.Pow(), right=ast.Constant(value=2)):
            return base
        case ast.Call(func=ast.Name(id="dot"), args=[u, w]) if ast.dump(u) == ast.dump(w):
            return ast.Call(ast.Name("norm"), [u], [])
    return None


# --- transposed matrices ---


def _transpose_otherwise(formula: ast.expr) -> Iterator[Rewriting]:
    """Yield the rewritings that omit a transposition, or transpose another matrix instead."""
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
    """Return m J J^T for m J^T J, and J m J^T for J^T m J; m is any factor."""
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
    """Return J f for Jv^T f, with two components of f, because Jv f is undefined for a planar arm."""
    match node:
        case ast.BinOp(left=ast.Call(func=ast.Name(id="transpose"), args=[ast.Name(id="Jv")]), right=ast.List(elts=f)):
            if len(f) == len(AXES):
                return ast.BinOp(ast.Name("J"), ast.Mult(), ast.List([f[k] for k in columns]))
    return None


# --- other values of symbols ---


def _substitute(formula: ast.expr, values: Mapping[str, str]) -> ast.expr:
    """Return the formula with other values of some symbols; the values are formulas, too."""
    return ast.Call(ast.Name("at"), [formula], [ast.keyword(name, parse(value)) for name, value in values.items()])


def _list_units(chain: Chain, part: Part) -> dict[str, str]:
    return part.details_as(CustomDetails).evaluator.list_units_of_symbols(chain)


def _forget_factors(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
    """Yield variants of a number without one symbol that the question introduces or gives, such as g or a joint rate.

    The last variant is without the numbers in the formula.
    """
    if part.type != "number":
        return
    details = part.details_as(CustomDetails)
    names = {name for name, _ in details.definition.units} | {symbol.name for symbol in details.values}
    for name in sorted(names):
        yield _make_variant(part, _substitute(formula, {name: "1"}), which=f" that contains {name}")
    yield _make_variant(part, _rewrite(formula, _omit_number))


def _omit_number(node: ast.expr) -> ast.expr | None:
    match node:
        case ast.BinOp(left=ast.Constant(), op=ast.Mult(), right=factor):
            return factor
        case ast.BinOp(left=factor, op=ast.Mult(), right=ast.Constant()):
            return factor
        case ast.BinOp(left=ast.Constant(), op=ast.Div(), right=divisor):
            return ast.BinOp(ast.Constant(1), ast.Div(), divisor)
    return None


def _leave_out_symbols(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
    """Yield variants without one component of the load or task velocity, or without one joint rate in a number."""
    for name in [*_list_components(chain, part), *(rate.name for rate in chain.rates if part.type == "number")]:
        yield _make_variant(part, _substitute(formula, {name: "0"}), symbol=name)


def _change_signs(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
    """Yield variants with the opposite sign of one component of the load or of the task velocity."""
    for name in _list_components(chain, part):
        yield _make_variant(part, _substitute(formula, {name: f"-{name}"}), symbol=name)


def _list_components(chain: Chain, part: Part) -> list[str]:
    """Return the names of the components of the load and of the task velocity that a formula may contain."""
    return [name for name in _list_units(chain, part) if len(name) == 2 and name[0] in "fmvw" and name[1] in AXES]


def _exchange_symbols(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
    """Yield variants with two similar symbols exchanged, such as fx and fy, or two masses.

    Lengths are not among them, because another mistake exchanges lengths in the table.
    """
    units = {name: unit for name, unit in _list_units(chain, part).items() if unit != "rad" and not is_length(name)}
    for first_name, second_name in combinations(units, 2):
        if find_stem(first_name) == find_stem(second_name) and units[first_name] == units[second_name]:
            new_formula = _substitute(formula, {first_name: second_name, second_name: first_name})
            yield _make_variant(part, new_formula, one=first_name, other=second_name)


def _use_unit_vector(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
    """Yield variants with a unit vector instead of the task velocity or the force."""
    for letter in "vf":
        names = [letter + row[1] for row in chain.task if row[0] == "v"]
        length = f"sqrt({' + '.join(f'{name}^2' for name in names) or '1'})"
        yield _make_variant(part, _substitute(formula, {name: f"{name}/{length}" for name in names}))


def _drop_cross_terms(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
    """Yield the variant that adds the results for each joint rate alone, in a formula with squares (an energy)."""
    names, text = [rate.name for rate in chain.rates], ast.unparse(formula)
    square_count = text.count("** 2") + text.count("dot(")
    if len(names) > 1 and square_count > text.count("norm(") and "sqrt(" not in text:
        terms = [_substitute(formula, dict.fromkeys(set(names) - {name}, "0")) for name in names]
        yield _make_variant(part, reduce(lambda left, right: ast.BinOp(left, ast.Add(), right), terms))


def _use_degrees(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
    """Yield the variant of a number with joint angles in degrees."""
    names = find_names(formula) & {name for name, unit in _list_units(chain, part).items() if unit == "rad"}
    if part.type == "number" and names:
        yield _make_variant(part, _substitute(formula, {name: f"180/pi*{name}" for name in names}))


def _scale(factor: str) -> Callable[[ast.expr, Chain, Part], Iterator[MistakeVariant]]:
    """Return a function that yields the variant of a number with an additional factor."""

    def list_variants(formula: ast.expr, chain: Chain, part: Part) -> Iterator[MistakeVariant]:
        product = ast.BinOp(parse(factor), ast.Mult(), formula)
        return iter([_make_variant(part, product)] if part.type == "number" else [])

    return list_variants


FORMULA_VARIANTS: dict[str, FormulaVariantGenerator] = {
    "other-component": _rewrite_each(_exchange_components),
    "component-left-out": _rewrite_each(_omit_components),
    "other-frame": _rewrite_each(_choose_adjacent_frames),
    "speed-squared": _rewrite_each(_replace_norm("dot(u, u)")),
    "square-missing": _rewrite_each(lambda _: iter([_omit_square])),
    "components-added": _rewrite_each(_replace_norm(
        "dot(u, [1, 1])", "dot(u, [1, 1, 1])", "abs(u[1]) + abs(u[2]) + 0*dot(u, [1, 1])",
        "abs(u[1]) + abs(u[2]) + abs(u[3])",
    )),
    "component-alone": _rewrite_each(_replace_norm("u[1]", "u[2]", "u[3]", "abs(u[1])", "abs(u[2])", "abs(u[3])")),
    "transposed-wrongly": _rewrite_each(_transpose_otherwise),
    "factor-missing": _vary_formula(_forget_factors),
    "symbol-left-out": _vary_formula(_leave_out_symbols),
    "symbols-exchanged": _vary_formula(_exchange_symbols),
    "unit-vector": _vary_formula(_use_unit_vector),
    "symbol-sign": _vary_formula(_change_signs),
    "cross-terms-missing": _vary_formula(_drop_cross_terms),
    "degrees-as-radians": _vary_formula(_use_degrees),
    "entry-halved": _vary_formula(_scale("1/2")),
    "entry-doubled": _vary_formula(_scale("2")),
}  # fmt: skip
"""Maps the name of each mistake in the formula of a question to a function that yields its variants."""
