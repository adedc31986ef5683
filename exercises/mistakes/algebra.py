"""Mistakes in what is made of a Jacobian: its determinant, its inverse, rates and torques."""

from collections.abc import Callable, Iterator
from itertools import combinations
from itertools import product as product_of
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import applied, determinant, product, signs
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import Change, Working, carried, singular_vectors
from qdot.exercises.mistakes.base import Mistake, Shape, Slip


def _square(chain: Chain, least: int = 2, most: int = 6) -> bool:
    return len(chain.task) == chain.n and least <= chain.n <= most


def _one(stage: str, change: Change, least: int = 2, most: int = 6) -> Callable[[Chain, Shape], Iterator[Slip]]:
    def slips(chain: Chain, _: Shape) -> Iterator[Slip]:
        if _square(chain, least, most):
            yield Slip({stage: change})

    return slips


def _plus_only(w: Working, _: np.ndarray) -> np.ndarray:
    return determinant(w["jacobian"], 1)


def _first_row_plus(w: Working, _: np.ndarray) -> np.ndarray:
    """Expansion along the first row, each 2 x 2 minor right, the signs between them forgotten."""
    return np.asarray((w["jacobian"][0] * w["minors"][0]).sum(axis=0))


def _diagonal(w: Working, _: np.ndarray) -> np.ndarray:
    corner = w["jacobian"][0, 0]
    for k in range(1, w.n):
        corner = corner * w["jacobian"][k, k]
    return np.asarray(corner)


def _factors(chain: Chain, _: Shape) -> Iterator[Slip]:
    if not _square(chain, 1):
        return
    generic = derive(chain).generic_minors[0]
    values = dict(structure(chain).values)
    for factor, _power in generic.factors:
        own = factor.xreplace(values)
        if len(generic.factors) > 1 and not own.is_number:
            yield _lost("determinant", chain, own, own)


