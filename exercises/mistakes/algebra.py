"""Mistakes in results computed from a Jacobian: its determinant, its inverse, rates and torques."""

from collections.abc import Iterator, Sequence
from functools import partial, reduce
from itertools import combinations
from itertools import product as product_of
from operator import mul

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import apply_matrix, cofactor_signs, determinant, matrix_product
from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.derivation import derive, structure
from qdot.exercises.arm.derivation_graph import Change, StageResults, links_to_point, singular_vectors
from qdot.exercises.mistakes.base import (
    AnswerShape,
    MistakeVariant,
    VariantGenerator,
    combine,
    scale_entries,
    variants_if,
)


def _is_square(chain: Chain, min_joints: int = 2, max_joints: int = 6) -> bool:
    return len(chain.task) == chain.n and min_joints <= chain.n <= max_joints


def _is_wide(chain: Chain) -> bool:
    return chain.n > len(chain.task)


def _variants_if_wide(stage: str, *changes: Change) -> VariantGenerator:
    """Return a function that yields one variant per change of a stage, for arms with more joints than rows of J."""
    return combine(*(variants_if(_is_wide, {stage: change}) for change in changes))


def _variants_if_square(stage: str, change: Change, min_joints: int = 2, max_joints: int = 6) -> VariantGenerator:
    return variants_if(partial(_is_square, min_joints=min_joints, max_joints=max_joints), {stage: change})


def _expand_without_signs(w: StageResults, _: np.ndarray) -> np.ndarray:
    """Return the determinant expanded along the first row, with correct 2 x 2 minors but without their signs."""
    return np.asarray((w["jacobian"][0] * w["minors"][0]).sum(axis=0))


def _multiply_diagonal(w: StageResults, _: np.ndarray) -> np.ndarray:
    return np.asarray(reduce(mul, (w["jacobian"][k, k] for k in range(w.n))))


def _factor_determinant(chain: Chain) -> list[tuple[sp.Expr, int]]:
    """Return the factors of this arm's det J with their powers; no factors if J is not square."""
    if not _is_square(chain, 1):
        return []
    values = dict(structure(chain).values)
    return [(factor.xreplace(values), power) for factor, power in derive(chain).generic_minors[0].factors]


