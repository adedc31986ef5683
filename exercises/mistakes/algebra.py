"""Mistakes in results computed from a Jacobian: its determinant, its inverse, rates and torques."""

from collections.abc import Callable, Iterator
from itertools import combinations
from itertools import product as product_of
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, determinant, product, signs
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import Change, Working, links_to_point, singular_vectors
from qdot.exercises.mistakes.base import Mistake, MistakeVariant, Shape


def _is_square(chain: Chain, least: int = 2, most: int = 6) -> bool:
    return len(chain.task) == chain.n and least <= chain.n <= most


def _single_variant(
    stage: str, change: Change, least: int = 2, most: int = 6
) -> Callable[[Chain, Shape], Iterator[MistakeVariant]]:
    def slips(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
        if _is_square(chain, least, most):
            yield MistakeVariant({stage: change})

    return slips


def _add_all_products(w: Working, _: np.ndarray) -> np.ndarray:
    return determinant(w["jacobian"], 1)


def _expand_without_signs(w: Working, _: np.ndarray) -> np.ndarray:
    """Expand along the first row with right 2 x 2 minors, but without their signs."""
    return np.asarray((w["jacobian"][0] * w["minors"][0]).sum(axis=0))


def _multiply_diagonal(w: Working, _: np.ndarray) -> np.ndarray:
    corner = w["jacobian"][0, 0]
    for k in range(1, w.n):
        corner = corner * w["jacobian"][k, k]
    return np.asarray(corner)


def _lose_factor(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if not _is_square(chain, 1):
        return
    generic = derive(chain).generic_minors[0]
    values = dict(structure(chain).values)
    for factor, _power in generic.factors:
        arm_factor = factor.xreplace(values)
        if len(generic.factors) > 1 and not arm_factor.is_number:
            yield _variant_without_factor("determinant", chain, arm_factor, arm_factor)


def _exchange_trig(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    """Exchange sine and cosine in a factor that is one of them.

    With a constant in the angle it can be written as either, so that both signs may come of it.
    """
    if not _is_square(chain, 1):
        return
    values, constants = dict(structure(chain).values), dict(zip(chain.q, chain.offsets, strict=True))
    for factor, _power in derive(chain).generic_minors[0].factors:
        arm_factor = factor.xreplace(values)
        waves = arm_factor.atoms(sp.sin, sp.cos)
        if len(waves) == 1 and (arm_factor / (wave := waves.pop())).is_number:
            exchanged = (sp.cos if isinstance(wave, sp.sin) else sp.sin)(*wave.args)
            yield MistakeVariant({"determinant": _divide_by(wave / exchanged)})
            if any(constants.get(symbol, 0) != 0 for symbol in wave.free_symbols):
                yield MistakeVariant({"determinant": _divide_by(-wave / exchanged)})


def _variant_without_factor(stage: str, chain: Chain, factor: Any, divisor: Any) -> MistakeVariant:
    """Return the variant in which a stage lacks a factor: the stage is divided by it."""
    symbols = {str(symbol) for symbol in factor.free_symbols}
    moving = symbols & set(map(str, chain.q))
    kind = "one that depends on the joints" if moving else "a length"
    return MistakeVariant({stage: _divide_by(divisor)}, {"factor": kind}, missing=", ".join(sorted(moving or symbols)))


def _divide_by(factor: object) -> Change:
    def apply_change(w: Working, right: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.asarray(right / w.arithmetic.value(w.arithmetic.table_entry(factor)))

    return apply_change


def _multiply_by_jacobian(w: Working, _: np.ndarray) -> np.ndarray:
    return apply_matrix(w["jacobian"], w["wanted velocity"])


def _take_reciprocals(w: Working, _: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        unit = w["jacobian"] * 0 + 1
        return np.asarray(
            np.where(w["jacobian"] == 0, w["jacobian"], unit / np.where(w["jacobian"] == 0, 1, w["jacobian"]))
        )


def _divide_again(w: Working, right: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.asarray(right / w["determinant"])


def _exchange_velocity(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_square(chain) and chain.n == 2:
        yield MistakeVariant({"wanted velocity": lambda w, velocity: velocity[::-1]})


def _is_wide(chain: Chain) -> bool:
    return chain.n > len(chain.task)


def _use_transpose(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    yield from _single_variant("inverse", lambda w, _: w["transposed jacobian"])(chain, shape)
    if _is_wide(chain):
        yield MistakeVariant({"pseudo-inverse": lambda w, _: w["transposed jacobian"]})


def _skip_inversion(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_wide(chain):
        yield MistakeVariant({"pseudo-inverse": lambda w, _: product(w["transposed jacobian"], w["gram matrix"])})


def _drop_cofactor_signs(chain: Chain, shape: Shape) -> Iterator[MistakeVariant]:
    yield from _single_variant("cofactors", lambda w, _: w["minors"])(chain, shape)
    if chain.n == len(chain.task) + 1:
        yield MistakeVariant({"self-motion": lambda w, motion: motion * signs(w.n)[0][:, None]})


def _miscount_minors(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    """Take the square of one maximal minor for the sum of all squares; or leave one out."""
    if _is_wide(chain):
        m = len(chain.task)
        for columns in combinations(range(chain.n), m):

            def apply_change(w: Working, _value: np.ndarray, columns: tuple[int, ...] = columns) -> np.ndarray:
                minor = determinant(w["jacobian"][:, list(columns)])
                return np.asarray(minor * minor)

            yield MistakeVariant({"gram determinant": apply_change})
            yield MistakeVariant({"gram determinant": lambda w, value, c=apply_change: value - c(w, value)})  # type: ignore[misc]


def _skip_squares(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_wide(chain):

        def apply_change(w: Working, _: np.ndarray) -> np.ndarray:
            chosen = combinations(range(w.n), len(w.chain.task))
            return np.asarray(sum(determinant(w["jacobian"][:, list(columns)]) for columns in chosen))

        yield MistakeVariant({"gram determinant": apply_change})


def _take_root(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_wide(chain):
        yield MistakeVariant({"gram determinant": lambda w, value: w.arithmetic.sqrt(value)})


def _choose_moving_direction(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if len(chain.task) == 2:
        yield MistakeVariant({"lost direction": lambda w, _: singular_vectors(w)[0][:, 0]})


def _choose_null_vector(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_square(chain):
        yield MistakeVariant({"lost direction": lambda w, _: singular_vectors(w)[2][-1]})


def _skip_transpose(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_square(chain):
        yield MistakeVariant({"transposed jacobian": lambda w, _: w["jacobian"]})


def _flip_product_sign(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    """Give one product of the expansion the wrong sign: an entry, or the part of a link in it, times its cofactor."""
    if not _is_square(chain, 2, 3):
        return
    axes = [TASK_ROWS.index(row) for row in chain.task]
    for row, column in product_of(range(chain.n), range(chain.n)):

        def whole(w: Working, value: np.ndarray, i: int = row, j: int = column) -> np.ndarray:
            return np.asarray(value - 2 * w["jacobian"][i, j] * w["cofactors"][i, j])

        yield MistakeVariant({"determinant": whole})
        for link in links_to_point(chain) if axes[row] < 3 else ():

            def part(w: Working, value: np.ndarray, i: int = row, j: int = column, k: int = link) -> np.ndarray:
                return np.asarray(value - 2 * w["effects"][j, k, axes[i]] * w["cofactors"][i, j])

            yield MistakeVariant({"determinant": part})


def _add_blocks(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_square(chain, 6):

        def apply_change(w: Working, _: np.ndarray) -> np.ndarray:
            return np.asarray(determinant(w["arm block"]) + determinant(w["wrist block"]))

        yield MistakeVariant({"determinant": apply_change})


def _solve_wrist_alone(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_square(chain, 6):

        def apply_change(w: Working, jacobian: np.ndarray) -> np.ndarray:
            out = np.array(jacobian)
            out[3:, :3] = 0 * out[3:, :3]
            return out

        yield MistakeVariant({"jacobian": apply_change})


def _square_sum(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    if _is_wide(chain):
        for sign in (1, -1):

            def apply_change(w: Working, _: np.ndarray, sign: int = sign) -> np.ndarray:
                chosen = combinations(range(w.n), len(w.chain.task))
                total = sum(sign**k * determinant(w["jacobian"][:, list(some)]) for k, some in enumerate(chosen))
                return np.asarray(total * total)

            yield MistakeVariant({"gram determinant": apply_change})


def _lose_square(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    """Lose one of several equal factors of the determinant in its absolute value."""
    if _is_square(chain, 1):
        values = dict(structure(chain).values)
        for factor, power in derive(chain).generic_minors[0].factors:
            arm_factor = factor.xreplace(values)
            if power > 1 and not arm_factor.is_number:
                yield _variant_without_factor("manipulability", chain, arm_factor, sp.Abs(arm_factor))


def _flip_velocity_sign(chain: Chain, _: Shape) -> Iterator[MistakeVariant]:
    for i, name in enumerate(chain.task):

        def apply_change(w: Working, velocity: np.ndarray, i: int = i) -> np.ndarray:
            out = np.array(velocity)
            out[i] = -out[i]
            return out

        yield MistakeVariant({"wanted velocity": apply_change}, {"name": name})


MISTAKES = (
    Mistake(
        "determinant-plus", "Plus for minus in the determinant",
        "The products of the determinant seem to be added throughout: every other one is subtracted.", "appendix",
        _single_variant("determinant", _add_all_products, 2, 3),
    ),
    Mistake(
        "expansion-signs", "Signs of the expansion left out",
        "The minors of the expansion seem to be added throughout: their signs alternate.", "appendix",
        _single_variant("determinant", _expand_without_signs, 3, 3),
    ),
    Mistake(
        "diagonal-only", "Product of the diagonal for the determinant",
        "The determinant seems to be the product of the diagonal, which holds for triangular matrices only.",
        "appendix", _single_variant("determinant", _multiply_diagonal),
    ),
    Mistake(
        "determinant-sign", "Determinant with the wrong sign",
        "The determinant seems to have the wrong sign: were two rows or columns exchanged?", "appendix",
        _single_variant("determinant", lambda w, value: -value, 1),
    ),
    Mistake(
        "wave-exchanged", "Sine and cosine exchanged in the determinant",
        "Sine and cosine seem to be exchanged in the determinant.", "6.8", _exchange_trig,
    ),
    Mistake(
        "factor-lost", "Factor of the determinant lost",
        "The determinant seems to lack a factor: {factor}.", "6.8", _lose_factor,
    ),
    Mistake(
        "transpose-for-inverse", "Transpose for the inverse",
        "The transpose of J seems to stand for its inverse. They are the same for rotations, not for a Jacobian.",
        "6.7", _use_transpose,
    ),
    Mistake(
        "gram-not-inverted", "J J^T not inverted",
        "J J^T seems to be multiplied by and not inverted: the pseudo-inverse holds its inverse.", "6.7",
        _skip_inversion,
    ),
    Mistake(
        "determinant-forgotten", "Division by the determinant forgotten",
        "The division by det J seems to be forgotten.", "appendix",
        _single_variant("inverse", lambda w, _: w["adjugate"]),
    ),
    Mistake(
        "determinant-multiplied", "Multiplied by the determinant",
        "The adjugate seems to be multiplied by det J: it is to be divided by it.", "appendix",
        _single_variant("inverse", lambda w, _: w["adjugate"] * w["determinant"], 1),
    ),
    Mistake(
        "determinant-squared", "Divided twice by the determinant",
        "The division by det J seems to be done twice.", "appendix", _single_variant("inverse", _divide_again, 1),
    ),
    Mistake(
        "adjugate-not-transposed", "Adjugate without the transpose",
        "The cofactors seem to stand where they were worked out: the adjugate is their transpose.", "appendix",
        _single_variant("adjugate", lambda w, _: w["cofactors"]),
    ),
    Mistake(
        "cofactor-signs", "Signs of the cofactors left out",
        "The cofactors seem to lack their signs: every other minor counts negative.", "appendix",
        _drop_cofactor_signs,
    ),
    Mistake(
        "reciprocal-entries", "Reciprocals of the entries for the inverse",
        "Each entry of J seems to be turned over by itself: the inverse of a matrix is not that.", "appendix",
        _single_variant("inverse", _take_reciprocals),
    ),
    Mistake(
        "jacobian-for-inverse", "J for its inverse",
        "The rates seem to be J times the velocity: they are J's inverse times it.", "6.7",
        _single_variant("rates", _multiply_by_jacobian),
    ),
    Mistake(
        "minor-missing", "Minor missing",
        "By Cauchy and Binet all maximal minors count, each squared. One or more seem to be missing.", "6.8",
        _miscount_minors,
    ),
    Mistake(
        "minors-not-squared", "Minors not squared",
        "The maximal minors seem to be added as they are: by Cauchy and Binet their squares are.", "6.8", _skip_squares,
    ),
    Mistake(
        "root-taken", "Root taken", "A square root seems to be taken that is not asked for.", "6.8", _take_root,
    ),
    Mistake(
        "direction-that-moves", "A direction that is not lost",
        "That is the direction in which the arm can still move. The lost one has no part along any column of J.", "6.8",
        _choose_moving_direction,
    ),
    Mistake(
        "null-vector-of-jacobian", "Joint rates for a direction of motion",
        "These seem to be joint rates that J takes to zero. A lost direction is a vector u with u J = 0.", "6.8",
        _choose_null_vector,
    ),
    Mistake(
        "jacobian-for-transpose", "J for its transpose",
        "The torques seem to be J times the load: by virtual work it is the transpose of J.", "dual of 6.4",
        _skip_transpose,
    ),
    Mistake(
        "product-sign", "Sign of one product of the determinant",
        "One product of the determinant seems to have the wrong sign: did terms add up that are to cancel?", "appendix",
        _flip_product_sign, rare=True,
    ),
    Mistake(
        "blocks-added", "Determinants of the blocks added",
        "The determinants of the blocks seem to be added: that of a block triangular matrix is their product.",
        "6.8", _add_blocks, rare=True,
    ),
    Mistake(
        "wrist-alone", "Wrist solved with the whole angular velocity",
        "The wrist seems to be solved with the whole angular velocity: what joints 1 to 3 turn is subtracted first.",
        "6.7", _solve_wrist_alone, rare=True,
    ),
    Mistake(
        "sum-squared", "Square of the sum of the minors",
        "The maximal minors seem to be added before they are squared: by Cauchy and Binet each square counts.", "6.8",
        _square_sum, rare=True,
    ),
    Mistake(
        "square-lost", "Square of a factor lost",
        "The determinant seems to hold a factor once that it holds more than once: {factor}.", "6.8", _lose_square,
        rare=True,
    ),
    Mistake(
        "velocity-sign", "Component of the velocity with the wrong sign",
        "The component {name} of the velocity seems to have the wrong sign.", "6.7", _flip_velocity_sign, rare=True,
    ),
    Mistake(
        "velocity-components-exchanged", "Components of the velocity exchanged",
        "The components of the velocity seem to be exchanged.", "6.7", _exchange_velocity,
    ),
)  # fmt: skip