def _trig_exchanged(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Exchange sine and cosine in a factor that is one of them.

    With a constant in the angle it can be written as either, so that both signs may come of it.
    """
    if not _square(chain, 1):
        return
    values, constants = dict(structure(chain).values), dict(zip(chain.q, chain.offsets, strict=True))
    for factor, _power in derive(chain).generic_minors[0].factors:
        own = factor.xreplace(values)
        waves = own.atoms(sp.sin, sp.cos)
        if len(waves) == 1 and (own / (wave := waves.pop())).is_number:
            other = (sp.cos if isinstance(wave, sp.sin) else sp.sin)(*wave.args)
            yield Slip({"determinant": _divided(wave / other)})
            if any(constants.get(symbol, 0) != 0 for symbol in wave.free_symbols):
                yield Slip({"determinant": _divided(-wave / other)})


def _lost(stage: str, chain: Chain, factor: Any, divisor: Any) -> Slip:
    """Return the slip by which a stage lacks a factor, which it is divided by."""
    symbols = {str(symbol) for symbol in factor.free_symbols}
    moving = symbols & set(map(str, chain.q))
    kind = "one that depends on the joints" if moving else "a length"
    return Slip({stage: _divided(divisor)}, {"factor": kind}, missing=", ".join(sorted(moving or symbols)))


def _divided(factor: object) -> Change:
    def changed(w: Working, right: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.asarray(right / w.arithmetic.value(w.arithmetic.stepped(factor)))

    return changed


def _jacobian_times(w: Working, _: np.ndarray) -> np.ndarray:
    return applied(w["jacobian"], w["wanted velocity"])


def _reciprocals(w: Working, _: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        one = w["jacobian"] * 0 + 1
        return np.asarray(
            np.where(w["jacobian"] == 0, w["jacobian"], one / np.where(w["jacobian"] == 0, 1, w["jacobian"]))
        )


def _divided_by_square(w: Working, right: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.asarray(right / w["determinant"])


def _velocity_exchanged(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _square(chain) and chain.n == 2:
        yield Slip({"wanted velocity": lambda w, velocity: velocity[::-1]})


def _wide(chain: Chain) -> bool:
    return chain.n > len(chain.task)


def _transpose(chain: Chain, shape: Shape) -> Iterator[Slip]:
    yield from _one("inverse", lambda w, _: w["transposed jacobian"])(chain, shape)
    if _wide(chain):
        yield Slip({"pseudo-inverse": lambda w, _: w["transposed jacobian"]})


def _not_inverted(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _wide(chain):
        yield Slip({"pseudo-inverse": lambda w, _: product(w["transposed jacobian"], w["gram matrix"])})


def _minor_signs(chain: Chain, shape: Shape) -> Iterator[Slip]:
    yield from _one("cofactors", lambda w, _: w["minors"])(chain, shape)
    if chain.n == len(chain.task) + 1:
        yield Slip({"self-motion": lambda w, found: found * signs(w.n)[0][:, None]})


def _one_square(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Take the square of one maximal minor for the sum of all; or leave one out."""
    if _wide(chain):
        m = len(chain.task)
        for columns in combinations(range(chain.n), m):

            def changed(w: Working, found: np.ndarray, columns: tuple[int, ...] = columns) -> np.ndarray:
                minor = determinant(w["jacobian"][:, list(columns)])
                return np.asarray(minor * minor)

            yield Slip({"gram determinant": changed})
            yield Slip({"gram determinant": lambda w, found, c=changed: found - c(w, found)})  # type: ignore[misc]


def _not_squared(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _wide(chain):

        def changed(w: Working, _: np.ndarray) -> np.ndarray:
            chosen = combinations(range(w.n), len(w.chain.task))
            return np.asarray(sum(determinant(w["jacobian"][:, list(columns)]) for columns in chosen))

        yield Slip({"gram determinant": changed})


def _rooted(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _wide(chain):
        yield Slip({"gram determinant": lambda w, found: w.arithmetic.sqrt(found)})


def _direction_that_moves(chain: Chain, _: Shape) -> Iterator[Slip]:
    if len(chain.task) == 2:
        yield Slip({"lost direction": lambda w, _: singular_vectors(w)[0][:, 0]})


def _null_vector_of_j(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _square(chain):
        yield Slip({"lost direction": lambda w, _: singular_vectors(w)[2][-1]})


def _no_transpose(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _square(chain):
        yield Slip({"transposed jacobian": lambda w, _: w["jacobian"]})


def _product_signs(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Give one product of the expansion the wrong sign: an entry, or the part of a link in it, times its cofactor."""
    if not _square(chain, 2, 3):
        return
    axes = [TASK_ROWS.index(row) for row in chain.task]
    for row, column in product_of(range(chain.n), range(chain.n)):

        def whole(w: Working, found: np.ndarray, i: int = row, j: int = column) -> np.ndarray:
            return np.asarray(found - 2 * w["jacobian"][i, j] * w["cofactors"][i, j])

        yield Slip({"determinant": whole})
        for link in carried(chain) if axes[row] < 3 else ():

            def part(w: Working, found: np.ndarray, i: int = row, j: int = column, k: int = link) -> np.ndarray:
                return np.asarray(found - 2 * w["effects"][j, k, axes[i]] * w["cofactors"][i, j])

            yield Slip({"determinant": part})


def _blocks_added(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _square(chain, 6):

        def changed(w: Working, _: np.ndarray) -> np.ndarray:
            return np.asarray(determinant(w["arm block"]) + determinant(w["wrist block"]))

        yield Slip({"determinant": changed})


def _wrist_alone(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _square(chain, 6):

        def changed(w: Working, jacobian: np.ndarray) -> np.ndarray:
            out = np.array(jacobian)
            out[3:, :3] = 0 * out[3:, :3]
            return out

        yield Slip({"jacobian": changed})


def _sum_squared(chain: Chain, _: Shape) -> Iterator[Slip]:
    if _wide(chain):
        for sign in (1, -1):

            def changed(w: Working, _: np.ndarray, sign: int = sign) -> np.ndarray:
                chosen = combinations(range(w.n), len(w.chain.task))
                total = sum(sign**k * determinant(w["jacobian"][:, list(some)]) for k, some in enumerate(chosen))
                return np.asarray(total * total)

            yield Slip({"gram determinant": changed})


def _square_lost(chain: Chain, _: Shape) -> Iterator[Slip]:
    """Lose one of several equal factors of the determinant in its absolute value."""
    if _square(chain, 1):
        values = dict(structure(chain).values)
        for factor, power in derive(chain).generic_minors[0].factors:
            own = factor.xreplace(values)
            if power > 1 and not own.is_number:
                yield _lost("manipulability", chain, own, sp.Abs(own))


def _velocity_sign(chain: Chain, _: Shape) -> Iterator[Slip]:
    for i, name in enumerate(chain.task):

        def changed(w: Working, velocity: np.ndarray, i: int = i) -> np.ndarray:
            out = np.array(velocity)
            out[i] = -out[i]
            return out

        yield Slip({"wanted velocity": changed}, {"name": name})


MISTAKES = (
    Mistake(
        "determinant-plus", "Plus for minus in the determinant",
        "The products of the determinant seem to be added throughout: every other one is subtracted.", "appendix",
        _one("determinant", _plus_only, 2, 3),
    ),
    Mistake(
        "expansion-signs", "Signs of the expansion left out",
        "The minors of the expansion seem to be added throughout: their signs alternate.", "appendix",
        _one("determinant", _first_row_plus, 3, 3),
    ),
    Mistake(
        "diagonal-only", "Product of the diagonal for the determinant",
        "The determinant seems to be the product of the diagonal, which holds for triangular matrices only.",
        "appendix", _one("determinant", _diagonal),
    ),
    Mistake(
        "determinant-sign", "Determinant with the wrong sign",
        "The determinant seems to have the wrong sign: were two rows or columns exchanged?", "appendix",
        _one("determinant", lambda w, found: -found, 1),
    ),
    Mistake(
        "wave-exchanged", "Sine and cosine exchanged in the determinant",
        "Sine and cosine seem to be exchanged in the determinant.", "6.8", _trig_exchanged,
    ),
    Mistake(
        "factor-lost", "Factor of the determinant lost",
        "The determinant seems to lack a factor: {factor}.", "6.8", _factors,
    ),
    Mistake(
        "transpose-for-inverse", "Transpose for the inverse",
        "The transpose of J seems to stand for its inverse. They are the same for rotations, not for a Jacobian.",
        "6.7", _transpose,
    ),
    Mistake(
        "gram-not-inverted", "J J^T not inverted",
        "J J^T seems to be multiplied by and not inverted: the pseudo-inverse holds its inverse.", "6.7", _not_inverted,
    ),
    Mistake(
        "determinant-forgotten", "Division by the determinant forgotten",
        "The division by det J seems to be forgotten.", "appendix", _one("inverse", lambda w, _: w["adjugate"]),
    ),
    Mistake(
        "determinant-multiplied", "Multiplied by the determinant",
        "The adjugate seems to be multiplied by det J: it is to be divided by it.", "appendix",
        _one("inverse", lambda w, _: w["adjugate"] * w["determinant"], 1),
    ),
    Mistake(
        "determinant-squared", "Divided twice by the determinant",
        "The division by det J seems to be done twice.", "appendix", _one("inverse", _divided_by_square, 1),
    ),
    Mistake(
        "adjugate-not-transposed", "Adjugate without the transpose",
        "The cofactors seem to stand where they were worked out: the adjugate is their transpose.", "appendix",
        _one("adjugate", lambda w, _: w["cofactors"]),
    ),
    Mistake(
        "cofactor-signs", "Signs of the cofactors left out",
        "The cofactors seem to lack their signs: every other minor counts negative.", "appendix",
        _minor_signs,
    ),
    Mistake(
        "reciprocal-entries", "Reciprocals of the entries for the inverse",
        "Each entry of J seems to be turned over by itself: the inverse of a matrix is not that.", "appendix",
        _one("inverse", _reciprocals),
    ),
    Mistake(
        "jacobian-for-inverse", "J for its inverse",
        "The rates seem to be J times the velocity: they are J's inverse times it.", "6.7",
        _one("rates", _jacobian_times),
    ),
    Mistake(
        "minor-missing", "Minor missing",
        "By Cauchy and Binet all maximal minors count, each squared. One or more seem to be missing.", "6.8",
        _one_square,
    ),
    Mistake(
        "minors-not-squared", "Minors not squared",
        "The maximal minors seem to be added as they are: by Cauchy and Binet their squares are.", "6.8", _not_squared,
    ),
    Mistake(
        "root-taken", "Root taken", "A square root seems to be taken that is not asked for.", "6.8", _rooted,
    ),
    Mistake(
        "direction-that-moves", "A direction that is not lost",
        "That is the direction in which the arm can still move. The lost one has no part along any column of J.", "6.8",
        _direction_that_moves,
    ),
    Mistake(
        "null-vector-of-jacobian", "Joint rates for a direction of motion",
        "These seem to be joint rates that J takes to zero. A lost direction is a vector u with u J = 0.", "6.8",
        _null_vector_of_j,
    ),
    Mistake(
        "jacobian-for-transpose", "J for its transpose",
        "The torques seem to be J times the load: by virtual work it is the transpose of J.", "dual of 6.4",
        _no_transpose,
    ),
    Mistake(
        "product-sign", "Sign of one product of the determinant",
        "One product of the determinant seems to have the wrong sign: did terms add up that are to cancel?", "appendix",
        _product_signs, rare=True,
    ),
    Mistake(
        "blocks-added", "Determinants of the blocks added",
        "The determinants of the blocks seem to be added: that of a block triangular matrix is their product.",
        "6.8", _blocks_added, rare=True,
    ),
    Mistake(
        "wrist-alone", "Wrist solved with the whole angular velocity",
        "The wrist seems to be solved with the whole angular velocity: what joints 1 to 3 turn is subtracted first.",
        "6.7", _wrist_alone, rare=True,
    ),
    Mistake(
        "sum-squared", "Square of the sum of the minors",
        "The maximal minors seem to be added before they are squared: by Cauchy and Binet each square counts.", "6.8",
        _sum_squared, rare=True,
    ),
    Mistake(
        "square-lost", "Square of a factor lost",
        "The determinant seems to hold a factor once that it holds more than once: {factor}.", "6.8", _square_lost,
        rare=True,
    ),
    Mistake(
        "velocity-sign", "Component of the velocity with the wrong sign",
        "The component {name} of the velocity seems to have the wrong sign.", "6.7", _velocity_sign, rare=True,
    ),
    Mistake(
        "velocity-components-exchanged", "Components of the velocity exchanged",
        "The components of the velocity seem to be exchanged.", "6.7", _velocity_exchanged,
    ),
)  # fmt: skip