def _drop_factor(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    factors = _factor_determinant(chain)
    for factor, _power in factors if len(factors) > 1 else ():
        if not factor.is_number:
            yield _variant_without_factor("determinant", chain, factor, factor)


def _drop_repeated_factor(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants without one of the repeated factors of |det J|, the manipulability."""
    for factor, power in _factor_determinant(chain):
        if power > 1 and not factor.is_number:
            yield _variant_without_factor("manipulability", chain, factor, sp.Abs(factor))


def _exchange_sine_and_cosine(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with sine and cosine exchanged in a factor of the determinant that contains only one of them.

    If the angle contains a constant offset, the factor can be written as a sine or as a cosine. Swapping them can then
    give either sign, so both are yielded.
    """
    offset_by_joint = dict(zip(chain.q, chain.offsets, strict=True))
    for factor, _power in _factor_determinant(chain):
        trig_terms = factor.atoms(sp.sin, sp.cos)
        if len(trig_terms) == 1 and (factor / (trig := trig_terms.pop())).is_number:
            cofunction = (sp.cos if isinstance(trig, sp.sin) else sp.sin)(*trig.args)
            yield MistakeVariant({"determinant": _divide_by(trig / cofunction)})
            if any(offset_by_joint.get(symbol, 0) != 0 for symbol in trig.free_symbols):
                yield MistakeVariant({"determinant": _divide_by(-trig / cofunction)})


def _variant_without_factor(stage: str, chain: Chain, factor: sp.Expr, divisor: sp.Expr) -> MistakeVariant:
    """Return the variant in which `factor` is missing from the result of a stage.

    The result is divided by `divisor`, which is the factor or its absolute value.
    """
    symbols = {str(symbol) for symbol in factor.free_symbols}
    joint_symbols = symbols & set(map(str, chain.q))
    factor_words = "one that depends on the joints" if joint_symbols else "a length"
    return MistakeVariant(
        {stage: _divide_by(divisor)},
        {"factor": factor_words},
        missing_symbols=", ".join(sorted(joint_symbols or symbols)),
    )


def _divide_by(divisor: sp.Expr) -> Change:
    def divide(w: StageResults, correct_value: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.asarray(correct_value / w.arithmetic.drop_derivatives(w.arithmetic.table_entry(divisor)))

    return divide


def _take_reciprocals(w: StageResults, _: np.ndarray) -> np.ndarray:
    jacobian = w["jacobian"]
    with np.errstate(all="ignore"):
        return np.asarray(np.where(jacobian == 0, jacobian, (jacobian * 0 + 1) / np.where(jacobian == 0, 1, jacobian)))


def _divide_again(w: StageResults, correct_value: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.asarray(correct_value / w["determinant"])


def _maximal_minor(w: StageResults, columns: Sequence[int]) -> np.ndarray:
    return np.asarray(determinant(w["jacobian"][:, list(columns)]))


def _add_minors(w: StageResults, sign: int = 1) -> np.ndarray:
    """Return the sum of the maximal minors of J, or their alternating sum if `sign` is -1."""
    column_sets = combinations(range(w.n), len(w.chain.task))
    return np.asarray(sum(sign**k * _maximal_minor(w, columns) for k, columns in enumerate(column_sets)))


def _miscount_minors(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with a wrong sum of the squared maximal minors.

    Only one square is used instead of the sum, or one square is omitted from it.
    """

    def miscount(w: StageResults, gram_determinant: np.ndarray, columns: Sequence[int], is_omitted: bool) -> np.ndarray:
        square = _maximal_minor(w, columns) * _maximal_minor(w, columns)
        return gram_determinant - square if is_omitted else square

    for columns in combinations(range(chain.n), len(chain.task)) if _is_wide(chain) else ():
        for leaves_out in (False, True):
            yield MistakeVariant({"gram determinant": partial(miscount, columns=columns, is_omitted=leaves_out)})


def _flip_product_sign(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    """Yield variants with the sign of one term of the cofactor expansion flipped.

    A term is an entry of J, or one link's contribution to that entry, times the cofactor of the entry.
    """

    def flip(w: StageResults, correct_determinant: np.ndarray, i: int, j: int, link: int | None = None) -> np.ndarray:
        entry = w["jacobian"][i, j] if link is None else w["effects"][j, link, task_rows[i]]
        return np.asarray(correct_determinant - 2 * entry * w["cofactors"][i, j])

    task_rows = [TASK_ROWS.index(row) for row in chain.task]
    for i, j in product_of(range(chain.n), repeat=2) if _is_square(chain, 2, 3) else ():
        yield MistakeVariant({"determinant": partial(flip, i=i, j=j)})
        for link in links_to_point(chain) if task_rows[i] < 3 else ():
            yield MistakeVariant({"determinant": partial(flip, i=i, j=j, link=link)})


def _add_block_determinants(w: StageResults, _: np.ndarray) -> np.ndarray:
    return np.asarray(determinant(w["arm block"]) + determinant(w["wrist block"]))


def _flip_alternate_rates(w: StageResults, motion: np.ndarray) -> np.ndarray:
    return np.asarray(motion * cofactor_signs(w.n)[0][:, None])


def _flip_velocity_sign(chain: Chain, _: AnswerShape) -> Iterator[MistakeVariant]:
    for i, name in enumerate(chain.task):
        yield MistakeVariant({"wanted velocity": scale_entries(i, -1)}, {"name": name})


VARIANTS: dict[str, VariantGenerator] = {
    "determinant-plus": _variants_if_square("determinant", lambda w, _: determinant(w["jacobian"], 1), 2, 3),
    "expansion-signs": _variants_if_square("determinant", _expand_without_signs, 3, 3),
    "diagonal-only": _variants_if_square("determinant", _multiply_diagonal),
    "determinant-sign": _variants_if_square("determinant", lambda w, value: -value, 1),
    "wave-exchanged": _exchange_sine_and_cosine,
    "factor-lost": _drop_factor,
    "transpose-for-inverse": combine(
        _variants_if_square("inverse", lambda w, _: w["transposed jacobian"]),
        _variants_if_wide("pseudo-inverse", lambda w, _: w["transposed jacobian"]),
    ),
    "gram-not-inverted": _variants_if_wide(
        "pseudo-inverse", lambda w, _: matrix_product(w["transposed jacobian"], w["gram matrix"])
    ),
    "determinant-forgotten": _variants_if_square("inverse", lambda w, _: w["adjugate"]),
    "determinant-multiplied": _variants_if_square("inverse", lambda w, _: w["adjugate"] * w["determinant"], 1),
    "determinant-squared": _variants_if_square("inverse", _divide_again, 1),
    "adjugate-not-transposed": _variants_if_square("adjugate", lambda w, _: w["cofactors"]),
    "cofactor-signs": combine(
        _variants_if_square("cofactors", lambda w, _: w["minors"]),
        variants_if(lambda chain: chain.n == len(chain.task) + 1, {"self-motion": _flip_alternate_rates}),
    ),
    "reciprocal-entries": _variants_if_square("inverse", _take_reciprocals),
    "jacobian-for-inverse": _variants_if_square(
        "rates", lambda w, _: apply_matrix(w["jacobian"], w["wanted velocity"])
    ),
    "minor-missing": _miscount_minors,
    "minors-not-squared": _variants_if_wide("gram determinant", lambda w, _: _add_minors(w)),
    "root-taken": _variants_if_wide("gram determinant", lambda w, value: w.arithmetic.sqrt(value)),
    "direction-that-moves": variants_if(
        lambda chain: len(chain.task) == 2, {"lost direction": lambda w, _: singular_vectors(w)[0][:, 0]}
    ),
    "null-vector-of-jacobian": _variants_if_square("lost direction", lambda w, _: singular_vectors(w)[2][-1]),
    "jacobian-for-transpose": _variants_if_square("transposed jacobian", lambda w, _: w["jacobian"]),
    "product-sign": _flip_product_sign,
    "blocks-added": _variants_if_square("determinant", _add_block_determinants, 6),
    "wrist-alone": _variants_if_square("jacobian", scale_entries((slice(3, None), slice(3)), 0), 6),
    "sum-squared": _variants_if_wide(
        "gram determinant", lambda w, _: _add_minors(w) ** 2, lambda w, _: _add_minors(w, -1) ** 2
    ),
    "square-lost": _drop_repeated_factor,
    "velocity-sign": _flip_velocity_sign,
    "velocity-components-exchanged": _variants_if_square("wanted velocity", lambda w, velocity: velocity[::-1], 2, 2),
}
